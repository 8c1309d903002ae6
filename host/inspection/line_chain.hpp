// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "host/inspection/datum_line.hpp"

/// From places to lines. For the sources of this folder only.

namespace sc::host {

/// Strings places on a plane together: each is followed by the next one that lies ahead, along the surface and at most
/// `options.gap` away. Where two faces meet, the corner is put in; what is straight is thinned out. Fills in runs, gaps
/// and lengths. `spacing` is that of the places.
void chain(std::vector<LinePlace> places, const Plane& plane, const CutOptions& options, double spacing, CutLine& out);

}  // namespace sc::host

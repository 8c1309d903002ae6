// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "host/formats/calibration_set.hpp"
#include "host/measurement/correction.hpp"
#include "host/measurement/station.hpp"
#include "host/vision/drawing.hpp"

/// What a station looks like: front view (along the beams: the numbered spots) and top view (from above the reference
/// plane's side: reference and object plane with their angle), with the figures beside them.

namespace sc::host {

/// 900 × 520; host/vision makes SVG and pixels of it.
[[nodiscard]] Drawing station_drawing(const StationResult& result, const Correction* correction);
/// A message in place of figures: a refused station shows no numbers.
[[nodiscard]] Drawing refusal_drawing(const std::string& station, const StationRefusal& refusal);
/// The same as a page that a terminal shows: 78 columns, no control bytes.
[[nodiscard]] std::string station_page(const StationResult& result, const Correction* correction);

/// One line of the running table, and its head.
[[nodiscard]] std::string table_head();
[[nodiscard]] std::string table_row(const StationResult& result, const Correction* correction);

}  // namespace sc::host

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "host/formats/calibration_set.hpp"
#include "host/measurement/correction.hpp"
#include "host/measurement/station.hpp"

/// What a station looks like: front view (along the beams: the numbered spots) and top view (from above the reference
/// plane's side: reference and object plane with their angle), with the figures beside them.

namespace sc::host {

/// SVG of 900 × 520.
[[nodiscard]] std::string station_svg(const StationResult& result, const Correction* correction);
/// The same as a page that a terminal shows: 78 columns, no control bytes.
[[nodiscard]] std::string station_page(const StationResult& result, const Correction* correction);
/// SVG with a message in place of figures: a refused station shows no numbers.
[[nodiscard]] std::string refusal_svg(const std::string& station, const StationRefusal& refusal);

/// One line of the running table, and its head.
[[nodiscard]] std::string table_head();
[[nodiscard]] std::string table_row(const StationResult& result, const Correction* correction);

}  // namespace sc::host

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "host/inspection/inspection.hpp"
#include "host/inspection/uncertainty.hpp"

namespace sc::host {

/// What a report says besides what was measured: "serial number", "operator", files, calibration ids, versions.
using ReportHeader = std::vector<std::pair<std::string, std::string>>;

/// One HTML page without any outside resource: verdict, faces before and after, opposite sides (the paper's Fig. 10),
/// histograms, the proof, worst places, sections along the datum lines, and an allowance map that turns in the browser
/// (warm: more metal than asked; cool: less) and can be shifted there, and the uncertainties. Some 0.9 MB.
[[nodiscard]] std::string inspection_html(const Inspection& inspection, const DistanceField& field,
                                          const ReportHeader& header, const Uncertainty& uncertainty);

}  // namespace sc::host

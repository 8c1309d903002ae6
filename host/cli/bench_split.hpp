// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "host/cli/bench_figures.hpp"

namespace sc::host::cli {

/// The part of bench_laser that has the stage move while it marks: 60 tiles of 50 mm on the simulated cell, with 0.1,
/// 0.3 and 1 s of marking a tile, split between stage and mirrors and once more tile by tile, each in the order that
/// suits it. Figures: split_speedup*, split_limit_violations, split_placement_*; split_off_speedup with the order of
/// the former and the actuator of the latter.
[[nodiscard]] std::vector<Figure> bench_split(const BenchOptions& options);

}  // namespace sc::host::cli

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "host/cli/bench_figures.hpp"

namespace sc::host::cli {

/// The fault campaign, by the programs scribecell-fault-bench (the firmware as it is) and scribecell-fault-mutants
/// (rules of the laser taken out, one at a time). Figures: combinations, violations, mutants, mutants_missed, and the
/// longest times from a fault to the last light, laser_off_*_us. Some minutes. `raw`: faults.csv, one row a
/// combination, those that cannot be with the reason; mutants.csv, one row a rule.
[[nodiscard]] std::vector<Figure> bench_faults(const BenchOptions& options);

}  // namespace sc::host::cli

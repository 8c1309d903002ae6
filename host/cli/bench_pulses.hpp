// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "host/cli/bench_figures.hpp"

namespace sc::host::cli {

/// The part of bench_laser that looks at single pulses: a job of lines, circles, tight turns and corners at 0.1 to 2
/// m/s, burnt by the simulated cell with the nominal head and judged from its pulse trace by host/verification
/// pulse_checker. Figures: pitch_*, placement_*, energy_*; each again with what earns it switched off.
[[nodiscard]] std::vector<Figure> bench_pulses(const BenchOptions& options);

}  // namespace sc::host::cli

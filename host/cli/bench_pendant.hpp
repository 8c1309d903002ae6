// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "host/cli/bench_figures.hpp"

namespace sc::host::cli {

/// A pendant's detents on the simulated cell, each axis and step: detent_cycles, the worst time from a detent to the
/// first set-point that moves, in drive cycles. Counted from the look before the one that found it (1 ms earlier) to
/// when the set-point begins to act, one tick after the step that emitted it. detent_cycles_can: the same over a
/// simulated CAN bus of 1 Mbit/s. `raw`: detents.csv, one row a detent.
[[nodiscard]] std::vector<Figure> detent_figures(const BenchOptions& options);

/// tests/guest with the programs of this build: guest_cases (passed) and guest_cases_failed. Some minutes. Empty, and
/// said on stderr, where the guest cannot be had.
[[nodiscard]] std::vector<Figure> guest_figures(const BenchOptions& options);

}  // namespace sc::host::cli

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "host/cli/bench_figures.hpp"
#include "shared/machine/galvo_field.hpp"
#include "shared/machine/galvo_lag.hpp"
#include "shared/path/item.hpp"
#include "shared/trace/trace.hpp"

namespace sc::host::cli {

/// The part of bench_laser that looks at single pulses: a job of lines, circles, tight turns and corners at 0.1 to 2
/// m/s, burnt by the simulated cell with the nominal head and judged from its pulse trace by host/verification
/// pulse_checker. Figures: pitch_*, placement_*, energy_*; each again with what earns it switched off.
[[nodiscard]] std::vector<Figure> bench_pulses(const BenchOptions& options);

/// The same job with mirrors that follow otherwise than the controller's configuration states, one world after the
/// other of boards/sim/world/beam/lag: before and after `scribecell calibrate galvo-lag`. Figures:
/// placement_mismatched_*. `raw`: lag.csv, a row a world.
[[nodiscard]] std::vector<Figure> bench_lag(const BenchOptions& options);

/// Lines by the axes while a swinging force pushes them off by 50 µm at 20 Hz, with mirrors that take it up and with
/// mirrors that do not: what share of the beam's error on the workpiece is gone. Figures: following_error_*. `raw`:
/// follow.csv.
[[nodiscard]] std::vector<Figure> bench_follow(const BenchOptions& options);

/// The job that the pulses are judged on.
struct PulseWorkload {
    std::vector<Item> items;
    /// Paths of lines. Curves are followed within their tolerance, and their pulses are equally far apart along what is
    /// followed: where each is along the curve as it was drawn is not defined to a micrometre.
    std::vector<std::uint32_t> straight;
};
[[nodiscard]] PulseWorkload pulse_workload();

/// A simulated cell for it.
struct PulseCell {
    std::filesystem::path world;
    std::vector<std::string> machine{};  ///< settings of its controller beside 18-bit words
    double prr_hz = 40e3;
    GalvoLag lag{};  ///< that the controller is told; empty: what its configuration states
    std::uint64_t seed = 1;
};
/// A world of boards/sim/world/beam. Throws CellError when the project's folder is not there.
[[nodiscard]] std::filesystem::path beam_world(const std::string& name);
/// Field correction of the nominal head, which those worlds have.
[[nodiscard]] GalvoField nominal_field();
/// Pulses of the job with that correction in force. Throws what Session throws.
[[nodiscard]] std::vector<trace::PulseRecord> burn_pulses(const std::vector<Item>& items, const PulseCell& cell,
                                                          const std::filesystem::path& folder);

}  // namespace sc::host::cli

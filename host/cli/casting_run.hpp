// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "host/cli/scribe_run.hpp"
#include "host/inspection/inspection.hpp"
#include "host/path/line_job.hpp"

namespace sc::host::cli {

struct CastingOptions {
    std::uint64_t seed = 1;
    std::string board = "sim";
    bool plain = false;  ///< faces as they are given and nothing kept from edges: what the care in BeamReach is worth
    std::function<void(const std::string&)> say = [](const std::string&) {};
};

/// Distances of all pulses from the true datum planes, metres, rising, and how many met nothing.
struct Burnt {
    std::vector<double> off;
    std::size_t missed = 0;
    struct Worst {
        double off = 0.0;
        std::string datum;
        Vec3 place;  ///< in w of the blank as it was scanned and moved
    };
    std::vector<Worst> worst;  ///< of each stretch, the farthest first
    [[nodiscard]] double share(double part) const {
        const auto last = static_cast<double>(off.size() - 1);
        return off.empty() ? 0.0 : off[static_cast<std::size_t>(std::lround(part * last))];
    }
};
struct CastingRun {
    Inspection inspection;
    LineJob lines;
    ScribeOutcome scribed;
    Burnt burnt;  ///< when the cell did not fail
    std::size_t views = 0;
    double inspect_seconds = 0.0;  ///< of this computer
    double burn_seconds = 0.0;     ///< of the cell's time
};

/// From a casting at the pose of the seed to its datum lines, burnt and measured, on the simulated cell. All files go
/// to `folder`. Some 5 s. Throws InputError and CellError; how the job itself failed is in `scribed`.
[[nodiscard]] CastingRun run_casting(const std::filesystem::path& folder, const CastingOptions& options);

}  // namespace sc::host::cli

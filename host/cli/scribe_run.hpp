// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>

#include <nlohmann/json.hpp>

#include "host/bridge/session.hpp"
#include "host/cli/failure.hpp"
#include "host/cli/scribe_input.hpp"
#include "host/verification/report.hpp"

namespace sc::host::cli {

/// What became of a job.
struct ScribeOutcome {
    JobPlan plan;
    std::string job_name;
    MachineConfig machine;
    std::string state;  ///< of the cell at the end
    JobProgress progress;
    std::optional<std::string> journal;
    double cell_seconds = 0.0;
    double wall_seconds = 0.0;
    std::optional<nlohmann::ordered_json> cell;  ///< the simulated cell's own account of its end
    std::optional<Report> report;                ///< when the job is done and its traces are at hand
    std::optional<Failure> failure;              ///< of cell or job; bad input is thrown
    bool dry_run = false;
    std::optional<PreviewResult> preview;  ///< nothing was burnt

    [[nodiscard]] int exit_code() const;
};

/// The whole of `scribecell scribe` but for printing its result: reads, connects, plans, burns, finds again what was
/// burnt. Progress goes to stderr. Throws InputError before anything has moved; what goes wrong afterwards is in the
/// outcome.
[[nodiscard]] ScribeOutcome run_scribe(const ScribeOptions& options);

}  // namespace sc::host::cli

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "host/bridge/open_transport.hpp"
#include "host/cli/pendant_options.hpp"
#include "host/formats/calibration_set.hpp"
#include "host/formats/job.hpp"
#include "host/formats/table.hpp"
#include "host/path/job_plan.hpp"
#include "shared/link/messages.hpp"

namespace sc::host::cli {

/// What `scribecell scribe` was asked for.
struct ScribeOptions {
    std::filesystem::path job;  ///< empty: the example
    std::optional<std::filesystem::path> table;
    std::optional<std::filesystem::path> calibration;
    std::vector<double> faces;  ///< empty: all
    std::string link = "sim:";
    LinkOptions link_options;  ///< world, out, script, jitter, seed
    std::optional<std::filesystem::path> svg;
    std::optional<std::filesystem::path> journal;
    std::uint32_t points_per_block = 0;
    PendantWords pendant{};               ///< beside the terminal's keys
    std::optional<int> override_percent;  ///< none: as it stands in the cell
    bool dry_run = false;
    bool preview = false;                 ///< trace with the guide laser, burn nothing
    std::optional<std::uint32_t> rounds;  ///< of the preview; none: until it is stopped, in the simulated cell once
    bool json = false;
    bool reset_fault = false;
    bool accept_expired = false;           ///< a calibration that has expired is warned of, not refused
    bool resume = false;                   ///< go on with the journal's job
    std::optional<std::string> confirmed;  ///< what a person has found of an uncertain stretch
};

/// The files of a job, read and checked.
struct ScribeInput {
    Job job;  ///< with the faces asked for alone
    CalibrationSet calibration;
    std::filesystem::path table_file;
    bool points_from_table = false;
};

/// Reads what the options name. Throws InputError; nothing has been started.
[[nodiscard]] ScribeInput read_input(const ScribeOptions& options);

/// A job planned for one machine.
struct Planned {
    VerificationTable table;
    JobPlan plan;
};
/// Throws InputError for anything that the machine cannot do.
[[nodiscard]] Planned plan_for(const ScribeInput& input, const MachineConfig& machine);

/// What the cell is told of the job's use of its distance sensors.
[[nodiscard]] link::SetSurface surface_of(const Job& job, const CalibrationSet& calibration);
[[nodiscard]] link::CheckSeating seating_of(const SeatingSettings& seating);

/// "the horizontal stroke of the cross at marker 5, face 90 (points.csv line 6)": what an item of the stream is for.
[[nodiscard]] std::string describe_item(const JobPlan& plan, std::size_t item);

}  // namespace sc::host::cli

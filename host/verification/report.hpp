// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "host/verification/accuracy.hpp"
#include "host/verification/path_follower.hpp"
#include "host/verification/sample_checker.hpp"

/// The accuracy report for a person (text, SVG) and for a program (JSON). All three say the same; lengths in mm unless
/// the name says otherwise. Pure: the caller writes the files.

namespace sc::host {

/// What the report tells of the run besides its accuracy.
struct RunFacts {
    std::string job;           ///< its name
    std::string job_hash;      ///< hex
    std::string state;         ///< of the cell at the end: "armed", "held", "fault", ...
    std::uint64_t pulses = 0;  ///< fired, as the cell counts them
    double cell_seconds = 0.0;
    double wall_seconds = 0.0;
    std::string command_trace_sha256;
};

struct Report {
    AccuracyReport accuracy;
    BurnFindings burns;
    SampleReport samples;
    RunFacts run;
    std::vector<PathAccuracy> paths{};  ///< free paths, in the order of the plan

    /// All that was planned was found, and nothing else.
    [[nodiscard]] bool complete() const;
};

/// A table like the paper's Table 1 for each face (found in place of measured), with max and rms, those of the table
/// alone and those foretold with the world's errors; then what was burnt, the datum lines, the errors, the times.
[[nodiscard]] std::string report_text(const Report& report);

/// One object: format, version, state, job, complete, faces[], max_command_error_um, known_errors[], found_errors{},
/// datum_lines[], paths[], burnt{}, pulses, limit_violations, violations[], motion_peaks{}, cell_seconds, wall_seconds,
/// command_trace_sha256. docs/formats.md lists the keys.
[[nodiscard]] nlohmann::ordered_json report_json(const Report& report);

/// A self-contained picture, one panel a face: what was burnt to scale, the markers' numbers, and the deviation of each
/// cross in x and z as an arrow 1000 times its length.
[[nodiscard]] std::string report_svg(const Report& report);

}  // namespace sc::host

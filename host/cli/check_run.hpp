// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <CLI/CLI.hpp>

#include "host/verification/motion_checker.hpp"
#include "host/verification/motion_trace.hpp"

/// What `check` and `plot` share: their options, and the judgement of a trace.

namespace sc::host::cli {

struct CheckOptions {
    std::filesystem::path trace;
    std::optional<std::filesystem::path> path;  ///< polyline that the motion was to follow
    double tolerance_mm = 0.01;
    std::optional<double> vertex_tolerance_mm;  ///< default: √2 · tolerance
    bool may_return = false;
    std::optional<std::string> limits;    ///< "v,a,j" of X, Y, Z: m/s, m/s², m/s³
    std::optional<std::string> c_limits;  ///< "v,a,j" of C: degrees
    std::optional<double> path_speed;     ///< m/s
    std::optional<std::string> travel;    ///< "x0,x1,y0,y1,z0,z1", metres
    std::vector<std::string> keep_out;    ///< "x0,y0,z0,x1,y1,z1", metres, each
    std::optional<std::string> ticks;     ///< "FROM:TO"
    double allow = kMotionAllow;
    std::optional<std::filesystem::path> pulses;  ///< default: pulses.trace beside the trace, if job.items is there too
    std::optional<std::filesystem::path> items;   ///< default: job.items beside the pulses
    double pitch_pct = 3.0;
    double energy_pct = 2.0;
    double pulse_energy_pct = 15.0;
    bool json = false;
};

/// Adds the options to a subcommand; they stay bound to `options`.
void describe_check(CLI::App& app, CheckOptions& options);

struct CheckOutcome {
    MotionTrace trace;  ///< of a stretch: cut to it
    MotionLimits limits;
    MotionReport report;
};

/// Reads and judges. A cell's whole trace is judged with its states, mirrors and machine (SampleChecker); a CSV, or a
/// stretch of ticks of either, as one motion from rest to rest (check_motion). Throws InputError.
[[nodiscard]] CheckOutcome run_check(const CheckOptions& options);

}  // namespace sc::host::cli

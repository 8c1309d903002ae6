// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include <nlohmann/json_fwd.hpp>

#include "host/verification/motion_checker.hpp"
#include "host/verification/sample_checker.hpp"

/// The judgement of a motion for a person and for a program. Pure.

namespace sc::host {

/// What `SampleChecker` found, in the form of one motion: rows of four axes and two mirrors.
[[nodiscard]] MotionReport motion_report_of(const SampleReport& samples, const MachineConfig& machine, double allow);

/// A table of the worst ratios, then deviation, what is broken (the first 20 places) and the verdict.
[[nodiscard]] std::string motion_text(const MotionReport& report);

/// "passed: every limit is kept" or "BROKEN: 3 violations".
[[nodiscard]] std::string motion_verdict(const MotionReport& report);

/// One object; docs/formats.md lists the keys.
[[nodiscard]] nlohmann::ordered_json motion_json(const MotionReport& report);

/// "tick 12: jerk of x 202 m/s3, limit 200"
[[nodiscard]] std::string violation_text(const Violation& violation);

}  // namespace sc::host

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "boards/drive_check/drive_client.hpp"

namespace sc::drive_check {

enum class Verdict : std::uint8_t { passed, failed, left_out };

struct Result {
    Verdict verdict = Verdict::passed;
    std::string text;  ///< why not passed
};

/// One thing that a CiA 301/402 drive must do. Each begins with a reset of the node and does not care what was before.
struct Case {
    std::string group;
    std::string name;
    bool moves = false;  ///< the axis moves by more than a few counts
    std::function<Result(DriveClient&)> run;
};

[[nodiscard]] std::vector<Case> communication_cases();  ///< NMT, heartbeat, SDO, PDO, SYNC, EMCY
[[nodiscard]] std::vector<Case> power_cases();          ///< state machine, faults, CSP, homing
/// Both.
[[nodiscard]] std::vector<Case> all_cases();

[[nodiscard]] inline Result passed() { return {}; }
[[nodiscard]] inline Result failed(std::string text) { return {Verdict::failed, std::move(text)}; }
[[nodiscard]] inline Result left_out(std::string text) { return {Verdict::left_out, std::move(text)}; }
[[nodiscard]] inline Result expect(bool holds, const std::string& text) { return holds ? passed() : failed(text); }
[[nodiscard]] std::string hex(std::uint32_t value);

}  // namespace sc::drive_check

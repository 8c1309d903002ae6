// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "boards/event_device/event_link.hpp"
#include "boards/linux_rt/runner.hpp"

namespace sc::linux_rt {

/// What a run has measured so far. The counters may be those of a tick that is under way.
struct RunFigures {
    const Runner* runner = nullptr;
    const ControlLoop* loop = nullptr;
    const DriveBus* drives = nullptr;
    const HostLink* link = nullptr;
    const event_device::EventLink* events = nullptr;  ///< may be null
};

/// One JSON object on one line.
[[nodiscard]] std::string to_json(const RunFigures& figures);
/// For a person.
[[nodiscard]] std::string to_text(const RunFigures& figures);

}  // namespace sc::linux_rt

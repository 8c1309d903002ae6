// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include <nlohmann/json_fwd.hpp>

#include "host/bridge/client.hpp"
#include "shared/machine/machine.hpp"

namespace sc::host::cli {

/// A cell's last status, for a person (several lines) and for a program.
[[nodiscard]] std::string status_text(const link::Status& status, const WireCounters& wire);
[[nodiscard]] nlohmann::ordered_json status_json(const link::Status& status, const WireCounters& wire);
/// The machine's configuration: travel, limits, galvo, laser, keep-out volumes.
[[nodiscard]] std::string machine_text(const MachineConfig& machine);
[[nodiscard]] nlohmann::ordered_json machine_json(const MachineConfig& machine);

}  // namespace sc::host::cli

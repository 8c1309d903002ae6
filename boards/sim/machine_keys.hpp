// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "shared/machine/machine.hpp"

namespace sc::sim {

/// Changes what the controller is told of its machine, not what the plant is; each setting is KEY=VALUE. Keys:
/// galvo.word (16, 18), galvo.latency_us, galvo.natural_frequency_hz (0: unknown), galvo.damping, laser.power_byte
/// (average, energy). Throws std::invalid_argument with the keys for any other, for a value that is none, and for a
/// machine that no controller can run with.
void set_machine(MachineConfig& machine, const std::vector<std::string>& settings);

}  // namespace sc::sim

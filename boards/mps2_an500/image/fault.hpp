// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "boards/mps2_an500/shared_ram.hpp"

namespace sc::mps2_an500 {

/// Writes the fault record, leaves outputs that are safe (none at all: the PC keeps the laser shut without a tick's
/// outputs) and stops the core for good. Any context.
[[noreturn]] void halt(const FaultRecord& record) noexcept;

}  // namespace sc::mps2_an500

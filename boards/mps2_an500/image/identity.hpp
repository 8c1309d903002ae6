// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "boards/mps2_an500/shared_ram.hpp"

namespace sc::mps2_an500 {

/// Writes what the PC checks before it asks for anything: magic, layout, schema, build, sizes.
void write_identity(SharedRam& ram) noexcept;

}  // namespace sc::mps2_an500

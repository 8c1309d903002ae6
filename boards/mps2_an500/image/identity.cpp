// SPDX-License-Identifier: Apache-2.0
#include "boards/mps2_an500/image/identity.hpp"

#include "boards/mps2_an500/build_id.hpp"
#include "boards/mps2_an500/image/stack.hpp"
#include "firmware/controller/controller.hpp"
#include "shared/link/schema.hpp"

namespace sc::mps2_an500 {

namespace {

/// Volatile, so that the number stands in the image in one piece.
const volatile std::uint64_t build_id = kBuildId;

}  // namespace

void write_identity(SharedRam& ram) noexcept {
    ram.core_magic = kCoreMagic;
    ram.core_layout_version = kLayoutVersion;
    ram.schema_hash = link::kSchemaHash;
    ram.build_id = build_id;
    ram.controller_bytes = sizeof(Controller);
    ram.stack_size = stack_size();
}

}  // namespace sc::mps2_an500

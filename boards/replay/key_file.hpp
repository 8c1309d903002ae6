// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

#include "firmware/link/seal_gate.hpp"

namespace sc::replay {

/// The cell's key: a file of 32 hex digits that only its owner may read. Throws std::invalid_argument that names file
/// and problem; the digits are never shown.
[[nodiscard]] crypto::Key read_key_file(const std::filesystem::path& file);

/// With random bytes of the system, as a board would have them from its own source. Throws std::system_error.
[[nodiscard]] link::SealSecret secret_of(const crypto::Key& key);

}  // namespace sc::replay

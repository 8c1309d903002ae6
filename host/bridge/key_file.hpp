// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <string>

#include "shared/crypto/aes128.hpp"

namespace sc::host {

/// The key of a cell, as a file: 32 hex digits, the first byte first, and a line's end. Nobody but its owner may read
/// it. Throws InputError that names file, line and what is wrong; the digits themselves are never shown.
[[nodiscard]] crypto::Key read_key_file(const std::filesystem::path& file);

/// A new key from the system's random numbers, into a file that only its owner may read. Throws InputError if the file
/// is there already, std::system_error if the system refuses; nothing is left half written.
crypto::Key make_key_file(const std::filesystem::path& file);

/// Random bytes of the system. Throws std::system_error.
[[nodiscard]] std::array<std::uint8_t, 16> random_bytes();

/// Eight hex digits that tell two keys apart and say nothing else of them.
[[nodiscard]] std::string key_check_text(const crypto::Key& key);

}  // namespace sc::host

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "shared/machine/axis_map.hpp"

/// The axis map as bytes, as MapChunk carries it: u16 version, then every field of AxisMap in the order of its
/// declaration, little-endian. The size is fixed.

namespace sc::link {

inline constexpr std::uint16_t kMapVersion = 1;
inline constexpr std::size_t kMapSize =
    2 + 6 * 8 + 9 * kMapCoefficients * 4 + kTurnTables * kTurnNodes * 4 + 3 * 8 + kAxisCount * 4 + kAxisCount * 8;
using MapBytes = std::array<std::uint8_t, kMapSize>;

/// No heap, any context, one pass.
void serialise(const AxisMap& map, std::span<std::uint8_t, kMapSize> out) noexcept;
/// False for a wrong size or another version. The map has not been judged (check_map).
[[nodiscard]] bool deserialise_map(std::span<const std::uint8_t> bytes, AxisMap& map) noexcept;
/// CRC-32 of the bytes; 0 for the identity, which is never sent. What names a map in a status.
[[nodiscard]] std::uint32_t map_crc(const AxisMap& map) noexcept;

}  // namespace sc::link

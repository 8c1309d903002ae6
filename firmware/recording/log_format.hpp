// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "shared/link/config.hpp"
#include "shared/machine/machine.hpp"

/// The log of a controller's inputs: a magic, then chunks. docs/formats.md has the layout.

namespace sc::recording {

inline constexpr std::array<std::uint8_t, 8> kLogMagic{'S', 'C', 'I', 'N', 'P', 'T', '0', '1'};
inline constexpr std::uint16_t kLogVersion = 5;
inline constexpr std::size_t kBuildIdSize = 48;

/// What is needed to build the same controller again.
struct LogHeader {
    MachineConfig machine{};
    std::uint32_t boot_id = 0;
    std::uint32_t plan_units = 0;               ///< units of plan_step after each servo_step
    std::array<char, kBuildIdSize> build_id{};  ///< of the program that recorded, text, filled up with zeros
    bool sealed = false;                        ///< the controller had a key, which is not in the log
    std::uint32_t key_check = 0;                ///< of that key (shared/link/seal.hpp)
    std::array<std::uint8_t, 16> entropy{};     ///< that its challenges were made from
};

enum class ChunkKind : std::uint8_t { header = 1, ticks = 2, end = 3 };

/// Why a log ends, as its last chunk says.
enum class EndReason : std::uint8_t {
    closed = 1,  ///< the recorder was asked to end
    full = 2,    ///< the limit of its size was reached; the cell went on
};

/// In front of each chunk; its own CRC-32 is its last four bytes. After the payload follows a CRC-32 over both.
struct ChunkHead {
    ChunkKind kind = ChunkKind::header;
    std::uint32_t number = 0;        ///< 0, 1, 2, ... in the file
    std::uint32_t payload_size = 0;  ///< bytes
    std::int64_t first_tick = 0;     ///< of the chunk; in the end chunk: the tick after the last
    std::uint32_t ticks = 0;         ///< in the chunk; in the end chunk: 0
};
inline constexpr std::array<std::uint8_t, 4> kChunkMark{'S', 'C', 'R', 'C'};
inline constexpr std::size_t kChunkHeadSize = 4 + 4 + 4 + 4 + 8 + 4 + 4;
inline constexpr std::size_t kChunkTailSize = 4;

inline constexpr std::size_t kHeaderPayloadSize = 2 + 2 + 4 + 4 + kBuildIdSize + 4 + 16 + link::kConfigSize;
inline constexpr std::size_t kEndPayloadSize = 1 + 8;
/// Bytes of the magic and the header chunk.
inline constexpr std::size_t kLogHeadSize = kLogMagic.size() + kChunkHeadSize + kHeaderPayloadSize + kChunkTailSize;
/// Bytes of the last chunk.
inline constexpr std::size_t kLogEndSize = kChunkHeadSize + kEndPayloadSize + kChunkTailSize;

}  // namespace sc::recording

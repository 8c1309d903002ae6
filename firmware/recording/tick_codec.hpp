// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "firmware/recording/digest.hpp"
#include "firmware/recording/io_image.hpp"
#include "shared/wire/bytes.hpp"

/// One tick of a log: the inputs as what has changed since the tick before, and the digest of the outputs.
/// docs/formats.md has the layout. No heap; any context.

namespace sc::recording {

/// Most bytes that one tick can take.
inline constexpr std::size_t kTickCapacity =
    2 + 8 + 5 + 2 + kLinkBytesPerTick + 1 + 3 + kDriveFramesPerTick * (4 + 1 + kDriveFrameBytes) + 1 +
    kSourceBytesPerTick + kEncoderBytes + kSensorBuses * (1 + kSensorBytesPerTick * (1 + 1 + 3)) + 1 + 8 + 4 + 1 +
    kOutputParts;

/// What both ends remember from tick to tick. Fresh at the start of each chunk.
struct TickMemory {
    static constexpr std::size_t kSlots = 64;

    std::int64_t tick = 0;  ///< expected next
    DigitalInputs digital;
    std::uint16_t galvo_status = 0;
    std::uint8_t guard_causes = 0;
    OutputsDigest digest;
    /// Checks that the next tick is expected to have: of the drives those of the tick before the last, because SYNC
    /// goes out every second tick of the reference cell; of all else those of the last.
    std::array<std::uint8_t, kOutputParts> expected{};
    std::array<DriveFrame, kSlots> frames{};  ///< the last of each CAN id
    std::size_t frame_count = 0;
    std::array<std::uint8_t, kDriveFramesPerTick> list{};  ///< slots of the last tick that had frames
    std::size_t list_size = 0;
};

/// False if it does not fit (kTickCapacity always does) or the inputs hold more than a tick may; `memory` and `out` are
/// then of no use any more.
[[nodiscard]] bool encode(const ServoInputs& inputs, const OutputsDigest& digest, TickMemory& memory,
                          ByteWriter& out) noexcept;
/// False, with everything unspecified, if the bytes are no tick.
[[nodiscard]] bool decode(ByteReader& in, TickMemory& memory, StoredInputs& stored, OutputsDigest& digest) noexcept;

}  // namespace sc::recording

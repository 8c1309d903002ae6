// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "firmware/recording/io_image.hpp"

namespace sc::recording {

/// What a log keeps of a tick's outputs: enough to say that they were others, in which part, and what state the cell
/// was in.
struct OutputsDigest {
    std::uint32_t crc = 0;                           ///< CRC-32 over the CRC-32s of the parts, in their order
    std::array<std::uint8_t, kOutputParts> check{};  ///< lowest byte of each part's CRC-32
    std::uint8_t state = 0;                          ///< State
    std::uint64_t faults = 0;                        ///< bits by Fault
    bool operator==(const OutputsDigest&) const noexcept = default;
};

/// Makes digests. One pass over the packed outputs: some 100 bytes in a dark tick, 2.5 kB while the mirrors move.
/// Holds a buffer of 34 kB: static storage.
class OutputsDigester {
public:
    [[nodiscard]] OutputsDigest digest(const ServoOutputs& outputs) noexcept;
    /// The packed outputs of the last digest; valid until the next.
    [[nodiscard]] std::span<const std::uint8_t> image() const noexcept { return std::span(image_).first(size_); }

private:
    std::array<std::uint8_t, kOutputsImageCapacity> image_{};
    std::size_t size_ = 0;
};

}  // namespace sc::recording

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

/// The head's status line: SPI3 as a slave, PC10 wired to the galvo's clock (PE2), PC12 to the status line. 20 bits a
/// frame, most significant first, taken with the rising clock; of them 16 are the status word, before the last. DMA1's
/// stream 1 keeps the newest frames.
///
/// Nothing marks a frame's begin: words are counted from the first clock on. A bit too much or too few turns every word
/// that follows, and none of those reads as healthy.

namespace sc::stm32h743 {

inline constexpr std::size_t kStatusWords = 32;

/// Lies where DMA1 reaches and nothing caches: SRAM1.
struct alignas(32) StatusBuffer {
    std::array<std::uint32_t, kStatusWords> words;
};

class GalvoStatus {
public:
    explicit GalvoStatus(StatusBuffer& buffer) noexcept : buffer_(buffer) {}
    /// Before the galvo's clock begins. False: the stream does not stop or does not run, or a setting did not stay.
    [[nodiscard]] bool start() noexcept;
    /// The status word of the newest frame (kGalvoStatusOk when all is well); 0 when no frame has come since the last
    /// call, or one was lost. At 3.2 kHz or more; some six accesses.
    [[nodiscard]] std::uint16_t word() noexcept;
    /// Words that were lost. Monotonic.
    [[nodiscard]] std::uint32_t overruns() const noexcept { return overruns_; }

private:
    StatusBuffer& buffer_;
    std::size_t seen_ = 0;
    std::uint32_t overruns_ = 0;
};

}  // namespace sc::stm32h743

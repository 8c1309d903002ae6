// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <span>

#include "firmware/hal/io.hpp"

/// XY2-100 of two mirrors on PE2 (clock), PE3 (sync), PE4 (x), PE5 (z): TIM6 asks for a word 4 000 000 times a second,
/// stream 0 of DMA1 writes it to the port's set/reset register. 20 clocks of 2 MHz a frame, 100 frames a millisecond.
/// All lines change with the rising clock, a head samples with the falling one; sync is low for the parity bit.
///
/// Two buffers of 1 ms are with the DMA, a third is filled and put in the place of the one that was played. A tick
/// begins with the DMA's swap, at which `swapped` is called; the frames filled in it leave with the next one, the first
/// rising clock 250 ns behind the swap. Timer clock 240 MHz (reference manual: DMA, double-buffer mode).

namespace sc::stm32h743 {

inline constexpr std::size_t kGalvoBits = 20;
inline constexpr std::size_t kGalvoBufferWords = kGalvoFramesPerTick * kGalvoBits * 2;

/// 48 000 bytes. Lies where DMA1 reaches and nothing caches: SRAM1.
struct alignas(32) GalvoBuffers {
    std::array<std::array<std::uint32_t, kGalvoBufferWords>, 3> words;
};

/// One object. `fill` in the tick, `check` in the guard's context, `swapped` in the DMA's interrupt; either of the
/// latter may break into what stands before it.
class GalvoWave {
public:
    /// A buffer must be filled so long before its swap: more than a period of the guard (100 µs).
    static constexpr std::int64_t kDeadlineNs = 150'000;
    static constexpr std::int64_t kWordNs = 250;

    explicit GalvoWave(GalvoBuffers& buffers) noexcept : buffers_(buffers) {}

    /// Sends this frame from now on, until frames are filled. 13 000 stores. False: the DMA stream does not stop, or
    /// does not run.
    [[nodiscard]] bool start(std::uint32_t word_x, std::uint32_t word_z) noexcept;

    /// The frames of the window that begins with the next swap, once a tick: 2 000 words, some 16 000 instructions.
    /// False: too late, or filled already; nothing is sent of them.
    [[nodiscard]] bool fill(std::span<const GalvoFrame, kGalvoFramesPerTick> frames) noexcept;

    /// At 10 kHz or more. False when the next buffer was not filled in time: it then repeats the last frame (2 000
    /// words, some 6 000 instructions, at most once a tick), and the gate must be shut before the swap. False until
    /// a swap to frames that were filled.
    [[nodiscard]] bool check() noexcept;

    /// The stream's interrupt. False: the stream has failed, or what plays now was neither filled nor repeated, since
    /// `check` was not called; the gate must be shut.
    [[nodiscard]] bool swapped() noexcept;

    /// Windows without frames of their own. Monotonic.
    [[nodiscard]] std::uint32_t underruns() const noexcept { return underruns_; }
    /// Transfer errors and swaps that were missed. Monotonic.
    [[nodiscard]] std::uint32_t errors() const noexcept { return errors_; }

private:
    enum class Next : std::uint8_t { open, filled, repeats };
    struct Words {
        std::uint32_t x = 0;
        std::uint32_t z = 0;
    };
    [[nodiscard]] static unsigned playing() noexcept;
    void put(std::size_t buffer, std::size_t frame, Words words) noexcept;
    void repeat(std::size_t buffer, Words words) noexcept;

    GalvoBuffers& buffers_;
    std::array<Words, 3> last_{};                ///< frame at the end of each buffer
    std::array<std::size_t, 2> with_dma_{0, 1};  ///< buffers at the stream's two addresses
    std::size_t free_ = 2;                       ///< the third
    std::atomic<Next> next_{Next::open};         ///< what the buffer that comes next holds
    std::atomic<std::uint32_t> turn_{0};         ///< swaps
    unsigned played_ = 0;                        ///< address that was played at the last swap
    std::atomic<bool> shut_{true};               ///< no filled frames play
    std::uint32_t underruns_ = 0;
    std::uint32_t errors_ = 0;
};

}  // namespace sc::stm32h743

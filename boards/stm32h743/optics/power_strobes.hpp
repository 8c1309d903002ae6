// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "boards/stm32h743/io/control_clock.hpp"
#include "firmware/hal/io.hpp"

/// The power byte on PF0 to PF7 and its latch on PF8. Each change of the lines is an event at a count of TIM5: compare
/// 1 asks stream 1 of DMA2 for the word that changes the port, compare 2 asks stream 2 for both compare values of the
/// next event. No processor between; a line moves some 100 ns after its count.
///
/// A stream reads a word ahead of the request that moves it (reference manual, DMA, direct mode). So the ring never
/// runs to its end: where no strobe is, events that change nothing follow one another each 100 us.

namespace sc::stm32h743 {

inline constexpr std::size_t kStrobeEvents = 2'048;  ///< two windows; each has 3 · (kLaserRunsPerTick + 1) + 10 at most

/// Lies where DMA2 reaches and nothing caches: SRAM2.
struct alignas(32) PowerBuffers {
    std::array<std::uint32_t, kStrobeEvents> words;                   ///< for the port
    std::array<std::array<std::uint32_t, 2>, kStrobeEvents> compare;  ///< counts of the two compares
};

/// One object, tick context. The clock runs before it starts.
class PowerStrobes {
public:
    PowerStrobes(PowerBuffers& buffers, const ControlClock& clock, const LaserConfig& laser) noexcept
        : buffers_(buffers), clock_(clock), setup_ns_(laser.latch_setup_ns), width_ns_(laser.latch_width_ns) {}

    /// The byte 0 on the lines, the latch low, and nothing until `until_ns`, the end of a window that is not over for
    /// the next 0.5 ms. False: a stream does not stop, or does not run.
    [[nodiscard]] bool start(std::int64_t until_ns) noexcept;
    /// Strobes of the window that begins where the last one ended, once a tick, whether or not there are any, 250 us
    /// before it begins: those of `runs`, and with `clear` the byte 0 at its begin unless it is in force. False: a
    /// strobe would fall into the one before, or there is no room or no time; then none leaves until `cancel`. Up to
    /// 541 events of some 60 instructions.
    [[nodiscard]] bool fill(std::span<const LaserRun> runs, bool clear) noexcept;
    /// Nothing that was filled leaves any more: the latch falls, the lines stay as they are, and which byte the source
    /// has is not known.
    void cancel() noexcept;
    /// Windows that could not be filled. Monotonic.
    [[nodiscard]] std::uint32_t refused() const noexcept { return refused_; }

private:
    static constexpr std::int32_t kUnknown = -1;

    [[nodiscard]] bool restart() noexcept;
    [[nodiscard]] bool lay_window(std::span<const LaserRun> runs, bool clear) noexcept;
    [[nodiscard]] bool strobe(std::int64_t rise_ns, std::uint8_t byte) noexcept;
    [[nodiscard]] bool put(std::int64_t ns, std::uint32_t word) noexcept;
    [[nodiscard]] bool idle_until(std::int64_t ns) noexcept;
    /// Events whose compare values have been loaded, in the ring.
    [[nodiscard]] static std::uint32_t loaded() noexcept;
    [[nodiscard]] std::uint32_t waiting() const noexcept;

    PowerBuffers& buffers_;
    const ControlClock& clock_;
    std::int64_t setup_ns_;
    std::int64_t width_ns_;
    std::uint32_t end_ = 0;         ///< of what is laid out, in the ring
    std::int64_t last_ns_ = 0;      ///< time of the last event
    std::int64_t window_ns_ = 0;    ///< begin of the window that is filled next
    std::int32_t byte_ = kUnknown;  ///< after all that is laid out
    bool runs_ = false;
    std::uint32_t refused_ = 0;
};

}  // namespace sc::stm32h743

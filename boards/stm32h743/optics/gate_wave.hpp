// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <span>

#include "boards/stm32h743/optics/pulse_segments.hpp"

/// Gate (PE9) and trigger (PE13) of the laser by TIM1 at 240 MHz: one segment of pulse_segments.hpp after the other, no
/// processor between. Each update asks stream 0 of DMA2 for a burst of five words into the timer's preload registers,
/// so that a segment is loaded two ahead of the one that plays. A ring of segments that always ends in darkness.
///
/// The break input (PE15, low or open = break) takes both outputs low in hardware, within some 20 ns; they come back by
/// `arm` alone. What the break does is locked until the next reset of the chip (BDTR.LOCK).

namespace sc::stm32h743 {

inline constexpr std::size_t kRingSegments = 4'096;

/// 81 920 bytes. Lies where DMA2 reaches and nothing caches: SRAM2.
struct alignas(32) GateBuffers {
    std::array<Segment, kRingSegments> ring;
};

/// One object. `fill`, `cancel` and `arm` in the tick; `shut` and `check` in any context.
class GateWave {
public:
    /// What begins later than this before the end of a window is made with the next window's runs.
    static constexpr std::int64_t kTailNs = 100'000;
    /// Runs of a window must be filled so long before it begins.
    static constexpr std::int64_t kDeadlineNs = 250'000;

    explicit GateWave(GateBuffers& buffers) noexcept : buffers_(buffers) {}

    /// The timer counts from `origin_ns` on, control time at the beginning of a window, with the outputs off and that
    /// window dark. Call it right behind the start of the galvo's wave: what lies between the two stays. False: the
    /// stream does not stop or does not run.
    [[nodiscard]] bool start(std::int64_t origin_ns) noexcept;

    /// Runs of the window that begins next, once a tick, whether or not there are any. 60 instructions a trigger.
    /// False: too late, or not started; the outputs are off until the next start.
    [[nodiscard]] bool fill(std::span<const LaserRun> runs) noexcept;

    /// Outputs off now. Four accesses.
    void shut() noexcept;
    /// Outputs off now, and nothing that was filled leaves after `arm`. Up to kRingSegments · 3 stores.
    void cancel() noexcept;
    /// Outputs on. False, and they stay off: the break input is active, segments from before a `cancel` are still
    /// loaded (150 µs at most), or fill came too late.
    [[nodiscard]] bool arm() noexcept;

    /// At 10 kHz or more. False: the outputs are off. Takes them off when the ring has run dry or its stream has
    /// failed.
    [[nodiscard]] bool check() noexcept;
    /// The break input or `shut` has acted since the last `arm`.
    [[nodiscard]] static bool broken() noexcept;

    /// Pulses that had no room or came too late. Monotonic.
    [[nodiscard]] std::uint32_t refused() const noexcept { return segments_.refused() + overflows_; }
    /// Windows that were not filled in time, and failures of the stream. Monotonic.
    [[nodiscard]] std::uint32_t failures() const noexcept { return failures_.load(); }

private:
    [[nodiscard]] static std::uint32_t position() noexcept;
    [[nodiscard]] bool dry(std::uint32_t position) const noexcept;
    void fail() noexcept;
    void put_stop(std::uint32_t at) noexcept;
    void set_up_outputs() noexcept;

    GateBuffers& buffers_;
    PulseSegments segments_;
    std::atomic<std::uint32_t> end_{0};  ///< of what is filled: darkness begins there
    std::atomic<bool> runs_{false};
    std::int64_t window_end_ns_ = 0;
    std::uint32_t cancelled_at_ = 0;
    bool cancelled_ = false;
    std::uint32_t overflows_ = 0;
    std::atomic<std::uint32_t> failures_{0};
};

}  // namespace sc::stm32h743

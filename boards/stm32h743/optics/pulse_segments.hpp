// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "firmware/hal/io.hpp"

/// Runs of triggers as periods of a timer of 240 MHz that follow one another without a gap. A trigger rises where a
/// segment begins; the gate opens and shuts between two triggers. Each trigger is rounded to the nearest count by
/// itself, so that it is off by half a count (2.1 ns) at most and nothing adds up.

namespace sc::stm32h743 {

/// A segment as the timer's registers take it, in their order.
struct Segment {
    std::uint32_t reload = 0;      ///< counts − 1
    std::uint32_t repeats = 0;     ///< times − 1
    std::uint32_t gate_until = 0;  ///< the gate is open below this count
    std::uint32_t gate_from = 0;   ///< and from this count on; kNoCount: not
    std::uint32_t trigger = 0;     ///< the trigger is up below this count
    bool operator==(const Segment&) const noexcept = default;
};
inline constexpr std::size_t kSegmentWords = 5;
static_assert(sizeof(Segment) == kSegmentWords * sizeof(std::uint32_t));

inline constexpr std::uint32_t kNoCount = 0xFFFF;
inline constexpr std::uint32_t kWindowCounts = 240'000;  ///< of 1 ms
inline constexpr std::int64_t kWindowNs = 1'000'000;
/// 500 ns, since the burst that loads a segment takes some 300 ns: triggers of 2 MHz at most.
inline constexpr std::uint32_t kShortestSegment = 120;
/// 50 µs, with its repetitions: what is loaded already cannot be long.
inline constexpr std::uint32_t kLongestSegment = 12'000;
inline constexpr std::uint32_t kTriggerCounts = 48;  ///< 200 ns
/// The gate opens so long before a trigger and shuts so long behind it, or halfway to the next: 5 µs.
inline constexpr std::uint32_t kGateCounts = 1'200;

/// Makes the segments. Knows a trigger's neighbour before it makes the segment between them; what lies behind the
/// horizon waits until the runs of the next window are there. Servo context, no division by a variable but one a pulse;
/// some 60 instructions a trigger.
class PulseSegments {
public:
    /// Segments begin at `origin_ns`, control time, of which the counts are whole: a multiple of 25 ns.
    void begin(std::int64_t origin_ns) noexcept;
    /// Runs in order of time. False: there is no room.
    [[nodiscard]] bool add(const LaserRun& run) noexcept;
    /// What is not in a segment yet never leaves.
    void drop() noexcept;

    /// The next segment that begins before the horizon; none: all are made. The last one ends at most
    /// kLongestSegment behind it. `horizon_ns` less than 2 ms ahead of where the segments have come to.
    [[nodiscard]] std::optional<Segment> next(std::int64_t horizon_ns) noexcept;

    /// Triggers that passed the gate and had to be left out: too late, or closer than kShortestSegment. Monotonic.
    [[nodiscard]] std::uint32_t refused() const noexcept { return refused_; }

private:
    struct Trigger {
        std::uint32_t count = 0;  ///< from base_ns_
        bool picked = false;
    };
    [[nodiscard]] std::uint32_t count_of(std::int64_t ns256) const noexcept;
    void rebase() noexcept;
    void load() noexcept;
    void step() noexcept;
    [[nodiscard]] std::optional<Trigger> peek() noexcept;
    [[nodiscard]] Segment make(std::uint32_t length, bool opens) const noexcept;

    static constexpr std::size_t kRuns = 2 * kLaserRunsPerTick;
    std::array<LaserRun, kRuns> runs_{};
    std::size_t first_ = 0;
    std::size_t size_ = 0;
    // In the first run: pulse, trigger in it, and its times in 1/256 ns.
    std::uint32_t pulse_ = 0;
    std::uint32_t part_ = 0;
    std::int64_t pulse_ns256_ = 0;
    std::uint32_t step_ns256_ = 0;
    std::uint32_t rest_ns256_ = 0;
    // Where the segments have come to.
    std::int64_t base_ns_ = 0;
    std::uint32_t at_ = 0;    ///< counts from base_ns_
    bool triggers_ = false;   ///< a trigger leaves there
    bool gate_open_ = false;  ///< and passes
    std::uint32_t refused_ = 0;
};

}  // namespace sc::stm32h743

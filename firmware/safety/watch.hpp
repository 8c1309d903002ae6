// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "firmware/safety/supervisor.hpp"
#include "shared/codes/codes.hpp"
#include "shared/geometry/vec.hpp"
#include "shared/machine/machine.hpp"

/// What the controller asks of its own set-points and of the encoders in every tick. The planner has checked all of it
/// before; these look at what really goes out and comes back. No heap, no state but the two histories.

namespace sc::safety {

/// A fault to trip, or none.
struct Finding {
    Fault fault = Fault::none;
    std::uint8_t axis = kNoAxis;
    [[nodiscard]] constexpr explicit operator bool() const noexcept { return fault != Fault::none; }
    constexpr bool operator==(const Finding&) const noexcept = default;
};

/// `soft_limit` for the first axis whose set-point lies outside its travel.
[[nodiscard]] Finding check_travel(const MachineConfig& machine, const AxisPositions& set_point) noexcept;

/// True if the point lies in the box; the faces belong to it.
[[nodiscard]] bool in_box(const KeepOut& box, const Vec3& point) noexcept;
/// True if any point of the segment lies in the box (slab test; a segment of no length is a point).
[[nodiscard]] bool segment_meets_box(const KeepOut& box, const Vec3& a, const Vec3& b) noexcept;
/// True if any keep-out volume holds the point / is met by the segment. Places in h, metres. O(volumes).
[[nodiscard]] bool in_keep_out(const MachineConfig& machine, const Vec3& point) noexcept;
[[nodiscard]] bool through_keep_out(const MachineConfig& machine, const Vec3& a, const Vec3& b) noexcept;
/// `keep_out` if the step from one tick's set-point to the next enters a volume.
[[nodiscard]] Finding check_keep_out(const MachineConfig& machine, const AxisPositions& previous,
                                     const AxisPositions& set_point) noexcept;

/// `turn_not_retracted` if C's set-point changes while y's set-point is below the retracted place in either tick.
[[nodiscard]] Finding check_turn(const MachineConfig& machine, const AxisPositions& previous,
                                 const AxisPositions& set_point) noexcept;

/// Compares encoders with the set-points of some ticks ago. An axis is where its set-point was between `delay_min` and
/// `delay_max` ticks ago (latency, bus cycle, age of the last status), so the error is the distance to the range of
/// the set-points of that stretch: exact at rest and free of false alarms at any speed.
class FollowingWatch {
public:
    /// `status_every`: drive cycles from one status of a drive to its next, of the slowest.
    explicit FollowingWatch(const MachineConfig& machine, std::uint32_t status_every = 1) noexcept;

    /// Forgets the past: the axes stand at `actual`. Call while the drives are not enabled and when a homing ends.
    void restart(const AxisPositions& actual) noexcept;

    /// Once a tick, with the set-points that went out in the last tick and the encoders of this one (or both one tick
    /// older). `axes`: bits of the axes to look at (the others are taken as standing where they are, e.g. while
    /// homing). The frozen encoder is looked for first: it also makes a following error. O(axes · delay).
    ///
    /// `encoder_frozen`: the commanded place has moved by more than a quarter of the following window and the encoder
    /// has not changed by a single count, over more than a drive cycle. `following_error`: further away than the
    /// following window.
    [[nodiscard]] Finding step(const AxisPositions& set_point, const AxisPositions& actual,
                               std::uint8_t axes = 0x0F) noexcept;

    /// How far `actual` lies outside the set-points that are due, as above; 0 for an axis that is not looked at.
    [[nodiscard]] std::int64_t error(std::size_t axis, std::int64_t actual) const noexcept;

    [[nodiscard]] std::size_t delay_min_ticks() const noexcept { return delay_min_; }
    [[nodiscard]] std::size_t delay_max_ticks() const noexcept { return delay_max_; }

    /// Longest delay that the history can hold; longer latencies are clamped to it.
    static constexpr std::size_t kHistory = 32;

private:
    struct Limits {
        std::int64_t window = 0;
        std::int64_t frozen_travel = 0;
    };
    [[nodiscard]] Finding step_axis(std::size_t axis, std::int64_t actual) noexcept;
    struct Range {
        std::int64_t low = 0;
        std::int64_t high = 0;
    };
    [[nodiscard]] Range due(std::size_t axis) const noexcept;
    [[nodiscard]] std::int64_t past(std::size_t axis, std::size_t ticks_ago) const noexcept;
    void restart_axis(std::size_t axis, std::int64_t actual) noexcept;

    std::size_t delay_min_ = 1;
    std::size_t delay_max_ = 1;
    std::size_t newest_ = 0;
    std::uint32_t frozen_ticks_ = 1;
    std::array<Limits, kAxisCount> limits_{};
    std::array<std::array<std::int64_t, kHistory>, kAxisCount> history_{};
    AxisPositions last_actual_{};        ///< encoder at its last change
    AxisPositions command_at_change_{};  ///< oldest command of the stretch at that moment
    std::array<std::uint32_t, kAxisCount> unchanged_ticks_{};
};

/// True if the processor rounds to nearest-even and keeps denormal numbers, as the determinism of the control path
/// needs. Found by arithmetic, so that it holds on any core. A dozen operations; once a tick.
[[nodiscard]] bool arithmetic_state_is_right() noexcept;

}  // namespace sc::safety

// SPDX-License-Identifier: Apache-2.0
#include "firmware/safety/watch.hpp"

#include "shared/math/scalar.hpp"

namespace sc::safety {
namespace {

constexpr double units_per_base(std::size_t axis) noexcept {
    return axis == index(Axis::c) ? kNdegPerDegree : kPmPerMetre;
}

/// Clamped to ±1e18, well inside an int64; a value that is no number becomes 0.
std::int64_t to_units(double base, std::size_t axis) noexcept {
    constexpr double kLimit = 1e18;
    const double value = base * units_per_base(axis);
    if (value >= kLimit) {
        return static_cast<std::int64_t>(kLimit);
    }
    if (value <= -kLimit) {
        return -static_cast<std::int64_t>(kLimit);
    }
    return value == value ? static_cast<std::int64_t>(value) : 0;
}

Vec3 place_of(const AxisPositions& p) noexcept {
    return {exact_double(p[0]) / kPmPerMetre, exact_double(p[1]) / kPmPerMetre, exact_double(p[2]) / kPmPerMetre};
}

std::int64_t distance(std::int64_t a, std::int64_t b) noexcept { return a < b ? b - a : a - b; }

std::size_t clamp_delay(std::int64_t ticks) noexcept {
    constexpr auto kLongest = static_cast<std::int64_t>(FollowingWatch::kHistory);
    if (ticks < 1) {
        return 1;
    }
    return static_cast<std::size_t>(ticks < kLongest ? ticks : kLongest);
}

/// The stretch of the parameter [0, 1] of a segment that lies in the slabs looked at so far.
struct Stretch {
    double from = 0.0;
    double to = 1.0;
};

bool clip_to_slab(Stretch& stretch, double a, double b, double low, double high) noexcept {
    const double d = b - a;
    if (d == 0.0) {
        return a >= low && a <= high;
    }
    const double at_low = (low - a) / d;
    const double at_high = (high - a) / d;
    const double enter = at_low < at_high ? at_low : at_high;
    const double leave = at_low < at_high ? at_high : at_low;
    stretch.from = enter > stretch.from ? enter : stretch.from;
    stretch.to = leave < stretch.to ? leave : stretch.to;
    return stretch.from <= stretch.to;
}

}  // namespace

Finding check_travel(const MachineConfig& machine, const AxisPositions& set_point) noexcept {
    for (std::size_t axis = 0; axis < kAxisCount; ++axis) {
        const double place = exact_double(set_point[axis]) / units_per_base(axis);
        if (place < machine.axis[axis].travel_min || place > machine.axis[axis].travel_max) {
            return {Fault::soft_limit, static_cast<std::uint8_t>(axis)};
        }
    }
    return {};
}

bool in_box(const KeepOut& box, const Vec3& p) noexcept {
    return p.x >= box.min.x && p.x <= box.max.x && p.y >= box.min.y && p.y <= box.max.y && p.z >= box.min.z &&
           p.z <= box.max.z;
}

bool segment_meets_box(const KeepOut& box, const Vec3& a, const Vec3& b) noexcept {
    Stretch stretch;
    return in_box(box, a) || in_box(box, b) ||
           (clip_to_slab(stretch, a.x, b.x, box.min.x, box.max.x) &&
            clip_to_slab(stretch, a.y, b.y, box.min.y, box.max.y) &&
            clip_to_slab(stretch, a.z, b.z, box.min.z, box.max.z));
}

bool in_keep_out(const MachineConfig& machine, const Vec3& point) noexcept {
    return through_keep_out(machine, point, point);
}

bool through_keep_out(const MachineConfig& machine, const Vec3& a, const Vec3& b) noexcept {
    for (std::size_t i = 0; i < machine.keep_out_count && i < kKeepOutCapacity; ++i) {
        if (segment_meets_box(machine.keep_out[i], a, b)) {
            return true;
        }
    }
    return false;
}

Finding check_keep_out(const MachineConfig& machine, const AxisPositions& previous,
                       const AxisPositions& set_point) noexcept {
    if (through_keep_out(machine, place_of(previous), place_of(set_point))) {
        return {Fault::keep_out, kNoAxis};
    }
    return {};
}

Finding check_turn(const MachineConfig& machine, const AxisPositions& previous,
                   const AxisPositions& set_point) noexcept {
    if (set_point[index(Axis::c)] == previous[index(Axis::c)]) {
        return {};
    }
    const std::int64_t y = set_point[index(Axis::y)];
    const std::int64_t y_before = previous[index(Axis::y)];
    const double lower = exact_double(y < y_before ? y : y_before);
    if (lower < machine.y_retracted.si() * kPmPerMetre) {
        return {Fault::turn_not_retracted, static_cast<std::uint8_t>(Axis::c)};
    }
    return {};
}

FollowingWatch::FollowingWatch(const MachineConfig& machine, std::uint32_t status_every) noexcept {
    const std::uint32_t status_ticks = machine.drive_cycle_ticks * status_every;
    std::int64_t shortest = INT64_MAX;
    std::int64_t longest = 0;
    for (std::size_t axis = 0; axis < kAxisCount; ++axis) {
        const AxisConfig& config = machine.axis[axis];
        limits_[axis].window = to_units(config.following_window, axis);
        limits_[axis].frozen_travel = limits_[axis].window / 4;
        shortest = config.latency_ns < shortest ? config.latency_ns : shortest;
        longest = config.latency_ns > longest ? config.latency_ns : longest;
    }
    // The set-point of tick n is due at t_n+1 plus the latency. The status read in tick m was taken at a SYNC up to
    // `status_every` drive cycles and one delivery before, and the caller may look at it a tick later.
    const std::int64_t period = machine.control_period_ns > 0 ? machine.control_period_ns : 1;
    delay_min_ = clamp_delay(shortest / period + 1);
    delay_max_ = clamp_delay((longest + period - 1) / period + 3 + static_cast<std::int64_t>(status_ticks));
    // A status that says the same for so long has been sent at least twice.
    frozen_ticks_ = status_ticks + 2;
    restart({});
}

void FollowingWatch::restart_axis(std::size_t axis, std::int64_t actual) noexcept {
    history_[axis].fill(actual);
    last_actual_[axis] = actual;
    command_at_change_[axis] = actual;
    unchanged_ticks_[axis] = 0;
}

void FollowingWatch::restart(const AxisPositions& actual) noexcept {
    for (std::size_t axis = 0; axis < kAxisCount; ++axis) {
        restart_axis(axis, actual[axis]);
    }
}

std::int64_t FollowingWatch::past(std::size_t axis, std::size_t ticks_ago) const noexcept {
    return history_[axis][(newest_ + kHistory - (ticks_ago - 1)) % kHistory];
}

FollowingWatch::Range FollowingWatch::due(std::size_t axis) const noexcept {
    const std::int64_t oldest = past(axis, delay_max_);
    Range range{oldest, oldest};
    for (std::size_t ago = delay_min_; ago < delay_max_; ++ago) {
        const std::int64_t p = past(axis, ago);
        range.low = p < range.low ? p : range.low;
        range.high = p > range.high ? p : range.high;
    }
    return range;
}

std::int64_t FollowingWatch::error(std::size_t axis, std::int64_t actual) const noexcept {
    const Range range = due(axis);
    return actual > range.high ? actual - range.high : (actual < range.low ? actual - range.low : 0);
}

Finding FollowingWatch::step(const AxisPositions& set_point, const AxisPositions& actual, std::uint8_t axes) noexcept {
    newest_ = (newest_ + 1) % kHistory;
    Finding worst;
    for (std::size_t axis = 0; axis < kAxisCount; ++axis) {
        if (((std::uint32_t{axes} >> axis) & 1U) == 0) {
            restart_axis(axis, actual[axis]);
            continue;
        }
        history_[axis][newest_] = set_point[axis];
        const Finding finding = step_axis(axis, actual[axis]);
        const bool more_telling = finding.fault == Fault::encoder_frozen && worst.fault != Fault::encoder_frozen;
        if (finding && (!worst || more_telling)) {
            worst = finding;
        }
    }
    return worst;
}

Finding FollowingWatch::step_axis(std::size_t axis, std::int64_t actual) noexcept {
    const auto number = static_cast<std::uint8_t>(axis);
    const std::int64_t oldest = past(axis, delay_max_);
    if (actual != last_actual_[axis]) {
        last_actual_[axis] = actual;
        command_at_change_[axis] = oldest;
        unchanged_ticks_[axis] = 0;
    } else if (unchanged_ticks_[axis] < frozen_ticks_) {
        ++unchanged_ticks_[axis];
    }
    if (unchanged_ticks_[axis] >= frozen_ticks_ &&
        distance(oldest, command_at_change_[axis]) > limits_[axis].frozen_travel) {
        return {Fault::encoder_frozen, number};
    }
    const Range range = due(axis);
    if (actual < range.low - limits_[axis].window || actual > range.high + limits_[axis].window) {
        return {Fault::following_error, number};
    }
    return {};
}

bool arithmetic_state_is_right() noexcept {
    // Volatile, so that the compiler cannot fold what the processor is to be asked.
    const volatile double one = 1.0;
    const volatile double ulp = 0x1p-52;
    const volatile double half_ulp = 0x1p-53;
    const volatile double smallest_normal = 0x1p-1022;
    const volatile double denormal = 0x1p-1060;
    const volatile double half = 0.5;
    const double even_below = one + half_ulp;
    const double odd = one + ulp;
    const double even_above = odd + half_ulp;
    const double negative = -one - half_ulp;
    const bool nearest_even = even_below == 1.0 && even_above == 0x1.0000000000002p0 && negative == -1.0;
    const double flushed_result = smallest_normal * half;
    const double flushed_input = denormal * 0x1p500;
    return nearest_even && flushed_result != 0.0 && flushed_input == 0x1p-560;
}

}  // namespace sc::safety

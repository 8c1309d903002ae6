// SPDX-License-Identifier: Apache-2.0
#include "firmware/laser/pulse_placer.hpp"

#include <algorithm>
#include <optional>
#include <span>

#include "shared/math/scalar.hpp"

namespace sc::laser {
namespace {

using trajectory::rate;
using trajectory::value;

constexpr double kExact = 1e-12;  // m: the place of a pulse is solved to this, slowly
/// m: so near, one step more leaves an error of the order (1e-9)² · acceleration / speed², below 1e-10 m.
constexpr double kOneStepMore = 1e-9;
constexpr double kFast = 20e-3;       // m/s: for kOneStepMore
constexpr double kGroupError = 1e-9;  // m: allowed between the pulses of a group that are solved
constexpr std::uint32_t kMostInGroup = 16;
constexpr std::array<double, kMostInGroup> kInverse = [] {
    std::array<double, kMostInGroup> inverse{};
    for (std::size_t i = 1; i < inverse.size(); ++i) {
        inverse[i] = 1.0 / static_cast<double>(i);
    }
    return inverse;
}();
constexpr double kTimeSlack = 1e-9;  // s: rounding where two segments meet
constexpr int kFastSteps = 4;
constexpr int kSlowSteps = 60;
constexpr std::int32_t kRunTolerance = 1280;  // 1/256 ns: 5 ns, 10 nm at 2 m/s
constexpr double kEndSlack = 1e-9;            // m: a pulse this near beyond the end still belongs to the path

}  // namespace

FiringRule::FiringRule(const PulseSpec& spec) noexcept
    : rate_per_speed_(1.0 / spec.pitch),
      speed_min_(spec.speed_min > 0.0 ? spec.speed_min : 1e-9),
      prr_min_(spec.prr_min),
      prr_top_(spec.prr_nominal * (1.0 + 1e-9)),
      code_per_hz_(spec.energy / spec.power * 255.0) {
    turn_round(spec.curve, spec.energy, spec.prr_nominal);
    if (spec.power_byte == PowerByte::pulse_energy) {
        code_ = code_at(spec.prr_nominal);
        code_per_hz_ = 0.0;
        stretches_ = 0;
    }
}

void FiringRule::turn_round(const PowerCurve& curve, double energy, double prr_nominal) noexcept {
    for (std::size_t i = 0; i + 1 < curve.count; ++i) {
        const double begin = curve.watts[i] / energy;
        const double end = curve.watts[i + 1] / energy;
        const double code = static_cast<double>(curve.byte[i]);
        const double slope = (static_cast<double>(curve.byte[i + 1]) - code) / (end - begin);
        if (end > 0.5 * prr_nominal && (stretches_ == 0 || begin < prr_top_)) {
            stretch_[stretches_] = {end, code - begin * slope, slope};
            ++stretches_;
        }
    }
}

Firing firing_at(double speed, const PulseSpec& spec) noexcept { return FiringRule(spec).at(speed, 1); }

void PulsePlacer::open(const PulseSpec& spec, std::uint32_t done) noexcept {
    *this = PulsePlacer{};
    next_ = done;
    spec_ = spec;
    rule_ = FiringRule(spec);
    pitch_pm_ = nearest(spec.pitch * kPmPerMetre);
    per_pitch_ = 1.0 / spec.pitch;
}

bool PulsePlacer::done(const motion::PathMotion& path) const noexcept {
    const std::optional<motion::Stretch> stretch = path.stretch(stretch_);
    return stretch && !stretch->more && path.end_known() && next_ - base_ >= pulses_of(*stretch);
}

/// Pulses that surely lie within the stretch; all of them once its end is known.
std::uint32_t PulsePlacer::pulses_of(const motion::Stretch& stretch) const noexcept {
    const double marked = stretch.end + kEndSlack - stretch.begin;
    return static_cast<std::uint32_t>(clamped(marked * per_pitch_, -1.0, 4e9) + 1.0);
}

double PulsePlacer::next_distance(const motion::PathMotion& path) const noexcept {
    const std::optional<motion::Stretch> stretch = path.stretch(stretch_);
    if (!stretch) {
        return 0.0;
    }
    const double next = stretch->begin + static_cast<double>(next_ - base_) * spec_.pitch;
    // Where the following stretch begins may not be known: behind the end of this one.
    return stretch->more && stretch->end_known ? smaller(next, stretch->end) : next;
}

/// To the stretch behind the one that is marked to its end. False: there is none, or it is not known.
bool PulsePlacer::next_stretch(const motion::PathMotion& path) noexcept {
    const std::optional<motion::Stretch> now = path.stretch(stretch_);
    if (!now || !now->more || !now->end_known || next_ - base_ < pulses_of(*now)) {
        return false;
    }
    const std::optional<motion::Stretch> then = path.stretch(stretch_ + 1);
    if (!then) {
        return false;
    }
    ++stretch_;
    base_ += pulses_of(*now);
    base_pm_ = nearest((then->begin - path.mark_begin()) * kPmPerMetre);
    mark_begin_ = then->begin;
    pulses_ = base_ + pulses_of(*then);
    return true;
}

PulsePlacer::Solved PulsePlacer::solve_slowly(const motion::Segment& segment, double length, double low,
                                              double high) noexcept {
    // The length rises with time over [low, high]: Newton, kept inside a shrinking bracket.
    const trajectory::Quintic& distance = segment.piece->distance;
    double t = high;
    for (int i = 0;; ++i) {
        const double x = segment.x(t);
        const double speed = segment.rate * rate(distance, x);
        const double error = value(distance, x) - length;
        if (absolute(error) < kExact || i == kSlowSteps) {
            return {t, speed};
        }
        (error > 0.0 ? high : low) = t;
        double next = speed > 0.0 ? t - error / speed : low;
        if (!(next > low && next < high)) {
            next = 0.5 * (low + high);
        }
        t = next;
    }
}

PulsePlacer::Solved PulsePlacer::solve(const motion::Segment& segment, double length, double low,
                                       double guess) noexcept {
    // Newton; 1/speed is refined along with it instead of divided anew.
    const trajectory::Quintic& distance = segment.piece->distance;
    double t = guess;
    for (int i = 0; i < kFastSteps; ++i) {
        const double x = segment.x(t);
        const double speed = segment.rate * rate(distance, x);
        const double error = value(distance, x) - length;
        slowness_ = slowness_ * (2.0 - speed * slowness_);
        t = t - error * slowness_;
        if (!(t >= low - kTimeSlack && t <= segment.end + kTimeSlack)) {
            break;
        }
        if (absolute(error) < kOneStepMore && speed > kFast) {
            slowness_ = slowness_ * (2.0 - speed * slowness_);
            return {t, speed};
        }
    }
    const Solved s = solve_slowly(segment, length, larger(low, segment.begin), segment.end);
    slowness_ = s.speed > 0.0 ? 1.0 / s.speed : 0.0;
    return s;
}

PulsePlacer::Group PulsePlacer::group(const motion::Segment& segment, double length, std::uint32_t count,
                                      double low) noexcept {
    const double pitch = spec_.pitch;
    const Solved first = solve(segment, length, low, last_time_ + pitch * slowness_);
    const double slope = pitch * slowness_;
    last_time_ = first.time;
    std::uint32_t tried = first.speed > kFast ? (count < group_ ? count : group_) : 1;
    if (tried == group_) {
        group_ = group_ * 2 < kMostInGroup ? group_ * 2 : kMostInGroup;
    }
    for (; tried > 1; tried = tried / 2, group_ = tried) {
        const double n = static_cast<double>(tried - 1);
        const Solved last = solve(segment, length + n * pitch, first.time, first.time + n * slope);
        last_time_ = last.time;
        const double per_n = kInverse[tried - 1];
        const double mean = (last.time - first.time) * per_n;
        const double end_slope = pitch * slowness_;
        const Group g = {tried,
                         first.time,
                         slope,
                         (3.0 * mean - 2.0 * slope - end_slope) * per_n,
                         (slope + end_slope - 2.0 * mean) * per_n * per_n,
                         first.speed,
                         (last.speed - first.speed) * per_n};
        const double middle = 0.5 * n;
        const double error = value(segment.piece->distance, segment.x(g.time(middle))) - (length + middle * pitch);
        if (tried == 2 || absolute(error) < kGroupError) {
            return g;
        }
    }
    group_ = group_ > 2 ? group_ : 2;
    // What was tried in vain lies ahead of the next pulse.
    last_time_ = first.time;
    slowness_ = slope * per_pitch_;
    return {1, first.time, slope, 0.0, 0.0, first.speed, 0.0};
}

bool PulsePlacer::trigger(const Group& group, std::uint32_t begin, std::uint32_t count, const Firing& firing,
                          ServoOutputs& out) noexcept {
    // In 1/256 ns since the window's start, which 32 bits hold for 8 ms. Trigger k of a run leaves at
    // t0 + k · period + k (k − 1) / 2 · change; t0 is a whole ns, the second and the last pulse are met.
    const auto at = [&](std::uint32_t k) noexcept {
        return nearest32_within((group.time(static_cast<double>(begin + k)) - window_) * 256e9);
    };
    const std::int32_t t0_ns = (at(0) + 128) >> 8U;
    const std::int32_t t0 = t0_ns * 256;
    std::int32_t period = 0;
    std::int32_t change = 0;
    if (count == 1) {
        // Still tells the source its rate.
        period = nearest32(spec_.pitch / larger(group.speed, spec_.speed_min) * 256e9);
    } else {
        period = at(1) - t0;
    }
    if (count > 2) {
        const auto last = static_cast<std::int32_t>(count - 1);
        const std::int32_t rest = at(count - 1) - t0 - last * period;
        change = nearest32_within(static_cast<double>(2 * rest) * kInverse[count - 1] * kInverse[count - 2]);
        const std::int32_t middle = last / 2 + 1;
        const std::int32_t error =
            t0 + middle * period + (middle * (middle - 1) / 2) * change - at(static_cast<std::uint32_t>(middle));
        if (error > kRunTolerance || error < -kRunTolerance) {
            return false;
        }
    }
    out.laser[out.laser_size] = {window_ns_ + act_ns_ + t0_ns,
                                 period,
                                 change,
                                 static_cast<std::uint16_t>(count),
                                 static_cast<std::uint8_t>(firing.pick),
                                 static_cast<std::uint8_t>(firing.power)};
    ++out.laser_size;
    return true;
}

void PulsePlacer::write(const motion::Segment& segment, const Group& group, const Firing& firing,
                        ServoOutputs& out) noexcept {
    // Time within the window and argument of the piece's polynomials: cubics in n, by forward differences.
    const double d1 = group.t1 + (group.t2 + group.t3);
    const double d2 = 2.0 * group.t2 + 6.0 * group.t3;
    const double d3 = 6.0 * group.t3;
    std::array<double, 3> ns{(group.t0 - window_) * 1e9, d1 * 1e9, d2 * 1e9};
    const double ns3 = d3 * 1e9;
    std::array<double, 3> x{segment.x(group.t0), d1 * segment.rate, d2 * segment.rate};
    const double x3 = d3 * segment.rate;
    std::array<double, kMostInGroup> at;
    const std::span<PathPulse> pulses = std::span(out.pulses).subspan(out.pulses_size, group.count);
    std::int64_t s_pm = base_pm_ + pitch_pm_ * static_cast<std::int64_t>(next_ - base_);
    std::uint32_t number = next_;
    double* argument = at.data();
    for (PathPulse& pulse : pulses) {
        pulse.path = spec_.path;
        pulse.pass = spec_.pass;
        pulse.energy_code = static_cast<std::uint8_t>(firing.power);
        pulse.number = number;
        pulse.s_pm = s_pm;
        pulse.t_ns = window_ns_ + nearest32_within(ns[0]);
        *argument = x[0];
        ++argument;
        ++number;
        s_pm += pitch_pm_;
        ns[0] += ns[1];
        ns[1] += ns[2];
        ns[2] += ns3;
        x[0] += x[1];
        x[1] += x[2];
        x[2] += x3;
    }
    // One axis after the other: the six coefficients stay in registers.
    for (std::size_t i = 0; i < 3; ++i) {
        trajectory::Quintic q = segment.piece->axis[i];
        const bool stands = q[1] == 0.0 && q[2] == 0.0 && q[3] == 0.0 && q[4] == 0.0 && q[5] == 0.0;
        for (double& k : q) {
            k *= kPmPerMetre;
        }
        if (stands) {
            const std::int64_t place = nearest_within(q[0]);
            for (PathPulse& pulse : pulses) {
                pulse.place_pm[i] = place;
            }
            continue;
        }
        argument = at.data();
        for (PathPulse& pulse : pulses) {
            pulse.place_pm[i] = nearest_within(value(q, *argument));
            ++argument;
        }
    }
    next_ += group.count;
    out.pulses_size += group.count;
}

void PulsePlacer::place_group(const motion::Segment& segment, const Group& group, ServoOutputs& out) noexcept {
    const Firing first = rule_.at(group.speed, pick_);
    const Firing last = rule_.at(group.speed + static_cast<double>(group.count - 1) * group.speed_change, first.pick);
    last_item_ = segment.piece->item;
    if (first.possible && last.possible && first.pick == last.pick && first.power == last.power) {
        pick_ = first.pick;
        std::uint32_t length = group.count;
        for (std::uint32_t begin = 0; begin < group.count;) {
            const std::uint32_t rest = group.count - begin;
            const std::uint32_t count = length < rest ? length : rest;
            if (trigger(group, begin, count, first, out)) {
                begin += count;
            } else {
                length = (count + 1) / 2;
            }
        }
        write(segment, group, first, out);
        return;
    }
    for (std::uint32_t i = 0; i < group.count; ++i) {
        const double n = static_cast<double>(i);
        const Group one{1, group.time(n), 0.0, 0.0, 0.0, group.speed + n * group.speed_change, 0.0};
        const Firing firing = rule_.at(one.speed, pick_);
        pick_ = firing.pick;
        if (firing.possible && trigger(one, 0, 1, firing, out)) {
            write(segment, one, firing, out);
        } else {
            ++withheld_;
            ++next_;
        }
    }
}

void PulsePlacer::fill(const motion::PathMotion& path, const motion::Segment& segment, double low, double high,
                       ServoOutputs& out) noexcept {
    const double length_at_end = value(segment.piece->distance, segment.x(smaller(segment.end, high)));
    const auto end_here = [&]() noexcept {
        const double behind = clamped((length_at_end - mark_begin_) * per_pitch_ + 1.0, 0.0, 4e9);
        const std::uint32_t end = base_ + static_cast<std::uint32_t>(behind);
        return end < pulses_ ? end : pulses_;
    };
    std::uint32_t end = end_here();
    while (next_ < end || (next_ >= pulses_ && next_stretch(path))) {
        if (next_ >= end) {
            end = end_here();
            if (next_ >= end) {
                return;
            }
        }
        const std::size_t room = std::min(out.pulses.size() - out.pulses_size, out.laser.size() - out.laser_size);
        if (room == 0) {
            return;
        }
        const std::uint32_t count = end - next_;
        const double length = next_length();
        const Group g = group(segment, length, count < room ? count : static_cast<std::uint32_t>(room), low);
        low = last_time_;
        place_group(segment, g, out);
    }
}

void PulsePlacer::place(const motion::PathMotion& path, std::int64_t from_ns, std::int64_t to_ns, std::int64_t act_ns,
                        ServoOutputs& out) noexcept {
    window_ns_ = from_ns;
    window_ = exact_double(from_ns) * 1e-9;
    act_ns_ = act_ns;
    const double low = larger(larger(window_, last_time_), path.rearm_time());
    const double high = smaller(exact_double(to_ns) * 1e-9, path.stop_time());
    if (!(low < high)) {
        return;
    }
    const std::optional<motion::Stretch> stretch = path.stretch(stretch_);
    if (!stretch) {
        return;
    }
    mark_begin_ = stretch->begin;
    pulses_ = base_ + pulses_of(*stretch);
    motion::Segment segment = path.segment(low, cursor_);
    while (segment.moving || segment.end < high) {
        if (segment.moving) {
            fill(path, segment, larger(low, segment.begin), high, out);
        }
        if (segment.end >= high) {
            return;
        }
        segment = path.segment_after(segment, segment.end, cursor_);
    }
}

}  // namespace sc::laser

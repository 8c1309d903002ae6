// SPDX-License-Identifier: Apache-2.0
#include "firmware/controller/axis_follower.hpp"

#include "shared/math/scalar.hpp"

namespace sc {
namespace {

constexpr std::size_t kX = index(Axis::x);
constexpr std::size_t kZ = index(Axis::z);
constexpr std::size_t kC = index(Axis::c);
constexpr double kRadPerDegree = 0.017453292519943295;
/// Where the surface lies from the turntable's axis in the middle, m: turns the design's amplitude into an angle.
constexpr double kDesignDistance = 0.2;

motion::ErrorPredictor predictor(const MachineConfig& machine, std::size_t axis) noexcept {
    const AxisConfig& a = machine.axis[axis];
    const bool direct = machine.galvo.follow == FollowAxes::encoders;
    const double counts = direct ? a.encoder_counts_per_unit : a.counts_per_unit;
    if (machine.galvo.follow == FollowAxes::off || !(counts > 0.0)) {
        return {};
    }
    const double ticks = direct ? 1.0 : exact_double(std::int64_t{machine.drive_cycle_ticks});
    const double amplitude = axis == kC ? AxisFollower::kDesignAmplitude / (kDesignDistance * kRadPerDegree)
                                        : AxisFollower::kDesignAmplitude;
    return motion::ErrorPredictor({.sample_s = ticks * exact_double(machine.control_period_ns) * 1e-9,
                                   .grid = 1.0 / counts,
                                   .amplitude = amplitude,
                                   .bandwidth_hz = AxisFollower::kDesignBandwidthHz});
}

}  // namespace

AxisFollower::AxisFollower(const MachineConfig& machine) noexcept
    : machine_(machine),
      period_s_(exact_double(machine.control_period_ns) * 1e-9),
      // A cubic over a tick turns by at most 6 · step + 4 · speed + 2 · speed, 12 steps a tick² where the next begins
      // the other way: 24 steps a tick² between one frame and the next.
      most_step_(machine.galvo.jerk.si() * exact_double(machine.galvo_period_ns) * 1e-9 * period_s_ * period_s_ *
                 (1.0 / 24.0)),
      mirror_latency_ns_(machine.galvo.latency_ns),
      x_error_(predictor(machine, kX)),
      z_error_(predictor(machine, kZ)),
      c_error_(predictor(machine, kC)) {}

void AxisFollower::note(std::int64_t tick, const AxisPositions& set_point) noexcept {
    if (tick != newest_ + 1) {
        oldest_ = tick;
    }
    history_[static_cast<std::size_t>(tick) % kHistory] = set_point;
    newest_ = tick;
    const std::int64_t held = tick + 1 - static_cast<std::int64_t>(kHistory);
    oldest_ = oldest_ < held ? held : oldest_;
}

/// Where the axis should be at a time, pm or ndeg; the set-point of tick n is for t_n+1, and a latency behind.
double AxisFollower::asked(std::size_t axis, std::int64_t t_ns) const noexcept {
    const std::int64_t period = machine_.control_period_ns;
    const std::int64_t at = t_ns - machine_.axis[axis].latency_ns - period;
    const std::int64_t tick = at / period;
    const std::int64_t low = tick < oldest_ ? oldest_ : tick < newest_ ? tick : newest_ - 1;
    if (low < oldest_ || low + 1 > newest_) {
        return exact_double(history_[static_cast<std::size_t>(newest_) % kHistory][axis]);
    }
    const std::int64_t before = history_[static_cast<std::size_t>(low) % kHistory][axis];
    const std::int64_t after = history_[static_cast<std::size_t>(low + 1) % kHistory][axis];
    const double share = clamped(exact_double(at - low * period) / exact_double(period), 0.0, 1.0);
    return exact_double(before) + share * exact_double(after - before);
}

void AxisFollower::take(const AxisSample& sample) noexcept {
    if (newest_ == 0 || sample.t_ns <= sample_ns_) {
        return;
    }
    const double elapsed = exact_double(sample.t_ns - sample_ns_) * 1e-9;
    const bool goes_on = sampled_ && sample.t_ns - sample_ns_ <= kStaleNs;
    const auto feed = [&](motion::ErrorPredictor& predictor, std::size_t axis, double per_unit) noexcept {
        const double error = (asked(axis, sample.t_ns) - exact_double(sample.place[axis])) * per_unit;
        if (goes_on) {
            predictor.sample(error, elapsed);
        } else {
            predictor.restart(error);
        }
    };
    feed(x_error_, kX, 1.0 / kPmPerMetre);
    feed(z_error_, kZ, 1.0 / kPmPerMetre);
    feed(c_error_, kC, 1.0 / kNdegPerDegree);
    sample_ns_ = sample.t_ns;
    sampled_ = true;
}

AxisFollower::Cubic AxisFollower::go(Mirror& mirror, double place, double speed) const noexcept {
    const double wanted = clamped(place, -kBound, kBound);
    const double step = clamped(wanted - mirror.place, -most_step_, most_step_);
    // Held back, it may not swing on beyond where it is wanted.
    const double end_speed = wanted == place ? clamped(speed, -most_step_, most_step_) : 0.0;
    const Cubic cubic{mirror.place, mirror.speed, 3.0 * step - 2.0 * mirror.speed - end_speed,
                      mirror.speed + end_speed - 2.0 * step};
    mirror.place += step;
    mirror.speed = end_speed;
    return cubic;
}

std::optional<AxisFollower::Shift> AxisFollower::step(std::int64_t tick, bool marking, double from_table) noexcept {
    const std::int64_t end = (tick + 2) * machine_.control_period_ns + mirror_latency_ns_;
    const bool known = marking && sampled_ && end - sample_ns_ <= kStaleNs;
    if (!known) {
        constexpr double kRest = 1e-9;
        if (absolute(x_.place) < kRest && absolute(z_.place) < kRest) {
            drop();
            return std::nullopt;
        }
        return Shift{go(x_, 0.0, 0.0), go(z_, 0.0, 0.0)};
    }
    const double ahead = exact_double(end - sample_ns_) * 1e-9;
    // The table stands at less than it was told: the surface lies behind by the angle times its distance.
    const double per_degree = from_table * kRadPerDegree;
    const double x = x_error_.error(ahead) + per_degree * c_error_.error(ahead);
    const double x_speed = x_error_.speed(ahead) + per_degree * c_error_.speed(ahead);
    return Shift{go(x_, x, x_speed * period_s_), go(z_, z_error_.error(ahead), z_error_.speed(ahead) * period_s_)};
}

}  // namespace sc

// SPDX-License-Identifier: Apache-2.0
#include "firmware/laser/pulse_placer.hpp"

#include "shared/math/scalar.hpp"

namespace sc::laser {
namespace {

constexpr double kExact = 1e-12;  // m: the place of a pulse is solved to this
constexpr int kFastSteps = 5;
constexpr int kSlowSteps = 60;
constexpr std::int64_t kRunTolerance = 512;  // 1/256 ns: 2 ns, 4 nm at 2 m/s
constexpr double kEndSlack = 1e-9;           // m: a pulse this near beyond the end still belongs to the path

}  // namespace

FiringRule::FiringRule(const PulseSpec& spec) noexcept
    : rate_per_speed_(1.0 / spec.pitch),
      speed_min_(spec.speed_min > 0.0 ? spec.speed_min : 1e-9),
      prr_min_(spec.prr_min),
      prr_top_(spec.prr_nominal * (1.0 + 1e-9)),
      code_per_hz_(spec.energy / spec.power * 255.0) {}

Firing FiringRule::at(double speed, std::uint8_t pick_hint) const noexcept {
    Firing firing;
    if (!(speed >= speed_min_)) {
        return firing;
    }
    const double rate = speed * rate_per_speed_;
    std::uint32_t pick = pick_hint;
    while (pick < 255 && rate * static_cast<double>(pick + 1) <= prr_top_) {
        ++pick;
    }
    while (pick > 1 && rate * static_cast<double>(pick) > prr_top_) {
        --pick;
    }
    const double prr = rate * static_cast<double>(pick);
    firing.pick = static_cast<std::uint8_t>(pick);
    if (prr < prr_min_ || prr > prr_top_ * 1.0001) {
        return firing;
    }
    firing.power = static_cast<std::uint8_t>(nearest32(clamped(prr * code_per_hz_, 0.0, 255.0)));
    firing.possible = firing.power > 0;
    return firing;
}

Firing firing_at(double speed, const PulseSpec& spec) noexcept { return FiringRule(spec).at(speed, 1); }

void PulsePlacer::open(const PulseSpec& spec) noexcept {
    *this = PulsePlacer{};
    spec_ = spec;
    rule_ = FiringRule(spec);
    pitch_pm_ = nearest(spec.pitch * kPmPerMetre);
}

bool PulsePlacer::done(const motion::Planner& planner) const noexcept {
    return planner.builder().finished() && next_distance(planner) > planner.builder().mark_end() + kEndSlack;
}

PulsePlacer::Solved PulsePlacer::evaluate(const motion::Segment& segment, double t) const noexcept {
    Solved s;
    s.time = t;
    s.way = segment.way(t);
    s.speed = segment.speed(t) * segment.element->stretch(s.way);
    return s;
}

PulsePlacer::Solved PulsePlacer::solve(const motion::Segment& segment, double length, double low,
                                       double high) noexcept {
    // Newton from where the last pulse's speed puts it; 1/speed is refined along with it instead of divided anew.
    double t = clamped(last_time_ + spec_.pitch * slowness_, low, high);
    for (int i = 0; i < kFastSteps; ++i) {
        const Solved s = evaluate(segment, t);
        const double error = segment.element->length_to(s.way) - length;
        const double ratio = s.speed * slowness_;
        if (!(ratio > 0.5 && ratio < 1.5)) {
            break;
        }
        slowness_ = slowness_ * (2.0 - ratio);
        if (absolute(error) < kExact) {
            return s;
        }
        t = t - error * slowness_;
        if (!(t >= low && t <= high)) {
            break;
        }
    }
    const Solved s = solve_slowly(segment, length, low, high);
    slowness_ = s.speed > 0.0 ? 1.0 / s.speed : 0.0;
    return s;
}

PulsePlacer::Solved PulsePlacer::solve_slowly(const motion::Segment& segment, double length, double low,
                                              double high) noexcept {
    // The length rises with time over [low, high]: Newton, kept inside a shrinking bracket.
    Solved s = evaluate(segment, high);
    for (int i = 0; i < kSlowSteps; ++i) {
        const double error = segment.element->length_to(s.way) - length;
        if (absolute(error) < kExact) {
            break;
        }
        (error > 0.0 ? high : low) = s.time;
        double next = s.speed > 0.0 ? s.time - error / s.speed : low;
        if (!(next > low && next < high)) {
            next = 0.5 * (low + high);
        }
        s = evaluate(segment, next);
    }
    return s;
}

void PulsePlacer::trigger(std::int64_t t_ns256, double speed, const Firing& firing, ServoOutputs& out) noexcept {
    if (out.laser_size > 0) {
        LaserRun& run = out.laser[out.laser_size - 1];
        const bool same = run.pick == firing.pick && run.power == firing.power;
        bool taken = false;
        if (same && run.count == 1) {
            run.period_ns256 = t_ns256 - run.t0_ns * 256;
            step_ = run.period_ns256;
            expected_ = t_ns256;
            taken = true;
        } else if (same && run.count == 2) {
            run.change_ns256 = nearest32(static_cast<double>(t_ns256 - last_trigger_ - run.period_ns256));
            step_ = run.period_ns256 + run.change_ns256;
            taken = last_trigger_ + step_ == t_ns256;  // unless the change had to be clamped
            run.change_ns256 = taken ? run.change_ns256 : 0;
        } else if (same && run.count < 0xFFFF) {
            const std::int64_t error = expected_ + step_ + run.change_ns256 - t_ns256;
            taken = error <= kRunTolerance && error >= -kRunTolerance;
            step_ += taken ? run.change_ns256 : 0;
        }
        if (taken) {
            expected_ += run.count > 1 ? step_ : 0;
            ++run.count;
            last_trigger_ = t_ns256;
            return;
        }
    }
    LaserRun& run = out.laser[out.laser_size];
    ++out.laser_size;
    run.t0_ns = (t_ns256 + 128) >> 8U;
    // A run of one still tells the source its rate.
    run.period_ns256 = nearest(spec_.pitch / larger(speed, spec_.speed_min) * 256e9);
    run.change_ns256 = 0;
    run.count = 1;
    run.pick = firing.pick;
    run.power = firing.power;
    last_trigger_ = t_ns256;
}

void PulsePlacer::emit(const motion::Segment& segment, const Solved& solved, std::int64_t t_ns256, std::int64_t t_ns,
                       ServoOutputs& out) noexcept {
    const Firing firing = rule_.at(solved.speed, last_pick_);
    if (!firing.possible) {
        ++withheld_;
        return;
    }
    last_pick_ = firing.pick;
    const motion::Element& element = *segment.element;
    const double bent = element.bent(solved.way);
    PathPulse& pulse = out.pulses[out.pulses_size];
    ++out.pulses_size;
    pulse.path = spec_.path;
    pulse.pass = spec_.pass;
    pulse.energy_code = firing.power;
    pulse.number = next_;
    pulse.s_pm = pitch_pm_ * static_cast<std::int64_t>(next_);
    for (std::size_t i = 0; i < pulse.place_pm.size(); ++i) {
        pulse.place_pm[i] = nearest(element.axis(i, solved.way, bent) * kPmPerMetre);
    }
    pulse.t_ns = t_ns;
    last_item_ = element.item;
    trigger(t_ns256, solved.speed, firing, out);
}

void PulsePlacer::place(const motion::Planner& planner, std::int64_t from_ns, std::int64_t to_ns, std::int64_t act_ns,
                        ServoOutputs& out) noexcept {
    const double from = static_cast<double>(from_ns) * 1e-9;
    double low = larger(larger(from, last_time_), planner.rearm_time());
    const double high = smaller(static_cast<double>(to_ns) * 1e-9, planner.stop_time());
    if (!(low < high) || planner.law().empty()) {
        return;
    }
    motion::Segment segment = planner.segment(low, hint_);
    double length_at_end = segment.element->length_to(segment.way(segment.last));
    while (!done(planner) && out.pulses_size < out.pulses.size() && out.laser_size < out.laser.size()) {
        const double distance = next_distance(planner);
        while (distance - segment.element->distance > length_at_end) {
            if (segment.end >= high) {
                return;
            }
            segment = planner.segment(segment.end, hint_);
            length_at_end = segment.element->length_to(segment.way(segment.last));
        }
        const Solved solved =
            solve(segment, distance - segment.element->distance, larger(low, segment.begin), segment.last);
        if (solved.time >= high) {
            return;
        }
        const double since = solved.time - from;
        emit(segment, solved, (from_ns + act_ns) * 256 + nearest32(since * 256e9), from_ns + nearest32(since * 1e9),
             out);
        low = last_time_ = solved.time;
        ++next_;
    }
}

}  // namespace sc::laser

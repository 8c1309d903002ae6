// SPDX-License-Identifier: Apache-2.0
#include "firmware/laser/pulse_placer.hpp"

#include "shared/math/scalar.hpp"

namespace sc::laser {
namespace {

constexpr double kExact = 1e-12;  // m: the place of a pulse is solved to this
constexpr int kSolveSteps = 24;
constexpr std::int64_t kRunTolerance = 512;  // 1/256 ns: 2 ns, 4 nm at 2 m/s
constexpr double kEndSlack = 1e-9;           // m: a pulse this near beyond the end still belongs to the path

/// Time of trigger k of a run, 1/256 ns.
std::int64_t trigger(const LaserRun& run, std::int64_t k) noexcept {
    return run.t0_ns * 256 + k * run.period_ns256 + run.change_ns256 * (k * (k - 1) / 2);
}

/// Adds a trigger at `t` (1/256 ns) to the run if it lies where the run puts it, or can be made to.
bool extend(LaserRun& run, std::int64_t last, std::int64_t t, const Firing& firing) noexcept {
    if (run.pick != firing.pick || run.power != firing.power || run.count == 0xFFFF) {
        return false;
    }
    if (run.count == 1) {
        run.period_ns256 = t - run.t0_ns * 256;
    } else if (run.count == 2) {
        run.change_ns256 =
            static_cast<std::int32_t>(clamped(static_cast<double>((t - last) - run.period_ns256), -2e9, 2e9));
    }
    const std::int64_t error = trigger(run, run.count) - t;
    if (error > kRunTolerance || error < -kRunTolerance) {
        return false;
    }
    ++run.count;
    return true;
}

}  // namespace

Firing firing_at(double speed, const PulseSpec& spec) noexcept {
    Firing firing;
    if (!(speed >= spec.speed_min) || !(speed > 0.0)) {
        return firing;
    }
    const double rate = speed / spec.pitch;
    // A rate that is the nominal one but for rounding keeps pick 1.
    const double pick = clamped(spec.prr_nominal / rate + 1e-9, 1.0, 255.0);
    firing.pick = static_cast<std::uint8_t>(pick);
    const double prr = rate * static_cast<double>(firing.pick);
    if (prr < spec.prr_min || prr > spec.prr_nominal * 1.0001) {
        return firing;
    }
    const double code = spec.energy * prr / spec.power * 255.0;
    firing.power = static_cast<std::uint8_t>(rounded(clamped(code, 0.0, 255.0)));
    firing.possible = firing.power > 0;
    return firing;
}

void PulsePlacer::open(const PulseSpec& spec) noexcept {
    *this = PulsePlacer{};
    spec_ = spec;
}

bool PulsePlacer::done(const motion::Planner& planner) const noexcept {
    return planner.builder().finished() && next_distance(planner) > planner.builder().mark_end() + kEndSlack;
}

PulsePlacer::Solved PulsePlacer::solve(const motion::Planner& planner, double distance, double low,
                                       double high) noexcept {
    // Distance rises with time over [low, high]: Newton, kept inside a shrinking bracket.
    Solved solved;
    solved.state = planner.state(high, hint_);
    if (planner.distance(solved.state) < distance) {
        return solved;
    }
    solved.found = true;
    double t = high;
    for (int i = 0; i < kSolveSteps; ++i) {
        const double error = planner.distance(solved.state) - distance;
        if (absolute(error) < kExact) {
            break;
        }
        (error > 0.0 ? high : low) = t;
        const double rate =
            solved.state.speed * planner.elements().at(solved.state.element).stretch_at(solved.state.tau);
        double next = rate > 0.0 ? t - error / rate : low;
        if (!(next > low && next < high)) {
            next = 0.5 * (low + high);
        }
        t = next;
        solved.state = planner.state(t, hint_);
    }
    solved.time = t;
    return solved;
}

void PulsePlacer::emit(const motion::Planner& planner, const Solved& solved, std::int64_t act_ns,
                       ServoOutputs& out) noexcept {
    const Firing firing =
        firing_at(solved.state.speed * planner.elements().at(solved.state.element).stretch_at(solved.state.tau), spec_);
    if (!firing.possible) {
        ++withheld_;
        return;
    }
    const std::int64_t t256 = rounded(solved.time * 256e9);
    PathPulse& pulse = out.pulses[out.pulses_size];
    ++out.pulses_size;
    const motion::Place place = planner.place(solved.state);
    pulse.path = spec_.path;
    pulse.pass = spec_.pass;
    pulse.energy_code = firing.power;
    pulse.number = next_;
    pulse.s_pm = rounded(static_cast<double>(next_) * spec_.pitch * kPmPerMetre);
    for (std::size_t i = 0; i < pulse.place_pm.size(); ++i) {
        pulse.place_pm[i] = rounded(place[i] * kPmPerMetre);
    }
    pulse.t_ns = rounded(solved.time * 1e9);
    last_item_ = planner.elements().at(solved.state.element).item;

    const std::int64_t t = t256 + act_ns * 256;
    if (out.laser_size == 0 || !extend(out.laser[out.laser_size - 1], last_trigger_, t, firing)) {
        LaserRun& run = out.laser[out.laser_size];
        ++out.laser_size;
        run = LaserRun{};
        run.t0_ns = (t + 128) / 256;
        run.count = 1;
        run.pick = firing.pick;
        run.power = firing.power;
        // A run of one still tells the source its rate.
        run.period_ns256 = rounded(spec_.pitch / larger(solved.state.speed, spec_.speed_min) * 256e9);
    }
    last_trigger_ = t;
}

void PulsePlacer::place(const motion::Planner& planner, double from, double to, std::int64_t act_ns,
                        ServoOutputs& out) noexcept {
    double low = larger(larger(from, last_time_), planner.rearm_time());
    const double high = smaller(to, planner.stop_time());
    while (low < high && !done(planner) && out.pulses_size < out.pulses.size() && out.laser_size < out.laser.size()) {
        const Solved solved = solve(planner, next_distance(planner), low, high);
        if (!solved.found || solved.time >= high) {
            return;
        }
        emit(planner, solved, act_ns, out);
        low = last_time_ = solved.time;
        ++next_;
    }
}

}  // namespace sc::laser

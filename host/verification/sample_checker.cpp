// SPDX-License-Identifier: Apache-2.0
#include "host/verification/sample_checker.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "host/formats/pulse_trace.hpp"
#include "shared/codes/state.hpp"

namespace sc::host {

namespace {

constexpr std::array<std::string_view, kAxisCount> kAxisName{"x", "y", "z", "c"};
constexpr std::array<std::string_view, 2> kMirrorName{"galvo x", "galvo z"};
/// Largest rounding of the first three differences, in units of the grid.
constexpr std::array<double, 3> kRounding{1.0, 2.0, 4.0};
constexpr double kDegreesPerMetre = 1e3;  ///< kPlaceTolerance for C

/// Set-points mean places in h. Before homing, idle may stand anywhere.
bool is_homed(std::uint8_t state) noexcept {
    return leads_axes(state) && state != static_cast<std::uint8_t>(State::idle);
}

double metres(std::int64_t pm) noexcept { return static_cast<double>(pm) / kPmPerMetre; }

/// A damaged trace may hold any number; differences of numbers within this do not overflow.
std::int64_t tamed(std::int64_t value) noexcept {
    constexpr std::int64_t kMost = 1'000'000'000'000'000'000;
    return std::clamp(value, -kMost, kMost);
}

}  // namespace

bool leads_axes(std::uint8_t state) noexcept {
    // A damaged trace may hold any number: no cast to State, and what is no state is judged as if axes were led.
    const auto is = [state](State other) { return state == static_cast<std::uint8_t>(other); };
    return !(is(State::boot) || is(State::disabled) || is(State::enabling) || is(State::homing) ||
             is(State::disabling) || is(State::fault));
}

std::string_view name_of(Breach breach) noexcept {
    switch (breach) {
        case Breach::missing_tick: return "missing_tick";
        case Breach::travel: return "travel";
        case Breach::speed: return "speed";
        case Breach::acceleration: return "acceleration";
        case Breach::jerk: return "jerk";
        case Breach::galvo_field: return "galvo_field";
        case Breach::keep_out: return "keep_out";
        case Breach::turn_not_retracted: return "turn_not_retracted";
        case Breach::gate_outside_marking: return "gate_outside_marking";
        case Breach::not_at_rest: return "not_at_rest";
        case Breach::path_end: return "path_end";
        case Breach::deviation: return "deviation";
        case Breach::vertex_skipped: return "vertex_skipped";
        case Breach::path_lost: return "path_lost";
    }
    return "?";
}

void SampleChecker::History::rest_at(std::int64_t sample) noexcept { last.fill(tamed(sample)); }

std::array<std::int64_t, 3> SampleChecker::History::push(std::int64_t sample) noexcept {
    const std::int64_t value = tamed(sample);
    const auto [p1, p2, p3] = last;
    last = {value, p1, p2};
    return {value - p1, value - 2 * p1 + p2, value - 3 * p1 + 3 * p2 - p3};
}

SampleChecker::SampleChecker(const MachineConfig& machine, double allow) : machine_(machine), allow_(allow) {
    const double tick = 1e-9 * static_cast<double>(machine.control_period_ns);
    for (std::size_t i = 0; i < kAxisCount; ++i) {
        const AxisConfig& a = machine.axis[i];
        const double units = i == index(Axis::c) ? kNdegPerDegree : kPmPerMetre;
        axis_bounds_[i] = {a.speed, a.acceleration, a.jerk, units, tick, kAxisName[i]};
    }
    const GalvoConfig& g = machine.galvo;
    const double frame = 1e-9 * static_cast<double>(machine.galvo_period_ns);
    for (std::size_t i = 0; i < 2; ++i) {
        galvo_bounds_[i] = {g.speed.si(), g.acceleration.si(), g.jerk.si(), kPmPerMetre, frame, kMirrorName[i]};
    }
}

void SampleChecker::add(const trace::SampleRecord& record, std::span<const trace::GalvoSample> frames) {
    if (report_.ticks > 0 && record.tick != next_tick_) {
        add_violation({.breach = Breach::missing_tick,
                       .tick = record.tick,
                       .axis = {},
                       .value = static_cast<double>(record.tick),
                       .limit = static_cast<double>(next_tick_)});
        moving_ = false;
        const trace::GalvoSample start = frames.empty() ? trace::GalvoSample{} : frames.front();
        galvo_[0].rest_at(start.x_pm);
        galvo_[1].rest_at(start.z_pm);
    }
    next_tick_ = record.tick + 1;
    ++report_.ticks;
    report_.cell_seconds = 1e-9 * static_cast<double>(machine_.control_period_ns) * static_cast<double>(report_.ticks);
    check_axes(record);
    if (is_homed(record.state)) {
        check_places(record);
    }
    check_mirrors(record, frames);
    if (record.gate != 0 && record.state != static_cast<std::uint8_t>(State::marking)) {
        add_violation({.breach = Breach::gate_outside_marking,
                       .tick = record.tick,
                       .axis = {},
                       .value = static_cast<double>(record.state),
                       .limit = static_cast<double>(State::marking)});
    }
}

void SampleChecker::check_axes(const trace::SampleRecord& record) {
    const bool moving = leads_axes(record.state);
    for (std::size_t i = 0; i < kAxisCount; ++i) {
        if (!moving || !moving_) {
            axis_[i].rest_at(record.set_point[i]);
            continue;
        }
        const std::array<std::int64_t, 3> differences = axis_[i].push(record.set_point[i]);
        check_differences(axis_bounds_[i], differences, record.tick, -1, report_.axis_peak[i]);
        if (i == index(Axis::c)) {
            check_turn(record, differences[0]);
        }
    }
    moving_ = moving;
}

void SampleChecker::check_turn(const trace::SampleRecord& record, std::int64_t c_step) {
    if (c_step == 0) {
        return;
    }
    const double up = machine_.y_retracted.si();
    const double commanded = metres(record.set_point[index(Axis::y)]);
    const double actual = metres(record.actual[index(Axis::y)]);
    const double window = machine_.axis[index(Axis::y)].following_window;
    if (commanded < up - kPlaceTolerance || actual < up - kPlaceTolerance - window) {
        add_violation({.breach = Breach::turn_not_retracted,
                       .tick = record.tick,
                       .axis = kAxisName[index(Axis::y)],
                       .value = std::min(commanded, actual),
                       .limit = up});
    }
}

void SampleChecker::check_places(const trace::SampleRecord& record) {
    for (std::size_t i = 0; i < kAxisCount; ++i) {
        const AxisConfig& axis = machine_.axis[i];
        const double value = static_cast<double>(record.set_point[i]) / axis_bounds_[i].units_per_base;
        const double slack = i == index(Axis::c) ? kPlaceTolerance * kDegreesPerMetre : kPlaceTolerance;
        if (value < axis.travel_min - slack || value > axis.travel_max + slack) {
            add_violation({.breach = Breach::travel,
                           .tick = record.tick,
                           .axis = kAxisName[i],
                           .value = value,
                           .limit = value < axis.travel_min ? axis.travel_min : axis.travel_max});
        }
    }
}

void SampleChecker::check_mirrors(const trace::SampleRecord& record, std::span<const trace::GalvoSample> frames) {
    const bool homed = is_homed(record.state);
    // At rest at zero from the fourth sample on: more of them would show nothing new.
    constexpr std::array<trace::GalvoSample, 4> kZeros{};
    const std::span<const trace::GalvoSample> samples = frames.empty() ? std::span(kZeros) : frames;
    report_.galvo_frames += static_cast<std::int64_t>(frames.size());
    int frame = 0;
    for (const trace::GalvoSample& sample : samples) {
        check_mirror_frame(record.tick, frame, sample);
        if (homed && (frame == 0 || !frames.empty())) {
            check_focus(record, frames.empty() ? -1 : frame, sample);
        }
        ++frame;
    }
}

void SampleChecker::check_mirror_frame(std::int64_t tick, int frame, const trace::GalvoSample& sample) {
    const std::array<std::int64_t, 2> place{sample.x_pm, sample.z_pm};
    const double half = machine_.galvo.half_field.si();
    for (std::size_t i = 0; i < 2; ++i) {
        check_differences(galvo_bounds_[i], galvo_[i].push(place[i]), tick, frame, report_.galvo_peak[i]);
        if (std::abs(metres(place[i])) > half + kPlaceTolerance) {
            add_violation({.breach = Breach::galvo_field,
                           .tick = tick,
                           .frame = frame,
                           .axis = kMirrorName[i],
                           .value = metres(place[i]),
                           .limit = half});
        }
    }
}

void SampleChecker::check_focus(const trace::SampleRecord& record, int frame, const trace::GalvoSample& sample) {
    const Vec3 focus{metres(record.set_point[0]) + metres(sample.x_pm), metres(record.set_point[1]),
                     metres(record.set_point[2]) + metres(sample.z_pm)};
    const std::size_t count = std::min<std::size_t>(machine_.keep_out_count, kKeepOutCapacity);
    for (std::size_t box = 0; box < count; ++box) {
        const KeepOut& volume = machine_.keep_out[box];
        double depth = std::numeric_limits<double>::infinity();  // of the focus inside the volume
        for (std::size_t i = 0; i < 3; ++i) {
            depth = std::min({depth, focus[i] - volume.min[i], volume.max[i] - focus[i]});
        }
        if (depth > kPlaceTolerance) {
            add_violation(
                {.breach = Breach::keep_out, .tick = record.tick, .frame = frame, .axis = {}, .value = depth});
        }
    }
}

void SampleChecker::check_differences(const Bounds& bounds, const std::array<std::int64_t, 3>& differences,
                                      std::int64_t tick, int frame, MotionPeak& peak) {
    const std::array<double, 3> limits{bounds.speed, bounds.acceleration, bounds.jerk};
    const std::array<double*, 3> peaks{&peak.speed, &peak.acceleration, &peak.jerk};
    constexpr std::array<Breach, 3> kBreach{Breach::speed, Breach::acceleration, Breach::jerk};
    double scale = 1.0 / bounds.units_per_base;
    for (std::size_t k = 0; k < 3; ++k) {
        scale /= bounds.period;
        const double value = std::abs(static_cast<double>(differences[k])) * scale;
        if (value > *peaks[k]) {
            *peaks[k] = value;
            peak.tick[k] = tick;
        }
        if (value > limits[k] * allow_ + kRounding[k] * scale) {
            add_violation({.breach = kBreach[k],
                           .tick = tick,
                           .frame = frame,
                           .axis = bounds.name,
                           .value = value,
                           .limit = limits[k]});
        }
    }
}

void SampleChecker::end() {
    for (std::size_t i = 0; moving_ && i < kAxisCount; ++i) {
        const Bounds& bounds = axis_bounds_[i];
        // An axis that comes to rest at the last sample covers J T³/6 at most in the tick before.
        const double most = bounds.jerk * bounds.period * bounds.period * bounds.period / 6.0;
        const double step = std::abs(static_cast<double>(axis_[i].last[0] - axis_[i].last[1])) / bounds.units_per_base;
        if (step > most * allow_ + kRounding[0] / bounds.units_per_base) {
            add_violation({.breach = Breach::not_at_rest,
                           .tick = next_tick_ - 1,
                           .axis = bounds.name,
                           .value = step / bounds.period,
                           .limit = most / bounds.period});
        }
    }
}

void SampleChecker::add_violation(const Violation& violation) {
    ++report_.limit_violations;
    if (report_.first.size() < kKeptViolations) {
        report_.first.push_back(violation);
    }
}

SampleReport check_samples(const std::filesystem::path& path, const MachineConfig& machine) {
    SampleChecker checker(machine);
    for_each_sample(path, [&checker](const trace::SampleRecord& record, std::span<const trace::GalvoSample> frames) {
        checker.add(record, frames);
    });
    return checker.report();
}

}  // namespace sc::host

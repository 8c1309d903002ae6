// SPDX-License-Identifier: Apache-2.0
// What the distance sensors are used for: the surface before and during marking, and the workpiece's seat.
#include "firmware/controller/controller.hpp"
#include "shared/math/scalar.hpp"

namespace sc {

void Controller::sense(const ServoInputs& in, ServoOutputs& out) noexcept {
    hub_.step(in, out);
    if (runner_.surface().on()) {
        runner_.see(hub_.sample(kYSensor));
    }
    if (seating_.busy()) {
        const auto result = seating_.step(hub_, in.tick * machine_.control_period_ns);
        if (result.done) {
            seating_failed_ = result.refusal != Refusal::none;
            link_.reply(seating_sequence_, result.refusal, result.detail);
        }
    }
}

Controller::Verdict Controller::set_surface(const link::SetSurface& m) noexcept {
    if (!geometry_may_change()) {
        return {Refusal::wrong_state, static_cast<std::int64_t>(state())};
    }
    const auto mode = static_cast<sensors::SurfaceMode>(m.mode);
    if (m.mode > static_cast<std::uint8_t>(sensors::SurfaceMode::follow)) {
        return {Refusal::bad_config, m.mode};
    }
    if (mode != sensors::SurfaceMode::off && !hub_.fitted(kYSensor)) {
        return {Refusal::sensor_not_fitted, static_cast<std::int64_t>(kYSensor)};
    }
    sensors::SurfaceSettings settings;
    settings.mode = mode;
    settings.origin = {m.origin[0], m.origin[1], m.origin[2]};
    settings.direction = {m.direction[0], m.direction[1], m.direction[2]};
    settings.zero = m.zero;
    settings.window = m.window;
    settings.bound = m.bound;
    return runner_.set_surface(settings) ? Verdict{} : Verdict{Refusal::bad_config, 0};
}

Controller::Verdict Controller::check_seating(const link::CheckSeating& m, std::int64_t tick) noexcept {
    for (std::size_t i = 0; i < kTripleCount; ++i) {
        if (!hub_.fitted(kFirstTriple + i)) {
            return {Refusal::sensor_not_fitted, static_cast<std::int64_t>(kFirstTriple + i)};
        }
    }
    if (seating_.busy() || safety::mo_state(state()) || !runner_.at_rest()) {
        return {Refusal::wrong_state, static_cast<std::int64_t>(state())};
    }
    sensors::SeatingWanted wanted;
    wanted.expected = m.expected;
    wanted.tolerance = m.tolerance;
    wanted.tilt = m.tilt;
    wanted.samples = m.samples;
    if (!seating_.begin(wanted, tick * machine_.control_period_ns)) {
        return {Refusal::bad_config, 0};
    }
    seating_sequence_ = m.sequence;
    return {};
}

Controller::Verdict Controller::fire_in_turn(const link::Command& command) noexcept {
    if (command.arg0 < 0 || command.arg0 > 1) {
        return {Refusal::bad_config, command.arg0};
    }
    hub_.fire_in_turn(command.arg0 == 1);
    return {};
}

void Controller::report_sensors(std::int64_t tick) noexcept {
    const std::int64_t now = tick * machine_.control_period_ns;
    link::SensorReport report;
    report.cell_time_us = static_cast<std::uint64_t>(now / 1000);
    for (std::size_t i = 0; i < kSensorCount; ++i) {
        if (!hub_.fitted(i)) {
            report.code[i] = static_cast<std::uint16_t>(Refusal::sensor_not_fitted);
            continue;
        }
        const sensors::Sample sample = hub_.sample(i);
        const std::int64_t age = sample.count > 0 ? (now - sample.measured_ns) / 1000 : 0;
        report.value[i] = sample.value;
        report.age_us[i] = static_cast<std::uint32_t>(age < 0xFFFF'FFFF ? age : 0xFFFF'FFFF);
        report.quality[i] = static_cast<std::uint8_t>(sample.quality);
        report.code[i] = static_cast<std::uint16_t>(sample.code);
        report.detail[i] = sample.detail;
        report.count[i] = sample.count;
        report.repeats[i] = sample.repeats;
        report.bad[i] = sample.bad;
        report.last_bad[i] = static_cast<std::uint16_t>(sample.last_bad);
    }
    const sensors::Surface& surface = runner_.surface();
    report.surface = surface.on() ? static_cast<std::uint8_t>(1U + static_cast<unsigned>(surface.verdict())) : 0;
    report.surface_depth = nearest32(surface.depth() * kWireUnitsPerMetre);
    report.shift = nearest32(surface.shift() * kWireUnitsPerMetre);
    for (std::size_t i = 0; i < kTripleCount; ++i) {
        report.seating[i] = seating_.deviation()[i];
    }
    link_.report(report);
}

void Controller::watch_surface(std::int64_t tick) noexcept {
    if (state() != State::marking || !runner_.surface().on()) {
        return;
    }
    const auto verdict = runner_.surface().verdict();
    if (verdict == sensors::Surface::Verdict::off) {
        trip(Fault::surface_off, static_cast<std::uint8_t>(Axis::y), tick);
    } else if (verdict == sensors::Surface::Verdict::not_seen) {
        trip(Fault::surface_lost, static_cast<std::uint8_t>(Axis::y), tick);
    }
}

}  // namespace sc

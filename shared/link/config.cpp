// SPDX-License-Identifier: Apache-2.0
#include "shared/link/config.hpp"

#include <limits>
#include <type_traits>

#include "shared/path/item.hpp"
#include "shared/wire/bytes.hpp"

namespace sc::link {
namespace {

// Structured bindings name every member: a member added to the configuration breaks the build here and not the machine.
template <class Visitor, class Config>
constexpr void visit_axis(Visitor& v, Config& a) noexcept {
    auto& [travel_min, travel_max, speed, acceleration, jerk, counts, window, home, latency, node, encoder] = a;
    v(travel_min), v(travel_max), v(speed), v(acceleration), v(jerk);
    v(counts), v(window), v(home), v(latency), v(node), v(encoder);
}
template <class Visitor, class Config>
constexpr void visit_galvo(Visitor& v, Config& g) noexcept {
    auto& [half_field, speed, acceleration, jerk, counts, latency, convention, word, frequency, damping, follow] = g;
    v(half_field), v(speed), v(acceleration), v(jerk), v(counts), v(latency), v(convention), v(word);
    v(frequency), v(damping), v(follow);
}
template <class Visitor, class Config>
constexpr void visit_laser(Visitor& v, Config& l) noexcept {
    auto& [power, prr_min, prr_nominal, warning, mo_wait, latency, mark_speed_min, guide_speed, shutter_time,
           latch_setup, latch_width, source, power_byte] = l;
    v(power), v(prr_min), v(prr_nominal), v(warning), v(mo_wait), v(latency), v(mark_speed_min);
    v(guide_speed), v(shutter_time), v(latch_setup), v(latch_width), v(source), v(power_byte);
}
template <class Visitor, class Config>
constexpr void visit_keep_out(Visitor& v, Config& k) noexcept {
    auto& [min, max] = k;
    v(min.x), v(min.y), v(min.z), v(max.x), v(max.y), v(max.z);
}
template <class Visitor, class Config>
constexpr void visit_sensors(Visitor& v, Config& s) noexcept {
    auto& [buses, sensors] = s;
    for (auto& bus : buses) {
        auto& [baud, parity, short_gaps, latch] = bus;
        v(baud), v(parity), v(short_gaps), v(latch);
    }
    for (auto& sensor : sensors) {
        auto& [kind, bus, address, identity, near, far, jump, update, patience, stuck, too_old] = sensor;
        v(kind), v(bus), v(address), v(identity), v(near), v(far), v(jump);
        v(update), v(patience), v(stuck), v(too_old);
    }
}
template <class Visitor, class Config>
constexpr void visit_machine(Visitor& v, Config& m) noexcept {
    auto& [control_period, galvo_period, guard_period, drive_cycle, axes, galvo, laser, y_retracted, park, settle,
           keep_outs, keep_out_count, heartbeat_timeout, held_link_timeout, table_y, sensors] = m;
    v(control_period), v(galvo_period), v(guard_period), v(drive_cycle);
    for (auto& axis : axes) {
        visit_axis(v, axis);
    }
    visit_galvo(v, galvo);
    visit_laser(v, laser);
    v(y_retracted), v(park), v(settle);
    for (auto& keep_out : keep_outs) {
        visit_keep_out(v, keep_out);
    }
    v(keep_out_count), v(heartbeat_timeout), v(held_link_timeout), v(table_y);
    visit_sensors(v, sensors);
}

struct Counter {
    std::size_t bytes = sizeof(kConfigVersion);
    template <class T>
    constexpr void operator()(const T& /*value*/) noexcept {
        bytes += sizeof(T);
    }
};
constexpr std::size_t config_size() noexcept {
    Counter counter;
    const MachineConfig machine;
    visit_machine(counter, machine);
    return counter.bytes;
}
static_assert(config_size() == kConfigSize, "another layout needs another kConfigVersion");

struct Writer {
    ByteWriter& out;
    template <WireNumber T>
    void operator()(const T& value) noexcept {
        out.put(value);
    }
    template <int L, int T, int M, int A>
    void operator()(const Quantity<L, T, M, A>& value) noexcept {
        out.put(value.si());
    }
    void operator()(const GalvoConvention& value) noexcept { out.put(static_cast<std::uint8_t>(value)); }
    void operator()(const GalvoWord& value) noexcept { out.put(static_cast<std::uint8_t>(value)); }
    void operator()(const FollowAxes& value) noexcept { out.put(static_cast<std::uint8_t>(value)); }
    void operator()(const LaserSource& value) noexcept { out.put(static_cast<std::uint8_t>(value)); }
    void operator()(const PowerByte& value) noexcept { out.put(static_cast<std::uint8_t>(value)); }
    void operator()(const SensorKind& value) noexcept { out.put(static_cast<std::uint8_t>(value)); }
    void operator()(const SensorParity& value) noexcept { out.put(static_cast<std::uint8_t>(value)); }
};
struct Reader {
    ByteReader& in;
    template <WireNumber T>
    void operator()(T& value) noexcept {
        value = in.get<T>();
    }
    template <int L, int T, int M, int A>
    void operator()(Quantity<L, T, M, A>& value) noexcept {
        value = Quantity<L, T, M, A>::from_si(in.get<double>());
    }
    void operator()(GalvoConvention& value) noexcept {
        const auto code = in.get<std::uint8_t>();
        value = static_cast<GalvoConvention>(code);
        if (code > static_cast<std::uint8_t>(GalvoConvention::twos_complement)) {
            in.fail();
        }
    }
    void operator()(GalvoWord& value) noexcept {
        const auto code = in.get<std::uint8_t>();
        value = static_cast<GalvoWord>(code);
        if (code > static_cast<std::uint8_t>(GalvoWord::bits18)) {
            in.fail();
        }
    }
    void operator()(FollowAxes& value) noexcept {
        const auto code = in.get<std::uint8_t>();
        value = static_cast<FollowAxes>(code);
        if (code > static_cast<std::uint8_t>(FollowAxes::encoders)) {
            in.fail();
        }
    }
    void operator()(LaserSource& value) noexcept {
        const auto code = in.get<std::uint8_t>();
        value = static_cast<LaserSource>(code);
        if (code > static_cast<std::uint8_t>(LaserSource::jpt)) {
            in.fail();
        }
    }
    void operator()(SensorKind& value) noexcept {
        const auto code = in.get<std::uint8_t>();
        value = static_cast<SensorKind>(code);
        if (code > static_cast<std::uint8_t>(SensorKind::ascii)) {
            in.fail();
        }
    }
    void operator()(SensorParity& value) noexcept {
        const auto code = in.get<std::uint8_t>();
        value = static_cast<SensorParity>(code);
        if (code > static_cast<std::uint8_t>(SensorParity::even)) {
            in.fail();
        }
    }
    void operator()(PowerByte& value) noexcept {
        const auto code = in.get<std::uint8_t>();
        value = static_cast<PowerByte>(code);
        if (code > static_cast<std::uint8_t>(PowerByte::pulse_energy)) {
            in.fail();
        }
    }
};

constexpr bool finite(double value) noexcept {
    constexpr double kLargest = std::numeric_limits<double>::max();
    return value >= -kLargest && value <= kLargest;
}
constexpr bool positive(double value) noexcept { return finite(value) && value > 0.0; }
constexpr bool not_negative(double value) noexcept { return finite(value) && value >= 0.0; }

bool axis_is_sound(const AxisConfig& a, double wire_units) noexcept {
    const double reach = std::numeric_limits<std::int32_t>::max() / wire_units;
    const bool travel = finite(a.travel_min) && finite(a.travel_max) && a.travel_min < a.travel_max &&
                        a.travel_min >= -reach && a.travel_max <= reach;
    const bool home = finite(a.home_position) && a.home_position >= a.travel_min && a.home_position <= a.travel_max;
    const bool limits = positive(a.speed) && positive(a.acceleration) && positive(a.jerk);
    const bool drive = positive(a.counts_per_unit) && positive(a.following_window) && a.latency_ns >= 0 &&
                       not_negative(a.encoder_counts_per_unit);
    return travel && home && limits && drive && a.drive_node >= 1 && a.drive_node <= 127;
}

bool axes_are_sound(const MachineConfig& m) noexcept {
    for (std::size_t i = 0; i < kAxisCount; ++i) {
        if (!axis_is_sound(m.axis[i], i == index(Axis::c) ? kWireUnitsPerDegree : kWireUnitsPerMetre)) {
            return false;
        }
        for (std::size_t j = 0; j < i; ++j) {
            if (m.axis[i].drive_node == m.axis[j].drive_node) {
                return false;
            }
        }
    }
    if (m.galvo.follow == FollowAxes::encoders) {
        for (const Axis axis : {Axis::x, Axis::z, Axis::c}) {
            if (m.axis[index(axis)].encoder_counts_per_unit == 0.0) {
                return false;
            }
        }
    }
    const AxisConfig& y = m.axis[index(Axis::y)];
    return finite(m.table_y.si()) && finite(m.y_retracted.si()) && m.y_retracted.si() >= y.travel_min &&
           m.y_retracted.si() <= y.travel_max;
}

/// The lag of the servo is a part of the latency, and a servo so damped is none.
bool servo_is_sound(const GalvoConfig& g) noexcept {
    const double frequency = g.natural_frequency.si();
    if (frequency == 0.0) {
        return not_negative(g.damping);
    }
    return positive(frequency) && g.damping >= 0.1 && g.damping <= 10.0 &&
           galvo_lead(g, 0).per_velocity <= static_cast<double>(g.latency_ns) * 1e-9;
}

bool galvo_is_sound(const GalvoConfig& g) noexcept {
    return servo_is_sound(g) && not_negative(g.half_field.si()) && positive(g.speed.si()) &&
           positive(g.acceleration.si()) && positive(g.jerk.si()) && positive(g.counts_per_metre) && g.latency_ns >= 0;
}

/// A strobe is over long before the next tick.
constexpr bool in_microseconds(std::int64_t ns) noexcept { return ns >= 0 && ns <= 20'000; }

bool laser_is_sound(const LaserConfig& l) noexcept {
    return positive(l.power.si()) && positive(l.prr_min.si()) && positive(l.prr_nominal.si()) &&
           l.prr_min <= l.prr_nominal && l.warning_ns >= 0 && l.mo_wait_ns >= 0 && l.latency_ns >= 0 &&
           not_negative(l.mark_speed_min.si()) && positive(l.guide_speed_max.si()) && l.shutter_time_ns > 0 &&
           in_microseconds(l.latch_setup_ns) && in_microseconds(l.latch_width_ns);
}

bool times_are_sound(const MachineConfig& m) noexcept {
    constexpr std::int64_t kMs = 1'000'000;
    const bool periods = m.galvo_period_ns > 0 && m.guard_period_ns > 0 && m.control_period_ns > 0 &&
                         m.control_period_ns % m.galvo_period_ns == 0 && m.control_period_ns % m.guard_period_ns == 0;
    const bool heartbeat = m.heartbeat_timeout_ns >= 20 * kMs && m.heartbeat_timeout_ns <= 500 * kMs;
    return periods && heartbeat && m.drive_cycle_ticks >= 1 && m.settle_ns >= 0 && m.held_link_timeout_ns >= 0 &&
           positive(m.park_tolerance.si());
}

bool sensor_is_sound(const SensorsConfig& all, std::size_t i) noexcept {
    const SensorConfig& s = all.sensor[i];
    if (s.kind == SensorKind::none) {
        return true;
    }
    const bool place = s.bus < kSensorBuses && all.bus[s.bus].baud != 0 && s.address >= 1 && s.address <= 247;
    const bool range = s.near >= 0 && s.near < s.far && s.jump >= 0;
    const bool times = s.update_ns > 0 && s.patience_ns > 0 && s.patience_ns <= 2'000'000'000 && s.stuck_ns >= 0 &&
                       s.too_old_ns > s.update_ns;
    for (std::size_t k = 0; k < i; ++k) {
        if (all.sensor[k].kind != SensorKind::none && all.sensor[k].bus == s.bus &&
            all.sensor[k].address == s.address) {
            return false;
        }
    }
    return place && range && times;
}

bool sensors_are_sound(const SensorsConfig& all) noexcept {
    for (const SensorBusConfig& bus : all.bus) {
        if (bus.baud != 0 && (bus.baud < 2'400 || bus.baud > 230'400)) {
            return false;
        }
    }
    for (std::size_t i = 0; i < kSensorCount; ++i) {
        if (!sensor_is_sound(all, i)) {
            return false;
        }
    }
    return true;
}

bool keep_outs_are_sound(const MachineConfig& m) noexcept {
    if (m.keep_out_count > kKeepOutCapacity) {
        return false;
    }
    for (std::size_t i = 0; i < m.keep_out_count; ++i) {
        const KeepOut& k = m.keep_out[i];
        for (std::size_t j = 0; j < 3; ++j) {
            if (!finite(k.min[j]) || !finite(k.max[j]) || !(k.min[j] < k.max[j])) {
                return false;
            }
        }
    }
    return true;
}

}  // namespace

void serialise(const MachineConfig& machine, std::span<std::uint8_t, kConfigSize> out) noexcept {
    ByteWriter bytes(out);
    bytes.put(kConfigVersion);
    Writer writer{bytes};
    visit_machine(writer, machine);
}

Refusal deserialise_into(MachineConfig& machine, std::span<const std::uint8_t> bytes) noexcept {
    ByteReader in(bytes);
    if (in.get<std::uint16_t>() != kConfigVersion && in.ok()) {
        return Refusal::version_mismatch;
    }
    Reader reader{in};
    visit_machine(reader, machine);
    return in.exhausted() ? check(machine) : Refusal::bad_config;
}

Refusal check(const MachineConfig& machine) noexcept {
    const bool sound = times_are_sound(machine) && axes_are_sound(machine) && galvo_is_sound(machine.galvo) &&
                       laser_is_sound(machine.laser) && keep_outs_are_sound(machine) &&
                       sensors_are_sound(machine.sensors);
    return sound ? Refusal::none : Refusal::bad_config;
}

}  // namespace sc::link

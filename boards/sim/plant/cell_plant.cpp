// SPDX-License-Identifier: Apache-2.0
#include "boards/sim/plant/cell_plant.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <span>
#include <stdexcept>
#include <utility>

namespace sc::sim {
namespace {

/// The board latches its encoders so long before the tick.
constexpr std::int32_t kEncoderAgeNs = 20'000;

/// A converter for the galvo's line says "all well" with no head behind it.
constexpr std::uint16_t kConverterAlone = 0xFDFD;

std::int64_t pm(double metres) { return std::llround(metres * kPmPerMetre); }

std::array<std::int64_t, 3> pm(const Vec3& v) { return {pm(v.x), pm(v.y), pm(v.z)}; }

void check_periods(const MachineConfig& machine) {
    if (machine.control_period_ns % machine.guard_period_ns != 0 ||
        machine.guard_period_ns % machine.galvo_period_ns != 0 ||
        machine.control_period_ns != machine.galvo_period_ns * static_cast<std::int64_t>(kGalvoFramesPerTick)) {
        throw std::invalid_argument("cell: a control period must be whole guard periods, and those whole galvo frames");
    }
}

}  // namespace

CellPlant::CellPlant(const MachineConfig& machine, const World& world, std::vector<FaultEvent> script,
                     GuardFunction guard_function, const PlantDrives& drives)
    : machine_(machine),
      world_(&world),
      guard_(guard_function),
      faults_(std::move(script)),
      galvo_(machine, world.spec().galvo),
      laser_(machine.laser, world.spec().laser),
      mopa_(machine.laser.source),
      sensors_(machine.sensors, world),
      lines_(world.spec().inputs) {
    check_periods(machine);
    show(SourceTrouble::none);
    read_lines();
    deflections_.resize(static_cast<std::size_t>(machine.guard_period_ns / machine.galvo_period_ns) + 1);
    const std::int64_t drive_cycle_ns = machine.drive_cycle_ticks * machine.control_period_ns;
    for (std::size_t i = 0; i < kAxisCount; ++i) {
        SimDriveOptions options = drive_options(machine.axis[i], drive_cycle_ns, kPowerUpPosition[i]);
        options.quirks = drives.quirks[i];
        options.second_bus = drives.second_bus[i];
        options.backlash = world.spec().drives.backlash[i];
        options.servo.disturbance = world.spec().drives.disturbance[i];
        options.servo.disturbance_frequency = world.spec().drives.disturbance_frequency;
        drives_.emplace_back(options);
    }
}

void CellPlant::sample(ServoInputs& inputs) {
    std::swap(drive_rx_, drive_sent_);
    drive_sent_.clear();
    inputs.drive_rx = drive_rx_;
    read_lines();
    inputs.digital = lines_;
    inputs.galvo_status = galvo_.status();
    source_rx_.clear();
    mopa_.take(source_rx_);
    inputs.source_rx = source_rx_;
    sensors_.take(inputs.tick * machine_.control_period_ns, sensor_rx_);
    for (std::size_t bus = 0; bus < kSensorBuses; ++bus) {
        inputs.sensor_rx.at(bus) = sensor_rx_.at(bus);
    }
    inputs.guard_causes = std::exchange(guard_causes_, std::uint8_t{0});
    read_encoders(inputs.encoders, inputs.tick * machine_.control_period_ns);
}

void CellPlant::read_encoders(EncoderInputs& encoders, std::int64_t t_ns) const {
    encoders = {};
    for (std::size_t i = 0; i < kAxisCount; ++i) {
        if (const double counts = machine_.axis[i].encoder_counts_per_unit; counts > 0.0) {
            encoders.valid = true;
            encoders.counts[i] = std::llround(drives_[i].true_position_at(t_ns - kEncoderAgeNs) * counts);
        }
    }
    encoders.age_ns = encoders.valid ? kEncoderAgeNs : 0;
}

void CellPlant::accept(std::int64_t tick, const ServoOutputs& outputs) {
    for (std::size_t i = 0; i < outputs.laser_size; ++i) {
        laser_.queue(outputs.laser[i], outputs.gate_allowed);
    }
    if (outputs.cancel_laser) {
        const std::int64_t t_ns = tick * machine_.control_period_ns + kCancelActNs;
        laser_.cancel(t_ns);
        cancelled_until_ns_ = (tick + 1) * machine_.control_period_ns;
        if (pin_sink_) {
            pin_sink_(t_ns, Pin::gate, false);
        }
    }
}

void CellPlant::play(std::int64_t tick, const ServoOutputs* acting, const PulseSink& sink) {
    const std::int64_t begin = tick * machine_.control_period_ns;
    begin_window(begin, acting);
    const std::size_t frames = deflections_.size() - 1;
    for (std::size_t first = 0; first < kGalvoFramesPerTick; first += frames) {
        const std::int64_t from = begin + static_cast<std::int64_t>(first) * machine_.galvo_period_ns;
        const std::int64_t to = from + machine_.guard_period_ns;
        run_timed_events(from);
        guard(from, acting != nullptr && acting->gate_allowed);
        if (pin_sink_) {
            show_pins(from, acting);
        }
        move(to, first, acting);
        fire(from, to, sink);
        shine_guide(from, acting);
    }
    for (SimDrive& drive : drives_) {
        drive.drain(drive_sent_);
    }
}

void CellPlant::begin_window(std::int64_t t_ns, const ServoOutputs* acting) {
    laser_.set_master_oscillator(acting != nullptr && acting->digital.master_oscillator, t_ns);
    if (acting == nullptr || acting->clear_power) {
        laser_.clear_power(t_ns);
    }
    shutter_.command(acting != nullptr && acting->digital.shutter_open);
    if (acting == nullptr) {
        return;
    }
    mopa_.emit(acting->digital.master_oscillator);
    mopa_.receive(std::span(acting->source_tx).first(acting->source_tx_size));
    sensors_.transmit(t_ns, acting->sensor_tx);
    const std::int64_t period = machine_.control_period_ns;
    beam_.master_oscillator_ns += acting->digital.master_oscillator ? period : 0;
    beam_.gate_ns += acting->gate_allowed ? period : 0;
    beam_.guide_ns += acting->digital.guide_laser ? period : 0;
    for (std::size_t i = 0; i < acting->drive_tx_size; ++i) {
        for (SimDrive& drive : drives_) {
            drive.receive(acting->drive_tx[i], t_ns);
        }
    }
}

void CellPlant::read_lines() {
    lines_.shutter_open = shutter_.reads_open();
    lines_.shutter_closed = shutter_.reads_closed();
}

void CellPlant::show(SourceTrouble trouble) { lines_.source_status = source_pins(machine_.laser.source, trouble); }

void CellPlant::shine_guide(std::int64_t t_ns, const ServoOutputs* acting) {
    if (guide_sink_ && acting != nullptr && acting->digital.guide_laser) {
        guide_sink_(record_of({.t_ns = t_ns}, t_ns));
    }
}

void CellPlant::watch_pins(PinSink sink) {
    pin_sink_ = std::move(sink);
    laser_.watch_triggers([this](std::int64_t t_ns) { pin_sink_(t_ns, Pin::trigger, true); });
}

void CellPlant::show_pins(std::int64_t t_ns, const ServoOutputs* acting) {
    const DigitalOutputs lines = acting == nullptr ? DigitalOutputs{} : acting->digital;
    pin_sink_(t_ns, Pin::master_oscillator, lines.master_oscillator);
    pin_sink_(t_ns, Pin::guide_laser, lines.guide_laser);
    pin_sink_(t_ns, Pin::shutter_coil, lines.shutter_open);
    pin_sink_(t_ns, Pin::beam_way, shutter_.passes());
}

void CellPlant::guard(std::int64_t t_ns, bool gate_allowed) {
    shutter_.step_to(t_ns);
    beam_.shutter_ns += shutter_.reads_closed() ? 0 : machine_.guard_period_ns;
    read_lines();
    const GuardVeto veto = guard_({lines_, galvo_.status(), gate_allowed, machine_.laser.source});
    guard_causes_ |= veto.causes;
    if (veto.causes == 0) {
        // Runs of a tick that did not allow the gate were refused when they were queued.
        laser_.open_gate();
    } else if (veto.close_gate) {
        laser_.cancel(t_ns + kGuardActNs);
        laser_.shut_gate(t_ns + kGuardActNs);
    }
    if (pin_sink_ && (veto.close_gate || t_ns >= cancelled_until_ns_)) {
        pin_sink_(veto.close_gate ? t_ns + kGuardActNs : t_ns, Pin::gate, !veto.close_gate);
    }
}

void CellPlant::move(std::int64_t t_ns, std::size_t first_frame, const ServoOutputs* acting) {
    deflections_[0] = galvo_.state();
    for (std::size_t i = 1; i < deflections_.size(); ++i) {
        if (acting != nullptr) {
            const GalvoFrame& frame = acting->galvo[first_frame + i - 1];
            galvo_.play(frame.word_x, frame.word_z);
        }
        deflections_[i] = galvo_.state();
    }
    for (SimDrive& drive : drives_) {
        drive.step_to(t_ns);
    }
    sensors_.step_to(
        t_ns, {drives_[0].load_position_at(t_ns), drives_[1].load_position_at(t_ns), drives_[2].load_position_at(t_ns)},
        drives_[3].load_position_at(t_ns));
}

void CellPlant::fire(std::int64_t begin_ns, std::int64_t end_ns, const PulseSink& sink) {
    while (true) {
        const std::int64_t limit = std::min(faults_.next_time(), end_ns);
        if (const std::optional<LaserPulse> pulse = laser_.next(limit)) {
            light(*pulse, begin_ns, sink);
        } else if (limit < end_ns) {
            run_timed_events(limit);
        } else {
            return;
        }
    }
}

void CellPlant::light(const LaserPulse& pulse, std::int64_t begin_ns, const PulseSink& sink) {
    if (!pulse.lit) {
        return;
    }
    if (!shutter_.passes()) {
        ++beam_.shuttered;
        return;
    }
    ++pulses_;
    last_pulse_ns_ = pulse.t_ns;
    faults_.saw_pulse(pulse.t_ns);
    sink(record_of(pulse, begin_ns));
    while (const std::optional<FaultEvent> event = faults_.take_after(pulses_, pulse.t_ns)) {
        apply(*event, pulse.t_ns);
    }
}

bool CellPlant::marks(const LaserPulse& pulse, const Spot& spot) const {
    const LaserTruth& laser = world_->spec().laser;
    const double off = spot.defocus / laser.rayleigh_length;
    const double area = kPi * laser.waist * laser.waist * (1.0 + off * off);
    return 2.0 * pulse.energy_nj * 1e-9 / area >= laser.mark_threshold;
}

trace::PulseRecord CellPlant::record_of(const LaserPulse& pulse, std::int64_t begin_ns) const {
    const double frame_ns = static_cast<double>(machine_.galvo_period_ns);
    const double frames = std::max(0.0, static_cast<double>(pulse.t_ns - begin_ns) / frame_ns);
    const std::size_t k = std::min(static_cast<std::size_t>(frames), deflections_.size() - 2);
    const auto mirrors =
        between(deflections_[k], deflections_[k + 1], frames - static_cast<double>(k), frame_ns * 1e-9);
    const Vec3 reading{drives_[0].load_position_at(pulse.t_ns), drives_[1].load_position_at(pulse.t_ns),
                       drives_[2].load_position_at(pulse.t_ns)};
    const double c = drives_[3].load_position_at(pulse.t_ns);

    trace::PulseRecord record;
    record.t_ns = pulse.t_ns;
    record.energy_nj = pulse.energy_nj;
    record.c_ndeg = std::llround(world_->table_angle(c) * kNdegPerDegree);
    if (const std::optional<Spot> spot = world_->shine(reading, mirrors[0], mirrors[1], c)) {
        record.place_pm = pm(spot->place);
        record.table_pm = pm(spot->table_place);
        record.defocus_pm = pm(spot->defocus);
        record.hit = marks(pulse, *spot) ? 1 : 2;
    }
    return record;
}

void CellPlant::run_timed_events(std::int64_t t_ns) {
    while (const std::optional<FaultEvent> event = faults_.take_at(t_ns)) {
        apply(*event, *event->at_ns);
    }
}

void CellPlant::apply(const FaultEvent& event, std::int64_t t_ns) {
    switch (event.action) {
        case FaultAction::estop_open: lines_.estop_closed = false; break;
        case FaultAction::estop_close: lines_.estop_closed = true; break;
        case FaultAction::interlock_open: lines_.interlock_closed = false; break;
        case FaultAction::interlock_close: lines_.interlock_closed = true; break;
        case FaultAction::laser_alarm:
        case FaultAction::laser_not_ready:
        case FaultAction::laser_ok:
        case FaultAction::laser_back_reflection:
        case FaultAction::laser_temperature:
        case FaultAction::laser_main_supply:
        case FaultAction::laser_housekeeping:
        case FaultAction::laser_system:
        case FaultAction::laser_strange:
        case FaultAction::laser_warning:
        case FaultAction::laser_starting:
        case FaultAction::laser_mute:
        case FaultAction::laser_stubborn:
        case FaultAction::laser_speaks_raycus:
        case FaultAction::laser_speaks_jpt: apply_to_laser(event.action); break;
        case FaultAction::shutter_stuck:
        case FaultAction::shutter_dropped:
        case FaultAction::shutter_unplugged:
        case FaultAction::shutter_ok:
        case FaultAction::key_off:
        case FaultAction::key_setup:
        case FaultAction::key_production: apply_to_beam(event.action); break;
        case FaultAction::galvo_fail: galvo_.fail(true); break;
        case FaultAction::galvo_absent: galvo_.unplug(kConverterAlone); break;
        case FaultAction::galvo_float_high: galvo_.unplug(0xFFFF); break;
        case FaultAction::galvo_float_low: galvo_.unplug(0x0000); break;
        case FaultAction::galvo_ok:
            galvo_.fail(false);
            galvo_.unplug(std::nullopt);
            break;
        case FaultAction::link_cut: link_connected_ = false; break;
        case FaultAction::link_restore: link_connected_ = true; break;
        case FaultAction::drive_freeze:
        case FaultAction::drive_stall:
        case FaultAction::drive_silent:
        case FaultAction::drive_fault:
        case FaultAction::drive_recover: apply_to_drive(event); break;
        case FaultAction::sensor_silent:
        case FaultAction::sensor_crc:
        case FaultAction::sensor_wrong_slave:
        case FaultAction::sensor_exception:
        case FaultAction::sensor_chopped:
        case FaultAction::sensor_stale:
        case FaultAction::sensor_foreign:
        case FaultAction::sensor_blind:
        case FaultAction::sensor_slipped:
        case FaultAction::sensor_swapped:
        case FaultAction::sensor_ok: apply_to_sensor(event); break;
    }
    apply_lines(t_ns);
}

void CellPlant::apply_to_laser(FaultAction action) {
    if (action == FaultAction::laser_alarm) {
        lines_.laser_no_alarm = false;
    } else if (action == FaultAction::laser_not_ready) {
        lines_.laser_ready = false;
    } else if (action == FaultAction::laser_ok) {
        lines_.laser_ready = lines_.laser_no_alarm = true;
        show(SourceTrouble::none);
        mopa_.mute(false);
        mopa_.stay(false);
    } else if (action == FaultAction::laser_mute) {
        mopa_.mute(true);
    } else if (action == FaultAction::laser_stubborn) {
        mopa_.stay(true);
    } else if (action == FaultAction::laser_speaks_raycus) {
        mopa_ = MopaSource(LaserSource::raycus);
    } else if (action == FaultAction::laser_speaks_jpt) {
        mopa_ = MopaSource(LaserSource::jpt);
    } else {
        static const std::map<FaultAction, SourceTrouble> kTroubles{
            {FaultAction::laser_back_reflection, SourceTrouble::back_reflection},
            {FaultAction::laser_temperature, SourceTrouble::temperature},
            {FaultAction::laser_main_supply, SourceTrouble::main_supply},
            {FaultAction::laser_housekeeping, SourceTrouble::housekeeping},
            {FaultAction::laser_system, SourceTrouble::system},
            {FaultAction::laser_strange, SourceTrouble::strange},
            {FaultAction::laser_warning, SourceTrouble::warning},
            {FaultAction::laser_starting, SourceTrouble::starting}};
        show(kTroubles.at(action));
    }
}

void CellPlant::apply_to_beam(FaultAction action) {
    if (action == FaultAction::shutter_stuck) {
        shutter_.stick(true);
    } else if (action == FaultAction::shutter_dropped) {
        shutter_.drop(true);
    } else if (action == FaultAction::shutter_unplugged) {
        shutter_.unplug(true);
    } else if (action == FaultAction::shutter_ok) {
        shutter_.stick(false);
        shutter_.drop(false);
        shutter_.unplug(false);
    } else {
        lines_.key_setup = action == FaultAction::key_setup;
        lines_.key_production = action == FaultAction::key_production;
    }
    read_lines();
}

void CellPlant::apply_to_drive(const FaultEvent& event) {
    SimDrive& drive = drives_[index(event.axis)];
    if (event.action == FaultAction::drive_freeze) {
        drive.freeze_encoder(true);
    } else if (event.action == FaultAction::drive_stall) {
        drive.block(true);
    } else if (event.action == FaultAction::drive_silent) {
        drive.go_silent(true);
    } else if (event.action == FaultAction::drive_fault) {
        drive.raise_fault(event.error_code);
    } else {
        drive.freeze_encoder(false);
        drive.block(false);
        drive.go_silent(false);
    }
}

void CellPlant::apply_to_sensor(const FaultEvent& event) {
    static const std::map<FaultAction, SensorTrouble> kTroubles{
        {FaultAction::sensor_silent, SensorTrouble::silent},
        {FaultAction::sensor_crc, SensorTrouble::crc},
        {FaultAction::sensor_wrong_slave, SensorTrouble::wrong_slave},
        {FaultAction::sensor_exception, SensorTrouble::exception},
        {FaultAction::sensor_chopped, SensorTrouble::chopped},
        {FaultAction::sensor_stale, SensorTrouble::stale},
        {FaultAction::sensor_foreign, SensorTrouble::foreign},
        {FaultAction::sensor_blind, SensorTrouble::blind},
        {FaultAction::sensor_slipped, SensorTrouble::slipped},
        {FaultAction::sensor_ok, SensorTrouble::none}};
    if (event.action == FaultAction::sensor_swapped) {
        sensors_.swap_with_next(event.sensor);
    } else {
        sensors_.trouble(event.sensor, kTroubles.at(event.action));
    }
}

void CellPlant::apply_lines(std::int64_t t_ns) {
    shutter_.allow(lines_.estop_closed && lines_.interlock_closed);
    if (lines_.estop_closed && lines_.interlock_closed) {
        laser_.restore_light();
    } else {
        laser_.cut_light(t_ns + kHardCutNs);
    }
}

AxisPositions CellPlant::encoders() const {
    AxisPositions out{};
    for (std::size_t i = 0; i < kAxisCount; ++i) {
        const AxisConfig& axis = machine_.axis[i];
        const double unit = i == index(Axis::c) ? kNdegPerDegree : kPmPerMetre;
        const double counts = std::round(drives_[i].true_position() * axis.counts_per_unit);
        out[i] = std::llround(counts / axis.counts_per_unit * unit);
    }
    return out;
}

}  // namespace sc::sim

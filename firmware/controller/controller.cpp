// SPDX-License-Identifier: Apache-2.0
#include "firmware/controller/controller.hpp"

#include <span>

#include "shared/machine/source_status.hpp"

namespace sc {
namespace {

using safety::Event;

constexpr std::uint8_t axis_bit(Axis axis) noexcept { return static_cast<std::uint8_t>(1U << index(axis)); }

/// Axes that a stage of homing moves: y first, so that x, z and C turn in the clear.
constexpr std::uint8_t home_axes(std::uint8_t stage) noexcept {
    return stage == 0
               ? axis_bit(Axis::y)
               : (stage == 1 ? static_cast<std::uint8_t>(axis_bit(Axis::x) | axis_bit(Axis::z)) : axis_bit(Axis::c));
}

}  // namespace

Controller::Controller(const MachineConfig& machine, std::uint32_t boot_id, RetainedMemory* retained,
                       const DrivePlan& drives) noexcept
    : machine_(machine),
      link_(machine, boot_id),
      drives_(machine_, drives),
      mo_(machine.laser.mo_wait_ns, machine.control_period_ns),
      shutter_(machine.laser.shutter_time_ns, machine.control_period_ns),
      following_(machine_, most_status_every(drives)),
      head_(machine.galvo),
      power_(machine.laser),
      mopa_(machine.laser.source, machine.control_period_ns),
      hub_(machine.sensors, machine.control_period_ns),
      runner_(machine),
      retained_(retained),
      retained_record_(retained == nullptr ? std::nullopt : retained->read()),
      black_box_(machine.control_period_ns) {}

bool Controller::homed() const noexcept {
    for (const drives::AxisStatus& axis : drives_seen_.axis) {
        if (!axis.homed) {
            return false;
        }
    }
    return true;
}

void Controller::advance_states() noexcept {
    switch (state()) {
        case State::boot:
            if (drives_seen_.all_present) {
                (void)supervisor_.post(Event::drives_present);
            }
            break;
        case State::enabling:
            if (drives_seen_.all_follow) {
                (void)supervisor_.post(Event::enabled);
            }
            break;
        case State::homing:
            if (drives_seen_.homing_done) {
                ++home_stage_;
                if (home_stage_ > 2) {
                    (void)supervisor_.post(Event::homed);
                }
            }
            break;
        case State::jogging:
            if (runner_.idle()) {
                (void)supervisor_.post(Event::jog_done);
            }
            break;
        case State::arming:
            if (mo_.ready()) {
                (void)supervisor_.post(Event::mo_ready);
            }
            break;
        case State::running:
        case State::marking: advance_job(); break;
        case State::previewing:
        case State::preview_stopping: advance_preview(); break;
        case State::stopping: advance_stop(); break;
        case State::held:
            // Held for want of points, and they have come. A hold by the operator waits for him.
            if (stop_reason_ == Event::starved && runner_.can_continue() && supervisor_.post(Event::resume)) {
                runner_.resume();
            }
            break;
        case State::disabling:
            if (drives_seen_.all_disabled) {
                (void)supervisor_.post(Event::disabled);
            }
            break;
        case State::disabled:
        case State::idle:
        case State::armed:
        case State::held_link:
        case State::fault: break;
    }
}

void Controller::advance_job() noexcept {
    if (drop_refused()) {
        return;
    }
    if (runner_.starved()) {
        if (supervisor_.post(Event::starved)) {
            stop_reason_ = Event::starved;
            note_starved();
        }
    } else if (state() == State::running && runner_.on_path()) {
        (void)supervisor_.post(Event::path_begin);
    } else if (state() == State::marking && !runner_.on_path()) {
        (void)supervisor_.post(Event::path_end);
    } else if (state() == State::running && runner_.job_done()) {
        (void)supervisor_.post(Event::job_done);
        end_job();
    }
}

void Controller::advance_preview() noexcept {
    if (state() == State::preview_stopping) {
        if (runner_.at_rest()) {
            drop_aborted();
            (void)supervisor_.post(Event::preview_stopped);
        }
    } else if (drop_refused()) {
        return;
    } else if (runner_.starved()) {
        // Nothing burns, so it simply goes on when points have come.
        if (runner_.at_rest() && runner_.can_continue()) {
            note_starved();
            runner_.resume();
        }
    } else if (runner_.job_done()) {
        (void)supervisor_.post(Event::preview_done);
        end_job();
    }
}

/// An item of the job was refused: the job ends as by an abort.
bool Controller::drop_refused() noexcept {
    const ItemRefusal& refusal = runner_.refusal();
    if (refusal.refusal == Refusal::none && link_.job_refusal() == Refusal::none) {
        return false;
    }
    if (refusal.refusal != Refusal::none) {
        link_.refuse_item(refusal.item, refusal.refusal, refusal.axis, refusal.value);
    }
    const Refusal why = refusal.refusal != Refusal::none ? refusal.refusal : link_.job_refusal();
    if (abort().refusal == Refusal::none) {
        note(link::BlackboxKind::item_refused, refusal.axis, static_cast<std::uint16_t>(why));
    }
    return true;
}

void Controller::end_job() noexcept {
    job_done_ = true;
    close_job();
    runner_.drop();
}

/// At rest after an abort. A refused job stays open on the link, so that its refusal is repeated.
void Controller::drop_aborted() noexcept {
    if (link_.job_refusal() == Refusal::none) {
        close_job();
    }
    job_open_ = job_started_ = false;
    runner_.drop();
}

void Controller::close_job() noexcept {
    if (job_started_) {
        link_.progress(runner_.planned(), runner_.fired(), runner_.fired_position());
        fired_.tick(job_burns_ ? JobPlace{runner_.fired(), runner_.fired_position()} : fired_.record().reached, false);
    }
    link_.close_job();
    job_open_ = job_started_ = false;
}

void Controller::advance_stop() noexcept {
    if (!runner_.at_rest()) {
        return;
    }
    if (stop_reason_ == Event::abort) {
        drop_aborted();
        (void)supervisor_.post(Event::stopped_abort);
    } else if (stop_reason_ == Event::link_silent) {
        (void)supervisor_.post(Event::stopped_link);
    } else {
        (void)supervisor_.post(Event::stopped_held);
    }
}

void Controller::gate(const ServoInputs& in, ServoOutputs& out) noexcept {
    const bool pulses = out.laser_size > 0;
    if (pulses) {
        safety::MarkContext context;
        context.state = state();
        context.mark_segment = runner_.on_path() && !suspicion_;
        context.mo_ready = mo_.ready();
        context.interlocks_closed = in.digital.estop_closed && in.digital.interlock_closed;
        context.laser_healthy = laser_healthy(in.digital);
        context.galvo_healthy = in.galvo_status == kGalvoStatusOk;
        context.shutter_open = shutter_.proven_open();
        context.key_production = key_mode(in.digital) == KeyMode::production;
        context.faults = supervisor_.faults();
        context.path_speed = Speed::from_si(runner_.pulse_speed() * 1.001);
        context.path_speed_min = machine_.laser.mark_speed_min;
        if (!safety::gate_permitted(context)) {
            out.laser_size = 0;
            out.pulses_size = 0;
            if (supervisor_.faults() == 0 && !suspicion_) {
                trip(Fault::mark_rule, safety::kNoAxis, in.tick);
            }
        }
    }
    // The window of the last tick's pulses begins only now: the guard must let them pass.
    out.gate_allowed = (out.laser_size > 0 || pulses_before_) && supervisor_.faults() == 0 && !suspicion_;
    pulses_before_ = out.laser_size > 0;
    for (std::size_t i = 0; i < out.laser_size; ++i) {
        pulses_total_ += out.laser[i].count;
    }
    out.cancel_laser = cancel_ || state() == State::fault;
    cancel_ = false;
    latch_power(out);
}

/// The byte is 0 while the master oscillator is off; else each run has its own.
void Controller::latch_power(ServoOutputs& out) noexcept {
    out.clear_power = !mo_.on();
    if (out.cancel_laser) {
        power_.forget();
    }
    if (out.clear_power) {
        power_.cleared();
    }
    power_.step(std::span(out.laser).first(out.laser_size));
}

void Controller::lines(ServoOutputs& out) noexcept {
    shutter_open_ = safety::shutter_state(state());
    out.digital.master_oscillator = mo_.on();
    out.digital.shutter_open = shutter_open_;
    out.digital.guide_laser =
        (safety::guide_state(state()) && runner_.on_line()) || (pointing_ && safety::pointing_state(state()));
    out.digital.light_red = state() == State::fault;
    out.digital.light_yellow = safety::mo_state(state());
    out.digital.light_green = state() == State::idle || state() == State::armed;
}

void Controller::follow_drives() noexcept {
    AxisPositions stand = runner_.set_point();
    bool changed = false;
    for (std::size_t i = 0; i < kAxisCount; ++i) {
        if (!drives_seen_.axis[i].follows) {
            stand[i] = drives_seen_.axis[i].actual;
            changed = true;
        }
    }
    if (changed) {
        runner_.stand_at(stand);
    }
}

void Controller::drive(const ServoInputs& in, ServoOutputs& out) noexcept {
    drives::Request request;
    const bool stopping_in_fault = state() == State::fault && !runner_.at_rest();
    // Where an encoder may lie no ramp can be trusted: the power goes at once. Other faults of the axes end in the
    // drives' own ramp.
    constexpr std::uint64_t kBlind = fault_bit(Fault::following_error) | fault_bit(Fault::encoder_frozen);
    constexpr std::uint64_t kByDrives = fault_bit(Fault::drive_fault) | fault_bit(Fault::drive_lost) |
                                        fault_bit(Fault::homing_failed) | fault_bit(Fault::soft_limit) |
                                        fault_bit(Fault::keep_out) | fault_bit(Fault::turn_not_retracted) |
                                        fault_bit(Fault::arithmetic_state) | fault_bit(Fault::planner_late);
    const bool blind = (supervisor_.faults() & kBlind) != 0;
    request.quick_stop = !blind && (supervisor_.faults() & kByDrives) != 0;
    request.power = safety::powered_state(state()) || (stopping_in_fault && !request.quick_stop && !blind);
    request.home = state() == State::homing;
    request.home_axes = request.home ? home_axes(home_stage_) : std::uint8_t{0};
    request.reset = reset_drives_;
    reset_drives_ = false;
    request.target = runner_.set_point();
    drives_seen_ = drives_.step(in.tick, in.drive_rx, request, out);
}

/// For mirrors that follow the axes. Ahead of the drives' own step, which would tell a tick later.
void Controller::measure_axes(const ServoInputs& in) noexcept {
    AxisSample sample;
    if (machine_.galvo.follow == FollowAxes::drives) {
        std::int64_t t_tick = 0;
        if (drives_.measured(in.tick, in.drive_rx, sample.place, t_tick)) {
            sample.t_ns = t_tick * machine_.control_period_ns;
            runner_.take_axes(sample);
        }
    } else if (machine_.galvo.follow == FollowAxes::encoders && in.encoders.valid) {
        for (std::size_t i = 0; i < kAxisCount; ++i) {
            const double counts = machine_.axis[i].encoder_counts_per_unit;
            const double unit = i == index(Axis::c) ? kNdegPerDegree : kPmPerMetre;
            sample.place[i] =
                counts > 0.0 ? rounded(exact_double(in.encoders.counts[i]) * (unit / counts)) : std::int64_t{0};
        }
        sample.t_ns = in.tick * machine_.control_period_ns - in.encoders.age_ns;
        runner_.take_axes(sample);
    }
}

void Controller::servo_step(const ServoInputs& in, ServoOutputs& out) noexcept {
    out.link_tx_size = out.drive_tx_size = out.laser_size = out.pulses_size = out.source_tx_size = 0;
    tick_ = in.tick;
    link_.receive(in.tick, in.link_rx);
    take_events(in);
    keep_parameters();
    speak_to_source(in, out);
    sense(in, out);
    watch_inputs(in);
    watch_drives(in);
    watch_link(in);
    try_reset(in);
    advance_states();
    const bool arming = state() == State::arming;
    warned_ticks_ = arming ? warned_ticks_ + 1 : 0;
    if (!arming) {
        head_.restart();
    }
    // Light may come only after its warning, through a head that is there, and once the shutter has proven that it
    // obeys: it opens during the warning, while there is nothing to let through.
    const bool warned = warned_ticks_ * machine_.control_period_ns > machine_.laser.warning_ns;
    mo_.step(state(), !arming || (warned && head_.proven() && shutter_.proven_open()));

    measure_axes(in);
    const AxisPositions before = runner_.set_point();
    if (!runner_.step(in.tick, link_.items(), state() == State::marking, out)) {
        trip(Fault::planner_late, safety::kNoAxis, in.tick);
    }
    if (arming) {
        head_.step(in.galvo_status, out.galvo);
    }
    if (runner_.at_rest()) {
        follow_drives();
    }
    watch_set_points(before, in.tick);
    watch_surface(in.tick);
    gate(in, out);
    lines(out);
    drive(in, out);
    report(in, out);
}

}  // namespace sc

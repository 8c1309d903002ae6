// SPDX-License-Identifier: Apache-2.0
#include "firmware/controller/controller.hpp"

#include "shared/math/scalar.hpp"

namespace sc {
namespace {

using safety::Event;

constexpr std::int64_t kStatusEveryTicks = 20;
constexpr std::int64_t kResetPatienceTicks = 500;
constexpr std::int64_t kStaleDriveTicks = 4;  ///< two drive cycles without an answer
constexpr double kJogLargest = 0.010;         ///< m in one step
constexpr double kJogLargestTurn = 10.0;      ///< degrees
constexpr double kJogFastest = 0.05;          ///< m/s
constexpr double kJogFastestTurn = 20.0;      ///< °/s

bool finite(double v) noexcept { return v >= -1e300 && v <= 1e300; }

constexpr std::uint8_t axis_bit(Axis axis) noexcept { return static_cast<std::uint8_t>(1U << index(axis)); }

/// Axes that a stage of homing moves: y first, so that x, z and C turn in the clear.
constexpr std::uint8_t home_axes(std::uint8_t stage) noexcept {
    return stage == 0 ? axis_bit(Axis::y)
                      : (stage == 1 ? static_cast<std::uint8_t>(axis_bit(Axis::x) | axis_bit(Axis::z)) : axis_bit(Axis::c));
}

}  // namespace

Controller::Controller(const MachineConfig& machine, std::uint32_t boot_id) noexcept
    : machine_(machine),
      link_(machine, boot_id),
      drives_(machine_),
      mo_(machine.laser.mo_wait_ns, machine.control_period_ns),
      following_(machine_),
      runner_(machine) {}

bool Controller::homed() const noexcept {
    for (const drives::AxisStatus& axis : drives_seen_.axis) {
        if (!axis.homed) {
            return false;
        }
    }
    return true;
}

// --- what the host asks ---------------------------------------------------------------------------------------------------

void Controller::take_events(const ServoInputs& in) noexcept {
    link::LinkEvent event;
    while (link_.poll(event)) {
        switch (event.kind) {
            case link::LinkEvent::Kind::none:
            case link::LinkEvent::Kind::session_resumed: break;
            case link::LinkEvent::Kind::session_open:
                // Nothing of another host's session goes on by itself.
                (void)abort();
                break;
            case link::LinkEvent::Kind::command: {
                const auto verb = static_cast<link::Verb>(event.command.verb);
                if (verb == link::Verb::reset_fault && state() == State::fault) {
                    reset_wanted_ = true;
                    reset_drives_ = true;
                    reset_sequence_ = event.command.sequence;
                    reset_deadline_ = in.tick + kResetPatienceTicks;
                    break;
                }
                const Verdict verdict = decide(event.command, in);
                link_.reply(event.command.sequence, verdict.refusal, verdict.detail);
                break;
            }
            case link::LinkEvent::Kind::job_open: {
                const Verdict verdict = open(event.job_open);
                link_.reply(event.job_open.sequence, verdict.refusal, verdict.detail);
                break;
            }
            case link::LinkEvent::Kind::compensation: {
                const Verdict verdict = set_compensation(event.compensation);
                link_.reply(event.compensation.sequence, verdict.refusal, verdict.detail);
                break;
            }
        }
    }
}

Controller::Verdict Controller::post(Event event) noexcept {
    if (supervisor_.post(event)) {
        return {};
    }
    return {Refusal::wrong_state, static_cast<std::int64_t>(state())};
}

Controller::Verdict Controller::decide(const link::Command& command, const ServoInputs& in) noexcept {
    switch (static_cast<link::Verb>(command.verb)) {
        case link::Verb::enable:
            if (!in.digital.estop_closed) {
                return {Refusal::estop_open, 0};
            }
            return post(Event::enable);
        case link::Verb::disable: return post(Event::disable);
        case link::Verb::home:
            if (!runner_.at_rest()) {
                return {Refusal::wrong_state, static_cast<std::int64_t>(state())};
            }
            home_stage_ = 0;
            return post(Event::home);
        case link::Verb::arm: return arm(in);
        case link::Verb::disarm: return post(Event::disarm);
        case link::Verb::start: {
            if (!job_open_) {
                return {Refusal::job_mismatch, 0};
            }
            const Verdict verdict = post(Event::start);
            if (verdict.refusal == Refusal::none) {
                job_done_ = false;
                runner_.start_job();
            }
            return verdict;
        }
        case link::Verb::hold: {
            const Verdict verdict = post(Event::hold);
            if (verdict.refusal == Refusal::none) {
                stop_reason_ = Event::hold;
                runner_.request_stop();
            }
            return verdict;
        }
        case link::Verb::resume: {
            const Verdict verdict = post(state() == State::held_link ? Event::link_back : Event::resume);
            if (verdict.refusal == Refusal::none) {
                runner_.resume();
            }
            return verdict;
        }
        case link::Verb::abort: return abort();
        case link::Verb::reset_fault: return {Refusal::wrong_state, static_cast<std::int64_t>(state())};
        case link::Verb::jog: return jog(command);
        case link::Verb::stop: {
            const Verdict verdict = post(Event::stop);
            if (verdict.refusal == Refusal::none) {
                runner_.request_stop();
            }
            return verdict;
        }
    }
    return {Refusal::unknown_command, command.verb};
}

Controller::Verdict Controller::arm(const ServoInputs& in) noexcept {
    if (!supervisor_.allowed(Event::arm)) {
        return {Refusal::wrong_state, static_cast<std::int64_t>(state())};
    }
    if (!homed()) {
        return {Refusal::not_homed, 0};
    }
    if (!in.digital.estop_closed) {
        return {Refusal::estop_open, 0};
    }
    if (!in.digital.interlock_closed) {
        return {Refusal::interlock_open, 0};
    }
    if (!in.digital.laser_ready || !in.digital.laser_no_alarm) {
        return {Refusal::laser_not_ready, 0};
    }
    if (machine_.galvo.convention == GalvoConvention::unset) {
        return {Refusal::galvo_convention_unset, 0};
    }
    return post(Event::arm);
}

Controller::Verdict Controller::jog(const link::Command& command) noexcept {
    if (!supervisor_.allowed(Event::jog) || !runner_.at_rest()) {
        return {Refusal::wrong_state, static_cast<std::int64_t>(state())};
    }
    if (command.arg0 < 0 || command.arg0 >= static_cast<std::int32_t>(kAxisCount)) {
        return {Refusal::unknown_command, command.arg0};
    }
    if (!homed()) {
        return {Refusal::not_homed, 0};
    }
    const auto axis = static_cast<Axis>(command.arg0);
    const bool turn = axis == Axis::c;
    const double distance = static_cast<double>(command.arg1) / (turn ? kWireUnitsPerDegree : kWireUnitsPerMetre);
    const double speed = static_cast<double>(command.arg2) * (turn ? 1e-3 : 1e-6);
    if (!(speed > 0.0 && speed <= (turn ? kJogFastestTurn : kJogFastest))) {
        return {Refusal::bad_speed, command.arg0};
    }
    AxisPositions end = runner_.set_point();
    end[index(axis)] += rounded(distance * (turn ? kNdegPerDegree : kPmPerMetre));
    const bool retracted =
        static_cast<double>(end[index(Axis::y)]) / kPmPerMetre >= machine_.y_retracted.si() - 1e-6;
    if (absolute(distance) > (turn ? kJogLargestTurn : kJogLargest) || (turn && !retracted) ||
        safety::check_travel(machine_, end) || safety::check_keep_out(machine_, runner_.set_point(), end)) {
        return {Refusal::jog_out_of_range, command.arg0};
    }
    runner_.start_jog(axis, distance, speed);
    return post(Event::jog);
}

Controller::Verdict Controller::abort() noexcept {
    const bool at_rest = state() == State::held || state() == State::held_link;
    const Verdict verdict = post(Event::abort);
    if (verdict.refusal == Refusal::none) {
        stop_reason_ = Event::abort;
        if (at_rest) {
            runner_.drop();
        } else {
            runner_.request_stop();
        }
        job_open_ = false;
    }
    return verdict;
}

Controller::Verdict Controller::open(const link::JobOpen& job) noexcept {
    if ((state() != State::idle && state() != State::armed) || !runner_.at_rest()) {
        return {Refusal::wrong_state, static_cast<std::int64_t>(state())};
    }
    link_.open_job(job.job, job.items);
    job_open_ = true;
    job_done_ = false;
    job_items_ = job.items;
    runner_.drop();
    return {};
}

Controller::Verdict Controller::set_compensation(const link::SetCompensation& m) noexcept {
    if ((state() != State::boot && state() != State::disabled && state() != State::idle) || !runner_.at_rest()) {
        return {Refusal::wrong_state, static_cast<std::int64_t>(state())};
    }
    Compensation c;
    for (std::size_t i = 0; i < 3; ++i) {
        c.axis_from_h.row[i] = {m.axis_matrix[3 * i], m.axis_matrix[3 * i + 1], m.axis_matrix[3 * i + 2]};
    }
    c.axis_offset = {m.axis_offset[0], m.axis_offset[1], m.axis_offset[2]};
    c.galvo_from_field = m.galvo_matrix;
    c.galvo_offset = m.galvo_offset;
    // A compensation is a small correction: far from identity it is a mistake, and dangerous.
    constexpr double kLargestCorrection = 0.02;
    constexpr double kLargestOffset = 2e-3;
    for (std::size_t i = 0; i < 9; ++i) {
        const double identity = i % 4 == 0 ? 1.0 : 0.0;
        if (!finite(m.axis_matrix[i]) || absolute(m.axis_matrix[i] - identity) > kLargestCorrection) {
            return {Refusal::bad_config, static_cast<std::int64_t>(i)};
        }
    }
    for (std::size_t i = 0; i < 4; ++i) {
        const double identity = i % 3 == 0 ? 1.0 : 0.0;
        if (!finite(m.galvo_matrix[i]) || absolute(m.galvo_matrix[i] - identity) > kLargestCorrection) {
            return {Refusal::bad_config, static_cast<std::int64_t>(9 + i)};
        }
    }
    for (const double offset :
         {m.axis_offset[0], m.axis_offset[1], m.axis_offset[2], m.galvo_offset[0], m.galvo_offset[1]}) {
        if (!finite(offset) || absolute(offset) > kLargestOffset) {
            return {Refusal::bad_config, 13};
        }
    }
    runner_.set_compensation(c);
    return {};
}

// --- what goes wrong --------------------------------------------------------------------------------------------------------

void Controller::trip(Fault fault, std::uint8_t axis, std::int64_t tick) noexcept {
    if ((supervisor_.faults() & fault_bit(fault)) != 0) {
        return;
    }
    const bool moving = state() != State::fault;
    supervisor_.trip(fault, axis, tick);
    cancel_ = true;
    if (moving) {
        runner_.request_stop();
    }
}

void Controller::watch_inputs(const ServoInputs& in) noexcept {
    const auto seen = [&](GuardCause cause) noexcept { return (in.guard_causes & static_cast<std::uint8_t>(cause)) != 0; };
    if (safety::powered_state(state()) && (!in.digital.estop_closed || seen(GuardCause::estop))) {
        trip(Fault::estop_open, safety::kNoAxis, in.tick);
    }
    if (safety::mo_state(state())) {
        if (!in.digital.interlock_closed || seen(GuardCause::interlock)) {
            trip(Fault::interlock_open, safety::kNoAxis, in.tick);
        }
        if (!in.digital.laser_ready || !in.digital.laser_no_alarm || seen(GuardCause::laser_alarm)) {
            trip(Fault::laser_alarm, safety::kNoAxis, in.tick);
        }
        if (in.galvo_status != kGalvoStatusOk || seen(GuardCause::galvo)) {
            trip(Fault::galvo_not_ready, safety::kNoAxis, in.tick);
        }
    }
    if (!safety::arithmetic_state_is_right()) {
        trip(Fault::arithmetic_state, safety::kNoAxis, in.tick);
    }
}

void Controller::watch_drives(const ServoInputs& in) noexcept {
    std::uint8_t following = 0;
    AxisPositions actual{};
    for (std::size_t i = 0; i < kAxisCount; ++i) {
        const drives::AxisStatus& axis = drives_seen_.axis[i];
        const auto number = static_cast<std::uint8_t>(i);
        actual[i] = axis.actual;
        if (axis.follows) {
            following = static_cast<std::uint8_t>(following | (1U << i));
        }
        if (state() == State::boot) {
            continue;
        }
        if (!axis.present) {
            trip(Fault::drive_lost, number, in.tick);
        } else if (axis.fault && safety::powered_state(state())) {
            trip(Fault::drive_fault, number, in.tick);
        } else if (axis.homing_failed && state() == State::homing) {
            trip(Fault::homing_failed, number, in.tick);
        }
    }
    stale_ticks_ = drives_seen_.actual_fresh ? 0 : stale_ticks_ + 1;
    if (safety::mo_state(state()) && stale_ticks_ > kStaleDriveTicks) {
        std::uint8_t silent = safety::kNoAxis;
        for (std::size_t i = 0; i < kAxisCount; ++i) {
            silent = drives_seen_.axis[i].follows ? silent : static_cast<std::uint8_t>(i);
        }
        trip(Fault::drive_lost, silent, in.tick);
    }
    if (!safety::powered_state(state()) || state() == State::enabling) {
        following_.restart(actual);
        return;
    }
    const safety::Finding finding = following_.step(runner_.set_point(), actual, following);
    if (finding) {
        trip(finding.fault, finding.axis, in.tick);
    }
}

void Controller::watch_link(const ServoInputs& in) noexcept {
    if (link_.alive(in.tick)) {
        silent_since_ = in.tick;
        return;
    }
    switch (state()) {
        case State::running:
        case State::marking:
        case State::stopping:
            if (stop_reason_ != Event::link_silent || state() != State::stopping) {
                const bool aborting = state() == State::stopping && stop_reason_ == Event::abort;
                if (!aborting && supervisor_.post(Event::link_silent)) {
                    stop_reason_ = Event::link_silent;
                    runner_.request_stop();
                }
            }
            break;
        case State::held:
            (void)supervisor_.post(Event::link_silent);
            break;
        case State::held_link:
            if ((in.tick - silent_since_) * machine_.control_period_ns >= machine_.held_link_timeout_ns) {
                trip(Fault::link_lost, safety::kNoAxis, in.tick);
            }
            break;
        case State::arming:
        case State::armed: (void)supervisor_.post(Event::disarm); break;
        case State::homing:
        case State::jogging:
            runner_.request_stop();
            (void)supervisor_.post(Event::stop);
            break;
        case State::boot:
        case State::disabled:
        case State::enabling:
        case State::idle:
        case State::disabling:
        case State::fault: break;
    }
}

void Controller::watch_set_points(const AxisPositions& before, std::int64_t tick) noexcept {
    if (!drives_seen_.all_follow || state() == State::homing || !homed()) {
        return;
    }
    const AxisPositions& now = runner_.set_point();
    for (const safety::Finding& finding :
         {safety::check_travel(machine_, now), safety::check_keep_out(machine_, before, now),
          safety::check_turn(machine_, before, now)}) {
        if (finding) {
            trip(finding.fault, finding.axis, tick);
        }
    }
}

std::uint64_t Controller::present_faults(const ServoInputs& in) const noexcept {
    std::uint64_t bits = 0;
    const auto add = [&](bool present, Fault fault) noexcept { bits |= present ? fault_bit(fault) : 0; };
    add(!in.digital.estop_closed, Fault::estop_open);
    add((supervisor_.faults() & fault_bit(Fault::interlock_open)) != 0 && !in.digital.interlock_closed,
        Fault::interlock_open);
    add(!in.digital.laser_ready || !in.digital.laser_no_alarm, Fault::laser_alarm);
    add(in.galvo_status != kGalvoStatusOk, Fault::galvo_not_ready);
    for (const drives::AxisStatus& axis : drives_seen_.axis) {
        add(axis.fault, Fault::drive_fault);
        add(!axis.present, Fault::drive_lost);
    }
    return bits;
}

void Controller::try_reset(const ServoInputs& in) noexcept {
    if (!reset_wanted_) {
        return;
    }
    const std::uint64_t present = present_faults(in);
    const bool settled = runner_.at_rest() && drives_seen_.all_disabled;
    if ((present != 0 || !settled) && in.tick < reset_deadline_) {
        return;
    }
    reset_wanted_ = false;
    std::int64_t detail = 0;
    for (unsigned number = 1; number < 64 && detail == 0; ++number) {
        detail = ((present >> number) & 1U) != 0 ? static_cast<std::int64_t>(number) : 0;
    }
    if (present == 0 && !settled) {
        link_.reply(reset_sequence_, Refusal::wrong_state, static_cast<std::int64_t>(state()));
        return;
    }
    const Refusal refusal = supervisor_.reset(present);
    if (refusal == Refusal::none) {
        runner_.drop();
        job_open_ = false;
    }
    link_.reply(reset_sequence_, refusal, detail);
}

// --- what goes on -----------------------------------------------------------------------------------------------------------

void Controller::advance_states(const ServoInputs& in) noexcept {
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
        case State::marking:
            if (runner_.refusal().refusal != Refusal::none || link_.job_refusal() != Refusal::none) {
                const ItemRefusal& refusal = runner_.refusal();
                if (refusal.refusal != Refusal::none) {
                    link_.refuse_item(refusal.item, refusal.refusal, refusal.axis, refusal.value);
                }
                (void)abort();
            } else if (runner_.starved()) {
                if (supervisor_.post(Event::starved)) {
                    stop_reason_ = Event::starved;
                    ++starvations_;
                }
            } else if (state() == State::running && runner_.on_path()) {
                (void)supervisor_.post(Event::path_begin);
            } else if (state() == State::marking && !runner_.on_path()) {
                (void)supervisor_.post(Event::path_end);
            } else if (state() == State::running && runner_.job_done()) {
                (void)supervisor_.post(Event::job_done);
                job_done_ = true;
                runner_.drop();
            }
            break;
        case State::stopping: advance_stop(in.tick); break;
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

void Controller::advance_stop(std::int64_t /*tick*/) noexcept {
    if (!runner_.at_rest()) {
        return;
    }
    if (stop_reason_ == Event::abort) {
        runner_.drop();
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
        context.mark_segment = runner_.on_path();
        context.mo_ready = mo_.ready();
        context.interlocks_closed = in.digital.estop_closed && in.digital.interlock_closed;
        context.laser_healthy = in.digital.laser_ready && in.digital.laser_no_alarm;
        context.galvo_healthy = in.galvo_status == kGalvoStatusOk;
        context.faults = supervisor_.faults();
        context.path_speed = Speed::from_si(runner_.pulse_speed() * 1.001);
        context.path_speed_min = machine_.laser.mark_speed_min;
        if (!safety::gate_permitted(context)) {
            out.laser_size = 0;
            out.pulses_size = 0;
            if (supervisor_.faults() == 0) {
                trip(Fault::mark_rule, safety::kNoAxis, in.tick);
            }
        }
    }
    // The window of the last tick's pulses begins only now: the guard must let them pass.
    out.gate_allowed = (out.laser_size > 0 || pulses_before_) && supervisor_.faults() == 0;
    pulses_before_ = out.laser_size > 0;
    for (std::size_t i = 0; i < out.laser_size; ++i) {
        pulses_total_ += out.laser[i].count;
    }
    out.cancel_laser = cancel_ || state() == State::fault;
    cancel_ = false;
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
    constexpr std::uint64_t kByDrives = fault_bit(Fault::drive_fault) | fault_bit(Fault::drive_lost) |
                                        fault_bit(Fault::following_error) | fault_bit(Fault::encoder_frozen) |
                                        fault_bit(Fault::homing_failed) | fault_bit(Fault::soft_limit) |
                                        fault_bit(Fault::keep_out) | fault_bit(Fault::turn_not_retracted) |
                                        fault_bit(Fault::arithmetic_state) | fault_bit(Fault::planner_late);
    request.quick_stop = (supervisor_.faults() & kByDrives) != 0;
    request.power = safety::powered_state(state()) || (stopping_in_fault && !request.quick_stop);
    request.home = state() == State::homing;
    request.home_axes = request.home ? home_axes(home_stage_) : std::uint8_t{0};
    request.reset = reset_drives_;
    reset_drives_ = false;
    request.target = runner_.set_point();
    drives_seen_ = drives_.step(in.tick, in.drive_rx, request, out);
}

void Controller::servo_step(const ServoInputs& in, ServoOutputs& out) noexcept {
    out.link_tx_size = out.drive_tx_size = out.laser_size = out.pulses_size = 0;
    link_.receive(in.tick, in.link_rx);
    take_events(in);
    watch_inputs(in);
    watch_drives(in);
    watch_link(in);
    try_reset(in);
    advance_states(in);
    mo_.step(state());

    const AxisPositions before = runner_.set_point();
    if (!runner_.step(in.tick, link_.items(), state() == State::marking, out)) {
        trip(Fault::planner_late, safety::kNoAxis, in.tick);
    }
    if (runner_.at_rest()) {
        follow_drives();
    }
    watch_set_points(before, in.tick);
    gate(in, out);
    drive(in, out);
    report(in, out);
}

void Controller::report(const ServoInputs& in, ServoOutputs& out) noexcept {
    link_.progress(runner_.planned(), runner_.fired(), runner_.fired_position());
    const State now = state();
    if (now != reported_state_ || in.tick - report_tick_ >= kStatusEveryTicks) {
        link::Status status;
        status.cell_time_us = static_cast<std::uint64_t>(in.tick * machine_.control_period_ns / 1000);
        status.state = static_cast<std::uint8_t>(now);
        status.faults = supervisor_.faults();
        status.first_fault = static_cast<std::uint8_t>(supervisor_.first_fault().fault);
        status.first_fault_axis = supervisor_.first_fault().axis;
        status.limited_by = static_cast<std::uint8_t>(runner_.limited_by());
        const auto flag = [&](bool on, link::StatusFlag bit) noexcept {
            status.flags = static_cast<std::uint8_t>(status.flags | (on ? static_cast<unsigned>(bit) : 0U));
        };
        flag(homed(), link::kFlagHomed);
        flag(in.digital.estop_closed, link::kFlagEstopClosed);
        flag(in.digital.interlock_closed, link::kFlagInterlockClosed);
        flag(mo_.on(), link::kFlagMasterOscillator);
        flag(out.laser_size > 0, link::kFlagGateOpen);
        flag(job_done_, link::kFlagJobDone);
        for (std::size_t i = 0; i < kAxisCount; ++i) {
            status.actual[i] = static_cast<std::int32_t>(drives_seen_.axis[i].actual / kPmPerWireUnit);
        }
        status.pulses_total = pulses_total_;
        status.starvations = starvations_;
        link_.status(status);
        reported_state_ = now;
        report_tick_ = in.tick;
    }
    out.link_tx_size = link_.transmit(out.link_tx);
    out.set_point = runner_.set_point();
    out.digital.master_oscillator = mo_.on();
    out.digital.light_red = now == State::fault;
    out.digital.light_yellow = safety::mo_state(now);
    out.digital.light_green = now == State::idle || now == State::armed;
    out.state = static_cast<std::uint8_t>(now);
    out.faults = supervisor_.faults();
}

}  // namespace sc

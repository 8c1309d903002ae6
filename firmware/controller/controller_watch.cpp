// SPDX-License-Identifier: Apache-2.0
#include "firmware/controller/controller.hpp"
#include "shared/machine/source_status.hpp"

namespace sc {
namespace {

using safety::Event;

constexpr std::int64_t kStaleDriveTicks = 4;  ///< two drive cycles without an answer

}  // namespace

void Controller::trip(Fault fault, std::uint8_t axis, std::int64_t tick) noexcept {
    if ((supervisor_.faults() & fault_bit(fault)) != 0) {
        return;
    }
    const bool moving = state() != State::fault;
    supervisor_.trip(fault, axis, tick);
    note(link::BlackboxKind::fault, axis, static_cast<std::uint16_t>(fault));
    cancel_ = true;
    if (moving) {
        runner_.request_stop();
    }
}

void Controller::watch_inputs(const ServoInputs& in) noexcept {
    const auto seen = [&](GuardCause cause) noexcept {
        return (in.guard_causes & static_cast<std::uint8_t>(cause)) != 0;
    };
    if (safety::powered_state(state()) && (!in.digital.estop_closed || seen(GuardCause::estop))) {
        trip(Fault::estop_open, safety::kNoAxis, in.tick);
    }
    watch_beam(in);
    watch_source(in);
    if (safety::mo_state(state())) {
        if (!in.digital.interlock_closed || seen(GuardCause::interlock)) {
            trip(Fault::interlock_open, safety::kNoAxis, in.tick);
        }
        // A mirror on its way does not acknowledge; while marking it must.
        const bool head =
            state() == State::marking ? in.galvo_status == kGalvoStatusOk : galvo_healthy(in.galvo_status);
        if (!head || seen(GuardCause::galvo)) {
            trip(Fault::galvo_not_ready, safety::kNoAxis, in.tick);
        }
        if (head_.failed()) {
            trip(Fault::galvo_absent, safety::kNoAxis, in.tick);
        }
    }
    if (!safety::arithmetic_state_is_right()) {
        trip(Fault::arithmetic_state, safety::kNoAxis, in.tick);
    }
}

/// The shutter, and the key that allows the beam.
void Controller::watch_beam(const ServoInputs& in) noexcept {
    const auto seen = [&](GuardCause cause) noexcept {
        return (in.guard_causes & static_cast<std::uint8_t>(cause)) != 0;
    };
    const KeyMode key = key_mode(in.digital);
    const bool wrong = shutter_.wrong(shutter_open_, in.digital);
    if (state() != State::boot && (wrong || (safety::mo_state(state()) && seen(GuardCause::shutter)))) {
        trip(Fault::shutter, safety::kNoAxis, in.tick);
    }
    if (safety::mo_state(state()) && (key != KeyMode::production || seen(GuardCause::key))) {
        trip(Fault::key_turned, safety::kNoAxis, in.tick);
    }
    if (!safety::pointing_state(state()) || guide_allowed(in.digital) != Refusal::none) {
        pointing_ = false;
    }
    if (state() == State::previewing) {
        if (key == KeyMode::off) {
            (void)abort();
        } else if (key == KeyMode::production && !in.digital.interlock_closed) {
            trip(Fault::interlock_open, safety::kNoAxis, in.tick);
        }
    }
}

bool Controller::laser_healthy(const DigitalInputs& in) const noexcept {
    return in.laser_ready && in.laser_no_alarm && may_emit(source_state(machine_.laser.source, in.source_status));
}

/// The source's own word where it has one, else that it is not well.
void Controller::watch_source(const ServoInputs& in) noexcept {
    if (!safety::mo_state(state())) {
        return;
    }
    const Fault alarm = fault_of(source_state(machine_.laser.source, in.digital.source_status));
    if (alarm != Fault::none) {
        trip(alarm, safety::kNoAxis, in.tick);
    } else if (!laser_healthy(in.digital) ||
               (in.guard_causes & static_cast<std::uint8_t>(GuardCause::laser_alarm)) != 0) {
        trip(Fault::laser_alarm, safety::kNoAxis, in.tick);
    }
}

void Controller::watch_drives(const ServoInputs& in) noexcept {
    std::uint8_t following = 0;
    AxisPositions actual{};
    // The frames of this tick, which the drives' own step would tell a tick later.
    const unsigned told = drives_.faults_told(in.drive_rx);
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
        } else if ((axis.fault || ((told >> i) & 1U) != 0) && safety::powered_state(state())) {
            trip(Fault::drive_fault, number, in.tick);
        } else if (!axis.enabled && safety::powered_state(state()) && state() != State::enabling) {
            trip(Fault::drive_fault, number, in.tick);
        } else if (axis.homing_failed && state() == State::homing) {
            trip(Fault::homing_failed, number, in.tick);
        }
    }
    stale_ticks_ = drives_seen_.actual_fresh ? 0 : stale_ticks_ + 1;
    if (safety::mo_state(state()) && stale_ticks_ > kStaleDriveTicks) {
        trip(Fault::drive_lost, suspicion_ ? suspicion_.axis : safety::kNoAxis, in.tick);
    }
    if (!safety::powered_state(state()) || state() == State::enabling) {
        following_.restart(actual);
        suspicion_ = {};
        return;
    }
    const safety::Finding finding = following_.step(runner_.set_point(), actual, following);
    if (finding && !suspicion_) {
        suspicion_ = finding;
        suspicion_tick_ = in.tick;
        cancel_ = true;
    }
    // A drive that has gone silent looks like a frozen encoder until its next answer is due. The light is off
    // meanwhile.
    if (suspicion_ && in.tick - suspicion_tick_ >= kStaleDriveTicks) {
        trip(drives_seen_.actual_fresh ? suspicion_.fault : Fault::drive_lost, suspicion_.axis, in.tick);
    }
}

void Controller::watch_link(const ServoInputs& in) noexcept {
    const bool silent = !link_.alive(in.tick);
    if (silent && !silent_) {
        note(link::BlackboxKind::link_silent);
    }
    silent_ = silent;
    if (!silent) {
        silent_since_ = in.tick;
        return;
    }
    pointing_ = false;
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
        case State::held: (void)supervisor_.post(Event::link_silent); break;
        case State::previewing:
            runner_.request_stop();
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
        case State::preview_stopping:
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
    add((supervisor_.faults() & fault_bit(Fault::key_turned)) != 0 && key_mode(in.digital) != KeyMode::production,
        Fault::key_turned);
    const Fault alarm = fault_of(source_state(machine_.laser.source, in.digital.source_status));
    add(alarm != Fault::none, alarm);
    add(alarm == Fault::none && !laser_healthy(in.digital), Fault::laser_alarm);
    add(!shutter_.agrees(), Fault::shutter);
    add(!galvo_healthy(in.galvo_status), Fault::galvo_not_ready);
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
        close_job();
        runner_.drop();
    }
    link_.reply(reset_sequence_, refusal, detail);
}

}  // namespace sc

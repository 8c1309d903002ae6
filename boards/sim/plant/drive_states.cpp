// SPDX-License-Identifier: Apache-2.0
#include "boards/sim/plant/drive_states.hpp"

namespace sc::sim {
namespace {

using State = DriveStates::State;

constexpr unsigned kSwitchOnBit = 0x01;
constexpr unsigned kVoltageBit = 0x02;
constexpr unsigned kNoQuickStopBit = 0x04;
constexpr unsigned kOperationBit = 0x08;
constexpr unsigned kResetBit = 0x80;

State after_disable_voltage() noexcept { return State::switch_on_disabled; }

State after_quick_stop(State state) noexcept {
    const bool running = state == State::operation_enabled || state == State::quick_stop_active;
    return running ? State::quick_stop_active : State::switch_on_disabled;
}

State after_shutdown(State state) noexcept {
    return state == State::quick_stop_active ? state : State::ready_to_switch_on;
}

State after_switch_on(State state, bool operate) noexcept {
    switch (state) {
        case State::ready_to_switch_on: return State::switched_on;
        case State::switched_on:
        case State::operation_enabled: return operate ? State::operation_enabled : State::switched_on;
        case State::switch_on_disabled:
        case State::quick_stop_active:
        case State::fault_reaction_active:
        case State::fault: return state;
    }
    return state;
}

}  // namespace

bool DriveStates::powered() const noexcept {
    return state_ == State::operation_enabled || state_ == State::quick_stop_active ||
           state_ == State::fault_reaction_active;
}

void DriveStates::control(std::uint16_t word) noexcept {
    const bool reset_bit = (word & kResetBit) != 0;
    const bool reset_edge = reset_bit && !reset_bit_;
    reset_bit_ = reset_bit;
    if (state_ == State::fault_reaction_active) {
        return;
    }
    if (state_ == State::fault) {
        state_ = reset_edge ? State::switch_on_disabled : state_;
        return;
    }
    if ((word & kVoltageBit) == 0) {
        state_ = after_disable_voltage();
    } else if ((word & kNoQuickStopBit) == 0) {
        state_ = after_quick_stop(state_);
    } else if ((word & kSwitchOnBit) == 0) {
        state_ = after_shutdown(state_);
    } else {
        state_ = after_switch_on(state_, (word & kOperationBit) != 0);
    }
}

void DriveStates::trip() noexcept {
    if (state_ != State::fault) {
        state_ = powered() ? State::fault_reaction_active : State::fault;
    }
}

void DriveStates::ramp_ended() noexcept {
    if (state_ == State::quick_stop_active) {
        state_ = State::switch_on_disabled;
    } else if (state_ == State::fault_reaction_active) {
        state_ = State::fault;
    }
}

std::uint16_t DriveStates::status_bits() const noexcept {
    constexpr std::uint16_t kAlways = 0x0210;
    switch (state_) {
        case State::switch_on_disabled: return kAlways | 0x60;
        case State::ready_to_switch_on: return kAlways | 0x21;
        case State::switched_on: return kAlways | 0x23;
        case State::operation_enabled: return kAlways | 0x27;
        case State::quick_stop_active: return kAlways | 0x07;
        case State::fault_reaction_active: return kAlways | 0x0F;
        case State::fault: return kAlways | 0x08;
    }
    return kAlways;
}

}  // namespace sc::sim

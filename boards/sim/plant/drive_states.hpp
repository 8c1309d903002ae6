// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

namespace sc::sim {

/// CiA 402 power state machine of the simulated drive, written from the standard's diagram and without a look at the
/// master. A drive of this kind makes one transition a controlword.
class DriveStates {
public:
    enum class State : std::uint8_t {
        switch_on_disabled,
        ready_to_switch_on,
        switched_on,
        operation_enabled,
        quick_stop_active,
        fault_reaction_active,
        fault,
    };

    [[nodiscard]] State state() const noexcept { return state_; }
    /// The motor carries current.
    [[nodiscard]] bool powered() const noexcept;

    void reset() noexcept { *this = DriveStates{}; }
    /// A controlword that becomes effective.
    void control(std::uint16_t word) noexcept;
    /// Something went wrong: fault reaction if the motor runs, else straight to fault.
    void trip() noexcept;
    /// The ramp of a quick stop or of a fault reaction has come to its end.
    void ramp_ended() noexcept;

    /// Bits 0..3, 5, 6 (state), 4 (voltage) and 9 (remote).
    [[nodiscard]] std::uint16_t status_bits() const noexcept;

private:
    State state_ = State::switch_on_disabled;
    bool reset_bit_ = false;
};

}  // namespace sc::sim

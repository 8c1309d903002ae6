// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "firmware/safety/transitions.hpp"
#include "shared/codes/codes.hpp"

namespace sc::safety {

inline constexpr std::uint8_t kNoAxis = 0xFF;

/// The first fault since the last reset, and where the cell was then.
struct FaultRecord {
    Fault fault = Fault::none;
    std::uint8_t axis = kNoAxis;  ///< index of the axis, kNoAxis if none
    State state = State::boot;    ///< the state that the fault ended
    std::int64_t tick = 0;
};

/// Holds the one state of the cell and is its only writer. Control tick context; every call O(rows of the table).
class Supervisor {
public:
    [[nodiscard]] State state() const noexcept { return state_; }
    [[nodiscard]] bool allowed(Event event) const noexcept { return next_state(state_, event).allowed; }

    /// Moves by the table. False: the event does not fit the state, nothing has changed. `trip` and `reset` are always
    /// refused here, since they carry more than the event.
    [[nodiscard]] bool post(Event event) noexcept;

    /// Latches the fault and moves to `fault`; the first one since the last reset is kept with its context.
    /// `Fault::none` is a programming mistake and is ignored.
    void trip(Fault fault, std::uint8_t axis, std::int64_t tick) noexcept;

    /// Leaves `fault` for `disabled` and clears the latch. Refused with `wrong_state` elsewhere and with
    /// `fault_present` while `still_present` (bits as in `faults()`) names any cause that is there now.
    [[nodiscard]] Refusal reset(std::uint64_t still_present) noexcept;

    /// Latched faults, `fault_bit` each.
    [[nodiscard]] std::uint64_t faults() const noexcept { return faults_; }
    [[nodiscard]] const FaultRecord& first_fault() const noexcept { return first_fault_; }

private:
    State state_ = State::boot;
    std::uint64_t faults_ = 0;
    FaultRecord first_fault_{};
};

}  // namespace sc::safety

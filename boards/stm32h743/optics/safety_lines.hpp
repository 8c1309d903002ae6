// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <cstdint>

/// E-stop (PE7) and interlock (PE8): high = closed = healthy, pulled down, so that a broken wire reads as open. Each
/// edge interrupts (EXTI, lines 7 and 8), and TIM7 interrupts 10 000 times a second for the guard, which asks for the
/// levels as well: an edge that is lost costs a period of the guard at most.
///
/// An opening shorter than the time to the interrupt is kept until the guard has seen it.

namespace sc::stm32h743 {

class SafetyLines {
public:
    struct State {
        bool estop_closed = false;
        bool interlock_closed = false;
    };
    static constexpr std::uint32_t kGuardHz = 10'000;

    /// Both lines and the guard's timer. False: a set-up register did not take what was written.
    [[nodiscard]] bool start() noexcept;
    /// Interrupt of EXTI lines 5 to 9. What the lines are now; false in it: open, or an edge came whose reason is gone.
    State edge() noexcept;
    /// Interrupt of TIM7: the guard's inputs. Open also when a line was open, if ever so short, since the last call.
    [[nodiscard]] State guard_period() noexcept;

private:
    std::atomic<std::uint32_t> opened_{~0U};  ///< lines that were open since the last period, bits as in the port
};

}  // namespace sc::stm32h743

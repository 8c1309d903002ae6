// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>

#include "boards/stm32h743/system/clock_plan.hpp"

/// Who may break into whom, how often, for how long, and what it may call. That all of them are done in time is proven
/// here, by response times: the cost, what more urgent contexts take meanwhile, and the longest time without
/// interrupts. Costs are bounds to keep, in cycles at 480 MHz with two cycles an instruction; not measured on the chip.

namespace sc::stm32h743 {

inline constexpr int kPendSv = -2;   ///< as the core's headers count exceptions: vector 14
inline constexpr int kThread = -15;  ///< no interrupt

struct Context {
    std::string_view name;  ///< of its handler
    int number;
    std::uint8_t priority;      ///< 0 is the most urgent; equal ones wait for one another
    std::uint32_t period_ns;    ///< at least so long from one to the next
    std::uint32_t cost_cycles;  ///< at most
    std::uint32_t deadline_ns;  ///< from the event
    std::string_view calls;
};

inline constexpr std::array kContexts{
    // E-stop and interlock; each line is filtered outside to 10 kHz.
    Context{"exti9_5_isr", 23, 1, 50'000, 500, 10'000, "SafetyLines::edge, GateWave::shut"},
    // The guard between ticks.
    Context{"tim7_isr", 55, 2, 100'000, 1'500, 50'000, "SafetyLines, GalvoWave::check, frame_guard, GateWave"},
    // The galvo's buffers swap: a new tick. Has to be there before the buffer after it is due.
    Context{"dma1_stream0_isr", 11, 3, 1'000'000, 1'000, 100'000, "GalvoWave::swapped; asks for PendSV"},
    // A byte of a sensor at 230 400 baud; the receiver holds one more.
    Context{"usart2_isr", 38, 4, 43'400, 300, 43'000, "SensorPort::on_interrupt"},
    Context{"usart6_isr", 71, 4, 43'400, 300, 43'000, "SensorPort::on_interrupt"},
    // A byte of the source at 57 600 baud.
    Context{"uart4_isr", 52, 4, 173'000, 300, 170'000, "the source's port"},
    // The shortest frames at 1 Mbit/s; the receive FIFO holds ten of them and more.
    Context{"fdcan1_it0_isr", 19, 5, 47'000, 1'500, 400'000, "Fdcan"},
    Context{"fdcan2_it0_isr", 20, 5, 47'000, 1'500, 400'000, "Fdcan, time stamps of SYNC"},
    // The host's line falls silent after bytes.
    Context{"usart3_isr", 39, 6, 500'000, 2'000, 500'000, "HostUart"},
    // servo_step: its frames are filled 150 us before their buffer is due.
    Context{"pendsv_isr", kPendSv, 14, 1'000'000, 120'000, 850'000,
            "the controller's servo_step and the board's ports"},
    // plan_step: ready by the next tick, or fault 11.
    Context{"plan_step", kThread, 255, 1'000'000, 120'000, 1'000'000,
            "PathMotion::work, SealGate::work; flash, one step"},
};

/// Stacking with the FPU's registers, fetching the vector, and back.
inline constexpr std::uint32_t kEntryCycles = 60;
/// Longest stretch with interrupts off.
inline constexpr std::uint32_t kMaskedNs = 1'000;

[[nodiscard]] constexpr std::uint64_t cost_ns(const Context& one) noexcept {
    return (std::uint64_t{one.cost_cycles} + kEntryCycles) * 1'000 / (kFast.core_hz / kMhz) + 1;
}

/// Load of all contexts together, in 1/1000.
[[nodiscard]] constexpr std::uint64_t load_per_mille() noexcept {
    std::uint64_t sum = 0;
    for (const Context& one : kContexts) {
        sum += (cost_ns(one) * 1'000 + one.period_ns - 1) / one.period_ns;
    }
    return sum;
}

/// From its event to its end at the worst, when everything that can delay it comes at once; 0 when there is no end.
[[nodiscard]] constexpr std::uint64_t response_ns(std::size_t index) noexcept {
    const Context& own = kContexts[index];
    std::uint64_t response = cost_ns(own);
    for (int i = 0; i < 1'000; ++i) {
        std::uint64_t next = kMaskedNs + cost_ns(own);
        for (std::size_t k = 0; k < kContexts.size(); ++k) {
            const Context& other = kContexts[k];
            if (k != index && other.priority <= own.priority) {
                next += (response + other.period_ns - 1) / other.period_ns * cost_ns(other);
            }
        }
        if (next == response) {
            return response;
        }
        response = next;
    }
    return 0;
}

[[nodiscard]] constexpr bool all_in_time() noexcept {
    for (std::size_t i = 0; i < kContexts.size(); ++i) {
        const std::uint64_t response = response_ns(i);
        if (response == 0 || response > kContexts[i].deadline_ns ||
            kContexts[i].deadline_ns > kContexts[i].period_ns * 10ULL) {
            return false;
        }
    }
    return true;
}

[[nodiscard]] constexpr bool contexts_are_distinct() noexcept {
    for (std::size_t i = 0; i < kContexts.size(); ++i) {
        for (std::size_t k = i + 1; k < kContexts.size(); ++k) {
            if (kContexts[i].number == kContexts[k].number || kContexts[i].name == kContexts[k].name ||
                kContexts[i].priority > kContexts[k].priority) {
                return false;
            }
        }
    }
    return true;
}
static_assert(contexts_are_distinct(), "and in the order of their priority");
static_assert(load_per_mille() < 1'000);
static_assert(load_per_mille() < 800, "room for what the costs do not know yet");
static_assert(all_in_time());
static_assert(kContexts.front().priority > 0, "0 is for the warning of the window watchdog alone");

/// Priorities of all contexts, the faults above them; nothing is enabled, nothing is pending. At the start.
void prepare_interrupts() noexcept;
/// After the driver behind it has started. False: it is not in the table.
[[nodiscard]] bool enable_interrupt(int number) noexcept;
/// For the watchdog's warning, number 0.
void enable_warning() noexcept;
/// servo_step runs when nothing more urgent does. Any context.
void ask_for_servo_step() noexcept;

}  // namespace sc::stm32h743

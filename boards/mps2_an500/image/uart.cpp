// SPDX-License-Identifier: Apache-2.0
#include "boards/mps2_an500/image/uart.hpp"

#include <array>
#include <atomic>

#include "boards/mps2_an500/image/registers.hpp"

namespace sc::mps2_an500 {
namespace {

constexpr std::size_t kRingBytes = 2048;

// One writer (the interrupt), one reader. The counters only grow; their difference is what is in the ring.
std::array<std::uint8_t, kRingBytes> ring;
std::atomic<std::uint32_t> written = 0;
std::atomic<std::uint32_t> taken = 0;
std::atomic<std::uint32_t> lost = 0;

}  // namespace

void uart_start(std::uint32_t baud) noexcept {
    uart_divider() = kCoreClockHz / baud;
    uart_control() = kUartTransmitEnable | kUartReceiveEnable | kUartReceiveInterruptEnable;
    interrupt_enable() = 1U << kUart0ReceiveInterrupt;
}

std::size_t uart_take(std::span<std::uint8_t> out) noexcept {
    const std::uint32_t end = written.load(std::memory_order_acquire);
    std::uint32_t place = taken.load(std::memory_order_relaxed);
    std::size_t count = 0;
    while (place != end && count < out.size()) {
        out[count++] = ring[place++ % kRingBytes];
    }
    taken.store(place, std::memory_order_release);
    return count;
}

bool uart_try_send(std::uint8_t byte) noexcept {
    if ((uart_state() & kUartTransmitFull) != 0) {
        return false;
    }
    uart_data() = byte;
    return true;
}

std::uint32_t uart_lost() noexcept { return lost.load(std::memory_order_relaxed); }

void uart_receive_isr() noexcept {
    uart_interrupts() = kUartReceiveInterruptClear;
    while ((uart_state() & kUartReceiveFull) != 0) {
        const auto byte = static_cast<std::uint8_t>(uart_data());
        const std::uint32_t place = written.load(std::memory_order_relaxed);
        if (place - taken.load(std::memory_order_acquire) == kRingBytes) {
            lost.store(lost.load(std::memory_order_relaxed) + 1, std::memory_order_relaxed);
            continue;
        }
        ring[place % kRingBytes] = byte;
        written.store(place + 1, std::memory_order_release);
    }
}

}  // namespace sc::mps2_an500

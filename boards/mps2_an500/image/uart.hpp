// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

/// UART0: received by interrupt into a ring, sent byte by byte by whoever waits for the next tick.

namespace sc::mps2_an500 {

/// Enables the UART at `baud` (16 bit of divider: 382 bits/s to 1.5 Mbit/s) and its receive interrupt.
void uart_start(std::uint32_t baud) noexcept;
/// Moves what has arrived to the start of `out`; returns how many bytes.
[[nodiscard]] std::size_t uart_take(std::span<std::uint8_t> out) noexcept;
/// Sends a byte if the transmitter has room; false if not.
[[nodiscard]] bool uart_try_send(std::uint8_t byte) noexcept;
/// Bytes lost because nobody took them in time.
[[nodiscard]] std::uint32_t uart_lost() noexcept;
/// Interrupt context; some 20 instructions a byte.
void uart_receive_isr() noexcept;

}  // namespace sc::mps2_an500

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

namespace sc::stm32h743 {

struct UartCounters {
    std::uint32_t bytes_in = 0;
    std::uint32_t bytes_out = 0;  ///< handed to DMA
    std::uint32_t unsent = 0;     ///< bytes that found no room
    std::uint32_t laps = 0;       ///< times that the ring was full before it was read: its bytes are lost
    // Calls of receive that found the flag: one error or more each.
    std::uint32_t overruns = 0;  ///< DMA came too late for a byte
    std::uint32_t framing = 0;
    std::uint32_t noise = 0;
    std::uint32_t dma_errors = 0;
};

/// The host's link on USART3 (the ST-Link's serial port), 8N1, with DMA1: stream 2 fills a ring, stream 3 sends from
/// two buffers in turn. Wants the kernel clock (120 MHz) selected and the pins set. One context at a time; receive and
/// send once a tick each.
class HostUart {
public:
    static constexpr std::uint32_t kKernelHz = 120'000'000;
    static constexpr std::size_t kIn = 4096;   ///< 13 ms at 3 Mbaud
    static constexpr std::size_t kOut = 2048;  ///< two ticks of what the controller can say
    static constexpr std::uint32_t kSlowest = 9'600;
    static constexpr std::uint32_t kFastest = 3'000'000;

    /// Lies where DMA1 reaches and no cache is: SRAM1 to SRAM3.
    struct Memory {
        std::array<std::uint8_t, kIn> in;
        std::array<std::array<std::uint8_t, kOut>, 2> out;
    };
    enum class Start : std::uint8_t {
        ok,
        bad_rate,
        stream_runs,  ///< a DMA stream did not stop
        silent,       ///< transmitter and receiver did not come up: no clock
    };

    explicit HostUart(Memory& memory) noexcept : memory_(memory) {}

    /// Some 100 us at most; may be called again.
    [[nodiscard]] Start start(std::uint32_t baud) noexcept;
    /// What has come since the last call, as far as there is room; how many. The rest waits.
    [[nodiscard]] std::size_t receive(std::span<std::uint8_t> out) noexcept;
    /// Sends what waits, and then these. What finds no room is dropped and counted.
    void send(std::span<const std::uint8_t> bytes) noexcept;
    /// Asks for an interrupt when the line falls silent after bytes.
    void use_interrupt() noexcept;
    /// To be called by its handler. True: the line fell silent.
    [[nodiscard]] bool acknowledge() noexcept;
    [[nodiscard]] const UartCounters& counters() const noexcept { return counters_; }

private:
    [[nodiscard]] bool stop_streams() noexcept;
    void begin_receiving() noexcept;
    [[nodiscard]] std::size_t arrived() noexcept;
    void note_errors() noexcept;
    void flush() noexcept;

    Memory& memory_;
    UartCounters counters_;
    std::size_t read_ = 0;     ///< next in the ring
    std::size_t filling_ = 0;  ///< which of the two buffers
    std::size_t filled_ = 0;
    bool runs_ = false;
};

}  // namespace sc::stm32h743

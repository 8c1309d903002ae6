// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "boards/stm32h743/registers/usart.hpp"
#include "firmware/hal/io.hpp"
#include "shared/machine/sensors.hpp"

namespace sc::stm32h743 {

struct SensorPortSettings {
    Address base = 0;
    Address clock_at = 0;
    std::uint32_t clock = 0;
};
/// Of each sensor bus. The pin that drives the bus is the USART's RTS.
inline constexpr std::array<SensorPortSettings, kSensorBuses> kSensorPorts{
    SensorPortSettings{usart::kUsart2, usart::kApb1lenr, usart::kUsart2Clock},
    SensorPortSettings{usart::kUsart6, usart::kApb2enr, usart::kUsart6Clock}};

struct SensorPortCounters {
    std::uint32_t sent = 0;           ///< transmissions
    std::uint32_t lost_requests = 0;  ///< given while one was under way, or longer than there can be
    std::uint32_t heard = 0;          ///< bytes
    std::uint32_t lost_bytes = 0;     ///< times that a byte was overwritten before it was read, and bytes without room
    std::uint32_t damaged = 0;        ///< bytes with a wrong parity or without a stop bit
    std::uint32_t cut = 0;            ///< transmissions that began while a byte was coming or had just come
    std::uint32_t silences = 0;       ///< times that the line fell silent for 3.5 characters after bytes
};

/// An RS485 bus of sensors on a USART that drives the bus by hardware: from half a bit before the first start bit to a
/// quarter bit after the last stop bit. The receiver is off meanwhile. A byte's time is when its interrupt was served:
/// at most half a bit before its stop bit ends, plus the interrupt's delay. Wants the kernel clock (120 MHz) selected
/// and the pins set. `on_interrupt` may not break into the other calls.
class SensorPort {
public:
    static constexpr std::uint32_t kKernelHz = 120'000'000;
    enum class Start : std::uint8_t {
        ok,
        bad_rate,  ///< outside 2400..230400 baud
        silent,    ///< transmitter and receiver did not come up: no clock
    };

    explicit SensorPort(const SensorPortSettings& settings) noexcept : settings_(settings) {}

    /// Some 100 us at most; may be called again.
    [[nodiscard]] Start start(const SensorBusConfig& bus) noexcept;
    /// What a tick wants sent in the window that begins at `window_ns`.
    void give(const SensorTransmission& sent, std::int64_t window_ns) noexcept;
    /// Begins what is due. To be called at least 10 000 times a second: a transmission begins so much later at most.
    void poll(std::int64_t now_ns) noexcept;
    /// Of the USART. Some 12 register accesses; once a byte, 21 000 times a second at 230 400 baud.
    void on_interrupt(std::int64_t now_ns) noexcept;
    /// Bytes until `tick_ns`, kSensorBytesPerTick at most; what more there is waits. Valid until the next call.
    [[nodiscard]] std::span<const SensorByte> take(std::int64_t tick_ns) noexcept;
    [[nodiscard]] const SensorPortCounters& counters() const noexcept { return counters_; }

private:
    enum class State : std::uint8_t {
        off,
        hearing,
        due,      ///< hears until what was given is to begin
        sending,  ///< until the last stop bit
    };
    struct Heard {
        std::int64_t end_ns = 0;
        std::uint8_t data = 0;
        std::uint8_t flags = 0;
    };
    static constexpr std::size_t kQueue = 64;

    [[nodiscard]] Address at(Address offset) const noexcept { return settings_.base + offset; }
    void begin(std::uint32_t flags) noexcept;
    void hear(std::uint32_t flags, std::int64_t now_ns) noexcept;
    void feed(std::uint32_t flags) noexcept;

    SensorPortSettings settings_;
    SensorPortCounters counters_;
    State state_ = State::off;
    SensorTransmission sending_;
    std::size_t next_ = 0;
    std::int64_t due_ns_ = 0;
    std::int64_t lead_ns_ = 0;  ///< from the driver's start to the start bit
    bool gap_ = false;          ///< bytes were lost before the next
    std::array<Heard, kQueue> queue_{};
    std::size_t first_ = 0;
    std::size_t size_ = 0;
    std::array<SensorByte, kSensorBytesPerTick> out_{};
};

}  // namespace sc::stm32h743

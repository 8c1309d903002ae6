// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "firmware/hal/io.hpp"
#include "firmware/sensors/telegram.hpp"
#include "shared/machine/sensors.hpp"

namespace sc::sensors {

/// Times of a bus, ns.
struct BusTiming {
    std::int64_t character = 0;  ///< start bit, eight data bits, parity, stop bit
    std::int64_t inner = 0;      ///< t1.5: longest silence within a telegram
    std::int64_t gap = 0;        ///< t3.5: least silence between telegrams
};
/// Modbus over serial line 1.02, 2.5.1.1: 1.5 and 3.5 characters up to 19 200 baud, 750 µs and 1.75 ms above.
[[nodiscard]] BusTiming bus_timing(const SensorBusConfig& bus) noexcept;

/// Turn-taking on one half-duplex line: one request, its answer, the silence between. A state machine that never waits.
///
/// Bytes of the window before a tick are judged at that tick, and what is sent begins in the window after it, at the
/// exact time at which the line has been silent for t3.5. An answer is good only once that silence has followed it; the
/// next request may be on its way meanwhile, since it begins later than that. So the control period costs a bus of
/// 115 200 baud next to nothing.
///
/// Servo context, once a tick; some 40 instructions and 40 a byte.
class BusMaster {
public:
    BusMaster(const SensorBusConfig& bus, std::int64_t period_ns) noexcept
        : timing_(bus_timing(bus)), period_ns_(period_ns) {}

    /// Takes what has come until `now_ns`. True if a telegram has ended: `reply` says how.
    [[nodiscard]] bool step(std::int64_t now_ns, std::span<const SensorByte> received, Reply& reply) noexcept;
    /// A telegram given now would begin within the next window.
    [[nodiscard]] bool can_send(std::int64_t now_ns) const noexcept {
        return state_ == State::quiet && begin_at(now_ns) < now_ns + 2 * period_ns_;
    }
    /// Only when can_send.
    void send(std::int64_t now_ns, const Telegram& telegram, SensorTransmission& out) noexcept;

    [[nodiscard]] const BusTiming& timing() const noexcept { return timing_; }
    /// Bytes that belonged to nothing.
    [[nodiscard]] std::uint32_t strays() const noexcept { return strays_; }

private:
    enum class State : std::uint8_t {
        quiet,      ///< nothing is asked; leaves by send
        waiting,    ///< for the answer's first byte; leaves by it, or by patience to quiet
        receiving,  ///< leaves with the last byte to quiet, with an error to draining
        draining,   ///< whatever comes is dropped; leaves once the line has been silent for t3.5
    };

    [[nodiscard]] std::int64_t begin_at(std::int64_t now_ns) const noexcept {
        const std::int64_t window = now_ns + period_ns_;
        const std::int64_t free = busy_until_ + timing_.gap;
        return free > window ? free : window;
    }
    void watch_time(std::int64_t now_ns) noexcept;
    void take(const SensorByte& byte, std::int64_t end_ns) noexcept;
    void take_in_turn(const SensorByte& byte, std::int64_t end_ns) noexcept;
    void append(const SensorByte& byte) noexcept;
    void complete() noexcept;
    void spoil(SensorCode code) noexcept;
    void fail(SensorCode code) noexcept;

    BusTiming timing_;
    std::int64_t period_ns_;
    State state_ = State::quiet;
    Telegram request_;
    Reply reply_;           ///< being received
    Reply done_;            ///< whole, or failed; not yet handed over
    bool pending_ = false;  ///< done_ is an answer, whose silence has not yet passed
    bool failed_ = false;   ///< done_ is none
    std::int64_t pending_until_ = 0;
    std::int64_t asked_ns_ = 0;      ///< end of the request
    std::int64_t last_byte_ns_ = 0;  ///< end of the answer's last byte
    std::int64_t busy_until_ = 0;    ///< the line was in use, or must be left alone, until then
    std::uint32_t strays_ = 0;
};

}  // namespace sc::sensors

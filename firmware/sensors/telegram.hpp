// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "firmware/hal/io.hpp"
#include "shared/codes/codes.hpp"

namespace sc::sensors {

/// How the end of an answer is known.
enum class ReplyForm : std::uint8_t {
    none,    ///< nobody answers (broadcast)
    modbus,  ///< Modbus RTU: length from its first bytes, CRC-16, silence of t1.5 at most within, t3.5 behind
    line,    ///< text that ends with a carriage return
};

/// What is sent to one sensor. Times in ns.
struct Telegram {
    std::array<std::uint8_t, kSensorTransmissionBytes> bytes{};
    std::uint8_t size = 0;
    ReplyForm reply = ReplyForm::none;
    std::uint8_t tag = 0;          ///< whose it is; comes back with the answer
    std::uint8_t step = 0;         ///< what the sensor asked for by it; comes back too
    std::int64_t patience_ns = 0;  ///< from the request's end to the first byte of the answer
    [[nodiscard]] std::span<const std::uint8_t> view() const noexcept { return std::span(bytes).first(size); }
};

inline constexpr std::size_t kReplyCapacity = 40;

/// What came of a telegram. `bytes` is whole and checked when `code` is none, and else empty.
struct Reply {
    SensorCode code = SensorCode::none;
    std::uint8_t detail = 0;  ///< of an exception: its number; of a wrong slave: who answered
    std::uint8_t tag = 0;     ///< of the telegram
    std::uint8_t step = 0;
    std::array<std::uint8_t, kReplyCapacity> bytes{};
    std::uint8_t size = 0;
    std::int64_t asked_ns = 0;  ///< control time at which the request's last stop bit ended
    [[nodiscard]] std::span<const std::uint8_t> view() const noexcept { return std::span(bytes).first(size); }
};

}  // namespace sc::sensors

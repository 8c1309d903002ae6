// SPDX-License-Identifier: Apache-2.0
#include "firmware/sensors/ascii_sensor.hpp"

namespace sc::sensors {
namespace {

constexpr std::size_t kHeadSize = 3;  ///< %AA
constexpr std::array<std::uint8_t, 4> kAnswer{'$', 'R', 'M', 'D'};
constexpr std::array<std::uint8_t, 4> kQuestion{'#', 'R', 'M', 'D'};
constexpr std::size_t kNumberAt = kHeadSize + kAnswer.size();
constexpr std::size_t kNumberSize = 9;  ///< ±ddd.dddd
constexpr std::size_t kPoint = 4;
constexpr std::size_t kTail = 3;  ///< bb and the carriage return
constexpr std::size_t kAnswerSize = kNumberAt + kNumberSize + kTail;
constexpr std::size_t kErrorSize = kHeadSize + 1 + 2 + kTail;
constexpr std::int32_t kNoTarget = 9'500'000;  ///< in 0.1 µm
constexpr std::int32_t kUnits = 10;            ///< 0.1 µm in 10 nm

constexpr std::uint8_t hex(unsigned digit) noexcept {
    return static_cast<std::uint8_t>(digit < 10 ? '0' + digit : 'A' + digit - 10);
}
constexpr bool is_digit(std::uint8_t byte) noexcept { return byte >= '0' && byte <= '9'; }

unsigned check_of(std::span<const std::uint8_t> bytes) noexcept {
    unsigned check = 0;
    for (const std::uint8_t byte : bytes) {
        check ^= byte;
    }
    return check;
}

bool checks(std::span<const std::uint8_t> line) noexcept {
    const unsigned check = check_of(line.first(line.size() - kTail));
    return line[line.size() - 3] == hex(check >> 4U) && line[line.size() - 2] == hex(check & 0xFU);
}

/// The number in 0.1 µm; false if it is none.
bool number(std::span<const std::uint8_t> text, std::int32_t& value) noexcept {
    if (text[0] != '+' && text[0] != '-') {
        return false;
    }
    std::int32_t sum = 0;
    for (std::size_t i = 1; i < text.size(); ++i) {
        if (i == kPoint) {
            if (text[i] != '.') {
                return false;
            }
        } else if (is_digit(text[i])) {
            sum = sum * 10 + (text[i] - '0');
        } else {
            return false;
        }
    }
    value = text[0] == '-' ? -sum : sum;
    return true;
}

}  // namespace

bool AsciiSensor::compose(std::int64_t now_ns, Telegram& telegram) noexcept {
    static_cast<void>(now_ns);
    telegram = {};
    const auto put = [&telegram](std::uint8_t byte) noexcept {
        telegram.bytes[telegram.size] = byte;
        ++telegram.size;
    };
    put('%');
    put(hex(config_.address / 10U % 10U));
    put(hex(config_.address % 10U));
    for (const std::uint8_t byte : kQuestion) {
        put(byte);
    }
    const unsigned check = check_of(telegram.view());
    put(hex(check >> 4U));
    put(hex(check & 0xFU));
    put('\r');
    telegram.reply = ReplyForm::line;
    telegram.patience_ns = config_.patience_ns;
    return true;
}

void AsciiSensor::understand(const Reply& reply, std::int64_t now_ns) noexcept {
    static_cast<void>(now_ns);
    const auto line = reply.view();
    if ((line.size() != kAnswerSize && line.size() != kErrorSize) || line[0] != '%') {
        reading_.fail(SensorCode::bad_frame, 0);
        return;
    }
    if (!checks(line)) {
        reading_.fail(SensorCode::bad_crc, 0);
        return;
    }
    const unsigned who = (line[1] - '0') * 10U + (line[2] - '0');
    if (who != config_.address) {
        reading_.fail(SensorCode::wrong_slave, static_cast<std::uint8_t>(who & 0xFFU));
        return;
    }
    if (line.size() == kErrorSize) {
        const unsigned error = (line[4] - '0') * 10U + (line[5] - '0');
        reading_.take_own_fault(static_cast<std::uint8_t>(error & 0xFFU));
        return;
    }
    for (std::size_t i = 0; i < kAnswer.size(); ++i) {
        if (line[kHeadSize + i] != kAnswer[i]) {
            reading_.fail(SensorCode::bad_frame, 0);
            return;
        }
    }
    std::int32_t value = 0;
    if (!number(line.subspan(kNumberAt, kNumberSize), value)) {
        reading_.fail(SensorCode::bad_frame, 0);
    } else if (value >= kNoTarget || value <= -kNoTarget) {
        reading_.take_nothing(reply.asked_ns);
    } else {
        reading_.take(value * kUnits, reply.asked_ns);
    }
}

}  // namespace sc::sensors

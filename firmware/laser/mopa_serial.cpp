// SPDX-License-Identifier: Apache-2.0
#include "firmware/laser/mopa_serial.hpp"

namespace sc::laser {
namespace {

constexpr std::uint8_t kRaycusHead = 0xA5;
constexpr std::uint8_t kRaycusWidth = 0x01;
constexpr std::size_t kRaycusAnswer = 3;
/// `$34;` before the three digits, `*` behind them.
constexpr std::array<std::uint8_t, 4> kJptHead{'$', '3', '4', ';'};
constexpr std::uint8_t kJptEnd = '*';
constexpr std::uint8_t kJptUnknown = 'E';
constexpr std::size_t kJptSize = kJptHead.size() + 3 + 1;

constexpr std::uint8_t digit(unsigned value) noexcept { return static_cast<std::uint8_t>('0' + value % 10U); }
constexpr bool is_digit(std::uint8_t byte) noexcept { return byte >= '0' && byte <= '9'; }

}  // namespace

void MopaSerial::begin(std::uint16_t width_ns) noexcept {
    wanted_ = width_ns;
    answered_ = 0;
    waited_ns_ = 0;
    sent_ = false;
    heard_size_ = 0;
}

std::size_t MopaSerial::transmit(std::span<std::uint8_t, kSourceBytesPerTick> out) noexcept {
    if (wanted_ == 0 || sent_) {
        return 0;
    }
    sent_ = true;
    if (source_ == LaserSource::raycus) {
        out[0] = kRaycusHead;
        out[1] = kRaycusWidth;
        out[2] = static_cast<std::uint8_t>(wanted_ >> 8U);
        out[3] = static_cast<std::uint8_t>(wanted_ & 0xFFU);
        return 4;
    }
    for (std::size_t i = 0; i < kJptHead.size(); ++i) {
        out[i] = kJptHead[i];
    }
    out[4] = digit(wanted_ / 100U);
    out[5] = digit(wanted_ / 10U);
    out[6] = digit(wanted_);
    out[7] = kJptEnd;
    return kJptSize;
}

WidthAnswer MopaSerial::step(std::span<const std::uint8_t> received) noexcept {
    if (wanted_ == 0) {
        return WidthAnswer::none;
    }
    WidthAnswer answer = WidthAnswer::none;
    for (const std::uint8_t byte : received) {
        if (heard_size_ < heard_.size() && answer == WidthAnswer::none) {
            heard_[heard_size_] = byte;
            ++heard_size_;
            answer = judge();
        }
    }
    waited_ns_ += period_ns_;
    if (answer == WidthAnswer::none && waited_ns_ >= kPatienceNs) {
        answer = WidthAnswer::silent;
    }
    if (answer != WidthAnswer::none) {
        wanted_ = 0;
    }
    return answer;
}

WidthAnswer MopaSerial::judge() noexcept { return source_ == LaserSource::raycus ? judge_raycus() : judge_jpt(); }

WidthAnswer MopaSerial::compare(std::uint16_t width) noexcept {
    answered_ = width;
    return width == wanted_ ? WidthAnswer::set : WidthAnswer::refused;
}

WidthAnswer MopaSerial::judge_raycus() noexcept {
    if (heard_[0] != kRaycusHead) {
        return WidthAnswer::foreign;
    }
    if (heard_size_ < kRaycusAnswer) {
        return WidthAnswer::none;
    }
    return compare(static_cast<std::uint16_t>(heard_[1] << 8U | heard_[2]));
}

WidthAnswer MopaSerial::judge_jpt() noexcept {
    if (heard_[0] == kJptUnknown) {
        return WidthAnswer::refused;
    }
    const std::size_t at = heard_size_ - 1;
    const std::uint8_t byte = heard_[at];
    const bool fits =
        at < kJptHead.size() ? byte == kJptHead[at] : (at + 1 < kJptSize ? is_digit(byte) : byte == kJptEnd);
    if (!fits) {
        return WidthAnswer::foreign;
    }
    if (heard_size_ < kJptSize) {
        return WidthAnswer::none;
    }
    return compare(static_cast<std::uint16_t>((heard_[4] - '0') * 100 + (heard_[5] - '0') * 10 + (heard_[6] - '0')));
}

}  // namespace sc::laser

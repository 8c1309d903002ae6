// SPDX-License-Identifier: Apache-2.0
#include "firmware/drives/sdo_transfer.hpp"

#include <algorithm>

#include "firmware/drives/canopen.hpp"

namespace sc::drives {
namespace {

constexpr std::size_t kSegment = 7;
constexpr std::size_t kExpedited = 4;
constexpr unsigned kToggleBit = 0x10;
constexpr std::uint32_t kTimedOut = 0x0504'0000;
constexpr std::uint32_t kBadToggle = 0x0503'0000;
constexpr std::uint32_t kBadCommand = 0x0504'0001;
constexpr std::uint32_t kOutOfMemory = 0x0504'0005;

std::uint8_t byte(std::uint32_t value, unsigned n) noexcept { return static_cast<std::uint8_t>(value >> (8U * n)); }

}  // namespace

void SdoTransfer::begin(std::uint16_t index, std::uint8_t sub) noexcept {
    const bool told = abort_due_;
    *this = SdoTransfer{};
    abort_due_ = told;
    index_ = index;
    sub_ = sub;
    result_ = Result::busy;
}

void SdoTransfer::read(std::uint16_t index, std::uint8_t sub, std::span<std::uint8_t> into) noexcept {
    begin(index, sub);
    into_ = into;
    reading_ = true;
}

void SdoTransfer::write(std::uint16_t index, std::uint8_t sub, std::span<const std::uint8_t> from) noexcept {
    begin(index, sub);
    from_ = from;
}

void SdoTransfer::restarted() noexcept {
    if (result_ == Result::busy) {
        result_ = Result::timed_out;
    }
    abort_due_ = false;
}

void SdoTransfer::give_up(Result result, std::uint32_t code) noexcept {
    result_ = result;
    abort_ = code;
    abort_due_ = true;
}

SdoTransfer::Bytes SdoTransfer::opening() const noexcept {
    Bytes bytes{0x40, byte(index_, 0), byte(index_, 1), sub_};
    if (reading_) {
        return bytes;
    }
    const auto size = static_cast<std::uint32_t>(from_.size());
    if (size > 0 && size <= kExpedited) {
        bytes[0] = static_cast<std::uint8_t>(0x23U | ((kExpedited - size) << 2U));
        std::copy(from_.begin(), from_.end(), bytes.begin() + 4);
        return bytes;
    }
    bytes[0] = 0x21;
    for (unsigned n = 0; n < 4; ++n) {
        bytes[4 + n] = byte(size, n);
    }
    return bytes;
}

SdoTransfer::Bytes SdoTransfer::request() noexcept {
    if (!opened_) {
        return opening();
    }
    const unsigned toggle = toggle_ ? kToggleBit : 0U;
    if (reading_) {
        return {static_cast<std::uint8_t>(0x60U | toggle)};
    }
    segment_ = std::min(kSegment, from_.size() - at_);
    const bool last = at_ + segment_ == from_.size();
    Bytes bytes{static_cast<std::uint8_t>(toggle | ((kSegment - segment_) << 1U) | (last ? 1U : 0U))};
    const auto begin = from_.begin() + static_cast<std::ptrdiff_t>(at_);
    std::copy(begin, begin + static_cast<std::ptrdiff_t>(segment_), bytes.begin() + 1);
    return bytes;
}

std::optional<DriveFrame> SdoTransfer::poll(std::uint8_t node, std::int64_t tick) noexcept {
    if (result_ == Result::busy && waiting_ && tick - sent_tick_ >= kTimeoutTicks) {
        give_up(Result::timed_out, kTimedOut);
    }
    DriveFrame frame;
    frame.id = static_cast<std::uint16_t>(canopen::kSdoRequestBase + node);
    frame.size = 8;
    if (abort_due_) {
        abort_due_ = false;
        frame.data = {
            0x80,           byte(index_, 0), byte(index_, 1), sub_, byte(abort_, 0), byte(abort_, 1), byte(abort_, 2),
            byte(abort_, 3)};
        return frame;
    }
    if (result_ != Result::busy || waiting_) {
        return std::nullopt;
    }
    frame.data = request();
    waiting_ = true;
    sent_tick_ = tick;
    return frame;
}

void SdoTransfer::receive(const DriveFrame& frame) noexcept {
    if (result_ != Result::busy || !waiting_ || frame.size != 8) {
        return;
    }
    const Bytes& reply = frame.data;
    const bool own = reply[1] == byte(index_, 0) && reply[2] == byte(index_, 1) && reply[3] == sub_;
    if (reply[0] == 0x80) {
        if (own || opened_) {
            result_ = Result::aborted;
            abort_ = reply[4] | (std::uint32_t{reply[5]} << 8U) | (std::uint32_t{reply[6]} << 16U) |
                     (std::uint32_t{reply[7]} << 24U);
        }
        return;
    }
    if (!opened_ && !own) {
        return;
    }
    waiting_ = false;
    if (opened_) {
        take_segment(reply);
    } else {
        take_opening(reply);
    }
}

void SdoTransfer::take_opening(const Bytes& reply) noexcept {
    const unsigned command = reply[0];
    if (!reading_ && command == 0x60) {
        opened_ = true;
        if (!from_.empty() && from_.size() <= kExpedited) {
            at_ = from_.size();
            result_ = Result::done;
        }
        return;
    }
    if (!reading_ || (command & 0xE0U) != 0x40U) {
        give_up(Result::aborted, kBadCommand);
        return;
    }
    if ((command & 2U) == 0) {
        opened_ = true;
        return;
    }
    const std::size_t size = (command & 1U) != 0 ? kExpedited - ((command >> 2U) & 3U) : kExpedited;
    store(std::span(reply).subspan(4, size));
    result_ = result_ == Result::busy ? Result::done : result_;
}

void SdoTransfer::take_segment(const Bytes& reply) noexcept {
    const unsigned command = reply[0];
    const unsigned kind = reading_ ? 0x00U : 0x20U;
    if ((command & 0xE0U) != kind || ((command & kToggleBit) != 0) != toggle_) {
        give_up(Result::aborted, (command & 0xE0U) != kind ? kBadCommand : kBadToggle);
        return;
    }
    toggle_ = !toggle_;
    bool last = false;
    if (reading_) {
        store(std::span(reply).subspan(1, kSegment - ((command >> 1U) & 7U)));
        last = (command & 1U) != 0;
    } else {
        at_ += segment_;
        last = at_ == from_.size();
    }
    if (last && result_ == Result::busy) {
        result_ = Result::done;
    }
}

void SdoTransfer::store(std::span<const std::uint8_t> bytes) noexcept {
    if (bytes.size() > into_.size() - at_) {
        give_up(Result::too_long, kOutOfMemory);
        return;
    }
    std::copy(bytes.begin(), bytes.end(), into_.begin() + static_cast<std::ptrdiff_t>(at_));
    at_ += bytes.size();
}

}  // namespace sc::drives

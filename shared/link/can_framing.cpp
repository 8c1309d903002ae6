// SPDX-License-Identifier: Apache-2.0
#include "shared/link/can_framing.hpp"

#include <algorithm>

namespace sc::link {
namespace {

constexpr std::size_t kClassicSize = 8;
constexpr std::size_t kFdSize = 64;
static_assert(kMessageCapacity <= 0xFF, "the length is one byte");

}  // namespace

std::uint8_t legal_can_size(std::size_t size) noexcept {
    constexpr std::array<std::uint8_t, 7> kSizes{12, 16, 20, 24, 32, 48, 64};
    if (size <= kClassicSize) {
        return static_cast<std::uint8_t>(size);
    }
    for (const std::uint8_t legal : kSizes) {
        if (size <= legal) {
            return legal;
        }
    }
    return kSizes.back();
}

bool CanSegmenter::begin(std::span<const std::uint8_t> message) noexcept {
    if (busy() || message.empty() || message.size() > message_.size()) {
        return false;
    }
    std::copy(message.begin(), message.end(), message_.begin());
    size_ = message.size();
    place_ = 0;
    return true;
}

bool CanSegmenter::next(LinkCanFrame& out) noexcept {
    if (!busy()) {
        return false;
    }
    const bool start = place_ == 0;
    const std::size_t head = start ? 2 : 1;
    const std::size_t body = std::min((fd_ ? kFdSize : kClassicSize) - head, size_ - place_);
    const bool end = place_ + body == size_;
    out = {};
    out.id = id_;
    out.fd = fd_;
    out.size = legal_can_size(head + body);
    const unsigned flags = (start ? can_bits::kStart : 0U) | (end ? can_bits::kEnd : 0U);
    out.data[0] = static_cast<std::uint8_t>(flags | sequence_);
    if (start) {
        out.data[1] = static_cast<std::uint8_t>(size_);
    }
    for (std::size_t i = 0; i < body; ++i) {
        out.data[head + i] = message_[place_ + i];
    }
    place_ += body;
    sequence_ = static_cast<std::uint8_t>((sequence_ + 1U) & can_bits::kSequence);
    return true;
}

void CanReassembler::drop() noexcept {
    if (state_ != State::skipping) {
        ++messages_dropped_;
    }
    state_ = State::skipping;
}

/// False when the frame is the last one again.
bool CanReassembler::check_sequence(std::uint8_t header) noexcept {
    if (last_header_ == header) {
        ++frames_repeated_;
        return false;
    }
    const bool follows =
        !last_header_ || ((*last_header_ + 1U) & can_bits::kSequence) == (header & can_bits::kSequence);
    last_header_ = header;
    if (!follows) {
        ++gaps_;
        drop();
    }
    return true;
}

/// Takes the length off the body. False when there is none.
bool CanReassembler::start(std::span<const std::uint8_t>& body) noexcept {
    if (state_ == State::inside) {
        drop();
    }
    if (body.empty() || body[0] == 0 || body[0] > message_.size()) {
        drop();
        return false;
    }
    expected_ = body[0];
    size_ = 0;
    body = body.subspan(1);
    state_ = State::inside;
    return true;
}

std::optional<std::span<const std::uint8_t>> CanReassembler::take(std::span<const std::uint8_t> body, bool last,
                                                                  bool may_pad) noexcept {
    const std::size_t wanted = expected_ - size_;
    const bool fits = last ? body.size() == wanted || (may_pad && body.size() > wanted) : body.size() < wanted;
    if (!fits) {
        drop();
        return std::nullopt;
    }
    const std::size_t used = std::min(wanted, body.size());
    std::copy_n(body.begin(), used, message_.begin() + static_cast<std::ptrdiff_t>(size_));
    size_ += used;
    if (!last) {
        return std::nullopt;
    }
    state_ = State::idle;
    return std::span<const std::uint8_t>(message_).first(size_);
}

std::optional<std::span<const std::uint8_t>> CanReassembler::push(const LinkCanFrame& frame) noexcept {
    const std::size_t limit = frame.fd ? kFdSize : kClassicSize;
    if (frame.size < 1 || frame.size > limit) {
        drop();
        return std::nullopt;
    }
    const std::uint8_t header = frame.data[0];
    if (!check_sequence(header)) {
        return std::nullopt;
    }
    auto body = std::span<const std::uint8_t>(frame.data).first(frame.size).subspan(1);
    if ((header & can_bits::kStart) != 0) {
        if (!start(body)) {
            return std::nullopt;
        }
    } else if (state_ != State::inside) {
        drop();
        return std::nullopt;
    }
    return take(body, (header & can_bits::kEnd) != 0, frame.fd);
}

}  // namespace sc::link

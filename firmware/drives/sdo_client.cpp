// SPDX-License-Identifier: Apache-2.0
#include "firmware/drives/sdo_client.hpp"

namespace sc::drives {

void SdoClient::begin(const canopen::ObjectKey& key) noexcept {
    key_ = key;
    attempts_ = 0;
    result_ = Result::busy;
}

void SdoClient::write(const canopen::ObjectKey& key, std::uint32_t value) noexcept {
    begin(key);
    reading_ = false;
    value_ = value;
}

void SdoClient::read(const canopen::ObjectKey& key) noexcept {
    begin(key);
    reading_ = true;
    value_ = 0;
}

std::optional<DriveFrame> SdoClient::poll(std::uint8_t node, std::int64_t tick) noexcept {
    if (result_ != Result::busy || (attempts_ > 0 && tick - sent_tick_ < kTimeoutTicks)) {
        return std::nullopt;
    }
    if (attempts_ == kAttempts) {
        result_ = Result::timed_out;
        return std::nullopt;
    }
    ++attempts_;
    sent_tick_ = tick;
    return reading_ ? canopen::sdo_upload(node, key_) : canopen::sdo_download(node, key_, value_);
}

void SdoClient::receive(const DriveFrame& frame) noexcept {
    const std::optional<canopen::SdoReply> reply = canopen::read_sdo_reply(frame);
    const bool expected = result_ == Result::busy && attempts_ > 0 && reply && reply->key.index == key_.index &&
                          reply->key.sub == key_.sub;
    if (!expected) {
        return;
    }
    if (reply->aborted) {
        result_ = Result::aborted;
        value_ = reply->value;
    } else if (reply->upload == reading_) {
        value_ = reading_ ? reply->value : value_;
        result_ = Result::done;
    }
}

}  // namespace sc::drives

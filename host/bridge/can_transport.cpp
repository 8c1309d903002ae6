// SPDX-License-Identifier: Apache-2.0
#include "host/bridge/can_transport.hpp"

#include <algorithm>
#include <array>
#include <utility>

#include "host/bridge/capture_transport.hpp"
#include "shared/link/can_record.hpp"

namespace sc::host {

CanTransport::CanTransport(std::unique_ptr<Transport> records, bool fd, std::unique_ptr<CaptureWriter> capture,
                           Nanoseconds offset)
    : records_(std::move(records)),
      fd_(fd),
      offset_(offset),
      capture_(std::move(capture)),
      port_(link::kCanIdToController, fd) {}

CanTransport::~CanTransport() { close_capture(capture_.get()); }

void CanTransport::note(const link::LinkCanFrame& frame) {
    if (capture_) {
        capture_->can({frame.id, frame.fd, {frame.data.begin(), frame.data.begin() + frame.size}},
                      (now().time_since_epoch() + offset_).count());
    }
}

void CanTransport::send(std::span<const std::uint8_t> bytes) {
    std::vector<std::uint8_t> records;
    while (!bytes.empty()) {
        bytes = bytes.subspan(port_.push(bytes));
        link::LinkCanFrame frame;
        while (port_.next(frame)) {
            note(frame);
            const std::size_t at = records.size();
            records.resize(at + link::can_record_size(fd_));
            link::put_can_record(frame, std::span(records).subspan(at));
        }
    }
    records_->send(records);
}

void CanTransport::take(std::span<const std::uint8_t> bytes) {
    begun_.insert(begun_.end(), bytes.begin(), bytes.end());
    const std::size_t size = link::can_record_size(fd_);
    std::size_t at = 0;
    std::array<std::uint8_t, link::kSerialCapacity> message{};
    for (; begun_.size() - at >= size; at += size) {
        const auto frame = link::get_can_record(std::span(begun_).subspan(at, size), fd_);
        if (!frame) {
            continue;
        }
        note(*frame);
        if (frame->id == link::kCanIdToHost) {
            const std::size_t n = port_.take(*frame, message);
            arrived_.insert(arrived_.end(), message.begin(), message.begin() + static_cast<std::ptrdiff_t>(n));
        }
    }
    begun_.erase(begun_.begin(), begun_.begin() + static_cast<std::ptrdiff_t>(at));
}

std::size_t CanTransport::hand_over(std::span<std::uint8_t> out) {
    const std::size_t n = std::min(out.size(), arrived_.size() - handed_over_);
    std::copy_n(arrived_.begin() + static_cast<std::ptrdiff_t>(handed_over_), n, out.begin());
    handed_over_ += n;
    if (handed_over_ == arrived_.size()) {
        arrived_.clear();
        handed_over_ = 0;
    }
    return n;
}

std::size_t CanTransport::receive(std::span<std::uint8_t> out, HostTime until) {
    std::array<std::uint8_t, 4096> chunk{};
    while (arrived_.empty()) {
        const std::size_t n = records_->receive(chunk, until);
        if (n == 0) {
            return 0;
        }
        take(std::span(chunk).first(n));
    }
    return hand_over(out);
}

}  // namespace sc::host

// SPDX-License-Identifier: Apache-2.0
#include "boards/linux_rt/drive_bus.hpp"

#include <algorithm>
#include <ctime>
#include <utility>

#include <poll.h>

namespace sc::linux_rt {
namespace {

constexpr std::uint16_t kNodeMask = 0x07F;
constexpr std::uint16_t kFunctionMask = 0x780;
constexpr std::uint16_t kSync = 0x080;
constexpr std::uint16_t kStatusOfNode = 0x180;
constexpr std::uint16_t kSdoReply = 0x580;
constexpr std::uint16_t kSdoRequest = 0x600;
constexpr std::uint16_t kHeartbeat = 0x700;
constexpr std::size_t kMostBuses = 2;

/// NMT, SYNC and time have no node, and a heartbeat sent here is the master's own.
bool for_all(const DriveFrame& frame) {
    return (frame.id & kNodeMask) == 0 || (frame.id & kFunctionMask) == kHeartbeat;
}

}  // namespace

DriveBus::DriveBus(std::vector<socketcan::CanSocket> buses) : buses_(std::move(buses)) {}

void DriveBus::note(const DriveFrame& frame, std::uint8_t bus) noexcept {
    const std::uint16_t function = frame.id & kFunctionMask;
    if ((frame.id & kNodeMask) == 0 || function < kSync || function == kSdoRequest) {
        return;
    }
    Node& node = nodes_[frame.id & kNodeMask];
    node.bus = bus;
    if (function == kStatusOfNode) {
        node.answers = true;
        node.answer_due = false;
    } else if (function == kSdoReply) {
        node.reply_due = false;
    } else if (function == kHeartbeat && frame.size == 1 && frame.data[0] == 0) {
        node = {.bus = bus};  // it has booted again
    }
}

void DriveBus::collect() noexcept {
    for (std::size_t i = 0; i < buses_.size(); ++i) {
        socketcan::CanFrame heard;
        while (size_ < kQueue && buses_[i].receive(heard)) {
            if (heard.extended || heard.remote || heard.fd) {
                ++counters_.foreign;
                continue;
            }
            DriveFrame& frame = queue_[(first_ + size_) % kQueue];
            frame.id = static_cast<std::uint16_t>(heard.id);
            frame.size = heard.size;
            std::copy_n(heard.data.begin(), frame.data.size(), frame.data.begin());
            ++size_;
            note(frame, static_cast<std::uint8_t>(i));
        }
    }
}

std::span<const DriveFrame> DriveBus::receive() noexcept {
    collect();
    const std::size_t n = std::min(size_, out_.size());
    for (std::size_t i = 0; i < n; ++i) {
        out_[i] = queue_[(first_ + i) % kQueue];
    }
    first_ = (first_ + n) % kQueue;
    size_ -= n;
    counters_.held += size_;
    return std::span(out_).first(n);
}

void DriveBus::expect(const DriveFrame& frame) noexcept {
    if (frame.id == kSync) {
        for (Node& node : nodes_) {
            node.answer_due = node.answers;
        }
    } else if ((frame.id & kFunctionMask) == kSdoRequest) {
        Node& node = nodes_[frame.id & kNodeMask];
        node.reply_due = node.bus != kNowhere;
    }
}

void DriveBus::send(std::span<const DriveFrame> frames) noexcept {
    for (const DriveFrame& frame : frames) {
        socketcan::CanFrame raw;
        raw.id = frame.id;
        raw.size = frame.size;
        std::copy(frame.data.begin(), frame.data.end(), raw.data.begin());
        const std::uint8_t at = for_all(frame) ? kNowhere : nodes_[frame.id & kNodeMask].bus;
        for (std::size_t i = 0; i < buses_.size(); ++i) {
            if ((at == kNowhere || at == i) && buses_[i].send(raw) != socketcan::CanSent::yes) {
                ++counters_.unsent;
            }
        }
        expect(frame);
    }
}

bool DriveBus::answered() noexcept {
    collect();
    return std::none_of(nodes_.begin(), nodes_.end(),
                        [](const Node& node) { return node.answer_due || node.reply_due; });
}

void DriveBus::give_up() noexcept {
    for (Node& node : nodes_) {
        if (node.answer_due) {
            ++counters_.unanswered;
            node.answers = false;
        }
        node.answer_due = node.reply_due = false;
    }
}

void DriveBus::wait(std::int64_t most_ns) noexcept {
    std::array<pollfd, kMostBuses> files{};
    const std::size_t n = std::min(buses_.size(), files.size());
    for (std::size_t i = 0; i < n; ++i) {
        files[i] = {buses_[i].file(), POLLIN, 0};
    }
    const timespec timeout{static_cast<time_t>(most_ns / 1'000'000'000), static_cast<long>(most_ns % 1'000'000'000)};
    (void)::ppoll(files.data(), n, &timeout, nullptr);
}

}  // namespace sc::linux_rt

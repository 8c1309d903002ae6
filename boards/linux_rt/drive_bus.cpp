// SPDX-License-Identifier: Apache-2.0
#include "boards/linux_rt/drive_bus.hpp"

#include <algorithm>
#include <ctime>
#include <utility>

#include <poll.h>

namespace sc::linux_rt {
namespace {

constexpr std::uint16_t kNodeMask = 0x07F;
constexpr std::uint16_t kIdMask = 0x7FF;
constexpr std::uint16_t kFunctionMask = 0x780;
constexpr std::uint16_t kNmt = 0x000;
constexpr std::uint8_t kNmtStart = 0x01;
constexpr std::uint16_t kSync = 0x080;
constexpr std::uint16_t kStatusOfNode = 0x180;
constexpr std::uint16_t kSdoReply = 0x580;
constexpr std::uint16_t kSdoRequest = 0x600;
constexpr std::uint16_t kHeartbeat = 0x700;
constexpr std::size_t kMostBuses = 2;

}  // namespace

DriveBus::DriveBus(std::vector<socketcan::CanSocket> buses) : buses_(std::move(buses)) {}

DriveBus::Node& DriveBus::node_of(const DriveFrame& frame) noexcept {
    return nodes_[(frame.id & kSecondDriveBus) != 0 ? 1 : 0][frame.id & kNodeMask];
}

void DriveBus::note(const DriveFrame& frame) noexcept {
    const auto function = static_cast<std::uint16_t>(frame.id & kFunctionMask);
    if ((frame.id & kNodeMask) == 0 || function < kSync || function == kSdoRequest) {
        return;
    }
    Node& node = node_of(frame);
    node.known = true;
    if (function == kStatusOfNode) {
        node.every = node.answered ? node.since : 0;
        node.answered = true;
        node.since = 0;
        node.answer_due = false;
    } else if (function == kSdoReply) {
        node.reply_due = false;
    } else if (function == kHeartbeat && frame.size == 1 && frame.data[0] == 0) {
        node = {};
        node.known = true;  // it has booted again
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
            frame.id = static_cast<std::uint16_t>(heard.id | (i == 0 ? 0U : kSecondDriveBus));
            frame.size = heard.size;
            std::copy_n(heard.data.begin(), frame.data.size(), frame.data.begin());
            ++size_;
            note(frame);
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
    if ((frame.id & kIdMask) == kSync) {
        for (Node& node : nodes_[(frame.id & kSecondDriveBus) != 0 ? 1 : 0]) {
            ++node.since;
            node.answer_due = node.every > 0 && node.since >= node.every;
        }
    } else if ((frame.id & kIdMask) == kNmt && frame.size == 2 && frame.data[0] != kNmtStart) {
        // Reset, stopped or pre-operational: no status to a SYNC from now on.
        auto& nodes = nodes_[(frame.id & kSecondDriveBus) != 0 ? 1 : 0];
        for (std::size_t i = 0; i < nodes.size(); ++i) {
            if (frame.data[1] == 0 || frame.data[1] == i) {
                nodes[i] = {.known = nodes[i].known};
            }
        }
    } else if ((frame.id & kFunctionMask) == kSdoRequest) {
        Node& node = node_of(frame);
        node.reply_due = node.known;
    }
}

void DriveBus::send(std::span<const DriveFrame> frames) noexcept {
    for (const DriveFrame& frame : frames) {
        const std::size_t bus = (frame.id & kSecondDriveBus) != 0 ? 1 : 0;
        socketcan::CanFrame raw;
        raw.id = frame.id & kIdMask;
        raw.size = frame.size;
        std::copy(frame.data.begin(), frame.data.end(), raw.data.begin());
        if (bus >= buses_.size() || buses_[bus].send(raw) != socketcan::CanSent::yes) {
            ++counters_.unsent;
        }
        expect(frame);
    }
}

bool DriveBus::answered() noexcept {
    collect();
    for (const auto& bus : nodes_) {
        for (const Node& node : bus) {
            if (node.answer_due || node.reply_due) {
                return false;
            }
        }
    }
    return true;
}

void DriveBus::give_up() noexcept {
    for (auto& bus : nodes_) {
        for (Node& node : bus) {
            if (node.answer_due) {
                ++counters_.unanswered;
                node.every = 0;
                node.answered = false;
            }
            node.answer_due = node.reply_due = false;
        }
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

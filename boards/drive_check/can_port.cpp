// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <stdexcept>
#include <utility>

#include <poll.h>
#include <time.h>

#include "boards/drive_check/drive_port.hpp"

namespace sc::drive_check {
namespace {

constexpr std::uint32_t kSync = 0x080;
constexpr std::int64_t kNsPerSecond = 1'000'000'000;
constexpr int kShortWaitMs = 2;

std::int64_t now_ns() {
    timespec t{};
    clock_gettime(CLOCK_MONOTONIC, &t);
    return std::int64_t{t.tv_sec} * kNsPerSecond + t.tv_nsec;
}

}  // namespace

CanPort::CanPort(socketcan::CanSocket socket, double cycle_ms, bool real_time, int patience_ms)
    : socket_(std::move(socket)), cycle_ms_(cycle_ms), real_time_(real_time), patience_ms_(patience_ms) {}

void CanPort::send(const Frame& frame) {
    // A node that boots or is stopped answers no SDO: not worth a long wait.
    const bool quiet = frame.id == 0 && !frame.data.empty() && (frame.data[0] >= 0x81 || frame.data[0] == 0x02);
    silent_ = silent_ || quiet;
    socketcan::CanFrame raw;
    raw.id = frame.id;
    raw.size = static_cast<std::uint8_t>(frame.data.size());
    std::ranges::copy(frame.data, raw.data.begin());
    for (int attempt = 0; attempt < patience_ms_; ++attempt) {
        const socketcan::CanSent sent = socket_.send(raw);
        if (sent == socketcan::CanSent::yes) {
            return;
        }
        if (sent != socketcan::CanSent::full) {
            break;
        }
        const timespec pause{.tv_sec = 0, .tv_nsec = 1'000'000};
        nanosleep(&pause, nullptr);
    }
    throw std::runtime_error("the CAN bus takes no frame: is the interface up, and another node on the bus?");
}

void CanPort::gather(std::vector<Frame>& out, int wait_ms, std::uint32_t until_id, bool fenced) {
    const std::int64_t end = now_ns() + std::int64_t{wait_ms} * 1'000'000;
    for (;;) {
        socketcan::CanFrame raw;
        while (socket_.receive(raw)) {
            const bool fence =
                raw.id == 0x580U + node_ && raw.data[1] == 0x00 && raw.data[2] == 0x10 && raw.data[3] == 0;
            const bool mine = raw.id == until_id && (fence || !fenced);
            if (fence && late_fences_ > 0 && !mine) {
                --late_fences_;
                continue;
            }
            if (!raw.extended && !raw.remote && !raw.fd) {
                out.push_back({raw.id, {raw.data.begin(), raw.data.begin() + raw.size}});
            }
            if (mine) {
                return;
            }
        }
        const std::int64_t left = end - now_ns();
        if (left <= 0 || socket_.closed()) {
            return;
        }
        pollfd file{socket_.file(), POLLIN, 0};
        poll(&file, 1, static_cast<int>(left / 1'000'000) + 1);
    }
}

std::vector<Frame> CanPort::cycle() {
    std::vector<Frame> heard;
    send({kSync, {}});
    if (real_time_) {
        const auto period = static_cast<std::int64_t>(cycle_ms_ * 1e6);
        next_ns_ = std::max(next_ns_ + period, now_ns());
        while (now_ns() < next_ns_) {
            gather(heard, 1, 0xFFFF'FFFF, false);
        }
        return heard;
    }
    // The answer to a request behind the SYNC shows that the SYNC has been worked off. A stopped drive gives none.
    send({0x600U + node_, {0x40, 0x00, 0x10, 0, 0, 0, 0, 0}});
    gather(heard, silent_ ? kShortWaitMs : patience_ms_, 0x580U + node_, true);
    silent_ = heard.empty() || heard.back().id != 0x580U + node_;
    if (silent_) {
        ++late_fences_;
    } else {
        heard.pop_back();
    }
    return heard;
}

std::vector<Frame> CanPort::answers() {
    std::vector<Frame> heard;
    gather(heard, patience_ms_, 0x580U + node_, false);
    return heard;
}

}  // namespace sc::drive_check

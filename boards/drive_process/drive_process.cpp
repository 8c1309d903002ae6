// SPDX-License-Identifier: Apache-2.0
#include "boards/drive_process/drive_process.hpp"

#include <algorithm>
#include <utility>

#include <poll.h>
#include <time.h>

namespace sc::drive_process {
namespace {

constexpr std::uint32_t kSync = 0x080;
constexpr int kWaitMs = 100;
constexpr int kSendTries = 500;

void wait_for(int file, short what, int ms) {
    pollfd poll_file{file, what, 0};
    poll(&poll_file, 1, ms);
}

}  // namespace

DriveProcess::DriveProcess(socketcan::CanSocket socket, const std::vector<sim::SimDriveOptions>& drives,
                           std::int64_t cycle_ns)
    : socket_(std::move(socket)), cycle_ns_(cycle_ns) {
    for (const sim::SimDriveOptions& options : drives) {
        drives_.emplace_back(options);
    }
}

void DriveProcess::run(const std::atomic<bool>& stop) {
    socketcan::CanFrame frame;
    while (!stop.load() && !socket_.closed()) {
        while (socket_.receive(frame)) {
            take(frame);
        }
        wait_for(socket_.file(), POLLIN, kWaitMs);
    }
}

void DriveProcess::take(const socketcan::CanFrame& frame) {
    if (frame.extended || frame.remote || frame.fd) {
        return;
    }
    ++counters_.received;
    DriveFrame raw;
    raw.id = static_cast<std::uint16_t>(frame.id);
    raw.size = frame.size;
    std::copy_n(frame.data.begin(), raw.data.size(), raw.data.begin());
    if (frame.id == kSync) {
        ++counters_.syncs;
        t_ns_ += cycle_ns_;
        for (sim::SimDrive& drive : drives_) {
            drive.step_to(t_ns_);
        }
    }
    for (sim::SimDrive& drive : drives_) {
        drive.receive(raw, t_ns_);
    }
    answer();
}

void DriveProcess::answer() {
    out_.clear();
    for (sim::SimDrive& drive : drives_) {
        drive.drain(out_);
    }
    for (const DriveFrame& frame : out_) {
        socketcan::CanFrame raw;
        raw.id = frame.id;
        raw.size = frame.size;
        std::ranges::copy(frame.data, raw.data.begin());
        bool sent = false;
        for (int i = 0; i < kSendTries && !sent; ++i) {
            const socketcan::CanSent result = socket_.send(raw);
            sent = result == socketcan::CanSent::yes;
            if (!sent && result != socketcan::CanSent::full) {
                break;
            }
            if (!sent) {
                // A full queue of an interface does not show in poll.
                const timespec pause{.tv_sec = 0, .tv_nsec = 200'000};
                nanosleep(&pause, nullptr);
            }
        }
        (sent ? counters_.sent : counters_.lost) += 1;
    }
}

}  // namespace sc::drive_process

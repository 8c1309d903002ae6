// SPDX-License-Identifier: Apache-2.0
// The CANopen half of SimDrive.
#include <algorithm>
#include <bit>
#include <cmath>
#include <utility>

#include "boards/sim/plant/drive.hpp"

namespace sc::sim {
namespace {

using State = DriveStates::State;

constexpr std::int64_t kBootNs = 20'000'000;
constexpr std::int64_t kNsPerMs = 1'000'000;
constexpr std::uint8_t kInitialising = 0x00;
constexpr std::uint8_t kStopped = 0x04;
constexpr std::uint8_t kOperational = 0x05;
constexpr std::uint8_t kPreOperational = 0x7F;
constexpr std::uint32_t kPdoOff = 0x8000'0000;
constexpr std::uint32_t kFrameIdMask = 0x7FF;
constexpr std::uint32_t kCyclicTypes = 240;
constexpr std::uint16_t kHeartbeatErrorCode = 0x8130;

}  // namespace

void SimDrive::restart() {
    objects_ = ObjectDictionary(options_.node, options_.quirks);
    states_.reset();
    servo_.power(false);
    servo_.set_counts_at(servo_.position(), 0);
    demand_.hold(servo_.position());
    waiting_rpdo_ = {};
    pending_.clear();
    taken_ns_ = -1;
    sync_ns_ = -1;
    nmt_state_ = kInitialising;
    homing_ = Homing::idle;
    homing_bit_ = false;
    boot_at_ns_ = t_ns_ + kBootNs;
    heartbeat_at_ns_ = 0;
    master_heard_ns_ = -1;
    error_since_ns_ = -1;
}

void SimDrive::drain(std::vector<DriveFrame>& out) {
    out.insert(out.end(), sent_.begin(), sent_.end());
    sent_.clear();
}

void SimDrive::send(std::uint32_t id, std::span<const std::uint8_t> data) {
    if (silent_ || nmt_state_ == kInitialising) {
        return;
    }
    DriveFrame frame;
    frame.id = static_cast<std::uint16_t>((id & kFrameIdMask) | (options_.second_bus ? kSecondDriveBus : 0U));
    frame.size = static_cast<std::uint8_t>(data.size());
    std::ranges::copy(data, frame.data.begin());
    sent_.push_back(frame);
}

void SimDrive::send_emergency(std::uint16_t code) {
    const std::array<std::uint8_t, 8> data{static_cast<std::uint8_t>(code), static_cast<std::uint8_t>(code >> 8U),
                                           static_cast<std::uint8_t>(objects_.get(0x1001))};
    send(0x080U + options_.node, data);
}

void SimDrive::receive(const DriveFrame& on_bus, std::int64_t t_ns) {
    step_to(t_ns);
    const bool other_bus = ((on_bus.id & kSecondDriveBus) != 0) != options_.second_bus;
    if (silent_ || other_bus || nmt_state_ == kInitialising) {
        return;
    }
    DriveFrame frame = on_bus;
    frame.id = static_cast<std::uint16_t>(frame.id & kFrameIdMask);
    const std::uint32_t watched = objects_.get(0x1016, 1) >> 16U;
    if (frame.id == 0x000 && frame.size == 2) {
        if (frame.data[1] == 0 || frame.data[1] == options_.node) {
            nmt(frame.data[0]);
        }
    } else if (frame.id == 0x080 && nmt_state_ == kOperational) {
        sync();
    } else if (frame.id == 0x600U + options_.node && frame.size == 8 && nmt_state_ != kStopped) {
        answer_sdo(frame);
    } else if (watched != 0 && frame.id == 0x700U + watched) {
        master_heard_ns_ = t_ns_;
    } else if (nmt_state_ == kOperational && frame.id >= 0x180 && frame.id < 0x580) {
        for (std::size_t number = 0; number < waiting_rpdo_.size(); ++number) {
            const std::uint32_t rpdo = objects_.get(static_cast<std::uint16_t>(0x1400 + number), 1);
            if ((rpdo & kPdoOff) == 0 && frame.id == (rpdo & kFrameIdMask)) {
                take_rpdo(static_cast<std::uint16_t>(number), std::span(frame.data).first(frame.size));
            }
        }
    }
}

void SimDrive::take_rpdo(std::uint16_t number, std::span<const std::uint8_t> data) {
    if (objects_.get(static_cast<std::uint16_t>(0x1400 + number), 2) <= kCyclicTypes) {
        waiting_rpdo_.at(number).assign(data.begin(), data.end());
    } else {
        unpack_rpdo(static_cast<std::uint16_t>(0x1600 + number), data);
        actuate();
    }
}

void SimDrive::nmt(std::uint8_t command) {
    constexpr std::uint8_t kResetNode = 0x81;
    constexpr std::uint8_t kResetCommunication = 0x82;
    if (command == kResetNode || command == kResetCommunication) {
        restart();
        return;
    }
    const std::uint8_t next = command == 0x01   ? kOperational
                              : command == 0x02 ? kStopped
                              : command == 0x80 ? kPreOperational
                                                : nmt_state_;
    if (nmt_state_ == kOperational && next != kOperational) {
        constexpr std::uint16_t kQuickStopWord = 0x02;
        const State before = states_.state();
        states_.control(kQuickStopWord);
        on_state_change(before);
    }
    syncs_ = next == kOperational && nmt_state_ != kOperational ? 0 : syncs_;
    nmt_state_ = next;
}

void SimDrive::answer_sdo(const DriveFrame& frame) {
    constexpr std::uint8_t kClientAborts = 0x80;
    refresh_objects();
    const std::array<std::uint8_t, 8> reply = objects_.serve(frame.data);
    if (frame.data[0] == kClientAborts) {
        return;
    }
    send(0x580U + options_.node, reply);
}

void SimDrive::sync() {
    ++syncs_;
    // What the TPDO reports was so at the SYNC, before the SYNC makes the waiting RPDO effective.
    if (objects_.get(0x1800, 2) <= kCyclicTypes) {
        send_tpdo();
    }
    sync_ns_ = t_ns_;
    Pending now{.at_ns = t_ns_ + options_.quirks.pdo_delay_ns, .rpdo = {}};
    const bool soon = taken_ns_ >= 0 && t_ns_ - taken_ns_ < options_.quirks.pdo_gap_ns;
    std::swap(now.rpdo, waiting_rpdo_);
    if (soon) {
        return;
    }
    taken_ns_ = t_ns_;
    if (options_.quirks.pdo_delay_ns == 0) {
        apply(now);
    } else {
        pending_.push_back(std::move(now));
    }
}

void SimDrive::apply(Pending& pending) {
    for (std::size_t number = 0; number < pending.rpdo.size(); ++number) {
        if (!pending.rpdo.at(number).empty()) {
            unpack_rpdo(static_cast<std::uint16_t>(0x1600 + number), pending.rpdo.at(number));
        }
    }
    actuate();
}

void SimDrive::send_tpdo() {
    const std::uint32_t cob_id = objects_.get(0x1800, 1);
    const std::uint32_t every = objects_.get(0x1800, 2);
    const bool due = every > kCyclicTypes || (every >= 1 && syncs_ % every == 0);
    if ((cob_id & kPdoOff) != 0 || !due) {
        return;
    }
    refresh_objects();
    std::vector<std::uint8_t> data;
    for (std::uint32_t sub = 1; sub <= objects_.get(0x1A00, 0); ++sub) {
        const std::uint32_t mapped = objects_.get(0x1A00, static_cast<std::uint8_t>(sub));
        const std::uint32_t value =
            objects_.get(static_cast<std::uint16_t>(mapped >> 16U), static_cast<std::uint8_t>(mapped >> 8U));
        for (std::uint32_t bit = 0; bit < (mapped & 0xFFU); bit += 8) {
            data.push_back(static_cast<std::uint8_t>(value >> bit));
        }
    }
    send(cob_id, data);
}

void SimDrive::unpack_rpdo(std::uint16_t mapping, std::span<const std::uint8_t> data) {
    std::size_t at = 0;
    for (std::uint32_t sub = 1; sub <= objects_.get(mapping, 0); ++sub) {
        const std::uint32_t mapped = objects_.get(mapping, static_cast<std::uint8_t>(sub));
        const std::size_t bytes = (mapped & 0xFFU) / 8;
        if (at + bytes > data.size()) {
            return;
        }
        std::uint32_t value = 0;
        for (std::size_t i = 0; i < bytes; ++i) {
            value |= std::uint32_t{data[at + i]} << (8 * i);
        }
        objects_.set(static_cast<std::uint16_t>(mapped >> 16U), static_cast<std::uint8_t>(mapped >> 8U), value);
        at += bytes;
    }
}

void SimDrive::advance_communication() {
    while (!pending_.empty() && t_ns_ >= pending_.front().at_ns) {
        apply(pending_.front());
        pending_.pop_front();
    }
    if (nmt_state_ == kOperational && objects_.get(0x1800, 2) > kCyclicTypes && statusword() != told_statusword_) {
        told_statusword_ = statusword();
        send_tpdo();
    }
    if (nmt_state_ == kInitialising) {
        if (t_ns_ >= boot_at_ns_) {
            nmt_state_ = kPreOperational;
            send(0x700U + options_.node, std::array<std::uint8_t, 1>{0});
        }
        return;
    }
    const std::int64_t period = static_cast<std::int64_t>(objects_.get(0x1017)) * kNsPerMs;
    if (period > 0 && t_ns_ >= heartbeat_at_ns_) {
        heartbeat_at_ns_ = t_ns_ + period;
        send(0x700U + options_.node, std::array<std::uint8_t, 1>{nmt_state_});
    }
    const std::int64_t limit = static_cast<std::int64_t>(objects_.get(0x1016, 1) & 0xFFFFU) * kNsPerMs;
    if (master_heard_ns_ >= 0 && limit > 0 && t_ns_ - master_heard_ns_ > limit) {
        master_heard_ns_ = -1;
        enter_fault(kHeartbeatErrorCode);
    }
}

void SimDrive::refresh_objects() {
    objects_.set(0x6041, 0, statusword());
    objects_.set(0x6064, 0, std::bit_cast<std::uint32_t>(static_cast<std::int32_t>(servo_.counts())));
    const auto error = static_cast<std::int32_t>(std::lround(following_error_counts()));
    objects_.set(0x60F4, 0, std::bit_cast<std::uint32_t>(error));
}

}  // namespace sc::sim

// SPDX-License-Identifier: Apache-2.0
#include "boards/drive_check/drive_client.hpp"

#include <algorithm>
#include <array>
#include <utility>

namespace sc::drive_check {
namespace {

constexpr std::uint32_t kNoAnswer = 0xFFFF'FFFF;
constexpr std::uint32_t kOff = 0x8000'0000;
constexpr std::uint32_t kNoRemoteRequest = 0x4000'0000;
constexpr int kBootCycles = 2000;

std::uint32_t number(const std::vector<std::uint8_t>& bytes, std::size_t at, std::size_t count) {
    std::uint32_t value = 0;
    for (std::size_t i = 0; i < count && at + i < bytes.size(); ++i) {
        value |= std::uint32_t{bytes[at + i]} << (8 * i);
    }
    return value;
}

}  // namespace

Power power_of(std::uint16_t statusword) {
    switch (statusword & 0x6FU) {
        case 0x21: return Power::ready;
        case 0x23: return Power::switched_on;
        case 0x27: return Power::enabled;
        case 0x07: return Power::quick_stop;
        default: break;
    }
    switch (statusword & 0x4FU) {
        case 0x00: return Power::not_ready;
        case 0x40: return Power::disabled;
        case 0x0F: return Power::reaction;
        case 0x08: return Power::fault;
        default: return Power::none;
    }
}

std::string name_of(Power power) {
    switch (power) {
        case Power::not_ready: return "not ready to switch on";
        case Power::disabled: return "switch on disabled";
        case Power::ready: return "ready to switch on";
        case Power::switched_on: return "switched on";
        case Power::enabled: return "operation enabled";
        case Power::quick_stop: return "quick stop active";
        case Power::reaction: return "fault reaction active";
        case Power::fault: return "fault";
        case Power::none: break;
    }
    return "no state of CiA 402";
}

void DriveClient::nmt(std::uint8_t command, int node) {
    send(0x000, {command, static_cast<std::uint8_t>(node < 0 ? node_ : node)});
}

std::vector<Frame> DriveClient::run(int cycles) {
    std::vector<Frame> all;
    for (int i = 0; i < cycles; ++i) {
        std::vector<Frame> heard = port_->cycle();
        std::ranges::move(heard, std::back_inserter(all));
    }
    take_status(all);
    return all;
}

std::vector<std::uint8_t> DriveClient::ask(std::vector<std::uint8_t> request) {
    constexpr int kStale = 4;
    request.resize(8);
    // A request that begins a transfer is answered with its own object.
    const bool begins = (request[0] & 0xE0U) == 0x20U || (request[0] & 0xE0U) == 0x40U;
    send(0x600U + node_, request);
    for (int i = 0; i < kStale; ++i) {
        std::vector<Frame> heard = port_->answers();
        if (heard.empty()) {
            return {};
        }
        for (Frame& frame : heard) {
            const bool mine = frame.id == 0x580U + node_ && frame.data.size() == 8;
            if (mine && (!begins || std::equal(request.begin() + 1, request.begin() + 4, frame.data.begin() + 1))) {
                return std::move(frame.data);
            }
        }
    }
    return {};
}

std::uint32_t DriveClient::write(std::uint16_t index, std::uint8_t sub, int size, std::uint32_t value) {
    const auto command = static_cast<std::uint8_t>(0x23U | (static_cast<unsigned>(4 - size) << 2U));
    const auto byte = [value](unsigned n) { return static_cast<std::uint8_t>(value >> (8U * n)); };
    const auto reply = ask({command, static_cast<std::uint8_t>(index), static_cast<std::uint8_t>(index >> 8U), sub,
                            byte(0), byte(1), byte(2), byte(3)});
    abort_ = reply.empty() ? kNoAnswer : (reply[0] == 0x60 ? 0 : number(reply, 4, 4));
    return abort_;
}

std::optional<std::uint32_t> DriveClient::read(std::uint16_t index, std::uint8_t sub) {
    const auto reply = ask({0x40, static_cast<std::uint8_t>(index), static_cast<std::uint8_t>(index >> 8U), sub});
    if (reply.empty() || (reply[0] & 0xF3U) != 0x43U) {
        abort_ = reply.empty() ? kNoAnswer : number(reply, 4, 4);
        return std::nullopt;
    }
    abort_ = 0;
    return number(reply, 4, 4U - ((reply[0] >> 2U) & 3U));
}

bool DriveClient::reset() {
    nmt(0x81);
    for (int i = 0; i < kBootCycles; ++i) {
        for (const Frame& frame : run(1)) {
            if (frame.id == 0x700U + node_ && frame.data.size() == 1 && frame.data[0] == 0) {
                return true;
            }
        }
    }
    return false;
}

bool DriveClient::operational(std::uint8_t status_every) {
    if (!reset()) {
        return false;
    }
    const std::uint32_t rpdo = 0x200U + node_;
    const std::uint32_t tpdo = (0x180U + node_) | kNoRemoteRequest;
    const auto period = static_cast<std::uint32_t>(cycle_ms());
    const bool mapped = write(0x1400, 1, 4, rpdo | kOff) == 0 && write(0x1400, 2, 1, 1) == 0 &&
                        write(0x1600, 0, 1, 0) == 0 && write(0x1600, 1, 4, 0x6040'0010) == 0 &&
                        write(0x1600, 2, 4, 0x607A'0020) == 0 && write(0x1600, 0, 1, 2) == 0 &&
                        write(0x1400, 1, 4, rpdo) == 0 && write(0x1800, 1, 4, tpdo | kOff) == 0 &&
                        write(0x1800, 2, 1, status_every) == 0 && write(0x1A00, 0, 1, 0) == 0 &&
                        write(0x1A00, 1, 4, 0x6041'0010) == 0 && write(0x1A00, 2, 4, 0x6064'0020) == 0 &&
                        write(0x1A00, 0, 1, 2) == 0 && write(0x1800, 1, 4, tpdo) == 0;
    const bool set = write(0x60C2, 1, 1, period) == 0 && write(0x60C2, 2, 1, 0xFD) == 0 &&
                     write(0x6060, 0, 1, 8) == 0 && write(0x605A, 0, 2, 2) == 0;
    nmt(0x01);
    run(2 * status_every + 1);
    return mapped && set;
}

std::vector<Frame> DriveClient::control(std::uint16_t word, std::int32_t target, int cycles) {
    std::vector<Frame> all;
    const auto bits = static_cast<std::uint32_t>(target);
    for (int i = 0; i < cycles; ++i) {
        send(0x200U + node_, {static_cast<std::uint8_t>(word), static_cast<std::uint8_t>(word >> 8U),
                              static_cast<std::uint8_t>(bits), static_cast<std::uint8_t>(bits >> 8U),
                              static_cast<std::uint8_t>(bits >> 16U), static_cast<std::uint8_t>(bits >> 24U)});
        std::vector<Frame> heard = run(1);
        std::ranges::move(heard, std::back_inserter(all));
    }
    return all;
}

bool DriveClient::take_status(const std::vector<Frame>& frames) {
    bool seen = false;
    for (const Frame& frame : frames) {
        if (frame.id == 0x180U + node_ && frame.data.size() == 6) {
            statusword_ = static_cast<std::uint16_t>(number(frame.data, 0, 2));
            actual_ = static_cast<std::int32_t>(number(frame.data, 2, 4));
            seen = true;
        }
    }
    return seen;
}

bool DriveClient::go_to(Power wanted) {
    constexpr std::array<std::pair<Power, std::uint16_t>, 3> kUp{
        {{Power::ready, 0x06}, {Power::switched_on, 0x07}, {Power::enabled, 0x0F}}};
    control(0x00, actual_);
    if (power() == Power::fault) {
        control(0x80, actual_);
        control(0x00, actual_);
    }
    if (wanted == Power::disabled) {
        return power() == Power::disabled;
    }
    for (const auto& [state, word] : kUp) {
        control(word, actual_);
        if (power() != state) {
            return false;
        }
        if (state == wanted) {
            return true;
        }
    }
    return false;
}

std::vector<std::uint16_t> DriveClient::emergencies(const std::vector<Frame>& frames) const {
    std::vector<std::uint16_t> codes;
    for (const Frame& frame : frames) {
        if (frame.id == 0x080U + node_ && frame.data.size() == 8) {
            codes.push_back(static_cast<std::uint16_t>(number(frame.data, 0, 2)));
        }
    }
    return codes;
}

int DriveClient::count(const std::vector<Frame>& frames, std::uint32_t id) const {
    return static_cast<int>(std::ranges::count(frames, id, &Frame::id));
}

}  // namespace sc::drive_check

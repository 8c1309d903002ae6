// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "boards/drive_check/drive_port.hpp"

namespace sc::drive_check {

/// States of CiA 402 by their status words.
enum class Power : std::uint8_t { not_ready, disabled, ready, switched_on, enabled, quick_stop, reaction, fault, none };
[[nodiscard]] Power power_of(std::uint16_t statusword);
[[nodiscard]] std::string name_of(Power power);

/// A plain CANopen client for one drive, written from CiA 301 and 402 alone.
class DriveClient {
public:
    DriveClient(DrivePort& port, std::uint8_t node) : port_(&port), node_(node) {}

    [[nodiscard]] std::uint8_t node() const { return node_; }
    [[nodiscard]] double cycle_ms() const { return port_->cycle_ms(); }
    void send(std::uint32_t id, std::vector<std::uint8_t> data) { port_->send({id, std::move(data)}); }
    void nmt(std::uint8_t command, int node = -1);
    /// Lets cycles pass; all frames of the drive, in order.
    std::vector<Frame> run(int cycles);
    std::vector<Frame> run_ms(double ms) { return run(static_cast<int>(ms / cycle_ms()) + 1); }
    /// The raw answer to an SDO request; empty without one.
    std::vector<std::uint8_t> ask(std::vector<std::uint8_t> request);
    /// 0, or the abort code; 0xFFFF'FFFF without an answer.
    std::uint32_t write(std::uint16_t index, std::uint8_t sub, int size, std::uint32_t value);
    std::optional<std::uint32_t> read(std::uint16_t index, std::uint8_t sub);
    [[nodiscard]] std::uint32_t abort_code() const { return abort_; }

    /// Resets the node and waits for its boot-up message. False without one.
    bool reset();
    /// Reset, PDOs mapped and tied to SYNC, mode CSP, started.
    bool operational(std::uint8_t status_every = 1);
    /// Sends an RPDO with these and lets cycles pass.
    std::vector<Frame> control(std::uint16_t word, std::int32_t target, int cycles = 3);
    /// The last status word and place of the TPDOs among the frames.
    bool take_status(const std::vector<Frame>& frames);
    [[nodiscard]] std::uint16_t statusword() const { return statusword_; }
    [[nodiscard]] std::int32_t actual() const { return actual_; }
    [[nodiscard]] Power power() const { return power_of(statusword_); }
    /// Steps by the state machine to a state, one at a time. False if the drive does not follow.
    bool go_to(Power wanted);
    /// Emergency frames of the drive among them, by code.
    [[nodiscard]] std::vector<std::uint16_t> emergencies(const std::vector<Frame>& frames) const;
    [[nodiscard]] int count(const std::vector<Frame>& frames, std::uint32_t id) const;

private:
    DrivePort* port_;
    std::uint8_t node_;
    std::uint32_t abort_ = 0;
    std::uint16_t statusword_ = 0;
    std::int32_t actual_ = 0;
};

}  // namespace sc::drive_check

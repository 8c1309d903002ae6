// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "boards/sim/cell.hpp"
#include "shared/link/blocks.hpp"
#include "shared/link/serial.hpp"
#include "shared/path/job_hash.hpp"

namespace sc::sim {

/// The least of a host: speaks the link to a cell in the same process, in the cell's time.
template <class Cell>
class BasicTestHost {
public:
    explicit BasicTestHost(Cell& cell) : cell_(&cell) {}

    template <class Message>
    void send(const Message& message) {
        std::array<std::uint8_t, link::kSerialCapacity> bytes{};
        const std::size_t size = link::encode_serial(message, counter_++, bytes);
        cell_->push_link(std::span(bytes).first(size));
    }

    /// Lets the cell live, with heartbeats (unless silent) and listening.
    void live(int ticks) {
        for (int i = 0; i < ticks; ++i) {
            if (!silent && cell_->now_ns() % 20'000'000 == 0) {
                send(link::Heartbeat{});
            }
            cell_->tick();
            received_.clear();
            cell_->take_link(received_);
            receiver_.receive(received_, [this](const link::Envelope& e) {
                (void)link::dispatch(link::CellMessages{}, e, [this](const auto& message) { this->take(message); });
            });
        }
    }

    [[nodiscard]] bool live_until(State state, int most_ticks) {
        for (int i = 0; i < most_ticks && cell_->state() != state; ++i) {
            live(1);
        }
        return cell_->state() == state;
    }

    [[nodiscard]] bool connect() {
        link::Hello hello;
        hello.schema = link::kSchemaHash;
        hello.session = 77;
        send(hello);
        for (int i = 0; i < 200 && !hello_; ++i) {
            live(1);
        }
        return hello_ && hello_->refusal == 0;
    }

    /// Refusal of a command, nothing when no answer came within 0.2 s.
    std::optional<std::uint16_t> command(link::Verb verb) {
        link::Command message;
        message.sequence = ++sequence_;
        message.verb = static_cast<std::uint8_t>(verb);
        send(message);
        return reply();
    }

    std::optional<std::uint16_t> open(std::span<const Item> items) {
        items_.assign(items.begin(), items.end());
        job_ = job_hash(items);
        send(link::JobOpen{++sequence_, job_, static_cast<std::uint32_t>(items.size())});
        return reply();
    }

    /// Sends the items from what the cell wants next on, at most `block` in one message; false when it takes no more.
    void stream(std::size_t block) {
        while (sent_ < items_.size() && sent_ < ack.received + ack.free_items) {
            const std::size_t end =
                std::min({sent_ + block, items_.size(), ack.received + std::size_t{ack.free_items}});
            const link::Block message =
                link::make_block(job_, std::span(items_).first(end), static_cast<std::uint32_t>(sent_));
            send(message);
            sent_ += message.count;
        }
    }

    /// Connects, powers, homes and arms.
    [[nodiscard]] bool prepare() {
        return connect() && live_until(State::disabled, 3000) && command(link::Verb::enable) == 0 &&
               live_until(State::idle, 3000) && command(link::Verb::home) == 0 && leave(State::idle) &&
               live_until(State::idle, 30'000) && command(link::Verb::arm) == 0 && live_until(State::armed, 3000);
    }

    /// Opens, starts and streams a job; true when the cell is armed again and has said that the job is done.
    [[nodiscard]] bool run(std::span<const Item> items, int most_ticks, std::size_t block = 40) {
        if (!begin(items)) {
            return false;
        }
        for (int i = 0; i < most_ticks && (status.flags & link::kFlagJobDone) == 0; ++i) {
            stream(block);
            live(1);
            if (cell_->faults() != 0 || refused) {
                return false;
            }
        }
        return (status.flags & link::kFlagJobDone) != 0;
    }
    [[nodiscard]] bool begin(std::span<const Item> items) {
        return open(items) == 0 && command(link::Verb::start) == 0;
    }

    bool silent = false;
    link::Status status;
    link::StreamAck ack;
    std::optional<link::JobRefused> refused;
    std::optional<link::Position> position;

private:
    [[nodiscard]] bool leave(State state) {
        for (int i = 0; i < 100 && cell_->state() == state; ++i) {
            live(1);
        }
        return cell_->state() != state;
    }
    std::optional<std::uint16_t> reply() {
        for (int i = 0; i < 200; ++i) {
            if (reply_ && reply_->sequence == sequence_) {
                return reply_->refusal;
            }
            live(1);
        }
        return std::nullopt;
    }
    void take(const link::HelloReply& message) { hello_ = message; }
    void take(const link::CommandReply& message) { reply_ = message; }
    void take(const link::StreamAck& message) { ack = message; }
    void take(const link::JobRefused& message) { refused = message; }
    void take(const link::Status& message) { status = message; }
    void take(const link::ConfigChunk&) {}
    void take(const link::Position& message) { position = message; }
    void take(const link::StreamMissing&) {}
    void take(const link::SensorReport&) {}
    void take(const link::ClockReply&) {}
    void take(const link::Telemetry&) {}
    void take(const link::BlackboxChunk&) {}
    void take(const link::Parameters&) {}
    void take(const link::SealChallenge&) {}

    Cell* cell_;
    std::uint16_t counter_ = 0;
    std::uint32_t sequence_ = 0;
    std::uint64_t job_ = 0;
    std::size_t sent_ = 0;
    std::vector<Item> items_;
    std::vector<std::uint8_t> received_;
    link::SerialReceiver receiver_;
    std::optional<link::HelloReply> hello_;
    std::optional<link::CommandReply> reply_;
};
using TestHost = BasicTestHost<SimCell>;

}  // namespace sc::sim

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "firmware/link/endpoint.hpp"
#include "shared/link/serial.hpp"

namespace sc::link {

/// The other end of an endpoint's wire, in memory: frames what a test sends and sorts what comes back.
class LinkHost {
public:
    template <class Message>
    std::vector<std::uint8_t> framed(const Message& message) {
        std::vector<std::uint8_t> bytes(kSerialCapacity);
        bytes.resize(encode_serial(message, counter_++, bytes, minor_));
        return bytes;
    }
    template <class Message>
    void send(Endpoint& endpoint, std::int64_t tick, const Message& message) {
        endpoint.receive(tick, framed(message));
    }
    void set_minor(std::uint8_t minor) {
        minor_ = minor;
        receiver_.set_minor(minor);
    }
    void set_counter(std::uint16_t counter) { counter_ = counter; }

    void take(std::span<const std::uint8_t> bytes) {
        receiver_.receive(bytes, [this](const Envelope& envelope) {
            const Dispatch result = dispatch(CellMessages{}, envelope, [this](const auto& message) { keep(message); });
            malformed += result == Dispatch::handled ? 0 : 1;
            order.push_back(envelope.id);
            counters.push_back(envelope.counter);
        });
    }
    /// Takes all that the endpoint sends now; how many bytes that was.
    std::size_t collect(Endpoint& endpoint, std::size_t room = 1024) {
        std::vector<std::uint8_t> bytes(room);
        const std::size_t size = endpoint.transmit(bytes);
        take(std::span(bytes).first(size));
        return size;
    }
    void clear() {
        hellos.clear();
        replies.clear();
        acks.clear();
        refused.clear();
        statuses.clear();
        chunks.clear();
        positions.clear();
        missing.clear();
        sensors.clear();
        clocks.clear();
        telemetry.clear();
        boxes.clear();
        order.clear();
    }

    std::vector<HelloReply> hellos;
    std::vector<CommandReply> replies;
    std::vector<StreamAck> acks;
    std::vector<JobRefused> refused;
    std::vector<Status> statuses;
    std::vector<ConfigChunk> chunks;
    std::vector<Position> positions;
    std::vector<StreamMissing> missing;
    std::vector<SensorReport> sensors;
    std::vector<ClockReply> clocks;
    std::vector<Telemetry> telemetry;
    std::vector<BlackboxChunk> boxes;
    std::vector<Parameters> parameters;
    std::vector<SealChallenge> challenges;
    std::vector<std::uint8_t> order;
    std::vector<std::uint16_t> counters;
    int malformed = 0;

    [[nodiscard]] std::uint32_t frames_bad() const { return receiver_.frames_bad(); }

private:
    void keep(const ClockReply& m) { clocks.push_back(m); }
    void keep(const Telemetry& m) { telemetry.push_back(m); }
    void keep(const BlackboxChunk& m) { boxes.push_back(m); }
    void keep(const SealChallenge& m) { challenges.push_back(m); }
    void keep(const Parameters& m) { parameters.push_back(m); }
    void keep(const SensorReport& m) { sensors.push_back(m); }
    void keep(const HelloReply& m) { hellos.push_back(m); }
    void keep(const CommandReply& m) { replies.push_back(m); }
    void keep(const StreamAck& m) { acks.push_back(m); }
    void keep(const JobRefused& m) { refused.push_back(m); }
    void keep(const Status& m) { statuses.push_back(m); }
    void keep(const ConfigChunk& m) { chunks.push_back(m); }
    void keep(const Position& m) { positions.push_back(m); }
    void keep(const StreamMissing& m) { missing.push_back(m); }

    SerialReceiver receiver_;
    std::uint16_t counter_ = 0;
    std::uint8_t minor_ = kProtocolMinor;
};

inline Hello hello_of(std::uint32_t session, std::uint16_t timeout_ms = 100) {
    Hello hello;
    hello.schema = kSchemaHash;
    hello.session = session;
    hello.heartbeat_timeout_ms = timeout_ms;
    return hello;
}

}  // namespace sc::link

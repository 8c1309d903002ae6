// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "firmware/hal/io.hpp"

namespace sc::sim {

/// What a slave puts on the line: bytes one after another, with a pause before one of them if it stutters.
struct SlaveAnswer {
    std::int64_t begin_ns = 0;
    std::vector<std::uint8_t> bytes;
    std::size_t pause_before = 0;  ///< 0: none
    std::int64_t pause_ns = 0;
};

/// A device on the line. It hears every byte, its own not.
class LineDevice {
public:
    LineDevice() = default;
    LineDevice(const LineDevice&) = delete;
    LineDevice& operator=(const LineDevice&) = delete;
    virtual ~LineDevice() = default;

    /// A byte whose stop bit ended at `end_ns`.
    virtual void hear(std::uint8_t byte, bool garbled, std::int64_t end_ns) = 0;
    /// When it wants to act, unless it hears more before; nullopt: not at all.
    [[nodiscard]] virtual std::optional<std::int64_t> due_ns() const = 0;
    /// Its time has come; what it sends, if anything.
    [[nodiscard]] virtual std::optional<SlaveAnswer> act(std::int64_t now_ns) = 0;
};

/// A half-duplex line in virtual time: bytes of two senders at once are garbled for all, and the controller hears
/// nothing while it sends. Devices are not owned.
class Rs485Line {
public:
    explicit Rs485Line(const SensorBusConfig& bus);

    void attach(LineDevice& device) { devices_.push_back(&device); }
    void transmit(std::int64_t begin_ns, std::span<const std::uint8_t> bytes);
    /// Noise: a byte that nobody sent.
    void disturb(std::int64_t begin_ns, std::uint8_t byte);
    /// Lives until `t_ns`.
    void run_to(std::int64_t t_ns);
    /// What the controller has heard since the last call, as its tick at `t_ns` is told it.
    void take(std::int64_t t_ns, std::vector<SensorByte>& out);
    [[nodiscard]] std::int64_t character_ns() const noexcept { return character_ns_; }
    [[nodiscard]] std::uint64_t collisions() const noexcept { return collisions_; }

private:
    struct Byte {
        std::int64_t end_ns;
        std::uint8_t data;
        std::size_t from;  ///< device, or kController, kNobody
        bool garbled;
    };
    struct Heard {
        std::int64_t end_ns;
        SensorByte byte;
    };
    static constexpr std::size_t kController = SIZE_MAX;
    static constexpr std::size_t kNobody = SIZE_MAX - 1;

    void put(std::int64_t begin_ns, std::uint8_t data, std::size_t from);
    void deliver(const Byte& byte);

    std::int64_t character_ns_;
    std::vector<LineDevice*> devices_;
    std::vector<Byte> on_line_;  ///< in order of their ends
    std::vector<Heard> heard_;
    std::int64_t deaf_from_ns_ = 0;  ///< while the controller sends
    std::int64_t deaf_to_ns_ = 0;
    std::uint64_t collisions_ = 0;
};

}  // namespace sc::sim

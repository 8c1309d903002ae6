// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <optional>
#include <vector>

#include "tests/stm32h743/model/machine.hpp"

/// A CAN bus frame by frame: arbitration by identifier, acknowledgement, errors and their counters. Bits are counted
/// without those that are stuffed.

namespace sc::model {

struct WireFrame {
    std::uint32_t id = 0;
    bool extended = false;
    bool remote = false;
    bool fd = false;
    bool fast = false;
    std::vector<std::uint8_t> data{};  ///< of a remote frame: none, and `asked` bytes
    std::uint8_t asked = 0;
    bool operator==(const WireFrame&) const = default;
};

struct WireRates {
    std::int64_t nominal = 0;  ///< bit/s
    std::int64_t data = 0;     ///< 0: reads classic frames alone
    bool operator==(const WireRates&) const = default;
};

enum class WireError : std::uint8_t { form = 2, ack = 3, bit = 5 };

class CanNode {
public:
    CanNode() = default;
    CanNode(const CanNode&) = delete;
    CanNode& operator=(const CanNode&) = delete;
    virtual ~CanNode() = default;

    /// From when it takes part; kNever when it does not.
    [[nodiscard]] virtual std::int64_t ready_ns() const = 0;
    [[nodiscard]] virtual std::optional<WireFrame> wants() const = 0;
    [[nodiscard]] virtual WireRates rates() const = 0;
    /// Can see that the fast bits that it sends itself arrive.
    [[nodiscard]] virtual bool hears_own_fast_bits() const { return true; }
    virtual void sent() = 0;
    virtual void heard(const WireFrame& frame, std::int64_t began_ns) = 0;
    virtual void failed(bool sender, WireError error) = 0;
};

class CanWire : public Peripheral {
public:
    /// Takes part in the machine's time.
    explicit CanWire(Machine& machine) : machine_(machine) { machine.attach(0, 0, *this); }
    void join(CanNode& node) { nodes_.push_back(&node); }
    /// The next `count` frames are disturbed.
    void disturb(unsigned count) { disturbed_ = count; }
    [[nodiscard]] std::int64_t busy_until_ns() const { return end_ns_; }
    [[nodiscard]] static std::int64_t duration_ns(const WireFrame& frame, const WireRates& rates);

    [[nodiscard]] std::uint32_t read(std::uint32_t /*offset*/) override { return 0; }
    void write(std::uint32_t /*offset*/, std::uint32_t /*value*/, unsigned /*bytes*/) override {}
    [[nodiscard]] std::int64_t next_ns() const override;
    void act(std::int64_t now_ns) override;

private:
    void begin(std::int64_t now_ns);
    void end(std::int64_t now_ns);

    Machine& machine_;
    std::vector<CanNode*> nodes_;
    CanNode* sender_ = nullptr;
    WireFrame frame_;
    std::int64_t began_ns_ = 0;
    std::int64_t end_ns_ = 0;
    unsigned disturbed_ = 0;
};

/// Another device on the bus.
class CanPeer : public CanNode {
public:
    explicit CanPeer(WireRates rates) : rates_(rates) {}
    std::deque<WireFrame> to_send;
    std::vector<WireFrame> frames;
    bool there = true;

    [[nodiscard]] std::int64_t ready_ns() const override { return there ? 0 : Peripheral::kNever; }
    [[nodiscard]] std::optional<WireFrame> wants() const override {
        return to_send.empty() ? std::nullopt : std::optional(to_send.front());
    }
    [[nodiscard]] WireRates rates() const override { return rates_; }
    void sent() override { to_send.pop_front(); }
    void heard(const WireFrame& frame, std::int64_t /*began_ns*/) override { frames.push_back(frame); }
    void failed(bool /*sender*/, WireError /*error*/) override { ++errors_; }
    [[nodiscard]] unsigned errors() const { return errors_; }

private:
    WireRates rates_;
    unsigned errors_ = 0;
};

}  // namespace sc::model

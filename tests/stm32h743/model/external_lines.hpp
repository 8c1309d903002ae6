// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>

#include "tests/stm32h743/model/optics.hpp"

/// Edges of pins of port E that interrupt, the choice of the port, and a timer that interrupts at its period. Numbers:
/// tests/data/stm32h743/lines.csv.

namespace sc::model {

/// SYSCFG's choice of a port for each line.
class PortChoice : public Peripheral {
public:
    static constexpr std::uint32_t kBase = 0x58000400;
    PortChoice(Machine& machine, const ClockGates& clocks) : machine_(machine), clocks_(clocks) {}
    [[nodiscard]] std::uint32_t read(std::uint32_t offset) override { return words_.at(offset / 4); }
    void write(std::uint32_t offset, std::uint32_t value, unsigned bytes) override;
    /// Port E is 4.
    [[nodiscard]] unsigned port_of(unsigned line) const { return (words_.at(2 + line / 4) >> (4 * (line % 4))) & 15U; }

private:
    Machine& machine_;
    const ClockGates& clocks_;
    std::array<std::uint32_t, 16> words_{};
};

/// EXTI, lines 0 to 15.
class EdgeLines : public Peripheral {
public:
    static constexpr std::uint32_t kBase = 0x58000000;
    static constexpr unsigned kInterrupt5To9 = 23;
    EdgeLines(Machine& machine, PortChoice& choice, EdgePort& port) : machine_(machine), choice_(choice), port_(port) {}
    [[nodiscard]] std::uint32_t read(std::uint32_t offset) override;
    void write(std::uint32_t offset, std::uint32_t value, unsigned bytes) override;
    /// A pin of port E moves.
    void set_pin(unsigned pin, bool high);
    [[nodiscard]] std::uint32_t pending() const { return pending_; }

private:
    void interrupt();
    Machine& machine_;
    PortChoice& choice_;
    EdgePort& port_;
    std::uint32_t pins_ = 0;
    std::uint32_t rising_ = 0;
    std::uint32_t falling_ = 0;
    std::uint32_t mask_ = 0;
    std::uint32_t pending_ = 0;
};

/// TIM7 at 240 MHz.
class PeriodTimer : public Peripheral {
public:
    static constexpr std::uint32_t kBase = 0x40001400;
    static constexpr unsigned kInterrupt = 55;
    PeriodTimer(Machine& machine, const ClockGates& clocks) : machine_(machine), clocks_(clocks) {}
    [[nodiscard]] std::uint32_t read(std::uint32_t offset) override { return words_.at(offset / 4); }
    void write(std::uint32_t offset, std::uint32_t value, unsigned bytes) override;
    [[nodiscard]] std::int64_t next_ns() const override;
    void act(std::int64_t now_ns) override;
    [[nodiscard]] std::int64_t started_ns() const { return started_ns_; }

private:
    void interrupt();
    Machine& machine_;
    const ClockGates& clocks_;
    std::array<std::uint32_t, 12> words_{};
    std::int64_t started_ns_ = 0;
    std::int64_t ticks_ = 0;
};

}  // namespace sc::model

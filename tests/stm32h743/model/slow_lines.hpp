// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <string>

#include "tests/stm32h743/model/optics.hpp"

/// A port of 16 slow pins, and a counter of 32 bits. Numbers: tests/data/stm32h743/io.csv.

namespace sc::model {

/// Port A (0) to K (10).
class SlowPort : public Peripheral {
public:
    static constexpr std::uint32_t kBase = 0x58020000;
    static constexpr std::uint32_t kStep = 0x400;
    /// Attaches itself.
    SlowPort(Machine& machine, const ClockGates& clocks, unsigned number);
    [[nodiscard]] std::uint32_t read(std::uint32_t offset) override;
    void write(std::uint32_t offset, std::uint32_t value, unsigned bytes) override;

    /// What drives pins from outside.
    void drive(std::uint32_t pins, std::uint32_t levels);
    /// Nothing drives them any more: they follow their pull resistors.
    void release(std::uint32_t pins) { driven_ &= ~pins; }
    /// Levels of pins that are outputs; the others are low, as an external pull-down holds them.
    [[nodiscard]] std::uint32_t levels() const { return level_ & outputs_; }
    /// Its alternate function; negative: it is none's.
    [[nodiscard]] int function(unsigned pin) const;
    /// Called with each change of the outputs: time, levels.
    std::function<void(std::int64_t, std::uint32_t)> on_change;
    /// Pins that have been outputs and high at once, ever.
    [[nodiscard]] std::uint32_t been_high() const { return been_high_; }

private:
    void note(const std::string& what);
    Machine& machine_;
    const ClockGates& clocks_;
    unsigned number_;
    std::uint32_t mode_ = 0xFFFFFFFF;
    std::uint32_t type_ = 0;
    std::uint32_t pull_ = 0;
    std::array<std::uint32_t, 2> function_{};
    std::uint32_t level_ = 0;
    std::uint32_t outputs_ = 0;
    std::uint32_t been_high_ = 0;
    std::uint32_t driven_ = 0;
    std::uint32_t outside_ = 0;
};

/// TIM5, 240 MHz, with two compare registers that ask for DMA, the second for a burst.
class Counter : public Peripheral {
public:
    static constexpr std::uint32_t kBase = 0x40000C00;
    static constexpr std::uint32_t kRequest1 = 55;
    static constexpr std::uint32_t kRequest2 = 56;
    /// Attaches itself. Without `dma` nothing may ask for it.
    Counter(Machine& machine, const ClockGates& clocks, DmaModel* dma = nullptr);
    [[nodiscard]] std::uint32_t read(std::uint32_t offset) override;
    void write(std::uint32_t offset, std::uint32_t value, unsigned bytes) override;
    [[nodiscard]] std::int64_t next_ns() const override { return next_ns_; }
    void act(std::int64_t now_ns) override;
    /// The oscillator stops.
    void stop() { stopped_ = true; }
    [[nodiscard]] std::int64_t started_ns() const { return started_ns_; }

private:
    [[nodiscard]] std::uint32_t count() const;
    [[nodiscard]] bool asks(unsigned channel) const;
    [[nodiscard]] std::int64_t due_ns(unsigned channel) const;
    void schedule();
    void ask(unsigned channel);
    Machine& machine_;
    const ClockGates& clocks_;
    DmaModel* dma_;
    std::array<std::uint32_t, 20> words_{};
    std::int64_t started_ns_ = -1;
    std::uint32_t from_ = 0;
    std::uint32_t prescaler_ = 0;                  ///< in force
    std::uint32_t burst_ = 0;                      ///< word of the burst that comes next
    std::array<std::int64_t, 2> last_ns_{-1, -1};  ///< when each compare asked
    std::int64_t next_ns_ = kNever;
    bool stopped_ = false;
};

}  // namespace sc::model

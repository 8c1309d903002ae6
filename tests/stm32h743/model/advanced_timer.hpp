// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "tests/stm32h743/model/optics.hpp"

/// TIM1: preload and shadow registers, repetitions, a burst of DMA on each update, outputs by compare in PWM modes 1, 2
/// and the first combined one, main output enable with break and lock. 240 MHz. Numbers: tests/data/stm32h743/gate.csv.

namespace sc::model {

class AdvancedTimer : public Peripheral {
public:
    static constexpr std::uint32_t kBase = 0x40010000;
    static constexpr std::uint32_t kRequest = 15;
    /// From an update to the end of its burst of five words, ns.
    static constexpr std::int64_t kBurstCounts = 72;
    struct Level {
        std::int64_t count = 0;  ///< since the counter was started
        bool gate = false;       ///< channel 1, PE9
        bool trigger = false;    ///< channel 3, PE13
    };
    AdvancedTimer(Machine& machine, const ClockGates& clocks, DmaModel& dma, const EdgePort& port)
        : machine_(machine), clocks_(clocks), dma_(dma), port_(port) {
        words_[0x2C / 4] = 0xFFFF;  // as the reset leaves them
        words_[0x60 / 4] = 1;
    }
    [[nodiscard]] std::uint32_t read(std::uint32_t offset) override;
    void write(std::uint32_t offset, std::uint32_t value, unsigned bytes) override;
    [[nodiscard]] std::int64_t next_ns() const override;
    void act(std::int64_t now_ns) override;

    /// PE15; its pull-down holds it low when nothing drives it.
    void set_break_pin(bool high);
    /// What the pins showed: a new entry for each change.
    std::vector<Level> levels;
    [[nodiscard]] std::int64_t started_ns() const { return started_ns_; }

private:
    struct Periodic {
        std::uint32_t reload = 0xFFFF;
        std::array<std::uint32_t, 4> compare{};
        bool operator==(const Periodic&) const = default;
    };
    [[nodiscard]] bool counts() const { return (words_[0x00 / 4] & 1U) != 0; }
    [[nodiscard]] std::int64_t count_now() const;
    [[nodiscard]] std::int64_t next_count() const;
    [[nodiscard]] bool reference(unsigned channel, std::int64_t count) const;
    [[nodiscard]] bool single(unsigned mode, unsigned channel, std::int64_t count) const;
    [[nodiscard]] unsigned mode(unsigned channel) const;
    [[nodiscard]] bool break_active() const;
    void take(std::uint32_t offset, std::uint32_t value);
    void take_bdtr(std::uint32_t value);
    void update();
    void burst();
    void see(std::int64_t count);

    Machine& machine_;
    const ClockGates& clocks_;
    DmaModel& dma_;
    const EdgePort& port_;
    std::array<std::uint32_t, 32> words_{};
    Periodic shadow_;
    std::uint32_t left_ = 0;  ///< repetitions
    std::int64_t started_ns_ = 0;
    std::int64_t base_ = 0;  ///< count at which this period began
    std::int64_t seen_ = 0;  ///< levels are right up to here
    std::int64_t burst_at_ = kNever;
    std::uint32_t burst_index_ = 0;
    bool bursting_ = false;
    bool pin_ = false;
    Level last_;
};

}  // namespace sc::model

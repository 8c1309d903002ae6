// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "tests/stm32h743/model/machine.hpp"
#include "tests/stm32h743/model/register_words.hpp"

/// What plays waveforms: clock enables, a timer that asks for DMA, eight DMA streams behind the request multiplexer,
/// and a port whose edges are recorded. Numbers: tests/data/stm32h743/optics.csv.

namespace sc::model {

/// Registers of RCC that let clocks through.
class ClockGates : public RegisterWords {
public:
    static constexpr std::uint32_t kBase = rcc::kBase;
    static constexpr std::uint32_t kAhb1 = rcc::kAhb1;
    static constexpr std::uint32_t kAhb2 = 0xDC;
    static constexpr std::uint32_t kAhb4 = 0xE0;
    static constexpr std::uint32_t kApb1l = rcc::kApb1l;
    static constexpr std::uint32_t kApb2 = rcc::kApb2;
    static constexpr std::uint32_t kApb4 = 0xF4;
    explicit ClockGates(Machine& machine) : machine_(machine) {}
    void write(std::uint32_t offset, std::uint32_t value, unsigned bytes) override;
    /// Notes a violation when the clock of `who` is off.
    bool check(std::uint32_t offset, unsigned bit, const char* who) const;

private:
    Machine& machine_;
};

/// Port E. Edges of pins that are outputs, in order.
class EdgePort : public Peripheral {
public:
    static constexpr std::uint32_t kBase = 0x58021000;
    struct Edge {
        std::int64_t ns = 0;
        std::uint32_t before = 0;  ///< levels of all pins
        std::uint32_t after = 0;
    };
    EdgePort(Machine& machine, const ClockGates& clocks) : machine_(machine), clocks_(clocks) {}
    [[nodiscard]] std::uint32_t read(std::uint32_t offset) override;
    void write(std::uint32_t offset, std::uint32_t value, unsigned bytes) override;
    std::vector<Edge> edges;
    /// Called with each change: levels before and after.
    std::function<void(std::uint32_t, std::uint32_t)> on_edge;
    /// What drives a pin that is an input; undriven it follows its pull-down.
    void set_input(unsigned pin, bool high) { input_ = (input_ & ~(1U << pin)) | (high ? 1U << pin : 0U); }
    /// Called behind each reading of the inputs.
    std::function<void()> after_read;
    /// Its alternate function; none: it is another's.
    [[nodiscard]] int function(unsigned pin) const;
    [[nodiscard]] bool pulled_down(unsigned pin) const { return ((pull_ >> (2 * pin)) & 3U) == 2; }

private:
    [[nodiscard]] std::uint32_t outputs() const { return outputs_; }
    Machine& machine_;
    const ClockGates& clocks_;
    std::uint32_t mode_ = 0xFFFFFFFF;
    std::uint32_t outputs_ = 0;
    std::uint32_t type_ = 0;
    std::uint32_t speed_ = 0;
    std::uint32_t pull_ = 0;
    std::uint32_t input_ = 0;
    std::array<std::uint32_t, 2> function_{};
    std::uint32_t level_ = 0;
};

/// DMA1 with its part of DMAMUX1, or DMA2 with its own.
class DmaModel : public Peripheral {
public:
    static constexpr std::uint32_t kBase = 0x40020000;
    static constexpr std::uint32_t kBase2 = 0x40020400;
    static constexpr std::uint32_t kMuxBase = 0x40020800;
    static constexpr std::uint32_t kMuxBase2 = 0x40020820;
    /// The multiplexer is another peripheral on the bus.
    class Mux : public Peripheral {
    public:
        explicit Mux(DmaModel& dma) : dma_(dma) {}
        [[nodiscard]] std::uint32_t read(std::uint32_t offset) override { return dma_.request_.at(offset / 4); }
        void write(std::uint32_t offset, std::uint32_t value, unsigned bytes) override;

    private:
        DmaModel& dma_;
    };
    enum class Which : std::uint8_t { first, second };
    DmaModel(Machine& machine, const ClockGates& clocks, Which which = Which::first)
        : mux(*this), machine_(machine), clocks_(clocks), which_(which) {}
    [[nodiscard]] std::uint32_t read(std::uint32_t offset) override;
    void write(std::uint32_t offset, std::uint32_t value, unsigned bytes) override;
    /// A peripheral asks for a transfer.
    void request(std::uint32_t line);
    Mux mux;

private:
    struct Stream {
        std::uint32_t cr = 0;
        std::uint32_t left = 0;
        std::uint32_t par = 0;
        std::array<std::uint32_t, 2> memory{};
        std::uint32_t fcr = 0x21;
        std::uint32_t count = 0;
        std::uint32_t at = 0;
        std::uint32_t flags = 0;
        std::uint32_t ahead = 0;  ///< read, and not yet asked for
    };
    void read_ahead(Stream& stream);
    void control(unsigned n, std::uint32_t value);
    void transfer(unsigned n);
    void finish(unsigned n);
    void note(const std::string& what) const { machine_.violation(std::string(name()) + ": " + what); }
    [[nodiscard]] const char* name() const { return which_ == Which::first ? "DMA1" : "DMA2"; }
    [[nodiscard]] unsigned clock_bit() const { return which_ == Which::first ? 0 : 1; }
    Machine& machine_;
    const ClockGates& clocks_;
    Which which_;
    std::array<Stream, 8> streams_{};
    std::array<std::uint32_t, 8> request_{};
};

/// TIM6: up to the auto-reload, from 0 again. 240 MHz.
class BasicTimer : public Peripheral {
public:
    static constexpr std::uint32_t kBase = 0x40001000;
    static constexpr std::uint32_t kRequest = 69;
    BasicTimer(Machine& machine, const ClockGates& clocks, DmaModel& dma)
        : machine_(machine), clocks_(clocks), dma_(dma) {}
    [[nodiscard]] std::uint32_t read(std::uint32_t offset) override;
    void write(std::uint32_t offset, std::uint32_t value, unsigned bytes) override;
    [[nodiscard]] std::int64_t next_ns() const override;
    void act(std::int64_t now_ns) override;
    [[nodiscard]] bool minds_its_own() const override { return true; }
    /// For the edge that counts: when the counter was started.
    std::int64_t started_ns = 0;

private:
    void update();
    Machine& machine_;
    const ClockGates& clocks_;
    DmaModel& dma_;
    std::array<std::uint32_t, 256> words_{};
    std::int64_t ticks_ = 0;  ///< from the start to the next update
};

}  // namespace sc::model

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <map>
#include <string>

#include "tests/stm32h743/model/machine.hpp"
#include "tests/stm32h743/model/register_words.hpp"

/// DMA1 as USARTs use it: bytes between a register and memory, once or in a circle, asked for through the multiplexer.

namespace sc::model {

class ByteDma : public Peripheral {
public:
    static constexpr std::uint32_t kBase = 0x40020000;
    static constexpr std::uint32_t kSize = 0x400;
    static constexpr std::uint32_t kMuxBase = 0x40020800;
    static constexpr std::uint32_t kMuxSize = 0x80;

    ByteDma(Machine& machine, const RegisterWords& clocks);
    /// `again` is called when a stream that serves `request` may move bytes (again).
    void on_ready(std::uint32_t request, std::function<void()> again) { ready_[request] = std::move(again); }
    /// A peripheral asks for one byte to be moved; false when no stream serves it now.
    bool serve(std::uint32_t request);
    /// Other masters hold the bus.
    void hold(bool on);
    /// The next byte of the stream meets an error of the bus.
    void fail_next(unsigned stream) { streams_.at(stream).fails = true; }

    [[nodiscard]] std::uint32_t read(std::uint32_t offset) override;
    void write(std::uint32_t offset, std::uint32_t value, unsigned bytes) override;
    [[nodiscard]] std::int64_t next_ns() const override;
    void act(std::int64_t now_ns) override;

private:
    struct Stream {
        std::uint32_t settings = 0;
        std::uint32_t count = 0;
        std::uint32_t loaded = 0;
        std::uint32_t peripheral = 0;
        std::uint32_t memory = 0;
        std::uint32_t flags = 0;
        std::int64_t stops_ns = kNever;
        bool enabled = false;
        bool fails = false;
    };
    void note(unsigned stream, const std::string& what);
    void write_settings(unsigned n, std::uint32_t value);
    void start(unsigned n);

    Machine& machine_;
    const RegisterWords& clocks_;
    RegisterWords mux_;
    std::array<Stream, 8> streams_;
    std::map<std::uint32_t, std::function<void()>> ready_;
    bool held_ = false;
};

}  // namespace sc::model

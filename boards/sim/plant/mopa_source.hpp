// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "shared/machine/machine.hpp"

namespace sc::sim {

/// The serial port of a MOPA source, byte by byte as its maker's manual has it; it answers two ticks later. One thread.
class MopaSource {
public:
    explicit MopaSource(LaserSource maker) : maker_(maker) {}

    void receive(std::span<const std::uint8_t> bytes);
    /// Appends what it has to say in this tick.
    void take(std::vector<std::uint8_t>& out);
    /// The master oscillator is on: the width stays as it is.
    void emit(bool on) noexcept { emits_ = on; }
    void mute(bool on) noexcept { mute_ = on; }
    /// It answers with the width in force, whatever was asked for.
    void stay(bool on) noexcept { stays_ = on; }
    [[nodiscard]] unsigned width_ns() const noexcept { return width_ns_; }

private:
    void hear_raycus(std::uint8_t byte);
    void hear_jpt(std::uint8_t byte);
    void answer(std::vector<std::uint8_t> bytes);
    [[nodiscard]] bool change(unsigned width_ns);

    LaserSource maker_;
    unsigned width_ns_ = 100;
    bool emits_ = false;
    bool mute_ = false;
    bool stays_ = false;
    std::vector<std::uint8_t> frame_;
    std::string line_;
    std::vector<std::uint8_t> answer_;
    int answer_in_ = 0;
};

}  // namespace sc::sim

// SPDX-License-Identifier: Apache-2.0
#include "boards/linux_rt/lines.hpp"

#include <bit>

#include "firmware/recording/io_image.hpp"

namespace sc::linux_rt {

LineSample Lines::sample() noexcept {
    InputBits fell = 0;
    InputBits rose = 0;
    port_->edges(fell, rose);
    const InputBits now = port_->levels();
    const auto changed = static_cast<InputBits>(now ^ last_);
    const auto told = static_cast<InputBits>((fell & ~now) | (rose & now));
    counters_.edges += static_cast<unsigned>(std::popcount(fell) + std::popcount(rose));
    counters_.glitches += static_cast<unsigned>(std::popcount(static_cast<InputBits>(fell & now & last_)));
    counters_.missed += static_cast<unsigned>(std::popcount(static_cast<InputBits>(changed & ~told)));
    last_ = now;
    return {now, static_cast<InputBits>(now & ~fell)};
}

void Lines::write(const DigitalOutputs& outputs) noexcept { port_->write(bits_of(outputs)); }

DigitalInputs digital_of(InputBits bits) noexcept { return recording::digital_inputs(bits); }

OutputBits bits_of(const DigitalOutputs& o) noexcept {
    unsigned bits = 0;
    const auto add = [&bits](bool on, Output line) { bits |= on ? unsigned{bit(line)} : 0U; };
    add(o.master_oscillator, Output::master_oscillator);
    add(o.guide_laser, Output::guide);
    add(o.light_red, Output::red);
    add(o.light_yellow, Output::yellow);
    add(o.light_green, Output::green);
    add(o.shutter_open, Output::shutter);
    return static_cast<OutputBits>(bits);
}

}  // namespace sc::linux_rt

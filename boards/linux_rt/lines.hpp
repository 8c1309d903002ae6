// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <string_view>

#include "firmware/hal/io.hpp"

namespace sc::linux_rt {

/// Inputs as bits, in the order of recording::bits_of; 1 is healthy.
enum class Input : std::uint8_t {
    estop = 0,
    interlock = 1,
    laser_ready = 2,
    laser_no_alarm = 3,
    shutter_open = 4,
    shutter_closed = 5,
    key_setup = 6,
    key_production = 7,
};
inline constexpr std::size_t kInputs = 8;
inline constexpr std::array<std::string_view, kInputs> kInputNames{"estop",          "interlock",     "laser-ready",
                                                                   "laser-no-alarm", "shutter-open",  "shutter-closed",
                                                                   "key-setup",      "key-production"};
using InputBits = std::uint8_t;
[[nodiscard]] constexpr InputBits bit(Input input) noexcept {
    return static_cast<InputBits>(1U << static_cast<unsigned>(input));
}

enum class Output : std::uint8_t {
    master_oscillator = 0,
    guide = 1,
    red = 2,
    yellow = 3,
    green = 4,
    shutter = 5,
    gate = 6
};
inline constexpr std::size_t kOutputs = 7;
inline constexpr std::array<std::string_view, kOutputs> kOutputNames{"mo",    "guide",   "red", "yellow",
                                                                     "green", "shutter", "gate"};
using OutputBits = std::uint8_t;
[[nodiscard]] constexpr OutputBits bit(Output output) noexcept {
    return static_cast<OutputBits>(1U << static_cast<unsigned>(output));
}

/// Where the lines are wired. No call blocks or allocates.
class LinePort {
public:
    LinePort() = default;
    LinePort(const LinePort&) = delete;
    LinePort& operator=(const LinePort&) = delete;
    virtual ~LinePort() = default;

    /// Lines that are wired; the others read 0.
    [[nodiscard]] virtual InputBits wired() const noexcept = 0;
    /// Levels now. A line that cannot be read is 0.
    [[nodiscard]] virtual InputBits levels() noexcept = 0;
    /// Lines that have had an edge to 0, and to 1, since the last call, as the kernel saw them.
    virtual void edges(InputBits& fell, InputBits& rose) noexcept = 0;
    virtual void write(OutputBits bits) noexcept = 0;
};

struct LineCounters {
    std::uint64_t edges = 0;     ///< events, of whatever line
    std::uint64_t glitches = 0;  ///< lines that had gone and come back between two looks
    std::uint64_t missed =
        0;  ///< levels that had changed without an event, or before it was there: only the level told
};

struct LineSample {
    InputBits levels = 0;  ///< as they are now
    InputBits worst = 0;   ///< healthy now and ever since the last look
};

/// Levels and events together: an event that the kernel's short queue has lost is caught by the level, a pulse between
/// two looks by its event.
class Lines {
public:
    explicit Lines(LinePort& port) noexcept : port_(&port), last_(port.levels()) {}
    [[nodiscard]] LineSample sample() noexcept;
    void write(const DigitalOutputs& outputs) noexcept;
    /// Everything off.
    void make_safe() noexcept { port_->write(0); }
    [[nodiscard]] const LineCounters& counters() const noexcept { return counters_; }

private:
    LinePort* port_;
    InputBits last_;
    LineCounters counters_;
};

/// A cell without wired lines, for tests and for a first start on a bench: the chains read closed, the key stands at
/// production. Never with a laser that can burn.
class ClosedLines final : public LinePort {
public:
    [[nodiscard]] InputBits wired() const noexcept override { return kClosed; }
    [[nodiscard]] InputBits levels() noexcept override { return kClosed; }
    void edges(InputBits& fell, InputBits& rose) noexcept override { fell = rose = 0; }
    void write(OutputBits /*bits*/) noexcept override {}

private:
    static constexpr InputBits kClosed =
        static_cast<InputBits>(bit(Input::estop) | bit(Input::interlock) | bit(Input::key_production));
};

/// The lines of the controller's inputs from their bits; source_status is 0.
[[nodiscard]] DigitalInputs digital_of(InputBits bits) noexcept;
[[nodiscard]] OutputBits bits_of(const DigitalOutputs& outputs) noexcept;

}  // namespace sc::linux_rt

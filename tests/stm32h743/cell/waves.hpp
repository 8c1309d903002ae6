// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "tests/stm32h743/model/advanced_timer.hpp"

/// What the pins showed, against what the controller asked for. Knows the lines' formats, nothing of the drivers.

namespace sc::stm32h743::cell {

/// XY2-100 frames from the edges of four lines: clock, sync, x, z as bits 2 to 5 of a port. A head samples with the
/// falling clock; sync is low for the last bit.
class GalvoLine {
public:
    struct Frame {
        std::int64_t begin_ns = 0;
        std::uint32_t word_x = 0;
        std::uint32_t word_z = 0;
    };
    /// The frame that a change of the lines completes.
    [[nodiscard]] std::optional<Frame> edge(std::int64_t ns, std::uint32_t before, std::uint32_t after);
    /// Frames that were not of 20 bits.
    [[nodiscard]] unsigned broken() const { return broken_; }

private:
    Frame frame_;
    unsigned bits_ = 0;
    unsigned broken_ = 0;
};

/// Edges of the trigger line that the pins showed, in counts of 240 MHz from the control time 0.
class TriggerLine {
public:
    struct Trigger {
        std::int64_t count = 0;
        bool passes = false;  ///< the gate is open
    };
    /// `count`: of the timer at the control time 0.
    void set_origin(std::int64_t count) { origin_ = count; }
    void take(std::vector<model::AdvancedTimer::Level>& levels, std::vector<Trigger>& out);

private:
    std::int64_t origin_ = 0;
    bool trigger_ = false;
};

/// The power byte as a type-D source takes it: bits 0 to 7 of a port, its latch bit 8.
class PowerLine {
public:
    PowerLine(std::int64_t setup_ns, std::int64_t width_ns) : setup_ns_(setup_ns), width_ns_(width_ns) {}
    void change(std::int64_t ns, std::uint32_t levels);
    /// The byte in force at a time; negative before the first.
    [[nodiscard]] int at(std::int64_t ns) const;
    /// Strobes that were too short, or whose byte did not stand long enough or changed meanwhile.
    [[nodiscard]] unsigned bad() const { return bad_; }
    [[nodiscard]] std::size_t strobes() const { return taken_.size(); }

private:
    struct Taken {
        std::int64_t ns = 0;
        int byte = 0;
    };
    std::int64_t setup_ns_;
    std::int64_t width_ns_;
    std::vector<Taken> taken_;
    std::uint32_t levels_ = 0;
    std::int64_t laid_ns_ = 0;
    std::int64_t rose_ns_ = 0;
    unsigned bad_ = 0;
};

}  // namespace sc::stm32h743::cell

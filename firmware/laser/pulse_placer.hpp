// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "firmware/hal/io.hpp"
#include "firmware/motion/planner.hpp"

/// Pulses at equal distance along the path. Pulse k of a pass belongs at mark begin + k · pitch; the time at which the
/// planned beam is there is solved from the time law, so pitch does not depend on speed, and nothing is accumulated
/// from tick to tick.
///
/// The source runs at `pick` times the pulse rate, within (nominal/2, nominal], and its power byte is scaled with that
/// rate, so that the energy of a pulse stays while the speed changes.

namespace sc::laser {

struct PulseSpec {
    std::uint32_t path = 0;
    std::uint8_t pass = 0;
    double pitch = 0.0;        ///< m
    double energy = 0.0;       ///< J
    double speed_min = 0.0;    ///< m/s: no pulse below
    double prr_min = 0.0;      ///< Hz
    double prr_nominal = 0.0;  ///< Hz
    double power = 0.0;        ///< W at power byte 255
};

/// How a pulse is made at a beam speed.
struct Firing {
    std::uint8_t pick = 1;
    std::uint8_t power = 0;
    bool possible = false;
};
[[nodiscard]] Firing firing_at(double speed, const PulseSpec& spec) noexcept;

class PulsePlacer {
public:
    /// Begins a pass at pulse 0.
    void open(const PulseSpec& spec) noexcept;
    /// All pulses with path times in [from, to), in order, into out.pulses and (as runs with absolute times) out.laser.
    /// `act` is the control time in ns that belongs to path time 0, latencies included. Appends; stops at the capacity
    /// of either, which 512 kHz does not reach. Servo context; some 300 operations a pulse.
    void place(const motion::Planner& planner, double from, double to, std::int64_t act_ns, ServoOutputs& out) noexcept;

    [[nodiscard]] std::uint32_t next_pulse() const noexcept { return next_; }
    /// True distance along the path at which the next pulse belongs.
    [[nodiscard]] double next_distance(const motion::Planner& planner) const noexcept {
        return planner.builder().mark_begin() + static_cast<double>(next_) * spec_.pitch;
    }
    /// Every pulse of the finished path has been placed.
    [[nodiscard]] bool done(const motion::Planner& planner) const noexcept;
    /// Pulses passed over because the beam was slower than it may be.
    [[nodiscard]] std::uint32_t withheld() const noexcept { return withheld_; }
    /// Item of the point before the last pulse placed.
    [[nodiscard]] std::uint32_t last_item() const noexcept { return last_item_; }

private:
    struct Solved {
        bool found = false;
        double time = 0.0;
        motion::MotionState state;
    };
    [[nodiscard]] Solved solve(const motion::Planner& planner, double distance, double low, double high) noexcept;
    void emit(const motion::Planner& planner, const Solved& solved, std::int64_t act_ns, ServoOutputs& out) noexcept;

    PulseSpec spec_;
    std::uint32_t next_ = 0;
    std::uint32_t withheld_ = 0;
    std::uint32_t last_item_ = 0;
    double last_time_ = -1.0;
    std::uint32_t hint_ = 0;
    // The run that is being built: the last two trigger times, in 1/256 ns.
    std::int64_t last_trigger_ = 0;
};

}  // namespace sc::laser

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

/// Firing over speed for one pulse spec, divisions done beforehand.
class FiringRule {
public:
    FiringRule() noexcept = default;
    explicit FiringRule(const PulseSpec& spec) noexcept;
    /// What is made at `speed`; `pick_hint` ≥ 1, where to look first, changes the cost and not the result.
    [[nodiscard]] Firing at(double speed, std::uint8_t pick_hint) const noexcept;

private:
    double rate_per_speed_ = 0.0;
    double speed_min_ = 1e30;
    double prr_min_ = 0.0;
    double prr_top_ = 0.0;  ///< nominal, and a little for rounding
    double code_per_hz_ = 0.0;
};
[[nodiscard]] Firing firing_at(double speed, const PulseSpec& spec) noexcept;

class PulsePlacer {
public:
    /// Begins a pass at pulse 0.
    void open(const PulseSpec& spec) noexcept;
    /// All pulses with path times in [from, to), at most 8 ms, in order, into out.pulses and (as runs with absolute
    /// times) out.laser. `act_ns` is the control time that belongs to path time 0, latencies included. Appends; stops
    /// at the capacity of either, which 512 kHz does not reach. Servo context; some 150 operations a pulse, no division
    /// or root but at the start of a law's piece.
    void place(const motion::Planner& planner, std::int64_t from_ns, std::int64_t to_ns, std::int64_t act_ns,
               ServoOutputs& out) noexcept;

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
    /// A place on the path, and when and how fast the beam is there.
    struct Solved {
        double time = 0.0;
        double way = 0.0;
        double speed = 0.0;  ///< d(true distance)/dt
    };
    [[nodiscard]] Solved evaluate(const motion::Segment& segment, double t) const noexcept;
    [[nodiscard]] Solved solve(const motion::Segment& segment, double length, double low, double high) noexcept;
    [[nodiscard]] Solved solve_slowly(const motion::Segment& segment, double length, double low, double high) noexcept;
    void emit(const motion::Segment& segment, const Solved& solved, std::int64_t t_ns256, std::int64_t t_ns,
              ServoOutputs& out) noexcept;
    void trigger(std::int64_t t_ns256, double speed, const Firing& firing, ServoOutputs& out) noexcept;

    PulseSpec spec_;
    FiringRule rule_;
    std::int64_t pitch_pm_ = 0;
    std::uint32_t next_ = 0;
    std::uint32_t withheld_ = 0;
    std::uint32_t last_item_ = 0;
    double last_time_ = 0.0;
    double slowness_ = 0.0;  ///< seconds a metre at the last pulse
    std::uint8_t last_pick_ = 1;
    std::uint32_t hint_ = 0;
    // The run that is being built, in 1/256 ns: its last trigger, when it puts the next, and by how much then the one
    // after that.
    std::int64_t last_trigger_ = 0;
    std::int64_t expected_ = 0;
    std::int64_t step_ = 0;
};

}  // namespace sc::laser

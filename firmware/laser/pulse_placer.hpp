// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "firmware/hal/io.hpp"
#include "firmware/motion/path_motion.hpp"
#include "shared/machine/power_curve.hpp"
#include "shared/math/scalar.hpp"

/// Pulses at equal distance along the path. Pulse k of a pass belongs at mark begin + k · pitch; the time at which the
/// planned beam is there is solved from the time law, so pitch does not depend on speed, and nothing is accumulated
/// from tick to tick. Behind a dark part of the path the pitches begin anew, and the numbers go on.
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
    double power = 0.0;        ///< W at power byte 255 (and prr_nominal, where the byte sets the energy)
    PowerCurve curve;          ///< and at the others, if measured
    PowerByte power_byte = PowerByte::average_power;
};

/// How a pulse is made at a beam speed.
struct Firing {
    std::uint32_t pick = 1;   ///< 1 … 255
    std::uint32_t power = 0;  ///< 0 … 255
    bool possible = false;
};

/// Firing over speed for one pulse spec, divisions done beforehand.
class FiringRule {
public:
    FiringRule() noexcept = default;
    explicit FiringRule(const PulseSpec& spec) noexcept;
    /// What is made at `speed`; `pick_hint` ≥ 1, where to look first, changes the cost and not the result.
    [[nodiscard]] Firing at(double speed, std::uint32_t pick_hint) const noexcept {
        Firing firing;
        if (!(speed >= speed_min_)) {
            return firing;
        }
        const double rate = speed * rate_per_speed_;
        std::uint32_t pick = pick_hint;
        while (pick < kMostPick && rate * static_cast<double>(pick + 1) <= prr_top_) {
            ++pick;
        }
        while (pick > 1 && rate * static_cast<double>(pick) > prr_top_) {
            --pick;
        }
        const double prr = rate * static_cast<double>(pick);
        firing.pick = pick;
        firing.power = static_cast<std::uint32_t>(nearest32_within(code_at(smaller(prr, prr_top_)) + code_));
        firing.power = firing.power < kMostPower ? firing.power : kMostPower;
        firing.possible = firing.power > 0 && prr >= prr_min_ && prr <= prr_top_ * 1.0001;
        return firing;
    }

private:
    static constexpr std::uint32_t kMostPick = 255;
    static constexpr std::uint32_t kMostPower = 255;
    /// The measured curve's stretches turned round, over the source's rate at this energy: those alone that lie within
    /// [nominal/2, nominal].
    struct Stretch {
        double end_hz = 0.0;
        double code = 0.0;  ///< at 0 Hz
        double code_per_hz = 0.0;
    };
    void turn_round(const PowerCurve& curve, double energy, double prr_nominal) noexcept;
    /// Power byte for the energy at a rate of the source, before rounding; from 0 on.
    [[nodiscard]] double code_at(double prr) const noexcept {
        if (stretches_ == 0) {
            return prr * code_per_hz_;
        }
        std::uint32_t i = 0;
        while (i + 1 < stretches_ && prr > stretch_[i].end_hz) {
            ++i;
        }
        return larger(stretch_[i].code + prr * stretch_[i].code_per_hz, 0.0);
    }
    std::array<Stretch, PowerCurve::kPoints - 1> stretch_{};
    std::uint32_t stretches_ = 0;
    double rate_per_speed_ = 0.0;
    double speed_min_ = 1e30;
    double prr_min_ = 0.0;
    double prr_top_ = 0.0;      ///< nominal, and a little for rounding
    double code_per_hz_ = 0.0;  ///< 0 where the byte sets the energy of a pulse …
    double code_ = 0.0;         ///< … and 0 where it sets the average power
};
[[nodiscard]] Firing firing_at(double speed, const PulseSpec& spec) noexcept;

class PulsePlacer {
public:
    /// Begins a pass at pulse 0, or behind those that are done already.
    void open(const PulseSpec& spec, std::uint32_t done = 0) noexcept;
    /// All pulses with path times in [from, to), at most 8 ms, in order, into out.pulses and (as runs with absolute
    /// times) out.laser. `act_ns` is the control time that belongs to path time 0, latencies included. Appends; stops
    /// at the capacity of either, which 512 kHz does not reach. Servo context; some 120 operations a pulse.
    ///
    /// Pulses are placed in groups of up to 16: the first and the last are solved exactly, the times between them
    /// follow a cubic through both with their slopes, and a group whose middle is off by more than 1 nm is halved.
    void place(const motion::PathMotion& path, std::int64_t from_ns, std::int64_t to_ns, std::int64_t act_ns,
               ServoOutputs& out) noexcept;

    [[nodiscard]] std::uint32_t next_pulse() const noexcept { return next_; }
    /// True distance along the path at which the next pulse belongs.
    [[nodiscard]] double next_distance(const motion::PathMotion& path) const noexcept;
    /// Every pulse of the finished path has been placed.
    [[nodiscard]] bool done(const motion::PathMotion& path) const noexcept;
    /// Pulses passed over because the beam was slower than it may be.
    [[nodiscard]] std::uint32_t withheld() const noexcept { return withheld_; }
    /// Item of the point before the last pulse placed.
    [[nodiscard]] std::uint32_t last_item() const noexcept { return last_item_; }

private:
    /// When and how fast the beam is at a place.
    struct Solved {
        double time = 0.0;
        double speed = 0.0;  ///< d(true distance)/dt
    };
    [[nodiscard]] static Solved solve_slowly(const motion::Segment& segment, double length, double low,
                                             double high) noexcept;
    [[nodiscard]] std::uint32_t pulses_of(const motion::Stretch& stretch) const noexcept;
    [[nodiscard]] bool next_stretch(const motion::PathMotion& path) noexcept;
    /// Distance along the path of the next pulse, in the present stretch.
    [[nodiscard]] double next_length() const noexcept {
        return mark_begin_ + static_cast<double>(next_ - base_) * spec_.pitch;
    }
    /// All pulses on one segment before path time `high`.
    void fill(const motion::PathMotion& path, const motion::Segment& segment, double low, double high,
              ServoOutputs& out) noexcept;
    /// When the beam is at `length` on the segment, from a first guess; leaves slowness_ exact to a few parts in 1e9.
    [[nodiscard]] Solved solve(const motion::Segment& segment, double length, double low, double guess) noexcept;
    /// Times of consecutive pulses: t(n) = t0 + n (t1 + n (t2 + n t3)), and their speed from first to last.
    struct Group {
        std::uint32_t count = 0;
        double t0 = 0.0;
        double t1 = 0.0;
        double t2 = 0.0;
        double t3 = 0.0;
        double speed = 0.0;
        double speed_change = 0.0;  ///< a pulse
        [[nodiscard]] double time(double n) const noexcept { return t0 + n * (t1 + n * (t2 + n * t3)); }
    };
    /// Up to `count` > 0 pulses from the next on, which is at `length` on the segment.
    [[nodiscard]] Group group(const motion::Segment& segment, double length, std::uint32_t count, double low) noexcept;
    void place_group(const motion::Segment& segment, const Group& group, ServoOutputs& out) noexcept;
    void write(const motion::Segment& segment, const Group& group, const Firing& firing, ServoOutputs& out) noexcept;
    /// One run for `count` pulses of the group from its pulse `begin` on. False: none fits within kRunTolerance,
    /// nothing is written.
    [[nodiscard]] bool trigger(const Group& group, std::uint32_t begin, std::uint32_t count, const Firing& firing,
                               ServoOutputs& out) noexcept;

    PulseSpec spec_;
    FiringRule rule_;
    std::int64_t pitch_pm_ = 0;
    double per_pitch_ = 0.0;
    std::uint32_t next_ = 0;
    std::uint32_t stretch_ = 0;  ///< of the path that is being marked …
    std::uint32_t base_ = 0;     ///< … its first pulse …
    std::int64_t base_pm_ = 0;   ///< … and where that is, from the path's first
    std::uint32_t withheld_ = 0;
    std::uint32_t last_item_ = 0;
    double last_time_ = 0.0;
    double slowness_ = 0.0;  ///< seconds a metre at the pulse that was solved last
    motion::Cursor cursor_;
    std::uint32_t pick_ = 1;   ///< of the last pulse
    std::uint32_t group_ = 1;  ///< pulses that the next group tries
    // The window that is being filled.
    std::int64_t window_ns_ = 0;  ///< path time of its start
    double window_ = 0.0;         ///< the same in seconds
    std::int64_t act_ns_ = 0;
    double mark_begin_ = 0.0;   ///< of the stretch
    std::uint32_t pulses_ = 0;  ///< up to its end, as far as is known
};

}  // namespace sc::laser

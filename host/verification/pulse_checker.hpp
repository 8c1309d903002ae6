// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "shared/geometry/vec.hpp"
#include "shared/path/item.hpp"
#include "shared/trace/trace.hpp"

/// Judges pulses one by one against the job that asked for them: pulse k of a path belongs k · pitch along the lines
/// and arcs of its items, with the energy of its PathBegin. Knows the job's items and the pulse trace, nothing of how
/// pulses are made. Places are compared across the beam (x, z): the depth is the surface's. A line's length is that in
/// space; an arc lies across the beam.

namespace sc::host {

/// A path as its items draw it, by length. Metres.
class DrawnPath {
public:
    /// The first place, or a line to the next.
    void meet(bool first, const PathPoint& point);
    void line_to(const PathPoint& point);
    /// Throws std::domain_error for an arc that is none.
    void arc(const PathPoint& via, const PathPoint& to);

    [[nodiscard]] double length() const;
    /// Place at a length; beyond the ends, along their tangents.
    [[nodiscard]] Vec3 at(double length) const;
    /// By how much a beam's way between two lengths may be longer or shorter, metres: what turns by an angle is so much
    /// longer when run a tolerance further out, and a smooth curve through points is longer than their chords.
    [[nodiscard]] double slack(double from, double to, double tolerance) const;
    /// Length of the nearest place between two lengths.
    [[nodiscard]] double nearest(const Vec3& place, double low, double high) const;

private:
    struct Span {
        double begin = 0.0;
        double length = 0.0;
        Vec3 from{};
        Vec3 way{};  ///< unit, of a line
        Vec3 centre{};
        double radius = 0.0;  ///< 0: a line
        double angle = 0.0;   ///< rad, of an arc's start about its centre, from x to z
        double turn = 0.0;    ///< rad, signed
    };
    [[nodiscard]] static double nearest_in(const Span& span, const Vec3& place);
    [[nodiscard]] static Vec3 place_in(const Span& span, double s);

    std::vector<Span> spans_;
    Vec3 last_{};
};

/// A stretch of a path that is marked: the whole path unless it has dark ones.
struct DrawnJobPath {
    PathBegin begin;
    std::shared_ptr<const DrawnPath> path;
    double from = 0.0;  ///< metres along the path
    double to = 0.0;
    double slack = 0.0;  ///< metres: DrawnPath::slack
    [[nodiscard]] double pitch() const { return begin.pitch_nm * 1e-9; }
    /// Place of its pulse k.
    [[nodiscard]] Vec3 place(std::size_t k) const { return path->at(from + static_cast<double>(k) * pitch()); }
    /// Pulses of the stretch: one at each end of each pitch.
    [[nodiscard]] std::size_t pulses() const;
};
/// The marked stretches of a job's paths in order. Throws std::domain_error for a path without two places, and for
/// items that are out of order.
[[nodiscard]] std::vector<DrawnJobPath> draw(const std::vector<Item>& items);

/// What a pulse must keep; shares of what the job asks for.
struct PulseLimits {
    double pitch = 0.03;   ///< distance from the pulse before, least and most
    double energy = 0.02;  ///< of all light on a millimetre
    /// Of a single pulse. The first ones of a laser that has rested are stronger, by its gain.
    double pulse_energy = 0.15;
};
enum class PulseBreach : std::uint8_t {
    paths,              ///< other paths than the job's: told apart by the dark between them
    count,              ///< pulses of a path; corners that are cut short are allowed for
    pitch,              ///< distance from the pulse before
    energy,             ///< of a pulse
    energy_per_length,  ///< of the last millimetre
    missed,             ///< a pulse met no surface
    gate_shut,          ///< a pulse in a tick whose gate is shut
};
[[nodiscard]] std::string_view name_of(PulseBreach breach) noexcept;
struct PulseViolation {
    PulseBreach breach = PulseBreach::paths;
    std::uint32_t path = 0;
    std::uint8_t pass = 0;
    std::size_t pulse = 0;  ///< from 0 in its stretch
    std::int64_t t_ns = 0;
    double value = 0.0;  ///< share of what the job asks for; a number of pulses or paths
    double limit = 0.0;
};
inline constexpr std::size_t kKeptPulseViolations = 100;

struct PulseFigures {
    std::size_t pulses = 0;
    std::size_t lost = 0;    ///< pulses that are missing, or too many, over all paths
    Vec3 stand{};            ///< metres: by how much all places were moved back, since the axes stand off by so much
    double pitch_rms = 0.0;  ///< of the pitch: distance along the path from one pulse to the next, less it
    double pitch_peak = 0.0;
    double placement_rms = 0.0;  ///< metres, from k · pitch along the path
    double placement_peak = 0.0;
    double energy_peak = 0.0;             ///< of the energy asked for, worst pulse
    double energy_per_length_peak = 0.0;  ///< the same of all light on a millimetre
    /// Pulses by which the last one of a path is off the place of its number, or the number off the path's; worst path.
    double drift = 0.0;
    std::uint64_t violations = 0;       ///< of PulseCheck::limits, all of them
    std::vector<PulseViolation> first;  ///< the first kKeptPulseViolations
};
struct PulseCheck {
    std::optional<std::vector<std::uint32_t>> only{};  ///< figures over these paths; all of them by default
    /// Where the axes stand off their anchor, one for the whole trace; by default the mean of pulse less k · pitch.
    std::optional<Vec3> stand{};
    /// Or each path has one of its own: where places themselves are judged elsewhere.
    bool stand_each = false;
    /// Judged by these too. Then a pulse's distance from the one before counts as it is along the path or straight,
    /// whichever is nearer to the pitch, since a corner may be cut; and other paths than the job's are a violation.
    std::optional<PulseLimits> limits{};
};
/// Paths are told apart by the dark between them. Throws std::domain_error when there are others than the job's,
/// unless limits are given.
[[nodiscard]] PulseFigures check_pulses(const std::vector<DrawnJobPath>& job,
                                        const std::vector<trace::PulseRecord>& pulses, const PulseCheck& check = {});

/// In which ticks of a sample trace the gate is open.
struct GateTicks {
    std::int64_t first_tick = 0;
    std::int64_t period_ns = 1'000'000;
    std::vector<bool> open;
};
/// Adds the pulses that left while the gate was shut: those of tick n leave in the tick behind it.
void check_gate(std::span<const trace::PulseRecord> pulses, const GateTicks& gate, PulseFigures& figures);

}  // namespace sc::host

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "shared/geometry/vec.hpp"
#include "shared/path/item.hpp"
#include "shared/trace/trace.hpp"

/// Judges pulses one by one against the job that asked for them: pulse k of a path belongs k · pitch along the lines
/// and arcs of its items, with the energy of its PathBegin. Knows the job's items and the pulse trace, nothing of how
/// pulses are made. In the plane across the beam (x, z).

namespace sc::host {

/// A path as its items draw it, by length. Metres.
class DrawnPath {
public:
    void begin(const PathPoint& point);
    void line_to(const PathPoint& point);
    /// Throws std::domain_error for an arc that is none.
    void arc(const PathPoint& via, const PathPoint& to);

    [[nodiscard]] double length() const;
    /// Place at a length; beyond the ends, along their tangents.
    [[nodiscard]] Vec3 at(double length) const;
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

struct DrawnJobPath {
    PathBegin begin;
    DrawnPath path;
    [[nodiscard]] double pitch() const { return begin.pitch_nm * 1e-9; }
    /// Pulses of a whole pass: one at each end of each pitch.
    [[nodiscard]] std::size_t pulses() const;
};
/// The paths of a job in order. Throws std::domain_error for a path without two places.
[[nodiscard]] std::vector<DrawnJobPath> draw(const std::vector<Item>& items);

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
};
struct PulseCheck {
    std::optional<std::vector<std::uint32_t>> only;  ///< figures over these paths; all of them by default
    /// Where the axes stand off their anchor, one for the whole trace; by default the mean of pulse less k · pitch.
    std::optional<Vec3> stand;
};
/// Paths are told apart by the dark between them. Throws std::domain_error when there are others than the job's.
[[nodiscard]] PulseFigures check_pulses(const std::vector<DrawnJobPath>& job,
                                        const std::vector<trace::PulseRecord>& pulses, const PulseCheck& check = {});

}  // namespace sc::host

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "firmware/trajectory/spec.hpp"

namespace sc::trajectory {

/// The circle through three places, as seen in x, y and z. Lengths in m.
struct Circle {
    Place centre{};
    Place first{};   ///< radius to the first place
    Place second{};  ///< the same a quarter turn on, towards the second place
    double radius = 0.0;
    double turn = 0.0;  ///< rad from the first place to the third
};
/// Nothing if they are on a line but for rounding. Cost: some 300 instructions.
[[nodiscard]] std::optional<Circle> circle_through(const Place& from, const Place& via, const Place& to) noexcept;

/// Directions of an arc at its ends, and the places where an axis turns back between them.
struct ArcShape {
    Place leaves{};  ///< of length 1
    Place arrives{};
    std::array<Place, 6> turns{};
    std::uint32_t turn_count = 0;
};
/// Of the arc from `from` through `via` to `to`; of a line if these are on one. Cost: some 1 000 instructions.
[[nodiscard]] ArcShape arc_shape(const Place& from, const Place& via, const Place& to) noexcept;

/// A circular arc over x, y and z as points on it, made one by one; C turns evenly. The chords between them stay within
/// kArcShare of the tolerance of the true arc, and the curve within the rest of it of the chords.
class Arc {
public:
    enum class Kind : std::uint8_t {
        arc,       ///< points follow
        line,      ///< straight within what is allowed, or too small to be seen: only its end is left
        no_plane,  ///< the three places lie on no one circle: repeated, or on a line with the middle one not between
        too_wide,  ///< a radius of more than kWidestArc
    };
    /// From `from` through `via` to `to`; of via only x, y, z count. The longest chord is such that its sagitta is
    /// `sagitta` and that it turns by 0.3 rad at most. Cost: some 400 instructions.
    [[nodiscard]] Kind begin(const Place& from, const Place& via, const Place& to, double sagitta,
                             double merge) noexcept;
    void stop() noexcept { left_ = 0; }
    /// Points that are not made yet, the end included.
    [[nodiscard]] std::uint32_t left() const noexcept { return left_; }
    /// The next point; the last is the end itself. Only while left() > 0. Cost: 30 operations.
    [[nodiscard]] Place next() noexcept;

private:
    Place centre_{};
    Place first_{};   ///< radius to the beginning
    Place second_{};  ///< the same a quarter turn on
    Place to_{};
    double turn_from_ = 0.0;  ///< C at the beginning
    double turn_step_ = 0.0;
    double sine_ = 0.0;  ///< of a step
    double cosine_ = 1.0;
    double at_sine_ = 0.0;
    double at_cosine_ = 1.0;
    std::uint32_t made_ = 0;
    std::uint32_t left_ = 0;
};

/// Of the tolerance, for the chords of an arc.
inline constexpr double kArcShare = 0.01;
/// m
inline constexpr double kWidestArc = 100.0;
/// m; with less every vertex is a stop
inline constexpr double kLeastArcTolerance = 1e-7;

}  // namespace sc::trajectory

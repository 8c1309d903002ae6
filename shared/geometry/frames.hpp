// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "shared/geometry/vec.hpp"

/// Coordinate frames as types, so that a chain which does not fit does not compile: `h_from_c * c_from_w * p_w`.
/// The frames and their letters are those of docs/frames.md; signs are pinned by tests/golden/frames.

namespace sc {

namespace frame {
/// Scribing frame: laser focus with the galvo at zero, in machine travel. Right-handed; +z up, +y from the workpiece
/// towards the laser head (y is depth along the beam).
struct H {};
/// Measurement frame: the 3-D sensor; a stitched scan set has one c, tied to the turntable at C = 0.
struct C {};
/// Workpiece (CAD).
struct W {};
/// Turntable: the workpiece as clamped; equals h when C = 0.
struct T {};
/// Robot base, robot flange, fixed target, mobile target.
struct B {};
struct F {};
struct G {};
struct M {};
}  // namespace frame

/// A place in one frame, in metres.
template <class Frame>
struct Point {
    Vec3 v;
    constexpr bool operator==(const Point&) const noexcept = default;
};
/// A direction in one frame: rotates, never shifts. Not normalised by itself.
template <class Frame>
struct Direction {
    Vec3 v;
    constexpr bool operator==(const Direction&) const noexcept = default;
};

/// Rigid transform that takes From-coordinates to To-coordinates: p_to = R p_from + t. Named `to_from_from`, e.g.
/// `h_from_c`. The invariant (R is a rotation) is checked where a transform enters the program (host/formats), not
/// here.
template <class To, class From>
struct Rigid {
    Mat3 rotation;
    Vec3 translation;  ///< metres, in To

    constexpr bool operator==(const Rigid&) const noexcept = default;
    [[nodiscard]] constexpr Rigid<From, To> inverse() const noexcept {
        const Mat3 rt = rotation.transposed();
        return {rt, -(rt * translation)};
    }
};

template <class To, class From>
constexpr Point<To> operator*(const Rigid<To, From>& x, const Point<From>& p) noexcept {
    return {x.rotation * p.v + x.translation};
}
template <class To, class From>
constexpr Direction<To> operator*(const Rigid<To, From>& x, const Direction<From>& d) noexcept {
    return {x.rotation * d.v};
}
template <class To, class Mid, class From>
constexpr Rigid<To, From> operator*(const Rigid<To, Mid>& a, const Rigid<Mid, From>& b) noexcept {
    return {a.rotation * b.rotation, a.rotation * b.translation + a.translation};
}

/// The turntable's axis, a line in h: a point on it and its unit direction, pointing up. C turns counter-clockwise seen
/// from +z (against the direction's tip).
struct AxisLine {
    Point<frame::H> point;
    Direction<frame::H> direction{{0.0, 0.0, 1.0}};
    constexpr bool operator==(const AxisLine&) const noexcept = default;
};

/// Rotation about `axis` by the angle whose sine and cosine are given (Rodrigues). Passing them keeps this free of
/// libm; the host calls std::sin, the control path has no need of it.
constexpr Rigid<frame::H, frame::T> turned(const AxisLine& axis, double sine, double cosine) noexcept {
    const Vec3 u = axis.direction.v;
    const double k = 1.0 - cosine;
    const Mat3 r{{Vec3{cosine + u.x * u.x * k, u.x * u.y * k - u.z * sine, u.x * u.z * k + u.y * sine},
                  Vec3{u.y * u.x * k + u.z * sine, cosine + u.y * u.y * k, u.y * u.z * k - u.x * sine},
                  Vec3{u.z * u.x * k - u.y * sine, u.z * u.y * k + u.x * sine, cosine + u.z * u.z * k}}};
    return {r, axis.point.v - r * axis.point.v};
}

}  // namespace sc

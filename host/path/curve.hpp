// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "shared/geometry/vec.hpp"

/// What paths are made of: straight pieces and circular arcs. Metres, radians. Pure.

namespace sc::host {

/// centre + cos φ·first + sin φ·second for φ from 0 to `angle`.
struct Circle {
    Vec3 centre;
    Vec3 first;   ///< radius to the beginning
    Vec3 second;  ///< the same a quarter turn on
    double angle = 0.0;

    [[nodiscard]] Vec3 at(double phi) const noexcept;
    [[nodiscard]] double radius() const noexcept { return norm(first); }
};
/// From `from` through `via` to `to`; none if two are the same or all lie on a line to 1e-12 of their distance.
[[nodiscard]] std::optional<Circle> circle_through(const Vec3& from, const Vec3& via, const Vec3& to) noexcept;

struct Piece {
    Vec3 from;
    Vec3 to;
    std::optional<Circle> circle;  ///< none: straight
    int line = 0;                  ///< of the file that gives `to`; 0: the path's own

    [[nodiscard]] double length() const noexcept;
    /// `share` from 0 (from) to 1 (to).
    [[nodiscard]] Vec3 at(double share) const noexcept;
    /// Unit vector; zero for a piece without length.
    [[nodiscard]] Vec3 direction(double share) const noexcept;
    /// Largest magnitude of each coordinate of its direction.
    [[nodiscard]] Vec3 steepest() const noexcept;
};
[[nodiscard]] double length(std::span<const Piece> pieces) noexcept;

/// Where a coordinate of an arc has a turning point: angles within it. `first` and `second` as of a Circle, or mapped.
[[nodiscard]] std::vector<double> turning_angles(const Vec3& first, const Vec3& second, double angle);

/// The place of a piece next to another place.
struct Nearest {
    double distance = 0.0;
    double share = 0.0;
};
[[nodiscard]] Nearest nearest(const Piece& piece, const Vec3& place) noexcept;

struct Bounds {
    Vec3 low;
    Vec3 high;

    void take(const Bounds& other) noexcept;
    /// 0 within.
    [[nodiscard]] double distance(const Vec3& place) const noexcept;
};
[[nodiscard]] Bounds bounds_of(const Piece& piece);

}  // namespace sc::host

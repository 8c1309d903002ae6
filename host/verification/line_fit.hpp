// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <span>
#include <vector>

/// Straight lines through places seen along the beam, in the plane (x, z) of h. Metres throughout.

namespace sc::host {

/// A place or a direction across the beam.
struct Flat {
    double x = 0.0;
    double z = 0.0;
    constexpr bool operator==(const Flat&) const noexcept = default;
};
constexpr Flat operator+(const Flat& a, const Flat& b) noexcept { return {a.x + b.x, a.z + b.z}; }
constexpr Flat operator-(const Flat& a, const Flat& b) noexcept { return {a.x - b.x, a.z - b.z}; }
constexpr Flat operator*(double s, const Flat& a) noexcept { return {s * a.x, s * a.z}; }
constexpr double dot(const Flat& a, const Flat& b) noexcept { return a.x * b.x + a.z * b.z; }
/// Positive if b is counter-clockwise of a in a picture with x to the right and z up.
constexpr double cross(const Flat& a, const Flat& b) noexcept { return a.x * b.z - a.z * b.x; }
[[nodiscard]] double length(const Flat& a) noexcept;

struct FlatLine {
    Flat point;          ///< centroid of the places that count
    Flat direction;      ///< unit
    double first = 0.0;  ///< places that count lie from `first` to `last` along the line, counted from `point`
    double last = 0.0;
    double rms = 0.0;          ///< distance of those places from the line
    double swing = 0.0;        ///< greatest minus least signed distance from the line
    std::vector<bool> counts;  ///< per place: not an outlier

    [[nodiscard]] double along(const Flat& p) const noexcept { return dot(p - point, direction); }
    [[nodiscard]] double off(const Flat& p) const noexcept { return cross(direction, p - point); }
    [[nodiscard]] Flat at(double s) const noexcept { return point + s * direction; }
    [[nodiscard]] double extent() const noexcept { return last - first; }
};

/// Total least squares through at least two different places; places further off than four robust standard deviations
/// (from the median; at least 1 µm) do not count. nullopt if all places coincide.
[[nodiscard]] std::optional<FlatLine> fit_line(std::span<const Flat> places);

/// value(s) = at_zero + slope·s by least squares over the entries that count; slope 0 if s does not vary.
struct Trend {
    double at_zero = 0.0;
    double slope = 0.0;
    [[nodiscard]] double at(double s) const noexcept { return at_zero + slope * s; }
};
[[nodiscard]] Trend fit_trend(std::span<const double> s, std::span<const double> value,
                              const std::vector<bool>& counts);

/// Where two lines meet; nullopt if they are parallel within 1e-6 rad.
[[nodiscard]] std::optional<Flat> meeting_point(const FlatLine& a, const FlatLine& b) noexcept;

}  // namespace sc::host

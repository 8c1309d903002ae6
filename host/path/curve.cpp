// SPDX-License-Identifier: Apache-2.0
#include "host/path/curve.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace sc::host {

namespace {

constexpr double kTurn = 2.0 * std::numbers::pi;

/// Angle in [0, 2π).
double positive(double angle) noexcept { return angle < 0.0 ? angle + kTurn : angle; }

Vec3 smaller(const Vec3& a, const Vec3& b) noexcept {
    return {std::min(a.x, b.x), std::min(a.y, b.y), std::min(a.z, b.z)};
}
Vec3 larger(const Vec3& a, const Vec3& b) noexcept {
    return {std::max(a.x, b.x), std::max(a.y, b.y), std::max(a.z, b.z)};
}

}  // namespace

Vec3 Circle::at(double phi) const noexcept { return centre + std::cos(phi) * first + std::sin(phi) * second; }

std::optional<Circle> circle_through(const Vec3& from, const Vec3& via, const Vec3& to) noexcept {
    const Vec3 a = via - from;
    const Vec3 b = to - from;
    const Vec3 normal = cross(a, b);
    const double square = dot(normal, normal);
    if (!(square > 1e-24 * dot(a, a) * dot(b, b)) || via == to) {
        return std::nullopt;
    }
    const Vec3 to_centre = (0.5 / square) * (dot(a, a) * cross(b, normal) - dot(b, b) * cross(a, normal));
    Circle circle;
    circle.centre = from + to_centre;
    circle.first = -to_centre;
    circle.second = (1.0 / std::sqrt(square)) * cross(normal, circle.first);
    const Vec3 end = to - circle.centre;
    // Seen along the normal the way over via is the one that turns to the left.
    circle.angle = positive(std::atan2(dot(end, circle.second), dot(end, circle.first)));
    return circle;
}

double Piece::length() const noexcept { return circle ? circle->radius() * circle->angle : norm(to - from); }

Vec3 Piece::at(double share) const noexcept {
    return circle ? circle->at(share * circle->angle) : from + share * (to - from);
}

Vec3 Piece::direction(double share) const noexcept {
    Vec3 way = to - from;
    if (circle) {
        const double phi = share * circle->angle;
        way = std::cos(phi) * circle->second - std::sin(phi) * circle->first;
    }
    const double size = norm(way);
    return size > 0.0 ? (1.0 / size) * way : Vec3{};
}

Vec3 Piece::steepest() const noexcept {
    const auto magnitudes = [](const Vec3& v) { return Vec3{std::abs(v.x), std::abs(v.y), std::abs(v.z)}; };
    Vec3 most = larger(magnitudes(direction(0.0)), magnitudes(direction(1.0)));
    if (circle) {
        // The direction turns as the radius does, a quarter turn ahead.
        for (const double phi : turning_angles(circle->second, -circle->first, circle->angle)) {
            most = larger(most, magnitudes(direction(phi / circle->angle)));
        }
    }
    return most;
}

double length(std::span<const Piece> pieces) noexcept {
    double sum = 0.0;
    for (const Piece& piece : pieces) {
        sum += piece.length();
    }
    return sum;
}

std::vector<double> turning_angles(const Vec3& first, const Vec3& second, double angle) {
    std::vector<double> angles;
    for (std::size_t i = 0; i < 3; ++i) {
        if (first[i] == 0.0 && second[i] == 0.0) {
            continue;
        }
        const double phi = positive(std::atan2(second[i], first[i]));
        for (const double at : {phi, phi + std::numbers::pi, phi - std::numbers::pi}) {
            if (at > 0.0 && at < angle) {
                angles.push_back(at);
            }
        }
    }
    return angles;
}

Nearest nearest(const Piece& piece, const Vec3& place) noexcept {
    if (!piece.circle) {
        const Vec3 way = piece.to - piece.from;
        const double square = dot(way, way);
        const double share = square > 0.0 ? std::clamp(dot(place - piece.from, way) / square, 0.0, 1.0) : 0.0;
        return {norm(place - piece.at(share)), share};
    }
    const Circle& circle = *piece.circle;
    const Vec3 off = place - circle.centre;
    const double phi = positive(std::atan2(dot(off, circle.second), dot(off, circle.first)));
    if (phi <= circle.angle) {
        return {norm(place - circle.at(phi)), phi / circle.angle};
    }
    const double to_from = norm(place - piece.from);
    const double to_to = norm(place - piece.to);
    return to_from <= to_to ? Nearest{to_from, 0.0} : Nearest{to_to, 1.0};
}

void Bounds::take(const Bounds& other) noexcept {
    low = smaller(low, other.low);
    high = larger(high, other.high);
}

double Bounds::distance(const Vec3& place) const noexcept {
    const Vec3 off = larger(larger(low - place, place - high), Vec3{});
    return norm(off);
}

Bounds bounds_of(const Piece& piece) {
    Bounds bounds{smaller(piece.from, piece.to), larger(piece.from, piece.to)};
    if (piece.circle) {
        for (const double phi : turning_angles(piece.circle->first, piece.circle->second, piece.circle->angle)) {
            const Vec3 at = piece.circle->at(phi);
            bounds.take({at, at});
        }
    }
    return bounds;
}

}  // namespace sc::host

// SPDX-License-Identifier: Apache-2.0
#include "host/inspection/face_gauge.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace sc::host {

namespace {

constexpr double kSameStrip = 1e-4;
constexpr double kGapCosine = 0.92;  ///< 23 degrees: a bore that is open here has no strip to measure over
constexpr std::size_t kFewestStrips = 4;
constexpr std::size_t kParts = 256;  ///< of the circle

/// Grows with the angle, from -2 to 2: cheaper than the angle.
double angle_of(double x, double y) {
    const double r = y / std::max(std::abs(x) + std::abs(y), 1e-300);
    return x >= 0.0 ? r : (y >= 0.0 ? 2.0 - r : -2.0 - r);
}
std::size_t part_of(double angle) {
    return std::min(static_cast<std::size_t>((angle + 2.0) * 0.25 * static_cast<double>(kParts)), kParts - 1);
}

Vec3 unit(const Vec3& v) { return (1.0 / std::max(norm(v), 1e-300)) * v; }

Vec3 radial(const CadFace& face, const Vec3& place) {
    const Vec3 r = place - face.point;
    return r - dot(r, face.direction) * face.direction;
}

Reading over_radius(const CadFace& face, const Vec3& place) {
    const Vec3 r = radial(face, place);
    const double side = face.hollow ? -1.0 : 1.0;
    return {side * (norm(r) - face.radius), side * unit(r), false};
}

}  // namespace

FaceGauge::FaceGauge(const DistanceField& field, const FaceMap& map) : field_(&field), map_(&map) {
    for (const CadFace& face : map.faces) {
        bores_.push_back(face.kind == FaceKind::cylinder && face.hollow ? bore_of(face) : Bore{});
    }
}

FaceGauge::Bore FaceGauge::bore_of(const CadFace& face) const {
    Bore bore;
    const Vec3 a = face.direction;
    bore.u = unit(cross(a, std::abs(a.x) < 0.7 ? Vec3{1, 0, 0} : Vec3{0, 1, 0}));
    bore.v = cross(a, bore.u);
    const TriangleMesh& mesh = field_->mesh();
    std::vector<Strip> strips;
    for (const std::uint32_t i : face.triangles) {
        const auto& t = mesh.triangles[i];
        const Vec3& p = mesh.vertices[t[0]];
        const Vec3 n = cross(mesh.vertices[t[1]] - p, mesh.vertices[t[2]] - p);
        const double area = 0.5 * norm(n);
        if (area > 1e-6 * face.area) {
            strips.push_back({angle_of(-dot(n, bore.u), -dot(n, bore.v)), p, unit(n), area});
        }
    }
    std::ranges::sort(strips, {}, &Strip::angle);
    std::vector<Strip> merged;
    for (const Strip& strip : strips) {
        if (!merged.empty() && strip.angle - merged.back().angle < kSameStrip) {
            merged.back() = strip.area > merged.back().area ? strip : merged.back();
        } else {
            merged.push_back(strip);
        }
    }
    const std::size_t count = merged.size();
    if (count < kFewestStrips) {
        return bore;
    }
    for (const Strip& strip : merged) {
        bore.angles.push_back(strip.angle);
    }
    for (std::size_t i = 0; i < count + 4; ++i) {
        const Strip& strip = merged[(i + count - 2) % count];
        bore.flats.push_back({strip.normal, dot(strip.on, strip.normal)});
    }
    for (std::size_t part = 0; part < kParts; ++part) {
        const double start = -2.0 + 4.0 * static_cast<double>(part) / static_cast<double>(kParts);
        bore.first.push_back(
            static_cast<std::uint32_t>(std::ranges::lower_bound(bore.angles, start) - bore.angles.begin()));
    }
    return bore;
}

Reading FaceGauge::over_bore(const Vec3& place, const CadFace& face, const Bore& bore) const {
    const Vec3 r = radial(face, place);
    const double angle = angle_of(dot(r, bore.u), dot(r, bore.v));
    std::size_t found = bore.first[part_of(angle)];
    while (found < bore.angles.size() && bore.angles[found] < angle) {
        ++found;
    }
    // The strips on both sides, and one more each: widths may differ.
    std::size_t least = found;
    double height = dot(place, bore.flats[found].normal) - bore.flats[found].offset;
    for (std::size_t i = found + 1; i < found + 4; ++i) {
        const double other = dot(place, bore.flats[i].normal) - bore.flats[i].offset;
        least = other < height ? i : least;
        height = std::min(height, other);
    }
    const Reading best{height, bore.flats[least].normal, true};
    const double towards = -dot(r, best.direction);
    const bool open = towards < 0.0 || towards * towards < kGapCosine * kGapCosine * dot(r, r);
    return open ? over_radius(face, place) : best;
}

Reading FaceGauge::at(const Vec3& place, std::uint32_t face) const {
    const CadFace& f = map_->faces[face];
    if (f.kind == FaceKind::plane) {
        return {dot(place - f.point, f.direction), f.direction, false};
    }
    if (f.kind == FaceKind::cylinder && f.hollow) {
        return bores_[face].angles.empty() ? over_radius(f, place) : over_bore(place, f, bores_[face]);
    }
    const Distance d = field_->at(place);
    if (f.kind == FaceKind::cylinder && map_->face_of[d.triangle] != face) {
        return over_radius(f, place);
    }
    return {d.value, field_->foot(place, d).direction, false};
}

}  // namespace sc::host

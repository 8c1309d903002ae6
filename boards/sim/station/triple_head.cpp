// SPDX-License-Identifier: Apache-2.0
#include "boards/sim/station/triple_head.hpp"

#include <cmath>
#include <numbers>

namespace sc::sim {
namespace {

constexpr double kHalfWavelength = 0.75;  ///< metres: 200 MHz
constexpr Mat3 kDrawn{{Vec3{0.0, 1.0, 0.0}, Vec3{0.0, 0.0, 1.0}, Vec3{1.0, 0.0, 0.0}}};
constexpr double kSeatBelow = 0.06;   ///< metres: the base under the sensors
constexpr double kSeatBehind = 0.02;  ///< and behind their optical centres

Vec3 three_draws(double sigma, Random& random) {
    Vec3 out;
    out.x = sigma * normal_draw(random);
    out.y = sigma * normal_draw(random);
    out.z = sigma * normal_draw(random);
    return out;
}

}  // namespace

double normal_draw(Random& random) {
    std::normal_distribution<double> normal;
    return normal(random);
}

Mat3 rotation_about(const Vec3& w) {
    const double angle = norm(w);
    if (!(angle > 0.0)) {
        return Mat3::identity();
    }
    const Vec3 u = (1.0 / angle) * w;
    const auto column = [&](const Vec3& e) {
        return std::cos(angle) * e + std::sin(angle) * cross(u, e) + ((1.0 - std::cos(angle)) * dot(u, e)) * u;
    };
    return Mat3{{column({1.0, 0.0, 0.0}), column({0.0, 1.0, 0.0}), column({0.0, 0.0, 1.0})}}.transposed();
}

TrueHead drawn_head(double side) {
    TrueHead head;
    const std::array<Vec3, 3> places{Vec3{0.0, 0.0, 0.0}, Vec3{side, 0.0, 0.0},
                                     Vec3{0.5 * side, 0.5 * std::sqrt(3.0) * side, 0.0}};
    for (std::size_t i = 0; i < 3; ++i) {
        head.beams[i].origin = places[i];
        head.beams[i].direction = {0.0, 0.0, 1.0};
    }
    head.d_from_r = kDrawn;
    head.seat = {0.5 * side, -kSeatBelow, -kSeatBehind};
    return head;
}

TrueHead made_head(double side, const HeadErrors& errors, Random& random) {
    TrueHead head = drawn_head(side);
    for (TrueBeam& beam : head.beams) {
        const Vec3 off = three_draws(errors.place, random);
        beam.origin = beam.origin + Vec3{off.x, off.y, 0.0};
        const Vec3 tilt = three_draws(errors.tilt, random);
        const Vec3 along{tilt.x, tilt.y, 1.0};
        beam.direction = (1.0 / norm(along)) * along;
        beam.gain = errors.gain * normal_draw(random);
        beam.zero = errors.zero * normal_draw(random);
        beam.cyclic = errors.cyclic;
        beam.cyclic_phase = 2.0 * std::numbers::pi * std::uniform_real_distribution<double>()(random);
    }
    const Vec3 turn = three_draws(errors.mount_angle, random);
    head.d_from_r = rotation_about(turn) * head.d_from_r;
    head.seat = head.seat + three_draws(errors.mount_place, random);
    return head;
}

TrueHead reseated(const TrueHead& head, double angle_sigma, double place_sigma, Random& random) {
    TrueHead out = head;
    const Vec3 turn = three_draws(angle_sigma, random);
    const Vec3 shift = three_draws(place_sigma, random);
    out.d_from_r = rotation_about(turn) * head.d_from_r;
    out.seat = head.seat + shift;
    return out;
}

TruePlane face_in_r(double angle, double yaw, double distance, double y, double z) {
    // Square to the reference the face looks along −x; then it is tipped about y, then turned about z.
    const Mat3 tip = rotation_about({0.0, angle - 0.5 * std::numbers::pi, 0.0});
    const Mat3 turn = rotation_about({0.0, 0.0, yaw});
    const Vec3 n = turn * (tip * Vec3{-1.0, 0.0, 0.0});
    return {n, dot(n, Vec3{distance, y, z})};
}

TruePlane plane_in_d(const TrueHead& head, const TruePlane& in_r) {
    const Vec3 n = head.d_from_r * in_r.normal;
    return {n, in_r.offset + dot(n, head.seat)};
}

TruePlane plate_in_d(double height) { return {{0.0, 0.0, -1.0}, -height}; }

std::array<double, 2> middle_in_r(double side) {
    const TrueHead head = drawn_head(side);
    const Vec3 middle = (1.0 / 3.0) * (head.beams[0].origin + head.beams[1].origin + head.beams[2].origin) - head.seat;
    const Vec3 r = head.d_from_r.transposed() * middle;
    return {r.y, r.z};
}

Vec3 spot_on(const TrueBeam& beam, const TruePlane& plane) {
    const double along = (plane.offset - dot(plane.normal, beam.origin)) / dot(plane.normal, beam.direction);
    return beam.origin + along * beam.direction;
}

double reading_of(const TrueBeam& beam, const TruePlane& plane, double sigma, Random& random) {
    const double way = dot(spot_on(beam, plane) - beam.origin, beam.direction);
    const double scaled = beam.zero + way / (1.0 + beam.gain);
    const double cycles = std::floor(scaled / kHalfWavelength);
    const double phase = 2.0 * std::numbers::pi * (scaled / kHalfWavelength - cycles);
    // A phase meter's crosstalk repeats twice a cycle.
    const double error = beam.cyclic * std::sin(2.0 * phase + beam.cyclic_phase) + sigma * normal_draw(random);
    return kHalfWavelength * (cycles + phase / (2.0 * std::numbers::pi)) + error;
}

}  // namespace sc::sim

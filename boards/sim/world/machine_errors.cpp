// SPDX-License-Identifier: Apache-2.0
#include "boards/sim/world/machine_errors.hpp"

#include <cmath>

namespace sc::sim {
namespace {

constexpr double kDegree = kPi / 180.0;

double periodic(const std::array<Periodic, 3>& terms, const Vec3& q) {
    double sum = 0.0;
    for (std::size_t j = 0; j < 3; ++j) {
        const Periodic& term = terms[j];
        if (term.amplitude != 0.0) {
            sum += term.amplitude * std::sin(2.0 * kPi * q[j] / term.period + term.phase);
        }
    }
    return sum;
}

/// Rotation by the small vector `w` (rad), exact.
Mat3 rotation_of(const Vec3& w) {
    const double angle = norm(w);
    if (angle == 0.0) {
        return Mat3::identity();
    }
    const AxisLine line{{}, {(1.0 / angle) * w}};
    return turned(line, std::sin(angle), std::cos(angle)).rotation;
}

/// A vector across the axis that goes round as `angle` does, less what it was at 0.
Vec3 going_round(double size, double angle, double phase) {
    return {size * (std::cos(angle + phase) - std::cos(phase)), size * (std::sin(angle + phase) - std::sin(phase)),
            0.0};
}

/// Where the lens images a pair of optical angles, before head and machine are askew to each other.
struct Image {
    double u = 0.0;
    double w = 0.0;
};

Image image_of(const GalvoTruth& truth, double a, double b) {
    const double along_a = std::sin(a);
    const double along_b = std::cos(a) * std::sin(b);
    const double sine = std::hypot(along_a, along_b);
    const double t = std::atan2(sine, std::cos(a) * std::cos(b));
    const auto& [f1, f2, f3, f4] = truth.lens;
    // r(t) / sin t, with its limit f1 at the centre.
    const double height = sine > 0.0 ? (f1 + (f2 + (f3 + f4 * t) * t) * t) * (t / sine) : f1;
    Image image{height * along_a, height * along_b};
    const double k = 2.0 * kPi / truth.ripple_period;
    const double u = image.u;
    const double w = image.w;
    image.u += truth.ripple_x * std::sin(k * u + 0.6) * std::cos(k * w);
    image.w += truth.ripple_z * std::cos(k * u) * std::sin(k * w + 0.3);
    return image;
}

}  // namespace

Vec3 true_focus(const AxesTruth& truth, const Vec3& reading) {
    const Vec3& q = reading;
    return {q.x * (1.0 + truth.scale[0]) + truth.squareness_xy * q.y + truth.squareness_xz * q.z +
                periodic(truth.periodic[0], q),
            q.y * (1.0 + truth.scale[1]) + truth.squareness_yz * q.z + periodic(truth.periodic[1], q),
            q.z * (1.0 + truth.scale[2]) + periodic(truth.periodic[2], q)};
}

double true_angle(const TurntableTruth& truth, double reading_deg) {
    const auto wave = [](double size, double angle, double phase) {
        return size * (std::sin(angle + phase) - std::sin(phase));
    };
    const double angle = reading_deg * kDegree;
    return reading_deg + wave(truth.pitch_error, angle, truth.pitch_error_phase) +
           wave(truth.pitch_error2, 2.0 * angle, truth.pitch_error2_phase);
}

AxisLine true_axis(const TurntableTruth& truth) {
    return {{truth.axis_point}, {(1.0 / norm(truth.direction)) * truth.direction}};
}

Rigid<frame::H, frame::T> true_h_from_t(const TurntableTruth& truth, double reading_deg) {
    const double angle = true_angle(truth, reading_deg) * kDegree;
    const AxisLine axis = true_axis(truth);
    const Rigid<frame::H, frame::T> turn = turned(axis, std::sin(angle), std::cos(angle));

    const Mat3 tilt = rotation_of(going_round(truth.wobble, angle, truth.wobble_phase) +
                                  going_round(truth.tilt2, 2.0 * angle, truth.tilt2_phase));
    const Vec3 u = axis.direction.v;
    const Vec3 pivot = axis.point.v + ((truth.wobble_pivot_z - axis.point.v.z) / u.z) * u;
    const double along = truth.axial * (std::sin(angle + truth.axial_phase) - std::sin(truth.axial_phase));
    const Vec3 shift = going_round(truth.runout, angle, truth.runout_phase) +
                       going_round(truth.radial2, 2.0 * angle, truth.radial2_phase) + along * u;
    const Rigid<frame::H, frame::H> disturbed{tilt, pivot - tilt * pivot + shift};
    return disturbed * turn;
}

Beam true_beam(const GalvoTruth& truth, const Vec3& focus, double command_x, double command_z) {
    const double a = truth.gain_x * command_x / truth.focal_length;
    const double b = truth.gain_z * command_z / truth.focal_length;
    const Image image = image_of(truth, a, b);
    const double square = image.u * image.u + image.w * image.w;
    const double bend = 1.0 + truth.exit_bend * square;
    const double across = truth.rotation + truth.skew;
    const auto turned_x = [&](double u, double w) { return std::cos(truth.rotation) * u - std::sin(across) * w; };
    const auto turned_z = [&](double u, double w) { return std::sin(truth.rotation) * u + std::cos(across) * w; };
    const double lean_u = image.u / truth.exit_pupil_x * bend;
    const double lean_w = image.w / truth.exit_pupil_z * bend;
    const Vec3 lean{turned_x(lean_u, lean_w) + truth.beam_tilt_x, -1.0, turned_z(lean_u, lean_w) + truth.beam_tilt_z};
    const Vec3 in_plane{focus.x + truth.offset_x + turned_x(image.u, image.w), focus.y,
                        focus.z + truth.offset_z + turned_z(image.u, image.w)};
    return {in_plane - truth.field_curvature * square * lean, (1.0 / norm(lean)) * lean};
}

}  // namespace sc::sim

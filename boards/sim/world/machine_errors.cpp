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
    const double across = truth.rotation + truth.skew;
    const double x = truth.gain_x * std::cos(truth.rotation) * command_x - truth.gain_z * std::sin(across) * command_z;
    const double z = truth.gain_x * std::sin(truth.rotation) * command_x + truth.gain_z * std::cos(across) * command_z;
    const Vec3 lean{x / truth.focal_length + truth.beam_tilt_x, -1.0, z / truth.focal_length + truth.beam_tilt_z};
    return {{focus.x + truth.offset_x + x, focus.y, focus.z + truth.offset_z + z}, (1.0 / norm(lean)) * lean};
}

}  // namespace sc::sim

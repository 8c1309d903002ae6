// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "boards/sim/world/world_spec.hpp"
#include "shared/geometry/frames.hpp"

/// How the machine truly moves, given what its encoders read. With axis readings q (metres), command g of the galvo
/// (metres at the focal plane) and table reading C (degrees):
///
///     focus   p_x = q_x (1 + s_x) + xy·q_y + xz·q_z + periodic       table   h_from_t(C) = shift(C) · wobble(C) ·
///     turn(C)
///             p_y = q_y (1 + s_y) + yz·q_z          + periodic
///             p_z = q_z (1 + s_z)                   + periodic
///     mirrors a = k_x g_x / f, b = k_z g_z / f: optical angles, x mirror first; field angle t, cos t = cos a cos b
///     lens    (u, w) = r(t) / sin t · (sin a, cos a sin b) + ripple, r(t) = f1 t + f2 t² + f3 t³ + f4 t⁴
///     beam    passes through focus + offset + R·(u, w), R = [ cos ρ,  −sin(ρ + σ) ]   in (x, z)
///                                                           [ sin ρ,   cos(ρ + σ) ]
///             and leans by R·(u / exit_pupil_x, w / exit_pupil_z) · (1 + exit_bend · r²) + beam tilt
///
/// with gains k, rotation ρ (from +x towards +z) and skew σ of the z mirror. The best focus lies on the beam,
/// field_curvature · (u² + w²) before the focal plane. `turn` is about the true axis line by C
/// plus the table's pitch errors; shift and wobble are counted from C = 0, where t equals h by definition. What goes
/// round once a turn with the table (runout, wobble) is to first order another axis line; what goes round twice, and
/// the shift along the axis, is not.

namespace sc::sim {

/// Place of the laser focus, galvo at zero and mounted without offset, in h.
[[nodiscard]] Vec3 true_focus(const AxesTruth& truth, const Vec3& reading);

/// Angle by which the table stands turned from C = 0, degrees.
[[nodiscard]] double true_angle(const TurntableTruth& truth, double reading_deg);
/// The table's true axis.
[[nodiscard]] AxisLine true_axis(const TurntableTruth& truth);
/// Where the table's frame is at a reading of C, with all its errors. Some fifteen sines: 0.4 µs.
[[nodiscard]] Rigid<frame::H, frame::T> true_h_from_t(const TurntableTruth& truth, double reading_deg);

/// A beam: the place that it is focused to and the way it travels.
struct Beam {
    Vec3 focus;      ///< metres, h
    Vec3 direction;  ///< unit, towards the workpiece
};
/// The beam for a focus of the axes and a galvo command (x, z in metres). The lens is not telecentric: a beam that
/// leans outwards lands further out beyond the focal plane and further in before it. Some 0.2 µs.
[[nodiscard]] Beam true_beam(const GalvoTruth& truth, const Vec3& focus, double command_x, double command_z);

}  // namespace sc::sim

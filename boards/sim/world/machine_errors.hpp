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
///     beam    passes through focus + offset + M·g, M = [ k_x cos ρ,  −k_z sin(ρ + σ) ]   in (x, z)
///                                                      [ k_x sin ρ,   k_z cos(ρ + σ) ]
///
/// with gains k, rotation ρ (from +x towards +z) and skew σ of the z mirror. `turn` is about the true axis line by C
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
/// The beam for a focus of the axes and a galvo command (x, z in metres). The lens is not telecentric: the beam leans
/// by deflection / focal length, so it lands further out beyond the focal plane and further in before it.
[[nodiscard]] Beam true_beam(const GalvoTruth& truth, const Vec3& focus, double command_x, double command_z);

}  // namespace sc::sim

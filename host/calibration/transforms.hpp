// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "host/formats/calibration_set.hpp"
#include "shared/geometry/frames.hpp"

/// From a place in w or c to the place in h where the beam meets it, with the turntable at a face: p_h = turned(C)·
/// h_from_c·c_from_w·p_w, C = −face. Conventions: docs/frames.md. Host only (libm); the cost is that of a sine.

namespace sc::host {

/// Turntable angle C at which face `face_deg` stands before the laser: the paper turns clockwise, C counts
/// counter-clockwise.
constexpr double c_of_face(double face_deg) noexcept { return -face_deg; }

/// Turntable at C (degrees), about the calibrated axis. Multiples of 90° are exact (no rounding of sine and cosine).
[[nodiscard]] Rigid<frame::H, frame::T> h_from_t(const AxisLine& axis, double c_deg) noexcept;

/// Where a place measured in c (tied to the turntable at C = 0) stands in h when face `face_deg` is before the laser.
/// Throws InputError if the set has no h_from_c or no turntable axis.
[[nodiscard]] Point<frame::H> to_face(const CalibrationSet& set, const Point<frame::C>& place, double face_deg);
/// The same for a place on the workpiece; c_from_w is the job's alignment.
[[nodiscard]] Point<frame::H> to_face(const CalibrationSet& set, const Rigid<frame::C, frame::W>& c_from_w,
                                      const Point<frame::W>& place, double face_deg);
/// Back again: the place in c of what stands at `place` in h at that face.
[[nodiscard]] Point<frame::C> from_face(const CalibrationSet& set, const Point<frame::H>& place, double face_deg);

/// Depth (y in h) of a surface by a distance sensor beside the head: the beam was focused at depth y1 when the sensor
/// read a1; where it reads a2 the surface is at y1 + a1 − a2 (a longer distance lies deeper). All in metres.
constexpr double depth_by_sensor(double y1, double a1, double a2) noexcept { return (y1 + a1) - a2; }

}  // namespace sc::host

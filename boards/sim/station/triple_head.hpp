// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <random>

#include "shared/geometry/vec.hpp"

/// The true triple-laser head and what its sensors read. Metres, radians. Frames as in docs/measure.md: d of the head
/// (z along the beams), r of the reference plane (z its normal, x along the beams).

namespace sc::sim {

using Random = std::mt19937_64;

/// Standard deviations of what a workshop gets wrong.
struct HeadErrors {
    double place = 0.3e-3;        ///< of a sensor's optical centre, x and y
    double tilt = 2e-3;           ///< of a beam, about x and y
    double gain = 2e-3;           ///< of a distance
    double zero = 0.25e-3;        ///< of a reading
    double mount_angle = 2.6e-3;  ///< of the head on its base, about each axis
    double mount_place = 0.3e-3;
    double cyclic = 0.03e-3;  ///< amplitude of a phase sensor's error that repeats with the phase
};

struct TrueBeam {
    Vec3 origin;
    Vec3 direction;  ///< unit
    double zero = 0.0;
    double gain = 0.0;
    double cyclic = 0.0;
    double cyclic_phase = 0.0;
};

struct TrueHead {
    std::array<TrueBeam, 3> beams;
    Mat3 d_from_r;
    Vec3 seat;  ///< origin of r, in d
};

/// The head as it was drawn: an equilateral triangle of side `side`, beam 1 at the origin of d, beam 2 on its x axis.
[[nodiscard]] TrueHead drawn_head(double side);
/// One that a workshop made.
[[nodiscard]] TrueHead made_head(double side, const HeadErrors& errors, Random& random);
/// The same head, its base put down again.
[[nodiscard]] TrueHead reseated(const TrueHead& head, double angle_sigma, double place_sigma, Random& random);

struct TruePlane {
    Vec3 normal;
    double offset = 0.0;  ///< normal · place
};
/// The face of a workpiece, in r: `angle` to the reference plane, turned by `yaw` about z, its distance along x taken
/// over (y, z).
[[nodiscard]] TruePlane face_in_r(double angle, double yaw, double distance, double y, double z);
[[nodiscard]] TruePlane plane_in_d(const TrueHead& head, const TruePlane& in_r);
/// Across z of d at this height.
[[nodiscard]] TruePlane plate_in_d(double height);
/// y and z in r of the middle of the drawn head.
[[nodiscard]] std::array<double, 2> middle_in_r(double side);

/// Where the beam meets the plane, in d.
[[nodiscard]] Vec3 spot_on(const TrueBeam& beam, const TruePlane& plane);
/// What the sensor gives for it: the modulation's phase says the distance within half a wavelength, whole cycles are
/// taken as resolved; the phase has white noise.
[[nodiscard]] double reading_of(const TrueBeam& beam, const TruePlane& plane, double sigma, Random& random);

[[nodiscard]] double normal_draw(Random& random);
[[nodiscard]] Mat3 rotation_about(const Vec3& w);

}  // namespace sc::sim

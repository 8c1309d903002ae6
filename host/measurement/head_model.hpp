// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>

#include <Eigen/Core>

#include "host/formats/calibration_set.hpp"
#include "host/formats/stations.hpp"

/// Geometry of the triple-laser head: readings to places, places to the plane, the plane to figures against the
/// reference. Frames and signs: docs/measure.md. For the sources of this folder and their tests.

namespace sc::host {

inline constexpr std::size_t kHeadParameters = TripleRecord::kParameters;
using HeadVector = Eigen::Matrix<double, static_cast<int>(kHeadParameters), 1>;
using HeadMatrix = Eigen::Matrix<double, static_cast<int>(kHeadParameters), static_cast<int>(kHeadParameters)>;

/// Three readings of a head that stands at `pose`, each with its standard deviation; metres.
struct PoseReadings {
    HeadPose pose;
    std::array<double, 3> value{};
    std::array<double, 3> sigma{1.0, 1.0, 1.0};
};

/// z = a[0] + a[1] x + a[2] y in d, the head on its seat.
struct DevicePlane {
    std::array<double, 3> a{};
    /// Unit, towards the head.
    [[nodiscard]] Vec3 normal() const noexcept;
    /// Between the normal and the z axis of d, radians.
    [[nodiscard]] double incidence() const noexcept;
};

/// What is said of a plane against the reference; radians, metres. Order of all vectors of four in this folder.
struct PlaneFigures {
    double angle = 0.0;     ///< between the planes, 0 to pi
    double about_y = 0.0;   ///< the same in the x-z plane of r
    double about_z = 0.0;   ///< yaw, in the x-y plane of r
    double distance = 0.0;  ///< along x of r, at the given y and z
    [[nodiscard]] Eigen::Vector4d vector() const { return {angle, about_y, about_z, distance}; }
};

/// `record` with `change` added: rays by sums, d_from_r by Exp(change) from the left.
[[nodiscard]] TripleRecord changed(const TripleRecord& record, const HeadVector& change);
[[nodiscard]] HeadMatrix covariance_of(const TripleRecord& record);
void set_covariance(TripleRecord& record, const HeadMatrix& covariance);

/// Rotation vector to rotation matrix.
[[nodiscard]] Mat3 rotation_exp(const Vec3& w);
/// Rz·Ry·Rx.
[[nodiscard]] Mat3 tilt_matrix(const Vec3& tilt);

/// Where the beam of `ray` at reading `value` meets a surface, in d with the head on its seat.
[[nodiscard]] Vec3 spot_of(const TripleRay& ray, double value, const HeadPose& pose);

/// Plane of least squares of the distances along the beams, weighted; exact for three readings. `readings` hold one
/// pose or more, and the spots are not on one line (spot_spread).
[[nodiscard]] DevicePlane fit_plane(const TripleRecord& record, const std::vector<PoseReadings>& readings);
/// Sum of squares of (measured − plane) along the beams, over sigma.
[[nodiscard]] double plane_misfit(const TripleRecord& record, const std::vector<PoseReadings>& readings,
                                  const DevicePlane& plane);
/// Standard deviations of the spots' x and y along and across the line that is nearest to them, metres.
[[nodiscard]] std::array<double, 2> spot_spread(const TripleRecord& record, const std::vector<PoseReadings>& readings);

/// The record has a reference, and the plane is not parallel to x of r.
[[nodiscard]] PlaneFigures figures_of(const TripleReference& reference, const DevicePlane& plane,
                                      const std::array<double, 2>& at);
[[nodiscard]] Vec3 to_reference(const TripleReference& reference, const Vec3& place_d);
[[nodiscard]] Vec3 direction_to_reference(const TripleReference& reference, const Vec3& direction_d);

/// Derivatives of the figures: by the readings (a column each, pose by pose) and by the head's parameters.
struct FigureSensitivity {
    Eigen::Matrix<double, 4, Eigen::Dynamic> by_reading;
    Eigen::Matrix<double, 4, static_cast<int>(kHeadParameters)> by_parameter;
};
/// By central differences; some 100 plane fits, 0.1 ms.
[[nodiscard]] FigureSensitivity sensitivity(const TripleRecord& record, const std::vector<PoseReadings>& readings,
                                            const std::array<double, 2>& at);

}  // namespace sc::host

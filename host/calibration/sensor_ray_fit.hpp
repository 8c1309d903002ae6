// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <filesystem>
#include <string>
#include <vector>

#include "host/formats/calibration_set.hpp"

/// Where a distance sensor looks, from readings over planes that are known in h: with the sensor carried to f, reading
/// r says that f + origin + (r − zero)·direction lies on the plane n·p = d. Unknown are the origin across the beam, the
/// direction and the zero: five. Host only; a millisecond.

namespace sc::host {

struct KnownPlane {
    int id = 0;
    Vec3 normal;            ///< unit, h
    double distance = 0.0;  ///< metres: n·p of its points
    double sigma = 0.0;     ///< of that, metres
};
struct RangeReading {
    int plane = 0;
    Vec3 carrier;  ///< what carries the sensor: the focus of the axes for the Y sensor, 0 for one that stands still
    double reading = 0.0;  ///< metres
    double sigma = 0.0;    ///< of one, > 0
    int line = 0;          ///< of the file
    int group = -1;        ///< readings that err in common; below 0: those of the plane
    double common = 0.0;   ///< metres, 1 sigma: by how much, beside the plane's own sigma
};
struct SensorRayOptions {
    Vec3 along{0.0, -1.0,
               0.0};  ///< roughly where it looks; origin lies in the plane through 0 square to the nearest axis
    double most_origin = 0.2e-3;  ///< metres: more uncertainty than that is refused
    double most_turn = 5e-3;      ///< radians
};
struct SensorRayFit {
    static constexpr std::size_t kParameters = 5;
    Vec3 origin;        ///< metres; its coordinate along the beam's main axis is `anchor`
    Vec3 direction;     ///< unit
    double zero = 0.0;  ///< metres
    /// Of the two origin coordinates across, the two direction components across (x before y before z), the zero.
    Covariance<kParameters> covariance;
    double rms = 0.0;        ///< metres along the beam
    double sigma = 0.0;      ///< of one reading, as the data show
    std::vector<int> wrong;  ///< lines of readings left out
    std::size_t readings = 0;
};
/// `anchor`: the origin's coordinate along the main axis, metres. Robust least squares. Throws InputError (with `file`)
/// for fewer than eight readings, a reading over no known plane, and planes that leave origin or direction uncertain:
/// the blind direction is named.
[[nodiscard]] SensorRayFit fit_sensor_ray(const std::filesystem::path& file, const std::vector<KnownPlane>& planes,
                                          const std::vector<RangeReading>& readings, double anchor,
                                          const SensorRayOptions& options = {});

/// Plane of least squares through points with noise `sigma` each; the normal against `towards`. Throws
/// std::domain_error for fewer than four points, or points on a line.
[[nodiscard]] KnownPlane fit_known_plane(int id, const std::vector<Vec3>& points, double sigma, const Vec3& towards);

}  // namespace sc::host

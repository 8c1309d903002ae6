// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <expected>
#include <optional>
#include <string>
#include <vector>

#include "host/formats/calibration_set.hpp"
#include "host/formats/station_job.hpp"
#include "host/formats/stations.hpp"
#include "host/measurement/location.hpp"

/// One station of the triple-laser head: its readings become the plane of the workpiece, its angles and distance
/// against the reference plane, with their uncertainties; or it is refused, and why.

namespace sc::host {

/// Why a station has no figures. A refusal is never a figure.
enum class StationProblem : std::uint8_t {
    missing_reference,  ///< the calibration does not say where the reference plane is
    swapped_sensors,    ///< the sensors' ids, or the readings themselves, say that columns are exchanged
    wrong_sensors,      ///< ids that the calibration does not have
    sensor_fault,       ///< every reading of a sensor carries a fault
    stale,              ///< too few readings are young enough
    stuck,              ///< a sensor repeats one value more often than its noise allows
    too_few,            ///< readings
    out_of_range,       ///< beyond what the sensors are good for
    collinear,          ///< the three spots lie (nearly) on one line
    grazing,            ///< the beams graze the surface
    inconsistent        ///< redundant readings that no plane fits
};
[[nodiscard]] const char* name_of(StationProblem problem) noexcept;

struct StationRefusal {
    StationProblem problem = StationProblem::too_few;
    std::string text;  ///< a sentence for a person, with values and what to do
};

/// Standard deviations by where they come from.
struct UncertaintyParts {
    double sensors = 0.0;   ///< noise of the readings
    double geometry = 0.0;  ///< calibration of beams, gains, zeros and reference
    double seat = 0.0;      ///< the magnetic base put down again
    [[nodiscard]] double total() const noexcept;
};

/// Radians and metres; frames d and r as in docs/measure.md.
struct StationResult {
    std::string id;
    std::optional<double> rail;
    std::array<double, 3> reading{};  ///< located, of the first pose
    std::size_t used = 0;             ///< readings per sensor, all poses
    std::size_t left_out = 0;         ///< stale, faulty or wild values
    std::array<Vec3, 3> spots{};      ///< in r
    Vec3 normal;                      ///< in r, unit, towards the head
    double angle = 0.0;               ///< between the planes, 0 to pi
    double about_y = 0.0;             ///< the same in the x-z plane of r
    double about_z = 0.0;             ///< yaw, in the x-y plane of r
    double distance = 0.0;            ///< along x of r, at `at`
    std::array<double, 2> at{};       ///< y, z in r
    UncertaintyParts angle_sigma;
    UncertaintyParts about_y_sigma;
    UncertaintyParts about_z_sigma;
    UncertaintyParts distance_sigma;
    double noise = 0.0;            ///< standard deviation of single readings, seen
    bool noisier = false;          ///< than calibrated, beyond chance: the uncertainty then goes by what is seen
    std::optional<double> misfit;  ///< rms along the beams over sigma, where readings are redundant
};

/// 95 % of normal errors.
inline constexpr double kCoverage95 = 1.959964;

struct StationOptions {
    Estimator estimator = Estimator::mean;
    SeatSigma seat;
    std::optional<std::array<double, 2>> at;  ///< default: that of the calibration
    double oldest = 0.2;                      ///< s
    std::size_t fewest = 3;                   ///< readings per sensor and pose
};
[[nodiscard]] StationOptions options_of(const StationJob& job);

[[nodiscard]] std::expected<StationResult, StationRefusal> measure_station(const TripleRecord& head,
                                                                           const Station& station,
                                                                           const StationOptions& options);

/// A station whose pose is known, measured as a check of head and wiring: nullopt when the figures agree within four
/// standard deviations; else the refusal, which names sensors that look exchanged.
[[nodiscard]] std::optional<StationRefusal> check_station(const TripleRecord& head, const Station& station,
                                                          const KnownPose& known, const StationOptions& options);

}  // namespace sc::host

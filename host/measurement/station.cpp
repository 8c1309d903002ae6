// SPDX-License-Identifier: Apache-2.0
#include "host/measurement/station.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "host/formats/text.hpp"
#include "host/measurement/head_model.hpp"
#include "host/measurement/station_readings.hpp"

namespace sc::host {

namespace {

constexpr double kDegree = std::numbers::pi / 180.0;
constexpr double kLeastSpread = 3e-3;  ///< metres, across the line nearest to the spots
constexpr double kLeastSpreadRatio = 0.05;
constexpr double kGrazing = 70.0 * kDegree;
constexpr double kLeastFacing = 0.1;  ///< |x| of the normal in r, below which a distance along x says nothing
constexpr double kCheckSigmas = 4.0;

using Order = std::array<std::size_t, 3>;
constexpr std::array<Order, 5> kExchanges{{{1, 0, 2}, {0, 2, 1}, {2, 1, 0}, {1, 2, 0}, {2, 0, 1}}};

std::unexpected<StationRefusal> refuse(StationProblem problem, std::string text) {
    return std::unexpected(StationRefusal{problem, std::move(text)});
}

std::vector<PoseReadings> exchanged(const std::vector<PoseReadings>& poses, const Order& order) {
    std::vector<PoseReadings> out = poses;
    for (std::size_t k = 0; k < out.size(); ++k) {
        for (std::size_t i = 0; i < 3; ++i) {
            out[k].value[i] = poses[k].value[order[i]];
            out[k].sigma[i] = poses[k].sigma[order[i]];
        }
    }
    return out;
}

std::string exchange_text(const TripleRecord& head, const Order& order) {
    std::string text;
    for (std::size_t i = 0; i < 3; ++i) {
        if (order[i] != i) {
            text += (text.empty() ? "" : ", ") + std::string("the readings of ") + head.rays[order[i]].id +
                    " belong to " + head.rays[i].id;
        }
    }
    return text;
}

/// Redundant readings: their misfit, or why no plane fits.
std::expected<std::optional<double>, StationRefusal> judge_misfit(const TripleRecord& head,
                                                                  const std::vector<PoseReadings>& poses,
                                                                  const DevicePlane& plane) {
    const double freedom = 3.0 * static_cast<double>(poses.size()) - 3.0;
    if (freedom <= 0.0) {
        return std::optional<double>{};
    }
    const double misfit = plane_misfit(head, poses, plane);
    // The calibration's own uncertainty is of the order of the noise of a located value: allowed for twofold.
    if (!beyond_chance(misfit / 4.0, freedom)) {
        return std::sqrt(misfit / freedom);
    }
    for (const Order& order : kExchanges) {
        const auto other = exchanged(poses, order);
        if (!beyond_chance(plane_misfit(head, other, fit_plane(head, other)) / 4.0, freedom)) {
            return refuse(StationProblem::swapped_sensors, "the sensors look exchanged: a plane fits only if " +
                                                               exchange_text(head, order) + "; put the cables right");
        }
    }
    return refuse(StationProblem::inconsistent,
                  "no plane fits the readings: " + fixed(std::sqrt(misfit / freedom), 1) +
                      " standard deviations rms; the head or the part moved, or the surface is not plane");
}

struct Sigmas {
    std::array<UncertaintyParts, 4> of;
};

Sigmas uncertainty(const TripleRecord& head, const std::vector<PoseReadings>& poses, const std::array<double, 2>& at,
                   const SeatSigma& seat) {
    const FigureSensitivity s = sensitivity(head, poses, at);
    Eigen::Matrix4d noise = Eigen::Matrix4d::Zero();
    for (std::size_t k = 0; k < poses.size(); ++k) {
        for (std::size_t i = 0; i < 3; ++i) {
            const Eigen::Vector4d column = s.by_reading.col(static_cast<int>(3 * k + i)) * poses[k].sigma[i];
            noise += column * column.transpose();
        }
    }
    const Eigen::Matrix4d geometry = s.by_parameter * covariance_of(head) * s.by_parameter.transpose();
    // The seat turns and shifts the head in r. Turned by w about the seat (origin of r), d_from_r changes by a turn
    // about the place where that origin lies in d: ξ = (w, −w × t).
    Eigen::Matrix4d seated = Eigen::Matrix4d::Zero();
    const Vec3 t = head.reference->translation;
    for (int axis = 0; axis < 3; ++axis) {
        const Vec3 w{axis == 0 ? 1.0 : 0.0, axis == 1 ? 1.0 : 0.0, axis == 2 ? 1.0 : 0.0};
        const Vec3 v = cross(t, w);
        HeadVector turn = HeadVector::Zero();
        turn.segment<3>(18) = Eigen::Vector3d(w.x, w.y, w.z);
        turn.segment<3>(21) = Eigen::Vector3d(v.x, v.y, v.z);
        HeadVector shift = HeadVector::Zero();
        shift(21 + axis) = 1.0;
        const Eigen::Vector4d by_turn = s.by_parameter * turn * seat.angle;
        const Eigen::Vector4d by_shift = s.by_parameter * shift * seat.place;
        seated += by_turn * by_turn.transpose() + by_shift * by_shift.transpose();
    }
    Sigmas out;
    for (int i = 0; i < 4; ++i) {
        out.of[static_cast<std::size_t>(i)] = {std::sqrt(noise(i, i)), std::sqrt(std::max(0.0, geometry(i, i))),
                                               std::sqrt(seated(i, i))};
    }
    return out;
}

bool agrees(const StationResult& result, const KnownPose& known) {
    const auto within = [](double off, double sigma, double other) {
        return std::abs(off) <= kCheckSigmas * std::hypot(sigma, other);
    };
    bool good = within(result.angle - known.angle, result.angle_sigma.total(), known.angle_sigma);
    if (known.yaw) {
        good = good && within(result.about_z - *known.yaw, result.about_z_sigma.total(), known.yaw_sigma);
    }
    if (known.distance) {
        good = good && within(result.distance - *known.distance, result.distance_sigma.total(), known.distance_sigma);
    }
    return good;
}

}  // namespace

const char* name_of(StationProblem problem) noexcept {
    switch (problem) {
        case StationProblem::missing_reference: return "missing_reference";
        case StationProblem::swapped_sensors: return "swapped_sensors";
        case StationProblem::wrong_sensors: return "wrong_sensors";
        case StationProblem::sensor_fault: return "sensor_fault";
        case StationProblem::stale: return "stale";
        case StationProblem::stuck: return "stuck";
        case StationProblem::too_few: return "too_few";
        case StationProblem::out_of_range: return "out_of_range";
        case StationProblem::collinear: return "collinear";
        case StationProblem::grazing: return "grazing";
        case StationProblem::inconsistent: return "inconsistent";
    }
    return "unknown";
}

double UncertaintyParts::total() const noexcept {
    return std::sqrt(sensors * sensors + geometry * geometry + seat * seat);
}

StationOptions options_of(const StationJob& job) {
    StationOptions out;
    out.seat = job.seat;
    if (job.at_given) {
        out.at = job.at;
    }
    out.oldest = job.oldest;
    out.fewest = static_cast<std::size_t>(job.fewest);
    return out;
}

std::expected<StationResult, StationRefusal> measure_station(const TripleRecord& head, const Station& station,
                                                             const StationOptions& options) {
    if (!head.reference) {
        return refuse(StationProblem::missing_reference,
                      "the calibration does not say where the reference plane is: give [reference] in the stand's "
                      "file, or run scribecell calibrate reference");
    }
    const auto located = locate_station(head, station, options);
    if (!located) {
        return std::unexpected(located.error());
    }
    const std::array<double, 2> spread = spot_spread(head, located->poses);
    if (!(spread[1] > kLeastSpread && spread[1] > kLeastSpreadRatio * spread[0])) {
        return refuse(StationProblem::collinear, "the spots lie on one line: they spread " + fixed(spread[0] * 1e3, 2) +
                                                     " mm along it and " + fixed(spread[1] * 1e3, 2) +
                                                     " mm across; arrange the sensors in a triangle, or correct their "
                                                     "places in the calibration");
    }
    const DevicePlane plane = fit_plane(head, located->poses);
    const Vec3 normal = direction_to_reference(*head.reference, plane.normal());
    if (!(plane.incidence() < kGrazing) || !(normal.x < -kLeastFacing)) {
        return refuse(StationProblem::grazing, "the beams meet the surface at " +
                                                   fixed(plane.incidence() / kDegree, 1) +
                                                   " degrees from its normal: too flat to measure; turn the workpiece "
                                                   "towards the head, or look whether a beam misses it");
    }
    const auto misfit = judge_misfit(head, located->poses, plane);
    if (!misfit) {
        return std::unexpected(misfit.error());
    }
    StationResult out;
    out.id = station.id;
    out.rail = station.rail;
    out.reading = located->poses.front().value;
    out.used = located->used;
    out.left_out = located->left_out;
    for (std::size_t i = 0; i < 3; ++i) {
        out.spots[i] =
            to_reference(*head.reference, spot_of(head.rays[i], out.reading[i], located->poses.front().pose));
    }
    out.normal = normal;
    out.at = options.at.value_or(head.reference->at);
    const PlaneFigures figures = figures_of(*head.reference, plane, out.at);
    out.angle = figures.angle;
    out.about_y = figures.about_y;
    out.about_z = figures.about_z;
    out.distance = figures.distance;
    const Sigmas sigmas = uncertainty(head, located->poses, out.at, options.seat);
    out.angle_sigma = sigmas.of[0];
    out.about_y_sigma = sigmas.of[1];
    out.about_z_sigma = sigmas.of[2];
    out.distance_sigma = sigmas.of[3];
    out.noise = located->noise;
    out.noisier = located->noisier;
    out.misfit = *misfit;
    return out;
}

std::optional<StationRefusal> check_station(const TripleRecord& head, const Station& station, const KnownPose& known,
                                            const StationOptions& options) {
    const auto result = measure_station(head, station, options);
    if (!result) {
        return result.error();
    }
    if (agrees(*result, known)) {
        return std::nullopt;
    }
    const std::string off = "the known station " + station.id + " reads " + fixed(result->angle / kDegree, 3) +
                            " degrees and should read " + fixed(known.angle / kDegree, 3);
    for (const Order& order : kExchanges) {
        Station other = station;
        for (HeadReading& reading : other.readings) {
            const auto value = reading.value;
            for (std::size_t i = 0; i < 3; ++i) {
                reading.value[i] = value[order[i]];
            }
        }
        const auto again = measure_station(head, other, options);
        if (again && agrees(*again, known)) {
            return StationRefusal{
                StationProblem::swapped_sensors,
                off + ": the sensors look exchanged, " + exchange_text(head, order) + "; put the cables right"};
        }
    }
    return StationRefusal{StationProblem::inconsistent,
                          off + ": head, seat or calibration has changed; seat the head again, or calibrate it"};
}

}  // namespace sc::host

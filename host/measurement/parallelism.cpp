// SPDX-License-Identifier: Apache-2.0
#include "host/measurement/parallelism.hpp"

#include <algorithm>
#include <cmath>

#include <Eigen/Dense>

#include "host/formats/error.hpp"
#include "host/formats/text.hpp"
#include "host/measurement/head_model.hpp"
#include "host/measurement/location.hpp"
#include "host/measurement/plate_scale.hpp"

namespace sc::host {

namespace {

constexpr double kLeastSpread = 3e-3;
constexpr double kZeroPrior = 1e-3;  ///< metres, one sigma, of a sensor that was never read on a plate
constexpr double kGainPrior = 5e-3;
constexpr double kDrawnPlace = 0.5e-3;  ///< of a workshop
constexpr double kDrawnTilt = 5e-3;
constexpr double kLeastSpotSigma = 1e-6;
constexpr double kSquare = 2.0;  ///< how much more than calculated the misfit may be

[[noreturn]] void fail(const Stand& stand, std::string problem, std::string value, std::string action) {
    throw InputError({.file = stand.file.string(),
                      .problem = std::move(problem),
                      .value = std::move(value),
                      .action = std::move(action)});
}

/// A straight line v = p + q·s for each sensor, one value a plate; errors of a plate are shared by the sensors.
struct Lines {
    Eigen::Matrix<double, 6, 1> value;  ///< p, q of sensor 1, 2, 3
    Eigen::Matrix<double, 6, 6> covariance;
    double chi2 = 0.0;
    double rms = 0.0;
    double freedom = 0.0;
};

struct LineData {
    std::array<std::vector<double>, 3> s;
    std::array<std::vector<double>, 3> v;
    std::array<std::vector<double>, 3> sigma;
    double shared = 0.0;
};

Lines fit_lines(const LineData& data) {
    const std::size_t plates = data.s[0].size();
    const auto n = static_cast<Eigen::Index>(3 * plates);
    Eigen::MatrixXd design = Eigen::MatrixXd::Zero(n, 6);
    Eigen::VectorXd v(n);
    Eigen::MatrixXd noise = Eigen::MatrixXd::Zero(n, n);
    for (std::size_t i = 0; i < 3; ++i) {
        for (std::size_t k = 0; k < plates; ++k) {
            const auto row = static_cast<Eigen::Index>(3 * k + i);
            design(row, static_cast<Eigen::Index>(2 * i)) = 1.0;
            design(row, static_cast<Eigen::Index>(2 * i + 1)) = data.s[i][k];
            v(row) = data.v[i][k];
            noise(row, row) += data.sigma[i][k] * data.sigma[i][k];
            for (std::size_t j = 0; j < 3; ++j) {
                noise(row, static_cast<Eigen::Index>(3 * k + j)) += data.shared * data.shared;
            }
        }
    }
    const Eigen::LDLT<Eigen::MatrixXd> weight(noise);
    Lines out;
    const Eigen::MatrixXd weighted = weight.solve(design);
    out.covariance = (design.transpose() * weighted).inverse();
    out.value = out.covariance * (weighted.transpose() * v);
    const Eigen::VectorXd off = v - design * out.value;
    out.chi2 = off.dot(weight.solve(off));
    out.rms = std::sqrt(off.squaredNorm() / static_cast<double>(n));
    out.freedom = static_cast<double>(n) - 6.0;
    return out;
}

/// The pictures name their sensors by their order: each spot must be nearest to where its sensor was drawn.
void check_order(const Stand& stand, const PlateScale& plate) {
    for (std::size_t i = 0; i < 3; ++i) {
        std::size_t best = 0;
        const auto distance = [&](std::size_t k) {
            return std::hypot(plate.spots[i][0] - stand.sensors[k].origin[0],
                              plate.spots[i][1] - stand.sensors[k].origin[1]);
        };
        for (std::size_t k = 1; k < 3; ++k) {
            best = distance(k) < distance(best) ? k : best;
        }
        if (best != i) {
            fail(stand, "the pictures of sensors look swapped on the plate at " + fixed(plate.z * 1e3, 1) + " mm",
                 "the spot of " + stand.sensors[i].id + " lies where " + stand.sensors[best].id + " shines",
                 "name the pictures in the order of the sensors, or put the cables right");
        }
    }
}

void check_triangle(const Stand& stand, const PlateScale& plate) {
    const auto& a = plate.spots[0];
    const auto& b = plate.spots[1];
    const auto& c = plate.spots[2];
    const double area = std::abs((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]));
    const double longest = *std::max_element(plate.side.begin(), plate.side.end());
    if (!(area > kLeastSpread * longest)) {
        fail(stand, "the three spots lie on one line on the plate at " + fixed(plate.z * 1e3, 1) + " mm",
             fixed(area / longest * 1e3, 2) + " mm across", "arrange the sensors in a triangle");
    }
}

LineData spot_lines(const Stand& stand, const std::vector<PlateScale>& plates, std::size_t axis) {
    LineData data;
    data.shared = std::max(stand.registration, kLeastSpotSigma);
    const double dots = static_cast<double>(stand.dots.size());
    for (const PlateScale& plate : plates) {
        // A map of eight numbers through the dots moves a spot by about this much.
        const double of_map = plate.residual * std::sqrt(4.0 / dots);
        for (std::size_t i = 0; i < 3; ++i) {
            data.s[i].push_back(plate.z);
            data.v[i].push_back(plate.spots[i][axis]);
            data.sigma[i].push_back(std::max(kLeastSpotSigma, std::hypot(plate.spot_sigma, of_map)));
        }
    }
    return data;
}

struct ReadingFit {
    std::array<double, 3> sigma{};
    Lines lines;
};

/// All readings of a plate, sensor by sensor.
std::array<std::vector<double>, 3> values_of(const StationFile& file) {
    std::array<std::vector<double>, 3> out;
    for (const Station& station : file.stations) {
        for (const HeadReading& reading : station.readings) {
            for (std::size_t i = 0; i < 3 && reading.fault.empty(); ++i) {
                out[i].push_back(reading.value[i]);
            }
        }
    }
    return out;
}

std::optional<ReadingFit> fit_readings(const Stand& stand, const std::vector<StationFile>& readings,
                                       const TripleRecord& head) {
    const auto with =
        std::count_if(readings.begin(), readings.end(), [](const StationFile& file) { return !file.stations.empty(); });
    if (with == 0) {
        return std::nullopt;
    }
    if (static_cast<std::size_t>(with) != readings.size()) {
        fail(stand, "some plates have readings and some have none", std::to_string(with),
             "give readings for every [[height]], or for none");
    }
    ReadingFit out;
    std::vector<std::array<std::vector<double>, 3>> values;
    for (std::size_t k = 0; k < readings.size(); ++k) {
        values.push_back(values_of(readings[k]));
        if (values.back()[0].size() < 3) {
            fail(stand, "too few readings on the plate at " + fixed(stand.heights[k].z * 1e3, 1) + " mm",
                 std::to_string(values.back()[0].size()), "read each sensor ten times or more");
        }
    }
    LineData data;
    data.shared = std::max(stand.height_sigma, 1e-7);
    for (std::size_t i = 0; i < 3; ++i) {
        double squares = 0.0;
        double freedom = 0.0;
        for (const auto& plate : values) {
            const double s = scatter(plate[i]);
            squares += s * s * static_cast<double>(plate[i].size() - 1);
            freedom += static_cast<double>(plate[i].size() - 1);
        }
        out.sigma[i] = std::max(std::sqrt(squares / freedom), 1e-7);
        const double along =
            std::sqrt(1.0 + head.rays[i].tilt[0] * head.rays[i].tilt[0] + head.rays[i].tilt[1] * head.rays[i].tilt[1]);
        for (std::size_t k = 0; k < values.size(); ++k) {
            const Location location = locate(values[k][i], out.sigma[i], Estimator::mean);
            data.s[i].push_back(stand.heights[k].z * along);
            data.v[i].push_back(location.value);
            data.sigma[i].push_back(location.sigma);
        }
    }
    out.lines = fit_lines(data);
    for (int i = 0; i < 3; ++i) {
        if (const double slope = out.lines.value(2 * i + 1); !(slope > 0.8 && slope < 1.25)) {
            fail(stand,
                 "the readings of sensor " + stand.sensors[static_cast<std::size_t>(i)].id +
                     " do not go with the plates' heights; slope",
                 fixed(slope, 4), "see which file belongs to which plate");
        }
    }
    if (beyond_chance(out.lines.chi2 / (kSquare * kSquare), out.lines.freedom)) {
        fail(stand, "the readings lie off straight lines over the plates' heights, rms in um",
             fixed(out.lines.rms * 1e6, 1), "see which file belongs to which plate, and the heights");
    }
    return out;
}

void take_spots(const Stand& stand, const std::array<Lines, 2>& lines, const ParallelismParts& parts,
                TripleRecord& head, HeadMatrix& covariance) {
    for (std::size_t axis = 0; axis < 2; ++axis) {
        for (std::size_t i = 0; i < 3; ++i) {
            const auto p = static_cast<Eigen::Index>(2 * i);
            head.rays[i].origin[axis] = parts.spots ? lines[axis].value(p) : stand.sensors[i].origin[axis];
            head.rays[i].tilt[axis] = parts.tilt ? lines[axis].value(p + 1) : 0.0;
            for (std::size_t j = 0; j < 3; ++j) {
                for (std::size_t a = 0; a < 2; ++a) {
                    for (std::size_t b = 0; b < 2; ++b) {
                        covariance(static_cast<Eigen::Index>(6 * i + 2 * a + axis),
                                   static_cast<Eigen::Index>(6 * j + 2 * b + axis)) =
                            lines[axis].covariance(static_cast<Eigen::Index>(2 * i + a),
                                                   static_cast<Eigen::Index>(2 * j + b));
                    }
                }
            }
        }
    }
}

void take_readings(const ReadingFit& fit, double middle, const ParallelismParts& parts, TripleRecord& head,
                   HeadMatrix& covariance) {
    Eigen::Matrix<double, 6, 6> to_parameters = Eigen::Matrix<double, 6, 6>::Identity();
    for (std::size_t i = 0; i < 3; ++i) {
        const auto p = static_cast<Eigen::Index>(2 * i);
        const double slope = fit.lines.value(p + 1);
        head.rays[i].sigma = fit.sigma[i];
        head.rays[i].gain = parts.gain ? 1.0 / slope - 1.0 : 0.0;
        // Without a gain the zero is what is right at the middle plate.
        head.rays[i].zero = parts.gain ? fit.lines.value(p) : fit.lines.value(p) + (slope - 1.0) * middle;
        to_parameters(p + 1, p + 1) = -1.0 / (slope * slope);
    }
    const Eigen::Matrix<double, 6, 6> c = to_parameters * fit.lines.covariance * to_parameters.transpose();
    for (Eigen::Index i = 0; i < 3; ++i) {
        for (Eigen::Index j = 0; j < 3; ++j) {
            covariance.block<2, 2>(6 * i + 4, 6 * j + 4) = c.block<2, 2>(2 * i, 2 * j);
        }
    }
}

void take_reference(const Stand& stand, TripleRecord& head, HeadMatrix& covariance) {
    head.reference = stand.reference;
    for (Eigen::Index k = 0; k < 6; ++k) {
        const double sigma = k < 3 ? stand.reference_angle_sigma : stand.reference_place_sigma;
        covariance(18 + k, 18 + k) = stand.reference ? sigma * sigma : 1.0;
    }
}

double angle_between(const TripleRay& a, const TripleRay& b) {
    const Vec3 u{a.tilt[0], a.tilt[1], 1.0};
    const Vec3 v{b.tilt[0], b.tilt[1], 1.0};
    return std::atan2(norm(cross(u, v)), dot(u, v));
}

void describe(const Stand& stand, const std::array<Lines, 2>& lines, Parallelism& out) {
    const PlateScale& plate = out.plates.front();
    for (std::size_t i = 0; i < 3; ++i) {
        const std::size_t j = (i + 1) % 3;
        const auto p = static_cast<Eigen::Index>(2 * i + 1);
        const auto q = static_cast<Eigen::Index>(2 * j + 1);
        double variance = 0.0;
        for (std::size_t axis = 0; axis < 2; ++axis) {
            const double e = (plate.spots[j][axis] - plate.spots[i][axis]) / plate.side[i];
            out.side_drift[i] += e * (lines[axis].value(q) - lines[axis].value(p));
            const auto& c = lines[axis].covariance;
            variance += e * e * (c(p, p) + c(q, q) - 2.0 * c(p, q));
            out.tilt_sigma[i][axis] = std::sqrt(c(p, p));
        }
        out.side_drift_sigma[i] = std::sqrt(variance);
        out.between[i] = angle_between(out.head.rays[i], out.head.rays[j]);
    }
    double variance = 0.0;
    for (std::size_t axis = 0; axis < 2; ++axis) {
        for (Eigen::Index i = 1; i < 6; i += 2) {
            out.drift[axis] += lines[axis].value(i) / 3.0;
            for (Eigen::Index j = 1; j < 6; j += 2) {
                variance += 0.5 * lines[axis].covariance(i, j) / 9.0;
            }
        }
    }
    out.drift_sigma = std::sqrt(variance);
    if (stand.mount) {
        const double sign = stand.mount->clockwise_is_positive ? 1.0 : -1.0;
        for (std::size_t i = 0; i < 3; ++i) {
            for (std::size_t axis = 0; axis < 2; ++axis) {
                const double tilt = lines[axis].value(static_cast<Eigen::Index>(2 * i + 1));
                out.turns.push_back({stand.sensors[i].id, axis == 0 ? 'x' : 'y', tilt,
                                     -sign * std::tan(tilt) * stand.mount->arm / stand.mount->pitch});
            }
        }
    }
}

}  // namespace

TripleRecord drawn_head_of(const Stand& stand) {
    TripleRecord head;
    head.range = stand.range;
    HeadMatrix covariance = HeadMatrix::Zero();
    const std::array sigma{kDrawnPlace, kDrawnPlace, kDrawnTilt, kDrawnTilt, kZeroPrior, kGainPrior};
    for (std::size_t i = 0; i < 3; ++i) {
        head.rays[i].id = stand.sensors[i].id;
        head.rays[i].origin = stand.sensors[i].origin;
        head.rays[i].sigma = stand.sigma;
        for (std::size_t k = 0; k < 6; ++k) {
            const auto at = static_cast<Eigen::Index>(6 * i + k);
            covariance(at, at) = sigma[k] * sigma[k];
        }
    }
    take_reference(stand, head, covariance);
    set_covariance(head, covariance);
    head.provenance = {.parents = {stand.id}, .residual_rms = 0.0, .time = stand.time, .note = "as drawn"};
    return head;
}

Parallelism fit_parallelism(const Stand& stand, const std::vector<PlatePixels>& plates,
                            const std::vector<StationFile>& readings, const ParallelismParts& parts) {
    Parallelism out;
    double middle = 0.0;
    for (const PlatePixels& pixels : plates) {
        out.plates.push_back(scale_of(stand, pixels));
        check_order(stand, out.plates.back());
        check_triangle(stand, out.plates.back());
        middle += pixels.z / static_cast<double>(plates.size());
    }
    const std::array<Lines, 2> lines{fit_lines(spot_lines(stand, out.plates, 0)),
                                     fit_lines(spot_lines(stand, out.plates, 1))};
    out.place_rms = std::sqrt(0.5 * (lines[0].rms * lines[0].rms + lines[1].rms * lines[1].rms));
    if (beyond_chance((lines[0].chi2 + lines[1].chi2) / (kSquare * kSquare), lines[0].freedom + lines[1].freedom)) {
        fail(stand, "the spots do not lie on straight beams, rms in um", fixed(out.place_rms * 1e6, 1),
             "see which picture belongs to which plate, and whether head or camera moved in between");
    }
    out.head = drawn_head_of(stand);
    HeadMatrix covariance = covariance_of(out.head);
    take_spots(stand, lines, parts, out.head, covariance);
    if (const auto fit = fit_readings(stand, readings, out.head)) {
        take_readings(*fit, middle, parts, out.head, covariance);
        out.reading_rms = fit->lines.rms;
    }
    set_covariance(out.head, covariance);
    out.head.provenance = {.parents = {stand.id}, .residual_rms = out.place_rms, .time = stand.time, .note = ""};
    describe(stand, lines, out);
    return out;
}

std::vector<SensorRay> rays_in_h(const TripleRecord& head, const TransformRecord& h_from_d, double at) {
    std::vector<SensorRay> out;
    for (const TripleRay& ray : head.rays) {
        const Vec3 along{ray.tilt[0], ray.tilt[1], 1.0};
        const Vec3 u = (1.0 / norm(along)) * along;
        SensorRay in_h;
        in_h.id = ray.id;
        // At the reading `at` the place is exact; from there on the ray's own reading counts plainly.
        const Vec3 origin = Vec3{ray.origin[0], ray.origin[1], 0.0} + (ray.gain * (at - ray.zero)) * u;
        in_h.origin.v = h_from_d.rotation * origin + h_from_d.translation;
        in_h.direction.v = h_from_d.rotation * u;
        in_h.zero = ray.zero;
        in_h.sigma = ray.sigma;
        in_h.provenance = head.provenance;
        out.push_back(in_h);
    }
    return out;
}

}  // namespace sc::host

// SPDX-License-Identifier: Apache-2.0
#include "host/measurement/reference_fit.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <Eigen/Dense>

#include "host/formats/error.hpp"
#include "host/formats/text.hpp"
#include "host/measurement/head_model.hpp"
#include "host/measurement/station_readings.hpp"

namespace sc::host {

namespace {

constexpr int kRounds = 5;
constexpr double kDegree = std::numbers::pi / 180.0;

using Order = std::array<std::size_t, 3>;
constexpr std::array<Order, 6> kOrders{{{0, 1, 2}, {1, 0, 2}, {0, 2, 1}, {2, 1, 0}, {1, 2, 0}, {2, 0, 1}}};

/// What is known of one station: angle, yaw, distance, those that are.
struct Observation {
    std::vector<PoseReadings> readings;
    KnownPose known;
    std::vector<int> rows;  ///< of the vector of figures
    Eigen::VectorXd value;
    Eigen::VectorXd sigma;
};

struct Solution {
    HeadVector change = HeadVector::Zero();
    HeadMatrix covariance;
    double chi2 = 0.0;
    double freedom = 0.0;
};

class Fit {
public:
    Fit(const TripleRecord& head, std::vector<Observation> observations, const StationOptions& options)
        : head_(head),
          observations_(std::move(observations)),
          seat_(options.seat),
          at_(options.at.value_or(head.reference->at)) {}

    [[nodiscard]] Solution solve() const {
        // Parameters in units of their own sigma: variances differ by ten orders.
        const HeadMatrix before = covariance_of(head_);
        const HeadVector unit = before.diagonal().cwiseSqrt();
        const HeadMatrix scaled = unit.cwiseInverse().asDiagonal() * before * unit.cwiseInverse().asDiagonal();
        const HeadMatrix information = scaled.ldlt().solve(HeadMatrix::Identity());
        HeadVector x = HeadVector::Zero();
        HeadMatrix normal = information;
        for (int round = 0; round < kRounds; ++round) {
            const TripleRecord now = changed(head_, unit.asDiagonal() * x);
            normal = information;
            HeadVector right = HeadVector::Zero();
            for (const Observation& observation : observations_) {
                const Linear line = linear(now, observation);
                const Eigen::MatrixXd j = line.jacobian * unit.asDiagonal();
                const Eigen::LDLT<Eigen::MatrixXd> weight(line.noise);
                normal += j.transpose() * weight.solve(j);
                right += j.transpose() * weight.solve(line.off + j * x);
            }
            x = normal.ldlt().solve(right);
        }
        Solution out;
        out.change = unit.asDiagonal() * x;
        out.covariance = unit.asDiagonal() * normal.ldlt().solve(HeadMatrix::Identity()) * unit.asDiagonal();
        out.chi2 = x.dot(information * x);
        const TripleRecord last = changed(head_, out.change);
        for (const Observation& observation : observations_) {
            const Linear line = linear(last, observation);
            out.chi2 += line.off.dot(line.noise.ldlt().solve(line.off));
            out.freedom += static_cast<double>(line.off.size());
        }
        return out;
    }

private:
    struct Linear {
        Eigen::VectorXd off;
        Eigen::MatrixXd jacobian;
        Eigen::MatrixXd noise;
    };

    [[nodiscard]] Linear linear(const TripleRecord& now, const Observation& o) const {
        const auto n = static_cast<Eigen::Index>(o.rows.size());
        const Eigen::Vector4d figures = figures_of(*now.reference, fit_plane(now, o.readings), at_).vector();
        const FigureSensitivity s = sensitivity(now, o.readings, at_);
        Linear out{Eigen::VectorXd(n), Eigen::MatrixXd(n, static_cast<Eigen::Index>(kHeadParameters)),
                   Eigen::MatrixXd::Zero(n, n)};
        Eigen::MatrixXd by_reading(n, s.by_reading.cols());
        for (Eigen::Index i = 0; i < n; ++i) {
            const int row = o.rows[static_cast<std::size_t>(i)];
            out.off(i) = o.value(i) - figures(row);
            out.jacobian.row(i) = s.by_parameter.row(row);
            by_reading.row(i) = s.by_reading.row(row);
            out.noise(i, i) = o.sigma(i) * o.sigma(i);
            // The seat turns the head by so much, whatever the axis; a distance shifts besides.
            out.noise(i, i) += row == 3 ? seat_.place * seat_.place : seat_.angle * seat_.angle;
        }
        for (std::size_t k = 0; k < o.readings.size(); ++k) {
            for (std::size_t i = 0; i < 3; ++i) {
                const Eigen::VectorXd c = by_reading.col(static_cast<Eigen::Index>(3 * k + i)) * o.readings[k].sigma[i];
                out.noise += c * c.transpose();
            }
        }
        return out;
    }

    TripleRecord head_;
    std::vector<Observation> observations_;
    SeatSigma seat_;
    std::array<double, 2> at_;
};

[[noreturn]] void fail(const StationFile& file, std::string problem, std::string value, std::string action) {
    throw InputError({.file = file.file.string(),
                      .problem = std::move(problem),
                      .value = std::move(value),
                      .action = std::move(action)});
}

const Station& station_of(const StationFile& stations, const KnownPose& known) {
    const auto found = std::find_if(stations.stations.begin(), stations.stations.end(),
                                    [&](const Station& station) { return station.id == known.station; });
    if (found == stations.stations.end()) {
        fail(stations, "has no readings of a known station", shortened(known.station), "measure it, or leave it out");
    }
    return *found;
}

Observation observation_of(const TripleRecord& head, const StationFile& stations, const KnownPose& known,
                           const StationOptions& options) {
    const Station& station = station_of(stations, known);
    const auto located = locate_station(head, station, options);
    if (!located) {
        fail(stations, "a known station is refused", shortened(known.station), located.error().text);
    }
    Observation out;
    out.readings = located->poses;
    out.known = known;
    std::vector<double> value{known.angle};
    std::vector<double> sigma{known.angle_sigma};
    out.rows = {0};
    if (known.yaw) {
        out.rows.push_back(2);
        value.push_back(*known.yaw);
        sigma.push_back(known.yaw_sigma);
    }
    if (known.distance) {
        out.rows.push_back(3);
        value.push_back(*known.distance);
        sigma.push_back(known.distance_sigma);
    }
    const auto n = static_cast<Eigen::Index>(value.size());
    out.value = Eigen::Map<Eigen::VectorXd>(value.data(), n);
    out.sigma = Eigen::Map<Eigen::VectorXd>(sigma.data(), n);
    return out;
}

std::vector<Observation> ordered(const std::vector<Observation>& observations, const Order& order) {
    std::vector<Observation> out = observations;
    for (std::size_t n = 0; n < out.size(); ++n) {
        for (std::size_t k = 0; k < out[n].readings.size(); ++k) {
            for (std::size_t i = 0; i < 3; ++i) {
                out[n].readings[k].value[i] = observations[n].readings[k].value[order[i]];
                out[n].readings[k].sigma[i] = observations[n].readings[k].sigma[order[i]];
            }
        }
    }
    return out;
}

/// Poses that this head cannot have measured: swapped sensors, or something else.
[[noreturn]] void refuse(const TripleRecord& head, const StationFile& stations,
                         const std::vector<Observation>& observations, const StationOptions& options, double misfit) {
    const std::string value = fixed(misfit, 1) + " standard deviations rms";
    for (const Order& order : kOrders) {
        const Solution other = Fit(head, ordered(observations, order), options).solve();
        if (!beyond_chance(other.chi2, other.freedom)) {
            std::string names;
            for (const std::size_t i : order) {
                names += (names.empty() ? "" : " ") + head.rays[i].id;
            }
            fail(stations, "the sensors look swapped: the known poses fit only if the columns are of", names,
                 "put the cables right, and measure again");
        }
    }
    fail(stations, "the readings do not fit the known poses", value,
         "see whether stations are mixed up, or the head was hit since its parallelism was calibrated");
}

double geometry_sigma(const TripleRecord& head, const Observation& observation, const std::array<double, 2>& at) {
    const FigureSensitivity s = sensitivity(head, observation.readings, at);
    return std::sqrt(s.by_parameter.row(0) * covariance_of(head) * s.by_parameter.row(0).transpose());
}

}  // namespace

ReferenceFit fit_reference(const TripleRecord& head, const StationFile& stations, const std::vector<KnownPose>& known,
                           const StationOptions& options, bool check) {
    if (!head.reference) {
        fail(stations, "the head's calibration has no reference to start from", {},
             "give the stand's file a [reference] from the drawing, and calibrate the parallelism again");
    }
    std::vector<Observation> observations;
    for (const KnownPose& pose : known) {
        observations.push_back(observation_of(head, stations, pose, options));
    }
    const Solution solution = Fit(head, observations, options).solve();
    ReferenceFit out;
    out.misfit = std::sqrt(solution.chi2 / solution.freedom);
    if (check && beyond_chance(solution.chi2, solution.freedom)) {
        refuse(head, stations, observations, options, out.misfit);
    }
    const std::array<double, 2> at = options.at.value_or(head.reference->at);
    out.head = changed(head, solution.change);
    set_covariance(out.head, solution.covariance);
    for (const Observation& o : observations) {
        const auto angle = [&](const TripleRecord& with) {
            return figures_of(*with.reference, fit_plane(with, o.readings), at).angle - o.known.angle;
        };
        out.residuals.push_back({o.known.station, angle(head), angle(out.head)});
    }
    out.angle_sigma_before = geometry_sigma(head, observations.front(), at);
    out.angle_sigma_after = geometry_sigma(out.head, observations.front(), at);
    double squares = 0.0;
    for (const KnownResidual& residual : out.residuals) {
        squares += residual.angle_after * residual.angle_after;
    }
    out.head.provenance.note = "reference from " + std::to_string(known.size()) + " known stations, angles off " +
                               fixed(std::sqrt(squares / static_cast<double>(known.size())) / kDegree, 4) + " deg rms";
    return out;
}

}  // namespace sc::host

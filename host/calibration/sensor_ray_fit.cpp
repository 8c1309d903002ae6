// SPDX-License-Identifier: Apache-2.0
#include "host/calibration/sensor_ray_fit.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <stdexcept>

#include <Eigen/Dense>
#include <fmt/format.h>

#include "host/calibration/motion.hpp"
#include "host/formats/error.hpp"

namespace sc::host {
namespace {

constexpr std::size_t kFewest = 8;
constexpr int kRounds = 30;
constexpr double kFar = 5.0;  ///< standard deviations: no reading of this plane
using Vector = Eigen::Matrix<double, 5, 1>;
using Square = Eigen::Matrix<double, 5, 5>;

class Fit {
public:
    Fit(const std::filesystem::path& file, const std::vector<KnownPlane>& planes,
        const std::vector<RangeReading>& readings, double anchor, const SensorRayOptions& options)
        : file_(file), options_(options), anchor_(anchor), used_(readings.size(), true), readings_(readings) {
        if (readings.size() < kFewest) {
            refuse("has too few readings", std::to_string(readings.size()), fmt::format("take {} or more", kFewest));
        }
        const Eigen::Vector3d along = to_eigen(options.along);
        along.cwiseAbs().maxCoeff(&main_);
        sign_ = along(main_) < 0.0 ? -1.0 : 1.0;
        across_ = {main_ == 0 ? 1 : 0, main_ == 2 ? 1 : 2};
        for (const RangeReading& r : readings) {
            const auto found = std::ranges::find(planes, r.plane, &KnownPlane::id);
            if (found == planes.end()) {
                throw InputError({.file = file.string(),
                                  .line = r.line,
                                  .problem = "a reading over a plane that is not known",
                                  .value = std::to_string(r.plane),
                                  .action = "measure that plane, or leave the reading out"});
            }
            plane_.push_back(*found);
        }
    }

    SensorRayFit run() {
        Vector x = Vector::Zero();
        x(2) = to_eigen(options_.along)(across_[0]);
        x(3) = to_eigen(options_.along)(across_[1]);
        for (;;) {
            for (int round = 0; round < kRounds; ++round) {
                const System s = system(x);
                const Square& n = s.normal;
                check(n);
                const Vector scale = n.diagonal().cwiseSqrt().cwiseInverse();
                const Square scaled = scale.asDiagonal() * n * scale.asDiagonal();
                const Vector step = scale.asDiagonal() * scaled.ldlt().solve(Vector(scale.asDiagonal() * s.gradient));
                x += step;
                if (step.norm() < 1e-12) {
                    break;
                }
            }
            const std::size_t worst = worst_reading(x);
            if (worst == readings_.size()) {
                return finish(x);
            }
            used_[worst] = false;
        }
    }

private:
    [[noreturn]] void refuse(std::string problem, std::string value, std::string action) const {
        throw InputError({.file = file_.string(),
                          .problem = std::move(problem),
                          .value = std::move(value),
                          .action = std::move(action)});
    }
    [[nodiscard]] Eigen::Vector3d direction(const Vector& x) const {
        Eigen::Vector3d d;
        d(across_[0]) = x(2);
        d(across_[1]) = x(3);
        d(main_) = sign_ * std::sqrt(std::max(0.01, 1.0 - x(2) * x(2) - x(3) * x(3)));
        return d;
    }
    [[nodiscard]] Eigen::Vector3d origin(const Vector& x) const {
        Eigen::Vector3d o;
        o(across_[0]) = x(0);
        o(across_[1]) = x(1);
        o(main_) = anchor_;
        return o;
    }
    struct Row {
        double left = 0.0;  ///< along the beam, over its sigma
        double left_metres = 0.0;
        double sigma = 0.0;
        double common = 0.0;  ///< metres, of the group
        Vector slope;
    };
    [[nodiscard]] Row row(const Vector& x, std::size_t i) const {
        const RangeReading& r = readings_[i];
        const KnownPlane& plane = plane_[i];
        const Eigen::Vector3d n = to_eigen(plane.normal);
        const Eigen::Vector3d d = direction(x);
        const double steep = n.dot(d);
        const double range = r.reading - x(4);
        const double off =
            plane.distance - n.dot(to_eigen(r.carrier) + origin(x) + range * d);  // metres along the normal
        Row out;
        out.left_metres = off / steep;
        out.left = out.left_metres / r.sigma;
        out.sigma = r.sigma;
        out.common = std::hypot(r.common, plane.sigma / steep);
        Vector by;
        by << n(across_[0]), n(across_[1]), range * (n(across_[0]) - n(main_) * x(2) / d(main_)),
            range * (n(across_[1]) - n(main_) * x(3) / d(main_)), -steep;
        out.slope = by / (steep * r.sigma);
        return out;
    }
    struct System {
        Square normal = Square::Zero();
        Vector gradient = Vector::Zero();
        double chi_squared = 0.0;
    };
    /// The covariance of a group is diag(sigma^2) + common^2 of all ones; its inverse by Sherman and Morrison.
    [[nodiscard]] System system(const Vector& x) const {
        struct Group {
            Vector slope = Vector::Zero();
            double left = 0.0;
            double weight = 0.0;
            double common = 0.0;
        };
        System out;
        std::map<int, Group> groups;
        for (std::size_t i = 0; i < readings_.size(); ++i) {
            if (used_[i]) {
                const Row r = row(x, i);
                out.normal += r.slope * r.slope.transpose();
                out.gradient += r.slope * r.left;
                out.chi_squared += r.left * r.left;
                Group& group = groups[readings_[i].group < 0 ? readings_[i].plane : readings_[i].group];
                group.slope += r.slope / r.sigma;
                group.left += r.left / r.sigma;
                group.weight += 1.0 / (r.sigma * r.sigma);
                group.common = std::max(group.common, r.common);
            }
        }
        for (const auto& [id, group] : groups) {
            const double variance = group.common * group.common;
            const double part = variance / (1.0 + variance * group.weight);
            out.normal -= part * group.slope * group.slope.transpose();
            out.gradient -= part * group.left * group.slope;
            out.chi_squared -= part * group.left * group.left;
        }
        return out;
    }
    [[nodiscard]] std::string name_of(const Vector& v) const {
        Eigen::Index at = 0;
        v.cwiseAbs().maxCoeff(&at);
        const char* axes = "xyz";
        switch (at) {
            case 0: return fmt::format("origin along {}", axes[across_[0]]);
            case 1: return fmt::format("origin along {}", axes[across_[1]]);
            case 2: return fmt::format("direction towards {}", axes[across_[0]]);
            case 3: return fmt::format("direction towards {}", axes[across_[1]]);
            default: return "zero";
        }
    }
    /// What the readings say nothing of, in units of what is asked of each unknown.
    void check(const Square& n) const {
        Vector unit;
        unit << options_.most_origin, options_.most_origin, options_.most_turn, options_.most_turn,
            options_.most_origin;
        const Eigen::SelfAdjointEigenSolver<Square> eigen(Square(unit.asDiagonal() * n * unit.asDiagonal()));
        if (!(eigen.eigenvalues()(0) > 1.0)) {
            refuse("the planes do not show the sensor's " + name_of(eigen.eigenvectors().col(0)),
                   fmt::format("1 sigma {:.3g} times what is asked",
                               1.0 / std::sqrt(std::max(1e-30, eigen.eigenvalues()(0)))),
                   "scan planes that lean in x and in z, each at several distances");
        }
    }
    /// In standard deviations, of a group too.
    [[nodiscard]] static double off_of(const Row& r) { return std::abs(r.left_metres) / std::hypot(r.sigma, r.common); }
    [[nodiscard]] double ratio(const Vector& x) const {
        std::vector<double> left;
        for (std::size_t i = 0; i < readings_.size(); ++i) {
            if (used_[i]) {
                left.push_back(off_of(row(x, i)));
            }
        }
        const auto middle = left.begin() + static_cast<std::ptrdiff_t>(left.size() / 2);
        std::ranges::nth_element(left, middle);
        return std::max(1.0, 1.4826 * *middle);
    }
    [[nodiscard]] std::size_t worst_reading(const Vector& x) const {
        const double limit = kFar * ratio(x);
        std::size_t worst = readings_.size();
        double most = limit;
        for (std::size_t i = 0; i < readings_.size(); ++i) {
            const double left = used_[i] ? off_of(row(x, i)) : 0.0;
            if (left > most) {
                most = left;
                worst = i;
            }
        }
        return worst;
    }
    [[nodiscard]] SensorRayFit finish(const Vector& x) const {
        SensorRayFit out;
        out.origin = to_vec(origin(x));
        out.direction = to_vec(direction(x));
        out.zero = x(4);
        double squares = 0.0;
        for (std::size_t i = 0; i < readings_.size(); ++i) {
            const Row r = row(x, i);
            if (!used_[i]) {
                out.wrong.push_back(readings_[i].line);
                continue;
            }
            ++out.readings;
            squares += r.left_metres * r.left_metres;
        }
        const double freedom = std::max(1.0, static_cast<double>(out.readings) - 5.0);
        out.rms = std::sqrt(squares / static_cast<double>(out.readings));
        out.sigma = std::sqrt(squares / freedom);
        const System s = system(x);
        const Square covariance = std::max(1.0, s.chi_squared / freedom) * s.normal.inverse();
        for (std::size_t i = 0; i < 5; ++i) {
            for (std::size_t j = 0; j < 5; ++j) {
                out.covariance.at[i][j] =
                    0.5 * (covariance(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j)) +
                           covariance(static_cast<Eigen::Index>(j), static_cast<Eigen::Index>(i)));
            }
        }
        return out;
    }

    std::filesystem::path file_;
    SensorRayOptions options_;
    double anchor_;
    Eigen::Index main_ = 1;
    double sign_ = -1.0;
    std::array<int, 2> across_{0, 2};
    std::vector<bool> used_;
    const std::vector<RangeReading>& readings_;
    std::vector<KnownPlane> plane_;
};

}  // namespace

SensorRayFit fit_sensor_ray(const std::filesystem::path& file, const std::vector<KnownPlane>& planes,
                            const std::vector<RangeReading>& readings, double anchor, const SensorRayOptions& options) {
    return Fit(file, planes, readings, anchor, options).run();
}

KnownPlane fit_known_plane(int id, const std::vector<Vec3>& points, double sigma, const Vec3& towards) {
    if (points.size() < 4) {
        throw std::domain_error("a plane needs four points or more");
    }
    const auto n = static_cast<double>(points.size());
    Eigen::Vector3d middle = Eigen::Vector3d::Zero();
    for (const Vec3& p : points) {
        middle += to_eigen(p) / n;
    }
    Eigen::Matrix3d spread = Eigen::Matrix3d::Zero();
    for (const Vec3& p : points) {
        spread += (to_eigen(p) - middle) * (to_eigen(p) - middle).transpose();
    }
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(spread);
    if (!(eigen.eigenvalues()(1) > 1e-4 * eigen.eigenvalues()(2))) {
        throw std::domain_error("the points of a plane lie on a line");
    }
    Eigen::Vector3d normal = eigen.eigenvectors().col(0);
    normal *= normal.dot(to_eigen(towards)) < 0.0 ? -1.0 : 1.0;
    // Twice that of its middle: what its tilt adds at its edges, about.
    return {id, to_vec(normal), normal.dot(middle), 2.0 * sigma / std::sqrt(n)};
}

}  // namespace sc::host

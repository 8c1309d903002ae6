// SPDX-License-Identifier: Apache-2.0
#include "host/calibration/galvo_fit.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include <Eigen/Dense>
#include <fmt/format.h>

#include "host/calibration/galvo_residual.hpp"

namespace sc::host {
namespace {

constexpr std::size_t kFewestCrosses = 60;
constexpr double kLeastDepth = 0.5e-3;
constexpr double kMostFieldSigma = 10e-6;
constexpr double kMostNoise = 20e-6;
constexpr double kMostNoiseRatio = 5.0;
/// Width of the Cauchy weight, in standard deviations.
constexpr double kCauchy = 3.0;
constexpr double kNotBelieved = 6.0;
/// Beyond so many times its prior a parameter is none of a head.
constexpr double kFarthest = 6.0;
constexpr int kRounds = 12;
constexpr int kSteps = 30;
constexpr const auto& kPrior = kGalvoSpread;
constexpr auto kN = static_cast<Eigen::Index>(GalvoModel::kParameters);
using Vector = Eigen::Matrix<double, kN, 1>;
using Square = Eigen::Matrix<double, kN, kN>;

double median(std::vector<double> values) {
    const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
    std::nth_element(values.begin(), middle, values.end());
    return *middle;
}

/// The fit of one set of crosses; parameters are scaled by their priors.
class Fit {
public:
    Fit(const std::vector<CrossObservation>& crosses, const GalvoFitOptions& options)
        : crosses_(crosses), options_(options) {
        nominal_.angle_scale = options.angle_scale;
        nominal_.value[GalvoModel::kF1] = options.angle_scale;
        nominal_.value[GalvoModel::kExitX] = nominal_.value[GalvoModel::kExitZ] = 1.0 / options.angle_scale;
        weight_.assign(crosses.size(), 1.0);
    }

    GalvoFit run() {
        Vector x = Vector::Zero();
        for (int round = 0; round < kRounds; ++round) {
            x = minimise(x);
            reweigh(residuals(model_of(x)));
        }
        GalvoFit fit;
        fit.model = model_of(x);
        fit.ray_rms = rms(residuals(fit.model));
        if (options_.residual_grid) {
            fit.grid_freedom = fit_residual_grid(fit.model, samples(residuals(fit.model)), options_.residual_half,
                                                 options_.residual_side);
            reweigh(residuals(fit.model));
        }
        const auto left = residuals(fit.model);
        fit.rms = rms(left);
        fit.sigma = noise_;
        for (std::size_t i = 0; i < crosses_.size(); ++i) {
            if (std::hypot(left[i][0], left[i][1]) > kNotBelieved * scale(i)) {
                fit.outliers.push_back(crosses_[i].number);
            }
        }
        const Square inverse = normal(x).inverse();
        for (Eigen::Index i = 0; i < kN; ++i) {
            for (Eigen::Index j = 0; j < kN; ++j) {
                fit.covariance.at[static_cast<std::size_t>(i)][static_cast<std::size_t>(j)] =
                    inverse(i, j) * kPrior[static_cast<std::size_t>(i)] * kPrior[static_cast<std::size_t>(j)];
            }
        }
        fit.field_sigma = field_sigma(x, inverse);
        return fit;
    }

private:
    [[nodiscard]] GalvoModel model_of(const Vector& x) const {
        GalvoModel model = nominal_;
        for (std::size_t i = 0; i < GalvoModel::kParameters; ++i) {
            model.value[i] += x(static_cast<Eigen::Index>(i)) * kPrior[i];
        }
        return model;
    }

    [[nodiscard]] std::vector<FieldPlace> residuals(const GalvoModel& model) const {
        std::vector<FieldPlace> out;
        out.reserve(crosses_.size());
        for (const CrossObservation& cross : crosses_) {
            const FieldPlace landed = model.land(cross.command, cross.depth);
            out.push_back({cross.landed[0] - landed[0], cross.landed[1] - landed[1]});
        }
        return out;
    }

    /// Of a coordinate of a cross: what it states, or what all of them show if that is more.
    [[nodiscard]] double scale(std::size_t i) const { return std::max(crosses_[i].sigma, noise_); }

    void reweigh(const std::vector<FieldPlace>& left) {
        std::vector<double> sizes;
        for (const FieldPlace& r : left) {
            sizes.push_back(std::abs(r[0]));
            sizes.push_back(std::abs(r[1]));
        }
        noise_ = 1.4826 * median(std::move(sizes));
        for (std::size_t i = 0; i < left.size(); ++i) {
            const double distance = std::hypot(left[i][0], left[i][1]) / (kCauchy * scale(i));
            weight_[i] = 1.0 / (1.0 + distance * distance);
        }
    }

    [[nodiscard]] std::vector<ResidualSample> samples(const std::vector<FieldPlace>& left) const {
        std::vector<ResidualSample> out;
        for (std::size_t i = 0; i < crosses_.size(); ++i) {
            out.push_back({crosses_[i].command, left[i], weight_[i]});
        }
        return out;
    }

    [[nodiscard]] double rms(const std::vector<FieldPlace>& left) const {
        double sum = 0.0;
        double weights = 0.0;
        for (std::size_t i = 0; i < left.size(); ++i) {
            sum += weight_[i] * (left[i][0] * left[i][0] + left[i][1] * left[i][1]);
            weights += 2.0 * weight_[i];
        }
        return std::sqrt(sum / weights);
    }

    [[nodiscard]] double cost(const Vector& x) const {
        const auto left = residuals(model_of(x));
        double sum = x.squaredNorm();
        for (std::size_t i = 0; i < left.size(); ++i) {
            const double s = scale(i);
            sum += weight_[i] * (left[i][0] * left[i][0] + left[i][1] * left[i][1]) / (s * s);
        }
        return sum;
    }

    /// Derivative of a landing place by the scaled parameters.
    [[nodiscard]] Eigen::Matrix<double, 2, kN> slope(const Vector& x, const FieldPlace& command, double depth) const {
        constexpr double kStep = 1e-5;
        Eigen::Matrix<double, 2, kN> out;
        for (Eigen::Index k = 0; k < kN; ++k) {
            Vector more = x;
            Vector less = x;
            more(k) += kStep;
            less(k) -= kStep;
            const FieldPlace a = model_of(more).land(command, depth);
            const FieldPlace b = model_of(less).land(command, depth);
            out(0, k) = (a[0] - b[0]) / (2.0 * kStep);
            out(1, k) = (a[1] - b[1]) / (2.0 * kStep);
        }
        return out;
    }

    [[nodiscard]] Square normal(const Vector& x, Vector* gradient = nullptr) const {
        Square out = Square::Identity();
        if (gradient != nullptr) {
            *gradient = -x;
        }
        const auto left = residuals(model_of(x));
        for (std::size_t i = 0; i < crosses_.size(); ++i) {
            const auto j = slope(x, crosses_[i].command, crosses_[i].depth);
            const double w = weight_[i] / (scale(i) * scale(i));
            out += w * j.transpose() * j;
            if (gradient != nullptr) {
                *gradient += w * j.transpose() * Eigen::Vector2d(left[i][0], left[i][1]);
            }
        }
        return out;
    }

    [[nodiscard]] Vector minimise(Vector x) const {
        double damping = 1e-6;
        double now = cost(x);
        for (int i = 0; i < kSteps; ++i) {
            Vector gradient;
            const Square n = normal(x, &gradient);
            Square damped = n;
            damped.diagonal() += damping * n.diagonal();
            const Vector step = damped.ldlt().solve(gradient);
            const double next = cost(x + step);
            if (next < now) {
                x += step;
                damping = std::max(1e-12, damping * 0.1);
                const bool settled = now - next < 1e-9 * now;
                now = next;
                if (settled) {
                    break;
                }
            } else if (damping > 1e6) {
                break;
            } else {
                damping *= 10.0;
            }
        }
        return x;
    }

    [[nodiscard]] double field_sigma(const Vector& x, const Square& inverse) const {
        double worst = 0.0;
        for (int i = -4; i <= 4; ++i) {
            for (int j = -4; j <= 4; ++j) {
                for (const double depth : {-1e-3, 0.0, 1e-3}) {
                    const auto s = slope(x, {i * 0.0138, j * 0.0138}, depth);
                    const Eigen::Matrix2d c = s * inverse * s.transpose();
                    worst = std::max({worst, c(0, 0), c(1, 1)});
                }
            }
        }
        return std::sqrt(worst);
    }

    const std::vector<CrossObservation>& crosses_;
    const GalvoFitOptions& options_;
    GalvoModel nominal_;
    std::vector<double> weight_;
    double noise_ = 0.0;
};

void check(const std::vector<CrossObservation>& crosses, const GalvoFitOptions& options) {
    if (crosses.size() < kFewestCrosses) {
        throw std::domain_error(fmt::format("{} crosses are too few: measure {} or more, on a grid over the field",
                                            crosses.size(), kFewestCrosses));
    }
    const auto span = [&](auto value) {
        const auto [low, high] = std::minmax_element(crosses.begin(), crosses.end(),
                                                     [&](const auto& a, const auto& b) { return value(a) < value(b); });
        return value(*high) - value(*low);
    };
    const double wanted = options.residual_half;
    for (const std::size_t axis : {0U, 1U}) {
        if (const double width = span([axis](const CrossObservation& c) { return c.command[axis]; }); width < wanted) {
            throw std::domain_error(
                fmt::format("the crosses span {:.3f} mm of the field in {}: spread them over {:.0f} mm or more",
                            width * 1e3, axis == 0 ? "x" : "z", wanted * 1e3));
        }
    }
    if (const double deep = span([](const CrossObservation& c) { return c.depth; }); deep < kLeastDepth) {
        throw std::domain_error(fmt::format(
            "the crosses span {:.3f} mm of depth: burn them at depths {:.1f} mm apart or more, or how the beam leans "
            "cannot be told",
            deep * 1e3, kLeastDepth * 1e3));
    }
}

}  // namespace

GalvoFit fit_galvo(const std::vector<CrossObservation>& crosses, const GalvoFitOptions& options) {
    check(crosses, options);
    GalvoFit fit = Fit(crosses, options).run();
    double stated = 0.0;
    for (const CrossObservation& cross : crosses) {
        stated = std::max(stated, cross.sigma);
    }
    if (fit.sigma > kMostNoise && fit.sigma > kMostNoiseRatio * stated) {
        throw std::domain_error(
            fmt::format("the crosses lie {:.1f} um (1 sigma) from the best model, and are stated to be within {:.1f} "
                        "um: check that "
                        "numbers, signs and units of the measured places belong to the plan",
                        fit.sigma * 1e6, stated * 1e6));
    }
    GalvoModel nominal;
    nominal.angle_scale = nominal.value[GalvoModel::kF1] = options.angle_scale;
    nominal.value[GalvoModel::kExitX] = nominal.value[GalvoModel::kExitZ] = 1.0 / options.angle_scale;
    for (std::size_t i = 0; i < GalvoModel::kParameters; ++i) {
        if (!(std::abs(fit.model.value[i] - nominal.value[i]) < kFarthest * kPrior[i])) {
            throw std::domain_error(
                "the crosses ask for a head that is far from any: check that numbers, signs and units of the measured "
                "places belong to the plan");
        }
    }
    if (fit.field_sigma > kMostFieldSigma) {
        throw std::domain_error(
            fmt::format("the model is known to {:.1f} um only in the field: measure more crosses, "
                        "nearer to its edges, or better",
                        fit.field_sigma * 1e6));
    }
    return fit;
}

GalvoRecord linear_record(const GalvoFit& fit) {
    constexpr double kStep = 1e-5;  // m
    // Offset and matrix (row-major) as functions of the ray model.
    const auto linear = [](const GalvoModel& model) {
        const FieldPlace at = model.land({0.0, 0.0}, 0.0);
        const FieldPlace x1 = model.land({kStep, 0.0}, 0.0);
        const FieldPlace x0 = model.land({-kStep, 0.0}, 0.0);
        const FieldPlace z1 = model.land({0.0, kStep}, 0.0);
        const FieldPlace z0 = model.land({0.0, -kStep}, 0.0);
        return std::array<double, 6>{at[0],
                                     at[1],
                                     (x1[0] - x0[0]) / (2.0 * kStep),
                                     (z1[0] - z0[0]) / (2.0 * kStep),
                                     (x1[1] - x0[1]) / (2.0 * kStep),
                                     (z1[1] - z0[1]) / (2.0 * kStep)};
    };
    GalvoRecord record;
    const auto centre = linear(fit.model);
    record.offset = {centre[0], centre[1]};
    record.matrix = {centre[2], centre[3], centre[4], centre[5]};
    Eigen::Matrix<double, 6, kN> slope;
    Square covariance;
    for (Eigen::Index k = 0; k < kN; ++k) {
        const auto p = static_cast<std::size_t>(k);
        GalvoModel more = fit.model;
        GalvoModel less = fit.model;
        more.value[p] += 1e-4 * kPrior[p];
        less.value[p] -= 1e-4 * kPrior[p];
        const auto a = linear(more);
        const auto b = linear(less);
        for (Eigen::Index i = 0; i < 6; ++i) {
            const auto q = static_cast<std::size_t>(i);
            slope(i, k) = (a[q] - b[q]) / (2e-4 * kPrior[p]);
        }
        for (Eigen::Index i = 0; i < kN; ++i) {
            covariance(k, i) = fit.covariance.at[p][static_cast<std::size_t>(i)];
        }
    }
    Eigen::Matrix<double, 6, 6> of_record = slope * covariance * slope.transpose();
    of_record = 0.5 * (of_record + of_record.transpose()).eval();
    for (Eigen::Index i = 0; i < 6; ++i) {
        for (Eigen::Index j = 0; j < 6; ++j) {
            record.covariance.at[static_cast<std::size_t>(i)][static_cast<std::size_t>(j)] = of_record(i, j);
        }
    }
    return record;
}

}  // namespace sc::host

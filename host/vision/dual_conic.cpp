// SPDX-License-Identifier: Apache-2.0
#include "host/vision/dual_conic.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <utility>
#include <vector>

#include <opencv2/imgproc.hpp>

namespace sc::host {
namespace {

using Vector5 = cv::Vec<double, 5>;
using Matrix5 = cv::Matx<double, 5, 5>;

constexpr int kRounds = 14;
constexpr int kWideRounds = 2;
constexpr double kReachPx = 6.0;    ///< of gradients from the edge, for a smoothing of 1 px
constexpr double kWideShare = 0.2;  ///< of the minor semi-axis, in the first rounds
constexpr double kMostReachShare = 0.8;
constexpr double kLeastStrength = 0.3;  ///< of a sector's edge, of the median's
constexpr double kLeastOutlierPx = 0.5;
constexpr double kOutlier = 2.0;
constexpr double kMadToSigma = 1.4826;
constexpr double kSectorPx = 4.0;
constexpr double kSlopeRing = 12.0;  ///< px outside the edge in which the light's slope is looked for
constexpr std::size_t kLeastSlopePixels = 100;
constexpr double kLeastLight = 0.02;
constexpr double kTiny = 1e-12;

/// Lines of a window round an ellipse, in coordinates about its centre in units of `scale`.
struct Frame {
    double x = 0.0;
    double y = 0.0;
    double scale = 1.0;
};

Vector5 row_of(double u, double v, double w) { return {u * u, u * v, v * v, u * w, v * w}; }

/// Contribution of a pixel to the normal equations at their solution: weight · row · residual.
Vector5 pull_of(double gx, double gy, const cv::Vec2d& at, const Vector5& solution, double power) {
    const double size = std::max(std::hypot(gx, gy), kTiny);
    const double u = gx / size;
    const double v = gy / size;
    const double w = -(u * at[0] + v * at[1]);
    const Vector5 row = row_of(u, v, w);
    return std::pow(size, power) * (row.dot(solution) - w * w) * row;
}

double median_of(std::vector<double> values) {
    const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
    std::nth_element(values.begin(), middle, values.end());
    return *middle;
}

class Fit {
public:
    Fit(const Gradients& gradients, const cv::Mat& light, const Ellipse& start, const MarkerSettings& settings)
        : gradients_(gradients), light_(light), ellipse_(start), settings_(settings) {
        const double outline = std::numbers::pi * (start.major + start.minor);
        sectors_.resize(static_cast<std::size_t>(std::clamp(static_cast<int>(outline / kSectorPx), 8, 36)));
    }

    bool run() {
        for (int round = 0; round < kRounds; ++round) {
            reach_ = round < kWideRounds ? std::max(kReachPx, kWideShare * ellipse_.minor) : kReachPx;
            reach_ = std::min(reach_, kMostReachShare * ellipse_.minor);
            if (round == kWideRounds) {
                find_slope();
            }
            if (!solve()) {
                return false;
            }
            judge_sectors();
        }
        return true;
    }

    [[nodiscard]] const Ellipse& ellipse() const { return ellipse_; }
    [[nodiscard]] const std::vector<EdgeSector>& sectors() const { return sectors_; }

    /// How the centre moves with each pixel's light, squared and summed: exact to first order, whatever the weights.
    [[nodiscard]] std::array<double, 3> covariance() const {
        const cv::Rect box = window();
        cv::Mat move[2][2];
        for (auto& pair : move) {
            for (cv::Mat& field : pair) {
                field = cv::Mat::zeros(box.size(), CV_64F);
            }
        }
        each_pixel([&](int column, int row, double weight, const cv::Vec2d& at) {
            const auto [gx, gy] = gradient(column, row);
            const double step = 1e-4 * std::max(std::hypot(gx, gy), 1e-6);
            const Vector5 by_x = (pull_of(gx + step, gy, at, solution_, settings_.weight_power) -
                                  pull_of(gx - step, gy, at, solution_, settings_.weight_power)) *
                                 (0.5 * weight / step);
            const Vector5 by_y = (pull_of(gx, gy + step, at, solution_, settings_.weight_power) -
                                  pull_of(gx, gy - step, at, solution_, settings_.weight_power)) *
                                 (0.5 * weight / step);
            const Vector5 solved_x = inverse_ * by_x;
            const Vector5 solved_y = inverse_ * by_y;
            for (int axis = 0; axis < 2; ++axis) {
                move[axis][0].at<double>(row - box.y, column - box.x) = 0.5 * frame_.scale * solved_x[3 + axis];
                move[axis][1].at<double>(row - box.y, column - box.x) = 0.5 * frame_.scale * solved_y[3 + axis];
            }
        });
        cv::Mat along;
        cv::Mat across;
        gradients_.along.convertTo(along, CV_64F);
        gradients_.across.convertTo(across, CV_64F);
        cv::Mat by_light[2];
        const int border = along.cols;
        for (int axis = 0; axis < 2; ++axis) {
            cv::Mat wide[2];
            for (int k = 0; k < 2; ++k) {
                cv::copyMakeBorder(move[axis][k], wide[k], border, border, border, border, cv::BORDER_CONSTANT);
            }
            cv::Mat x;
            cv::Mat y;
            cv::sepFilter2D(wide[0], x, CV_64F, across, along, cv::Point(-1, -1), 0.0, cv::BORDER_CONSTANT);
            cv::sepFilter2D(wide[1], y, CV_64F, along, across, cv::Point(-1, -1), 0.0, cv::BORDER_CONSTANT);
            by_light[axis] = x + y;
        }
        const cv::Matx22d in_place(by_light[0].dot(by_light[0]), by_light[0].dot(by_light[1]),
                                   by_light[0].dot(by_light[1]), by_light[1].dot(by_light[1]));
        const cv::Matx22d onwards = (cv::Matx22d::eye() - drawn_along()).inv();
        const cv::Matx22d all = onwards * in_place * onwards.t();
        return {all(0, 0), all(0, 1), all(1, 1)};
    }

private:
    /// The window is about the ellipse, and draws it along: how far the centre moves for a move of the window.
    [[nodiscard]] cv::Matx22d drawn_along() const {
        constexpr double kAsidePx = 0.05;
        cv::Matx22d out = cv::Matx22d::zeros();
        for (int axis = 0; axis < 2; ++axis) {
            for (const double sign : {1.0, -1.0}) {
                Fit aside = *this;
                (axis == 0 ? aside.ellipse_.x : aside.ellipse_.y) += sign * kAsidePx;
                if (aside.solve()) {
                    out(0, axis) += sign * (aside.ellipse_.x - ellipse_.x) / (2.0 * kAsidePx);
                    out(1, axis) += sign * (aside.ellipse_.y - ellipse_.y) / (2.0 * kAsidePx);
                }
            }
        }
        return out;
    }

    [[nodiscard]] cv::Rect window() const {
        const EllipseShape shape = shape_of(ellipse_);
        const double half_x = std::sqrt(shape[0]) + 1.5 * reach_;
        const double half_y = std::sqrt(shape[2]) + 1.5 * reach_;
        const cv::Point low(static_cast<int>(std::floor(ellipse_.x - half_x)),
                            static_cast<int>(std::floor(ellipse_.y - half_y)));
        const cv::Point high(static_cast<int>(std::ceil(ellipse_.x + half_x)) + 1,
                             static_cast<int>(std::ceil(ellipse_.y + half_y)) + 1);
        return cv::Rect(low, high) & cv::Rect(0, 0, gradients_.x.cols, gradients_.x.rows);
    }

    [[nodiscard]] std::size_t sector_of(double dx, double dy) const {
        const double c = std::cos(ellipse_.angle);
        const double s = std::sin(ellipse_.angle);
        const double turn = std::atan2((dy * c - dx * s) / ellipse_.minor, (dx * c + dy * s) / ellipse_.major);
        const double share = turn / (2.0 * std::numbers::pi) + 0.5;
        return std::min(static_cast<std::size_t>(share * static_cast<double>(sectors_.size())), sectors_.size() - 1);
    }

    /// Calls `each(column, row, weight, place)` for the pixels about the edge. Weights fall to nothing smoothly towards
    /// both sides, so that no pixel comes or goes at once.
    template <class Each>
    void each_pixel(const Each& each) const {
        const cv::Rect box = window();
        const EllipseShape shape = shape_of(ellipse_);
        for (int row = box.y; row < box.y + box.height; ++row) {
            for (int column = box.x; column < box.x + box.width; ++column) {
                const double dx = column - ellipse_.x;
                const double dy = row - ellipse_.y;
                const double off = distance_from(ellipse_, column, row);
                if (!(std::abs(off) < reach_) || !sectors_[sector_of(dx, dy)].used) {
                    continue;
                }
                const auto [gx, gy] = gradient(column, row);
                const double square = gx * gx + gy * gy;
                if (!(square > kTiny)) {
                    continue;
                }
                const double taper = std::cos(0.5 * std::numbers::pi * off / reach_);
                // A residual of the dual conic is twice the tangent's distance from the centre times its error.
                const double support = (gx * gx * shape[0] + 2.0 * gx * gy * shape[1] + gy * gy * shape[2]) /
                                       (square * frame_.scale * frame_.scale);
                each(column, row, taper * taper / std::max(support, 1e-6),
                     cv::Vec2d((column - frame_.x) / frame_.scale, (row - frame_.y) / frame_.scale));
            }
        }
    }

    [[nodiscard]] std::pair<double, double> gradient(int column, int row) const {
        const auto light = static_cast<double>(light_.at<float>(row, column));
        return {static_cast<double>(gradients_.x.at<float>(row, column)) - slope_[0] * light,
                static_cast<double>(gradients_.y.at<float>(row, column)) - slope_[1] * light};
    }

    /// How the light rises over the picture, which is none of the edge: the medians of the gradients away from it,
    /// inside and outside. Left in, it draws the centre towards the brighter side.
    void find_slope() {
        const EllipseShape shape = shape_of(ellipse_);
        const double half_x = std::sqrt(shape[0]) + kSlopeRing;
        const double half_y = std::sqrt(shape[2]) + kSlopeRing;
        const cv::Rect box = cv::Rect(cv::Point(static_cast<int>(std::floor(ellipse_.x - half_x)),
                                                static_cast<int>(std::floor(ellipse_.y - half_y))),
                                      cv::Point(static_cast<int>(std::ceil(ellipse_.x + half_x)) + 1,
                                                static_cast<int>(std::ceil(ellipse_.y + half_y)) + 1)) &
                             cv::Rect(0, 0, gradients_.x.cols, gradients_.x.rows);
        std::vector<double> x;
        std::vector<double> y;
        for (int row = box.y; row < box.y + box.height; ++row) {
            for (int column = box.x; column < box.x + box.width; ++column) {
                const double off = distance_from(ellipse_, column, row);
                if (std::abs(off) > kReachPx && off < kSlopeRing) {
                    const double light = std::max(static_cast<double>(light_.at<float>(row, column)), kLeastLight);
                    x.push_back(static_cast<double>(gradients_.x.at<float>(row, column)) / light);
                    y.push_back(static_cast<double>(gradients_.y.at<float>(row, column)) / light);
                }
            }
        }
        if (x.size() >= kLeastSlopePixels) {
            slope_ = {median_of(std::move(x)), median_of(std::move(y))};
        }
    }

    bool solve() {
        frame_ = {ellipse_.x, ellipse_.y, std::sqrt(ellipse_.major * ellipse_.minor)};
        Matrix5 normal = Matrix5::zeros();
        Vector5 right = Vector5::all(0.0);
        each_pixel([&](int column, int row, double weight, const cv::Vec2d& at) {
            const auto [gx, gy] = gradient(column, row);
            const double size = std::hypot(gx, gy);
            const double w = -(gx * at[0] + gy * at[1]) / size;
            const Vector5 line = row_of(gx / size, gy / size, w);
            const double all = weight * std::pow(size, settings_.weight_power);
            normal += all * line * line.t();
            right += all * w * w * line;
        });
        bool regular = false;
        inverse_ = normal.inv(cv::DECOMP_CHOLESKY, &regular);
        if (!regular) {
            return false;
        }
        solution_ = inverse_ * right;
        const double x = -0.5 * solution_[3];
        const double y = -0.5 * solution_[4];
        const double square = frame_.scale * frame_.scale;
        const auto next = ellipse_of(
            frame_.x + frame_.scale * x, frame_.y + frame_.scale * y,
            {square * (solution_[0] + x * x), square * (0.5 * solution_[1] + x * y), square * (solution_[2] + y * y)});
        if (!next || std::hypot(next->x - ellipse_.x, next->y - ellipse_.y) > ellipse_.major || next->minor < 1.0 ||
            next->major > 2.0 * ellipse_.major) {
            return false;
        }
        ellipse_ = *next;
        return true;
    }

    /// Where the edge is in each sector: mean of the pixels' distances, weighted by the square of the step across.
    void judge_sectors() {
        std::vector<double> sum(sectors_.size(), 0.0);
        std::vector<double> weight(sectors_.size(), 0.0);
        std::vector<double> most(sectors_.size(), 0.0);
        const double wide =
            std::min(std::max(kSectorPx, kWideShare * ellipse_.minor), kMostReachShare * ellipse_.minor);
        const EllipseShape shape = shape_of(ellipse_);
        const double determinant = shape[0] * shape[2] - shape[1] * shape[1];
        const cv::Rect box = window();
        double polarity = 0.0;
        for (const bool second : {false, true}) {
            for (int row = box.y; row < box.y + box.height; ++row) {
                for (int column = box.x; column < box.x + box.width; ++column) {
                    const double dx = column - ellipse_.x;
                    const double dy = row - ellipse_.y;
                    const double off = distance_from(ellipse_, column, row);
                    if (!(std::abs(off) < wide)) {
                        continue;
                    }
                    const double nx = (shape[2] * dx - shape[1] * dy) / determinant;
                    const double ny = (shape[0] * dy - shape[1] * dx) / determinant;
                    const auto [gx, gy] = gradient(column, row);
                    const double out = (nx * gx + ny * gy) / std::max(std::hypot(nx, ny), kTiny);
                    if (!second) {
                        polarity += out;
                    } else if (out * polarity > 0.0) {
                        const std::size_t k = sector_of(dx, dy);
                        sum[k] += out * out * off;
                        weight[k] += out * out;
                        most[k] = std::max(most[k], std::abs(out));
                    }
                }
            }
        }
        const double strength = median_of(most);
        std::vector<double> distances;
        for (std::size_t k = 0; k < sectors_.size(); ++k) {
            sectors_[k].strength = most[k];
            sectors_[k].distance = weight[k] > 0.0 ? sum[k] / weight[k] : wide;
            distances.push_back(std::abs(sectors_[k].distance));
        }
        const double limit = std::max(kOutlier * kMadToSigma * median_of(distances), kLeastOutlierPx);
        for (EdgeSector& sector : sectors_) {
            sector.used = sector.strength > kLeastStrength * strength && std::abs(sector.distance) < limit;
        }
    }

    const Gradients& gradients_;
    const cv::Mat& light_;  ///< smoothed as the gradients are
    Ellipse ellipse_;
    const MarkerSettings& settings_;
    std::vector<EdgeSector> sectors_;
    double reach_ = kReachPx;
    std::array<double, 2> slope_{};  ///< of the light a pixel, over the light: what is dark reflects less of it
    Frame frame_;
    Vector5 solution_;
    Matrix5 inverse_;
};

/// Mean light outside less that inside, next to the edge.
double step_of(const cv::Mat& light, const Ellipse& ellipse) {
    double sum[2] = {0.0, 0.0};
    int count[2] = {0, 0};
    const int reach = static_cast<int>(std::ceil(ellipse.major)) + 5;
    const int column0 = static_cast<int>(std::lround(ellipse.x));
    const int row0 = static_cast<int>(std::lround(ellipse.y));
    for (int row = std::max(0, row0 - reach); row <= std::min(light.rows - 1, row0 + reach); ++row) {
        for (int column = std::max(0, column0 - reach); column <= std::min(light.cols - 1, column0 + reach); ++column) {
            const double off = distance_from(ellipse, column, row);
            if (std::abs(off) >= 2.0 && std::abs(off) < 4.0) {
                const int side = off > 0.0 ? 1 : 0;
                sum[side] += static_cast<double>(light.at<float>(row, column));
                ++count[side];
            }
        }
    }
    return count[0] > 0 && count[1] > 0 ? sum[1] / count[1] - sum[0] / count[0] : 0.0;
}

}  // namespace

EllipseShape shape_of(const Ellipse& ellipse) {
    const double c = std::cos(ellipse.angle);
    const double s = std::sin(ellipse.angle);
    const double a = ellipse.major * ellipse.major;
    const double b = ellipse.minor * ellipse.minor;
    return {a * c * c + b * s * s, (a - b) * c * s, a * s * s + b * c * c};
}

std::optional<Ellipse> ellipse_of(double x, double y, const EllipseShape& shape) {
    const double middle = 0.5 * (shape[0] + shape[2]);
    const double half = std::hypot(0.5 * (shape[0] - shape[2]), shape[1]);
    if (!(middle - half > 0.0) || !std::isfinite(middle + half + x + y)) {
        return std::nullopt;
    }
    return Ellipse{.x = x,
                   .y = y,
                   .major = std::sqrt(middle + half),
                   .minor = std::sqrt(middle - half),
                   .angle = 0.5 * std::atan2(2.0 * shape[1], shape[0] - shape[2])};
}

double distance_from(const Ellipse& ellipse, double x, double y) {
    const double c = std::cos(ellipse.angle);
    const double s = std::sin(ellipse.angle);
    const double u = ((x - ellipse.x) * c + (y - ellipse.y) * s) / ellipse.major;
    const double v = ((y - ellipse.y) * c - (x - ellipse.x) * s) / ellipse.minor;
    const double radius = std::hypot(u, v);
    const double slope = std::hypot(u / ellipse.major, v / ellipse.minor);
    return slope > kTiny ? (radius - 1.0) * radius / slope : -ellipse.minor;
}

Gradients gradients_of(const cv::Mat& light, double smoothing_px) {
    Gradients out;
    if (smoothing_px > 0.0) {
        const int reach = static_cast<int>(std::ceil(4.0 * smoothing_px));
        out.along = cv::Mat(1, 2 * reach + 1, CV_32F);
        out.across = cv::Mat(1, 2 * reach + 1, CV_32F);
        double sum = 0.0;
        double moment = 0.0;
        for (int k = -reach; k <= reach; ++k) {
            const double value = std::exp(-0.5 * k * k / (smoothing_px * smoothing_px));
            sum += value;
            moment += k * k * value;
        }
        for (int k = -reach; k <= reach; ++k) {
            const double value = std::exp(-0.5 * k * k / (smoothing_px * smoothing_px));
            out.along.at<float>(0, k + reach) = static_cast<float>(value / sum);
            out.across.at<float>(0, k + reach) = static_cast<float>(k * value / moment);
        }
    } else {
        out.along = (cv::Mat_<float>(1, 3) << 0.0F, 1.0F, 0.0F);
        out.across = (cv::Mat_<float>(1, 3) << -0.5F, 0.0F, 0.5F);
    }
    cv::sepFilter2D(light, out.x, CV_32F, out.across, out.along, cv::Point(-1, -1), 0.0, cv::BORDER_REPLICATE);
    cv::sepFilter2D(light, out.y, CV_32F, out.along, out.across, cv::Point(-1, -1), 0.0, cv::BORDER_REPLICATE);
    return out;
}

std::optional<DualConicFit> fit_dual_conic(const Gradients& gradients, const cv::Mat& light, const Ellipse& start,
                                           const MarkerSettings& settings) {
    cv::Mat smooth;
    cv::sepFilter2D(light, smooth, CV_32F, gradients.along, gradients.along, cv::Point(-1, -1), 0.0,
                    cv::BORDER_REPLICATE);
    Fit fit(gradients, smooth, start, settings);
    if (!fit.run()) {
        return std::nullopt;
    }
    return DualConicFit{.ellipse = fit.ellipse(),
                        .covariance = fit.covariance(),
                        .sectors = fit.sectors(),
                        .step = step_of(light, fit.ellipse())};
}

}  // namespace sc::host

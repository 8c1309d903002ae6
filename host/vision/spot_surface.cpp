// SPDX-License-Identifier: Apache-2.0
#include "host/vision/spot_surface.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include <opencv2/imgproc.hpp>

namespace sc::host {

namespace {

constexpr int kParameters = 9;
constexpr int kRounds = 40;
constexpr double kReach = 3.0;           ///< radii of the half height
constexpr double kPerRadius = 20.0;      ///< places a radius that are looked at; more tell nothing new once smoothed
constexpr double kSmoothing = 0.1;       ///< radii: so that no pixel's noise is left out, nor bends the robust weights
constexpr double kSaturatedShare = 0.1;  ///< of the pixels that a smoothed value is made of: from here on it is unsure
constexpr double kSpeckle = 0.2;
constexpr double kFloor = 0.03;  ///< of the height: noise, and what no model has; fixed, so that noise moves no weight
constexpr double kHuber = 2.5;
constexpr double kSettled = 1e-4;  ///< px
constexpr double kBright = 0.2;    ///< of the height: where the misfit is taken

using Vector = cv::Matx<double, kParameters, 1>;
using Matrix = cv::Matx<double, kParameters, kParameters>;

/// x, y, ln height, a, b, c of the exponent a·dx² + 2b·dx·dy + c·dy², and background, its slopes.
struct Surface {
    Vector p;
    [[nodiscard]] double spot(double dx, double dy) const {
        const double q = p(3) * dx * dx + 2.0 * p(4) * dx * dy + p(5) * dy * dy;
        return q < 40.0 && q > -2.0 ? std::exp(p(2) - q) : 0.0;
    }
};

struct Sums {
    Matrix normal = Matrix::zeros();
    Vector right = Vector::zeros();
    double misfit = 0.0;
    double bright = 0.0;
};

struct Window {
    Circle circle;
    double reach = 0.0;
    int step = 1;
    double height = 0.0;
    double floor = 0.0;
};

Sums sums_of(const cv::Mat& light, const cv::Mat& saturated, const Window& window, const Surface& s) {
    Sums out;
    const int x0 = static_cast<int>(std::lround(window.circle.x));
    const int y0 = static_cast<int>(std::lround(window.circle.y));
    const int reach = static_cast<int>(window.reach);
    for (int dy0 = -reach; dy0 <= reach; dy0 += window.step) {
        for (int dx0 = -reach; dx0 <= reach; dx0 += window.step) {
            const int column = x0 + dx0;
            const int row = y0 + dy0;
            if (column < 0 || row < 0 || column >= light.cols || row >= light.rows ||
                dx0 * dx0 + dy0 * dy0 > reach * reach || saturated.at<std::uint8_t>(row, column) != 0) {
                continue;
            }
            const double dx = column - s.p(0);
            const double dy = row - s.p(1);
            const double spot = s.spot(dx, dy);
            const double off =
                static_cast<double>(light.at<float>(row, column)) - spot - s.p(6) - s.p(7) * dx0 - s.p(8) * dy0;
            const double sigma = std::hypot(window.floor, kSpeckle * spot);
            const double far = std::abs(off) / sigma;
            const double weight = (far > kHuber ? kHuber / far : 1.0) / (sigma * sigma);
            const Vector j(2.0 * spot * (s.p(3) * dx + s.p(4) * dy), 2.0 * spot * (s.p(4) * dx + s.p(5) * dy), spot,
                           -spot * dx * dx, -2.0 * spot * dx * dy, -spot * dy * dy, 1.0, dx0, dy0);
            for (int a = 0; a < kParameters; ++a) {
                for (int b = 0; b <= a; ++b) {
                    out.normal(a, b) += weight * j(a) * j(b);
                }
                out.right(a) += weight * j(a) * off;
            }
            if (spot > kBright * window.height) {
                out.misfit += off * off / (spot * spot);
                out.bright += 1.0;
            }
        }
    }
    for (int a = 0; a < kParameters; ++a) {
        for (int b = a + 1; b < kParameters; ++b) {
            out.normal(a, b) = out.normal(b, a);
        }
    }
    return out;
}

/// The share of a Gauss-Newton step that was taken; 0 when the equations are singular.
double step(const Sums& sums, Surface& s, double radius) {
    // In units in which all nine matter alike.
    Vector unit;
    for (int a = 0; a < kParameters; ++a) {
        if (!(sums.normal(a, a) > 0.0)) {
            return 0.0;
        }
        unit(a) = 1.0 / std::sqrt(sums.normal(a, a));
    }
    Matrix scaled;
    Vector right;
    for (int a = 0; a < kParameters; ++a) {
        for (int b = 0; b < kParameters; ++b) {
            scaled(a, b) = sums.normal(a, b) * unit(a) * unit(b) + (a == b ? 1e-9 : 0.0);
        }
        right(a) = sums.right(a) * unit(a);
    }
    Vector x;
    if (!cv::solve(scaled, right, x, cv::DECOMP_CHOLESKY)) {
        return 0.0;
    }
    double longest = 0.0;
    for (int a = 0; a < kParameters; ++a) {
        x(a) *= unit(a);
    }
    longest = std::max(std::abs(x(0)), std::abs(x(1))) / (0.2 * radius);
    longest = std::max({longest, std::abs(x(2)) / 0.5, std::abs(x(3)) * radius * radius / 0.3,
                        std::abs(x(4)) * radius * radius / 0.3, std::abs(x(5)) * radius * radius / 0.3});
    const double share = longest > 1.0 ? 1.0 / longest : 1.0;
    s.p += share * x;
    return share;
}

/// The part of the picture that a fit from `start` looks at, smoothed.
struct Part {
    cv::Point origin;
    cv::Mat light;
    cv::Mat saturated;  ///< CV_8U, not 0 where too many full pixels are in the mean
};

Part smoothed(const cv::Mat& light, const cv::Mat& saturated, const Circle& start) {
    const double sigma = kSmoothing * start.radius;
    const double reach = (kReach + 1.0) * start.radius + 4.0 * sigma;
    const cv::Rect box =
        cv::Rect(static_cast<int>(std::floor(start.x - reach)), static_cast<int>(std::floor(start.y - reach)),
                 static_cast<int>(2.0 * reach) + 2, static_cast<int>(2.0 * reach) + 2) &
        cv::Rect(0, 0, light.cols, light.rows);
    Part out{box.tl(), {}, {}};
    const int border = cv::BORDER_REFLECT | cv::BORDER_ISOLATED;
    cv::GaussianBlur(light(box), out.light, cv::Size(), sigma, sigma, border);
    cv::Mat share;
    saturated(box).convertTo(share, CV_32F);
    cv::GaussianBlur(share, share, cv::Size(), sigma, sigma, border);
    out.saturated = share > kSaturatedShare;
    return out;
}

/// Mean of the light around the window's rim.
double rim_of(const cv::Mat& light, const Window& window) {
    constexpr int kPlaces = 180;
    double sum = 0.0;
    double n = 0.0;
    for (int k = 0; k < kPlaces; ++k) {
        const double t = 2.0 * std::numbers::pi * k / kPlaces;
        const int column = static_cast<int>(std::lround(window.circle.x + window.reach * std::cos(t)));
        const int row = static_cast<int>(std::lround(window.circle.y + window.reach * std::sin(t)));
        if (column >= 0 && row >= 0 && column < light.cols && row < light.rows) {
            sum += static_cast<double>(light.at<float>(row, column));
            n += 1.0;
        }
    }
    return n > 0.0 ? sum / n : 0.0;
}

}  // namespace

std::optional<SurfaceFit> fit_surface(const cv::Mat& picture, const cv::Mat& full, const Circle& in_picture,
                                      double height) {
    const Part part = smoothed(picture, full, in_picture);
    const cv::Mat& light = part.light;
    const cv::Mat& saturated = part.saturated;
    Circle start = in_picture;
    start.x -= part.origin.x;
    start.y -= part.origin.y;
    const double shape = std::numbers::ln2 / (start.radius * start.radius);
    Surface s;
    s.p = Vector(start.x, start.y, std::log(height), shape, 0.0, shape, 0.0, 0.0, 0.0);
    const Window window{.circle = start,
                        .reach = kReach * start.radius,
                        .step = std::max(1, static_cast<int>(start.radius / kPerRadius)),
                        .height = height,
                        .floor = kFloor * height};
    s.p(6) = rim_of(light, window);
    for (int round = 0; round < kRounds; ++round) {
        const double x = s.p(0);
        const double y = s.p(1);
        const double share = step(sums_of(light, saturated, window, s), s, start.radius);
        if (!(share > 0.0)) {
            return std::nullopt;
        }
        if (!(std::hypot(s.p(0) - start.x, s.p(1) - start.y) < 0.5 * start.radius) ||
            !(s.p(3) * s.p(5) - s.p(4) * s.p(4) > 0.0)) {
            return std::nullopt;
        }
        if (std::hypot(s.p(0) - x, s.p(1) - y) < kSettled && share == 1.0) {
            const Sums last = sums_of(light, saturated, window, s);
            if (last.bright < 20.0) {
                return std::nullopt;
            }
            return SurfaceFit{s.p(0) + part.origin.x, s.p(1) + part.origin.y, std::sqrt(last.misfit / last.bright)};
        }
    }
    return std::nullopt;
}

}  // namespace sc::host

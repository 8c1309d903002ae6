// SPDX-License-Identifier: Apache-2.0
#include "host/vision/spot_outline.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <vector>

#include <opencv2/imgproc.hpp>

namespace sc::host {

namespace {

constexpr std::array kHeights{0.3, 0.4, 0.5, 0.6, 0.7};
constexpr std::size_t kHalf = 2;
constexpr int kSpokes = 180;
constexpr double kStepPx = 0.25;
constexpr double kFewestSpokes = 0.8;  ///< share that must meet the outline
constexpr int kRounds = 3;
constexpr double kTopPart = 0.35;  ///< radii: the top is taken within

/// a + b·dx + c·dy.
struct Ground {
    double a = 0.0;
    double b = 0.0;
    double c = 0.0;
    [[nodiscard]] double at(double dx, double dy) const { return a + b * dx + c * dy; }
};

double bilinear(const cv::Mat& m, double x, double y) {
    const int x0 = std::clamp(static_cast<int>(std::floor(x)), 0, m.cols - 2);
    const int y0 = std::clamp(static_cast<int>(std::floor(y)), 0, m.rows - 2);
    const double fx = x - x0;
    const double fy = y - y0;
    const auto at = [&](int dx, int dy) { return static_cast<double>(m.at<float>(y0 + dy, x0 + dx)); };
    return (1.0 - fy) * ((1.0 - fx) * at(0, 0) + fx * at(1, 0)) + fy * ((1.0 - fx) * at(0, 1) + fx * at(1, 1));
}

/// Plane through the ring around the blob: only a slope is taken from a whole ring; where the picture cuts the ring,
/// pairs of opposite pixels alone count, so that the blob's own tail leaves no slope.
std::optional<Ground> ground_of(const cv::Mat& m, const Circle& circle, const OutlineSettings& settings) {
    double n = 0.0;
    double sum = 0.0;
    double sx = 0.0;
    double sy = 0.0;
    double xx = 0.0;
    double yy = 0.0;
    double xy = 0.0;
    const double first = settings.background_from * circle.radius;
    const int rings = static_cast<int>(settings.background_to * circle.radius - first) + 1;
    for (int ring = 0; ring < rings; ++ring) {
        const double r = first + ring;
        const int spokes = std::max(kSpokes, static_cast<int>(std::numbers::pi * r));
        for (int k = 0; k < spokes; ++k) {
            const double t = std::numbers::pi * k / spokes;
            const double dx = r * std::cos(t);
            const double dy = r * std::sin(t);
            const auto inside = [&](double x, double y) {
                return x >= 0.0 && y >= 0.0 && x <= m.cols - 1.0 && y <= m.rows - 1.0;
            };
            if (!inside(circle.x + dx, circle.y + dy) || !inside(circle.x - dx, circle.y - dy)) {
                continue;
            }
            const double plus = bilinear(m, circle.x + dx, circle.y + dy);
            const double minus = bilinear(m, circle.x - dx, circle.y - dy);
            n += 2.0;
            sum += plus + minus;
            sx += dx * (plus - minus);
            sy += dy * (plus - minus);
            xx += 2.0 * dx * dx;
            yy += 2.0 * dy * dy;
            xy += 2.0 * dx * dy;
        }
    }
    const double determinant = xx * yy - xy * xy;
    if (n < 16.0 || !(determinant > 1e-6 * xx * yy)) {
        return std::nullopt;
    }
    return Ground{sum / n, (sx * yy - sy * xy) / determinant, (sy * xx - sx * xy) / determinant};
}

double top_of(const cv::Mat& m, const Circle& circle, const Ground& ground) {
    double sum = 0.0;
    double n = 0.0;
    const double reach = std::max(1.0, kTopPart * circle.radius);
    const int steps = static_cast<int>(4.0 * reach) + 1;
    for (int row = 0; row < steps; ++row) {
        const double dy = 0.5 * row - reach;
        for (int column = 0; column < steps; ++column) {
            const double dx = 0.5 * column - reach;
            if (dx * dx + dy * dy <= reach * reach) {
                sum += bilinear(m, circle.x + dx, circle.y + dy) - ground.at(dx, dy);
                n += 1.0;
            }
        }
    }
    return sum / n;
}

/// Where the spokes fall through the height, coming from the middle.
std::vector<std::array<double, 2>> outline_at(const cv::Mat& m, const Circle& circle, const Ground& ground,
                                              double height, double search) {
    std::vector<std::array<double, 2>> points;
    for (int k = 0; k < kSpokes; ++k) {
        const double t = 2.0 * std::numbers::pi * k / kSpokes;
        const double c = std::cos(t);
        const double s = std::sin(t);
        double before = 1.0;
        for (int step = 0; step * kStepPx <= search; ++step) {
            const double r = step * kStepPx;
            const double x = circle.x + r * c;
            const double y = circle.y + r * s;
            if (x < 0.0 || y < 0.0 || x > m.cols - 1.0 || y > m.rows - 1.0) {
                break;
            }
            const double over = bilinear(m, x, y) - ground.at(r * c, r * s) - height;
            if (over <= 0.0 && r > 0.0) {
                const double back = kStepPx * over / (over - before);
                points.push_back({x - back * c, y - back * s});
                break;
            }
            before = over;
        }
    }
    return points;
}

struct Levels {
    std::array<Circle, kHeights.size()> circle;
    double height = 0.0;
};

std::optional<Levels> levels_about(const cv::Mat& m, const Circle& start, const OutlineSettings& settings) {
    const auto ground = ground_of(m, start, settings);
    if (!ground) {
        return std::nullopt;
    }
    Levels out;
    out.height = top_of(m, start, *ground);
    for (std::size_t i = 0; i < kHeights.size(); ++i) {
        const auto points = outline_at(m, start, *ground, kHeights[i] * out.height, settings.search_to * start.radius);
        if (static_cast<double>(points.size()) < kFewestSpokes * kSpokes) {
            return std::nullopt;
        }
        const auto circle = fit_circle(points);
        if (!circle) {
            return std::nullopt;
        }
        out.circle[i] = *circle;
    }
    return out;
}

}  // namespace

std::optional<Outline> find_outline(const cv::Mat& light, const Circle& start, const OutlineSettings& settings) {
    const double blur = std::max(settings.least_smoothing_px, settings.smoothing * start.radius);
    const double reach = settings.background_to * start.radius + 3.0 * blur + 4.0;
    const cv::Rect whole(0, 0, light.cols, light.rows);
    const cv::Rect part =
        cv::Rect(static_cast<int>(std::floor(start.x - reach)), static_cast<int>(std::floor(start.y - reach)),
                 static_cast<int>(2.0 * reach) + 2, static_cast<int>(2.0 * reach) + 2) &
        whole;
    if (part.width < 4 || part.height < 4) {
        return std::nullopt;
    }
    cv::Mat smooth;
    // The part alone: what lies beyond must not matter.
    cv::GaussianBlur(light(part), smooth, cv::Size(), blur, blur, cv::BORDER_REFLECT | cv::BORDER_ISOLATED);
    Circle about = start;
    about.x -= part.x;
    about.y -= part.y;
    Outline out;
    for (int round = 0; round < kRounds; ++round) {
        const auto levels = levels_about(smooth, about, settings);
        if (!levels) {
            return std::nullopt;
        }
        out.circle = levels->circle[kHalf];
        out.circle.x = 0.0;
        out.circle.y = 0.0;
        for (const Circle& circle : levels->circle) {
            out.circle.x += circle.x / static_cast<double>(kHeights.size());
            out.circle.y += circle.y / static_cast<double>(kHeights.size());
        }
        out.height = levels->height;
        about.x = out.circle.x;
        about.y = out.circle.y;
    }
    // Neighbouring spokes share what the smoothing has mixed: that many of them count.
    const double apart = std::max(2.5 * blur, 1.0);
    const double free = std::max(4.0, 2.0 * std::numbers::pi * out.circle.radius / apart);
    out.sigma = out.circle.residual * std::sqrt(2.0 / free);
    out.circle.x += part.x;
    out.circle.y += part.y;
    return out;
}

}  // namespace sc::host

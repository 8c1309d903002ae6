// SPDX-License-Identifier: Apache-2.0
#include "host/vision/board.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <utility>

#include <opencv2/imgproc.hpp>

#include "host/vision/light.hpp"
#include "host/vision/marker.hpp"

namespace sc::host {
namespace {

using Point = std::array<double, 2>;

constexpr double kSaddleBlurPx = 2.0;
constexpr double kRingPx = 5.0;
constexpr std::size_t kRing = 16;
constexpr double kLeastOfBest = 0.05;  ///< of the strongest saddle
constexpr double kLeastSwing = 0.04;   ///< light between dark and bright squares, of full scale
constexpr double kMostLopsided = 0.6;  ///< difference of opposite pixels over that of neighbouring quarters
constexpr double kSamePx = 3.0;
constexpr double kMostMovedPx = 3.0;
constexpr int kMoves = 30;
constexpr double kAtRestPx = 1e-4;
constexpr double kWindowShare = 0.3;  ///< of the way to the next corner
constexpr double kLeastWindowPx = 3.0;
constexpr double kMostWindowPx = 12.0;
constexpr double kGradientBlurPx = 1.0;
constexpr double kBigDot = 1.25;  ///< radius over the median

std::string size_text(const GridSize& size) { return std::to_string(size.columns) + "x" + std::to_string(size.rows); }

double light_at(const cv::Mat& light, double x, double y) {
    const double cx = std::clamp(x, 0.0, light.cols - 1.001);
    const double cy = std::clamp(y, 0.0, light.rows - 1.001);
    const int column = static_cast<int>(cx);
    const int row = static_cast<int>(cy);
    const double fx = cx - column;
    const double fy = cy - row;
    const auto at = [&](int dx, int dy) { return static_cast<double>(light.at<float>(row + dy, column + dx)); };
    return (1.0 - fy) * ((1.0 - fx) * at(0, 0) + fx * at(1, 0)) + fy * ((1.0 - fx) * at(0, 1) + fx * at(1, 1));
}

/// Whether the ring round a place alternates dark, bright, dark, bright, opposite pixels alike.
bool is_crossing(const cv::Mat& light, const Point& at) {
    std::array<double, kRing> ring{};
    double mean = 0.0;
    for (std::size_t k = 0; k < kRing; ++k) {
        const double turn = 2.0 * std::numbers::pi * static_cast<double>(k) / kRing;
        ring[k] = light_at(light, at[0] + kRingPx * std::cos(turn), at[1] + kRingPx * std::sin(turn));
        mean += ring[k] / kRing;
    }
    double swing = 0.0;
    double lopsided = 0.0;
    int changes = 0;
    for (std::size_t k = 0; k < kRing; ++k) {
        const double opposite = ring[(k + kRing / 2) % kRing];
        const double quarter = ring[(k + kRing / 4) % kRing];
        swing += std::abs(ring[k] - quarter) / kRing;
        lopsided += std::abs(ring[k] - opposite) / kRing;
        changes += (ring[k] > mean) != (ring[(k + 1) % kRing] > mean) ? 1 : 0;
    }
    return changes == 4 && swing > kLeastSwing && lopsided < kMostLopsided * swing;
}

/// Local maxima of Ixy² − Ixx·Iyy that are crossings.
std::vector<Point> find_saddles(const cv::Mat& light) {
    cv::Mat smooth;
    cv::GaussianBlur(light, smooth, cv::Size(), kSaddleBlurPx, kSaddleBlurPx, cv::BORDER_REPLICATE);
    cv::Mat xx;
    cv::Mat yy;
    cv::Mat xy;
    cv::Sobel(smooth, xx, CV_32F, 2, 0);
    cv::Sobel(smooth, yy, CV_32F, 0, 2);
    cv::Sobel(smooth, xy, CV_32F, 1, 1);
    const cv::Mat strength = xy.mul(xy) - xx.mul(yy);
    cv::Mat largest;
    cv::dilate(strength, largest, cv::getStructuringElement(cv::MORPH_ELLIPSE, cv::Size(7, 7)));
    double most = 0.0;
    cv::minMaxLoc(strength, nullptr, &most);
    std::vector<Point> out;
    const int border = static_cast<int>(kRingPx) + 1;
    for (int row = border; row < light.rows - border; ++row) {
        for (int column = border; column < light.cols - border; ++column) {
            const float s = strength.at<float>(row, column);
            if (static_cast<double>(s) > kLeastOfBest * most && s >= largest.at<float>(row, column) &&
                is_crossing(smooth, {static_cast<double>(column), static_cast<double>(row)})) {
                out.push_back({static_cast<double>(column), static_cast<double>(row)});
            }
        }
    }
    return out;
}

struct Slopes {
    cv::Mat x;
    cv::Mat y;
};

Slopes slopes_of(const cv::Mat& light) {
    cv::Mat smooth;
    cv::GaussianBlur(light, smooth, cv::Size(), kGradientBlurPx, kGradientBlurPx, cv::BORDER_REPLICATE);
    Slopes out;
    const cv::Mat along = (cv::Mat_<float>(1, 3) << -0.5F, 0.0F, 0.5F);
    const cv::Mat none = (cv::Mat_<float>(1, 1) << 1.0F);
    cv::sepFilter2D(smooth, out.x, CV_32F, along, none, cv::Point(-1, -1), 0.0, cv::BORDER_REPLICATE);
    cv::sepFilter2D(smooth, out.y, CV_32F, none, along, cv::Point(-1, -1), 0.0, cv::BORDER_REPLICATE);
    return out;
}

/// The place past which the gradients around it point: Σ w·g·gᵀ·(p − q) = 0, in a round window of standard deviation
/// `window` that moves along. None if it walks away.
std::optional<Point> settled(const Slopes& slopes, const Point& start, double window) {
    Point at = start;
    const int reach = static_cast<int>(std::ceil(2.5 * window));
    for (int move = 0; move < kMoves; ++move) {
        double xx = 0.0;
        double xy = 0.0;
        double yy = 0.0;
        double bx = 0.0;
        double by = 0.0;
        const int column0 = static_cast<int>(std::lround(at[0]));
        const int row0 = static_cast<int>(std::lround(at[1]));
        for (int row = std::max(row0 - reach, 0); row <= std::min(row0 + reach, slopes.x.rows - 1); ++row) {
            for (int column = std::max(column0 - reach, 0); column <= std::min(column0 + reach, slopes.x.cols - 1);
                 ++column) {
                const double dx = column - at[0];
                const double dy = row - at[1];
                const double weight = std::exp(-0.5 * (dx * dx + dy * dy) / (window * window));
                const auto gx = static_cast<double>(slopes.x.at<float>(row, column));
                const auto gy = static_cast<double>(slopes.y.at<float>(row, column));
                const double along = gx * dx + gy * dy;
                xx += weight * gx * gx;
                xy += weight * gx * gy;
                yy += weight * gy * gy;
                bx += weight * gx * along;
                by += weight * gy * along;
            }
        }
        const double d = xx * yy - xy * xy;
        if (!(d > 1e-6 * (xx + yy) * (xx + yy))) {
            return std::nullopt;
        }
        const double step_x = (yy * bx - xy * by) / d;
        const double step_y = (xx * by - xy * bx) / d;
        at = {at[0] + step_x, at[1] + step_y};
        if (!(std::hypot(at[0] - start[0], at[1] - start[1]) < kMostMovedPx)) {
            return std::nullopt;
        }
        if (std::hypot(step_x, step_y) < kAtRestPx) {
            break;
        }
    }
    return at;
}

/// Each once.
std::vector<Point> settled_all(const Slopes& slopes, const std::vector<Point>& saddles) {
    std::vector<Point> out;
    for (const Point& saddle : saddles) {
        const auto at = settled(slopes, saddle, kLeastWindowPx);
        if (at && std::ranges::none_of(
                      out, [&](const Point& o) { return std::hypot(o[0] - (*at)[0], o[1] - (*at)[1]) < kSamePx; })) {
            out.push_back(*at);
        }
    }
    return out;
}

/// Way to the nearest neighbour in the grid, px.
double room_of(const std::vector<GridPoint>& grid, const std::vector<Point>& points, const GridPoint& p) {
    double least = 1e9;
    for (const GridPoint& o : grid) {
        if (std::abs(o.column - p.column) + std::abs(o.row - p.row) == 1) {
            least = std::min(
                least, std::hypot(points[o.index][0] - points[p.index][0], points[o.index][1] - points[p.index][1]));
        }
    }
    return least;
}

/// Light in the middle of the squares that lie like the first one, less that of the others.
double first_square(const cv::Mat& light, const std::vector<GridPoint>& grid, const std::vector<Point>& points) {
    double difference = 0.0;
    for (const GridPoint& a : grid) {
        for (const GridPoint& b : grid) {
            if (b.column == a.column + 1 && b.row == a.row + 1) {
                const double x = 0.5 * (points[a.index][0] + points[b.index][0]);
                const double y = 0.5 * (points[a.index][1] + points[b.index][1]);
                difference += ((a.column + a.row) % 2 == 0 ? 1.0 : -1.0) * light_at(light, x, y);
            }
        }
    }
    return difference;
}

BoardFound found_of(std::vector<GridPoint> grid, const std::vector<Point>& points, bool sure) {
    std::ranges::sort(grid, {}, [](const GridPoint& p) { return std::pair{p.row, p.column}; });
    BoardFound out{.corners = {}, .first_is_sure = sure};
    for (const GridPoint& p : grid) {
        out.corners.push_back({.column = p.column, .row = p.row, .x = points[p.index][0], .y = points[p.index][1]});
    }
    return out;
}

/// The grid among its turns that runs most to the right.
std::vector<GridPoint> upright(const std::vector<GridPoint>& grid, const std::vector<Point>& points,
                               const GridSize& size) {
    std::vector<std::vector<GridPoint>> turns{grid, turned_half(grid, size)};
    if (size.columns == size.rows) {
        turns.push_back(turned_quarter(grid, size));
        turns.push_back(turned_half(turns.back(), size));
    }
    return *std::ranges::max_element(turns, {}, [&](const auto& g) { return heading_right(g, points); });
}

}  // namespace

std::expected<BoardFound, std::string> find_chessboard(const GreyImage& image, const GridSize& size) {
    if (image.width < 32 || image.height < 32) {
        return std::unexpected("the picture is too small");
    }
    const cv::Mat light = light_of(image);
    const Slopes slopes = slopes_of(light);
    std::vector<Point> points = settled_all(slopes, find_saddles(light));
    const auto grid = find_grid(points, size);
    if (!grid) {
        return std::unexpected("no chessboard of " + size_text(size) +
                               " inner corners is seen: " + std::to_string(points.size()) +
                               " corners are found; show the whole board, evenly lit, each square 10 pixels or more");
    }
    for (const GridPoint& p : *grid) {
        const double window = std::clamp(kWindowShare * room_of(*grid, points, p), kLeastWindowPx, kMostWindowPx);
        if (const auto at = settled(slopes, points[p.index], 0.5 * window)) {
            points[p.index] = *at;
        }
    }
    // Seen from the other end its colours change places only if columns and rows are one odd, one even.
    const bool sure = (size.columns + size.rows) % 2 == 1;
    if (!sure) {
        return found_of(upright(*grid, points, size), points, false);
    }
    const bool dark_first = first_square(light, *grid, points) < 0.0;
    return found_of(dark_first ? *grid : turned_half(*grid, size), points, true);
}

std::expected<BoardFound, std::string> find_dot_grid(const GreyImage& image, const GridSize& size) {
    const MarkersFound markers = find_markers(image);
    std::vector<Point> points;
    std::vector<double> radii;
    for (const Marker& m : markers.markers) {
        points.push_back({m.ellipse.x, m.ellipse.y});
        radii.push_back(std::sqrt(m.ellipse.major * m.ellipse.minor));
    }
    const auto grid = find_grid(points, size);
    if (!grid) {
        return std::unexpected("no grid of " + size_text(size) + " dots is seen: " + std::to_string(points.size()) +
                               " dots are found, " + std::to_string(markers.refused.size()) +
                               " are refused; show the whole board, each dot 5 pixels across or more");
    }
    std::vector<double> sorted;
    for (const GridPoint& p : *grid) {
        sorted.push_back(radii[p.index]);
    }
    std::ranges::sort(sorted);
    const auto big = std::ranges::max_element(*grid, {}, [&](const GridPoint& p) { return radii[p.index]; });
    const bool sure = radii[big->index] > kBigDot * sorted[sorted.size() / 2];
    std::vector<GridPoint> best = upright(*grid, points, size);
    if (sure) {
        const auto rank = [&](const std::vector<GridPoint>& g) {
            const auto dot = std::ranges::find(g, big->index, &GridPoint::index);
            return dot->column + dot->row;
        };
        std::vector<std::vector<GridPoint>> turns{best, turned_half(best, size)};
        if (size.columns == size.rows) {
            turns.push_back(turned_quarter(best, size));
            turns.push_back(turned_half(turns.back(), size));
        }
        best = *std::ranges::min_element(turns, {}, rank);
    }
    BoardFound out = found_of(best, points, sure);
    for (BoardCorner& corner : out.corners) {
        const auto marker = std::ranges::find_if(
            markers.markers, [&](const Marker& m) { return m.ellipse.x == corner.x && m.ellipse.y == corner.y; });
        corner.sigma = marker->sigma;
    }
    return out;
}

Drawing overlay_of(const GreyImage& image, const BoardFound& found) {
    Drawing out{.width = image.width, .height = image.height, .shapes = {}};
    for (std::size_t i = 0; i < found.corners.size(); ++i) {
        const BoardCorner& c = found.corners[i];
        if (i > 0 && found.corners[i - 1].row == c.row) {
            out.shapes.emplace_back(Drawing::Line{
                .from = {found.corners[i - 1].x, found.corners[i - 1].y}, .to = {c.x, c.y}, .stroke = Stroke::thin});
        }
        out.shapes.emplace_back(Drawing::Disc{.centre = {c.x, c.y}, .radius = i == 0 ? 4.0 : 1.5});
    }
    return out;
}

}  // namespace sc::host

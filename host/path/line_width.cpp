// SPDX-License-Identifier: Apache-2.0
#include "host/path/line_width.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <span>

#include <fmt/format.h>

namespace sc::host {

namespace {

constexpr double kLeastTolerance = 1e-6;  ///< metres: taken for one of 0
constexpr double kShareOfTolerance = 0.1;
constexpr double kSteep = 1e-3;  ///< least part of a direction across the beam
constexpr double kSamePlace = 1e-8;
constexpr double kSharpest = -0.5;  ///< cosine of the turn of a corner that is mitred
constexpr std::size_t kMostStrokes = 255;
constexpr double kMostPoints = 1e5;
constexpr double kPointsPerSecond = 3000.0;  ///< of tight bends, that the slowest controller, a Cortex-M7, plans

/// A place of the line, given by this line of its file.
struct Corner {
    Vec3 place;
    int line = 0;
};

/// Steps of a circle of this radius whose chords stay so near to it.
int steps_of(double angle, double radius, double chord_error) {
    const double ratio = std::min(1.0, chord_error / radius);
    return std::max(1, static_cast<int>(std::ceil(angle / (2.0 * std::acos(1.0 - ratio)))));
}

std::vector<Corner> corners_of(const std::vector<Piece>& line, double chord_error) {
    std::vector<Corner> corners{{line.front().from, line.front().line}};
    for (const Piece& piece : line) {
        const int count = piece.circle ? steps_of(piece.circle->angle, piece.circle->radius(), chord_error) : 1;
        for (int i = 1; i < count; ++i) {
            corners.push_back({piece.at(static_cast<double>(i) / count), piece.line});
        }
        corners.push_back({piece.to, piece.line});
    }
    return corners;
}

std::vector<Piece> joined(std::span<const Corner> corners) {
    std::vector<Piece> pieces;
    for (std::size_t i = 1; i < corners.size(); ++i) {
        pieces.push_back({corners[i - 1].place, corners[i].place, std::nullopt, corners[i].line});
    }
    return pieces;
}

/// To the right of the way, across the beam.
std::vector<Vec3> normals_of(std::span<const Corner> corners) {
    std::vector<Vec3> normals;
    for (std::size_t i = 1; i < corners.size(); ++i) {
        const Vec3 way = corners[i].place - corners[i - 1].place;
        const double across = std::hypot(way.x, way.z);
        if (!(across > kSteep * norm(way))) {
            throw LineWidthError(corners[i].line, "a line along the beam has no width",
                                 fmt::format("{:.6g} mm", 1e3 * norm(way)),
                                 "leave width_um out, or burn it with a face that it lies across");
        }
        normals.push_back(Vec3{way.z, 0.0, -way.x} * (1.0 / across));
    }
    return normals;
}

/// The line moved to the right by `offset`.
std::vector<Corner> beside(std::span<const Corner> corners, std::span<const Vec3> normals, double offset) {
    const bool closed = norm(corners.back().place - corners.front().place) < kSamePlace;
    std::vector<Corner> out;
    for (std::size_t i = 0; i < corners.size(); ++i) {
        const Vec3& before = i > 0 ? normals[i - 1] : (closed ? normals.back() : normals.front());
        const Vec3& after = i < normals.size() ? normals[i] : (closed ? normals.front() : normals.back());
        const double turn = dot(before, after);
        if (turn < kSharpest) {
            throw LineWidthError(
                corners[i].line, "a corner is too sharp for a hatched line",
                fmt::format("turned by {:.4g} degrees", std::acos(std::max(-1.0, turn)) * 180.0 / std::numbers::pi),
                "use fill = \"wobble\", or make two paths of it");
        }
        out.push_back({corners[i].place + (before + after) * (offset / (1.0 + turn)), corners[i].line});
    }
    for (std::size_t i = 1; i < out.size(); ++i) {
        const Vec3 way = corners[i].place - corners[i - 1].place;
        const Vec3 moved = out[i].place - out[i - 1].place;
        if (!(way.x * moved.x + way.z * moved.z > 0.0)) {
            throw LineWidthError(corners[i].line, "a bend is too narrow for a hatched line of this width",
                                 fmt::format("{:.6g} um beside the line", 1e6 * std::abs(offset)),
                                 "make width_um smaller, or use fill = \"wobble\"");
        }
    }
    return out;
}

Strokes hatch(const std::vector<Piece>& line, const MarkSettings& settings, double chord_error) {
    const double width = settings.width.si();
    const double gaps = std::max(1.0, std::ceil(width / settings.fill_step.si() - 1e-9));
    if (!((gaps + 1.0) * settings.passes <= static_cast<double>(kMostStrokes))) {
        throw LineWidthError(0, "has too many strokes, all passes together",
                             fmt::format("{:.6g}", (gaps + 1.0) * settings.passes),
                             fmt::format("make fill_step_um larger: {} strokes are possible", kMostStrokes));
    }
    const std::vector<Corner> corners = corners_of(line, chord_error);
    const std::vector<Vec3> normals = normals_of(corners);
    Strokes out;
    for (int k = 0; k <= static_cast<int>(gaps); ++k) {
        std::vector<Corner> stroke = beside(corners, normals, width * (k / gaps - 0.5));
        if (k % 2 == 1) {
            std::ranges::reverse(stroke);
        }
        out.pieces.push_back(joined(stroke));
    }
    return out;
}

Strokes wobble(const std::vector<Piece>& line, const MarkSettings& settings, double chord_error) {
    const double radius = 0.5 * settings.width.si();
    const double step = settings.fill_step.si();
    const int per_turn = std::max(12, steps_of(2.0 * std::numbers::pi, radius, chord_error));
    const std::vector<Corner> corners = corners_of(line, chord_error);
    const std::vector<Piece> pieces = joined(corners);
    const double whole_length = length(pieces);
    const double points = whole_length / step * per_turn;
    if (!(points <= kMostPoints)) {
        throw LineWidthError(0, "has too many points with its wobble", fmt::format("{:.6g}", points),
                             "make fill_step_um larger, or the path shorter");
    }
    const double points_per_s = settings.speed.si() * per_turn / (2.0 * std::numbers::pi * radius);
    if (points_per_s > kPointsPerSecond) {
        throw LineWidthError(0, "has more points a second, with its wobble, than a controller plans",
                             fmt::format("{:.6g} of {:.6g}", points_per_s, kPointsPerSecond),
                             fmt::format("make speed_mm_s {:.3g} or less, tolerance_um larger, or use fill = \"hatch\"",
                                         std::floor(1e3 * settings.speed.si() * kPointsPerSecond / points_per_s)));
    }
    const auto turned = [&](const Vec3& place, double turn) {
        const double phi = 2.0 * std::numbers::pi * turn;
        return place + Vec3{radius * std::cos(phi), 0.0, radius * std::sin(phi)};
    };
    std::vector<Corner> stroke{{turned(line.front().from, 0.0), line.front().line}};
    double before = 0.0;  // length up to the piece
    const auto whole = static_cast<std::int64_t>(std::ceil(points - 1e-9));
    std::size_t at = 0;
    for (std::int64_t i = 1; i <= whole; ++i) {
        const double along = std::min(whole_length, static_cast<double>(i) * step / per_turn);
        while (at + 1 < pieces.size() && along > before + pieces[at].length()) {
            before += pieces[at].length();
            ++at;
        }
        const double share = std::min(1.0, (along - before) / pieces[at].length());
        stroke.push_back({turned(pieces[at].at(share), along / step), pieces[at].line});
    }
    return {{joined(stroke)}, 0.0};
}

}  // namespace

Strokes strokes_of(const std::vector<Piece>& line, const MarkSettings& settings) {
    const double tolerance = settings.tolerance.si();
    if (!(settings.width.si() > 0.0)) {
        return {{line}, tolerance};
    }
    const double chord_error = kShareOfTolerance * (tolerance > 0.0 ? tolerance : kLeastTolerance);
    const bool wobbles = settings.fill == Fill::wobble;
    Strokes out = wobbles ? wobble(line, settings, chord_error) : hatch(line, settings, chord_error);
    const bool has_chords =
        wobbles || std::ranges::any_of(line, [](const Piece& piece) { return piece.circle.has_value(); });
    out.tolerance = has_chords ? (1.0 - kShareOfTolerance) * tolerance : tolerance;
    return out;
}

}  // namespace sc::host

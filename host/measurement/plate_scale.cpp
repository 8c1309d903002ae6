// SPDX-License-Identifier: Apache-2.0
#include "host/measurement/plate_scale.hpp"

#include <algorithm>
#include <cmath>
#include <set>

#include <Eigen/Dense>

#include "host/formats/error.hpp"
#include "host/formats/text.hpp"

namespace sc::host {

namespace {

using Place = std::array<double, 2>;
using Map = Eigen::Matrix3d;

constexpr double kLargestResidual = 0.2e-3;  ///< metres: a dot that far off is another dot

Place mapped(const Map& map, const Place& p) {
    const Eigen::Vector3d v = map * Eigen::Vector3d(p[0], p[1], 1.0);
    return {v(0) / v(2), v(1) / v(2)};
}

/// Moves and scales the places so that they lie about zero with unit spread: the map's numbers are then alike.
Map normaliser(const std::vector<Place>& places) {
    Eigen::Vector2d mean = Eigen::Vector2d::Zero();
    for (const Place& p : places) {
        mean += Eigen::Vector2d(p[0], p[1]) / static_cast<double>(places.size());
    }
    double spread = 0.0;
    for (const Place& p : places) {
        spread += std::hypot(p[0] - mean(0), p[1] - mean(1)) / static_cast<double>(places.size());
    }
    const double k = 1.0 / spread;
    Map out;
    out << k, 0.0, -k * mean(0), 0.0, k, -k * mean(1), 0.0, 0.0, 1.0;
    return out;
}

/// Plane-to-plane map by least squares of its linear form, twice: the second time with the right weights.
Map fit_map(const std::vector<Place>& from, const std::vector<Place>& to) {
    const Map a = normaliser(from);
    const Map b = normaliser(to);
    Map h = Map::Identity();
    for (int round = 0; round < 3; ++round) {
        Eigen::MatrixXd rows(2 * static_cast<Eigen::Index>(from.size()), 8);
        Eigen::VectorXd right(rows.rows());
        for (std::size_t i = 0; i < from.size(); ++i) {
            const Place p = mapped(a, from[i]);
            const Place q = mapped(b, to[i]);
            const double w = 1.0 / (h(2, 0) * p[0] + h(2, 1) * p[1] + 1.0);
            const auto r = static_cast<Eigen::Index>(2 * i);
            rows.row(r) << p[0], p[1], 1.0, 0.0, 0.0, 0.0, -q[0] * p[0], -q[0] * p[1];
            rows.row(r + 1) << 0.0, 0.0, 0.0, p[0], p[1], 1.0, -q[1] * p[0], -q[1] * p[1];
            right(r) = q[0];
            right(r + 1) = q[1];
            rows.middleRows(r, 2) *= w;
            right.segment(r, 2) *= w;
        }
        const Eigen::VectorXd x = rows.colPivHouseholderQr().solve(right);
        h << x(0), x(1), x(2), x(3), x(4), x(5), x(6), x(7), 1.0;
    }
    return b.inverse() * h * a;
}

/// Index of the place that is furthest in the direction (u, v).
std::size_t furthest(const std::vector<Place>& places, double u, double v) {
    std::size_t best = 0;
    for (std::size_t i = 1; i < places.size(); ++i) {
        if (u * places[i][0] + v * places[i][1] > u * places[best][0] + v * places[best][1]) {
            best = i;
        }
    }
    return best;
}

[[noreturn]] void no_pattern(const Stand& stand, const PlatePixels& pixels, const std::string& why) {
    throw InputError(
        {.file = stand.file.string(),
         .problem = "the dots on the plate at " + fixed(pixels.z * 1e3, 1) + " mm do not fit their pattern: " + why,
         .value = {},
         .action = "take the picture with x of the head to the right and y down, all dots in it"});
}

}  // namespace

PlateScale scale_of(const Stand& stand, const PlatePixels& pixels) {
    // The four corners of the pattern give a first map; it tells which dot is which.
    std::vector<Place> from;
    std::vector<Place> to;
    for (const auto& [u, v] : {Place{1.0, 1.0}, Place{1.0, -1.0}, Place{-1.0, 1.0}, Place{-1.0, -1.0}}) {
        from.push_back(pixels.dots[furthest(pixels.dots, u, v)]);
        to.push_back(stand.dots[furthest(stand.dots, u, v)]);
    }
    const Map first = fit_map(from, to);
    from.clear();
    to.clear();
    std::set<std::size_t> taken;
    for (const Place& dot : pixels.dots) {
        const Place near = mapped(first, dot);
        std::size_t best = 0;
        for (std::size_t i = 1; i < stand.dots.size(); ++i) {
            if (std::hypot(stand.dots[i][0] - near[0], stand.dots[i][1] - near[1]) <
                std::hypot(stand.dots[best][0] - near[0], stand.dots[best][1] - near[1])) {
                best = i;
            }
        }
        if (!taken.insert(best).second) {
            no_pattern(stand, pixels, "two of them lie at the same place of it");
        }
        from.push_back(dot);
        to.push_back(stand.dots[best]);
    }
    const Map map = fit_map(from, to);
    PlateScale out;
    out.z = pixels.z;
    double squares = 0.0;
    for (std::size_t i = 0; i < from.size(); ++i) {
        const Place p = mapped(map, from[i]);
        squares += std::pow(p[0] - to[i][0], 2) + std::pow(p[1] - to[i][1], 2);
    }
    const double freedom = 2.0 * static_cast<double>(from.size()) - 8.0;
    out.residual = std::sqrt(squares / std::max(1.0, freedom));
    if (!(out.residual < kLargestResidual)) {
        no_pattern(stand, pixels, fixed(out.residual * 1e3, 3) + " mm rms");
    }
    for (std::size_t i = 0; i < 3; ++i) {
        out.spots[i] = mapped(map, pixels.spots[i]);
        for (std::size_t k = 0; k < 2; ++k) {
            out.middle[k] += out.spots[i][k] / 3.0;
        }
    }
    for (std::size_t i = 0; i < 3; ++i) {
        const Place& a = out.spots[i];
        const Place& b = out.spots[(i + 1) % 3];
        out.side[i] = std::hypot(a[0] - b[0], a[1] - b[1]);
    }
    // Pixels over millimetres there, along x and y: columns of the inverse map's derivative.
    const Map back = map.inverse();
    constexpr double kStep = 1e-4;
    const Place at_middle = mapped(back, out.middle);
    for (std::size_t k = 0; k < 2; ++k) {
        Place there = out.middle;
        there[k] += kStep;
        const Place moved = mapped(back, there);
        out.px_per_mm[k] = std::hypot(moved[0] - at_middle[0], moved[1] - at_middle[1]) / (kStep * 1e3);
    }
    out.spot_sigma = pixels.spot_sigma / (1e3 * std::min(out.px_per_mm[0], out.px_per_mm[1]));
    return out;
}

}  // namespace sc::host

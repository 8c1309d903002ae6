// SPDX-License-Identifier: Apache-2.0
#include "host/vision/circle_pose.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include <opencv2/core.hpp>

#include "host/formats/text.hpp"
#include "host/vision/dual_conic.hpp"

namespace sc::host {
namespace {

constexpr double kDegree = std::numbers::pi / 180.0;
constexpr double kMostSpread = 5.0 * kDegree;
constexpr double kTellApart = 2.0;        ///< spread of the false solution over that of the true one, at least
constexpr double kAlike = 6.0 * kDegree;  ///< solutions so near that either will do
constexpr double kLeastSpread = 0.02 * kDegree;

cv::Matx33d camera_matrix(const Pinhole& camera) {
    return {camera.focal_x, 0.0, camera.middle_x, 0.0, camera.focal_y, camera.middle_y, 0.0, 0.0, 1.0};
}

/// K⁻¹·C*·K⁻ᵀ: the dual conic on the plane z = 1.
cv::Matx33d dual_on_unit_plane(const Ellipse& e, const Pinhole& camera) {
    const EllipseShape s = shape_of(e);
    const double x = (e.x - camera.middle_x) / camera.focal_x;
    const double y = (e.y - camera.middle_y) / camera.focal_y;
    const double xx = s[0] / (camera.focal_x * camera.focal_x);
    const double xy = s[1] / (camera.focal_x * camera.focal_y);
    const double yy = s[2] / (camera.focal_y * camera.focal_y);
    return {xx - x * x, xy - x * y, -x, xy - x * y, yy - y * y, -y, -x, -y, -1.0};
}

double angle_between(const Vec3& a, const Vec3& b) { return std::atan2(norm(cross(a, b)), dot(a, b)); }

Vec3 unit(const Vec3& v) { return (1.0 / norm(v)) * v; }

/// One normal of each circle, the nearer to `seed`; their mean, and their rms angle from it.
struct Agreement {
    Vec3 mean;
    double spread = 0.0;
};

Agreement agreement(const std::vector<std::array<Vec3, 2>>& normals, Vec3 seed) {
    Agreement out{.mean = seed};
    for (int round = 0; round < 2; ++round) {
        Vec3 sum;
        double squares = 0.0;
        for (const auto& pair : normals) {
            const Vec3& nearer = dot(pair[0], out.mean) >= dot(pair[1], out.mean) ? pair[0] : pair[1];
            sum = sum + nearer;
            const double angle = angle_between(nearer, out.mean);
            squares += angle * angle;
        }
        out.spread = std::sqrt(squares / static_cast<double>(normals.size()));
        out.mean = unit(sum);
    }
    return out;
}

}  // namespace

std::array<Vec3, 2> circle_normals(const Ellipse& ellipse, const Pinhole& camera) {
    const cv::Matx33d cone = dual_on_unit_plane(ellipse, camera).inv();
    cv::Matx31d values;
    cv::Matx33d vectors;  // rows, by falling eigenvalue
    cv::eigen(0.5 * (cone + cone.t()), values, vectors);
    // Two eigenvalues of one sign and one of the other; the odd one must be last.
    int odd = 2;
    if (values(1) < 0.0) {
        odd = 0;
    }
    const int first = odd == 2 ? 0 : 2;
    const double largest = std::abs(values(first));
    const double middle = std::abs(values(1));
    const double least = -std::abs(values(odd));
    const double along = std::sqrt(std::max(0.0, (largest - middle) / (largest - least)));
    const double depth = std::sqrt(std::max(0.0, (middle - least) / (largest - least)));
    std::array<Vec3, 2> out;
    for (std::size_t k = 0; k < 2; ++k) {
        const double sign = k == 0 ? 1.0 : -1.0;
        const Vec3 n{sign * along * vectors(first, 0) + depth * vectors(odd, 0),
                     sign * along * vectors(first, 1) + depth * vectors(odd, 1),
                     sign * along * vectors(first, 2) + depth * vectors(odd, 2)};
        const Vec3 ray{(ellipse.x - camera.middle_x) / camera.focal_x, (ellipse.y - camera.middle_y) / camera.focal_y,
                       1.0};
        out[k] = dot(n, ray) > 0.0 ? -n : n;
    }
    return out;
}

std::expected<Vec3, std::string> common_normal(std::span<const Ellipse> ellipses, const Pinhole& camera) {
    if (ellipses.size() < 2) {
        return std::unexpected("a plane needs two circles at least, there are " + std::to_string(ellipses.size()) +
                               ": give its normal");
    }
    std::vector<std::array<Vec3, 2>> normals;
    for (const Ellipse& e : ellipses) {
        normals.push_back(circle_normals(e, camera));
    }
    std::vector<Agreement> all;
    for (const auto& pair : normals) {
        all.push_back(agreement(normals, pair[0]));
        all.push_back(agreement(normals, pair[1]));
    }
    std::sort(all.begin(), all.end(), [](const Agreement& a, const Agreement& b) { return a.spread < b.spread; });
    const Agreement& best = all.front();
    if (best.spread > kMostSpread) {
        return std::unexpected("the circles do not lie on one plane: their normals differ by " +
                               fixed(best.spread / kDegree, 1) + " deg, rms; give one normal for each plane");
    }
    for (const Agreement& other : all) {
        if (angle_between(other.mean, best.mean) > kAlike &&
            other.spread < kTellApart * std::max(best.spread, kLeastSpread)) {
            return std::unexpected("two planes fit the circles alike, " +
                                   fixed(angle_between(other.mean, best.mean) / kDegree, 1) +
                                   " deg apart: use circles further from each other, or give the normal");
        }
    }
    return best.mean;
}

std::array<double, 2> circle_centre(const Ellipse& ellipse, const Pinhole& camera, const Vec3& normal) {
    const cv::Vec3d pole =
        camera_matrix(camera) * (dual_on_unit_plane(ellipse, camera) * cv::Vec3d(normal.x, normal.y, normal.z));
    return {pole[0] / pole[2], pole[1] / pole[2]};
}

Vec3 circle_place(const Ellipse& ellipse, const Pinhole& camera, const Vec3& normal, double radius) {
    // The dual conic is k·(R²·(I − n·nᵀ) − s²·v·vᵀ) with the middle at s·v: its trace and its value on n give s.
    const cv::Matx33d dual = dual_on_unit_plane(ellipse, camera);
    const cv::Vec3d n(normal.x, normal.y, normal.z);
    const cv::Vec3d pole = dual * n;
    const cv::Vec3d v = pole * (1.0 / pole[2]);
    const double share = cv::trace(dual) / n.dot(pole);
    const double across = v.dot(n);
    const double square = 2.0 * radius * radius / (v.dot(v) - share * across * across);
    const double depth = std::sqrt(std::max(square, 0.0));
    return {depth * v[0], depth * v[1], depth};
}

}  // namespace sc::host

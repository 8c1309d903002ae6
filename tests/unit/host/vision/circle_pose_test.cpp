// SPDX-License-Identifier: Apache-2.0
#include "host/vision/circle_pose.hpp"

#include <cmath>
#include <numbers>
#include <vector>

#include <gtest/gtest.h>

namespace sc::host {
namespace {

constexpr double kDegree = std::numbers::pi / 180.0;
const Pinhole kCamera{.focal_x = 2232.0, .focal_y = 2240.0, .middle_x = 959.5, .middle_y = 600.0};

std::array<double, 2> seen(const Vec3& p) {
    return {kCamera.middle_x + kCamera.focal_x * p.x / p.z, kCamera.middle_y + kCamera.focal_y * p.y / p.z};
}

/// The ellipse through the pictures of points of the circle: the conic's five coefficients from five points by Gauss'
/// elimination, then middle and axes from the conic itself.
Ellipse seen_ellipse(const Vec3& centre, const Vec3& normal, double radius) {
    Vec3 u = cross(normal, std::abs(normal.x) < 0.8 ? Vec3{1.0, 0.0, 0.0} : Vec3{0.0, 1.0, 0.0});
    u = (radius / norm(u)) * u;
    const Vec3 v = cross(normal, u);
    const auto origin = seen(centre);
    double a[5][6];
    for (int k = 0; k < 5; ++k) {
        const double turn = 2.0 * std::numbers::pi * k / 5.0;
        const auto p = seen(centre + std::cos(turn) * u + std::sin(turn) * v);
        const double x = (p[0] - origin[0]) / 20.0;
        const double y = (p[1] - origin[1]) / 20.0;
        const double row[6] = {x * x, x * y, y * y, x, y, 1.0};
        std::copy(row, row + 6, a[k]);
    }
    for (int k = 0; k < 5; ++k) {
        int best = k;
        for (int i = k + 1; i < 5; ++i) {
            best = std::abs(a[i][k]) > std::abs(a[best][k]) ? i : best;
        }
        std::swap(a[k], a[best]);
        for (int i = 0; i < 5; ++i) {
            if (i != k) {
                const double share = a[i][k] / a[k][k];
                for (int j = k; j < 6; ++j) {
                    a[i][j] -= share * a[k][j];
                }
            }
        }
    }
    double c[5];
    for (int k = 0; k < 5; ++k) {
        c[k] = a[k][5] / a[k][k];
    }
    const double det = 4.0 * c[0] * c[2] - c[1] * c[1];
    const double x = (c[1] * c[4] - 2.0 * c[2] * c[3]) / det;
    const double y = (c[1] * c[3] - 2.0 * c[0] * c[4]) / det;
    const double size = c[0] * x * x + c[1] * x * y + c[2] * y * y + 1.0;
    const double mean = 0.5 * (c[0] + c[2]);
    const double half = std::hypot(0.5 * (c[0] - c[2]), 0.5 * c[1]);
    const double one = size / (mean + half);
    const double other = size / (mean - half);
    const bool swap = one < other;
    const double angle = 0.5 * std::atan2(c[1], c[0] - c[2]) + (swap ? 0.5 * std::numbers::pi : 0.0);
    return {.x = origin[0] + 20.0 * x,
            .y = origin[1] + 20.0 * y,
            .major = 20.0 * std::sqrt(std::max(one, other)),
            .minor = 20.0 * std::sqrt(std::min(one, other)),
            .angle = angle};
}

Vec3 tilted(double tilt, double heading) {
    return {std::sin(tilt) * std::cos(heading), std::sin(tilt) * std::sin(heading), -std::cos(tilt)};
}

double degrees_between(const Vec3& a, const Vec3& b) { return std::atan2(norm(cross(a, b)), dot(a, b)) / kDegree; }

TEST(CirclePose, OneOfTheTwoNormalsIsTheTrueOne) {
    for (const double tilt : {10.0, 30.0, 45.0, 65.0}) {
        for (const double heading : {0.3, 2.0, 4.4}) {
            const Vec3 normal = tilted(tilt * kDegree, heading);
            const auto found = circle_normals(seen_ellipse({30.0, -40.0, 500.0}, normal, 5.0), kCamera);
            EXPECT_LT(std::min(degrees_between(found[0], normal), degrees_between(found[1], normal)), 1e-3)
                << tilt << " " << heading;
        }
    }
}

TEST(CirclePose, CentreAndPlaceAreTheCircles) {
    const Vec3 centre{30.0, -40.0, 500.0};
    const Vec3 normal = tilted(45.0 * kDegree, 1.0);
    const Ellipse e = seen_ellipse(centre, normal, 5.0);
    const auto truth = seen(centre);
    // Without correction, a tenth of a pixel (facts: 112 mpx at radius 5 mm and 45 degrees).
    EXPECT_GT(std::hypot(e.x - truth[0], e.y - truth[1]), 0.08);
    const auto found = circle_centre(e, kCamera, normal);
    EXPECT_NEAR(found[0], truth[0], 1e-6);
    EXPECT_NEAR(found[1], truth[1], 1e-6);
    EXPECT_LT(norm(circle_place(e, kCamera, normal, 5.0) - centre), 1e-4);
}

TEST(CirclePose, CommonNormalOfAPlane) {
    const Vec3 normal = tilted(40.0 * kDegree, 2.2);
    const Vec3 u{-std::sin(2.2), std::cos(2.2), 0.0};
    const Vec3 v = cross(normal, u);
    std::vector<Ellipse> ellipses;
    for (int k = 0; k < 4; ++k) {
        ellipses.push_back(seen_ellipse(
            Vec3{5.0, 3.0, 500.0} + (40.0 * std::cos(1.6 * k)) * u + (40.0 * std::sin(1.6 * k)) * v, normal, 4.0));
    }
    const auto found = common_normal(ellipses, kCamera);
    ASSERT_TRUE(found) << found.error();
    EXPECT_LT(degrees_between(*found, normal), 1e-3);

    // One circle says too little; circles in one place leave two planes; another plane's circle agrees with none.
    EXPECT_FALSE(common_normal(std::vector{ellipses[0]}, kCamera));
    EXPECT_FALSE(common_normal(std::vector{ellipses[0], ellipses[0]}, kCamera));
    ellipses[0] = seen_ellipse({5.0, 3.0, 500.0}, tilted(60.0 * kDegree, 0.4), 4.0);
    const auto mixed = common_normal(ellipses, kCamera);
    ASSERT_FALSE(mixed);
    EXPECT_NE(mixed.error().find("one plane"), std::string::npos) << mixed.error();
}

}  // namespace
}  // namespace sc::host

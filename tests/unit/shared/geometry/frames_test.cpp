// SPDX-License-Identifier: Apache-2.0
#include "shared/geometry/frames.hpp"

#include <cmath>
#include <random>

#include <gtest/gtest.h>

namespace sc {
namespace {

Rigid<frame::H, frame::C> random_transform(std::mt19937_64& random) {
    std::normal_distribution<double> normal;
    const Vec3 raw{normal(random), normal(random), normal(random)};
    AxisLine axis;
    axis.direction.v = (1.0 / norm(raw)) * raw;
    axis.point.v = {normal(random), normal(random), normal(random)};
    const double angle = normal(random);
    const auto turn = turned(axis, std::sin(angle), std::cos(angle));
    return {turn.rotation, turn.translation + Vec3{normal(random), normal(random), normal(random)}};
}

void expect_near(const Vec3& a, const Vec3& b, double tolerance) {
    EXPECT_NEAR(a.x, b.x, tolerance);
    EXPECT_NEAR(a.y, b.y, tolerance);
    EXPECT_NEAR(a.z, b.z, tolerance);
}

TEST(Rigid, InverseUndoesIt) {
    std::mt19937_64 random(3);
    for (int i = 0; i < 200; ++i) {
        const auto h_from_c = random_transform(random);
        const Point<frame::C> p{{0.1, -2.0, 0.7}};
        expect_near((h_from_c.inverse() * (h_from_c * p)).v, p.v, 1e-13);
        EXPECT_LT(orthogonality_error(h_from_c.rotation), 1e-14);
        EXPECT_NEAR(h_from_c.rotation.determinant(), 1.0, 1e-14);
    }
}

TEST(Rigid, CompositionAppliesTheRightHandOneFirst) {
    std::mt19937_64 random(4);
    const auto h_from_c = random_transform(random);
    const auto other = random_transform(random);
    const Rigid<frame::C, frame::W> c_from_w{other.rotation, other.translation};
    const Point<frame::W> p{{0.3, 0.2, -0.1}};
    expect_near(((h_from_c * c_from_w) * p).v, (h_from_c * (c_from_w * p)).v, 1e-14);
}

TEST(Rigid, DirectionsRotateAndDoNotShift) {
    const Rigid<frame::H, frame::C> shift{Mat3::identity(), {1.0, 2.0, 3.0}};
    EXPECT_EQ((shift * Direction<frame::C>{{0.0, 1.0, 0.0}}).v, (Vec3{0.0, 1.0, 0.0}));
}

TEST(AxisLine, TurnsCounterClockwiseSeenFromAbove) {
    AxisLine axis;
    axis.point.v = {1.0, 2.0, 0.0};
    // A quarter turn about +z takes +x to +y.
    const auto turn = turned(axis, 1.0, 0.0);
    expect_near((turn * Point<frame::T>{{2.0, 2.0, 5.0}}).v, {1.0, 3.0, 5.0}, 1e-15);
    expect_near((turn * Point<frame::T>{{1.0, 2.0, -1.0}}).v, {1.0, 2.0, -1.0}, 1e-15);
}

}  // namespace
}  // namespace sc

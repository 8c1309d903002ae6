// SPDX-License-Identifier: Apache-2.0
#include "host/verification/path_follower.hpp"

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "synthetic_burns.hpp"

namespace sc::host {
namespace {

using synthetic::Burner;

constexpr AxisLine kAxis{{{synthetic::kAxisX, synthetic::kAxisY, 0.0}}, {{0.0, 0.0, 1.0}}};
constexpr Vec3 kCentre{-0.25, -0.30, -0.40};
constexpr double kRadius = 5e-3;

Vec3 on_circle(double phi, double radius = kRadius) {
    return kCentre + Vec3{radius * std::cos(phi), 0.0, radius * std::sin(phi)};
}

/// A half circle round a marker whose cross its ends touch, and that cross.
JobPlan plan() {
    JobPlan plan;
    plan.faces = {90.0};
    PlannedPath arc;
    arc.id = 2;
    arc.face_deg = 90.0;
    arc.kind = PathKind::free_path;
    arc.name = "half";
    arc.from = {on_circle(0.0)};
    arc.to = {on_circle(std::numbers::pi)};
    arc.pieces = {{arc.from.v, arc.to.v, circle_through(arc.from.v, on_circle(1.0), arc.to.v), 0}};
    arc.settings.pitch = Length::from_si(20e-6);
    PlannedPath stroke;
    stroke.face_deg = 90.0;
    stroke.centre = {kCentre};
    stroke.from = {kCentre - Vec3{6e-3, 0.0, 0.0}};
    stroke.to = {kCentre + Vec3{6e-3, 0.0, 0.0}};
    stroke.settings.pitch = Length::from_si(20e-6);
    plan.paths = {stroke, arc};
    return plan;
}

void burn_arc(Burner& burner, double from, double to, double radius) {
    const double step = 20e-6 / kRadius;
    for (double phi = from; phi <= to; phi += step) {
        burner.wait(80'000);
        burner.pulse(on_circle(phi, radius));
    }
    burner.wait(200'000'000);
}

Burner burnt(double to, double off) {
    Burner burner;
    burner.c_deg = -90.0;
    burner.roughness = [](const Vec3& p) { return 30e-6 * std::sin(4e2 * p.x); };
    burner.stroke(plan().paths[0].from.v, plan().paths[0].to.v);
    burner.wait(200'000'000);
    burn_arc(burner, 0.0, to, kRadius + off);
    return burner;
}

TEST(PathFollower, TellsAnArcFromTheCrossThatItMeets) {
    const Burner burner = burnt(std::numbers::pi, 4e-6);
    const FollowedPaths followed = follow_paths(burner.pulses, kAxis, plan());
    ASSERT_EQ(followed.paths.size(), 1U);
    const PathAccuracy& half = followed.paths[0];
    EXPECT_EQ(half.name, "half");
    EXPECT_EQ(half.path, 2U);
    EXPECT_EQ(followed.others.size(), 601U) << "the stroke, whole";
    EXPECT_EQ(half.pulses + 601U, burner.pulses.size());
    EXPECT_NEAR(half.max, 4e-6, 1e-9);
    EXPECT_NEAR(half.rms, 4e-6, 1e-9);
    EXPECT_TRUE(half.whole);
}

TEST(PathFollower, SaysWhenAStretchIsDark) {
    const Burner burner = burnt(3.0, 0.0);
    const FollowedPaths followed = follow_paths(burner.pulses, kAxis, plan());
    EXPECT_FALSE(followed.paths[0].whole);
    EXPECT_NEAR(followed.paths[0].largest_gap, (std::numbers::pi - 3.0) * kRadius, 25e-6);
    EXPECT_FALSE(follow_paths({}, kAxis, plan()).paths[0].whole) << "nothing at all";
}

TEST(PathFollower, LeavesWhatIsFarFromEveryPath) {
    Burner burner;
    burner.c_deg = -90.0;
    burner.stroke(kCentre + Vec3{0.05, 0.0, 0.03}, kCentre + Vec3{0.06, 0.0, 0.03});
    const FollowedPaths followed = follow_paths(burner.pulses, kAxis, plan());
    EXPECT_EQ(followed.others.size(), burner.pulses.size());
    EXPECT_EQ(followed.paths[0].pulses, 0U);
}

TEST(PathFollower, AJobWithoutFreePathsKeepsItsPulses) {
    JobPlan crosses = plan();
    crosses.paths.pop_back();
    const Burner burner = burnt(1.0, 0.0);
    const FollowedPaths followed = follow_paths(burner.pulses, kAxis, crosses);
    EXPECT_TRUE(followed.paths.empty());
    EXPECT_EQ(followed.others.size(), burner.pulses.size());
}

}  // namespace
}  // namespace sc::host

// SPDX-License-Identifier: Apache-2.0
#include "host/calibration/marker_identity.hpp"

#include <cmath>
#include <random>

#include <gtest/gtest.h>

namespace sc::host {
namespace {

Target random_target(int count, unsigned seed) {
    std::mt19937_64 random(seed);
    std::uniform_real_distribution<double> even(-0.1, 0.1);
    Target out;
    out.id = "t";
    for (int i = 0; i < count; ++i) {
        out.markers.push_back({.id = 100 + i, .place = {even(random), 0.005 * (i % 3), even(random)}, .sigma = 2e-6});
    }
    return out;
}

/// A quarter turn about x, then a shift.
Vec3 moved(const Vec3& p) { return Vec3{p.x, -p.z, p.y} + Vec3{0.03, -0.02, 0.5}; }

std::vector<PlacedMarker> seen(const Target& target, std::size_t first) {
    std::mt19937_64 random(9);
    std::normal_distribution<double> noise(0.0, 8e-6);
    std::vector<PlacedMarker> out;
    for (std::size_t i = first; i < target.markers.size(); ++i) {
        const Vec3 at = moved(target.markers[i].place);
        out.push_back({.place = {at.x + noise(random), at.y + noise(random), at.z + noise(random)}, .sigma = 1e-5});
    }
    return out;
}

TEST(MarkerIdentity, TellsMarkersApartThoughSomeAreMissingAndSomeAreFalse) {
    const Target target = random_target(20, 3);
    auto places = seen(target, 6);  // six are missing
    places.insert(places.begin(), {.place = {0.4, 0.3, 0.9}, .sigma = 1e-5});
    places.push_back({.place = {0.02, 0.01, 0.47}, .sigma = 1e-5});
    const auto found = identify_markers(target, places);
    ASSERT_TRUE(found) << found.error();
    EXPECT_FALSE(found->ids.front());
    EXPECT_FALSE(found->ids.back());
    for (std::size_t i = 1; i + 1 < places.size(); ++i) {
        ASSERT_TRUE(found->ids[i]);
        EXPECT_EQ(*found->ids[i], static_cast<int>(105 + i));
    }
    EXPECT_EQ(found->missing, (std::vector<int>{100, 101, 102, 103, 104, 105}));
    EXPECT_LT(found->rms, 2.5e-5);
    EXPECT_NEAR(found->translation.z, 0.5, 1e-4);
}

TEST(MarkerIdentity, RefusesALayoutThatLooksTheSameWhenTurned) {
    Target grid;
    grid.id = "grid";
    for (int i = 0; i < 12; ++i) {
        grid.markers.push_back({.id = i, .place = {0.02 * (i % 4), 0.0, 0.02 * (i / 4)}, .sigma = 0.0});
    }
    const auto found = identify_markers(grid, seen(grid, 0));
    ASSERT_FALSE(found);
    EXPECT_NE(found.error().find("ambiguous"), std::string::npos) << found.error();
    grid.markers.back().place = grid.markers.back().place + Vec3{0.006, 0.0, 0.003};  // one aside: unique
    EXPECT_TRUE(identify_markers(grid, seen(grid, 0)));
}

TEST(MarkerIdentity, RefusesAnotherTargetAndTooFewMarkers) {
    const Target target = random_target(12, 3);
    const auto other = identify_markers(target, seen(random_target(12, 4), 0));
    ASSERT_FALSE(other);
    EXPECT_NE(other.error().find("not recognised"), std::string::npos) << other.error();
    EXPECT_FALSE(identify_markers(target, seen(target, 9)));
    EXPECT_FALSE(identify_markers(target, {}));
}

}  // namespace
}  // namespace sc::host

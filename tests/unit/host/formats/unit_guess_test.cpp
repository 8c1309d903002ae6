// SPDX-License-Identifier: Apache-2.0
#include "host/formats/unit_guess.hpp"

#include <vector>

#include <gtest/gtest.h>

namespace sc::host {
namespace {

const std::vector<Vec3> kPlaces{{-314.09, -319.77, -425.944}, {-150.584, -318.478, -406.606}, {-211.2, -283.8, -323.0}};

std::vector<Vec3> scaled(double factor) {
    std::vector<Vec3> out;
    for (const Vec3& v : kPlaces) {
        out.push_back(factor * v);
    }
    return out;
}

std::string_view name_in_h(const std::vector<Vec3>& places) {
    const auto guess = guess_unit_in_h(places, reference_machine());
    return guess ? guess->name : "";
}

TEST(GuessUnitInH, KnowsMillimetresMetresAndInches) {
    EXPECT_EQ(name_in_h(kPlaces), "");
    EXPECT_EQ(name_in_h(scaled(1e-3)), "metres");
    EXPECT_EQ(name_in_h(scaled(1.0 / 25.4)), "inches");
    EXPECT_EQ(name_in_h({}), "");
}

TEST(GuessUnitInH, JudgesNoTableByOnePlace) {
    std::vector<Vec3> mixed = kPlaces;
    mixed.push_back({-0.3, -0.3, -0.4});
    EXPECT_EQ(name_in_h(mixed), "") << "one small place among real ones";
    mixed = scaled(1.0 / 25.4);
    mixed.push_back({-400.0, -300.0, -300.0});
    EXPECT_EQ(name_in_h(mixed), "");
}

TEST(GuessUnitInH, SaysNothingOfPlacesThatFitInNoUnit) {
    EXPECT_EQ(name_in_h({{1e9, 1e9, 1e9}}), "");
    EXPECT_EQ(name_in_h({{700.0, -300.0, -300.0}}), "") << "out of travel is another complaint";
}

TEST(GuessUnit, LeavesSmallNumbersAloneWhereZeroMayLieInTheData) {
    const std::vector<Vec3> small{{0.1, 0.2, 0.3}, {-0.4, 0.1, 0.0}};
    const auto anywhere = [](const Vec3&) { return true; };
    EXPECT_FALSE(guess_unit(small, 0.0, anywhere));
    ASSERT_TRUE(guess_unit(small, 10.0, anywhere));
    EXPECT_EQ(guess_unit(small, 10.0, anywhere)->millimetres, 1000.0);
    // A far-off frame: only inches bring these into reach.
    const auto reach = [](const Vec3& v) { return v.z > 0.7 && v.z < 1.2; };
    ASSERT_TRUE(guess_unit(std::vector<Vec3>{{1.0, 2.0, 35.0}, {1.0, 2.0, 36.0}}, 0.0, reach));
    EXPECT_EQ(guess_unit(std::vector<Vec3>{{1.0, 2.0, 35.0}, {1.0, 2.0, 36.0}}, 0.0, reach)->name, "inches");
}

}  // namespace
}  // namespace sc::host

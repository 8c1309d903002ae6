// SPDX-License-Identifier: Apache-2.0
#include "host/verification/world_errors.hpp"

#include <algorithm>

#include <gtest/gtest.h>

namespace sc::host {
namespace {

const std::vector<KnownError> kErrors{{"axes.squareness_xz", 0.1, "mrad", "calibration: axes"},
                                      {"axes.scale_z", 15.0, "ppm", "calibration: axes"},
                                      {"galvo.offset_x", 85.0, "um", "calibration: galvo field"},
                                      {"galvo.gain_x", 1.003, "1", "calibration: galvo field"},
                                      {"turntable.axis_x", -250.018, "mm", "calibration: turntable axis"},
                                      {"turntable.runout", 0.5, "um", "none"}};

CalibrationSet calibration() {
    CalibrationSet set;
    AxesRecord axes;
    axes.squareness_xz = 0.08e-3;
    axes.scale = {0.0, 0.0, 14e-6};
    set.axes = axes;
    GalvoRecord galvo;
    galvo.offset = {35e-6, 0.0};
    galvo.matrix = {1.002, 0.0, 0.0, 1.0};
    set.galvo = galvo;
    AxisRecord axis;
    axis.line = {{{-0.2502, -0.47, 0.1}}, {{1e-3, 0.0, 1.0}}};
    set.turntable = axis;
    return set;
}

const ErrorBalance& line_of(const std::vector<ErrorBalance>& list, std::string_view name) {
    return *std::ranges::find_if(list, [name](const ErrorBalance& line) { return line.error.name == name; });
}

TEST(ErrorBalance, TellsWhatCalibrationLeaves) {
    const std::vector<ErrorBalance> list = balance(kErrors, calibration());
    ASSERT_EQ(list.size(), kErrors.size());
    EXPECT_NEAR(line_of(list, "axes.squareness_xz").left, 0.02, 1e-12);
    EXPECT_NEAR(line_of(list, "axes.scale_z").left, 1.0, 1e-9);
    EXPECT_NEAR(line_of(list, "galvo.offset_x").left, 50.0, 1e-9);
    EXPECT_NEAR(line_of(list, "galvo.gain_x").left, 0.001, 1e-12);
    // The calibrated axis passes z = 0 at x = −250.3 mm.
    EXPECT_NEAR(line_of(list, "turntable.axis_x").left, 0.282, 1e-9);
    EXPECT_EQ(line_of(list, "turntable.runout").left, 0.5);
    EXPECT_FALSE(line_of(list, "turntable.runout").calibrated);
    EXPECT_FALSE(line_of(list, "turntable.runout").foretold);
    EXPECT_TRUE(line_of(list, "galvo.offset_x").foretold);
}

TEST(ErrorBalance, LeavesAllWithoutCalibration) {
    const std::vector<ErrorBalance> list = balance(kErrors, CalibrationSet{});
    EXPECT_EQ(line_of(list, "galvo.offset_x").left, 85.0);
    EXPECT_NEAR(line_of(list, "galvo.gain_x").left, 0.003, 1e-12);
}

TEST(Foretell, IsThePlaceItselfInAPerfectWorld) {
    const Vec3 place{-0.3, -0.31, -0.4};
    EXPECT_LT(norm(foretell({}, {}, place, Actuator::galvo, {-0.301, -0.31, -0.401}) - place), 1e-15);
    EXPECT_LT(norm(foretell({}, {}, place, Actuator::axes, place) - place), 1e-15);
}

TEST(Foretell, ErrorsThatCalibrationKnowsCancel) {
    CalibrationSet set = calibration();
    set.axes->squareness_xz = 0.1e-3;
    set.axes->scale[2] = 15e-6;
    set.galvo->offset[0] = 85e-6;
    set.galvo->matrix[0] = 1.003;
    const Vec3 place{-0.3, -0.31, -0.4};
    const Vec3 anchor{-0.302, -0.31, -0.401};
    const Vec3 lands = foretell(machine_truth(kErrors), compensation_of(set), place, Actuator::galvo, anchor);
    EXPECT_LT(norm(lands - place), 1e-12);
}

TEST(Foretell, WhatIsLeftShowsWhereItActs) {
    const std::vector<KnownError> errors{{"axes.squareness_xz", 0.1, "mrad", ""}, {"galvo.offset_x", 50.0, "um", ""}};
    const Vec3 place{-0.3, -0.31, -0.4};
    const Vec3 moved = foretell(machine_truth(errors), {}, place, Actuator::galvo, place) - place;
    EXPECT_NEAR(moved.x, 50e-6 - 40e-6, 1e-12);
    EXPECT_NEAR(moved.y, 0.0, 1e-15);
    EXPECT_NEAR(moved.z, 0.0, 1e-15);
}

}  // namespace
}  // namespace sc::host

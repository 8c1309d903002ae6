// SPDX-License-Identifier: Apache-2.0
#include "host/formats/lag_plate.hpp"

#include <string>

#include <gtest/gtest.h>

#include "host/formats/error.hpp"
#include "support.hpp"

namespace sc::host {
namespace {

using test::TempDir;

LagPlan plan_of_two() {
    LagPlan plan;
    plan.told = {160'500, Frequency::from_si(2000.125), 0.75};
    plan.lines.push_back({.no = 1,
                          .along_x = true,
                          .way = 1,
                          .start = {-0.008, 0.002},
                          .run = 0.016,
                          .amplitude = 0.0,
                          .wavelength = 0.0,
                          .speed = 2.0,
                          .pitch = 1e-4,
                          .anchor = {-0.225, -0.21, -0.25}});
    plan.lines.push_back(plan.lines[0]);
    plan.lines[1].no = 2;
    plan.lines[1].along_x = false;
    plan.lines[1].way = -1;
    plan.lines[1].amplitude = 2.37e-4;
    plan.lines[1].wavelength = 1.875e-3;
    return plan;
}

TEST(LagPlate, PlanGoesThereAndBack) {
    const TempDir dir;
    write_lag_plan(dir.path() / "plan.csv", plan_of_two());
    const LagPlan back = read_lag_plan(dir.path() / "plan.csv");
    ASSERT_EQ(back.lines.size(), 2U);
    EXPECT_EQ(back.told, plan_of_two().told);
    EXPECT_EQ(back.lines[1].way, -1);
    EXPECT_FALSE(back.lines[1].along_x);
    EXPECT_NEAR(back.lines[1].wavelength, 1.875e-3, 1e-12);
    EXPECT_NEAR(back.lines[1].amplitude, 2.37e-4, 1e-12);
    EXPECT_NEAR(back.lines[0].start[1], 0.002, 1e-12);
    EXPECT_NEAR(back.lines[0].speed, 2.0, 1e-12);
}

TEST(LagPlate, RefusesAPlanThatIsNone) {
    const TempDir dir;
    write_lag_plan(dir.path() / "plan.csv", plan_of_two());
    const std::string good = test::slurp(dir.path() / "plan.csv");
    const auto refused = [&](const std::string& from, const std::string& to) {
        const auto file = dir.write("bad.csv", test::replaced(good, from, to));
        EXPECT_THROW(static_cast<void>(read_lag_plan(file)), InputError) << to;
    };
    refused("\n2,z,-1,", "\n1,z,-1,");
    refused("\n2,z,-1,", "\n2,y,-1,");
    refused("\n2,z,-1,", "\n2,z,0,");
    refused("0.237000,1.875000", "0.237000,0.000000");
    refused("16.000000,0.000000,0.000000", "0.000000,0.000000,0.000000");
    refused("0.750000\n2,", "0.800000\n2,");
    refused("told_damping", "damping");
    EXPECT_NO_THROW(static_cast<void>(read_lag_plan(dir.write("good.csv", good))));
}

TEST(LagPlate, ReadsMarksAndRefusesWhatIsNone) {
    const TempDir dir;
    const auto marks =
        read_lag_marks(dir.write("m.csv", "line,mark,x,y,z,sigma\n3,0,-225.5,-210,-250.25,0.0075\n3,1,0,0,0,1\n"));
    ASSERT_EQ(marks.size(), 2U);
    EXPECT_EQ(marks[0].line, 3);
    EXPECT_DOUBLE_EQ(marks[0].place.z, -0.25025);
    EXPECT_DOUBLE_EQ(marks[0].sigma, 7.5e-6);
    for (const char* text :
         {"line,mark,x,y,z\n1,0,0,0,0\n", "line,mark,x,y,z,sigma\n", "line,mark,x,y,z,sigma\n1,0,0,0,0,0\n",
          "line,mark,x,y,z,sigma\n1,-1,0,0,0,1\n", "line,mark,x,y,z,sigma\n1,0,0,0,0,1\n1,0,0,0,0,1\n",
          "line,mark,x,y,z,sigma\n0,0,0,0,0,1\n", "line,mark,x,y,z,sigma\n1,0,1e9,0,0,1\n"}) {
        EXPECT_THROW(static_cast<void>(read_lag_marks(dir.write("bad.csv", text))), InputError) << text;
    }
}

}  // namespace
}  // namespace sc::host

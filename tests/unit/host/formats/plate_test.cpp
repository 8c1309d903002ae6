// SPDX-License-Identifier: Apache-2.0
#include "host/formats/plate.hpp"

#include <gtest/gtest.h>

#include "host/formats/error.hpp"
#include "support.hpp"

namespace sc::host {
namespace {

using test::TempDir;

TEST(Plate, PlanGoesThereAndBack) {
    const TempDir dir;
    const std::vector<PlateCross> crosses{{1, {-0.05, 0.012345}, {-0.225, -0.21, -0.25}}, {7, {0.0, 0.0}, {0, 0, 0}}};
    write_plate_plan(dir.path() / "plan.csv", crosses);
    const auto back = read_plate_plan(dir.path() / "plan.csv");
    ASSERT_EQ(back.size(), 2U);
    EXPECT_EQ(back[1].no, 7);
    EXPECT_NEAR(back[0].command[1], 0.012345, 1e-12);
    EXPECT_NEAR(back[0].anchor.x, -0.225, 1e-12);
}

TEST(Plate, ReadsMeasuredCrosses) {
    const TempDir dir;
    const auto file = dir.write("m.csv", "no,x,y,z,sigma\n3,-225.5,-210,-250.25,0.0075\n");
    const auto crosses = read_measured_crosses(file);
    ASSERT_EQ(crosses.size(), 1U);
    EXPECT_EQ(crosses[0].no, 3);
    EXPECT_DOUBLE_EQ(crosses[0].place.z, -0.25025);
    EXPECT_DOUBLE_EQ(crosses[0].sigma, 7.5e-6);
}

TEST(Plate, RefusesWhatIsNoMeasurement) {
    const TempDir dir;
    for (const char* text :
         {"no,x,y,z\n1,0,0,0\n", "no,x,y,z,sigma\n", "no,x,y,z,sigma\n1,0,0,0,0\n", "no,x,y,z,sigma\n1,0,0,0,-1\n",
          "no,x,y,z,sigma\n1,0,0,0,1\n1,0,0,0,1\n", "no,x,y,z,sigma\n1,1e9,0,0,1\n",
          "no,x,y,z,sigma,who\n1,0,0,0,1,me\n", "no,x,y,z,sigma\n1,nan,0,0,1\n"}) {
        EXPECT_THROW(static_cast<void>(read_measured_crosses(dir.write("m.csv", text))), InputError) << text;
    }
}

}  // namespace
}  // namespace sc::host

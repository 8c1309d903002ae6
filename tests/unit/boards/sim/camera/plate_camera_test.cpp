// SPDX-License-Identifier: Apache-2.0
#include "boards/sim/camera/plate_camera.hpp"

#include <cmath>
#include <cstdio>
#include <sstream>
#include <stdexcept>

#include <gtest/gtest.h>

namespace sc::sim {
namespace {

/// Appends the marks of a stroke of 2 mm through (x, z), turned by `angle`; mm.
void stroke(std::vector<trace::PulseRecord>& pulses, double x, double z, double angle) {
    std::int64_t t = pulses.empty() ? 0 : pulses.back().t_ns + 5'000'000;
    for (int i = -50; i <= 50; ++i) {
        trace::PulseRecord pulse;
        pulse.t_ns = t;
        pulse.hit = 1;
        const double way = 0.02 * i;
        pulse.place_pm = {std::llround((x + way * std::cos(angle)) * 1e9), -210'000'000'000,
                          std::llround((z + way * std::sin(angle)) * 1e9)};
        pulses.push_back(pulse);
        t += 80'000;
    }
}

TEST(PlateCamera, FindsWhereTheStrokesOfACrossMeet) {
    std::vector<trace::PulseRecord> pulses;
    stroke(pulses, -220.0, -250.0, 0.01);
    stroke(pulses, -220.0, -250.0, 1.59);
    stroke(pulses, -200.3, -240.0, 0.0);
    stroke(pulses, -200.0, -240.0, 1.5707963);
    const auto crosses = find_plate_crosses(pulses);
    ASSERT_EQ(crosses.size(), 2U);
    EXPECT_NEAR(crosses[0].place.x, -0.220, 1e-9);
    EXPECT_NEAR(crosses[0].place.y, -0.210, 1e-12);
    EXPECT_NEAR(crosses[0].place.z, -0.250, 1e-9);
    EXPECT_NEAR(crosses[1].place.x, -0.200, 1e-9);
}

TEST(PlateCamera, RefusesWhatIsNoCross) {
    std::vector<trace::PulseRecord> pulses;
    stroke(pulses, 0.0, 0.0, 0.0);
    EXPECT_THROW(static_cast<void>(find_plate_crosses(pulses)), std::runtime_error) << "one stroke";
    stroke(pulses, 0.0, 0.0, 0.1);
    EXPECT_THROW(static_cast<void>(find_plate_crosses(pulses)), std::runtime_error) << "nearly parallel";
    for (auto& pulse : pulses) {
        pulse.hit = 2;
    }
    EXPECT_TRUE(find_plate_crosses(pulses).empty()) << "too weak to be seen";
}

TEST(PlateCamera, ItsNoiseIsThatWhichItStates) {
    const std::vector<SeenCross> crosses(4000);
    std::istringstream csv(measured_csv(crosses, 7.5e-6, 9));
    std::string line;
    std::getline(csv, line);
    EXPECT_EQ(line, "no,x,y,z,sigma");
    double squares = 0.0;
    int rows = 0;
    while (std::getline(csv, line)) {
        double x = 0.0;
        double z = 0.0;
        double sigma = 0.0;
        double y = 0.0;
        int no = 0;
        ASSERT_EQ(std::sscanf(line.c_str(), "%d,%lf,%lf,%lf,%lf", &no, &x, &y, &z, &sigma), 5);
        EXPECT_DOUBLE_EQ(sigma, 0.0075);
        squares += x * x + z * z;
        ++rows;
    }
    EXPECT_EQ(rows, 4000);
    EXPECT_NEAR(std::sqrt(squares / (2.0 * rows)), 0.0075, 0.0002);
    EXPECT_EQ(measured_csv(crosses, 7.5e-6, 9), measured_csv(crosses, 7.5e-6, 9));
    EXPECT_NE(measured_csv(crosses, 7.5e-6, 9), measured_csv(crosses, 7.5e-6, 10));
}

}  // namespace
}  // namespace sc::sim

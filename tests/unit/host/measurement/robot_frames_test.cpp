// SPDX-License-Identifier: Apache-2.0
#include "host/measurement/robot_frames.hpp"

#include <cmath>
#include <numbers>
#include <random>

#include <gtest/gtest.h>

#include "host/measurement/correction.hpp"

namespace sc::host {
namespace {

constexpr double kDegree = std::numbers::pi / 180.0;

/// Rz(a)·Ry(b)·Rx(c), written out.
Mat3 from_abc(double a, double b, double c) {
    const double sa = std::sin(a), ca = std::cos(a), sb = std::sin(b), cb = std::cos(b), sc = std::sin(c),
                 cc = std::cos(c);
    return {{Vec3{ca * cb, ca * sb * sc - sa * cc, ca * sb * cc + sa * sc},
             Vec3{sa * cb, sa * sb * sc + ca * cc, sa * sb * cc - ca * sc}, Vec3{-sb, cb * sc, cb * cc}}};
}

TEST(RobotFrames, AnglesAndQuaternionsGiveTheRotationBack) {
    std::mt19937_64 random(7);
    std::uniform_real_distribution<double> even(-1.0, 1.0);
    for (int k = 0; k < 500; ++k) {
        const double a = 179.0 * kDegree * even(random);
        const double b = 89.0 * kDegree * even(random);
        const double c = 179.0 * kDegree * even(random);
        const Mat3 m = from_abc(a, b, c);
        const auto abc = abc_of(m);
        EXPECT_NEAR(abc[0], a, 1e-9);
        EXPECT_NEAR(abc[1], b, 1e-9);
        EXPECT_NEAR(abc[2], c, 1e-9);
        const auto q = quaternion_of(m);
        EXPECT_GE(q[0], 0.0);
        EXPECT_NEAR(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3], 1.0, 1e-12);
        EXPECT_NEAR(1.0 - 2.0 * (q[2] * q[2] + q[3] * q[3]), m.row[0].x, 1e-9);
        EXPECT_NEAR(2.0 * (q[1] * q[2] + q[0] * q[3]), m.row[1].x, 1e-9);
        EXPECT_NEAR(2.0 * (q[1] * q[3] - q[0] * q[2]), m.row[2].x, 1e-9);
        EXPECT_NEAR(2.0 * (q[2] * q[3] + q[0] * q[1]), m.row[2].y, 1e-9);
    }
}

TEST(RobotFrames, AFaceOnItsTargetIsWhereTheProgramExpectsIt) {
    StationResult result;
    result.id = "bar 7";
    result.rail = 1.5;
    result.normal = normal_of(80.0 * kDegree, 0.0);
    result.distance = 0.3;
    result.at = {0.01, 0.09};
    const StationTarget target{.same = false, .angle = 80.0 * kDegree, .yaw = 0.0, .distance = 0.3};
    StationRobot robot;
    robot.translation = {1.0, 2.0, 0.5};
    robot.rail = {0.0, 1.0, 0.0};
    const StationFrame frame = frame_of(result, target, robot, 3);
    EXPECT_NEAR(frame.translation.x, 1.3, 1e-12);
    EXPECT_NEAR(frame.translation.y, 3.51, 1e-12);
    EXPECT_NEAR(frame.translation.z, 0.59, 1e-12);
    EXPECT_NEAR(norm(frame.translation - frame.nominal_translation), 0.0, 1e-15);
    // Its x runs into the face, against the normal.
    EXPECT_NEAR(norm(frame.rotation * Vec3{1.0, 0.0, 0.0} + result.normal), 0.0, 1e-12);
    const std::array frames{frame};
    EXPECT_NE(frames_kuka(frames).find("BASE_DATA[3]={X 1300.0000,Y 3510.0000,Z 590.0000,A "), std::string::npos);
    EXPECT_NE(frames_abb(frames).find("wobj_bar_7:=[FALSE,TRUE,\"\",[[1300.0000,3510.0000,590.0000],["),
              std::string::npos);
    EXPECT_NE(frames_fanuc(frames).find("UFRAME[3]=PR[3]"), std::string::npos);
    EXPECT_NE(frames_csv(frames).find("bar 7,3,1300.0000,3510.0000,590.0000,"), std::string::npos);
}

}  // namespace
}  // namespace sc::host

// SPDX-License-Identifier: Apache-2.0
#include "host/formats/poses.hpp"

#include <cmath>

#include <gtest/gtest.h>

#include "tests/unit/host/formats/support.hpp"

namespace sc::host {
namespace {

using test::expect_refusal;
using test::TempDir;

void expect_near(const Mat3& a, const Mat3& b, double tolerance) {
    for (std::size_t r = 0; r < 3; ++r) {
        for (std::size_t c = 0; c < 3; ++c) {
            EXPECT_NEAR(a.row[r][c], b.row[r][c], tolerance) << r << c;
        }
    }
}

// Worked by hand: 90 degrees about z, then (in the turned frame) 90 about x: x to y, y to z, z to x.
const Mat3 kCycle{{Vec3{0.0, 0.0, 1.0}, Vec3{1.0, 0.0, 0.0}, Vec3{0.0, 1.0, 0.0}}};

TEST(Poses, EachConventionGivesTheSameRotation) {
    const TempDir dir;
    for (const char* text : {
             "view,x_mm,y_mm,z_mm,qw,qx,qy,qz\na,1,2,3,0.5,0.5,0.5,0.5\n",
             "view,qx,qy,qz,qw,x_m,y_m,z_m\na,-0.5,-0.5,-0.5,-0.5,0.001,0.002,0.003\n",
             "view,x_mm,y_mm,z_mm,q1,q2,q3,q4\na,1,2,3,0.5,0.5,0.5,0.5\n",
             "view,x_mm,y_mm,z_mm,r11,r12,r13,r21,r22,r23,r31,r32,r33\na,1,2,3,0,0,1,1,0,0,0,1,0\n",
             "view,X_mm,Y_mm,Z_mm,A,B,C\na,1,2,3,90,0,90\n",
             "view,x_mm,y_mm,z_mm,w_deg,p_deg,r_deg\na,1,2,3,90,0,90\n",
             "view,x_inch,y_inch,z_inch,w,p,r\na,0.03937007874015748,0.07874015748031496,0.11811023622047244,90,0,90\n",
         }) {
        const PoseFile file = read_poses(dir.write("poses.csv", text));
        ASSERT_EQ(file.poses.size(), 1U);
        EXPECT_EQ(file.poses[0].view, "a");
        EXPECT_EQ(file.poses[0].line, 2);
        expect_near(file.poses[0].rotation, kCycle, 1e-12);
        EXPECT_NEAR(file.poses[0].translation.x, 1e-3, 1e-15);
        EXPECT_NEAR(file.poses[0].translation.y, 2e-3, 1e-15);
        EXPECT_NEAR(file.poses[0].translation.z, 3e-3, 1e-15);
    }
}

TEST(Poses, KukaAndFanucTurnAboutZThenYThenX) {
    // Rz(90)·Ry(30): x of the tool points along (0, cos 30, -sin 30).
    const Mat3 m = rotation_of_zyx(std::acos(0.0), std::acos(0.0) / 3.0, 0.0);
    EXPECT_NEAR(m.row[0].x, 0.0, 1e-15);
    EXPECT_NEAR(m.row[1].x, std::sqrt(0.75), 1e-15);
    EXPECT_NEAR(m.row[2].x, -0.5, 1e-15);
}

TEST(Poses, FileWithoutAHeaderTakesItsNamesAndUnitFromTheCaller) {
    const TempDir dir;
    const auto path = dir.write("p.csv", "10.5,1,2,3,0,0,0,1\n10.7,1,2,4,0,0,0,1\n");
    const PoseFile file = read_poses(path, {.columns = "time_s,x,y,z,qx,qy,qz,qw", .unit = "m"});
    ASSERT_EQ(file.poses.size(), 2U);
    EXPECT_EQ(file.poses[1].line, 2);
    EXPECT_EQ(file.poses[1].time, 10.7);
    EXPECT_EQ(file.poses[1].translation.z, 4.0);
}

TEST(Poses, RefusesWhatIsNoPose) {
    const TempDir dir;
    const auto refused = [&](const char* text, int line, const char* value, const char* problem,
                             const PoseFileWords& words = {}) {
        const auto path = dir.write("p.csv", text);
        expect_refusal([&] { static_cast<void>(read_poses(path, words)); },
                       {.file = path.string(), .line = line, .value = value, .problem = problem});
    };
    refused("view,x,y,z,a,b,c\na,1,2,3,0,0,0\n", 1, "x", "unit is not known");
    refused("view,x,y,z,a,b,c\na,1,2,3,0,0,0\n", 1, "furlong", "no unit of length", {.columns = "", .unit = "furlong"});
    refused("view,x_mm,y_m,z_mm,a,b,c\na,1,2,3,0,0,0\n", 1, "mm, m, mm", "mixed units");
    refused("view,x_mm,y_mm,z_mm,a,b,c,w,p,r\na,1,2,3,0,0,0,0,0,0\n", 1, "KUKA A,B,C, FANUC W,P,R", "twice");
    refused("view,x_mm,y_mm,z_mm,roll\na,1,2,3,0\n", 1, "", "no columns of a rotation");
    refused("view,x_mm,y_mm,z_mm,qw,qx,qy,qz\na,1,2,3,0.5,0.5,0.5,0.6\n", 2, "1.054", "no unit quaternion");
    refused("view,x_mm,y_mm,z_mm,r11,r12,r13,r21,r22,r23,r31,r32,r33\na,1,2,3,1,0,0,0,1,0,0,0,-1\n", 2, "-1",
            "left-handed");
    refused("view,x_mm,y_mm,z_mm,r11,r12,r13,r21,r22,r23,r31,r32,r33\na,1,2,3,1,0.1,0,0,1,0,0,0,1\n", 2, "0.1",
            "not orthonormal");
    refused("view,x_m,y_m,z_m,a,b,c\na,617.7,32,891,0,0,0\n", 2, "617.7", "100 m away");
    refused("view,x_mm,y_mm,z_mm,a,b,c\na,1,2,3,0,0,0\na,1,2,3,0,0,0\n", 3, "a", "view appears twice");
    refused("view,x_mm,y_mm,z_mm,a,b,c,colour\na,1,2,3,0,0,0,1\n", 1, "colour", "unknown column");
    refused("view,x_mm,y_mm,z_mm,a,b,c\na,1,nan,3,0,0,0\n", 2, "nan", "not a finite number");
}

TEST(Poses, MarkersOfAViewHaveTheirNoiseByAxis) {
    const TempDir dir;
    const auto path = dir.write("m.csv",
                                "view,turn_deg,id,x_mm,y_mm,z_mm,sigma_x_um,sigma_y_um,sigma_z_um\n"
                                "1,90,4,1,2,3,5,6,7\n1,90,5,1,2,4,5,6,7\n2,180,4,0,0,0,1,1,1\n");
    EXPECT_TRUE(holds_markers(path));
    const MarkerFile file = read_marker_views(path);
    ASSERT_EQ(file.views.size(), 2U);
    ASSERT_EQ(file.views[0].markers.size(), 2U);
    EXPECT_EQ(file.views[0].markers[1].id, 5);
    EXPECT_NEAR(file.views[0].markers[1].sigma.z, 7e-6, 1e-18);
    EXPECT_NEAR(*file.views[1].turn, 2.0 * std::acos(0.0), 1e-15);
    expect_refusal(
        [&] {
            static_cast<void>(read_marker_views(dir.write("t.csv", "view,id,x_mm,y_mm,z_mm\n1,4,1,2,3\n1,4,1,2,3\n")));
        },
        {.file = (dir / "t.csv").string(), .line = 3, .value = "4", .problem = "marker appears twice"});
    expect_refusal(
        [&] {
            static_cast<void>(read_marker_views(dir.write("s.csv", "view,id,x_mm,y_mm,z_mm,sigma_um\n1,4,1,2,3,0\n")));
        },
        {.file = (dir / "s.csv").string(), .line = 2, .value = "0", .problem = "sigma"});
}

}  // namespace
}  // namespace sc::host

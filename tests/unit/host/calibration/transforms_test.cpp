// SPDX-License-Identifier: Apache-2.0
#include "host/calibration/transforms.hpp"

#include <cmath>
#include <random>

#include <gtest/gtest.h>

#include "host/formats/error.hpp"
#include "host/formats/points.hpp"
#include "host/formats/table.hpp"

namespace sc::host {
namespace {

const std::filesystem::path kFolder = SC_SOURCE_DIR "/examples/ras3dm";

TEST(HFromT, IsExactAtRightAngles) {
    const AxisLine axis{{{-0.25, -0.5, 0.0}}, {{0.0, 0.0, 1.0}}};
    const Mat3 quarter{{Vec3{0.0, -1.0, 0.0}, Vec3{1.0, 0.0, 0.0}, Vec3{0.0, 0.0, 1.0}}};
    for (const double c : {90.0, -270.0, 450.0, -630.0}) {
        EXPECT_EQ(h_from_t(axis, c).rotation, quarter) << c;
    }
    for (const double c : {0.0, 360.0, -360.0}) {
        EXPECT_EQ(h_from_t(axis, c).rotation, Mat3::identity()) << c;
        EXPECT_EQ(h_from_t(axis, c).translation, Vec3{}) << c;
    }
    EXPECT_EQ((h_from_t(axis, 180.0) * Point<frame::T>{{-0.15, -0.4, 0.3}}).v.z, 0.3);
}

TEST(HFromT, IsARotationThatKeepsTheAxis) {
    std::mt19937_64 random(11);
    std::uniform_real_distribution<double> any(-1.0, 1.0);
    for (int i = 0; i < 5000; ++i) {
        const Vec3 d{any(random), any(random), any(random)};
        const AxisLine axis{{{any(random), any(random), any(random)}}, {(1.0 / norm(d)) * d}};
        const double c = 720.0 * any(random);
        const auto turn = h_from_t(axis, c);
        ASSERT_LT(orthogonality_error(turn.rotation), 1e-14);
        ASSERT_NEAR(turn.rotation.determinant(), 1.0, 1e-14);
        const Vec3 on_axis = axis.point.v + any(random) * axis.direction.v;
        ASSERT_LT(norm((turn * Point<frame::T>{on_axis}).v - on_axis), 1e-14);
        const double trace = turn.rotation.row[0].x + turn.rotation.row[1].y + turn.rotation.row[2].z;
        ASSERT_NEAR(trace, 1.0 + 2.0 * std::cos(c * kPi / 180.0), 1e-12);
        const auto back = h_from_t(axis, -c);
        const Point<frame::T> p{{any(random), any(random), any(random)}};
        ASSERT_LT(norm((back * Point<frame::T>{(turn * p).v}).v - p.v), 1e-14);
    }
}

TEST(ToFace, AndBackIsTheSamePlace) {
    const CalibrationSet set = read_calibration(kFolder / "calibration.toml");
    std::mt19937_64 random(12);
    std::uniform_real_distribution<double> any(-1.0, 1.0);
    for (int i = 0; i < 1000; ++i) {
        const Point<frame::C> place{{any(random), any(random), any(random)}};
        const double face = 360.0 * any(random);
        ASSERT_LT(norm(from_face(set, to_face(set, place, face), face).v - place.v), 1e-11)
            << "the file's rotation has twelve digits";
    }
}

TEST(ToFace, TakesTheExamplesFace90BackToTheTable) {
    const CalibrationSet set = read_calibration(kFolder / "calibration.toml");
    const FacePoints points = read_points(kFolder / "face90_c.csv");
    const VerificationTable table = read_table(kFolder / "table1.csv");
    ASSERT_EQ(points.points.size(), 9U);
    std::size_t compared = 0;
    for (const TableRow& row : table.rows) {
        for (const FacePoint& point : points.points) {
            if (row.face_deg == 90.0 && row.no == point.no) {
                const Point<frame::H> h = to_face(set, Point<frame::C>{point.place}, 90.0);
                EXPECT_LT(norm(h.v - row.measured.v), 1e-7) << "the file holds 0.1 um";
                ++compared;
            }
        }
    }
    EXPECT_EQ(compared, 9U);
}

TEST(ToFace, NamesWhatTheCalibrationLacks) {
    CalibrationSet set;
    EXPECT_THROW(static_cast<void>(to_face(set, Point<frame::C>{}, 0.0)), InputError);
    set.transforms.push_back({.id = "h_from_c", .rotation = {}, .translation = {}, .covariance = {}, .provenance = {}});
    EXPECT_THROW(static_cast<void>(to_face(set, Point<frame::C>{}, 0.0)), InputError);
}

}  // namespace
}  // namespace sc::host

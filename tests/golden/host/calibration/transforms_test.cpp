// SPDX-License-Identifier: Apache-2.0
#include "host/calibration/transforms.hpp"

#include <fstream>
#include <string>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "host/formats/calibration_set.hpp"

/// The C++ against the points that tests/golden/frames/work_by_hand.py works without it.

namespace sc::host {
namespace {

using Json = nlohmann::json;

constexpr double kNanometreMm = 1e-6;

Json cases(const std::string& name, std::size_t least) {
    std::ifstream in(SC_SOURCE_DIR "/tests/golden/frames/golden.json");
    const Json all = Json::parse(in);
    EXPECT_GE(all.at(name).size(), least);
    return all.at(name);
}

Vec3 vector(const Json& json) {
    EXPECT_EQ(json.size(), 3U);
    return {json[0].get<double>(), json[1].get<double>(), json[2].get<double>()};
}
Vec3 metres(const Json& mm) { return 1e-3 * vector(mm); }

Mat3 matrix(const Json& rows) { return {{vector(rows[0]), vector(rows[1]), vector(rows[2])}}; }

AxisLine axis_of(const Json& json) { return {{metres(json.at("point_mm"))}, {vector(json.at("direction"))}}; }

void expect_near_mm(const Vec3& got_m, const Json& wanted_mm, const Json& why) {
    const Vec3 d = 1e3 * got_m - vector(wanted_mm);
    EXPECT_LT(norm(d), kNanometreMm) << why << ": " << 1e3 * got_m.x << " " << 1e3 * got_m.y << " " << 1e3 * got_m.z;
}

TEST(GoldenFrames, HIsRightHandedWithYTowardsTheHead) {
    const Vec3 across{1.0, 0.0, 0.0};
    const Vec3 towards_head{0.0, 1.0, 0.0};
    EXPECT_EQ(cross(across, towards_head), (Vec3{0.0, 0.0, 1.0})) << "+z is up";
    // Retracting, towards the head, raises y: a deeper surface has the smaller y.
    EXPECT_LT(depth_by_sensor(-0.3, 0.085, 0.090), -0.3);
}

TEST(GoldenFrames, TheTableTurnsCounterClockwise) {
    for (const Json& c : cases("turning", 7)) {
        const auto h = h_from_t(axis_of(c), c.at("c_deg").get<double>()) * Point<frame::T>{metres(c.at("from_mm"))};
        expect_near_mm(h.v, c.at("to_mm"), c.at("why"));
    }
}

TEST(GoldenFrames, FaceKStandsAtMinusK) {
    for (const Json& c : cases("face", 5)) {
        CalibrationSet set;
        TransformRecord record;
        record.id = "h_from_c";
        record.rotation = matrix(c.at("h_from_c").at("rotation"));
        record.translation = metres(c.at("h_from_c").at("translation_mm"));
        set.transforms.push_back(record);
        set.turntable.emplace();
        set.turntable->line = axis_of(c);
        const Rigid<frame::C, frame::W> c_from_w{matrix(c.at("c_from_w").at("rotation")),
                                                 metres(c.at("c_from_w").at("translation_mm"))};
        const Vec3 from = metres(c.at("from_mm"));
        const double face = c.at("face_deg").get<double>();
        const Point<frame::H> h = c.at("frame") == "w" ? to_face(set, c_from_w, Point<frame::W>{from}, face)
                                                       : to_face(set, Point<frame::C>{from}, face);
        expect_near_mm(h.v, c.at("to_mm"), c.at("why"));
    }
}

TEST(GoldenFrames, DepthIsYPlusFirstMinusSecondReading) {
    for (const Json& c : cases("depth", 3)) {
        EXPECT_NEAR(
            depth_by_sensor(c.at("y1_mm").get<double>(), c.at("a1_mm").get<double>(), c.at("a2_mm").get<double>()),
            c.at("y_mm").get<double>(), 1e-9)
            << c.at("why");
    }
}

TEST(GoldenFrames, SquarenessAndScaleAreTakenOut) {
    for (const Json& c : cases("axes", 5)) {
        const Vec3 k = 1e-3 * vector(c.at("squareness_xy_xz_yz_mrad"));
        const Vec3 s = 1e-6 * vector(c.at("scale_ppm"));
        CalibrationSet set;
        set.axes.emplace();
        set.axes->squareness_xy = k.x;
        set.axes->squareness_xz = k.y;
        set.axes->squareness_yz = k.z;
        set.axes->scale = {s.x, s.y, s.z};
        const Compensation compensation = compensation_of(set);
        const Vec3 reading = compensation.axis_from_h * metres(c.at("true_mm")) + compensation.axis_offset;
        expect_near_mm(reading, c.at("reading_mm"), c.at("why"));
    }
}

TEST(GoldenFrames, TheGalvoIsCommandedToLandThere) {
    for (const Json& c : cases("galvo", 5)) {
        CalibrationSet set;
        set.galvo.emplace();
        const Json& m = c.at("matrix");
        set.galvo->matrix = {m[0][0].get<double>(), m[0][1].get<double>(), m[1][0].get<double>(),
                             m[1][1].get<double>()};
        set.galvo->offset = {1e-3 * c.at("offset_mm")[0].get<double>(), 1e-3 * c.at("offset_mm")[1].get<double>()};
        const Compensation g = compensation_of(set);
        const double x = 1e-3 * c.at("lands_mm")[0].get<double>();
        const double z = 1e-3 * c.at("lands_mm")[1].get<double>();
        EXPECT_NEAR(1e3 * (g.galvo_from_field[0] * x + g.galvo_from_field[1] * z + g.galvo_offset[0]),
                    c.at("command_mm")[0].get<double>(), kNanometreMm)
            << c.at("why");
        EXPECT_NEAR(1e3 * (g.galvo_from_field[2] * x + g.galvo_from_field[3] * z + g.galvo_offset[1]),
                    c.at("command_mm")[1].get<double>(), kNanometreMm)
            << c.at("why");
    }
}

}  // namespace
}  // namespace sc::host

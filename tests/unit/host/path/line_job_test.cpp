// SPDX-License-Identifier: Apache-2.0
#include "host/path/line_job.hpp"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <numbers>
#include <sstream>

#include <gtest/gtest.h>

#include "host/formats/dxf.hpp"
#include "host/formats/error.hpp"

namespace sc::host {
namespace {

constexpr double kTurn = 2.0 * std::numbers::pi;

/// c stands 0.3 m beside h's origin, so that a part at c's origin stands on the turntable's axis.
CalibrationSet standing() {
    CalibrationSet set;
    TransformRecord record;
    record.id = "h_from_c";
    record.translation = {-0.2, -0.3, -0.25};
    set.transforms.push_back(record);
    AxisRecord axis;
    axis.line.point.v = {-0.2, -0.3, 0.0};
    set.turntable = axis;
    return set;
}

/// A ring about the axis, counter-clockwise seen from above, and a cloud of a tube.
std::vector<SurfacePlace> ring(double radius, double z, int count = 720) {
    std::vector<SurfacePlace> out;
    for (int i = 0; i < count; ++i) {
        const double angle = kTurn * i / count;
        const Vec3 way{std::cos(angle), std::sin(angle), 0.0};
        out.push_back({radius * way + Vec3{0.0, 0.0, z}, way});
    }
    return out;
}
std::vector<Vec3> tube(double radius, double low, double high) {
    std::vector<Vec3> out;
    for (double z = low; z <= high; z += 3e-4) {
        for (const SurfacePlace& at : ring(radius, z)) {
            out.push_back(at.place);
        }
    }
    return out;
}

double reached(const SplitLine& split) {
    double sum = 0.0;
    for (const ReachedPiece& piece : split.reached) {
        sum += piece.length;
    }
    return sum;
}

TEST(BeamReach, ARingIsBurntFromAllSidesWithoutAGap) {
    const std::vector<Vec3> cloud = tube(0.04, -0.02, 0.02);
    const BeamReach reach(standing(), reference_machine(), cloud);
    const SplitLine split = reach.split(ring(0.04, 0.0), true);
    EXPECT_TRUE(split.missed.empty()) << (split.missed.empty() ? "" : name_of(split.missed[0].why));
    EXPECT_NEAR(reached(split), kTurn * 0.04, 1e-5);
    EXPECT_GE(split.reached.size(), 3U);
    EXPECT_LE(split.reached.size(), 4U);
    for (std::size_t i = 0; i < split.reached.size(); ++i) {
        EXPECT_LE(split.reached[i].worst_incidence_deg, 60.0);
        const auto& next = split.reached[(i + 1) % split.reached.size()];
        EXPECT_LT(norm(split.reached[i].places.back().place - next.places.front().place), 1e-9)
            << "the next piece begins where this one ended";
    }
}

TEST(BeamReach, FaceNamesAreThoseOfTheJob) {
    // At face 90 the table stands at C = -90: what looked along -x at C = 0 looks at the laser.
    const BeamReach reach(standing(), reference_machine(), {}, {.faces = {0.0, 90.0}});
    EXPECT_NEAR(reach.incidence_deg({{0, 0.04, 0}, {0, 1, 0}}, 0), 0.0, 1e-9);
    EXPECT_NEAR(reach.incidence_deg({{0.04, 0, 0}, {1, 0, 0}}, 1), 180.0, 1e-9);
    EXPECT_NEAR(reach.incidence_deg({{-0.04, 0, 0}, {-1, 0, 0}}, 1), 0.0, 1e-9);
    EXPECT_NEAR(norm(reach.in_h({-0.04, 0, 0}, 1) - Vec3{-0.2, -0.26, -0.25}), 0.0, 1e-12);
}

TEST(BeamReach, WhatStandsBeforeALineHidesIt) {
    std::vector<Vec3> cloud = tube(0.04, -0.02, 0.02);
    // A post of 10 mm in front of the side that face 0 looks at.
    for (double z = -0.02; z < 0.02; z += 3e-4) {
        for (double x = -0.005; x < 0.005; x += 3e-4) {
            cloud.push_back({x, 0.06, z});
        }
    }
    const BeamReach reach(standing(), reference_machine(), cloud, {.faces = {0.0}});
    const SplitLine split = reach.split(ring(0.04, 0.0), true);
    ASSERT_GE(split.reached.size(), 2U);
    double occluded = 0.0;
    for (const MissedPiece& piece : split.missed) {
        occluded += piece.why == Unreached::occluded ? piece.length : 0.0;
    }
    // The post, the beam's radius either side, and what the steps along the line leave.
    EXPECT_NEAR(occluded, 0.010 + 2.0 * (0.3e-3 + 1.5e-3 + 0.0313 * 0.02), 3e-3);
    EXPECT_NEAR(reached(split) + occluded, kTurn * 0.04 / 3.0, 3e-3);
}

/// Up along the ring of 40 mm, in the plane through the axis whose normal stands at `plane` degrees about z.
std::vector<SurfacePlace> upright(double plane, double sigma) {
    const double angle = (plane + 90.0) * std::numbers::pi / 180.0;
    std::vector<SurfacePlace> out;
    for (int i = 0; i <= 20; ++i) {
        const Vec3 way{std::cos(angle), std::sin(angle), 0.0};
        out.push_back({0.04 * way + Vec3{0.0, 0.0, 1e-3 * i - 0.01}, way, sigma});
    }
    return out;
}
Vec3 normal_at(double degrees) {
    return {std::cos(degrees * std::numbers::pi / 180.0), std::sin(degrees * std::numbers::pi / 180.0), 0.0};
}

TEST(BeamReach, FacesAlongThePlaneGoFirst) {
    const CalibrationSet set = standing();
    const std::vector<double> along = faces_along(set, normal_at(17.0));
    ASSERT_EQ(along.size(), 2U);
    for (const double face : along) {
        const BeamReach reach(set, reference_machine(), {}, {.faces = {face}});
        EXPECT_NEAR(reach.incidence_deg({{}, normal_at(17.0)}, 0), 90.0, 0.01) << face;
    }
    EXPECT_TRUE(faces_along(set, {0.0, 0.0, 1.0}).empty()) << "any face lies along it";
    // The straight look from face 17 or 0 would do as well; the one along the plane is taken, at either end of the
    // list.
    for (const std::vector<double>& faces :
         {std::vector{0.0, along[0], along[1]}, std::vector{along[0], along[1], 0.0}}) {
        const BeamReach reach(set, reference_machine(), {}, {.faces = faces});
        const SplitLine split = reach.split(upright(17.0, 0.0), false, normal_at(17.0));
        ASSERT_EQ(split.reached.size(), 1U);
        EXPECT_NE(split.reached[0].face_deg, 0.0);
        EXPECT_NEAR(split.reached[0].worst_incidence_deg, 0.0, 0.01);
    }
}

TEST(BeamReach, APoorlySeenSurfaceIsBurntAlongItsPlaneOrNotAtAll) {
    const CalibrationSet set = standing();
    const std::vector<double> along = faces_along(set, normal_at(30.0));
    const auto split = [&](const std::vector<double>& faces, double sigma) {
        return BeamReach(set, reference_machine(), {}, {.faces = faces})
            .split(upright(30.0, sigma), false, normal_at(30.0));
    };
    // From face 0 the beam leaves the plane by tan 30 degrees of what the height is off: 40 um at three sigma of 23 um.
    EXPECT_EQ(split({0.0}, 20e-6).reached.size(), 1U);
    const SplitLine unsure = split({0.0}, 27e-6);
    EXPECT_TRUE(unsure.reached.empty());
    ASSERT_EQ(unsure.missed.size(), 1U);
    EXPECT_EQ(unsure.missed[0].why, Unreached::unsure);
    EXPECT_EQ(split({0.0, along[0], along[1]}, 1e-3).reached.size(), 1U);
}

TEST(BeamReach, EdgesAreLeftOutButAlongThePlane) {
    // Round the corner of a block, 20 mm either way; at face -45 both sides are seen at 45 degrees.
    std::vector<SurfacePlace> line;
    for (int i = 0; i <= 20; ++i) {
        line.push_back({{1e-3 * i - 0.02, 0.0, 0.0}, {0, 1, 0}});
    }
    for (int i = 1; i <= 20; ++i) {
        line.push_back({{0.0, -1e-3 * i, 0.0}, {1, 0, 0}});
    }
    const BeamReach reach(standing(), reference_machine(), {}, {.faces = {-45.0}});
    // Flat to the beam: an error of height stays in the plane. Leaning by 30 degrees: it does not.
    const SplitLine flat = reach.split(line, false, {0, 0, 1});
    ASSERT_EQ(flat.reached.size(), 1U);
    EXPECT_NEAR(flat.reached[0].length, 0.04, 1e-3);
    const SplitLine leaning = reach.split(line, false, {std::sqrt(0.125), std::sqrt(0.125), std::sqrt(0.75)});
    ASSERT_EQ(leaning.reached.size(), 2U);
    EXPECT_NEAR(leaning.reached[0].length, 0.02, 2e-3);
    EXPECT_NEAR(leaning.reached[1].length, 0.02, 3e-3);
    EXPECT_LT(leaning.reached[0].places.back().place.x, -0.3e-3);
    ASSERT_FALSE(leaning.missed.empty());
    EXPECT_EQ(leaning.missed[0].why, Unreached::edge);
}

TEST(BeamReach, TheRimOfWhatStandsInTheBeamMayNotHaveBeenScanned) {
    for (const double aside : {1.2e-3, 4.0e-3}) {
        std::vector<Vec3> cloud;
        for (double z = -0.02; z < 0.02; z += 3e-4) {
            cloud.push_back({aside, 0.06, z});
        }
        const BeamReach reach(standing(), reference_machine(), cloud, {.faces = {0.0}});
        EXPECT_EQ(reach.at({{0.0, 0.04, 0.0}, {0, 1, 0}}, 0), aside < 2e-3 ? Unreached::occluded : Unreached::none);
    }
}

TEST(BeamReach, TravelAndKeepOutAreReasons) {
    const BeamReach reach(standing(), reference_machine(), {}, {.faces = {0.0}});
    EXPECT_EQ(reach.at({{0.204, 0.0, 0.0}, {0, 1, 0}}, 0), Unreached::travel);
    EXPECT_EQ(reach.at({{0.0, 0.0, -0.234}, {0, 1, 0}}, 0), Unreached::keep_out);
    EXPECT_EQ(reach.at({{0.0, 0.0, 0.0}, {1, 0, 0}}, 0), Unreached::incidence);
    EXPECT_EQ(reach.at({{0.0, 0.0, 0.0}, {0, 1, 0}}, 0), Unreached::none);
}

TEST(LineJob, PathsKeepTheirLineAndFace) {
    const std::vector<Vec3> cloud = tube(0.04, -0.02, 0.02);
    const BeamReach reach(standing(), reference_machine(), cloud);
    const std::vector<LineToBurn> lines{{.id = "A", .places = ring(0.04, 0.0), .closed = true, .normal = {0, 0, 1}},
                                        {.id = "B", .places = ring(0.04, 0.01), .closed = true, .normal = {0, 0, 1}}};
    const LineJob job = line_job(lines, reach, {});
    ASSERT_EQ(job.paths.size(), job.burnt.size());
    EXPECT_NEAR(job.burnt_length, 2.0 * kTurn * 0.04, 1e-4);
    EXPECT_EQ(job.missed_length, 0.0);
    for (std::size_t i = 0; i < job.paths.size(); ++i) {
        EXPECT_EQ(job.paths[i].name, job.burnt[i].name);
        EXPECT_EQ(job.paths[i].frame, PlaceFrame::c);
        EXPECT_EQ(job.paths[i].face_deg, job.burnt[i].piece.face_deg);
        EXPECT_TRUE(i == 0 || job.paths[i].face_deg >= job.paths[i - 1].face_deg);
    }
}

TEST(Dxf, HoldsEveryPlaceInMillimetres) {
    const auto file = std::filesystem::temp_directory_path() / "scribecell_line_job_test.dxf";
    write_dxf(file, {{.layer = "datum A/1", .places = {{0.001, 0.002, 0.003}, {0.0, -0.01, 0.0}}, .closed = true}});
    std::ifstream in(file);
    const std::string text(std::istreambuf_iterator<char>(in), {});
    EXPECT_NE(text.find("AC1009"), std::string::npos);
    EXPECT_NE(text.find("datum_A_1"), std::string::npos);
    EXPECT_NE(text.find("10\n1.0000\n20\n2.0000\n30\n3.0000\n70\n32\n"), std::string::npos);
    EXPECT_NE(text.find("20\n-10.0000\n"), std::string::npos);
    EXPECT_NE(text.find("70\n9\n"), std::string::npos) << "closed";
    EXPECT_TRUE(text.ends_with("0\nEOF\n"));
    std::filesystem::remove(file);
}

}  // namespace
}  // namespace sc::host

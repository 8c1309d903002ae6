// SPDX-License-Identifier: Apache-2.0
#include "host/inspection/datum_line.hpp"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <numbers>
#include <sstream>

#include <gtest/gtest.h>

#include "host/formats/scan.hpp"
#include "host/inspection/alignment.hpp"
#include "tests/bench/allowance_workload.hpp"
#include "tests/bench/line_truth.hpp"
#include "tests/unit/host/inspection/shapes.hpp"

namespace sc::host::test {
namespace {

/// Both directions of a cut: how far its places lie off a mesh's section, and how much of the section it shows.
struct Compared {
    LineTruth line;
    CutLine cut;
};
Compared cut_and_compare(const TriangleMesh& mesh, const std::vector<Vec3>& places, const DatumPlane& datum) {
    const DistanceField field(mesh);
    Compared out;
    out.cut = datum_line(field, places, datum).cut;
    out.line = compare_line(out.cut, section(mesh, {datum.point.v, datum.normal.v}));
    return out;
}

DatumPlane plane_at(const Vec3& point, const Vec3& normal) {
    return {.id = "P", .point = {point}, .normal = {(1.0 / norm(normal)) * normal}, .note = {}};
}

TEST(Section, OfABoxIsARectangleWithTheMetalOnItsLeft) {
    const TriangleMesh box = box_mesh({0, 0, 0}, {0.04, 0.03, 0.02});
    const std::vector<SectionPiece> pieces = section(box, {{0, 0, 0.0125}, {0, 0, 1}});
    EXPECT_NEAR(length_of(pieces), 0.14, 1e-12);
    double area = 0.0;
    for (const SectionPiece& piece : pieces) {
        area += 0.5 * (piece.from.x * piece.to.y - piece.from.y * piece.to.x);
    }
    EXPECT_NEAR(area, 0.04 * 0.03, 1e-12) << "counter-clockwise seen from +z";
    EXPECT_TRUE(section(box, {{0, 0, 0.03}, {0, 0, 1}}).empty());
}

TEST(DatumLine, OfABoxIsClosedAndKeepsItsCorners) {
    const TriangleMesh box = box_mesh({0, 0, 0}, {0.04, 0.03, 0.02});
    const std::vector<Vec3> places = places_off(box, 60'000, 0.0, 0.0, 1e-5, 3);
    const Compared c = cut_and_compare(box, places, plane_at({0, 0, 0.01}, {0.1, -0.2, 1.0}));
    ASSERT_EQ(c.cut.runs.size(), 1U);
    EXPECT_TRUE(c.cut.runs[0].closed);
    EXPECT_TRUE(c.cut.gaps.empty());
    EXPECT_LT(c.line.off_max, 6e-5);
    EXPECT_LT(c.line.off_95, 1e-5);
    EXPECT_GT(c.line.shown, 0.999);
    for (const LinePlace& place : c.cut.runs[0].places) {
        EXPECT_NEAR(norm(place.normal), 1.0, 1e-9);
        EXPECT_GT(dot(place.normal, place.place - Vec3{0.02, 0.015, 0.01}), 0.0) << "out of the metal";
    }
}

TEST(DatumLine, RunsRoundABoreWithinTheChordError) {
    const TriangleMesh block = bored_block(0.06, 0.03, 0.012, 720);
    const std::vector<Vec3> places = places_off(block, 200'000, 0.0, 0.0, 0.0, 4);
    const Compared c = cut_and_compare(block, places, plane_at({0, 0, 0.015}, {0, 0, 1}));
    ASSERT_EQ(c.cut.runs.size(), 2U);
    EXPECT_TRUE(c.cut.runs[0].closed && c.cut.runs[1].closed);
    EXPECT_NEAR(c.cut.runs[1].length, 2.0 * std::numbers::pi * 0.012, 1e-4);
    double worst = 0.0;
    const auto& places_of = c.cut.runs[1].places;
    for (std::size_t i = 0; i < places_of.size(); ++i) {
        const Vec3 middle = 0.5 * (places_of[i].place + places_of[(i + 1) % places_of.size()].place);
        worst = std::max(worst, std::abs(std::hypot(middle.x, middle.y) - 0.012));
    }
    EXPECT_LT(worst, 1e-5);
}

TEST(DatumLine, GapsAreReportedAndNotBridged) {
    const TriangleMesh box = box_mesh({0, 0, 0}, {0.04, 0.03, 0.02});
    std::vector<Vec3> places = places_off(box, 60'000, 0.0, 0.0, 1e-5, 5);
    // Seven millimetres of the front, one and a half of the back are not seen.
    std::erase_if(places, [](const Vec3& p) {
        return (p.y < 0.001 && p.x > 0.01 && p.x < 0.017) || (p.y > 0.029 && p.x > 0.02 && p.x < 0.0215);
    });
    const Compared c = cut_and_compare(box, places, plane_at({0, 0, 0.01}, {0, 0, 1}));
    ASSERT_EQ(c.cut.runs.size(), 1U);
    EXPECT_FALSE(c.cut.runs[0].closed);
    ASSERT_EQ(c.cut.gaps.size(), 1U);
    EXPECT_NEAR(c.cut.gaps[0].length, 7e-3, 6e-4);
    EXPECT_NEAR(c.cut.length, 0.14 - 7e-3, 7e-4);
}

TEST(DatumLine, ThinWallsAndStepsAreNotMixedUp) {
    // Two plates 1.2 mm apart, one behind the other's face: four closed lines of their own.
    TriangleMesh plates = box_mesh({0, 0, 0}, {0.04, 0.0012, 0.02});
    const TriangleMesh other = box_mesh({0, 0.0024, 0}, {0.04, 0.0036, 0.02});
    const auto first = static_cast<std::uint32_t>(plates.vertices.size());
    plates.vertices.insert(plates.vertices.end(), other.vertices.begin(), other.vertices.end());
    for (auto t : other.triangles) {
        plates.triangles.push_back({t[0] + first, t[1] + first, t[2] + first});
    }
    const std::vector<Vec3> places = places_off(plates, 100'000, 0.0, 0.0, 1e-5, 6);
    const Compared c = cut_and_compare(plates, places, plane_at({0, 0, 0.01}, {0, 0, 1}));
    ASSERT_EQ(c.cut.runs.size(), 2U);
    EXPECT_TRUE(c.cut.runs[0].closed && c.cut.runs[1].closed);
    EXPECT_NEAR(c.cut.length, 4.0 * 0.0412, 2e-4);
    EXPECT_LT(c.line.off_max, 8e-5);
}

TEST(DatumLine, OutliersLeaveNoTrace) {
    const TriangleMesh box = box_mesh({0, 0, 0}, {0.04, 0.03, 0.02});
    std::vector<Vec3> places = places_off(box, 60'000, 0.0, 0.0, 1e-5, 7);
    const std::vector<Vec3> stray = places_off(box, 600, 3e-4, 4e-3, 0.0, 8);
    places.insert(places.end(), stray.begin(), stray.end());
    const Compared c = cut_and_compare(box, places, plane_at({0, 0, 0.01}, {0, 0, 1}));
    EXPECT_EQ(c.cut.runs.size(), 1U);
    EXPECT_LT(c.line.off_max, 1e-4);
}

TEST(DatumLine, SaysHowWellEachHeightIsKnown) {
    const TriangleMesh box = box_mesh({0, 0, 0}, {0.04, 0.03, 0.02});
    for (const double noise : {1e-5, 4e-5}) {
        const std::vector<Vec3> places = places_off(box, 60'000, 0.0, 0.0, noise, 11);
        const DistanceField field(box);
        CutOptions every;
        every.chord = 1e-12;
        const CutLine cut = datum_line(field, places, plane_at({0, 0, 0.01}, {0, 0, 1}), every).cut;
        double squares = 0.0;
        double said = 0.0;
        int count = 0;
        for (const LinePlace& at : cut.runs.at(0).places) {
            const double x = std::min(std::abs(at.place.x), std::abs(at.place.x - 0.04));
            const double y = std::min(std::abs(at.place.y), std::abs(at.place.y - 0.03));
            if (std::max(x, y) > 3e-3) {
                squares += std::min(x, y) * std::min(x, y);
                said += at.sigma * at.sigma;
                ++count;
            }
        }
        ASSERT_GT(count, 200);
        EXPECT_NEAR(std::sqrt(squares / said), 1.0, 0.25) << noise;
        EXPECT_LT(std::sqrt(said / count), 0.7 * noise) << "an average is better than a point";
    }
}

TEST(DatumLine, ThePublishedCastingFromItsScan) {
    const PointCloud cloud = read_scan(casting("scan.ply")).cloud;
    const std::vector<Vec3> places = placed(true_placement(casting("truth_pose.txt")), cloud.points);
    const DistanceField field(read_mesh(casting("finished.stl")).mesh);
    const TriangleMesh rough = read_mesh(casting("rough.stl")).mesh;
    for (const DatumPlane& datum : read_part(casting("part.toml")).datums) {
        const DatumLine line = datum_line(field, places, datum);
        const LineTruth truth = compare_line(line.cut, section(rough, line.plane));
        EXPECT_LE(truth.off_95, 1e-4) << datum.id;
        EXPECT_GT(truth.shown, 0.65) << datum.id;
        EXPECT_GT(line.cut.length, 0.2) << datum.id;
    }
}

TEST(DatumLine, RefusesAPlaneThatMissesAndAScanThatShowsNothing) {
    const TriangleMesh box = box_mesh({0, 0, 0}, {0.04, 0.03, 0.02});
    const DistanceField field(box);
    std::vector<Vec3> places = places_off(box, 60'000, 0.0, 0.0, 1e-5, 9);
    try {
        static_cast<void>(datum_line(field, places, plane_at({0, 0, 0.0215}, {0, 0, 1})));
        FAIL() << "missed the part and said nothing";
    } catch (const InspectionError& error) {
        EXPECT_NE(std::string(error.what()).find("misses the part: it passes 1.50 mm"), std::string::npos)
            << error.what();
    }
    std::erase_if(places, [](const Vec3& p) { return p.z > 0.001 && (p.x < 0.039 || p.y > 0.01); });
    EXPECT_THROW(static_cast<void>(datum_line(field, places, plane_at({0, 0, 0.01}, {0, 0.001, 1}))), InspectionError);
}

}  // namespace
}  // namespace sc::host::test

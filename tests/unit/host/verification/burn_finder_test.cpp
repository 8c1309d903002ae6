// SPDX-License-Identifier: Apache-2.0
#include "host/verification/burn_finder.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include <gtest/gtest.h>

#include "shared/units/quantity.hpp"
#include "synthetic_burns.hpp"

namespace sc::host {
namespace {

using synthetic::Burner;

constexpr AxisLine kAxis{{{synthetic::kAxisX, synthetic::kAxisY, 0.0}}, {{0.0, 0.0, 1.0}}};
constexpr std::array<double, 4> kFaces{0.0, 90.0, 180.0, 270.0};

const std::vector<Vec3> kPlaces{{-0.31, -0.32, -0.42}, {-0.15, -0.318, -0.40}, {-0.27, -0.319, -0.35}};

BurnFindings find(const Burner& burner) { return find_burns(burner.pulses, kAxis, kFaces); }

/// Distance from `place` to the nearest cross on the face.
double nearest(const BurnFindings& found, double face_deg, const Vec3& place) {
    double least = 1.0;
    for (const FoundCross& cross : found.crosses) {
        if (cross.face_deg == face_deg) {
            least = std::min(least, norm(cross.place.v - place));
        }
    }
    return least;
}

TEST(BurnFinder, FindsCrossesOnEveryFace) {
    Burner burner;
    for (const double face : kFaces) {
        burner.c_deg = -face;
        for (const Vec3& place : kPlaces) {
            burner.cross(place);
        }
    }
    const BurnFindings found = find(burner);
    EXPECT_EQ(found.crosses.size(), 12U);
    EXPECT_EQ(found.strokes.size(), 24U);
    EXPECT_TRUE(found.alone.empty());
    EXPECT_EQ(found.stray, 0U);
    EXPECT_TRUE(found.lines.empty());
    for (const double face : kFaces) {
        for (const Vec3& place : kPlaces) {
            EXPECT_LT(nearest(found, face, place), 0.01e-6);
        }
    }
}

TEST(BurnFinder, FindsKnownShiftAndShear) {
    Burner burner;
    burner.error = [](const Vec3& p) { return Vec3{50e-6 + 1e-4 * p.z, 3e-6, -20e-6}; };
    for (const Vec3& place : kPlaces) {
        burner.cross(place);
    }
    const BurnFindings found = find(burner);
    for (const Vec3& place : kPlaces) {
        EXPECT_LT(nearest(found, 0.0, place + burner.error(place)), 0.2e-6);
        EXPECT_GT(nearest(found, 0.0, place), 15e-6);
    }
    // The strokes along z lean by the shear.
    for (const FoundCross& cross : found.crosses) {
        EXPECT_NEAR(std::abs(cross.squareness), 1e-4, 1e-8);
    }
}

TEST(BurnFinder, ShiftOfTheTraceShiftsWhatIsFoundExactly) {
    Burner burner;
    burner.noise = 5e-6;
    for (const Vec3& place : kPlaces) {
        burner.cross(place);
    }
    const BurnFindings before = find(burner);
    for (trace::PulseRecord& pulse : burner.pulses) {
        pulse.table_pm[0] += 50'000'000;  // face 0: t is h
        pulse.table_pm[2] -= 30'000'000;
    }
    const BurnFindings after = find(burner);
    ASSERT_EQ(after.crosses.size(), before.crosses.size());
    for (std::size_t i = 0; i < before.crosses.size(); ++i) {
        const Vec3 moved = after.crosses[i].place.v - before.crosses[i].place.v;
        EXPECT_NEAR(moved.x, 50e-6, 1e-12);
        EXPECT_NEAR(moved.y, 0.0, 1e-12);
        EXPECT_NEAR(moved.z, -30e-6, 1e-12);
    }
}

TEST(BurnFinder, StaysWithinThreeSigmaOfTheNoise) {
    constexpr double kNoise = 5e-6;
    int outside = 0;
    int count = 0;
    for (unsigned seed = 1; seed <= 60; ++seed) {
        Burner burner(seed);
        burner.noise = kNoise;
        burner.cross(kPlaces[0]);
        const BurnFindings found = find(burner);
        ASSERT_EQ(found.crosses.size(), 1U);
        const FoundCross& cross = found.crosses[0];
        EXPECT_NEAR(cross.sigma, kNoise / std::sqrt(201.0), 0.2 * kNoise / std::sqrt(201.0));
        for (const double off : {cross.place.v.x - kPlaces[0].x, cross.place.v.z - kPlaces[0].z}) {
            outside += std::abs(off) > 3.0 * cross.sigma ? 1 : 0;
            ++count;
        }
    }
    // 0.27 % expected of 120; five would be absurd.
    EXPECT_LE(outside, 3) << "of " << count;
}

TEST(BurnFinder, JudgesDepthByTheFocusOnARoughSurface) {
    Burner burner;
    burner.roughness = [](const Vec3& p) { return 40e-6 * std::sin(p.x * 9e3) + 0.1 * (p.z - kPlaces[0].z) + 70e-6; };
    burner.cross(kPlaces[0]);
    const BurnFindings found = find(burner);
    ASSERT_EQ(found.crosses.size(), 1U);
    EXPECT_NEAR(found.crosses[0].place.v.y, kPlaces[0].y, 0.01e-6);
    EXPECT_NEAR(found.crosses[0].surface_y, kPlaces[0].y + 70e-6, 15e-6);
}

TEST(BurnFinder, FollowsAFocusThatSlopesAlongTheStroke) {
    Burner burner;
    const Vec3 c = kPlaces[1];
    burner.stroke(c + Vec3{-2e-3, -40e-6, 0.0}, c + Vec3{2e-3, 40e-6, 0.0});
    burner.stroke(c + Vec3{0.0, -20e-6, 2e-3}, c + Vec3{0.0, 20e-6, -2e-3});
    const BurnFindings found = find(burner);
    ASSERT_EQ(found.crosses.size(), 1U);
    EXPECT_LT(norm(found.crosses[0].place.v - c), 0.01e-6);
}

TEST(BurnFinder, TrueAngleOffItsNominalTurnsThePlacesWithIt) {
    Burner burner;
    burner.c_deg = -90.002;
    burner.cross(kPlaces[0]);
    const BurnFindings found = find(burner);
    ASSERT_EQ(found.crosses.size(), 1U);
    EXPECT_EQ(found.crosses[0].face_deg, 90.0);
    // At −90 the spot stands 0.002° further counter-clockwise about the axis.
    const double turn = 0.002 * 3.14159265358979323846 / 180.0;
    const Vec3 expected =
        kPlaces[0] + Vec3{-turn * (kPlaces[0].y - synthetic::kAxisY), turn * (kPlaces[0].x - synthetic::kAxisX), 0.0};
    EXPECT_LT(norm(found.crosses[0].place.v - expected), 0.01e-6);
}

TEST(BurnFinder, AnglesAreTheSameAfterAWholeTurn) {
    Burner burner;
    burner.c_deg = 270.0;
    burner.cross(kPlaces[0]);
    EXPECT_LT(nearest(find(burner), 90.0, kPlaces[0]), 0.01e-6);
}

TEST(BurnFinder, PulsesBetweenFacesAndBesideTheSurfaceAreCounted) {
    Burner burner;
    burner.cross(kPlaces[0]);
    burner.c_deg = -45.0;
    burner.cross(kPlaces[0]);
    burner.c_deg = 0.0;
    burner.cross(kPlaces[1]);
    burner.pulses.back().hit = 0;
    const BurnFindings found = find(burner);
    EXPECT_EQ(found.off_face, 402U);
    EXPECT_EQ(found.missed, 1U);
    EXPECT_EQ(found.crosses.size(), 2U);
    EXPECT_EQ(found.pulses, burner.pulses.size());
}

TEST(BurnFinder, MissingStrokeLeavesItsPartnerAlone) {
    Burner burner;
    burner.cross(kPlaces[0]);
    burner.stroke(kPlaces[1] + Vec3{-2e-3, 0.0, 0.0}, kPlaces[1] + Vec3{2e-3, 0.0, 0.0});
    const BurnFindings found = find(burner);
    EXPECT_EQ(found.crosses.size(), 1U);
    ASSERT_EQ(found.alone.size(), 1U);
    EXPECT_NEAR(found.strokes[found.alone[0]].line.point.x, kPlaces[1].x, 1e-9);
}

TEST(BurnFinder, DarkStretchInAStrokeDoesNotCutIt) {
    Burner burner;
    burner.lit = [](std::size_t i) { return i < 60 || i > 150; };  // 1.8 mm dark, the middle among it
    burner.cross(kPlaces[0]);
    const BurnFindings found = find(burner);
    EXPECT_EQ(found.strokes.size(), 2U);
    EXPECT_LT(nearest(found, 0.0, kPlaces[0]), 0.01e-6);
}

TEST(BurnFinder, HoldInTheMiddleOfAStrokeDoesNotCutIt) {
    Burner burner;
    const Vec3 c = kPlaces[0];
    burner.stroke(c + Vec3{-2e-3, 0.0, 0.0}, c + Vec3{0.5e-3, 0.0, 0.0});
    burner.wait(60'000'000'000);
    burner.stroke(c + Vec3{0.52e-3, 0.0, 0.0}, c + Vec3{2e-3, 0.0, 0.0});
    burner.stroke(c + Vec3{0.0, 0.0, 2e-3}, c + Vec3{0.0, 0.0, -2e-3});
    const BurnFindings found = find(burner);
    EXPECT_EQ(found.strokes.size(), 2U);
    EXPECT_LT(nearest(found, 0.0, c), 0.01e-6);
}

TEST(BurnFinder, PassesAreOneStroke) {
    Burner burner;
    burner.noise = 2e-6;
    for (int pass = 0; pass < 3; ++pass) {
        burner.stroke(kPlaces[0] + Vec3{-2e-3, 0.0, 0.0}, kPlaces[0] + Vec3{2e-3, 0.0, 0.0});
    }
    for (int pass = 0; pass < 3; ++pass) {
        burner.stroke(kPlaces[0] + Vec3{0.0, 0.0, -2e-3}, kPlaces[0] + Vec3{0.0, 0.0, 2e-3});
    }
    const BurnFindings found = find(burner);
    ASSERT_EQ(found.strokes.size(), 2U);
    EXPECT_EQ(found.strokes[0].pulses, 603U);
    EXPECT_EQ(found.crosses.size(), 1U);
    EXPECT_LT(nearest(found, 0.0, kPlaces[0]), 1e-6);
}

TEST(BurnFinder, StrayPulsesChangeNothing) {
    Burner burner;
    const Vec3 c = kPlaces[0];
    burner.pulse(c + Vec3{1e-3, 0.0, 1e-3});
    burner.stroke(c + Vec3{-2e-3, 0.0, 0.0}, c + Vec3{2e-3, 0.0, 0.0});
    burner.pulse(c + Vec3{30e-3, 0.0, 0.0});
    burner.stroke(c + Vec3{0.0, 0.0, 2e-3}, c + Vec3{0.0, 0.0, -1e-3});
    burner.pulse(c + Vec3{0.1e-3, 0.0, -1e-3});  // beside the line
    burner.pulse(c + Vec3{5e-3, 0.0, 5e-3});
    const BurnFindings found = find(burner);
    EXPECT_EQ(found.crosses.size(), 1U);
    EXPECT_LT(nearest(found, 0.0, c), 0.02e-6);
    EXPECT_EQ(found.stray, 3U);
    EXPECT_EQ(found.strokes[1].outliers, 1U);
}

TEST(BurnFinder, NeighbouringCrossesAreNotMixed) {
    Burner burner;
    // 6 mm apart at nearly the same height: strokes almost in line, 2 mm between their ends.
    const Vec3 next = kPlaces[0] + Vec3{6e-3, 0.0, 60e-6};
    burner.cross(kPlaces[0]);
    burner.cross(next);
    const BurnFindings found = find(burner);
    EXPECT_EQ(found.crosses.size(), 2U);
    EXPECT_LT(nearest(found, 0.0, kPlaces[0]), 0.01e-6);
    EXPECT_LT(nearest(found, 0.0, next), 0.01e-6);
}

TEST(BurnFinder, SmallCrossWhoseStrokesNearlyTouch) {
    Burner burner;
    burner.cross(kPlaces[0], 1e-3);
    EXPECT_LT(nearest(find(burner), 0.0, kPlaces[0]), 0.01e-6);
}

TEST(BurnFinder, CrossTurnedInItsFaceIsFound) {
    Burner burner;
    const Vec3 c = kPlaces[0];
    const double a = 0.3;
    const Vec3 u{2e-3 * std::cos(a), 0.0, 2e-3 * std::sin(a)};
    const Vec3 v{-u.z, 0.0, u.x};
    burner.stroke(c - u, c + u);
    burner.stroke(c - v, c + v);
    EXPECT_LT(nearest(find(burner), 0.0, c), 0.01e-6);
}

TEST(BurnFinder, LongStrokeIsALineAndTakesNoPartInCrosses) {
    Burner burner;
    burner.cross(kPlaces[2]);
    // Through the cross, exactly along its stroke.
    burner.stroke({-0.31, -0.319, kPlaces[2].z}, {-0.25, -0.318, kPlaces[2].z});
    const BurnFindings found = find(burner);
    EXPECT_EQ(found.crosses.size(), 1U);
    EXPECT_LT(nearest(found, 0.0, kPlaces[2]), 0.01e-6);
    ASSERT_EQ(found.lines.size(), 1U);
    const FoundLine& line = found.lines[0];
    EXPECT_NEAR(line.length, norm(Vec3{0.06, 0.001, 0.0}), 25e-6);
    EXPECT_NEAR(line.from.v.x, -0.31, 1e-9);
    EXPECT_NEAR(line.from.v.y, -0.319, 1e-9);
    EXPECT_LT(line.straightness, 1e-9);
    EXPECT_LT(line.z_range, 1e-9);
}

TEST(BurnFinder, LineTellsItsStraightnessAndRangeOfHeight) {
    // Two waves of 3 µm over the line, which a tilt cannot take up, on a tilt of 6 µm.
    Burner burner;
    burner.error = [](const Vec3& p) {
        const double along = (p.x + 0.31) / 0.06;
        return Vec3{0.0, 0.0, 3e-6 * std::cos(4.0 * kPi * along) + 6e-6 * along};
    };
    burner.stroke({-0.31, -0.319, -0.38}, {-0.25, -0.319, -0.38});
    const BurnFindings found = find(burner);
    ASSERT_EQ(found.lines.size(), 1U);
    EXPECT_NEAR(found.lines[0].straightness, 6e-6, 0.05e-6);
    double least = 1.0;
    double most = -1.0;
    for (const trace::PulseRecord& pulse : burner.pulses) {
        least = std::min(least, static_cast<double>(pulse.place_pm[2]) * 1e-12);
        most = std::max(most, static_cast<double>(pulse.place_pm[2]) * 1e-12);
    }
    EXPECT_NEAR(found.lines[0].z_range, most - least, 1e-11);
    EXPECT_GT(most - least, 8e-6);
}

TEST(BurnFinder, NothingBurntGivesNothing) {
    const BurnFindings found = find_burns({}, kAxis, kFaces);
    EXPECT_TRUE(found.strokes.empty());
    EXPECT_TRUE(found.crosses.empty());
    EXPECT_EQ(found.pulses, 0U);
}

TEST(BurnFinder, AFewPulsesAtOneSpotAreStray) {
    Burner burner;
    for (int i = 0; i < 10; ++i) {
        burner.pulse(kPlaces[0]);
    }
    const BurnFindings found = find(burner);
    EXPECT_TRUE(found.strokes.empty());
    EXPECT_EQ(found.stray, 10U);
}

}  // namespace
}  // namespace sc::host

// SPDX-License-Identifier: Apache-2.0
#include "boards/sim/world/machine_errors.hpp"

#include <cmath>
#include <tuple>

#include <gtest/gtest.h>

namespace sc::sim {
namespace {

constexpr double kDegree = kPi / 180.0;

TEST(TrueFocus, IsTheReadingWithoutErrors) { EXPECT_EQ(true_focus({}, {-0.1, -0.2, -0.3}), (Vec3{-0.1, -0.2, -0.3})); }

TEST(TrueFocus, AddsSquarenessAndScaleByHand) {
    AxesTruth truth;
    truth.squareness_xy = 0.120e-3;
    truth.squareness_xz = -0.080e-3;
    truth.squareness_yz = 0.150e-3;
    truth.scale = {12e-6, -8e-6, 15e-6};
    const Vec3 p = true_focus(truth, {-0.250, -0.320, -0.400});
    // x: -250 mm - 3.0 um (scale) - 38.4 um (0.12 mrad of y) + 32.0 um (-0.08 mrad of z)
    EXPECT_NEAR(p.x, -0.2500094, 1e-12);
    // y: -320 mm + 2.56 um - 60 um
    EXPECT_NEAR(p.y, -0.32005744, 1e-12);
    // z: -400 mm - 6 um
    EXPECT_NEAR(p.z, -0.400006, 1e-12);
}

TEST(TrueFocus, PeriodicShiftFollowsTheOtherAxis) {
    AxesTruth truth;
    truth.periodic[2][0] = {1e-6, 0.2, 30.0 * kDegree};
    EXPECT_NEAR(true_focus(truth, {0.0, 0.1, 0.0}).z, 0.5e-6, 1e-15);
    EXPECT_NEAR(true_focus(truth, {0.2, 0.3, 0.0}).z, 0.5e-6, 1e-15);
    EXPECT_NEAR(true_focus(truth, {0.1, 0.0, 0.0}).z, -0.5e-6, 1e-15);
    EXPECT_NEAR(true_focus(truth, {0.2 * 60 / 360, 0.0, 0.0}).z, 1e-6, 1e-15);
}

TEST(TurntableTruth, QuarterTurnTakesXToY) {
    TurntableTruth truth;
    truth.axis_point = {-0.250, -0.470, 0.0};
    const auto moved = true_h_from_t(truth, 90.0) * Point<frame::T>{{-0.150, -0.470, -0.4}};
    EXPECT_NEAR(moved.v.x, -0.250, 1e-12);
    EXPECT_NEAR(moved.v.y, -0.370, 1e-12);
    EXPECT_NEAR(moved.v.z, -0.4, 1e-12);
}

TurntableTruth bad_table() {
    TurntableTruth truth;
    truth.axis_point = {-0.250018, -0.470027, 0.0};
    truth.direction = {0.00004, -0.00003, 1.0};
    truth.runout = 0.5e-6;
    truth.runout_phase = 60 * kDegree;
    truth.wobble = 1e-6;
    truth.wobble_phase = 200 * kDegree;
    truth.wobble_pivot_z = -0.490;
    truth.pitch_error = 1e-4;
    truth.pitch_error_phase = 110 * kDegree;
    return truth;
}

TEST(TurntableTruth, FrameEqualsHAtZeroWithAllErrors) {
    const auto at_zero = true_h_from_t(bad_table(), 0.0);
    EXPECT_LT(orthogonality_error(at_zero.rotation), 1e-15);
    const Vec3 p{-0.1, -0.3, -0.4};
    EXPECT_LT(norm((at_zero * Point<frame::T>{p}).v - p), 1e-15);
    EXPECT_EQ(true_angle(bad_table(), 0.0), 0.0);
}

TEST(TurntableTruth, StaysRigidAndNearItsNominalTurn) {
    TurntableTruth ideal = bad_table();
    ideal.runout = ideal.wobble = ideal.pitch_error = 0.0;
    for (int c = -360; c <= 360; c += 15) {
        const auto t = true_h_from_t(bad_table(), c);
        EXPECT_LT(orthogonality_error(t.rotation), 1e-14);
        EXPECT_NEAR(t.rotation.determinant(), 1.0, 1e-14);
        const Point<frame::T> p{{-0.250, -0.250, -0.4}};
        const double off = norm((t * p).v - (true_h_from_t(ideal, c) * p).v);
        // 2 · 0.5 um runout + 2 · 1 urad · 0.25 m wobble + 2 · 0.1 mdeg · 0.22 m
        EXPECT_LT(off, 2.4e-6);
        if (c == 180 || c == -180) {
            EXPECT_GT(off, 0.3e-6);
        }
    }
}

TEST(TurntableTruth, EachErrorActsByItself) {
    TurntableTruth truth;
    truth.runout = 0.5e-6;
    // From phase 0, half a turn moves the centre from +r to -r.
    EXPECT_NEAR((true_h_from_t(truth, 180.0) * Point<frame::T>{}).v.x, -1e-6, 1e-15);
    truth = {};
    truth.pitch_error = 1e-4;
    EXPECT_NEAR(true_angle(truth, 90.0), 90.0001, 1e-12);
    EXPECT_NEAR(true_angle(truth, -90.0), -90.0001, 1e-12);
    truth = {};
    truth.wobble = 1e-6;
    truth.wobble_pivot_z = -0.5;
    // Half a turn: tilt of -2 urad about x; 0.1 m above the pivot that is +0.2 um of y, at the pivot nothing.
    const auto half = true_h_from_t(truth, 180.0);
    EXPECT_NEAR((half * Point<frame::T>{{0, 0, -0.4}}).v.y, 0.2e-6, 1e-12);
    EXPECT_NEAR((half * Point<frame::T>{{0, 0, -0.5}}).v.y, 0.0, 1e-15);
}

TEST(TrueBeam, LandsWhereTwoMirrorsAndTheLensSendIt) {
    GalvoTruth truth;
    truth.offset_x = 35e-6;
    truth.offset_z = -22e-6;
    truth.gain_x = 1.003;
    truth.gain_z = 0.998;
    truth.rotation = 1.5e-3;
    truth.skew = 0.4e-3;
    const Beam beam = true_beam(truth, {-0.25, -0.32, -0.4}, 0.010, -0.005);
    // Worked out apart: a = 1.003 · 10/160, b = -0.998 · 5/160, f t sin(a)/sin(t) and so on, then turned and skewed.
    EXPECT_NEAR(beam.focus.x, -0.25 + 35e-6 + 0.010041081727, 1e-11);
    EXPECT_NEAR(beam.focus.z, -0.4 - 22e-6 - 0.004968404575, 1e-11);
    EXPECT_EQ(beam.focus.y, -0.32);
}

TEST(TrueBeam, IsPillowInXAndBarrelInZ) {
    // f 160 mm, both mirrors 20 and 10 degrees: known values of the two-mirror head with an f-theta lens.
    const GalvoTruth truth;
    for (const auto& [degrees, x, z] : {std::tuple{20.0, 56.962, 53.527}, std::tuple{10.0, 28.066, 27.640}}) {
        const double command = 0.160 * degrees * kPi / 180.0;
        const Beam beam = true_beam(truth, {}, command, command);
        EXPECT_NEAR(beam.focus.x * 1e3, x, 5e-4);
        EXPECT_NEAR(beam.focus.z * 1e3, z, 5e-4);
    }
}

TEST(TrueBeam, EachTermOfTheLensActsByItself) {
    GalvoTruth truth;
    truth.lens = {0.160, -0.001, 0.0, 0.0};
    EXPECT_NEAR(true_beam(truth, {}, 0.016, 0.0).focus.x, 0.016 - 1e-5, 1e-12);
    truth.lens = {0.160, 0.0, -0.020, -0.010};
    EXPECT_NEAR(true_beam(truth, {}, 0.0, 0.016).focus.z, 0.016 - 2e-5 - 1e-6, 1e-12);
    truth = {};
    truth.ripple_x = 3e-6;
    truth.ripple_period = 0.064;
    // A quarter of a period out: sin(pi/2 + 0.6).
    EXPECT_NEAR(true_beam(truth, {}, 0.016, 0.0).focus.x, 0.016 + 3e-6 * 0.825335615, 1e-13);
}

TEST(TrueBeam, TravelsTowardsTheWorkpieceAndLeansOutwards) {
    GalvoTruth truth;
    const Beam straight = true_beam(truth, {}, 0.0, 0.0);
    EXPECT_EQ(straight.direction, (Vec3{0.0, -1.0, 0.0}));
    const Beam out = true_beam(truth, {}, 0.016, -0.008);
    EXPECT_NEAR(out.direction.x / -out.direction.y, 0.100041567467, 1e-10);
    EXPECT_NEAR(out.direction.z / -out.direction.y, -0.049833166647, 1e-10);
    EXPECT_NEAR(norm(out.direction), 1.0, 1e-12);
    truth.beam_tilt_x = 0.2e-3;
    EXPECT_NEAR(true_beam(truth, {}, 0.0, 0.0).direction.x, 0.2e-3, 1e-10);
}

TEST(TrueBeam, LeansByTheExitPupilOfEachMirrorAndBends) {
    GalvoTruth truth;
    truth.exit_pupil_x = 0.320;
    truth.exit_bend = 10.0;
    const Beam out = true_beam(truth, {}, 0.016, 0.0);
    EXPECT_NEAR(out.direction.x / -out.direction.y, 0.05 * (1.0 + 10.0 * 0.016 * 0.016), 1e-12);
}

TEST(TrueBeam, FieldCurvatureMovesTheFocusAlongTheBeam) {
    GalvoTruth truth;
    truth.field_curvature = 0.5;
    const Beam out = true_beam(truth, {}, 0.016, 0.0);
    EXPECT_NEAR(out.focus.y, 0.5 * 0.016 * 0.016, 1e-15);
    const Vec3 at_plane = out.focus + (out.focus.y / -out.direction.y) * out.direction;
    EXPECT_NEAR(at_plane.x, 0.016, 1e-12) << "the beam itself stays where it is";
}

}  // namespace
}  // namespace sc::sim

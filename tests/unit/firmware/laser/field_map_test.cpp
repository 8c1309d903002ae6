// SPDX-License-Identifier: Apache-2.0
#include "firmware/laser/field_map.hpp"

#include <cmath>
#include <limits>
#include <random>

#include <gtest/gtest.h>

namespace sc::laser {
namespace {

GalvoConfig head() {
    GalvoConfig galvo;
    galvo.counts_per_metre = 1e6;
    galvo.convention = GalvoConvention::offset_binary;
    return galvo;
}

/// A map of the size of a real one: what a two-mirror head behind a lens of f 160 mm needs, with terms up to the third
/// order in each direction (those a cubic spline represents without error), askew, off centre, leaning.
struct Truth {
    static constexpr double kF = 0.160;
    std::array<double, 2> slope0{2e-4, -1.5e-4};
    std::array<double, 4> slope{1.0 / 0.187, 0.008, -0.012, 1.0 / 0.171};
    double bend = 4.0;

    static std::array<double, 2> command(double x, double z) {
        const double radial = 0.12 / (kF * kF);
        return {1.003 * x + 0.0019 * z - 35e-6 - x * z * z / (6.0 * kF * kF) + radial * x * (x * x + z * z),
                0.998 * z - 0.0015 * x + 22e-6 + z * x * x / (3.0 * kF * kF) + radial * z * (x * x + z * z)};
    }
    std::array<double, 2> in_focus(double x, double z, double depth) const {
        double px = x;
        double pz = z;
        for (int i = 0; i < 60; ++i) {
            const double b = 1.0 + bend * (px * px + pz * pz);
            const double nx = x + depth * (slope0[0] + (slope[0] * px + slope[1] * pz) * b);
            pz = z + depth * (slope0[1] + (slope[2] * px + slope[3] * pz) * b);
            px = nx;
        }
        return {px, pz};
    }
    std::array<double, 2> exact(double x, double z, double depth) const {
        const auto p = in_focus(x, z, depth);
        return command(p[0], p[1]);
    }
    /// Coefficients of the cubic B-spline: along each direction f − h² f'' / 6, exact for cubics.
    GalvoField field(double half = 0.060) const {
        GalvoField field;
        field.half = half;
        field.slope0 = slope0;
        field.slope = slope;
        field.bend = bend;
        const double h = 2.0 * half / static_cast<double>(GalvoField::kCells);
        const auto along_x = [&](double x, double z, std::size_t i) {
            return (8.0 * command(x, z)[i] - command(x - h, z)[i] - command(x + h, z)[i]) / 6.0;
        };
        for (std::size_t j = 0; j < GalvoField::kNodes; ++j) {
            const double x = -half + h * (static_cast<double>(j % GalvoField::kSide) - 1.0);
            const double z = -half + h * (static_cast<double>(j / GalvoField::kSide) - 1.0);
            for (std::size_t i = 0; i < 2; ++i) {
                field.node[2 * j + i] = (8.0 * along_x(x, z, i) - along_x(x, z - h, i) - along_x(x, z + h, i)) / 6.0;
            }
        }
        return field;
    }
};

TEST(FieldMap, AppliesTheCompensationsMatrixAndClamps) {
    Compensation c;
    c.galvo_from_field = {1.01, 0.002, -0.003, 0.99};
    c.galvo_offset = {-1e-4, 2e-4};
    GalvoConfig galvo = head();
    FieldMap map(galvo);
    map.set(c);
    const FieldPatch patch = map.patch(0.0, 0.0, 0.0);
    const auto counts = patch.counts({0.01, -0.005, 0.3});
    EXPECT_EQ(counts[0], 10'100 - 10 - 100) << "depth changes nothing";
    EXPECT_EQ(counts[1], -30 - 4'950 + 200);
    EXPECT_EQ(patch.counts({1.0, -1.0, 0.0})[0], 32767);
    EXPECT_EQ(patch.counts({1.0, -1.0, 0.0})[1], -32767);
    const auto words = patch.words({0.01, -0.005, 0.0});
    EXPECT_EQ(words[0], xy2_100_word(10'100 - 10 - 100, GalvoConvention::offset_binary));
    EXPECT_EQ(words[1], xy2_100_word(-30 - 4'950 + 200, GalvoConvention::offset_binary));
    galvo.word = GalvoWord::bits18;
    FieldMap fine(galvo);
    fine.set(c);
    EXPECT_EQ(fine.patch(0.0, 0.0, 0.0).counts({0.01, -0.005, 0.0})[0], 4 * 9'990);
    EXPECT_EQ(fine.patch(0.0, 0.0, 0.0).counts({1.0, 0.0, 0.0})[0], 131'071);
}

TEST(FieldMap, IsExactWhereThePatchIsMade) {
    const Truth truth;
    FieldMap map(head());
    map.set(truth.field());
    for (double x = -0.055; x <= 0.0551; x += 0.005) {
        for (double z = -0.055; z <= 0.0551; z += 0.005) {
            for (const double depth : {-0.003, -0.001, 0.0, 0.0005, 0.003}) {
                const auto exact = truth.exact(x, z, depth);
                const auto got = map.patch(x, z, depth).exact_counts({x, z, depth});
                ASSERT_NEAR(got[0], exact[0] * 1e6, 1e-2) << x << ' ' << z << ' ' << depth;  // 10 nm
                ASSERT_NEAR(got[1], exact[1] * 1e6, 1e-2) << x << ' ' << z << ' ' << depth;
            }
        }
    }
}

/// Largest error, in µm, so far from a patch's place, on a surface that slopes so much.
double worst_over_a_patch(double surface_slope, double away) {
    const Truth truth;
    FieldMap map(head());
    map.set(truth.field());
    std::mt19937_64 random(5);
    std::uniform_real_distribution<double> field(-0.055, 0.055);
    std::uniform_real_distribution<double> deep(-0.001, 0.001);
    std::uniform_real_distribution<double> angle(0.0, 6.283185307179586);
    double worst = 0.0;
    for (int i = 0; i < 50'000; ++i) {
        const double x = field(random);
        const double z = field(random);
        const double depth = deep(random);
        const double way = angle(random);
        const double to_x = x + away * std::cos(way);
        const double to_z = z + away * std::sin(way);
        const double to_depth = depth + away * surface_slope * std::cos(angle(random));
        const auto exact = truth.exact(to_x, to_z, to_depth);
        const auto got = map.patch(x, z, depth).exact_counts({to_x, to_z, to_depth});
        worst = std::max(worst, std::hypot(got[0] - exact[0] * 1e6, got[1] - exact[1] * 1e6));
    }
    return worst;
}

TEST(FieldMap, IsWithinAThirdOfAMicrometreForTheFramesThatShareAPatch) {
    EXPECT_LT(worst_over_a_patch(0.0, 0.25e-3), 0.2);
    EXPECT_LT(worst_over_a_patch(0.1, 0.25e-3), 0.2);
    // Depth and place multiply: a wall of 1 : 1 at full speed costs this much.
    EXPECT_LT(worst_over_a_patch(1.0, 0.25e-3), 0.9);
    // The most that share one: 32 frames, at 2 m/s.
    EXPECT_LT(worst_over_a_patch(0.0, 0.32e-3), 0.33);
    EXPECT_LT(worst_over_a_patch(0.1, 0.32e-3), 0.33);
}

TEST(FieldMap, GoesOnStraightBeyondItsSquare) {
    const Truth truth;
    FieldMap map(head());
    map.set(truth.field(0.040));
    const auto inside = map.patch(0.0399, 0.01, 0.0).exact_counts({0.0399, 0.01, 0.0});
    const auto edge = map.patch(0.0401, 0.01, 0.0).exact_counts({0.0401, 0.01, 0.0});
    const auto out = map.patch(0.050, 0.01, 0.0).exact_counts({0.050, 0.01, 0.0});
    EXPECT_NEAR((edge[0] - inside[0]) / 0.2, (out[0] - edge[0]) / 9.9, 2.0);
}

TEST(FieldMap, AnEmptyFieldGivesTheMatrixBack) {
    FieldMap map(head());
    map.set(Truth{}.field());
    EXPECT_NE(map.patch(0.03, 0.03, 0.0).counts({0.03, 0.03, 0.0})[0], 30'000);
    map.set(GalvoField{});
    EXPECT_EQ(map.patch(0.03, 0.03, 0.0).counts({0.03, 0.03, 0.0})[0], 30'000);
}

TEST(GalvoField, IsSoundOnlyNearWhatALensNeeds) {
    const GalvoField good = Truth{}.field();
    EXPECT_TRUE(sound(good));
    EXPECT_FALSE(sound(GalvoField{}));
    constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
    constexpr double kInf = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < GalvoField::kNumbers; ++i) {
        for (const double bad : {kNan, kInf, -kInf}) {
            GalvoField field = good;
            field.set_number(i, bad);
            ASSERT_FALSE(sound(field)) << i << ' ' << bad;
        }
    }
    for (std::size_t i = 8; i < GalvoField::kNumbers; ++i) {
        GalvoField field = good;
        field.set_number(i, field.number(i) + 5e-3);
        ASSERT_FALSE(sound(field)) << "node " << i << " 5 mm off";
    }
    GalvoField mirrored = good;
    for (std::size_t i = 0; i < GalvoField::kNodes; ++i) {
        mirrored.node[2 * i] = -mirrored.node[2 * i];
    }
    EXPECT_FALSE(sound(mirrored));
}

TEST(GalvoField, NumbersGoThereAndBack) {
    const GalvoField field = Truth{}.field();
    GalvoField back;
    for (std::size_t i = 0; i < GalvoField::kNumbers; ++i) {
        back.set_number(i, field.number(i));
    }
    EXPECT_EQ(back, field);
}

}  // namespace
}  // namespace sc::laser

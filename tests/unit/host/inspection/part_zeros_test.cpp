// SPDX-License-Identifier: Apache-2.0
#include "host/inspection/part_zeros.hpp"

#include <gtest/gtest.h>

#include "tests/unit/host/inspection/shapes.hpp"

namespace sc::host {
namespace {

BlankModel published() { return read_blank_model(test::casting("published.toml")); }
std::vector<Vec3> published_zeros(const BlankModel& model) {
    std::vector<Vec3> out;
    for (const PartZero& zero : model.zeros) {
        out.push_back(zero.place);
    }
    return out;
}

TEST(PartZeros, AtThePublishedPlacesGiveThePublishedTable) {
    const BlankModel model = published();
    ASSERT_EQ(model.features.size(), 12U);
    ASSERT_EQ(model.tolerances.size(), 15U);
    const ZeroEvaluation at = evaluate_zeros(model, published_zeros(model));
    const std::vector<double> table{2.75552, 1.48859,  3.09493,  4.99987,  2.54021, 2.4056,
                                    0.5,     0.744214, 0.744214, 0.744214, 0.75,    0.75};
    for (std::size_t i = 0; i < table.size(); ++i) {
        EXPECT_NEAR(1e3 * at.allowance[i], table[i], 5e-5) << model.features[i].name;
    }
    EXPECT_NEAR(1e3 * at.least_radial, 1.489, 1e-3);
    EXPECT_NEAR(1e3 * at.least_axial, 0.500, 1e-3);
    EXPECT_NEAR(at.tolerance_error, 0.0, 1e-3);
}

TEST(PartZeros, AreFoundWithAllTolerancesCentredAndNeverLessMetal) {
    const BlankModel model = published();
    const ZeroPlacement found = place_zeros(model);
    ASSERT_TRUE(found.feasible);
    EXPECT_NEAR(found.at.tolerance_error, 0.0, 1e-7);
    EXPECT_GE(found.at.least_margin, evaluate_zeros(model, published_zeros(model)).least_margin - 1e-9);
    EXPECT_GE(1e3 * found.at.least_axial, 0.5 - 1e-6);
    EXPECT_LE(found.kkt_residual, 1e-9);
    // Recheck that no common shift of the zeros gives more: a grid about the answer, by the formulas alone.
    for (int i = -2; i <= 2; ++i) {
        for (int k = -2; k <= 2; ++k) {
            for (int back = -2; back <= 2; ++back) {
                std::vector<Vec3> moved = found.zeros;
                for (Vec3& zero : moved) {
                    zero = zero + Vec3{0.0, 2e-5 * i, 2e-5 * k};
                }
                moved[2].x += 2e-5 * back;
                EXPECT_LE(evaluate_zeros(model, moved).least_margin, found.at.least_margin + 1e-9);
            }
        }
    }
}

TEST(PartZeros, RefuseWhatNoPlaceCanGive) {
    BlankModel model = published();
    model.min_allowance = 2e-3;  // righthole1 has 1.5 at best
    EXPECT_FALSE(place_zeros(model).feasible);
}

}  // namespace
}  // namespace sc::host

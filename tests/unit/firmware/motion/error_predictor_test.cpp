// SPDX-License-Identifier: Apache-2.0
#include "firmware/motion/error_predictor.hpp"

#include <cmath>

#include <gtest/gtest.h>

namespace sc::motion {
namespace {

constexpr double kTwoPi = 6.283185307179586;

/// Root mean square of a swing's prediction by `ahead`, of the swing's; samples on a grid.
double left_over(const ErrorPredictor::Design& design, double frequency, double ahead) {
    ErrorPredictor predictor(design);
    double left = 0.0;
    double all = 0.0;
    for (int n = 0; n < 4000; ++n) {
        const double t = n * design.sample_s;
        const double seen = std::round(design.amplitude * std::sin(kTwoPi * frequency * t) / design.grid) * design.grid;
        predictor.sample(seen, design.sample_s);
        if (n > 500) {
            const double truth = design.amplitude * std::sin(kTwoPi * frequency * (t + ahead));
            left += (truth - predictor.error(ahead)) * (truth - predictor.error(ahead));
            all += truth * truth;
        }
    }
    return std::sqrt(left / all);
}

TEST(ErrorPredictor, GainsAreThoseOfRiccatisSteadyState) {
    // For a jerk drawn once a sample the steady state obeys, with gains α, β = gain₁ T, γ = gain₂ T²,
    // and Λ² the ratio of the jerk's place noise to the grid's: a filter with these gains must reproduce its own
    // covariance. Solved here by iterating the scalar form of the Joseph update with other arithmetic.
    const ErrorPredictor::Design design{1e-3, 1e-6, 50e-6, 20.0};
    const ErrorPredictor predictor(design);
    const double w = kTwoPi * design.bandwidth_hz;
    const long double q = 50e-6L * 50e-6L * std::pow(static_cast<long double>(w), 5.0L) / 1e-3L;
    const long double r = 1e-12L / 12.0L;
    const long double t = 1e-3L;
    long double p00 = 1e-8L;
    long double p01 = 0.0L;
    long double p02 = 0.0L;
    long double p11 = 1e-3L;
    long double p12 = 0.0L;
    long double p22 = 1e2L;
    long double k0 = 0.0L;
    long double k1 = 0.0L;
    long double k2 = 0.0L;
    for (int i = 0; i < 5000; ++i) {
        const long double h = 0.5L * t * t;
        const long double n00 = p00 + 2 * t * p01 + t * t * p11 + 2 * h * p02 + 2 * h * t * p12 + h * h * p22;
        const long double n01 = p01 + t * p11 + h * p12 + t * (p02 + t * p12 + h * p22);
        const long double n02 = p02 + t * p12 + h * p22;
        const long double n11 = p11 + 2 * t * p12 + t * t * p22;
        const long double n12 = p12 + t * p22;
        const long double g0 = t * t * t / 6.0L;
        p00 = n00 + g0 * g0 * q;
        p01 = n01 + g0 * h * q;
        p02 = n02 + g0 * t * q;
        p11 = n11 + h * h * q;
        p12 = n12 + h * t * q;
        p22 = p22 + t * t * q;
        const long double s = p00 + r;
        k0 = p00 / s;
        k1 = p01 / s;
        k2 = p02 / s;
        p22 -= k2 * p02;
        p12 -= k1 * p02;
        p11 -= k1 * p01;
        p02 -= k0 * p02;
        p01 -= k0 * p01;
        p00 -= k0 * p00;
    }
    EXPECT_NEAR(predictor.gains()[0], static_cast<double>(k0), 1e-6);
    EXPECT_NEAR(predictor.gains()[1] / static_cast<double>(k1), 1.0, 1e-6);
    EXPECT_NEAR(predictor.gains()[2] / static_cast<double>(k2), 1.0, 1e-6);
}

TEST(ErrorPredictor, ASwingOfItsBandwidthIsPredicted) {
    EXPECT_LT(left_over({1e-3, 0.1e-6, 50e-6, 20.0}, 20.0, 2.2e-3), 0.03);
    EXPECT_LT(left_over({2e-3, 1e-6, 50e-6, 20.0}, 20.0, 4.2e-3), 0.15);
}

TEST(ErrorPredictor, IsBetterThanHoldingOrGoingStraightOn) {
    const ErrorPredictor::Design design{2e-3, 1e-6, 50e-6, 20.0};
    const double w = kTwoPi * 20.0;
    const double ahead = 4.2e-3;
    EXPECT_LT(left_over(design, 20.0, ahead), 0.4 * (w * ahead)) << "held: w h";
    EXPECT_LT(left_over(design, 20.0, ahead), 0.8 * 0.5 * (w * ahead) * (w * ahead)) << "straight on: (w h)² / 2";
}

TEST(ErrorPredictor, ASlowErrorIsTakenUpWhole) {
    ErrorPredictor predictor({1e-3, 1e-6, 50e-6, 20.0});
    for (int n = 0; n < 300; ++n) {
        predictor.sample(30e-6 + 1e-3 * n * 1e-3, 1e-3);
    }
    EXPECT_NEAR(predictor.error(2e-3), 30e-6 + 1e-3 * (299 + 2) * 1e-3, 1e-9);
    EXPECT_NEAR(predictor.speed(0.0), 1e-3, 1e-7);
    predictor.restart(5e-6);
    EXPECT_EQ(predictor.error(1.0), 5e-6);
}

TEST(ErrorPredictor, ACoarserGridMakesItTrustLess) {
    const ErrorPredictor fine({1e-3, 0.1e-6, 50e-6, 20.0});
    const ErrorPredictor coarse({1e-3, 4e-6, 50e-6, 20.0});
    EXPECT_GT(fine.gains()[0], coarse.gains()[0]);
    EXPECT_GT(coarse.gains()[0], 0.3);
    EXPECT_LT(fine.gains()[0], 1.0);
}

}  // namespace
}  // namespace sc::motion

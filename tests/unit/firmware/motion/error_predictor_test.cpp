// SPDX-License-Identifier: Apache-2.0
#include "firmware/motion/error_predictor.hpp"

#include <array>
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
    // The same equation in other arithmetic: exact sine and cosine, Joseph's form of the update, far more rounds.
    const ErrorPredictor::Design design{1e-3, 1e-6, 50e-6, 20.0};
    const ErrorPredictor predictor(design);
    const long double t = 1e-3L;
    const long double w = 2.0L * 3.14159265358979323846L * 20.0L;
    const long double swing = std::sqrt(0.6L) * w;
    const long double q = 0.5L * 50e-6L * 50e-6L * std::pow(w, 6.0L) * (4.0L / 175.0L) / (20.0L * t);
    const long double r = 1e-12L / 12.0L;
    const long double s = std::sin(swing * t);
    const long double c = std::cos(swing * t);
    using Matrix = std::array<std::array<long double, 3>, 3>;
    const Matrix f{{{1.0L, s / swing, (1.0L - c) / (swing * swing)}, {0.0L, c, s / swing}, {0.0L, -swing * s, c}}};
    const std::array<long double, 3> g{t * t * t / 6.0L, t * t / 2.0L, t};
    Matrix p{{{1e-8L, 0.0L, 0.0L}, {0.0L, 1e-3L, 0.0L}, {0.0L, 0.0L, 1e2L}}};
    std::array<long double, 3> gain{};
    const auto mapped = [](const Matrix& a, const Matrix& b) {
        Matrix out{};
        for (std::size_t i = 0; i < 3; ++i) {
            for (std::size_t j = 0; j < 3; ++j) {
                for (std::size_t k = 0; k < 3; ++k) {
                    for (std::size_t l = 0; l < 3; ++l) {
                        out[i][j] += a[i][k] * b[k][l] * a[j][l];
                    }
                }
            }
        }
        return out;
    };
    for (int round = 0; round < 5000; ++round) {
        p = mapped(f, p);
        for (std::size_t i = 0; i < 3; ++i) {
            for (std::size_t j = 0; j < 3; ++j) {
                p[i][j] += g[i] * g[j] * q;
            }
        }
        const long double all = p[0][0] + r;
        gain = {p[0][0] / all, p[1][0] / all, p[2][0] / all};
        Matrix left{{{1.0L - gain[0], 0.0L, 0.0L}, {-gain[1], 1.0L, 0.0L}, {-gain[2], 0.0L, 1.0L}}};
        p = mapped(left, p);
        for (std::size_t i = 0; i < 3; ++i) {
            for (std::size_t j = 0; j < 3; ++j) {
                p[i][j] += gain[i] * gain[j] * r;
            }
        }
    }
    for (std::size_t i = 0; i < 3; ++i) {
        EXPECT_NEAR(predictor.gains()[i] / static_cast<double>(gain[i]), 1.0, 1e-6) << i;
    }
}

TEST(ErrorPredictor, ASwingOfItsBandwidthIsPredicted) {
    EXPECT_LT(left_over({1e-3, 0.1e-6, 50e-6, 20.0}, 20.0, 2.2e-3), 0.03);
    EXPECT_LT(left_over({2e-3, 1e-6, 50e-6, 20.0}, 20.0, 4.2e-3), 0.1);
}

TEST(ErrorPredictor, WhatIsSlowerIsPredictedToo) {
    for (const double frequency : {0.5, 2.0, 5.0, 10.0, 15.0}) {
        EXPECT_LT(left_over({1e-3, 0.1e-6, 50e-6, 20.0}, frequency, 2.2e-3), 0.01) << frequency;
        EXPECT_LT(left_over({2e-3, 1e-6, 50e-6, 20.0}, frequency, 4.2e-3), 0.1) << frequency;
    }
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
        predictor.sample(30e-6, 1e-3);
    }
    EXPECT_NEAR(predictor.error(2e-3), 30e-6, 1e-9);
    EXPECT_NEAR(predictor.speed(0.0), 0.0, 1e-7);
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

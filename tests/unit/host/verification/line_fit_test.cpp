// SPDX-License-Identifier: Apache-2.0
#include "host/verification/line_fit.hpp"

#include <array>
#include <cmath>
#include <random>

#include <gtest/gtest.h>

namespace sc::host {
namespace {

TEST(FitLine, FindsALineOfAnyDirection) {
    for (double angle = -1.6; angle < 1.6; angle += 0.1) {
        const Flat u{std::cos(angle), std::sin(angle)};
        std::vector<Flat> places;
        for (int i = 0; i <= 100; ++i) {
            places.push_back(Flat{-0.3, -0.4} + (i * 40e-6) * u);
        }
        const auto line = fit_line(places);
        ASSERT_TRUE(line);
        EXPECT_NEAR(std::abs(cross(line->direction, u)), 0.0, 1e-10);
        EXPECT_NEAR(line->extent(), 4e-3, 1e-12);
        EXPECT_LT(line->rms, 1e-14);
        EXPECT_NEAR(length(line->point - (Flat{-0.3, -0.4} + 2e-3 * u)), 0.0, 1e-12);
    }
}

TEST(FitLine, LeavesOutliersOut) {
    std::mt19937 random(2);
    std::normal_distribution<double> noise(0.0, 5e-6);
    std::vector<Flat> places;
    for (int i = 0; i <= 200; ++i) {
        places.push_back({i * 20e-6, noise(random)});
    }
    const auto clean = fit_line(places);
    places.push_back({1e-3, 120e-6});
    places.push_back({2e-3, 90e-6});
    const auto spoilt = fit_line(places);
    ASSERT_TRUE(clean && spoilt);
    EXPECT_FALSE(spoilt->counts[201]);
    EXPECT_FALSE(spoilt->counts[202]);
    EXPECT_NEAR(spoilt->off({2e-3, 0.0}), clean->off({2e-3, 0.0}), 0.2e-6);
}

TEST(FitLine, ErrorFallsAsTheStatisticsSay) {
    std::mt19937 random(4);
    std::normal_distribution<double> noise(0.0, 5e-6);
    double squares = 0.0;
    constexpr int kTrials = 400;
    for (int trial = 0; trial < kTrials; ++trial) {
        std::vector<Flat> places;
        for (int i = 0; i <= 200; ++i) {
            places.push_back({i * 20e-6 + noise(random), noise(random)});
        }
        const double off = fit_line(places)->off({2e-3, 0.0});
        squares += off * off;
    }
    const double expected = 5e-6 / std::sqrt(201.0);
    EXPECT_NEAR(std::sqrt(squares / kTrials), expected, 0.15 * expected);
}

TEST(FitLine, TellsRmsAndSwing) {
    std::vector<Flat> places;
    for (int i = 0; i < 100; ++i) {
        places.push_back({i * 1e-4, i % 4 == 0 || i % 4 == 3 ? 3e-6 : -3e-6});
    }
    const auto line = fit_line(places);
    ASSERT_TRUE(line);
    EXPECT_NEAR(line->rms, 3e-6, 1e-8);
    EXPECT_NEAR(line->swing, 6e-6, 1e-8);
}

TEST(FitLine, RefusesPlacesThatAreOne) {
    EXPECT_FALSE(fit_line({}));
    EXPECT_FALSE(fit_line(std::array{Flat{1.0, 2.0}}));
    EXPECT_FALSE(fit_line(std::array{Flat{1.0, 2.0}, Flat{1.0, 2.0}}));
}

TEST(FitTrend, IsExactForALineAndFlatWithoutSpread) {
    const std::array<double, 3> s{0.0, 1.0, 2.0};
    const std::array<double, 3> v{5.0, 7.0, 9.0};
    const Trend trend = fit_trend(s, v, {true, true, true});
    EXPECT_NEAR(trend.at(10.0), 25.0, 1e-12);
    const Trend without_last = fit_trend(s, std::array<double, 3>{5.0, 7.0, 100.0}, {true, true, false});
    EXPECT_NEAR(without_last.at(10.0), 25.0, 1e-12);
    EXPECT_EQ(fit_trend(std::array{1.0, 1.0}, std::array{3.0, 5.0}, {true, true}).at(9.0), 4.0);
}

TEST(MeetingPoint, IsOnBothLines) {
    const auto a = fit_line(std::array{Flat{0.0, 0.0}, Flat{1.0, 0.5}});
    const auto b = fit_line(std::array{Flat{0.0, 1.0}, Flat{1.0, -1.0}});
    const auto p = meeting_point(*a, *b);
    ASSERT_TRUE(p);
    EXPECT_NEAR(a->off(*p), 0.0, 1e-12);
    EXPECT_NEAR(b->off(*p), 0.0, 1e-12);
    EXPECT_FALSE(meeting_point(*a, *a));
}

}  // namespace
}  // namespace sc::host

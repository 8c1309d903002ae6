// SPDX-License-Identifier: Apache-2.0
#include "host/bridge/progress.hpp"

#include <gtest/gtest.h>

#include "tests/unit/host/bridge/fake_cell.hpp"

namespace sc::host {
namespace {

constexpr Nanoseconds kSecond{1'000'000'000};

TEST(ProgressEstimate, LongSlowLinesWeighMoreThanManyShortOnes) {
    std::vector<Item> items;
    const auto line = [&](std::uint32_t path, std::int32_t length) {
        items.emplace_back(PathBegin{.path = path, .speed_um_s = 10'000});
        items.emplace_back(PathPoint{});
        items.emplace_back(PathPoint{length, 0, 0});
        items.emplace_back(PathEnd{});
    };
    line(1, 1000);
    line(2, 1000);
    line(3, 10'000'000);  // 100 mm: 10 s
    const ProgressEstimate estimate(items, 0.0);
    EXPECT_EQ(estimate.fraction(0), 0.0);
    EXPECT_LT(estimate.fraction(8), 0.2);
    EXPECT_EQ(estimate.fraction(12), 1.0);
    EXPECT_EQ(estimate.fraction(999), 1.0);
}

TEST(ProgressEstimate, TimeLeftComesFromThePlanAtFirstAndFromThePaceLater) {
    const ProgressEstimate estimate(test::example_items(2, 10), 100.0);
    EXPECT_NEAR(static_cast<double>(estimate.left(0.0, Nanoseconds(0))->count()), 100e9, 1.0);
    // Twice as slow as planned: with half done the truth lies between plan and pace.
    const auto left = estimate.left(0.5, 100 * kSecond);
    EXPECT_GT(*left, 50 * kSecond);
    EXPECT_LE(*left, 100 * kSecond);
    EXPECT_NEAR(static_cast<double>(estimate.left(0.99, 198 * kSecond)->count()), 2e9, 0.1e9);
    EXPECT_EQ(*estimate.left(1.0, 200 * kSecond), Nanoseconds(0));
}

TEST(ProgressEstimate, KnowsNothingWithoutPlanOrPace) {
    const ProgressEstimate estimate(test::example_items(2, 10), 0.0);
    EXPECT_FALSE(estimate.left(0.0, kSecond).has_value());
    EXPECT_NEAR(static_cast<double>(estimate.left(0.25, kSecond)->count()), 3e9, 1.0);
}

TEST(ProgressEstimate, AnEmptyJobIsDone) {
    const ProgressEstimate estimate({}, 0.0);
    EXPECT_EQ(estimate.fraction(0), 1.0);
}

}  // namespace
}  // namespace sc::host

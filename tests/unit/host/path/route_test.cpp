// SPDX-License-Identifier: Apache-2.0
#include "host/path/route.hpp"

#include <algorithm>
#include <numeric>
#include <random>

#include <gtest/gtest.h>

namespace sc::host {
namespace {

TEST(NearestFirst, GoesDownARow) {
    const std::vector<Vec3> places{{0.3, 0.0, 0.0}, {0.1, 0.0, 0.0}, {0.2, 0.0, 0.0}};
    EXPECT_EQ(nearest_first({0.0, 0.0, 0.0}, places), (std::vector<std::size_t>{1, 2, 0}));
    EXPECT_EQ(nearest_first({0.4, 0.0, 0.0}, places), (std::vector<std::size_t>{0, 2, 1}));
}

TEST(NearestFirst, TakesEachPlaceOnceAndNeverPassesANearerOne) {
    std::mt19937 random(3);
    std::uniform_real_distribution<double> any(-0.2, 0.2);
    std::vector<Vec3> places;
    for (int i = 0; i < 40; ++i) {
        places.push_back({any(random), any(random), any(random)});
    }
    const std::vector<std::size_t> order = nearest_first({}, places);
    std::vector<std::size_t> sorted = order;
    std::ranges::sort(sorted);
    std::vector<std::size_t> all(places.size());
    std::iota(all.begin(), all.end(), 0U);
    EXPECT_EQ(sorted, all);
    Vec3 at;
    for (std::size_t i = 0; i < order.size(); ++i) {
        for (std::size_t later = i + 1; later < order.size(); ++later) {
            EXPECT_LE(across(at, places[order[i]]), across(at, places[order[later]]));
        }
        at = places[order[i]];
    }
}

TEST(NearestFirst, KeepsTheGivenOrderOfEquals) {
    const std::vector<Vec3> places{{0.1, 0.0, 0.0}, {0.0, 0.0, 0.1}, {-0.1, 0.0, 0.0}};
    EXPECT_EQ(nearest_first({}, places).front(), 0U);
}

TEST(NearestFirst, IsEmptyForNoPlaces) { EXPECT_TRUE(nearest_first({}, {}).empty()); }

TEST(OrderPair, IsNeverLongerThanAnyOtherOrder) {
    std::mt19937 random(5);
    std::uniform_real_distribution<double> any(-0.01, 0.01);
    const auto place = [&] { return Vec3{any(random), 0.0, any(random)}; };
    for (int trial = 0; trial < 200; ++trial) {
        const Vec3 at = place();
        const Stroke a{place(), place()};
        const Stroke b{place(), place()};
        const StrokeOrder order = order_pair(at, a, b);
        const double way = across(at, order.first.from) + across(order.first.to, order.second.from);
        for (const auto& [first, second] : {std::pair{a, b}, std::pair{b, a}}) {
            for (const Stroke& f : {first, Stroke{first.to, first.from}}) {
                for (const Stroke& s : {second, Stroke{second.to, second.from}}) {
                    EXPECT_LE(way, across(at, f.from) + across(f.to, s.from) + 1e-9);
                }
            }
        }
    }
}

}  // namespace
}  // namespace sc::host

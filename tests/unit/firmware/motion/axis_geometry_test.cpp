// SPDX-License-Identifier: Apache-2.0
#include "firmware/motion/axis_geometry.hpp"

#include <cmath>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "firmware/motion/move.hpp"
#include "tests/unit/firmware/motion/sample_map.hpp"

namespace sc::motion {
namespace {

const MachineConfig kMachine = reference_machine();

Compensation small_matrix() {
    Compensation c;
    c.axis_from_h.row[0] = {1.0 + 12e-6, 1.2e-4, -0.8e-4};
    c.axis_from_h.row[1] = {0.0, 1.0 - 8e-6, 1.5e-4};
    c.axis_offset = {3e-6, -2e-6, 1e-6};
    return c;
}

double number(std::int64_t units, std::size_t axis) {
    return static_cast<double>(units) * (axis == index(Axis::c) ? 1e-9 : 1e-12);
}

/// A spline by its definition: the sum of the shifted basis functions, written by cases.
double basis(double x) {
    const double a = std::abs(x);
    if (a >= 2.0) {
        return 0.0;
    }
    return a >= 1.0 ? std::pow(2.0 - a, 3) / 6.0 : 2.0 / 3.0 - a * a + a * a * a / 2.0;
}

double by_definition(const AxisMap::LinearTable& table, double place, double first, double spacing) {
    double sum = 0.0;
    for (std::size_t k = 0; k < kMapCoefficients; ++k) {
        sum +=
            static_cast<double>(table[k]) * 1e-12 * basis((place - first) / spacing - (static_cast<double>(k) - 1.0));
    }
    return sum;
}

double by_definition(const AxisMap::TurnCoefficients& table, double c) {
    double sum = 0.0;
    for (int k = -40; k < 80; ++k) {
        const auto node = static_cast<std::size_t>((k + 72) % 36);
        sum += static_cast<double>(table[node]) * basis(c / kTurnSpacing - k);
    }
    return sum;
}

TEST(AxisGeometry, WithoutAMapItIsTheMatrixInTheSameBits) {
    AxisGeometry geometry(kMachine);
    geometry.set(small_matrix());
    geometry.set(AxisMap{}, {});
    EXPECT_FALSE(geometry.mapped());
    std::mt19937_64 random(1);
    std::uniform_real_distribution<double> some(-0.4, 0.0);
    for (int i = 0; i < 2000; ++i) {
        const Place place{some(random), some(random), some(random), 300.0 * some(random)};
        const AxisPositions axes = geometry.set_point_of(place);
        EXPECT_EQ(axes, set_point_of(small_matrix(), place));
        EXPECT_EQ(geometry.place_of(axes), place_of(small_matrix(), axes));
    }
}

TEST(AxisGeometry, AddsTheTablesAsTheyAreDefined) {
    AxisMap map = test::sample_map();
    map.backlash = {};
    AxisGeometry geometry(kMachine);
    geometry.set(small_matrix());
    geometry.set(map, {});
    const auto turn = [&](TurnTable t, double c) {
        return by_definition(map.turn[static_cast<std::size_t>(t)], c) * 1e-12;
    };
    std::mt19937_64 random(2);
    std::uniform_real_distribution<double> some(0.0, 1.0);
    for (int i = 0; i < 500; ++i) {
        const Place place{-0.45 * some(random), -0.4 * some(random), -0.5 * some(random), 730.0 * some(random) - 365.0};
        const double c = place[3];
        const Vec3 r = Vec3{place[0], place[1], place[2]} - map.pivot;
        const Vec3 tilt{turn(TurnTable::tilt_x, c), turn(TurnTable::tilt_y, c), 0.0};
        const Vec3 shift{turn(TurnTable::shift_x, c), turn(TurnTable::shift_y, c), turn(TurnTable::shift_z, c)};
        const Vec3 moved = Vec3{place[0], place[1], place[2]} + shift + cross(tilt, r);
        const Vec3 nominal = axes_from_h(small_matrix(), moved);
        const AxisPositions axes = geometry.set_point_of(place);
        for (std::size_t k = 0; k < 3; ++k) {
            double wanted = nominal[k];
            for (std::size_t j = 0; j < 3; ++j) {
                wanted += by_definition(map.linear[k][j], nominal[j], map.first[j], map.spacing[j]);
            }
            EXPECT_NEAR(number(axes[k], k), wanted, 1e-12) << "axis " << k;
        }
        EXPECT_NEAR(number(axes[3], 3), c + by_definition(map.turn[0], c) * 1e-9, 1.1e-9);
    }
}

TEST(AxisGeometry, TheInverseLeadsBackToThePicometre) {
    AxisGeometry geometry(kMachine);
    geometry.set(small_matrix());
    geometry.set(test::sample_map(), {});
    std::mt19937_64 random(3);
    std::uniform_real_distribution<double> some(0.0, 1.0);
    for (int i = 0; i < 2000; ++i) {
        const Place place{-0.45 * some(random), -0.4 * some(random), -0.5 * some(random), 730.0 * some(random) - 365.0};
        const AxisPositions axes = geometry.set_point_of(place);
        const Place back = geometry.place_of(axes);
        for (std::size_t k = 0; k < kAxisCount; ++k) {
            EXPECT_NEAR(back[k], place[k], k == 3 ? 2e-9 : 2e-12);
        }
    }
}

/// Largest first to third difference of the set-points of moves at the limits that the map leaves, over the limits.
double worst_ratio(const AxisMap& map, const std::vector<Place>& stops) {
    MapCost cost;
    EXPECT_EQ(check_map(kMachine, map, cost).refusal, Refusal::none);
    AxisLimits limits;
    for (std::size_t i = 0; i < kAxisCount; ++i) {
        limits.speed[i] = kMachine.axis[i].speed - cost.speed[i];
        limits.acceleration[i] = kMachine.axis[i].acceleration - cost.acceleration[i];
        limits.jerk[i] = kMachine.axis[i].jerk - cost.jerk[i];
    }
    AxisGeometry geometry(kMachine);
    geometry.set(map, {});
    std::vector<AxisPositions> trace;
    for (std::size_t s = 1; s < stops.size(); ++s) {
        Move move;
        move.begin(stops[s - 1], stops[s], limits, 1e30);
        for (int tick = 0; 1e-3 * tick < move.duration(); ++tick) {
            trace.push_back(geometry.set_point_of(move.at(1e-3 * tick)));
        }
    }
    double worst = 0.0;
    for (std::size_t n = 3; n < trace.size(); ++n) {
        for (std::size_t i = 0; i < kAxisCount; ++i) {
            const auto at = [&](std::size_t back) { return number(trace[n - back][i], i); };
            const double v = (at(0) - at(1)) / 1e-3;
            const double a = (at(0) - 2.0 * at(1) + at(2)) / 1e-6;
            const double j = (at(0) - 3.0 * at(1) + 3.0 * at(2) - at(3)) / 1e-9;
            // Rounding of four set-points by half a unit each.
            const double grid = i == 3 ? 4.0 : 0.004;
            worst = std::max({worst, std::abs(v) / kMachine.axis[i].speed, std::abs(a) / kMachine.axis[i].acceleration,
                              (std::abs(j) - grid) / kMachine.axis[i].jerk});
        }
    }
    return worst;
}

TEST(AxisGeometry, SetPointsKeepTheLimitsAtFullSpeedAndThroughReversals) {
    std::mt19937_64 random(4);
    std::uniform_real_distribution<double> some(0.0, 1.0);
    std::vector<Place> stops{{0.0, 0.0, 0.0, 0.0}};
    for (int i = 0; i < 40; ++i) {
        stops.push_back({-0.45 * some(random), -0.4 * some(random), -0.5 * some(random), stops.back()[3]});
        Place turned = stops.back();
        turned[3] = 700.0 * some(random) - 350.0;
        stops.push_back(turned);
        // Short ways back and forth, within and beyond the time of a take-up.
        for (const double way : {2e-6, -1e-6, 30e-6, -40e-6, 1e-3, -2e-3}) {
            Place near = stops.back();
            near[static_cast<std::size_t>(i) % 3] += way;
            stops.push_back(near);
        }
    }
    const double worst = worst_ratio(test::sample_map(), stops);
    EXPECT_LE(worst, 1.0 + 1e-9);
    EXPECT_GT(worst, 0.9) << "the moves do not reach the limits";
}

TEST(Backlash, StandsHalfAWidthToTheSideOfTheLastMotion) {
    Backlash backlash(20e-6, 0.5e-6, 40.0);
    backlash.step(0.1);
    EXPECT_EQ(backlash.offset(), 0.0) << "unknown before the first motion";
    double place = 0.1;
    const auto move = [&](double way, int ticks) {
        for (int i = 0; i < ticks; ++i) {
            place += way;
            backlash.step(place);
        }
    };
    move(10e-6, 60);
    EXPECT_DOUBLE_EQ(backlash.offset(), 10e-6);
    move(-0.1e-6, 4);
    EXPECT_DOUBLE_EQ(backlash.offset(), 10e-6) << "within the dead band";
    move(-10e-6, 20);
    EXPECT_GT(backlash.offset(), -9e-6);
    EXPECT_LT(backlash.offset(), 9e-6);
    move(0.0, 30);
    EXPECT_DOUBLE_EQ(backlash.offset(), -10e-6);
}

TEST(Backlash, ATurnBackMeanwhileWaitsForTheEndOfTheCrossing) {
    Backlash backlash(20e-6, 0.5e-6, 40.0);
    double place = 0.0;
    double before = 0.0;
    double largest = 0.0;
    std::mt19937_64 random(5);
    backlash.step(place);
    double last_step = 0.0;
    double last_change = 0.0;
    for (int i = 0; i < 20'000; ++i) {
        place += (random() % 7 < 3 ? -3e-6 : 3e-6);
        backlash.step(place);
        const double step = backlash.offset() - before;
        const double change = step - last_step;
        largest = std::max(largest, std::abs(change - last_change));
        last_change = change;
        last_step = step;
        before = backlash.offset();
    }
    EXPECT_LE(largest, 32.0 * 20e-6 / std::pow(40.0, 3) * (1.0 + 1e-9));
    EXPECT_GT(largest, 16.0 * 20e-6 / std::pow(40.0, 3));
}

}  // namespace
}  // namespace sc::motion

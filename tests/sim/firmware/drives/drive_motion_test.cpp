// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include "drive_loop.hpp"
#include "firmware/safety/watch.hpp"

namespace sc {
namespace {

using test::DriveLoop;

/// A rest-to-rest move under the axis' own limits: 3 phases up, cruise, 3 phases down. Position at time t, in base
/// units, by summing the exact cubic of each phase.
class SCurve {
public:
    SCurve(const AxisConfig& axis, double speed, double cruise_s) {
        const double jerk = axis.jerk;
        double ramp = axis.acceleration / jerk;
        double flat = speed / axis.acceleration - ramp;
        if (flat < 0.0) {
            ramp = std::sqrt(speed / jerk);
            flat = 0.0;
        }
        phases_ = {{jerk, ramp}, {0, flat}, {-jerk, ramp}, {0, cruise_s}, {-jerk, ramp}, {0, flat}, {jerk, ramp}};
        cruise_from_ = 2 * ramp + flat;
        cruise_to_ = cruise_from_ + cruise_s;
        end_ = cruise_to_ + 2 * ramp + flat;
    }
    [[nodiscard]] double at(double t) const {
        double p = 0.0;
        double v = 0.0;
        double a = 0.0;
        for (const auto& [jerk, duration] : phases_) {
            const double d = std::clamp(t, 0.0, duration);
            p += d * (v + d * (a / 2 + d * jerk / 6));
            v += d * (a + d * jerk / 2);
            a += d * jerk;
            t -= d;
        }
        return p;
    }
    [[nodiscard]] double cruise_from() const { return cruise_from_; }
    [[nodiscard]] double cruise_to() const { return cruise_to_; }
    [[nodiscard]] double end() const { return end_; }

private:
    std::vector<std::pair<double, double>> phases_;
    double cruise_from_ = 0.0;
    double cruise_to_ = 0.0;
    double end_ = 0.0;
};

constexpr double kTickS = 1e-3;

struct Measured {
    double lag_s = 0.0;         ///< mean over the cruise
    double worst_smooth = 0.0;  ///< from the delayed command, whole move, base units
    double settle_error = 0.0;  ///< 50 ms after the end, base units
    double rest_wander = 0.0;   ///< after that, base units
};

Measured move(DriveLoop& loop, std::size_t axis, double speed, double cruise_s, double sign) {
    const SCurve curve(loop.machine.axis[axis], speed, cruise_s);
    const double units = test::units_per_base(axis);
    const std::int64_t start = loop.request.target[axis];
    const double start_base = static_cast<double>(start) / units;
    const std::int64_t first = loop.tick;
    const auto ticks = static_cast<std::int64_t>(curve.end() / kTickS) + 200;
    Measured measured;
    double lag_sum = 0.0;
    int lag_count = 0;
    double rest_low = 1e9;
    double rest_high = -1e9;
    safety::FollowingWatch watch(loop.machine);
    AxisPositions actual{};
    for (std::size_t i = 0; i < kAxisCount; ++i) {
        actual[i] = loop.outcome.axis[i].actual;
    }
    watch.restart(actual);
    for (std::int64_t i = 0; i < ticks; ++i) {
        // The set-point of tick n is due at t_n+1.
        const double due = static_cast<double>(loop.tick + 1 - first) * kTickS;
        const AxisPositions last_target = loop.request.target;
        loop.request.target[axis] = start + std::llround(sign * curve.at(due) * units);
        loop.step();
        for (std::size_t k = 0; k < kAxisCount; ++k) {
            actual[k] = loop.outcome.axis[k].actual;
        }
        EXPECT_FALSE(watch.step(last_target, actual)) << "tick " << i;
        // Odd times too, between the ticks.
        for (const double part : {1.0, 0.63}) {
            const std::int64_t t_ns = loop.tick * 1'000'000 - std::llround((1.0 - part) * 1e6);
            const double now = static_cast<double>(t_ns - first * 1'000'000) * 1e-9;
            const double place = sign * (loop.drives[axis].true_position_at(t_ns) - start_base);
            const double late = static_cast<double>(loop.machine.axis[axis].latency_ns) * 1e-9;
            measured.worst_smooth = std::max(measured.worst_smooth, std::abs(place - curve.at(now - late)));
            if (now > curve.cruise_from() + 0.03 && now < curve.cruise_to()) {
                lag_sum += (curve.at(now) - place) / speed;
                ++lag_count;
            }
            if (now > curve.end() + 0.05) {
                measured.settle_error = std::max(measured.settle_error, std::abs(place - curve.at(now)));
                rest_low = std::min(rest_low, place);
                rest_high = std::max(rest_high, place);
            }
        }
    }
    measured.lag_s = lag_sum / lag_count;
    measured.rest_wander = rest_high - rest_low;
    return measured;
}

void prepare(DriveLoop& loop) {
    ASSERT_TRUE(loop.run(2000, [&] { return loop.outcome.all_present; }));
    ASSERT_TRUE(loop.enable());
    ASSERT_TRUE(loop.home(0x0F));
}

TEST(DriveMotion, LagsByTheDeclaredLatencyAtConstantSpeed) {
    DriveLoop loop;
    prepare(loop);
    for (const double share : {1.0, 0.25, 0.05}) {
        for (std::size_t axis = 0; axis < kAxisCount; ++axis) {
            const double speed = loop.machine.axis[axis].speed * share;
            for (const double sign : {-1.0, 1.0}) {
                const Measured m = move(loop, axis, speed, 0.3, sign);
                // The place counts, at low speed as well: 10 µs at full speed is 2 µm.
                const double error_s = std::abs(m.lag_s - 4e-3);
                EXPECT_LT(error_s * speed, 10e-6 * loop.machine.axis[axis].speed) << axis << " " << speed;
                if (share == 1.0) {
                    EXPECT_LT(error_s, 10e-6) << axis << " " << m.lag_s;
                }
                RecordProperty("lag", std::to_string(m.lag_s));
            }
        }
    }
}

TEST(DriveMotion, FollowsAJerkLimitedMoveWithinOneCount) {
    DriveLoop loop;
    prepare(loop);
    for (std::size_t axis = 0; axis < kAxisCount; ++axis) {
        const Measured m = move(loop, axis, loop.machine.axis[axis].speed, 0.2, -1.0);
        EXPECT_LT(m.worst_smooth, loop.count_of(axis)) << axis;
    }
}

TEST(DriveMotion, SettlesWithinOneCountAndStandsStill) {
    DriveLoop loop;
    prepare(loop);
    for (std::size_t axis = 0; axis < kAxisCount; ++axis) {
        for (const double share : {1.0, 0.313, 0.011}) {
            const Measured m = move(loop, axis, loop.machine.axis[axis].speed * share, 0.05, -1.0);
            EXPECT_LE(m.settle_error, loop.count_of(axis)) << axis;
            EXPECT_LE(m.rest_wander, 0.1 * loop.count_of(axis)) << axis << ": limit cycle";
        }
    }
}

TEST(DriveMotion, HowOftenTheBoardStepsTheDrivesDoesNotMatter) {
    std::vector<double> places[2];
    for (const int way : {0, 1}) {
        DriveLoop loop;
        loop.substep_ns = way == 0 ? 1'000'000 : 10'000;
        prepare(loop);
        const SCurve curve(loop.machine.axis[0], 0.2, 0.1);
        for (int i = 0; i < 600; ++i) {
            loop.request.target[0] = -std::llround(curve.at(i * kTickS) * kPmPerMetre);
            loop.step();
            places[way].push_back(loop.drives[0].true_position());
        }
    }
    ASSERT_EQ(places[0].size(), places[1].size());
    for (std::size_t i = 0; i < places[0].size(); ++i) {
        ASSERT_NEAR(places[0][i], places[1][i], 0.5e-6) << i;
    }
    EXPECT_LT(places[0].back(), -0.01);
}

}  // namespace
}  // namespace sc

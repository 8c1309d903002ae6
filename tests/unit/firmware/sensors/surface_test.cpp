// SPDX-License-Identifier: Apache-2.0
#include "firmware/sensors/surface.hpp"

#include <cmath>
#include <random>

#include <gtest/gtest.h>

namespace {

using namespace sc;
using namespace sc::sensors;
using Verdict = Surface::Verdict;

constexpr std::int64_t kPeriod = 1'000'000;
constexpr std::int64_t kLatency = 4'000'000;

SurfaceSettings settings(SurfaceMode mode) {
    SurfaceSettings s;
    s.mode = mode;
    s.origin = {0.030, 0.0, 0.0};  // 30 mm ahead along +x
    s.direction = {0.0, -1.0, 0.0};
    s.zero = 0.125;
    s.window = 1.5e-3;
    s.bound = 1.0e-3;
    return s;
}

/// A beam that goes along +x at constant speed and constant y before a surface y(x), and a Y sensor read every 5 ms.
class Ride {
public:
    explicit Ride(SurfaceMode mode) { EXPECT_TRUE(surface.set(settings(mode))); }

    template <class Profile>
    void tick(const Profile& profile, bool near = true) {
        ++n;
        place.x += speed * 1e-3;
        past.push_back({place.x, place.y + surface.shift(), place.z});
        if (n % 5 == 0 && past.size() > 6) {
            // Where the axes truly are now: what was commanded five ticks ago (window and latency).
            const Vec3 at = past[past.size() - 6];
            const double depth = profile(at.x + 0.030);
            const double reading = 0.125 + (at.y - depth);
            sample.value = static_cast<SensorValue>(std::lround(reading * 1e8));
            sample.measured_ns = n * kPeriod;
            sample.quality = blind ? Quality::out_of_range : Quality::good;
            ++sample.count;
        }
        surface.step(n * kPeriod, sample, place, near, false);
    }

    Surface surface{kPeriod, kLatency};
    Sample sample;
    Vec3 place{-0.200, -0.330, -0.3};
    std::vector<Vec3> past;
    double speed = 0.020;
    bool blind = false;
    std::int64_t n = 0;
};

constexpr double kFlat = -0.330;
double flat(double) { return kFlat; }

TEST(Surface, RefusesSettingsThatMakeNoSense) {
    Surface surface(kPeriod, kLatency);
    const auto with = [&](auto change) {
        SurfaceSettings s = settings(SurfaceMode::follow);
        change(s);
        return surface.set(s);
    };
    EXPECT_TRUE(with([](SurfaceSettings&) {}));
    EXPECT_FALSE(with([](SurfaceSettings& s) { s.window = 0.0; }));
    EXPECT_FALSE(with([](SurfaceSettings& s) { s.bound = 3e-3; }));
    EXPECT_FALSE(with([](SurfaceSettings& s) { s.bound = 0.0; }));
    EXPECT_FALSE(with([](SurfaceSettings& s) { s.direction = {0.0, 1.0, 0.0}; }));
    EXPECT_FALSE(with([](SurfaceSettings& s) { s.direction = {0.0, -0.5, 0.0}; }));
    EXPECT_FALSE(with([](SurfaceSettings& s) { s.origin.x = std::nan(""); }));
    EXPECT_FALSE(with([](SurfaceSettings& s) { s.zero = 2.0; }));
}

TEST(Surface, WhereItShouldBeIsFine) {
    Ride ride(SurfaceMode::check);
    for (int i = 0; i < 1000; ++i) {
        ride.tick(flat);
    }
    EXPECT_EQ(ride.surface.verdict(), Verdict::fine);
    EXPECT_NEAR(ride.surface.depth(), kFlat, 1e-6);
    EXPECT_EQ(ride.surface.shift(), 0.0);
}

TEST(Surface, FartherThanTheWindowIsOffAndNotSeenIsNotSeen) {
    Ride ride(SurfaceMode::check);
    const auto step = [&](double x) { return x < -0.100 ? kFlat : kFlat - 2e-3; };
    double found_at = 0.0;
    for (int i = 0; i < 6000 && found_at == 0.0; ++i) {
        ride.tick(step);
        if (ride.surface.verdict() == Verdict::off) {
            found_at = ride.place.x;
        }
    }
    // The strip knows the step when the beam comes there, not when the sensor does; the reach of a look-up may bring it
    // forward by a millimetre.
    EXPECT_NEAR(found_at, -0.100, 1.5e-3);

    Ride blind(SurfaceMode::check);
    blind.blind = true;
    for (int i = 0; i < 150; ++i) {
        blind.tick(flat);
    }
    EXPECT_EQ(blind.surface.verdict(), Verdict::not_seen);
}

TEST(Surface, TheFocusFollowsWhatTheSensorSawWhenTheBeamComesThere) {
    Ride ride(SurfaceMode::follow);
    const auto slope = [](double x) { return kFlat + 0.5e-3 * std::sin(2.0 * 3.14159265 * x / 0.060); };
    double worst = 0.0;
    double worst_without = 0.0;
    for (int i = 0; i < 8000; ++i) {
        ride.tick(slope);
        if (i > 3000) {
            const double error = ride.place.y + ride.surface.shift() - slope(ride.place.x);
            worst = std::max(worst, std::abs(error));
            worst_without = std::max(worst_without, std::abs(ride.place.y - slope(ride.place.x)));
        }
    }
    EXPECT_GT(worst_without, 0.49e-3);
    EXPECT_LT(worst, 0.10e-3);
}

TEST(Surface, TheShiftIsBoundedAndSmoothWhateverTheSensorSays) {
    Ride ride(SurfaceMode::follow);
    std::mt19937 random(5);
    std::uniform_real_distribution<double> anywhere(-0.010, 0.010);
    const auto cost = ride.surface.cost();
    std::array<double, 4> last{};
    for (int i = 0; i < 20'000; ++i) {
        ride.speed = i % 500 < 250 ? 0.05 : -0.05;
        ride.tick([&](double) { return kFlat + anywhere(random); }, i % 700 < 600);
        last = {ride.surface.shift(), last[0], last[1], last[2]};
        ASSERT_LE(std::abs(last[0]), 1.0e-3);
        if (i > 4) {
            ASSERT_LE(std::abs(last[0] - last[1]) * 1e3, cost[0]);
            ASSERT_LE(std::abs(last[0] - 2 * last[1] + last[2]) * 1e6, cost[1]);
            ASSERT_LE(std::abs(last[0] - 3 * last[1] + 3 * last[2] - last[3]) * 1e9, cost[2]);
        }
    }
}

TEST(Surface, AwayFromPathsTheShiftReturnsToExactlyZero) {
    Ride ride(SurfaceMode::follow);
    const auto off = [](double) { return kFlat + 0.4e-3; };
    for (int i = 0; i < 2000; ++i) {
        ride.tick(off);
    }
    EXPECT_NEAR(ride.surface.shift(), 0.4e-3, 5e-6);
    EXPECT_TRUE(ride.surface.settled());
    for (int i = 0; i < 4000; ++i) {
        ride.tick(off, false);
    }
    EXPECT_EQ(ride.surface.shift(), 0.0);
}

}  // namespace

// SPDX-License-Identifier: Apache-2.0
#include "firmware/sensors/surface.hpp"

#include <cmath>
#include <functional>
#include <random>
#include <utility>
#include <vector>

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

/// Axes that first carry the sensor, read every 5 ms, along a line before a surface y(x), then the beam along the same
/// line.
class Ride {
public:
    explicit Ride(SurfaceMode mode) { EXPECT_TRUE(surface.set(settings(mode))); }

    template <class Profile>
    void tick(const Profile& profile, bool looking) {
        ++n;
        past.push_back({axes.x, axes.y + surface.shift(), axes.z});
        if (n % 5 == 0 && past.size() > 6) {
            // Where the axes truly are now: what was commanded five ticks ago (window and latency).
            const Vec3 at = past[past.size() - 6];
            const double depth = profile(at.x + 0.030);
            const double reading = 0.125 + (at.y - depth);
            sample.value = static_cast<SensorValue>(std::lround(reading * 1e8));
            sample.measured_ns = n * kPeriod;
            sample.quality = blind(at.x + 0.030) ? Quality::out_of_range : Quality::good;
            ++sample.count;
        }
        surface.step(n * kPeriod, sample, axes, looking);
    }
    template <class Profile>
    Verdict stand(const Profile& profile, bool begins) {
        surface.stand(begins);
        do {
            tick(profile, true);
        } while (surface.look() == Verdict::waiting);
        return surface.look();
    }
    /// From x = first to last; what came of it.
    template <class Profile>
    Verdict look(const Profile& profile, double first, double last) {
        surface.release();
        axes = {first - 0.030, kLineY, -0.3};
        const Verdict start = stand(profile, true);
        if (start != Verdict::fine) {
            return start;
        }
        while (axes.x < last - 0.030) {
            axes.x += look_speed * 1e-3;
            tick(profile, true);
        }
        return stand(profile, false);
    }
    /// The beam goes to x at its speed, lit.
    template <class Profile>
    void mark(const Profile& profile) {
        axes.x += speed * 1e-3;
        surface.expect(axes, true, false);
        tick(profile, false);
    }

    static constexpr double kLineY = -0.330;
    Surface surface{kPeriod, kLatency};
    Sample sample;
    Vec3 axes{-0.200, kLineY, -0.3};
    std::vector<Vec3> past;
    double speed = 0.020;
    double look_speed = 0.050;
    std::function<bool(double)> blind = [](double) { return false; };
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

TEST(Surface, ALookAtWhatIsThereIsFineAndTheBeamOnItToo) {
    Ride ride(SurfaceMode::check);
    ASSERT_EQ(ride.look(flat, -0.200, -0.140), Verdict::fine);
    ride.axes = {-0.200, Ride::kLineY, -0.3};
    while (ride.axes.x < -0.140) {
        ride.mark(flat);
        ASSERT_NE(ride.surface.verdict(), Verdict::off);
        ASSERT_NE(ride.surface.verdict(), Verdict::not_seen) << ride.axes.x;
    }
    EXPECT_EQ(ride.surface.verdict(), Verdict::fine);
    EXPECT_NEAR(ride.surface.depth(), kFlat, 1e-6);
    EXPECT_EQ(ride.surface.shift(), 0.0);
}

TEST(Surface, WhereNobodyHasLookedIsNotSeen) {
    Ride ride(SurfaceMode::check);
    ASSERT_EQ(ride.look(flat, -0.200, -0.180), Verdict::fine);
    EXPECT_EQ(ride.surface.verdict_at({-0.190, kFlat, -0.3}), Verdict::fine);
    EXPECT_EQ(ride.surface.verdict_at({-0.190, kFlat, -0.3 + 0.9 * kSurfaceReach}), Verdict::fine);
    EXPECT_EQ(ride.surface.verdict_at({-0.190, kFlat, -0.3 + 1.1 * kSurfaceReach}), Verdict::not_seen);
    EXPECT_EQ(ride.surface.verdict_at({-0.190, kFlat - 2e-3, -0.3}), Verdict::off);
    ride.axes = {-0.185, Ride::kLineY, -0.3};
    double found_at = 0.0;
    for (int i = 0; i < 2000 && found_at == 0.0; ++i) {
        ride.mark(flat);
        if (ride.surface.verdict() == Verdict::not_seen) {
            found_at = ride.axes.x;
        }
    }
    EXPECT_NEAR(found_at, -0.180 + kSurfaceReach, 0.2e-3);
    ride.surface.forget();
    EXPECT_EQ(ride.surface.verdict_at({-0.190, kFlat, -0.3}), Verdict::not_seen);
}

TEST(Surface, ALookFindsWhatIsOff) {
    Ride step(SurfaceMode::check);
    EXPECT_EQ(step.look([](double x) { return x < -0.170 ? kFlat : kFlat - 2e-3; }, -0.200, -0.140), Verdict::off);
    EXPECT_NEAR(step.surface.depth(), kFlat - 2e-3, 1e-6);
    Ride begin(SurfaceMode::check);
    EXPECT_EQ(begin.look([](double) { return kFlat + 2e-3; }, -0.200, -0.140), Verdict::off);
    Ride end(SurfaceMode::check);
    EXPECT_EQ(end.look([](double x) { return x < -0.1403 ? kFlat : kFlat - 2e-3; }, -0.200, -0.140), Verdict::off);
}

TEST(Surface, ALookForgivesASpeckButNoGap) {
    for (const auto& [width, wanted] : {std::pair{0.8e-3, Verdict::fine}, std::pair{3.0e-3, Verdict::not_seen}}) {
        Ride ride(SurfaceMode::check);
        ride.blind = [w = width](double x) { return x > -0.170 && x < -0.170 + w; };
        EXPECT_EQ(ride.look(flat, -0.200, -0.140), wanted) << width;
    }
    for (const auto& [width, wanted] : {std::pair{0.3e-3, Verdict::fine}, std::pair{3.0e-3, Verdict::off}}) {
        Ride hole(SurfaceMode::check);
        const auto profile = [w = width](double x) { return x > -0.170 && x < -0.170 + w ? kFlat - 5e-3 : kFlat; };
        EXPECT_EQ(hole.look(profile, -0.200, -0.140), wanted) << width;
    }
    Ride blind(SurfaceMode::check);
    blind.blind = [](double) { return true; };
    EXPECT_EQ(blind.look(flat, -0.200, -0.140), Verdict::not_seen);
    Ride late(SurfaceMode::check);
    late.blind = [](double x) { return x > -0.1405; };
    EXPECT_EQ(late.look(flat, -0.200, -0.140), Verdict::not_seen);
}

TEST(Surface, ItRemembersWhatTheHeaderSaysAndForgetsTheOldest) {
    Ride ride(SurfaceMode::check);
    ASSERT_EQ(ride.look(flat, -0.400, -0.400 + 0.240), Verdict::fine);
    EXPECT_EQ(ride.surface.verdict_at({-0.400, kFlat, -0.3}), Verdict::fine);
    ASSERT_EQ(ride.look(flat, -0.100, -0.100 + 0.100), Verdict::fine);
    EXPECT_EQ(ride.surface.verdict_at({-0.400, kFlat, -0.3}), Verdict::not_seen);
    EXPECT_EQ(ride.surface.verdict_at({-0.170, kFlat, -0.3}), Verdict::fine);
    EXPECT_EQ(ride.surface.verdict_at({-0.060, kFlat, -0.3}), Verdict::fine);
}

TEST(Surface, TheFocusFollowsWhatTheSensorSaw) {
    Ride ride(SurfaceMode::follow);
    const auto wave = [](double x) { return kFlat + 0.5e-3 * std::sin(2.0 * 3.14159265 * x / 0.060); };
    ASSERT_EQ(ride.look(wave, -0.220, -0.080), Verdict::fine);
    // As before a path: the shift comes to rest where the line begins.
    ride.axes = {-0.220, Ride::kLineY, -0.3};
    for (int i = 0; i < 1500; ++i) {
        ride.surface.expect(ride.axes, false, false);
        ride.tick(wave, false);
    }
    EXPECT_TRUE(ride.surface.settled());
    double worst = 0.0;
    double worst_without = 0.0;
    while (ride.axes.x < -0.081) {
        ride.mark(wave);
        worst = std::max(worst, std::abs(ride.axes.y + ride.surface.shift() - wave(ride.axes.x)));
        worst_without = std::max(worst_without, std::abs(ride.axes.y - wave(ride.axes.x)));
    }
    EXPECT_GT(worst_without, 0.49e-3);
    EXPECT_LT(worst, 0.10e-3);
}

TEST(Surface, TheShiftIsBoundedAndSmoothWhateverTheSensorSays) {
    Ride ride(SurfaceMode::follow);
    std::mt19937 random(5);
    std::uniform_real_distribution<double> anywhere(-1.4e-3, 1.4e-3);
    const auto rough = [&](double) { return kFlat + anywhere(random); };
    ASSERT_EQ(ride.look(rough, -0.250, -0.150), Verdict::fine);
    const auto cost = ride.surface.cost();
    std::array<double, 4> last{};
    ride.axes.x = -0.240;
    for (int i = 0; i < 20'000; ++i) {
        ride.speed = i % 1000 < 500 ? 0.15 : -0.15;
        if (i % 700 < 600) {
            ride.mark(flat);
        } else {
            ride.surface.release();
            ride.tick(flat, false);
        }
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
    ASSERT_EQ(ride.look(off, -0.200, -0.140), Verdict::fine);
    ride.axes = {-0.170, Ride::kLineY, -0.3};
    for (int i = 0; i < 2000; ++i) {
        ride.surface.expect(ride.axes, false, false);
        ride.tick(off, false);
    }
    EXPECT_NEAR(ride.surface.shift(), 0.4e-3, 5e-6);
    EXPECT_TRUE(ride.surface.settled());
    for (int i = 0; i < 4000; ++i) {
        ride.surface.release();
        ride.tick(off, false);
    }
    EXPECT_EQ(ride.surface.shift(), 0.0);
}

}  // namespace

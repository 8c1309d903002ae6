// SPDX-License-Identifier: Apache-2.0
// Random paths with random holds, overrides and droughts of points, driven tick by tick and judged on emitted 1 ms
// samples by differences, and by the undisturbed run of the same path.
#include "firmware/motion/path_motion.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <random>
#include <sstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>

namespace sc::motion {
namespace {

constexpr double kTick = 1e-3;

struct Sample {
    Place place{};
    double distance = 0.0;
};

trajectory::Spec spec_of(double speed, double tolerance) {
    trajectory::Spec spec;
    spec.speed = speed;
    spec.tolerance = tolerance;
    for (std::size_t i = 0; i < 3; ++i) {
        spec.limits.speed[i] = 0.2;
        spec.limits.acceleration[i] = 5.0;
        spec.limits.jerk[i] = 200.0;
    }
    return spec;
}

/// Drives a path as the controller does: points as room allows, one tick after the other.
class Runner {
public:
    Runner(const trajectory::Spec& spec, std::vector<Place> points, double override_share = 1.0)
        : points_(std::move(points)) {
        motion_->set_override(override_share);
        EXPECT_TRUE(motion_->open(spec));
    }

    PathMotion& motion() { return *motion_; }
    const std::vector<Sample>& samples() const { return samples_; }
    double time() const { return time_; }
    bool begun() const { return time_ > 0.0; }
    /// Times that run() found points there, but their plan too late.
    int late() const { return late_; }
    /// Distance of the next pulse of a laser that fires all the way to a stop.
    double next_pulse() const { return std::max(fired_, motion_->mark_begin()); }
    void limit_points(std::size_t known) { known_ = known; }
    /// A planner that is given less than it needs, and is late.
    void throttle(std::uint32_t units) { units_ = units; }
    bool resting() const { return motion_->stopped() && time_ > motion_->end_time() + kTick; }

    /// One tick; false once the path is done and at rest.
    bool tick() {
        EXPECT_TRUE(motion_->tick(time_, kTick) || units_ < kUnitsPerTick) << "planner late at " << time_;
        while (motion_->wants_points() && next_ < std::min(known_, points_.size())) {
            motion_->add(points_[next_], static_cast<std::uint32_t>(next_));
            ++next_;
        }
        if (next_ == points_.size() && !finished_ && motion_->wants_points()) {
            motion_->finish();
            finished_ = true;
        }
        motion_->work(units_);
        if (time_ == 0.0 && !motion_->ready()) {
            return true;
        }
        const Segment s = motion_->segment(time_, cursor_);
        expect_the_next_one(s);
        samples_.push_back({s.piece->place(s.x(time_)), value(s.piece->distance, s.x(time_))});
        if (motion_->complete() && time_ > motion_->end_time()) {
            return false;
        }
        if (time_ >= motion_->rearm_time() && time_ < motion_->stop_time()) {
            fired_ = std::max(fired_, samples_.back().distance);
        }
        motion_->forget_before(time_ - 0.01, fired_);
        time_ += kTick;
        return true;
    }
    /// To the path's end, going on by itself after a drought, as the controller does. False if it never comes.
    [[nodiscard]] bool run() {
        for (int n = 0; n < 400'000; ++n) {
            if (!tick()) {
                return true;
            }
            if (resting() && motion_->can_continue()) {
                ++late_;
                motion_->request_resume(next_pulse());
            }
        }
        return false;
    }
    /// Until at rest on the path, or at its end.
    [[nodiscard]] bool run_to_rest(int ticks) {
        for (int n = 0; n < ticks; ++n) {
            if (resting()) {
                return true;
            }
            if (!tick()) {
                return true;
            }
        }
        return false;
    }

    /// For a test that fails.
    std::string story() const {
        std::ostringstream text;
        text << "at " << time_ << " s, law ends " << motion_->end_time() << ", point " << next_ << " of "
             << points_.size() << ", starved " << motion_->starved() << ", stopped " << motion_->stopped()
             << ", complete " << motion_->complete() << ", ready " << motion_->ready() << ", rate " << motion_->rate()
             << ", planned to " << motion_->planner().pieces().end() << ", kept from "
             << motion_->planner().pieces().first() << ", distance " << samples_.back().distance;
        return text.str();
    }

private:
    static double value(const trajectory::Quintic& k, double t) { return trajectory::value(k, t); }

    /// What follows a segment is what a reader without a memory finds there.
    void expect_the_next_one(const Segment& s) const {
        for (const double later : {0.0, 3e-4}) {
            Cursor with = cursor_;
            Cursor without;
            const Segment after = motion_->segment_after(s, s.end + later, with);
            const Segment found = motion_->segment(s.end + later, without);
            ASSERT_EQ(after.piece, found.piece) << "after " << s.end << " s";
            ASSERT_EQ(after.begin, found.begin);
            ASSERT_EQ(after.end, found.end);
            ASSERT_EQ(after.t0, found.t0);
            ASSERT_EQ(after.x0, found.x0);
            ASSERT_EQ(after.rate, found.rate);
            ASSERT_EQ(with.piece, without.piece);
            ASSERT_EQ(with.leg, without.leg);
        }
    }

    std::unique_ptr<PathMotion> motion_ = std::make_unique<PathMotion>();
    std::vector<Place> points_;
    std::vector<Sample> samples_;
    std::size_t next_ = 0;
    bool finished_ = false;
    std::size_t known_ = static_cast<std::size_t>(-1);
    double time_ = 0.0;
    Cursor cursor_;
    double fired_ = 0.0;
    int late_ = 0;
    std::uint32_t units_ = kUnitsPerTick;
};

/// Worst ratio to the limits of first to third differences, at rest before and behind.
struct Worst {
    double share = 0.0;
    double time = 0.0;
};
Worst worst_share(const std::vector<Sample>& samples, const trajectory::AxisLimits& limits) {
    Worst worst;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        std::vector<double> p(3, samples.front().place[axis]);
        for (const Sample& s : samples) {
            p.push_back(s.place[axis]);
        }
        p.insert(p.end(), 3, p.back());
        for (std::size_t i = 3; i < p.size(); ++i) {
            const double v = (p[i] - p[i - 1]) / kTick;
            const double a = (p[i] - 2 * p[i - 1] + p[i - 2]) / (kTick * kTick);
            const double j = (p[i] - 3 * p[i - 1] + 3 * p[i - 2] - p[i - 3]) / (kTick * kTick * kTick);
            const double share = std::max({std::abs(v) / limits.speed[axis], std::abs(a) / limits.acceleration[axis],
                                           std::abs(j) / limits.jerk[axis]});
            if (share > worst.share) {
                worst = {share, kTick * static_cast<double>(i - 3)};
            }
        }
    }
    return worst;
}

/// Where the undisturbed beam is, by its distance along the path.
class Reference {
public:
    explicit Reference(const std::vector<Sample>& samples) : samples_(samples) {}
    /// How far a place is from the undisturbed path at the same distance.
    [[nodiscard]] double off(const Sample& s) const {
        const auto after = std::lower_bound(samples_.begin(), samples_.end(), s.distance,
                                            [](const Sample& a, double d) { return a.distance < d; });
        if (after == samples_.begin() || after == samples_.end()) {
            const Sample& end = after == samples_.end() ? samples_.back() : samples_.front();
            return apart(end.place, s.place);
        }
        const Sample& b = *after;
        const Sample& a = *(after - 1);
        const double x = b.distance > a.distance ? (s.distance - a.distance) / (b.distance - a.distance) : 0.0;
        Place on{};
        for (std::size_t k = 0; k < 3; ++k) {
            on[k] = a.place[k] + x * (b.place[k] - a.place[k]);
        }
        return apart(on, s.place);
    }

private:
    static double apart(const Place& a, const Place& b) { return std::hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]); }
    std::vector<Sample> samples_;
};

/// Bends of some millimetres' radius, dense or sparse points, and a sharp corner now and then.
std::vector<Place> random_path(std::mt19937_64& random, std::size_t count) {
    std::uniform_real_distribution<double> unit(-1.0, 1.0);
    std::uniform_real_distribution<double> decade(-4.3, -2.4);
    std::vector<Place> points{{0.1 * unit(random), 0.1 * unit(random), 0.1 * unit(random), 0.0}};
    const double scale = std::pow(10.0, decade(random));
    const double sharpest = std::min(300.0, 0.1 / scale);  // 1/m
    const double corners = random() % 3 == 0 ? 0.1 : 0.01;
    double heading = 3.0 * unit(random);
    double climb = 0.0;
    double bend = 0.0;
    while (points.size() < count) {
        const double step = scale * (0.2 + std::abs(unit(random)));
        bend += 0.2 * sharpest * unit(random) - 0.05 * bend;
        heading += step * std::clamp(bend, -sharpest, sharpest);
        climb = 0.98 * climb + 0.1 * step * sharpest * unit(random);
        if (std::abs(unit(random)) < corners) {
            heading += 1.6 + unit(random);
        }
        Place next = points.back();
        next[0] += step * std::cos(heading);
        next[1] += step * climb;
        next[2] += step * std::sin(heading);
        points.push_back(next);
    }
    return points;
}

constexpr double kMostShare = 1.005;
/// A chord of the reference between two samples leaves a path of 2 mm radius by 2.5 µm at full speed.
constexpr double kOffPath = 3e-6;

TEST(PathMotion, PlanIsAFunctionOfThePointsAlone) {
    std::mt19937_64 random(2);
    const auto points = random_path(random, 900);
    Runner at_once(spec_of(0.2, 1e-5), points);
    ASSERT_TRUE(at_once.run());
    Runner trickled(spec_of(0.2, 1e-5), points);
    std::size_t known = 0;
    bool going = true;
    while (going) {
        // Points come in clumps, but early enough not to starve.
        known += random() % 9;
        trickled.limit_points(known);
        going = trickled.tick();
    }
    ASSERT_FALSE(trickled.motion().starved());
    ASSERT_EQ(at_once.samples().size(), trickled.samples().size());
    for (std::size_t i = 0; i < at_once.samples().size(); ++i) {
        ASSERT_EQ(at_once.samples()[i].place, trickled.samples()[i].place) << "sample " << i;
    }
}

TEST(PathMotion, RestsWhereAPlanEndsAndDoesNotJumpIntoTheNext) {
    std::mt19937_64 random(9);
    int rests = 0;
    for (int trial = 0; trial < 6; ++trial) {
        // Dense points, so that the law is faster than such a planner.
        const auto points = random_path(random, 1500);
        Runner runner(spec_of(0.2, 1e-5), points);
        runner.throttle(3);
        ASSERT_TRUE(runner.run()) << "trial " << trial << ": " << runner.story();
        rests += runner.late();
        const std::vector<Sample>& samples = runner.samples();
        for (std::size_t i = 1; i < samples.size(); ++i) {
            const Place& a = samples[i - 1].place;
            const Place& b = samples[i].place;
            ASSERT_LE(std::hypot(b[0] - a[0], b[1] - a[1], b[2] - a[2]), 0.2 * kTick * kMostShare)
                << "trial " << trial << " sample " << i << " of " << samples.size();
        }
    }
    EXPECT_GT(rests, 0) << "the planner was never late";
}

TEST(PathMotion, KeepsLimitsAndPathThroughHoldsOverridesAndDroughts) {
    std::mt19937_64 random(3);
    int holds = 0;
    int droughts = 0;
    int overrides = 0;
    int late = 0;
    for (int trial = 0; trial < SC_RANDOM_RUNS; ++trial) {
        const std::size_t least = trial % 4 == 0 ? 700 : 3;
        const auto points = random_path(random, least + static_cast<std::size_t>(random() % 600));
        const trajectory::Spec spec = spec_of(trial % 3 == 0 ? 0.05 : 0.2, trial % 5 == 0 ? 0.0 : 1e-5);
        Runner undisturbed(spec, points);
        ASSERT_TRUE(undisturbed.run()) << "trial " << trial << ": " << undisturbed.story();
        late += undisturbed.late();
        const double seconds = undisturbed.time();
        const Reference reference(undisturbed.samples());

        Runner runner(spec, points);
        if (trial % 4 == 0) {
            runner.limit_points(points.size() / 2);
        }
        bool going = true;
        if (trial % 4 == 0) {
            for (int n = 0; n < 20'000 && going && !runner.resting(); ++n) {
                going = runner.tick();
            }
        }
        int actions = 0;
        while (going && actions < 12) {
            ++actions;
            const auto wait = static_cast<int>(static_cast<double>(random() % 1000) * seconds * 0.3) + 1;
            for (int n = 0; n < wait && going; ++n) {
                going = runner.tick();
                if (runner.motion().stopped()) {
                    break;
                }
            }
            if (!going) {
                break;
            }
            runner.limit_points(runner.motion().stopped()
                                    ? points.size()
                                    : static_cast<std::size_t>(random() % points.size() + points.size() / 2));
            if (!runner.motion().stopped() && random() % 3 == 0) {
                runner.motion().set_override(0.1 + 0.01 * static_cast<double>(random() % 190));
                ++overrides;
                continue;
            }
            if (!runner.begun()) {
                continue;
            }
            if (runner.motion().starved()) {
                ++droughts;
            } else {
                ++holds;
                runner.motion().request_stop();
            }
            ASSERT_TRUE(runner.run_to_rest(3000)) << "trial " << trial << ": no rest at " << runner.time();
            if (!runner.resting()) {
                going = false;
                break;
            }
            runner.limit_points(points.size());
            for (std::uint64_t n = random() % 200; n > 0; --n) {
                going = runner.tick();
            }
            for (int n = 0; n < 20'000 && !runner.motion().can_continue(); ++n) {
                going = runner.tick();
            }
            ASSERT_TRUE(runner.motion().can_continue()) << "trial " << trial << ": " << runner.story();
            runner.motion().request_resume(runner.next_pulse());
            if (random() % 4 == 0) {
                // And held again on the way back or in the run-in.
                for (std::uint64_t n = random() % 150; n > 0; --n) {
                    going = runner.tick();
                }
                runner.motion().request_stop();
                ASSERT_TRUE(runner.run_to_rest(3000)) << "trial " << trial << ": no rest at " << runner.time();
                runner.motion().request_resume(runner.next_pulse());
            }
        }
        runner.limit_points(points.size());
        runner.motion().set_override(1.0);
        for (int n = 0; n < 200'000 && going; ++n) {
            going = runner.tick();
            if (runner.resting()) {
                runner.motion().request_resume(runner.next_pulse());
            }
        }
        ASSERT_FALSE(going) << "trial " << trial << ": never done, " << runner.story();
        const Worst worst = worst_share(runner.samples(), spec.limits);
        ASSERT_LE(worst.share, kMostShare) << "trial " << trial << " at " << worst.time;
        for (std::size_t i = 0; i < runner.samples().size(); ++i) {
            ASSERT_LE(reference.off(runner.samples()[i]), kOffPath) << "trial " << trial << " sample " << i;
        }
        ASSERT_NEAR(runner.samples().back().distance, undisturbed.samples().back().distance, 1e-9);
    }
    EXPECT_GT(holds, SC_RANDOM_RUNS / 2);
    EXPECT_GT(droughts, SC_RANDOM_RUNS / 20);
    EXPECT_GT(overrides, SC_RANDOM_RUNS / 2);
    EXPECT_LE(late, SC_RANDOM_RUNS / 500);
}

TEST(PathMotion, OverrideAboveAHundredIsReachedOnThePathWhereTheLimitsLeaveRoom) {
    // Far below what the axes can do: a straight line, and a circle as dense points.
    std::vector<std::vector<Place>> paths{{{0.0, 0.0, 0.0, 0.0}, {0.4, 0.0, 0.0, 0.0}}, {}};
    for (int i = 0; i <= 3000; ++i) {
        const double a = 0.002 * i;
        paths[1].push_back({0.06 * std::cos(a), 0.0, 0.06 * std::sin(a), 0.0});
    }
    for (const auto& points : paths) {
        const trajectory::Spec spec = spec_of(0.06, 1e-5);
        Runner even(spec, points);
        ASSERT_TRUE(even.run());
        const Reference reference(even.samples());
        Runner runner(spec, points);
        double fastest = 0.0;
        double last = 0.0;
        double raised = 0.0;
        bool going = true;
        while (going && runner.time() < 20.0) {
            going = runner.tick();
            // Up, and down again before the end.
            runner.motion().set_override(runner.time() > 0.8 && runner.time() < 2.8 ? 2.0 : 1.0);
            const double way = runner.samples().empty() ? 0.0 : runner.samples().back().distance;
            if (runner.time() > 1.2 && runner.time() < 2.8) {
                raised += way - last;
            }
            fastest = std::max(fastest, (way - last) / kTick);
            last = way;
        }
        EXPECT_LE(fastest, 0.12 * 1.005);
        EXPECT_LT(runner.time(), even.time());
        if (&points == &paths[0]) {
            EXPECT_GE(fastest, 0.12 * 0.99);
            EXPECT_GE(raised / 1.6, 0.12 * 0.98) << "it stays there";
            EXPECT_LT(runner.time(), even.time() - 1.8);
        }
        EXPECT_LE(worst_share(runner.samples(), spec.limits).share, kMostShare);
        for (const Sample& s : runner.samples()) {
            ASSERT_LE(reference.off(s), kOffPath);
        }
    }
}

TEST(PathMotion, OverrideThatChangesBeforeTheLastChangeIsPlannedKeepsLimitsAndPath) {
    std::mt19937_64 random(7);
    for (int trial = 0; trial < SC_RANDOM_RUNS / 10; ++trial) {
        const auto points = random_path(random, 300);
        const trajectory::Spec spec = spec_of(trial % 2 == 0 ? 0.06 : 0.2, trial % 5 == 0 ? 0.0 : 1e-5);
        Runner even(spec, points);
        ASSERT_TRUE(even.run());
        const Reference reference(even.samples());
        Runner runner(spec, points);
        bool going = true;
        std::uint64_t wait = 0;
        for (int n = 0; n < 400'000 && going; ++n) {
            going = runner.tick();
            if (wait == 0) {
                wait = 1 + random() % 40;
                constexpr std::array<double, 4> kShares{0.3, 1.0, 1.5, 2.0};
                runner.motion().set_override(kShares[random() % kShares.size()]);
            }
            --wait;
            if (runner.resting() && runner.motion().can_continue()) {
                runner.motion().request_resume(runner.next_pulse());
            }
        }
        ASSERT_FALSE(going) << "trial " << trial << ": never done, " << runner.story();
        ASSERT_LE(worst_share(runner.samples(), spec.limits).share, kMostShare) << "trial " << trial;
        for (const Sample& s : runner.samples()) {
            ASSERT_LE(reference.off(s), kOffPath) << "trial " << trial;
        }
    }
}

TEST(PathMotion, ComesToRestWhenPointsStopArrivingAndGoesOnWhenTheyCome) {
    std::vector<Place> points;
    for (int i = 0; i < 1200; ++i) {
        const double a = 0.004 * i;
        points.push_back({0.05 * std::cos(a), 0.0, 0.05 * std::sin(a), 0.0});
    }
    Runner runner(spec_of(0.2, 1e-5), points);
    runner.limit_points(900);
    for (int n = 0; n < 60'000 && !runner.resting(); ++n) {
        ASSERT_TRUE(runner.tick());
    }
    ASSERT_TRUE(runner.motion().starved());
    const double rest = runner.samples().back().distance;
    for (int n = 0; n < 300; ++n) {
        runner.tick();
    }
    EXPECT_EQ(runner.samples().back().distance, rest);
    EXPECT_FALSE(runner.motion().can_continue());
    runner.limit_points(points.size());
    while (!runner.motion().can_continue()) {
        runner.tick();
    }
    runner.motion().request_resume(rest);
    ASSERT_TRUE(runner.run()) << runner.story();
    EXPECT_LE(worst_share(runner.samples(), spec_of(0.2, 1e-5).limits).share, kMostShare);
}

TEST(PathMotion, SecondRunEqualsTheFirst) {
    std::mt19937_64 random(5);
    const auto points = random_path(random, 300);
    const auto other = random_path(random, 40);
    std::vector<std::vector<Sample>> runs;
    auto motion = std::make_unique<PathMotion>();
    for (const auto& path : {points, other, points}) {
        ASSERT_TRUE(motion->open(spec_of(0.2, 1e-5)));
        std::vector<Sample> samples;
        std::size_t next = 0;
        double t = 0.0;
        Cursor cursor;
        bool finished = false;
        while (!(motion->complete() && t > motion->end_time())) {
            ASSERT_TRUE(motion->tick(t, kTick));
            for (; motion->wants_points() && next < path.size(); ++next) {
                motion->add(path[next], static_cast<std::uint32_t>(next));
            }
            if (next == path.size() && !finished && motion->wants_points()) {
                motion->finish();
                finished = true;
            }
            motion->work(kUnitsPerTick);
            if (t > 0.0 || motion->ready()) {
                const Segment s = motion->segment(t, cursor);
                samples.push_back({s.piece->place(s.x(t)), 0.0});
                t += kTick;
            }
        }
        runs.push_back(samples);
    }
    ASSERT_EQ(runs[0].size(), runs[2].size());
    for (std::size_t i = 0; i < runs[0].size(); ++i) {
        ASSERT_EQ(runs[0][i].place, runs[2][i].place) << i;
    }
}

}  // namespace
}  // namespace sc::motion

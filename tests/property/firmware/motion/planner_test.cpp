// SPDX-License-Identifier: Apache-2.0
// Random paths through the planner, judged on emitted 1 ms samples by differences alone.
#include "firmware/motion/planner.hpp"

#include <cmath>
#include <memory>
#include <random>
#include <vector>

#include <gtest/gtest.h>

namespace sc::motion {
namespace {

constexpr double kTick = 1e-3;

struct Sample {
    Place place{};
    double speed = 0.0;
    double distance = 0.0;
};

AxisLimits stage_limits() {
    AxisLimits limits;
    for (std::size_t i = 0; i < 3; ++i) {
        limits.speed[i] = 0.2;
        limits.acceleration[i] = 5.0;
        limits.jerk[i] = 200.0;
    }
    return limits;
}

/// Drives a planner as the controller does: points as room allows, one tick after the other.
class Runner {
public:
    Runner(const PathSpec& spec, std::vector<Place> points) : points_(std::move(points)) { planner_->open(spec); }

    Planner& planner() { return *planner_; }
    std::vector<Sample>& samples() { return samples_; }
    double time() const { return time_; }
    void limit_points(std::size_t known) { known_ = known; }

    /// One tick; false once the path is done and at rest.
    bool tick() {
        EXPECT_TRUE(planner_->tick(tick_, time_, kTick)) << "planner late at tick " << tick_;
        while (planner_->wants_points() && next_ < std::min(known_, points_.size())) {
            planner_->add(points_[next_], static_cast<std::uint32_t>(next_));
            ++next_;
        }
        if (next_ == points_.size() && !finished_ && planner_->wants_points()) {
            planner_->finish();
            finished_ = true;
        }
        planner_->work(kUnitsPerTick);
        ++tick_;
        if (time_ == 0.0 && !planner_->ready(kTick)) {
            return true;
        }
        const MotionState state = planner_->state(time_, hint_);
        samples_.push_back(
            {planner_->place(state), state.speed, planner_->elements().at(state.element).distance_at(state.tau)});
        if (planner_->complete() && time_ > planner_->law().end_time()) {
            return false;
        }
        planner_->forget_before(time_ - 0.02);
        time_ += kTick;
        return true;
    }
    void run() {
        for (int n = 0; n < 4'000'000; ++n) {
            if (!tick()) {
                return;
            }
        }
        FAIL() << "never done: element " << planner_->elements().end() << " first " << planner_->elements().first()
               << " time " << time_ << " law end " << planner_->law().end_time() << " stopped " << planner_->stopped()
               << " complete " << planner_->complete() << " next point " << next_ << " free " << planner_->law().free()
               << " finished " << planner_->builder().finished();
    }

private:
    std::unique_ptr<Planner> planner_ = std::make_unique<Planner>();
    std::vector<Place> points_;
    std::vector<Sample> samples_;
    std::size_t next_ = 0;
    bool finished_ = false;
    std::size_t known_ = static_cast<std::size_t>(-1);
    std::int64_t tick_ = 0;
    double time_ = 0.0;
    std::uint32_t hint_ = 0;
};

struct Peaks {
    double speed = 0.0;
    double acceleration = 0.0;
    double jerk = 0.0;
};

/// Worst ratio to the limits of first to third differences of picometre-rounded samples, at rest before and after.
Peaks peaks(const std::vector<Sample>& samples, const AxisLimits& limits) {
    Peaks worst;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        std::vector<double> p(3, std::round(samples.front().place[axis] * 1e12));
        for (const Sample& s : samples) {
            p.push_back(std::round(s.place[axis] * 1e12));
        }
        p.insert(p.end(), 3, p.back());
        for (std::size_t i = 3; i < p.size(); ++i) {
            const double v = (p[i] - p[i - 1]) * 1e-12 / kTick;
            const double a = (p[i] - 2 * p[i - 1] + p[i - 2]) * 1e-12 / (kTick * kTick);
            const double j = (p[i] - 3 * p[i - 1] + 3 * p[i - 2] - p[i - 3]) * 1e-12 / (kTick * kTick * kTick);
            worst.speed = std::max(worst.speed, std::abs(v) / limits.speed[axis]);
            worst.acceleration = std::max(worst.acceleration, std::abs(a) / limits.acceleration[axis]);
            worst.jerk = std::max(worst.jerk, std::abs(j) / limits.jerk[axis]);
        }
    }
    return worst;
}

double distance_to_segment(const Place& p, const Place& a, const Place& b) {
    double ab = 0.0;
    double ap = 0.0;
    for (std::size_t i = 0; i < 3; ++i) {
        ab += (b[i] - a[i]) * (b[i] - a[i]);
        ap += (p[i] - a[i]) * (b[i] - a[i]);
    }
    const double t = ab > 0.0 ? std::clamp(ap / ab, 0.0, 1.0) : 0.0;
    double d = 0.0;
    for (std::size_t i = 0; i < 3; ++i) {
        const double e = p[i] - (a[i] + t * (b[i] - a[i]));
        d += e * e;
    }
    return std::sqrt(d);
}

std::vector<Place> random_path(std::mt19937_64& random, std::size_t count) {
    std::uniform_real_distribution<double> unit(-1.0, 1.0);
    std::uniform_real_distribution<double> decade(-5.0, -1.5);
    std::vector<Place> points{{0.1 * unit(random), 0.1 * unit(random), 0.1 * unit(random), 0.0}};
    Place direction{1.0, 0.0, 0.0, 0.0};
    const double bend = 0.5 * (1.0 + unit(random));
    const double scale = std::pow(10.0, decade(random));
    while (points.size() < count) {
        double n = 0.0;
        Place d{};
        for (std::size_t i = 0; i < 3; ++i) {
            d[i] = direction[i] + bend * unit(random);
            n += d[i] * d[i];
        }
        if (n < 1e-6) {
            continue;
        }
        Place next = points.back();
        for (std::size_t i = 0; i < 3; ++i) {
            direction[i] = d[i] / std::sqrt(n);
            next[i] += direction[i] * scale * (0.2 + std::abs(unit(random)));
        }
        points.push_back(next);
    }
    return points;
}

PathSpec spec_of(double speed, double tolerance) {
    PathSpec spec;
    spec.speed = speed;
    spec.tolerance = tolerance;
    spec.limits = stage_limits();
    return spec;
}

TEST(Planner, KeepsLimitsAndToleranceOnRandomPaths) {
    std::mt19937_64 random(1);
    for (int trial = 0; trial < 60; ++trial) {
        const auto points = random_path(random, 3 + static_cast<std::size_t>(trial) * 7);
        Runner runner(spec_of(trial % 3 == 0 ? 0.05 : 0.2, trial % 4 == 0 ? 0.0 : 1e-5), points);
        runner.run();
        const Peaks worst = peaks(runner.samples(), stage_limits());
        EXPECT_LE(worst.speed, 1.0001) << "trial " << trial;
        EXPECT_LE(worst.acceleration, 1.0001) << "trial " << trial;
        EXPECT_LE(worst.jerk, 1.0005) << "trial " << trial;
        const auto& builder = runner.planner().builder();
        for (const Sample& s : runner.samples()) {
            if (s.distance < builder.mark_begin() || s.distance > builder.mark_end()) {
                continue;
            }
            double nearest = 1.0;
            for (std::size_t i = 1; i < points.size(); ++i) {
                nearest = std::min(nearest, distance_to_segment(s.place, points[i - 1], points[i]));
            }
            ASSERT_LE(nearest, 1.0001e-5) << "trial " << trial;
        }
    }
}

TEST(Planner, PlanIsAFunctionOfThePointsAlone) {
    std::mt19937_64 random(2);
    const auto points = random_path(random, 900);
    Runner at_once(spec_of(0.2, 1e-5), points);
    at_once.run();
    Runner trickled(spec_of(0.2, 1e-5), points);
    std::size_t known = 0;
    bool going = true;
    while (going) {
        // Points come in clumps, but early enough not to starve.
        known += random() % 9;
        trickled.limit_points(known);
        going = trickled.tick();
    }
    ASSERT_EQ(at_once.samples().size(), trickled.samples().size());
    for (std::size_t i = 0; i < at_once.samples().size(); ++i) {
        ASSERT_EQ(at_once.samples()[i].place, trickled.samples()[i].place) << "sample " << i;
    }
}

TEST(Planner, StopsWithinLimitsAtAnyMomentAndResumesDark) {
    std::mt19937_64 random(3);
    for (int trial = 0; trial < 300; ++trial) {
        const auto points = random_path(random, 5 + static_cast<std::size_t>(trial % 60) * 3);
        Runner runner(spec_of(0.2, 1e-5), points);
        const int stop_after = static_cast<int>(random() % 600);
        bool going = true;
        for (int n = 0; n < stop_after && going; ++n) {
            going = runner.tick();
        }
        if (!going || runner.time() == 0.0) {
            continue;
        }
        const double fired = runner.samples().back().distance;
        runner.planner().request_stop();
        const auto at_rest = [&] {
            return runner.planner().stopped() && runner.time() > runner.planner().law().end_time() + kTick;
        };
        for (int n = 0; n < 20'000 && going && !at_rest(); ++n) {
            going = runner.tick();
        }
        if (runner.planner().stopped()) {
            EXPECT_EQ(runner.samples().back().speed, 0.0);
            const double next_pulse = std::max(runner.planner().builder().mark_begin(), fired);
            runner.planner().request_resume(next_pulse);
            const double before = runner.time();
            runner.run();
            const double rearm = runner.planner().rearm_time();
            EXPECT_GT(rearm, before - kTick);
            // From the moment it moves forward again it begins at or before the next pulse's place.
            const auto index = static_cast<std::size_t>(rearm / kTick);
            ASSERT_LT(index, runner.samples().size());
            EXPECT_LE(runner.samples()[index].distance, next_pulse + 1e-9);
        }
        const Peaks worst = peaks(runner.samples(), stage_limits());
        EXPECT_LE(worst.speed, 1.0001) << "trial " << trial;
        EXPECT_LE(worst.acceleration, 1.0001) << "trial " << trial;
        EXPECT_LE(worst.jerk, 1.0005) << "trial " << trial;
        EXPECT_NEAR(runner.samples().back().distance, runner.planner().elements().distance(), 1e-9);
    }
}

TEST(Planner, ComesToRestWhenPointsStopArrivingAndGoesOnWhenTheyCome) {
    std::mt19937_64 random(4);
    auto points = random_path(random, 1200);
    Runner runner(spec_of(0.2, 1e-5), points);
    runner.limit_points(600);
    for (int n = 0; n < 60'000 && !runner.planner().stopped(); ++n) {
        runner.tick();
    }
    ASSERT_TRUE(runner.planner().stopped());
    for (int n = 0; n < 300; ++n) {
        runner.tick();
    }
    EXPECT_EQ(runner.samples().back().speed, 0.0);
    runner.limit_points(points.size());
    runner.planner().request_resume(runner.samples().back().distance);
    runner.run();
    const Peaks worst = peaks(runner.samples(), stage_limits());
    EXPECT_LE(worst.acceleration, 1.0001);
    EXPECT_LE(worst.jerk, 1.0005);
    EXPECT_NEAR(runner.samples().back().distance, runner.planner().elements().distance(), 1e-9);
}

}  // namespace
}  // namespace sc::motion

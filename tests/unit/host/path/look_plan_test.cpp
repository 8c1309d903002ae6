// SPDX-License-Identifier: Apache-2.0
#include "host/path/look_plan.hpp"

#include <algorithm>
#include <cmath>
#include <variant>

#include <gtest/gtest.h>

#include "shared/machine/sensors.hpp"
#include "shared/path/job_hash.hpp"
#include "tests/unit/host/path/sample_job.hpp"

namespace sc::host {
namespace {

using namespace literals;

const Vec3 kOrigin{0.030, 0.001, -0.002};

CalibrationSet with_sensor() {
    CalibrationSet set = sample::calibration();
    SensorRay ray;
    ray.id = "y1";
    ray.origin = {kOrigin};
    ray.direction = {{0.0, -1.0, 0.0}};
    ray.zero = 0.125;
    set.y_sensor = ray;
    return set;
}

Job watched(Job job = sample::job()) {
    job.surface = SurfaceSettings{.follow = false, .window = 1_mm, .bound = {}, .look_speed = 50_mm_s};
    return job;
}

JobPlan plan_watched(const Job& job, const MachineConfig& machine = reference_machine()) {
    return plan_job(job, sample::table(), with_sensor(), machine, {});
}

Vec3 place_of(const Look& look) {
    return Vec3{look.x / kWireUnitsPerMetre, look.y / kWireUnitsPerMetre, look.z / kWireUnitsPerMetre} + kOrigin;
}
Vec3 place_of(const PathPoint& p) {
    return {p.x / kWireUnitsPerMetre, p.y / kWireUnitsPerMetre, p.z / kWireUnitsPerMetre};
}

/// Replays the items as a controller would: bins of the memory, which places have been looked at since the last turn.
class Replay {
public:
    explicit Replay(const JobPlan& plan) {
        for (const Item& item : plan.items) {
            if (std::holds_alternative<Turn>(item)) {
                seen_.clear();
            } else if (const auto* look = std::get_if<Look>(&item)) {
                take(*look);
            } else if (const auto* point = std::get_if<PathPoint>(&item)) {
                check(place_of(*point));
            }
        }
    }
    double worst = 0.0;        ///< m from a marked point to the nearest place looked at that is remembered
    double worst_depth = 0.0;  ///< m
    int looks = 0;

private:
    void take(const Look& look) {
        const Vec3 to = place_of(look);
        if (look.speed_um_s == 0) {
            ++looks;
            keep(to);
        } else {
            const int steps = std::max(1, static_cast<int>(std::ceil(norm(to - at_) / kSurfaceBin)));
            const Vec3 from = at_;
            for (int i = 1; i <= steps; ++i) {
                keep(from + (static_cast<double>(i) / steps) * (to - from));
            }
        }
        at_ = to;
    }
    void keep(const Vec3& place) {
        seen_.push_back(place);
        if (seen_.size() > kSurfacePlaces) {
            seen_.erase(seen_.begin());
        }
    }
    void check(const Vec3& place) {
        const auto near = std::ranges::min_element(
            seen_, {}, [&](const Vec3& s) { return std::hypot(s.x - place.x, s.z - place.z); });
        ASSERT_NE(near, seen_.end());
        worst = std::max(worst, std::hypot(near->x - place.x, near->z - place.z));
        worst_depth = std::max(worst_depth, std::abs(near->y - place.y));
    }
    std::vector<Vec3> seen_;
    Vec3 at_;
};

TEST(LookPlan, EachLineIsLookedAtWhereItLiesBeforeItIsBurnt) {
    const JobPlan plan = plan_watched(watched());
    const Replay replay(plan);
    EXPECT_LT(replay.worst, 0.9e-3);
    EXPECT_LT(replay.worst_depth, 0.1e-3);
    EXPECT_EQ(replay.looks, 2 * (4 * 2 + 1));
    EXPECT_EQ(plan.hash, job_hash(plan.items));
}

TEST(LookPlan, WhatIsBurntStaysAsItIs) {
    const JobPlan bare = sample::plan(sample::job(), sample::table());
    JobPlan plan = plan_watched(watched());
    ASSERT_EQ(plan.paths.size(), bare.paths.size());
    for (std::size_t i = 0; i < plan.paths.size(); ++i) {
        const auto begin = std::get<PathBegin>(plan.items.at(plan.paths[i].first_item));
        EXPECT_EQ(begin, std::get<PathBegin>(bare.items.at(bare.paths[i].first_item)));
        EXPECT_TRUE(
            std::holds_alternative<PathEnd>(plan.items.at(plan.paths[i].first_item + plan.paths[i].item_count - 1)));
    }
    for (const PlannedLook& look : plan.looks) {
        EXPECT_TRUE(std::holds_alternative<Look>(plan.items.at(look.item)));
        EXPECT_LT(look.path, plan.paths.size());
    }
    EXPECT_GT(plan.expected_seconds_estimate, bare.expected_seconds_estimate + 5.0);
    std::erase_if(plan.items, [](const Item& item) { return std::holds_alternative<Look>(item); });
    EXPECT_EQ(plan.items, bare.items);
}

TEST(LookPlan, GroupsFitTheMemoryAndPassesAreLookedAtOnce) {
    Job job = watched();
    job.cross.reset();
    job.datum_line.reset();
    job.faces.clear();
    MarkSettings settings = sample::axes_settings();
    settings.passes = 2;
    for (int i = 0; i < 4; ++i) {
        JobPath path;
        path.name = "line " + std::to_string(i);
        path.settings = settings;
        path.steps = {{0, std::nullopt, {-0.300, -0.300, -0.40 + 0.01 * i}},
                      {0, std::nullopt, {-0.200, -0.300, -0.40 + 0.01 * i}}};
        job.paths.push_back(path);
    }
    const JobPlan plan = plan_watched(job);
    const Replay replay(plan);
    EXPECT_EQ(replay.looks, 4) << "once a line, both passes";
    EXPECT_LT(replay.worst, 0.9e-3) << "two lines of 100 mm a group";
}

TEST(LookPlan, WhatTheAxesCannotDoIsRefusedWithTheLine) {
    const auto refused = [](const Job& job, const MachineConfig& machine = reference_machine()) {
        try {
            (void)plan_watched(job, machine);
        } catch (const InputError& error) {
            return std::string(error.what());
        }
        return std::string("nothing");
    };
    Job far = watched();
    far.datum_line->length = 260_mm;
    far.cross.reset();
    EXPECT_NE(refused(far).find("too long for the Y sensor"), std::string::npos) << refused(far);
    MachineConfig narrow = reference_machine();
    narrow.axis[0].travel_min = -0.300;
    EXPECT_NE(refused(watched(), narrow).find("from which the Y sensor looks"), std::string::npos)
        << refused(watched(), narrow);
}

}  // namespace
}  // namespace sc::host

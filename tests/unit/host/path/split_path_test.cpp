// SPDX-License-Identifier: Apache-2.0
#include "host/path/split_path.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <variant>
#include <vector>

#include <gtest/gtest.h>

#include "sample_job.hpp"

namespace sc::host {
namespace {

Piece line(const Vec3& from, const Vec3& to) { return {from, to, std::nullopt, 0}; }

/// Lines along z, 4 mm apart, to and fro.
std::vector<Stroke3> comb(int lines) {
    std::vector<Stroke3> strokes;
    for (int i = 0; i < lines; ++i) {
        const double x = -0.3 + 0.004 * i;
        const double way = i % 2 == 0 ? 0.02 : -0.02;
        strokes.push_back({line({x, -0.3, -0.25 - way}, {x, -0.3, -0.25 + way})});
    }
    return strokes;
}

PathBegin begin(Actuator actuator, double speed) {
    PathBegin b;
    b.actuator = actuator;
    b.speed_um_s = static_cast<std::uint32_t>(speed * 1e6);
    b.pitch_nm = 50'000;
    b.energy_nj = 300'000;
    b.tolerance_nm = 5'000;
    return b;
}

/// The curve of the items alone, as the controller would read them.
struct Curve {
    double spacing = 0.0;
    std::vector<Vec3> control;
};
Curve curve_of(const std::vector<Item>& items) {
    Curve curve;
    for (const Item& item : items) {
        if (const auto* stage = std::get_if<StageCurve>(&item)) {
            curve.spacing = stage->spacing_um * 1e-6;
        } else if (const auto* knot = std::get_if<StageKnot>(&item)) {
            curve.control.push_back({knot->x * 1e-8, knot->y * 1e-8, knot->z * 1e-8});
        }
    }
    return curve;
}

TEST(SplitPath, TheStageKeepsItsShareAndTheMirrorsReachEveryPoint) {
    const MachineConfig machine = reference_machine();
    const StrokePath path = split_path(begin(Actuator::split, 1.0), comb(40), machine);
    ASSERT_LE(path.stage.worst, 1.0 + kStageSlack);
    const Curve curve = curve_of(path.items);
    const double rate = 1.0 / curve.spacing;
    for (std::size_t i = 0; i + 3 < curve.control.size(); ++i) {
        const auto& c = curve.control;
        for (std::size_t k = 0; k < 3; ++k) {
            const double d1 = c[i + 1][k] - c[i][k];
            const double d2 = c[i + 2][k] - 2.0 * c[i + 1][k] + c[i][k];
            const double d3 = c[i + 3][k] - 3.0 * c[i + 2][k] + 3.0 * c[i + 1][k] - c[i][k];
            EXPECT_LE(std::abs(d1) * rate, 0.5 * machine.axis[k].speed);
            EXPECT_LE(std::abs(d2) * rate * rate, 0.5 * machine.axis[k].acceleration);
            EXPECT_LE(std::abs(d3) * rate * rate * rate, 0.5 * machine.axis[k].jerk);
        }
    }
    double distance = 0.0;
    const PathPoint* last = nullptr;
    std::size_t given = 0;
    for (const Item& item : path.items) {
        given += std::holds_alternative<StageKnot>(item) ? 1U : 0U;
        if (const auto* point = std::get_if<PathPoint>(&item)) {
            const Vec3 place{point->x * 1e-8, point->y * 1e-8, point->z * 1e-8};
            if (last != nullptr) {
                distance += norm(place - Vec3{last->x * 1e-8, last->y * 1e-8, last->z * 1e-8});
            }
            ASSERT_GE(static_cast<double>(given), std::floor(distance / curve.spacing) + 4.0) << "knots come first";
            for (const double back : {0.0, 0.03, 0.068}) {
                const Vec3 stage = stage_at(curve.control, curve.spacing, distance - back);
                EXPECT_LE(std::abs(place.x - stage.x), 0.054);
                EXPECT_LE(std::abs(place.z - stage.z), 0.054);
            }
            last = point;
        }
    }
    EXPECT_NEAR(distance, path.length, 1e-3);
}

TEST(SplitPath, IsDarkFromTheEndOfEachLineToTheBeginningOfTheNext) {
    for (const Actuator actuator : {Actuator::galvo, Actuator::split}) {
        const std::vector<Stroke3> strokes = comb(7);
        const StrokePath path = stroke_path(begin(actuator, 1.0), strokes, reference_machine());
        std::vector<PathPoint> changes;
        PathPoint last;
        bool on = true;
        for (const Item& item : path.items) {
            if (const auto* point = std::get_if<PathPoint>(&item)) {
                last = *point;
            } else if (const auto* light = std::get_if<PathLight>(&item)) {
                EXPECT_NE(light->on, on);
                on = light->on;
                changes.push_back(last);
            }
        }
        EXPECT_TRUE(on);
        ASSERT_EQ(changes.size(), 12U);
        for (std::size_t i = 0; i < 6; ++i) {
            EXPECT_NEAR(changes[2 * i].z * 1e-8, strokes[i].back().to.z, 1e-8);
            EXPECT_NEAR(changes[2 * i + 1].z * 1e-8, strokes[i + 1].front().from.z, 1e-8);
        }
    }
}

TEST(SplitPath, GoesSlowerWhereTheStageCannotFollowAndSaysSoWhereItNeverCan) {
    // 60 mm a line of 8 mm: the mirrors bridge one such step, not twenty.
    std::vector<Stroke3> strokes;
    for (int i = 0; i < 6; ++i) {
        const double x = -0.4 + 0.06 * i;
        strokes.push_back({line({x, -0.3, -0.252}, {x, -0.3, -0.248})});
    }
    const StrokePath slower = split_path(begin(Actuator::split, 0.4), strokes, reference_machine());
    EXPECT_LE(slower.stage.worst, 1.0 + kStageSlack);
    const auto& made = std::get<PathBegin>(slower.items.front());
    EXPECT_LT(made.speed_um_s, 400'000U);
    EXPECT_GE(made.speed_um_s, 100'000U);
    EXPECT_EQ(made.pitch_nm, 50'000U);
    const StrokePath never = split_path(begin(Actuator::split, 1.9), strokes, reference_machine());
    EXPECT_GT(never.stage.worst, 1.0 + kStageSlack);
}

TEST(SplitPath, LinesOfAFaceWithTheSameSplitSettingsBecomeOnePath) {
    Job job = sample::job();
    job.cross->settings.actuator = Actuator::split;
    const JobPlan plan = sample::plan(job, sample::table());
    int begins = 0;
    int knots = 0;
    for (const Item& item : plan.items) {
        const auto* b = std::get_if<PathBegin>(&item);
        begins += b != nullptr && b->actuator == Actuator::split ? 1 : 0;
        knots += std::holds_alternative<StageKnot>(item) ? 1 : 0;
    }
    EXPECT_EQ(begins, 2) << "one a face";
    EXPECT_GT(knots, 8);
    ASSERT_EQ(plan.paths.size(), 18U) << "four crosses and a line on each of two faces";
    for (const PlannedPath& path : plan.paths) {
        EXPECT_TRUE(std::holds_alternative<PathBegin>(plan.items[path.first_item])) << path.marker;
        EXPECT_TRUE(std::holds_alternative<PathEnd>(plan.items[path.first_item + path.item_count - 1]));
    }
    EXPECT_EQ(plan.paths[0].id, plan.paths[7].id);
    EXPECT_NE(plan.paths[7].id, plan.paths[8].id);
    EXPECT_EQ(plan.expected_pulses, sample::plan(sample::job(), sample::table()).expected_pulses);
}

TEST(SplitPath, AJobWhoseStageCannotFollowIsRefusedWithWhatToDo) {
    Job job = sample::job();
    job.cross->settings.actuator = Actuator::split;
    job.cross->settings.speed = Speed::from_si(1.6);
    VerificationTable table = sample::table();
    for (auto& row : table.rows) {
        row.measured.v.x = row.measured.v.x < -0.25 ? -0.42 : -0.04;
        row.measured.v.y = sample::depth(row.measured.v.x, row.measured.v.z);
    }
    const InputError refusal = sample::refusal_of([&] { static_cast<void>(sample::plan(job, table)); });
    EXPECT_NE(refusal.problem().find("split"), std::string::npos);
    EXPECT_NE(refusal.action().find("slower"), std::string::npos);
}

}  // namespace
}  // namespace sc::host

// SPDX-License-Identifier: Apache-2.0
#include "host/inspection/what_if.hpp"

#include <cmath>
#include <numeric>

#include <gtest/gtest.h>

#include "tests/bench/allowance_workload.hpp"
#include "tests/unit/host/inspection/shapes.hpp"

namespace sc::host::test {
namespace {

struct Block {
    DistanceField field{bored_block(0.06, 0.03, 0.012, 360)};
    FaceMap map = segmented(field.mesh(), field.topology());
    FaceGauge gauge{field, map};
    AllowancePlan plan = plan_for_all(map, 1e-3);
    std::vector<BorrowPoint> points;

    Block() {
        // In the bore metal stands inside.
        for (const Vec3& place : places_off(field.mesh(), 40'000, 1e-3, 1.5e-3, 2e-5, 3)) {
            const Distance at = field.at(place);
            const std::uint32_t group = plan.group_of_face[map.face_of[at.triangle]];
            if (group != kNoGroup && at.feature == Feature::face) {
                points.push_back({place, group});
            }
        }
    }
};

Rigid<frame::W, frame::W> motion(double size) {
    return {turn_by(Vec3{1e-3 * size, -2e-3 * size, 3e-3 * size}), size * Vec3{2e-4, -3e-4, 1e-4}};
}

void expect_same(const AllowanceReport& exact, std::span<const TriedFace> tried, double within) {
    ASSERT_EQ(exact.faces.size(), tried.size());
    for (std::size_t i = 0; i < tried.size(); ++i) {
        EXPECT_EQ(exact.faces[i].count, tried[i].count);
        EXPECT_NEAR(exact.faces[i].least, tried[i].least, within) << exact.faces[i].id;
        EXPECT_NEAR(exact.faces[i].mean, tried[i].mean, within) << exact.faces[i].id;
        EXPECT_EQ(std::accumulate(tried[i].histogram.begin(), tried[i].histogram.end(), std::size_t{0}),
                  tried[i].count);
    }
}

TEST(WhatIf, AtTheBaseItIsTheReport) {
    const Block block;
    WhatIf tried(block.gauge, block.points, block.plan.groups);
    const AllowanceReport exact = evaluate(block.gauge, block.points, block.plan.groups, {});
    expect_same(exact, tried.frame({}), 1e-7);
    const auto moved = motion(1.0);
    const AllowanceReport& base = tried.base(moved);
    expect_same(base, tried.frame(moved), 1e-7);
    expect_same(evaluate(block.gauge, block.points, block.plan.groups, moved), tried.frame(moved), 1e-7);
}

TEST(WhatIf, WhileDraggingItIsOffByLessThanAStripsSagitta) {
    const Block block;
    WhatIf tried(block.gauge, block.points, block.plan.groups);
    const double sagitta = 0.012 * (1.0 - std::cos(3.1416 / 360.0));
    for (const double size : {0.1, 0.5, 1.0, -1.0}) {
        // A point may pass several strips: in the bore 0.5 mm are some two of them, 1 degree each.
        expect_same(evaluate(block.gauge, block.points, block.plan.groups, motion(size)), tried.frame(motion(size)),
                    20.0 * sagitta * std::max(1.0, std::abs(size)));
    }
}

TEST(WhatIf, TheMapIsInTheOrderOfThePoints) {
    const Block block;
    WhatIf tried(block.gauge, block.points, block.plan.groups);
    const auto moved = motion(0.5);
    static_cast<void>(tried.base(moved));
    static_cast<void>(tried.frame(moved));
    const std::vector<float> margins = tried.margins();
    ASSERT_EQ(margins.size(), block.points.size());
    for (std::size_t i = 0; i < margins.size(); i += 97) {
        const BorrowGroup& group = block.plan.groups[block.points[i].group];
        const Vec3 place = moved.rotation * block.points[i].place + moved.translation;
        EXPECT_NEAR(static_cast<double>(margins[i]), block.gauge.at(place, group.face).value - group.least, 1e-7);
    }
}

}  // namespace
}  // namespace sc::host::test

// SPDX-License-Identifier: Apache-2.0
#include "host/inspection/borrowing.hpp"

#include <algorithm>
#include <map>

#include <gtest/gtest.h>

#include "host/formats/error.hpp"
#include "host/inspection/allowance.hpp"
#include "tests/bench/allowance_workload.hpp"
#include "tests/unit/host/inspection/shapes.hpp"

namespace sc::host {
namespace {

TEST(Equalise, IsThePapersExample) {
    const Equalised out = equalise(1.84e-3, 2.76e-3);
    EXPECT_NEAR(out.shift, 0.46e-3, 1e-15);
    EXPECT_NEAR(out.left, 2.30e-3, 1e-15);  // the paper prints 2.29
    EXPECT_NEAR(out.right, 2.30e-3, 1e-15);
}

/// Points over the two z sides of a box, with that much metal.
std::vector<BorrowPoint> over_two_sides(double height, double below, double above) {
    std::vector<BorrowPoint> out;
    for (int i = 1; i < 20; ++i) {
        for (int k = 1; k < 20; ++k) {
            const double x = 5e-3 * i;
            const double y = 5e-3 * k;
            out.push_back({{x, y, -below}, 0});
            out.push_back({{x, y, height + above}, 1});
        }
    }
    return out;
}

struct Box {
    DistanceField field{test::box_mesh({0.0, 0.0, 0.0}, {0.1, 0.1, 0.05})};
    FaceMap map = segmented(field.mesh(), field.topology());
    FaceGauge gauge{field, map};
    std::uint32_t below = map.face_of[field.at({0.03, 0.05, -0.01}).triangle];
    std::uint32_t above = map.face_of[field.at({0.03, 0.05, 0.06}).triangle];
};

TEST(Borrowing, WithOneAxisFreeIsTheEqualiser) {
    const Box box;
    const auto points = over_two_sides(0.05, 1.84e-3, 2.76e-3);
    const std::vector<BorrowGroup> groups{{.id = "left", .face = box.below}, {.id = "right", .face = box.above}};
    const Borrowing out =
        borrow(box.field, box.gauge, points, groups, {.free = {false, false, true, false, false, false}});
    EXPECT_NEAR(out.along[2], -0.46e-3, 1e-10);
    EXPECT_NEAR(out.margin_before, 1.84e-3, 1e-12);
    EXPECT_NEAR(out.margin, 2.30e-3, 1e-10);
    EXPECT_LE(out.kkt_residual, 1e-9);
    EXPECT_EQ(out.along[0], 0.0);
    EXPECT_EQ(out.along[3], 0.0);
}

TEST(Borrowing, TakesRequirementsAndBoundsAndLocksIntoAccount) {
    const Box box;
    const auto points = over_two_sides(0.05, 1e-3, 3e-3);
    const std::vector<BorrowGroup> groups{{.id = "left", .face = box.below, .least = 0.5e-3},
                                          {.id = "right", .face = box.above, .least = 1.5e-3}};
    const Borrowing all = borrow(box.field, box.gauge, points, groups);
    EXPECT_NEAR(all.margin, 1e-3, 1e-9);
    EXPECT_NEAR(all.along[2], -0.5e-3, 1e-9);
    EXPECT_NEAR(all.along[0], 0.0, 1e-9) << "what does no good is not moved";
    BorrowOptions bounded;
    bounded.bound[2] = 0.1e-3;
    const Borrowing some = borrow(box.field, box.gauge, points, groups, bounded);
    EXPECT_NEAR(some.along[2], -0.1e-3, 1e-9);
    EXPECT_NEAR(some.margin, 0.6e-3, 1e-9);
    ASSERT_EQ(some.bounds.size(), 1U);
    EXPECT_EQ(some.bounds[0].motion, 2U);
    const DatumPlane datum{.id = "A", .point = {{0.0, 0.0, 0.025}}, .normal = {{0.0, 0.0, 1.0}}, .note = ""};
    const Borrowing locked = borrow(box.field, box.gauge, points, groups, {.locked = {datum}});
    EXPECT_NEAR(locked.margin, locked.margin_before, 1e-12);
    EXPECT_NEAR(locked.along[2], 0.0, 1e-12);
    EXPECT_THROW(static_cast<void>(borrow(box.field, box.gauge, points, groups, {.free = {}})), InputError);
}

TEST(Borrowing, EvensOutATiltAtTheSameSmallestMargin) {
    const Box box;
    std::vector<BorrowPoint> points;
    for (const BorrowPoint& p : over_two_sides(0.05, 2e-3, 2e-3)) {
        const Mat3 turn = turn_by({0.01, -0.005, 0.0});
        points.push_back({turn * (p.place - Vec3{0.05, 0.05, 0.025}) + Vec3{0.05, 0.05, 0.025}, p.group});
    }
    const Borrowing out =
        borrow(box.field, box.gauge, points,
               std::vector<BorrowGroup>{{.id = "l", .face = box.below}, {.id = "r", .face = box.above}});
    EXPECT_NEAR(out.margin, 2e-3, 1e-8);
    EXPECT_GT(out.variance_before, 1e-8);
    EXPECT_LT(out.variance, 1e-15);
    EXPECT_NEAR(out.along[3], -0.01, 1e-4);
}

/// Height of a place over a machined feature, by the part file's own numbers alone.
double height_over(const MachinedFeature& f, const Vec3& p) {
    if (f.kind == FeatureKind::plane) {
        return dot(p - f.point.v, f.direction.v);
    }
    const Vec3 r = p - f.axis_point.v;
    return 0.5 * f.diameter - norm(r - dot(r, f.direction.v) * f.direction.v);
}

/// Judges a borrowing by itself: heights from the part file, and the conditions of an optimum added up. None of the
/// engine's code. Of bores the file knows the circle, the mesh has flat strips: they agree to `sagitta`.
void recheck(const Part& part, const std::vector<BorrowPoint>& points, const std::vector<BorrowGroup>& groups,
             const Borrowing& out) {
    constexpr double kSagitta = 2e-5;
    constexpr double kPlane = 2e-8;  // the file's 7 digits
    const auto feature = [&](std::uint32_t point) -> const MachinedFeature& {
        const std::string& id = groups[points[point].group].id;
        return *std::find_if(part.machined.begin(), part.machined.end(),
                             [&](const MachinedFeature& f) { return id == f.id || id.starts_with(f.id + "+"); });
    };
    const auto margin = [&](std::uint32_t point, const Vec3& at) {
        return height_over(feature(point), at) - groups[points[point].group].least;
    };
    const auto moved = [&](std::uint32_t i) { return out.motion.rotation * points[i].place + out.motion.translation; };
    for (std::uint32_t i = 0; i < points.size(); ++i) {
        const double allowed = feature(i).kind == FeatureKind::plane ? kPlane : kSagitta;
        ASSERT_GE(margin(i, moved(i)), out.margin - allowed) << "no point has less than the smallest margin";
    }
    std::array<double, 6> sum{};
    double weights = 0.0;
    for (const ActivePoint& a : out.active) {
        EXPECT_GT(a.multiplier, 0.0);
        weights += a.multiplier;
        const Vec3 p = moved(a.point);
        const bool plane = feature(a.point).kind == FeatureKind::plane;
        EXPECT_NEAR(margin(a.point, p), out.margin, plane ? kPlane : kSagitta) << "it does stop";
        EXPECT_NEAR((margin(a.point, p + 1e-6 * a.direction) - margin(a.point, p)) / 1e-6, 1.0, 2e-3) << "it does grow";
        const Vec3 turn = cross(p, a.direction);
        for (std::size_t i = 0; i < 3; ++i) {
            sum[i] += a.multiplier * a.direction[i];
            sum[3 + i] += a.multiplier * turn[i] / 0.07;
        }
    }
    EXPECT_NEAR(weights, 1.0, 1e-9);
    EXPECT_TRUE(out.bounds.empty());
    for (std::size_t i = 0; i < 6; ++i) {
        EXPECT_NEAR(sum[i], 0.0, 1e-9) << "motion " << i << ": what pushes one way is balanced";
    }
}

struct Casting {
    DistanceField field{read_mesh(test::casting("finished.stl")).mesh};
    FaceMap map = segmented(field.mesh(), field.topology());
    std::vector<Vec3> places;
    std::vector<Distance> distances;
    FaceGauge gauge{field, map};

    Casting() {
        places = test::places_off(read_mesh(test::casting("rough.stl")).mesh, 120000, 0.0, 0.0, 0.0, 1);
        distances.resize(places.size());
        field.measure(places, distances);
    }
};
const Casting& part() {
    static const Casting casting;
    return casting;
}

TEST(Allowance, OfTheCastingIsThatOfItsDrawing) {
    const Casting& c = part();
    const Part plan_file = read_part(test::casting("part.toml"));
    const AllowancePlan plan = plan_from(plan_file, c.field, c.map);
    const OverFaces over = points_over(c.field, c.map, plan, c.places, c.distances);
    const AllowanceReport report = evaluate(c.gauge, over.points, plan.groups, {});
    const std::map<std::string, double> nominal{
        {"righthole1", 1.5}, {"frontface", 0.5}, {"rightface1", 0.5}, {"rightface2", 0.5}, {"rightface3", 0.5}};
    for (const FaceAllowance& face : report.faces) {
        EXPECT_GT(face.count, 20U) << face.id;
        if (const auto found = nominal.find(face.id); found != nominal.end()) {
            EXPECT_NEAR(1e3 * face.least, found->second, 0.02) << face.id;
        }
    }
    ASSERT_NE(report.worst(), nullptr);
    EXPECT_NEAR(1e3 * report.least_margin, -0.2, 1e-6) << "the back faces have no metal as drawn, and 0.2 is asked";
    EXPECT_FALSE(report.enough());
}

TEST(Borrowing, FindsTheCastingsOptimumAndProvesIt) {
    const Casting& c = part();
    const Part plan_file = read_part(test::casting("part.toml"));
    const AllowancePlan plan = plan_from(plan_file, c.field, c.map);
    const OverFaces over = points_over(c.field, c.map, plan, c.places, c.distances);
    const Borrowing out = borrow(c.field, c.gauge, over.points, plan.groups);
    // Front asks for 0.5 of 0.5, back for 0.2 of 0: together -0.2, shared as -0.1 each.
    EXPECT_NEAR(1e3 * out.margin, -0.1, 1e-6);
    EXPECT_LE(out.kkt_residual, 1e-9);
    recheck(plan_file, over.points, plan.groups, out);
    EXPECT_LT(out.variance, out.variance_before);
}

TEST(Borrowing, WithoutTheBackFacesReachesMoreThanTheKnownShift) {
    const Casting& c = part();
    Part plan_file = read_part(test::casting("part.toml"));
    std::erase_if(plan_file.machined, [](const MachinedFeature& f) { return f.id.starts_with("backface"); });
    const AllowancePlan plan = plan_from(plan_file, c.field, c.map);
    const OverFaces over = points_over(c.field, c.map, plan, c.places, c.distances);
    const Borrowing out = borrow(c.field, c.gauge, over.points, plan.groups);
    // The shift (-0.5, 0, -0.5) gives 1.0 where 0.5 is asked, less what the flat strips of a bore cut off.
    EXPECT_GT(1e3 * out.margin, 0.5 - 2e-3);
    EXPECT_LE(out.kkt_residual, 1e-9);
    recheck(plan_file, over.points, plan.groups, out);
}

TEST(Borrowing, OfTheInfeasiblePlanNamesFrontAgainstBack) {
    const Casting& c = part();
    const AllowancePlan plan = plan_from(read_part(test::casting("part-infeasible.toml")), c.field, c.map);
    const OverFaces over = points_over(c.field, c.map, plan, c.places, c.distances);
    const Borrowing out = borrow(c.field, c.gauge, over.points, plan.groups);
    EXPECT_NEAR(1e3 * out.margin, -0.25, 1e-6) << "0.25 at best where 0.5 is asked";
    std::map<std::string, double> share;
    for (const ActivePoint& a : out.active) {
        share[plan.groups[a.group].id] += a.multiplier;
    }
    EXPECT_NEAR(share["frontface"], 0.5, 1e-6);
    EXPECT_NEAR(share["backface1"] + share["backface2"] + share["backface1+backface2"], 0.5, 1e-6);
}

TEST(AllowancePlan, RefusesFeaturesThatTheModelDoesNotHave) {
    const Casting& c = part();
    const Part whole = read_part(test::casting("part.toml"));
    const auto refused = [&](auto change) {
        Part changed = whole;
        change(changed);
        try {
            static_cast<void>(plan_from(changed, c.field, c.map));
            return std::string("not refused");
        } catch (const InputError& error) {
            return std::string(error.what());
        }
    };
    EXPECT_NE(refused([](Part& p) { p.machined[0].diameter *= 1.1; }).find("fronthole has another diameter"),
              std::string::npos);
    EXPECT_NE(refused([](Part& p) { p.machined[6].point.v.z += 1e-3; }).find("1.000 mm off"), std::string::npos);
    EXPECT_NE(refused([](Part& p) { p.machined[6].direction.v = {1, 0, 0}; }).find("no plane of that normal"),
              std::string::npos);
    EXPECT_NE(refused([](Part& p) { p.machined.clear(); }).find("no machined face"), std::string::npos);
}

}  // namespace
}  // namespace sc::host

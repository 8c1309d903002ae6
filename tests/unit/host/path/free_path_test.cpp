// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "host/path/check.hpp"
#include "sample_job.hpp"

namespace sc::host {
namespace {

/// An arc as points, not by the code under test: the centre solves three linear equations (two bisectors, the plane).
std::vector<Vec3> sampled(const Vec3& a, const Vec3& b, const Vec3& c) {
    const Vec3 n = cross(b - a, c - a);
    const std::array<Vec3, 3> rows{b - a, c - a, n};
    const Vec3 right{0.5 * (dot(b, b) - dot(a, a)), 0.5 * (dot(c, c) - dot(a, a)), dot(n, a)};
    const Mat3 m{rows};
    const double det = m.determinant();
    const auto solve = [&](std::size_t k) {
        Mat3 swapped = m.transposed();
        swapped.row[k] = right;
        return swapped.determinant() / det;
    };
    const Vec3 centre{solve(0), solve(1), solve(2)};
    std::vector<Vec3> out{a};
    constexpr int kSteps = 400;
    const Vec3 unit_n = (1.0 / norm(n)) * n;
    const Vec3 first = a - centre;
    const Vec3 second = cross(unit_n, first);
    const Vec3 end = c - centre;
    double angle = std::atan2(dot(end, second), dot(end, first));
    angle = angle < 0.0 ? angle + 2.0 * std::numbers::pi : angle;
    for (int i = 1; i <= kSteps; ++i) {
        const double phi = angle * i / kSteps;
        out.push_back(centre + std::cos(phi) * first + std::sin(phi) * second);
    }
    return out;
}

Vec3 metres(const PathPoint& p) { return {p.x * 1e-8, p.y * 1e-8, p.z * 1e-8}; }

/// What the controller is told, as a fine polyline.
std::vector<Vec3> told(const JobPlan& plan, const PlannedPath& path) {
    std::vector<Vec3> out;
    for (std::size_t i = path.first_item; i < path.first_item + path.item_count; ++i) {
        if (const auto* point = std::get_if<PathPoint>(&plan.items[i])) {
            out.push_back(metres(*point));
        } else if (const auto* arc = std::get_if<PathArc>(&plan.items[i])) {
            const auto points = sampled(out.back(), metres(arc->via), metres(arc->to));
            out.insert(out.end(), points.begin() + 1, points.end());
        }
    }
    return out;
}

double distance(const std::vector<Vec3>& polyline, const Vec3& at) {
    double least = 1.0;
    for (std::size_t i = 1; i < polyline.size(); ++i) {
        const Vec3 way = polyline[i] - polyline[i - 1];
        const double share = std::clamp(dot(at - polyline[i - 1], way) / std::max(dot(way, way), 1e-30), 0.0, 1.0);
        least = std::min(least, norm(at - polyline[i - 1] - share * way));
    }
    return least;
}

Job job_of(std::vector<PathStep> steps, MarkSettings settings = sample::axes_settings()) {
    Job job;
    job.file = "sample/job.toml";
    job.name = "free";
    JobPath path;
    path.line = 7;
    path.name = "rim";
    path.steps = std::move(steps);
    path.settings = settings;
    job.paths.push_back(path);
    return job;
}
PathStep at(double x_mm, double z_mm, double y_mm = -300.0) {
    return {10, std::nullopt, {x_mm * 1e-3, y_mm * 1e-3, z_mm * 1e-3}};
}
PathStep over(PathStep via, PathStep to) { return {11, via.to, to.to}; }

InputError refused(const Job& job, MachineConfig machine = reference_machine()) {
    return sample::refusal_of([&] { (void)plan_job(job, {}, sample::calibration(), machine); });
}
void expect_says(const InputError& error, const std::string& text) {
    EXPECT_NE(std::string(error.what()).find(text), std::string::npos) << error.what();
}

std::vector<PathStep> dense_circle(double radius_mm, int count, double share = 1.0, double noise_um = 0.0) {
    std::vector<PathStep> steps;
    for (int i = 0; i <= count; ++i) {
        const double phi = 2.0 * std::numbers::pi * share * i / count;
        const double r = radius_mm + 1e-3 * noise_um * std::sin(12.9898 * i);
        steps.push_back(at(-250.0 + r * std::cos(phi), -400.0 + r * std::sin(phi)));
    }
    return steps;
}

TEST(FreePath, PointsAndArcsBecomeItems) {
    const Job job = job_of({at(-260, -400), over(at(-250, -390), at(-240, -400)), at(-230, -400)});
    const JobPlan plan = sample::plan(job, {});
    ASSERT_EQ(plan.items.size(), 7U);  // turn, begin, point, arc, point, end, end of the job
    EXPECT_TRUE(std::holds_alternative<Turn>(plan.items[0]));
    EXPECT_EQ(std::get<PathPoint>(plan.items[2]), (PathPoint{-26'000'000, -30'000'000, -40'000'000}));
    const auto& arc = std::get<PathArc>(plan.items[3]);
    EXPECT_EQ(arc.via, (PathPoint{-25'000'000, -30'000'000, -39'000'000}));
    EXPECT_EQ(arc.to, (PathPoint{-24'000'000, -30'000'000, -40'000'000}));
    ASSERT_EQ(plan.paths.size(), 1U);
    EXPECT_EQ(plan.paths[0].kind, PathKind::free_path);
    EXPECT_NEAR(plan.marked_metres, 10e-3 * std::numbers::pi + 10e-3, 1e-12);
    EXPECT_EQ(plan.expected_pulses, static_cast<std::uint64_t>(plan.marked_metres / 20e-6) + 1);
}

TEST(FreePath, AlmostAWholeCircleIsTwoArcsAndViaIsPutInTheMiddle) {
    // A circle of 10 mm from phi = 0 to 350 degrees, given by a via at 10 degrees.
    const auto on = [](double deg) {
        return at(-250.0 + 10.0 * std::cos(deg * std::numbers::pi / 180),
                  -400.0 + 10.0 * std::sin(deg * std::numbers::pi / 180));
    };
    const JobPlan plan = sample::plan(job_of({on(0), over(on(10), on(350))}), {});
    ASSERT_EQ(plan.items.size(), 7U);
    const auto& first = std::get<PathArc>(plan.items[3]);
    const auto& second = std::get<PathArc>(plan.items[4]);
    const auto near = [&](const PathPoint& p, double deg) { EXPECT_LT(norm(metres(p) - on(deg).to), 2e-8) << deg; };
    near(first.via, 87.5);
    near(first.to, 175.0);
    near(second.via, 262.5);
    near(second.to, 350.0);
}

TEST(FreePath, RefusesWhatIsNoArc) {
    expect_says(refused(job_of({at(-260, -400), over(at(-250, -400), at(-240, -400))})), "lie on one line");
    expect_says(refused(job_of({at(-260, -400), over(at(-250, -399.99995), at(-240, -400))})), "too wide");
    expect_says(refused(job_of({at(-260, -400), over(at(-250, -390), at(-260, -400))})), "two arcs");
    expect_says(refused(job_of({at(-260, -400), at(-260, -400), at(-250, -400)})), "repeated");
    MarkSettings settings = sample::axes_settings();
    settings.tolerance = Length::from_si(0.05e-6);
    expect_says(refused(job_of({at(-260, -400), over(at(-250, -390), at(-240, -400))}, settings)), "tolerance");
    const InputError error = refused(job_of({at(-260, -400), over(at(-250, -400), at(-240, -400))}));
    EXPECT_EQ(error.line(), 11);
    EXPECT_EQ(error.file(), "sample/job.toml");
}

TEST(FreePath, TheArcItselfMustFitNotOnlyItsEnds) {
    // x travel ends at 0: the ends are inside, the arc's top is not.
    MachineConfig machine = reference_machine();
    const double edge = machine.axis[index(Axis::x)].travel_max * 1e3;
    const Job out = job_of({at(edge - 5, -410), over(at(edge + 5, -400), at(edge - 5, -390))});
    expect_says(refused(out), "the arc to place 2 is out of the travel of x");
    EXPECT_NO_THROW((void)sample::plan(job_of({at(-260, -400), over(at(-250, -390), at(-240, -400))}), {}));
    machine.keep_out_count = 1;
    machine.keep_out[0] = {{-0.2505, -0.31, -0.3905}, {-0.2495, -0.29, -0.3895}};  // at the arc's top, off its chord
    expect_says(refused(job_of({at(-260, -400), over(at(-250, -390), at(-240, -400))}), machine), "keep-out");
    machine.keep_out[0] = {{-0.2505, -0.31, -0.4005}, {-0.2495, -0.29, -0.3995}};  // on its chord, off the arc
    EXPECT_NO_THROW((void)plan_job(job_of({at(-260, -400), over(at(-250, -390), at(-240, -400))}), {},
                                   sample::calibration(), machine));
}

TEST(FreePath, GalvoArcsMustFitTheField) {
    const double half = reference_machine().galvo.half_field.si() * 1e3;
    // The ends stand on one side: the box's middle is the anchor, and the circle is wider than the field.
    const double r = half * 1.1;
    const Job wide = job_of({at(-250 - r, -400), over(at(-250, -400 + r), at(-250 + r, -400)),
                             over(at(-250, -400 - r), at(-250 - r, -400))},
                            sample::galvo_settings());
    expect_says(refused(wide), "field");
    const double s = half * 0.5;
    const Job fits = job_of({at(-250 - s, -400), over(at(-250, -400 + s), at(-250 + s, -400)),
                             over(at(-250, -400 - s), at(-250 - s, -400))},
                            sample::galvo_settings());
    const JobPlan plan = sample::plan(fits, {});
    EXPECT_NEAR(plan.paths[0].centre.v.x, -0.25, 1e-12);
    EXPECT_NEAR(plan.paths[0].centre.v.z, -0.40, 1e-12);
}

TEST(FreePath, APathJoinsItsFacesMarks) {
    Job job = sample::job();
    job.paths = job_of({at(-260, -400), at(-240, -390)}).paths;
    job.paths[0].face_deg = 90.0;
    const JobPlan plan = sample::plan(job, sample::table());
    EXPECT_EQ(plan.faces, (std::vector<double>{0.0, 90.0}));
    EXPECT_EQ(plan.paths.back().kind, PathKind::free_path);
    EXPECT_EQ(plan.paths.back().face_deg, 90.0);
    EXPECT_EQ(plan.paths.size(), 19U);
}

TEST(FreePath, ArcFitIsOffByDefault) {
    const JobPlan plan = sample::plan(job_of(dense_circle(10.0, 1000)), {});
    EXPECT_EQ(plan.items.size(), 1001U + 4U);
}

void expect_fits(const std::vector<PathStep>& steps, std::size_t most_items) {
    Job job = job_of(steps);
    job.paths[0].arc_fit = 0.2;
    const JobPlan plan = sample::plan(job, {});
    EXPECT_LE(plan.items.size(), most_items);
    const std::vector<Vec3> line = told(plan, plan.paths[0]);
    double worst = 0.0;
    for (const PathStep& step : steps) {
        worst = std::max(worst, distance(line, step.to));
    }
    EXPECT_LE(worst, 0.2 * 5e-6 + 2e-8) << "a share of 0.2 of 5 um, and the wire's rounding";
    std::vector<Vec3> asked;
    for (const PathStep& step : steps) {
        asked.push_back(step.to);
    }
    double bulge = 0.0;
    for (const Vec3& place : line) {
        bulge = std::max(bulge, distance(asked, place));
    }
    EXPECT_LE(bulge, 0.2 * 5e-6 + 2e-8) << "nor does the arc leave the straight pieces by more";
    EXPECT_EQ(std::get<PathBegin>(plan.items[1]).tolerance_nm, 4000U) << "what is left of it";
}

TEST(FreePath, ArcFitReplacesDensePointsWithinItsShare) {
    expect_fits(dense_circle(10.0, 1000), 12);
    expect_fits(dense_circle(10.0, 1000, 0.4, 0.5), 12);  // points 0.5 um off
    std::vector<PathStep> wave;                           // bends that no single arc follows
    for (int i = 0; i <= 2000; ++i) {
        const double x = -280.0 + 0.03 * i;
        wave.push_back(at(x, -400.0 + 4.0 * std::sin(0.3 * x), -300.0 + 0.5 * std::sin(0.1 * x)));
    }
    expect_fits(wave, 400);
}

TEST(FreePath, ArcFitLeavesCornersAndStraightLines) {
    for (const auto& steps :
         {std::vector<PathStep>{at(-260, -410), at(-240, -410), at(-240, -390), at(-260, -390), at(-260, -405)},
          std::vector<PathStep>{at(-260, -400), at(-255, -400), at(-250, -400), at(-245, -400), at(-240, -400),
                                at(-235, -400)},
          dense_circle(10.0, 12)}) {
        Job job = job_of(steps);
        job.paths[0].arc_fit = 0.2;
        const JobPlan plan = sample::plan(job, {});
        EXPECT_TRUE(
            std::ranges::none_of(plan.items, [](const Item& item) { return std::holds_alternative<PathArc>(item); }));
        EXPECT_EQ(plan.items.size(), steps.size() + 4U);
    }
}

TEST(FreePath, ReadsItsPlacesFromAFile) {
    const sample::TempFile file("route.csv", "x,y,z\n-260,-300,-400\n-250,-300,-390\n-250,-300,-390\n");
    Job job = job_of({});
    job.paths[0].file = file.path();
    const InputError error = refused(job);
    expect_says(error, "repeated");
    EXPECT_EQ(error.line(), 4);
    EXPECT_EQ(error.file(), file.path().string());
}

}  // namespace
}  // namespace sc::host

// SPDX-License-Identifier: Apache-2.0
#include "host/path/job_plan.hpp"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "sample_job.hpp"
#include "shared/path/job_hash.hpp"

namespace sc::host {
namespace {

std::size_t count_of(const JobPlan& plan, PathKind kind) {
    return static_cast<std::size_t>(
        std::ranges::count_if(plan.paths, [kind](const PlannedPath& p) { return p.kind == kind; }));
}
const PlannedPath& path_of(const JobPlan& plan, double face, PathKind kind, int marker) {
    const auto it = std::ranges::find_if(
        plan.paths, [&](const PlannedPath& p) { return p.face_deg == face && p.kind == kind && p.marker == marker; });
    EXPECT_NE(it, plan.paths.end());
    return *it;
}

TEST(JobPlan, HasTwoStrokesAMarkerAndALineAFace) {
    const JobPlan plan = sample::plan(sample::job(), sample::table());
    EXPECT_EQ(plan.faces, (std::vector<double>{0.0, 90.0}));
    EXPECT_EQ(count_of(plan, PathKind::cross_horizontal), 8U);
    EXPECT_EQ(count_of(plan, PathKind::cross_vertical), 8U);
    EXPECT_EQ(count_of(plan, PathKind::datum_line), 2U);
    // Two turns, 18 paths of four items, the end.
    EXPECT_EQ(plan.items.size(), 2U + 18U * 4U + 1U);
}

TEST(JobPlan, ItemsAreInTheGrammarsOrder) {
    const JobPlan plan = sample::plan(sample::job(), sample::table());
    EXPECT_TRUE(std::holds_alternative<Turn>(plan.items.front()));
    EXPECT_TRUE(std::holds_alternative<JobEnd>(plan.items.back()));
    std::size_t next_path = 0;
    for (std::size_t i = 1; i + 1 < plan.items.size();) {
        if (std::holds_alternative<Turn>(plan.items[i])) {
            ++i;
            continue;
        }
        const PlannedPath& path = plan.paths[next_path];
        ASSERT_TRUE(std::holds_alternative<PathBegin>(plan.items[i]));
        EXPECT_EQ(std::get<PathBegin>(plan.items[i]).path, next_path);
        EXPECT_EQ(path.first_item, i);
        EXPECT_EQ(path.item_count, 4U);
        EXPECT_TRUE(std::holds_alternative<PathPoint>(plan.items[i + 1]));
        EXPECT_TRUE(std::holds_alternative<PathPoint>(plan.items[i + 2]));
        EXPECT_TRUE(std::holds_alternative<PathEnd>(plan.items[i + 3]));
        i += 4;
        ++next_path;
    }
    EXPECT_EQ(next_path, plan.paths.size());
}

TEST(JobPlan, CrossKeepsItsCentreAndFollowsTheFacesSlope) {
    VerificationTable table = sample::table();
    table.rows[0].measured.v.y += 25e-6;  // off the plane: the centre keeps it
    const JobPlan plan = sample::plan(sample::job(), table);
    const PlannedPath& across = path_of(plan, 0.0, PathKind::cross_horizontal, 1);
    const PlannedPath& up = path_of(plan, 0.0, PathKind::cross_vertical, 1);
    EXPECT_EQ(across.centre, table.rows[0].measured);
    EXPECT_NEAR(norm(0.5 * (across.from.v + across.to.v) - across.centre.v), 0.0, 1e-15);
    EXPECT_NEAR(std::abs(across.to.v.x - across.from.v.x), 4e-3, 1e-15);
    EXPECT_EQ(across.to.v.z, across.from.v.z);
    EXPECT_NEAR(std::abs(up.to.v.z - up.from.v.z), 4e-3, 1e-15);
    EXPECT_EQ(up.to.v.x, up.from.v.x);
    // 25 µm at one of four corners tilt the plane by 12.5 µm per 60 and per 40 mm.
    const double slope_x = (across.to.v.y - across.from.v.y) / (across.to.v.x - across.from.v.x);
    const double slope_z = (up.to.v.y - up.from.v.y) / (up.to.v.z - up.from.v.z);
    EXPECT_NEAR(slope_x, 0.01 - 12.5e-6 / 0.06, 1e-9);
    EXPECT_NEAR(slope_z, 0.02 - 12.5e-6 / 0.04, 1e-9);
}

TEST(JobPlan, GalvoPathsStandAtTheMeasuredPlace) {
    const JobPlan plan = sample::plan(sample::job(), sample::table());
    const PlannedPath& path = path_of(plan, 0.0, PathKind::cross_vertical, 4);
    const auto& begin = std::get<PathBegin>(plan.items[path.first_item]);
    EXPECT_EQ(begin.actuator, Actuator::galvo);
    EXPECT_EQ(begin.anchor_x, -22'000'000);
    EXPECT_EQ(begin.anchor_y, std::llround(sample::depth(-0.22, -0.38) * 1e8));
    EXPECT_EQ(begin.anchor_z, -38'000'000);
    EXPECT_EQ(begin.speed_um_s, 250'000U);
    EXPECT_EQ(begin.pitch_nm, 20'000U);
    EXPECT_EQ(begin.energy_nj, 300'000U);
    EXPECT_EQ(begin.tolerance_nm, 5'000U);
}

TEST(JobPlan, PointsAreTheEndsInWireUnits) {
    const JobPlan plan = sample::plan(sample::job(), sample::table());
    for (const PlannedPath& path : plan.paths) {
        const auto& first = std::get<PathPoint>(plan.items[path.first_item + 1]);
        const auto& last = std::get<PathPoint>(plan.items[path.first_item + 2]);
        EXPECT_NEAR(first.x * 1e-8, path.from.v.x, 5.001e-9);
        EXPECT_NEAR(first.y * 1e-8, path.from.v.y, 5.001e-9);
        EXPECT_NEAR(first.z * 1e-8, path.from.v.z, 5.001e-9);
        EXPECT_NEAR(last.x * 1e-8, path.to.v.x, 5.001e-9);
        EXPECT_NEAR(last.y * 1e-8, path.to.v.y, 5.001e-9);
        EXPECT_NEAR(last.z * 1e-8, path.to.v.z, 5.001e-9);
    }
}

TEST(JobPlan, DatumLineLiesOnThePlaneAtTheCentroidsHeight) {
    const JobPlan plan = sample::plan(sample::job(), sample::table());
    const PlannedPath& line = path_of(plan, 90.0, PathKind::datum_line, 0);
    EXPECT_NEAR(norm(line.to.v - line.from.v), 0.06 * std::sqrt(1.0 + 0.01 * 0.01), 1e-12);
    for (const Vec3& end : {line.from.v, line.to.v}) {
        EXPECT_NEAR(end.z, -0.40, 1e-15);
        EXPECT_NEAR(end.y, sample::depth(end.x, end.z), 1e-12);
        EXPECT_NEAR(std::abs(end.x + 0.25), 0.03, 1e-12);
    }
}

TEST(JobPlan, DatumLineMovesAsideToStayInTravelWithItsRunIn) {
    VerificationTable table = sample::table();
    for (TableRow& row : table.rows) {
        row.measured.v.x += 0.22;  // around x = −30 mm: its end would be at 0, 5 mm before the end of travel
    }
    Job job = sample::job();
    job.datum_line->length = Length::from_si(0.09);
    const PlannedPath line = path_of(sample::plan(job, table), 0.0, PathKind::datum_line, 0);
    const double last = std::max(line.from.v.x, line.to.v.x);
    EXPECT_LT(last, 0.005 - 1e-3);
    EXPECT_GT(last, -0.005);
    EXPECT_NEAR(std::abs(line.to.v.x - line.from.v.x), 0.09, 1e-12);
}

TEST(JobPlan, TakesTheTurnNearestToWhereTheTableStands) {
    Job job = sample::job();
    job.faces[1].angle_deg = 270.0;
    VerificationTable table = sample::table();
    for (TableRow& row : table.rows) {
        row.face_deg = row.face_deg == 90.0 ? 270.0 : row.face_deg;
    }
    const JobPlan plan = sample::plan(job, table);
    EXPECT_EQ(std::get<Turn>(plan.items[0]).c, 0);
    const PlannedPath& first = *std::ranges::find(plan.paths, 270.0, &PlannedPath::face_deg);
    EXPECT_EQ(std::get<Turn>(plan.items[first.first_item - 1]).c, 9'000'000);
}

TEST(JobPlan, OtherwayRoundIfTravelAsksForIt) {
    Job job = sample::job();
    job.faces.erase(job.faces.begin());
    MachineConfig machine = reference_machine();
    machine.axis[index(Axis::c)].travel_min = -10.0;
    const JobPlan plan = plan_job(job, sample::table(), sample::calibration(), machine);
    EXPECT_EQ(std::get<Turn>(plan.items[0]).c, 27'000'000);
}

TEST(JobPlan, FilterLeavesOneFace) {
    const JobPlan plan = sample::plan(sample::job(), sample::table(), {.face = 90.0});
    EXPECT_EQ(plan.faces, (std::vector<double>{90.0}));
    EXPECT_TRUE(std::ranges::all_of(plan.paths, [](const PlannedPath& p) { return p.face_deg == 90.0; }));
    EXPECT_EQ(std::get<Turn>(plan.items.front()).c, -9'000'000);
}

TEST(JobPlan, RepeatsTheItemsOfEachPass) {
    Job job = sample::job();
    job.datum_line->settings.passes = 3;
    const JobPlan plan = sample::plan(job, sample::table());
    const PlannedPath& line = path_of(plan, 0.0, PathKind::datum_line, 0);
    EXPECT_EQ(line.item_count, 12U);
    for (std::uint8_t pass = 0; pass < 3; ++pass) {
        const auto& begin = std::get<PathBegin>(plan.items[line.first_item + 4U * pass]);
        EXPECT_EQ(begin.pass, pass);
        EXPECT_EQ(begin.path, line.id);
    }
}

TEST(JobPlan, CountsPulsesAndLength) {
    const JobPlan plan = sample::plan(sample::job(), sample::table());
    // A stroke is a hair longer than 4 mm for the slope of its face, which makes no further pulse.
    EXPECT_EQ(plan.expected_pulses, 16U * 201U + 2U * 3001U);
    EXPECT_NEAR(plan.marked_metres, 16 * 0.004 + 2 * 0.06, 1e-4);
}

TEST(JobPlan, EstimateOfTimeHoldsAllItsParts) {
    const JobPlan plan = sample::plan(sample::job(), sample::table());
    const double settle = 8 * 0.05;
    const double lines = 2 * 1.0;
    const double turn = 90.0 / 45.0;
    EXPECT_GT(plan.expected_seconds_estimate, settle + lines + turn);
    EXPECT_LT(plan.expected_seconds_estimate, 30.0);
    const JobPlan half = sample::plan(sample::job(), sample::table(), {.face = 0.0});
    EXPECT_LT(half.expected_seconds_estimate, plan.expected_seconds_estimate);
}

TEST(JobPlan, ChoosesTheLeastMultipleOfThePulseRate) {
    const JobPlan plan = sample::plan(sample::job(), sample::table());
    // 250 mm/s / 20 µm = 12.5 kHz → 25 kHz; 60 / 20 = 3 kHz → 21 kHz.
    EXPECT_EQ(path_of(plan, 0.0, PathKind::cross_horizontal, 1).pick, 2);
    EXPECT_EQ(path_of(plan, 0.0, PathKind::datum_line, 0).pick, 7);
}

TEST(JobPlan, HashIsThatOfTheItemsAlone) {
    const JobPlan plan = sample::plan(sample::job(), sample::table());
    EXPECT_EQ(plan.hash, job_hash(plan.items));

    Job renamed = sample::job();
    renamed.name = "another name";
    renamed.file = "elsewhere/job.toml";
    VerificationTable table = sample::table();
    table.file = "elsewhere/table.csv";
    for (TableRow& row : table.rows) {
        row.truth.v.x += 1e-3;
        row.line += 100;
    }
    EXPECT_EQ(sample::plan(renamed, table).hash, plan.hash);

    table.rows[3].measured.v.z += 1e-8;
    EXPECT_NE(sample::plan(renamed, table).hash, plan.hash);
}

TEST(JobPlan, RowsInAnotherOrderOfTheFileGiveTheSameTour) {
    VerificationTable table = sample::table();
    std::ranges::reverse(table.rows);
    EXPECT_EQ(sample::plan(sample::job(), table).hash, sample::plan(sample::job(), sample::table()).hash);
}

TEST(JobPlan, PathsCanBeMadeByTheAxesAlone) {
    Job job = sample::job();
    job.cross->settings = sample::axes_settings();
    const JobPlan plan = sample::plan(job, sample::table());
    const PlannedPath& path = path_of(plan, 0.0, PathKind::cross_horizontal, 2);
    const auto& begin = std::get<PathBegin>(plan.items[path.first_item]);
    EXPECT_EQ(begin.actuator, Actuator::axes);
    EXPECT_EQ(begin.anchor_x, 0);
}

}  // namespace
}  // namespace sc::host

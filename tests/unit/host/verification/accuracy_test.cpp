// SPDX-License-Identifier: Apache-2.0
#include "host/verification/accuracy.hpp"

#include <algorithm>
#include <cmath>
#include <map>

#include <gtest/gtest.h>

#include "ras3dm_run.hpp"

namespace sc::host {
namespace {

using synthetic::Ras3dmRun;

double found_error(const AccuracyReport& report, std::string_view name) {
    const auto it = std::ranges::find(report.common.errors, name, &FoundError::name);
    EXPECT_NE(it, report.common.errors.end()) << name;
    return it == report.common.errors.end() ? 0.0 : it->value;
}

TEST(Accuracy, PerfectCellShowsTheTablesOwnDeviations) {
    const Ras3dmRun run;
    const AccuracyReport report = run.assess();
    EXPECT_TRUE(report.complete);
    ASSERT_EQ(report.faces.size(), 4U);
    // Largest and rms of measured − true, worked out apart from this code from the printed table (mm).
    const std::map<double, std::pair<Vec3, Vec3>> printed{{0.0, {{0.077, 0.042, 0.080}, {0.047, 0.026, 0.045}}},
                                                          {90.0, {{0.100, 0.037, 0.150}, {0.064, 0.022, 0.061}}},
                                                          {180.0, {{0.115, 0.054, 0.137}, {0.065, 0.028, 0.065}}},
                                                          {270.0, {{0.095, 0.044, 0.108}, {0.051, 0.027, 0.042}}}};
    for (const FaceAccuracy& face : report.faces) {
        EXPECT_EQ(face.points.size(), 9U);
        const auto& [max, rms] = printed.at(face.face_deg);
        for (std::size_t i = 0; i < 3; ++i) {
            EXPECT_NEAR(1e3 * face.found.max[i], max[i], 0.0012) << face.face_deg << " axis " << i;
            EXPECT_NEAR(1e3 * face.found.rms[i], rms[i], 0.0012) << face.face_deg << " axis " << i;
            EXPECT_NEAR(face.csv.max[i], face.found.max[i], 0.3e-6);
            EXPECT_NEAR(face.csv.rms[i], face.found.rms[i], 0.3e-6);
        }
    }
    EXPECT_LT(report.max_command_error, 0.01e-6);
    EXPECT_EQ(report.lines.size(), 4U);
    for (const LineAccuracy& line : report.lines) {
        ASSERT_TRUE(line.command_error);
        EXPECT_LT(*line.command_error, 0.01e-6);
        EXPECT_GE(line.found.length, 0.0599);
    }
}

TEST(Accuracy, ShiftAndShearShowExactlyInTheReport) {
    Ras3dmRun run;
    run.error = [](const Vec3& p) { return Vec3{50e-6 + 0.1e-3 * p.z, 0.0, 0.0}; };
    const AccuracyReport report = run.assess();
    EXPECT_TRUE(report.complete);
    EXPECT_NEAR(found_error(report, "offset_x"), 50.0, 0.01);
    EXPECT_NEAR(found_error(report, "squareness_xz"), 0.1, 1e-5);
    EXPECT_NEAR(found_error(report, "offset_z"), 0.0, 0.01);
    EXPECT_NEAR(found_error(report, "rotation"), 0.0, 1e-5);
    EXPECT_NEAR(found_error(report, "scale_x"), 0.0, 0.05);
    EXPECT_LT(report.common.worst_um, 0.02);
    for (const FaceAccuracy& face : report.faces) {
        for (const PointAccuracy& point : face.points) {
            const double shift = 50e-6 + 0.1e-3 * point.commanded->z;
            EXPECT_NEAR(point.deviation.x, point.csv_deviation.x + shift, 0.3e-6);
            EXPECT_NEAR(point.command_error->x, shift, 0.01e-6);
        }
        // A trace that lists no errors says nothing of what to expect.
        EXPECT_FALSE(face.foretold);
        EXPECT_FALSE(face.difference);
    }
}

TEST(Accuracy, ErrorsListedInTheHeaderAreForetold) {
    Ras3dmRun run;
    run.header.errors = {{"axes.squareness_xz", 0.1, "mrad", ""}, {"galvo.offset_x", 50.0, "um", ""}};
    run.calibration.axes.reset();
    run.calibration.galvo.reset();
    run.error = [](const Vec3& p) { return Vec3{50e-6 + 0.1e-3 * p.z, 0.0, 0.0}; };
    const AccuracyReport report = run.assess();
    for (const FaceAccuracy& face : report.faces) {
        ASSERT_TRUE(face.foretold && face.difference);
        EXPECT_LT(*face.difference, 0.3e-6);
        EXPECT_GT(std::abs(face.foretold->max.x - face.csv.max.x), 1e-6);
    }
    ASSERT_EQ(report.known.size(), 2U);
    EXPECT_EQ(report.known[1].left, 50.0);
}

TEST(Accuracy, ShiftOfTheTraceShiftsEveryDeviation) {
    Ras3dmRun plain;
    plain.noise = 3e-6;
    Ras3dmRun shifted;
    shifted.noise = 3e-6;
    shifted.error = [](const Vec3&) { return Vec3{20e-6, -10e-6, 5e-6}; };
    const AccuracyReport a = plain.assess();
    const AccuracyReport b = shifted.assess();
    for (std::size_t f = 0; f < 4; ++f) {
        ASSERT_EQ(a.faces[f].points.size(), b.faces[f].points.size());
        for (std::size_t i = 0; i < a.faces[f].points.size(); ++i) {
            const Vec3 moved = b.faces[f].points[i].deviation - a.faces[f].points[i].deviation;
            EXPECT_LT(norm(moved - Vec3{20e-6, -10e-6, 5e-6}), 1e-10);
        }
    }
}

TEST(Accuracy, CommandErrorStaysWithinTheNoise) {
    Ras3dmRun run;
    run.noise = 3e-6;
    const AccuracyReport report = run.assess();
    EXPECT_TRUE(report.complete);
    EXPECT_GT(report.max_command_error, 0.05e-6);
    EXPECT_LT(report.max_command_error, 5.0 * 3e-6 / std::sqrt(201.0));
}

TEST(Accuracy, ReportsCrossesThatAreMissing) {
    Ras3dmRun run;
    run.skip = [](const PlannedPath& path) { return path.face_deg == 180.0 && path.marker == 4; };
    const AccuracyReport report = run.assess();
    EXPECT_FALSE(report.complete);
    EXPECT_EQ(report.faces[2].not_found, (std::vector<int>{4}));
    EXPECT_EQ(report.faces[2].points.size(), 8U);
}

TEST(Accuracy, ReportsAStrokeThatIsMissing) {
    Ras3dmRun run;
    run.skip = [](const PlannedPath& path) {
        return path.face_deg == 0.0 && path.marker == 2 && path.kind == PathKind::cross_vertical;
    };
    const AccuracyReport report = run.assess();
    EXPECT_FALSE(report.complete);
    EXPECT_EQ(report.faces[0].not_found, (std::vector<int>{2}));
}

TEST(Accuracy, ReportsALineThatIsMissing) {
    Ras3dmRun run;
    run.skip = [](const PlannedPath& path) { return path.face_deg == 0.0 && path.kind == PathKind::datum_line; };
    const AccuracyReport report = run.assess();
    EXPECT_FALSE(report.complete);
    EXPECT_EQ(report.lines_missing, 1U);
    EXPECT_EQ(report.lines.size(), 3U);
}

TEST(Accuracy, ReportsCrossesThatNobodyAskedFor) {
    Ras3dmRun run;
    run.also = [](synthetic::Burner& burner) {
        burner.c_deg = 0.0;
        burner.cross({-0.2, -0.32, -0.36});
    };
    const AccuracyReport report = run.assess();
    EXPECT_FALSE(report.complete);
    ASSERT_EQ(report.faces[0].unmatched.size(), 1U);
    EXPECT_NEAR(report.faces[0].unmatched[0].v.x, -0.2, 1e-9);
    EXPECT_EQ(report.faces[0].points.size(), 9U);
}

TEST(Accuracy, DoesNotJudgeWhatIsAmbiguous) {
    Ras3dmRun run;
    const Vec3 marker = run.table.rows[3].measured.v;
    run.also = [marker](synthetic::Burner& burner) {
        burner.c_deg = 0.0;
        burner.cross(marker + Vec3{0.7e-3, 0.0, 0.9e-3});
    };
    const AccuracyReport report = run.assess();
    EXPECT_FALSE(report.complete);
    EXPECT_EQ(report.faces[0].ambiguous, (std::vector<int>{4}));
    EXPECT_EQ(report.faces[0].points.size(), 8U);
}

TEST(Accuracy, OneFaceAloneIsComplete) {
    Ras3dmRun run;
    run.options.face = 180.0;
    const AccuracyReport report = run.assess();
    EXPECT_TRUE(report.complete);
    ASSERT_EQ(report.faces.size(), 1U);
    EXPECT_EQ(report.faces[0].face_deg, 180.0);
}

TEST(Accuracy, BurnsOnAFaceOutsideThePlanAreReported) {
    Ras3dmRun run;
    run.options.face = 180.0;
    run.also = [](synthetic::Burner& burner) {
        burner.c_deg = 0.0;
        burner.cross({-0.2, -0.32, -0.36});
    };
    const AccuracyReport report = run.assess();
    EXPECT_FALSE(report.complete);
    EXPECT_EQ(report.crosses_elsewhere, 1U);
}

TEST(Accuracy, AnotherTruthGivesOtherDeviationsAtOnce) {
    Ras3dmRun run;
    for (TableRow& row : run.table.rows) {
        row.truth.v.x += 0.5e-3;
    }
    const AccuracyReport report = run.assess();
    EXPECT_NEAR(report.faces[0].found.max.x, 0.5e-3 + 0.062e-3, 1e-6);
}

TEST(FaceAngles, AreEachOnceInTheTablesOrder) {
    EXPECT_EQ(face_angles(Ras3dmRun().table), (std::vector<double>{0.0, 90.0, 180.0, 270.0}));
}

}  // namespace
}  // namespace sc::host

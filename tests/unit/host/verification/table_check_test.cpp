// SPDX-License-Identifier: Apache-2.0
#include "host/verification/table_check.hpp"

#include <algorithm>
#include <cmath>
#include <random>

#include <gtest/gtest.h>

#include "host/verification/table_signs.hpp"

namespace sc::host {
namespace {

const std::filesystem::path kData = SC_SOURCE_DIR "/tests/data/ras3dm-table1";

/// What the paper prints, in mm.
std::vector<PrintedMaximum> printed_maxima() {
    const auto of = [](int line, double face, double x, double y, double z) {
        return PrintedMaximum{.line = line, .face_deg = face, .axis = {x / 1e3, y / 1e3, z / 1e3}, .any = {}};
    };
    std::vector<PrintedMaximum> out{of(3, 0.0, 0.077, 0.043, -0.08), of(4, 90.0, 0.100, 0.037, 0.15),
                                    of(5, 180.0, -0.115, 0.039, 0.137), of(6, 270.0, 0.095, 0.044, -0.108)};
    out[0].any = 0.077e-3;
    return out;
}

std::size_t count(const TableAssessment& a, TableFinding finding) {
    return static_cast<std::size_t>(std::ranges::count(a.warnings, finding, &TableWarning::finding));
}
const TableWarning* first(const TableAssessment& a, TableFinding finding) {
    const auto found = std::ranges::find(a.warnings, finding, &TableWarning::finding);
    return found == a.warnings.end() ? nullptr : &*found;
}
void expect_near(const Vec3& v, double x, double y, double z, double within_mm) {
    EXPECT_NEAR(std::abs(1e3 * v.x), x, within_mm);
    EXPECT_NEAR(std::abs(1e3 * v.y), y, within_mm);
    EXPECT_NEAR(std::abs(1e3 * v.z), z, within_mm);
}

struct Row {
    double face;
    Vec3 largest, rms;
    double rms_3d, max_3d;
    Vec3 mean;
    double fit_rms, fit_max;
};

// Worked out beforehand from the printed digits by a script of its own.
TEST(TableCheck, ReproducesTheFiguresOfTheRas3dmTable) {
    const TableAssessment a = assess_table(read_printed_table(kData / "table1.csv"));
    const std::vector<Row> rows{
        {0, {0.077, 0.042, 0.080}, {0.047, 0.026, 0.045}, 0.070, 0.117, {0.0001, 0.022, 0.004}, 0.063, 0.096},
        {90, {0.100, 0.037, 0.150}, {0.064, 0.022, 0.061}, 0.091, 0.166, {0.0000, 0.015, 0.003}, 0.086, 0.182},
        {180, {0.115, 0.054, 0.137}, {0.065, 0.028, 0.065}, 0.096, 0.173, {0.0001, 0.011, 0.000}, 0.069, 0.120},
        {270, {0.095, 0.044, 0.108}, {0.051, 0.027, 0.042}, 0.072, 0.114, {0.0000, 0.023, 0.000}, 0.063, 0.102}};
    ASSERT_EQ(a.faces.size(), rows.size());
    for (std::size_t i = 0; i < rows.size(); ++i) {
        SCOPED_TRACE(rows[i].face);
        const DeviationFigures& f = a.faces[i].figures;
        EXPECT_EQ(a.faces[i].face_deg, rows[i].face);
        EXPECT_EQ(f.points, 9U);
        expect_near(f.largest, rows[i].largest.x, rows[i].largest.y, rows[i].largest.z, 1e-6);
        expect_near(f.rms, rows[i].rms.x, rows[i].rms.y, rows[i].rms.z, 0.51e-3);
        EXPECT_NEAR(1e3 * f.rms_3d, rows[i].rms_3d, 0.6e-3) << "that of the printed dy is 0.0005 larger";
        EXPECT_NEAR(1e3 * f.max_3d, rows[i].max_3d, 0.51e-3);
        EXPECT_NEAR(std::abs(1e3 * f.mean.x), rows[i].mean.x, 0.06e-3);
        EXPECT_NEAR(1e3 * f.mean.y, rows[i].mean.y, 0.51e-3);
        EXPECT_NEAR(std::abs(1e3 * f.mean.z), rows[i].mean.z, 0.51e-3);
        EXPECT_NEAR(1e3 * a.faces[i].after_fit.rms_3d, rows[i].fit_rms, 0.51e-3);
        EXPECT_NEAR(1e3 * a.faces[i].after_fit.max_3d, rows[i].fit_max, 0.51e-3);
    }
    expect_near(a.all.largest, 0.115, 0.054, 0.150, 1e-6);
    expect_near(a.all.rms, 0.057, 0.026, 0.054, 0.51e-3);
    EXPECT_NEAR(1e3 * a.all.rms_3d, 0.083, 0.51e-3);
    EXPECT_NEAR(1e3 * a.all.max_3d, 0.173, 0.51e-3);
    EXPECT_EQ(a.all.max_3d_no, 3);
    EXPECT_NEAR(1e3 * a.all.mean.y, 0.018, 0.51e-3);
    EXPECT_NEAR(1e3 * a.pooled_3d, 0.071, 0.51e-3);
    EXPECT_NEAR(a.removed_by_faces, 0.28, 0.0051);
    ASSERT_TRUE(a.rigid && a.affine);
    EXPECT_NEAR(1e3 * a.rigid->rms_3d, 0.079, 0.51e-3);
    EXPECT_NEAR(a.rigid->removed, 0.09, 0.0051);
    EXPECT_NEAR(a.affine->removed, 0.36, 0.0051);
    EXPECT_NEAR(1e3 * a.in_plane_95, 0.104, 0.51e-3);
    EXPECT_NEAR(1e3 * a.in_plane_sigma, 0.055, 0.51e-3);
}

TEST(TableCheck, NamesWhatIsOddAboutTheRas3dmTable) {
    const TableAssessment a = assess_table(read_printed_table(kData / "table1.csv"), printed_maxima());
    EXPECT_LT(a.zeroed_chance.x, 1e-6) << "all four means within 0.11 um";
    EXPECT_GT(a.zeroed_chance.y, 0.05);
    const TableWarning* zeroed = first(a, TableFinding::zeroed_mean);
    ASSERT_NE(zeroed, nullptr);
    EXPECT_NE(zeroed->text.find("means of dx"), std::string::npos) << zeroed->text;
    ASSERT_EQ(a.grids.size(), 2U);
    EXPECT_EQ(a.grids[0].axis, 'x');
    EXPECT_EQ(a.grids[1].axis, 'z');
    EXPECT_FALSE(a.grids[0].of_truth || a.grids[1].of_truth);
    EXPECT_NEAR(a.grids[0].step, 1e-5, 1e-12);
    EXPECT_NEAR(a.grids[1].step, 1e-5, 1e-12);
    EXPECT_GE(a.grids[0].within + a.grids[1].within, 71U);
    for (const TableFace& face : a.faces) {
        EXPECT_LT(face.plane[1].rms, 0.7e-6) << face.face_deg;
        EXPECT_GT(face.plane[0].rms, 5e-6) << face.face_deg;
        EXPECT_GT(face.plane[1].slope[0], -0.385e-3);
        EXPECT_LT(face.plane[1].slope[0], -0.165e-3);
        EXPECT_GT(face.plane[1].slope[1], -0.355e-3);
        EXPECT_LT(face.plane[1].slope[1], -0.255e-3);
    }
    ASSERT_EQ(count(a, TableFinding::dependent_column), 1U);
    EXPECT_NE(first(a, TableFinding::dependent_column)->text.find("dy is a plane over x, z on 4 of 4"),
              std::string::npos);
    ASSERT_EQ(count(a, TableFinding::arithmetic), 1U);
    EXPECT_EQ(first(a, TableFinding::arithmetic)->lines, (std::vector<int>{2, 20, 22, 24, 27, 28, 30, 34}));
    EXPECT_EQ(count(a, TableFinding::reversed), 0U);
    ASSERT_EQ(count(a, TableFinding::printed_maximum), 2U) << "0.039 for 0.055, and 0.077 for 0.080";
    EXPECT_EQ(first(a, TableFinding::printed_maximum)->lines, std::vector<int>{3});
}

/// Four faces of nine markers with errors of 50 um, to the printed micrometre.
PrintedTable honest(std::uint64_t seed) {
    std::mt19937_64 random(seed);
    std::normal_distribution<double> error(0.0, 50e-6);
    std::uniform_real_distribution<double> place(-0.1, 0.1);
    const auto digits = [](double v) { return std::round(v * 1e6) / 1e6; };
    PrintedTable out;
    for (const double face : {0.0, 90.0, 180.0, 270.0}) {
        for (int no = 1; no <= 9; ++no) {
            const Vec3 t{digits(-0.25 + place(random)), digits(-0.3 + 0.05 * place(random)),
                         digits(-0.35 + place(random))};
            const Vec3 m{digits(t.x + error(random)), digits(t.y + error(random)), digits(t.z + error(random))};
            out.table.rows.push_back({.line = 0, .face_deg = face, .no = no, .measured = {m}, .truth = {t}});
            out.deviations.push_back(m - t);
        }
    }
    return out;
}

TEST(TableCheck, FindsNothingOddInHonestTables) {
    std::size_t odd = 0;
    for (std::uint64_t seed = 1; seed <= 300; ++seed) {
        odd += assess_table(honest(seed)).warnings.empty() ? 0U : 1U;
    }
    EXPECT_LE(odd, 4U) << "each sign is one that chance gives in 1 of 1000 tables at most";
}

TEST(TableCheck, FindsWhatWasDoneToATable) {
    for (std::uint64_t seed = 1; seed <= 20; ++seed) {
        PrintedTable shifted = honest(seed);
        for (std::size_t face = 0; face < 4; ++face) {
            double mean = 0.0;
            for (std::size_t i = 9 * face; i < 9 * face + 9; ++i) {
                mean += (shifted.table.rows[i].measured.v.z - shifted.table.rows[i].truth.v.z) / 9.0;
            }
            for (std::size_t i = 9 * face; i < 9 * face + 9; ++i) {
                shifted.table.rows[i].truth.v.z = std::round((shifted.table.rows[i].truth.v.z + mean) * 1e6) / 1e6;
            }
        }
        const TableAssessment a = assess_table(shifted);
        EXPECT_EQ(count(a, TableFinding::zeroed_mean), 1U) << seed;
        EXPECT_GE(count(a, TableFinding::arithmetic), 1U) << "its printed deviations are the old ones";

        PrintedTable stepped = honest(seed);
        for (TableRow& row : stepped.table.rows) {
            row.truth.v.x = std::round(row.truth.v.x / 2e-5) * 2e-5;
        }
        stepped.deviations.clear();
        const TableAssessment s = assess_table(stepped);
        ASSERT_EQ(s.grids.size(), 1U) << seed;
        EXPECT_TRUE(s.grids[0].of_truth);
        EXPECT_NEAR(s.grids[0].step, 2e-5, 1e-12);
        EXPECT_EQ(s.grids[0].axis, 'x');
    }
}

TEST(TableCheck, NoticesSignsTurnedRoundAndCopies) {
    PrintedTable table = honest(3);
    for (std::size_t i = 0; i < table.deviations.size(); ++i) {
        table.deviations[i] = -table.deviations[i];
        table.table.rows[i].truth.v.y = table.table.rows[i].measured.v.y;
    }
    for (Vec3& d : table.deviations) {
        d.y = 0.0;
    }
    const TableAssessment a = assess_table(table);
    EXPECT_EQ(count(a, TableFinding::reversed), 1U);
    EXPECT_EQ(count(a, TableFinding::arithmetic), 0U);
    EXPECT_EQ(count(a, TableFinding::copied_column), 1U);
}

TEST(TableCheck, JudgesSmallTablesByWhatTheyHold) {
    PrintedTable table = honest(5);
    table.table.rows.resize(2);
    table.deviations.resize(2);
    const TableAssessment a = assess_table(table);
    EXPECT_FALSE(a.rigid);
    EXPECT_EQ(count(a, TableFinding::few_points), 1U);
    EXPECT_EQ(a.faces[0].after_fit.rms_3d, a.faces[0].figures.rms_3d);
    EXPECT_NE(table_svg(table.table, a).find("marker 2"), std::string::npos);
}

TEST(TableSigns, GiveTheChancesOfANormalMean) {
    // Of 101 values with scatter s about a mean of s/10: sigma of the mean is s/10 too.
    EXPECT_NEAR(mean_chance(0.1, std::hypot(1.0, 0.1), 101, 1e-9), 0.6827, 1e-4);
    EXPECT_EQ(mean_chance(0.0, 0.0, 9, 1e-6), 1.0);
    EXPECT_NEAR(joint_chance({0.3}), 0.3, 1e-12);
    EXPECT_NEAR(joint_chance({0.1, 0.1}), 0.01 * (1.0 - std::log(0.01)), 1e-12);
}

}  // namespace
}  // namespace sc::host

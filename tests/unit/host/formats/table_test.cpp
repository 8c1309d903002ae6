// SPDX-License-Identifier: Apache-2.0
#include "host/formats/table.hpp"

#include <algorithm>

#include "host/formats/csv.hpp"
#include "host/formats/points.hpp"
#include "host/formats/text.hpp"
#include "tests/unit/host/formats/support.hpp"

namespace sc::host {
namespace {

using test::expect_refusal;
using test::TempDir;

const std::filesystem::path kExample = SC_SOURCE_DIR "/examples/ras3dm/table1.csv";

void expect_bad(const std::string& text, int line, const std::string& value, const std::string& problem) {
    const TempDir dir;
    const auto path = dir.write("t.csv", text);
    expect_refusal([&] { static_cast<void>(read_table(path)); },
                   {.file = path.string(), .line = line, .value = value, .problem = problem});
}

/// The example with all coordinates of some columns scaled.
std::string scaled(double factor, const std::vector<std::string_view>& columns) {
    const CsvTable csv = CsvTable::read(kExample);
    std::string out = joined(csv.columns(), ",") + "\n";
    for (std::size_t row = 0; row < csv.size(); ++row) {
        std::vector<std::string> fields;
        for (std::size_t i = 0; i < csv.columns().size(); ++i) {
            const bool scale = std::ranges::find(columns, csv.columns()[i]) != columns.end();
            fields.push_back(scale ? fixed(csv.number(row, i) * factor, 6) : csv.text(row, i));
        }
        out += joined(fields, ",") + "\n";
    }
    return out;
}

TEST(ReadTable, ReadsTheExample) {
    const VerificationTable table = read_table(kExample);
    ASSERT_EQ(table.rows.size(), 36U);
    EXPECT_EQ(table.file, kExample);
    const TableRow& row = table.rows[9];
    EXPECT_EQ(row.line, 11);
    EXPECT_EQ(row.face_deg, 90.0);
    EXPECT_EQ(row.no, 1);
    EXPECT_EQ(row.measured.v, (Vec3{-224.815 / 1e3, -285.691 / 1e3, -404.515 / 1e3}));
    EXPECT_EQ(row.truth.v, (Vec3{-224.815 / 1e3, -285.710 / 1e3, -404.505 / 1e3}));
}

TEST(ReadTable, NeedsNoDeviations) {
    const TempDir dir;
    const auto path = dir.write("t.csv", "no,face_deg,mx,my,mz,tx,ty,tz\n3,-90,-300,-300,-300,-300.1,-300.2,-300.3\n");
    const VerificationTable table = read_table(path);
    ASSERT_EQ(table.rows.size(), 1U);
    EXPECT_EQ(table.rows[0].no, 3);
    EXPECT_EQ(table.rows[0].face_deg, -90.0);
}

TEST(ReadTable, RefusesAMissingFile) {
    expect_refusal([] { static_cast<void>(read_table("no/such.csv")); },
                   {.file = "no/such.csv", .problem = "no such file"});
}

TEST(ReadTable, RefusesWhatIsMalformed) {
    const std::string good = test::slurp(kExample);
    expect_bad("", 0, "", "is empty");
    expect_bad("face_deg,no,mx,my,mz,tx,ty,tz\n", 0, "", "no rows");
    expect_bad(test::replaced(good, ",tz,", ",ttz,"), 1, "ttz", "unknown column");
    expect_bad("face_deg,no,mx,my,mz,tx,ty\n0,1,-300,-300,-300,-300,-300\n", 1, "tz", "column is missing");
    expect_bad(test::replaced(good, "-425.944", "abc"), 2, "abc", "column mz is not a number");
    expect_bad(test::replaced(good, "-425.944", "nan"), 2, "nan", "not a finite number");
    expect_bad(test::replaced(good, "-425.944", "\"-425,944\""), 2, "-425,944", "decimal comma");
    expect_bad(test::replaced(good, "\n0,2,", "\n0,1,"), 3, "1", "marker appears twice on face 0");
    expect_bad(test::replaced(good, "\n0,2,", "\n0,2.5,"), 3, "2.5", "column no is not a whole number");
}

TEST(ReadTable, RefusesACommaForThePoint) {
    std::string text = test::slurp(kExample);
    std::ranges::replace(text, '.', ',');
    expect_bad(text, 2, "0,1,-314,090,-319,770,-425,944,-314,128,-319,812,-425,964,0,...", "decimal comma");
}

TEST(ReadTable, RefusesMetresAndInches) {
    const std::vector<std::string_view> all{"mx", "my", "mz", "tx", "ty", "tz"};
    // The largest coordinate of the table stands in line 32: 270/4 mz.
    expect_bad(scaled(1e-3, all), 32, "-0.443935", "look like metres");
    expect_bad(scaled(1.0 / 25.4, all), 32, "-17.477756", "look like inches");
    expect_bad(scaled(1e-3, {"tx", "ty", "tz"}), 32, "-0.443927", "look like metres");
    expect_bad(scaled(1.0 / 25.4, {"mx", "my", "mz"}), 32, "-17.477756", "look like inches");
}

TEST(WriteTable, RoundTripsTheExample) {
    const TempDir dir;
    const VerificationTable table = read_table(kExample);
    write_table(dir / "t.csv", table);
    const VerificationTable again = read_table(dir / "t.csv");
    ASSERT_EQ(again.rows.size(), table.rows.size());
    for (std::size_t i = 0; i < table.rows.size(); ++i) {
        EXPECT_EQ(again.rows[i].face_deg, table.rows[i].face_deg);
        EXPECT_EQ(again.rows[i].no, table.rows[i].no);
        EXPECT_EQ(again.rows[i].measured, table.rows[i].measured);
        EXPECT_EQ(again.rows[i].truth, table.rows[i].truth);
    }
    EXPECT_TRUE(
        test::slurp(dir / "t.csv")
            .starts_with("face_deg,no,mx,my,mz,tx,ty,tz,dx,dy,dz\n"
                         "0,1,-314.0900,-319.7700,-425.9440,-314.1280,-319.8120,-425.9640,0.0380,0.0420,0.0200\n"));
}

TEST(ReadPoints, ReadsAndRoundTrips) {
    const TempDir dir;
    const auto path = dir.write("p.csv", "no,x,y,z\n4,1.5,-2,0.00005\n2,0,0,0\n");
    const FacePoints points = read_points(path);
    ASSERT_EQ(points.points.size(), 2U);
    EXPECT_EQ(points.points[0].no, 4);
    EXPECT_EQ(points.points[0].line, 2);
    EXPECT_EQ(points.points[0].place, (Vec3{1.5e-3, -2e-3, 0.00005 / 1e3}));
    write_points(dir / "q.csv", points);
    const FacePoints again = read_points(dir / "q.csv");
    ASSERT_EQ(again.points.size(), 2U);
    EXPECT_EQ(again.points[1].place, points.points[1].place);
    EXPECT_NEAR(again.points[0].place.z, 0.0001 / 1e3, 1e-7);
}

TEST(ReadPoints, RefusesWhatIsMalformed) {
    const TempDir dir;
    const auto bad = [&dir](const std::string& text, int line, const std::string& value, const std::string& problem) {
        const auto path = dir.write("p.csv", text);
        expect_refusal([&] { static_cast<void>(read_points(path)); },
                       {.file = path.string(), .line = line, .value = value, .problem = problem});
    };
    bad("no,x,y\n1,2,3\n", 1, "z", "column is missing");
    bad("no,x,y,z,frame\n", 1, "frame", "unknown column");
    bad("no,x,y,z\n", 0, "", "no rows");
    bad("no,x,y,z\n1,0,0,0\n1,0,0,1\n", 3, "1", "point number appears twice");
    bad("no,x,y,z\n1,0,inf,0\n", 2, "inf", "not a finite number");
}

}  // namespace
}  // namespace sc::host

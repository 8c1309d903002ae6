// SPDX-License-Identifier: Apache-2.0
#include "host/formats/scan.hpp"

#include <cstring>
#include <limits>

#include "host/formats/pcd.hpp"
#include "tests/unit/host/formats/support.hpp"

namespace sc::host {
namespace {

using test::expect_refusal;
using test::TempDir;

const std::vector<Vec3> kPlaces{{1e-3, 2e-3, 3e-3}, {-4e-3, 5.5e-3, 0.0}};

void expect_places(const ScanFile& scan) {
    ASSERT_EQ(scan.cloud.points.size(), 2U);
    for (std::size_t i = 0; i < 2; ++i) {
        EXPECT_LT(norm(scan.cloud.points[i] - kPlaces[i]), 1e-12) << i;
    }
}

void put(std::string& out, const auto& value) {
    std::string raw(sizeof(value), '\0');
    std::memcpy(raw.data(), &value, sizeof(value));
    out += raw;
}

TEST(ScanFile, ReadsTextHoweverItIsSeparated) {
    const TempDir dir;
    expect_places(read_scan(dir.write("a.xyz", "1 2 3\n-4 5.5 0\n")));
    expect_places(read_scan(dir.write("b.asc", "# cloud\n\n1\t2\t3\t255\n-4 5.5 0 17\n")));
    expect_places(read_scan(dir.write("c.csv", "x,y,z\n1,2,3\n-4,5.5,0\n")));
    expect_places(read_scan(dir.write("d.csv", "id;\"Z\";\"Y\";\"X\"\r\n7;3;2;1\r\n8;0;5.5;-4\r\n")));
    expect_places(read_scan(dir.write("e.asc", "//X Y Z\n2\n1 2 3\n-4 5.5 0")));
    expect_places(read_scan(dir.write("f.txt", "1e0 +2.0 3\n-4 5.5 0\n"), *length_unit("mm")));
    expect_places(read_scan(dir.write("g.xyz", "0.001 0.002 0.003\n-.004 .0055 0\n"), *length_unit("m")));
}

TEST(ScanFile, ReadsPlyWithViewsAndLeavesOutWhatIsNotFinite) {
    const TempDir dir;
    const ScanFile scan = read_scan(
        dir.write("a.ply",
                  "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
                  "property int view\nend_header\n1 2 3 0\nnan nan nan 0\n-4 5.5 0 1\n"));
    expect_places(scan);
    EXPECT_EQ(scan.not_finite, 1U);
    EXPECT_EQ(scan.cloud.view, (std::vector<std::uint32_t>{0, 1}));
    write_ply(dir / "b.ply", scan.cloud);
    const ScanFile again = read_scan(dir / "b.ply");
    ASSERT_EQ(again.cloud.points.size(), 2U);
    EXPECT_LT(norm(again.cloud.points[1] - kPlaces[1]), 1e-9);
    EXPECT_EQ(again.cloud.view, scan.cloud.view);
}

std::string pcd_header(const char* data) {
    return std::string(
               "# .PCD v0.7\nVERSION 0.7\nFIELDS rgb x y z\nSIZE 4 4 4 4\nTYPE U F F F\nCOUNT 1 1 1 1\n"
               "WIDTH 3\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS 3\nDATA ") +
           data + "\n";
}

TEST(ScanFile, ReadsPcdInAllThreeForms) {
    const TempDir dir;
    const float nan = std::numeric_limits<float>::quiet_NaN();
    const float rows[3][3] = {{1.0F, 2.0F, 3.0F}, {nan, nan, nan}, {-4.0F, 5.5F, 0.0F}};
    const ScanFile ascii = read_scan(dir.write("a.pcd", pcd_header("ascii") + "9 1 2 3\n9 nan nan nan\n9 -4 5.5 0\n"));
    expect_places(ascii);
    EXPECT_EQ(ascii.not_finite, 1U);

    std::string binary = pcd_header("binary");
    std::string columns;
    for (const auto& row : rows) {
        put(binary, std::uint32_t{9});
        put(columns, std::uint32_t{9});
        for (const float v : row) {
            put(binary, v);
        }
    }
    expect_places(read_scan(dir.write("b.pcd", binary)));
    for (std::size_t axis = 0; axis < 3; ++axis) {
        for (const auto& row : rows) {
            put(columns, row[axis]);
        }
    }
    // LZF by hand: 4 literal bytes, a copy of 8 bytes from 4 back (so it overlaps itself), then literals.
    std::string packed = std::string("\x03", 1) + columns.substr(0, 4) + std::string("\xc0\x03", 2);
    for (std::size_t at = 12; at < columns.size(); at += 32) {
        const std::string piece = columns.substr(at, 32);
        packed += static_cast<char>(piece.size() - 1);
        packed += piece;
    }
    ASSERT_EQ(unpacked_lzf(packed, columns.size()), columns);
    std::string compressed = pcd_header("binary_compressed");
    put(compressed, static_cast<std::uint32_t>(packed.size()));
    put(compressed, static_cast<std::uint32_t>(columns.size()));
    expect_places(read_scan(dir.write("c.pcd", compressed + packed)));
    EXPECT_THROW(static_cast<void>(read_scan(dir.write("d.pcd", compressed + packed.substr(4)))), InputError);
    EXPECT_THROW(static_cast<void>(read_scan(dir.write("e.pcd", binary.substr(0, binary.size() - 1)))), InputError);
}

TEST(Lzf, RefusesWhatPointsBeforeItsStart) {
    EXPECT_TRUE(unpacked_lzf(std::string("\x20\x05", 2), 3).empty());
    EXPECT_TRUE(unpacked_lzf(std::string("\x05"
                                         "ab",
                                         3),
                             6)
                    .empty());
    EXPECT_TRUE(unpacked_lzf(std::string("\x00"
                                         "a\xe0",
                                         3),
                             10)
                    .empty());
}

TEST(ScanFile, RefusesWithFileLineAndValue) {
    const TempDir dir;
    const auto text = dir.write("a.xyz", "1 2 3\n4 five 6\n");
    expect_refusal([&] { static_cast<void>(read_scan(text)); }, {text.string(), 2, "five", "not a number"});
    const auto few = dir.write("b.xyz", "1 2 3\n4 5\n");
    expect_refusal([&] { static_cast<void>(read_scan(few)); }, {few.string(), 2, "4 5", "fewer than three"});
    const auto names = dir.write("c.csv", "x,y,depth\n1,2,3\n");
    expect_refusal([&] { static_cast<void>(read_scan(names)); }, {names.string(), 1, "x", "lacks one of x, y, z"});
    const auto none = dir.write("d.xyz", "# nothing\n");
    expect_refusal([&] { static_cast<void>(read_scan(none)); }, {none.string(), 0, "", "has no point"});
    const auto nan = dir.write("e.xyz", "nan nan nan\n");
    expect_refusal([&] { static_cast<void>(read_scan(nan)); },
                   {nan.string(), 0, "all 1 are NaN or infinite", "no finite point"});
    const auto binary = dir.write("f.bin", std::string("\x01\x00\x02", 3));
    expect_refusal([&] { static_cast<void>(read_scan(binary)); }, {binary.string(), 0, ".bin", "no cloud"});
    const auto header =
        dir.write("g.ply", "ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\nend_header\n1\n");
    expect_refusal([&] { static_cast<void>(read_scan(header)); }, {header.string(), 3, "", "lacks x, y or z"});
    EXPECT_THROW(static_cast<void>(read_scan(dir / "missing.xyz")), InputError);
}

TEST(ScanFile, ReadsTheScanOfTheCasting) {
    const ScanFile scan = read_scan(std::filesystem::path(SC_TEST_DATA) / "casting-blank" / "scan.ply");
    EXPECT_EQ(scan.cloud.points.size(), 600000U);
    EXPECT_EQ(scan.not_finite, 0U);
}

}  // namespace
}  // namespace sc::host

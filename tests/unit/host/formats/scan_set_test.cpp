// SPDX-License-Identifier: Apache-2.0
#include "host/formats/scan_set.hpp"

#include "tests/unit/host/formats/support.hpp"

namespace sc::host {
namespace {

using test::expect_refusal;
using test::TempDir;

/// Two views: the flange stands a quarter turn about z and 1 m along x; once as b_from_f, once as its inverse.
constexpr std::string_view kText = R"(format = "scribecell-scan-set"
version = 1
id = "s1"
time = "2026-01-15T09:30:00Z"
[[view]]
id = "v1"
c_deg = -90.0
cloud = "clouds/v1.ply"
[view.robot_pose]
convention = "b_from_f"
rotation = [[0, -1, 0], [1, 0, 0], [0, 0, 1]]
translation_mm = [1000, 0, 0]
[[view.marker]]
id = 7
place_mm = [1.5, -2.5, 600.25]
sigma_um = 12.5
[[view]]
id = "v2"
c_deg = 0
[view.robot_pose]
convention = "f_from_b"
rotation = [[0, 1, 0], [-1, 0, 0], [0, 0, 1]]
translation_mm = [0, 1000, 0]
[[view.marker]]
id = 7
place_mm = [0, 0, 600]
sigma_um = 0
)";

TEST(ScanSet, HoldsEveryPoseAsBFromF) {
    const TempDir dir;
    const ScanSet set = read_scan_set(dir.write("s.toml", kText));
    ASSERT_EQ(set.views.size(), 2U);
    ASSERT_TRUE(set.views[0].b_from_f && set.views[1].b_from_f);
    const Point<frame::F> p{{0.25, 0.5, 0.75}};
    EXPECT_EQ((*set.views[0].b_from_f * p).v, (Vec3{0.5, 0.25, 0.75}));
    EXPECT_EQ((*set.views[1].b_from_f * p).v, (*set.views[0].b_from_f * p).v);
    EXPECT_EQ(set.views[0].c_deg, -90.0);
    EXPECT_EQ(set.views[0].cloud, dir / "clouds/v1.ply");
    EXPECT_EQ(set.views[0].markers[0], (ScanMarker{7, {1.5e-3, -2.5e-3, 0.60025}, 12.5e-6}));
}

TEST(ScanSet, RoundTrips) {
    const TempDir dir;
    const ScanSet set = read_scan_set(dir.write("s.toml", kText));
    write_scan_set(dir / "t.toml", set);
    const ScanSet again = read_scan_set(dir / "t.toml");
    EXPECT_EQ(again.id, set.id);
    EXPECT_EQ(again.time, set.time);
    ASSERT_EQ(again.views.size(), set.views.size());
    for (std::size_t i = 0; i < set.views.size(); ++i) {
        EXPECT_EQ(again.views[i].id, set.views[i].id);
        EXPECT_EQ(again.views[i].b_from_f, set.views[i].b_from_f);
        EXPECT_EQ(again.views[i].c_deg, set.views[i].c_deg);
        EXPECT_EQ(again.views[i].markers, set.views[i].markers);
        EXPECT_EQ(again.views[i].cloud, set.views[i].cloud);
    }
}

TEST(ScanSet, RefusesWhatIsMalformed) {
    const TempDir dir;
    const auto bad = [&](const std::string& from, const std::string& to, int line, const std::string& value,
                         const std::string& problem) {
        const auto path = dir.write("bad.toml", test::replaced(std::string(kText), from, to));
        expect_refusal([&] { static_cast<void>(read_scan_set(path)); },
                       {.file = path.string(), .line = line, .value = value, .problem = problem});
    };
    bad("\"f_from_b\"", "\"flange\"", 21, "flange", "unknown value");
    bad("[[0, 1, 0], [-1, 0, 0]", "[[0, 1, 0], [1, 0, 0]", 22, "-1", "left-handed");
    bad("\"v2\"", "\"v1\"", 18, "v1", "appears twice");
    bad("c_deg = 0\n", "c_deg = nan\n", 19, "nan", "not a finite number");
    bad("[[view.marker]]\nid = 7\nplace_mm = [0, 0, 600]\nsigma_um = 0\n", "", 18, "v2", "neither markers nor a cloud");
    bad("sigma_um = 12.5\n", "sigma_um = 12.5\n[[view.marker]]\nid=7\nplace_mm=[0,0,0]\nsigma_um=1\n", 18, "7",
        "appears twice in a view");
    bad("id = 7", "id = -1", 14, "-1", "out of range");
}

}  // namespace
}  // namespace sc::host

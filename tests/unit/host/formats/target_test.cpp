// SPDX-License-Identifier: Apache-2.0
#include "host/formats/target.hpp"

#include "tests/unit/host/formats/support.hpp"

namespace sc::host {
namespace {

using test::expect_refusal;
using test::TempDir;

Target sample() {
    return {
        .id = "mobile-1",
        .kind = TargetKind::mobile,
        .certificate = "no. 4711, 2025",
        .markers = {{1, {0.0, 0.0, 0.0}, 0.0}, {2, {0.04, 5.01e-3, -0.0125}, 1.5e-6}, {9, {0.08, 0.01502, 0.02}, 2e-6}},
        .steps = {{1, 0.0, 5e-7, {1}}, {2, 5.01e-3, 5e-7, {2}}, {3, 0.01502, 5e-7, {9}}}};
}

TEST(Target, RoundTrips) {
    const TempDir dir;
    write_target(dir / "t.toml", sample());
    EXPECT_EQ(read_target(dir / "t.toml"), sample());
    Target fixed = sample();
    fixed.kind = TargetKind::fixed;
    fixed.steps.clear();
    fixed.certificate.clear();
    write_target(dir / "t.toml", fixed);
    EXPECT_EQ(read_target(dir / "t.toml"), fixed);
}

TEST(Target, RefusesWhatIsMalformed) {
    const TempDir dir;
    write_target(dir / "t.toml", sample());
    const std::string good = test::slurp(dir / "t.toml");
    const auto bad = [&](const std::string& from, const std::string& to, const std::string& value,
                         const std::string& problem) {
        const std::string text = test::replaced(good, from, to);
        const auto path = dir.write("bad.toml", text);
        expect_refusal([&] { static_cast<void>(read_target(path)); },
                       {.file = path.string(), .line = test::line_with(text, to), .value = value, .problem = problem});
    };
    bad("markers = [9]", "markers = [3]", "3", "names a marker that the target does not have");
    bad("markers = [9]", "markers = [9999999999]", "9999999999", "names a marker");
    bad("markers = [9]", "markers = [9.0]", "9", "not a whole number");
    bad("id = 9", "id = 2 ", "2", "appears twice");
    bad("kind = \"mobile\"", "kind = \"round\"", "round", "unknown value");
    bad("place_mm = [0.0, 0.0, 0.0]", "place_mm = [0.0, 0.0]", "2", "wrong number of values");
}

}  // namespace
}  // namespace sc::host

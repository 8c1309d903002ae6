// SPDX-License-Identifier: Apache-2.0
#include "host/formats/part.hpp"

#include "tests/unit/host/formats/support.hpp"

namespace sc::host {
namespace {

using test::expect_refusal;
using test::TempDir;

Part sample() {
    MachinedFeature bore{.id = "fronthole",
                         .kind = FeatureKind::bore,
                         .point = {{0.0, 0.029, 0.0225}},
                         .direction = {{0.0, 0.0, 1.0}},
                         .axis_point = {{0.0, 0.0, 0.0425}},
                         .diameter = 0.058,
                         .depth = 0.075,
                         .min_allowance = 5e-4};
    MachinedFeature plane{.id = "frontface",
                          .kind = FeatureKind::plane,
                          .point = {{0.0, 0.032, 0.0425}},
                          .direction = {{0.6, 0.0, 0.8}},
                          .axis_point = {},
                          .diameter = 0.0,
                          .depth = 0.0,
                          .min_allowance = 5e-4};
    return {.id = "blank",
            .note = "",
            .machined = {bore, plane},
            .datums = {{"A", {{0.0, 0.0, 0.0425}}, {{0.0, 1.0, 0.0}}, "contains the main bore's axis"}},
            .reference_points = {{"P1", 1, {{-0.025, -0.04, 0.0365}}, {{0.0, -1.0, 0.0}}}},
            .as_cast = AsCastBand{2.5e-4, 1e-3}};
}

TEST(Part, RoundTrips) {
    const TempDir dir;
    write_part(dir / "p.toml", sample());
    EXPECT_EQ(read_part(dir / "p.toml"), sample());
}

TEST(Part, RefusesWhatIsMalformed) {
    const TempDir dir;
    write_part(dir / "p.toml", sample());
    const std::string good = test::slurp(dir / "p.toml");
    const auto bad = [&](const std::string& from, const std::string& to, const std::string& value,
                         const std::string& problem) {
        const std::string text = test::replaced(good, from, to);
        const auto path = dir.write("bad.toml", text);
        expect_refusal([&] { static_cast<void>(read_part(path)); },
                       {.file = path.string(), .line = test::line_with(text, to), .value = value, .problem = problem});
    };
    bad("kind = \"plane\"", "kind = \"sphere\"", "sphere", "unknown value");
    bad("normal = [0.6, 0.0, 0.8]", "normal = [0.6, 0.0, 0.9]", "1.082", "no unit vector");
    bad("id = \"A\"", "id = \"fronthole\" ", "fronthole", "appears twice");
    bad("level = 1", "level = 4", "4", "out of range");
    bad("diameter_mm = 58.0", "diameter_mm = 0.0", "0.0", "out of range");
    bad("min_allowance_mm = 0.5", "min_allowance_mm = -0.5", "-0.5", "out of range");
    bad("[as_cast]", "[as_forged]", "as_forged", "unknown key");
}

TEST(PlainPart, ReadsTheMachiningDescriptionOfTheCasting) {
    const std::filesystem::path data = std::filesystem::path(SC_TEST_DATA) / "casting-blank";
    const Part part = read_part(data / "part.toml");
    ASSERT_EQ(part.machined.size(), 12U);
    EXPECT_EQ(part.datums.size(), 3U);
    EXPECT_EQ(part.reference_points.size(), 6U);
    EXPECT_DOUBLE_EQ(part.machined[0].diameter, 0.058);
    EXPECT_DOUBLE_EQ(part.machined[0].min_allowance, 0.5e-3);
    EXPECT_EQ(part.machined[11].id, "backface2");
    EXPECT_DOUBLE_EQ(part.machined[11].min_allowance, 0.2e-3);
    const TempDir dir;
    write_part(dir / "part.toml", part);
    EXPECT_EQ(read_part(dir / "part.toml"), part) << "written as a part, it is the same";
}

TEST(PlainPart, TakesItsUnitAndRefusesUnknownWords) {
    const TempDir dir;
    const std::string text =
        "units = \"inch\"\n[[machined]]\nid = \"a\"\nkind = \"plane\"\npoint = [1, 0, 0]\nnormal = [1, 0, 0]\n"
        "min_allowance = 0.1\n";
    EXPECT_DOUBLE_EQ(read_part(dir.write("a.toml", text)).machined[0].point.v.x, 0.0254);
    const auto unit = dir.write("b.toml", test::replaced(text, "inch", "ell"));
    expect_refusal([&] { static_cast<void>(read_part(unit)); }, {unit.string(), 1, "ell", "no unit of length"});
    const auto key = dir.write("c.toml", test::replaced(text, "min_allowance", "minimum"));
    EXPECT_THROW(static_cast<void>(read_part(key)), InputError);
}

}  // namespace
}  // namespace sc::host

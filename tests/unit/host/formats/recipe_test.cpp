// SPDX-License-Identifier: Apache-2.0
#include "host/formats/recipe.hpp"

#include "tests/unit/host/formats/support.hpp"

namespace sc::host {
namespace {

using test::expect_refusal;
using test::TempDir;

Recipe sample() {
    MarkSettings deep;
    deep.actuator = Actuator::galvo;
    deep.speed = Speed::from_si(0.25);
    deep.pitch = Length::from_si(20.0 / 1e6);
    deep.energy = Energy::from_si(312.5 / 1e6);
    deep.passes = 3;
    deep.tolerance = Length::from_si(2.5 / 1e6);
    MarkSettings fine = deep;
    fine.actuator = Actuator::axes;
    fine.passes = 1;
    fine.pulse_width_ns = 20;
    MarkSettings seen = fine;
    seen.width = Length::from_si(160.0 / 1e6);
    seen.fill = Fill::wobble;
    seen.fill_step = Length::from_si(80.0 / 1e6);
    seen.fluence_tolerance = 0.1;
    return {.name = "grey iron \"as cast\"",
            .material = "EN-GJL-250",
            .note = "two\nlines and a \\ and a \x01",
            .entries = {{"deep", deep}, {"fine", fine}, {"seen", seen}}};
}

TEST(Recipe, RoundTrips) {
    const TempDir dir;
    write_recipe(dir / "r.toml", sample());
    EXPECT_EQ(read_recipe(dir / "r.toml"), sample());
}

TEST(Recipe, RefusesWhatIsMalformed) {
    const TempDir dir;
    write_recipe(dir / "r.toml", sample());
    const std::string good = test::slurp(dir / "r.toml");
    const auto bad = [&](const std::string& from, const std::string& to, const std::string& value,
                         const std::string& problem) {
        const std::string text = test::replaced(good, from, to);
        const auto path = dir.write("bad.toml", text);
        expect_refusal([&] { static_cast<void>(read_recipe(path)); },
                       {.file = path.string(), .line = test::line_with(text, to), .value = value, .problem = problem});
    };
    bad("id = \"fine\"", "id = \"deep\" ", "deep", "appears twice");
    bad("pitch_um = 20.0", "pitch_um = 0.0", "0.0", "out of range");
    bad("energy_uj = 312.5", "energy_uj = true", "true", "not a number");
    bad("pulse_width_ns = 20", "pulse_width_ns = 1000", "1000", "out of range");
    bad("width_um = 160.0\nfill = \"wobble\"", "fill = \"wobble\"", "fill", "is given for a line of one stroke");
    bad("fill = \"wobble\"", "fill = \"zigzag\"", "zigzag", "has an unknown value");
    bad("fill_step_um = 80.0", "fill_step_um = 0.5", "0.5", "out of range");
    bad("fluence_tolerance_pct = 10.0", "fluence_tolerance_pct = 95.0", "95.0", "out of range");
    bad("material = ", "metal = \"x\"\nmaterial = ", "metal", "unknown key");
}

TEST(Recipe, TheExampleIsSound) {
    const Recipe recipe = read_recipe(SC_SOURCE_DIR "/examples/casting/recipe.toml");
    ASSERT_NE(find_entry(recipe, "seen"), nullptr);
    EXPECT_GT(find_entry(recipe, "seen")->settings.width.si(), 0.0);
    EXPECT_EQ(find_entry(recipe, "none"), nullptr);
    EXPECT_EQ(entry_ids(recipe), "fine, seen, rough");
}

}  // namespace
}  // namespace sc::host

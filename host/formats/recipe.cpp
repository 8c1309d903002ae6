// SPDX-License-Identifier: Apache-2.0
#include "host/formats/recipe.hpp"

#include <array>
#include <set>

#include "host/formats/file.hpp"
#include "host/formats/mark_settings.hpp"
#include "host/formats/text.hpp"

namespace sc::host {

namespace {

constexpr std::string_view kFormat = "scribecell-recipe";
// What a speed, pitch or energy can be at all; what the cell at hand can do is checked against its configuration.
constexpr Limits kSpeedMmS{0.1, 20'000.0};
constexpr Limits kPitchUm{0.1, 10'000.0};
constexpr Limits kEnergyUj{0.001, 1'000'000.0};
constexpr Limits kToleranceUm{0.0, 1000.0};

Recipe parse_recipe(const std::filesystem::path& path, std::string_view text) {
    TomlDocument document(path, text, kFormat);
    TomlReader& root = document.root();
    Recipe recipe{
        .name = root.text("name"), .material = root.text("material"), .note = root.text_or("note", ""), .entries = {}};
    std::set<std::string> seen;
    for (TomlReader& table : root.tables("entry")) {
        RecipeEntry entry{.id = table.text("id"), .settings = read_mark_settings(table)};
        if (!seen.insert(entry.id).second) {
            table.fail("id", "appears twice", shortened(entry.id), "give every entry an id of its own");
        }
        table.finish();
        recipe.entries.push_back(std::move(entry));
    }
    root.finish();
    return recipe;
}

}  // namespace

MarkSettings read_mark_settings(TomlReader& table) {
    MarkSettings out;
    constexpr std::array kActuators{Actuator::axes, Actuator::galvo, Actuator::split};
    out.actuator = kActuators.at(table.choice("actuator", {"axes", "galvo", "split"}));
    out.speed = Speed::from_si(table.number("speed_mm_s", kSpeedMmS) / 1e3);
    out.pitch = Length::from_si(table.number("pitch_um", kPitchUm) / 1e6);
    out.energy = Energy::from_si(table.number("energy_uj", kEnergyUj) / 1e6);
    out.passes = static_cast<std::uint8_t>(table.integer_or("passes", 1, 1, 255));
    out.tolerance = Length::from_si(table.number_or("tolerance_um", 5.0, kToleranceUm) / 1e6);
    out.pulse_width_ns = static_cast<std::uint16_t>(table.integer_or("pulse_width_ns", 0, 0, 999));
    return out;
}

void write_mark_settings(TomlWriter& out, const MarkSettings& settings) {
    constexpr std::array<std::string_view, 3> kNames{"axes", "galvo", "split"};
    out.text("actuator", kNames.at(static_cast<std::size_t>(settings.actuator)));
    out.number("speed_mm_s", settings.speed.si(), 1e3);
    out.number("pitch_um", settings.pitch.si(), 1e6);
    out.number("energy_uj", settings.energy.si(), 1e6);
    out.integer("passes", settings.passes);
    out.number("tolerance_um", settings.tolerance.si(), 1e6);
    if (settings.pulse_width_ns != 0) {
        out.integer("pulse_width_ns", settings.pulse_width_ns);
    }
}

Recipe read_recipe(const std::filesystem::path& path) { return parse_recipe(path, read_text_file(path)); }

void write_recipe(const std::filesystem::path& path, const Recipe& recipe) {
    TomlWriter out(kFormat);
    out.text("name", recipe.name);
    out.text("material", recipe.material);
    out.text_unless_empty("note", recipe.note);
    for (const RecipeEntry& entry : recipe.entries) {
        out.item("entry");
        out.text("id", entry.id);
        write_mark_settings(out, entry.settings);
    }
    static_cast<void>(parse_recipe(path, out.str()));  // what would be refused is not written
    write_text_file(path, out.str());
}

}  // namespace sc::host

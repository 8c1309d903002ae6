// SPDX-License-Identifier: Apache-2.0
#include "host/formats/recipe.hpp"

#include <algorithm>
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
constexpr Limits kWidthUm{0.0, 10'000.0};
constexpr Limits kFillStepUm{1.0, 10'000.0};
constexpr Limits kFluencePct{1.0, 90.0};

/// `base`: what holds for keys that are absent; null: the defaults, and actuator, speed, pitch and energy must be
/// there.
MarkSettings read_settings(TomlReader& table, const MarkSettings* base) {
    const MarkSettings given = base != nullptr ? *base : MarkSettings{};
    const auto needed = [&](std::string_view key) { return base == nullptr || table.has(key); };
    MarkSettings out = given;
    if (needed("actuator")) {
        constexpr std::array kActuators{Actuator::axes, Actuator::galvo, Actuator::split};
        out.actuator = kActuators.at(table.choice("actuator", {"axes", "galvo", "split"}));
    }
    if (needed("speed_mm_s")) {
        out.speed = Speed::from_si(table.number("speed_mm_s", kSpeedMmS) / 1e3);
    }
    if (needed("pitch_um")) {
        out.pitch = Length::from_si(table.number("pitch_um", kPitchUm) / 1e6);
    }
    if (needed("energy_uj")) {
        out.energy = Energy::from_si(table.number("energy_uj", kEnergyUj) / 1e6);
    }
    out.passes = static_cast<std::uint8_t>(table.integer_or("passes", given.passes, 1, 255));
    if (table.has("tolerance_um")) {
        out.tolerance = Length::from_si(table.number("tolerance_um", kToleranceUm) / 1e6);
    }
    out.pulse_width_ns = static_cast<std::uint16_t>(table.integer_or("pulse_width_ns", given.pulse_width_ns, 0, 999));
    if (table.has("fluence_tolerance_pct")) {
        out.fluence_tolerance = table.number("fluence_tolerance_pct", kFluencePct) / 100.0;
    }
    if (table.has("width_um")) {
        out.width = Length::from_si(table.number("width_um", kWidthUm) / 1e6);
    }
    const bool wide = out.width.si() > 0.0;
    for (const std::string_view key : {"fill", "fill_step_um"}) {
        if (!wide && table.has(key)) {
            table.fail(key, "is given for a line of one stroke", std::string(key), "add width_um, or take it out");
        }
    }
    if (wide && (given.width.si() <= 0.0 || table.has("fill"))) {
        out.fill = table.choice("fill", {"hatch", "wobble"}) == 0 ? Fill::hatch : Fill::wobble;
    }
    if (wide && (given.width.si() <= 0.0 || table.has("fill_step_um"))) {
        out.fill_step = Length::from_si(table.number("fill_step_um", kFillStepUm) / 1e6);
    }
    return out;
}

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

MarkSettings read_mark_settings(TomlReader& table) { return read_settings(table, nullptr); }

MarkSettings read_mark_settings(TomlReader& table, const Recipe* recipe) {
    if (!table.has("entry")) {
        return read_settings(table, nullptr);
    }
    const std::string id = table.text("entry");
    if (recipe == nullptr) {
        table.fail("entry", "names an entry, but the job has no recipe", shortened(id),
                   "add recipe = \"FILE.toml\" to the job, or give the settings here");
    }
    const RecipeEntry* entry = find_entry(*recipe, id);
    if (entry == nullptr) {
        table.fail("entry", "is not in the recipe", shortened(id), "choose one of: " + entry_ids(*recipe));
    }
    return read_settings(table, &entry->settings);
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
    if (settings.width.si() > 0.0) {
        out.number("width_um", settings.width.si(), 1e6);
        out.text("fill", settings.fill == Fill::hatch ? "hatch" : "wobble");
        out.number("fill_step_um", settings.fill_step.si(), 1e6);
    }
    if (settings.fluence_tolerance != MarkSettings{}.fluence_tolerance) {
        out.number("fluence_tolerance_pct", settings.fluence_tolerance, 1e2);
    }
}

const RecipeEntry* find_entry(const Recipe& recipe, std::string_view id) noexcept {
    const auto entry = std::ranges::find(recipe.entries, id, &RecipeEntry::id);
    return entry == recipe.entries.end() ? nullptr : &*entry;
}

std::string entry_ids(const Recipe& recipe) {
    std::string ids;
    for (const RecipeEntry& entry : recipe.entries) {
        ids += (ids.empty() ? "" : ", ") + shortened(entry.id);
    }
    return ids;
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

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "shared/path/item.hpp"
#include "shared/units/quantity.hpp"

namespace sc::host {

/// How a line that is wider than the spot is filled (host/path/line_width.hpp).
enum class Fill : std::uint8_t { hatch, wobble };

/// How a line is burnt.
struct MarkSettings {
    Actuator actuator = Actuator::axes;
    Speed speed;    ///< along the path
    Length pitch;   ///< between pulses
    Energy energy;  ///< of one pulse
    std::uint8_t passes = 1;
    Length tolerance = Length::from_si(5e-6);  ///< how far the beam may leave the points at corners
    std::uint16_t pulse_width_ns = 0;          ///< of a MOPA source; 0: as it is
    Length width{};                            ///< between a wide line's outermost strokes; 0: one stroke
    Fill fill = Fill::hatch;                   ///< of a wide line
    Length fill_step{};                        ///< hatch: between strokes, at most; wobble: along the line, each turn
    double fluence_tolerance = 0.2;            ///< share of the peak fluence in focus that a pulse may lack off focus
    constexpr bool operator==(const MarkSettings&) const noexcept = default;
};

/// Laser recipe: named settings that suit one material. File: format = "scribecell-recipe", version = 1.
struct RecipeEntry {
    std::string id;
    MarkSettings settings;
    bool operator==(const RecipeEntry&) const = default;
};
struct Recipe {
    std::string name;
    std::string material;
    std::string note;
    std::vector<RecipeEntry> entries;  ///< ids are unique
    bool operator==(const Recipe&) const = default;
};

/// Null if there is none of that id.
[[nodiscard]] const RecipeEntry* find_entry(const Recipe& recipe, std::string_view id) noexcept;
/// Ids, separated by commas.
[[nodiscard]] std::string entry_ids(const Recipe& recipe);

/// Both throw InputError (file, line, value, what to do).
[[nodiscard]] Recipe read_recipe(const std::filesystem::path& path);
void write_recipe(const std::filesystem::path& path, const Recipe& recipe);

}  // namespace sc::host

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "host/formats/recipe.hpp"
#include "host/formats/toml_reader.hpp"
#include "host/formats/toml_writer.hpp"

namespace sc::host {

/// The keys actuator, speed_mm_s, pitch_um, energy_uj, passes (1), tolerance_um (5), pulse_width_ns (0), width_um (0)
/// with fill and fill_step_um, fluence_tolerance_pct (20) of a table.
[[nodiscard]] MarkSettings read_mark_settings(TomlReader& table);
/// The same of a table of a job, where the key `entry` names settings of the recipe, which the table's own keys
/// replace. `recipe` may be null.
[[nodiscard]] MarkSettings read_mark_settings(TomlReader& table, const Recipe* recipe);
void write_mark_settings(TomlWriter& out, const MarkSettings& settings);

}  // namespace sc::host

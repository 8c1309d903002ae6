// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "host/formats/recipe.hpp"
#include "host/formats/toml_reader.hpp"
#include "host/formats/toml_writer.hpp"

namespace sc::host {

/// The keys actuator, speed_mm_s, pitch_um, energy_uj, passes (1), tolerance_um (5), pulse_width_ns (0) of a
/// table.
[[nodiscard]] MarkSettings read_mark_settings(TomlReader& table);
void write_mark_settings(TomlWriter& out, const MarkSettings& settings);

}  // namespace sc::host

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "shared/machine/machine.hpp"

namespace sc::sim {

/// What is the matter with the simulated source.
enum class SourceTrouble : std::uint8_t {
    none,
    warning,
    starting,
    back_reflection,
    temperature,
    main_supply,
    housekeeping,
    system,
    strange,  ///< a code that no table has
};

/// How the source of a maker shows it on its pins 11, 12, 16 and 21 (bits 0 to 3). Written down apart from the
/// controller's table, so that a slip in either shows.
[[nodiscard]] std::uint8_t source_pins(LaserSource source, SourceTrouble trouble) noexcept;

}  // namespace sc::sim

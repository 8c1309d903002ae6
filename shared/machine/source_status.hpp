// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>

#include "shared/codes/codes.hpp"
#include "shared/machine/machine.hpp"

/// What the four status pins of a type-D source say. Each maker has a table of its own: they give normal, back
/// reflection, temperature and supply on pins 16 and 21, and differ in what pins 11 and 12 add. The tables here are the
/// usual ones and not confirmed for every model: check them against the data sheet of the source that is fitted. A code
/// that its table lacks is a fault and never a guess.
///
/// A reading is the pins as bits: 11 is bit 0, 12 bit 1, 16 bit 2, 21 bit 3.

namespace sc {

enum class SourceState : std::uint8_t {
    ready = 0,
    warning = 1,    ///< it may emit; something of it wants service
    not_ready = 2,  ///< it starts up or is switched off
    back_reflection = 3,
    temperature = 4,
    main_supply = 5,
    housekeeping = 6,
    system = 7,
    unknown = 8,
};
inline constexpr std::size_t kSourceStateCount = 9;
inline constexpr std::size_t kSourceReadings = 16;

namespace source_tables {

using enum SourceState;
using Table = std::array<SourceState, kSourceReadings>;
/// Rows: pins 21 16; columns: pins 12 11 = 00, 01, 10, 11.
inline constexpr Table kIpg{temperature,     temperature,     unknown, system,       // 00
                            ready,           not_ready,       warning, unknown,      // 01
                            main_supply,     housekeeping,    unknown, unknown,      // 10
                            back_reflection, back_reflection, unknown, system};      // 11
inline constexpr Table kRaycus{temperature,     unknown, temperature,     system,    // 00
                               ready,           warning, not_ready,       unknown,   // 01
                               main_supply,     unknown, housekeeping,    unknown,   // 10
                               back_reflection, unknown, back_reflection, unknown};  // 11
inline constexpr Table kJpt{temperature,     system,  unknown,      unknown,         // 00
                            ready,           unknown, not_ready,    warning,         // 01
                            main_supply,     unknown, housekeeping, unknown,         // 10
                            back_reflection, unknown, unknown,      unknown};        // 11

}  // namespace source_tables

/// Any context, one look-up. A source without pins is taken for ready: its two contacts alone then speak for it.
[[nodiscard]] constexpr SourceState source_state(LaserSource source, std::uint8_t pins) noexcept {
    const std::size_t reading = pins % kSourceReadings;
    switch (source) {
        case LaserSource::none: return SourceState::ready;
        case LaserSource::ipg: return source_tables::kIpg[reading];
        case LaserSource::raycus: return source_tables::kRaycus[reading];
        case LaserSource::jpt: return source_tables::kJpt[reading];
    }
    return SourceState::unknown;
}

[[nodiscard]] constexpr bool may_emit(SourceState state) noexcept {
    return state == SourceState::ready || state == SourceState::warning;
}

/// The fault of an alarm; none for what is no alarm.
[[nodiscard]] constexpr Fault fault_of(SourceState state) noexcept {
    constexpr std::array<Fault, kSourceStateCount> kFaults{Fault::none,
                                                           Fault::none,
                                                           Fault::none,
                                                           Fault::laser_back_reflection,
                                                           Fault::laser_temperature,
                                                           Fault::laser_main_supply,
                                                           Fault::laser_housekeeping,
                                                           Fault::laser_system,
                                                           Fault::laser_code_unknown};
    const auto i = static_cast<std::size_t>(state);
    return i < kFaults.size() ? kFaults[i] : Fault::laser_code_unknown;
}

[[nodiscard]] constexpr std::string_view name_of(SourceState state) noexcept {
    switch (state) {
        case SourceState::ready: return "ready";
        case SourceState::warning: return "warning";
        case SourceState::not_ready: return "not ready";
        case SourceState::back_reflection: return "back reflection";
        case SourceState::temperature: return "temperature";
        case SourceState::main_supply: return "main supply";
        case SourceState::housekeeping: return "housekeeping supply";
        case SourceState::system: return "system error";
        case SourceState::unknown: return "unknown code";
    }
    return "?";
}

}  // namespace sc

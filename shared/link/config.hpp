// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <expected>
#include <span>

#include "shared/codes/codes.hpp"
#include "shared/machine/machine.hpp"

/// The machine's configuration as bytes, as ConfigChunk carries it: u16 version, then every field of MachineConfig in
/// the order of its declaration, little-endian, quantities in SI units as f64, all eight keep-out volumes. The size is
/// fixed.

namespace sc::link {

inline constexpr std::uint16_t kConfigVersion = 5;
inline constexpr std::size_t kConfigSize = 1162;

/// No heap, any context, one pass.
void serialise(const MachineConfig& machine, std::span<std::uint8_t, kConfigSize> out) noexcept;

/// Reads the configuration. Refusal::version_mismatch for another version, Refusal::bad_config for a wrong size or a
/// configuration that `check` refuses; `machine` is then not to be used.
[[nodiscard]] Refusal deserialise_into(MachineConfig& machine, std::span<const std::uint8_t> bytes) noexcept;

/// The same as a value, where the stack has room for it.
[[nodiscard]] inline std::expected<MachineConfig, Refusal> deserialise(std::span<const std::uint8_t> bytes) noexcept {
    MachineConfig machine;
    const Refusal refusal = deserialise_into(machine, bytes);
    if (refusal != Refusal::none) {
        return std::unexpected(refusal);
    }
    return machine;
}

/// Refusal::none for a configuration that a controller can run with, else Refusal::bad_config: a number that is not
/// finite; a minimum that is not below its maximum; a limit, count, period or power that is not above zero; mirrors
/// that follow encoders that are not there; a negative latency, or one below the lag of the galvo's servo; a travel
/// that 32-bit wire units cannot express; a home outside the travel; a drive's node id that is not 1..127 or is given
/// twice; periods that do not divide; a heartbeat timeout outside 20..500 ms; a sensor on a bus that is none, at an
/// address outside 1..247 or given twice on its bus, with an empty range or no times; a sensor bus outside
/// 2400..230 400 baud.
[[nodiscard]] Refusal check(const MachineConfig& machine) noexcept;

}  // namespace sc::link

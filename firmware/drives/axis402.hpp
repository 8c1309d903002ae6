// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

/// The CiA 402 state machine as the master sees it: what a statusword says, and which controlword leads one transition
/// nearer to what is wanted. Pure, any context.

namespace sc::drives::axis402 {

enum class PowerState : std::uint8_t {
    not_ready,
    switch_on_disabled,
    ready_to_switch_on,
    switched_on,
    operation_enabled,
    quick_stop_active,
    fault_reaction_active,
    fault,
    unknown,  ///< a pattern that the standard does not know
};

/// Modes of operation (6060, 6061).
enum class Mode : std::int8_t { homing = 6, csp = 8 };

inline constexpr std::uint16_t kDisableVoltage = 0x0000;
inline constexpr std::uint16_t kQuickStop = 0x0002;
inline constexpr std::uint16_t kShutdown = 0x0006;
inline constexpr std::uint16_t kSwitchOn = 0x0007;
inline constexpr std::uint16_t kEnableOperation = 0x000F;
inline constexpr std::uint16_t kHomingStart = 0x0010;  ///< added to enable operation
inline constexpr std::uint16_t kFaultReset = 0x0080;

inline constexpr std::uint16_t kTargetReached = 0x0400;  ///< bit 10
inline constexpr std::uint16_t kBit12 = 0x1000;          ///< CSP: follows 607A; homing: attained
inline constexpr std::uint16_t kBit13 = 0x2000;          ///< CSP: following error; homing: error

[[nodiscard]] PowerState decode(std::uint16_t statusword) noexcept;

/// Controlword for the next single transition from `state`, as confirmed by a statusword, towards Operation enabled
/// (`power`) or Switch on disabled. Repeats the present state's word where the drive must move by itself.
[[nodiscard]] std::uint16_t next_controlword(PowerState state, bool power) noexcept;

enum class HomingState : std::uint8_t { running, interrupted, attained_moving, done, error };
/// Bits 13, 12 and 10 of the statusword in homing mode.
[[nodiscard]] HomingState decode_homing(std::uint16_t statusword) noexcept;

}  // namespace sc::drives::axis402

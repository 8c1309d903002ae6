// SPDX-License-Identifier: Apache-2.0
#include "firmware/drives/axis402.hpp"

namespace sc::drives::axis402 {

PowerState decode(std::uint16_t statusword) noexcept {
    switch (statusword & 0x6FU) {
        case 0x21U: return PowerState::ready_to_switch_on;
        case 0x23U: return PowerState::switched_on;
        case 0x27U: return PowerState::operation_enabled;
        case 0x07U: return PowerState::quick_stop_active;
        default: break;
    }
    switch (statusword & 0x4FU) {
        case 0x00U: return PowerState::not_ready;
        case 0x40U: return PowerState::switch_on_disabled;
        case 0x0FU: return PowerState::fault_reaction_active;
        case 0x08U: return PowerState::fault;
        default: return PowerState::unknown;
    }
}

std::uint16_t next_controlword(PowerState state, bool power) noexcept {
    switch (state) {
        case PowerState::switch_on_disabled: return power ? kShutdown : kDisableVoltage;
        case PowerState::ready_to_switch_on: return power ? kSwitchOn : kDisableVoltage;
        case PowerState::switched_on: return power ? kEnableOperation : kShutdown;
        case PowerState::operation_enabled: return power ? kEnableOperation : kSwitchOn;
        case PowerState::quick_stop_active: return kQuickStop;
        case PowerState::not_ready:
        case PowerState::fault_reaction_active:
        case PowerState::fault:
        case PowerState::unknown: return kDisableVoltage;
    }
    return kDisableVoltage;
}

HomingState decode_homing(std::uint16_t statusword) noexcept {
    const bool reached = (statusword & kTargetReached) != 0;
    if ((statusword & kBit13) != 0) {
        return HomingState::error;
    }
    if ((statusword & kBit12) != 0) {
        return reached ? HomingState::done : HomingState::attained_moving;
    }
    return reached ? HomingState::interrupted : HomingState::running;
}

}  // namespace sc::drives::axis402

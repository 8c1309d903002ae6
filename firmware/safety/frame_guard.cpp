// SPDX-License-Identifier: Apache-2.0
#include "firmware/safety/frame_guard.hpp"

#include "shared/machine/source_status.hpp"

namespace sc::safety {
namespace {

constexpr unsigned bit_if(bool condition, GuardCause cause) noexcept {
    return condition ? static_cast<unsigned>(cause) : 0U;
}

/// While pulses may leave, the mirrors must be where they are sent.
constexpr bool healthy_head(const GuardInputs& inputs) noexcept {
    return inputs.gate_allowed ? inputs.galvo_status == kGalvoStatusOk : galvo_healthy(inputs.galvo_status);
}

/// While pulses may leave, the shutter must read open; at other times the tick watches it.
constexpr bool healthy_shutter(const GuardInputs& inputs) noexcept {
    return !inputs.gate_allowed || shutter_reads_open(inputs.digital);
}

constexpr bool healthy_key(const GuardInputs& inputs) noexcept {
    return !inputs.gate_allowed || key_mode(inputs.digital) == KeyMode::production;
}

constexpr bool healthy_source(const GuardInputs& inputs) noexcept {
    return inputs.digital.laser_ready && inputs.digital.laser_no_alarm &&
           may_emit(source_state(inputs.source, inputs.digital.source_status));
}

}  // namespace

GuardVeto frame_guard(const GuardInputs& inputs) noexcept {
    const DigitalInputs& digital = inputs.digital;
    const unsigned causes =
        bit_if(!digital.estop_closed, GuardCause::estop) | bit_if(!digital.interlock_closed, GuardCause::interlock) |
        bit_if(!healthy_source(inputs), GuardCause::laser_alarm) | bit_if(!healthy_head(inputs), GuardCause::galvo) |
        bit_if(!healthy_shutter(inputs), GuardCause::shutter) | bit_if(!healthy_key(inputs), GuardCause::key);
    return {.close_gate = !inputs.gate_allowed || causes != 0, .causes = static_cast<std::uint8_t>(causes)};
}

}  // namespace sc::safety

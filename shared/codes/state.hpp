// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string_view>

namespace sc {

/// States of the cell's one state machine (firmware/safety/supervisor.hpp has the table of transitions).
enum class State : std::uint8_t {
    boot = 0,               ///< after power-up: waits for all drives on the bus. Laser off, axes unpowered.
    disabled = 1,           ///< drives present, unpowered.
    enabling = 2,           ///< drives are brought to Operation enabled, one confirmed transition at a time.
    idle = 3,               ///< axes hold their place; not homed, or homed and at rest. Laser off.
    homing = 4,             ///< y first, then x and z, then C.
    jogging = 5,            ///< one bounded step of one axis.
    arming = 6,             ///< master oscillator on, its wait not yet over. Gate shut.
    armed = 7,              ///< ready to run a job. Gate shut.
    running = 8,            ///< a job moves dark: travel, retract, turn, settle, run-in.
    marking = 9,            ///< on a path; the only state in which a pulse may leave.
    stopping = 10,          ///< jerk-limited stop on the path. Gate shut.
    held = 11,              ///< at rest on the path by command, or for want of points; may resume.
    held_link = 12,         ///< at rest on the path because the host is silent; the same session may go on within 10 s.
    disabling = 13,         ///< drives are brought down.
    fault = 14,             ///< latched. Laser off, axes stopped. Leaves only by reset_fault, to disabled.
    previewing = 15,        ///< a job is traced with the guide laser: master oscillator off, shutter and gate shut.
    preview_stopping = 16,  ///< jerk-limited stop of it. Guide laser off.
};
inline constexpr std::uint8_t kStateCount = 17;

[[nodiscard]] constexpr std::string_view name_of(State state) noexcept {
    switch (state) {
        case State::boot: return "boot";
        case State::disabled: return "disabled";
        case State::enabling: return "enabling";
        case State::idle: return "idle";
        case State::homing: return "homing";
        case State::jogging: return "jogging";
        case State::arming: return "arming";
        case State::armed: return "armed";
        case State::running: return "running";
        case State::marking: return "marking";
        case State::stopping: return "stopping";
        case State::held: return "held";
        case State::held_link: return "held_link";
        case State::disabling: return "disabling";
        case State::fault: return "fault";
        case State::previewing: return "previewing";
        case State::preview_stopping: return "preview_stopping";
    }
    return "?";
}

}  // namespace sc

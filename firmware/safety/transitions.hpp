// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>

#include "shared/codes/state.hpp"

/// The cell's state machine as data: the events, the one table of transitions, what each state may do, and the proofs
/// that the compiler checks. docs/states.md shows the same table as a diagram (a test compares them).

namespace sc::safety {

/// What can move the state. `trip` and `reset` go through Supervisor::trip and Supervisor::reset only.
enum class Event : std::uint8_t {
    drives_present = 0,
    enable,
    enabled,
    disable,
    disabled,
    home,
    homed,
    jog,
    jog_done,
    stop,  ///< breaks off homing or a jog
    arm,
    mo_ready,
    disarm,
    start,
    path_begin,
    path_end,
    job_done,
    hold,         ///< the operator's feed hold
    starved,      ///< points do not arrive in time
    link_silent,  ///< the host has gone quiet during a job
    abort,
    stopped_held,   ///< at rest after hold or starved
    stopped_link,   ///< at rest after link_silent
    stopped_abort,  ///< at rest after abort
    resume,
    link_back,
    preview,          ///< trace the opened job with the guide laser
    preview_done,     ///< its last item is done
    preview_stopped,  ///< at rest after it was broken off
    trip,
    reset,
};
inline constexpr std::size_t kEventCount = 31;

struct Transition {
    State from;
    Event event;
    State to;
};

/// Every transition but `trip`, which leads from each state to `fault` (see `next_state`).
inline constexpr std::array kTransitions{
    Transition{State::boot, Event::drives_present, State::disabled},
    Transition{State::disabled, Event::enable, State::enabling},
    Transition{State::enabling, Event::enabled, State::idle},
    Transition{State::enabling, Event::disable, State::disabling},
    Transition{State::idle, Event::disable, State::disabling},
    Transition{State::idle, Event::home, State::homing},
    Transition{State::idle, Event::jog, State::jogging},
    Transition{State::idle, Event::arm, State::arming},
    Transition{State::idle, Event::preview, State::previewing},
    Transition{State::homing, Event::homed, State::idle},
    Transition{State::homing, Event::stop, State::idle},
    Transition{State::jogging, Event::jog_done, State::idle},
    Transition{State::jogging, Event::stop, State::idle},
    Transition{State::arming, Event::mo_ready, State::armed},
    Transition{State::arming, Event::disarm, State::idle},
    Transition{State::armed, Event::disarm, State::idle},
    Transition{State::armed, Event::start, State::running},
    Transition{State::running, Event::path_begin, State::marking},
    Transition{State::running, Event::job_done, State::armed},
    Transition{State::running, Event::hold, State::stopping},
    Transition{State::running, Event::starved, State::stopping},
    Transition{State::running, Event::link_silent, State::stopping},
    Transition{State::running, Event::abort, State::stopping},
    Transition{State::marking, Event::path_end, State::running},
    Transition{State::marking, Event::hold, State::stopping},
    Transition{State::marking, Event::starved, State::stopping},
    Transition{State::marking, Event::link_silent, State::stopping},
    Transition{State::marking, Event::abort, State::stopping},
    Transition{State::stopping, Event::link_silent, State::stopping},
    Transition{State::stopping, Event::abort, State::stopping},
    Transition{State::stopping, Event::stopped_held, State::held},
    Transition{State::stopping, Event::stopped_link, State::held_link},
    Transition{State::stopping, Event::stopped_abort, State::armed},
    Transition{State::held, Event::resume, State::running},
    Transition{State::held, Event::abort, State::armed},
    Transition{State::held, Event::link_silent, State::held_link},
    Transition{State::held_link, Event::link_back, State::running},
    Transition{State::held_link, Event::abort, State::armed},
    Transition{State::previewing, Event::preview_done, State::idle},
    Transition{State::previewing, Event::abort, State::preview_stopping},
    Transition{State::previewing, Event::link_silent, State::preview_stopping},
    Transition{State::preview_stopping, Event::preview_stopped, State::idle},
    Transition{State::disabling, Event::disabled, State::disabled},
    Transition{State::fault, Event::reset, State::disabled},
};

/// Answer of `next_state`: `allowed` false means that nothing changes.
struct NextState {
    State state = State::fault;
    bool allowed = false;
};

/// Where an event leads. O(rows); any context.
[[nodiscard]] constexpr NextState next_state(State from, Event event) noexcept {
    if (event == Event::trip) {
        return {State::fault, true};
    }
    for (const Transition& row : kTransitions) {
        if (row.from == from && row.event == event) {
            return {row.to, true};
        }
    }
    return {from, false};
}

/// The only state in which a pulse may leave.
[[nodiscard]] constexpr bool gate_state(State state) noexcept { return state == State::marking; }

/// States in which the source's master oscillator is on.
[[nodiscard]] constexpr bool mo_state(State state) noexcept {
    switch (state) {
        case State::arming:
        case State::armed:
        case State::running:
        case State::marking:
        case State::stopping:
        case State::held:
        case State::held_link: return true;
        case State::boot:
        case State::disabled:
        case State::enabling:
        case State::idle:
        case State::homing:
        case State::jogging:
        case State::disabling:
        case State::fault:
        case State::previewing:
        case State::preview_stopping: return false;
    }
    return false;
}

/// States in which the beam's shutter is open: those of the master oscillator.
[[nodiscard]] constexpr bool shutter_state(State state) noexcept { return mo_state(state); }

/// The state in which the guide laser traces a job.
[[nodiscard]] constexpr bool guide_state(State state) noexcept { return state == State::previewing; }

/// States in which a person may have the guide laser on, to point by.
[[nodiscard]] constexpr bool pointing_state(State state) noexcept {
    return state == State::idle || state == State::jogging;
}

/// States that belong to a preview.
[[nodiscard]] constexpr bool preview_state(State state) noexcept {
    return state == State::previewing || state == State::preview_stopping;
}

/// States in which axes may be in motion by order (homing is made by the drives themselves).
[[nodiscard]] constexpr bool moving_state(State state) noexcept {
    return state == State::homing || state == State::jogging || state == State::running || state == State::marking ||
           state == State::stopping || preview_state(state);
}

/// States in which the drives are asked to be in Operation enabled.
[[nodiscard]] constexpr bool powered_state(State state) noexcept {
    return state == State::enabling || state == State::idle || state == State::homing || state == State::jogging ||
           preview_state(state) || mo_state(state);
}

[[nodiscard]] constexpr std::string_view name_of(Event event) noexcept {
    switch (event) {
        case Event::drives_present: return "drives_present";
        case Event::enable: return "enable";
        case Event::enabled: return "enabled";
        case Event::disable: return "disable";
        case Event::disabled: return "disabled";
        case Event::home: return "home";
        case Event::homed: return "homed";
        case Event::jog: return "jog";
        case Event::jog_done: return "jog_done";
        case Event::stop: return "stop";
        case Event::arm: return "arm";
        case Event::mo_ready: return "mo_ready";
        case Event::disarm: return "disarm";
        case Event::start: return "start";
        case Event::path_begin: return "path_begin";
        case Event::path_end: return "path_end";
        case Event::job_done: return "job_done";
        case Event::hold: return "hold";
        case Event::starved: return "starved";
        case Event::link_silent: return "link_silent";
        case Event::abort: return "abort";
        case Event::stopped_held: return "stopped_held";
        case Event::stopped_link: return "stopped_link";
        case Event::stopped_abort: return "stopped_abort";
        case Event::resume: return "resume";
        case Event::link_back: return "link_back";
        case Event::preview: return "preview";
        case Event::preview_done: return "preview_done";
        case Event::preview_stopped: return "preview_stopped";
        case Event::trip: return "trip";
        case Event::reset: return "reset";
    }
    return "?";
}

}  // namespace sc::safety

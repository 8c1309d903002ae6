// SPDX-License-Identifier: Apache-2.0
#include "firmware/safety/supervisor.hpp"

#include "firmware/safety/laser_rule.hpp"

namespace sc::safety {
namespace {

constexpr State state_at(std::size_t i) noexcept { return static_cast<State>(i); }
constexpr Event event_at(std::size_t i) noexcept { return static_cast<Event>(i); }

constexpr bool rows_are_unambiguous() noexcept {
    for (std::size_t i = 0; i < kTransitions.size(); ++i) {
        for (std::size_t k = i + 1; k < kTransitions.size(); ++k) {
            if (kTransitions.at(i).from == kTransitions.at(k).from &&
                kTransitions.at(i).event == kTransitions.at(k).event) {
                return false;
            }
        }
    }
    return true;
}

constexpr bool every_trip_leads_to_fault() noexcept {
    for (std::size_t i = 0; i < kStateCount; ++i) {
        const NextState next = next_state(state_at(i), Event::trip);
        if (!next.allowed || next.state != State::fault) {
            return false;
        }
    }
    return true;
}

constexpr bool fault_leaves_only_by_reset() noexcept {
    for (std::size_t i = 0; i < kEventCount; ++i) {
        const NextState next = next_state(State::fault, event_at(i));
        if (next.allowed && next.state != State::fault && event_at(i) != Event::reset) {
            return false;
        }
    }
    return next_state(State::fault, Event::reset).state == State::disabled;
}

constexpr bool every_state_is_reachable() noexcept {
    std::array<bool, kStateCount> reached{};
    reached[static_cast<std::size_t>(State::boot)] = true;
    reached[static_cast<std::size_t>(State::fault)] = true;  // by a trip from boot
    for (std::size_t pass = 0; pass < kStateCount; ++pass) {
        for (const Transition& row : kTransitions) {
            if (reached.at(static_cast<std::size_t>(row.from))) {
                reached.at(static_cast<std::size_t>(row.to)) = true;
            }
        }
    }
    for (const bool state : reached) {
        if (!state) {
            return false;
        }
    }
    return true;
}

constexpr std::uint32_t states_where(bool (*holds)(State) noexcept) noexcept {
    std::uint32_t bits = 0;
    for (std::size_t i = 0; i < kStateCount; ++i) {
        bits |= holds(state_at(i)) ? (std::uint32_t{1} << i) : 0U;
    }
    return bits;
}
template <class... States>
constexpr std::uint32_t exactly(States... states) noexcept {
    return ((std::uint32_t{1} << static_cast<unsigned>(states)) | ...);
}

/// A state that fires pulses is entered from `running` alone: nothing can skip the run-in.
constexpr bool marking_is_entered_from_running_alone() noexcept {
    for (const Transition& row : kTransitions) {
        if (row.to == State::marking && row.from != State::running) {
            return false;
        }
    }
    return true;
}

/// No way from a preview to a state that burns but through `idle`, and so through all of arming.
constexpr bool a_preview_leads_to_idle_or_fault_alone() noexcept {
    for (const Transition& row : kTransitions) {
        if (preview_state(row.from) && !preview_state(row.to) && row.to != State::idle) {
            return false;
        }
        if (preview_state(row.to) && !preview_state(row.from) && row.from != State::idle) {
            return false;
        }
    }
    return true;
}

/// The laser rule with everything but the state at its best.
constexpr bool no_preview_passes_the_laser_rule() noexcept {
    MarkContext best{.state = State::marking,
                     .mark_segment = true,
                     .mo_ready = true,
                     .interlocks_closed = true,
                     .laser_healthy = true,
                     .galvo_healthy = true,
                     .shutter_open = true,
                     .key_production = true,
                     .faults = 0,
                     .path_speed = Speed::from_si(1.0),
                     .path_speed_min = Speed::from_si(0.0)};
    if (!gate_permitted(best)) {
        return false;  // the rule would prove nothing
    }
    for (std::size_t i = 0; i < kStateCount; ++i) {
        best.state = state_at(i);
        if ((preview_state(best.state) || guide_state(best.state) || pointing_state(best.state)) &&
            gate_permitted(best)) {
            return false;
        }
    }
    return true;
}

static_assert(rows_are_unambiguous(), "one row for a state and an event");
static_assert(every_trip_leads_to_fault());
static_assert(fault_leaves_only_by_reset());
static_assert(every_state_is_reachable());
static_assert(marking_is_entered_from_running_alone());
static_assert(states_where(gate_state) == exactly(State::marking), "pulses leave while marking and never else");
static_assert(states_where(mo_state) == exactly(State::arming, State::armed, State::running, State::marking,
                                                State::stopping, State::held, State::held_link));
static_assert((states_where(gate_state) & ~states_where(mo_state)) == 0, "no gate without master oscillator");
static_assert(states_where(guide_state) == exactly(State::previewing));
static_assert(states_where(pointing_state) == exactly(State::idle, State::jogging));
static_assert((states_where(pointing_state) & (states_where(mo_state) | states_where(shutter_state))) == 0,
              "who points has neither master oscillator nor an open shutter");
static_assert((states_where(preview_state) & (states_where(gate_state) | states_where(mo_state))) == 0,
              "a preview has neither gate nor master oscillator");
static_assert((states_where(preview_state) & states_where(shutter_state)) == 0, "a preview leaves the shutter shut");
static_assert((states_where(gate_state) & ~states_where(shutter_state)) == 0, "no gate with the shutter shut");
static_assert(a_preview_leads_to_idle_or_fault_alone());
static_assert(no_preview_passes_the_laser_rule(), "whatever else holds, a preview fires nothing");
static_assert((states_where(moving_state) & ~states_where(powered_state)) == 0, "no motion without power");

}  // namespace

bool Supervisor::post(Event event) noexcept {
    if (event == Event::trip || event == Event::reset) {
        return false;
    }
    const NextState next = next_state(state_, event);
    state_ = next.state;
    return next.allowed;
}

void Supervisor::trip(Fault fault, std::uint8_t axis, std::int64_t tick) noexcept {
    if (fault == Fault::none) {
        return;
    }
    if (faults_ == 0) {
        first_fault_ = {.fault = fault, .axis = axis, .state = state_, .tick = tick};
    }
    faults_ |= fault_bit(fault);
    state_ = next_state(state_, Event::trip).state;
}

Refusal Supervisor::reset(std::uint64_t still_present) noexcept {
    const NextState next = next_state(state_, Event::reset);
    if (!next.allowed) {
        return Refusal::wrong_state;
    }
    if (still_present != 0) {
        return Refusal::fault_present;
    }
    state_ = next.state;
    faults_ = 0;
    first_fault_ = {};
    return Refusal::none;
}

}  // namespace sc::safety

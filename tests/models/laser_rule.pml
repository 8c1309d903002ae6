/* SPDX-License-Identifier: Apache-2.0
 *
 * The laser rule: when a pulse may leave. The table of states, its predicates and the rule itself are not written here:
 * check.py makes table.pml from firmware/safety/transitions.hpp and laser_rule.hpp. Written here is what surrounds them:
 * the order of a tick (Controller::servo_step), the guard between ticks, the hard line, and a world, an operator and a path
 * that do what they like. README.md has the mapping.
 */
#include "table.pml"

/* The world: inputs, drawn anew each time that something looks at them; a key that is gone stays away. */
bool estop, interlock, source, key, shutter, alive, key_gone = false;
/* What the operator has asked for since the last fault: 0 nothing, 1 reset, 2 enable, 3 arm, 4 start. Power-up counts as
 * a reset that was asked for. */
byte asked = 1;
bool asked_reset = true, asked_on = true; /* since the last fault; since the last hold or silent link */

/* The controller. */
byte state = S_boot;
bool faults = false;
bool mo_on = false, mo_waited = false, warned = false, shutter_order = false, shutter_proven = false;
bool pulses_before = false, stopping_for_abort = false, stopping_for_link = false, stopping_for_points = false;
bool seen_estop = false, seen_beam = false; /* by the guard since the last tick */
/* Its path. */
bool moving = false, on_path = false, fast = false;
/* The laser: runs that wait for the next window, and those of this one. */
bool queued = false, queued_allowed = false, acting = false, acting_allowed = false, gate_open = false;
bool rightly = false, acting_rightly = false; /* they were released as they must be */
bool slot_beam = false; /* source, shutter and key as they were when the guard last looked */

#define MO_READY (mo_on && mo_waited)

inline trip() {
    if
    :: state != S_fault -> asked = 0; asked_reset = false
    :: else
    fi;
#ifndef NO_LATCH
    state = S_fault;
    faults = true;
#endif
    queued = false; acting = false /* cancel_laser acts at once */
}

inline stop_for(abort, link, points) {
    stopping_for_abort = abort; stopping_for_link = link; stopping_for_points = points
}

inline take_command() {
    if
    :: command == E_arm ->
        if
        :: key && estop && interlock && source -> post_arm()
        :: else
        fi
    :: command == E_resume ->
        if
        :: state == S_held_link -> post_link_back()
        :: else -> post_resume()
        fi
    :: command == E_hold ->
        post_hold();
        if
        :: ok -> stop_for(false, false, false); asked_on = false
        :: else
        fi
    :: command == E_abort ->
        post_abort();
        if
        :: ok -> stop_for(true, false, false)
        :: else
        fi
    :: command == E_reset ->
        if
        :: state == S_fault && estop && source && shutter == shutter_order && interlock && !moving ->
            post_reset(); faults = false
        :: else
        fi
    :: command == 0 -> skip
    :: else -> post(command)
    fi;
    command = 0
}

inline watch_inputs() {
    if
    :: (POWERED_STATE(state) && (!estop || seen_estop)) ||
       (MO_STATE(state) && (!interlock || !source || !key || seen_beam)) || (shutter_proven && !shutter) -> trip()
    :: else
    fi;
    seen_estop = false; seen_beam = false;
    shutter_proven = shutter_order && shutter
}

inline watch_link() {
    if
    :: alive -> skip
    :: !alive && state == S_held_link ->
        if
        :: trip() /* it has been silent for too long */
        :: skip
        fi
    :: !alive && (state == S_arming || state == S_armed) -> post_disarm()
    :: !alive && (state == S_homing || state == S_jogging) -> post_stop()
    :: else ->
        if
        :: state == S_stopping && stopping_for_abort -> skip
        :: else ->
            post_link_silent();
            if
            :: ok && !PREVIEW_STATE(state) -> stop_for(false, true, false); asked_on = false
            :: else
            fi
        fi
    fi
}

inline advance_states() {
    if
    :: state == S_boot -> post_drives_present()
    :: state == S_enabling -> post_enabled()
    :: state == S_homing -> post_homed()
    :: state == S_jogging -> post_jog_done()
    :: state == S_arming && MO_READY -> post_mo_ready()
    :: state == S_running && on_path -> post_path_begin()
    :: state == S_marking && !on_path -> post_path_end()
    :: state == S_running && !on_path -> post_job_done()
    :: state == S_running || state == S_marking -> post_starved(); stop_for(false, false, true)
    :: state == S_stopping && !moving ->
        if
        :: stopping_for_abort -> post_stopped_abort()
        :: stopping_for_link -> post_stopped_link()
        :: else -> post_stopped_held()
        fi
    :: state == S_held && stopping_for_points -> post_resume() /* they have come */
    :: state == S_previewing -> post_preview_done()
    :: state == S_preview_stopping && !moving -> post_preview_stopped()
    :: state == S_disabling -> post_disabled()
    :: true
    fi
#ifdef REARM_BY_ITSELF
    ;
    if
    :: state == S_fault && estop && interlock && source && key -> state = S_arming; faults = false
    :: else
    fi
#endif
#ifdef RESUME_BY_ITSELF
    ;
    if
    :: state == S_held_link && alive -> post_link_back()
    :: else
    fi
#endif
}

/* MoSequencer::step; in `arming` only behind the warning and a shutter that obeys. */
inline step_oscillator() {
    if
    :: MO_STATE(state) && (state != S_arming || (warned && shutter_proven)) ->
        mo_waited = mo_on;
        mo_on = true
    :: else -> mo_on = false; mo_waited = false
    fi;
    warned = (state == S_arming);
}

/* A path does what it likes, and offers pulses when it likes. */
inline step_path() {
    if
    :: MOVING_STATE(state) && state != S_stopping && state != S_preview_stopping ->
        moving = true;
        if
        :: on_path = true
        :: on_path = false
        fi
    :: else ->
        if
        :: moving = false
        :: skip
        fi
    fi;
    if
    :: fast = moving
    :: fast = false
    fi
}

inline gate() {
    mark_segment = on_path; mo_ready = MO_READY; interlocks_closed = estop && interlock; laser_healthy = source;
    galvo_healthy = true; shutter_open = shutter_proven; key_production = key; path_speed_suffices = fast;
    if
    :: offered && GATE_PERMITTED ->
        rightly = state == S_marking && on_path && fast && MO_READY && estop && interlock && source && shutter && key &&
            !faults && asked_on
    :: offered && !GATE_PERMITTED ->
        offered = false;
        if
        :: !faults -> trip() /* mark_rule */
        :: else
        fi
    :: else
    fi;
    queued_allowed = (offered || pulses_before) && !faults;
    queued = offered && queued_allowed;
    pulses_before = offered;
    shutter_order = SHUTTER_STATE(state);
    if
    :: state == S_fault -> queued = false; acting = false
    :: else
    fi
}

inline draw(input) {
    if
    :: input = true
    :: input = false
    fi
}

/* One trouble at a time; the next look may find another. */
inline look_at_inputs() {
    estop = true; interlock = true; source = true; shutter = true; key = true;
    if
    :: skip
    :: estop = false
    :: interlock = false
    :: source = false
    :: shutter = false
    :: key = false
    :: key_gone = true
    fi;
    key = key && !key_gone
}

/* So that what nobody will look at again makes no states of its own. */
inline forget_inputs() {
    estop = false; interlock = false; source = false; shutter = false; key = false; alive = false
}

/* The operator says anything at any time; what he has asked for counts from then on, taken or not. */
inline operate() {
    if
    :: command = 0
    :: alive -> command = E_enable; asked = (asked == 1 -> 2 : asked)
    :: alive -> command = E_home
    :: alive -> command = E_jog
    :: alive -> command = E_preview
    :: alive -> command = E_arm; asked = (asked == 2 -> 3 : asked)
    :: alive -> command = E_start; asked = (asked == 3 -> 4 : asked); asked_on = true
    :: alive -> command = E_disarm
    :: alive -> command = E_disable
    :: alive -> command = E_hold
    :: alive -> command = E_resume; asked_on = true
    :: alive -> command = E_abort
    :: alive -> command = E_reset; asked = (asked == 0 -> 1 : asked); asked_reset = true
    fi
}

proctype cell() {
    bool ok, offered, mark_segment, mo_ready, interlocks_closed, laser_healthy, galvo_healthy, shutter_open, key_production,
        path_speed_suffices;
    byte command, slot;
    do
    :: atomic {
        /* The outputs of the last tick begin to act, then this one looks. */
        acting = queued; acting_allowed = queued_allowed; acting_rightly = rightly;
        queued = false;
        look_at_inputs();
        draw(alive);
        operate();
        take_command();
        watch_inputs();
        watch_link();
        advance_states();
        step_oscillator();
        step_path();
        draw(offered);
        gate();
        rightly = rightly && queued;
        acting_rightly = acting_rightly && acting;
        forget_inputs();
        ok = false; offered = false; mark_segment = false; mo_ready = false; interlocks_closed = false;
        laser_healthy = false; galvo_healthy = false; shutter_open = false; key_production = false;
        path_speed_suffices = false; fast = false;
        slot = 0 }
    atomic {
        do
        :: slot < 2 ->
            /* frame_guard */
            look_at_inputs();
            slot_beam = source && shutter && key;
            seen_estop = seen_estop || !estop;
            seen_beam = seen_beam || !interlock || !source || (acting_allowed && (!shutter || !key));
#ifdef NO_GUARD
            gate_open = true;
#else
            if
            :: !estop || !interlock || !source || (acting_allowed && (!shutter || !key)) -> gate_open = false; acting = false
            :: else -> gate_open = true
            fi;
#endif
            /* A pulse, if one waits. The hard line from e-stop and interlock needs no program. */
            if
            :: skip
            :: estop = false
            :: interlock = false
            fi;
            if
            :: acting && gate_open && estop && interlock ->
                assert(acting_rightly); /* by the rule: in marking, at speed, no fault; asked to go on since a hold */
                assert(slot_beam);      /* nothing wrong that the guard could see */
                assert(asked == 4);     /* reset, enable, arm and start since the last fault */
#ifdef WITNESS
                assert(false)
#endif
            :: else
            fi;
            slot++
        :: else -> break
        od;
        slot = 0; slot_beam = false; gate_open = false;
        forget_inputs() }
    od
}

init { run cell() }

#ifdef LIVENESS
/* A fault stays until a reset is asked for. */
ltl latched { [] (state == S_fault -> (asked_reset V (state == S_fault || asked_reset))) }
#endif

#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Copies of the firmware's sources, and of the plant's hard line, from which rules of the laser can be taken out while
the program runs. Each text must be there exactly once, so that a mutant cannot rot into a copy of what is right.

mutate.py PROJECT COPIES"""
import sys
from pathlib import Path

GUARD = "firmware/safety/frame_guard.cpp"
SUPERVISOR = "firmware/safety/supervisor.cpp"
CONTROLLER = "firmware/controller/controller.cpp"
WATCH = "firmware/controller/controller_watch.cpp"
PLANT = "boards/sim/plant/cell_plant.cpp"
STREAM = "firmware/link/job_stream.cpp"
RUNNER = "firmware/controller/job_runner.cpp"


def guard(cause, condition):
    """A comparison of the guard between ticks."""
    return [(GUARD, f"bit_if({condition}, GuardCause::{cause})", f"bit_if(!(@) && {condition}, GuardCause::{cause})")]


def assigned(file, left, right):
    return [(file, f"{left} = {right};", f"{left} = (@) || ({right});")]


# (rule, [(file, text, text without the rule)]); @ stands for "this rule is taken out". A rule that stands in several
# places of one layer is taken out of all of them.
MUTANTS = [
    ("hardware: the e-stop chain cuts the light",
     [(PLANT, "    if (lines_.estop_closed && lines_.interlock_closed) {\n        laser_.restore_light",
       "    if ((lines_.estop_closed || (@)) && lines_.interlock_closed) {\n        laser_.restore_light")]),
    ("hardware: the interlock cuts the light",
     [(PLANT, "        laser_.cut_light(t_ns + kHardCutNs);",
       "        if (!((@) && lines_.estop_closed)) {\n            laser_.cut_light(t_ns + kHardCutNs);\n        }")]),
    ("guard: e-stop", guard("estop", "!digital.estop_closed")),
    ("guard: interlock", guard("interlock", "!digital.interlock_closed")),
    ("guard: source", guard("laser_alarm", "!healthy_source(inputs)")),
    ("guard: the source's ready contact",
     [(GUARD, "inputs.digital.laser_ready &&", "(inputs.digital.laser_ready || (@)) &&")]),
    ("guard: the source's alarm contact",
     [(GUARD, "inputs.digital.laser_no_alarm &&", "(inputs.digital.laser_no_alarm || (@)) &&")]),
    ("guard: the source's status pins",
     [(GUARD, "may_emit(source_state(inputs.source, inputs.digital.source_status))",
       "((@) || may_emit(source_state(inputs.source, inputs.digital.source_status)))")]),
    ("guard: galvo status", guard("galvo", "!healthy_head(inputs)")),
    ("guard: shutter", guard("shutter", "!healthy_shutter(inputs)")),
    ("guard: key", guard("key", "!healthy_key(inputs)")),
    ("guard: shuts the gate when it has a cause",
     [(GUARD, ".close_gate = !inputs.gate_allowed || causes != 0", ".close_gate = !inputs.gate_allowed || (causes != 0 && !(@))")]),
    ("tick: e-stop trips",
     [(WATCH, "if (safety::powered_state(state()) && (!in", "if (!(@) && safety::powered_state(state()) && (!in")]),
    ("tick: interlock trips",
     [(WATCH, "        if (!in.digital.interlock_closed || seen(GuardCause::interlock)) {",
       "        if (!(@) && (!in.digital.interlock_closed || seen(GuardCause::interlock))) {")]),
    ("tick: galvo status trips",
     [(WATCH, "if (!head || seen(GuardCause::galvo)) {", "if (!(@) && (!head || seen(GuardCause::galvo))) {")]),
    ("tick: a head that is not there trips", [(WATCH, "if (head_.failed()) {", "if (!(@) && head_.failed()) {")]),
    ("tick: shutter trips", [(WATCH, "if (state() != State::boot && (wrong", "if (!(@) && state() != State::boot && (wrong")]),
    ("tick: key trips",
     [(WATCH, "if (safety::mo_state(state()) && (key != KeyMode::production",
       "if (!(@) && safety::mo_state(state()) && (key != KeyMode::production")]),
    ("tick: the source's status pins trip",
     [(WATCH, "    if (alarm != Fault::none) {\n        trip", "    if (!(@) && alarm != Fault::none) {\n        trip")]),
    ("tick: the source's contacts trip",
     [(WATCH, "    } else if (!laser_healthy(in.digital) ||\n", "    } else if ((@) ? false : !laser_healthy(in.digital) ||\n")]),
    ("tick: what the guard has seen since the last tick counts",
     [(WATCH, "void Controller::watch_inputs(const ServoInputs& in) noexcept {\n    const auto seen = [&](GuardCause cause) noexcept {\n        return (",
       "void Controller::watch_inputs(const ServoInputs& in) noexcept {\n    const auto seen = [&](GuardCause cause) noexcept {\n        return !(@) && ("),
      (WATCH, "void Controller::watch_beam(const ServoInputs& in) noexcept {\n    const auto seen = [&](GuardCause cause) noexcept {\n        return (",
       "void Controller::watch_beam(const ServoInputs& in) noexcept {\n    const auto seen = [&](GuardCause cause) noexcept {\n        return !(@) && (")]),
    ("tick: wrong arithmetic trips",
     [(WATCH, "if (!safety::arithmetic_state_is_right()) {", "if (!(@) && !safety::arithmetic_state_is_right()) {")]),
    ("tick: a drive that is silent trips",
     [(WATCH, "if (!axis.present) {", "if (!(@) && !axis.present) {"),
      (WATCH, "stale_ticks_ > kStaleDriveTicks) {", "stale_ticks_ > kStaleDriveTicks && !(@)) {"),
      (WATCH, "drives_seen_.actual_fresh ? suspicion_.fault : Fault::drive_lost",
       "drives_seen_.actual_fresh || (@) ? suspicion_.fault : Fault::drive_lost")]),
    ("tick: a drive in its fault trips",
     [(WATCH, "        } else if ((axis.fault ||", "        } else if (!(@) && (axis.fault ||"),
      (WATCH, "state() != State::enabling) {\n            trip(Fault::drive_fault",
       "state() != State::enabling && !(@)) {\n            trip(Fault::drive_fault")]),
    ("tick: a drive's fault counts in the tick that its frame comes in",
     [(WATCH, "((told >> i) & 1U) != 0)", "(((told >> i) & 1U) != 0 && !(@)))")]),
    ("tick: a fault stops the axes", [(WATCH, "    if (moving) {\n", "    if (moving && !(@)) {\n")]),
    ("tick: a silent host disarms",
     [(WATCH, "        case State::armed: (void)supervisor_.post(Event::disarm); break;",
       "        case State::armed: (void)((@) || supervisor_.post(Event::disarm)); break;")]),
    ("tick: a silent host ends homing and jogging",
     [(WATCH, "            runner_.request_stop();\n            (void)supervisor_.post(Event::stop);",
       "            if (!(@)) {\n                runner_.request_stop();\n                (void)supervisor_.post(Event::stop);\n            }")]),
    ("tick: a silent host ends a preview",
     [(WATCH, "            runner_.request_stop();\n            (void)supervisor_.post(Event::link_silent);",
       "            if (!(@)) {\n                runner_.request_stop();\n"
       "                (void)supervisor_.post(Event::link_silent);\n            }")]),
    ("tick: axes are compared with their set-points",
     [(WATCH, "if (finding && !suspicion_) {", "if (finding && !suspicion_ && !(@)) {")]),
    ("tick: a suspicion ends in a fault",
     [(WATCH, "if (suspicion_ && in.tick - suspicion_tick_", "if (!(@) && suspicion_ && in.tick - suspicion_tick_")]),
    ("tick: a silent host takes the light away",
     [(WATCH, "    const bool silent = !link_.alive(in.tick);", "    const bool silent = !link_.alive(in.tick) && !(@);")]),
    ("tick: a held job is lost after its time",
     [(WATCH, "            if ((in.tick - silent_since_) * machine_", "            if (!(@) && (in.tick - silent_since_) * machine_")]),
    ("tick: a late planner trips",
     [(CONTROLLER, "state() == State::marking, out)) {", "state() == State::marking, out) && !(@)) {")]),
    # Alone it does not show: the guard's word shuts the gate as well, in the same window.
    ("tick: a fault cancels what is queued and takes back the guard's word",
     [(CONTROLLER, "out.cancel_laser = cancel_ || state() == State::fault;",
       "out.cancel_laser = !(@) && (cancel_ || state() == State::fault);"),
      (CONTROLLER, "(out.laser_size > 0 || pulses_before_) && supervisor_.faults() == 0 && !suspicion_;",
       "(out.laser_size > 0 || pulses_before_) && ((@) || (supervisor_.faults() == 0 && !suspicion_));")]),
    ("tick: pulses leave while marking alone",
     [(CONTROLLER, "context.state = state();", "context.state = (@) ? State::marking : state();"),
      (CONTROLLER, "link_.items(), state() == State::marking, out)", "link_.items(), (@) || state() == State::marking, out)")]),
    ("tick: master oscillator off in a fault",
     [(CONTROLLER, "out.digital.master_oscillator = mo_.on();",
       "out.digital.master_oscillator = mo_.on() || ((@) && state() == State::fault);")]),
    ("tick: shutter shut in a fault",
     [(CONTROLLER, "out.digital.shutter_open = shutter_open_;",
       "out.digital.shutter_open = shutter_open_ || ((@) && state() == State::fault);")]),
    ("tick: warning before the master oscillator",
     [(CONTROLLER, "const bool warned = warned_ticks_ * ", "const bool warned = (@) || warned_ticks_ * ")]),
    ("tick: shutter proven before the master oscillator",
     [(CONTROLLER, "shutter_.proven_open()));", "(shutter_.proven_open() || (@))));"),
      (CONTROLLER, "warned && head_.proven()", "(warned || (@)) && head_.proven()")]),
    ("tick: armed only after the master oscillator's wait",
     [(CONTROLLER, "            if (mo_.ready()) {", "            if (mo_.ready() || (@)) {"),
      (CONTROLLER, "context.mo_ready = mo_.ready();", "context.mo_ready = (@) || mo_.ready();")]),
    ("tick: guide laser in previews alone",
     [(CONTROLLER, "(safety::guide_state(state()) && runner_.on_line())", "((safety::guide_state(state()) || (@)) && runner_.on_line())")]),
    ("tick: guide laser to point by only when asked",
     [(CONTROLLER, "(pointing_ && ", "((pointing_ || (@)) && ")]),
    ("tick: guide laser to point by goes with its states",
     [(CONTROLLER, "safety::pointing_state(state()));", "(safety::pointing_state(state()) || (@)));"),
      (WATCH, "if (!safety::pointing_state(state()) || guide_allowed", "if ((!safety::pointing_state(state()) && !(@)) || guide_allowed")]),
    ("a fault stays until it is reset",
     [(SUPERVISOR, "    const NextState next = next_state(state_, event);\n    state_ = next.state;",
       "    if ((@) && state_ == State::fault) {\n        state_ = State::disabled;\n    }\n"
       "    const NextState next = next_state(state_, event);\n    state_ = next.state;")]),
    ("a reset is refused while its cause is there",
     [(SUPERVISOR, "if (still_present != 0) {", "if (still_present != 0 && !(@)) {"),
      (WATCH, "const std::uint64_t present = present_faults(in);",
       "const std::uint64_t present = (@) ? 0 : present_faults(in);")]),
    ("a reset leads to disabled",
     [(SUPERVISOR, "    state_ = next.state;\n    faults_ = 0;", "    state_ = (@) ? State::armed : next.state;\n    faults_ = 0;")]),
    ("a fault is left only when the host asks for it",
     [(WATCH, "    if (!reset_wanted_) {", "    if (!reset_wanted_ && !((@) && state() == State::fault)) {")]),
    ("supervisor: what has no row is refused",
     [(SUPERVISOR, "    return next.allowed;\n", "    return next.allowed || (@);\n")]),
    ("supervisor: the first fault stays the first",
     [(SUPERVISOR, "    if (faults_ == 0) {\n", "    if (faults_ == 0 || (@)) {\n")]),
    ("supervisor: each fault has its bit",
     [(SUPERVISOR, "    faults_ |= fault_bit(fault);", "    faults_ |= (@) ? 0 : fault_bit(fault);")]),
    ("supervisor: a reset forgets the faults",
     [(SUPERVISOR, "    first_fault_ = {};\n    return", "    faults_ = (@) ? still_present | fault_bit(first_fault_.fault) : 0;\n    first_fault_ = {};\n    return")]),
    ("stream: an item is taken once, by its number",
     [(STREAM, "    if (rules_.checks_index && known(block)) {", "    if (!(@) && rules_.checks_index && known(block)) {"),
      (STREAM, "        if (!rules_.checks_index || next.end() > received_", "        if ((@) || !rules_.checks_index || next.end() > received_"),
      (STREAM, "    if (rules_.checks_index && reading_item_ < received_) {", "    if (!(@) && rules_.checks_index && reading_item_ < received_) {")]),
    ("stream: blocks of another job are not taken",
     [(STREAM, "    if (!open_ || block.job_low != job_low()) {", "    if (!open_ || (block.job_low != job_low() && !(@))) {")]),
    ("stream: the job's hash must come out",
     [(STREAM, "    hash_ok_ = hasher_.value() == job_;", "    hash_ok_ = hasher_.value() == job_ || (@);")]),
    ("resume: back to before the next pulse",
     [(RUNNER, "motion_.request_resume(next_distance());", "motion_.request_resume(next_distance() + ((@) ? 5e-3 : 0.0));")]),
    ("resume: none by itself after a hold",
     [(CONTROLLER, "            if (stop_reason_ == Event::starved && runner_.can_continue()",
       "            if (((@) || stop_reason_ == Event::starved) && runner_.can_continue()")]),
]


def main():
    root, copies = Path(sys.argv[1]), Path(sys.argv[2])
    texts = {}
    for number, (rule, edits) in enumerate(MUTANTS, 1):
        for file, before, after in edits:
            original = (root / file).read_text(encoding="utf-8")
            if original.count(before) != 1:
                sys.exit(f"mutate: {file}: {before!r} is there {original.count(before)} times, not once; mend the rule "
                         f"'{rule}' in tests/bench/faults/mutate.py")
            texts.setdefault(file, original)
            if texts[file].count(before) != 1:
                sys.exit(f"mutate: {file}: the rule '{rule}' overlaps another one at {before!r}")
            texts[file] = texts[file].replace(before, after.replace("@", f"sc::faults::taken_out({number})"))
    for file in (GUARD, SUPERVISOR, CONTROLLER, WATCH, PLANT, STREAM, RUNNER):
        copy = copies / file
        copy.parent.mkdir(parents=True, exist_ok=True)
        # What asks for a rule is no constant.
        copy.write_text(texts[file].replace("constexpr bool healthy_", "bool healthy_"), encoding="utf-8")
    rows = ",\n        ".join(f'{{{number}, "{rule}"}}' for number, (rule, _) in enumerate(MUTANTS, 1))
    (copies / "mutants.cpp").write_text(f"""namespace sc::faults {{
namespace {{
unsigned gone = 0;
}}
const std::vector<RemovedRule>& removable_rules() {{
    static const std::vector<RemovedRule> kRules{{
        {rows}}};
    return kRules;
}}
void take_out(unsigned rule) noexcept {{ gone = rule; }}
bool taken_out(unsigned rule) noexcept {{ return gone == rule; }}
}}  // namespace sc::faults
""", encoding="utf-8")


if __name__ == "__main__":
    main()

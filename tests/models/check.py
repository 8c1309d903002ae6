#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Checks a model with spin, all of its states: check.py MODEL.pml --work DIR [--define NAME[=V]]... [--ltl NAME]
[--expect error] [--edit FILE FROM TO]...

--edit changes a copy of a source before the model's table is made from it. Exit code 0: what was expected came out."""
import argparse
import pathlib
import re
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parents[2]
STATES = "shared/codes/state.hpp"
TABLE = "firmware/safety/transitions.hpp"
RULE = "firmware/safety/laser_rule.hpp"


def enumerators(text, name):
    body = re.search(rf"enum class {name} : std::uint8_t {{(.*?)\n}};", text, re.DOTALL).group(1)
    return re.findall(r"^\s*(\w+)(?: = \d+)?,", re.sub(r"//.*", "", body), re.MULTILINE)


def states_of(text, predicate):
    """States for which a predicate of transitions.hpp holds."""
    body = re.search(rf"bool {predicate}\(State state\) noexcept {{(.*?)\n?}}\n", text, re.DOTALL).group(1)
    if "switch" in body:
        return re.findall(r"State::(\w+)", body[:body.index("return true")])
    found = re.findall(r"state == State::(\w+)", body)
    for other in re.findall(r"(\w+)\(state\)", body):
        found += states_of(text, other)
    return found


def table(source):
    """The Promela of the state machine and of the laser rule, from the C++ that runs."""
    states, events = enumerators(source[STATES], "State"), enumerators(source[TABLE], "Event")
    rows = re.findall(r"Transition{State::(\w+), Event::(\w+), State::(\w+)}", source[TABLE])
    assert len(states) == 17 and len(events) == 31 and len(rows) > 40, "the table is not read as it was written"
    lines = [f"#define S_{name} {number}" for number, name in enumerate(states)]
    lines += [f"#define E_{name} {number + 1}" for number, name in enumerate(events)]
    for predicate in ("gate_state", "mo_state", "shutter_state", "preview_state", "moving_state", "powered_state"):
        held = states_of(source[TABLE], predicate)
        assert held, predicate
        lines.append(f"#define {predicate.upper()}(s) (" + " || ".join(f"s == S_{name}" for name in held) + ")")
    # One for each event, which the C compiler has to read each time that it is used; and one for commands.
    for event in (*events, ""):
        lines += [f"inline post_{event}() {{" if event else "inline post(event) {", "    ok = true;", "    if"]
        lines += [f"    :: state == S_{a} && {'true' if event else f'event == E_{e}'} -> state = S_{b}"
                  for a, e, b in rows if event in ("", e)]
        lines += ["    :: else -> ok = false", "    fi", "}"]
    rule = re.search(r"bool gate_permitted\(.*?return (.*?);", source[RULE], re.DOTALL).group(1)
    rule = rule.replace("gate_state(c.state)", "GATE_STATE(state)").replace("c.faults == 0", "!faults")
    rule = rule.replace("c.path_speed >= c.path_speed_min", "path_speed_suffices").replace("c.", "")
    lines.append(f"#define GATE_PERMITTED ({' '.join(rule.split())})")
    return "\n".join(lines) + "\n"


def run(command, folder):
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
    return done.returncode, done.stdout + done.stderr


def check(options):
    work = pathlib.Path(options.work)
    work.mkdir(parents=True, exist_ok=True)
    for old in work.glob("*.trail"):
        old.unlink()
    source = {name: (ROOT / name).read_text() for name in (STATES, TABLE, RULE)}
    for name, old, new in options.edit:
        if source[name].count(old) != 1:
            return f"{name} holds '{old}' {source[name].count(old)} times"
        source[name] = source[name].replace(old, new)
    (work / "table.pml").write_text(table(source))
    model = pathlib.Path(options.model).resolve()
    (work / model.name).write_text(model.read_text())
    defines = [f"-D{name}" for name in options.define] + (["-DLIVENESS"] if options.ltl else [])
    code, said = run(["spin", "-a", *defines, model.name], work)
    if code != 0 or "Error" in said:
        return f"spin does not read the model:\n{said}"
    search = ["-DNOREDUCE"] if options.ltl else ["-DSAFETY"]
    code, said = run(["gcc", "-O1", "-w", "-DCOLLAPSE", "-DMEMLIM=3000", *search, "-o", "pan", "pan.c"], work)
    if code != 0:
        return f"the compiler does not read what spin has made:\n{said}"
    _, said = run(["./pan", "-m1000000", *(["-a", "-f", "-N", options.ltl] if options.ltl else [])], work)
    errors = re.search(r"errors: (\d+)", said)
    states = re.search(r"(\d\S*) states, stored", said)
    if errors is None or states is None or "max search depth too small" in said or "Search not completed" in said and \
            errors.group(1) == "0":
        return f"the search is not complete:\n{said}"
    found = re.findall(r"pan:1: (.*)", said)
    print(f"{model.stem} {' '.join(defines)} {options.ltl or ''}: {states.group(1)} states, "
          f"errors: {errors.group(1)} {'; '.join(found)}")
    if options.expect == "error":
        # A model that stops in an unforeseen way proves nothing on the variant.
        wrong = errors.group(1) != "0" and any("assertion" in text or "acceptance cycle" in text for text in found)
        return None if wrong else "the wrong variant passes"
    if errors.group(1) != "0":
        _, trail = run(["spin", "-t", "-p", "-g", *defines, model.name], work)
        return f"the model is wrong:\n{trail[-6000:]}"
    return None


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("model")
    parser.add_argument("--work", required=True)
    parser.add_argument("--define", action="append", default=[])
    parser.add_argument("--ltl")
    parser.add_argument("--expect", choices=("pass", "error"), default="pass")
    parser.add_argument("--edit", nargs=3, action="append", default=[], metavar=("FILE", "FROM", "TO"))
    problem = check(parser.parse_args())
    if problem:
        print(problem)
    sys.exit(1 if problem else 0)


if __name__ == "__main__":
    main()

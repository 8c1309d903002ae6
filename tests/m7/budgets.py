#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Instruction budgets of the controller on the Cortex-M7, and the same bits on board, PC and replay: the figures of
`scribecell bench controller`, each of which must be as asked in tests/bench/asked.toml. Instructions are the same in
every run; what depends on the machine (pc_ticks_per_s) is left out.

budgets.py SCRIBECELL"""
import json
import subprocess
import sys

TIMED = {"pc_ticks_per_s"}
NEEDED = {
    "servo_instructions_max",
    "servo_instructions_max_any",
    "plan_instructions_per_point",
    "tick_instructions_max",
    "split_servo_instructions_max",
    "split_tick_instructions_max",
    "points_per_s",
    "pulses_per_s",
    "hashes_equal",
    "replay_equal",
}


def main():
    run = subprocess.run([sys.argv[1], "bench", "controller", "--json"], capture_output=True, text=True, check=False)
    try:
        figures = json.loads(run.stdout)["figures"]
    except (json.JSONDecodeError, KeyError):
        sys.exit(f"budgets: no figures, exit code {run.returncode}: {run.stdout}{run.stderr}")
    for figure in figures:
        print(f"{figure['name']:<30} {figure['value']:>14.1f}  asked {figure['asked']:.6g}, {figure['better']} is better")
    missing = NEEDED - {figure["name"] for figure in figures}
    if missing:
        sys.exit(f"budgets: no figure {', '.join(sorted(missing))}")
    over = [f["name"] for f in figures if f["name"] not in TIMED and not f["met"]]
    if over:
        sys.exit(f"budgets: not as asked: {', '.join(over)}")


if __name__ == "__main__":
    main()

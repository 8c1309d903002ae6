#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The main job by the host program over CAN to the modelled board, against the simulated cell: the same pulses, and on
the pins of the chip nothing but what the controller asked for.

main_job.py CELL SCRIBECELL [--face DEG]"""

import argparse
import json
import os
import pathlib
import subprocess
import sys
import tempfile
import time

CLEAN = ("gaps", "unlit", "not_allowed", "cancelled", "out_of_rate", "disordered", "wrong_power", "frames_wrong",
         "triggers_wrong", "power_wrong", "lines_wrong", "unsent", "bus_errors", "failed", "violations", "vetoes")


def scribe(program: str, folder: pathlib.Path, options: list[str]) -> dict:
    done = subprocess.run([program, "scribe", "--json", "--out", str(folder), *options], stdout=subprocess.PIPE,
                          stderr=subprocess.PIPE, text=True, timeout=800)
    if done.returncode != 0 or not done.stdout:
        sys.exit(f"main_job: scribe {' '.join(options)} ended with {done.returncode}: {done.stderr}")
    return json.loads(done.stdout)


def on_board(cell: str, program: str, folder: pathlib.Path, options: list[str]) -> dict:
    root = pathlib.Path(os.environ["SCRIBECELL_ROOT"])
    socket = folder / "cell.socket"
    board = subprocess.Popen([cell, "--world", str(root / "boards/sim/world/default/world.toml"), "--lockstep",
                              str(socket)], stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)
    try:
        for _ in range(1000):
            if socket.exists() or board.poll() is not None:
                break
            time.sleep(0.01)
        scribe(program, folder / "board", ["--link", f"lockstep:{socket}", *options])
    finally:
        board.terminate()
        said, _ = board.communicate(timeout=60)
    if board.returncode != 0:
        sys.exit(f"main_job: the board's cell ended with {board.returncode}")
    return json.loads(said)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("cell")
    parser.add_argument("program")
    parser.add_argument("--face", action="append", default=[], help="only this face")
    arguments = parser.parse_args()
    options = [part for face in arguments.face for part in ("--face", face)]
    with tempfile.TemporaryDirectory(prefix="main_job_") as name:
        folder = pathlib.Path(name)
        here = scribe(arguments.program, folder / "sim", options)
        there = on_board(arguments.cell, arguments.program, folder, options)
    print(json.dumps(there, indent=2))
    wrong = [f"{key} is {there[key]}" for key in CLEAN if there[key]]
    for key, asked in (("command_trace_sha256", here["command_trace_sha256"]), ("pulses", here["pulses"]),
                       ("pulses_seen", here["pulses"])):
        if there[key] != asked:
            wrong.append(f"{key} is {there[key]}, in the simulated cell {asked}")
    if wrong:
        sys.exit("main_job: " + "; ".join(wrong))
    print(f"main_job: {here['pulses']} pulses, command_trace_sha256 {here['command_trace_sha256']}")


if __name__ == "__main__":
    main()

# SPDX-License-Identifier: Apache-2.0
"""Interlock and e-stop on simulated GPIO lines, while marking: an edge stops the laser; so does a level whose edges were lost."""
import signal
import time

from support.cell import LONG_JOB, Cell, finished, scribe
from support.gpio import Chip

LIMIT_S = 400
LINES = {"estop": 3, "interlock": 4, "key-setup": 5, "key-production": 6, "red": 10}
ESTOP_OPEN, INTERLOCK_OPEN = "estop", "interlock"


def cell_on(guest, chip):
    wiring = f"{chip.name}:" + ",".join(f"{name}={line}" for name, line in LINES.items())
    return Cell(guest, "can:vcan0", "vcan1", lines=("--gpio", wiring))


def edge(chip, _cell, line):
    chip.pull(line, False)


def pulse(chip, _cell, line):
    """Open and closed again: the level tells nothing, only the event does."""
    chip.pull(line, False)
    time.sleep(0.005)
    chip.pull(line, True)


def lost_edges(chip, cell, line):
    """More edges than the kernel keeps while nobody reads: what is left is the level."""
    cell.controller.send_signal(signal.SIGSTOP)
    for turn in range(41):
        chip.pull(line, turn % 2 == 1)
        time.sleep(0.003)
    assert chip.value(line) == 0
    cell.controller.send_signal(signal.SIGCONT)


def stops(guest, chip, line, open_it, why):
    for name in ("estop", "interlock", "key-production"):
        chip.pull(LINES[name], True)
    chip.pull(LINES["key-setup"], False)
    cell = cell_on(guest, chip)
    job = scribe(cell, LONG_JOB)
    cell.wait_for_state("marking")
    open_it(chip, cell, LINES[line])
    said = finished(job, 1)
    assert why in said, f"{line} {open_it.__name__}: the host says {said[-300:]}"
    figures = cell.figures()
    assert figures["state"] == "fault", f"{line} {open_it.__name__}: state {figures['state']}"
    chip.pull(LINES[line], True)
    figures, report = cell.end()
    assert 0 < report["pulses"] < LONG_PULSES, f"{line} {open_it.__name__}: {report['pulses']} pulses"
    return figures["lines"]


LONG_PULSES = 4_001


def run(guest):
    guest.vcan("vcan0")
    guest.vcan("vcan1")
    chip = Chip(guest, 16)
    lines = stops(guest, chip, "interlock", edge, "interlock")
    assert lines["edges"] >= 1, f"{lines}"
    lines = stops(guest, chip, "estop", pulse, "stop")
    assert lines["glitches"] >= 1 or lines["edges"] >= 2, f"{lines}"
    lines = stops(guest, chip, "interlock", lost_edges, "interlock")
    assert lines["edges"] >= 16, f"{lines}"

# SPDX-License-Identifier: Apache-2.0
"""Interlock and e-stop on simulated GPIO lines, while marking: an edge stops the laser; so does a pulse of which only the edges tell,
and a level of which no edge tells. The job is resumed each time: each pulse once."""
import signal
import time

from support.cell import LONG_JOB, Cell, finished, resume, scribe
from support.gpio import Chip, interrupt_threads

LIMIT_S = 600
LINES = {"estop": 3, "interlock": 4, "key-setup": 5, "key-production": 6, "red": 10}
LONG_PULSES = 4_001
KEPT_EVENTS = 16  # by the kernel, a line
SETTLE_S = 0.01
LIGHT_NS = 1_000  # light follows its trigger by so much
FAULTS = {"estop": 1, "interlock": 2}


def edge(chip, _cell, line):
    chip.pull(line, False)


def pulse_unseen(chip, cell, line):
    """Open and closed again between two looks: the level tells nothing, only the events do."""
    cell.controller.send_signal(signal.SIGSTOP)
    chip.pull(line, False)
    time.sleep(SETTLE_S)
    chip.pull(line, True)
    time.sleep(SETTLE_S)
    cell.controller.send_signal(signal.SIGCONT)


def edge_lost(chip, cell, line):
    """The kernel's room for events is full of rises when the line opens: only the level tells."""
    cell.controller.send_signal(signal.SIGSTOP)
    threads = interrupt_threads("scribecell-rt")
    for _ in range(KEPT_EVENTS + 4):
        chip.blink(line, threads)
    chip.pull(line, False)
    time.sleep(SETTLE_S)
    assert chip.value(line) == 0, "the line is not low"
    cell.controller.send_signal(signal.SIGCONT)


def stopped(cell, chip, job, name, open_it):
    """Opens a line in mid-mark; what the controller has counted of its lines since."""
    what = f"{name}, {open_it.__name__}"
    before = cell.wait_for_state("marking")["lines"]
    open_it(chip, cell, LINES[name])
    said = finished(job, 1)
    assert f"code {FAULTS[name]} " in said, f"{what}: the host says {said[-300:]}"
    figures = cell.figures()
    assert figures["state"] == "fault" and figures["first_fault"] == FAULTS[name], f"{what}: {figures}"
    assert 0 < cell.burnt() < LONG_PULSES, f"{what}: {cell.burnt()} pulses"
    chip.pull(LINES[name], True)
    return {key: value - before[key] for key, value in figures["lines"].items()}


def check_dark(played):
    """From each word of the guard on until it is taken back there is no pulse, but what was triggered just before it."""
    since, words = None, 0
    for time_ns, what, value in played:
        if what == "veto":
            words += value != 0
            since = time_ns if value != 0 else None
        assert what != "pulse" or since is None or time_ns <= since + LIGHT_NS, f"a pulse at {time_ns} ns, the guard's word at {since}"
    assert words >= 3, f"{words} words of the guard"


def run(guest):
    guest.vcan("vcan0")
    guest.vcan("vcan1")
    chip = Chip(guest, 16)
    for name in ("estop", "interlock", "key-production"):
        chip.pull(LINES[name], True)
    chip.pull(LINES["key-setup"], False)
    wiring = f"{chip.name}:" + ",".join(f"{name}={line}" for name, line in LINES.items())
    cell = Cell(guest, "can:vcan0", "vcan1", lines=("--gpio", wiring))
    lines = stopped(cell, chip, scribe(cell, LONG_JOB), "interlock", edge)
    assert lines["edges"] == 1 and lines["glitches"] == 0, f"an edge: {lines}"  # its level may be seen first: missed
    lines = stopped(cell, chip, resume(cell, LONG_JOB), "estop", pulse_unseen)
    assert lines["glitches"] == 1 and lines["missed"] == 0, f"a pulse: {lines}"
    lines = stopped(cell, chip, resume(cell, LONG_JOB), "interlock", edge_lost)
    assert lines["missed"] == 1 and lines["edges"] == 1 and lines["glitches"] == 0, f"a lost edge: {lines}"
    finished(resume(cell, LONG_JOB))
    _figures, report = cell.end()
    check_dark(cell.played())
    assert report["pulses"] == LONG_PULSES, f"{report['pulses']} pulses in all, not {LONG_PULSES}"

# SPDX-License-Identifier: Apache-2.0
"""In mid-job: the host's interface goes down, the drives' queue overflows, their bus goes off. The light goes off each time, and the
job is resumed: each pulse once."""
from support.can import ERROR_BUS_OFF, ERROR_FLAG, ERROR_RESTARTED, Bus
from support.cell import LONG_JOB, Cell, finished, resume, scribe
from support.guest import wait_until

LIMIT_S = 600
LONG_PULSES = 4_001
LINK_LOST, DRIVE_LOST = 10, 6  # shared/codes/codes.hpp


def host_link_down(guest):
    guest.run("ip", "link", "set", "vcan0", "down")


def host_link_up(guest):
    guest.run("ip", "link", "set", "vcan0", "up")


def drive_queue_full(guest):
    guest.run("tc", "qdisc", "add", "dev", "vcan1", "root", "netem", "delay", "250s", "limit", "1")


def drive_queue_free(guest):
    guest.run("tc", "qdisc", "del", "dev", "vcan1", "root")


def drive_bus_off(guest):
    """As a CAN controller does: it tells of it, and sends no more."""
    Bus(guest, "vcan1").send(ERROR_FLAG | ERROR_BUS_OFF, bytes(8))
    drive_queue_full(guest)


def drive_bus_restart(guest):
    drive_queue_free(guest)
    Bus(guest, "vcan1").send(ERROR_FLAG | ERROR_RESTARTED, bytes(8))


def broken_off(guest, cell, job, breaks, mends, fault):
    """A job that is broken off in mid-mark; what is mended after that."""
    cell.wait_for_state("marking")
    breaks(guest)
    finished(job, 1, 300)
    figures = cell.wait_for_state("fault", seconds=300)
    assert figures["first_fault"] == fault, f"{breaks.__name__}: fault {figures['first_fault']}, not {fault}"
    assert 0 < cell.burnt() < LONG_PULSES, f"{breaks.__name__}: {cell.burnt()} pulses"
    mends(guest)
    # A tick waits for answers that went with the fault; the next ones come at once.
    wait_until(lambda: cell.figures()["ticks"] > figures["ticks"] + 50, 300, "ticks after the fault")


def run(guest):
    guest.vcan("vcan0")
    guest.vcan("vcan1")
    cell = Cell(guest, "can:vcan0", "vcan1", answer_ms=5_000)
    broken_off(guest, cell, scribe(cell, LONG_JOB), host_link_down, host_link_up, LINK_LOST)
    broken_off(guest, cell, resume(cell, LONG_JOB), drive_queue_full, drive_queue_free, DRIVE_LOST)
    broken_off(guest, cell, resume(cell, LONG_JOB), drive_bus_off, drive_bus_restart, DRIVE_LOST)
    finished(resume(cell, LONG_JOB), 0, 300)
    figures, report = cell.end(drives_ok=False)  # they tell of frames that found no room
    assert report["pulses"] == LONG_PULSES, f"{report['pulses']} pulses in all, not {LONG_PULSES}"
    link, bus = figures["link"]["can"], figures["drives"]["buses"][0]
    assert link["down"] >= 1 and link["state"] == "active", f"{link}"
    assert bus["full"] >= 1 and bus["bus_offs"] == 1 and bus["restarts"] == 1 and bus["state"] == "active", f"{bus}"

# SPDX-License-Identifier: Apache-2.0
"""In mid-job: the host's interface goes down, a bus-off is told, the drives' queue overflows. The light goes off each time, and the
job is resumed: each pulse once."""

from support.can import ERROR_BUS_OFF, ERROR_FLAG, Bus
from support.cell import LONG_JOB, Cell, finished, in_process, scribe

LIMIT_S = 600


def host_link_down(guest, _cell):
    guest.run("ip", "link", "set", "vcan0", "down")


def host_link_up(guest):
    guest.run("ip", "link", "set", "vcan0", "up")


def drive_queue_full(guest, _cell):
    guest.run("tc", "qdisc", "add", "dev", "vcan1", "root", "netem", "delay", "20s", "limit", "1")


def drive_queue_free(guest):
    guest.run("tc", "qdisc", "del", "dev", "vcan1", "root")


def drive_bus_off(guest, _cell):
    Bus(guest, "vcan1").send(ERROR_FLAG | ERROR_BUS_OFF, bytes(8))


def broken_off(guest, breaks, mends):
    """A job that is broken off by `breaks` and resumed; (figures at the break, figures and report at the end)."""
    cell = Cell(guest, "can:vcan0", "vcan1")
    job = scribe(cell, LONG_JOB)
    cell.wait_for_state("marking")
    breaks(guest, cell)
    said = finished(job, 1, 300)
    broken = cell.wait_for_state("fault", "held_link", "disabled")
    mends(guest)
    finished(scribe(cell, LONG_JOB, "--resume", "--reset-fault"), 0, 300)
    figures, report = cell.end()
    expected = in_process(guest, LONG_JOB)["pulses"]
    assert report["pulses"] == expected, f"{breaks.__name__}: {report['pulses']} pulses in all, not {expected}; {said[-200:]}"
    return broken, figures


def run(guest):
    guest.vcan("vcan0")
    guest.vcan("vcan1")
    broken, figures = broken_off(guest, host_link_down, host_link_up)
    assert figures["link"]["can"]["down"] >= 1, f"{figures['link']}"
    broken, figures = broken_off(guest, drive_queue_full, drive_queue_free)
    bus = figures["drives"]["buses"][0]
    assert bus["full"] >= 1 and broken["state"] == "fault", f"{bus}, state {broken['state']}"
    broken, figures = broken_off(guest, drive_bus_off, lambda _guest: None)
    bus = figures["drives"]["buses"][0]
    assert bus["bus_offs"] == 1 and broken["state"] == "fault", f"{bus}, state {broken['state']}"

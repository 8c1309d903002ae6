# SPDX-License-Identifier: Apache-2.0
"""Host, controller, drives and event device as processes over virtual buses, the host classic and FD: the set-points and laser
events of the same job in one process."""
from support.cell import JOB, Cell, assert_same, finished, in_process, scribe

LIMIT_S = 400


def run(guest):
    expected = in_process(guest, JOB)
    host, drives = guest.vcan("vcan0"), guest.vcan("vcan1", fd=False)
    for link in (f"can:{host}", f"can:{host}?fd=1"):
        cell = Cell(guest, link, drives)
        finished(scribe(cell, JOB))
        figures, report = cell.end()
        assert_same(report, expected)
        bus = figures["drives"]["buses"][0]
        assert figures["first_fault"] == 0 and figures["allocations"] == 0, f"{link}: {figures}"
        assert bus["dropped"] == bus["malformed"] == bus["failed"] == 0, f"{link}: {bus}"

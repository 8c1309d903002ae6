# SPDX-License-Identifier: Apache-2.0
"""The same over emulated Kvaser cards: drives at the other end of one bus, the host at the other end of a second."""
from support.cell import JOB, Cell, assert_same, finished, in_process, scribe

LIMIT_S = 300


class CardCell(Cell):
    def host_link(self):
        return "can:can3"


def run(guest):
    expected = in_process(guest, JOB)
    for number in range(4):
        guest.card(number, queue=256)
    cell = CardCell(guest, "can:can2", "can0", "can1")
    finished(scribe(cell, JOB))
    figures, report = cell.end()
    assert_same(report, expected)
    assert figures["drives"]["buses"][0]["state"] == "active" and figures["first_fault"] == 0, f"{figures}"

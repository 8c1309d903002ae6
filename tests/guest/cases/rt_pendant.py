# SPDX-License-Identifier: Apache-2.0
"""A pendant on USB moves the axes of a controller process, is unplugged in mid-jog, and comes back."""
import time

from cases.pendant import Host, goes_to, place
from support.cell import Cell
from support.guest import wait_until
from support.hid import Pendant

LIMIT_S = 300


def run(guest):
    guest.vcan("vcan0")
    guest.vcan("vcan1")
    cell = Cell(guest, "can:vcan0", "vcan1")
    pendant = Pendant(guest)
    host = Host(guest, "--link", cell.link, "--home", "--dead-man-s", "10")
    host.wait("steps: 0.001: 1 um")
    wait_until(pendant.device.opened.is_set, 60, "the pendant's opening")
    pendant.axis("z")
    pendant.feed("0.1")
    host.wait("Z: 100 um a detent")
    wait_until(pendant.shown, 60, "the display")
    start = place(pendant, 2)
    pendant.wheel(-1)
    goes_to(pendant, 2, start - 0.1)
    pendant.feed("1")
    host.wait("Z: 1000 um a detent")
    start = place(pendant, 2)
    pendant.wheel(2)
    cell.wait_for_state("jogging")
    pendant.device.unplug()
    host.wait("stopped: the pendant is unplugged")
    cell.wait_for_state("idle")
    back = Pendant(guest, axis="z", feed="1")
    host.wait("turn its axis knob")
    back.feed("0.1")
    wait_until(back.shown, 60, "the display")
    stopped = place(back, 2)
    assert -0.0015 < stopped - start < 1.9, f"unplugged, it went {stopped - start} mm of 2"
    back.wheel(5)
    assert abs(place(back, 2) - stopped) < 0.0015, "a pendant that came back moved an axis"
    back.axis("off")
    back.axis("z")
    time.sleep(0.3)
    back.wheel(1)
    goes_to(back, 2, stopped + 0.1)
    result = host.result()
    assert result["unplugs"] == 1 and result["detents"]["unarmed"] == 5, f"counted {result}"
    figures, _report = cell.end()
    assert figures["first_fault"] == 0, f"{figures}"

# SPDX-License-Identifier: Apache-2.0
"""A pendant on USB moves the axes of a simulated cell, is unplugged in mid-jog, comes back, and moves nothing until it is armed."""
import json
import signal
import time

from support.guest import wait_until
from support.hid import Pendant

LIMIT_S = 300
TRIES = 4


class Host:
    """`scribecell pendant`, and what it has said."""

    def __init__(self, guest, *options):
        self.process = guest.start(guest.program("scribecell"), "pendant", "--json", *options)

    def said(self, text, count=1):
        return self.process.err.read_text(encoding="utf-8").count(text) >= count

    def wait(self, text, count=1):
        wait_until(lambda: self.said(text, count) or self.process.poll() is not None, 90, f"'{text}'")
        assert self.said(text, count), f"it ended: {self.process.err.read_text(encoding='utf-8')[-400:]}"

    def result(self):
        self.process.send_signal(signal.SIGINT)
        code = self.process.wait(90)
        assert code == 0, f"it ended with {code}: {self.process.err.read_text(encoding='utf-8')[-400:]}"
        return json.loads(self.process.out.read_text(encoding="utf-8"))


def place(pendant, line, settled=1.0):
    """A line of the display once it has stood still."""
    last, since = None, time.monotonic()
    while time.monotonic() - since < settled:
        time.sleep(0.05)
        shown = pendant.shown()
        if shown and shown[0][line] != last:
            last, since = shown[0][line], time.monotonic()
    return last


def goes_to(pendant, line, mm):
    wait_until(lambda: abs(pendant.shown()[0][line] - mm) < 0.0015, 60, f"{mm:.4f} mm on the display")


def unplugged_in_mid_jog(guest, host, pendant, tries):
    """How far it went of 2 mm, and the pendant that was plugged in again."""
    pendant.feed("1")
    host.wait("X: 1000 um a detent", tries)
    start = place(pendant, 0)
    pendant.wheel(2)
    time.sleep(0.03 * tries)
    pendant.device.unplug()
    host.wait("stopped: the pendant is unplugged", tries)
    back = Pendant(guest, axis="x", feed="1")
    host.wait("turn its axis knob", tries)
    back.feed("0.1")
    wait_until(back.shown, 60, "the display")
    end = place(back, 0)
    for _ in range(3):
        back.wheel(5)
    assert abs(place(back, 0) - end) < 0.0015, "a pendant that came back moved an axis"
    back.axis("off")
    back.axis("x")
    return end - start, back


def run(guest):
    pendant = Pendant(guest)
    host = Host(guest, "--link", "sim:")
    host.wait("steps: 0.001: 1 um")
    wait_until(pendant.device.opened.is_set, 60, "the pendant's opening")
    pendant.axis("z")
    pendant.feed("0.1")
    host.wait("Z: 100 um a detent")
    wait_until(pendant.shown, 60, "the display")
    start = place(pendant, 2)
    pendant.wheel(-3)
    goes_to(pendant, 2, start - 0.3)
    pendant.feed("60%")
    host.wait("Z: 5 um a detent")
    pendant.wheel(4)
    goes_to(pendant, 2, start - 0.28)
    assert pendant.shown()[2] == 5, f"the display shows a step of {pendant.shown()[2]} um, not 5"
    pendant.press("feed-")
    wait_until(lambda: pendant.shown()[1] == 90, 30, "90 % on the display")
    pendant.axis("x")
    cut = []
    for tries in range(1, TRIES + 1):
        moved, pendant = unplugged_in_mid_jog(guest, host, pendant, tries)
        assert -0.0015 < moved < 2.0015, f"unplugged, it went {moved} mm of 2"
        cut.append(moved)
    assert min(cut) < 1.9, f"unplugging never stopped a move of 2 mm before its end: {cut}"
    start = place(pendant, 0)
    pendant.feed("0.1")
    pendant.wheel(1)
    goes_to(pendant, 0, start + 0.1)
    result = host.result()
    assert result["unplugs"] == TRIES and result["detents"]["unarmed"] >= TRIES * 15, f"counted {result}"
    assert result["override_percent"] == 90 and result["malformed"] == 0, f"it ended as {result}"

# SPDX-License-Identifier: Apache-2.0
"""A simulated GPIO chip (gpio-sim): its input lines are pulled from here, and seen by programs as real lines."""
import os
import re
from pathlib import Path

CONFIG = Path("/sys/kernel/config/gpio-sim")
ABOVE_INTERRUPTS = 80  # whose threads have 50


def interrupt_threads(program):
    """Threads of the kernel that note the edges for a program; their names are cut short."""
    threads = [path for path in Path("/proc").glob("[0-9]*/comm")
               if re.match(r"irq/\d+-" + program[:6], path.read_text(encoding="utf-8"))]
    assert threads, f"no interrupt of a line is {program}'s"
    return [int(path.parent.name) for path in threads]


class Chip:
    def __init__(self, guest, lines, name="cell"):
        self._folder = CONFIG / name
        bank = self._folder / "bank0"
        bank.mkdir(parents=True)
        guest.at_end(self._remove)
        (bank / "num_lines").write_text(str(lines), encoding="ascii")
        (self._folder / "live").write_text("1", encoding="ascii")
        self.name = (bank / "chip_name").read_text(encoding="ascii").strip()
        self.path = f"/dev/{self.name}"
        device = (self._folder / "dev_name").read_text(encoding="ascii").strip()
        self._lines = Path(f"/sys/devices/platform/{device}/{self.name}")

    def pull(self, line, high):
        (self._lines / f"sim_gpio{line}/pull").write_text("pull-up" if high else "pull-down", encoding="ascii")

    def value(self, line):
        return int((self._lines / f"sim_gpio{line}/value").read_text(encoding="ascii"))

    def blink(self, line, threads):
        """Low and high again as one interrupt, which tells of a rise alone. `threads`: see interrupt_threads."""
        everywhere, here = os.sched_getaffinity(0), {max(os.sched_getaffinity(0))}
        for thread in threads:
            os.sched_setaffinity(thread, here)
        os.sched_setaffinity(0, here)
        os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(ABOVE_INTERRUPTS))
        try:
            self.pull(line, False)
            self.pull(line, True)
        finally:  # now they run, at once
            os.sched_setscheduler(0, os.SCHED_OTHER, os.sched_param(0))
            os.sched_setaffinity(0, everywhere)

    def _remove(self):
        (self._folder / "live").write_text("0", encoding="ascii")
        os.rmdir(self._folder / "bank0")
        os.rmdir(self._folder)

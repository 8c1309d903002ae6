# SPDX-License-Identifier: Apache-2.0
"""A simulated GPIO chip (gpio-sim): its input lines are pulled from here, and seen by programs as real lines."""
import os
from pathlib import Path

CONFIG = Path("/sys/kernel/config/gpio-sim")


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

    def _remove(self):
        (self._folder / "live").write_text("0", encoding="ascii")
        os.rmdir(self._folder / "bank0")
        os.rmdir(self._folder)

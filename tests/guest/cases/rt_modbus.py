# SPDX-License-Identifier: Apache-2.0
"""Modbus RTU on a pair of pseudo-terminals: what pymodbus serves as a distance sensor arrives at the host, and its going too."""
import json
import signal

from support.cell import Cell
from support.guest import wait_until
from support.line import Line

LIMIT_S = 240
DISTANCE_MM = 125.003  # support/modbus_slave.py, within 4 um


def sensor_of(guest, cell):
    text = guest.run(guest.program("scribecell"), "sensors", "--json", "--link", cell.link, ok=(0, 1))
    found = json.loads(text)
    return next(one for one in found["sensors"] if one["name"] == "y")


def run(guest):
    guest.vcan("vcan0")
    guest.vcan("vcan1")
    line = Line(guest)
    slave = guest.start("/usr/bin/python3", "-B", guest.root / "tests/guest/support/modbus_slave.py", line.ends[1])
    wait_until(lambda: "ready" in slave.out.read_text(encoding="utf-8") or slave.poll() is not None, 60, "pymodbus")
    cell = Cell(guest, "can:vcan0", "vcan1", more=("--sensors", f"0={line.ends[0]}"))
    found = wait_until(lambda: (one := sensor_of(guest, cell)).get("code", 1) == 0 and one, 60, "a good value")
    assert abs(found["value_mm"] - DISTANCE_MM) < 0.004, f"the sensor says {found}"
    slave.send_signal(signal.SIGTERM)
    slave.wait(30)
    wait_until(lambda: sensor_of(guest, cell).get("code", 0) != 0, 60, "the loss of the sensor")
    cell.end()

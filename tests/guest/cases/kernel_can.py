# SPDX-License-Identifier: Apache-2.0
"""Frames go over a virtual bus, classic and FD, over two cards on one bus, and error frames are seen."""
from support.can import ERROR_BUS_OFF, ERROR_FLAG, Bus


def exchange(guest, one, other, frames, fd):
    a, b = Bus(guest, one, fd=fd), Bus(guest, other, fd=fd)
    for number, data in frames:
        a.send(number, data)
        got = b.receive()
        assert got == (number, data), f"{one}: sent {number:x} {data.hex()}, came {got[0]:x} {got[1].hex()}"


def run(guest):
    classic = [(0x80, b""), (0x181, b"\x37\x06\x00\x01\x02\x03"), (0x7FF, bytes(range(8)))]
    guest.vcan("vcan0")
    exchange(guest, "vcan0", "vcan0", classic, False)
    exchange(guest, "vcan0", "vcan0", classic + [(0x201, bytes(range(64))), (0x202, bytes(range(12)))], True)
    for one, other in ((0, 1), (2, 3)):
        exchange(guest, guest.card(one), guest.card(other), classic, False)
    Bus(guest, "can1").send(0x123, b"\x01")
    assert Bus(guest, "can3").waiting() == [], "a frame crossed from one bus to the other"
    watcher = Bus(guest, "vcan0", errors=True)
    Bus(guest, "vcan0").send(ERROR_FLAG | ERROR_BUS_OFF, bytes(8))
    got = watcher.receive()
    assert got[0] == ERROR_FLAG | ERROR_BUS_OFF, f"an error frame came as {got[0]:x}"

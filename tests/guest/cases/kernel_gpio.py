# SPDX-License-Identifier: Apache-2.0
"""Edges of simulated lines come through libgpiod, in order; beyond 16 they are lost, and the level is still right."""
import ctypes
import time

from support.gpio import Chip

RISING, FALLING = 1, 2
SETTLE_S = 0.01  # two edges at once are one interrupt


class Time(ctypes.Structure):
    _fields_ = [("s", ctypes.c_long), ("ns", ctypes.c_long)]


class Event(ctypes.Structure):
    _fields_ = [("time", Time), ("type", ctypes.c_int), ("offset", ctypes.c_int)]


def library():
    gpiod = ctypes.CDLL("libgpiod.so.2")
    gpiod.gpiod_chip_open.restype = gpiod.gpiod_chip_get_line.restype = ctypes.c_void_p
    gpiod.gpiod_chip_get_line.argtypes = [ctypes.c_void_p, ctypes.c_uint]
    gpiod.gpiod_line_request_both_edges_events.argtypes = [ctypes.c_void_p, ctypes.c_char_p]
    gpiod.gpiod_line_event_wait.argtypes = [ctypes.c_void_p, ctypes.POINTER(Time)]
    gpiod.gpiod_line_event_read.argtypes = [ctypes.c_void_p, ctypes.POINTER(Event)]
    gpiod.gpiod_line_get_value.argtypes = gpiod.gpiod_line_release.argtypes = [ctypes.c_void_p]
    gpiod.gpiod_chip_close.argtypes = [ctypes.c_void_p]
    return gpiod


def events(gpiod, line):
    found = []
    while gpiod.gpiod_line_event_wait(line, ctypes.byref(Time(0, 200_000_000))) == 1:
        event = Event()
        assert gpiod.gpiod_line_event_read(line, ctypes.byref(event)) == 0, "an event could not be read"
        found.append(event.type)
    return found


def run(guest):
    chip, gpiod = Chip(guest, 4), library()
    handle = gpiod.gpiod_chip_open(chip.path.encode())
    assert handle, f"{chip.path} cannot be opened"
    line = gpiod.gpiod_chip_get_line(handle, 2)
    assert gpiod.gpiod_line_request_both_edges_events(line, b"test") == 0, "the line could not be requested"
    try:
        for high in (True, False, True):
            chip.pull(2, high)
            time.sleep(SETTLE_S)
        found = events(gpiod, line)
        assert found == [RISING, FALLING, RISING], f"edges came as {found}"
        for turn in range(40):
            chip.pull(2, turn % 2 == 1)
            time.sleep(SETTLE_S)
        chip.pull(2, False)
        time.sleep(SETTLE_S * 20)
        found = events(gpiod, line)
        assert len(found) == 16, f"of 41 edges unread the kernel kept {len(found)}, not 16"
        assert gpiod.gpiod_line_get_value(line) == 0, "the level is not that of the last edge"
    finally:
        gpiod.gpiod_line_release(line)
        gpiod.gpiod_chip_close(handle)

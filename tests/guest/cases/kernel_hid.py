# SPDX-License-Identifier: Apache-2.0
"""A made-up pendant is found by hidapi under its numbers; reports go both ways; unplugged, a read fails."""
import ctypes

from support.guest import wait_until
from support.hid import Device


def library():
    hid = ctypes.CDLL("libhidapi-hidraw.so.0")
    hid.hid_open.restype = ctypes.c_void_p
    hid.hid_open.argtypes = [ctypes.c_ushort, ctypes.c_ushort, ctypes.c_wchar_p]
    hid.hid_read_timeout.argtypes = [ctypes.c_void_p, ctypes.c_char_p, ctypes.c_size_t, ctypes.c_int]
    hid.hid_close.argtypes = [ctypes.c_void_p]
    assert hid.hid_init() == 0
    return hid


def run(guest):
    hid, pendant = library(), Device(guest)

    handle = wait_until(lambda: hid.hid_open(0x10CE, 0xEB93, None), what="the device")
    sent = bytes([0x04, 0x5A, 0x00, 0x00, 0x0D, 0x11, 0x01, 0x5A])
    pendant.report(sent)
    buffer = ctypes.create_string_buffer(64)
    count = hid.hid_read_timeout(handle, buffer, 64, 20000)
    assert buffer.raw[:count] == sent, f"a report came as {buffer.raw[:max(count, 0)].hex()}"
    hid.hid_send_feature_report.argtypes = [ctypes.c_void_p, ctypes.c_char_p, ctypes.c_size_t]
    block = bytes([0x06, 0xFE, 0xFD, 0xFE, 0x81, 0x01, 0x02, 0x03])
    assert hid.hid_send_feature_report(handle, block, len(block)) == len(block), "a feature report was refused"
    assert pendant.features == [block], f"a feature report came as {pendant.features}"
    pendant.unplug()
    assert hid.hid_read_timeout(handle, buffer, 64, 20000) == -1, "a read of an unplugged device did not fail"
    hid.hid_close(handle)

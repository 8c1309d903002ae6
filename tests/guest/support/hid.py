# SPDX-License-Identifier: Apache-2.0
"""A HID device that a program makes up (uhid): programs see it as one on USB, with a hidraw file."""
import os
import select
import struct

CREATE2, DESTROY, INPUT2 = 11, 1, 12
START, OPEN, CLOSE, OUTPUT, GET_REPORT, GET_REPORT_REPLY, SET_REPORT, SET_REPORT_REPLY = 2, 4, 5, 6, 9, 10, 13, 14
BUS_USB = 3
EVENT_SIZE = 4380

# Collection of one input report (id 4, 7 bytes) and one feature report (id 6, 7 bytes), as the pendant's own.
PENDANT = bytes.fromhex("0600ff 0901 a101 1500 26ff00 7508"
                        "8504 9507 0900 8102"
                        "8506 9507 0900 b102 c0")


class Device:
    def __init__(self, guest, vendor=0x10CE, product=0xEB93, name="XHC WHB04B-6", descriptor=PENDANT):
        self._file = os.open("/dev/uhid", os.O_RDWR | os.O_CLOEXEC)
        guest.at_end(self.unplug)
        self.features = []  # feature reports that were set, without their id
        body = struct.pack("<128s64s64sHHIIII4096s", name.encode(), b"", b"", len(descriptor), BUS_USB, vendor, product, 0, 0,
                           descriptor)
        os.write(self._file, struct.pack("<I", CREATE2) + body)

    def report(self, data):
        self.serve(0)
        os.write(self._file, struct.pack("<IH4096s", INPUT2, len(data), data))

    def serve(self, seconds):
        """Answers the kernel's questions that are there, and waits `seconds` at most for the first."""
        while self._file is not None and select.select([self._file], [], [], seconds)[0]:
            event = os.read(self._file, EVENT_SIZE)
            kind = struct.unpack_from("<I", event)[0]
            if kind == SET_REPORT:
                request, _number, _type, size = struct.unpack_from("<IBBH", event, 4)
                self.features.append(event[13:12 + size])
                os.write(self._file, struct.pack("<IIH", SET_REPORT_REPLY, request, 0))
            elif kind == GET_REPORT:
                request = struct.unpack_from("<I", event, 4)[0]
                os.write(self._file, struct.pack("<IIHH", GET_REPORT_REPLY, request, 5, 0))
            seconds = 0

    def unplug(self):
        if self._file is not None:
            os.close(self._file)  # the kernel removes the device with it
            self._file = None

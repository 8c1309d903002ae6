# SPDX-License-Identifier: Apache-2.0
"""A HID device that a program makes up (uhid): programs see it as one on USB, with a hidraw file."""
import os
import select
import struct
import threading

CREATE2, DESTROY, INPUT2 = 11, 1, 12
START, OPEN, CLOSE, OUTPUT, GET_REPORT, GET_REPORT_REPLY, SET_REPORT, SET_REPORT_REPLY = 2, 4, 5, 6, 9, 10, 13, 14
BUS_USB = 3
EVENT_SIZE = 4380

# Collection of one input report (id 4, 7 bytes) and one feature report (id 6, 7 bytes), as the pendant's own.
PENDANT = bytes.fromhex("0600ff 0901 a101 1500 26ff00 7508"
                        "8504 9507 0900 8102"
                        "8506 9507 0900 b102 c0")


class Device:
    """One that is plugged in until `unplug`. A thread answers what the kernel asks."""

    def __init__(self, guest, vendor=0x10CE, product=0xEB93, name="XHC WHB04B-6", descriptor=PENDANT):
        self._file = os.open("/dev/uhid", os.O_RDWR | os.O_CLOEXEC)
        guest.at_end(self.unplug)
        self.features = []  # feature reports that were set, with their number in front
        self.opened = threading.Event()
        self._over = False
        body = struct.pack("<128s64s64sHHIIII4096s", name.encode(), b"", b"", len(descriptor), BUS_USB, vendor, product, 0, 0,
                           descriptor)
        os.write(self._file, struct.pack("<I", CREATE2) + body)
        self._thread = threading.Thread(target=self._serve, daemon=True)
        self._thread.start()

    def report(self, data):
        os.write(self._file, struct.pack("<IH4096s", INPUT2, len(data), data))

    def _serve(self):
        while not self._over:
            if not select.select([self._file], [], [], 0.05)[0]:
                continue
            event = os.read(self._file, EVENT_SIZE)
            kind = struct.unpack_from("<I", event)[0]
            if kind == OPEN:
                self.opened.set()
            elif kind == SET_REPORT:
                request, _number, _type, size = struct.unpack_from("<IBBH", event, 4)
                self.features.append(event[12:12 + size])
                os.write(self._file, struct.pack("<IIH", SET_REPORT_REPLY, request, 0))
            elif kind == GET_REPORT:
                request = struct.unpack_from("<I", event, 4)[0]
                os.write(self._file, struct.pack("<IIHH", GET_REPORT_REPLY, request, 5, 0))

    def unplug(self):
        """The kernel removes the device when its file is closed."""
        if not self._over:
            self._over = True
            self._thread.join()
            os.close(self._file)


class Pendant:
    """What a person does with an XHC WHB04B-6. Bytes: docs/pendant.md."""

    AXES = {"off": 0x06, "x": 0x11, "y": 0x12, "z": 0x13, "c": 0x16}
    FEEDS = {"0.001": 0x0D, "0.01": 0x0E, "0.1": 0x0F, "1": 0x10, "60%": 0x1A, "lead": 0x1C}
    KEYS = {"stop": 0x02, "start": 0x03, "feed+": 0x04, "feed-": 0x05, "fn": 0x0C, "probe-z": 0x0D, "reset": 0x01}

    def __init__(self, guest, axis="off", feed="0.01"):
        self.device = Device(guest)
        self._axis, self._feed, self._random = self.AXES[axis], self.FEEDS[feed], 0x31

    def _send(self, key=0, detents=0):
        self._random = (self._random * 5 + 77) & 0xFF
        self.device.report(bytes([4, self._random, key, 0, self._feed, self._axis, detents & 0xFF, self._random & 0xFE]))

    def axis(self, name):
        self._axis = self.AXES[name]
        self._send()

    def feed(self, name):
        self._feed = self.FEEDS[name]
        self._send()

    def wheel(self, detents):
        self._send(detents=detents)

    def press(self, key):
        self._send(key=self.KEYS[key])
        self._send()

    def shown(self):
        """(lines in mm, feed, speed) of the display; None before it was whole."""
        features = list(self.device.features)
        for end in range(len(features), 2, -1):
            block = b"".join(feature[1:8] for feature in features[end - 3:end])
            if block[:2] == b"\xfe\xfd" and all(feature[0] == 6 for feature in features[end - 3:end]):
                break
        else:
            return None
        lines = []
        for whole, part in (struct.unpack_from("<HH", block, 4 + 4 * line) for line in range(3)):
            size = whole + (part & 0x7FFF) / 1e4
            lines.append(-size if part & 0x8000 else size)
        return (lines, *struct.unpack_from("<HH", block, 16))

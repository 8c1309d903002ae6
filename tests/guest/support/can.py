# SPDX-License-Identifier: Apache-2.0
"""CAN frames of the kernel, for cases that look at a bus or disturb it."""
import socket
import struct

FRAME = struct.Struct("<IBB2x8s")
FD_FRAME = struct.Struct("<IBB2x64s")
ERR_FILTER = 2  # CAN_RAW_ERR_FILTER, which this Python has no name for
ERROR_FLAG = 0x20000000
ERROR_BUS_OFF = 0x00000040
ERROR_RESTARTED = 0x00000100


class Bus:
    """A raw socket on one interface. Frames are (id, data)."""

    def __init__(self, guest, name, fd=False, errors=False):
        self._socket = socket.socket(socket.AF_CAN, socket.SOCK_RAW, socket.CAN_RAW)
        guest.at_end(self._socket.close)
        if fd:
            self._socket.setsockopt(socket.SOL_CAN_RAW, socket.CAN_RAW_FD_FRAMES, 1)
        if errors:
            self._socket.setsockopt(socket.SOL_CAN_RAW, ERR_FILTER, 0x1FFFFFFF)
        self._socket.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4 << 20)
        self._socket.bind((name,))

    def send(self, number, data):
        if len(data) > 8:
            self._socket.send(FD_FRAME.pack(number, len(data), 1, data))
        else:
            self._socket.send(FRAME.pack(number, len(data), 0, data))

    def receive(self, seconds=20.0):
        self._socket.settimeout(seconds)
        got = self._socket.recv(FD_FRAME.size)
        number, length, _, data = (FD_FRAME if len(got) == FD_FRAME.size else FRAME).unpack(got)
        return number, data[:length]

    def waiting(self):
        """All frames that are there by now."""
        frames = []
        try:
            while True:
                frames.append(self.receive(0.001))
        except (TimeoutError, BlockingIOError):
            return frames

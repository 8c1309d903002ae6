# SPDX-License-Identifier: Apache-2.0
"""boards/socketcan over a virtual bus, classic and FD, over two cards, with a full queue."""
import os


def test(guest, name, **variables):
    guest.run(guest.build / "tests/guest_socketcan", f"--gtest_filter=KernelCan.{name}", env={**os.environ, **variables})


def run(guest):
    guest.vcan("vcan0")
    guest.vcan("vcan1", fd=False)
    frames = "FramesCrossTheBusBothWaysInOrder"
    test(guest, frames, SC_CAN_A="vcan0", SC_CAN_B="vcan0", SC_CAN_FD="1")
    test(guest, frames, SC_CAN_A="vcan1", SC_CAN_B="vcan1")
    test(guest, frames, SC_CAN_A=guest.card(0), SC_CAN_B=guest.card(1))
    guest.run("tc", "qdisc", "add", "dev", "vcan1", "root", "netem", "delay", "5s", "limit", "2")
    test(guest, "AFullQueueIsToldAndCounted", SC_CAN_SLOW="vcan1")
    test(guest, "AnUnknownInterfaceIsRefusedByName")

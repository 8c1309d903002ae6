# SPDX-License-Identifier: Apache-2.0
"""Slaves of pymodbus on a serial device: its framer, its decoder, its registers. usage: foreign_slave.py DEVICE

Slave 1 is a triangulation sensor (input registers 1 to 6), 2 and 3 are phase sensors (holding registers from 1), 4 has
a block that is too small, so that pymodbus answers with an exception. Addresses are those on the wire.
"""

import os
import sys
import termios
import tty

from pymodbus.datastore import ModbusSequentialDataBlock, ModbusServerContext, ModbusSlaveContext
from pymodbus.factory import ServerDecoder
from pymodbus.framer.rtu_framer import ModbusRtuFramer


def slave(inputs, holdings):
    return ModbusSlaveContext(
        ir=ModbusSequentialDataBlock(0, inputs), hr=ModbusSequentialDataBlock(0, holdings), zero_mode=True
    )


SLAVES = ModbusServerContext(
    {
        1: slave([0, 602, 17, 10602, 100, 50, 8192], [0] * 64),
        2: slave([0] * 8, [0, 0, 1853, 0] + [0] * 32),
        3: slave([0] * 8, [0, 0x8000, 23, 0] + [0] * 32),
        4: slave([0], [0]),
    },
    single=False,
)


def main():
    line = os.open(sys.argv[1], os.O_RDWR | os.O_NOCTTY)
    tty.setraw(line, termios.TCSANOW)
    framer = ModbusRtuFramer(ServerDecoder())

    def answer(request):
        if request.unit_id not in SLAVES.slaves():
            return
        response = request.execute(SLAVES[request.unit_id])
        response.unit_id = request.unit_id
        response.transaction_id = request.transaction_id
        os.write(line, framer.buildPacket(response))

    print("ready", flush=True)
    while True:
        framer.processIncomingPacket(os.read(line, 256), answer, list(range(1, 248)), single=False)


main()

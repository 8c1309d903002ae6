# SPDX-License-Identifier: Apache-2.0
"""A triangulation sensor by pymodbus on a serial device, address 1: 100 mm + 50 mm * (8192..8194) / 16384, never twice the same
in turn, as a living sensor's value. usage: modbus_slave.py DEVICE"""
import os
import sys
import termios
import tty

from pymodbus.datastore import ModbusSequentialDataBlock, ModbusServerContext, ModbusSlaveContext
from pymodbus.factory import ServerDecoder
from pymodbus.framer.rtu_framer import ModbusRtuFramer


class Living(ModbusSequentialDataBlock):
    turn = 0

    def getValues(self, address, count=1):
        Living.turn += 1
        self.values[6] = 8192 + Living.turn % 3
        return super().getValues(address, count)


def main():
    line = os.open(sys.argv[1], os.O_RDWR | os.O_NOCTTY)
    tty.setraw(line, termios.TCSANOW)
    inputs = Living(0, [0, 602, 17, 10602, 100, 50, 8192] + [0] * 8)
    sensor = ModbusSlaveContext(ir=inputs, hr=ModbusSequentialDataBlock(0, [0] * 64), zero_mode=True)
    slaves = ModbusServerContext({1: sensor}, single=False)
    framer = ModbusRtuFramer(ServerDecoder())

    def answer(request):
        if request.unit_id == 1:
            response = request.execute(slaves[1])
            response.unit_id, response.transaction_id = 1, request.transaction_id
            os.write(line, framer.buildPacket(response))

    print("ready", flush=True)
    while True:
        framer.processIncomingPacket(os.read(line, 256), answer, list(range(1, 248)), single=False)


main()

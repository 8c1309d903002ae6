# SPDX-License-Identifier: Apache-2.0
"""A serial line between two programs: two pseudo-terminals, and a thread that hands bytes from one to the other."""
import os
import select
import threading
import tty


class Line:
    def __init__(self, guest):
        self._masters, self.ends, slaves = [], [], []
        for _ in range(2):
            master, slave = os.openpty()
            tty.setraw(slave)
            self._masters.append(master)
            slaves.append(slave)  # kept open, so that the line outlives a program that closes its end
            self.ends.append(os.ttyname(slave))
        self._over = False
        self._thread = threading.Thread(target=self._carry, daemon=True)
        self._thread.start()

        def close():
            self._over = True
            self._thread.join()
            for file in [*self._masters, *slaves]:
                os.close(file)

        guest.at_end(close)

    def _carry(self):
        other = dict(zip(self._masters, reversed(self._masters)))
        while not self._over:
            for ready in select.select(self._masters, [], [], 0.05)[0]:
                os.write(other[ready], os.read(ready, 4096))

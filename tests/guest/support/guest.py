# SPDX-License-Identifier: Apache-2.0
"""What a case has of the guest: programs of the build, network interfaces, a folder to keep files in."""
import os
import signal
import subprocess
import time
from pathlib import Path


class Guest:
    def __init__(self, build, root, folder):
        self.build, self.root, self.folder = build, root, folder
        self._processes = []
        self._at_end = []
        folder.mkdir(exist_ok=True)

    def at_end(self, action):
        """`action` is called when the case has ended, the last one first."""
        self._at_end.append(action)

    def program(self, name):
        return str(self.build / "bin" / name)

    def start(self, *command, **options):
        """Starts a process that ends with the case at the latest. Its output goes to a file of the case's folder."""
        name = f"{len(self._processes)}-{Path(command[0]).name}"
        with open(self.folder / f"{name}.out", "wb") as out, open(self.folder / f"{name}.err", "wb") as err:
            process = subprocess.Popen([str(word) for word in command], stdin=subprocess.DEVNULL, stdout=out, stderr=err,
                                       cwd="/run", **options)
        process.out, process.err = (self.folder / f"{name}.{end}" for end in ("out", "err"))
        self._processes.append(process)
        return process

    def run(self, *command, ok=(0,), timeout=100, **options):
        """Runs a command to its end; its standard output. It must end with a code of `ok`."""
        done = subprocess.run([str(word) for word in command], stdin=subprocess.DEVNULL, capture_output=True, text=True,
                              check=False, timeout=timeout, cwd="/run", **options)
        assert done.returncode in ok, f"{' '.join(map(str, command))} ended with {done.returncode}: " \
            f"{(done.stderr or done.stdout)[-600:]}"
        return done.stdout

    def close(self):
        for process in self._processes:
            if process.poll() is None:
                process.kill()
            process.wait()
        for action in reversed(self._at_end):
            action()

    def vcan(self, name, fd=True, queue=None):
        """A virtual CAN bus that is there and up while the case runs. `queue`: length of the send queue in frames."""
        self.run("ip", "link", "add", "dev", name, "type", "vcan")
        self.at_end(lambda: self.run("ip", "link", "del", name))
        if fd:
            self.run("ip", "link", "set", name, "mtu", "72")
        if queue:
            self.run("ip", "link", "set", name, "txqueuelen", queue)
        self.run("ip", "link", "set", name, "up")
        return name

    def card(self, number, bit_rate=1_000_000, queue=10):
        """An emulated Kvaser card, up: 0 and 1 are on one bus, 2 and 3 on another."""
        name = f"can{number}"
        self.run("ip", "link", "set", name, "txqueuelen", queue)
        self.run("ip", "link", "set", name, "type", "can", "bitrate", bit_rate)
        self.run("ip", "link", "set", name, "up")
        self.at_end(lambda: self.run("ip", "link", "set", name, "down"))
        on_first_processor(name)
        return name


def on_first_processor(device):
    """Its interrupts are served by processor 0. A card of the guest sends the next frame as soon as the one before is noted, and
    holds five that nobody has read: where sender and receiver are served by two processors, of which a busy build machine holds
    one back for a while, frames are lost."""
    lines = Path("/proc/interrupts").read_text(encoding="ascii").splitlines()
    numbers = [line.split(":")[0].strip() for line in lines if device in line.replace(",", " ").split()]
    assert numbers, f"{device} has no interrupt"
    for number in numbers:
        Path(f"/proc/irq/{number}/smp_affinity").write_text("1", encoding="ascii")


def wait_until(condition, seconds=30.0, what="what was waited for"):
    """Asks again and again until `condition()` holds; its value. Wall time says nothing here, so the limit is generous."""
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        value = condition()
        if value:
            return value
        time.sleep(0.02)
    raise AssertionError(f"{what} did not come within {seconds} s")


def stop(process, seconds=30):
    """Asks a process to end (SIGTERM) and returns its exit code."""
    if process.poll() is None:
        os.kill(process.pid, signal.SIGTERM)
    return process.wait(seconds)

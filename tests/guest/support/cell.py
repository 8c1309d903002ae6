# SPDX-License-Identifier: Apache-2.0
"""A cell of processes: the controller (scribecell-rt), its drives (scribecell-drive), its event device (scribecell-events)."""
import itertools
import json
import os
import signal
from pathlib import Path

from support.guest import wait_until

JOB = "tests/guest/data/job.toml"
LONG_JOB = "tests/guest/data/long_job.toml"
HASHES = ("command_trace_sha256", "set_point_sha256", "laser_sha256")
_numbers = itertools.count()


def last_json(text):
    """The last JSON object of a line of its own in what a program printed; None before one is whole."""
    for line in reversed(text.splitlines()):
        if line.startswith("{") and line.endswith("}"):
            return json.loads(line)
    return None


class Cell:
    def __init__(self, guest, link, bus, drives=None, lines=("--lines-closed",), more=(),
                 answer_ms=20_000):
        """`bus`: the interface that the controller's drive bus is; `drives`: that of the drives, if it is another;
        `answer_ms`: how long a tick waits for drives, on a busy machine for seconds."""
        self.guest, self.link = guest, link
        self.name = f"{guest.folder.name}-{next(_numbers)}"
        self.drives = guest.start(guest.program("scribecell-drive"), "--can", drives or bus,
                                  *[word for node in (1, 2, 3, 4) for word in ("--node", node)])
        socket = f"/run/{self.name}.socket"
        self._trace = Path(f"/run/{self.name}.trace")
        self.events = guest.start(guest.program("scribecell-events"), socket, "--once", "--json", "--watchdog", "0",
                                  "--out", self._trace)
        self._ready(self.drives, "ready")
        wait_until(lambda: os.path.exists(socket), 60, "the event device's socket")
        self.controller = guest.start(guest.program("scribecell-rt"), "--drive-bus", f"can:{bus}", "--link", link,
                                      "--events", socket, "--pace", "drives", "--no-rt", "--json", "--answer-timeout", answer_ms, *lines,
                                      *more)
        wait_until(lambda: "host on" in self.controller.err.read_text(encoding="utf-8") or self.controller.poll() is not None,
                   60, "the controller")
        assert self.controller.poll() is None, self.controller.err.read_text(encoding="utf-8")[-400:]

    @staticmethod
    def _ready(process, word):
        wait_until(lambda: word in process.out.read_text(encoding="utf-8") or process.poll() is not None, 60,
                   f"'{word}' of {process.args[0]}")
        assert process.poll() is None, process.err.read_text(encoding="utf-8")[-400:]

    def figures(self):
        """What the controller has measured so far."""
        before = self.controller.out.read_text(encoding="utf-8").count("\n")
        self.controller.send_signal(signal.SIGUSR1)
        wait_until(lambda: self.controller.out.read_text(encoding="utf-8").count("\n") > before
                   or self.controller.poll() is not None, 30, "figures of the controller")
        return last_json(self.controller.out.read_text(encoding="utf-8"))

    def wait_for_state(self, *states, seconds=400):
        return wait_until(lambda: (figures := self.figures())["state"] in states and figures, seconds,
                          f"state {' or '.join(states)}")

    def played(self):
        """What the event device has played, (ns, what, value) each; whole up to where the light went off last."""
        part = Path(f"{self._trace}.part")
        lines = (part if part.exists() else self._trace).read_text(encoding="utf-8").splitlines()
        events = [line.split() for line in lines if not line.startswith("#")]
        return [(int(words[0]), words[1], int(words[2])) for words in events if len(words) == 3]

    def burnt(self):
        """Pulses on the part, as a person counts them there."""
        return sum(what == "pulse" for _, what, _ in self.played())

    def host(self, *words, link=None):
        """Starts `scribecell` on this cell."""
        return self.guest.start(self.guest.program("scribecell"), *words, "--link", link or self.host_link())

    def host_link(self):
        return self.link

    def end(self, drives_ok=True):
        """(figures of the controller, report of the event device) once all have ended as asked."""
        self.controller.send_signal(signal.SIGTERM)
        code = self.controller.wait(60)
        figures = last_json(self.controller.out.read_text(encoding="utf-8"))
        assert code == 0, f"scribecell-rt ended with {code}: {self.controller.err.read_text(encoding='utf-8')[-300:]}"
        assert self.events.wait(60) == 0, self.events.err.read_text(encoding="utf-8")[-300:]
        self.drives.send_signal(signal.SIGTERM)
        assert self.drives.wait(60) == 0 or not drives_ok, self.drives.out.read_text(encoding="utf-8")[-300:]
        return figures, json.loads(self.events.out.read_text(encoding="utf-8"))


def scribe(cell, job, *words):
    """Starts a job; see `finished`."""
    root = cell.guest.root
    journal = f"/run/{cell.name}.sqlite"  # SQLite's locks do not work in the shared folder
    return cell.host("scribe", root / job, "--json", "--journal", journal, *words)


def resume(cell, job):
    """Goes on with the first path of a job that was broken off, where pulses are uncertain with those on the part."""
    return scribe(cell, job, "--resume", "--reset-fault", "--confirm-uncertain", f"0/0/{cell.burnt()}")


def finished(process, code=0, seconds=200):
    ended = process.wait(seconds)
    assert ended == code, f"the host ended with {ended}, not {code}: {process.err.read_text(encoding='utf-8')[-600:]}"
    return process.err.read_text(encoding="utf-8")


def in_process(guest, job):
    """What the same job gives in the simulated cell, in one process: made once a guest."""
    kept = guest.folder.parent / f"in-process-{os.path.basename(job)}.json"
    if not kept.exists():
        out = Path("/run/in-process-" + os.path.basename(job))
        guest.run(guest.program("scribecell"), "scribe", guest.root / job, "--out", out, "--json", timeout=200)
        kept.write_text((out / "cell.json").read_text(encoding="utf-8"), encoding="utf-8")
    return json.loads(kept.read_text(encoding="utf-8"))


def assert_same(report, expected):
    """Set-points and laser events are those of the simulated cell, to the last."""
    assert report["gaps"] == 0, f"{report['gaps']} windows of laser events are missing"
    assert expected["pulses"] > 500 and report["pulses"] == expected["pulses"], \
        f"{report['pulses']} pulses, in one process {expected['pulses']}"
    for name in HASHES:
        assert report[name] == expected[name], f"{name} differs: {report[name][:12]}, in one process {expected[name][:12]}"

#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Cases against real kernel interfaces: CAN, GPIO, HID and serial lines of Debian's PREEMPT_RT kernel in QEMU.

guest.py BUILD [--case NAME...] [--json FILE] [--list]

BUILD is a build folder; its programs run inside as they are. Each case is printed as it ends, ok or failed and why; what its
programs printed stays in BUILD/guest. Time in the guest means nothing: cases judge order, counts and bytes.

  guest.py build/dev                          all cases
  guest.py build/dev --case can_classic       one of them
  guest.py build/dev --json cases.json        also {"tried": n, "passed": n, "cases": [{"name", "ok", "seconds", "text"}]}

Exit codes: 0 all passed; 1 a case failed or the guest did not come up; 2 bad usage, or packages are missing."""
import argparse
import fcntl
import json
import os
import re
import shutil
import subprocess
import sys
import threading
from pathlib import Path

from archive import Archive
from kernel import KernelError, ready_kernel

HERE = Path(__file__).resolve().parent
TIME_LIMIT_S = 900  # of the whole run: far beyond what it takes
QEMU = "qemu-system-x86_64"


def say(text):
    print(f"guest: {text}", flush=True)


def first_file_system(kernel):
    """What the kernel unpacks before there is a root: busybox, modules and the first process."""
    archive = Archive()
    for folder in ("bin", "dev", "proc", "sys", "host", "modules"):
        archive.folder(folder)
    archive.file("bin/busybox", (kernel / "busybox").read_bytes(), 0o755)
    archive.file("bin/cat", b"#!/bin/busybox sh\nexec /bin/busybox cat \"$@\"\n", 0o755)
    for module in sorted((kernel / "modules").iterdir()):
        archive.file(f"modules/{module.name}", module.read_bytes())
    archive.file("runner", str(HERE / "inside.py").encode())
    archive.file("init", (HERE / "init").read_bytes(), 0o755)
    return archive.finished()


def command(kernel, initrd, share):
    """Two buses with two CAN cards each, the build machine's files read-only, one folder to write to."""
    cards = []
    for bus in range(2):
        cards += ["-object", f"can-bus,id=canbus{bus}"]
        cards += ["-device", f"kvaser_pci,canbus=canbus{bus}"] * 2
    return [QEMU, "-accel", "tcg,thread=multi", "-cpu", "max", "-smp", "2", "-m", "1024", "-nodefaults", "-no-user-config",
            "-display", "none", "-no-reboot", "-serial", "stdio", "-net", "none", *cards,
            "-fsdev", "local,id=root,path=/,security_model=none,readonly=on,multidevs=remap",
            "-device", "virtio-9p-pci,fsdev=root,mount_tag=root",
            "-fsdev", f"local,id=results,path={share},security_model=none",
            "-device", "virtio-9p-pci,fsdev=results,mount_tag=results",
            "-kernel", str(kernel / "vmlinuz"), "-initrd", str(initrd),
            "-append", "console=ttyS0 quiet panic=-1 mitigations=off rdinit=/init"]


def boot(kernel, share, request, log):
    """Runs the guest to its end. Prints what the cases print; all of the console goes to `log`."""
    initrd = share.parent / "initrd"
    initrd.write_bytes(first_file_system(kernel))
    (share / "request.json").write_text(json.dumps(request), encoding="utf-8")
    with open(log, "w", encoding="utf-8") as kept, subprocess.Popen(
            command(kernel, initrd, share), stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
            text=True, errors="replace") as process:
        watchdog = threading.Timer(TIME_LIMIT_S, process.kill)
        watchdog.start()
        try:
            for line in process.stdout:
                kept.write(line)
                shown = re.search(r"(?:ok|failed) +\w+: .*|\|.*|guest: .*|Kernel panic.*", line)
                if shown:
                    print(shown[0].rstrip(), flush=True)
        finally:
            watchdog.cancel()
            process.kill()


def results(share, cases):
    """What the guest wrote, one entry a case; a case without one did not end."""
    path = share / "results.jsonl"
    lines = path.read_text(encoding="utf-8").splitlines() if path.is_file() else []
    found = {entry["name"]: entry for entry in map(json.loads, lines)}
    lost = {"ok": False, "seconds": 0.0, "text": "the guest ended before this case did"}
    return [found.get(name, {"name": name, **lost}) for name in cases]


def all_cases():
    return sorted(path.stem for path in (HERE / "cases").glob("*.py"))


def arguments():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("build", type=Path)
    parser.add_argument("--case", action="append", default=[], metavar="NAME")
    parser.add_argument("--json", type=Path, metavar="FILE")
    parser.add_argument("--list", action="store_true", help="only name the cases")
    return parser.parse_args()


def main():
    asked = arguments()
    cases = all_cases()
    if asked.list:
        print("\n".join(cases))
        return 0
    unknown = [name for name in asked.case if name not in cases]
    if unknown:
        say(f"there is no case '{unknown[0]}'; there are: {', '.join(cases)}")
        return 2
    if not (asked.build / "bin").is_dir():
        say(f"{asked.build} is no build folder: it has no bin")
        return 2
    if not shutil.which(QEMU):
        say(f"{QEMU} is missing; as root: apt-get install -y --no-install-recommends qemu-system-x86 make xz-utils libelf1 iproute2")
        return 2
    cases = [name for name in cases if name in asked.case] if asked.case else cases
    try:
        kernel = ready_kernel(say)
    except KernelError as error:
        say(str(error))
        return 2
    share = asked.build.resolve() / "guest/files"
    share.parent.mkdir(exist_ok=True)
    with open(share.parent / ".lock", "w", encoding="utf-8") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        shutil.rmtree(share, ignore_errors=True)
        share.mkdir()
        request = {"root": str(HERE.parents[1]), "build": str(asked.build.resolve()), "cases": cases}
        boot(kernel, share, request, share.parent / "console.log")
        done = results(share, cases)
    passed = sum(entry["ok"] for entry in done)
    if asked.json:
        written = asked.json.with_suffix(".new")
        written.write_text(json.dumps({"tried": len(done), "passed": passed, "cases": done}, indent=1) + "\n", encoding="utf-8")
        os.replace(written, asked.json)
    print(f"guest_cases: {passed} of {len(done)} passed; files of the cases and console: {share.parent}")
    return 0 if passed == len(done) else 1


if __name__ == "__main__":
    sys.exit(main())

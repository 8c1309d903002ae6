#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""One log, replayed by the controllers of many builds: each must give the recorded outputs bit by bit, and all the same
hashes. Each build runs twice, its memory and stack full of another pattern each time, so that a byte that is used
before it is written shows too. Prints a row a build.

hashes.py LOG --build NAME PROGRAM ... [--recorded NAME LOG] [--needs NAME FLAG,FLAG] [--must-differ NAME]

--recorded: a log that another controller has made of the same job; the first build must replay it to the same hashes.
--needs: a row that is not run, and not counted as equal, where the processor lacks one of the flags.
--must-differ: a test of this test. Passes if this build alone is found to differ."""
import argparse
import json
import subprocess
import sys
from pathlib import Path

PAINTS = ("0", "165")
HASHES = ("command_trace_sha256", "outputs_sha256", "inner_sha256")


def processor_flags():
    for line in Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines():
        if line.startswith("flags"):
            return set(line.split(":", 1)[1].split())
    return set()


def replay(program, log, paint):
    """(result, what is wrong or None)"""
    run = subprocess.run([program, log, "--json", "--paint", paint], capture_output=True, text=True, check=False)
    try:
        result = json.loads(run.stdout)
    except json.JSONDecodeError:
        return None, f"no result, exit code {run.returncode}: {run.stderr.strip()}"
    if result["difference"]:
        difference = result["difference"]
        return result, f"differs from tick {difference['tick']} on: {', '.join(difference['parts']) or 'outputs'}"
    if run.returncode != 0 or not result["equal"] or result["end"] != "closed":
        return result, f"exit code {run.returncode}, log {result['end']}: {run.stderr.strip()}"
    return result, None


def row(program, log, expected):
    """(hashes or None, what is wrong or None) of a build, all paints."""
    if not Path(program).exists():
        return None, f"{program} is not there; ./test builds it"
    hashes = None
    for paint in PAINTS:
        result, wrong = replay(program, log, paint)
        found = tuple(result[key] for key in HASHES) if result else None
        hashes = hashes or found
        if not wrong and (expected or hashes) != found:
            wrong = "every tick's outputs are equal, what they were rounded from is not"
        if wrong:
            return hashes, f"{wrong} (memory painted with {int(paint):#04x})"
    return hashes, None


def check(log, builds, recorded, needs):
    """Names of the builds that differ; prints the table."""
    flags = processor_flags()
    expected, bad, rows = None, [], []
    for name, program in builds:
        missing = [flag for flag in needs.get(name, "").split(",") if flag and flag not in flags]
        if missing:
            rows.append((name, "-", "-", "-", f"not run: this processor has no {', '.join(missing)}"))
            continue
        hashes, wrong = row(program, log, expected)
        if wrong:
            bad.append(name)
        elif expected is None:
            expected = hashes
        rows.append((name, *(h[:16] for h in hashes or ("-", "-", "-")), wrong or "equal"))
    for name, other in recorded:
        if Path(other).exists():
            hashes, wrong = row(builds[0][1], other, expected)
        else:
            hashes, wrong = None, f"{other} is not there"
        if wrong:
            bad.append(name)
        rows.append((name, *(h[:16] for h in hashes or ("-", "-", "-")), wrong or "equal"))
    rows.insert(0, ("build", "command_trace", "outputs", "inner", "result"))
    width = max(len(r[0]) for r in rows)
    for name, commands, outputs, inner, result in rows:
        print(f"{name:<{width}}  {commands:<16}  {outputs:<16}  {inner:<16}  {result}")
    for key, value in zip(HASHES, expected or ()):
        print(f"{key} {value}")
    return bad


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("log")
    parser.add_argument("--build", nargs=2, action="append", required=True, metavar=("NAME", "PROGRAM"))
    parser.add_argument("--recorded", nargs=2, action="append", default=[], metavar=("NAME", "LOG"))
    parser.add_argument("--needs", nargs=2, action="append", default=[], metavar=("NAME", "FLAGS"))
    parser.add_argument("--must-differ", metavar="NAME")
    arguments = parser.parse_args()
    bad = check(arguments.log, arguments.build, arguments.recorded, dict(arguments.needs))
    if arguments.must_differ:
        if bad != [arguments.must_differ]:
            sys.exit(f"hashes: '{arguments.must_differ}' alone should have been found, found: {bad or 'none'}")
        print(f"'{arguments.must_differ}' was found, as it must be")
    elif bad:
        sys.exit(f"hashes: not the same: {', '.join(bad)}")


if __name__ == "__main__":
    main()

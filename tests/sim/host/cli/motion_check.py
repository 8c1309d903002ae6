#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""What the trajectory planner emits for a polyline, judged by `scribecell check`, which shares no code with it: every
1 kHz sample within the limits, the polyline followed within its tolerance and to its end. Then the same samples against
a lower jerk, and against a lower tolerance: they must be rejected, or the check proves nothing.

motion_check.py MOTION_BENCH SCRIBECELL POLYLINE"""
import subprocess
import sys
import tempfile
from pathlib import Path

# Speed, acceleration and jerk, m and s, as the planner was given them.
GIVEN = (0.2, 5.0, 200.0)
TOLERANCE_MM = 0.01


def run(*words):
    return subprocess.run([str(w) for w in words], capture_output=True, text=True, check=False)


def check(scribecell, samples, polyline, limits, tolerance):
    return run(scribecell, "check", samples, "--path", polyline, "--tolerance", tolerance, "--path-speed", limits[0],
               "--limits", ",".join(str(v) for v in limits))


def main():
    bench, scribecell, polyline = sys.argv[1:]
    with tempfile.TemporaryDirectory() as folder:
        samples = Path(folder) / "samples.csv"
        made = run(bench, "--input", polyline, "--samples", samples)
        if made.returncode != 0:
            sys.exit(f"motion_check: {made.stdout}{made.stderr}")
        judged = check(scribecell, samples, polyline, GIVEN, TOLERANCE_MM)
        print(made.stdout + judged.stdout + judged.stderr)
        if judged.returncode != 0:
            sys.exit("motion_check: the samples are rejected")
        for name, limits, tolerance in (
            ("jerk", (GIVEN[0], GIVEN[1], GIVEN[2] * 0.98), TOLERANCE_MM),
            ("tolerance", GIVEN, TOLERANCE_MM * 0.4),
        ):
            if check(scribecell, samples, polyline, limits, tolerance).returncode != 1:
                sys.exit(f"motion_check: a lower {name} is not found broken")


if __name__ == "__main__":
    main()

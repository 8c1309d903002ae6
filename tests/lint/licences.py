#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Nothing under the GPL is linked into what ships: looked up in the libraries a program loads, directly or not.

licences.py PROGRAM..."""
import re
import subprocess
import sys

from project import finish

# Ceres itself is BSD, but Debian's is linked to SuiteSparse.
GPL = re.compile(r"\b(lib(?:ceres|CGAL\w*|cholmod|spqr|umfpack|cxsparse|gsl|fftw3\w*|readline|gmpxx))\.so")


def findings_in(loaded, program):
    return [f"{program} loads {name}, which is under the GPL or brings it" for name in sorted(set(GPL.findall(loaded)))]


def check(program):
    done = subprocess.run(["ldd", program], capture_output=True, text=True, check=False)
    if "libc.so" not in done.stdout:
        return [f"{program}: ldd cannot tell what it loads: {done.stdout}{done.stderr}"]
    return findings_in(done.stdout, program)


if __name__ == "__main__":
    if len(sys.argv) < 2:
        finish("licences", ["no program given"])
    finish("licences", [finding for program in sys.argv[1:] for finding in check(program)])

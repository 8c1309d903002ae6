#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""All C++ files are as clang-format-19 would write them. `format.py --fix` rewrites them."""
import re
import subprocess
import sys

from project import ROOT, cxx_files, finish

FORMAT = "clang-format-19"
_PLACE = re.compile(r"^([^\s:]+):(\d+):\d+: (?:error|warning): ", re.MULTILINE)


def check(root, fix=False):
    """One finding a file, at its first place."""
    files = [str(path) for path in cxx_files(root)]
    mode = ["-i"] if fix else ["--dry-run", "-Werror", "--ferror-limit=0"]
    findings = {}
    for start in range(0, len(files), 50):
        done = subprocess.run([FORMAT, *mode, *files[start:start + 50]], cwd=root, capture_output=True, text=True,
                              check=False)
        places = _PLACE.findall(done.stderr)
        for path, line in places:
            findings.setdefault(path, f"{path}:{line}: not as {FORMAT} writes it")
        if done.returncode and not places:
            findings[start] = done.stderr.strip()
    return list(findings.values())


if __name__ == "__main__":
    FINDINGS = check(ROOT, fix="--fix" in sys.argv[1:])
    if FINDINGS:
        FINDINGS.append("rewrite them with: python3 tests/lint/format.py --fix")
    finish("format", FINDINGS)

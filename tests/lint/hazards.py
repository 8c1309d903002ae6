#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Every test that docs/hazards.md names is there, and every hazard names one."""
import re

from project import ROOT, finish

PAGE = "docs/hazards.md"
TEST = re.compile(r"^TEST(?:_F|_P)?\(\s*(\w+)\s*,\s*(\w+)\s*\)", re.MULTILINE)
NAME = re.compile(r"`(\w+\.\w+)`")


def tests_in(root):
    found = set()
    for file in (root / "tests").rglob("*.cpp"):
        found.update(".".join(pair) for pair in TEST.findall(file.read_text(encoding="utf-8")))
    return found


def check(root):
    page = root / PAGE
    if not page.exists():
        return [f"{PAGE} is not there"]
    there = tests_in(root)
    findings = []
    rows = 0
    for number, line in enumerate(page.read_text(encoding="utf-8").splitlines(), 1):
        cells = [cell.strip() for cell in line.split("|")[1:-1]]
        if len(cells) != 3 or cells[0] == "hazard" or set(cells[0]) <= {"-"}:
            continue
        rows += 1
        names = NAME.findall(cells[2])
        if not names:
            findings.append(f"{PAGE}:{number}: '{cells[0]}' names no test")
        findings += [f"{PAGE}:{number}: no test is called {name}" for name in names if name not in there]
    return findings if rows else [f"{PAGE} has no table of hazards"]


if __name__ == "__main__":
    finish("hazards", check(ROOT))

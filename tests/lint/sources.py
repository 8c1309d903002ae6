#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The rules of single files: licence line, size, include guard, names, no paths of one machine, no leftovers."""
import re

from project import CXX, ROOT, finish, project_files

SPDX = "SPDX-License-Identifier: Apache-2.0"
SOURCE_SUFFIXES = CXX | {".c", ".h", ".S", ".ld", ".py", ".sh", ".cmake", ".ts", ".js"}
MAX_LINES = 600
MACHINE_PATH = re.compile(r"(?<![\w.$}~>-])/(?:work|root|home)/\w")
# Assembled, so that this file does not find itself.
LEFTOVER = re.compile(r"\b(" + "|".join(["TO" + "DO", "FIX" + "ME", "X" + "XX"]) + r")\b")
NOLINT = re.compile(r"NOLINT(?:NEXTLINE|BEGIN)?\b(?!END)(.*)")
SNAKE = re.compile(r"^[a-z0-9_]+\.[ch]pp$")


def is_source(path, text):
    return path.suffix in SOURCE_SUFFIXES or path.name == "CMakeLists.txt" or text.startswith("#!")


def source_findings(path, text):
    lines = text.splitlines()
    first = lines[1:2] if text.startswith("#!") else lines[:1]
    if not first or SPDX not in first[0]:
        yield f"{path}:1: the licence line is missing: '{SPDX}'"
    if len(lines) > MAX_LINES:
        yield f"{path}:{MAX_LINES}: {len(lines)} lines; split it, {MAX_LINES} is the limit"
    if text and not text.endswith("\n"):
        yield f"{path}:{len(lines)}: no newline at the end"
    for number, line in enumerate(lines, 1):
        if line.rstrip() != line:
            yield f"{path}:{number}: blanks at the end of the line"
        if "\t" in line:
            yield f"{path}:{number}: tab"
        if LEFTOVER.search(line):
            yield f"{path}:{number}: leftover: finish it, or file an issue"


def cxx_findings(path, text):
    if path.suffix == ".hpp" and "\n#pragma once\n" not in text:
        yield f"{path}:1: no #pragma once"
    if not SNAKE.match(path.name):
        yield f"{path}:1: file names are snake_case"
    for number, line in enumerate(text.splitlines(), 1):
        match = NOLINT.search(line)
        if match and not re.match(r"\([\w,.* -]+\): \w", match.group(1)):
            yield f"{path}:{number}: NOLINT names its check and gives a reason: NOLINT(check): reason"


def check(root):
    findings = []
    for path in project_files(root):
        raw = (root / path).read_bytes()
        try:
            text = raw.decode("utf-8")
        except UnicodeDecodeError:
            continue
        for number, line in enumerate(text.splitlines(), 1):
            if MACHINE_PATH.search(line):
                findings.append(f"{path}:{number}: a path of one machine")
        if is_source(path, text):
            findings += source_findings(path, text)
        if path.suffix in CXX:
            findings += cxx_findings(path, text)
    return findings


if __name__ == "__main__":
    finish("sources", check(ROOT))

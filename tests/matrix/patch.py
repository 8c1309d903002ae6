#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""A copy of a source with one text replaced by another: how the tests break real control code on purpose. The text must
be there exactly once, so that a break cannot rot into a copy of what is right.

patch.py SOURCE COPY FROM TO"""
import sys
from pathlib import Path


def main():
    source, copy, before, after = sys.argv[1:]
    text = Path(source).read_text(encoding="utf-8")
    found = text.count(before)
    if found != 1:
        sys.exit(f"patch: {source}: {before!r} is there {found} times, not once; mend the break in tests/matrix/breaks.cmake")
    Path(copy).parent.mkdir(parents=True, exist_ok=True)
    Path(copy).write_text(text.replace(before, after), encoding="utf-8")


if __name__ == "__main__":
    main()

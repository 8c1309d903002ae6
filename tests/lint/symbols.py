#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""What the libraries of shared/ and firmware/ may need from outside themselves: a short list, looked up in the object
code. A heap call, a throw, a function of the mathematics library or of I/O is on none of it, however it was written.

symbols.py ARCHIVE..."""
import subprocess
import sys

from project import finish

# What a compiler puts in by itself, and what a freestanding C library has.
ALLOWED = {
    "memcpy", "memmove", "memset", "memcmp", "bcmp", "strlen", "abort",
    "_GLOBAL_OFFSET_TABLE_", "__stack_chk_fail", "__cxa_pure_virtual",
    # The size bits of 64-bit integer and floating-point arithmetic on 32-bit cores.
    "__udivdi3", "__divdi3", "__umoddi3", "__moddi3", "__muldi3",
}


def symbols(archive):
    """(defined, {undefined: object file}) of an archive."""
    defined, undefined = set(), {}
    listing = subprocess.run(["nm", "-A", "--no-demangle", str(archive)], capture_output=True, text=True, check=True)
    for line in listing.stdout.splitlines():
        place, _, rest = line.rpartition(":")
        kind, name = rest.split()[-2:]
        if kind == "U":
            undefined.setdefault(name, place)
        elif kind not in "wv":
            defined.add(name)
    return defined, undefined


def demangle(name):
    return subprocess.run(["c++filt", name], capture_output=True, text=True, check=True).stdout.strip()


def check(archives):
    defined, undefined = set(ALLOWED), {}
    for archive in archives:
        own, needed = symbols(archive)
        defined |= own
        undefined |= needed
    return [f"{place}: needs '{demangle(name)}', which is not in shared/ or firmware/ and not on the list of symbols.py"
            for name, place in sorted(undefined.items()) if name not in defined]


if __name__ == "__main__":
    if len(sys.argv) < 2:
        finish("symbols", ["no archive given"])
    finish("symbols", check(sys.argv[1:]))

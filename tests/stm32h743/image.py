#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""What the image for the STM32H743 is made of, read from the file and from what the compiler left beside the objects.

image.py BUILD    the vector table, where sections lie, budgets of boards/stm32h743/image/README.md, stack frames, and
                  that nothing brings a heap, exceptions or an exit along"""
import re
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
README = ROOT / "boards/stm32h743/image/README.md"
IMAGE = "bin/scribecell-stm32h743.elf"
TOOL = "arm-none-eabi-"
FORBIDDEN = re.compile(r"^(malloc|free|_sbrk|exit|_exit|atexit|__cxa_(throw|atexit|guard_acquire|pure_virtual)|"
                       r"_Zn[wa]|_Zd[la]|printf|puts|sin|cos|sqrt|pow|__aeabi_d(mul|div)|__aeabi_f(mul|div))")
EXCEPTIONS, INTERRUPTS = 16, 150
STORED = [".vectors", ".text", ".rodata", ".ARM.exidx", ".init_array", ".itcm", ".data"]
SLOTS = {0x08020000, 0x08100000}
SLOT_BYTES = 384 * 1024
DTCM, DTCM_BYTES = 0x20000000, 128 * 1024


def run(tool, *arguments):
    return subprocess.run([TOOL + tool, *map(str, arguments)], capture_output=True, text=True, check=True).stdout


def limits():
    rows = re.findall(r"^\| `(\w+)` \| ([\d ]+) \|", README.read_text(encoding="utf-8"), re.MULTILINE)
    return {name: int(number.replace(" ", "")) for name, number in rows}


def sections(image):
    rows = re.findall(r"^\s+\d+\s+(\S+)\s+([0-9a-f]{8})\s+([0-9a-f]{8})\s+([0-9a-f]{8})", run("objdump", "-h", image),
                      re.MULTILINE)
    return {name: (int(size, 16), int(address, 16), int(load, 16)) for name, size, address, load in rows}


def symbols(image):
    rows = (line.split() for line in run("nm", image).splitlines())
    return {row[-1]: int(row[0], 16) for row in rows if len(row) == 3}


def words(image, section):
    text = run("objdump", "-s", "-j", section, image)
    data = "".join("".join(re.match(r"^ [0-9a-f]+ ((?:[0-9a-f]{2,8} ?){1,4})", line)[1].split())
                   for line in text.splitlines() if re.match(r"^ [0-9a-f]{7,8} ", line))
    raw = bytes.fromhex(data)
    return [int.from_bytes(raw[i:i + 4], "little") for i in range(0, len(raw), 4)]


def check_vectors(image, placed, named):
    table, findings = words(image, ".vectors"), []
    size, address, _ = placed[".vectors"]
    if address not in SLOTS or size != 4 * (EXCEPTIONS + INTERRUPTS):
        findings.append(f".vectors: {size} bytes at {address:#x}, not the whole table at the start of a slot")
    if table[0] != named["stack_top"] or not DTCM < table[0] <= DTCM + DTCM_BYTES:
        findings.append(f"the first stack is {table[0]:#x}, not stack_top in DTCM")
    if table[1] != named["reset_handler"] | 1:
        findings.append("the second vector is not reset_handler")
    for number, handler in enumerate(table[1:], 1):
        if handler % 2 == 0 or not address <= handler < address + SLOT_BYTES:
            findings.append(f"vector {number} is {handler:#x}: no Thumb code of this slot")
    # Non-maskable, hard, memory, bus and usage faults, and the warning of the window watchdog.
    findings += [f"vector {number} is not fault_handler" for number in (2, 3, 4, 5, 6, EXCEPTIONS)
                 if table[number] != named["fault_handler"] | 1]
    if named["vectors_in_ram"] % 1024 != 0 or not DTCM <= named["vectors_in_ram"] < DTCM + DTCM_BYTES:
        findings.append("the vectors in force do not lie in DTCM at a multiple of 1024")
    return findings


def check_places(placed, named):
    findings = []
    if named["stack_bottom"] != DTCM:
        findings.append("the stack is not the lowest in DTCM")
    if named["itcm_begin"] < 0x100:
        findings.append("code lies at null")
    stored = [placed[name] for name in STORED if placed.get(name, (0,))[0] > 0]
    used = {"flash": max(load + size for size, _, load in stored) - min(load for _, _, load in stored),
            "itcm": named["itcm_end"] - named["itcm_begin"],
            "dtcm": named["bss_end"] - DTCM}
    for name, value in used.items():
        print(f"{name}: {value} of {limits()[name]}")
        if value > limits()[name]:
            findings.append(f"{name}: {value} is more than {limits()[name]}")
    return findings


def check_frames(build):
    limit, findings, seen = limits()["frame"], [], 0
    for path in build.rglob("*stm32h743*/**/*.su"):
        for line in path.read_text(encoding="utf-8").splitlines():
            where, size, kind = line.split("\t")
            seen += 1
            if kind != "static" or int(size) > limit:
                findings.append(f"{where}: frame of {size} bytes ({kind}), {limit} is the limit")
    return findings or ([] if seen else ["no frames at all"])


def main():
    if len(sys.argv) != 2:
        sys.exit("usage: image.py BUILD")
    build = Path(sys.argv[1])
    image = build / IMAGE
    if not image.is_file():
        sys.exit(f"{image} is missing: cmake --preset h743 && cmake --build --preset h743")
    placed, named = sections(image), symbols(image)
    findings = check_vectors(image, placed, named) + check_places(placed, named) + check_frames(build)
    findings += [f"'{name}' is in it" for name in named if FORBIDDEN.match(name)]
    if run("nm", "--undefined-only", image).split():
        findings.append("something is undefined")
    print("\n".join(findings))
    sys.exit(1 if findings else 0)


if __name__ == "__main__":
    main()

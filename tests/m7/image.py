#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""What the image for the Cortex-M7 is made of, read from the file and from what the compiler left beside the objects.

image.py symbols BUILD    no heap, exit, exception or I/O; no mathematics library; of the run-time library only what is
                          listed here, and of double arithmetic in software nothing but conversions of 64-bit integers
image.py sizes BUILD      code, data and RAM against the limits that boards/mps2_an500/README.md states
image.py frames BUILD     no stack frame of a function in the image beyond the limit stated there, none of unknown size"""
import re
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
README = ROOT / "boards/mps2_an500/README.md"
IMAGE = "bin/scribecell-mps2-an500.elf"
TOOL = "arm-none-eabi-"

# What objects of our own may ask the run-time libraries for.
ASKED = {"memcpy", "memmove", "memset", "memcmp", "abort",
         "__aeabi_d2lz", "__aeabi_l2d", "__aeabi_ldivmod", "__aeabi_uldivmod"}
# What these bring along. Whole members of libgcc are linked: the adder of doubles is in that of l2d, and nothing of
# ours calls it, which `ASKED` proves.
BROUGHT = {"__aeabi_d2ulz", "__fixdfdi", "__fixunsdfdi", "__udivmoddi4", "__aeabi_idiv0", "__aeabi_ldiv0",
           "__aeabi_dadd", "__aeabi_dsub", "__aeabi_drsub", "__adddf3", "__subdf3",
           "__aeabi_f2d", "__aeabi_i2d", "__aeabi_ui2d", "__aeabi_ul2d",
           "__extendsfdf2", "__floatdidf", "__floatsidf", "__floatundidf", "__floatunsidf"}
# Comparisons of arrays, templates of headers that the compiler has left as functions where size counts.
BROUGHT |= {"_ZNSt7__equalILb1EE5equalIlEEbPKT_S4_S4_", "_ZSteqIdLj3EEbRKSt5arrayIT_XT0_EES4_"}
# Start-up and linker script.
OWN = {"abort", "board_main", "fault_handler", "record_exception", "reset_handler", "start", "vector_table",
       "bss_begin", "bss_end", "data_begin", "data_end", "data_image", "fault_stack_bytes", "fault_stack_top",
       "init_array_begin", "init_array_end", "stack_bottom", "stack_bytes", "stack_top"}
# C++ names may be of our own namespaces; operator new and delete are _Znw, _Zna, _Zdl, _Zda, the library is _ZSt, _ZNSt
# and __cxa: none of them passes.
CXX_NAME = re.compile(r"^_Z(?:TV|Z)?(?:NK?(?:2sc|12_GLOBAL__N_1)|L)")


def run(tool, *arguments):
    return subprocess.run([TOOL + tool, *map(str, arguments)], capture_output=True, text=True, check=True).stdout


def limits():
    """The numbers of README's table, by name."""
    rows = re.findall(r"^\| `(\w+)` \| ([\d ]+) \|", README.read_text(encoding="utf-8"), re.MULTILINE)
    return {name: int(number.replace(" ", "")) for name, number in rows}


def own_objects(build):
    return sorted(build.rglob("*.obj"))


def linked_objects(build):
    """Those objects that the linker has taken, by its map: libraries of ours hold more than the image uses."""
    text = (build / f"{IMAGE}.map").read_text(encoding="utf-8")
    taken = set(re.findall(r"lib(\w+)\.a\((\w+\.cpp\.obj)\)", text))
    program = f"{Path(IMAGE).name}.dir"
    return [path for path in own_objects(build)
            if program in path.parts or any(f"{name}.dir" in path.parts and path.name == member for name, member in taken)]


def unknown(names, allowed):
    return sorted(name for name in names if name not in allowed and not CXX_NAME.match(name))


def check_symbols(build):
    findings = []
    for path in own_objects(build):
        needed = {line.split()[-1] for line in run("nm", "--undefined-only", path).splitlines() if line.strip()}
        findings += [f"{path.relative_to(build)}: needs '{name}', which is not on the list of image.py"
                     for name in unknown(needed, ASKED | OWN)]
    names = {line.split()[-1] for line in run("nm", build / IMAGE).splitlines()} - {"$a", "$d", "$t"}
    if not {"memcpy", "reset_handler"} <= names:
        findings.append(f"{IMAGE}: has not even the symbols that it must have")
    findings += [f"{IMAGE}: '{name}' is in it, which is not on the list of image.py"
                 for name in unknown(names, ASKED | BROUGHT | OWN)]
    left = run("nm", "--undefined-only", build / IMAGE).split()
    return findings + [f"{IMAGE}: undefined: {left}"] * bool(left)


def check_sizes(build):
    text, data, bss = map(int, run("size", build / IMAGE).splitlines()[1].split()[:3])
    figures = {"flash_bytes": text + data, "ram_bytes": data + bss}
    for name, value in figures.items():
        print(f"{name}: {value} of {limits()[name]}")
    return [f"{name}: {value} is more than the {limits()[name]} of boards/mps2_an500/README.md"
            for name, value in figures.items() if value > limits()[name]]


def check_frames(build):
    limit, frames, findings = limits()["frame_bytes"], [], []
    for path in linked_objects(build):
        usage = path.with_suffix(".su")
        if not usage.is_file():
            findings.append(f"{path.relative_to(build)}: the compiler left no stack usage beside it")
            continue
        for line in usage.read_text(encoding="utf-8").splitlines():
            where, size, kind = line.split("\t")
            frames.append((int(size), where))
            if kind != "static":
                findings.append(f"{where}: frame of a size that only the run knows ({kind})")
    frames.sort(reverse=True)
    for size, where in frames[:10]:
        print(f"{size:6} {where}")
    findings += [f"{where}: frame of {size} bytes, {limit} is the limit" for size, where in frames if size > limit]
    return findings or ([] if frames else ["no frames at all"])


def main():
    checks = {"symbols": check_symbols, "sizes": check_sizes, "frames": check_frames}
    if len(sys.argv) != 3 or sys.argv[1] not in checks:
        sys.exit(f"usage: image.py {'|'.join(checks)} BUILD")
    build = Path(sys.argv[2])
    if not (build / IMAGE).is_file():
        sys.exit(f"{build / IMAGE} is missing: cmake --preset m7 && cmake --build --preset m7")
    findings = checks[sys.argv[1]](build)
    print("\n".join(findings))
    sys.exit(1 if findings else 0)


if __name__ == "__main__":
    main()

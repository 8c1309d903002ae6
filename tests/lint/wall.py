#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The wall between truth and estimate: nothing of boards/ (the true world) or firmware/ can be reached from host/, neither
by an include, nor by a link. Each proof is run the other way round too, where it must find something.

wall.py BUILD_FOLDER COMPILER"""
import json
import re
import subprocess
import sys
from pathlib import Path

from project import ROOT, cxx_files, finish

BEHIND = ("boards", "firmware")
_LIBRARY = re.compile(r"\blib(?:" + "|".join(BEHIND) + r")_\w+\.a\b")
_ROOT = re.compile(r"/include/(?:" + "|".join(BEHIND) + r")_\w+")
_SYMBOL = re.compile(r"\bsc::sim::")


def include_roots(build):
    """[(layer, target, folders)] as CMake computed them, with all that each target links."""
    lines = (build / "include_roots.txt").read_text().splitlines()
    return [(layer, target, [folder for folder in folders.split(";") if folder])
            for layer, target, folders in (line.split("|") for line in lines)]


def probe_source():
    """A source that does not compile where any header behind the wall can be found."""
    headers = [path for path in cxx_files(ROOT) if path.suffix == ".hpp" and path.parts[0] in BEHIND]
    return len(headers), "".join(f'#if __has_include("{path}")\n#error reached {path}\n#endif\n' for path in headers)


def reached(compiler, folders, source):
    done = subprocess.run([compiler, "-std=c++23", "-fsyntax-only", "-x", "c++", "-", *(f"-I{f}" for f in folders)],
                          input=source, capture_output=True, text=True, check=False)
    return sorted(set(re.findall(r"#error reached (\S+)", done.stderr)))


def include_findings(build, compiler):
    count, source = probe_source()
    roots = include_roots(build)
    hosts = [(target, folders) for layer, target, folders in roots if layer == "host"]
    worlds = [(target, folders) for layer, target, folders in roots if target == "boards_sim_world"]
    if not (count and hosts and worlds):
        yield f"nothing to prove: {count} headers behind the wall, {len(hosts)} host targets, {len(worlds)} worlds"
    for target, folders in hosts:
        for header in reached(compiler, folders, source):
            yield f"{target} can include {header}"
    for target, folders in worlds:
        if not reached(compiler, folders, source):
            yield f"the probe is blind: it finds no header from within {target}"


def command_findings(build):
    for entry in json.loads((build / "compile_commands.json").read_text()):
        file = Path(entry["file"])
        if file.is_relative_to(ROOT / "host") and _ROOT.search(entry["command"]):
            yield f"{file.relative_to(ROOT)} is compiled with {_ROOT.search(entry['command']).group()}"


def link_line(build, program):
    done = subprocess.run(["ninja", "-C", str(build), "-t", "commands", "-s", f"bin/{program}"], capture_output=True,
                          text=True, check=True)
    return done.stdout


def symbol_names(build, program):
    return subprocess.run(["nm", "-C", str(build / "bin" / program)], capture_output=True, text=True, check=True).stdout


def program_findings(build):
    for library in sorted(set(_LIBRARY.findall(link_line(build, "scribecell")))):
        yield f"scribecell links {library}"
    if _SYMBOL.search(symbol_names(build, "scribecell")):
        yield "scribecell contains symbols of sc::sim"
    if not _LIBRARY.search(link_line(build, "scribecell-cell")):
        yield "the search is blind: it finds no library of boards/ in scribecell-cell"
    if not _SYMBOL.search(symbol_names(build, "scribecell-cell")):
        yield "the search is blind: it finds no symbol of sc::sim in scribecell-cell"


if __name__ == "__main__":
    BUILD = Path(sys.argv[1])
    finish("wall", [*include_findings(BUILD, sys.argv[2]), *command_findings(BUILD), *program_findings(BUILD)])

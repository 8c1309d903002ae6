#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""clang-tidy-19 over all sources of shared, firmware, boards and host, as build/tidy would compile them.

A source that passed is not looked at again until it, a header of the project that it includes, its compile command, the
configuration or clang-tidy changes: what passed is kept as empty files named by a hash in
${SC_CACHE:-${XDG_CACHE_HOME:-~/.cache}/scribecell}/tidy, good for every clone of the project.

tidy.py [REGEX]    only sources whose path matches"""
import concurrent.futures
import hashlib
import json
import os
import re
import subprocess
import sys
from pathlib import Path

from project import LAYERS, ROOT, finish

TIDY = "clang-tidy-19"
_QUOTED = re.compile(r'^\s*#\s*include\s*"([^"]+)"', re.MULTILINE)


def cache_folder():
    base = os.environ.get("SC_CACHE") or Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "scribecell"
    folder = Path(base) / "tidy"
    folder.mkdir(parents=True, exist_ok=True)
    return folder


def with_headers(root, source):
    """The source and the project's headers it includes, directly or not."""
    seen, todo = set(), [source]
    while todo:
        path = todo.pop()
        if path in seen or not path.is_file():
            continue
        seen.add(path)
        todo += [root / name for name in _QUOTED.findall(path.read_text(encoding="utf-8"))]
    return sorted(seen)


def key(root, entry, common):
    digest = hashlib.sha256(common)
    digest.update(entry["command"].replace(str(root), "").encode())
    for path in with_headers(root, Path(entry["file"])):
        digest.update(str(path.relative_to(root)).encode() + b"\0" + path.read_bytes())
    return digest.hexdigest()


def run(build, entry):
    done = subprocess.run([TIDY, "--quiet", "-p", str(build), entry["file"]], capture_output=True, text=True, check=False)
    noise = re.compile(r"^(\d+ warnings? (generated|treated as errors)\.?|Suppressed .*|Use -header-filter.*)$", re.MULTILINE)
    return done.returncode, (done.stdout + noise.sub("", done.stderr)).strip()


def check(root, build, pattern):
    database = build / "compile_commands.json"
    if not database.is_file():
        return [f"{database.relative_to(root)} is missing: cmake --preset tidy"]
    version = subprocess.run([TIDY, "--version"], capture_output=True, check=True).stdout
    common = version + (root / ".clang-tidy").read_bytes()
    entries = [entry for entry in json.loads(database.read_text()) if Path(entry["file"]).is_relative_to(root)]
    entries = [entry for entry in entries if Path(entry["file"]).relative_to(root).parts[0] in LAYERS
               and pattern.search(str(Path(entry["file"]).relative_to(root)))]
    passed = cache_folder()
    todo = [(entry, key(root, entry, common)) for entry in entries]
    todo = [(entry, name) for entry, name in todo if not (passed / name).exists()]
    print(f"clang-tidy: {len(entries)} sources, {len(todo)} to look at", flush=True)
    findings = {}  # each once: a header is looked at from many sources
    with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
        jobs = {pool.submit(run, build, entry): name for entry, name in todo}
        for job in concurrent.futures.as_completed(jobs):
            code, text = job.result()
            if code:
                findings |= dict.fromkeys(re.split(r"\n(?=/\S+:\d+:\d+: (?:error|warning))", text))
            else:
                (passed / jobs[job]).touch()
    return list(findings)


if __name__ == "__main__":
    finish("tidy", check(ROOT, ROOT / "build" / "tidy", re.compile(sys.argv[1] if len(sys.argv) > 1 else "")))

#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The rules of the folders: who may include whom, and what shared/ and firmware/ may not use at all."""
import re

from project import LAYERS, ROOT, code_only, cxx_files, finish

MAY_INCLUDE = {
    "shared": {"shared"},
    "firmware": {"shared", "firmware"},
    "boards": {"shared", "firmware", "boards"},
    "host": {"shared", "host"},
}
# Headers that allocate, do I/O, block, or bring the mathematics library, whose bits differ between machines.
BANNED_HEADERS = set("""
    iostream ostream istream fstream sstream iomanip print format cstdio stdio.h
    vector string map set unordered_map unordered_set deque list forward_list queue stack functional any
    memory_resource regex locale filesystem random ranges
    cmath math.h complex cfenv fenv.h
    mutex shared_mutex thread condition_variable future semaphore latch barrier
    unistd.h termios.h fcntl.h gpiod.h modbus.h modbus/modbus.h hidapi/hidapi.h
""".split())
BANNED_FOLDERS = ("linux/", "sys/", "net/", "netinet/")
BANNED_WORDS = {
    "new": "no heap", "malloc": "no heap", "calloc": "no heap", "realloc": "no heap",
    "throw": "no exceptions", "try": "no exceptions", "catch": "no exceptions",
    "dynamic_cast": "no run-time type information", "typeid": "no run-time type information",
    "goto": "no goto",
}
_INCLUDE = re.compile(r'^\s*#\s*include\s*([<"])([^>"]+)[>"]', re.MULTILINE)
_WORD = re.compile(r"\b(" + "|".join(BANNED_WORDS) + r")\b")
_DELETE = re.compile(r"(?<!=)\s\bdelete\b\s*[\[\w(]")
_MACHINE = re.compile(r"^\s*#\s*(?:if|ifdef|ifndef|elif)\b.*?\b(STM32\w*|MPS2\w*|AN500\w*|CORTEX\w*|__arm__|__thumb__|"
                      r"__ARM\w*|__x86_64__|__i386__|__linux__)", re.MULTILINE | re.IGNORECASE)


def line_of(text, offset):
    return text.count("\n", 0, offset) + 1


def include_findings(layer, text, where):
    for match in _INCLUDE.finditer(text):
        quote, target = match.groups()
        place = f"{where}:{line_of(text, match.start(2))}"
        top = target.split("/")[0]
        if ".." in target.split("/"):
            yield f"{place}: '{target}': include paths start at the project's root, without '..'"
        elif quote == '"' and layer in MAY_INCLUDE and top not in LAYERS:
            yield f"{place}: '{target}': write the path from the project's root"
        elif layer in MAY_INCLUDE and top in LAYERS and top not in MAY_INCLUDE[layer]:
            yield f"{place}: {layer}/ must not include {top}/ ('{target}')"
        elif layer in ("shared", "firmware") and (target in BANNED_HEADERS or target.startswith(BANNED_FOLDERS)):
            yield f"{place}: {layer}/ must not include <{target}>"


def word_findings(layer, code, where):
    if layer not in ("shared", "firmware"):
        return
    for match in _WORD.finditer(code):
        word = match.group(1)
        yield f"{where}:{line_of(code, match.start())}: '{word}' in {layer}/: {BANNED_WORDS[word]}"
    for match in _DELETE.finditer(code):
        yield f"{where}:{line_of(code, match.end())}: 'delete' in {layer}/: no heap"


def machine_findings(layer, text, where):
    if layer in ("boards", "toolchains"):
        return
    for match in _MACHINE.finditer(text):
        yield f"{where}:{line_of(text, match.start(1))}: '{match.group(1)}' is asked for outside boards/ and toolchains/"


def check(root):
    findings = []
    for path in cxx_files(root):
        text = (root / path).read_text(encoding="utf-8")
        layer = path.parts[0]
        findings += include_findings(layer, text, path)
        findings += word_findings(layer, code_only(text), path)
        findings += machine_findings(layer, text, path)
    return findings


if __name__ == "__main__":
    finish("includes", check(ROOT))

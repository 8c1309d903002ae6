# SPDX-License-Identifier: Apache-2.0
"""What the lint scripts share: the project's files, C++ without its comments, and how findings are reported."""
import os
import re
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
CXX = {".cpp", ".hpp"}
LAYERS = ("shared", "firmware", "boards", "host")
NOT_OURS = {".git", ".cache", "__pycache__", "node_modules", "run-output"}


def project_files(root):
    """All files of the project, tracked or new but not ignored, as paths relative to root."""
    listed = subprocess.run(["git", "-C", str(root), "ls-files", "-co", "--exclude-standard", "-z"],
                            capture_output=True, check=False) if (root / ".git").exists() else None
    if listed and listed.returncode == 0:
        paths = {Path(name) for name in listed.stdout.decode().split("\0") if name}
        return sorted(path for path in paths if (root / path).is_file())
    found = []
    for folder, subfolders, names in os.walk(root):
        subfolders[:] = [name for name in subfolders if name not in NOT_OURS and not name.startswith("build")]
        found += [Path(folder, name).relative_to(root) for name in names]
    return sorted(found)


def cxx_files(root):
    return [path for path in project_files(root) if path.suffix in CXX]


_NOT_CODE = re.compile(r'''R"([^\s(]*)\(.*?\)\1"|//[^\n]*|/\*.*?\*/|"(?:\\.|[^"\\\n])*"|(?<![0-9A-Fa-f])'(?:\\.|[^'\\\n])*\'''',
                       re.DOTALL)


def code_only(text):
    """The text with comments and literals blanked, line numbers kept."""
    return _NOT_CODE.sub(lambda match: re.sub(r"[^\n]", " ", match.group()), text)


def finish(name, findings):
    """Prints the findings and ends the program: 0 without any, 1 with."""
    for finding in findings:
        print(finding)
    if findings:
        print(f"{name}: {len(findings)} finding(s)")
    sys.exit(1 if findings else 0)

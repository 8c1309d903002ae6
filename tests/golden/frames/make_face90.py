#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Makes the part of examples/ras3dm that is given in c and w: face 90's markers (face90_c.csv) and its datum line.

The measured places of face 90 (table1.csv, in h at C = -90) are turned back to C = 0 about the calibrated axis and taken
to c with the calibration; the line runs through their centroid at constant z on their least-squares plane and is taken on
to w with the job's alignment. Written by hand from docs/frames.md: shares no code with the project.

    make_face90.py EXAMPLE_FOLDER            prints both
    make_face90.py EXAMPLE_FOLDER --write    writes face90_c.csv and prints the line's two keys for job.toml
    make_face90.py EXAMPLE_FOLDER --check    exit code 1 unless the folder holds just that
"""
import csv
import math
import pathlib
import sys
import tomllib

FACE = 90
LINE_LENGTH_MM = 64.0


def dot(a, b):
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def apply_transposed(rotation, v):
    return [dot([row[i] for row in rotation], v) for i in range(3)]


def inverse_place(transform, place):
    """From the left frame of the transform's name to the right one."""
    rotation, translation = transform
    return apply_transposed(rotation, [place[i] - translation[i] for i in range(3)])


def turn(axis, degrees, place):
    """By `degrees` about the axis, right-hand rule: the part along it stays, the part across turns in its plane."""
    point, direction = axis
    length = math.sqrt(dot(direction, direction))
    u = [d / length for d in direction]
    r = [place[i] - point[i] for i in range(3)]
    along = dot(u, r)
    across = [r[i] - along * u[i] for i in range(3)]
    side = [u[1] * r[2] - u[2] * r[1], u[2] * r[0] - u[0] * r[2], u[0] * r[1] - u[1] * r[0]]
    c, s = math.cos(math.radians(degrees)), math.sin(math.radians(degrees))
    return [point[i] + along * u[i] + c * across[i] + s * side[i] for i in range(3)]


def measured(folder):
    with open(folder / "table1.csv", newline="", encoding="utf-8") as stream:
        rows = [row for row in csv.DictReader(stream) if float(row["face_deg"]) == FACE]
    return [(int(row["no"]), [float(row["mx"]), float(row["my"]), float(row["mz"])]) for row in rows]


def line_ends(places):
    """Two ends of the datum line in h: least squares y = a + b x + c z, then z constant through the centroid."""
    n = len(places)
    mean = [math.fsum(p[i] for p in places) / n for i in range(3)]
    d = [[p[i] - mean[i] for i in range(3)] for p in places]
    xx, zz, xz = (math.fsum(p[i] * p[j] for p in d) for i, j in ((0, 0), (2, 2), (0, 2)))
    xy, zy = (math.fsum(p[i] * p[1] for p in d) for i in (0, 2))
    slope = (xy * zz - zy * xz) / (xx * zz - xz * xz)
    half = LINE_LENGTH_MM / 2.0 / math.hypot(1.0, slope)
    return [[mean[0] + s * half, mean[1] + s * half * slope, mean[2]] for s in (-1.0, 1.0)]


def load(folder):
    with open(folder / "calibration.toml", "rb") as stream:
        calibration = tomllib.load(stream)
    with open(folder / "job.toml", "rb") as stream:
        job = tomllib.load(stream)
    h_from_c = next(t for t in calibration["transform"] if t["id"] == "h_from_c")
    assert h_from_c["unit"] == "mm"
    axis = calibration["turntable"]["point_mm"], calibration["turntable"]["direction"]
    alignment = job["alignment"]["rotation"], job["alignment"]["translation_mm"]
    return (h_from_c["rotation"], h_from_c["translation"]), axis, alignment


def make(folder):
    """(text of face90_c.csv, [line of from_mm, line of to_mm])"""
    h_from_c, axis, c_from_w = load(folder)

    def to_c(place):
        # Face 90 stands at C = -90; turning by +90 brings the table back to C = 0.
        return inverse_place(h_from_c, turn(axis, float(FACE), place))

    markers = measured(folder)
    text = "no,x,y,z\n"
    for no, place in markers:
        text += "%d,%.4f,%.4f,%.4f\n" % (no, *to_c(place))
    ends = [inverse_place(c_from_w, to_c(end)) for end in line_ends([place for _, place in markers])]
    keys = ["%s = [%.4f, %.4f, %.4f]" % (key, *end) for key, end in zip(("from_mm", "to_mm"), ends)]
    return text, keys


def main():
    folder = pathlib.Path(sys.argv[1])
    text, keys = make(folder)
    if "--write" in sys.argv:
        (folder / "face90_c.csv").write_text(text, encoding="utf-8")
        print("\n".join(keys))
        return 0
    if "--check" in sys.argv:
        lines = (folder / "job.toml").read_text(encoding="utf-8").splitlines()
        same_points = (folder / "face90_c.csv").read_text(encoding="utf-8") == text
        missing = [key for key in keys if key not in lines]
        if same_points and not missing:
            return 0
        print("face90_c.csv is %s; job.toml lacks %s" % ("as made" if same_points else "other", missing or "nothing"))
        return 1
    print(text + "\n".join(keys))
    return 0


if __name__ == "__main__":
    sys.exit(main())

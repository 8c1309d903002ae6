#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Makes the default world's casting: a closed mesh whose four faces hold the true marker places of a table.

Each face is triangulated (Delaunay, in exact integers) over three kinds of points, seen along the beam:
  markers   the table's true places, on the surface exactly;
  pads      eight points round each marker, coplanar with it and with the slope of the face, so that the surface is
            smooth where a cross is burnt;
  ring      a border on the face's least-squares plane, 20 mm beyond the outermost markers.
The faces are turned back from C = -face to the table's frame about the true axis of world.toml, joined by chamfers at
the corners and closed by a flat fan at top and bottom. Only the standard library; the output depends on nothing else.
"""
import argparse
import csv
import math
import pathlib
import sys
import tomllib

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parents[2]
FACES = (0, 90, 180, 270)
PAD_UM = ((6000, 0), (4243, 4243), (0, 6000), (-4243, 4243), (-6000, 0), (-4243, -4243), (0, -6000), (4243, -4243))
MARGIN_UM = 20_000
STEP_UM = 20_000


def read_markers(table):
    """{face: [(x, y, z) in mm]} of the true values, in h at C = -face."""
    markers = {face: [] for face in FACES}
    with open(table, newline="", encoding="utf-8") as stream:
        for row in csv.DictReader(stream):
            markers[int(row["face_deg"])].append(tuple(float(row[key]) for key in ("tx", "ty", "tz")))
    return markers


def least_squares_plane(points):
    """(a, b, c) of y = a + b x + c z."""
    n = len(points)
    mx, my, mz = (math.fsum(p[i] for p in points) / n for i in range(3))
    xx = math.fsum((x - mx) ** 2 for x, _, _ in points)
    zz = math.fsum((z - mz) ** 2 for _, _, z in points)
    xz = math.fsum((x - mx) * (z - mz) for x, _, z in points)
    xy = math.fsum((x - mx) * (y - my) for x, y, _ in points)
    zy = math.fsum((z - mz) * (y - my) for _, y, z in points)
    det = xx * zz - xz * xz
    b = (xy * zz - zy * xz) / det
    c = (zy * xx - xy * xz) / det
    return my - b * mx - c * mz, b, c


def um(mm):
    return round(mm * 1000.0)


def divided(low, high):
    """From low to high in equal steps of about STEP_UM, integers."""
    n = max(1, round((high - low) / STEP_UM))
    return [low + (high - low) * i // n for i in range(n + 1)]


def orient(a, b, p):
    return (b[0] - a[0]) * (p[1] - a[1]) - (b[1] - a[1]) * (p[0] - a[0])


def in_circle(a, b, c, p):
    """Positive when p lies inside the circle through a, b, c (counter-clockwise)."""
    rows = [(q[0] - p[0], q[1] - p[1]) for q in (a, b, c)]
    lift = [x * x + z * z for x, z in rows]
    (ax, az), (bx, bz), (cx, cz) = rows
    return ax * (bz * lift[2] - cz * lift[1]) - az * (bx * lift[2] - cx * lift[1]) + lift[0] * (bx * cz - bz * cx)


def delaunay(points):
    """Triangles (counter-clockwise) of integer points whose first four are the corners of their rectangle."""
    triangles = {(0, 1, 2), (0, 2, 3)}
    for k in range(4, len(points)):
        p = points[k]
        hit = [t for t in triangles if in_circle(*(points[i] for i in t), p) > 0]
        edges = {(t[i], t[(i + 1) % 3]) for t in hit for i in range(3)}
        triangles.difference_update(hit)
        for a, b in edges:
            if (b, a) not in edges and orient(points[a], points[b], p) != 0:
                triangles.add((a, b, k))
    return sorted(triangles)


class Face:
    """One face in h at C = -face, as seen along the beam in (x, z)."""

    def __init__(self, markers, z_low, z_high):
        a, b, c = least_squares_plane(markers)
        low = min(um(x) for x, _, _ in markers) - MARGIN_UM
        high = max(um(x) for x, _, _ in markers) + MARGIN_UM
        self.xs, self.zs = divided(low, high), divided(z_low, z_high)
        self.points, self.y = [], []

        def add(x, z, y):
            self.points.append((x, z))
            self.y.append(y)

        def on_plane(x, z):
            add(x, z, a + b * x / 1000.0 + c * z / 1000.0)

        for x, z in ((low, z_low), (high, z_low), (high, z_high), (low, z_high)):
            on_plane(x, z)
        for x in self.xs[1:-1]:
            on_plane(x, z_low)
            on_plane(x, z_high)
        for z in self.zs[1:-1]:
            on_plane(low, z)
            on_plane(high, z)
        for x, y, z in markers:
            add(um(x), um(z), y)
            for dx, dz in PAD_UM:
                add(um(x) + dx, um(z) + dz, y + (b * dx + c * dz) / 1000.0)
        # Counter-clockwise in (x, z) looks along +y; outward is +y, so each triangle is turned round.
        self.triangles = [(p, r, q) for p, q, r in delaunay(self.points)]
        self.at = {point: i for i, point in enumerate(self.points)}

    def column(self, side):
        x = self.xs[0] if side == "low" else self.xs[-1]
        return [self.at[x, z] for z in self.zs]

    def row(self, side):
        """From the high-x end to the low-x end: counter-clockwise round the table seen from above."""
        z = self.zs[0] if side == "low" else self.zs[-1]
        return [self.at[x, z] for x in reversed(self.xs)]


def rotation(direction, degrees):
    length = math.sqrt(math.fsum(v * v for v in direction))
    u = [v / length for v in direction]
    quarter = {0: (0.0, 1.0), 90: (1.0, 0.0), 180: (0.0, -1.0), 270: (-1.0, 0.0)}
    s, c = quarter[degrees]
    k = 1.0 - c
    return [[c + u[0] * u[0] * k, u[0] * u[1] * k - u[2] * s, u[0] * u[2] * k + u[1] * s],
            [u[1] * u[0] * k + u[2] * s, c + u[1] * u[1] * k, u[1] * u[2] * k - u[0] * s],
            [u[2] * u[0] * k - u[1] * s, u[2] * u[1] * k + u[0] * s, c + u[2] * u[2] * k]]


def turned_back(point, face, table):
    """From h at C = -face to t: about the axis by +face."""
    origin = [table["axis_x_mm"], table["axis_y_mm"], table["axis_z_mm"]]
    r = rotation([table["direction_x"], table["direction_y"], table["direction_z"]], face)
    d = [point[i] - origin[i] for i in range(3)]
    return [math.fsum([origin[i]] + [r[i][j] * d[j] for j in range(3)]) for i in range(3)]


def build(markers, table):
    """(vertices in mm in t, triangles counter-clockwise seen from outside)."""
    every = [p for face in FACES for p in markers[face]]
    z_low = (min(um(z) for _, _, z in every) - MARGIN_UM) // 1000 * 1000
    z_high = -(-(max(um(z) for _, _, z in every) + MARGIN_UM) // 1000) * 1000
    faces = {face: Face(markers[face], z_low, z_high) for face in FACES}
    vertices, triangles, start = [], [], {}
    for face, f in faces.items():
        start[face] = len(vertices)
        vertices += [turned_back((x / 1000.0, y, z / 1000.0), face, table) for (x, z), y in zip(f.points, f.y)]
        triangles += [tuple(start[face] + i for i in t) for t in f.triangles]
    for face in FACES:
        following = (face + 90) % 360
        right = [start[face] + i for i in faces[face].column("low")]
        left = [start[following] + i for i in faces[following].column("high")]
        for i in range(len(right) - 1):
            triangles += [(right[i], left[i], right[i + 1]), (left[i], left[i + 1], right[i + 1])]
    for side in ("low", "high"):
        loop = [start[face] + i for face in FACES for i in faces[face].row(side)]
        centre = len(vertices)
        vertices.append([math.fsum(vertices[i][k] for i in loop) / len(loop) for k in range(3)])
        for i, a in enumerate(loop):
            b = loop[(i + 1) % len(loop)]
            triangles.append((a, b, centre) if side == "high" else (b, a, centre))
    return vertices, triangles


def check(vertices, triangles, table):
    """Every directed edge once and its opposite once; volume positive; swing circle within 270 mm."""
    edges = [(t[i], t[(i + 1) % 3]) for t in triangles for i in range(3)]
    known = set(edges)
    if len(edges) != len(known) or any((b, a) not in known for a, b in edges):
        sys.exit("make_workpiece: the mesh is not closed")
    volume = 0.0
    for t in triangles:
        (ax, ay, az), (bx, by, bz), (cx, cy, cz) = (vertices[i] for i in t)
        volume += ax * (by * cz - bz * cy) - ay * (bx * cz - bz * cx) + az * (bx * cy - by * cx)
    swing = max(math.hypot(v[0] - table["axis_x_mm"], v[1] - table["axis_y_mm"]) for v in vertices)
    if volume <= 0.0 or swing >= 270.0:
        sys.exit(f"make_workpiece: volume {volume / 6e9:.4f} dm3, swing radius {swing:.1f} mm (must be under 270)")
    return swing


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--table", default=ROOT / "examples/ras3dm/table1.csv", help="marker table (CSV, mm)")
    parser.add_argument("--world", default=HERE / "default/world.toml", help="world file that holds the true axis")
    parser.add_argument("--out", default=HERE / "default/workpiece.obj", help="OBJ file to write")
    arguments = parser.parse_args()
    with open(arguments.world, "rb") as stream:
        table = tomllib.load(stream)["turntable"]
    vertices, triangles = build(read_markers(arguments.table), table)
    swing = check(vertices, triangles, table)
    with open(arguments.out, "w", encoding="ascii", newline="\n") as out:
        out.write("# Casting of the default world in the table's frame t, mm. Made by make_workpiece.py; do not edit.\n")
        out.writelines("v {:.9f} {:.9f} {:.9f}\n".format(*v) for v in vertices)
        out.writelines("f {} {} {}\n".format(*(i + 1 for i in t)) for t in triangles)
    print(f"{len(vertices)} vertices, {len(triangles)} triangles, swing radius {swing:.1f} mm")


if __name__ == "__main__":
    main()

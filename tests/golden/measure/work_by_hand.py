#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Poses worked out with vectors alone, for tests/golden/host/measurement: three places from three readings, the normal
by the paper's equation 9, the angle by its equation 10, the distance by meeting a line. Shares no code with the project.

    work_by_hand.py            writes golden.json
    work_by_hand.py --check    compares it with what is there
"""
import json
import math
import random
import sys
from pathlib import Path

FILE = Path(__file__).with_name("golden.json")


def turn(axis, angle, p):
    """Right-handed, about x, y or z."""
    i, j = {"x": (1, 2), "y": (2, 0), "z": (0, 1)}[axis]
    q = list(p)
    q[i] = math.cos(angle) * p[i] - math.sin(angle) * p[j]
    q[j] = math.sin(angle) * p[i] + math.cos(angle) * p[j]
    return q


def case(rng):
    origins = [[0.0, 0.0], [100.0, 0.0], [50.0, 50.0 * math.sqrt(3.0)]]
    rays = [{"origin_mm": [o + rng.uniform(-1, 1) for o in origin], "tilt": [rng.uniform(-0.01, 0.01) for _ in "xy"],
             "zero_mm": rng.uniform(-1, 1), "gain": rng.uniform(-0.01, 0.01)} for origin in origins]
    # Columns of d_from_r: where the axes of r point in d, a little askew.
    angles = [rng.uniform(-0.02, 0.02) for _ in "xyz"]
    axes = [[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]
    axes = [turn("z", angles[2], turn("y", angles[1], turn("x", angles[0], axis))) for axis in axes]
    seat = [50.0 + rng.uniform(-1, 1), -60.0, -20.0 + rng.uniform(-1, 1)]
    at = [rng.uniform(-5, 5), 90.0]
    # A face with these slopes in d; readings that its three places would give.
    plane = [300.0 + rng.uniform(-20, 20), rng.uniform(-0.1, 0.1), rng.uniform(-0.6, 0.1)]
    readings = []
    places = []
    for ray in rays:
        length = math.sqrt(1.0 + ray["tilt"][0] ** 2 + ray["tilt"][1] ** 2)
        z = (plane[0] + plane[1] * ray["origin_mm"][0] + plane[2] * ray["origin_mm"][1]) / (
            1.0 - plane[1] * ray["tilt"][0] - plane[2] * ray["tilt"][1])
        places.append([ray["origin_mm"][0] + ray["tilt"][0] * z, ray["origin_mm"][1] + ray["tilt"][1] * z, z])
        readings.append(ray["zero_mm"] + z * length / (1.0 + ray["gain"]))
    in_r = [[sum((p[k] - seat[k]) * axis[k] for k in range(3)) for axis in axes] for p in places]
    (x1, y1, z1), (x2, y2, z2), (x3, y3, z3) = in_r
    normal = [(y2 - y1) * (z3 - z1) - (y3 - y1) * (z2 - z1), (x3 - x1) * (z2 - z1) - (x2 - x1) * (z3 - z1),
              (y3 - y1) * (x2 - x1) - (x3 - x1) * (y2 - y1)]
    size = math.sqrt(sum(v * v for v in normal))
    sign = -1.0 if normal[0] > 0.0 else 1.0  # towards the head
    normal = [sign * v / size for v in normal]
    return {"rays": rays, "axes_of_r": axes, "seat_mm": seat, "at_mm": at, "readings_mm": readings,
            "angle_deg": math.degrees(math.pi - math.acos(normal[2])),
            "about_z_deg": math.degrees(math.atan2(-normal[1], -normal[0])),
            "distance_mm": x1 - (normal[1] * (at[0] - y1) + normal[2] * (at[1] - z1)) / normal[0]}


def main():
    rng = random.Random(20260131)
    text = json.dumps([case(rng) for _ in range(12)], indent=1) + "\n"
    if "--check" in sys.argv:
        sys.exit(0 if FILE.read_text() == text else f"{FILE.name} is not what this script works out")
    FILE.write_text(text)


main()

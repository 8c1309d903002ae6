#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Points that pin every sign of docs/frames.md, worked without any code of the project.

Where right angles allow it the answer is written down as a person reads it off a sketch; the general cases that follow
are worked with plain elimination and plane geometry, and must agree with the sketches by the same functions. Millimetres,
degrees, milliradians, ppm.

    work_by_hand.py           prints golden.json
    work_by_hand.py --check   exit code 1 unless golden.json beside this file is just that
"""
import json
import math
import pathlib
import sys

HERE = pathlib.Path(__file__).resolve().parent


def dot(a, b):
    return sum(p * q for p, q in zip(a, b))


def rounded(values, digits=10):
    return [round(v, digits) + 0.0 for v in values]


def turn(point, direction, c_deg, place):
    """Right-hand turn about an axis, in the plane across it: e1 towards the place, e2 a quarter turn further."""
    length = math.sqrt(dot(direction, direction))
    u = [d / length for d in direction]
    r = [p - q for p, q in zip(place, point)]
    along = dot(u, r)
    e1 = [a - along * b for a, b in zip(r, u)]
    e2 = [u[1] * e1[2] - u[2] * e1[1], u[2] * e1[0] - u[0] * e1[2], u[0] * e1[1] - u[1] * e1[0]]
    c, s = math.cos(math.radians(c_deg)), math.sin(math.radians(c_deg))
    return [point[i] + along * u[i] + c * e1[i] + s * e2[i] for i in range(3)]


def solve(matrix, right):
    """Gauss elimination with pivots."""
    rows = [list(row) + [value] for row, value in zip(matrix, right)]
    n = len(rows)
    for i in range(n):
        pivot = max(range(i, n), key=lambda k: abs(rows[k][i]))
        rows[i], rows[pivot] = rows[pivot], rows[i]
        for k in range(n):
            if k != i:
                factor = rows[k][i] / rows[i][i]
                rows[k] = [a - factor * b for a, b in zip(rows[k], rows[i])]
    return [rows[i][n] / rows[i][i] for i in range(n)]


def place_by(transform, place):
    return [dot(row, place) + t for row, t in zip(transform["rotation"], transform["translation_mm"])]


def turning_cases():
    """The table's axis stands at x = -250, y = -470 and points up. Seen from above: x to the right, y up the page."""
    axis = {"point_mm": [-250.0, -470.0, 0.0], "direction": [0.0, 0.0, 1.0]}
    sketches = [
        ("right of the axis; +90 is counter-clockwise, so it comes to the head's side", 90, [-150, -470, -300], [-250, -370, -300]),
        ("at the head's side; +90 takes it to the left", 90, [-250, -370, -300], [-350, -470, -300]),
        ("right of the axis; -90 is clockwise, away from the head", -90, [-150, -470, -300], [-250, -570, -300]),
        ("half a turn", 180, [-150, -440, -10], [-350, -500, -10]),
        ("a place on the axis stays", 137, [-250, -470, -55], [-250, -470, -55]),
    ]
    cases = []
    for why, c_deg, before, after in sketches:
        worked = turn(axis["point_mm"], axis["direction"], c_deg, before)
        assert max(abs(a - b) for a, b in zip(worked, after)) < 1e-9, why
        cases.append({"why": why, **axis, "c_deg": c_deg, "from_mm": before, "to_mm": after})
    tilted = {"point_mm": [-250.0173, -470.0281, 0.0], "direction": [0.02, -0.03, math.sqrt(1 - 0.02**2 - 0.03**2)]}
    for c_deg in (33.25, -271.5):
        before = [-180.0, -391.0, -260.0]
        after = rounded(turn(tilted["point_mm"], tilted["direction"], c_deg, before))
        cases.append({"why": "a tilted axis", **tilted, "c_deg": c_deg, "from_mm": before, "to_mm": after})
    return cases


def face_cases():
    """w -> c -> h -> turned to face k, which is C = -k."""
    axis = {"point_mm": [-250.0, -470.0, 0.0], "direction": [0.0, 0.0, 1.0]}
    # The sensor stands left of the head and looks along +x: its z is h's x, its x is h's -y, its y is h's -z.
    h_from_c = {"rotation": [[0, 0, 1], [-1, 0, 0], [0, -1, 0]], "translation_mm": [-1000, -400, -100]}
    # The workpiece lies with its x towards the sensor (c's -z) and its z up (c's -y); then its y is c's x.
    c_from_w = {"rotation": [[0, 1, 0], [0, 0, -1], [-1, 0, 0]], "translation_mm": [40, 250, 760]}
    sketches = [
        # c = (30, 200, 600): h = (z - 1000, -x - 400, -y - 100)
        ("face 0: no turn", 0, "c", [30, 200, 600], [-400, -430, -300]),
        # From the axis (-150, 40): clockwise by 90 is (40, 150).
        ("face 90 stands at C = -90: clockwise brings the left side to the head", 90, "c", [30, 200, 600], [-210, -320, -300]),
        ("face 180", 180, "c", [30, 200, 600], [-100, -510, -300]),
        ("face 270: three quarters clockwise", 270, "c", [30, 200, 600], [-290, -620, -300]),
        # w = (160, -10, 50): c = (y + 40, -z + 250, -x + 760) = (30, 200, 600)
        ("the same place given on the workpiece", 90, "w", [160, -10, 50], [-210, -320, -300]),
    ]
    cases = []
    for why, face, frame, before, after in sketches:
        in_c = place_by(c_from_w, before) if frame == "w" else before
        worked = turn(axis["point_mm"], axis["direction"], -face, place_by(h_from_c, in_c))
        assert max(abs(a - b) for a, b in zip(worked, after)) < 1e-9, why
        cases.append({"why": why, **axis, "h_from_c": h_from_c, "c_from_w": c_from_w, "face_deg": face, "frame": frame,
                      "from_mm": before, "to_mm": after})
    return cases


def depth_cases():
    return [
        {"why": "the same reading: the same depth", "y1_mm": -300.0, "a1_mm": 85.0, "a2_mm": 85.0, "y_mm": -300.0},
        {"why": "a longer reading lies deeper: smaller y", "y1_mm": -300.0, "a1_mm": 85.0, "a2_mm": 90.01, "y_mm": -305.01},
        {"why": "a step up of 15.02", "y1_mm": -300.0, "a1_mm": 85.0, "a2_mm": 69.98, "y_mm": -284.98},
    ]


def axes_matrix(e):
    s = [v * 1e-6 for v in e["scale_ppm"]]
    k = [v * 1e-3 for v in e["squareness_xy_xz_yz_mrad"]]
    return [[1 + s[0], k[0], k[1]], [0, 1 + s[1], k[2]], [0, 0, 1 + s[2]]]


def axes_cases():
    """Reading q -> true place p of the focus; and the reading that is to be commanded for a wanted place."""
    one = [
        ("x tilts with y: 1 mrad over -300 mm of y moves the focus 0.3 mm to -x", [1, 0, 0], [0, 0, 0], [-200, -300, -400], [-200.3, -300, -400]),
        ("x tilts with z", [0, 1, 0], [0, 0, 0], [-200, -300, -400], [-200.4, -300, -400]),
        ("y tilts with z", [0, 0, 1], [0, 0, 0], [-200, -300, -400], [-200, -300.4, -400]),
        ("scales: +100 ppm stretches", [0, 0, 0], [100, 200, -300], [-200, -300, -400], [-200.02, -300.06, -399.88]),
    ]
    cases = []
    for why, k, s, reading, true in one:
        e = {"squareness_xy_xz_yz_mrad": k, "scale_ppm": s}
        worked = [dot(row, reading) for row in axes_matrix(e)]
        assert max(abs(a - b) for a, b in zip(worked, true)) < 1e-9, why
        cases.append({"why": why, **e, "reading_mm": reading, "true_mm": true})
    e = {"squareness_xy_xz_yz_mrad": [20, -30, 40], "scale_ppm": [5000, -7000, 9000]}
    true = [-210.0, -310.0, -410.0]
    cases.append({"why": "large and together: the inverse must be exact, not of first order", **e,
                  "reading_mm": rounded(solve(axes_matrix(e), true)), "true_mm": true})
    return cases


def galvo_cases():
    """Command g -> where the beam lands, seen from the focus: offset + M g."""
    one = [
        ("mirrors at zero: the offset", [0.035, -0.022], [[1, 0], [0, 1]], [0, 0], [0.035, -0.022]),
        ("x gain", [0, 0], [[1.01, 0], [0, 1]], [2, 3], [2.02, 3]),
        ("the second row's first entry turns +x towards +z", [0, 0], [[1, 0], [0.01, 1]], [2, 3], [2, 3.02]),
        ("the first row's second entry turns +z towards +x", [0, 0], [[1, 0.01], [0, 1]], [2, 3], [2.03, 3]),
    ]
    cases = []
    for why, offset, m, command, lands in one:
        worked = [offset[i] + dot(m[i], command) for i in range(2)]
        assert max(abs(a - b) for a, b in zip(worked, lands)) < 1e-12, why
        cases.append({"why": why, "offset_mm": offset, "matrix": m, "command_mm": command, "lands_mm": lands})
    offset, m, lands = [0.5, -0.25], [[1.05, -0.03], [0.04, 0.97]], [1.5, -2.0]
    command = solve(m, [lands[i] - offset[i] for i in range(2)])
    cases.append({"why": "all together, far from the identity", "offset_mm": offset, "matrix": m,
                  "command_mm": rounded(command), "lands_mm": lands})
    return cases


def rendered(golden):
    """JSON with a case on each line."""
    parts = ['"%s": [\n%s\n]' % (name, ",\n".join(json.dumps(case) for case in cases)) for name, cases in golden.items()]
    return "{\n" + ",\n".join(parts) + "\n}\n"


def main():
    golden = {"turning": turning_cases(), "face": face_cases(), "depth": depth_cases(), "axes": axes_cases(),
              "galvo": galvo_cases()}
    text = rendered(golden)
    if "--check" not in sys.argv:
        sys.stdout.write(text)
        return 0
    if (HERE / "golden.json").read_text(encoding="utf-8") == text:
        return 0
    print("golden.json is not what this script works out")
    return 1


if __name__ == "__main__":
    sys.exit(main())

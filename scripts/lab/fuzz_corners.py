#!/usr/bin/env python3
"""Random outlines with many corners, drawn or measured: a rod that slides along them may not be lost.

    scripts/lab/fuzz_corners.py build/tendril SEED COUNT [SECONDS] [--space]

Each scene has one polygon: a round cavity of 52 to 400 corners, a smooth cavity at random sampled with 30 to 300 corners, with
or without noise, a bowl in a block, or a hairpin. A round one is run beside the circle that it is drawn from. A scene is
lost if it gives up, crawls or does not end in SECONDS (60), or if its balance of energy is off by more than its error
is told to be; one that is jammed, and says so, is not. Each line is one that is lost, or whose tip is off from the
circle's by more than 1e-2 of the length: of a rod that meets the wall head-on the edge that it meets decides to which side it goes. --space: by the model of space."""

import math
import os
import random
import re
import subprocess
import sys
import tempfile

import h5py
import numpy as np

from fuzz_walls import ENVIRONMENT, balance


def corners(points):
    return " ".join(f"{x:.7g} {y:.7g}" for x, y in points)


def ring(R, n, middle, radius):
    """Corners on r(angle) about a place, not quite evenly spaced."""
    turn = R.uniform(0, 6)
    angles = [turn + 2 * math.pi * (k + R.uniform(-0.2, 0.2)) / n for k in range(n)]
    return [(middle + radius(a) * math.cos(a), radius(a) * math.sin(a)) for a in angles]


def round_cavity(R, start):
    r, x = R.uniform(0.6, 1) * max(start, 0.5) + 0.4, start / 2
    n = R.choice([52, 54, 56, 58, 60, 80, 100, 140, 200, 300, 400])
    turn = R.uniform(0, 1)
    points = [(x + r * math.cos(2 * math.pi * (k + turn) / n), r * math.sin(2 * math.pi * (k + turn) / n))
              for k in range(n)]
    return f"polygon inside {corners(points)}", f"circle {x:.9g} 0 {r:.9g} inside"


def wavy_cavity(R, start):
    waves = [(m, R.uniform(0, 0.12) / m, R.uniform(0, 6)) for m in range(2, R.randint(3, 7))]
    r, n = start / 2 + R.uniform(0.3, 0.8), R.randint(30, 300)
    noise = 2 * math.pi * r / n * math.radians(R.choice([0, 0.3, 1, 3]))  # by what edges turn

    def radius(a):
        return r * (1 + sum(size * math.cos(m * a + turn) for m, size, turn in waves)) + R.gauss(0, noise)

    return f"polygon inside {corners(ring(R, n, start / 2, radius))}", None


def bowl(R, start):
    """A block with a dent in front of the tip."""
    x, y, r, n = start + R.uniform(0.4, 1), R.uniform(-0.2, 0.2), R.uniform(0.4, 1.2), R.randint(20, 150)
    half = R.uniform(0.5, 1.2)
    arc = [(x + r * (math.cos(a) - 1), y + r * math.sin(a)) for a in np.linspace(-half, half, n)]
    x0 = arc[0][0]
    return f"polygon outside {corners([*arc, (x0, y + 3), (x + 3, y + 3), (x + 3, y - 3), (x0, y - 3)])}", None


def hairpin(R, start):
    """The outline of a channel that turns back."""
    half, r, n, out = R.uniform(0.1, 0.25), R.uniform(0.3, 0.6), R.randint(20, 120), start + R.uniform(0.5, 1)
    turn = np.linspace(-math.pi / 2, math.pi / 2, n)
    sides = []
    for side in (half, -half):
        bend = [(out + (r + side) * math.cos(a), r + (r + side) * math.sin(a)) for a in turn]
        sides.append([(-0.3, -side), *bend, (-0.3, 2 * r + side)])
    return f"polygon inside {corners(sides[0] + sides[1][::-1])}", None


def scene(R):
    start = round(R.uniform(0.3, 1), 3)
    o = {"growth_type": R.choice(["feed", "feed", "uniform", "apical"]), "growth_initial_length": start,
         "shape_type": "straight", "contact_diameter": R.choice([0.02, 0.05, 0.1, round(R.uniform(0.02, 0.15), 3)]),
         "rod_cells": R.choice([60, 100, 200]), "rod_curvature": round(R.uniform(-0.5, 0.5), 3),
         "friction_beta": R.choice([1e-3, 1e-3, 0, 1e-2]), "ts_max_time": round(R.uniform(1.5, 4), 2)}
    if o["growth_type"] == "uniform":
        o["ts_max_time"] = round(R.uniform(0.8, 1.8), 2)
    if R.random() < 0.2:
        o["contact_stiffness"] = R.choice([1e4, 1e5, 1e6])
    if R.random() < 0.1:
        o["friction_mu"] = 0
    wall, circle = R.choice([round_cavity, wavy_cavity, wavy_cavity, bowl, hairpin])(R, start)
    return o, wall, circle, R.choice([0, 0, 0.05, 0.1, 0.3])


def run(exe, o, wall, limit):
    """What became of it, its tip over its length, its iterations, and the command."""
    folder = tempfile.mkdtemp()
    with open(f"{folder}/walls.txt", "w") as f:
        f.write(wall + "\n")
    command = [exe, *sum([["-" + k, str(v)] for k, v in o.items()], []), "-wall_file", f"{folder}/walls.txt",
               "-output", f"{folder}/run.h5"]
    text = " ".join(command)
    try:
        done = subprocess.run(command, capture_output=True, text=True, timeout=limit, env=ENVIRONMENT)
    except subprocess.TimeoutExpired:
        return "hung", None, 0, text
    said = (done.stderr or done.stdout).strip()
    if not os.path.exists(f"{folder}/run.h5"):
        return ("refused" if "starts in a wall" in said else f"lost: {said[-300:]}"), None, 0, text
    iterations = int(re.search(r"(\d+) Newton iterations", done.stdout).group(1))
    with h5py.File(f"{folder}/run.h5") as f:
        tip = f["shapes/x"][-1, -1] / f["series/length"][-1]
        pressed = f["series/contact_force"][:].max() > 0
    if done.returncode:
        return ("jammed" if "jammed at" in said else f"lost: {said[-300:]}"), tip, iterations, text
    off, told = balance(f"{folder}/run.h5")
    if off > told:
        return f"lost: energy is off by {off}, told is {told}", tip, iterations, text
    return ("touched" if pressed else "free"), tip, iterations, text


def main():
    space = "--space" in sys.argv
    exe, seed, count, *more = (word for word in sys.argv[1:] if word != "--space")
    limit, R, tally, beside = float(more[0]) if more else 60, random.Random(int(seed)), {}, []
    for _ in range(int(count)):
        o, wall, circle, rub = scene(R)
        if space:
            o.update(rod_model="space", rod_curvature_2=0.01)  # (a mode without any content is another matter)
        what, tip, iterations, command = run(exe, o, f"{wall} friction {rub}", limit)
        word = what.split(":")[0]
        tally[word] = tally.get(word, 0) + 1
        if word in ("lost", "hung"):
            print(what, "|", command, flush=True)
        if circle and word == "touched":
            smooth, at, others, _ = run(exe, o, f"{circle} friction {rub}", limit)
            off = np.linalg.norm(tip - at) if smooth == "touched" else math.nan
            beside.append((off, iterations / max(1, others)))
            if not off < 1e-2:
                print(f"off by {off:.1e} from a circle ({smooth}) |", command, flush=True)
    off, times = np.array(beside or [(math.nan, math.nan)]).T
    print(f"{count} scenes: {tally}; {len(beside)} beside a circle: tips off by {np.nanmedian(off):.1e} of the length in the "
          f"middle, {np.nanmax(off):.1e} at most, {np.nanmedian(times):.2f} times as many iterations")
    return any(tally.get(k) for k in ("hung", "lost"))


if __name__ == "__main__":
    sys.exit(main())

#!/usr/bin/env python3
"""Random scenes in space with walls: none may be lost, and none may go through a wall.

    scripts/lab/fuzz_walls.py build/tendril SEED COUNT [SECONDS [FINER]] [--thin] [--moving]

Each is run once, for SECONDS at most (30), with FINER times as many cells (1). A scene is lost if it gives up, does
not end, is silent about a rod that is pressed in by more than 1 % of its diameter, or if its balance of energy is off by
more than its error is told to be; one that is jammed, and says so, is not, nor is one that is
refused because the rod starts in a wall. The curve between nodes is looked at in all stored shapes: where its
middle is behind a wall, the rod is through. Every tenth that touches is broken where half of its steps in contact are
behind it, and has to go on to the last bit; and runs on two ranks: how far its tip is from that of one is told.
--thin: what stands out of walls, and the rod, are thinner than cells are long (feet in space). --moving: walls are
displaced and come back, as rows say."""

import os
import random
import subprocess
import sys
import tempfile
import time

import h5py
import numpy as np
from scipy.interpolate import PchipInterpolator

ENVIRONMENT = dict(os.environ, OMP_NUM_THREADS="1", OMPI_ALLOW_RUN_AS_ROOT="1",
                   OMPI_ALLOW_RUN_AS_ROOT_CONFIRM="1", OMPI_MCA_ess_singleton_isolated="1")


def unit(v):
    return np.asarray(v, float) / np.linalg.norm(v)


def cylindrical(x, at, axis):
    o = x - at
    z = o @ axis
    return np.linalg.norm(o - np.outer(z, axis), axis=-1), z


def distance(wall, x):
    """The distance of points from a wall, below 0 behind it."""
    kind, a, inside = wall
    side = -1 if inside else 1
    at = np.array(a[:3])
    if kind == "plane":
        return (x - at) @ unit(a[3:6])
    if kind == "sphere":
        return side * (np.linalg.norm(x - at, axis=-1) - a[3])
    r, z = cylindrical(x, at, unit(a[3:6]))
    if kind == "cylinder":
        return side * (r - a[6])
    if kind == "cone":  # inside; beyond its ends it is open
        n = unit([-a[8], a[7] - a[6]])
        d = n[0] * (r - a[6]) + n[1] * z
        return np.where((z > 0) & (z < a[8]), d, np.inf)
    return side * (np.hypot(r - a[6], z) - a[7])


def scene(R):
    def uniform(a, b):
        return round(R.uniform(a, b), 4)

    D, start = R.choice([0.02, 0.05, 0.1, uniform(0.02, 0.15)]), uniform(0.3, 0.8)
    o = {"growth_type": R.choice(["feed", "feed", "uniform", "gaussian", "apical"]), "contact_diameter": D,
         "growth_initial_length": start, "shape_type": "straight", "ts_max_time": uniform(1, 3),
         "rod_cells": R.choice([60, 100]), "rod_curvature": uniform(-0.5, 0.5),
         "rod_curvature_2": uniform(-0.5, 0.5), "friction_beta": R.choice([0, 1e-3, 1e-3])}
    if o["growth_type"] in ("uniform", "gaussian"):
        o["ts_max_time"] = uniform(0.8, 1.8)
    if R.random() < 0.3:
        o["rod_weight"] = f"{uniform(-0.3, 0.3)},{uniform(-0.5, 0.5)},{uniform(-1, 0.2)}"
    if R.random() < 0.3:
        o["clamp_spin"] = uniform(-3, 3)
    if R.random() < 0.3:
        o["rod_twist"] = uniform(-1, 1)
    axis, walls = np.stack([np.linspace(0, start, 50), *np.zeros((2, 50))], 1), []
    clear = D / 2 + 0.02
    led = R.random()
    if led < 0.25:
        walls.append(("cylinder", [0, 0, 0, 1, 0, 0, D / 2 + uniform(0.03, 0.3)], True))
    elif led < 0.45:
        turn, ring, r = uniform(0, 6), uniform(0.8, 2), D / 2 + uniform(0.05, 0.3)
        walls.append(("torus", [0, ring * np.cos(turn), ring * np.sin(turn), 0, -np.sin(turn), np.cos(turn), ring, r],
                      True))
    elif led < 0.55:
        walls.append(("cone", [-0.5, 0, 0, 1, 0, 0, D / 2 + uniform(0.1, 0.4), D / 2 + uniform(0.05, 0.2), 4], True))
    while len(walls) < 1 or R.random() < 0.6:
        at = [uniform(0, 2.5), uniform(-0.8, 0.8), uniform(-0.8, 0.8)]
        n = list(unit([R.gauss(0, 1) for _ in range(3)]))
        kind = R.choice(["plane", "sphere", "cylinder", "torus"])
        walls.append({"plane": ("plane", at + n, False),
                      "sphere": ("sphere", at + [uniform(0.1, 0.6)], False),
                      "cylinder": ("cylinder", at + n + [uniform(0.1, 0.4)], False),
                      "torus": ("torus", at + n + [uniform(0.4, 0.8), uniform(0.1, 0.2)], False)}[kind])
    walls = [w for w in walls if distance(w, axis).min() > clear]
    return o, walls, lines_of(R, walls)


def lines_of(R, walls):
    rub = R.choice([0, 0.1, 0.3, 0.6])
    return [f"{k} {' '.join(f'{v:.12g}' for v in a)} {'' if k == 'plane' else 'inside' if i else 'outside'} "
            f"friction {rub}" for k, a, i in walls]


THIN = {"sphere": 3, "cylinder": 6, "torus": 7}  # which number of a wall is the radius of what stands out


def thinner(R, o, walls):
    """The rod and what stands out: of radii from 1e-3 to 2e-2."""
    o["contact_diameter"] = round(10**R.uniform(-2.5, -1.7), 5)
    for kind, a, inside in walls:
        if not inside and kind in THIN:
            a[THIN[kind]] = round(10**R.uniform(-3, -1.7), 6)


def moving(R, o, walls, lines):
    """Displacements over time of some of the walls, by number; their rows are added to the lines."""
    led = {}
    for k in range(len(walls)):
        if R.random() < 0.5:
            t = np.sort([round(R.uniform(0, o["ts_max_time"]), 4) for _ in range(4)])
            if np.diff(t).min() <= 0:
                continue
            x = np.outer([0, 1, R.uniform(-1, 1), 0], [round(R.gauss(0, 0.1), 4) for _ in range(3)])
            rows = " ".join(f"{value:.17g}" for row in np.c_[t, x] for value in row)
            lines[k] = lines[k].replace(" friction", f" moves at {rows} friction")
            led[k] = PchipInterpolator(t, x)
    return led


def displaced(led, k, t):
    """By how much wall k is displaced at a time."""
    return led[k](np.clip(t, led[k].x[0], led[k].x[-1])) if k in led else 0


def curve(x, tangent, g, s, fine=8):
    """Points of the cubic between nodes."""
    z = np.linspace(0, 1, fine, endpoint=False)[:, None, None]
    h = np.diff(s)[:, None]
    a, b, u, v = x[:-1], x[1:], h * (g[:, None] * tangent)[:-1], h * (g[:, None] * tangent)[1:]
    return ((1 + 2 * z) * (1 - z) ** 2 * a + z * (1 - z) ** 2 * u + z * z * (3 - 2 * z) * b
            + z * z * (z - 1) * v).reshape(-1, 3)


def run(exe, o, walls, lines, limit, led):
    """What became of it, how deep it was pressed in, by what its energy is off, and the command."""
    folder = tempfile.mkdtemp()
    with open(f"{folder}/walls.txt", "w") as f:
        f.write("\n".join(lines) + "\n")
    file = f"{folder}/run.h5"
    command = [exe, *sum([["-" + k, str(v)] for k, v in o.items()], []), "-wall_file", f"{folder}/walls.txt",
               "-output_interval", "0.05", "-output", file]
    try:
        done = subprocess.run(command, capture_output=True, text=True, timeout=limit, env=ENVIRONMENT)
    except subprocess.TimeoutExpired:
        return "hung", 0, 0, " ".join(command)
    said = (done.stderr or done.stdout).strip()
    if not os.path.exists(file):
        refused = "the rod starts in a wall" in said
        return "refused" if refused else f"lost: {said[-200:]}", 0, 0, " ".join(command)
    with h5py.File(file) as f:
        shapes = {k: f["shapes"][k][:] for k in ("t", "x", "d1", "stretch")}
        s, deep = np.linspace(0, 1, shapes["x"].shape[1]), f["series/penetration"][:].max()
        s = f["s"][:] if "s" in f else s
        pressed = f["series/contact_force"][:].max() > 0
    for t, x, d1, g in zip(*shapes.values()):
        for k, wall in enumerate(walls):
            if distance(wall, curve(x, d1, g, s) - displaced(led, k, t)).min() < 0:
                return f"through {wall[0]}", deep, 0, " ".join(command)
    if deep > 0.01 * o["contact_diameter"] and "pressed in by more than 1 %" not in done.stdout:
        return "lost: is silent about how deep it is pressed", 0, 0, " ".join(command)
    if done.returncode:
        deep /= o["contact_diameter"]
        return ("jammed" if "jammed at" in said else f"lost: {said[-200:]}"), deep, 0, " ".join(command)
    off, told = balance(file)
    if off > told:
        return f"lost: energy is off by {off}, told is {told}", deep, off, " ".join(command)
    return "touched" if pressed else "free", deep / o["contact_diameter"], off, " ".join(command)


def balance(file):
    """By how much the energies of a run are off, and the largest error that it is told."""
    with h5py.File(file) as f:
        return f["series/energy_defect"][-1], f.attrs["error_estimate"]


def same(a, b):
    """Do two result files have the same series and shapes, to the last bit?"""
    with h5py.File(a) as f, h5py.File(b) as g:
        return all(np.array_equal(f[group][k][()], g[group][k][()])
                   for group in ("series", "shapes") for k in f[group])


def again(command, limit):
    """A scene that has run, broken and gone on with, and on two ranks: is it the same; how far is its tip off."""
    words = command.split()
    file, d = words[-1], os.path.dirname(words[-1])

    def execute(words):
        subprocess.run(words, capture_output=True, timeout=limit, env=ENVIRONMENT, check=False)

    with h5py.File(file) as f:
        pressed = np.flatnonzero(f["series/contact_force"][:] > 0)
        tip, length = f["shapes/x"][-1, -1], f["series/length"][-1]
    execute([*words[:-1], f"{d}/broken.h5", "-ts_max_steps", str(max(1, pressed[len(pressed) // 2]))])
    execute([words[0], "-restart", f"{d}/broken.h5", "-output", f"{d}/broken.h5"])
    execute(["mpiexec", "--bind-to", "none", "--oversubscribe", "-n", "2", *words[:-1], f"{d}/ranks.h5"])
    with h5py.File(f"{d}/ranks.h5") as f:
        off = np.linalg.norm(f["shapes/x"][-1, -1] - tip) / length
    return same(file, f"{d}/broken.h5"), off


def main():
    kinds = {word for word in sys.argv[1:] if word.startswith("--")}
    exe, seed, count, *more = (word for word in sys.argv[1:] if word not in kinds)
    seed, count = int(seed), int(count)
    limit, finer = float(more[0]) if more else 30, int(more[1]) if len(more) > 1 else 1
    R, tally, deepest, times, touched, differ, energies, jammed = random.Random(seed), {}, [], [], [], [], [], 0
    for _ in range(count):
        o, walls, lines = scene(R)
        if "--thin" in kinds:
            thinner(R, o, walls)
            lines = lines_of(R, walls)
        led = moving(R, o, walls, lines) if "--moving" in kinds else {}
        o["rod_cells"] *= finer
        if not walls:
            lines, walls = ["plane 0 0 -2 0 0 1"], [("plane", [0, 0, -2, 0, 0, 1], False)]
        begin = time.time()
        what, deep, off, command = run(exe, o, walls, lines, limit, led)
        times.append(time.time() - begin)
        deepest.append(deep)
        word = what.split(":")[0].split()[0]
        if word in ("touched", "jammed"):
            touched.append(deep)
            jammed += word == "jammed" and deep > 0.01
        if word == "touched":
            energies.append(off)
        if word == "touched" and len(touched) % 10 == 1:
            goes_on, off = again(command, 3 * limit)
            differ.append(off)
            if not goes_on:
                what, word = "lost: does not go on to the last bit", "lost"
        tally[word] = tally.get(word, 0) + 1
        if word in ("hung", "lost", "through"):
            print(what, "|", command, flush=True)
    print(f"{count} scenes: {tally}; penetration at most {100 * max(deepest):.2f} % of the diameter, "
          f"{sum(d > 0.01 for d in touched)} of {len(touched)} that touch above 1 %, {jammed} of them jammed; "
          f"energy off by more than 1e-5 in {sum(e > 1e-5 for e in energies)} of {len(energies)}, by "
          f"{np.median(energies or 0):.1e} in the middle, {max(energies, default=0):.1e} at most; {len(differ)} gone on with to the "
          f"last bit, on two ranks off by at most {max(differ, default=0):.1e}; "
          f"median of the times {np.median(times):.2f} s, at most {max(times):.1f} s")
    return any(tally.get(k) for k in ("hung", "lost", "through"))


if __name__ == "__main__":
    sys.exit(main())

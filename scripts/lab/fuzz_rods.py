#!/usr/bin/env python3
"""Random scenes of 2 to 12 rods that touch: each at the defaults, against a hundredth of the tolerance on twice the cells.

    fuzz_rods.py EXE SEED COUNT [--join]

Rods begin on a lattice, lean towards each other, grow or are fed, bend by nature, weigh something, with friction between them and
a floor in half of the scenes; --join: some hang on others. A scene is lost if it gives up or hangs, or if any tip is off
by more than 1 % of the length and by more than its run tells. Prints these with their options, and a summary; exit 1 if any is lost. Files are left under /tmp/fuzz-rods-SEED."""

import subprocess
import sys
from pathlib import Path

import h5py
import numpy as np

from fuzz import Draw

LIMIT, REFERENCE_LIMIT = 120, 400  # seconds
TIP = 1e-2


def vector(numbers):
    return ",".join(f"{x:.3g}" for x in numbers)


def own_lines(draw, place, middle):
    """The options of one rod at a place, which leans towards the middle."""
    way = middle - place
    way = way / max(np.linalg.norm(way), 1e-9) + np.array([draw.between(-.5, .5) for _ in range(3)])
    o = {"clamp_place": vector(place), "clamp_direction": vector(way / np.linalg.norm(way))}
    if draw.happens(.6):
        o["rod_curvature"] = draw.between(-.6, .6)
    if draw.happens(.4):
        o["rod_curvature_2"] = draw.between(-.6, .6)
    if draw.happens(.3):
        o["contact_diameter"] = draw.between(.02, .06)
    if draw.happens(.2):
        o["growth_type"] = draw.choice(["none", "feed"])
    return o


def scene(draw, path, join):
    """The text of a scene."""
    n = draw.choice([2, 2, 3, 3, 4, 5, 6, 8, 12])
    side = int(np.ceil(n ** .5))
    shared = {"growth_type": draw.choice(["uniform", "feed"]), "growth_initial_length": .4, "shape_type": "straight",
              "contact_diameter": draw.between(.03, .06), "contact_friction": draw.choice([0, 0, .2, .4]),
              "friction_mu": draw.choice([0, 1, .5]), "friction_beta": 1e-3, "ts_max_time": draw.between(.5, 1), "rod_cells": 24}
    if draw.happens(.4):
        shared["rod_weight"] = vector([draw.between(-1, 1), 0, draw.between(-2, 0)])
    if draw.happens(.5):
        wall = path / "floor.txt"
        wall.write_text(f"plane 0 0 -0.3 0 0 1 friction {draw.choice([0, .3])}\n")
        shared["wall_file"] = wall
    lines = [f"-{k} {v}" for k, v in shared.items()]
    middle = np.array([side * .2, side * .2, .2])
    for k in range(n):
        place = np.array([k % side * .4, k // side * .4, draw.between(-.1, .1)])
        o = own_lines(draw, place, middle)
        if join and k and draw.happens(.3):
            o = {x: v for x, v in o.items() if x not in ("clamp_place", "growth_type")}
            o |= {"clamp_on": "r0", "clamp_at": "tip"}
        lines += [f"[rod r{k}]"] + [f"-{x} {v}" for x, v in o.items()]
    names = " ".join(f"r{k}" for k in range(n))
    return "\n".join(lines + [f"[pair {names}]", ""]), n


def run(exe, file, out, more, limit):
    try:
        done = subprocess.run([exe, "-options_file", str(file), "-output", str(out), "-quiet", *more], capture_output=True, text=True, timeout=limit)
    except subprocess.TimeoutExpired:
        return "hangs"
    return done.stderr.strip() if done.returncode else ""


def tips(out):
    with h5py.File(out) as f:
        x, last = f["shapes/x"][-1], f["rods/first"][:] + f["rods/count"][:] - 1
        told = [f[f"rods/of/{name.decode()}"].attrs.get("error_end_tip", np.nan) for name in f["rods/name"]]
        length = f["rods/series/length"][-1]
        return x[last], np.array(told), length, f["series/penetration"][:].max(), f["series/contact_force"][:].max(), len(f["series/t"])


def look(exe, seed, number, folder, join):
    """lost, wrong, told or fine, and a line about it."""
    draw, path = Draw(1000 * seed + number), folder / str(number)
    path.mkdir(parents=True, exist_ok=True)
    text, n = scene(draw, path, join)
    file = path / "scene.opts"
    file.write_text(text)
    fault = run(exe, file, path / "a.h5", [], LIMIT)
    if "deep in each other" in fault or "starts in a wall" in fault:
        return "none", "begins within"
    if fault:
        return "lost", f"{n} rods: {fault[:160]}"
    a, told, length, deep, force, steps = tips(path / "a.h5")
    fault = run(exe, file, path / "b.h5", ["-ts_rtol", "1e-7", "-rod_cells", "48"], REFERENCE_LIMIT)
    if fault:
        return "unknown", f"{n} rods, {steps} steps: no reference: {fault[:100]}"
    off = np.linalg.norm(a - tips(path / "b.h5")[0], axis=1) / length
    worst = int(np.argmax(off))
    about = f"{n} rods, {steps} steps, force {force:.2g}, deep {deep:.1e}, off {off[worst]:.1e}, told {told[worst]:.1e}"
    if off[worst] > TIP and not off[worst] < told[worst]:
        return "wrong", about
    return "told" if off[worst] > TIP else "fine", about


def main():
    exe, seed, count = sys.argv[1], int(sys.argv[2]), int(sys.argv[3])
    folder = Path(f"/tmp/fuzz-rods-{seed}")
    found = {}
    for number in range(count):
        verdict, about = look(exe, seed, number, folder, "--join" in sys.argv)
        found[verdict] = found.get(verdict, 0) + 1
        print(f"{number}: {verdict}: {about}", flush=True)
    print(found)
    sys.exit(bool(found.get("lost") or found.get("wrong")))


if __name__ == "__main__":
    main()

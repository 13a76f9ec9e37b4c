#!/usr/bin/env python3
"""Rods in space on walls where nothing is 0 to the last digit: what a frame, or a symmetry, hides.

    scripts/lab/oblique.py lengthways|fed [--scenes COUNT] [--seed SEED] [--kinds KIND,...] [--tendril build/tendril]

lengthways: straight rods that nothing holds sink onto cylinders (from inside and outside), balls and meshes, most of them
all along at once. fed: rods are fed along the inside of spheres, cylinders, cones, rings, tubes of points and meshes, and
along planes, each beside its turned self, whose clamp is oblique to the axes of the laboratory: turned back, its tip is the same. Prints a line for
each scene that is lost, with the command, and how large the rest is; those that end in a true line (jammed; dry, and nothing
stops their fall; start in a wall) are counted. Exit code 1 if any is lost or another one."""

import argparse
import shlex
import subprocess
import sys
import tempfile

import h5py
import numpy as np
from invariances import ENVIRONMENT, ROOT

sys.path.insert(0, str(ROOT / "scripts"))
LIMIT = 120  # seconds of a run
APART = {"body": 1e-4}  # tips, of the rod's length: a mesh's distance is laid on another grid


def unit(v):
    return np.asarray(v, float) / np.linalg.norm(v)


def said(*numbers):
    return " ".join(repr(float(a)) for a in np.concatenate([np.ravel(n) for n in numbers]))


def smallest_turn(d):
    """That which takes the clamp's frame from e1 to d."""
    axis = np.cross([1, 0, 0], d)
    K = np.cross(axis, np.eye(3)).T
    return np.eye(3) + K + K @ K / (1 + d[0])


def capsule(radius, length, rows=24):
    """Points and triangles of a ball that is drawn out along x1."""
    a, b = np.linspace(0, np.pi, rows + 1)[1:-1, None], np.pi * np.arange(2 * rows) / rows
    rings = np.stack([np.cos(a) + 0 * b, np.sin(a) * np.cos(b), np.sin(a) * np.sin(b)], -1)
    rings = np.insert(rings, rows // 2, rings[rows // 2 - 1], 0) if length else rings
    x = radius * np.concatenate([rings.reshape(-1, 3), [[1, 0, 0], [-1, 0, 0]]])
    n, m = len(rings), 2 * rows
    half = np.append(np.repeat(np.arange(n) < n // 2, m), [True, False])
    x[:, 0] += np.where(half, length / 2, -length / 2)
    at, i, j = np.arange(n - 1)[:, None] * m, np.arange(m), (np.arange(m) + 1) % m
    return x, np.concatenate([np.stack([at + i, at + m + i, at + m + j], -1).reshape(-1, 3),
                              np.stack([at + i, at + m + j, at + j], -1).reshape(-1, 3),
                              np.stack([np.full(m, len(x) - 2), i, j], -1),
                              np.stack([np.full(m, len(x) - 1), (n - 1) * m + j, (n - 1) * m + i], -1)])


def body(folder, name, points, triangles, D, side):
    """The line of a mesh."""
    from tendril import surface
    rows = ["v {!r} {!r} {!r}".format(*map(float, x)) for x in points]
    rows += ["f {} {} {}".format(*t) for t in triangles + 1]
    (folder / f"{name}.obj").write_text("\n".join(rows) + "\n")
    surface(folder / f"{name}.obj", folder / f"{name}.h5", diameter=D, side=side)
    return f"body {name}.h5 {side}"


def run(tendril, folder, options, wall):
    """(what became of it, the command, its tip over its length)"""
    (folder / "walls.txt").write_text(wall + "\n")
    command = [tendril, *shlex.split(options), "-ts_max_steps", "3000", "-wall_file", str(folder / "walls.txt"), "-output", str(folder / "a.h5")]
    try:
        done = subprocess.run(command, capture_output=True, text=True, timeout=LIMIT, env=ENVIRONMENT)
    except subprocess.TimeoutExpired:
        return "lost: does not end", " ".join(command), None
    line = done.stderr.strip()[-300:]
    if "the rod starts in a wall" in line:
        return "refused", " ".join(command), None
    true = [word for word, said in (("jammed", "jammed at"), ("falls", "falls at once, without end")) if said in line]
    what = "ends" if not done.returncode else f"{true[0] if true else 'lost'}: {line}"
    with h5py.File(folder / "a.h5") as f:
        s = f["series"]
        tip = np.array([s[f"tip_x{k}"][-1] for k in (1, 2, 3)]) / s["length"][-1]
        if what == "ends" and not s["contact_force"][:].any():
            what = "free"
    return what, f"{' '.join(command)} ({wall[:200]})", tip


# ---- straight rods that sink ----


def sinking(dice, folder, kind):
    """(options, wall)"""
    def one_of(*choices):
        return dice.choice(choices)
    D, rub, mu = float(one_of(0.05, 0.1)), float(one_of(0, 0.1, 0.3)), float(one_of(0, 0, 0.1, 0.3, 0.5, 0.9, 1))
    clamp = unit([1, *dice.uniform(-1, 1, 2)]) if dice.random() < 0.5 else np.array([1., 0, 0])
    Q = smallest_turn(clamp)
    down, side = Q @ [0, 0, -1], Q @ [0, 1, 0]
    weight = 10 ** dice.uniform(0.1, 1) * (down + dice.uniform(-0.4, 0.4) * side)
    drop, R = dice.uniform(0.1, 0.3), dice.uniform(0.2, 0.5)
    across = unit(down + dice.uniform(-0.3, 0.3) * side) if dice.random() < 0.5 else unit(weight)
    axis = unit(clamp + dice.choice([0, 0, 0.1]) * dice.normal(size=3))
    middle = clamp / 2 + (drop + D / 2 + R) * across
    if kind == "cylinder" and dice.random() < 0.6:
        wall = f"cylinder {said(clamp / 2, axis, R + drop + D)} inside"
    elif kind == "cylinder":
        wall = f"cylinder {said(middle, axis, R)} outside"
    elif kind == "sphere":
        wall = f"sphere {said(middle, R)} outside"
    else:
        points, triangles = capsule(R, float(dice.choice([0, 1])))
        wall = body(folder, "body", middle + points @ smallest_turn(axis).T, triangles, D, "outside")
        wall = wall.replace("body.h5", str(folder / "body.h5"))
    return (f"-rod_model space -growth_type none -clamp_type free -shape_type straight -growth_initial_length 1 "
            f"-friction_radius {D / 2} -contact_diameter {D} -ts_max_time {1 / np.linalg.norm(weight):.4f} -rod_cells 50 "
            f"-friction_mu {mu} -rod_weight {said(weight).replace(' ', ',')} "
            f"-clamp_direction {said(clamp).replace(' ', ',')}"), f"{wall} friction {rub}"


def lengthways(tendril, folder, scenes, seed, kinds):
    """Faults as text."""
    faults, tally = [], {}
    for k in range(scenes):
        dice = np.random.default_rng([seed, k])
        kind = kinds[k % len(kinds)]
        what, command, _ = run(tendril, folder, *sinking(dice, folder, kind))
        word = f"{kind} {what.split(':')[0]}"
        tally[word] = tally.get(word, 0) + 1
        if what.startswith("lost"):
            faults.append(f"scene {k}, {what} | {command}")
    print(f"{scenes} scenes, seed {seed}: {tally}")
    return faults


# ---- rods that are fed into what is hollow ----


def hollow(dice, kind):
    """(options, wall in the clamp's frame): the clamp is near the wall, and straight along it or towards it. Of those in
    balls half are bent in a plane, where nothing drives them out of it; elsewhere that may be unstable."""
    R, D = dice.uniform(0.5, 1.5), float(dice.choice([0.02, 0.05, 0.1]))
    flat, lean = kind in ("sphere", "body") and dice.random() < 0.5, dice.uniform(0.1, 0.5)
    turn = 0 if flat else dice.uniform(-3, 3)
    to_middle = np.array([0, np.cos(turn), np.sin(turn)])
    bends = dice.uniform(0.05, 0.4, 2) * dice.choice([-1, 1], 2) / R
    options = (f"-rod_model space -shape_type straight -growth_type feed -growth_initial_length {0.2 * R:.4f} "
               f"-ts_max_time {dice.uniform(1.5, 4) * R:.4f} -friction_mu {dice.choice(['0', '0.5', '0.9'])} -rod_cells 60 "
               f"-contact_diameter {D} -rod_curvature {bends[0]:.4f} -rod_curvature_2 {0 if flat else bends[1]:.4f} "
               "-ts_rtol 1e-6")
    wall = {"kind": kind, "R": R, "D": D, "axis": unit(np.array([1, 0, 0]) + (lean * to_middle if kind == "cylinder" else 0)),
            "at": (R - D / 2 - dice.uniform(0.02, 0.2) * R) * to_middle, "rub": float(dice.choice([0, 0.1, 0.3]))}
    beside = np.cross([1, 0, 0], to_middle)  # (the axis of a cylinder leans, so that it comes to meet the rod)
    if kind == "plane":
        wall["axis"] = unit(to_middle - lean * np.array([1, 0, 0]))
        wall["at"] = -(D / 2 + 0.2 * R) * wall["axis"]
    if kind == "cone":  # of half the radius at its other end
        wall |= {"at": wall["at"] - [0.5 * R, 0, 0], "ring": 1.1 * R, "long": 6 * R}
    if kind == "torus":
        ring = dice.uniform(2, 4) * R
        wall |= {"ring": ring, "axis": beside, "at": wall["at"] + ring * dice.choice([-1, 1]) * to_middle}
    if kind == "tube":
        z = np.linspace(-R, 4 * R, 11)[:, None]
        wall["points"] = wall["at"] + z * [1, 0, 0] + 0.8 * R * np.sin(0.5 * z / R)**2 * (beside + to_middle)
    return options, wall


def turned(wall, Q, folder):
    """Its line."""
    kind, R, at, axis = wall["kind"], wall["R"], Q @ wall["at"], Q @ wall["axis"]
    if kind == "tube":
        line = f"tube inside {said(*(np.append(Q @ x, R) for x in wall['points']))}"
    elif kind == "body":
        points, triangles = capsule(R, 0, 32)
        line = body(folder, "body", at + points, triangles, wall["D"], "inside").replace("body.h5", str(folder / "body.h5"))
    else:
        numbers = {"plane": (at, axis), "sphere": (at, R), "cylinder": (at, axis, R), "torus": (at, axis, wall.get("ring"), R),
                   "cone": (at, axis, wall.get("ring"), R / 2, wall.get("long"))}[kind]
        line = f"{kind} {said(*numbers)}{' inside' if kind != 'plane' else ''}"
    return f"{line} friction {wall['rub']}"


def fed(tendril, folder, scenes, seed, kinds):
    """Faults as text."""
    faults, tally, most = [], {}, {}
    for k in range(scenes):
        dice = np.random.default_rng([seed, k])
        kind = kinds[k % len(kinds)]
        options, wall = hollow(dice, kind)
        direction = unit(dice.normal(size=3))
        Q = smallest_turn(direction)
        what, command, tip = run(tendril, folder, options, turned(wall, np.eye(3), folder))
        other, again, there = run(tendril, folder, f"{options} -clamp_direction {said(direction).replace(' ', ',')}",
                                  turned(wall, Q, folder))
        for words, line in ((what, command), (other, again)):
            word = f"{kind} {words.split(':')[0]}"
            tally[word] = tally.get(word, 0) + 1
            if words.startswith("lost"):
                faults.append(f"scene {k}, {words} | {line}")
        if what == other and tip is not None:
            off = np.abs(Q.T @ there - tip).max()
            most.setdefault(kind, []).append(off)
            if not off < APART.get(kind, 1e-5):
                faults.append(f"scene {k}, tips are {off:.1e} apart | {command} | {again}")
    print(f"{scenes} scenes, seed {seed}: {tally}; tips apart by at most",
          ", ".join(f"{kind} {max(off):.1e}" for kind, off in most.items()))
    return faults


def main():
    from pathlib import Path
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("study", choices=["lengthways", "fed"])
    parser.add_argument("--tendril", default=str(ROOT / "build/tendril"))
    parser.add_argument("--scenes", type=int, default=50)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--kinds", default="")
    choice = parser.parse_args()
    study, kinds = {"lengthways": (lengthways, "cylinder,sphere,cylinder,body"),
                    "fed": (fed, "sphere,cylinder,cone,torus,tube,body,plane")}[choice.study]
    with tempfile.TemporaryDirectory(prefix="tendril-") as folder:
        faults = study(choice.tendril, Path(folder), choice.scenes, choice.seed, (choice.kinds or kinds).split(","))
    for fault in faults:
        print("FAIL", fault)
    return len(faults) > 0


if __name__ == "__main__":
    sys.exit(main())

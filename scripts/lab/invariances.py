#!/usr/bin/env python3
"""What must not change a rod, on random scenes: mirrored, turned, in other units, on more ranks, stopped
and gone on with, grown from a later time, with its walls named in another order.

    scripts/lab/invariances.py [--scenes COUNT] [--seed SEED] [--cells N] [--space] [--ranks no|only] [--tendril build/tendril]
                               [--mpiexec mpiexec]

--space: rods in space, turned about the clamp's axis, their clamp turned in the laboratory, their mirror images (a
left-handed one for a right-handed one), on ranks, stopped and gone on with. Prints a line a scene and invariance that fails, with the command, and how large the rest are. Exit code 1
if any fails."""

import argparse
import os
import shlex
import subprocess
import sys
import tempfile
from pathlib import Path

import h5py
import numpy as np

ROOT = Path(__file__).resolve().parents[2]
ENVIRONMENT = dict(os.environ, OMPI_ALLOW_RUN_AS_ROOT="1", OMPI_ALLOW_RUN_AS_ROOT_CONFIRM="1",
                   OMPI_MCA_rmaps_base_oversubscribe="1", OMP_NUM_THREADS="1",
                   PRTE_MCA_rmaps_default_mapping_policy=":oversubscribe",
                   OMPI_MCA_mpi_yield_when_idle="1")
LIMIT = 900  # seconds of a run; more is a hang, however busy the machine
RTOL = 1e-6
# how far the tip may go, of the rod's length: what is the same to the last bit, what is the same run
# with other round-off, and what is another run of the same rod
BITS, SAME, ANOTHER = 1e-12, 2e-5, 2e-4
TURNED = 1e-6  # a rod in space, in steps of its own: what Newton's method leaves where dry friction all but holds


class Lost(Exception):
    """The scene itself does not run: another test's matter."""


class Place:
    def __init__(self, directory, choice):
        self.directory, self.tendril, self.mpiexec, self.ranks = Path(directory), choice.tendril, choice.mpiexec, choice.ranks

    def run(self, options, ranks=1, file="a.h5", code=0):
        """The tip and the length at the end."""
        launch = [self.mpiexec, "-n", str(ranks), "--bind-to", "none"] if ranks > 1 else []
        command = [*launch, self.tendril, *shlex.split(options), "-output", str(self.directory / file)]
        done = subprocess.run(command, capture_output=True, text=True, env=ENVIRONMENT, timeout=LIMIT)
        if (done.returncode != 0) != code:
            raise Lost(done.stderr.strip()[-300:])
        with h5py.File(self.directory / file) as f:
            s = f["series"]
            return np.array([s[f"tip_x{k}"][-1] for k in (1, 2, 3) if f"tip_x{k}" in s]), s["length"][-1]

    def walls(self, lines, name="walls.txt"):
        (self.directory / name).write_text("".join(line + "\n" for line in lines))
        return f"-wall_file {self.directory / name} -contact_diameter 0.05 "


def random_scene(dice, cells=120):
    """(options, curvature, walls); the shape is straight, bent by its curvature alone, so that its
    mirror image has one option of another sign."""
    law = dice.choice(["uniform", "gaussian", "feed", "apical"])
    mu = dice.choice(["0", "0.5", "1"])
    length = dice.uniform(0.5, 2)
    end = dice.uniform(1, 5)
    options = (f"-growth_type {law} -growth_initial_length {length:.3f} -ts_max_time {end:.3f} "
               f"-friction_mu {mu} -friction_across {dice.choice([0.5, 1, 2])} -shape_type straight "
               f"-rod_cells {cells} -ts_rtol {RTOL} ")
    if law == "apical":
        options += f"-growth_zone {length * dice.uniform(0.3, 1):.3f} "
    if dice.random() < 0.3:
        options += f"-tip_force {dice.uniform(0, 0.5):.3f} -tip_law {dice.choice(['dead', 'follower'])} "
    walls = []
    if dice.random() < 0.4:
        far = length + dice.uniform(0.5, 2)
        walls = [f"plane {far:.3f} 0 -1 {dice.uniform(-0.3, 0.3):.3f}",
                 f"circle {far - 0.4:.3f} {-dice.uniform(0.7, 1):.3f} 0.3 outside",
                 f"plane 0 {-dice.uniform(1.5, 3):.3f} 0 1"]
    return options, float(dice.choice([-1, 1]) * 10 ** dice.uniform(-2.5, -0.7)), walls


def mirrored(walls):
    """By the line of the clamp: the second of each pair of numbers changes its sign."""
    where = {"plane": (2, 4), "circle": (2,)}
    lines = [line.split() for line in walls]
    for words in lines:
        for k in where[words[0]]:
            words[k] = str(-float(words[k]))
    return [" ".join(words) for words in lines]


def turned(walls, alpha):
    lines = [line.split() for line in walls]
    for words in lines:
        for k in (1, 3) if words[0] == "plane" else (1,):
            x, y = (float(w) for w in words[k:k + 2])
            words[k] = repr(float(np.cos(alpha) * x - np.sin(alpha) * y))
            words[k + 1] = repr(float(np.sin(alpha) * x + np.cos(alpha) * y))
    return [" ".join(words) for words in lines]


def with_walls(place, walls):
    return place.walls(walls) if walls else ""


def off(a, b):
    return np.linalg.norm(a[0] - b[0]) / b[1]


def on_ranks(place, whole, dice, it=None):
    """Alone, in steps as they are by default: each step costs ranks messages."""
    if not it:
        whole = whole.replace(f"-ts_rtol {RTOL} ", "")
        it = place.run(whole)
    yield "ranks", off(place.run(whole, ranks=int(dice.integers(2, 4))), it), SAME


def invariances(place, scene, dice):
    """(name, how far off, how far it may be) one by one."""
    options, curvature, walls = scene
    bent = f"-rod_curvature {curvature!r} "
    whole = f"{options}{bent}{with_walls(place, walls)}"
    if place.ranks == "only":
        yield from on_ranks(place, whole, dice)
        return
    it = place.run(whole)
    other = place.run(f"{options}-rod_curvature {-curvature!r} {with_walls(place, mirrored(walls))}")
    yield "mirror", off((other[0] * [1, -1], 0), it), BITS if not walls else SAME
    alpha = float(dice.uniform(-3, 3))
    other = place.run(f"{options}{bent}-clamp_angle {alpha!r} "
                      f"{with_walls(place, turned(walls, alpha))}")
    c, s = np.cos(alpha), np.sin(alpha)
    yield "turn", off((np.array([[c, s], [-s, c]]) @ other[0], 0), it), SAME
    if "-friction_mu 1 " in options:
        si = f"-si_bending_stiffness {float(10 ** dice.uniform(-6, 0))!r} -si_friction_dry 2 -si_speed 0.1 "
        other = place.run(f"{options}{bent}{si}{with_walls(place, walls)}".replace("-friction_mu 1 ", ""))
        yield "units", off(other, it), SAME
    whole = f"{options}{bent}{with_walls(place, walls)}"
    if place.ranks == "too":
        yield from on_ranks(place, whole, dice, it)
    place.run(f"{whole} -ts_max_steps {int(dice.integers(5, 40))}", code=1, file="b.h5")
    with h5py.File(place.directory / "b.h5") as f:
        begun = len(f["series/t"]) > 1
    if begun:
        yield "restart", off(place.run(f"-restart {place.directory / 'b.h5'}", file="b.h5"), it), BITS
    end = float(options.split("-ts_max_time ")[1].split()[0])
    place.run(whole.replace(f"-ts_max_time {end:.3f}", f"-ts_max_time {end / 3:.3f}"), file="c.h5")
    other = place.run(f"-restart {place.directory / 'c.h5'} -ts_max_time {end:.3f}", file="c.h5")
    yield "later end", off(other, it), ANOTHER
    if walls:
        yield "order of walls", off(place.run(f"{options}{bent}{place.walls(walls[::-1])}"), it), SAME


def random_rod_in_space(dice, cells=60):
    """(options that no turn and no mirror changes, what turns: vectors and bends)"""
    law, mu = dice.choice(["uniform", "gaussian", "feed", "apical"]), dice.choice(["0", "0.5", "0.9", "1"])
    options = (f"-rod_model space -shape_type straight -growth_type {law} -growth_initial_length {dice.uniform(0.5, 2):.3f} "
               f"-growth_zone 0.4 -ts_max_time {dice.uniform(0.5, 2):.3f} -friction_mu {mu} "
               f"-friction_across {dice.choice([0.5, 1, 2])} -rod_torsion {dice.uniform(0.4, 1.5):.3f} -rod_cells {cells} ")
    if law != "apical":
        options = options.replace("-growth_zone 0.4 ", "")
    rod = {"bends": dice.uniform(-0.4, 0.4, 2), "twist": dice.uniform(-0.5, 0.5), "weight": np.zeros(3), "force": np.zeros(3),
           "torque": 0., "spin": 0., "ratio": 1., "radius": 0., "clamp": np.array([1., 0, 0])}
    for name, draw in {"weight": lambda: dice.uniform(-0.3, 0.3, 3), "force": lambda: dice.uniform(-0.1, 0.1, 3),
                       "torque": lambda: dice.uniform(-0.3, 0.3), "ratio": lambda: dice.uniform(0.4, 3)}.items():
        if dice.random() < 0.4:
            rod[name] = draw()
    if dice.random() < 0.4:
        rod |= {"radius": 0.2, "spin": dice.uniform(-0.5, 0.5)}
    if mu == "0.9" and dice.random() < 0.5:
        options += "-friction_beta 0 "
    return options, rod


def said(options, rod):
    def vector(v):
        return ",".join(repr(float(a)) for a in v)
    text = (f"{options}-rod_curvature_2 {float(rod['bends'][0])!r} -rod_curvature {float(rod['bends'][1])!r} "
            f"-rod_twist {float(rod['twist'])!r} -rod_bend_ratio {float(rod['ratio'])!r} -clamp_direction {vector(rod['clamp'])} ")
    for name, option in {"weight": "rod_weight", "force": "tip_force_vector"}.items():
        if rod[name].any():
            text += f"-{option} {vector(rod[name])} "
    for name, option in {"torque": "tip_torque", "radius": "friction_radius", "spin": "clamp_spin"}.items():
        if rod[name]:
            text += f"-{option} {float(rod[name])!r} "
    return text


def invariances_in_space(place, scene, dice):
    """As invariances(). Sections of two stiffnesses are not turned about the clamp's axis: they have axes."""
    options, rod = scene
    whole = said(options, rod) + f"-ts_rtol {RTOL} "
    if place.ranks == "only":
        yield from on_ranks(place, whole, dice)
        return
    it = place.run(whole)

    def turned(R, **more):
        return rod | {k: R @ rod[k] for k in ("weight", "force")} | more
    if rod["ratio"] == 1:
        angle = dice.uniform(-3, 3)
        c, s = np.cos(angle), np.sin(angle)
        R = np.array([[1, 0, 0], [0, c, -s], [0, s, c]])
        other = place.run(said(options, turned(R, bends=R[1:, 1:] @ rod["bends"])) + f"-ts_rtol {RTOL} ")
        yield "turn about the clamp's axis", off((R.T @ other[0], 0), it), TURNED
    d = dice.normal(size=3)
    d /= np.linalg.norm(d)
    axis, c = np.cross([1, 0, 0], d), d[0]  # the clamp's frame is turned about e1 x d
    K = np.cross(axis, np.eye(3)).T
    Q = np.eye(3) + K + K @ K / (1 + c)
    other = place.run(said(options, turned(Q, clamp=d)) + f"-ts_rtol {RTOL} ")
    yield "turn of the clamp", off((Q.T @ other[0], 0), it), TURNED
    flat = np.diag([1, 1, -1])
    other = place.run(said(options, turned(flat, bends=rod["bends"] * [-1, 1], twist=-rod["twist"], torque=-rod["torque"],
                                           spin=-rod["spin"])) + f"-ts_rtol {RTOL} ")
    yield "mirror, other hand", off((flat @ other[0], 0), it), BITS
    if place.ranks == "too":
        yield from on_ranks(place, whole, dice, it)
    place.run(f"{whole} -ts_max_steps {int(dice.integers(5, 40))}", code=1, file="b.h5")
    yield "restart", off(place.run(f"-restart {place.directory / 'b.h5'}", file="b.h5"), it), 0


def study(place, count, seed, verbose=True, space=False, cells=None):
    """Faults as text."""
    faults, most = [], {}
    draw, check = (random_rod_in_space, invariances_in_space) if space else (random_scene, invariances)
    for k in range(count):
        dice = np.random.default_rng([seed, k])
        scene = draw(dice, cells) if cells else draw(dice)
        try:
            for name, far, allowed in check(place, scene, dice):
                most[name] = max(most.get(name, 0), far)
                if not far <= allowed:
                    faults.append(f"{name}: off by {far:.1e}, not {allowed:g}: "
                                  + (said(*scene) if space else f"{scene[0]}-rod_curvature {scene[1]!r}, walls {scene[2]}"))
        except (Lost, subprocess.TimeoutExpired) as error:
            faults.append(f"lost: {error}: {scene}")
    if verbose:
        print(f"{count} scenes, seed {seed}; farthest:",
              ", ".join(f"{name} {far:.1e}" for name, far in most.items()))
    return faults


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--tendril", default=str(ROOT / "build/tendril"))
    parser.add_argument("--mpiexec", default="mpiexec")
    parser.add_argument("--scenes", type=int, default=40)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--cells", type=int)
    parser.add_argument("--space", action="store_true")
    parser.add_argument("--ranks", choices=["too", "no", "only"], default="too")
    choice = parser.parse_args()
    with tempfile.TemporaryDirectory(prefix="tendril-") as directory:
        faults = study(Place(directory, choice), choice.scenes, choice.seed, space=choice.space, cells=choice.cells)
    for fault in faults:
        print("FAIL", fault)
    return len(faults) > 0


if __name__ == "__main__":
    sys.exit(main())

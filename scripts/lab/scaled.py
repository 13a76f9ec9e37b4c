#!/usr/bin/env python3
"""A scene without units is one of many that are the same but for their scales: do they take the same steps?

    scripts/lab/scaled.py [--walls] [--scenes COUNT] [--seed SEED] [--scale C,C] [--tendril build/tendril]

Random scenes without contact, or with walls that they touch, each with its lengths times C (1e-3 and 1e3 unless told otherwise), times as friction
has it, forces over C^2, forces per length over C^3. Prints steps and iterations of each, with the command of those that
differ by more than 1 % (of three steps at least). Where dry friction lets a rod snap, round-off alone may do that: such a
scene is run with its numbers off by parts of 3e-14, too, and its scaled runs may differ from one of these by 1 %, or by
as much as these do among themselves. Exit code 1 if any differs by more."""

import argparse
import math
import os
import random
import re
import shlex
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
ENVIRONMENT = dict(os.environ, OMP_NUM_THREADS="1", OMPI_ALLOW_RUN_AS_ROOT="1", OMPI_ALLOW_RUN_AS_ROOT_CONFIRM="1")
SUMMARY = re.compile(r"(\d+) steps, \d+ rejected, (\d+) Newton iterations")
PART, FEWEST, LIMIT = 0.01, 3, 120  # what may differ; seconds of a run
PLACE = tempfile.TemporaryDirectory(prefix="scaled-")
ROUND_OFF, TIMES = 3e-14, 4  # how far numbers are moved, and how often
LENGTH, TIME, FORCE, PER_LENGTH, BEND = "length", "time", "force", "per length", "bend"


def about(dice, least, most):
    """A number of three digits, its logarithm anywhere between."""
    return float(f"{math.exp(dice.uniform(math.log(least), math.log(most))):.3g}")


class Scene:
    """Options, each a list of numbers of one dimension, and how friction is."""

    def __init__(self, dice, walls=False):
        self.options, self.plain, self.walls = {}, [], []
        self.length = about(dice, 0.1, 3)
        self.grows = dice.choice(["uniform", "feed", "apical", "gaussian", "none", "none"])
        self.viscous = dice.choice([0, 0.01, 0.5, 1] if self.grows != "none" else [0.01, 0.1, 0.5, 1, 1])
        self.beta = about(dice, 1e-6, 1e-2)
        self.factor = dice.choice([1, 1, about(dice, 0.1, 10)])
        # speeds of growth are 1 in any unit; times of a rod that does not grow may go otherwise than its lengths
        self.power = 1 if self.grows != "none" else dice.choice([0.5, 1, 1.5])
        self.put("growth_initial_length", LENGTH, self.length)
        self.put("ts_max_time", TIME, about(dice, 0.3, 3))
        self.plain += [f"-growth_type {self.grows}", "-rod_cells 60"]
        if self.grows == "apical":
            self.put("growth_zone", LENGTH, self.length / 2)
        self.bend(dice)
        self.load(dice)
        if walls:
            self.wall(dice)

    def put(self, name, dimension, *values):
        self.options[name] = (dimension, values)

    def bend(self, dice):
        """How it is bent, and held."""
        shape = dice.choice(["straight", "sag", "random", "mode"])
        self.plain.append(f"-shape_type {shape}")
        if shape != "straight":
            self.plain.append(f"-shape_amplitude {about(dice, 0.02, 1)}")
        if shape == "random":
            self.plain.append(f"-shape_seed {dice.randint(1, 99)}")
        if shape == "straight" or dice.random() < 0.3:
            self.put("rod_curvature", BEND, about(dice, 0.01, 0.5) / self.length)
        elif self.grows in ("uniform", "none"):
            self.plain.append(f"-tip_type {dice.choice(['free', 'pinned', 'clamped'])}")
            if dice.random() < 0.5 and shape == "random":
                self.plain.append("-clamp_type hinged")
        if dice.random() < 0.25:
            self.plain.append("-rod_model space")

    def load(self, dice):
        """What pushes."""
        if dice.random() < 0.4:
            self.put("rod_weight", PER_LENGTH, 0, -about(dice, 0.1, 20) / self.length**3)
        if dice.random() < 0.3 and not any("pinned" in o or "clamped" in o for o in self.plain):
            self.put("tip_force", FORCE, about(dice, 0.1, 20) / self.length**2)

    def wall(self, dice):
        """What it meets: walls are words, and numbers that are lengths."""
        L, slant = self.length, round(dice.uniform(-0.5, 0.5), 3)
        thick = about(dice, 0.02, 0.1) * L
        if dice.random() < 0.9:
            self.put("contact_diameter", LENGTH, thick)
        rub = "" if dice.random() < 0.5 else f" friction {dice.choice([0.1, 0.3])}"
        self.walls = dice.choice([
            [("plane", (about(dice, 1.1, 1.5) * L, 0), f"-1 {slant}{rub}")],
            [("plane", (0, 0.5 * L), f"0 -1{rub}"), ("plane", (0, -0.2 * L), f"0 1{rub}")],
            [("circle", (0.3 * L, 0.05 * L, about(dice, 1.3, 1.8) * L), f"inside{rub}")],
            [("circle", (1.5 * L, 0.1 * L, 0.3 * L), f"outside{rub}")]])
        if dice.random() < 0.2 and "contact_diameter" in self.options:
            self.plain.append("-contact_self true")

    def scaled(self, c, off=0):
        """The options with lengths times c, all numbers too large by a part; the walls go into a file."""
        lines = [" ".join([kind, *(f"{x * c * (1 + off):.17g}" for x in lengths), more]) for kind, lengths, more in self.walls]
        file = Path(PLACE.name) / "walls.txt"
        file.write_text("\n".join(lines) + "\n", encoding="utf-8")
        time = c**self.power
        unit = {LENGTH: c, TIME: time, FORCE: c**-2, PER_LENGTH: c**-3, BEND: 1 / c}
        speed = c / time
        drag, dry = self.viscous * self.factor / c**3 / speed, (1 - self.viscous) * self.factor / c**3
        text = [f"-{name} " + ",".join(f"{value * unit[of] * (1 + off):.17g}" for value in values)
                for name, (of, values) in self.options.items()]
        text += [f"-friction_layers 0:{drag + dry:.17g}", f"-friction_mu {dry / (drag + dry):.17g}"]
        if dry > 0:
            text.append(f"-friction_beta {self.beta * speed**2:.17g}")
        return " ".join(text + self.plain + ([f"-wall_file {file}"] if self.walls else []))


def steps(tendril, options):
    """Steps and iterations, or why there are none."""
    try:
        done = subprocess.run([tendril, *shlex.split(options)], capture_output=True, text=True, env=ENVIRONMENT,
                              timeout=LIMIT)
    except subprocess.TimeoutExpired:
        return "does not end"
    found = SUMMARY.search(done.stdout)
    if done.returncode or not found:
        return done.stderr.strip()[-150:]
    return int(found[1]), int(found[2])


def alike(one, other):
    """Are two runs the same?"""
    if isinstance(one, str) or isinstance(other, str):
        return isinstance(one, str) and isinstance(other, str)
    return all(abs(a - b) <= max(FEWEST, PART * a) for a, b in zip(one, other))


def within(ran, many):
    """Is each run within 1 % of what lies between the least and the most of many?"""
    if any(isinstance(one, str) for one in [*ran, *many]):
        return False
    for counts, of in zip(zip(*ran), zip(*many)):
        least, most = min(of), max(of)
        room = (most - least) + max(FEWEST, PART * most)
        if not all(least - room <= count <= most + room for count in counts):
            return False
    return True


def judge(tendril, scene, ran):
    """How the runs of a scene and its scaled ones compare; and whether they are the same but for round-off."""
    if all(alike(ran[0], other) for other in ran[1:]):
        return "", True
    moved = [steps(tendril, scene.scaled(1, k * ROUND_OFF)) for k in range(1, TIMES)]
    if within(ran[1:], [ran[0], *moved]):
        return f"as by round-off {moved}", True
    return f"DIFFER, by round-off {moved}", False


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--walls", action="store_true")
    parser.add_argument("--scenes", type=int, default=50)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--scale", default="1e-3,1e3")
    parser.add_argument("--tendril", default=str(ROOT / "build" / "tendril"))
    given = parser.parse_args()
    scales, differ = [float(c) for c in given.scale.split(",")], 0
    for k in range(given.scenes):
        scene = Scene(random.Random(1000 * given.seed + k), given.walls)
        ran = [steps(given.tendril, scene.scaled(c)) for c in (1, *scales)]
        told, same = judge(given.tendril, scene, ran)
        differ += not same
        print(f"{k:3} {ran} {told}" + ("" if same else f"\n    {scene.scaled(1)}  {scene.walls}"), flush=True)
    print(f"{given.scenes} scenes, {differ} take other steps when they are scaled")
    return 1 if differ else 0


if __name__ == "__main__":
    sys.exit(main())

#!/usr/bin/env python3
"""What stiffer contact than the usual one costs, and gains: random scenes that touch, run with both.

    scripts/lab/stiffer.py build/tendril walls|head-on SEED COUNT TIMES [SECONDS]

walls: the scenes in space of fuzz_walls.py. head-on: straight rods of the plane that run into a plane, a circle's
inside or a post, next to straight on. The stiffness of the second run is TIMES that which the first one ends with.
Of each scene that touches, and of which the first run tells it: how deep it is pressed in, steps, iterations, energy defect; in the sums are those
that come through both ways, within SECONDS (25)."""

import random
import re
import subprocess
import sys
import tempfile

import numpy as np
from fuzz_walls import ENVIRONMENT, scene


def head_on(R):
    """Options, and the line of a wall."""
    D, away, aside, rub = R.choice([0.02, 0.05, 0.06, 0.1]), R.uniform(1, 2.5), R.choice([0, 0, 0.05, 0.2]), R.choice([0, 0.3])
    wall = R.choice([f"plane {away:.3f} 0 -1 {aside}", f"circle {away - 1:.3f} {aside} {R.uniform(1.5, 2.5):.3f} inside",
                     f"circle {away + 0.6:.3f} {aside / 10} 0.5 outside"])
    growth = R.choice(["feed", "feed", "apical", "uniform"])
    end = np.log(away * 1.5 / 0.6) if growth == "uniform" else 1.3 * away
    return {"growth_type": growth, "growth_initial_length": 0.6, "shape_type": "straight", "contact_diameter": D,
            "rod_curvature_random": f"{10 ** R.uniform(-5, -1):.3g}", "rod_curvature_seed": R.randrange(1000),
            "ts_max_time": f"{end:.3f}", "rod_cells": R.choice([60, 100]),
            "friction_beta": R.choice([0, 1e-4, 1e-3])}, [f"{wall} friction {rub}"]


def run(command, limit):
    """Depth in % of the diameter, steps, iterations, defect, stiffness; and what else there is to tell."""
    try:
        done = subprocess.run(command, capture_output=True, text=True, timeout=limit, env=ENVIRONMENT, check=False)
    except subprocess.TimeoutExpired:
        return None, "does not end"
    seen = re.search(r"(\d+) steps, \d+ rejected, (\d+) Newton.*defect ([\d.e+-]+),", done.stdout)
    depth = re.search(r"\(([\d.e+-]+) % of the diameter\)", done.stdout)
    if not seen or not depth:
        return None, "gives up" if done.returncode else "refused"
    word = re.search("jammed|crawls", done.stdout + done.stderr)
    k = re.search(r"contact of stiffness ([\d.e+-]+):", done.stdout)[1]
    return np.array([float(v) for v in (depth[1], *seen.groups(), k)]), \
        word[0] if word else "gives up" if done.returncode else ""


def main():
    exe, kind, times = sys.argv[1], sys.argv[2], float(sys.argv[5])
    R, count, limit = random.Random(int(sys.argv[3])), int(sys.argv[4]), float(sys.argv[6]) if len(sys.argv) > 6 else 25
    both, words = [], [[], []]
    for k in range(count):
        o, lines = head_on(R) if kind == "head-on" else scene(R)[::2]
        if not lines:
            continue
        with tempfile.NamedTemporaryFile("w", suffix=".txt") as file:
            file.write("\n".join(lines) + "\n")
            file.flush()
            command = [exe, *sum([["-" + k, str(v)] for k, v in o.items()], []), "-wall_file", file.name]
            pair = [run(command, limit)]
            if pair[0][0] is None or pair[0][0][0] == 0:  # stiffness is told of what was run to an end
                continue
            pair.append(run([*command, "-contact_stiffness", f"{times * pair[0][0][4]:.6g}"], limit))
        print(k, *(f"{p[0][0]:.2g} % {p[0][1]:.0f} steps {p[0][2]:.0f} iterations {p[0][3]:.1e} {p[1]}" if p[0] is not None
                   else p[1] for p in pair), sep=" | ", flush=True)
        for word, p in zip(words, pair):
            word.append(p[1])
        if not pair[0][1] and not pair[1][1]:
            both.append([p[0] for p in pair])
    a, b = np.array(both).transpose(1, 0, 2)
    print(f"{len(words[0])} that touch; usual: {sum(map(bool, words[0]))} do not come through, stiffer: "
          f"{sum(map(bool, words[1]))}; of {len(a)} that do both ways: {sum(a[:, 0] > 1)}, {sum(b[:, 0] > 1)} pressed in by more "
          f"than 1 %, at most {a[:, 0].max()}, {b[:, 0].max()} %; steps {b[:, 1].sum() / a[:, 1].sum() - 1:+.0%}, iterations "
          f"{b[:, 2].sum() / a[:, 2].sum() - 1:+.0%}; defects {np.exp(np.log(b[:, 3] / a[:, 3]).mean()):.2f} times")


if __name__ == "__main__":
    main()

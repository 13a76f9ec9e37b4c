#!/usr/bin/env python3
"""The ropes of tests/run/ropes_test.py, finer and with more of them: the rows of the table in docs/ropes.md.

    ropes.py build/tendril [pillar|helix|upheaval ...]"""

import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent.parent
sys.path.insert(0, str(ROOT / "tests" / "run"))
import ropes_test as ropes
import scene_test as scene

import numpy as np
from scipy.optimize import brentq


def pillar():
    for turns, pull, tilt, cells in ((1.5, 60, 0, 300), (1.5, 60, 0.7, 300), (1.5, 60, 2, 300), (2.5, 300, 0.7, 300)):
        r, off = ropes.capstan(turns, pull, tilt, 1e7, cells)
        print(f"| pillar, {turns} turns, turned by {tilt} | {off:.1e} | {r.steps} |", flush=True)


def helix():
    for torque, D in ((0, 0.1), (0.3, 0.02)):
        r = ropes.duct(28.5, torque, 0.15, 3e5, 320, D=D)
        line, turns = ropes.Line(r), 4 * np.pi / np.hypot(ropes.KAPPA, ropes.TAU)
        at = brentq(lambda s: line.P(s) - 10, 3, 6)
        P, want = ropes.helix_push(line, at, at + turns)
        print(f"| helix, two turns, M = {line.M(at):.3g}: P 10 -> {P:.9f}, exact {want:.9f} | {P / want - 1:.1e} "
              f"| {r.steps} |", flush=True)


def upheaval():
    for weight in (0.5, 1, 2):
        r, push, height = ropes.upheaval(weight, 1e10, 1000)
        print(f"| upheaval, w = {weight} | {push:.1e}, {height:.1e} | {r.steps} |", flush=True)


def main():
    scene.TENDRIL = str(Path(sys.argv[1]).resolve())
    with tempfile.TemporaryDirectory() as scene.SCRATCH:
        for name in sys.argv[2:] or ("pillar", "helix", "upheaval"):
            globals()[name]()


if __name__ == "__main__":
    main()

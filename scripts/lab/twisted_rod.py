#!/usr/bin/env python3
"""The rod that is clamped at both ends and twisted by 27 turns (options/twisted-rod.opts): errors against the exact rod
and seconds, as a table for docs/notes/exact-answers.md.

    scripts/lab/twisted_rod.py build/tendril [CELLS...]"""

import re
import subprocess
import sys
import tempfile
from pathlib import Path

import h5py
import numpy as np

ROOT = Path(__file__).resolve().parents[2]
ANGLE, TORQUE, FORCE = 47.65156384, 98.541496156, 2900.9932439  # by shooting, to ten digits


def run(tendril, cells, rtol):
    with tempfile.TemporaryDirectory() as scratch:
        file = f"{scratch}/rod.h5"
        said = subprocess.run([tendril, "-options_file", "options/twisted-rod.opts", "-rod_cells", str(cells),
                               "-ts_rtol", str(rtol), "-output_interval", "10", "-output", file], cwd=ROOT,
                              check=True, capture_output=True, text=True).stdout
        with h5py.File(file) as f:
            d, s = f["shapes/d1"][-1], f["shapes/s"][:]
            moment = abs(f["series/base_moment_1"][-1])
            force = np.linalg.norm([f[f"series/base_force_{k}"][-1] for k in (1, 2, 3)])
    angle = np.degrees(np.arctan2(np.hypot(d[:, 1], d[:, 2]), d[:, 0]))
    i = slice(angle.argmax() - 3, angle.argmax() + 4)  # between nodes: the polynomial through seven
    top = np.polynomial.Polynomial.fit(s[i], angle[i], 6)
    most = max(top(x.real) for x in top.deriv().roots() if abs(x - s[i.start + 3]) < 2 / cells)
    steps, seconds = re.search(r"(\d+) steps.* ([0-9.]+) s;", said).groups()
    errors = " | ".join(f"{abs(a / b - 1):.1e}" for a, b in ((most, ANGLE), (moment, TORQUE), (force, FORCE)))
    print(f"| {cells} | {errors} | {rtol:g} | {steps} | {seconds} |", flush=True)


if __name__ == "__main__":
    for cells in map(int, sys.argv[2:] or (100, 200, 400, 800)):
        run(sys.argv[1], cells, 1e-4)

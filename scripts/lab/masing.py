#!/usr/bin/env python3
"""A rod at rest in friction that is turned at its tip by 0.5 and back to 0.1 (Masing), and one that is fed and turned: how far the
torque, and the push, are off the exact ones, with more and more cells. Writes docs/notes/masing.csv and docs/notes/masing.png.

    scripts/lab/masing.py build/tendril [--draw]      (--draw: from docs/notes/masing.csv)"""

import csv
import re
import shlex
import subprocess
import sys
import tempfile
from pathlib import Path

import h5py
import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "scripts"))
from tendril.style import BLUE, GREEN, RED, STYLE

TABLE, PICTURE = ROOT / "docs/notes/masing.csv", ROOT / "docs/notes/masing.png"
RADIUS, TORSION = 0.5, 0.75
TURNED = (f"-growth_type none -growth_initial_length 3 -shape_type straight -friction_radius {RADIUS} -tip_type slides "
          "-ts_max_time 2 -output_shapes 1 ")
FED = "-growth_type feed -growth_initial_length 1 -shape_type straight -ts_max_time 1 -output_shapes 1 "
EULER = "-friction_beta 1e-20 -ts_bdf_order 1 -ts_adapt_type none -ts_dt 0.1 -ts_rtol 1e-10 -snes_max_it 2000"
ROWS = ([("turned by Euler's steps", EULER, n) for n in (50, 100, 200, 400, 800, 1600, 3200)]
        + [("turned", "-friction_beta 0", n) for n in (25, 50, 100, 200)]
        + [("fed and turned", "-ts_rtol 1e-9", n) for n in (4, 8, 16)])


def run(tendril, options, scratch):
    """The last moments at the tip, push and torque at the clamp; iterations; seconds."""
    said = subprocess.run([tendril, *shlex.split(options), "-output", f"{scratch}/run.h5"], check=True, capture_output=True,
                          text=True).stdout
    with h5py.File(f"{scratch}/run.h5") as f:
        found = (f["shapes/moment"][-1, -1, 0], *(f[f"series/base_{k}_1"][-1] for k in ("force", "moment")))
    return found, *re.search(r"(\d+) Newton iterations, ([0-9.]+) s", said).groups()


def back():
    return np.sqrt(2 * RADIUS * TORSION * 0.5) - 2 * np.sqrt(RADIUS * TORSION * 0.4)


def fed(radius=0.3, turns=4, length=2, stiff=100, beta=1e-3):
    """Push and torque: the spin is the same along the rod, and lags by what a couple that grows winds it up."""
    spin = turns
    for _ in range(50):
        speed = np.sqrt(1 + (radius * spin)**2 + beta)
        spin = turns - length * radius**2 * spin / speed / stiff
    return length / speed, length * radius**2 * spin / speed


def measure(tendril):
    with tempfile.TemporaryDirectory() as scratch, open(TABLE, "w", newline="") as file:
        table = csv.writer(file, lineterminator="\n")
        table.writerow(("what", "options", "cells", "error", "iterations", "seconds"))
        Path(f"{scratch}/back.csv").write_text("t, turn\n0, 0\n1, 0.5\n2, 0.1\n")
        for what, options, cells in ROWS:
            scene = (FED + "-friction_radius 0.3 -clamp_spin 4 -rod_torsion 100 " if what.startswith("fed")
                     else TURNED + f"-tip_path {scratch}/back.csv ")
            (tip, push, torque), iterations, seconds = run(tendril, f"{scene} {options} -rod_cells {cells}", scratch)
            error = (max(abs(push / fed()[0] - 1), abs(torque / fed()[1] - 1)) if what.startswith("fed")
                     else abs(tip / back() - 1))
            table.writerow((what, options, cells, f"{error:.2g}", iterations, seconds))
            print(f"| {what} | {cells} | {error:.1e} | {iterations} | {seconds} |", flush=True)


def draw():
    with open(TABLE) as file, plt.rc_context(STYLE):
        rows = list(csv.DictReader(file))
        figure, axes = plt.subplots(figsize=(3.4, 2.6), layout="constrained")
        for (what, marker), colour in zip({"turned by Euler's steps": "o", "turned": "s", "fed and turned": "^"}.items(),
                                          (BLUE, RED, GREEN)):
            mine = [(int(r["cells"]), float(r["error"])) for r in rows if r["what"] == what]
            axes.loglog(*zip(*mine), marker=marker, markersize=3, color=colour, label=what)
        cells = np.array([50, 1600])
        axes.loglog(cells, 2 * cells[0]**2 * 1e-3 / cells**2.0, ":", color="black", linewidth=0.7, label="order 2")
        axes.set(xlabel="cells", ylabel="error of the torque")
        axes.legend()
        figure.savefig(PICTURE)


if __name__ == "__main__":
    if "--draw" not in sys.argv:
        measure(sys.argv[1])
    draw()

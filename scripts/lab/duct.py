#!/usr/bin/env python3
"""A cable in a duct of three bends out of one plane (options/duct-bends.opts), over the friction of its wall: table and
figure for options/README.md.

    PYTHONPATH=scripts .venv/bin/python scripts/lab/duct.py build/tendril DIRECTORY [path] [run] [table]

path makes options/data/duct-bends.csv anew."""

import subprocess
import sys
from pathlib import Path

import h5py
import matplotlib
import numpy as np

matplotlib.use("Agg")
import matplotlib.pyplot as plt

from steps import steps_of
from tendril.style import BLUE, STYLE

ROOT = Path(__file__).resolve().parents[2]
PATH = ROOT / "options" / "data" / "duct-bends.csv"
RADIUS = 0.15
RUNS = {"0.3": (0.3, 150), "0.4": (0.4, 150), "0.5": (0.5, 150), "0.5, 300 cells": (0.5, 300), "0.7": (0.7, 150)}
LENGTHS = 4, 6, 8, 12, 16, 20


def make_path():
    """Straight pieces of 2, 1, 1 and 15, and between them quarters of a circle of radius 1, a point every 15 degrees."""
    x, d, points = np.zeros(3), np.array([1.0, 0, 0]), [[-0.5, 0, 0], [0, 0, 0]]

    def line(length, pieces):
        nonlocal x
        for _ in range(pieces):
            x = x + d * length / pieces
            points.append(x)

    def bend(to):
        nonlocal x, d
        for a in np.radians(np.arange(15, 91, 15)):
            points.append(x + to * (1 - np.cos(a)) + d * np.sin(a))
        x, d = x + to + d, to

    line(2, 4)
    for to in np.eye(3)[[1, 2, 0]]:
        bend(to)
        line(*((15, 15) if to[0] else (1, 2)))
    lines = [",".join(f"{v:.10g}" for v in (*p, RADIUS)) for p in np.round(points, 12) + 0.0]
    PATH.write_text("x,y,z,r\n" + "\n".join(lines) + "\n")


def run(tendril, d):
    for name, (mu, cells) in RUNS.items():
        wall = d / f"duct-{mu}.txt"
        wall.write_text(f"tube {PATH} inside friction {mu}\n")
        subprocess.run([tendril, "-options_file", ROOT / "options" / "duct-bends.opts", "-wall_file", wall, "-rod_cells",
                        str(cells), "-quiet", "-output", d / f"{name}.h5"], check=True, cwd=ROOT)


def table(d):
    print("| friction |", " | ".join(str(n) for n in LENGTHS), "| locked up at length | energy defect |")
    for name in RUNS:
        length, push, _, defect = read(d, name)
        at = (f"{np.interp(n, length, push):.2f}" if n <= length[-1] else "" for n in LENGTHS)
        print(f"| {name} |", " | ".join(at), f"| {f'{length[-1]:.2f}' if push[-1] > 55 else ''} | {defect:.1e} |")


def read(d, name):
    """(length, push, last shape, energy defect) of a run."""
    with h5py.File(d / f"{name}.h5") as f:
        return (f["series/length"][:], f["series/base_force_1"][:], f["shapes/x"][-1], f["series/energy_defect"][-1])


def picture(d, file=ROOT / "options" / "pictures" / "duct-bends.png"):
    """From the side, from above, and the push over the length."""
    figure, axes = plt.subplot_mosaic([["side", "push"], ["above", "push"]], figsize=(7.2, 3), layout="constrained")
    path, (length, _, x, _) = np.loadtxt(PATH, delimiter=",", skiprows=1), read(d, "0.5")
    for ax, k in (("side", 2), ("above", 1)):
        axes[ax].plot(path[:, 0], path[:, k], color="0.9", lw=7, solid_capstyle="butt", zorder=0)
        axes[ax].plot(x[:, 0], x[:, k], color=BLUE)
        axes[ax].plot(0, 0, "ks", ms=3, zorder=3)
        axes[ax].set(aspect="equal", ylabel=f"$x_{k + 1}$", xlim=(-0.6, 12), ylim=(-0.6, 3.6))
    axes["side"].set_title(f"friction 0.5, length {length[-1]:.1f}")
    axes["above"].set(xlabel="$x_1$")
    one = [name for name in RUNS if "cells" not in name]
    for name, shade in zip(one, plt.get_cmap("viridis")(np.linspace(0, 0.88, len(one)))):
        length, push, *_ = read(d, name)
        axes["push"].semilogy(length[length > 1], push[length > 1], color=shade, label=f"friction {name}")
    axes["push"].set(xlabel="length of cable in the duct", ylabel="push", xlim=(0, 21), ylim=(0.1, 70))
    axes["push"].legend(loc="lower right")
    for name, letter in zip(("side", "above", "push"), "abc"):
        axes[name].set_title(f"({letter})", loc="left")
    figure.savefig(file, dpi=200)


def main():
    choice = steps_of(__doc__, ["path", "run", "table"], ["run", "table"])
    if "path" in choice.what:
        make_path()
    if "run" in choice.what:
        run(str(Path(choice.tendril).resolve()), choice.directory)
    if "table" in choice.what:
        table(choice.directory)
        with plt.rc_context(STYLE):
            picture(choice.directory)


if __name__ == "__main__":
    sys.exit(main())

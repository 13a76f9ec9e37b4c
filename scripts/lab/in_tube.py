#!/usr/bin/env python3
"""Rods in round tubes against exact answers (tests/scenes/space/in_tube_test.py), as tables for docs/notes/tubes-measured.md.

    PYTHONPATH=scripts .venv/bin/python scripts/lab/in_tube.py build/tendril [helix] [sinus] [spun]
        [beyond] [energies]"""

import argparse
import sys
import tempfile
from pathlib import Path

import matplotlib
import numpy as np

matplotlib.use("Agg")
import matplotlib.pyplot as plt

from tendril.scene_data import carried, rise
from tendril.style import BLUE, GREY, ORANGE, STYLE

ROOT = Path(__file__).resolve().parents[2]
sys.path[:0] = [str(ROOT / "tests/scenes/space"), str(ROOT / "tests/support")]
import in_tube_test as tube
import scene
from scipy.interpolate import CubicSpline


def row(*cells):
    print("| " + " | ".join(str(c) for c in cells) + " |", flush=True)


def helix():
    """Over cells and k; and with k extrapolated. A wall that is pressed by N per length gives way by
    w (1 - 2 (N/kw)^(1/2)), w ~ k^(-3/4) (world/contact.h): so errors go as l^3 and l^(7/2), l = k^(-1/4)."""
    names = "k", "P of its k", "N of its k", "N", "N at a node", "radius"
    row("cells", "contact's k", *names, "steps")
    for cells in (240, 480):
        layers, errors = [], []
        for k in (None, 2e3, 1.6e4, 1.28e5):
            run, off = tube.helix(cells, "-ts_rtol 1e-7 " + (f"-contact_stiffness {k}" if k else ""))
            row(cells, f"{k:g}" if k else "default", *(f"{off[n]:.1e}" for n in names), run.steps)
            if k:
                layers.append(k**-0.25)
                errors.append([off[n] for n in names])
        powers = np.array(layers)[:, None] ** [0, 3, 3.5]
        row(cells, "extrapolated", *(f"{e:.1e}" for e in np.linalg.solve(powers, errors)[0]), "")


def sinus():
    """Where a sinus begins, and how fast it grows, over the length."""
    row("waves", "exact", "cells", "P of the run", "P off by", "shape off by", "wave length off by", "steps")
    for waves, cells in ((4, 160), (8, 320), (16, 640)):
        exact = tube.threshold(2 * np.pi * waves)
        P, end = 1.01 * exact, 250 if waves > 8 else 150
        run, force, shape, wave = tube.sinus(waves, P, end, cells=cells)
        row(waves, f"{exact:.7f}", cells, f"{P:.5f}", f"{force:.1e}", f"{shape:.1e}", f"{wave:.1e}", run.steps)


def spun():
    """Fed and spun, held as high as it climbs."""
    lengths = 6, 10, 20, 30, 38
    row("length", "push off by", "torque", "spin", "sum of pressures", "steps")
    run, off = tube.spun(lengths)
    for length, errors in zip(lengths, off):
        row(length, *(f"{e:.1e}" for e in errors), np.argmax(run.length >= length))


def beyond(figure=ROOT / "docs" / "figures" / "tube-beyond.png"):
    """A rod of six waves in a smooth tube, pushed in steps up and down again, each from the shape before."""
    waves, r, cells = 6, 0.05, 500
    way = [2.0, 2.2, 2.6, 3.0, 3.4, 3.5, 3.6, 3.7, 3.8, 3.9, 4.0, 5.0, 4.0, 3.4, 3.0, 2.8, 2.7, 2.6, 2.5, 2.4, 2.2]
    length, state = 2 * np.pi * waves, None
    shape = lambda s: 1e-5 * np.sin(np.pi * s)**2 * np.sin(length * (s - 0.4))
    led = Path(scene.SCRATCH) / "led.csv"  # what strains in the nodes do not tell is not to add up
    led.write_text("t,x2,x3,angle\n0,0,0,0\n1e5,0,0,0\n")
    row("P", "turned by at most, degrees", "least pressure, in w", "steps")
    seen = []
    for P in way:
        run = tube.lying(P, state or shape, length, r=r, k=2e6, cells=cells,
                         more=f"-tip_path {led} -ts_max_time 3000 -ts_rtol 1e-5 ")
        x, push = run.shapes["x"][-1], run.shapes["contact"][-1]
        middle = slice(cells // 5, 4 * cells // 5)
        turn = np.degrees(np.unwrap(np.arctan2(x[:, 1], r - x[:, 2])))
        least = np.hypot(*push[middle, 1:].T).min() / r
        row(P, f"{np.abs(turn).max():.1f}", f"{least:.3f}", run.steps)
        seen.append((P, turn, least, x))
        state = run.shapes["s"], run.shapes["strain"][-1]
    with plt.rc_context(STYLE):
        draw_beyond(way, seen, np.linspace(0, length, cells + 1), figure)


def draw_beyond(way, seen, s, file):
    """How far the rod has turned about the tube, over the push, and along the rod at some of them."""
    top = way.index(max(way))
    figure, axes = plt.subplots(1, 2, figsize=(7.2, 2.8), layout="constrained")
    for part, look, name, colour in ((slice(0, top + 1), "o-", "pushed harder", BLUE), (slice(top, None), "s--", "let go", ORANGE)):
        axes[0].plot([p for p, *_ in seen[part]], [np.abs(t).max() for _, t, *_ in seen[part]], look, ms=3, color=colour,
                     label=name)
    for P in (2, 2.745, 3.546):
        axes[0].axvline(P, color=GREY, lw=0.5, zorder=0)
        axes[0].text(P, 250, f"{P} ", fontsize=7, color=GREY, ha="right", rotation=90)
    axes[0].set(xlabel=r"push over $(Bw/r)^{1/2}$", ylabel="turned about the tube, at most (degrees)")
    axes[0].legend(loc="center right")
    chosen = 1, way.index(3.4), top, way.index(2.6, top)
    for i, shade in zip(chosen, plt.get_cmap("viridis")(np.linspace(0, 0.88, len(chosen)))):
        axes[1].plot(s, seen[i][1], "--" if i > top else "-", color=shade,
                     label=f"{way[i]:g}, {'let go' if i > top else 'pushed harder'}")
    axes[1].set(xlabel=r"arc length over $(Br/w)^{1/4}$", ylabel="turned about the tube (degrees)", ylim=(-100, 640))
    axes[1].legend(ncols=2, loc="upper center", title="push")
    for ax, letter in zip(axes, "ab"):
        ax.set_title(f"({letter})", loc="left")
    figure.savefig(file, dpi=200)


CLEARANCE = 0.02


def wound(turned, length):
    """Strains of a rod that lies on the tube's wall, turned about its axis by an angle over the arc length: (s, strain)."""
    s = np.linspace(0, length, 4001)
    angle = turned(s)
    rate = CLEARANCE * np.gradient(angle, s, edge_order=2)
    q = np.stack([np.sqrt(1 - rate**2), np.cos(angle) * rate, np.sin(angle) * rate], axis=1)
    d2, slope = carried(q), np.gradient(q, s, axis=0, edge_order=2)
    return s / length, np.stack([0 * s, -(slope * np.cross(q, d2)).sum(1), (slope * d2).sum(1)], axis=1)


def period(run, length, P, half):
    """Of a wave (half = 0) or a helix (half = pi: half a turn to either side), in the rod's middle: wave number, energy over
    w r per length (that of the straight rod is 0), the least pressure over w."""
    x, m, q = (run.shapes[name][-1] for name in ("x", "moment", "d1"))
    s = length * run.shapes["s"]
    angle = CubicSpline(s, np.unwrap(np.arctan2(x[:, 1], CLEARANCE - x[:, 2])))
    energy = CubicSpline(s, ((m * m).sum(1) / 2 + CLEARANCE * x[:, 2] - P * (1 - q[:, 0])) / CLEARANCE**2).antiderivative()
    if half:
        middle = round(angle(length / 2) / np.pi)
        ends = [min(angle.solve(np.pi * (middle + k)), key=lambda z: abs(z - length / 2)) for k in (-1, 1)]
    else:
        up = [z for z in angle.roots(extrapolate=False) if angle(z, 1) > 0]
        ends = up[len(up) // 2 - 1:len(up) // 2 + 1]
    a, b = sorted(ends)
    push = np.linalg.norm(run.shapes["contact"][-1], axis=1) / CLEARANCE
    return 2 * np.pi / (b - a), (energy(b) - energy(a)) / (b - a), push[(s > a) & (s < b)].min()


def energies():
    """Wave and helix, each at rest, pushed harder or less from the shape before: which one has less energy."""
    row("", "cells", "length", "P", "wave number", "energy over w r", "least pressure, in w", "steps")
    helix = lambda length: lambda s: 12 * np.pi * np.clip(CubicSpline(
        z := np.linspace(0, length, 999), rise(z / 4) * rise((length - z) / 4)).antiderivative()(s) / (length - 4), 0, 1)
    wave = lambda length: lambda s: 1.4 * np.sin(0.972 * (s - length / 2)) * rise(s / 4) * rise((length - s) / 4)
    runs = (250, 400, 400, 400)
    for name, shape, lengths, way, half in (("wave", wave, (33, 33, 34.5, 36), (2.85, 2.9, 2.95), 0),
                                            ("helix", helix, (34, 34, 35, 36), (2.95, 2.9, 2.85, 2.8, 2.78), np.pi)):
        for cells, length in zip(runs, lengths):
            state = wound(shape(length), length)
            for P in way:
                run = tube.lying(P, state, length, r=CLEARANCE, k=2e6, cells=cells, more="-ts_max_time 400 -ts_rtol 1e-5 ")
                k, energy, least = period(run, length, P, half)
                row(name, cells, length, P, f"{k:.4f}", f"{energy:.6f}", f"{least:.4f}", run.steps)
                state = run.shapes["s"], run.shapes["strain"][-1]


def main():
    tables = {"helix": helix, "sinus": sinus, "spun": spun, "beyond": beyond, "energies": energies}
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("tendril")
    parser.add_argument("table", nargs="*", choices=[[], *tables], default=[])
    choice = parser.parse_args()
    choice.table = choice.table or list(tables)
    scene.TENDRIL = str(Path(choice.tendril).resolve())
    with tempfile.TemporaryDirectory() as scene.SCRATCH:
        for name in choice.table:
            tables[name]()


if __name__ == "__main__":
    sys.exit(main())

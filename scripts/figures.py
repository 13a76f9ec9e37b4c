#!/usr/bin/env python3
"""The figures of docs/figures.md that set runs side by side: the pushed tube, and a map of what
imperfections lead to.

    figures.py results/figures docs/figures"""

import sys
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

from plot import BLUE, GREEN, ORANGE, RED, STYLE
from tendril_results import load

LENGTH = 9.93  # of the paper's tube when it was photographed
TUBES = {"tube-feed": ("feed, curved by nature", BLUE, "-"),
         "tube-feed-perfect": ("feed, initial sag only", BLUE, "--"),
         "tube-gaussian": (r"$a = 0.05$, curved by nature", ORANGE, "-"),
         "tube-gaussian-perfect": (r"$a = 0.05$, initial sag only", ORANGE, "--")}


def at_length(r, name, length):
    return float(np.interp(length, r.series.length, r.series[name]))


def crossing(r):
    first = np.flatnonzero(r.series.self_crossings > 0)
    return float(r.series.length[first[0]]) if len(first) else np.nan


def tube(directory, pictures):
    figure, axes = plt.subplots(1, 3, figsize=(7.2, 2.9), layout="constrained")
    for name, (label, colour, style) in TUBES.items():
        r = load(directory / f"{name}.h5")
        k = int(np.argmin(np.abs(0.5 + r.shapes.t - LENGTH)))
        axes[0].plot(*r.shapes.x[k].T, style, color=colour, label=label)
        for ax, series in zip(axes[1:], ("end_distance", "width")):
            ax.plot(r.series.length, r.series[series], style, color=colour)
        scale = float(r.attributes["si_length"])
        values = [LENGTH, at_length(r, "end_distance", LENGTH), at_length(r, "width", LENGTH),
                  crossing(r)]
        print(f"{name}: " + ", ".join(f"{w} {v:.3f} ({100 * v * scale:.2f} cm)" for w, v in
                                      zip(("length", "end distance", "width", "first crossing at"),
                                          values)))
    axes[0].set(xlabel="$x_1$", ylabel="$x_2$")
    axes[0].set_aspect("equal", adjustable="datalim")
    axes[0].plot(0, 0, "ks", ms=3, zorder=4)
    for ax, text in zip(axes[1:], ("distance of the ends $|x(1)|$", "width")):
        ax.axvline(LENGTH, color="#999999", lw=0.6)
        ax.set(xlabel="length $L$", ylabel=text)
    for ax, letter in zip(axes, "abc"):
        ax.set_title(f"({letter})", loc="left")
    figure.legend(loc="outside upper center", ncol=2)
    figure.savefig(pictures / "tube.png")


def imperfections(directory, pictures):
    """Width at t = 10, first crossing, and how the ends move apart, over amplitude."""
    kinds = {"sag": ("initial sag", RED, "s"), "constant": ("natural curvature, constant", BLUE, "o"),
             "random": ("natural curvature, random", GREEN, "^")}
    figure, axes = plt.subplots(1, 3, figsize=(7.2, 2.7), layout="constrained")
    for kind, (label, colour, mark) in kinds.items():
        rows = []
        for file in directory.glob(f"map-{kind}-*.h5"):
            r = load(file)
            rows.append((float(file.stem.split("-")[-1]),
                         *(np.interp(10, r.series.t, r.series[n]) for n in ("width", "max_angle")),
                         crossing(r) - 0.5,
                         *(np.interp(t, r.series.t, r.series.end_distance) for t in (20, 30, 40))))
        rows = np.array(sorted(rows))
        for row in rows:
            print(f"{kind} {row[0]:g}: at t = 10 width {row[1]:.2e}, largest angle {row[2]:.2e}; first "
                  f"crossing t = {row[3]:.1f}; ends apart at t = 20, 30, 40: {row[4]:.2f}, "
                  f"{row[5]:.2f}, {row[6]:.2f}")
        axes[0].plot(rows[:, 0], rows[:, 1], mark + "-", color=colour, label=label, ms=4)
        axes[1].plot(rows[:, 0], rows[:, 3], mark + "-", color=colour, ms=4)
        axes[2].plot(rows[:, 0], rows[:, 6] - rows[:, 5], mark + "-", color=colour, ms=4)
    axes[0].set_yscale("log")
    axes[0].set_ylabel("width at $t = 10$")
    axes[1].set_ylabel("time of the first crossing")
    axes[2].set_ylabel("$|x(1)|$ at $t = 40$ less that at $30$")
    axes[2].axhline(0, color="#999999", lw=0.6)
    for ax, letter in zip(axes, "abc"):
        ax.set(xscale="log", xlabel="amplitude")
        ax.set_title(f"({letter})", loc="left")
    figure.legend(loc="outside upper center", ncol=3)
    figure.savefig(pictures / "imperfections.png")


if __name__ == "__main__":
    with plt.rc_context(STYLE):
        tube(Path(sys.argv[1]), Path(sys.argv[2]))
        imperfections(Path(sys.argv[1]), Path(sys.argv[2]))

#!/usr/bin/env python3
"""The figures of docs/notes/paper-figures.md that set runs side by side: the pushed tube, and a map of what
imperfections lead to.

    figures.py results/figures docs/figures"""

import sys
from pathlib import Path

import h5py
import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

from tendril import load
from tendril.style import BLUE, GREEN, ORANGE, RED, STYLE

LENGTH = 9.93  # of the paper's tube when it was photographed
TUBES = {"tube-feed": ("feed, curved by nature", BLUE, "-"),
         "tube-feed-perfect": ("feed, initial sag only", BLUE, "--"),
         "tube-gaussian": (r"$a = 0.05$, curved by nature", ORANGE, "-"),
         "tube-gaussian-perfect": (r"$a = 0.05$, initial sag only", ORANGE, "--")}


def at_length(r, name, length):
    return float(np.interp(length, r.series.length, r.series[name]))


def crossing(r):
    """The length at which the rod first crosses itself, from the run that stops there; nan if it
    never does."""
    file = r.path.with_name(f"crossing-{r.path.name}")
    if not file.exists():
        if (r.series.self_crossings > 0).any():
            raise SystemExit(f"figures: {file} is missing, run scripts/lab/figures.sh")
        return np.nan
    stopped = load(file)
    with h5py.File(file) as f:
        return float(stopped.series.length[-1]) if "event" in f and \
            f["event"].attrs["kind"] == b"self_contact" else np.nan


def crossings(shape):
    """Where the polygon of a shape crosses itself: [(s of the first pass, s of the second)]."""
    a, step = shape.x[:-1], np.diff(shape.x, axis=0)
    apart = a[None] - a[:, None]
    cross = step[:, None, 0] * step[None, :, 1] - step[:, None, 1] * step[None, :, 0]
    with np.errstate(divide="ignore", invalid="ignore"):
        u = (apart[..., 0] * step[None, :, 1] - apart[..., 1] * step[None, :, 0]) / cross
        w = (apart[..., 0] * step[:, None, 1] - apart[..., 1] * step[:, None, 0]) / cross
    i, j = np.nonzero(np.triu((u >= 0) & (u < 1) & (w >= 0) & (w < 1), 2))
    return list(zip(shape.s[i], shape.s[j]))


def eight(r):
    """The first stored time at which the rod draws a figure 8: two strands cross twice, and so close
    a loop and a second one beside it; nan if they never do."""
    for t in r.shapes.t:
        found = crossings(r.at(t))
        if any(a[0] < b[0] and b[1] < a[1] for a in found for b in found):
            return float(t)
    return np.nan


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
        print(f"{name}: " + ", ".join(
            f"{w} {v:.3f} ({100 * v * scale:.2f} cm)" if v == v else f"{w} none" for w, v in
            zip(("length", "end distance", "width", "first crossing at"), values))
            + f", figure 8 from t = {eight(r):g}".replace("nan", "none"))
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


def outcome(r):
    """What an imperfection leads to, by the run's end."""
    apart = [float(np.interp(t, r.series.t, r.series.end_distance)) for t in (20, 30, 40)]
    return {"width": float(np.interp(10, r.series.t, r.series.width)), "crossing": crossing(r) - 0.5,
            "eight": eight(r), "apart": apart, "drift": apart[2] - apart[1]}


def imperfections(directory, pictures):
    """Width at t = 10, first crossing, and how the ends move apart, over amplitude."""
    kinds = {"sag": ("initial sag", RED, "s"), "constant": ("constant curvature", BLUE, "o"),
             "random": ("random curvature", GREEN, "^")}
    panels = {"width": "width at $t = 10$", "crossing": "time of the first crossing",
              "drift": "$|x(1)|$ at $t = 40$ less that at $30$"}
    figure, axes = plt.subplots(1, 3, figsize=(7.2, 2.7), layout="constrained")
    for kind, (label, colour, mark) in kinds.items():
        rows = {float(file.stem.split("-")[-1]): outcome(load(file))
                for file in directory.glob(f"map-{kind}-*.h5")}
        rows = dict(sorted(rows.items()))
        for amplitude, row in rows.items():
            times = [f"{row[k]:.1f}" if row[k] == row[k] else "none" for k in ("crossing", "eight")]
            print(f"| {label} {amplitude:g} | {row['width']:.2g} | {times[0]} | {times[1]} | "
                  + ", ".join(f"{d:.2f}" for d in row["apart"]) + " |")
        for ax, name in zip(axes, panels):
            ax.plot(list(rows), [row[name] for row in rows.values()], mark + "-", color=colour,
                    label=label, ms=4)
    axes[0].set_yscale("log")
    axes[2].axhline(0, color="#999999", lw=0.6)
    for ax, letter, text in zip(axes, "abc", panels.values()):
        ax.set(xscale="log", xlabel="amplitude", ylabel=text)
        ax.set_title(f"({letter})", loc="left")
    handles, labels = axes[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside upper center", ncol=3)
    figure.savefig(pictures / "imperfections.png")


if __name__ == "__main__":
    with plt.rc_context(STYLE):
        tube(Path(sys.argv[1]), Path(sys.argv[2]))
        imperfections(Path(sys.argv[1]), Path(sys.argv[2]))

#!/usr/bin/env python3
"""The rod that is injected into a lying tube (options/injected-tube.opts), fed, fed and spun, and fed and then spun, to
where it locks up: tables for docs/notes/injected-tube-measured.md and its figures.

    PYTHONPATH=scripts .venv/bin/python scripts/lab/injected_tube.py build/tendril DIRECTORY [run] [tables] [figure]

Results are kept in DIRECTORY, so that tables and figure can be made anew without the runs."""

import re
import subprocess
import sys
from pathlib import Path

import h5py
import matplotlib
import numpy as np

matplotlib.use("Agg")
import matplotlib.pyplot as plt

from steps import steps_of
from tendril.style import BLUE, GREY, ORANGE, STYLE

ROOT = Path(__file__).resolve().parents[2]
R, W, MU, BETA, VISCOUS, SPIN, D, C = 0.1, 0.1, 0.5, 1e-6, 1e-4, 30.0, 0.1, 0.75
CELLS = 300, 500, 1000
TURNED = f"-clamp_spin {SPIN} -stop_length 110 -ts_max_time 110 -rod_cells 300"
THEN = f"-clamp_path {ROOT / 'options' / 'data' / 'then-spun.csv'} -ts_max_time 96 -rod_cells 300"  # as injected-spun.opts
PUSHES = 2.5, 3, 5, 10, 20, 40


def stiffer(directory, k=1e5):
    """The tube for contact that much stiffer: as wide as it must be for the rod to lie on its bottom."""
    smooth = 2 * W**(2 / 3) * k**-0.75 / np.sqrt(8)  # of a rod of 7 and more: a shorter one presses harder
    gap = smooth * (1 - 2 * np.sqrt(W / (k * smooth)))
    wall = directory / "stiffer.txt"
    wall.write_text(f"cylinder 0 0 {R} 1 0 0 {R + D / 2 + gap:.12g} inside friction {MU}\n")
    return f"-wall_file {wall} -contact_stiffness {k:g}"


def runs(directory):
    return {**{f"fed-{n}": f"-rod_cells {n}" for n in CELLS}, "stiffer": stiffer(directory),
            "finer": "-ts_rtol 1e-6", "bent": "-rod_curvature_random 1e-3", "other": "-rod_curvature_seed 2",
            "spun": TURNED, "then": THEN}


class Result:
    def __init__(self, directory, name):
        self.said = (directory / f"{name}.log").read_text()
        with h5py.File(directory / f"{name}.h5") as f:
            self.series = {k: v[:] for k, v in f["series"].items()}
            self.shapes = {k: v[:] for k, v in f["shapes"].items()}
        self.length, self.push = self.series["length"], self.series["base_force_1"]

    def at(self, push):
        """The length at which it is first pushed so hard."""
        i = np.argmax(self.push > push)
        return np.interp(push, self.push[i - 1:i + 1], self.length[i - 1:i + 1]) if i else np.nan

    def cost(self):
        return re.search(r"(\d+) steps.* ([0-9.]+) s; energy defect ([0-9.e+-]+)", self.said).groups()


def row(*cells):
    print("| " + " | ".join(str(c) for c in cells) + " |", flush=True)


def straight(r):
    """Push over its exact value, off by at most, while the push is below 2."""
    exact = (MU * W / np.sqrt(1 + BETA) + VISCOUS) * r.length
    i = (r.length > 5) & (r.push < 1.99)
    return np.abs(r.push[i] / exact[i] - 1).max()


def along(r, time):
    """Through the helix at a time: place, force along the tube, turns per length, pressure."""
    j = np.abs(r.shapes["t"] - time).argmin()
    x, force = r.shapes["x"][j], -r.shapes["force"][j, :, 0]
    turn = np.unwrap(np.arctan2(x[:, 1], R - x[:, 2]))
    length = np.interp(r.shapes["t"][j], r.series["t"], r.length)
    return x[:, 0], force, np.gradient(turn, r.shapes["s"] * length), np.linalg.norm(r.shapes["contact"][j], axis=1)


def law(r, time):
    """d(1/P)/dx over mu r/4B, in the helix but for its ends."""
    x, force, turns, _ = along(r, time)
    helix = (np.abs(turns) > 1) & (force > 3.5) & (x > 0.3)
    if helix.sum() < 4:
        return np.nan, 0
    return np.polyfit(x[helix], 1 / force[helix], 1)[0] / (MU * R / 4), x[helix].max()


def tables(directory):
    row("run", "straight: push off by", *(f"P = {P}" for P in PUSHES), "steps", "seconds", "energy defect")
    for name in runs(directory):
        if (directory / f"{name}.h5").exists() and name not in ("spun", "then"):
            r = Result(directory, name)
            row(name, f"{straight(r):.1e}", *(f"{r.at(P):.2f}" for P in PUSHES), *r.cost())
    print()
    r = Result(directory, "fed-500")
    row("length", "push", "helix to x", "d(1/P)/dx over mu r/4B")
    for t in (70, 74, 78, 81):
        slope, end = law(r, t)
        row(4 + t, f"{np.interp(t, r.series['t'], r.push):.2f}", f"{end:.1f}", f"{slope:.3f}")
    print()
    r = Result(directory, "spun")
    row("length", "push over its N", "off by", "torque over its N", "off by", "spin of the tip", "off by")
    for length in (10, 20, 30, 38):
        i = np.argmax(r.length > length)
        normal, spin = r.series["contact_force"][i], SPIN  # a first guess
        for _ in range(20):  # the torque twists what comes: it spins by so much less
            slip = np.hypot(1, D / 2 * spin)
            climb = np.arctan(MU * D / 2 * spin / slip)
            torque = MU * W * np.cos(climb) * (D / 2)**2 * spin / slip
            spin = SPIN - torque * r.length[i] / C
        push = (r.push[i] - VISCOUS * r.length[i]) / normal / (MU / slip)
        moment = r.series["base_moment_1"][i] / normal / (MU * (D / 2)**2 * spin / slip)
        row(f"{r.length[i]:.2f}", f"{MU / slip:.6f}", f"{push - 1:.1e}", f"{MU * (D / 2)**2 * spin / slip:.6f}",
            f"{moment - 1:.1e}", f"{spin:.4f}", f"{r.series['tip_spin'][i] / spin - 1:.1e}")


def then(directory):
    """Fed into the helix, then turned: push and torque, what they are over the pressures' sum N, beside the straight rod's."""
    row("length", "push", "torque", "spin of the tip", "turned about the tube, degrees", "push over its N, off by",
        "torque over its N, off by")
    r = Result(directory, "then")
    for t in (70, 74, 74.5, 75, 75.5, 76, 82, 88, 96):
        push, torque, spin, normal = (np.interp(t, r.series["t"], r.series[name])
                                      for name in ("base_force_1", "base_moment_1", "tip_spin", "contact_force"))
        x, slip = r.shapes["x"][np.abs(r.shapes["t"] - t).argmin()], np.hypot(1, D / 2 * spin)
        turn = np.degrees(np.unwrap(np.arctan2(x[:, 1], R - x[:, 2])))
        off = ("", "") if t < 75.5 else (f"{(push - VISCOUS * (4 + t)) / normal / (MU / slip) - 1:.1e}",
                                         f"{torque / normal / (MU * (D / 2)**2 * spin / slip) - 1:.1e}")
        row(4 + t, f"{push:.3f}", f"{torque:.4f}", f"{spin:.2f}", f"{np.abs(turn).max():.0f}", *off)


def shades(count):
    """Colours of moments one after the other, as plots of shapes have them."""
    return plt.get_cmap("viridis")(np.linspace(0, 0.88, count))


def lettered(*axes):
    for ax, letter in zip(axes, "abcd"):
        ax.set_title(f"({letter})", loc="left")


def from_above(ax, r, times, end):
    """The rod in its tube at several times, one below the other, drawn wider than it is."""
    for k, (t, shade) in enumerate(zip(times, shades(len(times)))):
        x, middle = r.shapes["x"][np.abs(r.shapes["t"] - t).argmin()], -0.26 * k
        ax.plot(x[:, 0], x[:, 1] + middle, lw=0.8, color=shade)
        ax.fill_between([0, end], middle - R, middle + R, color="0.94", lw=0, zorder=0)
        ax.text(1.01 * end, middle, f"$L = {4 + t:g}$", va="center")
    ax.set(xlim=(0, 1.12 * end), yticks=[], xlabel="$x_1$; seen from above, drawn wider than it is")
    ax.tick_params(top=False)
    ax.spines[["left", "right", "top"]].set_visible(False)


def draw_push(ax, fed, spun):
    for r, name, colour in ((fed, "fed", BLUE), (spun, "fed and spun", ORANGE)):
        ax.semilogy(r.length[r.length > 4.1], r.push[r.length > 4.1], color=colour, label=name)
    x = np.linspace(4, 110)
    ax.semilogy(x, MU * W * x, "k:", label=r"$\mu w L$")
    for P, words in ((2, "sinus: 2"), (2 * np.sqrt(2), r"$2\sqrt{2}$")):
        ax.axhline(P, color=GREY, lw=0.5, zorder=0)
        ax.text(1 if P == 2 else 109, P, words, fontsize=7, color=GREY, va="bottom", ha="left" if P == 2 else "right")
    ax.set(xlabel="length injected $L$", ylabel="push $P$", xlim=(0, 112), ylim=(0.1, 60))
    ax.legend(loc="upper left")


def draw_inverse(ax, fed):
    times = 70, 75, 80, 81.5
    for t, shade in zip(times, shades(len(times))):
        x, force, _, _ = along(fed, t)
        ax.plot(x, 1 / force, color=shade, label=f"$L = {4 + t:g}$")
    x = np.linspace(0, 22)
    ax.plot(x, 0.035 + MU * R / 4 * x, "k:", label=r"slope $\mu r/4B$")
    ax.set(xlim=(0, 25), ylim=(0, 0.35), xlabel="$x_1$", ylabel="1 / force along the tube")
    ax.legend(ncols=2, loc="lower right", fontsize=7)


def draw_turns(ax, fed):
    x, force, turns, _ = along(fed, 80)
    ax.plot(x, np.abs(turns), color=BLUE, label=r"$d\theta/ds$ at $L = 84$")
    ax.plot(x, np.sqrt(np.clip(force, 0, None) / 2), "k:", label=r"$(P/2B)^{1/2}$")
    ax.set(xlim=(0, 25), ylim=(0, 4), xlabel="$x_1$", ylabel="turn per length")
    ax.legend(loc="upper right")


def picture(directory, file=ROOT / "docs" / "figures" / "injected-tube.png"):
    fed, spun = Result(directory, "fed-500"), Result(directory, "spun")
    figure = plt.figure(figsize=(7.2, 5.4), layout="constrained")
    grid = figure.add_gridspec(3, 2, height_ratios=(1, 1, 0.95))
    axes = [figure.add_subplot(place) for place in (grid[:2, 0], grid[0, 1], grid[1, 1], grid[2, :])]
    draw_push(axes[0], fed, spun)
    draw_inverse(axes[1], fed)
    draw_turns(axes[2], fed)
    from_above(axes[3], fed, (50, 64, 70, 81), 90)
    lettered(*axes)
    figure.savefig(file, dpi=200)


def picture_then(directory, file=ROOT / "docs" / "figures" / "injected-spun.png"):
    """Fed, then spun: push and torque over the length, and the rod from above before and after."""
    r = Result(directory, "then")
    figure = plt.figure(figsize=(7.2, 3.2), layout="constrained")
    grid = figure.add_gridspec(2, 2, width_ratios=(1, 1.25))
    axes = [figure.add_subplot(grid[0, 0])]
    axes += [figure.add_subplot(grid[1, 0], sharex=axes[0]), figure.add_subplot(grid[:, 1])]
    for ax, values, name in zip(axes, (r.push, r.series["base_moment_1"]), ("push", "torque")):
        ax.plot(r.length, values, color=BLUE)
        ax.axvspan(78, 79, color="0.9", lw=0, zorder=0)
        ax.set(ylabel=name, xlim=(60, 100))
    axes[0].tick_params(labelbottom=False)
    axes[0].set_ylim(0, None)
    axes[0].text(79.3, 7.5, "the clamp starts to turn", fontsize=7, color=GREY)
    axes[1].axhline(0, color=GREY, lw=0.5, zorder=0)
    axes[1].set_xlabel("length injected $L$")
    from_above(axes[2], r, (74, 76, 82, 96), 100)
    lettered(*axes)
    figure.savefig(file, dpi=200)


def main():
    choice = steps_of(__doc__, ["run", "tables", "figure"])
    if "run" in choice.what:
        for name, more in runs(choice.directory).items():
            done = subprocess.run([choice.tendril, "-options_file", ROOT / "options" / "injected-tube.opts", *more.split(),
                                   "-output", choice.directory / f"{name}.h5"], check=True, capture_output=True, text=True)
            (choice.directory / f"{name}.log").write_text(done.stdout)
            print(name, *done.stdout.splitlines()[-1:], flush=True)
    if "tables" in choice.what:
        tables(choice.directory)
        then(choice.directory)
    if "figure" in choice.what:
        with plt.rc_context(STYLE):
            picture(choice.directory)
            picture_then(choice.directory)


if __name__ == "__main__":
    sys.exit(main())

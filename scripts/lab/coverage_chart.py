#!/usr/bin/env python3
"""Draws what coverage.py has found: estimated against true errors of random scenes.

    PYTHONPATH=scripts .venv/bin/python scripts/lab/coverage_chart.py [docs/notes/coverage.csv] [docs/notes/coverage.png]"""

import csv
import sys
from pathlib import Path

import numpy as np
from matplotlib import pyplot as plt

from tendril.style import STYLE

NOTES = Path(__file__).resolve().parents[2] / "docs" / "notes"
COLOURS = {"plain": "#0072B2", "wide": "#56B4E9", "world": "#009E73", "contact": "#D55E00", "hard": "#CC79A7",
           "space": "#E69F00", "space-world": "#F0E442", "linear": "#999999", "linear-world": "#882255", "moving": "#000000"}
LEAST = 1e-10


def main():
    table, picture = ([Path(word) for word in sys.argv[1:3]] + [NOTES / "coverage.csv", NOTES / "coverage.png"][len(sys.argv) - 1:])
    with table.open(newline="") as file:
        rows = [row for row in csv.DictReader(file) if not row["accuracy"]]
    limits = np.array((LEAST, 3))
    with plt.rc_context(STYLE):
        fig, ax = plt.subplots(figsize=(4.2, 3.6))
        ax.fill_between(limits, LEAST, limits, color="#D55E00", alpha=0.08, lw=0)
        for factor, words in ((1, "the error"), (10, "10 times the error"), (100, "100 times")):
            ax.plot(limits, factor * limits, color="#999999", lw=0.6, zorder=1)
            ax.annotate(words, (2 * LEAST, 2.6 * LEAST * factor), fontsize=7, color="#555555", rotation=43,
                        rotation_mode="anchor")
        for kind, colour in COLOURS.items():
            own = [row for row in rows if row["kind"] == kind]
            if own:
                error = [min(1, max(LEAST, *(float(row[k]) for k in ("tip", "norm", "energy")))) for row in own]
                ax.plot(error, [min(1, float(row["estimate"])) for row in own], "o", ms=3, mew=0.3, mec="black",
                        color=colour, label=f"{kind}, {len(own)}")
        ax.set(xscale="log", yscale="log", xlim=limits, ylim=limits, xlabel=r"true error, the largest of tip, $\|x_2\|$ and energy",
               ylabel="error estimate")
        ax.legend(borderaxespad=1.2, loc="lower right", fontsize=7)
        fig.tight_layout()
        fig.savefig(picture, dpi=200)
    ratio = np.array([float(row["ratio"]) for row in rows])
    print(f"{len(rows)} scenes: above the error in {100 * np.mean(ratio >= 1):.1f} %, not below a third of it in "
          f"{100 * np.mean(ratio >= 1 / 3):.1f} %, median {np.median(ratio):.2g}")


if __name__ == "__main__":
    main()

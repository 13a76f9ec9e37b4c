"""Draws the distributions over an ensemble: length at the first self-contact (of the centre line),
width and number of loops at the end, and the members' shapes.

    python -m tendril ensemble results/ensemble --output results/ensemble

Reads the files of scripts/sweep.sh in a directory, or the one file of tendril -task sweep with
-sweep_store series,shapes."""

import argparse
import sys
from pathlib import Path

import matplotlib
import matplotlib.pyplot as plt
import numpy as np
from matplotlib.ticker import MaxNLocator

from .style import BLUE, GREY, ORANGE, STYLE
from .collection import load_sweep
from .errors import ResultsError
from .results import load


def contact_length(r):
    """The length at which the rod first crosses itself, to the step; nan if it never does."""
    first = np.flatnonzero(r.series.self_crossings > 0)
    return r.series.length[first[0]] if len(first) else np.nan


def read(place):
    """The finished runs of a directory, or of a sweep's file."""
    place = Path(place)
    if place.is_dir():
        members = [load(f) for f in sorted(place.glob("*.h5"))]
    else:
        members = list(load_sweep(place).members())
        if members and not (members[0].series and members[0].shapes):
            raise ResultsError(f"{place}: holds no series or no shapes; -sweep_store series,shapes")
    members = [r for r in members if r.finished and r.series]
    if not members:
        raise ResultsError(f"{place}: holds no finished run")
    return members


def above(ax):
    """The legend where it covers nothing."""
    ax.legend(loc="lower right", bbox_to_anchor=(1, 1))


def histogram(ax, values, label, bins, median=True):
    values = values[np.isfinite(values)]
    ax.set_xlabel(label)
    ax.set_ylabel("members")
    ax.yaxis.set_major_locator(MaxNLocator(integer=True))
    if not len(values):
        ax.text(0.5, 0.5, "none", transform=ax.transAxes, ha="center")
        return
    ax.hist(values, bins=bins, color=BLUE, edgecolor="white", lw=0.4)
    if median:
        ax.axvline(np.median(values), color=ORANGE, lw=1.2, label="median")
        above(ax)


def main(arguments=None):
    parser = argparse.ArgumentParser(prog="python -m tendril ensemble", description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("place", help="directory, or file of a sweep")
    parser.add_argument("--output", metavar="BASENAME", required=True)
    matplotlib.use("Agg")
    choice = parser.parse_args(arguments)
    try:
        members = read(choice.place)
    except (ResultsError, OSError) as error:
        print(f"ensemble: {error}", file=sys.stderr)
        return 1
    contact = np.array([contact_length(r) for r in members])
    width = np.array([r.series.width[-1] for r in members])
    loops = np.array([int(r.series.self_crossings[-1]) for r in members])
    touched = contact[np.isfinite(contact)]
    print(f"ensemble: {len(members)} members; {len(touched)} cross themselves, first at length "
          + (f"{np.median(touched):.2f} (quartiles {np.percentile(touched, 25):.2f}, "
             f"{np.percentile(touched, 75):.2f})" if len(touched) else "-")
          + f"; width {width.mean():.2f} +- {width.std():.2f}; crossings at the end "
          + ", ".join(f"{k}: {np.sum(loops == k)}" for k in np.unique(loops)))
    with plt.rc_context(STYLE):
        figure, axes = plt.subplots(2, 2, figsize=(6.3, 4.6), layout="constrained")
        for r in members:
            axes[0, 0].plot(*r.at(r.shapes.t[-1]).x.T, color=GREY, lw=0.4, alpha=0.35)
        middle = members[int(np.argmin(np.abs(width - np.median(width))))]
        axes[0, 0].plot(*middle.at(middle.shapes.t[-1]).x.T, color=ORANGE, lw=1.3,
                        label="of median width")
        above(axes[0, 0])
        axes[0, 0].plot(0, 0, "ks", ms=3, zorder=4)
        axes[0, 0].set(xlabel="$x_1$", ylabel="$x_2$")
        axes[0, 0].set_aspect("equal", adjustable="datalim")
        histogram(axes[0, 1], contact, "length at the first crossing", 24)
        histogram(axes[1, 0], width, "width at the end", 24)
        histogram(axes[1, 1], loops.astype(float), "crossings at the end",
                  np.arange(-0.5, loops.max() + 1), median=False)
        axes[1, 1].set_xticks(range(0, loops.max() + 1, max(1, loops.max() // 8)))
        for ax, letter in zip(axes.flat, "abcd"):
            ax.set_title(f"({letter})", loc="left")
        for ending in ("png", "pdf"):
            figure.savefig(f"{choice.output}.{ending}")
    return 0


if __name__ == "__main__":
    sys.exit(main())

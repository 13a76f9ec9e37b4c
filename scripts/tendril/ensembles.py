"""Draws the distributions over an ensemble: length at the first self-contact (of the centre line),
width and number of loops at the end, and the members' shapes.

    tendril-py ensemble results/ensemble --output results/ensemble

Reads the files of scripts/sweep.sh in a directory, or the one file of tendril -task sweep with
-sweep_store series,shapes.

    print(tendril.ensemble(sweep)); tendril.ensemble(sweep).plot().savefig("ensemble.pdf")    in Python"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import matplotlib
import numpy as np
from matplotlib.ticker import MaxNLocator

from .collection import Sweep, load_sweep
from .command import Parser
from .errors import ResultsError, path_of
from .loading import load
from .results import Results
from .style import BLUE, GREY, ORANGE, STYLE, InStyle, save

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def contact_length(r):
    """The length at which the rod first crosses itself, to the step; nan if it never does."""
    first = np.flatnonzero(r.series.self_crossings > 0)
    return r.series.length[first[0]] if len(first) else np.nan


def finished(sweep: Sweep):
    return [r for r in sweep.members.flat if isinstance(r, Results)]


def read(place):
    """The finished runs of a sweep, of its file, of a directory, or of a list."""
    if isinstance(place, Sweep):
        members = finished(place)
    elif isinstance(place, (list, tuple)):
        members = [r for r in place if isinstance(r, Results)]
    elif path_of(place, "ensemble, without a sweep or a list of runs").is_dir() and not (Path(place) / "sweep.h5").is_file():
        members = [load(f) for f in sorted(Path(place).glob("*.h5"))]
    else:
        members = finished(load_sweep(Path(place) / "sweep.h5" if Path(place).is_dir() else place))
    members = [r for r in members if r.finished]
    if members and not (members[0].series and members[0].shapes):
        raise ResultsError(f"{place}: holds no series or no shapes; -sweep_store series,shapes")
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


@dataclass
class Ensemble:
    """What differs over an ensemble."""

    members: list[Results]
    contact: np.ndarray  # length at the first crossing, nan where there is none
    width: np.ndarray  # at the end
    loops: np.ndarray  # crossings at the end

    def __str__(self):
        touched = self.contact[np.isfinite(self.contact)]
        first = "-" if not len(touched) else f"{np.median(touched):.2f} (quartiles " \
            f"{np.percentile(touched, 25):.2f}, {np.percentile(touched, 75):.2f})"
        loops = ", ".join(f"{k}: {np.sum(self.loops == k)}" for k in np.unique(self.loops))
        return (f"{len(self.members)} members; {len(touched)} cross themselves, first at length {first}; "
                f"width {self.width.mean():.2f} +- {self.width.std():.2f}; crossings at the end {loops}")

    def plot(self) -> Figure:
        """Shapes at the end, and the three as histograms."""
        import matplotlib.pyplot as plt

        with plt.rc_context(STYLE):
            figure = plt.figure(figsize=(6.3, 4.6), layout="constrained", FigureClass=InStyle)
            plt.close(figure)
            axes = figure.subplots(2, 2)
            self.draw_shapes(axes[0, 0])
            histogram(axes[0, 1], self.contact, "length at the first crossing", 24)
            histogram(axes[1, 0], self.width, "width at the end", 24)
            histogram(axes[1, 1], self.loops.astype(float), "crossings at the end",
                      np.arange(-0.5, self.loops.max() + 1), median=False)
            axes[1, 1].set_xticks(range(0, self.loops.max() + 1, max(1, self.loops.max() // 8)))
            for ax, letter in zip(axes.flat, "abcd"):
                ax.set_title(f"({letter})", loc="left")
        return figure

    def draw_shapes(self, ax):
        for r in self.members:
            ax.plot(*r.stored(-1).x[:, :2].T, color=GREY, lw=0.4, alpha=0.35)
        middle = self.members[int(np.argmin(np.abs(self.width - np.median(self.width))))]
        ax.plot(*middle.stored(-1).x[:, :2].T, color=ORANGE, lw=1.3, label="of median width")
        above(ax)
        ax.plot(0, 0, "ks", ms=3, zorder=4)
        ax.set(xlabel="$x_1$", ylabel="$x_2$")
        ax.set_aspect("equal", adjustable="datalim")


def ensemble(place) -> Ensemble:
    """The distributions over an ensemble: a Sweep, its file, a directory of result files, or a list of
    Results. print() tells them, .plot() draws them."""
    members = read(place)
    return Ensemble(members, np.array([contact_length(r) for r in members]),
                    np.array([r.series.width[-1] for r in members]),
                    np.array([int(r.series.self_crossings[-1]) for r in members]))


def main(arguments=None):
    parser = Parser("tendril-py ensemble", __doc__)
    parser.add_argument("place", help="directory, or file of a sweep")
    parser.add_argument("--output", metavar="BASENAME", required=True)
    matplotlib.use("Agg")
    choice = parser.parse_args(arguments)
    found = ensemble(choice.place)
    print(f"ensemble: {found}")
    print(f"ensemble: {save(found.plot(), choice.output, None)} show it")
    return 0

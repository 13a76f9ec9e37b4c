"""Draws files of -task stability and -task critical, as PNG and PDF: the eigenvalues over t (with
|x2| of a run below them), the critical mode, the perturbation that grows most.

    tendril-py stability results/stability-dry.h5 --run results/uniform-dry.h5
    tendril-py stability results/critical.h5

Symbols are those of the README; all is dimensionless."""

from pathlib import Path

import matplotlib
import matplotlib.pyplot as plt
import numpy as np

from .command import Parser
from .errors import ResultsError
from .loading import MOST, finite, load
from .style import BLUE, GREEN, GREY, ORANGE, RED, STYLE, InStyle, save

CURVES = (("lambda_max_A", BLUE, r"$\lambda_{max}(A)$", "-"),
          ("lambda_max_A_plus_AT", ORANGE, r"$\lambda_{max}(A + A^T)$", "-"),
          ("lambda_max_C", GREEN, r"$\lambda_{max}(C)$", "-"),
          ("rate_friction_norm", "black", "rate, friction norm", ":"))


LINEAR = 1  # up to here the axis of the eigenvalues is linear, beyond logarithmic


def symlog(ax):
    """An axis that is logarithmic on both sides of a linear strip. Where it changes from the one to
    the other curves have a kink that is none of theirs: the strip is drawn, and says so."""
    ax.set_yscale("symlog", linthresh=LINEAR)
    ax.axhspan(-LINEAR, LINEAR, color="#f0f0f0", lw=0, zorder=0)
    ax.annotate("linear", (1, 0), xycoords=ax.get_yaxis_transform(), xytext=(3, 0),
                textcoords="offset points", rotation=270, va="center", fontsize=6, color=GREY)


def draw_stability(ax, r, legend=True):
    """The curves of one result of -task stability over t."""
    table, lowest = r.stability, 0
    for name, colour, label, line in CURVES:
        if name in table:
            ax.plot(table.t, table[name], color=colour, ls=line, label=label)
            lowest = min(lowest, float(np.min(table[name])))
    ax.axhline(0, color=GREY, lw=0.5)
    ax.axvline(float(table.t_cr), color=RED, lw=0.6, ls="--")
    ax.annotate(rf"$t_{{cr}} = {float(table.t_cr):.5g}$", (float(table.t_cr), 1),
                xycoords=ax.get_xaxis_transform(), xytext=(0, 3), textcoords="offset points",
                ha="center", va="bottom", color=RED, fontsize=7)
    symlog(ax)
    ax.set_xlim(table.t[0], table.t[-1])
    ax.set_ylabel("eigenvalue")
    ax.set_xlabel("time $t$")
    if legend:
        ax.legend(loc="lower center", bbox_to_anchor=(0.5, 1.09), ncol=2, fontsize=6)


def minimum(t, norm):
    """Time and size of the smallest value, by a quartic through the logarithms around it: the
    minimum is flat, and the nearest step may be some way off."""
    i = int(norm.argmin())
    low, high = max(0, i - 4), min(len(t), i + 5)
    if i in (0, len(t) - 1) or high - low < 5:
        return t[i], norm[i]
    quartic = np.poly1d(np.polyfit(t[low:high] - t[i], np.log(norm[low:high]), 4))
    near = np.linspace(t[max(0, i - 2)], t[min(len(t) - 1, i + 2)], 2001) - t[i]
    k = int(quartic(near).argmin())
    return t[i] + near[k], float(np.exp(quartic(near[k])))


def draw_run(ax, r, end):
    """|x2| of a run in time, with its minimum."""
    t, norm = r.series.t, r.series.norm_x2
    keep = (t <= end) & (norm > 0) & (norm < MOST)
    if not keep.any():
        raise ResultsError(f"{r.told}: holds no deflection before t = {end:g}")
    t, norm = t[keep], norm[keep]
    at, least = minimum(t, norm)
    ax.semilogy(t, norm, color=BLUE)
    ax.plot(at, least, "o", ms=4, color=RED)
    ax.annotate(rf"$t = {at:.5g}$", (at, least), xytext=(-4, 4), ha="right", color=RED,
                textcoords="offset points", fontsize=7)
    ax.set_xlim(0, end)
    ax.set_xlabel("time $t$")
    ax.set_ylabel(r"$\|x_2\|$")


def draw_critical(ax, r):
    """The critical mode of one result of -task critical."""
    c = r.critical
    if "x2" in c:  # in space
        ax.plot(c.s, c.x2, color=BLUE, label=r"$x_2$")
        ax.plot(c.s, c.x3, color=ORANGE, ls="--", label=r"$x_3$")
    else:
        ax.plot(c.s, c.y, color=BLUE, label=r"$y$")
        ax.plot(c.s, c.theta, color=ORANGE, ls="--", label=r"$\theta$")
    kind = rf"flutter, $\omega = {float(c.frequency):.4g}$" if c.frequency > 0 else "buckling"
    ax.set_title(rf"$t_{{cr}} = {float(c.t):.6f}$, $L_{{cr}} = {float(c.length):.6f}$, {kind}",
                 fontsize=7)
    ax.set_xlabel("$s$")
    ax.set_ylabel("critical mode")
    ax.legend(loc="upper left")


def draw_optimal(ax, r, norm="L2"):
    """The deflection that grows most over the window of a result, before and after."""
    table = r.groups["transient"]
    table.of = f"{r.told}: transient"
    t1, t2, amplification = (float(finite(table, name, 0)) for name in ("t1", "t2", f"{norm}/amplification"))
    s = finite(table, f"{norm}/s", 1)
    before, after = (finite(table, f"{norm}/{name}", 1, s.shape) for name in ("initial_y", "final_y"))
    if not (before.any() and after.any()):
        raise ResultsError(f"{table.of}: its deflections are 0")
    ax.plot(s, before / np.abs(before).max(), color=BLUE, label=rf"at $t = {t1:.4g}$")
    ax.plot(s, after / np.abs(after).max(), color=ORANGE, ls="--", label=rf"at $t = {t2:.4g}$")
    ax.set_title(f"amplification {amplification:.4g} in {norm}", fontsize=7)
    ax.set_xlabel("$s$")
    ax.set_ylabel("optimal perturbation")
    ax.legend(loc="best")


def panels(results, runs):
    """One column a file: a list of functions that draw, one a row."""
    columns = []
    for i, r in enumerate(results):
        column = []
        if r.stability:
            column.append(lambda ax, r=r: draw_stability(ax, r))
            if runs:
                run, end = runs[min(i, len(runs) - 1)], float(r.stability.t[-1])
                column.append(lambda ax, run=run, end=end: draw_run(ax, run, end))
            if "transient" in r.groups:
                column.append(lambda ax, r=r: draw_optimal(ax, r))
        if r.critical:
            column.append(lambda ax, r=r: draw_critical(ax, r))
        if not column:
            raise ResultsError(f"{r.told}: holds neither a stability table nor a critical mode")
        columns.append(column)
    return columns


def figure_of(results, runs=(), ax=None):
    """A column a result, of -task stability or critical; runs: in time, drawn below the tables, one a
    table or one for all. ax: axes for one panel of one result."""
    columns = panels(results, runs)
    with plt.rc_context(STYLE):
        if ax is not None:
            columns[0][0](ax)
            return ax.figure
        rows = max(len(c) for c in columns)
        figure = plt.figure(figsize=(3.4 * len(columns), 2.2 * rows), layout="constrained", FigureClass=InStyle)
        axes = figure.subplots(rows, len(columns), squeeze=False)
        for k, column in enumerate(columns):
            for place, panel in zip(axes[:, k], column):
                panel(place)
            for place in axes[len(column):, k]:
                place.set_visible(False)
        plt.close(figure)
    return figure


def main(arguments=None):
    parser = Parser("tendril-py stability", __doc__)
    parser.add_argument("files", nargs="+", metavar="FILE", help="result files, HDF5")
    parser.add_argument("--run", action="append", default=[], metavar="FILE",
                        help="a run in time to draw below a table; once a table, or once for all")
    parser.add_argument("--output", metavar="BASENAME",
                        help="writes BASENAME.png and .pdf; default: the first file's name")
    matplotlib.use("Agg")
    view = parser.parse_args(arguments)
    output = view.output or str(Path(view.files[0]).with_suffix(""))
    figure = figure_of([load(p) for p in view.files], [load(p) for p in view.run])
    print(f"plot: {save(figure, output, None)}")
    return 0

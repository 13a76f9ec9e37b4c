"""Draws a quantity of a sweep over two options, or over one as a curve, as PNG and PDF.

    scripts/map.sh results/map --axes friction_mu,growth_width
    scripts/map.sh results/one --axes friction_mu --quantity width
    scripts/map.sh results/map2 --axes friction_mu,friction_beta --quantity critical/length
    scripts/map.sh results/widths --axes friction_mu,growth_initial_length --quantity width

The quantity is a number of the files, or a series, of which the last value is taken. Reads the files of
scripts/sweep.sh in a directory, or the one file of tendril -task sweep (or the directory that
tendril.sweep keeps it in); points that are missing or unfinished stay white.

    tendril.map(sweep, ("friction_mu", "growth_width"), "width").savefig("map.pdf")      in Python"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import h5py
import matplotlib
import numpy as np
from matplotlib.ticker import LogLocator, MaxNLocator, NullLocator

from .collection import Sweep, load_sweep
from .command import Parser
from .errors import RunError, TendrilError, arguments, path_of
from .naming import options_in, unknown
from .style import STYLE, InStyle, save
from .titles import in_words
from .units import DIMENSIONS, KINDS, in_laboratory, suited_to
from .units import quantity as number_with_unit

if TYPE_CHECKING:
    from matplotlib.figure import Figure

LABELS = {"friction_mu": r"dry share $\mu$", "growth_width": r"growth width $a$",
          "friction_beta": r"regularisation $\beta$", "growth_initial_length": r"$L_0$",
          "friction_across": r"friction across over along $a$", "tip_force": r"force on the tip $P$",
          "growth_zone": r"length of the growth zone", "critical/t": r"$t_{cr}$",
          "critical/length": r"$L_{cr}$", "critical/frequency": r"frequency at $t_{cr}$"}


def point(path):
    """{'friction_mu': (0.5, ""), ...}, numbers with units, from friction_mu=0.5__growth_width=1.h5"""
    return {k: number(v.replace("_", "/")) for k, v in options_in(path.stem).items()}


def number(text):
    """(number, unit) of 0.5, "0.5" or "0.5N/m"; a plain line for what is none."""
    found = number_with_unit(text)
    if not found:
        raise ValueError(f"{text}: is no number, and has no place on an axis")
    return found


def alone(axes, seen, place, options):
    """A plain line where a place of the map has more than one run: which of them was meant is not known."""
    if place in seen:
        more = " and ".join(name for name in options if name not in axes)
        raise ValueError(f"several runs are at {', '.join(f'{a} {options[a]}' for a in axes)}"
                         + (f", of {more}; map a sweep over two options" if more else ""))


def value_of(file, quantity, si):
    """(a number of a file, or the last of a series: "critical/t", "series/width" or "width"; its unit). si:
    in SI units, with the file's own scales."""
    name = quantity if "/" in quantity else f"series/{quantity}"
    if name not in file:
        known = [*(f"critical/{k}" for k in file.get("critical", ())), *file.get("series", ())]
        raise ValueError(f"{file.filename}: holds no {quantity}{unknown(quantity, known)}")
    value, unit = float(np.ravel(file[name][()])[-1]), file[name].attrs.get("units", b"1").decode()
    if not si:
        return value, unit
    try:
        return value * in_laboratory(unit, lambda kind: float(file.attrs[f"si_{kind}"]))[0], unit
    except KeyError:
        raise ValueError(f"{file.filename}: --si needs runs with -si_bending_stiffness and the like") from None


def of_directory(directory, axes, quantity, si):
    """{(x, y): value} of the files in a directory of scripts/sweep.sh, x and y as (number, unit)"""
    found, seen = {}, set()
    for path in sorted(Path(directory).glob("*=*.h5")):
        if path.name.endswith(".part.h5"):
            continue
        values = point(path)
        if not all(axis in values for axis in axes):
            raise ValueError(f"{path}: does not vary {' and '.join(axes)}")
        alone(axes, seen, place := tuple(values[a] for a in axes), values)
        seen.add(place)
        with h5py.File(path, "r", locking=False) as file:
            if file.attrs.get("finished", 0):
                found[place] = value_of(file, quantity, si)
    return found


def of_sweep(sweep, axes, quantity, si):
    """{(x, y): value} of a sweep, x and y as (number, unit)"""
    points = [sweep.point(k) for k in range(len(sweep))]
    for axis in axes:
        if not points or axis not in points[0]:
            raise ValueError(f"this sweep does not vary {axis}{unknown(axis, points[0] if points else (), ', but')}")
    seen = set()
    for p in points:
        alone(axes, seen, place := tuple(p[axis] for axis in axes), p)
        seen.add(place)
    ends, name = sweep.ends(si), quantity.rpartition("/")[2]
    if name not in ends:
        raise ValueError(f"this sweep holds no {quantity}{unknown(quantity, ends)}")
    values, unit = ends[name]
    unit = sweep.units.get(f"final/{name}", sweep.units.get(f"critical/{name}", unit))  # si: read() names it
    return {tuple(number(p[axis]) for axis in axes): (float(v), unit)
            for p, v, r in zip(points, values, sweep.members.flat) if not isinstance(r, RunError)}


def found_at(place, axes, quantity, si):
    if isinstance(place, Sweep):
        return of_sweep(place, axes, quantity, si)
    place = path_of(place, "map, without a sweep")
    if Path(place).is_dir() and not (Path(place) / "sweep.h5").is_file():
        return of_directory(place, axes, quantity, si)
    return of_sweep(load_sweep(Path(place) / "sweep.h5" if Path(place).is_dir() else place), axes, quantity,
                    si)


def read(place, axes, quantity, si=False):
    """(x values, y values, table [y, x] with NaN where there is no result, the units of all three)"""
    found = found_at(place, axes, quantity, si)
    if not found:
        raise ValueError("there is no finished point to draw")
    units = [{p[k][1] for p in found} for k in (0, 1)]
    for axis, there in zip(axes, units):
        if len(there) > 1:
            raise ValueError(f"{axis} is in several units")
    unit = next(iter(found.values()))[1]
    found = {(x, y): value for ((x, _), (y, _)), (value, _) in found.items()}
    xs, ys = (np.array(sorted({p[k] for p in found})) for k in (0, 1))
    table = np.array([[found.get((x, y), np.nan) for x in xs] for y in ys])
    table, unit = shown(table, unit, si)
    return xs, ys, table, [*(there.pop() for there in units), unit]


def shown(values, unit, si):
    """Values as they are drawn, and the unit behind their name: cm rather than m, where that suits."""
    if si and unit in KINDS:
        unit, one = suited_to(KINDS[unit], np.nanmax(np.abs(values)))
        return values / one, unit
    return values, DIMENSIONS[unit][1] if si and unit in DIMENSIONS else ""


def labelled(name, unit):
    """What stands beside an axis: of an option, or of a quantity."""
    return LABELS.get(name, in_words(name.removeprefix("series/"))) + (f" ({unit})" if unit else "")


def even(values):
    """Whether values are closer to evenly spaced than to evenly spaced logarithms."""
    if len(values) < 3 or values[0] <= 0:
        return True
    steps, ratios = np.diff(values), np.diff(np.log(values))
    return np.ptp(steps) / steps.mean() <= np.ptp(ratios) / ratios.mean()


def edges(values):
    """Where cells around these values meet: halfway, on a logarithmic axis by their logarithms."""
    v = np.asarray(values, float) if even(values) else np.log(values)
    if len(v) == 1:
        return [v[0] - 0.5, v[0] + 0.5]
    middle = (v[1:] + v[:-1]) / 2
    found = np.concatenate([[2 * v[0] - middle[0]], middle, [2 * v[-1] - middle[-1]]])
    return found if even(values) else np.exp(found)


def draw(ax, xs, ys, table, units, axes, quantity):
    # before the contours: their labels cut them where they are on the screen
    for values, scale, axis in ((xs, ax.set_xscale, ax.xaxis), (ys, ax.set_yscale, ax.yaxis)):
        if not even(values):
            scale("log")
            if values[-1] < 1000 * values[0]:  # few decades: 0.5, 1, 2, not powers of ten alone
                axis.set_major_locator(LogLocator(subs=(1, 2, 5)))
                axis.set_major_formatter("{x:g}")
                axis.set_minor_locator(NullLocator())
    low, high = np.nanmin(table), np.nanmax(table)
    wide = low > 0 and high > 100 * low  # over decades: colours and contours by the logarithm
    colours = ax.pcolormesh(edges(xs), edges(ys), table, shading="flat", cmap="cividis",
                            rasterized=True, norm="log" if wide else "linear")
    if np.isfinite(table).all() and min(table.shape) > 2 and np.ptp(table) > 0:
        levels = (LogLocator(subs=(1, 2, 5)) if wide else MaxNLocator(9)).tick_values(low, high)
        dark = colours.norm(levels) < 0.6  # white on dark cells, black on light ones
        lines = ax.contour(xs, ys, table, levels=levels, linewidths=0.5,
                           colors=np.where(dark, "white", "#222222"))
        ax.clabel(lines, fontsize=6, fmt="%.4g")
    for axis, unit, label in zip(axes, units, (ax.set_xlabel, ax.set_ylabel)):
        label(labelled(axis, unit))
    ax.figure.colorbar(colours, ax=ax, label=labelled(quantity, units[2]))


def curve(ax, place, axis, quantity, si):
    """Draws it over one option; how many points have no result."""
    found = found_at(place, (axis,), quantity, si)
    if not found:
        raise ValueError("there is no finished point to draw")
    if len(units := {x[1] for (x,) in found}) > 1:
        raise ValueError(f"{axis} is in several units")
    x = np.array(sorted(x for ((x, _),) in found))
    y = np.array([next(value for (place,), (value, _) in found.items() if place[0] == one) for one in x])
    y, unit = shown(y, next(iter(found.values()))[1], si)
    ax.plot(x, y, "o-", ms=3)
    if not even(x):
        ax.set_xscale("log")
    ax.set_xlabel(labelled(axis, units.pop()))
    ax.set_ylabel(labelled(quantity, unit))
    return int(np.isnan(y).sum())


@arguments(axes="texts", quantity="text", si="flag")
def map(sweep, axes, quantity="critical/t", *, si=False, ax=None) -> Figure:
    """Draws a number of a sweep over two of its options, or over one as a curve; the figure.

    sweep     a Sweep, its file, or a directory of scripts/sweep.sh
    axes      two options, along and up; one: along
    quantity  "width", "critical/length": of a series the last value
    si        the quantity in units of the laboratory
    ax        axes of matplotlib to draw into, in place of a figure of its own"""
    import matplotlib.pyplot as plt

    axes = [name.strip().lstrip("-") for name in (axes.split(",") if isinstance(axes, str) else axes)]
    if len(axes) not in (1, 2) or not all(axes):
        raise TendrilError(f"map: give one option for a curve, or two for axes, not {', '.join(axes) or 'none'}")
    with plt.rc_context(STYLE):
        try:
            if len(axes) == 2:
                xs, ys, table, units = read(sweep, axes, quantity, si)
            figure = ax.figure if ax else plt.figure(figsize=(3.4, 2.7), layout="constrained", FigureClass=InStyle)
            if len(axes) == 1:
                figure.missing = curve(ax or figure.subplots(), sweep, axes[0], quantity, si)
            else:
                draw(ax or figure.subplots(), xs, ys, table, units, axes, quantity)
                figure.missing = int(np.isnan(table).sum())
        except ValueError as error:
            raise TendrilError(f"map: {error}") from None
    if not ax:
        plt.close(figure)
    return figure


def main(arguments=None):
    parser = Parser("scripts/map.sh", __doc__)
    parser.add_argument("place", help="directory of scripts/sweep.sh, or file of a sweep")
    parser.add_argument("--axes", required=True, metavar="X,Y", help="options along the axes; one alone: a curve")
    parser.add_argument("--quantity", default="critical/t", help="default %(default)s")
    parser.add_argument("--si", action="store_true", help="the quantity in SI units, of runs with -si_ options")
    parser.add_argument("--output", metavar="BASENAME",
                        help="writes BASENAME.png and .pdf; default: the place's name")
    view = parser.parse_args(arguments)
    matplotlib.use("Agg")
    figure = map(view.place, view.axes, view.quantity, si=view.si)
    drawn = save(figure, view.output, Path(view.place).with_suffix("") if view.place.endswith(".h5")
                 else view.place.rstrip("/"))
    if figure.missing:
        print(f"map: {figure.missing} points have no result")
    print(f"map: {drawn}")
    return 0

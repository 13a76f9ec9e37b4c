"""Draws result files of tendril as PNG and PDF: one column a file, or all files in one with
--overlay.

    scripts/plot.sh results/uniform-dry.h5
    scripts/plot.sh results/uniform-*.h5 --panels norm,shapes --times 10,20,30 --output compare
    scripts/plot.sh slow.h5 fast.h5 --overlay --panels shapes,width,tip_x1+tip_x2
    scripts/plot.sh mytube.h5 --times 20s,1min

Symbols are those of the README. Runs with a physical rod (-si_ options) are drawn in the units of the laboratory, each by
its own scales; others, and all with --dimensionless, in the units of the file.

panels: {panels}, all of them as "all", or the name of any series of the file (docs/results.md), or
several in one, joined by +"""

from __future__ import annotations

import itertools
import re
from dataclasses import dataclass, field
from pathlib import Path
from string import ascii_lowercase
from typing import TYPE_CHECKING, Sequence

import matplotlib
import matplotlib.pyplot as plt
import numpy as np
from matplotlib import colormaps
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import RendererAgg
from matplotlib.collections import LineCollection
from matplotlib.colors import Normalize, to_rgb
from matplotlib.lines import Line2D
from matplotlib.patheffects import withStroke
from matplotlib.text import Annotation
from matplotlib.ticker import LogLocator, NullLocator

from . import plot_stability
from .bends import bends_of
from .command import Parser
from .errors import ResultsError, arguments
from .loading import load, runs_of
from .naming import did_you_mean
from .perspective import VIEW, Rods, Strand, box_of, draw_surfaces, fit_seen, furnish, head, seen_aspect, sight
from .results import Results
from .senses import strain_rate
from .several import Rod
from .solids import solids
from .spatial import diameter_of, lift, out_of_plane, up_of
from .style import BLUE, COLOURS, GREEN, GREY, ORANGE, RED, STYLE, InStyle, save
from .surroundings import arc_length, contact_force, size_of
from .titles import titles_of
from .units import Units, add_choice_of_units, briefly, in_laboratory_of, moment, scale_of
from .walls import draw_contact, draw_lamp, draw_rod, draw_walls, strongest_contact

if TYPE_CHECKING:
    from matplotlib.figure import Figure

NAMED = 24  # of an overlay: more runs have colours alone
STYLES = ("-", "--", ":", "-.", (0, (4, 1, 1, 1, 1, 1)))


@dataclass
class View:
    """What is drawn, and how."""

    results: list[Results]
    units: Units
    times: list | None = None  # of the shapes, numbers or with a unit; None: quarters of each run
    overlay: bool = False
    titles: list[str] = field(default_factory=list)
    beside: dict = field(default_factory=dict)  # path -> run drawn dashed beside it
    view: tuple = VIEW  # from where rods in space are seen

    def of(self, r) -> Units:
        """The units of a run: its own numbers may be multiplied by others than another's."""
        return self.units.at(r)

    def colour(self, r, otherwise):
        """In an overlay a run has its colour in all panels."""
        return colours(len(self.results))[self.results.index(r)] if self.overlay else otherwise

    def style(self, r, number, otherwise):
        """In an overlay lines of one run are told apart by their style."""
        return STYLES[number % len(STYLES)] if self.overlay else otherwise

    def second(self, r):
        """What 1 of the run's time is in that which is shown."""
        return self.of(r).scales["time"][0]

    def times_of(self, r):
        """Of the shapes drawn, as the run's file counts them."""
        end = r.shapes.t[-1] * (1 + 1e-9)
        if self.times is not None:
            return [t for t in (moment("times", word, [r]) for word in self.times) if t <= end]
        first = r
        if self.overlay:  # the same for all
            first = min(self.results, key=lambda r: r.shapes.t[-1] * self.second(r))
        found = sorted({shape_of(first, first.shapes.t[-1] * k / 4).t for k in (1, 2, 3, 4)})
        return found if first is r else [min(t * self.second(first) / self.second(r), r.shapes.t[-1]) for t in found]


def colours(count) -> list:
    """As many colours as there are runs: those of the style, or if there are more evenly along a map."""
    if count <= len(COLOURS):
        return list(COLOURS[:count])
    return [tuple(shade) for shade in colormaps["viridis"](np.linspace(0, 0.94, count))]


def shape_of(r, t):
    """The shape at a time; where too few are stored to tell it, the stored one that is nearest."""
    try:
        return r.at(t)
    except ResultsError:
        return r.at(t, nearest=True)


def power_of_ten(value):
    mantissa, exponent = f"{value:.1e}".split("e")
    return rf"{mantissa} \times 10^{{{int(exponent)}}}"


# Each panel draws one result into one axes.


def decades(ax):
    """A logarithmic axis with a tick a decade, or every few, so that labels do not run together."""
    ax.set_yscale("log")
    ax.yaxis.set_major_locator(LogLocator(numticks=7))
    ax.yaxis.set_minor_locator(NullLocator())


def mark_minimum(ax, r, view):
    """The smallest deflection, if it lies within the run and is not just its first or last step."""
    at, least = r.minimum("norm_x2")
    if at in (r.series.t[0], r.series.t[-1]):
        return
    point = view.of(r).of("time", at), view.of(r).of("length", least)
    ax.plot(*point, "o", ms=4, color=view.colour(r, RED))
    if view.overlay:
        return
    late = at > 0.55 * r.series.t[-1]
    ax.annotate(rf"${power_of_ten(point[1])}$ at {view.of(r).time(at)}", point, color=RED,
                xytext=(-5 if late else 5, -5), textcoords="offset points", va="top",
                ha="right" if late else "left",
                path_effects=[withStroke(linewidth=2.5, foreground="white")])  # over other curves


def settle(figure):
    """Moves what is written at a point to where no curve goes through it, if there is such a place within its axes; else to any
    within them."""
    renderer = RendererAgg(*figure.bbox.size, figure.dpi)
    for ax in figure.axes:
        curves = [line.get_path().transformed(ax.transData).cleaned(remove_nans=True)
                  for line in ax.lines if len(line.get_xdata()) > 1]
        for text in filter(lambda t: isinstance(t, Annotation), ax.texts):
            first = text.get_ha(), *text.xyann
            places = list(itertools.product((-5, *range(5, 42, 3), -16, -27), (1, -1)))
            for (down, side), anywhere in [*((place, False) for place in places), *((place, True) for place in places), (places[0], None)]:
                text.set(ha=first[0] if side > 0 else {"left": "right", "right": "left"}[first[0]],
                         va="top" if down < 0 else "bottom")
                text.xyann = side * first[1], down
                box = text.get_window_extent(renderer).padded(2)
                if ax.bbox.x0 < box.x0 and box.x1 < ax.bbox.x1 and ax.bbox.y0 < box.y0 \
                        and box.y1 < ax.bbox.y1 and (anywhere or not any(c.intersects_bbox(box, False) for c in curves)):
                    break


def panel_norm(ax, r, view):
    decades(ax)
    ax.set_ylabel(view.of(r).label(r"deflection $\|x_2\|$", "length"))
    for run, line, colour in ((r, "-", BLUE), (view.beside.get(r.path), "--", GREY)):
        if run is not None and (run.series.norm_x2 > 0).any():
            norm = view.of(run).of("length", np.ma.masked_less_equal(run.series.norm_x2, 0))
            ax.plot(view.of(run).of("time", run.series.t), norm, line, color=view.colour(r, colour),
                    label=r"$\|x_2\|$" if r.in_space else None)
            shade(ax, run, view, "norm_x2", view.of(run).of("length", 1.0), view.colour(r, colour))
    if r.in_space and (r.series.norm_x3 > 0).any():
        norm = view.of(r).of("length", np.ma.masked_less_equal(out_of_plane(r), 0))
        ax.plot(view.of(r).of("time", r.series.t), norm, view.style(r, 1, "--"), color=view.colour(r, ORANGE),
                label=r"$\|x_3\|$")
        ax.set_ylabel(view.of(r).label("deflection", "length"))
    if (r.series.norm_x2 > 0).any():
        mark_minimum(ax, r, view)
        ax.margins(y=0.25)  # room for what is written below the minimum
    elif not view.overlay:
        ax.text(0.5, 0.5, r"$x_2 = 0$ throughout", transform=ax.transAxes, ha="center")


def shade(ax, r, view, name, factor, colour):
    """The band that a series is in, as far as the run tells its errors."""
    band = r.band(name)
    if band is not None:
        low, high = band
        if ax.get_yscale() == "log":
            low = np.maximum(low, 1e-3 * high)
        ax.fill_between(view.of(r).of("time", r.series.t), factor * low, factor * high, color=colour, alpha=0.18, lw=0)


def curves(unit, label, *lines):
    """A panel of lines over time, in a unit of the file: (series, label, colour, style); a series the
    file lacks is left out."""
    def panel(ax, r, view):
        factor, name_of_unit = view.of(r).unit(unit)
        for number, (name, text, colour, style) in enumerate(lines):
            if name in r.series:
                ax.plot(view.of(r).of("time", r.series.t), factor * r.series[name],
                        linestyle=view.style(r, number, style), color=view.colour(r, colour),
                        label=text)
                shade(ax, r, view, name, factor, view.colour(r, colour))
        typeset = re.sub(r"\^\(?([0-9/]+)\)?", r"$^{\1}$", name_of_unit)
        ax.set_ylabel(f"{label} ({typeset})" if typeset else label)

    return panel


def panel_power(ax, r, view):
    lines = [("growth_power", "growth", BLUE, "-"), ("dissipation", "friction", ORANGE, "--")]
    if any(np.abs(run.series.get("tip_power", 0)).max() > 1e-4 * run.series.growth_power.max()
           for run in view.results):
        lines.append(("tip_power", "tip", GREEN, ":"))
    for name, text in (("curvature_power", "steering"), ("tropism_power", "bending itself")):
        if any(name in run.series for run in view.results):
            lines.append((name, text, RED, "-."))
    curves("N l V", "power", *lines)(ax, r, view)


def panel_defect(ax, r, view):
    defect = np.ma.masked_equal(np.abs(r.series.energy_defect), 0)
    decades(ax)
    if defect.count():
        ax.plot(view.of(r).of("time", r.series.t), defect, color=view.colour(r, BLUE), lw=0.8)
    ax.set_ylabel("energy defect, relative")


def panel_errors(ax, r, view):
    """What the run tells of its errors."""
    decades(ax)
    for number, (name, text, colour) in enumerate((("error_tip", "tip", BLUE), ("error_norm_x2", r"$\|x_2\|$", ORANGE),
                                                   ("error_energy", "energy", GREEN))):
        if name in r.series and (r.series[name] > 0).any():
            ax.plot(view.of(r).of("time", r.series.t), np.ma.masked_less_equal(r.series[name], 0), lw=0.8,
                    linestyle=view.style(r, number, "-"), color=view.colour(r, colour), label=text)
    ax.set_ylabel("estimated error, relative")


def draw_shapes(ax, r, view, line):
    """The rod at the times asked for; line: draws a shape with the look it is given."""
    times = view.times_of(r)
    # a time has its colour in all columns, also if some runs end before the last
    shades = plt.get_cmap("viridis")(np.linspace(0, 0.88, len(view.times or times)))
    for number, (t, shade) in enumerate(zip(times, shades)):
        shape = shape_of(r, t)
        line(shape, color=view.colour(r, shade), linestyle=view.style(r, number, "-"),
             label=f"${view.of(r).of('time', shape.t):.4g}$", zorder=2 + 0.5 * (1 - number / len(times)))  # where they lie in one place all are seen
    ax.plot(0, 0, "ks", ms=3, clip_on=False, zorder=3)


def axes_of_place(ax, view, across="$x_2$"):
    ax.set_xlabel(view.units.label("$x_1$", "length"))
    ax.set_ylabel(view.units.label(across, "length"))


def panel_shapes(ax, r, view):
    unit = view.of(r).of("length", 1.0)
    draw_shapes(ax, r, view, lambda shape, **look: draw_rod(ax, r, shape.x[:, :2], unit, **look))
    if not r.in_space:
        draw_walls(ax, r, unit, t=max(view.times_of(r), default=0.0))  # what moves: at the last of the times
    else:
        draw_lamp(ax, r, (0, 1), unit)
    axes_of_place(ax, view)


def panel_side(ax, r, view):
    """A rod in space, seen along x2."""
    unit = view.of(r).of("length", 1.0)
    in_space("side", r)
    draw_shapes(ax, r, view, lambda shape, **look: draw_rod(ax, r, shape.x[:, ::2], unit, **look))
    draw_lamp(ax, r, (0, 2), unit)
    axes_of_place(ax, view, "$x_3$")


def panel_front(ax, r, view):
    """A rod in space, seen along x1."""
    unit = view.of(r).of("length", 1.0)
    in_space("front", r)
    draw_shapes(ax, r, view, lambda shape, **look: draw_rod(ax, r, shape.x[:, 1:], unit, **look))
    draw_lamp(ax, r, (1, 2), unit)
    ax.set_xlabel(view.of(r).label("$x_2$", "length"))
    ax.set_ylabel(view.of(r).label("$x_3$", "length"))


def in_space(panel, r):
    if not r.in_space:
        raise ResultsError(f"plot: {panel}: {r.name} is a rod in the plane")


def panel_space(ax, r, view):
    """The rod in perspective, with axes of true lengths; in a run of the plane x3 is 0."""
    if ax.name != "3d":
        raise ResultsError('plot: the panel space needs axes with projection="3d"')
    unit, times = view.of(r).of("length", 1.0), view.times_of(r)
    shades = plt.get_cmap("viridis")(np.linspace(0, 0.88, len(view.times or times)))
    strands = []
    for number, (t, shade) in enumerate(zip(times, shades)):
        shape = shape_of(r, t)
        colour = view.colour(r, tuple(shade))
        if view.overlay:  # a run has its colour, paler at earlier times
            colour = tuple(1 - (0.4 + 0.6 * (number + 1) / len(times)) * (1 - c) for c in to_rgb(colour))
        else:
            ax.plot([], [], [], color=colour, label=f"${view.of(r).of('time', shape.t):.4g}$")  # for the legend
        strands.append(Strand(unit * lift(r, shape).x, colour, unit * diameter_of(r)))
    drawn = [c for c in ax.collections if isinstance(c, Rods)]  # of the runs before, in an overlay
    rods = drawn[0] if drawn else ax.add_collection(Rods(zorder=3), autolim=False)
    rods.set_strands(rods.strands + strands)
    if "clamp_on" not in r.options:  # else a rod carries it, and no clamp is there
        ax.plot(*(unit * lift(r, r.stored(0)).x[:1].T), "ks", ms=3, zorder=4)
    beside = [] if view.overlay else [one for one in view.results if one is not r]  # their panels have the same box
    others = [view.of(one).of("length", lift(one, shape_of(one, t)).x) for one in beside for t in view.times_of(one)]
    low, high = box_of(np.concatenate([np.zeros((1, 3)), *(s.x for s in rods.strands), *others]))
    furnish(ax, low, high, up_of(r), view.view, lambda name: view.of(r).label(name, "length"))
    draw_surfaces(ax, [one.at(shape.t) for one in solids(r)], low, high, unit)  # what moves: at the last of the times


def along_rod(field, label, unit):
    """A panel of a scalar along the rod, at the times asked for."""
    def panel(ax, r, view):
        times = view.times_of(r)
        factor, name_of_unit = view.of(r).unit(unit)
        shades = plt.get_cmap("viridis")(np.linspace(0, 0.88, len(view.times or times)))
        for number, (t, shade) in enumerate(zip(times, shades)):
            shape = shape_of(r, t)
            ax.plot(view.of(r).of("length", arc_length(shape)), factor * field(r, shape),
                    linestyle=view.style(r, number, "-"), color=view.colour(r, shade),
                    label=f"${view.of(r).of('time', shape.t):.4g}$")
        ax.set_xlabel(view.of(r).label("distance from the clamp, along the rod", "length"))
        ax.set_ylabel(f"{label} ({name_of_unit})" if name_of_unit else label)

    return panel


def panel_bends(ax, r, view):
    """At the times asked for: the bend along the rod, that which it has by nature, and that at which it would learn no more."""
    times = view.times_of(r)
    factor, unit = view.of(r).unit("1/l")
    shades = plt.get_cmap("viridis")(np.linspace(0, 0.88, len(view.times or times)))
    for t, shade in zip(times, shades):
        shape = r.at(t, nearest=True)
        label = f"${view.of(r).of('time', shape.t):.4g}$"
        for _, style, bend in bends_of(r, shape):
            ax.plot(view.of(r).of("length", arc_length(shape)), factor * bend, linestyle=style, color=view.colour(r, shade),
                    label=label)
    shown = {"-": "line", "--": "dashed", ":": "dotted"}
    told = ",\n".join(f"{name} ({shown[style]})" for name, style, _ in bends_of(r, r.stored(0)))
    ax.set_xlabel(view.of(r).label("distance from the clamp, along the rod", "length"))
    ax.set_ylabel(told + (f" ({unit})" if unit else ""), fontsize=7)


def panel_growth(ax, r, view):
    """The rod at the times asked for, darker where it grows faster."""
    unit, times = view.of(r).of("length", 1.0), view.times_of(r)
    shapes = [r.at(t, nearest=True) for t in times]
    rates = [strain_rate(r, shape) for shape in shapes]
    most = max((rate.max() for rate in rates), default=0) or 1
    name = view.units.scales["time"][1]
    for shape, rate in zip(shapes, rates):
        x, rate = unit * shape.x[:, :2], (rate[1:] + rate[:-1]) / 2
        grows = rate > 0.01 * most
        draw_rod(ax, r, shape.x[:, :2], unit, color=GREY, label=f"${view.of(r).of('time', shape.t):.4g}$")
        ax.add_collection(LineCollection(np.stack([x[:-1], x[1:]], axis=1)[grows], array=rate[grows], cmap="YlGn",
                                         norm=Normalize(0, most), linewidths=2.4, zorder=3))
    ax.plot(0, 0, "ks", ms=3, clip_on=False, zorder=4)
    draw_lamp(ax, r, (0, 1), unit)
    axes_of_place(ax, view)
    ax.set_xlabel(f"{ax.get_xlabel()}; darkest: grows by {briefly(most / view.second(r))}" + (f" 1/{name}" if name else ""))


def panel_portrait(ax, r, view):
    """The phase portrait of the tip: its angle and how fast that changes; in space where it points."""
    if r.in_space:
        ax.plot(r.shapes["d1"][:, -1, 1], r.shapes["d1"][:, -1, 2], color=view.colour(r, BLUE))
        ends = r.shapes["d1"][[0, -1], -1, 1:].T
        ax.set(xlabel="tip points along $x_2$", ylabel="along $x_3$")
    else:
        angle = r.series.tip_angle
        turns = np.gradient(angle, view.of(r).of("time", r.series.t))
        ax.plot(angle, turns, color=view.colour(r, BLUE))
        ends = np.array([angle, turns])[:, [0, -1]]
        ax.set(xlabel="angle of the tip", ylabel=view.of(r).label("turns by", "time").replace(" (", " (1/"))
    for (x, y), fill in zip(ends.T, ("white", view.colour(r, BLUE))):  # its begin is open
        ax.plot(x, y, "o", ms=4, color=view.colour(r, BLUE), mfc=fill)


def panel_energy(ax, r, view):
    """Of a rod in space with the part of twist."""
    whole = ("energy", "all" if r.in_space else "bending", BLUE, "-")
    parts = [("energy_twist", "of twist", ORANGE, "--")] if r.in_space else []
    curves("N l^2", "elastic energy" if r.in_space else "bending energy", whole, *parts)(ax, r, view)


def panel_touch(ax, r, view):
    """The last of the times asked for, and what presses on the rod."""
    if r.in_space:
        raise ResultsError(f"plot: touch: {r.name} is a rod in space; give pressure, or space")
    unit, times = view.of(r).of("length", 1.0), view.times_of(r)
    shape = r.at(times[-1] if times else r.shapes.t[-1], nearest=True)
    most, (factor, name) = strongest_contact(r, [shape]), view.of(r).unit("N")
    arrow = f"; longest arrow: {briefly(factor * most)} {name or 'per length'}" if most and not view.overlay else ""
    draw_rod(ax, r, shape.x, unit, color=view.colour(r, BLUE),
             label=f"${view.of(r).of('time', shape.t):.4g}$" + arrow)
    draw_contact(ax, r, shape, unit)
    draw_walls(ax, r, unit, t=shape.t)
    ax.plot(0, 0, "ks", ms=3, clip_on=False, zorder=3)
    axes_of_place(ax, view)


def panel_normalised(ax, r, view):
    draw_shapes(ax, r, view,
                lambda shape, **look: ax.plot(*(shape.x[:, :2].T / shape.length), **look))
    ax.set_xlabel("$x_1 / L$")
    ax.set_ylabel("$x_2 / L$")


PANELS = {
    "shapes": panel_shapes,
    "side": panel_side,
    "front": panel_front,
    "space": panel_space,
    "norm": panel_norm,
    "force": curves("N l", "force at the clamp", ("base_force_1", r"$-n_1(0)$", BLUE, "-"),
                    ("base_force_2", r"$-n_2(0)$", ORANGE, "-")),
    "energy": panel_energy,
    "power": panel_power,
    "distance": curves("l", "distance from the clamp", ("length", "$L$", GREY, "--"),
                       ("end_distance", r"$|x(1)|$", BLUE, "-"),
                       ("mid_distance", r"$|x(1/2)|$", ORANGE, "-"),
                       ("width", "width", GREEN, "-.")),
    "normalised": panel_normalised,
    "speed": curves("V", "speed", ("tip_speed", r"$|v(1)|$", BLUE, "-"),
                    ("mid_speed", r"$|v(1/2)|$", ORANGE, "-")),
    "defect": panel_defect,
    "errors": panel_errors,
    "touch": panel_touch,
    "bends": panel_bends,
    "growth": panel_growth,
    "portrait": panel_portrait,
    "curvature": along_rod(lambda r, shape: shape.curvature, r"curvature $\kappa$", "1/l"),
    "twisting": along_rod(lambda r, shape: lift(r, shape).strain[:, 0], "twist $u_1$", "1/l"),
    "pressure": along_rod(lambda r, shape: size_of(contact_force(r, shape)), "force of contact per length", "N"),
    "contact": curves("N l", "force", ("contact_force", "in contact", BLUE, "-"),
                      ("feed_force", "feeding", ORANGE, "-")),
}
FIRST = ("shapes", "norm", "force", "energy")  # what is drawn if nothing is asked for
OF_SPACE = ("space", "norm", "curvature", "twisting")  # ... of rods in space
OF_CONTACT = ("touch", "pressure", "contact")  # of all of them drawn only if there is contact
OF_SENSES = ("bends", "growth", "portrait")  # ... only of rods whose material bends itself
ONLY_IN_SPACE = ("side", "front", "space", "twisting")  # ... only of rods in space
SHAPES = ("shapes", "side", "front", "normalised", "touch", "growth")  # drawn with equal aspect
TIMED = (*SHAPES, "space", "bends", "curvature", "twisting", "pressure")  # with times for a legend
__doc__ = __doc__.format(panels=", ".join(PANELS))


# series by what they are to a reader, with their symbols
NAMES = {
    "length": r"length $L$", "tip_x1": r"tip, $x_1(1)$", "tip_x2": r"tip, $x_2(1)$",
    "norm_x2": r"deflection (root mean square), $\|x_2\|$", "norm_x2_length": "deflection over arc length",
    "max_angle": r"largest $|\theta|$", "energy": "bending energy", "growth_power": "power of growth",
    "dissipation": "power lost to friction", "energy_defect": "energy defect, relative",
    "end_distance": r"distance of the tip, $|x(1)|$", "mid_distance": r"distance of the middle, $|x(1/2)|$",
    "width": "width", "tip_speed": r"speed of the tip, $|v(1)|$",
    "mid_speed": r"speed of the middle, $|v(1/2)|$", "base_force_1": r"force at the clamp, $-n_1(0)$",
    "base_force_2": r"force at the clamp, $-n_2(0)$", "feed_force": "force of feeding",
    "tip_force_1": r"force on the tip, $x_1$", "tip_force_2": r"force on the tip, $x_2$",
    "tip_power": "power at the tip", "inflections": "inflections", "self_crossings": "crossings",
    "contact_force": "force of contact", "wall_force_1": r"force of walls, $x_1$",
    "wall_force_2": r"force of walls, $x_2$", "wall_force_3": r"force of walls, $x_3$",
    "wall_power": "power of moving walls", "friction_force_1": r"force of friction, $x_1$",
    "friction_force_2": r"force of friction, $x_2$", "friction_force_3": r"force of friction, $x_3$",
    "weight_force_1": r"weight, $x_1$", "weight_force_2": r"weight, $x_2$", "weight_force_3": r"weight, $x_3$",
    "contact_energy": "energy of contact",
    "penetration": "penetration", "contacts": "zones of contact", "step": "step",
    "newton_iterations": "Newton iterations", "model": "model",
    "error_tip": "estimated error, tip", "error_norm_x2": r"estimated error, $\|x_2\|$",
    "error_energy": "estimated error, energy",
    "tip_x3": r"tip, $x_3(1)$", "norm_x3": r"deflection out of the plane (root mean square), $\|x_3\|$", "twist": r"twist, $\int u_1$",
    "link": "link in turns", "writhe": "writhe in turns", "energy_twist": "energy of twist",
    "base_force_3": r"force at the clamp, $-n_3(0)$", "base_moment_1": r"moment at the clamp, $-m_1(0)$",
    "base_moment_2": r"moment at the clamp, $-m_2(0)$", "base_moment_3": r"moment at the clamp, $-m_3(0)$",
    "tip_force_3": r"force on the tip, $x_3$", "tip_spin": "spin of the tip",
    "clamp_power": "power of the turning clamp", "weight_power": "power of weight", "curvature_power": "power of steering",
}


def name_of(series):
    return NAMES.get(series, series.replace("_", " "))


def symbol_of(series):
    """Its symbol where it has one, for a legend of several."""
    return name_of(series).rpartition(", $")[2].rstrip("$").join("$$") if ", $" in name_of(series) \
        else name_of(series)


def panel_of(name, results):
    """A panel by its name: one of PANELS, or series of the files, joined by +."""
    if name in PANELS:
        return PANELS[name]
    series = name.split("+")
    for one in series:
        if not any(one in r.series for r in results):
            near = did_you_mean(one, [*PANELS, *results[0].series])
            raise ResultsError(f"panel {one}: unknown" + (near or f", give some of {', '.join(PANELS)}, or of the series "
                                                          f"{', '.join(results[0].series)}"))
    units = {r.units.get(f"series/{one}", "1") for r in results for one in series
             if one in r.series}
    if len(units) > 1:
        raise ResultsError(f"panel {name}: has no one unit, {' and '.join(sorted(units))}; give them "
                           "as panels of their own")
    label = name_of(series[0]) if len(series) == 1 else shared_name(series)
    return curves(units.pop(), label, *((one, symbol_of(one), COLOURS[i % len(COLOURS)], STYLES[i // len(COLOURS)])
                                        for i, one in enumerate(series)))


def shared_name(series):
    """What several series are, for their common axis."""
    kinds = {"l": "length", "N l": "force", "N l^2": "energy", "N l V": "power", "V": "speed"}
    unit = next((unit for unit, names in BY_UNIT.items() if series[0] in names), "")
    first = name_of(series[0]).split(",")[0]
    same = all(name_of(one).split(",")[0] == first for one in series)
    return first if same else kinds.get(unit, "value")


BY_UNIT = {
    "l": ("length", "tip_x1", "tip_x2", "tip_x3", "norm_x2", "norm_x3", "end_distance", "mid_distance", "width", "penetration"),
    "N l": ("base_force_1", "base_force_2", "feed_force", "tip_force_1", "tip_force_2", "contact_force",
            "wall_force_1", "wall_force_2", "friction_force_1", "friction_force_2"),
    "N l^2": ("energy", "contact_energy"), "N l V": ("growth_power", "dissipation", "tip_power", "curvature_power"),
    "V": ("tip_speed", "mid_speed"),
}


def grid(view, names):
    """Rows of (panel, results drawn in it): a file a column; in an overlay, and of a single file,
    panels go in two columns."""
    if len(view.results) > 1 and not view.overlay:
        return [[(name, [r]) for r in view.results] for name in names]
    cells = [(name, view.results) for name in names]
    return [cells[i : i + 2] for i in range(0, len(cells), 2)]


def share_limits(row):
    drawn = [ax for ax in row if ax.has_data()] or row
    x = np.array([ax.get_xlim() for ax in drawn])
    y = np.array([ax.get_ylim() for ax in drawn])
    for ax in row:
        ax.set(xlim=(x.min(), x.max()), ylim=(y.min(), y.max()))


def aspect_of(ax):
    return float(np.ptp(ax.get_ylim()) / np.ptp(ax.get_xlim()))


def set_aspect(ax, aspect):
    """Equal aspect: widens the limits about their centre until height over width is aspect."""
    (x0, x1), (y0, y1) = ax.get_xlim(), ax.get_ylim()
    width = max(x1 - x0, (y1 - y0) / aspect)
    height = width * aspect
    ax.set(xlim=((x0 + x1 - width) / 2, (x0 + x1 + width) / 2),
           ylim=((y0 + y1 - height) / 2, (y0 + y1 + height) / 2))


def legend_entries(ax, view, name):
    """(handles, labels) of a panel. Of shapes they are times, behind the name of the axis; in an
    overlay lines have the colour of their run, so the legend shows their style alone."""
    handles, labels = ax.get_legend_handles_labels()
    first = {}
    for handle, label in zip(handles, labels):
        first.setdefault(label, handle)
    if view.overlay:
        first = {label: Line2D([], [], color="black", linestyle=handle.get_linestyle())
                 for label, handle in first.items()}
        if len(first) == 1:
            return [], []
    if name in TIMED and first:
        unit = view.units.scales["time"][1]
        head, plain = f"$t$ in {unit}:" if unit else "$t =$", Line2D([], [], lw=0)
        if len(first) == 1 or name == "growth":  # which has no colours of times
            return [plain], [f"{head} {', '.join(first)}"]
        first = {head: plain} | first
    return list(first.values()), list(first)


def legend(ax, view, name):
    """Above the axes, where it covers no curve."""
    handles, labels = legend_entries(ax, view, name)
    if len(handles) > 1 or handles and name in TIMED:
        short = name in TIMED  # many entries, in an overlay of lines with a style
        head(ax).legend(handles, labels, loc="lower left", bbox_to_anchor=(0.1, 0.99), ncol=len(handles),
                  handlelength=2.0 if view.overlay else 1.1 if short else 1.6,
                  columnspacing=(0.5 if view.overlay else 0.8) if short else 1.2,
                  handletextpad=0.3 if short else 0.5)


def mend_legends(figure):
    """A legend wider than its panel goes into it, where it covers least."""
    renderer = RendererAgg(*figure.bbox.size, figure.dpi)
    for ax in map(head, figure.axes):
        old = ax.get_legend()
        if old and old.get_window_extent(renderer).x1 > ax.bbox.x1 + 1:
            texts = [text.get_text() for text in old.get_texts()]
            ax.legend(old.legend_handles, texts, loc="best", handlelength=1.4, fontsize=7, ncol=-(-len(texts) // 8))


def limit_row(view, row, cells):
    """Sets the limits of a row of panels; of each its height over its width."""
    if cells[0][0] == "space" and len(view.results) > 1 and not view.overlay:
        return [max(map(seen_aspect, row))] * len(row)
    for ax, (name, _) in zip(row, cells):
        if name != "space":
            ax.margins(x=0.02)
    shared = len(view.results) > 1 and not view.overlay
    if shared:
        share_limits(row)
        for ax in row[1:]:
            ax.set_ylabel("")
            ax.tick_params(labelleft=False)
    equal = [ax for ax, (name, _) in zip(row, cells) if name in SHAPES]
    aspects = {ax: float(np.clip(max(map(aspect_of, equal if shared else [ax])), 0.36, 1.3)) for ax in equal}
    for ax, aspect in aspects.items():
        set_aspect(ax, aspect)
    return [seen_aspect(ax) if name == "space" else aspects.get(ax) for ax, (name, _) in zip(row, cells)]


FLAT, HIGH = 0.66, 0.8  # height over width of a panel of curves; the most of it, beside one that is high
SHARES = 0.42, 0.58  # of a row's width, that one of two panels may have


def split(aspects, width):
    """(widths, heights) of the panels of a row that has so much width: those of a given height over width are as high as each
    other, as far as none gets too narrow; curves (None) are as high as they are."""
    if len(aspects) == 2 and any(aspects):
        a, b = (aspect or FLAT for aspect in aspects)
        share = float(np.clip(b / (a + b), *SHARES))
        widths = [share * width, (1 - share) * width]
    else:
        widths = [width / len(aspects)] * len(aspects)
    most = max((w * a for w, a in zip(widths, aspects) if a), default=0.0)
    return widths, [w * a if a else float(np.clip(most, FLAT * w, HIGH * w)) for w, a in zip(widths, aspects)]


WIDTHS = {1: 3.4, 2: 2.7, 3: 2.1}  # of a panel, by the number of columns, in inches
BELOW, ABOVE, LEFT, RIGHT = 0.44, 0.26, 0.66, 0.1  # room for labels around a panel, in inches


def place(figure, axes, aspects, shared, headed):
    """Puts the panels where they belong: in whatever units their labels are, the tops of a row in line; columns of several runs are
    of the same width, and with shared labels they move together.

    aspects  a row a list, height over width of its panels; None: of curves, which have none of their own"""
    columns = axes.shape[1]
    panel, gap = WIDTHS.get(columns, 1.8), (0.12 if shared else LEFT + RIGHT)
    width = width_of(columns, shared)
    sizes = [([panel] * len(row), [panel * (aspect or FLAT) for aspect in row]) if shared or len(row) < columns else split(row, columns * panel)
             for row in aspects]
    height = sum(max(heights) + BELOW + ABOVE for _, heights in sizes) + headed
    figure.set_size_inches(width, height)
    top = height - headed
    for row, (widths, heights) in zip(axes, sizes):
        top -= ABOVE
        left = LEFT
        for ax, wide, high in zip(row, widths, heights):
            cell = np.array([left / width, (top - high) / height, wide / width, high / height])
            if ax.name == "3d":
                fit_seen(ax, cell)
            else:
                ax.set_position(cell)
            left += wide + gap
        top -= max(heights) + BELOW


def name_runs(figure, view, width):
    """The runs of an overlay, at the head of the figure, as many in a row as have room; the height they
    take."""
    if len(view.results) > NAMED:
        return 0.1
    renderer = RendererAgg(10, 10, figure.dpi)
    handles = [Line2D([], [], color=view.colour(r, "black")) for r in view.results]
    texts = [figure.text(0, 0, title, fontsize=STYLE["legend.fontsize"]) for title in view.titles]
    longest = max(text.get_window_extent(renderer).width for text in texts) / figure.dpi
    for text in texts:
        text.remove()
    rows = -(-len(handles) // max(1, min(len(handles), int((width - 0.2) / (longest + 0.42)))))
    figure.legend(handles, view.titles, loc="upper left", ncol=-(-len(handles) // rows),
                  bbox_to_anchor=(0.02, 1))
    return 0.16 * rows + 0.1


def width_of(columns, shared):
    """Of a figure, in inches."""
    return LEFT + columns * WIDTHS.get(columns, 1.8) + (columns - 1) * (0.12 if shared else LEFT + RIGHT) + RIGHT


def draw_into(ax, name, view):
    """One panel in somebody's axes."""
    panel = panel_of(name, view.results)
    ax.set_xlabel(view.units.label("time $t$", "time"))
    for r in view.results:
        panel(ax, r, view)
    if name in SHAPES:
        ax.set_aspect("equal", adjustable="datalim")
    handles, labels = ax.get_legend_handles_labels()
    if len(handles) > 1:
        ax.legend()


def axes_of(figure, cells, columns):
    """[rows, columns], those of the panel space with three dimensions."""
    axes = np.empty((len(cells), columns), object)
    for i, row in enumerate(cells):
        for j in range(columns):
            solid = j < len(row) and row[j][0] == "space"
            place = len(cells), columns, i * columns + j + 1
            axes[i, j] = figure.add_subplot(*place, projection="3d" if solid else None)
            if solid:
                axes[i, j].head = figure.add_artist(Axes(figure, (0, 0, 1, 1)))  # (none of the figure's axes, for who goes through them)
                axes[i, j].head.set_axis_off()
    return axes


def draw(names, view):
    """The figure of the named panels."""
    panels = {name: panel_of(name, view.results) for name in names}
    cells = grid(view, names)
    columns = len(cells[0])
    figure = plt.figure(FigureClass=InStyle)
    axes = axes_of(figure, cells, columns)
    aspects, letters = [], iter(ascii_lowercase)
    shared = len(view.results) > 1 and not view.overlay
    for row, row_cells in zip(axes, cells):
        for ax in row[len(row_cells) :]:
            ax.set_axis_off()
        row = row[: len(row_cells)]
        for ax, (name, runs) in zip(row, row_cells):
            ax.set_xlabel(view.units.label("time $t$", "time"))
            for r in runs:
                panels[name](ax, r, view)
        aspects.append(limit_row(view, row, row_cells))
        for k, (ax, (name, _)) in enumerate(zip(row, row_cells)):
            times = [[f"{view.second(r) * t:.4g}" for r in one for t in view.times_of(r)] if name in TIMED else None
                     for _, one in row_cells]
            if not shared or k == 0 or any(t != times[0] for t in times):
                legend(ax, view, name)
            if not shared or k == 0:
                head(ax).set_title(f"({next(letters)})", loc="left")
    headed = 0.0
    if view.overlay:
        headed = name_runs(figure, view, width_of(columns, shared))
    elif shared:
        heads = [head(ax) for ax in axes[0]]
        over = any(ax.get_legend() for ax in heads)  # a legend, which the titles stand above
        for ax, title in zip(heads, view.titles):
            ax.set_title(title, pad=18 if over else 6)
        headed = 0.2 * over
    place(figure, axes, aspects, shared, headed)
    mend_legends(figure)
    settle(figure)
    plt.close(figure)  # it is returned, and not pyplot's to show
    return figure


def bare(word):
    """Whether a time has no unit."""
    return not str(word).strip()[-1:].isalpha()


def check_times(view):
    """A time beyond the end of all runs, or a run that has none of them, would be an empty panel; one without a unit is
    not the same of runs that count it in units of their own."""
    for r in view.results:
        if not len(r.series.get("t", ())) or not len(r.shapes.get("t", ())):
            raise ResultsError(f"{r.told}: holds no stored shape to draw")
    if view.times is None:
        return
    latest = max(view.results, key=lambda r: r.shapes.t[-1] * view.second(r))
    units = view.of(latest)
    seconds = scale_of([latest], "time")
    if len({scale_of([r], "time") for r in view.results}) > 1 and (word := next(filter(bare, view.times), None)) is not None \
            and units.scales["time"][1]:
        raise ResultsError(f"times {word}: these runs count it each in a unit of its own; give it with one, {word}s")

    def told(t):
        return units.plain(t)[4:] + (f" ({t * seconds:.4g} s)" if seconds and not units.scales["time"][1] else "")

    def meant(t, word):
        """Who thinks in seconds may have left them out."""
        if not bare(word) or not seconds or not 0 <= t <= latest.shapes.t[-1] * seconds:
            return ""
        return f" (a time without a unit is dimensionless; give {t:.6g}s if seconds are meant)"

    for word in view.times:
        t = moment("times", word, [latest])
        if t < 0 or t > latest.shapes.t[-1] * (1 + 1e-9):
            raise ResultsError(f"{latest.told}: ends at t = {told(latest.shapes.t[-1])}; no shape at "
                               f"{told(t)}{meant(t, word)}")
    for r in view.results:
        if not view.times_of(r):
            raise ResultsError(f"{r.told}: ends at {view.of(r).plain(r.shapes.t[-1])}, before the "
                               "first of the times asked for")


def panels_of(asked, runs):
    """Names of panels: those asked for, or those that a first look wants, or all."""
    if asked == "all" or list(asked or ()) == ["all"]:
        touch = any("contact" in r.shapes for r in runs)
        return [name for name in PANELS
                if (touch or name not in OF_CONTACT)
                and (name not in OF_SENSES or all("tropism_power" in r.series for r in runs))
                and (name not in ONLY_IN_SPACE or all(r.in_space for r in runs))
                and (name != "touch" or not any(r.in_space for r in runs))]
    first = OF_SPACE if all(r.in_space for r in runs) else FIRST
    return [name.strip() for name in asked.split(",")] if isinstance(asked, str) else list(asked or first)


def of_one_file(runs) -> bool:
    """Whether these are rods of one run, which are seen together."""
    return len({r.path for r in runs}) == 1 and all(isinstance(r, Rod) for r in runs)


@arguments(panels="texts?", times="times?", si="flag?", overlay="flag", titles="texts?")
def plot(results: Results | Sequence[Results], panels: Sequence[str] | str | None = None, *,
         times: Sequence[float | str] | None = None, si: bool | None = None, overlay: bool = False,
         titles: Sequence[str] | None = None, beside: Sequence[Results] = (),
         view: tuple[float, float] | str | None = None,
         ax: Axes | None = None) -> Figure:
    """Draws one run or several, one column each; the figure, which savefig saves. What critical() has
    found, and the result of -task stability, are drawn as that.

    results  Results, names of files, a sweep, or several of them
    panels   names of PANELS or of series, "width", or several in one panel, "width+end_distance"; "all";
             None: shapes, deflection, force and energy; of rods in space the rod in perspective, deflection,
             curvature and twist along it
    times    of the shapes drawn, dimensionless or with a unit, "20s"; None: quarters of each run
    si       in units of the laboratory that suit the runs, each by its own scales; None: where the files have them;
             False: dimensionless, each run in its own unit of length
    overlay  all runs in every panel, instead of a column each
    titles   of the runs; None: the names of their files
    beside   runs drawn dashed beside these in the panel norm, one for each
    view     from where the panel space is seen, two angles in degrees: about the axis that points up, from the
             front, and above the horizon
    ax       axes of matplotlib for one panel, in place of a figure of its own"""
    runs = runs_of(results, "plot")
    if not any(r.series for r in runs):
        return plot_stability.figure_of(runs, ax=ax)
    names = panels_of(panels, runs)
    if titles and len(titles) != len(runs):
        raise ResultsError(f"plot: {len(titles)} titles for {len(runs)} runs")
    beside = runs_of(beside, "plot: beside") if not isinstance(beside, (list, tuple)) or len(beside) else []
    drawn = View(runs, Units(in_laboratory_of([*runs, *beside], si)), overlay=(overlay or ax is not None or of_one_file(runs)) and len(runs) > 1,
                 titles=titles_of(runs, titles),
                 beside={r.path: other for r, other in zip(runs, beside)}, view=sight(view))
    if times is not None:
        drawn.times = [times] if isinstance(times, str) or np.ndim(times) == 0 else list(times)
    check_times(drawn)
    with plt.rc_context(STYLE):
        if ax is None:
            return draw(names, drawn)
        if len(names) != 1:
            raise ResultsError(f"plot: ax holds one panel; give its name, {', '.join(FIRST)} or another")
        draw_into(ax, names[0], drawn)
        return ax.figure


def read(path):
    r = load(path)
    if not r.finished and r.series:
        end = r.series.t[-1] if len(r.series.t) else 0
        print(f"plot: {path}: the run has not reached its end, drawn up to t = {end:.4g}")
    return r


def tell_missing(results, times, si):
    whole = Units(in_laboratory_of(results, si))
    if (word := next(filter(bare, times), None)) is not None and whole.scales["time"][1]:
        print(f"plot: times without a unit are dimensionless: {word} is {whole.plain(float(word))[4:]}")
    for r in results:
        units = whole.at(r)
        for t in (moment("times", word, [r]) for word in times):
            drawn = shape_of(r, min(t, r.shapes.t[-1]))
            stored, asked = units.plain(drawn.t), units.plain(t, "g")
            if t > r.shapes.t[-1] * (1 + 1e-9):
                print(f"plot: {r.told}: ends at {stored}, before {asked[4:]}")
            elif abs(drawn.t - t) > 1e-6 * max(t, 1):
                print(f"plot: {r.told}: no shape stored at {asked}, drawn at {stored[4:]}")


def options(arguments):
    parser = Parser("scripts/plot.sh", __doc__)
    parser.add_argument("files", nargs="+", metavar="FILE", help="result files, HDF5")
    parser.add_argument("--output", metavar="BASENAME",
                        help="writes BASENAME.png and .pdf, or the one that it ends with (also .svg); default: "
                        "the first file's name")
    parser.add_argument("--panels", metavar="A,B+C,...",
                        help=f"comma list, in this order; default: {','.join(FIRST)}, in space {','.join(OF_SPACE)}")
    parser.add_argument("--times", metavar="T1,T2,...",
                        help="of the shapes drawn; of a run with -si_ options also 20s or 2min; "
                        "default: quarters of each run")
    parser.add_argument("--overlay", action="store_true",
                        help="all files in every panel, instead of a column each")
    add_choice_of_units(parser)
    parser.add_argument("--beside", metavar="FILE,...", default="",
                        help="runs drawn dashed beside these in the panel norm, one for each")
    parser.add_argument("--titles", metavar="A,B,...", help="of the files; default: their names")
    parser.add_argument("--view", metavar="TURN,RISE", help="of the panel space: degrees about the axis that points "
                        f"up, from the front, and above the horizon; default: {VIEW[0]:g},{VIEW[1]:g}")
    return parser.parse_intermixed_args(arguments)


def main(arguments=None):
    matplotlib.use("Agg")
    choice = options(arguments)
    output = choice.output or str(Path(choice.files[0]).with_suffix(""))
    results = [read(path) for path in choice.files]
    if not any(r.series for r in results):
        return plot_stability.main([*choice.files, "--output", output])
    times = choice.times.split(",") if choice.times else None
    figure = plot(results, choice.panels, times=times, si=choice.si, overlay=choice.overlay,
                  titles=choice.titles.split(",") if choice.titles else None,
                  beside=[read(path) for path in choice.beside.split(",") if path], view=choice.view)
    tell_missing(runs_of(results, "plot"), times or (), choice.si)
    print(f"plot: {save(figure, output, None)}")
    return 0

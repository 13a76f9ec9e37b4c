"""Draws result files of tendril, one column a file, as PNG and PDF.

    scripts/plot.sh results/uniform-dry.h5
    scripts/plot.sh results/uniform-*.h5 --panels norm,shapes --times 10,20,30 --output compare
    scripts/plot.sh mytube.h5 --si --times 20s,1min

Symbols are those of the README; all is dimensionless, or with --si in the units of the laboratory."""

import argparse
import sys
from pathlib import Path
from string import ascii_lowercase

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

from . import plot_stability
from .results import ResultsError, load
from .style import BLUE, GREEN, GREY, ORANGE, RED, STYLE
from .units import Units, moment
from .walls import draw_contact, draw_rod, draw_walls


def legend(ax, columns, whole_row):
    """Above the axes, where it covers no curve; whole_row: it may run on over those beside."""
    handles, labels = ax.get_legend_handles_labels()
    if handles:
        made = ax.legend(handles, labels, loc="lower left", bbox_to_anchor=(0.11, 1.0),
                         ncol=len(handles) if whole_row else columns)
        made.set_in_layout(not whole_row)


def power_of_ten(value):
    mantissa, exponent = f"{value:.1e}".split("e")
    return rf"{mantissa} \times 10^{{{int(exponent)}}}"


# Each panel draws one result into one axes. view holds what the command line chose.


def panel_norm(ax, r, view):
    t, norm = r.series.t, np.ma.masked_less_equal(r.series.norm_x2, 0)
    ax.set_yscale("log")
    ax.set_ylabel(view.units.label(r"$\|x_2\| = (\int_0^1 x_2^2\, ds)^{1/2}$", "length"))
    if not norm.count():
        ax.text(0.5, 0.5, r"$x_2 = 0$ throughout", transform=ax.transAxes, ha="center")
        return
    norm = view.units.of("length", norm)
    ax.plot(view.units.of("time", t), norm, color=BLUE)
    if r.path in view.beside:
        r = view.beside[r.path]
        t, norm = r.series.t, view.units.of("length", np.ma.masked_less_equal(r.series.norm_x2, 0))
        ax.plot(view.units.of("time", t), norm, "--", color=GREY)
    at, least = r.minimum("norm_x2")
    least = view.units.of("length", least)
    ax.plot(view.units.of("time", at), least, "o", ms=4, color=RED)
    ax.annotate(rf"${power_of_ten(least)}$ at {view.units.time(at)}",
                (view.units.of("time", at), least), xytext=(5, -4),
                textcoords="offset points", va="top", color=RED)
    ax.margins(y=0.25)


def curves(ax, r, view, kind, *lines):
    """lines: (series, label, colour, style); a series the file lacks is left out."""
    for name, label, colour, style in lines:
        if name in r.series:
            ax.plot(view.units.of("time", r.series.t), view.units.of(kind, r.series[name]), style,
                    color=colour, label=label)


def panel_energy(ax, r, view):
    curves(ax, r, view, "energy", ("energy", r"$E$", BLUE, "-"))
    curves(ax, r, view, "power", ("growth_power", r"$W$", ORANGE, "-"),
           ("dissipation", "Diss", "black", ":"))
    units = [view.units.scales[kind][1] for kind in ("energy", "power")]
    ax.set_ylabel(f"energy ({units[0]}), power ({units[1]})" if units[0] else "energy, power")


def panel_defect(ax, r, view):
    defect = np.ma.masked_equal(np.abs(r.series.energy_defect), 0)
    ax.set_yscale("log")
    if defect.count():
        ax.plot(view.units.of("time", r.series.t), defect, color=BLUE, lw=0.8)
    ax.set_ylabel("energy defect, relative")


def panel_distance(ax, r, view):
    curves(ax, r, view, "length", ("length", r"$L$", GREY, "--"),
           ("end_distance", r"$|x(1)|$", BLUE, "-"), ("mid_distance", r"$|x(1/2)|$", ORANGE, "-"),
           ("width", "width", GREEN, "-."))
    ax.set_ylabel(view.units.label("distance from the clamp", "length"))


def panel_speed(ax, r, view):
    curves(ax, r, view, "speed", ("tip_speed", r"$|v(1)|$", BLUE, "-"),
           ("mid_speed", r"$|v(1/2)|$", ORANGE, "-"))
    ax.set_ylabel(view.units.label("speed", "speed"))


def panel_force(ax, r, view):
    curves(ax, r, view, "force", ("base_force_1", r"$-n_1(0)$", BLUE, "-"),
           ("base_force_2", r"$-n_2(0)$", ORANGE, "-"))
    ax.set_ylabel(view.units.label("force at the clamp", "force"))


def shapes_of(r, view):
    """(label, colour, shape) of the times asked for, as far as the run has come."""
    colours = plt.get_cmap("viridis")(np.linspace(0, 0.88, len(view.times)))
    for t, colour in zip(view.times, colours):
        if t <= r.shapes.t[-1] * (1 + 1e-9):
            shape = r.at(t)
            yield view.units.time(shape.t), colour, shape


def panel_shapes(ax, r, view):
    unit = view.units.of("length", 1.0)
    for label, colour, shape in shapes_of(r, view):
        draw_rod(ax, r, shape.x, unit, color=colour, label=label)
    draw_walls(ax, r, unit)
    ax.plot(0, 0, "ks", ms=3, clip_on=False, zorder=3)
    ax.set_xlabel(view.units.label("$x_1$", "length"))
    ax.set_ylabel(view.units.label("$x_2$", "length"))


def panel_touch(ax, r, view):
    """The last of the times asked for, and what presses on the rod."""
    unit = view.units.of("length", 1.0)
    for label, _, shape in list(shapes_of(r, view))[-1:]:
        draw_rod(ax, r, shape.x, unit, color=BLUE, label=label)
        draw_contact(ax, r, shape, unit)
    draw_walls(ax, r, unit)
    ax.plot(0, 0, "ks", ms=3, clip_on=False, zorder=3)
    ax.set_xlabel(view.units.label("$x_1$", "length"))
    ax.set_ylabel(view.units.label("$x_2$", "length"))


def panel_contact(ax, r, view):
    curves(ax, r, view, "force", ("contact_force", "in contact", BLUE, "-"),
           ("feed_force", "feeding", ORANGE, "-"))
    ax.set_ylabel(view.units.label("force", "force"))


def panel_normalised(ax, r, view):
    for label, colour, shape in shapes_of(r, view):
        ax.plot(*(shape.x.T / shape.length), color=colour, label=label)
    ax.plot(0, 0, "ks", ms=3, clip_on=False, zorder=3)
    ax.set_xlabel("$x_1 / L$")
    ax.set_ylabel("$x_2 / L$")


PANELS = {
    "norm": panel_norm, "energy": panel_energy, "shapes": panel_shapes,
    "normalised": panel_normalised, "distance": panel_distance, "speed": panel_speed,
    "force": panel_force, "defect": panel_defect, "touch": panel_touch, "contact": panel_contact,
}
OF_CONTACT = ("touch", "contact")  # drawn if asked for, or if there is contact
EQUAL = ("shapes", "normalised", "touch")  # drawn with equal aspect


def grid(results, names):
    """Rows of (panel, result): a file a column; the panels of a single file go in two columns."""
    if len(results) > 1:
        return [[(name, r) for r in results] for name in names]
    cells = [(name, results[0]) for name in names]
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
    ax.set_aspect("equal", adjustable="box")


def size_rows(figure, axes, aspects, width):
    """Sets the height of the figure so that every row has its height over width."""
    figure.get_layout_engine().set(hspace=0.04, wspace=0.03)
    axes[0, 0].get_gridspec().set_height_ratios(aspects)
    height = sum(aspects) * width / axes.shape[1] + 0.6 * len(aspects)
    for _ in range(3):  # the layout tells how much room labels and titles take
        figure.set_size_inches(width, height)
        figure.draw_without_rendering()
        boxes = [ax.get_position(original=True) for ax in axes[:, 0]]
        labels = height * (1 - sum(box.height for box in boxes))
        height = labels + sum(aspects) * width * boxes[0].width
    figure.set_size_inches(width, height)


def draw(results, names, view):
    """The figure of the named panels."""
    cells = grid(results, names)
    columns = len(cells[0])
    width = {1: 4.0, 2: 3.5, 3: 2.7}.get(columns, 2.3)  # of one column, in inches
    figure = plt.figure(layout="constrained")
    axes = figure.subplots(len(cells), columns, squeeze=False)
    aspects, letters = [], iter(ascii_lowercase)
    for row, row_cells in zip(axes, cells):
        for ax in row[len(row_cells) :]:
            ax.set_axis_off()
        row = row[: len(row_cells)]
        for ax, (name, r) in zip(row, row_cells):
            ax.set_xlabel(view.units.label("time $t$", "time"))
            PANELS[name](ax, r, view)
            ax.margins(x=0.02)
        if len(results) > 1:
            share_limits(row)
            for ax in row[1:]:
                ax.set_ylabel("")
                ax.tick_params(labelleft=False)
        equal = [ax for ax, (name, _) in zip(row, row_cells) if name in EQUAL]
        aspects.append(np.clip(max(map(aspect_of, equal), default=0.68), 0.36, 1.3))
        for ax in equal:
            set_aspect(ax, aspects[-1])
        for ax in row[:1] if len(results) > 1 else row:
            legend(ax, 4, len(results) > 1)
            ax.set_title(f"({next(letters)})", loc="left")
    if len(results) > 1:
        for ax, r, title in zip(axes[0], results, view.titles):
            ax.set_title(title, pad=18 if axes[0, 0].get_legend() else 6)
    size_rows(figure, axes, aspects, columns * width)
    return figure


def default_times(results):
    """The stored times nearest to the quarters of the longest run."""
    longest = max(results, key=lambda r: r.shapes.t[-1])
    return sorted({longest.at(longest.shapes.t[-1] * k / 4).t for k in (1, 2, 3, 4)})


def read(path):
    r = load(path)
    if not r.finished and r.series:
        end = r.series.t[-1] if len(r.series.t) else 0
        print(f"plot: {path}: the run has not reached its end, drawn up to t = {end:.4g}")
    return r


def tell_missing(results, times, units):
    for r in results:
        for t in times:
            stored, asked = units.plain(r.at(t).t), units.plain(t, "g")
            if t > r.shapes.t[-1] * (1 + 1e-9):
                print(f"plot: {r.path}: ends at {stored}, before {asked[4:]}")
            elif abs(r.at(t).t - t) > 1e-6 * max(t, 1):
                print(f"plot: {r.path}: no shape stored at {asked}, drawn at {stored[4:]}")


def draw_stability(paths, output):
    """Files of -task stability and -task critical have a module of their own."""
    return plot_stability.main([*paths, "--output", output])


def main(arguments=None):
    parser = argparse.ArgumentParser(prog="scripts/plot.sh", description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("files", nargs="+", metavar="FILE", help="result files, HDF5")
    parser.add_argument("--output", metavar="BASENAME",
                        help="writes BASENAME.png and .pdf; default: the first file's name")
    parser.add_argument("--panels", metavar="A,B,...",
                        help=f"comma list, in this order, of {', '.join(PANELS)}; default: all, "
                        f"{' and '.join(OF_CONTACT)} where there is contact")
    parser.add_argument("--times", metavar="T1,T2,...",
                        help="of the shapes drawn; of a run with -si_ options also 20s or 2min; "
                        "default: quarters of the longest run")
    parser.add_argument("--si", action="store_true",
                        help="in centimetres, newtons, seconds and the like: for runs with -si_ options")
    parser.add_argument("--beside", metavar="FILE,...", default="",
                        help="runs drawn dashed beside these in the panel norm, one for each")
    parser.add_argument("--titles", metavar="A,B,...", help="above columns; default: file names")
    view = parser.parse_args(arguments)
    names = view.panels.split(",") if view.panels else list(PANELS)
    unknown = [name for name in names if name not in PANELS]
    if unknown:
        parser.error(f"--panels {unknown[0]}: unknown, give some of {', '.join(PANELS)}")
    output = view.output or str(Path(view.files[0]).with_suffix(""))
    try:
        results = [read(path) for path in view.files]
        if not any(r.series for r in results):
            return draw_stability(view.files, output)
        for r in results:
            if not len(r.series.get("t", ())) or not len(r.shapes.get("t", ())):
                raise ResultsError(f"{r.path}: holds no stored shape to draw")
        if not view.panels and not any("contact" in r.shapes for r in results):
            names = [name for name in names if name not in OF_CONTACT]
        others = [read(path) for path in view.beside.split(",") if path]
        view.beside = {r.path: other for r, other in zip(results, others)}
        view.units = Units(results if view.si else ())
        view.times = ([moment("--times", word, results) for word in view.times.split(",")]
                      if view.times else default_times(results))
        tell_missing(results, view.times, view.units)
        view.titles = view.titles.split(",") if view.titles else [r.name for r in results]
        with plt.rc_context(STYLE):
            figure = draw(results, names, view)
            for ending in ("png", "pdf"):
                figure.savefig(f"{output}.{ending}")
    except (ResultsError, OSError) as error:
        print(f"plot: {error}", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())

"""Makes a film of the growth from a result file: the rod coloured by its axial force, with arrows
for the friction that acts on it, and for what presses on it.

    scripts/animate.sh results/uniform-dry.h5 [--output film.gif] [--from T --to T] [--frames N]
    scripts/animate.sh helix.h5 --turn 90 --field twist       # of a rod in space: the view turns, any field

The ending of --output decides: .gif, or .mp4 where ffmpeg is installed."""

from __future__ import annotations

import errno
import os
from pathlib import Path

import matplotlib
import matplotlib.pyplot as plt
import numpy as np
from matplotlib.animation import FFMpegWriter, PillowWriter
from matplotlib.colors import AsinhNorm

from .command import Parser
from .errors import ResultsError, arguments, replacing
from .film_space import FilmInSpace
from .loading import load, runs_of
from .results import Results
from .spatial import FIELDS
from .style import STYLE
from .progress import bar
from .surroundings import axial_force, friction
from .style import InStyle
from .units import Units, add_choice_of_units, briefly, in_laboratory_of, moment
from .walls import (RIM, ThickLine, ThickSegments, draw_contact, draw_walls, strongest_contact, walls_of)

ARROWS = 28


class Film:
    """A figure that shows one shape after the other; on the whole film its axes stay as they are."""

    def __init__(self, r, shapes, units):
        self.r, self.shapes, self.units = r, shapes, units
        self.pressed = None
        unit = units.of("length", 1.0)
        strongest = units.of("force", max(np.abs(axial_force(s)).max() for s in shapes) or 1)
        drag = max(np.percentile(np.hypot(*friction(r, s, ARROWS)[1].T), 95) for s in shapes) or 1
        low = units.of("length", np.min([s.x.min(axis=0) for s in shapes], axis=0))
        high = units.of("length", np.max([s.x.max(axis=0) for s in shapes], axis=0))
        room = 0.06 * (high - low).max()
        low, high = low - room, high + room
        if high[1] - low[1] < 0.4 * (high[0] - low[0]):
            middle, half = (low[1] + high[1]) / 2, 0.2 * (high[0] - low[0])
            low[1], high[1] = middle - half, middle + half
        aspect = (high[1] - low[1]) / (high[0] - low[0])
        self.figure = plt.figure(figsize=(6, min(5.2 * aspect + 0.7, 8)), layout="constrained",
                                 FigureClass=InStyle)
        plt.close(self.figure)
        ax = self.figure.subplots()
        ax.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]),
               xlabel=units.label("$x_1$", "length"), ylabel=units.label("$x_2$", "length"))
        ax.set_aspect("equal")
        ax.update_datalim([low, high])
        self.scenery = draw_walls(ax, r, unit, room=False)
        self.ax = ax
        self.most = strongest_contact(r, shapes)
        self.outline = ThickLine([], [], color="#333333", solid_capstyle="round")
        ax.add_line(self.outline)
        self.rod = ThickSegments([], cmap="coolwarm_r", capstyle="round", zorder=3,
                                 norm=AsinhNorm(strongest / 20, -strongest, strongest))
        ax.add_collection(self.rod)
        # as thick as the rod is, and not thinner than can be seen
        for line, least, rim in ((self.outline, 3.2, 0), (self.rod, 2.2, RIM)):
            line.width, line.least, line.rim = unit * r.diameter, least, rim
        ax.plot(0, 0, "ks", ms=4, zorder=4)
        nothing = np.zeros(ARROWS)
        # the strongest friction is drawn as long as a twelfth of the picture's width
        self.arrows = ax.quiver(nothing, nothing, nothing, nothing, angles="xy", scale_units="xy",
                                scale=12 * drag / (high[0] - low[0]), width=0.0022,
                                color="#555555", zorder=1)
        steps = [a * 10.0**e for e in range(-3, 5) for a in (1, 3)]
        steps = [v for v in steps if strongest / 15 < v <= strongest]
        self.figure.colorbar(self.rod, ax=ax, shrink=0.9, pad=0.01, format="%g",
                             ticks=[-v for v in steps] + [0] + steps,
                             label=units.label(r"axial force $n \cdot q$", "force")
                             + " (compression < 0)")
        factor, name = units.unit("N")
        ax.quiverkey(self.arrows, 0.9, 0.96, drag, f"friction {briefly(factor * drag)} {name}".rstrip(), labelpos="W",
                     labelcolor="#555555", fontproperties={"size": 7}, labelsep=0.05).set_zorder(6)
        self.extent = (high - low).max()
        if self.most:
            ax.set_title(f"longest arrow: contact {briefly(factor * self.most)} {name or 'per length'}", loc="right",
                         color="#D55E00", fontsize=7)
        self.title = ax.set_title("", loc="left", fontfamily="monospace", fontsize=8)

    def show(self, k):
        shape = self.shapes[k]
        force, nodes = self.units.of("force", axial_force(shape)), self.units.of("length", shape.x)
        if self.scenery:
            self.scenery.walls = walls_of(self.r, shape.t)
        self.outline.set_data(*nodes.T)
        self.rod.set_segments(np.stack([nodes[:-1], nodes[1:]], axis=1))
        self.rod.set_array((force[:-1] + force[1:]) / 2)
        if self.pressed:
            self.pressed.remove()
        self.pressed = draw_contact(self.ax, self.r, shape, self.units.of("length", 1.0),
                                    self.most, self.extent)
        x, drag = friction(self.r, shape, ARROWS)
        self.arrows.set_offsets(self.units.of("length", x))
        self.arrows.set_UVC(*drag.T)
        length, unit = self.units.of("length", shape.length), self.units.scales["length"][1]
        self.title.set_text(f"{self.units.plain(shape.t, '6.2f')}   "
                            f"length {length:6.2f} {unit}".rstrip())


def writer_of(output, rate):
    """What writes a film of this name."""
    if output.suffix == ".mp4":
        if not FFMpegWriter.isAvailable():
            raise ResultsError(f"{output}: needs ffmpeg, which is not installed; use .gif")
        return FFMpegWriter(fps=rate)
    if output.suffix == ".gif":
        return PillowWriter(fps=rate)
    raise ResultsError(f"output {output}: give a name that ends in .gif or .mp4")


@arguments(output="file", begin="time", end="time", si="flag?", frames="count", rate="above 0", field="text?", turn="number",
           progress="flag?")
def animate(r: Results, output: str | Path, *, begin: float | str = 0, end: float | str = "inf",
            si: bool | None = None, frames: int = 160, rate: int = 20, field: str | None = None,
            view: tuple[float, float] | str | None = None, turn: float = 0, progress: bool | None = None) -> int:
    """Writes a film of a run, .gif or .mp4; the number of its frames.

    begin, end  of the film, dimensionless or with a unit, "20s"
    si          in units of the laboratory that suit the run; None: if its file has them; False: dimensionless
    frames      at most so many, the first and the last shape among them
    rate        frames a second
    field       of a rod in space what the colours show: axial, curvature, twist and others; None: axial
    view, turn  of a rod in space: from where it is seen, as in plot(); by how many degrees the view turns on
                the way
    progress    a bar; None: in a terminal and in a notebook"""
    output = Path(output)
    writer = writer_of(output, rate)
    if not output.parent.is_dir():
        raise FileNotFoundError(errno.ENOENT, os.strerror(errno.ENOENT), str(output))
    runs = runs_of(r, "animate")
    if len(runs) != 1:
        raise ResultsError(f"animate: a film is of one run, not of {len(runs)}; view() shows several in motion")
    r = runs[0]
    if not r.in_space and (field or view or turn):
        raise ResultsError(f"{r.told}: a rod in the plane: field, view and turn are of rods in space")
    first, last = moment("begin", begin, [r]), moment("end", end, [r])
    times = [t for t in r.shapes.get("t", ()) if first * (1 - 1e-9) <= t <= last * (1 + 1e-9)]
    if not times:
        raise ResultsError(f"{r.told}: holds no shape in that time")
    chosen = np.unique(np.linspace(0, len(times) - 1, min(len(times), max(frames, 2))).round().astype(int))
    with plt.rc_context(STYLE), bar(progress, len(chosen)) as shown:
        shapes, units = [r.at(times[k]) for k in chosen], Units(in_laboratory_of([r], si))
        film = FilmInSpace(r, shapes, units, field or "axial", view, turn) if r.in_space else Film(r, shapes, units)
        film.show(0)
        film.figure.draw_without_rendering()
        film.figure.set_layout_engine("none")  # laid out once, not for every frame
        with replacing(output) as part, writer.saving(film.figure, str(part), dpi=110):
            for k in range(len(film.shapes)):
                film.show(k)
                writer.grab_frame()
                shown.update()
    return len(film.shapes)


def main(arguments=None):
    parser = Parser("scripts/animate.sh", __doc__)
    parser.add_argument("file", help="result file, HDF5")
    parser.add_argument("--output", help="default: the file's name with .gif")
    parser.add_argument("--from", dest="begin", default="0", metavar="T",
                        help="of a run with -si_ options also 20s or 2min")
    parser.add_argument("--to", dest="end", default="inf", metavar="T")
    add_choice_of_units(parser)
    parser.add_argument("--frames", type=int, default=160, help="at most; default %(default)s")
    parser.add_argument("--rate", type=int, default=20, help="frames a second; default %(default)s")
    parser.add_argument("--field", help="of a rod in space, what the colours show: " + ", ".join(FIELDS))
    parser.add_argument("--view", metavar="TURN,RISE", help="of a rod in space, degrees about the axis that points up, "
                        "from the front, and above the horizon")
    parser.add_argument("--turn", type=float, default=0, metavar="DEGREES",
                        help="by which the view of a rod in space turns on the way; default: not at all")
    choice = parser.parse_intermixed_args(arguments)
    matplotlib.use("Agg")
    output = Path(choice.output or Path(choice.file).with_suffix(".gif"))
    frames = animate(load(choice.file), output, begin=choice.begin, end=choice.end, si=choice.si,
                     frames=choice.frames, rate=choice.rate, field=choice.field, view=choice.view,
                     turn=choice.turn)
    print(f"animate: {output}, {frames} frames")
    return 0

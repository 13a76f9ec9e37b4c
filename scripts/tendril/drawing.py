"""A picture of a scene before it runs: its rods as they begin, with their names, and what is around them."""

from __future__ import annotations

import tempfile
from pathlib import Path
from typing import TYPE_CHECKING

import matplotlib.pyplot as plt
import numpy as np

from .errors import ResultsError, RunError
from .loading import runs_of
from .perspective import VIEW, Rods, Strand, box_of, draw_surfaces, furnish, sight
from .pictures import NAMED, colours
from .results import Results
from .runs import run
from .several import Several
from .solids import solids
from .spatial import diameter_of, lift, up_of
from .style import STYLE
from .units import scale_of, suited_to

if TYPE_CHECKING:
    from matplotlib.figure import Figure

BESIDE = 0.5  # of the longest side of their box: so far beside the rods walls are seen


def begun(scene, rods, pairs, options) -> Results:
    """A scene as it begins, with no step taken."""
    with tempfile.TemporaryDirectory(prefix="tendril-") as directory:
        try:
            return run(scene, rods=rods, pairs=pairs, output=Path(directory) / "begin.h5", **options | {"ts_max_steps": 0})
        except RunError as error:
            if error.results is None or "ts_max_steps: reached" not in str(error):
                raise  # the scene itself is refused
            return error.results


def time_of(r, t) -> str:
    """A time in words, in the laboratory's unit if the run has one."""
    scale = scale_of([r], "time")
    name, seconds = suited_to("time", t * scale) if scale else ("", 1)
    return f"{t * (scale or 1) / seconds:.3g} {name}".strip()


def show_births(axes, results, joints):
    """Where rods come out later, on those that are there, with their names and times. (A place that is yet to grow is shown near the tip.)"""
    for name in sorted(set(results.born) - set(results.rods), key=results.born.get):
        carrier = results.rods.get(joints[name].on) if name in joints else None
        if carrier is not None:
            place = lift(carrier, carrier.stored(0)).x[joints[name].node - results.first[carrier.name]]
            axes.plot(*place[:, None], "+", c="k", ms=5, zorder=5)
            axes.text(*place, f" {name}: {time_of(carrier, results.born[name])}", fontsize=7, zorder=5)


def draw(scene=None, *, rods=None, pairs=None, view: tuple[float, float] | str | None = None, **options) -> Figure:
    """Draws a scene before it runs: its rods as they begin, with their names, and the walls. A clamp is a square, a joint a ring, and a
    cross is where one comes out later, and when.

    scene, rods, pairs, options  as for run(); or what run() gave, drawn as it began
    view                         from where it is seen, as for plot()"""
    results = scene if isinstance(scene, Results) else begun(scene, rods, pairs, options)
    each = runs_of(results, "draw")
    if not all(len(r.shapes.get("t", ())) for r in each):
        raise ResultsError("draw: the scene holds no shape; give one of -task grow")
    with plt.rc_context(STYLE):
        figure = plt.figure(figsize=(6.4, 5.2))
        axes = figure.add_axes((0.02, 0.04, 0.94, 0.92), projection="3d")
        shapes = [lift(r, r.stored(0)).x for r in each]
        shades = colours(len(each))
        lines = {line: r for r in each for line in str(r.attributes.get("walls", "") or "").splitlines()}
        low, high = box_of(np.concatenate(shapes))
        if lines:  # what is beside the rods is to be seen
            room = BESIDE * (high - low).max()
            low, high = low - room, high + room
        furnish(axes, low, high, up_of(each[0]), sight(view or VIEW), lambda name: name)
        axes.add_collection(Rods([Strand(x, shade, diameter_of(r)) for r, x, shade in zip(each, shapes, shades)], zorder=3), autolim=False)
        joints = results.joints if isinstance(results, Several) and results.joined else {}
        for r, x, shade in zip(each, shapes, shades):
            if r.name not in joints:
                axes.plot(*x[:1].T, "ks", ms=3, zorder=4)
            for end in [k for name, k in ((r.name, 0), (f"{r.name}.tip", -1)) if name in joints]:
                axes.plot(*x[[end]].T, "o", mfc="w", mec=shade, ms=5, zorder=4)
            if len(each) <= NAMED and isinstance(results, Several):
                axes.text(*x[-1], f" {r.name}", color=shade, fontsize=8, zorder=5)
        if isinstance(results, Several):
            show_births(axes, results, joints)
        for r in {id(r): r for r in lines.values()}.values():
            draw_surfaces(axes, [one.at(0.0) for one in solids(r)], low, high)
    return figure

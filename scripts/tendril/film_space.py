"""The film of a rod in space: in perspective with true lengths, coloured by a field, and friction as arrows; the
view may turn on the way."""

from __future__ import annotations

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.cm import ScalarMappable
from matplotlib.colors import AsinhNorm, LinearSegmentedColormap

from .errors import ResultsError
from .naming import unknown
from .perspective import Rods, Strand, box_of, draw_surfaces, fit_seen, furnish, look, seen_aspect, sight
from .solids import solids
from .spatial import FIELDS, VISIBLE, diameter_of, fields_of, up_of
from .style import InStyle
from .units import briefly
from .surroundings import friction, pressed, size_of

ARROWS = 28
RISING = LinearSegmentedColormap.from_list("rising", ["#d6d6d2", "#fdbb84", "#e34a33", "#7f0000"])


class FilmInSpace:
    """A figure that shows one shape after the other, in axes that stay as they are."""

    def __init__(self, r, shapes, units, field, view, turn):
        self.r, self.shapes, self.units, self.field = r, shapes, units, field
        self.turn, self.up, self.view = turn, up_of(r), sight(view)
        along = [fields_of(r, shape).get(field) for shape in shapes]
        if along[0] is None:
            raise ResultsError(f"{r.told}: field {field}{unknown(field, fields_of(r, shapes[0]), ': give one of')}")
        label, unit, signed = FIELDS[field]
        factor, name = units.unit(unit)
        self.along = [factor * values for values in along]
        most = max(np.abs(values).max() for values in self.along) or 1.0
        self.colours = ScalarMappable(AsinhNorm(most / 20, -most if signed else 0, most), "coolwarm_r" if signed else RISING)
        places = units.of("length", np.concatenate([np.zeros((1, 3)), *(s.x for s in shapes)]))
        self.low, self.high = box_of(places)
        self.extent = (self.high - self.low).max()
        self.figure = plt.figure(figsize=(6, 5), FigureClass=InStyle)
        plt.close(self.figure)
        self.ax = self.figure.add_axes((0.0, 0.05, 0.84, 0.89), projection="3d")
        furnish(self.ax, self.low, self.high, self.up, self.view, lambda axis: units.label(axis, "length"))
        self.ax.set_anchor("C")
        self.ax.set_box_aspect((self.high - self.low) / self.extent, zoom=0.95)
        surfaces = solids(r)
        self.draw_walls([one for one in surfaces if not one.motion])
        self.moving, self.drawn = [one for one in surfaces if one.motion], []
        self.rods = self.ax.add_collection(Rods(zorder=3), autolim=False)
        self.ax.plot([0], [0], [0], "ks", ms=4, zorder=4)
        if not turn:  # what is seen fills the film; of a view that turns it changes
            self.figure.set_size_inches(6, 0.9 + 5.0 * max(seen_aspect(self.ax), 0.45))
            fit_seen(self.ax, (0.03, 0.09, 0.8, 0.83))
        self.bar(label if not name else f"{label} ({name})", most, signed)
        self.drag = max(np.percentile(size_of(friction(r, s, ARROWS)[1]), 95) for s in shapes) or 1
        self.press = max((size_of(pressed(r, s, ARROWS)[1]).max() for s in shapes), default=0) if "contact" in r.shapes else 0
        factor, name = units.unit("N")
        told = [("#555555", f"longest arrows: friction {briefly(factor * self.drag)} {name or 'per length'}")]
        if self.press:
            told.append(("#D55E00", f"contact {briefly(factor * self.press)} {name or 'per length'}"))
        for k, (colour, text) in enumerate(told):
            self.figure.text(0.02, 0.03 + 0.035 * k, text, color=colour, fontsize=7)
        self.title = self.figure.text(0.02, 0.95, "", fontfamily="monospace", fontsize=8)
        self.arrows = []

    def bar(self, label, most, signed):
        steps = [a * 10.0**e for e in range(-6, 7) for a in (1, 3)]
        steps = [v for v in steps if most / 15 < v <= most]
        ticks = [-v for v in steps if signed] + [0] + steps
        self.figure.colorbar(self.colours, cax=self.figure.add_axes((0.86, 0.2, 0.022, 0.6)), format="%g", ticks=ticks,
                             label=label.translate(str.maketrans("₁₂₃", "123")))

    def show(self, k):
        shape, length = self.shapes[k], lambda values: self.units.of("length", values)
        middle = (self.along[k][1:] + self.along[k][:-1]) / 2
        thick = length(diameter_of(self.r)) or VISIBLE * self.extent
        self.rods.set_strands([Strand(length(shape.x), self.colours.to_rgba(middle), thick, least=2)])
        look(self.ax, self.up, (self.view[0] + self.turn * k / max(1, len(self.shapes) - 1), self.view[1]))
        for one in [*self.arrows, *self.drawn]:
            one.remove()
        self.drawn = self.draw_walls([one.at(shape.t) for one in self.moving])
        self.arrows = [self.draw_arrows(*friction(self.r, shape, ARROWS), self.drag, "#555555", False)]
        if self.press:
            self.arrows.append(self.draw_arrows(*pressed(self.r, shape, ARROWS), self.press, "#D55E00", True))
        unit = self.units.scales["length"][1]
        self.title.set_text(f"{self.units.plain(shape.t, '6.2f')}   length {length(shape.length):6.2f} {unit}".rstrip())

    def draw_walls(self, surfaces):
        return draw_surfaces(self.ax, surfaces, self.low, self.high, self.units.of("length", 1.0))

    def draw_arrows(self, places, forces, strongest, colour, end):
        """Of forces, of which the strongest is a twelfth of the axes long; they begin at their places, or end
        there."""
        arrows, places = forces * self.extent / 12 / strongest, self.units.of("length", places)
        return self.ax.quiver(*(places - end * arrows).T, *arrows.T, color=colour, lw=0.7, arrow_length_ratio=0.3, zorder=5)

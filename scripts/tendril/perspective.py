"""Rods in space on paper: axes of three dimensions with true lengths, and rods in them as thick as they are,
of which what is nearer hides what is behind it."""

from __future__ import annotations

import itertools
from dataclasses import dataclass

import numpy as np
from matplotlib.backends.backend_agg import RendererAgg
from matplotlib.collections import LineCollection
from matplotlib.colors import to_rgba
from matplotlib.ticker import FixedLocator, MaxNLocator
from matplotlib.transforms import Bbox
from mpl_toolkits.mplot3d import proj3d
from mpl_toolkits.mplot3d.art3d import Line3DCollection, Poly3DCollection

from .errors import ResultsError
from .solids import within
from .walls import EDGE, SOLID

VIEW = (20.0, 20.0)  # degrees: turned about the axis that points up, from the front; from how far above
LIGHT, ROUND = 0.3, 4.0  # of a rod's thickness: the light on it; points: the least thickness at which it has one
LEAST, HALO = 1.1, 0.7  # points: the least thickness; the white on both sides of what passes over something
ROOM = 0.08  # of the longest side of the box of axes: so far beyond it are surfaces drawn
SLIM = 0.22  # of the longest side of the box of axes: the shortest
ASPECTS = 0.4, 1.3  # height over width of what is seen: the least and the most that is made room for


@dataclass
class Strand:
    """A rod as it is drawn: x [n, 3], a colour, or an array of them [n - 1, 4], its diameter."""

    x: np.ndarray
    colour: object
    diameter: float = 0.0
    least: float = LEAST
    halo: float = HALO


class Rods(LineCollection):
    """Rods in axes of three dimensions, piece by piece from the furthest to the nearest."""

    def __init__(self, strands=(), **more):
        super().__init__([], capstyle="butt", **more)
        self.set_strands(strands)

    def set_strands(self, strands):
        """What is drawn from now on."""
        self.strands = list(strands)
        self.stale = True

    def do_3d_projection(self):
        """What axes of three dimensions ask of all that is drawn in them: sets the pieces as they are seen, and
        gives the depth of the nearest."""
        pieces, widths, colours, depths = [], [], [], []
        for number, strand in enumerate(self.strands):
            x = np.asarray(strand.x, float)
            flat, depth = self.seen(x)
            depth = depth + number * self.deep(x, strand.diameter)  # of shapes that lie in one place the earlier is seen before the later
            size = np.maximum(strand.least, strand.diameter * self.scale(x))
            ends = np.stack([flat[:-1], flat[1:]], axis=1)
            thick = (size[1:] + size[:-1]) / 2
            shades = np.broadcast_to(strand.colour if np.ndim(strand.colour) == 2 else to_rgba(strand.colour), (len(ends), 4))
            pieces.append(np.stack([ends, ends, ends], axis=1))  # of each piece its white, then itself, then the light on it
            widths.append(np.stack([thick + 2 * strand.halo, thick, LIGHT * thick], axis=1))
            white = np.tile((1.0, 1.0, 1.0, 1.0 if strand.halo else 0.0), (len(ends), 1))
            light = np.column_stack([shades[:, :3] + 0.35 * (1 - shades[:, :3]), shades[:, 3] * (thick > ROUND)])
            colours.append(np.stack([white, shades, light], axis=1))
            depths.append((depth[1:] + depth[:-1]) / 2)
        if not pieces:
            self.set_segments([])
            return np.nan
        pieces, widths, colours, depths = map(np.concatenate, (pieces, widths, colours, depths))
        order = np.argsort(-depths, kind="stable")
        pieces = joined(pieces, widths, self.axes)
        self.set_segments(pieces[order].reshape(-1, 2, 2))
        self.set_linewidth(widths[order].ravel())
        self.set_color(colours[order].reshape(-1, 4))
        return float(depths.min())

    def seen(self, x):
        """([n, 2] places in the axes' plane, [n] depths, smaller is nearer) of points [n, 3]."""
        a, b, depth = proj3d.proj_transform(*np.asarray(x, float).T, self.axes.get_proj())
        return np.column_stack([a, b]), np.asarray(depth)

    def deep(self, x, least):
        """What a distance towards who looks is in depth: one or three hundredths of the axes' box, or between them one that is given."""
        box = np.ptp([self.axes.get_xlim(), self.axes.get_ylim(), self.axes.get_zlim()], axis=1).max()
        step = np.clip(least, 0.01 * box, 0.03 * box)
        middle = np.mean(x, axis=0, keepdims=True)
        return np.linalg.norm([self.seen(middle + step * d)[1] - self.seen(middle)[1] for d in np.eye(3)])

    def scale(self, x):
        """[n], points of print that a unit of length has at points [n, 3]. The squares of what three axes at right
        angles are seen as add up to two of it."""
        step = 1e-3 * np.ptp([self.axes.get_xlim(), self.axes.get_ylim(), self.axes.get_zlim()], axis=1).max()
        here = self.axes.transData.transform(self.seen(x)[0])
        total = sum(np.sum((self.axes.transData.transform(self.seen(x + step * d)[0]) - here) ** 2, axis=1)
                    for d in np.eye(3))
        return np.sqrt(total / 2) / step * 72 / self.axes.figure.dpi


def joined(pieces, widths, axes):
    """Pieces whose own lines are a little longer than they are, so that none of the paper is seen in a bend."""
    unit = np.linalg.norm(axes.transData.transform((1, 0)) - axes.transData.transform((0, 0)))
    room = 0.2 * widths[:, 1] * axes.figure.dpi / 72 / unit
    own = pieces[:, 1]  # (the light on it is as long)
    along = own[:, 1] - own[:, 0]
    long = np.maximum(np.linalg.norm(along, axis=1), 1e-12)
    more = along * np.minimum(room / long, 0.5)[:, None]
    longer = np.stack([own[:, 0] - more, own[:, 1] + more], axis=1)
    return np.stack([pieces[:, 0], longer, longer], axis=1)


def box_of(points):
    """(low [3], high [3]) of the axes round points [n, 3], with room; no side is much shorter than the longest."""
    low, high = np.min(points, axis=0), np.max(points, axis=0)
    longest = (high - low).max() or 1.0
    side = np.maximum(1.04 * (high - low), SLIM * longest)
    return (low + high - side) / 2, (low + high + side) / 2


def directions(up):
    """(right, up, towards who looks), [3] each: up is an axis, 1, 2 or 3, negative where it points down."""
    above = np.sign(up) * np.eye(3)[abs(up) - 1]
    right = np.eye(3)[1 if abs(up) == 1 else 0]
    return right, above, np.cross(right, above)


def sight(view):
    """Two angles, of a pair or of text "20,30"."""
    try:
        turn, rise = map(float, view.split(",") if isinstance(view, str) else VIEW if view is None else view)
    except (TypeError, ValueError):
        raise ResultsError(f"view {view}: give two angles in degrees, about the axis that points up and above "
                           "the horizon: 20,30") from None
    if not abs(rise) < 90:
        raise ResultsError(f"view {view}: the second angle is above the horizon, less than 90 degrees")
    return turn, rise


def towards(up, view):
    """Unit vector [3] towards the eye of who looks from view: degrees about the axis that points up from the front,
    and above the horizon."""
    right, above, front = directions(up)
    turn, rise = np.radians(view)
    return np.cos(rise) * (np.sin(turn) * right + np.cos(turn) * front) + np.sin(rise) * above


def look(axes, up, view):
    """Turns axes so that an axis points up, and they are seen from view."""
    vertical = abs(up) - 1
    a, b, c = np.roll(towards(up, view), 2 - vertical)  # as the library has them: c along the vertical axis
    axes.view_init(elev=np.degrees(np.arcsin(np.clip(c, -1, 1))), azim=np.degrees(np.arctan2(b, a)),
                   roll=180 if up < 0 else 0, vertical_axis="xyz"[vertical])


def ticks_of(low, high, most):
    """Where an axis has numbers, into that many pieces or fewer, so that they do not run together; yet two numbers
    where that can be: the outermost of them if there is no room for those between, the last if there is none for two."""
    for pieces in range(max(2, round(most)), max(2, round(most)) + 3):
        locator = MaxNLocator(pieces, steps=[1, 2, 5, 10], min_n_ticks=1)
        inside = [value for value in locator.tick_values(low, high) if low <= value <= high]
        if len(inside) > 1:
            break
    if most < 0.6:
        return FixedLocator(inside[-1:])
    return FixedLocator([inside[0], inside[-1]]) if len(inside) > 2 and most < 1.5 else locator


def furnish(axes, low, high, up, view, label):
    """Axes from low to high, alike in all directions, for who looks from view.

    label  gives the label of an axis, "$x_1$" """
    axes.set_proj_type("persp", focal_length=1.6)
    axes.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), zlim=(low[2], high[2]))
    sides = np.subtract(high, low)
    seen = sides * np.sqrt(1 - towards(up, view) ** 2)  # an axis that points at the eye is seen short
    look(axes, up, view)  # (the library takes the sides for those that the present vertical axis says)
    axes.set_box_aspect(sides / sides.max(), zoom=1.0)
    axes.computed_zorder = False
    axes.set_anchor("W")  # so that letters of panels stay in line
    axes.patch.set_alpha(0)
    for d, axis in enumerate((axes.xaxis, axes.yaxis, axes.zaxis)):
        depth = np.delete(sides, d).max() / sides.max()  # the library moves labels off by parts of the other sides
        axis.set_major_locator(ticks_of(low[d], high[d], 5 * seen[d] / sides.max()))
        axis.set_pane_color((1, 1, 1, 0))
        axis.line.set_linewidth(0.6)
        axis.set_tick_params(pad=1 if d == abs(up) - 1 else -2, labelsize=7, width=0.5)  # beside it wide numbers need more
        axis.labelpad = max(-5, 11 / depth - 21)
        axis._axinfo["grid"].update(linewidth=0.35, color="#dcdcdc")
    axes.set_xlabel(label("$x_1$"))
    axes.set_ylabel(label("$x_2$"))
    axes.set_zlabel(label("$x_3$"))


def head(ax):
    """The axes that carry the letter and the legend of others: themselves, but of three dimensions, whose frame is moved so that what
    they show fills their place, some without anything of their own in that place."""
    return getattr(ax, "head", ax)


def seen_box(ax):
    """What axes of three dimensions show, in pixels: their box, what sticks out of it, numbers and names."""
    renderer = RendererAgg(*ax.figure.bbox.size, ax.figure.dpi)
    ax.apply_aspect()
    ax.M = ax.get_proj()
    boxes = [axis.get_tightbbox(renderer) for axis in (ax.xaxis, ax.yaxis, ax.zaxis)]
    low, high = np.array([ax.get_xlim(), ax.get_ylim(), ax.get_zlim()]).T
    room = ROOM * (high - low).max() if any(isinstance(one, Poly3DCollection) for one in ax.collections) else 0.0
    corners = np.array(list(itertools.product(*np.transpose([low - room, high + room]))))
    flat = ax.transData.transform(np.column_stack(proj3d.proj_transform(*corners.T, ax.M)[:2]))
    return Bbox.union([*filter(None, boxes), Bbox([flat.min(axis=0), flat.max(axis=0)])])


def seen_aspect(ax):
    """Height over width of what axes of three dimensions show."""
    box = seen_box(ax)
    return float(np.clip(box.height / box.width, *ASPECTS))


def fit_seen(ax, cell):
    """Moves and widens axes of three dimensions until what they show fills a cell of the figure, (left, bottom, width, height) in
    its parts; letters keep their size, so it is done a few times."""
    figure = ax.figure
    ax.set_anchor("C")
    head(ax).set_position(cell)
    left, bottom, wide, high = np.array(cell) * np.tile(figure.bbox.size, 2)
    side, middle = min(wide, high), np.array([left + wide / 2, bottom + high / 2])
    for _ in range(4):
        ax.set_position(np.array([*(middle - side / 2), side, side]) / np.tile(figure.bbox.size, 2))
        box = seen_box(ax)
        side *= min(wide / box.width, high / box.height)
        middle += np.array([left + wide / 2, bottom + high / 2]) - [(box.x0 + box.x1) / 2, (box.y0 + box.y1) / 2]


def draw_surfaces(axes, surfaces, low, high, unit=1.0):
    """Surfaces (solids.py) behind the rods, translucent, as far as they are in the box of axes or near it; what was
    drawn."""
    drawn = []
    room = ROOM * (np.asarray(high) - low).max()
    for surface in surfaces:
        corners, lines = within(surface, (low - room) / unit, (high + room) / unit)
        if len(corners):
            drawn.append(Poly3DCollection([unit * one for one in corners], facecolor=(*to_rgba(SOLID)[:3], 0.28),
                                          edgecolor="none", zorder=1, clip_on=False))
        drawn.append(Line3DCollection([unit * line for line in lines], colors=EDGE, lw=0.4, alpha=0.7, zorder=2, clip_on=False))
    return [axes.add_collection(one, autolim=False) for one in drawn]

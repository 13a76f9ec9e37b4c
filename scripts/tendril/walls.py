"""Walls in pictures: what `-wall_file` said, as the result file has it, and the rod at its diameter.

    from tendril.walls import draw_walls, draw_rod, draw_contact
    draw_walls(ax, r)               # planes, circles, polygons and conduits, behind all else
    draw_rod(ax, r, shape.x)        # as thick as it is
    draw_contact(ax, r, shape)      # arrows: the force of contact per length

for axes of equal aspect. What is drawn fits itself to the limits that stand when it is drawn."""

from dataclasses import dataclass, field, replace

import numpy as np
from matplotlib import rcParams
from matplotlib.artist import Artist
from matplotlib.collections import LineCollection
from matplotlib.colors import to_rgb
from matplotlib.lines import Line2D
from matplotlib.patches import PathPatch, Rectangle
from matplotlib.path import Path
from matplotlib.text import Text
from matplotlib.transforms import Affine2D

from .courses import motion_of, shift_of, turn_of
from .senses import lamp
from .surroundings import layers_of, pressed, stiffness_along

ARROWS = 40  # of contact along the rod, at most
SOLID, EDGE, SOIL = "#d9d4c7", "#8a8371", "#d8b98a"


@dataclass
class Wall:
    kind: str  # plane, circle, polygon, path
    inside: bool  # circle and polygon: where the rod is
    numbers: np.ndarray
    friction: float
    bend: float = 0.0  # path: radius of its corners; 0: as the program chooses
    motion: dict = field(default_factory=dict)  # of what moves: see courses.motion_of()

    def at(self, t):
        """It where it is at a time; a wall of the plane."""
        if not self.motion:
            return self
        numbers, first = self.numbers.copy(), int(self.kind == "path")
        places = numbers[first:len(numbers) if self.kind in ("path", "polygon") else 2].reshape(-1, 2)
        angle, about = turn_of(self.motion, t)
        turn = np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])
        places[:] = (places - about) @ turn + about + shift_of(self.motion, t)[:2]
        if self.kind == "plane":
            numbers[2:4] = numbers[2:4] @ turn
        return replace(self, numbers=numbers, motion={})


def ends_of(words):
    """(the words of a line without friction, radius and motion at its end; {"friction": 0.3, ...}; how it moves, as
    courses.motion_of() has it)"""
    own, motion = {"friction": 0.0, "radius": 0.0}, {}
    while True:
        if len(words) > 2 and words[-2] in own:
            own[words[-2]] = float(words[-1])
            words = words[:-2]
        elif at := max((k for k, word in enumerate(words) if k and word in ("moves", "turns")), default=0):
            motion |= motion_of(words[at], words[at + 1:])
            words = words[:at]
        else:
            return words, own, motion


def parse(text):
    """The walls of the attribute `walls`, one a line."""
    walls = []
    for line in str(text or "").splitlines():
        words = line.partition("#")[0].replace(",", " ").split()
        if not words:
            continue
        words, own, motion = ends_of(words)
        numbers = [float(w) for w in words[1:] if w not in ("inside", "outside")]
        walls.append(Wall(words[0], "inside" in words, np.array(numbers), own["friction"], own["radius"], motion))
    return walls


def walls_of(r, t=0.0):
    """The walls around a run, those of the plane where they are at a time; none is an empty list."""
    walls = parse(r.attributes.get("walls"))
    return walls if r.in_space else [wall.at(t) for wall in walls]


# ---- outlines ----


def arc(centre, radius, begin, end, points=33):
    """Points of an arc from one angle to another, in radians."""
    a = np.linspace(begin, end, points)
    return np.asarray(centre) + radius * np.column_stack([np.cos(a), np.sin(a)])


def axis_of(radius, points, corner=0.0):
    """The axis of a conduit with its corners rounded as the solver rounds them, each vertex with
    the normal to the left."""
    points = points.reshape(-1, 2)
    steps = np.diff(points, axis=0)
    lengths = np.hypot(*steps.T)
    along = steps / lengths[:, None]
    x, n = [points[0]], [(-along[0, 1], along[0, 0])]
    for k in range(1, len(points) - 1):
        t, u = along[k - 1], along[k]
        turn = np.arctan2(t[0] * u[1] - t[1] * u[0], t @ u)
        normals = (-t[1], t[0]), (-u[1], u[0])
        if abs(turn) < 1e-9:
            x.append(points[k])
            n.append(normals[0])
            continue
        half = np.tan(abs(turn) / 2)
        taken = corner * half or min(radius * max(1, 2 * half), min(lengths[k - 1], lengths[k]) / 2)
        side, bend = np.sign(turn), taken / half
        centre = points[k] - taken * t + side * bend * np.array(normals[0])
        begin = np.arctan2(*(-side * np.array(normals[0]))[::-1])
        ring = arc((0, 0), 1, begin, begin + turn)
        x.extend(centre + bend * ring)
        n.extend(-side * ring)
    x.append(points[-1])
    n.append((-along[-1, 1], along[-1, 0]))
    return np.array(x), np.array(n)


def mouth(radius, end, outwards, side):
    """The rounded lip at an end of a conduit, from its wall outwards."""
    across = side * np.array([-outwards[1], outwards[0]])
    begin = np.arctan2(-across[1], -across[0])
    turn = np.pi / 2 if side < 0 else -np.pi / 2
    turn = turn if np.allclose(arc((0, 0), 1, begin, begin + turn)[-1], outwards, atol=1e-6) else -turn
    return arc(end + 2 * radius * across, radius, begin, begin + turn)


def conduit(wall):
    """The two walls of a conduit as lines, mouths included."""
    radius = wall.numbers[0]
    x, n = axis_of(radius, wall.numbers[1:], wall.bend)
    out = [x[0] - x[1], x[-1] - x[-2]]
    out = [o / np.hypot(*o) for o in out]
    lines = []
    for side in (1, -1):
        # at the first end the left of the axis is the right of the direction outwards
        first = mouth(radius, x[0], out[0], -side)[::-1]
        last = mouth(radius, x[-1], out[1], side)
        lines.append(np.concatenate([first, x + side * radius * n, last]))
    return lines


def view_of(ax):
    (x0, x1), (y0, y1) = sorted(ax.get_xlim()), sorted(ax.get_ylim())
    return x0, x1, y0, y1


def half_plane(point, normal, view):
    """The part of the view that lies behind a plane, a polygon, and the plane's line in it."""
    x0, x1, y0, y1 = view
    size = 2 * np.hypot(x1 - x0, y1 - y0)
    normal = normal / np.hypot(*normal)
    along = np.array([normal[1], -normal[0]])
    foot = point + along * (along @ (np.array([(x0 + x1) / 2, (y0 + y1) / 2]) - point))
    a, b = foot - size * along, foot + size * along
    return np.array([a, b, b - size * normal, a - size * normal]), np.array([a, b])


def ring_of(wall):
    """The outline of a circle or polygon, closed."""
    if wall.kind == "circle":
        return arc(wall.numbers[:2], wall.numbers[2], 0, 2 * np.pi, 181)
    x = wall.numbers.reshape(-1, 2)
    return np.concatenate([x, x[:1]])


def reach_of(walls):
    """Where walls with an extent are, [n, 2]: for who chooses the limits of a picture."""
    parts = [ring_of(w) for w in walls if w.kind in ("circle", "polygon")]
    parts += [p for w in walls if w.kind == "path" for p in conduit(w)]
    return np.concatenate(parts) if parts else np.zeros((0, 2))


# ---- drawing ----


def closed(vertices):
    codes = [Path.MOVETO] + [Path.LINETO] * (len(vertices) - 1)
    return list(vertices), codes


def solid(wall, view):
    """(the patch where the wall's body is, its outlines)."""
    x0, x1, y0, y1 = view
    if wall.kind == "plane":
        body, line = half_plane(wall.numbers[:2], wall.numbers[2:], view)
        return Path(np.concatenate([body, body[:1]])), [line]
    if wall.kind == "path":
        left, right = conduit(wall)
        return None, [left, right]
    ring = ring_of(wall)
    if not wall.inside:
        return Path(ring), [ring]
    # all of the view but the hole: the box one way round, the ring the other
    wide, high = x1 - x0, y1 - y0
    box = np.array([(x0 - wide, y0 - high), (x1 + wide, y0 - high), (x1 + wide, y1 + high),
                    (x0 - wide, y1 + high), (x0 - wide, y0 - high)])
    area = np.sum(ring[:-1, 0] * ring[1:, 1] - ring[1:, 0] * ring[:-1, 1])
    vertices, codes = closed(box)
    more, their = closed(ring[::-1] if area > 0 else ring)
    return Path(np.array(vertices + more), codes + their), [ring]


class Layers(Artist):
    """Layers of friction behind all else, darker where it is larger, with what it is multiplied by, as far as they are within the
    limits that the axes have when they are drawn."""

    def __init__(self, layers, scale):
        super().__init__()
        self.layers, self.scale = layers, scale
        self.set_zorder(-2)

    def get_tightbbox(self, renderer=None):
        return None

    def draw(self, renderer):
        x0, x1, y0, y1 = view_of(self.axes)
        begins = [-np.inf, *(self.scale * begin for begin, _ in self.layers[1:]), np.inf]  # the first is constant beyond its edge
        most = max(factor for _, factor in self.layers)
        for low, high, (_, factor) in zip(begins, begins[1:], self.layers):
            low, high = max(low, x0), min(high, x1)
            if high <= low:
                continue
            band = Rectangle((low, y0), high - low, y1 - y0, facecolor=SOIL, alpha=0.6 * factor / most if most else 0.0, edgecolor="none")
            word = Text(low + 0.02 * (x1 - x0), y0 + 0.02 * (y1 - y0), f"friction × {factor:g}" if low == x0 else f"× {factor:g}", fontsize=7, color="#555")
            for part in (band, word):
                part.axes, part.figure = self.axes, self.axes.figure
                part.set_transform(self.axes.transData)
                part.set_clip_path(self.axes.patch)
                part.draw(renderer)


class Scenery(Artist):
    """The walls of a run, drawn within whatever limits the axes have when they are drawn."""

    def __init__(self, walls, scale):
        super().__init__()
        self.walls, self.grow, self.scale = walls, Affine2D().scale(scale), scale
        self.set_zorder(-1)

    def get_window_extent(self, renderer=None):
        return self.axes.bbox

    def get_tightbbox(self, renderer=None):
        return None

    def draw(self, renderer):
        view = tuple(v / self.scale for v in view_of(self.axes))
        for wall in self.walls:
            body, lines = solid(wall, view)
            parts = [] if body is None else [(body, dict(facecolor=SOLID, edgecolor="none"))]
            parts += [(Path(line), dict(fill=False, edgecolor=EDGE, lw=0.8)) for line in lines]
            for path, look in parts:
                patch = PathPatch(self.grow.transform_path(path), **look)
                patch.axes, patch.figure = self.axes, self.axes.figure
                patch.set_transform(self.axes.transData)
                patch.set_clip_path(self.axes.patch)
                patch.draw(renderer)


def outlines(r) -> list[tuple[list[np.ndarray], list[np.ndarray]]]:
    """Of each wall around a run (rings [m, 2], what lies in one but not in two of them is its body; its
    lines [m, 2]); of what has no end as much as the shapes reach along it, and more."""
    x = np.concatenate([s.reshape(-1, 2) for s in r.shapes["x"]])
    (x0, y0), (x1, y1) = x.min(axis=0), x.max(axis=0)
    room = max(x1 - x0, y1 - y0)
    found = []
    for wall in walls_of(r):
        body, lines = solid(wall, (x0 - room, x1 + room, y0 - room, y1 + room))
        found.append((body.to_polygons(closed_only=False) if body else [], lines))
    return found


def draw_lamp(ax, r, axes, scale=1.0):
    """Draws the lamp of a run, if it has one, seen along the axis that is not among these two."""
    at = lamp(r, 3)
    if at is not None:
        ax.plot(*(scale * at[list(axes)]), marker="*", ms=9, mfc="#F0C000", mec="#8A6D00", mew=0.6, ls="", zorder=4)


def draw_walls(ax, r, scale=1.0, room=True, t=0.0):
    """Draws the walls of a run, where they are at a time, behind all else, and makes room for those the rod is within or beside;
    its lamp, and layers of friction. scale: what a unit of length is in the picture. Returns what draws the walls, whose .walls may
    be set; None if there are none."""
    draw_lamp(ax, r, (0, 1), scale)
    layers = layers_of(r)
    if len({factor for _, factor in layers}) > 1:
        ax.add_artist(Layers(layers, scale))
    walls = walls_of(r, t)
    if not walls:
        return None
    scenery = ax.add_artist(Scenery(walls, scale))
    whole = [w for w in walls if w.inside or w.kind == "path" or near(w, ax.dataLim, scale)]
    if whole and room:
        ax.update_datalim(scale * reach_of(whole))
        ax.autoscale_view()
    return scenery


def near(wall, box, scale):
    """Is it a stone no larger than what is drawn in a box, and partly in it or near it?"""
    if wall.kind != "circle" or not np.isfinite(box.extents).all():
        return False
    x, y, radius = scale * np.asarray(wall.numbers[:3])
    off = np.hypot(x - np.clip(x, box.x0, box.x1), y - np.clip(y, box.y0, box.y1))
    size = max(box.width, box.height)
    return off < radius + 0.05 * size and 2 * radius < size


class Thick:
    """A line as wide as `width` in the data of its axes, which have equal aspect, less `rim` points on
    both sides."""

    width, least, rim = 0.0, 0.5, 0.0

    def points(self):
        box = self.axes.get_window_extent()
        return self.width * box.width / abs(np.subtract(*self.axes.get_xlim())) * 72 / self.axes.figure.dpi

    def draw(self, renderer):
        self.set_linewidth(max(self.least, self.points() - 2 * self.rim))
        super().draw(renderer)


class ThickLine(Thick, Line2D):
    pass


class ThickSegments(Thick, LineCollection):
    pass


class Tube(ThickLine):
    """A rod as thick as it is, with a rim: strands that touch each other stay apart for the eye."""

    def draw(self, renderer):
        colour, thick = self.get_color(), self.points()
        super().draw(renderer)
        if thick > THIN:
            self.set(color=pale(colour), linestyle="-")
            self.rim = min(RIM, thick / 6)
            super().draw(renderer)
            self.set_color(colour)
            self.rim = 0.0


RIM, THIN = 0.55, 2.0  # in points: the rim, and of a rod that has none


def pale(colour):
    """Halfway to white."""
    return tuple((1 + c) / 2 for c in to_rgb(colour))


def draw_rod(ax, r, x, scale=1.0, **look):
    """The rod through the nodes x, as thick as it is, and thinly if it has no diameter."""
    look.setdefault("solid_capstyle", "round")
    look.setdefault("solid_joinstyle", "round")
    line = Tube(*(scale * np.asarray(x).T), **look)
    line.width = scale * r.diameter
    line.least = look.get("lw", rcParams["lines.linewidth"] if line.width == 0 else Thick.least)
    ax.add_line(line)
    stiff = stiffness_along(r, x) if line.width == 0 else None
    if stiff is not None:  # wider where it is stiffer, so that a soft end is seen
        ends = np.stack([scale * np.asarray(x)[:-1], scale * np.asarray(x)[1:]], axis=1)
        ax.add_collection(LineCollection(ends, linewidths=line.get_linewidth() + 3.5 * stiff / stiff.max(), color=pale(line.get_color()), capstyle="round",
                                         zorder=line.get_zorder() - 0.01), autolim=False)
    ax.autoscale_view()
    return line


def strongest_contact(r, shapes):
    """Of the arrows of these shapes."""
    return max((np.hypot(*pressed(r, shape, ARROWS)[1].T).max() for shape in shapes), default=0.0)


def draw_contact(ax, r, shape, scale=1.0, most=None, extent=None, **look):
    """Arrows for the force of contact on the rod per length, each the mean over its piece of the rod; one of
    the size `most`, the largest if not given, is an eighth of an extent long, the rod's if not given.
    Returns them; None if nothing touches."""
    place, force = pressed(r, shape, ARROWS)  # an arrow ends on the rod's surface, where the force acts
    size = np.hypot(*force.T)
    if size.max() == 0:
        return None
    most = most or size.max()
    drawn = size > 0.02 * most
    long = 0.125 * (extent or scale * np.ptp(shape.x, axis=0).max()) / most
    look = {"color": "#D55E00", "width": 0.0032, "zorder": 4, "edgecolor": "white", "linewidth": 0.3, **look}
    return ax.quiver(*(scale * place[drawn].T), *force[drawn].T, angles="xy", scale_units="xy",
                     scale=1 / long, pivot="tip", headwidth=3.6, headlength=4.2, headaxislength=3.8, **look)

"""Surfaces around a rod in space, as the result file has them (/walls, one a line), as triangles and lines for
who draws them. Walls of the plane stand upright along x3; what has no end is drawn as far as the rod reaches,
and a little more."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import h5py
import numpy as np
from scipy.interpolate import CubicSpline
from scipy.spatial.transform import Rotation

from .courses import shift_of, turned
from .results import Results
from .senses import lamp
from .spatial import carried, slopes
from .units import METRES
from .walls import conduit, ends_of, parse, ring_of

ROUND = 48  # pieces of a full turn


@dataclass
class Surface:
    """Vertices [m, 3], triangles [k, 3], and lines [j, 3] that show what it is where it is hardly seen; at t = 0,
    if it moves. What has no end is a piece of it, which stays under the rod while it moves."""

    vertices: np.ndarray
    triangles: np.ndarray
    lines: list[np.ndarray]
    endless: np.ndarray = field(default_factory=lambda: np.empty((0, 3)))  # directions of length 1 in which it has no end
    # of what moves, as courses.motion_of() has it; endless, and the "middle" it was drawn under
    motion: dict = field(default_factory=dict)

    def at(self, t):
        """It where it is at a time."""
        if not self.motion:
            return self
        turns, middle = (self.motion.get(what, still) for what, still in
                         (("turns", np.array([0, 0, 0, 0, 0, 0, 1.0])), ("middle", np.zeros(3))))
        shift = shift_of(self.motion, t)
        turn, place = Rotation.from_rotvec(turned(self.motion, t) * turns[4:]), turns[1:4]
        under = turn.inv().apply(middle - place - shift) + place  # what was drawn there is under the rod now
        laid = self.endless.T @ (self.endless @ (under - middle))

        def carried_to(x):
            return turn.apply(x + laid - place) + place + shift

        return replace(self, vertices=carried_to(self.vertices), lines=[carried_to(line) for line in self.lines])


def solids(r: Results) -> list[Surface]:
    """The surfaces around a run, as far as they are near to where the rod ever is, and its lamp as a small ball."""
    text = str(r.attributes.get("walls", "") or "")
    x = r.shapes.x.reshape(-1, r.shapes.x.shape[-1])
    x = np.column_stack([x, np.zeros((len(x), 3 - x.shape[1]))])
    reach = Reach(np.minimum(x.min(axis=0), 0), np.maximum(x.max(axis=0), 0))
    found = [surface for line in text.splitlines() if line.split() for surface in drawn(line, r, reach)]
    at = lamp(r, 3)
    if at is not None:
        found += of_numbers(" ".join(["sphere", *map(str, at), str(0.03 * reach.size), "outside"]), reach)
    return found


@dataclass
class Reach:
    """The box [low, high] in which the rod moves."""

    low: np.ndarray
    high: np.ndarray

    @property
    def middle(self):
        return (self.low + self.high) / 2

    @property
    def size(self):
        """Half of its longest side, and a little more."""
        return 0.65 * float(np.max(self.high - self.low)) or 1.0


def drawn(line, r, reach):
    """The surfaces of a line; none of a kind that is not known here."""
    words, _, motion = ends_of(line.split())
    still = of_body(words[1], r) if words[0] == "body" else of_numbers(line, reach)
    return [replace(one, motion=motion and motion | {"endless": one.endless, "middle": reach.middle}) for one in still]


def of_numbers(line, reach):
    """The surfaces of a line whose form its numbers say, at t = 0."""
    (wall,) = parse(line)
    kind, n = wall.kind, wall.numbers
    if kind == "plane" and len(n) == 6:
        return [plane(n[:3], n[3:], reach)]
    if kind == "sphere":
        return [revolved(n[:3], (0, 0, 1), n[3] * np.sin(turn(-0.5, 0.5)), n[3] * np.cos(turn(-0.5, 0.5)))]
    if kind == "cylinder":
        return [straight(n[:3], n[3:6], n[6], n[6], n[7] if len(n) > 7 else None, reach)]
    if kind == "cone":
        return [straight(n[:3], n[3:6], n[6], n[7], n[8], reach)]
    if kind == "torus":
        around = turn(-1, 1)
        return [revolved(n[:3], n[3:6], n[7] * np.sin(around), n[6] + n[7] * np.cos(around))]
    if kind == "tube":
        return [along(n.reshape(-1, 4))]
    if kind in ("plane", "circle", "polygon", "path"):
        return upright(wall, reach)
    return []


def of_body(path, r):
    """The triangles that a body was made from, else, with scikit-image, those of its distance; none if the file is
    not to be had any more."""
    try:
        with h5py.File(path, "r", locking=False) as file:
            unit = length_of(file["distance"].attrs.get("units", ""), r)
            if "mesh" in file:
                vertices, triangles = file["mesh/points"][()], file["mesh/triangles"][()]
            else:
                vertices, triangles = level(*(file[name][()] for name in ("distance", "origin", "spacing")))
    except (OSError, KeyError, ValueError, ImportError):
        return []
    vertices, triangles = coarse(np.asarray(vertices, float), np.asarray(triangles, int))
    return [Surface(unit * vertices, triangles, [])]


def level(distance, origin, spacing):
    """Where a distance [n3, n2, n1] on a grid is 0."""
    from skimage.measure import marching_cubes

    places, triangles, *_ = marching_cubes(distance, 0.0)
    return origin + places[:, ::-1] * spacing, triangles


def length_of(unit, r):
    """What 1 of a unit is in those of the file; 1 without a unit."""
    unit = unit.decode() if isinstance(unit, bytes) else str(unit)
    return METRES[unit] / r.scale("length") if unit in METRES else 1.0


def along(balls):
    """The tube along balls [n, 4], places and radii, in rings across the smooth path through them."""
    knots = np.concatenate([[0], np.cumsum(np.linalg.norm(np.diff(balls[:, :3], axis=0), axis=1))])
    path = CubicSpline(knots, balls)(np.linspace(0, knots[-1], min(400, 8 * len(balls))))
    x, radius = path[:, :3], path[:, 3:]
    normal, third = carried(x, np.eye(3)[np.argmin(np.abs(slopes(x)[0]))])
    around = turn(-1, 1)[:-1]
    ring = np.cos(around)[:, None] * normal[:, None] + np.sin(around)[:, None] * third[:, None]
    return sheet(x[:, None] + radius[:, None] * ring)


def coarse(vertices, triangles, most=8000):
    """Of so many vertices at most: those in one box of a grid become one, in their middle."""
    side = np.ptp(vertices, axis=0).max() / 4 / np.sqrt(most)
    while len(vertices) > most:
        side *= 1.5
        _, box = np.unique(np.floor(vertices / side), axis=0, return_inverse=True)
        box = box.ravel()
        count = np.bincount(box)
        vertices = np.column_stack([np.bincount(box, v) / count for v in vertices.T])
        triangles = box[triangles]
        whole = (triangles[:, 0] != triangles[:, 1]) & (triangles[:, 1] != triangles[:, 2]) & (triangles[:, 2] != triangles[:, 0])
        triangles = triangles[whole]
    return vertices, triangles


def within(surface, low, high):
    """What of a surface is in a box: its triangles, polygons [k, 3] where the box cuts them, and its lines as far as their
    points are."""
    corners = surface.vertices[surface.triangles]
    inside = np.all((corners >= low) & (corners <= high), axis=(1, 2))
    near = np.all((corners.max(axis=1) > low) & (corners.min(axis=1) < high), axis=1) & ~inside
    parts = [part for part in (cut(corner, low, high) for corner in corners[near]) if len(part) > 2]
    lines = [line[np.all((line >= low) & (line <= high), axis=1)] for line in surface.lines]
    return [*corners[inside], *parts], [line for line in lines if len(line) > 1]


def cut(polygon, low, high):
    """What of a convex polygon [n, 3] is in a box: cut by its six sides, one after another (Sutherland and Hodgman)."""
    for axis, sign, at in [(k, s, v[k]) for s, v in ((1, low), (-1, high)) for k in range(3)]:
        depth = sign * (polygon[:, axis] - at)
        kept = []
        for a, b, deep, next_deep in zip(polygon, np.roll(polygon, -1, axis=0), depth, np.roll(depth, -1)):
            if deep >= 0:
                kept.append(a)
            if deep * next_deep < 0:
                kept.append(a + deep / (deep - next_deep) * (b - a))
        polygon = np.array(kept).reshape(-1, 3)
        if not len(polygon):
            break
    return polygon


def turn(first, last):
    """Angles from one to another, in parts of half a turn."""
    return np.pi * np.linspace(first, last, max(2, round(ROUND * (last - first) / 2)) + 1)


def plane(point, normal, reach):
    """A square of it, under where the rod is."""
    normal = normal / np.linalg.norm(normal)
    a = np.cross(normal, np.eye(3)[np.argmin(np.abs(normal))])
    a /= np.linalg.norm(a)
    b = np.cross(normal, a)
    foot = reach.middle - ((reach.middle - point) @ normal) * normal
    corners = foot + reach.size * np.array([-a - b, a - b, a + b, -a + b])
    return Surface(corners, np.array([[0, 1, 2], [0, 2, 3]]), [np.concatenate([corners, corners[:1]])], np.array([a, b]))


def straight(point, axis, first, last, length, reach):
    """A cylinder or cone; without a length as much of it as the rod reaches along it."""
    axis = axis / np.linalg.norm(axis)
    along = (0.0, length) if length is not None else \
        np.array([-1, 1]) * reach.size + (reach.middle - point) @ axis
    whole = revolved(point, axis, np.linspace(*along, ROUND // 2), np.linspace(first, last, ROUND // 2))
    return whole if length is not None else replace(whole, endless=axis[None])


def revolved(middle, axis, along, radii):
    """What a line at `along` the axis and at radii from it sweeps."""
    axis = np.asarray(axis, float) / np.linalg.norm(axis)
    a = np.cross(axis, np.eye(3)[np.argmin(np.abs(axis))])
    a /= np.linalg.norm(a)
    around = turn(-1, 1)[:-1]
    ring = np.cos(around)[:, None] * a + np.sin(around)[:, None] * np.cross(axis, a)
    grid = middle + along[:, None, None] * axis + radii[:, None, None] * ring
    return sheet(grid)


def sheet(grid):
    """The surface through rings [rows, columns, 3], each closed, with its first and last ring and some lines along
    it."""
    rows, columns = grid.shape[:2]
    i, j = np.meshgrid(np.arange(rows - 1), np.arange(columns), indexing="ij")
    k = (j + 1) % columns
    a, b, c, d = (i * columns + j, i * columns + k, (i + 1) * columns + k, (i + 1) * columns + j)
    triangles = np.concatenate([np.stack([a, b, c], -1).reshape(-1, 3), np.stack([a, c, d], -1).reshape(-1, 3)])
    rings = [np.concatenate([grid[row], grid[row][:1]]) for row in np.unique(np.linspace(0, rows - 1, 3).astype(int))]
    return Surface(grid.reshape(-1, 3), triangles, rings + [grid[:, column] for column in range(0, columns, columns // 4)])


def upright(wall, reach):
    """A wall of the plane along x3, from below the rod to above it."""
    low, high = reach.middle[2] - reach.size / 2, reach.middle[2] + reach.size / 2
    if wall.kind == "plane":
        normal = np.array([*wall.numbers[2:4], 0.0])
        return [plane(np.array([*wall.numbers[:2], 0.0]), normal, reach)]
    outlines = conduit(wall) if wall.kind == "path" else [ring_of(wall)]
    return [band(np.asarray(line), low, high) for line in outlines]


def band(line, low, high):
    """What stands on a line [n, 2]."""
    n = len(line)
    ends = [np.column_stack([line, np.full(n, z)]) for z in (low, high)]
    i = np.arange(n - 1)
    triangles = np.concatenate([np.stack([i, i + 1, n + i + 1], -1), np.stack([i, n + i + 1, n + i], -1)])
    return Surface(np.concatenate(ends), triangles, ends)

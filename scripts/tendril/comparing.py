"""How far a run is from what was measured: residuals, in the units of the measurement."""

from __future__ import annotations

from collections import Counter
from typing import NamedTuple

import numpy as np
from scipy import stats
from scipy.interpolate import CubicSpline, PchipInterpolator
from scipy.sparse.csgraph import connected_components, minimum_spanning_tree
from scipy.spatial import cKDTree
from scipy.spatial.distance import cdist

from .measured import Curve, DataError, Measured, Photograph
from .naming import unknown
from .noise import Block
from .results import Results, as_text
from .units import PIXEL, in_laboratory

FINER = 4  # points between nodes, so that the line is as good as the nodes are
ANGLES = ("tip_angle", "base_angle")  # series that are read off shapes: of places behind the tip
LINES = "lines"  # the group of all points of centre lines; series are groups by their names
ENDS = "ends"  # of how far a rod goes on beyond its points
BARE = "bare"  # of places on the rod near which there are no points
PLACES = 24  # of these, on each rod
BARE_NOISE = 0.05  # of the extent: they lead a search, and are nothing where rod and points agree
# how a picture and its clock stand to the rod: what the numbers are where nothing is said
VIEW = {"camera_x": 0.0, "camera_y": 0.0, "camera_turn": 0.0, "camera_scale": 1.0, "camera_stretch": 0.0,
        "camera_shear": 0.0, "camera_tilt_1": 0.0, "camera_tilt_2": 0.0, "clock_rate": 1.0, "clock_offset": 0.0}


def viewed(line, view=VIEW):
    """[n, 2], where a picture shows a line of the rod: larger by its scale, longer along x1 than along x2 by its stretch,
    sheared, turned, smaller with the distance along the tilt, and off its place,

        x' = s R (1 + E) x / (1 + g.x) + d,   E = 1/2 ((stretch, shear), (shear, -stretch))."""
    c, s = np.cos(view["camera_turn"]), np.sin(view["camera_turn"])
    stretch, shear = view["camera_stretch"] / 2, view["camera_shear"] / 2
    strain = np.array([[1 + stretch, shear], [shear, 1 - stretch]])
    tilt = 1 + line @ [view["camera_tilt_1"], view["camera_tilt_2"]]
    return view["camera_scale"] * (line @ strain @ [[c, s], [-s, c]]) / tilt[:, None] + [view["camera_x"], view["camera_y"]]


def time_of(r: Results, abscissa, at, view=VIEW):
    """Dimensionless times of a run at times or lengths that were measured; the clock of the measurement
    may go fast and begin late: its rate and offset, in its own unit, are in the view."""
    unit = {"t": "l/V", "length": "l"}[abscissa]
    if at.si and at.unit != unit:
        raise DataError(f"{abscissa} was measured in another unit than {unit} has")
    clocked = at.numbers
    if abscissa == "t":
        clocked = (clocked - view["clock_offset"]) / view["clock_rate"]
    values = clocked / in_laboratory(unit, r.scale)[0] if at.si else clocked
    if abscissa == "t":
        return values
    return np.interp(values, r.series.length, r.series.t)


def shape_at(r: Results, t):
    """[n, 2], the rod at time t: the cubic through the four stored shapes around it. Beyond the ends
    of the run, its first or last."""
    times = r.shapes.t
    t = float(np.clip(t, times[0], times[-1]))
    first = int(np.clip(np.searchsorted(times, t) - 2, 0, max(0, len(times) - 4)))
    near = times[first:first + 4]
    weights = [np.prod([(t - b) / (a - b) for b in near if b != a]) for a in near]
    return np.tensordot(weights, r.shapes.x[first:first + 4], 1)


NEWTON = 6  # iterations, from where a stretch that is even in the cell would have it


def angles_behind(r: Results, distance):
    """[times of the shapes], the rod's angle so far behind its tip, as the run counts lengths: at the label s where the arc
    length p = int_0^s g ds is L - distance. Of a shorter rod that at the clamp."""
    if distance == 0:
        return r.shapes.theta[:, -1]
    s, theta, every = r.shapes.s, CubicSpline(r.shapes.s, r.shapes.theta.T), np.arange(len(r.shapes.t))
    length = CubicSpline(s, r.shapes.stretch.T).antiderivative()
    p = length(s)
    asked = np.maximum(p[-1] - distance, 0.0)
    cell = (p[1:-1] <= asked).sum(axis=0)
    quartic, cubic, width = length.c[:, cell, every], theta.c[:, cell, every], np.diff(s)[cell]
    beyond = (asked - p[cell, every]) / (p[cell + 1, every] - p[cell, every]) * width  # of its first node; g varies little in a cell
    for _ in range(NEWTON):
        off, slope = np.zeros_like(asked), np.zeros_like(asked)
        for c in quartic:
            off, slope = off * beyond + c, slope * beyond + off
        beyond = np.clip(beyond - (off - asked) / slope, 0, width)
    found = np.zeros_like(asked)
    for c in cubic:
        found = found * beyond + c
    return found


def finer(x):
    """A line of nodes [n, 2] as a smooth one of more points."""
    s = np.arange(len(x))
    return CubicSpline(s, x)(np.linspace(0, len(x) - 1, FINER * (len(x) - 1) + 1))


class Nearest(NamedTuple):
    """Of points, what of a line is nearest to them."""

    distance: np.ndarray  # [m], positive on the left of the line; but for slack beyond its ends
    foot: np.ndarray  # [m, 2]
    place: np.ndarray  # [m], arc length of the foot
    normal: np.ndarray  # [m, 2], of the line, to the left
    other: np.ndarray  # [m], how much farther another strand of the line is; inf where there is none
    beyond: np.ndarray  # [m], how far behind the end of the line, along it; 0 beside the line


def least_of_all_near(values):
    """[m, n], whether a value is not larger than those before and behind it in its row. What is farther along the same
    strand of a rod is nearer to a point than some other strand, but no foot of it: distances go on falling on one side."""
    falls = np.diff(values, axis=1) < 0
    return np.pad(falls, ((0, 0), (1, 0)), constant_values=True) & np.pad(~falls, ((0, 0), (0, 1)), constant_values=True)


FARTHEST = 20.0  # logarithm of how many pictures long a rod is at most, or as a part of one at least
SLACK = 2.0  # gaps between points: what is known of where the rod ends
BY_CHANCE, SURELY = 0.07, 1e-3  # how often the last gap is wider than SLACK, of points anywhere; a chance that is none
STRAND = 0.1  # of a line's length: what is farther from a place, along it, is another strand


def nearest(points, line, slack=0.0) -> Nearest:
    """By the node that is nearest, and the pieces on both sides of it: nodes are much nearer to each other than lines
    bend (FINER). slack: a point not farther beyond an end of the line has the distance from its extension. The sign
    of one that lies ahead of the tip is by chance, and would change with the least turn of it: by twice its distance."""
    along = np.diff(line, axis=0)
    lengths = np.hypot(*along.T)
    begin = np.concatenate([[0], np.cumsum(lengths)])
    squares = cdist(points, line, "sqeuclidean")
    node, rows = np.argmin(squares, axis=1), np.arange(len(points))
    away = np.abs(begin - begin[node][:, None]) > STRAND * begin[-1]
    other = np.sqrt(np.min(squares, axis=1, where=away & least_of_all_near(squares), initial=np.inf))
    pieces = np.clip(node[:, None] + [-1, 0], 0, len(along) - 1)  # [m, 2], before and behind it
    part = np.einsum("mkd,mkd->mk", points[:, None] - line[pieces], along[pieces]) / lengths[pieces] ** 2
    part = np.clip(part, 0, 1)
    feet = line[pieces] + part[..., None] * along[pieces]
    which = np.argmin(np.sum((points[:, None] - feet) ** 2, axis=2), axis=1)
    piece, part, foot = pieces[rows, which], part[rows, which], feet[rows, which]
    along = along[piece] / lengths[piece][:, None]
    normal, gap = np.column_stack([-along[:, 1], along[:, 0]]), points - foot
    across, ahead = np.sum(normal * gap, axis=1), np.sum(along * gap, axis=1)
    far = np.maximum(np.abs(ahead) - slack, 0)
    return Nearest(np.where(across < 0, -1, 1) * np.hypot(across, far), foot, begin[piece] + part * lengths[piece],
                   normal, other - np.hypot(*gap.T), np.where(piece == len(lengths) - 1, np.maximum(ahead, 0), 0))


def distances(points, line):
    """([m] distances of points from a line, positive on its left; [m, 2] its nearest places)"""
    return nearest(points, line)[:2]


class Camera:
    """How a picture shows the rod: scale (pixels per length), the clamp's place, a turn. Pixels are
    counted downwards."""

    COUNT = 4

    def __init__(self, size):
        self.size = size  # of what is in the picture, in pixels

    def see(self, x, numbers):
        """[n, 2] in pixels. numbers: logarithm of the scale, place over the size, angle in radians."""
        scale, angle = self.size * np.exp(numbers[0]), numbers[3]
        turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
        return self.size * np.asarray(numbers[1:3]) + scale * (x @ turn.T) * [1, -1]

    def guess(self, points, x):
        """Numbers by which a line comes to lie over points: equal centres and radii of gyration."""
        x, points = x * [1, -1], np.asarray(points)
        ratio = np.sqrt(points.var(axis=0).sum() / max(x.var(axis=0).sum(), 1e-30))
        place = points.mean(axis=0) - ratio * x.mean(axis=0)
        return [np.log(ratio / self.size), *(place / self.size), 0.0]


def best_time(r: Results, points):
    """The stored time, as a part of the run, at which rod and points lie nearest to each other: both
    ways, for a rod that is too long has something near every point, too. Medians, against outliers."""
    tree = cKDTree(points)
    cost = [np.median(np.abs(distances(points, x)[0])) + np.median(tree.query(x)[0])
            for x in r.shapes.x]
    return float(r.shapes.t[int(np.argmin(cost))] / r.shapes.t[-1])


def spacing(points):
    """How far points are from the next one, but for the loosest."""
    return float(np.quantile(cKDTree(points).query(points, 2)[0][:, 1], 0.95))


def loose_end(points, line, gap, beyond=()):
    """How far the end of a line is from the nearest point, beyond what the gaps between points explain:
    distances from the points alone would not tell that a rod is too long. Negative where it is too short: how far
    the second of the points that are farthest beyond it is, for one may be a stray; more than SLACK gaps are in
    the distances."""
    short = min(np.sort(beyond)[-2], SLACK * gap) if len(beyond) > 1 else 0.0
    return max(0.0, float(cKDTree(points).query(line[-1])[0] - SLACK * gap)) - float(short)


def widest_gap(points):
    """The longest way from some points to the rest of them, where both are three or more: between these
    nothing was measured, and a rod may be there."""
    links = minimum_spanning_tree(cdist(points, points)).tocoo()
    longest = np.argsort(links.data)[::-1]
    for k in longest[:20]:
        kept = np.arange(len(links.data)) != k
        rest = type(links)((links.data[kept], (links.row[kept], links.col[kept])), shape=links.shape)
        _, side = connected_components(rest, directed=False)
        if min(np.count_nonzero(side == 0), np.count_nonzero(side == 1)) >= 3:
            return float(links.data[k])
    return float(np.median(links.data))


def bare(points, line, gap):
    """[PLACES], how far places on a line are from the nearest point, or from the clamp, beyond what gaps
    between the points explain: a rod with loops where nothing was seen is near all points, too."""
    tree = cKDTree(points)
    s = np.concatenate([[0], np.cumsum(np.hypot(*np.diff(line, axis=0).T))])
    at = (np.arange(PLACES) + 0.5) / PLACES * s[-1]
    places = np.column_stack([np.interp(at, s, column) for column in line.T])
    allowed = max(gap, 0.75 * float(tree.query(line[0])[0]))
    return np.maximum(0, np.minimum(tree.query(places)[0], np.hypot(*(places - line[0]).T)) - allowed)


class Comparison:
    """Residuals of a run. Beside the run they depend on a few numbers of their own, `own`: those of the
    camera, and the times of photographs that have none (as parts of the run)."""

    def __init__(self, measured: Measured):
        self.measured = measured
        pixels = [p.points.numbers for p in measured.photographs if p.points.unit == PIXEL]
        self.camera = Camera(float(np.ptp(np.vstack(pixels), axis=0).max())) if pixels else None
        self.timeless = [p for p in measured.photographs if p.abscissa is None]
        self.read_off = None, {}  # a run, and its angles so far behind the tip
        self.groups: list[str] = []  # of each residual
        self.spacings = {id(p): spacing(p.points.numbers) for p in measured.photographs}
        self.gaps = {id(p): 0.75 * widest_gap(p.points.numbers) + 2 * self.spacings[id(p)]
                     for p in measured.photographs}
        self.hidden: set[int] = set()  # photographs, by their place, in which something lies on the tip
        # of loose ends, in their order: where the last point happens to be is known no better
        self.loose = np.array([self.spacings[id(p)] for p in measured.photographs if not p.ordered])

    def told(self, r: Results, own) -> list[str]:
        """In words, the numbers that were found beside the parameters."""
        words = []
        if self.camera:
            x, y = self.camera.size * np.asarray(own[1:3])
            words.append(f"picture: {self.camera.size * np.exp(own[0]):.5g} px per "
                         f"{'m' if 'si_length' in r.attributes else 'unit of length'}, the clamp at "
                         f"({x:.5g}, {y:.5g}) px, turned by {np.degrees(own[3]):.3g} degrees")
        for p, part in zip(self.timeless, own[len(own) - len(self.timeless):]):
            t = float(np.clip(part, 0, 1)) * r.shapes.t[-1]
            lab = f" ({t * r.scale('time'):.4g} s)" if "si_time" in r.attributes else ""
            words.append(f"{p.source}: best at t = {t:.4g}{lab}")
        return words

    def guess(self, r: Results, own=()):
        """The numbers to begin with, for a run: its last photograph tells the camera, unless it is known
        from before."""
        own = list(own[:Camera.COUNT]) if self.camera else []
        if self.camera and not own:
            last = max((p for p in self.measured.photographs),
                       key=lambda p: np.ptp(p.points.numbers, axis=0).max())
            t = time_of(r, last.abscissa, last.at) if last.abscissa else r.shapes.t[-1]
            own = self.camera.guess(last.points.numbers, self.seen_plain(r, t))
        return np.array(own + [best_time(r, self.plain_points(r, p, own)) for p in self.timeless])

    def sees(self, r, own):
        """Whether a camera can have these numbers, for a run: of points that tell little of it, as of no rod at all, a search
        steps to scales in which the rod is a point, or that no number holds."""
        if not self.camera:
            return True
        rod = own[0] + np.log(r.series.length[-1] * float(r.attributes.get("si_length", 1)))  # its length in pictures, the logarithm
        return bool(abs(rod) < FARTHEST and np.abs(own[1:Camera.COUNT]).max() < np.exp(FARTHEST))

    def seen_plain(self, r, t):
        """The rod in metres, or dimensionless if the run knows none."""
        return shape_at(r, t) * float(r.attributes.get("si_length", 1))

    def plain_points(self, r, p: Photograph, own):
        """Points as the file of a run counts them."""
        points = p.points.numbers
        if self.camera:  # back through the camera, as it is guessed
            points = (points - self.camera.size * np.asarray(own[1:3])) * [1, -1]
            return points / (self.camera.size * np.exp(own[0])) / float(r.attributes.get("si_length", 1))
        return points / r.scale("length") if p.points.si else points

    def line(self, r, p: Photograph, own, view=VIEW):
        """[n, 2], what a photograph should show of a run, in its own unit."""
        if p.abscissa:
            t = time_of(r, p.abscissa, p.at, view)
        else:
            k = (Camera.COUNT if self.camera else 0) + self.timeless.index(p)
            t = np.clip(own[k], 0, 1) * r.shapes.t[-1]
        if self.camera:
            return finer(self.camera.see(self.seen_plain(r, t), own[:Camera.COUNT]))
        return viewed(finer(shape_at(r, t) * (r.scale("length") if p.points.si else 1)), view)

    def of_photograph(self, r, p: Photograph, own, view=VIEW):
        """(distances of its points: of one in order the last is the tip, also along the rod; how far the
        rod goes on beyond points that are not, or they beyond it; where the rod is and no points are; the points' Block)"""
        line = self.line(r, p, own, view)
        gap = self.spacings[id(p)]
        near = nearest(p.points.numbers, line, SLACK * gap)
        found, place, normal = near.distance, near.place, near.normal
        uncovered = bare(p.points.numbers, line, self.gaps[id(p)])
        if not p.ordered:
            end = loose_end(p.points.numbers, line, gap, near.beyond)
            if any(self.measured.photographs[k] is p for k in self.hidden):
                end = min(end, 0.0)
            return found, [end], uncovered, (place, normal, near.other)
        gap, end = p.points.numbers[-1] - line[-1], line[-1] - line[-2]
        end = end / np.hypot(*end)
        across = [-end[1], end[0]]
        return (np.concatenate([found[:-1], [across @ gap, end @ gap]]), [], uncovered,
                (np.append(place, place[-1]), np.vstack([normal[:-1], across, end]),
                 np.append(near.other[:-1], [np.inf, np.inf])))

    def angle(self, r, c: Curve, view=VIEW):
        """[m], an angle of a run where it was measured, in a picture that is turned."""
        if c.behind:
            distance = float(c.behind.numbers) / r.scale("length")
        elif c.name == "tip_angle":
            distance = 0.0
        elif as_text(r.attributes.get("parameters/growth_type", "")) == "apical":
            distance = float(r.attributes["parameters/growth_zone"])
        else:
            raise DataError(f"{c.source}: {c.name}: this scene has no growth zone, at whose base it would be; write how far behind "
                            "the tip it was measured, base angle at 0.6 mm (deg)")
        of, known = self.read_off
        if of is not r:  # several organs, or several columns, may be measured at one place
            of, known = self.read_off = r, {}
        if distance not in known:
            known[distance] = CubicSpline(r.shapes.t, angles_behind(r, distance))
        t = np.clip(time_of(r, c.abscissa, c.at, view), 0, r.shapes.t[-1])
        return known[distance](t) + view["camera_turn"]

    def model(self, r, c: Curve, view=VIEW):
        """[m], a series of a run where it was measured, in the unit of the measurement."""
        if c.name in ANGLES:
            return self.angle(r, c, view)
        if c.name not in r.series:
            raise DataError(f"{c.source}: {c.name} is no series{unknown(c.name, r.series)}")
        unit = r.units[f"series/{c.name}"]
        if c.values.si and c.values.unit != unit:
            raise DataError(f"{c.source}: {c.name} was measured in a unit of something else")
        t = np.clip(time_of(r, c.abscissa, c.at, view), 0, r.series.t[-1])
        factor = in_laboratory(unit, r.scale)[0] if c.values.si else 1
        return factor * PchipInterpolator(r.series.t, r.series[c.name])(t)

    def residuals(self, r: Results, own, view=VIEW) -> np.ndarray:
        """Measured less computed, group by group as in self.groups; self.blocks are then those of the
        residuals whose errors belong together."""
        values, self.groups, self.blocks = [], [], []

        def add(group, numbers):
            first = len(self.groups)
            values.append(numbers)
            self.groups += [group] * len(numbers)
            return np.arange(first, first + len(numbers))

        for p in self.measured.photographs:
            off, end, uncovered, (place, normal, other) = self.of_photograph(r, p, own, view)
            self.blocks.append(Block(LINES, add(LINES, off), place, normal, other))
            add(ENDS, end)
            add(BARE, uncovered)
        organs = Counter(c.name for c in self.measured.curves)
        for c in self.measured.curves:
            rows, angles = add(c.name, c.values.numbers - self.model(r, c, view)), c.name in ANGLES
            self.blocks.append(Block(c.name, rows, c.at.numbers, None, np.full(len(rows), np.inf), angles,
                                     angles and organs[c.name] > 1))
        return np.concatenate(values)

    def find_hidden(self, r: Results, own, view=VIEW):
        """Finds the photographs in which the rod goes on beyond the points, by more than gaps between them explain, if there
        are more of these than by chance: there the tip is hidden, and how far the rod goes on says nothing of it. True if
        there are any."""
        photographs, self.hidden = self.measured.photographs, set()
        loose = [k for k, p in enumerate(photographs) if not p.ordered]
        beyond = {k for k in loose if self.of_photograph(r, photographs[k], own, view)[1][0] > 0}
        if stats.binom.sf(len(beyond) - 1, len(loose), BY_CHANCE) < SURELY:
            self.hidden = beyond
        return bool(self.hidden)

    def spreads(self) -> dict[str, float]:
        """How large what was measured is, by group: the measure of a first guess of its noise."""
        found = {c.name: float(np.ptp(c.values.numbers)) or 1.0 for c in self.measured.curves}
        if self.measured.photographs:
            found[LINES] = float(max(np.ptp(p.points.numbers, axis=0).max()
                                     for p in self.measured.photographs))
        return found

"""Rods from what others measured or drew: a root system traced in a photograph (RSML), a branched line (SWC), and laterals along
a root by the four numbers that root architects give, length to the first, spacing, angle and turn."""

from __future__ import annotations

import re
import xml.etree.ElementTree as xml
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING

import h5py
import numpy as np

from .errors import TendrilError, arguments, number, whole
from .readers import text_of_file
from .spatial import carried
from .units import METRES, PIXELS, quantity, unit_called

if TYPE_CHECKING:
    from pandas import DataFrame

SAMPLES = 4  # of the curvature, for each point of a line
LEAST = 41
NAME = re.compile(r"\W+")


@dataclass
class Line:
    """A root: its points from its base on, in the file's unit, which other one carries it, its mean diameter."""

    name: str
    x: np.ndarray
    carrier: Line | None = None
    diameter: float = np.nan
    at: float = 0.0  # how far along its carrier it begins
    told: str = ""
    curve: tuple = field(default=(), repr=False)


@arguments(carrier="text", name="text?")
def laterals(carrier, n, *, first, apart, angle, turn="137.5deg", delay=None, name=None, **options) -> DataFrame:
    """A table of n rods along another one, for run(rods={"laterals": table}).

    carrier  what that one is called
    first    how far along it the first begins, a number or a text with a unit, "4mm" (CPlantBox: lb)
    apart    from each to the next (ln)
    angle    against the carrier's tangent, "65deg" (theta)
    turn     from each to the next about the carrier
    delay    with `born`, the time at which the first comes out, and `speed` with which the carrier's tip passes on to the next:
             {"born": "2h", "speed": "1mm/h"}; None: all are there from the beginning
    name     what they are called, with a number behind it; None: as the carrier, l1 of tap is tap1
    options  of each; one that is a list has a value for each"""
    from pandas import DataFrame

    n = whole(n, "n", 1)
    at, unit = measured(first, "first")
    step, other = measured(apart, "apart")
    if unit != other:
        raise TendrilError(f"first, apart: in {unit or 'no unit'} and in {other or 'no unit'}; give both in one")
    about, of_angle = measured(turn, "turn")
    table = {"name": [f"{name or carrier}{k + 1}" for k in range(n)], "clamp_on": carrier,
             "clamp_at": [f"{at + k * step:.9g}{unit}" for k in range(n)], "clamp_angle": angle,
             "clamp_azimuth": [f"{k * about % (360 if of_angle == 'deg' else 2 * np.pi):.9g}{of_angle}" for k in range(n)]}
    if delay is not None:
        table["born"] = born(delay, step, unit, n)
    for key, value in options.items():
        if isinstance(value, (list, np.ndarray)) and len(value) != n:
            raise TendrilError(f"{key}: has {len(value)} values for {n} rods; give one for each, or one for all")
        table[key] = value
    return DataFrame(table)


def measured(value, what):
    """(number, unit) of 4, "4mm" or "4 mm"."""
    found = quantity(value)
    if found:
        return found[0], found[1].strip()
    return number(value, what), ""


def born(delay, step, unit, n):
    """When each of n comes out that are `step` apart."""
    if not isinstance(delay, dict) or set(delay) != {"born", "speed"}:
        raise TendrilError('delay: give {"born": when the first comes out, "speed": how fast the tip goes on}')
    start, of_time = measured(delay["born"], "delay: born")
    speed, of_speed = measured(delay["speed"], "delay: speed")
    if speed <= 0:
        raise TendrilError(f"delay: speed: {delay['speed']} is not above 0")
    wanted = f"{unit}/{of_time}" if unit or of_time else ""
    if of_speed != wanted:
        raise TendrilError(f"delay: speed: is in {of_speed or 'no unit'}; give it in {wanted or 'no unit'}, as lengths and times are")
    return [f"{start + k * step / speed:.9g}{of_time}" for k in range(n)]


@arguments(path="file", directory="file?", natural="flag", slides="flag", smooth="number?", least="number")
def rods(path, directory=None, *, length=None, natural=True, slides=False, smooth=None, least=0.0, **options) -> DataFrame:
    """The roots of a file as a table of rods, for run(rods={"roots": table}).

    path       RSML (root system markup, any version, in the plane or in space) or SWC (branched lines)
    directory  where the curvature of each is put, NAME.h5; None: beside the file, in a folder of its name
    length     what 1 is in the scene, "2mm", or a number in the file's unit: the table has numbers. None: it has the file's
               unit, for a scene with -si_ scales
    natural    these shapes are at rest: they are natural curvature (-rod_curvature_file). False: they are the shape at the
               start, -shape_file, of a rod that is straight by nature
    slides     they grow at their tips or are fed (apical, feed): natural curvature goes with the distance from the tip
    smooth     how far a smooth line may be from the points, in the file's unit, root mean square; None: half a pixel where
               the file has pixels, else none
    least      roots shorter than this, in the file's unit, are left out, with what they carry
    options    of each

    A lateral begins at the place of its carrier that is nearest to its first point. In the plane x2 is up: pixels count down.
    table.attrs has `unit`, `diameter` {name: in the file's unit} and `moved` {name: how far a lateral's base was put}."""
    from pandas import DataFrame

    path = Path(path)
    lines, unit, pixels = read(path)
    smooth = 0.5 * pixels if smooth is None else smooth
    lines = kept(lines, least)
    if not lines:
        raise TendrilError(f"{path}: no root is longer than {least:g} {unit}")
    directory = Path(directory) if directory is not None else path.with_suffix("")
    directory.mkdir(parents=True, exist_ok=True)
    factor, suffix = scale_of(length, unit, path)
    rows, moved = [], {}
    for line in lines:
        row, moved[line.name] = row_of(line, path, smooth, factor, suffix)
        write_bends(row, line, natural, slides, directory, factor, suffix)
        rows.append(row | options)
    table = DataFrame(rows)
    table.attrs |= {"unit": unit, "diameter": {line.name: line.diameter for line in lines}, "moved": moved}
    return table


def scale_of(length, unit, path):
    """(factor, unit behind numbers) of what the table has."""
    if length is None:
        if unit not in METRES:
            raise TendrilError(f"{path}: does not say in which unit it is ({unit or 'none'}); give length=, what 1 is in the scene, as a number in it")
        return 1.0, unit
    value, of = measured(length, "length")
    if value <= 0:
        raise TendrilError(f"length: {length} is not above 0")
    if of and (of not in METRES or unit not in METRES):
        raise TendrilError(f"length: {length}: the file is in {unit or 'no unit'}; give a number in that")
    return (METRES[unit] / METRES[of] if of else 1.0) / value, ""


def kept(lines, least):
    """Those that are long enough, and whose carriers are."""
    found = []
    for line in lines:
        if length_of(line.x) > least and (line.carrier is None or any(line.carrier is other for other in found)):
            found.append(line)
    return found


def length_of(x):
    return float(np.linalg.norm(np.diff(x, axis=0), axis=1).sum())


# ---- a line as a rod ----


def row_of(line, path, smooth, factor, suffix):
    """Where a rod begins, where to, and how long it is; and how far its base was put to be on its carrier."""
    row, moved = {"name": line.name}, 0.0
    if line.carrier is not None:
        line.at, place = nearest(line.carrier, line.x[0])
        moved = float(np.linalg.norm(place - line.x[0]))
        if moved > max(0.5 * length_of(line.x), line.carrier.diameter if line.carrier.diameter > 0 else 0):
            raise TendrilError(f"{path}: {line.told} begins {moved:.3g} beside the root that carries it, {line.carrier.told}, more than half of its own length; mend the file")
        line.x = np.vstack([place, line.x[1:]])
    line.curve = curve_of(line, path, smooth)
    s, x, q, _ = line.curve
    if line.carrier is None:
        row["clamp_place"] = tuple(f"{v * factor:.9g}{suffix}" for v in x[0])
    else:
        row |= {"clamp_on": line.carrier.name, "clamp_at": f"{min(line.at, line.carrier.curve[0][-1]) * factor:.9g}{suffix}"}
    row |= {"clamp_direction": tuple(f"{v:.9g}" for v in q[0]), "growth_initial_length": f"{s[-1] * factor:.9g}{suffix}"}
    return row, moved


def nearest(line, point):
    """(how far along a line, place) of what is nearest to a point."""
    s, x, *_ = line.curve
    k = int(np.argmin(np.linalg.norm(x - point, axis=1)))
    best = (np.inf, 0.0, x[0])
    for i in (k - 1, k):
        if 0 <= i < len(x) - 1:
            edge = x[i + 1] - x[i]
            part = float(np.clip((point - x[i]) @ edge / (edge @ edge), 0, 1))
            place = x[i] + part * edge
            best = min(best, (float(np.linalg.norm(place - point)), float(s[i] + part * (s[i + 1] - s[i])), place), key=lambda b: b[0])
    return best[1:]


def curve_of(line, path, smooth):
    """(arc length, places, tangents, their slope but for its part along) along a smooth line through the points, or by them."""
    from scipy.interpolate import BSpline, CubicSpline, make_interp_spline, splprep

    x = line.x[np.append(True, np.linalg.norm(np.diff(line.x, axis=0), axis=1) > 0)]
    if len(x) < 2:
        raise TendrilError(f"{path}: {line.told} has {len(x)} point; a root has two at least")
    u = np.append(0, np.cumsum(np.linalg.norm(np.diff(x, axis=0), axis=1)))
    if smooth > 0 and len(x) > 4:
        weight = np.ones(len(x))
        weight[0] = 1e3  # where it is carried
        (knots, c, k), _ = splprep(x.T, w=weight, u=u, s=len(x) * smooth**2)
        curve = BSpline(knots, np.array(c).T, k)
    else:
        curve = CubicSpline(u, x) if len(x) > 2 else make_interp_spline(u, x, k=1)
    z = np.linspace(0, u[-1], max(LEAST, SAMPLES * len(x)) * 4 + 1)
    speed = np.linalg.norm(curve(z, 1), axis=1)
    s = np.append(0, np.cumsum((speed[1:] + speed[:-1]) / 2 * np.diff(z)))
    even = np.interp(np.linspace(0, s[-1], max(LEAST, SAMPLES * len(x))), s, z)
    q, speed = curve(even, 1), np.linalg.norm(curve(even, 1), axis=1)[:, None]
    return np.linspace(0, s[-1], len(even)), curve(even), q / speed, curve(even, 2) / speed**2


def first_across(q):
    """d2 where a clamp points along q: e2, turned as e1 is turned into q on the shortest way (src/scene/space.c)."""
    if q[2] == 0:
        return np.array([-q[1], q[0], 0.0])
    if q[0] < -1 + 1e-12:
        return np.array([0.0, -1.0, 0.0])
    across = np.array([0.0, -q[2], q[1]])  # e1 x q
    e2 = np.array([0.0, 1.0, 0.0])
    return e2 + np.cross(across, e2) + np.cross(across, np.cross(across, e2)) / (1 + q[0])


def write_bends(row, line, natural, slides, directory, factor, suffix):
    """The bends of a rod about axes that are carried along it without a turn about it, as a file that its options name."""
    s, x, q, slope = line.curve
    d2, _ = carried(x, first_across(q[0]), q)
    bends = [-(slope * np.cross(q, d2)).sum(1) / factor, (slope * d2).sum(1) / factor]
    file = (directory / f"{line.name}.h5").resolve()
    with h5py.File(file, "w") as f:
        if natural and slides:
            f["distance"], bends = s * factor, [bend[::-1] for bend in bends]
        else:
            f["s"] = s / s[-1]
        for name, values in zip(("curvature_2", "curvature") if natural else ("u2", "u3"), bends):
            f[name] = values
        for name in f if suffix else ():
            if name != "s":
                f[name].attrs["units"] = suffix if name == "distance" else f"1/{suffix}"
    row |= {"rod_curvature_file": str(file), "shape_type": "straight"} if natural else {"shape_type": "file", "shape_file": str(file)}


# ---- readers ----


def read(path):
    """([Line], unit, how long a pixel is or 0): carriers before what they carry."""
    text = text_of_file(path)
    if re.search(r"<\s*rsml\b", text):
        return read_rsml(path, text)
    if path.suffix.lower() == ".swc" or re.search(r"^\s*\d+\s+-?\d+(\s+[-+.\deE]+){4}\s+-?\d+\s*$", text, re.M):
        return read_swc(path, text)
    raise TendrilError(f"{path}: is neither RSML nor SWC")


def read_rsml(path, text):
    try:
        top = xml.fromstring(re.sub(r"<!DOCTYPE[^>]*>", "", text))
    except xml.ParseError as error:
        raise TendrilError(f"{path}: is not whole: {error}") from None
    for element in top.iter():
        element.tag = element.tag.split("}")[-1]
    unit, resolution = (top.findtext(f"metadata/{key}", "").strip() for key in ("unit", "resolution"))
    pixel = pixel_of(path, resolution)
    unit = unit_called(unit, "length") or unit
    if unit.lower() in PIXELS:
        unit = "px"
    lines = []
    for plant in top.iter("plant"):
        for root in plant.findall("root"):
            gather(path, root, None, lines, 1 / pixel if pixel and unit in METRES else 1.0)
    if not lines:
        raise TendrilError(f"{path}: has no root with a polyline")
    name_all(lines)
    return lines, unit, 1 / pixel if pixel and unit in METRES else 1.0 if unit == "px" else 0.0


def pixel_of(path, resolution):
    """How many pixels a unit has; 0: the file does not say."""
    if not resolution:
        return 0.0
    try:
        value = float(resolution)
    except ValueError:
        raise TendrilError(f"{path}: metadata/resolution: {resolution!r} is no number") from None
    return value if value > 0 and value != 1 else 0.0


def gather(path, root, carrier, lines, factor):
    """A root and those that it carries."""
    label = root.get("label") or root.get("ID") or root.get("id") or f"root {len(lines) + 1}"
    points = [[p.get(key) for key in "xyz"] for p in root.findall("geometry/polyline/point")]
    if not points:
        raise TendrilError(f"{path}: root {label}: has no geometry/polyline/point")
    flat = all(p[2] is None for p in points)
    try:
        x = np.array([[float(v) for v in (p[:2] + [p[2] or 0])] for p in points]) * factor
    except (TypeError, ValueError):
        raise TendrilError(f"{path}: root {label}: a point without x and y, or one that is no number") from None
    if not np.isfinite(x).all():
        raise TendrilError(f"{path}: root {label}: a point that is no number")
    if flat:
        x[:, 1] *= -1
    thick = [float(s.get("value") or s.text or "nan") for f in root.findall("functions/function") if f.get("name") == "diameter" for s in f.iter("sample")]
    line = Line(label, x, carrier, float(np.mean(thick)) * factor if thick else np.nan, told=f"root {label}")
    lines.append(line)
    for child in root.findall("root"):
        gather(path, child, line, lines, factor)


def name_all(lines):
    """Names that options can have: letters and digits, each once."""
    used = set()
    for k, line in enumerate(lines):
        name = NAME.sub("", line.name.replace("_", ""))
        if not name or not name[0].isalpha() or len(name) > 24:
            name = f"root{k + 1}"
        while name in used:
            name += "x"
        used.add(name)
        line.name = name


def read_swc(path, text):
    """Points with their parents; where it branches, the longest way goes on, others are laterals."""
    points = {}
    for k, line in enumerate(text.splitlines(), 1):
        words = line.split("#")[0].split()
        if not words:
            continue
        try:
            index, _, x, y, z, r, parent = (float(w) for w in words[:7])
        except ValueError:
            raise TendrilError(f"{path}, line {k}: is not of seven numbers: n, type, x, y, z, radius, parent") from None
        if int(parent) >= 0 and int(parent) not in points:
            raise TendrilError(f"{path}, line {k}: its parent {int(parent)} does not stand before it")
        points[int(index)] = (np.array([x, y, z]), r, int(parent) if parent >= 0 else None)
    if not points:
        raise TendrilError(f"{path}: has no point")
    return split(points), "um", 0.0


def split(points):
    """Lines of a tree."""
    children, reach = {index: [] for index in points}, {}
    for index, (_, _, parent) in points.items():
        if parent is not None:
            children[parent].append(index)
    for index in reversed(points):  # from the ends on
        reach[index] = max((reach[c] + np.linalg.norm(points[c][0] - points[index][0]) for c in children[index]), default=0.0)
    lines, open_ = [], [(index, None, None) for index, point in points.items() if point[2] is None]
    while open_:
        index, fork, carrier = open_.pop(0)
        way = [index] if fork is None else [fork, index]
        beside = []
        while children[way[-1]]:
            onward = sorted(children[way[-1]], key=lambda c: -reach[c] - np.linalg.norm(points[c][0] - points[way[-1]][0]))
            beside += [(c, way[-1]) for c in onward[1:]]
            way.append(onward[0])
        if len(way) > 1:
            line = Line(f"p{way[1]}", np.array([points[i][0] for i in way]), carrier, 2 * float(np.mean([points[i][1] for i in way])), told=f"the line from point {way[0]}")
            lines.append(line)
            open_ += [(c, at, line) for c, at in beside]
    name_all(lines)
    return lines

"""Centre lines with a radius along them, from what others write: VMTK (.vtp, .vtk, .dat), lines of OBJ, 3D Slicer (markups
.json, .fcsv, .csv), tables x, y, z, r, well surveys (measured depth, inclination, azimuth; or north, east, TVD)."""

import json
import re
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from .chains import joined
from .errors import TendrilError
from .meshes import SurfaceError, polydata
from .readers import Row, heading, is_undefined, line_of, rows_and_comments, text_of_file
from .tables import Wanted, body_of, factor, in_unit, length_said, named, under, unit_behind
from .units import METRES, unit_called

# names of columns, in small letters without their units
PLACES = (("x1", "x2", "x3"), ("x", "y", "z"), ("l", "p", "s"), ("px", "py", "pz"), ("r", "a", "s"), ("points 0", "points 1", "points 2"))
RADII = ("radius", "maximuminscribedsphereradius", "inner radius", "r")
DIAMETERS = ("diameter", "diam", "inner diameter", "hole diameter", "hole size", "bore")
DEPTHS = ("md", "measured depth", "meas depth", "depth", "dept")
INCLINATIONS = ("inclination", "inc", "incl", "deviation", "drift angle", "devi", "hole inclination")
AZIMUTHS = ("azimuth", "azi", "azim", "az", "azm", "hole azimuth", "hazi", "drift direction", "bearing")
NORTHS = ("north", "northing", "n/s", "n/-s", "+n/-s", "ns", "n-s", "n(+)/s(-)", "northings", "n", "local north")
EASTS = ("east", "easting", "e/w", "e/-w", "+e/-w", "ew", "e-w", "e(+)/w(-)", "eastings", "e", "local east")
DOWNS = ("tvd", "true vertical depth", "vertical depth", "tvdss", "true vertical", "vertical")
UPS = ("z", "elevation", "elev", "altitude")
TURN = np.radians(2)  # of a survey's arc from one point to the next, at most
BESIDE = 1e-6  # of a survey's length: how far from its path the spline of the tube may lead
HALVINGS = 12  # of its steps, at most
GROWS = 1.5  # from one step to the next, where a piece of long ones follows
ENDS = (".vtp", ".vtk", ".obj", ".json", ".fcsv", ".csv", ".tsv", ".tab", ".dat", ".txt", ".asc", ".dev", ".xlsx")
SYSTEMS = {"0": "RAS", "1": "LPS", "2": "IJK"}  # as 3D Slicer counts them

WANTED = {
    "depth": Wanted("length", DEPTHS), "inclination": Wanted("angle", INCLINATIONS), "azimuth": Wanted("angle", AZIMUTHS),
    "north": Wanted("length", NORTHS), "east": Wanted("length", EASTS), "down": Wanted("length", (*DOWNS, *DEPTHS)),
    "up": Wanted("length", UPS), "radius": Wanted("length", RADII[:-1]), "r": Wanted("length", RADII[-1:]),
    "diameter": Wanted("length", DIAMETERS), "defined": Wanted("", ("defined",)),
    **{f"{k}{d}": Wanted("length", (name,)) for k, names in enumerate(PLACES) for d, name in enumerate(names)}}
SURVEY = ("depth", "inclination", "azimuth")
# what makes a path, the first that is there
PATHS = (SURVEY, *(tuple(f"{k}{d}" for d in range(3)) for k in range(len(PLACES))), ("north", "east", "down"), ("north", "east", "up"))


@dataclass
class CentreLine:
    """A line through points, [n, 4]: x, y, z, r, and its unit; NaN where it says no radius."""

    points: np.ndarray
    unit: str = ""  # of length, by tendril's name or, if it has none, the file's; "": none is said
    notes: list[str] = field(default_factory=list)


def read_line(path, line=0, radius=None, foreign=False):
    """The centre line of a file; of a file with several lines, that one.

    radius   of a path that says none, or another; in the unit of the file
    foreign  units of length that are not known are taken as they are"""
    path = Path(path)
    if not path.is_file():
        raise SurfaceError(f"{path}: no such file")
    kind = path.suffix.lower()
    if kind not in ENDS:
        raise SurfaceError(f"{path}: a centre line is {', '.join(end[1:].upper() for end in ENDS)}")
    try:
        if kind in (".vtp", ".vtk"):
            found = from_vtk(path, line)
        elif kind == ".obj":
            found = from_obj(path, line)
        elif kind == ".json":
            found = from_slicer(path, line)
        else:
            if line:
                raise SurfaceError(f"{path}: has one line, counted from 0: there is no {line}")
            found = from_fcsv(path, radius is None) if kind == ".fcsv" else from_table(path, radius is None, foreign)
    except TendrilError as error:
        raise error if isinstance(error, SurfaceError) else SurfaceError(str(error)) from None
    if found.unit and not unit_called(found.unit, "length") and not foreign:
        raise SurfaceError(f"{path}: is in {found.unit}, no unit of length that tendril knows; give --scale, what 1 {found.unit} is in "
                           "the unit of the result")
    found.unit = unit_called(found.unit, "length") or found.unit
    found.points = checked(path, found.points, radius)
    return found


def in_units(line, unit, scale, source):
    """(what the path is multiplied by, the unit of the result): of a file that names its unit, that of `unit`, or else the
    file's own; a scale that says another is refused. With a scale and no unit the result has none."""
    if not line.unit:
        return scale or 1.0, unit
    if not unit:
        if scale:
            line.notes.append(f"{source}: is in {line.unit}; times {scale:g} it is of no unit")
            return scale, ""
        line.notes.append(f"{source}: is in {line.unit}, and so is the result")
        return 1.0, line.unit
    if line.unit not in METRES:
        line.notes.append(f"{source}: is in {line.unit}, of which 1 is {scale:g} {unit} by scale")
        return scale, unit
    by_units = METRES[line.unit] / METRES[unit]
    if scale and abs(scale / by_units - 1) > 1e-3:
        raise SurfaceError(f"{source}: is in {line.unit}, of which 1 is {by_units:g} {unit}, not {scale:g}; leave scale out, or unit")
    if line.unit != unit:
        line.notes.append(f"{source}: is in {line.unit}, of which 1 is {by_units:g} {unit}")
    return by_units, unit


def checked(path, x, radius):
    """Points that are a path."""
    if not len(x):
        raise SurfaceError(f"{path}: a path needs two points at least")
    if radius is not None:
        x[:, 3] = float(radius)
    if np.isnan(x[:, 3]).all():
        raise SurfaceError(f"{path}: says no radius; give radius")
    if not np.isfinite(x).all():
        raise SurfaceError(f"{path}: point {int(np.argmin(np.isfinite(x).all(axis=1))) + 1} is not finite")
    moved = np.linalg.norm(np.diff(x[:, :3], axis=0), axis=1) > 1e-9 * np.ptp(x[:, :3], axis=0).max()
    x = x[np.concatenate([[True], moved])]
    if len(x) < 2:
        raise SurfaceError(f"{path}: a path needs two points at least")
    if not (x[:, 3] > 0).all():
        raise SurfaceError(f"{path}: point {int(np.argmin(x[:, 3] > 0)) + 1}: the radius must be above 0")
    return x


def with_radius(x, r=None):
    x = np.asarray(x, float).reshape(-1, 3)
    return np.column_stack([x, np.full(len(x), np.nan) if r is None else np.broadcast_to(r, len(x)).astype(float)])


def chosen(path, x, cells, line):
    """(one of the lines through points [n, 3] that pieces of indices make, what is said of them)."""
    if not np.isfinite(x).all():
        raise SurfaceError(f"{path}: point {int(np.argmin(np.isfinite(x).all(axis=1))) + 1} is not finite")
    lines = joined(x, cells)
    if not lines:
        raise SurfaceError(f"{path}: has no line of two points")
    if not 0 <= line < len(lines):
        raise SurfaceError(f"{path}: has {len(lines)} line{'s' if len(lines) > 1 else ''}, counted from 0: there is no {line}")
    notes = []
    if len(cells) != len(lines):
        notes.append(f"{path}: {len(cells)} pieces that share end points are {len(lines)} line{'s' if len(lines) > 1 else ''}")
    if len(lines) > 1:
        sizes = ", ".join(f"{k}: {len(one)}" for k, one in enumerate(lines[:12])) + (", ..." if len(lines) > 12 else "")
        notes.append(f"{path}: has {len(lines)} lines (points of each: {sizes}); line {line} is taken, --line for another")
    return lines[line], notes


def from_vtk(path, line):
    data = polydata(path)
    from vtkmodules.util.numpy_support import vtk_to_numpy

    lines = data.GetLines()
    if not lines or not lines.GetNumberOfCells():
        raise SurfaceError(f"{path}: has no line in it; is it a mesh?")
    offsets = vtk_to_numpy(lines.GetOffsetsArray())
    ids = vtk_to_numpy(lines.GetConnectivityArray())
    x = vtk_to_numpy(data.GetPoints().GetData()).astype(float)
    cells = [ids[a:b] for a, b in zip(offsets[:-1], offsets[1:])]
    along, notes = chosen(path, x, cells, line)
    arrays = data.GetPointData()
    r, unit = None, ""
    for k in range(arrays.GetNumberOfArrays()):
        said = unit_behind(arrays.GetArrayName(k) or "", RADII, "length")
        if said is not None and arrays.GetArray(k) is not None:
            r, unit = vtk_to_numpy(arrays.GetArray(k))[along], said
    return CentreLine(with_radius(x[along], r), unit, notes)


def is_line(path):
    """Whether an OBJ file has lines and no faces."""
    lines = False
    with open(path, encoding="utf-8", errors="replace") as file:
        for text in file:
            if re.match(r"\s*f\s", text):
                return False
            lines = lines or bool(re.match(r"\s*l\s", text))
    return lines


def from_obj(path, line):
    """Vertices and the elements `l 1 2 3`, counted from 1 or, if negative, back from the last vertex."""
    x, cells, unit = [], [], ""
    text = text_of_file(path).replace("\\\n", " ")
    for number, words in enumerate(text.splitlines()):
        key, *rest = words.split() or [""]
        try:
            if key == "v":
                x.append([float(word) for word in rest[:3]])
                if len(x[-1]) < 3:
                    raise ValueError
            elif key == "l":
                ends = [int(word.split("/")[0]) for word in rest]
                cells.append([k - 1 if k > 0 else len(x) + k for k in ends])
            elif key.startswith("#"):
                unit = unit or length_said(words) or ""
        except ValueError:
            raise SurfaceError(f"{path}, line {number + 1}: {words.strip()}: is no {'vertex' if key == 'v' else 'line'} of an OBJ file"
                               ) from None
    if not cells:
        raise SurfaceError(f"{path}: has no line in it, l 1 2; is it a mesh?")
    if any(not 0 <= k < len(x) for cell in cells for k in cell):
        raise SurfaceError(f"{path}: a line ends at a vertex that is not there")
    x = np.array(x, float)
    along, notes = chosen(path, x, cells, line)
    return CentreLine(with_radius(x[along]), unit, notes)


# ---- 3D Slicer ----


def word_of(unit):
    """A unit of the markups: "mm", or ["mm", "UCUM", "millimeter"]."""
    unit = unit[0] if isinstance(unit, (list, tuple)) and unit else unit
    return "" if unit in (None, "") or not isinstance(unit, str) else unit


def system_note(path, system):
    """What is said of the axes."""
    name = SYSTEMS.get(str(system).strip(), str(system).strip().upper())
    if name == "IJK":
        raise SurfaceError(f"{path}: is counted in voxels (IJK); save it in LPS or RAS")
    if name == "RAS":
        return [f"{path}: is in RAS, and so is the result; in LPS, as Slicer's meshes are, x and y have the other sign"]
    return []


def unplaced_note(path, count):
    return [f"{path}: not used: {count} point{'s' if count > 1 else ''} not placed"] if count else []


def from_slicer(path, line):
    try:
        markups = json.loads(text_of_file(path))["markups"]
        if not isinstance(line, int) or not 0 <= line < len(markups):
            raise SurfaceError(f"{path}: has {len(markups)} lines, counted from 0: there is no {line}")
        curve = markups[line]
        points = list(curve["controlPoints"])
        placed = [str(p.get("positionStatus", "defined")).lower() == "defined" for p in points]
        radii, unit = radii_of(path, curve, placed)
    except (ValueError, KeyError, TypeError, IndexError, AttributeError, RecursionError):
        raise SurfaceError(f"{path}: is no curve of 3D Slicer's markups, with controlPoints that have a position each") from None
    x = [place_of(path, k, p) for k, (p, there) in enumerate(zip(points, placed)) if there]
    notes = unplaced_note(path, placed.count(False)) + system_note(path, curve.get("coordinateSystem", "LPS"))
    if len(markups) > 1:
        notes.append(f"{path}: has {len(markups)} lists of points; {line} is taken, --line for another")
    if str(curve.get("type", "")).lower() == "closedcurve":
        notes.append(f"{path}: is a closed curve, read from its first point to its last")
    own = word_of(curve.get("coordinateUnits"))
    if radii is not None and own and unit:
        radii = radii * factor(unit_called(unit, "length") or unit, unit_called(own, "length") or own, path)
    return CentreLine(with_radius(x, radii), own or unit, notes)


def place_of(path, k, point):
    try:
        x = np.array(point["position"], float)
        if x.shape == (3,):
            return x
    except (ValueError, KeyError, TypeError):
        pass
    raise SurfaceError(f"{path}: control point {k + 1} has no position of three numbers")


def radii_of(path, curve, placed):
    """(the radii at the points that are placed, their unit) of a measurement; (None, "")."""
    r, unit = None, ""
    for measurement in curve.get("measurements") or []:
        said = unit_behind(str(measurement.get("name", "")), RADII, "length")
        if said is not None and measurement.get("controlPointValues"):
            r, unit = np.array(measurement["controlPointValues"], float), said or word_of(measurement.get("units"))
    if r is None:
        return None, ""
    if len(r) == len(placed):
        return r[np.array(placed, bool)], unit
    if len(r) != placed.count(True):
        raise SurfaceError(f"{path}: has {placed.count(True)} points and {len(r)} radii")
    return r, unit


def from_fcsv(path, with_radii):
    """Slicer's old lists: comments say the columns and the axes."""
    rows, notes, comments = rows_and_comments(path)
    said = {key.strip().lower(): value for key, _, value in (text.partition("=") for _, text in comments)}
    names = [name.strip().lower() for name in said.get("columns", "id,x,y,z").split(",")]
    if not {"x", "y", "z"} <= set(names):
        raise SurfaceError(f"{path}: its columns are {', '.join(names)}: a path needs x, y, z")
    kept = []
    for row in rows:
        cells = dict(zip(names, row))
        status = cells.get("positionstatus", row[14].strip() if "positionstatus" not in names and len(row) > 15 else "2")
        if status in ("2", "defined", "") and not is_undefined(cells.get("defined", "1")) \
                and any(cells.get(name, "").strip() for name in "xyz"):
            kept.append(Row([cells.get(name, "") for name in (*"xyz", "radius")], line_of(row)))
    wide = any(row[3].strip() for row in kept)
    given = [Row([*"xyz", "radius" if wide else ""]), *kept], notes, []
    line = from_table(path, with_radii and wide, False, given)
    line.unit = said.get("coordinateunits", "").strip()
    line.notes += unplaced_note(path, len(rows) - len(kept)) + system_note(path, said.get("coordinatesystem", "RAS"))
    return line


# ---- tables ----


def of_path(found):
    return next((names for names in PATHS if all(name in found for name in names)
                 and len({found[name].index for name in names}) == len(names)), None)


def from_table(path, with_radii, foreign, given=None):
    """given: rows, notes and comments, if the file has been read."""
    wanted = WANTED if with_radii else {what: w for what, w in WANTED.items() if what not in ("radius", "r", "diameter")}
    # only what is used is read: names are looked for twice
    kept = {}

    def enough(found):
        names = of_path(found)
        if names is None:
            return False
        used = {found[name].index for name in names}
        width = next((what for what in ("radius", "r", "diameter") if what in found and found[what].index not in used), None)
        kept.update(names=names, width=width)
        for what in [*found]:
            if what not in (*names, width, "defined"):
                del found[what]
        return True

    table, rest = named(path, wanted, enough, foreign, given)
    if table is None:
        return from_table(path, with_radii, foreign, unnamed(path, *rest))
    names, width = kept["names"], kept["width"]
    lengths = [name for name in (*names, width) if name and wanted[name].kind == "length"]
    values, unit = table.lengths(lengths, path)
    value = dict(zip(lengths, values.T))
    r = None if width is None else value[width] / (2 if width == "diameter" else 1)
    if width == "diameter":
        table.notes.append(f"{path}: the radius is half of {table.columns[width].name}")
    there = np.ones(len(values), bool)
    if table.has("defined"):
        there = np.array([not is_undefined(cell) for cell in table.numbers("defined")], bool)
        table.notes += unplaced_note(path, int(np.count_nonzero(~there)))
    if not there.any():
        raise SurfaceError(f"{path}: a path needs two points at least, there is none below the names")
    if names == SURVEY:
        i, a = (table.numbers(name) * in_unit(table.columns[name].unit or "deg", "angle") for name in names[1:])
        x, r = minimum_curvature(path, table, value["depth"], i, a, r)
    else:
        x = np.column_stack([value[name] for name in names])[there]
        r = None if r is None else r[there]
        if names[-1] == "down":
            x[:, 2] = 0 - x[:, 2]
        if names[0] == "north":
            table.notes.append(f"{path}: from {', '.join(table.columns[name].name for name in names)}: x is north, y east, z up")
    return CentreLine(with_radius(x, r), unit, table.notes)


def unnamed(path, rows, notes, comments):
    """Rows of three or four columns of numbers without names, with these above them."""
    first, full = body_of(rows)
    named = next((row for row in reversed(rows[:first]) if sum(bool(cell.strip()) for cell in row) > 1), None)
    if named or not full:
        names = [heading(cell)[0] for cell in named or rows[0] if cell.strip()]
        raise SurfaceError(f"{path}: columns {', '.join(names)}: a path needs x, y, z (and r), a survey measured depth, inclination "
                           "and azimuth, or north, east and TVD")
    if len(full) not in (3, 4):
        raise SurfaceError(f"{path}: has {len(full)} columns without names; give x, y, z and r above them")
    return under("xyzr", rows), notes, comments


def minimum_curvature(path, table, depth, i, a, radius):
    """The path of a survey: arcs of circles from station to station, with angles against the vertical and
    from north; x is north, y east, z up."""
    if (np.diff(depth) <= 0).any():
        k = int(np.argmax(np.diff(depth) <= 0))
        raise SurfaceError(f"{path}, line {table.lines[k + 1]}: measured depth must increase, {depth[k + 1]:g} does not after "
                           f"{depth[k]:g}")
    if (np.abs(i) > np.pi).any():
        k = int(np.argmax(np.abs(i) > np.pi))
        raise SurfaceError(f"{path}, line {table.lines[k]}: {np.degrees(i[k]):g} degrees is no inclination, which is 0 to 180")
    t = np.column_stack([np.sin(i) * np.cos(a), np.sin(i) * np.sin(a), -np.cos(i)])
    angles = np.arctan2(np.linalg.norm(np.cross(t[:-1], t[1:]), axis=1), np.einsum("kd,kd->k", t[:-1], t[1:]))
    lengths = np.diff(depth)
    parts = graded(lengths, np.maximum(1, np.ceil(angles / TURN)).astype(int), angles > 1e-9)
    stations = np.cumsum([np.zeros(3), *(arc(*piece, 1.0) for piece in zip(t, t[1:], angles, lengths))], axis=0)

    def place(s):
        k = np.clip(np.searchsorted(depth, s, side="right") - 1, 0, len(lengths) - 1)
        return stations[k] + arc(t[k], t[k + 1], angles[k], lengths[k], (s - depth[k]) / lengths[k])

    between = (depth[k] + part[part < 1 - 1e-9] * lengths[k] for k, part in enumerate(parts))  # the stations are there as they are
    s = followed(np.sort(np.concatenate([depth, *between])), lambda s: np.array([place(one) for one in s]))
    return np.array([place(one) for one in s]), None if radius is None else np.interp(s, depth, radius)


def arc(one, other, angle, long, part):
    """Where an arc of a circle leads up to a part of its length; its direction turns evenly from one to the other."""
    if angle < 1e-12:
        return part * long * one
    first, last = np.cos((1 - part) * angle) - np.cos(angle), 1 - np.cos(part * angle)
    return long / (angle * np.sin(angle)) * (first * one + last * other)


def followed(s, place):
    """Depths between which the spline of the tube through their places keeps to the path: steps where it does not are halved.
    Where a straight piece goes over into an arc the spline swings to either side, by about a fiftieth of the step squared over
    the arc's radius: a well of 500 ft straight down, then 2 degrees in 500 ft, was 3 inches beside itself."""
    from scipy.interpolate import CubicSpline

    parts = np.array([0.25, 0.5, 0.75])
    for _ in range(HALVINGS):
        x = place(s)
        u = np.concatenate([[0], np.cumsum(np.linalg.norm(np.diff(x, axis=0), axis=1))])
        path = CubicSpline(u, x)
        at = u[:-1, None] + np.diff(u)[:, None] * parts
        along = path(at, 1)
        off = path(at) - place((s[:-1, None] + np.diff(s)[:, None] * parts).ravel()).reshape(*at.shape, 3)
        off -= (off * along).sum(axis=-1, keepdims=True) / (along**2).sum(axis=-1, keepdims=True) * along
        wide = np.linalg.norm(off, axis=-1).max(axis=1) > BESIDE * (s[-1] - s[0])
        if not wide.any():
            break
        s = np.sort(np.concatenate([s, 0.5 * (s[:-1] + s[1:])[wide]]))
    return s


def graded(lengths, steps, bent):
    """Of each piece of a path the parts of it, up to 1, at which there are points: so many even steps, and beside a bent piece of
    shorter steps some that grow from these. For the tube is a spline through the points, and where a long step follows on a short one it
    swings: beside an arc in steps of 10 ft a straight piece of 800 ft as one step was 78 ft off."""
    even, found = lengths / steps, []
    for k, long in enumerate(lengths):
        at = list(np.arange(1, steps[k] + 1) * even[k])
        ends = [(even[j], back) for j, back in ((k - 1, False), (k + 1, True)) if 0 <= j < len(even) and bent[j] and even[j] < even[k]]
        room = even[k] * (0.5 if steps[k] == 1 and len(ends) == 2 else 0.8)  # from either end
        for step, back in ends:
            reached = step
            while reached < room:
                at.append(long - reached if back else reached)
                step *= GROWS
                reached += step
        found.append(np.array(sorted(at)) / long)
    return found


EMPTY = 1000  # knots a point at most: those without a point near them go anyway


def fair(x, every=None):
    """A smooth path through points that are closer than a quarter of the radius and so say more of their
    own noise than of the tube: least squares, knots a radius apart or `every`. Returns points on it,
    and how far it is from those given, along the path and in the radius."""
    from scipy.interpolate import make_lsq_spline

    steps = np.linalg.norm(np.diff(x[:, :3], axis=0), axis=1)
    r = np.median(x[:, 3])
    if every is None and np.median(steps) >= r / 4:
        return x, 0.0
    every = every or r
    u = np.concatenate([[0], np.cumsum(steps)])
    inner = max(1, int(round(min(u[-1] / every, EMPTY * len(u)))))
    knots = np.linspace(0, u[-1], inner + 1)
    kept = [0] + [k for k in range(1, inner) if np.any((u > knots[k - 1]) & (u < knots[k + 1]))] + [inner]
    knots = knots[kept]
    if len(u) < len(knots) + 3:
        return x, 0.0
    try:
        spline = make_lsq_spline(u, x, np.concatenate([[0] * 3, knots, [u[-1]] * 3]))
    except (ValueError, np.linalg.LinAlgError):
        return x, 0.0
    if not np.isfinite(spline.c).all():  # points lie so that they do not tell it
        return x, 0.0
    moved = np.linalg.norm((spline(u) - x)[:, :3], axis=1)
    points = spline(np.linspace(0, u[-1], 4 * len(knots) - 3))
    return points, float(max(moved.max(), np.abs(spline(u) - x)[:, 3].max()))

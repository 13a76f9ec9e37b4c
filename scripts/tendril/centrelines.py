"""Centre lines with a radius along them, from what others write: VMTK (.vtp, .vtk, .dat), 3D Slicer (markups
.json, .csv), tables x, y, z, r, well surveys (measured depth, inclination, azimuth)."""

import json
import re
from pathlib import Path

import numpy as np

from .meshes import SurfaceError, polydata

# names of columns, in small letters without their units
PLACES = (("x1", "x2", "x3"), ("x", "y", "z"), ("l", "p", "s"), ("px", "py", "pz"), ("r", "a", "s"))
RADII = ("radius", "r", "maximuminscribedsphereradius")
DEPTHS = ("md", "measured depth", "measured_depth", "depth")
INCLINATIONS = ("inclination", "inc", "incl")
AZIMUTHS = ("azimuth", "azi", "azim")
TURN = np.radians(2)  # of a survey's arc from one point to the next, at most


def read_line(path, line=0, radius=None):
    """[n, 4]: x, y, z, r; of a file with several lines, that one."""
    path = Path(path)
    if not path.is_file():
        raise SurfaceError(f"{path}: no such file")
    kind = path.suffix.lower()
    if kind in (".vtp", ".vtk"):
        x, r = from_vtk(path, line)
    elif kind == ".json":
        x, r = from_slicer(path, line)
    elif kind in (".csv", ".dat", ".txt"):
        x, r = from_table(path)
    else:
        raise SurfaceError(f"{path}: a centre line is VTP, VTK, JSON, CSV or DAT")
    if radius is not None:
        r = np.full(len(x), float(radius))
    if r is None:
        raise SurfaceError(f"{path}: says no radius; give radius")
    x = np.column_stack([x, np.broadcast_to(r, len(x))]).astype(float)
    if not np.isfinite(x).all():
        raise SurfaceError(f"{path}: point {int(np.argmin(np.isfinite(x).all(axis=1))) + 1} is not finite")
    moved = np.linalg.norm(np.diff(x[:, :3], axis=0), axis=1) > 1e-9 * np.ptp(x[:, :3], axis=0).max()
    x = x[np.concatenate([[True], moved])]
    if len(x) < 2:
        raise SurfaceError(f"{path}: a path needs two points at least")
    if not (x[:, 3] > 0).all():
        raise SurfaceError(f"{path}: point {int(np.argmin(x[:, 3] > 0)) + 1}: the radius must be above 0")
    return x


def from_vtk(path, line):
    data = polydata(path)
    from vtkmodules.util.numpy_support import vtk_to_numpy

    lines = data.GetLines()
    if not lines or not lines.GetNumberOfCells():
        raise SurfaceError(f"{path}: has no line in it; is it a mesh?")
    if not 0 <= line < lines.GetNumberOfCells():
        raise SurfaceError(f"{path}: has {lines.GetNumberOfCells()} lines, counted from 0: there is no {line}")
    offsets = vtk_to_numpy(lines.GetOffsetsArray())
    ids = vtk_to_numpy(lines.GetConnectivityArray())[offsets[line]:offsets[line + 1]]
    arrays = data.GetPointData()
    r = None
    for k in range(arrays.GetNumberOfArrays()):
        if (arrays.GetArrayName(k) or "").lower() in RADII:
            r = vtk_to_numpy(arrays.GetArray(k))[ids]
    return vtk_to_numpy(data.GetPoints().GetData()).astype(float)[ids], r


def from_slicer(path, line):
    try:
        markups = json.loads(path.read_text())["markups"]
        curve = markups[line]
        points = curve["controlPoints"]
        x = np.array([p["position"] for p in points], float).reshape(len(points), 3)
    except (ValueError, KeyError, TypeError, IndexError) as error:
        raise SurfaceError(f"{path}: is no curve of 3D Slicer's markups: {error!r}") from None
    r = None
    for measurement in curve.get("measurements", []):
        if measurement.get("name", "").lower() in RADII and measurement.get("controlPointValues"):
            r = np.array(measurement["controlPointValues"], float)
    if r is not None and len(r) != len(x):
        raise SurfaceError(f"{path}: has {len(x)} points and {len(r)} radii")
    return x, r


def table_of(path):
    """(names of columns, numbers); no names: None."""
    lines = [words.partition("#")[0] for words in path.read_text(encoding="utf-8-sig").splitlines()]
    rows = [re.split(r"\s*[,;\t]\s*", words.strip()) if re.search("[,;\t]", words) else words.split()
            for words in lines if words.strip(" ,;\t")]
    if not rows:
        raise SurfaceError(f"{path}: is empty")
    names = None
    if any(re.match(r"[A-Za-z_\"]", cell) for cell in rows[0]):
        names = [re.sub(r"\s*[(\[].*", "", cell.strip('"')).strip().lower() for cell in rows.pop(0)]
    width = len(names) if names else len(rows[0])
    for k, row in enumerate(rows):
        if len(row) != width:
            raise SurfaceError(f"{path}: row {k + 1} has {len(row)} cells, not {width}")

    def number(cell):
        try:
            return float(cell)
        except ValueError:
            return np.nan

    return names, np.array([[number(cell) for cell in row] for row in rows])


def from_table(path):
    names, table = table_of(path)
    if names is None:
        if table.shape[1] not in (3, 4):
            raise SurfaceError(f"{path}: has {table.shape[1]} columns without names; give x, y, z and r above them")
        return table[:, :3], table[:, 3] if table.shape[1] == 4 else None
    column = {name: table[:, k] for k, name in reversed(list(enumerate(names)))}

    def first(known, but=()):
        return next((column[name] for name in known if name in column and name not in but), None)

    survey = [first(known) for known in (DEPTHS, INCLINATIONS, AZIMUTHS)]
    if all(part is not None for part in survey):
        return minimum_curvature(path, *survey, first(RADII))
    for places in PLACES:
        if all(name in column for name in places):
            return np.column_stack([column[name] for name in places]), first(RADII, places)
    raise SurfaceError(f"{path}: columns {', '.join(names)}: a path needs x, y, z (and r), a survey measured depth, "
                       "inclination and azimuth")


def minimum_curvature(path, depth, inclination, azimuth, radius):
    """The path of a survey: arcs of circles from station to station, in degrees against the vertical and
    from north; x is north, y east, z up."""
    if (np.diff(depth) <= 0).any():
        raise SurfaceError(f"{path}: measured depth must increase, it does not at row "
                           f"{int(np.argmax(np.diff(depth) <= 0)) + 2}")
    i, a = np.radians(inclination), np.radians(azimuth)
    t = np.column_stack([np.sin(i) * np.cos(a), np.sin(i) * np.sin(a), -np.cos(i)])
    x, r, at = [np.zeros(3)], [0 if radius is None else radius[0]], np.zeros(3)
    for k in range(len(depth) - 1):
        angle = np.arctan2(np.linalg.norm(np.cross(t[k], t[k + 1])), t[k] @ t[k + 1])
        long = depth[k + 1] - depth[k]
        steps = max(1, int(np.ceil(angle / TURN)))
        for part in np.arange(1, steps + 1) / steps:
            if angle < 1e-12:
                go = part * long * t[k]
            else:  # integral of the direction that turns evenly from one to the other
                one = np.cos((1 - part) * angle) - np.cos(angle)
                other = 1 - np.cos(part * angle)
                go = long / (angle * np.sin(angle)) * (one * t[k] + other * t[k + 1])
            x.append(at + go)
            r.append(0 if radius is None else radius[k] + part * (radius[k + 1] - radius[k]))
        at = x[-1]
    return np.array(x), None if radius is None else np.array(r)


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
    inner = max(1, int(round(u[-1] / every)))
    knots = np.linspace(0, u[-1], inner + 1)
    kept = [0] + [k for k in range(1, inner) if np.any((u > knots[k - 1]) & (u < knots[k + 1]))] + [inner]
    knots = knots[kept]
    if len(u) < len(knots) + 3:
        return x, 0.0
    try:
        spline = make_lsq_spline(u, x, np.concatenate([[0] * 3, knots, [u[-1]] * 3]))
    except (ValueError, np.linalg.LinAlgError):
        return x, 0.0
    moved = np.linalg.norm((spline(u) - x)[:, :3], axis=1)
    points = spline(np.linspace(0, u[-1], 4 * len(knots) - 3))
    return points, float(max(moved.max(), np.abs(spline(u) - x)[:, 3].max()))

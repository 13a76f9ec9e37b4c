"""Reads tendril's result files, of a run or of a sweep."""

from __future__ import annotations

import math
import time
from pathlib import Path

import h5py
import numpy as np
from h5py import h5a, h5d, h5g, h5o, h5s

from .collection import Sweep, is_sweep, load_sweep
from .errors import OF_CONTENT, ResultsError, path_of
from .results import ALONG, NUMBERS, SHAPES, Results, Table, as_text, options_of
from .several import Several, births_of, names_of, rod_of

PRIVATE = ("restart",)  # what is tendril's own business
MOST = 1e100  # of any number of a rod
OF_ROD = ("finished", "parameters/contact_diameter", "parameters/friction_radius")


def _numbers(data: h5d.DatasetID):
    """What a dataset holds, as h5py.Dataset has it: files have hundreds, and numbers are read in half of its time."""
    if data.shape is None or data.dtype.kind not in "fiub":
        return h5py.Dataset(data)[()]
    values = np.empty(data.shape, data.dtype)
    data.read(h5s.ALL, h5s.ALL, values)
    return values[()]


def _words(data: h5d.DatasetID, name):
    """The text of an attribute of a dataset, if it has it; read so for the same reason."""
    if not h5a.exists(data, name.encode()):
        return None
    attribute = h5a.open(data, name.encode())
    text = np.empty((), attribute.dtype)
    if text.dtype.kind == "S" and attribute.get_storage_size() == text.nbytes:  # one text of a fixed length, as the program's are
        attribute.read(text)
    else:
        text = h5py.Dataset(data).attrs[name]
    return str(as_text(text))


def _group(group, name, about):
    """The datasets of a group, those of groups within under their path."""
    table = Table()

    def take(path):
        one, key = h5o.open(group.id, path), path.decode()
        if isinstance(one, h5g.GroupID):
            table.update({f"{key}/{attribute}": as_text(value) for attribute, value in h5py.Group(one).attrs.items()})
        elif isinstance(one, h5d.DatasetID):
            table[key] = _numbers(one)
            for attribute, notes in about.items():
                if (words := _words(one, attribute)) is not None:
                    notes[f"{name}/{key}"] = words

    h5o.visit(group.id, take)
    for attribute, value in group.attrs.items():
        table[attribute] = as_text(value)
    return table


def _cut(table, names):
    """A run that is going on or was killed may have written one array further than another."""
    names = [n for n in names if n in table]
    if names:
        rows = min(len(table[n]) for n in names)
        for n in names:
            table[n] = table[n][:rows]


def _read(path):
    """(attributes, groups, units, notes). No lock is asked for: the run that writes may go on."""
    units, notes = {}, {}
    about = {"units": units, "description": notes}
    with h5py.File(path, "r", locking=False) as file:
        attributes = {k if isinstance(k, str) else k.decode("latin-1"): as_text(v) for k, v in file.attrs.items()}
        # walls, earlier_options: texts too long for an attribute are datasets
        attributes |= {name: as_text(file[name][()]) for name in file
                       if isinstance(file[name], h5py.Dataset) and file[name].shape == ()
                       and file[name].dtype.kind in "SO"}
        groups = {name: _group(file[name], name, about) for name in file if name not in PRIVATE
                  and isinstance(file[name], h5py.Group)}
    return attributes, groups, units, notes


def no_result(path, error) -> str:
    """Why a file that is not HDF5 is none: a scene is often given in the place of its result."""
    with path.open("rb") as file:
        words = file.read(4096).decode("utf-8", "replace").splitlines()
    if path.suffix == ".opts" or any(word.startswith("-growth_") for word in words):
        return "is an options file, not its result; run it, with -output FILE.h5, and give that"
    return f"not a whole HDF5 file ({error})"


def numbers_of(table):
    """Refuses what is no array of numbers."""
    for name, values in table.items():
        if isinstance(values, np.ndarray) and values.dtype.kind not in "fiub":
            raise ResultsError(f"{table.of}/{name}: holds {values.dtype}, and no numbers")


def finite(table, name, dimensions, many=None):
    """[...] of a table, all of it finite and of a size that numbers of a rod have."""
    values = np.asarray(table[name])
    if values.ndim != dimensions or values.dtype.kind not in "fiub":
        raise ResultsError(f"{table.of}/{name}: is an array {list(values.shape)}; it should have {dimensions} dimensions")
    if many is not None and values.shape[:len(many)] != many:
        raise ResultsError(f"{table.of}/{name}: is an array {list(values.shape)}, which does not go with the others, {list(many)}")
    if not (np.abs(values) < MOST).all():  # also of nan
        raise ResultsError(f"{table.of}/{name}: holds a number that is not finite, or none of a rod")
    return values


def cut_to(table, rows):
    """Leaves so many rows of each of its arrays."""
    for name in table:
        table[name] = table[name] if name == "s" else table[name][:rows]


def check_series(series):
    for name, values in series.items():
        if np.ndim(values) != 1:
            raise ResultsError(f"{series.of}/{name}: is an array {list(np.shape(values))}, not a number a step")
    if series:
        for name in ("t", "length"):
            finite(series, name, 1)
        if len(series.t) > 1 and series.t[-1] < series.t[-2]:  # a row that is being written
            cut_to(series, len(series.t) - 1)
        if (np.diff(series.t) < 0).any():
            raise ResultsError(f"{series.of}/t: does not rise")


def check_shapes(shapes, joined=False):
    """Shapes that go with each other, of rods that have a length; where others are joined to a rod a node is there twice."""
    if not shapes:
        return
    k, s = len(finite(shapes, "t", 1)), finite(shapes, "s", 1)
    rows = [k] + [len(shapes[name]) for name in ALONG if name in shapes and np.ndim(shapes[name])]
    many = (min(rows), len(s))  # a run that goes on may have written one array further than another
    if len(s) < 2 or (np.diff(s) < 0 if joined else np.diff(s) <= 0).any():
        raise ResultsError(f"{shapes.of}/s: labels must rise")
    for name in ALONG:
        if name in shapes or name in SHAPES:
            dimensions = 2 if name in NUMBERS else 3
            if np.ndim(shapes[name]) != dimensions:
                finite(shapes, name, dimensions)
            part = Table({name: shapes[name][:many[0]]})
            part.of = shapes.of
            finite(part, name, dimensions, many)
    if shapes.x.shape[2] not in (2, 3) or any(shapes[name].shape[2] not in (2, 3) for name in ALONG if np.ndim(shapes.get(name, 0)) == 3):
        raise ResultsError(f"{shapes.of}: points and forces have two or three components")
    for name in ("strain", "d1", "d2", "d3") if shapes.x.shape[2] == 3 else ():
        shapes[name]  # a rod in space has them all
    if shapes.force.shape[2] != shapes.x.shape[2]:
        raise ResultsError(f"{shapes.of}/force: has not as many components as x")
    x, t = shapes.x, shapes.t
    if many[0] > 1 and (not x[many[0] - 1].any() or t[many[0] - 1] < t[many[0] - 2]):  # one that is being written
        many = many[0] - 1, many[1]
        cut_to(shapes, many[0])
    if many[0] and not (np.ptp(shapes.x[:many[0]], axis=1).max(axis=1) > 0).all():
        raise ResultsError(f"{shapes.of}/x: holds a rod without a length")
    if (np.diff(shapes.t[:many[0]]) < 0).any():
        raise ResultsError(f"{shapes.of}/t: does not rise")


def check_modes(stability, critical):
    """Tables of -task stability and critical."""
    if stability:
        t, _ = finite(stability, "t", 1), finite(stability, "t_cr", 0)
        for name, values in stability.items():
            if np.ndim(values) == 1 and name != "t" and len(values) != len(t):
                raise ResultsError(f"{stability.of}/{name}: has {len(values)} rows, and t {len(t)}")
    if "factor" in critical:  # of several rods
        for name in ("factor", "error", "frequency"):
            finite(critical, name, 0)
        finite(critical, "mode", 2, finite(critical, "x", 2).shape)
        finite(critical, "first", 1)
    elif critical:
        s = finite(critical, "s", 1)
        for name in ("t", "length", "error", "frequency"):
            finite(critical, name, 0)
        for name in ("y", "theta", "x2", "x3"):
            if name in critical:
                finite(critical, name, 1, s.shape)


def check_attributes(path, attributes):
    """Scales and numbers of the rod, which all that draws needs."""
    for name, value in attributes.items():
        if name.startswith(("si_", "parameters/si_")) or name in OF_ROD:
            try:
                good = math.isfinite(float(value)) and (float(value) > 0 or not name.startswith("si_")) and abs(float(value)) < MOST
            except (TypeError, ValueError):
                good = False
            if not good:
                raise ResultsError(f"{path}: attribute {name}: {str(value)[:40]} is no number that it can be")
    for name in ("options", "walls"):
        if not isinstance(attributes.get(name, ""), str):
            raise ResultsError(f"{path}: {name}: is no text")


def load(path) -> Results | Sweep:
    """Reads a result file, of a run or of a sweep; raises ResultsError, a plain line, if that cannot be
    done."""
    path = path_of(path, "load")
    if not path.is_file():
        raise ResultsError(f"{path}: is a directory, not a file" if path.is_dir() else f"{path}: no such file")
    if is_sweep(path):
        return load_sweep(path)
    for attempt in range(10):
        try:
            attributes, groups, units, notes = _read(path)
            break
        except (OSError, *OF_CONTENT) as error:
            # a file that is being written may change between two reads: once more, then
            if attempt == 9 or time.time() - path.stat().st_mtime > 3:
                raise ResultsError(f"{path}: {no_result(path, error)}") from None
            time.sleep(0.1)
    series, shapes, stability, critical = (groups.pop(name, Table()) for name in
                                           ("series", "shapes", "stability", "critical"))
    if not (series or stability or critical):
        raise ResultsError(f"{path}: no result file of tendril, it has no group series")
    for table, name in ((series, "series"), (shapes, "shapes"), (stability, "stability"), (critical, "critical")):
        table.of = f"{path}: {name}"
        numbers_of(table)
    check_series(series)
    if "rods" in groups:
        return load_rods(path, attributes, groups, series, shapes, (units, notes))
    check_shapes(shapes)
    check_modes(stability, critical)
    _cut(series, list(series))
    _cut(shapes, [name for name in shapes if name != "s"])
    if len(shapes.get("t", ())) and not len(series.get("t", ())):
        raise ResultsError(f"{path}: series: holds no step, though there are shapes")
    check_attributes(path, attributes)
    options = options_of(attributes.pop("options", ""))
    finished = bool(attributes.pop("finished", 0))
    return Results(path, finished, options, attributes, series, shapes, stability, critical, groups,
                   notes, units)


def load_rods(path, attributes, groups, series, shapes, about) -> Several:
    """The rods of a file that has several."""
    finished = bool(attributes.pop("finished", 0))
    options = options_of(attributes.pop("options", ""))
    rods, names = {}, names_of(path, groups["rods"])
    born = births_of(path, groups["rods"], names)
    for number, name in enumerate(names):
        if born.get(name, 0) > (1 + 1e-12) * max(series.get("t", ()), default=0):
            continue  # it is to come
        rods[name] = one = rod_of(path, finished, number, name, attributes, groups, shapes, series, about)
        check_series(one.series)
        check_shapes(one.shapes, "joints" in groups)
        check_attributes(path, one.attributes)
    others = {name: group for name, group in groups.items() if name not in ("rods", "pairs", "joints")}
    return Several(path, finished, options, attributes, series, shapes, groups=others, units=about[0], notes=about[1], rods=rods,
                   born=born, names=names, first={name: int(k) for name, k in zip(names, groups["rods"]["first"])},
                   touching=groups.get("pairs", Table()), joined=groups.get("joints", Table()))


def runs_of(given, who) -> list[Results]:
    """The runs that somebody gave to draw: Results, files of them, what critical() found, sweeps, or
    several of these. who: whom it was given to, for the line that refuses."""
    if isinstance(given, Several):
        return list(given.rods.values())
    if isinstance(given, Results):
        return [given]
    if isinstance(given, (str, Path)):
        return runs_of(load(given), who)
    if isinstance(getattr(given, "results", None), Results):  # a Critical
        return [given.results]
    if isinstance(given, Sweep):
        given = [r for r in given.members.flat if isinstance(r, Results)]
    if not isinstance(given, (list, tuple, np.ndarray)):
        raise ResultsError(f"{who}: give what run() or load() gave, or the name of a result file, not "
                           f"{type(given).__name__}")
    runs = [r for one in given for r in runs_of(one, who)]
    if not runs:
        raise ResultsError(f"{who}: there is no run to show")
    return runs

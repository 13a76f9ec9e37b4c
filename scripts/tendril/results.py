"""Reads tendril's result files.

    from tendril import load
    r = load("results/uniform-dry.h5")
    r.series.t, r.series.norm_x2        one value per accepted step; names as in the file
    shape = r.at(20)                    the stored shape nearest to t = 20
    shape.x[:, 0], shape.x[:, 1]        its nodes; also .s .theta .curvature .force .length .t
    r.minimum("norm_x2")                (t, value) of the smallest
    r.options["friction_mu"]            what was in force, as text

All is dimensionless, as in the file. Files of runs that are still going or were killed are read as
far as they were written; r.finished tells. Needs numpy and h5py.
"""

import time
from dataclasses import dataclass, field
from pathlib import Path

import h5py
import numpy as np

SHAPES = ("x", "theta", "curvature", "force")


class ResultsError(Exception):
    """The file cannot be read, in one plain line."""


class Table(dict):
    """Arrays by name: table["t"] and table.t are the same."""

    def __getattr__(self, name):
        try:
            return self[name]
        except KeyError:
            raise AttributeError(f"no {name} here; there are {', '.join(self)}") from None


@dataclass
class Shape:
    """The rod at one stored time."""

    index: int  # among the stored shapes
    t: float
    length: float
    s: np.ndarray  # [n], material labels, 0 to 1
    x: np.ndarray  # [n, 2]
    theta: np.ndarray  # [n]
    curvature: np.ndarray  # [n]
    force: np.ndarray  # [n, 2], the internal force


@dataclass
class Results:
    path: Path
    finished: bool
    options: dict  # without the leading dash; what was in force, as text
    attributes: dict  # version, petsc_version, ranks, ...
    series: Table
    shapes: Table  # t [k], s [n], x [k,n,2], theta [k,n], curvature [k,n], force [k,n,2]
    stability: Table = field(default_factory=Table)  # empty if the file holds none
    critical: Table = field(default_factory=Table)
    notes: dict = field(default_factory=dict)  # "series/t" -> its units or description

    @property
    def name(self):
        return self.path.stem

    def at(self, t):
        """The stored shape nearest to time t."""
        if not len(self.shapes.get("t", ())):
            raise ResultsError(f"{self.path}: holds no shape")
        k = int(np.argmin(np.abs(self.shapes.t - t)))
        time = float(self.shapes.t[k])
        return Shape(k, time, self.value("length", time), self.shapes.s,
                     *(self.shapes[name][k] for name in SHAPES))

    def value(self, name, t):
        """A series at time t, between its steps by linear interpolation."""
        return float(np.interp(t, self.series.t, self.series[name]))

    def minimum(self, name="norm_x2"):
        """(t, value) of a series at its minimum: that of the parabola through the logarithms of the
        smallest positive step and its neighbours."""
        t, values = self.series.t, np.where(self.series[name] > 0, self.series[name], np.nan)
        i = int(np.nanargmin(values))
        if not 0 < i < len(t) - 1:
            return float(t[i]), float(values[i])
        a, b, c = np.polyfit(t[i - 1:i + 2] - t[i], np.log(values[i - 1:i + 2]), 2)
        if not a > 0:
            return float(t[i]), float(values[i])
        return float(t[i] - b / (2 * a)), float(np.exp(c - b * b / (4 * a)))


def _text(value):
    if isinstance(value, np.ndarray) and value.size == 1:
        value = value.item()
    return value.decode() if isinstance(value, bytes) else value


def _options(text):
    """Lines '-a 1', '-b' as {'a': '1', 'b': ''}."""
    pairs = (line[1:].partition(" ") for line in str(text).splitlines() if line)
    return {name: value for name, _, value in pairs}


def _group(file, name, notes):
    table = Table()
    for key, data in file.get(name, {}).items():
        table[key] = data[()]
        for attribute in ("units", "description"):
            if attribute in data.attrs:
                notes[f"{name}/{key}"] = _text(data.attrs[attribute])
    return table


def _cut(table, names):
    """A run that is going on or was killed may have written one array further than another."""
    names = [n for n in names if n in table]
    if names:
        rows = min(len(table[n]) for n in names)
        for n in names:
            table[n] = table[n][:rows]


def _read(path):
    """(attributes, groups, notes). No lock is asked for: the run that writes may be going on."""
    notes = {}
    with h5py.File(path, "r", locking=False) as file:
        attributes = {k: _text(v) for k, v in file.attrs.items()}
        groups = [_group(file, g, notes) for g in ("series", "shapes", "stability", "critical")]
    return attributes, groups, notes


def load(path):
    """Reads a result file; raises ResultsError, a plain line, if that cannot be done."""
    path = Path(path)
    if not path.is_file():
        raise ResultsError(f"{path}: no such file")
    for attempt in range(10):
        try:
            attributes, groups, notes = _read(path)
            break
        except (OSError, RuntimeError, KeyError) as error:
            # a file that is being written may change between two reads: once more, then
            if attempt == 9 or time.time() - path.stat().st_mtime > 3:
                raise ResultsError(f"{path}: not a whole HDF5 file ({error})") from None
            time.sleep(0.1)
    series, shapes, stability, critical = groups
    if not (series or stability or critical):
        raise ResultsError(f"{path}: no result file of tendril, it has no group series")
    _cut(series, list(series))
    _cut(shapes, ("t",) + SHAPES)
    options = _options(attributes.pop("options", ""))
    finished = bool(int(attributes.pop("finished", 0)))
    return Results(path, finished, options, attributes, series, shapes, stability, critical, notes)

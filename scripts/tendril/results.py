"""Reads tendril's result files.

    from tendril import load
    r = load("results/uniform-dry.h5")
    r.series.t, r.series.norm_x2        one value per accepted step; names as in the file
    shape = r.at(20)                    the stored shape nearest to t = 20
    shape.x[:, 0], shape.x[:, 1]        its nodes; also .s .theta .curvature .force .length .t
    r.minimum("norm_x2")                (t, value) of the smallest
    r.options["friction_mu"]            what was given, as text
    r.dataset(si=True)                  an xarray Dataset, here in SI units
    r.to_csv("series.csv", si=True)     the series as a table; r.frame() for pandas

All is dimensionless, as in the file, but where si=True is said. Files of runs that are still going
or were killed are read as far as they were written; r.finished tells.
"""

from __future__ import annotations

import time
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING

import h5py
import numpy as np

from .errors import ResultsError
from .units import in_laboratory, scales_of_rod

if TYPE_CHECKING:
    import pandas
    import xarray

SHAPES = ("x", "theta", "curvature", "force")
PRIVATE = ("restart",)  # what is tendril's own business
AXES = {2: ("shape_t", "s"), 3: ("shape_t", "s", "axis")}  # of the arrays of /shapes, by rank


class Table(dict):
    """Arrays by name: table["t"] and table.t are the same."""

    def __getattr__(self, name):
        try:
            return self[name]
        except KeyError:
            raise AttributeError(f"no {name} here; there are {', '.join(self)}") from None


@dataclass(repr=False)
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

    def __repr__(self):
        return f"<the rod at t = {self.t:g}, length {self.length:g}, {len(self.s)} nodes>"


@dataclass(repr=False)
class Results:
    """A result file, all of it in memory: the file may be gone."""

    path: Path
    finished: bool
    options: dict  # without the leading dash; what was given, as text
    attributes: dict  # version, petsc_version, ranks, si_length, parameters/NAME, ...
    series: Table
    shapes: Table  # t [k], s [n], x [k,n,2], theta [k,n], curvature [k,n], force [k,n,2]
    stability: Table = field(default_factory=Table)  # empty if the file holds none
    critical: Table = field(default_factory=Table)
    groups: dict = field(default_factory=dict)  # every other group of the file: event, ...
    notes: dict = field(default_factory=dict)  # "series/t" -> what it is
    units: dict = field(default_factory=dict)  # "series/t" -> its unit, "l/V"

    def __repr__(self):
        held = [f"{len(self.series.t)} steps to t = {self.series.t[-1]:g}" if self.series else "",
                f"{len(self.shapes.t)} shapes" if self.shapes else "",
                "a critical length" if self.critical else "",
                "a table of stability" if self.stability else ""]
        return f"<{self.name}: {', '.join(filter(None, held))}>"

    @property
    def name(self):
        return self.path.stem

    def at(self, t) -> Shape:
        """The stored shape nearest to time t."""
        if not len(self.shapes.get("t", ())):
            raise ResultsError(f"{self.path}: holds no shape")
        k = int(np.argmin(np.abs(self.shapes.t - t)))
        time = float(self.shapes.t[k])
        return Shape(k, time, self.value("length", time), self.shapes.s,
                     *(self.shapes[name][k] for name in SHAPES))

    def value(self, name, t) -> float:
        """A series at time t, between its steps by linear interpolation."""
        return float(np.interp(t, self.series.t, self.series[name]))

    def minimum(self, name="norm_x2") -> tuple[float, float]:
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

    def scale(self, kind) -> float:
        """What 1 of it (length, time, speed, force, energy, power, curvature) is in SI units."""
        known = scales_of_rod(self.attributes).get(kind)
        if self.attributes.get(f"si_{kind}", known) is None:
            needed = "-si_speed" if kind in ("time", "speed", "power") else "-si_bending_stiffness"
            raise ResultsError(f"{self.path}: does not know its {kind} in SI units; run it with "
                               f"{needed} and the like")
        return float(self.attributes.get(f"si_{kind}", known))

    def column(self, group, name, si):
        """(values, unit) of a dataset, as in the file or in SI units."""
        values, unit = getattr(self, group)[name], self.units.get(f"{group}/{name}", "1")
        if not si:
            return values, unit
        factor, unit = in_laboratory(unit, self.scale)
        return factor * values, unit

    def dataset(self, si=False) -> xarray.Dataset:
        """Series over t [steps] and shapes over shape_t [k], s [n] and axis [x1, x2] as an xarray
        Dataset; units and descriptions are attributes of its variables, options those of the whole.

        si  in SI units, of a run with -si_ options"""
        import xarray

        def variable(dims, group, name):
            values, unit = self.column(group, name, si)
            return dims, values, {"units": unit, "long_name": self.notes.get(f"{group}/{name}", name)}

        coords = {"t": variable("t", "series", "t")}
        data = {name: variable("t", "series", name) for name in self.series if name != "t"}
        if self.shapes:
            coords |= {"shape_t": variable("shape_t", "shapes", "t"), "axis": ["x1", "x2"],
                       "s": variable("s", "shapes", "s")}
            data |= {name: variable(AXES[self.shapes[name].ndim], "shapes", name)
                     for name in self.shapes if self.shapes[name].ndim in AXES}
        options = "\n".join(f"-{name} {value}".rstrip() for name, value in self.options.items())
        return xarray.Dataset(data, coords, {"options": options, "finished": int(self.finished),
                                             "version": self.attributes.get("version", "")})

    def frame(self, si=False) -> pandas.DataFrame:
        """The series as a pandas DataFrame, a row a step; with si the names carry units: "t (s)"."""
        import pandas

        columns = {name: self.column("series", name, si) for name in self.series}
        return pandas.DataFrame({f"{name} ({unit})" if si and unit != "1" else name: values
                                 for name, (values, unit) in columns.items()})

    def to_csv(self, path, si=False) -> None:
        """Writes the series as a table, a row a step."""
        self.frame(si).to_csv(path, index=False)


def _text(value):
    if isinstance(value, np.ndarray) and value.size == 1:
        value = value.item()
    return value.decode() if isinstance(value, bytes) else value


def _options(text):
    """Lines '-a 1', '-b' as {'a': '1', 'b': ''}."""
    pairs = (line[1:].partition(" ") for line in str(text).splitlines() if line)
    return {name: value for name, _, value in pairs}


def _group(group, name, about):
    """The datasets of a group, those of groups within under their path."""
    table = Table()

    def take(key, data):
        if isinstance(data, h5py.Dataset):
            table[key] = data[()]
            for attribute, notes in about.items():
                if attribute in data.attrs:
                    notes[f"{name}/{key}"] = _text(data.attrs[attribute])

    group.visititems(take)
    for attribute, value in group.attrs.items():
        table[attribute] = _text(value)
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
        attributes = {k: _text(v) for k, v in file.attrs.items()}
        # walls, earlier_options: texts too long for an attribute are datasets
        attributes |= {name: _text(file[name][()]) for name in file
                       if isinstance(file[name], h5py.Dataset) and file[name].shape == ()
                       and file[name].dtype.kind in "SO"}
        groups = {name: _group(file[name], name, about) for name in file if name not in PRIVATE
                  and isinstance(file[name], h5py.Group)}
    return attributes, groups, units, notes


def load(path) -> Results:
    """Reads a result file; raises ResultsError, a plain line, if that cannot be done."""
    path = Path(path)
    if not path.is_file():
        raise ResultsError(f"{path}: no such file")
    for attempt in range(10):
        try:
            attributes, groups, units, notes = _read(path)
            break
        except (OSError, RuntimeError, KeyError) as error:
            # a file that is being written may change between two reads: once more, then
            if attempt == 9 or time.time() - path.stat().st_mtime > 3:
                raise ResultsError(f"{path}: not a whole HDF5 file ({error})") from None
            time.sleep(0.1)
    series, shapes, stability, critical = (groups.pop(name, Table()) for name in
                                           ("series", "shapes", "stability", "critical"))
    if not (series or stability or critical):
        raise ResultsError(f"{path}: no result file of tendril, it has no group series")
    _cut(series, list(series))
    _cut(shapes, [name for name in shapes if name != "s"])
    options = _options(attributes.pop("options", ""))
    finished = bool(int(attributes.pop("finished", 0)))
    return Results(path, finished, options, attributes, series, shapes, stability, critical, groups,
                   notes, units)

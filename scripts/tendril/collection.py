"""Many runs: what tendril.sweep() gives, and what the one file of `tendril -task sweep` holds.

    s = tendril.load("results/map/sweep.h5")
    s.over                                  {option: its values}, the axes of the grid
    s.members[0, 1].series.width            each run as load() gives it, an axis an option
    s.dataset().width                       where the runs ended, as xarray
    s.columns.friction_mu, s.final.width    the same as tables, an entry a run
    s.status, s.line, s.seconds             0 not run yet, 1 finished, 2 failed; why; wall time

A column of the file is read when it is first asked for, once for all runs: of a thousand runs one reads
what one looks at."""

from __future__ import annotations

import itertools
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Sequence

import h5py
import numpy as np

from .errors import OF_CONTENT, ResultsError, RunError, TendrilError, reading
from .results import ALONG, NUMBERS, Results, Table, as_text, options_of
from .units import parameters_of, quantity

if TYPE_CHECKING:
    import xarray

GROUPS = ("columns", "final", "critical", "series", "shapes")
OF_A_MEMBER = ("first", "count", "first_node", "nodes")  # where its own are among those of all


class Lazy(Table):
    """A table whose arrays are read, or made, when they are first asked for; known: its names."""

    def __init__(self, names, read):
        super().__init__()
        self.__dict__.update(names=tuple(names), read=read)

    def __missing__(self, name):
        if name not in self.names:
            return super().__missing__(name)
        self[name] = found = self.read(name)
        return found

    def __contains__(self, name):
        return name in self.names

    def __iter__(self):
        return iter(self.names)

    def __len__(self):
        return len(self.names)

    def __bool__(self):
        return bool(self.names)

    def __dir__(self):
        return [*dict.__dir__(self), *self.names]

    def keys(self):
        return dict.fromkeys(self.names).keys()

    def values(self):
        return [self[name] for name in self.names]

    def items(self):
        return [(name, self[name]) for name in self.names]

    def get(self, name, otherwise=None):
        return self[name] if name in self else otherwise


def _texts(values):
    if values.dtype.kind != "O":
        return values
    return np.array([v.decode() if isinstance(v, bytes) else v for v in values], dtype=object)


class File:
    """A sweep's file, of which columns are read when they are asked for. It is renamed into its place
    anew while the sweep goes on; what was opened stays whole."""

    def __init__(self, path):
        with h5py.File(path, "r", locking=False) as file:
            if "status" not in file or "columns" not in file:
                raise ResultsError(f"{path}: no result of -task sweep")
            names = {g: [n for n in file.get(g, ()) if isinstance(file[g][n], h5py.Dataset)] for g in GROUPS}
            # a member's own table has those that are not about members
            about = {what: {f"{g}/{n}": str(as_text(file[g][n].attrs[what])) for g in GROUPS[1:]
                            for n in names[g] if what in file[g][n].attrs} for what in ("description", "units")}
            self.notes, self.units = about["description"], about["units"]
            self.attributes = {k: as_text(v) for k, v in file.attrs.items()}
            self.status, self.line = file["status"][()], _texts(file["line"][()])
            self.seconds = file["seconds"][()]
            many = {name: file["columns"][name].shape for name in names["columns"]} | {
                name: file[name].shape for name in ("status", "line", "seconds")}
        self.path = path
        if any(shape != many["status"] or len(shape) != 1 for shape in many.values()) or self.status.dtype.kind not in "iu":
            raise ResultsError(f"{path}: its columns do not go with each other: {', '.join(f'{n} {list(m)}' for n, m in many.items())}")
        self.tables = {g: Lazy(names[g], lambda n, g=g: self.read(f"{g}/{n}")) for g in GROUPS}
        for group, table in self.tables.items():
            table.__dict__["of"] = f"{path}: {group}"

    def read(self, name):
        with reading(self.path, f"{name} cannot be read"), h5py.File(self.path, "r", locking=False) as file:
            values = _texts(file[name][()])
        if values.dtype.kind not in "fiubO":
            raise ResultsError(f"{self.path}: {name}: holds {values.dtype}, and no numbers")
        if name.startswith(("final/", "critical/")) and (values.ndim < 1 or len(values) != len(self.status)):
            raise ResultsError(f"{self.path}: {name}: is an array {list(values.shape)}, and there are {len(self.status)} runs")
        return values


def grid_of(columns, rows):
    """{column: its values} if the rows of a table are a grid over its columns, the last running fastest;
    else {}."""
    columns = {name: np.asarray(values).tolist() for name, values in columns.items()}
    over = {name: list(dict.fromkeys(values)) for name, values in columns.items()}
    points = itertools.product(*over.values())
    whole = np.prod([len(v) for v in over.values()]) == rows
    return over if whole and all(point == row for point, row in zip(points, zip(*columns.values()))) else {}


def final_values(r: Results, si=False) -> dict:
    """{name: (value, unit)} of the last step, or of -task critical."""
    group = "series" if r.series else "critical"
    columns = {name: of for name, of in r.columns(group, si).items() if r.series or np.ndim(of[0]) == 0}
    return {name: (float(np.ravel(values)[-1]), unit) for name, (values, unit) in columns.items()}


@dataclass(repr=False)
class Sweep:
    """Many runs: members is an array of Results, of the shape of the grid, with a RunError in the place
    of one that failed, or has not been run."""

    over: dict  # option -> its values; {}: the runs are no grid, and members a row of them
    found: Sequence | None = None  # members that are in no file
    path: Path | None = None
    finished: bool = True  # all runs have been made
    columns: Table = field(default_factory=Table)  # the options of the table; numbers or text
    status: np.ndarray = field(default_factory=lambda: np.zeros(0, int))
    line: np.ndarray = field(default_factory=lambda: np.zeros(0, object))  # of those that failed, why
    seconds: np.ndarray = field(default_factory=lambda: np.zeros(0))
    final: Table = field(default_factory=Table)  # last values of the series; nan if there is none
    critical: Table = field(default_factory=Table)  # of -sweep_task critical
    attributes: dict = field(default_factory=dict)
    series: Table = field(default_factory=Table)  # of all members, one behind the other
    shapes: Table = field(default_factory=Table)
    notes: dict = field(default_factory=dict)  # "series/t" -> what it is
    units: dict = field(default_factory=dict)  # "series/t" -> its unit, "l/V"

    def __repr__(self):
        grid = " over " + " x ".join(f"{len(v)} {name}" for name, v in self.over.items()) if self.over else ""
        failed = f", {len(self.failed)} failed" if self.failed else ""
        return f"<{len(self)} runs{grid}{failed}>"

    def __len__(self):
        return len(self.status) if self.found is None else len(self.found)

    def __iter__(self):
        """(options of the member, its Results or RunError), one after the other"""
        return ((self.point(k), r) for k, r in enumerate(self.members.flat))

    def point(self, k) -> dict:
        """The options of member k that the sweep varies."""
        if self.over:
            return dict(zip(self.over, next(itertools.islice(itertools.product(*self.over.values()), k, None))))
        return {name: values[k] for name, values in self.columns.items()}

    @cached_property
    def members(self) -> np.ndarray:
        """[...] Results or RunError, an axis an option; those of a file are read as they are looked at."""
        members = np.empty(len(self), object)
        members[:] = self.found if self.found is not None else [self.member(k) for k in range(len(self))]
        return members.reshape([len(v) for v in self.over.values()]) if self.over else members

    @cached_property
    def shared(self) -> dict:
        """The options that all runs have, as text."""
        return options_of(self.attributes.get("options", ""))

    @property
    def failed(self) -> list[tuple[dict, RunError]]:
        return [(point, r) for point, r in self if isinstance(r, RunError)]

    def member(self, k) -> Results | RunError:
        """Run k as load() gives it, as far as it was stored (-sweep_store)."""
        if self.found is not None:
            return self.found[k]
        if self.status[k] != 1:
            return RunError(str(self.line[k]) or "has not been run yet")
        own = {n: text_of_cell(v[k]) for n, v in self.columns.items()}
        options = self.shared | {n: text for n, text in own.items() if text}
        name = "__".join(f"{n}={text}" for n, text in own.items() if text).replace("/", "_")
        critical = Lazy(self.critical.keys(), lambda n: self.critical[n][k])
        return Results(self.path.with_name(f"{name or k}.h5"), True, options, parameters_of(options),
                       self.part_of_series(k), self.part_of_shapes(k), critical=critical, notes=self.notes,
                       units=self.units)

    @staticmethod
    def place(table, name, k):
        """Where a member's own begins, or how many there are."""
        values = table[name]
        if values.dtype.kind not in "iu" or values.ndim != 1 or not k < len(values) or values[k] < 0:
            raise ResultsError(f"{table.of}/{name}: does not say where the rows of run {k} are")
        return int(values[k])

    @staticmethod
    def rows(table, name, first, count):
        values, dimensions = table[name], 2 if name in ALONG and name not in NUMBERS else 1
        if values.dtype.kind not in "fiub" or values.ndim != dimensions or len(values) < first + count:
            raise ResultsError(f"{table.of}/{name}: is an array {list(values.shape)} of {values.dtype}; rows {first} to {first + count} "
                               "are those of a run")
        return values[first:first + count]

    def part_of_series(self, k):
        """The steps of run k: a view of those of all."""
        def read(name):
            first, count = (self.place(self.series, n, k) for n in OF_A_MEMBER[:2])
            return self.rows(self.series, name, first, count)

        def has(name):
            """Errors are followed in the models frame and space alone; and series that another run has may be none of this one.
            Of one that failed nothing is known."""
            return np.isnan(self.final["t"][k]) or not (name in self.final and np.isnan(self.final[name][k]))

        return Lazy((n for n in self.series if n not in OF_A_MEMBER and has(n)), read)

    def part_of_shapes(self, k):
        """The shapes of run k: views of those of all."""
        def read(name):
            first, count, node, nodes = (self.place(self.shapes, n, k) for n in OF_A_MEMBER)
            if name == "t":
                return self.rows(self.shapes, name, first, count)
            mine = self.rows(self.shapes, name, node, count * nodes)
            mine = mine.reshape(count, nodes, *mine.shape[1:])
            return mine[0] if name == "s" and count else mine

        return Lazy((n for n in self.shapes if n not in OF_A_MEMBER), read)

    def ends(self, si) -> dict:
        """{name: ([members] last values, unit)}"""
        table, group = (self.final, "final") if self.final else (self.critical, "critical")
        if self.found is None and not si:
            return {name: (values, self.units.get(f"{group}/{name}", "1")) for name, values in table.items()}
        last = [None if isinstance(r, RunError) else
                self.final_of(k, r, table, group) if self.found is None else final_values(r, si)
                for k, r in enumerate(self.members.flat)]
        known = [values for values in last if values]
        names = [n for n in (known[0] if known else ()) if all(n in values for values in known)]
        return {name: (np.array([values[name][0] if values else np.nan for values in last]), known[0][name][1])
                for name in names}

    def final_of(self, k, r, table, group):
        """{name: (value, unit in SI)} of member k, by its own scales."""
        one = Results(r.path, True, r.options, r.attributes, Table((n, v[k]) for n, v in table.items()),
                      Table(), units={f"series/{n}": self.units.get(f"{group}/{n}", "1") for n in table})
        return one.columns("series", si=True)

    def dataset(self, si=False) -> xarray.Dataset:
        """Where the runs ended: the last value of each series (of -task critical its numbers) over
        the options, as an xarray Dataset; NaN where a run failed. Of a sweep that is no grid the runs
        stand along `member`."""
        import xarray

        ends = {name: found for name, found in self.ends(si).items() if not np.isnan(found[0]).all()}  # what any of them has
        if not ends:
            failed = self.failed
            raise TendrilError(f"no run of this sweep came to its end: {failed[0][1] if failed else 'none'}")
        names = tuple(self.over) or ("member",)
        data = {name: (names, np.reshape(values, self.members.shape), {"units": unit})
                for name, (values, unit) in ends.items()}
        axes = self.over or {n: v for n, v in self.columns.items()}
        coords = {name: ((name,) if self.over else ("member",), *coordinate(values))
                  for name, values in axes.items()}
        return xarray.Dataset(data, coords)


def text_of_cell(value):
    """A cell of the table as an option's text; nothing for an empty one."""
    if isinstance(value, str):
        return value
    return "" if np.isnan(value) else repr(float(value)).removesuffix(".0")


def coordinate(values):
    """(numbers, {"units": theirs}) of an axis in one unit; what is no number stays text."""
    found = [quantity(value) for value in values]
    units = {of[1] for of in found if of}
    if None in found or len(units) != 1:
        return np.asarray([str(v) for v in values] if None in found else list(values)), {}
    unit = units.pop()
    return np.array([number for number, _ in found]), {"units": unit} if unit else {}


def is_sweep(path):
    """Whether a file is one, and not the result of a single run."""
    try:
        with h5py.File(path, "r", locking=False) as file:
            return "status" in file and "columns" in file
    except (OSError, *OF_CONTENT):  # load() says what is wrong with it
        return False


def load_sweep(path, over=None) -> Sweep:
    """Reads a sweep's file; raises ResultsError, a plain line, if that cannot be done. The sweep may
    be under way: the file is then that of its latest store.

    over  the axes of the grid, if they are known; else they are seen from the table"""
    path = Path(path)
    if not path.is_file():
        raise ResultsError(f"{path}: no such file")
    try:
        with reading(path, "not a whole file of a sweep"):
            file = File(path)  # it is renamed into its place, so what is there is whole
    except OSError as error:
        raise ResultsError(f"{path}: not a whole HDF5 file ({error})") from None
    columns = file.tables["columns"]
    if over:  # the file has them by name, the grid as they were given
        columns = Lazy(over, columns.read)
    return Sweep(over or grid_of(columns, len(file.status)), None, path,
                 bool(file.attributes.get("finished", 0)), columns, file.status, file.line, file.seconds,
                 file.tables["final"], file.tables["critical"], file.attributes, file.tables["series"],
                 file.tables["shapes"], file.notes, file.units)

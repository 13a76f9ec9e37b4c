"""Reads the one result file of `tendril -task sweep`.

    from tendril.collection import load_sweep
    s = load_sweep("results/map.h5")
    s.columns.friction_mu, s.final.width    what was asked and what came of it, an entry a run
    s.status, s.line, s.seconds             0 not run yet, 1 finished, 2 failed; why; wall time
    for r in s.members(): r.series.t        with -sweep_store series,shapes: each finished run, as
                                            load() gives it
"""

from dataclasses import dataclass
from pathlib import Path

import h5py
import numpy as np

from .results import Results, ResultsError, Table

GROUPS = ("columns", "final", "critical", "series", "shapes")
OF_A_MEMBER = ("first", "count", "first_node", "nodes")  # where its own are among those of all


@dataclass
class Sweep:
    path: Path
    finished: bool  # all runs have been made
    columns: Table  # the options of the table; numbers or text
    status: np.ndarray
    line: np.ndarray  # of those that failed, why
    seconds: np.ndarray
    final: Table  # of -sweep_task grow: the last value of each series; nan if there is none
    critical: Table  # of -sweep_task critical
    attributes: dict
    series: Table
    shapes: Table
    notes: dict  # "series/t" -> what it is
    units: dict  # "series/t" -> its unit, "l/V"

    def __len__(self):
        return len(self.status)

    def member(self, k):
        """Run k as load() gives it, as far as it was stored (-sweep_store)."""
        series, shapes = Table(), Table()
        if self.series:
            a = self.series["first"][k]
            rows = slice(a, a + self.series["count"][k])
            series.update((n, v[rows]) for n, v in self.series.items() if n not in OF_A_MEMBER)
        if self.shapes:
            a, count, b, nodes = (int(self.shapes[n][k]) for n in OF_A_MEMBER)
            for name, values in self.shapes.items():
                if name == "t":
                    shapes[name] = values[a:a + count]
                elif name not in OF_A_MEMBER:
                    mine = values[b:b + count * nodes]
                    shapes[name] = mine.reshape(count, nodes, *values.shape[1:])
            shapes["s"] = shapes["s"][0] if count else shapes["s"]
        critical = Table((n, v[k]) for n, v in self.critical.items())
        options = {n: str(v[k]) for n, v in self.columns.items()}
        return Results(self.path, self.status[k] == 1, options, {}, series, shapes,
                       critical=critical, notes=self.notes, units=self.units)

    def members(self):
        """The finished runs, one by one."""
        return (self.member(k) for k in np.flatnonzero(self.status == 1))


def _texts(values):
    if values.dtype.kind != "O":
        return values
    return np.array([v.decode() if isinstance(v, bytes) else v for v in values], dtype=object)


def _read(path):
    with h5py.File(path, "r", locking=False) as file:
        if "status" not in file or "columns" not in file:
            raise ResultsError(f"{path}: no result of -task sweep")
        group = {g: Table((n, _texts(d[()])) for n, d in file.get(g, {}).items()) for g in GROUPS}
        about = {what: {f"{g}/{n}": d.attrs[what].decode() for g in GROUPS[1:]
                        for n, d in file.get(g, {}).items() if what in d.attrs}
                 for what in ("description", "units")}
        return Sweep(path, bool(file.attrs["finished"]), group["columns"], file["status"][()],
                     _texts(file["line"][()]), file["seconds"][()], group["final"],
                     group["critical"], dict(file.attrs), group["series"], group["shapes"],
                     about["description"], about["units"])


def is_sweep(path):
    """Whether a file is one, and not the result of a single run."""
    try:
        with h5py.File(path, "r", locking=False) as file:
            return "status" in file and "columns" in file
    except OSError:
        return False


def load_sweep(path):
    """Reads a sweep's file; raises ResultsError, a plain line, if that cannot be done. The sweep may
    be under way: the file is then that of its latest store."""
    path = Path(path)
    if not path.is_file():
        raise ResultsError(f"{path}: no such file")
    try:
        return _read(path)  # it is renamed into its place, so what is there is whole
    except (OSError, RuntimeError, KeyError) as error:
        raise ResultsError(f"{path}: not a whole HDF5 file ({error})") from None

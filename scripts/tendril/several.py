"""Several rods in one result file: what each is alone, and all of them.

    r = tendril.load("dish.h5")
    r["left"].series.tip_x1       a rod's results, as of a run of its own
    r.rods                        {name: results}; of one that is born in the run, from its birth on
    r.born                        {name: when it is born} of those that are, or are to come
    r.pairs[-1].force             where rods touch in the last stored shape: rods, s, force, gap
    r.joints["branch"].force     what a rod does to the one that carries it, in the stored shapes: force, moment, on, end, node
    r.series.energy               of all: sums, or the largest"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import NoReturn

import numpy as np

from .errors import ResultsError
from .naming import unknown
from .results import Results, Table, as_text, options_of

OF_ALL = ("t", "step", "newton_iterations", "model")  # series that rods share
OF_FILE = ("version", "petsc_version", "units", "ranks", "interrupted")


@dataclass(repr=False, eq=False)
class Rod(Results):
    """One of several rods: results as of a run of its own."""

    rod: str = ""

    @property
    def name(self):
        return self.rod


@dataclass(repr=False, eq=False)
class Several(Results):
    """A result file of several rods. Its shapes hold all nodes, rod behind rod; a rod's own are its results'."""

    rods: dict[str, Results] = field(default_factory=dict)
    born: dict[str, float] = field(default_factory=dict)
    names: list[str] = field(default_factory=list)  # of all, in the file's order,
    first: dict[str, int] = field(default_factory=dict)  # and the first node of each among those of all
    touching: Table = field(default_factory=Table)  # /pairs of the file
    joined: Table = field(default_factory=Table)  # /joints of the file

    @property
    def pairs(self) -> list[Table]:
        """Where rods touch each other, of each stored shape: names of the two, labels on either, the force on the first, the gap."""
        if not self.touching:
            raise ResultsError(f"{self.told}: its rods do not touch each other; give the scene a [pair ...] section")
        names, first = self.names, self.touching["first"]
        return [Table({"rods": [tuple(names[int(k)] for k in two) for two in self.touching["rods"][a:b]]}
                      | {name: self.touching[name][a:b] for name in ("s", "force", "gap")}) for a, b in zip(first[:-1], first[1:])]

    @property
    def joints(self) -> dict[str, Table]:
        """What rods do to those that hold them: of each joint, called as the rod that is held (its tip: NAME.tip)."""
        if not self.joined:
            raise ResultsError(f"{self.told}: its rods do not hold each other; give one a -clamp_on or -tip_on")
        found = {}
        for j, (name, on, end) in enumerate(zip(*(map(as_text, self.joined[key]) for key in ("name", "on", "end")))):
            found[name if end == "base" else f"{name}.tip"] = Table(
                {"on": on, "end": end, "node": int(self.joined["node"][j])} | {key: self.joined[key][:, j] for key in ("force", "moment")})
        return found

    def __repr__(self):
        return f"<{self.name}: {len(self.rods)} rods, {', '.join(self.rods)}; {len(self.series.t)} steps to t = {self.series.t[-1]:g}>"

    def __getitem__(self, name) -> Results:
        if name not in self.rods and name in self.born:
            raise ResultsError(f"{self.told}: rod {name} is born at t = {self.born[name]:g}, and the run is at {self.series.t[-1]:g}")
        if name not in self.rods:
            raise ResultsError(f"{self.told}: has no rod {name}{unknown(name, self.rods)}")
        return self.rods[name]

    def at(self, t, nearest=False) -> NoReturn:
        first = next(iter(self.rods))
        raise ResultsError(f"{self.told}: holds {len(self.rods)} rods; take one, as [{first!r}].at({t})")

    stored = between = astray = at


def rod_of(path, finished, number, name, attributes, groups, shapes, series, about) -> Rod:
    """Results of rod `number` of a file, from its birth on; about: units and notes."""
    rods = groups["rods"]
    nodes = slice(int(rods["first"][number]), int(rods["first"][number] + rods["count"][number]))
    prefix = f"of/{name}/"
    own = {key.removeprefix(prefix): as_text(value) for key, value in rods.items() if key.startswith(prefix)}
    before = [born_before(table.get("t", ()), rods, number) for table in (series, shapes)]
    columns = {key.removeprefix("series/"): values[before[0]:, number] for key, values in rods.items()
               if key.startswith("series/") and not np.isnan(values[:, number]).all()}
    mine = Table({key: values[before[0]:] for key, values in series.items() if key in OF_ALL} | columns)
    cut = Table({key: values[nodes] if key == "s" else (values if key == "t" else values[:, nodes])[before[1]:] for key, values in shapes.items()})
    mine.of, cut.of = f"{path}: rods/series of {name}", f"{path}: shapes of {name}"
    kept = {key: value for key, value in attributes.items() if key in OF_FILE} | own
    options = options_of(kept.pop("options", ""))
    return Rod(path, finished, options, kept, mine, cut, rod=name, units=about[0], notes=about[1])


def born_before(t, rods, number) -> int:
    """How many of these times are before a rod is born."""
    return int((t < (1 - 1e-12) * rods["born"][number]).sum()) if "born" in rods and len(t) else 0


def births_of(path, rods, names) -> dict[str, float]:
    """When rods are born, {name: t}, of those that are not there from the start."""
    if "born" not in rods:
        return {}
    if np.shape(rods["born"]) != (len(names),) or not (rods["born"] >= 0).all():
        raise ResultsError(f"{path}: rods/born: holds no time for each rod")
    return {name: float(t) for name, t in zip(names, rods["born"]) if t > 0}


def names_of(path, rods) -> list[str]:
    """What the rods of a file are called."""
    try:
        names = [str(as_text(name)) for name in rods["name"]]
        whole = all(len(rods[key]) == len(names) for key in ("first", "count"))
    except (KeyError, TypeError) as error:
        raise ResultsError(f"{path}: rods: is not whole ({error})") from None
    if not whole or not names:
        raise ResultsError(f"{path}: rods: names, first and count are not as many")
    return names

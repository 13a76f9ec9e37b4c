"""What was measured, from CSV files: centre lines as photographs have them, and series.

Columns carry their unit, "x1 (cm)" or "x1 [cm]"; without one a number is dimensionless, or in what
`unit` says. Three kinds of file:

  t (s), x1 (cm), x2 (cm)[, point]    points of centre lines, a row a point, in any order; photographs
                                      are told apart by t, or by length (cm). A column point says that
                                      they are in order, counted from the clamp to the tip
  t (s), width (cm), base_force_1 (N) series by their names in docs/results.md, over t or length; what
                                      is missing is left empty
  two columns of numbers              one photograph, as a digitiser exports it, with its time or length
                                      given beside the file; or several side by side under a line of
                                      times and a line "X, Y, X, Y" (WebPlotDigitizer)

DeepLabCut, Tracker, ImageJ, spreadsheets and DataFrames: tendril.readers; SLEAP, SmartRoot, RSML: tendril.tracked. Points in
px are those of a picture, x2 downwards: scale, place and turn of the camera are then found together with the rest. A
photograph without a time has that which its file's name says (tendril.naming), or is compared with the shape that fits it
best."""

from __future__ import annotations

import re
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Mapping, Sequence

import numpy as np

from . import angle_tables
from .errors import DataError
from .naming import times_of, unknown
from .readers import Row, heading, is_number, line_of, number_in, plain
from .units import MEASURED, PIXEL, quantity

ABSCISSAE = ("t", "length")


@dataclass
class Values:
    """Numbers with what they are: in SI units, in pixels, or dimensionless as tendril has them."""

    numbers: np.ndarray
    unit: str = ""  # "" dimensionless; else that of units.MEASURED: "l" is metres, PIXEL, ...

    @property
    def si(self):
        return self.unit not in ("", PIXEL, "rad")


@dataclass
class Photograph:
    """The points of one centre line."""

    points: Values  # numbers [m, 2]
    abscissa: str | None  # "t" or "length"; None: neither is known
    at: Values  # one number
    ordered: bool  # from the clamp to the tip
    source: str


@dataclass
class Curve:
    """A series as measured."""

    name: str
    abscissa: str  # "t" or "length"
    at: Values  # numbers [m], rising
    values: Values  # numbers [m]
    source: str
    behind: Values | None = None  # of an angle: how far behind the tip; None: where the series says


@dataclass
class Measured:
    photographs: list[Photograph] = field(default_factory=list)
    curves: list[Curve] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)  # what was made of the files, and what was not used

    def abscissae(self, name) -> list[Values]:
        """All times, or lengths, at which something was measured."""
        return [m.at for m in (*self.photographs, *self.curves) if m.abscissa == name]

    def told(self, noise) -> dict[str, float]:
        """{group: number} of the noise that a user tells, {"lines": "0.5mm"}, in the units of what was
        measured."""
        units = {c.name: c.values.unit for c in self.curves}
        units |= {"lines": p.points.unit for p in self.photographs}
        found = {}
        for name, text in (noise or {}).items():
            if name not in units:
                raise DataError(f"noise of {name}: was not measured{unknown(name, units)}")
            if not (number := quantity(text)):
                raise DataError(f'noise of {name}: "{text}" is no number with a unit')
            value = values_of(*number, f"noise of {name}")
            if value.unit != units[name] or not float(value.numbers) > 0:
                raise DataError(f"noise of {name}: {text}: give a positive number in the unit of what was "
                                "measured")
            found[name] = float(value.numbers)
        return found

    def count(self) -> int:
        return sum(len(p.points.numbers) for p in self.photographs) \
            + sum(len(c.values.numbers) for c in self.curves)


def values_of(numbers, unit, what):
    """Values of numbers in a unit by its name, "cm"."""
    unit = unit.replace("\u03bc", "\u00b5")  # a Greek mu is a micro, too
    if unit not in MEASURED:
        raise DataError(f"{what}: {unit} is no unit; give one of "
                        f"{', '.join(name for name in MEASURED if name and '/' not in name)}, or of such, as mm/s and 1/m")
    name, si = MEASURED[unit]
    return Values(si * np.asarray(numbers, float), name)


def moment(text, what):
    """(abscissa, Values) of what stands beside a photograph: "20s", "t = 20s", "12cm", "" for none."""
    text = text.strip()
    if not text:
        return None, Values(np.nan)
    found = re.fullmatch(r"(?:(t|length)\s*=?\s*)?(.*)", text)
    number = found and quantity(found[2])
    if not number or re.match(r"\W", number[1]):
        raise DataError(f'{what}: "{text}" is no time and no length; give 20s, 12cm, or t=2.5')
    at = values_of(*number, what)
    return found[1] or ("length" if at.unit == "l" else "t"), at


def number(cell, what, row=()):
    if not cell.strip():
        return np.nan
    if is_number(cell):
        return float(cell)
    if (found := number_in(cell)) and not found[1]:
        return found[0]
    told = f", in the row {', '.join(row)}" if row else ""
    what = f"{what}, line {line_of(row)}" if line_of(row) else what
    if cell.strip().startswith("-") and row and cell is row[0]:
        told += "; is it an options file? The scene comes first, then the data"
    raise DataError(f'{what}: "{cell.strip()}" is no number{told}')


def columns_of(rows, width, path):
    """[row, column] as numbers, NaN where nothing is given."""
    return np.array([[number(cell, path, row) for cell in (row + [""] * width)[:width]] for row in rows], float).reshape(-1, width)


def photograph(points, unit, at, ordered, source):
    """A photograph of the points whose two numbers are given; at as of moment()."""
    points = points[np.isfinite(points).all(axis=1)]
    if len(points) < 3:
        raise DataError(f"{source}: a photograph needs three points at least, it has {len(points)}")
    return Photograph(values_of(points, unit, source), *at, ordered, source)


def side_by_side(rows, unit, path, at=""):
    """Photographs in pairs of columns, under a line of times or lengths (WebPlotDigitizer)."""
    table = columns_of(rows[2:], len(rows[1]), path)
    heads = (rows[0] + [""] * len(rows[1]))[:len(rows[1])]
    if at and len(rows[1]) < 4:  # of one alone it may stand beside the file
        heads[0] = at
    try:
        when = [moment(heads[k], path) for k in range(0, len(rows[1]) - 1, 2)]
    except DataError:
        named = next(head.strip() for head in heads[::2] if not timely(head))
        raise DataError(f'{path}: the data set "{named}" says no time and no length: name it 20s or 12cm in the digitiser, '
                        "or export it alone and give 20s@FILE") from None
    return [photograph(table[:, k:k + 2], unit, when[k // 2], False, f"{path}, columns {k + 1} and {k + 2}")
            for k in range(0, len(rows[1]) - 1, 2)]


def timely(text):
    """Whether moment() can read it."""
    try:
        moment(text, "")
        return True
    except DataError:
        return False


def lines_of(table, names, units, abscissa, path, notes):
    """Photographs of a file of points, a row a point; those of which too little is sure are noted."""
    place = {name: table[:, k] for k, name in enumerate(names)}
    points = np.column_stack([place["x1"], place["x2"]])
    if units["x1"] != units["x2"]:
        raise DataError(f"{path}: x1 is in {units['x1']}, x2 in {units['x2']}; give them in one unit")
    when = place.get(abscissa, np.full(len(points), np.nan))
    found, few = [], []
    for value in [*np.unique(when[np.isfinite(when)]), *([np.nan] if np.isnan(when).any() else [])]:
        rows = np.isnan(when) if np.isnan(value) else when == value
        if "point" in place:
            rows = np.flatnonzero(rows)[np.argsort(place["point"][rows], kind="stable")]
        if abscissa == "length" and value <= 0:
            raise DataError(f"{path}: a photograph at length {value:g}; lengths are above 0")
        at = (None, Values(np.nan)) if np.isnan(value) else (
            abscissa, values_of(value, units[abscissa], path))
        sure = place["unsure"][rows] != 1 if "unsure" in place else np.ones(len(points[rows]), bool)
        there = sure & np.isfinite(points[rows]).all(axis=1)
        if np.count_nonzero(there) < 3:
            few.append(f"{path}: not used: {abscissa} = {value:g}, of which {np.count_nonzero(there)} of "
                       f"{len(sure)} points are sure")
            continue
        # the last is the tip, if it is sure
        found.append(photograph(points[rows][sure], units["x1"], at, "point" in place and bool(there[-1]),
                                f"{path}, {abscissa} = {value:g}"))
    if not found:
        raise DataError(f"{path}: no photograph has three points that are sure, and it needs three at least")
    notes += few
    return found


def curves_of(table, names, units, abscissa, path):
    """Series of a file with a column each."""
    if abscissa is None:
        raise DataError(f"{path}: has no column t or length, as t (s); there are {', '.join(filter(None, names))}")
    when, found = table[:, names.index(abscissa)], []
    for k, name in enumerate(names):
        rows = np.flatnonzero(np.isfinite(when) & np.isfinite(table[:, k]))
        if not name or name == abscissa or not len(rows):
            continue
        rows = rows[np.argsort(when[rows], kind="stable")]
        found.append(Curve(name.lower(), abscissa, values_of(when[rows], units[abscissa], path),
                           values_of(table[rows, k], units[name], f"{path}, {name}"), str(path)))
    return found


def angles_of(found, rows, headings, path, notes):
    """Series of a table of angles, an organ each; what else it has is noted."""
    series, unit = angle_tables.series_of(found, rows, path)
    if unused := [name for (name, _), one in zip(headings, found) if name and (one is None or not one.what)]:
        notes.append(f"{path}: not used: {', '.join(unused)}")
    organs = list(dict.fromkeys(organ for _, organ, _, _ in series))
    if len(organs) > 1:
        notes.append(f"{path}: {len(organs)} organs, whose mean is looked for")
    return [Curve(column.what, "t", values_of(t, unit, path), values_of(angles, column.unit, path),
                  f"{path}, {organ}" if organ else str(path), None if column.behind is None else Values(np.array(column.behind), "l"))
            for column, organ, t, angles in series]


def left_out(table, names, path):
    """In words, what of a file of points is not used."""
    words = []
    used = ("x1", "x2", "point", "unsure", next((name for name in ABSCISSAE if name in names), None))
    unused = [name for name in names if name and name not in used]
    if unused:
        words.append(f"{path}: not used: {', '.join(unused)}")
    if "unsure" in names and (count := np.count_nonzero(table[:, names.index("unsure")] == 1)):
        words.append(f"{path}: not used: points that are unsure or not there, {count}")
    missing = ~np.isfinite(table[:, [names.index("x1"), names.index("x2")]]).all(axis=1)
    if "unsure" in names:
        missing &= table[:, names.index("unsure")] != 1
    missing = np.count_nonzero(missing)
    return words + ([f"{path}: {missing} rows without a point are not used"] if missing else [])


def read(path, unit="", at="", fps=None) -> Measured:
    """Reads one file, or a pandas DataFrame.

    unit  of the numbers that carry none, "cm" or "px"; "": dimensionless
    at    of a photograph that does not say so itself, "20s" or "12cm"; "": not known
    fps   frames per second, of a file that counts frames"""
    rows, notes = plain(path, fps)
    path = "data" if hasattr(path, "itertuples") else path
    if all(is_number(cell) for cell in rows[0] if cell.strip()):
        width = max(len(row) for row in rows)
        if width > 2:
            notes.append(f"{path}: not used: columns 3 to {width}, which have no heading")
        table = columns_of(rows, 2, path)
        return Measured([photograph(table, unit, moment(at, path), False, str(path))], notes=notes)
    if len(rows) > 1 and [c.strip().upper() for c in rows[1]][:2] == ["X", "Y"]:
        return Measured(side_by_side(rows, unit, path, at), notes=notes)
    if len(rows) < 2:
        raise DataError(f"{path}: has a line of headings, and no row below it")
    headings = [heading(cell) for cell in rows[0]]
    names = [name for name, _ in headings]
    if found := angle_tables.columns_of(headings):
        return Measured([], angles_of(found, rows[1:], headings, path, notes), notes)
    if twice := next((name for name in names if name and names.count(name) > 1), None):
        raise DataError(f"{path}: has {names.count(twice)} columns {twice}; give each photograph rows of its own, or X, Y, X, Y "
                        "under a line of times")
    units = {name: unit if given is None and name in ("x1", "x2") else given or ""
             for name, given in headings}
    abscissa = next((name for name in ABSCISSAE if name in names), None)
    points = {"x1", "x2"} <= set(names)
    used = {"x1", "x2", "point", "unsure", *ABSCISSAE}
    table = columns_of([Row([cell if not points or name in used else "" for name, cell in zip(names, row)], line_of(row))
                        for row in rows[1:]], len(names), path)
    if points:
        found = lines_of(table, names, units, abscissa, path, notes)
        if abscissa is None and at:
            for one in found:
                one.abscissa, one.at = moment(at, path)
        return Measured(found, notes=notes + left_out(table, names, path))
    return Measured([], curves_of(table, names, units, abscissa, path), notes)


def gather(data, unit="", y_down=None, fps=None) -> Measured:
    """All that was measured as one.

    data  a file, a list of files, Measured, or a dict of photographs by their time or length:
          {"20s": "photo.csv", "30s": points [m, 2]}
    y_down  whether x2 is counted downwards; None: of px it is"""
    whole = gathered(data, unit, fps)
    for p in whole.photographs:
        if y_down is not None and y_down != (p.points.unit == PIXEL):
            p.points = replace(p.points, numbers=p.points.numbers * [1, -1])
    return whole


def named(files, fps=None):
    """Gives photographs that know no time those that the names of their files say. files: (name, Measured), of which all
    that hold one photograph alone are meant."""
    lone = [(name, one) for name, one in files if len(one.photographs) == 1 and one.photographs[0].abscissa is None]
    times, told = times_of([name for name, _ in lone], fps) if len(lone) == len(files) else (None, "")
    for (_, one), at in zip(lone, times or ()):
        one.photographs[0].abscissa, one.photographs[0].at = "t", Values(float(at), "l/V")
    if told:
        lone[0][1].notes.append(told)
    return [one for _, one in files]


def points_of(points, at, unit, fps):
    """Measured, of what stands for a photograph beside its time or length: a file, a DataFrame, an array."""
    if isinstance(points, (str, Path)) or hasattr(points, "itertuples"):
        return read(points, unit, str(at), fps)
    what = f"photograph at {at}" if at else "photograph"
    try:
        table = np.asarray(points, float)
    except (TypeError, ValueError):
        table = np.empty(0)
    if table.ndim != 2 or table.shape[1] != 2:
        told = f", not {list(table.shape)}" if table.size else ""
        raise DataError(f"{what}: give points [m, 2], x1 and x2{told}")
    return Measured([photograph(table, unit, moment(str(at), "data"), False, what)])


def gathered(data, unit, fps=None) -> Measured:
    if isinstance(data, Measured):
        return checked(data)
    if isinstance(data, Mapping):
        found = [points_of(points, at, unit, fps) for at, points in data.items()]
    elif isinstance(data, (str, Path)) or hasattr(data, "itertuples"):
        found = [read(data, unit, fps=fps)]
        found = found if hasattr(data, "itertuples") else named([(data, found[0])], fps)
    elif isinstance(data, Sequence) and len(data) and all(isinstance(one, (str, Path)) for one in data):
        found = named([(one, read(one, unit, fps=fps)) for one in data], fps)
    elif isinstance(data, Sequence) and not isinstance(data, bytes) and len(data):
        found = [gathered(one, unit, fps) for one in data]
    else:
        raise DataError("data: give a CSV file, a DataFrame, several in a list, or {'20s': 'photo.csv', ...}")
    return checked(Measured([p for m in found for p in m.photographs],
                            [c for m in found for c in m.curves], [n for m in found for n in m.notes]))


LARGEST = 1e50  # of what was measured


def checked(whole: Measured) -> Measured:
    if not whole.count():
        raise DataError("data: nothing was measured there")
    if len({p.points.unit for p in whole.photographs}) > 1:
        raise DataError("data: the photographs are in different units, some dimensionless or in px; "
                        "give all in one")
    points = [p.points.numbers for p in whole.photographs]
    if points and sum(map(len, points)) > 1 and not np.ptp(np.vstack(points), axis=0).any():
        raise DataError(f"{whole.photographs[0].source}: all points that were measured are in one place")
    for one in [*whole.photographs, *whole.curves]:
        for values in (one.at, one.points if isinstance(one, Photograph) else one.values):
            if (far := np.abs(values.numbers) > LARGEST).any():
                number = float(np.atleast_1d(values.numbers)[np.atleast_1d(far)][0])
                raise DataError(f"{one.source}: {number:g} cannot have been measured; {LARGEST:g} is the most")
    return whole

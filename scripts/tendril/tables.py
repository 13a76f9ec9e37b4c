"""Tables by the names above their columns: paths, well surveys, rates. The names are looked for below titles, the units stand behind
them or in a row below, or behind the numbers; rows of words, titles and footnotes are left out, and said to be."""

from __future__ import annotations

import re
from dataclasses import dataclass, field

import numpy as np

from .readers import DataError, Row, heading, is_number, line_of, number_in, rows_and_comments, units_in
from .units import METRES, OF_KIND, PIXELS, TIMES, rate_called, unit_called

HEAD = 80  # rows in which headings are looked for
# in brackets behind a name, and no unit
ASIDE = ("", "-", "1", "none", "true", "grid", "magnetic", "mag", "true north", "grid north", "rkb", "kb", "rt", "dfe", "msl", "ss", "ras",
         "lps")
SAID = re.compile(r"\b(?:units?|uom)\b[^:=,;]{0,24}[:=,;]\s*[\"'(\[]?\s*([A-Za-z\u00b5\u03bc]+)", re.IGNORECASE)
# lengths that tendril does not know, as a title may have them
STRANGE = ("yd", "yard", "yards", "km", "dm", "nm", "mile", "miles", "usft", "ftus", "fathom", "furlong", *PIXELS, "voxel",
           "voxels", "kilometre", "kilometer", "kilometres", "kilometers")


@dataclass
class Wanted:
    """A column that is looked for."""

    kind: str  # of unit: "length", "angle", "rate", or "" for words
    names: tuple[str, ...]  # in small letters


@dataclass
class Column:
    name: str  # as it stands there
    index: int
    unit: str | None  # by tendril's name; None: none was said
    numbers: np.ndarray = field(default_factory=lambda: np.empty(0))


@dataclass
class Table:
    """What was found of what was wanted."""

    columns: dict[str, Column]
    lines: list[int]  # of the rows in the file
    notes: list[str]

    def has(self, *names):
        return all(name in self.columns for name in names)

    def numbers(self, name):
        return self.columns[name].numbers

    def lengths(self, names, source):
        """(the columns of these names [n, k] in one unit, that unit): those without one are in that of the others."""
        said = [column for name in names if (column := self.columns[name]).unit]
        bare = [column.name for name in names if not (column := self.columns[name]).unit]
        if said and bare:
            self.notes.append(f"{source}: {', '.join(bare)}: without a unit, taken in {said[0].unit} as {said[0].name}")
        unit = said[0].unit if said else ""
        return np.column_stack([self.numbers(name) * factor(self.columns[name].unit or unit, unit, source) for name in names]), unit


def factor(unit, to, source):
    """What 1 of a unit of length is in another; those that tendril does not know are not converted."""
    if unit == to:
        return 1.0
    if strange := next((one for one in (unit, to) if one not in METRES), None):
        raise DataError(f"{source}: has lengths in {to} and in {unit}; {strange} is no unit of length that tendril knows")
    return METRES[unit] / METRES[to]


def plain_name(cell):
    """A name in small letters, with blanks for what else parts words."""
    return " ".join(re.sub(r"[_:.\s\"]+", " ", cell).split()).lower()


def unit_of(text, kind):
    """(the name of a unit, whether it is one)."""
    word = plain_name(text)
    if word in ASIDE:
        return None, True
    if kind == "rate":
        return text.strip(), rate_called(text) is not None
    found = unit_called(text, kind)
    return found or text.strip(), found is not None


def unit_behind(cell, names, kind):
    """The unit of a heading that has one of the names, as it stands there, in brackets or not: "x (mm)", "x/mm", "radius_mm", "MD ft";
    "" for none. None: it is another heading."""
    name, unit = heading(cell)
    if plain_name(name) in names:
        return unit or ""
    if unit is not None and plain_name(re.sub(r"[(\[{].*?[)\]}]", "", name)) in names:  # Measured Depth (MD) (ft)
        return unit
    for apart in re.finditer(r"[\s_.,:;/-]+", cell):
        name, unit = cell[:apart.start()], cell[apart.end():].strip().strip("()[]{}")
        if unit and plain_name(name) in names and (unit_of(unit, kind)[1] if kind else False):
            return unit
    return None


def columns_in(cells, wanted):
    """{what is wanted: its column} of a row of headings; by the first of its names that is there, not the first column."""
    found = {}
    for what, column in wanted.items():
        there = [(k, unit) for name in column.names for k, cell in enumerate(cells)
                 if (unit := unit_behind(cell, (name,), column.kind)) is not None]
        if there:
            found[what] = Column(cells[there[0][0]].strip(), *there[0])
    return found


def joined(one, two):
    """Headings over two rows."""
    return Row([f"{a} {b}".strip() for a, b in zip(one + [""] * len(two), two + [""] * len(one))], line_of(one))


def headed(rows, comments, wanted, enough):
    """(columns, the rows below them, the rows above) of a table with names that are enough; None."""
    for k, row in enumerate(rows[:HEAD]):
        if enough(found := columns_in(row, wanted)):
            return found, row, rows[k + 1:], rows[:k]
    for k, (row, below) in enumerate(zip(rows[:HEAD], rows[1:HEAD + 1])):
        if not any(map(is_number, [*row, *below])) and enough(found := columns_in(heads := joined(row, below), wanted)):
            return found, heads, rows[k + 2:], rows[:k]
    body = next((k for k, row in enumerate(rows) if any(map(is_number, row))), len(rows))
    for line, text in reversed([one for one in comments if body < len(rows) and one[0] < line_of(rows[body])]):
        for way in (r"\s*[,;\t]\s*", r"\s+(?![(\[])"):
            cells = Row(re.split(way, text.strip()), line)
            if len(cells) == len(rows[body]) and enough(found := columns_in(cells, wanted)):
                return found, cells, rows[body:], rows[:body]
    return None


def units_below(columns, rows, name, notes):
    """The rows without those directly below the headings that have no number in a column that is wanted and something in two, or a
    unit in one: they say the units."""
    for row in rows[:1]:
        said = {what: row[c.index].strip() for what, c in columns.items() if c.index < len(row) and row[c.index].strip()}
        if any(map(number_in, said.values())) or not (len(said) > 1 or units_in(said.values())):
            break
        for what, cell in said.items():
            columns[what].unit = columns[what].unit or cell.strip("()[]{} ")
        notes.append(f"{name}: units from line {line_of(row)}")
        return rows[1:]
    return rows


def unit_said(rows, comments):
    """(line, word) of a unit of length for all of it, that a title or a comment says: "units: mm"; None."""
    texts = [(line_of(row), ", ".join(cell.strip() for cell in row if cell.strip())) for row in rows]
    return next(((line, word) for line, text in sorted(texts + comments) if (word := length_said(text))), None)


def length_said(text):
    """The unit of length that words say, "units: mm"; None for none."""
    found = SAID.search(text)
    return found[1] if found and (unit_called(found[1], "length") or found[1].lower() in STRANGE) else None


def named(source, wanted, enough, foreign=False, given=None):
    """(the table with what is wanted of a file, None), or (None, what was read of it) where the names are not enough.

    wanted   {what: Wanted}
    enough   of {what: Column}: whether these will do
    foreign  units of length that are not known are taken as they are
    given    rows, notes and comments, if the file has been read"""
    rows, notes, comments = given or rows_and_comments(source)
    head = headed(rows, comments, wanted, enough)
    if head is None:
        return None, (rows, notes, comments)
    columns, heads, rows, above = head
    if above:
        notes.append(f"{source}: not used: above the headings, {', '.join(words_of(row) for row in above[:3])}"
                     f"{', ...' if len(above) > 3 else ''}")
    rows = units_below(columns, rows, source, notes)
    said = unit_said(above, [one for one in comments if one[0] < (line_of(rows[0]) if rows else 0)])
    for what, column in columns.items():
        if wanted[what].kind == "length" and not column.unit and said:
            column.unit = said[1]
    if said:
        notes.append(f"{source}: the unit {said[1]} of line {said[0]}")
    for what, column in columns.items():
        check_unit(source, column, wanted[what].kind, foreign)
    used = {column.index for column in columns.values()}
    unused = [cell.strip() for k, cell in enumerate(heads) if k not in used and cell.strip()]
    if unused:
        notes.append(f"{source}: not used: {'columns' if len(unused) > 1 else 'column'} {', '.join(unused[:8])}"
                     f"{', ...' if len(unused) > 8 else ''}")
    table = Table(columns, [], notes)
    fill(table, rows, heads, wanted, source)
    return table, None


def body_of(rows):
    """(the number of the first row of numbers, the columns that are filled from there on)."""
    first = next((k for k, row in enumerate(rows) if sum(map(is_number, row)) > 1), len(rows))
    width = max(map(len, rows[first:]), default=0)
    return first, [k for k in range(width) if any(k < len(row) and row[k].strip() for row in rows[first:])]


def under(names, rows):
    """Rows with names above the columns that are filled, where the numbers begin."""
    first, full = body_of(rows)
    named_at = dict(zip(full, names))
    heads = Row([named_at.get(k, "") for k in range(full[-1] + 1)], line_of(rows[first]))
    return [*rows[:first], heads, *rows[first:]]


def words_of(row):
    return " ".join(cell.strip() for cell in row if cell.strip())


def check_unit(source, column, kind, foreign):
    """Gives a column tendril's name of its unit, or refuses it."""
    column.unit, known = unit_of(column.unit or "", kind) if kind else (None, True)
    if known or (foreign and kind == "length"):
        return
    if kind == "rate":
        raise DataError(f"{source}: {column.name}: {column.unit} is no unit of a relative rate; give %/h, 1/h and the like, by "
                        f"{', '.join(TIMES)}")
    raise DataError(f"{source}: {column.name}: {column.unit} is no unit of {'an angle' if kind == 'angle' else kind}; tendril knows "
                    f"{', '.join(OF_KIND[kind])}" + (f"; else give --scale, what 1 {column.unit} is in the unit of the result"
                                                     if kind == "length" else ""))


def fill(table, rows, heads, wanted, source):
    """Reads the numbers of the columns; rows of words are left out."""
    columns = {what: c for what, c in table.columns.items() if wanted[what].kind}
    marks = {what: c for what, c in table.columns.items() if not wanted[what].kind}
    kept, words = [], []
    for row in rows:
        cells = {what: row[c.index] if c.index < len(row) else "" for what, c in columns.items()}
        if not any(number_in(cell) for cell in cells.values()):
            words.append(row)
            continue
        kept.append(row)
        table.lines.append(line_of(row))
    for what, column in columns.items():
        column.numbers = np.array([value_of(row, column, wanted[what].kind, heads, source) for row in kept])
    for column in marks.values():
        column.numbers = np.array([row[column.index].strip() if column.index < len(row) else "" for row in kept], dtype=object)
    for row in words[:3]:
        table.notes.append(f'{source}: not used: line {line_of(row)}, "{words_of(row)[:60]}"')
    if len(words) > 3:
        table.notes.append(f"{source}: not used: {len(words) - 3} more rows of words")


def value_of(row, column, kind, heads, source):
    """The number of a row in a column, in the column's unit."""
    where = f"{source}, line {line_of(row)}"
    if column.index >= len(row):
        raise DataError(f"{where} has {len(row)} cells, not {len(heads)}: {column.name} is not finite")
    cell = row[column.index].strip()
    found = number_in(cell)
    if not found:
        told = f'"{cell}" is no number' if cell else "nothing stands there"
        raise DataError(f"{where}: {column.name} is not finite: {told}; fill it in, or leave the row out")
    number, own = found
    if not np.isfinite(number):
        raise DataError(f"{where}: {column.name} is not finite: {cell}")
    if not own:
        return number
    unit, known = unit_of(own, kind)
    if not known or not unit:
        raise DataError(f'{where}: {column.name}: "{cell}" is no number with a unit that tendril knows')
    if not column.unit:  # of the first with one
        column.unit = unit
    return number * in_unit(unit, kind) / in_unit(column.unit, kind)


def in_unit(unit, kind):
    """What 1 of a unit is in that which all of its kind are counted in."""
    if kind == "rate":
        share, per = rate_called(unit)
        return share / (TIMES[per] if per else 1.0)
    return OF_KIND[kind].get(unit, 1.0)

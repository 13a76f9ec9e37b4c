"""Tables of angles over time, as time-lapses of roots and shoots give them.

    t (h), tip_angle (deg), base_angle (deg)         one organ, or the mean of many
    t (h), root, tip angle (deg)                     several, a row an organ and a time
    t (h), root 1 tip (deg), root 2 tip (deg), ...   several, a column each

tip_angle is that of the tip; base_angle that of the base of the growth zone, or of a place so far behind the tip as the heading
says, "base angle at 0.6 mm (deg)". Both count from x1, towards x2, as the scene does. "hours" and "tip_deg" are understood,
what is empty or NA is missing, and columns of errors and counts are not used."""

from __future__ import annotations

import re
from dataclasses import dataclass

import numpy as np

from .errors import DataError
from .readers import is_number, line_of, number_in
from .units import ANGLES, METRES, TIMES, unit_called

ORGANS = ("root", "plant", "seedling", "shoot", "organ", "sample", "individual", "replicate", "hypocotyl", "coleoptile", "id")
ENDS = {"tip": "tip_angle", "apex": "tip_angle", "base": "base_angle"}
FILLING = {"angle", "angles", "theta", "mean", "average", "avg", "of", "the", "at", "zone", "growth", "from", "behind", "no", *ORGANS}
SPREADS = {"se", "sem", "sd", "std", "stdev", "err", "error", "ci", "n", "count", "number", "roots", "plants", "var", "low", "high"}
MISSING = ("", "na", "n/a", "nan", "-", "--", ".", "null", "none")
PLACE = re.compile(rf"(\d+\.?\d*|\.\d+)\s*({'|'.join(sorted(METRES, key=len, reverse=True))})(?![a-z])")
TURNS = 4 * np.pi  # more is no angle in radians


@dataclass
class Column:
    """What a column holds: a time ("t"), the name of an organ ("organ"), an angle by its series' name, or nothing of use ("")."""

    what: str
    unit: str = ""
    organ: str = ""
    behind: float | None = None  # metres from the tip
    heading: str = ""


def words_of(name):
    """The words of a heading, in small letters: of tip_deg and "Root 3, tip" two and three."""
    return re.findall(r"[a-zµμ°º]+|\d+", name.lower())


def column_of(name, unit):
    """A Column, if a heading is one of such a table, else None."""
    place = PLACE.search(name.lower())
    words = words_of(PLACE.sub(" ", name.lower()))
    if len(words) > 1 and unit is None and (said := unit_called(words[-1], "angle")):
        words, unit = words[:-1], said
    ends = [ENDS[word] for word in words if word in ENDS]
    rest = [word for word in words if word not in ENDS]
    heading = f"{name} ({unit})" if unit else name
    if ends and SPREADS & set(words):
        return Column("", heading=heading)
    turned = unit is not None and unit_called(unit, "angle")
    if not (ends or place and ("angle" in words or turned)) or any(word not in FILLING and not word.isdigit() for word in rest):
        return None
    if len(ends) > 1:
        raise DataError(f'"{heading}": is it the tip\'s angle or the base\'s? Write tip_angle or base_angle')
    organ = " ".join(word for word in words if word in ORGANS or word.isdigit())
    behind = float(place[1]) * METRES[place[2]] if place else None
    return Column((ends or ["base_angle"])[0], unit or "", organ, behind, heading)


def time_of(name, unit):
    """A Column of time, of "t (h)" or "hours", or None."""
    words = [word for word in words_of(name) if word not in ("elapsed", "in")]
    if name == "t":
        return Column("t", unit or "")
    said = words and unit_called(words[-1], "time")
    return Column("t", said) if said and words[:-1] in ([], ["t"], ["time"]) and unit is None else None


def columns_of(headings):
    """[Column or None] of a table's headings, (name, unit) each; None where no column is an angle of a tip or base."""
    angles = [column_of(name, unit) for name, unit in headings]
    if not any(one and one.what for one in angles):
        return None
    found = [angle or time_of(name, unit) or (Column("organ") if name.lower() in (*ORGANS, *(f"{o} id" for o in ORGANS)) else None)
             for (name, unit), angle in zip(headings, angles)]
    for (name, unit), one in zip(headings, found):
        if one is None and unit is not None and unit_called(unit, "angle") and not name.lower().endswith("_angle"):
            raise DataError(f'"{name} ({unit})": the angle of what? Write tip_angle ({unit}) or base_angle ({unit})')
    return found


def number(cell, path, row):
    """Of a cell; nan of one that is missing."""
    if cell.strip().lower() in MISSING:
        return np.nan
    if is_number(cell):
        return float(cell)
    if (found := number_in(cell)) and not found[1]:
        return found[0]
    raise DataError(f'{path}, line {line_of(row)}: "{cell.strip()}" is no number; leave what is missing empty')


def checked_unit(column, path, values):
    """The unit of an angle, which must be one, and can be that of its numbers."""
    if not column.unit:
        raise DataError(f"{path}: {column.heading} has no unit; write {column.heading} (deg) or {column.heading} (rad)")
    unit = unit_called(column.unit, "angle")
    if not unit:
        raise DataError(f"{path}: {column.heading}: {column.unit} is no unit of an angle; give one of {', '.join(ANGLES)}")
    if unit == "rad" and (most := np.nanmax(np.abs(values))) > TURNS:
        raise DataError(f"{path}: {column.heading} reaches {most:g} rad; if these are degrees write {column.what} (deg)")
    return unit


def rising(times, rows, path, organ):
    """Refuses times that do not rise, row by row."""
    for k in np.flatnonzero(np.diff(times) <= 0):
        what = f"is {times[k]:g} twice" if times[k] == times[k + 1] else f"falls from {times[k]:g} to {times[k + 1]:g}"
        told = f" of {organ}" if organ else "; of several organs give a column root that tells them apart"
        raise DataError(f"{path}, line {line_of(rows[k + 1])}: t {what}{told}")


def series_of(found, rows, path):
    """[(Column, organ, times, angles)] of the rows of a table whose columns are found; and the unit of t."""
    times = [k for k, one in enumerate(found) if one and one.what == "t"]
    if not times:
        raise DataError(f"{path}: has angles and no column of time; write t (h), or t with another of {', '.join(TIMES)}")
    if len(times) > 1:
        raise DataError(f"{path}: has {len(times)} columns of time; give each organ rows of its own, and a column root")
    named = next((k for k, one in enumerate(found) if one and one.what == "organ"), None)
    cell = lambda row, k: row[k] if k < len(row) else ""
    t = np.array([number(cell(row, times[0]), path, row) for row in rows])
    groups: dict[str, list[int]] = {}
    for k, row in enumerate(rows):
        groups.setdefault(cell(row, named).strip() if named is not None else "", []).append(k)
    series = []
    for k, column in enumerate(found):
        if column is None or column.what not in ENDS.values():
            continue
        angles = np.array([number(cell(row, k), path, row) for row in rows])
        if np.isfinite(angles).any():
            column.unit = checked_unit(column, path, angles)
        for organ, mine in groups.items():
            if len(lost := [i for i in mine if np.isfinite(angles[i]) and np.isnan(t[i])]):
                raise DataError(f"{path}, line {line_of(rows[lost[0]])}: has an angle and no time")
            kept = [i for i in mine if np.isfinite(angles[i])]
            rising(t[kept], [rows[i] for i in kept], path, f"{found[named].heading or 'root'} {organ}" if organ else column.organ)
            if kept:
                series.append((column, organ or column.organ, t[kept], angles[kept]))
    if not series:
        raise DataError(f"{path}: has headings of angles, and no angle below them")
    return series, found[times[0]].unit

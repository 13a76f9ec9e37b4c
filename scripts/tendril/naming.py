"""Names: those that there are not, beside those that there are; and times that stand in the names of pictures and files: root-20s.png; 2018-03-08_1000.jpg, from the first on; img_0050.png,
by frames per second."""

from __future__ import annotations

import re
from calendar import timegm
from difflib import get_close_matches

from .units import TIMES

WITH_UNIT = re.compile(rf"(?<![A-Za-z0-9.])(?:t\s*=?\s*)?(\d+(?:\.\d+)?)\s*({'|'.join(sorted(TIMES, key=len, reverse=True))})"
                       r"(?![A-Za-z0-9])")
DAY = r"(?<!\d)((?:19|20)\d\d)[-_.]?(0[1-9]|1[0-2])[-_.]?(0[1-9]|[12]\d|3[01])"
STAMP = re.compile(DAY + r"(?:[-_T .]*([01]\d|2[0-3])[-_.:h]?([0-5]\d)(?:[-_.:m]?([0-5]\d))?)?(?!\d)")
ENDING = re.compile(r"(\.[A-Za-z][A-Za-z0-9]*)+$")


def did_you_mean(word, known) -> str:
    """The likeliest names for one that there is not, as the end of a sentence; "" if none is like it."""
    near = get_close_matches(str(word), [str(name) for name in known], 3, 0.75)
    return f", did you mean {' or '.join(near)}?" if near else ""


def unknown(word, known, say="; there are") -> str:
    """The end of a sentence that refuses a name: the likeliest of those that there are, or all of them."""
    return did_you_mean(word, known) or f"{say} {', '.join(map(str, known)) or 'none'}"


def stem(name):
    """A file's name without its directory and its endings."""
    return ENDING.sub("", re.split(r"[\\/]", str(name).strip())[-1])


def options_in(name):
    """{option: value} of the name of a member of a sweep, friction_mu=0.5__growth_width=1; {}: it says none."""
    return dict(pair.split("=", 1) for pair in str(name).split("__") if "=" in pair)


def told_time(name):
    """Seconds, of root-20s.png or t=2.5h.csv; None: it says none."""
    found = WITH_UNIT.search(stem(name))
    return float(found[1]) * TIMES[found[2]] if found else None


def stamp(name):
    """Seconds since some day, of 2018-03-08_1000.jpg or 20180308T100030; None: there is no date in it."""
    found = STAMP.search(stem(name))
    return float(timegm(tuple(int(part or 0) for part in found.groups()))) if found else None


def number(name):
    """The last number in it; None: there is none."""
    found = re.findall(r"\d+", stem(name))
    return float(found[-1]) if found else None


def times_of(names, fps=None):
    """([seconds] that names say, or None; a line that tells it, or ""). They are taken where all of them speak in one way:
    a time with a unit; a date, counted from the first; with frames per second a number."""
    names = [str(name) for name in names]
    if names and all(told_time(name) is not None for name in names):
        return [told_time(name) for name in names], f"times are those of the names, {stem(names[0])} and so on"
    stamps = [stamp(name) for name in names]
    if names and None not in stamps and len(set(stamps)) > 1:
        first = min(stamps)
        return [at - first for at in stamps], f"times are those of the names, t = 0 is {stem(names[stamps.index(first)])}"
    numbers = [number(name) for name in names]
    if None in numbers or len(set(numbers)) < 2:
        return None, ""
    if fps:
        return [at / float(fps) for at in numbers], f"the numbers in the names are frames, {fps:g} per second"
    return None, f"the names count, {stem(names[0])} and so on: give --fps, frames per second, to take that for times"

"""Walls as values of Python, for wall_file of run() and the like:

    tendril.run("feed", contact_diameter=0.1, wall_file=[
        tendril.plane((3, 0), (-1, 0)), tendril.circle((2.6, 0.25), 0.7, friction=0.3)])
    tendril.circle(("26mm", 0), "7mm")      # lengths may carry units

Each gives its line of the file, which the guide describes."""

from __future__ import annotations

from typing import Sequence

import numpy as np

from .errors import TendrilError, arguments
from .runs import text_of


def numbers(what, value, count=None) -> list[str]:
    """Numbers, or text with a unit, as words. count: how many there must be."""
    try:
        flat = np.ravel(np.asarray(value, object))
    except ValueError:  # arrays of several shapes
        flat = ()
    words = [text_of(v.item() if hasattr(v, "item") else v) for v in flat]
    if not words or count and len(words) != count or len(words) % 2 and not count:
        raise TendrilError(f"{what}: give {f'{count} numbers' if count else 'points (x1, x2)'}, not {value!r}")
    return words


def line(words, friction) -> str:
    """friction: that of the wall itself; None: -contact_friction's."""
    return " ".join([*words, *([] if friction is None else ["friction", text_of(friction)])])


def plane(point: Sequence, normal: Sequence, friction=None) -> str:
    """A straight wall through a point; normal: the direction to the side where the rod is."""
    return line(["plane", *numbers("plane: point", point, 2), *numbers("plane: normal", normal, 2)], friction)


@arguments(inside="flag")
def circle(centre: Sequence, radius, inside=False, friction=None) -> str:
    """A round stone; or with inside a round cavity, with the rod in it."""
    return line(["circle", *numbers("circle: centre", centre, 2), *numbers("circle: radius", radius, 1),
                 "inside" if inside else "outside"], friction)


@arguments(inside="flag")
def polygon(corners: Sequence, inside=False, friction=None) -> str:
    """A body with corners [n, 2], in either sense; with inside the rod is in it."""
    return line(["polygon", "inside" if inside else "outside", *numbers("polygon: corners", corners)],
                friction)


def conduit(radius, points: Sequence, friction=None) -> str:
    """A conduit along points [n, 2], open at both ends, the rod in it."""
    return line(["path", *numbers("conduit: radius", radius, 1), *numbers("conduit: points", points)], friction)

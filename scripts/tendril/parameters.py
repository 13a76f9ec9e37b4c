"""What a fit looks for: numbers in options of a scene, between bounds."""

from __future__ import annotations

import re
from dataclasses import dataclass

import numpy as np

from .errors import TendrilError

LOGARITHMIC = 4  # a positive parameter with bounds this far apart is looked for by its logarithm
PER = {"/m": 1, "1/m": 1, "/cm": 1e-2, "1/cm": 1e-2, "/mm": 1e-3, "1/mm": 1e-3}  # of curvatures
MODE = re.compile(r"curvature_mode_(\d+)$")


def with_unit(value):
    """(number, unit) of 0.5, "0.5" or "0.5N/m"."""
    found = re.fullmatch(r"\s*([-+]?(?:[0-9]*\.)?[0-9]+\.?(?:[eE][-+]?[0-9]+)?)\s*(\S*)\s*", str(value))
    if not found:
        raise TendrilError(f"{value}: give a number, or one with a unit")
    return float(found[1]), found[2]


@dataclass
class Parameter:
    """What is looked for, between bounds; inside it is counted from 0 to 1."""

    name: str
    low: float
    high: float
    start: float | None  # None: the middle, and what theory says
    unit: str  # behind the number, as tendril has it

    @classmethod
    def of(cls, name, bounds):
        """bounds: (low, high) or (low, high, start), numbers or text with a unit."""
        numbers = [with_unit(b) for b in (bounds.split(":") if isinstance(bounds, str) else bounds)]
        values, units = [v for v, _ in numbers], {u for _, u in numbers}
        if len(values) not in (2, 3) or not values[0] < values[1]:
            raise TendrilError(f"{name}: give two bounds, the lower first, and a start if one is known")
        if len(units) > 1:
            raise TendrilError(f"{name}: give bounds and start in one unit")
        if MODE.match(name) and units - {"", *PER}:
            raise TendrilError(f"{name}: give its bounds in {', '.join(PER)}, or dimensionless")
        start = values[2] if len(values) == 3 else None
        if start is not None and not values[0] <= start <= values[1]:
            raise TendrilError(f"{name}: the start {start:g} is not within its bounds")
        return cls(name.lstrip("-"), values[0], values[1], start, units.pop())

    @property
    def logarithmic(self):
        return self.low > 0 and self.high >= LOGARITHMIC * self.low

    def value(self, u):
        if self.logarithmic:
            return self.low * (self.high / self.low) ** np.asarray(u)
        return self.low + (self.high - self.low) * np.asarray(u)

    def inside(self, value):
        """The inverse of value()."""
        if self.logarithmic:
            return np.log(value / self.low) / np.log(self.high / self.low)
        return (value - self.low) / (self.high - self.low)

    def text(self, value):
        return f"{float(value)!r}{self.unit}"

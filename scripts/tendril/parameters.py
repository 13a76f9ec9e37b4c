"""What a fit looks for: numbers in options of a scene, between bounds."""

from __future__ import annotations

import ast
import operator
import re
from dataclasses import dataclass

import numpy as np

from .errors import TendrilError
from .units import PER, with_unit

LOGARITHMIC = 4  # a positive parameter with bounds this far apart is looked for by its logarithm
MODE = re.compile(r"curvature_mode_(\d+)$")


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
        given = bounds.split(":") if isinstance(bounds, str) else [bounds] if np.ndim(bounds) == 0 else bounds
        numbers = [with_unit(b) for b in given]
        values, units = [v for v, _ in numbers], {u for _, u in numbers}
        if len(values) not in (2, 3) or not values[0] < values[1]:
            raise TendrilError(f"{name}: give two bounds, the lower first, and a start if one is known: LOW:HIGH or "
                               "LOW:HIGH:START, as in 0.1N/m:2N/m")
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


@dataclass
class Prior:
    """What was known of a parameter beforehand: a normal distribution, in the unit of its bounds."""

    name: str
    mean: float
    deviation: float
    unit: str

    @classmethod
    def of(cls, name, known):
        """known: (mean, standard deviation), numbers or text with a unit, or "mean:deviation"."""
        numbers = [with_unit(k) for k in (known.split(":") if isinstance(known, str) else known)]
        units = {u for _, u in numbers}
        if len(numbers) != 2 or len(units) > 1 or not numbers[1][0] > 0:
            raise TendrilError(f"prior of {name}: give a mean and a standard deviation in one unit, "
                               "0.5N/m:0.1N/m")
        return cls(name.lstrip("-"), numbers[0][0], numbers[1][0], units.pop())

    def bounds(self):
        """Where none are given: five deviations to both sides, of one that must not change its sign not
        beyond a tenth of the mean."""
        low, high = self.mean - 5 * self.deviation, self.mean + 5 * self.deviation
        if self.mean > 0:
            low = max(low, 0.1 * self.mean)
        if self.mean < 0:
            high = min(high, 0.1 * self.mean)
        return f"{low!r}{self.unit}:{high!r}{self.unit}:{self.mean!r}{self.unit}"

    def parameter(self, u, parameters):
        """The value of its parameter at a point, from 0 to 1 each."""
        k = next(k for k, p in enumerate(parameters) if p.name == self.name)
        return float(parameters[k].value(u[k]))


OPERATORS = {ast.Add: operator.add, ast.Sub: operator.sub, ast.Mult: operator.mul, ast.Div: operator.truediv,
             ast.Pow: operator.pow, ast.USub: operator.neg}


def tied_value(name, text, values):
    """What is tied to parameters, as tendril has it: "2*si_friction_dry Ns/m^2", a formula of + - * / **
    with their numbers, and a unit behind a blank. values: {parameter: "0.7N/m"}"""
    formula, _, unit = str(text).strip().partition(" ")
    if " " in unit.strip():
        raise TendrilError(f"tied {name}: {text}: write the formula without blanks, and its unit behind one")

    def number(node):
        if isinstance(node, ast.Expression):
            return number(node.body)
        if isinstance(node, ast.Constant) and isinstance(node.value, (int, float)):
            return float(node.value)
        if isinstance(node, ast.Name) and node.id in values:
            return with_unit(values[node.id])[0]
        if isinstance(node, (ast.BinOp, ast.UnaryOp)) and type(node.op) in OPERATORS:
            parts = [node.operand] if isinstance(node, ast.UnaryOp) else [node.left, node.right]
            return OPERATORS[type(node.op)](*map(number, parts))
        raise ValueError

    try:
        return f"{number(ast.parse(formula, mode='eval'))!r}{unit.strip()}"
    except (ValueError, SyntaxError, ZeroDivisionError, OverflowError):
        raise TendrilError(f"tied {name}: {text}: give a formula of the parameters, {', '.join(values)}, and "
                           f"its own unit behind a blank: 0.5*{next(iter(values), 'a')} N/m") from None

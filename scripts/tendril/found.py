"""The numbers of a fit: estimates, intervals, errors, likelihoods."""

from __future__ import annotations

import json
from dataclasses import dataclass, field

import numpy as np

from .errors import replacing
from .parameters import Parameter
from .problem import Problem
from .results import Results


@dataclass(repr=False)
class Found:
    """What was found. Numbers of parameters are in the units in which their bounds were given."""

    problem: Problem
    u: np.ndarray
    covariance: np.ndarray  # of u
    reach: np.ndarray  # of u, half an interval of 95 %, in standard deviations
    run: Results  # of the best scene
    cost: float
    others: list[float]  # costs of the searches from other starts
    seconds: float
    indistinct: list[str] = field(default_factory=list)  # what cannot be told apart, in words
    warnings: list[str] = field(default_factory=list)  # what speaks against the fit, in words
    interrupted: bool = False  # by Ctrl-C: the best until then
    # with each cause that is named: (parameters, from 0 to 1, halves of their intervals)
    elsewhere: list[tuple[np.ndarray, np.ndarray]] = field(default_factory=list)
    ends: dict = field(default_factory=dict)  # {number: (low, high)} of intervals that are no multiple of a deviation, from 0 to 1
    doubtful: bool = False  # what is left over is no error of points, or the search may not be at its end

    @property
    def parameters(self) -> list[Parameter]:
        return self.problem.parameters

    @property
    def values(self) -> dict[str, float]:
        return {p.name: float(p.value(x)) for p, x in zip(self.parameters, self.u)}

    @property
    def intervals(self) -> dict[str, tuple[float, float]]:
        """Of 95 %, one parameter at a time, within the bounds; where a cause is named, as far as the parameter goes with it."""
        p = len(self.parameters)
        half = (self.reach * np.sqrt(np.diag(self.covariance)))[:p]
        own = np.array([self.ends.get(k, (x - d, x + d)) for k, (x, d) in enumerate(zip(self.u, half))]).T
        ends = np.array([*own]
                        + [u + sign * np.maximum(d, half) for u, d in self.elsewhere for sign in (-1, 1)])
        return {q.name: (float(q.value(max(column.min(), 0))), float(q.value(min(column.max(), 1))))
                for q, column in zip(self.parameters, ends.T)}

    @property
    def trusted(self) -> bool:
        """Whether the intervals are what they say: not of a fit that is bad, that has a cause to be other than it is
        (warnings), or that did not come to its end."""
        return not (self.interrupted or self.doubtful or self.elsewhere)

    @property
    def correlations(self) -> np.ndarray:
        """[parameter, parameter]"""
        deviation = np.sqrt(np.diag(self.covariance))
        p = len(self.parameters)
        return (self.covariance / np.outer(deviation, deviation))[:p, :p]

    @property
    def noise(self) -> dict[str, float]:
        """Standard deviation of what was measured, by group, in SI units, pixels, or dimensionless."""
        return dict(self.problem.noise)

    @property
    def errors(self):
        """{group: noise.Group}: the part of the noise that is of each point, smooth, of a photograph."""
        return dict(self.problem.errors.groups)

    @property
    def log_likelihood(self) -> float:
        """Of the best scene, with the errors as they are estimated."""
        (r,) = self.problem.run([self.u])
        return self.problem.errors.log_likelihood(self.problem.raw(self.u, r))

    @property
    def count(self) -> tuple[int, int]:
        """(residuals, numbers that were found: parameters, those of the camera, those of the errors)"""
        errors = self.problem.errors
        points = sum(len(b.rows) for b in errors.blocks)
        return points, len(self.u) + errors.numbers()

    @property
    def chi2(self) -> float:
        """Sum of squares of the residuals over their errors, which are then independent."""
        (r,) = self.problem.run([self.u])
        raw = self.problem.raw(self.u, r)
        return float(np.sum(self.problem.errors.whitened(raw)[self.problem.errors.mine()] ** 2))

    @property
    def aic(self) -> float:
        return 2 * self.count[1] - 2 * self.log_likelihood

    @property
    def bic(self) -> float:
        return self.count[1] * np.log(self.count[0]) - 2 * self.log_likelihood

    def to_dict(self) -> dict:
        """All that the report says, in plain numbers and lists, as JSON has them."""
        return {"parameters": {p.name: {"value": self.values[p.name], "interval": list(self.intervals[p.name]),
                                        "unit": p.unit, "bounds": [p.low, p.high]} for p in self.parameters},
                "correlations": self.correlations.tolist(),
                "errors": {name: {"point": float(g.sigma), "smooth": float(g.smooth), "reach": float(g.reach),
                                  "photograph": float(g.shift)} for name, g in self.errors.items()},
                "log_likelihood": self.log_likelihood, "aic": self.aic, "bic": self.bic, "chi2": self.chi2,
                "trusted": self.trusted, "points": self.count[0], "runs": self.problem.count, "seconds": self.seconds,
                "indistinct": self.indistinct, "warnings": self.warnings, "notes": self.problem.measured.notes,
                "interrupted": self.interrupted}

    def to_json(self, path) -> None:
        """Writes to_dict() as JSON."""
        with replacing(path) as part:
            part.write_text(json.dumps(self.to_dict(), indent=1) + "\n")

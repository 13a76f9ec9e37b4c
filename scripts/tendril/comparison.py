"""Which of several models the data speak for.

    dry = tendril.fit("tube.opts", "film.csv", {"si_friction_dry": ("1N/m", "20N/m")})
    wet = tendril.fit("tube.opts", "film.csv", {"si_friction_viscous": ("1N/m", "20N/m")}, friction_mu=0)
    print(tendril.compare([dry, wet], names=["dry", "viscous"]))

Both are judged with one model of the errors, that of the fit whose likelihood is larger with its own: a bad
model calls what it lacks an error, and would be forgiven. Akaike's weight exp(-dAIC/2), normalised, says how
surely one of them is the best of these for data yet to come; it does not say that it is right (see the
warnings)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Sequence

import numpy as np

from .errors import TendrilError
from .fitting import Fit

SURELY = (10, 4)  # differences of AIC that are decisive, that are clear


@dataclass(repr=False)
class Comparison:
    """What the data say of some fits; arrays have an entry a fit."""

    names: list[str]
    log_likelihood: np.ndarray
    numbers: np.ndarray  # of each that were found
    aic: np.ndarray
    bic: np.ndarray
    chi2: np.ndarray
    weight: np.ndarray  # Akaike's

    @property
    def best(self) -> str:
        return self.names[int(np.argmin(self.aic))]

    def __repr__(self):
        width = max(len(name) for name in self.names)
        lines = [f"{'':{width}}   log-likelihood   numbers       AIC       BIC      chi2    weight"]
        for row in zip(self.names, self.log_likelihood, self.numbers, self.aic, self.bic, self.chi2, self.weight):
            lines.append("{0:{w}}   {1:14.2f}   {2:7d} {3:9.2f} {4:9.2f} {5:9.2f}   {6:7.2g}".format(*row, w=width))
        order = np.argsort(self.aic)
        if len(order) > 1:
            gap = self.aic[order[1]] - self.aic[order[0]]
            how = "decisively" if gap > SURELY[0] else "clearly" if gap > SURELY[1] else "hardly"
            lines.append(f"{self.best} is {how} better than {self.names[order[1]]} (AIC differs by {gap:.3g})"
                         if gap > SURELY[1] else f"these data hardly tell {self.best} from "
                         f"{self.names[order[1]]} (AIC differs by {gap:.2g})")
        return "\n".join(lines)

    def frame(self):
        import pandas

        return pandas.DataFrame({"log_likelihood": self.log_likelihood, "numbers": self.numbers, "aic": self.aic,
                                 "bic": self.bic, "chi2": self.chi2, "weight": self.weight}, self.names)


def same_data(fits):
    """Whether all fits have the same points."""
    def points(f):
        m = f.problem.measured
        return [p.points.numbers for p in m.photographs] + [c.values.numbers for c in m.curves]

    first = points(fits[0])
    return all(len(points(f)) == len(first) and all(np.array_equal(a, b) for a, b in zip(points(f), first))
               for f in fits[1:])


def compare(fits: Sequence[Fit], names: Sequence[str] | None = None) -> Comparison:
    """Compares fits of different scenes or parameters to the same data.

    Raises TendrilError where the data are not the same."""
    fits = list(fits)
    names = list(names or (f"fit {k + 1}" for k in range(len(fits))))
    if len(fits) < 2 or len(names) != len(fits):
        raise TendrilError("compare: give two fits or more, and a name for each")
    if not same_data(fits):
        raise TendrilError("compare: the fits are not of the same data; likelihoods then tell nothing")
    errors = max(fits, key=lambda f: f.log_likelihood).problem.errors
    count = fits[0].count[0]
    likelihood, chi2 = [], []
    for f in fits:
        raw = f.problem.raw(f.u, f.run)
        likelihood.append(errors.log_likelihood(raw))
        chi2.append(float(np.sum(errors.whitened(raw)[errors.mine()] ** 2)))
    likelihood, numbers = np.array(likelihood), np.array([len(f.u) + errors.numbers() for f in fits])
    aic = 2 * numbers - 2 * likelihood
    weight = np.exp(-(aic - aic.min()) / 2)
    return Comparison(names, likelihood, numbers, aic, numbers * np.log(count) - 2 * likelihood, np.array(chi2),
                      weight / weight.sum())

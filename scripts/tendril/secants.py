"""Least squares where each derivative is a run: a step puts derivatives right."""

from __future__ import annotations

import numpy as np
from scipy import optimize

CURVED = 0.3  # of a change of the residuals: what derivatives may leave unsaid of it, before they are made anew


class Flat(Exception):
    """At the point, its argument, no number changes any residual, not even by rounding: least_squares would divide by that."""


class Still(Exception):
    """At the point, its argument, the residuals have no slope, as where all are 0: least_squares would divide by that."""


class Stale(Exception):
    """A step led nowhere, and the derivatives were not made where it began."""


class Secant:
    """Of residuals f at a point u, [residual, number]. After a step s = v - u of a search they are put right along it,
    as Broyden does, in numbers scaled by W = diag |J_k|,

        J <- J + (f(v) - f(u) - J s) (W^2 s)^T / (s^T W^2 s),

    and made anew where that is too much, or where a step then leads nowhere (Stale)."""

    def __init__(self, made, wanted):
        self.made, self.wanted = made, wanted  # the function that makes them; whether to put them right at all
        self.u = self.f = self.matrix = None  # where they are of
        self.last = None  # the last point that was looked at
        self.count = 0  # of these
        self.updated = False

    def seen(self, f, fell):
        """Tells of a point that was looked at, and whether the cost fell."""
        self.last, self.count = f, self.count + 1
        if self.updated and not fell:
            raise Stale

    def __call__(self, u):
        if self.wanted and self.matrix is not None:
            step, change = u - self.u, self.last - self.f
            left = change - self.matrix @ step
            self.updated = bool(np.linalg.norm(left) < CURVED * np.linalg.norm(change))
        if self.updated:
            along = np.sum(self.matrix**2, axis=0) * step
            self.matrix = self.matrix + np.outer(left, along) / (along @ step)
        else:
            self.matrix = self.made(u)
        self.u, self.f = np.array(u), self.last
        if not self.matrix.any():
            raise Flat(self.u)
        if not (self.f @ self.matrix).any():
            raise Still(self.u)
        return self.matrix

    def begin_anew(self):
        """Where the search goes on, with derivatives that are made there."""
        self.matrix, self.updated = None, False
        self.count -= 1  # that point is looked at again, without a run
        return self.u


def least(residuals, derivatives, cost, begin, *, wanted, most, **more):
    """(where the cost of the residuals is least, the cost), from a point on, in so many points at most: by scipy's
    least_squares with more of its options. wanted: derivatives are put right by steps (Secant), but those at the end
    were made there."""
    slopes, lowest = Secant(derivatives, wanted), np.inf

    def seen(u):
        nonlocal lowest
        f = residuals(u)
        now = cost(f)
        fell, lowest = now < lowest, min(now, lowest)
        slopes.seen(f, fell)
        return f

    while True:
        try:
            found = optimize.least_squares(seen, begin, slopes, gtol=None, x_scale="jac", max_nfev=most - slopes.count, **more)
            end = found.x, found.cost
        except Stale:
            end = slopes.u, lowest
        except Still as still:
            return still.args[0], lowest
        if not slopes.updated or slopes.count >= most - 1:
            return end
        begin = slopes.begin_anew()

"""The least cost with one number held: how an interval ought to be where the linearised problem tells none.

At a fold of the search, as where memory and proprioception of a root could as well be exchanged, derivatives along a valley of
the cost are 0 and the linearised interval is endless; the cost rises with higher powers. There the valley is followed."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from .errors import RunError
from .noise import Certainty
from .problem import Problem, Solution

STILL = 3e-3  # of the cost: less is no fall
WIDE = 0.25  # of the bounds: an interval that is linearised and has such a half is followed
TOGETHER = 0.95  # correlation from which on a number goes along a valley with another
STEPS = (0.03, 0.07, 0.14, 0.25, 0.4, 0.6, 1.0)  # from the estimate, in parts of the bounds


def held(problem: Problem, u, k):
    """(the least cost from a point on with number k held, where that is): two Gauss-Newton steps."""
    best = problem.cost(problem.residuals(u))
    for _ in range(2):
        jacobian = np.delete(problem.jacobian(u), k, axis=1)
        if not jacobian.shape[1]:
            return best, u
        step = -np.linalg.lstsq(jacobian, problem.residuals(u), rcond=None)[0]
        new = u + np.insert(step, k, 0.0)
        new[:len(problem.parameters)] = np.clip(new[:len(problem.parameters)], 0, 1)
        cost = problem.cost(problem.residuals(new))
        if cost > best - STILL:
            return (cost, new) if cost < best else (best, u)
        best, u = cost, new
    return best, u


class Valley(NamedTuple):
    """The points of a valley, from one end of an interval to the other."""

    points: np.ndarray  # [m, number]
    open: tuple  # whether it goes on beyond the bounds, below and above


def side(problem: Problem, u, k, cost, rise, slope, sign):
    """([points] from the estimate to where the cost has risen so far, whether the bound comes first)."""
    points, risen = [np.array(u)], [0.0]
    bound, p = (u[k] if sign < 0 else 1 - u[k]), len(problem.parameters)
    for step in (*(s for s in STEPS if s < bound), bound):
        ahead = points[-1] - points[-2] if len(points) > 1 else sign * slope
        there = points[-1] + ahead * (u[k] + sign * step - points[-1][k]) / ahead[k]
        there[:p] = np.clip(there[:p], 0, 1)
        there[k] = np.clip(u[k] + sign * step, 0, 1)
        try:
            least, there = held(problem, there, k)
        except RunError:  # no rod there
            return points, False
        points.append(there)
        risen.append(max(least - cost, 0.0))
        if risen[-1] > rise:
            # the cost rises as a power of the distance, so its root is nearer to a line
            part = (rise**0.5 - risen[-2] ** 0.5) / (risen[-1] ** 0.5 - risen[-2] ** 0.5)
            points[-1] = points[-2] + part * (there - points[-2])
            return points, False
    return points, True


def valley(problem: Problem, u, k, cost, rise, slope) -> Valley:
    """The least cost with number k held, to both sides of the estimate u until it has risen so far. slope: how the others
    follow k at first, with 1 for k itself."""
    (below, low), (above, high) = (side(problem, u, k, cost, rise, slope, sign) for sign in (-1, 1))
    return Valley(np.array([*below[:0:-1], *above]), (low, high))


def followed_out(problem: Problem, best: Solution, known: Certainty, rises, tell):
    """{number: (low, high)} of parameters whose linearised intervals are too wide to be believed, as parts of their bounds:
    as far as the cost rises by so much."""
    p, ends = len(problem.parameters), {}
    deviations = np.sqrt(np.maximum(np.diag(known.covariance), 1e-300))
    half, alike = (known.reach * deviations)[:p], np.abs(known.covariance / np.outer(deviations, deviations))
    for k in np.argsort(-half):
        if half[k] < WIDE or k in ends:
            continue
        tell(f"following {problem.parameters[k].name}, of which derivatives tell little")
        found = valley(problem, best.u, k, best.cost, rises[k], known.covariance[:, k] / known.covariance[k, k])
        for j in range(p):
            if j == k or half[j] >= WIDE and alike[j, k] > TOGETHER:
                low, high = float(found.points[:, j].min()), float(found.points[:, j].max())
                if j != k and any(found.open):  # where the valley leaves the bounds others would go on
                    low, high = 0.0, 1.0
                ends[j] = low, high
    return ends

"""Fits options of a scene to what was measured.

    f = tendril.fit("mytube.opts", "photos.csv", {"si_friction_dry": ("0.1N/m", "2N/m"),
                                                  "rod_curvature": ("-10/m", "10/m")})
    print(f.report())
    f.save("fit")           # fit.opts, fit.png, fit.csv

Any option with a number is a parameter, by its bounds and, if one is known, a start. So is a word in
braces in the text of another option: friction_layers="0:1,3:{hard}" with {"hard": (1, 10)}; and so are
curvature_mode_1, _2, ...: the natural curvature sum of mode_k cos((k-1) pi s), over the label s of a
rod that grows in place, over the distance from the tip, as a part of the final length, of one that
slides (feed, apical); in 1/m and the like, or dimensionless.

The sum of squares of the residuals, over their noise, is made least by scipy's least_squares, with
Huber's loss against outliers. Runs for the derivatives are made side by side. The noise is estimated
from the residuals, of each series and of the centre lines by itself. Intervals are those of the
linearised problem (Huber's covariance, Student's t), widened where a run along a principal axis of
the covariance shows that the sum of squares rises more slowly than it should.
"""
from __future__ import annotations

import time
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from typing import Mapping

import numpy as np
from scipy import stats

from .errors import RunError, TendrilError
from .fit_report import describe, draw, indistinct, save, scene_text, table
from .measured import gather
from .parameters import Parameter
from .problem import HUBER, Problem, Solution
from .results import Results
from .starting import starting_points

SEARCH = 10  # the search for a start is made with this many times the error of the final runs
FOLLOWED = 6  # evaluations for which two searches go on side by side, before one
CLOSE, ROUGH = 3e-3, 1e-2  # tolerances of these two, and of the one, which is polished after
BETTER = 0.05  # less of the cost is no reason to go on: 1.92 is that of an interval's end
CONFIDENCE = 0.95


@dataclass(repr=False)
class Fit:
    """What was found. Numbers of parameters are in the units in which their bounds were given."""

    problem: Problem
    u: np.ndarray
    covariance: np.ndarray  # of u
    run: Results  # of the best scene
    freedom: int
    cost: float
    others: list[float]  # costs of the searches from other starts
    seconds: float
    indistinct: list[str] = field(default_factory=list)  # what cannot be told apart, in words

    def __repr__(self):
        return self.report()

    @property
    def parameters(self) -> list[Parameter]:
        return self.problem.parameters

    @property
    def values(self) -> dict[str, float]:
        return {p.name: float(p.value(x)) for p, x in zip(self.parameters, self.u)}

    @property
    def intervals(self) -> dict[str, tuple[float, float]]:
        """Of 95 %, one parameter at a time, within the bounds."""
        reach = stats.t.ppf((1 + CONFIDENCE) / 2, self.freedom) * np.sqrt(np.diag(self.covariance))
        return {p.name: tuple(float(p.value(np.clip(x + sign * d, 0, 1))) for sign in (-1, 1))
                for p, x, d in zip(self.parameters, self.u, reach)}

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

    def residuals(self):
        """What was measured beside what the best scene gives, as a pandas DataFrame."""
        return table(self)

    def report(self) -> str:
        return describe(self)

    def plot(self):
        """A figure of what was measured beside the best scene."""
        return draw(self)

    def scene(self) -> str:
        """The best scene as an options file."""
        return scene_text(self)

    def save(self, basename):
        """Writes BASENAME.opts, the best scene; .txt, the report; .csv, residuals; .png and .pdf."""
        save(self, basename)


def huber_covariance(problem: Problem, f, jacobian):
    """Of all that is looked for, and the freedom that is left. f: residuals over their noise."""
    n, p = jacobian.shape
    influence = np.clip(f, -HUBER, HUBER)
    factor = np.mean(influence**2) / max(np.mean(np.abs(f) <= HUBER), 0.1) ** 2 * n / max(n - p, 1)
    # a prior as wide as the bounds, so that what the data do not fix has an end, too
    bounded = np.r_[np.ones(len(problem.parameters)), np.zeros(p - len(problem.parameters))]
    information = jacobian.T @ jacobian / factor + np.diag(bounded) * 1e-6
    return np.linalg.pinv(information, hermitian=True), max(n - p, 1)


def widened(problem: Problem, u, covariance, cost):
    """(the covariance with its principal axes as long as runs along them tell, the best point among
    these runs, its cost). Where the cost rises less than the linearised problem says, the axis is that
    much longer; where it falls, the search was not at its end."""
    p = len(problem.parameters)
    variance, axes = np.linalg.eigh(covariance[:p, :p])
    reach = np.minimum(stats.norm.ppf((1 + CONFIDENCE) / 2) * np.sqrt(np.maximum(variance, 0)), 0.5)
    rest = covariance[p:, :p] @ np.linalg.pinv(covariance[:p, :p])  # how the other numbers follow
    trials = []
    for d, axis in zip(reach, axes.T):
        for sign in (-1, 1):
            step = sign * d * axis
            inside = np.clip(u[:p] + step, 0, 1)
            trials.append(np.r_[inside, u[p:] + rest @ (inside - u[:p])])
    problem.run([t[:p] for t in trials])
    inverse = np.linalg.pinv(covariance, hermitian=True)
    costs = [problem.cost(problem.residuals(trial)) for trial in trials]
    longer = np.ones(p)
    for k, (trial, reached) in enumerate(zip(trials, costs)):
        expected = 0.5 * (trial - u) @ inverse @ (trial - u)
        if expected > 1e-3:
            risen = max(reached - cost, 1e-4 * expected)
            longer[k // 2] = max(longer[k // 2], np.sqrt(expected / risen))
    whole = np.eye(len(u))
    whole[:p, :p] = axes @ np.diag(longer) @ axes.T
    least = int(np.argmin(costs))
    return whole @ covariance @ whole.T, trials[least], costs[least]


def search(problem: Problem, starts, accuracy, seed, tell):
    """The best of the searches from several starts, and the costs of all."""
    middle = np.array([0.5 if p.start is None else p.inside(p.start) for p in problem.parameters])
    problem.prepare(middle, accuracy)
    points = starting_points(problem, starts, seed)
    tell(f"{len(points)} starts")
    runs = problem.run(points)
    good = [(u, r) for u, r in zip(points, runs) if not isinstance(r, RunError)]
    if not good:
        raise runs[0]
    whole = [np.r_[u, problem.comparison.guess(r)] for u, r in good]
    problem.measure_noise(whole[0], share=0.03)
    ranked = sorted(whole, key=lambda u: problem.cost(problem.residuals(u)))
    with ThreadPoolExecutor() as pool, problem.shared(len(ranked[:2])):
        found = list(pool.map(lambda u: problem.solve(u, CLOSE, ahead=False, most=FOLLOWED), ranked[:2]))
    tell("costs of the searches: " + " and ".join(f"{s.cost:.4g}" for s in found) + ", the best goes on")
    best = problem.solve(min(found, key=lambda s: s.cost).u, ROUGH)
    return best, [s.cost for s in found]


def certain(problem: Problem, best: Solution, tell, most=4):
    """(the least cost, its covariance, the freedom): as long as a run on a principal axis is better than
    the best, the search goes on from there."""
    for last in range(most):
        problem.measure_noise(best.u)
        f = problem.residuals(best.u)
        best = Solution(best.u, problem.cost(f))
        covariance, freedom = huber_covariance(problem, f, problem.central_jacobian(best.u))
        covariance, other, cost = widened(problem, best.u, covariance, best.cost)
        if cost > best.cost - BETTER or last == most - 1:
            return best, covariance, freedom
        best = problem.solve(other, 1e-4)
        tell(f"a better one beside it, {problem.count} runs")


def fit(scene, data, parameters: Mapping[str, tuple | str], *, unit: str = "", accuracy: float = 3e-4,
        starts: int | None = None, seed: int = 1, jobs: int | None = None, progress: bool = False,
        **options) -> Fit:
    """Finds the parameters of a scene that give what was measured.

    scene       as for run
    data        a CSV file, several in a list, or {"20s": photograph}; see tendril.measured
    parameters  {"si_friction_dry": ("0.1N/m", "2N/m"), "clamp_angle": (-0.2, 0.2, 0)}: bounds, and a
                start where one is known
    unit        of coordinates that carry none: "cm", "px"
    accuracy    of the runs; the search for a start takes ten times that
    starts      points that fill the bounds, beside the start itself; the two best are followed. None: 24
                for one parameter, 12 for two, else 8
    seed        of these points
    options     that all runs have, as for run; {name} in their text is a parameter

    Raises TendrilError, in one line, for data or a scene that cannot be read or run."""
    begin, measured = time.perf_counter(), gather(data, unit)
    tell = (lambda text: print(f"fit: {text}", flush=True)) if progress else (lambda text: None)
    looked_for = [Parameter.of(name, bounds) for name, bounds in parameters.items()]
    if not looked_for:
        raise TendrilError('fit: give what to look for, {"si_friction_dry": ("0.1N/m", "2N/m")}')
    problem = Problem(scene, measured, looked_for, options, jobs)
    p = len(looked_for)
    starts = max(8, 24 // p) if starts is None else starts
    best, costs = search(problem, starts, SEARCH * accuracy, seed, tell)
    problem.prepare(best.u[:p], accuracy)
    (r,) = problem.run([best.u[:p]])
    best.u = np.r_[best.u[:p], problem.comparison.guess(r, best.u[p:])]  # times, now that it looks so
    for tolerance in (1e-3, 1e-4):  # the noise as the residuals tell it, then once more
        problem.measure_noise(best.u)
        best = problem.solve(best.u, tolerance)
    tell(f"{problem.count} runs, polished")
    best, covariance, freedom = certain(problem, best, tell)
    r = problem.first(best.u[:p], problem.settings)
    found = Fit(problem, best.u, covariance, r, freedom, best.cost, costs, time.perf_counter() - begin)
    found.indistinct = indistinct(found)
    return found

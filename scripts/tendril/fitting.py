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

import re
import time
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from typing import Mapping, Sequence

import numpy as np
from scipy import optimize, stats

from .comparing import Comparison, time_of
from .errors import RunError, TendrilError
from .fit_report import describe, draw, indistinct, scene_text, table
from .measured import Measured, gather
from .results import Results
from .runs import critical
from .sweeps import cores, run_all
from .units import scales_of_rod

HUBER = 1.345  # 95 % efficiency for normal noise
STEP, FINE_STEP = 3e-3, 1e-2  # of differences, in parts of a parameter's bounds: forward, central
SEARCH = 10  # the search for a start is made with this many times the error of the final runs
SHAPES = 120  # stored in a run, between which shapes are interpolated
LOGARITHMIC = 4  # a positive parameter with bounds this far apart is looked for by its logarithm
BETTER = 0.05  # less of the cost is no reason to go on: 1.92 is that of an interval's end
FAILED = 1e3  # a residual, in noise, of a run that failed
CONFIDENCE = 0.95
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


@dataclass
class Solution:
    """A point of the search: of all that is looked for, the run that belongs to it, the cost."""

    u: np.ndarray  # parameters from 0 to 1, then the comparison's own numbers
    cost: float


class Problem:
    """A scene, what is looked for in it, and what was measured: runs and residuals at any point."""

    def __init__(self, scene, measured: Measured, parameters: Sequence[Parameter], options, jobs=None):
        self.scene, self.measured, self.parameters = scene, measured, list(parameters)
        self.options, self.jobs = dict(options), jobs or 2 * cores()
        self.comparison = Comparison(measured)
        self.settings: dict = {}  # end, stored shapes, cells and tolerance of all runs
        self.glimpse = self.begin = None  # a run at the first point, for what it says of the scene
        self.reach = 1.0  # length at the end, in units of that run
        # parameters that are words in braces in the text of another option
        self.inserted = {p.name for p in self.parameters for text in self.options.values()
                         if isinstance(text, str) and "{" + p.name + "}" in text}
        self.noise: dict[str, float] = {}
        self.count = 0  # of runs
        self.known: dict = {}  # runs by their point

    def words(self, u):
        """The options of a run, apart from its settings; u: parameters, from 0 to 1."""
        values = {p.name: p.text(p.value(x)) for p, x in zip(self.parameters, u)}
        modes = {int(MODE.match(name)[1]): with_unit(values.pop(name)) for name in list(values)
                 if MODE.match(name)}
        options = {}
        for name, value in self.options.items():
            if isinstance(value, str) and "{" in value:
                try:
                    value = value.format_map(values)
                except (KeyError, ValueError, IndexError):
                    raise TendrilError(f"{name} {value}: what stands in braces is no parameter") from None
            options[name.lstrip("-")] = value
        values = {name: text for name, text in values.items() if name not in self.inserted}
        if modes and self.glimpse is not None:
            options["rod_curvature_file"] = self.curvature(modes, u)
        return options | values

    def unit_length(self, u):
        """1 of tendril's unit of length in m at a point, 1 without laboratory units."""
        rod = dict(self.glimpse.attributes)
        for p, x, x0 in zip(self.parameters, u, self.begin):
            if p.name.startswith("si_"):
                rod[f"parameters/{p.name}"] *= p.value(x) / p.value(x0)
        return scales_of_rod(rod).get("length", 1.0)

    def curvature(self, modes, u):
        """The arrays of -rod_curvature_file for some modes, {number: (amplitude, unit)}."""
        s, unit = np.linspace(0, 1, 201), self.unit_length(u)
        reach = self.reach * self.unit_length(self.begin) / unit
        slides = self.glimpse.attributes["parameters/growth_type"] in ("feed", "apical")
        bend = sum(a * (unit / PER[per] if per else 1) * np.cos((k - 1) * np.pi * s)
                   for k, (a, per) in modes.items())
        return {"distance" if slides else "s": s * (reach if slides else 1), "curvature": bend}

    def run(self, points) -> list[Results | RunError]:
        """Runs at these points, side by side; those that were made before are not made again."""
        keys = [tuple(np.round(np.asarray(u, float), 12)) for u in points]
        new = [key for key in dict.fromkeys(keys) if key not in self.known]
        for key, r in zip(new, run_all([self.words(key) | self.settings for key in new], self.scene,
                                       self.jobs, progress=False)):
            self.known[key] = r
        self.count += len(new)
        return [self.known[key] for key in keys]

    def ends(self):
        """Options by which a run ends with the last of what was measured; and the span it covers."""
        end = {}
        for abscissa, option in (("t", "ts_max_time"), ("length", "stop_length")):
            found = self.measured.abscissae(abscissa)
            if found:
                last = max(found, key=lambda v: np.max(v.numbers))
                unit = {"t": "s", "length": "m"}[abscissa] if last.si else ""
                end[option] = f"{float(np.max(last.numbers)) * (1 + 1e-9)!r}{unit}"
        return end

    def prepare(self, u, accuracy):
        """Chooses how all runs are made, from one at u: their end, which shapes they store, and cells
        and tolerance for an accuracy; so that runs differ by their parameters alone."""
        self.known, self.settings, self.glimpse = {}, {}, None
        self.glimpse, self.begin = self.first(u, {"ts_max_time": 1e-6}), u
        end = self.ends()
        if "stop_length" in end and "ts_max_time" not in end:
            last = max(self.measured.abscissae("length"), key=lambda v: np.max(v.numbers))
            reach = float(np.max(last.numbers)) / (self.glimpse.scale("length") if last.si else 1)
            end["ts_max_time"] = 1.2 * max(reach - float(self.glimpse.series.length[0]), 0.1)
        if any(MODE.match(p.name) for p in self.parameters):
            self.reach = self.first(u, end | {"rod_cells": 40, "ts_rtol": 1e-3}).series.length[-1]
        chosen = self.first(u, end | {"accuracy": accuracy})
        self.check_end(chosen)
        for name in ("rod_cells", "ts_rtol"):
            end.setdefault(name, chosen.options.get(name))
        if "stop_length" in end and "ts_max_time" not in self.ends():
            end["ts_max_time"] = 10 * end["ts_max_time"]  # the length decides, however stiff the rod
        end["output_interval"] = float(chosen.series.t[-1]) / SHAPES
        self.settings |= {k: v for k, v in end.items() if v is not None and k not in self.options}
        self.known = {}

    def check_end(self, r: Results):
        """A run must go on for as long as something was measured."""
        for abscissa in ("t", "length"):
            for at in self.measured.abscissae(abscissa):
                si = r.scale({"t": "time", "length": "length"}[abscissa]) if at.si else 1
                last, end = np.max(at.numbers), r.series[abscissa][-1] * si
                if end < last * (1 - 1e-6):
                    raise TendrilError(f"the scene ends at {abscissa} = {end:.6g}, before the last of what was "
                                       f"measured, at {last:.6g}; take out what ends it (-stop_...)")

    def first(self, u, settings):
        """A run that must not fail."""
        (r,) = run_all([self.words(u) | settings], self.scene, self.jobs, progress=False)
        self.count += 1
        if isinstance(r, RunError):
            raise r
        return r

    def residuals(self, u, r=None):
        """Residuals over their noise, at a point of all that is looked for."""
        p = len(self.parameters)
        if r is None:
            (r,) = self.run([u[:p]])
        if isinstance(r, RunError):
            return np.full(len(self.sigma), FAILED)
        return self.comparison.residuals(r, u[p:]) / self.sigma

    def measure_noise(self, u, share=None):
        """Sets the noise of each group: a share of what was measured, or what the residuals at u
        tell, by their median so that outliers do not count."""
        (r,) = self.run([u[:len(self.parameters)]])
        if isinstance(r, RunError):
            raise r
        values = self.comparison.residuals(r, u[len(self.parameters):])
        groups, spreads = np.array(self.comparison.groups), self.comparison.spreads()
        freedom = np.sqrt(max(1e-3, 1 - len(u) / len(values)))
        for name in dict.fromkeys(groups):
            told = np.median(np.abs(values[groups == name])) / stats.norm.ppf(0.75)
            least = 1e-6 * spreads[name]  # data without noise
            self.noise[name] = share * spreads[name] if share else max(told / freedom, least)
        self.sigma = np.array([self.noise[name] for name in groups])

    def cost(self, f):
        """Half the sum that least_squares makes least."""
        z = (f / HUBER) ** 2
        return 0.5 * HUBER**2 * float(np.sum(np.where(z <= 1, z, 2 * np.sqrt(z) - 1)))

    def neighbours(self, u, size):
        """(points a step away from u, one a number; the steps, which keep within the bounds)"""
        p = len(self.parameters)
        steps = np.where((np.asarray(u) + size > 1) & (np.arange(len(u)) < p), -size, size)
        return u + np.diag(steps), steps

    def jacobian(self, u):
        """[residual, number], by forward differences; the runs are made side by side."""
        points, steps = self.neighbours(u, STEP)
        self.run([u[:len(self.parameters)], *points[:, :len(self.parameters)]])
        here = self.residuals(u)
        return np.column_stack([(self.residuals(a) - here) / h for a, h in zip(points, steps)])

    def central_jacobian(self, u):
        """The same by central differences, but at a bound."""
        p = len(self.parameters)
        ahead, steps = self.neighbours(u, FINE_STEP)
        behind = 2 * u - ahead
        behind[:, :p] = np.clip(behind[:, :p], 0, 1)
        self.run([*ahead[:, :p], *behind[:, :p]])
        return np.column_stack([(self.residuals(a) - self.residuals(b)) / (a - b)[k]
                                for k, (a, b) in enumerate(zip(ahead, behind))])

    def with_neighbours(self, u):
        """Residuals. The derivatives are mostly asked for next: their runs are made at the same time."""
        p = len(self.parameters)
        self.run([u[:p], *self.neighbours(u, STEP)[0][:, :p]])
        return self.residuals(u)

    def bounds(self, u):
        p = len(self.parameters)
        return (np.r_[np.zeros(p), np.full(len(u) - p, -np.inf)],
                np.r_[np.ones(p), np.full(len(u) - p, np.inf)])

    def solve(self, u, tolerance, ahead=True, most=15) -> Solution:
        """The least cost from a start. ahead: runs for derivatives are made before they are asked for,
        as there are cores for them."""
        inside = np.clip(u, *[b + s for b, s in zip(self.bounds(u), (1e-6, -1e-6))])
        found = optimize.least_squares(self.with_neighbours if ahead else self.residuals, inside,
                                       self.jacobian, self.bounds(u), loss="huber",
                                       f_scale=HUBER, x_scale="jac", xtol=tolerance,
                                       ftol=tolerance, gtol=None, max_nfev=most)
        return Solution(found.x, found.cost)


def starting_points(problem: Problem, starts, seed):
    """Parameters, from 0 to 1, from which the search may begin: those asked for (else the middle of
    their bounds), those of the straight rod's theory, and some that fill the bounds evenly."""
    first = np.array([0.5 if p.start is None else p.inside(p.start) for p in problem.parameters])
    cube = stats.qmc.LatinHypercube(len(first), seed=seed).random(max(starts, 0))
    free = np.array([p.start is None for p in problem.parameters])
    theory = theory_start(problem, first) if free.any() else None
    return [first, *([theory] if theory is not None else []), *cube]


SCALES = {"si_bending_stiffness": 3, "si_friction_dry": -3, "si_friction_viscous": -3}


def theory_start(problem: Problem, u):
    """The point at which the straight rod gives way at the length at which the measured one is first
    seen to be bent: one of stiffness and friction is chosen so. None where that tells nothing."""
    free = [k for k, p in enumerate(problem.parameters) if p.start is None and p.name in SCALES]
    (r,) = problem.run([u])
    bent = bent_length(problem.comparison, r) if free and not isinstance(r, RunError) else None
    if bent is None:
        return None
    try:
        words = problem.words(u) | {"rod_curvature": 0}
        c = critical(problem.scene, **{k: v for k, v in words.items() if k != "rod_curvature_file"})
    except RunError:
        return None
    k = free[0]
    p = problem.parameters[k]
    value = p.value(u[k]) * (bent / c.length) ** SCALES[p.name]
    moved = np.array(u)
    moved[k] = np.clip(p.inside(np.clip(value, p.low, p.high)), 0.02, 0.98)
    return moved


def bent_length(comparison: Comparison, r: Results, share=0.05):
    """The least length, as the run counts it, at which what was measured is bent: the width of a
    photograph, or the series width, more than a share of its extent. None if it never is."""
    found = []
    for p in comparison.measured.photographs:
        if p.abscissa and not comparison.camera:
            points = comparison.plain_points(r, p, [])
            if np.ptp(points[:, 1]) > share * np.ptp(points[:, 0]):
                found.append(r.value("length", float(time_of(r, p.abscissa, p.at))))
    for c in comparison.measured.curves:
        if c.name == "width":
            length = np.interp(time_of(r, c.abscissa, c.at), r.series.t, r.series.length)
            width = c.values.numbers / (r.scale("length") if c.values.si else 1)
            found += list(length[width > share * length][:1])
    return min(found, default=None)


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
        from .fit_report import save
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
    with ThreadPoolExecutor() as pool:
        found = list(pool.map(lambda u: problem.solve(u, 3e-3, ahead=False), ranked[:2]))
    tell("searches end at " + " and ".join(f"{s.cost:.4g}" for s in found))
    return min(found, key=lambda s: s.cost), [s.cost for s in found]


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
        starts: int = 8, seed: int = 1, jobs: int | None = None, progress: bool = False,
        **options) -> Fit:
    """Finds the parameters of a scene that give what was measured.

    scene       as for run
    data        a CSV file, several in a list, or {"20s": photograph}; see tendril.measured
    parameters  {"si_friction_dry": ("0.1N/m", "2N/m"), "clamp_angle": (-0.2, 0.2, 0)}: bounds, and a
                start where one is known
    unit        of coordinates that carry none: "cm", "px"
    accuracy    of the runs; the search for a start takes ten times that
    starts      points that fill the bounds, beside the start itself; the two best are followed
    seed        of these points
    options     that all runs have, as for run; {name} in their text is a parameter

    Raises TendrilError, in one line, for data or a scene that cannot be read or run."""
    begin, measured = time.perf_counter(), gather(data, unit)
    tell = (lambda text: print(f"fit: {text}", flush=True)) if progress else (lambda text: None)
    looked_for = [Parameter.of(name, bounds) for name, bounds in parameters.items()]
    if not looked_for:
        raise TendrilError('fit: give what to look for, {"si_friction_dry": ("0.1N/m", "2N/m")}')
    problem = Problem(scene, measured, looked_for, options, jobs)
    best, costs = search(problem, starts, SEARCH * accuracy, seed, tell)
    p = len(looked_for)
    problem.prepare(best.u[:p], accuracy)
    (r,) = problem.run([best.u[:p]])
    best.u = np.r_[best.u[:p], problem.comparison.guess(r, best.u[p:])]  # times, now that it looks so
    for tolerance in (1e-3, 1e-4):  # the noise as the residuals tell it, then once more
        problem.measure_noise(best.u)
        best = problem.solve(best.u, tolerance)
    tell(f"{problem.count} runs, polished")
    best, covariance, freedom = certain(problem, best, tell)
    (r,) = problem.run([best.u[:p]])
    found = Fit(problem, best.u, covariance, r, freedom, best.cost, costs, time.perf_counter() - begin)
    found.indistinct = indistinct(found)
    return found

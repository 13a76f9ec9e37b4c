"""A scene, what is looked for in it, and what was measured: runs, residuals and derivatives at any point,
and the least cost from a start."""

from __future__ import annotations

from contextlib import contextmanager
from dataclasses import dataclass
from typing import Sequence

import numpy as np
from scipy import optimize, stats

from .comparing import Comparison
from .errors import RunError, TendrilError
from .measured import Measured
from .parameters import MODE, PER, Parameter, with_unit
from .results import Results
from .runs import run
from .sweeps import cores, stored
from .units import scales_of_rod

HUBER = 1.345  # 95 % efficiency for normal noise
STEP, FINE_STEP = 3e-3, 1e-2  # of differences, in parts of a parameter's bounds: forward, central
SHAPES = 120  # stored in a run, between which shapes are interpolated
FAILED = 1e3  # a residual, in noise, of a run that failed


@dataclass
class Solution:
    """A point of the search: of all that is looked for, the run that belongs to it, the cost."""

    u: np.ndarray  # parameters from 0 to 1, then the comparison's own numbers
    cost: float


class Problem:
    """A scene, what is looked for in it, and what was measured: runs and residuals at any point."""

    def __init__(self, scene, measured: Measured, parameters: Sequence[Parameter], options, jobs=None):
        self.scene, self.measured, self.parameters = scene, measured, list(parameters)
        self.options, self.jobs = dict(options), jobs or cores()
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

    def rod(self, u):
        """What the file of a run at a point would say of its rod in the laboratory."""
        about = dict(self.glimpse.attributes)
        for p, x, x0 in zip(self.parameters, u, self.begin):
            if p.name.startswith("si_"):
                about[f"parameters/{p.name}"] *= p.value(x) / p.value(x0)
        return about | {f"si_{kind}": scale for kind, scale in scales_of_rod(about).items()}

    def unit_length(self, u):
        """1 of tendril's unit of length in m at a point, 1 without laboratory units."""
        return self.rod(u).get("si_length", 1.0)

    def curvature(self, modes, u):
        """The arrays of -rod_curvature_file for some modes, {number: (amplitude, unit)}."""
        s, unit = np.linspace(0, 1, 201), self.unit_length(u)
        reach = self.reach * self.unit_length(self.begin) / unit
        slides = self.glimpse.attributes["parameters/growth_type"] in ("feed", "apical")
        bend = sum(a * (unit / PER[per] if per else 1) * np.cos((k - 1) * np.pi * s)
                   for k, (a, per) in modes.items())
        return {"distance" if slides else "s": s * (reach if slides else 1), "curvature": bend}

    def run(self, points) -> list[Results | RunError]:
        """Runs at these points, side by side; those that were made before are not made again. Of their
        attributes they have those of the rod in the laboratory."""
        keys = [tuple(np.round(np.asarray(u, float), 12)) for u in points]
        new = [key for key in dict.fromkeys(keys) if key not in self.known]
        for key, r in zip(new, stored([self.words(key) | self.settings for key in new], self.scene,
                                      self.jobs)):
            if isinstance(r, Results):
                r.attributes = self.rod(key)
            self.known[key] = r
        self.count += len(new)
        return [self.known[key] for key in keys]

    @contextmanager
    def shared(self, searches):
        """While several searches go on side by side each has its share of the cores."""
        whole = self.jobs
        self.jobs = max(1, whole // searches)
        try:
            yield
        finally:
            self.jobs = whole

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
        """A run that must not fail, with all that its file tells."""
        self.count += 1
        return run(self.scene, progress=False, **self.words(u) | settings)

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

    def bounds(self, u):
        p = len(self.parameters)
        return (np.r_[np.zeros(p), np.full(len(u) - p, -np.inf)],
                np.r_[np.ones(p), np.full(len(u) - p, np.inf)])

    def solve(self, u, tolerance, ahead=True, most=15) -> Solution:
        """The least cost from a start. ahead: runs for derivatives are made together with the one at the
        point itself, as there are cores for them; but after a step that was none, when the next, which
        is shorter, may be none either."""
        p, least, better = len(self.parameters), np.inf, ahead

        def residuals(u):
            nonlocal least, better
            if better:
                self.run([u[:p], *self.neighbours(u, STEP)[0][:, :p]])
            f = self.residuals(u)
            cost = self.cost(f)
            least, better = min(cost, least), ahead and cost < least
            return f

        inside = np.clip(u, *[b + s for b, s in zip(self.bounds(u), (1e-6, -1e-6))])
        found = optimize.least_squares(residuals, inside, self.jacobian, self.bounds(u), loss="huber",
                                       f_scale=HUBER, x_scale="jac", xtol=tolerance,
                                       ftol=tolerance, gtol=None, max_nfev=most)
        return Solution(found.x, found.cost)

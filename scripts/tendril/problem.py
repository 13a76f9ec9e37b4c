"""A scene, what is looked for in it, and what was measured: runs, residuals and derivatives at any point,
and the least cost from a start."""

from __future__ import annotations

from contextlib import contextmanager
from dataclasses import dataclass
from threading import Lock
from typing import Sequence

import numpy as np
from scipy import stats

from .comparing import ANGLES, BARE, BARE_NOISE, ENDS, LINES, VIEW, Comparison
from .errors import RunError, TendrilError
from .measured import Measured, values_of
from .noise import Errors, estimate
from .parameters import MODE, Parameter, Prior, tied_value
from .progress import Stages, bar
from .results import Results
from .runs import check_names, run
from .secants import Flat, least
from .sweeps import cores, stored
from .tangents import STEP as ALONG, beside
from .units import PER, in_si, parameters_of, quantity, scales_of_rod, with_unit

HUBER = 1.345  # 95 % efficiency for normal noise
STEP, FINE_STEP = 3e-3, 1e-2  # of differences, in parts of a parameter's bounds: forward, central
NEAR = 0.3  # of these steps: differences around a point so near are as good as around this one
SHAPES = 120  # stored in a run, between which shapes are interpolated
FINEST = 1e-5  # the accuracy that runs are made with at best
WEAK = 10.0  # by so many times a prior is made wider during the search
EARLY = 0.05  # what was measured may be shorter than the rod at its start by this part, as points err
FAILED = 1e3  # a residual, in noise, of a run that failed


def untold(error: RunError):
    """Whether a run is refused only because it was asked for derivatives."""
    return error.results is None and "sensitivity" in str(error)


@dataclass
class Solution:
    """A point of the search: of all that is looked for, the run that belongs to it, the cost."""

    u: np.ndarray  # parameters from 0 to 1, then the comparison's own numbers
    cost: float
    flat: bool = False  # nothing that is looked for changes the cost there


class Problem:
    """A scene, what is looked for in it, and what was measured: runs and residuals at any point."""

    def __init__(self, scene, measured: Measured, parameters: Sequence[Parameter], options, jobs=None, *,
                 priors: Sequence[Prior] = (), tied=None, noise=None):
        self.scene, self.measured, self.parameters = scene, measured, list(parameters)
        self.options, self.jobs = dict(options), jobs or cores()
        self.priors, self.tied, self.told_noise = list(priors), dict(tied or {}), dict(noise or {})
        # parameters that are of the picture and its clock: no run depends on them
        self.of_view = [k for k, p in enumerate(self.parameters) if p.name in VIEW]
        self.of_runs = [k for k, p in enumerate(self.parameters) if p.name not in VIEW]
        self.comparison = Comparison(measured)
        if self.comparison.camera and (mine := [self.parameters[k].name for k in self.of_view
                                                if self.parameters[k].name.startswith("camera")]):
            raise TendrilError(f"{mine[0]}: of points in px the camera is found anyway; leave it out")
        # parameters that are words in braces in the text of another option
        self.inserted = {p.name for p in self.parameters for text in self.options.values()
                         if isinstance(text, str) and "{" + p.name + "}" in text}
        check_names([*(self.parameters[k].name for k in self.of_runs if not MODE.match(self.parameters[k].name)
                       and self.parameters[k].name not in self.inserted), *(name.lstrip("-") for name in self.tied)])
        self.settings: dict = {}  # end, stored shapes, cells and tolerance of all runs
        self.glimpse = self.begin = None  # a run at the first point, for what it says of the scene
        self.reach = 1.0  # length at the end, in units of that run
        self.noise: dict[str, float] = {}
        self.errors: Errors | None = None  # the model of them, once the search is over
        self.count = 0  # of runs
        # of the search, for causes that are tried afterwards
        self.search_settings, self.search_known, self.search_points = {}, {}, {}
        # of the searches that are under way, for one that is interrupted
        self.best: np.ndarray | None = None
        self.least, self.ended, self.lock = np.inf, False, Lock()
        self.bar: Stages | None = None
        self.seen = None  # who looks on (fit_seen.FitSeen)
        self.known: dict = {}  # runs by their point
        self.points: dict = {}  # the points themselves
        # options by whose numbers runs tell their derivatives; none: derivatives are differences between runs
        self.followed: list[str] = []
        self.middle: np.ndarray | None = None  # around which the last central differences were made
        self.derived: dict = {}  # runs that tell them, by their point; None: this one does not

    def like(self, settings, known=(), measured=None, more=()) -> Problem:
        """This problem with other settings of its runs, of which it knows some; perhaps with other data, and with more to
        look for, behind its parameters."""
        new = Problem(self.scene, measured or self.measured, [*self.parameters, *more], self.options, self.jobs,
                      priors=self.priors, tied=self.tied)
        new.bar, new.glimpse, new.begin, new.reach = self.bar, self.glimpse, self.begin, self.reach
        new.settings, new.known = dict(settings), dict(known)
        # numbers of picture and clock are no run's; what else runs tell is seen when one is made (run_derived)
        new.followed = new.own_numbers() if self.followed else []
        new.comparison.hidden = self.comparison.hidden
        return new

    def words(self, u):
        """The options of a run, apart from its settings; u: parameters, from 0 to 1."""
        values = {self.parameters[k].name: self.parameters[k].text(self.parameters[k].value(u[k]))
                  for k in self.of_runs}
        values |= {name: tied_value(name, text, values) for name, text in self.tied.items()}
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

    def show(self, progress, expected):
        """A bar of the runs, of which about so many are expected; a function that tells what goes on: in a
        line of its own where progress is asked for, else behind the bar."""
        shown = bar(None if progress else progress, expected, what="fit", unit="run")
        self.bar = Stages(shown)
        tell = (lambda text: shown.write(f"fit: {text}")) if progress else self.bar.tell
        return self.seen.telling(tell) if self.seen else tell

    def counted(self, runs):
        """Counts runs that are made."""
        self.count += runs
        if self.bar is not None:
            self.bar.count(runs)

    def expect(self, more):
        """Tells the bar how many more runs are to be expected."""
        if self.bar is not None:
            self.bar.expect(more)

    def hide(self, done=True):
        """Takes the bar away, full if all is done."""
        if self.bar is not None:
            self.bar.close(done)
            self.bar = None

    def words_tied(self, u):
        """The values of what is tied to parameters."""
        values = {p.name: p.text(p.value(x)) for p, x in zip(self.parameters, u)}
        return {name: tied_value(name, text, values) for name, text in self.tied.items()}

    def view(self, u):
        """How picture and clock stand to the rod, at a point: as comparing.VIEW, in the data's units."""
        found = dict(VIEW)
        for k in self.of_view:
            p = self.parameters[k]
            found[p.name] = float(values_of(p.value(u[k]), p.unit, p.name).numbers)
        return found

    def rod(self, u):
        """What the file of a run at a point would say of its rod in the laboratory."""
        told = {p.name: p.text(p.value(x)) for p, x in zip(self.parameters, u)} | self.words_tied(u)
        about = self.glimpse.attributes | parameters_of({k: v for k, v in told.items() if k.startswith("si_")})
        about |= {f"si_{kind}": scale for kind, scale in scales_of_rod(about).items()}
        zone = told.get("growth_zone", str(self.options.get("growth_zone", self.glimpse.options.get("growth_zone", ""))))
        if found := quantity(zone.format_map(told) if "{" in zone else zone):
            about |= {"parameters/growth_zone": found[0] * in_si(found[1]) / about["si_length"] if found[1] else found[0]}
        return about

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

    def key(self, u):
        """What tells one run from another."""
        return tuple(np.round(np.asarray(u, float)[self.of_runs], 12))

    def own_numbers(self):
        """Numbers of runs that are options of their own; none if anything else hangs on them."""
        names = [self.parameters[k].name for k in self.of_runs]
        return [] if self.tied or any(MODE.match(name) for name in names) else [n for n in names if n not in self.inserted]

    def follow(self, u) -> Results:
        """The first moment of the run at u. With it is set which numbers runs are asked to tell their derivatives by: those
        that are options of their own, if the program does not refuse it."""
        self.followed, moment = self.own_numbers(), {"ts_max_time": 1e-6}
        if self.followed:
            try:
                return self.first(u, moment | self.derivatives())
            except RunError as error:
                if not untold(error):
                    raise
                self.followed = []
        return self.first(u, moment)

    def derivatives(self):
        """The option by which a run tells them."""
        return {"sensitivity": ",".join(self.followed)}

    @property
    def all_followed(self) -> bool:
        """Whether a run tells all derivatives that are asked for."""
        return bool(self.followed) and len(self.followed) == len(self.of_runs)

    def run_derived(self, u) -> Results | None:
        """The run at u with its derivatives; None: it fails, or does not tell them (behind a snap)."""
        key = self.key(u)
        if self.ended:
            raise KeyboardInterrupt
        if key not in self.derived:
            self.derived[key] = None
            try:
                r = self.first(u, self.settings | self.derivatives())
            except RunError as error:
                if untold(error):
                    self.followed = []
                else:
                    self.known[key] = error
                return None
            r.attributes = self.rod(u)
            self.known[key], self.points[key] = r, np.asarray(u, float)[:len(self.parameters)]
            if all(np.isfinite(r.sensitivity(name).shapes.x).all() for name in self.followed):
                self.derived[key] = r
        return self.derived[key]

    def derivative(self, u, r, k, of):
        """Of a function of point and run by number k at u, where r is the run with its derivatives."""
        two = []
        for sign in (1, -1):
            there = np.array(u, float)
            there[k] += sign * ALONG
            change = {self.parameters[i].name: float(self.parameters[i].value(there[i]) - self.parameters[i].value(u[i]))
                      for i in self.of_runs if i == k}
            two.append(of(there, beside(r, change, self.rod(there))))
        return (two[0] - two[1]) / (2 * ALONG)

    def run(self, points) -> list[Results | RunError]:
        """Runs at these points, side by side; those that were made before are not made again. Of their
        attributes they have those of the rod in the laboratory."""
        if self.ended:  # somebody pressed Ctrl-C, and another thread was told
            raise KeyboardInterrupt
        keys = [self.key(u) for u in points]
        new = {key: u for key, u in zip(keys[::-1], list(points)[::-1]) if key not in self.known}
        for (key, u), r in zip(new.items(), stored([self.words(u) | self.settings for u in new.values()],
                                                   self.scene, self.jobs) if new else ()):
            if isinstance(r, Results):
                r.attributes = self.rod(u)
            self.known[key] = r
            self.points[key] = np.asarray(u, float)[:len(self.parameters)]
        if new:
            self.counted(len(new))
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
                end[option] = f"{self.latest(abscissa, last) * (1 + 1e-9)!r}{unit}"
        return end

    def latest(self, abscissa, at):
        """The last of what was measured, as the rod's own clock may have it at most."""
        last = float(np.max(at.numbers))
        if abscissa == "length":
            return last
        corners = [self.view([x] * len(self.parameters)) for x in (0.0, 1.0)]
        return (last - min(v["clock_offset"] for v in corners)) / min(v["clock_rate"] for v in corners)

    def prepare(self, u, accuracy):
        """Chooses how all runs are made, from one at u: their end, which shapes they store, and cells
        and tolerance for an accuracy; so that runs differ by their parameters alone. One that is
        interrupted leaves all as it was."""
        before = self.known, self.settings, self.glimpse, self.begin, self.reach
        self.derived, self.middle = {}, None
        try:
            self.choose(u, accuracy)
        except BaseException:
            self.known, self.settings, self.glimpse, self.begin, self.reach = before
            raise

    def choose(self, u, accuracy):
        self.known, self.settings, end = {}, {}, self.ends()
        if self.glimpse is None or "ts_max_time" not in end:  # a length says when to end, and it counts from the first
            self.glimpse = self.follow(u)
        self.begin = u
        self.check_angles()
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

    def check_angles(self):
        """A table of angles has its times in a unit where the scene knows one."""
        if "si_time" in self.glimpse.attributes:
            for c in self.measured.curves:
                if c.name in ANGLES and not c.at.si:
                    raise TendrilError(f"{c.source}: t has no unit, and this scene has seconds; write t (h), or t (min), t (s), t (d)")

    def keep_search(self):
        """Keeps the runs of the search, for what is asked of them after it."""
        self.search_settings, self.search_known = dict(self.settings), dict(self.known)
        self.search_points = {key: self.points[key] for key in self.known}

    def check_end(self, r: Results):
        """A run must go on for as long as something was measured, and begin before it."""
        if "growth_initial_length" not in [p.name for p in self.parameters]:
            for at in self.measured.abscissae("length"):
                first, begin = np.min(at.numbers), r.series.length[0] * (r.scale("length") if at.si else 1)
                if first < (1 - EARLY) * begin:
                    raise TendrilError(f"something was measured at length {first:.4g}, and the scene begins at {begin:.4g}"
                                       f"{' m' if at.si else ''}; give a smaller -growth_initial_length, or take it out")
        for abscissa in ("t", "length"):
            for at in self.measured.abscissae(abscissa):
                si = r.scale({"t": "time", "length": "length"}[abscissa]) if at.si else 1
                last, end = self.latest(abscissa, at), r.series[abscissa][-1] * si
                if end < last * (1 - 1e-6):
                    raise TendrilError(f"the scene ends at {abscissa} = {end:.6g}, before the last of what was "
                                       f"measured, at {last:.6g}; take out what ends it (-stop_...)")

    def first(self, u, settings):
        """A run that must not fail, with all that its file tells."""
        self.counted(1)
        return run(self.scene, progress=False, **self.words(u) | settings)

    def raw(self, u, r):
        """What was measured less what a run gives, in the units of the measurement, at a point of all
        that is looked for; then how far parameters are from what was known of them, in its deviations."""
        p = len(self.parameters)
        own = [(prior.parameter(u[:p], self.parameters) - prior.mean) / prior.deviation for prior in self.priors]
        return np.append(self.comparison.residuals(r, u[p:], self.view(u)), own)

    def residuals(self, u, r=None):
        """Residuals over their noise; once there is a model of the errors, free of correlation."""
        if r is None:
            (r,) = self.run([u])
        if isinstance(r, RunError) or not self.comparison.sees(r, u[len(self.parameters):]):
            return np.full(len(self.sigma), FAILED)
        raw = self.raw(u, r)
        found = self.errors.whitened(raw, search=True) if self.errors else raw / self.sigma
        if self.seen:
            self.seen.tried(u, r, self.cost(found))
        return found

    def measure_noise(self, u, share=None):
        """Sets the noise of each group as if all residuals erred by themselves: a share of what was
        measured, or what the residuals at u tell, by their median so that outliers do not count."""
        (r,) = self.run([u])
        if isinstance(r, RunError):
            raise r
        self.errors, self.least = None, np.inf  # costs are counted anew
        if self.seen:
            self.seen.fresh()
        values = self.raw(u, r)
        groups, spreads = np.array(self.comparison.groups), self.comparison.spreads()
        freedom = np.sqrt(max(1e-3, 1 - len(u) / len(values)))
        for name in spreads:
            told = np.median(np.abs(values[:len(groups)][groups == name])) / stats.norm.ppf(0.75)
            least = 1e-6 * spreads[name]  # data without noise
            self.noise[name] = share * spreads[name] if share else self.told_noise.get(
                name, max(told / freedom, least))
        beside = {ENDS: self.noise.get(LINES), BARE: BARE_NOISE * spreads.get(LINES, 0)}
        sizes = self.noise | beside
        # while the noise is a guess what was known beforehand must not outweigh the points
        self.sigma = np.array([sizes[name] for name in groups] + [WEAK] * len(self.priors))
        ends = np.flatnonzero(groups == ENDS)
        self.sigma[ends] = np.maximum(self.sigma[ends], self.comparison.loose)

    def leave_hidden(self, u):
        """Leaves the tips out that are hidden in the photographs, as it looks at u. True if there are any."""
        (r,) = self.run([u])
        return not isinstance(r, RunError) and self.comparison.find_hidden(r, u[len(self.parameters):], self.view(u))

    def raw_jacobian(self, u, central=False, of=None):
        """[residual, number], of raw residuals, or of another function of point and run: by each number from what the run
        tells, or by forward or central differences between runs. Where central ones were made around a point that is near, these serve again."""
        of = of or self.raw
        r = self.run_derived(u) if self.followed else None
        told = [k for k in range(len(u)) if r and (k not in self.of_runs or self.parameters[k].name in self.followed)]
        found = {k: self.derivative(u, r, k, of) for k in told}
        if rest := [k for k in range(len(u)) if k not in found]:
            central, u = self.around(u, central)
            points, _ = self.neighbours(u, FINE_STEP if central else STEP)
            behind = 2 * u - points if central else np.tile(u, (len(u), 1))
            inside = slice(0, len(self.parameters))
            behind[:, inside] = np.clip(behind[:, inside], 0, 1)
            runs = self.run([*points[rest], *behind[rest]])
            if failed := next((r for r in runs if isinstance(r, RunError)), None):
                raise failed
            for k, ahead, back in zip(rest, runs, runs[len(rest):]):
                found[k] = (of(points[k], ahead) - of(behind[k], back)) / (points[k] - behind[k])[k]
        return np.column_stack([found[k] for k in range(len(u))])

    def around(self, u, central):
        """(whether differences are central ones, the point around which they are made): u, or with the runs of one that is
        near."""
        moved = np.array(u, float)
        if self.middle is not None:
            moved[self.of_runs] = self.middle[self.of_runs]
            if np.abs(moved - u).max() <= NEAR * FINE_STEP:
                return True, moved
        if central:
            self.middle = np.array(u, float)
        return central, np.array(u, float)

    def prior_information(self, count):
        """One as wide as the bounds, so that what the data do not fix has an end, too."""
        return np.diag(np.r_[np.ones(len(self.parameters)), np.zeros(count - len(self.parameters))]) * 1e-6

    def measure_errors(self, u, jacobian):
        """Estimates the model of the errors from the residuals at u; from then on residuals are those
        of generalised least squares."""
        (r,) = self.run([u])
        raw = self.raw(u, r)
        alone = np.r_[self.sigma[:len(raw) - len(self.priors)], np.ones(len(self.priors))]
        self.least = np.inf
        if self.seen:
            self.seen.fresh()
        self.errors = estimate(self.comparison.blocks, raw, jacobian, alone,
                               self.prior_information(len(u)), self.told_noise)
        self.noise = {name: g.total for name, g in self.errors.groups.items()}
        return raw

    def wanted_accuracy(self):
        """That of runs whose own error is no part of the residuals: a tenth of the noise, over the extent."""
        spreads = self.comparison.spreads()
        return max(FINEST, min(0.1 * noise / spreads[name] for name, noise in self.noise.items()))

    def cost(self, f):
        """Half the sum that least_squares makes least."""
        if self.errors:
            return 0.5 * float(f @ f)
        z = (f / HUBER) ** 2
        return 0.5 * HUBER**2 * float(np.sum(np.where(z <= 1, z, 2 * np.sqrt(z) - 1)))

    def neighbours(self, u, size):
        """(points a step away from u, one a number; the steps, which keep within the bounds)"""
        p = len(self.parameters)
        steps = np.where((np.asarray(u) + size > 1) & (np.arange(len(u)) < p), -size, size)
        return u + np.diag(steps), steps

    def jacobian(self, u):
        """[residual, number], over the noise; differences are central once the errors are known, for in a valley
        the end of a search is off by what derivatives are."""
        try:
            raw = self.raw_jacobian(u, central=self.errors is not None)
        except RunError:  # what fails beside the point is as far as a residual can be
            points, steps = self.neighbours(u, STEP)
            here = self.residuals(u)
            return np.column_stack([(self.residuals(a) - here) / h for a, h in zip(points, steps)])
        return self.errors.whitened(raw, search=True) if self.errors else raw / self.sigma[:, None]

    def bounds(self, u):
        """Parameters, and times of photographs that have none, are parts of what they can be; a camera's numbers are not."""
        p = len(self.parameters)
        times = min(len(u) - p, len(self.comparison.timeless))
        free = np.full(len(u) - p - times, np.inf)
        return np.r_[np.zeros(p), -free, np.zeros(times)], np.r_[np.ones(p), free, np.ones(times)]

    def solve(self, u, tolerance, most=15) -> Solution:
        """The least cost from a start, in so many points at most. Where derivatives are differences between runs they
        are made anew only if steps show that they have changed (Secant)."""
        def residuals(u):
            if self.all_followed:
                self.run_derived(u)
            f = self.residuals(u)
            cost = self.cost(f)
            with self.lock:
                if cost < self.least:
                    self.best, self.least = np.array(u), cost
            return f

        inside = np.clip(u, *[b + s for b, s in zip(self.bounds(u), (1e-6, -1e-6))])
        try:
            return Solution(*least(residuals, self.jacobian, self.cost, inside, wanted=not self.all_followed, most=most,
                                   bounds=self.bounds(u), loss="linear" if self.errors else "huber", f_scale=HUBER,
                                   xtol=tolerance, ftol=tolerance))
        except Flat as flat:
            (end,) = flat.args
            return Solution(end, self.cost(self.residuals(end)), True)

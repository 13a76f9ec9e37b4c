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

The search is made by scipy's least_squares, with Huber's loss against strays, from several starts, and
from more of them until the two best end in one place. What is left over then tells how the points err:
by themselves, smoothly along the rod, a photograph as a whole (tendril.noise); with that the end is found
by generalised least squares. Intervals are those of the linearised problem, over all that the errors may
be like, and widened where a run along a principal axis of the covariance shows that the sum of squares
rises more slowly than it should. What speaks against the fit is in .warnings (tendril.doubts)."""
from __future__ import annotations

import re
import time
from concurrent.futures import ThreadPoolExecutor
from typing import Mapping

import numpy as np
from scipy import stats

from .doubts import warnings_of
from .errors import RunError, TendrilError, arguments, number, whole
from .fit_report import bands, describe, draw, indistinct, save, scene_text, table
from .fit_seen import FitSeen
from .found import Found
from .measured import gather
from .noise import Certainty, certainty
from .parameters import Parameter, Prior
from .problem import Problem, Solution
from .profiles import followed_out
from .starting import exchanged, starting_points
from .units import PIXEL

SEARCH, COARSEST = 30, 0.1  # the search for a start is made with so many times the error of the final runs, and no more
FOLLOWED = 6  # evaluations for which two searches go on side by side, before one
BEGINNINGS = 8  # points that are tried where the first run gives up
DOUBLINGS = 3  # of the starts, at most, as long as no two searches end in one place
TOGETHER = 0.03  # in parts of the bounds: two ends are one
BETWEEN = (0.25, 0.5, 0.75)  # places on the way from one end to another
CLOSE, ROUGH = 3e-3, 1e-2  # tolerances of these two, and of the one, which is polished after
BETTER = 0.05  # less of the cost is no reason to go on: 1.92 is that of an interval's end
CONFIDENCE = 0.95


class Fit(Found):
    """What was found, and what tells and draws it."""

    def __repr__(self):
        return self.report()

    def residuals(self):
        """What was measured beside what the best scene gives, as a pandas DataFrame."""
        return table(self)

    def report(self) -> str:
        return describe(self)

    def dataset(self):
        """Estimates, intervals and correlations over the parameters, residuals over the points, as an xarray
        Dataset."""
        import xarray

        names, rows = [p.name for p in self.parameters], self.residuals()
        found = {"estimate": ("parameter", [self.values[n] for n in names]),
                 "interval": (("parameter", "end"), [list(self.intervals[n]) for n in names]),
                 "unit": ("parameter", [p.unit for p in self.parameters]),
                 "correlation": (("parameter", "other"), self.correlations),
                 "residual": ("point", rows.residual.to_numpy(float)), "group": ("point", list(rows.group)),
                 "at": ("point", rows["at"].to_numpy(float))}
        return xarray.Dataset(found, {"parameter": names, "other": names, "end": ["low", "high"]},
                              {"log_likelihood": self.log_likelihood, "runs": self.problem.count, "trusted": int(self.trusted),
                               "warnings": "\n".join(self.warnings)})

    def band(self, photograph: int):
        """(the rod of the best scene as a photograph should show it [n, 2], how far it may lie to both sides [n]: at each
        place on it the rod is there in 95 of 100 such fits), in the unit of its points; photographs count from 0."""
        return bands(self, [self.problem.measured.photographs[photograph]])[0]

    def plot(self):
        """A figure of what was measured beside the best scene."""
        return draw(self)

    def scene(self) -> str:
        """The best scene as an options file."""
        return scene_text(self)

    def save(self, basename):
        """Writes BASENAME.opts, the best scene; .txt, the report; .csv, residuals; .png and .pdf."""
        save(self, basename)


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
    problem.run(trials)
    inverse = np.linalg.pinv(covariance, hermitian=True)
    costs = [problem.cost(problem.residuals(trial)) for trial in trials]
    longer = np.ones(p)
    for k, (trial, reached) in enumerate(zip(trials, costs)):
        expected = 0.5 * (trial - u) @ inverse @ (trial - u)
        if expected > 1e-3:
            # a fall says that the search was not at its end, and nothing of how flat it is there
            risen = max(reached - cost, 1e-4 * expected) if reached >= cost else 0.25 * expected
            longer[k // 2] = max(longer[k // 2], np.sqrt(expected / risen))
    whole = np.eye(len(u))
    whole[:p, :p] = axes @ np.diag(longer) @ axes.T
    least = int(np.argmin(costs))
    return whole @ covariance @ whole.T, trials[least], costs[least]


def one_place(problem: Problem, a: Solution, b: Solution):
    """Whether two searches have ended in one: near to each other at about the same cost, or with a way between them
    that goes down all along from the worse end: that one had not come to its end."""
    p, (low, high) = len(problem.parameters), sorted((a, b), key=lambda s: s.cost)
    if high.cost - low.cost <= 0.1 * low.cost + 0.5 and np.abs(a.u[:p] - b.u[:p]).max() < TOGETHER:
        return True
    points = [high.u + part * (low.u - high.u) for part in BETWEEN]
    problem.run(points)
    costs = [high.cost, *(problem.cost(problem.residuals(u)) for u in points), low.cost]
    return all(after <= 1.05 * before for before, after in zip(costs, costs[1:]))


def followed(problem: Problem, starts):
    """The ends of searches side by side."""
    with ThreadPoolExecutor() as pool, problem.shared(max(len(starts), 1)):
        try:
            return list(pool.map(lambda u: problem.solve(u, CLOSE, most=FOLLOWED), starts))
        except KeyboardInterrupt:
            problem.ended = True  # the searches in other threads are not told by themselves
            raise


def runs_of_stages(problem: Problem):
    """About how many runs searches take beside their starts, the end of the search, and what is made to be sure of it."""
    each = 1 + len(problem.of_runs) - len(problem.followed)  # of a point: those for derivatives that runs do not tell
    return 10 * each + 4, 10 * each, 2 * len(problem.parameters) + each


def ranked(problem: Problem, points):
    """The points whose runs do not fail, with the comparison's own numbers, the best first."""
    runs = problem.run(points)
    good = [np.r_[u, problem.comparison.guess(r)] for u, r in zip(points, runs) if not isinstance(r, RunError)]
    if not good:
        raise runs[0]
    if not problem.noise:
        problem.measure_noise(good[0], share=0.03)
    order = sorted(good, key=lambda u: problem.cost(problem.residuals(u)))
    if problem.best is None:
        problem.best = order[0]
    return order


def begun(problem: Problem, first, accuracy, seed):
    """Prepares runs from one at a first point; where that gives up on its way, as a straight rod that jams at a wall, from
    another within the bounds."""
    failed = None
    for u in (first, *stats.qmc.LatinHypercube(len(first), seed=seed).random(BEGINNINGS)):
        try:
            return problem.prepare(u, accuracy)
        except RunError as error:
            if error.results is None:  # refused: so are the others
                raise
            failed = failed or error
    raise failed


def search(problem: Problem, starts, accuracy, seed, tell):
    """(the best of the searches from several starts, the costs of all, whether two ended there). The two
    starts that look best are followed, and one that was asked for; if the two best ends are not one place,
    further, and then from twice as many starts."""
    middle = np.array([0.5 if p.start is None else p.inside(p.start) for p in problem.parameters])
    begun(problem, middle, accuracy, seed)
    problem.noise = {}
    points = starting_points(problem, starts, seed)
    asked = any(problem.parameters[k].start is not None for k in problem.of_runs)
    ends, agreed = [], False
    for doubling in range(DOUBLINGS + 1):
        tell(f"{len(points)} starts")
        problem.expect(len(points) + sum(runs_of_stages(problem)))
        order = ranked(problem, points)
        chosen = order[:2]
        if asked and not doubling:
            chosen += [u for u in order[2:] if np.array_equal(u[:len(middle)], points[0])]
        new = followed(problem, chosen)
        ends = sorted(ends + new, key=lambda s: s.cost)
        agreed = len(ends) > 1 and one_place(problem, *ends[:2])
        if not agreed:
            ends = sorted(followed(problem, [s.u for s in ends[:2]]) + ends[2:], key=lambda s: s.cost)
            agreed = len(ends) > 1 and one_place(problem, *ends[:2])
        if agreed or starts == 0:
            break
        points = starting_points(problem, max(starts, 1) * 2 ** (doubling + 1), seed + doubling + 1)[1:]
    if (other := exchanged(problem, ends[0].u)) is not None:
        problem.run([other])
        ends = sorted(ends + followed(problem, [other]), key=lambda s: s.cost)
    if all(s.flat for s in ends):
        raise TendrilError(f"fit: {', '.join(p.name for p in problem.parameters)}: changes nothing of what was measured; a rod "
                           "that is straight by nature stays straight: look for rod_curvature, too, or give it")
    problem.expect(sum(runs_of_stages(problem)[1:]))
    tell("costs of the searches: " + ", ".join(f"{s.cost:.4g}" for s in ends) + "; the best goes on")
    return problem.solve(ends[0].u, ROUGH), [s.cost for s in ends], agreed


def less_likely(errors, raw, errors_before, raw_before):
    """Of what tells something both times."""
    both = errors.telling & errors_before.telling
    return errors.log_likelihood(raw, both) < errors_before.log_likelihood(raw_before, both)


def certain(problem: Problem, best: Solution, tell):
    """(the least cost, what is known of it); where the linearised problem tells next to nothing, by the cost itself."""
    best, known, rises = settled(problem, best, tell)
    other = exchanged_end(problem, best)
    if other and other.cost < best.cost - BETTER:
        tell("memory and proprioception exchanged fit better")
        best, known, rises = settled(problem, other, tell)
        other = exchanged_end(problem, best)
    ends = followed_out(problem, best, known, rises, tell)
    half = known.reach * np.sqrt(np.diag(known.covariance))
    if other and other.cost < best.cost + max(rises):
        for k in range(len(problem.parameters)):
            low, high = ends.get(k, (best.u[k] - half[k], best.u[k] + half[k]))
            ends[k] = min(low, max(other.u[k] - half[k], 0.0)), max(high, min(other.u[k] + half[k], 1.0))
    if not ends:
        return best, known
    part = np.ones(len(half))
    for k, (low, high) in ends.items():
        if 0 < low and high < 1:  # else nothing shows how far it would go on
            part[k] = min(1.0, 0.5 * (high - low) / half[k])
    return best, Certainty(known.covariance * np.outer(part, part), known.reach, ends)


def exchanged_end(problem: Problem, best: Solution):
    """Of roots that remember, the least cost on the other side, where memory and straightening have changed places; None where
    that is the same side."""
    there = exchanged(problem, best.u)
    if there is None:
        return None
    end = problem.solve(there, 1e-3)
    return None if np.abs(end.u - best.u)[:len(problem.parameters)].max() < TOGETHER else end


def settled(problem: Problem, best: Solution, tell, most=3):
    """(the least cost, what is known of it, by how much the cost rises to the ends of intervals): as long as a run on a principal axis is better than the best,
    the search goes on from there; and back, if all in all, with the errors that are then estimated, that is less likely:
    errors that reach far let a search slide along a valley."""
    before = None
    for last in range(most):
        jacobian = problem.raw_jacobian(best.u, central=True)
        raw = problem.measure_errors(best.u, jacobian)
        if before and less_likely(problem.errors, raw, *before[2:4]):
            tell("that is less likely all in all; back")
            best, known, problem.errors, _, problem.noise, rises = before
            return best, known, rises
        best = Solution(best.u, problem.cost(problem.errors.whitened(raw, search=True)))
        known = certainty(problem.errors, raw, jacobian, problem.prior_information(len(best.u)),
                          problem.told_noise, CONFIDENCE)
        plain = np.linalg.pinv(problem.prior_information(len(best.u)) + (lambda w: w.T @ w)(
            problem.errors.whitened(jacobian, search=True)), hermitian=True)
        rises = 0.5 * known.reach**2 * np.diag(known.covariance) / np.maximum(np.diag(plain), 1e-300)
        wide, other, cost = widened(problem, best.u, plain, best.cost)
        # what the errors leave open, and what is curved, both widen
        larger = np.sqrt(np.maximum(np.diag(wide) / np.maximum(np.diag(plain), 1e-300), 1))
        known = Certainty(known.covariance * np.outer(larger, larger), known.reach)
        if cost > best.cost - BETTER or last == most - 1:
            break
        before = best, known, problem.errors, raw, problem.noise, rises
        problem.expect(2 * runs_of_stages(problem)[2])
        best = problem.solve(other, 1e-4)
        tell(f"a better one beside it, {problem.count} runs")
    return best, known, rises


def polished(problem: Problem, best: Solution, accuracy, tell, finer=True):
    """The end of the search with the runs' final accuracy, better than this one where the data are (finer), and the
    errors as they are: of each point first, then with their correlation."""
    p = len(problem.parameters)
    if not problem.search_known:
        problem.keep_search()
    problem.prepare(best.u[:p], accuracy)
    if problem.followed:  # the search begins here, and asks for them
        problem.run_derived(best.u)
    (r,) = problem.run([best.u])
    best.u = np.r_[best.u[:p], problem.comparison.guess(r, best.u[p:])]  # times, now that it looks so
    problem.measure_noise(best.u)
    best = problem.solve(best.u, 1e-3)
    if problem.leave_hidden(best.u):
        tell("tips are hidden: they are left out")
        problem.measure_noise(best.u)
        best = problem.solve(best.u, 1e-3)
    problem.measure_noise(best.u)
    if finer and (wanted := problem.wanted_accuracy()) < accuracy:
        tell(f"the data are finer than the runs: once more with -accuracy {wanted:.1g}")
        problem.expect(sum(runs_of_stages(problem)[1:]))
        return polished(problem, best, wanted, tell, finer=False)
    problem.measure_errors(best.u, problem.raw_jacobian(best.u, central=True))
    best = problem.solve(best.u, 1e-4)
    problem.expect(runs_of_stages(problem)[2])
    tell(f"{problem.count} runs, polished")
    return best


def by_name(value, what, example):
    """Refuses what is no dict by names."""
    if value is not None and not (isinstance(value, Mapping) and all(isinstance(name, str) for name in value)):
        raise TendrilError(f"fit: give {what} by name, {example}")


def check_numbers(unit, fps, y_down, accuracy, starts, seed, jobs):
    """fit()'s arguments that are one number or word each."""
    if not isinstance(unit, str):
        raise TendrilError(f'fit: unit {unit}: give its name, "cm" or "px"')
    if y_down not in (None, True, False):
        raise TendrilError(f"fit: y_down {y_down}: give True, False or None")
    if fps is not None:
        number(fps, "fit: fps", above=0)
    if number(accuracy, "fit: accuracy", above=0) > 1:
        raise TendrilError(f"fit: accuracy {accuracy:g}: give a relative error, 3e-4")
    for value, what, least in ((starts, "starts", 0), (seed, "seed", 0), (jobs, "jobs", 1)):
        if value is not None:
            whole(value, f"fit: {what}", least)


# a straight rod is as long, whatever these are
TOLD_BY_BENDS = re.compile(r"friction_|si_friction_|si_bending_stiffness|rod_stiffness|contact_friction|tip_force|rod_weight")
STRAIGHT, THROUGH = 1e-9, 0.02  # of the extent of points: how far they are off a line; how far it passes the clamp


def stays_straight(measured) -> bool:
    """Whether all points of all photographs lie on one line, and that goes through the clamp."""
    points = [p.points.numbers for p in measured.photographs]
    if not points or measured.curves:
        return False
    points = np.vstack(points)
    middle = points.mean(axis=0)
    _, size, axes = np.linalg.svd(points - middle, full_matrices=False)
    across = np.array([-axes[0, 1], axes[0, 0]])
    through = measured.photographs[0].points.unit == PIXEL or abs(across @ middle) <= THROUGH * np.ptp(points, axis=0).max()
    return bool(size[1] <= STRAIGHT * size[0] and through)


def check_bent(measured, looked_for, options):
    """Refuses to look for what only a bend tells where there is none."""
    texts = {word: name for name, text in options.items() if isinstance(text, str) for word in re.findall(r"{(\w+)}", text)}
    of_bends = [p.name for p in looked_for if TOLD_BY_BENDS.match(texts.get(p.name, p.name).lstrip("-"))]
    if of_bends and stays_straight(measured):
        count = len(measured.photographs)
        where = "the photograph" if count == 1 else f"all {count} photographs"
        raise TendrilError(f"fit: the rod is straight in {where}: nothing tells {', '.join(of_bends)}; give photographs in which "
                           "it bends, or a series beside them, as base_force_1")


def made(scene, data, parameters, *, unit, fps, y_down, priors, tied, noise, jobs, options) -> Problem:
    """The problem of fit()'s arguments."""
    by_name(parameters, "parameters", '{"si_friction_dry": ("0.1N/m", "2N/m")}')
    by_name(priors, "priors", '{"si_bending_stiffness": ("4.5e-4", "1e-5")}')
    by_name(tied, "tied", '{"si_friction_viscous": "2*si_friction_dry Ns/m^2"}')
    by_name(noise, "noise", '{"lines": "0.5mm"}')
    known = [Prior.of(name, prior) for name, prior in (priors or {}).items()]
    bounds = dict(parameters or {}) | {k.name: k.bounds() for k in known if k.name not in parameters}
    looked_for = [Parameter.of(name, value) for name, value in bounds.items()]
    if not looked_for:
        raise TendrilError('fit: give what to look for, {"si_friction_dry": ("0.1N/m", "2N/m")}')
    for k in known:
        p = next(p for p in looked_for if p.name == k.name)
        if p.unit != k.unit:
            raise TendrilError(f"prior of {k.name}: its bounds are in {p.unit or 'no unit'}; give it so, too")
    measured = gather(data, unit, y_down, fps)
    check_bent(measured, looked_for, options)
    if (count := measured.count() + len(known)) <= len(looked_for):
        raise TendrilError(f"fit: {len(looked_for)} parameters from {count} numbers that were measured: nothing would be left over to "
                           "tell how they err; look for fewer, or measure more")
    return Problem(scene, measured, looked_for, options, jobs, priors=known, tied=tied,
                   noise=measured.told(noise))


@arguments(progress="flag?")
def fit(scene, data, parameters: Mapping[str, tuple | str], *, unit: str = "", fps: float | None = None, y_down: bool | None = None,
        priors: Mapping[str, tuple | str] | None = None, tied: Mapping[str, str] | None = None,
        noise: Mapping[str, str] | None = None, accuracy: float = 3e-4, starts: int | None = None,
        seed: int = 1, jobs: int | None = None, progress: bool | None = None, watch=None, **options) -> Fit:
    """Finds the parameters of a scene that give what was measured.

    scene       as for run
    data        a CSV file, several in a list, or {"20s": photograph}; see tendril.measured
    parameters  {"si_friction_dry": ("0.1N/m", "2N/m"), "clamp_angle": (-0.2, 0.2, 0)}: bounds, and a
                start where one is known. Beside options: camera_x, camera_y, camera_turn, camera_scale (the
                picture beside the rod), clock_rate, clock_offset
    unit        of coordinates that carry none: "cm", "px"
    fps         frames per second, of data that count frames
    y_down      whether x2 is counted downwards; None: of px it is, else it is not
    priors      {"si_bending_stiffness": ("4.5e-4", "1e-5")}: mean and standard deviation of what is known
    tied        {"si_friction_viscous": "2*si_friction_dry Ns/m^2"}: options that follow from parameters
    noise       {"lines": "0.5mm", "base_force_1": "2mN"}: of what was measured, where it is known, and
                independent from point to point; else it is estimated, with its correlation
    accuracy    of the runs, or better where the data are; the search for a start takes 30 times that
    starts      points that fill the bounds, beside the start itself; the two best are followed, and a start
                that was given; twice as many as long as no two end in one place. None: 24 for one
                parameter, 12 for two, else 8
    seed        of these points
    progress    a bar of the runs, and a line for each stage; None: the bar alone, in a terminal and in a notebook
    watch       a page of tendril.watch(), which shows the rods that are tried over what was measured
    options     that all runs have, as for run; {name} in their text is a parameter

    Ctrl-C ends the search; the best until then is returned. Raises TendrilError, in one line, for data or a
    scene that cannot be read or run."""
    begin = time.perf_counter()
    check_numbers(unit, fps, y_down, accuracy, starts, seed, jobs)
    problem = made(scene, data, parameters, unit=unit, fps=fps, y_down=y_down, priors=priors, tied=tied, noise=noise,
                   jobs=jobs, options=options)
    problem.seen = FitSeen(watch, problem) if watch else None
    p = len(problem.parameters)
    tell = problem.show(progress, expected=(starts or 8) + sum(runs_of_stages(problem)))
    agreed, costs, interrupted = True, [], False
    try:
        best, costs, agreed = search(problem, max(8, 24 // p) if starts is None else starts,
                                     min(SEARCH * accuracy, COARSEST), seed, tell)
        best = polished(problem, best, accuracy, tell)
        best, known = certain(problem, best, tell)
    except KeyboardInterrupt:
        if problem.best is None:
            problem.hide(done=False)
            raise
        tell("interrupted; the best until now")
        interrupted, (best, known) = True, rough(problem)
    except BaseException:
        problem.hide(done=False)
        raise
    found = finished(problem, best, known, costs, begin, interrupted, agreed or starts == 0, tell)
    if problem.seen:
        problem.seen.ended(found)
    return found


def finished(problem: Problem, best: Solution, known: Certainty, costs, begin, interrupted, agreed, tell) -> Fit:
    """What was found, and what speaks against it."""
    try:
        try:
            r = problem.first(best.u[:len(problem.parameters)], problem.settings)
        except KeyboardInterrupt:  # of all that was found nothing is missing but this run
            interrupted, r = True, problem.first(best.u[:len(problem.parameters)], problem.settings)
        found = Fit(problem, best.u, known.covariance, known.reach, r, best.cost, costs, 0.0,
                    interrupted=interrupted, ends=known.ends)
        found.indistinct = indistinct(found)
        found.warnings = [] if interrupted else doubted(found, agreed, tell)
    finally:
        problem.hide()
    found.seconds = time.perf_counter() - begin
    return found


def doubted(found: Fit, agreed, tell):
    """What speaks against it; Ctrl-C ends this alone."""
    try:
        return warnings_of(found, agreed, tell)
    except KeyboardInterrupt:
        found.doubtful = True
        return ["what speaks against the fit was not looked for to its end: interrupted."]


def rough(problem: Problem):
    """(the best point of a search that was interrupted, what is known of it)"""
    # Ctrl-C in a terminal is for the runs, too: what they left is no run to the end
    problem.ended, problem.known = False, {}
    best = Solution(problem.best, np.nan)
    problem.measure_noise(best.u)
    jacobian = problem.raw_jacobian(best.u)
    raw = problem.measure_errors(best.u, jacobian)
    best.cost = problem.cost(problem.errors.whitened(raw, search=True))
    return best, certainty(problem.errors, raw, jacobian, problem.prior_information(len(best.u)),
                           problem.told_noise, CONFIDENCE)

"""What speaks against a fit, and what may be its cause, each in a line.

A fit always ends somewhere. Here it is asked whether the rod is where the points are (residuals, places
without points), whether what is left over looks like errors (runs of one sign along the rod; the same
side of the rod in every photograph), and whether something that is no parameter would take it away:
the picture's place, turn and scale, its clock, by their linearised effect, which costs no run; what the scene leaves
out, by a run each (tendril.laws); and if the fit is bad also data mirrored, with columns exchanged, in another unit. A
cause that is named was tried: the fit was made again with it. Where one is named, or residuals have a pattern that none
explains, the intervals are not to be trusted, and the fit says so."""

from __future__ import annotations

import contextlib
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from scipy import stats

from .comparing import ANGLES, BARE, ENDS, LINES, VIEW
from .errors import RunError, TendrilError
from .found import Found
from .laws import Law, effects_of, laws_of, with_law
from .measured import Measured, Values
from .noise import estimate, lasting
from .parameters import Parameter
from .problem import Problem, Solution
from .starting import starting_points
from .units import METRES, TIMES, briefly, scales_of_rod

BAD = 0.02  # of the extent: residuals beyond are no errors of clicking
BAD_SERIES = 0.05  # of the range of a series
SURE = 1e-4  # the probability at which what is left over is no chance
BETTER, SLIGHT = 0.6, 0.8  # a cause is one if residuals fall to this part, of a fit that is not bad
WELL = 1 / 3  # to this part also with one that ends at the most that is tried,
STILL = 2.5  # or leaves them beyond so many times what is called bad: next to points at random anything explains a little
ALIKE = 1.25  # residuals are known no better than to such a factor: causes within it are not told apart
APART = 3.0  # times the noise of other photographs: what lies farther from the rod is beside it
ODD, FEWER = 0.4, 0.1  # of a photograph's points, or fewer that lie twice as far: it is none of the others
MUCH = 0.2  # of the rods: where tips are hidden, so much may be where there are no points
GOES_ON = 0.05  # of the extent: so far beyond its points a rod's tip was not seen
EDGE = 0.01  # of its bounds: there a cause is as large as was tried
LONGER = 3.0  # runs so much longer than those that were made are not tried
COARSE = 3e-3  # the accuracy of runs for another time
TRIAL = 20  # runs, about, to try a cause
LAWS = 2  # of those that the residuals ask for, that are tried
CLEARLY = 5.0  # of the log-likelihood: as much as 10 of AIC
SEEN = 2e-3  # of the extent: a cause that moves the points less is left alone
FACTORS = {1e-3: "1000", 1e-2: "100", 0.1: "10", 10.0: "10", 100.0: "100", 1e3: "1000"}


@dataclass
class Cause:
    """Something that may be wrong with the data: how they would be without, and what else is looked for."""

    words: str  # with {camera_turn} and the like
    looked_for: tuple[str, ...] = ()
    change: tuple[str, float | tuple] | None = None  # of the data, as changed() knows it
    law: Law | None = None  # nothing is wrong with the data: the scene leaves it out

    @property
    def name(self) -> str:
        return self.law.parameter.name if self.law else ", ".join(self.looked_for) or self.change[0]

    @property
    def of_time(self) -> bool:
        """Whether runs must go on for another time with it."""
        return any(name.startswith("clock") for name in self.looked_for) or bool(self.change) and self.change[0] == "time"


CAUSES = [Cause("the points lie beside the rod by ({camera_x}, {camera_y}): the clamp is not at (0, 0). Give it, or "
                "look for camera_x and camera_y", ("camera_x", "camera_y")),
          Cause("the picture is turned by {camera_turn}. Turn the points, or look for camera_turn", ("camera_turn",)),
          Cause("the points are {camera_scale} times as large as the rod: scale or unit. Correct it, or look for "
                "camera_scale", ("camera_scale",)),
          Cause("the clock of the data goes {clock_rate} times as fast as the rod's. Correct it, or look for "
                "clock_rate", ("clock_rate",)),
          Cause("the clock of the data is ahead by {clock_offset}. Correct it, or look for clock_offset",
                ("clock_offset",))]


def spread_of(values):
    """The standard deviation as the median tells it."""
    return float(np.median(np.abs(values)) / stats.norm.ppf(0.75)) if len(values) else 0.0


def sizes(fit: Found):
    """{group: (size of its residuals, what was measured from end to end)}"""
    comparison = fit.problem.comparison
    raw = fit.problem.raw(fit.u, fit.run)[:len(comparison.groups)]
    groups, spreads = np.array(comparison.groups), comparison.spreads()
    # of points also the upper ones count: half of a rod may be right
    return {name: (max(spread_of(raw[groups == name]), np.quantile(np.abs(raw[groups == name]), 0.8) / 1.28),
                   spreads[name]) for name in spreads}


def limit_of(group) -> float:
    """The part of what was measured beyond which residuals are called bad."""
    return BAD if group == LINES else BAD_SERIES


def runs_along(fit: Found):
    """(how many standard deviations fewer runs of one sign there are along the rod than by chance, how
    many there are, how many were to be expected): Wald and Wolfowitz, over all photographs."""
    raw = fit.problem.raw(fit.u, fit.run)
    seen = expected = variance = 0.0
    for block in fit.problem.errors.blocks:
        signs = raw[block.rows][np.argsort(block.place, kind="stable")] > 0
        above, below, n = np.sum(signs), np.sum(~signs), len(signs)
        if min(above, below) < 1:
            continue
        mean = 2 * above * below / n + 1
        seen, expected = seen + 1 + np.count_nonzero(np.diff(signs)), expected + mean
        variance += (mean - 1) * (mean - 2) / max(n - 1, 1)
    return (expected - seen) / np.sqrt(max(variance, 1e-12)), int(seen), expected


def same_side(fit: Found, bins=8):
    """(the probability of it by chance, the place as a part of the rod, how far) where in all photographs the points
    lie most clearly on one side of the rod; None of fewer than four photographs."""
    raw = fit.problem.raw(fit.u, fit.run)
    rows = []
    for block in fit.problem.errors.blocks:
        if block.normal is not None:
            part = np.minimum((block.place / max(block.place.max(), 1e-300) * bins).astype(int), bins - 1)
            rows.append([np.median(raw[block.rows][part == k]) if np.any(part == k) else np.nan for k in range(bins)])
    table = np.array(rows)
    if len(table) < 4:
        return None
    best = (1.0, 0.0, 0.0)
    for k in range(bins):
        column = table[np.isfinite(table[:, k]), k]
        if len(column) >= 4 and np.ptp(column) > 0:
            chance = float(stats.ttest_1samp(column, 0).pvalue) * bins
            best = min(best, (chance, (k + 0.5) / bins, abs(float(np.median(column)))))
    return best


def bare_part(fit: Found):
    """The part of the rods near which there are no points."""
    comparison = fit.problem.comparison
    raw = fit.problem.raw(fit.u, fit.run)[:len(comparison.groups)]
    far = raw[np.array(comparison.groups) == BARE]
    return float(np.mean(far > 0.01 * comparison.spreads()[LINES])) if len(far) else 0.0


def off_the_rod(distances, others):
    """(the part of a photograph's points that is farther from the rod than those of the others are, how far in the middle);
    (0, 0) where that may be chance: strays are in all photographs alike, and some are in each."""
    far = APART * max(spread_of(others), 1e-300)
    beside, elsewhere = np.abs(distances) > far, np.abs(others) > far
    count = int(np.sum(beside))
    if not count or stats.binom.sf(count - 1, len(beside), (np.sum(elsewhere) + 1) / (len(elsewhere) + 2)) > SURE:
        return 0.0, 0.0
    part, size = count / len(beside), float(np.median(np.abs(distances[beside])))
    return (part, size) if part > (FEWER if size > 2 * far else ODD) else (0.0, 0.0)


def odd_ones(fit: Found):
    """Photographs that do not belong to the others, in words: of another time, or of another rod. The intervals allow for
    them as for strays, and nothing else tells of them. None of fewer than three photographs."""
    comparison, raw = fit.problem.comparison, fit.problem.raw(fit.u, fit.run)
    photographs = comparison.measured.photographs
    blocks = [raw[b.rows] for b in comparison.blocks if b.normal is not None]
    words = []
    for k, p in enumerate(photographs if len(photographs) > 2 else ()):
        part, size = off_the_rod(blocks[k], np.concatenate(blocks[:k] + blocks[k + 1:]))
        if size > SEEN * comparison.spreads()[LINES]:
            unit = {"t": " s", "length": " m"}[p.abscissa] if p.abscissa and p.at.si else ""
            name = f"the photograph at {p.abscissa} = {briefly(float(p.at.numbers))}{unit}" if p.abscissa else p.source
            words.append(f"{name}: {100 * part:.0f} % of its points lie beside the rod, by {briefly(100 * size / comparison.spreads()[LINES])} % of the "
                         "extent, where the others' are on it: of another time, or another rod? Leave it out, and see.")
    return words


def view_step(fit: Found, name):
    """A small change of one of VIEW's numbers, in the units of the data."""
    extent = fit.problem.comparison.spreads().get(LINES, 1.0)
    times = fit.problem.measured.abscissae("t")
    span = max((float(np.max(at.numbers)) for at in times), default=0.0)
    return {"camera_x": 1e-3 * extent, "camera_y": 1e-3 * extent, "camera_turn": 1e-3, "camera_scale": 1e-3,
            "clock_rate": 2e-3, "clock_offset": 2e-3 * span}[name]


def applies(fit: Found, cause: Cause):
    """Whether a cause is possible, and no parameter already."""
    problem = fit.problem
    names = {p.name for p in problem.parameters}
    if names & set(cause.looked_for):
        return False
    if cause.looked_for == ("camera_turn",) and angles_of(problem.measured):
        return problem.comparison.camera is None
    if any(name.startswith("camera") for name in cause.looked_for):
        return bool(problem.measured.photographs) and problem.comparison.camera is None
    return bool(problem.measured.abscissae("t"))


def angles_of(measured: Measured):
    """The series that are angles of a tip or a base."""
    return [c for c in measured.curves if c.name in ANGLES]


def effect_on_view(fit: Found, cause: Cause):
    """[residual, number], how residuals change with the numbers of a cause that is of picture or clock: no run is made."""
    problem, p = fit.problem, len(fit.parameters)
    view, base = problem.view(fit.u), problem.raw(fit.u, fit.run)
    columns = []
    for name in cause.looked_for:
        step = view_step(fit, name)
        moved = problem.comparison.residuals(fit.run, fit.u[p:], view | {name: view[name] + step})
        columns.append((np.append(moved, base[len(moved):]) - base) / step)
    return np.column_stack(columns)


class Sign(NamedTuple):
    """What the residuals say of a cause."""

    chance: float  # the probability that they ask for it as clearly as they do by chance
    moved: float  # how far it would move them, over the extent
    statistic: float  # how clearly they ask, as F
    shift: float  # the largest of how far parameters would go with it, in halves of their intervals
    half: np.ndarray  # of the intervals of parameters with it


def linear_sign(fit: Found, effect, of_law=False) -> Sign:
    """The effect of a cause [residual, number] is put beside those of the parameters, with errors estimated anew, for
    what it explains is none."""
    problem, base = fit.problem, fit.problem.raw(fit.u, fit.run)
    jacobian = np.column_stack([problem.errors.jacobian, effect])
    prior = np.zeros((jacobian.shape[1],) * 2)
    prior[:len(fit.u), :len(fit.u)] = problem.prior_information(len(fit.u))
    errors = estimate(problem.comparison.blocks, base, jacobian, problem.errors.alone, prior, problem.told_noise,
                      problem.errors)
    white = errors.whitened(np.column_stack([base, jacobian]))
    covariance = np.linalg.pinv(prior + white[:, 1:].T @ white[:, 1:], hermitian=True)
    whole = -(covariance @ white[:, 1:].T @ white[:, 0])
    change, p = whole[len(fit.u):], len(fit.parameters)
    reach = fit.reach[:p] * np.sqrt(np.maximum(np.diag(fit.covariance)[:p], 1e-300))
    found = covariance[len(fit.u):, len(fit.u):]
    # what photographs err by alike is told as often as once
    # (a number that changes nothing, as where a straight rod is pushed along itself, explains nothing)
    statistic = float(change @ np.linalg.pinv(found, hermitian=True) @ change) / len(change) / (lasting(errors, base) if of_law else 1)
    photographs = max(len(problem.measured.photographs), 3)
    moved = float(np.sqrt(np.mean((effect[problem.errors.mine()] @ change) ** 2)))
    extent = problem.comparison.spreads().get(LINES, np.inf)
    return Sign(float(stats.f.sf(statistic, len(change), 4 * photographs)), moved / extent, statistic,
                float(np.max(np.abs(whole[:p]) / reach)), fit.reach[:p] * np.sqrt(np.maximum(np.diag(covariance)[:p], 0)))


def wide(fit: Found, name) -> Parameter:
    """One of VIEW's numbers as a parameter, wide enough for what happens."""
    extent = fit.problem.comparison.spreads().get(LINES, 1.0)
    span = max((float(np.max(at.numbers)) for at in fit.problem.measured.abscissae("t")), default=1.0)
    lines = fit.problem.measured.photographs
    metre = "m" if lines and lines[0].points.si else ""
    second = "s" if any(at.si for at in fit.problem.measured.abscissae("t")) else ""
    low, high, unit = {"camera_x": (-0.3 * extent, 0.3 * extent, metre), "camera_turn": (-0.6, 0.6, ""),
                       "camera_y": (-0.3 * extent, 0.3 * extent, metre), "camera_scale": (0.4, 2.5, ""),
                       "clock_rate": (0.5, 2.0, ""), "clock_offset": (-0.4 * span, 0.4 * span, second)}[name]
    return Parameter(name, low, high, VIEW[name], unit)


def bare_time(one) -> bool:
    """Whether a photograph or a series has its times without a unit."""
    return one.abscissa == "t" and not one.at.si


def changed(measured: Measured, change) -> Measured:
    """The data without a fault."""
    kind, factor = change
    if kind == "time":
        return Measured(*([replace(one, at=Values(one.at.numbers * factor, "l/V")) if bare_time(one) else one for one in some]
                          for some in (measured.photographs, measured.curves)))
    if kind == "angles":
        times, plus = factor
        return Measured(measured.photographs, [replace(c, values=replace(c.values, numbers=times * c.values.numbers + plus))
                                               if c.name in ANGLES else c for c in measured.curves])
    if kind == "metre":
        return Measured([replace(p, points=Values(p.points.numbers * factor, "l")) for p in measured.photographs],
                        measured.curves)
    matrix = {"none": [[1, 0], [0, 1]], "mirror": [[1, 0], [0, -1]], "swap": [[0, 1], [1, 0]], "unit": [[factor, 0], [0, factor]],
              "back": [[-1, 0], [0, 1]]}[kind]
    photographs = [replace(p, points=replace(p.points, numbers=p.points.numbers @ np.array(matrix, float)))
                   for p in measured.photographs]
    return Measured(photographs, measured.curves)


def tried(fit: Found, cause: Cause):
    """(the size of the residuals once a cause is allowed for, over what it was; the problem and its end, None if the cause
    explains nothing)"""
    old = fit.problem
    if cause.law:
        more, starts = [cause.law.parameter], [[begin] for begin in cause.law.begins]
        new = with_law(fit, cause.law, old.settings)  # what it changes may be little: not by the search's coarse runs
    else:
        more = [wide(fit, name) for name in cause.looked_for]
        starts = [[p.inside(VIEW[p.name]) for p in more]]
        new = old.like(old.search_settings, old.search_known, changed(old.measured, cause.change) if cause.change else None, more)
    points = [fit.u[:len(old.parameters)]]
    if cause.law and cause.law.usual:  # what was found without it may be far from what it is with it
        points += [np.full(len(old.parameters), 0.5)]
    if cause.change and cause.of_time:  # nothing that was run is of use
        new.prepare(points[0], COARSE)
        points += starting_points(new, 8, 1)
    elif cause.of_time:
        new.settings |= {k: v for k, v in new.ends().items() if k not in old.options}
        new.known = {}
    elif cause.change:  # from all points that were ever run, as the data now look
        points += list(old.search_points.values())
    points = [np.r_[u, start] for u in points for start in starts]
    whole = [np.r_[u, new.comparison.guess(r, fit.u[len(old.parameters):])] for u, r in zip(points, new.run(points))
             if not isinstance(r, RunError)]
    if not whole:
        return 1.0, new, None
    new.measure_noise(whole[0], share=0.03)
    best = Solution(min(whole, key=lambda u: new.cost(new.residuals(u))), np.inf)
    for share in (0.01, None) if cause.law else (0.03, 0.01):
        new.measure_noise(best.u, share=share)
        best = new.solve(best.u, 3e-3, most=8)
    (r,) = new.run([best.u])
    found = replace(fit, problem=new, u=best.u, run=r)
    after = sizes(found)
    ratio = float(np.mean([a[0] / a[1] / max(b[0] / b[1], 1e-12) for a, b in zip(after.values(), sizes(fit).values())]))
    own = best.u[len(old.parameters):len(new.parameters)]
    in_vain = not cause.law and np.any((own < EDGE) | (own > 1 - EDGE)) or any(
        size > STILL * limit_of(name) * extent for name, (size, extent) in after.items())
    return ratio, new, None if in_vain and ratio > WELL else best.u


def spoken(fit: Found, problem: Problem, u, cause: Cause):
    """A cause in words, with its numbers."""
    if cause.law:
        found = [f"{p.name} = {float(f'{p.value(x):.3g}'):g} {p.unit}".rstrip() for p, x in zip(problem.parameters, u)]
        return (f"the scene, in which {cause.law.words}: with {found[-1]} it has {', '.join(found[:-1])}. Look for "
                f"{cause.law.parameter.name}, too")
    view = problem.view(u)
    lines, times = problem.measured.photographs, problem.measured.abscissae("t")
    length = (lambda x: f"{briefly(1e3 * x)} mm") if lines and lines[0].points.si else (lambda x: f"{x:.2g}")
    second = " s" if any(at.si for at in times) else ""
    said = {"camera_x": length(view["camera_x"]), "camera_y": length(view["camera_y"]),
            "camera_turn": f"{np.degrees(view['camera_turn']):.2g} degrees",
            "camera_scale": f"{view['camera_scale']:.3g}", "clock_rate": f"{view['clock_rate']:.3g}",
            "clock_offset": f"{view['clock_offset']:.3g}{second}"}
    return cause.words.format_map(said)


def unitless(measured: Measured, attributes):
    """Causes that are numbers without a unit beside a scene in the laboratory's."""
    scales, causes = scales_of_rod(attributes), []
    if scales.get("time") and any(map(bare_time, [*measured.photographs, *measured.curves])):
        causes += [Cause(f"the times are in {name}, but carry no unit, and were taken as dimensionless: write t ({name})",
                         change=("time", float(TIMES[name]))) for name in ("s", "min")
                   if TIMES[name] < LONGER * scales["time"]]
    if scales.get("length") and any(p.points.unit == "" for p in measured.photographs):
        causes += [Cause(f"the coordinates are in {name}, but carry no unit, and were taken as dimensionless: write "
                         f"x1 ({name})", change=("metre", METRES[name])) for name in ("m", "cm", "mm")]
    return causes


def discrete():
    """Causes that are no small change."""
    return [Cause("x2 has the wrong sign: the picture is mirrored, or y counts downwards (--y-down)",
                  change=("mirror", 0)),
            Cause("x1 and x2 are exchanged", change=("swap", 0)),
            Cause("x1 has the wrong sign: it must grow away from the clamp", change=("back", 0)),
            *(Cause(f"the coordinates are {text} times too {'large' if factor < 1 else 'small'}: another unit",
                    change=("unit", factor)) for factor, text in FACTORS.items())]


def of_angles():
    """The same of angles: how they may count otherwise than the scene."""
    quarter, degree = np.pi / 2, np.pi / 180
    return [Cause("the angles have the other sign: the scene's grow from x1 towards x2", change=("angles", (-1.0, 0.0))),
            Cause("the angles count from x2, not from x1: write 90 less the angle", change=("angles", (-1.0, quarter))),
            Cause("the angles count from -x2, not from x1: write the angle less 90", change=("angles", (1.0, -quarter))),
            Cause("the angles are in degrees, and their heading says radians", change=("angles", (degree, 0.0))),
            Cause("the angles are in radians, and their heading says degrees", change=("angles", (1 / degree, 0.0)))]


def promising(fit: Found, causes, most=2):
    """Of discrete causes those under which one of the runs of the search lies nearest to the data: no run
    is made for it."""
    found = []
    for cause in causes:
        problem, costs = fit.problem, []
        new = problem.like(problem.search_settings, problem.search_known, changed(problem.measured, cause.change))
        for u in problem.search_points.values():
            (r,) = new.run([u])
            if not isinstance(r, RunError):
                whole = np.r_[u, new.comparison.guess(r)]
                if not new.noise:
                    new.measure_noise(whole, share=0.03)
                costs.append(new.cost(new.residuals(whole)))
        if costs:
            found.append((min(costs), cause))
    found.sort(key=lambda pair: pair[0])
    return [cause for _, cause in found[:most]]


def plain_units(measured: Measured, attributes):
    """Numbers that carry no unit beside a scene in the laboratory's, in words."""
    words, scales = [], scales_of_rod(attributes)
    for abscissa, kind, unit in (("t", "time", "s"), ("length", "length", "m")):
        if scales.get(kind) and any(not at.si for at in measured.abscissae(abscissa)):
            words.append(f"{abscissa} carries no unit, and is taken as dimensionless: 1 of it is {scales[kind]:.3g} "
                         f"{unit} in this scene. If it is in seconds or metres write {abscissa} ({unit})")
    if scales.get("length") and any(p.points.unit == "" for p in measured.photographs):
        words.append(f"x1 and x2 carry no unit, and are taken as dimensionless: 1 of them is "
                     f"{scales['length']:.3g} m in this scene. Write x1 (cm), or give --unit cm")
    return words


def searched_again(fit: Found):
    """(the part to which residuals fall, in words) of a search that goes on from all that was run, with nothing changed: a
    cause that does no better is none. (1, None): they do not fall."""
    ratio, problem, u = tried(fit, Cause("", change=("none", 0)))
    fit.problem.count += problem.count
    if u is None or ratio > BETTER:
        return 1.0, None
    raw, groups = problem.raw(u, problem.run([u])[0]), np.array(problem.comparison.groups)
    ends = raw[:len(groups)][groups == ENDS]
    if unseen := int(np.sum(ends > GOES_ON * problem.comparison.spreads()[LINES])):
        return ratio, (f"likeliest cause: in {unseen} of {len(ends)} photographs the rod goes on beyond the points: its tip is out of the "
                       f"picture, or hidden. Leave these out (residuals fall to {briefly(100 * ratio)} % where that costs little).")
    there = ", ".join(p.text(float(f"{p.value(x):.4g}")) for p, x in zip(problem.parameters, u))
    return ratio, (f"the search ended beside the solution: at {', '.join(p.name for p in problem.parameters)} = {there} residuals fall to "
                   f"{briefly(100 * ratio)} %. Give that as START, or more --starts.")


class End(NamedTuple):
    """A cause that was tried."""

    ratio: float  # what is left of the residuals with it
    count: int  # of its numbers
    words: str
    law: bool = False  # of the scene
    place: tuple = ()  # (the fit's own parameters with it, from 0 to 1, halves of their intervals)
    raw: np.ndarray | None = None  # residuals with it, if the data are the same
    blocks: list = []  # theirs


def most_likely(ends, least, bad=False):
    """Of causes that were tried those that take the most away, if that is enough: of several that do it about as well
    none is more likely. Of a fit that is not bad a law was asked for by the residuals, and needs to take little: numbers
    make up for it."""
    cost = lambda end: end.ratio * (1 + 0.05 * end.count)
    order = sorted((end for end in ends if (end.ratio < 1 if end.law and not bad else cost(end) < least)), key=lambda end: (cost(end), end.words))
    return [end for end in order if cost(end) <= ALIKE * cost(order[0]) + 1e-6]


def told_apart(fit: Found, alike):
    """Of causes that do about as well, where one is a law of the scene, those that the data do not tell apart by their
    likelihood, with the errors that the best of them leaves."""
    if not any(end.law for end in alike) or any(end.raw is None for end in alike):
        return alike
    errors, best = fit.problem.errors, alike[0]
    told = estimate(best.blocks, best.raw, errors.jacobian, errors.alone, fit.problem.prior_information(errors.jacobian.shape[1]),
                    fit.problem.told_noise)
    likely = [told.log_likelihood(end.raw) for end in alike]
    return [end for end, one in zip(alike, likely) if one > max(likely) - CLEARLY]


def causes_named(alike):
    """The causes that are the most likely, in one line."""
    said = [f"{end.words} (residuals fall to {briefly(100 * end.ratio)} % with it)" for end in alike]
    if len(said) == 1:
        left = alike[0].ratio > WELL and not alike[0].law
        return f"likeliest cause: {said[0]}." + (" What is left may as well be the scene's, a law that it leaves out." if left else "")
    return f"likeliest causes, which these data do not tell apart: {'; or '.join(said)}." if said else ""


def wanted_laws(fit: Found, bad):
    """(how clearly, the cause), for laws that the scene leaves out and the residuals ask for: by chance hardly, and with
    them parameters would leave their intervals."""
    laws, found = laws_of(fit), []
    fit.problem.expect(len(laws))
    for law, effect in zip(laws, effects_of(fit, laws)):
        with contextlib.suppress(np.linalg.LinAlgError):
            found += [(linear_sign(fit, effect, of_law=True), Cause("", law=law))] if effect is not None else []
    return [pair for pair in found if bad or (pair[0].chance < SURE and pair[0].shift > 1)]


def likeliest(fit: Found, bad, tell):
    """The cause that takes most of the residuals away, in words, or what was tried in vain."""
    possible = [(linear_sign(fit, effect_on_view(fit, cause)), cause) for cause in CAUSES if applies(fit, cause)]
    signs = [pair for pair in possible if bad or (pair[0].chance < SURE and pair[0].moved > SEEN)]
    laws = sorted(wanted_laws(fit, bad), key=lambda pair: -pair[0].statistic)
    laws = [pair for k, pair in enumerate(laws) if k < LAWS or bad and pair[1].law.usual]
    if not (bad or signs or laws):
        return []
    signs.sort(key=lambda pair: -pair[0].statistic)
    causes = [cause for _, cause in signs[:None if bad else 3] + laws]
    units = unitless(fit.problem.measured, fit.run.attributes) if bad else []
    if bad and not fit.problem.comparison.camera:
        changes = (discrete() if fit.problem.measured.photographs else []) + (of_angles() if angles_of(fit.problem.measured) else [])
        causes += promising(fit, [c for c in [*changes, *units] if not c.of_time])
    causes = [c for c in units if c.of_time] + causes
    fit.problem.expect(TRIAL * (len(causes) + bad))
    if bad and fit.problem.measured.photographs:
        tell("searching again")
        nothing, again = searched_again(fit)
    else:
        nothing, again = 1.0, None
    ends, p = [], len(fit.parameters)
    halves = {cause.name: sign.half for sign, cause in signs + laws}
    for cause in causes:
        tell(f"trying a cause: {cause.name}")
        try:
            ratio, problem, u = tried(fit, cause)
        except (TendrilError, np.linalg.LinAlgError):
            continue
        fit.problem.count += problem.count
        if u is not None and (again is None or ALIKE * ratio < nothing):
            raw = None if cause.change else problem.raw(u, problem.run([u])[0])
            half = halves.get(cause.name, np.zeros(p))
            ends.append(End(ratio, len(cause.looked_for) + bool(cause.law), spoken(fit, problem, u, cause), cause.law is not None,
                            (u[:p], half), raw, problem.comparison.blocks))
    if alike := told_apart(fit, most_likely(ends, BETTER if bad else SLIGHT, bad)):
        fit.elsewhere = [end.place for end in alike]
        return [causes_named(alike)]
    if again:
        return [again]
    fit.doubtful = True
    return ["likeliest cause: none of place, turn, scale, unit, mirror, clock explains it; the scene is not "
            "the experiment, or these are not points of the rod."] if bad else \
        [f"residuals ask for {' and '.join(cause.name for cause in causes)}, which explain little of them: the scene is not the "
         "experiment, or the data have a fault."]


def stays_straight(fit: Found) -> bool:
    """Whether nothing ever bends the rod of the best scene, which then tells nothing of what holds it."""
    angles = fit.run.series.get("max_angle", ())
    return len(angles) > 0 and not fit.run.in_space and float(np.abs(angles).max()) < 1e-9


def warnings_of(fit: Found, agreed, tell) -> list[str]:
    """What speaks against a fit, in lines."""
    words, bad = plain_units(fit.problem.measured, fit.run.attributes), False
    for name, (size, extent) in sizes(fit).items():
        if size > limit_of(name) * extent:
            bad = True
            what = "the points lie beside the rod of the best scene" if name == LINES else \
                f"{name} is off the best scene's"
            words.append(f"a bad fit: {what} by {briefly(100 * size / extent)} % of the extent; the numbers above "
                         "mean little.")
    part, hidden = bare_part(fit), fit.problem.comparison.hidden
    if part > (MUCH if hidden else 0.05):
        bad = True
        words.append(f"a bad fit: {100 * part:.0f} % of the rods of the best scene are where there are no points.")
    fewer, seen, expected = runs_along(fit)
    if fewer > stats.norm.isf(SURE):
        along = "along the rod" if fit.problem.measured.photographs else "over time"
        words.append(f"residuals come in runs of one sign {along} ({seen}, by chance {expected:.0f}): "
                     "neighbouring points err alike, which the intervals allow for, or the scene lacks something.")
    side = same_side(fit)
    if side and side[0] < 1e-2 and not bad:
        words.append(f"in all photographs the points lie on one side of the rod at {100 * side[1]:.0f} % of its "
                     f"length, by {100 * side[2] / fit.problem.comparison.spreads()[LINES]:.1g} % of the extent: the scene lacks something there, or the picture is off.")
    words += (odd := odd_ones(fit))
    if hidden:
        words.append(f"in {len(hidden)} of {len(fit.problem.measured.photographs)} photographs the rod goes on beyond the points: something hides its "
                     "tip, or the scene's rod is too long. Where it ends in these is left out.")
    for name, told in fit.problem.told_noise.items():
        size = sizes(fit)[name][0]
        if size > 1.5 * told:
            words.append(f"the residuals of {name} are {briefly(size / told)} times the noise that was told.")
    if not agreed:
        words.append("no two searches ended in one place: the best may not be the best there is. More --starts, "
                     "narrower bounds, or a START.")
    if bad and stays_straight(fit):
        fit.doubtful = True
        return [*words, "the rod of the best scene is straight, and stays so whatever its friction: give it the bend that it has by "
                "nature, -rod_curvature, or look for it, --parameter rod_curvature=LOW:HIGH."]
    words += likeliest(fit, bad, tell)
    fit.doubtful = fit.doubtful or bad or not agreed or bool(odd)
    return words

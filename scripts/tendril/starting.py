"""Where a search begins."""

from __future__ import annotations

import numpy as np
from scipy import stats

from .comparing import Comparison, time_of
from .errors import RunError
from .problem import Problem
from .results import Results, as_text
from .runs import critical
from .units import in_si

# the power of the unit of length that each goes with
SCALES = {"si_bending_stiffness": 3, "si_friction_dry": -3, "si_friction_viscous": -3}


def starting_points(problem: Problem, starts, seed):
    """Parameters, from 0 to 1, from which the search may begin: those asked for (else the middle of
    their bounds), those of the straight rod's theory, and some that fill the bounds evenly."""
    first = np.array([0.5 if p.start is None else p.inside(p.start) for p in problem.parameters])
    cube = stats.qmc.LatinHypercube(len(first), seed=seed).random(max(starts, 0))
    free = np.array([p.start is None for p in problem.parameters])
    theory = theory_start(problem, first) if free.any() else None
    return [first, *([theory] if theory is not None else []), *cube]


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
        c = critical(problem.scene, progress=False, **{k: v for k, v in words.items() if k != "rod_curvature_file"})
    except RunError:
        return None
    k = free[0]
    p = problem.parameters[k]
    value = p.value(u[k]) * (bent / c.length) ** SCALES[p.name]
    moved = np.array(u)
    moved[k] = np.clip(p.inside(np.clip(value, p.low, p.high)), 0.02, 0.98)
    return moved


def exchanged(problem: Problem, u):
    """The point at which a root remembers for as long as it took to straighten, and straightens as fast as it forgot: two delays
    in a row, of which the tip's angle hardly tells which comes first, so that the cost has a minimum for each. None where not
    both are looked for."""
    names = [p.name for p in problem.parameters]
    about, looked = problem.rod(u), ("tropism_proprioception", "tropism_memory")
    if not set(looked) <= set(names) or as_text(about.get("parameters/growth_type", "")) != "apical":
        return None
    straightens, remembers = (names.index(name) for name in looked)
    memory = problem.parameters[remembers]
    one = in_si(memory.unit) / about["si_time"] if memory.unit else 1.0  # of the memory's unit, in the run's
    zone = float(about["parameters/growth_zone"])  # in the time in which as much has grown
    G, T = (max(float(problem.parameters[k].value(u[k])), 1e-6) for k in (straightens, remembers))
    values = {straightens: zone / (T * one), remembers: zone / (G * one)}
    if "tropism_gravity" in names:  # the first bend stays as fast
        k = names.index("tropism_gravity")
        values[k] = float(problem.parameters[k].value(u[k])) * values[remembers] / T
    moved = np.array(u, float)
    for k, value in values.items():
        p = problem.parameters[k]
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

"""What a scene leaves out: numbers that it holds, and that the data may ask for.

A fit looks for a few numbers and takes the rest for known. Where that is wrong (friction that is viscous, too, or larger
across the rod) the numbers make up for it, and their intervals, which allow for how points err, say nothing of it. So for
each law that is likely the rod is run once more with a little of it, and the residuals are asked whether they want it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .errors import TendrilError
from .found import Found
from .parameters import MODE, Parameter
from .problem import Problem
from .results import Results
from .sweeps import stored
from .units import TIMES, quantity, scales_of_rod

A_LITTLE = 0.02  # of its bounds: so much of a law tells what it would do
USUALLY = 0.3  # of its bounds: about so much such scenes have
BENT = 4.0  # radians over the whole rod: so far natural curvature is tried to both sides
STRAIGHTENS, REMEMBERED = 10.0, 0.25  # proprioception, and memory as a part of the run, that are tried where there is none
MOST = 4.0  # times, or parts, of what it is: so far other numbers are tried


@dataclass
class Law:
    """A number that the scene holds, with bounds between which it is tried."""

    words: str  # what the scene says of it
    parameter: Parameter
    held: float  # in the parameter's unit
    usual: bool = False  # such scenes mostly have it, and this one has nothing of it

    @property
    def name(self) -> str:
        return self.parameter.name

    @property
    def begins(self) -> list[float]:
        """Numbers of the parameter from which it is tried; of what is missing altogether a little may not show what it does."""
        return [self.begin, USUALLY] if self.usual else [self.begin]

    @property
    def begin(self) -> float:
        """A number of the parameter, a little from where it is held, to the side on which there is more room."""
        at = float(self.parameter.inside(self.held))
        return at + (A_LITTLE if at <= 0.5 else -A_LITTLE)


class Held:
    """What a scene holds: the numbers in force in a run, apart from those that a fit looks for."""

    def __init__(self, fit: Found):
        problem = fit.problem
        self.run, self.attributes, self.given = fit.run, fit.run.attributes, fit.run.options
        self.free = {p.name for p in problem.parameters} | set(problem.tied)
        self.free |= {name.lstrip("-") for name, text in problem.options.items() if isinstance(text, str) and "{" in text}
        self.scales = scales_of_rod(self.attributes)
        self.length = float(fit.run.series.length[-1])

    def number(self, name, default=0.0) -> float:
        found = self.attributes.get(f"parameters/{name}", default)
        return float(found) if isinstance(found, (int, float, np.number)) else 0.0

    def text(self, name) -> str:
        return str(self.attributes.get(f"parameters/{name}", ""))

    def friction(self):
        """The share of friction that the scene holds, mostly at nothing."""
        speed, dry, viscous = (self.number(f"si_{name}") for name in ("speed", "friction_dry", "friction_viscous"))
        if not self.scales and "friction_mu" not in self.free:
            mu = self.number("friction_mu", 1.0)
            said = {1.0: "all friction is dry", 0.0: "all friction is viscous"}.get(mu, f"the dry share of friction is {mu:g}")
            yield Law(said, Parameter("friction_mu", 0.0, 1.0, None, ""), mu)
        if self.scales and speed and not viscous:
            yield Law("all friction is dry", Parameter("si_friction_viscous", 0.0, MOST * dry / speed, None, "Ns/m^2"), 0.0)
        if self.scales and speed and not dry:
            yield Law("all friction is viscous", Parameter("si_friction_dry", 0.0, MOST * viscous * speed, None, "N/m"), 0.0)

    def curvature(self):
        """Natural curvature, or one that varies along the rod by a cosine more, where no file tells it."""
        modes = [int(found[1]) for found in map(MODE.match, self.free) if found]  # then the file is the fit's own
        if not modes and {"rod_curvature_file", "rod_curvature_random"} & set(self.given):
            return
        scale, unit = (self.scales["length"], "/m") if self.scales else (1.0, "")
        most, held = BENT / (self.length * scale), self.number("rod_curvature") / scale
        if modes or "rod_curvature" in self.free:
            said = "natural curvature is the same all along the rod" if not modes else f"natural curvature has no mode {max(modes) + 1}"
            yield Law(said, Parameter(f"curvature_mode_{max(modes, default=1) + 1}", -most, most, None, unit), 0.0)
        else:
            yield Law(f"natural curvature is {held:.3g}{unit}", Parameter("rod_curvature", held - most, held + most, None, unit), held)

    def senses(self):
        """Of growth that senses: whether anything straightens the rod, and how long it remembers."""
        if not (self.number("tropism_gravity") or self.number("tropism_light")):
            return
        name, held = "tropism_proprioception", self.number("tropism_proprioception")
        if name not in self.free:
            said = f"proprioception is {held:.3g}" if held else "nothing straightens what is bent (no proprioception)"
            yield Law(said, Parameter(name, held / MOST, MOST * held or STRAIGHTENS, None, ""), held, not held)
        name, held = "tropism_memory", self.number("tropism_memory")
        if name not in self.free:
            one = self.scales.get("time", 1.0) / (TIMES["h"] if "time" in self.scales else 1.0)
            unit, last = "h" if "time" in self.scales else "", float(self.run.series.t[-1])
            said = f"what is sensed is remembered for {held * one:.3g} {unit}".rstrip() if held else "what is sensed acts at once"
            yield Law(said, Parameter(name, held * one / MOST, (MOST * held or REMEMBERED * last) * one, None, unit), held * one)

    def as_given(self, name):
        """(a number, its unit), as the scene has it."""
        number, unit = quantity(self.given.get(name, "")) or (self.number(name), "")
        return number, unit

    def others(self):
        """Friction across the rod, the load on its tip, where it grows."""
        growth = self.text("growth_type")
        for name, said, used in (("friction_across", "friction across the rod is {} of that along it", True),
                                 ("growth_zone", "the growth zone is {} long", growth == "apical"),
                                 ("growth_width", "the growth zone is {} wide", growth == "gaussian")):
            if used and self.number(name) > 0 and name not in self.free:
                held, unit = self.as_given(name)
                yield Law(said.format(f"{held:.3g} {unit}".rstrip()), Parameter(name, held / MOST, held * MOST, None, unit), held)
        if "tip_force" not in self.free and self.text("tip_type") in ("", "free"):
            one, unit = (self.scales["force"], "N") if self.scales else (1.0, "")
            held = self.number("tip_force") * one
            yield Law(f"the force on the tip is {held:.3g} {unit}".rstrip(),
                      Parameter("tip_force", held - one, held + one, None, unit), held)


def laws_of(fit: Found) -> list[Law]:
    """What may be wrong with the scene of a fit: the numbers that it holds."""
    held = Held(fit)
    return [*held.friction(), *held.curvature(), *held.senses(), *held.others()]


def with_law(fit: Found, law: Law, settings) -> Problem:
    """The problem of a fit with a law to look for, too, behind its parameters; no run of it is known."""
    old = fit.problem
    new = old.like(settings, more=[law.parameter])
    if new.reach == 1.0:  # of modes of curvature, which it had none of
        new.reach = float(fit.run.series.length[-1]) * old.unit_length(fit.u) / old.unit_length(old.begin)
    return new


def effects_of(fit: Found, laws):
    """[residual, 1] of each, how residuals change with a law's number, over its bounds: from a run with a little of it, all
    side by side. None of one whose run is refused or gives up."""
    old, p, base = fit.problem, len(fit.parameters), fit.problem.raw(fit.u, fit.run)
    problems = [with_law(fit, law, old.settings) for law in laws]
    points = [np.r_[fit.u[:p], law.begin, fit.u[p:]] for law in laws]
    try:
        runs = stored([new.words(u) | new.settings for new, u in zip(problems, points)], old.scene, old.jobs)
    except TendrilError:
        runs = [None] * len(laws)
    old.counted(len(laws))

    def effect(law, new, u, r):
        if not isinstance(r, Results):
            return None
        r.attributes = new.rod(u)
        return ((new.raw(u, r) - base) / (law.begin - float(law.parameter.inside(law.held))))[:, None]

    return [effect(*one) for one in zip(laws, problems, points, runs)]

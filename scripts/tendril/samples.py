"""What a fit's intervals leave out: the shape of the posterior, by profiles and by samples.

    p = tendril.profile(f, "si_friction_dry")     # cost over one parameter, the others at their best
    s = tendril.sample(f, steps=200)              # emcee; the runs of a step are one job of -task sweep
    s.corner().savefig("corner.png"); s.interval("si_friction_dry")

The errors are as the fit estimated them: what is not known of these, and what lasts over many photographs, widens
the fit's own intervals and not these. The prior is flat within the bounds, of a parameter that is looked for by its
logarithm in that; with it goes what was given as priors."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from .errors import TendrilError
from .fitting import Fit
from .naming import unknown
from .problem import FAILED
from .profiles import held
from .progress import bar

FEWEST = 10  # steps of an interrupted chain that are of use


@dataclass
class Profile:
    """The least cost over values of one parameter."""

    name: str
    values: np.ndarray
    cost: np.ndarray  # above that of the fit; 1.92 at the ends of an interval of 95 %


def profile(fit: Fit, name, count=9, reach=3.0) -> Profile:
    """The least cost with a parameter held at some values, to both sides of its estimate as many standard
    deviations as reach says: how an interval of the linearised problem ought to be."""
    problem = fit.problem
    names = [p.name for p in fit.parameters]
    if name not in names:
        raise TendrilError(f"profile: {name} is no parameter{unknown(name, names)}")
    k = names.index(name)
    deviation = np.sqrt(np.diag(fit.covariance))
    at = np.unique(np.clip(fit.u[k] + np.linspace(-reach, reach, count) * deviation[k], 0, 1))
    slope = fit.covariance[:, k] / max(fit.covariance[k, k], 1e-300)  # how the others follow
    costs = []
    for value in at:
        u = fit.u + slope * (value - fit.u[k])
        u[:len(names)] = np.clip(u[:len(names)], 0, 1)
        u[k] = value
        costs.append(held(problem, u, k)[0])
    return Profile(name, fit.parameters[k].value(at), np.array(costs) - fit.cost)


@dataclass
class Samples:
    """Of the posterior: values [n, parameter] in the units of the bounds."""

    names: list[str]
    values: np.ndarray
    acceptance: float
    steps_between: float  # steps after which a walker has forgotten where it was
    units: list[str] = field(default_factory=list)
    estimate: list[float] | None = None  # of the fit

    def interval(self, name, share=0.95):
        column = self.values[:, self.names.index(name)]
        return tuple(float(v) for v in np.quantile(column, [(1 - share) / 2, (1 + share) / 2]))

    def corner(self, **options):
        """A corner plot of all parameters, with lines at the fit's estimate; options as corner.corner has them."""
        try:
            import corner
        except ImportError:
            raise TendrilError("a corner plot needs corner: pip install 'tendril[sample]'") from None
        units = self.units or [""] * len(self.names)
        labels = [f"{name} ({'1' * unit.startswith('/') + unit})" if unit else name for name, unit in zip(self.names, units)]
        return corner.corner(self.values, **{"labels": labels, "titles": self.names, "truths": self.estimate,
                                             "quantiles": (0.025, 0.975), "title_quantiles": (0.025, 0.5, 0.975),
                                             "show_titles": True, "title_fmt": ".4g",
                                             "title_kwargs": {"fontsize": 8}, "label_kwargs": {"fontsize": 9}} | options)


def sample(fit: Fit, steps=200, walkers=None, burn=0.3, seed=1, progress: bool | None = None) -> Samples:
    """Samples of the posterior by emcee's affine invariant walkers; all runs of a step go side by side.

    steps    of each walker
    walkers  None: four for each number that is looked for, eight at least
    burn     the part at the beginning that is left out
    progress a bar; None: in a terminal and in a notebook

    Ctrl-C ends it; the samples until then are returned."""
    try:
        import emcee
    except ImportError:
        raise TendrilError("samples need emcee: pip install 'tendril[sample]'") from None
    problem, p, n = fit.problem, len(fit.parameters), len(fit.u)
    walkers = walkers or max(8, 4 * n)
    random, pressed = np.random.default_rng(seed), []

    def chance(points):
        inside = np.all((points[:, :p] >= 0) & (points[:, :p] <= 1), axis=1)
        kept, found = dict(problem.known), np.full(len(points), -np.inf)
        try:
            if inside.any():
                problem.run(points[inside])
            for k in np.flatnonzero(inside):
                f = problem.residuals(points[k])
                found[k] = -np.inf if np.all(f == FAILED) else -problem.cost(f)
        except KeyboardInterrupt:  # of which emcee would print all it has at hand
            pressed.append(True)
            found[:] = -np.inf
        problem.known = kept  # thousands of runs are no memory's load
        return found

    begin = fit.u + 0.5 * random.multivariate_normal(np.zeros(n), fit.covariance, walkers, check_valid="ignore")
    begin[:, :p] = np.clip(begin[:, :p], 1e-6, 1 - 1e-6)
    sampler = emcee.EnsembleSampler(walkers, n, chance, vectorize=True)
    sampler.random_state = np.random.RandomState(seed).get_state()
    with bar(progress, steps, what="sample", unit="step") as shown:
        try:
            for _ in sampler.sample(begin, iterations=steps):
                shown.update()
                if pressed:
                    raise KeyboardInterrupt
        except KeyboardInterrupt:
            if sampler.iteration < FEWEST:
                raise
    chain = sampler.get_chain(discard=int(burn * sampler.iteration), flat=True)
    values = np.column_stack([q.value(chain[:, k]) for k, q in enumerate(fit.parameters)])
    return Samples([q.name for q in fit.parameters], values, float(np.mean(sampler.acceptance_fraction)),
                   float(np.max(sampler.get_autocorr_time(quiet=True, tol=0))), [q.unit for q in fit.parameters],
                   [fit.values[q.name] for q in fit.parameters])

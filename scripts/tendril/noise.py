"""The errors of what was measured, and what they leave unknown.

Points of a photograph do not err each by itself. The error of one goes over into its neighbours, for a
tracker follows an edge or a shadow, and the whole photograph lies beside its place, for the camera was
touched. With r the residuals of a photograph, p the arc length of each, n its normal,

    cov(r_i, r_j) = sigma^2 delta_ij / w_i  +  (smooth^2 K(|p_i - p_j| / reach) + shift^2) n_i.n_j

K is Matern's kernel 3/2 or Gauss's, and the reach the same in all photographs or one part of each rod's
length (KINDS): which of the four it is the residuals tell. It matters: a kernel too rough, or a reach too
short in the long photographs, which tell most, gives intervals of half the width they should have. w < 1
takes the weight off a stray point. Of a series place is time, n = 1, and
there is no shift. Angles over time are fitted evenly, as if all erred by themselves, and only their intervals know of the
covariance V: with W of those errors alone, A = (J^T W J)^-1, that of the parameters is A J^T W V W J A. What a law of growth
leaves of one curve is smooth itself, and weights V^-1, which forgive what is smooth, would let the search slide away from the
data along it. Several organs may be shifted as photographs are. The four numbers are estimated from the residuals by restricted maximum likelihood (REML),
which knows that the parameters have taken up a part of them; the parameters then by generalised least
squares. What the residuals do not tell of kind and numbers makes intervals wider: all of their values
count, each by its likelihood times a flat prior of the standard deviations (importance sampling), and
an interval is one of that mixture of normal distributions."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Callable, NamedTuple

import numpy as np
from scipy import linalg, optimize, stats

STRAY = 2.5  # a point this many standard deviations off, given its neighbours, counts less
FAR = 4.0  # the same, before correlation is known
BETWEEN = 6.0  # standard deviations: a point that is not so much farther from another strand tells nothing
NOTHING = 1e-6  # the weight of such a point
FLOOR = 0.05  # of all errors, what is at least independent: a model of a rod is no better to tell neighbours apart
EXACT = 1e-3  # of what residuals would err by alone: what is smaller is rounding, or data without any error
AT_ONCE = 2**15  # of matrices' entries, that are worked on together
DRAWS = 128  # of the errors' numbers, of each kind
UNLIKELY = 4.0  # the logarithm of how much less likely a kind of errors is that is left alone
SAME = 1e-3  # and of how much less likely one is only by rounding: where points err by themselves none is seen


@dataclass
class Block:
    """Residuals whose errors belong together: a photograph, a series."""

    group: str
    rows: np.ndarray  # [m], among all residuals
    place: np.ndarray  # [m], arc length or time
    normal: np.ndarray | None  # [m, 2]; None: of a series
    other: np.ndarray  # [m], how much farther another strand of the rod is: of which is it a point?
    evenly: bool = False  # all count alike in the search, however their errors are correlated
    shifts: bool = False  # of a series: one of several, which may lie beside their place as a whole

    @property
    def whole(self) -> bool:
        """Whether it may be shifted."""
        return self.normal is not None or self.shifts

    @property
    def extent(self) -> float:
        """From the first place to the last: of a photograph, how long the rod is."""
        return float(np.ptp(self.place)) or 1.0


def matern(distance):
    """(Matern's kernel 3/2, its derivative by the logarithm of the reach), of distances over the reach."""
    z = np.sqrt(3) * distance
    falls = np.exp(-z)
    return (1 + z) * falls, z**2 * falls


def gauss(distance):
    """The same of Gauss's."""
    square = distance**2
    falls = np.exp(-0.5 * square)
    return falls, square * falls


class Kind(NamedTuple):
    """How errors that are smooth are alike."""

    kernel: Callable
    power: int  # of a block's extent, that the reach goes with


KINDS = [Kind(matern, 0), Kind(gauss, 0), Kind(matern, 1), Kind(gauss, 1)]


@dataclass
class Group:
    """The errors of all blocks of one kind. Standard deviations are in the unit of the residuals."""

    sigma: float
    smooth: float = 0.0
    reach: float = 1.0  # of the longest block
    shift: float = 0.0
    kind: Kind = KINDS[0]
    longest: float = 1.0  # extent of a block

    @property
    def total(self) -> float:
        return float(np.sqrt(self.sigma**2 + self.smooth**2 + self.shift**2))

    def alike(self, gaps, extent):
        """(K, its derivative by log reach), of places so far from each other, in a block of that extent."""
        return self.kind.kernel(gaps / (self.reach * (extent / self.longest) ** self.kind.power))


@dataclass
class Errors:
    """The error model of all residuals, with the weights of single ones."""

    blocks: list[Block]
    groups: dict[str, Group]
    weights: np.ndarray  # [n]
    alone: np.ndarray  # [n], the standard deviation of residuals that are in no block
    jacobian: np.ndarray | None = None  # [n, p], with which they were estimated

    def covariance(self, block: Block, group: Group | None = None):
        """[m, m], of the residuals of a block."""
        g = group or self.groups[block.group]
        v = np.diag(g.sigma**2 / self.weights[block.rows])
        alike = 1.0 if block.normal is None else block.normal @ block.normal.T
        if g.smooth:
            v += g.smooth**2 * g.alike(np.abs(block.place[:, None] - block.place), block.extent)[0] * alike
        if g.shift and block.whole:
            v += g.shift**2 * alike
        return v

    def evenly(self, block: Block):
        """[m], the standard deviations of its residuals if all erred by themselves."""
        return self.groups[block.group].total / np.sqrt(self.weights[block.rows])

    def whitened(self, values, search=False):
        """Residuals, or a Jacobian [n, p], so that their errors are independent and of size 1; the sum
        of their squares is r.V^-1.r. search: as they count in the search (Block.evenly)."""
        out = (values.T / self.alone).T
        for block in self.blocks:
            if search and block.evenly:
                out[block.rows] = (values[block.rows].T / self.evenly(block)).T
                continue
            factor = linalg.cholesky(self.covariance(block), lower=True, check_finite=False)
            out[block.rows] = linalg.solve_triangular(factor, values[block.rows], lower=True,
                                                      check_finite=False)
        return out


    def mine(self):
        """The rows that are in a block, all together."""
        return np.concatenate([b.rows for b in self.blocks])

    def numbers(self) -> int:
        """How many numbers the model has that are not nought."""
        return sum(1 + 2 * (g.smooth > 1e-3 * g.total) + (g.shift > 1e-3 * g.total) for g in self.groups.values())

    @property
    def telling(self):
        """[n], which residuals tell something."""
        return self.weights > NOTHING

    def log_likelihood(self, residuals, rows=None) -> float:
        """Of what tells something, or of these rows of it [n]."""
        rows, total = self.telling if rows is None else rows, 0.0
        for block in self.blocks:
            told = rows[block.rows]
            factor = linalg.cholesky(self.covariance(block)[np.ix_(told, told)], lower=True, check_finite=False)
            white = linalg.solve_triangular(factor, residuals[block.rows[told]], lower=True, check_finite=False)
            total -= 0.5 * (white @ white) + np.sum(np.log(np.diag(factor))) + 0.5 * len(white) * np.log(2 * np.pi)
        return float(total)


class Estimate:
    """REML of one group's errors, all others as they are."""

    def __init__(self, errors: Errors, name, residuals, jacobian, prior):
        self.errors, self.name = errors, name
        self.blocks = [b for b in errors.blocks if b.group == name and len(b.rows)]
        # a row whose weight is nothing would ask for errors as small as may be, for its likelihood goes with 1/sigma
        told = [errors.telling[b.rows] for b in self.blocks]
        if not np.any(np.concatenate(told)):  # then they must do
            told = [np.ones(len(b.rows), bool) for b in self.blocks]
        # all blocks as large as the largest, with rows that say nothing: 0 = 0 with an error of 1
        size, count, p = max(len(b.rows) for b in self.blocks), len(self.blocks), jacobian.shape[1]
        self.values = np.zeros((count, size, 1 + p))
        self.gaps, self.alike = np.zeros((count, size, size)), np.zeros((count, size, size))
        self.extra, self.empty = np.zeros((count, size)), np.ones((count, size))
        for k, (b, kept) in enumerate(zip(self.blocks, told)):
            rows, place, m = b.rows[kept], b.place[kept], np.count_nonzero(kept)
            self.values[k, :m] = np.column_stack([residuals[rows], jacobian[rows]])
            self.gaps[k, :m, :m] = np.abs(place[:, None] - place)
            self.alike[k, :m, :m] = 1.0 if b.normal is None else b.normal[kept] @ b.normal[kept].T
            self.extra[k, :m], self.empty[k, :m] = 1 / errors.weights[rows], 0
        self.lines = any(b.whole for b in self.blocks)
        self.evenly = any(b.evenly for b in errors.blocks)  # some of all residuals count so
        self.extents = np.array([b.extent for b in self.blocks])[:, None, None]
        self.kind, self.kinds = KINDS[0], KINDS if np.ptp(self.extents) > 0.1 * self.extents.max() else KINDS[:2]
        mine = np.zeros(len(residuals), bool)
        mine[np.concatenate([b.rows for b in self.blocks])] = True
        white = errors.whitened(np.column_stack([residuals, jacobian]))[~mine]
        self.others, self.rest = prior + white[:, 1:].T @ white[:, 1:], white[:, 1:].T @ white[:, 0]
        if self.evenly:
            self.sandwiched = [sandwiched(errors, jacobian, prior, ~mine, scatter) for scatter in (False, True)]
            self.weight = np.where(self.empty, 0, 1 / np.maximum(self.extra, 1e-300)) / errors.groups[name].total**2
        spans = [np.ptp(b.place) for b in self.blocks]
        steps = [np.median(np.diff(np.sort(b.place))) for b in self.blocks if len(b.rows) > 2]
        self.longest = max(0.25 * max(spans), 1e-12)  # what is alike over more is a shift
        self.shortest = min(max(np.median(steps) if steps else 0, 1e-3 * self.longest), 0.5 * self.longest)

    def group(self, theta) -> Group:
        """theta: log sigma, smooth/sigma0, log reach, shift/sigma0; or many of them, [4, draw, 1, 1, 1]."""
        return Group(np.exp(theta[0]), abs(theta[1]) * self.unit, np.exp(theta[2]),
                     abs(theta[3]) * self.unit * self.lines, self.kind, float(self.extents.max()))

    def terms(self, theta):
        """(log of the restricted likelihood, information of the numbers, their gradient); of residuals that count evenly the
        information that is left of it, and the gradient is 0 at the end of the search whatever V is."""
        g = self.group(theta)
        likelihood, information, gradient, _ = self.solved(g)
        if self.evenly:
            weighed = self.weight[..., None] * self.values[:, :, 1:]  # W J
            mine = np.einsum("kma,kmb->ab", weighed, self.values[:, :, 1:]), np.einsum(
                "kma,...kmn,knb->...ab", weighed, self.covariance(g)[0], weighed)
            if not self.blocks[0].evenly:
                mine = 2 * (information - self.others,)
            whole, spread = (others + own for others, own in zip(self.sandwiched, mine))
            information, gradient = whole @ np.linalg.inv(spread) @ whole, np.zeros_like(gradient)
        return likelihood, information, gradient

    def covariance(self, g: Group):
        """[..., block, m, m], and K n.n with its derivative by log reach."""
        kernel, longer = g.alike(self.gaps, self.extents)
        kernel, longer = kernel * self.alike, longer * self.alike
        v = g.smooth**2 * kernel + g.shift**2 * self.alike
        diagonal = np.arange(v.shape[-1])
        v[..., diagonal, diagonal] += (g.sigma**2 * self.extra[:, None])[..., 0, :] + self.empty
        return v, kernel, longer

    def solved(self, g: Group, inverse=None, v=None):
        """The terms, and V^-1 [r J]; of many groups, of each."""
        v = self.covariance(g)[0] if v is None else v
        logs = 2 * np.sum(np.log(np.einsum("...mm->...m", np.linalg.cholesky(v))), axis=(-2, -1))
        solved = np.linalg.solve(v, self.values) if inverse is None else inverse @ self.values
        products = np.einsum("kma,...kmb->...ab", self.values, solved)
        information, gradient = self.others + products[..., 1:, 1:], self.rest + products[..., 1:, 0]
        _, determinant = np.linalg.slogdet(information)
        fitted = np.sum(gradient * np.linalg.solve(information, gradient[..., None])[..., 0], axis=-1)
        return -0.5 * (logs + determinant + products[..., 0, 0] - fitted), information, gradient, solved

    def allowed(self, theta):
        return np.log(FLOOR) - 1e-9 <= theta[0] - self.middle < 12 and \
            np.log(self.shortest) <= theta[2] <= np.log(self.longest)

    def cost(self, theta):
        return self.cost_and_terms(theta)[0]

    def cost_and_terms(self, theta):
        """The cost, and (information, gradient) that it was made of; None where it is out of all bounds."""
        try:
            value, *terms = self.terms(theta) if self.allowed(theta) else (-np.inf,)
        except np.linalg.LinAlgError:
            return 1e10, None
        return (-value, terms) if np.isfinite(value) else (1e10, None)

    def costs_and_terms(self, thetas):
        """The same of many thetas, so many at a time as fit into the memory at hand."""
        allowed = [k for k, theta in enumerate(thetas) if self.allowed(theta)]
        found, most = [(1e10, None)] * len(thetas), max(1, AT_ONCE // self.gaps.size)
        for some in (allowed[k:k + most] for k in range(0, len(allowed), most)):
            try:
                values, informations, gradients = self.terms(thetas[some].T[:, :, None, None, None])
            except np.linalg.LinAlgError:  # of one of them
                for k in some:
                    found[k] = self.cost_and_terms(thetas[k])
                continue
            for k, value, *terms in zip(some, values, informations, gradients):
                found[k] = (-value, terms) if np.isfinite(value) else (1e10, None)
        return found

    def cost_and_slope(self, theta):
        """The cost and its derivatives by theta. With e = V^-1 (r - J b), b the parameters' estimate,

            d cost = 1/2 tr[(V^-1 - e e^T - V^-1 J I^-1 J^T V^-1) dV]"""
        g = self.group(theta)
        try:
            v, kernel, longer = self.covariance(g)
            inverse = np.linalg.inv(v)
            value, information, gradient, solved = self.solved(g, inverse, v)
        except np.linalg.LinAlgError:
            return 1e10, np.zeros(4)
        if not np.isfinite(value):
            return 1e10, np.zeros(4)
        e = solved[:, :, 0] - solved[:, :, 1:] @ np.linalg.solve(information, gradient)
        taken = solved[:, :, 1:] @ np.linalg.inv(information)
        rest = inverse - e[:, :, None] * e[:, None] - taken @ solved[:, :, 1:].transpose(0, 2, 1)
        unit = self.unit**2
        slope = [2 * g.sigma**2 * np.sum(np.einsum("kmm->km", rest) * self.extra),
                 2 * theta[1] * unit * np.sum(rest * kernel), g.smooth**2 * np.sum(rest * longer),
                 2 * theta[3] * unit * self.lines * np.sum(rest * self.alike)]
        return -value, 0.5 * np.array(slope)

    def find(self, near: Group | None = None, known: Group | None = None):
        """theta where the likelihood is largest, of the kind that has the largest: from errors that are all
        independent, from some that are all correlated, from shifts; from what is near, of that kind alone; or from what
        was found before. self.found has (cost, theta, kind) of all kinds, the best first."""
        r, weight = self.values[:, :, 0], np.where(self.empty, 0, 1 / np.maximum(self.extra, 1e-300))
        alone = EXACT * np.median(np.concatenate([self.errors.alone[b.rows] for b in self.blocks]))
        self.unit = max(float(np.sqrt(np.sum(weight * r**2) / np.sum(self.empty == 0))), float(alone))
        self.middle = np.log(self.unit)
        reach = 0.5 * (np.log(self.shortest) + np.log(self.longest))
        low = np.array([self.middle + np.log(FLOOR), 0, np.log(self.shortest), 0])
        high = np.array([self.middle + 2, 10, np.log(self.longest), 10])
        starts = [[self.middle, 0.05, reach, 0.05], [self.middle - 1, 0.7, reach, 0.5 * self.lines]]
        if self.lines:  # and from photographs that are only shifted
            starts.append([self.middle - 0.3, 0.02, reach - 0.5, 0.6])
        if told := near or known:
            starts = [starts[0]] * bool(near) + [[np.log(told.sigma), told.smooth / self.unit, np.log(told.reach), told.shift / self.unit]]
        self.found, kinds = [], self.kinds
        if told:
            kinds = [told.kind] + [kind for kind in kinds if known and kind != told.kind]
        for self.kind in kinds:
            if self.found:  # the other kinds from where the first ended, but with a kernel that is seen
                starts = [np.maximum(self.found[0][1], [-np.inf, 0.05, -np.inf, 0])]
            ends = [optimize.minimize(self.cost_and_slope, np.clip(start, low, high), jac=True, method="L-BFGS-B",
                                      bounds=list(zip(low, high)), options={"maxiter": 60, "ftol": 1e-8})
                    for start in starts]
            best = min(ends, key=lambda one: one.fun)
            self.found.append((best.fun, best.x, self.kind))
        least = min(cost for cost, *_ in self.found)
        # of kinds that are as likely the first, whatever rounding says
        self.found.sort(key=lambda one: (max(one[0], least + SAME), KINDS.index(one[2])))
        _, theta, self.kind = self.found[0]
        return theta

    def spread(self, theta, draws, seed=0):
        """(terms [k] of as many thetas, the logarithm of their shares of the posterior, but for a number that all
        kinds have in common): importance sampling around the best of self.kind, with Student's t of 5 degrees,
        the width that of the likelihood."""
        size = np.array([0.1, 0.1, 0.3, 0.1])
        here, curved = self.cost(theta), np.empty(4)
        for k in range(4):  # the width of each, where the likelihood has fallen by 1/2, on its wider side
            widths = []
            for sign in (-1, 1):
                step = np.zeros(4)
                step[k] = sign * size[k]
                rise = self.cost(theta + step) - here
                widths.append(size[k] * np.sqrt(0.5 / max(rise, 1e-2)) if rise < 1e9 else 0)
            curved[k] = max(widths) or size[k]
        limit = np.array([1, 2, np.log(self.longest / self.shortest) / 2, 2])
        scale = np.clip(curved, 0.02, limit) * 1.2
        random = np.random.default_rng(seed)
        normal = stats.norm.ppf(stats.qmc.Sobol(4, seed=random).random(draws))
        chi = np.sqrt(random.chisquare(5, draws) / 5)
        z = normal / chi[:, None]
        thetas = theta + z * scale
        # what falls below 0 of the two standard deviations is folded back by abs() in group()
        costs, terms = zip(*self.costs_and_terms(thetas))
        proposal = -0.5 * 9 * np.log1p((z**2).sum(axis=1) / 5) - np.sum(np.log(scale))
        return terms, -np.array(costs) - proposal

    def posterior(self, draws):
        """(information, gradient and share of the posterior) of numbers that errors may have, of all kinds
        that are not unlikely."""
        self.find(known=self.errors.groups[self.name])
        least, terms, logs = self.found[0][0], [], []
        for cost, theta, self.kind in self.found:
            if cost > least + UNLIKELY:
                continue
            drawn, one = self.spread(theta, draws)
            kept = one > one.max() + np.log(1e-4)
            terms += [drawn[k] for k in np.flatnonzero(kept)]
            logs.append(one[kept])
        share = np.exp(np.concatenate(logs) - np.max(np.concatenate(logs)))
        return terms, share / share.sum()


def sandwiched(errors: Errors, jacobian, prior, rows, scatter):
    """Of some rows, whole blocks: the information J^T W J as residuals count in the search, and the prior's; or, scatter, the
    covariance of the gradient J^T W r: with A the inverse of the first A (J^T W V W J) A is the parameters'."""
    found, alone = np.array(prior, float), np.array(rows)
    for block in errors.blocks:
        alone[block.rows] = False
        if not rows[block.rows].all():
            continue
        j = jacobian[block.rows]
        if not block.evenly:
            found += j.T @ np.linalg.solve(errors.covariance(block), j)
            continue
        weighed = (j.T / errors.evenly(block) ** 2).T
        found += weighed.T @ errors.covariance(block) @ weighed if scatter else weighed.T @ j
    white = (jacobian[alone].T / errors.alone[alone]).T
    return found + white.T @ white


def screened(residuals, sigma, blocks):
    """[n], weights by which strays count less, before anything is known of correlation."""
    weights = np.ones(len(residuals))
    for block in blocks:
        z = np.abs(residuals[block.rows]) / sigma[block.rows]
        weights[block.rows] = np.minimum(1, (FAR / np.maximum(z, 1e-100)) ** 2)
        weights[block.rows[block.other < BETWEEN * sigma[block.rows]]] = NOTHING
    return weights


def judged(errors: Errors, residuals):
    """The same, each residual judged by what the others of its block say of it."""
    weights = np.ones(len(residuals))
    for block in errors.blocks:
        inverse = np.linalg.inv(errors.covariance(block))
        gap = np.abs(inverse @ residuals[block.rows]) / np.diag(inverse)  # from what the others let expect
        usual = 1 / np.diag(inverse) - errors.groups[block.group].sigma ** 2 * (1 / errors.weights[block.rows] - 1)
        z = gap / np.sqrt(np.maximum(usual, errors.groups[block.group].sigma ** 2))
        weights[block.rows] = np.minimum(1, (STRAY / np.maximum(z, 1e-100)) ** 2)
        weights[block.rows[errors.weights[block.rows] == NOTHING]] = NOTHING
    return weights


def estimate(blocks, residuals, jacobian, sigma, prior, known=None, near: Errors | None = None) -> Errors:
    """The model of the errors by REML, group by group, with the strays found in between.

    residuals  [n], in their units, at the estimate of the parameters
    jacobian   [n, p], of them
    sigma      [n], what they would be if all erred by themselves; stays so for those in no block
    prior      [p, p], information on the parameters from elsewhere
    known      {group: standard deviation} of groups whose errors are told, and independent
    near       a model that is not far: its weights are kept"""
    groups = {b.group: Group(float(sigma[b.rows][0])) for b in blocks if len(b.rows)}
    errors = Errors([b for b in blocks if len(b.rows)], groups, near.weights if near else
                    screened(residuals, sigma, blocks), sigma, jacobian)
    for last in (False, True):
        r = residuals
        for name in groups:
            if name in (known or {}):
                errors.groups[name] = Group(known[name])
                continue
            one = Estimate(errors, name, r, jacobian, prior)
            errors.groups[name] = one.group(one.find(near and near.groups[name]))
        if near:
            return errors
        white = errors.whitened(np.column_stack([residuals, jacobian]))
        step = np.linalg.lstsq(white[:, 1:], white[:, 0], rcond=None)[0]
        weights = judged(errors, residuals - jacobian @ step)
        if last or np.allclose(weights, errors.weights, atol=0.05):
            return errors
        errors = replace(errors, weights=weights)
    return errors


@dataclass
class Certainty:
    """What is known of the parameters: a mixture of normal distributions around their estimate."""

    covariance: np.ndarray  # [p, p], of the mixture
    reach: np.ndarray  # [p], half an interval of 95 %, in standard deviations of the mixture
    ends: dict = field(default_factory=dict)  # {number: (low, high)} of intervals that are not so (tendril.profiles)


def certainty(errors: Errors, residuals, jacobian, prior, known=None, share=0.95) -> Certainty:
    """Of the parameters, at the estimate: over what the residuals tell of their errors."""
    names = [name for name in errors.groups if name not in (known or {})]
    information = prior + (lambda w: w.T @ w)(errors.whitened(jacobian))
    plain = np.linalg.pinv(information, hermitian=True)
    if any(block.evenly for block in errors.blocks):
        whole, spread = (sandwiched(errors, jacobian, prior, np.ones(len(jacobian), bool), scatter) for scatter in (False, True))
        around = np.linalg.pinv(whole, hermitian=True)
        plain = around @ spread @ around
    means, covariances, shares = [np.zeros(len(prior))], [plain], [1.0]
    for name in names[:1]:  # the group that tells most; the others' errors are taken as found
        one = Estimate(errors, max(names, key=lambda n: weight_of(errors, jacobian, n)), residuals, jacobian, prior)
        terms, shares = one.posterior(DRAWS)
        covariances = np.linalg.pinv(np.array([i for i, _ in terms]), hermitian=True)
        means = -np.einsum("kab,kb->ka", covariances, [g for _, g in terms])
    means, covariances, shares = np.array(means), np.array(covariances), np.array(shares)
    middle = shares @ means
    spread = np.einsum("k,ka,kb->ab", shares, means - middle, means - middle)
    covariance = np.einsum("k,kab->ab", shares, covariances) + spread
    factor = lasting(errors, residuals)
    factor *= (stats.t.ppf((1 + share) / 2, freedom(errors)) / stats.norm.ppf((1 + share) / 2)) ** 2
    covariance, covariances, means = factor * covariance, factor * covariances, np.sqrt(factor) * means
    middle = np.sqrt(factor) * middle
    deviations = np.sqrt(np.maximum(np.einsum("kaa->ka", covariances), 0))
    reach = [mixture_reach(means[:, a] - middle[a], deviations[:, a], shares, share) for a in range(len(prior))]
    return Certainty(covariance, np.array(reach) / np.sqrt(np.maximum(np.diag(covariance), 1e-300)))


def freedom(errors: Errors) -> float:
    """Of Student's t: what a photograph errs by as a whole, the part c of the variance, is known from the two components
    of n shifts only, and what errs by itself from all points: 2 (n - 1)/c^2, as Satterthwaite has it. (What is
    smooth along the rod is known from all its pieces, and how well is in the mixture.)"""
    names = {block.group for block in errors.blocks if block.whole}
    count = sum(block.whole for block in errors.blocks)
    if count < 2:
        return 2.0 if count else np.inf
    whole = max((g.shift / max(g.total, 1e-300)) ** 2 for g in (errors.groups[name] for name in names))
    return max(2 * (count - 1) / max(whole, 1e-3) ** 2, 2.0)


def lasting(errors: Errors, residuals, bins=12):
    """How much larger variances are because what a photograph errs by, others err by, too: frames of a film have
    one light, one lens, one threshold. 1 + 2 sum (1 - k/n) c_k of n photographs, with the correlation c_k over k
    of them, as long as it is more than chance; n where all err alike."""
    rows = []
    for block in errors.blocks:
        if block.normal is not None:
            sure = errors.weights[block.rows] > NOTHING
            part = np.minimum((block.place / max(block.place.max(), 1e-300) * bins).astype(int), bins - 1)
            values = residuals[block.rows]
            rows.append([np.mean(values[sure & (part == k)]) if np.any(sure & (part == k)) else np.nan
                         for k in range(bins)])
    if len(rows) < 4:
        return 1.0
    table = np.array(rows)
    squares = table**2
    if not np.isfinite(squares).any():
        return 1.0
    limit = np.nanquantile(squares, 0.9)  # so that no single stray decides
    factor = 1.0
    for k in range(1, len(table)):
        pairs = table[:-k] * table[k:]
        both = np.isfinite(pairs)
        if np.sum(both) < 8:
            break
        power = 0.5 * (np.minimum(squares[:-k], limit) + np.minimum(squares[k:], limit))[both]
        c = np.sum(np.clip(pairs[both], -limit, limit)) / max(np.sum(power), 1e-300) - 1.5 / np.sqrt(np.sum(both))
        if c <= 0:
            break
        factor += 2 * (1 - k / len(table)) * min(c, 1.0)
    return float(factor)


def weight_of(errors: Errors, jacobian, name):
    """How much a group tells of the parameters."""
    rows = np.concatenate([b.rows for b in errors.blocks if b.group == name])
    return float(np.sum(errors.whitened(jacobian)[rows] ** 2))


def mixture_reach(means, deviations, shares, share):
    """Half the width of the interval around 0 that holds a share of a mixture of normal distributions."""
    def beyond(x):
        inside = stats.norm.cdf((x - means) / deviations) - stats.norm.cdf((-x - means) / deviations)
        return shares @ inside - share

    deviations = np.maximum(deviations, 1e-300)
    most = float(np.max(np.abs(means) + 8 * deviations))
    return optimize.brentq(beyond, 0, most) if most > 0 else 0.0

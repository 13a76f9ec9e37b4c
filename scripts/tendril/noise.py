"""The errors of what was measured, and what they leave unknown.

Points of a photograph do not err each by itself. The error of one goes over into its neighbours, for a
tracker follows an edge or a shadow, and the whole photograph lies beside its place, for the camera was
touched. With r the residuals of a photograph, p the arc length of each, n its normal,

    cov(r_i, r_j) = sigma^2 delta_ij / w_i  +  (smooth^2 K(|p_i - p_j| / reach) + shift^2) n_i.n_j

K is Matern's kernel 3/2; w < 1 takes the weight off a stray point. Of a series place is time, n = 1, and
there is no shift. The four numbers are estimated from the residuals by restricted maximum likelihood (REML),
which knows that the parameters have taken up a part of them; the parameters then by generalised least
squares. What the residuals do not tell of the four numbers makes intervals wider: all of their values
count, each by its likelihood times a flat prior of the standard deviations (importance sampling), and
an interval is one of that mixture of normal distributions."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy import linalg, optimize, stats

STRAY = 2.5  # a point this many standard deviations off, given its neighbours, counts less
FAR = 4.0  # the same, before correlation is known
BETWEEN = 6.0  # standard deviations: a point that is not so much farther from another strand tells nothing
NOTHING = 1e-6  # the weight of such a point
FLOOR = 0.05  # of all errors, what is at least independent: a model of a rod is no better to tell neighbours apart
DRAWS = 128  # of the errors' numbers


@dataclass
class Block:
    """Residuals whose errors belong together: a photograph, a series."""

    group: str
    rows: np.ndarray  # [m], among all residuals
    place: np.ndarray  # [m], arc length or time
    normal: np.ndarray | None  # [m, 2]; None: of a series
    other: np.ndarray  # [m], how much farther another strand of the rod is: of which is it a point?


@dataclass
class Group:
    """The errors of all blocks of one kind. Standard deviations are in the unit of the residuals."""

    sigma: float
    smooth: float = 0.0
    reach: float = 1.0
    shift: float = 0.0

    @property
    def total(self) -> float:
        return float(np.sqrt(self.sigma**2 + self.smooth**2 + self.shift**2))


def matern(distance):
    z = np.sqrt(3) * distance
    return (1 + z) * np.exp(-z)


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
            v += g.smooth**2 * matern(np.abs(block.place[:, None] - block.place) / g.reach) * alike
        if g.shift and block.normal is not None:
            v += g.shift**2 * alike
        return v

    def whitened(self, values):
        """Residuals, or a Jacobian [n, p], so that their errors are independent and of size 1; the sum
        of their squares is r.V^-1.r."""
        out = (values.T / self.alone).T
        for block in self.blocks:
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

    def log_likelihood(self, residuals) -> float:
        total = 0.0
        for block in self.blocks:
            factor = linalg.cholesky(self.covariance(block), lower=True, check_finite=False)
            white = linalg.solve_triangular(factor, residuals[block.rows], lower=True, check_finite=False)
            total -= 0.5 * (white @ white) + np.sum(np.log(np.diag(factor))) + 0.5 * len(white) * np.log(2 * np.pi)
        return float(total)


class Estimate:
    """REML of one group's errors, all others as they are."""

    def __init__(self, errors: Errors, name, residuals, jacobian, prior):
        self.errors, self.name = errors, name
        self.blocks = [b for b in errors.blocks if b.group == name and len(b.rows)]
        # all blocks as large as the largest, with rows that say nothing: 0 = 0 with an error of 1
        size = max(len(b.rows) for b in self.blocks)
        count, p = len(self.blocks), jacobian.shape[1]
        self.values = np.zeros((count, size, 1 + p))
        self.gaps, self.alike = np.zeros((count, size, size)), np.zeros((count, size, size))
        self.extra, self.empty = np.zeros((count, size)), np.ones((count, size))
        for k, b in enumerate(self.blocks):
            m = len(b.rows)
            self.values[k, :m] = np.column_stack([residuals[b.rows], jacobian[b.rows]])
            self.gaps[k, :m, :m] = np.abs(b.place[:, None] - b.place)
            self.alike[k, :m, :m] = 1.0 if b.normal is None else b.normal @ b.normal.T
            self.extra[k, :m], self.empty[k, :m] = 1 / errors.weights[b.rows], 0
        self.lines = any(b.normal is not None for b in self.blocks)
        mine = np.zeros(len(residuals), bool)
        mine[np.concatenate([b.rows for b in self.blocks])] = True
        white = errors.whitened(np.column_stack([residuals, jacobian]))[~mine]
        self.others, self.rest = prior + white[:, 1:].T @ white[:, 1:], white[:, 1:].T @ white[:, 0]
        spans = [np.ptp(b.place) for b in self.blocks]
        steps = [np.median(np.diff(np.sort(b.place))) for b in self.blocks if len(b.rows) > 2]
        self.longest = max(0.25 * max(spans), 1e-12)  # what is alike over more is a shift
        self.shortest = min(max(np.median(steps) if steps else 0, 1e-3 * self.longest), 0.5 * self.longest)

    def group(self, theta) -> Group:
        """theta: log sigma, smooth/sigma0, log reach, shift/sigma0."""
        return Group(float(np.exp(theta[0])), abs(theta[1]) * self.unit, np.exp(theta[2]), abs(theta[3]) * self.unit * self.lines)

    def terms(self, theta):
        """(log of the restricted likelihood, information of the numbers, their gradient)"""
        g = self.group(theta)
        v = (g.smooth**2 * matern(self.gaps / g.reach) + g.shift**2) * self.alike
        diagonal = np.arange(v.shape[1])
        v[:, diagonal, diagonal] += g.sigma**2 * self.extra + self.empty
        logs = 2 * np.sum(np.log(np.einsum("kmm->km", np.linalg.cholesky(v))))
        products = np.einsum("kma,kmb->ab", self.values, np.linalg.solve(v, self.values))
        information, gradient = self.others + products[1:, 1:], self.rest + products[1:, 0]
        _, determinant = np.linalg.slogdet(information)
        fitted = gradient @ np.linalg.solve(information, gradient)
        return -0.5 * (logs + determinant + products[0, 0] - fitted), information, gradient

    def cost(self, theta):
        if not np.log(FLOOR) - 1e-9 <= theta[0] - self.middle < 12 or not np.log(self.shortest) <= theta[2] <= np.log(self.longest):
            return 1e10
        try:
            value = self.terms(theta)[0]
        except np.linalg.LinAlgError:
            return 1e10
        return -value if np.isfinite(value) else 1e10

    def find(self, near: Group | None = None):
        """theta where the likelihood is largest: from errors that are all independent, from some
        that are all correlated, from shifts; or from what is near."""
        r, weight = self.values[:, :, 0], np.where(self.empty, 0, 1 / np.maximum(self.extra, 1e-300))
        self.unit = max(float(np.sqrt(np.sum(weight * r**2) / np.sum(self.empty == 0))), 1e-300)
        self.middle = np.log(self.unit)
        reach = 0.5 * (np.log(self.shortest) + np.log(self.longest))
        low = np.array([self.middle + np.log(FLOOR), 0, np.log(self.shortest), 0])
        high = np.array([self.middle + 2, 10, np.log(self.longest), 10])
        starts = [[self.middle, 0.05, reach, 0.05], [self.middle - 1, 0.7, reach, 0.5 * self.lines]]
        if self.lines:  # and from photographs that are only shifted
            starts.append([self.middle - 0.3, 0.02, reach - 0.5, 0.6])
        if near:
            starts = [starts[0], [np.log(near.sigma), near.smooth / self.unit, np.log(near.reach), near.shift / self.unit]]
        found = [optimize.minimize(self.cost, np.clip(start, low, high), method="L-BFGS-B",
                                   bounds=list(zip(low, high)), options={"maxiter": 40, "ftol": 1e-7})
                 for start in starts]
        return min(found, key=lambda one: one.fun).x

    def spread(self, theta, draws, seed=0):
        """(thetas [k, 4], their shares of the posterior): importance sampling around the best, with
        Student's t of 5 degrees, the width that of the likelihood."""
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
        costs = np.array([self.cost(t) for t in thetas])
        proposal = -0.5 * 9 * np.log1p((z**2).sum(axis=1) / 5)
        logs = -costs - proposal
        share = np.exp(logs - logs.max())
        return thetas, share / share.sum()


def screened(residuals, sigma, blocks):
    """[n], weights by which strays count less, before anything is known of correlation."""
    weights = np.ones(len(residuals))
    for block in blocks:
        z = np.abs(residuals[block.rows]) / sigma[block.rows]
        weights[block.rows] = np.minimum(1, (FAR / np.maximum(z, 1e-300)) ** 2)
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
        weights[block.rows] = np.minimum(1, (STRAY / np.maximum(z, 1e-300)) ** 2)
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


def certainty(errors: Errors, residuals, jacobian, prior, known=None, share=0.95) -> Certainty:
    """Of the parameters, at the estimate: over what the residuals tell of their errors."""
    names = [name for name in errors.groups if name not in (known or {})]
    information = prior + (lambda w: w.T @ w)(errors.whitened(jacobian))
    plain = np.linalg.pinv(information, hermitian=True)
    means, covariances, shares = [np.zeros(len(prior))], [plain], [1.0]
    for name in names[:1]:  # the group that tells most; the others' errors are taken as found
        one = Estimate(errors, max(names, key=lambda n: weight_of(errors, jacobian, n)), residuals, jacobian, prior)
        theta = one.find()
        thetas, shares = one.spread(theta, DRAWS)
        kept = shares > 1e-4 * shares.max()
        terms = [one.terms(t)[1:] for t in thetas[kept]]
        covariances = [np.linalg.pinv(i, hermitian=True) for i, _ in terms]
        means = [-c @ g for c, (_, g) in zip(covariances, terms)]
        shares = shares[kept] / shares[kept].sum()
    means, covariances, shares = np.array(means), np.array(covariances), np.array(shares)
    middle = shares @ means
    spread = np.einsum("k,ka,kb->ab", shares, means - middle, means - middle)
    covariance = np.einsum("k,kab->ab", shares, covariances) + spread
    factor = lasting(errors, residuals)
    # correlation is known from so many photographs only, in two directions each
    count = sum(block.normal is not None for block in errors.blocks)
    if count:
        factor *= (stats.t.ppf((1 + share) / 2, max(2 * (count - 1), 2)) / stats.norm.ppf((1 + share) / 2)) ** 2
    covariance, covariances, means = factor * covariance, factor * covariances, np.sqrt(factor) * means
    middle = np.sqrt(factor) * middle
    deviations = np.sqrt(np.maximum(np.einsum("kaa->ka", covariances), 0))
    reach = [mixture_reach(means[:, a] - middle[a], deviations[:, a], shares, share) for a in range(len(prior))]
    return Certainty(covariance, np.array(reach) / np.sqrt(np.maximum(np.diag(covariance), 1e-300)))


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

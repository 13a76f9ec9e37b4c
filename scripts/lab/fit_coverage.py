#!/usr/bin/env python3
"""How often the intervals of tendril.fit hold the truth, over many more seeds than fit_trial.py can: the rod is
run at the truth and a step beside it, once; each seed then has points of its own, whose errors are judged and
whose parameters are found by one step of generalised least squares from the truth, as the end of a fit does it.
What a search may do wrong is not seen here, how the errors are judged is.

    PYTHONPATH=scripts .venv/bin/python scripts/lab/fit_coverage.py [--seeds 200] [--first 1001] \\
      [--errors independent,smooth,shifted,tracker,strays] [SCENE ...]"""

import argparse
import sys
import tempfile
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent))
import fit_trial
from tendril.fitting import CONFIDENCE, made
from tendril.noise import certainty, estimate
from tendril.units import with_unit

STEPS = 3  # of least squares, the errors judged anew before each


class Linear:
    """A trial's runs at its truth and beside it."""

    def __init__(self, trial, place):
        self.trial, self.place, self.truth = trial, place, trial.run()
        self.problem = self.of(1, "independent")
        self.u = np.array([p.inside(with_unit(trial.hidden[p.name])[0]) for p in self.problem.parameters])
        self.problem.prepare(self.u, 3e-4)
        self.points = [self.u, *(self.u + sign * 1e-3 * one for one in np.eye(len(self.u)) for sign in (1, -1))]
        self.runs = self.problem.run(self.points)

    def of(self, seed, errors):
        files = fit_trial.measure(self.trial, self.truth, seed, self.place, errors)
        return made(self.trial.scene, files, self.trial.bounds, unit="", fps=None, y_down=None, priors=None,
                    tied=None, noise=None, jobs=None, options=self.trial.options)

    def attempt(self, seed, errors):
        """(how far the estimates are from the truth, half of each interval), in parts of the bounds"""
        new, old = self.of(seed, errors), self.problem
        for name in ("glimpse", "begin", "reach", "settings"):
            setattr(new, name, getattr(old, name))
        here, *beside = (new.raw(u, r) for u, r in zip(self.points, self.runs))
        jacobian = np.column_stack([(a - b) / 2e-3 for a, b in zip(beside[::2], beside[1::2])])
        new.known = {tuple(np.round(self.u, 12)): self.runs[0]}
        new.measure_noise(self.u)
        prior = new.prior_information(len(self.u))
        off, blocks = np.zeros(len(self.u)), new.comparison.blocks
        for _ in range(STEPS):
            raw = here + jacobian @ off
            model = estimate(blocks, raw, jacobian, new.sigma, prior)
            white = model.whitened(np.column_stack([raw, jacobian]))
            off = off - np.linalg.lstsq(white[:, 1:], white[:, 0], rcond=None)[0]
        raw = here + jacobian @ off
        model = estimate(blocks, raw, jacobian, new.sigma, prior)
        known = certainty(model, raw, jacobian, prior, None, CONFIDENCE)
        return off, known.reach * np.sqrt(np.diag(known.covariance)), model.groups["lines"]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scenes", nargs="*", metavar="SCENE", default=["fed tube"])
    parser.add_argument("--seeds", type=int, default=200)
    parser.add_argument("--first", type=int, default=1001)
    parser.add_argument("--errors", default="independent,smooth,shifted,tracker,strays")
    choice = parser.parse_args()
    print("| scene | errors | parameter | interval over scatter | holds the truth |\n" + "|---" * 5 + "|")
    with tempfile.TemporaryDirectory(prefix="tendril-") as place:
        for name in choice.scenes:
            linear = Linear(fit_trial.TRIALS[name], Path(place))
            for errors in choice.errors.split(","):
                found = [linear.attempt(seed, errors) for seed in range(choice.first, choice.first + choice.seeds)]
                off, half = np.array([f[0] for f in found]), np.array([f[1] for f in found])
                for k, p in enumerate(linear.problem.parameters):
                    scatter = np.sqrt(np.mean(off[:, k] ** 2))
                    print(f"| {name} | {errors} | {p.name} | {np.median(half[:, k]) / (1.96 * scatter):.2f} | "
                          f"{100 * np.mean(np.abs(off[:, k]) < half[:, k]):.1f} % of {len(found)} |", flush=True)
                g = [f[2] for f in found]
                for what in ("sigma", "smooth", "reach", "shift"):
                    print("   ", what, np.quantile([getattr(one, what) for one in g], [0.1, 0.5, 0.9]), flush=True)


if __name__ == "__main__":
    sys.exit(main())

#!/usr/bin/env python3
"""What tendril.fit says of points with one fault each: the table of docs/notes/fitting-measured.md. The points are those of
the fed tube of fit_trial.py, clean or with errors of 1 % of the width.

    PYTHONPATH=scripts .venv/bin/python scripts/lab/fit_faults.py [--noisy] [--seed 1] [--seeds 1] [FAULT ...]"""

import argparse
import sys
import tempfile
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent))
import fit_trial
import tendril


def turned(t, x, random):
    c, s = np.cos(np.radians(3)), np.sin(np.radians(3))
    return t, x @ np.array([[c, s], [-s, c]])


def another_time(t, x, random):
    """The fifth photograph shows what the third does."""
    at, x = np.unique(t), x.copy()
    x[t == at[4]] = x[t == at[2]]
    return t, x


def late(t, x, random):
    """The fifth photograph was taken one interval, 5 s, later than it says."""
    at, x = np.unique(t), x.copy()
    x[t == at[4]] = x[t == at[5]]
    return t, x


def hidden(part):
    """Of each photograph the points beyond a part of the rod's length, as the clock has it: something lies on the tip."""
    def change(t, x, random):
        seen = np.ones(len(t), bool)
        for one in np.unique(t):
            mine = np.flatnonzero(t == one)
            seen[mine] = fit_trial.PLACES[one] < part
        return t[seen], x[seen]
    return change


def times_exchanged(t, x, random):
    at, other = np.unique(t), t.copy()
    other[t == at[4]], other[t == at[5]] = at[5], at[4]
    return other, x


def camera_moved(t, x, random):
    return t, x + np.where(t >= np.unique(t)[4], 1, 0)[:, None] * [3e-3, 2e-3]


def cut_off(part):
    """The rod leaves the picture."""
    return lambda t, x, random: [column[x[:, 0] < part * x[:, 0].max()] for column in (t, x)]


def strays(share):
    def change(t, x, random):
        astray, x = random.random(len(t)) < share, x.copy()
        x[astray] = random.uniform(x.min(axis=0), x.max(axis=0), (astray.sum(), 2))
        return t, x
    return change


def alone(*which):
    """Some of the photographs."""
    return lambda t, x, random: [column[np.isin(t, np.unique(t)[list(which)])] for column in (t, x)]


# times in s and points in m, [n] and [n, 2]
FAULTS = {
    "none": lambda t, x, random: (t, x),
    "points at random": lambda t, x, random: (t, random.uniform(x.min(axis=0), x.max(axis=0), x.shape)),
    "columns exchanged": lambda t, x, random: (t, x[:, ::-1]),
    "clamp 2 mm off": lambda t, x, random: (t, x + [2e-3, 0]),
    "turned by 3 degrees": turned,
    "clock 20 % fast": lambda t, x, random: (1.2 * t, x),
    "clock 3 s early": lambda t, x, random: (t + 3, x),
    "mm labelled cm": lambda t, x, random: (t, 10 * x),
    "x2 downwards": lambda t, x, random: (t, x * [1, -1]),
    "scale 5 % too large": lambda t, x, random: (t, 1.05 * x),
    "scale 5 % too small": lambda t, x, random: (t, 0.95 * x),
    "a time without its unit": lambda t, x, random: (t, x),
    "a photograph of another time": another_time,
    "a photograph 5 s late": late,
    "the last tenth is hidden": hidden(0.9),
    "the last fifth is hidden": hidden(0.8),
    "two times exchanged": times_exchanged,
    "the camera was moved": camera_moved,
    "the outer 40 % is missing": cut_off(0.6),
    "the outer 15 % is missing": cut_off(0.85),
    "strays 10 %": strays(0.1),
    "strays 25 %": strays(0.25),
    "strays 40 %": strays(0.4),
    "one photograph": alone(7),
    "two photographs": alone(5, 7),
    "three photographs": alone(3, 5, 7),
    "an early photograph": alone(2),
}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("faults", nargs="*", metavar="FAULT", help=", ".join(FAULTS))
    parser.add_argument("--noisy", action="store_true")
    parser.add_argument("--seed", type=int, default=1, help="of the photographs")
    parser.add_argument("--seeds", type=int, default=1, help="how many, from that one on")
    choice = parser.parse_args()
    if not choice.noisy:
        fit_trial.NOISE = 1e-4
    trial = fit_trial.TRIALS["fed tube"]
    r = trial.run()
    for seed in range(choice.seed, choice.seed + choice.seeds):
        for name in choice.faults or FAULTS:
            tell(trial, r, seed, name)


def tell(trial, r, seed, name):
    """Fits the photographs of a seed with a fault, and prints what is said."""
    with tempfile.TemporaryDirectory(prefix="tendril-") as place:
        whole = np.loadtxt(fit_trial.measure(trial, r, seed, Path(place))[0], delimiter=",", skiprows=1)
        t, x = FAULTS[name](whole[:, 0], whole[:, 1:], np.random.default_rng(1))
        head = "t,x1 (m),x2 (m)" if "unit" in name else "t (s),x1 (m),x2 (m)"
        data = fit_trial.write(Path(place) / "faulty.csv", head, np.column_stack([t, x]))
        try:
            found = tendril.fit(trial.scene, data, trial.bounds)
            said = found.warnings or ["nothing"]
            numbers = ", ".join(f"{n} {v:.4g} ({low:.4g} to {high:.4g})" for (n, v), (low, high) in
                                zip(found.values.items(), found.intervals.values()))
            print(f"| {name} | {numbers}{'' if found.trusted else ', not to be trusted'} | {said[0]} |", flush=True)
            for more in said[1:]:
                print(f"|  |  | {more} |")
        except tendril.TendrilError as error:
            print(f"| {name} | refused | {error} |", flush=True)


if __name__ == "__main__":
    sys.exit(main())

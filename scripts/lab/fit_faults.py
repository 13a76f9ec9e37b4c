#!/usr/bin/env python3
"""What tendril.fit says of points with one fault each: the table of docs/fitting.md, section 4. The points are those of
the fed tube of fit_trial.py, clean or with errors of 1 % of the width.

    PYTHONPATH=scripts .venv/bin/python scripts/lab/fit_faults.py [--noisy] [FAULT ...]"""

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
}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("faults", nargs="*", metavar="FAULT", help=", ".join(FAULTS))
    parser.add_argument("--noisy", action="store_true")
    choice = parser.parse_args()
    if not choice.noisy:
        fit_trial.NOISE = 1e-4
    trial = fit_trial.TRIALS["fed tube"]
    r = trial.run()
    with tempfile.TemporaryDirectory(prefix="tendril-") as place:
        whole = np.loadtxt(fit_trial.measure(trial, r, 1, Path(place))[0], delimiter=",", skiprows=1)
        for name in choice.faults or FAULTS:
            t, x = FAULTS[name](whole[:, 0], whole[:, 1:], np.random.default_rng(1))
            head = "t,x1 (m),x2 (m)" if "unit" in name else "t (s),x1 (m),x2 (m)"
            data = fit_trial.write(Path(place) / "faulty.csv", head, np.column_stack([t, x]))
            try:
                found = tendril.fit(trial.scene, data, trial.bounds)
                said = found.warnings or ["nothing"]
                print(f"| {name} | {', '.join(f'{n} {v:.4g}' for n, v in found.values.items())} | {said[0]} |", flush=True)
                for more in said[1:]:
                    print(f"|  |  | {more} |")
            except tendril.TendrilError as error:
                print(f"| {name} | refused | {error} |", flush=True)


if __name__ == "__main__":
    sys.exit(main())

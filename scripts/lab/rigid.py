#!/usr/bin/env python3
"""Rigid contact by extrapolation: runs a scene with the contact stiffness k, 10 k, 100 k and tells
where tip, forces and energy go for k to infinity, with the error it finds.

    scripts/lab/rigid.py [--stiffness 1e5] [--build build/tendril] -- -options_file SCENE.opts ...

A number that errs by c k^-q has three values a, b, c at k, 10 k, 100 k with (b - a)/(c - b) = 10^q; the
limit is c + (c - b)/(10^q - 1). q is 3/4 for point contacts and 1 for contact along a line; what is found
outside of 0.3 to 2 is no such law, and then 3/4 is taken and the whole change counts as the error."""

import argparse
import os
import subprocess
import sys
import tempfile
from math import log10
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "scripts"))
from tendril import load  # noqa: E402

ENVIRONMENT = dict(os.environ, OMPI_ALLOW_RUN_AS_ROOT="1", OMPI_ALLOW_RUN_AS_ROOT_CONFIRM="1",
                   OMPI_MCA_ess_singleton_isolated="1", OMP_NUM_THREADS="1")
NAMES = ("tip_x1", "tip_x2", "energy", "feed_force", "contact_force", "wall_force_1",
         "wall_force_2", "penetration")


def limit(a, b, c):
    """(limit, error, order) of three values at k, 10 k, 100 k."""
    first, second = b - a, c - b
    if second == 0:
        return c, abs(first), float("nan")
    q = log10(first / second) if first / second > 0 else float("nan")
    if 0.3 < q < 2:
        # the error: what another order between 3/4 and 1 would change, or a tenth of the rest
        ends = [c + second / (10**p - 1) for p in (0.75, 1, q)]
        return ends[2], max(max(ends) - min(ends), abs(ends[2] - c) / 10), q
    return c + second / (10**0.75 - 1), max(abs(first), abs(second)), float("nan")


def run(binary, options, k, file):
    done = subprocess.run([binary, "-quiet", *options, "-contact_stiffness", repr(k), "-output",
                           str(file)], env=ENVIRONMENT, stdin=subprocess.DEVNULL,
                          capture_output=True, text=True, check=False)
    if done.returncode:
        sys.exit(f"rigid: at k = {k:g}: {done.stderr.strip()}")
    return load(file).series


def main():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--stiffness", type=float, default=1e5, metavar="K")
    parser.add_argument("--build", default=str(ROOT / "build/tendril"), metavar="TENDRIL")
    parser.add_argument("options", nargs="+")
    choice = parser.parse_args()
    with tempfile.TemporaryDirectory() as directory:
        runs = [run(choice.build, choice.options, choice.stiffness * f,
                    Path(directory) / f"{f}.h5") for f in (1, 10, 100)]
    print(f"{'':14}" + "".join(f"{f'k = {choice.stiffness * f:g}':>15}" for f in (1, 10, 100))
          + f"{'rigid':>15}{'error':>10}{'order':>7}")
    for name in NAMES:
        values = [s[name][-1] for s in runs]
        value, error, order = limit(*values)
        print(f"{name:14}" + "".join(f"{v:15.8g}" for v in values)
              + f"{value:15.8g}{error:10.1e}{order:7.2f}")


if __name__ == "__main__":
    main()

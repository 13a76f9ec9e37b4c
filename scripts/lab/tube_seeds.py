#!/usr/bin/env python3
"""Runs options/tube-contact.opts with many seeds of its natural curvature: do all end, does none cross
itself? Results that are there are passed over. What stands behind -- goes to every run.

    scripts/lab/tube_seeds.py [--seeds 200] [--jobs 1] [--build build/tendril] [-- OPTIONS ...]"""

import argparse
import os
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "scripts"))
from tendril import load  # noqa: E402

ENVIRONMENT = dict(os.environ, OMPI_ALLOW_RUN_AS_ROOT="1", OMPI_ALLOW_RUN_AS_ROOT_CONFIRM="1",
                   OMPI_MCA_ess_singleton_isolated="1", OMP_NUM_THREADS="1")


def run(seed, choice):
    """The seed's line: None if it did not end."""
    file = Path(choice.directory) / f"{seed}.h5"
    if not (file.is_file() and load(file).finished):
        done = subprocess.run(
            [str(Path(choice.build).resolve()), "-quiet", "-options_file", "options/tube-contact.opts",
             "-rod_curvature_seed", str(seed), *choice.options, "-output", str(file)],
            cwd=ROOT, env=ENVIRONMENT, stdin=subprocess.DEVNULL, capture_output=True, text=True,
            check=False)
        if done.returncode:
            print(f"seed {seed}: {done.stderr.strip()}", flush=True)
            return None
    r = load(file)
    s, d = r.series, float(r.attributes["parameters/contact_diameter"])
    return (len(s.t) - 1, s.self_crossings.max(), s.penetration.max() / d,
            abs(s.energy_defect[-1]), s.contact_force[-1], s.width[-1])


def main():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seeds", type=int, default=200)
    parser.add_argument("--jobs", type=int, default=1)
    parser.add_argument("--build", default=str(ROOT / "build/tendril"), metavar="TENDRIL")
    parser.add_argument("--directory", default=str(ROOT / "results/tube-seeds"))
    parser.add_argument("options", nargs="*")
    choice = parser.parse_args()
    Path(choice.directory).mkdir(parents=True, exist_ok=True)
    with ThreadPoolExecutor(choice.jobs) as pool:
        lines = list(pool.map(lambda seed: run(seed, choice), range(1, choice.seeds + 1)))
    ended = np.array([line for line in lines if line])
    print(f"{choice.seeds} seeds, {len(ended)} ended")
    if len(ended):
        print(f"{np.count_nonzero(ended[:, 1])} cross themselves")
        for k, name in enumerate(("steps", None, "penetration over diameter", "energy defect",
                                  "force in contact at the end", "width at the end")):
            if name:
                low, middle, high = np.quantile(ended[:, k], (0, 0.5, 1))
                print(f"{name}: {low:.3g} to {high:.3g}, median {middle:.3g}")
    return int(len(ended) < choice.seeds or ended[:, 1].any())


if __name__ == "__main__":
    sys.exit(main())

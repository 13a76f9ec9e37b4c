#!/usr/bin/env python3
"""A catheter with a bent tip is pushed into a vessel and turned into its branch. The vessel is a mesh that this script
makes, a main vessel and a branch that are blended, of which scripts/surface.sh makes a distance; without the turn the tip
passes the branch by.

    scripts/lab/vessel.py build/tendril DIRECTORY        needs VTK: pip install 'tendril[space]'
    scripts/plot.sh DIRECTORY/pushed.h5 DIRECTORY/turned.h5 --panels space --times 1,2,3,5 --view 25,20"""

import argparse
import subprocess
import sys
from pathlib import Path

import h5py
import numpy as np

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "scripts"))
from tendril import surface

D = 0.15  # of the catheter
FORK, BRANCH = np.array([3.0, 0, 0]), np.array([np.cos(0.7), 0, np.sin(0.7)])  # where it begins, and its direction
SCENE = """-growth_type feed -growth_initial_length 1.2 -shape_type file -rod_cells 120 -ts_max_time 5
    -friction_mu 0 -friction_layers 0:1e-2 -friction_radius 0.075 -ts_rtol 1e-5 -output_interval 0.1""".split()


def distance(x):
    """Below 0 within the vessel: two tubes, blended over 0.25, cut off at their ends."""
    main = np.hypot(x[1] - 0.15 * (1 - np.cos(0.6 * x[0])), x[2]) - 0.5
    s = np.maximum(np.tensordot(BRANCH, x - FORK[:, None, None, None], 1), 0)
    off = x - FORK[:, None, None, None] - s * BRANCH[:, None, None, None]
    branch = np.sqrt((off**2).sum(0)) - 0.36
    h = np.clip(0.5 + (branch - main) / 0.5, 0, 1)
    both = branch + (main - branch) * h - 0.25 * h * (1 - h)
    return np.max([both, -1.6 - x[0], x[0] - 7.6, x[2] - 3.1], axis=0)


def mesh(path, spacing=0.08):
    """The surface as triangles."""
    from meshes import surface_at, write_stl
    write_stl(surface_at(distance, ((-1.9, 7.9), (-0.8, 1.2), (-0.8, 3.4)), spacing), path)


def catheter(path, shape, length=1.2):
    """Bent by 2.2 per length over its last 0.9; and what makes it straight at the start, in the vessel."""
    def bend(d):
        z = np.clip((d - 0.7) / 0.4, 0, 1)
        return 2.2 * (1 - z**3 * (10 - 15 * z + 6 * z * z))
    d, s = np.linspace(0, 1.5, 61), np.linspace(0, 1, 121)
    with h5py.File(path, "w") as f:
        f["distance"], f["curvature"] = d, bend(d)
    with h5py.File(shape, "w") as f:
        f["s"], f["u3"], f["u2"] = s, -bend((1 - s) * length), 0 * s


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("tendril")
    parser.add_argument("directory", type=Path)
    choice = parser.parse_args()
    d = choice.directory
    d.mkdir(parents=True, exist_ok=True)
    mesh(d / "vessel.stl")
    made = surface(d / "vessel.stl", d / "vessel.h5", diameter=D, side="inside", flip=True, spacing=0.075,
                   box=[-1.2, -0.8, -0.8, 7.2, 1.2, 2.8])
    print(f"distance: error {made.error:.1e}, spacing {made.spacing}, {made.shape}")
    (d / "vessel.txt").write_text(f"{made.line} friction 0.1\n")
    catheter(d / "catheter.h5", d / "straight.h5")
    for name, spin in (("pushed", 0), ("turned", 0.65)):
        done = subprocess.run([choice.tendril, *SCENE, "-wall_file", d / "vessel.txt", "-contact_diameter", str(D),
                               "-rod_curvature_file", d / "catheter.h5", "-shape_file", d / "straight.h5", "-clamp_spin",
                               str(spin), "-output", d / f"{name}.h5"],
                              capture_output=True, text=True)
        print(name, *done.stdout.splitlines()[-3:], done.stderr, sep="\n", flush=True)


if __name__ == "__main__":
    sys.exit(main())

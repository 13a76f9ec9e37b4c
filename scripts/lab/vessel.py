#!/usr/bin/env python3
"""A catheter with a bent tip is pushed into a vessel and turned into its branch (options/vessel-branch.opts). The vessel is
a mesh that this script makes, a main vessel and a branch that are blended, of which scripts/surface.sh makes a distance;
without the turn the tip passes the branch by.

    scripts/lab/vessel.py build/tendril DIRECTORY [make] [run]        make needs VTK: pip install 'tendril[space]'
    scripts/plot.sh DIRECTORY/pushed.h5 DIRECTORY/turned.h5 --panels space --times 1,2,3,5 --view 25,20

make lays down options/data/branched.h5, hooked.h5 and hooked-straight.h5 anew."""

import subprocess
import sys
from pathlib import Path

import h5py
import numpy as np

from steps import steps_of

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "scripts"))
DATA = ROOT / "options" / "data"
D = 0.15  # of the catheter
FORK, BRANCH = np.array([3.0, 0, 0]), np.array([np.cos(0.7), 0, np.sin(0.7)])  # where it begins, and its direction
BOX = np.array([-1.2, -0.8, -0.8, 7.2, 1.2, 2.8])
RANGES = (-1.9, 7.9), (-0.8, 1.2), (-0.8, 3.4)  # with all of the vessel in them


def distance(x):
    """Below 0 within the vessel: two tubes, blended over 0.25, cut off at their ends."""
    main = np.hypot(x[1] - 0.15 * (1 - np.cos(0.6 * x[0])), x[2]) - 0.5
    s = np.maximum(np.tensordot(BRANCH, x - FORK[:, None, None, None], 1), 0)
    off = x - FORK[:, None, None, None] - s * BRANCH[:, None, None, None]
    branch = np.sqrt((off**2).sum(0)) - 0.36
    h = np.clip(0.5 + (branch - main) / 0.5, 0, 1)
    both = branch + (main - branch) * h - 0.25 * h * (1 - h)
    return np.max([both, -1.6 - x[0], x[0] - 7.6, x[2] - 3.1], axis=0)


def make(directory):
    """The vessel's distance, by way of a mesh. What is far from a wall is cut off there to keep the file small; with it are
    triangles to be drawn, as far as the grid reaches."""
    from meshes import surface_at, write_stl
    from tendril import surface
    from vtk.util.numpy_support import vtk_to_numpy
    write_stl(surface_at(distance, RANGES, 0.08), directory / "vessel.stl")
    made = surface(directory / "vessel.stl", directory / "vessel.h5", diameter=D, side="inside", flip=True, spacing=D / 2,
                   box=list(BOX))
    print(f"distance: error {made.error:.1e}, spacing {made.spacing}, {made.shape}")
    drawn = surface_at(distance, RANGES, 0.2)
    points = vtk_to_numpy(drawn.GetPoints().GetData())
    triangles = vtk_to_numpy(drawn.GetPolys().GetConnectivityArray()).reshape(-1, 3)
    triangles = triangles[(points[triangles] > BOX[:3]).all(axis=(1, 2)) & (points[triangles] < BOX[3:]).all(axis=(1, 2))]
    with h5py.File(directory / "vessel.h5") as f, h5py.File(DATA / "branched.h5", "w") as small:
        packed = {"compression": "gzip", "compression_opts": 9, "shuffle": True}
        small.create_dataset("distance", data=np.clip(np.round(f["distance"][:], 5), -0.5, 0.3).astype(np.float32), **packed)
        for name in ("origin", "spacing"):
            small[name] = f[name][:]
        small.create_dataset("mesh/points", data=np.round(points, 3).astype(np.float32), **packed)
        small.create_dataset("mesh/triangles", data=triangles.astype(np.int32), **packed)
        small.attrs["error"] = made.error
    catheter(DATA / "hooked.h5", DATA / "hooked-straight.h5")


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


def run(tendril, directory):
    for name, spin in (("pushed", 0), ("turned", 0.65)):
        done = subprocess.run([tendril, "-options_file", ROOT / "options" / "vessel-branch.opts", "-clamp_spin", str(spin),
                               "-output", directory / f"{name}.h5"], capture_output=True, text=True, check=False)
        print(name, *done.stdout.splitlines()[-4:], done.stderr, sep="\n", flush=True)


def main():
    choice = steps_of(__doc__, ["make", "run"])
    if "make" in choice.what:
        make(choice.directory)
    if "run" in choice.what:
        run(choice.tendril, choice.directory)


if __name__ == "__main__":
    sys.exit(main())

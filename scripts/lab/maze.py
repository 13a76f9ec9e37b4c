#!/usr/bin/env python3
"""The maze of pipes of options/vine-maze.opts: makes options/data/maze.h5, and the table of what that scene comes to.

    scripts/lab/maze.py build/tendril DIRECTORY [pipes] [table]       pipes needs VTK: pip install 'tendril[space]'"""

import subprocess
import sys
from pathlib import Path

import h5py
import numpy as np

from steps import steps_of

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "scripts"))
D, R, BLEND = 0.15, 0.35, 0.3  # of the vine; the pipes' radius; the corners are rounded over this
PIPES = (((-2, 0, 0), (3, 0, 0)), ((3, -2, 0), (3, 2, 0)), ((3, 2, 0), (3, 2, 3)))
RANGES = ((-2.6, 4.1), (-2.6, 3.1), (-1.1, 3.6))  # with all of the pipes in them
BOX = np.array([-0.6, -2.6, -0.6, 3.6, 2.6, 1.8])


def distance(x):
    """Below 0 within the pipes: round ones, blended where they meet."""
    def pipe(a, b):
        a, b = np.array(a, float), np.array(b, float)
        along = np.clip(np.tensordot(b - a, x - a[:, None, None, None], 1) / ((b - a) @ (b - a)), 0, 1)
        return np.sqrt(((x - a[:, None, None, None] - along * (b - a)[:, None, None, None])**2).sum(0)) - R
    both = pipe(*PIPES[0])
    for ends in PIPES[1:]:
        one = pipe(*ends)
        h = np.clip(0.5 + (one - both) / (2 * BLEND), 0, 1)
        both = one + (both - one) * h - BLEND * h * (1 - h)
    return both


def pipes(directory, data=ROOT / "options" / "data" / "maze.h5"):
    """The maze's distance, by way of a mesh. What is far from a wall is cut off there to keep the file small; with it are
    triangles to be drawn, as far as the grid reaches."""
    from meshes import surface_at, write_stl
    from tendril import surface
    from vtk.util.numpy_support import vtk_to_numpy
    write_stl(surface_at(distance, RANGES, 0.05), directory / "maze.stl")
    made = surface(directory / "maze.stl", directory / "maze.h5", diameter=D, side="inside", flip=True, spacing=D / 2,
                   box=BOX)
    print(f"distance: error {made.error:.1e}, spacing {made.spacing}, {made.shape}")
    drawn = surface_at(distance, RANGES, 0.12)
    points = vtk_to_numpy(drawn.GetPoints().GetData())
    triangles = vtk_to_numpy(drawn.GetPolys().GetConnectivityArray()).reshape(-1, 3)
    triangles = triangles[(points[triangles] > BOX[:3]).all(axis=(1, 2)) & (points[triangles] < BOX[3:]).all(axis=(1, 2))]
    with h5py.File(directory / "maze.h5") as f, h5py.File(data, "w") as small:
        packed = {"compression": "gzip", "compression_opts": 9, "shuffle": True}
        small.create_dataset("distance", data=np.clip(np.round(f["distance"][:], 6), -0.5, 0.5).astype(np.float32), **packed)
        for name in ("origin", "spacing"):
            small[name] = f[name][:]
        small.create_dataset("mesh/points", data=np.round(points, 3).astype(np.float32), **packed)
        small.create_dataset("mesh/triangles", data=triangles.astype(np.int32), **packed)
        small.attrs["error"] = made.error


RUNS = {"left": "", "right": "-rod_curvature -0.3", "400 cells": "-rod_cells 400", "-ts_rtol 1e-6": "-ts_rtol 1e-6",
        "-contact_stiffness 1.2e6": "-contact_stiffness 1.2e6"}


def table(tendril, directory):
    print("| run | tip at t = 4 | tip at the end | most push | steps | energy defect |")
    for name, more in RUNS.items():
        file = directory / f"{name.replace(' ', '-')}.h5"
        subprocess.run([tendril, "-quiet", "-options_file", ROOT / "options" / "vine-maze.opts", *more.split(),
                        "-output", file], check=True)
        with h5py.File(file) as f:
            s = {k: v[:] for k, v in f["series"].items()}
        tips = (", ".join(f"{np.interp(t, s['t'], s[f'tip_x{d}']):.4f}" for d in (1, 2, 3)) for t in (4, s["t"][-1]))
        print(f"| {name} | {' | '.join(tips)} | {s['feed_force'].max():.2f} | {len(s['t']) - 1} "
              f"| {s['energy_defect'][-1]:.1e} |", flush=True)


def main():
    choice = steps_of(__doc__, ["pipes", "table"])
    if "pipes" in choice.what:
        pipes(choice.directory)
    if "table" in choice.what:
        table(choice.tendril, choice.directory)


if __name__ == "__main__":
    sys.exit(main())

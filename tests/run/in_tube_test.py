#!/usr/bin/env python3
"""Rods within round tubes, against exact answers.

    in_tube_test.py build/tendril [--mpiexec mpiexec] CHECK...      (no CHECK: all of them)"""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent))
import scene_test as scene  # takes .venv's python if this one lacks numpy and h5py
from contact_test import walls
from scene_test import Run, expect

import h5py
import numpy as np

CHECKS = {}


def check(function):
    CHECKS[function.__name__.replace("_", "-")] = function
    return function


def helix(cells, more="", r=0.5, k=1.0, begun=0.9, length=24, D=0.05):
    """A weightless rod in a smooth tube, pushed by P = 2 k^2 cos(alpha) at its tip, sin(alpha) = r k: in its middle,
    some lengths 1/k from either end, it is the helix that turns by k per length. It starts as one that turns by
    `begun`, clamped at that one's angle. Returns the run, and relative errors."""
    angle, P = np.arcsin(r * begun), 2 * k**2 * np.sqrt(1 - (r * k)**2)
    s = np.linspace(0, 1, 2001)
    bend, turn = np.sin(angle)**2 / r, np.sin(angle) * np.cos(angle) / r * length
    file = Path(scene.SCRATCH) / "helix.h5"
    with h5py.File(file, "w") as f:
        f["s"], f["u1"], f["u2"], f["u3"] = s, 0 * s, bend * np.cos(turn * s), -bend * np.sin(turn * s)
    run = Run(f"-growth_type none -growth_initial_length {length} -friction_mu 0 -rod_cells {cells} "
              f"-shape_type file -shape_file {file} -contact_diameter {D} -ts_max_time 1e5 -output_shapes 1 "
              f"-clamp_direction {np.cos(angle):.17g},{np.sin(angle):.17g},0 -tip_force_vector {-P:.17g},0,0 "
              + walls(f"cylinder 0 0 {-r} 1 0 0 {r + D / 2} inside") + more)
    x, d, n, push = (run.shapes[name][-1] for name in ("x", "d1", "force", "contact"))
    j, w, h = cells // 2, 4, length / cells
    R, cosine = np.hypot(x[j, 1], x[j, 2] + r), d[j, 0]
    turns = np.hypot(*d[j, 1:]) / R
    # what the wall takes of the force between two nodes: N, whose direction turns
    N = np.hypot(*(n[j + w] - n[j - w])[1:]) * turns / (2 * np.sin(turns * w * h))
    return run, {"k": turns / k - 1, "P of its k": P / (2 * turns**2 * cosine) - 1, "N of its k": N / (R * turns**4) - 1,
                 "N": N / (r * k**4) - 1, "N at a node": np.hypot(*push[j, 1:]) / (r * k**4) - 1, "radius": R / r - 1}


@check
def helix_in_tube():
    """P = 2 B k^2 cos(alpha), N = B r k^4, exact at any slope; here 30 degrees."""
    run, off = helix(240)
    print(f"{run.steps} steps, " + ", ".join(f"{name} {e:.1e}" for name, e in off.items()))
    for name, bound in {"k": 1e-4, "P of its k": 1e-5, "N of its k": 1e-5, "N": 3e-4, "N at a node": 2e-3,
                        "radius": 2e-4}.items():
        expect(abs(off[name]) < bound, f"{name} is off by {off[name]:.1e}")


if __name__ == "__main__":
    sys.exit(scene.main(CHECKS))

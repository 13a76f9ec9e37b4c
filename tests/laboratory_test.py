#!/usr/bin/env python3
"""The rod in the laboratory: natural curvature, events, restart, physical units, files for ParaView.

    laboratory_test.py build/tendril [--mpiexec mpiexec] CHECK...      (no CHECK: all of them)"""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent))
import scene_test as scene  # takes .venv's python if this one lacks numpy and h5py
from scene_test import DRY, Run, distance, expect

import numpy as np

CHECKS = {}


def check(function):
    CHECKS[function.__name__.replace("_", "-")] = function
    return function


CURVED = "-rod_curvature 0.02 -rod_curvature_random 0.1 -shape_type straight "


@check
def natural_curvature():
    """Energy is balanced, two models agree, and mirrored curvature gives the mirrored rod."""
    for law, length, end in (("uniform", 0.5, 20), ("gaussian", 0.5, 10), ("feed", 1, 8)):
        options = (f"-growth_type {law} -growth_initial_length {length} -ts_max_time {end} " + CURVED)
        a = Run(options)
        b = Run(options + "-rod_model mixed -rod_cells 2000")
        defect = a.energy_defect[a.t > 0.01].max()
        print(f"{law}: defect {defect:.1e}, frame and mixed differ by {distance(b.tip, a.tip):.1e}, "
              f"tip {a.tip}")
        expect(defect < 1e-5, f"{law}: energy defect {defect:.1e}")
        expect(distance(b.tip, a.tip) < 1e-4, f"{law}: models differ by {distance(b.tip, a.tip):.1e}")
        expect(a.max_angle[-1] > 1, f"{law}: does not bend")
    up, down = (Run(f"-ts_max_time 5 -shape_type straight -rod_curvature {k}") for k in (0.1, -0.1))
    expect(np.allclose(up.tip_x2, -down.tip_x2, rtol=1e-12, atol=0), "not mirrored")
    one, three = (Run(f"-ts_max_time 5 {CURVED}", ranks=n) for n in (1, 3))
    expect(distance(three.tip, one.tip) < 1e-7, "3 ranks differ")
    # a rod that nothing pushes keeps its natural curvature: at t = 0 it stores no energy
    expect(up.energy[0] < 1e-12, f"energy {up.energy[0]} at t = 0")
    expect(np.allclose(up.shapes["curvature"][0], 0.1, rtol=1e-9), "curvature at t = 0")


if __name__ == "__main__":
    sys.exit(scene.main(CHECKS))

#!/usr/bin/env python3
# test: one surface given in several ways is the same
"""Rods in tubes and on bodies: one surface given in several ways is the same surface.

    tubes_test.py build/tendril"""

import subprocess
import sys
import tempfile
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "support"))
from interpreter import from_venv

try:
    import h5py
    import numpy as np

    import made_meshes
    from tendril import surface
except ImportError as error:
    from_venv(error)

CENTRE, RADIUS, DIAMETER, SPACING = np.array([1.3, 0.25, 0.1]), 0.6, 0.1, 0.05
SCENE = """-growth_type feed -growth_initial_length 0.5 -ts_max_time 1.2 -rod_curvature 0.05 -rod_curvature_2 0.03
    -rod_cells 100 -output_shapes 4""".split()


def write_distance(path):
    axes = [c - RADIUS - 0.4 + np.arange(0, 2 * RADIUS + 0.8, SPACING) for c in CENTRE]
    x = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1)
    with h5py.File(path, "w") as f:
        f["distance"] = (np.linalg.norm(x - CENTRE, axis=-1) - RADIUS).transpose(2, 1, 0)
        f["origin"], f["spacing"] = [a[0] for a in axes], [SPACING] * 3


def run(tendril, wall, d):
    (d / "wall").write_text(f"{wall} friction 0.3\n")
    done = subprocess.run([tendril, *SCENE, "-wall_file", d / "wall", "-contact_diameter", str(DIAMETER), "-output",
                           d / "out.h5"], capture_output=True, text=True)
    if done.returncode:
        sys.exit(f"{wall}: {done.stderr}")
    with h5py.File(d / "out.h5") as f:
        result = f["shapes/x"][:], len(f["series/t"]), np.linalg.norm(f["shapes/contact"][-1], axis=1).max()
    (d / "out.h5").unlink()
    return result


def main():
    """A rod that is fed against a ball and glides round it with friction: the ball exactly, as a distance,
    and as the distance from a mesh of twenty thousand triangles, whose facets are 3e-4 off."""
    tendril = sys.argv[1]
    failed = False
    with tempfile.TemporaryDirectory(prefix="tendril-") as scratch:
        d = Path(scratch)
        ways = {"distance": "body distance.h5 outside"}
        write_distance(d / "distance.h5")
        if made_meshes.VTK:
            made_meshes.write_obj(d / "ball.obj", made_meshes.sphere(71, CENTRE, RADIUS))
            surface(d / "ball.obj", d / "mesh.h5", diameter=DIAMETER, spacing=SPACING)
            ways["mesh"] = "body mesh.h5 outside"
        x, steps, pressed = run(tendril, "sphere {:.17g} {:.17g} {:.17g} {} outside".format(*CENTRE, RADIUS), d)
        off_axis = np.hypot(x[-1, -1, 1], x[-1, -1, 2])
        if not (pressed > 0.5 and off_axis > 0.3):
            sys.exit(f"the ball is not met: {pressed}, {off_axis}")
        for name, wall in ways.items():
            other, more, _ = run(tendril, wall, d)
            off = np.abs(other - x).max()
            print(f"{name}: {off:.1e} from the exact ball, {more} steps against {steps}")
            failed |= off > 1e-5 or not steps / 1.5 < more < 1.5 * steps
    return failed


if __name__ == "__main__":
    sys.exit(main())

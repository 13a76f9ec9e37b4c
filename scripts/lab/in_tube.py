#!/usr/bin/env python3
"""Rods in round tubes against exact answers (tests/run/in_tube_test.py), as tables for docs/tubes.md.

    scripts/lab/in_tube.py build/tendril [helix]"""

import argparse
import sys
import tempfile
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tests" / "run"))
import in_tube_test as tube
import scene_test as scene


def row(*cells):
    print("| " + " | ".join(str(c) for c in cells) + " |", flush=True)


def helix():
    """Over cells and k; and with k extrapolated. A wall that is pressed by N per length gives way by
    w (1 - 2 (N/kw)^(1/2)), w ~ k^(-3/4) (world/contact.h): so errors go as l^3 and l^(7/2), l = k^(-1/4)."""
    names = "k", "P of its k", "N of its k", "N", "N at a node", "radius"
    row("cells", "contact's k", *names, "steps")
    for cells in (240, 480):
        layers, errors = [], []
        for k in (None, 2e3, 1.6e4, 1.28e5):
            run, off = tube.helix(cells, "-ts_rtol 1e-7 " + (f"-contact_stiffness {k}" if k else ""))
            row(cells, f"{k:g}" if k else "default", *(f"{off[n]:.1e}" for n in names), run.steps)
            if k:
                layers.append(k**-0.25)
                errors.append([off[n] for n in names])
        powers = np.array(layers)[:, None] ** [0, 3, 3.5]
        row(cells, "extrapolated", *(f"{e:.1e}" for e in np.linalg.solve(powers, errors)[0]), "")


def main():
    tables = {"helix": helix}
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("tendril")
    parser.add_argument("table", nargs="*", choices=[[], *tables], default=list(tables))
    choice = parser.parse_args()
    scene.TENDRIL = str(Path(choice.tendril).resolve())
    with tempfile.TemporaryDirectory() as scene.SCRATCH:
        for name in choice.table:
            tables[name]()


if __name__ == "__main__":
    sys.exit(main())

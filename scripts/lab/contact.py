#!/usr/bin/env python3
"""Measured errors of contact against the exact answers A (the tip on a plane) and B (inside a
circle) of tests/scenes/contact/contact_test.py: over the stiffness k of contact, and over the number of cells.

    contact.py build/tendril [--store docs/notes/contact.csv]"""

import argparse
import csv
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent.parent
sys.path[:0] = [str(ROOT / "tests/scenes/contact"), str(ROOT / "tests/support")]
import contact_test as contact
import scene

CELLS, R = (125, 250, 500, 1000), 0.001


def measured(answer, cells, k):
    more = f"-rod_cells {cells}" + (f" -contact_stiffness {k:g}" if k else "")
    if answer == "A":
        off, run = contact.plane_errors(more)
        return run, dict(zip(("force", "height", "wall force"), off))
    run = contact.in_circle(R, more)
    return run, contact.circle_errors(run, R)


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("tendril")
    parser.add_argument("--store", default=ROOT / "docs" / "notes" / "contact.csv")
    choice = parser.parse_args()
    scene.TENDRIL = str(Path(choice.tendril).resolve())
    with open(choice.store, "w", newline="") as file, tempfile.TemporaryDirectory() as scene.SCRATCH:
        table = csv.writer(file, lineterminator="\n")
        table.writerow(["answer", "cells", "k", "quantity", "relative error", "steps", "Newton"])
        for answer, stiff in (("A", (1e12, 1e13, 1e14, 1e15)), ("B", (1e16, 1e17, 1e18, 1e19))):
            for cells, k in ([(500, k) for k in stiff] + [(n, stiff[2]) for n in CELLS if n != 500]
                             + [(n, 0) for n in CELLS]):
                run, off = measured(answer, cells, k)
                for name, e in off.items():
                    table.writerow([answer, cells, f"{k:g}" if k else "default", name, f"{abs(e):.2e}",
                                    run.steps, int(run.newton_iterations.sum())])
                print(answer, cells, k or "default", {n: f"{e:.1e}" for n, e in off.items()}, flush=True)


if __name__ == "__main__":
    sys.exit(main())

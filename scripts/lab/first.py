#!/usr/bin/env python3
"""Makes what the first three pages of the guide show, docs/my-*.md: their pictures, and the synthetic
photographs of the root, docs/first/root.csv.

    PYTHONPATH=scripts .venv/bin/python scripts/lab/first.py"""

import numpy as np

import tendril
from tendril.comparing import finer, shape_at
from tendril.runs import CHECKOUT

PLACE = CHECKOUT / "docs/first"
TRUTH = dict(si_friction_dry="0.4N/m", rod_curvature="5/m")
LENGTHS, POINTS, NOISE = (0.03, 0.04, 0.05, 0.06), 25, 3e-4  # m; of a photograph; m


def photographs():
    random = np.random.default_rng(7)
    r = tendril.run(PLACE / "root.opts", **TRUTH, accuracy=1e-6, stop_length="6cm", output_shapes=200)
    unit = r.scale("length")
    rows = ["# synthetic: a run of tendril with noise, made by scripts/lab/first.py", "length (cm),x1 (cm),x2 (cm)"]
    for length in LENGTHS:
        line = finer(shape_at(r, np.interp(length / unit, r.series.length, r.series.t))) * unit
        points = line[random.choice(len(line), POINTS, replace=False)]
        points += NOISE * random.normal(size=points.shape)
        rows += [f"{100 * length:g},{100 * x:.2f},{100 * y:.2f}" for x, y in points]
    (PLACE / "root.csv").write_text("\n".join(rows) + "\n")


def main():
    photographs()
    tube = tendril.run(PLACE / "tube.opts")
    tendril.plot(tube, "shapes,force", si=True, times=["20s", "40s", "58s"]).savefig(PLACE / "tube.png", dpi=130)
    cable = tendril.run(PLACE / "cable.opts")
    tendril.plot(cable, "touch,feed_force", si=True).savefig(PLACE / "cable.png", dpi=130)


if __name__ == "__main__":
    main()

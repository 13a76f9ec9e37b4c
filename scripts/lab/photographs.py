#!/usr/bin/env python3
"""Makes the synthetic photographs of docs/fitting.md, docs/fitting/photographs.csv: the tube of
docs/fitting/tube.opts with a friction and a natural curvature that the example has to find, noise of a
millimetre, points in no order and some of them nowhere near.

    PYTHONPATH=scripts .venv/bin/python scripts/lab/photographs.py"""

import numpy as np

import tendril
from tendril.comparing import finer, shape_at
from tendril.runs import CHECKOUT

PLACE = CHECKOUT / "docs/fitting"
FRICTION = 17.3  # N/m
MODES = (1.9, -2.6, 1.4)  # 1/m, cosines over the distance from the tip
LENGTHS = (0.12, 0.16, 0.2, 0.24, 0.28)  # m
POINTS, STRAY, NOISE = 30, 2, 1e-3  # of a photograph; of these anywhere; m


def main():
    random = np.random.default_rng(2026)
    unit = (4.4907e-4 / FRICTION) ** (1 / 3)  # of length, (YI/N)^(1/3)
    s = np.linspace(0, 1, 201)
    bend = sum(a * np.cos(k * np.pi * s) for k, a in enumerate(MODES))
    r = tendril.run(PLACE / "tube.opts", si_friction_dry=f"{FRICTION}N/m", accuracy=1e-6,
                    rod_curvature_file={"distance": s * LENGTHS[-1] / unit, "curvature": bend * unit},
                    stop_length=f"{LENGTHS[-1]}m", output_interval=0.05)
    rows = ["# synthetic: a run of tendril with noise, made by scripts/lab/photographs.py",
            "length (cm),x1 (cm),x2 (cm)"]
    for length in LENGTHS:
        t = np.interp(length / unit, r.series.length, r.series.t)
        line = finer(shape_at(r, t)) * unit
        points = line[random.choice(len(line), POINTS, replace=False)]
        points += NOISE * random.normal(size=points.shape)
        points[:STRAY] = random.uniform([0, -0.05], [0.25, 0.05], (STRAY, 2))
        rows += [f"{100 * length:g},{100 * x:.2f},{100 * y:.2f}" for x, y in points]
    (PLACE / "photographs.csv").write_text("\n".join(rows) + "\n")


if __name__ == "__main__":
    main()

#!/usr/bin/env python3
"""The table and the picture of docs/my-plant.md: the mean tip angle of 115 roots fitted up to 16 h, and the base of the growth zone predicted, with the
zone as a bell and even, with and without the bend that the roots had at first, and without proprioception.

    PYTHONPATH=scripts .venv/bin/python scripts/lab/plant.py"""

import sys
from pathlib import Path
from unittest import mock

import matplotlib
import matplotlib.pyplot as plt
import numpy as np

import tendril
from tendril import fitting, measured
from tendril.parameters import Parameter
from tendril.problem import Problem
from tendril.style import STYLE

FIRST = Path(__file__).resolve().parents[2] / "docs/first"
LOOKED_FOR = {"tropism_gravity": ("0.1/mm", "50/mm", "5/mm"), "tropism_proprioception": (0.2, 50, 5), "tropism_memory": ("0.1h", "10h", "1.1h")}
ZONE, TIP, BASE = 0.597, 5.156, 1.354  # mm; degrees at t = 0


def first_bend():
    """What the zone was bent by at t = 0, as the bell: the base begins where it was, and the rest is natural curvature."""
    z = np.linspace(0, 1, 101)
    return {"clamp_angle": f"{BASE}deg", "rod_curvature_file": {"distance": z * ZONE,
                                                                "curvature": np.radians(TIP - BASE) * 30 * z**2 * (1 - z) ** 2 / ZONE}}


def fitted(tip, base, options, names):
    """(values, root of the mean square of the tip's residuals and of the base's, in degrees)"""
    looked = [Parameter.of(name, LOOKED_FOR[name]) for name in names]
    p = Problem(FIRST / "plant.opts", tip, looked, options)
    u = np.array([q.inside(q.start) for q in looked])
    p.prepare(u, 1e-3)
    p.measure_noise(u)
    best = p.solve(u, 1e-3)
    (r,) = p.run([best.u])
    rms = [np.degrees(np.sqrt(np.mean(off**2))) for off in (p.raw(best.u, r), base.values.numbers - p.comparison.angle(r, base))]
    return [float(q.value(x)) for q, x in zip(looked, best.u)], rms


def picture():
    """The tip as it is fitted, and the base, which counts for nothing: it is told to err by 1000 degrees."""
    with mock.patch.object(fitting, "followed_out", lambda *_: {}), mock.patch.object(fitting, "warnings_of", lambda *_: []):
        f = tendril.fit(FIRST / "plant.opts", [FIRST / "plant.csv", FIRST / "plant-base.csv"], LOOKED_FOR, starts=0, progress=False,
                        noise={"tip_angle": "1.3deg", "base_angle": "1000deg"})
    with plt.rc_context(STYLE):
        f.plot().savefig(FIRST / "plant.png")


def main():
    matplotlib.use("Agg")
    tip = measured.read(FIRST / "plant.csv")
    (base,) = measured.read(FIRST / "plant-base.csv").curves
    three = list(LOOKED_FOR)
    print("| | b (1/mm) | G | T (h) | tip | base |\n" + "|---" * 6 + "|")
    for words, options, names in (("even zone", {}, three), ("bell", {"growth_profile": "bell"}, three),
                                  ("bell, and the first bend", {"growth_profile": "bell"} | first_bend(), three),
                                  ("even, no proprioception", {"tropism_proprioception": 0}, ["tropism_gravity", "tropism_memory"])):
        values, (of_tip, of_base) = fitted(tip, base, options, names)
        cells = dict(zip(names, values))
        print(f"| {words} | " + " | ".join(f"{cells[n]:.3g}" if n in cells else "0" for n in three) + f" | {of_tip:.2f}° | {of_base:.1f}° |", flush=True)
    picture()


if __name__ == "__main__":
    sys.exit(main())

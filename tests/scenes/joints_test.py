#!/usr/bin/env python3
"""Rods that hold each other: frames and trees whose answers are known otherwise, what a joint does not change, and what is refused.

    joints_test.py build/tendril CHECK...      (no CHECK: all of them)"""

import shlex
import subprocess
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "support"))
import scene  # takes .venv's python if this one lacks numpy and h5py
from scene import check, expect

import h5py
import numpy as np

# at rest at the end
STATIC = {"growth_type": "none", "growth_initial_length": 1, "friction_mu": 0, "friction_layers": "0:1e-2", "shape_type": "straight",
          "rod_cells": 16, "ts_max_time": 60, "output_shapes": 1}


class Several:
    """What a run of several rods says: {rod: places at the end}, {rod: series}, sums."""

    def __init__(self, rods, options="", name="joints", **shared):
        self.path, self.out = (Path(scene.SCRATCH) / f"{name}.{end}" for end in ("opts", "h5"))
        text = "".join(f"-{key} {value}\n" for key, value in (STATIC | shared).items())
        for rod, own in rods.items():
            text += f"[rod {rod}]\n" + "".join(f"-{key} {value}\n" for key, value in own.items())
        self.path.write_text(text)
        self.run("-options_file", self.path, "-output", self.out, *shlex.split(options))

    def run(self, *words):
        done = subprocess.run([scene.TENDRIL, *map(str, words), "-quiet"], capture_output=True, text=True, env=scene.ENVIRONMENT)
        expect(done.returncode == 0 and not done.stderr, done.stderr)
        self.read()

    def read(self):
        with h5py.File(self.out) as f:
            first, count = f["rods/first"][:], f["rods/count"][:]
            self.x = {name.decode(): f["shapes/x"][:, a:a + n] for name, a, n in zip(f["rods/name"][:], first, count)}
            self.series = {name.decode(): {key: column[:, k] for key, column in f["rods/series"].items()}
                           for k, name in enumerate(f["rods/name"][:])}
            self.sums = {key: column[:] for key, column in f["series"].items()}

    def tip(self, rod):
        return self.x[rod][-1, -1]


def refusal(text, *words):
    path = Path(scene.SCRATCH) / "refused.opts"
    path.write_text(text)
    done = subprocess.run([scene.TENDRIL, "-options_file", str(path), "-ts_max_time", "0.01", *words], capture_output=True, text=True,
                          env=scene.ENVIRONMENT)
    return done.returncode, done.stderr.strip()


Y = {"stem": {"clamp_direction": "0,1"},
     "left": {"clamp_on": "stem", "clamp_angle": "45deg", "tip_force_vector": "0,-0.5,0"},
     "right": {"clamp_on": "stem", "clamp_angle": "45deg", "clamp_azimuth": "180deg", "tip_force_vector": "0,-0.25,0"}}


@check
def a_y_is_where_shooting_has_it():
    """And energy is balanced, of each rod and of all."""
    for cells, bound in ((16, 1e-6), (32, 1e-7)):
        run = Several(Y, rod_cells=cells, ts_max_time=200)
        for rod, place in (("stem", (-0.3097154300, 0.9346753812)), ("left", (-1.3067740390, 0.9532699313)),
                           ("right", (-0.1089842811, 1.9142918031))):
            off = np.abs(run.tip(rod) - (*place, 0)).max()
            defect = run.series[rod]["energy_defect"][-1]
            print(f"{cells} cells, {rod}: off by {off:.1e}, energy {defect:.1e}")
            expect(off < bound, f"{rod}: {off}")
            expect(defect < 2e-5, f"{rod}: energy {defect}")


@check
def a_rod_that_is_cut_and_welded_is_the_rod():
    """At fixed steps, on the same mesh, bent and twisted out of its plane."""
    fixed = "-ts_adapt_type none -ts_dt 0.02 -ts_rtol 1e-11"
    load = {"rod_weight": "0,0.3,-1", "rod_curvature": 0.5, "rod_torsion": 0.6}
    shared = {"ts_max_time": 0.4, "output_shapes": 4, "friction_layers": "0:1"}
    whole = Several({"all": {"growth_initial_length": 2, "rod_cells": 24, "tip_force_vector": "0.2,0,0.3", **load}}, fixed, **shared)
    parts = Several({"base": {"rod_cells": 12, **load},
                     "end": {"clamp_on": "base", "rod_cells": 12, "tip_force_vector": "0.2,0,0.3", **load}}, fixed, "parts", **shared)
    x = np.concatenate([parts.x["base"][:, :-1], parts.x["end"][:, 1:]], axis=1)
    off = np.abs(x - whole.x["all"])[1:].max()  # (at t = 0 the shape itself is, to 1e-9)
    print(f"off by {off:.1e}")
    expect(off < 1e-12, off)


REFUSED = [  # (lines of a scene, what is said)
    ("[rod a]\n[rod b]\n-clamp_on c\n", "line 3, rod b: -clamp_on c: there is no rod of that name; there are a, b"),
    ("[rod a]\n-clamp_on a\n", "line 2, rod a: -clamp_on a: a rod cannot hold itself"),
    ("[rod a]\n-clamp_on b\n[rod b]\n-clamp_on a\n", "line 2, rod a: -clamp_on b: that rod is carried by a itself, in the end"),
    ("[rod a]\n[rod b]\n-clamp_on a\n-clamp_at 0.6\n", "line 4, rod b: -clamp_at 0.6: rod a is 0.5 long as it begins"),
    ("[rod a]\n[rod b]\n-clamp_on a\n-clamp_at -1\n", "line 4, rod b: -clamp_at -1: rod a is 0.5 long as it begins"),
    ("[rod a]\n[rod b]\n-clamp_on a\n-clamp_at top\n", "line 4, rod b: -clamp_at top"),
    ("[rod a]\n[rod b]\n-clamp_at 0.2\n", "line 3, rod b: -clamp_at: says where on a rod, and -clamp_on says on which"),
    ("[rod a]\n[rod b]\n-clamp_on a\n-clamp_place 0,1,0\n", "line 4, rod b: -clamp_place: not with -clamp_on"),
    ("[rod a]\n[rod b]\n-clamp_azimuth 1\n", "line 3, rod b: -clamp_azimuth: is about the rod that carries this one"),
    ("[rod a]\n-growth_type feed\n[rod b]\n-clamp_on a\n-clamp_at 0.2\n", "line 4, rod b: -clamp_on a: the material of rod a moves along it there"),
    ("[rod a]\n[rod b]\n-clamp_place 0,1,0\n-tip_on a\n", "line 4, rod b: -tip_on a: as the rods begin the tip is at"),
    ("[rod a]\n[rod b]\n-tip_on a\n-tip_force 1\n", "line 4, rod b: -tip_force: not of a tip that another rod holds"),
    ("[rod a]\n[rod b]\n-clamp_on a\n-clamp_type ball\n", "line 4, rod b: -clamp_type ball: nothing keeps the rod from spinning"),
    ("[rod a]\n-clamp_type ball\n", "line 2, rod a: -clamp_type ball: is a joint between rods"),
]


@check
def what_is_wrong_is_told_with_rod_and_line():
    for text, said in REFUSED:
        code, found = refusal(text)
        expect(code != 0 and said in found and "\n" not in found and found.startswith("tendril: "), f"{text!r}: exit {code}, {found!r} and not {said!r}")


if __name__ == "__main__":
    sys.exit(scene.main())

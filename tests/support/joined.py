"""Runs of several rods that hold each other, for the tests of them."""

import shlex
import subprocess
from pathlib import Path

import scene
from scene import expect

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

    def expect_told(self, rod, off):
        """What is told of a tip that is so far off is more, and not a hundred times."""
        told = self.series[rod]["error_tip"][-1] * np.linalg.norm(self.tip(rod) - self.x[rod][0, 0])
        print(f"  told {told:.1e}, {told / off:.1f} times what it is off by")
        expect(off < told < 100 * off, f"{rod}: off by {off}, told {told}")


def refusal(text, *words):
    path = Path(scene.SCRATCH) / "refused.opts"
    path.write_text(text)
    done = subprocess.run([scene.TENDRIL, "-options_file", str(path), "-ts_max_time", "0.01", *words], capture_output=True, text=True,
                          env=scene.ENVIRONMENT)
    return done.returncode, done.stderr.strip()

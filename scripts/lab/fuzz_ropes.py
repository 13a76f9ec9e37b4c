#!/usr/bin/env python3
"""Random ropes in space that touch themselves: coils, ropes that are let down, spun until they writhe, fed and wound,
loops that wind up, knots.

    scripts/lab/fuzz_ropes.py build/tendril SEED FIRST COUNT [--kinds coil,...] [--estimate] [--ranks] [--restart]

Each is run once, for LIMIT seconds of a processor. One is lost if it gives up, passes through itself (its writhe
jumps by 2 from one stored shape to the next), or is off its balance of energy by more than 1e-2. --estimate: the error that is told beside the true one, by 1.6 times the cells and a tenth of the
tolerance with the same stiffness. --ranks: 2 and 3 ranks beside one. --restart: broken in the midst of contact it must go
on to the last bit."""

import argparse
import random
import re
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent.parent
sys.path[:0] = [str(ROOT / "scripts" / "lab"), str(ROOT / "scripts")]
import coverage
import h5py
import numpy as np
from fuzz_walls import ENVIRONMENT, curve

from tendril.scene_data import overhand, twisted_loop

LIMIT, REFERENCE_LIMIT = 20, 60
FINER = 1.6


class Draw:
    """Random numbers of a scene, and room for its files."""

    def __init__(self, seed, directory):
        self.R, self.directory, self.number = random.Random(seed), Path(directory), 0

    def between(self, a, b):
        return float(f"{self.R.uniform(a, b):.4g}")

    def over(self, a, b):
        return float(f"{np.exp(self.R.uniform(np.log(a), np.log(b))):.3g}")

    def choice(self, *values):
        return self.R.choice(values)

    def file(self, end):
        self.number += 1
        return self.directory / f"{self.number}{end}"

    def rubbing(self):
        return {"contact_friction": self.choice(0, 0, 0.1, 0.3, 0.6), "friction_beta": self.choice(0, 1e-3, 1e-3, 1e-2)}

    def uneven(self):
        """Out of the plane, too."""
        return {"shape_type": "random", "shape_amplitude": self.over(1e-3, 0.1), "shape_seed": self.R.randint(1, 1000),
                "rod_curvature_random": self.over(1e-3, 0.1), "rod_curvature_random_2": self.over(1e-2, 0.1)}


def coil(draw):
    """Grows into turns that are wound on each other: its natural shape is a helix of less pitch than its diameter."""
    D, bend = draw.between(0.1, 0.16), draw.between(2.5, 4)
    twist = draw.between(-0.3, 0.3) * D * bend**2 / (2 * np.pi)
    return {"growth_type": draw.choice("feed", "uniform"), "growth_initial_length": f"{1.6 * np.pi / bend:.4g}",
            "rod_curvature": bend, "rod_twist": f"{twist:.4g}", **draw.uneven(), "friction_mu": draw.choice(0.05, 0.3),
            "rod_cells": draw.choice(40, 50), "contact_diameter": D, "ts_max_time": draw.between(1.2, 1.8), **draw.rubbing()}


def fall(draw):
    """Is let down on a table."""
    D, height, wall = draw.between(0.05, 0.1), draw.between(0.4, 0.6), draw.file(".txt")
    wall.write_text(f"plane {height} 0 0 -1 0 0 friction {draw.choice(0.2, 0.5, 1)}\n")
    return {"growth_type": "feed", "growth_initial_length": 0.3, "rod_weight": f"{draw.between(20, 60)},0,0",
            **draw.uneven(), "friction_mu": 0, "friction_layers": "0:0.05", "wall_file": wall, "rod_cells": 40,
            "rod_curvature_2": draw.between(-1, 1), "rod_curvature": draw.between(-1, 1), "contact_diameter": D,
            "ts_max_time": draw.between(1.2, 1.8), **draw.rubbing()}


def writhe(draw):
    """Spun by its clamp while its end is led towards it: it writhes, and winds up."""
    length, turns, slack, time = draw.between(2.5, 4), draw.between(3, 6), draw.between(0.4, 0.6), 4
    way = draw.file(".csv")
    way.write_text(f"t,x1\n0,{length}\n{time / 2},{length * (1 - slack)}\n{time},{length * (1 - slack)}\n")
    return {"growth_type": "none", "growth_initial_length": length, **draw.uneven(),
            "shape_amplitude": draw.over(1e-3, 0.02), "tip_type": "clamped",  # its way is to begin where the tip is
            "tip_path": way, "clamp_spin": f"{draw.choice(-1, 1) * 2 * np.pi * turns / time:.4g}",
            "friction_mu": 0, "friction_layers": f"0:{draw.over(0.01, 0.3)}", "rod_cells": draw.choice(40, 60),
            "contact_diameter": draw.between(0.1, 0.2), "ts_max_time": draw.between(2, 2.8), **draw.rubbing()}


def wound(draw):
    """Fed between two clamps, and spun by one of them."""
    return {"growth_type": "feed", "growth_initial_length": 1, "tip_type": "clamped", **draw.uneven(),
            "friction_mu": draw.choice(0, 0, 0.2), "clamp_spin": draw.choice(-1, 1) * draw.between(12, 18),
            "contact_diameter": draw.between(0.08, 0.15), "rod_cells": draw.choice(40, 50),
            "ts_max_time": draw.between(0.9, 1.3), **draw.rubbing()}


def loop(draw):
    """A loop that is twisted, and winds up into a plectoneme."""
    shape, length, pull = draw.file(""), draw.between(3.8, 4.6), draw.over(20, 40)
    shape.mkdir(exist_ok=True)
    torque = draw.between(0.6, 0.85) * np.sqrt(pull)
    twisted_loop(shape, length, torque, pull, draw.between(1.5, 2.3))
    return {"growth_type": "none", "growth_initial_length": length, "shape_type": "file",
            "shape_file": shape / "plectoneme.h5", "tip_type": "clamped", "tip_path": shape / "plectoneme.csv",
            "clamp_spin": -draw.between(1.5, 2.5), "friction_mu": 0, "friction_layers": f"0:{draw.over(1e-2, 1e-1)}",
            "rod_cells": 80, "contact_diameter": draw.between(0.1, 0.16), "ts_max_time": draw.between(1, 2.5), **draw.rubbing()}


def knot(draw):
    """An overhand knot, pulled or let go."""
    shape, way, D = draw.file(".h5"), draw.file(".csv"), draw.between(0.03, 0.05)
    length, apart = overhand(shape, diameter=D, tail=draw.between(1.2, 1.6))
    way.write_text(f"t,x1\n0,{apart}\n0.1,{apart}\n1,{apart + draw.between(-0.3, 0.9):.6g}\n")
    return {"growth_type": "none", "growth_initial_length": length, "shape_type": "file", "shape_file": shape,
            "tip_type": "clamped", "tip_path": way, "friction_mu": 0, "friction_layers": f"0:{draw.over(1e-2, 1e-1)}",
            "rod_cells": 100, "contact_diameter": D, "ts_max_time": draw.between(0.2, 0.4), **draw.rubbing()}


KINDS = {f.__name__: f for f in (coil, writhe, wound, loop, knot, fall)}


def scene(seed, number, directory, kinds):
    """Its kind, and options by name."""
    draw, kind = Draw(f"{seed}-{number}", directory), kinds[number % len(kinds)]
    o = KINDS[kind](draw)
    return kind, {**o, "rod_model": "space", "contact_self": "true", "output_interval": o["ts_max_time"] / 60}


def run(exe, options, file, limit, extra=(), ranks=0):
    """A run, and its command."""
    command = [exe, *(str(w) for k, v in options.items() for w in (f"-{k}", v)), *map(str, extra)]
    if ranks:
        command = ["mpiexec", "--bind-to", "none", "--oversubscribe", "-n", str(ranks), *command]
    done = subprocess.run(["prlimit", f"--cpu={limit}", *command, "-output", str(file)], capture_output=True, text=True,
                          check=False, env=ENVIRONMENT)
    return done, " ".join(command[1:])


def writhe_of(x):
    """Of a polygon: the sum over pairs of edges of the solid angle from which they are seen to cross."""
    i, j = np.triu_indices(len(x) - 1, 2)
    a, b, c, d = x[i], x[i + 1], x[j], x[j + 1]
    r = [c - a, d - a, d - b, c - b]
    n = [np.cross(r[k], r[(k + 1) % 4]) for k in range(4)]
    size = [np.linalg.norm(v, axis=1) for v in n]
    n = [np.where(s[:, None] > 1e-14, v / np.maximum(s, 1e-300)[:, None], 0) for v, s in zip(n, size)]
    angle = sum(np.arcsin(np.clip((n[k] * n[(k + 1) % 4]).sum(1), -1, 1)) for k in range(4))
    return (angle * np.sign((np.cross(d - c, b - a) * (c - a)).sum(1))).sum() / (2 * np.pi)


def in_order(points, fine=2):
    """Points of curve(), one after the other along the rod."""
    return points.reshape(fine, -1, 3).swapaxes(0, 1).reshape(-1, 3)


def wrong(file):
    """What is wrong with a run that ended, or ''; and figures of it."""
    with h5py.File(file) as f:
        shapes, s = {k: f["shapes"][k][:] for k in ("x", "d1", "stretch", "contact")}, f["shapes/s"][:]
        series = {k: f["series"][k][:] for k in ("contacts", "energy_defect", "self_crossings", "contact_force",
                                                 "penetration")}
    if not series["contacts"].max():
        return "", "does not touch"
    turns = np.array([writhe_of(in_order(curve(x, d, g, s, 2))) for x, d, g in
                      zip(shapes["x"], shapes["d1"], shapes["stretch"])])
    jump, late = np.abs(np.diff(turns)).max(), series["energy_defect"][-1]
    figures = f"writhe by {jump:.2f} at most, defect {late:.1e}"
    if jump > 1.5 or series["self_crossings"].max() > 0:
        return "passes through itself", figures
    return ("off its balance of energy" if late > 1e-2 else ""), figures


def estimate(exe, options, file, directory, kept):
    """The true errors of a run and what it tells."""
    with h5py.File(file) as f:
        a, n = dict(f.attrs), f["shapes/s"].shape[0] - 1
    if not kept.exists():
        finer = {**options, "contact_stiffness": repr(float(a["contact_stiffness"])), "rod_cells": int(FINER * n),
                 "ts_rtol": 1e-6, "output_interval": options["ts_max_time"]}
        done, _ = run(exe, finer, f"{directory}/fine.h5", REFERENCE_LIMIT)
        if done.returncode:
            return f"no reference: {done.stderr[-100:]}", None
        np.savez(kept, **coverage.series(f"{directory}/fine.h5")[0])
    with np.load(kept) as f:
        true = coverage.true_errors(coverage.series(file)[0], dict(f), False)
    told = {k[6:]: float(v) for k, v in a.items() if k.startswith("error_") and not isinstance(v, bytes)}
    ratio = min(1, told["estimate"]) / min(1, true.max())
    return ("true " + " ".join(f"{v:.1e}" for v in true) + " told "
            + " ".join(f"{k} {told.get(k, 0):.1e}" for k in ("tip", "norm_x2", "energy", "space", "time", "contact"))
            + f" ratio {ratio:.2g}"), ratio


def on_ranks(exe, options, file, directory):
    """By how much 2 and 3 ranks differ from one, in the energy."""
    off = []
    with h5py.File(file) as f:
        energy = f["series/energy"][-1]
    for ranks in (2, 3):
        done, _ = run(exe, options, f"{directory}/ranks.h5", 3 * LIMIT, ranks=ranks)
        if done.returncode:
            return f"on {ranks} ranks lost: {done.stderr[-100:]}"
        with h5py.File(f"{directory}/ranks.h5") as f:
            off.append(abs(f["series/energy"][-1] / energy - 1))
    return "ranks differ by " + " ".join(f"{v:.1e}" for v in off)


def contents(file):
    found = {}
    with h5py.File(file) as f:
        f.visititems(lambda name, item: found.update({name: item[:]}) if isinstance(item, h5py.Dataset)
                     and item.shape and not name.startswith("restart") else None)
    return found


def broken(exe, options, file, directory):
    """Does it go on to the last bit?"""
    with h5py.File(file) as f:
        touching = np.flatnonzero(f["series/contacts"][:] > 0)
    part = f"{directory}/broken.h5"
    run(exe, options, part, LIMIT, ["-ts_max_steps", touching[len(touching) // 2]])
    done, _ = run(exe, {}, part, LIMIT, ["-restart", part])
    if done.returncode:
        return f"does not go on: {done.stderr[-100:]}"
    one, other = contents(file), contents(part)
    different = [k for k in one if k in other and not np.array_equal(one[k], other[k], equal_nan=one[k].dtype.kind == "f")]
    return f"broken, differs in {different}" if different else "broken: the same"


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("exe")
    for name in ("seed", "first", "count"):
        parser.add_argument(name, type=int)
    parser.add_argument("--kinds", default=",".join(KINDS))
    for name in ("estimate", "ranks", "restart"):
        parser.add_argument(f"--{name}", action="store_true")
    given, tally, ratios = parser.parse_args(), {}, []
    kept = Path(tempfile.gettempdir()) / f"fuzz_ropes-{given.seed}"
    kept.mkdir(exist_ok=True)
    for number in range(given.first, given.first + given.count):
        with tempfile.TemporaryDirectory() as d:
            kind, o = scene(given.seed, number, d, given.kinds.split(","))
            done, command = run(given.exe, o, f"{d}/own.h5", LIMIT)
            said = (done.stderr or done.stdout).strip()[-250:]
            what, more = wrong(f"{d}/own.h5") if not done.returncode else ("jammed" if "jammed at" in said else "lost: "
                                                                          + said, "")
            if not what and "not touch" not in more:
                what = "touched"
                more += " " + re.search(r"\d+ steps", done.stdout).group()
                if given.estimate:
                    text, ratio = estimate(given.exe, o, f"{d}/own.h5", d, kept / f"{number}-{kind}.npz")
                    more, ratios = f"{more}, {text}", ratios + ([ratio] if ratio else [])
                if given.ranks:
                    more += ", " + on_ranks(given.exe, o, f"{d}/own.h5", d)
                if given.restart:
                    more += ", " + broken(given.exe, o, f"{d}/own.h5", d)
            print(number, kind, what, more, *([command] if what not in ("touched", "") else []), flush=True)
        word = (what or "free").split(":")[0]
        tally[word] = tally.get(word, 0) + 1
    print(given.count, "scenes:", tally, *(["estimate over error", np.round(np.sort(ratios), 2)] if ratios else []))


if __name__ == "__main__":
    main()

#!/usr/bin/env python3
"""How well energies balance in random scenes that touch walls, or themselves, and how deep they are pressed in: the
defect at the end of each run.

    scripts/lab/balance.py build/tendril [--families walls,ropes,...] [--cells 500] [--seconds 200] [-- OPTIONS ...]

The scenes are those of fuzz.py (contact: of the plane, with walls and itself), stiffer.py (head-on: into a wall, next to
straight on), fuzz_walls.py (walls: of space) and fuzz_ropes.py (ropes: of space, by themselves). Each is run with so many
cells (0: the 40 to 100 that are drawn for it) and the OPTIONS, such as -ts_rtol 1e-6, for so many SECONDS of a processor. A
scene that touches nothing, or does not end, is left out; how many did not end is told. A line for each scene, and one for
each family."""

import argparse
import random
import re
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
sys.path[:0] = [str(ROOT / "scripts" / "lab"), str(ROOT / "scripts")]
import fuzz
import fuzz_ropes
import fuzz_walls
import h5py
import numpy as np
import stiffer

# family: seeds, and how many scenes of each are drawn
FAMILIES = {"contact": {3: 30}, "head-on": {1: 30, 2: 30}, "walls": {50001: 40, 50003: 60}, "ropes": {5: 18}}


def scenes(family, seed, count, directory):
    """Numbers of scenes, and their options by name."""
    R = random.Random(seed)
    for number in range(count):
        room = Path(directory) / f"{family}-{seed}-{number}"
        room.mkdir()
        if family == "contact":
            o = {"rod_cells": 80, **fuzz.contact_scene(fuzz.Draw(f"{seed}-{number}"), False, room / "scene")}
        elif family == "ropes":
            o = fuzz_ropes.scene(seed, number, room, list(fuzz_ropes.KINDS))[1]
        else:
            o, lines = stiffer.head_on(R) if family == "head-on" else fuzz_walls.scene(R)[::2]
            if not lines:
                continue
            (room / "walls.txt").write_text("\n".join(lines) + "\n")
            o["wall_file"] = room / "walls.txt"
        yield number, o


def run(exe, options, more, seconds, file):
    """Defect, steps, iterations, depth over the diameter; None if nothing is touched, NaN if it does not end."""
    command = ["prlimit", f"--cpu={seconds}", exe, *(str(w) for k, v in options.items() for w in (f"-{k}", v)), *more,
               "-output", str(file)]
    done = subprocess.run(command, capture_output=True, text=True, check=False, env=fuzz_walls.ENVIRONMENT)
    if done.returncode < 0 or not file.exists():
        return None if "starts in a wall" in done.stderr else [np.nan] * 4
    with h5py.File(file) as f:
        s = {k: f[f"series/{k}"][:] for k in ("energy_defect", "contact_force", "newton_iterations", "penetration")}
    file.unlink()
    if not s["contact_force"].max() > 0:
        return None
    if not re.search("energy defect", done.stdout):
        return [np.nan] * 4
    return [s["energy_defect"][-1], len(s["energy_defect"]) - 1, s["newton_iterations"].sum(),
            s["penetration"].max() / float(options["contact_diameter"])]


def tell(name, found):
    """The distribution of the defects of runs that ended."""
    a = np.array(found).reshape(-1, 4)
    ended = a[np.isfinite(a[:, 0])]
    if len(ended):
        quantiles = " ".join(f"{v:.1e}" for v in np.quantile(ended[:, 0], (0.5, 0.75, 0.95)))
        print(f"{name}: {len(ended)} that touch and end, {len(a) - len(ended)} do not end; above 1e-5 {(ended[:, 0] > 1e-5).sum()}, "
              f"above 1e-4 {(ended[:, 0] > 1e-4).sum()}; deeper than 1 % {(ended[:, 3] > 0.01).sum()}; quantiles 50, 75, 95 % {quantiles}; "
              f"steps {ended[:, 1].sum():.0f}, iterations {ended[:, 2].sum():.0f}", flush=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("exe")
    parser.add_argument("--families", default=",".join(FAMILIES))
    parser.add_argument("--cells", type=int, default=500)
    parser.add_argument("--seconds", type=int, default=200)
    words, _, more = " ".join(sys.argv[1:]).partition(" -- ")
    given, more, all_found = parser.parse_args(words.split()), more.split(), []
    with tempfile.TemporaryDirectory() as directory:
        for family in given.families.split(","):
            found = []
            for seed, count in FAMILIES[family].items():
                for number, o in scenes(family, seed, count, directory):
                    if "contact_diameter" not in o:
                        continue
                    o["rod_cells"] = given.cells or o["rod_cells"]
                    seen = run(given.exe, o, more, given.seconds, Path(directory) / "run.h5")
                    if seen is not None:
                        print(f"{family}-{seed}-{number} {seen[0]:.1e} {seen[1]:.0f} steps {seen[2]:.0f} iterations "
                              f"{seen[3]:.2%} deep", flush=True)
                        found.append(seen)
            tell(family, found)
            all_found += found
    tell("all", all_found)


if __name__ == "__main__":
    main()

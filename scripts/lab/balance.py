#!/usr/bin/env python3
"""How well energies balance in random scenes that touch walls, or themselves, and how deep they are pressed in: the
defect at the end of each run.

    scripts/lab/balance.py build/tendril [--families walls,ropes,...] [--cells 500] [--seconds 200] [-- OPTIONS ...]
    scripts/lab/balance.py build/tendril --forces 100 [--seed 1] [--seconds 40] [-- OPTIONS ...]

The scenes are those of fuzz.py (contact: of the plane, with walls and itself), stiffer.py (head-on: into a wall, next to
straight on), fuzz_walls.py (walls: of space) and fuzz_ropes.py (ropes: of space, by themselves). Each is run with so many
cells (0: the 40 to 100 that are drawn for it) and the OPTIONS, such as -ts_rtol 1e-6, for so many SECONDS of a processor. A
scene that touches nothing, or does not end, is left out; how many did not end is told. A line for each scene, and one for
each family.

--forces: how well forces balance (clamp, tip, walls, friction, weight: their sum over the largest of them in the run) in so
many scenes of all that those draw, and of fuzz.py besides, every other one in exact friction, some held in a hinge, or by
nothing: in the worst of all steps, and in the last one. Exit 1 if any is off by more than 1e-6 there."""

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


def of_all_laws(seed, number, room):
    """Options by name of a scene of any kind, or None."""
    draw = fuzz.Draw(f"{seed}-{number}")
    kinds = (fuzz.plain_scene, fuzz.world_scene, fuzz.contact_scene, fuzz.space_scene, fuzz.space_world_scene, "walls", "ropes")
    kind = kinds[number % len(kinds)]
    if kind == "ropes":
        o = fuzz_ropes.scene(seed, number, room, list(fuzz_ropes.KINDS))[1]
    elif kind == "walls":
        o, walls, lines = fuzz_walls.scene(draw)
        if not lines:
            return None
        fuzz_walls.moving(draw, o, walls, lines)
        (room / "walls.txt").write_text("\n".join(lines) + "\n")
        o["wall_file"] = room / "walls.txt"
    else:
        o = kind(draw, False) if kind is fuzz.plain_scene else kind(draw, False, room / "scene")
    if kind in (fuzz.plain_scene, fuzz.space_scene) and not {"tip_type", "clamp_spin"} & set(o) and draw.happens(.4):
        o["clamp_type"], o["rod_model"] = draw.choice(["hinged", "free"]), "space" if kind is fuzz.space_scene else "frame"
        if o["rod_model"] == "space":
            o.setdefault("friction_radius", .1)
        if o["clamp_type"] == "free":
            o["growth_type"] = draw.choice(["uniform", "none"])
            o.pop("growth_width", None), o.pop("growth_zone", None)
    o.setdefault("rod_cells", 120)
    if draw.happens(.5):
        o["friction_beta"] = 0
    return o


def unbalanced(file):
    """Of each step but the first line: the sum of all forces over the largest of them."""
    with h5py.File(file) as f:
        s = {k: d[:] for k, d in f["series"].items()}
    zero = np.zeros(len(s["t"]))
    parts = [np.stack([s.get(f"{who}_force_{k}", zero) for k in (1, 2, 3)]) for who in ("base", "tip", "wall", "friction", "weight")]
    largest = max(max(np.linalg.norm(f, axis=0).max() for f in parts), 1e-9 * s["length"].max())
    return np.linalg.norm(sum(parts), axis=0)[1:] / largest, s["contact_force"].max()


def forces(exe, seed, count, more, seconds, directory):
    """Runs them; how many are off."""
    number, seen, bad = 0, 0, 0
    while seen < count:
        room = Path(directory) / f"forces-{number}"
        room.mkdir()
        o, number = of_all_laws(seed, number, room), number + 1
        if o is None:
            continue
        command = ["prlimit", f"--cpu={seconds}", exe, *(str(w) for k, v in o.items() for w in (f"-{k}", v)), *more,
                   "-output", str(room / "run.h5")]
        done = subprocess.run(command, capture_output=True, text=True, check=False, env=fuzz_walls.ENVIRONMENT)
        if not (room / "run.h5").exists():
            print(f"{number - 1} is refused, or does not begin: {done.stderr.strip()[:100]}")
            continue
        off, touches = unbalanced(room / "run.h5")
        if not len(off):
            continue
        seen, bad = seen + 1, bad + (off.max() > 1e-6)
        print(f"{number - 1}: {len(off)} steps, off by {off.max():.1e} at most, {off[-1]:.1e} at the end; beta {o.get('friction_beta')}, "
              f"touches {touches:.1e}{'' if off.max() <= 1e-6 else '   ' + ' '.join(command[2:])}", flush=True)
    print(f"{seen} scenes, {bad} off by more than 1e-6")
    return bad


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
    parser.add_argument("--forces", type=int, default=0)
    parser.add_argument("--seed", type=int, default=1)
    words, _, more = " ".join(sys.argv[1:]).partition(" -- ")
    given, more, all_found = parser.parse_args(words.split()), more.split(), []
    with tempfile.TemporaryDirectory() as directory:
        if given.forces:
            sys.exit(forces(given.exe, given.seed, given.forces, more, given.seconds, directory) > 0)
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

#!/usr/bin/env python3
"""Random scenes that are broken at random steps, again and again, and gone on with: what they come to must be that of a
run that was not broken, to the last bit.

    restarts.py EXE SEED COUNT [--kinds plain,wide,world,contact,hard,space,space-world,linear,led,kicked,moving,rope]
                [--breaks 3] [--cells 40] [--limit 8] [--show]

COUNT scenes of each kind: those of fuzz.py and coverage.py; rods whose clamp or tip is led, in contact or not; straight
ones that an oblique wall kicks; among walls that move; ropes that touch themselves (fuzz_ropes.py). Of those with friction half
have it exact. A scene that gives up, or takes more than LIMIT seconds of a processor, is left out. Prints what differs, with the
command and the steps at which it was broken; --show: a line a scene."""

import argparse
import os
import subprocess
import sys
import tempfile
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent))
import coverage
import fuzz
import fuzz_ropes
import h5py
import numpy as np

ENVIRONMENT = dict(os.environ, OMP_NUM_THREADS="1")


def led_scene(draw, files):
    """Clamp or tip are led in jerks, in the plane or in space, with walls or without."""
    o = fuzz.contact_scene(draw, False, files) if draw.happens(.5) else fuzz.plain_scene(draw, False)
    o["growth_type"] = draw.choice(["feed", "uniform", "none"])
    for name in ("growth_width", "growth_zone", "clamp_angle", "wall_file"):
        o.pop(name, None)
    end = o["ts_max_time"] = draw.between(1, 2)
    o.update(growth_initial_length=draw.between(1, 2), rod_model="space", friction_radius=draw.over_decades(.02, .3))
    times = [0, *sorted(draw.between(.1, end) for _ in range(3)), end + 1]
    turns = [0, *(draw.between(-2, 2) for _ in range(4))]
    path = Path(f"{files}-led.csv")
    path.write_text("t,turn\n" + "".join(f"{t},{turn}\n" for t, turn in zip(times, turns)))
    if draw.happens(.5):
        o["clamp_path"] = path
    else:
        o.update(tip_path=path, tip_type=draw.choice(["clamped", "slides"]), shape_type="sag", shape_amplitude=.3)
    if draw.happens(.5):
        wall = Path(f"{files}-ground.walls")
        wall.write_text(f"plane 0 0 -0.2  0 {draw.between(-.2, .2)} 1 friction {draw.between(0, .8)}\n")
        o.update(wall_file=wall, contact_diameter=draw.between(.04, .1), rod_weight="0,0,-0.5", shape_amplitude=.1,
                 shape_type="sag")
    elif "contact_self" not in o:
        o.pop("contact_diameter", None)
    return o


def kicked_scene(draw, files):
    """A rod that is straight, or all but, meets an oblique wall."""
    wall = Path(f"{files}.walls")
    length = draw.between(.3, 1)
    wall.write_text(f"plane {length + draw.between(.1, .6)} 0 -1 {draw.between(-.8, .8)} friction {draw.between(0, .5)}\n")
    return {"growth_type": draw.choice(["feed", "uniform"]), "growth_initial_length": length, "shape_type": "straight",
            "rod_curvature": draw.choice([0, 1e-9, 1e-5]), "wall_file": wall, "contact_diameter": draw.between(.02, .1),
            "friction_mu": draw.choice([0, .5, 1]), "friction_beta": draw.choice([0, 1e-3]), "ts_max_time": length + 1}


def moving_scene(draw, files):
    """Walls in space that turn or move, evenly or as given in time."""
    wall = Path(f"{files}.walls")
    kind = draw.choice(["turns", "moves"])
    axis = "1.35 0 0 0 0 1"
    if draw.happens(.5):
        motion = f"turns {draw.between(-2, 2)} {axis}" if kind == "turns" else f"moves {draw.between(-.4, .2)} {draw.between(-.3, .3)} 0"
    else:  # as given in time
        times = [0, *sorted({draw.between(.05, 1.5) for _ in range(4)})]
        rows = [f"{t} {draw.between(-2, 2)}" if kind == "turns" else f"{t} {draw.between(-.4, .1)} {draw.between(-.2, .2)} 0" for t in times]
        motion = f"{kind} {'at' if kind == 'moves' else draw.choice(['at', 'spin'])} {' '.join(rows)}" + f" about {axis}" * (kind == "turns")
    wall.write_text(f"sphere 1.35 {draw.between(-.2, .2)} {draw.between(-.2, .2)} 0.3 outside {motion} friction {draw.between(.1, .8)}\n")
    return {"growth_type": draw.choice(["feed", "none", "uniform"]), "growth_initial_length": .8, "shape_type": "straight",
            "rod_curvature": draw.between(-.2, .2), "rod_curvature_2": draw.between(-.2, .2), "wall_file": wall,
            "contact_diameter": draw.between(.03, .1), "friction_radius": draw.choice([0, .1]),
            "friction_beta": draw.choice([0, 1e-3]), "friction_mu": draw.choice([.5, 1]), "ts_max_time": draw.between(.8, 1.4)}


def rope_scene(draw, files):
    ropes = fuzz_ropes.Draw(draw.randint(1, 10 ** 6), Path(f"{files}").parent)
    ropes.file = lambda end: Path(f"{files}-rope{end}")
    o = draw.choice([fuzz_ropes.coil, fuzz_ropes.fall, fuzz_ropes.writhe])(ropes)
    return {**o, "rod_model": "space", "contact_self": "true"}


KINDS = {**coverage.SCENES, "led": led_scene, "kicked": kicked_scene, "moving": moving_scene, "rope": rope_scene}


def run(exe, words, limit):
    """(exit code, what it said): None: it takes too long."""
    try:
        done = subprocess.run(["prlimit", f"--cpu={limit}", exe, *words], capture_output=True, text=True, env=ENVIRONMENT,
                              timeout=20 * limit)
    except subprocess.TimeoutExpired:
        return None, "hung"
    return (None if done.returncode < 0 else done.returncode), done.stdout + done.stderr


def different(a, b):
    """What two result files differ in."""
    with h5py.File(a) as f, h5py.File(b) as g:
        return [f"{group}/{k}" for group in ("series", "shapes") for k in f[group]
                if k not in g[group] or not np.array_equal(f[group][k][()], g[group][k][()], equal_nan=True)]


def first_step(a, b):
    """... and at which step first."""
    with h5py.File(a) as f, h5py.File(b) as g:
        s, u = f["series"], g["series"]
        n = min(len(s["t"]), len(u["t"]))
        return min((int(np.flatnonzero(s[k][:n] != u[k][:n])[0]) for k in s if (s[k][:n] != u[k][:n]).any()), default=n)


def told(file):
    with h5py.File(file) as f:
        return float(f.attrs.get("error_estimate", 0))


def study(exe, options, directory, limit, breaks, dice):
    """(what is wrong or None, a word on it)."""
    words = [w for k, v in options.items() for w in (f"-{k}", str(v))]
    whole, broken = str(directory / "whole.h5"), str(directory / "broken.h5")
    for file in (whole, broken):
        Path(file).unlink(missing_ok=True)
    code, said = run(exe, [*words, "-output", whole], limit)
    if code != 0:
        return None, f"left out: {said.strip().splitlines()[-1][:90] if said.strip() else code}"
    with h5py.File(whole) as f:
        steps = len(f["series/t"]) - 1
    if steps < 8:
        return None, "left out: few steps"
    at = sorted({int(k) for k in dice.integers(1, steps, breaks)})
    start = [*words, "-output", broken]
    for k in at:
        run(exe, [*start, "-ts_max_steps", str(k)], limit)
        start = ["-restart", broken]
    code, again = run(exe, start, 2 * limit)
    if code != 0:
        return f"does not go on: {again.strip()[-200:]}", at
    wrong = different(whole, broken)
    if wrong:
        return f"{len(wrong)} differ, first at step {first_step(whole, broken)} of {steps}", at
    a, b = told(whole), told(broken)
    if not (b >= .5 * a and a >= .5 * b) and max(a, b) > 1e-7:
        return f"told {a:g}, behind breaks {b:g}", at
    return None, f"{steps} steps, broken at {at}, told {a:g} and {b:g}"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("exe")
    parser.add_argument("seed", type=int)
    parser.add_argument("count", type=int)
    parser.add_argument("--kinds", default=",".join(KINDS))
    parser.add_argument("--breaks", type=int, default=3)
    parser.add_argument("--cells", type=int, default=40)
    parser.add_argument("--limit", type=int, default=8)
    parser.add_argument("--show", action="store_true")
    choice = parser.parse_args()
    tally = {}
    with tempfile.TemporaryDirectory(prefix="tendril-") as name:
        directory = Path(name)
        for kind in choice.kinds.split(","):
            draw, dice = fuzz.Draw(f"{choice.seed} {kind}"), np.random.default_rng(choice.seed)
            for i in range(choice.count):
                options = KINDS[kind](draw, directory / f"{kind}-{i}")
                if kind != "rope":
                    options["rod_cells"] = choice.cells
                options["ts_max_time"] = min(float(options["ts_max_time"]), 5)
                if draw.happens(.5) and float(options.get("friction_mu", 1)) > 0:
                    options["friction_beta"] = 0
                wrong, said = study(choice.exe, options, directory, choice.limit, choice.breaks, dice)
                what = "wrong" if wrong else "left out" if str(said).startswith("left out") else "good"
                tally[what] = tally.get(what, 0) + 1
                words = " ".join(f"-{k} {v}" for k, v in options.items())
                if wrong:
                    print(f"FAIL {kind} {i}: {wrong}; broken at {said}: {words}", flush=True)
                    for k, v in options.items():
                        if str(v).startswith(name) and str(v).endswith((".walls", ".csv", ".txt")):
                            print(f"     {Path(v).name}: {Path(v).read_text().strip()!r}")
                elif choice.show:
                    print(f"{kind} {i}: {said}", flush=True)
    print(f"seed {choice.seed}: {tally}")
    return int("wrong" in tally)


if __name__ == "__main__":
    sys.exit(main())

#!/usr/bin/env python3
"""Random rods: what -task critical tells, against finer meshes and, where the rod is followed, a hundredth of the tolerance.

    fuzz_critical.py EXE SEED COUNT [--bent]

Straight rods over laws of growth, loads, held tips, a hinge, weight, layers, stiffness, few cells; --bent: rods in space that
something bends. A time or length off by more than three times what is told, or told where the finer one has none,
is printed with its command; exit 1 if there is any."""

import re
import subprocess
import sys
import tempfile

import numpy as np

from fuzz import Draw, write


def scene(draw, bent, files):
    o = {"growth_type": draw.choice(["uniform", "uniform", "gaussian", "feed", "apical", "table"]),
         "growth_initial_length": draw.between(.3, 1.2), "rod_cells": draw.choice([8, 12, 20, 33, 60]),
         "friction_mu": draw.choice([0, 1, 1, draw.between(.1, .9)]),
         "friction_beta": draw.choice([0, 1e-17, 1e-9, 1e-3]), "ts_max_time": draw.between(4, 9)}
    if o["growth_type"] == "gaussian":
        o["growth_width"] = draw.over_decades(.05, 2)
    if o["growth_type"] == "apical":
        o["growth_zone"] = draw.between(.3, 2)
        if draw.happens(.7):
            o["friction_mu"] = 0
    if o["growth_type"] == "table":
        L, begins, power = o.pop("growth_initial_length"), draw.choice([0, 1, 1]), draw.choice([1, 2, 3])
        t, s = np.linspace(0, 10, 101), np.linspace(0, 1, 21)
        late = np.clip(t - begins, 0, None)
        late = late ** power / (1 + late) ** (power - 1)
        share = 1 + draw.between(-.6, .6) * np.cos(3 * s)
        o["growth_table"] = write(files + "-table.h5", s=s, t=t, g=L + np.outer(late, share))
        o["ts_max_time"] = 8
    if draw.happens(.35):
        o["friction_across"] = draw.over_decades(.4, 3)
    if draw.happens(.3):
        a = draw.between(.2, 1)
        o["friction_layers"] = (f"0:{draw.over_decades(.3, 3)},{a}:{draw.over_decades(.2, 5)},"
                                f"{a + draw.between(.5, 2):.3f}:{draw.over_decades(.2, 5)}")
        o["friction_layer_width"] = draw.over_decades(.05, .3)
    if draw.happens(.25) and not bent:
        o["tip_type"] = draw.choice(["pinned", "clamped", "slides"])
        if draw.happens(.5) and o["growth_type"] not in ("feed", "apical"):
            o["clamp_type"] = "hinged"
    elif draw.happens(.25) and bent:
        o["tip_type"] = "slides"
    elif draw.happens(.6):
        o["tip_force"] = draw.choice([1, 1, -1]) * draw.over_decades(.02, 2)
        o["tip_law"] = draw.choice(["dead", "follower", "resistance"])
        if o["tip_law"] == "resistance":
            o["tip_force"] = abs(o["tip_force"])
    if draw.happens(.25):
        o["rod_weight"] = f"{draw.between(-.6, .4)},0" + (",0" if bent or draw.happens(.2) else "")
    if draw.happens(.2):
        o["rod_bend_ratio"] = draw.over_decades(.3, 4)
    if draw.happens(.1) and "clamp_type" not in o:
        o["tip_torque"] = draw.between(-2, 2)
    if draw.happens(.2):
        d = np.linspace(0, 12, 201)
        factor = draw.between(.5, 2) + draw.between(.2, 3) * (1 - np.exp(-d / draw.between(.3, 3)))
        o["rod_stiffness_file"] = write(files + "-stiffness.h5", distance=d, factor=factor)
    if bent:
        o["rod_model"] = "space"
        if o["friction_beta"] == 0:
            o["friction_beta"] = 1e-12
        if draw.happens(.6):
            o["rod_curvature"] = draw.over_decades(.01, 1)
        if draw.happens(.3) or "rod_curvature" not in o:
            o["rod_weight"] = f"{draw.between(-.3, .3)},{draw.over_decades(1e-3, .3)},{draw.choice([0, draw.over_decades(1e-3, .3)])}"
        o["shape_type"] = draw.choice(["straight", "sag"])
        o["ts_max_time"] = min(o["ts_max_time"], 5)
    return o


def run(exe, o):
    """t, L and the error told, or None; the frequency, or what was said; the command."""
    command = [exe, "-task", "critical", *(word for k, v in o.items() for word in ("-" + k, str(v)))]
    try:
        done = subprocess.run(command, capture_output=True, text=True, timeout=60, check=False)
    except subprocess.TimeoutExpired:
        return None, "HUNG", command
    if done.returncode:
        return None, done.stderr.strip(), command
    numbers = [float(re.search(p + r"\s*=?\s*(\S+)", done.stdout).group(1)) for p in ("t =", "L =", "below")]
    flutter = re.search(r"flutter, frequency (\S+)", done.stdout)
    return numbers, float(flutter.group(1)) if flutter else 0, command


def main(exe, seed, count, *flags):
    bad = told = refused = 0
    scratch = tempfile.mkdtemp(prefix="fuzz-critical-")  # kept: commands that are printed need their files
    for k in range(int(count)):
        draw = Draw(int(seed) * 1000 + k)
        bent = "--bent" in flags
        o = scene(draw, bent, f"{scratch}/{k}")
        found, what, command = run(exe, o)
        finer = {"rod_cells": 2 * o["rod_cells"]} if bent else {"rod_cells": 400}
        if bent:
            finer["ts_rtol"] = 1e-8
        fine, what2, _ = run(exe, {**o, **finer})
        if found is None:
            refused += 1
            print(f"{seed} {k}: refused: {what[:110]}" + (f"; the finer one tells {fine}" if fine else ""), flush=True)
            continue
        told += 1
        if fine is None:
            bad += 1
            print(f"{seed} {k}: TOLD {found} {what}, finer: {what2[:150]}\n   {' '.join(command)}", flush=True)
            continue
        off = abs(found[0] - fine[0])
        mark = off > 3 * found[2] or (what > 0) != (what2 > 0)
        bad += mark
        print(f"{seed} {k}: {found[0]:.9g} off {off:.1e} told {found[2]:.1e}, frequencies {what:.4g} {what2:.4g}, cells "
              f"{o['rod_cells']}" + (f"  BAD\n   {' '.join(command)}" if mark else ""), flush=True)
    print(f"{told} told, {refused} refused, {bad} bad")
    return bad > 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))

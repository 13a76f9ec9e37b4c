#!/usr/bin/env python3
"""Rods beyond critical: to which side do they snap?

    snaps.py EXE starts                  60 starts: lengths, forces, amplitudes, dry and viscous
    snaps.py EXE random SEED COUNT       random scenes: starts, loads that rise, held tips, hairpins
    snaps.py EXE far SEED COUNT          starts far beyond critical, P L^2 from 10 to 60, bent by 0.3 to 1.4
    snaps.py EXE across SEED COUNT       bent dry rods with weak friction across: from 0.02 to 0.5 of that along

Each at the defaults, and at -ts_rtol 1e-4 and 1e-8, against a reference that shares no snap and no step
beyond a growth time with it: friction with a viscous share of 0.001 where it is dry, a first step of
1e-12 and none longer than 1e-3 of the run. A tip that is farther from the reference's than 0.05 of the
length is on another side. Prints those, with their command, and a summary; exit 1 if there is one. With
friction across, a line that says that the rod has no velocity counts as refused, not as lost."""

import subprocess
import sys
import tempfile
from pathlib import Path

import h5py
import numpy as np

from fuzz import Draw

OTHER_SIDE = 0.05
TOLERANCES = ("1e-6", "1e-4", "1e-8")
REFUSED = "does not say how fast so bent a rod moves"
LIMIT = 120  # seconds of processor time


def starts():
    """60 rods under a dead force, from 1.6 to 6 times that under which a straight one buckles."""
    for length in (.05, .1, .2, .35, .5):
        for load in (4, 8, 15):
            for amplitude in (.1, 1):
                for mu in (0, 1):
                    yield dict(growth_initial_length=length, tip_force=float(f"{load / length ** 2:.6g}"),
                               shape_amplitude=amplitude, friction_mu=mu, ts_max_time=float(f"{.2 * length:.3g}"))


def bent(draw, length, amplitude, bends=True):
    o = dict(growth_type=draw.choice(["uniform", "feed", "gaussian"]), growth_initial_length=length,
             shape_type=draw.choice(["sag", "sag", "random"]) if bends else "sag", shape_amplitude=amplitude,
             friction_mu=draw.choice([0, .5, 1, 1]))
    if o["shape_type"] == "random":
        o["shape_seed"] = draw.randint(1, 1000)
    if draw.happens(.2):
        o["friction_beta"] = draw.over_decades(1e-8, 1e-2)
    return o


def beyond(draw):
    """Beyond critical at t = 0."""
    length = draw.over_decades(.05, 2)
    o = bent(draw, length, draw.over_decades(.01, 2))
    return dict(o, tip_force=float(f"{draw.over_decades(3, 70) / length ** 2:.4g}"),
                ts_max_time=float(f"{.2 * length:.4g}"))


def far(draw):
    """Far beyond critical at t = 0, and bent far; some out of the plane: a first step may go far, to another state."""
    length = draw.over_decades(.05, .5)
    o = dict(growth_type=draw.choice(["uniform", "feed"]), growth_initial_length=length, shape_type="sag",
             shape_amplitude=draw.between(.3, 1.4), friction_mu=draw.choice([0, 0, .5, .9, .99, .999, .999, 1]))
    if draw.happens(.2):
        o["shape_turn"] = draw.between(.1, 6.2)
    return dict(o, tip_force=float(f"{draw.over_decades(10, 60) / length ** 2:.4g}"),
                ts_max_time=float(f"{.2 * length:.4g}"))


def rising(draw):
    """Critical on the way: a rod grows under a force, or into layers that resist more and more."""
    length = draw.between(.3, 1)
    o = bent(draw, length, draw.over_decades(.003, .3))
    o["ts_max_time"] = draw.between(.5, 1.5)
    if draw.happens(.5):
        critical = 2.47 / (length + draw.between(.1, .4)) ** 2
        return dict(o, tip_force=float(f"{critical:.4g}"))
    return dict(o, friction_layers=f"0:1,{length + draw.between(0, .3):.3g}:{draw.over_decades(20, 300)}",
                friction_layer_width=draw.between(.05, .3))


def held(draw):
    o = bent(draw, draw.between(.5, 2), draw.between(.1, 1))
    return dict(o, tip_type=draw.choice(["pinned", "clamped"]),
                ts_max_time=float(f"{o['growth_initial_length'] * draw.between(.3, 1):.3g}"))


def hairpin(draw):
    return dict(bent(draw, draw.between(1, 3), draw.between(1.2, 3.1), False),
                ts_max_time=draw.between(.2, 2))


def across(draw):
    """Friction across that is weaker than along."""
    o = dict(bent(draw, draw.over_decades(1, 4), draw.over_decades(.03, 2)), friction_mu=1,
             friction_across=draw.over_decades(.02, .5),
             friction_beta=draw.choice([0, 1e-3, draw.over_decades(1e-10, 1e-2)]))
    if draw.happens(.4):
        o["tip_force"] = draw.over_decades(.05, 2)
    if draw.happens(.4):
        o["rod_curvature"] = draw.between(-.2, .2)
    return dict(o, ts_max_time=draw.between(.5, 4))


def scenes(words):
    if words == ["starts"]:
        return list(starts())
    draw = Draw(int(words[1]))
    kinds = {"across": [across], "far": [far], "random": [beyond, beyond, rising, held, hairpin]}[words[0]]
    return [draw.choice(kinds)(draw) for _ in range(int(words[2]))]


def run(exe, options, directory):
    """(tip over length, None) or (None, what it said)"""
    file = Path(directory) / "run.h5"
    command = [exe, *(word for k, v in options.items() for word in (f"-{k}", str(v)))]
    done = subprocess.run(["prlimit", f"--cpu={LIMIT}", *command, "-quiet", "-output", str(file)],
                          capture_output=True, text=True)
    if done.returncode:
        return None, done.stderr.strip()[-400:] or "hung"
    with h5py.File(file) as f:
        tip = [f["series"][k][-1] for k in ("tip_x1", "tip_x2", "tip_x3") if k in f["series"]]
        return np.array(tip) / f["series"]["length"][-1], None


def reference(options):
    o = dict(options, ts_dt=1e-12, ts_adapt_dt_max=1e-3 * options["ts_max_time"])
    return dict(o, friction_mu=.999) if options["friction_mu"] == 1 else o


def main():
    words = sys.argv[2:]
    if not (words == ["starts"] or words[:1] in (["random"], ["far"], ["across"]) and len(words) == 3):
        sys.exit(__doc__)
    exe, other, lost, unknown, refused, farthest, tried = sys.argv[1], 0, 0, 0, 0, 0, 0
    with tempfile.TemporaryDirectory() as directory:
        for options in scenes(words):
            right, said = run(exe, reference(options), directory)
            command = " ".join(f"-{k} {v}" for k, v in options.items())
            if right is None:
                unknown += 1
                print("no reference:", said, "|", command, flush=True)
                continue
            for rtol in TOLERANCES:
                tip, said = run(exe, dict(options, ts_rtol=rtol), directory)
                tried += 1
                if tip is None and REFUSED in said:
                    refused += 1
                    print("refused:", command, "-ts_rtol", rtol, flush=True)
                    continue
                if tip is None:
                    lost += 1
                    print("lost:", said, "|", command, "-ts_rtol", rtol, flush=True)
                    continue
                distance = float(np.linalg.norm(tip - right))
                if distance > OTHER_SIDE:
                    other += 1
                    print(f"tip {tip.round(3)}, not {right.round(3)}:", command, "-ts_rtol", rtol, flush=True)
                else:
                    farthest = max(farthest, distance)
    print(f"{other} of {tried} runs on another side, {lost} lost, {refused} refused, {unknown} scenes without a "
          f"reference; the "
          f"others' tips within {farthest:.1e} of the length")
    sys.exit(int(other + lost > 0))


if __name__ == "__main__":
    main()

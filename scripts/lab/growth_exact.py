#!/usr/bin/env python3
"""Growth that senses and yields against its exact answers, in one table: what is found, what is exact, by how much it is off, and what
the run tells of its errors.

    growth_exact.py EXE [--only WORD] [--rtol 1e-7]

Stiff rods (B = 1e9) have their natural shape; of straight ones the length is asked for, and when they buckle or swing."""

import argparse
import re
import subprocess
import sys
import tempfile
from cmath import exp as cexp
from math import atan, cos, exp, hypot, pi, sin, sqrt, tan
from pathlib import Path

import h5py
import numpy as np

SMALL = 1e-4                 # an angle that is linear
STIFF = 1e9


def last(run, name):
    return float(run["series"][name][-1])


def towards(angle):
    return f"-tropism_direction {cos(angle)!r},{sin(angle)!r}"


def linear(run):
    """The part of a small angle that the tip is still off."""
    return 1 - last(run, "tip_angle") / SMALL


def swings(memory, b, t):
    w = sqrt(b / memory - 1 / 4 / memory**2)
    return exp(-t / 2 / memory) * (cos(w * t) + sin(w * t) / 2 / memory / w)


def answers():
    """(what, options, what is asked for, exact)"""
    tip = "-tropism_proprioception 1 -tropism_sensed tip"
    angle = lambda run: last(run, "tip_angle")
    length = lambda run: last(run, "length")
    yield_ = "-shape_type straight -growth_initial_length 0.5 -growth_yield 1.2 -growth_type"
    for law in ("uniform", "apical -growth_zone 0.5"):
        yield (f"1 tip, {law}", f"STIFF -growth_type {law} -ts_max_time 1 -tropism_gravity 2 {tip} {towards(1.2)}",
               lambda run: angle(run) - 1.2, 2 * atan(tan(-.6) * exp(-2)))
    yield ("1 with memory", f"STIFF -growth_type uniform -ts_max_time 1 -tropism_gravity 2 {tip} -tropism_memory 0.3 {towards(SMALL)}",
           linear, swings(.3, 2, 1))
    for L, t, exact in ((1, 1, 0.3754088546), (2, 1, 0.0115788341), (3, 5, 0.0219638368), (6, 5, -0.0173231963)):
        yield (f"2 no growth, s {L}, t {t}", f"STIFF -growth_type none -growth_initial_length {L} -tropism_rate 1 -tropism_gravity 1 "
               f"-tropism_proprioception 0.5 -ts_max_time {t} {towards(SMALL)}", linear, exact)
    yield ("3 at rest", "STIFF -growth_type none -tropism_rate 1 -tropism_gravity 2 -tropism_proprioception 1 -ts_max_time 40 "
           "-tropism_direction 0,1", lambda run: pi / 2 - angle(run), 0.2690359907)
    for G, exact in ((1, -0.1965480953), (1.5, -0.0657722187)):
        yield (f"4 uniform, G {G}", f"STIFF -growth_type uniform -tropism_gravity 2 -tropism_proprioception {G} -ts_max_time 1 "
               f"{towards(SMALL)}", linear, exact)
    for law, ends in (("-tropism_gravity 4 -tropism_proprioception 2", (1.0248121758, 1.1370367447, 1.188009917)),
                      ("-tropism_gravity 6 -tropism_proprioception 0.5 -tropism_memory 0.4", (1.7512510657, 1.014168622, 1.21599738))):
        for t, exact in zip((1, 2, 4), ends):
            yield (f"6 bell, {law.split()[1]}, t {t}", f"STIFF -growth_type apical -growth_zone 1 -tropism_sensed tip {law} "
                   f"-ts_max_time {t} {towards(1.2)}", angle, exact)
    for omega, exact in ((3, 0.1659526108), (10, 0.0404124512)):
        yield (f"8 nutation in drag, {omega}", "-shape_type straight -growth_initial_length 1 -growth_type none -friction_mu 0 "
               f"-tropism_rate 1 -tropism_gravity 1 -tropism_direction 1,0 -tropism_proprioception 0.5 -tropism_nutation {SMALL} "
               f"-tropism_nutation_2 {SMALL} -tropism_nutation_rate {omega} -ts_max_time 20",
               lambda run: hypot(last(run, "tip_x2"), last(run, "tip_x3")) / SMALL, exact)
    for name, law, end, exact in (
            ("uniform, beta 1e-3", "uniform -friction_mu 1", 3, 1.9780650367),
            ("uniform, beta 1e-4", "uniform -friction_mu 1 -friction_beta 1e-4", 3, 1.9440504676),
            ("uniform, exact friction", "uniform -friction_mu 1 -friction_beta 0", 3, 1.9278347677),
            ("uniform, viscous, pressed", "uniform -friction_mu 0 -tip_force 0.3", 4, 2.6449147195),
            ("fed, exact friction", "feed -friction_mu 1 -friction_beta 0", 2, 1.2 - .7 * exp(-2 / 1.2)),
            ("fed, viscous", "feed -friction_mu 0", 2, 1.2 * (sqrt(1 + 2 / 1.2 * (.5 + .25 / 2.4 + 2)) - 1)),
            ("a zone, viscous", "apical -growth_zone 0.5 -growth_initial_length 1 -growth_yield 1.5 -friction_mu 0 -tip_force 0.3", 1,
             1.7082770244),
            ("a zone, exact friction", "apical -growth_zone 0.5 -growth_initial_length 1 -growth_yield 1.5 -friction_mu 1 "
             "-friction_beta 0 -tip_force 0.3", 1, 1 + 1 - .55 / 1.5)):
        yield f"9 {name}", f"{yield_} {law} -ts_max_time {end}", length, exact


def turned(q):
    """Where a stiff tip is across, over a small angle of its clamp: int exp(-q s) - 1 ds."""
    return (1 - cexp(-q)) / q - 1


def across(run):
    return complex(last(run, "tip_x2"), last(run, "tip_x3")) / SMALL


def later():
    """As answers(): a clinostat, ironing, a snake."""
    bent = f"-growth_type none -friction_mu 0 -tropism_rate 1 -tropism_direction 1,{-SMALL},0"
    for omega, b, G in ((2, 1, .5), (5, 3, 1)):
        yield (f"7 clinostat, {omega}", f"STIFF {bent} -tropism_gravity {b} -tropism_proprioception {G} -clamp_spin {omega} -ts_max_time 40",
               lambda run, q=b / (G - 1j * omega): abs(across(run) - turned(q)), 0.)
    for law, factor in (("none -tropism_rate 1", 3), ("uniform", 16)):
        yield (f"11 cantilever, {law.split()[0]}", f"STIFF -growth_type {law} -friction_mu 0 -growth_ironing 2 -tip_force_vector 0,3e5,0 "
               "-ts_max_time 1", lambda run: last(run, "tip_x2") * 1e4, factor)


def straight():
    """(what, options of -task critical, length): section 5, and 10."""
    law = "-tropism_proprioception {} -tropism_gravity {} -tropism_direction 1,0"
    viscous = "-friction_mu 0 "
    yield "5 viscous, G 1", viscous + "-tropism_proprioception 1", 2.1758716549
    for b, tip, length in ((1, "", 2.1640112874), (10, "", 1.8095000078), (1, " -tropism_sensed tip", 2.3722649159),
                           (10, " -tropism_sensed tip", 2.9118257437)):
        yield f"5 viscous, b {b}{tip}", viscous + law.format(1, b) + tip, length
    yield "5 viscous, memory", viscous + law.format(.5, 3) + " -tropism_sensed tip -tropism_memory 1", 1.7497779049
    yield "5 dry", law.format(1, 1), 1.984753359
    yield "5 dry, tip", law.format(1, 1) + " -tropism_sensed tip", 2.148058511
    yield "5 viscous, ironing 2", viscous + "-tropism_proprioception 1 -growth_ironing 2", 1.7237350449
    yield "5 dry, ironing 4", "-tropism_proprioception 1 -growth_ironing 4", 1.251815804
    yield "5 weight", viscous + "-rod_weight -1,0 " + law.format(1, 2), 1.6276499439
    yield "5 weight, tip", viscous + "-rod_weight -1,0 -tropism_sensed tip " + law.format(1, 2), 1.8026047109
    for limit, length in ((.5, 3.2384319552), (1, 2.7466089760), (2, 2.4688957860)):
        yield f"10 viscous, {limit}", f"{viscous}-growth_yield {limit} -ts_max_time 20", length
    for limit, length in ((.5, 2.4709206437), (1, 2.0624712812), (1.5, 1.9908584435), (3, 1.9863527074)):
        yield f"10 dry, {limit}", f"-friction_beta 1e-10 -growth_yield {limit} -ts_max_time 20", length


def lengths(asked):
    for name, options, exact in straight():
        if asked.only not in name:
            continue
        done = subprocess.run([asked.exe, "-task", "critical", *options.split()], capture_output=True, text=True, check=False)
        found = re.search(r"length L = (\S+)", done.stdout)
        if not found:
            print(f"| {name} | {done.stderr.strip()[-90:]} | {exact:.10g} | | |", flush=True)
            continue
        told = re.search(r"error below +(\S+)", done.stdout)[1]
        print(f"| {name} | {found[1]} | {exact:.11g} | {abs(float(found[1]) - exact):.1e} | {told} |", flush=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("exe")
    parser.add_argument("--only", default="", help="answers whose name has this word")
    parser.add_argument("--rtol", default="1e-7")
    parser.add_argument("--cells", default="100")
    asked = parser.parse_args()
    with tempfile.TemporaryDirectory() as directory:
        stiff, file = Path(directory) / "stiff.h5", Path(directory) / "run.h5"
        with h5py.File(stiff, "w") as f:
            f["distance"], f["factor"] = np.linspace(0, 10, 5), np.full(5, STIFF)
        print("| answer | found | exact | off | told |\n|---|---|---|---|---|")
        for name, options, found, exact in (*answers(), *later()):
            if asked.only not in name:
                continue
            words = options.replace("STIFF", f"-rod_stiffness_file {stiff} -shape_type straight -growth_initial_length 1")
            done = subprocess.run([asked.exe, *words.split(), "-rod_cells", asked.cells, "-ts_rtol", asked.rtol, "-output", str(file)],
                                  capture_output=True, text=True, check=False)
            if done.returncode:
                print(f"| {name} | {done.stderr.strip()[-90:]} | {exact:.10g} | | |", flush=True)
                continue
            with h5py.File(file) as run:
                value, told = found(run), max(last(run, "error_tip"), last(run, "error_energy"))
            print(f"| {name} | {value:.10g} | {exact:.10g} | {abs(value - exact):.1e} | {told:.0e} |", flush=True)
    lengths(asked)


if __name__ == "__main__":
    sys.exit(main())

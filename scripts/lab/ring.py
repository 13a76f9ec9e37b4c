#!/usr/bin/env python3
"""A ring that is closed and then twisted (Michell, Zajac): the twist at which -task critical says that it leaves its plane,
2 pi sqrt(3) B/C.

    scripts/lab/ring.py build/tendril [CELLS ...]

The ring is what the rod begins as: length 1, bent by 2 pi, and its tip is held where it closes. Its natural twist is -Phi, so that
it bears C Phi with sections that do not turn against the ring. It may roll about its own axis at no cost, which no mesh tells from
giving way. So it has a part of its bend by nature; that holds it and shifts what is looked for, to second order in Phi as the roots
of a determinant say (written beside), and three such parts are extrapolated to none. Its plane is tilted, as any may be. Whether it
is stable is asked at each of Phi, halving."""

import shlex
import subprocess
import sys
import tempfile

import h5py
import numpy as np

TORSION, TILT, NATURAL = 0.75, 0.7, (0.001, 0.002, 0.004)
ZAJAC = 2 * np.pi * np.sqrt(3) / TORSION
FOUND = 1e-11
STEPS = "-ts_max_time 1e-5 -ts_dt 1e-6 -ts_rtol 1e-4"


def cross(a):
    return np.array([[0, -a[2], a[1]], [a[2], 0, -a[0]], [-a[1], a[0], 0]])


def determinant(moment, natural):
    """Of turns and forces that go with two waves round a ring of radius 1 under a twisting moment."""
    turn = cross([0, 0, 1]) + 2j * np.eye(3)
    bent = np.diag([TORSION, 1, 1]) @ turn
    return np.linalg.det(np.block([[turn @ bent - cross([moment, 0, 1 - natural]) @ turn, cross([1, 0, 0])],
                                   [-cross([0, 0, moment]) @ turn, turn]])).imag


def exact(natural):
    a, b = 1.5, 1.8
    rises = determinant(b, natural) > 0
    for _ in range(60):
        middle = (a + b) / 2
        a, b = (a, middle) if (determinant(middle, natural) > 0) == rises else (middle, b)
    return 2 * np.pi * a / TORSION


def unstable(tendril, scratch, twist, natural, cells, tilt=TILT, steps=STEPS):
    across = 2 * np.pi * np.array([np.sin(tilt), np.cos(tilt)])
    with h5py.File(f"{scratch}/ring.h5", "w") as f:
        f["s"], one = np.linspace(0, 1, 9), np.ones(9)
        f["u1"] = twist * one
        for k in (0, 1):
            f[f"u{2 + k}"] = across[k] * (1 - natural) * one
    said = subprocess.run([tendril, *shlex.split(
        f"-task critical -growth_type none -growth_initial_length 1 -friction_mu 0 -rod_torsion {TORSION} -rod_twist {-twist:.17g} "
        f"-rod_curvature_2 {across[0] * natural:.17g} -rod_curvature {across[1] * natural:.17g} -shape_type file "
        f"-shape_file {scratch}/ring.h5 -tip_type clamped -rod_cells {cells} {steps}")],
        capture_output=True, text=True, check=False).stderr
    if "unstable already" not in said and "stable up to there" not in said:
        sys.exit(said)
    return "unstable already" in said


def critical(tendril, scratch, natural, cells, near):
    a, b = near
    if unstable(tendril, scratch, a, natural, cells) or not unstable(tendril, scratch, b, natural, cells):
        sys.exit(f"does not give way between {a} and {b}")
    while b - a > FOUND * b:
        middle = (a + b) / 2
        a, b = (a, middle) if unstable(tendril, scratch, middle, natural, cells) else (middle, b)
    return (a + b) / 2


def main(tendril, *cells):
    with tempfile.TemporaryDirectory() as scratch:
        for n in map(int, cells or (50, 100, 200, 400)):
            off = 1e3 / n**4 + 1e-8
            found = [critical(tendril, scratch, k, n, exact(k) * np.array([1 - off, 1 + off])) for k in NATURAL]
            limit = np.polynomial.polynomial.polyfit(NATURAL, found, 2)[0]
            print(f"{n} cells: {limit:.10f}, off by {limit / ZAJAC - 1:.2e}; with parts of the bend by nature by",
                  ", ".join(f"{phi / exact(k) - 1:.2e}" for phi, k in zip(found, NATURAL)), flush=True)


if __name__ == "__main__":
    main(*sys.argv[1:])

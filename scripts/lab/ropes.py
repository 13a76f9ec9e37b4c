#!/usr/bin/env python3
"""The ropes of tests/run/ropes_test.py, finer and with more of them: the rows of the table in docs/ropes.md.

    ropes.py build/tendril [pillar|helix|upheaval|heavy|plectoneme|knot ...]"""

import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent.parent
sys.path[:0] = [str(ROOT / "tests" / "run"), str(ROOT / "scripts")]
import ropes_test as ropes
import scene_test as scene

import numpy as np
from scipy.optimize import brentq

from tendril.scene_data import overhand, twisted_loop


def pillar():
    for turns, pull, tilt, cells in ((1.5, 60, 0, 300), (1.5, 60, 0.7, 300), (1.5, 60, 2, 300), (2.5, 300, 0.7, 300)):
        r, off = ropes.capstan(turns, pull, tilt, 1e7, cells)
        print(f"| pillar, {turns} turns, turned by {tilt} | {off:.1e} | {r.steps} |", flush=True)


def helix():
    for torque, D in ((0, 0.1), (0.3, 0.02)):
        r = ropes.duct(28.5, torque, 0.15, 3e5, 320, D=D)
        line, turns = ropes.Line(r), 4 * np.pi / np.hypot(ropes.KAPPA, ropes.TAU)
        at = brentq(lambda s: line.P(s) - 10, 3, 6)
        P, want = ropes.helix_push(line, at, at + turns)
        print(f"| helix, two turns, M = {line.M(at):.3g}: P 10 -> {P:.9f}, exact {want:.9f} | {P / want - 1:.1e} "
              f"| {r.steps} |", flush=True)


def upheaval():
    for weight in (0.5, 1, 2):
        r, push, height = ropes.upheaval(weight, 1e10, 1000)
        print(f"| upheaval, w = {weight} | {push:.1e}, {height:.1e} | {r.steps} |", flush=True)


def wound(angle):
    """T R^2/B, M R/B and p R^3/B of a plectoneme (Clauvelin, Audoly, Neukirch 2008)."""
    fourth, M = np.sin(angle)**4, 2 * np.cos(angle) * np.sin(angle)**3 / np.cos(2 * angle)
    return fourth * (0.5 + 1 / np.cos(2 * angle)), M, abs(fourth - M * np.sin(2 * angle) / 2)


def law_of_strands(T, k, D=0.1):
    """Angle, moment and depth of strands under the pull T, pressed in by p/k: contact's energy, U a strand, is part of
    what a length of plectoneme costs."""
    smooth = min(2 * k**-0.75 / (2 * 2**0.5), D / 4)  # over which contact sets in (world/contact.c)

    def rest(depth):
        R, U = (D - depth) / 2, k * (2 * smooth**2 / 3 + (depth**2 - smooth**2) / 2) / 2
        angle = brentq(lambda a: wound(a)[0] - (T + U) * R * R, 0.02, 0.75)
        return angle, wound(angle)[1] / R, wound(angle)[2] / R**3 - k * depth

    depth = brentq(lambda d: rest(d)[2], smooth, 0.2 * D)
    return *rest(depth)[:2], depth


def plectoneme():
    for length, torque, pull, slack, spin, cells, more in (
            (7, 2.529, 9.995, 3.3, 1.9, 160, ""), (4.5, 5.639, 49.68, 2.6, 2.3, 170, ""),
            (4.5, 5.639, 49.68, 2.3, 2.3, 170, "-contact_stiffness 2e5")):
        twisted_loop(Path(scene.SCRATCH), length, torque, pull, slack)
        shape, way = (Path(scene.SCRATCH) / f"plectoneme.{kind}" for kind in ("h5", "csv"))
        r = ropes.Run(f"-growth_type none -growth_initial_length {length} -shape_type file -shape_file {shape} "
                      f"-tip_type clamped -tip_path {way} -clamp_spin {-spin} -contact_diameter 0.1 -contact_self true "
                      f"-friction_mu 0 -friction_layers 0:1e-4 -rod_cells {cells} -ts_rtol 1e-3 -ts_max_time 8 "
                      f"-output_interval 0.5 {more}")
        k = float(r.said.split("contact of stiffness ")[1].split(":")[0])
        for j in range(-6, 0):
            q, n, m = (r.shapes[name][j] for name in ("d1", "force", "moment"))
            T, M = (n[0] * q[0]).sum(), (m * q).sum(axis=1).mean()
            angle, law, depth = law_of_strands(T, k)
            print(f"| plectoneme, angle {angle:.4f}, T {T:.4f}, pressed in by {depth / 0.1:.1%}: M {M:.5f} for "
                  f"{law:.5f} | {M / law - 1:.1e} | {r.steps} |", flush=True)


def heavy():
    for part, time, cells, k in ((0.999, 20, 120, 1e6), (0.9995, 20, 240, 1e7), (1.001, 0.1, 120, 1e6)):
        r = ropes.heavy_rope(part, time, cells=cells, stiffness=k)
        moved = np.abs(r.shapes["x"][-1] - r.shapes["x"][len(r.shapes["x"]) // 2]).max()
        print(f"| heavy rope, {part} of {ropes.overhang(100, 1):.6f} | in the second half by {moved:.1e} | {r.steps} |",
              flush=True)


def knot():
    found = []
    for D, tail, longer, more in ((0.02, 4, 2.2, "-rod_cells 400 -friction_layers 0:1e-4"),
                                  (0.01, 2.6, 4, "-rod_cells 420 -contact_stiffness 5e6 -friction_layers 0:1e-3")):
        shape, way = (Path(scene.SCRATCH) / f"knot.{kind}" for kind in ("h5", "csv"))
        length, apart = overhand(shape, diameter=D, tail=tail, longer=longer)
        way.write_text(f"t,x1\n0,{apart}\n0.2,{apart}\n2,{apart + 1.2}\n")
        r = ropes.Run(f"-growth_type none -growth_initial_length {length} -shape_type file -shape_file {shape} "
                      f"-tip_type clamped -tip_path {way} -contact_diameter {D} -contact_self true -friction_mu 0 "
                      f"-ts_rtol 1e-3 -ts_max_time 2 -output_interval 0.2 {more}")
        for x, n, q in zip(*(r.shapes[name][1:] for name in ("x", "force", "d1"))):
            R = (length - np.linalg.norm(x[-1])) / (2 * np.pi)
            found.append((np.sqrt(D / 2 / R), (n[0] * q[0]).sum() * R * R))
            print(f"| knot, sqrt(h/R) = {found[-1][0]:.4f} | T R^2/B = {found[-1][1]:.5f} | {r.steps} |", flush=True)
    print(f"| loose limit | {np.polynomial.Polynomial.fit(*np.transpose(found), 2)(0):.4f} for 1/2 | |")


def main():
    scene.TENDRIL = str(Path(sys.argv[1]).resolve())
    with tempfile.TemporaryDirectory() as scene.SCRATCH:
        for name in sys.argv[2:] or ("pillar", "helix", "upheaval", "heavy", "plectoneme", "knot"):
            globals()[name]()


if __name__ == "__main__":
    main()

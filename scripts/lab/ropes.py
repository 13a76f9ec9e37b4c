#!/usr/bin/env python3
"""The ropes of tests/scenes/space/ropes_test.py, finer and with more of them: the rows of the table in docs/notes/ropes-measured.md.

    ropes.py build/tendril [pillar|helix|upheaval|heavy|plectoneme|knot ...]"""

import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent.parent
sys.path[:0] = [str(ROOT / "tests/scenes/space"), str(ROOT / "tests/support"), str(ROOT / "scripts")]
import ropes_test as ropes
import scene

import numpy as np
from scipy.interpolate import CubicHermiteSpline, make_interp_spline
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


# Of a loop, twisted until it winds up: the rod's length, the loop's torque and pull, how far its ends are apart and by
# how much its clamp has turned in the end, cells, contact's stiffness.
PLIES = ((18, 0.25, 0.988, 3.2, 47.2, 400, 4e4), (5.5, 2.0, 9.995, 1.3, 26, 160, 1e5),
         (4.75, 5.639, 49.68, 1.3, 35.4, 280, 4e5))


def wind(length, torque, pull, end, turned, cells, k, most=8, still=1):
    """Ends are led together while the clamp turns, both ever slower, then it turns on a little, then rests."""
    d = Path(scene.SCRATCH)
    twisted_loop(d, length, torque, pull, 0)
    apart = np.loadtxt(d / "plectoneme.csv", delimiter=",", skiprows=1)[0, 1]
    t = np.linspace(0, 1, 21)
    np.savetxt(d / "tip.csv", np.c_[most * t, apart - (apart - end) * t * t * (3 - 2 * t)], delimiter=",", header="t,x1",
               comments="", fmt="%.8f")
    np.savetxt(d / "clamp.csv", np.r_[np.c_[most * t, -0.9 * turned * t * (2 - t)],
                                      np.c_[most * (1 + t[1:] / 2), -turned * (0.9 + 0.1 * t[1:] * (2 - t[1:]))]],
               delimiter=",", header="t,turn", comments="", fmt="%.8f")
    return ropes.Run(f"-growth_type none -growth_initial_length {length} -tip_type clamped -tip_path {d / 'tip.csv'} "
                     f"-clamp_path {d / 'clamp.csv'} -contact_diameter {DIAMETER} -contact_self true -contact_stiffness {k} "
                     f"-rod_cells {cells} -ts_rtol 1e-3 -ts_max_time {1.5 * most + still} -output_interval {most / 16} "
                     + ropes.ALONE.format(d / "plectoneme.h5", 1e-4))


DIAMETER = 0.1


def ply(shapes, j, length, k):
    """In the middle of the ply of shape j: the strands' angle and radius R, half of what they are apart, pressure, pull and
    torque. What passes along a rod on which nothing acts along it is n.d1 + m.m/2 - m1^2/2, the pull of an endless tail;
    in the ply that and U, contact's energy of a strand."""
    x, q, n, m = (shapes[name][j] for name in ("x", "d1", "force", "moment"))
    arc = length * shapes["s"]
    line, M = make_interp_spline(arc, x, k=7), (m * q).sum(axis=1)
    tangent, bend = line.derivative(), line.derivative(2)
    pull = ((n * q).sum(axis=1) + ((m * m).sum(axis=1) - M**2) / 2)[[0, -1]].mean()

    def foot(s, other):
        for _ in range(60):
            o, t = line(s) - line(other), tangent(other)
            other += np.clip(o @ t / max(t @ t - o @ bend(other), 0.2), -0.02, 0.02)
        return other

    fine = np.linspace(0, length, 3001)
    half = fine < length / 2
    far = np.linalg.norm(line(fine[half])[:, None] - line(fine[~half]), axis=2)
    touch = np.flatnonzero(far.min(axis=1) < DIAMETER)
    touch = max(np.split(touch, np.flatnonzero(np.diff(touch) > 1) + 1), key=len)
    first, last = fine[half][touch[[0, -1]]]
    places = first + (last - first) * np.linspace(0.35, 0.6, 60)
    found, drawn = [], CubicHermiteSpline(arc, x, q)  # as contact has the rod between nodes
    for s in places:
        other = foot(s, fine[~half][far[np.searchsorted(fine, s)].argmin()])
        cosine = tangent(s) @ tangent(other) / np.linalg.norm(tangent(s)) / np.linalg.norm(tangent(other))
        found.append((np.arccos(abs(cosine)) / 2, np.linalg.norm(line(s) - line(other)) / 2,
                      DIAMETER - np.linalg.norm(drawn(s) - drawn(other))))
    (angle, R, depth), spread = np.mean(found, axis=0), np.ptp(found, axis=0)
    smooth = min(2 * k**-0.75 / (2 * 2**0.5), DIAMETER / 4)  # over which contact sets in (world/contact.h)
    U = k * (2 * smooth**2 / 3 + (depth**2 - smooth**2) / 2) / 2
    return angle, R, k * depth, pull, M.mean(), U, spread


def plectoneme():
    for scene_ in PLIES:
        r = wind(*scene_)
        for j in (-3, -1):
            angle, R, p, T, M, U, spread = ply(r.shapes, j, scene_[0], scene_[-1])
            law = wound(angle)
            print(f"| plectoneme, angle {angle:.5f} (all along the middle to {spread[0]:.0e}), pressed in by "
                  f"{1 - 2 * R / DIAMETER:.1%}, U/T {U / T:.1e}: T R^2/B {(T + U) * R**2:.8f}, M R/B {M * R:.8f}, "
                  f"p R^3/B {p * R**3:.8f} | {(T + U) * R**2 / law[0] - 1:.1e}, {M * R / law[1] - 1:.1e}, "
                  f"{p * R**3 / law[2] - 1:.1e} | {r.steps} |", flush=True)


def heavy():
    for part, time, cells, k in ((0.999, 20, 120, 1e6), (0.9995, 20, 240, 1e7), (1.001, 0.1, 120, 1e6)):
        r = ropes.heavy_rope(part, time, "-ts_rtol 1e-6 ", cells=cells, stiffness=k)
        moved = np.abs(r.shapes["x"][-1] - r.shapes["x"][len(r.shapes["x"]) // 2]).max()
        print(f"| heavy rope, {part} of {ropes.overhang(100, 1):.6f} | in the second half by {moved:.1e} | {r.steps} |",
              flush=True)


# Diameter, tails, how long strands meet; cells and contact's stiffness. The first ones are pulled tight, the others at rest.
KNOTS = ((0.02, 4, 2.2, 400, None), (0.01, 2.6, 4, 420, 5e6), (0.01, 2.6, 4, 720, 1.6e7), (0.005, 2.6, 4, 600, 1.2e7),
         (0.005, 2.6, 4, 900, 4e7), (0.0025, 2.6, 4, 840, 3e7), (0.0025, 2.6, 4, 1200, 1e8), (0.00125, 2.6, 4, 1200, 8e7),
         (0.00125, 2.6, 4, 1600, 2.5e8))


def knot():
    """The pull of knots, and what their strands press in all, which is what friction between them takes: led on to
    rigid strands, by how deep two of each diameter are pressed in, and to a rod without thickness."""
    found = {}
    for number, (D, tail, longer, cells, k) in enumerate(KNOTS):
        tight, rest = number < 2, 0.2 if D > 0.002 else 0.1
        shape, way = (Path(scene.SCRATCH) / f"knot.{kind}" for kind in ("h5", "csv"))
        length, apart = overhand(shape, diameter=D, tail=tail, longer=longer)
        way.write_text(f"t,x1\n0,{apart}\n{rest},{apart}\n2,{apart + 1.2}\n")
        r = ropes.Run(f"-growth_type none -growth_initial_length {length} -shape_type file -shape_file {shape} "
                      f"-tip_type clamped -tip_path {way} -contact_diameter {D} -contact_self true -friction_mu 0 "
                      f"-friction_layers 0:{1e-3 if k else 1e-4} -ts_rtol 1e-3 -ts_max_time {2 if tight else rest} "
                      f"-output_interval {rest} -rod_cells {cells} " + (f"-contact_stiffness {k}" if k else ""))
        for t, x, n, q in zip(*(r.shapes[name][1:] for name in ("t", "x", "force", "d1"))):
            R = (length - np.linalg.norm(x[-1])) / (2 * np.pi)
            e, depth = np.sqrt(D / 2 / R), np.interp(t, r.t, r.penetration) / D
            T, other, P = (n[0] * q[0]).sum() * R**2, (n[-1] * q[-1]).sum() * R**2, np.interp(t, r.t, r.contact_force) * R**2 * e
            if k and t < 1.5 * rest:
                found.setdefault(D, []).append((e, depth, T, P))
            print(f"| knot, D {D:g}, {cells} cells, e = sqrt(h/R) = {e:.5f} | T R^2/B = {T:.5f}, {other:.5f}; pressed by {P:.5f} "
                  f"B/(R^2 e), in by {depth:.2%} | {r.steps} |", flush=True)
    e, T, P = np.transpose([(a[0], *(b[j] + (b[j] - a[j]) * b[1] / (a[1] - b[1]) for j in (2, 3)))
                            for a, b in found.values()])
    for degree, part in ((3, slice(None)), (2, slice(0, 3)), (2, slice(1, 4))):
        print("| loose limits | {:.4f} for 1/2, {:.4f} for 0.492 | |".format(
            *(np.polynomial.Polynomial.fit(e[part], v[part], degree)(0) for v in (T, P))), flush=True)


def main():
    scene.TENDRIL = str(Path(sys.argv[1]).resolve())
    with tempfile.TemporaryDirectory() as scene.SCRATCH:
        for name in sys.argv[2:] or ("pillar", "helix", "upheaval", "heavy", "plectoneme", "knot"):
            globals()[name]()


if __name__ == "__main__":
    main()

#!/usr/bin/env python3
"""Random rods in space by a program that shares nothing with tendril: its unknowns are the strains, turned into
directors and places by integration on Gauss-Legendre panels, Radau IIA of order 5 takes them through time, and its
derivatives are complex steps. On two meshes, so that its own error is known, and beside it tendril's.

    strains.py TENDRIL [--seed SEED] [--scenes COUNT] [--references] [-- OPTIONS]

--references: the scenes of tests/reference/s_*.json, against these. What follows a word -- is given to tendril, too."""

import argparse
import json
import subprocess
import sys
import tempfile
from pathlib import Path

import h5py
import numpy as np

BETA = 1e-3
A = np.array([[(88 - 7 * 6 ** .5) / 360, (296 - 169 * 6 ** .5) / 1800, (-2 + 3 * 6 ** .5) / 225],
              [(296 + 169 * 6 ** .5) / 1800, (88 + 7 * 6 ** .5) / 360, (-2 - 3 * 6 ** .5) / 225],
              [(16 - 6 ** .5) / 36, (16 + 6 ** .5) / 36, 1 / 9]])  # Radau IIA
STAGES, INVERSE = A.sum(1), np.linalg.inv(A)


def cross(a, b):
    return np.stack([a[..., 1] * b[..., 2] - a[..., 2] * b[..., 1], a[..., 2] * b[..., 0] - a[..., 0] * b[..., 2],
                     a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0]], -1)


class Mesh:
    """Nodes s, and the integrals up to them and over all."""

    def __init__(self, panels, order):
        z, w = np.polynomial.legendre.leggauss(order)
        z, w = (z + 1) / 2, w / 2
        powers = np.arange(order)
        inner = (z[:, None] ** (powers + 1) / (powers + 1)) @ np.linalg.inv(z[:, None] ** powers)
        h, n = 1 / panels, panels * order
        self.h, self.panels, self.order, self.inner, self.w1 = h, panels, order, inner * h, w * h
        self.s = (np.arange(panels)[:, None] * h + h * z).ravel()
        self.w = np.tile(w * h, panels)
        self.upto = np.zeros((n, n))
        for p in range(panels):
            rows = slice(p * order, (p + 1) * order)
            self.upto[rows, :p * order] = self.w[:p * order]
            self.upto[rows, rows] = inner * h
        self.behind = self.w - self.upto  # from a node to the end

    def directors(self, y):
        """Rotations at the nodes and the end for turns y per label, by collocation of the quaternion."""
        q, p, order = [], np.array([1., 0, 0, 0]), self.order
        for panel in range(self.panels):
            a, b, c = y[panel * order:(panel + 1) * order].T / 2
            zero = np.zeros(order)
            turn = np.array([[zero, -a, -b, -c], [a, zero, c, -b], [b, -c, zero, a], [c, b, -a, zero]])  # p (0, y/2)
            system = np.eye(4 * order) - np.einsum("kl,ijl->kilj", self.inner, turn).reshape(4 * order, 4 * order)
            inside = np.linalg.solve(system, np.tile(p, order)).reshape(order, 4)
            q.append(inside)
            p = p + np.einsum("l,ijl,lj->i", self.w1, turn, inside)
            p /= np.linalg.norm(p)
        q = np.concatenate([*q, [p]])
        q /= np.linalg.norm(q, axis=1)[:, None]
        a, b, c, d = q.T
        return np.array([[a * a + b * b - c * c - d * d, 2 * (b * c - a * d), 2 * (b * d + a * c)],
                         [2 * (b * c + a * d), a * a - b * b + c * c - d * d, 2 * (c * d - a * b)],
                         [2 * (b * d - a * c), 2 * (c * d + a * b), a * a - b * b - c * c + d * d]]).transpose(2, 0, 1)


class Rod:
    """o: mu, L0, feed, C, B3, u0 (twist, bends), e2, e3, across, weight, force, torque"""

    def __init__(self, mesh, **o):
        self.mesh, self.o = mesh, o
        self.S = np.array([o["C"], 1, o["B3"]])

    def begin(self):
        """Strains at the start. What turns a section about its tangent moves no place and costs no friction: sections turn
        at once, by psi, until moments about the tangent are in balance."""
        mesh, s, o = self.mesh, self.mesh.s, self.o
        shape = 3 * (1 - s) ** 2 / o["L0"]
        u = np.array(o["u0"]) + np.stack([0 * s, o["e2"] * (1 - 1.5 * s) * shape, o["e3"] * shape], -1)

        def turned(slope):
            psi = (slope @ mesh.upto.T) * o["L0"]
            c, d = np.cos(psi), np.sin(psi)
            return np.stack([u[:, 0] + slope, c * u[:, 1] + d * u[:, 2], c * u[:, 2] - d * u[:, 1]], -1)

        def off(slope):
            now = turned(slope)
            m = self.S * (now - np.array(o["u0"]))
            return m[..., 0] - o["torque"] - o["L0"] * (now[..., 1] * m[..., 2] - now[..., 2] * m[..., 1]) @ mesh.behind.T
        slope, unit = np.zeros(len(s)), np.eye(len(s))
        for _ in range(20):
            slope = slope - np.linalg.solve(off(slope + 1e-30j * unit).imag.T / 1e-30, off(slope))
        return o["L0"] * turned(slope)

    def moments(self, R, z, g):
        """m in the body, for directors and rates of turn; R: [..., node and end, 3, 3]"""
        mesh, o, d1 = self.mesh, self.o, R[..., :-1, :, 0]
        omega = mesh.upto @ np.einsum("...kij,...kj->...ki", R[..., :-1, :, :], z)
        v = mesh.upto @ (d1 + g * cross(omega, d1))
        if o["feed"]:
            v = v + (1 - mesh.s)[:, None] * d1
        along = (v * d1).sum(-1)[..., None]
        drag = 1 - o["mu"] + o["mu"] / np.sqrt((v * v).sum(-1) + BETA)[..., None]
        load = drag * (o["across"] * v + (1 - o["across"]) * along * d1) - np.array(o["weight"])
        n = np.array(o["force"]) - g * (mesh.behind @ load)
        m = o["torque"] * R[..., -1:, :, 0] + g * (mesh.behind @ cross(d1, n))
        return np.einsum("...kij,...ki->...kj", R[..., :-1, :, :], m)

    def residual(self, t, y, z):
        g = self.o["L0"] + t
        R = self.mesh.directors(y)
        return self.moments(R, z, g) - self.S * (y / g - np.array(self.o["u0"])), R

    def slopes(self, t, R, z):
        """By y, directors following as they turn; by z."""
        mesh, g, n = self.mesh, self.o["L0"] + t, 3 * len(self.mesh.s)
        unit = np.eye(n).reshape(n, -1, 3)
        turned = np.einsum("kij,bkj->bki", R[:-1], unit)
        phi = np.concatenate([mesh.upto @ turned, (mesh.w @ turned)[:, None]], 1)
        dR = np.stack([cross(phi, R[None, ..., c]) for c in range(3)], -1)
        step = 1e-30j
        by_y = self.moments(R + step * dR, z, g).imag / 1e-30 - self.S / g * unit
        by_z = self.moments(np.broadcast_to(R, (n, *R.shape)), z + step * unit, g).imag / 1e-30
        return by_y.reshape(n, n).T, by_z.reshape(n, n).T

    def residuals(self, t, h, y, stages):
        z = np.einsum("ij,jkl->ikl", INVERSE, stages - y) / h
        found = [self.residual(t + c * h, here, rate) for c, here, rate in zip(STAGES, stages, z)]
        return np.array([r.ravel() for r, _ in found]), [R for _, R in found], z

    def step(self, t, h, y, rates):
        """y at t + h and the rates there, by Newton's method, damped where its steps do not lessen the residual; None
        where it does not converge."""
        n = y.size
        stages = np.array([y + (0 if rates is None else h * c * rates) for c in STAGES])
        r, R, z = self.residuals(t, h, y, stages)
        for _ in range(40):
            J = np.zeros((3, n, 3, n))
            for i in range(3):
                by_y, by_z = self.slopes(t + STAGES[i] * h, R[i], z[i])
                for j in range(3):
                    J[i, :, j] = INVERSE[i, j] / h * by_z + (i == j) * by_y
            change, part = -np.linalg.solve(J.reshape(3 * n, 3 * n), r.ravel()).reshape(stages.shape), 1.
            while True:
                there = self.residuals(t, h, y, stages + part * change)
                if np.abs(there[0]).max() < np.abs(r).max() or np.abs(change).max() < 1e-7 or part < 1e-3:
                    break
                part /= 2
            stages, (r, R, z) = stages + part * change, there
            if part == 1 and np.abs(change).max() < 1e-11:
                return stages[2], z[2]
        return None

    def run(self, end, grow, most):
        t, h, y, rates = 0, 1e-7, self.begin(), None
        while t < end * (1 - 1e-12):
            h = min(h, end - t)
            done = self.step(t, h, y, rates)
            if not done:
                h /= 8
                if h < 1e-14:
                    raise RuntimeError(f"no convergence at t = {t}")
                continue
            y, rates = done
            t, h = t + h, min(h * grow, most)
        return self.observe(t, y)

    def observe(self, t, y):
        mesh, g = self.mesh, self.o["L0"] + t
        R = mesh.directors(y)
        x = mesh.upto @ (g * R[:-1, :, 0])
        strain = y / g - np.array(self.o["u0"])
        return {"tip": g * mesh.w @ R[:-1, :, 0], "norm_x2": (mesh.w @ x[:, 1] ** 2) ** .5, "norm_x3": (mesh.w @ x[:, 2] ** 2) ** .5,
                "energy": g / 2 * mesh.w @ (strain ** 2 @ self.S), "length": g}


def tendril(program, o, end, file, more=()):
    """The same rod by tendril."""
    shape = Path(file).with_suffix(".shape.h5")
    s = np.linspace(0, 1, 401)
    with h5py.File(shape, "w") as f:
        f["s"] = s
        f["u3"] = o["e3"] * 3 * (1 - s) ** 2 / o["L0"]
        f["u2"] = o["e2"] * (1 - 1.5 * s) * 3 * (1 - s) ** 2 / o["L0"]
    words = {"growth_type": "feed" if o["feed"] else "uniform", "growth_initial_length": o["L0"], "friction_mu": o["mu"],
             "friction_across": o["across"], "rod_torsion": o["C"], "rod_bend_ratio": o["B3"], "rod_twist": o["u0"][0],
             "rod_curvature_2": o["u0"][1], "rod_curvature": o["u0"][2], "shape_type": "file", "shape_file": shape,
             "rod_weight": ",".join(map(repr, o["weight"])), "tip_force_vector": ",".join(map(repr, o["force"])),
             "tip_torque": o["torque"], "rod_model": "space", "rod_cells": 200, "ts_rtol": 1e-8, "ts_max_time": end, "output": file}
    command = [program, *(str(w) for k, v in words.items() for w in (f"-{k}", v)), *more]
    done = subprocess.run(command, capture_output=True, text=True)
    if done.returncode:
        raise RuntimeError(f"{' '.join(command)}: {done.stderr}")
    with h5py.File(file) as f:
        last = {k: float(f["series"][k][-1]) for k in ("tip_x1", "tip_x2", "tip_x3", "norm_x2", "norm_x3", "energy", "length")}
    return last | {"tip": np.array([last[f"tip_x{k}"] for k in (1, 2, 3)])}


def off(a, b):
    """Of the tip over the length; of norms; of the energy."""
    return (np.linalg.norm(np.array(a["tip"]) - b["tip"]) / b["length"],
            max(abs(a[k] / b[k] - 1) for k in ("norm_x2", "norm_x3")), abs(a["energy"] / b["energy"] - 1))


REST = {"across": 1, "weight": [0., 0., 0.], "force": [0., 0., 0.], "torque": 0., "u0": [0., 0., 0.], "feed": False,
        "C": 0.75, "B3": 1., "e2": 0.1, "e3": 0.1, "mu": 1., "L0": 1.}
KNOWN = {"s_bent": REST | {"L0": 2., "C": 1.},
         "s_helix": REST | {"mu": .6, "e2": 0, "e3": 0, "u0": [.3, .1, .4], "B3": 1.5},
         "s_weight": REST | {"mu": .5, "feed": True, "e2": 0, "C": .7, "across": 2, "weight": [0., -.3, -.2]},
         "s_tip": REST | {"mu": .3, "e2": 0, "C": .7, "force": [0., .03, .05], "torque": .3}}


def random_rod(dice):
    u = lambda a, b: round(float(dice.uniform(a, b)), 3)
    o = REST | {"mu": u(0, 1), "L0": u(.7, 2), "feed": bool(dice.random() < .5), "C": u(.4, 1.5), "e2": u(-.2, .2), "e3": u(-.2, .2)}
    if dice.random() < .5:
        o |= {"u0": [u(-.5, .5) for _ in range(3)]}
    if dice.random() < .5:
        o |= {"B3": u(.5, 2)}
    if dice.random() < .5:
        o |= {"across": u(.5, 2.5)}
    if dice.random() < .5:
        o |= {"weight": [u(-.3, .3) for _ in range(3)]}
    if dice.random() < .5:
        o |= {"force": [u(-.06, .06) for _ in range(3)], "torque": u(-.4, .4)}
    return o, u(.5, 1.5)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--scenes", type=int, default=10)
    parser.add_argument("--references", action="store_true")
    words = sys.argv[1:]
    more = words[words.index("--") + 1:] if "--" in words else []
    choice = parser.parse_args(words[:len(words) - len(more) - bool(more)])
    scenes = [(f"{choice.seed}.{k}", *random_rod(np.random.default_rng([choice.seed, k])), None) for k in range(choice.scenes)]
    if choice.references:
        lines = {name: json.loads((Path(__file__).parents[2] / f"tests/reference/{name}.json").read_text().splitlines()[-1])
                 for name in KNOWN}
        scenes = [(name, o, lines[name]["t"], lines[name]) for name, o in KNOWN.items()]
    lost = 0
    for name, o, end, known in scenes:
        with tempfile.TemporaryDirectory() as place:
            it = tendril(choice.program, o, end, f"{place}/run.h5", more)
        try:
            coarse, fine = Rod(Mesh(4, 6), **o).run(end, 1.4, .05), Rod(Mesh(5, 7), **o).run(end, 1.25, .03)
        except RuntimeError as error:
            print(name, "no reference:", error, o, flush=True)
            continue
        far = off(it, known or fine)
        lost += not (far[0] < 1e-6 and max(far[1:]) < 1e-5)
        print(name, "t", end, "tendril off by (tip, norms, energy)", *(f"{e:.1e}" for e in far), "; two meshes of this program apart by",
              *(f"{e:.1e}" for e in off(coarse, fine)), *(("; it is off by", *(f"{e:.1e}" for e in off(fine, known))) if known else ()),
              "" if known else {k: v for k, v in o.items() if v != REST[k]}, flush=True)
    return lost > 0


if __name__ == "__main__":
    sys.exit(main())

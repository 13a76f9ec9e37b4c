#!/usr/bin/env python3
"""Rods within round tubes, against exact answers.

    in_tube_test.py build/tendril [--mpiexec mpiexec] CHECK...      (no CHECK: all of them)"""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "support"))
import scene  # takes .venv's python if this one lacks numpy and h5py
from scene import Run, check, expect, tip_in_space, walls

import h5py
import numpy as np
from scipy.interpolate import CubicSpline


def helix(cells, more="", r=0.5, k=1.0, begun=0.9, length=24, D=0.05):
    """A weightless rod in a smooth tube, pushed by P = 2 k^2 cos(alpha) at its tip, sin(alpha) = r k: in its middle,
    some lengths 1/k from either end, it is the helix that turns by k per length. It starts as one that turns by
    `begun`, clamped at that one's angle. Returns the run, and relative errors."""
    angle, P = np.arcsin(r * begun), 2 * k**2 * np.sqrt(1 - (r * k)**2)
    s = np.linspace(0, 1, 2001)
    bend, turn = np.sin(angle)**2 / r, np.sin(angle) * np.cos(angle) / r * length
    file = Path(scene.SCRATCH) / "helix.h5"
    with h5py.File(file, "w") as f:
        f["s"], f["u1"], f["u2"], f["u3"] = s, 0 * s, bend * np.cos(turn * s), -bend * np.sin(turn * s)
    run = Run(f"-growth_type none -growth_initial_length {length} -ts_rtol 1e-5 -friction_mu 0 -rod_cells {cells} "
              f"-shape_type file -shape_file {file} -contact_diameter {D} -ts_max_time 1e5 -output_shapes 1 "
              f"-clamp_direction {np.cos(angle):.17g},{np.sin(angle):.17g},0 -tip_force_vector {-P:.17g},0,0 "
              + walls(f"cylinder 0 0 {-r} 1 0 0 {r + D / 2} inside") + more)
    x, d, n, push = (run.shapes[name][-1] for name in ("x", "d1", "force", "contact"))
    j, w, h = cells // 2, 4, length / cells
    R, cosine = np.hypot(x[j, 1], x[j, 2] + r), d[j, 0]
    turns = np.hypot(*d[j, 1:]) / R
    # what the wall takes of the force between two nodes: N, whose direction turns
    N = np.hypot(*(n[j + w] - n[j - w])[1:]) * turns / (2 * np.sin(turns * w * h))
    return run, {"k": turns / k - 1, "P of its k": P / (2 * turns**2 * cosine) - 1, "N of its k": N / (R * turns**4) - 1,
                 "N": N / (r * k**4) - 1, "N at a node": np.hypot(*push[j, 1:]) / (r * k**4) - 1, "radius": R / r - 1}


@check
def a_helix_in_a_tube_bears_the_exact_thrust():
    """P = 2 B k^2 cos(alpha), N = B r k^4, exact at any slope; here 30 degrees. What the wall gives way by goes with the
    rod's diameter: of one that is 1/25 of the clearance, with the usual cells, N is right to 1e-4. (The 240 cells are four times
    as long as the layer of contact.)"""
    for more, bounds in (({"cells": 240}, {"k": 1e-4, "P of its k": 3e-4, "N of its k": 6e-4, "N": 3e-4, "N at a node": 2e-3,
                                           "radius": 2e-4}),
                         ({"cells": 500, "D": 0.02}, {"k": 1e-4, "P of its k": 3e-5, "N of its k": 6e-5, "N": 1e-4})):
        run, off = helix(**more)
        print(f"{run.steps} steps, " + ", ".join(f"{name} {e:.1e}" for name, e in off.items()))
        for name, bound in bounds.items():
            expect(abs(off[name]) < bound, f"{name} is off by {off[name]:.1e}")


def lying(P, shape, length, r=0.05, k=1e5, D=0.1, cells=250, friction=0, more=""):
    """A heavy rod that lies straight in a tube, between a clamp and a guide that presses it by P, in units in which
    w/r = B = 1; shape: x2 over s, small, or (s, strain). The wall gives way by its own law until it bears the weight;
    the tube is as much wider, so that the rod lies r from its axis."""
    file = Path(scene.SCRATCH) / "lying.h5"
    with h5py.File(file, "w") as f:
        if callable(shape):
            s, h = np.linspace(0, 1, 2001), 1e-4
            x2 = np.array([shape(s + h), shape(s), shape(s - h)])
            x3 = x2**2 / (r + np.sqrt(r**2 - x2**2))  # on the wall
            f["s"], f["u3"], f["u2"] = s, *(sign * (x[0] - 2 * x[1] + x[2]) / (h * length)**2
                                            for sign, x in ((1, x2), (-1, x3)))
        else:
            f["s"], (f["u1"], f["u2"], f["u3"]) = shape[0], shape[1].T
    smooth = min(2 * max(P, r**(2 / 3)) * k**-0.75 / np.sqrt(8), 0.01 * D)
    gap = smooth * (1 - 2 * np.sqrt(r / (k * smooth)))
    return Run(f"-growth_type none -growth_initial_length {length:.17g} -ts_rtol 1e-5 -friction_mu 0 -rod_cells {cells} -shape_type file "
               f"-shape_file {file} -tip_type slides -tip_force {P:.17g} -rod_weight 0,0,{-r} -contact_diameter {D} "
               f"-contact_stiffness {k} -output_shapes 1 "
               + walls(f"cylinder 0 0 {r} 1 0 0 {r + D / 2 + gap:.17g} inside friction {friction}") + more)


def bisect(f, a, b):
    for _ in range(60):
        middle = (a + b) / 2
        a, b = (middle, b) if f(a) * f(middle) > 0 else (a, middle)
    return (a + b) / 2


def fastest(P, length, odd):
    """The largest rate of y'''' + P y'' + (1 + rate) y = 0 with clamped ends, and its wave numbers."""
    def numbers(rate):
        root = np.sqrt(P * P / 4 - 1 - rate)
        return np.sqrt(P / 2 + root), np.sqrt(P / 2 - root)

    def condition(rate):
        (a, b), half = numbers(rate), length / 2
        if odd:
            return b * np.sin(a * half) * np.cos(b * half) - a * np.cos(a * half) * np.sin(b * half)
        return b * np.cos(a * half) * np.sin(b * half) - a * np.sin(a * half) * np.cos(b * half)

    rates = P * P / 4 - 1 - np.linspace(1e-9, 1, 4001)
    values = condition(rates)
    i = np.flatnonzero(values[1:] * values[:-1] < 0)[0]
    rate = bisect(condition, rates[i + 1], rates[i])
    return rate, *numbers(rate)


def threshold(length, odd=True):
    return bisect(lambda P: fastest(P, length, odd)[0], 2.0001, 2.5)


def sinus(waves, P, end, cells=250, more=""):
    """A sinus of about so many waves grows from 1e-6: how far P is off that which grows so fast, over
    2 sqrt(B w/r), the shape from that of the exact one, and the mean wave length, away from the ends."""
    length = 2 * np.pi * waves
    run = lying(P, lambda s: 1e-6 * np.sin(np.pi * s)**2 * np.sin(length * (s - 0.5)), length, cells=cells,
                more=f"-ts_max_time {end} " + more)
    late = run.t > 0.6 * end
    exact, a, b = fastest(P, length, True)
    force = (np.polyfit(run.t[late], np.log(run.norm_x2[late]), 1)[0] - exact) / P
    z, x = length * (run.shapes["s"] - 0.5), run.shapes["x"][-1, :, 1]
    mode = np.sin(a * z) * np.sin(b * length / 2) - np.sin(b * z) * np.sin(a * length / 2)
    wave, exact_wave = (np.diff(CubicSpline(z, y).roots(extrapolate=False)[2:-2]).mean() for y in (x, mode))
    return run, force, np.abs(x * (x @ mode) / (x @ x) - mode).max() / np.abs(mode).max(), wave / exact_wave - 1


@check
def a_heavy_rod_leaves_the_bottom_of_a_tube_as_a_wave():
    """A heavy rod that lies in a tube leaves its bottom as a wave at P = 2 sqrt(B w/r), wave length
    2 pi (B r/w)^(1/4); here one of four waves, whose ends are clamped: exactly at 2.0615654, and as fast as that."""
    run, force, shape, wave = sinus(4, 2.08, 40, cells=160)
    print(f"from {threshold(8 * np.pi):.7f} on: {run.steps} steps, force off by {force:.1e}, shape by {shape:.1e}, "
          f"wave length by {wave:.1e}")
    expect(run.norm_x2[-1] > 1.5 * run.norm_x2[0], "does not grow")
    expect(abs(force) < 1e-5 and shape < 1e-2 and abs(wave) < 1e-3, f"{force}, {shape}, {wave}")


INJECTED = "-options_file options/injected-tube.opts "


@check
def a_straight_injected_rod_is_pushed_by_its_friction():
    """A rod that is fed into a lying tube is pushed by mu w L while it is straight, and leaves the bottom above 2; one
    that is spun, too, climbs, is pushed less, and takes the torque, its slip being that of what twists as it comes."""
    mu, w, a, beta, viscous, rate, C = 0.5, 0.1, 0.05, 1e-6, 1e-4, 30, 0.75
    r = Run(INJECTED + "-rod_cells 100 -rod_curvature_random 1e-5 -ts_max_time 56")
    lies = (r.length > 8) & (r.base_force_1 < 1.9)  # shorter ones press harder, and walls are stiffer to them
    off = np.abs(r.base_force_1 / (r.length * (mu * w / np.sqrt(1 + beta) + viscous)) - 1)[lies].max()
    aside = [np.interp(P, r.base_force_1, r.norm_x2) for P in (1, 1.5, 2, 2.5)]
    print(f"{r.steps} steps, push off by {off:.1e}; aside with the push: {aside}")
    expect(off < 1e-6, f"push off by {off}")
    expect(aside[2] < 1e-4 and aside[3] > 5 * aside[2] and r.norm_x2[-1] > 1e-2, f"{aside}, {r.norm_x2[-1]}")
    r = Run(INJECTED + f"-rod_cells 100 -clamp_spin {rate} -ts_max_time 16")
    spin, slip, N = r.tip_spin[-1], np.hypot(1, a * r.tip_spin[-1]), r.contact_force[-1]
    twisted = spin / (rate - r.base_moment_1[-1] / C) - 1
    torque = r.base_moment_1[-1] / (mu * N * a**2 * spin / slip) - 1
    climb = -r.shapes["x"][-1, 50, 1] / (0.1 * np.sin(np.arctan(mu * a * spin / slip))) - 1
    print(f"spun: {r.steps} steps, spin off by {twisted:.1e}, torque {torque:.1e}, climbs {climb:.1e}")
    expect(max(map(abs, (twisted, torque))) < 1e-4 and abs(climb) < 1e-2, "spun")


def spun(lengths, mu=0.5, w=0.1, r=0.1, D=0.1, k=1e4, beta=1e-6, viscous=1e-4, rate=30, C=75):
    """The same rod, spun, too, and held at its clamp not on the bottom but as high as it climbs, where
    w sin(phi) = mu N a W/s: straight, along all of it, so that what it is pushed and turned by is exact. (It is stiff in
    twist, for what twists as it comes spins less, and climbs less.) Relative errors of push, torque, spin and pressure
    at the lengths, 5 and more."""
    def exact(length):
        spin = rate
        for _ in range(30):
            slip = np.sqrt(1 + (D / 2 * spin)**2 + beta)
            climb = np.arctan(mu * D / 2 * spin / slip)
            N = w * np.cos(climb) * length
            torque = mu * N * (D / 2)**2 * spin / slip
            spin = rate - torque / C
        return climb, np.array([mu * N / slip + viscous * length, torque, spin, N])

    climb, values = exact(lengths[-1])
    smooth = 2 * w**(2 / 3) * k**-0.75 / np.sqrt(8)  # of rods of 7 and more: a shorter one presses harder, by 10/L^2
    gap = smooth * (1 - 2 * np.sqrt(values[-1] / lengths[-1] / (k * smooth)))
    run = Run(f"-growth_type feed -growth_initial_length 4 -friction_mu 0 -friction_layers 0:{viscous} -friction_beta {beta} "
              f"-shape_type straight -rod_model space -rod_torsion {C} -rod_weight 0,0,{-w} -contact_diameter {D} "
              f"-contact_stiffness {k:g} -clamp_spin {rate} -rod_cells 100 -ts_rtol 1e-5 -ts_max_time {lengths[-1] - 3.9} "
              + walls(f"cylinder 0 {r * np.sin(climb):.17g} {r * np.cos(climb):.17g} 1 0 0 {r + D / 2 + gap:.17g} inside "
                      f"friction {mu}"))
    at = [np.argmax(run.length >= length) for length in lengths]
    return run, [np.array([run.base_force_1[i], run.base_moment_1[i], run.tip_spin[i], run.contact_force[i]])
                 / exact(run.length[i])[1] - 1 for i in at]


@check
def a_spun_rod_shares_its_friction():
    """What a rod that slides and turns in a lying tube is pushed and turned by: friction is shared."""
    run, off = spun((10, 20))
    print(f"{run.steps} steps, push, torque, spin, pressure off by", *(np.array2string(e, precision=1) for e in off))
    expect(np.abs(off[0]).max() < 6e-6 and np.abs(off[1]).max() < 1e-5, f"{off}")  # spin: its angle is held by its arm


@check
def a_bend_turned_about_its_axis_gives_the_same_rod():
    """A rod that is straight to the last digit is fed into a tube that bends: in the plane of x1 and x2, and turned about
    x1, the same rod. What is across begins with the wall's push, from nothing."""
    tips = []
    for angle in (0, 0.7):
        a = np.radians(np.arange(10, 91, 10))
        path = np.array([(-1, 0), (0, 0), (1, 0), (2, 0), *zip(2 + 2 * np.sin(a), 2 - 2 * np.cos(a)), (4, 3), (4, 4)])
        rows = [f"{x:.17g},{y * np.cos(angle):.17g},{y * np.sin(angle):.17g},0.15" for x, y in path]
        file = Path(scene.SCRATCH) / f"bend-{angle}.csv"
        file.write_text("x,y,z,r\n" + "\n".join(rows) + "\n")
        r = Run("-growth_type feed -growth_initial_length 0.5 -shape_type straight -contact_diameter 0.1 -rod_cells 60 "
                f"-ts_max_time 3 -friction_mu 0 -friction_layers 0:1e-3 "
                + walls(f"tube {file} inside friction 0.2"))
        print(f"turned by {angle}: {r.steps} steps, tip {r.tip}, {r.tip_x3[-1]}")
        tips.append(tip_in_space(r))
    off = np.abs(tips[1] - [tips[0][0], tips[0][1] * np.cos(0.7), tips[0][1] * np.sin(0.7)]).max()
    expect(tips[0][1] > 0.3 and off < 1e-6, f"{off}")


if __name__ == "__main__":
    sys.exit(scene.main())

#!/usr/bin/env python3
"""Random rods: what -task critical tells, against finer meshes and, where the rod is followed, a hundredth of the tolerance.

    fuzz_critical.py EXE SEED COUNT [--bent | --windows]

Straight rods over laws of growth, loads, held tips, a hinge, weight, layers, stiffness, few cells; --bent: rods in space that
something bends. --windows: rods that are unstable for a short time, 1/20000 of the search and more, which only a table in time
(growth, friction, the tip's force) tells of, against a look at every instant around it by elements or an angle of their own
(no mesh of tendril's). A time or length off by more than three times what is told, or told where the finer one has none,
is printed with its command; exit 1 if there is any."""

import re
import subprocess
import sys
import tempfile

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.linalg import eig
from scipy.optimize import brentq

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


def window(draw, search, rough):
    """Times and heights of a short bump of height 1 in a table: a bell, a smooth block; rough: also a peak of three rows, a
    block of a few; its middle and width."""
    width, mid = draw.over_decades(search / 20000, search / 50), draw.between(.1, .95) * search
    kind = draw.choice(["bell", "bell", "smooth", *(["peak", "block"] if rough else [])])
    if kind == "bell":
        z = np.linspace(-4, 4, draw.choice([41, 81, 400]))
        f = np.exp(-z ** 2)
    elif kind == "smooth":
        z = np.linspace(-2, 2, 161)
        f = (np.tanh((z + 1) / .1) - np.tanh((z - 1) / .1)) / 2
    elif kind == "peak":
        z, f = np.array([-1., 0, 1]), np.array([0., 1, 0])
    else:
        z, f = np.array([-1, -.9, -.5, 0, .5, .9, 1]), np.array([0., 1, 1, 1, 1, 1, 0])
    return mid + width * z, f, mid, width


class Bumpy:
    """A number over time, by rows between which it follows a spline: a constant with bumps, some with noise."""

    def __init__(self, draw, search, height, bumps, ends):
        rows, self.around = {}, []
        base = np.linspace(0, search, draw.choice([4, 21, 81, 400]))
        noise = draw.choice([0, 0, .01])
        for t in base:
            rows[t] = 1 + noise * draw.uniform(-1, 1)
        for _ in range(bumps):
            t, f, mid, width = window(draw, search, ends == "not-a-knot")
            if any(t[-1] > a and t[0] < b for a, b, _ in self.around) or t[0] <= 0 or t[-1] >= search:
                continue
            for gone in [x for x in rows if t[0] <= x <= t[-1]]:
                del rows[gone]
            h = height * draw.over_decades(.5, 6)
            rows.update(zip(t, 1 + h * f))
            self.around.append((t[0], t[-1], width))
        self.t = np.array(sorted(rows))
        self.spline = CubicSpline(self.t, [rows[x] for x in self.t], bc_type=ends)
        while ends == "clamped" and min(self.spline(np.linspace(0, search, 20001)).min(), self.spline(self.looks()).min()) < .02:
            self.spline = CubicSpline(self.t, 1 + .7 * (self.spline(self.t) - 1), bc_type=ends)  # it may not fall below 0

    def looks(self):
        """All of the bumps, and what splines swing beside them."""
        swing = 4 * np.diff(self.t).max()
        return np.concatenate([np.r_[np.linspace(a - swing, a, 161), np.linspace(a - 2 * w, b + 2 * w, 801),
                                     np.linspace(b, b + swing, 161)] for a, b, w in self.around] or [[0.]])


def windows(draw, files):
    """Options of a rod with short windows; what its length, its rate, N and the tip's force are over time."""
    search = draw.choice([10, 20, 40])
    mu, across = draw.choice([0, 0, 1]), draw.choice([1, 1, .6, 2])
    o = {"growth_type": "table", "friction_mu": mu, "friction_beta": 1e-6, "ts_max_time": search, "rod_cells": 200}
    if across != 1:
        o["friction_mu"] = mu = draw.choice([0, .3])
        o["friction_beta"] = 1e-2
        o["friction_across"] = across
    what = draw.choice(["growth", "friction", "tip"]) if mu < 1 else draw.choice(["friction", "tip"])
    L0, back = draw.between(.8, 1.2), draw.between(.001, .4) / search
    bumps = draw.choice([1, 1, 2])
    # the rod gives way at a thrust of some B/L^2 (viscous: L L'/2; dry: L); a tip that resists at about 2.5 B/L^2
    height = {"growth": 10 / back, "friction": 10 / back if mu < 1 else 8, "tip": 8}[what]
    bump = Bumpy(draw, search, height, bumps, "not-a-knot" if what == "growth" else "clamped")
    rate = bump.spline if what == "growth" else CubicSpline([0, search / 3, search / 2, search], [1, 1, 1, 1])
    t = bump.t if what == "growth" else np.linspace(0, search, 9)
    L = L0 + back * rate.antiderivative()(t)
    if what == "growth":
        height = 1
    s = np.linspace(0, 1, 5)
    o["growth_table"] = write(files + "-table.h5", s=s, t=t, g=np.repeat(L[:, None], 5, 1))
    length = CubicSpline(t, L)  # as tendril reads it
    one = lambda t: np.ones_like(t)
    while length(np.linspace(0, search, 2001)).min() < .3 or length(bump.looks()).min() < .3:
        L = 1 + .7 * (L - 1)
        o["growth_table"] = write(files + "-table.h5", s=s, t=t, g=np.repeat(L[:, None], 5, 1))
        length = CubicSpline(t, L)
    N = bump.spline if what == "friction" else one
    x = np.array([-1., 0, 1])
    if what == "friction":
        o["friction_field"] = write(files + "-field.h5", t=bump.t, x1=x, x2=x,
                                    factor=np.repeat(bump.spline(bump.t), 9).reshape(-1, 3, 3))
    force = lambda t: np.zeros_like(t)
    if what == "tip":
        o["tip_force"], o["tip_law"] = P, _ = draw.between(.2, 1), "resistance"
        o["tip_field"] = write(files + "-tip.h5", t=bump.t, x1=x, x2=x,
                               factor=np.repeat(bump.spline(bump.t), 9).reshape(-1, 3, 3))
        force = lambda t: P * bump.spline(t)
    rod = {"mu": mu, "beta": o["friction_beta"], "a": across, "length": length, "N": N, "force": force}
    return o, rod, np.unique(np.clip(np.concatenate([np.linspace(0, search, 2001), bump.looks()]), 0, search)), bump


def known(rod, t):
    """Length, its rate, friction and the tip's force at times."""
    return rod["length"](t), rod["length"](t, 1), rod["N"](t), rod["force"](t)


def pressed(rod, at, x):
    """phi, V and the compression at the parts x of the rod's length, at times of which that is known."""
    L, L_t, N, force = at
    V = x * L_t
    phi = 1 - rod["mu"] + rod["mu"] / np.sqrt(V ** 2 + rod["beta"])
    r = np.sqrt(L_t ** 2 + rod["beta"])
    G = lambda V: (1 - rod["mu"]) * V ** 2 / 2 + rod["mu"] * np.sqrt(V ** 2 + rod["beta"])  # of phi V
    with np.errstate(invalid="ignore", divide="ignore"):
        between = np.where(np.abs(L_t) > 1e-12, (G(L_t) - G(V)) / L_t, 0)
    return phi * N, V, force * L_t / r + L * N * between


def by_angle(rod, t):
    """Below 0 while a rod that is alike in all directions is stable: u'' + P u = 0 from the tip, where u' = 0, with
    u = r cos(a), u' = - r sin(a); it is critical once a is pi/2 at the clamp."""
    steps, a, at = 400, np.zeros_like(t), known(rod, t)
    slope = lambda a, x: at[0] * (np.sin(a) ** 2 + pressed(rod, at, x)[2] * np.cos(a) ** 2)
    h = 1 / steps
    for k in range(steps):
        x = 1 - k * h
        k1 = slope(a, x)
        k2 = slope(a + h / 2 * k1, x - h / 2)
        k3 = slope(a + h / 2 * k2, x - h / 2)
        a = a + h / 6 * (k1 + 2 * k2 + 2 * k3 + slope(a + h * k3, x - h))
    return a - np.pi / 2


def by_elements(rod, t, cells=24):
    """The largest real part of the modes' rates, of Hermite's cubics: a N phi y_t = -y_4 - (P y_1)_1 - (1 - a) N phi V y_1."""
    z, w = np.polynomial.legendre.leggauss(4)
    z, w = (z + 1) / 2, w / 2
    y = np.array([1 - 3 * z ** 2 + 2 * z ** 3, z - 2 * z ** 2 + z ** 3, 3 * z ** 2 - 2 * z ** 3, z ** 3 - z ** 2])
    y1 = np.array([6 * z ** 2 - 6 * z, 1 - 4 * z + 3 * z ** 2, 6 * z - 6 * z ** 2, 3 * z ** 2 - 2 * z])
    y2 = np.array([12 * z - 6, 6 * z - 4, 6 - 12 * z, 6 * z - 2])
    worst = np.empty_like(t)
    for i, now in enumerate(t):
        times = known(rod, np.full(4, now))
        L = float(rod["length"](now))
        h, n = L / cells, 2 * cells + 2
        K, D = np.zeros((n, n)), np.zeros((n, n))
        for c in range(cells):
            drag, V, P = pressed(rod, times, (c + z) / cells)
            at = np.ix_(range(2 * c, 2 * c + 4), range(2 * c, 2 * c + 4))
            K[at] += (-(y2 * w) @ y2.T / h ** 3 + (y1 * w * P) @ y1.T / h - (1 - rod["a"]) * (y * w * drag * V) @ y1.T)
            D[at] += h * rod["a"] * (y * w * drag) @ y.T
        r = np.sqrt(rod["length"](now, 1) ** 2 + rod["beta"])
        D[-2, -2] += rod["force"](now) / r
        worst[i] = eig(K[2:, 2:], D[2:, 2:], right=False).real.max()
    return worst


def truth(rod, looks):
    """The first time at which it is unstable; None: not at any."""
    level = by_angle if rod["a"] == 1 else by_elements
    f = level(rod, looks)
    first = np.argmax(f >= 0)
    if f[first] < 0:
        return None, f.max()
    if first == 0:
        return looks[0], f.max()
    return brentq(lambda t: level(rod, np.array([t]))[0], looks[first - 1], looks[first], xtol=1e-14, rtol=1e-15), f.max()


def look_for_windows(exe, seed, count):
    """1 if a critical time in a window was missed, or told wrong."""
    bad = missed = told = stable = 0
    scratch = tempfile.mkdtemp(prefix="fuzz-windows-")
    for k in range(count):
        draw = Draw(seed * 1000 + k)
        o, rod, looks, bump = windows(draw, f"{scratch}/{k}")
        if rod["a"] != 1:
            looks = np.unique(np.concatenate([looks[::20], bump.looks()[::4]]))
        right, most = truth(rod, looks)
        found, what, command = run(exe, o)
        wide = "widths " + " ".join(f"1/{o['ts_max_time'] / w:.0f}" for _, _, w in bump.around)
        if found is None and right == 0 and "already at t = 0" in what:
            mark = ""
        elif (found is None) != (right is None):
            mark = " BAD"
        elif found is None:
            mark, stable = "", stable + 1
        else:
            told += 1
            mark = " BAD" if abs(found[0] - right) > 3 * found[2] + 1e-6 * right else ""
        bad += mark != ""
        missed += right is not None and mark != ""
        print(f"{seed} {k}: {wide}: right {right} (at most {most:.3g}), told {found or what[:90]}{mark}"
              + (f"\n   {' '.join(command)}" if mark else ""), flush=True)
    print(f"{told} told, {stable} stable, {bad} bad, {missed} of these unstable")
    return bad > 0


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
    if "--windows" in flags:
        return look_for_windows(exe, int(seed), int(count))
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

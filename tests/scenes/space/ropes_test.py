#!/usr/bin/env python3
"""Ropes against exact answers: round a pillar, along a helical duct, heavy on a rough plane and over a pillar.

    ropes_test.py build/tendril CHECK...      (no CHECK: all of them)

scripts/lab/ropes.py runs the same scenes finer, for docs/notes/ropes-measured.md."""

import subprocess
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "support"))
sys.path.insert(0, str(Path(__file__).resolve().parents[3] / "scripts"))
import scene  # takes .venv's python if this one lacks numpy and h5py
from scene import Run, check, expect, walls

import h5py
import numpy as np
from scipy.integrate import solve_bvp, solve_ivp
from scipy.interpolate import CubicSpline
from scipy.linalg import expm
from scipy.optimize import brentq

from tendril.scene_data import overhand

MU = 0.3
ALONE = "-shape_type file -shape_file {} -friction_mu 0 -friction_layers 0:{:g} "


def numbers(values):
    return ",".join(repr(float(v)) for v in values)


def shape(**fields):
    """A file for -shape_file."""
    path = Path(scene.SCRATCH) / "shape.h5"
    with h5py.File(path, "w") as f:
        for name, values in fields.items():
            f[name] = values
    return path


class Line:
    """Of the last shape in space: thrust P and twisting moment over the arc length."""

    def __init__(self, r):
        last = {k: r.shapes[k][-1] for k in ("d1", "force", "moment", "stretch")}
        s, g = r.shapes["s"], last["stretch"]
        self.arc = np.append(0, np.cumsum(np.diff(s) * (g[1:] + g[:-1]) / 2))
        self.P = CubicSpline(self.arc, -(last["force"] * last["d1"]).sum(axis=1))
        self.M = CubicSpline(self.arc, (last["moment"] * last["d1"]).sum(axis=1))
        self.d1 = last["d1"]

    def turned(self, e, n):
        """The angle of its direction in the plane of e and n."""
        return CubicSpline(self.arc, np.unwrap(np.arctan2(self.d1 @ n, self.d1 @ e)))


def capstan(turns, pull, tilt, stiffness, cells, drag=0.01):
    """A rope that slides over a pillar of any direction: by how much the ratio of its tensions, two rope's radii
    and more from where it touches, is off e^(mu phi), phi what the rod itself has turned by between: it is held off,
    by up to a hundredth of D, where it is pressed less than usual. (What the ground bears, drag, is taken off.)"""
    D, lead, room = 0.1, 2, 0.005
    length = 2 * lead + 2 * np.pi * turns
    s = np.linspace(0, 1, 4001)
    bend = (np.tanh((s * length - lead) / 0.05) - np.tanh((s * length - length + lead) / 0.05)) / 2
    n, axis = np.array([0, np.cos(tilt), np.sin(tilt)]), np.array([0, -np.sin(tilt), np.cos(tilt)])
    end = np.cos(2 * np.pi * turns) * np.array([1, 0, 0]) + np.sin(2 * np.pi * turns) * n
    file = shape(s=s, u3=bend * n[1], u2=-bend * n[2])
    r = Run(f"-growth_type feed -growth_initial_length {length} -rod_cells {cells} -contact_diameter {D} "
            f"-contact_stiffness {stiffness} -friction_beta 1e-5 -ts_rtol 1e-5 -ts_max_time 0.3 "
            f"-tip_force_vector {numbers(pull * end)} " + ALONE.format(file, drag)
            + walls("cylinder " + " ".join(map(repr, map(float, [lead, *n[1:], *axis, 1 - D / 2 - room])))
                    + f" outside friction {MU}"))
    line, a, b = Line(r), lead + 1, length - lead - 1
    angle = line.turned(np.array([1, 0, 0]), n)
    phi = angle(b) - angle(a)
    bare = drag * (b - a) / phi / MU
    return r, (bare - line.P(b)) / (bare - line.P(a)) / np.exp(MU * phi) - 1


@check
def tension_round_a_pillar_is_eulers():
    """Euler's law to 1e-4 over a turn and a half, whichever way the pillar stands. (With k a tenth of that it is held off by
    0.3 % of D more where it leaves than where it is pulled, and winds outwards by that, which the law does not know: 3e-4.)"""
    for tilt in (0, 0.7):
        r, off = capstan(1.5, 60, tilt, 1e7, 160)
        print(f"turned by {tilt}: {r.steps} steps, ratio of tensions off by {off:.1e}")
        expect(abs(off) < 1e-4, f"turned by {tilt}: {off}")


def helix(length, straight=0.6, curved=22.5, exit_over=4):
    """A duct's path, straight, then a helix of curvature 0.75 and torsion 3^0.5/4, then straight: points every 0.1,
    the normals there, and the directions at the ends."""
    def bends(s):
        rise = lambda z: np.clip(z, 0, 1)**2 * (3 - 2 * np.clip(z, 0, 1))
        w = rise((s - straight) / 1.2) * (1 - rise((s - curved) / exit_over))
        return KAPPA * w, TAU * w

    def frame(s, y):
        (k, t), (q, n, b) = bends(s), y[3:].reshape(3, 3)
        return np.concatenate([q, k * n, t * b - k * q, -t * n])

    way = solve_ivp(frame, (0, length + 2), [0, 0, 0, *np.eye(3).ravel()], rtol=1e-11, atol=1e-12, dense_output=True)
    s = np.arange(0, length + 2, 0.1)
    before = np.arange(-1, 0, 0.1)
    x = np.concatenate([np.outer(before, [1, 0, 0]), way.sol(s)[:3].T])
    n = np.concatenate([np.tile([0, 1, 0], (len(before), 1)), way.sol(s)[6:9].T])
    return np.append(before, s), x, n, way.sol(length)[3:6]


KAPPA, TAU = 0.75, np.sqrt(3) / 4  # of a helix of radius 1 at 60 degrees to its axis


def duct(length, torque, pull, stiffness, cells, D=0.1, room=0.01, curved=22.5, exit_over=4, rtol=1e-5):
    """A rod is pushed through it, the rod's line, not the duct's, being that helix."""
    s, x, n, end = helix(length, curved=curved, exit_over=exit_over)
    x = x + room * n * (np.clip((s - 0.1) / 0.5, 0, 1)**2 * (3 - 2 * np.clip((s - 0.1) / 0.5, 0, 1)))[:, None]
    path = Path(scene.SCRATCH) / "duct.csv"
    np.savetxt(path, np.c_[x, np.full(len(s), D / 2 + room)], delimiter=",", header="x1,x2,x3,radius", comments="",
               fmt="%.12g")
    return Run("-growth_type feed -growth_initial_length 0.5 -shape_type straight -friction_mu 0 "
               f"-friction_layers 0:1e-9 -friction_beta 1e-12 -rod_cells {cells} -contact_diameter {D} "
               f"-contact_stiffness {stiffness} -ts_rtol {rtol} -ts_max_time {length - 0.5} -tip_torque {torque} "
               f"-tip_force_vector {numbers(pull * end)} " + walls(f"tube {path} inside friction {MU}"))


def helix_push(line, a, b):
    """Thrust at b, and what it should be by Q(b) = Q(a) exp(-mu kappa (b - a)), Q = P - B tau^2 + M tau."""
    Q = line.P(a) - TAU**2 + line.M(a) * TAU
    return line.P(b), Q * np.exp(-MU * KAPPA * (b - a)) + TAU**2 - line.M(b) * TAU


@check
def a_rod_laid_down_in_a_bent_duct_comes_to_rest():
    """A rod laid down along the bends of a rough duct, which is not at rest there: its first step goes far, and
    finds where it comes to rest. (By the modes that it counted beside rough walls, it crossed some, and gave up.)"""
    length, room, s = 8, 0.02, np.linspace(0, 1, 2001)
    turning = np.array([[0, KAPPA, 0, 0], [-KAPPA, 0, TAU, 0], [0, -TAU, 0, 0], [1, 0, 0, 0]])  # of axes, and place
    at = np.arange(-1.5, length + 1.5, 0.1)
    path = Path(scene.SCRATCH) / "bent.csv"
    np.savetxt(path, [[*(m[3] + room * m[1])[:3], 0.05 + room] for m in expm(at[:, None, None] * turning)],
               delimiter=",", header="x1,x2,x3,radius", comments="", fmt="%.15g")
    file = shape(s=s, u3=KAPPA * np.cos(TAU * s * length), u2=-KAPPA * np.sin(TAU * s * length))
    r = Run(f"-growth_type feed -growth_initial_length {length} -rod_cells 150 -contact_diameter 0.1 -ts_max_time 0.02 "
            + ALONE.format(file, 1e-9) + walls(f"tube {path} inside friction {MU}"))
    line = Line(r)
    P, want = helix_push(line, 1, 4.5)
    print(f"{r.steps} steps; P {line.P(1):.5f} -> {P:.6f}, by the law {want:.6f}, defect {r.energy_defect[-1]:.1e}")
    expect(abs(P / want - 1) < 3e-3 and r.energy_defect[-1] < 1e-5, f"{P}, {want}, {r.energy_defect[-1]}")


UPHEAVAL, HEIGHT, EXCESS = 80.762914226, 2.40679895e-3, 1.596999587e-5  # P L^2/B, h B/(w L^4), excess B^2/(w^2 L^7)


def upheaval(weight, stiffness, cells):
    """A heavy rod between two clamps on a plane, which a little excess length lifts off in the middle (Hobbs): P and
    height off, with L as the excess length says."""
    s, D = np.linspace(0, 1, 8001), 0.01
    x = 2 * s - 1
    file = shape(s=s, theta=np.where(abs(x) < 0.5, -2.52e-3 * np.pi * weight * np.sin(2 * np.pi * x), 0))
    r = Run(f"-growth_type none -growth_initial_length 2 -rod_cells {cells} -contact_diameter {D} -friction_mu 0 "
            f"-shape_type file -shape_file {file} -rod_weight 0,{-weight} -tip_type clamped -ts_max_time 5 "
            f"-contact_stiffness {stiffness} " + walls(f"plane 0 {-D / 2} 0 1"))
    x, theta, force = (r.shapes[k][-1] for k in ("x", "theta", "force"))
    arc = 2 * r.shapes["s"]
    y = CubicSpline(arc, x[:, 1])
    top = brentq(y.derivative(), 0.9, 1.1)
    excess = CubicSpline(arc, 1 - np.cos(theta)).integrate(0, 2)
    L = (excess / (EXCESS * weight**2))**(1 / 7)
    return r, -force[len(force) // 2, 0] * L**2 / UPHEAVAL - 1, y(top) / (HEIGHT * weight * L**4) - 1


@check
def a_pushed_pipe_lifts_off_as_hobbs_says():
    """Hobbs's upheaval, met to 1e-4 (what a slope of 0.01 is off the law for small ones is 1e-5)."""
    r, push, height = upheaval(1, 1e10, 800)
    print(f"{r.steps} steps; push off by {push:.1e}, height by {height:.1e}")
    expect(abs(push) < 1e-4 and abs(height) < 1e-4, f"{push}, {height}")


class Hanging:
    """What hangs of a heavy rope, length h, from a pillar of radius 1, stiffness and all: the angle, from the top,
    at which it leaves it, and its direction over the arc length."""

    def __init__(self, h, weight):
        l = (weight * h)**-0.5
        s = np.linspace(0, h, 300)
        found = solve_bvp(lambda s, y: [y[1], weight * (h - s) * np.cos(y[0])], lambda a, b: [a[1] + 1, b[1]], s,
                          [l * np.exp(-s / l) - np.pi / 2, -np.exp(-s / l)], tol=1e-10, max_nodes=100000)
        expect(found.success, found.message)
        self.leaves, self.direction = -found.sol(0)[0], lambda s: found.sol(s)[0]
        self.pull, self.press = weight * h * np.sin([self.leaves, np.pi / 2 - self.leaves])


def overhang(weight, h, mu=MU):
    """How much may hang on one side of a pillar if h does on the other: what touches is bent alike all along, so its
    shear is 0, friction is T' = mu (T + w cos phi) - w sin phi, and what hangs presses at a point where it leaves."""
    short = Hanging(h, weight)

    def more(long):
        other = Hanging(long, weight)
        way = solve_ivp(lambda p, T: mu * (T + weight * np.cos(p)) - weight * np.sin(p),
                        (-short.leaves, other.leaves), [short.pull + mu * short.press], rtol=1e-11, atol=1e-11)
        return way.y[0, -1] + mu * other.press - other.pull

    return brentq(more, h, 8 * h, xtol=1e-10)


def heavy_rope(part, time, more="", weight=100, cells=120, stiffness=1e6, drag=1):
    """A heavy rope over a pillar, both its ends free; of the overhang that friction bears just so, this part hangs."""
    D = 0.1
    a, b = Hanging(1, weight), Hanging(part * overhang(weight, 1), weight)
    ends = np.cumsum([1, a.leaves + b.leaves, part * overhang(weight, 1)])
    s = np.linspace(0, ends[2], 8001)
    psi = np.select([s < ends[0], s < ends[1]], [-a.direction(np.clip(1 - s, 0, 1)), a.leaves + 1 - s],
                    b.direction(np.clip(s - ends[1], 0, None)))
    line = CubicSpline(s, np.c_[np.cos(psi), np.sin(psi)]).antiderivative()
    middle = line(1) + [np.sin(a.leaves), -np.cos(a.leaves)]
    file = shape(s=s / ends[2], theta=psi - psi[0])
    return Run(f"-growth_type none -growth_initial_length {ends[2]} -clamp_type free -clamp_angle {float(psi[0])!r} "
               f"-rod_cells {cells} -contact_diameter {D} -contact_stiffness {stiffness} -rod_weight 0,{-weight} "
               f"-friction_beta 0 -ts_max_time {time} " + ALONE.format(file, drag) + more
               + walls(f"circle {numbers(middle)} {1 - D / 2} outside friction {MU}".replace(",", " ")))


@check
def a_heavy_rope_overhangs_by_what_friction_bears():
    """With 0.999 of the overhang that friction bears a heavy rope stays where it is for good, with 1.001 it runs
    off: exact stick, of a rod that nothing else holds."""
    for more in ("", "-rod_model space -friction_radius 0.05 "):
        r = heavy_rope(0.999, 20, "-ts_rtol 1e-6 " + more)  # what it moves by is its steps' error, 2e-7 with 1e-5
        x, late = r.shapes["x"], len(r.shapes["x"]) // 2
        settled, creeps = (abs(x[-1] - x[k]).max() for k in (0, late))
        print(f"holds: {r.steps} steps, settled by {settled:.1e}, in the second half by {creeps:.1e}")
        expect(settled < 2e-3 and creeps < 1e-7, f"{more}: {settled}, {creeps}")
    r = heavy_rope(1.001, 0.1)
    print(f"slides: {r.steps} steps, at {r.tip_speed[-1]:.2g}, by {-r.tip_x2[-1] + r.tip_x2[0]:.2g}")
    expect(r.tip_speed[-1] > 0.1 and r.tip_x2[0] - r.tip_x2[-1] > 0.01, f"{r.tip_speed[-1]}")


@check
def errors_of_a_rope_that_writhes_are_above_what_they_are():
    """A rope that is fed between clamps and spun until it writhes: what is told of |x2| and |x3| at its end is above what they differ
    by from those of twice the cells in contact 100 times as stiff (0.262950, 0.059133), and not far above. (It was 0.7 times that.)"""
    r = Run("-growth_type feed -growth_initial_length 1 -tip_type clamped -shape_type random -shape_amplitude 0.0267 -shape_seed 804 "
            "-rod_curvature_random 0.0686 -rod_curvature_random_2 0.0172 -friction_mu 0.2 -clamp_spin -12.23 -contact_diameter 0.09328 "
            "-rod_cells 40 -ts_max_time 1.223 -contact_friction 0 -friction_beta 0.001 -rod_model space -contact_self true")
    off = max(abs(r.norm_x2[-1] - 0.262950), abs(r.norm_x3[-1] - 0.059133)) / 0.262950
    print(f"{r.steps} steps, off by {off:.1e}, told {r.told['end_norm_x2']:.1e}")
    expect(off < r.told["end_norm_x2"] < 10 * off, f"off by {off}, told {r.told}")


@check
def an_overhand_knot_stays_one_and_is_pulled_alike():
    """An overhand knot that is pulled by its ends, frictionless: it stays one, its ends are pulled alike, the work at its
    tip is the rod's energy, and with R as the rod that is in it says, eps^2 = h/R, the pull is T R^2/B = 1/2 for loose
    ones: 1/2 + 0.4465 eps + 1.554 eps^2 by knots of two diameters and twice as fine (docs/notes/ropes-measured.md)."""
    D, d = 0.02, Path(scene.SCRATCH)
    length, apart = overhand(d / "knot.h5", diameter=D, tail=2.2)
    (d / "knot.csv").write_text(f"t,x1\n0,{apart}\n0.1,{apart}\n1,{apart + 0.8}\n")
    r = Run(f"-growth_type none -growth_initial_length {length} -tip_type clamped -tip_path {d}/knot.csv -rod_cells 200 "
            f"-contact_diameter {D} -contact_self -ts_rtol 1e-3 -ts_max_time 0.5 -output_interval 0.1 "
            + ALONE.format(d / "knot.h5", 1e-3))
    R = (length - np.linalg.norm(r.shapes["x"][1:, -1], axis=1)) / (2 * np.pi)
    T = [[(n[k] * q[k]).sum() for k in (0, -1)] for n, q in zip(r.shapes["force"][1:], r.shapes["d1"][1:])]
    first, eps = np.searchsorted(r.t, 0.1), np.sqrt(D / 2 / R)
    work = np.trapezoid(-r.base_force_1[first:], r.tip_x1[first:]) / (r.energy[-1] - r.energy[first])
    off = np.max(abs(np.array(T).mean(axis=1) * R**2 - 0.5 - 0.4465 * eps - 1.554 * eps**2))
    print(f"{r.steps} steps, R {R[0]:.3f} to {R[-1]:.3f}, T R^2/B off by {off:.1e}, work over energy {work:.5f}")
    coarse = subprocess.run([scene.TENDRIL, "-options_file", "knot.opts", "-rod_cells", "60", "-ts_max_time", "0.05"],
                            cwd=scene.ROOT / "docs/ropes", capture_output=True, text=True, env=scene.ENVIRONMENT).stderr
    expect(not coarse or "too long for contact" in coarse and "-friction_mu" not in coarse, f"too coarse: {coarse}")
    expect(off < 1.5e-3 and np.ptp(T, axis=1).max() < 4e-3 and abs(work - 1) < 5e-3, f"{off}, {work}, {T}")


if __name__ == "__main__":
    sys.exit(scene.main())

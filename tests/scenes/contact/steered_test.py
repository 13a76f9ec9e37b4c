#!/usr/bin/env python3
"""What is driven from outside: a rod that a schedule pushes in and pulls out, and natural curvature that is steered
over time, against exact answers and against what must hold always.

    steered_test.py build/tendril [--mpiexec mpiexec] CHECK...      (no CHECK: all of them)"""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "support"))
import scene  # takes .venv's python if this one lacks numpy and h5py
from scene import Run, broken, check, expect, tendril, walls

import h5py
import numpy as np
from scipy.interpolate import PchipInterpolator

EVEN = "-ts_adapt_type none -ts_dt 0.01 "
FED = "-growth_type feed -shape_type straight -rod_cells 20 "


def rows(name, **columns):
    """A table of columns over time, CSV."""
    path = Path(scene.SCRATCH) / f"{name}.csv"
    values = np.stack([np.asarray(v, float) for v in columns.values()], 1)
    np.savetxt(path, values, fmt="%.17g", delimiter=",", header=",".join(columns), comments="")
    return path


def steers(name, **arrays):
    """The option that steers by these arrays."""
    path = Path(scene.SCRATCH) / f"{name}.h5"
    with h5py.File(path, "w") as f:
        for key, values in arrays.items():
            f[key] = values
    return f"-rod_curvature_file {path} "


def pushed_in_and_pulled_out(more, ranks=1):
    """A straight rod is pushed in, held and pulled out: the force of its clamp is that of friction on all of it, which
    turns round with it, and vanishes with the speed."""
    t, v = [0, 1, 1.4, 2, 2.5, 3.5, 3.7], [1, 1, 0, 0, -1, -0.8, 0]
    speed = PchipInterpolator(t, v)
    path = rows("speed", t=t, speed=v)
    r = Run(FED + f"-growth_path {path} -growth_initial_length 0.5 -friction_mu 0.7 -friction_beta 1e-2 -ts_max_time 3.7 "
            "-ts_rtol 1e-9 " + more, ranks)
    V, L = speed(r.t), 0.5 + speed.antiderivative()(r.t)
    force = L * (0.7 * V / np.sqrt(V**2 + 1e-2) + 0.3 * V)
    off = [np.abs(r.length - L).max(), np.abs(r.base_force_1 - force)[1:].max(), np.abs(r.feed_force - force)[1:].max()]
    print(f"{more}{ranks} ranks: length off by {off[0]:.1e}, forces by {off[1]:.1e}, {off[2]:.1e}; {r.steps} steps")
    expect(off[0] < 1e-12 and max(off[1:]) < 1e-3 and np.median(np.abs(r.base_force_1 - force)) < 1e-7, f"{more}: {off}")
    expect(min(r.base_force_1) < -0.9 and abs(r.base_force_1[np.abs(V) < 1e-12]).max() < 1e-4, "it does not turn round")


@check(ranks=3)
def a_straight_rod_pushed_in_and_pulled_out_on_three_ranks_bears_its_friction():
    pushed_in_and_pulled_out("", 3)


@check
def a_straight_rod_pushed_in_and_pulled_out_bears_its_friction():
    """In the plane and in space. Friction takes what was put in: under dry friction L1^2 - L0^2 a loop."""
    for more in ("", "-rod_model space "):
        pushed_in_and_pulled_out(more)
    path = rows("length", t=[0, 1, 2, 3], length=[0.5, 1.5, 1.5, 0.5])
    r = Run(FED + f"-growth_path {path} -friction_beta 1e-10 -ts_max_time 3 " + EVEN)
    work = (np.diff(r.t) * (r.dissipation[1:] + r.dissipation[:-1]) / 2).sum()
    print(f"a loop takes {work:.6f}, its defect is {r.energy_defect.max():.1e}")
    expect(abs(work - 2) < 1e-3 and r.energy_defect.max() < 1e-3, f"{work}, {r.energy_defect.max()}")


@check
def a_rod_pushed_against_a_wall_is_pulled_off_it():
    """Pushed against a wall and pulled off it: at a length the wall pushes alike both ways, friction 2 N L apart."""
    path = rows("wall", t=[0, 1, 1.5, 2.5], length=[0.09, 0.0991, 0.0991, 0.09])
    for more in ("", "-rod_model space "):
        r = Run(FED + f"-growth_path {path} -friction_beta 1e-12 -ts_max_time 2.5 {EVEN}-contact_diameter 0.01 -contact_stiffness 1e6 "
                + walls("plane 0.104 0 0 -1 0 0" if more else "plane 0.104 0 -1 0") + more)
        wall, turned = -r.wall_force_1, r.t > 1.5
        sign = np.where(turned, -1, 1)
        moves = ((r.t < 1) | turned) & (r.t > 0.01) & (np.abs(r.t - 1.5) > 1e-3)
        off = np.abs(r.base_force_1 - wall - sign * r.length)[moves].max()
        push = wall > 1e-3
        back = np.interp(r.length[~turned & push & moves], r.length[turned][::-1], wall[turned][::-1])
        apart = np.abs(back - wall[~turned & push & moves]).max() / wall.max()
        print(f"{more}the wall pushes by {wall.max():.3f}; forces off by {off:.1e}, the wall's both ways by {apart:.1e}")
        expect(wall.max() > 1 and wall[-1] < 0.02 and off < 1e-4 and apart < 0.02, f"{off}, {apart}, {wall[-1]}")


def arc(k, L):
    """Where the tip of a rod of curvature k is, along the clamp and across."""
    return np.stack([np.sin(k * L) / k, (1 - np.cos(k * L)) / k], -1)


@check
def a_stiff_rod_is_bent_as_it_is_steered():
    """A short rod, against whose stiffness friction is nothing, is bent as it is steered: a circle at all times; while
    it is fed and pulled out, too, and about an axis that both bends make."""
    t, at = np.linspace(0, 1, 41), [0, 0.3, 0.6, 1]
    k = 100 + 150 * np.sin(3 * t)
    flat = np.repeat(k[:, None], 4, 1)
    fed = f"-growth_path {rows('short', t=[0, 0.4, 1], length=[0.006, 0.01, 0.007])} "
    for name, options, where in (("none", "-growth_type none -growth_initial_length 0.01 ", "s"), ("fed", FED + fed, "distance"),
                                 ("apical", "-growth_type apical -growth_zone 0.004 -growth_initial_length 0.01 ", "distance")):
        for space in (False, True):
            end = 0.005 if name == "apical" else 1
            steer = dict(curvature=0.6 * flat, curvature_2=0.8 * flat) if space else dict(curvature=flat)
            r = Run(options + "-friction_mu 0 -shape_type straight -rod_cells 20 -ts_rtol 1e-7 "
                    + steers(f"{name}", **{where: at}, t=t, **steer) + f"-ts_max_time {end}")
            exact = arc(100 + 150 * np.sin(3 * r.t), r.length)
            off = np.abs(r.tip_x1 - exact[:, 0]) + np.abs(r.tip_x2 - (0.6 if space else 1) * exact[:, 1])
            if space:
                off += np.abs(r.tip_x3 + 0.8 * exact[:, 1])
            print(f"{name}, {'space' if space else 'plane'}: off by {(off / r.length)[1:].max():.1e} of its length, {r.steps} steps")
            expect((off / r.length)[1:].max() < 2e-5, f"{name}: {off.max()}")


@check
def waves_of_curvature_swim_at_the_speed_of_small_waves():
    """Waves of natural curvature along a free rod in drag that is twice as strong across: it swims against them, at
    the speed that small waves have, U/A^2 = (a - 1) <y_t y'>/A^2 (second order in A: by 1e-4 here)."""
    A, k, w, L, a = 0.02, 3, 2, 4, 2
    period, n = 2 * np.pi / w, 8
    t, s = np.linspace(0, n * period, 40 * n + 1), np.linspace(0, 1, 81)
    r = Run(f"-growth_type none -growth_initial_length {L} -friction_mu 0 -friction_across {a} -clamp_type free "
            f"-shape_type straight -rod_cells 100 -ts_rtol 1e-8 -output_interval {period} -ts_max_time {n * period} "
            + steers("snake", s=s, t=t, curvature=A * np.cos(k * L * s - w * t[:, None])))
    at = [r.tip_at(m * period)[0] for m in (n - 1, n)]
    U = (at[1] - at[0]) / period / A**2
    print(f"U/A^2 is {U:.7f}; {r.steps} steps, defect {r.energy_defect[-1]:.1e}")
    expect(abs(U / -0.0331651704 - 1) < 1e-3, f"{U}")
    # on the whole who steers pays for friction
    expect(r.energy_defect[-1] < 1e-6 and np.abs(r.growth_power).max() == 0 and r.curvature_power.max() > 0, "power")


def let_go():
    """The tip of a rod that is fed is bent, held so, and let go: kinks in time."""
    t, held = [0, 1, 1, 2, 2, 2.5], [0, 1, 1, 1, 1, 0]
    d = np.linspace(0, 2, 21)
    return steers("let-go", distance=d, t=t, curvature=2 * np.outer(held, np.exp(-(d / 0.7)**4)))


BENT = FED + "-growth_initial_length 1 -rod_cells 60 -ts_max_time 3 "


@check
def steps_end_at_kinks_of_what_steers():
    """Steps end at kinks; the balance of energy, with the power of who steers, falls with the tolerance; plane and
    space agree, and a file over time of equal rows is the one without."""
    r = Run(BENT + let_go())
    for kink in (1, 2, 2.5):
        expect(np.abs(r.t - kink).min() < 1e-12, f"no step ends at {kink}")
    fine = Run(BENT + let_go() + "-ts_rtol 1e-8")
    space = Run(BENT + let_go() + "-rod_model space")
    off = np.abs(r.tip - fine.tip).max(), np.abs(space.tip - fine.tip).max()
    print(f"off by {off[0]:.1e}, in space {off[1]:.1e}; told {r.estimate:.1e}; defects {r.energy_defect[-1]:.1e}, {fine.energy_defect[-1]:.1e}")
    expect(max(off) < 2e-5 and max(off) <= r.estimate < 1e-3, f"{off}, told {r.estimate}")
    expect(r.energy_defect[-1] < 1e-5 and fine.energy_defect[-1] < 1e-7, "defect")
    late = fine.t > 2.5
    expect(np.abs(fine.curvature_power).max() > 1e-3 and np.abs(fine.curvature_power[late]).max() == 0, "its power")
    d = np.linspace(0, 2, 21)
    bend = np.cos(d)
    still = [Run(BENT + steers("still", distance=d, **more)) for more in
             (dict(curvature=bend), dict(t=[0, 1, 2, 3], curvature=np.tile(bend, (4, 1))))]
    expect(np.abs(still[0].tip - still[1].tip).max() < 1e-6, "equal rows")


def fed_and_let_go():
    """Fed by a schedule and steered."""
    path = rows("back", t=[0, 1.2, 1.5, 3], length=[1, 2.2, 2.2, 1])
    return BENT + let_go() + f"-growth_path {path} -friction_beta 1e-6 -output_interval 0.5 "


@check(ranks=3)
def a_steered_run_on_three_ranks_is_that_on_one():
    whole, three = (Run(fed_and_let_go(), ranks) for ranks in (1, 3))
    far = np.abs(whole.tip - three.tip).max()
    print(f"{whole.steps} steps; three ranks are off by {far:.1e}")
    expect(far < 1e-8, f"ranks: {far}")


@check
def a_steered_run_that_is_broken_goes_on_as_the_whole():
    """To the last bit."""
    driven = fed_and_let_go()
    for more, step in (("", lambda r: len(r["series/t"]) // 2), ("-rod_model space ", lambda r: int(np.searchsorted(r["series/t"], 2)))):
        _, differ = broken(driven + more, step)
        expect(not differ, f"{more}behind a restart: {differ}")


@check
def a_straight_rod_that_rests_is_held_by_exact_friction():
    """While a rod is not fed, or a table has it at rest, dry friction holds it against deflections, the exact one as that next to it,
    and its critical length is that of a rod which never rested. (It was told to be without friction across.)"""
    d, s = scene.SCRATCH, np.linspace(0, 1, 21)
    t = np.linspace(0, 6, 121)
    with h5py.File(f"{d}/rests.h5", "w") as f:
        f["s"], f["t"], f["g"] = s, t, 1 + np.outer(np.clip(t - 1, 0, None), np.ones_like(s))
    waits = rows("waits", t=[0, 1, 6], length=[1, 1, 6])
    for name, rests, goes in (("fed", f"-growth_type feed -growth_path {waits}", "-growth_type feed -growth_initial_length 1"),
                              ("table", f"-growth_type table -growth_table {d}/rests.h5", "-growth_type uniform -growth_initial_length 1")):
        said = [tendril(f"-task critical -friction_beta 0 -ts_max_time 6 {o} -output {d}/c.h5", 0) for o in (rests, goes)]
        length = [float(text.split("critical length L = ")[1].split()[0]) for text in said]
        print(f"{name}: critical at L = {length}")
        expect(abs(length[0] / length[1] - 1) < 1e-4, f"{name}: {length}")


@check
def what_cannot_be_steered_is_refused_in_one_line():
    """One line for what cannot be driven so."""
    d, s = np.linspace(0, 1, 5), [0, 0.2, 0.5, 1]
    go, one = rows("go", t=[0, 1], length=[1, 2]), np.ones(4)
    fed = "-growth_type feed "
    for options, words in (
            (f"-growth_path {go}", "-growth_path: with -growth_type uniform"),
            (f"-growth_type gaussian -growth_path {go}", "-growth_path: with -growth_type gaussian"),
            (f"-growth_type apical -growth_path {go}", "-growth_path: with -growth_type apical"),
            (fed + f"-growth_path {go} -growth_initial_length 3", "-growth_initial_length 3: with -growth_path"),
            (fed + f"-growth_path {rows('gone', t=[0, 1], length=[1, 0])}", "it must stay longer than 0"),
            (fed + f"-growth_path {rows('past', t=[0, 1, 2], speed=[0, -1, 0])}", "it must stay longer than 0"),
            (fed + f"-growth_path {rows('rest', t=[0, 1], length=[1, 1])}", "nothing moves"),
            (fed + f"-growth_path {rows('odd', t=[0, 1], spin=[1, 1])}", "column spin: how a rod is fed is given by t and speed"),
            (fed + f"-growth_path {rows('late', t=[1, 0], length=[1, 2])}", "t must increase"),
            (steers("a", s=s, t=[0, 1], curvature=one), "/curvature must have 2 dimension"),
            (steers("b", s=s, t=[0, 1], curvature=np.ones((3, 4))), "must be [2, 4]"),
            (steers("c", s=s, t=[0, 1, 1, 2], curvature=np.outer([0, 1, 2, 2], one)), "/curvature jumps at t = 1"),
            (steers("d", s=s, t=[0, 0, 1], curvature=np.ones((3, 4))), "first or last time twice"),
            (steers("e", s=s, t=[0, 1, 0.5], curvature=np.ones((3, 4))), "/t must increase"),
            (steers("f", s=s, t=[0], curvature=np.ones((1, 4))), "needs 2 entries or more in /t"),
            (steers("g", distance=d, t=[0, 1], curvature=np.ones((2, 5))), "give that"),
            (steers("h", s=s, t=[0, 1], curvature=np.ones((2, 4))) + "-task critical", "straight by nature"),
            (steers("i", s=s, t=[0, 1], curvature=np.zeros((2, 4)), twist=np.ones((2, 4))) + "-task stability", "-rod_curvature_file: with /t"),
    ):
        said = tendril(options, 1)
        expect(words in said, f"{options}: {said}")


if __name__ == "__main__":
    sys.exit(scene.main())

#!/usr/bin/env python3
"""What acts on a rod: the forces of clamp, tip, walls, friction and weight balance in every step, and so do the powers;
and what is counted of Newton's method.

    forces_test.py build/tendril [--mpiexec mpiexec] CHECK...      (no CHECK: all of them)"""

import re
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "support"))
import scene  # takes .venv's python if this one lacks numpy and h5py
from contact_test import COIL
from scene import Run, check, expect, tendril, walls

import h5py
import numpy as np

WHO = ("base", "tip", "wall", "friction", "weight")


def forces(r):
    """{who: [steps + 1, 3]} forces on the rod."""
    zero = np.zeros(len(r.series["t"]))
    return {who: np.stack([r.series.get(f"{who}_force_{k}", zero) for k in (1, 2, 3)], 1) for who in WHO}


def unbalanced(r):
    """The sum of all forces over the largest of them, behind the start, where only the shape is known."""
    parts = forces(r)
    largest = max(np.linalg.norm(f, axis=1).max() for f in parts.values())
    return np.linalg.norm(sum(parts.values()), axis=1)[1:] / largest


SHORT = "-growth_initial_length 1 -ts_max_time 1 -rod_cells 60 -shape_amplitude 0.1 "
FED = "-growth_type feed -growth_initial_length 0.5 -shape_type straight -rod_cells 60 -contact_diameter 0.05 "


def table():
    path = Path(scene.SCRATCH) / "table.h5"
    with h5py.File(path, "w") as f:
        f["s"], f["t"] = np.linspace(0, 1, 21), np.linspace(0, 1, 9)
        f["g"] = 1 + np.outer(f["t"][()], 0.5 + f["s"][()])
    return f"-growth_type table -growth_table {path} -ts_max_time 1 -rod_cells 60 -shape_amplitude 0.1 "


def all_laws():
    """Scenes by name: each law of growth, each end, walls at rest and in motion, fields, all models."""
    rough, stone = walls("plane 1.2 0 -1 0.4 friction 0.4"), walls("circle 1 0.07 0.01 outside friction 0.5")
    ball = walls("sphere 1.3 0.1 0.05 0.5 outside moves at 0 0 0 0  0.4 -0.05 0.05 0  1 0 0 0 friction 0.4")
    layers = "-friction_layers 0:0.5,0.8:2 -friction_across 2 "
    return {
        "uniform": SHORT + layers, "gaussian": SHORT + "-growth_type gaussian -rod_weight 0.1,-0.3 ",
        "feed": SHORT + "-growth_type feed -clamp_angle 0.5 -rod_weight 0.1,-0.3 ", "table": table(),
        "apical": SHORT + "-growth_type apical -tip_force 0.2 -tip_law resistance ",
        "none": SHORT + "-growth_type none -clamp_type free -rod_weight 0.2,-0.4 ",
        "hinged": SHORT + "-clamp_type hinged -tip_force 0.3 -tip_law follower ",
        "pinned": SHORT + "-tip_type pinned ", "second order": SHORT + "-rod_order 2 " + layers,
        "mixed": SHORT + "-rod_model mixed -tip_force 0.2 ",
        "wall": FED + "-rod_curvature 0.2 -ts_max_time 1.5 " + rough, "post": FED + "-rod_curvature 0.1 -ts_max_time 1.2 " + stone,
        "itself": COIL + "-rod_curvature 3 -ts_max_time 6.5 -rod_cells 80 -contact_friction 0.3 ",
        "space": SHORT + "-rod_model space -friction_radius 0.1 -clamp_spin 0.5 -rod_weight 0.1,0.2,-0.3 " + layers,
        "moving": FED + "-rod_model space -rod_curvature 0.1 -rod_curvature_2 0.1 -ts_max_time 1 " + ball,
    }


# (mixed: its first steps; pinned: where the layer of its start ends, what Newton's method leaves there)
BOUND = {"mixed": 1e-4, "pinned": 2e-5}


@check(ranks=(1, 3))
def all_forces_on_the_rod_add_up_to_0(ranks):
    """The forces of clamp, tip, walls, friction and weight add up to 0 in all steps, with exact friction, too."""
    for name, options in list(all_laws().items())[::1 if ranks == 1 else 3]:
        for beta in (1e-3, 0):
            if (name, beta) == ("mixed", 0):
                continue
            r = Run(f"{options} -friction_beta {beta}", ranks=ranks)
            off = unbalanced(r)
            print(f"{name}, beta {beta}: {len(off)} steps, off by {off.max():.1e} at most, touches {r.contact_force.max():.1e}")
            expect(len(off) > 20 and off.max() < BOUND.get(name, 1e-6), f"{name}, beta {beta}: {off.max():.1e}")
            expect(name not in ("wall", "post", "itself", "moving") or r.contact_force.max() > 0.01, f"{name}: no contact")
            expect(("weight_force_1" in r.series) == ("weight" in options), f"{name}: weight")


@check
def forces_of_the_linear_model_balance_to_its_order():
    """The linear model's balance holds to its own order, and at an event to what interpolation leaves."""
    for options, most in (("-rod_model linear -shape_amplitude 1e-4 -tip_force 0.3 ", 1e-6), ("-stop_length 1.77 ", 1e-5)):
        r = Run(SHORT + options)
        off = unbalanced(r)
        print(f"{options}: off by {off.max():.1e} at most")
        expect(off.max() < most, f"{options}: {off.max():.1e}")


REST = ("-growth_type none -clamp_type free -growth_initial_length 1 -shape_type straight -contact_diameter 0.1 -rod_cells 60 "
        "-friction_layers -9:0.1 ")


@check
def a_rod_that_sticks_bears_what_pushes_it():
    """What a rod bears that sticks: on a rough floor that rests, in the plane and in space, and on one that moves, and
    takes the rod along against the friction of the ground. Next to exact friction, in which it creeps, says the same."""
    flat, upright = walls("plane 0 -0.05 0 1 friction 0.5"), walls("plane 0 0 -0.05 0 0 1 friction 0.5")
    for name, options in (("plane", "-rod_weight 0.3,-1 " + flat), ("space", "-rod_weight 0.3,0,-1 -friction_radius 0.05 " + upright)):
        r = Run(f"{REST} {options} -friction_mu 0.5 -friction_beta 0 -ts_max_time 1")
        wall, ground = r.wall_force_1[-1], r.friction_force_1[-1]
        print(f"{name}: walls hold {wall:.6f} along them, the ground {ground:.6f}; moved by {r.tip_x1[-1] - 1:.1e}")
        expect(abs(wall + ground + 0.3) < 1e-6 and -0.5 < wall < -0.25 and abs(ground) < 0.05, f"{name}: {wall}, {ground}")
        expect(abs(r.tip_x1[-1] - 1) < 1e-5, f"{name}: moved")
    # friction 0.1 of the ground is overcome by a belt that goes at 0.3
    belt = walls("plane 0 0 -0.05 0 0 1 moves at 0 0 0 0  2 0.6 0 0 friction 0.5")
    found = {}
    for beta in (0, 1e-12):
        r = Run(f"{REST} -rod_weight 0,0,-1 -friction_radius 0.05 {belt} -friction_mu 1 -friction_beta {beta} -ts_max_time 1")
        found[beta] = [r.series[k][-1] for k in ("wall_force_1", "friction_force_1", "wall_power", "dissipation")]
        speed = r.tip_speed[-1]
        print(f"belt, beta {beta}: {found[beta]}, the rod goes at {speed:.6f}")
        expect(abs(speed - 0.3) < 1e-3, f"belt: {speed}")
    expect(np.allclose(found[0], [0.1, -0.1, 0.1 * speed, 0.1 * speed], rtol=1e-3), f"belt: {found[0]}")
    expect(np.allclose(found[0], found[1e-12], rtol=1e-3), f"belt: {found}")


@check
def a_wall_that_pushes_the_tip_is_no_force_of_the_tip():
    """The force on a tip is none where a wall alone pushes it: what the wall does is the wall's. (It is what Newton's method
    leaves, and of steps of the usual tolerance that is 1.3e-6 of the push in the one step that meets the wall.)"""
    flat, ahead = walls("plane 0.9 0 -1 0"), walls("plane 0.9 0 0 -1 0 0")
    for options in (flat, "-rod_model space " + ahead):
        r = Run(FED + "-rod_curvature 0.1 -ts_max_time 0.6 -friction_mu 0 -ts_rtol 1e-6 " + options)
        push, held = np.abs(r.wall_force_1).max(), np.abs([r.tip_force_1, r.tip_force_2]).max()
        print(f"walls push by {push:.3f}, the force on the tip is {held:.1e}")
        expect(push > 0.1 and held < 1e-6 * push, f"{push}, {held}")
        pushed = Run(FED + "-rod_curvature 0.1 -ts_max_time 0.6 -friction_mu 0 -tip_force 0.05 " + options)
        expect(np.abs(pushed.tip_force_1 + 0.05)[1:].max() < 1e-5 * push, f"-tip_force: {pushed.tip_force_1}")


@check
def all_iterations_of_newton_are_counted():
    """All of Newton's iterations are told, those of snaps too: as many as PETSc's solver says it has made; and so
    they are behind a restart, rejected steps with them."""
    d, options = scene.SCRATCH, "-tip_force 240 -growth_initial_length 0.2 -ts_max_time 0.01 -friction_mu 1 -rod_cells 100 "

    def told(said):
        return [int(n) for n in re.search(r"(\d+) steps, (\d+) rejected, (\d+) Newton", said).groups()]

    def summed(name):
        with h5py.File(f"{d}/{name}.h5") as f:
            return f["series/newton_iterations"][:].sum()

    said = tendril(f"{options} -info -output {d}/whole.h5")
    made, (_, _, count) = said.count("linear solve iterations="), told(said)
    print(f"{count} told, {summed('whole'):.0f} in the series, {made} made")
    expect("1 snap" in said and count == made == summed("whole"), "iterations")
    tendril(f"{options} -ts_max_time 0.005 -output {d}/half.h5")
    first = told(tendril(f"{options} -ts_max_time 0.005"))
    again = told(tendril(f"{options} -restart {d}/half.h5"))
    print(f"{first} in half of it, {again} behind a restart; {summed('half'):.0f} in the series")
    expect(again[2] == summed("half") > first[2] and again[1] >= first[1], f"restart: {first}, {again}")


if __name__ == "__main__":
    sys.exit(scene.main())

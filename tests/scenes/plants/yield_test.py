#!/usr/bin/env python3
"""Growth that feels the force along the rod: how long it becomes, where it stalls, and what else goes on meanwhile. Against exact
answers and references by a program that shares nothing with tendril.

    yield_test.py build/tendril [--mpiexec mpiexec] CHECK...      (no CHECK: all of them)"""

import sys
from math import atan, cos, exp, log, sin, sqrt, tan
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "support"))
import scene  # takes .venv's python if this one lacks numpy and h5py
from references import stiffness
from scene import check, expect, Run, tendril, tip_in_space

import numpy as np

STRAIGHT = "-shape_type straight "


def near(name, got, exact, allowed):
    expect(abs(got - exact) <= allowed, f"{name}: {got:.10g}, exact {exact:.10g}: off by {abs(got - exact):.1g}")


# At one time each: length, x of the tip, sqrt(int x2^2 dp), energy, int u0 dp, sqrt(int u0^2 dp), powers of growth and friction. By
# a program with Chebyshev panels in which no field knows of labels.
REFERENCES = {
    "a tip that is pressed on, then buckles": (
        "-growth_type uniform -growth_initial_length 1 -friction_mu 1 -growth_yield 2 -tip_force 0.8 -shape_type sag "
        "-shape_amplitude 0.1 -ts_max_time 6 -rod_cells 100 -ts_rtol 1e-6",
        (2.4347216064294175, (2.430495956603476, 0.12230489474100273), 0.08501630441776661, 0.0019818222009941383, 0, 0,
         0.2261023361265852, 0.08481356933370578)),
    "a root that turns down, and remembers": (
        "-growth_type apical -growth_zone 0.5 -growth_initial_length 1 -friction_mu 0.5 -tip_force 0.4 -tip_law resistance "
        "-growth_yield 1.5 -shape_type straight -tropism_gravity 2.5 -tropism_direction 0.6967067093471654,-0.7173560908995228 "
        "-tropism_proprioception 1.4 -tropism_sensed tip -tropism_memory 0.5 -ts_max_time 0.5 -rod_cells 100 -ts_rtol 1e-7",
        (1.3065807070930555, (1.3042159305934522, -0.032076399966607286), 0.010017367584618561, 0.00044110402843630225,
         -0.17970357084149755, 0.24864978465366103, 0.35544712633706427, 0.11192149269738011)),
}


@check
def references_by_another_program_are_met():
    for name, (options, exact) in REFERENCES.items():
        length, tip, norm, energy, angle, bend, grows, lost = exact
        r = Run(options)
        near(name + ", length", r.length[-1] / length, 1, 2e-7)
        expect(np.abs(r.tip - tip).max() < 3e-6 * length, f"{name}: tip {r.tip}, {tip}")
        near(name + ", norm", r.norm_x2_length[-1] / norm, 1, 2e-5)
        near(name + ", energy", r.energy[-1] / energy, 1, 3e-5)
        near(name + ", natural angle", r.natural_angle[-1], angle, 1e-5)
        near(name + ", natural bend", r.natural_bend[-1], bend, 1e-5)
        near(name + ", growth", r.growth_power[-1] / grows, 1, 1e-5)
        near(name + ", friction", r.dissipation[-1] / lost, 1, 1e-5)
        expect(r.energy_defect[-1] < 1e-6, f"{name}: the balance of energy is off by {r.energy_defect[-1]:g}")


@check
def a_straight_rod_is_as_long_as_its_friction_lets_it():
    """Dry, beta of 1e-3: by quadrature of n' = phi(V), V' = 1/L (1 + n/Pi). Viscous: L_t = (Pi - P)/sqrt(L Pi) tanh sqrt(L/Pi), and
    of a zone; fed: L + L^2/2Pi = L0 + L0^2/2Pi + t."""
    limit, first = 1.2, 0.5
    fed = limit * (sqrt(1 + 2 / limit * (first + first**2 / 2 / limit + 2)) - 1)
    for options, end, exact in (
            ("uniform -friction_mu 1", 3, 1.9780650367),
            ("uniform -friction_mu 1 -friction_beta 1e-4", 3, 1.9440504676),
            ("uniform -friction_mu 0 -tip_force 0.3", 4, 2.6449147195),
            ("feed -friction_mu 0", 2, fed),
            ("apical -growth_zone 0.5 -growth_initial_length 1 -growth_yield 1.5 -friction_mu 0 -tip_force 0.3", 1, 1.7082770244)):
        r = Run(f"{STRAIGHT}-growth_initial_length {first} -growth_yield {limit} -growth_type {options} -ts_max_time {end} "
                "-rod_cells 60 -ts_rtol 1e-7")
        near(options, r.length[-1], exact, 1e-6)
        expect(r.energy_defect[-1] < 1e-6, f"{options}: the balance of energy is off by {r.energy_defect[-1]:g}")


@check
def exact_friction_stalls_what_is_fed_and_not_what_grows_at_its_tip():
    """L = Pi - (Pi - L0) exp(-t/Pi); of a zone at the tip of which nothing else moves 1 - (P + zone/2)/Pi. What is told of how far
    off a limit of exact friction is holds."""
    dry = f"{STRAIGHT}-friction_mu 1 -friction_beta 0 -rod_cells 60 "
    r = Run(f"{dry}-growth_type feed -growth_initial_length 0.5 -growth_yield 1.2 -ts_max_time 2")
    near("fed", r.length[-1], 1.2 - 0.7 * exp(-2 / 1.2), 2e-6)
    r = Run(f"{dry}-growth_type apical -growth_zone 0.5 -growth_initial_length 1 -growth_yield 1.5 -tip_force 0.3 -ts_max_time 1")
    near("a zone", r.length[-1], 1 + (1 - (0.3 + 0.25) / 1.5), 2e-6)
    r = Run(f"{dry}-growth_type uniform -growth_initial_length 0.5 -growth_yield 1.2 -ts_max_time 3")
    off = abs(r.length[-1] - 1.9278347677)
    expect(off < 2e-4 and off < r.error_tip[-1] * r.length[-1], f"all along: off by {off:g}, told {r.error_tip[-1]:g}")


@check
def a_run_says_what_stalls_it():
    fed = f"{STRAIGHT}-growth_type feed -growth_initial_length 0.5 -friction_beta 0 -rod_cells 40 -growth_yield "
    line = tendril(f"{fed}1 -ts_max_time 12")
    expect("stalled at length 1.00" in line and "friction takes all" in line, line)
    line = tendril(f"{fed}1 -ts_max_time 12 -friction_mu 0 -friction_beta 1e-3 -tip_force 0.999")
    expect("what presses on the tip takes all" in line, line)
    line = tendril(f"{fed}1 -ts_max_time 12 -friction_mu 0 -friction_beta 1e-3 -rod_weight -1,0")
    expect("the rod's weight takes all" in line, line)
    wall = Path(scene.SCRATCH) / "yield-wall.txt"
    wall.write_text("plane 0.3 0 -1 0\n")
    # pressed hard, for thousands of steps in which it gets nowhere: that is no jam
    line = tendril(f"{fed}50 -growth_initial_length 0.2 -ts_max_time 12 -ts_adapt_dt_max 5e-3 -friction_mu 0 -friction_beta 1e-3 "
                   f"-contact_diameter 0.01 -wall_file {wall}")
    expect("walls take all" in line and "jammed" not in line, line)
    line = tendril(f"{fed}1 -ts_max_time 1")
    expect("stalled" not in line, line)
    r = Run(f"{fed}1.2 -ts_max_time 9 -stop_stall 0.1")
    near("when", r.t[-1], -1.2 * log(0.12 / 0.7), 3e-5)
    r = Run(f"{fed}1.2 -ts_max_time 9 -stop_length 0.9")
    near("at a length", r.t[-1], 1.2 * log(0.7 / 0.3), 3e-5)


@check
def a_tip_that_is_sensed_turns_by_the_length_that_has_grown_however_slowly():
    """G = 1: tan(theta/2) falls as exp(-b (L - L0))."""
    stiff = stiffness(lambda d: np.full_like(d, 1e6))
    for growth in ("uniform", "apical -growth_zone 0.5"):
        r = Run(f"{stiff} {STRAIGHT}-growth_initial_length 1 -growth_type {growth} -growth_yield 2 -friction_mu 0.5 -ts_max_time 1 "
                f"-tropism_gravity 2 -tropism_proprioception 1 -tropism_sensed tip -tropism_direction {cos(1.2)!r},{sin(1.2)!r} "
                "-rod_cells 60 -ts_rtol 1e-7")
        grown = r.length[-1] - 1
        expect(grown < 0.9, f"{growth}: no thrust slows it down: {grown}")
        near(growth, r.tip_angle[-1], 1.2 - 2 * atan(tan(0.6) * exp(-2 * grown)), 1e-5)


@check
def force_that_is_next_to_none_beside_the_limit_changes_nothing():
    for law in ("uniform", "apical -growth_zone 0.5", "feed"):
        scene_ = f"-growth_type {law} -growth_initial_length 1 -friction_mu 0.5 -rod_curvature 0.4 -ts_max_time 0.5 -rod_cells 40 -ts_rtol 1e-6 "
        a, b = (Run(scene_ + more) for more in ("", "-growth_yield 1e6"))
        expect(np.abs(a.tip - b.tip).max() < 3e-6, f"{law}: {a.tip} {b.tip}")
        near(law, b.energy[-1] / a.energy[-1], 1, b.error_energy[-1])


@check
def it_goes_on_from_a_restart_as_if_nothing_had_been():
    options = (f"{STRAIGHT}-growth_type apical -growth_zone 0.5 -growth_initial_length 1 -friction_mu 0.5 -growth_yield 1.5 "
               "-tropism_gravity 2 -tropism_direction 0,-1 -tropism_proprioception 1 -ts_max_time 0.3 -rod_cells 40 ")
    whole = Run(options)
    file = str(Path(scene.SCRATCH) / "yield-begun.h5")
    tendril(f"{options}-ts_max_steps 30 -output {file}", 1)
    on = Run(f"{options}-restart {file}")
    expect(on.length[-1] == whole.length[-1] and (on.tip == whole.tip).all() and on.energy[-1] == whole.energy[-1],
           f"{on.length[-1] - whole.length[-1]:g} {on.tip - whole.tip}")


@check(ranks=3)
def ranks_find_the_same():
    options = (f"{STRAIGHT}-growth_type apical -growth_zone 0.5 -growth_initial_length 1 -friction_mu 0.5 -growth_yield 1.5 "
               "-tropism_gravity 2 -tropism_direction 0,-1 -tropism_proprioception 1 -tropism_sensed tip -ts_max_time 0.2 -rod_cells 30 ")
    a, b = Run(options), Run(options, ranks=3)
    expect(np.abs(a.tip - b.tip).max() < 1e-6 and abs(a.length[-1] - b.length[-1]) < 1e-6, f"{a.tip} {b.tip}")


# What grows in the plane: each law, with what there is to feel and to learn.
IN_THE_PLANE = {
    "uniform": "-shape_type sag -shape_amplitude 0.1 -friction_mu 1 -tip_force 0.8 -growth_yield 2",
    "feed": "-rod_curvature 0.4 -friction_mu 0 -friction_across 2 -growth_yield 1.5",
    "apical -growth_zone 0.5": STRAIGHT + "-friction_mu 0.5 -growth_yield 1.5 -tip_force 0.4 -tip_law resistance -tropism_gravity 2.5 "
                               "-tropism_direction 0.7,-0.7 -tropism_proprioception 1.4 -tropism_sensed tip -tropism_memory 0.5",
}


@check
def a_scene_of_the_plane_is_the_same_in_space():
    for law, more in IN_THE_PLANE.items():
        options = f"-growth_type {law} -growth_initial_length 1 {more} -ts_max_time 0.3 -rod_cells 24 -ts_rtol 1e-7 -rod_model "
        plane, space = Run(options + "frame"), Run(options + "space")
        near(f"{law}, length", space.length[-1], plane.length[-1], 1e-7)
        expect(np.abs(space.tip - plane.tip).max() < 3e-7 and space.tip_x3[-1] == 0, f"{law}: {space.tip} {plane.tip}")
        near(f"{law}, energy", space.energy[-1] / plane.energy[-1], 1, 1e-5)
        expect(space.energy_defect[-1] < 5e-6, f"{law}: the balance of energy is off by {space.energy_defect[-1]:g}")


@check
def a_wall_takes_as_much_in_space():
    wall = Path(scene.SCRATCH) / "yield-tilted.txt"
    wall.write_text("plane 1.1 0 -1 0.2 friction 0.3\n")
    options = (f"-growth_type feed -growth_initial_length 1 -friction_mu 0.5 -growth_yield 1.5 -rod_curvature 0.4 -contact_diameter 0.02 "
               f"-wall_file {wall} -ts_max_time 0.4 -rod_cells 24 -ts_rtol 1e-6 -rod_model ")
    plane, space = Run(options + "frame"), Run(options + "space")
    expect(plane.wall_force_1[-1] < -0.2, f"it is pressed with {plane.wall_force_1[-1]}")
    near("length", space.length[-1], plane.length[-1], 1e-5)
    near("wall", space.wall_force_1[-1] / plane.wall_force_1[-1], 1, 1e-4)


@check
def a_rod_in_space_stalls_as_one_in_the_plane():
    options = f"{STRAIGHT}-rod_model space -growth_type feed -growth_initial_length 0.5 -friction_beta 0 -rod_cells 20 -growth_yield "
    r = Run(f"{options}1.2 -ts_max_time 9 -stop_stall 0.1")
    near("when", r.t[-1], -1.2 * log(0.12 / 0.7), 3e-5)
    line = tendril(f"{options}1 -ts_max_time 12")
    expect("stalled at length 1.00" in line and "friction takes all" in line, line)


def root_in_space(turn=np.eye(3), hand=1, learns=True):
    """Options of a root that is bent and twisted by nature, whose friction feels its spin, and that may feel where down is: turned
    and mirrored."""
    down, weight, clamp = (",".join(map(repr, (turn @ v * [1, 1, hand]).tolist())) for v in ((0.2, -0.8, 0.5), (0.1, -0.3, 0.2), (1, 0, 0)))
    return ("-rod_model space -growth_type apical -growth_zone 0.5 -growth_initial_length 1 -friction_mu 0.5 -growth_yield 1.2 "
            f"{STRAIGHT}-rod_curvature_2 {-hand * 0.2} -rod_twist {hand * 0.6} -rod_torsion 0.7 -friction_radius 0.1 -rod_weight {weight} "
            f"-clamp_direction {clamp} -ts_max_time 0.3 -ts_rtol 1e-6 -rod_cells 24 "
            + learns * f"-tropism_gravity 3 -tropism_proprioception 1 -tropism_direction {down} ")


def grown(options):
    """Tip, length and energy at the end."""
    r = Run(options)
    expect(r.energy_defect[-1] < 1e-5, f"{options}: the balance of energy is off by {r.energy_defect[-1]:g}")
    return np.array([*tip_in_space(r), r.length[-1], r.energy[-1]])


@check
def turned_and_mirrored_it_is_the_same_and_goes_on_to_the_last_bit():
    it = grown(root_in_space())
    expect(abs(it[2]) > 1e-3, f"it leaves the plane: {it}")
    a = np.array([0.6, 0.48, 0.64])  # the least turn that takes the clamp's axis here
    cross = np.array([[0, -a[1], -a[2]], [a[1], 0, 0], [a[2], 0, 0]])
    turn = np.eye(3) + cross + cross @ cross / (1 + a[0])
    other = grown(root_in_space(turn))
    expect(np.abs(other - [*(turn @ it[:3]), *it[3:]]).max() < 1e-8, f"turned: {it} {other}")
    file = str(Path(scene.SCRATCH) / "yield-space-begun.h5")
    tendril(root_in_space() + f"-ts_max_steps 20 -output {file}", 1)
    other = grown(root_in_space() + f"-restart {file}")
    expect((other == it).all(), f"gone on with: {it} {other}")
    it, other = (grown(root_in_space(hand=hand, learns=False)) for hand in (1, -1))
    expect((other == it * [1, 1, -1, 1, 1]).all(), f"mirrored: {it} {other}")


@check(ranks=3)
def ranks_find_the_same_in_space():
    options = root_in_space() + "-tropism_sensed tip -ts_max_time 0.02 -rod_cells 12"
    a, b = Run(options), Run(options, ranks=3)
    expect(np.abs(tip_in_space(a) - tip_in_space(b)).max() < 1e-8 and abs(a.length[-1] - b.length[-1]) < 1e-8, f"{a.tip} {b.tip}")


@check
def what_does_not_go_with_it_is_refused():
    for options, word in (("-growth_type gaussian", "-growth_yield"), ("-growth_type none", "-growth_yield"),
                          ("-rod_model linear", "-growth_yield"),
                          ("-rod_model mixed", "-growth_yield"),
                          ("-rod_order 2", "-rod_order 2"), ("-rod_model space -rod_order 2", "-rod_order 2"),
                          ("-rod_model space -growth_type gaussian", "-growth_yield"),
                          ("-rod_model space -contact_self true -contact_diameter 0.1", "-contact_self"),
                          ("-growth_type apical -growth_profile even", "-growth_profile"),
                          ("-rod_curvature_random 0.1", "-rod_curvature_random"),
                          ("-contact_self true -contact_diameter 0.1", "-contact_self"),
                          ("-clamp_type hinged", "-clamp_type")):
        expect(word in tendril(f"-growth_yield 1 {options}", 1), options)
    expect("-stop_stall" in tendril("-stop_stall 0.1", 1), "-stop_stall")


if __name__ == "__main__":
    sys.exit(scene.main())

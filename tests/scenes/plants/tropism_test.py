#!/usr/bin/env python3
"""Growth that senses: gravity, light, posture, nutation, memory and moments that are ironed out. Against exact answers and
references by programs that share nothing with tendril.

    tropism_test.py build/tendril [--mpiexec mpiexec] CHECK...      (no CHECK: all of them)"""

import sys
from math import cos, exp, log, pi, sin, sqrt, tan, atan
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "support"))
import scene  # takes .venv's python if this one lacks numpy and h5py
from references import stiffness
from scene import broken, check, expect, order, Run, tendril

import numpy as np

STRAIGHT = "-shape_type straight -growth_initial_length 1 "
ROOT = "-growth_type apical -growth_zone 0.6 -friction_mu 0.5 " + STRAIGHT


def toward(angle):
    return f"-tropism_direction {cos(angle)!r},{sin(angle)!r} "


def stiff():
    """So stiff that its shape is the natural one."""
    return stiffness(lambda d: np.full_like(d, 1e8)) + " "


def near(name, got, exact, allowed):
    expect(abs(got - exact) <= allowed, f"{name}: {got:.10g}, exact {exact:.10g}: off by {abs(got - exact):.1g}")


# --- references ----------------------------------------------------------------------------------

# At one time each: x of the tip (of the length), sqrt(int x2^2 dp), energy, int u0 dp, sqrt(int u0^2 dp). By programs with
# Chebyshev panels for x, theta and u0 of a beam in the plane, and for directors in space, at two resolutions that agree to 1e-8.
REFERENCES = {
    "a root, sensed at its tip": (
        "-growth_type apical -growth_zone 0.6 -friction_mu 1 -tropism_gravity 4 -tropism_proprioception 2 -tropism_sensed tip "
        "-tropism_direction 0.3623577544766736,-0.9320390859672263 ", 1,
        ((1.721350637687983, -0.7150632513689439), 0.39823022650847517, 0.0021231961063986077,
         -1.0581877203685361, 0.9182280322197759)),
    "a shoot that weighs": (
        "-growth_type uniform -friction_mu 0.5 -rod_weight 0,-0.3 -tropism_gravity 2 -tropism_direction 0,1 "
        "-tropism_proprioception 0.8 ", 1, ((1.571266089478498, 0.9271759937552224), 0.5526506363966299, 0.3652038918936386,
         2.202007849530359, 1.5769734608170853)),
    "a shoot that nutates": (
        "-growth_type uniform -friction_mu 0.6 -tropism_nutation 2 -tropism_nutation_2 2 -tropism_nutation_rate 3 "
        "-tropism_gravity 1 -tropism_direction 1,0,0 -tropism_proprioception 1 ", 1, ((1.7239295216989368, 0.44591953060897954, 0.713468566861579), 0.3213714965103074, 0.11838999043850594,
         -0.0456123418583326, 0.9363798533158413)),
    "a bend that is ironed": (
        "-growth_type uniform -friction_mu 0.5 -tip_force_vector 0,0.3,0 -growth_ironing 5 ", 1, ((1.7693741177023967, 0.7874385183230272), 0.505196341487398, 0.0073981950578138915,
         0.61127387899289, 0.4592416510785821)),
}


@check
def references_by_other_programs_are_met():
    for name, (options, end, (tip, norm, energy, angle, bend)) in REFERENCES.items():
        r = Run(f"{STRAIGHT}{options} -ts_max_time {end} -rod_cells 200 -ts_rtol 1e-7")
        at = [r.series[f"tip_x{k + 1}"][-1] for k in range(len(tip))]
        expect(np.abs(np.subtract(at, tip)).max() < 1e-6 * r.length[-1], f"{name}: tip {at}, {tip}")
        near(name + ", norm", r.norm_x2_length[-1] / norm, 1, 5e-6)
        near(name + ", energy", r.energy[-1] / energy, 1, 2e-5)
        near(name + ", natural bend", r.natural_bend[-1], bend, 1e-5)
        near(name + ", natural angle", r.natural_angle[-1], angle, 1e-5)
        expect(r.energy_defect[-1] < 1e-6, f"{name}: the balance of energy is off by {r.energy_defect[-1]:g}")


# --- exact answers -------------------------------------------------------------------------------

@check
def a_tip_that_is_sensed_turns_by_the_length_that_has_grown():
    """G = 1: tan(theta/2) falls as exp(-b L), whatever grows."""
    exact = 1.2 + 2 * atan(tan(-1.2 / 2) * exp(-2))
    for growth in ("uniform", "apical -growth_zone 0.5"):
        r = Run(f"{stiff()}{STRAIGHT}-growth_type {growth} -ts_max_time 1 -tropism_gravity 2 -tropism_proprioception 1 "
                f"-tropism_sensed tip {toward(1.2)} -rod_cells 100 -ts_rtol 1e-7")
        near(growth, r.tip_angle[-1], exact, 2e-6)


@check
def a_tip_that_remembers_swings():
    memory, small = 0.3, 1e-4
    w = sqrt(2 / memory - 1 / 4 / memory**2)
    r = Run(f"{stiff()}{STRAIGHT}-growth_type uniform -ts_max_time 1 -tropism_gravity 2 -tropism_proprioception 1 "
            f"-tropism_sensed tip -tropism_memory {memory} {toward(small)} -rod_cells 50 -ts_rtol 1e-7")
    near("angle", 1 - r.tip_angle[-1] / small, exp(-1 / 2 / memory) * (cos(w) + sin(w) / 2 / memory / w), 1e-6)


@check
def places_that_sense_for_themselves_bend_as_bessel_functions_have_it():
    for options, exact in (("-growth_type none -tropism_rate 1 -tropism_gravity 1 -tropism_proprioception 0.5", 0.3754088546),
                           ("-growth_type uniform -tropism_gravity 2 -tropism_proprioception 1", -0.1965480953),
                           ("-growth_type uniform -tropism_gravity 2 -tropism_proprioception 1.5", -0.0657722187)):
        r = Run(f"{stiff()}{STRAIGHT}{options} -ts_max_time 1 {toward(1e-4)} -rod_cells 50 -ts_rtol 1e-7")
        near(options, 1 - r.tip_angle[-1] / 1e-4, exact, 2e-6)


@check
def a_bell_of_growth_turns_its_tip():
    for options, exact in (("-tropism_gravity 4 -tropism_proprioception 2", 1.0248121758),
                           ("-tropism_gravity 6 -tropism_proprioception 0.5 -tropism_memory 0.4", 1.7512510657)):
        r = Run(f"{stiff()}{STRAIGHT}-growth_type apical -growth_zone 1 -ts_max_time 1 -tropism_sensed tip {options} "
                f"{toward(1.2)} -rod_cells 100 -ts_rtol 1e-7")
        near(options, r.tip_angle[-1], exact, 5e-6)


@check
def an_even_zone_turns_its_tip_as_two_numbers_do():
    """k of the zone is one number, k' = b sin(dir - theta) - G k, that of the base turns as k does: by a program for these."""
    for options, exact in (("-tropism_gravity 4 -tropism_proprioception 2", 1.0353501749),
                           ("-tropism_gravity 6 -tropism_proprioception 0.5 -tropism_memory 0.4", 1.7191528311)):
        r = Run(f"{stiff()}{STRAIGHT}-growth_type apical -growth_profile even -growth_zone 1 -ts_max_time 1 -tropism_sensed tip {options} "
                f"{toward(1.2)} -rod_cells 100 -ts_rtol 1e-6")
        near(options, r.tip_angle[-1], exact, 5e-5)
        expect(r.energy_defect[-1] < 1e-4, f"{options}: the balance of energy is off by {r.energy_defect[-1]:g}")


@check
def a_rod_that_is_spun_stands_bent_and_a_cantilever_gives_way_by_what_is_ironed():
    """theta = theta0 exp(-b s/(G - i om/r)) on a clinostat, at rest in the laboratory; f L^3 (1 + I r t)/3B under a force across."""
    small, q = 1e-4, 3 / (1 - 5j)
    exact = (1 - np.exp(-q)) / q - 1
    r = Run(f"{stiff()}{STRAIGHT}-growth_type none -friction_mu 0 -tropism_rate 1 -tropism_gravity 3 -tropism_proprioception 1 "
            f"-tropism_direction 1,{-small},0 -clamp_spin 5 -ts_max_time 12 -ts_rtol 1e-6 -rod_cells 30")
    near("spun", abs(complex(r.tip_x2[-1], r.tip_x3[-1]) / small - exact), 0, 5e-5)
    r = Run(f"{stiff()}{STRAIGHT}-growth_type none -friction_mu 0 -tropism_rate 1 -growth_ironing 2 -tip_force_vector 0,3e4,0 -ts_max_time 1 "
            "-ts_rtol 1e-6 -rod_cells 30")
    near("cantilever", r.tip_x2[-1] / 3e-4, 1, 2e-6)


@check
def a_rod_at_rest_ends_in_the_direction_by_its_balance():
    """Sine, steady: tan(theta/2) falls as exp(-b s/G)."""
    r = Run(f"{stiff()}{STRAIGHT}-growth_type none -ts_max_time 40 -tropism_rate 1 -tropism_gravity 2 -tropism_proprioception 1 "
            "-tropism_direction 0,1 -rod_cells 50")
    near("angle", pi / 2 - r.tip_angle[-1], 0.2690359907, 1e-7)
    near("place", 2 * r.tip_x1[-1], 1.3017603360, 1e-7)


@check
def a_far_lamp_pulls_as_gravity_and_a_near_one_is_pointed_at():
    """Its strength is the same at any distance; at rest a tip that senses points at where the lamp is from there."""
    root = "-growth_type uniform -friction_mu 0.5 " + STRAIGHT + "-tropism_proprioception 1 -ts_max_time 1 -rod_cells 40 "
    for model in ("frame", "space"):
        a, b = (Run(f"{root}-rod_model {model} {law}") for law in ("-tropism_gravity 2 -tropism_direction 0.6,0.8",
                                                                   "-tropism_light 2 -tropism_source 6e7,8e7"))
        near(f"{model}, far", b.tip_angle[-1], a.tip_angle[-1], 1e-6)
        r = Run(f"{stiff()}{STRAIGHT}-growth_type none -tropism_rate 1 -tropism_light 3 -tropism_source 0.9,1.3 -tropism_sensed tip "
                f"-ts_max_time 20 -rod_cells 30 -rod_model {model}")
        near(f"{model}, near", r.tip_angle[-1], np.arctan2(1.3 - r.tip_x2[-1], 0.9 - r.tip_x1[-1]), 1e-6)


@check
def what_is_fed_in_is_straight_and_bends_from_then_on():
    """A constant drive: k = r n (time since it is in), int k dp = r n (t^2/2 + L0 t), however it is bent."""
    for model in ("frame", "space"):
        off = [abs(Run(f"{STRAIGHT}-growth_type feed -tropism_rate 0.5 -tropism_nutation 0.8 -ts_max_time 1 -rod_cells {n} "
                       f"-rod_model {model}").natural_angle[-1] / (0.5 * 0.8 * (1 / 2 + 1)) - 1) for n in (30, 60)]
        expect(off[1] < 1e-4 and off[1] < 0.45 * off[0], f"{model}: {off}")


@check
def a_front_of_what_is_fed_in_is_followed():
    """Between what was there at first and what has come in k has a corner, in whatever cell: the rod is resolved to the order 4 all
    the same, and steps do not go by cells."""
    for model in ("frame", "space"):
        coarse, fine = [Run(f"{STRAIGHT}-growth_type feed -friction_mu 0.5 -tropism_rate 1 -tropism_gravity 2 -tropism_direction 0,1 "
                            f"-tropism_proprioception 0.8 -ts_max_time 0.83 -ts_rtol 1e-5 -rod_cells {n} -rod_model {model}")
                        for n in (30, 60)]
        near(f"{model}, across", coarse.tip_x2[-1], fine.tip_x2[-1], 1e-5)
        near(f"{model}, energy", coarse.energy[-1], fine.energy[-1], 1e-5)
        expect(abs(len(fine.t) / len(coarse.t) - 1) < 0.2, f"{model}: {len(coarse.t)} steps, {len(fine.t)}")


@check
def forces_between_held_ends_are_ironed_out_and_the_shape_stays():
    for model in ("frame", "space"):
        r = Run("-growth_type none -growth_initial_length 4 -shape_type sag -shape_amplitude 0.5 -tip_type clamped -friction_mu 0 "
                f"-tropism_rate 1 -growth_ironing 0.3 -ts_max_time 20 -rod_cells 60 -ts_rtol 1e-7 -rod_model {model}")
        k = np.searchsorted(r.t, 12)
        near(model, log(r.base_force_1[k] / r.base_force_1[-1]) / (r.t[-1] - r.t[k]), 0.3, 1e-4)
        expect(np.abs(r.shapes["x"][-1] - r.shapes["x"][-2]).max() < 1e-7, f"{model}: the shape moves")


# --- what must hold always -----------------------------------------------------------------------

MIXED = ROOT + "-tropism_gravity 4 -tropism_proprioception 2 -growth_ironing 3 -tropism_light 1 -ts_max_time 0.4 -rod_cells 40 "
SOURCE = "-tropism_source {},{} -tropism_direction {},{} "


@check
def a_root_in_the_plane_is_one_in_space():
    for more in ("-tropism_memory 0.1", "-tropism_sensed tip"):
        a, b = (Run(f"{MIXED}{SOURCE.format(3, 1, 0.3, -1)}{more} -ts_rtol 1e-7 -rod_model {model}") for model in ("frame", "space"))
        for name in ("tip_x1", "tip_x2", "natural_angle", "natural_bend"):
            near(f"{more}, {name}", b.series[name][-1], a.series[name][-1], 1e-6)


@check
def mirrored_and_turned_roots_bend_alike():
    a = Run(MIXED + SOURCE.format(3, 1, 0.3, -1))
    b = Run(MIXED + SOURCE.format(3, -1, 0.3, 1))
    expect(np.array_equal(a.tip_x2, -b.tip_x2) and np.array_equal(a.natural_angle, -b.natural_angle), "the mirror image differs")
    c, s = cos(0.7), sin(0.7)
    b = Run(MIXED + SOURCE.format(3 * c - s, 3 * s + c, 0.3 * c + s, 0.3 * s - c) + "-clamp_angle 0.7")
    near("turned", b.tip_x1[-1], c * a.tip_x1[-1] - s * a.tip_x2[-1], 1e-9)
    near("turned, angle", b.tip_angle[-1] - 0.7, a.tip_angle[-1], 1e-9)


@check
def an_aligned_root_decays_as_far_as_numbers_go_and_comes_back():
    """Stiff, sensed at its tip and turned away from where it points: u = k grows as r (b L - G), so that it falls until L = 1, by
    almost 250 orders of magnitude, and returns."""
    r = Run(f"{stiff()}-growth_type uniform -growth_initial_length 0.2 -shape_amplitude 1e-3 -friction_mu 0 -ts_max_time 1.622 "
            "-rod_cells 30 -rod_model frame -tropism_rate 1700 -tropism_gravity 1 -tropism_proprioception 1 -tropism_sensed tip "
            "-tropism_direction -1,0")
    expect(r.norm_x2.min() < 1e-240 and r.norm_x2[-1] > 0.1, f"{r.norm_x2.min():g}, {r.norm_x2[-1]:g}")
    small = (r.t > 0.1) & ((r.t < 1) | (r.norm_x2 < 1e-4))
    t, bend = r.t[small], np.abs(r.tip_angle / r.length)[small]
    off = np.log(bend / bend[0]) - 1700 * ((0.2 + t)**2 / 2 - t - (0.2 + t[0])**2 / 2 + t[0])
    near("its logarithm", off[-1], 0, 3e-3)
    expect(np.abs(off).max() < 3e-3, f"on the way: {np.abs(off).max():g}")


@check(ranks=3)
def several_ranks_agree_on_what_is_learned():
    for more in ("-tropism_sensed tip", "-tropism_memory 0.1"):
        runs = [Run(f"{MIXED}{SOURCE.format(3, 1, 0.3, -1)}{more}", ranks) for ranks in (1, 2, 3)]
        for r in runs[1:]:
            near(more, r.tip_x2[-1], runs[0].tip_x2[-1], 1e-9)


@check
def a_run_broken_off_goes_on_to_the_last_bit():
    for more in ("-tropism_sensed tip", "-tropism_memory 0.1 -rod_model space"):
        whole, different = broken(f"{MIXED}{SOURCE.format(3, 1, 0.3, -1)}{more}", 60)
        expect(len(whole["series/t"]) > 70 and not different, f"{more}: {different} differ")


@check
def orders_in_space_and_in_time_are_those_of_the_formulas():
    def tip(options):
        r = Run(f"-growth_type uniform -friction_mu 0.5 {STRAIGHT}-tropism_gravity 3 -tropism_direction 0,-1 "
                f"-tropism_proprioception 1 -growth_ironing 2 -ts_max_time 0.5 {options}")
        return r.tip, r.steps

    cells = [tip(f"-rod_cells {n} -rod_grading uniform -ts_rtol 1e-9")[0] for n in (6, 12, 24, 96)]
    near("in space", order([np.linalg.norm(x - cells[-1]) for x in cells[:-1]]), 4, 0.3)
    fine = tip("-rod_cells 20 -ts_rtol 1e-10")[0]
    for formula, tolerances in {2: (1e-4, 1e-6), 4: (1e-5, 1e-7)}.items():
        ends, steps = zip(*(tip(f"-rod_cells 20 -ts_bdf_order {formula} -ts_rtol {rtol}") for rtol in tolerances))
        off = [np.linalg.norm(x - fine) for x in ends]
        near(f"order {formula} in time", log(off[0] / off[1]) / log(steps[1] / steps[0]), formula, 0.5)


@check
def sensitivities_are_differences():
    step = 0.002
    base = ROOT + "-tropism_gravity 4 -tropism_proprioception 2 -tropism_sensed tip -tropism_direction 0.3,-1 -ts_max_time 0.6 " \
        "-rod_cells 40 -ts_rtol 1e-7 -tropism_memory "
    r = Run(f"{base}0.2 -sensitivity tropism_memory,growth_zone")
    low, high = (Run(f"{base}{0.2 + d}") for d in (-step, step))
    near("memory", r.derivatives["tropism_memory", "series/tip_x2"][-1], (high.tip_x2[-1] - low.tip_x2[-1]) / 2 / step, 1e-4)
    low, high = (Run(f"{base}0.2 -growth_zone {0.6 + d}") for d in (-step, step))
    near("zone", r.derivatives["growth_zone", "series/tip_x2"][-1], (high.tip_x2[-1] - low.tip_x2[-1]) / 2 / step, 3e-4)


@check
def a_tip_that_reaches_its_lamp_stops_there():
    """A straight shoot meets its lamp head-on at length 2, seen from a hundredth of that; one that turns to it arrives, too."""
    file = str(Path(scene.SCRATCH) / "lamp.h5")
    line = tendril(f"{STRAIGHT}-growth_type uniform -tropism_light 3 -tropism_source 0,2,0 -clamp_angle {pi / 2!r} -ts_max_time 2 "
                   f"-ts_adapt_dt_max 1e-3 -rod_cells 200 -output {file}", 1)
    expect("lamp" in line and "-tropism_source" in line and "stored" in line, line)
    near("length", scene.read(file)["series/length"][-1], 1.98, 0.003)
    for model in ("frame", "space"):
        line = tendril(f"{ROOT}-tropism_light 30 -tropism_source 1.5,0.3 -tropism_proprioception 1 -tropism_sensed tip -ts_max_time 2 "
                       f"-rod_cells 60 -rod_model {model}", 1)
        expect("lamp" in line, line)


# --- what touches itself -------------------------------------------------------------------------

# A root that its growth winds up, until it meets itself at t = 0.4.
WOUND = ("-growth_type apical -growth_zone 0.4 -friction_mu 0.5 -shape_type straight -growth_initial_length 0.5 -rod_cells 24 "
         "-tropism_nutation 9 -tropism_gravity 1 -tropism_direction 0,-1 -tropism_proprioception 0.5 -growth_ironing 1 "
         "-contact_self -contact_diameter 0.1 -contact_friction 0.3 -ts_max_time 0.43 ")


@check(ranks=3)
def a_root_that_winds_up_meets_itself_on_any_ranks():
    for model, more in (("frame", "-tropism_sensed tip -tropism_memory 0.2"), ("space", "")):
        r, other = (Run(f"{WOUND}{more} -rod_model {model} -ts_max_time 0.41", ranks) for ranks in (1, 3))
        expect(r.contact_force[-1] > 1 and r.penetration.max() < 1e-3, f"{r.contact_force[-1]}, {r.penetration.max()}")
        near(model, other.tip_x2[-1], r.tip_x2[-1], 1e-6)


@check
def a_root_that_winds_up_goes_on_behind_its_touch_to_the_last_bit():
    for more in ("-tropism_sensed tip", "-tropism_memory 0.1 -rod_model space"):
        whole, different = broken(WOUND + more, lambda whole: int(np.flatnonzero(whole["series/contact_force"] > 0)[3]))
        expect(not different, f"{more}: {different} differ")
        expect(whole["series/energy_defect"][-1] < 1e-3, f"{more}: the balance of energy is off")


@check
def a_root_that_winds_up_does_so_in_space_and_in_the_mirror():
    mirrored = WOUND.replace("nutation 9", "nutation -9").replace("0,-1", "0,1")
    r, space, mirror = Run(WOUND), Run(WOUND + "-rod_model space"), Run(mirrored)
    expect(np.abs(r.tip - space.tip).max() < 3e-4, f"{r.tip}, {space.tip}")
    near("in the mirror", -mirror.tip_x2[-1], r.tip_x2[-1], 1e-12)


# --- what touches something else (the scenes of the gallery, on coarser meshes) ------------------

@check
def a_root_stalls_at_a_stone_goes_round_it_and_keeps_the_bend():
    r = Run("-options_file options/root-stone.opts -ts_max_time 4 -rod_cells 60")
    stalled = np.interp([1, 1.6], r.t, r.length)
    expect(np.ptp(stalled) < 0.01 and r.length[-1] > stalled[0] + 1.5, f"length {stalled}, at the end {r.length[-1]}")
    expect(r.tip_x1[-1] > 2.8 and abs(r.tip_x2[-1]) > 0.5, f"the tip is at {r.tip}")
    bend = r.shapes["natural_curvature"][-1]
    expect(np.abs(bend[r.shapes["x"][-1, :, 0] < 1.7]).max() > 0.5, "it has not kept the bend")
    expect(r.energy_defect[-1] < 2e-3, f"the balance of energy is off by {r.energy_defect[-1]:g}")


@check
def a_root_waves_on_a_tilted_plate_and_not_on_an_upright_one():
    """Its direction along the plate goes to both sides, and back."""
    for tilt, direction in ((45, "1,0,-1"), (10, "0.985,0,-0.174")):
        r = Run(f"-options_file options/root-waving.opts -rod_cells 50 -ts_max_time 34h -ts_rtol 1e-3 -tropism_direction {direction}")
        d = r.shapes["d1"][-1]
        angle = np.arctan2(d[:, 1], d[:, 0])
        sides = angle[angle.argmax():].min(), angle[angle.argmin():].max()
        if tilt == 45:
            expect(angle.min() < -0.5 and angle.max() > 0.5 and sides[1] > 0.5, f"{angle.min()}, {angle.max()}, {sides}")
        else:
            expect(np.abs(angle).max() < 0.2, f"upright it turns by {np.abs(angle).max()}")


@check
def a_shoot_that_circles_twines_round_a_post():
    r = Run("-options_file options/tendril-post.opts -rod_cells 40 -ts_max_time 4 -ts_rtol 1e-3")
    x = r.shapes["x"][-1]
    around = np.unwrap(np.arctan2(x[:, 2] - 0.25, x[:, 1] - 0.5))
    expect(np.ptp(around) > 4 * pi and r.contact_force[-1] > 0.5, f"{np.ptp(around) / 2 / pi} turns, {r.contact_force[-1]}")


@check
def options_that_say_nothing_are_refused():
    for options, word in (("-tropism_gravity 1", "-tropism_direction"), ("-tropism_light 1", "-tropism_source"),
                          ("-tropism_gravity 1 -tropism_direction 0,0", "-tropism_direction"),
                          ("-growth_type none -growth_ironing 1", "-tropism_rate"),
                          ("-growth_type feed -tropism_nutation 1", "-tropism_rate"),
                          ("-tropism_memory 1", "-tropism_memory"), ("-tropism_direction 0,1", "-tropism_direction"),
                          ("-growth_ironing 1 -rod_model linear", "-growth_ironing"),
                          ("-tropism_nutation 1 -tropism_nutation_2 1 -rod_model frame", "-tropism_nutation_2")):
        expect(word in tendril(options, 1), options)


if __name__ == "__main__":
    sys.exit(scene.main())

#!/usr/bin/env python3
"""Growing rods that friction holds, compared with references and exact answers."""

import re
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "support"))
import scene  # takes .venv's python if this one lacks numpy and h5py
from references import DECAY, REFERENCES, SMOOTH, against_reference, expect_reference
from scene import DRY, ROOT, Failure, Run, check, distance, errors, expect, lagrange, order, tip_in_space

import h5py
import numpy as np


@check
def an_accuracy_that_is_asked_is_met():
    """-accuracy is met: the error is at most what was asked, and at least a hundredth of it."""
    for name in ("v_short", "v_gauss", "v_feed", "v_decay_mu1"):
        for asked in (1e-2, 1e-4):
            r, worst = against_reference(name, f"-accuracy {asked}")
            largest = max(max(e) for e in worst.values())
            print(f"{name}: asked {asked:g}, measured {largest:.1e}, estimated {r.estimate:.1e}")
            expect(asked / 100 <= largest <= asked, f"{name}: asked {asked:g}, found {largest:.1e}")
    few = Run(DRY + "-ts_max_time 1 -accuracy 1e-2 -rod_cells 77 -output_interval 1")
    expect(len(few.shapes["s"]) == 78, "-accuracy overrides -rod_cells")


@check
def rods_next_to_straight_creep_as_they_are_bent():
    """Rods next to straight that are laid down under exact friction, taken as a limit, creep by as much as they are bent, and say
    so (5e-5 was told of linear ones, of which that is not measured); under one that is next to exact auto's steps see the short
    waves of the energy (off by 3e-3, told 1.3e-5, while they were those of the linear model)."""
    for creeps in ("-growth_zone 0.556 -growth_initial_length 0.576 -shape_amplitude 4.15e-5 -friction_across 0.3 -tip_force 0.969 "
                   "-ts_max_time 4.4 ",
                   "-growth_zone 0.156 -growth_initial_length 0.306 -shape_amplitude 1.43e-4 -friction_across 0.325 -tip_force 0.474 "
                   "-tip_law resistance -ts_max_time 4.83 "):
        creeps += "-growth_type apical -shape_type sag "
        limit = Run(creeps + "-friction_beta 1e-13 -rod_model frame -rod_cells 500 -ts_rtol 1e-7")
        for model in ("auto", "linear"):
            r = Run(creeps + f"-friction_beta 0 -rod_model {model}")
            error = max(abs(r.series[k][-1] / limit.series[k][-1] - 1) for k in ("norm_x2", "energy"))
            print(f"the limit, {model}: off by {error:.1e}, told {r.estimate:.1e}")
            expect(0.1 < error < r.estimate, f"{model}: off by {error:.1e}, told {r.estimate:.1e}")
    waves = ("-growth_type apical -friction_beta 2e-11 -growth_initial_length 7 -growth_zone 0.72 -shape_type sag "
             "-shape_amplitude 1e-5 -ts_max_time 4 ")
    r, fine = Run(waves + "-rod_model auto"), Run(waves + "-rod_model frame -rod_cells 500 -ts_rtol 1e-7")
    error = abs(np.interp(r.t, fine.t, fine.energy) / r.energy - 1)[r.t > 0.04].max()
    print(f"next to exact: energy off by {error:.1e}, told {r.estimate:.1e}")
    expect(error < 5e-5, f"next to exact: energy off by {error:.1e}")
    # one that starts faster across than beta lets it slide along itself (the linear model is off by 8 %, and was told 5e-5)
    fast = ("-growth_type apical -friction_mu 0.086 -friction_beta 3.21e-7 -growth_initial_length 0.381 -shape_type random "
            "-shape_amplitude 4.17e-5 -shape_seed 669 -ts_max_time 1 -growth_zone 0.193 -friction_across 0.483 ")
    auto, linear, frame = (Run(f"{fast} -rod_model {model}") for model in ("auto", "linear", "frame"))
    for name, r in (("auto", auto), ("linear", linear)):
        error = abs(r.norm_x2[-1] / frame.norm_x2[-1] - 1)
        print(f"fast across, {name}: |x2| off by {error:.1e}, told {r.estimate:.1e}")
        expect(error < r.estimate + frame.estimate and (name == "linear" or error < 1e-3), f"{name}: off by {error:.1e}")


@check
def an_accuracy_that_may_not_be_met_is_doubted():
    """An accuracy that may not be met is doubted, with what would do, and that does. Of friction that is exact where
    material comes to rest the estimate measures what it is off from its limit."""
    rod = "-growth_initial_length 2 -shape_amplitude 0.3 -ts_max_time 3 -accuracy 1e-6 "
    r = Run(rod + "-rod_cells 40")
    asked = re.search(r"-accuracy 1e-06 may not be met, the estimate is above it; give( .*)\.\n", r.said)
    expect(asked and "-rod_cells" in asked[1], r.said)
    expect("may not be met" not in Run(rod + asked[1]).said, f"{asked[1]} is not enough")
    rests = ("-growth_type apical -growth_zone 0.362 -shape_type straight -rod_curvature_random 0.0265 "
             "-rod_curvature_length 3 -rod_curvature_seed 9 -ts_max_time 4 ")
    r, limit = Run(rests + "-friction_beta 0"), Run(rests + "-friction_beta 1e-14 -rod_cells 800 -ts_rtol 1e-7")
    error = abs(r.energy[-1] / limit.energy[-1] - 1)
    print(f"the limit: off by {error:.1e}, estimated {r.estimate:.1e}")
    expect(error < r.estimate < 20 * error, f"energy off by {error:.1e}, estimated {r.estimate:.1e}")
    mixed = Run(rests + "-friction_beta 0 -rod_model mixed")
    error = abs(mixed.energy[-1] / limit.energy[-1] - 1)
    print(f"the limit, by the mixed model: off by {error:.1e}, estimated {mixed.estimate:.1e}")
    expect(error < 1 <= mixed.estimate < 1.5, f"mixed: energy off by {error:.1e}, estimated {mixed.estimate:.1e}")
    expect(", friction " in r.said and "errors at the end: tip " in r.said, r.said)
    bent = ("-growth_type apical -growth_zone 0.56 -growth_initial_length 3 -shape_type straight -rod_curvature 0.04 "
            "-tip_force 1.3 -tip_law follower -friction_across 1.5 -ts_max_time 2 -rod_cells 200 ")
    r, limit = Run(bent + "-friction_beta 0"), Run(bent + "-friction_beta 1e-13 -ts_rtol 1e-7")
    errors = (np.hypot(r.tip_x1[-1] - limit.tip_x1[-1], r.tip_x2[-1] - limit.tip_x2[-1]) / limit.tip_x1[-1],
              *(abs(r.series[k][-1] / limit.series[k][-1] - 1) for k in ("norm_x2", "energy")))
    told = re.search(r"errors at the end: tip (\S+), \|x2\| (\S+), energy (\S+);", r.said)
    for error, part, name in zip(errors, told.groups(), ("tip", "|x2|", "energy")):
        print(f"the limit: {name} off by {error:.1e}, told {part}")
        expect(error < float(part) < 20 * error, f"the limit: {name} off by {error:.1e}, told {part}")
    # a hairpin out of its plane leaves its start to the same side with few cells as with many (with 20 to 26 of them it chatters
    # on its way in a quarter of all runs that differ by 1e-7, and is told up to 0.05)
    start = "-growth_initial_length 2 -shape_amplitude 3.1 -shape_turn 1 -rod_curvature_2 0.05 -ts_max_time 0.3 "
    fine = Run(start + "-rod_cells 80")

    def off_by(r):
        there = tip_in_space(fine)
        return max(abs(r.norm_x2[-1] / fine.norm_x2[-1] - 1), np.linalg.norm(tip_in_space(r) - there) / np.linalg.norm(there))

    for cells, most in (24, 0.1), (40, 1e-2):
        r = Run(f"{start} -rod_cells {cells}")
        off = off_by(r)
        print(f"the hairpin with {cells} cells: off by {off:.1e}, told {r.estimate:.1e}")
        expect(off < 1e-5 and off < r.estimate < most, f"off by {off:.1e}, told {r.estimate:.1e}")
    r = Run(start + "-rod_cells 60 -ts_dt 1e-14")  # and in steps that are shorter than its layer
    off = off_by(r)
    print(f"the hairpin in short steps: off by {off:.1e}, told {r.estimate:.1e}")
    expect(off < r.estimate < 1e-2, f"short steps: off by {off:.1e}, told {r.estimate:.1e}")
    expect(fine.estimate < 1e-3, f"told {fine.estimate:.1e}")
    # a start that snaps, which is followed, and goes on in a blind step, by which it hardly moves
    kicked = "-shape_type sag -shape_amplitude 0.1 -rod_curvature 0.001 -ts_max_time 32 "
    r, fine = Run(kicked), Run(kicked + "-ts_dt 1e-10 -ts_rtol 1e-6")
    off = max(abs(r.series[k][-1] / fine.series[k][-1] - 1) for k in ("norm_x2", "energy"))
    print(f"a start that snaps: off by {off:.1e}, told {r.estimate:.1e}")
    expect(off < r.estimate < 1e-3, f"a start that snaps: off by {off:.1e}, told {r.estimate:.1e}")
    # a run that ends long before its last time tells what is off by then (without a snap, whose share would hide it)
    soon = "-friction_mu 0.5 -rod_cells 60 -shape_amplitude 0.05 -rod_curvature 0.05 -stop_length 20 -ts_max_time 3000 "
    r, fine = Run(soon), Run(soon + "-rod_cells 240 -ts_rtol 1e-7")
    off = max(abs(r.series[k][-1] / fine.series[k][-1] - 1) for k in ("norm_x2", "energy"))
    print(f"ended soon: off by {off:.1e}, told {r.estimate:.1e}")
    expect(off < r.estimate < 1e-2, f"ended soon: off by {off:.1e}, told {r.estimate:.1e}")
    # of a straight rod that nothing moves no energy is missing; one that grows stays about its middle
    straight = "-clamp_type free -shape_type straight -rod_cells 40 -ts_max_time 1 "
    still, grows = Run(straight + "-growth_type none"), Run(straight)
    expect(still.energy_defect.max() < 1e-3, f"at rest: energy defect {still.energy_defect.max():.1e}")
    expect(abs(grows.tip_x1[-1] - 1) < 1e-7, f"free: the tip is at {grows.tip_x1[-1]!r}")
    # the energy of a rod that is bent by next to nothing is that of its bend, not round-off's
    fed = ("-growth_type feed -growth_initial_length 0.5 -rod_cells 40 -ts_max_time 1 -ts_rtol 1e-4 "
           "-shape_type straight -rod_curvature ")
    much, little = Run(fed + "1e-3"), Run(fed + "1e-8")
    print(f"bent by 1e-3 and 1e-8: told {much.estimate:.1e}, {little.estimate:.1e}")
    expect(abs(little.estimate / much.estimate - 1) < 0.1, f"told {much.estimate}, {little.estimate}")
    # nor of one that rests as it is bent by nature: what round-off does to an energy of nothing is no error
    for options in ("", "-rod_curvature 1e-6", "-rod_curvature_2 0.1 -rod_twist 1"):
        r = Run(f"-growth_type none -growth_initial_length 2 -shape_type straight -rod_curvature 0.1 -ts_max_time 1 {options}")
        print(f"at rest, bent by nature: told {r.estimate:.1e}")
        expect(r.estimate < 1e-5 and "balance" not in r.said, f"at rest: told {r.estimate:.1e}, {r.said}")


@check
def errors_of_the_linear_model_are_told():
    """The linear model's errors: of its splines in a narrow zone of growth, of short waves that are what is left, and of what
    falls by many orders while |x2| is that of a clamp that leans."""
    for name, options, cells in (
            ("a narrow zone", "-growth_type gaussian -growth_width 0.0183 -growth_initial_length 0.591 -shape_amplitude 9.1e-11 ", 300),
            ("short waves", "-friction_beta 0 -growth_initial_length 6.56 -shape_amplitude 3.26e-10 ", 200),
            ("a clamp that leans", "-growth_type gaussian -growth_width 2.83 -friction_beta 7.22e-7 -growth_initial_length 0.266 "
             "-shape_amplitude 6.52e-11 -clamp_angle -1.56 ", 100)):
        r, fine = Run(options + "-ts_max_time 2 -rod_cells 100 -rod_model auto"), Run(options + f"-ts_max_time 2 -rod_cells {cells} -ts_rtol 1e-7")
        off = max(abs(r.series[k][-1] / fine.series[k][-1] - 1) for k in ("norm_x2", "energy"))
        print(f"{name}: off by {off:.1e}, told {r.estimate:.1e}")
        expect(off < r.estimate and "a fit" in r.said, f"{name}: off by {off:.1e}, told {r.estimate:.1e}")
    bent = "-growth_initial_length 2 -shape_amplitude 0.3 -ts_max_time 2 -rod_model "  # what is left out of the linear model is most of it
    r, whole = Run(bent + "linear"), Run(bent + "frame")
    off = max(abs(r.series[k][-1] / whole.series[k][-1] - 1) for k in ("norm_x2", "energy"))
    print(f"bent: off by {off:.1e}, told {r.estimate:.1e}")
    expect(off < r.estimate < 100 * off, f"bent: off by {off:.1e}, told {r.estimate:.1e}")


@check
def what_steps_leave_at_kinks_is_in_the_estimate():
    """A fed arch whose material comes to rest and is torn off, each a kink in time: what steps leave there is in the
    estimate, though differences behind a kink cancel."""
    arch = ("-growth_type feed -growth_initial_length 1 -tip_type pinned -shape_amplitude 0.1 -clamp_angle -1.49 -friction_mu 0.8 "
            "-friction_beta 2.3e-12 -friction_across 2.96 -rod_cells 100 -ts_max_time 2.4 ")
    r, fine = Run(arch), Run(arch + "-ts_rtol 3e-8")
    error = max(abs(r.series[k][-1] / fine.series[k][-1] - 1) for k in ("norm_x2", "energy"))
    print(f"kinks: off by {error:.1e}, estimated {r.estimate:.1e}")
    expect(error < 1.4 * r.estimate, f"kinks: off by {error:.1e}, estimated {r.estimate:.1e}")


@check
def lengths_too_short_for_the_cells_are_told():
    """Lengths that a scene gives: what cells are too long for is in the estimate, and said in a line."""
    layer = "-ts_max_time 3 -shape_amplitude 0.8 -friction_layers 0:1,1.1:0.34 -friction_layer_width 0.0054 "
    bell = "-growth_type apical -growth_initial_length 1 -rod_curvature_random 0.1 -ts_max_time 3 "
    distance, s, t = np.unique(np.r_[np.linspace(0, 6, 60), np.linspace(0.37, 0.43, 61)]), np.linspace(0, 1, 41), np.linspace(0, 2, 9)
    for name, table in (("notch", dict(distance=distance, factor=1 - 0.5 * np.exp(-((distance - 0.4) / 0.005)**2))),
                        ("smooth", dict(distance=distance, factor=1 + 0.3 * np.sin(distance))),
                        ("hook", dict(s=np.array([0, 0.2, 0.7, 0.9, 0.96, 0.98, 1]), curvature=np.array([0, 0, 0, 0, 0, 0.5, 0.5]))),
                        ("even", dict(s=np.linspace(0, 1, 500), curvature=np.sin(3 * np.linspace(0, 1, 500)))),
                        ("bulge", dict(s=s, t=t, g=1 + t[:, None] * np.exp(-((s - 0.5) / 0.03)**2)))):
        with h5py.File(f"{scene.SCRATCH}/{name}.h5", "w") as f:
            for key, values in table.items():
                f[key] = values
    for options, more, says in ((layer, "-rod_cells 150", "-friction_layer_width 0.0054"),
                                (bell + "-growth_zone 0.05 ", "-rod_cells 40", "-growth_zone 0.05"),
                                (bell + "-growth_zone 0.17 ", "-accuracy 1e-4", None),
                                (f"{DRY}-ts_max_time 1 -rod_stiffness_file {scene.SCRATCH}/notch.h5 ", "-rod_cells 15", "-rod_stiffness_file"),
                                (f"{DRY}-ts_max_time 1 -rod_stiffness_file {scene.SCRATCH}/smooth.h5 ", "-rod_cells 40", None),
                                (f"-shape_amplitude 0.1 -ts_max_time 1 -growth_type table -growth_table {scene.SCRATCH}/bulge.h5 ", "-rod_cells 10", "-growth_table"),
                                (DRY + f"-ts_max_time 0.1 -rod_curvature_file {scene.SCRATCH}/hook.h5 ", "-rod_cells 60", "bends of (in s) 0.02"),
                                (DRY + f"-ts_max_time 0.1 -rod_curvature_file {scene.SCRATCH}/even.h5 ", "-rod_cells 60", None),
                                (DRY + "-ts_max_time 3 ", "-rod_cells 60", None)):
        r = Run(options + more)
        fine = Run(options + "-rod_cells 2000 -ts_rtol 1e-7")
        error = max(np.hypot(r.tip_x1[-1] - fine.tip_x1[-1], r.tip_x2[-1] - fine.tip_x2[-1]) / fine.tip_x1[-1],
                    *(abs(r.series[k][-1] / fine.series[k][-1] - 1) for k in ("norm_x2", "energy")))
        print(f"{options}{more}: off by {error:.1e}, estimated {r.estimate:.1e}")
        expect(error < r.estimate, f"{options}{more}: off by {error:.1e}, estimated {r.estimate:.1e}")
        expect("-accuracy" not in more or error < 1e-4, f"{options}{more}: off by {error:.1e}")
        expect(says is None or says in r.said, f"{options}{more}: nothing is said of {says}")
        expect(says or "may miss it" not in r.said, f"{options}{more}: warns: {r.said}")
    # errors are carried along on cells that are not longer than a bend of the rod, however long that is
    long = "-growth_initial_length 60 -shape_type straight -rod_curvature_random 0.05 -ts_max_time 0.1 -rod_cells "
    r, fine = Run(long + "300"), Run(long + "900 -ts_rtol 1e-8")
    error = max(abs(r.series[k][-1] / fine.series[k][-1] - 1) for k in ("norm_x2", "energy"))
    print(f"a rod of length 60: off by {error:.1e}, estimated {r.estimate:.1e}")
    expect(error < r.estimate < 0.2, f"a rod of length 60: off by {error:.1e}, estimated {r.estimate:.1e}")
    # of a wire that is spun the bends in both directions turn into each other
    r = Run("-options_file options/wire-spun.opts -rod_cells 30 -ts_max_time 1.5")
    expect(r.estimate < 1.5e-4, f"a spun wire is told {r.estimate:.1e}")
    r = Run("-growth_type gaussian -growth_width 1e-4 -ts_max_time 5")
    expect(r.tip_x1[-1] < r.length[-1] + 1e-6, f"a rod {r.length[-1]} long has its tip at {r.tip_x1[-1]}")


@check
def the_frame_model_meets_the_references():
    for name in REFERENCES:
        expect_reference(name, "", 1e-5)


@check
def the_automatic_model_meets_the_references():
    for name in REFERENCES:
        expect_reference(name, "-rod_model auto", 1e-5)


@check
def the_factored_decay_takes_half_the_steps():
    """With the factor of the fields across taken out, the decay takes half the steps for a smaller
    error, in every model and law."""
    plain = "-ts_bdf_factor 0 -ts_bdf_order 5"
    for options in (DECAY, DECAY + "-friction_mu 0", DECAY + "-rod_model auto",
                    DECAY + "-rod_model mixed", DECAY + "-growth_type gaussian",
                    DECAY + "-growth_type feed", DECAY + "-friction_beta 0"):
        options = options.replace("-ts_max_time 40", "-ts_max_time 12 -rod_cells 150")
        fine = Run(f"{options} {plain} -ts_rtol 1e-9")
        for rtol in ("1e-5", "1e-6"):
            runs = [Run(f"{options} -ts_rtol {rtol} {more}") for more in ("", plain)]
            e = [abs(r.at("norm_x2", 11.9) / fine.at("norm_x2", 11.9) - 1) for r in runs]
            n = [r.steps for r in runs]
            print(f"{options} -ts_rtol {rtol}: steps {n[0]} and {n[1]}, "
                  f"errors {e[0]:.1e} and {e[1]:.1e}")
            expect(n[0] < 0.62 * n[1] and e[0] < 0.5 * e[1], f"{options} -ts_rtol {rtol}: {n}, {e}")
    # a decay so fast that a step could lose what the tolerance is measured by
    r = Run("-growth_initial_length 0.25 -shape_amplitude 0.1 -ts_max_time 5")
    print(f"L0 = 0.25: {r.steps} steps, |x2| {r.norm_x2[-1]:.4g}")
    expect(abs(r.norm_x2[-1] / 2.83415e-90 - 1) < 0.01 and r.steps < 600, f"L0 = 0.25: {r.steps}")
    # a rod that follows its natural curvature, x2 like its length squared: no harm where it does
    # not pay, by what the estimates say
    for options in ("-rod_curvature_random 0.003 -growth_initial_length 0.08 -shape_amplitude 1e-11 "
                    "-ts_max_time 0.8", "-rod_curvature 0.3 -shape_type straight -ts_max_time 32"):
        n = [Run(f"{options} -rod_cells 150 {more}").steps for more in ("", plain)]
        print(f"{options}: steps {n[0]} and {n[1]}")
        expect(n[0] < 1.1 * n[1], f"{options}: {n}")


@check
def what_is_seen_has_no_seam_between_the_models():
    """What is observed in the linear model, before it hands over, is what the frame model shows."""
    options = "-ts_max_time 13 -ts_rtol 1e-8 -rod_model"
    auto, frame = Run(options + " auto"), Run(options + " frame")
    expect(auto.model[-1] == 1 and (auto.model == 0).any(), "no hand-over before t = 13")
    for t in (2, 8, auto.t[auto.model == 0][-1], auto.t[auto.model == 0][-1] + 0.1):
        apart = {k: abs(auto.at(k, t) / frame.at(k, t) - 1)
                 for k in ("norm_x2", "energy", "max_angle", "base_force_1", "dissipation")}
        print(f"t = {t:.2f}:", ", ".join(f"{k} {e:.1e}" for k, e in apart.items()))
        expect(max(apart.values()) < 5e-5, f"t = {t:.2f}: {apart}")


@check
def the_mixed_model_meets_the_references():
    for name in REFERENCES:
        expect_reference(name, "-rod_model mixed -rod_cells 1000 -ts_rtol 1e-6", 1e-3)


@check
def errors_in_space_have_the_order_of_the_model():
    """From the finest pair, time error far below, against a finer run of another kind."""
    bent = SMOOTH + "-ts_max_time 1 -ts_rtol "
    small = SMOOTH.replace("0.1", "1e-6", 1) + "-ts_max_time 1 -ts_rtol "
    fine, fine_small = Run(bent + "1e-10 -rod_cells 600"), Run(small + "1e-10 -rod_cells 600")
    for what, options, exact, cells, should in (
            ("frame, order 2", bent + "1e-8 -rod_order 2", fine, (120, 240, 480), 2),
            ("frame, order 4", bent + "1e-10", fine, (12, 24, 48), 4),
            ("mixed", bent + "1e-10 -rod_model mixed", fine, (40, 80, 160), 2),
            ("linear", small + "1e-10 -rod_model linear", fine_small, (16, 32, 64), 4)):
        for k, e in errors(options, cells, exact).items():
            print(f"{what:15} {k:8} errors {e[0]:.1e} {e[1]:.1e} {e[2]:.1e}, order {order(e):.2f}")
            low = 3 if (what, k) == ("linear", "energy") else should - 0.3  # the moment lags a little
            expect(low < order(e) < should + 0.8, f"{what}: {k} order {order(e):.2f}")


@check
def backward_euler_is_of_first_order():
    """First order in time at fixed steps."""
    short = SMOOTH + "-ts_max_time 1 -rod_cells 100 "
    fine = Run(short + "-ts_rtol 1e-9")
    e = [distance(Run(f"{short} -ts_type beuler -ts_dt {h}").tip, fine.tip)
         for h in (0.02, 0.01, 0.005)]
    r = Run(f"{short} -ts_type beuler")  # the paper's step by default
    print(f"beuler: tip {e[0]:.1e} {e[1]:.1e} {e[2]:.1e}, order {order(e):.2f}")
    expect(0.9 < order(e) < 1.1, f"order {order(e):.2f}")
    expect(r.steps == 100 and np.ptp(r.step[1:]) < 1e-12, f"{r.steps} steps")
    expect(abs(distance(r.tip, fine.tip) / e[1] - 1) < 1e-3, "0.01 is not the default step")


@check
def the_bdf_of_petsc_gives_the_same_rod():
    fine = Run(DRY + "-ts_max_time 1 -ts_rtol 1e-9")
    r = Run(DRY + "-ts_max_time 1 -ts_type bdf -ts_bdf_order 5")
    print(f"PETSc's bdf: tip off by {distance(r.tip, fine.tip):.1e} in {r.steps} steps")
    expect(distance(r.tip, fine.tip) < 1e-6, f"tip off by {distance(r.tip, fine.tip):.1e}")


@check(ranks=2)
def several_ranks_agree():
    """1, 2 and 3 ranks agree to 1e-7."""
    small = "-ts_max_time 1.2 -rod_cells 100"
    for options in (DRY + "-ts_max_time 1 -rod_cells 100",
                    DRY + "-ts_max_time 1 -rod_cells 100 -rod_model mixed",
                    "-growth_type gaussian -growth_width 0.05 -ts_max_time 3 -rod_cells 100",
                    small + " -rod_model linear", small + " -rod_model auto",
                    "-ts_max_time 5 -rod_curvature 0.02 -rod_curvature_random 0.1 -shape_type straight -rod_cells 100"):
        one = Run(options)
        for n in (2, 3):
            r = Run(options, ranks=n)
            tip, norm = distance(r.tip, one.tip), abs(r.norm_x2[-1] / one.norm_x2[-1] - 1)
            print(f"{options}: {n} ranks, tip {tip:.1e}, |x2| {norm:.1e}")
            expect(tip < 1e-7 and norm < 1e-7 and abs(r.tip_x2[-1] / one.tip_x2[-1] - 1) < 1e-7,
                   f"{options}: {n} ranks differ, tip by {tip:.1e}, |x2| by {norm:.1e}")


@check
def a_straight_rod_stays_straight_and_bears_its_exact_force():
    """x2 = 0 stays exactly 0, and the clamp bears what docs/notes/exact-answers.md says."""
    for model in ("frame", "mixed", "linear", "auto"):
        for law in ("uniform", "gaussian", "feed"):
            r = Run(f"-shape_type straight -rod_model {model} -growth_type {law} -ts_max_time 4 "
                    "-rod_cells 50")
            for name in ("norm_x2", "tip_x2", "max_angle", "width", "energy", "base_force_2"):
                expect(not r.series[name].any(), f"{model}, {law}: {name} is not 0")
            expect(not r.shapes["x"][:, :, 1].any(), f"{model}, {law}: x2 is not 0")
            expect(np.allclose(r.tip_x1, 0.5 + r.t, rtol=1e-7), f"{model}, {law}: tip")
            if law == "uniform":
                r = Run(f"-shape_type straight -rod_model {model} -ts_max_time 2 -friction_mu 0.7")
                force = (0.5 + r.t) * (0.7 * (1.001 ** 0.5 - 0.001 ** 0.5) + 0.15)
                worst = np.abs(r.base_force_1 / force - 1).max()
                print(f"{model}: force at the clamp to {worst:.1e}")
                expect(worst < (1e-4 if model == "mixed" else 1e-8), f"{model}: force at the clamp off by {worst:.1e}")


@check
def a_mirrored_shape_gives_the_mirrored_rod():
    for model in ("frame", "mixed", "linear", "auto"):
        options = f"-growth_initial_length 2 -ts_max_time 6 -rod_cells 100 -rod_model {model}"
        a, b = (Run(f"{options} -shape_amplitude {e}") for e in ("0.1", "-0.1"))
        expect(a.steps == b.steps, f"{model}: {a.steps} and {b.steps} steps")
        for name, sign in (("tip_x1", 1), ("tip_x2", -1), ("norm_x2", 1), ("energy", 1),
                           ("base_force_2", -1)):
            expect(np.allclose(a.series[name], sign * b.series[name], rtol=1e-12, atol=0),
                   f"{model}: {name} differs")


@check
def the_whole_run_turns_with_the_clamp():
    """The whole run turns with the clamp; what has no direction stays."""
    options, angle = DRY + "-ts_max_time 6 -rod_cells 100", 0.7
    a, b = Run(options), Run(f"{options} -clamp_angle {angle}")
    turn = np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])
    for name in ("x", "force"):
        expect(np.allclose(a.shapes[name] @ turn, b.shapes[name], atol=1e-12), f"{name} not turned")
    expect(np.allclose(a.shapes["theta"] + angle, b.shapes["theta"], atol=1e-12), "theta")
    expect(np.allclose(a.shapes["curvature"], b.shapes["curvature"], atol=1e-12), "curvature")
    expect(np.allclose(a.tip @ turn, b.tip, atol=1e-12), "tip")
    for name in ("energy", "width", "max_angle", "end_distance", "dissipation", "self_crossings"):
        expect(np.allclose(a.series[name], b.series[name], rtol=1e-12), f"{name} changed")


@check
def amplitudes_of_any_size_decay_alike():
    """Amplitudes from 1e-13 to 1e-2 decay alike: x2 is followed relative to its own size."""
    for model in ("frame", "mixed", "linear"):
        decay = {}
        for amplitude in (1e-2, 1e-5, 1e-13):
            r = Run(f"-ts_max_time 1.5 -rod_model {model} -shape_amplitude {amplitude}")
            decay[amplitude] = r.norm_x2[-1] / r.norm_x2[0]
        print(f"{model}: decay to", *(f"{d:.7e}" for d in decay.values()))
        expect(decay[1e-2] < 1e-10, f"{model}: no decay, {decay[1e-2]:.1e}")
        expect(abs(decay[1e-13] / decay[1e-5] - 1) < 1e-5, f"{model}: {decay}")
        expect(abs(decay[1e-13] / decay[1e-2] - 1) < 0.1, f"{model}: {decay}")  # not yet linear


@check
def stored_rates_are_those_of_the_steps():
    """The rates that are stored are those of the steps: the tip's speed across the rod, of which
    tip_speed at a small deflection has just the square, against the change of tip_x2."""
    for model in ("frame", "linear"):
        r = Run(f"-growth_initial_length 2 -shape_amplitude 1e-3 -ts_max_time 0.1 -ts_rtol 1e-8 "
                f"-rod_model {model}")
        ahead = np.gradient(r.tip_x1, r.t)
        across = np.abs(np.diff(r.tip_x2) / np.diff(r.t))[1:6]
        speed = np.sqrt(np.maximum(r.tip_speed ** 2 - (1 if model == "linear" else ahead ** 2), 0))
        between = (speed[1:6] + speed[2:7]) / 2
        off = np.abs(between / across - 1).max()
        print(f"{model}: across {across}, stored {between}")
        expect(off < 0.05, f"{model}: off by {off:.1e}")


@check
def exact_friction_adds_no_noise_in_the_small():
    """Where |x2| falls to 1e-25, exact Coulomb friction adds no noise of its own."""
    r = Run("-growth_initial_length 0.389 -shape_type random -shape_amplitude 0.0432 -shape_seed 37 "
            "-ts_max_time 28 -friction_beta 0")
    print(f"tip {r.tip}, |x2| at least {r.norm_x2.min():.1e}, defect {r.energy_defect[-1]:.1e}")
    expect(r.norm_x2.min() < 1e-24, f"|x2| falls to {r.norm_x2.min():.1e} only")
    expect(abs(r.tip[0] - 20.40006) < 2e-4, f"tip {r.tip}, with beta = 1e-12 at 20.40006")


@check
def a_front_half_held_by_exact_friction_stands_still():
    """A fed rod whose front half rests, held by exact Coulomb friction: it stands still, and to hold
    it does not take many iterations."""
    r = Run(f"-options_file {ROOT}/options/feed.opts -friction_beta 0 -ts_max_time 16")
    per_step, creep = r.newton_iterations.sum() / r.steps, r.tip_speed[r.t > 7].max()
    print(f"{per_step:.2f} iterations per step, tip {r.tip}, its speed at most {creep:.1e}")
    expect(per_step < 8, f"{per_step:.2f} iterations per step")
    expect(creep < 1e-6, f"the tip creeps at {creep:.1e}")
    expect(distance(r.tip, (5.9121178, 0.8109298)) < 1e-6, f"tip {r.tip}")
    r = Run(f"-options_file {ROOT}/options/feed.opts -friction_beta 0 -ts_max_time 12 -ts_rtol 1e-7")
    creep = r.tip_speed[r.t > 7].max()
    print(f"-ts_rtol 1e-7: the speed of the tip at most {creep:.1e}")
    expect(creep < 3e-8, f"-ts_rtol 1e-7: the tip creeps at {creep:.1e}")  # held again within a step


@check
def both_linearisations_reach_one_solution():
    """Both linearisations reach one solution; the primal-dual one takes no more iterations, and few
    where the primal one takes many or fails."""
    for options in (DRY + "-ts_max_time 8", DRY + "-ts_max_time 4 -friction_beta 1e-5"):
        a = Run(options + " -friction_newton primal_dual")
        b = Run(options + " -friction_newton primal")
        print(f"{options}: {a.newton_iterations.sum():.0f} and {b.newton_iterations.sum():.0f} "
              f"iterations, tips differ by {distance(a.tip, b.tip):.1e}")
        expect(distance(a.tip, b.tip) < 1e-5, f"tips differ by {distance(a.tip, b.tip):.1e}")
        expect(a.newton_iterations.sum() <= b.newton_iterations.sum(), "primal takes fewer")
        # (one that has arrived is not repeated to see it: 1.05 and 1.07 a step)
        expect(a.newton_iterations.sum() < 1.6 * a.steps, f"{a.newton_iterations.sum() / a.steps:.2f} iterations a step")
    options = DRY + "-ts_max_time 10 -rod_cells 200 -friction_beta 1e-9 -friction_newton "
    a = Run(options + "primal_dual")
    try:
        b = Run(options + "primal")
        expect(b.newton_iterations.sum() > a.newton_iterations.sum(), "primal does as well")
        print(f"primal ends at beta = 1e-9, in {b.newton_iterations.sum():.0f} iterations")
    except Failure as failure:
        expect("gave up at t =" in str(failure), failure)
        print("primal gives up at beta = 1e-9")


@check(ranks=(1, 2))
def other_ways_to_solve_a_step_end_in_the_same_place(ranks):
    """PETSc's other ways to solve a step end in the same place, also those that need the matrix, which
    by default is not there."""
    options = f"-options_file {ROOT}/options/feed.opts -ts_max_time 3 -rod_cells 60 -ts_rtol 1e-7 "
    tip = Run(options).tip
    for way in ("-snes_linesearch_type bt", "-snes_linesearch_type l2", "-snes_type newtontr",
                "-snes_lag_jacobian 2", "-pc_type lu", "-pc_type ilu -ksp_type gmres", "-snes_mf_operator",
                "-snes_fd_color", "-snes_ksp_ew"):
        if ranks > 1 and way.startswith("-pc_type"):
            continue  # (these are of one rank)
        off = distance(Run(options + way, ranks).tip, tip)
        print(f"{way}, ranks {ranks}: tip off by {off:.1e}")
        expect(off < 1e-6, f"{way}, ranks {ranks}: tip off by {off:.1e}")


@check
def friction_may_be_nearly_exact():
    """beta from 1e-2 to 1e-12 with all else at its default."""
    before = {}
    for exponent in range(2, 13):
        for name, options in (("short", "-ts_max_time 5"),
                              ("folded", "-ts_max_time 32 -rod_cells 200")):
            r = Run(f"{DRY} {options} -friction_beta 1e-{exponent}")
            per_step = r.newton_iterations.sum() / r.steps
            moved = distance(r.tip, before.get(name, r.tip))
            before[name] = r.tip
            print(f"beta 1e-{exponent}, {name}: {r.steps} steps, {per_step:.2f} iterations per step, "
                  f"tip {r.tip[0]:.7f} {r.tip[1]:.7f}")
            expect(per_step <= 4, f"beta 1e-{exponent}: {per_step:.2f} iterations per step")
            beta = 10. ** (1 - exponent)
            bound = 0.1 * beta + 3e-7 if name == "short" else beta ** 0.5
            expect(moved < bound, f"beta 1e-{exponent}, {name}: tip moved by {moved:.1e}")


def task_of(file):
    found = re.search(r"^-task\s+(\w+)", file.read_text(), re.MULTILINE)
    return found.group(1) if found else "grow"


SNAPS = "-growth_initial_length 2 -shape_amplitude {} -ts_max_time 5 "


@check(ranks=2)
def a_bent_rod_that_friction_cannot_hold_snaps_on_two_ranks_as_on_one():
    for amplitude in ("1.5", "3.1"):
        one, two = (Run(SNAPS.format(amplitude), ranks).tip for ranks in (1, 2))
        print(f"{amplitude}: two ranks differ by {distance(two, one):.1e}")
        expect(distance(two, one) < 1e-5, f"{amplitude}: two ranks, tip {two}")


@check
def a_bent_rod_that_friction_cannot_hold_snaps_by_the_viscous_path():
    """Where dry friction cannot hold a bent rod, it takes the path of a vanishing viscous share: the
    limit of 1 - mu = 1e-3, 5e-4, 2e-4, which follow no snap. (A single step of backward Euler would miss the bent rod's tip by
    0.2 %, the hairpin's by a quarter.)"""
    for amplitude in ("1.5", "3.1"):
        bent = SNAPS.format(amplitude)
        nearly = [Run(bent + f"-friction_mu {1 - share}").tip for share in (1e-3, 5e-4, 2e-4)]
        limit = lagrange((1e-3, 5e-4, 2e-4), nearly)
        dry = Run(bent)
        stuck = Run(bent + "-friction_beta 0").tip
        print(f"{amplitude}: limit {limit}, dry off by {distance(dry.tip, limit):.1e}, exact Coulomb by {distance(stuck, limit):.1e}")
        expect(distance(dry.tip, limit) < 2e-4, f"{amplitude}: tip {dry.tip}, not {limit}")
        expect(distance(dry.tip, limit) < dry.estimate * np.hypot(*limit), f"{amplitude}: told {dry.estimate:.1e}")
        expect(distance(stuck, limit) < 2e-3, f"{amplitude}: exact Coulomb, tip {stuck}")
        expect(dry.energy_defect[-1] < 1e-3, f"{amplitude}: defect {dry.energy_defect[-1]:.1e}")
    behind = ("-growth_type gaussian -growth_width 0.552 -growth_initial_length 0.357 -shape_amplitude 1.65 "
              "-ts_max_time 0.001 ")
    x2, right = (Run(behind + dt).norm_x2[-1] for dt in ("", "-ts_dt 1e-12"))
    print(f"behind a snap at the start: |x2| {x2:.6e}, with a first step of 1e-12 {right:.6e}")
    expect(abs(x2 - right) < 1e-4 * right, f"behind a snap at the start: |x2| {x2}, not {right}")


@check
def a_rod_at_the_brink_of_a_snap_is_asked_again():
    """A rod fed under a force comes to the brink of a snap in ever smaller steps. Asked too early it rests, and
    is left where it is, to be asked again: taken to where it rested it was lost, or not, as the tolerance had
    it. Asked too late, or not again, it came to steps of round-off. In the last one it barely sticks behind the first snap, and slips in steps that are as short. A start out of
    balance, whose first steps are far below what was guessed, is no snap."""
    fed = "-growth_type feed -shape_type sag "
    for options, tolerances in (
            ("-growth_initial_length 0.764 -shape_amplitude 0.0166 -friction_beta 1.09e-6 -ts_max_time 1.33 "
             "-tip_force 3.154", ("1.05e-6", "1.4e-6", "2e-6", "3e-6")),
            ("-growth_initial_length 0.468 -shape_amplitude 0.284 -friction_beta 1e-12 -ts_max_time 1.18 "
             "-tip_force 3.656", ("1e-6",))):
        right = Run(f"{fed} {options} -friction_mu 0.999").tip
        for rtol in tolerances:
            r = Run(f"{fed} {options} -ts_rtol {rtol}")
            print(f"{options}, {rtol}: tip {r.tip}, {r.steps} steps, {r.newton_iterations.sum():.0f} Newton")
            expect(distance(r.tip, right) < 1e-4, f"{options} {rtol}: tip {r.tip}, not {right}")
            # (never asked again it creeps there, in ten times as many)
            expect(r.newton_iterations.sum() < 4000, f"{options} {rtol}: {r.newton_iterations.sum()} Newton iterations")
    start = ("-growth_type gaussian -growth_width 1.69 -growth_initial_length 0.618 -shape_amplitude 0.0232 "
             "-friction_across 0.596 -rod_cells 100 -ts_max_time 1e-4 ")
    loose, tight = Run(start + "-ts_rtol 1e-7"), Run(start + "-ts_rtol 1e-9")
    error = max(abs(tight.at("energy", t) / e - 1) for t, e in zip(loose.t, loose.energy) if t > 1e-6)
    print(f"a start out of balance: energies differ by {error:.1e}, told {loose.estimate:.1e}")
    expect(error < 1e-5 and "snaps" not in tight.said, f"a start is taken for a snap: off by {error:.1e}, {tight.said}")
    # (steps that are not smooth in time are rejected, and err more than differences tell)
    expect(error < loose.estimate < 15 * error, f"a start: off by {error:.1e}, told {loose.estimate:.1e}")


@check
def what_comes_and_goes_within_a_step_is_seen():
    """What tables give in time, and comes and goes within what would be a step of a rod that rests: steps end where
    it sets out, and see it, as they do where it begins with the run."""
    d, bump = Path(scene.SCRATCH), np.array([0, 1, 0])
    still = "-growth_type none -growth_initial_length 1 -shape_type straight -rod_curvature 0.2 "

    def csv(name, t, value, also=""):
        np.savetxt(d / f"{name}.csv", np.c_[t, value], delimiter=",", header="t," + name, comments="", fmt="%.9f")
        return d / f"{name}.csv"

    def h5(t, what, goes, axes):  # (many rows: a spline through few would swing)
        times = np.linspace(0, 10, 501)
        value = 1 + goes * (np.abs(times - t[1]) < 0.009)
        with h5py.File(d / "table.h5", "w") as f:
            f["t"], f[what] = times, np.multiply.outer(value, np.ones([len(x) for x in axes.values()][::-1]))
            for name, at in axes.items():
                f[name] = at
        return d / "table.h5"

    def most(name):
        return lambda r, since: np.abs(r.series[name])[r.t > since].max()

    scenes = {  # what is seen of it, and options for what comes at a time
        "-tip_path": (most("energy"), lambda t: still + "-friction_mu 0 -friction_layers 0:1 -tip_type pinned -tip_path "
                      f"{csv('x1', t, 0.9933466 - 0.08 * bump)}"),
        "-tip_path, in space": (most("energy"), lambda t: still + "-friction_mu 0 -friction_layers 0:1 -tip_type pinned "
                                f"-rod_model space -tip_path {csv('x1', t, 0.9933466 - 0.08 * bump)}"),
        "-clamp_path": (most("twist"), lambda t: still + f"-friction_radius 0.05 -clamp_path {csv('turn', t, bump)}"),
        "-growth_table": (most("length"), lambda t: "-growth_type table -shape_amplitude 0.01 -growth_table "
                          f"{h5(t, 'g', 0.1, {'s': np.linspace(0, 1, 4)})}"),
        "-friction_field": (lambda r, since: r.norm_x2[-1], lambda t: still + "-friction_beta 0 -rod_weight 0,-0.5 -friction_field "
                            f"{h5(t, 'factor', -0.9, {'x1': [0.0], 'x2': [0.0]})}")}
    for name, (seen, options) in scenes.items():
        early, late = (Run(options(at + np.array([0, 0.01, 0.02])) + " -ts_max_time 10 -rod_cells 60") for at in (0.03, 4.99))
        seen = seen(early, 0.02), seen(late, 4)
        print(f"{name}: {early.steps}, {late.steps} steps, {seen}")
        # (how far a path goes is met to the last digits where a step ends; a spline's rows are not where it is highest)
        expect(abs(seen[1] / seen[0] - 1) < (1e-5 if "tip_path" in name else 2e-3), f"{name}: {seen}")


@check
def rods_beyond_critical_give_way_to_the_side_they_are_bent_to():
    """Rods beyond critical at the start give way to the side they are bent to, one half-way by the path
    of a vanishing viscous share: a first step longer than the time in which they grow would mirror them.
    The reference shares no snap and no such step: mu = 0.999 where friction is dry, and first steps of
    1e-12."""
    starts = [(length, load, amplitude, mu) for length, load, amplitude, mu in (
        (.05, 8, 1, 0), (.05, 8, 1, 1), (.05, 15, .1, 1), (.05, 15, 1, 1), (.1, 8, 1, 0), (.1, 15, 1, 1),
        (.2, 15, .1, 0), (.35, 15, 1, 0), (.5, 60, .1, 1), (.5, 60, 1, 0))]
    for length, load, amplitude, mu in starts:
        rod = (f"-growth_initial_length {length} -tip_force {load / length ** 2:.6g} "
               f"-shape_amplitude {amplitude} -rod_cells 100 -ts_max_time {.2 * length:.3g} ")
        right = Run(rod + f"-friction_mu {min(mu, .999)} -ts_dt 1e-12").tip
        for more in ("", "-ts_rtol 1e-4", "-ts_rtol 1e-8"):
            tip = Run(rod + f"-friction_mu {mu} {more}").tip
            expect(distance(tip, right) < 0.01, f"{rod} mu {mu} {more}: tip {tip}, not {right}")
        print(f"L {length}, P L^2 {load}, amplitude {amplitude}, mu {mu}: tip {tip / length}")
    # far beyond critical a first step, or one in the fast time of a snap, may go far past a mode that dry friction hides
    # from a rod at rest, and end where there is none
    for growth, length, force, amplitude, share, cells in (
            ("feed", .112, 1929.21, 1.09, 1, ""), ("feed", .112, 1929.21, 1.13, 1, ""),
            ("uniform", .1, 2071, .98, .999, "-rod_cells 100"), ("uniform", .248, 578.1, 1.16, .999, "-rod_cells 100"),
            ("uniform", .186, 687.9, 1.34, .99, ""), ("uniform", .0734, 5438, .595, .9, "")):
        far = (f"-growth_type {growth} -growth_initial_length {length} -shape_type sag -tip_force {force} {cells} "
               f"-shape_amplitude {amplitude} -ts_max_time {.2 * length:.4g} ")
        there = Run(far + f"-friction_mu {min(share, .999)} -ts_dt 1e-13").tip
        for more in ("", "-ts_rtol 1e-4"):
            tip = Run(far + f"-friction_mu {share} {more}").tip
            expect(distance(tip, there) < 0.01 * length, f"{far} mu {share} {more}: tip {tip}, not {there}")
        print(f"P L^2 {force * length ** 2:.1f}, amplitude {amplitude}, mu {share}: tip {tip / length}")


@check
def sides_are_kept_with_any_way_to_solve():
    """The same where the modes that grow are not counted by the way the equations are solved: with a
    matrix, with self-contact, in the mixed model."""
    ways = ("-pc_type lu", "-contact_self true -contact_diameter 0.001", "-rod_model mixed")
    rod = "-growth_initial_length 0.2 -ts_max_time 0.002 -tip_force 375 -shape_amplitude 0.1 "
    crossed = Run("-growth_initial_length 0.0112 -tip_force 2.439e5 -shape_amplitude 1.48 -shape_turn 0.684 -rod_cells 24 "
                  "-ts_max_time 0.00056 -friction_mu 0 -ts_dt 1e-10")  # a layer that is seen is not jumped through
    expect("snap" not in crossed.said, crossed.said)
    for mu in (0, 1):
        right = Run(rod + f"-friction_mu {min(mu, .999)} -ts_dt 1e-12").tip
        for way in ways:
            tip = Run(rod + f"-friction_mu {mu} {way}").tip
            expect(distance(tip, right) < 0.01, f"{way}, mu {mu}: tip {tip}, not {right}")
        print(f"mu {mu}: tip {tip}")
    for more, asked in (("-ts_type beuler -ts_dt 1e-4", True), ("-ts_type beuler -ts_dt 1e-5", False)):
        r = Run(f"{rod} -friction_mu 0 {more}")
        same = distance(r.tip, Run(rod + "-friction_mu 0 -ts_dt 1e-12").tip) < 0.01
        print(f"{more}: tip {r.tip}")
        expect(("to which side the rod gave way is not known" in r.said) == asked and same != asked,
               f"{more}: tip {r.tip}, {r.said}")


@check(ranks=2)
def two_ranks_give_way_to_the_side_that_one_does():
    """Free, and held where the way to solve does not count the modes that grow."""
    rod = "-growth_initial_length 0.5 -tip_force 240 -shape_amplitude 1 -rod_cells 100 -ts_max_time 0.1 -friction_mu 0 "
    right, two = Run(rod + "-ts_dt 1e-12").tip, Run(rod, ranks=2).tip
    expect(distance(two, right) < 0.01, f"{rod} on two ranks: tip {two}, not {right}")
    held = "-tip_type pinned -growth_initial_length 1.2 -shape_amplitude 0.5 -ts_max_time 0.1 -friction_mu 0"
    one, two = (Run(held, ranks=n).norm_x2[-1] for n in (1, 2))
    expect(abs(two - one) < 1e-4 * one, f"held on two ranks: |x2| {two}, not {one}")


@check
def a_deflection_whose_square_is_no_number_is_followed():
    """|x2| below 1e-154, whose square is no number, and its e-folds in the estimate."""
    r = {a: Run(f"-ts_max_time 3 -shape_amplitude {a}") for a in ("1e-130", "1e-160")}
    a, b = r.values()
    expect(abs(b.norm_x2[-1] * 1e30 / a.norm_x2[-1] - 1) < 1e-6, f"{a.norm_x2[-1]}, {b.norm_x2[-1]}")
    expect(abs(b.estimate / a.estimate - 1) < 0.01, f"estimates {a.estimate}, {b.estimate}")
    print(f"|x2| {b.norm_x2[-1]:.2e}, estimate {b.estimate:.1e}")
    for model in ("frame", "auto"):  # less than all numbers that there are
        gone = Run(f"-friction_mu 0 -growth_initial_length 0.18 -shape_amplitude 1e-11 -ts_max_time 1 -rod_model {model}")
        expect(gone.estimate >= 1, f"{model}: |x2| {gone.norm_x2[-1]:.2e}, estimate {gone.estimate:.1e}")


SHORTER = {  # scenes of options/ that take longest, and how they are run to an end
    "injected-tube": "-rod_cells 150 -ts_max_time 20", "duct-bends": "-ts_max_time 1",
    "injected-spun": "-rod_cells 40 -ts_max_time 2", "cable-conduit": "-ts_max_time 3",
    "packing": "-ts_max_time 16", "twisted-rod": "-rod_cells 400", "root-gel": "-rod_cells 60 -ts_max_time 4",
    "vine-maze": "-rod_cells 60 -contact_stiffness 1e5 -ts_max_time 2.2",
    "vessel-branch": "-rod_cells 60 -ts_max_time 2",
    "tube-heap": "-rod_cells 40 -ts_max_time 3"
}


@check
def each_scene_of_options_runs():
    """Each scene in options/ of another task runs as a small problem of it, and each that grows and is run to its end in another
    way, as it stands for a few steps."""
    small = {"stability": "-stability_points 3 -stability_vertices 60", "critical": "-rod_cells 60"}
    for file in sorted((ROOT / "options").glob("*.opts")):
        task = task_of(file)
        if task == "grow" and file.stem not in SHORTER:
            continue
        r = Run(f"-options_file {file} {small.get(task, '-ts_max_time 0.01')}", group=task)
        if task == "grow":
            expect(r.t[-1] == 0.01, f"{file.name}: ends at {r.t[-1]}")
        print(f"{file.name}: task {task}")


@check(parts=3)
def energy_is_balanced_in_the_scenes_of_options(part):
    """Each scene of options/ in which one rod grows, to its end, but for those that take longest: every third. (Of several rods
    each has its own: several_test.py.)"""
    growing = [file for file in sorted((ROOT / "options").glob("*.opts"))
               if task_of(file) == "grow" and not re.search(r"(?m)^\[rods? ", file.read_text())]
    for file in growing[part::3]:
        r = Run(f"-options_file {file} {SHORTER.get(file.stem, '')}")
        defect = r.energy_defect[r.t > 0.01].max()
        print(f"{file.name}: {r.steps} steps, energy defect {defect:.1e}")
        expect(defect < 1e-3, f"{file.name}: energy defect {defect:.1e}")
        if not re.search("wall_file|contact_self|tip_path", file.read_text()):  # nothing there is to be doubted
            expect(r.estimate < 1e-2, f"{file.name}: told {r.estimate:.1e}")


SENSITIVE = {  # scene: what it is asked for, (number, unit) each
    "-growth_type uniform -friction_beta 1e-2":
        {"friction_mu": (0.7, ""), "friction_beta": (1e-2, ""), "friction_across": (1.4, ""), "rod_curvature": (0.2, ""),
         "tip_force": (0.3, ""), "clamp_angle": (0.1, "")},
    "-growth_type feed -shape_type straight -si_speed 5mm/s":
        {"si_friction_dry": (0.62, "N/m"), "si_bending_stiffness": (2.209, "Nmm^2"), "rod_curvature": (3.7, "/m"),
         "growth_initial_length": (6, "cm")},
    "-growth_type apical -rod_grading uniform -growth_zone 0.7 -tip_law resistance -tip_force 0.5 -friction_layers 0:0.5,2:2":
        {"growth_zone": (0.7, ""), "rod_curvature": (0.2, ""), "friction_beta": (0.01, "")},
}
# steps that do not depend on the numbers: then the derivatives are those of the numbers computed
FIXED = " -ts_max_time 1.5 -ts_adapt_type none -ts_dt 0.05 -ts_bdf_factor 0 -ts_rtol 1e-12 -rod_cells 40 -output_shapes 3 "


def words(numbers):
    return " ".join(f"-{name} {number!r}{unit}" for name, (number, unit) in numbers.items())


def differences(scene, numbers, name, part=1e-4):
    """{path: derivative} of what is stored by one number, central differences of order 4."""
    number, unit = numbers[name]
    step = part * number
    runs = {k: Run(f"{scene}{FIXED}{words(numbers | {name: (number + k * step, unit)})}") for k in (-2, -1, 1, 2)}

    def by(table, key):
        far, near = (getattr(runs[k], table)[key] - getattr(runs[-k], table)[key] for k in (2, 1))
        return (8 * near - far) / (12 * step)

    return {f"{table}/{key}": by(table, key) for table in ("series", "shapes") for key in getattr(runs[1], table)}


@check
def sensitivities_are_differences_between_runs():
    """-sensitivity is what differences between runs are, to 1e-6; the run itself is what it was."""
    for scene, numbers in SENSITIVE.items():
        options = f"{scene}{FIXED}{words(numbers)}"
        r, alone = Run(f"{options} -sensitivity {','.join(numbers)}"), Run(options)
        expect(not alone.derivatives and distance(r.tip, alone.tip) < 1e-12, f"{options}: is another run")
        for name, (number, _) in numbers.items():
            told = differences(scene, numbers, name)
            worst = {}
            for path in ("shapes/x", "shapes/theta", "shapes/force", "series/tip_x2", "series/energy", "series/width",
                         "series/base_force_1", "series/dissipation", "series/tip_force_1"):
                found, table = r.derivatives[name, path], path.split("/")
                size = max(np.abs(told[path][1:]).max(), 1e-4 * np.abs(getattr(r, table[0])[table[1]]).max() / number)
                worst[path] = np.abs(found - told[path])[1:].max() / max(size, 1e-9)
            print(f"{scene}: {name}, {max(worst.values()):.1e} in {max(worst, key=worst.get)}")
            expect(max(worst.values()) < 1e-6, f"{scene}: by {name}: {worst}")


@check
def sensitivities_hold_with_chosen_steps():
    """With steps and factor as they are chosen: differences between runs of a tolerance of 1e-9."""
    scene, numbers = "-growth_type uniform -shape_amplitude 0.1 -ts_rtol 1e-9", {"friction_mu": (0.8, ""), "friction_across": (1.5, "")}
    more = " -ts_max_time 3 -rod_cells 40 -output_shapes 3 -growth_initial_length 1 "
    r = Run(f"{scene}{more}{words(numbers)} -sensitivity friction_mu,friction_across")
    for name, (number, unit) in numbers.items():
        a, b = (Run(f"{scene}{more}{words(numbers | {name: (number + step, unit)})}").shapes["x"] for step in (-1e-3, 1e-3))
        told = (b - a) / 2e-3
        off = np.abs(r.derivatives[name, "shapes/x"] - told)[1:].max() / np.abs(told).max()
        print(f"by {name}: {off:.1e} of {np.abs(told).max():.2g}, in {r.steps} steps")
        expect(off < 1e-5, f"by {name}: {off:.1e}")


@check(ranks=2)
def sensitivities_on_ranks_are_those_of_one():
    """On two and three ranks as on one."""
    options = "-growth_type uniform -rod_curvature 0.2 -friction_mu 0.7 -ts_max_time 1 -rod_cells 40 -sensitivity friction_mu,rod_curvature"
    one = Run(options)
    for n in (2, 3):
        r = Run(options, ranks=n)
        for name in ("friction_mu", "rod_curvature"):
            a, b = (run.derivatives[name, "shapes/x"] for run in (one, r))
            off = np.abs(a - b).max() / np.abs(a).max()
            print(f"{n} ranks, by {name}: {off:.1e}")
            expect(off < 1e-6, f"{n} ranks, by {name}: {off:.1e}")


@check
def nothing_is_said_of_derivatives_behind_a_snap():
    snaps = Run("-growth_type uniform -rod_curvature 0.2 -growth_initial_length 1.1 -tip_force 0.3 -ts_rtol 1e-10 -ts_max_time 0.1 "
                "-rod_cells 40 -sensitivity tip_force")
    expect("behind a snap" in snaps.said and np.isnan(snaps.derivatives["tip_force", "series/tip_x2"][-1]),
           f"a snap, and derivatives behind it: {snaps.said}")


if __name__ == "__main__":
    sys.exit(scene.main())

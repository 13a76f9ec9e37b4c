#!/usr/bin/env python3
"""The atlas of failure: every method on every cell of a grid of rods, with verdict and cost; a
table, a map (methods down, cells across) and a Dolan-More profile.

    atlas.py [--quick] [--methods NAME,...] [--draw] [--jobs N] [--kept docs/notes/atlas.csv]

--draw: from what is stored, without new runs. Fails if the default loses a cell. Runs go side by
side, one to a core."""

import argparse
import csv
import sys

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

from measure import (CORES, CRASHED, DECAY, GAVE_UP, HUNG, QUANTITIES, REFUSED, RIGHT_, THICK,
                     WRONG, Case, Scene, workplace)
from tendril.style import STYLE

LIMIT, LIMIT_PEER = 15, 60  # seconds; the slowest cell of the default takes 3
LIMIT_SENSING = 60          # a busy machine
LIMIT_SPACE = 8             # cells of 100; that of the default 2
FINER = "-rod_cells 1000 -ts_rtol 1e-8"
FINER_SPACE = "-rod_cells 300 -ts_rtol 1e-7"
FINER_SENSING = "-rod_cells 500 -ts_rtol 1e-7"
FINER_EXACT = "-rod_cells 800 -ts_rtol 3e-8"
FINER_CONTACT = "-rod_cells 800 -ts_rtol 1e-7|-rod_cells 800 -ts_rtol 3e-7"
METHODS = {  # name: (solver, options)
    "default": ("tendril", ""),
    "auto": ("tendril", "-rod_model auto"),
    "frame 2": ("tendril", "-rod_order 2"),
    "mixed": ("tendril", "-rod_model mixed"),
    "linear": ("tendril", "-rod_model linear"),
    "PETSc's bdf 5": ("tendril", "-ts_type bdf -ts_bdf_order 5"),
    "PETSc's bdf 2": ("tendril", "-ts_type bdf -ts_bdf_order 2"),
    "backward Euler, start extrapolated": ("tendril", "-ts_type beuler -ts_dt 0.01"),
    "backward Euler, start at last step":  # as PETSc has it
        ("tendril", "-ts_type beuler -ts_theta_initial_guess_extrapolate 0 -ts_dt 0.01"),
    "primal Newton": ("tendril", "-friction_newton primal"),
    "primal, backtracking": ("tendril", "-friction_newton primal -snes_linesearch_type bt"),
    "backtracking": ("tendril", "-snes_linesearch_type bt"),
    "MUMPS": ("tendril", "-pc_factor_mat_solver_type mumps"),
    "GMRES, ILU": ("tendril", "-ksp_type gmres -pc_type ilu"),
    "paper's elements": ("paper_fem", "-dt 0.01 -nel 128 -graded"),
    "paper's elements, step 0.002": ("paper_fem", "-dt 0.002 -nel 128 -graded"),
    "paper's, taken literally": ("paper_fem", "-dt 0.01 -nel 64 -literal"),
    "PyElastica": ("pyelastica_rod", "-elements 20 -dt 3e-5"),
}
QUICK_METHODS = ("default", "mixed", "linear", "backward Euler, start at last step",
                 "primal Newton", "paper's, taken literally")


WORLD = "the world, $t=6$"  # laws around the rod
WORLD_LAWS = {
    "a = 2": "-friction_across 2",
    "a = 0.5, fed": "-friction_across 0.5 -growth_type feed",
    "a = 2, exact": "-friction_across 2 -friction_beta 0",
    "layers": "-friction_layers 0:1,3:2.5,5:0.4",
    "layers, exact": "-friction_layers 0:1,3:2.5,5:0.4 -friction_beta 0",
    "dead tip": "-tip_force 0.5",
    "follower": "-tip_force 0.5 -tip_law follower -friction_mu 0.5",
    "resistance": "-tip_force 0.5 -tip_law resistance",
    "pinned": "-tip_type pinned",
    "clamped": "-tip_type clamped",
    "apical": "-growth_type apical -growth_zone 0.6",
    "apical, exact": "-growth_type apical -growth_zone 0.6 -friction_beta 0",
    "stiffness, fed": "-rod_stiffness_file options/data/catheter.h5 -growth_type feed",
    "all of it": "-growth_type apical -growth_zone 0.6 -friction_across 2 -tip_force 0.3 "
                 "-tip_law resistance -friction_layers 0:1,3:2.5 -rod_curvature 0.05 "
                 "-rod_stiffness_file options/data/catheter.h5 -friction_beta 1e-6"}


CONTACT = "contact"
FED = "-growth_type feed -growth_initial_length 0.5 -shape_type straight "
MEETS = FED + "-rod_curvature 0.1 -wall_file scripts/lab/walls/"
TUBE = (FED + "-rod_curvature_random 0.1 -rod_curvature_length 4 -rod_curvature_seed 1 -contact_self "
        "-contact_diameter 0.1787 -contact_stiffness 2.5e4")
IN_CAVITY = (FED + "-rod_curvature_random 0.1 -rod_curvature_length 1 -contact_self -contact_diameter 0.1 "
             "-wall_file options/data/cavity.txt -contact_stiffness 2e4")
CONTACTS = {  # label: (options, times); the stiffness is given, so that finer runs have the same
    "plane": (f"{MEETS}across.txt -contact_stiffness 3e4", (2, 4)),
    "plane, straighter": (f"{MEETS}across.txt -contact_stiffness 3e4 -rod_curvature 0.01", (2, 4)),
    "corners": (f"{MEETS}stone.txt -contact_diameter 0.05 -contact_stiffness 3e5", (2, 4)),
    "corners, stiff": (f"{MEETS}stone.txt -contact_diameter 0.05 -contact_stiffness 1e7", (2, 4)),
    r"corners, $\beta=10^{-10}$": (f"{MEETS}stone.txt -contact_diameter 0.05 -contact_stiffness 3e5 "
                                   "-friction_beta 1e-10", (2, 4)),
    "corners, exact": (f"{MEETS}stone.txt -contact_diameter 0.05 -contact_stiffness 3e5 "
                       "-friction_beta 0", (2, 4)),
    "circle, exact": (f"{MEETS}pillar.txt -contact_diameter 0.05 -contact_stiffness 3e5 "
                      "-friction_beta 0", (1.5, 2)),
    "thin": (f"{MEETS}stone.txt -contact_diameter 1e-3 -contact_stiffness 2.5e7", (2, 4)),
    "corridor": ("-growth_type apical -growth_initial_length 1 -growth_zone 0.5 -shape_type straight "
                 "-rod_curvature 0.05 -wall_file options/data/corridor.txt -contact_diameter 0.1 "
                 "-contact_stiffness 3e4", (4, 8)),
    "cable": (FED + "-rod_curvature_random 0.1 -rod_curvature_length 1 -contact_diameter 0.1 "
              "-wall_file options/data/conduit.txt -contact_stiffness 1e5", (3, 6)),
    "many strands": (IN_CAVITY, (10, 18)),
    "tube": (TUBE, (17, 19)),
    "tube, $N=150$": (f"{TUBE} -rod_cells 150", (17, 19)),
    "tube, friction": (f"{TUBE} -contact_friction 0.3", (17, 19)),
}


SPACE = "in space, 100 cells"
IN_SPACE = QUANTITIES + ("norm_x3",)
SPACE_METHODS = ("default", "auto", "frame 2", "PETSc's bdf 5", "backward Euler, start extrapolated",  # of those that know these rods
                 "primal Newton", "backtracking", "MUMPS", "GMRES, ILU")
SPACES = {  # label: (options, times)
    "turned start": (f"{THICK} -shape_turn 1.2 -rod_curvature 0.05", (2, 6)),
    r"$\epsilon=10^{-12}$": ("-growth_initial_length 1 -shape_amplitude 1e-12 -rod_curvature_2 1e-8", (1, 3)),
    "heavy": ("-growth_initial_length 1 -shape_amplitude 0.1 -rod_weight 0.1,-0.3,0.2", (2, 4)),
    "strip, twisted": (f"{THICK} -rod_bend_ratio 5 -shape_turn 1.2 -rod_twist 0.5", (2, 6)),
    "weak twist": (f"{THICK} -rod_torsion 0.05 -shape_turn 0.5 -rod_curvature_2 0.3 -rod_twist 0.2", (2, 4)),
    "across, torque": (f"{THICK} -friction_across 2 -tip_torque 0.3 -shape_turn 0.5", (2, 4)),
    "layers": (f"{THICK} -friction_layers 0:1,3:2.5,5:0.4 -rod_weight 0,0,-0.1", (2, 6)),
    "dead force": (f"{THICK} -tip_force_vector 0.2,-0.3,0.4 -friction_mu 0.5", (2, 4)),
    "root": ("-growth_type apical -growth_initial_length 1 -growth_zone 1 -friction_beta 1e-4 -rod_curvature 0.9 "
             "-rod_curvature_2 0.3 -rod_twist 1.2 -shape_type straight", (4, 8)),
    "vine": ("-growth_type apical -growth_initial_length 1 -growth_zone 2 -friction_mu 0.2 -clamp_direction 1,0,0.3 "
             "-rod_weight 0,0,-0.6 -rod_curvature 1 -rod_curvature_2 0.1 -shape_type straight", (4, 8)),
    "wire, spun": (FED + "-clamp_spin 1 -friction_radius 0.2 -friction_mu 0.95 -rod_curvature 0.01", (3, 6)),
    "wire, exact": (FED + "-clamp_spin 1 -friction_radius 0.2 -friction_beta 0 -rod_curvature 0.1", (2, 4)),
    r"$\beta=10^{-9}$": (f"{THICK} -friction_beta 1e-9 -shape_turn 1 -rod_curvature_2 0.2", (2, 6)),
    r"$\beta=10^{-12}$": (f"{THICK} -friction_beta 1e-12 -shape_turn 1 -rod_curvature_2 0.2", (2, 6)),
    "exact": (f"{THICK} -friction_beta 0 -shape_turn 1 -rod_curvature_2 0.2", (2, 6)),
    "apical, exact": (f"{THICK} -growth_type apical -growth_zone 0.6 -friction_beta 0 -rod_curvature_2 0.3", (2, 6)),
    "hairpin": ("-growth_initial_length 2 -shape_amplitude 3.1 -shape_turn 1 -rod_curvature_2 0.05", (2, 4)),
    "snap at once": ("-growth_initial_length 0.2 -tip_force 1000 -shape_amplitude 0.1 -shape_turn 0.5 -rod_bend_ratio 1.5",
                     (0.1,)),
}

BOUND = "in space, held at the tip or against walls, 100 cells"
BOUND_METHODS = ("default",)
TOUCHES = "-contact_diameter 0.1 -contact_stiffness 1e5 -wall_file scripts/lab/walls/"
BOUNDS = {  # label: (options, times)
    "pinned": (f"{THICK} -tip_type pinned -shape_turn 1 -rod_curvature_2 0.2", (1, 3)),
    "clamped strip": (f"{THICK} -tip_type clamped -rod_bend_ratio 4 -shape_turn 1 -rod_twist 0.5", (1, 3)),
    "slides, heavy": (f"{THICK} -tip_type slides -rod_weight 0.1,-0.2,-0.3 -friction_mu 0.5 -shape_turn 1", (1, 3)),
    "pinned, exact": (f"{THICK} -tip_type pinned -friction_beta 0 -shape_turn 1 -rod_curvature_2 0.2", (1, 3)),
    "clamped, spun": (f"{THICK} -tip_type clamped -clamp_spin 1 -friction_mu 0.5 -shape_turn 1", (1, 3)),
    "slides, turned": (f"{THICK} -tip_type slides -tip_path scripts/lab/walls/turned.csv -friction_radius 0.1 -shape_turn 1 "
                       "-rod_curvature_2 0.1", (1, 3)),
    "27 turns": ("-growth_type none -growth_initial_length 1 -rod_torsion 0.5866171003717472 -friction_mu 0 -tip_type clamped "
                 "-tip_path options/data/twisted-rod.csv -ts_rtol 1e-4", (1, 2)),
    "ground": (f"{FED} -rod_weight 0,0,-0.5 -rod_curvature 0.2 {TOUCHES}ground.txt", (2, 4)),
    "leaning post": (f"{FED} -rod_curvature 0.1 -rod_curvature_2 0.05 {TOUCHES}post.txt", (2, 3)),
    "ball": (f"{FED} -rod_curvature 0.1 -rod_curvature_2 0.05 {TOUCHES}ball.txt", (2, 3)),
    "ball, exact": (f"{FED} -friction_beta 0 -rod_curvature 0.1 -rod_curvature_2 0.05 {TOUCHES}ball.txt", (2, 3)),
    "two bends": (f"{FED} -rod_curvature 0.1 -rod_curvature_2 0.05 {TOUCHES}bends.txt", (2, 4)),
    "two bends, spun": (f"{FED} -rod_curvature 0.3 -clamp_spin 2 {TOUCHES}bends.txt", (2, 4)),
    "ring, spun": (f"{FED} -rod_curvature 0.5 -clamp_spin 2 {TOUCHES}ring.txt", (2, 4)),
    "lying, exact": (f"{FED} -rod_curvature 0.5 -clamp_spin 2 -friction_beta 0 -rod_weight 0,0,-0.5 {TOUCHES}lying.txt", (2, 4)),
    "apical, ball": ("-growth_type apical -growth_zone 0.4 -growth_initial_length 0.5 -shape_type straight -rod_curvature 0.1 "
                     f"-rod_curvature_2 0.05 {TOUCHES}ball.txt", (2, 3)),
}


SENSING = "growth that senses"
SENSING_METHODS = ("default",)
ROOT_GROWS = "-growth_type apical -growth_zone 0.6 -growth_initial_length 1 -shape_type straight -friction_mu 0.5 -tropism_direction 0,-1 "
SENSES = {  # label: (options, times)
    "strong, at the tip": (f"{ROOT_GROWS}-tropism_gravity 30 -tropism_proprioception 3 -tropism_sensed tip", (0.5, 1)),
    "strong, in each place": (f"{ROOT_GROWS}-tropism_gravity 30 -tropism_proprioception 3", (0.5, 1)),
    "short memory": (f"{ROOT_GROWS}-tropism_gravity 4 -tropism_proprioception 2 -tropism_sensed tip -tropism_memory 0.003", (0.5, 1)),
    "swings by itself": (f"{ROOT_GROWS}-tropism_gravity 33 -tropism_proprioception 0.5 -tropism_sensed tip -tropism_memory 1", (1, 2)),
    "ironing 500": ("-growth_type uniform -growth_initial_length 1 -shape_type straight -friction_mu 0.5 -rod_weight 0,-0.05 "
                    "-growth_ironing 500", (0.1, 0.2)),
    "ironing 500, dry": (f"{ROOT_GROWS}-friction_mu 1 -tropism_gravity 4 -tropism_proprioception 2 -growth_ironing 500", (0.5, 1)),
    "shoot, heavy": ("-growth_type uniform -growth_initial_length 1 -shape_type straight -friction_mu 0 -rod_weight 0,-0.3 "
                     "-tropism_gravity 2 -tropism_direction 0,1 -tropism_proprioception 1", (1, 2)),
    "yields, near its stall": ("-growth_type uniform -growth_initial_length 0.9 -growth_yield 1 -friction_beta 1e-4 -shape_type straight "
                               "-rod_curvature 1e-3 -tropism_gravity 2 -tropism_direction 1,-0.1 -tropism_proprioception 1", (1, 3)),
    "fed": (f"{FED} -tropism_rate 1 -tropism_gravity 2 -tropism_direction 0,1 -tropism_proprioception 1", (1, 2)),
    "meets itself": ("-growth_type apical -growth_zone 0.4 -growth_initial_length 0.5 -shape_type straight -friction_mu 0.5 "
                     "-tropism_nutation 9 -tropism_proprioception 0.5 -growth_ironing 1 -contact_self -contact_diameter 0.1 "
                     "-contact_friction 0.3 -contact_stiffness 1e5", (0.3, 0.6)),
    "goes round": ("-options_file options/root-stone.opts -contact_stiffness 1e5", (1, 2)),
}


def scene(group, label, options, times, quantities=QUANTITIES):
    return group, Scene(label, options, times, finer=FINER, quantities=quantities)


def cells(quick):
    """[(group, scene)]"""
    result = []
    for mu in ("1", "0.5", "0"):
        for beta in ("1e-1", "1e-3", "1e-6", "1e-9", "1e-12", "0"):
            if mu == "0.5" and beta not in ("1e-3", "1e-9", "0"):
                continue
            if mu == "0" and beta != "1e-3":
                continue  # beta is of the dry share alone
            result.append(scene(rf"decay and fold, $t=20$: $\mu$, $\beta$", f"{mu}, {beta}",
                                f"{DECAY} -friction_mu {mu} -friction_beta {beta}", (8, 14, 20)))
    for mu in ("1", "0"):
        for growth in ("uniform", "5", "0.5", "0.05", "0.005", "feed"):
            law = (f"-growth_type {growth}" if growth[0] in "uf" else
                   f"-growth_type gaussian -growth_width {growth}")
            result.append(scene(r"growth, $t=10$: $\mu$, law or width $a$", f"{mu}, {growth}",
                                f"{THICK} {law} -friction_mu {mu}", (2, 6, 10)))
    for amplitude in ("1e-15", "1e-8", "1e-2", "0.5", "1.5", "3.1"):
        result.append(scene(r"amplitude $\epsilon$, $t=16$",
                            "hairpin" if amplitude == "3.1" else amplitude,
                            f"-growth_initial_length 2 -shape_amplitude {amplitude}", (2, 8, 16)))
    for length in ("0.001", "0.1", "0.25", "10", "30"):
        # below 0.2, x2 and the energy die out altogether: what is left to compare is the tip
        left = ("tip",) if float(length) < 0.2 else QUANTITIES
        result.append(scene("$L_0$, $t=5$", length,
                            f"-growth_initial_length {length} -shape_amplitude 0.1", (1, 5), left))
    corners = [("fed", f"{THICK} -growth_type feed -friction_beta", ("1e-9", "0"), (2, 6, 10)),
               ("0.05", f"{THICK} -growth_type gaussian -growth_width 0.05 -friction_beta",
                ("1e-12", "0"), (2, 6, 10)),
               ("0.005", f"{THICK} -growth_type gaussian -growth_width 0.005 -friction_beta",
                ("1e-12",), (2, 6, 10)),
               ("0.05, 1e-16", "-growth_type gaussian -growth_width 0.05 -shape_amplitude 1e-16 "
                "-growth_initial_length 2 -friction_beta", ("1e-9",), (2, 5)),
               ("hairpin", "-growth_initial_length 2 -shape_amplitude 3.1 -friction_beta",
                ("1e-12", "0"), (2, 5)),
               ("fed hairpin", "-growth_type feed -growth_initial_length 2 -shape_amplitude 3.1 "
                "-friction_beta", ("1e-9",), (2, 5))]
    for name, options, betas, times in corners:
        for beta in betas:
            result.append(scene(r"corners: width or shape, $\beta$", f"{name}, {beta}",
                                f"{options} {beta}", times))
    for n in ("100", "1000", "10000"):
        result.append(scene("decay, $N$", n, f"{DECAY} -rod_cells {n}", (8, 12)))
    for name, options in WORLD_LAWS.items():
        result.append(scene(WORLD, name, f"{THICK} {options}", (2, 6)))
    for name, (options, times) in CONTACTS.items():
        finer = FINER_CONTACT.split("|")["exact" in name]
        result.append((CONTACT, Scene(name, options, times, finer=finer)))
    for name, (options, times) in SPACES.items():
        result.append((SPACE, Scene(name, f"{options} -rod_cells 100", times, finer=FINER_SPACE,
                                    quantities=IN_SPACE)))
    for name, (options, times) in BOUNDS.items():
        result.append((BOUND, Scene(name, f"{options} -rod_cells 100", times, finer=FINER_SPACE, quantities=IN_SPACE)))
    for name, (options, times) in SENSES.items():
        result.append((SENSING, Scene(name, options, times, finer=FINER_SENSING)))
    result += exact_cells()
    return result[::4] if quick else result


EXACT = "exact friction"  # with each law that has no such column above
EXACT_LAWS = {
    **{name: WORLD_LAWS[name] for name in ("a = 0.5, fed", "dead tip", "follower", "resistance", "pinned", "clamped",
                                           "stiffness, fed")},
    "all of it": WORLD_LAWS["all of it"].replace(" -friction_beta 1e-6", ""),
    "apical, $\\mu = 0.5$": "-growth_type apical -growth_zone 0.6 -friction_mu 0.5",
    "width 5": "-growth_type gaussian -growth_width 5", "width 0.5": "-growth_type gaussian -growth_width 0.5",
    "width 0.005": "-growth_type gaussian -growth_width 0.005",
    "bent by nature": "-rod_curvature 0.1", "bent, fed": "-rod_curvature 0.1 -growth_type feed"}
EXACT_METHODS = ("default",)


def exact_cells():
    """Exact friction with each law around the rod, and each thing that it touches."""
    result = [(EXACT, Scene(name, f"{THICK} {options} -friction_beta 0", (2, 6), finer=FINER_EXACT))
              for name, options in EXACT_LAWS.items()]
    for name, (options, times) in CONTACTS.items():
        if name != "corners" and "friction_beta" not in options:
            result.append((EXACT, Scene(name, f"{options} -friction_beta 0", times, finer=FINER_CONTACT.split("|")[1])))
    return result


NUMBERS = ([("cells $N$", n, f"-rod_cells {n}") for n in
            ("10", "20", "50", "200", "1000", "4000", "10000")] +
           [("tolerance", r, f"-ts_rtol {r}") for r in
            ("1e-2", "1e-3", "1e-4", "1e-5", "1e-7", "1e-8", "1e-9")])
STEPS = [("step", h, f"-ts_dt {h}") for h in ("0.5", "0.1", "0.05", "0.01", "0.002")]


SETTINGS = tuple(dict.fromkeys(n[0] for n in NUMBERS + STEPS))  # groups without a claim
SET = ("default", "frame 2", "mixed", "primal Newton", "PETSc's bdf 5",
       "backward Euler, start extrapolated")  # the methods whose settings are varied


def never(method, group):
    """The peers know nothing of a world around the rod, nor, in these scenes, of contact. Explicit, with inertia, PyElastica cannot
    follow the decay; a small step of the paper's elements takes minutes there. Exact friction with each law
    and rods in space that are held or touch are looked at for the default alone."""
    if group == EXACT:
        return method not in EXACT_METHODS
    if group == SPACE:
        return method not in SPACE_METHODS
    if group == BOUND:
        return method not in BOUND_METHODS
    if group == SENSING:
        return method not in SENSING_METHODS
    if group in (WORLD, CONTACT):
        return METHODS[method][0] != "tendril"
    return "decay" in group and method in ("PyElastica", "paper's elements, step 0.002")


def cases(arguments):
    """[(method, group, label, case)]"""
    names = arguments.methods.split(",") if arguments.methods else (
        QUICK_METHODS if arguments.quick else METHODS)
    result = []
    for group, where in cells(arguments.quick):
        for method in names:
            solver, options = METHODS[method]
            limit = LIMIT_SPACE if group in (SPACE, BOUND) else LIMIT_SENSING if group == SENSING else LIMIT if solver == "tendril" else LIMIT_PEER
            if not never(method, group):
                result.append((method, group, where.name, Case(solver, where, options, limit)))
    if arguments.quick:
        return result
    thick = Scene("thick", THICK, (2, 6, 10), finer=FINER)
    for method in (m for m in SET if m in names):
        euler = "Euler" in method
        for group, label, more in (n for n in NUMBERS + STEPS
                                   if n[0] != ("tolerance" if euler else "step")):
            options = f"{METHODS[method][1].replace('-ts_dt 0.01', '')} {more}".strip()
            if euler and group != "step":
                options += " -ts_dt 0.01"
            result.append((method, group, label, Case("tendril", thick, options, limit=30)))
    return result


def take_up(store, wanted, path):
    """Puts the rows of an earlier table into the store, so that only what is new is run."""
    with open(path, newline="") as file:
        rows = {(r["method"], r["group"], r["cell"]): r for r in csv.DictReader(file)}
    for method, group, label, case in wanted:
        row = rows.get((method, group, label))
        if not row or case.key in store.runs or row["scene_options"] != case.scene.options:
            continue
        run = {k: row[k] for k in ("verdict", "reason", "options", "scene_options", "message")}
        run |= {k: int(row[k]) if row[k].isdigit() else float(row[k]) for k in COLUMNS[5:14] if row[k]}
        store.keep({"key": case.key, **run})


def measure_all(store, arguments):
    """[(method, group, label, run)]"""
    wanted = cases(arguments)
    if arguments.kept:
        take_up(store, wanted, arguments.kept)
    again = [w[3].key for w in wanted if w[0] in arguments.again.split(",")]
    if not arguments.draw:
        store.get_all([w[2:] for w in wanted], arguments.jobs, again)
    found = [(*w[:3], dict(store.runs[w[3].key])) for w in wanted if w[3].key in store.runs]
    explain(found)
    return found


def explain(found):
    """Why a finished run is wrong. The default is right on the same mesh: with another stepper the
    error is in time; with another model, all else the same, in space or of the model. The paper's
    elements err in time if a fifth of the step lessens the error to a half."""
    error = {f[:3]: f[3].get("error") for f in found}
    for method, group, label, run in found:
        if run["verdict"] != WRONG:
            continue
        finer = error.get(("paper's elements, step 0.002", group, label))
        if group in SETTINGS:
            why = "time" if group != SETTINGS[0] or "Euler" in method else "space"
        elif method in ("frame 2", "mixed"):
            why = "space"
        elif method == "paper's elements" and finer and finer > run["error"] / 2:
            why = "space"
        elif method == "paper's elements, step 0.002":
            coarse = error.get(("paper's elements", group, label)) or np.inf
            why = "space" if run["error"] > coarse / 2 else "time"
        else:
            why = {"linear": "model", "PyElastica": "elements"}.get(method, "time")
        run["reason"] = why


# Okabe and Ito's colours; the letter in a cell tells why
COLOUR = {RIGHT_: "#a6d5f0", WRONG: "#E69F00", GAVE_UP: "#F5E663", REFUSED: "#e4e4e4",
          CRASHED: "#D55E00", HUNG: "#7a4fa3"}
LETTER = {"time": "t", "space": "s", "model": "m", "elements": "e", "angle": "a", "newton": "N",
          "rejections": "N", "step": "N", "zero pivot": "N", "time limit": "h", "refused": "n"}
NAMES = {RIGHT_: "right, with its seconds",
         WRONG: "wrong (errs in t time, s space, m model, e its elements)",
         GAVE_UP: "gave up (N Newton or the step, a large angles)", REFUSED: "not supported (n)",
         CRASHED: "crashed (c)", HUNG: f"hung or over {LIMIT} s, peers {LIMIT_PEER} s (h)"}


def cost(seconds):
    return f"{seconds:.2f}"[1:] if seconds < 0.995 else f"{seconds:.1f}" if seconds < 9.95 else f"{seconds:.0f}"


def draw_block(ax, found, methods):
    """Methods down, cells across, in groups; returns how many columns wide it is."""
    groups = {}
    for _, group, label, _ in found:
        groups.setdefault(group, {})[label] = None
    columns, at, gap = {}, 0.0, 0.7
    for group, labels in groups.items():
        ax.text(at - 0.5, -0.75, group, fontsize=7, ha="left", va="bottom")
        for label in labels:
            columns[group, label] = at
            at += 1
        at = max(at + gap, columns[group, next(iter(labels))] + 0.33 * len(group.replace("$", "")))
    for method, group, label, run in found:
        x, y, verdict = columns[group, label], methods.index(method), run["verdict"]
        ax.add_patch(plt.Rectangle((x - 0.5, y - 0.5), 1, 1, fc=COLOUR[verdict], ec="white",
                                   lw=0.6))
        right = verdict == RIGHT_
        ax.text(x, y, cost(run["seconds"]) if right else LETTER.get(run["reason"], "c"),
                ha="center", va="center", fontsize=5 if right else 7,
                color="white" if verdict in (HUNG, CRASHED) else "black")
    ax.set_yticks(range(len(methods)), methods)
    ax.set_xticks(list(columns.values()), [label for _, label in columns], rotation=90, fontsize=7)
    ax.set_ylim(len(methods) - 0.5, -0.6)
    ax.tick_params(length=0)
    for side in ax.spines.values():
        side.set_visible(False)
    return at - gap


def draw_map(found, base):
    """Above, the cells, then those in space; below, the settings of some methods on one rod, and exact friction."""
    rows = {SPACE: 1, BOUND: 1, **dict.fromkeys((*SETTINGS, SENSING, EXACT), 2)}
    blocks = [sorted((f for f in found if rows.get(f[1], 0) == row), key=lambda f: f[1] == EXACT) for row in range(3)]
    blocks = [b for b in blocks if b]
    methods = [[m for m in METHODS if any(f[0] == m for f in b)] for b in blocks]

    def rooms(b):  # above and below its rows, for its words
        return 7 if b[0][1] == SPACE else 5
    with plt.rc_context(STYLE):
        heights = [len(m) + rooms(b) for m, b in zip(methods, blocks)]
        fig, axes = plt.subplots(len(blocks), squeeze=False, figsize=(10.6, 0.6 + 0.19 * sum(heights)),
                                 height_ratios=heights)
        widths = [draw_block(ax, b, m) for ax, b, m in zip(axes[:, 0], blocks, methods)]
        for ax in axes[:, 0]:
            ax.set_xlim(-0.7, max(widths) - 0.3)
        handles = [plt.Rectangle((0, 0), 1, 1, fc=COLOUR[v], ec="none", label=NAMES[v])
                   for v in COLOUR if any(f[3]["verdict"] == v for f in found)]
        fig.legend(handles=handles, ncol=3, loc="lower center", fontsize=7)
        fig.tight_layout(rect=(0, 0.06, 1, 1))
        for suffix in (".png", ".pdf"):
            fig.savefig(f"{base}{suffix}", dpi=200)
        plt.close(fig)


def draw_profile(found, base):
    """Share of cells solved right within tau times the time of the fastest right method there."""
    grid = [f for f in found if f[1] not in (*SETTINGS, SPACE, BOUND, EXACT, SENSING)]
    fastest = {}
    for _, group, label, run in grid:
        if run["verdict"] == RIGHT_:
            key = group, label
            fastest[key] = min(fastest.get(key, np.inf), max(run["seconds"], 1e-3))
    total = len({(g, l) for _, g, l, _ in grid})
    tau = np.logspace(0, 3, 400)
    named = {"default": "#0072B2", "auto": "#CC79A7", "mixed": "#009E73", "PETSc's bdf 5": "#E69F00",
             "primal Newton": "#D55E00", "backward Euler, start extrapolated": "#000000",
             "paper's elements, step 0.002": "#56B4E9"}  # the others in grey
    with plt.rc_context(STYLE):
        fig, ax = plt.subplots(figsize=(6.4, 3.4))
        for method in (m for m in METHODS if any(f[0] == m for f in grid)):
            ratios = np.array([max(run["seconds"], 1e-3) / fastest[g, l]
                               for m, g, l, run in grid if m == method
                               and run["verdict"] == RIGHT_])
            share = [(ratios <= t * (1 + 1e-9)).sum() / total for t in tau]
            own = [f[3] for f in grid if f[0] == method]
            ax.step(tau, share, where="post", color=named.get(method, "#bbbbbb"),
                    lw=2 if method == "default" else 1.2, zorder=3 if method in named else 1,
                    label=f"{method}: {len(ratios)} of {len(own)} run")
        ax.set_xscale("log")
        ax.set_xlim(1, 1e3)
        ax.set_ylim(0, 1.02)
        ax.set_xlabel(r"$\tau$, time over that of the fastest right method")
        ax.set_ylabel(r"share of the cells solved right within $\tau$")
        ax.legend(loc="center left", bbox_to_anchor=(1.01, 0.5), fontsize=7, handlelength=2.4)
        fig.tight_layout()
        for suffix in (".png", ".pdf"):
            fig.savefig(f"{base}-profile{suffix}", dpi=200)
        plt.close(fig)


COLUMNS = ("method", "group", "cell", "verdict", "reason", "error", "tip", "norm_x2", "energy",
           "seconds", "steps", "rejected", "newton", "reached", "options", "scene_options",
           "message")

# what README shows: some methods, and the groups of rods that part them
SHORT_METHODS = ("default", "auto", "mixed", "PETSc's bdf 5", "backward Euler, start extrapolated",
                 "primal Newton", "MUMPS", "paper's elements", "PyElastica")
SHORT_GROUPS = ("decay", "growth", "amplitude", "corners")


def draw_short(table, base):
    """A part of the atlas, from its table, of a size that can be read on a page."""
    with open(table, newline="") as file:
        rows = list(csv.DictReader(file))
    found = [(r["method"], r["group"], r["cell"], r | {"seconds": float(r["seconds"] or 0)}) for r in rows
             if r["method"] in SHORT_METHODS and r["group"].startswith(SHORT_GROUPS)
             and not r["group"].startswith("decay, $N")]
    methods = [m for m in SHORT_METHODS if any(f[0] == m for f in found)]
    with plt.rc_context(STYLE):
        fig, ax = plt.subplots(figsize=(7.0, 3.3))
        ax.set_xlim(-0.7, draw_block(ax, found, methods) - 0.3)
        handles = [plt.Rectangle((0, 0), 1, 1, fc=COLOUR[v], ec="none", label=NAMES[v].split(" (")[0])
                   for v in COLOUR if any(f[3]["verdict"] == v for f in found)]
        fig.legend(handles=handles, ncol=5, loc="lower center", fontsize=8)
        fig.tight_layout(rect=(0, 0.06, 1, 1))
        fig.savefig(f"{base}-short.png", dpi=200)
        plt.close(fig)


def table(found, path):
    with open(path, "w", newline="") as file:
        writer = csv.DictWriter(file, COLUMNS, extrasaction="ignore", lineterminator="\n")
        writer.writeheader()
        for method, group, label, run in found:
            row = dict(run, method=method, group=group, cell=label)
            writer.writerow({k: f"{v:.4g}" if isinstance(v, float) else v for k, v in row.items()})


def summary(found):
    """Counts per method; the cells that the default lost."""
    grid = [f for f in found if f[1] not in SETTINGS]
    for method in METHODS:
        own = [f[3] for f in grid if f[0] == method]
        if own:
            counts = {v: sum(r["verdict"] == v for r in own) for v in COLOUR}
            print(f"{method:36}", ", ".join(f"{n} {v}" for v, n in counts.items() if n),
                  f"; {sum(r['seconds'] for r in own):.0f} s")
    lost = [f for f in grid if f[0] == "default" and f[3]["verdict"] != RIGHT_]
    for _, _, _, run in lost:
        print(f"LOST by the default: {run['verdict']} {run['reason']} error "
              f"{run.get('error', float('nan')):.1e}: tendril {run['scene_options']} "
              f"{run['options']}  {run['message']}")
    return len(lost)


def main():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--quick", action="store_true", help="fewer cells, under 3 minutes")
    parser.add_argument("--draw", action="store_true", help="only draw what is stored")
    parser.add_argument("--jobs", type=int, default=CORES, metavar="N",
                        help="runs side by side")
    parser.add_argument("--kept", metavar="CSV", help="take up an earlier table; run what is new")
    parser.add_argument("--methods", default="", metavar="NAME,...")
    parser.add_argument("--again", default="", metavar="METHOD,...", help="repeat these")
    parser.add_argument("--short", metavar="CSV", help="draw README's part from this table, and no more")
    arguments = parser.parse_args()
    if arguments.short:
        return draw_short(arguments.short, arguments.short.removesuffix(".csv"))
    place, store = workplace("atlas", arguments.quick)
    found = measure_all(store, arguments)
    table(found, place / "atlas.csv")
    draw_map(found, place / "atlas")
    draw_short(place / "atlas.csv", place / "atlas")
    draw_profile(found, place / "atlas")
    lost = summary(found)
    print(f"atlas: {len(found)} runs; {place}/atlas.csv, .png, -profile.png; "
          f"cells lost by the default: {lost}")
    return lost > 0


if __name__ == "__main__":
    sys.exit(main())

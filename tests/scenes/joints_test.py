#!/usr/bin/env python3
"""Rods that hold each other: frames and trees whose answers are known otherwise, what a joint does not change, and what is refused.

    joints_test.py build/tendril CHECK...      (no CHECK: all of them)"""

import re
import shlex
import subprocess
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "support"))
import scene  # takes .venv's python if this one lacks numpy and h5py
from scene import check, expect

from joined import STATIC, Several, refusal

import h5py
import numpy as np


Y = {"stem": {"clamp_direction": "0,1"},
     "left": {"clamp_on": "stem", "clamp_angle": "45deg", "tip_force_vector": "0,-0.5,0"},
     "right": {"clamp_on": "stem", "clamp_angle": "45deg", "clamp_azimuth": "180deg", "tip_force_vector": "0,-0.25,0"}}


@check
def a_y_is_where_shooting_has_it():
    """And energy is balanced, of each rod and of all."""
    for cells, bound in ((16, 1e-6), (32, 1e-7)):
        run = Several(Y, rod_cells=cells, ts_max_time=200)
        for rod, place in (("stem", (-0.3097154300, 0.9346753812)), ("left", (-1.3067740390, 0.9532699313)),
                           ("right", (-0.1089842811, 1.9142918031))):
            off = np.abs(run.tip(rod) - (*place, 0)).max()
            defect = run.series[rod]["energy_defect"][-1]
            print(f"{cells} cells, {rod}: off by {off:.1e}, energy {defect:.1e}")
            expect(off < bound, f"{rod}: {off}")
            if cells == 16:  # (with 32 what is told is what steps leave at least)
                run.expect_told(rod, np.linalg.norm(run.tip(rod) - (*place, 0)))
            expect(defect < 2e-5, f"{rod}: energy {defect}")


@check
def a_rod_that_is_cut_and_welded_is_the_rod():
    """At fixed steps, on the same mesh, bent and twisted out of its plane."""
    fixed = "-ts_adapt_type none -ts_dt 0.02 -ts_rtol 1e-11"
    load = {"rod_weight": "0,0.3,-1", "rod_curvature": 0.5, "rod_torsion": 0.6}
    shared = {"ts_max_time": 0.4, "output_shapes": 4, "friction_layers": "0:1"}
    whole = Several({"all": {"growth_initial_length": 2, "rod_cells": 24, "tip_force_vector": "0.2,0,0.3", **load}}, fixed, **shared)
    parts = Several({"base": {"rod_cells": 12, **load},
                     "end": {"clamp_on": "base", "rod_cells": 12, "tip_force_vector": "0.2,0,0.3", **load}}, fixed, "parts", **shared)
    x = np.concatenate([parts.x["base"][:, :-1], parts.x["end"][:, 1:]], axis=1)
    off = np.abs(x - whole.x["all"])[1:].max()  # (at t = 0 the shape itself is, to 1e-9)
    print(f"off by {off:.1e}")
    expect(off < 1e-12, off)
    for error in ("error_tip", "error_energy"):
        told = [run.series[rod][error][-1] for run, rod in ((whole, "all"), (parts, "end"))]
        print(f"{error}: {told[0]:.1e} of the whole, {told[1]:.1e} of its end")
        expect(0.2 < told[1] / told[0] < 5, f"{error}: {told}")


@check
def a_rod_of_another_stiffness_friction_and_speed_is_the_run_scaled():
    """b, n, v over those of the scales: lengths go as (b/n)^(1/3), times as that over v, energies as b over it; beside a rod that is not."""
    b, n, v = 3., 0.4, 0.7
    length = (b / n) ** (1 / 3)
    fixed = "-ts_adapt_type none -ts_rtol 1e-10 "
    shared = {"friction_mu": 1, "shape_type": "sag", "rod_cells": 20, "output_shapes": 2}
    for growth in ("uniform", "feed", "apical", "gaussian"):
        zone = {"growth_zone": 0.25} if growth == "apical" else {}
        zoned = {key: value * length for key, value in zone.items()}
        one = Several({"one": {"shape_amplitude": 0.02}}, fixed + f"-ts_dt {0.05}", "one", **shared | zone,
                      growth_type=growth, growth_initial_length=0.8, ts_max_time=0.5, friction_beta=1e-4, friction_layers="0:1")
        two = Several({"one": {"rod_stiffness": b, "friction_strength": n, "growth_speed": v, "shape_amplitude": 0.02},
                       "other": {"clamp_place": "0,9,0", "growth_initial_length": 0.5}},
                      fixed + f"-ts_dt {0.05 * length / v}", "two", **shared | zoned, growth_type=growth, growth_initial_length=0.8 * length,
                      ts_max_time=0.5 * length / v, friction_beta=1e-4 * v ** 2, friction_layers="0:1")
        off = np.abs(two.x["one"] / length - one.x["one"]).max()
        energy = abs(two.series["one"]["energy"][-1] * length / b / one.series["one"]["energy"][-1] - 1)
        print(f"{growth}: off by {off:.1e}, energy {energy:.1e}")
        expect(off < 1e-8 and energy < 1e-6, f"{growth}: {off}, {energy}")


@check
def branches_of_their_own_stiffness_are_where_shooting_has_them():
    """A Y in space, a lateral half-way along a rod that hangs, and one on a rod that is stiff."""
    space = Several({"stem": {"clamp_direction": "0,0,1"},
                     "left": {"clamp_on": "stem", "clamp_angle": "45deg", "clamp_azimuth": "-90deg", "tip_force_vector": "0,0.5,-0.5"},
                     "right": {"clamp_on": "stem", "clamp_angle": "45deg", "clamp_azimuth": "90deg", "tip_force_vector": "0,0,-0.5",
                               "rod_stiffness": 0.5}}, ts_max_time=200)
    tap = Several({"tap": {"growth_initial_length": 2, "rod_cells": 32, "rod_weight": "0,0,-1"},
                   "side": {"clamp_on": "tap", "clamp_at": 1, "clamp_angle": "60deg", "rod_stiffness": 0.25, "rod_weight": "0,0,-1"}},
                  ts_max_time=400)
    stiff = Several({"parent": {"rod_stiffness": 1e7},
                     "side": {"clamp_on": "parent", "clamp_at": 0.5, "clamp_angle": "90deg", "rod_weight": "0,0,-10"}}, ts_max_time=200, rod_cells=32)
    side = (0.6563537612, -0.7001997155)
    for run, rod, place in ((space, "stem", (-0.1979053254, 0.5906411715, 0.6896091608)), (space, "left", (0.1713377345, 1.5023743946, 0.8479399576)),
                            (space, "right", (-1.0633534719, 0.9919607202, 0.4236064095)), (tap, "side", (0.8545361494, 0.5371027312, -1.4030751075)),
                            (tap, "tap", (1.1844905217, -0.1490193522, -1.4919255478)), (stiff, "side", (0.5, *side))):
        off = np.abs(run.tip(rod) - place).max()
        print(f"{rod}: off by {off:.1e}")
        expect(off < 3e-6, f"{rod}: {off}")
        if np.abs(place).sum() > 1:  # (the parent that is stiff is where it is, to 1e-8)
            run.expect_told(rod, np.linalg.norm(run.tip(rod) - place))


RING = {"a": {"rod_curvature": 1, "tip_force_vector": "0,1,0"}, "b": {"clamp_direction": "-1,0", "rod_curvature": -1, "tip_on": "a"}}
PORTAL = {"a": {"clamp_direction": "0,0,1", "tip_force_vector": "0,1e-4,-2"},
          "b": {"clamp_place": "1,0,0", "clamp_direction": "0,0,1", "tip_force_vector": "0,1e-4,-2"},
          "beam": {"clamp_on": "a", "clamp_direction": "1,0,0", "tip_on": "b"}}


@check
def rings_and_frames_are_where_they_are_known_to_be():
    """A ring of two halves that is pulled and pressed, of order 4; a portal pushed out of its plane under a load on each corner, whose columns
    bend alike, w = H (tan k - k)/k^3, k^2 = P; and one whose beam is in a ball at one corner, mirrored."""
    for force, height in ((1, 2.13288216292), (-1, 1.83305621894)):
        off = []
        for cells in (16, 32):
            rods = RING | {"a": {"rod_curvature": 1, "tip_force_vector": f"0,{force},0"}}
            run = Several(rods, growth_initial_length=np.pi, ts_max_time=300, rod_cells=cells)
            off.append(abs(run.tip("a")[1] - height))
            run.expect_told("a", off[-1])
            expect(np.abs(run.tip("a") - run.tip("b")).max() < 1e-7, "the halves part")
        print(f"ring, {force}: off by {off[0]:.1e}, {off[1]:.1e}")
        expect(off[1] < 1e-6 and off[1] < off[0] / 10, f"{force}: {off}")
    run = Several(PORTAL, ts_max_time=2000, rod_cells=12)
    k = np.sqrt(2)
    for rod in ("a", "b"):
        off = run.tip(rod)[1] / (1e-4 * (np.tan(k) - k) / k ** 3) - 1
        print(f"portal, {rod}: off by {off:.1e} of it")
        expect(abs(off) < 1e-5, f"{rod}: {off}")
    corner = {"a": {"clamp_direction": "0,1", "tip_force_vector": "0.5,-1,0"}, "b": {"clamp_place": "1,0,0", "clamp_direction": "0,1"}}
    tips = [Several(corner | {"beam": {"clamp_on": "a", "clamp_direction": "1,0,0", "tip_on": "b"} | own}, ts_max_time=100).tip("a")
            for own in ({"clamp_type": "ball"}, {"clamp_type": "hinged"}, {})]
    print("portal with a corner in a ball, hinged, welded:", *tips)
    expect(np.abs(tips[0] - tips[1]).max() < 1e-7, "in the plane a ball and a hinge are not alike")
    expect(tips[0][0] > 1.2 * tips[2][0] > 0.01, "a corner that gives way holds as a weld does")


IN_PLANE = {"rod_stiffness": 10, "rod_bend_ratio": 0.1}  # 1 in the plane, 10 out of it


def portal(load, push):
    """Its places across at a column's tip, in a run and of beam and columns that are nearly straight."""
    k, own = np.sqrt(load), {"tip_force_vector": f"{push},{-load},0", **IN_PLANE}
    run = Several({"a": {"clamp_direction": "0,1", **own}, "b": {"clamp_place": "1,0,0", "clamp_direction": "0,1", **own},
                   "beam": {"clamp_on": "a", "clamp_direction": "1,0,0", "tip_on": "b", **IN_PLANE}}, ts_max_time=100, rod_cells=12)
    bent = push / k ** 3
    tilted = bent * (k * np.sin(k) - 6 * (np.cos(k) - 1)) / (k * np.cos(k) + 6 * np.sin(k))
    return run, "a", run.tip("a")[0], tilted * (1 - np.cos(k)) + bent * (np.sin(k) - k)


def l_frame(foot, load, weight):
    """... half-way up its column, under a beam with a weight."""
    k = np.sqrt(load)
    run = Several({"foot": {"clamp_direction": "0,1", "clamp_type": foot, "tip_force_vector": f"0,{-load},0", **IN_PLANE},
                   "beam": {"clamp_place": "1,1,0", "clamp_direction": "-1,0,0", "clamp_type": "hinged", "tip_on": "foot",
                            "rod_weight": f"0,{-weight},0", **IN_PLANE}}, ts_max_time=100)
    s, c, half = np.sin(k), np.cos(k), (np.sin(k / 2), np.cos(k / 2))
    if foot == "hinged":  # a s + b sin ks, nothing at s = 1, where w'' + 3 w' = weight/8
        shape, slope, bend = 0.5 - half[0] / s, 1 - k * c / s, k ** 2
    else:  # 1 - cos ks + b (sin ks - ks)
        b = -(1 - c) / (s - k)
        shape, slope, bend = 1 - half[1] + b * (half[0] - k / 2), k * s + b * k * (c - 1), k ** 2 * (c - b * s)
    return run, "foot", run.x["foot"][-1, 8, 0], weight / 8 * shape / (bend + 3 * slope)


@check
def frames_give_way_at_their_critical_loads():
    """Below one, 7.379153560799 of a portal that is clamped and 13.88594290596 and 26.95826497181 of an L whose foot is hinged and clamped, they
    are where nearly straight rods are; above it they leave."""
    for name, below, above in (("portal", portal(7, 1e-6), portal(7.45, 1e-6)), ("L, hinged", l_frame("hinged", 13, 1e-5), l_frame("hinged", 14.2, 1e-5)),
                               ("L, clamped", l_frame("held", 25, 1e-5), l_frame("held", 27.5, 1e-5))):
        run, rod, across, known = below
        off, told = across / known - 1, run.series[rod]["error_norm_x2"][-1]
        print(f"{name}: off by {off:.1e} of {known:.2e}, told {told:.1e}; beyond it {above[2]:.2e}")
        expect(abs(off) < min(5e-4, told), f"{name}: {across}, not {known}")
        expect(abs(above[2]) > 0.01, f"{name}: beyond its load it is {above[2]} across")


def critical(rods, **more):
    """(the factor of all loads, what is told of its error, results) of a frame that stands."""
    file = Path(scene.SCRATCH) / "frame.opts"
    shared = {"task": "critical", "growth_type": "none", "shape_type": "straight", "friction_mu": 0, "growth_initial_length": 1} | more
    file.write_text("".join(f"-{key} {value}\n" for key, value in shared.items()) + "".join(
        f"[rod {name}]\n" + "".join(f"-{key} {value}\n" for key, value in own.items()) for name, own in rods.items()))
    said = scene.tendril(f"-options_file {file} -output {file}.h5")
    with h5py.File(f"{file}.h5") as f:
        found = {key: values[()] for key, values in f["critical"].items()}
    return float(found["factor"]), float(found["error"]), found, said


@check
def critical_loads_of_frames_are_the_exact_ones():
    """-task critical of several rods: an L with a hinged foot and a clamped one, a portal in its plane and out of it, a stepped column, a heavy
    one of two welded; to order 4, and below what is told. A follower force on two that are welded flutters."""
    stiff = {"rod_stiffness": 100, "rod_bend_ratio": 0.01}
    up = {"clamp_direction": "0,1", "tip_force_vector": "0,-1,0"}
    beam = {"clamp_place": "1,1,0", "clamp_direction": "-1,0,0", "clamp_type": "hinged", "tip_on": "foot"}
    columns = {"a": up, "b": up | {"clamp_place": "1,0,0"}, "beam": {"clamp_on": "a", "clamp_direction": "1,0,0", "tip_on": "b"}}
    half, heavy = {"growth_initial_length": 0.5}, {"rod_weight": "0,0,-1"}
    low, high = half | {"clamp_direction": "0,0,1"}, half | {"clamp_on": "low"}
    known = {
        "L, hinged": ({"foot": up | {"clamp_type": "hinged"}, "beam": beam}, stiff, 13.88594290596),
        "L, clamped": ({"foot": up, "beam": beam}, stiff, 26.95826497181),
        "portal": (columns, stiff, 7.379153560799),
        "portal, out of its plane": (columns, {}, np.pi ** 2 / 4),
        "stepped column": ({"low": low | {"rod_stiffness": 1.25}, "high": high | {"rod_stiffness": 0.25, "tip_force_vector": "0,0,-1"}}, {}, 1.659183128383),
        "heavy column": ({"low": low | heavy, "high": high | heavy}, {}, 7.8373474379)}
    for name, (rods, more, exact) in known.items():
        off = []
        for cells in (8, 16):
            factor, told, found, _ = critical(rods, rod_cells=cells, **more)
            off.append(abs(factor / exact - 1))
            expect(off[-1] * exact < told < 100 * off[-1] * exact, f"{name}: off by {off[-1] * exact:.1e}, told {told:.1e}")
        print(f"{name}: off by {off[0]:.1e}, {off[1]:.1e}")
        expect(off[1] < 5e-5 and 3.5 < np.log2(off[0] / off[1]) < 4.5, f"{name}: {off}")
        expect(found["frequency"] == 0 and abs(np.abs(found["mode"]).max() - 1) < 1e-12, name)
    pushed = {"tip_force": 1, "tip_law": "follower"}
    factor, _, found, said = critical({"low": low, "high": high | pushed}, rod_cells=10)
    whole, _, other, _ = critical({"whole": {"clamp_direction": "0,0,1"} | pushed}, rod_cells=20)
    print(f"follower on two: {factor:.8f}, on one: {whole:.8f}; {said.splitlines()[-1]}")
    expect(abs(factor / whole - 1) < 1e-9 and abs(found["frequency"] / other["frequency"] - 1) < 1e-6 and "flutter, frequency" in said, said)


TREE = {"stem": {"clamp_direction": "0,0,1", "rod_curvature": 0.3},
        "left": {"clamp_on": "stem", "clamp_at": 0.6, "clamp_angle": "50deg", "clamp_azimuth": "30deg", "rod_weight": "0,0.2,-0.5"},
        "right": {"clamp_on": "left", "clamp_angle": "-40deg", "tip_force_vector": "0.1,0.1,0.1", "clamp_spin": 0.2}}


@check
def a_scene_that_is_turned_is_turned_and_in_another_order_the_same():
    """Of a tree whose last branch is turned in its joint."""
    fixed = "-ts_adapt_type none -ts_dt 0.02 -ts_rtol 1e-11"
    shared = {"ts_max_time": 0.4, "friction_layers": "0:1"}
    run = Several(TREE, fixed, **shared)
    again = Several(dict(reversed(list(TREE.items()))), fixed, "again", **shared)
    turned = {rod: dict(own) for rod, own in TREE.items()}
    turned["stem"]["clamp_direction"] = "1,0,0"  # e1 -> e3 of the smallest turn, taken back: x, y, z -> z, y, -x
    turned["left"]["rod_weight"] = "-0.5,0.2,0"
    turned["right"]["tip_force_vector"] = "0.1,0.1,-0.1"
    turned = Several(turned, fixed, "turned", **shared)
    for rod in TREE:
        order = np.abs(again.x[rod] - run.x[rod]).max()
        turn = np.abs(turned.x[rod] - run.x[rod][..., [2, 1, 0]] * (1, 1, -1)).max()
        print(f"{rod}: another order {order:.1e}, turned {turn:.1e}")
        expect(order < 1e-12 and turn < 1e-11, f"{rod}: {order}, {turn}")
    balance = run.sums["energy"][-1] - run.sums["energy"][0]
    expect(abs(balance) > 1e-3, "nothing has moved")


@check
def a_tree_that_was_stopped_goes_on_to_the_last_digit():
    whole = Several(TREE, name="whole", ts_max_time=2)
    steps = len(whole.sums["t"])
    part = Path(scene.SCRATCH) / "part.h5"
    done = subprocess.run([scene.TENDRIL, "-options_file", str(whole.path), "-output", str(part), "-ts_max_steps", str(steps // 2), "-quiet"],
                          capture_output=True, text=True, env=scene.ENVIRONMENT)
    expect("-ts_max_steps: reached" in done.stderr, done.stderr)
    done = subprocess.run([scene.TENDRIL, "-restart", str(part), "-output_shapes", "1", "-quiet"], capture_output=True, text=True, env=scene.ENVIRONMENT)
    expect(done.returncode == 0 and not done.stderr, done.stderr)
    with h5py.File(whole.out) as a, h5py.File(part) as b:
        for group in ("series", "rods/series", "shapes"):
            for name in a[group]:
                expect(np.array_equal(a[group][name][:], b[group][name][:], equal_nan=True), f"{group}/{name} differs")


KINDS = {"stem": {"rod_curvature": 0.5}, "ball": {"clamp_on": "stem", "clamp_at": 0.4, "clamp_angle": 0.7, "clamp_azimuth": 0.5, "clamp_type": "ball",
                                                  "friction_radius": 0.1},
         "hinge": {"clamp_on": "stem", "clamp_at": 0.4, "clamp_angle": -1.2, "clamp_type": "hinged", "clamp_axis": "1,1,1"},
         "weld": {"clamp_on": "hinge", "clamp_angle": 0.3, "clamp_spin": 1}, "held": {"clamp_place": "3,0,0", "rod_curvature": 1},
         "tied": {"clamp_place": "3,0,0", "rod_curvature": 1, "tip_on": "held"},
         "pin": {"clamp_place": "3,0,0", "rod_curvature": 1, "tip_on": "held", "tip_type": "pinned"}}


@check
def the_matrix_is_the_derivative_of_the_equations():
    """Of joints of all kinds, as differences have it."""
    shared = STATIC | {"rod_cells": 4, "friction_layers": "0:1", "ts_max_time": 0.02, "rod_weight": "0,0.3,-1"}
    path = Path(scene.SCRATCH) / "kinds.opts"
    path.write_text("".join(f"-{key} {value}\n" for key, value in shared.items()) + "".join(
        f"[rod {rod}]\n" + "".join(f"-{key} {value}\n" for key, value in own.items()) for rod, own in KINDS.items()))
    done = subprocess.run([scene.TENDRIL, "-options_file", str(path), *shlex.split("-ts_adapt_type none -ts_dt 0.01 -snes_test_jacobian")],
                          capture_output=True, text=True, env=scene.ENVIRONMENT)
    expect(done.returncode == 0, done.stderr)
    off = [float(value) for value in re.findall(r"Jfd\|\|_F/\|\|J\|\|_F = (\S+),", done.stdout)]
    print(f"{len(off)} matrices, off by {max(off):.1e}")
    expect(len(off) > 2 and max(off) < 5e-8, off)


REFUSED = [  # (lines of a scene, what is said)
    ("[rod a]\n[rod b]\n-clamp_on c\n", "line 3, rod b: -clamp_on c: there is no rod of that name; there are a, b"),
    ("[rod a]\n-clamp_on a\n", "line 2, rod a: -clamp_on a: a rod cannot hold itself"),
    ("-task critical\n[rod a]\n-tip_force 1\n", "line 2, rod a: -growth_type uniform: -task critical of several rods is about frames"),
    ("-task critical\n-growth_type none\n-friction_beta 0\n[rod a]\n-tip_force 1\n", "rod a: -friction_beta: -task critical of several rods"),
    ("-task critical\n-growth_type none\n-tip_force 1\n[rod a]\n[rod b]\n-clamp_on a\n-born 1\n", "line 7, rod b: -born: -task critical of several rods"),
    ("-task critical\n-growth_type none\n[rod a]\n", "-task critical: nothing loads the rods"),
    ("-task critical\n-growth_type none\n[rod a]\n-clamp_direction 0,0,1\n-tip_force_vector 0,0,1\n", "-task critical: the rods are stable up to"),
    ("-task critical\n-growth_type none\n-tip_force 1\n[rod a]\n-clamp_direction 0,1\n-clamp_type hinged\n[rod b]\n-clamp_on a\n", "the rods move without a load"),
    ("[rod a]\n-clamp_on b\n[rod b]\n-clamp_on a\n", "line 2, rod a: -clamp_on b: that rod is carried by a itself, in the end"),
    ("[rod a]\n[rod b]\n-clamp_on a\n-clamp_at 0.6\n", "line 4, rod b: -clamp_at 0.6: rod a is 0.5 long as it begins"),
    ("[rod a]\n[rod b]\n-clamp_on a\n-clamp_at -1\n", "line 4, rod b: -clamp_at -1: rod a is 0.5 long as it begins"),
    ("[rod a]\n[rod b]\n-clamp_on a\n-clamp_at top\n", "line 4, rod b: -clamp_at top"),
    ("[rod a]\n[rod b]\n-clamp_at 0.2\n", "line 3, rod b: -clamp_at: says where on a rod, and -clamp_on says on which"),
    ("[rod a]\n[rod b]\n-clamp_on a\n-clamp_place 0,1,0\n", "line 4, rod b: -clamp_place: not with -clamp_on"),
    ("[rod a]\n[rod b]\n-clamp_azimuth 1\n", "line 3, rod b: -clamp_azimuth: is about the rod that carries this one"),
    ("[rod a]\n[rod b]\n-clamp_place 0,1,0\n-tip_on a\n", "line 4, rod b: -tip_on a: as the rods begin the tip is at"),
    ("[rod a]\n[rod b]\n-tip_on a\n-tip_force 1\n", "line 4, rod b: -tip_force: not of a tip that another rod holds"),
    ("[rod a]\n[rod b]\n-clamp_on a\n-clamp_type ball\n", "line 4, rod b: -clamp_type ball: nothing keeps the rod from spinning"),
    ("-growth_type none\n-shape_type straight\n[rod a]\n[rod b]\n-clamp_place 1,0,0\n-clamp_direction -1,0\n-tip_on a\n",
     "line 7, rod b: -tip_on a: rods that are straight do not stretch"),
    ("[rod a]\n-tip_on b\n[rod b]\n-tip_on a\n", "line 4, rod b: -tip_on a: the tip of rod a is held by this one already; leave one of them out"),
    ("[rod a]\n-clamp_type ball\n", "line 2, rod a: -clamp_type ball: is a joint between rods"),
]


@check
def what_is_wrong_is_told_with_rod_and_line():
    for text, said in REFUSED:
        code, found = refusal(text)
        expect(code != 0 and said in found and "\n" not in found and found.startswith("tendril: "), f"{text!r}: exit {code}, {found!r} and not {said!r}")


if __name__ == "__main__":
    sys.exit(scene.main())

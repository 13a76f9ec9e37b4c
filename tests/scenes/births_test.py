#!/usr/bin/env python3
"""Joints that go with the material of rods that are fed or grow at their tips, and rods that are born on these.

    births_test.py build/tendril CHECK...      (no CHECK: all of them)"""

import re
import shlex
import subprocess
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "support"))
import scene  # takes .venv's python if this one lacks numpy and h5py
from scene import Run, check, expect
from joined import Several, refusal

import h5py
import numpy as np

SHARED = {"friction_layers": "0:1", "ts_max_time": 1, "output_shapes": 4}
FED = {"growth_type": "feed", "growth_initial_length": 0.5, "rod_cells": 20}
ROOT = {"growth_type": "apical", "growth_initial_length": 0.5, "growth_zone": 0.3, "rod_cells": 32}
TWIG = {"growth_initial_length": 0.1, "rod_cells": 6}
LIGHT = {"rod_stiffness": 1e-6, "friction_strength": 1e-9}


def on(carrier, at, angle, **more):
    return TWIG | {"clamp_on": carrier, "clamp_at": at, "clamp_angle": angle} | more


def node_of(run, joint):
    """The joint's node among those of the rod that holds it."""
    with h5py.File(run.out) as f:
        names = [name.decode() for name in f["rods/name"]]
        j = [name.decode() for name in f["joints/name"]].index(joint)
        return f["joints/node"][j] - f["rods/first"][names.index(f["joints/on"][j].decode())]


@check
def twins_on_a_rod_that_is_fed_or_grows_leave_it_straight_and_go_with_its_material():
    """Fed material goes on at the speed of feeding, and rests behind a growth zone."""
    for tap, speed in ((FED, 1), (ROOT | {"growth_initial_length": 0.8}, 0)):
        run = Several({"tap": tap, "left": on("tap", 0.2, "70deg"), "right": on("tap", 0.2, "-70deg"), "next": on("tap", 0.4, "40deg"),
                       "beside": on("tap", 0.4, "-40deg")}, **SHARED)
        t = np.linspace(0, 1, 5)
        across = np.abs(run.x["tap"][..., 1:]).max()
        mirror = np.abs(run.x["left"] - run.x["right"] * (1, -1, 1)).max()
        way = np.abs(run.x["left"][:, 0, 0] - 0.2 - speed * t).max(), np.abs(run.x["next"][:, 0, 0] - 0.4 - speed * t).max()
        print(f"{tap['growth_type']}: across {across:.1e}, mirror {mirror:.1e}, way {way[0]:.1e}, {way[1]:.1e}")
        expect(across < 1e-12 and mirror < 1e-11 and max(way) < 1e-9, f"{across}, {mirror}, {way}")
        node = node_of(run, "left")
        expect(np.abs(run.x["tap"][:, node] - run.x["left"][:, 0]).max() < 1e-14, "it is off its place")
        balance = {rod: run.series[rod]["energy_defect"][-1] for rod in run.x if speed}  # what rests does no work
        expect(max(balance.values(), default=0) < 1e-5, balance)


@check
def a_rod_that_carries_next_to_nothing_is_the_rod():
    """Bent by nature, with joints that go along it; and the place that carries is where the material is."""
    for tap in (FED, ROOT):
        tap = tap | {"rod_curvature": 0.5, "rod_curvature_2": 0.3, "rod_cells": 48}
        run = Several({"tap": tap, "one": on("tap", 0.2, "70deg", **LIGHT), "two": on("tap", 0.35, "70deg", born=0.3, **LIGHT)},
                      "-ts_rtol 1e-7", **SHARED)
        words = " ".join(f"-{key} {value}" for key, value in (SHARED | tap).items())
        alone = Run(f"{words} -rod_model space -friction_mu 0 -shape_type straight -ts_rtol 1e-7 -quiet")
        off = np.abs(run.tip("tap") - alone.shapes["x"][-1, -1]).max()
        print(f"{tap['growth_type']}: off by {off:.1e}")
        expect(off < 2e-6, off)


@check
def a_rod_that_is_born_is_the_one_that_was_there_from_the_start_later():
    """On a rod that rests till then."""
    stem, twig = {"growth_type": "none", "rod_cells": 16}, on("stem", 0.4, "60deg", growth_type="uniform", rod_weight="0,0.5,-1", rod_cells=16)
    first = Several({"stem": stem, "twig": twig}, **SHARED)
    later = Several({"stem": stem, "twig": twig | {"born": 0.5}}, **SHARED | {"ts_max_time": 1.5, "output_shapes": 6})
    x = later.x["twig"]
    expect(np.isnan(x[:2]).all() and not np.isnan(x[2:]).any(), "shapes before and behind its birth")
    off = np.abs(x[2:] - first.x["twig"]).max(), np.abs(later.x["stem"][2:] - first.x["stem"]).max()
    t, series = later.sums["t"], later.series["twig"]
    expect(all(np.isnan(column[t < 0.5]).all() and not np.isnan(column[t >= 0.5]).any() for column in series.values()), "series")
    expect(np.abs(series["length"][t >= 0.5] - 0.1 - (t[t >= 0.5] - 0.5)).max() < 1e-12, "length")
    print(f"off by {off[0]:.1e}, {off[1]:.1e}; moved by {np.abs(first.x['stem'][-1] - first.x['stem'][0]).max():.2f}")
    expect(max(off) < 1e-5, off)
    for rod in ("stem", "twig"):
        defect = later.series[rod]["energy_defect"][-1]
        expect(defect < 1e-5, f"{rod}: energy is off by {defect}")


BORN = {"tap": ROOT | {"rod_curvature": 0.6}, "early": on("tap", 0.3, "70deg", growth_type="apical", growth_zone=0.05, born=0.2),
        "late": on("tap", 0.6, "60deg", clamp_azimuth="120deg", born=0.5, growth_type="apical", growth_zone=0.05),
        "twig": on("late", 0.06, "60deg", born=0.7)}


@check
def a_rod_is_born_at_its_place_and_turned_as_that_is():
    run = Several(BORN, **SHARED | {"output_shapes": 10})
    with h5py.File(run.out) as f:
        first, d1 = dict(zip((name.decode() for name in f["rods/name"]), f["rods/first"])), f["shapes/d1"][:]
        born = dict(zip(first, f["rods/born"][:]))
    for rod, on_rod, angle, at in (("early", "tap", 70, 0.3), ("late", "tap", 60, 0.6), ("twig", "late", 60, 0.06)):
        k = round(10 * born[rod])
        node = node_of(run, rod)
        along, way = d1[k, first[on_rod] + node], d1[k, first[rod]]
        turned = np.degrees(np.arccos(along @ way))
        place = np.abs(run.x[on_rod][k, node] - run.x[rod][k, 0]).max()
        arc = np.linalg.norm(np.diff(run.x[on_rod][k, :node + 1], axis=0), axis=1).sum()
        bent = np.abs(np.cross(run.x[rod][k] - run.x[rod][k, 0], way)).max()
        print(f"{rod}: {turned:.9f} degrees, at {arc:.5f}")
        expect(abs(turned - angle) < 1e-8 and place < 1e-12 and abs(arc - at) < 1e-4, f"{rod}: {turned}, {place}, {arc}")
        expect(np.isnan(run.x[rod][k - 1]).all() and bent < 1e-12, f"{rod}: {bent}")


@check
def a_run_that_was_stopped_before_or_at_a_birth_goes_on_to_the_last_digit():
    whole = Several(BORN, name="whole", **SHARED | {"output_shapes": 1})
    at = int(np.argmin(np.abs(whole.sums["t"] - 0.5)))
    for steps in (at - 5, at, at + 5):
        part = Path(scene.SCRATCH) / "part.h5"
        done = subprocess.run([scene.TENDRIL, "-options_file", str(whole.path), "-output", str(part), "-ts_max_steps", str(steps), "-quiet"],
                              capture_output=True, text=True, env=scene.ENVIRONMENT)
        expect("-ts_max_steps: reached" in done.stderr, done.stderr)
        done = subprocess.run([scene.TENDRIL, "-restart", str(part), "-output_shapes", "1", "-quiet"], capture_output=True, text=True,
                              env=scene.ENVIRONMENT)
        expect(done.returncode == 0 and not done.stderr, done.stderr)
        with h5py.File(whole.out) as a, h5py.File(part) as b:
            for group in ("series", "rods/series", "shapes"):
                for name in a[group]:
                    expect(np.array_equal(a[group][name][:], b[group][name][:], equal_nan=True), f"{steps}: {group}/{name} differs")


@check
def what_is_not_born_is_touched_by_nothing():
    """A rod goes through the place in which another one is born later, and meets it if that is there."""
    rods = {"post": {"growth_initial_length": 0.5, "clamp_place": "0.4,-0.3,0", "clamp_direction": "0,1,0"},
            "twig": on("post", 0.3, "90deg") | {"growth_initial_length": 0.3},
            "goes": FED | {"clamp_place": "0.25,0,-0.2", "clamp_direction": "0,0,1", "growth_initial_length": 0.1, "rod_cells": 8}}
    shared = SHARED | {"ts_max_time": 0.2, "contact_diameter": 0.02, "rod_cells": 12}
    there = Several(rods, "-contact_rods", **shared)
    late = Several(rods | {"twig": rods["twig"] | {"born": 0.5}}, "-contact_rods", **shared)
    force, depth = there.sums["contact_force"].max(), late.sums["contact_force"].max()
    print(f"pressed by {force:.2g}; {depth:g}")
    expect(force > 0.01 and depth == 0, f"{force}, {depth}")
    expect(np.abs(late.x["goes"][-1, -1] - (0.25, 0, 0.1)).max() < 1e-12, "it is put off")


@check
def the_matrix_is_the_derivative_where_joints_move():
    rods = {"tap": FED | {"rod_cells": 6, "rod_curvature": 0.5, "growth_initial_length": 1}, "weld": on("tap", 0.4, 0.7, clamp_spin=1, **FED),
            "ball": on("tap", 0.4, 0.7, clamp_azimuth=0.5, clamp_type="ball", friction_radius=0.1),
            "hinge": on("tap", 0.7, -1.2, clamp_type="hinged", clamp_axis="1,1,1"), "late": on("tap", 1.5, 0.7, born=1)}
    path = Path(scene.SCRATCH) / "kinds.opts"
    shared = {"friction_mu": 0, "friction_layers": "0:1", "shape_type": "straight", "rod_weight": "0,0.3,-1", "ts_max_time": 0.02, "rod_cells": 4}
    path.write_text("".join(f"-{key} {value}\n" for key, value in shared.items()) + "".join(
        f"[rod {rod}]\n" + "".join(f"-{key} {value}\n" for key, value in (own | {"rod_cells": 4}).items()) for rod, own in rods.items()))
    done = subprocess.run([scene.TENDRIL, "-options_file", str(path), *shlex.split("-ts_dt 0.01 -ts_max_steps 2 -snes_test_jacobian")],
                          capture_output=True, text=True, env=scene.ENVIRONMENT)
    expect("Jfd" in done.stdout, done.stderr)
    off = [float(value) for value in re.findall(r"Jfd\|\|_F/\|\|J\|\|_F = (\S+),", done.stdout)]
    print(f"{len(off)} matrices, off by {max(off):.1e}")
    expect(len(off) > 2 and max(off) < 5e-8, off)


REFUSED = [  # (lines of a scene, what is said)
    ("[rod a]\n-growth_type feed\n[rod b]\n-clamp_on a\n-clamp_at base\n", "line 5, rod b: -clamp_at base: that place of rod a, which is fed, is not in"),
    ("[rod a]\n-growth_type feed\n[rod b]\n-clamp_on a\n-clamp_at 0.2\n-born 1\n",
     "line 5, rod b: -clamp_at 0.2: that place of rod a, which is fed, is not in at t = 0"),
    ("[rod a]\n-growth_type apical\n-growth_zone 0.3\n[rod b]\n-clamp_on a\n-clamp_at 0.3\n",
     "line 6, rod b: -clamp_at 0.3: is in the growth zone of rod a then, where material stretches; give a place nearer its base, or -born 0.1"),
    ("[rod a]\n-born 1\n-clamp_type free\n", "line 3, rod a: -clamp_type free"),
    ("[rod a]\n[rod c]\n-clamp_on a\n-born 2\n[rod b]\n-clamp_on c\n-born 1\n", "line 7, rod b: -born 1: rod c, which carries it, is born at 2"),
    ("[rod a]\n[rod b]\n-clamp_on a\n-clamp_at 2\n-born 1\n", "line 4, rod b: -clamp_at 2: rod a is 1.5 long then"),
    ("[rod a]\n[rod b]\n-clamp_on a\n-clamp_direction 0,1,0\n-born 1\n", "line 4, rod b: -clamp_direction: not of a rod that is born"),
    ("[rod a]\n[rod b]\n-clamp_on a\n-clamp_type hinged\n-born 1\n", "line 4, rod b: -clamp_type hinged: not of a rod that is born"),
    ("[rod a]\n[rod b]\n-clamp_place 0,0.5,0\n-tip_on a\n-born 1\n", "line 5, rod b: -born: not where a tip is held"),
    ("[rod a]\n-tip_type pinned\n-born 1\n-shape_amplitude 0.1\n", "line 3, rod a: -born: not of a rod whose tip is held or led"),
    ("-si_bending_stiffness 5e-7\n-si_friction_dry 2N/m\n-si_speed 1mm/h\n[rod a]\n-growth_initial_length 1cm\n[rod b]\n-clamp_on a\n-born 2h\n"
     "-clamp_at 30mm\n", "line 9, rod b: -clamp_at 30mm: rod a is 1.904881262 (1.2 cm) long then"),
    ("[rod a]\n[rod b]\n-born soon\n", "line 3, rod b: -born soon"),
    ("-ts_adapt_type none\n[rod a]\n[rod b]\n-clamp_place 0,1,0\n-born 1\n", "-born: ends a step"),
]


@check
def what_cannot_be_born_is_told_with_rod_and_line():
    for text, said in REFUSED:
        code, found = refusal(text)
        expect(code != 0 and said in found and "\n" not in found and found.startswith("tendril: "), f"{text!r}: exit {code}, {found!r} and not {said!r}")


if __name__ == "__main__":
    sys.exit(scene.main())

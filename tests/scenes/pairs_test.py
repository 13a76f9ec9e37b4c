#!/usr/bin/env python3
"""Rods that touch each other: forces that are known, mirror images, and runs that go on.

    pairs_test.py build/tendril CHECK...      (no CHECK: all of them)"""

import shlex
import subprocess
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "support"))
import scene  # takes .venv's python if this one lacks numpy and h5py
from scene import Run, check, expect

import h5py
import numpy as np


def start(text, more="", out="pairs.h5"):
    """A run of an options file of this text."""
    path, out = Path(scene.SCRATCH) / "pairs.opts", Path(scene.SCRATCH) / out
    path.write_text(text)
    done = subprocess.run([scene.TENDRIL, "-options_file", str(path), *shlex.split(more), "-output", str(out), "-quiet"],
                          capture_output=True, text=True, env=scene.ENVIRONMENT)
    return done, out


def several(text, more=""):
    """The last shapes and series of each rod, {name: (x, series)}, and the series of all."""
    done, out = start(text, more)
    expect(done.returncode == 0 and not done.stderr, done.stderr)
    found = {}
    with h5py.File(out) as f:
        for k, name in enumerate(f["rods/name"][:]):
            first, count = f["rods/first"][k], f["rods/count"][k]
            found[name.decode()] = f["shapes/x"][-1, first:first + count], {n: c[:, k] for n, c in f["rods/series"].items()}
        return found, {n: c[:] for n, c in f["series"].items()}


SLACK = "-growth_type none -friction_mu 0 -friction_layers 0:1 -output_shapes 1 "  # rods that come to rest
CROSSED = """-growth_type none
-growth_initial_length 2
-shape_type file
-shape_file {hump}
-tip_type slides
-tip_force -10
-contact_diameter 0.1
-friction_mu 0
-friction_layers 0:1
-ts_max_time 20
-rod_cells 60
[rod a]
-clamp_place -1,-0.001464,0
-shape_turn 90deg
[rod b]
-clamp_place -0.001464,-1,0
-clamp_direction 0,1,0
-shape_turn -90deg
[pair a b]
"""


@check
def crossed_cables_press_by_what_bends_them():
    """Two cables of length 2, clamped in direction and pulled by 10, cross at their middles, each deflected by 0.05: by the
    plane's equations, solved by shooting, they press by 2.3922021992, and nearly in proportion to the deflection."""
    hump = Path(scene.SCRATCH) / "hump.h5"
    s = np.linspace(0, 1, 401)
    with h5py.File(hump, "w") as f:
        f["s"], f["theta"] = s, 0.2 * np.sin(2 * np.pi * s)
    found, sums = several(CROSSED.format(hump=hump))
    for name, (x, series) in found.items():
        away = np.abs(x[:, 2]).max()
        press = 2 * abs(series["base_force_3"][-1])
        off = press / (2.3922021992 / 0.05 * away) - 1
        print(f"{name}: deflected by {away:.6f}, pressed by {press:.6f}, off by {off:.1e}; defect {series['energy_defect'][-1]:.1e}")
        expect(abs(off) < 1e-3, f"{name}: {off}")
        expect(abs(away - 0.05) < 2e-4 and sums["penetration"].max() < 1e-2 * 0.1, f"{name}: {away}, {sums['penetration'].max()}")
        expect(series["energy_defect"][-1] < 1e-3, f"{name}: {series['energy_defect'][-1]}")
    normal = sums["contact_force"][-1]
    expect(abs(normal / press - 1) < 5e-3, f"{normal} is not {press}")
    given = [series["wall_power"] for _, series in found.values()]
    expect(np.abs(given[0] + given[1]).max() < 1e-12, "what rods give each other does not cancel")


TWIN = "-growth_initial_length 0.4 -contact_diameter 0.05 -contact_friction {mu} -rod_cells 40 -ts_max_time 0.5 -growth_type feed -friction_beta 1e-4 " \
       "-shape_type straight -rod_curvature_2 {bend} -clamp_place {place}"


@check
def mirror_twins_are_a_rod_and_a_plane():
    """Two rods that bend towards each other meet where a plane would be; what rubs on the plane does not on the twin, which
    goes along."""
    wall = Path(scene.SCRATCH) / "plane.txt"
    wall.write_text("plane 0 0 -0.1 0 0 1 friction 0\n")
    shared = "".join(f"{a} {b}\n" for a, b in zip(*[iter(shlex.split(TWIN.format(mu=0.4, bend=0.6, place="0,0,0")))] * 2))
    found, _ = several(shared + "[rod up]\n[rod down]\n-clamp_place 0,0,-0.2\n-rod_curvature_2 -0.6\n[pair up down]\n")
    alone = Run(TWIN.format(mu=0, bend=0.6, place="0,0,0").replace("-contact_friction 0 ", "") + f" -wall_file {wall} -rod_model space -quiet")
    x, y = found["up"][0], found["down"][0]
    off = np.abs(x - alone.shapes["x"][-1]).max()
    mirrored = np.abs(x * [1, 1, -1] - [0, 0, 0.2] - y).max()
    press = found["up"][1]["contact_force"][-1] + found["down"][1]["contact_force"][-1]
    print(f"off the plane's by {off:.1e}, off the twin by {mirrored:.1e}; presses by {press:.4f}, {alone.contact_force[-1]:.4f}")
    expect(alone.contact_force[-1] > 0.05, "it does not touch")
    expect(mirrored < 1e-9 and off < 1e-3, f"{mirrored}, {off}")
    expect(abs(press / alone.contact_force[-1] - 1) < 1e-2, f"{press}")


ROPE = """-growth_type uniform
-growth_initial_length 1
-friction_beta 1e-3
-shape_type straight
-contact_diameter 0.08
-contact_friction 0.3
-rod_cells 20
-ts_max_time 0.4
-output_interval 0.1
{rods}[pair bent bar tilted]
"""
RODS = {"bent": "-rod_curvature 1.2\n-rod_curvature_2 0.5\n", "bar": "-clamp_place 0.82,0.85,-1.2\n-clamp_direction 0.1,0,1\n",
        "tilted": "-clamp_place 0.7,1.1,-1.2\n-clamp_direction 0,0.1,1\n-rod_curvature 0.3\n-contact_diameter 0.06\n"}


def rope(order):
    return ROPE.format(rods="".join(f"[rod {name}]\n{RODS[name]}" for name in order))


DENSE = """-growth_type uniform
-growth_initial_length 0.4
-shape_type straight
-contact_diameter 0.0371
-friction_mu 0
-friction_beta 1e-3
-ts_max_time 0.35
-rod_cells 24
-rod_weight 0.917,0,-0.628
[rod bent]
-clamp_place 0,0,-0.0908
-clamp_direction 0.619,0.732,0.284
-rod_curvature 0.511
-rod_curvature_2 0.0696
[rod free]
-clamp_place 0.4,0,-0.0734
-clamp_direction 0.154,0.964,0.218
[rod thick]
-clamp_place 0,0.4,-0.0701
-clamp_direction 0.918,0.272,0.288
-rod_curvature 0.425
-rod_curvature_2 -0.538
-contact_diameter 0.0552
[pair bent free thick]
"""


@check
def rods_that_press_each_other_take_the_steps_that_contact_leaves_sense_in():
    """What contact that is not rigid puts them off by is known, so steps need not be finer; one that is free keeps its own
    tolerance. They stay within what they tell."""
    fine, all_fine = several(DENSE, "-contact_rtol 1e-5")
    told, sums = several(DENSE)
    steps = len(sums["t"]), len(all_fine["t"])
    exact, _ = several(DENSE, "-ts_rtol 1e-6 -rod_cells 36 -contact_stiffness 1e7")
    print(f"{steps[0]} steps, {steps[1]} of those that are never eased")
    expect(sums["contact_force"].max() > 0.1, "they do not press")
    expect(steps[0] < 0.7 * steps[1], f"{steps}")
    for name, (x, series) in told.items():
        off = np.linalg.norm(x[-1] - exact[name][0][-1]) / series["length"][-1]
        print(f"{name}: off by {off:.1e}, told {series['error_tip'][-1]:.1e}, {fine[name][1]['error_tip'][-1]:.1e}")
        expect(off < series["error_tip"][-1], f"{name}: {off}")
    expect(told["free"][1]["error_tip"][-1] < 2 * fine["free"][1]["error_tip"][-1], "what is free is eased, too")


@check
def order_changes_nothing_but_round_off():
    first, sums = several(rope(("bent", "bar", "tilted")))
    again, _ = several(rope(("tilted", "bent", "bar")))
    expect(sums["contact_force"][-1] > 0.1, f"they do not touch: {sums['contact_force'][-1]}")
    slippery, _ = several(rope(("bent", "bar", "tilted")), "-contact_friction 0")
    rubbed = np.abs(first["bent"][0] - slippery["bent"][0]).max()
    expect(rubbed > 1e-4, f"friction between rods, the mean of both, changes nothing: {rubbed}")
    for name in RODS:
        off = np.abs(first[name][0] - again[name][0]).max()
        print(f"{name}: {off:.1e}")
        expect(off < 1e-6, f"{name}: {off}")


@check
def a_run_goes_on_in_contact_to_the_last_digit():
    done, whole = start(rope(RODS), out="whole.h5")
    expect(done.returncode == 0, done.stderr)
    with h5py.File(whole) as f:
        steps = len(f["series/t"])
        touch = f["series/contact_force"][2 * steps // 3]
    expect(touch > 0, "nothing touches where it stops")
    stopped, part = start(rope(RODS), f"-ts_max_steps {2 * steps // 3}", out="part.h5")
    expect("-ts_max_steps: reached" in stopped.stderr, stopped.stderr)
    again = subprocess.run([scene.TENDRIL, "-restart", str(part), "-quiet"], capture_output=True, text=True, env=scene.ENVIRONMENT)
    expect(again.returncode == 0 and not again.stderr, again.stderr)
    with h5py.File(whole) as a, h5py.File(part) as b:
        expect(a["pairs/first"][-1] > 0 and (a["pairs/gap"][:] < 0.01).all(), "no pairs are stored")
        press = np.linalg.norm(a["pairs/force"][:][a["pairs/first"][-2]:], axis=1).sum()
        expect(0.9 < press / a["series/contact_force"][-1] < 1.2, f"pairs press by {press}")
        for group in ("series", "rods/series", "shapes", "pairs"):
            for name in a[group]:
                one, two = a[group][name][:], b[group][name][:]
                expect(one.shape == two.shape and np.array_equal(one, two, equal_nan=True), f"{group}/{name} differs")


if __name__ == "__main__":
    sys.exit(scene.main())

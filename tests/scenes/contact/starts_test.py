#!/usr/bin/env python3
"""Starts out of balance, and shapes that stop being stable: a rod that viscous friction holds goes where steps that
see all it does take it, of whatever length it is, behind a hinge, on any number of ranks, in space and between walls.

    starts_test.py build/tendril [--mpiexec mpiexec] CHECK...      (no CHECK: all of them)

Where it goes was found by first steps of 1e-8 L^4 and tolerances of 1e-7, and by the least energy there is."""

import random
import re
import subprocess
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "support"))
import scene  # takes .venv's python if this one lacks numpy and h5py
from scene import Run, check, expect

import h5py
import numpy as np

sys.path.insert(0, str(scene.ROOT / "scripts/lab"))
import scaled as lab

S = np.linspace(0, 1, 401)
STILL = "-growth_type none -shape_type file -friction_mu 0 "
HALF_WAVE, LAST = 0.61684, "-rod_cells 100 -ts_max_steps 2000 "  # its energy times its length: pi^2/16


def shape(name, theta):
    """The options for an initial shape of these angles."""
    file = f"{scene.SCRATCH}/{name}.h5"
    with h5py.File(file, "w") as f:
        f["s"], f["theta"] = S, theta
    return f"-shape_file {file} "


def wave(waves, amplitude, asymmetry, arch=0):
    """So many half waves, and a little of one."""
    return shape("wave", amplitude * (np.cos(waves * np.pi * S) - 1) + asymmetry * (np.cos(np.pi * S) - 1)
                 + arch * np.sin(np.pi * S))


def energy(r):
    """The energy at the end, times the length: that of a shape, whatever its size."""
    return r.energy[-1] * r.length[-1]


def ends(r, what, value, part=1e-3, told=None):
    """It has come to the shape of this energy, and says no less than it is off."""
    off = abs(energy(r) / value - 1)
    print(f"{what}: {r.steps} steps, energy {energy(r):.5f}, off {off:.1e}, told {r.estimate:.1e}")
    expect(off < part, f"{what}: energy {energy(r)}, not {value}")
    if told is not None:
        expect("snap" not in r.said and r.estimate < told, f"{what}: {r.said[-600:]}")


@check
def five_half_waves_give_way_to_the_side_that_small_steps_take():
    """Five half waves: the first step had been taken for a snap, and had decided the side."""
    start = wave(5, 0.6547080143778274, 0.000344, -0.0006141549369480942)
    for cells in (100, 160):
        r = Run(STILL + start + "-growth_initial_length 0.0625 -ts_max_time 1 -tip_type pinned "
                f"-rod_cells {cells} -ts_max_steps 2000")
        ends(r, f"{cells} cells", 4.20426, told=1e-4)


@check
def an_arch_in_exact_friction_sinks_evenly_and_stops():
    """In exact friction: the arch sinks evenly, stops and is held; it had turned over."""
    r = Run("-growth_type none -shape_type file " + shape("arch", 1.1 * np.sin(2 * np.pi * S)) +
            "-growth_initial_length 0.1 -tip_type clamped -friction_mu 0.9 -friction_beta 0 -rod_weight 0,-160000 "
            "-rod_curvature_random 1e-5 -rod_curvature_length 0.3 -ts_max_time 3 -rod_cells 200")
    ends(r, "arch", 15.1239)
    expect(r.shapes["x"][-1, 100, 1] > 0.02, f"the arch is at {r.shapes['x'][-1, 100]}")


@check
def a_rod_between_smooth_walls_gives_way_as_by_small_steps():
    """Between two smooth walls: resolved, a rod that gives way is off by 5 % from where long steps take it."""
    walls = Path(scene.SCRATCH) / "walls.txt"
    place, across = np.array([0.00329519393, 0.00320993009]), np.array([0.71631343, 0.697778668])
    walls.write_text("".join(f"plane {' '.join(map(str, [*(side * place), *(-side * across)]))} friction 0\n"
                             for side in (-1, 1)))
    r = Run(STILL + wave(3, 0.7977725945027618, 0.000732) + "-growth_initial_length 0.0465 -ts_max_time 1 "
            f"-rod_cells 100 -tip_type pinned -wall_file {walls} -contact_diameter 0.00022440060536653016")
    ends(r, "corridor", 13.21442, part=2e-3, told=1e-2)


@check
def a_side_that_errors_decide_is_told():
    """A rod between two walls with friction that gives way by a mode so small at first that errors of the steps turn it: it
    comes to rest elsewhere, 2.9 % of its length away, where errors that are carried along have long faded (told 2e-5)."""
    walls = Path(scene.SCRATCH) / "walls.txt"
    place, across = np.array([0.0107904337, 0.0276980958]), np.array([0.363000005, 0.931789137])
    walls.write_text("".join(f"plane {' '.join(map(str, [*(side * place), *(-side * across)]))} friction 0.3\n"
                             for side in (-1, 1)))
    options = ("-growth_type none -shape_type file -friction_mu 0.5 " + wave(3, 0.37142770002930303, 5.78e-5) +
               "-growth_initial_length 0.632 -ts_max_time 1 -rod_cells 100 -tip_type clamped "
               f"-wall_file {walls} -contact_diameter 0.0014500347462667916")
    r, fine = Run(options), Run(options + " -ts_rtol 1e-7")
    off = np.abs(r.shapes["x"][-1] - fine.shapes["x"][-1]).max() / r.length[-1]
    end = r.told["end_estimate"]
    print(f"off by {off:.1e}, told {end:.1e} at the end, {r.error_norm_x2[-1]:.1e} of |x2| in its series")
    expect(end >= max(off, 0.5) and r.error_norm_x2[-1] >= 0.5, f"off by {off}, told {end}")
    file = f"{scene.SCRATCH}/broken.h5"  # the mode has grown by then
    for words in ([*options.split(), "-ts_max_steps", "70", "-output", file], ["-restart", file]):
        subprocess.run([scene.TENDRIL, *words], capture_output=True, env=scene.ENVIRONMENT, check=False)
    with h5py.File(file) as f:
        expect(f.attrs["error_end_estimate"] == end, f"told {f.attrs['error_end_estimate']} behind a restart, {end} in one run")


@check
def a_rod_in_a_hinge_takes_the_same_steps_at_any_length():
    """Viscous friction without growth has no scale but time, so all lengths take the same steps to the same side."""
    steps = {}
    for length in (1, 0.3, 0.1, 0.03, 0.001):
        r = Run(STILL + wave(2, 0.5, 1e-6) + f"-growth_initial_length {length} -clamp_type hinged -tip_type pinned "
                f"-ts_max_time {5 * length**4} {LAST}")
        ends(r, f"L = {length}", HALF_WAVE)
        angles = r.shapes["theta"][-1, [0, -1]]
        expect(np.abs(angles - [-0.0007, -0.9993]).max() < 1e-3, f"L = {length}: the other side, {angles}")
        expect(1e-4 < r.estimate < 1e-2, f"L = {length}: told {r.estimate}")
        steps[length] = r.steps
    expect(max(steps.values()) - min(steps.values()) <= 1, f"steps by lengths: {steps}")
    for length in (0.3, 0.03):
        r = Run(STILL + wave(2, 0.5, 1e-6) + f"-growth_initial_length {length} -clamp_type hinged -tip_type clamped "
                f"-ts_max_time 5 {LAST}")
        ends(r, f"clamped tip, L = {length}", HALF_WAVE)
        r = Run(STILL + wave(2, 0.5, 1e-6) + f"-growth_initial_length {length} -clamp_type hinged -tip_type pinned "
                f"-ts_max_time 5 -rod_model space {LAST}")
        ends(r, f"in space, L = {length}", HALF_WAVE)


@check
def errors_of_a_rod_in_a_hinge_are_told():
    """Errors of a rod in a hinge are those of a rod that tilts there: falling from a whole wave to the half one it is
    off by 1e-4 for a while, and had been told 1e-6."""
    options = (STILL + wave(2, 0.5, 1e-6) + "-growth_initial_length 1 -clamp_type hinged -tip_type pinned "
               "-ts_max_time 5 -output_shapes 200 " + LAST)
    coarse, fine = Run(options), Run(options + "-ts_rtol 1e-9")
    later = slice(2, 200)  # a hundredth of the run is its start's
    off = np.abs(coarse.shapes["x"][later] - fine.shapes["x"][later]).max()
    print(f"off by {off:.1e}, told {coarse.estimate:.1e}, with a thousandth of the tolerance {fine.estimate:.1e}")
    expect(2e-5 < off < coarse.estimate < 100 * off, f"off by {off}, told {coarse.estimate}")
    expect(fine.estimate < 0.02 * coarse.estimate, f"told {coarse.estimate} and {fine.estimate}")


@check(ranks=3)
def several_ranks_count_the_growing_modes_as_one():
    """Several ranks count the modes that grow as one does."""
    far = Path(scene.SCRATCH) / "far.txt"
    far.write_text("plane 0 -3 0 1\n")
    options = STILL + wave(2, 0.5, 1e-6) + "-growth_initial_length 0.03 -tip_type pinned -ts_max_time 5 " + LAST
    for more in ("", f"-wall_file {far}", "-rod_model space", "-clamp_type hinged"):
        alone = Run(options + more)
        ends(alone, f"1 rank {more}", HALF_WAVE)
        for number in ((2, 3) if not more else (2,)):
            r = Run(options + more, ranks=number)
            ends(r, f"{number} ranks {more}", HALF_WAVE)
            expect(abs(r.steps - alone.steps) <= 2, f"{r.steps} steps on {number} ranks, {alone.steps} on one")


@check
def an_upright_arch_in_space_does_not_crawl():
    """An arch in space that stands upright only because nothing pushes it out of its plane: it had crawled."""
    options = (STILL + shape("arch", 1.1 * np.sin(2 * np.pi * S)) + "-growth_initial_length 0.1 -tip_type clamped "
               "-rod_curvature_random 1e-5 -rod_curvature_length 0.3 -ts_max_time 3 -rod_weight 0,-140000 " + LAST)
    flat = Run(options)
    upright = Run(options + "-rod_model space")
    expect(abs(energy(upright) / energy(flat) - 1) < 1e-5, f"energies {energy(upright)}, {energy(flat)}")
    expect(np.abs(upright.norm_x3).max() == 0, "x3 is not 0")
    expect("unstable out of its plane" in upright.said, upright.said[-800:])
    advised = re.search(r"-rod_curvature_2 ([0-9.e+-]+)", upright.said)[1]
    for push in (f"-rod_curvature_2 {advised}", "-rod_weight 0,-140000,1.4"):
        fallen = Run(options + push)
        print(f"{push}: {fallen.steps} steps, |x3| up to {fallen.norm_x3.max():.2e}, energy {energy(fallen):.3f}")
        expect(fallen.norm_x3.max() > 0.005, f"{push}: |x3| {fallen.norm_x3.max()}")
        expect("unstable" not in fallen.said, fallen.said[-800:])
    lies = Run(STILL + wave(2, 0.5, 1e-3) + "-growth_initial_length 0.1 -ts_max_time 1 -rod_model space " + LAST)
    expect("unstable" not in lies.said, "a free rod that has straightened is stable")


@check
def plane_starts_in_space_end_as_in_the_plane():
    """Plane starts in space: each ends as in the plane."""
    dice = random.Random(7)
    for _ in range(5):
        start = wave(dice.choice([2, 3, 4, 5]), dice.uniform(0.3, 1.2), 10**dice.uniform(-6, -2))
        length = 10**dice.uniform(-2, -0.5)
        options = (STILL + start + f"-growth_initial_length {length:.3g} -ts_max_time 1 "
                   f"-tip_type {dice.choice(['pinned', 'clamped'])} " + LAST)
        ends(Run(options + "-rod_model space"), f"L = {length:.3g}", energy(Run(options)))


@check
def a_rod_that_goes_to_rest_in_weak_drag_does_not_snap():
    """A rod that goes to rest in a weak drag does not snap: there is no dry friction that could not hold it."""
    base = "-growth_type none -growth_initial_length 1 -shape_type straight -friction_mu 0 -ts_max_steps 2000 "
    path = Path(scene.SCRATCH) / "path.csv"
    path.write_text("t,x1\n0,0.99\n1,0.79\n2,0.79\n")
    for options in ("-friction_layers 0:0.01 -tip_force_vector 0,0.1 -ts_max_time 50",
                    "-friction_layers 0:0.001 -tip_force_vector 0,0.1 -ts_max_time 50",
                    "-friction_layers 0:0.01 -tip_force_vector 0,0.0001 -ts_max_time 50",
                    "-friction_layers 0:0.01 -tip_force_vector 0,1 -ts_max_time 5000",
                    "-friction_layers 0:0.01 -tip_force_vector 0,0.1,0.1 -ts_max_time 50 -rod_cells 100"):
        r = Run(base + options)
        ends(r, options, energy(r), told=2e-5)
        if "0,0.1 " in options:
            expect(np.abs(r.tip - [0.9993346, 0.03329532]).max() < 1e-6, f"{options}: tip {r.tip}")
    for options in ("-shape_type mode", f"-shape_type sag -shape_amplitude 0.05 -tip_path {path}"):
        r = Run("-growth_type none -growth_initial_length 1 -friction_mu 0 -friction_layers 0:0.01 -ts_max_time 50 "
                "-tip_type clamped " + options)
        ends(r, options, energy(r), told=2e-5)


@check
def scenes_of_any_length_take_the_same_steps():
    """Scenes without units, their lengths times 1e-3 and 1e3 and all that follows: the same steps."""
    for seed in (1001, 1005, 1006, 1014, 1018, 1024, 1039, 77007, 77030, 79018, 79025):
        one = lab.Scene(random.Random(seed))
        ran = [lab.steps(scene.TENDRIL, one.scaled(c)) for c in (1, 1e-3, 1e3)]
        print(seed, ran)
        expect(not isinstance(ran[0], str), f"{one.scaled(1)}: {ran[0]}")
        expect(all(lab.alike(ran[0], other) for other in ran[1:]), f"{one.scaled(1)}: {ran}")


@check
def a_rod_that_rests_between_walls_rests_in_any_units():
    """A rod in its natural shape, between walls that it does not touch: what short steps make of round-off is no motion."""
    one = lab.Scene(random.Random(92036), walls=True)
    ran = [lab.steps(scene.TENDRIL, one.scaled(c)) for c in (1, 1e-3, 0.03, 1e3)]
    print(ran)
    expect(all(not isinstance(r, str) and r[0] <= 20 for r in ran), ran)
    r = Run(one.scaled(1e-3))
    expect(abs(r.series["energy_defect"][-1]) < 1e-6, r.series["energy_defect"][-1])


@check
def a_short_rod_is_short_behind_a_restart():
    """What is short for a rod is so behind a restart."""
    options = (STILL + wave(3, 0.5, 1e-4) + "-growth_initial_length 0.1 -tip_type pinned " + LAST).split()
    whole, broken = (f"{scene.SCRATCH}/{name}.h5" for name in ("whole", "broken"))
    end = ["-ts_max_time", "1e-3"]

    def run(*more):
        done = subprocess.run([scene.TENDRIL, *more], capture_output=True, text=True, env=scene.ENVIRONMENT)
        expect(done.returncode == 0, done.stderr)

    run(*options, *end, "-output", whole)
    with h5py.File(whole) as f:
        t = f["series/t"][:]
    run(*options, "-ts_max_time", repr(float(t[len(t) // 3])), "-output", broken)
    run("-restart", broken, *end)
    with h5py.File(whole) as a, h5py.File(broken) as b:
        steps = [len(f["series/t"]) for f in (a, b)]
        apart = np.abs(a["shapes/x"][-1] - b["shapes/x"][-1]).max() / 0.1
    print(f"{steps} steps, {apart:.1e} apart")
    expect(abs(steps[0] - steps[1]) <= 3 and apart < 1e-7, f"{steps} steps, {apart} apart")


if __name__ == "__main__":
    sys.exit(scene.main())

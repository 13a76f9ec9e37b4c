#!/usr/bin/env python3
"""Physics that is odd but possible, and some that is not: a right answer or a plain refusal.

    bad_physics.py build/tendril [CHECK...]      (no CHECK: all of them)"""

import subprocess
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "support"))
import scene  # takes .venv's python if this one lacks numpy and h5py
from held import HANG
from scene import Failure, check, expect

import h5py
import numpy as np

BENT = "-growth_initial_length 2 -shape_amplitude 0.1 "


def tendril(options):
    """(exit code, stderr, results)"""
    file = Path(scene.SCRATCH) / "run.h5"
    file.unlink(missing_ok=True)
    try:
        done = subprocess.run([scene.TENDRIL, *options.split(), "-output", str(file)], text=True,
                              capture_output=True, env=scene.ENVIRONMENT, timeout=HANG)
    except subprocess.TimeoutExpired:
        raise Failure(f"{options}: hung") from None
    results = {}
    if file.exists():
        with h5py.File(file) as f:
            results = {name: data[:] for name, data in f["series"].items()}
            results.update({f"shapes/{name}": data[:] for name, data in f["shapes"].items()})
    return done.returncode, done.stderr.strip(), results


def grown(options):
    code, err, results = tendril(options)
    expect(code == 0, f"{options}: exit {code}, {err}")
    for name, values in results.items():
        expect(np.isfinite(values).all(), f"{options}: {name} holds what is not a number")
    print(f"  {options}: {len(results['t']) - 1} steps, energy defect "
          f"{results['energy_defect'].max():.1e}")
    return results


def refused(options, word):
    """Before any work, in one plain line that says what is wrong."""
    code, err, _ = tendril(options)
    expect(code > 0, f"{options}: exit {code}")
    expect(len(err.splitlines()) == 1 and word in err, f"{options}: says {err!r}, not {word!r}")
    print(f"  refused: {err}")


def table(name, g, times, labels=41):
    """A growth table g(s, t) as file; its options."""
    s = np.linspace(0, 1, labels)
    with h5py.File(f"{scene.SCRATCH}/{name}", "w") as f:
        f["s"], f["t"] = s, times
        f["g"] = np.array([g(s, t) * np.ones(labels) for t in times])
    return (f"-growth_type table -growth_table {scene.SCRATCH}/{name} -shape_amplitude 0.1 "
            f"-ts_max_time {times[-1]:g} ")


def ramp(t, begin, end):
    """0 to 1, smooth to the second derivative."""
    x = np.clip((t - begin) / (end - begin), 0, 1)
    return x ** 3 * (10 - 15 * x + 6 * x * x)


@check
def a_rod_whose_growth_stops_comes_to_rest():
    """The rod comes to rest; what is left of its speed is the creep that beta allows."""
    times = np.linspace(0, 8, 81)
    r = grown(table("stops.h5", lambda s, t: 2 + 3 * ramp(t, 0, 3), times))
    expect(abs(r["length"][-1] - 5) < 1e-9, f"length {r['length'][-1]}")
    moving, late = r["tip_speed"][r["t"] < 3].max(), r["tip_speed"][-1]
    expect(late < 2e-2 * moving, f"the tip moves at {late:g}, before at {moving:g}")
    energy = r["energy"][r["t"] > 3.2]
    expect((np.diff(energy) <= 1e-6 * energy[0]).all(), "the energy rises in a rod at rest")


@check
def a_rod_that_shrinks_is_as_long_as_it_should():
    """Grown to 5 and back to 2: the length is right, the energy balance holds. A straight rod ends
    where it began."""
    times = np.linspace(0, 8, 81)
    there_and_back = table("shrinks.h5",
                           lambda s, t: 2 + 3 * (ramp(t, 0, 4) - ramp(t, 4, 8)), times)
    r = grown(there_and_back)
    expect(abs(r["length"][-1] - 2) < 1e-9, f"length {r['length'][-1]}")
    expect(r["energy_defect"][r["t"] > 0.1].max() < 1e-3,
           f"defect {r['energy_defect'][r['t'] > 0.1].max():g}")
    r = grown(there_and_back .replace("-shape_amplitude 0.1", "-shape_type straight"))
    expect(abs(r["tip_x1"][-1] - 2) < 1e-9 and (r["norm_x2"] == 0).all(), "straight no more")
    # (before growth has set in, the defect is that of a work of 1e-7)
    expect(r["energy_defect"][r["t"] > 0.5].max() < 1e-3,
           f"straight: defect {r['energy_defect'][r['t'] > 0.5].max():g}")


@check
def a_rate_of_growth_may_jump():
    """From rate 0.2 to 4 within a hundredth of a unit of time."""
    times = np.concatenate((np.linspace(0, 2, 21), np.linspace(2.01, 3, 100)))
    for model in ("frame", "mixed"):
        r = grown(table("jumps.h5", lambda s, t: 2 + 0.2 * t + 2 * ramp(t, 2, 2.5), times)
                  + f"-rod_model {model}")
        expect(abs(r["length"][-1] - 4.6) < 1e-6, f"length {r['length'][-1]}")


@check
def a_noisy_table_gives_the_smooth_rod_within_its_noise():
    """Half a part in a hundred of noise along the rod and in time: the tip stays within that of the
    smooth rod's."""
    noise = np.random.default_rng(1)
    times = np.linspace(0, 5, 26)
    smooth = grown(table("smooth.h5", lambda s, t: 2 + t, times))
    rough = grown(table("rough.h5",
                        lambda s, t: (2 + t) * (1 + 0.005 * noise.uniform(-1, 1, len(s))), times))
    off = np.hypot(*(rough[k][-1] - smooth[k][-1] for k in ("tip_x1", "tip_x2"))) / 7
    expect(off < 0.05, f"the tip is off by {off:g} of the length")


@check
def impossible_tables_are_refused_in_one_line():
    times = np.linspace(0, 1, 11)
    refused(table("negative.h5", lambda s, t: 1 - 2 * t, times), "-growth_table")
    refused(table("zero.h5", lambda s, t: 0 * s, times), "-growth_table")
    refused(table("nan.h5", lambda s, t: np.nan * s, times), "-growth_table")
    refused(table("ends.h5", lambda s, t: 1 + t, times).replace("-ts_max_time 1", "-ts_max_time 2"),
            "-ts_max_time")


@check
def a_rod_may_begin_shorter_than_a_grown_cell():
    """It starts at a thousandth or less, of which a grown cell is ten times as long: straight at once, and
    stable until it has grown. Its x2 falls below the smallest number there is. (Round-off of x1 makes velocities along
    it that turn dry friction, in the time in which so short a rod comes to rest: steps crept at 1e-16 and got nowhere.)"""
    for law in ("uniform", "gaussian", "feed"):
        for length in (3e-4, 1e-3, 1e-2):
            r = grown(f"-growth_type {law} -growth_initial_length {length} -rod_cells 100 "
                      "-shape_amplitude 0.1 -ts_max_time 5 -output_interval 1")
            t, tip = r["shapes/t"][1:], r["shapes/x"][1:, -1]
            expect(np.allclose(tip[:, 0], t + length, rtol=1e-9, atol=0), f"{law}: tips {tip[:, 0]}")
            expect(len(t) == 5 and (np.abs(tip[:, 1]) < 1e-8).all(), f"{law}: x2 {tip[:, 1]}")
            expect(r["norm_x2"][-1] < 1e-8, f"{law}: |x2| = {r['norm_x2'][-1]:g}")


@check
def crossings_of_an_initial_loop_are_counted():
    """A full loop crosses itself: the run goes on and the crossings are counted. A spiral of more
    than a full turn does not cross (its curvature falls steadily), and runs as well."""
    s = np.linspace(0, 1, 101)
    with h5py.File(f"{scene.SCRATCH}/loop.h5", "w") as f:
        f["s"], f["theta"] = s, 7.5 * s * s * (3 - 2 * s)
    for shape, crosses in ((f"-shape_type file -shape_file {scene.SCRATCH}/loop.h5", True),
                           ("-shape_amplitude 6.5", False), ("-shape_amplitude -6.5", False)):
        r = grown(f"-growth_initial_length 6 {shape} -ts_max_time 2 -rod_cells 200")
        expect(abs(r["length"][-1] - 8) < 1e-9, f"{shape}: length {r['length'][-1]}")
        expect((r["self_crossings"][0] > 0) == crosses,
               f"{shape}: {r['self_crossings'][0]:g} crossings at first")


@check
def a_clamp_turned_by_pi_gives_the_same_rod_turned():
    """The whole rod turned round: the same numbers with the other sign."""
    ahead = grown(BENT + "-ts_max_time 3")
    for angle, sign in (("3.141592653589793", -1), ("6.283185307179586", 1),
                        ("-3.141592653589793", -1)):
        back = grown(BENT + f"-ts_max_time 3 -clamp_angle {angle}")
        for k in ("tip_x1", "tip_x2"):
            expect(abs(back[k][-1] - sign * ahead[k][-1]) < 1e-9, f"{angle}: {k} {back[k][-1]}")
        expect(abs(back["energy"][-1] / ahead["energy"][-1] - 1) < 1e-9, f"{angle}: energy")


if __name__ == "__main__":
    sys.exit(scene.main())

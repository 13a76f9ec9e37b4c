#!/usr/bin/env python3
"""-task critical and stability of a straight rod whose material learns: against eigenvalues by another program, and against runs.

    learned_modes_test.py build/tendril [CHECK...]      (no CHECK: all of them)"""

import re
import sys
from math import sqrt
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "support"))
import scene  # takes .venv's python if this one lacks numpy and h5py
from references import stiffness
from scene import Run, check, expect, tendril

import h5py
import numpy as np

ALONG = "-tropism_direction 1,0 "
VISCOUS = "-friction_mu 0 "
STILL = VISCOUS + "-growth_type none -growth_initial_length 1 -tropism_rate 1 -tip_law dead "
PRESSED = STILL + ALONG + "-tropism_gravity 2 -tropism_proprioception 1 -tropism_sensed tip "


def rate(options, vertices=100):
    """lambda(A) and its frequency, of the first time."""
    file = f"{scene.SCRATCH}/modes.h5"
    tendril(f"-task stability -stability_end 1e-6 -stability_points 1 -stability_vertices {vertices} -output {file} {options}")
    with h5py.File(file) as f:
        return f["stability/lambda_max_A"][0], f["stability/frequency_A"][0]


@check
def critical_lengths_are_those_of_another_program():
    """By shooting and by panels of polynomials, which agree to ten digits; local and at the tip, with memory, ironing and weight."""
    for options, length, frequency in (
            (VISCOUS + ALONG + "-tropism_gravity 10 -tropism_proprioception 1", 1.8095000078, 2.253237763),
            (VISCOUS + ALONG + "-tropism_gravity 3 -tropism_proprioception 0.5 -tropism_memory 1 -tropism_sensed tip", 1.7497779049,
             1.440247042),
            (ALONG + "-tropism_gravity 1 -tropism_proprioception 1 -tropism_sensed tip", 2.148058511, 0.622910503),
            ("-tropism_proprioception 1 -growth_ironing 4", 1.251815804, 0),
            (VISCOUS + ALONG + "-rod_weight -1,0 -tropism_gravity 2 -tropism_proprioception 1", 1.6276499439, 1.509820659)):
        said = tendril("-task critical -rod_cells 100 " + options)
        got = float(re.search(r"critical length L = (\S+)", said)[1])
        at = re.search(r"frequency (\S+) per", said)
        expect(abs(got / length - 1) < 1e-8, f"{options}: {got!r}, not {length}")
        expect(abs((float(at[1]) if at else 0) - frequency) < 1e-5, f"{options}: frequency {at and at[1]}, not {frequency}")


@check
def rates_of_rods_that_do_not_grow_are_those_of_another_program():
    for options, exact in (("-tip_force 1 -growth_ironing 1", 0.570482960562),
                           ("-tip_force 3 -tropism_gravity 2 -tropism_proprioception 1 -tropism_sensed tip " + ALONG,
                            1.06585580348 + 5.75933143228j),
                           ("-tip_force 2 -tropism_gravity 5 -tropism_proprioception 1 -tropism_memory 0.5 " + ALONG,
                            -0.142072855312 + 4.18892299861j)):
        found = complex(*rate(STILL + options))
        expect(abs(found - exact) < 1e-8, f"{options}: {found}, not {exact}")


@check
def a_run_swings_and_grows_as_its_rate_says_on_both_sides_of_the_threshold():
    """The tip's deflection is c1 e^(lambda t) + its conjugate; 2.614321964 is where the real part is 0."""
    for force, sign in ((2.55, -1), (2.68, 1)):
        found = complex(*rate(f"{PRESSED} -tip_force {force}"))
        expect(found.real * sign > 0.1, f"{force}: {found}")
        r = Run(f"{PRESSED} -tip_force {force} -shape_type sag -shape_amplitude 1e-6 -ts_max_time 4 -ts_rtol 1e-6 -rod_cells 40")
        t, y = r.t[r.t > 2], r.tip_x2[r.t > 2] / np.exp(found.real * r.t[r.t > 2])
        wave = np.column_stack([np.cos(found.imag * t), np.sin(found.imag * t)])
        left = y - wave @ np.linalg.lstsq(wave, y, rcond=None)[0]
        expect(np.abs(left).max() < 3e-3 * np.abs(y).max(), f"{force}: {found}, left {np.abs(left).max() / np.abs(y).max():g}")
    expect(abs(rate(f"{PRESSED} -tip_force 2.614321964")[0]) < 1e-8, "the threshold")


@check
def a_stiff_root_swings_for_ever_from_a_memory_on():
    """lambda (lambda + G) (1 + T lambda) + B' (lambda + 1) = 0 of an even zone; of a bell by the differential equation along it."""
    b, G = 4., 0.25
    even = (b + G) / (b - G * (b + G))
    for profile, memory, frequency, off in (("even", even, sqrt((G + b) / even), 1e-5), ("bell", 1.1187418, 2.0797632, 2e-5)):
        root = (f"{stiffness(lambda d: np.full_like(d, 1e9))} -growth_type apical -growth_zone 1 -growth_profile {profile} "
                f"-growth_initial_length 2 {ALONG} -tropism_gravity {b} -tropism_proprioception {G} -tropism_sensed tip -tropism_memory ")
        above, found = rate(root + str(memory + off))
        below = rate(root + str(memory - off))[0]
        expect(above > 0 > below, f"{profile}: {below} below, {above} above")
        expect(abs(found - frequency) < 1e-4, f"{profile}: frequency {found}, not {frequency}")


@check
def growth_that_feels_force_buckles_later_or_stalls():
    """Viscous by series at 20 digits. Dry, where thrust is min(L - p, 1), by Airy's functions for beta to 0, from which beta is off by sqrt(beta), a
    boundary layer. Fed, it ends at the length of its thrust."""
    for options, length, allowed in (("-friction_mu 0 -growth_yield 1", 2.7466089760, 1e-8), ("-growth_yield 1.5 -friction_beta 1e-12", 1.9908584435, 1e-6)):
        said = tendril(f"-task critical -rod_cells 100 -ts_max_time 20 {options}")
        got = float(re.search(r"critical length L = (\S+)", said)[1])
        expect(abs(got / length - 1) < allowed, f"{options}: {got!r}, not {length}")
    said = tendril("-task critical -growth_type feed -growth_yield 0.7 -friction_beta 0 -ts_max_time 20 -rod_cells 100", 1)
    expect("of length 0.7" in said, said)


@check
def what_bends_the_straight_rod_is_refused():
    for task in ("critical", "stability"):
        for options, word in (("-tropism_gravity 1 -tropism_direction 0,1", "-tropism_direction"), ("-tropism_nutation 1", "-tropism_nutation"),
                              ("-tropism_light 1 -tropism_source 5,1", "-tropism_source"),
                              ("-tropism_light 1 -tropism_source 0.7,0", "-tropism_source"),
                              ("-growth_ironing 1 -tip_type clamped -tip_torque 1", "twist"),
                              ("-growth_yield 1 -tip_force 2", "-growth_yield")):
            expect(word in tendril(f"-task {task} {options}", 1), f"{task} {options}")
    expect("creep" in tendril("-task critical -growth_ironing 2", 1), "ironing")


if __name__ == "__main__":
    sys.exit(scene.main())

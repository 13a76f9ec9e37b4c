#!/usr/bin/env python3
"""The rod in the laboratory: natural curvature, events, restart, physical units, files for ParaView.

    laboratory_test.py build/tendril [--mpiexec mpiexec] CHECK...      (no CHECK: all of them)"""

import gzip
import re
import shlex
import signal
import subprocess
import sys
from pathlib import Path
from xml.etree import ElementTree

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "support"))
import scene  # takes .venv's python if this one lacks numpy and h5py
from held import PAGE, Held
from scene import DRY, Run, check, distance, expect, read, tendril

import h5py
import numpy as np


CURVED = "-rod_curvature 0.02 -rod_curvature_random 0.1 -shape_type straight "


@check
def a_naturally_curved_rod_balances_its_energy():
    """Energy is balanced, two models agree, and mirrored curvature gives the mirrored rod."""
    for law, length, end in (("uniform", 0.5, 20), ("gaussian", 0.5, 10), ("feed", 1, 8)):
        options = (f"-growth_type {law} -growth_initial_length {length} -ts_max_time {end} " + CURVED)
        a = Run(options)
        b = Run(options + "-rod_model mixed -rod_cells 2000")
        defect = a.energy_defect[a.t > 0.01].max()
        print(f"{law}: defect {defect:.1e}, frame and mixed differ by {distance(b.tip, a.tip):.1e}, "
              f"tip {a.tip}")
        expect(defect < 1e-5, f"{law}: energy defect {defect:.1e}")
        expect(distance(b.tip, a.tip) < 1e-4, f"{law}: models differ by {distance(b.tip, a.tip):.1e}")
        expect(a.max_angle[-1] > 1, f"{law}: does not bend")
    up, down = (Run(f"-ts_max_time 5 -shape_type straight -rod_curvature {k}") for k in (0.1, -0.1))
    expect(np.allclose(up.tip_x2, -down.tip_x2, rtol=1e-12, atol=0), "not mirrored")
    # a rod that nothing pushes keeps its natural curvature: at t = 0 it stores no energy
    expect(up.energy[0] < 1e-12, f"energy {up.energy[0]} at t = 0")
    expect(np.allclose(up.shapes["curvature"][0], 0.1, rtol=1e-9), "curvature at t = 0")


FED = "-growth_type feed -growth_initial_length 2 -shape_amplitude 0.1 -ts_max_time 20 "


@check
def events_are_located_to_the_tolerance():
    """Located to the tolerance: against a run with a hundredth of it, and against what is known."""
    out = f"-output {scene.SCRATCH}/e.h5 "
    for stop, kind in (("-stop_self_contact 0", "self_contact"), ("-stop_angle 2", "angle"),
                       ("-stop_self_contact 0.2", "self_contact"), ("-stop_length 7.77", "length")):
        found = []
        for rtol in (1e-6, 1e-8):
            text = tendril(f"{FED} {out} {stop} -ts_rtol {rtol} -output_interval 1")
            r = read(f"{scene.SCRATCH}/e.h5")
            word = {"self_contact": "touches itself at s", "angle": "an angle of 2 at s",
                    "length": "length 7.77"}[kind]
            expect(f": {word}" in text and r["kind"] == kind, f"{stop}: {text}")
            expect(r["finished"] == 1, f"{stop}: not finished")
            expect(r["event/t"] == r["series/t"][-1] == r["shapes/t"][-1], f"{stop}: times differ")
            expect((np.diff(r["series/t"]) > 0).all(), f"{stop}: times do not increase")
            found.append(float(r["event/t"]))
        off = abs(found[0] / found[1] - 1)
        print(f"{stop}: t = {found[1]:.9g}, s = {r['event/s']}, differs by {off:.1e}")
        expect(off < 1e-5, f"{stop}: t = {found[0]} and {found[1]}")
        if kind == "length":
            expect(abs(found[0] - 5.77) < 1e-12, f"length 7.77 at t = {found[0]}")
        if kind == "angle":
            expect(abs(np.abs(r["shapes/theta"][-1]).max() - 2) < 1e-9, "angle")
        if stop.endswith(" 0"):  # both labels are at one place
            x, s = r["shapes/x"][-1], r["shapes/s"]
            both = np.array([[np.interp(p, s, x[:, d]) for d in (0, 1)] for p in r["event/s"]])
            expect(np.abs(both - r["event/x"]).max() < 1e-6, f"crossing at {both}")
        # the speeds at the event belong to the run
        whole = scene.Run(f"{FED} -ts_rtol 1e-8 -ts_max_time {found[1]!r}")
        for name in ("tip_speed", "dissipation", "energy", "tip_x2"):
            expect(abs(r[f"series/{name}"][-1] / whole.series[name][-1] - 1) < 1e-4, f"{stop}: {name}")
    # of a rod in space its place is that in the laboratory, whichever way the clamp points
    tendril(f"{FED} {out} -rod_model space -clamp_direction 0.1,0.2,1 -stop_length 2.5")
    r = read(f"{scene.SCRATCH}/e.h5")
    tip = np.array([r["series/tip_x1"][-1], r["series/tip_x2"][-1]])
    expect(np.abs(r["event/x"] - tip).max() < 1e-12, f"event at {r['event/x']}, the tip at {tip}")
    expect("-stop_angle" in tendril(f"{FED} -stop_angle 0.01", 1), "already so")
    expect("-stop_length" in tendril(f"{FED} -stop_length 1", 1), "too short")


def same_run(a, b, what, bound):
    expect(len(a["shapes/t"]) == len(b["shapes/t"]) and np.allclose(a["shapes/t"], b["shapes/t"]),
           f"{what}: shapes at {a['shapes/t']} and {b['shapes/t']}")
    expect((np.diff(a["series/t"]) > 0).all(), f"{what}: times do not increase")
    expect(abs(a["series/step"].sum() - a["series/t"][-1]) < 1e-9, f"{what}: a step is missing")
    expect(len({len(v) for k, v in a.items() if k.startswith("series/")}) == 1, f"{what}: lengths")
    off = distance(a["shapes/x"][-1][-1], b["shapes/x"][-1][-1])
    print(f"{what}: {len(a['series/t'])} and {len(b['series/t'])} steps, tips differ by {off:.1e}, "
          f"defect {a['series/energy_defect'][-1]:.1e}")
    expect(off < bound, f"{what}: tips differ by {off:.1e}")
    expect(a["series/energy_defect"][-1] < 1e-5, f"{what}: energy defect")


def told_of(file):
    """The estimate of a stored run."""
    with h5py.File(file) as f:
        return float(f.attrs["error_estimate"])


def remembered(file):
    """What a run that goes on remembers: numbers by name."""
    with h5py.File(file) as f:
        rows = [row.split() for row in f["restart/names"].asstr()[()].splitlines()]
        ends = np.cumsum([int(count) for _, count in rows])
        return dict(zip([name for name, _ in rows], np.split(f["restart/state"][()], ends[:-1])))


@check
def a_broken_run_goes_on_as_the_whole():
    """A run that was broken and goes on is the unbroken one; so is one that goes on past its end."""
    d = scene.SCRATCH
    for law, more in (("uniform", ""), ("gaussian", "-rod_model auto -shape_amplitude 1e-4"),
                      ("feed", "-rod_curvature_random 0.05 -rod_curvature_length 0.2")):
        options = f"{DRY} -growth_type {law} {more} -ts_max_time 12 -output_interval 0.5 "
        tendril(f"{options} -output {d}/whole.h5")
        whole = read(f"{d}/whole.h5")
        tendril(f"{options} -output {d}/a.h5 -ts_max_steps 60", 1)
        broken = Path(f"{d}/a.h5").read_bytes()
        tendril(f"-restart {d}/a.h5 -output {d}/b.h5")
        expect(Path(f"{d}/a.h5").read_bytes() == broken, "-restart changed a file it should read")
        tendril(f"-restart {d}/a.h5 -output {d}/a.h5 -ts_max_steps 60", 1)  # not a step further
        tendril(f"-restart {d}/a.h5 -output {d}/a.h5")
        a, b = read(f"{d}/a.h5"), read(f"{d}/b.h5")
        same_run(a, whole, f"{law}, broken at step 60", 1e-12)
        for k in whole:  # to the last bit
            expect(np.array_equal(a[k], whole[k]) or k == "finished", f"{law}: {k} differs")
        expect(all(np.array_equal(a[k], b[k]) for k in a), "a new file and the same differ")
        told = [told_of(f"{d}/{name}.h5") for name in ("a", "whole")]
        print(f"{law}: estimates {told[0]:.2e}, of the whole run {told[1]:.2e}")
        expect(abs(told[0] / told[1] - 1) < 0.05, f"{law}: told {told[0]}, of the whole run {told[1]}")
        expect("-restart" in tendril(f"-restart {d}/a.h5", 1), "goes on past its end")
        longer = tendril(f"-restart {d}/a.h5 -ts_max_time 13 -growth_initial_length 3", 1)
        expect("-growth_initial_length" in longer and longer.count("\n") <= 1, f"goes on as another rod: {longer}")
    # a start that snaps: what is told behind a restart is what is told of the unbroken run
    start = "-growth_initial_length 0.113 -ts_max_time 0.00122 -tip_force 1110 -shape_amplitude 1"
    tendril(f"{start} -ts_max_steps 10 -output {d}/a.h5", 1)
    tendril(f"-restart {d}/a.h5 -output {d}/b.h5")
    tendril(f"{start} -output {d}/whole.h5")
    told = [told_of(f"{d}/{name}.h5") for name in ("whole", "b")]
    expect(told[0] > 1e-6 and abs(told[1] / told[0] - 1) < 0.1, f"a snap at the start: told {told[0]}, behind a restart {told[1]}")
    tendril(f"{DRY} -ts_max_time 7.3 -output_interval 0.5 -output {d}/a.h5")
    tendril(f"-restart {d}/a.h5 -ts_max_time 12")
    tendril(f"{DRY} -ts_max_time 12 -output_interval 0.5 -output {d}/whole.h5")
    further, whole = (told_of(f"{d}/{name}.h5") for name in ("a", "whole"))
    expect(abs(further / whole - 1) < 0.1, f"past its end the estimate is {further}, of the whole run {whole}")
    same_run(read(f"{d}/a.h5"), read(f"{d}/whole.h5"), "past its end", 1e-5)
    tendril(f"{FED} -stop_angle 1 -output_interval 0.5 -output {d}/a.h5")
    tendril(f"-restart {d}/a.h5")
    tendril(f"{FED} -output_interval 0.5 -output {d}/whole.h5")
    same_run(read(f"{d}/a.h5"), read(f"{d}/whole.h5"), "past an event", 1e-4)
    # made by version 0.2, whose numbers to go on from had no names (gzip): -growth_type uniform -ts_max_time 3 -rod_cells 16
    # -clamp_angle 0.3 -rod_curvature 0.2 -output_shapes 2
    Path(f"{d}/old.h5").write_bytes(gzip.decompress((Path(__file__).parent / "before_names.h5.gz").read_bytes()))
    tendril(f"-restart {d}/old.h5 -ts_max_time 4 -output {d}/a.h5")
    tendril(f"-growth_type uniform -ts_max_time 3 -rod_cells 16 -clamp_angle 0.3 -rod_curvature 0.2 -output_shapes 2 -output {d}/b.h5")
    tendril(f"-restart {d}/old.h5 -ts_max_time 4 -output {d}/c.h5 -ts_max_steps {len(read(f'{d}/b.h5')['series/t']) - 1}", 1)  # not a step
    was, now = remembered(f"{d}/c.h5"), remembered(f"{d}/b.h5")
    off = [name for name in now if not np.allclose(was[name], now[name], rtol=1e-2, atol=1e-12)]
    expect(set(off) <= {"astray", "seen.tip_angle", "seen.growth_rate"}, f"of a file without names, {off} are others")  # (these are newer)
    tendril(f"-restart {d}/b.h5 -ts_max_time 4")
    same_run(read(f"{d}/a.h5"), read(f"{d}/b.h5"), "of a file without names", 1e-9)
    expect(abs(told_of(f"{d}/a.h5") / told_of(f"{d}/b.h5") - 1) < 1e-9, "errors of a file without names")
    for options in (f"-restart {d}/none.h5", f"-restart {scene.TENDRIL}", "-restart",
                    f"-restart {d}/whole.h5 -ts_max_time 30 -rod_cells 20",
                    f"-restart {d}/whole.h5 -ts_max_time 30 -rod_model mixed",
                    f"-restart {d}/whole.h5 -ts_max_time 30 -task critical"):
        tendril(options, 1)


@check
def a_run_goes_on_to_the_last_bit_wherever_it_was_broken():
    """A run goes on to the last bit wherever it was broken: in its first steps, which are no time at which shapes are due, one
    step before its end, in the linear model, while a wall kicks a straight rod; and tells the same errors."""
    d = scene.SCRATCH
    Path(f"{d}/wall.txt").write_text("plane 0.8 0 -1 -0.5 friction 0.3\n")
    fed = "-growth_type feed -friction_mu 0 -shape_type straight -rod_curvature 0.357 -rod_cells 40 -ts_max_time 3.25 -ts_rtol 1e-5"
    for options, breaks in (("-rod_model linear -growth_initial_length 1 -shape_amplitude 1e-7 -rod_cells 30 -ts_max_time 1.5 -ts_dt 1e-12", (5, 60, -1)),
                            (fed, (4,)),
                            (f"-shape_type straight -rod_curvature 1e-9 -wall_file {d}/wall.txt -contact_diameter 0.05 -ts_max_time 0.4 "
                             "-rod_cells 30", (48, 50))):
        tendril(f"{options} -output {d}/whole.h5")
        whole = read(f"{d}/whole.h5")
        for k in breaks:
            tendril(f"{options} -output {d}/a.h5 -ts_max_steps {k % (len(whole['series/t']) - 1)}", 1)
            tendril(f"-restart {d}/a.h5")
            a, told = read(f"{d}/a.h5"), [told_of(f"{d}/{name}.h5") for name in ("a", "whole")]
            different = [name for name in whole if name != "finished" and not np.array_equal(a[name], whole[name])]
            print(f"{len(whole['series/t'])} steps, broken at {k}: {len(different)} differ, told {told[0]:.2e} and {told[1]:.2e}")
            expect(not different, f"{options}, broken at {k}: {different} differ")
            expect(abs(told[0] / told[1] - 1) < 0.3, f"{options}, broken at {k}: told {told[0]}, of the whole run {told[1]}")
    # one that gave up goes on with what would have helped
    said = tendril(f"-rod_cells 20 -ts_max_time 20 -ts_dt 1e-6 -ts_max_reject 0 -output {d}/a.h5", 1)
    expect("gave up at t = 1e-06" in said, said)
    said = tendril(f"-restart {d}/a.h5 -ts_max_reject 50 -ts_max_steps 6", 1)
    expect("-ts_max_steps: reached" in said, said)
    # times that are added up drift past the end, where the last shape is one of them all the same
    tendril(f"-rod_cells 20 -ts_max_time 5 -output_interval 0.0025 -output {d}/a.h5")
    tendril(f"-restart {d}/a.h5 -ts_max_time 5.02")
    gaps = np.diff(read(f"{d}/a.h5")["shapes/t"])
    expect(abs(gaps / 0.0025 - 1).max() < 1e-6, f"shapes {gaps.max():g} apart")


@check
def a_run_stopped_by_a_signal_goes_on_as_the_whole():
    """Stopped between two stores, or killed behind one: it goes on to the end of the unbroken run."""
    d = scene.SCRATCH
    options = f"{DRY} -ts_max_time 12 -output_interval 0.05 -rod_cells 1000 "
    tendril(f"{options} -output {d}/whole.h5")
    whole = read(f"{d}/whole.h5")
    for number in (signal.SIGTERM, signal.SIGKILL):
        file = Path(f"{d}/{number.name}.h5")

        def stored():
            return len(read(file)["shapes/t"]) if file.exists() else 0

        with Held([scene.TENDRIL, *shlex.split(options), "-output", file],
                  env=scene.ENVIRONMENT) as run:
            run.let(18 * PAGE)  # its first steps are small, and store nothing
            expect(run.until(lambda: stored() > 1), "ended before it was stored")
            before = stored()
            run.send_signal(number)
            code, said = run.end()
        expect(code != 0, "exit 0 after a signal")
        if number == signal.SIGTERM:
            expect(said.startswith("tendril: interrupted by signal 15 at t = ") and
                   said.count("\n") == 1, said)
        expect(before <= stored() < len(whole["shapes/t"]), f"{stored()} shapes are stored")
        tendril(f"-restart {file}")
        same_run(read(file), whole, number.name, 1e-6)


@check
def what_was_asked_for_and_did_not_happen_is_said_at_the_end():
    """What was asked for and did not happen, what is stored and what is not, where x2 is measured."""
    d, short = scene.SCRATCH, f"{DRY} -rod_cells 40 -ts_max_time 0.1 "
    text = tendril(f"{short} -stop_length 300 -stop_angle 2")
    for words in ("not reached by t = 0.1: -stop_length 300\n", "not reached by t = 0.1: -stop_angle 2\n",
                  "nothing is stored; -output FILE keeps the result\n"):
        expect(words in text, text)
    text = tendril(f"{short} -stop_length 2.05 -output {d}/a.h5")
    expect("not reached" not in text and "nothing is stored" not in text and "clamp" not in text, text)
    expect("-output_interval: no shapes are stored without -output" in tendril(f"{short} -output_interval 0.01", 1),
           "-output_interval")
    text = tendril(f"{short} -clamp_angle -90deg -output {d}/down.h5")
    off = float(re.search(r"line of the clamp, at -1.571 rad, the tip is (\S+) off", text).group(1))
    expect(abs(off / read(f"{d}/a.h5")["series/tip_x2"][-1] - 1) < 0.1, text)
    for output, words in (("", "nothing is stored without -output FILE"),
                          (f"-output {d}/b.h5", "the results up to there are stored")):
        with Held([scene.TENDRIL, *shlex.split(f"{short} {output}")], env=scene.ENVIRONMENT) as run:
            run.let(5 * PAGE)
            run.send_signal(signal.SIGINT)
            said = run.end()[1]
        expect(f"; {words}\n" in said, said)
    with h5py.File(f"{d}/b.h5") as f:
        expect(f.attrs["interrupted"].decode().startswith("by signal 2 at t = "), f.attrs["interrupted"])
    tendril(f"-restart {d}/b.h5")
    with h5py.File(f"{d}/b.h5") as f:
        expect(f.attrs["interrupted"] in (b"", ""), f"{f.attrs['interrupted']}")
    # units as they are written: with blanks between their parts
    for said in ("'2.209 N mm^2' -si_friction_dry '0.5 N / m'", "2.209Nmm^2 -si_friction_dry 0.5N/m"):
        expect("0.01640874 m" in tendril(f"-task units -si_speed 1 -si_bending_stiffness {said}"), said)


TUBE = "-si_bending_stiffness 4.4907e-4 -si_friction_dry 20.03 "


@check
def units_of_the_laboratory_go_there_and_back():
    """There and back; a rod of twice the size in metres is the same in numbers."""
    d = scene.SCRATCH
    table = {line.split()[0]: line.split()[1:] for line in
             tendril(f"-task units {TUBE} -si_speed 0.01").splitlines()[1:]}
    expect(abs(float(table["length"][2]) / 35.46 - 1) < 2e-4, f"length {table['length']}")
    for name in ("length", "force", "time", "speed", "energy", "power", "curvature"):
        to, _, back = table[name]
        expect(abs(float(to) * float(back) - 1) < 1e-6, f"{name}: {to} and {back}")
    runs = []
    for k in (1, 2):  # lengths k, friction per length the same: YI k^3, speed k
        physical = f"-si_bending_stiffness {3e-4 * k**3} -si_friction_dry 15 " \
                   f"-si_friction_viscous {50 / k} -si_speed {0.1 * k}"
        tendril(f"{DRY} -ts_max_time 3 {physical} -output {d}/si.h5")
        with h5py.File(f"{d}/si.h5") as f:
            runs.append((read(f"{d}/si.h5"), {n: f.attrs[f"si_{n}"] for n in
                                              ("length", "force", "time", "energy", "power")}))
    (a, sa), (b, sb) = runs
    expect(np.array_equal(a["shapes/x"], b["shapes/x"]), "numbers differ")
    for name, factor in (("length", 2), ("force", 2), ("time", 1), ("energy", 4), ("power", 4)):
        expect(abs(sb[name] / sa[name] / factor - 1) < 1e-12, f"scale of {name}")
    expect(abs(sa["power"] * sa["time"] / sa["energy"] - 1) < 1e-12, "power x time = energy")
    bare = Run(f"{DRY} -ts_max_time 3 -friction_mu 0.75")
    expect(distance(a["shapes/x"][-1][-1], bare.tip) < 1e-12, "mu = 15/(15 + 50 x 0.1)")
    for wrong, word in (("-si_friction_dry 20", "-si_bending_stiffness"), (TUBE + "-friction_mu 0.5",
                        "-friction_mu"), (TUBE + "-si_friction_viscous 3", "-si_speed"),
                        ("-si_bending_stiffness 1", "-si_friction_dry"), ("-task units", "units")):
        expect(word in tendril(f"{wrong} -ts_max_time 0.1", 1), wrong)


LAB = dict(stiffness=2.209e-6, dry=0.5, speed=5e-3)  # SI: the tube of docs/guide.md
LENGTH = (LAB["stiffness"] / LAB["dry"]) ** (1 / 3)
FORCE, TIME = LAB["dry"] * LENGTH, LENGTH / LAB["speed"]
SI = "-si_bending_stiffness {stiffness} -si_friction_dry {dry} -si_speed {speed} ".format(**LAB)
# (option, its value with a unit, and as a number of tendril's)
QUANTITIES = [
    ("-growth_initial_length", "1cm", 0.01 / LENGTH), ("-growth_zone", "5mm", 5e-3 / LENGTH),
    ("-ts_max_time", "0.2min", 12 / TIME), ("-output_interval", "2s", 2 / TIME),
    ("-ts_dt", "0.2ms", 2e-4 / TIME), ("-ts_adapt_dt_max", "0.3s", 0.3 / TIME),
    ("-tip_force", "500uN", 5e-4 / FORCE), ("-friction_layer_width", "2000um", 2e-3 / LENGTH),
    ("-rod_curvature", "2/m", 2 * LENGTH), ("-stop_length", "0.0605m", 0.0605 / LENGTH)]
LAYERS = [(0, 1), (0.03, 2.5)]


def spoken(units, leave=()):
    """The same scene, with units or in tendril's numbers."""
    words = [f"{name} {text if units else repr(number)}" for name, text, number in QUANTITIES
             if name not in leave]
    layers = ",".join(f"{x * 100}cm:{f}" if units else f"{x / LENGTH!r}:{f}" for x, f in LAYERS)
    return f"{SI} -growth_type apical -shape_type straight -friction_layers {layers} -rod_cells 60 " \
           + " ".join(words)


@check
def a_scene_with_units_is_the_scene_of_numbers():
    """With units it is the same run as with numbers; also when it is broken and goes on; the file
    keeps what was said."""
    d = scene.SCRATCH
    for name, units in (("units", True), ("numbers", False)):
        tendril(f"{spoken(units)} -output {d}/{name}.h5")
    a, b = read(f"{d}/units.h5"), read(f"{d}/numbers.h5")
    for key in b:
        if key.startswith(("series/", "shapes/")):
            expect(a[key].shape == b[key].shape, f"{key}: {a[key].shape}, {b[key].shape}")
    # (steps end where round-off has them; stored times do not move with it)
    for key, off in (("shapes/x", 1e-9), ("shapes/t", 1e-9), ("series/tip_x2", 1e-6), ("series/base_force_1", 1e-6)):
        expect(np.allclose(a[key], b[key], rtol=off, atol=off), f"{key} differs")
    expect(a["kind"] == "length" and abs(a["series/length"][-1] * LENGTH - 0.0605) < 1e-9, "length")
    with h5py.File(f"{d}/units.h5") as f:
        said = f.attrs["options"].decode().splitlines()
        for name, text, number in QUANTITIES:
            expect(f"{name} {text}" in said, f"{name} {text} is not kept: {said}")
            expect(abs(f.attrs[f"parameters/{name[1:]}"] / number - 1) < 1e-12, f"{name} in force")
    tendril(f"{spoken(True, ['-ts_dt'])} -output {d}/whole.h5")
    tendril(f"{spoken(True, ['-ts_dt'])} -output {d}/broken.h5 -ts_max_steps 20", 1)
    tendril(f"-restart {d}/broken.h5 -ts_max_time 12s")  # as it was, said otherwise
    one, two = read(f"{d}/whole.h5"), read(f"{d}/broken.h5")
    for key in one:
        expect(np.array_equal(one[key], two[key]) or key == "finished", f"restart: {key} differs")


@check
def inches_feet_mils_and_french_are_what_they_are_in_mm():
    """Inches, feet, mils and French are what they are in mm: in options, wall files, tables and HDF5; a blank before one is seen."""
    d = Path(scene.SCRATCH)
    said = {"mm": ("304.8mm", "2mm", "0.254mm", "25.4mm", "914.4mm", "0.0001/mm", "0.508mm/s"),
            "in": ("1ft", "6Fr", "10mil", "1in", "3ft", "0.00254/in", "1.2in/min")}
    runs = {}
    for name, (length, diameter, thin, wide, end, bend, speed) in said.items():
        (d / f"{name}.csv").write_text(f"x1,x2,x3,radius\n0,0,0,{wide}\n{end},0,0,{wide}\n")
        (d / f"{name}.txt").write_text(f"tube {name}.csv inside\nsphere 0 {end} 0 {wide} outside\n")
        with h5py.File(d / f"{name}-curvature.h5", "w") as f:
            scale = {"mm": 1.0, "in": 1 / 25.4}[name]
            f["distance"], f["curvature"] = np.linspace(0, 900, 4) * scale, 1e-4 * np.arange(4) / scale
            f["distance"].attrs["units"], f["curvature"].attrs["units"] = name, f"1/{name}"
        tendril(f"-si_bending_stiffness 1e-6 -si_friction_dry 0.1 -si_speed {speed} -growth_type feed -rod_cells 20 "
                f"-growth_initial_length {length} -contact_diameter {diameter} -rod_curvature_file {d}/{name}-curvature.h5 "
                f"-friction_layer_width {thin} -friction_layers 0mm:1,{end}:2 -rod_curvature_2 {bend} -wall_file {d}/{name}.txt "
                f"-stop_length {end} -ts_max_time 1ms -output {d}/{name}.h5")
        with h5py.File(d / f"{name}.h5") as f:
            runs[name] = {key: f.attrs[key] for key in f.attrs if key.startswith("parameters/")} | {"walls": f["walls"][()].decode()}
    a, b = runs["mm"], runs["in"]
    expect(a.keys() == b.keys(), "parameters")
    for key in a:
        if isinstance(a[key], float):
            expect(abs(a[key] - b[key]) <= 1e-9 * abs(a[key]), f"{key}: {a[key]}, {b[key]}")
    numbers = [[float(word) for word in re.findall(r"-?[0-9][0-9.e+-]*", str(of["walls"]))] for of in (a, b)]
    expect(len(numbers[0]) > 5 and np.allclose(*numbers, rtol=1e-9), f"walls: {a['walls']}, {b['walls']}")
    (d / "slip.txt").write_text("plane 0 0 1 4 in\n")
    line = tendril(f"{SI} -growth_type feed -wall_file {d}/slip.txt -ts_max_time 0.01", 1)
    expect("write a unit right behind its number, 4in" in line, line)


@check
def a_table_may_say_units_in_its_columns():
    """A table says its units in the names of its columns, or by an attribute of HDF5: paths, tubes, growth tables, shapes."""
    d = Path(scene.SCRATCH)
    fed = f"{SI} -growth_type feed -growth_initial_length 2cm -rod_cells 20 -ts_max_time 1s -output {d}/u.h5 "
    tubes = {"cells": "x1,x2,x3,radius\n0mm,0mm,0mm,30mm\n900mm,0mm,0mm,30mm\n",
             "names": "x1 (mm),x2 [mm],x3(cm),radius (in)\n0,0,0,1.1811023622047245\n900,0,0,30mm\n"}
    walls = []
    for name, text in tubes.items():
        (d / f"{name}.csv").write_text(text)
        (d / f"{name}.txt").write_text(f"tube {name}.csv inside\n")
        tendril(f"{fed} -wall_file {d}/{name}.txt")
        with h5py.File(d / "u.h5") as f:
            walls.append([float(word) for word in f["walls"][()].decode().split()[2:10]])
    expect(np.allclose(*walls, rtol=1e-9, atol=1e-12), f"{walls}")
    (d / "names.csv").write_text(tubes["names"].replace("(in)", "(yd)"))
    expect("yd: not a unit of length" in tendril(f"{fed} -wall_file {d}/names.txt", 1), "yards")
    s, t = np.linspace(0, 1, 5), np.linspace(0, 20, 5)
    g = 0.02 + 0.0005 * t[:, None] + 0 * s
    lengths = []
    for units, shares in ((("s", "cm", ""), (1, 100)), (("min", "mm", "1"), (1 / 60, 1000)), (None, (1 / TIME, 1 / LENGTH))):
        with h5py.File(d / "g.h5", "w") as f:
            f["s"], f["t"], f["g"] = s, t * shares[0], g * shares[1]
            for name, unit in zip("tgs", units or ()):
                f[name].attrs["units"] = unit
        tendril(f"{SI} -growth_type table -growth_table {d}/g.h5 -shape_type straight -rod_cells 20 -ts_max_time 10s -output {d}/u.h5")
        lengths.append(read(f"{d}/u.h5")["series/length"][-1] * LENGTH)
    expect(np.allclose(lengths, 0.025, rtol=1e-9), f"{lengths}")
    shapes = []
    for unit, share in (("deg", 180 / np.pi), ("rad", 1), (None, 1)):
        with h5py.File(d / "theta.h5", "w") as f:
            f["s"], f["theta"] = s, 0.1 * s**2 * share
            if unit:
                f["theta"].attrs["units"] = unit
        tendril(f"-shape_type file -shape_file {d}/theta.h5 -rod_cells 20 -ts_max_time 1e-3 -output {d}/u.h5")
        shapes.append(read(f"{d}/u.h5")["shapes/theta"][0])
    expect(np.allclose(shapes, shapes[2], atol=1e-12) and np.abs(shapes[2]).max() > 0.05, "theta")
    for name, unit, words in (("t", "yr", "yr: not a unit of time"), ("s", "mm", "takes no unit"), ("g", "s", "not a unit of length")):
        with h5py.File(d / "g.h5", "w") as f:
            f["s"], f["t"], f["g"] = s, t, g
            f[name].attrs["units"] = unit
        line = tendril(f"{SI} -growth_type table -growth_table {d}/g.h5 -ts_max_time 1s", 1)
        expect(words in line.replace("/t in ", ""), line)


@check
def an_accuracy_may_have_a_unit():
    d = scene.SCRATCH
    chosen = []
    for units in (True, False):
        text = spoken(units).replace("-rod_cells 60", "-accuracy 1e-2")
        tendril(f"{text} -output {d}/accuracy.h5")
        with h5py.File(f"{d}/accuracy.h5") as f:
            chosen.append((f.attrs["parameters/rod_cells"], f.attrs["parameters/ts_rtol"]))
    expect(chosen[0] == chosen[1], f"{chosen}")


@check
def a_rod_given_with_units_is_the_rod_of_numbers():
    """The rod itself may be given with units: the same table; a sliding law's correlation length."""
    table = tendril(f"-task units {SI}")
    for said in ("-si_bending_stiffness 2.209Nmm^2 -si_friction_dry 0.5mN/mm -si_speed 5mm/s",
                 "-si_bending_stiffness 0.02209Ncm^2 -si_friction_dry 5mN/cm -si_speed 30cm/min"):
        expect(tendril(f"-task units {said}") == table, said)
    viscous = "-task units -si_bending_stiffness 2.209Nmm^2 -si_speed 3.6mm/h -si_friction_viscous "
    expect(tendril(viscous + "300Pas") == tendril(viscous + "300"), "viscous")
    fed = f"{SI} -growth_type feed -rod_curvature_random 0.1 -rod_cells 20 -ts_max_time 0.01 " \
          f"-output {scene.SCRATCH}/k.h5 -rod_curvature_length "
    shapes = []
    for length in ("5mm", repr(5e-3 / LENGTH)):
        tendril(fed + length)
        shapes.append(read(f"{scene.SCRATCH}/k.h5")["shapes/x"])
    expect(np.allclose(*shapes, rtol=1e-9), "-rod_curvature_length")


FREE = "-si_bending_stiffness 3944.1 -si_friction_dry 0 -growth_initial_length 1m "


@check
def a_heavy_column_stands_as_high_as_greenhill_says():
    """A weight in N/m, kg/m and in its own unit is one; a rod without friction stands as high as Greenhill's column,
    L^3 = 7.837347 YI/w, and hangs as the elastica does, whatever the unit of length is."""
    pole = f"-task critical -growth_type uniform -clamp_direction 0,0,1 {FREE}-rod_weight 0,0,-"
    height = (7.837347439 * 3944.1 / 38.515) ** (1 / 3)
    for weight in ("38.515N/m", f"{38.515 / 9.80665!r}kg/m", f"{38.515 / 9.80665 * 1000!r}g/m",
                   f"{38.515 / 9.80665 * 0.3048 / 0.45359237!r}lb/ft", f"{38.515 / 3944.1!r}"):
        said = tendril(pole + weight)
        expect(abs(float(re.search(r"length L = (\S+)", said)[1]) / height - 1) < 1e-8, f"{weight}: {said}")
    sag = "-growth_type none -shape_type straight -ts_max_time 1 -rod_cells 100 -rod_weight 0,-"
    tips = [np.hypot(*Run(sag + more).tip) for more in (
        f"1000N/m {FREE}",
        f"{1000 / 20.03!r} {TUBE.replace('4.4907e-4', '3944.1')}-growth_initial_length 1m -friction_layers 0:0")]
    scale = (3944.1 / 20.03) ** (1 / 3)
    expect(abs(tips[0] / (tips[1] * scale) - 1) < 1e-7, f"it hangs to {tips[0]}, {tips[1] * scale}")
    # of one that dry friction holds in part the rest falls at once, and all of it hangs there when that has given way
    for layers in ("0:0,0.1:1", "0:1,0.1:0"):
        r = Run(f"{sag}{1000 / 20.03!r} -growth_initial_length {1 / scale!r} -friction_layers {layers}")
        expect(abs(np.hypot(*r.tip) / tips[1] - 1) < 1e-7, f"-friction_layers {layers}: it hangs to {r.tip}")
    for wrong, word in (("-rod_weight 1,-2N/m", "-rod_weight: some of its numbers have a unit"),
                        ("-rod_weight 0,-2N", "N/m, mN/m"), ("-friction_layers 0:2", "-friction_layers: has nothing to multiply"),
                        ("-friction_mu 0.5", "-friction_mu")):
        expect(word in tendril(f"{FREE}-growth_type none -ts_max_time 0.1 {wrong}", 1), wrong)
    expect("-growth_initial_length: give it with a unit" in tendril("-si_bending_stiffness 1 -si_friction_dry 0", 1), "no length")
    expect("-si_friction_dry 0" in tendril("-si_bending_stiffness 1", 1), "no friction")


@check
def a_cable_that_begins_on_a_floor_is_told_how():
    """A heavy cable that begins along the floor of a duct of 17 points, a spline, is told that the floor is taken off, and
    not also to leave more room. Of cells it is told for the length at which it stops, not for that of -ts_max_time."""
    arc = [(2000 + 500 * np.sin(a), 500 - 500 * np.cos(a)) for a in np.radians(np.arange(10, 91, 10))]
    points = [(x, 0) for x in range(0, 2001, 250)] + [(round(x, 1), round(y, 1)) for x, y in arc] + [(2500, 1000)]
    floor = Path(scene.SCRATCH) / "floor.txt"
    floor.write_text(f"tube inside {' '.join(f'{x:g}mm {y:g}mm 10mm 16mm' for x, y in points)} friction 0.3\n")
    said = tendril("-growth_type feed -si_bending_stiffness 2Nm^2 -si_friction_dry 0 -si_friction_viscous 0.01 -si_speed 5cm/s "
                   "-growth_initial_length 20cm -shape_type straight -rod_weight 0,0,-0.5kg/m -contact_diameter 12mm "
                   f"-wall_file {floor} -stop_length 0.22m")
    expect("begins at a wall, 0 (0 um) from it" in said, said)
    for wrong in ("leave more room", "stands out"):
        expect(wrong not in said, f"{wrong}: {said}")


@check
def a_misplaced_unit_is_refused_by_the_option_and_its_units():
    """One line, which names the option and the units it takes."""
    for options, words in (
            ("-stop_length 3s", "-stop_length 3s m, cm, mm, um"),
            ("-stop_length 3furlong", "-stop_length 3furlong m, cm, mm, um"),
            ("-ts_max_time 2cm", "-ts_max_time 2cm h, min, s"),
            ("-ts_dt 2cm", "-ts_dt 2cm h, min, s"), ("-tip_force 2kg", "-tip_force N, mN, uN"),
            ("-rod_curvature 2cm", "-rod_curvature 1/m, /m, 1/cm"),
            ("-friction_layers 0s:1,3cm:2", "-friction_layers m, cm, mm, um"),
            ("-friction_layers 0:1cm,3cm:2", "-friction_layers 1cm takes no unit"),
            ("-friction_beta 1cm", "-friction_beta 1cm takes no unit"),
            ("-si_speed 3cm", "-si_speed 3cm m/s mm/h"),
            ("-si_friction_dry 3N", "-si_friction_dry 3N N/m mN/mm"),
            ("-si_bending_stiffness 3N", "-si_bending_stiffness 3N Nmm^2")):
        said = tendril(f"{SI} -growth_type feed -rod_cells 20 -ts_max_time 0.01 {options}", 1)
        for word in words.replace(", ", ",").split(" "):
            expect(word in said.replace(", ", ","), f"{options}: {said}")
    for options, word in ((SI.replace("-si_speed 0.005", "-ts_max_time 2min"), "-si_speed"),
                          ("-ts_max_time 2min", "-si_bending_stiffness"),
                          (f"{SI} -growth_initial_length 3cm -stop_length 2cm", "(3 cm)")):
        expect(word in tendril(options, 1), options)


@check
def with_scales_all_that_is_said_has_units_too():
    """Log, summary, event and errors have the laboratory's numbers, too; without one none of it."""
    run = f"{SI} -growth_type feed -growth_initial_length 1cm -friction_beta 1e-6 -shape_type " \
          "straight -rod_curvature 3/m -rod_cells 60 -ts_max_time 80s "
    text = tendril(f"{run} -stop_length 30cm")
    lines = text.splitlines()
    expect(re.search(r"t, s +length, cm +\|x2\|, cm +step, s ", lines[0]), lines[0])
    last = [line for line in lines if re.match(r" +[0-9]", line)][-1].split()
    expect(last[:2] == ["58.0000", "30.0000"], f"{last}")
    line = next(line for line in lines if line.startswith("in the laboratory: "))
    t, length, x, y = re.match(r"in the laboratory: t = (\S+) s, length (\S+) cm, tip \((\S+), (\S+)\)"
                               r" cm, \|x2\| \S+ cm$", line).groups()
    expect((t, length) == ("58", "30"), line)
    bare = re.search(r"tip \((\S+), (\S+)\)", text).groups()
    expect(np.allclose([float(x), float(y)], [float(v) * LENGTH * 100 for v in bare], rtol=1e-5), line)
    expect(re.search(r"stopped at t = \S+ \(58 s\): length \S+ \(30 cm\)", text), text)
    expect("ms) before -ts_max_time" in tendril(f"{run} -ts_max_steps 3", 1), "error")
    # a number without a unit is told once, with what it is; nothing is told of a scene that has none
    short = f"{run.replace('3/m', '0.05')} -stop_length 1.1cm -tip_force 2 -quiet"
    said = "without a unit, and so dimensionless: "
    expect(tendril(short) == "", "-quiet")
    told = [line for line in tendril(short.removesuffix("-quiet")).splitlines() if said in line]
    expect(len(told) == 1 and set(told[0].removeprefix(said).split(", ")) == {
        f"-tip_force 2 ({2e3 * FORCE:.6g} mN)", f"-rod_curvature 0.05 ({0.05 / LENGTH:.6g} 1/m)"}, f"{told}")
    expect(said not in text and said not in tendril("-ts_max_time 0.01 -tip_force 2"), "told of what has no unit")
    for task, length, more in ((f"{SI} -ts_max_time 1h", r"t = \S+ s, ", ""),
                               (SI.partition("-si_speed")[0], "", "")):
        text = tendril(f"-task critical {task}")
        line = re.search(rf"^in the laboratory: {length}L = (\S+) cm$", text, re.MULTILINE)
        expect(line and abs(float(line.group(1)) / (1.98713372 * LENGTH * 100) - 1) < 1e-5, text)
    flutter = tendril(f"-task critical -growth_type feed -growth_initial_length 2 {SI}")
    expect(re.search(r"L = \S+ cm, frequency \S+ rad/s$", flutter, re.MULTILINE), flutter)
    for bare in ("-ts_max_time 1 -stop_length 1", "-task critical"):
        text = tendril(bare)
        expect("laboratory" not in text and " cm" not in text and ", s" not in text, text)


@check
def numbers_without_units_in_a_wall_file_are_told():
    """Numbers of a wall file, and of tables and grids that it names, that have no unit in a scene of the laboratory
    are told in one line: the first, with what it is there, and how many more. Of 0, of directions and of what has
    units nothing is told, nor of any number in a scene without the laboratory."""
    d = Path(scene.SCRATCH)
    (d / "bare.csv").write_text("x1,x2,x3,radius\n0,0,0,0.5\n9,0,0,0.5\n")
    (d / "said.csv").write_text("x1 (cm),x2 (cm),x3 (cm),radius (cm)\n-1,0,0,0.5\n9,0,0,0.5\n")
    axis = np.linspace(-3, 3, 31)
    x = np.stack(np.meshgrid(axis + 12, axis, axis, indexing="ij"))
    for name, units in (("bare", None), ("said", "cm")):
        with h5py.File(d / f"{name}.h5", "w") as f:
            f["origin"], f["spacing"] = [9., -3, -3], [0.2, 0.2, 0.2]
            f["distance"] = np.sqrt((x[0] - 12) ** 2 + x[1] ** 2 + x[2] ** 2) - 1
            for dataset in f.values() if units else ():
                dataset.attrs["units"] = np.bytes_(units)
    rod = "-growth_type feed -growth_initial_length 1mm -contact_diameter 8mm -rod_cells 20 -ts_max_time 0.001s "
    cm, speed = 100 * LENGTH, LAB["speed"]
    for text, space, told in (
        ("circle 8 0 1 outside\n", False, f"8 ({8 * cm:.6g} cm) of line 1, and 1 more"),
        ("# nothing\nplane 0 -30cm 0 1\n\nplane 0 -8 0 1", False, f"-8 ({-8 * cm:.6g} cm) of line 4"),
        ("path 4cm -3cm 0 9cm 0 radius 5\n", False, f"5 ({5 * cm:.6g} cm) of line 1"),
        ("circle 8cm 0 1cm outside friction 0.2\nplane 0 -8cm 0 1\n", False, None),
        ("sphere 50cm 0 0 1cm outside moves 2 0 0", True, f"2 ({2 * speed:.6g} m/s) of line 1"),
        ("sphere 50cm 0 0 1cm outside moves 2mm/s 0 0 turns 1 50cm 0 0 1 0 0", True, None),
        ("tube bare.csv inside", True, f"9 ({9 * cm:.6g} cm) of line 1, and 2 more"), ("tube said.csv inside", True, None),
        ("body bare.h5 outside", True, f"9 ({9 * cm:.6g} cm) of line 1, and 2 more"), ("body said.h5 outside", True, None)):
        (d / "walls.txt").write_text(text)
        options = f"{rod} -wall_file {d}/walls.txt {'-rod_model space' * space} "
        said = [line for line in tendril(f"{SI} {options}").splitlines() if "dimensionless" in line]
        wanted = [f"-wall_file {d}/walls.txt: without a unit, and so dimensionless: {told}"] if told else []
        expect(said == wanted, f"{text}: {said} for {wanted}")
        expect("dimensionless" not in tendril(f"{SI} {options} -quiet"), text)
    (d / "walls.txt").write_text("circle 8 0 1 outside\n")
    bare = "-growth_type feed -contact_diameter 0.1 -rod_cells 20 -ts_max_time 0.001 "
    expect("dimensionless" not in tendril(f"{bare} -wall_file {d}/walls.txt"), "told without a laboratory")


@check
def a_run_that_ends_straight_says_so():
    """A run that ends straight says so, and what to give: whether it began so or has become so, in every model
    and direction, but not where something bends it, nor where it was quiet or gave up for another reason that is told."""
    stayed, became = "The rod stayed straight: nothing bends it", "The rod has become straight, to an angle of "
    wall = Path(scene.SCRATCH, "head-on.txt")
    wall.write_text("plane 2 0 -1 0\n")
    straight = "-shape_type straight -ts_max_time 2 "
    for options, told, remedy in (
        (straight, stayed, "-rod_curvature"), ("-shape_amplitude 0 -ts_max_time 2", stayed, "-shape_amplitude"),
        (f"{straight} -clamp_angle 0.7 -rod_model mixed", stayed, "-rod_curvature"),
        (f"{straight} -rod_model linear", stayed, "-rod_curvature"),
        (f"{straight} -rod_model space -clamp_direction 1,2,3", stayed, "-rod_curvature"),
        (f"{straight} -growth_type none -tip_force -1", stayed, "-rod_curvature"),
        (f"{straight} -growth_type feed -wall_file {wall} -ts_max_time 0.3 -contact_diameter 0.1", stayed, "-rod_curvature"),
        ("-ts_max_time 2", became, "-rod_curvature"), ("-ts_max_time 2 -rod_model auto", became, "-rod_curvature"),
        (f"{straight} -rod_curvature 0.01", None, ""), (f"{straight} -rod_weight 0,-0.1", None, ""),
        ("-ts_max_time 0.01 -shape_amplitude 1e-9", None, ""), ("-ts_max_time 20", None, ""), (f"{straight} -quiet", None, "")):
        said = [line for line in tendril(options).splitlines() if line.startswith("The rod ")]
        expect(len(said) == (told is not None), f"{options}: {said}")
        expect(not told or said[0].startswith(told) and remedy in said[0], f"{options}: {said}")
    done = subprocess.run([scene.TENDRIL, *shlex.split(f"-growth_type feed -growth_initial_length 1 {straight} "
                          f"-wall_file {wall} -ts_max_time 4")], capture_output=True, text=True, env=scene.ENVIRONMENT)
    expect(done.returncode and "jammed at" in done.stderr and stayed not in done.stdout, done.stdout + done.stderr)


@check
def paraview_plays_the_rod_in_time():
    """ParaView's own reader plays the rod in time."""
    try:
        from vtkmodules.util.numpy_support import vtk_to_numpy
        from vtkmodules.vtkIOXdmf2 import vtkXdmfReader
    except ImportError:
        print("vtk is not installed: left out")
        return
    d = scene.SCRATCH
    for name, rod in (("rod", DRY), ("space", "-growth_initial_length 1 -shape_type straight -rod_curvature 0.4 "
                                     "-rod_curvature_2 0.1 -rod_twist 0.5")):
        tendril(f"{rod} -ts_max_time 3 -output_interval 0.5 -output {d}/{name}.h5")
        played(vtkXdmfReader(), vtk_to_numpy, f"{d}/{name}", read(f"{d}/{name}.h5"))


@check
def paraview_plays_several_rods_each_as_its_line():
    """ParaView's own reader has a line for each rod, with its number, through its nodes alone."""
    try:
        from vtkmodules.util.numpy_support import vtk_to_numpy
        from vtkmodules.vtkIOXdmf2 import vtkXdmfReader
    except ImportError:
        print("vtk is not installed: left out")
        return
    d = scene.SCRATCH
    Path(f"{d}/two.opts").write_text("-growth_type feed\n-ts_max_time 0.1\n-output_shapes 2\n[rod a]\n-rod_cells 7\n-contact_diameter 0.01\n-contact_self\n"
                                     "[rod b]\n-rod_cells 5\n-clamp_place 0,1,0\n")
    tendril(f"-options_file {d}/two.opts -output {d}/two.h5")
    reader, r = vtkXdmfReader(), read(f"{d}/two.h5")
    played(reader, vtk_to_numpy, f"{d}/two", r)
    grid = reader.GetOutputDataObject(0)
    while grid.IsA("vtkMultiBlockDataSet"):
        grid = grid.GetBlock(0)
    lines = [[grid.GetCell(k).GetPointId(i) for i in range(grid.GetCell(k).GetNumberOfPoints())] for k in range(grid.GetNumberOfCells())]
    expect(lines == [list(range(8)), list(range(8, 14))], f"lines {lines}")
    expect(list(vtk_to_numpy(grid.GetCellData().GetArray("rod"))) == [0, 1], "numbers of the rods")


def played(reader, vtk_to_numpy, name, r):
    """Each shape as the reader has it, of a rod in space with its vectors."""
    space = r["shapes/x"].shape[2] == 3
    reader.SetFileName(f"{name}.xmf")
    reader.UpdateInformation()
    times = np.array(reader.GetOutputInformation(0).Get(reader.GetExecutive().TIME_STEPS()))
    expect(np.allclose(times, r["shapes/t"]), f"times {times}")
    for k, t in enumerate(times):
        reader.UpdateTimeStep(t)
        grid = reader.GetOutputDataObject(0)
        while grid.IsA("vtkMultiBlockDataSet"):
            grid = grid.GetBlock(0)
        x = vtk_to_numpy(grid.GetPoints().GetData())
        expect(np.allclose(x[:, :3 if space else 2], r["shapes/x"][k], atol=1e-6), f"x at t = {t}")
        arrays = {"theta": r["shapes/theta"][k], "curvature": r["shapes/curvature"][k]}
        arrays |= ({v: r[f"shapes/{v}"][k] for v in ("force", "moment", "strain", "d1", "d2", "d3")} if space else
                   {"force_1": r["shapes/force"][k, :, 0], "force_2": r["shapes/force"][k, :, 1]})
        for name, values in arrays.items():
            a = vtk_to_numpy(grid.GetPointData().GetArray(name))
            expect(np.allclose(a, values, atol=1e-6), f"{name} at t = {t}")
    print(f"{len(times)} shapes read by VTK")


@check
def task_units_prints_the_scales_of_its_table():
    """The table of -task units is what README says: l = (YI/N)^(1/3), forces in N l, times in l/V."""
    YI, mu, nu, V = 3e-4, 15, 50, 0.1
    N = mu + nu * V
    l = (YI / N) ** (1 / 3)
    text = tendril(f"-task units -si_bending_stiffness {YI} -si_friction_dry {mu} "
                   f"-si_friction_viscous {nu} -si_speed {V} -growth_initial_length 2 -ts_max_time 3")
    table = {line.split()[0]: float(line.split()[1]) for line in text.splitlines()[1:-1]}
    for name, value in dict(length=l, force=N * l, time=l / V, speed=V, energy=N * l * l,
                            power=N * l * V, curvature=1 / l).items():
        expect(abs(table[name] / value - 1) < 1e-7, f"{name}: {table[name]}, not {value}")
    start, end, share = (float(x) for x in re.findall(
        r"from (\S+) m to (\S+) m; .* is (\S+)\.$", text.splitlines()[-1])[0])
    expect(np.allclose((start / l, end / l, share), (2, 5, mu / N), rtol=1e-5), f"{text}")


@check
def each_array_of_the_xdmf_is_that_of_the_result():
    """Each array that the .xmf names is that of the .h5 (read without ParaView)."""
    d = scene.SCRATCH
    tendril(f"{DRY} -ts_max_time 1 -output_interval 0.5 -output {d}/rod.h5")
    r = read(f"{d}/rod.h5")
    grids = ElementTree.parse(f"{d}/rod.xmf").findall("./Domain/Grid/Grid")
    expect(len(grids) == len(r["shapes/t"]), f"{len(grids)} shapes")
    for k, grid in enumerate(grids):
        expect(float(grid.find("Time").get("Value")) == r["shapes/t"][k], f"time {k}")
        for name, label, column in (("x", None, slice(2)), ("theta", "theta", None),
                                    ("curvature", "curvature", None), ("force", "force_1", 0),
                                    ("force", "force_2", 1)):
            slab = grid.find("Geometry/DataItem" if label is None else
                             f"Attribute[@Name='{label}']/DataItem")
            start, stride, count = np.array([int(n) for n in slab[0].text.split()]).reshape(3, -1)
            file, data = slab[1].text.split(":")
            with h5py.File(f"{d}/{file}") as f:
                whole = f[data][()]
            expect([int(n) for n in slab[1].get("Dimensions").split()] == list(whole.shape), data)
            got = whole[tuple(slice(a, a + h * n, h) for a, h, n in zip(start, stride, count))]
            expect([int(n) for n in slab.get("Dimensions").split()] == list(got.shape), data)
            want = r[f"shapes/{name}"][k] if column is None else r[f"shapes/{name}"][k][:, column]
            expect(np.array_equal(got.ravel(), want.ravel()), f"{label or 'x'} of shape {k}")


@check
def a_rod_begins_with_its_natural_curvature():
    """At t = 0 the rod has the angle of its natural curvature; a random one has the root mean square
    and the correlation it was asked for."""
    for law in ("uniform", "gaussian"):
        r = Run(f"-growth_type {law} -growth_initial_length 2 -shape_type straight -ts_max_time 0.01 "
                "-rod_curvature 0.1")
        expect(abs(r.shapes["theta"][0, -1] - 0.2) < 1e-9, f"{law}: {r.shapes['theta'][0, -1]}")
    part = 0.005
    r = Run("-growth_initial_length 2 -shape_type straight -ts_max_time 0.001 -rod_cells 2000 "
            f"-rod_curvature_random 0.1 -rod_curvature_length {part}")
    s, k = r.shapes["s"], r.shapes["curvature"][0]
    even = np.interp(np.linspace(0, 1, 4001), s, k)
    shift = int(part * 4000)
    rms, along = even.std(), np.mean(even[shift:] * even[:-shift]) / np.mean(even ** 2)
    print(f"root mean square {rms:.4f}, correlation after one length {along:.3f}")
    expect(abs(rms / 0.1 - 1) < 0.15, f"root mean square {rms}")
    expect(abs(along - np.exp(-0.5)) < 0.2, f"correlation {along}")


@check
def a_restart_past_the_end_keeps_the_curvature_of_material():
    """Past its end, a fed rod keeps the natural curvature that its material has: in one go on or in
    two it is the same rod. Points that do not belong to their state are refused."""
    d = scene.SCRATCH
    fed = "-growth_type feed -growth_initial_length 2 -shape_type straight -output_interval 0.5 " \
          "-rod_curvature_random 0.1 -rod_curvature_length 0.2 "
    for name in ("one", "two"):
        tendril(f"{fed} -ts_max_time 4 -output {d}/{name}.h5")
    tendril(f"-restart {d}/two.h5 -ts_max_time 5.5")
    for name in ("one", "two"):
        tendril(f"-restart {d}/{name}.h5 -ts_max_time 7")
    one, two = read(f"{d}/one.h5"), read(f"{d}/two.h5")
    same_run(one, two, "in one and in two", 1e-5)
    with h5py.File(f"{d}/one.h5", "r+") as f:
        f["restart/points"][0] += 1
    expect("is not whole" in tendril(f"-restart {d}/one.h5 -ts_max_time 8", 1), "goes on from a mix")


if __name__ == "__main__":
    sys.exit(scene.main())

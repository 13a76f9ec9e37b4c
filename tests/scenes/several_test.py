#!/usr/bin/env python3
"""Several rods in one run: each is what it is alone, whatever it is called and beside whatever it is; and what is refused.

    several_test.py build/tendril CHECK...      (no CHECK: all of them)"""

import shlex
import subprocess
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "support"))
import scene  # takes .venv's python if this one lacks numpy and h5py
from scene import Run, check, expect

import h5py
import numpy as np

SHARED = ("-growth_type uniform -growth_initial_length 1 -friction_beta 1e-4 -shape_type sag -shape_amplitude 1e-3 "
          "-ts_max_time 1 -rod_cells 40 -output_interval 0.25 ")
RODS = {"tap": "-growth_initial_length 0.7",
        "left": "-clamp_place 0,2,0.5 -rod_cells 50 -rod_curvature 0.4 -friction_mu 0.9",
        "heavy": "-clamp_place 0,-2,0.5 -clamp_direction 0,1,1 -rod_weight 0,0,-0.2 -rod_curvature_2 0.4",
        "pressed": "-growth_type feed -growth_initial_length 0.5 -contact_diameter 0.05 -rod_curvature 0.2 -rod_cells 40 -wall_file {wall}"}


def words(options):
    """(option, value) of a text of options."""
    all_of = shlex.split(options)
    return list(zip(all_of[::2], all_of[1::2]))


def file(text, name="several.opts"):
    path = Path(scene.SCRATCH) / name
    path.write_text(text)
    return path


def lines(options):
    return "".join(f"{name} {value}\n" for name, value in words(options))


def several(rods, options="", shared=SHARED):
    """{rod: (shapes x, series)} of one run of all of them, and its steps."""
    path = file(lines(shared) + "".join(f"[rod {name}]\n{lines(own)}" for name, own in rods.items()))
    out = Path(scene.SCRATCH) / "several.h5"
    done = subprocess.run([scene.TENDRIL, "-options_file", str(path), *shlex.split(options), "-output", str(out), "-quiet"],
                          capture_output=True, text=True, env=scene.ENVIRONMENT)
    expect(done.returncode == 0 and not done.stderr, done.stderr)
    found = {}
    with h5py.File(out) as f:
        for k, name in enumerate(f["rods/name"][:]):
            first, count = f["rods/first"][k], f["rods/count"][k]
            series = {key: column[:, k] for key, column in f["rods/series"].items()}
            found[name.decode()] = f["shapes/x"][:, first:first + count], series, dict(f[f"rods/of/{name.decode()}"].attrs)
        expect(f.attrs["finished"] == 1, "not finished")
        sums = {key: column[:] for key, column in f["series"].items()}
    return found, sums


def with_wall(rods):
    wall = file("plane 1 0.2 0 -1 0 0 friction 0.2\n", "wall.txt")
    return {name: own.format(wall=wall) for name, own in rods.items()}


FIXED = "-ts_adapt_type none -ts_dt 0.01 -ts_rtol 1e-11 "  # the smaller, the nearer is Newton's method to what it looks for


@check
def rods_apart_are_runs_of_their_own():
    rods = with_wall(RODS)
    del rods["pressed"]  # in contact how firm it is follows from steps
    found, sums = several(rods, FIXED)
    for name, own in rods.items():
        alone = Run(f"{SHARED}{own} {FIXED} -ts_bdf_factor 0 -rod_model space -quiet")
        x, series, _ = found[name]
        off = np.abs(x - alone.shapes["x"]).max()
        energy = abs(series["energy"][-1] / alone.energy[-1] - 1)
        print(f"{name}: off by {off:.1e}, energy {energy:.1e}")
        expect(x.shape == alone.shapes["x"].shape and off < 1e-10, f"{name}: {off}")
    total = sum(series["energy"] for _, series, _ in found.values())
    expect(np.allclose(sums["energy"], total, rtol=1e-14), "energies do not add up")


@check
def at_the_defaults_they_are_within_what_is_told():
    """And a rod in contact is stepped as if it were alone."""
    rods = with_wall(RODS)
    found, sums = several(rods)
    for name, own in rods.items():
        alone = Run(f"{SHARED}{own} -rod_model space -quiet")
        x, series, about = found[name]
        away = alone.end_distance[-1]
        off = np.linalg.norm(x[-1, -1] - alone.shapes["x"][-1, -1]) / away
        told = about["error_end_tip"] + alone.told["end_tip"]
        print(f"{name}: tip off by {off:.1e}, told {told:.1e}; defect {series['energy_defect'][-1]:.1e}")
        expect(off <= told + 1e-9, f"{name}: {off} is more than {told}")
        expect(off < 1e-4, f"{name}: {off}")
        expect(about["error_kind"] == b"measured" or about["error_kind"] == "measured", f"{name}: errors are not followed")
        expect(series["energy_defect"][-1] < 1e-3, f"{name}: energy {series['energy_defect'][-1]}")
    expect(found["pressed"][1]["contact_force"][-1] > 0, "the pressed rod does not touch")


@check
def neither_order_nor_names_change_anything():
    rods = {name: RODS[name] for name in ("tap", "left", "heavy")}
    first, _ = several(rods)
    again, _ = several({f"r{k}": rods[name] for k, name in enumerate(("heavy", "tap", "left"))})
    for k, name in enumerate(("heavy", "tap", "left")):
        off = np.abs(first[name][0] - again[f"r{k}"][0]).max()
        print(f"{name}: {off:.1e}")
        expect(off < 1e-12, f"{name}: {off}")


@check
def tables_sections_and_prefixes_say_the_same():
    """A row of a table, lines below its head, a section of one of its rods and a prefix, the latter before the former."""
    file("name, clamp_place, rod_curvature\na1, \"0,1,0\", 0.1\na2, \"0,2,0\", 0.2\n", "plants.csv")
    path = file(f"{lines(SHARED)}-rod_cells 30\n[rods plants.csv]\n-rod_curvature 7\n-rod_torsion 0.6\n[rod a2]\n-rod_cells 20\n")
    out = Path(scene.SCRATCH) / "table.h5"
    done = subprocess.run([scene.TENDRIL, "-options_file", str(path), "-a1_rod_torsion", "0.8", "-output", str(out), "-quiet"],
                          capture_output=True, text=True, env=scene.ENVIRONMENT)
    expect(done.returncode == 0 and not done.stderr, done.stderr)
    by_hand, _ = several({"a1": "-clamp_place 0,1,0 -rod_curvature 0.1 -rod_torsion 0.8 -rod_cells 30",
                          "a2": "-clamp_place 0,2,0 -rod_curvature 0.2 -rod_torsion 0.6 -rod_cells 20"})
    with h5py.File(out) as f:
        x = f["shapes/x"][:]
        expect([n.decode() for n in f["rods/name"][:]] == ["a1", "a2"], "names")
    expect((x == np.concatenate([by_hand["a1"][0], by_hand["a2"][0]], axis=1)).all(), "not the same")


@check
def a_run_that_was_stopped_goes_on_to_the_last_digit():
    """With friction that is held exactly, and in contact: series and shapes of the unbroken run."""
    rods = with_wall(RODS)
    rods["pressed"] += " -friction_beta 0"
    path = file(lines(SHARED) + "".join(f"[rod {name}]\n{lines(own)}" for name, own in rods.items()))
    whole, part = Path(scene.SCRATCH) / "whole.h5", Path(scene.SCRATCH) / "part.h5"

    def run(*words):
        return subprocess.run([scene.TENDRIL, *map(str, words), "-quiet"], capture_output=True, text=True, env=scene.ENVIRONMENT)

    done = run("-options_file", path, "-output", whole)
    expect(done.returncode == 0, done.stderr)
    with h5py.File(whole) as f:
        steps = len(f["series/t"])
    stopped = run("-options_file", path, "-output", part, "-ts_max_steps", steps // 2)
    expect("-ts_max_steps: reached" in stopped.stderr, stopped.stderr)
    again = run("-restart", part)
    expect(again.returncode == 0 and not again.stderr, again.stderr)
    with h5py.File(whole) as a, h5py.File(part) as b:
        for group in ("series", "rods/series", "shapes"):
            for name in a[group]:
                one, two = a[group][name][:], b[group][name][:]
                expect(one.shape == two.shape and np.array_equal(one, two, equal_nan=True), f"{group}/{name} differs")
    late = run("-restart", part)
    expect("give a later -ts_max_time" in late.stderr, late.stderr)
    other = run("-restart", part, "-options_file", file("[rod a]\n"), "-ts_max_time", 2)
    expect("has 4 rods, and the scene has 1" in other.stderr, other.stderr)


def ended(text, *words, out="ended.h5"):
    """The attributes of /event, its time, and the lines printed, of a run."""
    out = Path(scene.SCRATCH) / out
    done = subprocess.run([scene.TENDRIL, *text, *words, "-output", str(out)], capture_output=True, text=True, env=scene.ENVIRONMENT)
    expect(done.returncode == 0 and not done.stderr, done.stderr)
    with h5py.File(out) as f:
        expect(f.attrs["finished"] == 1, "not finished")
        event = {key: value.decode() if isinstance(value, bytes) else value for key, value in f["event"].attrs.items()} if "event" in f else {}
        return event, f["event/t"][()] if event else None, f["series/t"][-1], done.stdout


@check
def the_first_event_of_any_rod_ends_the_run():
    """Located in time within the step, and told of its rod; the run goes on from there to where none ends it."""
    path = file(lines(SHARED) + "[rod a]\n-stop_length 1.613\n[rod b]\n-clamp_place 0,1,0\n-growth_initial_length 0.8\n-stop_length 1.2\n")
    event, t, last, told = ended(["-options_file", str(path)])
    expect(event == {"kind": "length", "rod": "b"} and abs(t - 0.4) < 1e-14 and last == t, f"{event} at {t}, last {last}")
    expect("b: stopped at t = 0.4: length 1.2\n" in told and "a: " in told and "a: stopped" not in told, told)
    with h5py.File(Path(scene.SCRATCH) / "ended.h5") as f:
        expect(f["shapes/t"][-1] == t, "no shape of the event")
    event, t, last, told = ended(["-restart", str(Path(scene.SCRATCH) / "ended.h5")], out="further.h5")
    expect(not event and last == 1, f"{event}, {last}")
    event, t, *_ = ended(["-options_file", str(path), "-b_stop_length", "5", "-a_stop_length", "1.25"])
    expect(event == {"kind": "length", "rod": "a"} and abs(t - 0.25) < 1e-14, f"{event} at {t}")


@check
def rods_that_grow_towards_each_other_stop_where_they_touch():
    """Tip to tip, at the distance in which contact sets in."""
    path = file("-growth_type feed\n-growth_initial_length 0.5\n-contact_diameter 0.05\n-contact_rods\n-ts_max_time 2\n-rod_cells 20\n"
                "[rod left]\n-clamp_place 0,-0.01,0\n-stop_contact\n[rod right]\n-clamp_place 2,0.01,0\n-clamp_direction -1,0,0\n")
    event, t, _, told = ended(["-options_file", str(path)])
    expect(event == {"kind": "contact", "rod": "left"} and "left: stopped" in told and "touches a rod at s = 1\n" in told, f"{event}: {told}")
    gap = np.hypot(2 - 2 * (0.5 + t), 0.02) - 0.05
    print(f"t = {t:.6f}, gap {gap:.2e}")
    expect(0 < gap < 0.01, f"they touch at a gap of {gap}")


@check
def a_run_is_repeated_until_each_rod_is_as_accurate_as_asked_for():
    """The rod that is bent most gets more cells; what is given stays, and is told."""
    path = file("-growth_type uniform\n-growth_initial_length 1\n-friction_beta 1e-3\n-ts_max_time 0.5\n-accuracy 1e-3\n"
                "[rod a]\n-rod_curvature 30\n[rod b]\n-clamp_place 0,3,0\n-rod_curvature 0.3\n")
    out = Path(scene.SCRATCH) / "accurate.h5"
    _, _, _, told = ended(["-options_file", str(path)], out="accurate.h5")
    expect(told.count("once more") == 1 and "may not be met" not in told, told)
    with h5py.File(out) as f:
        cells, error = f["rods/count"][:] - 1, f.attrs["error_end_estimate"]
    expect(cells[0] > 1.5 * cells[1] and error < 1e-3, f"{cells} cells, {error}")
    _, _, _, told = ended(["-options_file", str(path), "-a_rod_cells", "50"])
    expect("once more" not in told and "-accuracy 0.001 may not be met, the estimate is above it; give -rod_cells" in told, told)


REFUSED = [  # (lines of a scene, more words, what is said)
    ("[rod a]\n-contact_diameter 0.1\n[rod b]\n-clamp_place 0,1,0\n", "", "line 2, rod a: -contact_diameter: there is nothing to touch; give -contact_rods, or [pair]"),
    ("[rod a]\n-friction_nu 1\n", "", "several.opts, line 2, rod a: -friction_nu: unknown option, did you mean -friction_mu?"),
    ("[rod a]\n\n-rod_curvature x\n", "", "several.opts, line 3, rod a: -rod_curvature x: give a number"),
    ("[rod a]\n-ts_max_time 3\n", "", "several.opts, line 2, rod a: -ts_max_time: is of the scene as a whole"),
    ("[rod a]\n-growth_zone 0.2\n", "", "several.opts, line 2, rod a: -growth_zone: nothing in this run reads it"),
    ("[rod a]\n", "-a_rod_curvature x", "-a_: -rod_curvature x: give a number"),
    ("[rod a]\n[rod b]\n-change_file late.txt\n", "", "rod b: -change_file: at t = 0.005: rod_cells cannot be changed in a run"),
    ("[rod a]\n", "-b_rod_curvature 1", "-b_rod_curvature: unknown option"),
    ("[rod a]\n[rod b]\n[rod a]\n", "", "line 3: there is a [rod a] already"),
    ("[rod rod]\n", "", "line 1: a rod cannot be named rod"),
    ("[rod a-b]\n", "", "line 1: a rod's name is of letters and digits"),
    ("[rod a\n", "", "line 1: a section is a line of its own, in brackets: [rod NAME]"),
    ("[root a]\n", "", "line 1: [root]: a section is [rod NAME], [rods FILE.csv] or [pair NAME NAME]"),
    ("[rods nowhere.csv]\n", "", "nowhere.csv"),
    ("[rods bare.csv]\n", "", "has no column `name`"),
    ("[rods bad.csv]\n", "", "bad.csv, rod a2: -rod_curvature y: give a number"),
    ("[rods twice.csv]\n", "", "two rods are named a1"),
    ("[rod a]\n-options_file other.opts\n", "", "line 2: -options_file: is no option of a rod"),
    ("[rod a]\n[rod b]\n[pair a b]\n", "", "several.opts, line 3, pair a b: rod a has no thickness; give it a -contact_diameter"),
    ("[rod a]\n[rod b]\n[pair a c]\n", "", "line 3: [pair a c]: no rod, and no table of rods, is called c"),
    ("[rod a]\n[rod b]\n[pair a,]\n", "", "line 3: [pair a,]: a pair has two names"),
    ("[rod a]\n[rod b]\n[pair a b]\n-rod_cells 3\n", "", "line 4, pair a b: -rod_cells: is not of how two rods touch"),
    ("[rod a]\n[rod b]\n[pair a b]\n-contact_friction x\n", "", "line 4, pair a b: -contact_friction x: give a number"),
    ("-contact_diameter 0.1\n[rod a]\n[rod b]\n-clamp_place 0,0.05,0\n[pair a b]\n", "", "rods a and b are 0.05"),
    ("[rod a]\n-clamp_type free\n", "", "line 2, rod a: -clamp_type free: nothing keeps a rod in space from spinning"),
    ("[rod a]\n", "-task critical", "[rod a]: this -task knows one rod"),
    ("[rod a]\n", "-pc_type lu", "several rods have none"),
    ("[rod a]\n-accuracy 1e-4\n", "", "line 2, rod a: -accuracy: is of the scene as a whole"),
    ("[rod a]\n-stop_length 0.5\n", "", "several.opts, line 2, rod a: -stop_length: the rod is 0.5 long at the start"),
    ("[rod a]\n", "-stop_contact", "-stop_contact: there is nothing to touch; give -contact_rods"),
    ("[rod a]\n[rod b]\n-rod_curvature 1\n-shape_type sag\n-shape_amplitude 1\n-stop_angle 0.5\n", "", "rod b: -stop_angle: it is so at t = 0 already"),
    ("[rod a]\n", "-rod_model frame", "-rod_model: several rods are in space"),
]


@check
def what_is_wrong_is_told_with_rod_and_line():
    """One line each, and no result."""
    file("rod_curvature\n1\n", "bare.csv")
    file("0.005 rod_cells 3\n", "late.txt")
    file("name, rod_curvature\na1, 1\na2, y\n", "bad.csv")
    file("name, rod_curvature\na1, 1\na1, 2\n", "twice.csv")
    for text, more, said in REFUSED:
        path = file(text)
        done = subprocess.run([scene.TENDRIL, "-options_file", str(path), "-ts_max_time", "0.01", *shlex.split(more)],
                              capture_output=True, text=True, env=scene.ENVIRONMENT)
        found = done.stderr.strip()
        expect(done.returncode != 0 and said in found and "\n" not in found and found.startswith("tendril: "),
               f"{text!r} {more}: exit {done.returncode}, {found!r} and not {said!r}")


@check(ranks=2)
def several_ranks_are_refused():
    path = file("[rod a]\n")
    done = scene.on_ranks(2, ["-options_file", str(path)])
    expect(done.returncode != 0 and "[rod a]: several rods run on one rank in this version" in done.stderr, done.stderr)


if __name__ == "__main__":
    sys.exit(scene.main())

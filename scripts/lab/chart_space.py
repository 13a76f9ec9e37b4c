#!/usr/bin/env python3
"""Speed against accuracy in space, beside PyElastica, MuJoCo and Exudyn: runs what is not yet in the store, and writes
docs/notes/chart-space.csv and docs/notes/chart-space.png.

    chart_space.py [--only SCENE,...] [--methods NAME,...] [--draw] [--again]

Scenes, each with an exact answer but the last: bend (45 degrees, Bathe), twisted (clamped at both ends, 27 turns), laid (a heavy rod
lies down on a plane), capstan (a rope slides round a pillar), helix (a rod is pushed two turns along a helical duct; PyElastica, which
has none, pulls a rope round a pillar along the same helix), root (in the plane: one that was turned by 90 degrees bends down as it grows, by a
law that was written for PyElastica), injected (a rod in a lying tube, to lock-up; tendril
alone, against its own finest run). What is not run again stays as the table has it. TENDRIL names the executable. Peers: scripts/lab/peers/setup.sh first. Seconds are of
the loop alone, one core: tendril's of the clock or of the processor, whichever is less, the shortest of up to three runs; the
peers' of the processor, once."""

import argparse
import csv
import json
import math
import os
import re
import shlex
import sys
import tempfile

import h5py
import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import brentq, root

from measure import PEERS, ROOT, TENDRIL, Store, execute

sys.path[:0] = [str(ROOT / "tests/scenes/space"), str(ROOT / "tests/support"), str(ROOT / "scripts")]
import ropes_test as ropes
import scene as scene_runs
from tendril.style import STYLE

TABLE = ROOT / "docs" / "notes" / "chart-space.csv"
COLUMNS = ("scene", "method", "options", "error", "seconds", "steps", "failed")
METHODS = {"tendril": ("#0072B2", "o", "-"), "PyElastica": ("#666666", "d", ":"), "MuJoCo": ("#D55E00", "s", "--"),
           "Exudyn": ("#009E73", "^", "--")}
TITLES = {"bend": "bend of 45°:\nplace of the tip", "twisted": "twisted by 27 turns:\nlargest angle",
          "laid": "laid down on a plane:\nshape", "capstan": "capstan:\nratio of tensions",
          "helix": "helical capstan, two turns:\npush that comes out", "root": "root turned by 90°:\nangle of the tip",
          "injected": "injected tube to lock-up:\nlength at six pushes"}
# places of the tip over the radius: of a rod that neither stretches nor shears, and of Bathe's, which does
KIRCHHOFF, REISSNER = ((0.471512944003, 0.156850781622, 0.534685984423), (0.471504385736, 0.156848005340, 0.534748787918))
ANGLE = 47.65156384  # by shooting, as tests/scenes/space/space_test.py has it
WEIGHT, HIGH, SEEN = 100.0, 0.1, 0.25
PUSHES = 2.5, 3, 5, 10, 20, 40
ROOT_ANGLE = 2 * math.atan(math.exp(-2)) - math.pi / 2  # tan of half the way to go falls by e^(-b growth)
STEEP = 3**0.5 / 2  # the sine of 60 degrees
TWO_TURNS, PUSHED_OUT = 4 * np.pi / STEEP, 0.562367828485  # of a radius of 1: Q = P - torsion^2 falls by e^(-mu curvature s)


# --- exact answers -------------------------------------------------------------------------------

def bend_error(tip, exact):
    return float(np.linalg.norm(np.subtract(tip, exact)) / (np.pi / 4))


def elastica_laid_down(high, at):
    """Place at an arc length of a heavy rod of B = 1, clamped level so high above the plane on which it lies down."""
    def shape(y, dense=False):
        length, moment, shear = y
        return solve_ivp(lambda s, y: [np.cos(y[2]), np.sin(y[2]), y[3], -(shear + WEIGHT * s) * np.cos(y[2])],
                         (0, length), [0, high, 0, moment], rtol=1e-12, atol=1e-14, dense_output=dense)

    length = (72 * high / WEIGHT)**0.25  # of small slopes
    found = root(lambda y: shape(y).y[1:, -1], [length, -WEIGHT * length**2 / 6, -2 * WEIGHT * length / 3], tol=1e-13)
    return shape(found.x, True).sol(at)[:2]


def laid_error(s, x):
    """How far a point of the span is off, over the height; x: along, up. Contact gives way a little everywhere: the height
    is that of the run."""
    s, x = np.asarray(s), np.asarray(x)
    high = -x[-1, 1]
    near = np.sort(np.abs(s - SEEN).argsort()[:4])
    place = [np.polynomial.Polynomial.fit(s[near], x[near, k], 3)(SEEN) for k in (0, 1)]
    return float(np.linalg.norm(place + np.array([0, high]) - elastica_laid_down(high, SEEN)) / high)


def capstan_error(phi, tension, drag, steep=1.0, end=3 * np.pi, a=1.0, b=3 * np.pi - 1, mu=0.3):
    """By how much the ratio of tensions over the pillar, between two angles, is off the law; drag: what else holds the rope
    per length; steep: the sine of its angle to the pillar's axis, so that its curvature is steep^2 and Q = T + torsion^2 (B = 1)
    grows by mu steep a radian."""
    phi = np.array(phi)
    rope = np.array(tension) + steep**2 * (1 - steep**2) + drag / (mu * steep**2)
    on = (phi > 0) & (phi < end)
    if on.sum() < 5 or np.any(rope[on] <= 0):
        return math.nan
    return float(abs(np.exp(np.diff(np.interp([a, b], phi[on], np.log(rope[on]))) - mu * steep * (b - a))[0] - 1))


# --- tendril -------------------------------------------------------------------------------------

def tendril(options, read):
    """{error, seconds, steps} of the best of up to three runs."""
    best = {}
    for _ in range(3):
        with tempfile.TemporaryDirectory() as scratch:
            file = f"{scratch}/run.h5"
            code, out, err, seconds = execute([TENDRIL, *shlex.split(options), "-output", file], 900)
            if code:
                return {"failed": (err.strip().splitlines() or ["gave up"])[-1][:80], "seconds": seconds, "steps": 0}
            steps, took = re.search(r"(\d+) steps.* ([0-9.]+) s;", out).groups()
            took = min(seconds, float(took))
            if not best or took < best["seconds"]:
                with h5py.File(file) as f:
                    best = {"error": read(f), "seconds": took, "steps": int(steps)}
        if took > 3:
            break
    return best


def bend(options):
    return tendril("-rod_model space -rod_torsion 1 -growth_type none -growth_initial_length 0.7853981633974483 "
                   "-rod_curvature 1 -shape_type straight -tip_force_vector 0,0,7.2 -friction_mu 0 "
                   "-friction_layers 0:1e-2 -ts_max_time 20 -output_interval 20 " + options,
                   lambda f: bend_error(f["shapes/x"][-1, -1], KIRCHHOFF))


def largest_angle(f):
    """Between nodes: of the polynomial through seven."""
    d, s = f["shapes/d1"][-1], f["shapes/s"][:]
    angle = np.degrees(np.arctan2(np.hypot(d[:, 1], d[:, 2]), d[:, 0]))
    near = slice(max(0, angle.argmax() - 3), angle.argmax() + 4)
    top = np.polynomial.Polynomial.fit(s[near], angle[near], 6)
    return max(top(x.real) for x in top.deriv().roots() if abs(x - s[angle.argmax()]) < 2 / len(s))


def twisted(options):
    return tendril(f"-options_file {ROOT}/options/twisted-rod.opts -output_interval 10 " + options,
                   lambda f: abs(largest_angle(f) / ANGLE - 1))


def laid(options):
    with tempfile.NamedTemporaryFile("w", suffix=".txt") as wall:
        wall.write(f"plane 0 0 {-HIGH - 0.01} 0 0 1\n")
        wall.flush()
        return tendril("-rod_model space -growth_type none -growth_initial_length 1 -shape_type straight "
                       f"-rod_weight 0,0,{-WEIGHT} -contact_diameter 0.02 -wall_file {wall.name} -friction_mu 0 "
                       "-friction_layers 0:1e-2 -ts_max_time 1 -output_interval 1 " + options,
                       lambda f: laid_error(f["shapes/s"], f["shapes/x"][-1][:, [0, 2]]))


def rope(scene):
    """The best of up to three runs of a scene of tests/scenes/space/ropes_test.py, which says (run, how far it is off)."""
    best = {}
    scene_runs.TENDRIL = TENDRIL
    for _ in range(3):
        with tempfile.TemporaryDirectory() as scene_runs.SCRATCH:
            before = os.times()
            try:
                run, off = scene()
            except scene_runs.Failure as failure:
                return {"failed": re.search("tendril: (.{1,60})", str(failure).split("exit")[-1])[1], "seconds": 0.1, "steps": 0}
            after = os.times()
        used = after.children_user + after.children_system - before.children_user - before.children_system
        took = min(used, float(re.search(r" ([0-9.]+) s;", run.said).group(1)))
        if not best or took < best["seconds"]:
            best = {"error": abs(off), "seconds": took, "steps": run.steps}
        if took > 3:
            break
    return best


def capstan(options):
    cells, stiffness = options.split()[1::2]
    return rope(lambda: ropes.capstan(1.5, 60, 0.7, stiffness, cells))


def helix(options):
    """A push of 10 comes out, two turns on, as 0.562367828485."""
    cells, stiffness, rtol = options.split()[1::2]

    def pushed():
        run = ropes.duct(28.5, 0, 0.15, stiffness, cells, rtol=rtol)
        line = ropes.Line(run)
        at = brentq(lambda s: line.P(s) - 10, 3, 6)
        return run, line.P(at + TWO_TURNS) / PUSHED_OUT - 1

    return rope(pushed)


def root_bends(options):
    """(So short a rod that friction is nothing.)"""
    return tendril("-growth_type uniform -growth_initial_length 0.002 -ts_max_time 0.002 -shape_type straight -friction_mu 0 "
                   "-tropism_gravity 1000 -tropism_direction 0,-1 -tropism_proprioception 1 -tropism_sensed tip " + options,
                   lambda f: abs(f["series/tip_angle"][-1] / ROOT_ANGLE - 1))


def lengths_at_pushes(f):
    push, length = f["series/base_force_1"][:], f["series/length"][:]
    at = [np.argmax(push > P) for P in PUSHES]
    return [float(np.interp(P, push[i - 1:i + 1], length[i - 1:i + 1])) for P, i in zip(PUSHES, at)]


def injected(options):
    return tendril(f"-options_file {ROOT}/options/injected-tube.opts -output_interval 90 " + options, lengths_at_pushes)


# --- peers ---------------------------------------------------------------------------------------

def peer(name, scene, options):
    """{error, seconds, steps} of a run of scripts/lab/peers/NAME_space.py."""
    script = {"PyElastica": "pyelastica", "MuJoCo": "mujoco", "Exudyn": "exudyn"}[name]
    code, out, err, seconds = execute([os.environ.get("PEERS_PYTHON", str(ROOT / "results/peers/venv/bin/python")),
                                       *([str(PEERS / f"{script}_root.py")] if scene == "root" else
                                         [str(PEERS / f"{script}_space.py"), scene]), *options.split()], 900)
    lines = [json.loads(line) for line in out.splitlines() if line.startswith("{")]
    if len(lines) < 2:
        return {"failed": (err.strip().splitlines() or ["no answer"])[-1][:80], "seconds": seconds, "steps": 0}
    found, cost = lines
    if not code:
        cost["error"] = {"root": lambda: abs(found["angle"] / ROOT_ANGLE - 1),
                         "bend": lambda: bend_error(found["tip"], KIRCHHOFF if name == "MuJoCo" else REISSNER),
                         "twisted": lambda: abs(found["angle"] / ANGLE - 1),
                         "laid": lambda: laid_error(found["s"], found["x"]),
                         "capstan": lambda: capstan_error(found["phi"], found["tension"], found["drag"]),
                         "helix": lambda: capstan_error(found["phi"], found["tension"], found["drag"], STEEP, 5 * np.pi,
                                                        0.5 * np.pi, 4.5 * np.pi)}[scene]()
    return cost


FINEST = "-rod_cells 1000 -ts_rtol 1e-6"
SETTINGS = {
    ("bend", "tendril"): [f"-rod_cells {n} -ts_rtol 1e-2" for n in (4, 6, 8, 16, 32, 64, 128)],
    ("bend", "PyElastica"): [f"-elements {n}" for n in (10, 20, 40, 80)],
    ("bend", "MuJoCo"): ["-elements 8", "-elements 16", "-elements 32 -dt 5e-4"],
    ("bend", "Exudyn"): [f"-elements {n}" for n in (4, 8, 16, 32, 64, 128)],
    ("twisted", "tendril"): [f"-rod_cells {n} -ts_rtol 1e-3" for n in (25, 50, 100, 200, 400)] + [
        "-rod_cells 800 -ts_rtol 1e-4"],
    ("twisted", "PyElastica"): ["-elements 50", "-elements 100", "-elements 200", "-elements 200 -dt 5e-4"],
    ("laid", "tendril"): [f"-rod_cells {n} -contact_stiffness {k} -ts_rtol 1e-3" for n, k in (
        (20, "1e5"), (40, "1e5"), (40, "1e6"), (80, "1e6"), (80, "1e7"), (160, "1e7"), (160, "1e8"), (320, "1e9"))],
    ("laid", "PyElastica"): [f"-elements {n}" for n in (20, 40, 80, 160)],
    ("laid", "MuJoCo"): ["-elements 8 -dt 2e-3 -time 1.5", "-elements 16 -dt 2e-3 -time 1.5",
                         "-elements 32 -dt 2e-3 -time 1.5", "-elements 64 -dt 1e-3 -time 1.5"],
    ("capstan", "tendril"): [f"-rod_cells {n} -contact_stiffness {k}" for n, k in (
        (100, "1e5"), (100, "1e6"), (160, "1e6"), (200, "1e7"), (300, "1e7"))],
    ("capstan", "PyElastica"): [f"-elements {n}" for n in (50, 100)],
    ("helix", "tendril"): [f"-rod_cells {n} -contact_stiffness {k} -ts_rtol {r}" for n, k, r in (
        (70, "1e5", "1e-4"), (100, "1e5", "1e-4"), (140, "1e5", "1e-4"), (200, "1e5", "1e-4"), (200, "3e5", "1e-5"),
        (320, "3e5", "1e-5"))],
    ("helix", "PyElastica"): [f"-elements {n}" for n in (50, 100, 200)],
    ("root", "tendril"): [f"-rod_cells {n} -ts_rtol {r}" for n, r in ((4, "1e-2"), (4, "1e-4"), (6, "1e-6"), (12, "1e-8"))],
    ("root", "PyElastica"): ["-elements 10", "-elements 20", "-elements 40 -dt 1e-4"],
    ("injected", "tendril"): [f"-rod_cells {n} -ts_rtol {r}" for n, r in (
        (100, "1e-4"), (100, "1e-5"), (150, "1e-5"), (200, "1e-5"), (300, "1e-5"), (500, "1e-5"))] + [FINEST],
}
OURS = {"bend": bend, "twisted": twisted, "laid": laid, "capstan": capstan, "helix": helix, "root": root_bends, "injected": injected}


def wanted(choice):
    for (scene, name), settings in SETTINGS.items():
        if scene in choice.only.split(",") and name in choice.methods.split(","):
            for options in settings:
                yield scene, name, options


def run_all(store, choice):
    for scene, name, options in wanted(choice):
        key = f"{scene} {name} {options}"
        if key not in store.runs or choice.again:
            run = OURS[scene](options) if name == "tendril" else peer(name, scene, options)
            store.keep({"key": key, **run})
            print(key, {k: v for k, v in run.items() if k != "key"}, flush=True)


def in_table():
    """{(scene, method, options): row} of docs/notes/chart-space.csv as it is."""
    if not TABLE.exists():
        return {}
    with open(TABLE, newline="") as file:
        rows = [{k: v for k, v in row.items() if v} for row in csv.DictReader(file)]
    return {(r["scene"], r["method"], r["options"]): {k: float(v) if k in ("error", "seconds") else v for k, v in r.items()}
            for r in rows}


def found(store):
    """[{scene, method, options, error, seconds, steps, failed}]"""
    rows, before = [], in_table()
    finest = store.runs.get(f"injected tendril {FINEST}", {}).get("error")
    for (scene, name), settings in SETTINGS.items():
        for options in settings:
            run = store.runs.get(f"{scene} {name} {options}")
            if run and scene == "injected" and "error" in run:  # lengths; without the finest run nothing is known of them
                run = run | {"error": float(np.max(np.abs(np.divide(run["error"], finest) - 1)))} if finest else None
            run = run or before.get((scene, name, options))
            if run and options != FINEST:
                rows.append({"scene": scene, "method": name, "options": options, **run})
    return rows


def draw_column(ax, rows, scene):
    for name, (colour, marker, line) in METHODS.items():
        runs = sorted((r for r in rows if r["scene"] == scene and r["method"] == name), key=lambda r: r["seconds"])
        done = [r for r in runs if math.isfinite(r.get("error", math.nan))]
        best, front = math.inf, []
        for run in done:
            if run["error"] < best:
                best = run["error"]
                front.append(run)
        ax.loglog([r["seconds"] for r in front], [r["error"] for r in front], line, color=colour, zorder=2)
        ax.loglog([r["seconds"] for r in done], [r["error"] for r in done], marker, color=colour, ms=4.5, mew=0.3,
                  mec="black", zorder=3)
        lost = [r for r in runs if r not in done]
        ax.plot([r["seconds"] for r in lost], [1] * len(lost), marker, mfc="none", mec=colour, ms=5, zorder=3)
    ax.set_title(TITLES[scene], fontsize=9)
    ax.set_xlabel("time / s")
    ax.set_ylim(top=2)
    low, high = ax.get_xlim()
    if high < 100 * low:  # a decade at least is marked
        ax.set_xlim(low / 3, high * 3)
    for axis in (ax.xaxis, ax.yaxis):
        axis.set_minor_formatter(plt.NullFormatter())


def draw(rows, base):
    """Four scenes a row; the legend below."""
    scenes = [s for s in TITLES if any(r["scene"] == s for r in rows)]
    with plt.rc_context(STYLE):
        fig, axes = plt.subplots(2, 4, figsize=(9.4, 5.4))
        for ax, scene in zip(axes.flat, scenes):
            draw_column(ax, rows, scene)
        for row in axes:
            row[0].set_ylabel("relative error")
        for ax in axes.flat[len(scenes):]:
            ax.axis("off")
        handles = [plt.Line2D([], [], color=c, marker=m, ls=l, ms=5, mec="black", mew=0.3, label=name)
                   for name, (c, m, l) in METHODS.items()]
        handles.append(plt.Line2D([], [], color="black", marker="o", mfc="none", ls="none", ms=5, label="did not finish"))
        fig.legend(handles=handles, loc="lower center", ncols=len(handles), fontsize=9)
        fig.tight_layout(h_pad=1.5, rect=(0, 0.05, 1, 1))
        fig.savefig(f"{base}.png", dpi=200)
        plt.close(fig)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--only", default=",".join(TITLES), metavar="SCENE,...")
    parser.add_argument("--methods", default=",".join(METHODS), metavar="NAME,...")
    parser.add_argument("--draw", action="store_true", help="only draw what is stored")
    parser.add_argument("--again", action="store_true", help="run also what is stored")
    choice = parser.parse_args()
    store = Store(ROOT / "results" / "chart-space" / "runs.jsonl")
    if not choice.draw:
        run_all(store, choice)
    rows = found(store)
    with open(TABLE, "w", newline="") as file:
        table = csv.DictWriter(file, COLUMNS, extrasaction="ignore", lineterminator="\n")
        table.writeheader()
        for row in rows:
            table.writerow({k: f"{v:.3g}" if isinstance(v, float) else v for k, v in row.items()})
    draw(rows, ROOT / "docs" / "notes" / "chart-space")
    print("docs/notes/chart-space.csv, docs/notes/chart-space.png")


if __name__ == "__main__":
    main()

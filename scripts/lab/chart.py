#!/usr/bin/env python3
"""Speed against accuracy: runs methods over their settings, keeps every run in a table, and draws
error over time and over counted work, a column per scene.

    chart.py [--quick] [--only SCENE,...] [--draw] [--jobs N] [--kept docs/notes/chart.csv]

--kept: the rows of an earlier table stand; only what is new is run. TENDRIL_BEFORE=PROGRAM in the
environment: an earlier version, charted beside this one. --draw: from what is stored, without new runs. Runs go side by side, one to a core."""

import argparse
import csv
import math
from datetime import date
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

from measure import BEFORE, CORES, RIGHT_, SCENES, WRONG, Case, workplace
from tendril.style import STYLE

TITLES = {"decay": "decay to $10^{-13}$, $t = 12$", "short": "thick start, $t = 5$",
          "folded": "folded rod, $t = 40$", "gaussian": "growth zone $a = 0.05$", "feed": "feed",
          "contact": "pushed on a plane (force, height)"}
TOP = 5  # of the error axis
TOLERANCES = ("1e-2", "1e-3", "1e-4", "1e-5", "1e-6", "1e-7", "1e-8")
# name: (solver, colour, marker, line); colours after Okabe and Ito
METHODS = {
    "frame 4, vbdf": ("tendril", "#0072B2", "o", "-"),
    "frame 4, vbdf, 0.1": ("tendril_before", "#0072B2", ".", ":"),
    "frame 2, vbdf": ("tendril", "#56B4E9", "s", "-"),
    "mixed, vbdf": ("tendril", "#009E73", "D", "-"),
    "auto, vbdf": ("tendril", "#CC79A7", "v", "-"),
    "linear, vbdf": ("tendril", "#999999", "^", "-"),
    "frame 4, bdf 2": ("tendril", "#F0E442", "p", "--"),
    "frame 4, bdf 5": ("tendril", "#E69F00", "h", "--"),
    "frame 4, backward Euler": ("tendril", "#D55E00", "X", "--"),
    "mixed, backward Euler": ("tendril", "#8C510A", "P", "--"),
    "paper's elements": ("paper_fem", "#000000", "*", ":"),
    "PyElastica": ("pyelastica_rod", "#666666", "d", ":"),
}
MESHES = {"1e-2": 60, "1e-3": 100, "1e-4": 150, "1e-5": 250, "1e-6": 400, "1e-7": 600,
          "1e-8": 1000}  # an even spatial error beside that of time, for order 4


CONTACT = ("frame 4, vbdf", "frame 2, vbdf", "frame 4, bdf 2", "frame 4, bdf 5",
           "frame 4, backward Euler", "PyElastica")  # who knows contact


def settings(name, scene, quick):
    """The options of a method, coarse to fine."""
    if scene == "contact" and name not in CONTACT:
        return []
    if scene == "contact" and name == "PyElastica":
        fine = ["-elements 10 -dt 3e-4 -radius 0.05 -time 20",
                "-elements 20 -dt 2e-4 -radius 0.04 -time 20",
                "-elements 40 -dt 1.2e-4 -radius 0.03 -time 20",
                "-elements 80 -dt 6e-5 -radius 0.03 -time 20"]
        return fine[:1] if quick else fine
    tolerances = TOLERANCES[1:6:2] if quick else TOLERANCES
    steps = ("0.1", "0.02") if quick else ("0.1", "0.05", "0.02", "0.01", "0.005", "0.002")
    if scene == "contact":  # it lasts 0.0032
        steps = [f"{float(step) / 1000:g}" for step in steps]
    if name in ("frame 4, vbdf", "frame 4, vbdf, 0.1", "auto, vbdf"):
        model = "frame" if name[0] == "f" else "auto"
        even = [f"-rod_model {model} -rod_cells {MESHES[r]} -ts_rtol {r}" for r in tolerances]
        fine = [] if quick else [f"-rod_model {model} -rod_cells {n} -ts_rtol {r}"
                                 for n, r in ((50, "1e-4"), (100, "1e-6"), (200, "1e-4"),
                                              (200, "1e-6"), (500, "1e-4"), (500, "1e-6"),
                                              (500, "1e-7"), (1000, "1e-9"), (1500, "1e-10"))]
        return even + fine
    if name in ("frame 2, vbdf", "mixed, vbdf"):
        model = "frame -rod_order 2" if name[0] == "f" else "mixed"
        pairs = [(100, "1e-4"), (500, "1e-5")] if quick else [
            (100, "1e-3"), (100, "1e-4"), (200, "1e-4"), (500, "1e-5"), (1000, "1e-5"),
            (2000, "1e-6"), (5000, "1e-6")]
        return [f"-rod_model {model} -rod_cells {n} -ts_rtol {r}" for n, r in pairs]
    if name == "linear, vbdf":
        return [f"-rod_model linear -rod_cells {2 * MESHES[r]} -ts_rtol {r}" for r in tolerances]
    if "bdf 2" in name or "bdf 5" in name:
        return [f"-ts_type bdf -ts_bdf_order {name[-1]} -rod_cells {MESHES[r]} -ts_rtol {r}"
                for r in (tolerances[:5] if name[-1] == "2" else tolerances)]
    if "Euler" in name:
        model = "mixed -rod_cells 500" if name[0] == "m" else "frame -rod_cells 200"
        # with PETSc's own start, the last step, Newton's method stalls: a start by extrapolation
        return [f"-ts_type beuler -ts_theta_initial_guess_extrapolate -ts_dt {h} -rod_model {model}"
                for h in steps]
    if name == "paper's elements":
        nel = 200 if scene == "gaussian" else 64  # fine enough: halving the elements changes less
        short = steps if scene in ("short", "gaussian") else steps[:4]  # the others take minutes
        return [f"-dt {h} -nel {nel} -graded" for h in (steps[1:] if quick else short)] + (
            [] if quick else [f"-dt 0.05 -nel {2 * nel} -graded", f"-dt 0.01 -nel {nel} -literal"])
    if scene != "short":  # it takes minutes, and cannot follow a decay to 1e-13
        return [] if quick else ["-elements 20 -dt 3e-5"]
    return ["-elements 10 -dt 3e-5"] if quick else [
        "-elements 10 -dt 3e-5", "-elements 20 -dt 3e-5", "-elements 40 -dt 1.5e-5",
        "-elements 40 -mass 3e-4 -dt 8e-6"]


def limit(slow, quick):
    """Seconds a run may take."""
    if quick:
        return 15 if slow else 5
    return 120 if slow else 30


def cases(arguments):
    """[(scene, method, case)]"""
    result = []
    for scene in arguments.only.split(","):
        for name, (solver, *_) in METHODS.items():
            slow = not solver.startswith("tendril")
            if slow and scene == "contact":
                solver = "pyelastica_contact"
            for options in settings(name, scene, arguments.quick):
                result.append((scene, name, Case(
                    solver, SCENES[scene], options, limit=limit(slow, arguments.quick),
                    repeat=1 if slow or arguments.quick else 3)))
    return result


def take_up(store, wanted, path):
    """Puts the rows of an earlier table into the store, so that only what is new is run."""
    with open(path, newline="") as file:
        rows = {(r["scene"], r["method"], r["options"]): r for r in csv.DictReader(file)}
    for scene, method, case in wanted:
        row = rows.get((scene, method, case.options))
        if not row or case.key in store.runs or row["scene_options"] != case.scene.options:
            continue
        run = {k: row[k] for k in ("scene", "verdict", "reason", "options", "scene_options")}
        run |= {k: float(row[k]) for k in COLUMNS[5:-1] if row.get(k)}
        store.keep({"key": case.key, **run})


def runs(store, arguments):
    """{scene: {method: [run]}}"""
    wanted, found = cases(arguments), {}
    if arguments.kept:
        take_up(store, wanted, arguments.kept)
    if not arguments.draw:
        store.get_all([(scene, case) for scene, _, case in wanted
                       if BEFORE or case.solver != "tendril_before"], arguments.jobs)
    for scene, name, case in wanted:
        if case.key in store.runs:
            run = dict(store.runs[case.key], method=name)
            found.setdefault(scene, {}).setdefault(name, []).append(run)
    return found


def finished(run):
    return run["verdict"] in (RIGHT_, WRONG) and math.isfinite(run["error"]) and run["error"] > 0


def front(all_runs, x):
    """The runs that no other beats in both, cheapest first."""
    best, result = math.inf, []
    for run in sorted(all_runs, key=lambda r: (r[x], r["error"])):
        if run["error"] < best:
            best = run["error"]
            result.append(run)
    return result


def cheapest(all_runs, bound, x="seconds"):
    return min((r for r in all_runs if r["error"] <= bound), key=lambda r: r[x], default=None)


def draw_scene(ax, methods, x):
    good = [r for runs_ in methods.values() for r in runs_ if finished(r) and r.get(x)]
    if not good:
        return
    low = min(r["error"] for r in good)
    pareto, lost = front(good, x), {}
    # a failure stands at the top, at the cost it had
    for name, runs_ in methods.items():
        _, colour, marker, line = METHODS[name]
        done = [r for r in runs_ if finished(r) and r.get(x)]
        own = front(done, x)
        ax.plot([r[x] for r in own], [min(r["error"], TOP) for r in own], line, color=colour, lw=1,
                zorder=2)
        ax.plot([r[x] for r in done], [min(r["error"], TOP) for r in done], marker, color=colour,
                ms=4.5, mew=0.3, mec="black", zorder=3, ls="none")
        for run in runs_:
            if not finished(run) and run.get(x):
                ax.plot(run[x], 3 * TOP, marker, mfc="none", mec=colour, ms=5, mew=1, zorder=3, clip_on=False)
                lost[run["reason"]] = min(run[x], lost.get(run["reason"], math.inf))
    ax.step([r[x] for r in pareto], [min(r["error"], TOP) for r in pareto], where="post",
            color="black", lw=2.5, alpha=0.2, zorder=1)
    ax.set_xscale("log")
    ax.set_yscale("log")
    ax.set_ylim(low / 3, 3.5 * TOP)
    ax.yaxis.set_minor_locator(plt.NullLocator())
    middle = math.prod(ax.get_xlim())**0.5
    for code, first in lost.items():
        ax.annotate(code, (first, 3 * TOP), xytext=(0, 5), textcoords="offset points", fontsize=6, color="0.3",
                    ha="left" if first < middle else "right")


AXES = {"seconds": "wall time / s", "work": "Newton iterations × unknowns"}
# what the README shows: two rods, over time, the methods one would choose among
SHORT_SCENES, SHORT_METHODS = ("decay", "gaussian"), (
    "frame 4, vbdf", "auto, vbdf", "mixed, vbdf", "frame 4, bdf 5", "frame 4, backward Euler",
    "paper's elements", "PyElastica")
ACROSS = 3  # columns of a page


def draw(found, base, over=tuple(AXES)):
    """A column per scene, a row per measure of cost; more scenes than a page has columns go on below."""
    scenes = [s for s in SCENES if s in found]
    names = [n for n in METHODS if any(n in found[s] for s in scenes)]
    columns, blocks = min(ACROSS, len(scenes)), -(-len(scenes) // ACROSS)
    rows, foot = blocks * len(over), 0.75 if len(over) > 1 else 0.85
    width, height = 0.7 + 2.3 * columns, 2.35 * rows + 0.3 * blocks + foot
    with plt.rc_context(STYLE):
        fig, axes = plt.subplots(rows, columns, squeeze=False, figsize=(width, height))
        for ax in axes.flat[len(scenes) * len(over):] if blocks == 1 else ():
            ax.axis("off")
        for k, scene in enumerate(scenes):
            for row, x in enumerate(over):
                ax = axes[k // columns * len(over) + row, k % columns]
                draw_scene(ax, found[scene], x)
                ax.set_xlabel(AXES[x])
                if not k % columns:
                    ax.set_ylabel("largest relative error of\n" r"$\mathbf{x}(1,t)$, $\|x_2\|$, $E$")
                if not row:
                    ax.set_title(TITLES[scene], fontsize=9, pad=14)
        handles = [plt.Line2D([], [], color=METHODS[n][1], marker=METHODS[n][2], ls=METHODS[n][3],
                              ms=5, lw=1, mec="black", mew=0.3, label=n) for n in names]
        handles += [plt.Line2D([], [], color="black", lw=2.5, alpha=0.2, label="Pareto front"),
                    plt.Line2D([], [], color="black", marker="o", mfc="none", ls="none", ms=5,
                               label="did not finish (reason)"),
                    plt.Line2D([], [], ls="none", label=f"errors above {TOP} are drawn at {TOP}")]
        fig.legend(handles=handles, ncol=min(4, columns + 1), loc="lower center", fontsize=8, frameon=False)
        fig.subplots_adjust(left=0.75 / width, right=0.985, bottom=(foot + 0.42) / height,
                            top=1 - 0.45 / height, hspace=0.48, wspace=0.3)
        for suffix in (".png", ".pdf"):
            fig.savefig(f"{base}{suffix}", dpi=200)
        plt.close(fig)


COLUMNS = ("scene", "method", "options", "verdict", "reason", "error", "tip", "norm_x2", "energy",
           "base_force_1", "tip_x2", "estimate", "seconds", "process_seconds", "steps", "rejected", "newton", "work", "scene_options")


def table(found, path):
    with open(path, "w", newline="") as file:
        writer = csv.DictWriter(file, COLUMNS, extrasaction="ignore", lineterminator="\n")
        writer.writeheader()
        for methods in found.values():
            for runs_ in methods.values():
                for run in runs_:
                    writer.writerow({k: f"{v:.4g}" if isinstance(v, float) else v
                                     for k, v in run.items()})


def summary(found, path):
    """The front by name, and how many times longer each method takes: a Markdown table."""
    lines = [f"# How many times longer each method takes, as measured on {date.today():%d %B %Y}", "",
             "By scripts/lab/chart.sh; [chart-and-atlas.md](chart-and-atlas.md) explains it.", "",
             "| scene | error | fastest | s | " + " | ".join(METHODS) + " |",
             "|" + "---|" * (4 + len(METHODS))]
    for scene, methods in found.items():
        everything = [r for runs_ in methods.values() for r in runs_ if finished(r)]
        print(f"{scene}: front", ", ".join(
            dict.fromkeys(r["method"] for r in front(everything, "seconds"))))
        for bound in (1e-2, 1e-4, 1e-6):
            best = cheapest(everything, bound)
            if not best:
                continue
            ones = [cheapest([r for r in methods.get(name, ()) if finished(r)], bound)
                    for name in METHODS]
            lines.append(f"| {scene} | {bound:g} | `{best['options']}` | {best['seconds']:.3f} | "
                         + " | ".join(f"{one['seconds'] / best['seconds']:.2g}" if one else "-"
                                      for one in ones) + " |")
    path.write_text("\n".join(lines) + "\n")


def main():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--quick", action="store_true", help="a coarse matrix, under 3 minutes")
    parser.add_argument("--draw", action="store_true", help="only draw what is stored")
    parser.add_argument("--jobs", type=int, default=CORES, metavar="N", help="runs side by side")
    parser.add_argument("--kept", metavar="CSV", help="take up an earlier table; run what is new")
    parser.add_argument("--only", default=",".join(SCENES), metavar="SCENE,...")
    arguments = parser.parse_args()
    place, store = workplace("chart", arguments.quick)
    found = runs(store, arguments)
    own = {scene: methods for scene, methods in found.items() if scene != "contact"}  # of tip, |x2|, E
    table(found, place / "chart.csv")
    draw(found, Path(place) / "chart")
    few = {s: {m: r for m, r in found[s].items() if m in SHORT_METHODS}
           for s in SHORT_SCENES if s in found}
    if few:
        draw(few, Path(place) / "chart-short", over=("seconds",))
    summary(found, place / "chart-factors.md")
    print(f"chart: {place}/chart.csv, .png, -short.png and -factors.md")


if __name__ == "__main__":
    main()

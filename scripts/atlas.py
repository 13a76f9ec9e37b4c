#!/usr/bin/env python3
"""The atlas of failure: every method on every cell of a grid of rods, with verdict and cost; a
table, a map (methods down, cells across) and a Dolan-More profile.

    atlas.py [--quick] [--methods NAME,...] [--draw] [--jobs N]

--draw: from what is stored, without new runs. Fails if the default loses a cell. Runs go side by
side, one to a core."""

import argparse
import csv
import os
import sys
from concurrent.futures import ThreadPoolExecutor

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

from measure import (CRASHED, DECAY, GAVE_UP, HUNG, REFUSED, RIGHT_, ROOT, THICK, WRONG, Case,
                     Scene, Store, say)
from plot import STYLE

LIMIT, LIMIT_PEER = 15, 60  # seconds; the slowest cell of the default takes 3
FINER = "-rod_cells 1000 -ts_rtol 1e-8"
METHODS = {  # name: (solver, options)
    "default": ("tendril", ""),
    "auto": ("tendril", "-rod_model auto"),
    "frame 2": ("tendril", "-rod_order 2"),
    "mixed": ("tendril", "-rod_model mixed"),
    "linear": ("tendril", "-rod_model linear"),
    "PETSc's bdf 5": ("tendril", "-ts_type bdf -ts_bdf_order 5"),
    "PETSc's bdf 2": ("tendril", "-ts_type bdf -ts_bdf_order 2"),
    "backward Euler, start extrapolated": ("tendril", "-ts_type beuler -ts_dt 0.01"),
    "backward Euler, start at last step":  # as PETSc has it
        ("tendril", "-ts_type beuler -ts_theta_initial_guess_extrapolate 0 -ts_dt 0.01"),
    "primal Newton": ("tendril", "-friction_newton primal"),
    "primal, backtracking": ("tendril", "-friction_newton primal -snes_linesearch_type bt"),
    "backtracking": ("tendril", "-snes_linesearch_type bt"),
    "MUMPS": ("tendril", "-pc_factor_mat_solver_type mumps"),
    "GMRES, ILU": ("tendril", "-ksp_type gmres -pc_type ilu"),
    "paper's elements": ("paper_fem", "-dt 0.01 -nel 128 -graded"),
    "paper's elements, step 0.002": ("paper_fem", "-dt 0.002 -nel 128 -graded"),
    "paper's, taken literally": ("paper_fem", "-dt 0.01 -nel 64 -literal"),
    "PyElastica": ("pyelastica_rod", "-elements 20 -dt 3e-5"),
}
QUICK_METHODS = ("default", "mixed", "linear", "backward Euler, start at last step",
                 "primal Newton", "paper's, taken literally")


def scene(group, label, options, times):
    return group, Scene(label, options, times, finer=FINER)


def cells(quick):
    """[(group, scene)]"""
    result = []
    for mu in ("1", "0.5", "0"):
        for beta in ("1e-1", "1e-3", "1e-6", "1e-9", "1e-12", "0"):
            if mu == "0.5" and beta not in ("1e-3", "1e-9", "0"):
                continue
            if mu == "0" and beta != "1e-3":
                continue  # beta is of the dry share alone
            result.append(scene(rf"decay and fold, $t=20$: $\mu$, $\beta$", f"{mu}, {beta}",
                                f"{DECAY} -friction_mu {mu} -friction_beta {beta}", (8, 14, 20)))
    for mu in ("1", "0"):
        for growth in ("uniform", "5", "0.5", "0.05", "0.005", "feed"):
            law = (f"-growth_type {growth}" if growth[0] in "uf" else
                   f"-growth_type gaussian -growth_width {growth}")
            result.append(scene(r"growth, $t=10$: $\mu$, law or width $a$", f"{mu}, {growth}",
                                f"{THICK} {law} -friction_mu {mu}", (2, 6, 10)))
    for amplitude in ("1e-15", "1e-8", "1e-2", "0.5", "1.5", "3.1"):
        result.append(scene(r"amplitude $\epsilon$, $t=16$",
                            "hairpin" if amplitude == "3.1" else amplitude,
                            f"-growth_initial_length 2 -shape_amplitude {amplitude}", (2, 8, 16)))
    for length in ("0.25", "10", "30"):
        result.append(scene("$L_0$, $t=5$", length,
                            f"-growth_initial_length {length} -shape_amplitude 0.1", (1, 5)))
    return result[::4] if quick else result


NUMBERS = ([("cells $N$", n, f"-rod_cells {n}") for n in
            ("10", "20", "50", "200", "1000", "4000", "10000")] +
           [("tolerance", r, f"-ts_rtol {r}") for r in
            ("1e-2", "1e-3", "1e-4", "1e-5", "1e-7", "1e-8", "1e-9")])
STEPS = [("step", h, f"-ts_dt {h}") for h in ("0.5", "0.1", "0.05", "0.01", "0.002")]


SETTINGS = tuple(dict.fromkeys(n[0] for n in NUMBERS + STEPS))  # groups without a claim
SET = ("default", "frame 2", "mixed", "primal Newton", "PETSc's bdf 5",
       "backward Euler, start extrapolated")  # the methods whose settings are varied


def never(method, group):
    """Explicit, with inertia, PyElastica cannot follow the decay; a small step of the paper's
    elements takes minutes there."""
    return "decay" in group and method in ("PyElastica", "paper's elements, step 0.002")


def cases(arguments):
    """[(method, group, label, case)]"""
    names = arguments.methods.split(",") if arguments.methods else (
        QUICK_METHODS if arguments.quick else METHODS)
    result = []
    for group, where in cells(arguments.quick):
        for method in names:
            solver, options = METHODS[method]
            limit = LIMIT if solver == "tendril" else LIMIT_PEER
            if not never(method, group):
                result.append((method, group, where.name, Case(solver, where, options, limit)))
    if arguments.quick:
        return result
    thick = Scene("thick", THICK, (2, 6, 10), finer=FINER)
    for method in (m for m in SET if m in names):
        euler = "Euler" in method
        for group, label, more in (n for n in NUMBERS + STEPS
                                   if n[0] != ("tolerance" if euler else "step")):
            options = f"{METHODS[method][1].replace('-ts_dt 0.01', '')} {more}".strip()
            if euler and group != "step":
                options += " -ts_dt 0.01"
            result.append((method, group, label, Case("tendril", thick, options, limit=30)))
    return result


def measure_all(store, arguments):
    """[(method, group, label, run)]"""
    wanted = cases(arguments)
    again = [w[3].key for w in wanted if w[0] in arguments.again.split(",")]
    if not arguments.draw:
        new = [w for w in wanted if w[3].key not in store.runs or w[3].key in again]
        print(f"atlas: {len(new)} of {len(wanted)} runs to do, {arguments.jobs} at a time")
        with ThreadPoolExecutor(arguments.jobs) as pool:
            list(pool.map(store.reference, dict.fromkeys(w[3].scene for w in new)))
            for run in pool.map(lambda w: dict(store.get(w[3], again=w[3].key in again),
                                               scene=w[2]), new):
                say(run)
    return [(*w[:3], store.runs[w[3].key]) for w in wanted if w[3].key in store.runs]


# verdict: (colour, letter); Okabe and Ito, and the letter says the same
LOOK = {RIGHT_: ("#a6d5f0", ""), WRONG: ("#E69F00", "w"), GAVE_UP: ("#F5E663", "g"),
        REFUSED: ("#e4e4e4", "n"), CRASHED: ("#D55E00", "c"), HUNG: ("#7a4fa3", "h")}

NAMES = {RIGHT_: "right (seconds)",
         HUNG: f"hung, or over {LIMIT} s; peers {LIMIT_PEER} s (h)"}


def cost(seconds):
    return f"{seconds:.2f}"[1 if seconds < 0.995 else 0:] if seconds < 1.95 else f"{seconds:.0f}"


def draw_map(found, base):
    groups = {}
    for _, group, label, _ in found:
        groups.setdefault(group, {})[label] = None
    methods = [m for m in METHODS if any(f[0] == m for f in found)]
    columns, gap = {}, 0.6
    at = 0.0
    for group, labels in groups.items():
        for label in labels:
            columns[group, label] = at
            at += 1
        at += gap
    with plt.rc_context(STYLE):
        fig, ax = plt.subplots(figsize=(2 + 0.22 * at, 1.7 + 0.2 * len(methods)))
        for method, group, label, run in found:
            x, y = columns[group, label], methods.index(method)
            colour, letter = LOOK[run["verdict"]]
            ax.add_patch(plt.Rectangle((x - 0.5, y - 0.5), 1, 1, fc=colour, ec="white", lw=0.6))
            text = letter if run["verdict"] != RIGHT_ else cost(run["seconds"])
            ax.text(x, y, text, ha="center", va="center", fontsize=5 if not letter else 7,
                    color="white" if run["verdict"] in (HUNG, CRASHED) else "black")
        ax.set_yticks(range(len(methods)), methods)
        ax.set_xticks(list(columns.values()), [label for _, label in columns], rotation=90,
                      fontsize=7)
        for k, (group, labels) in enumerate(groups.items()):
            first = columns[group, next(iter(labels))]
            ax.text(first - 0.5, -0.75, group, fontsize=7, ha="left", va="bottom",
                    rotation=0 if len(labels) > 5 else 18)
        ax.set_xlim(-0.7, at - gap - 0.3)
        ax.set_ylim(len(methods) - 0.5, -0.6)
        ax.tick_params(length=0)
        for side in ax.spines.values():
            side.set_visible(False)
        handles = [plt.Rectangle((0, 0), 1, 1, fc=LOOK[v][0], ec="none",
                                 label=NAMES.get(v, f"{v} ({LOOK[v][1]})")) for v in LOOK]
        fig.legend(handles=handles, ncol=6, loc="lower center", fontsize=7)
        fig.tight_layout(rect=(0, 0.05, 1, 1))
        for suffix in (".png", ".pdf"):
            fig.savefig(f"{base}{suffix}", dpi=200)
        plt.close(fig)


def draw_profile(found, base):
    """Share of cells solved right within tau times the time of the fastest right method there."""
    grid = [f for f in found if f[1] not in SETTINGS]
    fastest = {}
    for _, group, label, run in grid:
        if run["verdict"] == RIGHT_:
            key = group, label
            fastest[key] = min(fastest.get(key, np.inf), max(run["seconds"], 1e-3))
    total = len({(g, l) for _, g, l, _ in grid})
    tau = np.logspace(0, 3, 400)
    styles = ("-", "--", ":", "-.")
    colours = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#000000")
    with plt.rc_context(STYLE):
        fig, ax = plt.subplots(figsize=(6.4, 3.4))
        for k, method in enumerate(m for m in METHODS if any(f[0] == m for f in grid)):
            ratios = np.array([max(run["seconds"], 1e-3) / fastest[g, l]
                               for m, g, l, run in grid if m == method
                               and run["verdict"] == RIGHT_])
            share = [(ratios <= t * (1 + 1e-9)).sum() / total for t in tau]
            ax.step(tau, share, where="post", color=colours[k % 5], ls=styles[k // 5],
                    lw=2 if method == "default" else 1.1, label=method)
        ax.set_xscale("log")
        ax.set_xlim(1, 1e3)
        ax.set_ylim(0, 1.02)
        ax.set_xlabel(r"$\tau$, time over that of the fastest right method")
        ax.set_ylabel(r"share of the cells solved right within $\tau$")
        ax.legend(loc="center left", bbox_to_anchor=(1.01, 0.5), fontsize=7, handlelength=2.4)
        fig.tight_layout()
        for suffix in (".png", ".pdf"):
            fig.savefig(f"{base}-profile{suffix}", dpi=200)
        plt.close(fig)


COLUMNS = ("method", "group", "cell", "verdict", "reason", "error", "tip", "norm_x2", "energy",
           "seconds", "steps", "rejected", "newton", "reached", "options", "scene_options",
           "message")


def table(found, path):
    with open(path, "w", newline="") as file:
        writer = csv.DictWriter(file, COLUMNS, extrasaction="ignore", lineterminator="\n")
        writer.writeheader()
        for method, group, label, run in found:
            row = dict(run, method=method, group=group, cell=label)
            writer.writerow({k: f"{v:.4g}" if isinstance(v, float) else v for k, v in row.items()})


def summary(found):
    """Counts per method; the cells that the default lost."""
    grid = [f for f in found if f[1] not in SETTINGS]
    for method in METHODS:
        own = [f[3] for f in grid if f[0] == method]
        if own:
            counts = {v: sum(r["verdict"] == v for r in own) for v in LOOK}
            print(f"{method:36}", ", ".join(f"{n} {v}" for v, n in counts.items() if n),
                  f"; {sum(r['seconds'] for r in own):.0f} s")
    lost = [f for f in grid if f[0] == "default" and f[3]["verdict"] != RIGHT_]
    for _, _, _, run in lost:
        print(f"LOST by the default: {run['verdict']} {run['reason']} error "
              f"{run.get('error', float('nan')):.1e}: tendril {run['scene_options']} "
              f"{run['options']}  {run['message']}")
    return len(lost)


def main():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--quick", action="store_true", help="fewer cells, under 3 minutes")
    parser.add_argument("--draw", action="store_true", help="only draw what is stored")
    parser.add_argument("--jobs", type=int, default=len(os.sched_getaffinity(0)), metavar="N",
                        help="runs side by side")
    parser.add_argument("--methods", default="", metavar="NAME,...")
    parser.add_argument("--again", default="", metavar="METHOD,...", help="repeat these")
    arguments = parser.parse_args()
    place = ROOT / ("results/atlas-quick" if arguments.quick else "docs")
    place.mkdir(parents=True, exist_ok=True)
    store = Store(ROOT / "results" / ("atlas-quick" if arguments.quick else "atlas") / "runs.jsonl")
    found = measure_all(store, arguments)
    table(found, place / "atlas.csv")
    draw_map(found, place / "atlas")
    draw_profile(found, place / "atlas")
    lost = summary(found)
    print(f"atlas: {len(found)} runs; {place}/atlas.csv, .png, -profile.png; "
          f"cells lost by the default: {lost}")
    return lost > 0


if __name__ == "__main__":
    sys.exit(main())

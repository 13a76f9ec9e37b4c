#!/usr/bin/env python3
"""What is told of errors in contact, at the end and over the run, beside what is true: random scenes of plane and space
that touch, at the defaults, each against two references with two at a time of: a hundredth of the tolerance, contact a
hundred times as stiff, twice the cells. The larger difference counts.

    scripts/lab/coverage_contact.py --tendril build/tendril SEED COUNT [--kinds plane,head-on,walls,ropes]
                [--first 0] [--store FILE.csv]

COUNT scenes of each kind are drawn, by fuzz.py (plane), stiffer.py (head-on), fuzz_walls.py and fuzz_ropes.py (in space).
One that touches nothing, does not come to its end within LIMIT seconds of a processor, or has no reference within
REFERENCE_LIMIT is left out. The largest true error over the run is that at the same time, from a hundredth of the run on. References are
kept under /tmp/coverage-contact-SEED: another program at the same scenes needs no new ones, as long as its contact is as
stiff. Rows are added to FILE one by one; what is in it is not run again."""

import argparse
import csv
import random
import sys
from pathlib import Path

import coverage
import fuzz
import fuzz_ropes
import fuzz_walls
import numpy as np
import stiffer

LIMIT, REFERENCE_LIMIT, STEPS = 6, 20, 40
PAIRS = (("steps", "stiff"), ("stiff", "cells"))
SEEN = ("tip", "norm_x2", "energy")
HEAD = ["seed", "kind", "number", *(f"{what}_{which}_{name}" for which in ("end", "most") for what in ("told", "true")
                                            for name in SEEN), "when", "why", "options"]


def plane(R, files):
    o = fuzz.contact_scene(fuzz.Draw(R.random()), False, files)
    return {**o, "rod_cells": R.choice([60, 100, 160]), "ts_max_time": round(min(o["ts_max_time"], R.uniform(3, 8)), 3)}


def head_on(R, files):
    return with_walls(*stiffer.head_on(R), files)


def walls(R, files):
    o, _, lines = fuzz_walls.scene(R)
    if not lines:
        return None
    return with_walls({**o, "rod_cells": R.choice([40, 60]), "rod_model": "space"}, lines, files)


def ropes(R, files):
    folder = files.parent / f"{files.name}-files"
    folder.mkdir(exist_ok=True)
    _, o = fuzz_ropes.scene(R.randrange(10**6), 0, folder, [R.choice(list(fuzz_ropes.KINDS))])
    return o


def with_walls(o, lines, files):
    path = Path(f"{files}.walls")
    path.write_text("\n".join(lines) + "\n")
    return {**o, "wall_file": path}


KINDS = {"plane": plane, "head-on": head_on, "walls": walls, "ropes": ropes}


def reference_options(options, pair, run, attributes):
    used, extra = {k: v for k, v in options.items() if k != "contact_rtol"}, []
    rtol = coverage.tolerance(attributes)
    if "stiff" in pair:
        used["contact_stiffness"] = f"{100 * float(attributes['contact_stiffness']):.6g}"
    if "cells" in pair:
        used["rod_cells"] = 2 * run["cells"]
    if "steps" in pair:
        extra = ["-ts_rtol", f"{rtol / 100:g}"]
    return used, extra


def true_over_run(run, fine):
    """The largest relative errors at the same time: at some of the steps, those at which most is told among them."""
    later = np.flatnonzero(run["t"] > 0.01 * run["t"][-1])
    picked = [later[::max(1, len(later) // STEPS)], [len(run["t"]) - 1]]
    for name in SEEN:
        if len(run.get(f"error_{name}", ())):
            picked.append(later[np.argsort(run[f"error_{name}"][later])[-5:]])
    steps = np.unique(np.concatenate(picked).astype(int))
    errors = [np.where(coverage.counts(run, i), np.min([coverage.errors_at(run, fine, i, points, logarithm) for points in (2, 4, 6)
                                                        for logarithm in (True, False)], axis=0), 0) for i in steps]
    return np.min([coverage.errors_at(run, fine, len(run["t"]) - 1, points) for points in (2, 4)], axis=0), np.max(errors, axis=0)


def measure(exe, options, directory):
    """Told and true at the end, told and true over the run, when and why; or a text: what went wrong."""
    file = str(directory / f"run-{coverage.os.getpid()}.h5")
    done = coverage.execute(exe, options, file, LIMIT)
    if done.returncode:
        return f"lost: {done.returncode} {done.stderr.strip()[-100:]}"
    if ", contact " not in done.stdout:
        return "free"
    run, attributes = coverage.series(file)
    with coverage.h5py.File(file) as f:
        run |= {f"error_{name}": f[f"series/error_{name}"][:] for name in SEEN if f"series/error_{name}" in f}
    run["natural"] = max(abs(float(options.get(k, 0))) for k in coverage.NATURAL)
    true = []
    for pair in PAIRS:
        used, extra = reference_options(options, pair, run, attributes)
        fine = coverage.reference(exe, used, directory, extra)
        if isinstance(fine, str):
            return f"no reference: {fine[-100:]}"
        true.append(true_over_run(run, fine))
    end, largest = np.max(true, axis=0)
    told = [np.array([float(attributes[f"error_{which}{name}"]) for name in SEEN]) for which in ("end_", "")]
    most = SEEN[int(np.argmax(told[1]))]
    return told[0], end, told[1], largest, f"{float(attributes[f'error_when_{most}']) / run['t'][-1]:.3f}", attributes[f"error_why_{most}"].decode()


def share(values):
    return f"{100 * np.mean(values):.0f} %"


def summary(kind, rows):
    told_end, true_end, told_most, true_most = (np.array([[float(r[f"{what}_{name}"]) for name in SEEN] for r in rows])
                                                for what in ("told_end", "true_end", "told_most", "true_most"))
    lines = []
    for which, told, true in (("at the end", told_end, true_end), ("over the run", told_most, true_most)):
        for of, a, b in (("all", told.max(1), true.max(1)), *((name, told[:, k], true[:, k]) for k, name in enumerate(SEEN))):
            ratio = np.minimum(a, 1) / np.maximum(np.minimum(b, 1), 1e-12)
            good = (ratio >= 1) | (b < 1e-12)
            lines.append(f"{kind} {which}, {of}: {len(rows)} scenes, above {share(good)}, within 10 {share(good & (ratio <= 10))}, "
                         f"within 100 or below 1e-5 {share(good & ((ratio <= 100) | (a < 1.01e-5)))}; quartiles "
                         + ", ".join(f"{q:.2g}" for q in np.quantile(ratio, (0.05, .25, .5, .75, .95)))
                         + f"; told 1 and more where it is below 1e-2: {np.sum((a >= 1) & (b < 1e-2))}, 0.1 and more: "
                         f"{np.sum((a >= .1) & (b < 1e-2))}")
    return "\n".join(lines)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("seed", type=int)
    parser.add_argument("count", type=int, help="scenes of each kind")
    parser.add_argument("--tendril", default="build/tendril")
    parser.add_argument("--kinds", default=",".join(KINDS))
    parser.add_argument("--first", type=int, default=0, help="leaves out so many of each kind")
    parser.add_argument("--store", type=Path, help="a table, CSV, to which rows are added")
    choice = parser.parse_args()
    coverage.REFERENCE_LIMIT = REFERENCE_LIMIT
    directory, rows, left_out = Path(f"/tmp/coverage-contact-{choice.seed}"), [], {}
    directory.mkdir(exist_ok=True)
    kept = {}
    if choice.store and choice.store.exists():
        with choice.store.open(newline="") as file:
            kept = {(r["seed"], r["kind"], r["number"]): r for r in csv.DictReader(file)}
    draws = {kind: random.Random(f"{choice.seed} {kind}") for kind in choice.kinds.split(",")}
    for i in range(choice.count):
        for kind, R in draws.items():
            files = directory / f"{kind}-{i}"
            options = KINDS[kind](R, files)
            if options is None or i < choice.first:
                continue
            row = kept.get((str(choice.seed), kind, str(i)))
            if not row:
                found = measure(choice.tendril, options, directory)
                words = coverage.words_of(options, directory, None)
                if isinstance(found, str):
                    left_out[found.split(":")[0]] = left_out.get(found.split(":")[0], 0) + 1
                    print(kind, i, found, words, flush=True)
                    continue
                numbers = [f"{v:.2e}" for group in (found[0], found[1], found[2], found[3]) for v in group]
                row = dict(zip(HEAD, [choice.seed, kind, i, *numbers, *found[4:], words]))
                if choice.store:
                    new = not choice.store.exists()
                    with choice.store.open("a", newline="") as file:
                        writer = csv.DictWriter(file, HEAD, lineterminator="\n")
                        if new:
                            writer.writeheader()
                        writer.writerow(row)
            rows.append(row)
            print(*(row[k] for k in HEAD[1:]), flush=True)
    for kind in [*draws, "all"]:
        own = [r for r in rows if kind in ("all", r["kind"])]
        if own:
            print(summary(kind, own))
    print("left out:", left_out or "none")


if __name__ == "__main__":
    sys.exit(main())

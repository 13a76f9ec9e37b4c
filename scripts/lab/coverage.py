#!/usr/bin/env python3
"""How often the error estimate of a run is an upper one: random scenes of fuzz.py at the defaults,
each against four times its cells and a hundredth of its tolerance.

    coverage.py EXE SEED COUNT [--kinds plain,wide,world,contact,hard] [--end 6] [--accuracy 1e-4]
                [--store FILE.csv]

The true error is the largest relative one of tip, |x2| and energy from a hundredth of the run on. Prints a
line a scene and the share in which the estimate is above it, or below by at most 3. With --accuracy that
is asked for, and the last column says whether it was met, or the program said that it was not."""

import argparse
import csv
import re
import subprocess
import sys
from pathlib import Path

import fuzz
import h5py
import numpy as np

SCENES = {"plain": lambda draw, files: fuzz.plain_scene(draw, False),
          "wide": lambda draw, files: fuzz.plain_scene(draw, True),
          "world": lambda draw, files: fuzz.world_scene(draw, False, files),
          "contact": lambda draw, files: fuzz.contact_scene(draw, False, files),
          "hard": lambda draw, files: fuzz.hard_scene(draw, False, files)}
SEEN = ("tip_x1", "tip_x2", "norm_x2", "energy")


def series(file):
    with h5py.File(file) as f:
        return {k: f["series"][k][:] for k in ("t", *SEEN)}, dict(f.attrs)


def at(s, name, t):
    """A series at a time: the polynomial through six steps about it, of the logarithm if it keeps its sign."""
    first = int(np.clip(np.searchsorted(s["t"], t) - 3, 0, max(0, len(s["t"]) - 6)))
    times, values = s["t"][first:first + 6], s[name][first:first + 6]
    weights = [np.prod([(t - b) / (a - b) for b in times if b != a]) for a in times]
    if np.all(values > 0):
        return float(np.exp(np.dot(weights, np.log(values))))
    return float(np.dot(weights, values))


def true_error(run, fine):
    """The largest relative error of a run, in (tip, norm, energy)."""
    times = run["t"][run["t"] > 0.01 * run["t"][-1]]
    times = np.unique(np.append(times[::max(1, len(times) // 60)], run["t"][-1]))
    worst = np.zeros(3)
    for t in times:
        i = int(np.abs(run["t"] - t).argmin())
        x1, x2, norm, energy = (at(fine, k, t) for k in SEEN)
        tip = np.hypot(run["tip_x1"][i] - x1, run["tip_x2"][i] - x2) / np.hypot(x1, x2)
        worst = np.maximum(worst, [tip, abs(run["norm_x2"][i] / norm - 1) if norm else 0,
                                   abs(run["energy"][i] / energy - 1) if energy else 0])
    return worst


def execute(exe, options, file, limit, extra=()):
    command = [exe, *(word for k, v in options.items() for word in (f"-{k}", str(v))), *extra]
    return subprocess.run(["prlimit", f"--cpu={limit}", *command, "-output", file], capture_output=True,
                          text=True, check=False), command[1:]


def measure(exe, options, file, accuracy, extra=()):
    """(true error, estimate, said that it is not met, command) or what went wrong"""
    extra = [*extra, *(["-accuracy", str(accuracy)] if accuracy else [])]
    done, command = execute(exe, options, file, 60, extra)
    if done.returncode:
        return f"lost: {done.stderr.strip()[-150:]} {' '.join(command)}"
    estimate = float(re.search(r"error estimate (\S+?)[,; ]", done.stdout.replace("\n", " ") + " ").group(1))
    run, attributes = series(file)
    with h5py.File(file) as f:
        cells = f["shapes/s"].shape[0] - 1
    used = {k: v for k, v in options.items()}
    if "contact_stiffness" in attributes:
        used["contact_stiffness"] = float(attributes["contact_stiffness"])
    rtol = 1e-6
    found = re.search(r"-ts_rtol (\S+)", str(attributes.get("options", "")))
    rtol = float(found.group(1)) if found else rtol
    done, _ = execute(exe, used, file, 150, ["-rod_cells", str(4 * cells), "-ts_rtol", f"{max(1e-12, rtol / 100):g}"])
    if done.returncode:
        return f"no reference: {done.stderr.strip()[-100:]} {' '.join(command)}"
    return true_error(run, series(file)[0]), estimate, "is not met" in done.stdout, " ".join(command)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("exe")
    parser.add_argument("seed", type=int)
    parser.add_argument("count", type=int, help="scenes of each kind")
    parser.add_argument("--kinds", default="plain,wide,world,contact,hard")
    parser.add_argument("--end", type=float, default=6, help="latest end of a run")
    parser.add_argument("--accuracy", type=float)
    parser.add_argument("--store", type=Path, help="a table, CSV")
    arguments = parser.parse_args()
    directory, rows = Path(f"/tmp/coverage-{arguments.seed}"), []
    directory.mkdir(exist_ok=True)
    for kind in arguments.kinds.split(","):
        draw = fuzz.Draw(arguments.seed)
        for i in range(arguments.count):
            options = SCENES[kind](draw, directory / f"{kind}-{i}")
            options["ts_max_time"] = min(float(options["ts_max_time"]), arguments.end)
            found = measure(arguments.exe, options, str(directory / "run.h5"), arguments.accuracy)
            if isinstance(found, str):
                print(kind, found, flush=True)
                continue
            error, estimate, refused, command = found
            rows.append([kind, f"{estimate:.1e}", *(f"{e:.1e}" for e in error), f"{estimate / max(error.max(), 1e-12):.2g}",
                         command.replace(f"{directory}/", "")])
            print(" ".join(rows[-1]), flush=True)
    ratios = {kind: np.array([float(row[5]) for row in rows if row[0] == kind]) for kind in arguments.kinds.split(",")}
    ratios["all"] = np.array([float(row[5]) for row in rows])
    for kind, r in ratios.items():
        if len(r):
            print(f"{kind}: {len(r)} scenes, estimate above the error in {100 * np.mean(r >= 1):.0f} %, not below a third of "
                  f"it in {100 * np.mean(r >= 1 / 3):.0f} %; quartiles of their ratio "
                  + ", ".join(f"{q:.2g}" for q in np.quantile(r, (0, .25, .5, .75, 1))))
    if arguments.store:
        with arguments.store.open("w", newline="") as file:
            writer = csv.writer(file, lineterminator="\n")
            writer.writerow(["kind", "estimate", "tip", "norm", "energy", "ratio", "options"])
            writer.writerows(rows)


if __name__ == "__main__":
    sys.exit(main())

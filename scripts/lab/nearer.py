#!/usr/bin/env python3
"""What scenes with contact cost, beside how far they are from what they should be: this program, and an earlier one.

    scripts/lab/nearer.py [--tendril build/tendril] [--before PROGRAM [--before-options DIRECTORY]]
                          [--references DIRECTORY] [--scenes NAME,NAME] [--repeat N] [--picture FILE] [--store FILE]

The scenes are those of options/ in which a rod touches most. A reference has two of: a tolerance of 1e-7, contact 100
times stiffer, twice the cells; it is made once, into the directory, and takes minutes. Errors are relative: of the tip's
place, and of the energy, the median over the run (by time) and that at its end; against the reference that is nearer.
Seconds are those of user time, the programs in turn, their ratio the median of N pairs. The picture has a point for each
scene and program, cost against error, joined."""

import argparse
import csv
import os
import re
import resource
import subprocess
import sys
from pathlib import Path

import h5py
import numpy as np
from scipy.interpolate import PchipInterpolator

ROOT = Path(__file__).resolve().parents[2]
ENVIRONMENT = dict(os.environ, OMP_NUM_THREADS="1", OMPI_ALLOW_RUN_AS_ROOT="1", OMPI_ALLOW_RUN_AS_ROOT_CONFIRM="1")
# what is run to its end takes long: up to where, the cells, and a stiffness that is as good as rigid
SCENES = {"cable-conduit": (None, 500, 5.39e6), "packing": (16, 500, 2e6), "tube-heap": (10, 150, 5e6),
          "tube-contact": (None, 500, 2.5e6), "duct-bends": (10, 150, 1e7), "vine-maze": (None, 200, 1.8e7),
          "injected-tube": (70, 500, 5e6), "vessel-branch": (None, 120, 3.1e6)}
SUMMARY = re.compile(r"(\d+) steps, (\d+) rejected, (\d+) Newton iterations")
OF = ("tip, median", "tip, end", "energy, median", "energy, end")
ENOUGH, WORSE = 1e-4, 1.2  # an error that small is no matter; what an error may grow by


def options_of(name, directory):
    end = SCENES[name][0]
    return ["-options_file", f"{name}.opts", *(["-ts_max_time", str(end)] if end else [])], Path(directory)


def run(program, name, directory, output, more=()):
    """Steps, iterations and seconds of user time, or None."""
    options, where = options_of(name, directory)
    before = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime
    done = subprocess.run(["nice", str(Path(program).resolve()), *options, *more, "-output", str(output)], cwd=where, check=False,
                          capture_output=True, text=True, env=ENVIRONMENT)
    found = SUMMARY.search(done.stdout)
    if not found:
        print(f"{program} {name}: {done.stdout[-200:]} {done.stderr[-300:]}", file=sys.stderr)
        return None
    Path(output).with_suffix(".log").write_text(done.stdout + done.stderr)
    return int(found[1]), int(found[3]), resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime - before


def references(program, name, directory):
    """The files of a scene's references, made if they are not there."""
    _, cells, stiffness = SCENES[name]
    stiff = ["-contact_stiffness", str(stiffness)]
    kinds = {"a": ["-ts_rtol", "1e-7", *stiff], "b": ["-ts_rtol", "1e-5", "-rod_cells", str(2 * cells), *stiff]}
    for kind, more in kinds.items():
        file = directory / f"{name}.{kind}.h5"
        if not file.exists():
            run(program, name, ROOT / "options", file, more)
    return [file for kind in kinds if (file := directory / f"{name}.{kind}.h5").exists()]


def series(file):
    """Times, place of the tip, energy."""
    with h5py.File(file) as h:
        get = lambda name: h[f"series/{name}"][:] if f"series/{name}" in h else 0 * h["series/t"][:]
        return get("t"), np.stack([get(f"tip_x{d}") for d in (1, 2, 3)], axis=1), get("energy")


def errors(file, reference):
    """Of OF."""
    (t, tip, energy), (at, its_tip, its_energy) = series(file), series(reference)
    keep = np.r_[True, np.diff(at) > 0]
    at, its_tip, its_energy = at[keep], its_tip[keep], its_energy[keep]
    inside = (t <= at[-1]) & (t > 0)
    t, tip, energy = t[inside], tip[inside], energy[inside]
    there, then = PchipInterpolator(at, its_tip)(t), PchipInterpolator(at, its_energy)(t)
    off = [np.linalg.norm(tip - there, axis=1) / np.linalg.norm(there, axis=1),
           np.abs(energy - then) / np.maximum(then, 1e-3 * its_energy.max())]
    even = np.linspace(0.01, 1, 1000) * t[-1]
    return np.array([value for e in off for value in (np.median(np.interp(even, t, e)), e[-1])])


def picture(rows, file):
    """Cost against the largest of a scene's four errors, before and now."""
    import matplotlib
    matplotlib.use("Agg")
    import matplotlib.pyplot as plt
    from matplotlib.ticker import LogLocator, NullFormatter, ScalarFormatter
    figure, axes = plt.subplots(1, 2, figsize=(11, 4.5), sharey=True)
    for panel, cost, label in ((axes[0], "iterations", "Newton iterations"), (axes[1], "seconds", "seconds of user time")):
        for k, (name, row) in enumerate(rows.items()):
            points = [(row[who][cost], max(row[who]["errors"])) for who in ("before", "now") if who in row]
            panel.loglog(*zip(*points), "-", color=f"C{k}", lw=1)
            panel.loglog(*points[-1], "o", color=f"C{k}", label=name)
            if len(points) > 1:
                panel.loglog(*points[0], "o", mfc="white", color=f"C{k}")
        panel.set_xlabel(label)
        panel.xaxis.set_major_locator(LogLocator(subs=(1, 2, 5)))
        panel.xaxis.set_major_formatter(ScalarFormatter())
        panel.xaxis.set_minor_formatter(NullFormatter())
    axes[0].set_ylabel("largest error: tip, energy; median, end")
    axes[1].legend(fontsize=8, title="full: now; hollow: before", title_fontsize=8)
    figure.tight_layout()
    figure.savefig(file, dpi=130)


def measure(name, programs, directory, repeat):
    """Of each program: steps, iterations, seconds, errors; the ratio of seconds."""
    work = directory / "runs"
    work.mkdir(parents=True, exist_ok=True)
    files, row, seconds = references(programs["now"][0], name, directory), {}, {who: [] for who in programs}
    for _ in range(repeat):
        for who, (program, options) in programs.items():
            file = work / f"{name}.{who}.h5"
            ran = run(program, name, options, file)
            if ran is None:
                return None
            seconds[who].append(ran[2])
            row[who] = {"steps": ran[0], "iterations": ran[1]}
    for who in programs:
        off = [errors(work / f"{name}.{who}.h5", file) for file in files]
        row[who].update(seconds=min(seconds[who]), errors=np.min(off, axis=0))
    if "before" in row:
        row["ratio"] = float(np.median([a / b for a, b in zip(seconds["now"], seconds["before"])]))
    return row


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--tendril", default=str(ROOT / "build" / "tendril"))
    parser.add_argument("--options", default=str(ROOT / "options"))
    parser.add_argument("--before")
    parser.add_argument("--before-options", help="its directory of options, if they were others")
    parser.add_argument("--references", type=Path, default=ROOT / "results" / "references")
    parser.add_argument("--scenes", default=",".join(SCENES))
    parser.add_argument("--repeat", type=int, default=1)
    parser.add_argument("--picture")
    parser.add_argument("--store")
    given = parser.parse_args()
    programs = {"now": (given.tendril, given.options)}
    if given.before:
        programs = {"before": (given.before, given.before_options or given.options), **programs}
    rows, kept, of = {}, 0, 0
    for name in given.scenes.split(","):
        row = measure(name, programs, given.references, given.repeat)
        if row is None:
            continue
        rows[name] = row
        for who in programs:
            r = row[who]
            print(f"{name:14} {who:6} {r['steps']:5} steps {r['iterations']:6} iterations {r['seconds']:6.1f} s  "
                  + "  ".join(f"{e:.1e}" for e in r["errors"]), flush=True)
        if "ratio" in row:
            good = [now <= max(ENOUGH, WORSE * then) for now, then in zip(row["now"]["errors"], row["before"]["errors"])]
            kept, of = kept + sum(good), of + len(good)
            print(f"{'':14} seconds {row['ratio']:.2f}, iterations {row['now']['iterations'] / row['before']['iterations']:.2f}"
                  + "".join(f"; worse: {what}" for what, g in zip(OF, good) if not g), flush=True)
    if given.before and rows:
        ratios = [row["ratio"] for row in rows.values()]
        print(f"geometric mean of seconds {np.exp(np.mean(np.log(ratios))):.2f}, at most {max(ratios):.2f}; of {of} errors "
              f"{kept} at most {WORSE} times those before, or below {ENOUGH:g}")
    if given.store:
        with open(given.store, "w", newline="", encoding="utf-8") as file:
            table = csv.writer(file, lineterminator="\n")
            table.writerow(["scene", "program", "steps", "iterations", "seconds", *OF])
            for name, row in rows.items():
                for who in programs:
                    r = row[who]
                    table.writerow([name, who, r["steps"], r["iterations"], f"{r['seconds']:.2f}", *(f"{e:.2e}" for e in r["errors"])])
    if given.picture and rows:
        picture(rows, given.picture)
    return 0


if __name__ == "__main__":
    sys.exit(main())

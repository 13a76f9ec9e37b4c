#!/usr/bin/env python3
"""Checks -accuracy: the measured error of tip, |x2| and energy on the scenes of options/ and on
scenes drawn at random, against much finer runs. (Contact is held against exact answers:
contact.py.)

    accuracy.py [--tolerances 1e-2,1e-4,1e-6] [--scenes 10] [--seed 1] [--store FILE]

A line per run; the error must lie between a hundredth of what was asked and what was asked."""

import argparse
import csv
import os
import random
import re
import sys
from pathlib import Path

from measure import CORES, DECAY, ROOT, Case, Scene, Store, from_reference

# scenes of options/ with a reference: its file, the options
INDEPENDENT = {"uniform-dry": ("v_decay_mu1", DECAY),
               "uniform-half": ("v_decay_mu05", DECAY + " -friction_mu 0.5"),
               "uniform-viscous": ("v_decay_mu0", DECAY + " -friction_mu 0")}


def read_options(path):
    """{'friction_mu': '1', ...} of an options file; the files that it names, from the project's root"""
    options = {}
    for line in path.read_text().splitlines():
        words = line.split("#")[0].split()
        if words:
            beside = path.parent / " ".join(words[1:])
            options[words[0].lstrip("-")] = (str(beside.relative_to(ROOT)) if beside.is_file() else
                                             " ".join(words[1:]))
    return options


def times_of(end):
    return tuple(round(f * end, 1) for f in (0.1, 0.25, 0.5, 0.75, 1))


def scene_of(name, options):
    """A scene, measured at five times, its reference an independent one where there is one, else a
    run with a tolerance far below those asked for."""
    end = float(options.get("ts_max_time", 40))
    if name in INDEPENDENT:
        return from_reference(name, INDEPENDENT[name][1], INDEPENDENT[name][0], (1.5, 8, 12, 40))
    text = " ".join(f"-{k} {v}" for k, v in options.items()
                    if k not in ("ts_max_time", "output_interval", "task", "stop_length",
                                 "rod_cells", "ts_rtol"))  # -accuracy chooses the last two
    return Scene(name, text, times_of(end),
                 finer="|".join(f"-rod_cells 1200 -ts_rtol {r}" for r in ("2e-11", "1e-10", "1e-9")))


def scenes_of_options():
    for path in sorted((ROOT / "options").glob("*.opts")):
        options = read_options(path)
        if options.get("task", "grow") == "grow" and not any(
                re.match("shape_file|growth_table|restart|rod_curvature_file|wall_file|"
                         "contact_self", k)
                for k in options):
            yield scene_of(path.stem, options)


def scenes_at_random(n, seed):
    draw = random.Random(seed)
    for i in range(n):
        growth = draw.choice(("uniform", "uniform", "gaussian", "feed"))
        options = {"growth_type": growth,
                   "growth_initial_length": f"{draw.uniform(0.4, 3):.2f}",
                   "friction_mu": f"{draw.choice((0, 1, draw.random())):.2f}",
                   "friction_beta": f"{10 ** draw.uniform(-6, -1):.1e}",
                   "shape_type": draw.choice(("sag", "random")),
                   "shape_amplitude": f"{10 ** draw.uniform(-4, -0.5):.1e}",
                   "ts_max_time": f"{draw.choice((5, 10, 20, 30)):g}"}
        if options["shape_type"] == "random":
            options["shape_seed"] = str(draw.randrange(1000))
        if growth == "gaussian":
            options["growth_width"] = f"{10 ** draw.uniform(-1.5, 0.5):.3f}"
        yield scene_of(f"random-{i + 1}", options)


def here(name):
    """A file named from where one stands."""
    return Path(name).resolve()


def main():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--tolerances", default="1e-2,1e-4,1e-6")
    parser.add_argument("--scenes", type=int, default=10, help="drawn at random")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--store", type=here, default=ROOT / "results/accuracy/runs.jsonl")
    parser.add_argument("--jobs", type=int, default=CORES, help="runs side by side")
    parser.add_argument("--again", action="store_true", help="repeat runs that are in the store")
    parser.add_argument("--output", type=here, help="a table, CSV")
    arguments = parser.parse_args()
    os.chdir(ROOT)
    store, missed, table = Store(arguments.store), 0, []
    scenes = [*scenes_of_options(), *scenes_at_random(arguments.scenes, arguments.seed)]
    wanted = {(scene, asked): Case("tendril", scene, f"-accuracy {asked}", limit=300)
              for scene in scenes for asked in arguments.tolerances.split(",")}
    store.get_all([(scene.name, case) for (scene, _), case in wanted.items()], arguments.jobs,
                  [case.key for case in wanted.values()] if arguments.again else ())
    for scene in scenes:
        for asked in arguments.tolerances.split(","):
            run = store.runs[wanted[scene, asked].key]
            ratio = run.get("error", float("inf")) / float(asked)
            met = 0.01 <= ratio <= 1
            missed += not met
            table.append([scene.name, scene.options, asked, f"{run.get('error', 0):.2e}",
                          f"{run.get('estimate', 0):.1e}", f"{run['seconds']:.3f}",
                          run.get("steps"), "yes" if met else "no"])
            print(f"{scene.name:16} asked {asked:6} error {run.get('error', 0):8.1e} "
                  f"estimate {run.get('estimate', 0):8.1e} {run['seconds']:6.2f} s  "
                  f"{'met' if met else 'MISSED  ' + run['verdict'] + ' ' + scene.options} "
                  f"{run['message']}", flush=True)
    if arguments.output:
        with arguments.output.open("w", newline="") as file:
            writer = csv.writer(file, lineterminator="\n")
            writer.writerow(["scene", "options", "asked", "error", "estimate", "seconds", "steps",
                             "met"])
            writer.writerows(table)
    print(f"accuracy: {missed} of {len(table)} runs missed the asked error")
    return missed > 0


if __name__ == "__main__":
    sys.exit(main())

#!/usr/bin/env python3
"""Whether tendril.fit finds a hidden truth, and whether its intervals are what they say: scenes with
synthetic photographs and series made from a run of another model of the rod, mixed, on many cells, with errors of 1 % of the width, over and over with others.

    PYTHONPATH=scripts .venv/bin/python scripts/lab/fit_trial.py [--seeds 20] [--first 1] \\
      [--errors independent,smooth,shifted,tracker,strays] [SCENE ...]

Prints a line a fit, and at the end the table of docs/notes/fitting-measured.md."""

import argparse
import os
import sys
import tempfile
import time
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

import tendril
from tendril.comparing import finer, shape_at
from tendril.units import with_unit

NOISE = 0.01  # of the width
# how points err, in parts of NOISE x width: (each by itself, smoothly along the rod over a tenth of its
# length, a photograph as a whole, the share of points that are somewhere else)
ERRORS = {"independent": (1, 0, 0, 0), "smooth": (0, 1, 0, 0), "shifted": (0.5, 0, 0.5, 0),
          "tracker": (0.2, 0.5, 0.5, 0), "strays": (1, 0, 0, 0.05)}

PLACES = {}  # of the points that were last measured, on the rod from 0 to 1, by their time


@dataclass
class Trial:
    """A scene, what of it is hidden, what is measured."""

    scene: dict
    hidden: dict  # parameter -> its truth
    bounds: dict  # parameter -> (low, high)
    end: str | float  # last time
    photographs: int = 8
    points: int = 40  # of a photograph
    series: list = field(default_factory=list)
    options: dict = field(default_factory=dict)  # with {parameter} in their text
    left_out: dict = field(default_factory=dict)  # what the truth has, and the scene that is fitted has not
    truth: dict = field(default_factory=lambda: {"rod_model": "mixed", "rod_cells": 1200, "ts_rtol": 1e-7})

    def run(self):
        """The run that is photographed."""
        values = {name: str(value) for name, value in self.hidden.items()}
        texts = {name: text.format_map(values) for name, text in self.options.items()}
        used = "".join(self.options.values())
        direct = {name: value for name, value in self.hidden.items() if "{" + name + "}" not in used}
        end, unit = with_unit(self.end)
        return tendril.run(self.scene | self.left_out, **self.truth, ts_max_time=self.end,
                           output_interval=f"{end / 80}{unit}", **texts, **direct)


TUBE = dict(growth_type="feed", growth_initial_length="1cm", si_bending_stiffness="2.209Nmm^2",
            si_speed="5mm/s", friction_beta=1e-6, shape_type="straight")
FED = (TUBE, {"si_friction_dry": "0.62N/m", "rod_curvature": "3.7/m"},
       {"si_friction_dry": ("0.1N/m", "2N/m"), "rod_curvature": ("-10/m", "10/m")}, "40s")
TRIALS = {
    "fed tube": Trial(*FED),
    "viscous, too": Trial(*FED, left_out={"si_friction_viscous": "62Ns/m^2"}),
    "a little viscous": Trial(*FED, left_out={"si_friction_viscous": "12Ns/m^2"}),
    "twice across": Trial(*FED, left_out={"friction_across": 2}),
    "a load on the tip": Trial(*FED, left_out={"tip_force": "3mN"}),
    "softer at the tip": Trial(*FED, left_out={"rod_stiffness_file": {"distance": ([0, 2, 4, 8], "cm"), "factor": [0.4, 0.6, 0.8, 1]}}),
    "uniform": Trial(dict(growth_type="uniform", growth_initial_length=1, shape_type="straight"),
                     {"friction_mu": 0.7, "friction_across": 1.4, "rod_curvature": 0.15},
                     {"friction_mu": (0, 1), "friction_across": (0.5, 3), "rod_curvature": (-0.5, 0.5)},
                     12, series=["base_force_1"]),
    "root in a layer": Trial(dict(growth_type="apical", growth_initial_length=1, tip_law="resistance",
                                  friction_beta=1e-6, shape_type="straight"),
                             {"growth_zone": 1.8, "hard": 3.4, "tip_force": 0.9, "rod_curvature": 0.11},
                             {"growth_zone": (0.5, 4), "hard": (1, 10), "tip_force": (0.1, 3),
                              "rod_curvature": (-0.4, 0.4)}, 10,
                             options={"friction_layers": "0:0.3,3:{hard}"}),
}


def smooth(random, place, reach):
    """[n, 2], errors that are alike over a reach along the rod: a normal process with a Gauss kernel."""
    kernel = np.exp(-((place[:, None] - place) / reach) ** 2 / 2) + 1e-9 * np.eye(len(place))
    return np.linalg.cholesky(kernel) @ random.normal(size=(len(place), 2))


def measure(trial, r, seed, place, errors="independent"):
    """CSV files of photographs, points in no order, and of series, with noise."""
    random = np.random.default_rng(seed)
    si = "si_length" in r.attributes
    length = r.scale("length") if si else 1
    times = np.linspace(0, r.shapes.t[-1], trial.photographs + 1)[1:]
    noise, rows = NOISE * r.series.width[-1] * length, []
    own, along, whole, strays = ERRORS[errors]
    count = 60 if errors == "tracker" else trial.points
    for t in times:
        line = finer(shape_at(r, t)) * length
        s = np.concatenate([[0], np.cumsum(np.hypot(*np.diff(line, axis=0).T))])
        at = np.sort(random.choice(len(line), count, replace=False))
        points = line[at] + noise * own * random.normal(size=(count, 2))
        points = points + noise * along * smooth(random, s[at], 0.1 * s[-1]) * bool(along)
        points = points + noise * whole * random.normal(size=2)
        astray = random.random(count) < strays
        points[astray] += 40 * noise * random.normal(size=(astray.sum(), 2))
        order, time_told = random.permutation(count), t * (r.scale("time") if si else 1)
        rows += [(time_told, *p) for p in points[order]]
        PLACES[float(time_told)] = (s[at] / s[-1])[order]
    files = [write(place / "photographs.csv", ("t (s),x1 (m),x2 (m)" if si else "t,x1,x2"), rows)]
    for name in trial.series:  # its noise is 1 % of its own largest value
        t = np.linspace(0, r.series.t[-1], 41)[1:]
        values = np.interp(t, r.series.t, r.series[name])
        values = values + NOISE * np.abs(values).max() * random.normal(size=t.shape)
        files.append(write(place / f"{name}.csv", f"t,{name}", np.column_stack([t, values])))
    return files


def write(path, head, rows):
    path.write_text("\n".join([head, *(",".join(repr(float(v)) for v in row) for row in rows)]) + "\n")
    return path


def attempt(trial, r, seed, place, errors):
    """(which intervals hold the truth, half of each over the truth, seconds, seconds of all cores, runs,
    how far the estimates are from the truth, over it, whether the fit trusts itself)"""
    begin, before = time.perf_counter(), sum(os.times()[:4])
    found = tendril.fit(trial.scene, measure(trial, r, seed, place, errors), trial.bounds, **trial.options)
    seconds, cores = time.perf_counter() - begin, sum(os.times()[:4]) - before
    truth = {name: with_unit(value)[0] for name, value in trial.hidden.items()}
    inside = {name: low <= truth[name] <= high for name, (low, high) in found.intervals.items()}
    width = {name: (high - low) / 2 / abs(truth[name])
             for name, (low, high) in found.intervals.items()}
    estimates = ", ".join(f"{name} {value:.5g}{'' if inside[name] else ' (!)'}"
                          for name, value in found.values.items())
    print(f"seed {seed}: {estimates}; {found.problem.count} runs, {seconds:.0f} s, {cores:.0f} s of cores"
          f"{'' if found.trusted else '; not to be trusted'}", flush=True)
    for words in [*found.indistinct, *found.warnings]:
        print(f"  {words}", flush=True)
    off = {name: found.values[name] / truth[name] - 1 for name in truth}
    return inside, width, seconds, cores, found.problem.count, off, found.trusted


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scenes", nargs="*", metavar="SCENE", help=f"of {', '.join(TRIALS)}; default: those that leave nothing out")
    parser.add_argument("--seeds", type=int, default=20)
    parser.add_argument("--first", type=int, default=1, help="seed")
    parser.add_argument("--errors", default="independent", help=f"of {', '.join(ERRORS)}")
    choice = parser.parse_args()
    rows = []
    for name in choice.scenes or [name for name, trial in TRIALS.items() if not trial.left_out]:
        trial = TRIALS[name]
        r = trial.run()
        for errors in choice.errors.split(","):
            print(f"{name}, {errors}: {', '.join(f'{k} {v}' for k, v in trial.hidden.items())}", flush=True)
            with tempfile.TemporaryDirectory(prefix="tendril-") as place:
                found = [attempt(trial, r, seed, Path(place), errors)
                         for seed in range(choice.first, choice.first + choice.seeds)]
            rows += lines(name, errors, trial, found)
    print("| scene | errors | hidden | truth | interval (median) | scatter, two deviations | holds the truth "
          "| trusted | runs | longest fit | of all cores, median and most |\n" + "|---" * 11 + "|")
    print("\n".join(rows))


def lines(name, errors, trial, found):
    """Of the table, one a parameter."""
    for parameter, truth in trial.hidden.items():
        held = sum(one[0][parameter] for one in found)
        reach, off = np.median([one[1][parameter] for one in found]), [one[5][parameter] for one in found]
        seconds, cores, runs = zip(*(one[2:5] for one in found))
        yield (f"| {name} | {errors} | {parameter} | {truth} | ±{100 * reach:.2g} % | "
               f"±{200 * np.sqrt(np.mean(np.square(off))):.2g} % | {held} of {len(found)} | {sum(one[6] for one in found)} | "
               f"{np.median(runs):.0f} | {max(seconds):.0f} s | {np.median(cores):.0f} s, {max(cores):.0f} s |")


if __name__ == "__main__":
    sys.exit(main())

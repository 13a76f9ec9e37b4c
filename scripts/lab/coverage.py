#!/usr/bin/env python3
"""How often the error estimate of a run is an upper one: random scenes of fuzz.py at the defaults,
each against three times its cells and a hundredth of its tolerance, where friction is exact behind a
growth zone also against a beta far smaller than that which tolerance allows.

    coverage.py EXE SEED COUNT [--kinds plain,wide,world,senses,yields,contact,hard,space,space-world,moving,linear,linear-world]
                [--end 6] [--cells N] [--accuracy 1e-4] [--store FILE.csv]

The true error is the largest relative one of tip, |x2| and energy from a hundredth of the run on (and
as far behind a time at which there is no |x2|, or no energy). Prints a line a scene and the share in which the
estimate is above it, or below by at most 3. With --accuracy that is asked for, and it is counted how often it was met,
and how often the program said that it was not. Where rods snap, another reference, which follows no snap, says whether
they are on the right side (see fuzz.py). References are kept beside the results, under /tmp/coverage-SEED: another
program at the same scenes needs no new ones, as long as its
cells are the same. Rows are added to FILE one by one, and scenes that are in it are not measured again: what was
interrupted goes on with the same command."""

import argparse
import csv
import hashlib
import os
import re
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

import fuzz
import h5py
import numpy as np


def linear_scene(draw, files):
    """Options by name: a wide scene of a rod so straight that the linear model has it for most of the run, if not for all."""
    return next_to_straight(draw, fuzz.plain_scene(draw, True))


def next_to_straight(draw, o):
    for name in ("rod_curvature", "rod_curvature_random", "clamp_angle", "tip_type"):  # a held tip wants a rod that is bent
        o.pop(name, None)
    return {**o, "shape_amplitude": draw.over_decades(1e-12, 1e-4), "rod_model": "auto"}


def moving_scene(draw, files):
    """Options by name: a rod in space, at rest at first in half of the scenes, and a wall that moves towards it or past it."""
    o = fuzz.space_scene(draw, False, files)
    for name in ("shape_amplitude", "shape_turn", "shape_seed", "tip_type", "clamp_direction"):
        o.pop(name, None)
    o.update(shape_type="straight", growth_initial_length=.5, contact_diameter=draw.between(.04, .12), ts_max_time=2)
    o["wall_file"] = fuzz.random_surfaces(draw, f"{files}.walls", o["contact_diameter"])
    moves = "moves " + " ".join(str(draw.between(-.2, .2)) for _ in range(3))
    path = Path(o["wall_file"])
    line, rubs, friction = path.read_text().strip().partition(" friction ")
    path.write_text(f"{line} {moves}{rubs}{friction}\n")
    if draw.happens(.5):
        for name in ("growth_width", "growth_zone"):
            o.pop(name, None)
        o["growth_type"] = "none"
    return o


SCENES = {"plain": lambda draw, files: fuzz.plain_scene(draw, False),
          "wide": lambda draw, files: fuzz.plain_scene(draw, True),
          "world": lambda draw, files: fuzz.world_scene(draw, False, files),
          "senses": lambda draw, files: fuzz.senses_scene(draw),
          "yields": lambda draw, files: fuzz.senses_scene(draw, True),
          "contact": lambda draw, files: fuzz.contact_scene(draw, False, files),
          "hard": lambda draw, files: fuzz.hard_scene(draw, False, files),
          "space": lambda draw, files: fuzz.space_scene(draw, False, files),
          "space-world": lambda draw, files: fuzz.space_world_scene(draw, False, files),
          "moving": moving_scene,
          "linear": linear_scene,
          "linear-world": lambda draw, files: next_to_straight(draw, fuzz.world_scene(draw, False, files))}
SEEN = ("tip_x1", "tip_x2", "tip_x3", "norm_x2", "norm_x3", "energy", "length")
NAMES = ("tip", "norm", "energy")
LIMIT, REFERENCE_LIMIT = 40, 60    # seconds of a processor
SLIGHT = 1.5e-5                   # share of friction by which a reference is not off
OTHER_SIDE = 0.05                 # of the length: so far off a rod is on another side
NEXT_TO_EXACT = 1e-13             # of references: the program takes 9e-10 at its own tolerance
ROUNDING = 2.2e-16                # of k0^2 L: an energy that is none, of a rod bent or twisted by nature
NATURAL = ("rod_curvature", "rod_curvature_2", "rod_curvature_random", "rod_curvature_random_2", "rod_twist")
DIGITS_END = 1e-300               # an energy below has few of them
BEND_IN_CONTACT = 0.01            # of rods that touch: errors are parts of what they are where bent by this angle, at least
SNAP_OFF = 2e-4                   # of the run: so much earlier or later a rod may snap


@dataclass
class Measured:
    """What was found of one scene."""

    command: str
    errors: np.ndarray  # true ones, as NAMES says
    estimate: float
    refused: bool       # the program says that what was asked for may not be met
    wrong_side: bool = False

    @property
    def ratio(self):
        """Of the estimate to the true error; one of 1 says that nothing is known, which is never too low."""
        return min(self.estimate, 1) / max(min(self.errors.max(), 1), 1e-12)


def series(file):
    """Times and what is SEEN, with the file's attributes."""
    with h5py.File(file) as f:
        s = {k: f["series"][k][:] for k in ("t", "contact_force", *SEEN) if k in f["series"]}
        s["cells"] = f["shapes/s"].shape[0] - 1
        attributes = {k: f.attrs[k] for k in f.attrs}
    return s, attributes


def at(s, name, t, points, logarithm):
    """A series at a time: the polynomial through so many steps about it, of the logarithm if that is wanted and it
    keeps its sign; else, of norms, of the square, which is smooth where they all but vanish."""
    first = int(np.clip(np.searchsorted(s["t"], t) - points // 2, 0, max(0, len(s["t"]) - points)))
    times, values = s["t"][first:first + points], s[name][first:first + points]
    weights = [np.prod([(t - b) / (a - b) for b in times if b != a]) for a in times]
    if logarithm and np.all(values > 0):
        return float(np.exp(np.dot(weights, np.log(values))))
    if name.startswith("norm"):
        return float(np.sqrt(max(0, np.dot(weights, values**2))))
    return float(np.dot(weights, values))


def errors_at(run, fine, i, points, logarithm=True, t=None):
    """The relative errors of tip, |x2| (in space the larger one of |x2| and |x3|) and energy at a run's step, against
    the reference then or at t."""
    other = {k: at(fine, k, run["t"][i] if t is None else t, points, logarithm) for k in SEEN if k in fine}
    tip = [k for k in ("tip_x1", "tip_x2", "tip_x3") if k in other]
    off = np.sqrt(sum((run[k][i] - other[k]) ** 2 for k in tip)) / np.sqrt(sum(other[k] ** 2 for k in tip))
    norms = [k for k in ("norm_x2", "norm_x3") if other.get(k)]
    bend = BEND_IN_CONTACT if np.any(run.get("contact_force", np.zeros(1))[:i + 1]) else 0
    size = max([other[k] for k in norms], default=0)
    norm = max((abs(run[k][i] - other[k]) / max(size, bend * run["length"][i] / 3 ** .5) for k in norms), default=0)
    energy = abs(run["energy"][i] - other["energy"]) / max(other["energy"], bend ** 2 / (2 * run["length"][i]), DIGITS_END)
    return np.array([off, norm, energy if other["energy"] > DIGITS_END else 0])


def near_in_time(run, fine, i):
    """The relative errors at a run's step against the reference a little earlier or later."""
    t, reach = run["t"][i], SNAP_OFF * run["t"][-1]
    steps = fine["t"][(fine["t"] > t - reach) & (fine["t"] < t + reach)]
    others = np.interp(np.linspace(0, len(steps), 4 * len(steps)), np.arange(len(steps)), steps) if len(steps) else []
    return min((errors_at(run, fine, i, 2, t=other) for other in others), key=max, default=np.full(3, np.inf))


def counts(run, i):
    """Are errors of tip, |x2| and energy counted at a step? From a hundredth of the run behind that on at which there was
    nothing of it at last; what was there before it vanished counts, too."""
    values = (run["length"], np.maximum(run["norm_x2"], run.get("norm_x3", 0)), run["energy"])
    least = (0, 1e-280, ROUNDING * run.get("natural", 0) ** 2 * run["length"])
    nothing = [run["t"][:i + 1][(v <= of)[:i + 1]] for v, of in zip(values, least)]
    return [run["t"][i] > 0.01 * run["t"][-1] + (t[-1] if len(t) else 0) for t in nothing]


def true_errors(run, fine, snaps):
    """The largest relative errors of a run from a hundredth of it on: of several polynomials through the
    reference's steps that which is nearest, for where a rod is torn off or touches none goes through many. Where it
    snaps it may do so a little earlier or later."""
    steps = np.flatnonzero(run["t"] > 0.01 * run["t"][-1])
    steps = np.unique(np.append(steps[::max(1, len(steps) // 60)], len(run["t"]) - 1))
    worst = []
    for i in steps:
        errors = np.min([errors_at(run, fine, i, points, logarithm) for points in (2, 4, 6)
                         for logarithm in (True, False)], axis=0)
        if snaps and errors.max() > 1e-5:
            errors = min(errors, near_in_time(run, fine, i), key=max)
        worst.append(np.where(counts(run, i), errors, 0))
    return np.max(worst, axis=0)


def words_of(options, directory, accuracy):
    """What a scene is called in tables: its options, the files' folder left out."""
    asked = ["-accuracy", str(accuracy)] if accuracy else []
    return " ".join([*(word for k, v in options.items() for word in (f"-{k}", str(v))), *asked]).replace(f"{directory}/", "")


def execute(exe, options, file, limit, extra=()):
    command = [exe, *(word for k, v in options.items() for word in (f"-{k}", str(v))), *extra]
    return subprocess.run(["prlimit", f"--cpu={limit}", *command, "-output", file], capture_output=True,
                          text=True, check=False)


def contents(options):
    """What a scene is: its options, and what is in the files that they name."""
    return repr([(k, Path(str(v)).read_bytes() if k.endswith(("_file", "_field", "_table", "_path")) else str(v))
                 for k, v in sorted(options.items())])


def reference(exe, options, directory, extra):
    """A series, as it was kept or as it is computed now; a text: it failed."""
    kept = directory / (hashlib.sha256((contents(options) + repr(extra)).encode()).hexdigest()[:20] + ".npz")
    if not kept.exists():
        file = str(directory / f"reference-{os.getpid()}.h5")
        done = execute(exe, options, file, REFERENCE_LIMIT, extra)
        said = "" if not done.returncode else f"{done.returncode} {done.stderr.strip()[-100:]}"
        share = re.search(r"; viscous share (\S+)", done.stdout)
        if share and float(share[1]) > SLIGHT:  # it could not follow a snap of dry friction, and is of another rod
            said = "it snaps, and needs a viscous share for it"
        np.savez(kept, said=said, **({} if said else series(file)[0]))
    with np.load(kept) as found:
        said = str(found["said"])
        return said if said else {k: found[k] for k in found.files}


def tolerance(attributes):
    """That of a run's steps where contact does not ease it: as given, or as the scene has it (an earlier program does not say it)."""
    found = re.search(r"-ts_rtol ([\d.e+-]+)", str(attributes.get("options", "")))
    return float(found[1]) if found else float(attributes.get("parameters/ts_rtol", 1e-6))


def reference_options(run, attributes, options, accuracy):
    """Those of three times the cells and a hundredth of the tolerance. The stiffness of contact follows from the
    diameter; where an accuracy is asked for, that of rigid contact is, and it is as much larger as such cells allow."""
    used = {k: v for k, v in options.items() if k not in ("rod_cells", "contact_rtol")}
    if accuracy and "contact_stiffness" in attributes:
        used["contact_stiffness"] = f"{3 ** 4 * float(attributes['contact_stiffness']):g}"
    rtol = tolerance(attributes)
    if used.get("rod_model") in ("auto", "linear"):
        used["rod_model"] = "frame"
    if used.get("growth_type") == "apical" and float(used.get("friction_beta", 1)) == 0 and float(used["friction_mu"]) > 0:
        used["friction_beta"] = NEXT_TO_EXACT
    return used, ["-rod_cells", str(3 * run["cells"]), "-ts_rtol", f"{max(1e-12, rtol / 100):g}"]


def on_another_side(exe, options, directory, run):
    """Is its tip elsewhere than that of a rod in small steps with a viscous share, which follows no snap?"""
    end = float(options["ts_max_time"])
    used = {**options, "friction_mu": min(float(options["friction_mu"]), 0.999)}
    fine = reference(exe, used, directory, ["-ts_dt", "1e-12", "-ts_rtol", "1e-7", "-ts_adapt_dt_max", f"{end / 500:g}"])
    if isinstance(fine, str):
        return False
    off = np.linalg.norm([run[k][-1] - fine[k][-1] for k in ("tip_x1", "tip_x2", "tip_x3") if k in run])
    return off > OTHER_SIDE * run["length"][-1]


def measure(exe, options, directory, accuracy):
    """What was found of a scene, or a text: what went wrong."""
    file = str(directory / f"run-{os.getpid()}.h5")
    done = execute(exe, options, file, LIMIT, ["-accuracy", str(accuracy)] if accuracy else [])
    words = words_of(options, directory, accuracy)
    if done.returncode:
        return f"lost: {done.returncode} {done.stderr.strip()[-150:]} {words}"
    said = done.stdout.replace("\n", " ") + " "
    estimate = re.search(r"error estimate (\S+?)[,; ]", said)
    run, attributes = series(file)
    run["natural"] = max(abs(float(options.get(k, 0))) for k in NATURAL)
    used, extra = reference_options(run, attributes, options, accuracy)
    fine = reference(exe, used, directory, extra)
    if isinstance(fine, str):
        return f"no reference: {fine} {words}"
    snaps = re.search(r"; \d+ snap", said) is not None
    told = float(attributes.get("error_estimate", estimate.group(1)))
    if ", contact " in said and not accuracy:  # the reference has the same stiffness
        told = sum(float(attributes.get(f"error_{part}", 0)) for part in ("space", "time", "friction"))
    found = Measured(words, true_errors(run, fine, snaps), told, "may not be met" in said)
    if snaps and "contact_diameter" not in options:
        found.wrong_side = on_another_side(exe, options, directory, run)
    return found


class Table:
    """Rows of a file, added one by one; none: nothing is kept."""

    HEAD = ["seed", "kind", "accuracy", "estimate", *NAMES, "ratio", "doubted", "options"]

    def __init__(self, path, seed, accuracy):
        self.path, self.seed, self.accuracy, self.rows = path, seed, accuracy or "", {}
        if path and path.exists():
            with path.open(newline="") as file:
                self.rows = {tuple(row[k] for k in ("seed", "kind", "accuracy", "options")): row for row in csv.DictReader(file)}

    def find(self, kind, words):
        """What is there of a scene, or None."""
        row = self.rows.get((str(self.seed), kind, str(self.accuracy), words))
        return row and Measured(words, np.array([float(row[k]) for k in NAMES]), float(row["estimate"]), row["doubted"] == "yes")

    def add(self, kind, m):
        if not self.path:
            return
        new = not self.path.exists()
        with self.path.open("a", newline="") as file:
            writer = csv.writer(file, lineterminator="\n")
            if new:
                writer.writerow(self.HEAD)
            writer.writerow([self.seed, kind, self.accuracy, f"{m.estimate:.1e}", *(f"{e:.1e}" for e in m.errors),
                             f"{m.ratio:.2g}", ("yes" if m.refused else "no") if self.accuracy else "", m.command])


def summary(kind, found, accuracy):
    ratios = np.array([m.ratio for m in found])
    words = (f"{kind}: {len(found)} scenes, estimate above the error in {100 * np.mean(ratios >= 1):.0f} %, not below a "
             f"third of it in {100 * np.mean(ratios >= 1 / 3):.0f} %; quartiles of their ratio "
             + ", ".join(f"{q:.2g}" for q in np.quantile(ratios, (0, .25, .5, .75, 1))))
    if accuracy:
        met = [m.errors.max() <= accuracy for m in found]
        words += (f"; {accuracy:g} met in {100 * np.mean(met):.0f} %, of the others "
                  f"{sum(m.refused for m, ok in zip(found, met) if not ok)} of {len(met) - sum(met)} said so, of those that "
                  f"met it {sum(m.refused for m, ok in zip(found, met) if ok)} said that they did not")
    return words


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("exe")
    parser.add_argument("seed", type=int)
    parser.add_argument("count", type=int, help="scenes of each kind")
    parser.add_argument("--kinds", default=",".join(SCENES))
    parser.add_argument("--first", type=int, default=0, help="leaves out so many of each kind")
    parser.add_argument("--end", type=float, default=6, help="latest end of a run")
    parser.add_argument("--cells", type=int, help="of the runs; the default if not given")
    parser.add_argument("--accuracy", type=float)
    parser.add_argument("--store", type=Path, help="a table, CSV, to which rows are added")
    arguments = parser.parse_args()
    directory, all_found, failed, left_out = Path(f"/tmp/coverage-{arguments.seed}"), {}, 0, 0
    directory.mkdir(exist_ok=True)
    table = Table(arguments.store, arguments.seed, arguments.accuracy)
    for kind in arguments.kinds.split(","):
        draw, all_found[kind] = fuzz.Draw(arguments.seed), []
        for i in range(arguments.count):
            options = SCENES[kind](draw, directory / f"{kind}-{i}")
            options["ts_max_time"] = min(float(options["ts_max_time"]), arguments.end)
            if arguments.cells:
                options["rod_cells"] = arguments.cells
            if i < arguments.first:
                continue
            words = words_of(options, directory, arguments.accuracy)
            kept = table.find(kind, words)
            found = kept or measure(arguments.exe, options, directory, arguments.accuracy)
            if isinstance(found, str):
                failed += found.startswith("lost")
                left_out += not found.startswith("lost")
                print(kind, found, flush=True)
                continue
            all_found[kind].append(found)
            if not kept:
                table.add(kind, found)
            failed += found.wrong_side
            print(kind, f"{found.estimate:.1e}", *(f"{e:.1e}" for e in found.errors), f"{found.ratio:.2g}",
                  *(["WRONG SIDE"] if found.wrong_side else []), *(["not met"] if found.refused else []), found.command,
                  flush=True)
    everything = [m for found in all_found.values() for m in found]
    for kind, found in {**all_found, "all": everything}.items():
        if found:
            print(summary(kind, found, arguments.accuracy))
    if left_out:
        print(f"{left_out} scenes have no reference and are not in this")
    return int(failed > 0)


if __name__ == "__main__":
    sys.exit(main())

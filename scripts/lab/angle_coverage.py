#!/usr/bin/env python3
"""How often the intervals of a fit to a table of angles hold the truth: roots whose numbers and errors nobody chose, whole fits.

Each root has its own sensing, proprioception, memory and first direction, drawn evenly (by their logarithms) between bounds; its
table the tip's angles, of half of the roots the base's, too, at 12 to 30 times, of one organ or of up to six; and each organ errs by
itself, smoothly over a part of the time that is drawn, and as a whole, each by a size that is drawn. What speaks against a fit is
not looked for: its tries change no interval but of fits that are called bad.

    PYTHONPATH=scripts .venv/bin/python scripts/lab/angle_coverage.py [--seeds 40] [--first 1] [--output FILE.csv]"""

import argparse
import sys
import tempfile
from pathlib import Path
from unittest import mock

import numpy as np

import tendril
from tendril import fitting, noise
from tendril.comparing import angles_behind

SCENE = dict(growth_type="apical", growth_zone=0.5, growth_initial_length=1, friction_mu=1, friction_beta=1e-3, shape_type="straight",
             tropism_direction="0,1", tropism_sensed="tip")
CELLS = dict(rod_cells=40, ts_rtol=1e-4)
DRAWN = {"tropism_gravity": (1.5, 15), "tropism_proprioception": (0.5, 6), "tropism_memory": (0.03, 0.6)}
BOUNDS = {"tropism_gravity": (0.3, 60), "tropism_proprioception": (0.1, 30), "tropism_memory": (0.005, 3)}
END = 2.0
DEGREE = np.pi / 180


def between(random, low, high):
    return float(low * (high / low) ** random.random())


def errors(random, t, own, smooth, reach, whole):
    """Of one organ, in degrees."""
    kernel = noise.matern(np.abs(t[:, None] - t) / reach)[0] + 1e-9 * np.eye(len(t))
    return own * random.normal(size=len(t)) + smooth * np.linalg.cholesky(kernel) @ random.normal(size=len(t)) + whole * random.normal()


def root(seed, place):
    """(truth, scene, file of its table, what its errors are)"""
    random = np.random.default_rng(seed)
    truth = {name: between(random, *bounds) for name, bounds in DRAWN.items()}
    scene = SCENE | {"clamp_angle": float(random.uniform(-0.3, 0.5))}
    r = tendril.run(scene | truth, ts_max_time=END, output_interval=END / 200, progress=False, rod_cells=60, ts_rtol=1e-5)
    organs = int(random.integers(1, 7)) if random.random() < 0.5 else 1
    sizes = [between(random, 0.1, 3), between(random, 0.1, 3), between(random, 0.1, 0.6), between(random, 0.1, 3) if organs > 1 else 0.0]
    t = np.linspace(0, END, int(random.integers(12, 31)))
    columns = {"tip": 0.0} | ({"base": 0.5} if random.random() < 0.5 else {})
    rows = ["t,root," + ",".join(f"{c}_angle (deg)" for c in columns)]
    for organ in range(organs):
        seen = [np.interp(t, r.shapes.t, angles_behind(r, d)) / DEGREE + errors(random, t, *sizes) for d in columns.values()]
        rows += [f"{time!r},{organ}," + ",".join(f"{float(a):.4f}" for a in row) for time, row in zip(t.tolist(), np.array(seen).T)]
    file = Path(place) / f"{seed}.csv"
    file.write_text("\n".join(rows) + "\n")
    return truth, scene, file, dict(organs=organs, times=len(t), columns="+".join(columns), own=sizes[0], smooth=sizes[1], reach=sizes[2],
                                    whole=sizes[3])


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seeds", type=int, default=40)
    parser.add_argument("--first", type=int, default=1)
    parser.add_argument("--output", default="angle-coverage.csv")
    choice = parser.parse_args()
    lines, held = [], {name: [] for name in DRAWN}
    with tempfile.TemporaryDirectory(prefix="tendril-") as place, mock.patch.object(fitting, "warnings_of", lambda *_: []):
        for seed in range(choice.first, choice.first + choice.seeds):
            truth, scene, file, about = root(seed, place)
            try:
                f = tendril.fit(scene, file, BOUNDS, starts=3, progress=False, **CELLS)
            except tendril.TendrilError as error:
                print(f"{seed}: {error}", flush=True)
                continue
            row = {"seed": seed} | {k: f"{v:.3g}" if isinstance(v, float) else v for k, v in about.items()} | {"runs": f.problem.count}
            for name, value in truth.items():
                low, high = f.intervals[name]
                held[name].append(low <= value <= high)
                row |= {name: f"{value:.4g}", f"{name}_found": f"{f.values[name]:.4g}", f"{name}_low": f"{low:.4g}",
                        f"{name}_high": f"{high:.4g}"}
            lines.append(row)
            print(seed, about, {n: (round(truth[n], 3), *(round(x, 3) for x in f.intervals[n]), held[n][-1]) for n in truth},
                  f"{f.seconds:.0f} s", flush=True)
            Path(choice.output).write_text("\n".join([",".join(lines[0]), *(",".join(map(str, line.values())) for line in lines)]) + "\n")
    for name, one in held.items():
        print(f"{name}: held {sum(one)} of {len(one)}")


if __name__ == "__main__":
    sys.exit(main())

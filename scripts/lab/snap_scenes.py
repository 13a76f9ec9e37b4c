#!/usr/bin/env python3
"""24 scenes with a snap: free, pressed by walls, caged, exact friction, in space. Steps, iterations, and where each ends.

    snap_scenes.py EXE [BEFORE] [--only REGEX]

BEFORE: another program, whose ends and counts stand beside; of one that runs a snap in a run of its own, its log of
these is not counted. The last line has the sums, the largest ratio of iterations, and how far ends are apart, as part of
the length."""

import argparse
import re
import subprocess
import tempfile
from pathlib import Path

import h5py
import numpy as np

WALLS = {
    "near": "plane 1 0 -1 0",
    "far": "plane 2 0 -1 0",
    "arch": "plane 2.005 0 -1 0",
    "cage": "polygon inside -0.2 -0.5 0.8 -0.5 0.8 0.5 -0.2 0.5",
    "oblique": "plane 2 0 -1 0.2 friction 0.5",
}
FED = "-growth_type feed -shape_type straight -rod_cells"
PRESSED = "-growth_type feed -contact_stiffness 1e6 -contact_friction 0.5 -ts_max_time 2.5 -ts_rtol 1e-6 -rod_curvature 0.01 -rod_cells 200"
ARCH = "-growth_initial_length 2 -shape_amplitude 0.1 -rod_cells 24 -ts_max_time 0.02 -tip_type clamped -rod_curvature_random 0.1"
SCENES = [line.split(" | ") for line in f"""\
dead force | -tip_force 240 -ts_max_time 0.1
hairpin | -growth_initial_length 2 -shape_amplitude 3.1 -ts_max_time 5
hairpin, exact | -growth_initial_length 2 -shape_amplitude 3.1 -ts_max_time 5 -friction_beta 0
behind the start | -growth_type gaussian -growth_width 0.552 -growth_initial_length 0.357 -shape_amplitude 1.65 -ts_max_time 0.001
brink | -growth_type feed -shape_type sag -growth_initial_length 0.764 -shape_amplitude 0.0166 -friction_beta 1.09e-6 -ts_max_time 1.33 -tip_force 3.154 -ts_rtol 1.05e-6
a wall, aside | {FED} 100 -growth_initial_length 0.9 -rod_curvature 1e-2 -ts_max_time 0.6 | near
nearly straight, 0.01 | {FED} 250 -growth_initial_length 0.5 -contact_stiffness 3e4 -rod_curvature 0.01 -ts_max_time 2 | far
nearly straight, 1e-4 | {FED} 250 -growth_initial_length 0.5 -contact_stiffness 3e4 -rod_curvature 1e-4 -ts_max_time 2 | far
arch on a wall, 1e-6 | {ARCH} -ts_rtol 1e-6 | arch
arch on a wall, 1e-4 | {ARCH} -ts_rtol 1e-4 | arch
cage | -growth_initial_length 0.1 -contact_diameter 0.05 -rod_curvature 0.3 -shape_type straight -ts_max_time 1.6 -rod_cells 400 -ts_rtol 1e-5 | cage
sticks, exact | {PRESSED} -friction_beta 0 | far
sticks, 1e-12 | {PRESSED} -friction_beta 1e-12 | far
oblique, held | -growth_type feed -growth_initial_length 0.5 -ts_max_time 1.6 -rod_cells 60 -contact_stiffness 1e6 -rod_curvature 0.01 -friction_beta 0 | oblique
slides 1, space, exact | -friction_mu 1 -friction_beta 0 -shape_type random -rod_model space -rod_cells 60 -growth_type feed -growth_initial_length 1 -shape_amplitude 0.035 -shape_seed 554 -ts_max_time 1.02 -rod_torsion 1.95 -tip_type clamped -rod_weight -0.123,0.141,0.209
slides 2, space, exact | -friction_mu 1 -friction_beta 0 -shape_type random -rod_model space -rod_cells 60 -growth_type feed -growth_initial_length 0.5 -shape_amplitude 0.036 -shape_seed 393 -ts_max_time 1.12 -rod_torsion 0.52 -rod_weight -0.060,-0.204,0.046
sag, long | -shape_type sag -shape_amplitude 0.1 -rod_curvature 0.001 -ts_max_time 32
spun, no snap | -growth_type apical -friction_mu 1 -friction_beta 0 -growth_initial_length 3.88 -shape_type sag -shape_amplitude 0.0053 -rod_model space -ts_max_time 1.16 -growth_zone 1.37 -rod_bend_ratio 1.65 -rod_twist -0.614 -tip_force 0.0839 -tip_law resistance -friction_radius 0.177 -rod_cells 60 -clamp_spin 0.5
space, sides 1 | -growth_initial_length 0.1832 -tip_force 2016.7 -shape_amplitude 0.0194 -rod_cells 80 -ts_max_time 0.03664 -shape_turn 0.5
space, sides 3 | -growth_initial_length 0.05 -tip_force 6000 -shape_amplitude 0.1 -rod_cells 80 -ts_max_time 0.01 -shape_turn 4
space, sides 4 | -growth_initial_length 0.3 -tip_force 160 -shape_amplitude 0.1 -rod_cells 80 -ts_max_time 0.06 -shape_turn 1 -rod_curvature -0.2 -rod_curvature_2 0.3 -rod_twist -5 -rod_bend_ratio 1.5
far, feed | -growth_type feed -growth_initial_length .112 -shape_type sag -tip_force 1929.21 -shape_amplitude 1.09 -ts_max_time 0.0224
far, uniform | -growth_type uniform -growth_initial_length .1 -shape_type sag -tip_force 2071 -shape_amplitude .98 -ts_max_time 0.02
layered start, across | -growth_type gaussian -growth_width 1.69 -growth_initial_length 0.618 -shape_amplitude 0.0232 -friction_across 0.596 -rod_cells 100 -ts_max_time 1e-4 -ts_rtol 1e-7
""".splitlines()]


def run(exe, options, wall, directory):
    """steps, iterations, end (tip and |x2| over length) or None, what was said"""
    file = Path(directory) / "run.h5"
    file.unlink(missing_ok=True)
    words = options.split()
    if wall:
        (Path(directory) / "wall").write_text(WALLS[wall] + "\n")
        words += ["-wall_file", str(Path(directory) / "wall")]
    done = subprocess.run(["prlimit", "--cpu=300", exe, *words, "-output", str(file)], capture_output=True, text=True)
    counts = re.search(r"(\d+) steps, \d+ rejected, (\d+) Newton", done.stdout)
    if done.returncode or not counts:
        return 0, 0, None, done.stderr.strip()[-160:] or "over the limit of time"
    with h5py.File(file) as f:
        series = f["series"]
        end = [series[k][-1] for k in ("tip_x1", "tip_x2", "tip_x3") if k in series]
        return int(counts[1]), int(counts[2]), np.array(end) / series["length"][-1], ""


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("exe")
    parser.add_argument("before", nargs="?")
    parser.add_argument("--only", default="")
    arguments = parser.parse_args()
    programs = [p for p in (arguments.exe, arguments.before) if p]
    sums, most, apart, lost = np.zeros((2, 2), int), 0., 0., 0
    with tempfile.TemporaryDirectory() as directory:
        for name, options, *wall in SCENES:
            if not re.search(arguments.only, name):
                continue
            rows = [run(p, options, wall[0].strip() if wall else None, directory) for p in programs]
            for k, row in enumerate(rows):
                sums[k] += row[:2]
            text = "; ".join(f"{steps:6d} {its:6d} {np.round(end, 7) if end is not None else said}" for steps, its, end, said in rows)
            if len(rows) == 2 and all(r[2] is not None for r in rows):
                n = min(len(rows[0][2]), len(rows[1][2]))
                distance = float(np.linalg.norm(rows[0][2][:n] - rows[1][2][:n]))
                most, apart = max(most, rows[0][1] / rows[1][1]), max(apart, distance)
                text += f"; apart {distance:.1e}, iterations {rows[0][1] / rows[1][1]:.2f}"
            lost += rows[0][2] is None
            print(f"{name:24s} {text}", flush=True)
    print(f"{lost} lost; steps, iterations: {sums[:len(programs)].tolist()}; iterations at most {most:.2f} times, ends within {apart:.1e}")


if __name__ == "__main__":
    main()

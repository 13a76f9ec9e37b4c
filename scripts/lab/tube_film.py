#!/usr/bin/env python3
"""From a film to numbers, the paper's tube: PVC insulation of 5.04 mm, stiffness 4.4907e-4 N m^2, friction 20 N/m.
Renders the film of its push (light, blur, noise, hand, tilt, compression), measures it and finds the friction and
the natural curvature; the page docs/my-film.md has what it prints and its picture.

    PYTHONPATH=scripts .venv/bin/python scripts/lab/tube_film.py [--directory DIRECTORY] [--picture docs/first/film.png]"""

import argparse
import sys
import tempfile
import time
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent))
import film
import tendril
from tendril.comparing import finer, shape_at
from tendril.filming import film_frames
from tendril.style import STYLE

TUBE = Path(__file__).resolve().parents[2] / "docs/first/push.opts"
FRICTION, CURVATURE, DIAMETER = 20.0, 1.5, 5.04e-3  # N/m, 1/m, m
SECONDS, FPS, SEED = 56, 5, 2026


def pictured(m, number, movie, f, path):
    """A frame with the line that was found in it; and the rods of the best scene over the measured points."""
    frame = m.frames[number]
    index = int(round(frame.at * FPS))
    picture = next(p for _, k, p in film_frames(str(movie), 1, (index, index)))
    with plt.rc_context(STYLE):
        figure, axes = plt.subplots(1, 2, figsize=(8.4, 2.9), layout="constrained")
        axes[0].imshow(picture)
        axes[0].plot(*frame.line.points.T, color="#e69f00", lw=1.2)
        axes[0].set_axis_off()
        axes[0].set_title(f"a frame, {frame.at:g} s, and its centre line", fontsize=8)
        problem = f.problem
        for p in problem.measured.photographs[::4]:
            line = problem.comparison.line(f.run, p, f.u[len(f.parameters):], problem.view(f.u))
            axes[1].plot(*(100 * p.points.numbers.T), ".", ms=2.5, color="#e69f00")
            axes[1].plot(*(100 * line.T), color="#0072b2", lw=0.8)
        axes[1].set_aspect("equal")
        axes[1].set_xlabel("$x_1$ (cm)")
        axes[1].set_ylabel("$x_2$ (cm)")
        axes[1].set_title("measured, and the scene found", fontsize=8)
        figure.savefig(path, dpi=130)
    plt.close(figure)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--directory", help="where film, points and page stay")
    parser.add_argument("--picture", default="tube-film.png")
    choice = parser.parse_args()
    truth = tendril.run(TUBE, si_friction_dry=f"{FRICTION}N/m", rod_curvature=f"{CURVATURE}/m", rod_model="mixed",
                        rod_cells=800, ts_rtol=1e-7, ts_max_time=f"{SECONDS}s", output_interval=f"{SECONDS / 100}s")
    length = truth.scale("length")
    places = np.vstack([finer(shape_at(truth, t / truth.scale("time"))) for t in np.linspace(0, SECONDS, 30)]) * length
    low, high = places.min(axis=0), places.max(axis=0)
    stage = film.Stage(SEED, (low + high) / 2, 1.5 * max(high[0] - low[0], 1.6 * (high[1] - low[1])))
    with tempfile.TemporaryDirectory(prefix="tendril-") as temporary:
        place = Path(choice.directory or temporary)
        place.mkdir(parents=True, exist_ok=True)
        movie, board = place / "push.mp4", place / "board.png"
        film.rendered(movie, truth, stage, DIAMETER, SECONDS * FPS, FPS)
        film.imageio.imwrite(board, stage.finished(stage.board))
        clamp, along = np.round(stage.view(np.array([[0, 0], [0.05, 0]])))
        begin = time.perf_counter()
        m = tendril.measure(movie, clamp=clamp, along=along, checkerboard=(*film.BOARD, f"{film.SQUARE}m"),
                            board_picture=board, every=10)
        m.save(place / "push")
        print(f"priors {m.priors(clicked=1.5, scaled=1e-3)}")
        print(f"clamp {clamp}, along {along}: {m}, {time.perf_counter() - begin:.0f} s")
        f = tendril.fit(TUBE, place / "push.csv", {"si_friction_dry": ("4N/m", "60N/m"), "rod_curvature": ("-8/m", "8/m")},
                        priors=m.priors(clicked=1.5, scaled=1e-3))
        print(f.report())
        f.save(place / "push-fit")
        good = [k for k, frame in enumerate(m.frames) if frame.line]
        pictured(m, good[3 * len(good) // 4], movie, f, choice.picture)


if __name__ == "__main__":
    sys.exit(main())

#!/usr/bin/env python3
"""From a film to numbers, over and over: renders films of runs whose truth is known (light that falls off, blur,
noise, a textured ground, the hand that pushes, a ruler, a tilted camera, compression), measures and fits them.

    PYTHONPATH=scripts .venv/bin/python scripts/lab/film.py [--seeds 20] [--first 1] [--frames 200] [--every 8]
      [--size 1920x1080] [--lens] [--ground textured] [--touching] [--keep DIRECTORY]

A film of another size shows the same in fewer pixels: blur, texture and the width of what is drawn go with it.
--lens bends the picture as a wide one does, and has six pictures of the board in other positions. --ground
textured is gravel, darker and lighter than the rod, for the ridge filter. --touching pushes on until the rod has
touched itself for some seconds, and fits a scene that knows of it.

Prints a line a film and how often the intervals hold the truth."""

import argparse
import os
import sys
import tempfile
import time
from functools import lru_cache
from importlib.util import find_spec
from pathlib import Path

import numpy as np

import tendril
from tendril.comparing import finer, shape_at


def refuse_without(package):
    sys.exit(f"{Path(sys.argv[0]).stem}: rendering and measuring films needs {package}: .venv/bin/python -m pip "
             "install -e './scripts[film]'")


try:
    import cv2
    import imageio.v2 as imageio
    import skimage  # noqa: F401, which finds lines
except ImportError as missing:
    refuse_without(missing.name)

SIZE = [1920, 1080]
BARREL = (-0.18, 0.04)  # of the lens: x (1 + a r^2 + b r^4), r = 1 half a width from the middle
TUBE = dict(growth_type="feed", growth_initial_length="1cm", si_bending_stiffness="2.209Nmm^2",
            si_speed="5mm/s", friction_beta=1e-6, shape_type="straight")
DIAMETER, SECONDS, LONGER = 2.5e-3, 40, 46  # m, s; it touches itself at 39.2 s
TOUCHING = TUBE | dict(contact_self=True, contact_diameter=f"{DIAMETER}m")
TRUTH = {"si_friction_dry": (0.62, "N/m"), "rod_curvature": (3.7, "/m")}
BOUNDS = {"si_friction_dry": ("0.1N/m", "2N/m"), "rod_curvature": ("-10/m", "10/m")}
BOARD, SQUARE = (9, 6), 0.008  # inner corners; m


class View:
    """A camera at some height over the plane, tilted: from metres in the plane to pixels, [3, 3]."""

    def __init__(self, random, middle, span, tilt=4.0, near=1.0):
        a, b = np.radians(random.uniform(-tilt, tilt, 2)) if np.isscalar(tilt) else np.radians(tilt)
        turn = np.array([[1, 0, 0], [0, np.cos(a), -np.sin(a)], [0, np.sin(a), np.cos(a)]]) \
            @ np.array([[np.cos(b), 0, np.sin(b)], [0, 1, 0], [-np.sin(b), 0, np.cos(b)]])
        height = 3 * span
        focal = 0.9 * SIZE[0] * height / span
        place = np.array([[1, 0, -middle[0]], [0, -1, middle[1]], [0, 0, 0]])
        rows = turn @ place
        rows[:, 2] += [0, 0, near * height]
        self.matrix = np.array([[focal, 0, SIZE[0] / 2], [0, focal, SIZE[1] / 2], [0, 0, 1]]) @ rows
        self.size = focal / height  # pixels per metre in the middle

    def __call__(self, points):
        whole = np.column_stack([points, np.ones(len(points))]) @ self.matrix.T
        return whole[:, :2] / whole[:, 2:]


def bent(points):
    """Where a wide lens shows points of a picture."""
    middle, half = np.array(SIZE) / 2, SIZE[0] / 2
    x = (np.asarray(points, float) - middle) / half
    square = np.sum(x**2, axis=-1, keepdims=True)
    return middle + half * x * (1 + BARREL[0] * square + BARREL[1] * square**2)


@lru_cache
def taken_from(width, height):
    """Of each pixel behind the lens, where in the picture before it that is."""
    wanted = np.stack(np.meshgrid(np.arange(width, dtype=float), np.arange(height, dtype=float)), axis=-1)
    at = wanted.copy()
    for _ in range(20):  # what bent() takes to where it is wanted
        at += wanted - bent(at)
    return at.astype(np.float32).transpose(2, 0, 1)


def through_lens(picture):
    """The picture that a wide lens makes of this one."""
    return cv2.remap(picture, *taken_from(*SIZE), cv2.INTER_CUBIC, borderMode=cv2.BORDER_REFLECT_101)


def polygon(picture, points, colour):
    cv2.fillPoly(picture, [np.round(16 * points).astype(np.int32)], colour, cv2.LINE_AA, 4)


class Stage:
    """All of a film that does not move: ground, ruler, board, light; and how the rest is drawn."""

    def __init__(self, seed, middle, span, body=60, ground=205, gravel=False, lens=False):
        self.random = random = np.random.default_rng(seed)
        self.view, self.body, self.lens = View(random, middle, span), body, lens
        self.middle, self.span, self.part = middle, span, SIZE[0] / 1920
        x, y = np.meshgrid(*(np.linspace(-1, 1, n) for n in SIZE))
        angle = random.uniform(0, 2 * np.pi)
        self.light = 1 - 0.22 * (x * np.cos(angle) + y * np.sin(angle)) - 0.12 * (x**2 + y**2)
        texture = cv2.GaussianBlur(random.normal(size=SIZE[::-1]).astype(np.float32), (0, 0), 6 * self.part)
        self.still = (ground + (25 if gravel else 6) * texture / texture.std()).astype(np.float32)
        low = middle[1] - 0.26 * span
        self.ruler(np.array([middle[0] - 0.35 * span, low - 0.03 * span]), 0.7 * span, 0.02 * span)
        self.board = self.checkers(np.array([middle[0] - 0.45 * span, middle[1] + 0.265 * span - SQUARE * (BOARD[1] + 1)]))

    def ruler(self, corner, length, height):
        box = corner + np.array([[0, 0], [length, 0], [length, height], [0, height]])
        polygon(self.still, self.view(box), 235)
        for k in range(int(length / 1e-3) + 1):
            reach = height * (0.6 if k % 10 == 0 else 0.3)
            ends = self.view(corner + np.array([[k * 1e-3, height], [k * 1e-3, height - reach]]))
            cv2.line(self.still, *[tuple(int(v) for v in np.round(16 * e)) for e in ends], 70, 1, cv2.LINE_AA, 4)

    def boards(self, count=6):
        """Pictures of the board in other positions, near enough to fill the picture, for the lens."""
        views, here = [], self.view
        for k in range(count):
            tilt, size = self.random.uniform(-28, 28, 2), SQUARE * (np.array(BOARD) + 1)
            self.view = View(self.random, self.middle, self.span, tilt, 1.6 * max(size / [self.span, 0.55 * self.span]))
            corner = self.middle + self.random.uniform(-0.1, 0.1, 2) * size - size / 2
            views.append(self.finished(self.checkers(corner)))
        self.view = here
        return views

    def checkers(self, corner):
        """The picture of the board alone, as it is filmed before the rod."""
        still = self.still.copy()
        count = np.array(BOARD) + 1
        edge = corner + SQUARE * np.array([[-1, -1], [count[0] + 1, -1], [count[0] + 1, count[1] + 1], [-1, count[1] + 1]])
        polygon(still, self.view(edge), 240)
        for c in range(count[0]):
            for r in range(count[1]):
                if (c + r) % 2 == 0:
                    box = corner + SQUARE * np.array([[c, r], [c + 1, r], [c + 1, r + 1], [c, r + 1]])
                    polygon(still, self.view(box), 40)
        return still

    def finished(self, picture):
        """Lens, light, blur, noise; RGB of 8 bits."""
        picture = through_lens(picture) if self.lens else picture
        lit = cv2.GaussianBlur(picture * self.light.astype(np.float32), (0, 0), max(1.3 * self.part, 0.6))
        lit = lit + 4 * self.random.normal(size=lit.shape).astype(np.float32)
        return np.repeat(np.clip(lit, 0, 255).astype(np.uint8)[..., None], 3, axis=2)

    def frame(self, line, diameter, t):
        """The rod, and the hand that pushes it."""
        picture = self.still.copy()
        thick = diameter * self.view.size
        along = np.gradient(line, axis=0)
        along /= np.hypot(*along.T)[:, None]
        # a polygon that OpenCV fills reaches half a pixel beyond its edge
        half = 0.5 / self.view.size
        line = np.vstack([line[:-1], line[-1] - half * along[-1]])
        side = (diameter / 2 - half) * np.column_stack([-along[:, 1], along[:, 0]])
        left, right = self.view(line + side), self.view(line - side)
        for k in range(len(line) - 1):  # piece by piece, for a rod may cross itself
            polygon(picture, np.array([left[k], left[k + 1], right[k + 1], right[k]]), self.body)
        clamp = self.view(np.zeros((1, 2)))[0]
        wrist = clamp + [-3.2 * thick - 12 * abs(np.sin(0.9 * t)), 1.5 * thick]
        cv2.ellipse(picture, (tuple(wrist.tolist()), (6 * thick, 14 * thick), 25), 150, -1, cv2.LINE_AA)
        return self.finished(picture)


def rendered(path, r, stage, diameter, frames, fps):
    """Writes a film of a run, compressed by H.264."""
    if not find_spec("imageio_ffmpeg"):  # which imageio writes films with
        refuse_without("imageio_ffmpeg")
    length = r.scale("length")
    with imageio.get_writer(path, fps=fps, codec="libx264", output_params=["-crf", "27", "-preset", "veryfast", "-threads", "1"],
                            macro_block_size=None, ffmpeg_log_level="error") as film:
        for t in np.arange(frames) / fps:
            line = finer(shape_at(r, t / r.scale("time"))) * length
            film.append_data(stage.frame(line, diameter, t))


def attempt(seed, r, frames, every, place, lens=False, ground="plain", scene=TUBE, seconds=SECONDS):
    """(which intervals hold the truth, relative errors of the estimates, seconds of rendering, measuring,
    fitting)"""
    fps = frames / seconds
    length = r.scale("length")
    reach = np.ptp(r.shapes.x.reshape(-1, 2), axis=0) * length
    middle = np.mean([r.shapes.x.reshape(-1, 2).min(axis=0), r.shapes.x.reshape(-1, 2).max(axis=0)], axis=0) * length
    stage = Stage(seed, middle, 1.5 * max(reach[0], 1.6 * reach[1]), gravel=ground == "textured", lens=lens)
    film, board = place / f"film{seed}.mp4", place / f"board{seed}.png"
    begin = time.perf_counter()
    rendered(film, r, stage, DIAMETER, frames, fps)
    imageio.imwrite(board, stage.finished(stage.board))
    drawn = time.perf_counter()
    clamp, along = (bent if lens else np.array)(stage.view(np.array([[0, 0], [0.05, 0]])))
    others = [place / f"lens{seed}-{k}.png" for k in range(6)] if lens else []
    for path, picture in zip(others, stage.boards() if lens else []):
        imageio.imwrite(path, picture)
    click = max(stage.part, 0.5)
    m = tendril.measure(film, clamp=clamp + click * stage.random.normal(size=2),
                        along=along + click * stage.random.normal(size=2), lens=others, ground=ground,
                        checkerboard=(*BOARD, f"{SQUARE}m"), board_picture=board, every=every)
    m.save(place / f"film{seed}")
    measured = time.perf_counter()
    f = tendril.fit(scene, place / f"film{seed}.csv", BOUNDS, priors=m.priors(clicked=1.5, scaled=1e-3))
    fitted = time.perf_counter()
    held = {n: f.intervals[n][0] <= v <= f.intervals[n][1] for n, (v, _) in TRUTH.items()}
    off = {n: f.values[n] / v - 1 for n, (v, _) in TRUTH.items()}
    half = {n: (f.intervals[n][1] - f.intervals[n][0]) / 2 / v for n, (v, _) in TRUTH.items()}
    print(f"film {seed}: " + ", ".join(f"{n} {f.values[n]:.5g} ({100 * off[n]:+.2g} % +- {100 * half[n]:.2g}"
                                       f"{'' if held[n] else ' !'})" for n in TRUTH)
          + f"; {m}; rendered {drawn - begin:.0f} s, measured {measured - drawn:.0f} s, fitted {fitted - measured:.0f} s",
          flush=True)
    for words in [*f.indistinct, *f.warnings]:
        print(f"  {words}", flush=True)
    return held, off, drawn - begin, measured - drawn, fitted - measured


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seeds", type=int, default=20)
    parser.add_argument("--first", type=int, default=1)
    parser.add_argument("--frames", type=int, default=200)
    parser.add_argument("--every", type=int, default=8)
    parser.add_argument("--size", default="1920x1080", help="of the picture; default %(default)s")
    parser.add_argument("--lens", action="store_true", help="a wide one, calibrated")
    parser.add_argument("--ground", choices=("plain", "textured"), default="plain")
    parser.add_argument("--touching", action="store_true", help="a longer push, until the rod touches itself")
    parser.add_argument("--keep", help="directory in which films and pages stay")
    choice = parser.parse_args()
    SIZE[:] = [int(n) for n in choice.size.split("x")]
    os.environ.setdefault("OMP_NUM_THREADS", "1")
    scene, seconds = (TOUCHING, LONGER) if choice.touching else (TUBE, SECONDS)
    # contact is known to the frame model alone
    best = dict(rod_model="frame", rod_cells=600, ts_rtol=1e-6) if choice.touching else \
        dict(rod_model="mixed", rod_cells=1200, ts_rtol=1e-7)
    r = tendril.run(scene, **{n: f"{v}{u}" for n, (v, u) in TRUTH.items()}, **best, ts_max_time=f"{seconds}s",
                    output_interval=f"{seconds / 80}s")
    with tempfile.TemporaryDirectory(prefix="tendril-") as temporary:
        place = Path(choice.keep or temporary)
        place.mkdir(parents=True, exist_ok=True)
        found = [attempt(seed, r, choice.frames, choice.every, place, choice.lens, choice.ground, scene, seconds)
                 for seed in range(choice.first, choice.first + choice.seeds)]
    for name in TRUTH:
        held = sum(one[0][name] for one in found)
        off = [one[1][name] for one in found]
        print(f"| {name} | {held} of {len(found)} | {100 * np.max(np.abs(off)):.2g} % at most |")
    print("| seconds (median): " + ", ".join(f"{what} {np.median([one[k] for one in found]):.0f}" for k, what in
                                             ((2, "rendering"), (3, "measuring"), (4, "fitting"))) + " |")


if __name__ == "__main__":
    sys.exit(main())

"""How surfaces move as given in time, as the lines of /walls say it: rows of a time and of what is there then, between
which monotone cubic curves lead, those of the program (src/base/schedule.c)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.interpolate import PchipInterpolator, PPoly


@dataclass
class Course:
    """Where it is over time [k], 0 at t = 0: a curve of polynomials between knots, beyond which it goes on at the rates
    `ends` [2, k]."""

    curve: PPoly
    ends: np.ndarray

    def at(self, t):
        """Where it is at a time."""
        return self.place(t) - self.place(0)

    def place(self, t):
        within = np.clip(t, *self.curve.x[[0, -1]])
        return self.curve(within) + (t - within) * self.ends[int(t > within)]

    def tolist(self):
        """It as a page has it: places are counted from that at t = 0; pieces [n - 1, degree + 1, k] are coefficients of the
        time since their knot, the highest power first."""
        pieces = self.curve.c.copy()
        pieces[-1] -= self.place(0)
        return {"knots": self.curve.x.tolist(), "pieces": pieces.swapaxes(0, 1).tolist(), "ends": self.ends.tolist()}


def course(numbers, columns, rate=False):
    """Of the numbers of a line: rows of a time and so many columns, places, or, if that is so, rates."""
    t, values = np.hsplit(np.reshape(np.asarray(numbers, float), (-1, 1 + columns)), [1])
    curve = PchipInterpolator(t[:, 0], values)
    if not rate:
        return Course(curve, np.zeros((2, columns)))
    return Course(curve.antiderivative(), values[[0, -1]])


def shift_of(motion, t):
    """[3], how far what moves so, as motion_of() has it, has been carried along at a time."""
    return motion["shift"].at(t) if "shift" in motion else t * motion.get("moves", np.zeros(3))


def turned(motion, t):
    """The angle by which what moves so has turned at a time."""
    return motion["angle"].at(t)[0] if "angle" in motion else motion["turns"][0] * t if "turns" in motion else 0.0


def turn_of(motion, t):
    """Of a wall of the plane, the angle to the left by which it has turned at a time, and about what [2]."""
    place = motion.get("turns", np.array([0, 0, 0, 0, 0, 0, 1.0]))
    return np.sign(place[6]) * turned(motion, t), place[1:3]


def motion_of(word, tail):
    """What a line says behind `moves` or `turns`: {"moves": velocity [3]} or {"shift": Course}, {"turns": rate, place and
    axis [7]} or {"angle": Course, "turns": ... that rate 0}."""
    if word == "moves":
        return {"shift": course(tail[1:], 3)} if tail[0] == "at" else {"moves": np.array(tail, float)}
    if tail[0] not in ("at", "spin"):
        return {"turns": np.array(tail, float)}
    about = tail.index("about")
    return {"angle": course(tail[1:about], 1, tail[0] == "spin"), "turns": np.array([0, *tail[about + 1:]], float)}

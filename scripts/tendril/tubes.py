"""What the program asks of a tube (src/world/tube.c), asked before the file is written, and told by the points of the
file that the tube comes from."""

from __future__ import annotations

import numpy as np

from .meshes import SurfaceError

SHARPEST = np.radians(60)  # turn at a point
STEEPEST = 0.99  # change of the radius by length
BENT = 1e-3  # curvature times radius that is worth a word
PLACES = 16  # of a segment at which it is looked at
AWAY = 1.1 * np.pi  # in widest radii: parts so far along the path are others
MOST = 100_000  # places at which the tube may meet another part of itself
FINE = 8  # samples a radius, of the other parts


class Tube:
    """The smooth path through balls [n, 4], x1, x2, x3 and radius, as the program lays it: cubic splines over the length of
    the chords, without a knot at the second point and the last but one."""

    def __init__(self, balls):
        from scipy.interpolate import CubicSpline

        self.balls = balls
        self.u = np.concatenate([[0], np.cumsum(np.linalg.norm(np.diff(balls[:, :3], axis=0), axis=1))])
        self.at = CubicSpline(self.u, balls)

    def by_arc(self, u):
        """The radius at places [...], its slope, its bend, and the path's curvature, by arc length."""
        y, d1, d2 = self.at(u), self.at(u, 1), self.at(u, 2)
        speed2 = (d1[..., :3] ** 2).sum(axis=-1)
        along = (d1[..., :3] * d2[..., :3]).sum(axis=-1) / speed2
        across = d2[..., :3] - along[..., None] * d1[..., :3]
        return (y[..., 3], d1[..., 3] / np.sqrt(speed2), (d2[..., 3] - along * d1[..., 3]) / speed2,
                np.linalg.norm(across, axis=-1) / speed2)

    def places(self):
        """[segments, PLACES + 1] along it."""
        return self.u[:-1, None] + np.diff(self.u)[:, None] * np.arange(PLACES + 1) / PLACES

    def steep_start(self):
        """Does its first ball lie within the next one, or does the path widen as fast as that behind it?"""
        first = self.u[0] + (self.u[1] - self.u[0]) * np.arange(PLACES + 1) / PLACES
        return self.balls[1, 3] - self.balls[0, 3] >= self.u[1] or bool((self.by_arc(first)[1] >= STEEPEST).any())

    def trouble(self, inside, radius):
        """Why the program would refuse it with a rod of this radius: (places along it, what it does, what to do); None."""
        return self.at_points(inside, radius) or self.of_segments(inside, radius) or self.in_itself()

    def at_points(self, inside, radius):
        steps = np.diff(self.balls[:, :3], axis=0)
        steps /= np.linalg.norm(steps, axis=1)[:, None]
        turns = np.arccos(np.clip((steps[1:] * steps[:-1]).sum(axis=1), -1, 1))
        narrow = self.balls[:, 3] <= (radius if inside else 0)
        if narrow.any():
            k = int(np.argmax(narrow))
            return [self.u[k]], f"the tube, of radius {self.balls[k, 3]:.4g}, is no wider than the rod, of radius {radius:.4g}", \
                "make it wider, or the rod thinner"
        if (turns >= SHARPEST).any():
            k = int(np.argmax(turns >= SHARPEST))
            return [self.u[k + 1]], f"the path has a kink of {np.degrees(turns[k]):.0f} degrees", \
                "give more points where it bends"
        return None

    def of_segments(self, inside, radius):
        """The balls' envelope is smooth where  r'' + kappa sqrt(1 - r'^2) < (1 - r'^2)/r,  outside with the rod's radius
        on top."""
        u = self.places()
        r, slope, bend, curvature = self.by_arc(u)
        narrow, steep = r <= (radius if inside else 0), np.abs(slope) >= STEEPEST
        flat = np.clip(1 - slope**2, 0, None)
        sharp = bend + curvature * np.sqrt(flat) >= flat / np.maximum(r if inside else r + radius, 1e-300)
        wrong = (narrow | steep | sharp).ravel()
        if not wrong.any():
            return None
        k = int(np.argmax(wrong))
        place = [float(u.ravel()[k])]
        if narrow.ravel()[k]:
            return place, f"the tube {'is narrower than the rod' if inside and radius else 'vanishes'}", \
                "its radius is a smooth curve through the points; give more of them"
        if steep.ravel()[k]:
            return place, "the tube widens or narrows more than the path goes on", \
                "leave points out there, or smooth it with a larger every"
        kappa, wide = curvature.ravel()[k], r.ravel()[k]
        how = f"bends with radius {1 / kappa:.3g}, or its width does," if kappa * wide > BENT else "changes its width too sharply"
        return place, f"the tube {how} and has radius {wide:.3g}", "make it narrower or its bends wider, give more points, or " \
            "smooth it with every"

    def in_itself(self):
        """Do parts meet that are farther along than half a turn at its sharpest?"""
        from scipy.spatial import cKDTree

        end = self.u[-1]
        radii = self.at(self.places())[..., 3]
        narrowest, widest = radii.min(), radii.max()
        away = AWAY * widest
        if end < away:
            return None
        count = int(min(MOST, np.ceil(end / narrowest)))
        here = end * np.arange(count + 1) / count
        there = np.linspace(0, end, int(min(2 * MOST, np.ceil(FINE * end / narrowest))) + 1)
        step = there[1]
        x, y = self.at(here), self.at(there)
        tree = cKDTree(y[:, :3])
        fine = step * np.linspace(-1, 1, 33)
        for u, ball in zip(here, x):
            near = np.array(tree.query_ball_point(ball[:3], ball[3] + widest + 2 * step), int)
            near = near[np.abs(there[near] - u) >= away - step]
            if not len(near):
                continue
            deep = y[near, 3] + ball[3] - np.linalg.norm(y[near, :3] - ball[:3], axis=1)
            best = there[near[np.argmax(deep)]] + fine
            best = best[(best >= 0) & (best <= end) & (np.abs(best - u) >= away)]
            other = self.at(best)
            gap = np.linalg.norm(other[:, :3] - ball[:3], axis=1) - other[:, 3] - ball[3]
            if len(gap) and gap.min() < 0:
                return [float(u), float(best[np.argmin(gap)])], "the tube runs into itself", "make it narrower, or cut it"
        return None

    def holds(self, x, radius):
        """May the axis of a rod be at x: within the tube, or before one of its mouths, whose lips open by 45 degrees?"""
        u = np.append(self.places().ravel(), self.u)
        y = self.at(u)
        deep = y[:, 3] - np.linalg.norm(x - y[:, :3], axis=1)
        if deep.max() >= radius:
            return True
        for k, sign in ((0, -1), (-1, 1)):
            out = sign * self.at(self.u[k], 1)[:3]
            out /= np.linalg.norm(out)
            off = x - self.balls[k, :3]
            beyond = off @ out
            if beyond >= 0 and np.linalg.norm(off - beyond * out) + radius <= beyond + np.sqrt(2) * self.balls[k, 3]:
                return True
        return False


def trimmed(balls):
    """Without the points at the ends whose balls lie within their neighbours', which add nothing to a tube; how many
    are left out (at the start, at the end)."""
    first, last = 0, len(balls)
    while last - first > 2:
        if Tube(balls[first:last]).steep_start():
            first += 1
        elif Tube(balls[first:last][::-1]).steep_start():
            last -= 1
        else:
            break
    return balls[first:last], (first, len(balls) - last)


def asked(balls, given, own, source, inside, radius):
    """Refuses what the program would refuse: in one line, with the points `own` [n, 3] of the file between which it is;
    given: where they are in the frame of the balls."""
    tube = Tube(balls)
    found = tube.trouble(inside, radius)
    if found is None:
        return tube
    places, what, remedy = found
    where = " and ".join(between(x, given, own) for x in tube.at(places)[:, :3])
    raise SurfaceError(f"{source}: {where}: {what}: {remedy}")


def between(x, given, own):
    """Words for a place: the two points of the file that it is between."""
    a, b = given[:-1], given[1:]
    share = np.clip(((x - a) * (b - a)).sum(axis=1) / np.maximum(((b - a) ** 2).sum(axis=1), 1e-300), 0, 1)
    k = int(np.argmin(np.linalg.norm(a + share[:, None] * (b - a) - x, axis=1)))
    place = ", ".join(f"{v:.4g}" for v in own[k] + share[k] * (own[k + 1] - own[k]))
    return f"between points {k + 1} and {k + 2} of {len(own)}, near ({place})"

"""Arrays as a page holds them."""

import base64

import numpy as np

from .results import FAR


def packed(values):
    """An array as base64 of 32-bit numbers, least significant byte first as browsers have it."""
    return base64.b64encode(np.ascontiguousarray(values, "<f4").tobytes()).decode()


def thinned(count, most):
    """Indices of at most so many of count things, the first and the last among them."""
    return np.unique(np.linspace(0, count - 1, min(count, most)).round().astype(int))


def moves_straight(r, kept):
    """[kept - 1] of each pair of stored shapes that follow each other: 1 if the rod may be drawn between
    them in a straight motion, which is then where the series have it; else 0, and the stored are shown."""
    x, t = r.shapes.x[kept], r.shapes.t[kept]
    middle = np.argmin(np.abs(r.shapes.s - 0.5))
    tip = np.column_stack([r.series[name] for name in ("tip_x1", "tip_x2", "tip_x3") if name in r.series])
    fair = np.ones(max(len(kept) - 1, 0))
    for k in range(len(fair)):
        within = np.flatnonzero((r.series.t > t[k]) & (r.series.t < t[k + 1]))
        w = ((r.series.t[within] - t[k]) / (t[k + 1] - t[k]))[:, None]
        ends = x[k, -1, :tip.shape[1]] * (1 - w) + x[k + 1, -1, :tip.shape[1]] * w
        halves = (x[k, middle] - x[k, 0]) * (1 - w) + (x[k + 1, middle] - x[k + 1, 0]) * w
        off = [np.linalg.norm(ends - tip[within], axis=1),
               np.abs(np.linalg.norm(halves, axis=1) - r.series.mid_distance[within])]
        fair[k] = np.max(off, initial=0) <= FAR * r.value("length", t[k + 1])
    return fair


def packed_small(values):
    """An array in 16 bits a number, in parts of its largest: {most, values}."""
    most = float(np.abs(values).max(initial=0)) or 1.0
    parts = np.round(np.asarray(values) / most * 32767).astype("<i2")
    return {"most": most, "values": base64.b64encode(np.ascontiguousarray(parts).tobytes()).decode()}

"""What acts on a rod and what stands around it, for all that draws a rod."""

from __future__ import annotations

import numpy as np

from .results import Results, Shape
from .units import in_si, quantity


def size_of(vectors) -> np.ndarray:
    """[...], of vectors [..., 2 or 3]."""
    return np.hypot(*np.moveaxis(vectors, -1, 0)) if vectors.shape[-1] == 2 else np.linalg.norm(vectors, axis=-1)


def arc_length(shape: Shape) -> np.ndarray:
    """[n], from the clamp, along the nodes."""
    return np.concatenate([[0], np.cumsum(size_of(np.diff(shape.x, axis=0)))])


def axial_force(shape: Shape) -> np.ndarray:
    """[n], n.q, negative in compression."""
    if shape.d1 is not None:
        return np.sum(shape.force * shape.d1, axis=1)
    return shape.force[:, 0] * np.cos(shape.theta) + shape.force[:, 1] * np.sin(shape.theta)


def contact_force(r: Results, shape: Shape) -> np.ndarray:
    """[n, 2 or 3], force of contact on the rod per unit length; 0 where the file knows none."""
    if "contact" not in r.shapes:
        return np.zeros_like(shape.x)
    force = r.shapes["contact"][shape.index]
    return np.pad(force, ((0, 0), (0, shape.x.shape[1] - force.shape[1])))  # of a rod in the plane shown in space


def weight(r: Results, axes: int) -> np.ndarray:
    """[axes], the rod's weight per unit length in the laboratory, 0 if it has none."""
    given = [quantity(part) for part in str(r.attributes.get("parameters/rod_weight", "") or "0").split(",")]
    found = [number * in_si(unit) * r.scale("length") / r.scale("force") if unit else number
             for number, unit in given]
    return np.array([*found, 0, 0][:axes])


def friction(r: Results, shape: Shape, pieces: int) -> tuple[np.ndarray, np.ndarray]:
    """([pieces, 2 or 3] middles of equal pieces of the rod, [pieces, 2 or 3] friction on each per unit
    length): what with its weight w holds the internal force in balance, -dn/dp - w. 0 on a piece that is
    touched: there it would be the small difference of two large forces."""
    p = arc_length(shape)
    ends = np.linspace(0, p[-1], pieces + 1)
    held = -np.diff(along(p, shape.force, ends), axis=0) / np.diff(ends)[:, None] - weight(r, shape.x.shape[1])
    touched = np.flatnonzero(np.any(contact_force(r, shape), axis=1))
    near = np.clip(np.searchsorted(ends, p[touched][:, None] + [[-1e-9, 1e-9]]) - 1, 0, pieces - 1)
    held[np.unique(near)] = 0
    return along(p, shape.x, (ends[1:] + ends[:-1]) / 2), held


def pressed(r: Results, shape: Shape, pieces: int) -> tuple[np.ndarray, np.ndarray]:
    """([pieces, 2 or 3] places on the rod's surface, [pieces, 2 or 3] force of contact on the rod per unit length) in
    equal pieces of the rod, as the mean over each: what is pressed at a point and what is pressed along a
    line are drawn alike. 0 where nothing touches."""
    force, p = contact_force(r, shape), arc_length(shape)
    width = np.gradient(p)
    piece = np.minimum((p / p[-1] * pieces).astype(int), pieces - 1)
    size = size_of(force) * width
    total = [np.bincount(piece, f * width, pieces) for f in force.T]
    place = [np.bincount(piece, x * size, pieces) for x in shape.x.T]
    share = np.bincount(piece, size, pieces)
    mean = np.column_stack(total) / (p[-1] / pieces)
    at = np.column_stack(place) / np.maximum(share, 1e-300)[:, None]
    away = mean / np.maximum(size_of(mean), 1e-300)[:, None]
    there = share > 0
    return np.where(there[:, None], at - r.diameter / 2 * away, shape.x[0]), np.where(there[:, None], mean, 0)


def along(p, values, at) -> np.ndarray:
    """[m, d], nodal values [n, d] at some arc lengths."""
    return np.column_stack([np.interp(at, p, column) for column in values.T])


def walls(r: Results) -> list[tuple[list[np.ndarray], list[np.ndarray]]]:
    """Of each wall around a run (rings [m, 2], what lies in one but not in two of them is its body; its
    lines [m, 2]); of what has no end as much as the shapes reach along it, and more."""
    from .walls import solid, walls_of

    x = np.concatenate([s.reshape(-1, 2) for s in r.shapes["x"]])
    (x0, y0), (x1, y1) = x.min(axis=0), x.max(axis=0)
    room = max(x1 - x0, y1 - y0)
    found = []
    for wall in walls_of(r):
        body, lines = solid(wall, (x0 - room, x1 + room, y0 - room, y1 + room))
        found.append((body.to_polygons(closed_only=False) if body else [], lines))
    return found

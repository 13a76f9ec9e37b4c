"""What acts on a rod and what stands around it, for all that draws a rod."""

from __future__ import annotations

import numpy as np

from .results import Results, Shape


def arc_length(shape: Shape) -> np.ndarray:
    """[n], from the clamp, along the nodes."""
    return np.concatenate([[0], np.cumsum(np.hypot(*np.diff(shape.x, axis=0).T))])


def axial_force(shape: Shape) -> np.ndarray:
    """[n], n.q, negative in compression."""
    return shape.force[:, 0] * np.cos(shape.theta) + shape.force[:, 1] * np.sin(shape.theta)


def contact_force(r: Results, shape: Shape) -> np.ndarray:
    """[n, 2], force of contact on the rod per unit length; 0 where the file knows none."""
    return r.shapes["contact"][shape.index] if "contact" in r.shapes else np.zeros_like(shape.x)


def friction(r: Results, shape: Shape) -> np.ndarray:
    """[n, 2], friction on the rod per unit length: what holds the internal force in balance, -dn/dp,
    less what contact does."""
    return -np.gradient(shape.force, arc_length(shape), axis=0) - contact_force(r, shape)


def walls(r: Results) -> list[np.ndarray]:
    """Lines [m, 2] of the walls around a run; of a plane as much as its shapes reach along it."""
    from .walls import solid, walls_of

    x = np.concatenate([s.reshape(-1, 2) for s in r.shapes["x"]])
    (x0, y0), (x1, y1) = x.min(axis=0) - 1, x.max(axis=0) + 1
    return [line for wall in walls_of(r) for line in solid(wall, (x0, x1, y0, y1))[1]]

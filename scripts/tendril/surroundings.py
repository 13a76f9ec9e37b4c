"""What acts on a rod and what stands around it, for all that draws a rod."""

from __future__ import annotations

from pathlib import Path

import h5py
import numpy as np

from .results import Results, Shape, as_text
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


def layers_of(r: Results) -> list[tuple[float, float]]:
    """Where each layer of friction begins along x1, and what friction is multiplied by in it."""
    found = []
    for piece in as_text(r.attributes.get("parameters/friction_layers", "")).split(","):
        begin, factor = (quantity(part) for part in piece.partition(":")[::2])
        if begin and factor:
            found.append((begin[0] * in_si(begin[1]) / r.scale("length") if begin[1] else begin[0], factor[0]))
    return found


def stiffness_along(r: Results, x) -> np.ndarray | None:
    """[n - 1], between nodes x, how many times as stiff as the scales have it the rod is; None where it is the same all along, or its
    file is not there any more."""
    file = Path(as_text(r.attributes.get("parameters/rod_stiffness_file", "")))
    if not file.is_file():
        return None
    with h5py.File(file, "r", locking=False) as f:
        distance, factor = f["distance"][()], f["factor"][()]
    pieces = size_of(np.diff(x, axis=0))
    from_tip = np.cumsum(pieces[::-1])[::-1] - pieces / 2
    return np.interp(from_tip, distance, factor)


def vector_of(r: Results, name: str, axes: int, *units: str) -> np.ndarray:
    """[axes], an option that is a vector in the laboratory, 0 if it was not given; its unit is the first of the file's
    over the others."""
    given = [quantity(part) for part in str(r.attributes.get(f"parameters/{name}", "") or "0").split(",")]
    found = [number * in_si(unit) * np.prod([r.scale(kind) for kind in units[1:]]) / r.scale(units[0]) if unit else number
             for number, unit in given]
    return np.array([*found, 0, 0][:axes])


def weight(r: Results, axes: int) -> np.ndarray:
    """[axes], the rod's weight per unit length in the laboratory, 0 if it has none."""
    return vector_of(r, "rod_weight", axes, "force", "length")


def pieces_of(r: Results, shape: Shape, pieces: int) -> np.ndarray:
    """[pieces + 1], ends of about equal pieces of the rod: where it is touched in a few places, beside them, for what presses
    on one point is spread over its cells in the forces along the rod, and so in pressures, but not alike."""
    p, touched = arc_length(shape), np.any(contact_force(r, shape), axis=1)
    ends = np.linspace(0, p[-1], pieces + 1)
    beside = np.convolve(touched, [1, 1, 1], "same") > 0
    if touched.any() and not beside.all():
        clear = p[~beside]
        near = clear[np.abs(clear - ends[:, None]).argmin(axis=1)]
        moves = np.abs(near - ends) < 0.45 * p[-1] / pieces
        moves[[0, -1]] = False
        ends[moves] = near[moves]
    return ends


def borne(r: Results, shape: Shape, ends) -> np.ndarray:
    """[pieces, 2 or 3], force of contact on each piece of the rod between these arc lengths: what the file has at a node is
    the mean over half of the cells beside it."""
    p = arc_length(shape)
    half = np.concatenate([[0], (p[1:] + p[:-1]) / 2, [p[-1]]])
    total = np.vstack([np.zeros(shape.x.shape[1]), np.cumsum(contact_force(r, shape) * np.diff(half)[:, None], axis=0)])
    return np.diff(along(half, total, ends), axis=0)


def friction(r: Results, shape: Shape, pieces: int) -> tuple[np.ndarray, np.ndarray]:
    """([pieces, 2 or 3] middles of about equal pieces of the rod, [pieces, 2 or 3] friction on each per unit
    length, that of walls and of other strands too): what with its weight w and what presses on it holds the internal
    force in balance, -dn/dp - w - pressure."""
    p = arc_length(shape)
    ends = pieces_of(r, shape, pieces)
    held = -np.diff(along(p, shape.force, ends), axis=0) - borne(r, shape, ends)
    return along(p, shape.x, (ends[1:] + ends[:-1]) / 2), held / np.diff(ends)[:, None] - weight(r, shape.x.shape[1])


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

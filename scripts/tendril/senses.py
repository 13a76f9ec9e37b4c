"""Where the lamp of a rod is that senses, and how fast it grows where, for all that draws it."""

from __future__ import annotations

import numpy as np

from .results import Results, Shape
from .surroundings import axial_force, vector_of


def number(r: Results, name: str) -> float:
    return float(r.attributes.get(f"parameters/{name}", 0) or 0)


def lamp(r: Results, axes: int) -> np.ndarray | None:
    """[axes], its place; None: it sees none."""
    return vector_of(r, "tropism_source", axes, "length") if number(r, "tropism_light") else None


def strain_rate(r: Results, shape: Shape) -> np.ndarray:
    """[n], the rate at which the material of a shape stretches (docs/theory/growth.md), per unit of time."""
    law = r.attributes.get("parameters/growth_type", "uniform")
    if law in ("none", "feed"):
        return np.zeros(len(shape.s))
    if law == "apical":
        zone = min(number(r, "growth_zone"), shape.length)
        z = np.clip((1 - shape.s) * shape.length / zone, 0, 1)
        even = r.attributes.get("parameters/growth_profile") == "even"
        rate = (z < 1) / zone if even else 30 * z**2 * (1 - z) ** 2 / zone
    elif law == "uniform":
        rate = np.full(len(shape.s), 1 / shape.length)
    else:  # in place
        stretch = r.shapes["stretch"]
        rate = np.gradient(stretch, r.shapes.t, axis=0)[shape.index] / stretch[shape.index]
    most = number(r, "growth_yield")
    return rate * np.maximum(0, 1 + axial_force(shape) / most) if most else rate

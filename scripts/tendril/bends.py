"""The bend along a rod, that which it has by nature, and that at which its material would learn no more."""

from __future__ import annotations

import numpy as np

from .results import Results, Shape
from .senses import lamp, number
from .spatial import lift
from .surroundings import vector_of


def natural(r: Results, shape: Shape) -> np.ndarray:
    """[n, 3], natural strains about d1, d2, d3."""
    if "natural_strain" in r.shapes:
        return r.shapes["natural_strain"][shape.index]
    bend = r.shapes["natural_curvature"][shape.index]
    return np.column_stack([np.zeros_like(bend), np.zeros_like(bend), bend])


def sensed(r: Results, shape: Shape) -> np.ndarray:
    """[n, 2], what is sensed now about d2 and d3: in each place, or at the tip for all."""
    shape = lift(r, shape)
    pull = np.zeros_like(shape.x)
    if number(r, "tropism_gravity"):
        direction = vector_of(r, "tropism_direction", 3)
        pull += number(r, "tropism_gravity") * direction / np.linalg.norm(direction)
    if number(r, "tropism_light"):
        way = lamp(r, 3) - shape.x
        pull += number(r, "tropism_light") * way / np.linalg.norm(way, axis=1, keepdims=True)
    felt = np.column_stack([-np.sum(pull * shape.d3, axis=1), np.sum(pull * shape.d2, axis=1)])
    return np.broadcast_to(felt[-1], felt.shape) if r.attributes.get("parameters/tropism_sensed") == "tip" else felt


def set_point(r: Results, shape: Shape) -> np.ndarray | None:
    """[n, 2], bends about d2 and d3 at which the material learns no more, by what is sensed now:
    (f + nutation + I (u - u0)) / G; None where nothing straightens it, G = 0."""
    straightens, angle = number(r, "tropism_proprioception"), number(r, "tropism_nutation_rate") * shape.t
    if not straightens:
        return None
    turns = np.array([-number(r, "tropism_nutation_2") * np.sin(angle), number(r, "tropism_nutation") * np.cos(angle)])
    elastic = (lift(r, shape).strain - natural(r, shape))[:, 1:]
    return (sensed(r, shape) + turns + number(r, "growth_ironing") * elastic) / straightens


def size_or_one(bends: np.ndarray, r: Results) -> np.ndarray:
    """[n], of bends [n, 2]: in the plane that about d3, in space their size."""
    return np.linalg.norm(bends, axis=1) if r.in_space else bends[:, 1]


def bends_of(r: Results, shape: Shape) -> list[tuple[str, str, np.ndarray]]:
    """(what it is, a line's style, [n]): the bend, that which it has by nature, and its set point, along the rod."""
    found = [("bend", "-", lift(r, shape).strain[:, 1:]), ("by nature", "--", natural(r, shape)[:, 1:])]
    goal = set_point(r, shape)
    found += [("set point", ":", goal)] if goal is not None else []
    return [(name, style, size_or_one(bends, r)) for name, style, bends in found]


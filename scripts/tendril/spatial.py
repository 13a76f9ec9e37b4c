"""A rod as a body in space: its fields, how its material lies about its centre line, the tube it is; for all
that draws a rod in space, and for what takes it elsewhere. A rod in the plane is one with x3 = 0."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from .results import Results, Shape
from .senses import number, strain_rate
from .surroundings import axial_force, contact_force, weight

# name -> (what it is, its unit, whether it has a sign); the parts of vectors are about the directors
FIELDS = {
    "axial": ("axial force, compression < 0", "N l", True),
    "curvature": ("curvature", "1/l", False),
    "bend_2": ("bend u₂", "1/l", True),
    "bend_3": ("bend u₃", "1/l", True),
    "twist": ("twist u₁", "1/l", True),
    "bending_moment": ("bending moment", "N l^2", False),
    "twisting_moment": ("twisting moment", "N l^2", True),
    "shear": ("force across the rod", "N l", False),
    "contact": ("force of contact per length", "N", False),
    "growth": ("rate of growth", "V/l", False),
}
VISIBLE = 0.012  # of the extent: the diameter that a rod without one is shown with


def lift(r: Results, shape: Shape) -> Shape:
    """A shape with three coordinates; one in space as it is."""
    if shape.d1 is not None:
        return shape
    flat = np.zeros(len(shape.s))
    d1 = np.column_stack([np.cos(shape.theta), np.sin(shape.theta), flat])
    d3 = np.broadcast_to([0.0, 0.0, 1.0], d1.shape)
    return replace(shape, x=np.column_stack([shape.x, flat]), force=np.column_stack([shape.force, flat]),
                   strain=np.column_stack([flat, flat, shape.curvature]), d1=d1, d2=np.cross(d3, d1), d3=d3)


def fields_of(r: Results, shape: Shape) -> dict[str, np.ndarray]:
    """Scalars along a shape by the names of FIELDS, [n]; those that its file has."""
    shape = lift(r, shape)
    axial = axial_force(shape)
    found = {"axial": axial, "curvature": np.abs(shape.curvature), "bend_2": shape.strain[:, 1],
             "bend_3": shape.strain[:, 2], "twist": shape.strain[:, 0],
             "shear": np.sqrt(np.maximum(np.sum(shape.force**2, axis=1) - axial**2, 0))}
    if shape.moment is not None:
        found["twisting_moment"] = np.sum(shape.moment * shape.d1, axis=1)
        found["bending_moment"] = np.linalg.norm(
            shape.moment - found["twisting_moment"][:, None] * shape.d1, axis=1)
    if "contact" in r.shapes:
        found["contact"] = np.linalg.norm(contact_force(r, shape), axis=1)
    if number(r, "growth_zone") or number(r, "tropism_gravity") or number(r, "tropism_light"):
        found["growth"] = strain_rate(r, shape)
    return {name: found[name] for name in FIELDS if name in found}


def diameter_of(r: Results) -> float:
    """That of contact, or that at which friction feels the spin; 0 if the rod has none."""
    return r.diameter or 2 * float(r.attributes.get("parameters/friction_radius", 0) or 0)


def extent_of(r: Results) -> float:
    """Of all stored shapes, in any direction."""
    x = r.shapes.x.reshape(-1, r.shapes.x.shape[-1])
    return float(np.ptp(x, axis=0).max()) or 1.0


def up_of(r: Results) -> int:
    """The axis that is drawn upwards, 1, 2 or 3, negative where it points down: against the weight, else x3
    of a rod in space and x2 of one in the plane."""
    w = weight(r, 3)
    if not w.any():
        return 3 if r.in_space else 2
    axis = int(np.argmax(np.abs(w)))
    return -int(np.sign(w[axis])) * (axis + 1)


def carried(x, first, tangents=None):
    """([..., n, 3], [..., n, 3]) unit vectors across curves x [..., n, 3] that are carried along without turning
    about them, by two reflections a piece (Wang and others 2008: of order 4); the first of them is the part of
    `first` [..., 3] that lies across."""
    tangents = slopes(x) if tangents is None else tangents
    normal = np.empty_like(tangents)
    across = first - dot(first, tangents[..., 0, :]) * tangents[..., 0, :]
    normal[..., 0, :] = across / np.linalg.norm(across, axis=-1, keepdims=True)
    for i in range(x.shape[-2] - 1):
        chord, here = x[..., i + 1, :] - x[..., i, :], normal[..., i, :]
        half = 2 / np.maximum(dot(chord, chord), 1e-300) * chord
        r_n, r_t = here - dot(chord, here) * half, tangents[..., i, :] - dot(chord, tangents[..., i, :]) * half
        back = tangents[..., i + 1, :] - r_t
        r_n = r_n - 2 / np.maximum(dot(back, back), 1e-300) * dot(back, r_n) * back
        r_n -= dot(r_n, tangents[..., i + 1, :]) * tangents[..., i + 1, :]
        normal[..., i + 1, :] = r_n / np.linalg.norm(r_n, axis=-1, keepdims=True)
    return normal, np.cross(tangents, normal)


def dot(a, b):
    """[..., 1] of vectors [..., 3]."""
    return np.sum(a * b, axis=-1, keepdims=True)


def slopes(x):
    """[..., n, 3], unit tangents of curves through their nodes."""
    chords = np.diff(x, axis=-2)
    chords = chords / np.maximum(np.linalg.norm(chords, axis=-1, keepdims=True), 1e-300)
    mean = np.concatenate([chords[..., :1, :], chords[..., 1:, :] + chords[..., :-1, :], chords[..., -1:, :]], -2)
    return mean / np.maximum(np.linalg.norm(mean, axis=-1, keepdims=True), 1e-300)


def turned(x, d1, d2):
    """[..., n], the angle from a direction that is carried along a rod [..., n, 3] to d2: 0 at the clamp, as many
    turns as the material makes about the centre line."""
    normal, third = carried(x, d2[..., 0, :], d1)
    return np.unwrap(np.arctan2(dot(d2, third), dot(d2, normal))[..., 0], axis=-1)


def tube(x, radius, sides=16, first=None):
    """([m, 3] vertices, [k, 3] triangles, [m] the node of each vertex) of the closed tube of a radius round a
    curve x [n, 3]. The last two vertices are the middles of its ends."""
    x = np.asarray(x, float)
    tangent = slopes(x)
    if first is None:
        first = np.eye(3)[np.argmin(np.abs(tangent[0]))]
    normal, third = carried(x, first)
    angle = 2 * np.pi * np.arange(sides) / sides
    ring = np.cos(angle)[None, :, None] * normal[:, None] + np.sin(angle)[None, :, None] * third[:, None]
    vertices = np.concatenate([(x[:, None] + radius * ring).reshape(-1, 3), x[:1], x[-1:]])
    n = len(x)
    i, j = np.meshgrid(np.arange(n - 1), np.arange(sides), indexing="ij")
    k = (j + 1) % sides
    a, b, c, d = (i * sides + j, i * sides + k, (i + 1) * sides + k, (i + 1) * sides + j)
    sheet = np.concatenate([np.stack([a, b, c], -1).reshape(-1, 3), np.stack([a, c, d], -1).reshape(-1, 3)])
    j, k, last = np.arange(sides), (np.arange(sides) + 1) % sides, (n - 1) * sides
    ends = np.concatenate([np.stack([np.full(sides, n * sides), k, j], -1),
                           np.stack([np.full(sides, n * sides + 1), last + j, last + k], -1)])
    node = np.concatenate([np.repeat(np.arange(n), sides), [0, n - 1]])
    return vertices, np.concatenate([sheet, ends]), node


def out_of_plane(r):
    """The norm of x3, 0 while it first rises from rounding to where it could be told beside that of x2."""
    norm, beside = r.series.norm_x3.copy(), r.series.norm_x2[r.series.norm_x2 > 0]
    norm[:np.argmax(norm > 0.1 * beside.min(initial=np.inf))] = 0
    return norm

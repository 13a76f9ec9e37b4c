"""What a page holds of a rod in space, beside what it holds of one in the plane."""

from __future__ import annotations

import base64

import numpy as np

from .packed import moves_straight, packed, thinned
from .solids import solids
from .spatial import FIELDS, VISIBLE, diameter_of, extent_of, fields_of, lift, turned, up_of
from .surroundings import friction, pressed

ARROWS = 28
ROOM, SERIES = 2.2e6, 7e5  # bytes that the shapes and the series of all runs may take
NODES = {1: 251, 2: 251}  # of a run, by how many there are


def shapes_of(r, runs):
    """What moves: arrays by name, [stored time, ...], thinned to what a page of so many runs holds. "along"
    has the fields by name, [stored time, node]."""
    nodes = thinned(len(r.shapes.s), NODES.get(runs, 151))
    bytes_of = 4 / 3 * len(nodes) * (16 + 2 * len(FIELDS))
    kept = thinned(len(r.shapes.t), int(np.clip(ROOM / runs / bytes_of, 20, 300)))
    shapes = [lift(r, r.stored(k)) for k in kept]
    x, d1, d2 = (np.stack([getattr(shape, name) for shape in shapes]) for name in ("x", "d1", "d2"))
    table = {"t": r.shapes.t[kept], "x": x[:, nodes], "base": d2[:, 0], "turn": turned(x, d1, d2)[:, nodes]}
    forces = [friction(r, shape, ARROWS) for shape in shapes]
    table |= {"places": np.stack([place for place, _ in forces]), "friction": np.stack([f for _, f in forces])}
    if "contact" in r.shapes:
        forces = [pressed(r, shape, ARROWS) for shape in shapes]
        table |= {"touched": np.stack([place for place, _ in forces]), "contact": np.stack([f for _, f in forces])}
    fields = [fields_of(r, shape) for shape in shapes]
    along = {name: np.stack([one[name] for one in fields])[:, nodes] for name in fields[0]}
    return table | {"fair": moves_straight(r, kept), "along": along}


def add(content, results, shapes):
    """Adds to the content of a page what there is in space only."""
    for run, r, shape in zip(content["runs"], results, shapes):
        steps = thinned(len(r.series.t), int(SERIES / len(results) / (16 / 3 * len(r.series))))
        if len(steps) < len(r.series.t):
            run["series"] = {name: packed(values[steps]) for name, values in r.series.items()}
        run["surfaces"] = [{"positions": packed(one.vertices), "index": base64.b64encode(
            np.ascontiguousarray(one.triangles, "<u4").tobytes()).decode(), "lines": [packed(line) for line in one.lines],
            "motion": {what: numbers.tolist() for what, numbers in one.motion.items()} or None} for one in solids(r)]
    content["up"] = up_of(next(r for r in results if r.in_space))
    content["visible"] = VISIBLE * max(extent_of(r) for r in results)
    content["twisted"] = bool(max(np.ptp(shape["turn"]) for shape in shapes) > 0.5)
    for run, r in zip(content["runs"], results):
        run["diameter"] = diameter_of(r)

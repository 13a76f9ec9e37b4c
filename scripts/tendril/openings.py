"""Which way a mesh faces, and its open ends: found, measured, led on.

    for end in tendril.ends("vessel.stl"):
        print(end.number, end.middle, end.direction, end.width)

Whether a surface is inside out is asked of what its rims, capped, enclose: each part of it by its own volume and by
which other parts it lies in, before anything is built on it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .errors import path_of
from .meshes import Mesh, SurfaceError, count_of, read_mesh

LEAD = 2.0  # how far open ends are led on, in their own diameters
NOTHING = 1e-12  # of the cube of a part's size: what encloses less has no inside
FLUSH = 1e-6  # of its size: ends that are in one plane
NEAR_0 = 1e-12  # what rounding leaves of a 0
WITNESSES = 20  # places of a part by which it is seen to be within another
MOST_ANGLES = 5e8  # solid angles that are summed for that


def boundary(mesh):
    """Directed edges that no triangle borders on the other side, and edges of more than two triangles, or
    of two that run the same way."""
    edges = mesh.edges()
    key = np.sort(edges, axis=1)
    _, where, count = np.unique(key, axis=0, return_inverse=True, return_counts=True)
    sense = np.zeros(len(count))
    np.add.at(sense, where.ravel(), np.where(edges[:, 0] < edges[:, 1], 1, -1))
    where = where.ravel()
    return edges[count[where] == 1], edges[count[where] > 2], edges[(count[where] == 2) & (sense[where] != 0)]


def place_of(mesh, corner):
    return "near (" + ", ".join(f"{v:.4g}" for v in mesh.points[corner]) + ")"


def sound(mesh):
    """Refuses a mesh of which nobody can say which side is which; returns the edges of its holes."""
    holes, many, against = boundary(mesh)
    if len(many):
        raise SurfaceError(f"{mesh.name}: at {count_of(len(np.unique(np.sort(many), axis=0)), 'edge')} more than two triangles meet, the first "
                           f"{place_of(mesh, many[0][0])}; mend the mesh")
    if len(against):
        raise SurfaceError(f"{mesh.name}: triangles face different ways, the first {place_of(mesh, against[0][0])}; "
                           "mend the mesh")
    return holes


def check(mesh, flip=False, open=False):
    """Refuses what has no inside; returns the mesh, with its triangles outwards.

    flip  turn it, whichever way it faces; a mesh that is inside out then is refused
    open  it may have holes, the ends of a vessel"""
    holes = sound(mesh)
    if len(holes) and not open:
        raise SurfaceError(f"{mesh.name}: has holes: {len(holes)} edges belong to one triangle only, the first "
                           f"{place_of(mesh, holes[0][0])}; close them, or, if they are the ends of a vessel, give open")
    if open and not len(holes):
        raise SurfaceError(f"{mesh.name}: open, but it has no open end")
    if flip:
        mesh = Mesh(mesh.points, mesh.triangles[:, ::-1], mesh.name, mesh.own, mesh.notes)
    return outwards(mesh, flip)


def outwards(mesh, flipped=False):
    """The mesh with all its parts turned so that their triangles run counterclockwise as seen from outside, and a note of
    what was turned; what was flipped by hand is not turned again, but refused."""
    part, turned, volume = facing(capped(mesh))
    if not volume > 0:
        raise SurfaceError(f"{mesh.name}: encloses no volume: a surface needs an inside")
    if not turned.any():
        return mesh
    wrong = turned[part[:len(mesh.triangles)]]
    n = int(turned.sum())
    who = "" if turned.all() else f"{n} of {len(turned)} parts, the first {place_of(mesh, mesh.triangles[wrong][0][0])}, "
    be = "are" if who and n > 1 else "is"
    if flipped:
        raise SurfaceError(f"{mesh.name}: {who}{be} inside out with flip: leave flip away, without it what is inside out is turned")
    triangles = mesh.triangles.copy()
    triangles[wrong] = triangles[wrong, ::-1]
    mesh.notes.append(f"{who}{be} inside out: its triangles run clockwise as seen from outside; turned")
    return Mesh(mesh.points, triangles, mesh.name, mesh.own, mesh.notes)


# ---- which way it faces ----


def facing(mesh):
    """Of a closed mesh: the part that each triangle is of, which parts face the wrong way, and the volume enclosed by
    those that are within none. A part within another is a cavity and faces the other way, and so on inwards."""
    part = parts_of(mesh)
    count = part.max() + 1
    corners = mesh.corners
    low, high = np.full((count, 3), np.inf), np.full((count, 3), -np.inf)
    np.minimum.at(low, part, corners.min(axis=1))
    np.maximum.at(high, part, corners.max(axis=1))
    a, b, c = np.moveaxis(corners - ((low + high) / 2)[part][:, None], 1, 0)
    volume = np.bincount(part, np.einsum("ij,ij->i", a, np.cross(b, c)) / 6, count)
    depth = depths(corners, mesh.own or len(corners), part, low, high)
    solid = np.abs(volume) > NOTHING * np.linalg.norm(high - low, axis=1) ** 3
    return part, solid & (volume * (1 - 2 * (depth % 2)) < 0), np.abs(volume[solid & (depth == 0)]).sum()


def parts_of(mesh):
    """[m] which triangles hang together, by edges: numbers from 0."""
    from scipy.sparse import coo_matrix
    from scipy.sparse.csgraph import connected_components

    m = len(mesh.triangles)
    _, edge = np.unique(np.sort(mesh.edges(), axis=1), axis=0, return_inverse=True)
    order = np.argsort(edge.ravel(), kind="stable")
    same = np.flatnonzero(np.diff(edge.ravel()[order]) == 0)
    a, b = order[same] // 3, order[same + 1] // 3
    return connected_components(coo_matrix((np.ones(len(a)), (a, b)), (m, m)), directed=False)[1]


def depths(corners, own, part, low, high):
    """[parts] in how many others each lies as a whole. One that another runs through is in none: such a mesh is seen to run
    through itself later on."""
    count = len(low)
    depth = np.zeros(count, int)
    little = FLUSH * np.linalg.norm(high - low, axis=1, keepdims=True)
    pairs = [(i, k) for i in range(count)
             for k in np.flatnonzero(((low - little <= low[i]) & (high + little >= high[i])).all(axis=1)) if i != k]
    if not pairs:
        return depth
    most = int(np.clip(MOST_ANGLES / (len(pairs) * len(part) / count), 1, WITNESSES))
    middles = corners[:own].mean(axis=1)  # not those of caps
    for i, k in pairs:
        of_it = np.flatnonzero(part[:own] == i)
        seen = middles[of_it[np.linspace(0, len(of_it) - 1, min(most, len(of_it))).astype(int)]]
        depth[i] += all(abs(winding(corners[part == k], place)) > 0.5 for place in seen)
    return depth


def winding(corners, place):
    """How often a surface goes round a place: the solid angles of its triangles (van Oosterom and Strackee)."""
    a, b, c = np.moveaxis(corners - place, 1, 0)
    la, lb, lc = (np.linalg.norm(v, axis=1) for v in (a, b, c))

    def dot(v, w):
        return np.einsum("ij,ij->i", v, w)

    return np.arctan2(dot(a, np.cross(b, c)), la * lb * lc + dot(a, b) * lc + dot(b, c) * la + dot(c, a) * lb).sum() / (2 * np.pi)


# ---- open ends ----


def loops_of(mesh, edges):
    """Closed rings of a hole's directed edges. Where holes meet in a corner, each goes on with the edge that is next across
    the hole; what comes back to a corner of its own has closed there."""
    after = {}
    for a, b in edges.tolist():
        after.setdefault(a, []).append(b)
    shared = [a for a, more in after.items() if len(more) > 1]
    normal = normals_at(mesh, shared)
    loops = []
    while after:
        walk = [next(iter(after))]
        at = {walk[0]: 0}
        while True:
            corner = walk[-1]
            there = after.get(corner)
            if not there:
                if len(walk) > 1:
                    raise SurfaceError(f"{mesh.name}: a hole's rim does not close {place_of(mesh, corner)}; mend the mesh")
                break
            following = there[0]
            if len(there) > 1 and len(walk) > 1:
                following = next_across(mesh.points, walk[-2], corner, there, normal[corner])
            there.remove(following)
            if not there:
                del after[corner]
            if following in at:
                first = at[following]
                loops.append(np.array(walk[first:]))
                for gone in walk[first + 1:]:
                    del at[gone]
                del walk[first + 1:]
            else:
                at[following] = len(walk)
                walk.append(following)
    return loops


def normals_at(mesh, corners):
    """{corner: the sum of the normals of its triangles, by their areas}."""
    found = {}
    for corner in corners:
        a, b, c = np.moveaxis(mesh.corners[(mesh.triangles == corner).any(axis=1)], 1, 0)
        found[corner] = np.cross(b - a, c - a).sum(axis=0)
    return found


def next_across(points, before, corner, following, normal):
    """Where a rim goes on from a corner: the first edge that is met when one turns, counterclockwise about the normal, from
    the edge it came by; the mesh is on its other side."""
    def angle(to):
        v, w = points[before] - points[corner], points[to] - points[corner]
        normed = normal / max(np.linalg.norm(normal), 1e-300)
        turned = np.arctan2(normed @ np.cross(v, w), v @ w - (v @ normed) * (w @ normed))
        return turned % (2 * np.pi) or 2 * np.pi

    return min(following, key=angle)


def capped(mesh):
    """The mesh with its holes closed by fans about their middles."""
    points, triangles, n = [mesh.points], [mesh.triangles], len(mesh.points)
    for ring in loops_of(mesh, boundary(mesh)[0]):
        points.append(mesh.points[ring].mean(axis=0)[None])
        triangles.append(np.column_stack([np.roll(ring, -1), ring, np.full(len(ring), n)]))
        n += 1
    return Mesh(np.concatenate(points), np.concatenate(triangles), mesh.name, len(mesh.triangles))


def area_of(mesh, rim):
    """Of a rim [n, 3]: its area as a vector into the mesh, which is on the left of its edges; and its size."""
    middle = rim.mean(axis=0)
    area = np.cross(rim - middle, np.roll(rim, -1, axis=0) - middle).sum(axis=0) / 2
    size = np.linalg.norm(area)
    if size == 0:
        around = ", ".join(f"{v:.4g}" for v in middle)
        raise SurfaceError(f"{mesh.name}: an open end has no area, near ({around}); mend the mesh")
    return area, size


def extended(mesh, diameters=LEAD):
    """The mesh with its open ends led on straight, by so many of their diameters, and closed there: a rod
    that leaves the vessel meets no lid at its end."""
    points, triangles = [mesh.points], [mesh.triangles]
    n = len(mesh.points)
    for ring in loops_of(mesh, boundary(mesh)[0]):
        rim = mesh.points[ring]
        middle = rim.mean(axis=0)
        area, size = area_of(mesh, rim)
        out = -area / size
        wide = 2 * np.sqrt(size / np.pi)
        steps = max(2, int(np.ceil(diameters * wide / np.median(np.linalg.norm(rim - np.roll(rim, 1, 0), axis=1)))))
        # flat at its end, wherever the rim is uneven
        far = middle + diameters * wide * out
        last = rim + ((far - rim) @ out)[:, None] * out
        rows = [rim + (last - rim) * k / steps for k in range(1, steps + 1)]
        points += rows + [far[None]]
        ids = [ring] + [n + k * len(ring) + np.arange(len(ring)) for k in range(steps)]
        for a, b in zip(ids[:-1], ids[1:]):
            a1, b1 = np.roll(a, -1), np.roll(b, -1)
            triangles += [np.column_stack([a1, a, b]), np.column_stack([a1, b, b1])]
        n += steps * len(ring)
        triangles.append(np.column_stack([np.roll(ids[-1], -1), ids[-1], np.full(len(ring), n)]))
        n += 1
    return Mesh(np.concatenate(points), np.concatenate(triangles), mesh.name, len(mesh.triangles), mesh.notes)


@dataclass
class End:
    """An open end of a mesh, in the file's own frame."""

    number: int  # from 1, the widest first
    middle: np.ndarray  # [3], of its rim: for origin
    direction: np.ndarray  # [3], of length 1, into the mesh: for direction, or clamp_direction
    width: float  # the diameter of a circle of the same area

    @property
    def options(self):
        """What surface.sh is given so that the rod enters here."""
        return " ".join(f"--{name}={','.join(f'{v + 0.0:.7g}' for v in vector)}"
                        for name, vector in (("origin", self.middle), ("direction", self.direction)))


def ends(source, scale=1.0):
    """The open ends of a mesh: STL, OBJ, PLY, VTP, VTK. A list, the widest first; none of a closed mesh. Directions are
    inwards also of a mesh that is inside out.

    scale  what the mesh's unit is in that of the widths: places are as the file has them, for origin"""
    try:
        scale = float(scale)
    except (TypeError, ValueError):
        scale = 0.0
    if not 0 < scale < np.inf:
        raise SurfaceError("scale: must be above 0")
    return ends_of(read_mesh(path_of(source, "source")), scale)


def ends_of(mesh, scale=1.0):
    """Those of a mesh that was read."""
    holes = sound(mesh)
    if not len(holes):
        return []
    mesh = outwards(mesh)
    found = []
    for ring in loops_of(mesh, boundary(mesh)[0]):
        rim = mesh.points[ring]
        area, size = area_of(mesh, rim)
        after = np.roll(rim, -1, axis=0)
        middle = np.average((rim + after) / 2, axis=0, weights=np.linalg.norm(after - rim, axis=1))
        middle[np.abs(middle) < NEAR_0 * np.abs(mesh.points).max()] = 0
        direction = np.where(np.abs(area) < NEAR_0 * size, 0, area)
        found.append((2 * scale * np.sqrt(size / np.pi), middle, direction / np.linalg.norm(direction)))
    found.sort(key=lambda end: -end[0])
    return [End(k + 1, middle, direction, float(width)) for k, (width, middle, direction) in enumerate(found)]

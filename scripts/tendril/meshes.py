"""Triangle meshes as signed distances: read, checked, measured from.

VTK does the reading (STL, OBJ, PLY, VTP, VTK) and finds the nearest triangle. A mesh stands for the smooth
surface that it was made from: between its corners the surface is bent as the normals in the corners say
(Phong tessellation, exact for a surface of second degree), but for edges sharper than SHARP, which stay."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from .errors import TendrilError, optional

SHARP = np.radians(30)
ROUNDS = 2  # towards the nearest point of the smooth surface


class SurfaceError(TendrilError):
    """What cannot be a surface, in one plain line."""


def vtk_parts(*names):
    """Classes of VTK, or the line that says that it is missing."""
    homes = {"vtkSTLReader": "IOGeometry", "vtkOBJReader": "IOGeometry", "vtkPLYReader": "IOPLY",
             "vtkXMLPolyDataReader": "IOXML", "vtkPolyDataReader": "IOLegacy",
             "vtkTriangleFilter": "FiltersCore", "vtkCleanPolyData": "FiltersCore",
             "vtkImplicitPolyDataDistance": "FiltersCore", "vtkStaticCellLocator": "CommonDataModel",
             "vtkPolyData": "CommonDataModel", "vtkCellArray": "CommonDataModel",
             "vtkPoints": "CommonCore", "vtkObject": "CommonCore", "vtkIdTypeArray": "CommonCore", "vtkDoubleArray": "CommonCore",
             "reference": "CommonCore"}
    missing = "surfaces from meshes and VMTK's centre lines need VTK: pip install 'tendril[space]', or pip install vtk"
    return [getattr(optional(f"vtkmodules.vtk{homes[name]}", SurfaceError, missing), name) for name in names]


def polydata(path):
    """What VTK reads from a file."""
    kinds = {".stl": "vtkSTLReader", ".obj": "vtkOBJReader", ".ply": "vtkPLYReader",
             ".vtp": "vtkXMLPolyDataReader", ".vtk": "vtkPolyDataReader"}
    path = Path(path)
    kind = kinds.get(path.suffix.lower())
    if not kind:
        raise SurfaceError(f"{path}: a mesh is STL, OBJ, PLY, VTP or VTK")
    if not path.is_file():
        raise SurfaceError(f"{path}: no such file")
    reader = vtk_parts(kind)[0]()
    reader.SetFileName(str(path))
    loud = vtk_parts("vtkObject")[0]
    loud.GlobalWarningDisplayOff()  # what is wrong is said below, in one line
    reader.Update()
    loud.GlobalWarningDisplayOn()
    data = reader.GetOutput()
    if data is None or not data.GetNumberOfPoints():
        raise SurfaceError(f"{path}: holds no mesh that VTK can read")
    return data


@dataclass
class Mesh:
    points: np.ndarray  # [n, 3]
    triangles: np.ndarray  # [m, 3], counterclockwise as seen from outside
    name: str = "mesh"
    own: int | None = None  # how many of the triangles are the surface's own, the first; None: all

    @property
    def corners(self):
        return self.points[self.triangles]

    def volume(self):
        a, b, c = np.moveaxis(self.corners - self.points.mean(axis=0), 1, 0)
        return np.einsum("ij,ij->", a, np.cross(b, c)) / 6

    def edges(self):
        """Directed edges, three a triangle."""
        return self.triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)


def read_mesh(path):
    """The triangles of a file; corners at the same place are one."""
    data = polydata(path)
    from vtkmodules.util.numpy_support import vtk_to_numpy

    if not data.GetNumberOfPolys() and not data.GetNumberOfStrips():
        raise SurfaceError(f"{path}: has points but no triangles; is it a centre line, or a cloud of points?")
    triangulate, clean = (part() for part in vtk_parts("vtkTriangleFilter", "vtkCleanPolyData"))
    triangulate.SetInputData(data)
    triangulate.PassLinesOff()
    triangulate.PassVertsOff()
    clean.SetInputConnection(triangulate.GetOutputPort())
    clean.SetTolerance(0)
    clean.Update()
    data = clean.GetOutput()
    points = vtk_to_numpy(data.GetPoints().GetData()).astype(float)
    triangles = vtk_to_numpy(data.GetPolys().GetConnectivityArray()).reshape(-1, 3).astype(np.int64)
    if not np.isfinite(points).all():
        raise SurfaceError(f"{path}: a corner is not finite")
    return Mesh(points, triangles, str(path))


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


def place_of(mesh, edge):
    return "near (" + ", ".join(f"{v:.4g}" for v in mesh.points[edge[0]]) + ")"


def check(mesh, flip=False):
    """Refuses what has no inside; returns the mesh, turned if it is to be."""
    holes, many, against = boundary(mesh)
    if len(many):
        raise SurfaceError(f"{mesh.name}: at {len(many) // 3} edges more than two triangles meet, the first "
                           f"{place_of(mesh, many[0])}; mend the mesh")
    if len(holes):
        raise SurfaceError(f"{mesh.name}: has holes: {len(holes)} edges belong to one triangle only, the first "
                           f"{place_of(mesh, holes[0])}; close them, or, if they are the ends of a vessel, give open")
    if len(against):
        raise SurfaceError(f"{mesh.name}: triangles face different ways, the first {place_of(mesh, against[0])}; "
                           "mend the mesh")
    if flip:
        mesh = Mesh(mesh.points, mesh.triangles[:, ::-1], mesh.name, mesh.own)
    if mesh.volume() <= 0:
        raise SurfaceError(f"{mesh.name}: is inside out: its triangles run clockwise as seen from outside; give flip")
    return mesh


def loops_of(edges):
    """Closed rings of directed edges."""
    after = dict(edges.tolist())
    loops = []
    while after:
        first = next(iter(after))
        ring, at = [first], after.pop(first)
        while at != first:
            ring.append(at)
            if at not in after:
                raise SurfaceError("a hole's rim does not close; mend the mesh")
            at = after.pop(at)
        loops.append(np.array(ring))
    return loops


def extended(mesh, diameters=2.0):
    """The mesh with its open ends led on straight, by so many of their diameters, and closed there: a rod
    that leaves the vessel meets no lid at its end."""
    holes = boundary(mesh)[0]
    if not len(holes):
        raise SurfaceError(f"{mesh.name}: open, but it has no open end")
    points, triangles = [mesh.points], [mesh.triangles]
    n = len(mesh.points)
    for ring in loops_of(holes):
        rim = mesh.points[ring]
        middle = rim.mean(axis=0)
        area = np.cross(rim - middle, np.roll(rim, -1, axis=0) - middle).sum(axis=0) / 2
        size = np.linalg.norm(area)
        if size == 0:
            raise SurfaceError(f"{mesh.name}: an open end has no area; mend the mesh")
        out = -area / size  # the mesh is on the left of its rim's edges
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
    return Mesh(np.concatenate(points), np.concatenate(triangles), mesh.name, len(mesh.triangles))


# ---- distances ----


def corner_normals(mesh):
    """[m, 3, 3]: in each corner the normal of the smooth surface, by Max's weights, which are exact for a
    sphere; of the triangles that are not beyond a sharp edge. And which triangles have a sharp corner."""
    x = mesh.corners
    face = np.cross(x[:, 1] - x[:, 0], x[:, 2] - x[:, 0])
    size = np.linalg.norm(face, axis=1, keepdims=True)
    unit = face / np.maximum(size, 1e-300)
    weighted = np.empty_like(x)
    for k in range(3):
        a, b = x[:, (k + 1) % 3] - x[:, k], x[:, (k + 2) % 3] - x[:, k]
        lengths = np.einsum("ij,ij->i", a, a) * np.einsum("ij,ij->i", b, b)
        weighted[:, k] = np.cross(a, b) / np.maximum(lengths, 1e-300)[:, None]
    flat = mesh.triangles.ravel()
    order = np.argsort(flat, kind="stable")
    starts = np.searchsorted(flat[order], np.arange(len(mesh.points) + 1))
    count = np.diff(starts)
    normals = np.zeros((len(flat), 3))
    sharp = np.zeros(len(flat), bool)
    weight = weighted.reshape(-1, 3)
    for many in np.unique(count[count > 0]):  # corners where so many triangles meet
        at = order[starts[:-1][count == many][:, None] + np.arange(many)]  # [corners, many]
        n = unit[at // 3]
        near = np.einsum("aik,ajk->aij", n, n) > np.cos(SHARP)
        normals[at] = np.einsum("aij,ajk->aik", near, weight[at])
        sharp[at] = ~near.all(axis=2)
    normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-300)
    return normals.reshape(-1, 3, 3), sharp.reshape(-1, 3).any(axis=1)


class Distance:
    """Signed distances from a closed mesh, below 0 within it."""

    def __init__(self, mesh):
        from vtkmodules.util.numpy_support import numpy_to_vtk, numpy_to_vtkIdTypeArray

        vtkPolyData, vtkCellArray, vtkPoints, exact, locator = vtk_parts(
            "vtkPolyData", "vtkCellArray", "vtkPoints", "vtkImplicitPolyDataDistance", "vtkStaticCellLocator")
        self.mesh = mesh
        points, cells, self.data = vtkPoints(), vtkCellArray(), vtkPolyData()
        points.SetDataTypeToDouble()
        points.SetData(numpy_to_vtk(np.ascontiguousarray(mesh.points), deep=True))
        m = len(mesh.triangles)
        cells.ImportLegacyFormat(numpy_to_vtkIdTypeArray(
            np.column_stack([np.full(m, 3), mesh.triangles]).astype(np.int64).ravel(), deep=True))
        self.data.SetPoints(points)
        self.data.SetPolys(cells)
        self.exact, self.locator = exact(), locator()
        self.exact.SetInput(self.data)
        self.locator.SetDataSet(self.data)
        self.locator.BuildLocator()
        self.normals, self.sharp = corner_normals(mesh)

    def facets(self, x):
        """From the triangles themselves."""
        from vtkmodules.util.numpy_support import numpy_to_vtk, vtk_to_numpy

        given = numpy_to_vtk(np.ascontiguousarray(x, float), deep=True)
        result = vtk_parts("vtkDoubleArray")[0]()
        result.SetNumberOfTuples(len(x))
        self.exact.FunctionValue(given, result)
        return vtk_to_numpy(result).copy()

    def nearest(self, x):
        """The nearest triangle of each place, and where on it."""
        reference = vtk_parts("reference")[0]
        cell, sub, d2, at = reference(0), reference(0), reference(0.0), [0.0, 0.0, 0.0]
        which, where = np.empty(len(x), int), np.empty((len(x), 3))
        for k, place in enumerate(x.tolist()):
            self.locator.FindClosestPoint(place, at, cell, sub, d2)
            which[k], where[k] = cell.get(), at
        return which, where

    def smooth(self, x):
        """From the smooth surface that the mesh stands for, for places near it."""
        d = self.facets(x)
        which, p = self.nearest(x)
        rough = self.sharp[which]
        d[rough] -= self.bulge(which[rough], p[rough])[0]
        x, which, p, d1 = x[~rough], which[~rough], p[~rough], d[~rough]
        on = np.ones(len(x), bool)
        for k in range(ROUNDS + 1):
            height, n, foot = self.bulge(which, p)
            d1 = np.where(on, np.einsum("ij,ij->i", x - foot, n), d1)
            if k < ROUNDS:
                which, p = self.nearest(x - d1[:, None] * n)
                on &= ~self.sharp[which]
        d[~rough] = d1
        return d

    def bulge(self, which, p):
        """At places of triangles: how high the smooth surface is above them, its normal, its place."""
        corners = self.mesh.points[self.mesh.triangles[which]]
        a, b, c = np.moveaxis(corners, 1, 0)
        n = np.cross(b - a, c - a)
        area = np.maximum(np.einsum("ij,ij->i", n, n), 1e-300)
        share = np.stack([np.einsum("ij,ij->i", n, np.cross(c - b, p - b)),
                          np.einsum("ij,ij->i", n, np.cross(a - c, p - c)),
                          np.einsum("ij,ij->i", n, np.cross(b - a, p - a))], axis=1) / area[:, None]
        share = np.clip(share, 0, 1)
        normals = self.normals[which]
        off = np.einsum("ijk,ijk->ij", p[:, None] - corners, normals)  # above tangent planes
        shift = -np.einsum("ij,ij,ijk->ik", share, off, normals) / 2  # a parabola is half as high as its tangents
        normal = np.einsum("ij,ijk->ik", share, normals)
        normal /= np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-300)
        return np.einsum("ij,ij->i", shift, n) / np.sqrt(area), normal, p + shift

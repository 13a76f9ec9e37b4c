"""Triangle meshes as signed distances: read, and measured from.

VTK finds the nearest triangle. A mesh stands for the smooth
surface that it was made from: between its corners the surface is bent as the normals in the corners say
(Phong tessellation, exact for a surface of second degree), but for edges sharper than SHARP, which stay."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from .mesh_files import SurfaceError, count_of, heard, polydata, vtk_parts

SHARP = np.radians(30)
ROUNDS = 2  # towards the nearest point of the smooth surface


@dataclass
class Mesh:
    points: np.ndarray  # [n, 3]
    triangles: np.ndarray  # [m, 3], counterclockwise as seen from outside
    name: str = "mesh"
    own: int | None = None  # how many of the triangles are the surface's own, the first; None: all
    notes: list[str] = field(default_factory=list)  # what was left out or turned on the way

    @property
    def corners(self):
        return self.points[self.triangles]

    def edges(self):
        """Directed edges, three a triangle."""
        return self.triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)


def read_mesh(path):
    """The triangles of a file; corners at the same place are one."""
    notes = []
    data = polydata(path, notes)
    from vtkmodules.util.numpy_support import vtk_to_numpy

    if not data.GetNumberOfPolys() and not data.GetNumberOfStrips():
        raise SurfaceError(f"{path}: has points but no triangles; is it a centre line, or a cloud of points?")
    places = vtk_to_numpy(data.GetPoints().GetData())
    if not np.isfinite(places).all():
        raise SurfaceError(f"{path}: point {int(np.argmin(np.isfinite(places).all(axis=1))) + 1} is not finite")
    for cells in (data.GetPolys(), data.GetStrips()):
        ids = vtk_to_numpy(cells.GetConnectivityArray())
        if len(ids) and not (ids.min() >= 0 and ids.max() < len(places)):
            raise SurfaceError(f"{path}: a face names a point that there is not: there are {len(places)}")
    triangulate, clean = (part() for part in vtk_parts("vtkTriangleFilter", "vtkCleanPolyData"))
    triangulate.SetInputData(data)
    triangulate.PassLinesOff()
    triangulate.PassVertsOff()
    clean.SetInputConnection(triangulate.GetOutputPort())
    clean.SetTolerance(0)
    heard(clean.Update)
    sizes = np.diff(vtk_to_numpy(data.GetPolys().GetOffsetsArray()))
    less = int((sizes < 3).sum()) + triangulate.GetOutput().GetNumberOfPolys() - clean.GetOutput().GetNumberOfPolys()
    if less:
        notes.append(f"{count_of(less, 'face')} of fewer than three different corners left out")
    data = clean.GetOutput()
    if not data.GetNumberOfPolys():
        raise SurfaceError(f"{path}: none of its faces has three different corners")
    points = vtk_to_numpy(data.GetPoints().GetData()).astype(float)
    triangles = vtk_to_numpy(data.GetPolys().GetConnectivityArray()).reshape(-1, 3).astype(np.int64)
    return Mesh(points, triangles, str(path), notes=notes)


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

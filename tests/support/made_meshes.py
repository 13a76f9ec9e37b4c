"""Meshes whose surface is known, and files of them in all forms that are read."""

import struct
import sys
import unittest
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path

from interpreter import ROOT

sys.path.insert(0, str(ROOT / "scripts"))
import numpy as np

from tendril import meshes
from tendril.meshes import Mesh


def sphere(n=24, centre=(0, 0, 0), radius=1.0):
    """Rings of triangles."""
    a = np.linspace(0, np.pi, n + 1)[1:-1]
    b = 2 * np.pi * np.arange(2 * n) / (2 * n)
    rings = np.stack([np.sin(a)[:, None] * np.cos(b), np.sin(a)[:, None] * np.sin(b), np.cos(a)[:, None] + 0 * b], -1)
    x = np.concatenate([rings.reshape(-1, 3), [[0, 0, 1], [0, 0, -1]]])
    m = 2 * n
    at = np.arange(len(a))[:-1, None] * m
    i, j = np.arange(m), (np.arange(m) + 1) % m
    t = np.concatenate([np.stack([at + i, at + m + i, at + m + j], -1).reshape(-1, 3),
                        np.stack([at + i, at + m + j, at + j], -1).reshape(-1, 3),
                        np.stack([np.full(m, len(x) - 2), i, j], -1),
                        np.stack([np.full(m, len(x) - 1), (len(a) - 1) * m + j, (len(a) - 1) * m + i], -1)])
    return Mesh(np.asarray(centre) + radius * x, t)


def pipe(radius=1.0, length=4.0, n=40, m=40):
    """A cylinder's wall about x1, open at both ends, its normals outwards."""
    b = 2 * np.pi * np.arange(n) / n
    z = np.linspace(0, length, m + 1)
    x = np.stack(np.broadcast_arrays(z[:, None], radius * np.cos(b), radius * np.sin(b)), -1).reshape(-1, 3)
    at, i, j = np.arange(m)[:, None] * n, np.arange(n), (np.arange(n) + 1) % n
    t = np.concatenate([np.stack([at + i, at + j, at + n + i], -1).reshape(-1, 3),
                        np.stack([at + j, at + n + j, at + n + i], -1).reshape(-1, 3)])
    return Mesh(x, t)


def cube(size=1.0):
    x = size * (np.array([[k & 1, k >> 1 & 1, k >> 2] for k in range(8)]) - 0.5)
    quads = [(0, 4, 6, 2), (1, 3, 7, 5), (0, 1, 5, 4), (2, 6, 7, 3), (0, 2, 3, 1), (4, 5, 7, 6)]
    return Mesh(x, np.array([t for q in quads for t in ((q[0], q[1], q[2]), (q[0], q[2], q[3]))]))


def write_stl(path, mesh):
    """Binary: 80 bytes, a count, and of each triangle its normal and corners."""
    with open(path, "wb") as f:
        f.write(b"\0" * 80 + struct.pack("<I", len(mesh.triangles)))
        for corners in mesh.corners:
            f.write(struct.pack("<12fH", 0, 0, 0, *corners.ravel(), 0))


def write_obj(path, mesh):
    lines = ["v {:.17g} {:.17g} {:.17g}".format(*x) for x in mesh.points]
    Path(path).write_text("\n".join(lines + ["f {} {} {}".format(*(t + 1)) for t in mesh.triangles]) + "\n")


def as_vtk(mesh):
    return meshes.Distance(mesh).data


def by_vtk(home, name):
    def write(path, mesh):
        writer = getattr(import_module(f"vtkmodules.{home}"), name)()
        writer.SetFileName(str(path))
        writer.SetInputData(as_vtk(mesh) if isinstance(mesh, Mesh) else mesh)
        writer.Write()

    return write


WRITERS = {"stl": write_stl, "obj": write_obj, "ply": by_vtk("vtkIOPLY", "vtkPLYWriter"),
           "vtp": by_vtk("vtkIOXML", "vtkXMLPolyDataWriter"), "vtk": by_vtk("vtkIOLegacy", "vtkPolyDataWriter")}
VTK = find_spec("vtkmodules")
needs_vtk = unittest.skipUnless(VTK, "vtk is not installed")

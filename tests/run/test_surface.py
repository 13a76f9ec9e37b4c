#!/usr/bin/env python3
"""Surfaces from meshes and centre lines: distances against spheres, cylinders and boxes that are written
down, what has no inside is refused, paths as VMTK, 3D Slicer and well surveys say them.

    test_surface.py"""

import json
import os
import struct
import subprocess
import sys
import tempfile
import unittest
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path

from interpreter import ROOT, from_venv

os.environ.setdefault("OMP_NUM_THREADS", "1")
sys.path.insert(0, str(ROOT / "scripts"))
try:
    import h5py
    import numpy as np

    import tendril
    from tendril import meshes, openings
    from tendril.meshes import Mesh, SurfaceError
except ImportError as error:
    from_venv(error)


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


class Files(unittest.TestCase):
    def setUp(self):
        self.directory = tempfile.TemporaryDirectory(prefix="tendril-")
        self.addCleanup(self.directory.cleanup)
        self.rng = np.random.default_rng(3)

    def at(self, name):
        return Path(self.directory.name) / name

    def file(self, name, text):
        self.at(name).write_text(text)
        return self.at(name)

    def mesh(self, mesh, name="mesh.obj"):
        WRITERS[name.split(".")[-1]](self.at(name), mesh)
        return self.at(name)

    def refused(self, words, call, *args, **more):
        with self.assertRaises(SurfaceError) as caught:
            call(*args, **more)
        text = str(caught.exception)
        self.assertNotIn("\n", text)
        for word in words.split("|"):
            self.assertIn(word, text)

    def values(self, path):
        """The file's spline, looked at with scipy."""
        from scipy.interpolate import RegularGridInterpolator

        with h5py.File(path) as f:
            d, origin, spacing = f["distance"][:], f["origin"][:], f["spacing"][:]
        axes = [origin[k] + spacing[k] * np.arange(d.shape[2 - k]) for k in range(3)]
        return RegularGridInterpolator(axes, d.transpose(2, 1, 0), method="cubic"), axes


@needs_vtk
class Meshes(Files):
    def test_sphere_in_all_formats(self):
        """The triangles are 6e-3 from the sphere that they stand for, the distance is not."""
        e = self.rng.normal(size=(300, 3))
        e /= np.linalg.norm(e, axis=1)[:, None]
        far = self.rng.uniform(-0.2, 0.2, 300)
        centre = np.array([3.0, -1, 2])
        ball = sphere(24, centre)
        made = tendril.surface(self.mesh(ball), self.at("ball.h5"), diameter=0.4)
        d, _ = self.values(made.path)
        self.assertLess(np.abs(d(centre + (1 + far)[:, None] * e) - far).max(), 4e-4)
        self.assertLess(made.error, 8e-4)
        self.assertGreater(made.facets, 3e-3)
        self.assertLess(made.facets, 1.2e-2)
        self.assertLessEqual(made.spacing, 0.2)
        self.assertEqual(made.line, f"body {made.path} outside")
        for kind in WRITERS:
            read = openings.check(meshes.read_mesh(self.mesh(ball, f"ball.{kind}")))
            self.assertEqual(read.points.shape, ball.points.shape, kind)
            np.testing.assert_allclose(np.sort(read.corners.mean(axis=1), axis=0),
                                       np.sort(ball.corners.mean(axis=1), axis=0), atol=1e-6)

    def test_twenty_thousand_triangles(self):
        ball = sphere(71)
        distance = meshes.Distance(ball)
        e = self.rng.normal(size=(500, 3))
        e /= np.linalg.norm(e, axis=1)[:, None]
        for far in (-0.1, 0, 0.1):
            self.assertGreater(np.abs(distance.facets((1 + far) * e) - far).max(), 2e-4)
            self.assertLess(np.abs(distance.smooth((1 + far) * e) - far).max(), 2e-6)

    def test_facets(self):
        """Asked for, the triangles themselves; a cube's edges are sharp in both."""
        made = tendril.surface(self.mesh(sphere(24)), self.at("f.h5"), diameter=0.4, facets=True, spacing=0.1)
        self.assertIsNone(made.facets)
        x = self.rng.uniform(-0.8, 0.8, (400, 3))
        box = np.abs(x) - 0.5
        exact = np.linalg.norm(np.maximum(box, 0), axis=1) + np.minimum(box.max(axis=1), 0)
        distance = meshes.Distance(cube())
        np.testing.assert_allclose(distance.facets(x), exact, atol=1e-12)
        np.testing.assert_allclose(distance.smooth(x), exact, atol=1e-12)
        made = tendril.surface(self.mesh(cube(), "c.stl"), self.at("c.h5"), diameter=0.2, spacing=0.04)
        self.assertGreater(made.error, 1e-4)  # the spline rounds the edges, and says so
        self.assertLess(made.error, 0.04)

    def test_error_is_that_which_is_stated(self):
        """Against the exact sphere, at places the program did not choose; finer when a finer one is asked."""
        errors = []
        for tolerance in (1e-2, 1e-4):
            made = tendril.surface(self.mesh(sphere(71)), self.at("s.h5"), diameter=0.8, tolerance=tolerance)
            d, _ = self.values(made.path)
            e = self.rng.normal(size=(300, 3))
            e /= np.linalg.norm(e, axis=1)[:, None]
            errors.append(np.abs(d(1.2 * e) - 0.2).max())
            self.assertLess(errors[-1], 2 * made.error)
            self.assertLess(made.error, tolerance)
        self.assertLess(errors[1], 0.1 * errors[0])

    def test_open_ends(self):
        short = self.mesh(pipe(length=2, m=20), "pipe.ply")
        made = tendril.surface(short, self.at("p.h5"), diameter=0.4, side="inside", open=True)
        d, axes = self.values(made.path)
        self.assertLess(axes[0][0], -2)  # led on by two diameters
        x = np.column_stack([np.linspace(-1.5, 3.5, 50), 0.7 * np.cos(np.arange(50)), 0.7 * np.sin(np.arange(50))])
        np.testing.assert_allclose(d(x), -0.3, atol=3e-3)
        box = tendril.surface(short, self.at("b.h5"), diameter=0.4, open=True, box=(0, -1.5, -1.5, 2, 1.5, 1.5))
        _, axes = self.values(box.path)
        self.assertEqual(axes[0][0], 0)

    def test_refused(self):
        holes = sphere()
        holes.triangles = holes.triangles[5:]
        call = tendril.surface
        self.refused("has holes|edges belong to one triangle|open", call, self.mesh(holes), "x.h5", diameter=0.4)
        turned = sphere()
        turned.triangles = turned.triangles[:, ::-1]
        self.assertEqual(call(self.mesh(turned), self.at("flip.h5"), diameter=0.4, flip=True).line, f"body {self.at('flip.h5')} outside")
        self.refused("inside out with flip|leave flip away", call, self.mesh(sphere()), "x.h5", diameter=0.4, flip=True)
        mixed = sphere()
        mixed.triangles[7] = mixed.triangles[7, ::-1]
        self.refused("face different ways", call, self.mesh(mixed), "x.h5", diameter=0.4)
        ball = sphere()
        thick = Mesh(np.concatenate([ball.points, [[0, 0, 3]]]),
                     np.concatenate([ball.triangles, [[*ball.triangles[0, :2], len(ball.points)]]]))
        self.refused("more than two triangles", call, self.mesh(thick), "x.h5", diameter=0.4)
        good = self.mesh(sphere(), "good.obj")
        self.refused("diameter", call, good, "x.h5")
        self.refused("values|larger spacing", call, good, "x.h5", spacing=0.001)
        self.refused("diameter|above 0", call, good, "x.h5", diameter=-1)
        self.refused("side", call, good, "x.h5", diameter=1, side="left")
        self.refused("radius|mesh", call, good, "x.h5", diameter=1, radius=2)
        self.refused("no open end", call, good, "x.h5", diameter=1, open=True)
        self.refused("nowhere in it", call, good, "x.h5", diameter=1, box=[5, 5, 5, 6, 6, 6])
        both = Mesh(np.concatenate([ball.points, ball.points + [1.2, 0, 0]]),
                    np.concatenate([ball.triangles, ball.triangles + len(ball.points)]))
        self.refused("runs through itself", call, self.mesh(both), "x.h5", diameter=1)
        self.refused("no such file", call, self.at("none.stl"), "x.h5", diameter=1)
        self.refused("no mesh", call, self.file("bad.ply", "nothing"), "x.h5", diameter=1)
        self.refused("STL, OBJ", meshes.polydata, self.file("bad.step", "nothing"))

    def test_command(self):
        done = subprocess.run([ROOT / "scripts/surface.sh", self.mesh(sphere(12)), self.at("s.h5"), "--diameter", "1",
                               "--unit", "mm"], capture_output=True, text=True,
                              env={**os.environ, "PYTHON": sys.executable})
        self.assertEqual(done.stderr, "")
        self.assertEqual(done.stdout.splitlines()[-1], f"body {self.at('s.h5')} outside")
        with h5py.File(self.at("s.h5")) as f:
            self.assertEqual([f[name].attrs["units"] for name in ("distance", "origin", "spacing")], ["mm"] * 3)
            self.assertEqual(f["mesh/triangles"].shape[1], 3)


class CentreLines(Files):
    def test_without_vtk(self):
        block = "import sys; sys.modules['vtkmodules'] = None; from tendril.surfaces import main; sys.exit(main())"
        done = subprocess.run([sys.executable, "-c", block, str(self.mesh(sphere(6))), "x.h5", "--diameter", "1"],
                              capture_output=True, text=True, env={**os.environ, "PYTHONPATH": str(ROOT / "scripts")})
        self.assertEqual(done.returncode, 1)
        self.assertEqual(done.stderr, "surface: surfaces from meshes and VMTK's centre lines need VTK: pip install "
                         "'tendril[space]', or pip install vtk\n")

    def helix(self, n=60):
        a = np.linspace(0, 4, n)
        return np.column_stack([3 * np.cos(a), 3 * np.sin(a), a, 0.5 + 0.1 * np.sin(a)])

    def table(self, path):
        lines = path.read_text().splitlines()
        self.assertEqual(lines[0], "x1,x2,x3,radius")
        return np.array([[float(c) for c in line.split(",")] for line in lines[1:]])

    def made(self, name, text=None, **more):
        path = self.at(name) if text is None else self.file(name, text)
        made = tendril.surface(path, self.at("out.csv"), **more)
        self.assertEqual(made.line, f"tube {self.at('out.csv')} inside")
        return self.table(made.path)

    def test_formats(self):
        x = self.helix()
        cells = "\n".join(",".join(f"{v:.15g}" for v in row) for row in x)
        np.testing.assert_allclose(self.made("a.csv", "x,y,z,r\n" + cells), x, atol=1e-10)
        np.testing.assert_allclose(self.made("b.csv", "# by hand\n" + cells), x, atol=1e-10)
        np.testing.assert_allclose(self.made("c.dat", "X Y Z MaximumInscribedSphereRadius Length\n" +
                                             cells.replace(",", " ").replace("\n", " 1\n") + " 1\n"), x, atol=1e-10)
        np.testing.assert_allclose(self.made("d.csv", "label,l,p,s,Radius (mm)\n" + "\n".join(
            "c-1," + row for row in cells.splitlines())), x, atol=1e-10)
        markup = {"markups": [{"type": "Curve", "controlPoints": [{"position": list(p)} for p in x[:, :3]],
                               "measurements": [{"name": "Radius", "controlPointValues": list(x[:, 3])}]}]}
        np.testing.assert_allclose(self.made("e.mrk.json", json.dumps(markup)), x, atol=1e-10)

    @needs_vtk
    def test_vmtk(self):
        x = self.helix()
        from vtkmodules.util.numpy_support import numpy_to_vtk
        from vtkmodules.vtkCommonCore import vtkPoints
        from vtkmodules.vtkCommonDataModel import vtkCellArray, vtkPolyData

        points, lines, data = vtkPoints(), vtkCellArray(), vtkPolyData()
        points.SetDataTypeToDouble()
        points.SetData(numpy_to_vtk(x[:, :3].copy(), deep=True))
        for ids in (range(3), range(len(x))):
            lines.InsertNextCell(len(ids))
            for k in ids:
                lines.InsertCellPoint(k)
        data.SetPoints(points)
        data.SetLines(lines)
        radii = numpy_to_vtk(x[:, 3].copy(), deep=True)
        radii.SetName("MaximumInscribedSphereRadius")
        data.GetPointData().AddArray(radii)
        for name in ("f.vtp", "g.vtk"):
            WRITERS[name[-3:]](self.at(name), data)
            np.testing.assert_allclose(self.made(name, line=1), x, atol=1e-5 if name == "g.vtk" else 1e-10)
        self.refused("2 lines|no 2", self.made, "f.vtp", line=2)

    def test_placed(self):
        x = self.made("a.csv", "x,y,z,r\n1,1,1,0.5\n1,1,3,0.5\n1,2,5,0.5\n", origin="start", direction="start", scale=2.0)
        np.testing.assert_allclose(x[:2], [[0, 0, 0, 1], [4, 0, 0, 1]], atol=1e-12)
        self.assertAlmostEqual(np.linalg.norm(x[2, :3] - x[1, :3]), 2 * np.sqrt(5))
        done = tendril.surface(self.at("a.csv"), self.at("u.csv"), unit="mm", radius=2.0, side="outside")
        self.assertEqual(done.path.read_text().splitlines()[1], "1mm,1mm,1mm,2mm")
        self.assertEqual(done.side, "outside")

    def test_survey(self):
        """A quarter of a circle from straight down to level, eastwards: exact by minimum curvature. And a
        station after a station, against the formula of the trade."""
        x = self.made("w.csv", f"MD (m),Inclination (deg),Azimuth (deg)\n0,0,90\n100,0,90\n{100 + 100 * np.pi / 2},90,90\n",
                      radius=0.1)
        np.testing.assert_allclose(x[-1], [0, 100, -200, 0.1], atol=1e-9)
        bend = x[2:]
        np.testing.assert_allclose(np.hypot(bend[:, 1] - 100, bend[:, 2] + 100), 100, atol=1e-9)
        self.assertGreater(len(x), 40)
        stations = np.array([[0, 10, 20], [35, 25, 60], [90, 50, 55], [120, 50, 55]])
        x = self.made("v.csv", "md,inc,azi,radius\n" + "\n".join(",".join(map(str, [*s, 0.2])) for s in stations))
        at = np.zeros(3)
        for (m0, i0, a0), (m1, i1, a1) in zip(stations[:-1], stations[1:]):
            i0, i1, a0, a1 = np.radians([i0, i1, a0, a1])
            dog = np.arccos(np.clip(np.cos(i1 - i0) - np.sin(i0) * np.sin(i1) * (1 - np.cos(a1 - a0)), -1, 1))
            ratio = 1 if dog < 1e-9 else 2 / dog * np.tan(dog / 2)
            at += (m1 - m0) / 2 * ratio * np.array([np.sin(i0) * np.cos(a0) + np.sin(i1) * np.cos(a1),
                                                    np.sin(i0) * np.sin(a0) + np.sin(i1) * np.sin(a1),
                                                    -np.cos(i0) - np.cos(i1)])
            self.assertLess(np.linalg.norm(x[:, :3] - at, axis=1).min(), 1e-9)
        self.refused("must increase", self.made, "u.csv", "md,inc,azi,r\n0,0,0,1\n5,0,0,1\n4,0,0,1\n")

    def test_noise(self):
        """Points every twentieth of the radius, off by a hundredth: what comes out bends as the path does."""
        a = np.linspace(0, 3, 600)
        x = np.column_stack([5 * np.cos(a), 5 * np.sin(a), a, 0.5 + 0 * a])
        noisy = x + 0.005 * self.rng.normal(size=x.shape)
        y = self.made("n.csv", "x,y,z,r\n" + "\n".join(",".join(map(str, row)) for row in noisy))
        self.assertLess(len(y), 200)
        off = np.array([np.linalg.norm(x[:, :3] - p, axis=1).min() for p in y[:, :3]])
        self.assertLess(off.max(), 0.02)
        turn = np.diff(y[:, :3], axis=0)
        turn /= np.linalg.norm(turn, axis=1)[:, None]
        curvature = np.linalg.norm(np.diff(turn, axis=0), axis=1) / np.linalg.norm(np.diff(y[1:, :3], axis=0), axis=1)
        self.assertLess(curvature.max(), 1.0)  # twice as much as r allows were the noise in it
        sharp = np.diff(noisy[:, :3], axis=0)
        sharp /= np.linalg.norm(sharp, axis=1)[:, None]
        self.assertGreater(np.linalg.norm(np.diff(sharp, axis=0), axis=1).max() / 0.025, 5)

    def test_refused(self):
        self.refused("says no radius", self.made, "a.csv", "x,y,z\n0,0,0\n1,0,0\n")
        self.refused("above 0", self.made, "a.csv", "x,y,z,r\n0,0,0,1\n1,0,0,0\n")
        self.refused("not finite", self.made, "a.csv", "x,y,z,r\n0,0,0,1\n1,0,,1\n")
        self.refused("two points", self.made, "a.csv", "x,y,z,r\n0,0,0,1\n0,0,0,1\n")
        self.refused("needs x, y, z", self.made, "a.csv", "x,y,q,r\n0,0,0,1\n0,0,0,1\n")
        self.refused("has 3 cells, not 4", self.made, "a.csv", "x,y,z,r\n0,0,0\n")
        self.refused("is empty", self.made, "a.csv", "# nothing\n")
        self.refused("3D Slicer", self.made, "a.json", "{}")
        self.refused("open|centre line", self.made, "a.csv", "x,y,z,r\n0,0,0,1\n1,0,0,1\n", open=True)


if __name__ == "__main__":
    unittest.main()

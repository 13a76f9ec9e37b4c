#!/usr/bin/env python3
# test: surfaces are those of known meshes and centre lines
"""Surfaces from meshes and centre lines: distances against spheres, cylinders and boxes that are written
down, what has no inside is refused, paths as VMTK, 3D Slicer and well surveys say them.

    test_surface.py"""

import json
import os
import re
import subprocess
import sys
import tempfile
import unittest
from importlib.util import find_spec
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "support"))
from interpreter import ROOT, from_venv

os.environ.setdefault("OMP_NUM_THREADS", "1")
sys.path.insert(0, str(ROOT / "scripts"))
try:
    import h5py
    import numpy as np

    import tendril
    from tendril import meshes, openings
    from tendril.meshes import Mesh, SurfaceError
    from made_meshes import WRITERS, cube, needs_vtk, pipe, sphere
except ImportError as error:
    from_venv(error)


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
        # (the line is told by what runs all commands)
        block = "import sys; sys.modules['vtkmodules'] = None; from tendril.__main__ import main; sys.exit(main())"
        done = subprocess.run([sys.executable, "-c", block, "surface", str(self.mesh(sphere(6))), "x.h5", "--diameter", "1"],
                              capture_output=True, text=True, env={**os.environ, "PYTHONPATH": str(ROOT / "scripts")})
        self.assertEqual(done.returncode, 1)
        self.assertRegex(done.stderr, r"^surface: .* VTK: pip install 'tendril\[space\]'.*\n$")

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
        np.testing.assert_allclose(self.made("d.csv", "label,l,p,s,Radius\n" + "\n".join(
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

    def pieces(self, name, cells, x=None):
        """A file of lines that are pieces, with radii of 1."""
        from vtkmodules.util.numpy_support import numpy_to_vtk
        from vtkmodules.vtkCommonCore import vtkPoints
        from vtkmodules.vtkCommonDataModel import vtkCellArray, vtkPolyData

        x = np.array([[k, 0.1 * k * k, 0] for k in range(11)], float) if x is None else np.array(x, float)
        points, lines, data = vtkPoints(), vtkCellArray(), vtkPolyData()
        points.SetDataTypeToDouble()
        points.SetData(numpy_to_vtk(x.copy(), deep=True))
        for ids in cells:
            lines.InsertNextCell(len(ids))
            for k in ids:
                lines.InsertCellPoint(int(k))
        data.SetPoints(points)
        data.SetLines(lines)
        radii = numpy_to_vtk(np.ones(len(x)), deep=True)
        radii.SetName("MaximumInscribedSphereRadius")
        data.GetPointData().AddArray(radii)
        WRITERS[name[-3:]](self.at(name), data)
        return x

    @needs_vtk
    def test_pieces(self):
        """Cells of two points are one line, in any order and sense, also where each has points of its own; the branches between
        forks are lines; two lines of VMTK's that begin together stay two."""
        cells = [[k, k + 1] for k in range(10)]
        mixed = [cells[k][::1 - 2 * (k % 3 == 1)] for k in (4, 0, 9, 2, 1, 8, 3, 7, 5, 6)]
        for name, pieces in (("a.vtp", cells), ("b.vtk", cells), ("c.vtp", mixed), ("d.vtp", [[0, 1, 2, 3], [3, 4], [10, 9, 8, 7, 6, 5, 4]])):
            x = self.pieces(name, pieces)
            y = self.made(name)
            np.testing.assert_allclose(y[:, :3], x, atol=1e-5, err_msg=name)
        single = np.array([[k, 0.1 * k * k, 0] for k in range(11)], float)
        self.pieces("own.vtp", [[2 * k, 2 * k + 1] for k in range(10)], np.concatenate([single[k:k + 2] for k in range(10)]))
        np.testing.assert_allclose(self.made("own.vtp")[:, :3], single)
        made = tendril.surface(self.at("own.vtp"), self.at("own.csv"))
        self.assertTrue(any("10 pieces" in note and "1 line" in note for note in made.notes), made.notes)
        fork = [[0, 0, 0], [1, 0, 0], [2, 0, 0], [3, 1, 0], [4, 2, 0], [3, -1, 0]]
        self.pieces("fork.vtp", [[0, 1], [1, 2], [2, 3], [3, 4], [2, 5]], fork)
        for line, ids in enumerate(([0, 1, 2], [2, 3, 4], [2, 5])):
            np.testing.assert_allclose(self.made("fork.vtp", line=line)[:, :3], np.array(fork, float)[ids])
        notes = tendril.surface(self.at("fork.vtp"), self.at("out.csv")).notes
        self.assertTrue(any("3 lines" in note and "--line" in note for note in notes), notes)
        self.refused("3 lines|no 3", self.made, "fork.vtp", line=3)
        self.pieces("vmtk.vtp", [[0, 1, 2, 3, 4], [0, 1, 2, 5]], fork)
        self.assertEqual([len(self.made("vmtk.vtp", line=k, radius=0.1)) for k in (0, 1)], [5, 4])

    def test_lines_of_obj(self):
        head = "".join(f"v {k} {0.1 * k * k} 0\n" for k in range(5))
        for name, lines in (("a.obj", "l 1 2\nl 2 3\nl 4 5\nl 3 4\n"), ("b.obj", "l 1/1 2/2 3 4 5\n"), ("c.obj", "l -5 -4 -3 -2 -1\n"),
                            ("d.obj", "l 1 2 3 \\\n 4 5\n")):
            x = self.made(name, head + lines, radius=2)
            np.testing.assert_allclose(x, [[k, 0.1 * k * k, 0, 2] for k in range(5)], atol=1e-12, err_msg=name)
        self.refused("not there", self.made, "e.obj", head + "l 1 9\n", radius=2)
        self.refused("e.obj, line 1|no vertex", self.made, "e.obj", "v 0 0\nl 1 1\n", radius=2)

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
        x = self.made("w.csv", f"MD,Inclination (deg),Azimuth (deg)\n0,0,90\n100,0,90\n{100 + 100 * np.pi / 2},90,90\n",
                      radius=0.1)
        np.testing.assert_allclose(x[-1], [0, 100, -200, 0.1], atol=1e-9)
        bend = x[x[:, 2] < -100 + 1e-9]
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
        # the spline of the tube through the points is the well's path, also where a long straight piece follows on an arc
        from scipy.interpolate import CubicSpline
        x = self.made("z.csv", "md,inc,azi\n0,0,0\n100,0,0\n400,60,90\n700,90,90\n1500,90,90\n", radius=0.35)[:, :3]
        u = np.concatenate([[0], np.cumsum(np.linalg.norm(np.diff(x, axis=0), axis=1))])
        path = CubicSpline(u, x)(np.linspace(0, u[-1], 3000))
        self.assertLess(np.abs(path[path[:, 2] > -100][:, 1]).max(), 0.02)
        level = path[path[:, 1] > x[-1, 1] - 799]
        self.assertLess(np.abs(level[:, 2] - x[-1, 2]).max(), 0.02)
        # and where a straight piece goes over into a gentle arc that has no shorter steps: straight down for 500, as it was
        x = self.made("g.csv", "md,inc,azi\n0,0,0\n500,0,0\n1000,2,45\n1100,5,45\n1200,10,47\n", radius=0.35)[:, :3]
        u = np.concatenate([[0], np.cumsum(np.linalg.norm(np.diff(x, axis=0), axis=1))])
        path = CubicSpline(u, x)(np.linspace(0, u[-1], 3000))
        self.assertLess(np.hypot(*path[path[:, 2] > -500][:, :2].T).max(), 0.003)
        arc = 500 / np.radians(2)  # the radius of the next piece, about a place beside its beginning
        bent = path[(path[:, 2] < -500) & (path[:, 2] > x[x[:, 2] > -1000][-1, 2])]
        self.assertLess(np.abs(np.hypot(bent[:, :2] @ [0.5**0.5, 0.5**0.5] - arc, bent[:, 2] + 500) - arc).max(), 0.003)
        self.refused("u.csv, line 5|must increase", self.made, "u.csv", "# a well\nmd,inc,azi,r\n0,0,0,1\n5,0,0,1\n4,0,0,1\n")

    def rows(self, name, text=None, **more):
        """(the numbers of the result, its unit, notes)"""
        path = self.at(name) if text is None else self.at(name)
        if text is not None:
            path.write_bytes(text if isinstance(text, bytes) else text.encode())
        made = tendril.surface(path, self.at("out.csv"), **more)
        cells = [line.split(",") for line in made.path.read_text().splitlines()[1:]]
        units = {re.sub("^[-+.e0-9]+", "", cell) for row in cells for cell in row}
        self.assertEqual(len(units), 1, units)
        unit = units.pop()
        return np.array([[float(cell.removesuffix(unit)) for cell in row] for row in cells]), unit, "\n".join(made.notes)

    def test_what_the_rod_asks(self):
        """The rod's diameter in its own unit; where up is in a path that was turned, which its weight must know."""
        sloping = "x (mm),y (mm),z (mm),radius (mm)\n0,0,0,16\n450,0,-218,16\n900,0,-436,16\n"
        for diameter in (32.5, "3.25cm", "1.28in"):
            self.refused("no wider than the rod, of radius 16.2", self.rows, "a.csv", sloping, diameter=diameter)
        self.refused("diameter 12kg: not a unit of length", self.rows, "a.csv", sloping, diameter="12kg")
        self.refused("diameter 3mm: the result has no unit", self.rows, "b.csv", sloping.replace(" (mm)", ""), diameter="3mm")
        path = self.at("a.csv")
        down = np.array([450, 0, -218]) / np.hypot(450, 218)
        self.assertTrue(np.array_equal(tendril.surface(path, self.at("out.csv")).up, [0, 0, 1]))
        for direction in ("start", (450, 0, -218)):
            up = tendril.surface(path, self.at("out.csv"), diameter="12mm", direction=direction).up
            np.testing.assert_allclose(up, [down[2], 0, down[0]], atol=1e-12)

    def test_units_of_files(self):
        """What a file says of its units is taken, converted to --unit, or goes on to the result."""
        path = "x (mm),y (mm),z (mm),radius (mm)\n0,0,0,2\n10,0,0,2\n20,0,0,2\n"
        for unit, factor in (("cm", 0.1), ("m", 1e-3), ("in", 1 / 25.4), ("mm", 1), (None, 1), ("um", 1e3), ("Fr", 3)):
            x, told, _ = self.rows("a.csv", path, unit=unit)
            self.assertEqual(told, unit or "mm")
            np.testing.assert_allclose(x[1], [10 * factor, 0, 0, 2 * factor], rtol=1e-11)
        same = [[0, 0, 0, 2], [10, 0, 0, 2], [20, 0, 0, 2]]
        for text in (path.replace("(mm)", "[mm]"), path.replace(" (mm)", "_mm"), path.replace(" (mm)", "/mm"), path.replace("mm", "Millimeters"),
                     path.replace(" (mm)", "").replace("\n", "\nmm,mm,mm,mm\n", 1), path.replace("radius (mm)", "radius"),
                     "x,y,z,radius\n(mm),(mm),(mm),(cm)\n0,0,0,0.2\n10,0,0,0.2\n20,0,0,0.2\n", "# units: mm\n" + path.replace(" (mm)", ""),
                     "Duct 7,,,\nUnits: mm,,,\n" + path.replace(" (mm)", ""), "# x (mm), y (mm), z (mm), r (mm)\n0 0 0 2\n10 0 0 2\n20 0 0 2\n",
                     "x,y,z,radius\n0mm,0mm,0mm,2mm\n1cm,0mm,0mm,2mm\n0.02m,0mm,0mm,2mm\n", path.replace("radius (mm)", "diameter (mm)").replace(",2\n", ",4\n")):
            x, told, _ = self.rows("b.csv", text, unit="mm")
            self.assertEqual(told, "mm", text)
            np.testing.assert_allclose(x, same, rtol=1e-11, err_msg=text)
        well = "Measured Depth (ft),Inclination (deg),Azimuth (deg)\n0,0,0\n1000,0,0\n2000,30,90\n"
        x, told, _ = self.rows("w.csv", well, radius=0.1, unit="m")
        self.assertLess(np.abs(x - [0, 0, -304.8, 0.1]).max(axis=1).min(), 1e-9)
        y, told, notes = self.rows("w.csv", well, radius="6in")
        self.assertEqual(told, "ft")
        self.assertIn("ft", notes)
        np.testing.assert_allclose(y[:, :3] * 0.3048, x[:, :3], atol=1e-9)
        np.testing.assert_allclose(y[:, 3], 0.5)
        radians = "MD (m),Inc (rad),Azi (rad)\n0,0,0\n304.8,0,0\n609.6,{0:.17g},{1:.17g}\n".format(np.pi / 6, np.pi / 2)
        np.testing.assert_allclose(self.rows("r.csv", radians, radius=0.1)[0][:, :3], x[:, :3], atol=1e-9)
        np.testing.assert_allclose(self.rows("s.csv", well, radius=0.1, scale=0.3048, unit="m")[0], x)
        numbers, told, notes = self.rows("s.csv", well, radius=0.1, scale=2.0)  # the user's own unit
        self.assertEqual((told, bool(np.isclose(numbers[:, 2], -2000).any())), ("", True))
        self.refused("is in ft|0.3048 m|not 2", self.made, "s.csv", radius=0.1, scale=2.0, unit="m")
        for text, words in ((path.replace("(mm)", "(yd)"), "yd|m, cm, mm, um, in, ft, mil, Fr"), (path.replace(" (mm)", "").replace("\n", "\nyd,yd,yd,yd\n", 1), "yd"),
                            (path.replace("x (mm)", "x (px)"), "px"), (path.replace("radius (mm)", "radius (%)"), "%"),
                            (well.replace("Inclination (deg)", "Inclination (%)"), "%|deg, rad"),
                            (well.replace("(ft)", "(furlong)"), "furlong")):
            self.refused(words, self.made, "x.csv", text, radius=None if "radius" in text else 1, unit="mm")
        x, told, _ = self.rows("y.csv", path.replace("(mm)", "(yd)"), scale=0.9144, unit="m")
        self.assertAlmostEqual(x[1, 0], 9.144)
        self.refused("furlong|m, cm, mm, um, in, ft, mil, Fr", self.made, "a.csv", path, unit="furlong")
        for radius, words in (("2s", "2s|not a unit of length"), ("x", "radius x"), (-1, "above 0"), ("0mm", "above 0")):
            self.refused(words, self.made, "a.csv", path, unit="mm", radius=radius)

    def markup(self, points, **more):
        return json.dumps({"markups": [{"type": "Curve", "controlPoints": points, **more}]})

    def test_slicer(self):
        """Its unit; points that are not placed; the old .fcsv with its axes."""
        points = [{"position": [10, 20, 30], "positionStatus": "defined"}, {"position": [0, 0, 0], "positionStatus": "undefined"},
                  {"position": [15, 21, 50]}, {"position": "", "positionStatus": "missing"}, {"positionStatus": "undefined"}]
        for unit in ("mm", ["mm", "UCUM", "millimeter"]):
            x, told, notes = self.rows("a.mrk.json", self.markup(points, coordinateUnits=unit, coordinateSystem="LPS"), radius=0.002, unit="m")
            np.testing.assert_allclose(x, [[0.01, 0.02, 0.03, 0.002], [0.015, 0.021, 0.05, 0.002]])
            self.assertIn("3 points not placed", notes)
        radii = [{"name": "Radius", "units": "cm", "controlPointValues": [0.1, 9, 0.2, 9, 9]}]
        x, told, notes = self.rows("b.mrk.json", self.markup(points, coordinateUnits="mm", coordinateSystem="RAS", measurements=radii))
        np.testing.assert_allclose(x[:, 3], [1, 2])
        self.assertEqual(told, "mm")
        self.assertIn("RAS", notes)
        self.refused("furlong", self.made, "c.mrk.json", self.markup(points, coordinateUnits="furlong"), radius=1)
        self.refused("control point 2|no position", self.made, "c.mrk.json", self.markup([points[0], {"label": "x"}]), radius=1)
        self.refused("1 lines|no 4", self.made, "b.mrk.json", line=4)
        table = "label,l,p,s,defined,selected,description\nC-1,10,20,30,1,1,\"inlet, main\"\nC-2,0,0,0,0,1,\nC-3,15,21,50,1,1,\n"
        x, _, notes = self.rows("d.csv", table, radius=2)
        np.testing.assert_allclose(x, [[10, 20, 30, 2], [15, 21, 50, 2]])
        self.assertIn("1 point not placed", notes)
        old = "# Markups fiducial file version = 4.11\n# CoordinateSystem = {}\n# columns = id,x,y,z,ow,ox,oy,oz,vis,sel,lock,label,desc,associatedNodeID\n" \
              'a,-17.5,58,50,0,0,0,1,1,1,0,"F, 1",,\nb,-18.5,58,60,0,0,0,1,1,1,0,F-2,,\n'
        for system, told in (("LPS", False), ("RAS", True), ("0", True), ("1", False)):
            x, _, notes = self.rows("e.fcsv", old.format(system), radius=2)
            np.testing.assert_allclose(x, [[-17.5, 58, 50, 2], [-18.5, 58, 60, 2]])
            self.assertEqual("RAS" in notes, told, system)
        self.refused("voxels", self.made, "e.fcsv", old.format("IJK"), radius=2)
        self.refused("e.fcsv, line 4|x is not finite", self.made, "e.fcsv", old.format("LPS").replace("-17.5", "left"), radius=2)

    def test_tables_as_they_come(self):
        """As fit.sh reads them: quotes, semicolons, tabs, decimal commas, other encodings, titles, blank first columns, headings of
        two rows, footnotes, pages; what is left out is said with its line."""
        survey = [[0, 0, 0], [100, 0, 0], [200, 15, 90]]
        want = self.made("md.csv", "md,inc,azi\n" + "\n".join(",".join(map(str, row)) for row in survey), radius=1)[:, :3]
        body = "0;0;0\n100;0,0;0\n200;15;90,0\n"
        texts = {"a.csv": "MD;Inc;Azi\n" + body, "b.tsv": "MD\tInc\tAzi\n" + body.replace(";", "\t"),
                 "c.csv": '"MD","Inc","Azi"\n"0","0","0"\n"100","0,0","0"\n"200","15","90,0"\n',
                 "d.csv": "L\u00e4nge;Tiefe\nMD;Inc (\u00b0);Azi (\u00b0)\n".encode("latin-1") + body.encode(),
                 "e.csv": ("MD;Inc;Azi\n" + body).encode("utf-16"), "f.csv": ("\ufeffMD;Inc;Azi\n" + body).encode(),
                 "g.csv": "MD,Inc,Azi\r0,0,0\r100,0,0\r200,15,90\r",
                 "h.txt": "Survey of well B, 2020\nMeasured Depth   Inclination (deg)   Azimuth (deg)\n 0.0  0.0  0.0\n 100.0  0.0  0.0\n 200.0  15.0  90.0\n as measured\n",
                 "i.csv": 'Survey report,,,,\n"Well A, pad 3",,,,\n,,,,\n,MD,Inc,Azi,Note\n,0,0,0,\n,100,0,0,"KOP, 1.5"\n,200.0,15,90,\n,,,,\n"* not by gyro, see above",,,,\n',
                 "j.csv": "Measured,Hole,Hole\nDepth,Inclination,Azimuth\n0,0,0\n100,0,0\nDepth,Inclination,Azimuth\n200,15,90\n",
                 "k.csv": 'MD,Inc,Azi,Note\n0,0,0,a\n100,0,0,b\n200,15,90,"1,000.00"\n',
                 "l.csv": "MD,Inc,Azi\n0,0,0\n100,0,0\n200,\u221215,\u221290\n"}
        for name, text in texts.items():
            x, _, notes = self.rows(name, text, radius=1)
            np.testing.assert_allclose(x[:, :3], want if name != "l.csv" else want, atol=1e-9, err_msg=name)
        for name, words in (("h.txt", "line 6"), ("i.csv", "line 9"), ("j.csv", "line 5"), ("d.csv", "L\u00e4nge")):
            self.assertIn(words, self.rows(name, texts[name], radius=1)[2], name)
        if find_spec("openpyxl"):
            import pandas
            pandas.DataFrame(survey, columns=["MD", "Inc", "Azi"]).to_excel(self.at("m.xlsx"), index=False)
            np.testing.assert_allclose(self.rows("m.xlsx", radius=1)[0][:, :3], want, atol=1e-9)
        x, _, notes = self.rows("n.csv", "MD,N/S,E/W,TVD\n0,0,0,0\n100,5,1,99\n200,20,4,190\n", radius=1)
        np.testing.assert_allclose(x[:, :3], [[0, 0, 0], [5, 1, -99], [20, 4, -190]])
        self.assertIn("x is north, y east, z up", notes)
        x, told, _ = self.rows("o.csv", "MD[m],TVD[m],North[m],East[m]\n0,0,0,0\n100,99,5,1\n", radius=1, unit="ft")
        np.testing.assert_allclose(x[1, :3], np.array([5, 1, -99]) / 0.3048)
        x, told, notes = self.rows("bare.csv", "measured by hand\n0cm,0,0,1cm\n5,0,0,1\n9,1,0,12mm\nso far,,,\n")  # without names
        np.testing.assert_allclose(x[:, 3], [1, 1, 1.2])
        self.assertIn("line 5", notes)
        for text, words in (("md,inc,azi\n0,0,0\n100,,\n200,15,90\n", "p.csv, line 3|inc|nothing stands there"),
                            ("0,0,0,1\n5,0,,1\n", "p.csv, line 2|z is not finite"),
                            ("# a\n\nmd,inc,azi\n0,0,0\n100,n/a,3\n", 'p.csv, line 5|inc|"n/a" is no number'),
                            ("md,inc,azi\n0,0,0\n100,4\n", "p.csv, line 3|2 cells, not 3"),
                            ("md,inc,azi\n0,0,0\n100,400,3\n", "line 3|400 degrees is no inclination"),
                            ("md,inc,azi\nm,deg,deg\n", "two points"), ("md,inc,azi\n0,inf,0\n100,4,3\n", "line 2|not finite"),
                            ('md,inc,azi\n0,0,0\n"1,000",2,3\n"2,000",2,3\n', "of thousands")):
            self.refused(words, self.made, "p.csv", text, radius=1)
        self.refused("one line|no 1", self.made, "a.csv", radius=1, line=1)

    def command(self, *words):
        done = subprocess.run([sys.executable, "-m", "tendril", "surface", *map(str, words)], capture_output=True, text=True,
                              env={**os.environ, "PYTHONPATH": str(ROOT / "scripts")})
        self.assertNotIn("Traceback", done.stderr)
        self.assertEqual(done.stderr.count("\n"), int(done.returncode != 0), done.stderr)
        return done

    def test_lists_that_begin_with_a_minus(self):
        path = self.file("a.csv", "x,y,z,r\n-12,0,31,2\n-12,0,41,2\n-10,0,51,2\n")
        done = self.command(path, self.at("o.csv"), "--origin", "-12,0,31", "--direction", "-.0,0,1")
        self.assertEqual(done.returncode, 0, done.stderr)
        np.testing.assert_allclose(self.table(self.at("o.csv"))[:2, :3], [[0, 0, 0], [10, 0, 0]], atol=1e-12)
        self.assertEqual(self.command(path, self.at("o.csv"), "--direction", "-1,0,0").returncode, 0)
        for words, said in ((("--origin", "12,zero,31"), '"zero" is no number'), (("--origin", "1,2"), "3 numbers"),
                            (("--direction", "-1,0"), "3 numbers"), (("--origin",), "--origin"), (("--scale", "x"), '"x" is no number'),
                            (("--origin", "nan,0,0"), "not finite"), (("--line", "0.5"), "no whole number")):
            done = self.command(path, self.at("o.csv"), *words)
            self.assertEqual(done.returncode, 2)
            self.assertIn(said, done.stderr)
            self.assertNotIn("invalid", done.stderr)

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
    del sys.argv[1:2]  # the program, which no test here runs
    unittest.main()

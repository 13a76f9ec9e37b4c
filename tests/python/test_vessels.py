#!/usr/bin/env python3
# test: meshes as people have them become tubes or are refused
"""Meshes as people have them, and what they become: which way they face, their open ends, what a file has that no surface
needs, what a reader says; and tubes that the program takes.

    test_vessels.py [build/tendril]"""

import os
import pty
import re
import subprocess
import sys
import unittest
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "support"))
import test_surface
from interpreter import ROOT, from_venv
from made_meshes import WRITERS, Mesh, cube, needs_vtk, pipe, sphere

try:
    import numpy as np

    import tendril
    from tendril import meshes, openings, tubes
    from tendril.meshes import SurfaceError
except ImportError as error:
    from_venv(error)

PROGRAM = ROOT / "build/tendril"
SAMPLE_SEED = 44


def turned(mesh):
    return Mesh(mesh.points, mesh.triangles[:, ::-1], mesh.name)


def moved(mesh, shift):
    return Mesh(mesh.points + np.asarray(shift, float), mesh.triangles, mesh.name)


def together(*parts):
    """One mesh of several."""
    before = np.cumsum([0] + [len(m.points) for m in parts])
    return Mesh(np.concatenate([m.points for m in parts]), np.concatenate([m.triangles + n for m, n in zip(parts, before)]))


def pinched(n=16, rows=9, gone=((3, 4), (4, 5))):
    """A tube about x3 whose wall lacks some squares (row, column): two of them meet in a corner."""
    a = 2 * np.pi * np.arange(n) / n
    points = [(np.cos(t), np.sin(t), 0.5 * k) for k in range(rows) for t in a]
    triangles = []
    for k in range(rows - 1):
        for j in range(n):
            if (k, j) not in gone:
                p, q = k * n + j, k * n + (j + 1) % n
                triangles += [(p, q, q + n), (p, q + n, p + n)]
    return Mesh(np.array(points), np.array(triangles))


class Vessels(test_surface.Files):
    def command(self, *words, code=0):
        """(stdout, stderr) of surface.sh."""
        done = subprocess.run([ROOT / "scripts/surface.sh", *map(str, words)], capture_output=True, text=True,
                              env={**os.environ, "PYTHON": sys.executable})
        self.assertEqual(done.returncode, code, done.stdout + done.stderr)
        if code:
            self.assertEqual(len(done.stderr.splitlines()), 1, done.stderr)
        return done.stdout, done.stderr

    def taken(self, line, *options):
        """The program runs with this wall."""
        wall = self.file("wall.txt", line + "\n")
        done = subprocess.run([PROGRAM, "-growth_type", "feed", "-growth_initial_length", "1", "-shape_type", "straight",
                               "-wall_file", wall, "-ts_max_time", "0.2", *options], capture_output=True, text=True)
        self.assertEqual(done.returncode, 0, done.stderr)


@needs_vtk
class Facing(Vessels):
    def outwards(self, mesh, open=False):
        """The mesh as it is turned, and the notes of that."""
        found = openings.check(Mesh(mesh.points, mesh.triangles.copy(), "m.obj"), open=open)
        return found, found.notes

    def test_short_vessel(self):
        """As surfaces of marching cubes are: inside out, and shorter than what its ends are led on by. It is turned before."""
        tube = turned(pipe(radius=12, length=90, n=16, m=15))
        path = self.mesh(tube, "tube.obj")
        said, _ = self.command(path, self.at("tube.h5"), "--diameter", "1.8", "--spacing", "1.2", "--side", "inside", "--open", "--origin=3,0,0")
        self.assertIn("tube.obj: is inside out", said)
        error = float(re.search(r"error of the distance ([0-9.e-]+)", said)[1])
        self.assertLess(error, 0.008)
        self.taken(said.splitlines()[-1], "-contact_diameter", "1.8")
        box = (-20, -13, -13, 20, 13, 13)
        made = tendril.surface(path, self.at("s.h5"), diameter=1.8, spacing=1.8, side="inside", open=True, box=box)
        self.assertLess(made.error, 0.05)
        self.assertIn("is inside out", made.notes[0])
        flipped = tendril.surface(path, self.at("f.h5"), diameter=1.8, spacing=1.8, side="inside", open=True, flip=True, box=box)
        self.assertFalse([note for note in flipped.notes if "inside out" in note])
        self.assertEqual(flipped.error, made.error)
        self.refused("inside out with flip|leave flip away", tendril.surface, self.mesh(turned(tube)), "x.h5", diameter=1.8,
                     open=True, flip=True)

    def test_any_vessel(self):
        """Pieces of tubes of all lengths, bent, cut askew and unevenly: those that face outwards are left as they are, the
        others turned."""
        rng = np.random.default_rng(SAMPLE_SEED)
        for _ in range(60):
            n, m, long = int(rng.integers(3, 40)), int(rng.integers(1, 9)), 10 ** rng.uniform(-1.5, 1.5)
            tube = pipe(length=long, n=n, m=m)
            x = tube.points
            askew = rng.uniform(-0.3, 0.3, (2, 2)) * min(1, long)
            x[:n, 0] += x[:n, 1:] @ askew[0] + rng.uniform(-0.1, 0.1, n) * min(1, long / m)
            x[-n:, 0] += x[-n:, 1:] @ askew[1]
            bend = rng.uniform(0, 0.4)  # about x2 = 1/bend
            angle = x[:, 0] * min(bend, 5 / long)
            radius = 1 / max(min(bend, 5 / long), 1e-9)
            x = np.column_stack([(radius - x[:, 1]) * np.sin(angle), radius - (radius - x[:, 1]) * np.cos(angle), x[:, 2]])
            tube = Mesh(x + rng.normal(size=3) * 100, tube.triangles)
            left, notes = self.outwards(tube, open=True)
            self.assertEqual(notes, [])
            np.testing.assert_array_equal(left.triangles, tube.triangles)
            right, notes = self.outwards(turned(tube), open=True)
            self.assertEqual(len(notes), 1)
            np.testing.assert_array_equal(right.triangles, tube.triangles)

    def test_parts(self):
        """Each part by itself: one of two, a cavity, a kernel in the cavity; thick walls with open ends. Balls that run
        through each other stay as they are."""
        ball, small, kernel = sphere(8), sphere(8, radius=0.5), sphere(8, radius=0.2)
        right = together(ball, moved(ball, (3, 0, 0)), turned(small), kernel)
        left, notes = self.outwards(right)
        np.testing.assert_array_equal(left.triangles, right.triangles)
        self.assertEqual(notes, [])
        wrong = together(ball, turned(moved(ball, (3, 0, 0))), small, turned(kernel))
        left, notes = self.outwards(wrong)
        np.testing.assert_array_equal(left.triangles, right.triangles)
        self.assertIn("3 of 4 parts", notes[0])
        self.assertIn("near (3.", notes[0])
        wall = together(pipe(radius=1, n=20, m=8), turned(pipe(radius=0.8, n=20, m=8)))
        self.assertEqual(self.outwards(wall, open=True)[1], [])
        crossing = together(ball, moved(ball, (0.9, 0, 0)))
        self.assertEqual(self.outwards(crossing)[1], [])
        made = tendril.surface(self.mesh(wrong), self.at("w.h5"), diameter=0.2, spacing=0.1, box=(-0.5, -0.5, -0.5, 4, 0.5, 1.2))
        d, _ = self.values(made.path)
        self.assertLess(np.abs(d([[0, 0, 0.35], [3, 0, 0.9], [0, 0, 0.1]]) - [0.15, -0.1, -0.1]).max(), 0.04)

    def test_solid_turned(self):
        """Closed ones, too, in all formats."""
        for kind in WRITERS:
            path = self.mesh(turned(cube(2)), f"cube.{kind}")
            made = tendril.surface(path, self.at("c.h5"), diameter=0.5, spacing=0.25, side="outside", origin=(-2, 0, 0))
            self.assertEqual(len(made.notes), 1, made.notes)
            self.assertIn("is inside out", made.notes[0])
            d, _ = self.values(made.path)
            self.assertLess(abs(d([[1.2, 0, 0]])[0] + 0.2), 0.02)
        flat = Mesh(np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0.0]]), np.array([[0, 1, 2]]))
        self.refused("flat.obj|no volume", tendril.surface, self.mesh(flat, "flat.obj"), "x.h5", diameter=1, open=True)

    def test_runs_through_itself(self):
        """Where, in the file's own frame; and what the program would refuse is not written, with spacing either."""
        both = together(sphere(12), moved(sphere(12), (1.2, 0, 0)))
        path = self.mesh(both, "both.obj")
        for more in ({"facets": True}, {"spacing": 0.5}):
            with self.assertRaises(SurfaceError) as caught:
                tendril.surface(path, self.at("x.h5"), diameter=1, origin=(50, 0, 0), scale=2.0, **more)
            place = re.search(r"near \((.*?)\)", str(caught.exception))
            x = np.array([float(v) for v in place[1].split(",")])
            self.assertLess(np.linalg.norm(x[1:]), 1.3)
            self.assertTrue(-0.3 < x[0] < 1.5, x)
            self.assertFalse(self.at("x.h5").exists())


@needs_vtk
class Openings(Vessels):
    def test_holes_that_meet(self):
        """In a corner, in two, four about a square that hangs by its corners: each is a hole of its own."""
        for gone, rims in ((((3, 4), (4, 5)), 2), (((3, 4), (4, 5), (5, 4)), 3), (((3, 4), (4, 5), (5, 4), (4, 3)), 4),
                           (((3, 4), (4, 5), (4, 4)), 1), (((0, 4), (1, 5)), 1)):
            for mesh in (pinched(gone=gone), turned(pinched(gone=gone))):
                holes = openings.boundary(mesh)[0]
                loops = openings.loops_of(mesh, holes)
                self.assertEqual(sum(len(ring) for ring in loops), len(holes))
                self.assertEqual(len(loops), 2 + rims, gone)
                self.assertTrue(all(len(set(ring)) == len(ring) for ring in loops))
                if rims > 1:
                    self.assertEqual(sorted(map(len, loops)), [4] * rims + [16, 16])
        mesh = self.mesh(pinched(), "pinched.obj")
        said, _ = self.command(mesh, self.at("p.h5"), "--diameter", "0.3", "--spacing", "0.1", "--side", "inside", "--open",
                               "--direction", "0,0,1")
        self.assertLess(float(re.search(r"error of the distance ([0-9.e-]+)", said)[1]), 0.03)
        found = tendril.ends(mesh)
        self.assertEqual([round(end.width, 3) for end in found], [1.974, 1.974, 0.498, 0.498])
        np.testing.assert_allclose(found[2].direction[:2], -found[2].middle[:2] / np.linalg.norm(found[2].middle[:2]), atol=1e-6)

    def test_tubes_that_meet(self):
        """Two vessels whose rims have a corner in common are two."""
        a = pipe(n=16, m=4)
        mesh = together(a, moved(a, (0, 2, 0)))
        mesh.points = mesh.points.round(9)
        mesh = meshes.read_mesh(self.mesh(mesh, "two.ply"))
        self.assertLess(len(mesh.points), 2 * len(a.points))
        self.assertEqual([len(ring) for ring in openings.loops_of(mesh, openings.boundary(mesh)[0])], [16] * 4)

    def test_refusals_say_where(self):
        """File and place."""
        mixed = pinched()
        mixed.triangles[0] = mixed.triangles[0, ::-1]
        self.refused("m.obj: |face different ways|near (", tendril.surface, self.mesh(mixed, "m.obj"), "x.h5", diameter=1, open=True)
        thick = pinched()
        thick.triangles = np.concatenate([thick.triangles, [[0, 17, 40]]])
        self.refused("m.obj: |more than two|near (", tendril.surface, self.mesh(thick, "m.obj"), "x.h5", diameter=1, open=True)
        self.refused("m.obj: |has holes|near (", tendril.surface, self.mesh(pinched(), "m.obj"), "x.h5", diameter=1)
        self.refused("no rim|near (2, ", openings.loops_of, Mesh(np.array([[0, 0, 0], [1, 0, 0], [2, 0, 0]]), np.empty((0, 3), int),
                                                                 "no rim"), np.array([[0, 1], [1, 2]]))

    def test_ends(self):
        """Of a bent duct, of three widths; inside out or not; as a command whose lines can be given back."""
        mesh = pipe(radius=2, length=6, n=60, m=20)
        mesh.points[-60:, 1:] *= 0.5
        x = mesh.points
        turn = x[:, 0] * np.pi / 12  # a quarter of a circle of radius 12/pi
        bent = np.column_stack([(12 / np.pi - x[:, 1]) * np.sin(turn), 12 / np.pi - (12 / np.pi - x[:, 1]) * np.cos(turn), x[:, 2]])
        for kept in (Mesh(bent, mesh.triangles), turned(Mesh(bent, mesh.triangles))):
            one, other = tendril.ends(self.mesh(kept, "bent.vtp"), scale=10.0)
            self.assertEqual((one.number, other.number), (1, 2))
            self.assertAlmostEqual(one.width, 40, delta=0.1)
            self.assertAlmostEqual(other.width, 20, delta=0.1)
            np.testing.assert_allclose(one.middle, [0, 0, 0], atol=1e-6)
            np.testing.assert_allclose(one.direction, [1, 0, 0], atol=1e-6)
            np.testing.assert_allclose(other.middle, [12 / np.pi, 12 / np.pi, 0], atol=1e-6)
            np.testing.assert_allclose(other.direction, [0, -1, 0], atol=1e-6)
        said, _ = self.command(self.at("bent.vtp"), "--ends", "--unit", "mm")
        self.assertIn("2 open ends", said)
        self.assertRegex(said, r"2: middle \(3.81972, 3.81972, 0\), direction \(0, -1, 0\), width [0-9.]+ mm")
        options = said.splitlines()[-1].split()
        said, _ = self.command(self.at("bent.vtp"), self.at("b.h5"), "--diameter", "0.6", "--spacing", "0.5", "--side", "inside",
                               "--open", "--facets", *options)
        self.assertNotIn("the clamp", said)
        self.taken(said.splitlines()[-1], "-contact_diameter", "0.6")
        self.assertEqual(tendril.ends(self.mesh(sphere(6), "ball.obj")), [])
        self.assertIn("ball.obj: is closed", self.command(self.at("ball.obj"), "--ends", code=1)[1])
        self.assertIn("leave open away", self.command(self.at("bent.vtp"), "--ends", "--open", code=1)[1])
        self.assertIn("give a file", self.command(self.at("bent.vtp"), code=1)[1])


@needs_vtk
class Files(Vessels):
    def test_edges_among_faces(self):
        """An OBJ with lines `f 1 2` (Blender before 2.6), with one corner, and a triangle of two corners: they are left out."""
        self.mesh(cube(2), "block.obj")
        text = self.at("block.obj").read_text()
        text = text.replace("\nf ", "\nusemtl red\ncurv 0 1\nf ", 1).replace("f 1 ", "f -8 ", 1)  # and what VTK does not know
        self.file("edges.obj", text + "f 1 2\nf 3/3/3 \\\n4/4/4 # an edge\nf 5\nf 1 2 2\n")
        said, _ = self.command(self.at("edges.obj"), self.at("e.h5"), "--diameter", "0.5", "--spacing", "0.25")
        self.assertIn("edges.obj: 3 faces of fewer than three corners left out", said)
        self.assertIn("edges.obj: 1 face of fewer than three different corners left out", said)
        made = tendril.surface(self.at("block.obj"), self.at("b.h5"), diameter=0.5, spacing=0.25)
        one, other = (self.values(self.at(name))[0].values for name in ("e.h5", "b.h5"))
        np.testing.assert_array_equal(one, other)
        self.assertFalse([note for note in made.notes if "corners" in note])

    def test_reasons(self):
        """Those of the library, in one line with the file's name."""
        for name, text, words in (
                ("a.obj", "v 0 0 0\nv 1 0\n", "a.obj, line 2: v 1 0: a vertex is"), ("b.vtk", "nothing", "b.vtk|VTK says|Unrecognized file type"),
                ("c.vtp", "<VTKFile>", "c.vtp|VTK says|XML"), ("d.stl", "solid d\nfacet normal 0 0 1\nouter loop\nvertex 0 0",
                                                             "d.stl|VTK says|EOF"),
                ("e.ply", "nothing", "e.ply|VTK says|PLY"), ("f.obj", "# nothing\n", "f.obj|no vertex"), ("g.obj", "", "g.obj|is empty"),
                ("h.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 9\n", "h.obj|names a point that there is not"),
                ("i.obj", "v 0 0 0\nv 1 0 0\nv 0 nan 0\nf 1 2 3\n", "i.obj|point 3 is not finite"),
                ("j.obj", "v 0 0 0\nv 1 0 0\nf 1 2\n", "j.obj|no triangles")):
            self.refused(words, tendril.surface, self.file(name, text), self.at("x.h5"), diameter=1)
        self.at("d.obj").mkdir()
        self.refused("is a directory", tendril.surface, self.at("d.obj"), self.at("x.h5"), diameter=1)

    def test_damaged(self):
        """Files cut off, with bytes changed, with numbers that are none: read, or refused in a line; also where VTK itself
        breaks down, as on PLY."""
        rng = np.random.default_rng(SAMPLE_SEED)
        refused = 0
        for kind, count in (("ply", 6), ("vtk", 4), ("stl", 15), ("obj", 15), ("vtp", 15)):
            whole = self.mesh(sphere(5), f"whole.{kind}").read_bytes()
            for k in range(count):
                data = bytearray(whole)
                if k % 3 == 0:
                    data = data[:int(rng.integers(len(data)))]
                elif k % 3 == 1:
                    for at in rng.integers(len(data), size=int(rng.integers(1, 30))):
                        data[at] = int(rng.integers(256))
                else:
                    numbers = list(re.finditer(rb"[0-9]+", bytes(data)))
                    at = numbers[int(rng.integers(len(numbers)))]
                    data[at.start():at.end()] = [b"nan", b"-1", b"99999999", b"1e400", b"x"][int(rng.integers(5))]
                self.at(f"damaged.{kind}").write_bytes(bytes(data))
                try:
                    tendril.ends(self.at(f"damaged.{kind}"))
                except SurfaceError as error:
                    self.assertNotIn("\n", str(error))
                    self.assertIn(f"damaged.{kind}", str(error))
                    refused += 1
        self.assertGreater(refused, 25)
        whole = self.mesh(sphere(5), "whole.ply").read_bytes()
        self.at("cut.ply").write_bytes(whole[:-20])
        self.refused("cut.ply", tendril.ends, self.at("cut.ply"))

    def test_told_before(self):
        """The grid's size before the work; in a terminal a bar."""
        path = self.mesh(sphere(24), "s.obj")
        said, quiet = self.command(path, self.at("s.h5"), "--diameter", "0.5", "--spacing", "0.2", "--origin=-2,0,0")
        self.assertEqual(quiet, "")
        self.assertRegex(said.splitlines()[0], r"a grid of 22 x 22 x 22 = 1.1e\+04 values, 0.2 apart, 0.085 MB, from about .* distances")
        ours, theirs = pty.openpty()
        with subprocess.Popen([ROOT / "scripts/surface.sh", path, self.at("s.h5"), "--diameter", "0.2", "--spacing", "0.07"],
                              stdout=subprocess.DEVNULL, stderr=theirs, env={**os.environ, "PYTHON": sys.executable}) as work:
            os.close(theirs)
            shown = b""
            try:
                while part := os.read(ours, 4096):
                    shown += part
            except OSError:  # its other end is closed
                pass
        os.close(ours)
        self.assertEqual(work.returncode, 0)
        self.assertRegex(shown.decode(), r"surface, 0.07 apart: +[0-9]+%")

    def test_asked_wrongly(self):
        """One line each; nothing is written."""
        path, line = self.mesh(cube(2), "c.obj"), self.file("l.csv", "x,y,z,r\n0,0,0,1\n9,0,0,1\n")
        for words, source, more in (
                ("box|six", path, {"box": [1, 2]}), ("box|least", path, {"box": [1, 1, 1, 0, 0, 0]}), ("origin|three", path, {"origin": (1, 2)}),
                ("direction|not all 0", path, {"direction": (0, 0, 0)}), ("unit|furlong|mm", path, {"unit": "furlong"}),
                ("diameter|number", path, {"diameter": "thick"}), ("diameter|above 0", path, {"diameter": np.nan}),
                ("spacing|too coarse", path, {"spacing": 3}), ("values", path, {"spacing": 1e-9}), ("scale|above 0", line, {"scale": 0}),
                ("every|number", line, {"every": "often"}), ("open|True", path, {"open": "yes"}), ("side|inside", path, {"side": np.ones(3)}),
                ("unit|mm", line, {"unit": [1]}), ("line|whole", line, {"line": "second"}), ("tell|function", path, {"tell": 3}), ("start", path, {"origin": "start"}), ("is the source", path, {"output": path}),
                ("no directory", path, {"output": self.at("none/x.h5")}), ("no wider than the rod", line, {"diameter": 3})):
            output = more.pop("output", self.at("x.h5"))
            with self.assertRaises((SurfaceError, tendril.TendrilError, OSError)) as caught:
                tendril.surface(source, output, **{"diameter": 0.5, **more})
            text = tendril.errors.complaint(caught.exception, "surface")
            self.assertNotIn("\n", text)
            for word in words.split("|"):
                self.assertIn(word, text)
            self.assertFalse(self.at("x.h5").exists())


class Mouths(Vessels):
    def tube(self, text, **more):
        return tendril.surface(self.file("line.csv", text), self.at("tube.csv"), **more)

    def rows(self, x, r, y=0.0):
        return "x,y,z,r\n" + "".join(f"{a:.6g},{b:.6g},0,{c:.6g}\n" for a, b, c in zip(x, np.broadcast_to(y, x.shape), r))

    def test_narrow_ends(self):
        """As VMTK's radii are at open ends: what its neighbour holds is left out, at both ends, and the program takes it."""
        x = 0.4 * np.arange(126)
        r = 7 - 3 * np.exp(-x / 1.1) - 3 * np.exp(-(50 - x) / 1.1)
        self.file("mouth.csv", self.rows(x, r, 0.002 * x**2))
        said, _ = self.command(self.at("mouth.csv"), self.at("duct.csv"), "--origin", "start", "--direction", "start")
        self.assertRegex(said, r"duct.csv: \d points at its start and \d points at its end left out")
        self.taken(said.splitlines()[-1], "-contact_diameter", "1")
        first = np.loadtxt(self.at("duct.csv"), delimiter=",", skiprows=1)[0]
        np.testing.assert_allclose(first[:3], 0, atol=1e-12)
        made = self.tube(self.rows(x, 0 * x + 7, 0.002 * x**2), origin="start", direction="start")
        self.assertEqual(made.notes, [])

    def test_as_the_program(self):
        """Tubes at random, waves and coils: what is written the program takes; what is refused it refuses for the same reason."""
        rng = np.random.default_rng(SAMPLE_SEED)
        reasons = {"kink": "kink", "is narrower than|vanishes|no wider than": "is narrower than|vanishes", "widens": "widens",
                   "bends with|changes its width": "bends with", "itself": "itself"}
        met = []
        for k in range(60):
            n, wide = int(rng.integers(4, 12)), rng.uniform(0, 0.9)
            a = np.cumsum(rng.uniform(0.5, 1.5, n))
            bend = rng.uniform(0, 1.2)
            x = [a, bend * np.sin(a), bend * np.cos(0.7 * a)]
            if k % 2:  # of more than a turn
                a = np.linspace(0, rng.uniform(5, 12), 24)
                x, wide = [rng.uniform(0.8, 2) * np.cos(a), rng.uniform(0.8, 2) * np.sin(a), rng.uniform(0.05, 0.2) * a], 0.1
            balls = np.column_stack([*x, (0.3 if k % 2 else 0.6) + wide * np.sin(1.3 * a) ** 2])
            inside, thick = bool(rng.random() < 0.6), rng.uniform(0.05, 0.5)
            balls[:, :3] -= balls[0, :3] if inside else np.array([-9.0, -9, -9])
            found = tubes.Tube(balls).trouble(inside, thick / 2)
            line = "tube " + ("inside " if inside else "outside ") + " ".join(f"{v:.17g}" for v in balls.ravel())
            wall = self.file("wall.txt", line + "\n")
            done = subprocess.run([PROGRAM, "-growth_type", "feed", "-growth_initial_length", "0.01", "-shape_type", "straight", "-wall_file",
                                   wall, "-ts_max_time", "1e-4", "-contact_diameter", f"{thick:.17g}"], capture_output=True, text=True)
            if found is None:
                met.append("")
                self.assertNotRegex(done.stderr, "|".join(reasons.values()), line)
            else:
                met.append(next(words for words in reasons if re.search(words, found[1])))
                self.assertRegex(done.stderr, reasons[met[-1]], f"{found}: {line}")
        for words, least in (("", 8), ("itself", 4), ("widens", 2), ("bends with|changes its width", 8)):
            self.assertGreaterEqual(met.count(words), least, met)

    def test_named_by_the_file(self):
        """Between which of its points, in its own frame, whatever the tube's frame and its points."""
        x = 0.4 * np.arange(100)
        r = 3 + 2 * np.tanh((x - 20) / 0.5)
        self.refused("line.csv: between points 46 and 47 of 100|near (18.2|changes its width too sharply", self.tube, self.rows(x, r), origin="start", scale=10.0)
        a = np.linspace(0, 2 * np.pi, 60)
        ring = "x,y,z,r\n" + "".join(f"{5 * np.cos(t)},{5 * np.sin(t)},{0.1 * t},1\n" for t in a)
        self.refused("line.csv: between points 1 and 2 of 60|and between points|runs into itself", self.tube, ring)
        self.refused("line.csv: between points 1 and 2|kink of 90 degrees", self.tube, "x,y,z,r\n0,0,0,.1\n1,0,0,.1\n1,1,0,.1\n")
        self.refused("line.csv: between points|bends with radius", self.tube,
                     "x,y,z,r\n" + "".join(f"{np.cos(t)},{np.sin(t)},0,2\n" for t in np.linspace(0, 2, 20)))

    def test_clamp(self):
        made = self.tube("x,y,z,r\n5,5,5,1\n9,5,5,1\n")
        self.assertIn("the clamp, at 0, is outside of the tube", made.notes[0])
        self.assertEqual(self.tube("x,y,z,r\n5,5,5,1\n9,5,5,1\n", origin="start").notes, [])
        self.assertEqual(self.tube("x,y,z,r\n5,5,5,1\n9,5,5,1\n", origin=(4, 5, 5)).notes, [])  # before its mouth


if __name__ == "__main__":
    if len(sys.argv) > 1 and Path(sys.argv[1]).is_file():
        PROGRAM = Path(sys.argv.pop(1)).resolve()
    unittest.main()

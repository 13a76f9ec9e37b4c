#!/usr/bin/env python3
# test: what people asked for in public can be had
"""What people asked for in public and what it gives here: docs/dev/public-cases.md, by its numbers.

    public_cases.py build/tendril"""

import os
import struct
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
except ImportError as error:
    from_venv(error)

PROGRAM = ROOT / "build/tendril"


class Case(unittest.TestCase):
    def setUp(self):
        self.directory = tempfile.TemporaryDirectory(prefix="tendril-")
        self.addCleanup(self.directory.cleanup)

    def at(self, name):
        return Path(self.directory.name) / name

    def file(self, name, text):
        self.at(name).write_text(text)
        return self.at(name)

    def run_it(self, options, **more):
        """The run's results, and what it prints."""
        words = [str(word) for name, value in more.items() for word in (f"-{name}", value)]
        done = subprocess.run([PROGRAM, *options.split(), *words, "-output", self.at("r.h5")], capture_output=True, text=True)
        self.assertEqual(done.returncode, 0, done.stderr)
        return tendril.load(self.at("r.h5")), done.stdout


# ---- surveys of wells ----


def built(turns):
    """A well of straight pieces and arcs: rows (depth, inclination, azimuth) in degrees and (north, east, down) that go with
    them, exactly; an arc lies in the upright plane of its azimuth."""
    rows, places = [(0.0, 0.0, 0.0)], [np.zeros(3)]
    for long, inclination, azimuth in turns:
        depth, before = rows[-1][:2]
        i0, i1, a = np.radians([before, inclination, azimuth])
        if abs(i1 - i0) < 1e-12:
            out, down = long * np.sin(i1), long * np.cos(i1)
        else:
            r = long / (i1 - i0)
            out, down = r * (np.cos(i0) - np.cos(i1)), r * (np.sin(i1) - np.sin(i0))
        rows.append((depth + long, inclination, azimuth))
        places.append(places[-1] + [out * np.cos(a), out * np.sin(a), down])
    return rows, np.array(places)


class Surveys(Case):
    WELL = [(100, 0, 116), (90, 18, 116), (60, 18, 116), (41, 30, 116)]

    def last(self, name, text, **more):
        made = tendril.surface(self.file(name, text), self.at("out.csv"), **more)
        rows = [[float(cell.rstrip("m")) for cell in line.split(",")] for line in made.path.read_text().splitlines()[1:]]
        return np.array(rows)

    def test_01_openworks(self):
        """The well's name first, blanks between, its true depth and coordinates behind."""
        rows, places = built(self.WELL)
        text = "Well MD Inclination Azimuth TVDMSL TVD East North\n" + "".join(
            f"Well_01   {md:.2f}  {i:.4f}   {a:.4f}  {x[2] - 77.8:.2f}  {x[2]:.2f}  {478176.94 + x[1]:.2f}  {7236531.44 + x[0]:.2f}\n"
            for (md, i, a), x in zip(rows, places))
        x = self.last("ow.txt", text, radius=0.1, unit="m", origin="start")
        np.testing.assert_allclose(x[-1, :3] * [1, 1, -1], places[-1], atol=0.005)
        self.assertGreater(np.hypot(*places[-1, :2]), 40)

    def test_05_own_coordinates(self):
        """Commas; its own N/S, E/W, TVD beside: the same place."""
        rows, places = built(self.WELL)
        text = "MD,INC,AZI,TVD,N/S,E/W\n" + "".join(f"{md},{i},{a},{x[2]:.2f},{x[0]:.2f},{x[1]:.2f}\n"
                                                    for (md, i, a), x in zip(rows, places))
        x = self.last("own.csv", text, radius=0.35)
        np.testing.assert_allclose(x[-1, :3] * [1, 1, -1], places[-1], atol=0.005)

    def test_06_begins_below(self):
        """A depth that begins at 32: the path begins at 0 there. Depths that do not increase are refused, with the place."""
        rows, places = built(self.WELL)
        x = self.last("at32.csv", "MD,INC,AZI\n" + "".join(f"{md + 32},{i},{a}\n" for md, i, a in rows), radius=0.1)
        np.testing.assert_allclose(x[0, :3], 0, atol=1e-12)
        np.testing.assert_allclose(x[-1, :3] * [1, 1, -1], places[-1], atol=1e-6)
        with self.assertRaises(tendril.TendrilError) as caught:
            self.last("back.csv", "MD,INC,AZI\n0,0,0\n50,10,90\n40,20,90\n", radius=0.1)
        self.assertRegex(str(caught.exception), "back.csv.*depth.*increase")


# ---- cables, poles, beams, springs ----


class Rods(Case):
    def test_27_pulled_round_a_bend(self):
        """1.5 lb/ft, friction 0.3, a bend of 2 ft: T e^(mu a) for the angle a through which the cable really turns, and what its
        own weight rubs."""
        bend, weight, mu = 0.6096, 6.567, 0.3
        t = np.linspace(0, np.pi / 2, 10)
        path = [(-0.3, 0), (1.4, 0), *zip(1.5 + bend * np.sin(t), bend - bend * np.cos(t)), (1.5 + bend, bend + 0.1), (1.5 + bend, 3)]
        wall = self.file("duct.txt", "path 0.03m " + " ".join(f"{x:.6f}m {y:.6f}m" for x, y in path) + f" friction {mu}\n")
        r, _ = self.run_it(
            f"-growth_type feed -growth_initial_length 0.5m -si_bending_stiffness 2Nm^2 -si_friction_dry {weight}N/m -si_speed 0.1m/s "
            "-contact_diameter 0.04m -shape_type straight -tip_force -644N -tip_law follower -stop_length 3.6m -rod_cells 200",
            wall_file=wall)
        angle, force = r.shapes.theta[-1], r.shapes.force[-1] * r.scale("force")
        along, x = force[:, 0] * np.cos(angle) + force[:, 1] * np.sin(angle), r.shapes.x[-1] * r.scale("length")
        before, behind = np.argmax(x[:, 0] > 1.3), len(x) - 1 - np.argmax(x[::-1, 1] < 1.0)
        turn = angle[behind] - angle[before]
        self.assertTrue(1.52 < turn < np.pi / 2, turn)
        grows = np.exp(mu * turn)
        straight = weight * ((1.5 - x[before, 0]) + (x[behind, 1] - bend))  # what it rubs before and behind the bend
        self.assertAlmostEqual(along[behind] / (along[before] * grows + weight * bend / mu * (grows - 1) + straight), 1, delta=4e-3)

    def test_28_flagpole(self):
        """The height at which a pole of 1 in buckles under its weight: 7.8373 = L^3 w/B."""
        done = subprocess.run([PROGRAM, *("-task critical -growth_type uniform -si_bending_stiffness 3944.1 -si_friction_dry 38.515 "
                                          "-friction_layers 0:0 -rod_weight 0,0,-1 -clamp_direction 0,0,1 "
                                          "-growth_initial_length 1m").split()], capture_output=True, text=True)
        self.assertIn("L^3 = 7.8373474", done.stdout)
        self.assertIn("L = 9.29314 m", done.stdout)

    def test_29_cantilever(self):
        """P L^2/B = 1, large deflection: the elastica's, whatever drag brings it there."""
        for drag in (0.3, 0.01):
            r, _ = self.run_it(f"-growth_type none -growth_initial_length 1 -shape_type straight -friction_mu 0 -friction_layers 0:{drag} "
                               "-tip_force_vector 0,1 -ts_max_time 20")
            np.testing.assert_allclose(r.shapes.x[-1][-1], [0.94356676, 0.30172077], atol=1e-7)

    def test_30_stiff_about_one_axis(self):
        """So stiff a strip bends about its other axis alone; more is refused in a line."""
        scene = ("-growth_type none -growth_initial_length 1 -shape_type straight -friction_mu 0 -friction_layers 0:0.3 "
                 "-tip_force_vector 0,0.1,0.1 -rod_cells 40 -ts_max_time 2")
        r, _ = self.run_it(scene + " -rod_bend_ratio 1e4")
        bent = np.sort(np.abs(r.shapes.x[-1][-1][1:]))
        self.assertAlmostEqual(bent[1], 0.1 / 3, delta=2e-4)
        self.assertLess(bent[0], 1e-4)
        done = subprocess.run([PROGRAM, *scene.split(), "-rod_bend_ratio", "1e8"], capture_output=True, text=True)
        self.assertNotEqual(done.returncode, 0)
        self.assertEqual(done.stderr, "tendril: -rod_bend_ratio 1e8: too large, give at most 1000000\n")

    @unittest.skipUnless(find_spec("vtkmodules"), "vtk is not installed")
    def test_31_peg_through_a_block(self):
        """A block with a square hole, a mesh that is not convex: the rod comes in aslant, and goes through along the hole's
        wall."""
        x = np.array([(x1, s * a, s * b) for x1 in (1.0, 1.4) for s in (0.8, 0.3) for a, b in ((-1, -1), (1, -1), (1, 1), (-1, 1))])
        faces = []
        for k, j in ((0, 1), (1, 2), (2, 3), (3, 0)):
            faces += [(k, 4 + k, 4 + j), (k, 4 + j, j), (8 + k, 12 + j, 12 + k), (8 + k, 8 + j, 12 + j), (k, j, 8 + j), (k, 8 + j, 8 + k),
                      (4 + k, 12 + j, 4 + j), (4 + k, 12 + k, 12 + j)]
        self.at("block.stl").write_bytes(b"\0" * 80 + struct.pack("<I", len(faces)) + b"".join(
            struct.pack("<12fH", 0, 0, 0, *x[list(face)].ravel(), 0) for face in faces))
        made = tendril.surface(self.at("block.stl"), self.at("block.h5"), diameter=0.2, spacing=0.05, box=(0.6, -0.6, -0.6, 1.8, 0.6, 0.6))
        r, _ = self.run_it("-growth_type feed -growth_initial_length 0.5 -contact_diameter 0.2 -clamp_direction 1,0.25,0.1 "
                           "-ts_max_time 1.5 -rod_cells 60", wall_file=self.file("wall.txt", made.line + "\n"))
        nodes = r.shapes.x[-1]
        within = nodes[(nodes[:, 0] > 1.05) & (nodes[:, 0] < 1.35)]
        self.assertGreater(nodes[-1, 0], 1.9)
        self.assertLess(np.abs(within[:, 1:]).max(), 0.202)  # the hole's half, less the rod's radius
        self.assertGreater(np.abs(within[:, 1:]).max(), 0.19)  # it touches

    def test_32_on_the_end_of_a_post(self):
        """A rod end on to the flat end of a post: it is held there, buckles at Euler's load for one end clamped and one pinned, and
        slides off over the edge; it does not go through."""
        wall = self.file("post.txt", "cylinder 1.2 0 0  1 0 0  0.3 outside 1 friction 0.3\n")
        r, _ = self.run_it("-growth_type feed -growth_initial_length 1 -contact_diameter 0.1 -shape_amplitude 0.01 -friction_mu 0 "
                           "-friction_layers 0:0.01 -ts_max_time 0.8 -rod_cells 60", wall_file=wall)
        euler = 4.493409458**2 / 1.15**2
        length, push = r.series["length"], -r.series["wall_force_1"]
        self.assertAlmostEqual(push[np.argmin(np.abs(length - 1.155))] / euler, 1, delta=0.01)
        tip = np.column_stack([r.series[f"tip_x{k}"] for k in (1, 2, 3)])
        self.assertFalse(np.any((tip[:, 0] > 1.16) & (np.hypot(tip[:, 1], tip[:, 2]) < 0.34)))
        self.assertGreater(tip[-1, 0], 1.5)

    def test_33_spring_under_its_weight(self):
        """A helix of three turns: w L^2 R^2/2C longer, of a close-coiled spring."""
        radius, pitch, turns, torsion, longer = 0.5, 0.05, 3, 0.75, 0.3
        c = pitch / (2 * np.pi)
        length, curvature, twist = 2 * np.pi * turns * np.hypot(radius, c), radius / (radius**2 + c**2), c / (radius**2 + c**2)
        axis = np.array([c, 0, radius]) / np.hypot(radius, c)
        weight = ",".join(f"{v:.12g}" for v in longer * 2 * torsion / (length * radius) ** 2 * axis)
        with h5py.File(self.at("as_it_is.h5"), "w") as f:
            f["s"], f["u1"] = np.linspace(0, 1, 5), np.zeros(5)
        r, _ = self.run_it(f"-growth_type none -growth_initial_length {length:.12g} -rod_curvature {curvature:.12g} -rod_twist {twist:.12g} "
                           f"-rod_weight {weight} -rod_torsion {torsion} -shape_type file -friction_mu 0 -friction_layers 0:0.1 "
                           "-ts_max_time 100", shape_file=self.at("as_it_is.h5"))
        x = r.shapes.x
        self.assertAlmostEqual(x[0][-1] @ axis, turns * pitch, delta=1e-6)
        self.assertAlmostEqual((x[-1][-1] - x[0][-1]) @ axis, longer, delta=0.015 * longer)

    def test_36_both_ends_led(self):
        """Place and direction of both ends given, then one led nearer by a fifth: the elastica's force and width."""
        way = self.file("way.csv", "t,x1,x2,angle\n0,1,0,0\n5,0.8,0,0\n")
        r, _ = self.run_it("-growth_type none -growth_initial_length 1 -friction_mu 0 -friction_layers 0:0.01 -tip_type clamped "
                           "-ts_max_time 20", tip_path=way)
        self.assertAlmostEqual(r.series["base_force_1"][-1], 43.92916387, delta=1e-6)
        self.assertAlmostEqual(np.abs(r.shapes.x[-1][:, 1]).max(), 0.26632, delta=5e-6)


if __name__ == "__main__":
    if len(sys.argv) > 1 and Path(sys.argv[1]).is_file():
        PROGRAM = Path(sys.argv.pop(1)).resolve()
    unittest.main()

#!/usr/bin/env python3
"""Fitting: what was measured is read as it is meant, residuals are distances, intervals hold what they
say, a hidden truth is found again.

    test_fit.py build/tendril"""

import contextlib
import io
import os
import sys
import tempfile
import unittest
from pathlib import Path
from types import SimpleNamespace

from interpreter import ROOT, from_venv

sys.path.insert(0, str(ROOT / "scripts"))
try:
    import numpy as np
    from scipy import optimize, stats

    import tendril
    from tendril import comparing, fit_command, fitting, measured, problem
    from tendril.parameters import Parameter
except ImportError as error:
    from_venv(error)

TUBE = dict(growth_type="feed", growth_initial_length="1cm", si_bending_stiffness="2.209Nmm^2",
            si_speed="5mm/s", friction_beta=1e-6, shape_type="straight")
FRICTION, CURVATURE, END = 0.62, 3.7, 28.0  # hidden; N/m, 1/m, s


class Reading(unittest.TestCase):
    def setUp(self):
        self.directory = tempfile.TemporaryDirectory(prefix="tendril-")
        self.addCleanup(self.directory.cleanup)

    def file(self, text, name="data.csv"):
        path = Path(self.directory.name) / name
        path.write_text(text)
        return path

    def test_points(self):
        """A row a point, in any order, in centimetres; lines with nothing in them do not count."""
        m = measured.read(self.file("# by hand\nt (s), x1 (cm), x2 [cm]\n20,1,2\n10,3,4\n20,5,6\n10,7,\n"
                                    "10,0,0\n\n10,1,1\n20,9,9\n"))
        self.assertEqual([float(p.at.numbers) for p in m.photographs], [10, 20])
        self.assertEqual([p.at.unit for p in m.photographs], ["l/V", "l/V"])
        np.testing.assert_allclose(m.photographs[0].points.numbers, [[0.03, 0.04], [0, 0], [0.01, 0.01]])
        np.testing.assert_allclose(m.photographs[1].points.numbers, [[0.01, 0.02], [0.05, 0.06], [0.09, 0.09]])
        self.assertFalse(m.photographs[0].ordered)

    def test_points_in_order_and_without_time(self):
        m = measured.read(self.file("length (mm),x1,x2,point\n,3,3,3\n,1,1,1\n,2,2,2\n50,1,0,1\n50,3,0,3\n"
                                    "50,2,0,2\n"), unit="px")
        at, none = m.photographs
        self.assertEqual((at.abscissa, float(at.at.numbers), at.ordered), ("length", 0.05, True))
        np.testing.assert_array_equal(at.points.numbers[:, 0], [1, 2, 3])
        self.assertEqual((none.abscissa, none.points.unit), (None, measured.PIXEL))
        np.testing.assert_array_equal(none.points.numbers[:, 0], [1, 2, 3])

    def test_digitiser(self):
        """Two columns without a head; and pairs of columns side by side, of different lengths."""
        plain = measured.read(self.file("1;2\n3;4\n5;6\n"), unit="mm", at="t=20 s")
        np.testing.assert_allclose(plain.photographs[0].points.numbers[2], [0.005, 0.006])
        self.assertEqual(float(plain.photographs[0].at.numbers), 20)
        m = measured.read(self.file("20s,,12cm,\nX,Y,X,Y\n1,2,3,4\n5,6,7,8\n1,1,9,9\n,,2,3\n"), unit="px")
        self.assertEqual([p.abscissa for p in m.photographs], ["t", "length"])
        self.assertEqual([len(p.points.numbers) for p in m.photographs], [3, 4])
        m = measured.gather({"20s": np.eye(3)[:, :2], "": np.ones((4, 2))})
        self.assertEqual([p.abscissa for p in m.photographs], ["t", None])

    def test_series(self):
        """Each over the times at which it was measured, in rising order."""
        m = measured.read(self.file("t (min),width (cm),base_force_1 (mN)\n2,4,\n1,3,5\n3,,6\n"))
        width, force = m.curves
        np.testing.assert_allclose(width.at.numbers, [60, 120])
        np.testing.assert_allclose(width.values.numbers, [0.03, 0.04])
        np.testing.assert_allclose(force.values.numbers, [0.005, 0.006])
        self.assertEqual(force.values.unit, "N l")

    def test_refused_in_one_line(self):
        for text, word in (("t (s),x1 (cm),x2 (cm)\n1,2,three\n", "three"), ("", "empty"),
                           ("t (s),x1 (cm),x2 (cm)\n1,2,3\n", "three points"),
                           ("t (s),x1 (ft),x2 (ft)\n1,2,3\n1,2,3\n1,2,3\n", "ft is no unit"),
                           ("t (s),x1 (cm),x2 (mm)\n1,2,3\n1,2,3\n1,2,3\n", "in one unit"),
                           ("when,width\n1,2\n", "no column t")):
            with self.assertRaisesRegex(measured.DataError, word) as refused:
                measured.read(self.file(text))
            self.assertNotIn("\n", str(refused.exception))
        for bounds in ((2, 1), (1,), ("1N/m", "2N/cm"), "1:2:3", "1:two"):
            with self.assertRaises(tendril.TendrilError):
                Parameter.of("x", bounds)


class Residuals(unittest.TestCase):
    def test_distances(self):
        """Of points beside an arc, from the arc: signed, and as good as the line between its nodes."""
        angle = np.linspace(0, 2, 41)
        line = comparing.finer(np.column_stack([np.sin(angle), 1 - np.cos(angle)]))
        at, off = np.linspace(0.1, 1.9, 7), np.array([0.1, -0.2, 0.3, 0, 0.05, -0.01, 0.2])
        points = np.column_stack([(1 - off) * np.sin(at), 1 - (1 - off) * np.cos(at)])
        found, _ = comparing.distances(points, line)
        np.testing.assert_allclose(found, off, atol=2e-5)

    def test_ends(self):
        """A rod that goes on beyond the points is seen, one that ends with them is not."""
        points = np.column_stack([np.linspace(0, 1, 11), np.zeros(11)])
        for end, loose in ((1, 0), (1.15, 0), (3, 1.8)):
            line = np.column_stack([np.linspace(0, end, 50), np.zeros(50)])
            self.assertAlmostEqual(comparing.loose_end(points, line), loose)

    def test_camera(self):
        """What a camera sees is what it was told, and its guess of itself is right."""
        camera = comparing.Camera(500.0)
        x = np.column_stack([np.linspace(0, 2, 30), np.sin(np.linspace(0, 2, 30))])
        numbers = [np.log(0.4), 0.2, 0.5, 0.0]
        seen = camera.see(x, numbers)
        np.testing.assert_allclose(seen[0], [100, 250])
        self.assertLess(seen[10, 1], 250)  # upwards
        np.testing.assert_allclose(np.hypot(*np.diff(seen, axis=0).T), 200 * np.hypot(*np.diff(x, axis=0).T))
        np.testing.assert_allclose(camera.guess(seen, x), numbers, atol=1e-12)


class Intervals(unittest.TestCase):
    def test_hold_the_truth(self):
        """Of a linear model with noise they hold it in 95 % of all cases, also with outliers."""
        random = np.random.default_rng(1)
        problem = SimpleNamespace(parameters=[None, None])
        for outliers in (0, 0.05):
            held = []
            for _ in range(400):
                design = 1e3 * random.normal(size=(80, 2))
                f = random.normal(size=80) + 20 * (random.random(80) < outliers) * random.normal(size=80)
                solution = optimize.least_squares(lambda b: f - design @ b, [0, 0], loss="huber",
                                                          f_scale=fitting.HUBER)
                covariance, freedom = fitting.huber_covariance(problem, solution.fun, -design)
                reach = stats.t.ppf(0.975, freedom) * np.sqrt(np.diag(covariance))
                held.append(np.abs(solution.x) < reach)
            self.assertTrue(0.93 < np.mean(held) < 0.97, np.mean(held))


class Fitting(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.directory = tempfile.TemporaryDirectory(prefix="tendril-")
        cls.place = Path(cls.directory.name)
        cls.truth = tendril.run(TUBE, si_friction_dry=f"{FRICTION}N/m", rod_curvature=f"{CURVATURE}/m",
                                ts_max_time=f"{END}s", output_interval=f"{END / 60}s", accuracy=1e-5)

    @classmethod
    def tearDownClass(cls):
        cls.directory.cleanup()

    def photographs(self, seed):
        """Lines of CSV: points in no order, with noise of 1 % of the width, a twentieth of them anywhere."""
        random, r = np.random.default_rng(seed), self.truth
        length, rows = r.scale("length"), ["t (s),x1 (cm),x2 (cm)"]
        for t in (16, 20, 24, 28):
            line = comparing.finer(comparing.shape_at(r, t / r.scale("time"))) * length
            points = line[random.choice(len(line), 40, replace=False)]
            points += 0.01 * r.series.width[-1] * length * random.normal(size=points.shape)
            points[:2] = random.uniform(-0.05, 0.1, (2, 2))
            rows += [f"{t},{100 * x!r},{100 * y!r}" for x, y in points.tolist()]
        return rows

    def test_finds_the_truth(self):
        """By the command: in its intervals, which are narrow; the scene it leaves is the one it tells."""
        data, out = self.place / "photographs.csv", self.place / "fit"
        data.write_text("\n".join(self.photographs(1)) + "\n")
        scene = self.place / "tube.opts"
        scene.write_text("# a tube\n" + "".join(f"-{k} {v}\n" for k, v in TUBE.items())
                         + "-rod_curvature 0\n-stop_length 1m\n")
        said = io.StringIO()
        with contextlib.redirect_stdout(said):
            code = fit_command.main([str(scene), str(data), "--parameter", "si_friction_dry=0.2N/m:2N/m",
                                     "-p", "rod_curvature=-10/m:10/m", "--starts", "0", "--accuracy", "1e-3",
                                     "--output", str(out)])
        self.assertEqual(code, 0)
        lines = {line.split()[0]: line.split() for line in reversed(said.getvalue().splitlines())}
        for name, truth, width in (("si_friction_dry", FRICTION, 0.05), ("rod_curvature", CURVATURE, 0.1)):
            value, low, high = (float(lines[name][k]) for k in (1, 2, 4))
            self.assertTrue(low < value < high and low <= truth <= high, said.getvalue())
            self.assertLess(high - low, width * truth)
        text = out.with_suffix(".opts").read_text()
        self.assertIn("# a tube\n", text)
        self.assertEqual(text.count("-rod_curvature"), 1)
        best = tendril.run(out.with_suffix(".opts"), ts_max_time=f"{END}s", rod_cells=100)
        self.assertAlmostEqual(best.attributes["parameters/si_friction_dry"],
                               float(lines["si_friction_dry"][1]), 4)
        off = np.hypot(*(best.shapes.x[-1, -1] - self.truth.shapes.x[-1, -1]))
        self.assertLess(off, 0.02 * self.truth.series.end_distance[-1])
        rows = out.with_suffix(".csv").read_text().splitlines()
        self.assertEqual(len(rows), 1 + 4 * 40 + 4)  # points, and where each rod ends
        self.assertGreater(out.with_suffix(".png").stat().st_size, 10000)

    def test_tells_what_cannot_be_told(self):
        """Lengths and times alone tell stiffness over friction, and neither of the two."""
        length, time = self.truth.scale("length"), self.truth.scale("time")
        t = np.linspace(0, self.truth.series.t[-1], 21)[1:]
        columns = [t * time] + [np.interp(t, self.truth.series.t, self.truth.series[name]) * length
                                for name in ("width", "end_distance")]
        noise = np.random.default_rng(2).normal(size=(20, 3)) * [0, 3e-4, 3e-4]
        file = self.place / "series.csv"
        np.savetxt(file, np.column_stack(columns) + noise, delimiter=",", comments="",
                   header="t (s),width (m),end_distance (m)")
        shared = dict(starts=0, accuracy=3e-3, rod_curvature=f"{CURVATURE}/m")
        found = tendril.fit({k: v for k, v in TUBE.items() if k != "si_bending_stiffness"}, file,
                            {"si_friction_dry": ("0.2N/m", "2N/m", "0.5N/m"),
                             "si_bending_stiffness": ("1Nmm^2", "9Nmm^2", "2Nmm^2")}, **shared)
        self.assertEqual(len(found.indistinct), 1)
        self.assertIn("cannot be told apart", found.indistinct[0])
        self.assertRegex(found.indistinct[0], "Only si_(friction_dry / si_bending_stiffness|"
                         "bending_stiffness / si_friction_dry) is told")
        ratio = found.values["si_bending_stiffness"] / found.values["si_friction_dry"]
        self.assertAlmostEqual(ratio / (2.209 / FRICTION), 1, delta=0.02)
        for name, (low, high) in found.intervals.items():
            self.assertGreater(high / low, 4, name)

    def test_refuses_what_the_scene_cannot(self):
        data = self.place / "late.csv"
        data.write_text("t (s),width (cm)\n1,2\n20,3\n")
        bounds = {"si_friction_dry": ("0.2N/m", "2N/m")}
        for more, word in ((dict(stop_length="5cm"), "ends at t = 8, before .* at 20"),
                           (dict(friction_layers="0:1,3:{hard}"), "in braces is no parameter")):
            with self.assertRaisesRegex(tendril.TendrilError, word):
                tendril.fit(TUBE, data, bounds, **more)

    def test_words_in_braces(self):
        """One may stand in several options; none of it is an option of its own."""
        looked = problem.Problem(TUBE, measured.Measured(), [Parameter.of("hard", (1, 3))],
                                  dict(friction_layers="0:1,3:{hard}", tip_force="{hard}", rod_cells=40))
        self.assertEqual(looked.words([0.5]), {"friction_layers": "0:1,3:2.0", "tip_force": "2.0",
                                                "rod_cells": 40})

    def test_refused_in_one_line(self):
        data = self.place / "one.csv"
        data.write_text("t (s),wdth (cm)\n1,2\n2,3\n")
        for name in ("one", "two"):
            said, words = io.StringIO(), [str(self.place / "two.opts"), f"20s@{data}", "-p", "tip_force=1:2"]
            (self.place / "two.opts").touch()
            with contextlib.redirect_stderr(said):
                self.assertEqual(fit_command.main([*words, "--output", str(self.place / name)]), 1)
            self.assertRegex(said.getvalue(), f"^fit: --output .*{name}: would write over .*{name}.*\n$")
        for words, word in (([TUBE, data, {"si_friction_dry": ("0.2N/m", "2N/m")}], "wdth is no series"),
                            ([TUBE, data, {"si_frction_dry": (1, 2)}], "unknown option"),
                            ([TUBE, self.place / "none.csv", {"tip_force": (1, 2)}], "No such file"),
                            ([TUBE, data, {}], "what to look for")):
            with self.assertRaisesRegex(tendril.TendrilError, word):
                tendril.fit(*words, si_friction_dry=None if "si_friction_dry" in words[2] else "0.5N/m")


if __name__ == "__main__":
    os.environ["TENDRIL"] = str(Path(sys.argv.pop(1)).resolve())
    unittest.main()

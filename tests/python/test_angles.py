#!/usr/bin/env python3
# test: tables of angles are read, and roots fitted to them
"""Tables of tip and base angles over time: read as they are meant, refused in a line, and what a root senses by is found from them.

    test_angles.py build/tendril"""

import contextlib
import io
import os
import sys
import tempfile
import unittest
from pathlib import Path
from unittest import mock

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "support"))
from interpreter import ROOT, from_venv

os.environ.setdefault("OMP_NUM_THREADS", "1")  # matrices are small: threads of BLAS would only wait
sys.path.insert(0, str(ROOT / "scripts"))
try:
    import numpy as np

    import tendril
    from tendril import doubts, fit_command, measured, noise, problem, profiles, starting
    from tendril.parameters import Parameter
except ImportError as error:
    from_venv(error)

ROOTS = dict(growth_type="apical", growth_zone=0.5, growth_initial_length=1, friction_mu=1, friction_beta=1e-3, shape_type="straight",
             tropism_gravity=4, tropism_direction="0,1", tropism_proprioception=2, tropism_sensed="tip", tropism_memory=0.1)
COARSE = dict(rod_cells=24, ts_rtol=3e-4)  # of all runs: errors of angles are then a tenth of a degree
DEGREE = np.pi / 180


class InAPlace(unittest.TestCase):
    def setUp(self):
        self.directory = tempfile.TemporaryDirectory(prefix="tendril-")
        self.addCleanup(self.directory.cleanup)

    def file(self, text, name="angles.csv"):
        path = Path(self.directory.name) / name
        path.write_text(text)
        return path


class Tables(InAPlace):
    def test_one_root(self):
        """The tip's and the base's angles over one column of time; what is missing is left out, and what is not used is named."""
        m = measured.read(self.file("# a root\nhours,tip_deg,tip_se,base_deg,n_roots_tip\n0,5,1.2,1,9\n0.5,7,1.2,NA,9\n1,10,1,,9\n"))
        tip, base = m.curves
        self.assertEqual((tip.name, base.name, tip.abscissa, tip.values.unit, tip.at.unit), ("tip_angle", "base_angle", "t", "rad", "l/V"))
        np.testing.assert_allclose(tip.at.numbers, [0, 1800, 3600])
        np.testing.assert_allclose(tip.values.numbers, np.array([5, 7, 10]) * DEGREE)
        np.testing.assert_allclose(base.at.numbers, [0])
        self.assertTrue(any("not used: tip_se, n_roots_tip" in note for note in m.notes), m.notes)

    def test_headings(self):
        """As they are written: words in any order, degrees by sign or name, radians, a place behind the tip, Frame and --fps."""
        for heads, name, behind, one in (("t (min),tip angle (°)", "tip_angle", None, DEGREE), ("Time (hours),Tip Angle (degrees)", "tip_angle", None, DEGREE),
                                         ("time_h,angle of the tip [rad]", "tip_angle", None, 1), ("t (h);Base (deg)", "base_angle", None, DEGREE),
                                         ("t (h),base angle at 0.6 mm (deg)", "base_angle", 6e-4, DEGREE),
                                         ("t (h),angle_250um_deg", "base_angle", 2.5e-4, DEGREE), ("frame,tip (deg)", "tip_angle", None, DEGREE)):
            comma = ";" if ";" in heads else ","
            (c,) = measured.read(self.file(f"{heads}\n0{comma}1\n1{comma}2\n"), fps=1).curves
            self.assertEqual(c.name, name, heads)
            np.testing.assert_allclose(c.values.numbers, np.array([1, 2]) * one, err_msg=heads)
            self.assertEqual(c.behind and float(c.behind.numbers), behind, heads)

    def test_several_roots(self):
        """By a column that tells them apart, or a column each; each is a series of its own, whatever times it has."""
        m = measured.read(self.file("t (h),Root,tip_angle (deg),base_angle (deg)\n0,a,5,1\n1,a,9,NA\n0,b-2,4,\n1,b-2,,2\n2,b-2,11,3\n"))
        self.assertEqual([(c.name, len(c.at.numbers)) for c in m.curves], [("tip_angle", 2), ("tip_angle", 2), ("base_angle", 1), ("base_angle", 2)])
        self.assertIn("b-2", m.curves[1].source)
        np.testing.assert_allclose(m.curves[1].at.numbers, [0, 7200])
        self.assertTrue(any("2 organs" in note for note in m.notes), m.notes)
        m = measured.read(self.file("t (h),root 1 tip (deg),root 2 tip (deg)\n0,5,6\n1,9,\n2,,12\n"))
        self.assertEqual([len(c.at.numbers) for c in m.curves], [2, 2])
        self.assertIn("root 2", m.curves[1].source)

    def test_refused_in_one_line(self):
        for text, word in (("t (h),tip_angle\n0,5\n1,6\n", r"tip_angle has no unit; write tip_angle \(deg\) or tip_angle \(rad\)"),
                           ("t (h),tip_angle (mm)\n0,5\n1,6\n", "mm is no unit of an angle"),
                           ("t (h),tip_angle (rad)\n0,5\n1,60\n", r"reaches 60 rad; if these are degrees"),
                           ("t (h),tip_angle (deg)\n0,5\n2,6\n1,7\n", "line 4: t falls from 2 to 1; of several organs"),
                           ("t (h),root,tip_angle (deg)\n0,a,5\n0,b,6\n0,b,7\n", "line 4: t is 0 twice of root b"),
                           ("tip_angle (deg),base_angle (deg)\n5,1\n6,2\n", r"no column of time; write t \(h\)"),
                           ("t (h),t (s),tip_angle (deg)\n1,1,5\n", "2 columns"),
                           ("t (h),angle (deg)\n0,5\n1,6\n", None), ("t (h),tip_angle (deg),left (deg)\n0,5,1\n1,6,2\n", "the angle of what"),
                           ("t (h),tip to base angle (deg)\n0,5\n", None), ("t (h),tip base (deg)\n0,5\n", "the tip's angle or the base's"),
                           ("t (h),tip_angle (deg)\n0,five\n1,6\n", 'line 2: "five" is no number; leave what is missing empty'),
                           ("t (h),tip_angle (deg)\n,5\n1,6\n", "line 2: has an angle and no time"),
                           ("t (h),tip_angle (deg)\n0,NA\n1,\n", "no angle below")):
            path = self.file(text)
            if word is None:  # no angle of a tip or base: a series like any other, whose name is looked at with the run
                self.assertNotIn(measured.read(path).curves[0].name, ("tip_angle", "base_angle"), text)
                continue
            with self.assertRaisesRegex(measured.DataError, word) as refused:
                measured.read(path)
            self.assertNotIn("\n", str(refused.exception))


class Rises(unittest.TestCase):
    """An interval where derivatives tell nothing: a cost that rises with the fourth power of the distance, along a bent valley."""

    parameters, errors = [Parameter("a", 0, 1, None, ""), Parameter("b", 0, 1, None, "")], None

    def residuals(self, u):
        x, y = u - 0.4
        return np.array([50 * (y - x - x**2), 40 * x**2])

    def jacobian(self, u):
        x = u[0] - 0.4
        return np.array([[-50 * (1 + 2 * x), 50.0], [80 * x, 0.0]])

    def cost(self, f):
        return 0.5 * float(f @ f)

    def test_valley(self):
        u = np.array([0.4, 0.4])
        found = profiles.valley(self, u, 0, 0.0, 1.92, np.array([1.0, 1.0]))
        end = (2 * 1.92 / 1600) ** 0.25  # 0.5 (40 x^2)^2 = 1.92
        np.testing.assert_allclose(found.points[[0, -1], 0] - 0.4, [-end, end], rtol=0.1)
        self.assertEqual(found.open, (False, False))
        self.assertEqual(profiles.valley(self, u, 0, 0.0, 1e4, np.array([1.0, 1.0])).open, (True, True))
        known = noise.Certainty(4 * np.ones((2, 2)) + 1e-6 * np.eye(2), np.array([1.96, 1.96]))
        ends = profiles.followed_out(self, problem.Solution(u, 0.0), known, [1.92, 1.92], str)
        for k in (0, 1):
            self.assertLess(np.ptp(ends[k]), 0.6)
            self.assertTrue(ends[k][0] < 0.25 and 0.6 < ends[k][1], ends)


class Evenly(unittest.TestCase):
    """Angles of one root count alike in the search, and the interval knows how their errors are correlated."""

    def test_what_is_smooth(self):
        """Of a slope through errors that are all alike over some hours: the interval is that of plain least squares with
        these errors, not of independent ones, and holds the truth."""
        count, held, wide = 24, 0, []
        place = np.linspace(0, 16, count)
        kernel = noise.matern(np.abs(place[:, None] - place) / 2.0)[0] + 1e-2 * np.eye(count)
        jacobian = np.column_stack([place / 16, 1 - np.exp(-place / 3)])
        random = np.random.default_rng(5)
        around = np.linalg.inv(jacobian.T @ jacobian)
        right = np.sqrt((around @ jacobian.T @ kernel @ jacobian @ around)[0, 0])
        for _ in range(40):
            e = np.linalg.cholesky(kernel) @ random.normal(size=count)
            blocks = [noise.Block("tip_angle", np.arange(count), place, None, np.full(count, np.inf), True)]
            off, prior = np.zeros(2), 1e-6 * np.eye(2)
            errors = noise.estimate(blocks, e, jacobian, np.ones(count), prior)
            white = errors.whitened(np.column_stack([e, jacobian]), search=True)
            off = np.linalg.lstsq(white[:, 1:], -white[:, 0], rcond=None)[0]
            np.testing.assert_allclose(white[:, 1] * errors.evenly(blocks[0]), jacobian[:, 0])
            errors = noise.estimate(blocks, e + jacobian @ off, jacobian, np.ones(count), prior)
            known = noise.certainty(errors, e + jacobian @ off, jacobian, prior)
            half = known.reach[0] * np.sqrt(known.covariance[0, 0])
            wide.append(half / 1.96 / right)
            held += abs(off[0]) < half
        self.assertGreaterEqual(held, 34)  # of 40
        self.assertTrue(0.6 < np.median(wide) < 2, np.median(wide))

    def test_several_roots(self):
        """Each may be shifted: of eight roots the interval of their mean goes with the shifts."""
        count, place = 12, np.linspace(0, 10, 12)
        random, held = np.random.default_rng(7), 0
        for _ in range(20):
            e = np.concatenate([random.normal() + 0.1 * random.normal(size=count) for _ in range(8)])
            blocks = [noise.Block("tip_angle", np.arange(k * count, (k + 1) * count), place, None, np.full(count, np.inf), True, True)
                      for k in range(8)]
            jacobian, prior = np.ones((8 * count, 1)), np.array([[1e-6]])
            off = -np.mean(e)
            errors = noise.estimate(blocks, e + off, jacobian, np.ones(8 * count), prior)
            self.assertGreater(errors.groups["tip_angle"].shift, 0.3)
            known = noise.certainty(errors, e + off, jacobian, prior)
            held += abs(off) < known.reach[0] * np.sqrt(known.covariance[0, 0])
        self.assertGreaterEqual(held, 17)  # independent errors alone would make it a tenth as wide


class Exchanged(unittest.TestCase):
    def test_two_delays(self):
        """Memory and straightening change places, in the bounds' units; twice is once."""
        names = {"tropism_gravity": ("1/mm", "50/mm"), "tropism_proprioception": (0.1, 50), "tropism_memory": ("0.1h", "20h"), "friction_mu": (0, 1)}
        parameters = [Parameter.of(name, bounds) for name, bounds in names.items()]
        about = {"parameters/growth_type": "apical", "parameters/growth_zone": 0.6, "si_time": 36000.0}
        p = mock.Mock(parameters=parameters, rod=lambda u: about)
        u = np.array([q.inside(value) for q, value in zip(parameters, (4, 5, 2, 0.3))])
        other = starting.exchanged(p, u)  # G = 0.6/0.2, T = 0.6/5 of 10 h
        np.testing.assert_allclose([float(q.value(x)) for q, x in zip(parameters, other)], [2.4, 3, 1.2, 0.3])
        np.testing.assert_allclose(starting.exchanged(p, other), u)
        self.assertIsNone(starting.exchanged(mock.Mock(parameters=parameters[:2], rod=lambda u: about), u[:2]))


class Roots(InAPlace):
    @classmethod
    def setUpClass(cls):
        cls.run_of_truth = tendril.run(ROOTS, ts_max_time=1.5, output_interval=0.02, progress=False, rod_cells=60, ts_rtol=1e-5)

    def table(self, scatter=0.0, seed=1, columns=("tip", "base")):
        """The truth at 16 times, in degrees, with errors of so many degrees."""
        from tendril.comparing import angles_behind
        random, r, t = np.random.default_rng(seed), self.run_of_truth, np.linspace(0, 1.5, 16)
        angles = [np.interp(t, r.shapes.t, angles_behind(r, {"tip": 0.0, "base": 0.5}[c])) / DEGREE for c in columns]
        rows = np.column_stack([t, *(a + scatter * random.normal(size=len(t)) for a in angles)])
        return self.file(",".join(["t", *(f"{c}_angle (deg)" for c in columns)]) + "\n" + "\n".join(",".join(map(repr, map(float, row))) for row in rows))

    def test_angles_of_a_run(self):
        """The tip's is the series', the base's that where the zone ends; shorter rods have the clamp's."""
        from tendril.comparing import angles_behind
        r = self.run_of_truth
        np.testing.assert_allclose(angles_behind(r, 0.0), np.interp(r.shapes.t, r.series.t, r.series.tip_angle), atol=2e-4)
        s, last = r.shapes.s, r.shapes.theta[-1]
        self.assertAlmostEqual(float(angles_behind(r, 0.5)[-1]), float(np.interp(1 - 0.5 / r.series.length[-1], s, last)), delta=1e-3)
        self.assertEqual(float(angles_behind(r, 99.0)[-1]), last[0])

    def test_finds_the_truth(self):
        """Sensing, proprioception and memory, within their intervals; runs tell all derivatives."""
        with mock.patch("tendril.fitting.warnings_of", return_value=[]):  # what else may be wrong is asked below
            f = tendril.fit({k: v for k, v in ROOTS.items() if k not in ("tropism_gravity", "tropism_proprioception", "tropism_memory")},
                            self.table(0.5), {"tropism_gravity": (1, 16, 3), "tropism_proprioception": (0.5, 8, 1.5), "tropism_memory": (0.02, 0.5)},
                            starts=0, progress=False, **COARSE)
        self.assertEqual(len(f.problem.followed), 3)
        for name, truth in (("tropism_gravity", 4), ("tropism_proprioception", 2), ("tropism_memory", 0.1)):
            low, high = f.intervals[name]
            self.assertTrue(low < truth < high, (name, low, high))
        self.assertLess(f.intervals["tropism_gravity"][1] / f.intervals["tropism_gravity"][0], 3)
        self.assertAlmostEqual(f.noise["tip_angle"] / DEGREE, 0.5, delta=0.25)

    def test_a_fit_without_proprioception_is_called_bad(self):
        """And what is missing is named: with it the residuals fall."""
        with mock.patch.object(doubts, "CAUSES", []), mock.patch.object(doubts, "of_angles", list):  # these are tried elsewhere
            f = tendril.fit(ROOTS | {"tropism_proprioception": 0}, self.table(0.5, columns=("tip",)), {"tropism_gravity": (0.5, 16)}, starts=0,
                            progress=False, **COARSE)
        said = "\n".join(f.warnings)
        self.assertFalse(f.trusted)
        self.assertRegex(said, "a bad fit: tip_angle is off the best scene's by")
        self.assertRegex(said, "likeliest cause: the scene, in which nothing straightens what is bent .no proprioception.")

    def test_angles_that_count_otherwise(self):
        """From x2, or with the other sign, or in radians under degrees: each is tried, and is what the data would be without."""
        data = measured.gather(self.table(columns=("tip",)))
        angles, found = data.curves[0].values.numbers, {}
        for cause in doubts.of_angles():
            found[cause.words] = doubts.changed(data, cause.change).curves[0].values.numbers
        for word, expected in (("other sign", -angles), ("less the angle", np.pi / 2 - angles), ("the angle less 90", angles - np.pi / 2),
                               ("heading says radians", angles * DEGREE), ("heading says degrees", angles / DEGREE)):
            (values,) = (values for words, values in found.items() if word in words)
            np.testing.assert_allclose(values, expected)
        rows = [row.split(",") for row in self.table(0.3, columns=("tip",)).read_text().splitlines()]
        upside = self.file("\n".join(",".join([t, a if a.startswith("tip") else repr(-float(a))]) for t, a in rows))
        with mock.patch.object(doubts, "CAUSES", []), mock.patch.object(doubts, "laws_of", lambda _: []):
            f = tendril.fit(ROOTS, upside, {"tropism_gravity": (2, 6)}, starts=1, progress=False, **COARSE)
        self.assertRegex("\n".join(f.warnings), "likeliest cause: the angles have the other sign")

    def test_sweeps_have_the_series_of_growth_that_senses(self):
        """As single runs do; of a member that does not sense they are no series."""
        with tempfile.TemporaryDirectory() as place:
            s = tendril.sweep({k: v for k, v in ROOTS.items() if not k.startswith("tropism_")}, directory=place, progress=False, ts_max_time=0.3,
                              over={"tropism_gravity": [2, 4]}, tropism_direction="0,1", tropism_sensed="tip", **COARSE)
            for b, r in zip((2, 4), s.members):
                own = tendril.run({k: v for k, v in ROOTS.items() if not k.startswith("tropism_")}, progress=False, ts_max_time=0.3,
                                  tropism_gravity=b, tropism_direction="0,1", tropism_sensed="tip", **COARSE)
                np.testing.assert_array_equal(r.series.tip_angle, own.series.tip_angle)
                self.assertEqual(set(r.series), set(own.series))
            self.assertIn("tip_angle", s.dataset())
            self.assertNotIn("writhe", s.dataset())

    def test_derivatives_of_all_numbers(self):
        """What runs tell by each number of growth that senses is what differences between them are."""
        numbers = {"tropism_gravity": 4, "tropism_proprioception": 2, "tropism_memory": 0.2, "growth_ironing": 3, "tropism_light": 1,
                   "tropism_nutation": 0.5, "tropism_nutation_rate": 5, "growth_zone": 0.5, "clamp_angle": 0.2}
        parameters = [Parameter.of(name, (0.5 * value, 1.5 * value)) for name, value in numbers.items()]
        scene = {k: v for k, v in ROOTS.items() if k not in numbers} | {"tropism_source": "2,1.5"}
        p = problem.Problem(scene, measured.gather(self.table()), parameters, {"rod_cells": 40, "ts_rtol": 1e-7})
        u = np.full(len(numbers), 0.5)
        p.prepare(u, 1e-4)
        p.measure_noise(u)
        self.assertEqual(set(p.followed), set(numbers))
        told = p.raw_jacobian(u)
        p.followed = []
        problem.FINE_STEP, before = 2e-3, problem.FINE_STEP
        self.addCleanup(setattr, problem, "FINE_STEP", before)
        found = p.raw_jacobian(u, central=True)
        for k, name in enumerate(numbers):
            self.assertGreater(np.linalg.norm(found[:, k]), 1e-4, name)
            self.assertLess(np.linalg.norm(told[:, k] - found[:, k]), 0.01 * np.linalg.norm(found[:, k]), name)

    def test_refused(self):
        """In one line: a time without a unit beside a scene with seconds, no growth zone, more parameters than numbers, no such series."""
        laboratory = {"si_bending_stiffness": "1e-3Nmm^2", "si_friction_dry": "1mN/mm", "si_speed": "0.1mm/h", "growth_initial_length": "2mm",
                      "growth_zone": "0.6mm", "growth_type": "apical", "shape_type": "straight", "tropism_direction": "0,1"}
        for scene, text, wanted, word in (
                (laboratory, "t,tip_angle (deg)\n0,1\n1,2\n2,4\n", {"tropism_gravity": ("1/mm", "5/mm")}, r"t has no unit, and this scene has seconds; write t \(h\)"),
                (ROOTS | {"growth_type": "uniform", "growth_zone": None}, "t,base_angle (deg)\n0,1\n1,2\n2,3\n", {"tropism_gravity": (1, 5)},
                 "no growth zone, at whose base.*write how far behind"),
                (ROOTS, "t,tip_angle (deg)\n0,1\n1,2\n", {"tropism_gravity": (1, 5), "tropism_memory": (0.1, 1)}, "2 parameters from 2 numbers"),
                (ROOTS, "t,angle (deg)\n0,1\n1,2\n", {"tropism_gravity": (1, 5)}, "angle is no series"),
                (ROOTS, "t,tip_angle (deg)\n0,1\n1,2\n", {"tropism_gravty": (1, 5)}, "did you mean tropism_gravity")):
            with self.assertRaisesRegex(tendril.TendrilError, word) as refused:
                tendril.fit({k: v for k, v in scene.items() if v is not None} | COARSE, self.file(text), wanted, starts=0, progress=False)
            self.assertNotIn("\n", str(refused.exception))

    def test_a_command(self):
        """From the table to the report in one command, as it is typed."""
        scene = self.file("\n".join(f"-{k} {v}" for k, v in (ROOTS | {"rod_cells": 24}).items()), "root.opts")
        data, out = self.table(0.5, columns=("tip",)), Path(self.directory.name) / "found"
        with contextlib.redirect_stdout(io.StringIO()) as said:
            self.assertEqual(fit_command.main([str(scene), str(data), "-p", "tropism_gravity=1:16", "--starts", "0", "--accuracy", "3e-3",
                                               "--output", str(out), "--", "-ts_rtol", "3e-4"]), 0)
        self.assertRegex(said.getvalue(), r"(?m)^tropism_gravity +\d.*to")
        self.assertRegex(said.getvalue(), r"noise of tip_angle: 0\.\d+ deg")
        self.assertIn("-tropism_gravity", out.with_suffix(".opts").read_text())
        self.assertTrue(out.with_suffix(".png").exists())


if __name__ == "__main__":
    os.environ["TENDRIL"] = str(Path(sys.argv.pop(1)).resolve())
    unittest.main()

#!/usr/bin/env python3
# test: damaged files and calls end in one line
"""Commands and functions of the Python package, fed with damaged inputs: some of those of scripts/lab/damages.py.

    test_damages.py build/tendril        with .venv's python, or one that has what the package needs"""

import contextlib
import io
import os
import subprocess
import sys
import tempfile
import unittest
from inspect import signature
from pathlib import Path
from unittest import mock

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "support"))
from interpreter import ROOT, from_venv

sys.path[:0] = [str(ROOT / "scripts"), str(ROOT / "scripts/lab")]
try:
    import h5py
    import numpy as np

    import damages
    import tendril
    import tendril.__main__ as commands
    from matplotlib.figure import Figure

    from tendril import centrelines, comparing, errors, measured, plot_stability
except ImportError as error:
    from_venv(error)

FEW = {"plot": 4, "view": 4, "export": 4, "map": 4, "ensemble": 3, "stability": 3, "surface": 6, "growth_table": 3, "fit": 2, "measure": 2,
       "py.load": 5, "py.at": 4, "py.map": 3, "py.to_csv": 2, "py.view": 2, "py.circle": 3}


class Damages(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.directory = tempfile.TemporaryDirectory(prefix="tendril-")
        cls.place = Path(cls.directory.name)
        damages.made(cls.place)

    @classmethod
    def tearDownClass(cls):
        cls.directory.cleanup()

    def test_end_right_or_in_a_line(self):
        for what, count in FEW.items():
            found = damages.fed(what, damages.everything()[what], self.place, range(1, 1 + count))
            self.assertEqual(len(found), count, what)
            for seed, words, end, said in found:
                self.assertIn(end, ("right", "line"), f"{what} {seed}: {words}: {said}")

    def test_what_is_wrong_is_seen(self):
        """By that which looks at the ends: a traceback, a warning, several lines, none, another code."""
        for code, said, warned, failure, end in ((1, "plot: a: no such file\n", "", "", "line"), (0, "", "", "", "right"),
                                                 (None, "", "", "KeyError", "traceback"), (0, "", "RuntimeWarning", "", "warning"),
                                                 (1, "a\nb\n", "", "", "2 lines"), (1, "", "", "", "0 lines"),
                                                 (3, "plot: a fault\n", "", "", "unexpected"), (1, "oh\n", "", "", "no name")):
            self.assertRegex(damages.judged(code, said, warned, failure), f"^{end}")

    def without(self, name, change, of="tube"):
        """A result file, changed."""
        path = self.place / f"{name}.h5"
        path.write_bytes((self.place / f"{of}.h5").read_bytes())
        with h5py.File(path, "r+") as file:
            change(file)
        return path

    def test_result_files_say_what_is_wrong_with_them(self):
        def put(name, values):
            def change(file):
                del file[name]
                file[name] = values
            return change

        def attribute(name, value):
            return lambda file: file.attrs.__setitem__(name, value)

        def gone(name):
            return lambda file: file.__delitem__(name)

        with h5py.File(self.place / "tube.h5") as file:
            x = file["shapes/x"][()]
        for change, line in ((gone("shapes/x"), "shapes: no x here"), (put("shapes/x", x[..., 0]), "shapes/x: is an array"),
                             (put("shapes/x", np.where(x > 0.3, np.nan, x)), "shapes/x: holds a number that is not finite"),
                             (put("shapes/theta", np.zeros((3, 4))), "shapes/theta: .*does not go with the others"),
                             (put("series/t", np.zeros((3, 4))), "series/t: is an array"), (put("series/width", b"a"), "series/width: "),
                             (gone("series/length"), "series: no length here"), (attribute("si_length", "abc"), "attribute si_length: abc"),
                             (attribute("si_time", -1.0), "attribute si_time"), (put("shapes/x", 0 * x), "a rod without a length")):
            with self.assertRaisesRegex(tendril.ResultsError, line):
                tendril.load(self.without("bad", change))
        halved = tendril.load(self.without("missing", gone("series/norm_x2")))
        for call in (tendril.plot, lambda r: tendril.plot(r, "norm")):
            with self.assertRaisesRegex(tendril.ResultsError, "missing.h5: series: no norm_x2 here"):
                call(halved)

    def test_sweeps_and_stability_say_what_is_wrong_with_them(self):
        """Rows of another rank in a sweep; deflections that grow most without their nodes, or of nothing; a run with a norm
        that is not finite, of which the others are drawn."""
        def put(name, change):
            def changed(file):
                values = file[name][()]
                del file[name]
                file[name] = change(values)
            return changed

        for name in ("shapes/t", "series/self_crossings", "shapes/x"):
            path = self.without("rows", put(name, lambda v: v[..., None]), "sweep")
            with self.assertRaisesRegex(tendril.ResultsError, f"rows.h5: {name}: is an array"):
                tendril.ensemble(path).plot()
        for name, change, line in (("L2/s", lambda v: v[:0], "transient/L2/initial_y: .* does not go with"),
                                   ("L2/initial_y", lambda v: 0 * v, "transient: its deflections are 0"),
                                   ("t1", lambda v: np.nan, "transient/t1: holds a number that is not finite")):
            with self.assertRaisesRegex(tendril.ResultsError, line):
                tendril.plot(self.without("grows", put(f"transient/{name}", change), "stability"))
        t, norm = np.arange(11.0), 1 + np.abs(np.arange(11.0) - 5)
        norm[6] = np.inf
        figure = Figure()
        r = mock.Mock(series=mock.Mock(t=t, norm_x2=norm))
        plot_stability.draw_run(figure.subplots(), r, 10)
        self.assertTrue(np.isfinite(figure.axes[0].lines[1].get_xydata()).all())

    def test_a_run_that_goes_on(self):
        """Its last rows may be half written: they are left out, not refused."""
        def change(file):
            for name in ("x", "theta", "t"):
                values = file[f"shapes/{name}"][()]
                values[-1] = 0
                file[f"shapes/{name}"][...] = values
        whole, cut = tendril.load(self.place / "tube.h5"), tendril.load(self.without("going", change))
        self.assertEqual(len(cut.shapes.t), len(whole.shapes.t) - 1)
        self.assertEqual(len(cut.shapes.force), len(cut.shapes.t))

    def test_last_net(self):
        """A fault of the program's own is a line, too, and to who asks a traceback; what argparse refuses is one line."""
        with mock.patch.object(commands, "import_module", return_value=mock.Mock(main=mock.Mock(side_effect=KeyError("n\nm")))):
            with contextlib.redirect_stderr(io.StringIO()) as said:
                self.assertEqual(commands.main(["plot", "a"]), 3)
            self.assertRegex(said.getvalue(), r"^plot: a fault of tendril's own, KeyError: .*TENDRIL_TRACEBACK=1 .*\n$")
            with mock.patch.dict(os.environ, TENDRIL_TRACEBACK="1"), self.assertRaises(KeyError):
                commands.main(["plot", "a"])
        for words in (["plot"], ["view", "--output"], ["animate", "a", "--frames", "x"], ["growth_table", "a"], ["fit", "a"], ["measure", "a"]):
            with contextlib.redirect_stderr(io.StringIO()) as said, self.assertRaises(SystemExit) as end:
                commands.main(words)
            self.assertEqual(end.exception.code, 2)
            self.assertRegex(said.getvalue(), rf"^tendril-py {words[0]}: .*; -h says what there is\n$")

    def test_arguments(self):
        """Of each kind: what is one and what is none; None where it may be."""
        good = {"flag": (True, 0, np.bool_(True)), "number": (1, 0.5, np.float64(2)), "above 0": (1e-9,), "whole": (3, np.int64(0)), "count": (1,),
                "time": (0, "2s", 0.5, float("inf")), "text": ("a",), "texts": ("a", ["a", "b"], ()), "file": ("a", Path("b")),
                "numbers": ("start", (1, 2.5), np.zeros(3)), "times": ("2s", 1.5, ["2s", 3], (), np.zeros(2))}
        bad = {"flag": (2, "x", None), "number": (True, "1", float("nan")), "above 0": (0, -1), "whole": (0.5, True), "count": (0,),
               "time": (None, [1], b"x", True), "text": (3, None), "texts": ([1], 3), "file": (3, "", b"x"), "numbers": (3, ["a"], [True]), "times": ([[1], [1, 2]], {}, [None], np.zeros((2, 2)))}
        self.assertEqual(good.keys(), errors.KINDS.keys())
        for kind, values in good.items():
            call = errors.arguments(value=kind)(lambda value: "called")
            for value in values:
                self.assertEqual(call(value), "called", (kind, value))
            for value in bad[kind]:
                with self.assertRaisesRegex(tendril.TendrilError, "^value: give ", msg=(kind, value)):
                    call(value=value)
            self.assertEqual(errors.arguments(value=f"{kind}?")(lambda value: "called")(None), "called")
        for wall in (lambda inside: tendril.circle((0, 3), 1, inside), lambda inside: tendril.polygon([(0, 1), (1, 1), (1, 2)], inside)):
            with self.assertRaisesRegex(tendril.TendrilError, "^inside: give True or False, not "):
                wall(np.zeros((2, 2)))
        with self.assertRaisesRegex(tendril.TendrilError, "^1: is no name of an option"):
            tendril.critical({1: 2})
        for control in "\n\x0b\x1b\x85\u2028":
            self.assertEqual(str(tendril.TendrilError(f"a{control}b")), "a b")

    def test_requests_that_no_memory_holds(self):
        """Are refused in a line, by their limits or as memory is refused."""
        for words, line in ((["growth_table", "o.h5", "--length", "1", "--end", "1", "--rate", "1", "--times", "10000000000"], "--times: .* are the most"),
                            (["measure", str(self.place / "rod.tif"), "--clamp", "20,60", "--points", "10000000000"], "points 10000000000: .* to 10000")):
            with contextlib.redirect_stderr(io.StringIO()) as said:
                self.assertEqual(commands.main(words), 1)
            self.assertRegex(said.getvalue(), f"^{words[0]}: .*{line}.*\n$")
        with mock.patch.object(commands, "import_module", return_value=mock.Mock(main=mock.Mock(side_effect=MemoryError("7 TiB")))):
            with contextlib.redirect_stderr(io.StringIO()) as said:
                self.assertEqual(commands.main(["plot", "a"]), 1)
        self.assertRegex(said.getvalue(), r"^plot: needs more memory than there is; .* \(7 TiB\)\n$")
        with self.assertRaisesRegex(tendril.TendrilError, "^to_mesh: sides .* to 1000$"):
            tendril.load(self.place / "tube.h5").to_mesh(sides=10**12)
        call = errors.arguments(value="number")(mock.Mock(__name__="call", side_effect=MemoryError, __signature__=signature(lambda value: 0)))
        with self.assertRaisesRegex(tendril.TendrilError, "^call: needs more memory"):
            call(1)

    def test_what_cannot_have_been_measured(self):
        """Points that are all in one place, numbers of which squares are none: before the first run."""
        for cell, line in (("10", "measured.csv.*: all points that were measured are in one place"), ("1e200", "measured.csv.*: 1e.200 cannot have been measured")):
            (self.place / "measured.csv").write_text(f"t (s),x1 (px),x2 (px)\n2,10,20\n2,{cell},20\n2,10,20\n2,10,20\n")
            with self.assertRaisesRegex(tendril.TendrilError, line):
                tendril.fit(self.place / "tube.opts", self.place / "measured.csv", {"si_friction_dry": ("0.2N/m", "2N/m")}, progress=False)
        with self.assertRaisesRegex(tendril.TendrilError, "^tip_force: 1: is no name of an array"):
            tendril.critical(friction_beta=1e-6, tip_force={1: 2})

    def test_paths_of_points_that_tell_no_smooth_one(self):
        """Stay what they are: knots between points far apart, in numbers that no loop gets through, too."""
        x = np.column_stack([[0.0, 0.8, 1.7, 2.5, 3.3, 4.2, 5, 5.9, 7.1, 9, 12.5, 20], *np.zeros((2, 12)), np.full(12, 0.1)])
        for every in (2, 1e-9, 1e-300):
            points, moved = centrelines.fair(x, every)
            self.assertTrue(np.isfinite(points).all() and moved == 0, every)

    def test_names_that_the_terminal_cannot_show(self):
        """Are told in what it can show."""
        name = os.fsdecode(b"o\xff")
        for coding, shown in (("utf-8", r"o\udcff\u20ac".replace(r"\u20ac", "\u20ac")), ("ascii", r"o\udcff\u20ac")):
            ended = subprocess.run([sys.executable, "-m", "tendril", "plot", "tube.h5", "--panels", "width", "--output", f"{name}\u20ac"],
                                   cwd=self.place, capture_output=True, env=os.environ | {"PYTHONIOENCODING": coding, "PYTHONPATH": str(ROOT / "scripts")})
            self.assertEqual((ended.returncode, ended.stdout.decode(coding), ended.stderr), (0, f"plot: {shown}.png and .pdf\n", b""))

    def test_cameras_that_see_no_rod(self):
        """A search steps to scales in which a rod is a point, or that no number holds: these are as far off as can be."""
        rows = ["t (s),x1 (px),x2 (px)", "2,10,20", "2,60,25", "2,110,20", "2,150,30"]
        (self.place / "pixels.csv").write_text("\n".join(rows) + "\n")
        run = tendril.load(self.place / "tube.h5")
        comparison = comparing.Comparison(measured.read(self.place / "pixels.csv"))
        own = comparison.guess(run)
        self.assertTrue(comparison.sees(run, own))
        for k, off in ((0, 30), (0, -30), (0, 3e6), (0, np.nan), (1, 1e10), (2, -1e10)):
            self.assertFalse(comparison.sees(run, own + off * np.eye(4)[k]), (k, off))


if __name__ == "__main__":
    os.environ["TENDRIL"] = str(Path(sys.argv.pop(1)).resolve())
    unittest.main()

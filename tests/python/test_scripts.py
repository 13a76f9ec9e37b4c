#!/usr/bin/env python3
# test:
"""The reader and the pictures, on results made by tendril itself.

    test_scripts.py build/tendril        with .venv's python, or one that has h5py and matplotlib"""

import contextlib
import io
import os
import shutil
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path
from unittest import mock

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "support"))
from interpreter import ROOT, from_venv

SCRIPTS = ROOT / "scripts"
sys.path.insert(0, str(SCRIPTS))
try:
    import h5py
    import numpy as np

    from tendril import ResultsError, __main__ as commands, films, load
    from tendril.units import Units, briefly
except ImportError as error:
    from_venv(error)

TENDRIL = ""


def quietly(command, arguments):
    """(exit code, stdout, stderr) of a command."""
    out, err = io.StringIO(), io.StringIO()
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
        result = commands.main([command, *map(str, arguments)])
    return result, out.getvalue(), err.getvalue()


class Scripts(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.directory = tempfile.TemporaryDirectory(prefix="tendril-")
        d = Path(cls.directory.name)
        cls.file, cls.straight, cls.cut = d / "a.h5", d / "straight.h5", d / "cut.h5"
        for file, more in ((cls.file, "-clamp_angle -0.5"), (cls.straight, "-shape_type straight")):
            command = [TENDRIL, "-output", file, "-rod_cells", "60", "-ts_max_time", "2",
                       "-output_interval", "0.5", *more.split()]
            subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
        cls.cut.write_bytes(cls.file.read_bytes()[:2000])

    @classmethod
    def tearDownClass(cls):
        cls.directory.cleanup()

    def test_reader(self):
        r = load(self.file)
        self.assertTrue(r.finished)
        self.assertEqual(r.options["clamp_angle"], "-0.5")
        self.assertEqual(r.options["rod_cells"], "60")
        self.assertTrue(all(len(a) == len(r.series.t) for a in r.series.values()))
        np.testing.assert_allclose(r.shapes.t, [0, 0.5, 1, 1.5, 2], atol=1e-12)
        np.testing.assert_allclose(r.series.length, 0.5 + r.series.t, rtol=1e-12)
        shape = r.at(0.9, nearest=True)
        self.assertEqual((shape.index, shape.x.shape, shape.force.shape), (2, (61, 2), (61, 2)))
        self.assertAlmostEqual(shape.length, 1.5)
        self.assertAlmostEqual(shape.theta[0], -0.5)
        t, value = r.minimum("length")
        self.assertEqual((t, value), (0, 0.5))
        self.assertIn("series/norm_x2", r.notes)

    def test_reader_agrees_with_itself(self):
        r = load(self.file)  # the last shape is the last step
        shape = r.at(2)
        np.testing.assert_allclose(shape.x[-1], [r.series.tip_x1[-1], r.series.tip_x2[-1]],
                                   rtol=1e-9)
        np.testing.assert_allclose(-shape.force[0],
                                   [r.series.base_force_1[-1], r.series.base_force_2[-1]],
                                   rtol=1e-9)

    def test_bad_files(self):
        for path in (self.cut, self.file.parent / "none.h5", self.file.parent):
            with self.assertRaises(ResultsError):
                load(path)
            result, _, err = quietly("plot", [path])
            self.assertEqual(result, 1)
            self.assertRegex(err, r"^plot: .*\n$")
        said = quietly("plot", [self.file, "--titles", "a,b"])
        self.assertEqual((said[0], said[2]), (1, "plot: 2 titles for 1 runs\n"))

    def test_no_directory(self):
        """Where the file that is asked for cannot be made, one line says so, and what to do."""
        nowhere = self.file.parent / "nowhere"
        for command, name, word in (("plot", "a.png", "--output"), ("animate", "a.gif", "-o"), ("view", "a.html", "-output")):
            result, _, err = quietly(command, [self.file, word, nowhere / name])
            self.assertEqual(result, 1)
            self.assertRegex(err, rf"^\w+: {nowhere}/{name}: there is no directory {nowhere}; make it, or .*\n$")
        with self.assertRaisesRegex(ResultsError, "a film is of one run, not of 2"):
            films.animate([self.file, self.file], nowhere.parent / "a.gif")

    def test_plot(self):
        base = self.file.parent / "picture"
        for files, more in (([self.file], []), ([self.file, self.straight], []),
                            ([self.straight], ["--panels", "norm", "--times", "1"])):
            result, out, err = quietly("plot", [*files, "--output", base, *more])
            self.assertEqual((result, out, err), (0, f"plot: {base}.png and .pdf\n", ""))
            for ending in (".png", ".pdf"):
                self.assertGreater(base.with_suffix(ending).stat().st_size, 3000)
                base.with_suffix(ending).unlink()

    def test_plot_tells_of_times_it_lacks(self):
        """Where too few shapes are stored to tell that of another time, and only there."""
        few = self.file.parent / "few.h5"
        subprocess.run([TENDRIL, "-output", few, *"-rod_cells 60 -growth_initial_length 2 -shape_amplitude 0.5 "
                        "-ts_max_time 20 -output_shapes 1".split()], check=True, stdout=subprocess.DEVNULL)
        for file, time, word in ((self.file, "0.7", None), (few, "4", "no shape stored at t = 4, drawn at 0")):
            _, out, _ = quietly("plot", [file, "--times", time, "--panels", "shapes", "--output",
                                                self.file.parent / "times"])
            self.assertIn(word, out) if word else self.assertNotIn("no shape", out)

    def test_one_picture_of_its_name(self):
        """A name with an ending is that file; a PDF holds no Type 3 font, which journals refuse."""
        base = self.file.parent / "named"
        for ending in (".png", ".svg", ".pdf"):
            self.assertEqual(quietly("plot", [self.file, "--output", f"{base}{ending}"])[0], 0)
        self.assertEqual(sorted(f.name for f in base.parent.glob("named*")), ["named.pdf", "named.png", "named.svg"])
        self.assertNotIn(b"/Type3", base.with_suffix(".pdf").read_bytes())

    def test_a_time_beyond_the_end_is_an_error(self):
        base = self.file.parent / "beyond"
        for files in ([self.file], [self.file, self.straight]):
            result, _, err = quietly("plot", [*files, "--times", "1,9", "--output", base])
            self.assertEqual(result, 1)
            self.assertRegex(err, r"^plot: \S+: ends at t = 2; no shape at 9\n$")
        self.assertFalse(base.with_suffix(".png").exists())

    def test_slips(self):
        """A flag between two files, a name nearly right, a scene in the place of its result."""
        d = self.file.parent
        between = ["--overlay", self.file, "--panels", "width", self.straight, "--output", d / "slip"]
        self.assertEqual(quietly("plot", between), (0, f"plot: {d}/slip.png and .pdf\n", ""))
        self.assertIn("panel shape: unknown, did you mean shapes?",
                      quietly("plot", [self.file, "--panels", "shape", "--output", d / "no"])[2])
        (d / "scene.opts").write_text("-growth_type feed\n")
        self.assertIn("is an options file, not its result; run it", quietly("plot", [d / "scene.opts"])[2])
        self.assertIn("is a directory", quietly("plot", [d])[2])

    def test_laboratory(self):
        """--si and times with units, of a run in the laboratory; refused of another."""
        d = self.file.parent
        tube, film = d / "tube.h5", d / "tube.gif"
        subprocess.run([TENDRIL, "-output", tube, *"""-rod_cells 60 -si_bending_stiffness 2.209e-6
            -si_friction_dry 0.5 -si_speed 5e-3 -growth_initial_length 0.6094313102
            -ts_max_time 3.656587861265385 -output_interval 0.3047156551""".split()],
                       check=True, stdout=subprocess.DEVNULL)
        with contextlib.redirect_stdout(io.StringIO()):
            u = Units([load(tube)])
        self.assertEqual([u.scales[k][1] for k in ("length", "time", "speed", "force")],
                         ["cm", "s", "mm/s", "mN"])
        self.assertAlmostEqual(float(u.of("length", load(tube).series.length[-1])), 7, places=6)
        self.assertEqual(u.label("$x_1$", "length"), "$x_1$ (cm)")
        said = ["--times", "4s,0.1min", "--panels", "shapes,force", "--output", d / "si"]
        self.assertEqual(quietly("plot", [tube, "--si", *said]), (0, f"plot: {d}/si.png and .pdf\n", ""))
        self.assertAlmostEqual(load(tube).at("0.1min").length, load(tube).at(6 * 0.3047156551).length, 9)
        with self.assertRaisesRegex(ResultsError, "at 4furlong: give a time"):
            load(tube).at("4furlong")
        beyond = quietly("plot", [tube, "--si", "--times", "20s", "--output", d / "no"])
        self.assertEqual(beyond[2], f"plot: {tube}: ends at t = 12 s; no shape at 20 s\n")
        bare = quietly("plot", [tube, "--si", "--times", "8", "--output", d / "no"])
        self.assertIn("; give 8s if seconds are meant)", bare[2])
        self.assertEqual(quietly("plot", [tube, *said])[0], 0)
        result, out, err = quietly("animate", [tube, "--si", "--from", "2s", "--to", "0.1min",
                                                  "--output", film])
        self.assertEqual((result, out, err), (0, f"animate: {film}, 5 frames\n", ""))
        for command, more, word in (("plot", ["--times", "4s"], "seconds"),
                                    ("plot", ["--si"], "si needs"),
                                    ("plot", ["--times", "4furlong"], "min"),
                                    ("animate", ["--from", "4s"], "seconds"),
                                    ("animate", ["--si"], "si needs")):
            result, _, err = quietly(command, [self.file, *more, "--output", d / "no.gif"])
            self.assertEqual((result, err.count("\n")), (1, 1), err)
            self.assertIn(word, err)

    def test_mutations_are_of_this_source(self):
        """What scripts/lab/mutations.py changes stands in src as it says."""
        with mock.patch.object(sys, "path", [str(SCRIPTS / "lab"), *sys.path]):
            import mutations
        self.assertEqual(list(mutations.misplaced()), [])

    def test_numbers_in_words(self):
        self.assertEqual([briefly(x) for x in (123.4, 0.5, 0.01234, 1.26e7)], ["120", "0.5", "0.012", "1.3e+07"])

    def test_growth_table_is_checked_anywhere(self):
        """--check grows a rod with the program, wherever one stands."""
        table, here = self.file.parent / "slowing.h5", os.getcwd()
        words = [table, "--length", "1", "--end", "3", "--rate", "0.3*exp(-d)", "--check"]
        path = f"{Path(shutil.which(TENDRIL)).resolve().parent}:{os.environ['PATH']}"
        with mock.patch.dict(os.environ, PATH=path):
            os.environ.pop("TENDRIL", None)
            os.chdir(table.parent)
            try:
                result, out, err = quietly("growth_table", words)
            finally:
                os.chdir(here)
        self.assertEqual((result, err), (0, ""))
        self.assertIn("straight rod", out)

    def test_growth_table_of_measured_rates(self):
        """Rates as tables have them: separators, titles, units in headings or below, percent; what is left without a unit is that of
        the rod. The table it writes has the units of --length and --end."""
        plain = [["0", "0.05"], ["2", "0.16"], ["5", "0.14"], ["11", "0"]]
        percent = [[d, f"{100 * float(r):g}"] for d, r in plain]

        def table(text, length="20mm", end="12h"):
            data, file = self.file.parent / "rate.csv", self.file.parent / "rate.h5"
            data.write_bytes(text if isinstance(text, bytes) else text.encode())
            result, out, err = quietly("growth_table", [str(file), "--length", length, "--end", end, "--rate", str(data)])
            self.assertNotIn("Traceback", err)
            if result:
                self.assertEqual(err.count("\n"), 1, err)
                return err
            with h5py.File(file) as f:
                return f["g"][()], f["t"][()], [str(f[name].attrs.get("units", "")) for name in "tg"]

        def rows(cells, separator=",", head=""):
            return head + "\n".join(separator.join(row) for row in cells) + "\n"

        g, t, units = table(rows(plain))
        self.assertEqual(units, ["h", "mm"])
        self.assertAlmostEqual(np.trapezoid(g[0], np.linspace(0, 1, g.shape[1])) if hasattr(np, "trapezoid") else np.trapz(
            g[0], np.linspace(0, 1, g.shape[1])), 20, places=2)
        minutes = [[d, f"{float(r) / 60:.12g}"] for d, r in plain]
        centimetres = [[f"{float(d) / 10:g}", r] for d, r in percent]
        for text in (rows(plain, ";", "distance (mm);rate (1/h)\n"), rows(plain, "\t", "distance\trate\n"),
                     rows(percent, ",", "distance (mm),rate (%/h)\n"), rows(percent, ",", "d [mm],REGR [% h-1]\n"),
                     rows(percent, ",", "Root 5\nDistance from tip,REGR\nmm,percent per hour\n"), rows(minutes, ",", "distance (mm),rate (min^-1)\n"),
                     rows(centimetres, ",", "distance (cm),rate (%/h)\n"), rows(percent, ";", "Abstand (mm);Dehnung (%/h)\n").replace(".", ","),
                     rows(plain, ";", "distance;rate\n").replace(".", ","), rows(plain, ",", '"distance","rate"\n') + '"* of 5 roots, by hand"\n',
                     rows(plain, ",", "distance,rate\n").encode("utf-16")):
            again = table(text)
            self.assertIsInstance(again, tuple, f"{text}: {again}")
            np.testing.assert_allclose(again[0], g, rtol=1e-9, err_msg=str(text))
        np.testing.assert_allclose(table(rows(centimetres, ",", "distance (cm),rate (%/h)\n"), "2cm", "720min")[0] * 10, g, rtol=1e-9)
        bare = table(rows(percent, ",", "distance,rate (%)\n"), "20", "12")
        np.testing.assert_allclose(bare[0], g, rtol=1e-9)
        self.assertEqual(bare[2], ["", ""])
        for text, more, words in ((rows(plain, ",", "distance (mm),rate\n"), ("20", "12"), ("is in mm", "--length 20mm")),
                                  (rows(plain, ",", "distance,rate (1/h)\n"), ("20", "12"), ("per h", "--end 5h")),
                                  (rows(plain, ",", "distance (yd),rate\n"), ("20mm", "12h"), ("yd is no unit",)),
                                  (rows(plain, ",", "distance,rate (mm/h)\n"), ("20mm", "12h"), ("mm/h is no unit of a relative rate",)),
                                  (rows([*plain, ["20", ""]]), ("20", "12"), ("line 5", "nothing stands there")),
                                  (rows([*plain, ["7", "1"]], ",", "# a\ndistance,rate\n"), ("20", "12"), ("line 7", "must rise")),
                                  (rows(plain), ("20yd", "12"), ("--length 20yd", "mm")), (rows(plain), ("-2", "12"), ("--length -2",))):
            said = table(text, *more)
            self.assertIsInstance(said, str, text)
            for word in words:
                self.assertIn(word, said)

    def test_options_page(self):
        """docs/options.md is what scripts/lab/options.py makes of this executable."""
        done = subprocess.run([sys.executable, str(SCRIPTS / "lab" / "options.py"), TENDRIL],
                              capture_output=True, text=True)
        page = (SCRIPTS.parent / "docs" / "options.md").read_text()
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertGreater(page.count("| -"), 40)
        self.assertEqual(done.stdout, page, "redraw it: scripts/lab/options.py TENDRIL > docs/options.md")

    def test_animate(self):
        film = self.file.parent / "film.gif"
        result, _, err = quietly("animate", [self.file, "--output", film, "--frames", "3"])
        self.assertEqual((result, err), (0, ""))
        self.assertGreater(film.stat().st_size, 5000)


if __name__ == "__main__":
    TENDRIL = str(Path(sys.argv.pop(1)).resolve())
    unittest.main()

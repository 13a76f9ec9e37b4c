#!/usr/bin/env python3
# test: data are read, traced and reckoned with | with Reading Residuals Viewed Intervals Tracing Bars
# test: rods are fitted to data | with Fitting
"""Fitting: what was measured is read as it is meant, residuals are distances, intervals hold what they
say, a hidden truth is found again.

    test_fit.py build/tendril"""

import contextlib
import html
import io
import json
import os
import re
import subprocess
import sys
import tempfile
import unittest
from dataclasses import replace
from importlib.util import find_spec
from pathlib import Path
from threading import Thread
from unittest import mock

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "support"))
from chromium import FOUND as BROWSER
from held import HANG
from interpreter import ROOT, from_venv

os.environ.setdefault("OMP_NUM_THREADS", "1")  # matrices are small: threads of BLAS would only wait
sys.path.insert(0, str(ROOT / "scripts"))
try:
    import numpy as np

    import tendril
    import tendril.__main__ as commands
    from tendril import (comparing, doubts, filming, fit_command, fitting, laws, measured, naming, noise, problem, progress,
                         secants, tracing)
    from tendril.parameters import MODE, Parameter, Prior, tied_value
except ImportError as error:
    from_venv(error)

TUBE = dict(growth_type="feed", growth_initial_length="1cm", si_bending_stiffness="2.209Nmm^2",
            si_speed="5mm/s", friction_beta=1e-6, shape_type="straight")
FRICTION, CURVATURE, END = 0.62, 3.7, 28.0  # hidden; N/m, 1/m, s


QUIET = """--headless --no-sandbox --disable-gpu --disable-quic --no-first-run --disable-sync
    --disable-background-networking --disable-component-update --hide-scrollbars""".split()
# What is done in the page of a film; what its CSV then is is left in the element #seen.
ACTIONS = """
const seen = { k: 10 };
window.onerror = message => { seen.error = message; };
const mouse = (target, what, x, y) => target.dispatchEvent(new PointerEvent(what,
  { clientX: x, clientY: y, pointerId: 1, bubbles: true }));
try {
  svg.setPointerCapture = () => {}; // there is no real mouse to hold
  seen.before = csv();
  const box = svg.getBoundingClientRect(), one = box.width / data.frames[0].size[0];
  const dot = svg.querySelector("[data-k='10']").getBoundingClientRect();
  const x = dot.left + dot.width / 2, y = dot.top + dot.height / 2;
  mouse(svg.querySelector("[data-k='10']"), "pointerdown", x, y);
  for (const part of [0.5, 1]) mouse(svg, "pointermove", x, y + part * 50 * one);
  mouse(svg, "pointerup", x, y + 50 * one);
  seen.after = csv();
  const count = data.frames[0].points.length;
  mouse(svg, "pointerdown", box.left + 20, box.top + 20);
  mouse(svg, "pointerup", box.left + 20, box.top + 20);
  seen.added = data.frames[0].points.length - count;
  at("remove").click();
  if (csv() !== seen.after) seen.error = "a point that was added and removed is still there";
  at("on").click();
  at("kept").click();
  seen.less = csv();
} catch (error) { seen.error = String(error); }
const pre = document.createElement("pre");
pre.id = "seen";
pre.textContent = JSON.stringify(seen);
document.body.append(pre);
"""


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
        for text, word in (("t (s),x1 (cm),x2 (cm)\n1,2,three\n", "three.*in the row 1, 2, three$"), ("", "empty"),
                           ("t (s),x1 (cm),x2 (cm)\n", "no row below it"),
                           ("length (cm),x1 (cm),x2 (cm)\n" + 3 * "-3,1,2\n", "length -3; lengths are above 0"),
                           ("t (s),x1 (cm),x2 (cm)\n1,2,3\n", "three points"),
                           ("t (s),x1 (yd),x2 (yd)\n1,2,3\n1,2,3\n1,2,3\n", "yd is no unit"),
                           ("t (s),x1 (cm),x2 (mm)\n1,2,3\n1,2,3\n1,2,3\n", "in one unit"),
                           ("when,width\n1,2\n", "no column t")):
            with self.assertRaisesRegex(measured.DataError, word) as refused:
                measured.read(self.file(text))
            self.assertNotIn("\n", str(refused.exception))
        for bounds in ((2, 1), (1,), ("1N/m", "2N/cm"), "1:2:3", "1:two"):
            with self.assertRaises(tendril.TendrilError):
                Parameter.of("x", bounds)


    def test_other_programs(self):
        """DeepLabCut, Tracker, ImageJ; what is not used is said."""
        m = measured.read(self.file("scorer,n,n,n,n,n,n,n,n,n\nbodyparts,base,base,base,mid,mid,mid,tip,tip,tip\n"
                                    "coords,x,y,likelihood,x,y,likelihood,x,y,likelihood\n"
                                    "0,1,2,0.9,3,4,0.99,5,6,1\n50,1,2,1,3,5,1,6,6,0.9\n"), unit="px", fps=25)
        self.assertEqual([float(p.at.numbers) for p in m.photographs], [0, 2])
        np.testing.assert_array_equal(m.photographs[1].points.numbers, [[1, 2], [3, 5], [6, 6]])
        self.assertTrue(m.photographs[0].ordered)
        self.assertIn("DeepLabCut, 3 body parts", m.notes[0])
        m = measured.read(self.file(",mass A,,,mass B,,,mass C,\nt,x (cm),y (cm),t,x (cm),y (cm),t,x (cm),y (cm)\n"
                                    "0.5,1,2,0.5,3,4,0.5,5,6\n"))
        np.testing.assert_allclose(m.photographs[0].points.numbers, [[0.01, 0.02], [0.03, 0.04], [0.05, 0.06]])
        self.assertEqual((float(m.photographs[0].at.numbers), m.photographs[0].at.unit), (0.5, "l/V"))
        m = measured.read(self.file(" ,Area,X,Y,Slice\n1,0,10,20,1\n2,0,11,21,1\n3,0,12,22,1\n"), unit="px", fps=2)
        self.assertEqual(float(m.photographs[0].at.numbers), 0)
        self.assertTrue(any("not used: Area" in note for note in m.notes), m.notes)
        with self.assertRaisesRegex(measured.DataError, "--fps"):
            measured.read(self.file("frame,x,y\n1,2,3\n1,3,3\n1,4,4\n"))

    def test_rates_of_frames(self):
        """--fps takes frames per second, or per another time, as a series of photographs has them."""
        from argparse import ArgumentTypeError
        from tendril.command import per_second
        for word, rate in (("25", 25), ("6/h", 1 / 600), ("1/10min", 1 / 600), ("1/3600", 1 / 3600), ("30000/1001", 30000 / 1001)):
            self.assertAlmostEqual(per_second(word) / rate, 1, 12)
        for word in ("x", "1/0", "6/kg", "/h", "1/h/h", ""):
            self.assertRaisesRegex(ArgumentTypeError, "is no rate", per_second, word)
        m = measured.read(self.file(" ,X,Y,Slice\n1,10,20,1\n2,11,21,7\n3,12,22,7\n4,13,22,7\n"), unit="px", fps=per_second("6/h"))
        self.assertAlmostEqual(float(m.photographs[-1].at.numbers), 3600, 6)

    def test_which_frame_and_which_rod(self):
        """ImageJ writes Slice and Frame, of which one is 1 in all rows, and counts from 1; pictures that were labelled for
        DeepLabCut have their number in their name; of two animals none is the rod; where the last body part, or track,
        is not there, the last that is there is not the tip."""
        for head, at in (("Ch,Slice,Frame", "{0},1"), ("Ch,Frame,Slice", "{0},1")):
            body = "".join(f"{k},0,{k},{2 * k},1,{at.format(1 + k // 3)},0\n" for k in range(6))
            m = measured.read(self.file(f" ,Area,X,Y,{head},Count\n{body}"), unit="px", fps=2)
            self.assertEqual([float(p.at.numbers) for p in m.photographs], [0, 0.5], head)
        with self.assertRaisesRegex(measured.DataError, "frames and slices"):
            measured.read(self.file("X,Y,Slice,Frame\n1,2,1,1\n1,3,2,2\n"), unit="px", fps=2)
        parts = "bodyparts{0},base,base,mid,mid,tip,tip\ncoords{0},x,y,x,y,x,y\n"
        for index, name in (("", "labeled-data\\film2\\img050.png"), (",,", "labeled-data,film2,img050.png")):
            text = f"scorer{index},n,n,n,n,n,n\n{parts.format(index)}{name},1,2,3,4,5,6\n"
            (p,) = measured.read(self.file(text), unit="px", fps=25).photographs
            self.assertEqual(float(p.at.numbers), 2)
            np.testing.assert_array_equal(p.points.numbers, [[1, 2], [3, 4], [5, 6]])
        for animals, refused in (("a,a,a,a,a,a", False), ("a,a,a,a,b,b", True)):
            file = self.file(f"scorer,n,n,n,n,n,n\nindividuals,{animals}\n{parts.format('')}7,1,2,3,4,5,6\n")
            if refused:
                self.assertRaisesRegex(measured.DataError, "2 individuals, a, b", measured.read, file, "px", fps=25)
            else:
                self.assertEqual(len(measured.read(file, "px", fps=25).photographs[0].points.numbers), 3)
        m = measured.read(self.file("#multi:\n\tA\t\tB\t\tC\t\tD\t\t\nt\tx\ty\tx\ty\tx\ty\tx\ty\t\n"
                                    "0,1\t1\t2\t3\t4\t5\t6\t\t\t\n0,2\t1\t2\t3\t4\t5\t6\t7\t8\t\n"
                                    "0,3\t1\t2\t\t\t\t\t\t\t\n"), unit="px")
        self.assertEqual([p.ordered for p in m.photographs], [False, True])
        self.assertTrue(any("not used: t = 0.3, of which 1 of 4" in note for note in m.notes), m.notes)

    def test_titles_and_names(self):
        """Words above the headings are told from them; a digitiser's name that is no time; what is no text."""
        m = measured.read(self.file("Monday's tube\nt (s);x1 (cm);x2 (cm)\n1;1;2\n1;2;3\n1;3,5;4\n"))
        np.testing.assert_allclose(m.photographs[0].points.numbers[2], [0.035, 0.04])
        self.assertTrue(any("not used: Monday's tube" in note for note in m.notes), m.notes)
        file = self.file("Default Dataset,\nX,Y\n1,2\n3,4\n5,6\n")
        self.assertEqual(float(measured.read(file, unit="cm", at="20s").photographs[0].at.numbers), 20)
        self.assertRaisesRegex(measured.DataError, '"Default Dataset" says no time.*20s@FILE', measured.read, file, "cm")
        (Path(self.directory.name) / "old.xls").write_bytes(b"\xd0\xcf\x11\xe0" + bytes(60))
        self.assertRaisesRegex(measured.DataError, "no text", measured.read, Path(self.directory.name) / "old.xls")

    def test_as_files_come(self):
        """Decimal commas, x and y as headings, Latin-1, UTF-16, blanks, DataFrames, workbooks."""
        expected = [[0.015, 0.02], [0.025, 0.03], [0.035, 0.04]]
        text = "t (s);x (cm);y (cm);Länge\n1,5;1,5;2;a\n1,5;2,5;3;b\n1,5;3,5;4;c\n"
        for name, raw in (("l.csv", text.encode("latin-1")), ("u.csv", text.encode("utf-16")),
                          ("8.csv", text.encode("utf-8-sig"))):
            (Path(self.directory.name) / name).write_bytes(raw)
            m = measured.read(Path(self.directory.name) / name)
            np.testing.assert_allclose(m.photographs[0].points.numbers, expected)
            self.assertEqual(float(m.photographs[0].at.numbers), 1.5)
            self.assertTrue(any("not used: Länge" in note for note in m.notes), m.notes)
        m = measured.read(self.file("1.5 2\n2.5 3\n3.5 4\n"), unit="cm", at="2s")
        np.testing.assert_allclose(m.photographs[0].points.numbers, expected)
        import pandas
        frame = pandas.DataFrame({"t (s)": 1.5, "x1 (cm)": [1.5, 2.5, 3.5], "x2 (cm)": [2, 3, 4]})
        np.testing.assert_allclose(measured.gather(frame).photographs[0].points.numbers, expected)
        if find_spec("openpyxl"):
            frame.to_excel(Path(self.directory.name) / "a.xlsx", index=False)
            m = measured.read(Path(self.directory.name) / "a.xlsx")
            np.testing.assert_allclose(m.photographs[0].points.numbers, expected)

    def test_nothing_is_dropped_in_silence(self):
        """A second sheet, a length beside a time, columns of one name, an index; a title over t, x, y is no track; commas of
        thousands are not decimal ones."""
        rows = "1,5;1,5;2\n1,5;2,5;3\n1,5;3,5;4\n"
        for head in ("my tube\nt;x;y\n", "sep=;\nt (s);x (cm);y (cm)\n", "t/s;x/cm;y/cm\n", "t (s);x1 (\u03bcm);x2 (\u03bcm)\n"):
            (p,) = measured.read(self.file(head + rows), unit="cm").photographs
            self.assertEqual((p.ordered, len(p.points.numbers), float(p.at.numbers)), (False, 3, 1.5), head)
            self.assertAlmostEqual(p.points.numbers[0, 0], 1.5e-6 if "\u03bc" in head else 0.015)
        quoted = self.file('t (s),x1 (cm),x2 (cm)\n"1,5","1,5",2\n"1,5","2,25",3\n"1,5","3,5",4\n')
        np.testing.assert_allclose(measured.read(quoted).photographs[0].points.numbers[1], [0.0225, 0.03])
        grouped = self.file('t (s),x1 (mm),x2 (mm)\n1,"1,234.5",2\n1,1300,3\n1,1400,4\n')  # as paths and rates have them, too
        self.assertAlmostEqual(measured.read(grouped).photographs[0].points.numbers[0, 0], 1.2345)
        for time in ("1.2.3s", "2018-03-08", "5 %"):
            self.assertRaisesRegex(measured.DataError, "is no time and no length", measured.moment, time, "a.csv")
        for text, word in (('t (s),x1 (mm),x2 (mm)\n1,"1,234",2\n1,"1,335",3\n', "of thousands"),
                           ("t (s),x,y,x,y\n1,2,3,4,5\n", "2 columns x1")):
            self.assertRaisesRegex(measured.DataError, word, measured.read, self.file(text))
        m = measured.read(self.file("t (s) length (cm) x1 x2\n1 5 2 3\n1 5 3 3\n1 5 4 4\n"), unit="cm")
        self.assertEqual((float(m.photographs[0].at.numbers), m.photographs[0].at.unit), (1, "l/V"))
        self.assertTrue(any("not used: length" in note for note in m.notes), m.notes)
        import pandas
        frame = pandas.DataFrame({"t (s)": 1.5, "x1 (cm)": [1.5, 2.5, 3.5], "x2 (cm)": [2, 3, 4]})
        (p,) = measured.gather(frame.set_index("t (s)")).photographs
        self.assertEqual(float(p.at.numbers), 1.5)
        if find_spec("openpyxl"):
            path = Path(self.directory.name) / "b.xlsx"
            with pandas.ExcelWriter(path) as book:
                for sheet in ("first", "second"):
                    frame.to_excel(book, sheet_name=sheet, index=False)
            self.assertTrue(any("not used: sheet second" in note for note in measured.read(path).notes))

    def test_headings_in_either_case(self):
        """T is t as Time is, X is x1, Length and L are length; Frame alone is a time by --fps; the units may stand in a row below,
        as TrackMate's do; words behind a bracket are no unit; 3D Slicer's column defined says which points count."""
        rows = "6,0,0\n6,10,1\n6,20,2\n8,0,0\n8,10,2\n8,30,4\n"
        for head in ("T (s),x1 (mm),x2 (mm)", "Time (s),X (mm),Y (mm)", "t/s,X/mm,Y/mm", "TIME [s],X1 [mm],X2 [mm]", "T,X,Y\nsec,Millimeters,mm",
                     "POSITION_T,POSITION_X,POSITION_Y\nT,X,Y\nT,X,Y\n(sec),(mm),(mm)"):
            one, two = measured.read(self.file(f"{head}\n{rows}")).photographs
            self.assertEqual([(p.abscissa, float(p.at.numbers), p.at.unit) for p in (one, two)], [("t", 6, "l/V"), ("t", 8, "l/V")], head)
            np.testing.assert_allclose(two.points.numbers[2], [0.03, 0.004], err_msg=head)
        for head, at in (("Length (mm)", 0.006), ("L [mm]", 0.006), ("LENGTH/mm", 0.006)):
            p = measured.read(self.file(f"{head},x (mm),y (mm)\n{rows}")).photographs[0]
            self.assertEqual((p.abscissa, float(p.at.numbers)), ("length", at))
        both = rows.replace("\n6,", "\n6,1,").replace("\n8,", "\n8,2,").replace("6,0,0", "6,1,0,0", 1)
        m = measured.read(self.file(f"T (s),Frame,X (mm),Y (mm)\n{both}"), fps=10)
        self.assertEqual([float(p.at.numbers) for p in m.photographs], [6, 8])
        self.assertEqual([float(p.at.numbers) for p in measured.read(self.file(f"Frame,X (mm),Y (mm)\n{rows}"), fps=2).photographs], [3, 4])
        m = measured.read(self.file("t (s),x1 (cm),x2 (cm),v (cm)/s\n1,0,0,1\n1,1,0,1\n1,2,0,1\n"))
        self.assertEqual(len(m.photographs[0].points.numbers), 3)
        self.assertTrue(any("not used: v (cm)/s" in note for note in m.notes), m.notes)
        m = measured.read(self.file("T (s),X (in),Y (ft),defined\n1,0,0,1\n1,1,0,1\n1,2,0,1\n1,9,9,0\n".replace("(ft)", "(in)")))
        np.testing.assert_allclose(m.photographs[0].points.numbers[-1], [0.0508, 0])
        self.assertEqual([c.name for c in measured.read(self.file("Time (s),Width (cm)\n1,2\n2,3\n")).curves], ["width"])

    def test_lines_of_the_file(self):
        """Rows are counted as the file has them, below comments, titles and empty lines."""
        for text, line in (("# by hand\n\nt (s),x1 (cm),x2 (cm)\n1,2,3\n1,two,3\n", 5), ("a title\nt;x1;x2\n1;2;3\n\n1;2;drei\n", 5)):
            self.assertRaisesRegex(measured.DataError, f"line {line}: .* is no number", measured.read, self.file(text), "cm")
        for text in ("bodyparts,a,a\ncoords,x\n0,1,2\n", "bodyparts,a,a,a\ncoords,x,y,likelihood\n0,1,2,high\n", "20s,,12cm,\nX,Y,X,Y\n",
                     "scorer\nbodyparts\ncoords\n"):
            self.assertRaises(measured.DataError, measured.read, self.file(text), "cm", fps=25)

    def test_sleap(self):
        """Its analysis CSV, as sleap-convert writes it, and its .h5; of two tracks none is the rod."""
        head = "track,frame_idx,instance.score,base.x,base.y,base.score,mid.x,mid.y,mid.score,tip.x,tip.y,tip.score\n"
        file = self.file(head + ",0,0.9,1,2,0.9,3,4,0.8,5,6,0.9\n,50,0.9,1,2,0.9,3,5,0.9,6,6,0.1\n,75,0.9,1,2,0.9,3,5,0.9,,,\n"
                         ",100,0.9,1,2,0.9,3,5,0.9,7,7,0.9\n")
        m = measured.read(file, fps=25)
        self.assertEqual([(float(p.at.numbers), p.ordered) for p in m.photographs], [(0, True), (4, True)])
        np.testing.assert_array_equal(m.photographs[1].points.numbers, [[1, 2], [3, 5], [7, 7]])
        self.assertEqual(m.photographs[0].points.unit, measured.PIXEL)
        self.assertTrue(any("SLEAP, 3 nodes as points from the clamp to the tip, base to tip" in note for note in m.notes), m.notes)
        self.assertRaisesRegex(measured.DataError, "--fps", measured.read, file)
        two = self.file(head + "a,0,0.9,1,2,0.9,3,4,0.8,5,6,0.9\nb,0,0.9,1,2,0.9,3,5,0.9,6,6,0.1\n")
        self.assertRaisesRegex(measured.DataError, "2 tracks, a, b; leave", measured.read, two, fps=25)
        import h5py
        path = Path(self.directory.name) / "a.h5"
        with h5py.File(path, "w") as f:
            f["node_names"] = [b"base", b"mid", b"tip"]
            f["tracks"] = np.moveaxis([[[[1, 2], [3, 4], [5, 6]], [[1, 2], [3, 5], [6, np.nan]], [[1, 2], [3, 5], [7, 7]]]], 1, 3
                                      ).transpose(0, 2, 1, 3)
        m = measured.read(path, fps=2)
        self.assertEqual([float(p.at.numbers) for p in m.photographs], [0, 1])
        np.testing.assert_array_equal(m.photographs[1].points.numbers, [[1, 2], [3, 5], [7, 7]])

    def test_root_systems(self):
        """SmartRoot's nodes and RSML, in a unit from the root's base, upwards; laterals are left out and said, of two roots
        that hang on none neither is the rod; names of the images are times."""
        head = "image, root, root_name, x, y, theta, diameter, distance_from_base, distance_from_apex, root_order, root_ontology\n"
        nodes = "".join(f"g{image}.tif, k1, root_1, {5 + s}, {2 - 0.1 * s * s}, 0, 0.1, {s}, {3 - s}, 0, PO:1\n"
                        for image in ("-2h", "-30min") for s in (3, 0, 1, 2))
        lateral = "g-2h.tif, k2, lat_1, 9, 9, 0, 0.1, 0, 1, 1, PO:2\n"
        m = measured.read(self.file(head + nodes + lateral))
        self.assertEqual([float(p.at.numbers) for p in m.photographs], [1800, 7200])
        np.testing.assert_allclose(m.photographs[0].points.numbers, [[0, 0], [0.01, 0.001], [0.02, 0.004], [0.03, 0.009]], atol=1e-12)
        self.assertTrue(any("not used: 1 nodes of roots that hang" in note for note in m.notes), m.notes)
        other = self.file(head + nodes + nodes.replace("root_1", "root_2"))
        self.assertRaisesRegex(measured.DataError, "2 roots that hang on no other, root_1, root_2", measured.read, other)
        text = """<?xml version="1.0"?><rsml><metadata><unit>{unit}</unit><resolution>{size}</resolution>
            <image><name>/a/{name}</name></image></metadata><scene><plant><root id="1" label="A"><geometry><polyline>
            <point x="100" y="50"/><point x="200" y="50"/><point x="354" y="177"/></polyline></geometry>
            <root id="2"><geometry><polyline><point x="1" y="1"/></polyline></geometry></root></root>{more}</plant></scene></rsml>"""
        file = self.file(text.format(unit="inch", size=254, name="g-20s.png", more=""), "a.rsml")
        (p,) = measured.gather([file]).photographs
        self.assertEqual((float(p.at.numbers), p.ordered, p.points.unit), (20, True, "l"))
        np.testing.assert_allclose(p.points.numbers, [[0, 0], [0.01, 0], [0.0254, -0.0127]], atol=1e-12)
        (p,) = measured.read(self.file(text.format(unit="pixel", size=1, name="g.png", more=""), "a.rsml")).photographs
        np.testing.assert_array_equal((p.abscissa, p.points.unit, *p.points.numbers[2]), (None, measured.PIXEL, 354, 177))
        second = '<root label="B"/>'
        for broken, word in ((text.format(unit="cm", size=1, name="a", more=second), "2 roots that hang on no other, A, B"),
                             (text.format(unit="ell", size=1, name="a", more=""), "ell is no unit"),
                             ("<rsml>", "no RSML"), ("<rsml/>", "no RSML that has a root")):
            self.assertRaisesRegex(measured.DataError, word, measured.read, self.file(broken, "b.rsml"))

    def test_names_that_are_times(self):
        """Of pictures in a table, of files, of photographs to be measured: with a unit, as a date, as a number of frames;
        where one says its time itself names are not asked."""
        for name, seconds in (("root-20s.png", 20), ("a/2.5h.csv", 9000), ("t=3min_1.tif", 180), ("IMG_0050.png", None),
                              ("12cm.png", None), ("b2s.png", None)):
            self.assertEqual(naming.told_time(name), seconds, name)
        times = naming.times_of(["2018-03-08_1000.jpg", "2018-03-08_1130.jpg", "2018-03-09_1000.jpg"])[0]
        self.assertEqual(times, [0, 5400, 86400])
        self.assertEqual(naming.times_of(["img_0010.png", "img_0020.png"], 5)[0], [2, 4])
        self.assertRegex(naming.times_of(["img_0010.png", "img_0020.png"])[1], "give --fps")
        rows = "".join(f"img-{k}s.png,{x},{x}\n" for k in (5, 9) for x in (1, 2, 3))
        m = measured.read(self.file("image,x,y\n" + rows), unit="cm")
        self.assertEqual([float(p.at.numbers) for p in m.photographs], [5, 9])
        m = measured.read(self.file("label,x,y\n1,1,1\n2,2,2\n3,3,3\n"), unit="cm", fps=2)  # of points, not of pictures
        self.assertEqual([p.abscissa for p in m.photographs], [None])
        files = [self.file("1 2\n2 3\n3 4\n", f"at-{k}min.csv") for k in (1, 2)]
        self.assertEqual([float(p.at.numbers) for p in measured.gather(files, "cm").photographs], [60, 120])
        self.assertEqual([float(p.at.numbers) for p in fit_command.measured(map(str, files), "cm").photographs], [60, 120])
        told = measured.gather([*files, self.file("t (s),x1,x2\n7,1,2\n7,2,3\n7,3,5\n")], "cm").photographs
        self.assertEqual([p.abscissa for p in told], [None, None, "t"])
        self.assertEqual([at for at, *_ in filming.told_of(["a-1s.png", "a-3s.png"], None)[0]], [1, 3])
        self.assertEqual([length for _, length, _ in filming.told_of(["5cm@a-1s.png", "a-3s.png"], None)[0]], ["5cm", ""])

    def test_points_of_another_kind(self):
        """Three columns, none, words, what is no data at all: a line that says what is wanted."""
        for points in (np.zeros((5, 3)), np.zeros(5), [["a", "b"]] * 3, [[1, 2], [3]], None, {}):
            with self.assertRaisesRegex(measured.DataError, r"photograph at 3cm: give points \[m, 2\], x1 and x2"):
                measured.gather({"3cm": points})
        for data in (3, None, [], [1, 2], b"a.csv", {}):
            self.assertRaisesRegex(measured.DataError, "^data: ", measured.gather, data)
        import pandas
        frame = pandas.DataFrame({"x1 (cm)": [1.5, 2.5, 3.5], "x2 (cm)": [2, 3, 4]})
        self.assertEqual(float(measured.gather({"3cm": frame}).photographs[0].at.numbers), 0.03)

    def test_unsure_points(self):
        """They are left out; where the last of a line is one, the tip was not seen."""
        m = measured.read(self.file("t (s),x1,x2,point,unsure\n" + "".join(
            f"{t},{k},0,{k},{int(k == odd)}\n" for t, odd in ((1, 2), (2, 4)) for k in range(5))), unit="cm")
        self.assertEqual([len(p.points.numbers) for p in m.photographs], [4, 4])
        self.assertEqual([p.ordered for p in m.photographs], [True, False])
        rows = [f"{t},{k},0,{k},{int(t == 1 and k > 1)}\n" for t in (1, 2) for k in range(5)]
        m = measured.read(self.file("t (s),x1,x2,point,unsure\n" + "".join(rows)), unit="cm")
        self.assertEqual([float(p.at.numbers) for p in m.photographs], [2])
        self.assertTrue(any("not used: t = 1, of which 2 of 5 points are sure" in note for note in m.notes), m.notes)
        with self.assertRaisesRegex(measured.DataError, "no photograph has three points that are sure"):
            measured.read(self.file("t (s),x1,x2,point,unsure\n" + "".join(rows[:5])), unit="cm")

    def test_what_is_known(self):
        """Priors and ties, and what is wrong with them."""
        prior = Prior.of("a", "2N/m:0.1N/m")
        self.assertEqual((prior.mean, prior.deviation, prior.unit), (2, 0.1, "N/m"))
        self.assertEqual(Parameter.of("a", prior.bounds()).start, 2)
        self.assertEqual(tied_value("b", "0.5*a**2 N/m", {"a": "4N/m"}), "8.0N/m")
        for text in ("a+c", "__import__('os')", "a b c", "1/0"):
            with self.assertRaises(tendril.TendrilError) as refused:
                tied_value("b", text, {"a": "4N/m"})
            self.assertNotIn("\n", str(refused.exception))
        with self.assertRaises(tendril.TendrilError):
            Prior.of("a", "2N/m:-1N/m")

    def test_ties_of_the_manual(self):
        """What docs and help give as an example of a tie is an option that the program takes."""
        for file in ("docs/fitting.md", "scripts/tendril/fit_command.py", "scripts/tendril/fitting.py"):
            found = re.search(r"(si_friction_viscous)[\"=: ]+([^\"`]+)", (ROOT / file).read_text())
            option = tied_value(*found.groups(), {"si_friction_dry": "0.7N/m"})
            done = subprocess.run([os.environ["TENDRIL"], *("-task units -si_bending_stiffness 2e-6 -si_friction_dry 0.7N/m "
                                   f"-si_speed 5mm/s -si_friction_viscous {option}").split()], capture_output=True, text=True)
            self.assertEqual(done.returncode, 0, f"{file}: {found[0]}: {done.stderr}")


@unittest.skipUnless(find_spec("cv2") and find_spec("skimage"), "OpenCV and scikit-image are not there")
class Tracing(unittest.TestCase):
    def picture(self, line, width=14, seed=1):
        """A dark body on a ground with light that falls off, noise, and a block that is thick as a hand."""
        import cv2
        random = np.random.default_rng(seed)
        x, y = np.meshgrid(np.linspace(0, 1, 800), np.linspace(0, 1, 600))
        picture = np.full((600, 800), 200.0)
        cv2.polylines(picture, [np.round(16 * line).astype(np.int32)], False, 70.0, width, cv2.LINE_AA, 4)
        picture[230:420, 0:60] = 120
        picture = cv2.GaussianBlur(picture, (0, 0), 1.2) * (1 - 0.3 * x - 0.2 * y) + 3 * random.normal(size=x.shape)
        return np.clip(picture, 0, 255).astype(np.uint8)

    def test_a_loop_that_is_crossed_slantwise(self):
        """Is gone round: the arc from the clamp to the tip without it is as smooth."""
        s = np.linspace(0, 1, 400)
        line = np.column_stack([190 + 175 * np.sin(2.3 * np.pi * s) + 150 * s, 435 - 162 * np.cos(2.3 * np.pi * s)])
        found = tracing.trace(self.picture(line, width=11), line[0])
        self.assertAlmostEqual(found.length, np.hypot(*np.diff(line, axis=0).T).sum(), delta=25)
        self.assertTrue(found.whole and found.unsure.any())

    def test_a_line(self):
        """To a part of a pixel, with its width and its end."""
        s = np.linspace(0, 1, 300)
        line = np.column_stack([80 + 600 * s, 300 + 120 * np.sin(5 * s)])
        found = tracing.trace(self.picture(line), line[0])
        off, _ = comparing.distances(found.points[2:-3], line)
        self.assertLess(np.sqrt(np.mean(off**2)), 0.4)
        self.assertAlmostEqual(found.width, 15, delta=1.5)
        self.assertLess(np.hypot(*(found.points[-1] - line[-1])), 14)
        self.assertTrue(found.whole)
        self.assertEqual(found.unsure.sum(), 0)

    def test_a_crossing(self):
        """The path goes straight on; there it is unsure."""
        a = np.linspace(-0.9 * np.pi, 1.1 * np.pi, 600)
        line = np.column_stack([260 + 60 * a - 120 * np.sin(a), 300 + 120 * np.cos(a)])
        found = tracing.trace(self.picture(line, width=10), line[0])
        length = np.sum(np.hypot(*np.diff(line, axis=0).T))
        self.assertAlmostEqual(found.length / length, 1, delta=0.03)
        self.assertGreater(found.unsure.sum(), 0)
        off, _ = comparing.distances(found.points[~found.unsure], line)
        self.assertLess(np.quantile(np.abs(off), 0.9), 1.5)

    def staged(self, lens=False, ground="plain"):
        """How far, in mm, points are from a tube of 2.5 mm that was filmed with ruler, hand, board and tilt: by
        the board, with clicks in the picture as it was taken; and the same if the lens is left alone."""
        sys.path.insert(0, str(ROOT / "scripts/lab"))
        import film
        import imageio.v2 as imageio

        with mock.patch.object(film, "SIZE", [960, 540]), tempfile.TemporaryDirectory(prefix="tendril-") as place:
            s = np.linspace(0, 1, 400)
            line = np.column_stack([0.12 * s, 0.015 * np.sin(6 * s) * s])
            stage = film.Stage(4, np.array([0.06, 0.0]), 0.22, gravel=ground == "textured", lens=lens)
            boards = [Path(place) / f"{k}.png" for k in range(7)]
            for path, picture in zip(boards, [stage.finished(stage.board), *(stage.boards() if lens else [])]):
                imageio.imwrite(path, picture)
            clamp, along = (film.bent if lens else np.array)(stage.view(np.array([[0, 0], [0.05, 0]])))
            off = []
            for lenses in ([boards[1:], []] if lens else [[]]):
                m = tendril.measure(stage.frame(line, 2.5e-3, 0.0), clamp=clamp, along=along, lens=lenses, ground=ground,
                                    checkerboard=(*film.BOARD, f"{film.SQUARE}m"), board_picture=boards[0], pages=False)
                points = m.scale.plane(m.frames[0].line.points)
                gap, _ = comparing.distances(points[(points[:, 0] > 0.015) & (points[:, 0] < 0.11)], line)
                off.append(1e3 * float(np.sqrt(np.mean(gap**2))))
        return off

    @unittest.skipUnless(find_spec("cv2") and find_spec("imageio"), "OpenCV is not there")
    def test_through_a_lens(self):
        """That bends the picture by tens of pixels: straightened, clicks too."""
        with_lens, without = self.staged(lens=True)
        self.assertLess(with_lens, 0.5)
        self.assertGreater(without, 4 * with_lens)

    @unittest.skipUnless(find_spec("cv2") and find_spec("skimage"), "OpenCV is not there")
    def test_on_gravel(self):
        """A ground that is as dark as the rod in places: by the ridge filter."""
        self.assertLess(self.staged(ground="textured")[0], 0.15)

    def test_film(self):
        """Photographs with a scale become points in centimetres that fit reads, and a page."""
        s = np.linspace(0, 1, 200)
        pictures = [self.picture(np.column_stack([80 + r * s, 300 + 0 * s]), seed=k) for k, r in enumerate((300, 450, 600))]
        m = tendril.measure(pictures, clamp=(80, 300), scale=((0, 0), (100, 0), "1cm"))
        self.assertEqual(len(m.good()), 3)
        last = m.measured().photographs[-1].points.numbers
        self.assertAlmostEqual(float(m.table().length[2]), 0.06, delta=0.001)
        self.assertLess(np.abs(last[:, 1]).max(), 1e-4)
        self.assertIn('"picture": "/9j/', m.page())

    def test_what_a_board_leaves_unknown(self):
        """Of cameras whose boards' corners are off by parts of a pixel: how far the plane is then tilted and strained is
        what is told, which allows for corners that err alike."""
        random, board = np.random.default_rng(3), (9, 6, "0.8cm")
        view = np.array([[5200.0, 150, 300], [-80, -5100, 650], [0.4, -0.3, 1]])  # metres in the plane to pixels

        def seen(points):
            whole = np.column_stack([points, np.ones(len(points))]) @ view.T
            return whole[:, :2] / whole[:, 2:]

        corners = seen(np.array([[0.02 + 8e-3 * c, -0.06 + 8e-3 * (5 - r)] for r in range(6) for c in range(9)]))
        clamp, along = seen(np.array([[0, 0], [0.05, 0]]))
        off = []
        for _ in range(40):
            noisy = corners + 0.1 * random.normal(size=corners.shape)
            scale = filming.Scale(clamp, along, filming.of_board(noisy, board), "m")
            plane = np.eye(3)
            plane[:2, :2], plane[:2, 2] = scale.turn, scale.origin
            other = np.linalg.inv(plane) @ scale.homography @ view
            told = scale.doubts(noisy, board, draws=60)
            off.append([other[2, 0] / other[2, 2] / told["camera_tilt_1"], other[2, 1] / other[2, 2] / told["camera_tilt_2"]])
        size = np.sqrt(np.mean(np.square(off), axis=0)) * filming.BOARD_ALIKE
        self.assertTrue(np.all((size > 0.7) & (size < 1.4)), size)
        priors = filming.Filmed([], scale, 25.0, doubts=told).priors()
        self.assertEqual(priors["camera_tilt_1"], f"0/m:{told['camera_tilt_1']:.3g}/m")
        self.assertGreater(Prior.of("camera_tilt_1", priors["camera_tilt_1"]).deviation, 0)

    def test_lengths_and_none(self):
        """Photographs of which some have a length: the others have neither that nor a time."""
        def frame(**more):
            return filming.Frame("a", np.nan, line=line, **more)
        line = tracing.Traced(points=np.array([[0, 0], [5, 0], [9.0, 0]]), unsure=np.zeros(3, bool), width=1.0, error=0.1,
                              whole=True)
        many = filming.Filmed([frame(length="12mm"), frame(length="")], filming.Scale((0, 0), (1, 0), np.eye(3), ""), 0)
        self.assertEqual([row.split(",")[0] for row in many.text().splitlines()], ["length (cm)"] + 3 * ["1.2"] + 3 * [""])

    @unittest.skipUnless(BROWSER, "Chromium is not there")
    def test_page(self):
        """As a user would: a point is dragged, one added and taken away, a frame dropped; the CSV is that."""
        s = np.linspace(0, 1, 200)
        m = tendril.measure([self.picture(np.column_stack([80 + r * s, 300 + 0 * s])) for r in (300, 450)],
                            clamp=(80, 300), scale=((0, 0), (100, 0), "1cm"))
        m.frames[0].line.unsure[:] = True
        for f, t in zip(m.frames, (1, 2)):
            f.at = t
        with tempfile.TemporaryDirectory(prefix="tendril-") as place:
            page = Path(place) / "page.html"
            page.write_text(m.page().replace("</body>", f"<script>{ACTIONS}</script></body>"))
            done = subprocess.run([BROWSER, *QUIET, f"--user-data-dir={place}/user", "--window-size=1000,900",
                                   "--virtual-time-budget=20000", "--dump-dom", page.as_uri()], capture_output=True,
                                  text=True, timeout=HANG)
        said = re.search(r'(?s)<pre id="seen">(.*?)</pre>', done.stdout)
        self.assertTrue(said, done.stderr[-500:])
        seen = json.loads(html.unescape(said[1]))
        self.assertNotIn("error", seen)
        before, after, less = (np.genfromtxt(seen[k].splitlines()[1:], delimiter=",") for k in ("before", "after", "less"))
        self.assertEqual(seen["before"].splitlines()[0], "t (s),x1 (cm),x2 (cm),point,unsure")
        moved = np.flatnonzero(np.any(before != after, axis=1))
        self.assertEqual(list(moved), [seen["k"]])
        np.testing.assert_allclose(after[moved[0], 1:3] - before[moved[0], 1:3], [0, -0.5], atol=0.02)  # 50 px down
        self.assertEqual((before[moved[0], 4], after[moved[0], 4]), (1, 0))
        self.assertEqual(seen["added"], 1)
        self.assertEqual(set(less[:, 0]), {1})
        self.assertTrue(measured.read(self.written(seen["after"])).photographs)

    def written(self, text):
        place = tempfile.TemporaryDirectory(prefix="tendril-")
        self.addCleanup(place.cleanup)
        path = Path(place.name) / "page.csv"
        path.write_text(text)
        return path

    def test_refused(self):
        for words, word in (((np.full((200, 300), 200, np.uint8),), "nothing|no line"), (("none.mp4",), "no such file"),
                            (("12apples@a.png",), "no time and no length")):
            with self.assertRaisesRegex(tendril.TendrilError, word):
                tendril.measure([*words], clamp=(10, 10))

    def test_lengths_in_a_unit_that_is_none(self):
        """A line that lists the units."""
        body = self.picture(np.array([[80.0, 300], [600, 300]]))
        for scale in (((1, 1), (101, 1), "1furlong"), ((1, 1), (101, 1), "1N")):
            with self.assertRaisesRegex(tendril.TendrilError, r"scale: .*(no unit; give a length in m, cm, mm|no length)"):
                tendril.measure(body, clamp=(80, 300), scale=scale)
        self.assertRaisesRegex(tendril.TendrilError, "3furlong is no time", tendril.measure, "3furlong@a.png", clamp=(80, 300))

    def test_which_way(self):
        """Of a body on both sides of the clamp the part along x1 is taken, though it is the shorter one; where all of it
        is on the other side that is said, and the line not used."""
        body = self.picture(np.array([[400.0, 40], [400, 300], [440, 500]]))
        m = tendril.measure(body, clamp=(400, 300), along=(400, 400), scale=((0, 0), (100, 0), "1cm"), pages=False)
        points = m.scale.plane(m.good()[0].line.points)
        self.assertTrue(np.all(points[2:, 0] > 0), points)
        self.assertAlmostEqual(float(m.table().length[0]), 0.0204, delta=0.001)
        for more, used in ((dict(along=(400, 200)), False), (dict(along=(400, 0), scale=((0, 0), (100, 0), "1cm")), False),
                           (dict(), True)):  # of pixels alone fit finds the turn
            m = tendril.measure(body, clamp=(442, 505), pages=False, **{"scale": None} | more | (
                dict(along=(442, 600)) if not used else {}))
            self.assertEqual([bool(m.good()), m.frames[0].trouble], [used, "" if used else "the line goes away from --along, against x1"])

    def test_lines_that_are_too_short(self):
        """A stub of a few widths is no rod, but of a film whose lines grow from it; nor is a line that is much shorter than
        the photograph is told to be."""
        def film(lengths, times):
            bodies = [self.picture(np.array([[80.0, 300], [80.0 + r, 300]])) for r in lengths]
            frames = [filming.Frame("a", t, "", tracing.trace(b, (80, 300))) for b, t in zip(bodies, times)]
            filming.compared(frames, [])
            return [f.trouble for f in frames]

        self.assertRegex(film([45], [np.nan])[0], "px long, [0-9.]+ of its widths: that is no rod")
        self.assertEqual(film([45, 70, 100], [0, 1, 2]), ["", "", ""])
        self.assertEqual([bool(told) for told in film([45, 300], [0, 1])], [True, False])
        with tempfile.TemporaryDirectory(prefix="tendril-") as place:
            import imageio.v3 as imageio
            imageio.imwrite(Path(place) / "a.png", self.picture(np.array([[80.0, 300], [380, 300]])))
            for told, used in (("3cm", True), ("10cm", False)):
                m = tendril.measure(f"{told}@{place}/a.png", clamp=(80, 300), scale=((0, 0), (100, 0), "1cm"), pages=False)
                self.assertEqual(bool(m.good()), used)
            self.assertIn("and the body 10cm: it was not followed", m.frames[0].trouble)

    def test_pictures_of_all_kinds(self):
        """TIFF with LZW, as OpenCV and microscopes write it, is what PNG is; a file that no library reads and a stack of
        pictures are refused in a line."""
        import cv2
        import imageio.v3 as imageio
        body = self.picture(np.array([[80.0, 300], [600, 330]]))
        with tempfile.TemporaryDirectory(prefix="tendril-") as place:
            lzw, path = Path(place) / "a.tif", Path(place) / "a.png"
            cv2.imwrite(str(lzw), body, [cv2.IMWRITE_TIFF_COMPRESSION, 5])
            imageio.imwrite(path, body)
            np.testing.assert_array_equal(filming.photograph(lzw), filming.photograph(path))
            lzw.write_bytes(lzw.read_bytes()[:300])
            self.assertRaisesRegex(tendril.TendrilError, "a.tif: no picture that can be read", filming.photograph, lzw)
            cv2.imwrite(str(lzw), 257 * body.astype(np.uint16), [cv2.IMWRITE_TIFF_COMPRESSION, 5])
            np.testing.assert_array_equal(filming.photograph(lzw), body)
            imageio.imwrite(lzw, np.stack([body] * 5), extension=".tif")
            self.assertRaisesRegex(tendril.TendrilError, "is no one picture", filming.photograph, lzw)
        np.testing.assert_array_equal(filming.eight_bits(body / 255.0, "a") // 2, body // 2)
        self.assertRaisesRegex(tendril.TendrilError, "no such file", filming.photograph, "none.png")

    def test_arguments_of_another_kind(self):
        body = np.full((200, 300), 200, np.uint8)
        good = dict(clamp=(10, 10), scale=((0, 0), (100, 0), "1cm"))
        for more, word in ((dict(clamp=None), "clamp: give a point"), (dict(clamp="10,10"), "clamp: give a point"),
                           (dict(clamp=(1, 2, 3)), "clamp: give a point"), (dict(scale="20cm"), "scale: give two points"),
                           (dict(scale=((0, 0), (0, 0), "1cm")), "two points that are apart"), (dict(every=0), "every 0"),
                           (dict(every=1.5), "every 1.5"), (dict(frames=3), "frames: give the first"), (dict(fps="a"), "fps a"),
                           (dict(frames=(5, 2)), "comes after"), (dict(points=2), "points 2"), (dict(width=-1), "width -1"),
                           (dict(checkerboard=(9, 6)), "checkerboard: give inner"), (dict(along=(10, 10)), "along: .*apart"),
                           (dict(lens=3), "lens: give a list"), (dict(source=3), "source: give a film"), (dict(body="red"), "body is")):
            with self.assertRaisesRegex(tendril.TendrilError, word):
                tendril.measure(**{"source": body} | good | more)

    def test_missing_library(self):
        with mock.patch.dict(sys.modules, {"cv2": None}):
            with self.assertRaisesRegex(tendril.TendrilError, r"needs OpenCV: pip install 'tendril\[film\]'"):
                tendril.measure("film.mp4", clamp=(1, 1))


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
            self.assertAlmostEqual(comparing.loose_end(points, line, comparing.spacing(points)), loose)

    def test_ahead_of_the_tip(self):
        """With the least turn of the rod the point ahead of its tip changes sides: what is left of it does not jump. That
        the rod is too short still costs, and all the more so the shorter it is."""
        points = np.column_stack([np.r_[np.linspace(0, 1, 11), 1.08, 1.04], np.zeros(13)])
        gap, found = comparing.spacing(points), []
        for turn in (-1e-6, 1e-6):
            line = np.linspace(0, 1, 200)[:, None] * [np.cos(turn), np.sin(turn)]
            found.append(comparing.nearest(points, line, comparing.SLACK * gap))
            self.assertAlmostEqual(comparing.loose_end(points, line, gap, found[-1].beyond), -0.04)
        np.testing.assert_allclose(found[0].distance, found[1].distance, atol=1e-5)
        short = np.column_stack([np.linspace(0, 0.5, 200), np.zeros(200)])
        near = comparing.nearest(points, short, comparing.SLACK * gap)
        self.assertAlmostEqual(comparing.loose_end(points, short, gap, near.beyond), -comparing.SLACK * gap)
        self.assertAlmostEqual(np.abs(near.distance).max(), 0.58 - comparing.SLACK * gap)

    def test_derivatives_put_right(self):
        """A search by them ends where one does whose derivatives are made at every step, with fewer of them; also where
        they turn so much that steps lead nowhere."""
        t = np.linspace(0, 1, 30)
        bent = (lambda u: np.exp(-u[0] * t) + 1e-3 * u[1] * t - np.exp(-1.5 * t) - 7e-4 * t,
                lambda u: np.column_stack([-t * np.exp(-u[0] * t), 1e-3 * t]))
        banana = (lambda u: np.array([10 * (u[1] - u[0] ** 2), 1 - u[0]]), lambda u: np.array([[-20 * u[0], 10], [-1, 0]]))
        for (function, slope), begin, truth in ((bent, [4.0, 0.0], [1.5, 0.7]), (banana, [-1.2, 1.0], [1, 1])):
            counts = []
            for wanted in (False, True):
                made = mock.Mock(side_effect=slope)
                end, _ = secants.least(function, made, lambda f: 0.5 * f @ f, np.array(begin), wanted=wanted, most=200,
                                       xtol=1e-9, ftol=1e-9)
                np.testing.assert_allclose(end, truth, atol=1e-4)
                counts.append(made.call_count)
            if function is bent[0]:
                self.assertLess(counts[1], counts[0])

    def test_one_place(self):
        """Where it goes down all the way from one end to the other the search had not come to its end; over a rise
        there are two places."""
        def ends(cost, *places):
            toy = mock.Mock(parameters=[None], residuals=lambda u: u[0], cost=cost)
            return fitting.one_place(toy, *(problem.Solution(np.array([x]), cost(x)) for x in places))

        self.assertTrue(ends(lambda x: 10 + 100 * x**2, 0.0, 0.9))
        self.assertTrue(ends(lambda x: 10 + 100 * x**2, 0.9, 0.0))
        wells = lambda x: 10 + 1000 * (x**2 - 0.25) ** 2 + x
        self.assertFalse(ends(wells, -0.5, 0.5))
        self.assertTrue(ends(wells, 0.5, 0.49))

    def test_causes_that_are_alike(self):
        """Are all named, with what each leaves; a clear one is named alone, and one that leaves much not at all."""
        scale, clock, turn = (doubts.End(*end) for end in ((0.515, 1, "a scale"), (0.508, 1, "a clock"), (0.9, 1, "a turn")))

        def named(ends):
            return doubts.causes_named(doubts.most_likely(ends, 0.8))

        self.assertRegex(named([turn, scale, clock]), r"^likeliest causes, .*: a clock \(.* 51 % .*\); or a scale \(.* 52 % .*\)\.$")
        self.assertRegex(named([turn, scale, clock._replace(ratio=0.005)]), r"^likeliest cause: a clock \(.* 0\.5 % .*\)\.$")
        self.assertRegex(named([turn, scale]), r"^likeliest cause: a scale \(.* 52 % .*\)\. .*a law that it leaves out")
        self.assertEqual(named([turn]), "")
        self.assertEqual(named([]), "")
        self.assertEqual(doubts.most_likely([turn._replace(law=True)], 0.6, bad=True), [])
        self.assertIn("a turn", named([turn._replace(law=True)]))  # the residuals ask for it, and numbers make up for it

    def test_places_without_points(self):
        """A rod that runs on beyond its points and back to their end costs; one that is not seen in its
        middle, for nothing was measured there, does not."""
        points = np.column_stack([np.linspace(0, 1, 21), np.zeros(21)])
        there = np.column_stack([np.linspace(0, 1, 100), np.zeros(100)])
        loop = np.column_stack([1 + 0.5 * np.sin(np.linspace(0, 6.28, 100)), 0.5 - 0.5 * np.cos(np.linspace(0, 6.28, 100))])
        gap = 0.75 * comparing.widest_gap(points)
        self.assertEqual(comparing.bare(points, there, gap).max(), 0)
        self.assertEqual(comparing.loose_end(points, np.vstack([there, loop]), comparing.spacing(points)), 0)
        self.assertGreater(np.sum(comparing.bare(points, np.vstack([there, loop]), gap) > 0.1), 8)
        holed = points[(points[:, 0] < 0.3) | (points[:, 0] > 0.7)]
        self.assertEqual(comparing.bare(holed, there, 0.75 * comparing.widest_gap(holed)).max(), 0)

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


class Viewed(unittest.TestCase):
    def test_a_rod_that_stays_straight(self):
        """Of a scene that bends nowhere the friction cannot be seen: that is said, and no fault of the picture looked for."""
        for bend, straight in ((0, True), (0.1, False)):
            r = tendril.run(growth_type="uniform", shape_type="straight", rod_curvature=bend, rod_cells=20, ts_max_time=0.5)
            self.assertEqual(doubts.stays_straight(mock.Mock(run=r)), straight)

    def test_no_line_is_no_success(self):
        """Where no picture has its tip there is nothing to fit: that is said, beside the page that lets one mend it."""
        line = tracing.Traced(points=np.array([[0, 0], [5, 0], [9.0, 0]]), unsure=np.zeros(3, bool), width=1.0, error=0.1,
                              whole=False)
        none = filming.Filmed([filming.Frame("a.png", 1.0, "", line)], filming.Scale((0, 0), (1, 0), np.eye(3), ""), 0)
        with tempfile.TemporaryDirectory(prefix="tendril-") as place, \
                mock.patch.object(filming, "measure", return_value=none), \
                contextlib.redirect_stderr(io.StringIO()) as said, contextlib.redirect_stdout(io.StringIO()) as out:
            self.assertEqual(filming.main(["a.png", "--clamp", "0,0", "--output", f"{place}/none"]), 1)
            self.assertTrue((Path(place) / "none.html").is_file())
        self.assertRegex(said.getvalue(), r"^measure: in none of 1 pictures .* \(a.png: the tip is not seen\), so .*\n$")
        self.assertNotIn("is for scripts/fit.sh", out.getvalue())

    def test_a_tilted_plane(self):
        """The numbers are those of a homography near to one that leaves all as it is."""
        random = np.random.default_rng(2)
        line, view = random.uniform(-1, 1, (20, 2)), {"camera_x": 0.02, "camera_y": -0.01, "camera_turn": 0.03, "camera_scale": 1.02,
                                                      "camera_stretch": 0.004, "camera_shear": -0.006, "camera_tilt_1": 0.02,
                                                      "camera_tilt_2": -0.03}
        c, s = np.cos(0.03), np.sin(0.03)
        whole = np.eye(3)
        whole[:2, :2] = 1.02 * np.array([[c, -s], [s, c]]) @ [[1.002, -0.003], [-0.003, 0.998]]
        whole[2, :2] = 0.02, -0.03
        shown = np.column_stack([line, np.ones(20)]) @ whole.T
        np.testing.assert_allclose(comparing.viewed(line, comparing.VIEW | view), shown[:, :2] / shown[:, 2:] + [0.02, -0.01])
        np.testing.assert_array_equal(comparing.viewed(line), line)


class Intervals(unittest.TestCase):
    """Of a linear model: photographs of points on arcs, two parameters."""

    def points(self, random, kind, photographs=6, count=30):
        """(errors [n], jacobian [n, 2], blocks): of independent points, of those that err smoothly along
        the rod, of photographs that are shifted."""
        error, jacobian, blocks = [], [], []
        for k in range(photographs):
            place = np.sort(random.uniform(0, 1 + 0.2 * k, count))
            normal = np.column_stack([-np.sin(1.5 * place), np.cos(1.5 * place)])
            e = 0.5 * random.normal(size=count)
            if kind == "smooth":
                kernel = noise.matern(np.abs(place[:, None] - place) / 0.1)[0] + 1e-9 * np.eye(count)
                e = 0.2 * e + np.sum((np.linalg.cholesky(kernel) @ random.normal(size=(count, 2))) * normal, axis=1)
            if kind == "parts":  # of the rod's length, and more smoothly
                kernel = noise.gauss(np.abs(place[:, None] - place) / (0.1 * np.ptp(place)))[0] + 1e-9 * np.eye(count)
                e = 0.2 * e + np.sum((np.linalg.cholesky(kernel) @ random.normal(size=(count, 2))) * normal, axis=1)
            if kind == "shifted":
                e = e + normal @ random.normal(size=2)
            if kind == "strays":
                e = e + 20 * (random.random(count) < 0.05) * random.normal(size=count)
            jacobian.append(10 * np.column_stack([place**2, np.sin(2 * place)]))
            blocks.append(noise.Block("lines", np.arange(k * count, (k + 1) * count), place, normal,
                                      np.full(count, np.inf)))
            error.append(e)
        return np.concatenate(error), np.vstack(jacobian), blocks

    def scatter(self, kind, jacobian, blocks):
        """[2], the standard deviation of the best estimate there is, by one who knows how points() err."""
        information = np.zeros((2, 2))
        for b in blocks:
            own, gaps, alike = 0.5, np.abs(b.place[:, None] - b.place), b.normal @ b.normal.T
            v = {"smooth": lambda: noise.matern(gaps / 0.1)[0] * alike, "shifted": lambda: alike,
                 "parts": lambda: noise.gauss(gaps / (0.1 * b.extent))[0] * alike}.get(kind, lambda: 0)()
            own *= 0.2 if kind in ("smooth", "parts") else 1
            information += jacobian[b.rows].T @ np.linalg.solve(v + own**2 * np.eye(len(b.rows)), jacobian[b.rows])
        return np.sqrt(np.diag(np.linalg.inv(information)))

    def held(self, kind, cases):
        """(the part of intervals that hold the truth, the same if all points err by themselves, how wide the intervals are
        over what they would be if it were known how points err)"""
        held, plain, wide = [], [], []
        for seed in range(cases):
            e, j, blocks = self.points(np.random.default_rng(seed), kind)
            at = np.linalg.lstsq(j, e, rcond=None)[0]  # the truth is 0
            sigma = np.full(len(e), 1.4826 * np.median(np.abs(e - j @ at)))
            nothing = np.zeros((2, 2))
            errors = noise.estimate(blocks, e - j @ at, j, sigma, nothing)
            white = errors.whitened(np.column_stack([e, j]))
            at = np.linalg.lstsq(white[:, 1:], white[:, 0], rcond=None)[0]
            known = noise.certainty(errors, e - j @ at, j, nothing)
            half = known.reach * np.sqrt(np.diag(known.covariance))
            held.append(np.abs(at) < half)
            wide.append(half / (1.96 * self.scatter(kind, j, blocks)))
            scatter = np.sqrt(np.diag(np.linalg.inv(j.T @ j))) * np.std(e)
            plain.append(np.abs(np.linalg.lstsq(j, e, rcond=None)[0]) < 1.96 * scatter)
        return np.mean(held), np.mean(plain), np.median(wide)

    def test_hold_the_truth(self):
        """Of 95 %: however points err, 90 to 98 % (here within chance); as if all erred by themselves far
        fewer where they do not. And they are hardly wider than they must be."""
        for kind, least in (("independent", 0.85), ("smooth", 0.82), ("parts", 0.82), ("shifted", 0.82),
                            ("strays", 0.85)):
            held, plain, wide = self.held(kind, 12)
            self.assertGreaterEqual(held, least, kind)
            if kind != "strays":  # of which nobody knows
                self.assertLess(wide, 1.4, kind)
            if kind in ("smooth", "parts", "shifted"):
                self.assertLess(plain, 0.8, kind)

    def test_freedom(self):
        """Of Student's t: shifts are told by their photographs, what is smooth by its pieces, one photograph by nothing."""
        _, j, blocks = self.points(np.random.default_rng(1), "shifted")
        for count, group, expected in ((6, noise.Group(0.1, smooth=1.0), 100), (6, noise.Group(1e-3, shift=1.0), 10),
                                       (6, noise.Group(1.0, shift=1.0), 40), (1, noise.Group(1.0), 2)):
            errors = noise.Errors(blocks[:count], {"lines": group}, np.ones(len(j)), np.ones(len(j)))
            found = noise.freedom(errors)
            self.assertTrue(found > expected if group.smooth else abs(found - expected) < 1e-3, f"{found} {expected}")

    def test_errors_are_told(self):
        """What they were made of is what is found."""
        for kind, smooth, shift in (("independent", 0, 0), ("smooth", 1, 0), ("shifted", 0, 1)):
            found = []
            for seed in range(6):
                e, j, blocks = self.points(np.random.default_rng(seed), kind)
                found.append(noise.estimate(blocks, e, j, np.full(len(e), 0.5), np.zeros((2, 2))).groups["lines"])
            self.assertAlmostEqual(np.median([g.smooth for g in found]), smooth, delta=0.25, msg=kind)
            self.assertAlmostEqual(np.median([g.shift for g in found]), shift, delta=0.4, msg=kind)

    def test_slope_of_the_likelihood(self):
        """Of all kinds of errors: as differences have it."""
        e, j, blocks = self.points(np.random.default_rng(1), "parts")
        errors = noise.Errors(blocks, {"lines": noise.Group(1.0)}, np.ones(len(e)), np.ones(len(e)), j)
        one = noise.Estimate(errors, "lines", e, j, np.zeros((2, 2)))
        one.unit, one.middle = 1.0, 0.0
        theta, step = np.array([-0.3, 0.5, np.log(0.2), 0.4]), 1e-5
        for one.kind in noise.KINDS:
            differences = [(one.cost(theta + h) - one.cost(theta - h)) / (2 * step) for h in step * np.eye(4)]
            np.testing.assert_allclose(one.cost_and_slope(theta)[1], differences, rtol=1e-5, atol=1e-5)

    def test_which_kind(self):
        """Errors that are alike over a part of the rod are told from those alike over a length."""
        for kind, power in (("smooth", 0), ("parts", 1)):
            found = []
            for seed in range(4):
                e, j, blocks = self.points(np.random.default_rng(seed), kind, photographs=8, count=40)
                found.append(noise.estimate(blocks, e, j, np.full(len(e), 0.5), np.zeros((2, 2))).groups["lines"].kind)
            self.assertGreaterEqual(sum(k.power == power for k in found), 3, f"{kind}: {found}")

    def test_another_strand(self):
        """A point between two strands of the rod tells nothing: of which is it?"""
        line = np.array([[0, 0], [1, 0], [1, 0.1], [0, 0.1]], float)
        line = np.column_stack([np.interp(np.linspace(0, 3, 200), np.arange(4), c) for c in line.T])
        near = comparing.nearest(np.array([[0.5, 0.045], [0.5, -0.05]]), line)
        np.testing.assert_allclose(near.other, [0.01, 0.1], atol=2e-3)
        blocks = [noise.Block("lines", np.arange(2), near.place, near.normal, near.other)]
        np.testing.assert_array_equal(noise.screened(near.distance, np.full(2, 0.01), blocks) == noise.NOTHING,
                                      [True, False])

    def test_no_other_strand(self):
        """Of a short rod, whose points err by much of its length: what is farther along it is no other strand."""
        line, angle = np.linspace(0, 1, 200), np.linspace(0, 3, 200)
        for rod in (np.column_stack([line, 0 * line]), np.column_stack([np.sin(angle), 1 - np.cos(angle)]) / 3):
            near = comparing.nearest(rod[20:180:20] + [0.02, 0.07], rod)
            self.assertTrue(np.isinf(near.other).all(), near.other)

    def test_points_that_tell_nothing(self):
        """Are no reason to think that points err by less: with half of them between strands the errors are those of the
        other half."""
        e, j, blocks = self.points(np.random.default_rng(3), "independent")
        for block in blocks[:3]:
            block.other[:] = 0
        group = noise.estimate(blocks, e, j, np.full(len(e), 0.5), np.zeros((2, 2))).groups["lines"]
        self.assertAlmostEqual(group.total, 0.5, delta=0.08)
        self.assertGreater(group.sigma, 0.4)


class Bar:
    """What tqdm's has, and how far it was each time."""

    def __init__(self, total):
        self.n, self.total, self.seen, self.closed = 0, total, [], False

    def update(self, n):
        self.n += n
        self.refresh()

    def refresh(self):
        self.seen.append(self.n / self.total)

    def close(self):
        self.closed = True

    def write(self, text):
        print(text)

    set_postfix_str = write


class Bars(unittest.TestCase):
    def test_a_command_that_is_interrupted(self):
        """Also while it still loads what it needs: one line, no traceback."""
        with mock.patch("tendril.__main__.import_module", side_effect=KeyboardInterrupt), \
                contextlib.redirect_stderr(io.StringIO()) as said:
            self.assertEqual(commands.main(["measure", "push.mp4"]), 130)
        self.assertEqual(said.getvalue(), "measure: interrupted\n")

    def test_bar_that_is_interrupted(self):
        """Ctrl-C while it is drawn leaves it to other threads: a fit that was interrupted so waited for ever."""
        with contextlib.redirect_stderr(io.StringIO()):
            shown = progress.bar(True, 10)
            with mock.patch.object(shown, "display", side_effect=KeyboardInterrupt):
                self.assertRaises(KeyboardInterrupt, shown.refresh)
            other = Thread(target=lambda: progress.bar(False, 1).close(), daemon=True)
            other.start()
            other.join(10)
            self.assertFalse(other.is_alive())
            shown.close()


class Fitting(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.directory = tempfile.TemporaryDirectory(prefix="tendril-")
        cls.place = Path(cls.directory.name)
        cls.truth = tendril.run(TUBE, si_friction_dry=f"{FRICTION}N/m", rod_curvature=f"{CURVATURE}/m",
                                ts_max_time=f"{END}s", output_interval=f"{END / 60}s", accuracy=1e-5)
        cls.data, cls.out, scene = cls.place / "photographs.csv", cls.place / "fit", cls.place / "tube.opts"
        cls.data.write_text("\n".join(cls.photographs(1)) + "\n")
        scene.write_text("# a tube\n" + "".join(f"-{k} {v}\n" for k, v in TUBE.items())
                         + "-rod_curvature 0\n-stop_length 1m\n")
        said, found = io.StringIO(), []

        def kept(*words, **more):
            found.append(tendril.fit(*words, **more))
            return found[0]

        def shown(progress, total, **more):
            cls.bar = Bar(total)
            return cls.bar

        with contextlib.redirect_stdout(said), mock.patch.object(fit_command, "fit", kept), \
                mock.patch.object(problem, "bar", shown):
            cls.code = fit_command.main([str(scene), str(cls.data), "--parameter", "si_friction_dry=0.2N/m:2N/m",
                                         "-p", "rod_curvature=-10/m:10/m", "--starts", "0", "--accuracy", "1e-3",
                                         "--output", str(cls.out)])
        cls.said, cls.found = said.getvalue(), found[0]
        cls.count = cls.found.problem.count

    @classmethod
    def tearDownClass(cls):
        cls.directory.cleanup()

    @classmethod
    def photographs(cls, seed):
        """Lines of CSV: points in no order, with noise of 1 % of the width, a twentieth of them anywhere."""
        random, r = np.random.default_rng(seed), cls.truth
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
        out = self.out
        self.assertEqual(self.code, 0)
        self.assertEqual(self.found.warnings, [])
        lines = {line.split()[0]: line.split() for line in reversed(self.said.splitlines())}
        for name, truth, width in (("si_friction_dry", FRICTION, 0.05), ("rod_curvature", CURVATURE, 0.1)):
            value, low, high = (float(lines[name][k]) for k in (1, 2, 4))
            self.assertTrue(low < value < high and low <= truth <= high, self.said)
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

    def test_bar(self):
        """Full when the fit is done, and nearly so just before; it counts every run."""
        self.assertTrue(self.bar.closed)
        self.assertEqual((self.bar.n, self.bar.seen[-1]), (self.count, 1))
        self.assertLess(max(self.bar.seen[:-1]), 1)
        self.assertGreater(self.bar.seen[-2], 0.8, self.bar.seen)

    def test_band_of_shapes(self):
        """Runs of parameters that the fit leaves open lie in its band, the hidden truth among them, half as far as the
        band at half the way; it asks for no run more."""
        problem, count = self.found.problem, self.found.problem.count
        line, half = self.found.band(3)
        self.assertEqual(problem.count, count)
        true = comparing.finer(comparing.shape_at(self.truth, 28 / self.truth.scale("time"))) * self.truth.scale("length")
        off = np.abs(comparing.nearest(true[::40], line).distance)
        place = [np.argmin(np.hypot(*(line - x).T)) for x in true[::40]]
        self.assertGreater(np.mean(off <= half[place] + 1e-5), 0.85)
        self.assertLess(half.max(), 0.03 * np.ptp(line[:, 0]))
        deviation = np.sqrt(self.found.covariance[0, 0])
        beside = self.found.u + self.found.covariance[0] / deviation  # the others follow
        (r,) = problem.run([beside])
        moved = problem.comparison.line(r, problem.measured.photographs[3], beside[len(problem.parameters):])
        share = np.abs(comparing.nearest(line[200::100], moved).distance) * self.found.reach[0] / half[200::100]
        self.assertLess(share.max(), 1.1)
        self.assertGreater(share.max(), 0.4)

    def test_differences_that_serve_again(self):
        """Central ones around a point that is near ask for no run and are as good; farther off they are made anew."""
        problem = self.found.problem
        followed, problem.followed, problem.middle = problem.followed, [], None
        self.addCleanup(setattr, problem, "followed", followed)
        here = problem.raw_jacobian(self.found.u, central=True)
        for by, runs in ((0.002, 1), (0.02, 5)):  # one is that at the point itself
            count, u = problem.count, self.found.u + by
            problem.run([u])
            found = problem.raw_jacobian(u, central=True)
            self.assertEqual(problem.count - count, runs)
            problem.middle = None
            anew = problem.raw_jacobian(u, central=True)
            self.assertLess(np.linalg.norm(found - anew), 0.05 * np.linalg.norm(anew))
        self.assertEqual(found.shape, here.shape)

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
        shared = dict(starts=0, accuracy=1e-2, rod_curvature=f"{CURVATURE}/m")
        with mock.patch("tendril.fitting.warnings_of", return_value=[]):
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

    def faulty(self, change, **more):
        """The fit of clean points, changed; search from near the truth."""
        random, r = np.random.default_rng(3), self.truth
        length, found = r.scale("length"), {}
        for t in (14, 18, 21, 24, 28):
            line = comparing.finer(comparing.shape_at(r, t / r.scale("time"))) * length
            points = line[random.choice(len(line), 30, replace=False)] + 2e-4 * random.normal(size=(30, 2))
            found[f"{t}s"] = 100 * change(points)
        return tendril.fit(TUBE, found, {"si_friction_dry": ("0.2N/m", "2N/m", "0.6N/m")}, unit="cm", starts=0,
                           accuracy=1e-2, rod_curvature=f"{CURVATURE}/m", **more)

    def test_points_that_end_early(self):
        """By chance, for they are anywhere on the rod: where the last one is says no more of the rod's end than
        the others let expect."""
        random, r = np.random.default_rng(3), self.truth
        length, found = r.scale("length"), {}
        for t, last in ((14, 0.97), (18, 0.98), (21, 0.93), (24, 0.88), (28, 0.92)):
            line = comparing.finer(comparing.shape_at(r, t / r.scale("time"))) * length
            points = line[(np.linspace(0.01, last, 40) * (len(line) - 1)).astype(int)]
            found[f"{t}s"] = 100 * (points + 2e-4 * random.normal(size=points.shape))
        with mock.patch("tendril.fitting.warnings_of", return_value=[]):
            f = tendril.fit(TUBE, found, {"si_friction_dry": ("0.2N/m", "2N/m", "0.6N/m")}, unit="cm", starts=0,
                            accuracy=3e-3, rod_curvature=f"{CURVATURE}/m")
        low, high = f.intervals["si_friction_dry"]
        self.assertTrue(low < FRICTION < high and high - low < 0.04 * FRICTION, f"{low} to {high}")

    def test_hidden_tips(self):
        """Something lies on the last of the rod in all photographs: how far it goes on there says nothing, and is left out,
        of trials of laws, too; points that end by chance leave nothing out."""
        scale = {name: self.truth.scale(name) for name in ("time", "length")}

        def seen(t, x, random):
            line = comparing.finer(comparing.shape_at(self.truth, float(t) / scale["time"])) * scale["length"]
            near = comparing.nearest(x, line)
            return t, x[near.place < 0.8 * near.place.max()]

        def ends(one):
            raw = one.raw(self.found.u, self.found.run)
            return raw[:len(one.comparison.groups)][np.array(one.comparison.groups) == comparing.ENDS]

        self.assertFalse(self.found.problem.leave_hidden(self.found.u))
        wrong = self.wrong(seen)
        self.assertGreater(ends(wrong.problem).max(), 0)
        self.assertTrue(wrong.problem.leave_hidden(self.found.u))
        self.assertGreaterEqual(len(wrong.problem.comparison.hidden), 3)
        self.assertLessEqual(ends(wrong.problem).max(), 0)
        more = laws.with_law(wrong, laws.laws_of(wrong)[0], wrong.problem.settings)
        self.assertEqual(more.comparison.hidden, wrong.problem.comparison.hidden)

    def test_a_bad_fit_is_called_bad(self):
        """And its likeliest cause is named, with its size; a good one is called nothing (above)."""
        c, s = np.cos(np.radians(3)), np.sin(np.radians(3))
        few = [cause for cause in doubts.CAUSES if cause.looked_for in (("camera_turn",), ("clock_rate",))]
        # the others cost, and are tried below
        with mock.patch.object(doubts, "promising", return_value=[]), mock.patch.object(doubts, "CAUSES", few), \
                mock.patch.object(doubts, "laws_of", return_value=[]), mock.patch.object(doubts, "searched_again", return_value=(1.0, None)):
            turned = self.faulty(lambda x: x @ np.array([[c, s], [-s, c]]))
        self.assertIn("a bad fit", turned.warnings[0])
        self.assertRegex("\n".join(turned.warnings), "likeliest cause: the picture is turned by (2.[6-9]|3|3.[1-4]) degrees")
        self.assertIn("NOT TO BE TRUSTED", turned.report())
        low, high = turned.intervals["si_friction_dry"]  # as far as it goes with the cause
        self.assertTrue(low < FRICTION < high, f"{low} to {high}")

    def test_a_law_that_is_left_out(self):
        """Points of a tube whose friction is viscous, too, beside the scene that was found, in which it is dry alone: the law
        is named with its size, the intervals reach to the truth and are told not to be trusted. Right data ask for none."""
        self.assertEqual(doubts.wanted_laws(self.found, False), [])
        self.assertTrue(self.found.trusted)
        old, viscous = self.found.problem, 10.0
        law = next(law for law in laws.laws_of(self.found) if law.name == "si_friction_viscous")
        more = laws.with_law(self.found, law, old.settings)
        truth = np.r_[self.found.u[0] - 0.05, self.found.u[1], law.parameter.inside(viscous)]
        (r,) = more.run([truth])
        random, photographs = np.random.default_rng(5), []
        for p in old.measured.photographs:
            line = more.comparison.line(r, p, [])
            points = line[random.choice(len(line), 40, replace=False)]
            points = points + self.found.noise["lines"] * random.normal(size=points.shape)
            photographs.append(replace(p, points=replace(p.points, numbers=points)))
        wrong = replace(self.found, problem=problem.Problem(old.scene, measured.Measured(photographs), old.parameters, old.options))
        for name in ("glimpse", "begin", "reach", "settings", "search_settings", "search_points", "followed"):
            setattr(wrong.problem, name, getattr(old, name))
        wrong.problem.run([wrong.u])
        wrong.problem.measure_noise(wrong.u)
        wrong.u = wrong.problem.solve(wrong.u, 1e-2, most=4).u
        (wrong.run,) = wrong.problem.run([wrong.u])
        wrong.run = replace(wrong.run, options=self.found.run.options, attributes=self.found.run.attributes | wrong.run.attributes)
        wrong.problem.measure_errors(wrong.u, wrong.problem.raw_jacobian(wrong.u))
        friction = float(old.parameters[0].value(truth[0]))
        self.assertFalse(self.found.intervals["si_friction_dry"][0] < friction)
        with mock.patch.object(doubts, "CAUSES", []), mock.patch.object(doubts, "LAWS", 1):
            (said,) = doubts.likeliest(wrong, False, lambda text: None)
        found = re.search("friction is dry: with si_friction_viscous = (.*) Ns/m.2 it has si_friction_dry = (.*) N/m, rod", said)
        self.assertTrue(found, said)
        self.assertAlmostEqual(float(found[1]), viscous, delta=0.3 * viscous)
        low, high = wrong.intervals["si_friction_dry"]
        self.assertTrue(low < friction < high, f"{low} < {friction} < {high}")
        self.assertFalse(wrong.trusted)

    def test_laws_that_may_be_left_out(self):
        """Are those that the scene holds, and that no parameter is; with a number beside which the rod can run."""
        def fitted(names, **about):
            own = {"rod_curvature_file": "the fit's.h5"} if any(MODE.match(n) for n in names) else {}
            run = mock.Mock(attributes={f"parameters/{k}": v for k, v in about.items()}, options=own,
                            series=mock.Mock(length=np.array([1.0, 4.0])))
            return mock.Mock(run=run, problem=mock.Mock(parameters=[Parameter.of(n, (0.5, 2)) for n in names], tied={}, options={}))

        scene = dict(growth_type="apical", friction_mu=1.0, friction_across=1.0, growth_zone=0.5, tip_force=0.0, rod_curvature=0.1)
        for names, about, expected in (
                (["friction_across"], scene, {"friction_mu": 1, "rod_curvature": 0.1, "growth_zone": 0.5, "tip_force": 0}),
                (["rod_curvature", "friction_mu"], scene | {"growth_type": "feed"}, {"friction_across": 1, "curvature_mode_2": 0, "tip_force": 0}),
                (["curvature_mode_1", "curvature_mode_2", "tip_force"], scene | {"growth_type": "feed", "friction_mu": 0.0},
                 {"friction_mu": 0, "friction_across": 1, "curvature_mode_3": 0}),
                (["si_friction_viscous", "rod_curvature"], dict(si_bending_stiffness=1e-6, si_friction_viscous=100.0, si_speed=5e-3),
                 {"si_friction_dry": 0, "curvature_mode_2": 0, "tip_force": 0})):
            held = laws.laws_of(fitted(names, **about))
            self.assertEqual({law.name: law.held for law in held}, expected)
            for law in held:
                self.assertTrue(0 <= law.begin <= 1 and law.parameter.low <= law.held <= law.parameter.high, law)
        self.assertEqual(held[-1].parameter.unit, "N")

    def test_no_effect(self):
        """A cause that moves nothing, as a straight rod pushed along itself, explains nothing."""
        still = np.zeros((len(self.found.problem.raw(self.found.u, self.found.run)), 1))
        self.assertEqual(doubts.linear_sign(self.found, still)[:2], (1, 0))

    def test_interrupted_doubts(self):
        """A fit whose doubts were not looked for to their end is not trusted."""
        found = replace(self.found, doubtful=False, elsewhere=[])
        self.assertTrue(found.trusted)
        with mock.patch.object(fitting, "warnings_of", side_effect=KeyboardInterrupt):
            self.assertIn("interrupted", fitting.doubted(found, True, None)[0])
        self.assertFalse(found.trusted)

    def test_bounds(self):
        """Parameters and times of photographs that have none are within what there is; the camera is free."""
        with mock.patch.object(self.found.problem.comparison, "timeless", [None]):
            low, high = self.found.problem.bounds(np.zeros(len(self.found.parameters) + 5))
        p = len(self.found.parameters)
        self.assertEqual([*low], [0] * p + [-np.inf] * 4 + [0])
        self.assertEqual([*high], [1] * p + [np.inf] * 4 + [1])

    def test_told_apart(self):
        """A law that leaves no more than the errors is told from one that leaves a third more, as sizes alone would not."""
        errors = self.found.problem.errors
        raw = self.found.problem.raw(self.found.u, self.found.run)
        ends = [doubts.End(0.5, 1, "a law", True, raw=raw, blocks=errors.blocks), doubts.End(0.55, 1, "another", True, raw=1.3 * raw)]
        self.assertEqual([end.words for end in doubts.told_apart(self.found, ends)], ["a law"])
        ends[1] = ends[1]._replace(raw=1.001 * raw)
        self.assertEqual(len(doubts.told_apart(self.found, ends)), 2)

    def test_no_unit_at_all(self):
        """Of numbers that carry none, beside a scene in the laboratory's, what they may be; and what is then read."""
        about = self.found.run.attributes
        bare = [replace(p, at=measured.Values(p.at.numbers, ""), points=measured.Values(100 * p.points.numbers, ""))
                for p in self.found.problem.measured.photographs]
        causes = doubts.unitless(measured.Measured(bare), about)
        self.assertEqual([c.change for c in causes], [("time", 1.0), ("metre", 1.0), ("metre", 0.01), ("metre", 1e-3)])
        self.assertEqual([c.of_time for c in causes], [True, False, False, False])
        self.assertEqual(doubts.unitless(self.found.problem.measured, about), [])
        for cause in (causes[0], causes[2]):
            new = doubts.changed(measured.Measured(bare), cause.change).photographs
            for p, old in zip(new, self.found.problem.measured.photographs):
                one, other = (p.at, old.at) if cause.of_time else (p.points, old.points)
                self.assertEqual(one.unit, other.unit)
                np.testing.assert_allclose(one.numbers, other.numbers)

    def test_a_time_without_its_unit(self):
        """Is named, by trying it."""
        old = self.found.problem
        bare = measured.Measured([replace(p, at=measured.Values(p.at.numbers, "")) for p in old.measured.photographs])
        new = problem.Problem(old.scene, bare, old.parameters, old.options)
        for name in ("glimpse", "begin", "reach", "search_settings", "search_known", "search_points", "errors", "followed"):
            setattr(new, name, getattr(old, name))
        new.settings, new.known = old.settings, dict(old.known)
        wrong = replace(self.found, problem=new)
        new.raw(wrong.u, wrong.run)
        self.assertGreater(doubts.sizes(wrong)["lines"][0], 0.02 * doubts.sizes(wrong)["lines"][1])
        ratio, _, u = doubts.tried(wrong, doubts.unitless(bare, self.found.run.attributes)[0])
        self.assertLess(ratio, 0.3)
        self.assertAlmostEqual(float(old.parameters[0].value(u[0])), FRICTION, delta=0.05 * FRICTION)

    def test_a_wrong_unit(self):
        """Is the first of what is tried; then the residuals are gone."""
        old = self.found.problem
        new = problem.Problem(old.scene, doubts.changed(old.measured, ("unit", 10)), old.parameters, old.options)
        for name in ("glimpse", "begin", "reach", "search_settings", "search_known", "search_points", "errors", "followed"):
            setattr(new, name, getattr(old, name))
        new.settings, new.known = old.settings, dict(old.known)
        wrong = replace(self.found, problem=new)
        new.raw(wrong.u, wrong.run)
        size, extent = doubts.sizes(wrong)["lines"]
        self.assertGreater(size, doubts.BAD * extent)
        cause = doubts.promising(wrong, doubts.discrete())[0]
        self.assertEqual(cause.change, ("unit", 0.1))
        ratio, _, u = doubts.tried(wrong, cause)
        self.assertLess(ratio, 0.05)
        self.assertAlmostEqual(float(old.parameters[0].value(u[0])), FRICTION, delta=0.05 * FRICTION)

    def wrong(self, change):
        """The fit as if it had ended at the same scene, of its photographs changed: times and points [n, 2]."""
        old, photographs = self.found.problem, []
        for k, p in enumerate(self.found.problem.measured.photographs):
            at, points = change(p.at.numbers, p.points.numbers, np.random.default_rng(k))
            photographs.append(replace(p, at=replace(p.at, numbers=at), points=replace(p.points, numbers=points)))
        new = problem.Problem(old.scene, measured.Measured(photographs), old.parameters, old.options)
        for name in ("glimpse", "begin", "reach", "search_settings", "search_known", "search_points", "errors", "followed"):
            setattr(new, name, getattr(old, name))
        new.settings, new.known = dict(old.settings), dict(old.known)
        new.raw(self.found.u, self.found.run)
        return replace(self.found, problem=new)

    def test_misuses(self):
        """Of a clamp 2 mm off, a camera turned by 3 degrees, a wrong scale and a fast clock residuals ask first for what was
        wrong; of exchanged columns the search's own runs; each is no chance."""
        c, s = np.cos(np.radians(3)), np.sin(np.radians(3))
        for name, change in (("camera_x", lambda t, x, random: (t, x + [2e-3, 0])),
                             ("camera_turn", lambda t, x, random: (t, x @ np.array([[c, s], [-s, c]]))),
                             ("camera_scale", lambda t, x, random: (t, 1.05 * x)),
                             ("clock_rate", lambda t, x, random: (1.2 * t, x))):
            wrong = self.wrong(change)
            signs = {cause.looked_for[0]: doubts.linear_sign(wrong, doubts.effect_on_view(wrong, cause)) for cause in doubts.CAUSES}
            # a rod that is seen too large is nearly one that is pushed out too fast
            self.assertGreater(signs[name][2], 0.9 * max(sign[2] for sign in signs.values()), signs)
            self.assertTrue(signs[name][0] < doubts.SURE and signs[name][1] > doubts.SEEN, signs)
        swapped = self.wrong(lambda t, x, random: (t, x[:, ::-1]))
        self.assertGreater(doubts.bare_part(swapped), 0.05)
        self.assertEqual(doubts.promising(swapped, doubts.discrete())[0].change, ("swap", 0))

    def test_an_odd_photograph(self):
        """One that shows the rod at another time is named, and no other."""
        photographs = self.found.problem.measured.photographs
        late, other = photographs[-2].at.numbers, photographs[-1].points.numbers
        self.assertEqual(doubts.odd_ones(self.found), [])
        odd = self.wrong(lambda t, x, random: (t, other if t == late else x))
        (words,) = doubts.odd_ones(odd)
        self.assertRegex(words, f"^the photograph at t = {late:.3g} s: .* of another time, or another rod")
        odd.doubtful, odd.elsewhere = False, []
        with mock.patch.object(doubts, "limit_of", return_value=np.inf), mock.patch.object(doubts, "bare_part", return_value=0), \
                mock.patch.object(doubts, "likeliest", return_value=[]):  # nor is the fit trusted that nothing else speaks against
            self.assertIn(words, doubts.warnings_of(odd, True, None))
        self.assertFalse(odd.trusted)

    def test_strays_are_in_all_photographs(self):
        """And make none of them odd."""
        random = np.random.default_rng(1)
        clean, strays = random.normal(size=(2, 200))
        strays[::10] += 40
        self.assertEqual(doubts.off_the_rod(strays[:40], np.r_[strays[40:], strays]), (0, 0))
        part, size = doubts.off_the_rod(strays[:40], clean)
        self.assertTrue(part == 0 or size > 20, (part, size))
        self.assertGreater(doubts.off_the_rod(clean[:40] + 6, clean)[0], 0.9)

    def test_a_search_that_went_astray(self):
        """Is named, with where it should have ended; and so is the tip that is in no picture, which leads astray."""
        old = self.found.problem
        astray = np.array(self.found.u)
        astray[:2] = [0.9, 0.95]
        (r,) = old.run([astray])
        for most, words in ((np.inf, "the search ended beside the solution: at si_friction_dry, rod_curvature = (.*)N/m, (.*)/m residuals"),
                            (0.6, "in [1-9] of [0-9] photographs the rod goes on beyond the points")):
            reach = most * max(p.points.numbers[:, 0].max() for p in old.measured.photographs)
            wrong = replace(self.wrong(lambda t, x, random: (t, x[x[:, 0] < reach])), u=astray, run=r)
            wrong.problem.raw(astray, r)
            ratio, said = doubts.searched_again(wrong)
            self.assertLess(ratio, doubts.WELL)
            self.assertRegex(said, words)
            for number, truth in zip(re.search(words, said).groups(), (FRICTION, CURVATURE)):
                self.assertAlmostEqual(float(number) / truth, 1, delta=0.03)

    def test_points_at_random(self):
        """Are explained by nothing: a cause that leaves most of the residuals, or ends at the most that was tried, is none."""
        wild = self.wrong(lambda t, x, random: (t, random.uniform(x.min(axis=0), x.max(axis=0), x.shape)))
        size, extent = doubts.sizes(wild)["lines"]
        self.assertGreater(size, doubts.BAD * extent)
        clock = next(cause for cause in doubts.CAUSES if cause.looked_for == ("clock_offset",))
        for part in (0.5, 1.0):
            with mock.patch.object(problem.Problem, "solve",
                                   lambda one, u, *more, **also: problem.Solution(np.r_[u[:2], part, u[3:]], 1.0)):
                ratio, _, u = doubts.tried(wild, clock)
            self.assertGreater(ratio, doubts.WELL)
            self.assertIsNone(u)

    def test_which_model(self):
        """The data speak for the friction they were made with, and not for another data set."""
        with mock.patch("tendril.fitting.warnings_of", return_value=[]):
            viscous = tendril.fit(TUBE, self.data, {"si_friction_viscous": ("20Ns/m^2", "2000Ns/m^2", "150Ns/m^2")},
                                  rod_curvature=f"{CURVATURE}/m", starts=0, accuracy=3e-3)
        both = tendril.compare([viscous, self.found], names=["viscous", "dry"])
        self.assertEqual(both.best, "dry")
        self.assertIn("dry is decisively better than viscous", repr(both))
        self.assertLess(both.chi2[1], both.chi2[0])
        self.assertAlmostEqual(both.weight.sum(), 1)
        self.assertEqual(list(both.frame().index), ["viscous", "dry"])
        self.assertAlmostEqual(both.aic[1], self.found.aic, places=6)
        other = replace(self.found, problem=mock.Mock(measured=doubts.changed(self.found.problem.measured, ("unit", 2))))
        with self.assertRaisesRegex(tendril.TendrilError, "not of the same data"):
            tendril.compare([self.found, other])

    def test_profile(self):
        """The cost is least at the estimate, and rises to both sides as the linearised problem says: by half of
        the square of standard deviations, which the errors' own uncertainty makes wider."""
        f = self.found
        found = tendril.profile(f, "si_friction_dry", count=3, reach=1)
        self.assertAlmostEqual(found.values[1], f.values["si_friction_dry"])
        self.assertAlmostEqual(found.cost[1], 0, delta=0.02)
        white = f.problem.jacobian(f.u)
        plain = np.sqrt(np.linalg.inv(white.T @ white)[0, 0])
        expected = 0.5 * f.covariance[0, 0] / plain**2
        np.testing.assert_allclose(found.cost[[0, 2]], expected, rtol=0.25)
        with self.assertRaisesRegex(tendril.TendrilError, "is no parameter; there are si_friction_dry"):
            tendril.profile(f, "friction")

    @unittest.skipUnless(find_spec("emcee"), "emcee is not there")
    def test_samples(self):
        """Of a posterior that is known: as wide as it is. The runs are of the linearised problem."""
        f, p = self.found, self.found.problem
        here, white, asked = p.residuals(f.u), p.jacobian(f.u), []
        size = len(p.known)
        with mock.patch.object(p, "run", lambda points: asked.extend(np.array(points)) or [None] * len(points)), \
                mock.patch.object(p, "residuals", lambda u: here + white @ (u - f.u)):
            s = tendril.sample(f, steps=600, walkers=16)
        self.assertEqual(len(p.known), size)
        self.assertTrue(np.all((np.array(asked) >= 0) & (np.array(asked) <= 1)))
        inverse = np.linalg.inv(white.T @ white)
        middle = f.u - inverse @ white.T @ here
        for k, q in enumerate(f.parameters):
            ends = [float(q.value(middle[k] + z * 1.96 * np.sqrt(inverse[k, k]))) for z in (-1, 1)]
            np.testing.assert_allclose(s.interval(q.name), ends, atol=0.15 * (ends[1] - ends[0]))
        calls = []

        def pressed(points):
            calls.append(len(points))
            if len(calls) == 30:
                raise KeyboardInterrupt
            return [None] * len(points)

        said = io.StringIO()
        with mock.patch.object(p, "run", pressed), contextlib.redirect_stdout(said), contextlib.redirect_stderr(said), \
                mock.patch.object(p, "residuals", lambda u: here + white @ (u - f.u)):
            few = tendril.sample(f, steps=600, walkers=16, burn=0.5)
        self.assertEqual(said.getvalue(), "")
        self.assertTrue(16 * 5 <= len(few.values) < 16 * 15, len(few.values))
        if find_spec("corner"):
            figure = s.corner()
            self.assertEqual(len(figure.axes), 4)
        with mock.patch.dict(sys.modules, {"emcee": None}):
            with self.assertRaisesRegex(tendril.TendrilError, r"pip install 'tendril\[sample\]'"):
                tendril.sample(f)

    @unittest.skipUnless(find_spec("emcee"), "emcee is not there")
    def test_samples_of_runs(self):
        """A few steps of real ones: better or about as good as the estimate, and no run is kept."""
        f, size = self.found, len(self.found.problem.known)
        s = tendril.sample(f, steps=2, walkers=6, burn=0)
        self.assertEqual(s.values.shape, (12, 2))
        self.assertEqual(len(f.problem.known), size)
        for k, q in enumerate(f.parameters):
            self.assertLess(np.abs(q.inside(s.values[:, k]) - f.u[k]).max(), 8 * np.sqrt(f.covariance[k, k]))

    def test_as_xarray(self):
        """All of it, as it says, also through a file of JSON."""
        f, d = self.found, self.found.dataset()
        self.assertAlmostEqual(float(d.estimate.sel(parameter="si_friction_dry")), f.values["si_friction_dry"])
        np.testing.assert_allclose(d.interval.sel(parameter="rod_curvature"), f.intervals["rod_curvature"])
        np.testing.assert_allclose(d.correlation, f.correlations)
        self.assertEqual(d.sizes["point"], len(f.residuals()))
        said = json.loads(self.out.with_suffix(".json").read_text())
        self.assertEqual((said["trusted"], d.attrs["trusted"]), (True, 1))
        bad = replace(f, doubtful=True)
        self.assertEqual((bad.to_dict()["trusted"], bad.dataset().attrs["trusted"]), (False, 0))
        self.assertIn("NOT TO BE TRUSTED", bad.report())
        self.assertIn("not to be trusted", bad.scene())
        self.assertEqual(said["parameters"]["si_friction_dry"]["interval"], list(f.intervals["si_friction_dry"]))

    def test_interrupted(self):
        """Ctrl-C while two searches go on, in whatever thread: the best until then, near the truth; the other
        search ends, too."""
        run, calls, late = problem.Problem.run, [], []

        def pressed(one, points):
            calls.append(len(points))
            if one.best is not None and len(calls) == 12:
                raise KeyboardInterrupt
            late.append(one.ended)
            return run(one, points)

        with mock.patch.object(problem.Problem, "run", pressed), \
                mock.patch.object(fitting, "warnings_of", side_effect=AssertionError):
            found = tendril.fit(TUBE, self.data, {"si_friction_dry": ("0.2N/m", "2N/m", "0.5N/m")},
                                rod_curvature=f"{CURVATURE}/m", starts=1, accuracy=3e-3)
        self.assertTrue(found.interrupted)
        self.assertLess(sum(late), 3)
        self.assertIn("interrupted", found.report())
        self.assertAlmostEqual(found.values["si_friction_dry"], FRICTION, delta=0.3 * FRICTION)
        low, high = found.intervals["si_friction_dry"]
        self.assertLess(low, found.values["si_friction_dry"])
        self.assertLess(found.values["si_friction_dry"], high)

    def test_interrupted_at_once(self):
        """Before there is anything: one line, no traceback. While doubts are looked for, or in the last run: the fit stays."""
        said = io.StringIO()
        with mock.patch.object(fit_command, "fit", side_effect=KeyboardInterrupt), contextlib.redirect_stderr(said):
            code = fit_command.main([str(self.place / "tube.opts"), str(self.data), "-p", "si_friction_dry=0.2N/m:2N/m",
                                     "--output", str(self.place / "none")])
        self.assertEqual((code, said.getvalue()), (130, "fit: interrupted before anything was found\n"))
        with mock.patch.object(fitting, "warnings_of", side_effect=KeyboardInterrupt):
            self.assertIn("interrupted", fitting.doubted(self.found, True, print)[0])
        f, calls = self.found, []

        def first(u, settings):
            calls.append(settings)
            if len(calls) == 1:
                raise KeyboardInterrupt
            return f.run

        with mock.patch.object(f.problem, "first", first):
            again = fitting.finished(f.problem, problem.Solution(f.u, f.cost), noise.Certainty(f.covariance, f.reach), [], 0.0,
                                     False, True, print)
        self.assertTrue(again.interrupted and len(calls) == 2)
        self.assertEqual(again.values, f.values)

    def test_what_is_known_does_not_outweigh_the_points(self):
        """A picture that is turned by three degrees, known to be so to three: found beside the rest."""
        c, s = np.cos(np.radians(3)), np.sin(np.radians(3))
        with mock.patch("tendril.fitting.warnings_of", return_value=[]):
            known = self.faulty(lambda x: x @ np.array([[c, s], [-s, c]]), priors={"camera_turn": "0:0.05"})
        self.assertAlmostEqual(np.degrees(known.values["camera_turn"]), 3, delta=0.3)
        self.assertAlmostEqual(known.values["si_friction_dry"], FRICTION, delta=0.02 * FRICTION)

    def test_a_first_run_that_gives_up(self):
        """At the middle of the bounds the rod is straight and jams at a wall: the search begins at another point. What is
        refused there is refused at once."""
        looked = problem.Problem(TUBE, measured.Measured(), [Parameter.of("rod_curvature", (-1, 1))], {})
        for stored, tried in ((object(), 3), (None, 1)):
            points = []

            def prepare(u, accuracy):
                points.append(float(u[0]))
                if len(points) < 3:
                    raise tendril.RunError("jammed", results=stored)

            with mock.patch.object(looked, "prepare", prepare), contextlib.suppress(tendril.RunError):
                fitting.begun(looked, np.array([0.5]), 1e-3, 1)
            self.assertEqual(len(points), tried)
            self.assertEqual(len(set(points)), tried)

    def test_refuses_what_the_scene_cannot(self):
        data = self.place / "late.csv"
        bounds = {"si_friction_dry": ("0.2N/m", "2N/m")}
        for more, word in ((dict(stop_length="5cm"), "ends at t = 8, before .* at 20"),
                           (dict(data="length (mm),width (cm)\n2,1\n15,3\n"), "at length 0.002, and .* begins at .* m; give a smaller"),
                           (dict(friction_layers="0:1,3:{hard}"), "in braces is no parameter")):
            data.write_text(more.pop("data", "t (s),width (cm)\n1,2\n20,3\n"))
            with self.assertRaisesRegex(tendril.TendrilError, word):
                tendril.fit(TUBE, data, bounds, **more)

    def test_derivatives_that_runs_tell(self):
        """They are those of differences between runs, also where units change with the numbers and points are
        behind the end of the run; what runs do not tell is still found by differences."""
        bounds = {"si_friction_dry": ("0.3N/m", "1.5N/m"), "rod_curvature": ("-10/m", "10/m"), "clock_rate": (0.5, 2),
                  "growth_initial_length": ("0.8cm", "1.3cm")}
        parameters = [Parameter.of(name, value) for name, value in bounds.items()]
        scene = {name: value for name, value in TUBE.items() if name != "growth_initial_length"}
        p = problem.Problem(scene, measured.gather(self.data, "", None, None), parameters, {})
        u = np.array([q.inside(v) for q, v in zip(parameters, (0.7, 3.0, 1.0, 1.0))])
        p.prepare(u, 1e-5)
        self.assertEqual(p.followed, ["si_friction_dry", "rod_curvature", "growth_initial_length"])
        p.measure_noise(u)
        before = p.count
        told = p.raw_jacobian(u) / p.sigma[:, None]
        self.assertEqual(p.count, before + 1)
        p.followed = []
        with mock.patch.object(problem, "FINE_STEP", 1e-3):
            found = p.raw_jacobian(u, central=True) / p.sigma[:, None]
        off = np.linalg.norm(told - found, axis=0) / np.linalg.norm(found, axis=0)
        self.assertLess(off.max(), 0.03, off)
        touching = problem.Problem(TUBE | {"contact_self": True, "contact_diameter": "2.5mm"}, p.measured, parameters[:2], {})
        touching.follow(u[:2])
        self.assertEqual(touching.followed, [])  # the program refuses; differences do
        touching.followed, touching.settings = touching.own_numbers(), {"ts_max_time": 1e-6}  # as a cause's, which is not asked before
        self.assertIsNone(touching.run_derived(u[:2]))
        self.assertEqual((touching.followed, touching.known), ([], {}))
        before = p.count
        p.prepare(u, 1e-3)
        self.assertEqual(p.count, before + 1)  # what the scene is was asked before
        braces = problem.Problem(TUBE | {"si_friction_dry": "0.6N/m"}, p.measured, [Parameter.of("soft", (0.1, 1)), parameters[1]],
                                 {"friction_layers": "0:{soft},3:2"})
        u = np.array([0.5, 0.7])
        braces.prepare(u, 1e-3)
        self.assertEqual((braces.followed, braces.all_followed), (["rod_curvature"], False))
        braces.measure_noise(u)
        before = braces.count
        told = braces.raw_jacobian(u, central=True)
        self.assertEqual(braces.count, before + 3)
        braces.followed = []
        found = braces.raw_jacobian(u, central=True)
        np.testing.assert_allclose(told[:, 0], found[:, 0])
        self.assertLess(np.linalg.norm(told[:, 1] - found[:, 1]), 0.03 * np.linalg.norm(found[:, 1]))

    def test_names_before_physics(self):
        """A scene whose friction is looked for under a name that is none has no friction: the name is told."""
        scene, data = ROOT / "docs/first/root.opts", ROOT / "docs/first/root.csv"
        for names, word in ((["si_friction_dri"], "^si_friction_dri: unknown option, did you mean si_friction_dry"),
                            (["friction"], "^friction: unknown option, did you mean friction_mu"),
                            (["rod_curvature", "qqq"], "^qqq: unknown option; docs/options.md has all")):
            with self.assertRaisesRegex(tendril.TendrilError, word):
                tendril.fit(scene, data, {name: (0.1, 2) for name in names})
        with self.assertRaisesRegex(tendril.TendrilError, "^si_friction_viscos: unknown option, did you mean si_friction_viscous"):
            tendril.fit(scene, data, {"si_friction_dry": (0.1, 2)}, tied={"si_friction_viscos": "2*si_friction_dry Ns/m^2"})

    def test_straight_in_all_photographs(self):
        """Nothing tells friction there, and that is said before the search; what a straight rod tells is found, though no
        residual is left."""
        data = self.place / "straight.csv"
        data.write_text("t (s),x1 (cm),x2 (cm)\n" + "".join(f"{t},{x},0\n" for t, n in ((1, 3), (2, 4)) for x in 0.5 * np.arange(1, n + 1)))
        friction = {"si_friction_dry": ("0.1N/m", "10N/m")}
        for names, count in (({}, 2), ({"rod_curvature": ("-10/m", "10/m")}, 2)):
            with self.assertRaisesRegex(tendril.TendrilError, "straight in all 2 photographs: nothing tells si_friction_dry; give"):
                tendril.fit(TUBE, data, friction | names)
        with mock.patch.object(fitting, "Problem", side_effect=OverflowError):  # beyond the check
            for more in ("2,2,0.01\n", "", "t (s),width (cm)\n1,2\n2,3\n"):
                other = self.place / "more.csv"
                other.write_text(more if "width" in more else data.read_text() + more)
                name = friction if more else {"growth_initial_length": ("0.5cm", "2cm")}
                with self.assertRaises(OverflowError):
                    tendril.fit(TUBE, [data, other] if "width" in more else other, name)
        with np.errstate(all="raise"):
            found = tendril.fit(TUBE, data, {"rod_curvature": ("-10/m", "10/m")}, si_friction_dry="0.6N/m", starts=1, accuracy=3e-3)
        self.assertAlmostEqual(found.values["rod_curvature"], 0, delta=1e-3)

    def test_arguments_of_another_kind(self):
        good = {"si_friction_dry": ("0.2N/m", "2N/m")}
        for more, word in ((dict(unit=3), "unit 3"), (dict(fps="a"), "fps a"), (dict(fps=0), "fps 0"), (dict(y_down="no"), "y_down no"),
                           (dict(accuracy="x"), "accuracy x"), (dict(starts=1.5), "starts 1.5"), (dict(seed=-1), "seed -1"),
                           (dict(jobs=0), "jobs 0"), (dict(priors=["a"]), "priors by name"), (dict(tied="a=b"), "tied by name"),
                           (dict(noise=3), "noise by name"), (dict(parameters=[1]), "parameters by name"),
                           (dict(parameters={5: (1, 2)}), "parameters by name"), (dict(parameters={"tip_force": None}), "tip_force|None")):
            with self.assertRaisesRegex(tendril.TendrilError, word):
                tendril.fit(**{"scene": TUBE, "data": self.data, "parameters": good} | more)

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
        with contextlib.redirect_stderr(io.StringIO()) as said, \
                mock.patch.object(fit_command, "fit", side_effect=AssertionError):  # it is seen before the work
            self.assertEqual(fit_command.main([str(TUBE), str(data), "-p", "tip_force=1:2", "--output", "/none/x"]), 1)
        self.assertRegex(said.getvalue(), "^fit: /none/x: there is no directory /none; make it.*\n$")
        with contextlib.redirect_stderr(io.StringIO()) as said:
            self.assertEqual(fit_command.main([str(TUBE), str(data)]), 1)
        self.assertRegex(said.getvalue(), "^fit: .* --parameter si_friction_dry=0.1N/m:2N/m\n$")
        with contextlib.redirect_stderr(io.StringIO()) as said:
            self.assertEqual(fit_command.main([str(TUBE), str(data), "-p", "tip_force", "1:2"]), 1)
        self.assertRegex(said.getvalue(), "^fit: --parameter tip_force 1:2: .*tip_force=LOW:HIGH\n$")
        for words, word in (([TUBE, data, {"si_friction_dry": ("0.2N/m", "2N/m")}], "wdth is no series"),
                            ([TUBE, data, "si_friction_dry=0.2N/m:2N/m"], "give parameters by name"),
                            ([TUBE, data, {"si_frction_dry": (1, 2)}], "unknown option"),
                            ([TUBE, self.place / "none.csv", {"tip_force": (1, 2)}], "No such file"),
                            ([TUBE, data, {"tip_force": "0,1:2"}], "0,1: give a number with a point, 0.1"),
                            ([TUBE, data, {}], "what to look for")):
            with self.assertRaisesRegex(tendril.TendrilError, word):
                tendril.fit(*words, si_friction_dry=None if "si_friction_dry" in words[2] else "0.5N/m")

    def test_nothing_is_seen(self):
        """A rod that is straight for good, whatever its friction: its derivatives are 0 exactly."""
        data = self.place / "straight.csv"
        data.write_text("length,x1,x2\n3,2.01,0.04\n3,1,0.01\n3,1.5,0.03\n3,2.9,0.1\n")
        with self.assertRaisesRegex(tendril.TendrilError, "si_friction_dry: changes nothing of what was measured"):
            tendril.fit(ROOT / "docs/first/root.opts", data, {"si_friction_dry": ("0.05N/m", "5N/m")}, starts=0,
                        rod_cells=20, ts_rtol=1e-3)


if __name__ == "__main__":
    os.environ["TENDRIL"] = str(Path(sys.argv.pop(1)).resolve())
    unittest.main()

#!/usr/bin/env python3
# test: the package runs, reads, plots and sweeps
"""The Python package: runs, sweeps, what results can be turned into, pictures of several runs.

    test_package.py build/tendril        with .venv's python, or one that has what the package needs"""

import argparse
import contextlib
import html
import importlib.util
import io
import json
import os
import re
import shutil
import subprocess
import sys
import tempfile
import unittest
from dataclasses import replace
from pathlib import Path
from unittest import mock

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "support"))
from interpreter import ROOT, from_venv

sys.path.insert(0, str(ROOT / "scripts"))
try:
    import h5py
    import matplotlib
    import numpy as np
    import xarray
    from matplotlib.backends.backend_agg import FigureCanvasAgg

    import tendril
    from tendril import maps as map
    from tendril import __main__ as commands, films, runs, titles, units
    from tendril.units import in_laboratory
except ImportError as error:
    from_venv(error)

matplotlib.use("Agg")
SHORT = dict(rod_cells=40, ts_max_time=1, output_interval=0.25)
TUBE = dict(growth_type="feed", growth_initial_length="1cm", si_bending_stiffness="2.209 Nmm^2",
            si_friction_dry="0.5N/m", si_speed="5 mm/s", rod_cells=60, stop_length="6 cm",
            output_interval="1s")


class Package(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.directory = tempfile.TemporaryDirectory(prefix="tendril-")
        cls.place = Path(cls.directory.name)
        cls.tube = tendril.run(**TUBE)
        cls.runs = [tendril.run("feed", friction_mu=mu, **SHORT) for mu in (0, 1)]

    @classmethod
    def tearDownClass(cls):
        cls.directory.cleanup()

    def test_run(self):
        """What options say is what is run; the file is gone unless it is asked for."""
        r = tendril.run("feed", friction_mu=0.5, output=self.place / "kept.h5", **SHORT)
        self.assertEqual(r.attributes["parameters/friction_mu"], 0.5)
        self.assertEqual((r.name, r.finished, r.options["growth_type"]), ("kept", True, "feed"))
        self.assertEqual(tendril.load(self.place / "kept.h5").series.tip_x2[-1], r.series.tip_x2[-1])
        self.assertFalse(self.runs[0].path.exists())
        for wrong in (lambda: r.series["wdth"], lambda: r.series.wdth, lambda: r.minimum("wdth")):
            with self.assertRaisesRegex((KeyError, AttributeError), "no wdth here, did you mean .*width"):
                wrong()
        with self.assertRaisesRegex(AttributeError, "no width here; it is series.width"):
            r.width
        self.assertEqual(r.maximum("length"), (r.series.t[-1], r.series.length[-1]))
        self.assertRegex(repr(tendril.view(r)), "a page of .* MB")
        steps, nodes = len(r.series.t), r.shapes.x.shape[1]
        self.assertIn(f"tip_x1 [{steps}], ", repr(r.series))
        self.assertIn(f"x [{len(r.shapes.t)}, {nodes}, 2]", repr(r.shapes))
        options = ROOT / "options/feed.opts"
        self.assertEqual(tendril.run(options, friction_mu=0, **SHORT).series.tip_x2[-1],
                         self.runs[0].series.tip_x2[-1])
        two = tendril.run(dict(growth_type="feed", growth_initial_length=2, shape_amplitude=0.1),
                          friction_mu=0, **SHORT)
        self.assertEqual(two.series.tip_x2[-1], self.runs[0].series.tip_x2[-1])

    def test_errors_name_no_file_of_their_own(self):
        """Where run() makes files that are gone afterwards, no message names them."""
        with self.assertRaisesRegex(tendril.ResultsError, "^feed: runs from t = 0 to 1; there is no shape at 9"):
            self.runs[0].at(9)
        for name, value, word in (("wall_file", [("circle", 0, 3, 1)], "^wall_file, line 1: give circle"),
                                  ("rod_stiffness_file", {"distance": [0, 1]}, "^rod_stiffness_file: ")):
            with self.assertRaisesRegex(tendril.RunError, word):
                tendril.run("feed", **{name: value})

    def test_values(self):
        """Numbers to their last digit, units with a blank, pairs, flags, arrays as files."""
        words = runs.words_of({"a": 0.1, "-b": "5 mm/s", "c": [(0, 1), (3, 2.5)], "d": True, "e": None,
                               "f": np.float64(1e-17), "g": [1, 2], "h": np.int64(3),
                               "i": {"distance": [0, 1], "factor": [2, 3]}}, self.place)
        self.assertEqual(words[:-2], ["-a", "0.1", "-b", "5mm/s", "-c", "0:1,3:2.5", "-d", "true", "-f",
                                      "1e-17", "-g", "1,2", "-h", "3"])
        with h5py.File(words[-1]) as file:
            self.assertEqual(file["factor"][1], 3)

    def test_errors(self):
        with self.assertRaises(tendril.RunError) as refused:
            tendril.run("feed", frictoin_mu=1)
        self.assertEqual(str(refused.exception),
                         "frictoin_mu: unknown option, did you mean friction_mu?")
        self.assertIsNone(refused.exception.results)
        with self.assertRaises(tendril.RunError) as broken:
            tendril.run("feed", ts_max_steps=9, **SHORT)
        self.assertEqual(len(broken.exception.results.series.t), 10)
        with self.assertRaisesRegex(tendril.TendrilError, "no options file"):
            tendril.run("no-such-scene")
        with self.assertRaisesRegex(tendril.ResultsError, "with si_bending_stiffness"):
            self.runs[0].dataset(si=True)
        for call, line in (
                (lambda: tendril.run("fed"), "^fed: .*, did you mean feed"), (lambda: self.runs[0].scale("lenght"), "did you mean length"),
                (lambda: tendril.run(3), "^scene: give an"),
                (lambda: tendril.run("feed", output=3), "^output: give the name"),
                (lambda: tendril.run("feed", rod_weight="0 0 -1"), "^rod_weight 0 0 -1: put commas between numbers"),
                (lambda: tendril.run("feed", ranks=0), "^ranks 0: give a whole number from 1"),
                (lambda: tendril.load(3), "^load: give"), (lambda: self.runs[0].at([0, 1]), "give one time"),
                (lambda: self.runs[0].at(None), "^at None: give one time"),
                (lambda: tendril.critical("feed", task="grow"), "^critical: leaves no choice"),
                (lambda: tendril.sweep("feed", {"friction_mu": [0, 1]}, friction_mu=0.3), "^sweep: friction_mu is varied"),
                (lambda: tendril.sweep("feed", {"friction_mu": [0, 1]}, jobs=0), "^jobs 0: give"),
                (lambda: tendril.map(self.runs[0], "a,b"), "^map, without a sweep: give"),
                (lambda: tendril.ensemble(self.runs[0]), "^ensemble, without a sweep .*: give")):
            with self.subTest(line), self.assertRaisesRegex(tendril.TendrilError, line):
                call()
        place, os.environ["TENDRIL"] = os.environ["TENDRIL"], str(self.place / "none")
        try:
            with self.assertRaisesRegex(tendril.TendrilError, "no executable"):
                tendril.run("feed")
        finally:
            os.environ["TENDRIL"] = place

    def test_critical(self):
        """The exact length of the dry rod; the tube's in metres."""
        c = tendril.critical(friction_mu=1, growth_initial_length=0.5)
        self.assertAlmostEqual(c.length, 1.987133724512, delta=1e-9)
        self.assertFalse(c.flutters)
        tube = tendril.critical(**{k: v for k, v in TUBE.items() if k != "output_interval"
                                   and k != "stop_length"})
        self.assertTrue(tube.flutters)
        self.assertAlmostEqual(tube.in_si().length / tube.length, (2.209e-6 / 0.5) ** (1 / 3), 9)

    def test_units(self):
        """SI values are the file's times its scales; every unit of a file is known."""
        r = self.tube
        table = r.dataset(si=True)
        self.assertIsInstance(table, xarray.Dataset)
        self.assertEqual((table.width.attrs["units"], table.x.attrs["units"]), ("m", "m"))
        self.assertAlmostEqual(float(table.length[-1]), 0.06, 12)
        force = 0.5 * (2.209e-6 / 0.5) ** (1 / 3)
        np.testing.assert_allclose(table.base_force_1, r.series.base_force_1 * force, rtol=1e-12)
        np.testing.assert_allclose(table.curvature, r.shapes.curvature * 0.5 / force, rtol=1e-12)
        self.assertEqual(table.x.dims, ("shape_t", "s", "axis"))
        self.assertEqual(table.x.sel(axis="x1", s=1, shape_t=table.shape_t[-1]),
                         r.shapes.x[-1, -1, 0] * force / 0.5)
        named = {u: in_laboratory(u, r.scale)[1] for u in r.units.values()}
        self.assertEqual({u for u, si in named.items() if u == si}, {"1", "rad"})
        self.assertEqual(r.dataset().width.attrs["units"], "l")
        slow = tendril.run({k: v for k, v in TUBE.items() if k not in ("si_speed", "output_interval")})
        table = slow.dataset(si=True)  # what has no scale is left out, the time stays as it is
        self.assertEqual((table.width.attrs["units"], table.t.attrs["units"]), ("m", "l/V"))
        self.assertNotIn("tip_speed", table)

    @classmethod
    def spun(cls):
        """A rod in space, fed and turned at its clamp; run once."""
        if not hasattr(cls, "wire"):
            cls.wire = tendril.run(growth_type="feed", growth_initial_length=1, rod_curvature=0.6, clamp_spin="60deg",
                                   friction_radius=0.05, shape_type="straight", rod_cells=60, ts_max_time=6,
                                   output_interval=0.25)
        return cls.wire

    def test_space(self):
        """A rod in space has three coordinates and directors, vectors have an axis, strains a component; a
        shape between stored ones keeps its directors at right angles."""
        r = tendril.run(**SHORT, rod_weight="0,-0.1,-0.2")
        self.assertEqual(r.at(1).x.shape, (41, 3))
        self.assertAlmostEqual(r.at(1).x[-1, 2], r.series.tip_x3[-1], 12)
        r = self.spun()
        shape = r.at(5.9)
        self.assertFalse(shape.stored)
        frame = np.stack([shape.d1, shape.d2, shape.d3], 1)
        np.testing.assert_allclose(frame @ frame.transpose(0, 2, 1), np.broadcast_to(np.eye(3), frame.shape), atol=1e-12)
        np.testing.assert_allclose(shape.d1[1:-1], np.gradient(shape.x, shape.s, axis=0)[1:-1] / shape.length, atol=0.01)
        table = r.dataset()
        self.assertEqual(table.x.dims, ("shape_t", "s", "axis"))
        self.assertEqual(table.strain.dims, ("shape_t", "s", "component"))
        np.testing.assert_array_equal(table.strain.sel(component="u1"), r.shapes.strain[..., 0])
        np.testing.assert_array_equal(table.d2.sel(axis="x3"), r.shapes.d2[..., 2])
        self.assertNotIn("component", tendril.run(**SHORT).dataset().dims)
        s = tendril.sweep(dict(SHORT, rod_weight="0,-0.1,-0.2"), {"friction_mu": [0.5, 1]})
        self.assertEqual((s.failed, [r.in_space for r in s.members]), ([], [True, True]))

    def test_strands_that_touch(self):
        """Of two that lie on each other, some three points thick, each is paler than the line between them."""
        from types import SimpleNamespace

        import matplotlib.pyplot as plt

        from tendril.walls import draw_rod

        figure = plt.figure(figsize=(2, 2), dpi=400)
        ax = figure.add_axes((0, 0, 1, 1), xlim=(-1, 1), ylim=(-1, 1), autoscale_on=False)
        x, thick = np.linspace(-2, 2, 201), 3 / 72  # of two inches, two long
        draw_rod(ax, SimpleNamespace(diameter=thick),
                 np.concatenate([np.c_[x, 0 * x - thick / 2], np.c_[x[::-1], 0 * x + thick / 2]]), color="#000000")
        canvas = FigureCanvasAgg(figure)
        canvas.draw()
        column = np.asarray(canvas.buffer_rgba())[:, 400, 0].astype(int)
        self.assertLess(column[399:401].max(), 30)  # the rims between them
        self.assertGreater(min(column[399 - 8], column[400 + 8]), 100)  # and each strand's middle
        plt.close(figure)

    def test_space_plots(self):
        """In perspective with true lengths, from where one looks; three views, curvature and twist along the
        rod; what is of space only is refused to a rod in the plane."""
        r = self.spun()
        figure = tendril.plot(r)
        self.assertEqual([ax.name for ax in figure.axes], ["3d"] + 3 * ["rectilinear"])
        twist = figure.axes[3].lines[-1]
        np.testing.assert_allclose(twist.get_ydata(), r.shapes.strain[-1, :, 0])
        self.assertAlmostEqual(twist.get_xdata()[-1], r.series.length[-1], 2)
        for ax, axes in zip(tendril.plot(r, "shapes,side,front").axes, ((0, 1), (0, 2), (1, 2))):
            np.testing.assert_allclose(np.transpose(ax.lines[3].get_data()), r.shapes.x[-1][:, axes])
        for view, same in (((0, 0), "x1,x3"), ((90, 0), "x2,x3"), ((0, 89.9), "x1,x2")):
            figure = tendril.plot(r, "space", view=view)
            FigureCanvasAgg(figure).draw()
            rods = next(c for c in figure.axes[0].collections if hasattr(c, "strands"))
            middle = np.mean(np.reshape(figure.axes[0].get_w_lims(), (3, 2)), axis=1)
            flat = [figure.axes[0].transData.transform(rods.seen((middle + step)[None])[0])[0]
                    for step in (*(0.01 * np.eye(3)), np.zeros(3))]
            long = np.linalg.norm(np.subtract(flat[:3], flat[3]), axis=1)
            a, b = (int(name[1]) - 1 for name in same.split(","))
            self.assertAlmostEqual(long[a] / long[b], 1, 2)
            self.assertLess(long[3 - a - b], 0.05 * long[a])
            self.assertAlmostEqual(rods.scale(middle[None])[0] * figure.dpi / 72 * 0.01 / long[a], 1, 2)
        low, high = tendril.plot(r, "norm").axes[0].get_ylim()  # x3 begins from rounding: that sets no axis
        self.assertGreater(low, 1e-3 * r.series.norm_x2.min())
        self.assertGreater(high, r.series.norm_x3.max())
        with self.assertRaisesRegex(tendril.ResultsError, "two angles"):
            tendril.plot(r, "space", view="30")
        for panel in ("side", "front"):
            with self.assertRaisesRegex(tendril.ResultsError, "a rod in the plane"):
                tendril.plot(self.tube, panel)
        self.assertEqual(tendril.plot(self.tube, "space").axes[0].name, "3d")

    def test_panels_in_perspective_fill_their_places(self):
        """What is seen is as wide or as high as the place of a panel, and above it stands nothing but its letter and its legend."""
        from tendril.perspective import seen_box

        for view in ((20, 20), (0, 80)):
            figure = tendril.plot(self.spun(), "space,norm", view=view)
            ax, beside = figure.axes
            place, seen = ax.head.bbox, seen_box(ax)
            self.assertAlmostEqual(max(seen.width / place.width, seen.height / place.height), 1, 1)
            self.assertTrue(place.padded(3).contains(seen.x0, seen.y0) and place.padded(3).contains(seen.x1, seen.y1))
            self.assertEqual(ax.head.get_title(loc="left"), "(a)")
            self.assertGreater(len(ax.head.get_legend().get_texts()), 3)
            self.assertAlmostEqual(place.height, beside.bbox.height, delta=0.4 * place.height)

    def test_layers_soft_ends_and_whole_stones_are_seen(self):
        layered = tendril.run("root-layers", rod_cells=40, ts_max_time=3, progress=False)
        ax = tendril.plot(layered, "shapes").axes[0]
        FigureCanvasAgg(ax.figure).draw()
        (layers,) = [artist for artist in ax.artists if hasattr(artist, "layers")]
        self.assertEqual(layers.layers, [(0, 0.3), (3, 4), (7, 1)])
        soft = tendril.plot(tendril.run("catheter", rod_cells=40, ts_max_time=2, progress=False), "shapes").axes[0]
        wide = soft.collections[-1].get_linewidth()
        self.assertLess(wide[-1], 0.6 * wide[0])
        beside = tendril.run(None, growth_type="feed", contact_diameter=0.05, rod_cells=20, ts_max_time=1, wall_file=["circle 1 0.45 0.4 outside"], progress=False)
        self.assertGreater(tendril.plot(beside, "shapes").axes[0].get_ylim()[1], 0.84)

    def test_space_numbers(self):
        """The numbers of an axis that is seen short do not run together, and there are two at least, if there is room for them."""
        from matplotlib import pyplot as plt

        from tendril.perspective import furnish

        for high, view in (((5, 1.5, 1.5), (20, 20)), ((5, 1.5, 1.5), (70, 20)), ((1, 0.3, 0.3), (20, 20)),
                           ((3, 3, 3), (20, 35)), ((3, 3, 3), (5, 5))):
            figure = plt.figure(figsize=(3.3, 2.6), dpi=100)
            ax = figure.add_subplot(projection="3d")
            furnish(ax, (-0.05, -high[1] / 2, -high[2] / 2), (high[0], high[1] / 2, high[2] / 2), 3, view, str)
            canvas = FigureCanvasAgg(figure)
            canvas.draw()
            for axis in (ax.xaxis, ax.yaxis, ax.zaxis):
                boxes = [tick.label1.get_window_extent(canvas.get_renderer()) for tick in axis.get_major_ticks()
                         if tick.label1.get_text()]
                self.assertGreater(len(boxes), 1)
                for one, other in zip(boxes, boxes[1:]):
                    self.assertFalse(one.padded(-1).overlaps(other.padded(-1)), (high, view, axis.axis_name))
            plt.close(figure)

    def test_space_nearer_hides(self):
        """Of two rods that cross the nearer is seen, whichever is drawn first."""
        import matplotlib.pyplot as plt

        from tendril.perspective import Rods, Strand, furnish

        near = Strand(np.array([[x, -1, 0] for x in np.linspace(-1, 1, 11)]), "red", 0.4)
        far = Strand(np.array([[0, 1, z] for z in np.linspace(-1, 1, 11)]), "blue", 0.4)
        for strands in ([near, far], [far, near]):
            figure = plt.figure(figsize=(2, 2), dpi=100)
            ax = figure.add_subplot(projection="3d")
            furnish(ax, -np.ones(3), np.ones(3), 3, (0, 0), str)
            rods = ax.add_collection(Rods(strands, zorder=3), autolim=False)
            canvas = FigureCanvasAgg(figure)
            canvas.draw()
            x, y = ax.transData.transform(rods.seen(np.array([[0, -1, 0]]))[0])[0].astype(int)
            red, _, blue, _ = np.asarray(canvas.buffer_rgba())[200 - y, x]  # with light on it
            self.assertTrue(red == 255 and blue < 100, (red, blue))
            plt.close(figure)

    def test_space_film(self):
        """A frame a shape; the view turns if that is asked for, else the axes stay; fields that there are not are
        refused."""
        from PIL import Image

        r, films = self.spun(), {}
        for turn in (0, 90):
            file = self.place / f"film-{turn}.gif"
            self.assertEqual(tendril.animate(r, file, frames=3, turn=turn, field="twist"), 3)
            with Image.open(file) as film:
                self.assertEqual(film.n_frames, 3)
                films[turn] = [np.asarray(film.convert("L")) for k in range(3) if film.seek(k) is None]
        low = np.s_[-170:-40, 50:-150]  # axes with their numbers, below the rod
        self.assertEqual(films[90][0].shape, (550, 660))
        self.assertLess(np.mean(films[0][0][low] != films[0][1][low]), 0.03)
        self.assertGreater(np.mean(films[90][0][low] != films[90][1][low]), 0.05)
        with self.assertRaisesRegex(tendril.ResultsError, "field colour: give one of axial"):
            tendril.animate(r, self.place / "none.gif", field="colour")
        with self.assertRaisesRegex(tendril.ResultsError, "a rod in the plane"):
            tendril.animate(self.tube, self.place / "none.gif", turn=90)

    def test_wrong_values(self):
        """What is no wall, no numbers or no text of UTF-8 ends in a line; a map of a sweep over more than its two options
        would show one of several runs at each place; a sweep's members know their seconds."""
        steel = {"distance": [0, 1, 2, 3], "factor": [1, 1, 1, 1]}
        for words, options in (("wall_file: 3 is no wall", dict(wall_file=("circle", 3, 0, 1, "outside"))),
                               (r"wall_file: \[\] is no wall", dict(wall_file=[[]])),
                               (r"wall_file: None is no wall", dict(wall_file=[None])),
                               (r"wall_file: \['circle', 3, \[0, \[1\]\].* is no wall",
                                dict(wall_file=[["circle", 3, [0, [1]], 1, "outside"]])),
                               ("wall_file: give the name of a file, or a list", dict(wall_file={"a": 1})),
                               ("factor: give numbers", dict(rod_stiffness_file=steel | {"factor": ["stiff"] * 4})),
                               ("factor: give numbers", dict(friction_field={"factor": [[1, 2, 3], [1]]}))):
            with self.assertRaisesRegex(tendril.TendrilError, words):
                tendril.run("feed", **SHORT, **options)
        with self.assertRaisesRegex(tendril.TendrilError, "friction_mu: give two bounds"):
            tendril.fit("feed", self.runs[0].frame(), {"friction_mu": 0.5})
        scene = self.place / "latin.opts"
        scene.write_bytes("# Größe, that's all\n-growth_type feed\n-rod_cells 40\n-ts_max_time 1\n".encode("latin-1"))
        self.assertEqual(tendril.run(scene).series.length[-1], 1.5)
        whole = tendril.run("feed", output=self.place / "whole.h5", **SHORT).path
        with self.assertRaisesRegex(tendril.TendrilError, "whole.h5"):
            tendril.run(whole)
        corners = [("polygon", [(2, -1), (3, -1), (3, 1)], "outside"), ("circle", (9, 9), 1, "outside")]
        self.assertEqual([runs.text_of_wall(wall) for wall in corners], ["polygon 2 -1 3 -1 3 1 outside", "circle 9 9 1 outside"])
        over = {"friction_mu": [0, 1], "growth_initial_length": [1, 2], "shape_amplitude": [0.01, 0.2]}
        with self.assertRaisesRegex(tendril.TendrilError, "several runs are at friction_mu 0, .* of shape_amplitude"):
            tendril.map(tendril.sweep("feed", over, **SHORT), ("friction_mu", "growth_initial_length"), "width")
        stiff = tendril.sweep(TUBE | {"stop_length": "2 cm"}, {"si_friction_dry": ["0.5N/m", "1N/m"]}).members[1]
        self.assertAlmostEqual(stiff.at("1s").t, 1 / stiff.scale("time"))
        tendril.plot(stiff, "width", si=True)

    def test_moving_walls(self):
        """Walls that move are drawn where they are: a drum, whose axis is carried along, a belt, which moves along
        itself, and a post that comes up with the rod, which follows it."""
        from tendril.solids import solids

        r = tendril.run(growth_type="none", growth_initial_length=2, shape_type="straight", rod_curvature=0.1, rod_cells=40,
                        contact_diameter=0.1, ts_max_time=1, output_shapes=4, wall_file=[
                            "cylinder 1.4 -0.4 -1 0 0 1 0.2 outside 2 moves 0 0.5 0 turns 90deg 1 0 0 0 0 1 friction 0.3",
                            "plane 0 -2 0 0 1 0 moves 1 0.1 0"])
        drum, belt = ([one.at(t).vertices.mean(axis=0) for t in (0, 1)] for one in solids(r))
        np.testing.assert_allclose(drum, [[1.4, -0.4, 0], [1.4, 0.9, 0]], atol=1e-6)
        np.testing.assert_allclose(belt[1] - belt[0], [0, 0.1, 0], atol=1e-12)
        tendril.plot(r, "space,shapes", times=[0, 1])
        self.assertEqual(tendril.animate(r, self.place / "drum.gif", frames=2), 2)
        self.assertIn('"turns": [1.57', str(tendril.view(r)._repr_html_()).replace("&quot;", '"'))

    def test_walls_in_perspective(self):
        """A wall is drawn as far as the box round the rods, cut there; runs beside each other are drawn in one box."""
        from tendril.solids import Surface, within

        square = Surface(np.array([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0.0]]), np.array([[0, 1, 2], [0, 2, 3]]), [])
        for low, high, area in (((0, -0.5, -1), (2, 0.25, 1), 0.75), ((-2, -2, -2), (2, 2, 2), 4), ((0.25, 0, 0.5), (1, 1, 1), 0)):
            parts, _ = within(square, np.array(low), np.array(high))
            crosses = (np.cross(part[1:-1] - part[0], part[2:] - part[0]).sum(axis=0) for part in parts)
            self.assertAlmostEqual(sum(np.linalg.norm(cross) / 2 for cross in crosses), area, places=14)
            for part in parts:
                self.assertTrue(np.all((part >= low) & (part <= high)))
        short, long = (tendril.run(growth_type="none", growth_initial_length=length, rod_model="space", ts_max_time=0.1, rod_cells=20)
                       for length in (1, 3))
        left, right = tendril.plot([short, long], "space", times=[0.1]).axes
        self.assertEqual([left.get_xlim(), left.get_zlim()], [right.get_xlim(), right.get_zlim()])
        self.assertGreater(left.get_xlim()[1], 2.9)

    def test_endless_walls_that_move(self):
        """A plane that moves and turns is drawn where it is, and what has no end stays under the rod: a plane, a rod
        that moves along itself, and what turns about an axis far away. A page draws the same."""
        from tendril.solids import Reach, drawn

        reach, ahead, moved = Reach(np.array([0, -1, -1.0]), np.array([4, 1, 1.0])), np.array([2, 0, 0.0]), []
        quarter = f"turns {np.pi / 2!r}"
        for line, on, at in (
                (f"plane 0 0 0 0 0 1 moves 1 0 0 {quarter} 0 0 0 0 1 0", lambda x: x[:, 0] - 1, [1, 0, 0]),
                (f"plane 0 0 -1 0 0 1 {quarter} 0 50 0 0 0 1", lambda x: x[:, 2] + 1, [2, 0, -1]),
                (f"cylinder 0 0 0 1 0 0 0.5 outside moves 5 0 0 {quarter} 0 0 0 1 0 0", lambda x: np.hypot(x[:, 1], x[:, 2]) - 0.5, ahead),
                (f"cylinder 0 0 0 1 0 0 0.5 outside moves -88 -90 0 {quarter} 0 90 0 0 0 1", lambda x: np.hypot(x[:, 0] - 2, x[:, 2]) - 0.5, ahead),
                ("cylinder 0 0 0 1 0 0 0.5 outside 4 moves 5 0 0", lambda x: np.hypot(x[:, 1], x[:, 2]) - 0.5, [7, 0, 0])):
            (surface,) = drawn(line, None, reach)
            then = surface.at(1)
            for points in (then.vertices, *then.lines):
                np.testing.assert_allclose(on(points), 0, atol=1e-12, err_msg=line)
            middle = (then.vertices.min(axis=0) + then.vertices.max(axis=0)) / 2
            np.testing.assert_allclose(middle, at, atol=1e-12, err_msg=line)
            np.testing.assert_allclose(surface.at(0).vertices, surface.vertices, atol=1e-13)
            moved.append((surface, 1))
        self.check_page_carries(moved)

    def test_walls_that_move_in_time(self):
        """A wall that moves by rows is drawn where it is: at rest before the first and behind the last, by rates on and on. A
        page draws the same, and the file has the rows whatever gave them; the rod that it pushes is where it is."""
        from tendril.solids import Reach, drawn, solids

        reach, ball, moved = Reach(np.array([0, -1, -1.0]), np.array([4, 1, 1.0])), "sphere 0 0 0 0.5 outside", []
        for line, places in (
                (f"{ball} moves at 0.5 1 0 0 1 2 0 0 2 2 1 4 3 2 0 4", {0: [0, 0, 0], 0.5: [0, 0, 0], 1: [1, 0, 0], 9: [1, 0, 4]}),
                (f"{ball} moves at -1 0 0 0 1 2 0 0 3 4 0 0", {0: [0, 0, 0], 1: [1, 0, 0], 2: [2, 0, 0], 9: [3, 0, 0]}),
                (f"{ball} turns at 0.5 7 1 {7 + np.pi / 2!r} about 2 0 0 0 0 1", {0.5: [0, 0, 0], 1: [2, -2, 0], 9: [2, -2, 0]}),
                (f"{ball} turns spin 1 {np.pi / 2!r} 2 {np.pi / 2!r} about 2 0 0 0 0 1 moves at 0 0 0 0 1 0 0 1",
                 {0: [0, 0, 0], 1: [2, -2, 1], 2: [4, 0, 1], 9: [2, -2, 1]})):
            (surface,) = drawn(line, None, reach)
            for t, place in places.items():
                np.testing.assert_allclose(surface.at(t).vertices.mean(axis=0), place, atol=1e-9, err_msg=f"{line} at {t}")
            moved += [(surface, t) for t in (0, 0.6, 1, 1.7, 9)]
        self.check_page_carries(moved)
        (self.place / "press.csv").write_text("t,x2\n0.2,0\n0.6,0.3\n0.8,0.3\n1,0.1\n")
        r = tendril.run(growth_type="none", growth_initial_length=2, shape_type="straight", rod_curvature=-0.02, rod_model="space",
                        rod_cells=40, contact_diameter=0.1, ts_max_time=1.2, output_interval=0.1, wall_file=[
                            f"sphere 1.5 -0.5 0 0.4 outside moves {self.place / 'press.csv'} friction 0.2"])
        self.assertIn("moves at 0.2", str(r.attributes["walls"]).replace("0.20000000000000001", "0.2"))
        (post,) = solids(r)
        for shape in (r.stored(k) for k in range(len(r.shapes.t))):
            top = post.at(shape.t).vertices.mean(axis=0)
            gap = np.linalg.norm(shape.x - top, axis=1).min() - 0.45
            self.assertGreater(gap, -1e-3)
            if 0.45 < shape.t < 0.85:
                self.assertLess(gap, 2e-3)  # between nodes
        self.assertEqual(tendril.animate(r, self.place / "press.gif", frames=2), 2)
        tendril.plot(r, "space,shapes", times=[0, 0.7])
        self.assertIn('"shift": {"knots"', str(tendril.view(r)._repr_html_()).replace("&quot;", '"'))

    def check_page_carries(self, moved):
        """The page's `carried` takes surfaces to where they are at times; nothing without node."""
        if not (node := shutil.which("node")):
            return
        web = ROOT / "scripts/tendril/web"
        scripts = [(web / name).read_text() for name in ("three/three.min.js", "format.js", "drawing.js", "data.js", "space.js")]
        empty = "globalThis.document = { getElementById: () => ({ textContent: '{\"runs\": [], \"up\": 3}' }) };"  # a page of no run
        given = json.dumps([({"motion": {what: numbers.tolist() for what, numbers in surface.motion.items()},
                              "positions": surface.vertices.ravel().tolist(), "lines": []}, t) for surface, t in moved])
        text = "\n".join([empty, *scripts, f"console.log(JSON.stringify({given}.map(([one, t]) => Array.from(carried(one, t).positions))));"])
        done = subprocess.run([node, "-"], input=text, text=True, capture_output=True)
        self.assertEqual(done.returncode, 0, done.stderr[-500:])
        found = json.loads(done.stdout)
        self.assertEqual(len(found), len(moved))
        for places, (surface, t) in zip(found, moved):
            np.testing.assert_allclose(np.reshape(places, (-1, 3)), surface.at(t).vertices, atol=2e-5, err_msg=f"{surface.motion} at {t}")

    def test_vtk(self):
        """What VTK reads back is what the file has, of rods in space and in the plane."""
        try:
            from vtkmodules.util.numpy_support import vtk_to_numpy
            from vtkmodules.vtkIOXML import vtkXMLPolyDataReader
        except ImportError:
            self.skipTest("vtk is not installed")
        for r, t in ((self.spun(), 3), (self.spun(), None), (self.tube, None)):
            file = self.place / "rod.vtp"
            r.to_vtk(file, t)
            reader = vtkXMLPolyDataReader()
            reader.SetFileName(str(file))
            reader.Update()
            body, shape = reader.GetOutput(), r.stored(-1) if t is None else r.at(t)
            x = vtk_to_numpy(body.GetPoints().GetData())
            np.testing.assert_array_equal(x[:, :shape.x.shape[1]], shape.x)
            self.assertEqual((body.GetNumberOfLines(), body.GetCell(0).GetNumberOfPoints()), (1, len(shape.s)))
            data = {name: vtk_to_numpy(body.GetPointData().GetArray(name))
                    for name in ("s", "force", "curvature", "d1", "axial")}
            np.testing.assert_array_equal(data["force"][:, :shape.x.shape[1]], shape.force)
            np.testing.assert_array_equal(data["curvature"], np.abs(shape.curvature))
            np.testing.assert_allclose(np.sum(data["force"] * data["d1"], axis=1), data["axial"], atol=1e-12)
            if r is self.wire:
                moment = vtk_to_numpy(body.GetPointData().GetArray("moment"))
                np.testing.assert_array_equal(moment, shape.moment)
            self.assertEqual(body.GetFieldData().GetArray("TimeValue").GetValue(0), shape.t)
        si = self.tube.to_vtk(si=True)
        np.testing.assert_allclose(vtk_to_numpy(si.GetPoints().GetData())[:, 0],
                                   self.tube.shapes.x[-1][:, 0] * self.tube.scale("length"))
        with self.assertRaisesRegex(tendril.ResultsError, "ends in .vtp"):
            self.tube.to_vtk(self.place / "rod.vtu")

    def test_walls_exported(self):
        """The surfaces around a rod go where it goes, each triangle with the number of its surface: one that moves is
        where it is then."""
        try:
            import trimesh
            from vtkmodules.util.numpy_support import vtk_to_numpy
        except ImportError:
            self.skipTest("vtk or trimesh is not installed")
        r = replace(self.spun(), attributes=dict(self.spun().attributes))
        r.attributes["walls"] = ("sphere 1 1 1 0.4 outside friction 0\n"
                                 "cylinder 2 0 -1 0 0 1 0.3 2 outside moves 0.5 0 0 friction 0.3")
        body = r.to_vtk(self.place / "walls.vtp", 2, walls=True)
        x = vtk_to_numpy(body.GetPoints().GetData())
        cells = vtk_to_numpy(body.GetPolys().GetConnectivityArray()).reshape(-1, 3)
        of = vtk_to_numpy(body.GetCellData().GetArray("surface"))
        self.assertEqual(body.GetFieldData().GetArray("TimeValue").GetValue(0), 2)
        size = np.linalg.norm
        np.testing.assert_allclose(size(x[cells[of == 0]] - 1, axis=-1), 0.4)
        np.testing.assert_allclose(size(x[cells[of == 1]][..., :2] - [3, 0], axis=-1), 0.3)
        self.assertEqual(set(of), {0, 1})
        self.assertTrue((self.place / "walls.vtp").is_file())
        r.to_mesh(self.place / "walls.glb", 2, walls=True)
        solid = trimesh.load(self.place / "walls.glb", force="mesh")
        np.testing.assert_allclose(solid.bounds, [[0.6, -0.3, -1], [3.3, 1.4, 1.4]], atol=2e-3)
        with self.assertRaisesRegex(tendril.ResultsError, "has no walls"):
            self.tube.to_vtk(walls=True)

    def test_mesh(self):
        """The tube that others read is closed, has the rod's length and diameter, and its colours."""
        try:
            import trimesh
        except ImportError:
            self.skipTest("trimesh is not installed")
        r = self.spun()
        true = np.pi / 4 * 0.1**2 * r.series.length[-1]
        for ending in ("glb", "gltf", "obj", "ply", "stl"):
            file = self.place / f"rod.{ending}"
            r.to_mesh(file, field="twist", sides=48)
            body = trimesh.load(file, force="mesh")
            self.assertTrue(body.is_watertight, ending)
            self.assertAlmostEqual(body.volume / true, 1, delta=0.01)
            near = np.linalg.norm(body.vertices[:, None] - r.shapes.x[-1], axis=2).min(axis=1)
            self.assertLess(near.max(), 0.0501 + r.series.length[-1] / 60 / 2)
            if ending in ("glb", "ply"):
                self.assertGreater(len(np.unique(body.visual.vertex_colors, axis=0)), 20, ending)
        flat = self.tube.to_mesh(t="5s").bounds[:, 2]  # a rod in the plane has as much above it as below
        self.assertAlmostEqual(flat[0] / flat[1], -1, 9)
        for given, line in (({"path": "rod.xyz"}, "ends in .glb"), ({"field": "taste"}, "give one of axial"),
                            ({"diameter": -1}, "give more than 0")):
            with self.assertRaisesRegex(tendril.ResultsError, line):
                r.to_mesh(**given)

    def test_between(self):
        """A shape between stored ones is where a run that stored it there has it; of too few, and outside,
        there is none."""
        rod = dict(growth_type="feed", growth_initial_length=2, shape_amplitude=0.1, rod_cells=100, ts_max_time=8)
        r, fine = tendril.run(rod), tendril.run(rod, output_interval=0.27)
        self.assertEqual(len(r.shapes.t), 81)
        for k in range(1, len(fine.shapes.t)):
            shape = r.at(fine.shapes.t[k])
            self.assertLess(np.abs(shape.x - fine.shapes.x[k]).max(), 0.003 * shape.length)
        self.assertEqual([r.at(t).stored for t in (0, 4, 4.01)], [True, True, False])
        for t in (-0.1, 8.1):
            with self.assertRaisesRegex(tendril.ResultsError, "runs from t = 0 to 8"):
                r.at(t)
        few = tendril.run(rod, output_shapes=1)
        self.assertEqual(len(few.shapes.t), 2)
        with self.assertRaisesRegex(tendril.ResultsError, "too few shapes"):
            few.at(4)
        self.assertEqual(few.at(5, nearest=True).t, 8)
        with self.assertRaisesRegex(tendril.RunError, "leave one out"):
            tendril.run("feed", output_shapes=3)

    def test_shapes_of_the_program(self):
        """A run that keeps a file stores 41 shapes up to its end, also where a length ends it; a member of
        a sweep two."""
        file = self.place / "plain.h5"
        for words, end in ((("-ts_max_time", "2"), 2.0), (("-stop_length", "1.3"), 0.8)):
            subprocess.run([runs.executable(), "-rod_cells", "30", "-quiet", "-output", file, *words], check=True)
            np.testing.assert_allclose(tendril.load(file).shapes.t, np.linspace(0, end, 41), atol=1e-9)
        rod = dict(growth_type="feed", rod_cells=30)
        tendril.run(rod, ts_max_time=1, output=file)  # 80 shapes, which a restart is not held to
        for more in (dict(output_interval=0.5), dict(output_shapes=4)):
            on = tendril.run(rod, ts_max_time=2, restart=file, output=self.place / "on.h5", **more)
            np.testing.assert_allclose(on.shapes.t[-3:], [1, 1.5, 2])
        s = tendril.sweep({}, {"ts_max_time": [0.5]}, rod_cells=30)
        self.assertEqual(list(s.members[0].shapes.t), [0, 0.5])

    def test_tasks_in_files(self):
        """A scene whose file says another task than to grow is run as it is."""
        self.assertAlmostEqual(float(tendril.run("critical").critical["length"]), 1.987133724512, delta=1e-9)

    def test_walls(self):
        """Walls as values are those of a file."""
        lines = [tendril.plane((3, 0), (-1, 0)), tendril.circle(("2.6", 0.25), 0.7, friction=0.3),
                 tendril.polygon([(1, -2), (2, -2), (2, -1)]), tendril.conduit(0.5, [(-0.5, 0), (3.5, 0)])]
        self.assertEqual(lines, ["plane 3 0 -1 0", "circle 2.6 0.25 0.7 outside friction 0.3",
                                 "polygon outside 1 -2 2 -2 2 -1", "path 0.5 -0.5 0 3.5 0"])
        r = tendril.run("feed", contact_diameter=0.1, wall_file=[lines[0]], rod_cells=40, ts_max_time=0.1,
                        output_interval=0.1)
        self.assertEqual(r.attributes["walls"].split()[:5], ["plane", "3", "0", "-1", "0"])
        self.assertEqual(runs.words_of({"wall_file": lines[1]}, self.place),  # one by itself
                         runs.words_of({"wall_file": lines[1:2]}, self.place))
        self.assertEqual(runs.words_of({"wall_file": "my walls.txt"}, self.place), ["-wall_file", "my walls.txt"])
        with self.assertRaisesRegex(tendril.TendrilError, "circle: centre"):
            tendril.circle(3, 1)

    def test_what_is_given_to_draw(self):
        """One line for what cannot be drawn; names of files, critical lengths, a sweep, somebody's axes."""
        import matplotlib.pyplot as plt

        for draw in (tendril.plot, tendril.view):
            for wrong in ([], 5, self.place / "none.h5"):
                with self.assertRaisesRegex(tendril.TendrilError, "(no run|not int|no such file)"):
                    draw(wrong)
        for wrong, words in (({"panels": 7}, "panels: give names"), ({"overlay": "yes"}, "overlay: give True or False"), ({"none": 1}, "plot: .*none")):
            with self.assertRaisesRegex(tendril.TendrilError, words):
                tendril.plot(self.tube, **wrong)
        figure = tendril.plot(tendril.critical("feed"))
        self.assertEqual(len(figure.axes), 1)
        ax = plt.figure().subplots()
        self.assertIs(tendril.plot(self.runs, "width", ax=ax), ax.figure)
        np.testing.assert_array_equal(ax.lines[1].get_ydata(), self.runs[1].series.width)
        plt.close(ax.figure)
        self.assertIn("srcdoc", self.tube._repr_html_())
        self.assertIn("width", dir(self.tube.series))
        many = tendril.plot([self.tube] * 9, "width", overlay=True)
        self.assertEqual(len(many.axes[0].lines), 9)

    def test_colours(self):
        """No two of runs drawn together are the same, however many."""
        from tendril.pictures import colours

        for count in (2, 7, 8, 20):
            self.assertEqual(len(set(colours(count))), count)

    def test_a_disk_that_is_full(self):
        """What cannot be written whole leaves an older file as it was, nothing beside it, and one line that names it.
        (Python itself would leave its compiled modules cut short, and stumble over them from then on.)"""
        tendril.run("feed", output=self.place / "kept.h5", **SHORT)
        place = self.place / "full"
        place.mkdir()
        for command, name in (("view", "page.html"), ("plot", "panels.png")):
            (place / name).write_text("older")
            done = subprocess.run(["bash", "-c", 'ulimit -f 20; exec "$@"', "-", sys.executable, "-m", "tendril", command,
                                   str(self.place / "kept.h5"), "--output", str(place / name)], capture_output=True, text=True,
                                  env=os.environ | {"PYTHONDONTWRITEBYTECODE": "1"})
            self.assertEqual(done.returncode, 1)
            self.assertRegex(done.stderr, rf"^{command}: {place / name}: File too large\n$")
            self.assertEqual((place / name).read_text(), "older")
        self.assertEqual({file.name for file in place.iterdir()}, {"page.html", "panels.png"})

    def test_csv(self):
        self.tube.to_csv(self.place / "tube.csv", si=True)
        head, *rows = (self.place / "tube.csv").read_text().splitlines()
        self.assertEqual(head.split(",")[:2], ["t (s)", "length (m)"])
        self.assertIn("width (m)", head)
        self.assertEqual(len(rows), len(self.tube.series.t))
        frame = self.runs[0].frame()
        np.testing.assert_array_equal(frame["norm_x2"], self.runs[0].series.norm_x2)

    def test_sweep(self):
        """Each member is the run with these options; one that is refused is told, the others stay."""
        s = tendril.sweep("feed", {"friction_mu": [0, 1, 2], "growth_initial_length": [2, 1]},
                          directory=self.place / "sweep", **SHORT)
        self.assertEqual(s.members.shape, (3, 2))
        self.assertEqual(s.members[1, 0].series.tip_x2[-1], self.runs[1].series.tip_x2[-1])
        self.assertEqual([point["friction_mu"] for point, _ in s.failed], [2, 2])
        self.assertIn("too large", str(s.failed[0][1]))
        table = s.dataset()
        self.assertEqual(float(table.width.sel(friction_mu=0, growth_initial_length=2)),
                         self.runs[0].series.width[-1])
        self.assertTrue(np.isnan(table.width.sel(friction_mu=2)).all())
        kept = tendril.load(self.place / "sweep/sweep.h5")
        self.assertEqual((kept.over, kept.members.shape), (s.over, s.members.shape))
        self.assertEqual(kept.members[1, 0].series.width[-1], self.runs[1].series.width[-1])
        np.testing.assert_array_equal(kept.members[1, 0].at(1).x, self.runs[1].at(1).x)
        self.assertFalse("x" in dict.keys(kept.shapes) and "energy" in dict.keys(kept.series))  # not read yet
        self.assertEqual(kept.dataset().width.dims, ("friction_mu", "growth_initial_length"))
        again = tendril.sweep("feed", {"friction_mu": [0, 1, 2], "growth_initial_length": [2, 1]},
                              directory=self.place / "sweep", **SHORT)
        finished = s.status == 1
        np.testing.assert_array_equal(again.seconds[finished], s.seconds[finished])  # not run again
        with self.assertRaisesRegex(tendril.RunError, "directory .*other options; name another directory"):
            tendril.sweep("feed", {"friction_mu": [0, 1, 2], "growth_initial_length": [2, 1]},
                          directory=self.place / "sweep", **SHORT | {"rod_cells": 41})
        for wrong in ({}, {"friction_mu": []}, {"friction_mu": 0.5}, {"growth_type": "feed"}):
            with self.assertRaisesRegex(tendril.TendrilError, "^sweep: .*give"):
                tendril.sweep("feed", wrong)
        lengths = tendril.sweep(over={"tip_force": [0, 1]}, task="critical", friction_beta=1e-6)
        np.testing.assert_allclose(lengths.dataset().length, [1.98635, 1.326992], rtol=1e-5)

    def test_sweep_over_units(self):
        """A slash of a unit is none in the name of a file; arrays go along; tasks that a job of many
        cannot do are done one by one."""
        bend = {"distance": ([0, 1, 2, 3], "cm"), "curvature": ([0.1] * 4, "1/cm")}
        s = tendril.sweep(TUBE, {"si_friction_dry (N/m)": [np.float64(0.3), "0.6N/m"], "rod_cells": [50]},
                          directory=self.place / "units", rod_curvature_file=bend, stop_length="3cm")
        self.assertEqual([r.attributes["parameters/si_friction_dry"] for r in s.members.flat], [0.3, 0.6])
        self.assertEqual([r.scale("length") for r in s.members.flat],
                         [(2.209e-6 / friction) ** (1 / 3) for friction in (0.3, 0.6)])
        *axes, table, units = map.read(self.place / "units", ["si_friction_dry", "rod_cells"], "width", True)
        self.assertEqual((units, list(axes[0])), (["N/m", "", "mm"], [0.3, 0.6]))
        np.testing.assert_allclose(table[0], [1000 * r.dataset(si=True).width[-1] for r in s.members.flat])
        curvature = s.members[0, 0].dataset(si=True).natural_curvature[-1]
        np.testing.assert_allclose(curvature, 10)  # 1/m
        names = [f"si_friction_dry=0.{n}N_m__rod_cells=50" for n in (3, 6)]
        self.assertEqual([r.name for r in s.members.flat], names)
        numbers = s.dataset(si=True).si_friction_dry
        self.assertEqual((list(numbers), numbers.attrs["units"]), ([0.3, 0.6], "N/m"))
        with self.assertRaisesRegex(tendril.RunError, "did you mean friction_mu"):
            tendril.sweep("feed", {"rod_cells": [40, 50]}, frictoin_mu=1)
        s = tendril.sweep(over={"tip_force": [0, 0.5]}, task="stability", friction_beta=1e-3,
                          stability_points=2, stability_end=0.1, stability_vertices=20)
        self.assertEqual([len(r.stability.t) for r in s.members], [2, 2])

    def test_map(self):
        """Of last values of a sweep; on a logarithmic axis cells meet at geometric means."""
        place = self.place / "map"
        s = tendril.sweep("feed", {"friction_mu": [0, 1], "growth_initial_length": [1, 2, 4]},
                          directory=place, rod_cells=40, ts_max_time=0.2)
        said = io.StringIO()
        with contextlib.redirect_stderr(said):
            axes = ["--axes", "growth_initial_length,friction_mu", "--output", str(self.place / "map")]
            self.assertEqual(commands.main(["map", str(place), *axes, "--quantity", "wdth"]), 1)
            self.assertEqual(commands.main(["map", str(place), *axes, "--quantity", "width"]), 0)
        self.assertRegex(said.getvalue(), r"^map: .*holds no wdth, did you mean width\?\n$")
        self.assertGreater((self.place / "map.png").stat().st_size, 3000)
        xs, ys, table, _ = map.read(place, ["growth_initial_length", "friction_mu"], "series/width")
        np.testing.assert_array_equal(table, s.dataset().width.values)
        np.testing.assert_allclose(map.edges(xs), 2.0 ** np.array([-0.5, 0.5, 1.5, 2.5]))
        np.testing.assert_allclose(map.edges(ys), [-0.5, 0.5, 1.5])

    def test_map_of_what_is_not_finished(self):
        """That several runs are at one place is told also of such as are not finished, in whatever order they stand."""
        for place, done in (("first", 1), ("second", 2)):
            (self.place / place).mkdir()
            for k in (1, 2):
                with h5py.File(self.place / place / f"a=1__b=2__c={k}.h5", "w") as file:
                    file.attrs["finished"], file["series/width"] = int(k == done), [0.5]
            with self.assertRaisesRegex(ValueError, "several runs are at a .*, of c; .*two options"):
                map.of_directory(self.place / place, ["a", "b"], "width", False)

    def test_three_lines(self):
        """The example of the README does what it says, with the package as pip installs it: by itself, in
        whatever directory."""
        site, work = self.place / "site", self.place / "work"
        work.mkdir()
        shutil.copytree(ROOT / "scripts", self.place / "scripts",
                        ignore=shutil.ignore_patterns("*.egg-info", "build", "__pycache__"))
        if importlib.util.find_spec("setuptools"):
            subprocess.run([sys.executable, "-c", "import setuptools; setuptools.setup()", "-q", "build",
                            "--build-lib", site], cwd=self.place / "scripts", check=True, capture_output=True)
        else:
            shutil.copytree(self.place / "scripts/tendril", site / "tendril")
        for part in ("web/uplot/uPlot.iife.min.js", "py.typed", "options/feed.opts", "options/data/stones.txt"):
            self.assertTrue((site / "tendril" / part).is_file(), part)
        readme = (ROOT / "README.md").read_text()
        code = re.search(r"(?m)^    import tendril\n(    .*\n)+", readme)[0]
        lines = [line[4:] for line in code.splitlines()]
        self.assertLessEqual(len(lines), 4)
        lines.append("print(tendril.__file__)")
        done = subprocess.run([sys.executable, "-c", "\n".join(lines)], cwd=work, text=True,
                              capture_output=True, env=os.environ | {"PYTHONPATH": str(site)})
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual(Path(done.stdout.strip()), site / "tendril/__init__.py")
        for file in re.findall(r'"(\w+\.(?:png|html|csv|gif))"', code):
            self.assertGreater((work / file).stat().st_size, 1000, file)

    def test_version(self):
        text = (ROOT / "scripts/pyproject.toml").read_text()
        program = re.search(r"project\(tendril VERSION ([0-9.]+)", (ROOT / "CMakeLists.txt").read_text())[1]
        self.assertEqual(program, tendril.__version__)
        version = re.search(r'(?m)^version = "(.*?)"', text)[1]
        self.assertEqual({self.tube.attributes["version"], tendril.__version__}, {version})

    def test_installed_alike(self):
        """What pip installs is said twice, for the package with the program and for the package alone; an extra
        that one of them lacks would be passed over with a warning."""
        with_program, alone = ((ROOT / where).read_text() for where in ("pyproject.toml", "scripts/pyproject.toml"))
        extras = [re.search(r"(?m)^\[project.optional-dependencies\].*\n((?:\w+ = .*\n)+)", text)[1]
                  for text in (with_program, alone)]
        self.assertEqual(*extras)
        needed = re.findall(r'"(.*?)"', re.search(r"(?s)\ndependencies = \[(.*?)\]", with_program)[1])
        self.assertEqual(needed, (ROOT / "scripts/requirements.txt").read_text().split())
        for script in (ROOT / "scripts").glob("**/*.py"):
            for extra in re.findall(r"tendril\[(\w+)\]", script.read_text()):
                self.assertIn(f"\n{extra} = [", "\n" + extras[0])

    def test_a_script_lacks_its_libraries(self):
        (self.place / "cv2.py").write_text("raise ModuleNotFoundError(name='cv2')")
        done = subprocess.run([sys.executable, ROOT / "scripts/lab/tube_film.py"], text=True, capture_output=True,
                              env=os.environ | {"PYTHONPATH": f"{self.place}:{ROOT / 'scripts'}"})
        self.assertEqual((done.returncode, done.stderr.count("\n")), (1, 1), done.stderr)
        self.assertRegex(done.stderr, r"^tube_film: .*needs cv2: .*pip install -e './scripts\[film\]'$")

    def test_an_old_venv(self):
        """setup.sh brings .venv up to date where what the package needs has changed, extras too, and leaves there
        what else is in it; else it does nothing."""
        project = self.place / "old"
        (project / ".venv/bin").mkdir(parents=True)
        (project / "scripts").mkdir()
        for name in ("setup.sh", "common.sh", "requirements.txt", "pyproject.toml"):
            shutil.copy(ROOT / "scripts" / name, project / "scripts")
        python, known = project / ".venv/bin/python", self.place / "known/dpkg-query"
        python.write_text(f'#!/bin/sh\n[ "$2" = pip ] && echo "$@" >>{project}/called; true\n')
        known.parent.mkdir()  # all of Debian's packages are there
        known.write_text('#!/bin/sh\nfor p; do echo "installed $p"; done\n')
        for program in (python, known):
            program.chmod(0o755)
        shutil.copy(ROOT / "scripts/requirements.txt", project / ".venv")  # the stamp of earlier versions

        def calls():
            subprocess.run([project / "scripts/setup.sh"], check=True, capture_output=True, text=True,
                           env=os.environ | {"PATH": f"{known.parent}:{os.environ['PATH']}"})
            return (project / "called").read_text().count("install") if (project / "called").exists() else 0

        self.assertEqual([calls(), calls()], [1, 1])
        with open(project / "scripts/pyproject.toml", "a") as text:
            text.write('new = ["something"]\n')
        self.assertEqual([calls(), calls()], [2, 2])
        self.assertTrue(python.exists())

    def test_help(self):
        """Every shell script tells how it is used."""
        scripts = [f for f in (ROOT / "scripts").glob("**/*.sh") if f.name not in ("common.sh", "python.sh")]
        self.assertGreater(len(scripts), 12)
        for script in scripts:
            # what it is for Python to tell, Python is asked below, and not started for each
            done = subprocess.run([script, "-h"], capture_output=True, text=True, cwd=self.place, env=os.environ | {"PYTHON": "echo"})
            self.assertEqual(done.returncode, 0, f"{script}: {done.stderr}")
            words = done.stdout.splitlines()[-1].split()
            if words[:2] == ["-m", "tendril"]:
                self.assertEqual(words[3:], ["-h"])
                said = io.StringIO()
                with mock.patch.dict(os.environ, TENDRIL_SCRIPT="1"), contextlib.redirect_stdout(said), self.assertRaises(SystemExit) as end:
                    commands.main(words[2:])
                self.assertEqual(end.exception.code, 0, script)
                self.assertIn(script.name, said.getvalue())
            else:
                self.assertIn(script.name, done.stdout)

    def boxes(self, figure):
        """Where all texts and legends of a figure are, in points of the screen."""
        renderer = FigureCanvasAgg(figure).get_renderer()
        figure.draw(renderer)  # only then labels are where they belong
        for ax in figure.axes:
            texts = [t for t in (ax.title, ax._left_title, ax.xaxis.label, ax.yaxis.label, *ax.texts)
                     if t.get_text() and ax.axison]
            for text in texts + [ax.get_legend()] * (ax.get_legend() is not None):
                yield text, text.get_window_extent(renderer)

    def test_errors_of_runs(self):
        """What a run tells of its errors is what its series have, a band about their curves, and on its page; of a model
        that does not measure them there is none."""
        r = self.tube
        for name, told in r.errors.items():
            series = r.series[f"error_{name}"]
            self.assertEqual(told.end, series[-1])
            self.assertEqual(told.most, series[r.series.t == told.when][0])
            self.assertTrue(0 < told.end <= told.most and told.why in ("space", "time", "a snap"), (name, told))
        low, high = r.band("energy")
        np.testing.assert_allclose((high - low)[1:], 2 * (r.series.error_energy * r.series.energy)[1:], rtol=1e-9)
        low, high = r.band("tip_x1")
        np.testing.assert_allclose(high - low, 2 * r.series.error_tip * r.series.end_distance, rtol=1e-9, atol=1e-14)
        self.assertIsNone(r.band("width"))
        drawn = tendril.plot(r, "energy,width").axes
        self.assertEqual([len(ax.collections) for ax in drawn], [1, 0])
        self.assertEqual(len(tendril.plot(r, "errors").axes[0].lines), 3)
        page = tendril.view(r)._repr_html_()
        self.assertIn(f"energy {r.errors['energy'].end:.1e}", page)
        mixed = tendril.run("feed", rod_model="mixed", **SHORT)
        self.assertEqual((mixed.errors, mixed.rigid, mixed.band("energy")), ({}, {}, None))

    def test_pictures_do_not_collide(self):
        """No text of a picture lies over another or beyond its edge, in any unit and arrangement; panels
        have the same size in all units."""
        sizes = []
        for choice in (dict(), dict(si=True)):
            figure = tendril.plot(self.tube, **choice)
            sizes.append([ax.get_position().width * figure.get_size_inches()[0] for ax in figure.axes])
        np.testing.assert_allclose(sizes[0], sizes[1], rtol=1e-12)
        for picture in (tendril.plot(self.tube, si=True), tendril.plot(self.runs),
                        tendril.plot(self.runs, overlay=True),
                        tendril.plot(self.runs, "norm,width+end_distance,tip_speed,norm_x2_length")):
            found = list(self.boxes(picture))
            whole = picture.bbox
            for i, (a, box) in enumerate(found):
                self.assertTrue(whole.x0 <= box.x0 and box.x1 <= whole.x1 and whole.y0 <= box.y0
                                and box.y1 <= whole.y1, f"{a} is cut off")
                for b, other in found[:i]:
                    self.assertFalse(box.overlaps(other), f"{a} lies over {b}")

    def test_a_rod_that_senses_is_drawn(self):
        """Its lamp in pictures, films and pages; where it grows, all of which is its speed; at rest its bend is its set point."""
        from tendril import bends, senses, solids
        from tendril.films import Film
        from tendril.units import Units

        shoot = dict(growth_initial_length=1, shape_type="straight", rod_cells=20, tropism_light=2, tropism_proprioception=1)
        flat, lifted = (tendril.run(shoot, growth_type="apical", growth_zone=0.7, tropism_source="3mm,2mm", rod_model=model, ts_max_time=0.3,
                                    si_bending_stiffness="1Nmm^2", si_friction_dry="1N/mm", si_speed="1mm/h") for model in ("frame", "space"))
        for r in (flat, lifted):
            np.testing.assert_allclose(senses.lamp(r, 2), [3, 2], rtol=1e-12)
            shape = r.stored(-1)
            p = np.cumsum(np.r_[0, np.linalg.norm(np.diff(shape.x, axis=0), axis=1)])
            self.assertAlmostEqual(np.trapezoid(senses.strain_rate(r, shape), p), 1, delta=5e-3)
            picture = tendril.plot(r, "shapes,bends,growth,portrait")
            stars = [line.get_xydata()[0] for ax in picture.axes for line in ax.lines if line.get_marker() == "*"]
            np.testing.assert_allclose(stars, [[3, 2]] * 2, rtol=1e-12)
        found = re.search(r'"lamp": ?\[([^]]*)\]', html.unescape(tendril.view(flat)._repr_html_()))
        np.testing.assert_allclose([float(word) for word in found[1].split(",")], [3, 2], rtol=1e-12)
        self.assertTrue(any(line.get_marker() == "*" for line in Film(flat, [flat.stored(-1)], Units([flat])).figure.axes[0].lines))
        np.testing.assert_allclose(solids.solids(lifted)[-1].vertices.mean(axis=0), [3, 2, 0], atol=0.05)
        rest = tendril.run(shoot, growth_type="none", tropism_rate=1, tropism_source="2,1", ts_max_time=40, friction_mu=0)
        (_, _, bend), _, (_, _, goal) = bends.bends_of(rest, rest.stored(-1))
        np.testing.assert_allclose(goal[:-1], bend[:-1], atol=1e-4)

    def test_lengths_are_true_whatever_axis_points_up(self):
        import matplotlib.pyplot as plt

        from tendril.perspective import furnish

        for up in (1, -2, 3):
            ax = plt.figure().add_subplot(projection="3d")
            furnish(ax, np.zeros(3), np.array([3, 1, 0.5]), up, (30, 20), str)
            ax.set_proj_type("ortho")
            seen = np.linalg.norm(ax.get_proj()[:3, :3], axis=0)
            np.testing.assert_allclose(seen, seen[0], rtol=1e-9)
            plt.close(ax.figure)

    def test_overlay(self):
        """Every run in every panel, each in its own colour."""
        figure = tendril.plot(self.runs, "width,shapes", overlay=True, times=[0.5, 1])
        width, shapes = figure.axes
        self.assertEqual([list(line.get_ydata()) for line in width.lines],
                         [list(r.series.width) for r in self.runs])
        colours = [line.get_color() for line in width.lines]
        self.assertEqual(len(set(colours)), 2)
        rods = [line for line in shapes.lines if len(line.get_xdata()) > 1]
        self.assertEqual([line.get_color() for line in rods], [c for c in colours for _ in range(2)])
        for wrong, word in (("wdth", "unknown"), ("width+energy", "no one unit")):
            with self.assertRaisesRegex(tendril.ResultsError, word):
                tendril.plot(self.runs, wrong)

    def test_runs_of_two_frictions(self):
        """In one picture each has its own scales: both end at the same second, and their walls are one; the units of the
        laboratory are taken unasked. Beside a run that knows none they are refused."""
        scene = TUBE | {"stop_length": "3cm", "rod_curvature": "3/m", "wall_file": ["circle 2cm 1.5cm 1cm outside"],
                        "contact_diameter": "2mm", "output_interval": "0.2s"}
        two = [tendril.run(scene, si_friction_dry=f"{n}N/m") for n in (0.25, 2)]
        self.assertGreater(two[1].series.t[-1], 1.9 * two[0].series.t[-1])
        figure = tendril.plot(two, "width,shapes", overlay=True)
        width, shapes = figure.axes
        self.assertEqual((width.get_xlabel(), shapes.get_xlabel()), ("time $t$ (s)", "$x_1$ (cm)"))
        for r, line in zip(two, width.lines):
            np.testing.assert_allclose(line.get_xdata(), r.series.t * r.scale("time"))
            unit = {"width (mm)": 1e-3, "width (cm)": 1e-2}[width.get_ylabel()]
            np.testing.assert_allclose(line.get_ydata() * unit, r.series.width * r.scale("length"))
        first, second = [artist for artist in shapes.artists if hasattr(artist, "walls")]
        for own, r in ((first, two[0]), (second, two[1])):
            np.testing.assert_allclose(own.scale * own.walls[0].numbers, [2, 1.5, 1], rtol=1e-6)
        rods = [line for line in shapes.lines if len(line.get_xdata()) > 1]
        np.testing.assert_allclose([line.width for line in rods], 0.2, rtol=1e-6)
        for a, b in zip(rods[:4], rods[4:]):  # the same times of both
            self.assertEqual(a.get_label(), b.get_label())
            np.testing.assert_allclose(np.hypot(*np.diff(a.get_xydata(), axis=0).T).sum(),
                                       np.hypot(*np.diff(b.get_xydata(), axis=0).T).sum(), rtol=2e-3)
        bare = tendril.plot(two, "width", overlay=True, si=False).axes[0]
        self.assertEqual([line.get_xdata()[-1] for line in bare.lines], [r.series.t[-1] for r in two])
        self.assertEqual(bare.get_xlabel(), "time $t$")
        at = tendril.plot(two, "shapes", times=["2s"]).axes[0].get_legend()
        self.assertEqual([text.get_text() for text in at.get_texts()], ["$t$ in s: $2$"])
        for more, line in ((dict(times=[0.5]), "times 0.5: these runs count it each in a unit of its own; give it with one, 0.5s"),
                           (dict(times=["9s"]), "ends at t = .* s; no shape at 9 s")):
            self.assertRaisesRegex(tendril.ResultsError, line, tendril.plot, two, "shapes", **more)
        for call in (tendril.plot, tendril.view):
            for si in (None, True):
                with self.assertRaisesRegex(tendril.ResultsError, "knows its length in SI units and .* does not: .*--dimensionless"):
                    call([two[0], self.runs[0]], si=si)
            call([two[0], self.runs[0]], si=False)

    def test_pictures_are_in_the_laboratory(self):
        """Plot, film and page of a run that has one, unless it is asked for the numbers of the file."""
        for si, unit in ((None, "cm"), (True, "cm"), (False, "")):
            self.assertEqual(tendril.plot(self.tube, "shapes", si=si).axes[0].get_xlabel(), f"$x_1$ ({unit})" if unit else "$x_1$")
            with mock.patch.object(films, "Film", side_effect=InterruptedError) as film, self.assertRaises(InterruptedError):
                tendril.animate(self.tube, self.place / "lab.gif", si=si)
            self.assertEqual(film.call_args.args[2].scales["length"][1], unit)
            said = tendril.view(self.tube, si=si).text
            self.assertEqual(json.loads(re.search(r'id="data"[^>]*>(.*?)</script>', said, re.DOTALL)[1])["lab"], bool(unit))
        for words, unit in (([], "cm"), (["--si"], "cm"), (["--dimensionless"], "")):
            parser = argparse.ArgumentParser()
            units.add_choice_of_units(parser)
            chosen = units.in_laboratory_of([self.tube], parser.parse_args(words).si)
            self.assertEqual(units.Units(chosen).scales["length"][1], unit)
        self.assertEqual(tendril.plot(self.runs, "shapes").axes[0].get_xlabel(), "$x_1$")
        self.assertRaisesRegex(tendril.ResultsError, "si needs a run in the laboratory", tendril.plot, self.runs, si=True)

    def test_titles_of_a_sweep(self):
        """Options in words and values with their units, of what is varied."""
        s = tendril.sweep(TUBE, {"si_friction_dry": ["0.2N/m", "2N/m"], "rod_cells": [40]}, stop_length="2cm")
        self.assertEqual(titles.titles_of(list(s.members.flat)), ["friction 0.2 N/m", "friction 2 N/m"])
        figure = tendril.plot(s, "width", overlay=True)
        self.assertEqual([text.get_text() for text in figure.legends[0].get_texts()], ["friction 0.2 N/m", "friction 2 N/m"])
        ends = [line.get_xdata()[-1] for line in figure.axes[0].lines]
        self.assertAlmostEqual(ends[0], ends[1], places=6)
        self.assertEqual(map.read(s, ["si_friction_dry", "rod_cells"], "width")[3][0], "N/m")

    def test_names_of_runs(self):
        """Runs of one scene are told apart by the options in which they differ, else by where they are."""
        named = [text.get_text() for text in tendril.plot(self.runs, "width", overlay=True).legends[0].get_texts()]
        self.assertEqual(named, ["feed, friction_mu 0", "feed, friction_mu 1"])
        page = tendril.view([*self.runs, self.tube], si=False).text
        self.assertIn("feed, friction_mu 0 · feed, friction_mu 1 · run", page)
        thirds = [replace(self.tube, options={"friction_mu": repr(mu)}) for mu in (1 / 3, 2 / 3)]
        self.assertEqual(titles.titles_of(thirds), ["run, friction_mu 0.3333", "run, friction_mu 0.6667"])
        self.assertEqual(titles.titles_of([self.tube, self.tube]), ["run (1)", "run (2)"])
        kept = []
        for place in ("here", "there"):
            (self.place / place).mkdir()
            kept.append(tendril.run("feed", output=self.place / place / "mine.h5", **SHORT))
        self.assertEqual(titles.titles_of(kept), ["here/mine", "there/mine"])
        self.assertEqual(titles.titles_of(kept, "ab"), ["a", "b"])


if __name__ == "__main__":
    os.environ["TENDRIL"] = str(Path(sys.argv.pop(1)).resolve())
    unittest.main()

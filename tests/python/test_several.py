#!/usr/bin/env python3
"""Several rods from Python: dicts and tables, what each rod's results are, pictures.

    test_several.py build/tendril"""
# test: several rods are run, read and drawn from Python

import os
import sys
import tempfile
import unittest
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "support"))
from interpreter import ROOT, from_venv

sys.path.insert(0, str(ROOT / "scripts"))
try:
    import numpy as np
    import pandas as pd
    import tendril
except ImportError as error:
    from_venv(error)

SCENE = {"growth_type": "feed", "growth_initial_length": 0.5, "ts_max_time": 0.3, "rod_cells": 20, "shape_type": "sag",
         "shape_amplitude": 0.01, "output_shapes": 4}


class Several(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        table = pd.DataFrame({"clamp_place": [(0, 0.3 * k, 0) for k in range(2)], "rod_curvature": [0.1, 0.2]})
        cls.r = tendril.run(SCENE, rods={"tap": {"clamp_direction": (0, 0, 1), "rod_cells": 30}, "side": table})

    def test_each_is_a_run(self):
        self.assertEqual(list(self.r.rods), ["side1", "side2", "tap"])
        alone = tendril.run(SCENE, rod_curvature=0.2, clamp_place=(0, 0.3, 0), rod_model="space")
        one = self.r["side2"]
        self.assertEqual(one.shapes.x.shape, alone.shapes.x.shape)
        self.assertEqual(set(alone.series) - set(one.series), set())
        self.assertLess(np.abs(one.at(0.3).x - alone.at(0.3).x).max(), 1e-6)
        self.assertLess(np.abs(one.at(0.2).x - alone.at(0.2).x).max(), 1e-4)  # between two stored ones
        self.assertEqual((one.options["rod_curvature"], one.options["rod_cells"]), ("0.2", "20"))
        self.assertEqual(self.r["tap"].shapes.x.shape[1], 31)

    def test_sums(self):
        self.assertAlmostEqual(self.r.series.energy[-1], sum(one.series.energy[-1] for one in self.r.rods.values()), 14)
        self.assertEqual(self.r.series.length[-1], max(one.series.length[-1] for one in self.r.rods.values()))

    def test_pairs(self):
        with self.assertRaisesRegex(tendril.ResultsError, "its rods do not touch each other"):
            _ = self.r.pairs
        r = tendril.run(SCENE, contact_diameter=0.05, ts_max_time=0.6, output_shapes=2, rods={"low": {"clamp_direction": (1, 0, 0.05)},
                        "high": {"clamp_place": (0.7, 0, 0.5), "clamp_direction": (0, 0, -1)}}, pairs={("low", "high"): {"contact_friction": 0.2}})
        last = r.pairs[-1]
        self.assertEqual((len(r.pairs), len(r.pairs[0].rods), last.rods), (3, 0, [("low", "high")]))
        self.assertEqual((last.s.shape, last.force.shape, last.gap.shape), ((1, 2), (1, 3), (1,)))
        self.assertLess(last.force[0, 2], 0)
        self.assertAlmostEqual(np.linalg.norm(last.force) / r.series.contact_force[-1], 1, 1)

    def test_traced(self):
        """A root system drawn in pixels, and a branched line in space: rods begin with the lines' places and lengths."""
        with tempfile.TemporaryDirectory() as directory:
            s = np.linspace(0, 1, 60)
            tap, points = np.c_[200 + 30 * np.sin(5 * s), 50 + 900 * s], lambda x: "".join(f'<point x="{a:.2f}" y="{b:.2f}"/>' for a, b in x)
            side = np.c_[tap[30, 0] + 3 + 200 * s, tap[30, 1] + 120 * s**2]
            root = lambda name, x, more="": f'<root ID="{name}"><geometry><polyline>{points(x)}</polyline></geometry>{more}</root>'
            drawn = Path(directory) / "drawn.rsml"
            drawn.write_text('<?xml version="1.0"?><rsml><metadata><unit>cm</unit><resolution>100</resolution></metadata><scene><plant>'
                             f'{root("tap", tap, root("lat_1", side))}</plant></scene></rsml>')
            for more in ({}, {"natural": False}):
                table = tendril.rods(drawn, length="10mm", rod_cells=40, **more)
                r = tendril.run({"growth_type": "uniform", "ts_max_time": 1e-6}, rods={"roots": table})
                for name, line in (("tap", tap), ("lat1", side)):
                    self.assertLess(np.abs(r[name].stored(0).x[-1, :2] - line[-1] / [100, -100]).max(), 0.015, name)
            self.assertLess(abs(table.attrs["moved"]["lat1"] - 0.03), 0.005)
            z = np.linspace(0, 2, 41)
            helix = np.c_[np.cos(2 * z), np.sin(2 * z), z]
            lines = [f"{k + 1} 0 {a:.6f} {b:.6f} {c:.6f} 0.1 {k or -1}" for k, (a, b, c) in enumerate(helix)]
            lines += [f"{42 + k} 0 {helix[20, 0] + 0.1 * (k + 1):.6f} {helix[20, 1]:.6f} {helix[20, 2] + 0.02 * k * k:.6f} 0.05 {41 + k if k else 21}" for k in range(8)]
            (Path(directory) / "line.swc").write_text("# a branch\n" + "\n".join(lines))
            stem = tendril.rods(Path(directory) / "line.swc", length=1, slides=True, rod_cells=60)[:1]
            r = tendril.run({"growth_type": "apical", "growth_zone": 0.3, "ts_max_time": 1e-6}, rods={"stem": stem})
            self.assertLess(np.abs(r[stem.name[0]].stored(0).x[-1] - helix[-1]).max(), 2e-3)
            table = tendril.rods(Path(directory) / "line.swc", length=1, rod_cells=60)
            r = tendril.run({"growth_type": "uniform", "ts_max_time": 1e-6}, rods={"roots": table})
            self.assertEqual(list(r.rods), list(table.name))
            ends = [r[name].stored(0).x[-1] for name in r.rods]
            self.assertLess(np.abs(ends[0] - helix[-1]).max(), 2e-3)
            self.assertLess(np.abs(ends[1] - helix[20] - [0.8, 0, 0.98]).max(), 5e-3)
            with self.assertRaisesRegex(tendril.TendrilError, "line 2: its parent 7 does not stand before it"):
                (Path(directory) / "bad.swc").write_text("1 0 0 0 0 1 -1\n2 0 0 0 1 1 7\n")
                tendril.rods(Path(directory) / "bad.swc", length=1)
            with self.assertRaisesRegex(tendril.TendrilError, "does not say in which unit"):
                drawn.write_text(drawn.read_text().replace("<unit>cm</unit>", ""))
                tendril.rods(drawn)

    def test_laterals(self):
        table = tendril.laterals("tap", 3, first="4mm", apart="2.5mm", angle="65deg", delay={"born": "2h", "speed": "1mm/h"}, rod_cells=16)
        self.assertEqual(list(table.clamp_at), ["4mm", "6.5mm", "9mm"])
        self.assertEqual(list(table.clamp_azimuth), ["0deg", "137.5deg", "275deg"])
        self.assertEqual((list(table.born), list(table.name)), (["2h", "4.5h", "7h"], ["tap1", "tap2", "tap3"]))
        r = tendril.run({"growth_type": "uniform", "ts_max_time": 1e-6, "shape_type": "straight"},
                        rods={"tap": {"growth_initial_length": 1}, "sides": tendril.laterals("tap", 2, first=0.5, apart=0.25, angle="60deg", growth_initial_length=0.1)})
        ends = [r[f"tap{k}"].stored(0).x[-1] - r[f"tap{k}"].stored(0).x[0] for k in (1, 2)]
        self.assertLess(abs(ends[0] @ ends[1] / 0.01 - (0.25 + 0.75 * np.cos(np.radians(137.5)))), 1e-5)
        with self.assertRaisesRegex(tendril.TendrilError, "give both in one"):
            tendril.laterals("tap", 3, first="4mm", apart=2, angle="65deg")
        with self.assertRaisesRegex(tendril.TendrilError, "one for each"):
            tendril.laterals("tap", 3, first=4, apart=2, angle="65deg", rod_curvature_seed=[1, 2])

    def test_joints(self):
        """Each half of a ring that is pulled at its weld bears half; the moment there is that of the curvature (shooting)."""
        r = tendril.run({"growth_type": "none", "growth_initial_length": np.pi, "friction_mu": 0, "friction_layers": "0:1e-2", "rod_cells": 24,
                         "shape_type": "straight", "ts_max_time": 200},
                        rods={"a": {"rod_curvature": 1, "tip_force_vector": (0, 1, 0)},
                              "b": {"clamp_direction": (-1, 0), "rod_curvature": -1, "tip_on": "a"}})
        joint = r.joints["b.tip"]
        self.assertEqual((joint["on"], joint["end"], list(r.joints)), ("a", "tip", ["b.tip"]))
        self.assertLess(np.abs(joint.force[-1] - (0, -0.5, 0)).max(), 1e-9)
        self.assertLess(np.abs(joint.moment[-1] - (0, 0, 0.30355449275)).max(), 1e-6)
        tip = r["a"].shapes
        self.assertEqual(tip.s[-1], tip.s[-2])
        self.assertLess(np.abs(np.diff(tip.moment[-1, -2:], axis=0) - joint.moment[-1] * (0, 0, -1)).max(), 1e-9)
        marks = [(line.get_marker(), *np.ravel(line.get_data_3d())) for line in tendril.draw(r).axes[0].lines]
        self.assertEqual([mark[0] for mark in marks if mark[0] in "so"], ["s", "s", "o"])  # two clamps, a joint
        self.assertTrue(np.allclose([mark[1:] for mark in marks if mark[0] == "o"], [(0, 2, 0)]))
        with self.assertRaisesRegex(tendril.errors.ResultsError, "do not hold each other"):
            self.r.joints

    def test_one_is_to_be_taken(self):
        with self.assertRaisesRegex(tendril.ResultsError, r"holds 3 rods; take one, as \['side1'\]"):
            self.r.at(0.1)
        with self.assertRaisesRegex(tendril.ResultsError, "has no rod taps, did you mean tap"):
            self.r["taps"]

    def test_pictures(self):
        figure = tendril.plot(self.r, "space")
        self.assertEqual([len(c.strands) for a in figure.axes for c in a.collections if hasattr(c, "strands")], [12])
        names = [text.get_text().strip() for text in tendril.draw(self.r).axes[0].texts]
        self.assertEqual(names, ["side1", "side2", "tap"])

    def test_a_scene_is_drawn_before_it_runs(self):
        figure = tendril.draw(SCENE, rods={"a": {"clamp_place": (0, 1, 0)}, "b": {}}, contact_diameter=0.05,
                              wall_file=["sphere 1 0 0.2 0.3 outside"])
        axes = figure.axes[0]
        strands = next(c.strands for c in axes.collections if hasattr(c, "strands"))
        self.assertTrue(np.allclose(strands[0].x[0], (0, 1, 0)) and len(strands) == 2 and strands[0].diameter == 0.05)
        self.assertGreater(len(axes.collections), 2)  # the sphere
        with self.assertRaisesRegex(tendril.RunError, "rod a: clamp_place: give three numbers|rod a: -?clamp_place"):
            tendril.draw(SCENE, rods={"a": {"clamp_place": "x"}})

    def test_a_scene_with_sections(self):
        """What the scene has sections for is said by prefix, and comes on top."""
        with tempfile.TemporaryDirectory() as directory:
            path = Path(directory) / "dish.opts"
            path.write_text("".join(f"-{name} {value}\n" for name, value in SCENE.items()) + "[rod a]\n-rod_curvature 0.1\n")
            r = tendril.run(path, rods={"a": {"rod_curvature": 0.3}, "b": {"clamp_place": (0, 1, 0)}})
        self.assertEqual(list(r.rods), ["a", "b"])
        self.assertEqual((r["a"].options["rod_curvature"], r["b"].options["clamp_place"]), ("0.3", "0,1,0"))


if __name__ == "__main__":
    if len(sys.argv) > 1:
        os.environ["TENDRIL"] = str(Path(sys.argv.pop(1)).resolve())
    unittest.main()

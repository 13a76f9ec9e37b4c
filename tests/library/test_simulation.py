#!/usr/bin/env python3
# test: a simulation that is stepped is the run of the program
"""Simulations in this process (tendril.Simulation), against runs of the program.

    test_simulation.py build/tendril        with .venv's python, or one that has what the package needs"""

import gc
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

    import tendril
except ImportError as error:
    from_venv(error)

FEW = dict(rod_cells=60, ts_max_time=0.5, output_interval=0.1)
SCENES = {"feed": {}, "uniform-dry": {}, "cable-conduit": {"ts_max_time": 0.3}, "root-helix": {"ts_max_time": 0.3}}


def differing(series, others):
    """The names of series that are not the same to the last digit."""
    return [name for name in series if not np.array_equal(series[name], np.asarray(others[name]), equal_nan=True)]


class AsTheProgram(unittest.TestCase):
    def test_interleaved_runs_are_those_of_the_program_to_the_last_digit(self):
        runs = {scene: tendril.run(scene, **FEW | more) for scene, more in SCENES.items()}
        sims = {scene: tendril.Simulation(scene, **FEW | more) for scene, more in SCENES.items()}
        going = dict(sims)
        while going:
            for scene, sim in list(going.items()):
                if not sim.step():
                    del going[scene]
        for scene, sim in sims.items():
            with self.subTest(scene):
                self.assertEqual(differing(sim.series, runs[scene].series), [])
                last = runs[scene].at(sim.t)
                for name in ("x", "theta", "force"):
                    np.testing.assert_array_equal(getattr(sim, name), getattr(last, name))

    def test_looking_on_the_way_changes_nothing(self):
        for scene in ("feed", "cable-conduit"):
            with self.subTest(scene):
                looked, straight = (tendril.Simulation(scene, **FEW) for _ in range(2))
                straight.advance()
                for t in np.linspace(0.013, 0.5, 17):
                    self.assertTrue(looked.advance(t))
                    self.assertEqual(looked.t, t)
                    self.assertEqual(looked.series["t"][-1], t)
                    looked.nodes
                self.assertEqual(differing(looked.series, straight.series), [])
                self.assertFalse(looked.step())
                self.assertFalse(looked.advance(1))

    def test_what_is_between_steps_is_that_of_stored_shapes(self):
        run, sim = tendril.run("feed", **FEW), tendril.Simulation("feed", **FEW)
        for t in (0.1, 0.2, 0.3):
            sim.advance(t)
            np.testing.assert_allclose(sim.x, run.at(t).x, rtol=0, atol=1e-14)


TOGETHER = dict(growth_type="uniform", growth_initial_length=1, friction_beta=1e-4, friction_mu=0.5, ts_max_time=0.1, rod_cells=10)
RODS = {"left": {"rod_curvature": 0.3}, "right": {"clamp_place": (0, 1, 0), "rod_curvature": -0.4, "rod_cells": 14},
        "twig": {"clamp_on": "left", "clamp_at": "tip", "growth_initial_length": 0.4}}


class SeveralRods(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.by_program = tendril.run(rods=RODS, **TOGETHER)

    def test_interleaved_they_are_those_of_the_program_to_the_last_digit(self):
        """Each rod's series, those of all, and places; beside a run of one rod, which is its own, too."""
        short = FEW | {"ts_max_time": 0.05}
        run, alone = self.by_program, tendril.run("feed", **short)
        sim, other = tendril.Simulation(rods=RODS, **TOGETHER), tendril.Simulation("feed", **short)
        while sim.step():
            other.step()
        other.advance()
        self.assertEqual(list(sim.rods), list(RODS))
        self.assertEqual(differing(other.series, alone.series), [])
        self.assertEqual(differing(sim.series, run.series), [])
        for name in RODS:
            self.assertEqual(differing(sim[name].series, run[name].series), [])
            np.testing.assert_array_equal(sim[name].x, run[name].at(sim.t).x)
        self.assertIn("energy", sim.series)
        self.assertNotIn("tip_x1", sim.series)

    def test_looking_and_saving_on_the_way_change_nothing(self):
        looked, straight = tendril.Simulation(rods=RODS, **TOGETHER), self.by_program
        looked.advance(0.04)
        self.assertEqual((looked.t, looked.series["t"][-1], looked["twig"].series["t"][-1]), (0.04, 0.04, 0.04))
        looked["twig"].nodes
        looked.step()
        with tempfile.TemporaryDirectory() as directory:
            looked.save(f"{directory}/half.h5")
            again = tendril.Simulation.load(f"{directory}/half.h5")
        for sim in (looked, again):
            sim.advance()
            for name in RODS:
                self.assertEqual(differing(sim[name].series, straight[name].series), [])
            self.assertEqual(differing(sim.series, straight.series), [])

    def test_what_is_changed_of_one_or_of_all_is_a_scene_of_the_program(self):
        """The changes that are in its file, given to the program as a table of each rod, make the same run."""
        sim = tendril.Simulation(rods=RODS, **TOGETHER)
        sim.advance(0.03)
        sim["right"].set("tip_force", 0.4)
        sim.advance(0.06)
        sim.set("friction_mu", 0.3)
        with tempfile.TemporaryDirectory() as directory:
            sim.save(f"{directory}/changed.h5")
            again = tendril.Simulation.load(f"{directory}/changed.h5")
            sim.advance()
            again.advance()
            rods = {}
            for name, own in RODS.items():
                Path(f"{directory}/{name}.txt").write_text(("0.03 tip_force 0.4\n" if name == "right" else "") + "0.06 friction_mu 0.3\n")
                rods[name] = own | {"change_file": f"{directory}/{name}.txt"}
            run = tendril.run(rods=rods, **TOGETHER)
        for name in RODS:
            self.assertEqual(differing(sim[name].series, run[name].series), [])
            self.assertEqual(differing(again[name].series, sim[name].series), [])
        self.assertGreater(abs(run["right"].series["tip_x1"][-1] - self.by_program["right"].series["tip_x1"][-1]), 1e-4)

    def test_mistakes_are_one_sentence_and_change_nothing(self):
        for more, line in (({"rods": {"a": {"rod_curvaturex": 1}}}, "rod a: rod_curvaturex: unknown option"),
                           ({"b_rod_cells": 3}, "b_rod_cells: unknown option"), ({"rods": {"a": {"tip_on": "c"}}}, "there is no rod of that name")):
            with self.subTest(more), self.assertRaisesRegex(tendril.RunError, line) as caught:
                tendril.Simulation(**{"rods": RODS} | TOGETHER | more)
            self.assertNotIn("\n", str(caught.exception))
        sim = tendril.Simulation(rods=RODS, **TOGETHER)
        sim.advance(0.05)
        for option, value in (("left_tip_forcex", 1), ("rod_cells", 3), ("up_tip_force", 1), ("left_friction_mu", 1)):
            with self.subTest(option), self.assertRaises(tendril.RunError):
                sim.set(option, value)
        with self.assertRaisesRegex(tendril.TendrilError, "holds 3 rods"):
            sim.x
        with self.assertRaisesRegex(KeyError, "did you mean left"):
            sim["lef"]
        sim.advance()
        self.assertEqual(differing(sim.series, self.by_program.series), [])


class Handling(unittest.TestCase):
    def test_mistakes_are_one_sentence_and_the_process_goes_on(self):
        for options, line in (({"friction_mux": 1}, "did you mean friction_mu"), ({"friction_mu": 2}, "too large"),
                              ({"output": "x.h5"}, "is of the program"), ({"rod_model": "steel"}, "give one of"),
                              ({"load": "no-such.h5"}, "no-such.h5"), ({"stop_length": "1cm"}, "stop_length")):
            with self.subTest(options), self.assertRaisesRegex(tendril.RunError, line) as caught:
                tendril.Simulation("feed", **FEW | options)
            self.assertNotIn("\n", str(caught.exception))
        self.assertTrue(tendril.Simulation("feed", **FEW).step())

    def test_a_run_that_gives_up_can_still_be_read(self):
        sim = tendril.Simulation("feed", **FEW | {"ts_max_steps": 5})
        with self.assertRaisesRegex(tendril.RunError, "ts_max_steps: reached"):
            sim.advance()
        self.assertEqual(len(sim.series["t"]), 6)
        self.assertEqual(sim.series["t"][-1], sim.t)
        with self.assertRaisesRegex(tendril.RunError, "given up"):
            sim.set("tip_force", 1)

    def test_arrays_stay_as_they_were_and_outlive_the_simulation(self):
        sim = tendril.Simulation("feed", **FEW)
        kept = []
        while sim.step():
            kept.append((sim.t, sim.x, sim.series["t"], sim.x.copy(), sim.series["t"].copy()))
        sim.close()
        del sim
        gc.collect()
        for t, x, times, x_then, times_then in kept:
            np.testing.assert_array_equal(x, x_then)
            np.testing.assert_array_equal(times, times_then)
            self.assertEqual(times[-1], t)
        with self.assertRaises(ValueError):
            kept[0][2][0] = 1

    def test_it_is_closed_once(self):
        with tendril.Simulation("feed", **FEW) as sim:
            self.assertIn("tip_x1", sim.series)
            with self.assertRaisesRegex(KeyError, "no_such"):
                sim.series["no_such"]
        with self.assertRaisesRegex(tendril.TendrilError, "closed"):
            sim.t

    def test_a_watch_looks_and_stops(self):
        sim, seen = tendril.Simulation("feed", **FEW), []
        self.assertFalse(sim.advance(0.5, watch=lambda sim: seen.append(sim.x[-1, 0]) or len(seen) == 4))
        self.assertEqual(len(sim.series["t"]), 5)

        def interrupted(sim):
            raise KeyboardInterrupt
        with self.assertRaises(KeyboardInterrupt):
            sim.advance(0.5, watch=interrupted)
        self.assertTrue(sim.advance(0.5))


class Laws(unittest.TestCase):
    def test_friction_growth_and_curvature_of_ones_own(self):
        sim = tendril.Simulation("uniform-dry", friction=lambda v2: (0.5 + 0.5 / np.sqrt(v2 + 1e-3), -0.25 * (v2 + 1e-3) ** -1.5),
                                 **FEW | {"friction_mu": 0, "ts_max_time": 0.2})
        run = tendril.run("uniform-dry", **FEW | {"friction_mu": 0.5, "ts_max_time": 0.2})
        sim.advance()
        self.assertAlmostEqual(sim.series["tip_x1"][-1], run.series["tip_x1"][-1], delta=1e-5)
        self.assertAlmostEqual(sim.series["dissipation"][-1] / run.series["dissipation"][-1], 1, delta=1e-5)
        sim = tendril.Simulation(growth=lambda s, t: (0.5 + t, 1, 0, s * (0.5 + t), s), curvature=lambda s, t: 0.3, **FEW)
        sim.advance()
        self.assertEqual(differing(sim.series, tendril.run(rod_curvature=0.3, **FEW).series), [])

    def test_a_law_that_fails_says_so(self):
        def law(v2):
            raise ZeroDivisionError("mine")
        with self.assertRaisesRegex(ZeroDivisionError, "mine"):
            tendril.Simulation(friction=law, **FEW).advance()
        with self.assertRaisesRegex(tendril.TendrilError, "gives 2 values, not 1"):
            tendril.Simulation(friction=lambda v2: 1, **FEW).advance()
        with self.assertRaisesRegex(tendril.RunError, "integral of g"):
            tendril.Simulation(growth=lambda s, t: (1, 0, 0, 2 * s, 0), **FEW)
        with self.assertRaisesRegex(tendril.RunError, "growth_type"):
            tendril.Simulation("feed", growth=lambda s, t: (1, 0, 0, s, 0), **FEW)


class Changed(unittest.TestCase):
    def test_the_clamp_turns_from_now_on_and_so_does_what_was_saved(self):
        sim = tendril.Simulation("root-helix", **FEW)
        sim.advance(0.1)
        sim.set("clamp_spin", 0.5)
        self.assertEqual(sim.t, 0.1)
        sim.advance(0.2)
        np.testing.assert_allclose(sim.nodes["d"][0, 1], [0, np.cos(0.05), np.sin(0.05)], atol=1e-12)
        sim.set("clamp_spin", -0.25)
        sim.step()
        with tempfile.TemporaryDirectory() as directory:
            file = os.path.join(directory, "turned.h5")
            sim.save(file)
            on = tendril.Simulation.load(file)
            sim.advance(), on.advance()
            self.assertEqual(differing(on.series, sim.series), [])
            np.testing.assert_allclose(on.nodes["d"][0, 1], [0, np.cos(0.025), np.sin(-0.025)], atol=1e-12)
            more = tendril.run(restart=file, output=os.path.join(directory, "on.h5"))
            self.assertEqual(differing(sim.series, more.series), [])
        self.assertLess(sim.series["energy_defect"][-1], 1e-4)

    def test_a_change_at_once_behind_a_file_or_before_it_is_that_of_the_run_to_the_last_digit(self):
        for scene, options, until, name, value in (("feed", {}, 0.2, "tip_force", 0.5), ("root-helix", {"ts_max_time": 0.3}, 0.15, "clamp_spin", 0.4),
                                                   ("feed", {"friction_mu": 0.5, "rod_model": "auto", "shape_amplitude": 1e-5}, 0.05, "friction_mu", 0.3)):
            with self.subTest(scene, **options), tempfile.TemporaryDirectory() as directory:
                before, behind = (os.path.join(directory, name) for name in ("before.h5", "behind.h5"))
                sim = tendril.Simulation(scene, **FEW | options)
                while sim.t < until:
                    sim.step()
                models = set(sim.series["model"][1:])
                sim.save(before)
                sim.set(name, value)
                sim.save(behind)
                on = [tendril.Simulation.load(before), tendril.Simulation.load(behind)]
                on[0].set(name, value)
                for run in (sim, *on):
                    run.advance()
                for run in on:
                    self.assertEqual(differing(run.series, sim.series), [])
                if "rod_model" in options:  # from then on it is another one
                    self.assertEqual((models, sim.series["model"][-1]), ({0}, 1))

    def test_what_can_be_changed(self):
        sim = tendril.Simulation("feed", **FEW | {"friction_mu": 0.5, "rod_model": "space"})
        sim.advance(0.1)
        for name, value in (("tip_force", 0.1), ("tip_torque", 0.01), ("tip_force_vector", "0,0,0.01"),
                            ("rod_weight", "0,-0.1,0"), ("friction_mu", 0.3)):
            sim.set(name, value)
            self.assertTrue(sim.step())
        self.assertAlmostEqual(sim.series["tip_force_3"][-1], 0.01, delta=1e-9)
        self.assertAlmostEqual(sim.series["tip_force_1"][-1], -0.1, delta=1e-9)
        self.assertAlmostEqual(sim.series["weight_force_2"][-1], -0.1 * sim.series["length"][-1], delta=1e-9)
        sim.set("ts_max_time", 0.3)
        self.assertTrue(sim.advance())
        self.assertEqual(sim.t, 0.3)
        sim.set("ts_max_time", 0.35)
        self.assertTrue(sim.advance(0.35))

    def test_what_cannot(self):
        sim = tendril.Simulation("feed", **FEW)
        sim.advance(0.1)
        before = sim.t, len(sim.series["t"])
        for name, value, line in (("rod_cells", 50, "cannot be changed"), ("clamp_spin", 1, "out of the plane"),
                                  ("friction_mu", 0.5, "dry friction"), ("tip_force", "x", "give a number"),
                                  ("ts_max_time", 0.05, "already"), ("rod_weight", "1", "three numbers")):
            with self.subTest(name), self.assertRaisesRegex(tendril.RunError, line):
                sim.set(name, value)
        viscous = tendril.Simulation("feed", **FEW | {"friction_mu": 0.5})
        viscous.advance(0.1)
        with self.assertRaisesRegex(tendril.RunError, "cannot go on with dry friction"):
            viscous.set("friction_mu", 1)
        straight = tendril.Simulation("feed", **FEW)
        self.assertEqual((sim.t, len(sim.series["t"])), before)
        sim.advance(), straight.advance()
        self.assertEqual(differing(sim.series, straight.series), [])


PLAYED = {  # options; (behind so many steps, what, its new value, of which T is that much later)
    "fed": (dict(growth_type="feed", growth_initial_length=1, shape_amplitude=0.1, ts_max_time=1),
            [(0, "feed_speed", "0.5"), (40, "curvature_to", "T0.2 1"), (55, "curvature_to", "T0.1 -1"),
             (80, "friction_factor", "2"), (90, "feed_speed", "-0.5"), (110, "tip_force_vector", "0.1,0.2")]),
    "stones": (dict(growth_type="feed", growth_initial_length=1, shape_amplitude=0.05, contact_diameter=0.1, ts_max_time=1,
                    rod_model="space", wall_file=["cylinder 0.6 -0.6 0  0 0 1  0.5 outside friction 0.2",
                                                  "cylinder 30 10 0  0 0 1  0.3 outside friction 0.2"]),
               [(0, "clamp_spin", "0.3"), (15, "wall_to", "1 T0.4 0 0.3"), (60, "wall_at", "2 -28.7 -9.55"),
                (90, "wall_turn_to", "2 T0.3 1"), (150, "wall_friction", "1 0.4"), (170, "wall_to", "1 T0.1 0.1 0.2 0")]),
    "walls": (dict(growth_type="feed", growth_initial_length=1, shape_amplitude=0.05, contact_diameter=0.1, ts_max_time=1, ts_rtol=3e-6,
                   wall_file=["circle 0.6 -0.6 0.5 outside friction 0.2", "polygon outside 31 9 32 9 31 10", "path 0.6 -0.3 0 3 0 3 2 6 2"]),
              [(15, "wall_to", "1 T0.4 0 0.3"), (60, "wall_at", "2 -29.5 -10.1"), (90, "wall_to", "3 T0.3 0 0.1"), (95, "wall_turn_to", "2 T0.2 20deg"), (120, "wall_turn_to", "3 T0.3 -0.02"),
               (150, "wall_friction", "1 0.4"), (170, "wall_to", "1 T0.1 0.1 0.2 0")]),
    "shoot": (dict(growth_type="uniform", growth_initial_length=0.5, tropism_light=1.5, tropism_source="3,2", tropism_gravity=0.5, clamp_angle="20deg",
                   tropism_direction="0,1", tropism_proprioception=1, friction_mu=0, shape_type="straight", ts_max_time=1),
              [(20, "tropism_source", "3,-2"), (60, "tropism_light", "3"), (70, "tropism_proprioception", "0.2"), (80, "tropism_direction", "1,-1"),
               (90, "tropism_gravity", "0"), (100, "tropism_gravity", "2")]),
    "held": (dict(growth_type="none", growth_initial_length=1, shape_amplitude=0.5, tip_type="clamped", friction_mu=0.5, ts_max_time=1),
             [(20, "tip_to", "T0.3 0.8 0.2"), (40, "tip_to", "T0.2 0.7 0.1"), (60, "tip_turn_to", "T0.2 -0.5"), (90, "friction_mu", "0.2")]),
}


class Played(unittest.TestCase):
    """What was changed in a run is a table, with which the program does the same."""

    def play(self, options, wanted, file=None, behind=0):
        """The simulation at its end, and the rows of the table; saved behind so many steps."""
        sim, rows, n = tendril.Simulation(**options), [], 0
        wanted = list(wanted)
        while True:
            while wanted and n >= wanted[0][0]:
                _, what, value = wanted.pop(0)
                value = " ".join(repr(sim.t + float(word[1:])) if word[0] == "T" else word for word in value.split())
                sim.set(what, value)
                rows.append((sim.t, what, value))
            if n == behind and file:
                sim.save(file)
            if not sim.step():
                return sim, rows
            n += 1

    def test_the_program_does_the_same(self):
        for name, (options, wanted) in PLAYED.items():
            with self.subTest(name), tempfile.TemporaryDirectory() as directory:
                options = options | dict(rod_cells=60, output_interval=0.1)
                if "wall_file" in options:
                    walls = Path(directory) / "walls.txt"
                    walls.write_text("\n".join(options["wall_file"]))
                    options["wall_file"] = str(walls)
                file, table = os.path.join(directory, "saved.h5"), os.path.join(directory, "changes.txt")
                sim, rows = self.play(options, wanted, file, 65)
                Path(table).write_text("".join(f"{t!r} {what} {value}\n" for t, what, value in rows))
                run = tendril.run(**options, change_file=table)
                self.assertEqual(differing(sim.series, run.series), [])
                self.assertEqual(len(run.attributes["changes"].splitlines()) if "changes" in run.attributes else 0, len(rows))
                plain = tendril.run(**options)
                self.assertGreater(np.abs(np.interp(0.7, plain.series["t"], plain.series["energy"]) - np.interp(0.7, run.series["t"], run.series["energy"])), 1e-6)
                self.assertLess(np.abs(run.series["energy_defect"]).max(), 4e-4)
                on = tendril.Simulation.load(file)  # in the midst of it
                for t, what, value in rows:
                    while t > on.t and on.step():
                        pass
                    if t >= on.t and t > tendril.load(file).series["t"][-1]:
                        on.set(what, value)
                on.advance()
                self.assertEqual(differing(on.series, run.series), [])
                Path(table).write_text("".join(f"{t!r} {what} {value}\n" for t, what, value in rows[:2]) + "0.777 ts_max_time 0.9\n")
                within = tendril.run(**options, change_file=table)  # a step ends where no step of a run without it does
                self.assertIn(0.777, within.series["t"])
                self.assertEqual(within.series["t"][-1], 0.9)
                with self.assertRaisesRegex(tendril.RunError, "ts_max_steps: reached"):
                    tendril.run(**options, change_file=table, ts_max_steps=9)

    def test_what_it_does(self):
        fed, stones, held = (self.play(PLAYED[name][0] | dict(rod_cells=60), PLAYED[name][1])[0] for name in ("fed", "stones", "held"))
        self.assertAlmostEqual(np.diff(fed.series["length"])[-1] / np.diff(fed.series["t"])[-1], -0.5, delta=1e-9)
        np.testing.assert_allclose(held.x[-1], [0.7, 0.1], atol=1e-9)
        self.assertAlmostEqual(held.theta[-1], -0.5, delta=1e-9)
        self.assertGreater(stones.series["wall_power"].max(), 0)

    def test_what_is_refused(self):
        options, _ = PLAYED["stones"]
        sim = tendril.Simulation(**options | dict(rod_cells=60))
        for name, value, line in (("wall_to", "3 1 0 0", "no wall in this line"), ("wall_to", "1 -1 0 0", "already"),
                                  ("wall_to", "1 1", "give LINE T X1 X2 X3"), ("wall_turn_to", "1 9", "give LINE T ANGLE"), ("wall_turn_to", "1 0 1", "already"), ("wall_at", "2 -29.4 -10", "the rod is there"),
                                  ("tip_to", "1 1 0", "the tip is free"), ("friction_factor", "0", "0.001"),
                                  ("feed_speed", "fast", "give a number"), ("tropism_light", "1", "nothing in it learns")):
            with self.subTest(name), self.assertRaisesRegex(tendril.RunError, line):
                sim.set(name, value)
        for text, line in (("1 rod_cells 5", "cannot be changed in a run"), ("1 tip_to 2 1 0", "the tip is free"), ("tip_force", "give a time"),
                           ("2 tip_force 1\n1 tip_force 2", "must not decrease"), ("# none", "no change in it"),
                           ("0.5 wall_to 1 2", "at t = 0.5: wall_to 1 2: give LINE"), ("0.01 tip_force much", "at t = 0.01: tip_force much: give a number"),
                           ("0.5 tip_force 1\0", "is no text")):
            with self.subTest(text), tempfile.TemporaryDirectory() as directory, self.assertRaisesRegex(tendril.RunError, line):
                table = os.path.join(directory, "changes.txt")
                Path(table).write_text(text + "\n")
                tendril.run(**options | dict(rod_cells=60), change_file=table)

    def test_a_lamp_that_is_moved_turns_the_shoot(self):
        options, ends = dict(growth_type="uniform", growth_initial_length=0.5, tropism_light=3, tropism_source="4,1", friction_mu=0, shape_type="straight",
                             ts_max_time=1.5, rod_cells=40), {}
        for lamp in ("4,1", "4,-1", "-4,1"):
            sim = tendril.Simulation(**options)
            sim.advance(0.5)
            sim.set("tropism_source", lamp)
            sim.advance()
            ends[lamp] = sim.theta[-1]
        self.assertTrue(ends["4,-1"] < 0 < ends["4,1"] < ends["-4,1"], ends)
        sim = tendril.Simulation(**options)
        on_it = ",".join(map(repr, sim.x[20].tolist()))
        for name, value, line in (("tropism_source", on_it, "the rod is there"), ("tropism_gravity", 1, "is 0 in this run"), ("tropism_source", "1,1,1", "out of the plane"), ("tropism_direction", "0,1", "is not sensed")):
            with self.subTest(name), self.assertRaisesRegex(tendril.RunError, line):
                sim.set(name, value)

    def test_a_wall_of_the_plane_is_not_put_where_the_rod_is(self):
        sim = tendril.Simulation(**PLAYED["walls"][0] | dict(rod_cells=60))
        for value, line in (("1 0 0.4", "the rod is there"), ("2 -30.8 -9.3", "the rod is there"), ("1 0 0 1", "stays in it"), ("3 0 5", "the rod is there")):
            with self.subTest(value), self.assertRaisesRegex(tendril.RunError, line):
                sim.set("wall_at", value)
        sim.set("wall_at", "3 0 0.1")

    def test_a_surface_is_not_put_where_the_rod_is_in_whatever_units(self):
        with tempfile.TemporaryDirectory() as directory:
            walls = Path(directory) / "walls.txt"
            walls.write_text("cylinder 30mm 10mm 0  0 0 1  0.3mm outside friction 0.2\n")
            sim = tendril.Simulation(growth_type="feed", growth_initial_length="1mm", contact_diameter="0.1mm", rod_model="space", rod_cells=60,
                                     wall_file=str(walls), si_bending_stiffness="1e-3Nmm^2", si_friction_dry="1mN/mm", si_speed="1mm/s")
            for value in ("1 -29.4mm -10mm", "1 -2.94cm,-0.01m,0mm"):
                with self.subTest(value), self.assertRaisesRegex(tendril.RunError, "the rod is there"):
                    sim.set("wall_at", value)
            sim.set("wall_at", "1 -28.7mm -9.55mm")

    def test_a_surface_is_not_put_where_the_rod_is_wherever_the_clamp_is(self):
        with tempfile.TemporaryDirectory() as directory:
            walls = Path(directory) / "walls.txt"
            walls.write_text("sphere 0.5 0 5  0.2 outside\n")
            sim = tendril.Simulation(rod_model="space", clamp_place="0,5,0", rod_cells=40, contact_diameter=0.02, wall_file=str(walls))
            with self.assertRaisesRegex(tendril.RunError, "the rod is there"):
                sim.set("wall_at", "1 -0.4 5 -5")
            sim.set("wall_at", "1 -0.4 0 -5")

    def test_a_change_before_a_restart_is_one_of_that_run(self):
        with tempfile.TemporaryDirectory() as directory:
            half, table = os.path.join(directory, "half.h5"), os.path.join(directory, "changes.txt")
            options = dict(growth_type="feed", growth_initial_length=1, rod_cells=40, shape_amplitude=0.05)
            Path(table).write_text("\ufeff0.2 feed_speed 0.5\n0.6 feed_speed 2\n")
            tendril.run(**options, ts_max_time=0.4, change_file=table, output=half)
            on = tendril.run(**options, ts_max_time=1, restart=half, change_file=table, output=os.path.join(directory, "on.h5"))
            self.assertAlmostEqual(on.series["length"][-1], 1 + 0.2 + 0.5 * 0.4 + 2 * 0.4, delta=1e-9)
            Path(table).write_text("0.2 feed_speed 0.5\n0.6 feed_speed fast\n")
            with self.assertRaisesRegex(tendril.RunError, "at t = 0.6: feed_speed fast"):
                tendril.run(**options, ts_max_time=1, change_file=table, output=half)
            Path(table).write_text("0.2 feed_speed 0.5\n0.6 feed_speed 2\n")
            mended = tendril.run(**options, ts_max_time=1, restart=half, change_file=table, output=os.path.join(directory, "on.h5"))
            self.assertAlmostEqual(mended.series["length"][-1], on.series["length"][-1], delta=1e-9)
            self.assertAlmostEqual(mended.series["energy"][-1] / on.series["energy"][-1], 1, delta=1e-3)
            self.assertLess(np.abs(mended.series["energy_defect"]).max(), 1e-3)
            for rows in ("0.2 feed_speed 0.7\n", "0.1 feed_speed 0.7\n0.2 feed_speed 0.5\n"):
                Path(table).write_text(rows)
                with self.subTest(rows), self.assertRaisesRegex(tendril.RunError, "feed_speed 0.7 was no change of the run that restart"):
                    tendril.run(**options, ts_max_time=1, restart=half, change_file=table, output=os.path.join(directory, "no.h5"))


class Saved(unittest.TestCase):
    def test_to_the_last_digit_and_of_a_stored_time(self):
        for scene in ("feed", "cable-conduit"):
            with self.subTest(scene), tempfile.TemporaryDirectory() as directory:
                file = os.path.join(directory, "saved.h5")
                full, sim = (tendril.Simulation(scene, **FEW | SCENES[scene]) for _ in range(2))
                full.advance()
                while sim.t < 0.15:
                    sim.step()
                sim.save(file)
                on = tendril.Simulation.load(file)
                self.assertEqual(on.t, sim.t)
                np.testing.assert_array_equal(on.x, sim.x)
                on.advance(), sim.advance()
                self.assertEqual(differing(on.series, full.series) + differing(sim.series, full.series), [])
                full.save(file, t=0.1)
                self.assertEqual(tendril.load(file).series["t"][-1], 0.1)
                on = tendril.Simulation.load(file)
                self.assertEqual(on.t, 0.1)
                on.advance()
                np.testing.assert_allclose(on.x, full.x, rtol=0, atol=1e-5)
                with self.assertRaisesRegex(tendril.RunError, "multiples of 0.1"):
                    full.save(file, t=0.12)
                full.save(file)
                run = tendril.run(scene, **FEW | SCENES[scene])
                saved = tendril.load(file)
                self.assertEqual(differing(saved.series, run.series), [])
                np.testing.assert_array_equal(saved.shapes["x"], run.shapes["x"])
                if "contact" in saved.shapes:
                    np.testing.assert_array_equal(saved.shapes["contact"][-1], full.nodes["contact"][:, :2])


if __name__ == "__main__":
    program = Path(sys.argv.pop(1)).resolve()
    os.environ["TENDRIL"] = str(program)
    os.environ.setdefault("TENDRIL_LIBRARY", str(program.parent / "libtendril.so"))
    unittest.main(verbosity=2)

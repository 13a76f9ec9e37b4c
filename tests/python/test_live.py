#!/usr/bin/env python3
# test: a run is touched in a browser
"""Runs that one can touch (tendril-py live): the server, what it refuses, and the page in Chromium, where there is one.

    test_live.py build/tendril        with .venv's python, or one that has what the package needs"""

import base64
import contextlib
import json
import os
import signal
import subprocess
import sys
import tempfile
import time
import unittest
import unittest.mock
import urllib.error
import urllib.request
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "support"))
import chromium
from interpreter import ROOT, from_venv

sys.path.insert(0, str(ROOT / "scripts"))
try:
    import numpy as np

    import tendril
except ImportError as error:
    from_venv(error)
try:
    from websockets.exceptions import ConnectionClosed, InvalidStatus
    from websockets.sync.client import connect
except ImportError:
    connect = None

PROGRAM = Path(sys.argv[1]).resolve() if len(sys.argv) > 1 else None
STONES = dict(growth_type="feed", growth_initial_length=1, contact_diameter=0.1, shape_amplitude=0.05, rod_cells=60, ts_max_time=6,
              wall_file=["circle 1.6 -0.75 0.4 outside friction 0.1", "circle 2.6 0.9 0.4 outside friction 0.1"])
PAGE = "document.getElementById('live').tendril"


def started(scene, *words, results):
    """The command, and its address: its first line."""
    process = subprocess.Popen([sys.executable, "-m", "tendril", "live", *([scene] if scene else []), "--no-browser", "--results", str(results), *words],
                               stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, env=os.environ | {"PYTHONPATH": str(ROOT / "scripts")})
    address = process.stdout.readline().strip()
    if not address.startswith("http://127.0.0.1:"):
        process.kill()
        raise AssertionError(f"its first line is no address: {address!r} {process.stderr.read()}")
    return process, address


def ended(process):
    """Ctrl-C; what it still says."""
    process.send_signal(signal.SIGINT)
    said, complaint = process.communicate(timeout=60)
    return process.returncode, said, complaint


def told(socket, kind, seconds=60, **what):
    """The next message of a kind."""
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        message = json.loads(socket.recv(timeout=seconds))
        if message["kind"] == kind and all(message.get(k) == v for k, v in what.items()):
            return message
    raise AssertionError(f"no {kind}")


class Live(unittest.TestCase):
    """One server for all of a class."""

    @classmethod
    def setUpClass(cls):
        if connect is None:
            raise unittest.SkipTest("the library websockets is not there: pip install websockets")
        cls.directory = tempfile.TemporaryDirectory()
        cls.results = Path(cls.directory.name) / "results"
        cls.live = tendril.live(results=cls.results, **STONES)
        cls.base, _, cls.query = cls.live.address.partition("?")

    @classmethod
    def tearDownClass(cls):
        cls.live.close()
        cls.directory.cleanup()

    def socket(self, **more):
        return connect(f"{self.base.replace('http', 'ws')}ws?{self.query}", max_size=None, **more)


class Faults(Live):
    def status(self, path, headers={}):
        try:
            with urllib.request.urlopen(urllib.request.Request(self.base + path, headers=headers)) as answer:
                return answer.status
        except urllib.error.HTTPError as error:
            error.close()
            return error.code

    def test_who_has_no_token_or_comes_from_elsewhere_is_refused(self):
        self.assertEqual(self.status(f"?{self.query}"), 200)
        self.assertEqual(self.status(""), 403)
        self.assertEqual(self.status("?token=" + 32 * "a"), 403)
        self.assertEqual(self.status(f"?{self.query}", {"Host": "rebound.example:80"}), 403)
        self.assertEqual(self.status(f"?{self.query}", {"Origin": "http://evil.example"}), 403)
        for path in ("?token=%ff", "?token=%ed%a0%80", "?once=no", "/[?token=x", "//[::"):
            self.assertEqual(self.status(path), 403, path)
        for origin, query in (("http://evil.example", self.query), (None, "token=no"), (self.base.rstrip("/"), "")):
            with self.subTest(origin), self.assertRaises(InvalidStatus):
                connect(f"{self.base.replace('http', 'ws')}ws?{query}", origin=origin)

    def test_no_path_leads_to_the_hosts_files(self):
        for path in ("file/..%2f..%2f..%2fetc%2fpasswd", "file/../../etc/passwd", "file//etc/passwd", "file/%2Fetc%2Fpasswd", "picture/..%2f..%2fREADME.png",
                     "picture/feed.opts", "scripts/tendril/live.py", "file/begun.h5"):
            with self.subTest(path):
                self.assertEqual(self.status(f"{path}?{self.query}"), 404)
        self.assertEqual(self.status(f"picture/feed.png?{self.query}"), 200)
        with self.socket() as socket:
            told(socket, "whole")
            for line, word in (("tube /etc/passwd inside", "/etc/passwd"), ("body secret.h5 inside", "secret.h5"), ("sphere 1 1 1 1 outside moves ../../path.txt", "path.txt")):
                socket.send(json.dumps({"do": "draw", "form": {"growth_type": "feed", "contact_diameter": "1mm", "walls": line}}))
                self.assertRegex(told(socket, "refused", field="walls")["text"], f"line 1: .*{word}.* neither a number nor a word")
            for what in ("../../mine", "scene\n", 7, None, ["scene"]):
                socket.send(json.dumps({"do": "save", "what": [what]}))
                self.assertIn("give scene", told(socket, "refused")["text"])
            socket.send(json.dumps({"do": "start", "scene": "../../../etc/passwd"}))
            self.assertIn("no scene of the gallery", told(socket, "refused")["text"])

    def test_what_makes_no_sense_is_answered_and_changes_nothing(self):
        with self.socket() as socket:
            before = told(socket, "whole")
            for text in ("", "{", "[]", "7", '"run"', '{"do": 7}', '{"do": "__init__"}', '{"do": "loop"}', '{"do": "fly"}', "[" * 5000,
                         '{"do": "set", "name": "rod_cells", "value": 5}', '{"do": "set", "name": "feed_speed", "value": "fast"}',
                         '{"do": "set", "name": "feed_speed", "value": 1' + 400 * "0" + "}", '{"do": "pace", "pace": 1' + 400 * "0" + "}",
                         '{"do": "set", "name": "feed_speed", "value": NaN}', '{"do": "set", "name": "feed_speed"}', '{"do": "wall", "line": 99, "shift": [0, 0]}',
                         '{"do": "wall", "line": 1, "shift": ["a", 0]}', '{"do": "turn", "line": 1, "angle": NaN}', '{"do": "hand", "force": [NaN, 0]}', '{"do": "hand", "force": "up"}', '{"do": "back", "t": 1e9}', '{"do": "pace", "pace": -1}',
                         '{"do": "branch", "branch": 77}', '{"do": "lead", "place": [1, 0]}', '{"do": "set", "name": "wall_friction 1", "value": -1}'):
                with self.subTest(text[:60]):
                    socket.send(text)
                    said = told(socket, "refused")["text"]
                    self.assertRegex(said, "^(speed of feeding|angle|force): give a finite number" if "NaN" in text else ".")  # by the name that it has on the page
        with self.socket() as socket:
            after = told(socket, "whole")
        self.assertEqual((after["t"], after["changes"], after["running"]), (before["t"], before["changes"], before["running"]))

    def test_a_megabyte_and_a_page_that_goes_in_a_step(self):
        with self.assertRaises(ConnectionClosed) as caught, self.socket() as socket:
            told(socket, "whole")
            socket.send(json.dumps({"do": "start", "form": {"walls": 1_000_000 * "#"}}))
            while True:
                socket.recv(timeout=20)
        self.assertEqual(caught.exception.rcvd.code, 1009)
        several = contextlib.ExitStack()
        self.addCleanup(several.close)
        socket = several.enter_context(self.socket())
        told(socket, "whole")
        socket.send(json.dumps({"do": "pace", "pace": 0.02}))
        socket.send(json.dumps({"do": "run"}))
        told(socket, "frame")
        socket.socket.close()  # without a word
        time.sleep(0.5)
        pages = [several.enter_context(self.socket()) for _ in range(10)]
        wholes = [told(page, "whole") for page in pages]
        pages[3].send(json.dumps({"do": "pause"}))
        for page in pages:
            told(page, "state", running=False)
        pages[5].send(json.dumps({"do": "step"}))
        times = {told(page, "frame")["t"] for page in pages}
        self.assertTrue(all(whole["t"] > 0 for whole in wholes))
        self.assertGreaterEqual(min(times), max(whole["t"] for whole in wholes))

    def test_what_opens_the_page_is_good_for_one_look(self):
        path = self.live.server.opening()[len(self.base):]
        self.assertNotIn(self.live.server.token, path)
        with urllib.request.urlopen(self.base + path) as answer:
            self.assertIn(self.query, answer.read().decode())
        self.assertEqual(self.status(path), 403)
        self.assertEqual(self.status(path, {"Host": "rebound.example"}), 403)

    def test_a_mesh_is_dropped_in_parts(self):
        from tendril.starting_page import first_scene

        corners, faces = [(1, 0, 0), (-1, 0, 0), (0, 1, 0), (0, -1, 0), (0, 0, 1), (0, 0, -1)], [(k, m, n) if a * b * c > 0 else (k, n, m)
                                                                                                  for a, k in ((1, 1), (-1, 2)) for b, m in ((1, 3), (-1, 4)) for c, n in ((1, 5), (-1, 6))]
        mesh = "".join(f"v {10 * x} {10 * y} {10 * z}\n" for x, y, z in corners) + "".join("f {} {} {}\n".format(*face) for face in faces)
        form = {field["name"]: field["value"] for field in first_scene()["fields"]}
        more = {"do": "file", "name": "../../my stone.obj", "parts": 2, "unit": "mm", "side": "outside", "at": "60 0 0", "diameter": "0.02"}
        parts = [base64.b64encode(part.encode()).decode() for part in (mesh[:100], mesh[100:])]

        def drop(socket, **other):
            for k, part in enumerate(parts):
                socket.send(json.dumps(more | {"part": k, "data": part} | other))

        with self.socket() as socket:
            told(socket, "whole")
            drop(socket)
            self.assertEqual(told(socket, "made")["line"], "body my-stone.h5 outside")
            socket.send(json.dumps({"do": "draw", "form": form | {"contact_diameter": "0.02", "walls": "body my-stone.h5 outside"}}))
            drawn = told(socket, "drawn")
            places = drawn["length"] * np.reshape(drawn["walls"][0]["vertices"], (-1, 3))
            np.testing.assert_allclose([places.min(axis=0), places.max(axis=0)], [[0.05, -0.01, -0.01], [0.07, 0.01, 0.01]], atol=2e-3)
            self.assertTrue(drawn["space"])
            for other, line in (({"name": "stone.exe"}, "give a mesh"), ({"unit": "parsec"}, "parsec: give one of"), ({"side": "under"}, "inside or outside"),
                                ({"at": "6 0"}, "three numbers"), ({"data": "?", "part": 0}, "cannot be read"),
                                ({"part": 1, "name": "another"}, "beginning has not come"), ({"data": "bm90aGluZw==", "parts": 1, "part": 0}, "^my-stone-dropped.obj: ")):
                with self.subTest(line):
                    if "part" in other:
                        socket.send(json.dumps(more | {"data": parts[0]} | other))
                    else:
                        drop(socket, **other)
                    self.assertRegex(told(socket, "refused", field="file")["text"], line)
        self.assertEqual(sorted(file.name for file in Path(self.live.server.directory.name).rglob("*stone*.obj")), ["my-stone-dropped.obj"])

    def test_a_form_names_the_field_that_is_wrong(self):
        from tendril.starting_page import first_scene

        first = first_scene()
        form = {field["name"]: field["value"] for field in first["fields"]} | {"walls": first["walls"]}
        with self.socket() as socket:
            told(socket, "whole")
            socket.send(json.dumps({"do": "draw", "form": form}))
            self.assertEqual(len(told(socket, "drawn")["walls"]), 2)
            for name, value in (("contact_diameter", "thick"), ("rod_cells", "1"), ("si_speed", "-1"), ("walls", "circle 1cm 0 8mm outside"), ("walls", "ball 1 2"),
                                ("growth_type", "magic"), ("ts_max_time", "20 parsecs")):
                with self.subTest(value):
                    socket.send(json.dumps({"do": "draw", "form": form | {name: value}}))
                    self.assertEqual(told(socket, "refused")["field"], name)


class Sessions(unittest.TestCase):
    """Without a page."""

    def test_a_scene_with_a_table_is_gone_on_with_back_in_and_saved(self):
        from tendril.playing import prepare
        from tendril.sessions import Session, differs

        with tempfile.TemporaryDirectory() as directory:
            place = Path(directory)
            (place / "said.txt").write_text("# t\n0.2 feed_speed 0.5\n0.9 feed_speed 0.25 # slower\n")
            session = Session(prepare(None, STONES | dict(wall_file=["plane 0 -5 0 1"], change_file=str(place / "said.txt"), ts_max_time=1.2,
                                                           output_interval=0.1), place), place, results=place)

            def until(t):
                while session.sim.t < t and not session.branch.ended:
                    session.step()
                    session.look()

            until(0.3)
            session.do_set({"name": "friction_factor", "value": 2})
            for t in (0.45, 0.5):  # one at a change, one before it
                until(t)
                session.branch.kept.append((session.sim.t, place / f"kept-{t}.h5"))
                session.sim.save(session.branch.kept[-1][1])
            session.do_set({"name": "friction_factor", "value": 3})
            until(0.8)
            for t, undo in ((0.7, False), (None, True)):
                if undo:
                    session.obey({"do": "undo"})
                    self.assertEqual([float(c[2]) for c in session.branch.all_changes()], [2.0])
                else:
                    session.obey({"do": "back", "t": t})
                    self.assertEqual([float(c[2]) for c in session.branch.all_changes()], [2.0, 3.0])
                until(2)
                self.assertAlmostEqual(session.sim.series["length"][-1], 1 + 0.2 + 0.5 * 0.7 + 0.25 * 0.3, delta=1e-9)
                self.assertEqual(len(session.table()), 4 - undo)
                session.save_played("again")
                rows = np.column_stack([session.sim.series[name] for name in session.names])
                self.assertEqual(differs(place / "again" / "again.opts", session.names, rows)[0], 0)

    def test_a_lamp_is_where_it_was_put_also_when_it_is_gone_back(self):
        from tendril.playing import prepare
        from tendril.sessions import Session

        with tempfile.TemporaryDirectory() as directory:
            shoot = dict(growth_type="uniform", growth_initial_length=0.5, tropism_light=3, tropism_source="4,1", friction_mu=0, shape_type="straight",
                         ts_max_time=1.5, rod_cells=40)
            session, ends = Session(prepare(None, shoot, directory), Path(directory)), []
            self.assertEqual(session.whole()["lamp"], [4, 1, 0])
            for place, t in (([3, 2], 0.3), ([4, -1], 0.6)):
                while session.sim.t < t:
                    session.step()
                    session.look()
                session.obey({"do": "lamp", "place": place})
                self.assertEqual(session.whole()["lamp"], [*place, 0])
                ends.append(session.sim.t)
            while not session.branch.ended:
                session.step()
                session.look()
            self.assertLess(session.sim.theta[-1], 0)
            self.assertEqual([[float(x) for x in c[2].split(",")] for c in session.branch.all_changes()], [[3, 2], [4, -1]])
            session.obey({"do": "back", "t": 0.5 * sum(ends)})
            session.step()
            self.assertEqual(session.whole()["lamp"], [3, 2, 0])
            with self.assertRaisesRegex(tendril.TendrilError, "would stand on the rod"):
                session.do_lamp({"place": (session.sim.nodes["x"][20] + 1e-5).tolist()})
            while not session.branch.ended:
                session.step()
                session.look()
            self.assertGreater(session.sim.theta[-1], 0)

    def test_a_wall_is_turned_from_where_its_line_has_it(self):
        from tendril.playing import prepare
        from tendril.sessions import Session
        from tendril.walls import parse

        with tempfile.TemporaryDirectory() as directory:
            scene = dict(growth_type="feed", growth_initial_length=1, shape_amplitude=0.05, contact_diameter=0.1, rod_cells=20, ts_max_time=1,
                         wall_file=["polygon outside 1 2 3 2 2 3 turns -0.5 1 2 0 0 0 -1", "circle 1 -2 0.5 outside moves 0 0.1 0", "plane 0 -5 0 1"])
            for space in ({}, {"rod_model": "space"}):
                session = Session(prepare(None, scene | space, directory), Path(directory))
                self.assertEqual([wall["about"] for wall in session.scene()["walls"]], [[1, 2, 0, 0, 0, -1], [1, -2, 0, 0, 0, 1], [0, -5, 0, 0, 0, 1]])
                while session.sim.t < 0.3:
                    session.step()
                begin = session.sim.t
                for line, angle in ((1, 0.4), (2, -1), (3, 0.1)):
                    session.do_turn({"line": line, "angle": angle})
                np.testing.assert_allclose(session.walls_now(begin)["1"], [0, 0, 0, -0.5 * begin])
                while session.sim.t < begin + 0.1:
                    session.step()
                np.testing.assert_allclose([session.walls_now(session.sim.t)[line] for line in "123"],
                                           [[0, 0, 0, 0.4], [0, 0.1 * session.sim.t, 0, -1], [0, 0, 0, 0.1]], atol=1e-12)
                session.sim.save(Path(directory) / "turned.h5")
                polygon, _, plane = (wall.at(session.sim.t) for wall in parse(tendril.load(Path(directory) / "turned.h5").attributes["walls"]))
                c, s = np.cos(0.4), np.sin(0.4)
                np.testing.assert_allclose(polygon.numbers[:4], [1, 2, 1 + 2 * c, 2 - 2 * s], atol=1e-12)
                np.testing.assert_allclose(plane.numbers, [0, -5, -np.sin(0.1), np.cos(0.1)], atol=1e-12)

    def test_a_saved_scene_has_all_files_that_its_walls_name(self):
        from tendril.playing import prepare, save_scene

        with tempfile.TemporaryDirectory() as directory:
            place = Path(directory)
            for k in (1, 2):
                (place / f"d{k}").mkdir()
                (place / f"d{k}" / ("walls.txt" if k == 1 else "duct.csv")).write_text(f"x1,x2,x3,radius\n0,0,0,0.{k}\n1,0,0,0.{k}\n")
            (place / "walls.txt").write_text("tube d1/walls.txt inside # d1\n\ntube d2/duct.csv inside friction 0.1\n")
            file = save_scene(prepare(None, {"wall_file": str(place / "walls.txt")}, place), [], place, "saved")
            rows = (file.parent / "walls.txt").read_text().splitlines()
            self.assertEqual([(file.parent / rows[k].split()[1]).read_text() for k in (0, 2)], [(place / "d1/walls.txt").read_text(), (place / "d2/duct.csv").read_text()])
            self.assertEqual(rows[2].split()[2:], ["inside", "friction", "0.1"])

    def test_each_wall_beside_a_rod_that_sees_a_lamp_is_drawn_alone(self):
        from tendril.playing import prepare
        from tendril.sessions import Session, drawn_walls

        with tempfile.TemporaryDirectory() as directory:
            scene = dict(growth_type="apical", growth_zone=0.5, growth_initial_length=1, shape_type="straight", rod_cells=20, rod_model="space",
                         tropism_light=1, tropism_source="9,1,2", contact_diameter=0.1, wall_file=["sphere 5 0 3 0.5 outside", "sphere 5 3 0 0.5 outside moves 1 0 0"])
            session = Session(prepare(None, scene, directory), directory)
            self.assertEqual(session.scene()["lamp"], True)
            self.assertEqual(session.lamp_at, [9, 1, 2])
            for wall, middle in zip(drawn_walls(session), ([5, 0, 3], [5, 3, 0])):
                off = np.linalg.norm(np.reshape(wall["vertices"], (-1, 3)) - middle, axis=1)
                np.testing.assert_allclose(off, 0.5, atol=1e-4)

    def test_what_happens_in_many_steps_is_told_once(self):
        from tendril.playing import prepare
        from tendril.sessions import Session

        with tempfile.TemporaryDirectory() as directory:
            session = Session(prepare(None, dict(rod_cells=20), directory), directory)
            rows = np.zeros((8, len(session.names)))
            for name, values in (("t", range(8)), ("contacts", [0, 2, 0, 3, 3, 0, 1, 1]), ("self_crossings", [0, 0, 1, 1, 1, 1, 1, 2]),
                                 ("tip_speed", [0, 0, 50, 60, 0, 0, 0, 0]), ("newton_iterations", 8 * [20])):
                rows[:, session.names.index(name)] = values
            self.assertEqual(session.news(rows, 0), ["it touches, 3 times", "it lets go, 2 times", "it crosses itself, 2 times", "it snaps"])
            self.assertEqual(session.news(rows[4:5].repeat(2, 0), 1.5), ["a step took 1.5 s: 20 iterations: contact or friction changes all along the rod"])
            self.assertEqual(session.news(rows[4:6], 1.5)[-1], "a step took 1.5 s: what touches changes")

    def test_states_that_are_kept_are_few_and_small_together(self):
        from tendril import sessions
        from tendril.playing import prepare

        with tempfile.TemporaryDirectory() as directory:
            place = Path(directory)
            session = sessions.Session(prepare(None, dict(rod_cells=20), place), place)
            for k in range(5):
                for kind in ("h5", "xmf"):
                    (place / f"{k}.{kind}").write_bytes(100 * b" ")
                session.branch.kept.append((float(k), place / f"{k}.h5"))
            for most, left in ((500, [0, 1, 2, 3, 4]), (499, [0, 2, 4]), (1, [0, 4])):
                with unittest.mock.patch.object(sessions, "KEPT_BYTES", most):
                    session.forget()
                self.assertEqual([t for t, _ in session.branch.kept], left)
                self.assertEqual(sorted(file.name for file in place.glob("[0-9].*")), [f"{k}.{kind}" for k in left for kind in ("h5", "xmf")])

    def test_what_is_kept_for_pages_is_bounded(self):
        from tendril import sessions

        branch = sessions.Branch(0)
        for k in range(20_000):
            branch.add([float(k), 0.0])
        self.assertEqual((len(branch.times), branch.rows[0][0], branch.rows[-1][0]), (20_000, 0, 19_999))
        self.assertLessEqual(len(branch.rows), 2 * sessions.ROWS)
        self.assertLess(np.diff([row[0] for row in branch.rows]).max(), 40)


class Command(unittest.TestCase):
    def setUp(self):
        if connect is None:
            self.skipTest("the library websockets is not there: pip install websockets")

    def test_ctrl_c_leaves_a_run_that_can_be_gone_on_with(self):
        with tempfile.TemporaryDirectory() as directory:
            process, address = started("feed", results=directory)
            with connect(address.replace("http", "ws").replace("/?", "/ws?"), max_size=None) as socket:
                told(socket, "whole")
                socket.send(json.dumps({"do": "set", "name": "feed_speed", "value": 0.5}))
                socket.send(json.dumps({"do": "pace", "pace": None}))
                socket.send(json.dumps({"do": "run"}))
                while told(socket, "frame")["t"] < 0.5:
                    pass
            code, said, complaint = ended(process)
            self.assertEqual((code, complaint), (0, ""))
            file = Path(directory) / "feed-played.h5"
            self.assertIn(str(file), said)
            on = tendril.Simulation.load(file, ts_max_time=20)  # a quick machine is at the scene's end before it is told to stop
            self.assertGreater(on.t, 0.5)
            self.assertAlmostEqual(on.series["length"][-1], 2 + 0.5 * on.t, delta=1e-9)
            self.assertTrue(on.step())

    def test_a_server_that_is_killed_leaves_the_run_so_far(self):
        with tempfile.TemporaryDirectory() as directory:
            process, address = started("feed", results=directory)
            self.addCleanup(process.kill)
            file = Path(directory) / "feed-so-far.h5"
            with connect(address.replace("http", "ws").replace("/?", "/ws?"), max_size=None) as socket:
                told(socket, "whole")
                socket.send(json.dumps({"do": "pace", "pace": 0.1}))
                socket.send(json.dumps({"do": "run"}))
                while not file.exists():
                    told(socket, "frame")
                first, begun = file.stat().st_ino, tendril.Simulation.load(file).t
                end = time.monotonic() + 60
                while file.stat().st_ino == first:  # a later state takes its place
                    self.assertLess(time.monotonic(), end)
                    told(socket, "frame")
            process.kill()
            process.communicate(timeout=60)
            on = tendril.Simulation.load(file)
            self.assertGreater(on.t, begun)
            self.assertGreater(begun, 0)
            self.assertAlmostEqual(on.series["length"][-1], 2 + on.t, delta=1e-9)
            self.assertTrue(on.step())

    def test_each_scene_of_the_gallery_can_be_begun(self):
        from tendril.playing import prepare
        from tendril.sessions import Session
        from tendril.starting_page import scenes

        self.assertGreater(len(scenes()), 20)
        for name, file in scenes().items():
            with self.subTest(name), tempfile.TemporaryDirectory() as directory:
                session = Session(prepare(file, {}, directory), directory)
                session.step()
                self.assertGreater(session.whole()["t"], 0)
                json.dumps(session.scene(), allow_nan=False)

    def test_mistakes_are_a_line(self):
        for words, line in ((["no-such-scene"], "no scene of that name"), (["critical"], "nothing that runs"), (["feed", "--port", "70000"], "--port"),
                            (["feed", "--posts", "-1"], "--posts")):
            with self.subTest(words):
                done = subprocess.run([sys.executable, "-m", "tendril", "live", "--no-browser", *words], capture_output=True, text=True, timeout=60,
                                      env=os.environ | {"PYTHONPATH": str(ROOT / "scripts")})
                self.assertNotEqual(done.returncode, 0)
                self.assertEqual(len(done.stderr.strip().splitlines()), 1, done.stderr)
                self.assertIn(line, done.stderr)


@unittest.skipUnless(chromium.FOUND, chromium.MISSING)
class Browser(Live):
    def played(self, browser, live):
        """The saved scene run by the program, and the rows that the page has seen."""
        browser.say(f"{PAGE}.send('save', {{what: ['scene']}})")
        browser.until("[...document.querySelectorAll('.l-news .l-good')].some((one) => one.textContent.startsWith('checked'))", 120)
        file = self.results / "mine-played" / "mine-played.opts"
        names, rows = browser.say(f"{PAGE}.S.names"), np.array(live.session.branch.rows)
        with tempfile.TemporaryDirectory() as directory:
            moved = Path(directory) / "elsewhere"
            file.parent.rename(moved)  # all it needs is beside it
            output = Path(directory) / "played.h5"
            done = subprocess.run([PROGRAM, "-options_file", moved / file.name, "-output", output, "-ts_max_steps", str(len(rows) - 1)],
                                  capture_output=True, text=True, timeout=300)
            series = tendril.load(output).series
            self.assertEqual(len(series.t), len(rows), done.stderr)
        for k, name in enumerate(names):
            size = np.abs(rows[:, k]).max() or 1
            self.assertLess(np.abs(series[name] - rows[:, k]).max() / size, 1e-8, name)

    def test_run_touch_go_back_branch_save(self):
        with tendril.live(results=self.results, **STONES) as live, chromium.Chromium() as browser:
            browser.go(live.address)
            browser.until(f"{PAGE} && {PAGE}.S.frame")
            browser.press(".")
            browser.until(f"{PAGE}.S.t > 0")
            browser.say(f"{PAGE}.send('pace', {{pace: 0.6}})")
            browser.press(" ", "Space")
            browser.until(f"{PAGE}.S.t > 0.3")
            browser.press("ArrowLeft")
            browser.until(f"{PAGE}.S.values.feed_speed === -1")
            browser.press("ArrowRight")
            browser.until(f"{PAGE}.S.values.feed_speed === 1 && {PAGE}.S.t > 0.45")
            browser.press(" ", "Space")
            browser.until(f"!{PAGE}.S.running")
            browser.say("(() => { const box = document.querySelector('[aria-label=\"friction, times\"][type=number]'); box.value = 2; box.dispatchEvent(new Event('change')); })()")
            browser.until(f"{PAGE}.S.values.friction_factor === 2")
            # the first stone is dragged upwards, into the way of the rod
            stone = json.loads(browser.say(f"""(() => {{ const {{S, stage}} = {PAGE}, box = document.querySelector('.l-stage canvas').getBoundingClientRect();
              const [x, y] = stage.place(1.6, -0.75, 0); return JSON.stringify([x + box.left, y + box.top, stage.scale]); }})()"""))
            browser.press(" ", "Space")
            browser.drag(stone[:2], (stone[0] - 0.1 * stone[2], stone[1] - 0.35 * stone[2]))
            browser.until(f"({PAGE}.S.walls['1'] || [0, 0])[1] > 0.3")
            # ... and turned by its handle, by a quarter to the left
            knob = json.loads(browser.say(f"""(() => {{ const {{S, stage}} = {PAGE}, box = document.querySelector('.l-stage canvas').getBoundingClientRect();
              return JSON.stringify(stage.handle(S.scene.walls[0], S.walls['1']).map(([x, y]) => [x + box.left, y + box.top])); }})()"""))
            browser.drag(knob[1], (knob[0][0], knob[0][1] - (knob[1][0] - knob[0][0])))
            browser.until(f"Math.abs({PAGE}.S.walls['1'][3] - Math.PI / 2) < 0.05")
            browser.until(f"{PAGE}.S.t > 1.2")
            browser.press(" ", "Space")
            browser.until(f"!{PAGE}.S.running")
            seen = dict(zip(live.session.names, np.array(live.session.branch.rows).T))
            self.assertGreater(seen["wall_force_2"].max(), 0)
            self.assertLess(np.abs(seen["energy_defect"]).max(), 1e-3)
            self.played(browser, live)
            # back, and on from there without the stone
            came = browser.say(f"{PAGE}.S.t")
            browser.say("(() => { const slider = document.querySelector('.l-slider'); slider.value = 500; slider.dispatchEvent(new Event('input')); })()")
            browser.until("[...document.querySelectorAll('button')].some((one) => one.textContent === 'go on from here' && !one.hidden)")
            browser.say("[...document.querySelectorAll('button')].find((one) => one.textContent === 'go on from here').click()")
            browser.until(f"{PAGE}.S.branch === 1 && {PAGE}.S.branches.length === 2")
            parted = browser.say(f"{PAGE}.S.t")
            self.assertTrue(0.45 * came < parted < 0.55 * came, (parted, came))
            browser.press("z")
            browser.until(f"{PAGE}.S.branches.length === 3")
            browser.press("ArrowDown")
            browser.until(f"{PAGE}.S.values.feed_speed === 0")
            browser.press(".")
            browser.until(f"{PAGE}.S.changes.length > 0")
            browser.press(" ", "Space")
            browser.until(f"{PAGE}.S.t > {parted} + 0.2")
            browser.press(" ", "Space")
            browser.until(f"!{PAGE}.S.running")
            self.played(browser, live)
            browser.say("location.reload()")
            browser.until(f"{PAGE} && {PAGE}.S.branches.length === 3 && {PAGE}.S.rows.length > 10")
            self.assertEqual(browser.complaints, [])

    def test_on_a_phone_by_touch(self):
        with chromium.Chromium((390, 844), touch=True) as browser:
            browser.go(self.live.address)
            browser.until(f"{PAGE} && {PAGE}.S.frame && {PAGE}.stage.now")
            self.assertLessEqual(browser.say("document.documentElement.scrollWidth"), 390)
            browser.until(f"(async () => {{ const at = () => {PAGE}.stage.tip({PAGE}.S.frame), a = at(); await new Promise((go) => setTimeout(go, 150)); "
                          "const b = at(); return Math.hypot(a[0] - b[0], a[1] - b[1]) < 0.05; })()")  # the view has come to rest
            tip = json.loads(browser.say(f"""(() => {{ const {{S, stage}} = {PAGE}; document.querySelector('.l-stage').scrollIntoView();
              const box = document.querySelector('.l-stage canvas').getBoundingClientRect(), [x, y] = stage.tip(S.frame); return JSON.stringify([x + box.left, y + box.top]); }})()"""))
            before = browser.say(f"{PAGE}.S.changes.length")
            browser.drag(tip, (tip[0] + 5, tip[1] - 70))
            browser.until(f"{PAGE}.S.changes.length > {before} && Math.hypot(...{PAGE}.S.hand) > 0.5")
            self.assertGreater(browser.say(f"{PAGE}.S.hand[1]"), 0.5)
            self.assertEqual(browser.complaints, [])

    def test_from_nothing_to_a_picture_of_ones_own_scene(self):
        from tendril.starting_page import first_scene

        click = "[...document.querySelectorAll('button')].find((one) => one.textContent === '%s').click()"
        text = "document.querySelector('.l-walls').value"
        with tendril.live(results=self.results) as live, chromium.Chromium() as browser:
            browser.go(live.address)
            browser.until("document.querySelectorAll('.l-card img').length > 10 && document.querySelector('.hint').textContent.includes('cm')")
            self.assertTrue(browser.say("document.getElementById('home').hidden"))
            browser.call("Emulation.setDeviceMetricsOverride", width=390, height=844, deviceScaleFactor=1, mobile=True)
            self.assertLessEqual(browser.say("document.documentElement.scrollWidth"), 390)
            node = browser.call("DOM.querySelector", nodeId=browser.call("DOM.getDocument")["root"]["nodeId"], selector="input[type=file]")["nodeId"]
            (self.results.parent / "my duct.csv").write_text("x,y,z,r\n" + "".join(f"{10 * k},0,{k * k},12\n" for k in range(9)))
            browser.call("DOM.setFileInputFiles", nodeId=node, files=[str(self.results.parent / "my duct.csv")])
            browser.until(f"{click % 'make a wall of it'} || true")
            browser.until(f"{text}.includes('tube my-duct.csv inside')")
            self.assertLessEqual(browser.say("document.documentElement.scrollWidth"), 390)
            browser.call("Emulation.setDeviceMetricsOverride", width=1400, height=900, deviceScaleFactor=1, mobile=False)
            browser.say(f"(() => {{ const one = document.querySelector('.l-walls'); one.value = one.value.split('\\n').filter((line) => line.startsWith('tube')).join('\\n'); "
                        "one.dispatchEvent(new Event('input')); })()")
            browser.until(f"{PAGE}.S.drawn && {PAGE}.S.drawn.space && {PAGE}.S.drawn.walls[0].vertices.length > 300")
            browser.say(f"(() => {{ const one = document.querySelector('.l-walls'); one.value = {json.dumps(first_scene()['walls'])}; one.dispatchEvent(new Event('input')); }})()")
            for value, wrong in (("-1", True), ("3mm", False)):
                browser.say(f"(() => {{ const one = document.querySelector('[aria-label=diameter]'); one.value = '{value}'; one.dispatchEvent(new Event('input')); }})()")
                browser.until(f"[...document.querySelectorAll('.l-field .l-why')].some((one) => one.textContent) === {str(wrong).lower()}")
            browser.until(f"{PAGE}.S.drawn && {PAGE}.S.drawn.walls.length === 2")
            stone = json.loads(browser.say(f"""(() => {{ const one = {PAGE}.S.drawn.stage, [x, y] = one.place(...{PAGE}.S.drawn.walls[0].circle), box = one.canvas.getBoundingClientRect();
              return JSON.stringify([x + box.left, y + box.top, one.scale * 0.01 / {PAGE}.S.drawn.length]); }})()"""))
            browser.drag(stone[:2], (stone[0] - stone[2], stone[1] + 0.5 * stone[2]))  # a centimetre to the left, half one down
            self.assertRegex(browser.say(text), r"\ncircle (5|4.99|5.01)cm (0.6|0.59\d|0.60\d)cm 8mm outside\ncircle 9cm")
            browser.say(click % "add a stone")
            browser.until(f"{PAGE}.S.drawn.walls.length === 3")
            browser.say(click % "run it")
            browser.until(f"{PAGE}.S.scene && {PAGE}.S.frame && {PAGE}.S.t > 1")  # a click runs
            browser.press(" ", "Space")
            browser.say(click % "picture")
            browser.until("[...document.querySelectorAll('.l-files img')].some((one) => one.naturalWidth > 500)")
            self.assertEqual(browser.complaints, [])


class Watching(unittest.TestCase):
    """Sweeps and fits that are seen while they go on."""

    OVER = {"friction_mu": [0, 0.5, 7], "rod_curvature": [0.05, 0.2]}
    FEW = dict(growth_type="feed", growth_initial_length=1, rod_cells=30, ts_max_time=1, progress=False)

    def test_members_of_a_sweep_are_told_once_each(self):
        for more, space in (({}, False), ({"rod_model": "space"}, False), ({"rod_curvature_2": 0.01}, True)):  # in space they have a process each
            messages = []
            found = tendril.sweep(None, self.OVER, jobs=1, watch=messages.append, **self.FEW, **more)
            json.dumps(messages, allow_nan=False)
            self.assertEqual([m["kind"] for m in messages], ["study", *6 * ["member"], "ended"])
            self.assertEqual([[axis["name"], axis["texts"], axis["numbers"]] for axis in messages[0]["axes"]],
                             [["friction_mu", ["0", "0.5", "7"], [0, 0.5, 7]], ["rod_curvature", ["0.05", "0.2"], [0.05, 0.2]]])
            self.assertEqual([tuple(point) for point in messages[0]["points"]], [(i, j) for i in range(3) for j in range(2)])
            self.assertEqual(sorted(m["k"] for m in messages[1:-1]), list(range(6)))
            for m in messages[1:-1]:
                r = found.members.flat[m["k"]]
                if m["k"] < 4:
                    self.assertEqual((m["failed"], m["values"]["energy"]), ("", r.series["energy"][-1]))
                    x, last = np.frombuffer(base64.b64decode(m["x"]), "<f4").reshape(31, 3), r.shapes["x"][-1].astype("<f4")
                    np.testing.assert_array_equal(x[:, :last.shape[1]], last)
                    self.assertEqual((m["space"], bool(x[:, 2].any())), (space, space))
                else:
                    self.assertIn("friction_mu 7", m["failed"])

    def test_a_member_that_is_looked_at_again_is_not_told_again(self):
        from tendril.sweep_seen import SweepSeen

        messages = []
        found = tendril.sweep(None, self.OVER, jobs=1, **self.FEW)
        seen = SweepSeen(messages.append, None, self.OVER)
        for status in ([1, 0, 0, 1, 0, 0], found.status, found.status):  # as its file has it while it goes on
            whole, found.status = found.status, np.array(status)
            seen.look(found)
            found.status = whole
        self.assertEqual([m["k"] for m in messages[1:]], [0, 3, 1, 2, 4, 5])

    def test_what_is_kept_for_a_page_that_comes_later(self):
        """Of the points of a fit the latest, and the best before them; of another study nothing."""
        from tendril.watching import LATEST, Study

        study, tried = Study(), [{"kind": "tried", "better": k == 3, "k": k} for k in range(5 * LATEST)]
        for message in ({"kind": "study"}, *tried, {"kind": "ended"}):
            study.take(message)
        whole = study.whole()
        self.assertEqual((whole[0]["kind"], whole[1], whole[-2], whole[-1]["kind"]), ("study", tried[3], tried[-1], "ended"))
        self.assertTrue(LATEST <= len(whole) - 3 <= 2 * LATEST, len(whole))
        self.assertEqual([m["k"] for m in whole[2:-1]], list(range(whole[2]["k"], 5 * LATEST)))
        study.take({"kind": "fresh"})
        self.assertNotIn(tried[3], study.whole())
        study.take({"kind": "study", "what": "sweep"})
        self.assertEqual(study.whole(), [{"kind": "study", "what": "sweep"}])

    def test_the_rods_that_a_fit_tries(self):
        r = tendril.run(None, **self.FEW, rod_curvature=0.4)
        with tempfile.TemporaryDirectory() as directory:
            file = Path(directory) / "photo.csv"
            rng = np.random.default_rng(1)
            np.savetxt(file, r.shapes.x[-1] + 1e-3 * rng.normal(size=(31, 2)), delimiter=",", header="x1,x2", comments="")
            page = tendril.watch()
            try:
                messages = []
                options = {k: v for k, v in self.FEW.items() if k not in ("progress", "ts_max_time")}
                fit = tendril.fit(None, {1: str(file)}, {"rod_curvature": (0.1, 1)}, watch=lambda m: (messages.append(m), page(m)), starts=2, jobs=1, **options)
                json.dumps(messages, allow_nan=False)
                tried = [m for m in messages if m["kind"] == "tried"]
                self.assertEqual(([m["kind"] for m in messages[:1]], messages[-1]["kind"]), (["study"], "ended"))
                self.assertGreater(len(tried), 3)
                self.assertEqual(tried[-1]["values"]["rod_curvature"], fit.values["rod_curvature"])
                self.assertEqual([(one["name"], one["low"], one["high"], one["log"]) for one in messages[0]["parameters"]],
                                 [(p.name, p.low, p.high, p.logarithmic) for p in fit.parameters])
                self.assertEqual((fit.parameters[0].low, fit.parameters[0].high), (0.1, 1))
                line, points = (np.frombuffer(base64.b64decode(packed), "<f4").reshape(-1, 2)
                                for packed in (tried[-1]["lines"][0], messages[0]["photographs"][0]["points"]))
                self.assertLess(np.abs(line[-1] - r.shapes.x[-1][-1]).max(), 3e-3)
                self.assertLess(np.abs(points - r.shapes.x[-1]).max(), 5e-3)
                least = np.inf
                for m in messages[:-2]:  # behind them is what was found
                    least = np.inf if m["kind"] == "fresh" else least
                    if m["kind"] == "tried":
                        self.assertEqual(m["better"], m["cost"] < least)
                        least = min(least, m["cost"])
                self.assertEqual((messages[-2]["kind"], messages[-2]["better"], messages[-2]["cost"]), ("tried", True, fit.cost))
                off = [abs(m["values"]["rod_curvature"] - 0.4) for m in tried]
                self.assertLess(off[-1], max(off))
                with connect(page.address.replace("http", "ws").replace("/?", "/ws?"), max_size=None) as socket:  # who comes later
                    self.assertEqual(told(socket, "study")["parameters"][0]["name"], "rod_curvature")
                    self.assertEqual(told(socket, "ended")["text"], fit.report())
                    socket.send('{"do": "start", "scene": "feed"}')
                    self.assertIn("only looked at", told(socket, "refused")["text"])
            finally:
                page.close()

    @unittest.skipUnless(chromium.FOUND, chromium.MISSING)
    def test_its_page_fills(self):
        with tendril.watch() as page, chromium.Chromium((390, 844)) as browser:
            study = "document.getElementById('live').study"
            browser.go(page.address)
            tendril.sweep(None, self.OVER, jobs=1, watch=page, **self.FEW)
            browser.until(f"{study} && {study}.S.ended && {study}.S.done === 6 && {study}.S.failed === 2")
            browser.drawn()  # messages change S at once, and what is seen in the next frame
            self.assertLessEqual(browser.say("document.documentElement.scrollWidth"), 390)
            self.assertIn("6 of 6 runs, 2 failed", browser.say("document.querySelector('.l-told').textContent"))
            browser.say(f"(() => {{ {study}.S.picked = true; {study}.S.chosen = 5; {study}.draw(); }})()")
            self.assertIn("too large", browser.say("document.querySelector('.hint').textContent"))
            tendril.sweep(None, {"friction_mu": [0, 0.5]}, jobs=1, watch=page, **self.FEW)
            browser.until(f"{study}.S.first.axes.length === 1 && {study}.S.ended")
            self.assertEqual(browser.complaints, [])

    def test_the_command(self):
        with tempfile.TemporaryDirectory() as directory:
            done = subprocess.run([sys.executable, "-m", "tendril", "sweep", "-growth_type", "feed", "-rod_cells", "30", "-ts_max_time", "0.5", "-friction_mu", "0.2,0.5",
                                   "--live", "--no-browser", "--no-picture", "--output", f"{directory}/s.h5"], capture_output=True, text=True, timeout=120,
                                  env=os.environ | {"PYTHONPATH": str(ROOT / "scripts")})
            self.assertEqual(done.returncode, 0, done.stderr)
            self.assertTrue(done.stdout.startswith("http://127.0.0.1:"), done.stdout)
            self.assertIn("2 runs", done.stdout)


class Widget(unittest.TestCase):
    """The page in a notebook's cell."""

    def setUp(self):
        try:
            import anywidget  # noqa: F401
        except ImportError:
            self.skipTest("the library anywidget is not there: pip install anywidget")

    def test_a_notebook_runs_it(self):
        import nbformat
        from nbclient import NotebookClient

        code = ["import tendril, time", "w = tendril.widget('feed', rod_cells=60, ts_max_time=1)", "w",
                "w.session.do({'do': 'pace', 'pace': None}); w.session.do({'do': 'set', 'name': 'feed_speed', 'value': 0.5}); w.session.do({'do': 'run'})",
                "while not w.session.branch.ended: time.sleep(0.05)", "print(w.session.sim.t, w.session.sim.series['length'][-1]); w.close()"]
        book = nbformat.v4.new_notebook(cells=[nbformat.v4.new_code_cell(text) for text in code])
        os.environ["PYTHONPATH"] = f"{ROOT / 'scripts'}:{os.environ.get('PYTHONPATH', '')}"
        NotebookClient(book, timeout=120, kernel_name="python3").execute()
        self.assertIn("application/vnd.jupyter.widget-view+json", book.cells[2].outputs[0]["data"])
        self.assertEqual(book.cells[5].outputs[0]["text"].split(), ["1.0", "2.5"])

    @unittest.skipUnless(chromium.FOUND, chromium.MISSING)
    def test_its_script_draws_it(self):
        from tendril.live_widget import script, widget

        sent = []
        one = widget("feed", rod_cells=60, ts_max_time=1)
        one.sender.send = sent.append
        one.hear(None, {"do": "greet"}, None)
        one.hear(None, {"do": "step"}, None)
        end = time.monotonic() + 30
        while "frame" not in [m["kind"] for m in sent] and time.monotonic() < end:
            time.sleep(0.05)
        with chromium.Chromium() as browser:
            browser.say(f"""(async () => {{
              const module = await import(URL.createObjectURL(new Blob([{json.dumps(script())}], {{ type: "text/javascript" }})));
              window.said = []; window.model = {{ send: (m) => window.said.push(m), on: (what, f) => {{ window.hear = f; }} }};
              const el = document.createElement("div"); el.id = "live"; document.body.append(el); module.default.render({{ model: window.model, el }}); }})()""")
            for message in sent:
                browser.say(f"window.hear({json.dumps(message)})")
            browser.until(f"{PAGE}.S.frame && {PAGE}.stage.now && document.querySelectorAll('.l-chart canvas').length > 2")
            browser.press(" ", "Space")
            self.assertEqual(browser.say("JSON.stringify(window.said)"), '[{"do":"greet"},{"do":"run"}]')
            self.assertEqual(browser.complaints, [])
        one.close()


if __name__ == "__main__":
    sys.argv.pop(1)
    os.environ["TENDRIL"] = str(PROGRAM)
    os.environ.setdefault("TENDRIL_LIBRARY", str(PROGRAM.parent / "libtendril.so"))
    unittest.main(verbosity=2)

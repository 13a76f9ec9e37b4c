"""A run that is touched while it goes on: a simulation in a thread of its own, what was changed in it, and the branches that
it has. It knows nothing of who looks at it: what there is to see goes to a function."""

from __future__ import annotations

import contextlib
import ctypes
import os
import queue
import shutil
import threading
import time
from array import array
from collections import Counter, deque
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path

import numpy as np

from .courses import shift_of, turned
from .errors import RunError, TendrilError
from .outbox import ROWS, thin
from .playing import NUMBER, Played, controls, may_lead_tip, said_rows, save_scene, senses
from .results import Table
from .runs import run
from .senses import lamp, number
from .simulation import BY_WORDS, Simulation
from .surroundings import vector_of

KEEP_AT_MOST = 0.025  # of the time that it runs, for states to go back to
KEPT = 60  # of these, of a branch
KEPT_BYTES = 1e9  # of these, too
KEEP_STEP = 5e-5  # seconds, of a state, that each step before it takes: until one was kept
UNHURRIED = 20  # seconds that a run takes at first, if it can
HAPPENINGS = 500  # the latest that are kept
FRAMES = 240  # of a branch that are kept, to be looked at
TOUCH = 0.35  # seconds in which what is dragged comes to where it was dragged
SLOW = 0.7  # seconds: a step that takes longer is told
LOOKS = 1 / 30  # seconds between looks, at least: who looks sees no more
LOOK_AT_MOST = 0.025  # of the time of computing, for looks, where the run does not wait anyway; to send them takes as much
FAST = 30  # times the speed of growing: a place as fast snaps


@dataclass
class Branch:
    """A run from its beginning. Of what it shares with its parent it keeps nothing: changes are those since it parted."""

    number: int
    parent: Branch | None = None
    since: float = 0.0  # when it parted
    changes: list = field(default_factory=list)  # (t, what, value)
    kept: list = field(default_factory=list)  # (t, file): states to go back to
    times: array = field(default_factory=lambda: array("d"))  # at which its steps ended, from the beginning
    rows: list = field(default_factory=list)  # of the series, thinned, from the beginning; the last is always there
    frames: list = field(default_factory=list)  # (t, frame), from the beginning
    happened: list = field(default_factory=list)  # (t, text)
    ended: str = ""

    def add(self, row):
        self.times.append(row[0])
        self.rows.append(array("d", row))
        thin(self.rows)

    def all_changes(self, until=np.inf):
        """From the beginning, those in force at a time."""
        before = self.parent.all_changes(self.since) if self.parent else []
        return [c for c in before + self.changes if c[0] <= until]

    def states(self, until):
        """Kept states up to a time, (t, file, how many changes were in force), the latest first."""
        own = [k for k in self.kept if k[0] <= until]
        before = self.parent.states(min(until, self.since)) if self.parent else []
        return sorted(own + before, key=lambda k: -k[0])


class Session:
    """One run with its branches. Commands come by do(), from any thread; `publish` is called, in the run's own thread, with
    what has become of it."""

    def __init__(self, played: Played, directory, publish=lambda message: None, results=".", leaves=False):
        self.played, self.directory, self.publish = played, Path(directory), publish
        self.results = Path(results)
        self.so_far = self.results / f"{played.name}-so-far.h5" if leaves else None  # what is there after all if it is killed
        self.commands: queue.Queue = queue.Queue()
        self.running, self.closing = False, False
        self.written: dict[str, Path] = {}  # the files that a page may fetch
        self.branches: list[Branch] = []
        self.sim = Simulation(**played.options)
        self.setup = self.begun()
        self.courses = courses_of(self)
        self.end = float(self.setup.attributes.get("parameters/ts_max_time", 40))
        self.pace = self.end / UNHURRIED
        self.names = list(self.sim.series)
        self.space = self.sim.space
        self.branch = Branch(0)
        self.branches.append(self.branch)
        self.controls = controls(played, self.space, self.setup) + senses(self.setup)
        at = lamp(self.setup, 3)
        self.lamp_at = None if at is None else at.tolist()
        self.pull_at = vector_of(self.setup, "tropism_direction", 3).tolist() if number(self.setup, "tropism_gravity") else None
        if self.pull_at and not self.space:
            self.controls.append({"name": "pull_angle", "label": "direction of that pull", "value": float(np.arctan2(*self.pull_at[1::-1])), "low": -3.1416,
                                  "high": 3.1416, "unit": "rad", "of": "tropism_direction"})
        self.replay_values([])
        # seconds: since when a step is under way; that it has run, has kept states, that keeping one takes for each step before it
        self.busy_since, self.lived, self.keeping, self.keep_step, self.states = None, 0.0, 0.0, KEEP_STEP, 0
        self.kept_at = self.stepped = time.monotonic()
        self.rates = deque(maxlen=400)  # (when, iterations)
        self.before = None  # nodes of the step before
        self.look_from, self.unseen, self.slowest = 0.0, False, 0.0
        self.idle, self.look_at, self.to_look = True, 0.0, 0.0  # it has waited; the thread's own seconds at the latest look, and of it
        self.lock = threading.RLock()
        self.look()
        self.thread = threading.Thread(target=self.loop, name="tendril live", daemon=True)

    # ---- the thread ----

    def scene(self):
        """What a page must know of the run as a whole."""
        from .page import charts_of, plain
        from .pictures import name_of, symbol_of
        from .units import in_laboratory, laboratory_units

        r = self.setup
        units = laboratory_units([replace(r, series=self.typical())])
        return {"kind": "scene", "name": self.played.name, "space": self.space, "flat": not self.space, "controls": self.controls,
                "walls": drawn_walls(self), "diameter": float(r.diameter), "reach": float(self.typical()["length"][-1]), "leads": may_lead_tip(self.played),
                "pulls": self.played.held == "free", "lamp": self.lamp_at is not None, "posts": len(self.played.posts), "charts": charts_of([r]),
                "labels": {n: plain(name_of(n)) for n in self.names}, "symbols": {n: plain(symbol_of(n)) for n in self.names},
                "factors": {unit: in_laboratory(unit, r.scale)[0] / si for unit, (_, si) in units.items()},
                "units": {unit: name for unit, (name, _) in units.items()},
                "options": "\n".join(f"-{k} {v}" for k, v in self.played.options.items()), "to": None}

    def typical(self):
        """Series as large as those of the run may get, for units that suit them all along."""
        length = float(self.sim.series["length"][0])
        largest = {"t": self.end, "length": length + (self.end if self.played.feeds else length), "base_force_1": length + 1}
        return Table({name: np.append(values, largest.get(name, 1.0)) for name, values in self.setup.series.items()})

    def begin(self):
        self.thread.start()
        return self

    def do(self, command: dict):
        self.commands.put(command)

    def close(self, wait=20.0):
        """Ends it, behind the step that is under way; what it has is saved by who asks for that before."""
        self.closing = True
        self.commands.put({"do": "nothing"})
        if self.thread.is_alive():
            self.thread.join(wait)
        if self.so_far:
            self.so_far.unlink(missing_ok=True)

    def loop(self):
        began, t0 = time.monotonic(), self.sim.t
        while not self.closing:
            wait = self.wait(began, t0)
            self.idle = self.idle or wait is None or wait > 0
            try:
                command = self.commands.get(timeout=wait) if wait is None or wait > 0 else self.commands.get_nowait()
            except queue.Empty:
                command = None
            if command is not None:
                self.obey(command)
                began, t0 = time.monotonic(), self.sim.t
                continue
            if self.running:
                self.step()

    def wait(self, began, t0):
        """Seconds until the next step is due; None: there is none before a command comes."""
        if not self.running or self.branch.ended:
            return None
        if self.pace is None:
            return 0
        return max(0.0, (self.sim.t - t0) / self.pace - (time.monotonic() - began))

    def obey(self, command):
        """One command; what is wrong with it is told to who gave it, and changes nothing."""
        action = getattr(self, f"do_{command.get('do')}", None)
        if self.unseen:
            self.look()
        try:
            if action is None:
                raise TendrilError(f"{command.get('do')}: is nothing that a run can do")
            answer = action(command)
        except Exception as fault:  # whatever a page has sent: the run goes on
            self.publish({"kind": "refused", "command": command, "text": str(fault) or type(fault).__name__, "to": command.get("from")})
            return
        if answer:
            self.publish({"kind": "done", "text": answer, "to": None})
        self.publish(self.state())

    # ---- what it can do ----

    def do_nothing(self, command):
        pass

    def do_run(self, command):
        if not self.branch.ended:
            self.running = True

    def do_pause(self, command):
        self.running = False

    def do_step(self, command):
        self.running = False
        self.step()

    def do_pace(self, command):
        pace = command.get("pace")
        if pace is not None and not 0 < float(pace) < 1e9:
            raise TendrilError("pace: give units of time a second, above 0")
        self.pace = None if pace is None else float(pace)

    def do_set(self, command):
        """A control: its name on the page, and a number."""
        name = str(command["name"])
        control = next((c for c in self.controls if c["name"] == name), None)
        if control is None:
            raise TendrilError(f"{name[:60]}: cannot be changed in this run")
        value = number_of(command["value"], control["label"])
        if name == "pull_angle":
            self.pull = [float(np.cos(value)), float(np.sin(value)), 0.0]
            self.change("tropism_direction", f"{self.pull[0]!r},{self.pull[1]!r}")
        elif control.get("leads"):
            self.change(control["of"], f"{self.soon()!r} {value!r}")
        elif " " in name:
            self.change(control["of"], f"{name.split()[1]} {value!r}")
        else:
            self.change(name, repr(value))
        self.values[name] = value

    def do_hand(self, command):
        """A force on a free tip, as one pulls it."""
        if self.played.held != "free":
            raise TendrilError("the tip is held: it is led, not pulled")
        force = [number_of(f, "force") for f in command["force"]][:3] + [0.0] * (3 - len(command["force"]))
        if not self.space:
            force = force[:2]
        size = float(np.linalg.norm(force))
        most = 50.0
        force = [f * min(1, most / size) if size else 0.0 for f in force]
        self.change("tip_force_vector", ",".join(repr(f) for f in force))
        self.hand = [*force, 0.0][:3]

    def do_lead(self, command):
        """A held tip to a place."""
        if not may_lead_tip(self.played):
            raise TendrilError("the tip of this run cannot be led")
        self.change("tip_to", " ".join([repr(self.soon()), *map(repr, self.place(command))]))

    def do_lamp(self, command):
        """The lamp to a place."""
        if self.lamp_at is None:
            raise TendrilError("there is no lamp in this run")
        place = self.place(command)
        with self.lock:
            off = np.linalg.norm(self.sim.nodes["x"] - [*place, 0.0][:3], axis=1).min()
        if off < max(0.5 * float(self.setup.diameter), 1e-3 * self.sim.series["length"][-1]):
            raise TendrilError("the lamp would stand on the rod, where there is no direction to it; put it beside")
        self.change("tropism_source", ",".join(map(repr, place)))
        self.lamp = [*place, 0.0][:3]

    def do_wall(self, command):
        """A wall to a displacement; at once: it is put there."""
        wall = self.wall(command)
        shift = [number_of(x, "displacement") for x in command["shift"]]
        shift = (shift + [0.0] * 3)[:3]
        if not wall.in_space:
            shift[2] = 0.0  # it stays in its plane
        words = list(map(repr, shift))
        if command.get("at_once"):
            self.change("wall_at", " ".join([str(wall.line), *words]))
        else:
            self.change("wall_to", " ".join([str(wall.line), repr(self.soon()), *words]))
        self.shifts[wall.line] = shift

    def do_turn(self, command):
        """A wall to an angle."""
        wall = self.wall(command)
        self.change("wall_turn_to", f"{wall.line} {self.soon()!r} {number_of(command['angle'], 'angle')!r}")

    def do_post(self, command):
        """Puts one of the posts that wait somewhere."""
        x = [number_of(v, "place") for v in command["place"]][:2]
        for wall in self.played.walls:
            if wall.line in self.played.posts and not any(self.shifts[wall.line]):
                at = [x[0] - float(wall.numbers[0]), x[1] - float(wall.numbers[1]), 0.0]
                return self.do_wall({"line": wall.line, "shift": at, "at_once": True})
        raise TendrilError("no post is left; begin with more (--posts)")

    def do_back(self, command):
        """To an earlier time: a new branch parts there."""
        self.part(number_of(command["t"], "time"), self.which(command))

    def do_undo(self, command):
        """Back to before the latest change of this branch."""
        changes = self.branch.all_changes()
        if not changes:
            raise TendrilError("nothing was changed")
        last = changes[-1][0]
        self.part(last, self.branch, but=[c for c in changes if c[0] < last] + [c for c in changes if c[0] == last][:-1])
        return f"undone: {changes[-1][1]} {changes[-1][2]}"

    def do_branch(self, command):
        """To the end of another branch, where it was left."""
        branch = self.which(command)
        self.running = False
        self.go_to(branch, branch.rows[-1][0] if branch.rows else 0.0, branch.all_changes())
        self.branch = branch
        self.publish(self.whole())

    def do_save(self, command):
        kinds = command.get("what", ["scene"])
        return "; ".join(self.save(str(kind)) for kind in kinds)

    # ---- inside ----

    def place(self, command):
        """A place in as many numbers as the run has axes."""
        return [number_of(x, "place") for x in command["place"]][:3 if self.space else 2]

    def wall(self, command):
        for wall in self.played.walls:
            if wall.line == command["line"]:
                return wall
        raise TendrilError("there is no such wall")

    def which(self, command):
        number = command.get("branch", self.branch.number)
        for branch in self.branches:
            if branch.number == number:
                return branch
        raise TendrilError("there is no such branch")

    def begun(self):
        """The run as it begins, as a result: units, walls and all options in force."""
        from .loading import load

        file = self.directory / "begun.h5"
        self.sim.save(file)
        return load(file)

    def soon(self):
        """When what is led is to be there."""
        pace = self.pace if self.pace else self.end / 20
        return self.sim.t + max(TOUCH * pace, 1e-6 * self.end)

    def change(self, what, value):
        with self.lock:
            set_in(self.sim, what, value)
            self.branch.changes.append((self.sim.t, what, value))
            self.branch.ended = ""
        self.look()
        self.look_from, self.idle = 0.0, True  # what comes of it is seen at once

    def step(self):
        if self.branch.ended:
            return
        self.busy_since = time.monotonic()
        try:
            with self.lock:
                going = self.sim.step()
        except TendrilError as fault:
            going = False
            self.branch.ended = str(fault)
            self.happened("gave up: " + str(fault))
        took = time.monotonic() - self.busy_since
        self.busy_since = None
        if not going:
            if self.unseen:
                self.look()
            self.branch.ended = self.branch.ended or "it is at its end"
            self.running = False
            self.publish(self.state())
            return
        self.unseen = True
        self.slowest = max(self.slowest, took)
        if not self.running or self.may_look():
            self.look()
        self.keep()

    def may_look(self):
        """Is it time for another look? What looks take is little beside the steps, unless the run waits for the clock."""
        now = time.monotonic()
        if now < self.look_from or self.idle:
            return now >= self.look_from
        left = self.to_look / LOOK_AT_MOST - (time.thread_time() - self.look_at)
        self.look_from = now + left  # it cannot have computed for so long before
        return left <= 0

    def keep(self):
        """A state to go back to, where that costs next to nothing beside all else."""
        begin = time.monotonic()
        self.lived += min(begin - self.stepped, 1.0)
        self.stepped = begin
        steps = 200 + len(self.branch.times)  # what does not grow with the run is as much as 200 steps
        if self.keeping + self.keep_step * steps > KEEP_AT_MOST * self.lived or begin - self.kept_at < 1.0:
            return
        self.states += 1
        file = self.directory / f"state-{self.states}.h5"
        with self.lock:
            self.sim.save(file)
        give_back()
        self.branch.kept.append((self.sim.t, file))
        self.forget()
        if self.so_far:
            self.leave(file)
        self.kept_at = self.stepped = time.monotonic()
        self.keep_step = (self.kept_at - begin) / steps
        self.keeping += self.kept_at - begin

    def forget(self):
        """Every other state, where there are many, or large ones; neither the first nor the last."""
        kept = self.branch.kept
        while len(kept) > 2 and (len(kept) > KEPT or sum(file.stat().st_size for _, file in kept) > KEPT_BYTES):
            for _, old in kept[1:-1:2]:
                old.unlink(missing_ok=True)
                old.with_suffix(".xmf").unlink(missing_ok=True)
            del kept[1:-1:2]

    def leave(self, file):
        """A state beside the results, under a name of its own as soon as it is whole."""
        with contextlib.suppress(OSError):
            self.results.mkdir(parents=True, exist_ok=True)
            part = self.so_far.with_suffix(".part.h5")
            part.unlink(missing_ok=True)
            try:
                os.link(file, part)
            except OSError:
                shutil.copyfile(file, part)
            os.replace(part, self.so_far)

    def part(self, t, branch, but=None):
        """A branch from a time of another; `but`: with these changes alone."""
        if not 0 <= t <= (branch.rows[-1][0] if branch.rows else 0) * (1 + 1e-12):
            raise TendrilError(f"t = {t:g}: this branch has not been there")
        self.running = False
        times = np.array(branch.times)
        t = float(times[np.searchsorted(times, t * (1 + 1e-14), side="right") - 1])  # a step ended there
        changes = branch.all_changes(t) if but is None else but
        new = Branch(1 + max(b.number for b in self.branches), branch, t)
        if but is not None:  # it shares less than all up to there
            new.parent, new.since, new.changes = None, 0.0, list(but)
        self.go_to(branch, t, changes)
        now = self.sim.t
        new.times = array("d", times[times <= now])
        new.rows = [row for row in branch.rows if row[0] <= now]
        if len(new.times) and (not new.rows or new.rows[-1][0] < now):
            new.rows.append(array("d", [self.sim.series[name][-1] for name in self.names]))
        new.frames = [frame for frame in branch.frames if frame[0] <= now]
        new.happened = [what for what in branch.happened if what[0] <= now]
        self.branches.append(new)
        self.branch = new
        self.look(new=False)
        self.publish(self.whole())

    def go_to(self, branch, t, changes):
        """The simulation at a time at which a step of this branch ended, with these changes."""
        # a state from which a step leads on before anything is changed: what is estimated of errors stands on the step before
        state = next((k for k in branch.states(t) if k[0] < t and not any(c[0] == k[0] for c in changes) and
                      not any(c[0] <= k[0] for c in branch.all_changes() if c not in changes)), None)
        sim = Simulation.load(state[1]) if state else Simulation(**self.played.options)
        saved = Counter((t, what) for t, what, _ in saved_changes(state[1])) if state else Counter()
        left = []
        for change in changes:  # those that the state has, beside rows of -change_file, are done
            if saved[change[:2]] > 0:
                saved[change[:2]] -= 1
            else:
                left.append(change)
        while True:
            while left and left[0][0] <= sim.t * (1 + 1e-13):
                set_in(sim, *left.pop(0)[1:])
            if sim.t >= t * (1 - 1e-13) or not sim.step():
                break
        with self.lock:  # (where that failed the run is where it was)
            self.sim = sim
        self.before = None
        self.replay_values(changes)

    def replay_values(self, changes):
        """What controls and walls show, from the changes in force."""
        self.values = {c["name"]: c["value"] for c in self.controls}
        self.shifts = {wall.line: [0.0, 0.0, 0.0] for wall in self.played.walls}
        self.hand = [0.0, 0.0, 0.0]
        self.lamp, self.pull = self.lamp_at, self.pull_at
        for _, what, value in changes:
            words = value.split()
            if what in ("wall_to", "wall_at"):
                shift = [float(x) for x in words[2 if what == "wall_to" else 1:]]
                self.shifts[int(words[0])] = (shift + [0.0] * 3)[:3]
            elif what == "tip_force_vector":
                self.hand = ([float(x) for x in value.split(",")] + [0.0])[:3]
            elif what == "tropism_source":
                self.lamp = ([float(x) for x in value.split(",")] + [0.0])[:3]
            elif what == "tropism_direction":
                self.pull = ([float(x) for x in value.split(",")] + [0.0])[:3]
                self.values["pull_angle"] = float(np.arctan2(*self.pull[1::-1]))
            elif what == "wall_friction":
                self.values[f"wall_friction {words[0]}"] = float(words[1])
            elif what in self.values:
                self.values[what] = float(words[-1])

    # ---- looking ----

    def look(self, new=True):
        """What there is to see now, to who looks: the rows since the last look, and the rod."""
        begin, self.idle = time.thread_time(), False
        took, self.slowest, self.unseen, now = self.slowest, 0.0, False, time.monotonic()
        self.look_from = max(self.look_from, now - LOOKS) + LOOKS
        with self.lock:
            sim = self.sim
            have = len(self.branch.times) if new else len(sim.series["t"])
            rows = np.column_stack([sim.series[name][have:] for name in self.names]).tolist()
            t = sim.t
            frame = frame_of(sim, self.before, t)
            self.before = sim.nodes, t
        news = self.news(np.array([*self.branch.rows[-1:], *rows]), took) if self.branch.rows and rows else []
        for row in rows:
            self.branch.add(row)
        for text in news:
            self.happened(text)
        if new:
            self.keep_frame(t, frame)
        iterations = self.names.index("newton_iterations")
        self.rates.append((now, len(rows), sum(row[iterations] for row in rows)))
        self.look_at = time.thread_time()
        self.to_look = self.look_at - begin
        self.publish({"kind": "frame", "t": t, "rows": rows, "frame": frame, "branch": self.branch.number,
                      "walls": self.walls_now(t), "rates": self.speed(), "hand": self.hand, "lamp": self.lamp, "pull": self.pull, "to": None})

    def keep_frame(self, t, frame):
        frames = self.branch.frames
        frames.append((t, frame))
        if len(frames) > 2 * FRAMES:  # evenly thinned in time
            wanted = np.linspace(0, t, FRAMES)
            times = np.array([f[0] for f in frames])
            keep = np.unique(np.clip(np.searchsorted(times, wanted), 0, len(frames) - 1))
            self.branch.frames = [frames[k] for k in keep]

    def walls_now(self, t):
        """How far each wall is displaced, and by what angle it is turned, by line."""
        return {str(line): place for line, place in shifts_at(self.plain_rows() + self.branch.all_changes(), t, self.courses).items()}

    def speed(self):
        """(steps, iterations) a second, of the last two seconds."""
        now = time.monotonic()
        recent = [one for one in self.rates if one[0] > now - 2]
        if len(recent) < 2:
            return [0.0, 0.0]
        over = max(now - recent[0][0], 1e-3)
        return [sum(one[1] for one in recent[1:]) / over, sum(one[2] for one in recent[1:]) / over]

    def happened(self, text):
        t = self.branch.rows[-1][0] if self.branch.rows else 0.0
        self.branch.happened.append((t, text))
        del self.branch.happened[:-HAPPENINGS]
        self.publish({"kind": "happened", "t": t, "text": text, "branch": self.branch.number, "to": None})

    def news(self, rows, took):
        """What happens in steps, of which the row before them is the first, and why the last was slow: in words."""
        def column(name):
            return rows[:, self.names.index(name)] if name in self.names else np.zeros(len(rows))

        def begins(now):
            return now[1:] & ~now[:-1]

        touches, crossings, fast = column("contacts") > 0, column("self_crossings"), np.maximum(column("tip_speed"), column("mid_speed")) > FAST
        found = {"it touches": begins(touches), "it lets go": begins(~touches), "it crosses itself": crossings[1:] > crossings[:-1],
                 "it snaps": begins(fast) & (column("t")[1:] > 1e-6 * self.end)}  # (a start out of balance gives way at once)
        counts = {text: np.count_nonzero(when) for text, when in found.items()}
        told = [text if count == 1 else f"{text}, {count} times" for text, count in counts.items() if count]
        if took > SLOW:
            last, at = (dict(zip(self.names, row)) for row in rows[-2:])
            told.append(f"a step took {took:.1f} s: {self.why(at, last)}")
        return told

    def why(self, at, last):
        """In words, why a step was slow."""
        if max(at.get("tip_speed", 0), at.get("mid_speed", 0)) > FAST:
            return "the rod snaps, and is followed as it does"
        if at.get("contacts", 0) != last.get("contacts", 0):
            return "what touches changes"
        if at.get("step", 0) < 1e-3 * last.get("step", 0):
            return "steps got shorter: it may be about to give way, or is jammed"
        if at.get("newton_iterations", 0) > 15:
            return f"{int(at['newton_iterations'])} iterations: contact or friction changes all along the rod"
        return "there are many cells, or far parts of the rod touch each other"

    def state(self):
        return {"kind": "state", "running": self.running, "pace": self.pace, "end": self.end, "values": self.values,
                "branch": self.branch.number, "ended": self.branch.ended, "to": None, "written": sorted(self.written),
                "branches": [{"number": b.number, "parent": b.parent.number if b.parent else None, "since": b.since,
                              "t": b.rows[-1][0] if b.rows else 0.0, "changes": len(b.all_changes())} for b in self.branches],
                "changes": [list(c) for c in self.branch.all_changes()][-200:], "t": self.branch.rows[-1][0] if self.branch.rows else 0.0}

    def whole(self):
        """All there is of the present branch, for a page that has just come."""
        rows = self.branch.rows
        step = max(1, len(rows) // ROWS)
        shown = rows[::step] + ([rows[-1]] if rows and (len(rows) - 1) % step else [])
        return {"kind": "whole", "names": self.names, "rows": [list(row) for row in shown], "frames": [[t, f] for t, f in self.branch.frames],
                "happened": [list(h) for h in self.branch.happened], "walls": self.walls_now(self.branch.rows[-1][0] if rows else 0.0),
                "hand": self.hand, "lamp": self.lamp, "pull": self.pull, "to": None} | {k: v for k, v in self.state().items() if k not in ("kind", "to")}

    # ---- writing ----

    def save(self, kind):
        name = f"{self.played.name}-played"
        self.results.mkdir(parents=True, exist_ok=True)
        if kind == "scene":
            return self.save_played(name)
        file = self.results / f"{name}.h5"
        with self.lock:
            self.sim.save(file)
        self.written[file.name] = file
        if kind == "result":
            return f"{file} holds the run so far; it can be gone on with (-restart)"
        from .loading import load

        r = load(file)
        if kind == "picture":
            from .pictures import plot

            to = self.results / f"{name}.png"
            plot(r).savefig(to, dpi=150)
        elif kind == "film":
            from .films import animate

            to = self.results / f"{name}.gif"
            animate(r, output=to)
        elif kind == "page":
            from .page import view

            to = view(r, self.results / f"{name}.html")
        else:
            raise TendrilError(f"{kind[:40]}: give scene, result, picture, film or page")
        self.written[to.name] = to
        return f"{to} is written"

    def plain_rows(self):
        """Rows of -change_file that move walls, if they are plain numbers."""
        rows = [row for row in said_rows(self.played) if row[1] in ("wall_to", "wall_at", "wall_turn_to") and all(NUMBER.fullmatch(w) for w in (row[0], *row[2].split()))]
        return [(float(t), what, value) for t, what, value in rows]

    def table(self):
        """All that changes in this run, (t, what, value): what -change_file said, and what was changed here."""
        changes, said = self.branch.all_changes(), said_rows(self.played)
        if not said:
            return changes
        file = self.directory / "table.h5"
        with self.lock:
            self.sim.save(file)
        done = saved_changes(file)
        return done + said[len(done) - len(changes):]

    def save_played(self, name):
        changes = self.table()
        said = f"{self.played.name}, as it was played: {len(changes)} changes (docs/live.md)"
        file = save_scene(self.played, changes, self.results, name, said)
        self.written[file.name] = file
        if (file.parent / "changes.txt").exists():
            self.written["changes.txt"] = file.parent / "changes.txt"
        with self.lock:
            rows = np.column_stack([self.sim.series[name] for name in self.names])
        threading.Thread(target=self.check, args=(file, rows), daemon=True, name="tendril check").start()
        return f"{file} is written; the program is run with it to compare"

    def check(self, file, rows):
        """Runs the program with the saved scene, and tells by how much it differs."""
        try:
            off, name = differs(file, self.names, rows)
            text = f"checked: tendril -options_file {file.name} gives the same run, to {off:.1e}" + (f" ({name})" if off else "") \
                if off <= 1e-8 else f"the run of {file.name} differs by {off:.1e} ({name}): say so to the authors"
        except (TendrilError, OSError) as fault:
            text = f"{file.name} could not be checked: {fault}"
        self.publish({"kind": "done", "text": text, "to": None})


def differs(file, names, rows):
    """(largest relative difference of any series, its name) of the program's run of a scene to rows of series."""
    try:
        series = run(file, progress=False, quiet=True, ts_max_steps=max(len(rows) - 1, 1)).series
    except RunError as fault:
        if fault.results is None:
            raise
        series = fault.results.series
    n = min(len(rows), len(series["t"]))
    table, worst = np.array(rows[:n]), (0.0, "")
    if n < len(rows) and n < 2:
        raise TendrilError("it has no steps")
    for k, name in enumerate(names):
        if name in series:
            size = np.abs(table[:, k]).max() or 1.0
            worst = max(worst, (float(np.abs(table[:, k] - series[name][:n]).max() / size), name))
    return worst if n == len(rows) else (np.inf, f"{n} steps of {len(rows)}")


def lines_of(session):
    """(wall, its line in the result file, which has those of the plane first)"""
    walls = session.played.walls
    lines = str(session.setup.attributes.get("walls", "") or "").strip().splitlines()
    return zip([*(w for w in walls if not w.in_space), *(w for w in walls if w.in_space)], lines)


def drawn_walls(session):
    """Of each wall its line and kind, and what is drawn of it: in the plane a circle, or rings and lines; in space a mesh."""
    from .solids import Reach, drawn
    from .walls import parse, solid

    r, found = session.setup, []
    reach = max(float(r.shapes.x.max()), 1.0) + 1.1 * session.end  # surfaces are drawn as far as the rod may come
    for wall, line in lines_of(session):
        words = line.split()
        one = {"line": wall.line, "kind": wall.kind, "inside": "inside" in words, "about": axis_of(line)}
        numbers = [float(w) for w in words[1:8] if NUMBER.fullmatch(w)]
        if wall.kind in ("tube", "body"):
            pass
        elif wall.kind == "circle":
            one |= {"circle": numbers[:3]}
        elif wall.kind == "cylinder" and abs(numbers[5]) > 0.999:
            one |= {"circle": [numbers[0], numbers[1], numbers[6]]}
        elif wall.kind == "sphere":
            one |= {"circle": [numbers[0], numbers[1], numbers[3]], "height": numbers[2]}
        elif not wall.in_space or wall.kind == "plane" and wall.in_space and len(numbers) >= 6 and numbers[5] == 0:
            text = line if not wall.in_space else "plane {} {} {} {} friction 0".format(*numbers[:2], *numbers[3:5])
            body, edges = solid(parse(text)[0], (-reach, reach, -reach, reach))
            one |= {"rings": [np.ravel(ring).tolist() for ring in (body.to_polygons(closed_only=False) if body else [])],
                    "lines": [np.ravel(edge).tolist() for edge in edges]}
        if session.space:
            pieces = drawn(line, r, Reach(np.minimum(r.shapes.x.min(axis=(0, 1)), -reach), np.full(3, reach)))
            if pieces:
                before = np.cumsum([0] + [len(piece.vertices) for piece in pieces])
                corners = np.concatenate([piece.vertices for piece in pieces])
                triangles = np.concatenate([np.asarray(piece.triangles, int).reshape(-1, 3) + k for piece, k in zip(pieces, before)])
                some = triangles[np.unique(np.linspace(0, max(len(triangles) - 1, 0), min(len(triangles), MOST_TRIANGLES)).astype(int))]
                used, places = np.unique(some, return_inverse=True)
                one |= {"vertices": np.round(np.ravel(corners[used]), 5).tolist(), "triangles": np.ravel(places).tolist(),
                        "lines3": [np.round(np.ravel(edge), 5).tolist() for piece in pieces for edge in piece.lines]}
        found.append(one)
    return found


def give_back():
    """To the system, what writing a long run has taken for a moment: this thread would keep it, the more the longer the run."""
    with contextlib.suppress(AttributeError, OSError, TypeError):  # where the library of C has no such call
        ctypes.CDLL(None).malloc_trim(0)


def set_in(sim, what, value):
    sim.set(what, value if what in BY_WORDS or "," in value else float(value))


def saved_changes(file):
    """What was changed in the run of a result file, (t, what, value)."""
    import h5py

    with h5py.File(file, "r", locking=False) as f:
        if "changes" not in f:
            return []
        text = f["changes"][()]
        lines = (text.decode() if isinstance(text, bytes) else str(text)).strip().splitlines()
    return [(float(t), what, value) for t, what, value in (line.split(None, 2) for line in lines)]


def shifts_at(changes, t, courses=None):
    """By line, how far walls are displaced at a time, and by what angle they are turned [4]: as the library leads them, from where
    their own lines have them, {line: that over time}."""
    found, courses = {}, courses or {}
    for begin, what, value in changes:
        if what not in ("wall_to", "wall_at", "wall_turn_to") or begin > t:
            continue
        words, turns = value.split(), what == "wall_turn_to"
        line, end = int(words[0]), begin if what == "wall_at" else float(words[1])
        given = [float(v) for v in words[1 if what == "wall_at" else 2:]]
        place, angle = found.get(line, (None, None))
        at, rate = (part[3:] if turns else part[:3] for part in carried(courses.get(line), begin))
        if (before := angle if turns else place) is not None:
            at, rate = led(before, begin)
        to = np.array(given if turns else (given + [0.0])[:3])
        now = (begin, end, at, rate, to) if end > begin else (begin, begin, to, 0 * to, to)
        found[line] = (place, now) if turns else (now, angle)
    return {line: placed(found.get(line, (None, None)), courses.get(line), t) for line in found.keys() | courses.keys()}


def placed(leads, course, t):
    """[4] of a wall, as the leads of its place and angle have it, where there are any, or its course."""
    own = carried(course, t)[0]
    parts = (led(lead, t)[0] if lead is not None else part for lead, part in zip(leads, (own[:3], own[3:])))
    return np.concatenate(list(parts)).tolist()


def carried(course, t):
    """(where, how fast) [4] of what moves as its line says; None: not at all."""
    if course is None:
        return np.zeros(4), np.zeros(4)
    moment = 1e-6 * (1 + t)
    return course(t), (course(t + moment) - course(t - moment)) / (2 * moment)


def course_of(motion, t):
    return np.append(shift_of(motion, t), turned(motion, t))


def courses_of(session):
    """{line: displacement and angle over time} of the walls that move as their lines say."""
    from .walls import ends_of

    found = {}
    for wall, line in lines_of(session):
        if motion := ends_of(line.split())[2]:
            found[wall.line] = partial(course_of, motion)
    return found


def axis_of(line):
    """About which a wall turns, a place and a direction [6], or None: about its middle where its line does not say it, as the
    library has it."""
    from .walls import ends_of

    words, _, motion = ends_of(line.split())
    if "turns" in motion:
        return motion["turns"][1:].tolist()
    numbers = [float(w) for w in words[1:] if NUMBER.fullmatch(w)]
    if words[0] in ("tube", "body"):
        return None
    if words[0] in ("polygon", "path"):
        return [*np.reshape(numbers[words[0] == "path":], (-1, 2)).mean(axis=0).tolist(), 0, 0, 0, 1]
    flat = words[0] == "circle" or words[0] == "plane" and len(numbers) < 6
    return [*(numbers[:2] if flat else numbers[:3]), *([0] if flat else []), 0, 0, 1]


def led(lead, t):
    """(where, how fast) of what is led, (from when, to when, from where, how fast then, to where)."""
    t0, t1, a, v, b = lead
    if t >= t1:
        return b, 0 * b
    h, z = t1 - t0, (t - t0) / (t1 - t0)
    y = 1 - z
    return (1 + 2 * z) * y * y * a + z * z * (3 - 2 * z) * b + h * z * y * y * v, 6 * z * y * (b - a) / h + y * (1 - 3 * z) * v


def number_of(value, what):
    """A finite number, or a refusal that names it."""
    try:
        number = float(value)
    except (TypeError, ValueError):
        raise TendrilError(f"{what}: {str(value)[:40]!r} is no number") from None
    if not np.isfinite(number):
        raise TendrilError(f"{what}: give a finite number")
    return number


MOST_NODES, PIECES = 301, 28
MOST_TRIANGLES = 3000  # of a surface, as a page draws it


def frame_of(sim, before=None, t=0.0):
    """What is drawn of a rod: places, and what colours it along the nodes; friction and contact as arrows."""
    nodes = sim.nodes
    keep = np.unique(np.linspace(0, len(nodes) - 1, min(len(nodes), MOST_NODES)).round().astype(int))
    x, force = nodes["x"], nodes["force"]
    axial = np.einsum("ij,ij->i", force, nodes["d"][:, 0])
    bend = np.linalg.norm(nodes["curvature"], axis=1) * (np.sign(nodes["curvature"][:, 2]) if not sim.space else 1)
    growth = np.zeros(len(nodes))
    if before is not None and len(before[0]) == len(nodes) and t > before[1]:
        growth = (nodes["stretch"] / before[0]["stretch"] - 1) / (t - before[1])
    p = np.concatenate([[0], np.cumsum(np.linalg.norm(np.diff(x, axis=0), axis=1))])
    touch = nodes["contact"]
    ends = np.linspace(0, p[-1], PIECES + 1)

    def along(at, values):
        return np.column_stack([np.interp(at, p, column) for column in values.T])

    half = np.concatenate([[0], (p[1:] + p[:-1]) / 2, [p[-1]]])
    total = np.vstack([np.zeros(3), np.cumsum(touch * np.diff(half)[:, None], axis=0)])
    borne = np.diff(np.column_stack([np.interp(ends, half, column) for column in total.T]), axis=0)
    held = (-np.diff(along(ends, force), axis=0) - borne) / np.maximum(np.diff(ends)[:, None], 1e-300)
    middle = along((ends[1:] + ends[:-1]) / 2, x)
    return {"x": rounded(x[keep]), "axial": rounded(axial[keep]), "bend": rounded(bend[keep]), "growth": rounded(growth[keep]),
            "speed": rounded(np.linalg.norm(nodes["v"], axis=1)[keep]), "places": rounded(middle), "friction": rounded(held),
            "contact": rounded(borne / np.maximum(np.diff(ends)[:, None], 1e-300)) if touch.any() else None}


def rounded(values):
    """Base64 of 32-bit numbers, as pages have arrays."""
    from .packed import packed

    return packed(np.ravel(values))

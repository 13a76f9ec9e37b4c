"""Sweeps and fits seen while they go on, in a browser: members of a sweep as they end, in a map or curve that fills; the rods that a
fit tries, over the points of photographs and series.

    with tendril.watch() as page:
        print(page.address)
        tendril.sweep("feed", {"friction_mu": [0.2, 0.5, 0.8]}, watch=page)
        tendril.fit("mytube.opts", "photos.csv", {"si_friction_dry": ("0.1N/m", "2N/m")}, watch=page)

tendril-py sweep and fit have --live for it. What is watched is a function that takes messages, dicts of plain values; the page is
one. Who looks on changes nothing of what is found."""

from __future__ import annotations

import threading
import time
from contextlib import contextmanager
from itertools import product
from pathlib import Path

import numpy as np

from .errors import ResultsError, RunError, TendrilError
from .packed import packed, thinned

LOOKS = 0.2  # seconds between looks at a sweep's file
OFTEN = 0.04  # seconds between points of a fit that are no better than those before
NODES, POINTS = 120, 3000  # of a rod, and of a photograph, as they are drawn
LATEST = 400  # points of a fit that are kept for a page that comes later
MOST_PHOTOGRAPHS = 12


# ---- sweeps ----


def axis_of(name, values):
    """An axis as a page draws it: texts, and numbers if all are some."""
    from .runs import text_of
    from .titles import in_words
    from .units import quantity

    texts = [text_of(v) for v in values]
    found = [quantity(text) for text in texts]
    numbers = [one[0] for one in found] if None not in found and len({one[1] for one in found}) == 1 else None
    return {"name": name, "label": in_words(name), "texts": texts, "numbers": numbers, "unit": found[0][1] if numbers else ""}


class SweepSeen:
    """A sweep for who looks on."""

    def __init__(self, watch, scene, over):
        self.watch, self.told = watch, set()
        count = int(np.prod([len(values) for values in over.values()]))
        watch({"kind": "study", "what": "sweep", "name": Path(scene).stem if isinstance(scene, (str, Path)) else "sweep",
               "axes": [axis_of(name, values) for name, values in over.items()], "count": count,
               "points": list(product(*(range(len(values)) for values in over.values())))})

    def member(self, k, r, seconds=None):
        """One has ended."""
        from .collection import final_values

        if k in self.told:
            return
        self.told.add(k)
        told = {"kind": "member", "k": k, "seconds": seconds, "failed": "", "values": {}, "units": {}, "x": None, "space": False}
        if isinstance(r, RunError):
            told["failed"] = str(r)
        else:
            found = {name: value for name, value in final_values(r, "si_length" in r.attributes).items() if np.isfinite(value[0])}
            told |= {"values": {name: value for name, (value, _) in found.items()}, "units": {name: unit for name, (_, unit) in found.items()}}
            if "x" in r.shapes:
                x = r.shapes["x"][-1]
                x = x[thinned(len(x), NODES)]
                told |= {"x": packed(np.pad(x, ((0, 0), (0, 3 - x.shape[1])))), "space": x.shape[1] == 3 and bool(np.ptp(x[:, 2]) > 0)}
        self.watch(told)

    def look(self, sweep):
        """All that have ended since the last look."""
        for k in np.flatnonzero(sweep.status):
            if k not in self.told:
                self.member(int(k), sweep.member(k), float(sweep.seconds[k]))

    @contextmanager
    def following(self, path, over):
        """While a job writes its file anew and anew."""
        from .collection import load_sweep

        over_now, seen = threading.Event(), None

        def follow():
            nonlocal seen
            while not over_now.wait(LOOKS):
                try:
                    now = path.stat().st_mtime_ns, path.stat().st_ino
                    if now != seen:
                        self.look(load_sweep(path, over))
                        seen = now
                except (OSError, ResultsError):  # it is not there yet, or is renamed at this moment
                    continue

        thread = threading.Thread(target=follow, daemon=True, name="tendril watches")
        thread.start()
        try:
            yield
        finally:
            over_now.set()
            thread.join()

    def ended(self, text="all have ended"):
        self.watch({"kind": "ended", "text": text})


# ---- fits ----


class FitSeen:
    """A fit for who looks on: called with each point of the search."""

    def __init__(self, watch, problem):
        from .fit_report import shown, unit_of

        self.watch, self.problem, self.latest, self.least = watch, problem, 0.0, np.inf
        photographs = problem.measured.photographs
        self.photographs = [photographs[k] for k in thinned(len(photographs), MOST_PHOTOGRAPHS)] if photographs else []
        drawn = []
        for p in self.photographs:
            factor, unit = shown(p.points)
            times, name = shown(p.at) if p.abscissa else (1, "")
            title = f"{'t' if p.abscissa == 't' else 'L'} = {times * float(p.at.numbers):.4g} {name}".rstrip() if p.abscissa else "no time"
            points = np.asarray(p.points.numbers, float)
            drawn.append({"points": packed(factor * points[thinned(len(points), POINTS)]), "title": title, "unit": unit, "down": p.points.unit == "px"})
        curves = []
        for c in problem.measured.curves:
            (along, at_unit), (factor, unit) = shown(c.at), shown(c.values)
            curves.append({"name": c.name.replace("_", " "), "at": packed(along * c.at.numbers), "values": packed(factor * c.values.numbers),
                           "over": c.abscissa, "unit": unit, "at_unit": at_unit})
        watch({"kind": "study", "what": "fit", "name": Path(problem.scene).stem if isinstance(problem.scene, (str, Path)) else "fit",
               "photographs": drawn, "of": len(photographs), "curves": curves, "noise": unit_of(photographs[0].points) if photographs else "",
               "parameters": [{"name": p.name, "low": float(p.low), "high": float(p.high), "unit": p.unit, "log": bool(p.logarithmic)}
                              for p in problem.parameters]})

    def tried(self, u, r, cost):
        """A point of the search, its run and its cost."""
        from .fit_report import shown

        better = cost < self.least
        self.least = min(self.least, cost)
        if not better and time.monotonic() - self.latest < OFTEN:
            return
        self.latest = time.monotonic()
        p = len(self.problem.parameters)
        view, comparison = self.problem.view(u), self.problem.comparison
        lines, curves = [], []
        try:
            for photograph in self.photographs:
                line = comparison.line(r, photograph, u[p:], view)
                lines.append(packed(shown(photograph.points)[0] * line[thinned(len(line), NODES)]))
            for c in self.problem.measured.curves:
                curves.append(packed(shown(c.values)[0] * comparison.model(r, c, view)))
        except (TendrilError, ValueError, IndexError):  # it ends before the last photograph: as far as it goes
            pass
        self.watch({"kind": "tried", "runs": self.problem.count, "cost": float(cost), "better": better, "lines": lines, "curves": curves,
                    "values": {q.name: float(q.value(x)) for q, x in zip(self.problem.parameters, u)}})

    def fresh(self):
        """Costs are counted anew: by another noise."""
        self.least = np.inf
        self.watch({"kind": "fresh"})

    def telling(self, tell):
        """What tells what goes on, here as well."""
        def both(text):
            tell(text)
            self.watch({"kind": "stage", "text": text})
        return both

    def ended(self, fit):
        self.least = np.inf  # what it has found stands at the end
        self.tried(fit.u, fit.run, fit.cost)
        self.watch({"kind": "ended", "text": fit.report()})


# ---- who looks on ----


class Study:
    """What a page shows, kept for pages that come later: of the points of a fit the latest, and the best."""

    def __init__(self):
        self.messages, self.tried, self.best, self.lock = [], [], None, threading.Lock()

    def take(self, message):
        with self.lock:
            if message["kind"] == "study":
                self.messages, self.tried, self.best = [], [], None
            if message["kind"] == "fresh":
                self.best = None
                return
            if message["kind"] != "tried":
                self.messages.append(message)
                return
            self.tried.append(message)
            if len(self.tried) > 2 * LATEST:
                del self.tried[:-LATEST]
            if message["better"]:
                self.best = message

    def whole(self):
        with self.lock:
            first = [self.best] if self.best is not None and self.best not in self.tried else []
            return [*self.messages[:1], *first, *self.tried, *self.messages[1:]]


def watch(*, port=0):
    """A page in a browser that shows sweeps and fits while they go on: give it to tendril.sweep() or tendril.fit() as `watch`;
    .address leads to it, .close() ends it."""
    from .live_server import Live

    return Live(port=port, study=Study())


@contextmanager
def shown_live(wanted, port, browser):
    """A page for a command, its address printed first; None if it is not wanted."""
    import webbrowser

    if not wanted:
        yield None
        return
    with watch(port=port) as page:
        print(page.address, flush=True)
        if browser:
            threading.Thread(target=webbrowser.open, args=(page.server.opening(),), daemon=True).start()
        yield page
        if browser:
            print("live: the page stays as long as this runs; Ctrl-C ends it", flush=True)
            try:
                threading.Event().wait()
            except KeyboardInterrupt:
                pass


def live_options(parser):
    parser.add_argument("--live", action="store_true", help="shows it in a browser while it goes on")
    parser.add_argument("--no-browser", action="store_true", help="with --live: opens none, and ends when it is done")
    parser.add_argument("--port", type=int, default=0, help="with --live: of the address; default: a free one")

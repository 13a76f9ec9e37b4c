"""A fit for who looks on (watching.py): messages of the points that its search tries."""

from __future__ import annotations

import time
from pathlib import Path

import numpy as np

from .errors import TendrilError
from .fit_report import shown
from .packed import packed, thinned

OFTEN = 0.04  # seconds between points that are no better than those before
NODES, POINTS = 120, 3000  # of a rod, and of a photograph, as they are drawn
MOST_PHOTOGRAPHS = 12


class FitSeen:
    """A fit for who looks on: called with each point of the search."""

    def __init__(self, watch, problem):
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
               "photographs": drawn, "of": len(photographs), "curves": curves,
               "parameters": [{"name": p.name, "low": float(p.low), "high": float(p.high), "unit": p.unit, "log": bool(p.logarithmic)}
                              for p in problem.parameters]})

    def tried(self, u, r, cost):
        """A point of the search, its run and its cost."""
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

"""A sweep for who looks on (watching.py): messages of members as they end."""

from __future__ import annotations

import threading
from contextlib import contextmanager
from itertools import product
from pathlib import Path

import numpy as np

from .errors import ResultsError, RunError
from .packed import packed, thinned

LOOKS = 0.2  # seconds between looks at a sweep's file
NODES = 120  # of a rod, as it is drawn


def axis_of(name, values):
    """An axis as a page draws it: texts, and numbers if all are some."""
    from .runs import text_of
    from .titles import in_words
    from .units import quantity

    texts = [text_of(v) for v in values]
    found = [quantity(text) for text in texts]
    numbers = [one[0] for one in found] if None not in found and len({one[1] for one in found}) == 1 else None
    return {"name": name, "label": in_words(name), "texts": texts, "numbers": numbers}


class SweepSeen:
    """A sweep for who looks on."""

    def __init__(self, watch, scene, over):
        self.watch, self.told = watch, set()
        count = int(np.prod([len(values) for values in over.values()]))
        watch({"kind": "study", "what": "sweep", "name": Path(scene).stem if isinstance(scene, (str, Path)) else "sweep",
               "axes": [axis_of(name, values) for name, values in over.items()], "count": count,
               "points": list(product(*(range(len(values)) for values in over.values())))})

    def member(self, k, r):
        """One has ended."""
        from .collection import final_values

        if k in self.told:
            return
        self.told.add(k)
        told = {"kind": "member", "k": k, "failed": "", "values": {}, "units": {}, "x": None, "space": False}
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
                self.member(int(k), sweep.member(k))

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

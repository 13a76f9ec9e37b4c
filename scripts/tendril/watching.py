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
from contextlib import contextmanager

LATEST = 400  # points of a fit that are kept for a page that comes later


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

"""A run that one can touch as a widget of a notebook (Jupyter, VS Code, Colab): the page of tendril-py live in a cell, without a
server.

    tendril.widget("feed")"""

from __future__ import annotations

import tempfile
import threading
import time
from pathlib import Path

from .errors import TendrilError
from .live_server import SCRIPTS, WEB
from .outbox import Outbox
from .playing import prepare
from .sessions import Session

FRAMES_A_SECOND = 20


def script():
    """The page's own scripts as a module that a notebook loads."""
    text = "\n".join((WEB / name).read_text(encoding="utf-8") for name in SCRIPTS)
    return text + """
export default { render({ model, el }) {
  const connection = { hear: () => {}, lost: () => {}, open: true, send: (message) => model.send(message) };
  model.on("msg:custom", (message) => connection.hear(message));
  mount(el, connection);
  model.send({ do: "greet" });
} };
"""


class Sender:
    """From the run's thread to a notebook, frames so many a second."""

    def __init__(self, send):
        self.send, self.lock, self.outbox, self.closed = send, threading.Condition(), Outbox(), False
        threading.Thread(target=self.pump, daemon=True, name="tendril widget").start()

    def take(self, message):
        with self.lock:
            self.outbox.put(message)
            self.lock.notify()

    def pump(self):
        while not self.closed:
            with self.lock:
                self.lock.wait_for(lambda: self.outbox or self.closed, timeout=1)
                messages = self.outbox.take()
            for message in messages:
                self.send(message)
                if message["kind"] == "frame":
                    time.sleep(1 / FRAMES_A_SECOND)


def widget(scene=None, *, results="results/live", posts=0, **options):
    """A run that one can touch in a notebook's cell; scene and options as for live(). .session is the run: .session.sim the
    simulation, .close() ends it."""
    try:
        import anywidget
    except ImportError:
        raise TendrilError("widget: needs the library anywidget: pip install 'tendril[notebook]', or pip install anywidget") from None

    class LiveWidget(anywidget.AnyWidget):
        _esm = script()
        _css = "".join((WEB / name).read_text(encoding="utf-8") for name in ("uplot/uPlot.min.css", "live.css")) + ".l-all { --line: #ddd; --faint: #777; }"

        def __init__(self):
            super().__init__()
            self.directory = tempfile.TemporaryDirectory(prefix="tendril-live-")
            played = prepare(scene, options, self.directory.name, posts)
            self.sender = Sender(self.send)
            self.session = Session(played, Path(self.directory.name), self.sender.take, results).begin()
            self.on_msg(self.hear)

        def hear(self, _, command, buffers):
            if not isinstance(command, dict) or not isinstance(command.get("do"), str):
                return
            if command["do"] == "greet":
                self.sender.take(self.session.scene())
                self.sender.take(self.session.whole())
            else:
                self.session.do(command)

        def close(self):
            self.session.close()
            self.sender.closed = True
            super().close()

    return LiveWidget()

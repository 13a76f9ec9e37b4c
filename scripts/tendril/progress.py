"""How far something is, for all that takes a while: a bar in a terminal and in a notebook."""

from __future__ import annotations

import os
import sys

SOON = 0.5  # seconds: what ends before needs no bar


def wanted(progress: bool | None) -> bool:
    """Whether there is a bar; None: where somebody looks on."""
    return bool(sys.stderr.isatty() or "ipykernel" in sys.modules) if progress is None else progress


def bar(progress: bool | None, total, form: str | None = None, what="tendril", unit="it"):
    """A bar of tqdm, where it is wanted."""
    from tqdm import tqdm

    class Bar(tqdm):
        def refresh(self, nolock=False, lock_args=None):
            """tqdm's own keeps its lock for good if Ctrl-C comes while it draws, and all other threads then wait for it."""
            if not self.disable:
                with self.get_lock():
                    self.display()

    return Bar(total=total, desc=what, bar_format=form, unit=unit, leave=False, delay=SOON,
               disable=not wanted(progress), **size())


def size():
    """Of a terminal that does not know its own: tqdm would show nothing there. Else tqdm finds out."""
    try:
        return {} if all(os.get_terminal_size(sys.stderr.fileno())) else {"ncols": 80, "nrows": 24}
    except (OSError, ValueError, AttributeError):  # no terminal
        return {}


class Stages:
    """A bar of work that is known only stage by stage: full at its end, and not before."""

    def __init__(self, shown):
        self.shown = shown

    def expect(self, more):
        """From here on it is about so much more."""
        self.shown.total = self.shown.n + max(more, 1)
        self.shown.refresh()

    def count(self, done):
        """So much is done; if it is more than was thought there is a little left."""
        self.shown.total = max(self.shown.total, self.shown.n + done + 1)
        self.shown.update(done)

    def tell(self, text):
        """What goes on, behind the bar."""
        self.shown.set_postfix_str(text)

    def close(self, done=True):
        if done:
            self.shown.total = max(self.shown.n, 1)
            self.shown.refresh()
        self.shown.close()

"""Messages of a live run on their way to a page that may be slower than the run."""

from __future__ import annotations

import base64

import numpy as np

ROWS = 3000  # of the series that a page is shown; twice as many are kept, the run itself has all
MESSAGES = 500  # that wait, at most


def thin(rows):
    """Leaves out every other row of a list that has become long, but neither the first nor the last."""
    if len(rows) > 2 * ROWS:
        del rows[1:-1:2]


class Outbox:
    """What is to be sent; of frames the latest alone, with the rows of those left out."""

    def __init__(self):
        self.messages, self.frame, self.rows = [], None, []

    def __bool__(self):
        return bool(self.messages or self.frame)

    def put(self, message):
        if message["kind"] == "frame":
            self.rows.extend(message["rows"])
            thin(self.rows)
            self.frame = message | {"rows": self.rows}
            return
        if message["kind"] == "whole":  # which has all of them
            self.frame, self.rows = None, []
        self.messages.append(message)
        if len(self.messages) > MESSAGES:  # it does not listen any more
            del self.messages[:MESSAGES // 2]

    def take(self):
        """All that waits, the frame last, its rows as base64 of 64-bit numbers; nothing does any more."""
        found = list(self.messages)
        if self.frame:
            found.append(self.frame | {"rows": base64.b64encode(np.array(self.rows, "<f8").tobytes()).decode()})
        self.messages, self.frame, self.rows = [], None, []
        return found

"""What can go wrong, in one plain line each."""


class TendrilError(Exception):
    """What is asked for cannot be done."""


class ResultsError(TendrilError):
    """A file cannot be read, or does not hold what is asked of it."""


class RunError(TendrilError):
    """A run that tendril refused or gave up: its own line, without its name in front.

    command  as it was started, a list of words
    results  what was stored before, None if nothing was"""

    def __init__(self, line, command=(), results=None):
        super().__init__(line)
        self.command, self.results = list(command), results

"""What can go wrong, in one plain line each."""

import re
from importlib import import_module

OPTION = re.compile(r"(?<![\w=/.-])-([a-z][a-z0-9_]*[a-z0-9])\b")


class TendrilError(Exception):
    """What is asked for cannot be done."""


class ResultsError(TendrilError):
    """A file cannot be read, or does not hold what is asked of it."""


class RunError(TendrilError):
    """A run that tendril refused or gave up: its own line, without its name in front, and with options
    named as Python has them, friction_mu for -friction_mu.

    command  as it was started, a list of words
    results  what was stored before, None if nothing was"""

    def __init__(self, line, command=(), results=None):
        super().__init__(OPTION.sub(r"\1", line))
        self.command, self.results = list(command), results


def optional(module, error, line):
    """A module that not all have installed: where it is missing, the error with its line."""
    try:
        return import_module(module)
    except ImportError:
        raise error(line) from None

"""What can go wrong, in one plain line each."""

import math
import os
import re
from contextlib import contextmanager, suppress
from difflib import get_close_matches
from importlib import import_module
from numbers import Integral, Real
from pathlib import Path
from tempfile import TemporaryFile

OPTION = re.compile(r"(?<![\w=/.-])-([a-z][a-z0-9_]*[a-z0-9])\b")
# the file that run() made of a value that is none of a command line: walls, arrays
VALUE = re.compile(r"-(\w+) \S*/\1-[0-9a-f]{8}\.(?:txt|h5)\b")


class TendrilError(Exception):
    """What is asked for cannot be done."""


class DataError(TendrilError):
    """What was measured cannot be read, in one plain line."""


class ResultsError(TendrilError):
    """A file cannot be read, or does not hold what is asked of it."""


class RunError(TendrilError):
    """A run that tendril refused or gave up: its own line, without its name in front, and with options
    named as Python has them, friction_mu for -friction_mu.

    command  as it was started, a list of words
    results  what was stored before, None if nothing was"""

    def __init__(self, line, command=(), results=None):
        line = line.replace("unknown option; -help lists them", "unknown option; docs/options.md has all")
        super().__init__(OPTION.sub(r"\1", VALUE.sub(r"-\1", line)))
        self.command, self.results = list(command), results


def did_you_mean(word, known) -> str:
    """The likeliest names for one that there is not, as the end of a sentence; "" if none is like it."""
    near = get_close_matches(str(word), [str(name) for name in known], 3, 0.75)
    return f", did you mean {' or '.join(near)}?" if near else ""


def path_of(value, what) -> Path:
    """A file's name, text or a Path."""
    if not isinstance(value, (str, os.PathLike)):
        raise TendrilError(f"{what}: give the name of a file, not {type(value).__name__}")
    return Path(value)


def whole(value, what, least=1) -> int:
    """A whole number, not below the least."""
    if isinstance(value, bool) or not isinstance(value, Integral) or value < least:
        raise TendrilError(f"{what} {value}: give a whole number from {least}")
    return int(value)


def positive(value, what) -> int:
    """A whole number from 1."""
    return whole(value, what)


def number(value, what, above=-math.inf) -> float:
    """A finite number, above another."""
    if isinstance(value, bool) or not isinstance(value, Real) or not above < value < math.inf:
        raise TendrilError(f"{what} {value}: give a number" + (f" above {above:g}" if above > -math.inf else ""))
    return float(value)


@contextmanager
def replacing(path):
    """A file beside the one of that name, to be written in its place: it takes its name when it is whole, and
    until then, or where the disk is full, an older one stays what it was."""
    given, path = path, Path(path).resolve()
    if path.exists() and not path.is_file():  # a device, a pipe
        yield path
        return
    part = path.with_name(f".{os.getpid()}.part.{path.name}")
    try:
        yield part
        os.replace(part, path)
    except BaseException as error:
        with suppress(OSError):
            part.unlink()
        if isinstance(error, OSError) and error.errno:
            error.filename = str(given)
        raise


def writable(basename):
    """Makes sure, before the work, that what will be kept under a name can be."""
    try:
        with TemporaryFile(dir=Path(basename).resolve().parent):
            pass
    except OSError as error:
        error.filename = str(basename)
        raise


def optional(module, error, line):
    """A module that not all have installed: where it is missing, the error with its line."""
    try:
        return import_module(module)
    except ImportError:
        raise error(line) from None


def complaint(error, command) -> str:
    """What a command says of an error, behind its own name, which stands there once."""
    return f"{command}: {plain(error).removeprefix(f'{command}: ')}"


def plain(error) -> str:
    """An error's text: of a file that cannot be made, also what to do."""
    if not isinstance(error, OSError) or not error.filename:
        return str(error)
    where = Path(error.filename).parent
    if isinstance(error, FileNotFoundError) and not where.exists():
        return f"{error.filename}: there is no directory {where}; make it, or name a file elsewhere"
    return f"{error.filename}: {error.strerror}"

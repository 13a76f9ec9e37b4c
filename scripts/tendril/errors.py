"""What can go wrong, in one plain line each."""

import math
import os
import re
import struct
import zlib
from contextlib import contextmanager, suppress
from functools import wraps
from importlib import import_module
from inspect import signature
from numbers import Integral, Real
from pathlib import Path
from tempfile import TemporaryFile

OPTION = re.compile(r"(?<![\w=/.-])-([a-z][a-z0-9_]*[a-z0-9])\b")
# the file that run() made of a value that is none of a command line: walls, arrays
VALUE = re.compile(r"-(\w+) \S*/\1-[0-9a-f]{8}\.(?:txt|h5)\b")


# what ends a line or moves the cursor: bytes of a damaged file are quoted in messages
CONTROL = re.compile("[\x00-\x1f\x7f-\x9f\u2028\u2029]")


class TendrilError(Exception):
    """What is asked for cannot be done: one line, whatever is quoted in it."""

    def __init__(self, *words):
        super().__init__(*(CONTROL.sub(" ", word) if isinstance(word, str) else word for word in words))


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


def path_of(value, what) -> Path:
    """A file's name, text or a Path."""
    if not isinstance(value, (str, os.PathLike)):
        raise TendrilError(f"{what}: give the name of a file, not {type(value).__name__}")
    return Path(value)


def briefly_shown(value) -> str:
    """What was given, in a few words of one line."""
    text = " ".join(repr(value).split())
    return text if len(text) <= 60 else f"{text[:57]}..."


def _times(value):
    if getattr(value, "ndim", None) == 1:
        value = value.tolist()
    good = KINDS["time"][0]
    return good(value) or isinstance(value, (list, tuple)) and all(map(good, value))


def _flag(value):
    return type(value).__name__ in ("bool", "bool_") or isinstance(value, Integral) and value in (0, 1)


def _number(value):
    return isinstance(value, Real) and type(value).__name__ not in ("bool", "bool_") and math.isfinite(value)


def _texts(value):
    return isinstance(value, str) or isinstance(value, (list, tuple)) and all(isinstance(one, str) for one in value)


def _numbers(value):
    return isinstance(value, str) or isinstance(value, (list, tuple)) and all(map(_number, value)) \
        or getattr(value, "ndim", 0) == 1 and value.dtype.kind in "fiu" and all(map(_number, value.tolist()))


# kinds of arguments: what is one, and what it is called
KINDS = {
    "flag": (_flag, "True or False"), "text": (lambda v: isinstance(v, str), "a name"), "number": (_number, "a number"),
    "above 0": (lambda v: _number(v) and v > 0, "more than 0"),
    "whole": (lambda v: _number(v) and isinstance(v, Integral), "a whole number"),
    "count": (lambda v: _number(v) and isinstance(v, Integral) and v > 0, "a whole number from 1"),
    "time": (lambda v: _number(v) or isinstance(v, (str, Real)) and not _flag(v) or isinstance(v, Integral) and type(v).__name__ != "bool",
             "a time, a number or text with a unit"),
    "times": (_times, "times, numbers or text with a unit, one or several in a list"),
    "numbers": (_numbers, "numbers in a list, or their name"),
    "texts": (_texts, "names, one or several in a list"),
    "file": (lambda v: isinstance(v, (str, os.PathLike)) and str(v).strip("."), "the name of a file"),
}


def arguments(error=TendrilError, **kinds):
    """Checks the arguments of a public function, each of one of KINDS; with "?" behind it also None."""
    def of(function):
        shape = signature(function)

        @wraps(function)
        def call(*given, **named):
            try:
                bound = shape.bind(*given, **named).arguments
            except TypeError as wrong:
                raise error(f"{function.__name__}: {wrong}") from None
            for name, value in bound.items():
                kind = kinds.get(name)
                if kind is None or value is None and kind.endswith("?"):
                    continue
                good, what = KINDS[kind.rstrip("?")]
                if not good(value):
                    raise error(f"{name}: give {what}, not {briefly_shown(value)}")
            try:
                return function(*given, **named)
            except MemoryError as found:
                raise error(too_large(function.__name__, found)) from None

        return call

    return of


def whole(value, what, least=1, most=math.inf) -> int:
    """A whole number, not below the least, not above the most."""
    if isinstance(value, bool) or not isinstance(value, Integral) or not least <= value <= most:
        raise TendrilError(f"{what} {briefly_shown(value)}: give a whole number from {least}" + (f" to {most}" if most < math.inf else ""))
    return int(value)


def too_large(what, found) -> str:
    """The line for a request that no memory holds."""
    return f"{what}: needs more memory than there is; ask for less ({' '.join(str(found).split()) or 'no memory'})"


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


def tracebacks() -> bool:
    """Whether a developer wants to see where an error came from: the variable TENDRIL_TRACEBACK is set."""
    return bool(os.environ.get("TENDRIL_TRACEBACK"))


# what libraries raise of a file that is damaged, or holds something else than it should
OF_CONTENT = (ArithmeticError, AttributeError, EOFError, LookupError, MemoryError, RuntimeError, SyntaxError, TypeError, ValueError,
              struct.error, zlib.error)


@contextmanager
def reading(path, what="cannot be read as what it should be", error=None):
    """Turns what a reader says of a damaged file into one line with its name. It stands around the reading of one file,
    and around nothing else: what is wrong elsewhere is the program's own fault."""
    try:
        yield
    except TendrilError:
        raise
    except OF_CONTENT as found:
        if tracebacks():
            raise
        reason = " ".join(str(found).split()) or type(found).__name__
        raise (error or ResultsError)(f"{path}: {what} ({reason[:200]})") from None


@contextmanager
def silenced(into=None):
    """Libraries of C and C++ write what they think of a file to the process' own stderr: nowhere, or into a file."""
    kept = os.dup(2)
    with open(os.devnull, "w") as nowhere:
        os.dup2((into or nowhere).fileno(), 2)
    try:
        yield
    finally:
        os.dup2(kept, 2)
        os.close(kept)


def optional(module, error, line):
    """A module that not all have installed: where it is missing, the error with its line."""
    try:
        return import_module(module)
    except ImportError:
        raise error(line) from None


def complaint(error, command) -> str:
    """What a command says of an error, behind its own name, which stands there once."""
    return CONTROL.sub(" ", f"{command}: {plain(error).removeprefix(f'{command}: ')}")


def plain(error) -> str:
    """An error's text: of a file that cannot be made, also what to do."""
    if not isinstance(error, OSError) or not error.filename:
        return str(error)
    where = Path(error.filename).parent
    if isinstance(error, FileNotFoundError) and not where.exists():
        return f"{error.filename}: there is no directory {where}; make it, or name a file elsewhere"
    return f"{error.filename}: {error.strerror}"

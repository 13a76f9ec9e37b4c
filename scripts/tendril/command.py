"""What all commands have in common: lists of numbers may begin with a minus, what is wrong with an argument is said in
one line, and the last net under them."""

import argparse
import math
import os
import re
import sys
import warnings

from .errors import CONTROL, OF_CONTENT, TendrilError, complaint, too_large, tracebacks
from .units import TIMES, quantity

NEGATIVE = re.compile(r"-(\d|\.\d)")  # how a value begins that is no option


class Parser(argparse.ArgumentParser):
    """What a command takes. prog: as it is typed; text: what -h says first."""

    def __init__(self, prog, text):
        if not os.environ.get("TENDRIL_SCRIPT"):  # it names itself as it is typed
            prog, text = (re.sub(r"scripts/(\w+)\.sh", r"tendril-py \1", one) for one in (prog, text))
        super().__init__(prog=prog, description=text, formatter_class=argparse.RawDescriptionHelpFormatter)
        self.register("type", float, number)
        self.register("type", int, whole)

    def parse_known_args(self, args=None, namespace=None):
        words = bound(sys.argv[1:] if args is None else args)
        if "--output" in self._option_string_actions:  # as most programs have it, and tendril itself
            words = ["--output" if word in ("-o", "-output") else word for word in words]
        return super().parse_known_args(words, namespace)

    def error(self, message):
        self.exit(2, f"{self.prog}: {CONTROL.sub(' ', ' '.join(message.split()))}; -h says what there is\n")


def bound(words):
    """Words in which a value that begins with a minus stands right behind its option, --origin=-12,0,31."""
    found = []
    for word in words:
        option = found[-1] if found else ""
        if NEGATIVE.match(word) and option.startswith("--") and len(option) > 2 and "=" not in option and "--" not in found:
            found[-1] = f"{option}={word}"
        elif NEGATIVE.match(word) and re.fullmatch(r"-[A-Za-z]", option) and "--" not in found:
            found[-1] = f"{option}{word}"
        else:
            found.append(word)
    return found


def number(text):
    try:
        return float(text)
    except ValueError:
        raise argparse.ArgumentTypeError(f'"{text}" is no number') from None


def whole(text):
    try:
        return int(text)
    except ValueError:
        raise argparse.ArgumentTypeError(f'"{text}" is no whole number') from None


def per_second(text):
    """A rate of frames: 25, 6/h, 1/10min, 1/3600."""
    count, _, long = text.partition("/")
    found = quantity(long) if long else (1.0, "s")
    wrong = argparse.ArgumentTypeError(f'"{text}" is no rate; give frames per second, 25, or 6/h, 1/10min')
    if found is None and long in TIMES:
        found = 1.0, long
    if found is None or found[1] not in ("", *TIMES) or not found[0] > 0:
        raise wrong
    try:
        return float(count) / (found[0] * TIMES[found[1] or "s"])
    except ValueError:
        raise wrong from None


def listed(text, count):
    """So many numbers with commas between."""
    words = text.split(",")
    if len(words) != count:
        raise argparse.ArgumentTypeError(f"{text}: give {count} numbers with commas between, not {len(words)}")
    found = []
    for word in words:
        try:
            found.append(float(word))
        except ValueError:
            raise argparse.ArgumentTypeError(f'{text}: "{word}" is no number') from None
        if not math.isfinite(found[-1]):
            raise argparse.ArgumentTypeError(f"{text}: {word} is not finite")
    return found


def lonely(command, main, words) -> int:
    """Runs a command; its exit code. What it did not expect, a fault of its own, is a line, too, and with the variable
    TENDRIL_TRACEBACK set a traceback; so are warnings of numpy, which tell a user nothing."""
    for stream in (sys.stdout, sys.stderr):  # a name may have letters that the terminal's alphabet has not
        if hasattr(stream, "reconfigure"):
            stream.reconfigure(errors="backslashreplace")
    with warnings.catch_warnings():
        if not tracebacks():
            warnings.simplefilter("ignore")
        try:
            return main(words)
        except (TendrilError, OSError) as error:
            print(complaint(error, command), file=sys.stderr)
        except KeyboardInterrupt:
            print(f"{command}: interrupted", file=sys.stderr)
            return 130
        except MemoryError as error:
            if tracebacks():
                raise
            print(too_large(command, error), file=sys.stderr)
        except OF_CONTENT as error:
            if tracebacks():
                raise
            reason = CONTROL.sub(" ", " ".join(str(error).split()))[:200]
            print(f"{command}: a fault of tendril's own, {type(error).__name__}: {reason}; TENDRIL_TRACEBACK=1 in front of the command "
                  "tells where", file=sys.stderr)
            return 3
    return 1

"""Arguments of commands: lists of numbers may begin with a minus, and what is wrong with one is said in one line."""

import argparse
import math
import re
import sys

NEGATIVE = re.compile(r"-(\d|\.\d)")  # how a value begins that is no option


class Parser(argparse.ArgumentParser):
    """What a command takes. prog: as it is typed; text: what -h says first."""

    def __init__(self, prog, text):
        super().__init__(prog=prog, description=text, formatter_class=argparse.RawDescriptionHelpFormatter)
        self.register("type", float, number)
        self.register("type", int, whole)

    def parse_known_args(self, args=None, namespace=None):
        return super().parse_known_args(bound(sys.argv[1:] if args is None else args), namespace)

    def error(self, message):
        self.exit(2, f"{self.prog}: {message}; -h says what there is\n")


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

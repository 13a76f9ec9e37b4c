"""What all commands have in common: options that are refused in one line, and the last net under them."""

from __future__ import annotations

import argparse
import sys
import warnings

from .errors import OF_CONTENT, TendrilError, complaint, tracebacks


class Parser(argparse.ArgumentParser):
    """A parser of a command's options, which refuses in one line."""

    def __init__(self, command, about):
        super().__init__(prog=f"tendril-py {command}", description=about, formatter_class=argparse.RawDescriptionHelpFormatter)
        self.command = command

    def error(self, message):
        self.exit(2, f"{self.command}: {' '.join(message.split())}; -h behind it tells how\n")


def lonely(command, main, words) -> int:
    """Runs a command; its exit code. What it did not expect, a fault of its own, is a line, too, and with the variable
    TENDRIL_TRACEBACK set a traceback; so are warnings of numpy, which tell a user nothing."""
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
        except OF_CONTENT as error:
            if tracebacks():
                raise
            reason = " ".join(str(error).split())[:200]
            print(f"{command}: a fault of tendril's own, {type(error).__name__}: {reason}; TENDRIL_TRACEBACK=1 in front of the command "
                  "tells where", file=sys.stderr)
            return 3
    return 1


def number_list(text, option, error=TendrilError) -> list[float]:
    """Numbers of a comma list."""
    try:
        return [float(word) for word in text.split(",")]
    except ValueError:
        raise error(f"{option} {text}: give numbers with commas between") from None

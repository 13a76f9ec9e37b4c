"""The commands behind the shell scripts: python -m tendril COMMAND ..., or tendril-py COMMAND ..., each
with -h."""

import os
import sys
from importlib import import_module

# matrices are small here and processes many: threads of BLAS would only wait for each other
os.environ.setdefault("OMP_NUM_THREADS", "1")

COMMANDS = {"plot": "pictures", "animate": "films", "view": "page", "fit": "fit_command",
            "measure": "filming",
            "map": "maps", "ensemble": "ensembles", "growth_table": "growth_table", "export": "exports",
            "stability": "plot_stability", "surface": "surfaces", "live": "live_server", "run": "run_command:run_main",
            "sweep": "run_command:sweep_main", "critical": "run_command:critical_main"}


def main(words=None):
    words = sys.argv[1:] if words is None else words
    known = ", ".join(COMMANDS)
    if words and words[0] in ("-h", "--help"):
        print(f"tendril-py COMMAND ...: {known}; -h behind it tells how")
        return 0
    if words and words[0] == "--version":
        from . import __version__

        print(f"tendril {__version__}")
        return 0
    if not words or words[0] not in COMMANDS:
        print(f"tendril: give a command, {known}", file=sys.stderr)
        return 2
    from .command import lonely

    module, _, name = COMMANDS[words[0]].partition(":")
    return lonely(words[0], lambda more: getattr(import_module(f".{module}", __package__), name or "main")(more), words[1:])


if __name__ == "__main__":
    sys.exit(main())

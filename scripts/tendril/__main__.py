"""The commands behind the shell scripts: python -m tendril COMMAND ..., each with -h."""

import os
import sys
from importlib import import_module

COMMANDS = {"plot": "pictures", "animate": "films", "view": "page", "fit": "fit_command", "measure": "filming",
            "map": "map", "ensemble": "ensemble", "growth_table": "growth_table",
            "stability": "plot_stability"}


# matrices are small here and processes many: threads of BLAS would only wait for each other
os.environ.setdefault("OMP_NUM_THREADS", "1")


def main(words):
    if not words or words[0] not in COMMANDS:
        known = ", ".join(COMMANDS)
        print(f"python -m tendril COMMAND ...: {known}; -h behind it tells how"
              if words and words[0] in ("-h", "--help") else f"tendril: give a command, {known}",
              file=sys.stdout if words and words[0] in ("-h", "--help") else sys.stderr)
        return 0 if words and words[0] in ("-h", "--help") else 2
    return import_module(f".{COMMANDS[words[0]]}", __package__).main(words[1:])


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))

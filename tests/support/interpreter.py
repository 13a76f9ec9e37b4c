"""What every test in Python begins with: .venv's python takes over from one that lacks what is needed."""

import os
import signal
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
# a command in the background of a script ignores Ctrl-C, and so would all that tests start and interrupt
signal.signal(signal.SIGINT, signal.default_int_handler)


def from_venv(error):
    """Starts the test anew with .venv's python, or ends it with what is missing."""
    venv = ROOT / ".venv/bin/python"
    if venv.exists() and Path(sys.prefix) != venv.parent.parent:
        os.execv(venv, [str(venv), *sys.argv])
    sys.exit(f"{Path(sys.argv[0]).stem}: {error}; scripts/setup.sh makes .venv with what it needs")

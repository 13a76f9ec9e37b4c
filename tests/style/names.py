#!/usr/bin/env python3
"""Python that names what nothing defines (an import lost when a function moved) fails only where it runs; pyflakes finds it where it stands.

    names.py [the project's folder]"""

import subprocess
import sys
from pathlib import Path

ROOT = Path(sys.argv[1] if len(sys.argv) > 1 else Path(__file__).resolve().parents[2])
FATAL = "undefined name", "undefined local", "invalid syntax", "may be undefined"

try:
    import pyflakes  # noqa: F401
except ImportError:
    print("pyflakes is not there (tests/requirements.txt): left out")
    sys.exit(77)
files = sorted(str(file) for folder in ("scripts", "tests", "docs") for file in (ROOT / folder).rglob("*.py"))
said = subprocess.run([sys.executable, "-m", "pyflakes", *files], capture_output=True, text=True).stdout
wrong = [line for line in said.splitlines() if any(word in line for word in FATAL)]
print("\n".join(wrong) or f"{len(files)} files name nothing that is not there")
sys.exit(bool(wrong))

#!/usr/bin/env python3
# test: random scenes hold under mirrors, turns and units
"""A dozen of the random scenes of scripts/lab/invariances.py.

    invariances_test.py build/tendril"""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "support"))
from interpreter import ROOT, from_venv

sys.path.insert(0, str(ROOT / "scripts/lab"))
sys.argv[1:] = ["--tendril", str(Path(sys.argv[1]).resolve()), "--scenes", "12"]
try:
    import invariances
except ImportError as error:
    from_venv(error)

sys.exit(invariances.main())

#!/usr/bin/env python3
# test: random scenes hold under mirrors, turns and units | with --ranks=no
# test: random scenes are the same on ranks | ranks 2 | with --ranks=only
"""A dozen of the random scenes of scripts/lab/invariances.py, of half of its cells.

    invariances_test.py build/tendril [--ranks=no|only]"""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "support"))
from interpreter import ROOT, from_venv

sys.path.insert(0, str(ROOT / "scripts/lab"))
sys.argv[1:] = ["--tendril", str(Path(sys.argv[1]).resolve()), "--scenes", "12", "--cells", "60", *sys.argv[2:]]
try:
    import invariances
except ImportError as error:
    from_venv(error)

sys.exit(invariances.main())

#!/usr/bin/env python3
# test: random walls in oblique frames are the same walls
"""Some of the random scenes of scripts/lab/oblique.py: walls of all kinds in frames oblique to the laboratory, and straight
rods that sink onto cylinders and balls. (Meshes, if VTK is there.)

    oblique_test.py build/tendril"""

import sys
import tempfile
from importlib.util import find_spec
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "support"))
from interpreter import ROOT, from_venv

sys.path.insert(0, str(ROOT / "scripts/lab"))
try:
    import oblique
except ImportError as error:
    from_venv(error)


def main():
    tendril = str(Path(sys.argv[1]).resolve())
    meshes = ["body"] if find_spec("vtkmodules") else []
    faults = []
    for study, count, kinds in ((oblique.fed, 1, ["sphere", "cylinder", "cone", "torus", "tube", "plane"]),
                                (oblique.fed, 1, meshes), (oblique.lengthways, 3, ["cylinder", "sphere"])):
        with tempfile.TemporaryDirectory(prefix="tendril-") as folder:
            faults += study(tendril, Path(folder), count * len(kinds), 1, kinds)
    for fault in faults:
        print("FAIL", fault)
    return len(faults) > 0


if __name__ == "__main__":
    sys.exit(main())

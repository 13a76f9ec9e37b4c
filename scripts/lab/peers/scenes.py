"""What the scripts of the peers in space have in common: a scene is run, and said in two lines of JSON, what was found and
what it cost."""

import json
import sys

import numpy as np


def run(scenes, step=None):
    """SCENE [-NAME NUMBER ...] of the command line. scenes: {name: (function of the numbers, their usual values)};
    step(scene, numbers): a stable dt, if none is given."""
    scene, words = sys.argv[1], sys.argv[2:]
    function, o = scenes[scene]
    o |= {name.lstrip("-"): float(value) for name, value in zip(words[::2], words[1::2])}
    o["elements"] = int(o["elements"])
    if step and "dt" not in o:
        o["dt"] = step(scene, o)
    found, cost = function(o)
    print(json.dumps(found))
    if not all(np.isfinite(v).all() for v in map(np.array, found.values())):
        cost["failed"] = "not a number: the step is too long"
    print(json.dumps(cost))
    sys.exit(int("failed" in cost))

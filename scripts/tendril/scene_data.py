"""Makes the data files of scenes, options/data/*.h5. They are kept with the scenes; this tells what
is in them, and makes them anew.

    PYTHONPATH=scripts .venv/bin/python -m tendril.scene_data"""

from pathlib import Path

import h5py
import numpy as np


def write(path, **datasets):
    with h5py.File(path, "w") as f:
        for name, values in datasets.items():
            f[name] = np.asarray(values, float)


def rise(z):
    """From 0 at z = 0 to 1 at z = 1, with two derivatives."""
    z = np.clip(z, 0, 1)
    return z**3 * (10 - 15 * z + 6 * z * z)


def main():
    data = Path("options/data")
    data.mkdir(parents=True, exist_ok=True)
    # A catheter: its tip has a tenth of the shaft's stiffness and a hook; both end at distance 3.
    d = np.linspace(0, 3, 25)
    write(data / "catheter.h5", distance=d, factor=0.1 + 0.9 * rise(d / 3),
          curvature=0.5 * (1 - rise(d / 1.5)))
    # A vessel that narrows: friction along it rises from 0.2 to 1 between x1 = 2 and 10.
    x1 = np.linspace(0, 12, 25)
    write(data / "vessel.h5", x1=x1, x2=[0], factor=[0.2 + 0.8 * rise((x1 - 2) / 8)])


if __name__ == "__main__":
    main()

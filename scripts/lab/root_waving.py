#!/usr/bin/env python3
"""How long the waves of a root are on a plate that is tilted back: runs options/root-waving.opts over the tilt, and writes
docs/notes/root-waving.csv and .png.

    root_waving.py [--draw]

Tilt is that of the plate from the vertical. A wave is the rod between two maxima of x2, of what has been laid down; its error is what
the run tells of its tip, over the number of waves. A root whose direction along the plate turns by more than 180 degrees coils. TENDRIL names
the executable."""

import argparse
import csv
import tempfile

import h5py
import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

from measure import ROOT, TENDRIL, execute

TABLE = ROOT / "docs" / "notes" / "root-waving.csv"
COLUMNS = ("tilt", "waves", "along_rod", "spread", "along_plate", "width", "error", "told", "coils")
TILTS = (0, 10, 20, 30, 38, 45, 53, 60, 68, 75)
ZONE = 0.597  # mm


def waves_of(f):
    """Of a result file, in mm; error: of a wave."""
    x, d1 = f["shapes/x"][-1], f["shapes/d1"][-1]
    p = np.concatenate([[0], np.cumsum(np.linalg.norm(np.diff(x, axis=0), axis=1))])
    angle = np.unwrap(np.arctan2(d1[:, 1], d1[:, 0]))
    laid = p < p[-1] - ZONE
    at = np.flatnonzero((angle[:-1] > 0) & (angle[1:] <= 0) & laid[1:])
    share = angle[at] / (angle[at] - angle[at + 1])
    tops = [np.interp(at + share, np.arange(len(p)), values) for values in (p, x[:, 0])]
    long, along = (np.diff(values) for values in tops)
    told = float(f.attrs["error_end_tip"])
    swings = bool(np.ptp(angle[laid]) > 0.2)
    row = {"waves": len(long) if swings else 0, "width": float(np.ptp(x[laid, 1])), "told": told,
           "coils": int(np.abs(angle).max() > np.pi)}
    if swings and len(long):
        row |= {"along_rod": long.mean(), "spread": np.ptp(long) / 2, "along_plate": along.mean(), "error": told * p[-1] / len(long)}
    return row


def run(tilt):
    angle = np.radians(tilt)
    with tempfile.TemporaryDirectory() as scratch:
        code, _, err, _ = execute([TENDRIL, "-options_file", str(ROOT / "options/root-waving.opts"), "-rod_cells", "100", "-tropism_direction",
                                   f"{np.cos(angle):.6f},0,{-np.sin(angle):.6f}", "-output", f"{scratch}/run.h5"], 900)
        if code:
            raise SystemExit(f"tilt {tilt}: {err}")
        with h5py.File(f"{scratch}/run.h5") as f:
            return {"tilt": tilt} | waves_of(f)


def draw(rows):
    waves = [row for row in rows if int(row["waves"]) > 1 and not int(row["coils"])]
    figure, ax = plt.subplots(figsize=(5, 3.2), layout="constrained")
    tilt = [float(row["tilt"]) for row in waves]
    for name, label, style in (("along_rod", "along the root", "o-"), ("along_plate", "down the plate", "s--")):
        ax.errorbar(tilt, [float(row[name]) for row in waves], yerr=[float(row["error"]) for row in waves], fmt=style, capsize=3, ms=4,
                    label=label)
    low = max((float(row["tilt"]) for row in rows if float(row["tilt"]) < min(tilt)), default=0)
    high = min((float(row["tilt"]) for row in rows if float(row["tilt"]) > max(tilt)), default=90)
    ax.axvspan(0, (low + min(tilt)) / 2, color="#eeeeee")
    ax.axvspan((high + max(tilt)) / 2, 90, color="#f3e3d3")
    ax.text(2, 0.1, "straight", fontsize=9)
    ax.text(88, 0.1, "loops,\ncoils", fontsize=9, ha="right")
    ax.set(xlim=(0, 90), ylim=(0, None), xlabel="tilt of the plate from the vertical (degrees)", ylabel="length of a wave (mm)")
    ax.legend(frameon=False)
    figure.savefig(TABLE.with_suffix(".png"), dpi=150)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--draw", action="store_true", help="from the table as it is")
    if not parser.parse_args().draw:
        rows = []
        for tilt in TILTS:
            rows.append(run(tilt))
            print(rows[-1], flush=True)
        with open(TABLE, "w", newline="") as f:
            table = csv.DictWriter(f, COLUMNS)
            table.writeheader()
            table.writerows({k: f"{v:.4g}" if isinstance(v, float) else v for k, v in row.items()} for row in rows)
    with open(TABLE, newline="") as f:
        draw(list(csv.DictReader(f)))


if __name__ == "__main__":
    main()

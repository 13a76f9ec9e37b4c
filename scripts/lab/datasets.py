#!/usr/bin/env python3
"""Writes docs/datasets.md, the reference of the result file, from what small runs leave: every dataset says what it is
and in which unit.

    .venv/bin/python scripts/lab/datasets.py build/tendril > docs/datasets.md"""

import re
import subprocess
import sys
import tempfile
from pathlib import Path

import h5py
from options import ENVIRONMENT

ROOT = Path(__file__).resolve().parents[2]
SHORT = "-rod_cells 10 -growth_initial_length 1 "
WALLED = SHORT + "-wall_file walls.txt -contact_diameter 0.1 "
STRAIGHT = "-growth_initial_length 0.5 -rod_cells 20 "
RUNS = {  # so that each dataset is in one of them
    "plane": WALLED + "-growth_type feed -rod_curvature 0.1 -rod_weight 0,-0.01 -stop_contact true",
    "space": WALLED + "-rod_curvature_2 0.1 -ts_max_time 0.2",
    "heavy": WALLED + "-rod_weight 0,0,-0.01 -ts_max_time 0.2",
    "steered": SHORT + "-rod_curvature_file bend.h5 -ts_max_time 0.2",
    "learns": SHORT + "-growth_ironing 5 -ts_max_time 0.2",
    "critical": "-task critical " + STRAIGHT,
    "across": "-task critical -rod_bend_ratio 0.5 " + STRAIGHT,
    "stability": "-task stability -rod_bend_ratio 0.5 -stability_points 3 -stability_vertices 20 -stability_end 1 "
                 "-stability_transient_cells 20 " + STRAIGHT,
    "sweep": "-task sweep -sweep_file table.csv -sweep_store series,shapes -ts_max_time 0.2 -rod_cells 10",
}
# head, words below it, runs, and what their names begin with
PARTS = [
    ("Series", "One value per accepted step, under /series.", ("plane",), "series/"),
    ("Series of a rod in space", "Besides; weight_power and weight_force stand in the plane, too, if the rod has weight.",
     ("space", "heavy"), "series/"),
    ("Series of a rod that is steered", "Besides, where natural curvature is [given over time](guide.md#steered).", ("steered",),
     "series/"),
    ("Series of a rod whose material learns", "Besides, of -tropism_ options and -growth_ironing.", ("learns",), "series/"),
    ("Shapes", "The rod at the stored times, under /shapes: k counts them, n the nodes.", ("plane",), "shapes/"),
    ("Shapes of a rod in space", "Where they differ.", ("space",), "shapes/"),
    ("The event", "If one ended the run. The attribute `kind` says which.", ("plane",), "event/"),
    ("The critical length", "Of `-task critical`.", ("critical", "across"), "critical/"),
    ("Stability", "Of `-task stability`; k counts the times of the table.", ("stability",), "stability/"),
    ("The deflection that grows most", "Of `-task stability`, in two norms.", ("stability",), "transient/"),
    ("A sweep", "Of `-task sweep`: an entry of each a run.", ("sweep",), ""),
]


def datasets(place, name, options):
    """What the file of a run holds: its datasets' units and descriptions by name."""
    (place / "walls.txt").write_text("plane 2 0 -1 0\n")
    (place / "table.csv").write_text("friction_mu\n0\n1\n")
    with h5py.File(place / "bend.h5", "w") as file:
        file["s"], file["t"], file["curvature"] = [0, 0.3, 0.6, 1], [0, 1], [[0] * 4, [1] * 4]
    subprocess.run([sys.argv[1], *options.split(), "-output", f"{name}.h5"], check=True, cwd=place, env=ENVIRONMENT,
                   capture_output=True, stdin=subprocess.DEVNULL)
    found = {}

    def look(path, item):
        if isinstance(item, h5py.Dataset) and not path.startswith(("restart", "walls")):
            found[path] = tuple(word.decode() if isinstance(word, bytes) else word
                                for word in (item.attrs["units"], item.attrs["description"]))

    with h5py.File(place / f"{name}.h5") as file:
        file.visititems(look)
    return found


def order():
    """The series as the program has them."""
    return re.findall(r"(?m)^  X\((\w+),", (ROOT / "src/record/observe.h").read_text())


def rows(found, start, known):
    """A table's rows, without what an earlier table has alike."""
    last = order()
    names = [name for name in found if name.startswith(start) and known.get(name) != found[name]]
    names.sort(key=lambda name: (last.index(name[7:]) if start == "series/" else 0))
    for name in names:
        unit, words = found[name]
        yield f"| {name[len(start):]} | {unit} | {words.replace('|', '‖')} |"


def main():
    program = Path(sys.argv[1]).resolve()
    sys.argv[1] = str(program)
    with tempfile.TemporaryDirectory(prefix="tendril-") as place:
        files = {name: datasets(Path(place), name, options) for name, options in RUNS.items()}
    print("# Datasets of the result file\n\nMade by `scripts/lab/datasets.py` from what small runs leave. Units are those of "
          "[results.md](results.md#2-units);\n‖ is a norm. [results.md](results.md) says how the file is written and read, and has its "
          "attributes.")
    known = {}
    for head, words, runs, start in PARTS:
        print(f"\n## {head}\n\n{words}\n\n| name | unit | |\n|---|---|---|")
        for run in runs:
            found = files[run]
            if run == "sweep":
                found = {name: found[name] for name in found if "columns" not in name and not name.startswith(("final", "series", "shapes"))
                         or re.search(r"/(first|count|nodes|first_node)", name)}
            for row in rows(found, start, known):
                print(row)
            known |= {name: found[name] for name in found if name.startswith(start)}


if __name__ == "__main__":
    main()

#!/usr/bin/env python3
"""The layers of src/: a folder includes only from itself and from folders below it; private headers
of PETSc, HDF5 and SLEPc stay where they belong.

    layers.py [src]"""

import re
import sys
from pathlib import Path

ROOMS = ["base", "material", "world", "scene", "straight", "rod", "stepping", "record", "tasks"]  # from below
STRANGERS = {("material", "world"), ("world", "material")}  # a rod's own, and what is around all rods
# header: who may include it
KEPT = {r"petsc/private/": {"stepping/vbdf.c", "stepping/controller.c", "rod/frame.c", "rod/coupled.c"},
        r"hdf5\.h": {"base/hdf.c"},
        r"slepc": {"straight/", "tasks/stability.c", "tasks/critical.c", "tasks/bent.c", "tasks/tendril.c"}}


def faults(src):
    for file in sorted(src.rglob("*.[ch]")):
        name = file.relative_to(src).as_posix()
        room = name.split("/")[0] if "/" in name else "main"
        floor = ROOMS.index(room) if room in ROOMS else len(ROOMS)
        for line in file.read_text().splitlines():
            ours = re.match(r'#include "(\w+)/\w+\.h"', line)
            if ours and (ours.group(1) not in ROOMS or ROOMS.index(ours.group(1)) > floor or
                         (room, ours.group(1)) in STRANGERS):
                yield f"{name}: {line}"
            elif line.startswith('#include "') and not ours:
                yield f"{name}: {line} (write the room)"
            for header, allowed in KEPT.items():
                if re.match(rf"#include <{header}", line) and not name.startswith(tuple(allowed)):
                    yield f"{name}: {line} (only {', '.join(sorted(allowed))})"


def main():
    src = Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).resolve().parent.parent / "src"
    found = list(faults(src))
    print("\n".join(found) or f"{len(list(src.rglob('*.[ch]')))} files keep the layers")
    return len(found) > 0


if __name__ == "__main__":
    sys.exit(main())

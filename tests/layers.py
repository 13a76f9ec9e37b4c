#!/usr/bin/env python3
"""The layers of src/: a folder includes only from itself and from folders below it; private headers
of PETSc, HDF5 and SLEPc stay where they belong. And what includes do not show: laws name no solver,
models no time stepper; a rod holds nothing of a solve; only the scene's own folder copies one.

    layers.py [src]"""

import re
import sys
from pathlib import Path

ROOMS = ["base", "material", "world", "scene", "straight", "rod", "stepping", "record", "tasks"]  # from below
STRANGERS = {("material", "world"), ("world", "material")}  # a rod's own, and what is around all rods
# header: who may include it
KEPT = {r"petsc/private/": {"stepping/vbdf.c", "stepping/controller.c", "rod/rod.c", "rod/coupled.c"},
        r"hdf5\.h": {"base/hdf.c"},
        r"slepc": {"straight/", "tasks/stability.c", "tasks/critical.c", "tasks/bent.c", "tasks/tendril.c"}}

LAW = {"TS", "SNES", "KSP", "PC", "EPS", "ST", "Mat"}  # classes of PETSc and SLEPc that a law does not name
SOLVERS = {"material": LAW, "world": LAW, "scene": LAW, "rod": {"TS", "SNES", "EPS", "ST"}}
OF_A_SOLVE = r"\b(Vec|Mat|KSP|SNES|TS|Elimination|RodState|fresh|counts|shift|rate)\b"  # no member of a rod


def without_comments(text):
    """The text with comments and strings blanked out."""
    return re.sub(r'/\*.*?\*/|"(?:\\.|[^"\n])*"', " ", text, flags=re.S)


def named(text, room):
    """What a file names that its room does not know, or holds that it should not."""
    for solver in sorted(SOLVERS.get(room, ())):
        for word in sorted(set(re.findall(rf"\b{solver}(?:[A-Z][a-z]\w*)?\b", text))):
            yield f"names {word}, of a solver"
    for members in re.findall(r"struct _Rod \{(.*?)\n\};", text, flags=re.S):
        for line in members.splitlines():
            if re.search(OF_A_SOLVE, line):
                yield f"a rod holds of a solve: {line.strip()}"
    if room != "scene":
        for copy in re.findall(r"struct _Scene \w+\s*[;=]", text):
            yield f"copies a scene: {copy} (SceneShare())"


def faults(src):
    for file in sorted(src.rglob("*.[ch]")):
        name = file.relative_to(src).as_posix()
        room = name.split("/")[0] if "/" in name else "main"
        floor = ROOMS.index(room) if room in ROOMS else len(ROOMS)
        yield from (f"{name}: {fault}" for fault in named(without_comments(file.read_text()), room))
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

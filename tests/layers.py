#!/usr/bin/env python3
"""The layers of src/: a folder includes only from itself and from folders below it; private headers
of PETSc, HDF5 and SLEPc stay where they belong. And what includes do not show: laws name no solver,
models no time stepper; a rod holds nothing of a solve; only the scene's own folder copies one.

Of the Python package and the scripts beside it: no module imports, at its top, in a function or for
types alone, one that imports it. Modules by name are for the package's front (__init__, __main__), and for the
methods of results.py that draw (ABOVE).

    layers.py [the project's folder]"""

import ast
import re
import sys
from pathlib import Path

ROOMS = ["base", "curve", "material", "world", "scene", "straight", "rod", "system", "stepping", "record", "tasks", "library"]  # from below
STRANGERS = {("material", "world"), ("world", "material")}  # a rod's own, and what is around all rods
# header: who may include it
KEPT = {r"petsc/private/": {"stepping/vbdf.c", "stepping/controller.c", "rod/rod.c", "rod/coupled.c", "system/model.c"},
        r"hdf5\.h": {"base/hdf_library.h"},
        r"slepc": {"straight/", "tasks/stability.c", "tasks/critical.c", "tasks/bent.c", "tasks/program.c", "library/process.c"}}

LAW = {"TS", "SNES", "KSP", "PC", "EPS", "ST", "Mat"}  # classes of PETSc and SLEPc that a law does not name
SOLVERS = {"material": LAW, "world": LAW, "scene": LAW, "rod": {"TS", "SNES", "EPS", "ST"}, "system": {"TS", "SNES", "EPS", "ST"}}
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
            ours = re.match(r'#include "(\w+)/\w+\.(?:h|def)"', line)
            if ours and (ours.group(1) not in ROOMS or ROOMS.index(ours.group(1)) > floor or
                         (room, ours.group(1)) in STRANGERS):
                yield f"{name}: {line}"
            elif line.startswith('#include "') and not ours:
                yield f"{name}: {line} (write the room)"
            for header, allowed in KEPT.items():
                if re.match(rf"#include <{header}", line) and not name.startswith(tuple(allowed)):
                    yield f"{name}: {line} (only {', '.join(sorted(allowed))})"


def imported(tree, names, package):
    """The modules among these that a module imports, wherever it does."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            said = [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            module = f"{package}.{node.module or ''}".rstrip(".") if node.level else node.module
            said = [module, *(f"{module}.{alias.name}" for alias in node.names)]
        else:
            continue
        yield from {name for one in said for name in names if one in (name, f"{package}.{name}")}


def by_name(tree):
    """The lines in which a module is imported that no import names: import_module(f".{name}")."""
    return [node.lineno for node in ast.walk(tree) if isinstance(node, ast.Call) and node.args
            and getattr(node.func, "id", getattr(node.func, "attr", "")) in ("import_module", "__import__")
            and re.match(r"f?['\"](\.|tendril)", ast.unparse(node.args[0]))]


def round_trips(graph):
    """Of each set of modules that import each other one way round, a -> b -> a."""
    def way(begin):
        reached, now = {begin: (begin,)}, [begin]
        while now:
            at = now.pop(0)
            for to in sorted(graph[at]):
                if to == begin:
                    return (*reached[at], begin)
                if to not in reached:
                    reached[to] = (*reached[at], to)
                    now.append(to)
        return ()

    told = set()
    for name in sorted(graph):
        if name not in told and (round_trip := way(name)):
            told.update(round_trip)
            yield " -> ".join(round_trip)


def modules(folder):
    """Those of a folder; of tests, of all below it."""
    return sorted(folder.rglob("*.py") if folder.name == "tests" else folder.glob("*.py"))


def cycles(folder):
    """Imports of a folder's modules that come back to where they began."""
    trees = {file.stem: ast.parse(file.read_text()) for file in modules(folder)}
    graph = {name: set(imported(tree, trees, folder.name)) for name, tree in trees.items()}
    yield from (f"{folder.name}: imports in a circle: {found}" for found in round_trips(graph))
    yield from (f"{folder.name}/{name}.py:{line}: imports a module by name" for name, tree in trees.items()
                if name not in ("__init__", "__main__", "results") for line in by_name(tree))


def main():
    root = Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).resolve().parent.parent
    src, python = root / "src", [root / name for name in ("scripts/tendril", "scripts/lab", "tests")]
    found = [*faults(src), *(fault for folder in python for fault in cycles(folder))]
    print("\n".join(found) or f"{len(list(src.rglob('*.[ch]')))} files of src keep the layers; no imports go round in "
          f"{sum(len(modules(folder)) for folder in python)} modules")
    return len(found) > 0


if __name__ == "__main__":
    sys.exit(main())

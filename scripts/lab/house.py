#!/usr/bin/env python3
"""Counts what a reader of the code has to carry, a column for each working tree: lines, twins, branches on the dimension, what
solver and records know of a scene, constants, words. docs/notes/house.md has the table.

    scripts/lab/house.py .../tendril-279e4dd . > table.md"""

import re
import sys
from pathlib import Path

GENERATED = {"options.md", "datasets.md", "heuristics.md"}


def sources(root, *rooms):
    """The C files of rooms of src/, of all if none is named."""
    return [file for room in (rooms or ["**"]) for file in sorted((root / "src").glob(f"{room}/*.[ch]"))]


def lines(files, pattern=""):
    return sum(bool(re.search(pattern, line)) for file in files for line in file.read_text().splitlines())


def twins(root):
    """Files that are there twice: X and X_space, frame_X and space_X."""
    files = {file.relative_to(root): file for file in sources(root)}
    pairs = [(file, file.with_name(name)) for file in files
             for name in (file.name.replace("_space.", "."), file.name.replace("space_", "frame_")) if name != file.name]
    return {files[one] for pair in pairs if set(pair) <= set(files) for one in pair}


def constants(root):
    """How many the registers have, and how many of these name a test that fails without them."""
    rows = [row for file in (root / "src").glob("*/*.def") for row in re.findall(r'RULE\((.*?"(?:[^"\\]|\\.)*")\)', file.read_text(), re.S)]
    tested = [row for row in rows if re.findall(r'"([^"]*)"\s*$', row)[0].split(":")[0] not in ("", "none")]
    return f"{len(rows)}, {len(tested)}"


def words(root):
    pages = [root / "README.md", root / "CONTRIBUTING.md", *(root / "docs").rglob("*.md")]
    return sum(len(page.read_text().split()) for page in pages if "notes" not in page.parts and page.name not in GENERATED)


def longest(root):
    sizes = {file.name: lines([file]) for file in sources(root)}
    return ", ".join(f"{name} {size}" for name, size in sorted(sizes.items(), key=lambda item: -item[1])[:5])


ROWS = {
    "lines of src": lambda root: lines(sources(root)),
    "files above 700 lines": lambda root: sum(lines([file]) > 700 for file in sources(root)),
    "the longest files": longest,
    "lines of files that are there twice, for plane and space": lambda root: lines(twins(root)),
    "`[2]` or `d < 2` in rod, world, record": lambda root: lines(sources(root, "rod", "world", "record"), r"\[2\]|d < 2"),
    "branches on `space.rod` or `model->space`": lambda root: lines(sources(root), r"space\.rod|model->space"),
    "`scene->` in stepping": lambda root: lines(sources(root, "stepping"), "scene->"),
    "`scene->` in record": lambda root: lines(sources(root, "record"), "scene->"),
    "constants in registers, with a test that fails": constants,
    "words of pages, without notes and what is generated": words,
}


def main(roots):
    print("| | " + " | ".join(root.resolve().name for root in roots) + " |\n|---" + "|---" * len(roots) + "|")
    for name, count in ROWS.items():
        print(f"| {name} | " + " | ".join(str(count(root)) for root in roots) + " |")


if __name__ == "__main__":
    main([Path(name) for name in sys.argv[1:]] or [Path(".")])

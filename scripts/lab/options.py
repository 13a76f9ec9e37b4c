#!/usr/bin/env python3
"""Writes docs/options.md, the reference of the options, from what -help prints.

    scripts/lab/options.py build/tendril > docs/options.md"""

import os
import re
import subprocess
import sys

ENVIRONMENT = dict(os.environ, OMPI_ALLOW_RUN_AS_ROOT="1", OMPI_ALLOW_RUN_AS_ROOT_CONFIRM="1",
                   OMPI_MCA_ess_singleton_isolated="1")


def main():
    text = subprocess.run([sys.argv[1], "-help"], capture_output=True, text=True, check=True,
                          env=ENVIRONMENT, stdin=subprocess.DEVNULL).stdout
    print("# Options\n\nMade by `scripts/lab/options.py` from `tendril -help`. An option that "
          "nothing reads, a value out of\nrange and a name that is none are refused in one line. "
          "Values that are lengths, times, forces,\nspeeds or curvatures may carry a unit once "
          "the rod in the laboratory is given; angles may carry\n`deg`. PETSc's other options "
          "work as well: `tendril -help petsc` lists them for a given run.")
    for block in re.split(r"^(?=\S)", text.split("\n\n", 1)[1], flags=re.M):
        title, *rows = block.rstrip().split("\n")
        if not rows:
            continue
        print(f"\n## {title}\n\n| option | value | default | |\n|---|---|---|---|")
        for row in rows:
            name, kind, usual, meaning = re.match(r"  (-\w+) +<(.*), default (.*?)>: (.*)$",
                                                  row).groups()
            meaning = re.sub(r"\|(.*?)\|", r"‖\1‖", meaning)
            print(f"| {name} | {kind.replace(',', ', ')} | {usual} | {meaning} |")


if __name__ == "__main__":
    main()

#!/usr/bin/env python3
"""Writes docs/options.md, the reference of tendril's own options, from what -help prints for each
growth law, shape and task.

    options.py build/tendril > docs/options.md"""

import os
import re
import subprocess
import sys

LOOKS = ("", "-growth_type gaussian", "-growth_type table -growth_table x", "-shape_type random",
         "-shape_type file -shape_file x", "-rod_curvature_random 1", "-task stability",
         "-task critical")
ENVIRONMENT = dict(os.environ, OMPI_ALLOW_RUN_AS_ROOT="1", OMPI_ALLOW_RUN_AS_ROOT_CONFIRM="1",
                   OMPI_MCA_ess_singleton_isolated="1")
GROUPS = {"task": "Task and files", "accuracy": "Accuracy", "growth": "Growth",
          "friction": "Friction", "clamp": "Rod and clamp", "rod": "Rod and clamp",
          "shape": "Initial shape", "ts": "Run", "output": "Task and files",
          "restart": "Task and files", "quiet": "Task and files", "stop": "Events",
          "si": "Laboratory units", "stability": "-task stability", "snes": "Run", "pc": "Run"}


def collect(tendril):
    """{option: (kind and default, text)}"""
    found = {}
    for look in LOOKS:
        done = subprocess.run([tendril, "-help", *look.split()], capture_output=True, text=True,
                              env=ENVIRONMENT, stdin=subprocess.DEVNULL)
        for name, kind, default, text in re.findall(
                r"^  -(\w+) +<(.*), default (.*?)>: (.*)$", done.stdout, re.M):
            found.setdefault(name, (kind, default, text))
    return found


def main():
    groups = {}
    for name, entry in collect(sys.argv[1]).items():
        groups.setdefault(GROUPS.get(name.split("_")[0], "Other"), {})[name] = entry
    print("# Options of tendril\n\nMade by `scripts/options.py` from `-help`. Beside these, PETSc's "
          "own options work\n(`-ts_type`, `-ts_dt`, `-ts_bdf_order`, `-snes_...`, `-ksp_...`, "
          "`-pc_...`, `-eps_...`, `-log_view`):\n`build/tendril -help` lists them for a given run.")
    for title in dict.fromkeys(GROUPS.values()):
        if title in groups:
            print(f"\n## {title}\n\n| option | value | default | |\n|---|---|---|---|")
            for name, (kind, default, text) in groups[title].items():
                text = re.sub(r"\|(.*?)\|", r"‖\1‖", text)
                print(f"| -{name} | {kind} | {default} | {text} |")


if __name__ == "__main__":
    main()

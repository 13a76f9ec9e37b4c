#!/usr/bin/env python3
"""Which tests fail where a constant of the registers (rules.def) is far from its value? In a copy of the source that reads another
value from the environment when it starts, so that one build serves all.

    rules.py SCRATCH [--only REGEX] [--register REGEX] [--tests REGEX] [--times 100] [--through "nice -n 15"] [--again] [--built]

Each constant that has no test is made so many times as large, then as small, until a test fails: SCRATCH/found.csv has it, and what
fell through. --tests: of these tests; --again: also constants that have a test, or are in found.csv; --built: with the copy that an
earlier call has built."""

import argparse
import csv
import os
import re
import shlex
import shutil
import subprocess
import sys
from pathlib import Path

import heuristics
from test_costs import tests_of

# quick ones that between them go through steps, snaps, contact, space, strands, sensing and what is told
TESTS = "^(" + "|".join((
    "stepping-.*-on-1", "rod-.*-on-1", "rod-ask.*", "tasks-grow.*", "tasks-crawl.*", "straight-straight-.*-on-1",
    "friction-a-hairpin.*", "friction-sensitivities.*", "friction-errors.*", "friction-what-.*", "friction-exact.*", "friction-rods-.*",
    "friction-amplitudes.*", "contact-.*(snaps|jammed|corners|tension|restart-to|cage|pressed|brushes).*", "starts-.*",
    "space-errors-in-space-are-measured", "space-rods-.*", "space-heavy.*", "space-contact-.*(turns-over|gets-firmer-where|sinks-onto-a-cylinder-and).*",
    "ropes-.*", "laboratory-a-run-(goes|that).*", "steered-.*", "forces-a-.*", "tropism-.*")) + ")$"

SET = """#include <stdio.h>
#include <stdlib.h>
#include <string.h>
static void __attribute__((constructor)) Set{name}(void)
{{
  const char *said = getenv("TENDRIL_RULE");
  if (!said) return;
#define RULE(type, name, value, text, measured, test) \\
  if (!strncmp(said, "{name}." #name "=", strlen("{name}." #name "="))) {name}.name = (type)atof(strchr(said, '=') + 1);
#include "{register}"
#undef RULE
}}
"""


def prepare(scratch, through):
    """The copy, built."""
    copy = scratch / "src"
    scratch.mkdir(parents=True, exist_ok=True)
    shutil.rmtree(copy, ignore_errors=True)
    shutil.copytree(heuristics.ROOT, copy, symlinks=True, ignore=shutil.ignore_patterns(".git", "build*", "runs"))
    for register in heuristics.REGISTERS:
        for header in (copy / "src" / register).parent.glob("*rules.h"):
            text = header.read_text()
            name = re.search(r"static const \w+ (\w+) = ", text)[1]
            text = text.replace("static const ", "static ", 1)
            at = text.rindex("#endif")
            header.write_text(text[:at] + SET.format(name=name, register=register) + text[at:])
    build = scratch / "build"
    subprocess.run([*through, "cmake", "-S", copy, "-B", build, f"-DPython3_EXECUTABLE={sys.executable}",
                    *(["-DCMAKE_C_COMPILER_LAUNCHER=ccache"] if shutil.which("ccache") else []),
                    "-DCMAKE_INTERPROCEDURAL_OPTIMIZATION=OFF"], check=True, stdout=subprocess.DEVNULL)
    subprocess.run([*through, "cmake", "--build", build, "--parallel", "2"], check=True, stdout=subprocess.DEVNULL)
    return build


def fails(test, setting, through, limit=300):
    """Whether it does, with this constant."""
    name, command, environment, directory = test
    try:
        return subprocess.run([*through, *command], env={**os.environ, **environment, "TENDRIL_RULE": setting}, cwd=directory, timeout=limit,
                              stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL).returncode != 0
    except subprocess.TimeoutExpired:
        return True


def values(constant, times):
    """Far above and far below; what counts, at least 1 and next to it."""
    value = float(eval(constant.value, {"__builtins__": {}}))  # as 4. / 3
    if constant.type == "PetscInt":
        return sorted({str(int(value * times)), str(max(1, int(value / times)))} - {str(int(value))}, key=int, reverse=True)
    return [repr(value * times), repr(value / times)]


def looked_for(constant, register, tests, times, through):
    """(value, test that fails); an empty one for each value that none notices."""
    variable = {"stepping": "step_rule", "rod": "rod_rule", "tasks": "grow_rule"}[register.partition("/")[0]]
    found = []
    for value in values(constant, times):
        seen = next((test for test in tests if fails(test, f"{variable}.{constant.name}={value}", through)), None)
        found.append((value, seen[0] if seen else ""))
        if seen:
            tests.remove(seen)
            tests.insert(0, seen)  # what has seen one may see the next
            break
    return found


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scratch", type=Path)
    parser.add_argument("--only", default="")
    parser.add_argument("--register", default="")
    parser.add_argument("--tests", default=TESTS)
    parser.add_argument("--times", type=float, default=100)
    parser.add_argument("--through", default="", type=shlex.split)
    parser.add_argument("--again", action="store_true")
    parser.add_argument("--built", action="store_true")
    a = parser.parse_args()
    build, kept = a.scratch / "build" if a.built else prepare(a.scratch, a.through), a.scratch / "found.csv"
    known = {row[0] for row in csv.reader(kept.open())} if kept.exists() else set()
    tests = [test for test in tests_of(str(build), a.tests) if "mpiexec" not in str(test[1][0])]
    sound = [test for test in tests if not fails(test, "none=0", a.through)]
    print(f"{len(sound)} of {len(tests)} tests pass as it is", flush=True)
    for register in (r for r in heuristics.REGISTERS if re.search(a.register, r)):
        for constant in heuristics.constants(register):
            if not re.search(a.only, constant.name) or (not a.again and (constant.test or constant.name in known)):
                continue
            found = looked_for(constant, register, sound, a.times, a.through)
            with kept.open("a", newline="") as out:
                csv.writer(out).writerows([constant.name, *row] for row in found)
            print(f"{constant.name:22}", "; ".join(f"{value}: {test or 'nothing fails'}" for value, test in found), flush=True)


if __name__ == "__main__":
    main()

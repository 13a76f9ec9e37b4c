#!/usr/bin/env python3
"""Runs again and again the tests that depend on more than the program: on processes, signals, files, on
several ranks, on how busy the machine is. A test that fails now and then hides a cause.

    .venv/bin/python scripts/lab/repeats.py BUILD ROUNDS [--beside 6] [--only REGEX] [--without REGEX]
                                            [--through "nice -n 5"] [--table FILE]

BUILD is a build directory with tests (scripts/test.sh makes one). --beside starts so many processes that
only compute. What a test that failed has said is kept in BUILD/repeats/TEST.ROUND. Prints, and keeps in
BUILD/repeats/table.csv over all calls, how often each test ran and failed."""
import argparse
import csv
import pathlib
import re
import shlex
import subprocess
import sys

LABELS = "fault|input|script|memory"
NAMES = r"-[23]$|sweep-|restart|signal|ranks|interrupted"
AT_ONCE = 12  # tests that one call of ctest runs


def names(build, *selection):
    listed = subprocess.run(["ctest", "--test-dir", build, "-N", *selection], check=True, text=True,
                            capture_output=True).stdout
    return re.findall(r"Test +#\d+: (\S+)", listed)


def chosen(arguments):
    if arguments.only:
        found = names(arguments.build, "-R", arguments.only)
    else:
        of_labels = set(names(arguments.build, "-L", LABELS))
        found = [name for name in names(arguments.build) if name in of_labels or re.search(NAMES, name)]
    return [name for name in found if not (arguments.without and re.search(arguments.without, name))]


def batch(arguments, tests, number):
    """The tests of these that failed; what they said is kept."""
    one_of = "^(" + "|".join(re.escape(name) for name in tests) + ")$"
    done = subprocess.run([*shlex.split(arguments.through), "ctest", "--test-dir", arguments.build, "-R",
                           one_of, "--output-on-failure"], text=True, capture_output=True)
    passed = set(re.findall(r"Test +#\d+: (\S+) \.+ +Passed", done.stdout))
    skipped = set(re.findall(r"Test +#\d+: (\S+) \.+\**Skipped", done.stdout))
    failed = [name for name in tests if name not in passed | skipped]
    for name in failed:
        (pathlib.Path(arguments.build) / "repeats" / f"{name}.{number}").write_text(done.stdout + done.stderr)
    return [name for name in tests if name not in skipped], failed


def read_table(file):
    if not file.exists():
        return {}
    with open(file, newline="") as rows:
        return {row["test"]: [int(row["runs"]), int(row["failed"])] for row in csv.DictReader(rows)}


def write_table(file, table):
    with open(file, "w", newline="") as rows:
        out = csv.writer(rows)
        out.writerow(["test", "runs", "failed"])
        out.writerows([name, *counts] for name, counts in sorted(table.items()))


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("build")
    parser.add_argument("rounds", type=int)
    parser.add_argument("--beside", type=int, default=0)
    parser.add_argument("--only")
    parser.add_argument("--without")
    parser.add_argument("--through", default="")
    parser.add_argument("--table")
    arguments = parser.parse_args()
    kept = pathlib.Path(arguments.build) / "repeats"
    kept.mkdir(exist_ok=True)
    file = pathlib.Path(arguments.table) if arguments.table else kept / "table.csv"
    table, tests = read_table(file), chosen(arguments)
    busy = [subprocess.Popen([sys.executable, "-c", "while True: pass"]) for _ in range(arguments.beside)]
    try:
        for number in range(1, arguments.rounds + 1):
            for start in range(0, len(tests), AT_ONCE):
                ran, failed = batch(arguments, tests[start:start + AT_ONCE], number)
                for name in ran:
                    counts = table.setdefault(name, [0, 0])
                    counts[0] += 1
                    counts[1] += name in failed
                for name in failed:
                    print(f"round {number}: {name} FAILED", flush=True)
                write_table(file, table)
            print(f"round {number}: {sum(runs for runs, _ in table.values())} runs, "
                  f"{sum(bad for _, bad in table.values())} failed so far", flush=True)
    finally:
        for process in busy:
            process.kill()
    return any(bad for _, bad in table.values())


if __name__ == "__main__":
    sys.exit(main())

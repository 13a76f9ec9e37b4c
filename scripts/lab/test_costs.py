#!/usr/bin/env python3
"""What each test costs in seconds of processor, its own and those of all that it starts: not in seconds of a clock, which
on a shared machine say little.

    test_costs.py build-test [-R REGEX] [--at-once 2] [--output costs.csv]      the slowest last, and the sum

Two files of such rows: test_costs.py --compare before.csv after.csv"""

import argparse
import csv
import json
import os
import subprocess
import sys
import time
from concurrent.futures import ThreadPoolExecutor


def tests_of(build, pattern):
    """(name, command, environment, directory) of the tests that ctest has."""
    listed = json.loads(subprocess.run(["ctest", "--test-dir", build, "--show-only=json-v1", *(["-R", pattern] if pattern else [])],
                                       capture_output=True, text=True, check=True).stdout)
    for test in listed["tests"]:
        properties = {entry["name"]: entry["value"] for entry in test["properties"]}
        environment = dict(entry.split("=", 1) for entry in properties.get("ENVIRONMENT", []))
        yield test["name"], test["command"], environment, properties.get("WORKING_DIRECTORY", build)


def cost(test):
    """A row: what it is called, seconds of processor, of the clock, how it ended."""
    name, command, environment, directory = test
    begin = time.monotonic()
    process = subprocess.Popen(command, env={**os.environ, **environment}, cwd=directory, stdin=subprocess.DEVNULL,
                               stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    _, status, used = os.wait4(process.pid, 0)
    row = {"test": name, "user": round(used.ru_utime, 2), "system": round(used.ru_stime, 2),
           "clock": round(time.monotonic() - begin, 2), "exit": os.waitstatus_to_exitcode(status)}
    print(f"{row['user']:8.2f} {row['system']:6.2f} {row['clock']:8.2f} {row['exit']:4d}  {name}", flush=True)
    return row


def compare(files):
    before, after = ({row["test"]: float(row["user"]) for row in csv.DictReader(open(file))} for file in files)
    for name in sorted(before.keys() | after.keys(), key=lambda name: before.get(name, 0) - after.get(name, 0)):
        print(f"{before.get(name, 0):8.2f} {after.get(name, 0):8.2f}  {name}")
    print(f"{sum(before.values()):8.1f} {sum(after.values()):8.1f}  seconds of {len(before)} and {len(after)} tests")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("build", nargs="?")
    parser.add_argument("-R", dest="pattern", default="")
    parser.add_argument("--at-once", type=int, default=1)
    parser.add_argument("--output", default="")
    parser.add_argument("--compare", nargs=2, default=())
    a = parser.parse_args()
    if a.compare:
        return compare(a.compare)
    with ThreadPoolExecutor(a.at_once) as pool:
        rows = sorted(pool.map(cost, tests_of(a.build, a.pattern)), key=lambda row: row["user"])
    if a.output:
        with open(a.output, "w", newline="") as file:
            table = csv.DictWriter(file, rows[0])
            table.writeheader()
            table.writerows(rows)
    for row in rows[-30:]:
        print(f"{row['user']:8.2f}  {row['test']}")
    print(f"{sum(row['user'] for row in rows):8.1f} seconds of {len(rows)} tests, and {sum(row['system'] for row in rows):.1f} of the system")
    return 0


if __name__ == "__main__":
    sys.exit(main())

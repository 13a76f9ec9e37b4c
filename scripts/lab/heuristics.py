#!/usr/bin/env python3
"""Writes docs/dev/heuristics.md, the constants of the solver, from the registers in the code (rules.def): each with its
value, reason, what it was measured on, and the test that fails where it is another.

    scripts/lab/heuristics.py > docs/dev/heuristics.md"""

import collections
import re
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
REGISTERS = {"stepping/rules.def": "Time steps and Newton's method: `step_rule`", "rod/rules.def": "Models of the rod: `rod_rule`",
             "tasks/grow_rules.def": "A run of -task grow: `grow_rule`"}

Constant = collections.namedtuple("Constant", "section type name value text measured test")


def constants(register):
    """Those of a register of src/, in their order."""
    section, text = "", (ROOT / "src" / register).read_text()
    string = r'((?:\s*"(?:[^"\\]|\\.)*")+)'
    for head, kind, name, value, *strings in re.findall(
            rf'/\* ---- (.*?) ---- \*/|RULE\((\w+), (\w+), ([^,]+),{string},{string},{string}\)', text):
        section = head or section
        if name:
            yield Constant(section, kind, name, value, *("".join(re.findall(r'"((?:[^"\\]|\\.)*)"', s)) for s in strings))


def main():
    print("# Constants of the solver\n\nMade by `scripts/lab/heuristics.py` from the registers in the code. Each constant has one "
          "entry: what it is\nand why, what it was measured on, and a test that fails where it is another (none: those that could "
          "see it pass, or why; blank: not looked for).\n`scripts/lab/rules.py` and `mutations.py` look for such tests.")
    for register, title in REGISTERS.items():
        print(f"\n## {title}\n\n`src/{register}`")
        section = None
        for row in constants(register):
            if row.section != section:
                section = row.section
                print(f"\n### {section}\n\n| constant | value | what it is, and why | measured | test |\n|---|---|---|---|---|")
            print(f"| {row.name} | {row.value} | {row.text.replace('|', '‖')} | {row.measured.replace('|', '‖')} | {row.test} |")


if __name__ == "__main__":
    main()

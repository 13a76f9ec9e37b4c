"""What a study is told: the program, a directory for its files, and which of its steps are made."""

import argparse
from pathlib import Path


def steps_of(text, steps, usual=None):
    """.tendril, .directory, which is there then, and .what of a command line; text: what -h says.

    usual  the steps where none is told; None: all"""
    parser = argparse.ArgumentParser(description=text, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("tendril")
    parser.add_argument("directory", type=Path)
    parser.add_argument("what", nargs="*", choices=[[], *steps], default=[])
    choice = parser.parse_args()
    choice.what = choice.what or usual or steps
    choice.directory.mkdir(parents=True, exist_ok=True)
    return choice

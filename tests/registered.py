#!/usr/bin/env python3
"""Which tests there are: each file says it itself, once, and CMake asks here.

* C with cmocka, ROOM/test_NAME.c: a line `test: WHAT HOLDS | ranks 1 2 3` in its first comment (without ranks: 1). With `| apart` each case
  is a test of its own (on fewer ranks, if the line that lists it says /* ranks 1 2 */).
* Python, checks: each function below @check, @check(ranks=2), @check(ranks=(1, 2, 3)) or @check(parts=3): support/scene.py.
* Python with unittest, or with a main of its own: a line `# test: WHAT HOLDS`; `| with WORDS` are its arguments, as the names of classes.

What a test is called begins with its file's name (of C: the room's before it), then what holds, as a sentence.

    registered.py [--cmake | --check BUILD]      a list; a list for CMake; what is registered by nobody, twice or no longer so"""

import argparse
import ast
import collections
import re
import subprocess
import sys
from pathlib import Path

TESTS = Path(__file__).resolve().parent
LABELS = {"scenes": "scene", "record": "scene", "tasks": "scene", "input": "input", "faults": "fault", "python": "script",
          "docs": "script", "library": "script", "style": "style"}  # of Python; C is a unit
BY_HAND = {"support", "style", "installed", "reference"}  # folders of what tests use, and what tests/CMakeLists.txt itself names

Test = collections.namedtuple("Test", "name label ranks file words")


class Fault(Exception):
    pass


def dashed(sentence):
    return "-".join(re.findall(r"[a-z0-9]+", sentence.lower()))


def lines_of(text):
    """(what holds, {key: value}) of each line `test: ...` of a file."""
    for line in re.findall(r"(?m)^(?:#| \*|/\*|  )? *test: *(.*?)(?: *\*/)?$", text):
        what, *more = (part.strip() for part in line.split("|"))
        yield what, {key: value for key, _, value in (part.partition(" ") for part in more)}


def numbers(said):
    return [int(n) for n in said.split()]


def of_c(file):
    text = file.read_text()
    stem = f"{file.parent.name}-{file.stem.removeprefix('test_')}"
    for what, more in lines_of(text.partition("*/")[0] + "*/"):
        ranks = numbers(more.get("ranks", "1"))
        if "apart" in more:
            for case, fewer in re.findall(r"cmocka_unit_test\(Test(\w+)\)[,};]*(?: */\* ranks ([\d ]+) \*/)?", text):
                sentence = dashed(re.sub(r"(?<=[a-z])(?=[A-Z])", " ", case))
                yield from (Test(f"{stem}-{sentence}-on-{n}", "unit", n, file, [f"Test{case}"]) for n in (numbers(fewer) or ranks))
        else:
            yield from (Test("-".join(filter(None, (stem, dashed(what), f"on-{n}" if len(ranks) > 1 else ""))), "unit", n, file, [])
                        for n in ranks)


def of_checks(file, tree, label):
    """Functions below @check, with as many tests each as support/scene.py makes."""
    stem = file.stem.removesuffix("_test").replace("_", "-")
    for node in tree.body:
        for mark in getattr(node, "decorator_list", []):
            if getattr(getattr(mark, "func", mark), "id", "") != "check":
                continue
            said = {word.arg: ast.literal_eval(word.value) for word in getattr(mark, "keywords", [])}
            name, ranks = node.name.replace("_", "-"), said.get("ranks", 1)
            if isinstance(ranks, tuple):
                each = [(f"{name}-on-{n}", n) for n in ranks]
            else:
                each = [(f"{name}-part-{k + 1}", ranks) for k in range(said.get("parts", 0))] or [(name, ranks)]
            yield from (Test(f"{stem}-{one}", label, n, file, ["--check", one]) for one, n in each)


def of_python(file):
    text = file.read_text()
    label = LABELS[file.relative_to(TESTS).parts[0]]
    yield from of_checks(file, ast.parse(text), label)
    stem = file.stem.removesuffix("_test").removeprefix("test_").replace("_", "-")
    for what, more in lines_of(text):
        name = "-".join(filter(None, (stem, dashed(what))))
        yield Test(name, label, int(more.get("ranks", 1)), file, more.get("with", "").split())


def files():
    for file in sorted([*TESTS.rglob("*.c"), *TESTS.rglob("*.py")]):
        folder = file.relative_to(TESTS).parts[0]
        if len(file.relative_to(TESTS).parts) > 1 and folder not in BY_HAND and not re.search(r"[/.]__", str(file)):
            yield file


def tests():
    for file in files():
        yield from of_c(file) if file.suffix == ".c" else of_python(file)


def said_twice(names, what):
    return [f"{what}: {name}" for name, count in collections.Counter(names).items() if count > 1]


def cases_of(file, text):
    """Faults within a file: cases that its list leaves out, functions of one name, classes that no line names."""
    where = file.relative_to(TESTS)
    if file.suffix == ".c":
        listed = re.findall(r"cmocka_unit_test\((\w+)", text)
        yield from said_twice(listed, f"{where}: listed twice")
        if listed:
            yield from (f"{where}: not in its list: {name}" for name in re.findall(r"^static void (Test\w+)\(void \*\*", text, re.M)
                        if name not in listed)
        return
    tree = ast.parse(text)
    for scope in [tree, *(node for node in tree.body if isinstance(node, ast.ClassDef))]:
        yield from said_twice([node.name for node in scope.body if isinstance(node, (ast.FunctionDef, ast.ClassDef))],
                              f"{where}: two of one name")
    words = [set(more.get("with", "").split()) for _, more in lines_of(text)]
    if len(words) > 1 and all(words):
        parents = {name.id for node in tree.body if isinstance(node, ast.ClassDef) for name in node.bases if isinstance(name, ast.Name)}
        has = {node.name for node in tree.body if isinstance(node, ast.ClassDef) and node.name not in parents
               and any(getattr(item, "name", "").startswith("test") for item in node.body)}
        yield from (f"{where}: a class that no line names: {name}" for name in sorted(has - set.union(*words)))
        yield from said_twice([name for some in words for name in some], f"{where}: a class in two lines")


def unused():
    """Functions of Python that are no test and that nothing names: a check that has lost its mark, or what is left of one."""
    texts = {file: file.read_text() for file in sorted(TESTS.rglob("*.py"))}
    words = collections.Counter(word for text in texts.values() for word in re.findall(r"\w+", text))
    for file, text in texts.items():
        yield from (f"{file.relative_to(TESTS)}: neither a test nor used: {node.name}" for node in ast.parse(text).body
                    if isinstance(node, ast.FunctionDef) and not node.decorator_list and words[node.name] == 1)


def faults(build):
    found, by_hand = list(tests()), (TESTS / "CMakeLists.txt").read_text()
    yield from said_twice([test.name for test in found], "two tests of one name")
    known = {test.file for test in found}
    for file in files():
        text = file.read_text()
        if file not in known and file.stem not in by_hand:
            yield f"{file.relative_to(TESTS)}: nothing in it is a test (a line `test: what holds`, or @check; what others use is in support/)"
        yield from cases_of(file, text)
    yield from unused()
    listed = subprocess.run(["ctest", "--test-dir", build, "-N"], capture_output=True, text=True, check=True).stdout
    ran = set(re.findall(r"Test +#\d+: (\S+)", listed))
    yield from (f"not among those that ctest runs: {test.name} (build again)" for test in found
                if test.name not in ran and not (test.label == "unit" and "NO_CMOCKA" in listed))
    yield from said_twice(re.findall(r"Test +#\d+: (\S+)", listed), "ctest has it twice")
    yield from no_sentences(ran)


def no_sentences(names):
    """A name is a sentence, or at least says more than its file's name; style and pages keep theirs."""
    return [f"a name that is no sentence: {name}" for name in sorted(names) if name.count("-") < 3
            and name not in ("layers", "format", "docs", "scripts")]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--cmake", action="store_true")
    parser.add_argument("--check", metavar="BUILD")
    a = parser.parse_args()
    if a.check:
        found = list(faults(a.check))
        print("\n".join(found) or f"{len(list(tests()))} tests of {len(list(files()))} files, each registered once")
        return len(found) > 0
    for test in tests():
        if a.cmake:
            print("|".join([test.name, test.label, str(test.ranks), str(test.file.relative_to(TESTS)), " ".join(test.words)]))
        else:
            print(f"{test.label:7} {test.name}")
    return 0


if __name__ == "__main__":
    sys.exit(main())

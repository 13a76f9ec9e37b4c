#!/usr/bin/env python3
# test: the notebook runs and says what it should
"""The notebook of docs runs from top to bottom: in Jupyter where it is installed, else cell by cell in
one namespace; and what its last cells leave is there.

    test_notebook.py build/tendril"""

import importlib.util
import json
import os
import re
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
NOTEBOOK = ROOT / "docs/tendril.ipynb"
LEFT = {"tube.html": 100000, "tube.gif": 10000, "tube.csv": 10000}  # bytes at least


def in_jupyter():
    """Printed text of all cells."""
    import nbclient
    import nbformat

    book = nbformat.read(NOTEBOOK, 4)
    nbclient.NotebookClient(book, timeout=1500, kernel_name="python3").execute()
    outputs = [output for cell in book.cells for output in cell.get("outputs", ())]
    pictures = sum("image/png" in output.get("data", {}) for output in outputs)
    assert pictures == 3, f"{pictures} pictures are shown"
    return "".join(output.get("text", "") for output in outputs)


def cell_by_cell():
    import contextlib
    import io

    import matplotlib

    matplotlib.use("Agg")
    said, names = io.StringIO(), {"__name__": "__main__"}
    for cell in json.loads(NOTEBOOK.read_text())["cells"]:
        if cell["cell_type"] == "code":
            with contextlib.redirect_stdout(said):
                exec(compile("".join(cell["source"]), cell["id"], "exec"), names)
    return said.getvalue()


def main():
    os.environ["TENDRIL"] = str(Path(sys.argv[1]).resolve())
    os.environ["PYTHONPATH"] = str(ROOT / "scripts")  # of the kernel
    sys.path.insert(0, str(ROOT / "scripts"))
    jupyter = all(map(importlib.util.find_spec, ("nbclient", "ipykernel")))
    execute = in_jupyter if jupyter else cell_by_cell
    with tempfile.TemporaryDirectory(prefix="tendril-") as directory:
        os.chdir(directory)
        said = execute()
        for name, size in LEFT.items():
            assert Path(name).stat().st_size > size, name
        os.chdir(ROOT)
    for words in ("6.95 cm, flutter", "did you mean friction_mu", r"si_friction_dry +0\.(49|50)"):
        assert re.search(words, said), f"{words!r} is not said:\n{said}"
    print(f"{NOTEBOOK.name} runs, by {execute.__name__}")


if __name__ == "__main__":
    main()

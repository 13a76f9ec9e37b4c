"""Files of meshes and lines: STL, PLY, VTP and VTK by VTK, whose own words are told where it cannot; OBJ in here, for VTK ends
at the first line that it does not know."""

from __future__ import annotations

import json
import os
import re
import subprocess
import sys
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from .errors import TendrilError, optional


class SurfaceError(TendrilError):
    """What cannot be a surface, in one plain line."""


def vtk_parts(*names):
    """Classes of VTK, or the line that says that it is missing."""
    homes = {"vtkSTLReader": "IOGeometry", "vtkPLYReader": "IOPLY",
             "vtkXMLPolyDataReader": "IOXML", "vtkXMLPolyDataWriter": "IOXML", "vtkPolyDataReader": "IOLegacy",
             "vtkTriangleFilter": "FiltersCore", "vtkCleanPolyData": "FiltersCore",
             "vtkImplicitPolyDataDistance": "FiltersCore", "vtkStaticCellLocator": "CommonDataModel",
             "vtkPolyData": "CommonDataModel", "vtkCellArray": "CommonDataModel",
             "vtkPoints": "CommonCore", "vtkObject": "CommonCore", "vtkOutputWindow": "CommonCore",
             "vtkStringOutputWindow": "CommonCore", "vtkLogger": "CommonCore", "vtkIdTypeArray": "CommonCore", "vtkDoubleArray": "CommonCore",
             "reference": "CommonCore"}
    missing = "surfaces from meshes and VMTK's centre lines need VTK: pip install 'tendril[space]', or pip install vtk"
    return [getattr(optional(f"vtkmodules.vtk{homes[name]}", SurfaceError, missing), name) for name in names]


KINDS = {".stl": "vtkSTLReader", ".ply": "vtkPLYReader", ".vtp": "vtkXMLPolyDataReader", ".vtk": "vtkPolyDataReader"}
BRITTLE = (".ply", ".vtk")  # a damaged one may end the process


def polydata(path, notes=None):
    """What a file holds, as VTK has it; what is left out of it is added to the notes. What VTK calls an error is refused in VTK's
    own words: what it reads nevertheless is a part of what the file holds."""
    path = Path(path)
    kind = path.suffix.lower()
    if kind not in (".obj", *KINDS):
        raise SurfaceError(f"{path}: a mesh is STL, OBJ, PLY, VTP or VTK")
    if not path.is_file():
        raise SurfaceError(f"{path}: {'is a directory' if path.is_dir() else 'no such file'}")
    if not path.stat().st_size:
        raise SurfaceError(f"{path}: is empty")
    if kind == ".obj":
        return read_obj(path, notes)
    data, failed, lines = apart(path) if kind in BRITTLE else read_by(path)
    if failed or data is None or not data.GetNumberOfPoints():
        why = f"VTK says: {lines[0].rstrip('.')}" if lines else "it breaks down on it" if failed else "it finds no point in it"
        raise SurfaceError(f"{path}: holds no mesh that VTK can read; {why}")
    if kind == ".ply":
        counted(path, data)
    if notes is not None:
        notes += [f"VTK says: {line}" for line in dict.fromkeys(lines)]
    return data


def counted(path, data):
    """Refuses a PLY that ends before its faces do, which VTK does not tell."""
    with open(path, "rb") as file:
        head = file.read(10_000).partition(b"end_header")[0]
    said = re.search(rb"^element face (\d+)\s*$", head, re.MULTILINE)
    if said and int(said[1]) > data.GetNumberOfPolys() > 0:
        raise SurfaceError(f"{path}: ends before its faces do: {data.GetNumberOfPolys()} of the {int(said[1])} that its header counts")


def read_by(path):
    """(what VTK makes of a file, whether it failed, what it says)."""
    reader = vtk_parts(KINDS[Path(path).suffix.lower()])[0]()
    reader.SetFileName(str(path))
    failed, lines = heard(reader.Update)
    return reader.GetOutput(), failed, lines


def apart(path):
    """The same by another process: one that breaks down takes nobody with it."""
    vtk_parts(KINDS[path.suffix.lower()])
    package = str(Path(__file__).resolve().parents[1])
    code = "import sys; from tendril.mesh_files import hand_over; hand_over(*sys.argv[1:])"
    with TemporaryDirectory(prefix="tendril-") as scratch:
        kept = Path(scratch) / "read.vtp"
        done = subprocess.run(
            [sys.executable, "-c", code, str(path), str(kept)], stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, check=False,
            env={**os.environ, "PYTHONPATH": os.pathsep.join([package, *filter(None, [os.environ.get("PYTHONPATH")])])})
        try:
            failed, lines = json.loads(done.stdout.splitlines()[-1]) if done.returncode == 0 else (True, [])
        except (IndexError, ValueError):
            failed, lines = True, []
        return (None if failed else read_by(kept)[0]), failed, lines


def hand_over(path, kept):
    """Of a file what VTK reads, written again; and what it says, on stdout."""
    data, failed, lines = read_by(path)
    if not failed:
        writer = vtk_parts("vtkXMLPolyDataWriter")[0]()
        writer.SetFileName(kept)
        writer.SetInputData(data)
        writer.SetDataModeToAppended()
        writer.EncodeAppendedDataOff()
        failed = not writer.Write()
    print(json.dumps([failed, lines]))


def heard(work):
    """Lets VTK work; returns (whether it failed, what it says meanwhile, a line each) and keeps it from saying it itself."""
    window, catcher, loud, logger = vtk_parts("vtkOutputWindow", "vtkStringOutputWindow", "vtkObject", "vtkLogger")
    before, shown, logged = window.GetInstance(), loud.GetGlobalWarningDisplay(), logger.GetCurrentVerbosityCutoff()
    said = catcher()
    window.SetInstance(said)
    loud.GlobalWarningDisplayOn()
    logger.SetStderrVerbosity(logger.VERBOSITY_OFF)
    try:
        work()
    finally:
        window.SetInstance(before)
        loud.SetGlobalWarningDisplay(shown)
        logger.SetStderrVerbosity(logged)
    # ERROR: In vtkOBJReader.cxx, line 219, and below it: vtkOBJReader (0x5581): what there is to say
    text = said.GetOutput()
    text = text.decode("utf-8", "replace") if isinstance(text, bytes) else text
    found = re.findall(r"(ERROR|Warning): In .*\n(?:\S+ \(\w+\): )?((?:.+\n?)*)", text, re.IGNORECASE)
    lines = [printable(words) for _, words in found]
    pipeline = re.compile(r"Algorithm \w+ .* returned failure")  # says that a reader failed, not why
    return any(level.upper() == "ERROR" for level, _ in found), [line for line in lines if not pipeline.match(line)]


def printable(text, most=200):
    """In one line of reasonable length."""
    line = " ".join("".join(c if c.isprintable() and c != "\ufffd" else " " for c in text).split())
    return line if len(line) <= most else f"{line[:most]} ..."


def read_obj(path, notes=None):
    """The vertices and faces of an OBJ, and nothing else of it. Edges that some programs write as faces, of one corner or two,
    are left out."""
    points, faces, less = [], [], []
    for number, line in lines_of(path):
        key, *words = line.partition("#")[0].split() or [""]
        try:
            if key == "v":
                x, y, z = (float(word) for word in words[:3])
                points.append((x, y, z))
            elif key in ("f", "fo"):  # counted from 1, or back from the last vertex
                corners = [int(word.partition("/")[0]) for word in words]
                if 0 in corners or min(corners, default=1) < -len(points):
                    raise ValueError
                if len(corners) > 2:
                    faces.append([c - 1 if c > 0 else len(points) + c for c in corners])
                else:
                    less.append(number)
        except ValueError:
            what = "a vertex is v X Y Z" if key == "v" else "a face is f and the numbers of its corners, counted from 1"
            raise SurfaceError(f"{path}, line {number}: {printable(line, 60)}: {what}") from None
    if not points:
        raise SurfaceError(f"{path}: has no vertex, v X Y Z")
    if less and notes is not None:
        notes.append(f"{count_of(len(less), 'face')} of fewer than three corners left out, the first in line {less[0]}")
    return as_polydata(np.array(points, float), faces)


def lines_of(path):
    """(number, text) of the lines of a file, of which those that end in a backslash go on."""
    begun, first = "", 0
    for number, line in enumerate(path.read_text(encoding="latin-1").splitlines()):
        first = first if begun else number + 1
        begun += line
        if begun.endswith("\\"):
            begun = begun[:-1] + " "
            continue
        yield first, begun
        begun = ""
    yield first, begun


def as_polydata(points, faces):
    """Places [n, 3] and lists of corners for VTK."""
    data, places, cells = (part() for part in vtk_parts("vtkPolyData", "vtkPoints", "vtkCellArray"))
    from vtkmodules.util.numpy_support import numpy_to_vtk, numpy_to_vtkIdTypeArray

    places.SetDataType(numpy_to_vtk(points).GetDataType())
    places.SetData(numpy_to_vtk(points, deep=True))
    offsets = np.cumsum([0] + [len(face) for face in faces])
    corners = np.array([c for face in faces for c in face], np.int64)
    cells.SetData(numpy_to_vtkIdTypeArray(offsets.astype(np.int64), deep=True), numpy_to_vtkIdTypeArray(corners, deep=True))
    data.SetPoints(places)
    data.SetPolys(cells)
    return data


def count_of(n, what):
    return f"{n} {what}{'' if n == 1 else 's'}"

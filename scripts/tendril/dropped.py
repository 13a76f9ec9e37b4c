"""A mesh or centre line that was dropped on the page to begin from: it comes in parts, and becomes a wall of the form, by surface()."""

from __future__ import annotations

import base64
import binascii
import re
from pathlib import Path

import numpy as np

from .errors import TendrilError
from .playing import NUMBER
from .units import METRES

MESHES, LINES = (".stl", ".obj", ".ply", ".vtp", ".vtk"), (".csv", ".dat", ".txt", ".json", ".fcsv")
LARGEST = 40_000_000  # bytes of a file, of all its parts
SIDES = ("inside", "outside")


class Parts:
    """Files on their way from a page, which sends the parts of each behind each other."""

    def __init__(self):
        self.name, self.found = "", bytearray()

    def take(self, command) -> bytes | None:
        """The whole file, if this was its last part."""
        name, part, parts = command.get("name"), command.get("part"), command.get("parts")
        if part == 0:
            self.name, self.found = name, bytearray()
        elif name != self.name:
            raise TendrilError("a part of a file whose beginning has not come")
        try:
            self.found += base64.b64decode(str(command.get("data", "")), validate=True)
        except binascii.Error:
            raise TendrilError("a part of a file that cannot be read") from None
        if len(self.found) > LARGEST:
            self.name, self.found = "", bytearray()
            raise TendrilError(f"a file of more than {LARGEST // 1_000_000} MB is for the command line: scripts/surface.sh")
        if part != int(parts) - 1:
            return None
        whole, self.name, self.found = bytes(self.found), "", bytearray()
        return whole


def made(directory, command, data) -> dict:
    """What becomes of a dropped file: {name, path, line, notes}; name and line as they stand among the walls of the form."""
    from .surfaces import is_mesh, surface, told

    stem, suffix = Path(str(command["name"])).stem, Path(str(command["name"])).suffix.lower()
    if suffix not in (*MESHES, *LINES):
        raise TendrilError(f"{stem}{suffix}"[:60] + f": give a mesh ({', '.join(MESHES)}) or a centre line ({', '.join(LINES)})")
    stem = re.sub(r"[^A-Za-z0-9_-]", "-", stem).strip("-")[:40] or "wall"
    source = Path(directory) / f"{stem}-dropped{suffix}"
    source.write_bytes(data)
    unit, side = str(command.get("unit", "mm")), command.get("side")
    if unit not in METRES:
        raise TendrilError(f"{unit[:20]}: give one of {', '.join(METRES)}")
    if side not in SIDES:
        raise TendrilError("say whether the rod is inside or outside")
    mesh = is_mesh(source)
    path = source.with_name(f"{stem}.h5" if mesh else f"{stem}.csv")
    more = mesh_words(source, command, unit, side) if mesh else {"origin": "start", "direction": "start"}
    diameter = str(command.get("diameter", "")).replace(" ", "")
    surfaced = surface(source, path, side=side, unit=unit, diameter=f"{diameter}m" if NUMBER.fullmatch(diameter) else diameter or None, progress=False,
                       **more)
    line = f"{surfaced.kind} {path.name} {surfaced.side}"
    return {"kind": "made", "name": path.name, "path": path, "line": line, "notes": [note.replace(f"{path.parent}/", "") for note in (told(surfaced), *surfaced.notes)]}


def mesh_words(source, command, unit, side) -> dict:
    """How a mesh is put: with the clamp in its first open end, or its middle where that is asked for."""
    from .meshes import read_mesh
    from .openings import ends_of

    mesh = read_mesh(source)
    ends = ends_of(mesh, 1.0)
    if ends and side == "inside":
        return {"origin": tuple(ends[0].middle), "direction": tuple(ends[0].direction), "open": True}
    words = str(command.get("at", "")).replace(",", " ").split()
    if not words:
        return {"open": bool(ends)}
    try:
        at = np.array([float(word) for word in words])
    except ValueError:
        at = np.zeros(0)
    if at.shape != (3,) or not np.isfinite(at).all():
        raise TendrilError(f"its middle: give three numbers, X Y Z in {unit}")
    middle = (mesh.points.max(axis=0) + mesh.points.min(axis=0)) / 2
    return {"origin": tuple(middle - at), "open": bool(ends)}

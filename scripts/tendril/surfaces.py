"""Makes a surface for -wall_file from a mesh or from a centre line with its radius.

    scripts/surface.sh vessel.stl vessel.h5 --diameter 0.5 --side inside --open
    scripts/surface.sh stone.obj stone.h5 --diameter 2 --unit mm
    scripts/surface.sh centreline.vtp duct.csv
    scripts/surface.sh survey.csv well.csv --radius 0.1
    scripts/surface.sh vessel.stl --ends

A mesh (STL, OBJ, PLY, VTP, VTK) becomes a file of its signed distance on a grid, whose spacing the rod's
diameter says; the smooth surface that the triangles stand for is meant, or, with --facets, they themselves.
A centre line (VMTK's VTP with MaximumInscribedSphereRadius, or .dat; lines of OBJ; curves of 3D Slicer, .json,
.fcsv or .csv; tables of x, y, z, r; well surveys of measured depth, inclination, azimuth and radius) becomes a table of
points. Units that a file names are taken, and converted to that of --unit. The line for -wall_file is printed
last. With --ends the open ends of a mesh are listed, for --origin and --direction, and nothing is made."""

import sys
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass, field
from numbers import Integral
from pathlib import Path

import numpy as np

from .bodies import Wish, write_body
from .centrelines import fair, in_units, is_line, read_line
from .command import Parser, listed
from .errors import path_of, reading, replacing, writable
from .meshes import SurfaceError, count_of, polydata, read_mesh
from .openings import check, ends_of, extended
from .progress import wanted
from .tubes import asked, trimmed
from .units import METRES, length_in, length_unit


@dataclass
class Surface:
    """What was made, and how well."""

    path: Path
    kind: str  # body, tube
    side: str
    error: float  # of the distance where the rod touches, or how far a path was moved; in the file's unit
    spacing: float | None = None  # of the grid
    shape: tuple = ()  # of the grid (x3, x2, x1), or the number of points
    facets: float | None = None  # how far the triangles are from the smooth surface they stand for
    up: np.ndarray = field(default_factory=lambda: np.array([0.0, 0, 1]))  # the source's z where the rod is, for its weight
    notes: list[str] = field(default_factory=list)  # what was made of the file, left out or turned, and what the rod will meet

    @property
    def line(self):
        """The line for -wall_file."""
        return f"{self.kind} {self.path} {self.side}"

    def tell(self, note, tell):
        """Notes it, and tells it as it comes."""
        self.notes.append(note)
        tell(f"{self.path}: {note}")


HAS_ENDS = "; the open ends of a vessel are told by scripts/surface.sh MESH --ends, or tendril.ends(mesh)"


# ---- placing ----


def turn_to_x(direction):
    """The smallest rotation that takes a direction to x1."""
    d = np.asarray(direction, float)
    size = np.linalg.norm(d)
    if d.shape != (3,) or not size > 0:
        raise SurfaceError("direction: give three numbers, not all 0")
    d = d / size
    c = 1 + d[0]
    if c < 1e-12:
        return np.diag([-1.0, -1.0, 1.0])
    v = np.cross(d, [1, 0, 0])
    k = np.array([[0, -v[2], v[1]], [v[2], 0, -v[0]], [-v[1], v[0], 0]])
    return np.eye(3) + k + k @ k / c


def up_in(direction):
    """The source's z in the frame of the result."""
    return np.array([0.0, 0, 1]) if direction is None else turn_to_x(direction)[:, 2]


def placed(x, origin, direction, scale):
    x = np.asarray(x, float)
    if origin is not None:
        x = x - np.asarray(origin, float)
    if direction is not None:
        x = x @ turn_to_x(direction).T
    return scale * x


def number(value, name, least=0.0):
    """A number above 0, or none."""
    if value is None:
        return None
    try:
        found = float(value)
    except (TypeError, ValueError):
        raise SurfaceError(f"{name} {value}: give a number") from None
    if not least < found < np.inf:
        raise SurfaceError(f"{name}: must be above 0")
    return found


def lengths(unit, **values):
    """Lengths above 0, in the unit of the result or with their own; none where none is given."""
    def length(value, name):
        with suppress(TypeError, ValueError):  # also nan, which number refuses
            return number(float(value), name)
        return number(length_in(value, unit, name, SurfaceError), name)

    return [length(value, name) for name, value in values.items()]


def numbers(value, name, count):
    """So many numbers, none, or a word."""
    if value is None or isinstance(value, str):
        return value
    try:
        found = np.asarray(value, float)
    except (TypeError, ValueError):
        found = np.empty(0)
    if found.shape != (count,) or not np.isfinite(found).all():
        raise SurfaceError(f"{name}: give {'three' if count == 3 else 'six'} numbers")
    return found


def box_of(value):
    """(the least place, the largest)."""
    box = numbers(value, "box", 6)
    if isinstance(box, str):
        raise SurfaceError("box: give six numbers")
    if box is None:
        return None
    low, high = box.reshape(2, 3)
    if not (high > low).all():
        raise SurfaceError("box: give the least x, y, z, then the largest")
    return low, high


def of_kind(name, value, kind, wanted):
    """Refuses an argument that is none of its kind, nor None."""
    if value is not None and not isinstance(value, kind):
        raise SurfaceError(f"{name} {str(value)[:40]!r}: give {wanted}")


# ---- bodies ----


def body(source, output, side, origin, direction, scale, unit, open, flip, wish, tell, progress):
    for name, value in (("origin", origin), ("direction", direction)):
        if isinstance(value, str):
            raise SurfaceError(f"{name}: a mesh has no start; give three numbers" + HAS_ENDS)
    if not (wish.diameter or wish.spacing):
        raise SurfaceError("a mesh needs diameter, the rod's (it says how fine the grid must be), or spacing")
    if wish.diameter and wish.spacing and wish.spacing > wish.diameter:
        raise SurfaceError(f"spacing: {wish.spacing:g} is too coarse for a rod of diameter {wish.diameter:g}: give half of that or less")
    mesh = check(read_mesh(source), flip, open)
    for note in mesh.notes:
        tell(f"{mesh.name}: {note}")
    mesh.points = placed(mesh.points, origin, direction, scale)
    if open:
        mesh = extended(mesh)
    turn = np.eye(3) if direction is None else turn_to_x(direction)

    def back(x):
        return x / scale @ turn + (0 if origin is None else origin)

    grid, flat = write_body(mesh, output, wish, unit, back, tell, progress)
    made = Surface(Path(output), "body", side, grid.misfit.error, float(grid.spacing), grid.values.shape[::-1], flat, up_in(direction),
                   mesh.notes)
    if all(axis[0] < 0 < axis[-1] for axis in grid.axes):
        free = float(grid.distance.facets(np.zeros((1, 3)))[0]) * (-1 if side == "inside" else 1)
        if free <= (wish.diameter or 0) / 2:
            where = "outside of it" if side == "inside" else "within it"
            made.tell(f"the clamp, at 0, is {where}, or too near to its surface: give origin{HAS_ENDS}", tell)
    return made


# ---- tubes ----


def tube(source, x, output, side, origin, direction, scale, unit, every, diameter, tell):
    """x: the points [n, 4] of the source, in its frame."""
    start = x[0, :3] if isinstance(origin, str) else origin
    along = x[1, :3] - x[0, :3] if isinstance(direction, str) else direction
    given = placed(x[:, :3], start, along, scale)
    points, moved = fair(np.column_stack([given, scale * x[:, 3]]), every)
    points, (before, behind) = trimmed(points)
    made = Surface(Path(output), "tube", side, moved, None, (len(points),), None, up_in(along))
    if before or behind:
        first, last = (int(np.argmin(np.linalg.norm(given - points[k, :3], axis=1))) for k in (0, -1))
        made.tell(f"{left_out(first, len(given) - 1 - last)} left out: their balls lie within their neighbours', the tube is the "
                  "same without them", tell)
    if before:  # it begins elsewhere
        start = points[0, :3].copy() if isinstance(origin, str) else None
        along = points[1, :3] - points[0, :3] if isinstance(direction, str) else None
        given, points[:, :3] = placed(given, start, along, 1.0), placed(points[:, :3], start, along, 1.0)
        made.up = made.up if along is None else turn_to_x(along) @ made.up
    radius = (diameter or 0) / 2
    path = asked(points, given, x[:, :3], source, side == "inside", radius)
    text = [f"{v:.12g}" for v in points.ravel()]
    rows = [",".join(w + (unit or "") for w in text[k:k + 4]) for k in range(0, len(text), 4)]
    with replacing(output) as part:
        Path(part).write_text("\n".join(["x1,x2,x3,radius", *rows]) + "\n")
    if side == "inside" and not path.holds(np.zeros(3), radius):
        made.tell("the clamp, at 0, is outside of the tube: give origin start and direction start, or a place in it", tell)
    return made


def left_out(before, behind):
    """Words for points at the ends."""
    parts = [f"{count_of(n, 'point')} at its {where}" for n, where in ((before, "start"), (behind, "end")) if n]
    return " and ".join(parts)


def is_mesh(source):
    kind = Path(source).suffix.lower()
    if kind in (".stl", ".obj", ".ply"):
        return kind != ".obj" or not Path(source).is_file() or not is_line(source)
    if kind not in (".vtp", ".vtk"):
        return False
    data = polydata(source)
    return data.GetNumberOfPolys() + data.GetNumberOfStrips() > 0


def surface(source, output, *, diameter=None, spacing=None, side=None, origin=None, direction=None, scale=None,
            unit=None, open=False, flip=False, facets=False, box=None, tolerance=None, line=0, radius=None,
            every=None, progress=None, tell=None):
    """A file for -wall_file from a mesh or a centre line; returns what was made, with its error and its
    `line` for -wall_file.

    source     STL, OBJ, PLY, VTP, VTK: a mesh; VTP, VTK, JSON, CSV, DAT: a centre line
    output     HDF5 (of a mesh), CSV (of a centre line)
    diameter   of the rod, in the unit of the result or with its own, "0.035in": a mesh's grid is as fine as it needs; a tube must be wider
    spacing    of the grid, instead
    side       inside or outside, where the rod is; inside of centre lines unless said
    origin     the place, in the source's frame, that becomes 0, where the clamp is; "start": the first point
    direction  the direction that becomes x1; "start": that of the path at its first point
    scale      what the source's unit is in the result's, if the source does not say so itself
    unit       of the result, like mm; none: that which a centre line says, else numbers without dimension
    open       the mesh has open ends: they are led on
    flip       its triangles run the wrong way round; without it a mesh that is inside out is turned, and a note says so
    facets     the triangles themselves are meant, not the smooth surface that they stand for
    box        x, y, z, then again, of the result: the grid's least and largest places
    tolerance  error of the distance that is wanted, 0.002 of the diameter unless said
    line       which line of a file, from 0
    radius     of a path that says none, in the unit of the result or with its own, "4in"
    every      distance of the knots of a path that is smoothed; a radius where points are closer than a
               quarter of that; else the path goes through its points
    progress   the grid's size and a bar; None: in a terminal and in a notebook
    tell       is called with each line that there is to say on the way: the grid's size, and the result's notes"""
    of_kind("side", side, str, "inside or outside")
    of_kind("unit", unit, str, "the name of one, like mm")
    of_kind("line", line, Integral, "a whole number from 0")
    for name, value in (("open", open), ("flip", flip), ("facets", facets)):
        of_kind(name, value, (Integral, np.bool_), "True or False")
    of_kind("tell", tell, Callable, "a function of a line")
    if side not in (None, "inside", "outside"):
        raise SurfaceError(f"side: {side}: give inside or outside")
    unit = length_unit(unit, "unit", SurfaceError)
    source, output = path_of(source, "source"), path_of(output, "output")
    scale, box = number(scale, "scale"), box_of(box)
    origin, direction = numbers(origin, "origin", 3), numbers(direction, "direction", 3)
    if source.exists() and output.exists() and output.samefile(source):
        raise SurfaceError(f"{output}: is the source itself; name another file for the result")
    writable(output)
    tell = tell or (lambda line: wanted(progress) and print(f"surface: {line}", file=sys.stderr))
    if is_mesh(source):
        for name, value in (("line", line), ("radius", radius), ("every", every)):
            if value:
                raise SurfaceError(f"{name}: is of a centre line, {source} is a mesh")
        diameter, spacing, tolerance = lengths(unit, diameter=diameter, spacing=spacing, tolerance=tolerance)
        wish = Wish(diameter, spacing, box, facets, tolerance)
        return body(source, output, side or "outside", origin, direction, scale or 1.0, unit, open, flip, wish, tell, progress)
    for name, value in (("spacing", spacing), ("open", open), ("flip", flip), ("facets", facets), ("box", box),
                        ("tolerance", tolerance)):
        if value:
            raise SurfaceError(f"{name}: is of a mesh, {source} is a centre line")
    with reading(source, "is no centre line that can be read", SurfaceError):
        path = read_line(source, line, None if radius is None else 1.0, foreign=scale is not None)
    scale, unit = in_units(path, unit, scale, source)
    radius, every, diameter = lengths(unit, radius=radius, every=every, diameter=diameter)
    for note in path.notes:
        tell(note)
    x = path.points
    if radius is not None:
        x[:, 3] = radius / scale  # in the unit of the result, as the diameter is
    made = tube(source, x, output, side or "inside", origin, direction, scale, unit, every, diameter, tell)
    made.notes[:0] = path.notes
    return made


# ---- the command ----


def vector(text):
    return text if text == "start" else listed(text, 3)


def box(text):
    return listed(text, 6)


def arguments_of(words):
    parser = Parser("scripts/surface.sh", __doc__)
    parser.add_argument("source", help="mesh or centre line")
    parser.add_argument("output", nargs="?", help="HDF5 for a mesh, CSV for a centre line")
    parser.add_argument("--ends", action="store_true", help="list the open ends of a mesh, and make nothing")
    parser.add_argument("--diameter", help="of the rod: how fine a mesh's grid must be, how wide a tube; in the unit of the result, "
                        "or with its own, 0.035in")
    parser.add_argument("--spacing", help="of the grid, instead")
    parser.add_argument("--side", choices=("inside", "outside"), help="where the rod is")
    parser.add_argument("--origin", type=vector, metavar="X,Y,Z|start", help="what becomes the clamp's place, 0")
    parser.add_argument("--direction", type=vector, metavar="X,Y,Z|start", help="what becomes x1")
    parser.add_argument("--scale", type=float, help="the source's unit in that of the result")
    parser.add_argument("--unit", help=f"of the result: {', '.join(METRES)}; none: that of the source, if it says one")
    parser.add_argument("--open", action="store_true", help="the mesh's open ends are led on")
    parser.add_argument("--flip", action="store_true", help="its triangles run the wrong way round")
    parser.add_argument("--facets", action="store_true", help="the triangles themselves are meant")
    parser.add_argument("--box", type=box, metavar="X,Y,Z,X,Y,Z", help="the grid's least and largest places")
    parser.add_argument("--tolerance", help="of the distance; 0.002 diameters unless given")
    parser.add_argument("--line", type=int, default=0, help="which line of a file, from 0")
    parser.add_argument("--radius", help="of a path that says none; in the unit of the result, or with its own, 4in")
    parser.add_argument("--every", help="distance of the knots of a path that is smoothed")
    return parser.parse_args(words)


def told(made):
    if made.kind == "tube":
        moved = f", smoothed: moved by {made.error:.2g} at most" if made.error else ""
        return f"{made.path}: {made.shape[0]} points{moved}"
    size = " x ".join(str(n) for n in made.shape)
    flat = "" if made.facets is None else f"; the triangles are up to {made.facets:.2g} from the smooth surface"
    return f"{made.path}: {size} values, {made.spacing:.4g} apart; error of the distance {made.error:.2g}{flat}"


def list_ends(choice):
    """Prints the open ends of a mesh."""
    source, unit, scale = Path(choice["source"]), length_unit(choice["unit"], "unit", SurfaceError), number(choice["scale"], "scale") or 1.0
    more = [name for name, value in choice.items() if name not in ("source", "unit", "scale") and value]
    if more:
        raise SurfaceError(f"ends: lists them and makes nothing: leave {more[0]} away")
    if not is_mesh(source):
        raise SurfaceError(f"ends: {source} is a centre line; it begins at origin start, direction start")
    mesh = read_mesh(source)
    found = ends_of(mesh, scale)
    for note in mesh.notes:
        print(f"surface: {source}: {note}")
    if not found:
        raise SurfaceError(f"{source}: is closed: it has no open end")
    print(f"surface: {source}: {count_of(len(found), 'open end')}; places as the file has them, directions inwards")
    for end in found:
        words = ", ".join(f"{v:.6g}" for v in end.middle), ", ".join(f"{v:.6g}" for v in end.direction)
        print(f"{end.number}: middle ({words[0]}), direction ({words[1]}), width {end.width:.4g}{f' {unit}' if unit else ''}")
        print(f"   {end.options}")


def main(words=None):
    choice = vars(arguments_of(words))
    if choice.pop("ends"):
        list_ends(choice)
        return 0
    if choice["output"] is None:
        raise SurfaceError("give a file for the result, HDF5 of a mesh, CSV of a centre line; or --ends")
    made = surface(choice.pop("source"), choice.pop("output"), **choice, tell=lambda line: print(f"surface: {line}", flush=True))
    print(f"surface: {told(made)}")
    if made.up[2] < 1 - 1e-9:  # it was turned, and what is down with it
        print(f"surface: {made.path}: the source's z is now ({', '.join(f'{v + 0:.6g}' for v in np.round(made.up, 9))}), of which "
              "a weight must know (-rod_weight)")
    print(made.line)
    return 0

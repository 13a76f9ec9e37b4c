"""Makes a surface for -wall_file from a mesh or from a centre line with its radius.

    scripts/surface.sh vessel.stl vessel.h5 --diameter 0.5 --side inside --open
    scripts/surface.sh stone.obj stone.h5 --diameter 2 --unit mm
    scripts/surface.sh centreline.vtp duct.csv
    scripts/surface.sh survey.csv well.csv --radius 0.1

A mesh (STL, OBJ, PLY, VTP, VTK) becomes a file of its signed distance on a grid, whose spacing the rod's
diameter says; the smooth surface that the triangles stand for is meant, or, with --facets, they themselves.
A centre line (VMTK's VTP with MaximumInscribedSphereRadius, or .dat; lines of OBJ; curves of 3D Slicer, .json,
.fcsv or .csv; tables of x, y, z, r; well surveys of measured depth, inclination, azimuth and radius) becomes a table of
points. Units that a file names are taken, and converted to that of --unit. The line for -wall_file is printed
last."""

import sys
from dataclasses import dataclass
from pathlib import Path

import h5py
import numpy as np

from .centrelines import fair, in_units, is_line, read_line
from .command import Parser, numbers
from .errors import TendrilError, complaint
from .meshes import Distance, SurfaceError, check, extended, polydata, read_mesh
from .units import METRES, length_in, length_unit

MOST = 60_000_000  # values of a grid
COARSE = 4  # far from the surface the distance is taken at every fourth place only
SAMPLES = 1500
FINEST = 8  # spacings a diameter
DRAWN = 200_000  # triangles that are kept for pictures


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
    notes: tuple = ()  # what was made of the file, and what was not used

    @property
    def line(self):
        """The line for -wall_file."""
        return f"{self.kind} {self.path} {self.side}"


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


def three(value, name):
    """A place or a direction as it was given: None, "start", or three numbers."""
    if value is None or (isinstance(value, str) and value == "start"):
        return value
    try:
        numbers = np.array(value, float)
    except (TypeError, ValueError):
        numbers = np.empty(0)
    if numbers.shape != (3,) or not np.isfinite(numbers).all():
        raise SurfaceError(f"{name}: give three numbers, or start")
    return numbers


def placed(x, origin, direction, scale):
    x = np.asarray(x, float)
    if origin is not None:
        x = x - np.asarray(origin, float)
    if direction is not None:
        x = x @ turn_to_x(direction).T
    return scale * x


# ---- bodies ----


def axes_of(low, high, spacing):
    n = np.maximum(np.ceil((high - low) / spacing - 1e-9).astype(int) + 1, 4)
    return [low[d] + spacing * np.arange(n[d]) for d in range(3)]


def places_of(axes):
    return np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)


def on_grid(distance, axes, band, measure):
    """[n1, n2, n3] distances; within the band by `measure`, beyond it joined from every COARSE-th place."""
    from scipy.interpolate import RegularGridInterpolator

    spacing = axes[0][1] - axes[0][0]
    rough = [np.append(a[::COARSE], a[-1] + COARSE * spacing) for a in axes]
    values = distance.facets(places_of(rough)).reshape([len(a) for a in rough])
    look = RegularGridInterpolator(rough, values)
    d = np.empty([len(a) for a in axes])
    reach = band + np.sqrt(3) * COARSE * spacing
    for k, x1 in enumerate(axes[0]):
        places = places_of([[x1], axes[1], axes[2]])
        sheet = look(places)
        near = np.abs(sheet) < reach
        if near.any():
            exact = distance.facets(places[near])
            close = np.abs(exact) < band
            if close.any() and measure is not distance.facets:
                exact[close] = measure(places[near][close])
            sheet[near] = exact
        d[k] = sheet.reshape(d.shape[1:])
    return d


def spline_error(axes, d, distance, measure, band, rng):
    """The largest error of the spline through the grid's values, at places near the surface."""
    from scipy.ndimage import map_coordinates, spline_filter

    corners = distance.mesh.corners[:distance.mesh.own]
    area = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
    which = rng.choice(len(area), SAMPLES, p=area / area.sum())
    share = rng.dirichlet([1, 1, 1], SAMPLES)
    x = np.einsum("ij,ijk->ik", share, corners[which])
    away = rng.normal(size=x.shape)
    x += away / np.linalg.norm(away, axis=1)[:, None] * rng.uniform(0, band, SAMPLES)[:, None]
    spacing = axes[0][1] - axes[0][0]
    low, high = (np.array([a[k] for a in axes]) for k in (0, -1))
    x = x[((x > low + 2 * spacing) & (x < high - 2 * spacing)).all(axis=1)]
    if not len(x):
        return np.inf
    at = ((x - low) / spacing).T
    c = spline_filter(d, order=3, mode="mirror")
    return float(np.abs(map_coordinates(c, at, order=3, mode="mirror", prefilter=False) - measure(x)).max())


def body(mesh, output, diameter, spacing, side, box, facets, tolerance, unit, source):
    if not (diameter or spacing):
        raise SurfaceError("a mesh needs diameter, the rod's (it says how fine the grid must be), or spacing")
    for name, value in (("diameter", diameter), ("spacing", spacing)):
        if value is not None and not value > 0:
            raise SurfaceError(f"{name}: must be above 0")
    distance = Distance(mesh)
    measure = distance.facets if facets else distance.smooth
    width = diameter or 4 * spacing
    rng = np.random.default_rng(0)
    wanted = tolerance or 0.002 * width
    h = spacing or width / 2
    while True:
        edge = 3 * h + width
        low, high = mesh.points.min(axis=0) - edge, mesh.points.max(axis=0) + edge
        if box is not None:
            low, high = np.array(box, float).reshape(2, 3)
            if not (high > low).all():
                raise SurfaceError("box: give the least x, y, z, then the largest")
        axes = axes_of(low, high, h)
        count = float(np.prod([len(a) for a in axes], dtype=float))
        if count > MOST:
            raise SurfaceError(f"a grid of spacing {h:.3g} has {count:.2g} values, {MOST:.0e} are the most: give a "
                               "larger spacing or tolerance, or a box about what the rod can reach")
        band = 5 * h + width / 2  # what is farther is felt through the spline by less than 2e-3 of its error
        d = on_grid(distance, axes, band, measure)
        if not d.min() < 0 < d.max():
            raise SurfaceError("box: the mesh's surface is nowhere in it; give a box about what the rod can reach"
                               if box is not None else "the mesh has no inside that a grid can see: give a smaller spacing")
        error = spline_error(axes, d, distance, measure, width / 2, rng)
        if spacing or error <= wanted or h <= 1.01 * width / FINEST:
            break
        h = max(h * np.clip((wanted / error) ** 0.25 * 0.9, 0.5, 0.84), width / FINEST)
    if not spacing and width / 4 < error < np.inf:
        raise SurfaceError(f"even {h:.3g} apart the distance is off by {error:.2g}, more than a quarter of the diameter: the "
                           "mesh runs through itself, or is thinner than the rod; mend it, or give spacing to take it as it is")
    flat = 0.0
    if not facets:
        which, at = distance.nearest(mesh.corners[rng.integers(mesh.own or len(mesh.triangles), size=SAMPLES)].mean(axis=1))
        flat = float(np.abs(distance.bulge(which, at)[0]).max())
    with h5py.File(output, "w") as f:
        f.create_dataset("distance", data=d.transpose(2, 1, 0), chunks=True, compression="gzip", shuffle=True)
        f["origin"], f["spacing"] = [a[0] for a in axes], [h] * 3
        if unit:
            for name in ("distance", "origin", "spacing"):
                f[name].attrs["units"] = unit
        f.attrs.update(source=str(source), error=error, facets=flat, diameter=diameter or 0.0)
        if len(mesh.triangles) <= DRAWN:
            f.create_dataset("mesh/points", data=mesh.points, compression="gzip")
            f.create_dataset("mesh/triangles", data=mesh.triangles.astype(np.int32), compression="gzip")
    return Surface(Path(output), "body", side, error, float(h), d.shape[::-1], None if facets else flat)


# ---- tubes ----


def tube(x, output, side, unit, every):
    points, moved = fair(x, every)
    text = [f"{v:.12g}" for v in points.ravel()]
    rows = [",".join(w + (unit or "") for w in text[k:k + 4]) for k in range(0, len(text), 4)]
    Path(output).write_text("\n".join(["x1,x2,x3,radius", *rows]) + "\n")
    return Surface(Path(output), "tube", side, moved, None, (len(points),))


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
            every=None):
    """A file for -wall_file from a mesh or a centre line; returns what was made, with its error and its
    `line` for -wall_file.

    source     STL, OBJ, PLY, VTP, VTK: a mesh; VTP, VTK, JSON, CSV, DAT: a centre line
    output     HDF5 (of a mesh), CSV (of a centre line)
    diameter   of the rod, in the unit of the result: a mesh's grid is as fine as it needs
    spacing    of the grid, instead
    side       inside or outside, where the rod is; inside of centre lines unless said
    origin     the place, in the source's frame, that becomes 0, where the clamp is; "start": the first point
    direction  the direction that becomes x1; "start": that of the path at its first point
    scale      what the source's unit is in the result's, if the source does not say so itself
    unit       of the result, like mm; none: that which a centre line says, else numbers without dimension
    open       the mesh has open ends: they are led on
    flip       its triangles run the wrong way round
    facets     the triangles themselves are meant, not the smooth surface that they stand for
    box        x, y, z, then again, of the result: the grid's least and largest places
    tolerance  error of the distance that is wanted, 0.002 of the diameter unless said
    line       which line of a file, from 0
    radius     of a path that says none, in the unit of the result or with its own, "4in"
    every      distance of the knots of a path that is smoothed; a radius where points are closer than a
               quarter of that; else the path goes through its points"""
    if side not in (None, "inside", "outside"):
        raise SurfaceError(f"side: {side}: give inside or outside")
    if scale is not None and not 0 < scale < np.inf:
        raise SurfaceError("scale: must be above 0")
    unit = length_unit(unit, "unit", SurfaceError)
    origin, direction = three(origin, "origin"), three(direction, "direction")
    if Path(output).exists() and Path(source).exists() and Path(output).samefile(source):
        raise SurfaceError(f"{output}: is the source; give the result another name")
    if is_mesh(source):
        for name, value in (("line", line), ("radius", radius), ("every", every)):
            if value:
                raise SurfaceError(f"{name}: is of a centre line, {source} is a mesh")
        for name, value in (("origin", origin), ("direction", direction)):
            if isinstance(value, str):
                raise SurfaceError(f"{name}: a mesh has no start; give three numbers")
        mesh = read_mesh(source)
        mesh.points = placed(mesh.points, origin, direction, scale or 1.0)
        if open:
            if flip:
                mesh.triangles = mesh.triangles[:, ::-1]
            mesh = extended(mesh)
        mesh = check(mesh, flip and not open)
        return body(mesh, output, diameter, spacing, side or "outside", box, facets, tolerance, unit, source)
    for name, value in (("spacing", spacing), ("open", open), ("flip", flip), ("facets", facets), ("box", box),
                        ("tolerance", tolerance)):
        if value:
            raise SurfaceError(f"{name}: is of a mesh, {source} is a centre line")
    path = read_line(source, line, None if radius is None else 1.0, foreign=scale is not None)
    scale, unit = in_units(path, unit, scale, source)
    radius, every = (length_in(value, unit, name, SurfaceError) for name, value in (("radius", radius), ("every", every)))
    for name, value in (("radius", radius), ("every", every)):
        if value is not None and not 0 < value < np.inf:
            raise SurfaceError(f"{name}: must be above 0")
    x = path.points
    if radius is not None:
        x[:, 3] = radius / scale  # in the unit of the result, as the diameter is
    start = x[0, :3] if isinstance(origin, str) else origin
    along = x[1, :3] - x[0, :3] if isinstance(direction, str) else direction
    x = np.column_stack([placed(x[:, :3], start, along, scale), scale * x[:, 3]])
    made = tube(x, output, side or "inside", unit, every)
    made.notes = tuple(path.notes)
    return made


# ---- the command ----


def vector(text):
    return text if text == "start" else numbers(text, 3)


def box(text):
    return numbers(text, 6)


def arguments_of(words):
    parser = Parser("scripts/surface.sh", __doc__)
    parser.add_argument("source", help="mesh or centre line")
    parser.add_argument("output", help="HDF5 for a mesh, CSV for a centre line")
    parser.add_argument("--diameter", type=float, help="of the rod: how fine a mesh's grid must be")
    parser.add_argument("--spacing", type=float, help="of the grid, instead")
    parser.add_argument("--side", choices=("inside", "outside"), help="where the rod is")
    parser.add_argument("--origin", type=vector, metavar="X,Y,Z|start", help="what becomes the clamp's place, 0")
    parser.add_argument("--direction", type=vector, metavar="X,Y,Z|start", help="what becomes x1")
    parser.add_argument("--scale", type=float, help="the source's unit in that of the result")
    parser.add_argument("--unit", help=f"of the result: {', '.join(METRES)}; none: that of the source, if it says one")
    parser.add_argument("--open", action="store_true", help="the mesh's open ends are led on")
    parser.add_argument("--flip", action="store_true", help="its triangles run the wrong way round")
    parser.add_argument("--facets", action="store_true", help="the triangles themselves are meant")
    parser.add_argument("--box", type=box, metavar="X,Y,Z,X,Y,Z", help="the grid's least and largest places")
    parser.add_argument("--tolerance", type=float, help="of the distance; 0.002 diameters unless given")
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


def main(words=None):
    choice = vars(arguments_of(words))
    try:
        made = surface(choice.pop("source"), choice.pop("output"), **choice)
    except (TendrilError, OSError) as error:
        print(complaint(error, "surface"), file=sys.stderr)
        return 1
    for note in made.notes:
        print(f"surface: {note}")
    print(f"surface: {told(made)}")
    print(made.line)
    return 0

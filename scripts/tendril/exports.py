"""Takes a rod elsewhere: to VTK's PolyData (.vtp, for PyVista and ParaView), or as the tube that it is to a mesh
(.glb, .gltf, .obj, .ply, .stl, for Blender and others).

    scripts/export.sh helix.h5 --output rod.vtp                # the centre line with all that is known along it
    scripts/export.sh helix.h5 --output rod.glb --time 5 --field twist
    scripts/export.sh helix.h5 --output walls.vtp --walls      # the surfaces around it, to be shown beside it

VTK is asked for the first (pip install vtk), trimesh for the others (pip install trimesh); both come with
tendril[space]."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from matplotlib.cm import ScalarMappable
from matplotlib.colors import AsinhNorm

from .command import Parser
from .errors import ResultsError, arguments, optional, path_of, whole
from .loading import load
from .naming import unknown
from .results import Results
from .solids import solids
from .spatial import FIELDS, VISIBLE, diameter_of, extent_of, fields_of, lift, tube
from .surroundings import contact_force
from .units import in_laboratory, moment

MESHES = (".glb", ".gltf", ".obj", ".ply", ".stl")
VECTORS = {"force": "N l", "moment": "N l^2", "d1": "1", "d2": "1", "d3": "1"}


def needed(module, of):
    library = module.partition(".")[0].replace("vtkmodules", "vtk")
    return optional(module, ResultsError, f"{of}: needs {library}, which is not installed: pip install \"tendril[space]\"")


def shape_at(r: Results, t):
    """The shape at a time, dimensionless or with a unit; None: the last."""
    if not len(r.shapes.get("t", ())):
        raise ResultsError(f"{r.told}: holds no shape")
    return r.stored(-1) if t is None else r.at(moment("t", t, [r]))


def factor_of(r, unit, si):
    return in_laboratory(unit, r.scale)[0] if si else 1.0


def data_of(r: Results, shape, si):
    """({name: [n] or [n, 3]}, x [n, 3]) along a shape with three coordinates."""
    solid = lift(r, shape)
    data = {"s": shape.s} | {name: factor_of(r, FIELDS[name][1], si) * values
                             for name, values in fields_of(r, shape).items() if name != "contact"}
    data |= {name: factor_of(r, unit, si) * getattr(solid, name) for name, unit in VECTORS.items()
             if getattr(solid, name) is not None}
    if "contact" in r.shapes:
        data["contact"] = factor_of(r, "N", si) * contact_force(r, solid)
    return data, factor_of(r, "l", si) * solid.x


def walls_at(r: Results, shape, si):
    """(vertices [m, 3], triangles [k, 3], [k] which surface each is of): what stands around the rod, where it is then."""
    found = [one.at(shape.t) for one in solids(r)]
    if not found:
        raise ResultsError(f"{r.told}: has no walls that can be drawn")
    first = np.cumsum([0, *(len(one.vertices) for one in found)])
    return (factor_of(r, "l", si) * np.concatenate([one.vertices for one in found]),
            np.concatenate([n + one.triangles for n, one in zip(first, found)]),
            np.repeat(np.arange(len(found)), [len(one.triangles) for one in found]))


@arguments(ResultsError, path="file?", t="time?", si="flag", walls="flag")
def to_vtk(r: Results, path: str | Path | None = None, t: float | str | None = None, si: bool = False, walls: bool = False):
    """The centre line at a time as PolyData, a polyline whose points carry the label s, the scalars of
    spatial.FIELDS and the vectors force, moment, d1, d2, d3 (contact where there is any); field data say the
    time and the diameter. PyVista's PolyData where it is installed, else VTK's. Results.to_vtk() calls it.

    path   also written there, .vtp
    t      None: the last shape
    si     in SI units, of a run in the laboratory
    walls  the surfaces around it in its place: triangles, each with the number of its surface"""
    core = needed("vtkmodules.vtkCommonCore", "to_vtk")
    model = needed("vtkmodules.vtkCommonDataModel", "to_vtk")
    arrays = needed("vtkmodules.util.numpy_support", "to_vtk")
    shape = shape_at(r, t)
    points, cells, body = core.vtkPoints(), model.vtkCellArray(), model.vtkPolyData()
    if walls:
        x, polygons, surface = walls_at(r, shape, si)
        tables = [(body.GetCellData(), {"surface": surface})]
        body.SetPolys(cells)
    else:
        data, x = data_of(r, shape, si)
        polygons, tables = [range(len(x))], [(body.GetPointData(), data)]
        body.SetLines(cells)
    points.SetData(arrays.numpy_to_vtk(np.ascontiguousarray(x), deep=True))
    body.SetPoints(points)
    for polygon in polygons:
        cells.InsertNextCell(len(polygon))
        for i in polygon:
            cells.InsertCellPoint(i)
    told = {"TimeValue": factor_of(r, "l/V", si) * shape.t, "diameter": factor_of(r, "l", si) * diameter_of(r)}
    for where, table in [*tables, (body.GetFieldData(), told)]:
        for name, values in table.items():
            array = arrays.numpy_to_vtk(np.ascontiguousarray(np.atleast_1d(values), float), deep=True)
            array.SetName(name)
            where.AddArray(array)
    if path is not None:
        write_vtp(body, path_of(path, "to_vtk"))
    try:
        import pyvista
    except ImportError:
        return body
    return pyvista.wrap(body)


def write_vtp(body, path):
    if path.suffix != ".vtp":
        raise ResultsError(f"{path}: give a name that ends in .vtp")
    writer = needed("vtkmodules.vtkIOXML", "to_vtk").vtkXMLPolyDataWriter()
    writer.SetFileName(str(path))
    writer.SetInputData(body)
    if not path.parent.is_dir() or not writer.Write() or not path.is_file():
        raise ResultsError(f"{path}: cannot be written")


@arguments(ResultsError, path="file?", t="time?", field="text", diameter="above 0?", sides="whole", si="flag", walls="flag")
def to_mesh(r: Results, path: str | Path | None = None, t: float | str | None = None, *, field: str = "axial",
            diameter: float | None = None, sides: int = 24, si: bool = False, walls: bool = False):
    """The rod at a time as the closed tube that it is, a trimesh.Trimesh with the colours of a field.
    Results.to_mesh() calls it.

    path      also written there, .glb, .gltf, .obj, .ply or .stl
    t         None: the last shape
    field     what the colours show, a name of spatial.FIELDS; they have one scale for the whole run
    diameter  dimensionless; None: the rod's, or a visible one if it has none
    sides     of the tube
    si        in metres
    walls     the surfaces around it in its place, without colours"""
    trimesh = needed("trimesh", "to_mesh")
    shape = shape_at(r, t)
    whole(sides, "to_mesh: sides", 3, 1000)
    if walls:
        vertices, triangles, _ = walls_at(r, shape, si)
        body = trimesh.Trimesh(vertices, triangles, process=False)
    else:
        body = coloured(trimesh, r, shape, field, diameter, sides, si)
    if path is not None:
        path = Path(path)
        if path.suffix not in MESHES:
            raise ResultsError(f"{path}: give a name that ends in {', '.join(MESHES)}")
        if path.suffix == ".gltf":  # one file, with its arrays in it
            body.export(str(path), merge_buffers=True, embed_buffers=True)
        else:
            body.export(str(path))
    return body


def coloured(trimesh, r, shape, field, diameter, sides, si):
    """The rod as a tube with the colours of a field."""
    solid = lift(r, shape)
    fields = fields_of(r, shape)
    if field not in fields:
        raise ResultsError(f"{r.told}: field {field}{unknown(field, fields, ': give one of')}")
    width = diameter or diameter_of(r) or VISIBLE * extent_of(r)
    vertices, triangles, node = tube(solid.x, width / 2, sides, solid.d2[0])
    most = max(np.abs(fields_of(r, r.stored(k))[field]).max() for k in range(len(r.shapes.t))) or 1.0
    signed = FIELDS[field][2]
    colours = ScalarMappable(AsinhNorm(most / 20, -most if signed else 0, most), "coolwarm_r" if signed else "viridis")
    return trimesh.Trimesh(factor_of(r, "l", si) * vertices, triangles, process=False,
                           vertex_colors=(255 * colours.to_rgba(fields[field][node])).round().astype(np.uint8))


def main(arguments=None):
    parser = Parser("scripts/export.sh", __doc__)
    parser.add_argument("file", help="result file, HDF5")
    parser.add_argument("--output", help="ends in .vtp or one of " + " ".join(MESHES) + "; default: the file's name with .vtp")
    parser.add_argument("--time", metavar="T", help="of a run with -si_ options also 20s; default: the last shape")
    parser.add_argument("--field", default="axial", help="of a mesh, what its colours show: " + ", ".join(FIELDS))
    parser.add_argument("--diameter", type=float, help="of a mesh; default: the rod's, or a visible one")
    parser.add_argument("--walls", action="store_true", help="the surfaces around the rod in its place")
    parser.add_argument("--si", action="store_true", help="in SI units, of runs with -si_ options")
    choice = parser.parse_args(arguments)
    output = Path(choice.output or Path(choice.file).with_suffix(".vtp"))
    r = load(choice.file)
    if output.suffix in MESHES:
        to_mesh(r, output, choice.time, field=choice.field, diameter=choice.diameter, si=choice.si,
                walls=choice.walls)
    else:
        to_vtk(r, output, choice.time, si=choice.si, walls=choice.walls)
    print(f"export: {output}")
    return 0

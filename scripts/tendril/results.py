"""What a run left, all of it in memory (tendril.loading reads it).

    from tendril import load
    r = load("results/uniform-dry.h5")
    r.series.t, r.series.norm_x2        one value per accepted step; names as in the file
    shape = r.at(20)                    the shape at t = 20, stored or between two stored ones
    shape.x[:, 0], shape.x[:, 1]        its nodes; also .s .theta .curvature .force .length .t
    r.minimum("norm_x2")                (t, value) of the smallest
    r.options["friction_mu"]            what was given, as text
    r.dataset(si=True)                  an xarray Dataset, here in SI units
    r.to_csv("series.csv", si=True)     the series as a table; r.frame() for pandas

All is dimensionless, as in the file, but where si=True is said. Files of runs that are still going
or were killed are read as far as they were written; r.finished tells.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from importlib import import_module
from numbers import Real
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple, NoReturn

import numpy as np

from .errors import ResultsError, arguments, briefly_shown, path_of, replacing
from .naming import unknown
from .units import in_laboratory, moment, scales_of_rod

if TYPE_CHECKING:
    import pandas
    import xarray

SHAPES = ("x", "theta", "curvature", "force")
IN_SPACE = ("strain", "moment", "d1", "d2", "d3")  # what a shape in space has beside these
FAR = 0.01  # of the length: a shape between stored ones this far from where the series have it is none
AXES = {2: ("shape_t", "s"), 3: ("shape_t", "s", "axis")}  # of the arrays of /shapes, by rank
# by what error a series is uncertain, and over which size that is told; None: its own
UNCERTAIN = {"energy": ("error_energy", None), "norm_x2": ("error_norm_x2", None), "norm_x2_length": ("error_norm_x2", None),
             "norm_x3": ("error_norm_x2", None), "end_distance": ("error_tip", None), "tip_x1": ("error_tip", "end_distance"),
             "tip_x2": ("error_tip", "end_distance"), "tip_x3": ("error_tip", "end_distance")}
BODILY = ("strain", "natural_strain")  # their components are about the directors, not along the axes


class Sensitivity(NamedTuple):
    """Derivatives of a run by the number of an option, at fixed t and s, per unit of the option."""

    number: float  # at which they are
    unit: str  # of it, as it was given; empty: none
    series: Table  # as those of the run, but for counts and the like
    shapes: Table

class Told(NamedTuple):
    """How far a run may be off, relative: what it tells itself."""

    end: float  # in its last state
    most: float  # at most, over the run at the same time
    when: float  # when that was
    why: str  # a touch, it lets go, a snap; else space, time, friction, contact


EARLY = 0.01  # of a run: what a start does to its errors is over by then
# what shapes hold along the rod
ALONG = ("x", "theta", "curvature", "force", "strain", "moment", "d1", "d2", "d3", "contact", "stretch", "natural_curvature", "natural_strain")
NUMBERS = ("theta", "curvature", "natural_curvature", "stretch")  # of these, a number a node; the others are vectors
# what draws and exports a run knows this module: methods that do so find theirs when they are called
ABOVE = {"view": "page", "to_vtk": "exports", "to_mesh": "exports"}
SCALES = "length", "time", "speed", "force", "energy", "power", "curvature"


def above(name):
    """A function of ABOVE."""
    return getattr(import_module(f".{ABOVE[name]}", __package__), name)


class NoSuchName(ResultsError, KeyError, AttributeError):
    """A table has no array of that name."""

    __str__ = Exception.__str__


class Table(dict):
    """Arrays by name: table["t"] and table.t are the same."""

    of = ""  # the file and group that it is of, for messages

    def __missing__(self, name):
        raise NoSuchName((f"{self.of}: " if self.of else "") + f"no {name} here{unknown(name, self)}")

    def __getattr__(self, name):
        if name.startswith("__"):  # copy and pickle ask
            raise AttributeError(name)
        return self[name]

    def __repr__(self):
        """Names and shapes: of a run the numbers are some thousand lines."""
        return f"<{', '.join(f'{name} {list(np.shape(values))}' for name, values in self.items())}>"

    def __dir__(self):
        return [*super().__dir__(), *self]  # for completion


@dataclass(repr=False)
class Shape:
    """The rod at one time."""

    index: int  # of the stored shape, or of the nearest
    t: float
    length: float
    s: np.ndarray  # [n], material labels, 0 to 1
    x: np.ndarray  # [n, 2], in space [n, 3]
    theta: np.ndarray  # [n]
    curvature: np.ndarray  # [n]
    force: np.ndarray  # [n, 2], in space [n, 3], the internal force
    stored: bool = True  # it is as the run stored it, not between two that it stored
    strain: np.ndarray | None = None  # [n, 3], twist and bends about the directors; of a rod in space, as all below
    moment: np.ndarray | None = None  # [n, 3], the internal moment
    d1: np.ndarray | None = None  # [n, 3], the tangent
    d2: np.ndarray | None = None  # [n, 3], d2 and d3 lie in the cross-section
    d3: np.ndarray | None = None

    def __repr__(self):
        return f"<the rod at t = {self.t:g}, length {self.length:g}, {len(self.s)} nodes>"


@dataclass(repr=False, eq=False)
class Results:
    """A result file, all of it in memory: the file may be gone."""

    path: Path
    finished: bool
    options: dict  # without the leading dash; what was given, as text
    attributes: dict  # version, petsc_version, ranks, si_length, parameters/NAME, ...
    series: Table
    shapes: Table  # t [k], s [n], x [k,n,2], theta [k,n], curvature [k,n], force [k,n,2]
    stability: Table = field(default_factory=Table)  # empty if the file holds none
    critical: Table = field(default_factory=Table)
    groups: dict = field(default_factory=dict)  # every other group of the file: event, ...
    notes: dict = field(default_factory=dict)  # "series/t" -> what it is
    units: dict = field(default_factory=dict)  # "series/t" -> its unit, "l/V"

    def _repr_html_(self):
        """In a notebook the page of view(); of a run without shapes its line alone."""
        from html import escape

        if not (len(self.series.get("t", ())) and len(self.shapes.get("t", ()))):
            return f"<code>{escape(repr(self))}</code>"
        return above("view")(self)._repr_html_()

    def __repr__(self):
        held = [f"{len(self.series.t)} steps to t = {self.series.t[-1]:g}" if self.series else "",
                f"{len(self.shapes.t)} shapes" if self.shapes else "",
                "a critical length" if self.critical else "",
                "a table of stability" if self.stability else ""]
        return f"<{self.name}: {', '.join(filter(None, held))}>"

    @property
    def name(self):
        return self.path.stem

    @property
    def told(self):
        """What a message calls it: the file, or where that is gone its name."""
        return self.path if self.path.exists() else self.name

    @property
    def diameter(self) -> float:
        """The rod's, 0 if it has none."""
        return float(self.attributes.get("parameters/contact_diameter", 0) or 0)

    @arguments(ResultsError, nearest="flag")
    def at(self, t: float | str, nearest=False) -> Shape:
        """The shape at time t. Where none is stored it is the cubic through the four stored around t;
        where that is not where the series have the rod, too few are stored, and it is refused.

        t        as the file counts it; of a run in the laboratory also "20s" or "2min"
        nearest  the stored shape nearest to t, however far that is"""
        if isinstance(t, str):
            t = moment("at", t, [self])
        elif not isinstance(t, Real) or not math.isfinite(t):
            raise ResultsError(f"at {briefly_shown(t)}: give one time, a number or text with a unit")
        times = self.shapes.get("t", ())
        if not len(times):
            raise ResultsError(f"{self.told}: holds no shape")
        end = max(times[-1], self.series.t[-1] if len(self.series.get("t", ())) else 0)
        room = 1e-9 * max(abs(end), 1e-30)
        if not nearest and not times[0] - room <= t <= end + room:
            raise ResultsError(f"{self.told}: runs from t = {times[0]:g} to {end:g}; there is no shape at "
                               f"{t:g}")
        k = int(np.argmin(np.abs(times - t)))
        if nearest or abs(times[k] - t) <= room:
            return self.stored(k)
        shape = self.between(t)
        if shape is None or self.astray(shape) > FAR:
            raise ResultsError(
                f"{self.told}: too few shapes are stored around t = {t:g} to tell the one there; at("
                f"{t:g}, nearest=True) is that of t = {times[k]:g}, a run with a shorter output_interval "
                "has more")
        return shape

    def stored(self, k) -> Shape:
        """The stored shape number k."""
        k, t = range(len(self.shapes.t))[k], float(self.shapes.t[k])
        return Shape(k, t, self.value("length", t), self.shapes.s,
                     *(self.shapes[name][k] for name in SHAPES),
                     **{name: self.shapes[name][k] for name in IN_SPACE if name in self.shapes})

    def between(self, t) -> Shape | None:
        """The cubic in time through the four stored shapes around t (fewer if there are fewer); None if
        there are not two."""
        times = self.shapes.t
        if len(times) < 2:
            return None
        first = int(np.clip(np.searchsorted(times, t) - 2, 0, max(len(times) - 4, 0)))
        rows = slice(first, first + 4)
        weights = lagrange(times[rows], t)
        values = {name: np.tensordot(weights, self.shapes[name][rows], 1)
                  for name in (*SHAPES, *IN_SPACE) if name in self.shapes}
        if "d1" in values:
            values |= zip(("d1", "d2", "d3"), orthonormal(values["d1"], values["d2"]))
        return Shape(int(np.argmin(np.abs(times - t))), float(t), self.value("length", t), self.shapes.s,
                     **values, stored=False)

    def astray(self, shape) -> float:
        """How far the tip and the middle of a shape are from where the series have them at its time, in
        lengths of the rod."""
        end = np.array([self.value(f"tip_x{d + 1}", shape.t) for d in range(shape.x.shape[1])
                        if f"tip_x{d + 1}" in self.series])
        middle = np.array([np.interp(0.5, shape.s, x) for x in shape.x.T]) - shape.x[0]
        off = max(float(np.linalg.norm(shape.x[-1, :len(end)] - end)),
                  abs(float(np.linalg.norm(middle)) - self.value("mid_distance", shape.t)))
        return off / shape.length

    def sensitivity(self, name) -> Sensitivity:
        """Derivatives by an option's number, of a run with -sensitivity NAME."""
        name, stored = name.lstrip("-"), self.groups.get("sensitivity", {})
        if f"{name}/shapes/x" not in stored:
            raise ResultsError(f"{self.told}: holds no derivatives by {name}; run it with -sensitivity {name}")
        tables = (Table({key.rsplit("/", 1)[1]: values for key, values in stored.items()
                         if key.startswith(f"{name}/{group}/")}) for group in ("series", "shapes"))
        return Sensitivity(float(stored[f"{name}/number"]), stored[f"{name}/unit"], *tables)

    @property
    def errors(self) -> dict[str, Told]:
        """How far the run may be off in tip, norm_x2 and energy; empty where it has not measured it (a run of another
        model than frame and space). Of one that has not ended, and of a sweep's, by its series, without reasons."""
        of, names = self.attributes, ("tip", "norm_x2", "energy")
        if "error_end_tip" in of:
            return {name: Told(*(float(of[f"error_{which}{name}"]) for which in ("end_", "", "when_")), str(of[f"error_why_{name}"]))
                    for name in names}
        if "error_tip" not in self.series or len(self.series.t) < 2:
            return {}
        found, t = {}, self.series.t
        for name in names:
            errors = self.series[f"error_{name}"]
            most = int(np.argmax(np.where(t > EARLY * t[-1], errors, 0)))
            found[name] = Told(float(errors[-1]), float(errors[most]), float(t[most]), "")
        return found

    @property
    def rigid(self) -> dict[str, float]:
        """Tip and energy in the last state as rigid contact would have them, to first order; empty where nothing touches."""
        names = {name: f"rigid_{name}" for name in ("tip_x1", "tip_x2", "tip_x3", "energy")}
        return {name: float(self.attributes[of]) for name, of in names.items()
                if of in self.attributes and name in self.series}

    @arguments(name="text")
    def band(self, name) -> tuple[np.ndarray, np.ndarray] | None:
        """Between what the true values of a series are at each step, as far as the run tells its errors: of the tip, its
        distance, |x2| and the energy; None of others, and where errors are not measured."""
        error, over = UNCERTAIN.get(name, ("", None))
        if error not in self.series or name not in self.series:
            return None
        values = self.series[name]
        off = np.minimum(self.series[error], 1) * np.abs(self.series[over] if over else values)
        return values - off, values + off

    @arguments(name="text", t="time")
    def value(self, name, t) -> float:
        """A series at time t, between its steps by linear interpolation."""
        return float(np.interp(t, self.series.t, self.series[name]))

    @arguments(name="text")
    def minimum(self, name="norm_x2") -> tuple[float, float]:
        """(t, value) of a series at its minimum: that of the parabola through the logarithms of the
        smallest positive step and its neighbours."""
        t, values = self.series.t, np.where(self.series[name] > 0, self.series[name], np.nan)
        if not np.isfinite(values).any():
            raise ResultsError(f"{self.told}: series {name}: is above 0 nowhere")
        i = int(np.nanargmin(values))
        if not 0 < i < len(t) - 1 or not np.isfinite(values[i - 1:i + 2]).all() or not (np.diff(t[i - 1:i + 2]) > 0).all():
            return float(t[i]), float(values[i])
        a, b, c = np.polyfit(t[i - 1:i + 2] - t[i], np.log(values[i - 1:i + 2]), 2)
        if not a > 0:
            return float(t[i]), float(values[i])
        return float(t[i] - b / (2 * a)), float(np.exp(c - b * b / (4 * a)))

    @arguments(name="text")
    def maximum(self, name="base_force_1") -> tuple[float, float]:
        """(t, value) of a series at the step where it is largest."""
        if not np.isfinite(self.series[name]).any():
            raise ResultsError(f"{self.told}: series {name}: holds no number")
        i = int(np.nanargmax(self.series[name]))
        return float(self.series.t[i]), float(self.series[name][i])

    def __getattr__(self, name) -> NoReturn:
        """A series is looked for here first, by many."""
        for table in ("series", "shapes"):
            if not name.startswith("_") and name in self.__dict__.get(table, ()):
                raise AttributeError(f"no {name} here; it is {table}.{name}")
        raise AttributeError(f"no {name} here; numbers over time are in series, shapes in shapes and at(t)")

    @arguments(kind="text")
    def scale(self, kind) -> float:
        """What 1 of it (length, time, speed, force, energy, power, curvature) is in SI units."""
        known = scales_of_rod(self.attributes).get(kind)
        if self.attributes.get(f"si_{kind}", known) is None:
            if kind not in SCALES:
                raise ResultsError(f"scale {kind}: unknown{unknown(kind, SCALES, ', give one of')}")
            needed = "si_speed" if kind in ("time", "speed", "power") else "si_bending_stiffness"
            raise ResultsError(f"{self.told}: does not know its {kind} in SI units; run it with "
                               f"{needed} and the like")
        return float(self.attributes.get(f"si_{kind}", known))

    def column(self, group, name, si):
        """(values, unit) of a dataset, as in the file or in SI units."""
        values, unit = getattr(self, group)[name], self.units.get(f"{group}/{name}", "1")
        if not si:
            return values, unit
        self.scale("length")  # of a run that has nothing to do with a laboratory nothing can be told
        factor, unit = in_laboratory(unit, self.scale)
        return factor * values, unit

    def columns(self, group, si, order=None):
        """{name: (values, unit)} of a group; with si without those whose scale is not known, but for the
        time, which then stays a bare number."""
        found = {}
        for name in order or getattr(self, group):
            try:
                found[name] = self.column(group, name, si)
            except ResultsError:
                self.scale("length")
                if name == "t":
                    found[name] = self.column(group, name, False)
        return found

    @property
    def in_space(self) -> bool:
        """Does the rod have a third dimension?"""
        return "tip_x3" in self.series

    @arguments(si="flag")
    def dataset(self, si=False) -> xarray.Dataset:
        """Series over t [steps] and shapes over shape_t [k], s [n] and axis [x1, x2, in space x3] as an xarray
        Dataset; strains of a rod in space, which are about its directors, over component [u1, u2, u3].
        Units and descriptions are attributes of its variables, options those of the whole.

        si  in SI units, of a run in the laboratory; what has no scale there is left out"""
        import xarray

        def variables(group):
            return {name: (values, {"units": unit, "long_name": self.notes.get(f"{group}/{name}", name)})
                    for name, (values, unit) in self.columns(group, si).items()}

        series, shapes = variables("series"), variables("shapes")
        coords, data = {}, {name: ("t", *of) for name, of in series.items() if name != "t"}
        if series:
            coords["t"] = ("t", *series["t"])
        if shapes:
            coords |= {"shape_t": ("shape_t", *shapes["t"]), "s": ("s", *shapes["s"]),
                       "axis": [f"x{d + 1}" for d in range(self.shapes.x.shape[-1])]}
            data |= {name: (AXES[of[0].ndim], *of) for name, of in shapes.items() if of[0].ndim in AXES}
            bodily = {name: (("shape_t", "s", "component"), *shapes[name]) for name in BODILY if name in shapes}
            if bodily:
                data, coords["component"] = data | bodily, ["u1", "u2", "u3"]
        options = "\n".join(f"-{name} {value}".rstrip() for name, value in self.options.items())
        return xarray.Dataset(data, coords, {"options": options, "finished": int(self.finished),
                                             "version": self.attributes.get("version", "")})

    def to_vtk(self, path=None, t=None, si=False, walls=False):
        """The centre line at a time, the last if none is given, as PolyData for PyVista, with all that is known
        along it; with walls the surfaces around it in its place. With a path written there, too, .vtp. Needs vtk:
        tendril[space]."""
        return above("to_vtk")(self, path, t, si, walls)

    def to_mesh(self, path=None, t=None, **more):
        """The rod at a time as the tube that it is, a trimesh.Trimesh; with a path written there, too, .glb, .gltf,
        .obj, .ply or .stl. Needs trimesh: tendril[space].

        field     what its colours show: axial, curvature, twist, ...
        diameter  None: the rod's, or a visible one if it has none
        sides     of the tube
        si        in metres
        walls     the surfaces around it in its place"""
        return above("to_mesh")(self, path, t, **more)

    @arguments(si="flag")
    def frame(self, si=False) -> pandas.DataFrame:
        """The series as a pandas DataFrame, a row a step, t and length first; with si the names carry
        units: "t (s)"."""
        import pandas

        names = sorted(self.series, key=lambda name: ("t", "length", name).index(name))
        return pandas.DataFrame({f"{name} ({unit})" if si and unit not in ("1", "l/V") else name: values
                                 for name, (values, unit) in self.columns("series", si, names).items()})

    @arguments(path="file", si="flag")
    def to_csv(self, path, si=False) -> None:
        """Writes the series as a table, a row a step."""
        with replacing(path_of(path, "to_csv")) as part:
            self.frame(si).to_csv(part, index=False)


def orthonormal(d1, d2):
    """([n, 3] d1, d2, d3), unit and at right angles, of d1 and d2 that nearly are."""
    d1 = d1 / np.linalg.norm(d1, axis=1, keepdims=True)
    d2 = d2 - np.sum(d1 * d2, axis=1, keepdims=True) * d1
    d2 = d2 / np.linalg.norm(d2, axis=1, keepdims=True)
    return d1, d2, np.cross(d1, d2)


def lagrange(nodes, at):
    """Weights [n] with which values at nodes [n] make the polynomial through them at a place."""
    nodes = np.asarray(nodes, float)
    gaps = nodes[:, None] - nodes
    np.fill_diagonal(gaps, 1)
    there = np.tile(at - nodes, (len(nodes), 1))
    np.fill_diagonal(there, 1)
    return np.prod(there / gaps, axis=1)


def as_text(value):
    if isinstance(value, np.ndarray) and value.size == 1:
        value = value.item()
    return value.decode() if isinstance(value, bytes) else value


def options_of(text):
    """Lines '-a 1', '-b' as {'a': '1', 'b': ''}."""
    pairs = (line[1:].partition(" ") for line in str(text).splitlines() if line)
    return {name: value for name, _, value in pairs}

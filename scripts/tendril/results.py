"""Reads tendril's result files.

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
import time
from dataclasses import dataclass, field
from numbers import Real
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple, NoReturn

import h5py
import numpy as np

from .errors import OF_CONTENT, ResultsError, arguments, briefly_shown, did_you_mean, path_of, replacing
from .units import in_laboratory, moment, quantity, scales_of_rod

if TYPE_CHECKING:
    import pandas
    import xarray

    from .collection import Sweep

SHAPES = ("x", "theta", "curvature", "force")
IN_SPACE = ("strain", "moment", "d1", "d2", "d3")  # what a shape in space has beside these
FAR = 0.01  # of the length: a shape between stored ones this far from where the series have it is none
PRIVATE = ("restart",)  # what is tendril's own business
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
MOST = 1e100  # of any number of a rod
# what shapes hold along the rod
ALONG = ("x", "theta", "curvature", "force", "strain", "moment", "d1", "d2", "d3", "contact", "stretch", "natural_curvature", "natural_strain")
NUMBERS = ("theta", "curvature", "natural_curvature", "stretch")  # of these, a number a node; the others are vectors
OF_ROD = ("finished", "parameters/contact_diameter", "parameters/friction_radius")
SCALES = "length", "time", "speed", "force", "energy", "power", "curvature"


class NoSuchName(ResultsError, KeyError, AttributeError):
    """A table has no array of that name."""

    __str__ = Exception.__str__


class Table(dict):
    """Arrays by name: table["t"] and table.t are the same."""

    of = ""  # the file and group that it is of, for messages

    def __missing__(self, name):
        raise NoSuchName((f"{self.of}: " if self.of else "") + f"no {name} here"
                         + (did_you_mean(name, self) or f"; there are {', '.join(map(str, self)) or 'none'}"))

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
        from .page import view

        return view(self)._repr_html_()

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
        middle = np.array([np.interp(0.5, shape.s, x) for x in shape.x.T])
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
                raise ResultsError(f"scale {kind}: unknown, give one of {', '.join(SCALES)}")
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
        from .exports import to_vtk

        return to_vtk(self, path, t, si, walls)

    def to_mesh(self, path=None, t=None, **more):
        """The rod at a time as the tube that it is, a trimesh.Trimesh; with a path written there, too, .glb, .gltf,
        .obj, .ply or .stl. Needs trimesh: tendril[space].

        field     what its colours show: axial, curvature, twist, ...
        diameter  None: the rod's, or a visible one if it has none
        sides     of the tube
        si        in metres
        walls     the surfaces around it in its place"""
        from .exports import to_mesh

        return to_mesh(self, path, t, **more)

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


def runs_of(given, who) -> list[Results]:
    """The runs that somebody gave to draw: Results, files of them, what critical() found, sweeps, or
    several of these. who: whom it was given to, for the line that refuses."""
    from .collection import Sweep

    if isinstance(given, Results):
        return [given]
    if isinstance(given, (str, Path)):
        return runs_of(load(given), who)
    if isinstance(getattr(given, "results", None), Results):  # a Critical
        return [given.results]
    if isinstance(given, Sweep):
        given = [r for r in given.members.flat if isinstance(r, Results)]
    if not isinstance(given, (list, tuple, np.ndarray)):
        raise ResultsError(f"{who}: give what run() or load() gave, or the name of a result file, not "
                           f"{type(given).__name__}")
    runs = [r for one in given for r in runs_of(one, who)]
    if not runs:
        raise ResultsError(f"{who}: there is no run to show")
    return runs


IN_NO_TITLE = ("output", "output_interval", "output_shapes", "quiet", "options_file", "restart")
TOLD_APART_BY = 2  # options at most, in a title


def titles_of(runs, titles=None) -> list[str]:
    """What runs are called in a picture: the names of their files. Those of one name also say the options in
    which they differ; where these are many, or none, their directories or numbers. titles: given ones."""
    if titles:
        return list(titles)
    if told := told_by_sweep(runs):
        return told
    names = [r.name for r in runs]
    for name in {name for name in names if names.count(name) > 1}:
        alike = [k for k, r in enumerate(runs) if r.name == name]
        for k, title in zip(alike, told_apart(name, [runs[k] for k in alike])):
            names[k] = title
    return names


# options in words, where their names are none
WORDS = {"si_friction_dry": "friction", "si_friction_viscous": "viscous friction", "si_bending_stiffness": "stiffness",
         "si_speed": "speed", "friction_mu": "dry share of friction", "growth_initial_length": "length at first",
         "rod_curvature": "curvature", "contact_diameter": "diameter", "contact_friction": "friction in contact"}


def in_words(option) -> str:
    """An option's name for a reader."""
    return WORDS.get(option, option.removeprefix("si_").replace("_", " "))


def valued(text) -> str:
    """A value with a blank before its unit."""
    found = quantity(text)
    return f"{found[0]:.6g} {found[1]}".rstrip() if found else str(text)


def told_by_sweep(runs):
    """Titles of members of a sweep, whose names are OPTION=VALUE__OPTION=VALUE: "friction 0.2 N/m", of what is not the same
    in all; none if these are no members of one."""
    points = [dict(pair.split("=", 1) for pair in r.name.split("__") if "=" in pair) for r in runs]
    if len(runs) < 2 or not all(points) or any(point.keys() != points[0].keys() for point in points):
        return []
    points = [{name: r.options.get(name, value) for name, value in point.items()} for r, point in zip(runs, points)]
    varied = [name for name in points[0] if len({point[name] for point in points}) > 1]
    told = [", ".join(f"{in_words(name)} {valued(point[name])}" for name in varied) for point in points]
    return told if varied and len(set(told)) == len(told) else []


def told_apart(name, runs):
    options = [{key: value for key, value in r.options.items() if key not in IN_NO_TITLE} for r in runs]
    differ = [key for key in dict.fromkeys(key for one in options for key in one)
              if len({one.get(key) for one in options}) > 1]

    def named(one, write):
        return ", ".join([name, *(f"{key} {write(one[key])}".rstrip() for key in differ if key in one)])

    ways = [[named(one, shortly) for one in options], [named(one, str) for one in options],
            [f"{r.path.resolve().parent.name}/{name}" if r.path.exists() else name for r in runs],
            [f"{name} ({k})" for k in range(1, len(runs) + 1)]]
    return next(way for way in (ways if len(differ) <= TOLD_APART_BY else ways[2:]) if len(set(way)) == len(way))


def shortly(text):
    """A number of many digits with four."""
    try:
        return f"{float(text):.4g}"
    except ValueError:
        return text


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


def _text(value):
    if isinstance(value, np.ndarray) and value.size == 1:
        value = value.item()
    return value.decode() if isinstance(value, bytes) else value


def options_of(text):
    """Lines '-a 1', '-b' as {'a': '1', 'b': ''}."""
    pairs = (line[1:].partition(" ") for line in str(text).splitlines() if line)
    return {name: value for name, _, value in pairs}


def _group(group, name, about):
    """The datasets of a group, those of groups within under their path."""
    table = Table()

    def take(key, data):
        if isinstance(data, h5py.Group):
            table.update({f"{key}/{attribute}": _text(value) for attribute, value in data.attrs.items()})
        else:
            table[key] = data[()]
            for attribute, notes in about.items():
                if attribute in data.attrs:
                    notes[f"{name}/{key}"] = str(_text(data.attrs[attribute]))

    group.visititems(take)
    for attribute, value in group.attrs.items():
        table[attribute] = _text(value)
    return table


def _cut(table, names):
    """A run that is going on or was killed may have written one array further than another."""
    names = [n for n in names if n in table]
    if names:
        rows = min(len(table[n]) for n in names)
        for n in names:
            table[n] = table[n][:rows]


def _read(path):
    """(attributes, groups, units, notes). No lock is asked for: the run that writes may go on."""
    units, notes = {}, {}
    about = {"units": units, "description": notes}
    with h5py.File(path, "r", locking=False) as file:
        attributes = {k if isinstance(k, str) else k.decode("latin-1"): _text(v) for k, v in file.attrs.items()}
        # walls, earlier_options: texts too long for an attribute are datasets
        attributes |= {name: _text(file[name][()]) for name in file
                       if isinstance(file[name], h5py.Dataset) and file[name].shape == ()
                       and file[name].dtype.kind in "SO"}
        groups = {name: _group(file[name], name, about) for name in file if name not in PRIVATE
                  and isinstance(file[name], h5py.Group)}
    return attributes, groups, units, notes


def no_result(path, error) -> str:
    """Why a file that is not HDF5 is none: a scene is often given in the place of its result."""
    with path.open("rb") as file:
        words = file.read(4096).decode("utf-8", "replace").splitlines()
    if path.suffix == ".opts" or any(word.startswith("-growth_") for word in words):
        return "is an options file, not its result; run it, with -output FILE.h5, and give that"
    return f"not a whole HDF5 file ({error})"


def numbers_of(table):
    """Refuses what is no array of numbers."""
    for name, values in table.items():
        if isinstance(values, np.ndarray) and values.dtype.kind not in "fiub":
            raise ResultsError(f"{table.of}/{name}: holds {values.dtype}, and no numbers")


def finite(table, name, dimensions, many=None):
    """[...] of a table, all of it finite and of a size that numbers of a rod have."""
    values = np.asarray(table[name])
    if values.ndim != dimensions or values.dtype.kind not in "fiub":
        raise ResultsError(f"{table.of}/{name}: is an array {list(values.shape)}; it should have {dimensions} dimensions")
    if many is not None and values.shape[:len(many)] != many:
        raise ResultsError(f"{table.of}/{name}: is an array {list(values.shape)}, which does not go with the others, {list(many)}")
    if not (np.abs(values) < MOST).all():  # also of nan
        raise ResultsError(f"{table.of}/{name}: holds a number that is not finite, or none of a rod")
    return values


def cut_to(table, rows):
    """Leaves so many rows of each of its arrays."""
    for name in table:
        table[name] = table[name] if name == "s" else table[name][:rows]


def check_series(series):
    for name, values in series.items():
        if np.ndim(values) != 1:
            raise ResultsError(f"{series.of}/{name}: is an array {list(np.shape(values))}, not a number a step")
    if series:
        for name in ("t", "length"):
            finite(series, name, 1)
        if len(series.t) > 1 and series.t[-1] < series.t[-2]:  # a row that is being written
            cut_to(series, len(series.t) - 1)
        if (np.diff(series.t) < 0).any():
            raise ResultsError(f"{series.of}/t: does not rise")


def check_shapes(shapes):
    """Shapes that go with each other, of rods that have a length."""
    if not shapes:
        return
    k, s = len(finite(shapes, "t", 1)), finite(shapes, "s", 1)
    rows = [k] + [len(shapes[name]) for name in ALONG if name in shapes and np.ndim(shapes[name])]
    many = (min(rows), len(s))  # a run that goes on may have written one array further than another
    if len(s) < 2 or (np.diff(s) <= 0).any():
        raise ResultsError(f"{shapes.of}/s: labels must rise")
    for name in ALONG:
        if name in shapes or name in SHAPES:
            dimensions = 2 if name in NUMBERS else 3
            if np.ndim(shapes[name]) != dimensions:
                finite(shapes, name, dimensions)
            part = Table({name: shapes[name][:many[0]]})
            part.of = shapes.of
            finite(part, name, dimensions, many)
    if shapes.x.shape[2] not in (2, 3) or any(shapes[name].shape[2] not in (2, 3) for name in ALONG if np.ndim(shapes.get(name, 0)) == 3):
        raise ResultsError(f"{shapes.of}: points and forces have two or three components")
    for name in ("strain", "d1", "d2", "d3") if shapes.x.shape[2] == 3 else ():
        shapes[name]  # a rod in space has them all
    if shapes.force.shape[2] != shapes.x.shape[2]:
        raise ResultsError(f"{shapes.of}/force: has not as many components as x")
    x, t = shapes.x, shapes.t
    if many[0] > 1 and (not x[many[0] - 1].any() or t[many[0] - 1] < t[many[0] - 2]):  # one that is being written
        many = many[0] - 1, many[1]
        cut_to(shapes, many[0])
    if many[0] and not (np.ptp(shapes.x[:many[0]], axis=1).max(axis=1) > 0).all():
        raise ResultsError(f"{shapes.of}/x: holds a rod without a length")
    if (np.diff(shapes.t[:many[0]]) < 0).any():
        raise ResultsError(f"{shapes.of}/t: does not rise")


def check_modes(stability, critical):
    """Tables of -task stability and critical."""
    if stability:
        t, _ = finite(stability, "t", 1), finite(stability, "t_cr", 0)
        for name, values in stability.items():
            if np.ndim(values) == 1 and name != "t" and len(values) != len(t):
                raise ResultsError(f"{stability.of}/{name}: has {len(values)} rows, and t {len(t)}")
    if critical:
        s = finite(critical, "s", 1)
        for name in ("t", "length", "error", "frequency"):
            finite(critical, name, 0)
        for name in ("y", "theta", "x2", "x3"):
            if name in critical:
                finite(critical, name, 1, s.shape)


def check_attributes(path, attributes):
    """Scales and numbers of the rod, which all that draws needs."""
    for name, value in attributes.items():
        if name.startswith(("si_", "parameters/si_")) or name in OF_ROD:
            try:
                good = math.isfinite(float(value)) and (float(value) > 0 or not name.startswith("si_")) and abs(float(value)) < MOST
            except (TypeError, ValueError):
                good = False
            if not good:
                raise ResultsError(f"{path}: attribute {name}: {str(value)[:40]} is no number that it can be")
    for name in ("options", "walls"):
        if not isinstance(attributes.get(name, ""), str):
            raise ResultsError(f"{path}: {name}: is no text")


def load(path) -> Results | Sweep:
    """Reads a result file, of a run or of a sweep; raises ResultsError, a plain line, if that cannot be
    done."""
    from .collection import is_sweep, load_sweep

    path = path_of(path, "load")
    if not path.is_file():
        raise ResultsError(f"{path}: is a directory, not a file" if path.is_dir() else f"{path}: no such file")
    if is_sweep(path):
        return load_sweep(path)
    for attempt in range(10):
        try:
            attributes, groups, units, notes = _read(path)
            break
        except (OSError, *OF_CONTENT) as error:
            # a file that is being written may change between two reads: once more, then
            if attempt == 9 or time.time() - path.stat().st_mtime > 3:
                raise ResultsError(f"{path}: {no_result(path, error)}") from None
            time.sleep(0.1)
    series, shapes, stability, critical = (groups.pop(name, Table()) for name in
                                           ("series", "shapes", "stability", "critical"))
    if not (series or stability or critical):
        raise ResultsError(f"{path}: no result file of tendril, it has no group series")
    for table, name in ((series, "series"), (shapes, "shapes"), (stability, "stability"), (critical, "critical")):
        table.of = f"{path}: {name}"
        numbers_of(table)
    check_series(series)
    check_shapes(shapes)
    check_modes(stability, critical)
    _cut(series, list(series))
    _cut(shapes, [name for name in shapes if name != "s"])
    if len(shapes.get("t", ())) and not len(series.get("t", ())):
        raise ResultsError(f"{path}: series: holds no step, though there are shapes")
    check_attributes(path, attributes)
    options = options_of(attributes.pop("options", ""))
    finished = bool(attributes.pop("finished", 0))
    return Results(path, finished, options, attributes, series, shapes, stability, critical, groups,
                   notes, units)

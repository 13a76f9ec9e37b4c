"""Makes one page for a browser of result files: the rod in motion with its forces, all series under a
common cursor, summary and options. The page is one file, and needs no server and no network.

    scripts/view.sh results/uniform-dry.h5
    scripts/view.sh slow.h5 fast.h5 --output compare.html --titles slow,fast

The curves are drawn by uPlot (web/uplot), a rod in space by three.js (web/three); the page itself is in web/."""

from __future__ import annotations

import html
import json
import re
from pathlib import Path
from typing import Sequence

import numpy as np
from matplotlib.colors import to_hex

from . import page_space
from .command import Parser
from .errors import ResultsError, arguments, replacing
from .loading import load, runs_of
from .packed import moves_straight, packed, packed_small, thinned
from .pictures import colours, name_of, symbol_of
from .results import UNCERTAIN, Results
from .spatial import FIELDS, fields_of, out_of_plane
from .style import COLOURS
from .surroundings import friction, pressed, size_of
from .titles import titles_of
from .units import add_choice_of_units, in_laboratory, in_laboratory_of, laboratory_units
from .senses import lamp
from .walls import outlines, parse

WEB = Path(__file__).resolve().parent / "web"
MOST_SHAPES, MOST_NODES, ARROWS = 300, 501, 28  # what a page holds of a run
IN_PLANE = ("axial", "curvature", "growth")  # what the colours of a rod in the plane may show
# (title, series, logarithmic); series that are in none get a chart of their own
CHARTS = (
    ("distance", ("length", "end_distance", "mid_distance", "width"), False),
    ("deflection", ("norm_x2", "norm_x3"), True),
    ("energy", ("energy", "energy_twist", "contact_energy"), False),
    ("power", ("growth_power", "dissipation", "tip_power", "clamp_power", "weight_power", "wall_power",
               "curvature_power", "tropism_power"), False),
    ("force at the clamp", ("base_force_1", "base_force_2", "base_force_3", "feed_force"), False),
    ("moment at the clamp", ("base_moment_1", "base_moment_2", "base_moment_3"), False),
    ("force on the tip", ("tip_force_1", "tip_force_2", "tip_force_3"), False),
    ("force of friction", ("friction_force_1", "friction_force_2", "friction_force_3"), False),
    ("force of walls", ("wall_force_1", "wall_force_2", "wall_force_3"), False),
    ("weight", ("weight_force_1", "weight_force_2", "weight_force_3"), False),
    ("speed", ("tip_speed", "mid_speed"), False),
    ("tip", ("tip_x1", "tip_x2", "tip_x3"), False),
    ("angles", ("tip_angle", "natural_angle", "natural_angle_2", "natural_bend"), False),
    ("turns", ("link", "writhe"), False),
    ("crossings, inflections", ("self_crossings", "inflections"), False),
    ("energy defect", ("energy_defect",), True),
    ("estimated error", ("error_tip", "error_norm_x2", "error_energy"), True),
    ("step", ("step",), True),
)
FOLLOWS = (("time", "t"), ("length", "length"), ("tip x1", "tip_x1"), ("tip x2", "tip_x2"),
           ("tip x3", "tip_x3"), ("width", "width"), ("energy", "energy"), ("push at the clamp", "base_force_1"),
           ("energy defect", "energy_defect"))
WHOLE = ("steps", "Newton iterations", "finished", "ended by", "error at the end", "largest error", "version")


def shapes_of(r):
    """What moves: arrays by name, [stored time, ...], thinned to what a page holds. "along" has the fields by name."""
    nodes, kept = thinned(len(r.shapes.s), MOST_NODES), thinned(len(r.shapes.t), MOST_SHAPES)
    names = ["t", "x", "places", "friction"]
    names += ["touched", "contact"] if "contact" in r.shapes else []
    table, fields = {name: [] for name in names}, []
    for k in kept:
        shape = r.stored(k)
        values = [shape.t, shape.x[nodes], *friction(r, shape, ARROWS)]
        fields.append(fields_of(r, shape))
        values += pressed(r, shape, ARROWS) if "contact" in table else []
        for name, value in zip(names, values):
            table[name].append(value)
    along = {name: np.stack([one[name] for one in fields])[:, nodes] for name in fields[0] if name in IN_PLANE}
    return {name: np.asarray(rows) for name, rows in table.items()} | {"fair": moves_straight(r, kept), "along": along}


def summary_of(r):
    """What there is to say of a run as a whole."""
    return dict(zip(WHOLE, (len(r.series.t) - 1, int(r.series.newton_iterations.sum()), "yes" if r.finished else "no",
                            str(r.groups.get("event", {}).get("kind", "its end")), *errors_of(r),
                            str(r.attributes.get("version", "")))))


def errors_of(r):
    """How far it may be off in its last state, and at most, when and why."""
    if not r.errors:
        fit = r.attributes.get("error_estimate")
        return ("not measured", f"{float(fit):.1e} (a fit)" if fit is not None else "")
    told = {{"norm_x2": "‖x₂‖"}.get(name, name): one for name, one in r.errors.items()}
    name, worst = max(told.items(), key=lambda one: one[1].most)
    unit = f"{in_laboratory('l/V', r.scale)[0] * worst.when:.3g} {in_laboratory('l/V', r.scale)[1]}" \
        if "si_time" in r.attributes else f"{worst.when:.4g}"
    return (", ".join(f"{one} {error.end:.1e}" for one, error in told.items()),
            f"{name} {worst.most:.1e} at t = {unit}" + (f": {worst.why}" if worst.why else ""))


def run_of(r, title, colour, shapes, units):
    options = "\n".join(f"-{name} {value}".rstrip() for name, value in r.options.items())
    drawn = {"norm_x3": out_of_plane(r)} if r.in_space else {}
    return {
        "name": title, "colour": colour, "options": options, "summary": summary_of(r),
        "factors": {unit: in_laboratory(unit, r.scale)[0] / si for unit, (_, si) in units.items()},
        "series": {name: packed(values) for name, values in {**r.series, **drawn}.items()},
        "uncertain": {name: error for name, error in UNCERTAIN.items() if r.band(name) is not None},
        "shapes": {name: packed(values) for name, values in shapes.items() if name != "along"},
        "widths": {name: int(np.prod(values.shape[1:])) for name, values in shapes.items()
                   if name not in ("t", "fair", "along")},
        "walls": [] if r.in_space else [
            {part: [np.ravel(line).tolist() for line in lines] for part, lines in zip(("body", "lines"), drawn)}
            | {"motion": {what: numbers.tolist() for what, numbers in wall.motion.items()} or None}
            for wall, drawn in zip(parse(r.attributes.get("walls")), outlines(r))],
        "lamp": None if r.in_space or lamp(r, 2) is None else lamp(r, 2).tolist(),
        "diameter": r.diameter,
    }


def units_of(results):
    """The unit of each series that there is."""
    return {name: r.units.get(f"series/{name}", "1") for r in results for name in r.series}


def charts_of(results):
    """Which series are drawn together, and what they are: every series but time is in one."""
    present = dict.fromkeys(name for r in results for name in r.series if name != "t")
    units = units_of(results)
    charts = [(title, [n for n in names if n in present], log) for title, names, log in CHARTS]
    drawn = {name for _, names, _ in charts for name in names}
    charts += [(plain(name_of(name)), [name], False) for name in present if name not in drawn]
    return [{"title": title, "series": names, "log": log, "unit": units[names[0]]}
            for title, names, log in charts if names]


def plain(text):
    """A label without mathtext: |x(1/2)|, x₁, θ."""
    text = text.translate(str.maketrans("", "", "$")).replace(r"\|", "‖").replace(r"\theta", "θ")
    return re.sub("_([0-9])", lambda found: "₀₁₂₃₄₅₆₇₈₉"[int(found[1])], text)


def content_of(results, titles, space, si=None):
    """What the page's script draws; arrays are dimensionless, the script has the units."""
    lab = bool(in_laboratory_of(results, si, "view"))
    units = laboratory_units(results)
    shapes = [page_space.shapes_of(r, len(results)) if space else shapes_of(r) for r in results]
    shades = [to_hex(shade) for shade in colours(len(results))]
    drag = [float(np.percentile(size_of(s["friction"]), 95)) for s in shapes]
    press = [float(size_of(s["contact"]).max()) if "contact" in s else 0.0 for s in shapes]
    follows = [(text, unit, name) for text, name in FOLLOWS if (unit := units_of(results).get(name))]
    content = {
        "runs": [run_of(r, title, shade, shape, units)
                 for r, title, shape, shade in zip(results, titles, shapes, shades)],
        "charts": charts_of(results), "follows": follows, "whole": WHOLE, "colours": COLOURS,
        "names": {name: plain(name_of(name)) for r in results for name in r.series},
        "symbols": {name: plain(symbol_of(name)) for r in results for name in r.series},
        "units": {unit: name for unit, (name, _) in units.items()}, "lab": lab,
        "notes": {name: r.notes.get(f"series/{name}", "") for r in results for name in r.series},
        "touches": max(press) > 0,
    }
    for run, *longest in zip(content["runs"], drag, press):
        run["drag"], run["press"] = longest
    add_fields(content, shapes)
    if space:
        page_space.add(content, results, shapes)
    return content


def add_fields(content, shapes):
    """What colours along the rods may show."""
    for run, shape in zip(content["runs"], shapes):
        run["fields"] = {name: packed_small(values) for name, values in shape["along"].items()}
        run["nodes"] = shape["x"].shape[1]
    most = {name: max(float(np.abs(shape["along"][name]).max()) for shape in shapes if name in shape["along"])
            for name in FIELDS if any(name in shape["along"] for shape in shapes)}
    content["fields"] = {name: dict(zip(("label", "unit", "signed"), FIELDS[name])) | {"most": most[name]}
                         for name in most if most[name] > 0 or name == "axial"}


def page_of(content, title, space):
    """The page as text. Within a script element "<" could end it."""
    def text(*names):
        return "".join((WEB / name).read_text() for name in names)

    parts = {
        "title": html.escape(title), "style": text("uplot/uPlot.min.css", "page.css", *["space.css"] * space),
        "licence": text("uplot/LICENSE") + ("\nThe rod is drawn by three.js:\n" + text("three/LICENSE")) * space,
        "uplot": text("uplot/uPlot.iife.min.js") + ("\n" + text("three/three.min.js")) * space,
        "stage": text("space.html" if space else "plane.html"),
        "script": text("format.js", "drawing.js", "data.js", "space.js" if space else "plane.js", "charts.js"),
        "data": json.dumps(content, allow_nan=False).replace("<", "\\u003c"),
    }
    return re.sub("@([a-z]+)@", lambda found: parts[found[1]], (WEB / "page.html").read_text())


class Page:
    """A page as text, which a notebook shows inline, and save() keeps."""

    def __init__(self, text):
        self.text = text

    def save(self, path) -> Path:
        with replacing(path) as part:
            part.write_text(self.text, encoding="utf-8")
        return Path(path)

    def __repr__(self):
        return f"<a page of {len(self.text) / 1e6:.1f} MB, which a notebook shows; save('run.html') keeps it for a browser>"

    def _repr_html_(self):
        return (f'<iframe srcdoc="{html.escape(self.text)}" style="width: 100%; height: 640px; border: 0" '
                'title="tendril"></iframe>')


@arguments(output="file?", titles="texts?", si="flag?")
def view(results: Results | Sequence[Results], output: str | Path | None = None,
         titles: Sequence[str] | None = None, si: bool | None = None) -> Path | Page:
    """Writes a page for a browser of one run, or of several in one picture; its path. Without output the
    page itself, which a notebook shows.

    titles  of the runs; None: the names of their files
    si      opens in units of the laboratory; None: where the files have them; False: dimensionless. The page has a box
            that changes it"""
    runs = runs_of(results, "view")
    titles = titles_of(runs, titles)
    if len(titles) != len(runs):
        raise ResultsError(f"view: {len(titles)} titles for {len(runs)} runs")
    for r in runs:
        if not len(r.series.get("t", ())) or not len(r.shapes.get("t", ())):
            raise ResultsError(f"{r.told}: holds no stored shape to show")
    space = any(r.in_space for r in runs)
    page = Page(page_of(content_of(runs, titles, space, si), " · ".join(titles), space))
    return page if output is None else page.save(output)


def main(arguments=None):
    parser = Parser("scripts/view.sh", __doc__)
    parser.add_argument("files", nargs="+", metavar="FILE", help="result files, HDF5")
    parser.add_argument("--output", metavar="FILE.html",
                        help="default: the first file's name with .html")
    parser.add_argument("--titles", metavar="A,B,...", help="of the files; default: their names")
    add_choice_of_units(parser)
    choice = parser.parse_intermixed_args(arguments)
    output = choice.output or str(Path(choice.files[0]).with_suffix(".html"))
    output = view([load(path) for path in choice.files],
                  output if output.lower().endswith((".html", ".htm")) else f"{output}.html",
                  choice.titles.split(",") if choice.titles else None, choice.si)
    print(f"view: {output}, {output.stat().st_size / 1e6:.1f} MB; open it in a browser")
    return 0

"""Tables of programs that follow bodies or roots, as rows that tendril.measured reads: SLEAP, SmartRoot, RSML.

  SLEAP       the analysis CSV, track, frame_idx, instance.score, NODE.x, NODE.y, NODE.score, ..., or the analysis .h5;
              nodes are points from clamp to tip
  SmartRoot   the nodes as CSV, image, root, root_name, x, y, ..., in cm
  RSML        .rsml, polylines of roots in pixels, or in its unit by its resolution

Of a root system its one root that hangs on no other is taken. What is in a unit is counted from its first point, the base,
x1 to the right and x2 upwards in the picture; a picture's y goes downwards."""

from __future__ import annotations

import re
import xml.etree.ElementTree as xml

import h5py
import numpy as np

from .errors import DataError
from .units import METRES, PIXEL, PIXELS, unit_called

SURE = 0.6  # the score from which on a point is used
POINTS = ["x1 (px)", "x2 (px)", "point", "unsure"]


def only(names, source, what):
    """The one of some names that there is."""
    found = list(dict.fromkeys(names))
    if len(found) > 1:
        raise DataError(f"{source}: has {len(found)} {what}, {', '.join(found)}; leave the rows of one rod alone")


def text_of(value):
    return "" if value is None or not np.isfinite(value) else repr(float(value))


def scored(text):
    """Whether a score is too low; none is none."""
    try:
        return float(text) < SURE
    except ValueError:
        return False


# ---- SLEAP ----


def sleap(rows, source):
    """Rows of SLEAP's analysis CSV: (plain rows, notes), or None if it is not such a file."""
    heads = [cell.strip() for cell in rows[0]]
    if "frame_idx" not in heads:
        return None
    nodes = [head[:-2] for head in heads if head.endswith(".x") and f"{head[:-2]}.y" in heads]
    if len(nodes) < 3:
        raise DataError(f"{source}: SLEAP, with {len(nodes)} nodes; a rod needs three at least, from the clamp to the tip")
    body = [dict(zip(heads, (cell.strip() for cell in row))) for row in rows[1:]]
    only((row.get("track", "") for row in body), source, "tracks")
    frames = [row.get("frame_idx", "") for row in body]
    if twice := next((frame for frame in frames if frames.count(frame) > 1), None):
        raise DataError(f"{source}: has {frames.count(twice)} instances in frame {twice}; leave the rows of one rod alone")
    found = [["frame", *POINTS]]
    for row in body:
        for k, node in enumerate(nodes):
            x, y = row.get(f"{node}.x", ""), row.get(f"{node}.y", "")
            missing = not (x and y) or "nan" in (x.lower(), y.lower())
            found.append([row["frame_idx"], "" if missing else x, "" if missing else y, str(k),
                          str(int(missing or scored(row.get(f"{node}.score", ""))))])
    return found, [told_nodes(source, nodes)]


def told_nodes(source, nodes):
    return f"{source}: SLEAP, {len(nodes)} nodes as points from the clamp to the tip, {nodes[0]} to {nodes[-1]}, in px"


def sleap_file(source):
    """The same of its analysis .h5, tracks [track, 2, node, frame]."""
    try:
        with h5py.File(source, "r") as file:
            if "tracks" not in file or "node_names" not in file:
                raise DataError(f"{source}: no analysis file of SLEAP; give CSV, .xlsx, .rsml, or the .h5 that sleap-convert "
                                "--format analysis writes")
            tracks, nodes = file["tracks"][()].astype(float), [name.decode() for name in file["node_names"][()]]
            scores = file["point_scores"][()] if "point_scores" in file else None
    except (OSError, AttributeError, TypeError, ValueError) as error:
        raise DataError(f"{source}: no analysis file of SLEAP ({error})") from None
    if tracks.ndim != 4 or tracks.shape[1:3] != (2, len(nodes)) or scores is not None and scores.shape != tracks[:, 0].shape:
        raise DataError(f"{source}: no analysis file of SLEAP (tracks are {list(tracks.shape)})")
    used = np.flatnonzero(np.isfinite(tracks).any(axis=(1, 2, 3)))
    only((f"track {k}" for k in used), source, "tracks")
    found = [["frame", *POINTS]]
    for k in used[:1]:
        for frame in np.flatnonzero(np.isfinite(tracks[k]).any(axis=(0, 1))):
            for node in range(len(nodes)):
                x, y = tracks[k, :, node, frame]
                low = scores is not None and np.isfinite(scores[k, node, frame]) and scores[k, node, frame] < SURE
                found.append([str(frame), text_of(x), text_of(y), str(node), str(int(low or not np.isfinite(x + y)))])
    if len(found) == 1:
        raise DataError(f"{source}: SLEAP, without a point")
    return found, [told_nodes(source, nodes)]


# ---- root systems ----


def based(points, unit, factor=1.0):
    """[n, 2], points of a root from its base on, as a table has them: pixels as they are; else in the unit, from the base,
    upwards."""
    points = np.asarray(points, float)
    return points if unit == "px" else (points - points[0]) * factor * [1, -1]


def placed(unit):
    """In words, how that is."""
    return "in px" if unit == "px" else f"in {unit} from the root's base, x1 to the right and x2 upwards in the picture"


def smartroot(rows, source):
    """Rows of SmartRoot's nodes: (plain rows, notes), or None if it is not such a file."""
    heads = [cell.strip().lower() for cell in rows[0]]
    if not {"image", "root", "x", "y", "distance_from_base"} <= set(heads):
        return None
    body = [dict(zip(heads, (cell.strip() for cell in row))) for row in rows[1:]]
    first = [row for row in body if row.get("root_order", "0") in ("0", "")]
    name = "root_name" if "root_name" in heads else "root"
    only((row.get(name, "") for row in first), source, "roots that hang on no other")
    found = [["image", "x1 (cm)", "x2 (cm)", "point", "unsure"]]
    for image in dict.fromkeys(row["image"] for row in first):
        try:
            table = np.array([[float(row[k]) for k in ("distance_from_base", "x", "y")] for row in first if row["image"] == image])
        except (ValueError, KeyError):
            raise DataError(f"{source}: SmartRoot: a node of {image} has no numbers") from None
        table = table[np.argsort(table[:, 0], kind="stable")]
        found += [[image, text_of(x), text_of(y), str(k), "0"] for k, (x, y) in enumerate(based(table[:, 1:], "cm"))]
    notes = [f"{source}: SmartRoot, the nodes of a root as points from the clamp to the tip, {placed('cm')}"]
    if len(first) < len(body):
        notes.append(f"{source}: not used: {len(body) - len(first)} nodes of roots that hang on another")
    return found, notes


def alone(roots, source):
    if len(roots) > 1:
        names = [root.get("label") or root.get("id") or str(k + 1) for k, root in enumerate(roots)]
        raise DataError(f"{source}: has {len(roots)} roots that hang on no other, {', '.join(names)}; leave one alone")


def rsml(source):
    """Rows of an RSML file, and notes."""
    try:
        tree = xml.parse(source)
    except OSError as error:
        raise DataError(f"{source}: {error.strerror}") from None
    except (xml.ParseError, ValueError, LookupError) as error:
        raise DataError(f"{source}: no RSML ({error})") from None

    def told(path):
        return (tree.findtext(path) or "").strip()

    roots = tree.findall("scene/plant/root")
    if not roots:
        raise DataError(f"{source}: no RSML that has a root (scene, plant, root)")
    alone(roots, source)
    try:
        points = [[float(p.get("x")), float(p.get("y"))] for p in roots[0].findall("geometry/polyline/point")]
        resolution = float(told("metadata/resolution") or 1)
    except (TypeError, ValueError):
        raise DataError(f"{source}: RSML: a point or the resolution is no number") from None
    unit = told("metadata/unit") or PIXEL
    unit = PIXEL if unit.lower() in (*PIXELS, "none") else unit_called(unit, "length") or unit
    if len(points) < 3:
        raise DataError(f"{source}: RSML: its root has {len(points)} points; three are needed at least")
    if not resolution > 0:
        raise DataError(f"{source}: RSML: resolution {resolution:g}: it must be above 0")
    unit, factor = ("cm", METRES["in"] / METRES["cm"] / resolution) if unit == "in" else (unit, 1 / resolution)
    head = ["image", f"x1 ({unit})", f"x2 ({unit})", "point", "unsure"]
    image = told("metadata/image/name") or re.split(r"[\\/]", str(source))[-1]
    table = based(points, unit, factor)
    more = len(tree.findall("scene/plant//root")) - 1
    notes = [f"{source}: RSML, the root as {len(points)} points from the clamp to the tip, {placed(unit)}"]
    if more:
        notes.append(f"{source}: not used: {more} roots that hang on another")
    return [head, *([image, text_of(x), text_of(y), str(k), "0"] for k, (x, y) in enumerate(table))], notes

"""The rows of files as they come from programs, in any encoding: of all tables that the package reads (tendril.tables has
paths, surveys and rates), and as rows that tendril.measured reads.

CSV with comma, semicolon, tab or blanks between, decimal points or commas, in UTF-8, UTF-16 or Latin-1;
.xlsx; pandas DataFrames. A row knows its line of the file. And, turned into rows "t, x1, x2[, point]":

  DeepLabCut   lines scorer, [individuals,] bodyparts, coords; a row a frame, or a picture that was labelled;
               body parts are points from clamp to tip
  Tracker      a line of tracks over t, x, y, t, x, y; tracks are points from clamp to tip
  ImageJ       X, Y (or XM, YM) and Slice or Frame, among other columns

  TrackMate    POSITION_X, POSITION_Y and POSITION_T or FRAME, with names and units in the rows below

SLEAP, SmartRoot, RSML: tendril.tracked. Frames are times by frames per second; names of pictures, where they say some
(tendril.naming). Units stand in the headings or in a row below them. Whatever is not used is said, in notes."""

from __future__ import annotations

import csv
import re
from pathlib import Path

from . import naming, tracked
from .errors import DataError
from .units import OF_KIND, PIXEL, PIXELS, quantity, rate_called, unit_called

DECIMAL_COMMA = re.compile(r"\s*[-+]?\d*,\d+([eE][-+]?\d+)?\s*$")
THOUSANDS = re.compile(r"\s*[-+]?\d{1,3},\d{3}\s*")
GROUPED = re.compile(r"[-+]?\d{1,3}(,\d{3})+\.\d*")
# headings in small letters, and what they are called here
ALIASES = {"x": "x1", "y": "x2", "xm": "x1", "ym": "x2", "x_1": "x1", "x_2": "x2", "position_x": "x1", "position_y": "x2",
           "time": "t", "position_t": "t", "slice": "slice", "frame": "frame", "index": "point", "l": "length"}
ALIASES |= {name: name for name in ("x1", "x2", "t", "length", "point", "unsure")}
BETWEEN = (";", "\t", ",", None)  # cells; None: blanks
SURE = 0.6  # the likelihood from which on a point of DeepLabCut is used
PICTURES = ("image", "img", "file", "filename", "file name", "image name", "picture", "photo", "photograph")


class Row(list):
    """The cells of a row, and its line in the file, from 1."""

    def __init__(self, cells, line=0):
        super().__init__(cells)
        self.line = line


def line_of(row):
    return getattr(row, "line", 0)


def text_of_file(path):
    """A file's text, with plain minus signs and blanks."""
    return decoded(path).replace("\u2212", "-").replace("\u00a0", " ")


def decoded(path):
    try:
        raw = Path(path).read_bytes()
    except OSError as error:
        raise DataError(f"{path}: {error.strerror}") from None
    if raw[:2] in (b"\xff\xfe", b"\xfe\xff"):
        return raw.decode("utf-16", "replace")
    if b"\0" in raw:
        raise DataError(f"{path}: is no text; save it as .xlsx or as CSV")
    try:
        return raw.decode("utf-8-sig")
    except UnicodeDecodeError:
        return raw.decode("latin-1")


def workbook(path):
    """(the first sheet of an .xlsx, the names of others that hold something)"""
    try:
        import openpyxl
    except ImportError:
        raise DataError(f"{path}: reading .xlsx needs openpyxl: pip install openpyxl, or save it as CSV") from None
    try:
        first, *more = openpyxl.load_workbook(path, read_only=True, data_only=True).worksheets
    except FileNotFoundError:
        raise DataError(f"{path}: No such file or directory") from None
    except Exception as error:  # zipfile's, openpyxl's, ...
        raise DataError(f"{path}: no .xlsx ({error})") from None
    others = [sheet.title for sheet in more if any(cell is not None for row in sheet.iter_rows(values_only=True) for cell in row)]
    rows = first.iter_rows(values_only=True)
    return [Row(["" if cell is None else str(cell) for cell in row], k + 1) for k, row in enumerate(rows)], others


def table(frame):
    """The rows of a pandas DataFrame, its headings first; several levels of them are rows each. An index that has a name is
    a column."""
    if frame.columns.nlevels == 1 and any(frame.index.names) and not set(frame.index.names) & set(frame.columns):
        frame = frame.reset_index()
    levels = [[str(c[k]) for c in frame.columns] for k in range(frame.columns.nlevels)] \
        if frame.columns.nlevels > 1 else [[str(c) for c in frame.columns]]
    body = [["" if value != value or value is None else repr(float(value)) if isinstance(value, float) else str(value)
             for value in row] for row in frame.itertuples(index=False)]
    if len(levels) > 1:  # frames are the index of DeepLabCut's
        levels = [[name or "", *row] for name, row in zip(frame.columns.names, levels)]
        body = [[str(index), *row] for index, row in zip(frame.index, body)]
    return levels + body


def rows_of(source):
    """(rows of words, without empty ones and those that begin with #; notes)"""
    rows, notes, _ = rows_and_comments(source)
    return rows, notes


def rows_and_comments(source):
    """The same, and the comments: words behind a #, with their lines."""
    notes, commas, comments = [], False, []
    if hasattr(source, "itertuples"):
        rows = [Row(row, k + 1) for k, row in enumerate(table(source))]
    elif str(source).lower().endswith((".xlsx", ".xlsm")):
        rows, others = workbook(source)
        rows, commas = pointed(rows)
        notes += [f"{source}: not used: sheet {name}" for name in others]
    else:
        lines, comments = [], []
        for number, line in enumerate(re.split("\r\n|\r|\n", text_of_file(source))):
            if line.lstrip().startswith("#"):
                comments.append((number + 1, line.lstrip().lstrip("#").strip()))
            elif line.strip(" ,;\t") and not line.startswith("sep="):
                lines.append((number + 1, line))
        if not lines:
            raise DataError(f"{source}: is empty")
        try:
            rows, commas = split(lines)
        except csv.Error as error:
            raise DataError(f"{source}: is no table ({error})") from None
    if commas:
        notes.append(f"{source}: commas in numbers are decimal ones")
    rows = [row for row in rows if any(cell.strip() for cell in row)]
    if not rows:
        raise DataError(f"{source}: is empty")
    return rows, notes, comments


def cells_of(lines, separator):
    """Rows of lines, (number, text): what stands between separators, or between blanks."""
    if separator is None:
        return by_blanks(lines)
    reader = csv.reader((text for _, text in lines), delimiter=separator)
    rows, before = [], 0
    for cells in reader:
        rows.append(Row(cells, lines[before][0]))
        before = reader.line_num
    return rows


def by_blanks(lines):
    """Rows by blanks. A heading's unit is no word of its own, nor are the words of a heading that only one blank parts where
    two and more part the others."""
    rows = [Row([word.strip('"') for word in re.findall(r'"[^"]*"|\S+', text)], number) for number, text in lines]
    widths = [len(row) for row in rows if row and all(map(is_number, row))]
    width = max(set(widths), key=widths.count) if widths else 0
    found = []
    for row, (number, text) in zip(rows, lines):
        if not any(map(is_number, row)):
            apart = re.split(r"\s{2,}", text.strip())
            row = Row(apart if len(apart) == width > 1 else re.sub(r"\s+(?=[(\[])", "", text).split(), number)
        found.append(row)
    return found


def numbers_in(cells):
    """How well cells are numbers: what is one counts, what is none counts against it."""
    filled = [cell.strip() for cell in cells if cell.strip()]
    count = sum(is_number(cell) or bool(DECIMAL_COMMA.match(cell)) for cell in filled)
    return 2 * count - len(filled) if count > 1 else 0


def split(lines):
    """(rows, whether numbers have decimal commas). The separator is that by which most of the first lines are numbers."""
    sample = lines[:60]
    text = "\n".join(line for _, line in sample)
    ways = [way for way in BETWEEN if way is None or way in text]
    score = [sum(max(0, numbers_in(row)) for row in cells_of(sample, way)) for way in ways]
    separator = ways[score.index(max(score))] if max(score) else ways[0]
    # what follows a # behind numbers is a comment
    lines = [(number, re.sub(r"\s+#.*$", "", line) if re.match(r"\s*[-+.\d]", line) and '"' not in line else line)
             for number, line in lines]
    rows = cells_of(lines, separator)
    if separator == ",":  # in quotes a number may have one, too
        quoted = [cell for row in rows for cell in row if DECIMAL_COMMA.match(cell)]
        if quoted and all(THOUSANDS.fullmatch(cell) for cell in quoted):
            raise DataError(f'"{quoted[0].strip()}": is the comma a decimal one, or of thousands? Write the numbers with points, '
                            "or without")
    return pointed(rows)


def pointed(rows):
    """(rows with decimal points, whether there were commas)"""
    if not any(DECIMAL_COMMA.match(cell) for row in rows for cell in row):
        return rows, False
    return [Row([cell.replace(",", ".") if DECIMAL_COMMA.match(cell) else cell for cell in row], line_of(row)) for row in rows], True


def untitled(rows, name, notes):
    """Rows without titles above the headings: words that stand alone in their row. Above X, Y is a time."""
    filled = [[cell for cell in row if cell.strip()] for row in rows]
    first = next((k for k, cells in enumerate(filled) if len(cells) > 1 or is_number(cells[0])), 0)
    if first and [cell.strip().upper() for cell in filled[first][:2]] != ["X", "Y"]:
        notes.append(f"{name}: not used: {', '.join(cells[0].strip() for cells in filled[:first])}")
        return rows[first:]
    return rows


def deeplabcut(rows, source):
    """Rows of DeepLabCut: (plain rows, notes), or None if it is not such a file."""
    heads = {row[0].strip().lower(): row for row in rows[:5]}
    if "bodyparts" not in heads or "coords" not in heads:
        return None
    first = next(k for k, row in enumerate(rows) if row[0].strip().lower() == "coords") + 1
    columns = [k for k, cell in enumerate(heads["coords"]) if k and cell.strip()]  # others are of the index
    if not columns or any(len(heads[name]) <= columns[-1] for name in ("bodyparts", "individuals") if name in heads):
        raise DataError(f"{source}: DeepLabCut's lines bodyparts and coords are not of one length")
    several = list(dict.fromkeys(heads["individuals"][k] for k in columns)) if "individuals" in heads else []
    if len(several) > 1:
        raise DataError(f"{source}: has {len(several)} individuals, {', '.join(several)}; give the columns of one rod alone")
    order = list(dict.fromkeys(heads["bodyparts"][k] for k in columns))
    found, unsure = [["frame", "x1", "x2", "point", "unsure"]], 0
    for row in rows[first:]:
        for number, part in enumerate(order):
            value = {heads["coords"][k].strip().lower(): row[k] for k in columns if heads["bodyparts"][k] == part
                     and k < len(row)}
            x, y = (value.get(name, "").strip() for name in "xy")
            sure = (value.get("likelihood") or "").strip() or "1"
            if not is_number(sure):
                raise DataError(f'{source}, line {line_of(row)}: "{sure}" is no likelihood')
            unlikely = bool(x and y) and float(sure) < SURE
            unsure += unlikely
            # also of what is missing there is a row: the last that is there is the tip only if it is the last of all
            found.append(Row([frame_of(row, columns[0], source), x, y, str(number), str(int(unlikely or not (x and y)))], line_of(row)))
    notes = [f"{source}: DeepLabCut, {len(order)} body parts as points from the clamp to the tip, "
             f"{order[0]} to {order[-1]}"]
    return found, notes + ([f"{source}: {unsure} points have a likelihood below {SURE}"] if unsure else [])


def frame_of(row, columns, source):
    """The number of a frame: the index of a row, or the number in the name of the picture that was labelled."""
    if is_number(row[0]):
        return row[0]
    number = re.findall(r"\d+", re.split(r"[\\/]", row[columns - 1])[-1])
    if not number:
        raise DataError(f"{source}: {row[columns - 1]} has no number of a frame")
    return number[-1]


def tracker(rows, source):
    """Rows of Tracker: a line of tracks, then t, x, y for each. One alone is no rod: a title over points."""
    if len(rows) < 3:
        return None
    heads = [re.sub(r"[\s(\[].*", "", cell.strip().lower()) for cell in rows[1]]
    places = [k for k, head in enumerate(heads) if head == "x"]
    if heads[:1] != ["t"] or len(places) < 2 or "y" not in heads or rows[0][0].strip().lower().startswith("x"):
        return None
    if any(is_number(cell) for cell in rows[0] if cell.strip()):
        return None
    unit = re.search(r"[(\[].*[)\]]", rows[1][places[0]])
    found = [["t (s)", f"x1 {unit[0]}" if unit else "x1", f"x2 {unit[0]}" if unit else "x2", "point", "unsure"]]
    for row in rows[2:]:
        for number, k in enumerate(places):
            own = max((j for j in range(k) if heads[j] == "t"), default=0)
            x, y = (row[j].strip() if j < len(row) else "" for j in (k, k + 1))
            if own < len(row) and row[own].strip():
                found.append(Row([row[own], x, y, str(number), str(int(not (x and y)))], line_of(row)))
    unused = [head for head in dict.fromkeys(heads) if head not in ("t", "x", "y", "")]
    notes = [f"{source}: Tracker, {len(places)} tracks as points from the clamp to the tip, times in s"]
    return found, notes + ([f"{source}: not used: {', '.join(unused)}"] if unused else [])


def is_number(cell):
    try:
        float(cell)
        return "_" not in cell
    except ValueError:
        return False


def number_in(cell):
    """(number, unit behind it) of a cell; None for what is none."""
    return quantity(cell.replace(",", "") if GROUPED.fullmatch(cell.strip()) else cell)


def heading(cell):
    """(name, unit) of "x1 (cm)", "x1 [cm]" or "x1"; the unit None if there is none. With words behind the bracket all of it is
    the name."""
    name, unit = re.fullmatch(r"\s*(.*?)\s*(?:[(\[{]\s*([^()\[\]{}]*?)\s*[)\]}])?\s*", cell.replace("\n", " ")).groups()
    return name, unit


def alias(cell):
    """A heading by the name that tendril has for it, in letters of either case; x/cm is x (cm)."""
    if slash := re.fullmatch(r"\s*(t|time|length|l|x|y|x1|x2)\s*/\s*(\S+)\s*", cell, re.IGNORECASE):
        cell = f"{slash[1]} ({slash[2]})"
    name, unit = heading(cell)
    name = ALIASES.get(name.lower(), name)
    return name if unit is None else f"{name} ({unit})"


def is_unit(cell):
    """Whether a cell below the headings can be a unit: one that is known, or a word in brackets."""
    word = cell.strip()
    bare = word.strip("()[]{} ")
    return (word != bare and bare != "" and not is_number(bare)) or bare in ("-", *PIXELS) or \
        any(unit_called(bare, kind) for kind in OF_KIND) or bool(bare and rate_called(bare))


def units_in(row):
    """Whether a row below the headings is one of units: without a number, and with a unit."""
    filled = [cell for cell in row if cell.strip()]
    return not any(map(is_number, filled)) and any(map(is_unit, filled))


def with_units(rows, name, notes):
    """Headings with the units that stand in a row, or in the third, below them; rows of other names between are left out."""
    body = next((k for k, row in enumerate(rows) if k and any(map(is_number, row))), len(rows))
    said = next((k for k in range(1, min(body, 4)) if units_in(rows[k])), None)
    if said is None:
        return rows
    units = [cell.strip().strip("()[]{}").strip() for cell in rows[said]] + [""] * len(rows[0])
    heads = Row([cell if not unit or unit == "-" or heading(cell)[1] is not None else f"{cell} ({unit})"
                 for cell, unit in zip(rows[0], units)], line_of(rows[0]))
    notes.append(f"{name}: units from line {line_of(rows[said])}")
    return [heads, *rows[said + 1:]]


def plain(source, fps=None):
    """(rows as tendril.measured reads them, notes)

    fps  frames per second, for files that count frames"""
    name = "data" if hasattr(source, "itertuples") else source
    ending = Path(name).suffix.lower()
    if ending in (".rsml", ".h5", ".hdf5", ".slp"):
        known = tracked.rsml(source) if ending == ".rsml" else tracked.sleap_file(source)
        return timed(known[0], fps, name, known[1]), known[1]
    rows, notes = rows_of(source)
    known = deeplabcut(rows, name) or tracker(rows, name) or tracked.sleap(rows, name) or tracked.smartroot(rows, name)
    if known:
        rows, more = known
        notes += more
    else:
        rows = untitled(rows, name, notes)
    if not known and not all(is_number(cell) for cell in rows[0] if cell.strip()):
        second = [cell.strip().upper() for cell in rows[1][:2]] if len(rows) > 1 else []
        if second != ["X", "Y"]:
            rows = with_units(rows, name, notes)
            rows = placed(Row([in_short(alias(cell)) for cell in rows[0]], line_of(rows[0])), rows[1:])
    return timed(rows, fps, name, notes), notes


def placed(heads, rows):
    """Rows whose column `defined`, 3D Slicer's, says which points are unsure."""
    names = [heading(cell)[0].lower() for cell in heads]
    if "defined" not in names or "unsure" in names:
        return [heads, *rows]
    column = names.index("defined")
    return [Row([*heads[:column], "", *heads[column + 1:], "unsure"], line_of(heads)),
            *(Row([*(row + [""] * len(heads))[:len(heads)], str(int(is_undefined(row[column] if column < len(row) else "")))],
                  line_of(row)) for row in rows)]


def is_undefined(cell):
    """What a column `defined` has for a point that is not placed."""
    return cell.strip().lower() in ("0", "0.0", "false", "no", "undefined", "missing")


def in_short(cell):
    """A heading whose unit is by the name that tendril has for it."""
    name, unit = heading(cell)
    short = unit and next((found for kind in OF_KIND if (found := unit_called(unit, kind))),
                          PIXEL if unit.lower() in PIXELS else unit)
    return cell if unit is None or short == unit else f"{name} ({short})"


def timed(rows, fps, name, notes):
    """Rows in which frames are times."""
    heads = [cell.strip().lower() for cell in rows[0]]
    counts = [heads.index(head) for head in ("frame", "slice") if head in heads]
    if any(re.match(r"(t|length)\b", head) for head in heads):
        return rows
    if not counts:
        return by_pictures(rows, fps, name, notes)
    # ImageJ writes both, one of them 1 in all rows, and counts from 1
    varied = [k for k in counts if len({row[k] for row in rows[1:] if k < len(row) and row[k].strip()}) > 1]
    if len(varied) > 1:
        raise DataError(f"{name}: has frames and slices; leave one of the two columns out")
    column, first = (varied or counts)[0], 1 if "slice" in heads else 0
    if not fps:
        raise DataError(f"{name}: counts {heads[column]}s; give the frames per second, --fps 25")
    if first:
        notes.append(f"{name}: {heads[column]} 1 is at t = 0")
    body = []
    for row in rows[1:]:
        cell = row[column] if column < len(row) else ""
        if cell.strip() and not is_number(cell):
            raise DataError(f'{name}: "{cell.strip()}" is no {heads[column]}')
        time = repr((float(cell) - first) / float(fps)) if cell.strip() else ""
        body.append(Row([*row[:column], time, *row[column + 1:]], line_of(row)))
    return [[*rows[0][:column], "t (s)", *rows[0][column + 1:]], *body]


def by_pictures(rows, fps, name, notes):
    """Rows in which the names of pictures are times, if there is a column of them and they say some."""
    heads = [cell.strip().lower() for cell in rows[0]]
    column = next((heads.index(head) for head in PICTURES if head in heads), None)
    if column is None and "label" in heads:  # of ImageJ; another's labels are of points
        column = heads.index("label")
        if not all(re.search(r"\.(tiff?|png|jpe?g|bmp|gif)\b", row[column], re.IGNORECASE) for row in rows[1:] if column < len(row)):
            return rows
    if column is None:
        return rows
    pictures = list(dict.fromkeys(row[column].strip() for row in rows[1:] if column < len(row) and row[column].strip()))
    times, told = naming.times_of(pictures, fps)
    notes += [f"{name}: {told}"] if told else []
    if times is None:
        return rows
    at = dict(zip(pictures, times))
    body = [Row([*row[:column], repr(at[row[column].strip()]) if column < len(row) and row[column].strip() else "", *row[column + 1:]],
                line_of(row)) for row in rows[1:]]
    return [[*rows[0][:column], "t (s)", *rows[0][column + 1:]], *body]

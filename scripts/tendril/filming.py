"""Centre lines from a film or from photographs.

    m = tendril.measure("push.mp4", clamp=(212, 540), scale=((212, 900), (1012, 900), "20cm"), every=8)
    m.save("push")                      # push.csv for tendril.fit, push.html to see and correct
    f = tendril.fit("tube.opts", "push.csv", {"si_friction_dry": ("1N/m", "20N/m")})

    scripts/measure.sh push.mp4 --clamp 212,540 --scale 212,900:1012,900:20cm --every 8 --output push

A picture is traced by tendril.tracing. Here are frames and their times, what a pixel is in centimetres (two
points and their distance; or a checkerboard that lies in the plane of the rod, which also takes out a tilt of
the camera; lens distortion by pictures of one), what is unsure by comparison with the other frames, and the
page on which points are dragged and frames dropped."""

from __future__ import annotations

import base64
import json
import logging
import os
import re
import sys
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from .command import Parser, per_second
from .errors import TendrilError, arguments, complaint, number, replacing, silenced, whole, writable
from .measured import DataError, Measured, gather, moment
from .naming import times_of
from .tracing import FilmError, Traced, leaves_against, needed, trace
from .units import MEASURED, METRES, PIXEL, with_unit

WEB = Path(__file__).resolve().parent / "web"
FILMS = (".mp4", ".avi", ".mov", ".mkv", ".webm", ".m4v", ".gif", ".wmv", ".mpg", ".mpeg")
PAGE_WIDTH, PAGE_FRAMES = 960, 60  # of the pictures in a page, and how many it holds at most
BOARD_ALIKE = 1.6  # corners of a board err alike, from light and blur: of twenty known cameras the numbers found were off by
# 1.4 to 1.6 times what independent corners would have them
JUMP = 0.08  # of its length: a line that is so much shorter than those around it lost its tip
FEW = 5  # widths: a line that is no longer is no rod's, unless those that follow it in a film have grown from it
GROWN = 2.0  # times as long is the next one then, at most
LOST = 0.5  # of the length that a photograph is told to have: a shorter line is not that of the body


@dataclass
class Frame:
    """One picture that was measured."""

    source: str
    at: float  # s in a film; nan where it is not known
    length: str  # "12cm", of a photograph whose length is known; "" else
    line: Traced | None
    trouble: str = ""  # why there is no line

    def centimetres(self):
        """The length that is known."""
        value, unit = with_unit(self.length)
        return value * MEASURED[unit][1] / METRES["cm"]


class Scale:
    """From pixels to the plane of the rod, in metres (or lengths without a unit), from the clamp, x1 along."""

    def __init__(self, clamp, along, homography, unit):
        self.clamp, self.along, self.homography, self.unit = clamp, along, homography, unit
        origin, ahead = self.flat(np.array([clamp, along], float))
        direction = (ahead - origin) / max(np.hypot(*(ahead - origin)), 1e-12)
        self.origin = origin
        # x2 is upwards in the picture, whose rows go downwards
        self.turn = np.column_stack([direction, [direction[1], -direction[0]]])

    def flat(self, points):
        """Points in the plane, still with y downwards."""
        whole = np.column_stack([points, np.ones(len(points))]) @ self.homography.T
        return whole[:, :2] / whole[:, 2:]

    def plane(self, points):
        return (self.flat(points) - self.origin) @ self.turn

    def doubts(self, corners, board, draws=200):
        """{number of the camera: standard deviation}, by what the corners of the board leave unknown of it: the
        plane is seen from the clamp through a homography that came out a little other, x -> (A x + b)/(1 + g.x)."""
        random = np.random.default_rng(1)
        plane = np.eye(3)  # from the clamp's frame to the flat one
        plane[:2, :2], plane[:2, 2] = self.turn, self.origin
        found = []
        for _ in range(draws):
            other = np.linalg.inv(plane) @ noise_of_board(corners, board, self.homography, random) \
                @ np.linalg.inv(self.homography) @ plane
            other = other / other[2, 2]
            linear = other[:2, :2] - np.outer(other[:2, 2], other[2, :2])
            found.append([linear[0, 0] - linear[1, 1], linear[0, 1] + linear[1, 0], *other[2, :2]])
        names = ("camera_stretch", "camera_shear", "camera_tilt_1", "camera_tilt_2")
        return dict(zip(names, np.std(found, axis=0)))

    def back(self, points):
        """Where points of the plane are in the picture."""
        flat = np.column_stack([points @ self.turn.T + self.origin, np.ones(len(points))])
        whole = flat @ np.linalg.inv(self.homography).T
        return whole[:, :2] / whole[:, 2:]


@dataclass(repr=False)
class Filmed:
    """What was measured of a film or photographs."""

    frames: list[Frame]
    scale: Scale
    fps: float
    notes: list[str] = field(default_factory=list)
    pictures: list = field(default_factory=list)  # small ones, for the page
    doubts: dict = field(default_factory=dict)  # of the camera's numbers, what a board leaves unknown (Scale.doubts)

    def __repr__(self):
        good = [f for f in self.frames if f.line]
        return f"<{len(self.frames)} pictures, {len(good)} with a line, {sum(not f.line.whole for f in good)} without its tip>"

    def good(self):
        return [f for f in self.frames if f.line and f.line.whole]

    def rows(self) -> list[list[str]]:
        """The points as a table for tendril.fit, its headings first, in cm (in px without a scale)."""
        unit, factor = ("cm", 1 / METRES["cm"]) if self.scale.unit else (PIXEL, 1)
        given = [f for f in self.good() if f.length]
        head = "length (cm)" if given else "t (s)"
        rows = [[head, f"x1 ({unit})", f"x2 ({unit})", "point", "unsure"]]
        for f in self.good():
            at = f.centimetres() if f.length else np.nan if given else f.at
            at = "" if np.isnan(at) else f"{at:.6g}"
            points = self.scale.plane(f.line.points) * factor if self.scale.unit else f.line.points
            rows += [[at, f"{x:.5g}", f"{y:.5g}", str(k), str(int(u))] for k, ((x, y), u) in enumerate(zip(points, f.line.unsure))]
        return rows

    def text(self) -> str:
        """The same as CSV, behind what is to be said of it."""
        return "\n".join([*(f"# {note}" for note in self.notes), *map(",".join, self.rows())]) + "\n"

    def measured(self, path="film") -> Measured:
        """What tendril.fit takes as data."""
        import pandas

        heads, *body = self.rows()
        return gather(pandas.DataFrame(body, columns=heads))

    def priors(self, clicked=2.0, turned=0.01, scaled=2e-3) -> dict[str, str]:
        """What tendril.fit is to know of the picture: clamp and direction were clicked to some pixels and
        radians, the scale is good to a part of itself; the tilt of the camera, as well as the board tells it."""
        pixel = float(np.hypot(*(self.scale.plane(np.array([np.add(self.scale.clamp, [1, 0])]))[0])))
        unit = self.scale.unit
        return {"camera_x": f"0{unit}:{clicked * pixel:.3g}{unit}", "camera_y": f"0{unit}:{clicked * pixel:.3g}{unit}",
                "camera_turn": f"0:{turned:g}", "camera_scale": f"1:{scaled:g}"} | {
                    name: (f"0/{unit}:{off:.3g}/{unit}" if "tilt" in name else f"0:{off:.3g}")
                    for name, off in self.doubts.items()} if unit else {}

    def table(self):
        """A row a frame, as a pandas DataFrame: width and error in mm (px), length in cm."""
        import pandas

        rows = []
        for f in self.frames:
            if not f.line:
                rows.append((f.source, f.at, np.nan, np.nan, np.nan, np.nan, f.trouble))
                continue
            plane = self.scale.plane(f.line.points)
            length = float(np.sum(np.hypot(*np.diff(plane, axis=0).T)))
            size = length / f.line.length
            rows.append((f.source, f.at, length, f.line.width * size, f.line.error * size,
                         float(np.mean(f.line.unsure)), "" if f.line.whole else f.trouble or "the tip is not seen"))
        names = ["source", "t", "length", "width", "error", "unsure", "trouble"]
        return pandas.DataFrame(rows, columns=names)

    def save(self, basename):
        """Writes BASENAME.csv, for fit; -frames.csv, a row a frame; .html, to see and correct."""
        with replacing(f"{basename}.csv") as part:
            part.write_text(self.text())
        with replacing(f"{basename}-frames.csv") as part:
            self.table().to_csv(part, index=False)
        with replacing(f"{basename}.html") as part:
            part.write_text(self.page(Path(basename).name))

    def page(self, name="film") -> str:
        """One page for a browser: each picture with its line; points are dragged, frames dropped, clamp and
        scale set; it saves the CSV anew."""
        frames = []
        for f, (jpeg, size) in zip(self.frames, self.pictures):
            count = len(f.line.points) if f.line else 0
            some = np.unique(np.r_[np.arange(0, count, max(1, count // 30)), [count - 1] * (count > 0)]).astype(int)
            points = f.line.points[some] if f.line else np.empty((0, 2))
            frames.append({"name": f.source, "t": None if np.isnan(f.at) else f.at,
                           "length": f.centimetres() if f.length else None,
                           "unsure": f.line.unsure[some].astype(int).tolist() if f.line else [],
                           "picture": base64.b64encode(jpeg).decode(), "size": size,
                           "points": np.round(points, 2).tolist(), "trouble": f.trouble,
                           "kept": bool(f.line and f.line.whole)})
        about = {"name": name, "frames": frames, "clamp": list(map(float, self.scale.clamp)),
                 "along": list(map(float, self.scale.along)), "homography": self.scale.homography.tolist(),
                 "metric": bool(self.scale.unit)}
        text = (WEB / "trace.html").read_text(encoding="utf-8")
        return text.replace("/*DATA*/", json.dumps(about).replace("</", "<\\/"))


def film_frames(path, every, frames):
    """(number, picture) of a film, RGB; its frames per second in the first of them."""
    os.environ.setdefault("OPENCV_FFMPEG_LOGLEVEL", "-8")  # what ffmpeg thinks of a film
    cv2 = needed("cv2", "OpenCV")
    film = cv2.VideoCapture(str(path))
    if not film.isOpened():
        raise FilmError(f"{path}: no film that can be read" if Path(path).is_file() else f"{path}: no such file")
    fps = film.get(cv2.CAP_PROP_FPS)
    try:
        number = 0
        while film.grab():
            if number % every == 0 and (frames is None or frames[0] <= number <= frames[1]):
                read, picture = film.retrieve()
                if read:
                    yield fps, number, cv2.cvtColor(picture, cv2.COLOR_BGR2RGB)
            number += 1
    finally:
        film.release()
    if number == 0:
        raise FilmError(f"{path}: a film without a picture")


@contextmanager
def quiet(cv2):
    """Readers of pictures say what they think of a file in lines of their own."""
    log, own = logging.getLogger("tifffile"), getattr(cv2.utils, "logging", None)
    log.disabled, before, level = True, log.disabled, own and own.setLogLevel(0)
    try:
        with silenced():
            yield
    finally:
        log.disabled = before
        if own:
            own.setLogLevel(level)


def photograph(path):
    """[h, w] or [h, w, 3] of a file, 8 bits; what imageio cannot read OpenCV may, as TIFF with LZW."""
    imageio, cv2 = needed("imageio.v3", "imageio"), needed("cv2", "OpenCV")
    if not isinstance(path, (str, Path)):
        raise FilmError(f"a picture is the name of a file or an array, not {type(path).__name__}")
    if not Path(path).is_file():
        raise FilmError(f"{path}: no such file")
    with quiet(cv2):
        try:
            picture, reason = np.asarray(imageio.imread(path)), "it is empty"
        except Exception as error:  # any of its readers', which are many
            picture, reason = np.empty(0), (str(error).splitlines() or [type(error).__name__])[0]
    if not picture.size:
        with quiet(cv2):
            picture = cv2.imread(str(path), cv2.IMREAD_UNCHANGED)
        if picture is None:
            more = "; pip install imagecodecs, or save it as PNG" if "imagecodecs" in reason else ""
            raise FilmError(f"{path}: no picture that can be read ({reason}){more}")
        picture = picture if picture.ndim == 2 else picture[..., 2::-1]
    return eight_bits(picture, path)


def eight_bits(picture, path):
    """A picture as it is traced."""
    picture = np.asarray(picture)
    if picture.ndim == 3 and picture.shape[2] in (1, 2):  # grey, and how opaque it is
        picture = picture[..., 0]
    if picture.ndim not in (2, 3) or picture.ndim == 3 and picture.shape[2] not in (3, 4) or 0 in picture.shape:
        raise FilmError(f"{path}: is no one picture, but an array {list(picture.shape)}; save its pictures one by one")
    if picture.dtype.kind not in "buif" or not np.isfinite(picture).all():
        raise FilmError(f"{path}: its pixels are no numbers")
    picture = picture if picture.ndim == 2 else picture[..., :3]
    if picture.dtype == np.uint16:
        picture = picture // 257
    elif picture.dtype != np.uint8:
        low, high = min(float(picture.min()), 0.0), float(picture.max())
        part = picture.dtype.kind in "bf" and 0 <= low and high <= 1
        if part or low < 0 or high > 255:  # from black to white
            picture = 255 * (picture.astype(float) - low) / (1 if part else max(high - low, 1e-300))
    return np.ascontiguousarray(picture.astype(np.uint8))


def lengths():
    """Names of the units of length, for messages."""
    return ", ".join(name for name, (unit, _) in MEASURED.items() if unit == "l")


def metres(text, what):
    try:
        value, unit = with_unit(text)
    except TendrilError:
        raise FilmError(f"{what}: {text} is no length; give 20cm") from None
    if unit not in MEASURED:
        raise FilmError(f"{what}: {unit} is no unit; give a length in {lengths()}")
    if MEASURED[unit][0] not in ("l", ""):
        raise FilmError(f"{what}: {text} is no length; give 20cm")
    return value * MEASURED[unit][1], unit


def similarity(scale):
    """[3, 3], of two points and their distance: ((x, y), (x, y), "20cm")."""
    a, b, distance = scale
    reach, _ = metres(distance, "scale")
    pixels = float(np.hypot(*(np.asarray(b, float) - a)))
    if pixels < 2 or not reach > 0:
        raise FilmError("scale: give two points that are apart, and their distance: 212,900:1012,900:20cm")
    return np.diag([reach / pixels, reach / pixels, 1.0])


def corners_of(picture, board):
    """[n, 2], the inner corners of a checkerboard in a picture, row by row, to a part of a pixel."""
    cv2 = needed("cv2", "OpenCV")
    grey = cv2.cvtColor(picture, cv2.COLOR_RGB2GRAY) if picture.ndim == 3 else picture
    finder = getattr(cv2, "findChessboardCornersSB")
    found, corners = finder(grey, tuple(board[:2]))
    if not found:
        raise FilmError(f"no checkerboard of {board[0]} x {board[1]} inner corners was found")
    return corners.reshape(-1, 2).astype(float)


def of_board(corners, board):
    """[3, 3], from pixels to the plane of a checkerboard (columns, rows of inner corners, "1cm" a square)."""
    cv2 = needed("cv2", "OpenCV")
    square, _ = metres(board[2], "checkerboard")
    grid = np.array([[c, r] for r in range(board[1]) for c in range(board[0])], float) * square
    found, _ = cv2.findHomography(corners, grid)
    middle = np.append(corners.mean(axis=0), 1)
    jacobian = found[:2, :2] / (found[2] @ middle)
    if np.linalg.det(jacobian) < 0:  # numbered from the other side
        found = np.diag([-1.0, 1, 1]) @ found
    return found


def noise_of_board(corners, board, homography, random):
    """[3, 3], the homography as it might have come out as well: the corners lie off the plane's by some part of a
    pixel, as far as they are off the one that was found, which has taken up 8 numbers of them."""
    square, _ = metres(board[2], "checkerboard")
    whole = np.column_stack([corners, np.ones(len(corners))]) @ homography.T
    flat = whole[:, :2] / whole[:, 2:]
    grid = np.array([[c, r] for r in range(board[1]) for c in range(board[0])], float) * square
    if np.abs(flat - grid).max() > square / 2:  # numbered from the other side
        grid = grid * [-1, 1]
    back = np.column_stack([grid, np.ones(len(grid))]) @ np.linalg.inv(homography).T
    off = corners - back[:, :2] / back[:, 2:]
    size = BOARD_ALIKE * np.sqrt(np.sum(off**2) / max(2 * len(corners) - 8, 1))
    return of_board(corners + size * random.normal(size=corners.shape), board)


class Lens:
    """The lens, by pictures of a checkerboard in several positions."""

    def __init__(self, pictures, board):
        cv2 = needed("cv2", "OpenCV")
        grid = np.array([[c, r, 0] for r in range(board[1]) for c in range(board[0])], np.float32)
        corners = [corners_of(p, board).astype(np.float32) for p in pictures]
        if len(corners) < 3:
            raise FilmError("lens: give three pictures of the checkerboard at least, in different positions")
        size = pictures[0].shape[1::-1]
        # a handful of pictures tells no more than how long the lens is and two numbers of its bend: with its
        # middle and what is not round left free, too, the edges of the picture come out anyhow
        begin = np.array([[size[0], 0, (size[0] - 1) / 2], [0, size[0], (size[1] - 1) / 2], [0, 0, 1]], float)
        few = (cv2.CALIB_USE_INTRINSIC_GUESS | cv2.CALIB_FIX_PRINCIPAL_POINT | cv2.CALIB_FIX_ASPECT_RATIO
               | cv2.CALIB_ZERO_TANGENT_DIST | cv2.CALIB_FIX_K3)
        self.error, self.matrix, self.bent, _, _ = cv2.calibrateCamera([grid] * len(corners), corners, size, begin, None,
                                                                       flags=few)

    def straight(self, picture):
        return needed("cv2", "OpenCV").undistort(picture, self.matrix, self.bent)

    def straightened(self, points):
        """Where points of a picture as it was taken are in the straight one."""
        found = needed("cv2", "OpenCV").undistortPoints(np.array(points, float).reshape(-1, 1, 2), self.matrix, self.bent,
                                                        P=self.matrix)
        return found.reshape(-1, 2)


def when(one):
    """(time in s or nan, length as text or "", path) of FILE, 12cm@FILE or 20s@FILE."""
    at, _, path = str(one).rpartition("@")
    try:
        kind, value = moment(at, str(one))
        si = 1.0 if value.unit in ("l", "l/V") else np.nan
    except DataError:
        si = np.nan
    if at and np.isnan(si):
        raise FilmError(f"{one}: {at} is no time and no length; give 20s@FILE or 12cm@FILE")
    if kind == "length":
        return np.nan, f"{float(value.numbers) * 100:.10g}cm", path
    return float(value.numbers), "", path


def told_of(sources, fps):
    """(time, length and path of each picture or film; a line that tells of times that stand in names, or "")"""
    told = [(np.nan, "", one) if hasattr(one, "shape") else when(one) for one in sources]
    names = [path for at, length, path in told if not hasattr(path, "shape") and np.isnan(at) and not length
             and not path.lower().endswith(FILMS)]
    times, line = times_of(names, fps) if len(names) == len(told) else (None, "")
    return ([(at, "", path) for at, path in zip(times, names)] if times else told), line


def pictures_of(source, fps, every, frames, notes):
    """(name, time or nan, length or "", picture) one after the other; source: a film, or photographs, each a
    file or LENGTH@FILE or TIME@FILE."""
    told, line = told_of(source, fps)
    notes += [line] if line else []
    for at, length, path in told:
        if hasattr(path, "shape"):
            yield "picture", np.nan, "", eight_bits(path, "picture")
            continue
        if path.lower().endswith(FILMS):
            for told, number, picture in film_frames(path, every, frames):
                rate = fps or told
                if not (rate and np.isfinite(rate) and rate > 0):
                    raise FilmError(f"{path}: does not know its frames per second; give --fps 25")
                yield f"{Path(path).name}, frame {number}", number / rate, "", picture
            continue
        yield Path(path).name, at, length, photograph(path)


def small(picture):
    """(JPEG of a picture for the page, its size before)"""
    cv2 = needed("cv2", "OpenCV")
    h, w = picture.shape[:2]
    part = min(1.0, PAGE_WIDTH / w)
    shown = cv2.resize(picture, (int(w * part), int(h * part)), interpolation=cv2.INTER_AREA)
    shown = cv2.cvtColor(shown, cv2.COLOR_RGB2BGR) if shown.ndim == 3 else shown
    return bytes(cv2.imencode(".jpg", shown, [cv2.IMWRITE_JPEG_QUALITY, 70])[1]), [w, h]


def doubted(f, direction, seen):
    """Why a line is none of the body: it leaves against x1, or is much shorter than the body is told to be; else ""."""
    if direction is not None and leaves_against(f.line.points, direction, f.line.width):
        return "the line goes away from --along, against x1"
    plane = seen.plane(f.line.points)
    length = float(np.sum(np.hypot(*np.diff(plane, axis=0).T)))
    if f.length and seen.unit and length < LOST * f.centimetres() / 100:
        return f"the line is {100 * length:.3g} cm long, and the body {f.length}: it was not followed to its tip"
    return ""


def stubs(frames):
    """Marks lines of a few widths, where a body was not followed: but of a film those from which longer ones have grown."""
    following, length = False, 0.0
    order = sorted((f for f in frames if f.line and not f.trouble), key=lambda f: (np.isnan(f.at), f.at))
    for f in order[::-1]:
        long = f.line.length >= FEW * f.line.width
        following = long or following and not np.isnan(f.at) and length <= GROWN * f.line.length
        length = f.line.length
        if not following:
            f.trouble = f"the line is {length:.0f} px long, {length / f.line.width:.1f} of its widths: that is no rod"


def compared(frames, notes):
    """Marks lines that are not like those before and after them: a rod that grows does not become shorter."""
    lengths = [(k, f.line.length) for k, f in enumerate(frames) if f.line and f.line.whole and not f.trouble
               and not np.isnan(f.at)]
    order = sorted(lengths, key=lambda pair: frames[pair[0]].at)
    for (a, before), (b, here), (c, after) in zip(order, order[1:], order[2:]):
        if abs(here - 0.5 * (before + after)) > JUMP * here + 0.5 * abs(after - before):
            frames[b].trouble = "its length is not like that before and after"
    stubs(frames)
    longest = 0.0
    for k, length in order:
        if length < (1 - JUMP) * longest and not frames[k].trouble:
            frames[k].trouble = "shorter than before"
        longest = max(longest, 0 if frames[k].trouble else length)
    for f in frames:
        if f.trouble and f.line:
            f.line.whole = False
    lost = sum(not (f.line and f.line.whole) for f in frames)
    if lost:
        notes.append(f"{lost} of {len(frames)} pictures are not used; the page and -frames.csv say why")


def place(value, what):
    """[2], a point in a picture."""
    try:
        found = np.array(value, float)
    except (TypeError, ValueError):
        found = np.empty(0)
    if found.shape != (2,) or not np.isfinite(found).all():
        raise FilmError(f"{what}: give a point of the picture, two numbers in pixels, not {value!r}")
    return found


def boarded(value):
    """(columns, rows, square) of a checkerboard."""
    try:
        columns, rows, square = value
        columns, rows = whole(columns, "checkerboard"), whole(rows, "checkerboard")
        metres(square, "checkerboard")
    except (TypeError, ValueError):
        raise FilmError(f'checkerboard: give inner corners and the square, (9, 6, "1cm"), not {value!r}') from None
    if min(columns, rows) < 3:
        raise FilmError("checkerboard: needs three inner corners at least each way")
    return columns, rows, square


def checked(source, clamp, scale, checkerboard, lens, along, fps, every, frames, body, width, ground, points):
    """measure()'s arguments, those that have parts as such: (sources, clamp, scale, checkerboard, along)."""
    if body not in ("dark", "light") or ground not in ("plain", "textured"):
        raise FilmError("body is dark or light, ground is plain or textured")
    whole(every, "every"), whole(points, "points", 4, 10000)
    for value, what in ((fps, "fps"), (width, "width")):
        if value is not None:
            number(value, what, above=0)
    if frames is not None:
        try:
            first, last = (whole(k, "frames", 0) for k in frames)
        except (TypeError, ValueError):
            raise FilmError(f"frames: give the first and the last, (0, 200), not {frames!r}") from None
        if first > last:
            raise FilmError(f"frames: the first, {first}, comes after the last, {last}")
    if isinstance(source, (str, Path)) or hasattr(source, "shape"):
        source = [source]
    if not isinstance(source, (list, tuple)) or not all(isinstance(one, (str, Path)) or hasattr(one, "shape") for one in source):
        raise FilmError(f"source: give a film, or photographs as names of files or arrays, not {type(source).__name__}")
    if not isinstance(lens, (list, tuple)):
        raise FilmError("lens: give a list of pictures")
    clamp, along = place(clamp, "clamp"), None if along is None else place(along, "along")
    if along is not None and not np.hypot(*(along - clamp)) > 1:
        raise FilmError("along: give a point that is apart from the clamp")
    if scale is not None:
        if not isinstance(scale, (list, tuple)) or len(scale) != 3:
            raise FilmError('scale: give two points and their distance, ((212, 900), (1012, 900), "20cm")')
        scale = place(scale[0], "scale"), place(scale[1], "scale"), scale[2]
        similarity(scale)
    return list(source), clamp, scale, None if checkerboard is None else boarded(checkerboard), along


@arguments(pages="flag", progress="flag")
def measure(source, *, clamp, scale=None, checkerboard=None, board_picture=None, lens=(), along=None,
            fps: float | None = None, every: int = 1, frames=None, body: str = "dark",
            width: float | None = None, ground: str = "plain", points: int = 60, pages: bool = True,
            progress: bool = False) -> Filmed:
    """Measures centre lines in a film or in photographs.

    source        a film, or photographs, each "FILE", "12cm@FILE", "20s@FILE", or an array
    clamp         (x, y) in pixels, y downwards; like all that is clicked, in the picture as it was taken
    scale         ((x, y), (x, y), "20cm"): two points in the plane of the rod and their distance; None: pixels
    checkerboard  (9, 6, "1cm"): inner corners and square of one in the plane of the rod, instead of scale
    board_picture the picture that shows it; None: the first
    lens          pictures of the checkerboard in other positions, for the lens' distortion
    along         a point from the clamp in the direction of x1; None: to the right in the picture
    fps           frames per second; None: as the film says
    every         so many frames one is measured
    frames        (first, last) to be measured
    body          "dark" or "light" against its ground
    width         of the body in pixels; None: as seen
    ground        "plain" or "textured"
    points        of a line
    pages         keeps small pictures for the page

    Raises FilmError, in one line, for a film in which nothing can be measured."""
    given = checked(source, clamp, scale, checkerboard, lens, along, fps, every, frames, body, width, ground, points)
    sources, clamp, scale, checkerboard, along = given
    optics = Lens([photograph(p) for p in lens], checkerboard) if lens and checkerboard else None
    found, kept, notes, homography = [], [], [], np.eye(3)
    if optics:  # what was clicked was clicked in pictures as they were taken
        clamp, = optics.straightened([clamp])
        along = optics.straightened([along])[0] if along is not None else None
        scale = (*optics.straightened(scale[:2]), *scale[2:]) if scale else None
    metric = bool(scale or checkerboard)
    if scale:
        homography = similarity(scale)
    board = photograph(board_picture) if board_picture else None
    direction, seen = None, None
    for name, at, length, picture in pictures_of(sources, fps, every, frames, notes):
        picture = optics.straight(picture) if optics else picture
        if checkerboard and not found:
            shown = board if board is not None else picture
            corners = corners_of(optics.straight(shown) if optics and board is not None else shown, checkerboard)
            homography = of_board(corners, checkerboard)
        if seen is None:
            seen = Scale(clamp, (clamp[0] + 100, clamp[1]) if along is None else along, homography, "m" if metric else "")
            if metric or along is not None:  # of pixels fit finds the turn
                direction = np.subtract((clamp[0] + 100, clamp[1]) if along is None else along, clamp)
        frame = Frame(name, at, length, None)
        try:
            frame.line = trace(picture, clamp, body=body, width=width, ground=ground, points=points, along=direction)
            frame.trouble = doubted(frame, direction, seen)
        except FilmError as error:
            frame.trouble = str(error)
        found.append(frame)
        if pages:
            kept.append(small(picture))
        if progress:
            told = frame.trouble or f"{frame.line.length:.0f} px long, {frame.line.width:.1f} wide"
            print(f"measure: {name}: {told}", flush=True)
    if not any(f.line for f in found):
        raise FilmError(f"no line in any of {len(found)} pictures: {found[0].trouble if found else 'there is none'}")
    compared(found, notes)
    thin = np.unique(np.linspace(0, len(found) - 1, min(PAGE_FRAMES, len(found))).astype(int)) if pages else []
    if pages and len(thin) < len(found):
        notes.append(f"the page shows {len(thin)} of {len(found)} pictures")
    return Filmed(found, seen, fps or np.nan, notes, kept, seen.doubts(corners, checkerboard) if checkerboard else {})


def point(text):
    try:
        x, y = (float(part) for part in text.split(","))
    except ValueError:
        raise FilmError(f"{text}: give a point as X,Y in pixels") from None
    return x, y


def two_points(text):
    parts = text.split(":")
    if len(parts) != 3:
        raise FilmError(f"--scale {text}: give X,Y:X,Y:LENGTH, 212,900:1012,900:20cm")
    return point(parts[0]), point(parts[1]), parts[2]


def board(text):
    found = re.fullmatch(r"(\d+)x(\d+):(\S+)", text)
    if not found:
        raise FilmError(f"--checkerboard {text}: give inner corners and the square, 9x6:1cm")
    return int(found[1]), int(found[2]), found[3]


def main(arguments=None):
    parser = Parser("scripts/measure.sh", __doc__)
    parser.add_argument("source", nargs="+", metavar="FILM", help="or photographs, FILE, 12cm@FILE or 20s@FILE")
    parser.add_argument("--clamp", required=True, metavar="X,Y", help="in pixels, y downwards")
    parser.add_argument("--scale", metavar="X,Y:X,Y:LENGTH", help="two points in the plane of the rod")
    parser.add_argument("--checkerboard", metavar="9x6:1cm", help="inner corners and square of one in the plane")
    parser.add_argument("--board-picture", metavar="FILE", help="that shows it; default: the first")
    parser.add_argument("--lens", nargs="+", default=(), metavar="FILE", help="pictures of the checkerboard")
    parser.add_argument("--along", metavar="X,Y", help="a point from the clamp along x1; default: to the right")
    parser.add_argument("--fps", type=per_second, help="frames per second, or 6/h, 1/10min; default: as the film says")
    parser.add_argument("--every", type=int, default=1, help="so many frames one is measured")
    parser.add_argument("--frames", metavar="FIRST:LAST")
    parser.add_argument("--body", choices=("dark", "light"), default="dark")
    parser.add_argument("--width", type=float, help="of the body in pixels; default: as seen")
    parser.add_argument("--ground", choices=("plain", "textured"), default="plain")
    parser.add_argument("--points", type=int, default=60, help="of a line; default %(default)s")
    parser.add_argument("--output", metavar="BASENAME", default="film", help="default %(default)s")
    choice = parser.parse_args(arguments)
    try:
        if choice.scale and choice.checkerboard:
            raise FilmError("give --scale or --checkerboard, not both")
        writable(choice.output)
        span = tuple(int(k) for k in choice.frames.split(":")) if choice.frames else None
        m = measure(choice.source if len(choice.source) > 1 else choice.source[0], clamp=point(choice.clamp),
                    scale=two_points(choice.scale) if choice.scale else None,
                    checkerboard=board(choice.checkerboard) if choice.checkerboard else None,
                    board_picture=choice.board_picture, lens=choice.lens,
                    along=point(choice.along) if choice.along else None, fps=choice.fps, every=choice.every,
                    frames=span, body=choice.body, width=choice.width, ground=choice.ground,
                    points=choice.points, progress=True)
        m.save(choice.output)
    except (TendrilError, OSError, ValueError) as error:
        print(complaint(error, "measure"), file=sys.stderr)
        return 1
    for note in m.notes:
        print(f"measure: {note}")
    if not m.good():
        first = m.frames[0]
        print(f"measure: in none of {len(m.frames)} pictures the rod is seen as far as its tip ({first.source}: "
              f"{first.trouble or 'the tip is not seen'}), so {choice.output}.csv has no point; {choice.output}.html "
              "shows them, and lets you draw the lines", file=sys.stderr)
        return 1
    if known := m.priors():
        print("measure: what fit is to know of clicks and scale: "
              + " ".join(f"--prior {name}={prior}" for name, prior in known.items()))
    print(f"measure: {choice.output}.csv is for scripts/fit.sh, {choice.output}.html shows it and lets you correct it, "
          f"{choice.output}-frames.csv tells of each picture")
    return 0

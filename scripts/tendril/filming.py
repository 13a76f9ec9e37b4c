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
import re
import sys
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from .command import Parser
from .errors import TendrilError, complaint, replacing, writable
from .measured import KNOWN, Measured, gather
from .parameters import with_unit
from .tracing import FilmError, Traced, needed, trace

WEB = Path(__file__).resolve().parent / "web"
FILMS = (".mp4", ".avi", ".mov", ".mkv", ".webm", ".m4v", ".gif", ".wmv", ".mpg", ".mpeg")
PAGE_WIDTH, PAGE_FRAMES = 960, 60  # of the pictures in a page, and how many it holds at most
BOARD_ALIKE = 1.6  # corners of a board err alike, from light and blur: of twenty known cameras the numbers found were off by
# 1.4 to 1.6 times what independent corners would have them
JUMP = 0.08  # of its length: a line that is so much shorter than those around it lost its tip


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
        return value * KNOWN[unit][1] * 100


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

    def text(self) -> str:
        """The points as CSV for tendril.fit, in cm (in px without a scale)."""
        unit, factor = ("cm", 100) if self.scale.unit else ("px", 1)
        given = [f for f in self.good() if f.length]
        head = "length (cm)" if given else "t (s)"
        rows = [f"# {note}" for note in self.notes]
        rows.append(f"{head},x1 ({unit}),x2 ({unit}),point,unsure")
        for f in self.good():
            at = f.centimetres() if f.length else np.nan if given else f.at
            at = "" if np.isnan(at) else f"{at:.6g}"
            points = self.scale.plane(f.line.points) * factor if self.scale.unit else f.line.points
            rows += [f"{at},{x:.5g},{y:.5g},{k},{int(u)}" for k, ((x, y), u) in enumerate(zip(points, f.line.unsure))]
        return "\n".join(rows) + "\n"

    def measured(self, path="film") -> Measured:
        """What tendril.fit takes as data."""
        import io

        import pandas

        return gather(pandas.read_csv(io.StringIO(self.text()), comment="#"))

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


def photograph(path):
    imageio = needed("imageio.v3", "imageio")
    try:
        picture = np.asarray(imageio.imread(path))
    except (OSError, ValueError, SyntaxError) as error:
        raise FilmError(f"{path}: no picture that can be read ({str(error).splitlines()[0]})") from None
    if picture.dtype == np.uint16:
        picture = (picture // 257).astype(np.uint8)
    return picture.astype(np.uint8) if picture.ndim == 2 else picture[..., :3].astype(np.uint8)


def metres(text, what):
    value, unit = with_unit(text)
    if KNOWN.get(unit, ("", 0))[0] not in ("l", ""):
        raise FilmError(f"{what}: {text} is no length; give 20cm")
    return value * KNOWN[unit][1], unit


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


def pictures_of(source, fps, every, frames):
    """(name, time or nan, length or "", picture) one after the other; source: a film, or photographs, each a
    file or LENGTH@FILE or TIME@FILE."""
    sources = [source] if isinstance(source, (str, Path)) or hasattr(source, "shape") else list(source)
    for one in sources:
        if hasattr(one, "shape"):
            yield "picture", np.nan, "", np.asarray(one)
            continue
        at, _, path = str(one).rpartition("@")
        if path.lower().endswith(FILMS):
            for told, number, picture in film_frames(path, every, frames):
                rate = fps or told
                if not (rate and np.isfinite(rate) and rate > 0):
                    raise FilmError(f"{path}: does not know its frames per second; give --fps 25")
                yield f"{Path(path).name}, frame {number}", number / rate, "", picture
            continue
        length = re.fullmatch(r"(?:length\s*=?\s*)?([-+0-9.eE]+\s*(m|cm|mm|um))", at.strip())
        time = re.fullmatch(r"(?:t\s*=?\s*)?([-+0-9.eE]+)\s*s", at.strip())
        if at and not (length or time):
            raise FilmError(f"{one}: {at} is no time and no length; give 20s@FILE or 12cm@FILE")
        yield Path(path).name, float(time[1]) if time else np.nan, length[1].replace(" ", "") if length else "", \
            photograph(path)


def small(picture):
    """(JPEG of a picture for the page, its size before)"""
    cv2 = needed("cv2", "OpenCV")
    h, w = picture.shape[:2]
    part = min(1.0, PAGE_WIDTH / w)
    shown = cv2.resize(picture, (int(w * part), int(h * part)), interpolation=cv2.INTER_AREA)
    shown = cv2.cvtColor(shown, cv2.COLOR_RGB2BGR) if shown.ndim == 3 else shown
    return bytes(cv2.imencode(".jpg", shown, [cv2.IMWRITE_JPEG_QUALITY, 70])[1]), [w, h]


def compared(frames, notes):
    """Marks lines that are not like those before and after them: a rod that grows does not become shorter."""
    lengths = [(k, f.line.length) for k, f in enumerate(frames) if f.line and f.line.whole and not np.isnan(f.at)]
    order = sorted(lengths, key=lambda pair: frames[pair[0]].at)
    for (a, before), (b, here), (c, after) in zip(order, order[1:], order[2:]):
        if abs(here - 0.5 * (before + after)) > JUMP * here + 0.5 * abs(after - before):
            frames[b].trouble = "its length is not like that before and after"
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
    if body not in ("dark", "light") or ground not in ("plain", "textured"):
        raise FilmError("body is dark or light, ground is plain or textured")
    if every < 1:
        raise FilmError("every: give 1 or more")
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
    for name, at, length, picture in pictures_of(source, fps, every, frames):
        picture = optics.straight(picture) if optics else picture
        if checkerboard and not found:
            shown = board if board is not None else picture
            corners = corners_of(optics.straight(shown) if optics and board is not None else shown, checkerboard)
            homography = of_board(corners, checkerboard)
        try:
            line, trouble = trace(picture, clamp, body=body, width=width, ground=ground, points=points), ""
        except FilmError as error:
            line, trouble = None, str(error)
        found.append(Frame(name, at, length, line, trouble))
        if pages:
            kept.append(small(picture))
        if progress:
            print(f"measure: {name}: {trouble or f'{line.length:.0f} px long, {line.width:.1f} wide'}", flush=True)
    if not any(f.line for f in found):
        raise FilmError(f"no line in any of {len(found)} pictures: {found[0].trouble if found else 'there is none'}")
    compared(found, notes)
    thin = np.unique(np.linspace(0, len(found) - 1, min(PAGE_FRAMES, len(found))).astype(int)) if pages else []
    if pages and len(thin) < len(found):
        notes.append(f"the page shows {len(thin)} of {len(found)} pictures")
    ahead = along if along is not None else (clamp[0] + 100, clamp[1])
    unit = "m" if metric else ""
    seen = Scale(clamp, ahead, homography, unit)
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
    parser.add_argument("--fps", type=float, help="frames per second; default: as the film says")
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

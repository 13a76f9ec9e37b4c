"""The centre line of a thin body in one picture.

The body is what is darker (or lighter) than its ground over a few of its widths, which is a black hat of
morphology: light that changes slowly, and what is thick as a hand, drop out. What is connected with the clamp
is thinned to a skeleton; the path along it from the clamp goes straight on where lines cross, and over short
gaps. Each place of it is then moved to the middle of the body's profile across, so that it is good to a part
of a pixel, and a smoothing spline is laid through. Filters, skeleton and distances are those of OpenCV and
scikit-image."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import interpolate, ndimage

from .errors import TendrilError, optional

NOISE = 5.0  # the body stands out from the ground by so many standard deviations of the noise
TURN = np.radians(70)  # a path goes on within
LOOP = 0.7  # radians by which one turns rather to a branch that comes back to where one was: later it would be left out
COARSE, FINE = 640, 10.0  # pixels: of a picture in which a body is looked for; of its width, to be measured
BRIDGE = 8  # of its widths: a gap that a path goes over
AGAINST = -0.1  # cosine of the angle between x1 and the first part of a line, from which down it leaves the other way
BEGIN = 4  # widths of a line that are its first part


class FilmError(TendrilError):
    """A picture or film from which nothing can be measured, in one plain line."""


def needed(module, package):
    return optional(module, FilmError, f"measuring pictures needs {package}: pip install 'tendril[film]', or "
                    "pip install opencv-python-headless scikit-image imageio")


@dataclass
class Traced:
    """A centre line in pixels, from the clamp to the tip."""

    points: np.ndarray  # [n, 2], x to the right, y downwards
    unsure: np.ndarray  # [n], at crossings, in gaps, where the body touches itself
    error: float  # standard deviation of a point across
    width: float  # of the body
    whole: bool  # the tip is seen

    @property
    def length(self) -> float:
        return float(np.sum(np.hypot(*np.diff(self.points, axis=0).T)))


def standing_out(grey, body, size):
    """[h, w], by how much a picture is darker or lighter than its ground, over a distance in pixels."""
    cv2 = needed("cv2", "OpenCV")
    kernel = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (2 * int(size / 2) + 1,) * 2)
    kind = {"dark": cv2.MORPH_BLACKHAT, "light": cv2.MORPH_TOPHAT}[body]
    smooth = cv2.GaussianBlur(grey, (0, 0), 1.0)
    return cv2.morphologyEx(smooth, kind, kernel).astype(np.float32)


def ridges(grey, body, width):
    """The same on a textured ground: a ridge filter (Sato) that wants a line, not only a spot."""
    filters = needed("skimage.filters", "scikit-image")
    found = filters.sato(grey.astype(np.float32), sigmas=[0.5 * width / 2, 0.75 * width / 2],
                         black_ridges=body == "dark")
    return (255 * found / max(found.max(), 1e-30)).astype(np.float32)


def mask_of(response):
    """[h, w], where the body is: hysteresis between half and a third of what a body's response is, and above
    the noise."""
    filters = needed("skimage.filters", "scikit-image")
    noise = 1.4826 * np.median(np.abs(response - np.median(response))) + 0.5
    above = response[response > np.median(response) + NOISE * noise]
    if len(above) < 30:
        raise FilmError("nothing in the picture stands out from its ground")
    level = float(filters.threshold_otsu(above)) if np.ptp(above) > 0 else float(above[0])
    low = max(0.6 * level, np.median(response) + NOISE * noise)
    return filters.apply_hysteresis_threshold(response, low, max(level, low))


class Skeleton:
    """Branches of a thinned mask and the junctions at which they meet."""

    def __init__(self, mask, width):
        morphology = needed("skimage.morphology", "scikit-image")
        thin = morphology.skeletonize(mask)
        around = ndimage.convolve(thin.astype(np.uint8), np.ones((3, 3), np.uint8), mode="constant") - 1
        crossing = thin & (around >= 3)
        labels, count = ndimage.label(thin & ~crossing, np.ones((3, 3)))
        junctions, self.junction_count = ndimage.label(crossing, np.ones((3, 3)))
        self.width, self.branches, self.ends = width, [], []
        for k, box in enumerate(ndimage.find_objects(labels)):
            rows, columns = np.nonzero(labels[box] == k + 1)
            pixels = self.ordered(np.column_stack([columns + box[1].start, rows + box[0].start]))
            self.branches.append(pixels)
            self.ends.append([self.at(junctions, pixels[e]) for e in (0, -1)])
        self.centres = np.array(ndimage.center_of_mass(crossing, junctions, range(1, self.junction_count + 1))
                                ).reshape(-1, 2)[:, ::-1]
        self.merge()

    @staticmethod
    def ordered(pixels):
        """The pixels of a branch from one end to the other."""
        known = {tuple(p): k for k, p in enumerate(pixels)}
        steps = [(a, b) for a in (-1, 0, 1) for b in (-1, 0, 1) if a or b]
        steps.sort(key=lambda s: abs(s[0]) + abs(s[1]))
        near = [[known[q] for s in steps if (q := (p[0] + s[0], p[1] + s[1])) in known] for p in pixels.tolist()]
        here = next((k for k, n in enumerate(near) if len(n) <= 1), 0)
        order, seen = [here], {here}
        while (step := next((n for n in near[order[-1]] if n not in seen), None)) is not None:
            order.append(step)
            seen.add(step)
        return pixels[order].astype(float)

    @staticmethod
    def at(junctions, pixel):
        """The junction that an end of a branch touches, -1 for none."""
        x, y = pixel.astype(int)
        near = junctions[max(y - 1, 0):y + 2, max(x - 1, 0):x + 2]
        return int(near.max()) - 1

    def merge(self):
        """Two junctions that a branch shorter than two widths joins are one crossing; spurs go."""
        same = np.arange(self.junction_count)
        kept = []
        for k, (pixels, (a, b)) in enumerate(zip(self.branches, self.ends)):
            short = len(pixels) < 2 * self.width
            if short and a >= 0 and b >= 0 and a != b:
                same[same == same[b]] = same[a]
            elif not (len(pixels) < self.width and min(a, b) < 0 <= max(a, b)):
                kept.append(k)
        self.branches = [self.branches[k] for k in kept]
        self.ends = [[int(same[j]) if j >= 0 else -1 for j in self.ends[k]] for k in kept]

    def outwards(self, k, end):
        """The pixels of a branch from one of its ends on."""
        return self.branches[k] if end == 0 else self.branches[k][::-1]

    def direction(self, pixels):
        """That of the first two widths of a path."""
        far = pixels[min(int(2 * self.width) + 2, len(pixels) - 1)]
        gap = far - pixels[0]
        return gap / max(np.hypot(*gap), 1e-12)

    def onwards(self, path, used):
        """(branch, end, whether it is over a gap) at which a path goes on, or None."""
        heading, last = -self.direction(path[::-1]), path[-1]
        been = {junction for k in used for junction in self.ends[k] if junction >= 0}
        best = None
        for k in range(len(self.branches)):
            for end in (0, 1):
                if k in used:
                    continue
                ahead = self.outwards(k, end)
                gap = ahead[0] - last
                distance = np.hypot(*gap)
                joined = distance < 3 * self.width
                if distance > BRIDGE * self.width or (not joined and len(ahead) < 3 * self.width):
                    continue
                angles = [np.arccos(np.clip(heading @ self.direction(ahead), -1, 1))]
                if distance > self.width:
                    angles.append(np.arccos(np.clip(heading @ gap / distance, -1, 1)))
                if max(angles) < (TURN if joined else TURN / 2):
                    cost = max(angles) + 0.1 * distance / self.width - 0.02 * min(len(ahead) / self.width, 10)
                    if joined and self.ends[k][1 - end] in been:
                        cost -= LOOP
                    if best is None or cost < best[0]:
                        best = (cost, k, end, not joined)
        return best and best[1:]

    def path(self, clamp, most, along=None):
        """([n, 2] pixels from the clamp on, [n] whether a place is at a crossing or in a gap). Of several ways the longest
        that does not leave against along, if there is such a one."""
        near = [(float(np.min(np.hypot(*(b - clamp).T))), k) for k, b in enumerate(self.branches) if len(b) > 2]
        near = [(d, k) for d, k in near if d < most]
        if not near:
            raise FilmError("no body begins near the clamp; give --clamp, or another threshold (--body)")
        starts = [k for d, k in near if d < min(near)[0] + 2 * self.width]
        found = []
        for k in starts:
            begin = int(np.argmin(np.hypot(*(self.branches[k] - clamp).T)))
            for half in (self.branches[k][begin:], self.branches[k][:begin + 1][::-1]):
                if len(half) > 2:
                    found.append(self.follow(half, {k}))
        if not found:
            raise FilmError("the body near the clamp is no line")
        ahead = [pair for pair in found if len(pair[0]) > 2 * self.width and not leaves_against(pair[0], along, self.width)]
        return max(ahead or found, key=lambda pair: len(pair[0]))

    def follow(self, path, used):
        unsure = np.zeros(len(path), bool)
        while (step := self.onwards(path, used)) is not None:
            k, end, _ = step
            used = used | {k}
            ahead = self.outwards(k, end)
            count = max(int(np.hypot(*(ahead[0] - path[-1]))), 1)
            between = path[-1] + (ahead[0] - path[-1]) * (np.arange(1, count)[:, None] / count)
            doubt = np.ones(len(between), bool)
            near = min(int(2.5 * self.width), len(ahead), len(path))
            unsure[-near:] = True
            more = np.zeros(len(ahead), bool)
            more[:near] = True
            path = np.vstack([path, between, ahead])
            unsure = np.concatenate([unsure, doubt, more])
        return path, unsure


def leaves_against(path, along, width):
    """Whether the first part of a line, some widths of it, goes the other way than a direction; None: no."""
    if along is None:
        return False
    s = np.concatenate([[0], np.cumsum(np.hypot(*np.diff(path, axis=0).T))])
    gap = path[min(int(np.searchsorted(s, BEGIN * width)), len(path) - 1)] - path[0]
    return bool(gap @ along < AGAINST * np.hypot(*gap) * np.hypot(*along))


def resampled(path, step):
    """([n, 2], [n] the places on the old one): equally far from each other along a path."""
    s = np.concatenate([[0], np.cumsum(np.hypot(*np.diff(path, axis=0).T))])
    at = np.linspace(0, s[-1], max(int(s[-1] / step) + 1, 4))
    return np.column_stack([np.interp(at, s, column) for column in path.T]), at, s


def curved(path, step):
    """The same along a smooth line through the path: chords lie inside of a bend."""
    s = np.concatenate([[0], np.cumsum(np.maximum(np.hypot(*np.diff(path, axis=0).T), 1e-9))])
    at = np.linspace(0, s[-1], max(int(s[-1] / step) + 1, 4))
    return interpolate.CubicSpline(s, path)(at), at, s


def normals(path):
    along = np.gradient(path, axis=0)
    along /= np.maximum(np.hypot(*along.T), 1e-12)[:, None]
    return along, np.column_stack([-along[:, 1], along[:, 0]])


def centred(response, path, width):
    """A path moved to the middle of the body's profile across, and how wide that is there."""
    _, normal = normals(path)
    across = np.arange(-width, width + 0.05, 0.1)
    places = path[:, None] + across[:, None] * normal[:, None]
    profile = ndimage.map_coordinates(response, places.transpose(2, 0, 1)[::-1], order=1, mode="nearest")
    # its width is that at half its depth, however blurred its edges are
    profile = np.maximum(profile - 0.5 * profile.max(axis=1, keepdims=True), 0)
    # what is joined with the middle: a neighbour a width away is another part of the body
    middle = len(across) // 2
    on = profile > 0
    left = np.flip(np.cumprod(np.flip(on[:, :middle + 1], 1), 1), 1)
    right = np.cumprod(on[:, middle:], 1)
    joined = np.concatenate([left[:, :-1], right], axis=1)
    weight = profile * joined
    total = weight.sum(axis=1)
    shift = np.where(total > 0, (weight * across).sum(axis=1) / np.maximum(total, 1e-12), 0)
    return path + shift[:, None] * normal, joined.sum(axis=1) * 0.1


def to_the_tip(response, path, width):
    """A path that goes on straight to where the body ends: a skeleton stops half a width before. The end is
    where the response has fallen to half."""
    along, _ = normals(path)
    back = min(int(2 * width), len(path) - 1)
    heading = path[-1] - path[-1 - back]
    heading = heading / max(np.hypot(*heading), 1e-12)
    steps = np.arange(0, 2 * width, 0.25)
    ahead = path[-1] + steps[:, None] * heading
    level = ndimage.map_coordinates(response, ahead.T[::-1], order=1, mode="constant")
    inside = ndimage.map_coordinates(response, path[-back - 1:].T[::-1], order=1, mode="nearest")
    half = 0.5 * np.median(inside)
    beyond = np.flatnonzero(level < half)
    if not len(beyond) or beyond[0] == 0:
        return path
    k = beyond[0]
    reach = steps[k] - 0.25 * (half - level[k]) / max(level[k - 1] - level[k], 1e-12)
    return np.vstack([path, path[-1] + reach * heading]) if reach > 0.1 else path


def smoothed(path, unsure, width):
    """(a smoothing spline through a path, its scatter across): cross-validated along the path."""
    s = np.concatenate([[0], np.cumsum(np.maximum(np.hypot(*np.diff(path, axis=0).T), 1e-9))])
    weights = np.where(unsure, 0.1, 1.0)
    # knots a few widths apart: what is finer is no bend of a body that thick
    inner = np.linspace(0, s[-1], max(int(s[-1] / (2.5 * width)), 3))[1:-1]
    try:
        spline = interpolate.make_lsq_spline(s, path, np.r_[[0] * 4, inner, [s[-1]] * 4], w=weights)
    except (ValueError, np.linalg.LinAlgError):
        return path, 0.0
    line = spline(s)
    _, normal = normals(line)
    off = np.sum((path - line) * normal, axis=1)[~unsure]
    return line, float(1.4826 * np.median(np.abs(off))) if len(off) else 0.0


def trace(picture, clamp, *, body="dark", width=None, ground="plain", points=60, near=None, along=None) -> Traced:
    """The centre line of the body that begins at the clamp.

    picture  [h, w] or [h, w, 3], 8 bits
    clamp    (x, y) in pixels
    body     "dark" or "light" against its ground
    width    of the body in pixels; None: as the picture shows it
    ground   "plain" or "textured"
    points   of the line that comes out
    near     how far from the clamp the body may begin, in pixels; None: a tenth of the picture
    along    (x, y), the direction of x1 in the picture: of a body on both sides of the clamp that part is taken;
             None: the longer one

    Raises FilmError, in one line, where there is none."""
    cv2 = needed("cv2", "OpenCV")
    grey = picture if picture.ndim == 2 else cv2.cvtColor(np.ascontiguousarray(picture[..., :3]), cv2.COLOR_RGB2GRAY)
    clamp, near = np.asarray(clamp, float), near or 0.1 * max(grey.shape)
    along = None if along is None else np.asarray(along, float)
    if not width:
        coarse = min(1.0, COARSE / max(grey.shape))
        shown, there = reduced(grey, clamp, coarse)
        _, _, _, seen = found_in(shown, there, body, "plain", min(shown.shape) / 40, near * coarse, False, along)
        width = max(seen, 1.5) / coarse
    # a body of ten pixels is told to a small part of one; more of them cost time alone
    part = min(1.0, FINE / width)
    shown, there = reduced(grey, clamp, part)
    response, path, unsure, seen = found_in(shown, there, body, ground, width * part, near * part, True, along)
    line, doubt, error, wide = refined(response, path, unsure, seen)
    whole = to_the_tip(response, line, seen)
    h, w = shown.shape
    cut = not (seen < whole[-1, 0] < w - seen and seen < whole[-1, 1] < h - seen)
    fine, at, s = curved(whole, 0.5)
    doubt = np.interp(at, s, np.pad(doubt, (0, len(whole) - len(doubt)), "edge").astype(float)) > 0.25
    keep = np.linspace(0, len(fine) - 1, points).round().astype(int)
    # the middle of a pixel is where it was, whatever its size
    return Traced((fine[keep] + 0.5) / part - 0.5, doubt[keep], error / part, wide / part, not (cut or doubt[-1]))


def reduced(grey, clamp, part):
    """A picture and a place in it, made smaller."""
    if part == 1.0:
        return grey, clamp
    cv2 = needed("cv2", "OpenCV")
    return cv2.resize(grey, None, fx=part, fy=part, interpolation=cv2.INTER_AREA), (clamp + 0.5) * part - 0.5


def found_in(grey, clamp, body, ground, width, near, known, along):
    """(response, path, unsure, width) of the body near the clamp; known: whether its width is, or a guess."""
    cv2 = needed("cv2", "OpenCV")
    response = ridges(grey, body, width) if ground == "textured" and known else standing_out(grey, body, 3 * width)
    mask = mask_of(response)
    deep = cv2.distanceTransform(mask.astype(np.uint8), cv2.DIST_L2, 5)
    path, unsure = Skeleton(mask, max(width if known else 3, 3)).path(clamp, near, along)
    return response, path, unsure, 2 * float(np.median(deep[path[:, 1].astype(int), path[:, 0].astype(int)]))


def refined(response, path, unsure, width):
    """(a line through the middle of the body, whether a place of it is unsure, its scatter, its width)"""
    line, at, s = resampled(path, max(1.0, 0.3 * width))
    doubt = np.interp(at, s, unsure.astype(float)) > 0.25
    # the skeleton of a flat end, or at a hand, runs into a corner: to_the_tip() goes straight there
    cut = int(0.8 * width / max(at[1] - at[0], 1e-12))
    if len(line) > 2 * cut + 4:
        line, doubt = line[cut:-cut or None], doubt[cut:-cut or None]
    line, _ = smoothed(line, doubt, width)
    for _ in range(2):
        line, across = centred(response, line, 1.2 * width)
        line, error = smoothed(line, doubt, width)
    # where it is wider it touches itself
    return line, doubt | (across > 1.5 * np.median(across)), error, float(np.median(across))

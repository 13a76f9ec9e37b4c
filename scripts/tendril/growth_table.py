"""Makes a growth table for -growth_type table from the rate at which material elongates, given over
its distance along the rod from the tip or from the clamp.

    scripts/growth_table.sh root.h5 --length 2 --end 5 --rate "2*exp(-d/0.5)"
    scripts/growth_table.sh stem.h5 --length 1 --end 3 --rate measured.csv --from clamp --check
    scripts/growth_table.sh leaf.h5 --length 20mm --end 12h --rate marks.csv

The rate is relative, per time: 0.1 means that a piece gains a tenth of its length in unit time. It is
an expression of d (distance), t (time) and L (length of the rod), with numpy's functions; or a table
(CSV, .tsv, .xlsx) of two columns, distance and rate, joined by straight lines, its last rate going on beyond.
All is dimensionless, as in tendril; or in the units of --length and --end, and the table says so. Units in
the headings of a table, (mm) and (%/h), are then converted. Labels are shared out evenly over the rod as it
is at the end."""

import subprocess
import tempfile

import h5py
import numpy as np

from .command import Parser
from .errors import TendrilError
from .loading import load
from .readers import heading
from .runs import executable
from .tables import Wanted, body_of, named, plain_name, under
from .units import METRES, TIMES, quantity, rate_called, unit_called

# Gauss points on [0, 1] and their weights
POINTS, WEIGHTS = (np.polynomial.legendre.leggauss(4) + np.array([[1], [0]])) / 2
FINE = 4  # marks followed for each label of the table
LARGEST = 2_000_000  # numbers of a table: 16 times as many are followed
MOST = 1e4  # a label that stretches more is worth a warning


class BadTable(TendrilError):
    """What is asked for cannot be, in one plain line."""


DISTANCES = ("distance", "d", "position", "distance from tip", "distance from the tip", "distance from clamp", "distance from the clamp",
             "dist", "x", "s")
RATES = ("rate", "relative rate", "regr", "rer", "elongation rate", "relative elongation rate", "strain rate", "growth rate",
         "relative growth rate", "rate of elongation")
FILES = (".csv", ".tsv", ".tab", ".txt", ".dat", ".xlsx")


def read_rate(path, length_unit, time_unit):
    """(distances, rates, notes) of a table, in the units of the rod's length and of the end."""
    wanted = {"distance": Wanted("length", DISTANCES), "rate": Wanted("rate", RATES)}
    try:
        table, rest = named(path, wanted, lambda found: len(found) == 2)
        if table is None:
            wanted, rest = two_columns(path, *rest)
            table, _ = named(path, wanted, lambda found: len(found) == 2, given=rest)
    except TendrilError as error:
        raise BadTable(f"--rate {str(error).partition('; else give --scale')[0]}") from None
    distance, rate = table.columns["distance"], table.columns["rate"]
    if distance.unit and not length_unit:
        raise BadTable(f"--rate {path}: {distance.name} is in {distance.unit}: give --length with its unit, --length 20{distance.unit}")
    share, per = rate_called(rate.unit or "1")
    if per and not time_unit:
        raise BadTable(f"--rate {path}: {rate.name} is per {per}: give --end with its unit, --end 5{per}")
    d = distance.numbers * (METRES[distance.unit] / METRES[length_unit] if distance.unit else 1)
    r = rate.numbers * share * (TIMES[time_unit] / TIMES[per] if per else 1)
    if len(d) < 2:
        raise BadTable(f"--rate {path}: give two columns, distance and rate, and two rows at least")
    if d[0] != 0 or np.any(np.diff(d) <= 0):
        k = 0 if d[0] != 0 else int(np.argmax(np.diff(d) <= 0)) + 1
        raise BadTable(f"--rate {path}, line {table.lines[k]}: distances must rise from 0")
    return d, r, table.notes


def two_columns(path, rows, notes, comments):
    """(what is wanted, rows) of a table of two columns with other names, or none."""
    first, full = body_of(rows)
    heads = next((row for row in reversed(rows[:first]) if sum(bool(cell.strip()) for cell in row) == 2), None)
    if len(full) != 2:
        raise BadTable(f"--rate {path}: give two columns, distance and rate, and two rows at least")
    if heads is None:
        names = ["distance", "rate"]
        rows = under(names, rows)
    else:
        names = [plain_name(heading(heads[k] if k < len(heads) else "")[0]) for k in full]
    return {"distance": Wanted("length", (names[0],)), "rate": Wanted("rate", (names[1],))}, (rows, notes, comments)


def make_rate(text, length_unit="", time_unit=""):
    """r(d, t, L)"""
    if text.lower().endswith(FILES):
        distance, rate, notes = read_rate(text, length_unit, time_unit)
        for note in notes:
            print(f"growth_table: {note}")
        return lambda d, t, length: np.interp(d, distance, rate)
    names = {name: getattr(np, name) for name in dir(np) if not name.startswith("_")}

    def rate(d, t, length):
        try:
            with np.errstate(all="ignore"):
                value = eval(text, {"__builtins__": {}}, dict(names, d=d, t=t, L=length))
            return np.broadcast_to(np.asarray(value, float), np.shape(d))
        except Exception as error:
            raise BadTable(f"--rate {text}: {error}") from None

    return rate


def checked(rate):
    def value(d, t, length):
        r = rate(d, t, length)
        if not np.all(np.isfinite(r)):
            at = float(np.asarray(d)[~np.isfinite(r)].flat[0])
            raise BadTable(f"--rate: is not finite at d = {at:.4g}, t = {t:.4g}")
        return r

    return value


def speed(rate, d, t):
    """int_0^d rate, at distances that rise from 0 to the length of the rod."""
    gap = np.diff(d)
    inside = d[:-1, None] + gap[:, None] * POINTS
    return np.concatenate([[0], np.cumsum(gap * (rate(inside, t, d[-1]) @ WEIGHTS))])


def step(rate, d, log, t, h):
    """One step of Runge and Kutta's: distances, and the logarithm of their stretch."""
    def slope(d, t):
        return speed(rate, d, t), rate(d, t, d[-1])

    k1 = slope(d, t)
    k2 = slope(d + h / 2 * k1[0], t + h / 2)
    k3 = slope(d + h / 2 * k2[0], t + h / 2)
    k4 = slope(d + h * k3[0], t + h)
    move = [h / 6 * (a + 2 * b + 2 * c + e) for a, b, c, e in zip(k1, k2, k3, k4)]
    return d + move[0], log + move[1]


def final_length(rate, length, end, steps):
    """dL/dt is the speed at the other end; Runge and Kutta's method."""
    def slope(length, t):
        return speed(rate, np.linspace(0, length, 1001), t)[-1]

    h = end / steps
    for t in h * np.arange(steps):
        k1 = slope(length, t)
        k2 = slope(length + h / 2 * k1, t + h / 2)
        k3 = slope(length + h / 2 * k2, t + h / 2)
        length += h / 6 * (k1 + 2 * k2 + 2 * k3 + slope(length + h * k3, t + h))
        if not length > 0:
            raise BadTable("the rod shrinks to nothing")
    return length


def follow_back(rate, d, end, steps):
    """Marks from the end back to t = 0: (distances, log of the stretch) at all steps."""
    log, h = np.zeros_like(d), -end / steps
    path = [(d, log)]
    for k in range(steps):
        d, log = step(rate, d, log, end + k * h, h)
        if np.any(np.diff(d) <= 0):
            raise BadTable("the marks get out of order: the rate is too steep for these steps, give "
                           "more --times")
        path.append((d, log))
    return path


def make_table(rate, length, end, labels, times, side):
    """s, t, g, p (where the labels are), and the relative error of the way there and back."""
    marks, each = FINE * (labels - 1) + 1, FINE
    last = final_length(rate, length, end, each * (times - 1))
    back = follow_back(rate, np.linspace(0, last, marks), end, each * (times - 1))
    back = back[::-each]  # at the times of the table
    d = np.array([path[0][::FINE] for path in back])
    g = last * np.exp([path[1][::FINE] for path in back])
    error = abs(d[0, -1] / length - 1)
    if side == "tip":
        p, g = (d[:, -1:] - d)[:, ::-1], g[:, ::-1]
    else:
        p = d
    return np.linspace(0, 1, labels), np.linspace(0, end, times), g, p, error


def compare(file, end, s, t, p):
    """Grows the straight rod of this table; the largest error of a place over the length."""
    tendril = executable()
    with tempfile.TemporaryDirectory() as scratch:
        output = f"{scratch}/run.h5"
        # friction does not move a straight rod; the times of four rows of the table
        command = [tendril, "-growth_type", "table", "-growth_table", str(file), "-shape_type",
                   "straight", "-ts_max_time", repr(end), "-output", output, "-output_interval",
                   repr(end / 4), "-quiet"]
        try:
            done = subprocess.run(command, capture_output=True, text=True)
        except OSError as error:
            raise BadTable(f"--check: {tendril}: {error.strerror}") from None
        if done.returncode:
            raise BadTable(f"--check: {done.stderr.strip()}")
        r = load(output)
    worst = 0
    for time, x, g in zip(r.shapes.t, r.shapes.x, r.shapes.stretch):
        k = int(np.argmin(np.abs(t - time)))
        if abs(t[k] - time) > 1e-6 * end:
            continue
        i = np.clip(np.searchsorted(r.shapes.s, s) - 1, 0, len(r.shapes.s) - 2)
        h = r.shapes.s[i + 1] - r.shapes.s[i]
        b = (s - r.shapes.s[i]) / h
        a = 1 - b  # Hermite's cubic
        places = (a * a * (1 + 2 * b) * x[i, 0] + b * b * (1 + 2 * a) * x[i + 1, 0]
                  + a * b * h * (a * g[i] - b * g[i + 1]))
        worst = max(worst, np.abs(places - p[k]).max() / p[k, -1])
    return worst


def with_unit(text, kind, known):
    """(number, unit) of 2 or "20mm"."""
    found = quantity(text)
    unit = unit_called(found[1], kind) if found and found[1] else ""
    if not found or unit is None or not 0 < found[0] < np.inf:
        raise BadTable(f"--{'length' if kind == 'length' else 'end'} {text}: give a number above 0, or one with {', '.join(known)}")
    return found[0], unit


def arguments_of(words):
    parser = Parser("scripts/growth_table.sh", __doc__)
    parser.add_argument("file", help="the table to write, HDF5")
    parser.add_argument("--length", required=True, metavar="L0", help="length at t = 0, a number or with its unit, 20mm")
    parser.add_argument("--end", required=True, metavar="T",
                        help="last time of the table: -ts_max_time of the run, or later; a number or with its unit, 5h")
    parser.add_argument("--rate", required=True, metavar="EXPRESSION|FILE.csv",
                        help="relative rate of elongation over the distance d")
    parser.add_argument("--from", choices=("tip", "clamp"), default="tip", dest="side",
                        help="where distances are counted from; default %(default)s")
    parser.add_argument("--labels", type=int, default=201, help="default %(default)s")
    parser.add_argument("--times", type=int, default=101, help="default %(default)s")
    parser.add_argument("--unit", action="store_true",
                        help="multiplies the rate so that dL/dt = 1 at t = 0")
    parser.add_argument("--check", action="store_true",
                        help="grows the straight rod with it by build/tendril, and compares")
    choice = parser.parse_args(words)
    choice.length, choice.length_unit = with_unit(choice.length, "length", METRES)
    choice.end, choice.time_unit = with_unit(choice.end, "time", TIMES)
    if choice.unit and (choice.length_unit or choice.time_unit):
        raise BadTable("--unit: makes dL/dt 1 in numbers without units; give --length and --end without them, or leave it out")
    if choice.labels < 4 or choice.times < 4:
        raise BadTable("--labels and --times: give 4 at least")
    if choice.labels * choice.times > LARGEST:
        raise BadTable(f"--labels and --times: a table of {choice.labels} x {choice.times}; {LARGEST} numbers are the most")
    if (choice.times - 1) % 4:
        choice.times += 4 - (choice.times - 1) % 4  # a row at each quarter
    return choice


def write(file, s, t, g, length_unit="", time_unit=""):
    with h5py.File(file, "w") as f:
        f["s"], f["t"], f["g"] = s, t, g
        for name, unit in (("t", time_unit), ("g", length_unit)):
            if unit:
                f[name].attrs["units"] = unit


def make(choice):
    rate = checked(make_rate(choice.rate, choice.length_unit, choice.time_unit))
    if choice.unit:
        first = speed(rate, np.linspace(0, choice.length, 1001), 0)[-1]
        if not first > 0:
            raise BadTable("--unit: the rod does not lengthen at t = 0")
        plain = rate
        rate = lambda d, t, length: plain(d, t, length) / first  # noqa: E731
    s, t, g, p, error = make_table(rate, choice.length, choice.end, choice.labels, choice.times,
                                   choice.side)
    write(choice.file, s, t, g, choice.length_unit, choice.time_unit)
    length = p[:, -1]
    slope = np.gradient(length, t, edge_order=2)
    stretch = g.max(axis=0) / g.min(axis=0)
    in_length = f" {choice.length_unit}" if choice.length_unit else ""
    in_speed = f"{in_length}/{choice.time_unit}" if in_length and choice.time_unit else ""
    print(f"growth_table: {choice.file}: {len(t)} times, {len(s)} labels; length {length[0]:.6g} to "
          f"{length[-1]:.6g}{in_length}, dL/dt {slope[0]:.4g} to {slope[-1]:.4g}{in_speed}")
    print(f"growth_table: labels stretch by {stretch.min():.3g} to {stretch.max():.3g}; error "
          f"{error:.1e}")
    if stretch.max() > MOST:
        print("growth_table: that is much: steps have to follow it; for a zone behind the tip take "
              "-growth_type apical")
    if choice.check:
        with tempfile.TemporaryDirectory() as scratch:  # the numbers alone, of a rod without units
            bare = f"{scratch}/table.h5"
            write(bare, s, t, g)
            worst = compare(bare, choice.end, s, t, p)
        print(f"growth_table: the straight rod of a run is where it should be to {worst:.1e} of its "
              "length")


def main(words=None):
    make(arguments_of(words))
    return 0

"""Units: those of a file's numbers in the laboratory, and those of pictures, of a size that suits the
run."""

from __future__ import annotations

import contextlib
import re
from copy import copy

import numpy as np

from .errors import ResultsError, TendrilError

# (name, in SI, the least that is told in it), the larger first
SHOWN = {
    "length": (("m", 1, 1), ("cm", 1e-2, 1e-2), ("mm", 1e-3, 1e-3), ("µm", 1e-6, 0)),
    "time": (("h", 3600, 36000), ("min", 60, 600), ("s", 1, 0.1), ("ms", 1e-3, 0)),
    "speed": (("m/s", 1, 1), ("cm/s", 1e-2, 1e-2), ("mm/s", 1e-3, 1e-3), ("µm/s", 1e-6, 0)),
    "force": (("N", 1, 1), ("mN", 1e-3, 1e-3), ("µN", 1e-6, 0)),
    "energy": (("J", 1, 1), ("mJ", 1e-3, 1e-3), ("µJ", 1e-6, 1e-6), ("nJ", 1e-9, 0)),
    "power": (("W", 1, 1), ("mW", 1e-3, 1e-3), ("µW", 1e-6, 1e-6), ("nW", 1e-9, 0)),
}
# the series whose largest value decides
DECIDES = {"length": ["length"], "time": ["t"], "force": ["base_force_1", "base_force_2"],
           "energy": ["energy"], "power": ["growth_power", "dissipation"],
           "speed": ["tip_speed", "mid_speed"]}
# as the program has them (src/base/options_units.c); a Fr, French, is of diameters
METRES = {"m": 1.0, "cm": 1e-2, "mm": 1e-3, "um": 1e-6, "in": 0.0254, "ft": 0.3048, "mil": 25.4e-6, "Fr": 1e-3 / 3}
TIMES = {"ms": 1e-3, "s": 1, "min": 60, "h": 3600, "d": 86400}
ANGLES = {"deg": np.pi / 180, "rad": 1.0, "grad": np.pi / 200}
# how others write them, in small letters
SPELT = {word: unit for unit, words in {
    "m": "metre meter metres meters mtr", "cm": "centimetre centimeter centimetres centimeters",
    "mm": "millimetre millimeter millimetres millimeters", "um": "micron microns micrometre micrometer micrometres micrometers",
    "in": "inch inches \"", "ft": "foot feet '", "mil": "mils thou", "Fr": "french charriere", "s": "sec secs second seconds",
    "ms": "msec millisecond milliseconds", "min": "minute minutes mins", "h": "hr hrs hour hours", "d": "day days",
    "deg": "degree degrees \u00b0 \u00ba dega degs", "rad": "radian radians", "grad": "gon gons grads"}.items()
    for word in words.split()}
OF_KIND = {"length": METRES, "time": TIMES, "angle": ANGLES}
PIXEL = "px"
PIXELS = (PIXEL, "pixel", "pixels")
PER = {over + unit: METRES[unit] for unit in ("m", "cm", "mm", "in", "ft") for over in ("/", "1/")}  # of curvatures
# a unit of the file as powers of the scales of the laboratory, and its name in SI
DIMENSIONS = {
    "l": ({"length": 1}, "m"), "l/V": ({"time": 1}, "s"), "V": ({"speed": 1}, "m/s"),
    "N l": ({"force": 1}, "N"), "N l^2": ({"energy": 1}, "J"), "N l V": ({"power": 1}, "W"),
    "1/l": ({"length": -1}, "1/m"), "l^(3/2)": ({"length": 1.5}, "m^(3/2)"),
    "V/l": ({"time": -1}, "1/s"), "rad V/l": ({"time": -1}, "rad/s"),
    "N": ({"force": 1, "length": -1}, "N/m"),
}
KINDS = {"l": "length", "l/V": "time", "V": "speed", "N l": "force", "N l^2": "energy",
         "N l V": "power"}
# of what is measured: name of a unit -> (unit of the file, what 1 of it is in SI)
MEASURED = {name: (unit, si) for unit, kind in KINDS.items() if kind != "time" for name, si, _ in SHOWN[kind]}
MEASURED |= {name.replace("µ", "u"): value for name, value in MEASURED.items()}
MEASURED |= {name: ("l", si) for name, si in METRES.items()}
MEASURED |= {name: ("l/V", si) for name, si in TIMES.items()}
MEASURED |= {f"{length}/{time}": ("V", METRES[length] / TIMES[time]) for length in METRES for time in ("s", "min", "h", "d")}
MEASURED |= {over + unit: ("1/l", 1 / si) for over in ("/", "1/") for unit, (kind, si) in list(MEASURED.items()) if kind == "l"}
MEASURED |= {"rad": ("rad", 1), "deg": ("rad", np.pi / 180), "": ("", 1), "1": ("", 1), PIXEL: (PIXEL, 1)}


def in_laboratory(unit, scale):
    """(factor, SI unit) of a unit of the file. scale: a function from a kind, "length", to what 1 of
    it is in SI units. Angles, labels and counts stay as they are."""
    if unit not in DIMENSIONS:
        return 1.0, unit
    powers, name = DIMENSIONS[unit]
    return float(np.prod([scale(kind) ** power for kind, power in powers.items()])), name


# what units of options are made of, in SI
PARTS = {"N": 1, "mN": 1e-3, "uN": 1e-6, "Pa": 1, "mPa": 1e-3, **METRES, **TIMES, "kg": 9.80665, "g": 9.80665e-3}  # masses as weights
QUANTITY = re.compile(r"\s*([-+]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][-+]?[0-9]+)?)\s*((?![0-9.\s]).*?)\s*")
PART = re.compile(rf"({'|'.join(sorted(PARTS, key=len, reverse=True))})(?:\^([0-9]))?")


def quantity(text):
    """(number, unit) of 0.5, "0.5" or "0.5 N/m"; None for what is none."""
    found = QUANTITY.fullmatch(str(text))
    return (float(found[1]), found[2].replace(" ", "")) if found else None


def with_unit(value):
    """The same, of what must be one."""
    found = quantity(value)
    if not found:
        raise TendrilError(f"{value}: give a number, or one with a unit")
    if re.match(",[0-9]", found[1]):
        raise TendrilError(f"{value}: give a number with a point, {str(value).strip().replace(',', '.', 1)}")
    return found


def in_si(unit):
    """What 1 of a unit is in SI, "Nmm^2" or "mm/h"; None for what is no unit."""
    over, _, under = unit.partition("/")
    factor = 1.0
    for words, sign in ((over, 1), (under, -1)):
        parts = PART.findall(words)
        if "".join(name + (f"^{power}" if power else "") for name, power in parts) != words.removeprefix("1"):
            return None
        for name, power in parts:
            factor *= PARTS[name] ** (sign * int(power or 1))
    return factor


def unit_called(text, kind):
    """The name tendril has for a unit of "length", "time" or "angle", of "\u00b5m", "Feet" or "MM"; None for what is none."""
    word = str(text).strip().strip(".").replace("\u00b5", "u").replace("\u03bc", "u")
    for name in (word, SPELT.get(word.lower()), word.lower(), "Fr" if word.lower() == "fr" else None):
        if name in OF_KIND[kind]:
            return name
    return None


def rate_called(text):
    """(what 1 of it is, the time it is per) of a relative rate, "%/h", "h^-1" or "percent per hour"; "" for a time that it does
    not say. None for what is none."""
    word = re.sub(r"\s*\bper\b\s*", "/", str(text).strip().lower()).replace("percent", "%").replace("\u207b\u00b9", "-1")
    word = re.sub(r"^(%|1)?[\s\u00b7*.]*([a-z]+)\s*\^?\s*\(?-1\)?$", r"\1/\2", word)
    share, *per = [part.strip() for part in word.split("/")]
    if len(per) == 2 and share == per[0] and unit_called(share, "length"):  # mm/mm/h
        share, per = "1", per[1:]
    if share not in ("%", "1", "") or len(per) > 1 or (per and not unit_called(per[0], "time")):
        return None
    return 0.01 if share == "%" else 1.0, unit_called(per[0], "time") if per else ""


def length_unit(text, what, refusal=TendrilError):
    """The name of a unit of length as tendril has it; "" for none."""
    name = unit_called(text or "", "length")
    if text and not name:
        raise refusal(f"{what} {text}: not a unit of length; give one of {', '.join(METRES)}, or none")
    return name or ""


def length_in(value, unit, what, refusal=TendrilError):
    """A length as a number of a unit: of 0.1 itself, of "4in" by both units; None for None."""
    if value is None:
        return None
    found = quantity(value)
    if not found:
        raise refusal(f"{what} {value}: give a number, or one with a unit of length: {', '.join(METRES)}")
    number, own = found[0], unit_called(found[1], "length") if found[1] else ""
    if own is None:
        raise refusal(f"{what} {value}: not a unit of length; give a number, or one with {', '.join(METRES)}")
    if own and not unit:
        raise refusal(f"{what} {value}: the result has no unit; give it one, --unit {own}, or a bare number")
    return number * METRES[own] / METRES[unit] if own else number


def parameters_of(options):
    """{"parameters/NAME": number, ...} as a result file has it, from options as text: plain numbers, and
    what -si_ options say of the rod."""
    found = {}
    for name, text in options.items():
        number = quantity(text)
        if number and not number[1]:
            found[f"parameters/{name}"] = number[0]
        elif number and name.startswith("si_") and in_si(number[1]):
            found[f"parameters/{name}"] = number[0] * in_si(number[1])
    return found


def scales_of_rod(attributes):
    """{"length": what 1 is in m, ...} from the rod's own -si_ values, for files that keep only
    these (of -task critical)."""
    stiffness, dry, viscous, speed = (attributes.get(f"parameters/si_{name}") for name in (
        "bending_stiffness", "friction_dry", "friction_viscous", "speed"))
    friction = (dry or 0) + (viscous or 0) * (speed or 0)
    if not (stiffness and friction):
        return {}
    length = (stiffness / friction) ** (1 / 3)
    scales = {"length": length, "force": friction * length, "energy": friction * length**2,
              "curvature": 1 / length}
    if speed:
        scales |= {"speed": speed, "time": length / speed, "power": friction * length * speed}
    return scales


def scale_of(results, kind):
    """What 1 of it is in SI units, None if the files do not say so; they must not differ."""
    found = {r.attributes.get(f"si_{kind}", scales_of_rod(r.attributes).get(kind)) for r in results}
    if len(found) > 1:
        raise ResultsError(f"{results[0].told}: the files differ in their scale of {kind}")
    return found.pop()


def moment(option, text, results):
    """A time as the file counts it, from a number, "12.5" or, of a run in the laboratory, "20s"."""
    text = str(text).strip()
    with contextlib.suppress(ValueError):
        return float(text)
    value, said = quantity(text) or (0.0, "")
    unit = unit_called(said, "time")
    if not unit:
        raise ResultsError(f"{option} {text}: give a time, a number or one with {', '.join(TIMES)}")
    scale = scale_of(results, "time")
    if scale is None:
        raise ResultsError(f"{option} {text}: {results[0].told} does not know its seconds; give a "
                        "number, or run it with -si_speed and the like")
    return value * TIMES[unit] / scale


def briefly(value):
    """A number with two digits, 120 rather than 1.2e+02."""
    return f"{float(f'{value:.2g}'):g}"


def suited_to(kind, most):
    """(name, what 1 of it is in SI units) of the unit that suits a largest value, in SI units."""
    return next((u for u in SHOWN[kind] if most >= u[2] * (1 - 1e-9)), SHOWN[kind][0])[:2]


def suited(kind, results):
    """The same for the largest value of these runs."""
    largest = [r.scale(kind) * np.abs(a[np.isfinite(a)]).max(initial=0) for r in results
               for name, a in r.series.items() if name in DECIDES[kind]]
    return suited_to(kind, max(largest, default=1))


def laboratory_units(results):
    """{"l": ("cm", what 1 of it is in SI units), ...}: units of the file in the laboratory, of a size
    that suits these runs, whose scales may differ. A unit that one of them cannot tell in SI is left
    out; nothing remains if not all runs are in the laboratory."""
    found = {}
    for unit, (_, name) in DIMENSIONS.items():
        with contextlib.suppress(ResultsError):
            for r in results:
                in_laboratory(unit, r.scale)
            found[unit] = suited(KINDS[unit], results) if unit in KINDS else (name, 1)
    return found


def in_laboratory_of(results, si=None, who="plot") -> list:
    """The runs whose own units a picture of them has: all, or none.

    si  None: all, if they are in the laboratory; True: all; False: none. Where some are in the laboratory and some are
        not it is refused: their lengths could not be compared"""
    without = [r for r in results if scale_of([r], "length") is None]
    if si is False or not results or si is None and len(without) == len(results):
        return []
    if len(without) == len(results):
        raise ResultsError(f"{without[0].told}: si needs a run in the laboratory, with si_bending_stiffness and the like")
    for kind, of in (("length", without), ("time", [r for r in results if scale_of([r], "time") is None])):
        if of and len(of) < len(results):
            other = next(r for r in results if all(r is not one for one in of))
            raise ResultsError(f"{who}: {other.told} knows its {kind} in SI units and {of[0].told} does not: they cannot be drawn "
                               "together; dimensionless, each is drawn in its own (--dimensionless)")
    return list(results)


def add_choice_of_units(parser):
    """The options of a command that draws: its .si is None, True or False, as in_laboratory_of() takes it."""
    parser.add_argument("--si", action="store_true", default=None,
                        help="in centimetres, newtons, seconds and the like, as runs with -si_ options are drawn anyway")
    parser.add_argument("--dimensionless", dest="si", action="store_false", default=None,
                        help="as the files have it, also of such runs, each in its own unit of length")


class Units:
    """What the numbers of the files are multiplied by, and the unit they then have: none, or with results given those of
    the laboratory, of a size that suits them all; at(r): of that run, by its own scales."""

    def __init__(self, results=()):
        self.results = in_laboratory_of(results, True) if results else []
        self.shown = {kind: suited(kind, self.results) for kind in SHOWN
                      if results and all(scale_of([r], kind) is not None for r in self.results)}
        self.own = self.results[0] if self.results else None

    def at(self, r) -> Units:
        """Those of one of the runs."""
        own = copy(self)
        own.own = r if self.results else None
        return own

    @property
    def scales(self):
        """{kind: (factor, name)}; without -si_speed time has no scale and stays a bare number."""
        found = dict.fromkeys(SHOWN, (1.0, ""))
        for kind, (name, si) in self.shown.items():
            found[kind] = float(scale_of([self.own], kind)) / si, name
        if self.results and not found["power"][1]:
            # a power per unit of t: the time it is per stays a bare number
            found["power"] = found["energy"][0], f"{found['energy'][1]} per unit of $t$"
        return found

    def unit(self, unit):
        """(factor, name) of a unit of the file: the name is empty for bare numbers."""
        if unit in KINDS:
            return self.scales[KINDS[unit]]
        if self.results:
            with contextlib.suppress(ResultsError):
                factor, name = in_laboratory(unit, self.own.scale)
                return factor, "" if name == "1" else name
        return 1.0, "rad" if unit == "rad" else ""

    def of(self, kind, values):
        return self.scales[kind][0] * np.asarray(values) if kind else np.asarray(values)

    def plain(self, t, form=".4g"):
        """A time in words."""
        unit = self.scales["time"][1]
        return f"t = {self.of('time', t):{form}}" + (f" {unit}" if unit else "")

    def time(self, t):
        """A time in words, typeset."""
        unit = self.scales["time"][1]
        return rf"$t = {self.of('time', t):.4g}$" + (f" {unit}" if unit else "")

    def label(self, text, kind):
        unit = self.scales[kind][1] if kind else ""
        return f"{text} ({unit})" if unit else text

"""The units of pictures: none, or those of the laboratory, of a size that suits the run."""

import contextlib
import re

import numpy as np

from .results import ResultsError

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
           "energy": ["energy", "growth_power"], "power": ["growth_power"]}
TIMES = {"ms": 1e-3, "s": 1, "min": 60, "h": 3600, "d": 86400}


def scale_of(results, kind):
    """What 1 of it is in SI units, None if the files do not say so; they must not differ."""
    found = {r.attributes.get(f"si_{kind}") for r in results}
    if len(found) > 1:
        raise ResultsError(f"{results[0].path}: the files differ in their scale of {kind}")
    return found.pop()


def moment(option, text, results):
    """A time as the file counts it, from "12.5" or, of a run in the laboratory, "20s"."""
    number, unit = re.fullmatch(r"(.*?)\s*([a-z]*)", text.strip(), re.DOTALL).groups()
    with contextlib.suppress(ValueError):
        return float(text)
    try:
        value = float(number)
    except ValueError:
        value = None
    if value is None or unit not in TIMES:
        raise ResultsError(f"{option} {text}: give a time, a number or one with {', '.join(TIMES)}")
    scale = scale_of(results, "time")
    if scale is None:
        raise ResultsError(f"{option} {text}: {results[0].path} does not know its seconds; give a "
                           "number, or run it with -si_speed and the like")
    return value * TIMES[unit] / scale


class Units:
    """What the numbers of the files are multiplied by, and the unit they then have: none, or with
    results given (--si) those of a run that was given a physical rod."""

    def __init__(self, results=()):
        self.scales = dict.fromkeys(SHOWN, (1.0, ""))
        for r in results:
            if "si_length" not in r.attributes:
                raise ResultsError(f"{r.path}: --si needs a run with -si_bending_stiffness ...")
        for kind in SHOWN if results else ():
            scale = scale_of(results, kind)
            if scale is not None:  # without -si_speed time has no scale and stays a bare number
                self.scales[kind] = self.suited(kind, float(scale), results)
        if results:
            self.share_prefix(results)

    def share_prefix(self, results):
        """Energy and power are drawn on one axis: with the larger prefix of the two."""
        units = [self.scales[kind][1] for kind in ("energy", "power")]
        if not units[1]:
            self.scales["power"] = (self.scales["energy"][0], f"{units[0]} per unit of $t$")
            return
        prefix = min(("", "m", "µ", "n").index(unit[:-1]) for unit in units)
        for kind in ("energy", "power"):
            name, si, _ = SHOWN[kind][prefix]
            self.scales[kind] = (float(scale_of(results, kind)) / si, name)

    @staticmethod
    def suited(kind, scale, results):
        series = [np.abs(r.series[name]) for r in results for name in DECIDES.get(kind, ())
                  if name in r.series]
        most = max((a[np.isfinite(a)].max(initial=0) for a in series), default=1) * scale
        name, si, _ = next((u for u in SHOWN[kind] if most >= u[2] * (1 - 1e-9)), SHOWN[kind][0])
        return scale / si, name

    def of(self, kind, values):
        return self.scales[kind][0] * np.asarray(values)

    def plain(self, t, form=".4g"):
        """A time in words."""
        unit = self.scales["time"][1]
        return f"t = {self.of('time', t):{form}}" + (f" {unit}" if unit else "")

    def time(self, t):
        """A time in words, typeset."""
        unit = self.scales["time"][1]
        return rf"$t = {self.of('time', t):.4g}$" + (f" {unit}" if unit else "")

    def label(self, text, kind):
        unit = self.scales[kind][1]
        return f"{text} ({unit})" if unit else text

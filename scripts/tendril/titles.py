"""What runs are called in a picture."""

from __future__ import annotations

from .naming import options_in
from .units import quantity

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
    points = [options_in(r.name) for r in runs]
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

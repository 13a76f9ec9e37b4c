"""The page from which a live run begins: scenes of the gallery by their pictures, and a form of what a first scene needs, drawn
before it runs."""

from __future__ import annotations

import re
import tempfile
from pathlib import Path

import numpy as np

from .dropped import made
from .errors import RunError, TendrilError
from .playing import NUMBER, prepare
from .runs import CHECKOUT

# what a run by steps cannot do, or takes too long for a first look
LEFT_OUT = re.compile(r"critical|stability|paper|injected")
SECTION = re.compile(r"^\s*\[", re.MULTILINE)  # of several rods, which a run by steps does not have
# (option, label, usual, unit, what it does)
FIELDS = (
    ("si_bending_stiffness", "bending stiffness", "1e-5", "N m²", "of the rod: Young's modulus times the second moment of area"),
    ("si_friction_dry", "dry friction", "0.4", "N/m", "that holds the rod back, per length"),
    ("si_speed", "speed of feeding", "0.01", "m/s", "at which it is pushed in at the clamp, or grows"),
    ("growth_type", "how it grows", "feed", "", "pushed in at the clamp, all along, or at its tip"),
    ("growth_initial_length", "length at the start", "0.02", "m", "in front of the clamp"),
    ("contact_diameter", "diameter", "0.002", "m", "of the rod; walls meet its surface"),
    ("clamp_angle", "direction of the clamp", "0", "deg", "against the first axis"),
    ("rod_curvature", "natural curvature", "0.5", "1/m", "no rod is quite straight; it says to which side this one bends"),
    ("rod_weight", "weight", "0", "N/m", "per length, downwards"),
    ("ts_max_time", "time", "20", "s", "how long it is fed or grows"),
    ("rod_cells", "cells", "200", "", "more are finer, and slower"),
)
MOST_POSTS = 20
CHOICES = {"growth_type": ("feed", "uniform", "apical")}
WALLS = """# a wall a line, lengths with units; the clamp is at 0 0
circle 6cm 1.1cm 8mm outside
circle 9cm -1.1cm 8mm outside
"""
# of walls; another word would name a file, and none of the host's is read for a page
WORDS = frozenset("plane circle polygon path sphere cylinder cone torus tube body inside outside friction radius moves turns at spin about".split())


class FieldError(TendrilError):
    """A mistake in one field of the form."""

    def __init__(self, text, field):
        super().__init__(text)
        self.field = field


def scenes() -> dict[str, Path]:
    """Scenes of the gallery by name."""
    for place in (Path(__file__).parent / "options", CHECKOUT / "options"):
        found = {file.stem: file for file in sorted(place.glob("*.opts")) if not LEFT_OUT.search(file.stem) and not SECTION.search(file.read_text(errors="replace"))}
        if found:
            return found
    return {}


def picture_file(name) -> Path | None:
    """The picture of a scene of the gallery, by its name alone."""
    stem = name[:-4] if name.endswith(".png") else ""
    if stem not in scenes():
        return None
    for place in (Path(__file__).parent / "options/pictures", CHECKOUT / "options/pictures"):
        if (place / name).is_file():
            return place / name
    return None


def gallery() -> list[dict]:
    """What the page shows of each scene: its name, and how its file begins."""
    found = []
    for name, file in scenes().items():
        words = []
        for line in file.read_text(errors="replace").splitlines():
            if not line.startswith("#"):
                break
            words.append(line.lstrip("# "))
        text = re.split(r"(?<=[.:;])\s(?![^(]*\))", " ".join(words))[0].rstrip(":;")
        found.append({"name": name, "text": text, "picture": picture_file(f"{name}.png") is not None})
    return found


def first_scene() -> dict:
    """The form."""
    return {"fields": [{"name": name, "label": label, "value": value, "unit": unit, "about": about, "choices": CHOICES.get(name)}
                       for name, label, value, unit, about in FIELDS], "walls": WALLS}


def options_of(form, directory, dropped={}) -> dict:
    """The options that the form says; a mistake names its field.

    dropped  files of walls by the names that they have in the form"""
    options = {}
    for name, label, _, unit, _ in FIELDS:
        text = str(form.get(name, "")).strip()[:60]
        if name in CHOICES:
            if text not in CHOICES[name]:
                raise FieldError(f"{label}: choose one of {', '.join(CHOICES[name])}", name)
            options[name] = text
            continue
        if not text or text == "0" and name in ("rod_weight", "clamp_angle", "rod_curvature"):
            continue
        if not re.fullmatch(rf"{NUMBER.pattern}(\s*[A-Za-z/^0-9]+)?", text):
            raise FieldError(f"{label}: {text!r} is no number; write one, with a point, and with a unit if it is not {unit or 'alone'}", name)
        has_unit = re.search(r"[A-DF-Za-df-z]", text)
        plain = {"N m²": "Nm^2"}.get(unit, unit)
        value = text.replace(" ", "") if has_unit or not plain else f"{text}{plain}"
        options[name] = f"0,-{value}" if name == "rod_weight" else value
    walls = str(form.get("walls", ""))
    if any(line.partition("#")[0].split() for line in walls.splitlines()):
        for k, line in enumerate(walls.splitlines(), 1):
            for word in line.partition("#")[0].replace(",", " ").split():
                if word not in WORDS and word not in dropped and not re.fullmatch(rf"{NUMBER.pattern}([a-zA-Zµ°]+([/^]-?\w+)*)?", word):
                    raise FieldError(f"walls, line {k}: {word[:40]!r} is neither a number nor a word of a wall, nor a file that was dropped here",
                                     "walls")
        file = Path(directory) / "walls.txt"
        file.write_text("\n".join(" ".join(str(dropped.get(word, word)) for word in line.split(" ")) for line in walls.split("\n")) + "\n")
        options["wall_file"] = str(file)
    else:
        options.pop("contact_diameter", None)
    return options


def field_of(text):
    """Which field a line of tendril's is about, by the option that it names."""
    if "wall_file" in text:
        return "walls"
    for name, *_ in FIELDS:
        if re.search(rf"\b{name}\b", text):
            return name
    return None


def drawing(options) -> dict:
    """What a scene looks like before it runs: the rod, the clamp, the walls, in metres."""
    from .sessions import Session, drawn_walls

    with tempfile.TemporaryDirectory(prefix="tendril-") as directory:
        played = prepare(None, options, directory)
        session = Session(played, directory)
        sim, r = session.sim, session.setup
        length = r.scale("length") if "si_length" in r.attributes else 1.0
        return {"kind": "drawn", "x": np.ravel(np.round(sim.nodes["x"], 8)).tolist(), "space": session.space, "walls": drawn_walls(session), "diameter": float(r.diameter),
                "length": length, "end": float(r.attributes.get("parameters/ts_max_time", 0)), "cells": len(sim.s) - 1,
                "told": told(r)}


def told(r):
    """In words, what the scales of the scene are."""
    if "si_length" not in r.attributes:
        return ""
    length, force = r.scale("length"), r.scale("force")
    return (f"Bending and friction balance over {length * 100:.3g} cm: a rod much shorter stays straight, one longer buckles. "
            f"The force of friction over that length is {force:.3g} N.")


def posts_of(command):
    """How many stones the page asks for beside those of a scene; None: it does not say."""
    posts = command.get("posts")
    if posts is None:
        return None
    if isinstance(posts, bool) or not isinstance(posts, int) or not 0 <= posts <= MOST_POSTS:
        raise TendrilError(f"stones to put: give 0 to {MOST_POSTS}")
    return posts


def begin(server, command):
    """What the starting page asks for: a scene of the gallery, one of the form, or its drawing. What it answers."""
    if command["do"] == "home":
        return {"kind": "start", "gallery": gallery(), "form": first_scene(), "runs": server.session is not None}
    if "scene" in command:
        name = str(command["scene"])
        if name not in scenes():
            raise TendrilError(f"{name[:60]}: is no scene of the gallery")
        server.start(scenes()[name], posts=posts_of(command))
        return run_now(server)
    directory = Path(server.directory.name) / f"form-{server.runs}"
    directory.mkdir(exist_ok=True)
    if command["do"] == "file":
        try:
            found = made(directory, command, command["whole"])
        except TendrilError as fault:
            raise TendrilError(str(fault).replace(f"{directory}/", "")) from None
        server.dropped[found["name"]] = found.pop("path")
        return found
    form = command.get("form")
    if not isinstance(form, dict):
        raise TendrilError("there is no form")
    options = options_of(form, directory, server.dropped)
    try:
        if command["do"] == "draw":
            return drawing(options)
        server.start(None, posts=posts_of(command), **options)
    except RunError as fault:
        raise FieldError(str(fault), field_of(str(fault))) from None
    return run_now(server)


def run_now(server):
    """What was chosen on the page to begin from runs at once."""
    server.session.do({"do": "run"})

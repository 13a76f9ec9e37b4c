"""A scene that is run live: its options as a table, its walls by line, what may be changed in it, and how what was
changed becomes a scene file again."""

from __future__ import annotations

import re
import shutil
from dataclasses import dataclass, field
from pathlib import Path

from .errors import TendrilError
from .runs import rows_of, scene_file, texts_of
from .senses import number
from .simulation import Simulation

FILES = ("wall_file", "growth_path", "growth_table", "friction_field", "tip_field", "tip_path", "clamp_path",
         "rod_stiffness_file", "rod_curvature_file", "shape_file", "change_file")
OF_PROGRAM = ("output", "task", "quiet", "restart", "sweep_file", "sensitivity")  # none of a run by steps
MOVES = ("sphere", "cylinder", "cone", "torus", "tube", "body")  # with plane, if it has six numbers
NUMBER = re.compile(r"[-+]?(\d+\.?\d*|\.\d+)([eE][-+]?\d+)?")


@dataclass
class Wall:
    """A line of a wall file."""

    line: int
    words: list[str]

    @property
    def kind(self):
        return self.words[0]

    @property
    def numbers(self):
        """The words behind the kind up to the first that says how it moves or rubs."""
        found = []
        for word in self.words[1:]:
            if word in ("friction", "moves", "turns", "radius"):
                break
            if word not in ("inside", "outside"):
                found.append(word)
        return found

    @property
    def in_space(self):
        return self.kind in MOVES or self.kind == "plane" and len(self.numbers) >= 6

    @property
    def friction(self):
        where = [k for k, word in enumerate(self.words[:-1]) if word == "friction"]
        return float(self.words[where[-1] + 1]) if where and NUMBER.fullmatch(self.words[where[-1] + 1]) else None


@dataclass
class Played:
    """What a live run begins with.

    name     of the scene
    options  by name, as they are given; files with whole paths
    walls    the lines of its wall file"""

    name: str
    options: dict[str, str]
    walls: list[Wall] = field(default_factory=list)
    posts: list[int] = field(default_factory=list)  # lines of those that wait to be put somewhere

    @property
    def feeds(self):
        return self.options.get("growth_type", "uniform") == "feed"

    @property
    def held(self):
        return self.options.get("tip_type", "free")

    def number(self, name, usual):
        """The number of an option that has no unit, or the usual one."""
        text = self.options.get(name, "")
        return float(text) if NUMBER.fullmatch(text) else usual


def taken(file) -> dict[str, str]:
    """The options of an options file, those of files it names in their place."""
    found = {}
    for row in rows_of(file):
        name, value = row[0].lstrip("-"), (row[1] if len(row) > 1 else "true").strip("'\"")
        beside = Path(file).resolve().parent / value
        if name in FILES or name == "options_file":
            value = str(beside if beside.exists() else Path(value).resolve())
        if name == "options_file":
            found |= taken(value)
        else:
            found[name] = value
    return found


def walls_in(path) -> list[Wall]:
    lines = Path(path).read_text(errors="replace").splitlines()
    split = [line.partition("#")[0].replace(",", " ").split() for line in lines]
    return [Wall(k, words) for k, words in enumerate(split, 1) if words]


def prepare(scene, options, directory, posts=0) -> Played:
    """A scene, as for tendril.run(), as it is run live; files that are made are in the directory.

    posts  so many stand far away, to be put somewhere"""
    directory = Path(directory)
    found = {} if scene is None else texts_of(scene, directory) if isinstance(scene, dict) else taken(scene_file(scene))
    found |= texts_of(options, directory)
    if found.get("task", "grow") != "grow":
        raise TendrilError(f"live: -task {found['task']} has nothing that runs; give a scene that grows")
    for name in OF_PROGRAM:
        found.pop(name, None)
    for name in FILES:
        if name in found:
            found[name] = str(Path(found[name]).resolve())
    name = Path(scene).stem if isinstance(scene, (str, Path)) else "mine"
    played = Played(name, found)
    if "wall_file" in found:
        if not Path(found["wall_file"]).is_file():
            raise TendrilError(f"wall_file {found['wall_file']}: is not there")
        played.walls = walls_in(found["wall_file"])
    if posts:
        add_posts(played, directory, posts)
    return played


def add_posts(played, directory, posts):
    """Adds posts to be put somewhere."""
    from .loading import load

    sim, begun = Simulation(**played.options), Path(directory) / "alone.h5"
    sim.save(begun)
    radius = max(2 * load(begun).diameter, 0.05)
    lines = Path(played.options["wall_file"]).read_text().splitlines() if played.walls else []
    played.posts = list(range(len(lines) + 1, len(lines) + posts + 1))
    lines += [f"circle {1000 + 10 * k} 1000 {radius:.6g} outside" for k in range(posts)]
    file = Path(directory) / "walls.txt"
    file.write_text("\n".join(lines) + "\n")
    played.options["wall_file"] = str(file)
    played.walls = walls_in(file)


SENSES = (("tropism_light", "pull of the lamp", "1/l", -5, 5), ("tropism_gravity", "pull of gravity on growth", "1/l", -5, 5),
          ("tropism_proprioception", "how it straightens", "1", 0, 5), ("tropism_nutation", "nutation", "1/l", -5, 5),
          ("growth_ironing", "how growth gives way to moments", "1", 0, 500))


def senses(setup) -> list[dict]:
    """Of growth that senses or learns, what may be changed: what the run began with."""
    found = []
    for name, label, unit, low, high in SENSES:
        value = number(setup, name)
        if value != 0:
            found.append({"name": name, "label": label, "value": value, "low": min(low, 2 * value), "high": max(high, 2 * value), "unit": unit, "of": name})
    return found


def controls(played, space, setup) -> list[dict]:
    """What may be changed in a run of this scene: as the page offers it. of: what it means; kind: how it is given."""
    get, found = played.options.get, []

    def number(name, usual):
        """What the run began with, dimensionless."""
        value = setup.attributes.get(f"parameters/{name}", usual)
        return usual if isinstance(value, str) else float(value)

    def add(name, label, value, low, high, unit="1", of=None, **more):
        if not low <= value <= high:
            low, high = min(low, 2 * value), max(high, 2 * value)
        found.append({"name": name, "label": label, "value": value, "low": low, "high": high, "unit": unit, "of": of or name} | more)

    if played.feeds and "growth_path" not in played.options:
        add("feed_speed", "speed of feeding", 1.0, -2, 2, "V", keys=True)
    add("friction_factor", "friction, times", 1.0, 0.1, 10, log=True)
    mu = number("friction_mu", 1)
    if 0 < mu <= 0.999:
        add("friction_mu", "dry share of friction", mu, 0, 0.999)
    if played.held == "free":
        if get("tip_law", "dead") == "resistance":
            add("tip_force", "resistance to the tip", number("tip_force", 0), 0, 5, "N l")
        else:
            add("tip_force", "force against the tip", number("tip_force", 0), -5, 5, "N l")
        if space:
            add("tip_torque", "torque on the tip", number("tip_torque", 0), -2, 2, "N l^2")
    add("curvature_to", "natural curvature", number("rod_curvature", 0), -3, 3, "1/l", leads=True)
    if space:
        add("curvature_2_to", "natural bend out of the plane", number("rod_curvature_2", 0), -3, 3, "1/l", leads=True)
        add("twist_to", "natural twist", number("rod_twist", 0), -3, 3, "1/l", leads=True)
        if get("clamp_type", "held") != "free" and "clamp_path" not in played.options:
            add("clamp_spin", "spin of the clamp", number("clamp_spin", 0), -3, 3, "rad V/l", keys=True)
    rub = any((wall.friction or 0) > 0 for wall in played.walls) or number("contact_friction", 0) > 0
    for wall in played.walls if rub else []:
        usual = wall.friction if wall.friction is not None else number("contact_friction", 0)
        add(f"wall_friction {wall.line}", f"friction of wall {wall.line}, a {wall.kind}", usual, 0, 1, of="wall_friction")
    if played.held == "clamped" and not space and "tip_path" not in played.options:
        add("tip_turn_to", "direction of the tip", 0.0, -3.2, 3.2, "rad", leads=True)
    return found


def may_lead_tip(played):
    return played.held in ("pinned", "clamped") and "tip_path" not in played.options


# ---- what was done, as a scene file ----


def said_rows(played) -> list[tuple[str, str, str]]:
    """The rows of -change_file, as they stand there."""
    if "change_file" not in played.options:
        return []
    lines = (line.partition("#")[0].split(None, 2) for line in Path(played.options["change_file"]).read_text(encoding="utf-8-sig").splitlines())
    return [(t, what.lstrip("-"), value.strip()) for t, what, value in (line for line in lines if line)]


def names_file(words, folder):
    """Files that stand in a line of a wall file, beside it."""
    return [word for word in words if not NUMBER.fullmatch(word) and (folder / word).is_file()]


def copied(path, to) -> str:
    """The name of a copy of a file in a directory, and of what a wall file names there."""
    path, to = Path(path), Path(to)
    name = path.name
    while (to / name).exists() and (to / name).read_bytes() != path.read_bytes():
        name = f"{to.name}-{name}"
    shutil.copyfile(path, to / name)
    return name


def save_scene(played, changes, directory, name, said="") -> Path:
    """Writes NAME.opts, what it names, and the table of what was changed, [(t, what, value), ...], into a directory of its own,
    which may be moved: tendril -options_file NAME.opts gives the run again."""
    to = Path(directory) / name
    to.mkdir(parents=True, exist_ok=True)
    lines = [f"# {line}".rstrip() for line in said.splitlines()]
    for option, value in played.options.items():
        if option == "change_file":
            continue
        if option == "wall_file":
            folder, rows = Path(value).parent, Path(value).read_text().splitlines()
            value = "walls.txt"
            (to / value).write_text("\n".join(rows) + "\n")  # so that no copy takes its name
            for wall in played.walls:
                if inner := names_file(wall.words[1:], folder):
                    rows[wall.line - 1] = " ".join(copied(folder / word, to) if word in inner else word for word in wall.words)
            (to / value).write_text("\n".join(rows) + "\n")
        elif option in FILES:
            value = copied(value, to)
        lines.append(f"-{option} {value}".rstrip())
    if changes:
        rows = "".join(f"{t} {what} {value}\n" for t, what, value in changes)
        (to / "changes.txt").write_text("# t, what was changed, to what (docs/live.md)\n" + rows)
        lines.append("-change_file changes.txt")
    file = to / f"{name}.opts"
    file.write_text("\n".join(lines) + "\n")
    return file

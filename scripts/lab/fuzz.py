#!/usr/bin/env python3
"""Random scenes: each at the defaults, against a hundredth of the tolerance on a finer mesh.

    fuzz.py EXE SEED COUNT [--wide] [--world] [--contact] [--hard] [--space]

--wide: lengths, shapes and times far apart; --world: also friction across and in fields and layers,
forces on the tip and held tips, growth at the tip, stiffness along the rod; --contact: walls of all kinds around
a fed or growing rod that also meets itself (a tip off by 1 % of the length is called lost, for which way a rod folds may hang by a hair); --hard: loads beyond
the critical one from the start, which snap (the reference then follows no snap: it has a viscous share of 1e-3,
begins with steps of 1e-12 and goes on with small ones; a tip off by 5 % of the length is lost, it is on
another side), narrow zones of growth and layers of friction, thin posts; --space: a plain scene that weight,
forces, torque, spin, natural bends and twist or its start take out of the plane; --space --world: on 120 cells, with a
third of all else that space has: fields of three axes, growth by a table, stiffness, twist and bends from files, a tip that is led,
walls of all kinds. Prints the bad ones with
their command and a summary; exit 1 if any is lost (gave up, hung, tip off by more than 1e-4 of the
length). Files that scenes need are kept beside the results, under /tmp/fuzz-SEED."""

import os
import random
import signal
import subprocess
import sys
from pathlib import Path

import h5py
import numpy as np

LIMIT, REFERENCE_LIMIT = 60, 200  # seconds
TIP, NORM = 1e-4, 1e-2            # off by more is bad
TIP_IN_CONTACT = 1e-2
TOLD = "hardly grow on", "its own axis at once"  # where a scene ends by itself, and the run says how


class Draw(random.Random):
    """Draws numbers of three digits."""

    def between(self, a, b):
        return float(f"{self.uniform(a, b):.3g}")

    def over_decades(self, a, b):
        return float(f"{np.exp(self.uniform(np.log(a), np.log(b))):.3g}")

    def happens(self, share):
        return self.random() < share


def plain_scene(draw, wide, laws=("uniform", "uniform", "gaussian", "feed")):
    """Options by name: growth, friction, shape, natural curvature, model."""
    o = {"growth_type": draw.choice(laws)}
    if o["growth_type"] == "gaussian":
        o["growth_width"] = draw.over_decades(.01, 5)
    o["friction_mu"] = draw.choice([0, 1, 1, round(draw.random(), 3)])
    o["friction_beta"] = draw.choice([0, 1e-3, draw.over_decades(1e-12, 1e-1)])
    if o["friction_mu"] == 0:
        o["friction_beta"] = 1e-3
    o["growth_initial_length"] = draw.over_decades(*((.05, 8) if wide else (.3, 10)))
    o["shape_type"] = draw.choice(["sag", "sag", "random"])
    o["shape_amplitude"] = draw.over_decades(*((1e-12, 1.5) if wide else (1e-4, 2.5)))
    if o["shape_type"] == "random":
        o["shape_seed"] = draw.randint(1, 1000)
    if draw.happens(.3):
        o["rod_curvature_random"] = draw.over_decades(1e-6, .5)
    elif draw.happens(.15):
        o["rod_curvature"] = draw.over_decades(1e-6, 1)
    if draw.happens(.2):
        o["clamp_angle"] = draw.between(-3, 3)
    o["rod_model"] = draw.choice(["frame", "frame", "frame", "auto"])
    o["ts_max_time"] = draw.over_decades(*((.5, 30) if wide else (3, 40)))
    return o


def senses_scene(draw, yields=False):
    """Options by name: a rod whose material learns its natural curvature, by a few of all that it may go by, in the plane or in
    space; yields: whose growth feels force, and that may learn."""
    o = {"growth_type": draw.choice(("uniform", "apical", "apical", "feed") if yields else
                                    ("uniform", "gaussian", "apical", "apical", "feed", "none"))}
    if o["growth_type"] == "apical":
        o["growth_zone"] = draw.between(.2, 1.5)
    if o["growth_type"] == "gaussian":
        o["growth_width"] = draw.between(.1, 2)
    o["growth_initial_length"] = draw.over_decades(.3, 3)
    o["friction_mu"] = draw.choice([0, 1, round(draw.random(), 3)])
    if draw.happens(.2) and o["friction_mu"]:
        o["friction_beta"] = draw.choice([0, draw.over_decades(1e-6, 1e-2)])
    o.update(draw.choice([{"shape_type": "straight"}, {"shape_type": "sag", "shape_amplitude": draw.over_decades(1e-3, 1)}]))
    space = draw.happens(.4)
    if yields:
        o["growth_yield"] = draw.over_decades(.4, 8)
        if draw.happens(.5):
            o["tip_force"], o["tip_law"] = draw.over_decades(.02, .5), draw.choice(["dead", "resistance"])
    if not yields or draw.happens(.6):
        what_is_learned(draw, o, space)
    if draw.happens(.3):
        o["rod_weight"] = f"0,{-draw.over_decades(.02, .5)}" + (f",{draw.between(-.2, .2)}" if space else "")
    o["rod_model"] = "space" if space else "frame"
    o["ts_max_time"] = draw.over_decades(.5, 4)
    return o


def what_is_learned(draw, o, space):
    """What a material goes by."""
    still = o["growth_type"] in ("feed", "none")
    if still:
        o["tropism_rate"] = draw.over_decades(.2, 2)
    third = f",{draw.between(-1, 1)}" if space else ""
    senses = draw.choice(["gravity", "gravity", "light", "both", "none"])
    if senses in ("gravity", "both"):
        o["tropism_gravity"] = draw.over_decades(.2, 6)
        o["tropism_direction"] = f"{draw.between(-1, 1)},{draw.between(-1, 1)}{third}"
    if senses in ("light", "both"):
        o["tropism_light"] = draw.over_decades(.2, 4)
        o["tropism_source"] = f"{draw.between(20, 40)},{draw.between(-30, 30)}{third}"
    if senses != "none":
        o["tropism_sensed"] = draw.choice(["local", "tip"])
        if draw.happens(.4):
            o["tropism_memory"] = draw.over_decades(.05, 1)
    if senses == "none" or draw.happens(.25):
        o["tropism_nutation"], o["tropism_nutation_rate"] = draw.over_decades(.2, 3), draw.between(-6, 6)
        if space:
            o["tropism_nutation_2"] = o["tropism_nutation"]
    if draw.happens(.8):
        o["tropism_proprioception"] = draw.over_decades(.2, 5)
    if draw.happens(.3):
        o["growth_ironing"] = draw.over_decades(.5, 50)


def write(path, **arrays):
    with h5py.File(path, "w") as file:
        for name, values in arrays.items():
            file[name] = values
    return path


def random_field(draw, path, reach, end):
    """A factor of a few waves over the plane, in half of them over time; never below a tenth."""
    x1, x2 = np.linspace(-reach, reach, 61), np.linspace(-reach, reach, 41)
    t = np.linspace(0, end, 9) if draw.happens(.5) else np.zeros(1)
    factor = np.ones((len(t), len(x2), len(x1)))
    for _ in range(3):
        a, b, c = (draw.between(-1, 1) * 8 / reach for _ in range(3))
        phase = (a * x1[None, None, :] + b * x2[None, :, None] + c * t[:, None, None] * reach / end)
        factor += draw.between(0, .3) * np.sin(phase + draw.between(0, 6))
    if len(t) > 1:
        return write(path, x1=x1, x2=x2, t=t, factor=factor)
    return write(path, x1=x1, x2=x2, factor=factor[0])


def world_scene(draw, wide, files):
    """Options by name: a plain scene in a world of about half of all that there is."""
    o = plain_scene(draw, wide, ("uniform", "gaussian", "feed", "apical", "apical"))
    o["ts_max_time"] = min(o["ts_max_time"], 12)
    reach = o["growth_initial_length"] + o["ts_max_time"]
    if o["growth_type"] == "apical":
        o["growth_zone"] = draw.over_decades(.1, 3)
    if draw.happens(.5):
        o["friction_across"] = draw.over_decades(.3, 4)
    if draw.happens(.3):
        o["friction_field"] = random_field(draw, f"{files}-field.h5", reach, o["ts_max_time"])
    elif draw.happens(.4):
        starts = sorted({draw.between(0, reach) for _ in range(3)})
        starts = [a for k, a in enumerate(starts) if k == 0 or a - starts[k - 1] > .5]
        o["friction_layers"] = ",".join(f"{a}:{draw.over_decades(.2, 5)}" for a in starts)
        o["friction_layer_width"] = draw.over_decades(.02, .4)
    if draw.happens(.25):
        o["tip_type"] = draw.choice(["pinned", "clamped"])
        o["growth_initial_length"] = max(o["growth_initial_length"], 1)
        if o["shape_type"] != "straight":  # a held tip bends the rod at once: not from a straight one
            o["shape_amplitude"] = max(o["shape_amplitude"], .1)
    elif draw.happens(.6):
        o["tip_force"] = draw.over_decades(.01, 3)
        o["tip_law"] = draw.choice(["dead", "follower", "resistance", "resistance"])
        if o["tip_law"] == "resistance" and draw.happens(.3):
            o["tip_field"] = random_field(draw, f"{files}-tip.h5", reach, o["ts_max_time"])
    if draw.happens(.3):
        base, rise, over = draw.over_decades(.5, 3), draw.over_decades(.3, 5), draw.over_decades(.3, 5)
        distance = np.linspace(0, 8 * over, 201)
        o["rod_stiffness_file"] = write(f"{files}-stiffness.h5", distance=distance,
                                        factor=base + rise * (1 - np.exp(-distance / over)))
    return o


def random_walls(draw, path, diameter):
    """One to three walls that a rod from the origin along x1 does not start in."""
    lines, r = [], diameter / 2
    kind = draw.choice(["cavity", "plane", "stones", "conduit", "polygon", "none"])
    friction = f" friction {draw.between(0, 1)}" if draw.happens(.5) else ""
    if kind == "cavity":
        size = draw.between(2, 5)
        lines.append(f"circle {size - r - .1:.4f} 0 {size} inside{friction}")
    elif kind == "plane":
        lines.append(f"plane {draw.between(1.5, 6)} 0 -1 {draw.between(-.5, .5)}{friction}")
    elif kind == "stones":
        for k in range(draw.randint(1, 4)):
            lines.append(f"circle {2.5 + 1.8 * k} {draw.between(-1.2, 1.2)} {draw.between(.2, .8)} "
                         f"outside{friction}")
    elif kind == "conduit":
        turn, bend = draw.between(1.5, 4), draw.between(-1.2, 1.2)
        ends = f"{turn + 4 * np.cos(bend):.4f} {4 * np.sin(bend):.4f}"
        lines.append(f"path {draw.between(r + .1, r + .6):.4f} -1 0 {turn} 0 {ends}{friction}")
    elif kind == "polygon":
        a, b = draw.between(2, 5), draw.between(-1, 1)
        lines.append(f"polygon outside {a} {b - .6} {a + 1.5} {b - .8} {a + 1.2} {b + .9} {a} {b + .6}"
                     f"{friction}")
    Path(path).write_text("".join(line + "\n" for line in lines))
    return path if lines else None


def contact_scene(draw, wide, files):
    """Options by name: a plain scene that is long enough to touch what is around it."""
    o = plain_scene(draw, False, ("feed", "feed", "uniform", "apical"))
    if o["growth_type"] == "apical":
        o["growth_zone"] = draw.over_decades(.3, 2)
    o.update(growth_initial_length=.5, ts_max_time=draw.between(4, 16), shape_type="straight",
             rod_model="frame", contact_diameter=draw.between(.05, .3))
    o.pop("shape_amplitude"), o.pop("shape_seed", None), o.pop("rod_curvature", None)
    o["rod_curvature_random"], o["rod_curvature_length"] = draw.over_decades(.02, .3), 3
    o["rod_curvature_seed"] = draw.randint(1, 1000)
    o.pop("clamp_angle", None)
    walls = random_walls(draw, f"{files}.walls", o["contact_diameter"])
    if walls:
        o["wall_file"] = walls
    if not walls or draw.happens(.7):
        o["contact_self"] = "true"
    if draw.happens(.3):
        o["contact_friction"] = draw.over_decades(.05, 1)
    if "contact_self" not in o and " friction " in Path(walls).read_text():
        o.pop("contact_friction", None)  # nothing would take it
    return o


def hard_scene(draw, wide, files):
    """Options by name: what a stepper, a mesh or a contact may well overlook."""
    kind = draw.choice(["load", "load", "later", "apical", "gaussian", "layer", "post"])
    o = {"friction_mu": draw.choice([0, 1, 1, round(draw.random(), 3)]), "rod_model": "frame",
         "growth_initial_length": draw.between(.5, 2), "ts_max_time": draw.between(1, 4)}
    if kind == "load":
        length = o["growth_initial_length"] = draw.over_decades(.05, .5)
        o.update(tip_force=float(f"{draw.between(4, 15) / length ** 2:.3g}"), shape_amplitude=draw.choice([.1, 1]),
                 ts_max_time=float(f"{length * draw.between(.005, .3):.3g}"), friction_mu=draw.choice([0, 1]))
    elif kind == "later":  # growth takes the rod beyond the load's critical length
        length = o["growth_initial_length"] = draw.between(.3, 1)
        o.update(tip_force=float(f"{draw.between(1, 2.4) / length ** 2:.3g}"), shape_amplitude=draw.over_decades(1e-3, .3),
                 ts_max_time=float(f"{length * draw.between(.2, 1):.3g}"), growth_type=draw.choice(["uniform", "feed"]))
    elif kind == "apical":
        o.update(growth_type="apical", growth_zone=draw.over_decades(.03, .3), shape_type="straight",
                 rod_curvature_random=draw.over_decades(.01, .3))
    elif kind == "gaussian":
        o.update(growth_type="gaussian", growth_width=draw.over_decades(1e-4, .02), shape_amplitude=.1)
    elif kind == "layer":
        x = draw.between(.6, 3)
        o.update(growth_type=draw.choice(["uniform", "feed"]), shape_amplitude=draw.over_decades(.01, 1),
                 friction_layers=f"0:1,{x}:{draw.over_decades(.2, 5)}", friction_layer_width=draw.over_decades(.003, .1))
    else:
        path = Path(f"{files}.walls")
        path.write_text(f"circle {draw.between(1, 3)} {draw.between(-.5, 1)} {draw.over_decades(.003, .1)} outside\n")
        o.update(growth_type="feed", wall_file=path, contact_diameter=draw.over_decades(.02, .1), shape_type="straight",
                 rod_curvature=draw.between(.05, .4), growth_initial_length=.5, ts_max_time=draw.between(3, 6))
    return o


def vector(draw, most):
    return ",".join(str(draw.between(-most, most)) for _ in range(3))


def space_scene(draw, wide, files):
    """Options by name: a plain scene with about a third of all that takes a rod out of the plane."""
    o = plain_scene(draw, False, ("uniform", "gaussian", "feed", "apical"))
    if o["growth_type"] == "apical":
        o["growth_zone"] = draw.over_decades(.2, 3)
    o.pop("clamp_angle", None)
    o.update(rod_model="space", growth_initial_length=draw.over_decades(.3, 4), ts_max_time=draw.between(1, 4),
             shape_amplitude=draw.over_decades(1e-3, 1))
    chances = {"rod_curvature_2": lambda: draw.over_decades(1e-4, .5), "rod_twist": lambda: draw.between(-1, 1),
               "shape_turn": lambda: draw.between(-3, 3), "rod_weight": lambda: vector(draw, .4),
               "rod_torsion": lambda: draw.between(.3, 2), "rod_bend_ratio": lambda: draw.over_decades(.2, 5),
               "friction_radius": lambda: draw.over_decades(.01, .3), "friction_across": lambda: draw.over_decades(.3, 4),
               "tip_force_vector": lambda: vector(draw, .3), "tip_torque": lambda: draw.between(-1, 1),
               "clamp_spin": lambda: draw.between(-.5, .5), "clamp_direction": lambda: vector(draw, 1)}
    for name in draw.sample(sorted(chances), draw.randint(2, 5)):
        o[name] = chances[name]()
    if "rod_curvature_random" in o and draw.happens(.5):
        o["rod_curvature_random_2"] = draw.over_decades(1e-3, .3)
    if draw.happens(.2):
        o["tip_force"], o["tip_law"] = draw.over_decades(.01, 1), draw.choice(["dead", "follower", "resistance"])
    elif draw.happens(.1) and "tip_force_vector" not in o and "tip_torque" not in o:
        o.update(tip_type=draw.choice(["pinned", "clamped"]), shape_amplitude=draw.between(.1, .6))
        o["growth_initial_length"] = max(o["growth_initial_length"], 1)
    return o


def random_surfaces(draw, path, diameter):
    """Walls in space that a straight rod of length 0.5 from the origin along x1 does not start in."""
    r, kind = diameter / 2, draw.choice(["cavity", "tube", "ground", "pillar", "ball", "ring", "cone"])
    friction = f" friction {draw.between(0, 1)}" if draw.happens(.6) else ""
    a, b = draw.between(1, 2.5), draw.between(-.6, .6)
    if kind == "cavity":
        size = draw.between(1, 3)
        line = f"sphere {size - r - .1:.4f} 0 0 {size} inside"
    elif kind == "tube":
        line = f"tube inside -1 0 0 {r + .15:.4f}  0 0 0 {r + .15:.4f}  {a} 0 0 {r + .15:.4f}  {a + 1} {b} {b / 2:.4f} {r + .1:.4f}  {a + 4} {3 * b:.4f} {b} {r + .1:.4f}"
    elif kind == "ground":
        line = f"plane 0 0 {-r - .05:.4f}  0 {draw.between(-.3, .3)} 1"
    elif kind == "pillar":
        line = f"cylinder {a} {b} 0  {draw.between(-.5, .5)} {draw.between(-1, 1)} 1  {draw.between(.1, .6)} outside"
    elif kind == "ball":
        line = f"sphere {a + .5:.3f} {b} {draw.between(-.3, .3)} {draw.between(.2, .8)} outside"
    elif kind == "ring":
        line = f"torus {a} 0 0  1 0 {draw.between(-.3, .3)}  {r + .4:.4f} 0.1 outside"
    else:
        line = f"cone -1 0 0  1 0 0  {r + .4:.4f} {draw.between(.02, .2) + r:.4f} {a + 2} inside"
    Path(path).write_text(line + friction + "\n")
    return path


def space_world_scene(draw, wide, files):
    """Options by name: a scene in space in a world of about a third of all that there is."""
    o, s = space_scene(draw, wide, files), np.linspace(0, 1, 21)
    o["rod_cells"] = 120
    end = o["ts_max_time"] = min(o["ts_max_time"], 2.5)
    reach = o["growth_initial_length"] + 2 * end
    if draw.happens(.3):
        o.setdefault("friction_radius", draw.over_decades(.01, .3))
        o.setdefault("clamp_spin", draw.between(-1, 1))
        o.pop("tip_torque", None)
    if draw.happens(.3):
        x = [np.linspace(-reach, reach, n) for n in (31, 21, 21)]
        wave = sum(draw.between(.05, .3) * np.sin(draw.between(-4, 4) * x[0][None, None, :] + draw.between(-4, 4) * x[1][None, :, None]
                                                   + draw.between(-4, 4) * x[2][:, None, None]) for _ in range(3))
        o["friction_field"] = write(f"{files}-cloud.h5", x1=x[0], x2=x[1], x3=x[2], factor=1 + wave)
    if draw.happens(.25):
        o["rod_stiffness_file"] = write(f"{files}-stiffness.h5", distance=np.linspace(0, reach, 101),
                                        factor=1 + draw.over_decades(.3, 3) * (1 - np.exp(-np.linspace(0, reach, 101))))
    if draw.happens(.25):
        for name in ("rod_curvature", "rod_curvature_2", "rod_twist", "rod_curvature_random", "rod_curvature_random_2"):
            o.pop(name, None)
        along = {"distance": reach * s} if o["growth_type"] in ("feed", "apical") else {"s": s}
        o["rod_curvature_file"] = write(f"{files}-bent.h5", **along, twist=draw.between(-1, 1) * np.cos(3 * s),
                                        curvature=draw.between(-.5, .5) * np.sin(4 * s), curvature_2=draw.between(-.5, .5) * s)
    if draw.happens(.2):
        length, t = o.pop("growth_initial_length"), np.linspace(0, end, 9)
        for name in ("growth_width", "growth_zone"):
            o.pop(name, None)
        o["growth_type"] = "table"
        if "rod_curvature_file" in o:  # which is then laid out over s
            with h5py.File(o["rod_curvature_file"], "a") as f:
                f.pop("distance", None)
                f.require_dataset("s", s.shape, float)[:] = s
        o["growth_table"] = write(f"{files}-table.h5", s=s, t=t, g=length + np.outer(t, .5 + draw.between(0, 1) * s))
    if draw.happens(.35) and o["growth_type"] != "table":
        for name in ("shape_amplitude", "shape_turn", "shape_seed", "tip_type", "clamp_direction"):
            o.pop(name, None)
        o.update(shape_type="straight", contact_diameter=draw.between(.04, .12))
        o["growth_initial_length"] = .5
        o["wall_file"] = random_surfaces(draw, f"{files}.walls", o["contact_diameter"])
    elif draw.happens(.2) and o["growth_type"] != "table":
        for name in ("tip_force", "tip_law", "tip_force_vector", "tip_torque", "clamp_spin"):
            o.pop(name, None)
        o["tip_type"] = draw.choice(["clamped", "slides"])
        Path(f"{files}-lead.csv").write_text(f"t,turn\n0,0\n{end / 2},{draw.between(-2, 2)}\n{end},{draw.between(-2, 2)}\n")
        o["tip_path"] = f"{files}-lead.csv"
    return o


def reference_of(options, contact):
    """(what else its reference is given, off by how much of the length a tip is lost)"""
    if float(options.get("tip_force", 0)) > 3 and "tip_law" not in options:
        mu = min(float(options["friction_mu"]), .999)
        most = float(options["ts_max_time"]) / 500
        return ["-friction_mu", str(mu), "-ts_dt", "1e-12", "-ts_rtol", "1e-7", "-ts_adapt_dt_max", f"{most:g}"], .05
    if "rod_cells" in options:
        return ["-rod_cells", "300", "-ts_rtol", "1e-8"], TIP_IN_CONTACT if "wall_file" in options else TIP
    if contact or "wall_file" in options:
        return ["-rod_cells", "800", "-ts_rtol", "1e-8"], TIP_IN_CONTACT
    return ["-rod_cells", "1200", "-ts_rtol", "1e-8"], TIP


def run(exe, options, limit, file, extra=()):
    """(tip, norm, length, seconds) or None, what it said, the command."""
    command = [exe, *(word for k, v in options.items() for word in (f"-{k}", str(v))), *extra]
    began = os.times()
    try:  # the limit is of processor time: a busy machine is no hanging run
        done = subprocess.run(["prlimit", f"--cpu={limit}", *command, "-output", file],
                              capture_output=True, text=True, timeout=20 * limit)
    except subprocess.TimeoutExpired:
        return None, "hung", " ".join(command[1:])
    if done.returncode in (-signal.SIGXCPU, -signal.SIGKILL):
        return None, "hung", " ".join(command[1:])
    seconds = sum(os.times()[2:4]) - sum(began[2:4])
    if done.returncode:
        return None, (done.stderr or done.stdout).strip()[-200:], " ".join(command[1:])
    with h5py.File(file) as f:
        s = {k: float(f["series"][k][-1]) for k in ("tip_x1", "tip_x2", "norm_x2", "length")}
        third = [float(f["series/tip_x3"][-1])] if "tip_x3" in f["series"] else []
        crossed = "contact_self" in options and f["series/self_crossings"][:].max() > 0
    os.remove(file)
    if crossed:
        return None, "crosses itself", " ".join(command[1:])
    tip = np.array([s["tip_x1"], s["tip_x2"], *third])
    return (tip, s["norm_x2"], s["length"], seconds), "ok", " ".join(command[1:])


def main():
    words = [w for w in sys.argv[1:] if not w.startswith("--")]
    if len(words) != 3 or set(sys.argv[1:]) - set(words) - {"--wide", "--world", "--contact", "--hard", "--space"}:
        sys.exit(__doc__)
    exe, seed, count = words[0], int(words[1]), int(words[2])
    wide, world, contact, hard, space = (f"--{word}" in sys.argv
                                         for word in ("wide", "world", "contact", "hard", "space"))
    draw, directory = Draw(seed), Path(f"/tmp/fuzz-{seed}")
    directory.mkdir(exist_ok=True)
    lost, norms, tips, walls = 0, 0, [], []
    for i in range(count):
        files = directory / str(i)
        o = (space_world_scene(draw, wide, files) if space and world else space_scene(draw, wide, files) if space else hard_scene(draw, wide, files) if hard else contact_scene(draw, wide, files) if contact
             else world_scene(draw, wide, files) if world else plain_scene(draw, wide))
        found, said, command = run(exe, o, LIMIT, f"{files}.h5")
        if found is None and any(words in said for words in TOLD):
            print("ended:", said, command, flush=True)
            continue
        if found is None:
            lost += 1
            print("lost:", said, command, flush=True)
            continue
        walls.append(found[3])
        if not space:
            o["rod_model"] = "frame"
        more, allowed = reference_of(o, contact)
        fine, said, _ = run(exe, o, REFERENCE_LIMIT, f"{files}.h5", more)
        if fine is None:
            print("no reference:", said, command, flush=True)
            continue
        tip = float(np.linalg.norm(found[0] - fine[0])) / found[2]
        norm = abs(found[1] / fine[1] - 1) if fine[1] else 0
        tips.append(tip)
        norms += norm > NORM
        if tip > allowed:
            lost += 1
            print(f"tip off by {tip:.1e}:", command, flush=True)
        elif norm > NORM and allowed < 0.05:
            print(f"norm off by {norm:.1e} at |x2| {fine[1]:.1e}:", command, flush=True)
    print(f"{lost} of {count} random scenes lost; tip off by at most {max(tips, default=0):.1e}, norm by "
          f"1 % or more in {norms}, median {np.median(walls) if walls else 0:.2f} s")
    sys.exit(int(lost > 0))


if __name__ == "__main__":
    main()

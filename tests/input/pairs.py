#!/usr/bin/env python3
# test: each option goes with each other or is refused in the plane
# test: each option goes with each other or is refused in space | with --space
"""Every option with every other: each pair of settings alone, and all of them in random company, a few
steps each. A run ends well or is refused in one line that names an option; none ends in a traceback,
gives up, crashes or hangs.

    pairs.py build/tendril [--space] [--seed SEED] [--rows ROWS] [--show WORD]

The settings are those of SETTINGS, or with --space each of IN_SPACE with every other and with those; the
pairs are the members of one sweep. The same with each setting alone for the critical length, and with a few
that get on with each other at once for the stability and a restart."""

import argparse
import csv
import itertools
import re
import subprocess
import sys
import tempfile
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "support"))
import scene  # takes .venv's python if this one lacks numpy and h5py
from held import HANG

import h5py
import numpy as np

sys.path.insert(0, str(scene.ROOT / "scripts"))
from tendril.collection import load_sweep

# A short rod with few cells; what would touch it is within reach.
BASE = ("-growth_initial_length 2 -shape_amplitude 0.1 -rod_cells 24 -ts_max_time 0.02 -ts_rtol 1e-3 "
        "-ts_max_steps 400")
SETTINGS = {  # of each the first is what BASE has; {} is the directory of the files made below
    "law": ["", "growth_type=gaussian", "growth_type=gaussian growth_width=0.05", "growth_type=feed",
            "growth_type=apical", "growth_type=table growth_table={}/table.h5"],
    "length": ["", "growth_initial_length=0.5", "growth_initial_length=4"],
    "friction": ["", "friction_mu=0", "friction_mu=0.5"],
    "rounding": ["", "friction_beta=0", "friction_beta=1e-9", "friction_beta=0.1"],
    "across": ["", "friction_across=0.3", "friction_across=3"],
    "soil": ["", "friction_layers=0:1,1.5:2", "friction_field={}/field.h5"],
    # (with one rejection more it looks into snaps for seconds, which atlas_cells.py has it do)
    "newton": ["", "friction_newton=primal ts_max_reject=3"],
    "tip": ["", "tip_force=0.3", "tip_force=-0.3", "tip_force=0.3 tip_law=follower",
            "tip_force=0.3 tip_law=resistance", "tip_force=0.3 tip_law=resistance tip_field={}/field.h5",
            "tip_type=pinned", "tip_type=clamped"],
    "walls": ["", "wall_file={}/plane", "wall_file={}/oblique", "wall_file={}/post", "wall_file={}/duct",
              "wall_file={}/all contact_diameter=0.05"],
    "self": ["", "contact_self=true contact_diameter=0.05"],
    "touch": ["", "contact_friction=0.3", "contact_stiffness=1e4", "contact_firm=true"],
    "clamp": ["", "clamp_angle=-0.5", "clamp_type=hinged"],
    "grading": ["", "rod_grading=uniform"],
    "stiffness": ["", "rod_stiffness_file={}/stiffness.h5"],
    "curvature": ["", "rod_curvature=0.1", "rod_curvature_random=0.1", "rod_curvature_file={}/bent.h5"],
    "shape": ["", "shape_type=straight", "shape_type=mode", "shape_type=random", "shape_amplitude=1",
              "shape_type=file shape_file={}/shape.h5"],
    "model": ["", "rod_model=linear", "rod_model=mixed", "rod_model=auto"],
    "order": ["", "rod_order=2"],
    "stepper": ["", "ts_type=bdf", "ts_type=beuler ts_dt=1e-3", "ts_type=theta ts_dt=1e-3",
                "ts_bdf_order=1 ts_rtol=1e-2", "ts_bdf_factor=0"],
    "solver": ["", "ksp_type=gmres", "pc_type=lu", "snes_linesearch_type=bt"],
    "stop": ["", "stop_length=2.01", "stop_angle=0.5", "stop_contact=true", "stop_self_contact=0.01"],
    "senses": ["", "tropism_gravity=2 tropism_direction=0,-1 growth_ironing=20 tropism_rate=1",
               "tropism_light=2 tropism_source=9,3 tropism_proprioception=1 tropism_sensed=tip tropism_memory=0.1 tropism_rate=1"],
    "laboratory": ["", "si_bending_stiffness=1e-4 si_friction_dry=20",
                   "si_bending_stiffness=2Nmm^2 si_friction_dry=0.5N/m si_speed=5mm/s"],
}
# What makes a rod one in space, or is seen there alone; as pairs among themselves, and with those above.
IN_SPACE = {
    "space": ["", "rod_model=space"],
    "weight": ["", "rod_weight=0.1,0.2,-0.3"],
    "section": ["", "rod_torsion=0.1", "rod_bend_ratio=8"],
    "spin": ["", "friction_radius=0", "friction_radius=0.2"],
    "turned": ["", "clamp_spin=1"],
    "pull": ["", "tip_force_vector=0.03,0.06,-0.1"],
    "torque": ["", "tip_torque=0.1"],
    "direction": ["", "clamp_direction=1,1,-1"],
    "bends": ["", "rod_curvature_2=0.2", "rod_twist=0.4", "rod_curvature_random_2=0.1"],
    "circles": ["", "tropism_nutation=1 tropism_nutation_2=1 tropism_nutation_rate=3 tropism_rate=1"],
    "turn": ["", "shape_turn=1", "shape_type=file shape_file={}/wound.h5"],
    "cloud": ["", "friction_field={}/cloud.h5"],
    "led": ["", "tip_type=slides", "tip_type=clamped tip_path={}/lead.csv", "tip_type=slides tip_path={}/turn.csv"],
    "surfaces": ["", "wall_file={}/ground", "wall_file={}/ball", "wall_file={}/pillar", "wall_file={}/funnel",
                 "wall_file={}/ring", "wall_file={}/pipe", "wall_file={}/grid", "wall_file={}/drum contact_diameter=0.05"],
}
# ... of which some are enough there (dry friction that feels the spin refuses a hinge), and an arch between held
# ends need not snap over.
IN_COMPANY = {**SETTINGS, "clamp": SETTINGS["clamp"][:2], "length": [""], "newton": [""], "order": [""], "solver": [""],
              "tip": ["", "tip_force=0.3 tip_law=follower", "tip_force=0.3 tip_law=resistance tip_field={}/field.h5",
                      "tip_type=pinned ts_max_time=0.003", "tip_type=clamped"],
              "walls": ["", "wall_file={}/plane", "wall_file={}/all contact_diameter=0.05"],
              "senses": SETTINGS["senses"][:2],
              "shape": ["", "shape_type=straight", "shape_type=random", "shape_type=file shape_file={}/shape.h5"],
              "stepper": ["", "ts_type=bdf", "ts_bdf_factor=0"], "stop": ["", "stop_angle=0.5", "stop_contact=true"],
              "laboratory": ["", "si_bending_stiffness=1e-4 si_friction_dry=20"]}
# Something must hold its spin.
BASE_IN_SPACE = ("-growth_initial_length 2 -shape_amplitude 0.1 -shape_turn 0.5 -friction_radius 0.1 -rod_cells 16 "
                 "-ts_max_time 0.007 -ts_rtol 1e-3 -ts_max_steps 600")
# A run of a few steps that is asked for this may rightly find no step (its method is not for it), or
# end where its model ends.
MAY_GIVE_UP = ("friction_newton=primal", "ts_type=", "pc_type=lu", "ksp_type=gmres", "ts_bdf_order=1",
               "snes_linesearch_type=bt")
END = 0.003  # by then each may have come to its end


def write_files(d, base):
    # in a file, where a task of its own may leave unread what concerns it not
    (d / "base.opts").write_text(base.replace(" -", "\n-") + "\n")
    s = np.linspace(0, 1, 11)

    def write(name, **arrays):
        with h5py.File(d / name, "w") as f:
            for key, value in arrays.items():
                f[key] = value

    write("table.h5", s=s, t=np.linspace(0, 4, 9), g=2 + np.outer(np.linspace(0, 4, 9), 0.5 + s))
    write("field.h5", x1=np.linspace(-5, 9, 15), x2=np.linspace(-5, 5, 11),
          factor=np.ones((11, 15)) + 0.05 * np.arange(15))
    write("stiffness.h5", distance=np.linspace(0, 9, 10), factor=1 + 0.1 * np.arange(10))
    write("bent.h5", s=s, curvature=0.1 * np.cos(9 * s))
    write("shape.h5", s=s, theta=0.05 * np.sin(np.pi * s))
    for name, text in (("plane", "plane 2.005 0 -1 0"), ("oblique", "plane 2.01 0 -1 -0.5"),
                       ("post", "circle 2.305 0.05 0.3 outside"), ("duct", "path 0.3 -1 0 1 0 9 0.5")):
        (d / name).write_text(text + "\n")
    (d / "all").write_text("polygon inside -9 -9 9 -9 9 9 -9 9\ncircle 0 0 8 inside friction 0.2\n"
                           "polygon outside 2.05 -0.4 3 -0.4 3 0.6 2.05 0.6 friction 0\n")
    write_space_files(d, s, write)


def write_space_files(d, s, write):
    write("wound.h5", s=s, u1=0.1 * np.sin(3 * s), u2=0.05 * s, u3=0.05 * np.cos(2 * s))
    write("cloud.h5", x1=np.linspace(-5, 9, 8), x2=np.linspace(-5, 5, 6), x3=np.linspace(-5, 5, 6),
          factor=np.ones((6, 6, 8)) + 0.05 * np.arange(8))
    (d / "lead.csv").write_text("t,turn\n0,0\n1,0.5\n")
    (d / "turn.csv").write_text("t,turn\n0,0\n0.01,0.02\n1,-0.5\n")
    near = 0.1 * np.arange(9) - 0.4
    distance = np.sqrt(near[None, None, :] ** 2 + near[None, :, None] ** 2 + near[:, None, None] ** 2) - 0.29
    write("body.h5", distance=distance, origin=[1.9, -0.4, -0.4], spacing=[0.1] * 3)
    for name, text in (("ground", "plane 0 0 -0.01  0 0.1 1 friction 0.3"), ("ball", "sphere 2.3 0 0  0.3 outside"),
                       ("pillar", "cylinder 2.305 0.05 -1  0 0 1  0.3 outside 2"),
                       ("funnel", "cone -1 0 0  1 0 0  0.4 0.1 4 inside"),
                       ("ring", "torus 2 0 0  1 0 0  0.3 0.1 outside friction 0.2"),
                       ("pipe", "tube inside -1 0 0 0.16  9 0 0 0.16"), ("grid", "body body.h5 outside friction 0.2"),
                       ("drum", "sphere 2.35 0 0  0.3 outside turns 1 2.35 0 0 0 0 1 friction 0.4")):
        (d / name).write_text(text + "\n")


def pairs_of(row):
    return {frozenset(pair) for pair in itertools.combinations(row.items(), 2)}


def pairs(settings, own):
    """Each pair of settings, of which one at least is own."""
    for a, b in itertools.combinations(settings, 2):
        if a in own or b in own:
            yield from (frozenset([(a, x), (b, y)]) for x, y in itertools.product(settings[a][1:], settings[b][1:]))


def companies(settings, left, size, dice):
    """Rows of so many settings that have the pairs that are left, each with as many of them as it may."""
    left = dict.fromkeys(left)
    each = [(name, value) for name, values in settings.items() for value in values[1:]]
    while left:
        row = dict(sorted(next(iter(left))))
        while len(row) < size:
            news = [sum(frozenset([one, other]) in left for other in row.items() if one[0] not in row) for one in each]
            if max(news) < (len(row) + 1) // 2:
                break
            row.update([each[dice.choice(np.flatnonzero(np.array(news) == max(news)))]])
        for pair in pairs_of(row):
            left.pop(pair, None)
        yield row


def all_pairs(settings, own, d, space):
    """What is wrong, of each pair in a few others' company; of those that no company ran with, alone. And the
    pairs that ran, somewhere."""
    left, dice, wrong, good = list(pairs(settings, own)), np.random.default_rng(1), [], set()
    for size in (5, 3, 2):
        rows = list(companies(settings, left, size, dice))
        faults, ran = sweep(rows, d, "grow", space)
        wrong += faults
        good.update(*(pairs_of(row) for row, well in zip(rows, ran) if well))
        left = [pair for pair in left if pair not in good]
    return wrong, good


def groups(settings, own, good, size):
    """Each of the own settings once, with a few others that it has run with if there are such."""
    left = [(name, value) for name in own for value in settings[name][1:]]
    while left:
        group = [left.pop(0)]
        for one in list(left):
            if len(group) < size and all(frozenset([one, other]) in good for other in group):
                group.append(one)
                left.remove(one)
        yield dict(group)


def covering(settings, rows, seed):
    """Settings of all kinds at once: each row is the one of some random ones that has most pairs which
    no row before has."""
    dice, names = np.random.default_rng(seed), list(settings)
    sizes = np.array([len(settings[n]) for n in names])
    places = np.concatenate([[0], np.cumsum(sizes)])[:-1]
    seen = np.zeros((sizes.sum(), sizes.sum()), bool)
    for _ in range(rows):
        tries = dice.integers(0, sizes, size=(30, len(names)))
        tries[dice.random(tries.shape) > 0.25] = 0  # else one of so many refuses the rest
        news = [(~seen[np.ix_(places + t, places + t)]).sum() for t in tries]
        best = tries[int(np.argmax(news))]
        seen[np.ix_(places + best, places + best)] = True
        yield {n: settings[n][k] for n, k in zip(names, best) if k}


def options_of(row, d):
    """Settings as options by name; of two that set the same the later wins."""
    return dict(word.format(d).split("=", 1) for value in row.values() for word in value.split())


def words_of(row, d):
    return [w for name, value in options_of(row, d).items() for w in (f"-{name}", value)]


def said_of(row):
    return " ".join(row.values()).replace("{}/", "") or "nothing"


def fault_of(row, line):
    """What is wrong with the line that a run ended in; None: nothing."""
    if "turns over about its own axis at once" in line and "friction_radius=0" in said_of(row).split():
        return None  # nothing holds its spin, and so it says
    if line.startswith("-") and not line.startswith("-ts_max_steps"):
        return None  # refused, or ended as asked
    if line.startswith(("gave up", "jammed", "crawls", "-ts_max_steps")) and any(w in said_of(row) for w in MAY_GIVE_UP):
        return None
    if line.startswith("jammed") and runs_head_on(row):
        return None
    return line


def runs_head_on(row):
    """A straight rod that nothing bends, and that grows into the plane in front of it: it is jammed by ten times the
    force that bends one."""
    said = said_of(row).split()
    return ("shape_type=straight" in said and "wall_file=plane" in said
            and not any(word.startswith(("rod_curvature", "clamp_angle", "clamp_direction")) for word in said))


def follows_errors(row):
    """Are the errors of a run followed, so that they are in its series? By the usual stepper, in the whole model alone."""
    return not any(word.startswith(("ts_type=", "rod_model=linear", "rod_model=mixed", "rod_model=auto"))
                   for word in said_of(row).split())


def observables(group):
    """The series that only some runs have, as src/record/observe.h lists them."""
    header = (scene.ROOT / "src/record/observe.h").read_text()
    return set(re.findall(r"X\((\w+), \"", re.search(rf"#define OBSERVABLES_{group}\(X\)(.*?)\n\n?(?=#|/)", header, re.S)[1]))


def has(row, space):
    """Of which series a run must have numbers: whether it has one of this name. In a sweep all have the columns of all."""
    words = [word.partition("=")[0] for word in said_of(row).split()]
    none = observables("OF_STEERING")
    if not space:
        none |= observables("IN_SPACE")
    if not any(word.startswith("tropism_") or word == "growth_ironing" for word in words):
        none |= observables("OF_TROPISM")
    if "rod_weight" not in words:
        none |= {name for name in observables("OF_WEIGHT") | observables("IN_SPACE") if name.startswith("weight_")}
    if not follows_errors(row):
        none |= {"error_tip", "error_norm_x2", "error_energy"}
    return lambda name: name not in none


def sweep(rows, d, task, space=False):
    """What is wrong, of all rows in one job: (row, line); which of them ran to their end."""
    names = sorted({name for row in rows for name in options_of(row, d)})
    with open(d / "table.csv", "w", newline="") as f:
        table = csv.writer(f)
        table.writerow(names)
        table.writerows([options_of(row, d).get(name, "") for name in names] for row in rows)
    file = d / f"{task}.h5"
    file.unlink(missing_ok=True)
    try:
        done = subprocess.run([scene.TENDRIL, "-options_file", str(d / "base.opts"), "-task", "sweep", "-sweep_task", task,
                               "-sweep_file", str(d / "table.csv"), "-output", str(file), "-quiet"],
                              capture_output=True, text=True, env=scene.ENVIRONMENT, timeout=HANG)
        ended = f"exit {done.returncode}, {done.stderr[-300:]}"
        good = done.returncode == 0
    except subprocess.TimeoutExpired:
        ended, good = "hangs", False
    if not good:
        return one_by_one(rows, d, task, ended), [False] * len(rows)
    s = load_sweep(file)
    counts = (s.status == 1).sum(), (s.status == 2).sum()
    print(f"{task}: {len(rows)} runs, {counts[0]} ran, {counts[1]} were refused or gave up", flush=True)
    wrong = [(row, fault) for row, status, line in zip(rows, s.status, s.line)
             if status != 1 and (fault := fault_of(row, line))]
    expected = [has(row, space) for row in rows]
    for name, values in (s.final if task == "grow" else s.critical).items():
        wrong += [(rows[k], f"{name} is {values[k]}") for k in np.flatnonzero((s.status == 1) & ~np.isfinite(values)) if expected[k](name)]
    ended = s.final["t"] >= END if task == "grow" else True
    return wrong, (s.status == 1) & ended


def one_by_one(rows, d, task, ended):
    """A crash or a hang takes the whole sweep with it: which is it?"""
    wrong = [({}, f"the sweep as a whole: {ended}")]
    for row in rows:
        code, stderr = run(d, ["-task", task, *words_of(row, d)])
        if code is None or code < 0 or code > 127:
            wrong.append((row, "hangs" if code is None else f"exit {code}, {stderr[-200:]}"))
    return wrong


def run(d, words):
    """(exit code, stderr) of a run by itself; code None: it hangs. One that goes on has its options from the file."""
    base = [] if words[0] == "-restart" else ["-options_file", str(d / "base.opts")]
    try:
        done = subprocess.run([scene.TENDRIL, *base, *words], capture_output=True, text=True,
                              env=scene.ENVIRONMENT, timeout=HANG)
    except subprocess.TimeoutExpired:
        return None, ""
    return done.returncode, done.stderr


def alone(rows, d):
    """Each row with the stability, and with a restart of a run that was broken."""
    file = d / "broken.h5"
    for row in rows:
        words = words_of(row, d)
        tasks = [["-task", "stability", "-stability_points", "3", "-stability_vertices", "24",
                  "-stability_transient", "false", *words]]
        code, stderr = run(d, [*words, "-output", str(file), "-output_interval", "0.004", "-ts_max_steps", "9"])
        if code == 1 and stderr.startswith("tendril: -ts_max_steps"):
            tasks.append(["-restart", str(file), "-ts_max_steps", "400"])
        for task in tasks:
            code, stderr = run(d, task)
            lines = stderr.splitlines()
            good = code == 0 and not lines or (
                code is not None and 0 < code < 128 and len(lines) == 1
                and lines[0].startswith("tendril: ") and not fault_of(row, lines[0][9:]))
            if not good:
                yield row, f"{' '.join(task[:2])}: exit {code}, {stderr[:300]}"
        file.unlink(missing_ok=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("tendril")
    parser.add_argument("--space", action="store_true")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--rows", type=int, default=150, help="of settings of all kinds at once")
    parser.add_argument("--show", default="", help="only faults with this word")
    choice = parser.parse_args()
    scene.TENDRIL = str(Path(choice.tendril).resolve())
    with tempfile.TemporaryDirectory(prefix="tendril-") as name:
        d = Path(name)
        write_files(d, BASE_IN_SPACE if choice.space else BASE)
        settings, own = ({**IN_COMPANY, **IN_SPACE}, IN_SPACE) if choice.space else (SETTINGS, SETTINGS)
        single = [{}, *({name: value} for name in own for value in settings[name][1:])]
        wrong, good = all_pairs(settings, own, d, choice.space)
        wrong += sweep(list(covering(settings, choice.rows, choice.seed)), d, "grow", choice.space)[0]
        wrong += sweep(single, d, "critical")[0] + list(alone(groups(settings, own, good, 4), d))
    for row, line in wrong:
        line = re.sub(r"\s+", " ", line)
        if choice.show in f"{said_of(row)} {line}":
            print(f"FAIL {said_of(row)}: {line}")
    print(f"pairs: {len(wrong)} faults")
    return len(wrong) > 0


if __name__ == "__main__":
    sys.exit(main())

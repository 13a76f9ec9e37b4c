#!/usr/bin/env python3
"""Feeds the commands and public functions of the Python package with damaged inputs: files cut, bytes changed, datasets
missing, of another shape, not finite; cells of tables changed; arguments of another kind. Each ends right, or in one line.

    scripts/lab/damages.py build/tendril [--count 500] [--only plot,view] [--seed 1] [--show]

A line a command: how many ended right, how many in a line, and what else came out: a traceback, a warning, several lines, a
fault that the package itself did not expect (its own last net), a process that died. Slow ones (fit, measure, sweep) get a
fifth of the count."""

import argparse
import contextlib
import io
import json
import multiprocessing
import os
import random
import re
import shutil
import sys
import tempfile
import traceback
import warnings
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "scripts"))
os.environ.setdefault("OMP_NUM_THREADS", "1")
SLOW = ("fit", "measure", "sweep", "py.fit", "py.measure", "py.sweep", "animate", "py.animate")
JUNK = ["", " ", "a", "-1", "0", "nan", "inf", "-inf", "1e999", "1,2,3", "1,2", "\u221e", "20 s", "20furlong", "../x", "/", ".",
        "None", "x" * 300, "1:2", "a:b:c", "=", "@", "1@", "%s", "{}", "{a}", "0x10", "1e-400", "-", "--", "\u00e4", "1;2", "a,b", ",", "=,="]
SECONDS = 60  # that one may take


# ---- what is damaged ----


def made(place):
    """The inputs, undamaged."""
    import h5py
    import numpy as np

    import tendril

    tube = dict(growth_type="feed", growth_initial_length="1cm", si_bending_stiffness="2.209Nmm^2", si_friction_dry="0.5N/m",
                si_speed="5mm/s", rod_cells=30, stop_length="5cm", rod_curvature="3/m")
    (place / "walls.txt").write_text("circle 3cm 1.5cm 1cm outside\nplane 0 -1cm 0 1 friction 0.3\n")
    tendril.run(tube, wall_file=str(place / "walls.txt"), contact_diameter="2mm", output_shapes=6, output=place / "tube.h5")
    tendril.run(tube, si_friction_dry="2N/m", output_shapes=5, output=place / "other.h5")
    tendril.run(growth_type="feed", growth_initial_length=1, rod_curvature=0.6, clamp_spin="30deg", rod_cells=20, ts_max_time=0.5,
                output_shapes=4, output=place / "space.h5")
    tendril.run(task="critical", friction_beta=1e-6, output=place / "critical.h5")
    tendril.run(task="stability", stability_points=4, stability_end=0.5, stability_vertices=20, friction_beta=1e-3,
                output=place / "stability.h5")
    tendril.sweep("feed", {"friction_mu": [0, 0.5, 1], "growth_initial_length": [1, 1.5]}, directory=place / "sweep", rod_cells=20,
                  ts_max_time=0.5)
    shutil.copy(place / "sweep/sweep.h5", place / "sweep.h5")
    (place / "tube.opts").write_text("".join(f"-{name} {value}\n" for name, value in tube.items() if name != "si_friction_dry"))
    r = tendril.load(place / "tube.h5")
    rows = ["t (s),x1 (cm),x2 (cm)"]
    for t in ("2s", "6s"):
        shape = r.at(t, nearest=True)
        x = shape.x[::4] * r.scale("length") * 100
        rows += [f"{t[:-1]},{a:.4f},{b:.4f}" for a, b in x]
    (place / "points.csv").write_text("\n".join(rows) + "\n")
    (place / "force.csv").write_text("t (s),base_force_1 (mN)\n1,7\n2,10\n5,17\n")
    (place / "rate.csv").write_text("distance,rate\n0,1\n0.5,0.7\n1,0.2\n2,0\n")
    (place / "line.csv").write_text("x,y,z,r\n0,0,0,1\n5,0,0,1.1\n10,1,0,1.2\n15,1,1,1.1\n")
    (place / "survey.csv").write_text("MD,Inc,Azi,R\n0,0,0,1\n10,5,10,1\n20,9,20,1\n30,12,25,1\n")
    (place / "line.json").write_text(json.dumps({"markups": [{"type": "Curve", "coordinateSystem": "LPS", "controlPoints": [
        {"position": [float(k), 0.1 * k * k, 0.0]} for k in range(6)]}]}))
    ball(place / "ball.ply")
    import cv2
    body = np.full((120, 300), 220, np.uint8)
    cv2.polylines(body, [np.array([[20, 60], [150, 50], [270, 70]], np.int32)], False, 60, 9, cv2.LINE_AA)
    cv2.imwrite(str(place / "rod.png"), body)
    cv2.imwrite(str(place / "rod.tif"), body)
    with h5py.File(place / "tracks.h5", "w") as file:
        file["node_names"], file["tracks"] = [b"a", b"b", b"c"], np.random.default_rng(1).random((1, 2, 3, 5))
    (place / "root.rsml").write_text("<rsml><metadata><unit>cm</unit><resolution>1</resolution></metadata><scene><plant><root>"
                                     "<geometry><polyline>" + "".join(f'<point x="{k}" y="{k * k / 9}"/>' for k in range(6))
                                     + "</polyline></geometry></root></plant></scene></rsml>")


def ball(path):
    """A mesh of triangles around the origin."""
    import trimesh

    trimesh.creation.icosphere(subdivisions=2, radius=2.0).export(path)


# ---- damages ----


def cut(raw, chance):
    return raw[:chance.randrange(len(raw) + 1)]


def flipped(raw, chance):
    raw = bytearray(raw)
    for _ in range(chance.choice((1, 3, 20, 200))):
        raw[chance.randrange(len(raw))] = chance.randrange(256)
    return bytes(raw)


def zeroed(raw, chance):
    first = chance.randrange(len(raw))
    return raw[:first] + bytes(min(chance.choice((8, 64, 1000)), len(raw) - first)) + raw[first + 1000:]


def other(raw, chance):
    return chance.choice((b"", b"\n", b"hello\n", b"\x89PNG\r\n\x1a\n1234", b"\x89HDF\r\n\x1a\n", b"\xff\xfe\x00", b"-growth_type feed\n", b"\0" * 50,
                          b"a,b\n1,2\n", b"{}", b"<a/>"))


def cells(raw, chance):
    """A table with some of its cells, rows, headings or separators changed."""
    rows = [line.split(",") for line in raw.decode().splitlines()]
    for _ in range(chance.choice((1, 1, 3))):
        row = chance.choice(rows)
        kind = chance.randrange(6)
        if kind < 3 and row:
            row[chance.randrange(len(row))] = chance.choice(JUNK[:30])
        elif kind == 3 and row:
            row.pop(chance.randrange(len(row)))
        elif kind == 4:
            row.append(chance.choice(JUNK[:10]))
        else:
            rows.remove(row) if len(rows) > 1 else None
    return "\n".join(chance.choice((",", ",", ";", "\t")).join(row) if chance.random() < 0.02 else ",".join(row)
                     for row in rows).encode()


def datasets(path, chance):
    """A file of HDF5 with some of its parts changed."""
    import h5py
    import numpy as np

    with h5py.File(path, "r+") as file:
        names = []
        file.visit(names.append)
        for _ in range(chance.choice((1, 1, 2, 4))):
            where = file[chance.choice(names)] if names and chance.random() < 0.85 else file
            if chance.random() < 0.25 and len(where.attrs) and (name := chance.choice(list(where.attrs))):
                if chance.random() < 0.5:
                    del where.attrs[name]
                else:
                    where.attrs[name] = chance.choice(("", "abc", -1.0, np.nan, np.zeros(3), 10**9))
                continue
            if where.name == "/" or chance.random() < 0.25:
                if where.name != "/":
                    names = [name for name in names if not f"/{name}/".startswith(where.name + "/")]
                    del file[where.name]
                continue
            if not isinstance(where, h5py.Dataset):
                continue
            values, name, about = where[()], where.name, dict(where.attrs)
            try:
                values = np.array(changed(np.asarray(values), chance))
                del file[name]
                file[name] = values
            except (TypeError, ValueError):
                if name not in file:
                    file[name] = 0.0
            for key, value in about.items():
                file[name].attrs[key] = value


def changed(values, chance):
    import numpy as np

    kind = chance.randrange(9)
    if kind == 0:
        return values[:len(values) // 2] if values.ndim else values
    if kind == 1:
        return np.ravel(values)
    if kind == 2:
        return values[..., None]
    if kind == 3:
        return np.full(values.shape, np.nan)
    if kind == 4 and values.dtype.kind == "f" and values.size:
        values = values.copy()
        values.flat[chance.randrange(values.size)] = chance.choice((np.nan, np.inf, -1e300, 0))
        return values
    if kind == 5:
        return np.zeros(0)
    if kind == 6:
        return np.full(values.shape, b"word")
    if kind == 7:
        return np.zeros_like(values) if values.dtype.kind in "fi" else 3.0
    return -values[::-1] if values.ndim and values.dtype.kind in "fi" else 7


def damaged(path, chance):
    """Changes a file in its place, in a way that suits it or not."""
    path = Path(path)
    if path.is_dir():
        inside = sorted(p for p in path.rglob("*") if p.is_file())
        return damaged(chance.choice(inside), chance)
    raw = path.read_bytes()
    kind = chance.randrange(10)
    if path.suffix == ".h5" and kind < 7:
        return datasets(path, chance)
    if path.suffix in (".csv", ".opts", ".txt") and kind < 7:
        return path.write_bytes(cells(raw, chance))
    path.write_bytes(chance.choice((cut, flipped, zeroed, other))(raw, chance))


# ---- what is fed ----

COMMANDS = {
    "plot": ["plot tube.h5 --output o", "plot tube.h5 other.h5 --overlay --output o --panels width,shapes", "plot space.h5 --output o --view 30,20",
             "plot tube.h5 --panels touch,pressure,contact --times 2s,4s --output o", "plot critical.h5 --output o",
             "plot tube.h5 --titles a --beside other.h5 --panels norm --output o", "plot tube.h5 --dimensionless --panels energy,power --output o"],
    "animate": ["animate tube.h5 --frames 2 --output o.gif --from 0 --to 5s --rate 20", "animate space.h5 --frames 2 --output o.gif --turn 20 --field twist"],
    "view": ["view tube.h5 --output o.html", "view tube.h5 other.h5 --titles a,b --output o", "view space.h5 --output o"],
    "export": ["export tube.h5 --output o.vtp --time 2s --si", "export space.h5 --output o.glb --field axial --diameter 0.1",
               "export tube.h5 --output o.stl --walls"],
    "map": ["map sweep.h5 --axes friction_mu,growth_initial_length --quantity width --output o", "map sweep --axes friction_mu,growth_initial_length "
            "--quantity length --output o"],
    "ensemble": ["ensemble sweep.h5 --output o", "ensemble sweep --output o"],
    "stability": ["stability stability.h5 --run tube.h5 --output o", "stability critical.h5 --output o"],
    "growth_table": ["growth_table o.h5 --length 1 --end 0.5 --rate rate.csv --times 5 --labels 11", "growth_table o.h5 --length 1 --end 0.5 --rate exp(-d) "
                     "--from clamp --times 5 --labels 11 --unit"],
    "surface": ["surface line.csv o.csv --unit mm --origin start --direction start", "surface survey.csv o.csv --radius 0.1 --every 2",
                "surface line.json o.csv --radius 0.3 --line 0", "surface ball.ply o.h5 --spacing 0.5 --side outside --scale 1"],
    "measure": ["measure 4cm@rod.png --clamp 20,60 --along 200,60 --scale 0,0:100,0:2cm --output o", "measure rod.tif --clamp 20,60 --output o --points 20"],
    "fit": ["fit tube.opts points.csv -p si_friction_dry=0.2N/m:2N/m --starts 0 --accuracy 3e-2 --output o",
            "fit tube.opts force.csv -p si_friction_dry=0.2N/m:2N/m --starts 0 --accuracy 3e-2 --noise base_force_1=1mN --output o",
            "fit tube.opts tracks.h5 --fps 5 -p rod_curvature=-5/m:5/m --starts 0 --output o -- -si_friction_dry 1N/m",
            "fit tube.opts 3cm@root.rsml -p rod_curvature=-5/m:5/m --prior camera_x=0m:0.001m --starts 0 --accuracy 3e-2 --output o "
            "-- -si_friction_dry 1N/m"],
}


def functions(place):
    """{name: (function, its arguments)} of the package's own; names of files are in the place."""
    import tendril

    p = place
    r = tendril.load(p / "tube.h5") if (p / "tube.h5").is_file() else None
    scene = dict(growth_type="feed", growth_initial_length=1, rod_cells=20, ts_max_time=0.2)
    found = {
        "load": (tendril.load, dict(path=p / "tube.h5")),
        "run": (tendril.run, dict(scene=scene, friction_mu=0.5, progress=False, ranks=1, output=p / "o.h5")),
        "critical": (tendril.critical, dict(scene=dict(friction_beta=1e-6), tip_force=0.1)),
        "sweep": (tendril.sweep, dict(scene=scene, over={"friction_mu": [0, 1]}, jobs=1, directory=p / "s", progress=False)),
        "plot": (tendril.plot, dict(results=r, panels="width", times=["2s"], si=None, overlay=False, titles=["a"], beside=(), view=None)),
        "animate": (tendril.animate, dict(r=r, output=p / "o.gif", begin=0, end="5s", si=None, frames=2, rate=20, progress=False)),
        "view": (tendril.view, dict(results=r, output=p / "o.html", titles=["a"], si=None)),
        "map": (tendril.map, dict(sweep=p / "sweep.h5", axes=("friction_mu", "growth_initial_length"), quantity="width", si=False)),
        "ensemble": (tendril.ensemble, dict(place=p / "sweep.h5")),
        "surface": (tendril.surface, dict(source=p / "line.csv", output=p / "o.csv", origin="start", direction="start", scale=1, unit="mm",
                                          side="inside", radius=None, every=None, line=0)),
        "measure": (tendril.measure, dict(source=str(p / "rod.png"), clamp=(20, 60), scale=((0, 0), (100, 0), "2cm"), along=(200, 60), fps=None,
                                          every=1, frames=None, body="dark", width=None, ground="plain", points=20, pages=True, lens=(),
                                          checkerboard=None, board_picture=None)),
        "fit": (tendril.fit, dict(scene=p / "tube.opts", data=p / "force.csv", parameters={"si_friction_dry": ("0.2N/m", "2N/m")}, unit="", fps=None,
                                  y_down=None, priors=None, tied=None, noise=None, accuracy=3e-2, starts=0, seed=1, jobs=1, progress=False)),
        "circle": (tendril.circle, dict(centre=(0, 3), radius=1, inside=False, friction=0.1)),
        "plane": (tendril.plane, dict(point=(0, -1), normal=(0, 1), friction=None)),
        "polygon": (tendril.polygon, dict(corners=[(0, 1), (1, 1), (1, 2)], inside=False, friction=None)),
        "conduit": (tendril.conduit, dict(radius=1, points=[(0, 0), (5, 0)], friction=None)),
    }
    if r is not None:
        found |= {"at": (r.at, dict(t="2s", nearest=False)), "dataset": (r.dataset, dict(si=True)), "frame": (r.frame, dict(si=True)),
                  "to_csv": (r.to_csv, dict(path=p / "o.csv", si=True)), "to_vtk": (r.to_vtk, dict(path=p / "o.vtp", t="2s", si=True, walls=False)),
                  "to_mesh": (r.to_mesh, dict(path=p / "o.glb", t="2s", field="axial", diameter=None, sides=8, si=False, walls=False)),
                  "minimum": (r.minimum, dict(name="width")), "scale": (r.scale, dict(kind="length"))}
    return found


def things():
    """Arguments of another kind."""
    import numpy as np

    return [None, 3, -1, 0, 0.5, float("nan"), float("inf"), "x", "", "20s", b"x", True, [], (), {}, {"a": 1}, [1, 2, 3], ["a"], (1, 2), np.zeros((2, 2)),
            np.array(["a"]), object(), {"t": [1, 2]}, [[1], [1, 2]], Path("none.h5"), 10**12, "1e999", lambda: 0, {1: 2}, 1j]


# ---- one of them ----


def words_of(template, place, chance):
    """A command with one of its words damaged, or one of its files."""
    words = template.split(" ")
    files = [k for k, word in enumerate(words) if (place / word.rpartition("@")[2]).exists() and k]
    options = [k for k, word in enumerate(words) if word.startswith("-") and k + 1 < len(words)]
    told = None
    if chance.random() < 0.65 or not options:
        k = chance.choice(files) if files else 0
        if files:
            damaged(place / words[k].rpartition("@")[2], chance)
            told = words[k]
    elif chance.random() < 0.7:
        k = chance.choice(options)
        words[k + 1] = chance.choice(JUNK)
        told = words[k]
    else:
        k = chance.randrange(1, len(words))
        words[k:k + 1] = chance.choice(([], [words[k], words[k]], [chance.choice(JUNK)]))
    return words, told


def judged(code, said, warned, failure):
    """What is wrong with an end; "right" or "line" if nothing is."""
    lines = [line for line in said.splitlines() if line.strip()]
    if failure:
        return "traceback: " + failure
    if warned:
        return "warning: " + warned
    if code == 0:
        return "right" if not lines else "says on stderr: " + lines[0][:150]
    if code not in (1, 2):
        return f"unexpected: code {code}: {lines[-1][:200] if lines else ''}"
    if len(lines) != 1:
        return f"{len(lines)} lines: " + " | ".join(lines)[:200]
    return "line" if re.match(r"(tendril-py |python -m tendril )?[\w.\-/]+: \s*\S", lines[0]) else "no name: " + lines[0][:150]


def last_frame(error):
    own = [f for f in traceback.extract_tb(error.__traceback__) if "tendril" in f.filename]
    place = f"{Path(own[-1].filename).name}:{own[-1].lineno} {own[-1].name}" if own else "?"
    return f"{type(error).__name__}: {str(error)[:120]} at {place}"


@contextlib.contextmanager
def heard(err):
    """Adds what libraries of C write to the process' own stderr to what was said."""
    from tendril.errors import silenced

    with tempfile.TemporaryFile() as own:
        try:
            with silenced(own):
                yield
        finally:
            own.seek(0)
            err.write(own.read().decode(errors="replace"))


def command(template, place, chance):
    from tendril import __main__ as commands

    words, _ = words_of(template, place, chance)
    out, err, failure, code = io.StringIO(), io.StringIO(), "", None
    with heard(err), contextlib.redirect_stdout(out), contextlib.redirect_stderr(err), warnings.catch_warnings(record=True) as warned:
        warnings.simplefilter("always")
        try:
            code = commands.main(words)
        except SystemExit as end:
            code = end.code
        except BaseException as error:
            failure = last_frame(error)
    leaked = next((f"{w.category.__name__}: {w.message} ({Path(w.filename).name}:{w.lineno})" for w in warned
                   if issubclass(w.category, (RuntimeWarning, UserWarning))), "")
    return words, judged(code, err.getvalue(), leaked, failure), err.getvalue()


def function(name, place, chance):
    from tendril import TendrilError

    call, given = functions(place)[name]
    given = dict(given)
    files = [key for key, value in given.items() if isinstance(value, (str, Path)) and Path(value).is_file()]
    if files and chance.random() < 0.4:
        damaged(given[chance.choice(files)], chance)
    else:
        for _ in range(chance.choice((1, 1, 2))):
            given[chance.choice(list(given))] = chance.choice(things())
    out, err, end = io.StringIO(), io.StringIO(), "right"
    with heard(err), contextlib.redirect_stdout(out), contextlib.redirect_stderr(err), warnings.catch_warnings(record=True) as warned:
        warnings.simplefilter("always")
        try:
            call(**given)
        except TendrilError as error:
            end = "line" if "\n" not in str(error).strip() and str(error).strip() else f"several lines: {str(error)[:150]!r}"
        except OSError as error:
            end = "line" if error.filename or error.strerror else "traceback: " + last_frame(error)
        except BaseException as error:
            end = "traceback: " + last_frame(error)
    leaked = next((f"warning: {w.category.__name__}: {w.message} ({Path(w.filename).name}:{w.lineno})" for w in warned
                   if issubclass(w.category, (RuntimeWarning, UserWarning))), "")
    if err.getvalue().strip() and end in ("right", "line"):
        end = "says on stderr: " + err.getvalue().strip()[:150]
    return [name, {key: value for key, value in given.items()}], leaked or end, err.getvalue()


def work(what, template, source, seed, queue):
    """One damage, in a directory of its own."""
    os.environ["TENDRIL_CACHE"] = ""
    chance = random.Random(f"{what}-{seed}")
    with tempfile.TemporaryDirectory(prefix="tendril-") as place:
        place = Path(place)
        shutil.copytree(source, place, dirs_exist_ok=True)
        os.chdir(place)
        try:
            words, end, said = function(template, place, chance) if what.startswith("py.") else command(template, place, chance)
        finally:
            os.chdir("/")
    queue.put((str(words)[:300], end, said.strip()[:300]))


def batch(what, templates, source, seeds, queue):
    import matplotlib

    matplotlib.use("Agg")
    for seed in seeds:
        queue.put(seed)
        work(what, templates[seed % len(templates)], source, seed, queue)
    queue.put(None)


def fed(what, templates, source, seeds):
    """[(seed, words, how it ended, what it said)]; in a process of its own, which may die."""
    found, seeds = [], list(seeds)
    while seeds:
        queue = multiprocessing.get_context("fork").Queue()
        process = multiprocessing.get_context("fork").Process(target=batch, args=(what, templates, source, seeds, queue))
        process.start()
        now = None
        while True:
            try:
                got = queue.get(timeout=SECONDS)
            except Exception:
                died = not process.is_alive()
                found.append((now, "", "died" if died else "hangs", ""))
                process.kill()
                seeds = [seed for seed in seeds if now is not None and seed > now]
                break
            if got is None:
                seeds = []
                break
            if isinstance(got, int):
                now = got
            else:
                found.append((now, *got))
        process.join()
    return found


def everything():
    """{name: templates}, commands and functions."""
    names = ("load run critical sweep plot animate view map ensemble surface measure fit circle plane polygon conduit at dataset frame to_csv to_vtk "
             "to_mesh minimum scale").split()
    return COMMANDS | {f"py.{name}": [name] for name in names}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program")
    parser.add_argument("--count", type=int, default=500)
    parser.add_argument("--only", default="")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--show", action="store_true", help="each line that was said, too")
    choice = parser.parse_args()
    os.environ["TENDRIL"] = str(Path(choice.program).resolve())
    wanted, bad = [name for name in choice.only.split(",") if name], 0
    with tempfile.TemporaryDirectory(prefix="tendril-") as place:
        made(Path(place))
        for what, templates in everything().items():
            if wanted and what not in wanted:
                continue
            count = choice.count // 5 if what in SLOW else choice.count
            found = fed(what, templates, place, range(choice.seed, choice.seed + count))
            ends = [end for _, _, end, _ in found]
            wrong = [one for one in found if one[2] not in ("right", "line")]
            bad += len(wrong)
            print(f"{what}: {len(found)} damages, {ends.count('right')} right, {ends.count('line')} in a line, {len(wrong)} else", flush=True)
            for seed, words, end, said in wrong:
                print(f"  {seed} {words}\n      {end}", flush=True)
            if choice.show:
                for line in sorted({said for *_, end, said in found if end == "line"}):
                    print(f"    {line}")
    return 1 if bad else 0


if __name__ == "__main__":
    sys.exit(main())

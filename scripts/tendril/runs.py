"""Runs tendril and reads what it leaves.

    r = tendril.run("options/feed.opts", friction_mu=0.5, ts_max_time=12)
    r = tendril.run(growth_type="feed", si_bending_stiffness="2.2Nmm^2", si_friction_dry="0.5N/m",
                    si_speed="5mm/s", stop_length="30cm", rod_curvature="3/m", output="tube.h5")

Options are those of docs/options.md, without the dash. A value is a number, text ("30cm", "feed"),
True for a flag; pairs for what is written 0:1,3:2.5; and for a file of arrays a dict of them:

    tendril.run(rod_stiffness_file={"distance": [0, 1, 2, 3], "factor": [0.1, 0.5, 1, 1]})
    tendril.run(rod_curvature_file={"distance": ([0, 1, 2, 3], "cm"), "curvature": (k, "1/cm")}, ...)

Walls are text, a line each, or what plane(), circle(), polygon() and conduit() give:

    tendril.run("feed", contact_diameter=0.1, wall_file=[tendril.circle((4, 0.5), 1, friction=0.3)])
"""

from __future__ import annotations

import hashlib
import logging
import os
import re
import shlex
import shutil
import signal
import subprocess
import sysconfig
import tempfile
import time
from dataclasses import dataclass, replace
from functools import lru_cache
from numbers import Real
from pathlib import Path

import h5py
import numpy as np

from .errors import RunError, TendrilError, arguments, briefly_shown, path_of, positive
from .loading import load
from .naming import did_you_mean
from .progress import bar
from .results import Results

CHECKOUT = Path(__file__).resolve().parents[2]
# Open MPI refuses root without the first two; one thread each, for BLAS
ENVIRONMENT = {"OMPI_ALLOW_RUN_AS_ROOT": "1", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1",
               "OMP_NUM_THREADS": "1"}
# A single process needs no daemon, and no network to be looked for: it starts in half the time.
SINGLE = {"OMPI_MCA_ess_singleton_isolated": "1", "OMPI_MCA_pml": "ob1", "OMPI_MCA_btl": "self"}
# Several run wherever they may (by one name up to version 4 of Open MPI, by another from 5 on).
SEVERAL = {"OMPI_MCA_rmaps_base_oversubscribe": "1", "OMPI_MCA_hwloc_base_binding_policy": "none",
           "PRTE_MCA_rmaps_default_mapping_policy": ":oversubscribe",
           "PRTE_MCA_hwloc_default_binding_policy": "none"}
TRIES = 3  # now and then MPI itself does not start on a busy machine, which says nothing of the run
SHAPES = 80  # stored of a run of which nothing says how many: enough for any time between them
LOG = logging.getLogger("tendril")
WALL = re.compile(r"[a-z]+( (inside|outside))?( [-+.0-9]\S*){3}")  # a line of a wall_file
SECONDS_LEFT = re.compile(r"([0-9.]+) s$")


def executable() -> str:
    """The program: what the variable TENDRIL names; else build/tendril of the checkout that this
    package lies in; else that which was installed with it; else build/tendril of the working directory;
    else tendril on the PATH."""
    if os.environ.get("TENDRIL"):
        found = shutil.which(os.environ["TENDRIL"])
        if not found:
            raise TendrilError(f"TENDRIL={os.environ['TENDRIL']}: no executable")
        return found
    for place in (CHECKOUT / "build", Path(sysconfig.get_path("scripts")), Path.cwd() / "build"):
        if found := shutil.which(place / "tendril"):
            return found
    if found := shutil.which("tendril"):
        return found
    raise TendrilError("no executable tendril: build it (scripts/run.sh does), put it on the PATH, or "
                       "name it in the variable TENDRIL")


@lru_cache
def options_known_to(program) -> tuple[str, ...]:
    """The names of the options that a program says it has; none if it does not say."""
    done = subprocess.run([program, "-help"], capture_output=True, text=True, errors="replace", stdin=subprocess.DEVNULL,
                          env=os.environ | ENVIRONMENT | SINGLE)
    return tuple(re.findall(r"^  -(\w+) +<", done.stdout, re.MULTILINE))


def check_names(names):
    """Refuses names that are of no option of tendril's own, with the likeliest that is."""
    known = options_known_to(executable())
    for name in names:
        if known and name not in known:
            raise RunError(f"{name}: unknown option{did_you_mean(name, known) or '; docs/options.md has all'}")


def text_of(value) -> str:
    """An option's value as tendril reads it."""
    if isinstance(value, (bool, np.bool_)):
        return "true" if value else "false"
    if isinstance(value, (int, np.integer)):
        return str(int(value))
    if isinstance(value, (float, np.floating)):
        return repr(float(value))
    if isinstance(value, (list, tuple)):
        return ",".join(":".join(text_of(v) for v in pair) if isinstance(pair, (list, tuple))
                        else text_of(pair) for pair in value)
    return re.sub(r"^([-+]?[0-9.]+(?:[eE][-+]?[0-9]+)?) +(\S+)$", r"\1\2", str(value))  # "5 mm/s"


def write_arrays(path, arrays):
    """A dict of arrays as the HDF5 file that an option names; one with a unit is (values, "cm")."""
    with h5py.File(path, "w") as file:
        for name, values in arrays.items():
            values, *unit = values if isinstance(values, tuple) and isinstance(values[-1], str) else [values]
            try:
                file[name.lstrip("/")] = np.asarray(values, float)
            except (TypeError, ValueError):
                raise TendrilError(f"{name}: give numbers in rows of one length, or such with their unit, ([0, 1], \"cm\")") from None
            if unit:
                file[name.lstrip("/")].attrs["units"] = unit[0]
    return str(path)


def named_by(content: bytes, directory, name, ending):
    """A file for an option, with a name that tells its content: another one is another option."""
    return Path(directory) / f"{name}-{hashlib.sha256(content).hexdigest()[:8]}.{ending}"


def file_of(name, value, directory) -> str:
    """The file that stands for a value that is none of a command line: arrays, or walls."""
    if isinstance(value, dict):
        if name == "wall_file":
            raise TendrilError("wall_file: give the name of a file, or a list of walls, as of circle() or lines of text")
        if odd := [key for key in value if not isinstance(key, str)]:
            raise TendrilError(f"{name}: {briefly_shown(odd[0])}: is no name of an array; give text")
        content = repr([(k, v[0].tolist(), *v[1:]) if isinstance(v, tuple) and isinstance(v[0], np.ndarray)
                        else (k, np.asarray(v, object).tolist()) for k, v in value.items()]).encode()
        return write_arrays(named_by(content, directory, name, "h5"), value)
    text = "".join(f"{text_of_wall(wall)}\n" for wall in value)
    path = named_by(text.encode(), directory, name, "txt")
    path.write_text(text)
    return str(path)


def text_of_wall(wall) -> str:
    """A line of -wall_file: text as it is, or its words, ("circle", 3, 0, 1, "friction", 0.3)."""
    words = [wall] if isinstance(wall, str) else wall if isinstance(wall, (list, tuple, np.ndarray)) else []
    try:
        flat = [one for word in words for one in np.ravel(np.asarray(word, object))]
    except ValueError:  # arrays of several shapes in one
        flat = []
    if not flat or not all(isinstance(one, (str, Real, os.PathLike)) for one in flat):
        raise TendrilError(f"wall_file: {wall!r} is no wall; give a list of them, as of circle() or lines of text")
    return " ".join(text_of(one) for one in flat)


def words_of(options, directory) -> list[str]:
    """Options as words of a command line; arrays and walls go into files in the directory. None is left
    out."""
    words = []
    for name, value in options.items():
        if not isinstance(name, str):
            raise TendrilError(f"{briefly_shown(name)}: is no name of an option; give text")
        name = name.lstrip("-")
        if name == "wall_file" and isinstance(value, str) and WALL.match(value) and not Path(value).exists():
            value = [value]  # one wall by itself
        if isinstance(value, dict) or name == "wall_file" and isinstance(value, (list, tuple)):
            value = file_of(name, value, directory)
        if value is not None:
            words += [f"-{name}", text_of(value)]
    return words


def texts_of(options, directory) -> dict[str, str]:
    """{option: its value as tendril reads it}; arrays go into files in the directory."""
    words = words_of(options, directory)
    return dict(zip((word[1:] for word in words[::2]), words[1::2]))


def scene_file(name) -> Path:
    """An options file, or the scene of that name: of this package, of the working directory, or of where
    the program comes from, its checkout or what was installed with it."""
    if not isinstance(name, (str, os.PathLike)):
        raise TendrilError(f"scene: give an options file, the name of a scene or a dict, not {type(name).__name__}")
    if Path(name).is_file():
        return Path(name)
    program = Path(executable()).resolve().parents[1]
    places = [place / "options" for place in (Path(__file__).parent, Path.cwd(), program, program / "share/tendril")]
    for place in places:
        if (known := place / f"{name}.opts").is_file():
            return known
    scenes = sorted({file.stem for place in places for file in place.glob("*.opts")})
    raise TendrilError(f"{name}: no options file, and no scene of that name{did_you_mean(name, scenes)}")


def scene_words(scene, directory) -> list[str]:
    """A scene: an options file, the name of one in options/, options as a dict, or nothing."""
    if scene is None:
        return []
    if isinstance(scene, dict):
        return words_of(scene, directory)
    return ["-options_file", str(scene_file(scene))]


def follow(process, progress):
    """Reads what a run prints, and shows how far it is by the time that it says is left."""
    said, begin = [], time.perf_counter()
    form = "{desc}: {percentage:3.0f}%|{bar}| {elapsed}<{remaining}"
    with bar(progress, 1.0, form) as shown:
        for line in process.stdout:
            said.append(line)
            if left := SECONDS_LEFT.search(line):
                elapsed = time.perf_counter() - begin
                done = elapsed / (elapsed + float(left[1]))
                shown.update(max(0, done - shown.n))
    return "".join(said)


def start(command, progress):
    """(exit code, what it printed, what it complained of) of one run."""
    alone = command[0] == executable()
    environment = os.environ | ENVIRONMENT | (SINGLE if alone else SEVERAL)
    # Ctrl-C in a terminal is for all in the foreground; mpiexec would make an end of its own of it
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, errors="replace",
                          stdin=subprocess.DEVNULL, env=environment, start_new_session=not alone) as process:
        try:
            said = follow(process, progress)
            complaint = process.stderr.read()
        except KeyboardInterrupt:
            # it stores what it has, and ends; mpiexec hands SIGUSR1 on, and does nothing more
            process.send_signal(signal.SIGINT if alone else signal.SIGUSR1)
            process.wait()
            raise
    return process.returncode, said, complaint


def plain_line(complaint, code):
    """tendril's own line among what MPI may have added."""
    lines = complaint.strip().splitlines()
    own = [line for line in lines if line.startswith("tendril: ")]
    return own[-1][len("tendril: "):] if own else (lines or [f"ended with exit code {code}"])[-1]


def execute(command, output=None, progress=False) -> str:
    """Runs a command line of tendril; what it printed. Raises RunError with tendril's own line."""
    for _ in range(TRIES):
        LOG.info("%s", shlex.join(map(str, command)))
        code, said, complaint = start(command, progress)
        LOG.debug("%s", said)
        if code == 0:
            return said
        if "before MPI_INIT" not in complaint:
            break
    stored = None
    if output and Path(output).is_file():
        try:
            stored = load(output)
        except TendrilError:
            pass  # it was refused before it wrote there
    raise RunError(plain_line(complaint, code), command, stored)


def lines_of(file) -> list[str]:
    """The lines of an options file, in whatever coding its comments are: the program says what is wrong with it."""
    return Path(file).read_text(errors="replace").splitlines()


def rows_of(file) -> list[list[str]]:
    """The options of an options file, each with its value behind it."""
    return [row for line in lines_of(file) if (row := line.partition("#")[0].split())]


def task_of(words) -> str:
    """What a command line does."""
    task = "grow"
    for word, value in zip(words, words[1:]):
        if word == "-options_file":
            task = next((row[1].strip("'\"") for row in rows_of(value)[::-1] if row[0] == "-task" and row[1:]), task)
        elif word == "-task":
            task = value
    return task


def says_when(words) -> bool:
    """Whether a command line, or an options file that it names, says when shapes are stored."""
    wanted = ("-output_interval", "-output_shapes")
    files = [value for word, value in zip(words, words[1:]) if word == "-options_file"]
    return any(word in wanted for word in [*words, *(row[0] for file in files for row in rows_of(file))])


def launched(ranks: int) -> list[str]:
    """The beginning of a command line on so many ranks."""
    mpiexec = os.environ.get("MPIEXEC", "mpiexec")
    return [*([mpiexec, "-n", str(ranks)] if positive(ranks, "ranks") > 1 else []), executable()]


def named_in(scene) -> list[str]:
    """The rods that have a section in an options file."""
    if not isinstance(scene, (str, os.PathLike)):
        return []
    return [found[1] for line in lines_of(scene_file(scene)) if (found := re.match(r"\s*\[\s*rod\s+(\w+)\s*\]", line))]


def table_file(name, table, directory) -> str:
    """A DataFrame as the table of a section [rods FILE.csv]; without a column `name` rods are called by its index, or NAME1 on.
    What a rod has no value for it is not given."""
    if "name" not in table:
        own = table.index if table.index.dtype == object else [f"{name}{k + 1}" for k in range(len(table))]
        table = table.assign(name=own)
    path = Path(directory) / f"{name}.csv"
    there = table.notna()
    texts = {key: [text_of(cell) if given else "" for cell, given in zip(table[key], there[key])] for key in table}
    type(table)(texts).to_csv(path, index=False)
    return path.name


def rod_words(scene, rods, pairs, directory) -> list[str]:
    """The scene and its rods as words of a command line: rods that it names itself are given their options by prefix, others
    have sections in a file of their own, that of the scene before them."""
    if not rods and not pairs:
        return scene_words(scene, directory)
    known, prefixed, lines = named_in(scene), [], []
    for name, own in (rods or {}).items():
        if hasattr(own, "to_csv"):
            lines.append(f"[rods {table_file(name, own, directory)}]")
        elif not isinstance(own, dict):
            raise TendrilError(f"rods: {name}: give a dict of options, or a DataFrame with a row a rod, not {type(own).__name__}")
        elif name in known:
            prefixed += [word for key, value in texts_of(own, directory).items() for word in (f"-{name}_{key}", value)]
        else:
            lines += [f"[rod {name}]", *(f"-{key} {value}" for key, value in texts_of(own, directory).items())]
    for pair, own in (pairs or {}).items():
        lines += [f"[pair {' '.join(pair)}]", *(f"-{key} {value}" for key, value in texts_of(own, directory).items())]
    words = scene_words(scene, directory)
    if lines:
        path = Path(directory) / "rods.opts"
        path.write_text("\n".join(lines) + "\n")
        words += ["-options_file", str(path)]
    return words + prefixed


@arguments(output="file?", progress="flag?")
def run(scene=None, *, rods=None, pairs=None, output=None, progress: bool | None = None, ranks: int = 1,
        **options) -> Results:
    """Runs a scene and returns its results, which are dimensionless as in the file.

    scene     an options file, the name of one in options/, a dict of options, or None
    rods      of several in one run, {name: dict of its options, or a DataFrame with a row a rod}; what the scene and options
              say all share
    pairs     {(name, name): dict of options} of what touches
    output    the result file, if it is to be kept
    progress  a bar; None: in a terminal and in a notebook
    ranks     processes of one run, by mpiexec
    options   those of docs/options.md; they override the scene's. Where neither says when shapes are
              stored, 80 are

    Raises RunError, with tendril's own line, for a run that is refused or gives up; what was stored
    until then is in its .results."""
    with tempfile.TemporaryDirectory(prefix="tendril-") as directory:
        name = Path(scene).stem if isinstance(scene, (str, Path)) else "run"
        output = path_of(output or Path(directory) / f"{name}.h5", "output")
        words = [*rod_words(scene, rods, pairs, directory), *words_of(options, directory)]
        if task_of(words) == "grow" and not options.get("restart") and not says_when(words):
            words += ["-output_shapes", str(SHAPES)]
        execute([*launched(ranks), *words, "-output", str(output)], output, progress)
        return load(output)


@dataclass(repr=False)
class Critical:
    """When the straight rod gives way."""

    t: float  # in units of l/V
    length: float  # in units of l
    error: float  # a bound on that of the length
    frequency: float  # of the flutter, rad per unit of time; 0: it buckles
    s: np.ndarray  # [n], labels of the mode
    y: np.ndarray  # [n], its deflection, largest 1
    results: Results

    def __repr__(self):
        kind = f"flutter, frequency {self.frequency:.6g}" if self.flutters else "buckling"
        return f"<t = {self.t:.10g}, length {self.length:.10g}, {kind}>"

    @property
    def flutters(self) -> bool:
        return self.frequency > 0

    def in_si(self) -> Critical:
        """The same in seconds, metres and radians per second."""
        scale = self.results.scale
        return replace(self, t=self.t * scale("time"), length=self.length * scale("length"),
                       error=self.error * scale("length"),
                       frequency=self.frequency / scale("time"))


def critical(scene=None, **options) -> Critical:
    """The length at which the straight rod gives way; scene and options as for run."""
    if options.pop("task", "critical") != "critical":
        raise TendrilError("critical: leaves no choice of a task; run() does")
    r = run(scene, task="critical", **options)
    numbers = (float(r.critical[name]) for name in ("t", "length", "error", "frequency"))
    return Critical(*numbers, r.critical.s, r.critical.y, r)

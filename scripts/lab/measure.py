"""Runs one configuration, times it, measures its error and gives a verdict. Used by chart.py,
atlas.py and the tests.

    run = measure(Case("tendril", SCENES["short"], "-ts_rtol 1e-4"))
    run["verdict"], run["error"], run["seconds"], run["work"]

A case is a solver (tendril, tendril_before, paper_fem, pyelastica), a scene and further options. Its error is the
largest relative error of tip, |x2| and energy at the scene's times, against the independent
reference in tests/reference/ or, where there is none, against a much finer run of tendril. Every
result is a line of JSON in a store, so that a script that was stopped goes on where it was.
"""

import hashlib
import json
import os
import re
import shlex
import signal
import subprocess
import sys
import tempfile
import threading
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from itertools import zip_longest
from pathlib import Path

import h5py
import numpy as np

ROOT = Path(__file__).resolve().parent.parent.parent
REFERENCES = ROOT / "tests" / "reference"
PEERS = ROOT / "scripts" / "lab" / "peers"
TENDRIL = os.environ.get("TENDRIL", str(ROOT / "build" / "tendril"))
BEFORE = os.environ.get("TENDRIL_BEFORE")  # an earlier version, to be charted beside it
# mpiexec is not needed for one rank; the isolated singleton starts no daemon
ENVIRONMENT = dict(os.environ, OMPI_ALLOW_RUN_AS_ROOT="1", OMPI_ALLOW_RUN_AS_ROOT_CONFIRM="1",
                   OMPI_MCA_ess_singleton_isolated="1", OMP_NUM_THREADS="1",
                   OPENBLAS_NUM_THREADS="1")
CORES = len(os.sched_getaffinity(0))
RIGHT = 1e-2  # a finished run with a larger error is wrong

# verdicts
RIGHT_, WRONG, GAVE_UP, REFUSED, CRASHED, HUNG = ("right", "wrong", "gave up", "not supported",
                                                  "crashed", "hung")
QUANTITIES = ("tip", "norm_x2", "energy")


@dataclass(frozen=True)
class Scene:
    name: str
    options: str
    times: tuple            # where it is measured; the last one ends the run
    reference: str = ""     # file in tests/reference, or empty: a finer run
    finer: str = "-rod_cells 2000 -ts_rtol 1e-9"
    quantities: tuple = QUANTITIES
    exact: tuple = ()       # their values at these times, where they are known

    @property
    def interval(self):
        """The largest output interval that hits all times (several are multiples of 0.1)."""
        if len(self.times) == 1:
            return self.times[0]
        return int(np.gcd.reduce(np.round(10 * np.array(self.times)).astype(int))) / 10

    def words(self):
        return [*shlex.split(self.options), "-ts_max_time", f"{self.times[-1]:g}",
                "-output_interval", f"{self.interval:g}"]


def from_reference(name, options, reference, times=None):
    known = [line["t"] for line in read_lines(REFERENCES / f"{reference}.json")]
    return Scene(name, options, tuple(times or known), reference)


def read_lines(path):
    return [json.loads(line) for line in Path(path).read_text().splitlines() if line.strip()]


DECAY = "-growth_initial_length 0.5 -shape_amplitude 0.01"
THICK = "-growth_initial_length 2 -shape_amplitude 0.1"
SCENES = {scene.name: scene for scene in (
    from_reference("decay", DECAY, "v_decay_mu1", (1.5, 8, 12)),
    from_reference("folded", DECAY, "v_decay_mu1", (15, 20, 30, 40)),
    from_reference("short", THICK, "v_short"),
    Scene("gaussian", "-growth_type gaussian -growth_width 0.05 " + THICK, (2, 5, 10)),
    from_reference("feed", "-growth_type feed " + THICK, "v_feed"),
    # a tip on a frictionless plane, D/L = 0.7 (docs/notes/contact-measured.md, answer A)
    Scene("contact", "-growth_type feed -growth_initial_length 0.0068 -shape_type straight "
          "-rod_curvature 1e-4 -friction_mu 0 -wall_file options/data/plane.txt", (0.0032,),
          quantities=("base_force_1", "tip_x2"),
          exact=((2.9132575585e4, 6.2862520886e-3),)),
)}


@dataclass(frozen=True)
class Case:
    solver: str
    scene: Scene
    options: str = ""
    limit: float = 60   # seconds, then it hangs
    repeat: int = 1     # the fastest counts

    @property
    def key(self):
        text = " ".join((self.solver, *self.scene.words(), str(self.scene.times), self.options))
        return hashlib.sha1(text.encode()).hexdigest()[:16]


class Store:
    """Results by key, one line of JSON each."""

    def __init__(self, path):
        self.path = Path(path)
        self.path.parent.mkdir(parents=True, exist_ok=True)
        self.lock = threading.Lock()
        self.runs = {}
        if self.path.exists():
            for line in self.path.read_text().splitlines():
                try:
                    run = json.loads(line)
                    self.runs[run["key"]] = run
                except (ValueError, KeyError):
                    pass  # cut short by an interruption

    def keep(self, run):
        with self.lock, self.path.open("a") as file:
            self.runs[run["key"]] = run
            file.write(json.dumps(run) + "\n")

    def get(self, case, again=False):
        """The result of a case: from the store, else measured and kept."""
        if again or case.key not in self.runs:
            self.keep(measure(case, self))
        return self.runs[case.key]

    def get_all(self, named, jobs, again=()):
        """Measures what is not yet stored of [(name, case)], so many at a time, one to a core;
        prints a line for each."""
        new = [(n, c) for n, c in named if c.key not in self.runs or c.key in again]
        print(f"{len(new)} of {len(named)} runs to do, {jobs} at a time", flush=True)
        with ThreadPoolExecutor(jobs) as pool:
            list(pool.map(self.reference, dict.fromkeys(c.scene for _, c in new)))
            runs = pool.map(lambda case: self.get(case, again=case.key in again),
                            [c for _, c in new])
            for (name, _), run in zip(new, runs):
                say(dict(run, scene=name))

    def reference(self, scene):
        """[{t, tip, norm_x2, energy}] at the scene's times, or what else is compared there."""
        if scene.exact:
            return [dict(zip(("t", *scene.quantities), (t, *values)))
                    for t, values in zip(scene.times, scene.exact)]
        if scene.reference:
            lines = read_lines(REFERENCES / f"{scene.reference}.json")
            return [next(l for l in lines if abs(l["t"] - t) < 1e-9) for t in scene.times]
        for finer in scene.finer.split("|"):  # the first that finishes
            case = Case("tendril", scene, finer, limit=600)
            key = "reference-" + case.key
            if key in self.runs:
                return self.runs[key]["values"]
        for finer in scene.finer.split("|"):
            case = Case("tendril", scene, finer, limit=600)
            key = "reference-" + case.key
            state, values = run_tendril(case)
            if state["exit"] == 0:
                break
        else:
            raise RuntimeError(f"{scene.name}: no reference: {state['message']}")
        if key not in self.runs:
            self.keep({"key": key, "values": values, "seconds": state["seconds"],
                       "options": finer})
        return self.runs[key]["values"]


def workplace(name, quick):
    """(where the pictures and tables of a study go, its store); a quick one has its own."""
    name += "-quick" * quick
    place = ROOT / "results" / name if quick else ROOT / "docs" / "notes"
    place.mkdir(parents=True, exist_ok=True)
    return place, Store(ROOT / "results" / name / "runs.jsonl")


def execute(command, limit):
    """(exit code, or None when stopped at the limit; stdout; stderr; seconds of processor time, which
    is what the limit is for). On a busy machine MPI now and then fails to start: that says nothing
    about the run, which is then repeated."""
    for _ in range(3):
        result = execute_once(command, limit)
        if "before MPI_INIT" not in result[2]:
            break
    return result


IDLE = 20  # times the limit: a run that waits for something for so long hangs, too


def execute_once(command, limit):
    with tempfile.TemporaryFile("w+") as out, tempfile.TemporaryFile("w+") as err:
        run = subprocess.Popen(
            ["prlimit", f"--cpu={max(1, round(limit))}", *command], stdout=out, stderr=err,
            stdin=subprocess.DEVNULL, env=ENVIRONMENT, start_new_session=True)
        idle = threading.Timer(IDLE * limit, os.killpg, (run.pid, signal.SIGKILL))
        idle.start()
        _, status, used = os.wait4(run.pid, 0)
        idle.cancel()
        run.returncode = code = os.waitstatus_to_exitcode(status)
        seconds = used.ru_utime + used.ru_stime
        if code in (-signal.SIGXCPU, -signal.SIGKILL) or seconds > limit and code:
            code = None
        out.seek(0)
        err.seek(0)
        return code, out.read(), err.read(), seconds


def lagrange(times, values, t):
    """At t, the polynomial through these points."""
    return sum(values[i] * np.prod([(t - times[j]) / (times[i] - times[j])
                                    for j in range(len(times)) if j != i])
               for i in range(len(times)))


def series_at(t_steps, values, t):
    """A positive series at any time: the logarithm's polynomial through the steps around it."""
    i = int(np.abs(t_steps - t).argmin())
    if abs(t_steps[i] - t) < 1e-9 * max(1, t):
        return float(values[i])
    i = int(np.clip(np.searchsorted(t_steps, t) - 3, 0, max(0, len(t_steps) - 6)))
    with np.errstate(divide="ignore", invalid="ignore"):
        return float(np.exp(lagrange(t_steps[i:i + 6], np.log(values[i:i + 6]), t)))


def read_output(file, scene):
    with h5py.File(file) as f:
        series = {name: data[:] for name, data in f["series"].items()}
        t_shapes, x = f["shapes/t"][:], f["shapes/x"][:, -1]
        nodes = f["shapes/s"].shape[0]
    values, names = [], dict.fromkeys(QUANTITIES[1:] + scene.quantities)
    names.pop("tip", None)
    for t in scene.times:
        i = int(np.abs(t_shapes - t).argmin())
        if abs(t_shapes[i] - t) > 1e-6:
            break
        values.append({"t": t, "tip": x[i].tolist(),
                       **{k: series_at(series["t"], series[k], t) for k in names}})
    return series, values, nodes


def run_tendril(case):
    """(state of the run, values at the times it reached)"""
    with tempfile.TemporaryDirectory() as scratch:
        file = Path(scratch) / "run.h5"
        program = BEFORE if case.solver == "tendril_before" else TENDRIL
        command = [program, *case.scene.words(), *shlex.split(case.options), "-output", str(file)]
        code, out, err, seconds = execute(command, case.limit)
        state = {"exit": code, "message": (err.strip().splitlines() or [""])[-1],
                 "process_seconds": seconds, "traceback": "PETSC ERROR" in err}
        values = []
        try:
            series, values, nodes = read_output(file, case.scene)
            fields = np.array([1, 6, 3, 13])[series["model"].astype(int)]
            state["steps"] = len(series["t"]) - 1
            state["newton"] = int(series["newton_iterations"].sum())
            state["work"] = float((series["newton_iterations"] * fields).sum() * nodes)
            state["reached"] = float(series["t"][-1])
        except (OSError, KeyError, ValueError):
            pass
        found = re.search(r"Newton iterations, ([0-9.e+-]+) s", out)
        # of the time loop; on a busy machine the whole process may have used less
        state["seconds"] = min(seconds, float(found.group(1))) if found else seconds
        found = re.search(r"(\d+) rejected", out)
        state["rejected"] = int(found.group(1)) if found else 0
        found = re.search(r"the largest of the run: \S+ ([0-9.e+-]+)", out) or re.search(r"error estimate ([0-9.e+-]+)", out)
        if found:
            state["estimate"] = float(found.group(1))
    return state, values


def run_peer(case):
    """A peer prints JSON lines: {"t":, "tip":, "norm_x2":, "energy":} and at the end
    {"seconds":, "steps":, "newton":, "work":} or {"failed": "why"}."""
    python = {"paper_fem": "/usr/bin/python3"}.get(case.solver,
                                                   str(ROOT / "results/peers/venv/bin/python"))
    command = [python, str(PEERS / f"{case.solver}.py"), *case.scene.words(),
               "-times", ",".join(f"{t:g}" for t in case.scene.times), *shlex.split(case.options)]
    code, out, err, seconds = execute(command, case.limit)
    state = {"exit": code, "message": (err.strip().splitlines() or [""])[-1],
             "process_seconds": seconds, "seconds": seconds, "traceback": False}
    values = []
    for line in out.splitlines():
        try:
            entry = json.loads(line)
        except ValueError:
            continue
        if "tip" in entry:
            values.append(entry)
        elif isinstance(entry, dict):
            state.update(entry)
    return state, values


def errors(values, reference, quantities=QUANTITIES):
    """The largest relative error of each quantity."""
    worst = dict.fromkeys(quantities, 0.0)
    for value, exact in zip(values, reference):
        for k in quantities:
            if k == "tip":
                off = [a - b for a, b in zip_longest(value["tip"], exact["tip"], fillvalue=0)]  # plane, space
                e = np.linalg.norm(off) / np.linalg.norm(exact["tip"])
            else:
                # (a straight rod on a plane may turn to either side: the size counts)
                e = abs(abs(value[k]) / exact[k] - 1) if exact[k] else float(value[k] != 0)
            worst[k] = max(worst[k], float(e) if np.isfinite(e) else np.inf)
    return worst


def reason_of(state, verdict):
    """A short code: why it did not do what it should."""
    text = state.get("failed", "") or state["message"]
    if verdict in (RIGHT_, WRONG):
        return ""
    if verdict == HUNG:
        return "time limit"
    if verdict == CRASHED:
        return "signal" if (state["exit"] or 0) < 0 else "traceback"
    for code, pattern in (("angle", "where an angle reached"),
                          ("zero pivot", r"pivot|LU failed"),
                          ("newton", r"Newton|NONLINEAR|SNES"), ("rejections", r"REJECTED"),
                          ("step", r"gave up|crawls at|STEP"), ("jammed", r"jammed at"), ("refused", r".")):
        if re.search(pattern, text):
            return code
    return "silent"


def measure(case, store):
    """One result: the options, the cost, the errors, the verdict and its reason."""
    run = run_tendril if case.solver.startswith("tendril") else run_peer
    state, values = run(case)
    for _ in range(case.repeat - 1):
        if state["exit"] == 0 and state["seconds"] < 2:
            state["seconds"] = min(state["seconds"], run(case)[0]["seconds"])
    result = {"key": case.key, "solver": case.solver, "scene": case.scene.name,
              "scene_options": case.scene.options, "options": case.options, **state}
    if state["exit"] is None:
        verdict = HUNG
    elif state["exit"] == 3:
        verdict = REFUSED  # by a peer
    elif state["exit"] < 0 or state["traceback"] or "Traceback" in state["message"]:
        verdict = CRASHED
    elif state["exit"]:
        verdict = GAVE_UP if "failed" in state or re.search(
            "gave up|failed|stopped at|jammed at|crawls at|-ts_max_steps", state["message"]) \
            else REFUSED
    else:
        reference = store.reference(case.scene)
        result.update(errors(values, reference, case.scene.quantities))
        if len(values) < len(reference):
            result["error"] = np.inf
        else:
            result["error"] = max(result[k] for k in case.scene.quantities)
        verdict = RIGHT_ if result["error"] <= RIGHT else WRONG
    result["verdict"], result["reason"] = verdict, reason_of(state, verdict)
    return result


def short(run):
    error = f"{run['error']:8.1e}" if "error" in run else " " * 8
    return (f"{run['scene']:12} {run['solver']:10} {run['verdict']:13} {run['reason']:11} {error} "
            f"{run['seconds']:7.2f} s {run.get('steps', 0):6} steps  {run['options']}")


def say(run):
    print(short(run), flush=True)


def main():
    """measure.py SCENE OPTIONS...: one run of tendril, not stored"""
    scene, options = SCENES[sys.argv[1]], shlex.join(sys.argv[2:])
    with tempfile.TemporaryDirectory() as scratch:
        run = measure(Case("tendril", scene, options), Store(Path(scratch) / "store"))
    print(json.dumps(run, indent=1))


if __name__ == "__main__":
    main()

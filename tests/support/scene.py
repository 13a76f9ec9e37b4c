"""What the tests that run the program share: checks and how they are started, runs and what is read of them.

A file of checks is a program:   FILE build/tendril [--mpiexec mpiexec] CHECK...      (no CHECK: all of them)"""

import argparse
import os
import shlex
import subprocess
import tempfile
from functools import lru_cache, partial
from pathlib import Path

from held import HANG
from interpreter import ROOT, from_venv

try:
    import h5py
    import numpy as np
except ImportError as error:
    from_venv(error)

CHECKS = {}  # of the file that is run: name: function
ENVIRONMENT = dict(os.environ, OMPI_ALLOW_RUN_AS_ROOT="1", OMPI_ALLOW_RUN_AS_ROOT_CONFIRM="1",
                   OMPI_MCA_rmaps_base_oversubscribe="1", OMPI_MCA_mpi_yield_when_idle="1",
                   OMPI_MCA_ess_singleton_isolated="1", OMP_NUM_THREADS="1")
TENDRIL = MPIEXEC = SCRATCH = None
DRY = "-growth_initial_length 2 -shape_amplitude 0.1 "  # the rod of the reference v_short


def check(function=None, ranks=1, parts=0):
    """Makes a function a test, which tests/registered.py finds: on so many ranks, if these say much to each other (then it has
    the cores for itself, for a rank that shares one waits for its turn with each message); where there are several numbers of ranks, or
    parts, it is given one and is as many tests. What it is called is what holds, a sentence."""
    if function is None:
        return lambda function: check(function, ranks, parts)
    name = function.__name__.replace("_", "-")
    several = [(f"{name}-on-{n}", n) for n in ranks] if isinstance(ranks, tuple) else \
        [(f"{name}-part-{k + 1}", k) for k in range(parts)]
    if function.__module__ == "__main__":
        CHECKS.update({each: partial(function, n) for each, n in several} or {name: function})
    return function


class Failure(Exception):
    pass


def expect(condition, message):
    if not condition:
        raise Failure(message)


class Run:
    """A finished run: r.tip_x1 and so on are series, r.shapes['x'] and so on the stored shapes."""

    def __init__(self, options, ranks=1, group="grow"):
        file = Path(SCRATCH) / "run.h5"
        command = [TENDRIL, *shlex.split(options), "-output", str(file)]
        if ranks > 1:
            command = [MPIEXEC, "-n", str(ranks), *command]
        done = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
                              env=ENVIRONMENT, cwd=ROOT)  # scenes name their data
        expect(done.returncode == 0 and not done.stderr,
               f"tendril {options}, {ranks} ranks: exit {done.returncode}, {done.stderr.strip()}")
        self.said = done.stdout
        with h5py.File(file) as f:
            self.estimate = f.attrs.get("error_estimate")  # over the run
            self.firm = f.attrs.get("contact_firm", 1)  # how many times firmer contact has become at the end
            self.told = {k[6:]: f.attrs[k] for k in f.attrs if k.startswith("error_")}
            self.rigid = {k[6:]: f.attrs[k] for k in f.attrs if k.startswith("rigid_")}
            expect(f.attrs["finished"] == 1, f"{options}: not finished")
            expect(f.attrs["ranks"] == ranks, f"{options}: ran on {f.attrs['ranks']} ranks")
            if group != "grow":
                expect(len(f[group]) > 1, f"{options}: no results in /{group}")
                return
            self.shapes = {name: d[:] for name, d in f["shapes"].items()}
            self.series = {name: d[:] for name, d in f["series"].items()}
            self.derivatives = {}
            for name, by in f.get("sensitivity", {}).items():
                by.visititems(lambda path, d: self.derivatives.update({(name, path): d[:]})
                              if isinstance(d, h5py.Dataset) else None)
        file.unlink()
        self.__dict__.update(self.series)
        self.tip = np.array([self.tip_x1[-1], self.tip_x2[-1]])
        self.steps = len(self.t) - 1

    def at(self, name, t):
        """A positive series at any time: the polynomial of its logarithm through six steps."""
        i = int(np.clip(np.searchsorted(self.t, t) - 3, 0, len(self.t) - 6))
        times, values = self.t[i:i + 6] - t, np.log(self.series[name][i:i + 6])
        return np.exp(lagrange(times, values))

    def tip_at(self, t):
        i = np.abs(self.shapes["t"] - t).argmin()
        expect(abs(self.shapes["t"][i] - t) < 1e-9, f"no shape stored at t = {t}")
        return self.shapes["x"][i, -1]


def tip_in_space(r):
    """Where the tip of a rod in space is at the end of a run."""
    return np.array([*r.tip, r.tip_x3[-1]])


def lagrange(times, values):
    """At 0, the polynomial through these points."""
    return sum(values[i] * np.prod([times[j] / (times[j] - times[i])
                                    for j in range(len(times)) if j != i])
               for i in range(len(times)))


def errors(options, cells, fine):
    """Of tip, norm and energy at the end, for each number of cells, against a finer run."""
    result = {"tip_x2": [], "norm_x2": [], "energy": []}
    for n in cells:
        r = Run(f"{options} -rod_cells {n}")
        for k in result:
            result[k].append(abs(r.series[k][-1] / fine.series[k][-1] - 1))
    return result


def order(errors, halvings=1):
    """From the finest pair."""
    return np.log2(errors[-2] / errors[-1]) / halvings


def distance(a, b):
    return np.hypot(*(a - b)) / np.hypot(*b)


def tendril(options, code=0):
    """Runs it; exit code 0 or a refusal with one plain line, which is returned."""
    done = subprocess.run([TENDRIL, *shlex.split(options)], capture_output=True, text=True,
                          env=ENVIRONMENT)
    expect((done.returncode != 0) == (code != 0), f"{options}: exit {done.returncode} {done.stderr}")
    if code:
        expect(done.stderr.startswith("tendril: ") and done.stderr.count("\n") == 1, done.stderr)
    return done.stderr if code else done.stdout


def on_ranks(ranks, words):
    """A run of it on so many ranks, however that ends: it is not waited a second for the others when one has ended badly."""
    return subprocess.run([MPIEXEC, "-n", str(ranks), TENDRIL, *words], capture_output=True, text=True,
                          env=dict(ENVIRONMENT, OMPI_MCA_odls_base_sigkill_timeout="0"), timeout=HANG)


def read(file):
    """Series and shapes by name; event, kind if there is one; the error told."""
    with h5py.File(file) as f:
        r = {f"{g}/{n}": d[()] for g in ("series", "shapes", "event") for n, d in
             (f[g].items() if g in f else ())}
        r["finished"] = f.attrs["finished"]
        r["told"] = f.attrs.get("error_estimate", 0)
        r |= {name: value for name, value in f.attrs.items() if name.startswith(("error_", "rigid_"))}
        kind = f["event"].attrs["kind"] if "event" in f else ""
        r["kind"] = kind.decode() if isinstance(kind, bytes) else kind
    return r


@lru_cache
def whole_run(options):
    """Once, of a run that is broken in several places."""
    tendril(f"{options} -output {SCRATCH}/whole.h5")
    return read(f"{SCRATCH}/whole.h5")


def broken(options, step):
    """Runs it whole, then to a step (or to that of the whole run which step(whole) names), where it is broken and goes on:
    the whole run and the names of what is not in both to the last bit; nor may another error be told."""
    whole, part = whole_run(options), f"{SCRATCH}/broken.h5"
    tendril(f"{options} -output {part} -ts_max_steps {step(whole) if callable(step) else step}", 1)
    tendril(f"-restart {part} -output {part}")
    on = read(part)
    return whole, [k for k in whole if not np.array_equal(whole[k], on[k])]


def pressed(run):
    """The steps of a run that end in contact."""
    return np.flatnonzero(run["series/contact_force"] > 0)


def walls(*lines):
    """The options that give these walls."""
    path = Path(SCRATCH) / f"walls-{len(list(Path(SCRATCH).glob('walls-*')))}.txt"
    path.write_text("\n".join(lines) + "\n")
    return f"-wall_file {path} "


def file(name, **arrays):
    """An HDF5 file for one check."""
    path = f"{SCRATCH}/{name}.h5"
    with h5py.File(path, "w") as f:
        for k, values in arrays.items():
            f[k] = values
    return path


def main():
    """Runs the checks that are named."""
    global TENDRIL, MPIEXEC, SCRATCH
    parser = argparse.ArgumentParser()
    parser.add_argument("tendril")
    parser.add_argument("--mpiexec", default="mpiexec")
    parser.add_argument("checks", nargs="*", metavar="CHECK", help=", ".join(CHECKS))
    arguments = parser.parse_intermixed_args()
    unknown = set(arguments.checks) - set(CHECKS)
    if unknown:
        parser.error(f"no check is named {', '.join(unknown)}")
    TENDRIL, MPIEXEC = str(Path(arguments.tendril).resolve()), arguments.mpiexec
    failed = 0
    for name in arguments.checks or CHECKS:
        with tempfile.TemporaryDirectory(prefix="tendril-") as SCRATCH:
            try:
                CHECKS[name]()
            except Failure as failure:
                failed += 1
                print(f"{name} FAILED: {failure}")
    return failed != 0

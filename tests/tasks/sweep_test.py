#!/usr/bin/env python3
"""-task sweep: members are what single runs are, failures are recorded, what is stopped goes on.

    sweep_test.py build/tendril [--mpiexec mpiexec] CHECK...      (no CHECK: all of them)"""

import fcntl
import re
import shlex
import signal
import subprocess
import sys
import time
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "support"))
import scene  # takes .venv's python if this one lacks numpy and h5py
from held import HANG, MONITORS, Held, ended, small_disk
from scene import Failure, check, expect

import h5py
import numpy as np

ROOT = scene.ROOT
sys.path.insert(0, str(ROOT / "scripts"))
from tendril import load
from tendril.collection import load_sweep

SHORT = "-growth_initial_length 2 -shape_amplitude 0.1 -rod_cells 40 -ts_max_time 0.1 -ts_rtol 1e-4"
TABLE = """friction_mu, -rod_model, ts_max_time, friction_layers
1, frame, 0.2, ""
0.5, mixed, , "0:1,3:2"
0, linear, 0.05,
0.25, auto, 0.3,
0.75, , ,
1, frame, 0.1, 0:2
"""
ALL = "-sweep_store series,shapes,final"


def tendril(options, ranks=1, before=""):
    """(exit code, stdout, tendril's lines on stderr)"""
    command = [scene.MPIEXEC, "-n", str(ranks), "--bind-to", "none"] if ranks > 1 else []
    line = f"{before}exec {shlex.join([*command, scene.TENDRIL, *shlex.split(options)])}"
    try:
        code, out, err = ended(["bash", "-c", line], env=scene.ENVIRONMENT, cwd=scene.SCRATCH)
    except subprocess.TimeoutExpired:
        raise Failure(f"{options}, {ranks} ranks: hangs") from None
    said = [s.split(": ", 1)[1] for s in err.splitlines() if s.startswith("tendril: ")]
    if code and not said:
        said = ["nothing of its own, but: " + err[-500:]]
    return code, out, said


def sweep(table, options="", ranks=1, code=0, file="out.h5", base=SHORT):
    """Runs a table; the result file, and what was printed."""
    path = Path(scene.SCRATCH)
    if isinstance(table, str):
        (path / "table.csv").write_text(table)
        table = "table.csv"
    got, said, lines = tendril(f"{base} {options} -task sweep -sweep_file {table} -output {file}",
                               ranks)
    expect(got == code, f"sweep {options}, {ranks} ranks: exit {got}, {lines}")
    return load_sweep(path / file), said + "\n".join(lines)


def fresh():
    for file in Path(scene.SCRATCH).glob("out.h5*"):
        file.unlink()


def rows(table):
    """The options of each row, as a command line has them."""
    head, *lines = table.strip().splitlines()
    names = [n.strip().lstrip("-") for n in head.split(",")]
    for line in lines:
        cells = re.findall(r'\s*("[^"]*"|[^,]*)\s*(?:,|$)', line)[:len(names)]
        pairs = ((n, c.strip(' "')) for n, c in zip(names, cells))
        yield " ".join(f"-{n} {c}" for n, c in pairs if c)


def same(one, other, where):
    """Two results are the same to the last bit."""
    for kind in ("series", "shapes", "critical"):
        a, b = getattr(one, kind), getattr(other, kind)
        expect(set(a) == set(b), f"{where}: {kind} has {sorted(a)}, not {sorted(b)}")
        for name, values in a.items():
            expect(np.array_equal(values, b[name]), f"{where}: {kind}/{name} differs")


def single(options, file="single.h5", base=SHORT):
    got, _, lines = tendril(f"{base} {options} -output {file}")
    expect(got == 0, f"{options}: exit {got}, {lines}")
    return load(Path(scene.SCRATCH) / file)


@check(ranks=(1, 2, 3))
def members_are_single_runs(ranks):
    s, said = sweep(TABLE, f"{ALL} -output_interval 0.03", ranks)
    expect((s.status == 1).all() and s.finished, f"{ranks} ranks: status {s.status}, {s.line}")
    expect("6 runs: 6 finished, 0 failed" in said, said)
    for k, row in enumerate(rows(TABLE)):
        r = single(f"{row} -output_interval 0.03")
        same(r, s.member(k), f"{ranks} ranks, {row}")
        for name, values in r.series.items():
            expect(s.final[name][k] == values[-1], f"{ranks} ranks, {row}: final/{name}")
    expect(np.array_equal(s.columns.friction_mu, [1, 0.5, 0, 0.25, 0.75, 1]), "columns/friction_mu")
    expect(list(s.columns.rod_model) == ["frame", "mixed", "linear", "auto", "", "frame"],
           f"columns/rod_model {s.columns.rod_model}")
    expect(np.isnan(s.columns.ts_max_time[1]) and s.columns.ts_max_time[0] == 0.2, "ts_max_time")
    expect((s.seconds > 0).all() and (s.line == "").all(), "seconds, line")


@check(ranks=2)
def members_of_teams_agree():
    """A member on two ranks agrees to the solver's tolerance; two teams of two share the table."""
    table = "friction_mu\n1\n0.5\n0\n0.75\n"
    alone, _ = sweep(table)
    for ranks in (2, 4):
        s, said = sweep(table, "-sweep_ranks 2", ranks, file=f"out.h5.{ranks}")
        expect(f"{ranks // 2} at a time" in said, said)
        expect((s.status == 1).all(), f"status {s.status}, {s.line}")
        for name in ("tip_x1", "tip_x2", "energy", "norm_x2"):
            gap = np.abs(s.final[name] / alone.final[name] - 1).max()
            expect(gap < 1e-8, f"{ranks} ranks: final/{name} off by {gap}")
    got, _, lines = tendril(f"{SHORT} -task sweep -sweep_file table.csv -output no.h5 "
                            "-sweep_ranks 2", 3)
    expect(got and lines == ["-sweep_ranks 2: there are 3 ranks; give a number that divides this"],
           f"exit {got}, {lines}")


@check
def critical_lengths_of_members_are_those_of_single_runs():
    table = "friction_mu,growth_type\n1,uniform\n0.5,uniform\n1,feed\n0.5,gaussian\n"
    for ranks in (1, 3):
        fresh()
        s, _ = sweep(table, "-sweep_task critical", ranks, base="-rod_cells 40")
        expect((s.status == 1).all(), f"status {s.status}, {s.line}")
        for k, row in enumerate(rows(table)):
            r = single(f"{row} -task critical", base="-rod_cells 40")
            for name in ("t", "length", "error", "frequency"):
                expect(s.critical[name][k] == r.critical[name], f"{row}: critical/{name}")


@check
def members_that_fail_leave_their_line():
    """They are recorded with the line of a single run, and the others go on."""
    table = """friction_mu,ts_max_steps,rod_model,growth_width,shape_file,ts_max_time
2,,,,,
1,5,,,,
1,,frame,,,
1,,foo,,,
1,,,0.3,,
1,,,,nowhere.h5,
1,,linear,,,8
0.5,,,,,x
0.5,,,,,
"""
    alone = [tendril(f"{SHORT} {row} -output single.h5")[2] for row in rows(table)]
    for ranks in (1, 3):
        fresh()
        s, said = sweep(table, ALL, ranks)
        expect(list(s.status) == [2, 2, 1, 2, 2, 2, 2, 2, 1], f"{ranks} ranks: status {s.status}")
        expect("9 runs: 2 finished, 7 failed" in said and re.search(r"run \d failed: -", said), said)
        for k, row in enumerate(rows(table)):
            said_alone = alone[k][0] if alone[k] else ""
            expect(said_alone == s.line[k], f"{row}: {s.line[k]}, not {said_alone}")
            expect(np.isnan(s.final.t[k]) == bool(s.line[k]), f"{row}: final/t {s.final.t[k]}")
        expect(len(s.member(2).series.t) > 5 and not len(s.part_of_series(1).t), "series")
        again, said = sweep(table, ALL, ranks)
        expect("9 of 9 runs are in out.h5 already" in said and (again.line == s.line).all(), said)


def stopped(ranks, number, ways):
    """Stopped when a part is stored, and gone on with: as if it had not been."""
    table = "friction_mu,shape_amplitude\n" + "".join(
        f"{1 - k / 100},{0.1 + k / 1000}\n" for k in range(40))
    options = f"{ALL} -rod_cells 100 -ts_rtol 1e-6 -ts_max_time 2 {' '.join(MONITORS)}"
    whole, _ = sweep(table, options, 2, file="whole.h5")
    command = shlex.split(f"{scene.TENDRIL} {SHORT} {options} -task sweep -sweep_file table.csv "
                          "-output out.h5")
    launch = [scene.MPIEXEC, "-n", str(ranks), "--bind-to", "none"] if ranks > 1 else []
    place = Path(scene.SCRATCH) / "out.h5"

    def stored():
        return int((load_sweep(place).status == 1).sum()) if place.exists() else 0

    for _ in range(ways):
        before = stored()
        with Held(command, launch, env=scene.ENVIRONMENT, cwd=scene.SCRATCH) as run:
            expect(run.until(lambda: stored() > before, pages=100), "ended before it could be stopped")
            run.send_signal(number)
            code, said = run.end()
        done = stored()
        expect(code and before < done < 40, f"exit {code}, {done} of 40 are stored, {said}")
        if number == signal.SIGTERM:
            lines = [t for t in said.splitlines() if t.startswith("tendril: ")]
            expect(len(lines) == 1 and
                   f"interrupted by signal 15; {done} of 40 runs are stored" in lines[0], said)
    s, said = sweep(table, options, ranks)
    expect(s.finished and (s.status == 1).all(), f"status {s.status}")
    expect(f"{done} of 40 runs are in out.h5 already" in said, said)
    for k in range(40):
        same(whole.member(k), s.member(k), f"member {k}")


@check(ranks=(1, 3))
def a_terminated_sweep_goes_on_as_the_whole(ranks):
    stopped(ranks, signal.SIGTERM, 2 if ranks == 1 else 1)


@check
def a_killed_sweep_goes_on_as_the_whole():
    stopped(1, signal.SIGKILL, 1)


@check
def ctrl_c_in_python_keeps_what_has_come_in():
    """Ctrl-C of tendril.sweep on two ranks: what has come in is kept, and no rank goes on."""
    # with steps so short that no machine comes to the end
    code = ("import tendril; tendril.sweep({'growth_initial_length': 2, 'rod_cells': 40, 'ts_max_steps': 10**9, "
            "'ts_max_time': 0.1, 'ts_adapt_type': 'none'}, {'ts_dt': [0.01, 0.02, 0.03, 0.05, 1e-12, 2e-12, 3e-12]}, "
            "directory='kept', jobs=2)")
    file = Path(scene.SCRATCH) / "kept/sweep.h5"
    environment = dict(scene.ENVIRONMENT, TENDRIL=scene.TENDRIL, MPIEXEC=scene.MPIEXEC, PYTHONPATH=str(ROOT / "scripts"))
    with subprocess.Popen([sys.executable, "-c", code], stderr=subprocess.PIPE, text=True, env=environment,
                          cwd=scene.SCRATCH) as process:
        while not (file.exists() and (load_sweep(file).status == 1).sum() == 4):
            expect(process.poll() is None, "the sweep has ended")
            time.sleep(0.1)
        process.send_signal(signal.SIGINT)
        said = process.communicate(timeout=HANG)[1]
    expect(process.returncode and "KeyboardInterrupt" in said, f"{process.returncode}, {said}")
    s = load_sweep(file)
    expect((s.status == 1).sum() == 4 and not s.finished, f"status {s.status}")
    left = [p for p in Path("/proc").glob("[0-9]*") if b"kept/sweep.csv" in bytes_of(p / "cmdline") and works_here(p)]
    expect(not left, f"{left} go on")
    expect(not list(file.parent.glob("*.part")) and not list(file.parent.glob("*.lock")), f"{list(file.parent.iterdir())}")


def bytes_of(path):
    try:
        return path.read_bytes()
    except OSError:  # it has just ended
        return b""


def works_here(process):
    """Others may run these tests at the same time, too."""
    try:
        return (process / "cwd").samefile(scene.SCRATCH)
    except OSError:  # it has just ended, or is another user's
        return False


def refuse(cases):
    """Each (table, options, words of the line): in one line, and before anything is run."""
    path = Path(scene.SCRATCH)
    for table, options, words in cases:
        (path / "table.csv").write_text(table)
        got, _, lines = tendril(f"{SHORT} -task sweep -sweep_file table.csv -output out.h5 {options}")
        expect(got and len(lines) == 1 and words in lines[0], f"{table!r} {options}: {got}, {lines}")
    expect(not list(path.glob("*.part")), "a part is left")


GOOD = "friction_mu\n1\n0.5\n"


@check
def wrong_tables_are_refused():  # the unit test has more of them
    refuse([
        ("friction_mew\n1\n", "", "-friction_mew: unknown option, did you mean -friction_mu?"),
        ("friction_mu,rod_cells\n1\n", "", "line 2 has 1 cells"),
        ("", "", "table.csv: is empty"),
        ("output\na.h5\n", "", "-output is of the sweep"),
        ("restart\na.h5\n", "", "-restart is of the sweep"),
        ("sweep_file\na.csv\n", "", "-sweep_file is of the sweep"),
        ("quiet\ntrue\n", "", "-quiet is of the sweep"),
        ("options_file\na.opts\n", "", "-options_file is of the sweep"),
        ("friction_layers\n\"" + ",".join(f"{k}:1" for k in range(80)) + "\"\n",
         "-sweep_directory runs", "row 1 cannot be named"),
        ("shape_file\na/b_c\na_b/c\n", "-sweep_directory runs",
         " would have one file"),
        (GOOD, "-sweep_file nowhere.csv", "-sweep_file nowhere.csv: No such file or directory"),
        (GOOD, "-output table.csv", "-output table.csv: would overwrite the file that -sweep_file"),
    ])


@check
def wrong_options_are_refused():
    refuse([
        (GOOD, "-restart out.h5", "-restart: a sweep goes on by itself"),
        (GOOD, "-sweep_store finals", "-sweep_store finals: unknown, give some of final"),
        (GOOD, "-sweep_task critical -sweep_store shapes", "there is only final"),
        (GOOD, "-sweep_task stability", "-sweep_task stability: unknown, give one of grow,critical"),
        (GOOD, "-sweep_directory runs -sweep_store series", "leave -sweep_store series out"),
        (GOOD, "-friction_mew 1", "-friction_mew: unknown option, did you mean -friction_mu?"),
        (GOOD, "-sweep_ranks 0", "-sweep_ranks 0: too small"),
        (GOOD, "-snes_type foo", "-snes_type foo: PETSc has no such type"),
    ])
    for options, words in (("-task sweep -output a.h5", "-task sweep: give the table"),
                           ("-task sweep -sweep_file table.csv", "-task sweep: give the file"),
                           ("-sweep_file table.csv", "-sweep_file: nothing in this run reads it")):
        got, _, lines = tendril(options)
        expect(got and len(lines) == 1 and words in lines[0], f"{options}: {got}, {lines}")


@check
def files_of_another_sweep_stay():
    """What is there, and is not the same sweep, stays."""
    path = Path(scene.SCRATCH)
    sweep(GOOD)
    single("", "run.h5")
    (path / "foreign.h5").write_text("not ours")
    before = [(path / f).read_bytes() for f in ("out.h5", "run.h5", "foreign.h5")]
    refuse([
        ("friction_mu\n1\n0.25\n", "", "-output out.h5: holds a sweep of another table"),
        ("friction_mu\n1\n0.5\n1\n", "", "-output out.h5: holds a sweep of another table"),
        (GOOD, "-friction_beta 0.01", "-output out.h5: holds a sweep with other options"),
        (GOOD, "-sweep_store series", "-output out.h5: holds a sweep with other options"),
        (GOOD, "-sweep_task critical", "-output out.h5: holds a sweep with other options"),
        (GOOD, "-output foreign.h5", "-output foreign.h5: is there, and is no result of tendril"),
        (GOOD, "-output run.h5", "-output run.h5: is there, and is no sweep's"),
        (GOOD, "-output nowhere/a.h5", "-output nowhere/a.h5: there is no directory nowhere; make it (mkdir -p nowhere)"),
    ])
    for options in ("", "-rod_cells 9 -task critical"):
        got, _, lines = tendril(f"{options} -output out.h5")
        expect(got and lines == ["-output out.h5: holds a sweep; name another file, or take it away"],
               f"{options}: {got}, {lines}")
    expect(before == [(path / f).read_bytes() for f in ("out.h5", "run.h5", "foreign.h5")], "changed")


@check
def tables_of_hdf5_and_csv_say_the_same():
    """HDF5 and CSV say the same; units, files of options, and what these have beyond the task."""
    path = Path(scene.SCRATCH)
    with h5py.File(path / "table.h5", "w") as f:
        f["friction_mu"] = [1, 0.1, np.nan]
        f["rod_cells"] = np.array([20, 30, 40], dtype=np.int32)
        f["rod_model"] = ["frame", "", "mixed"]
        f["stop_length"] = [2.05, 2.06, 2.07]
    a, _ = sweep(Path("table.h5"), ALL)
    fresh()
    b, _ = sweep("friction_mu,rod_cells,rod_model,stop_length\n1,20,frame,2.05\n0.1,30,,2.06\n"
                 ",40,mixed,2.07\n", ALL)
    expect((a.status == 1).all(), f"status {a.status}, {a.line}")
    for k in range(3):
        same(a.member(k), b.member(k), f"member {k}")
    expect(np.abs(a.final.length - a.columns.stop_length).max() < 1e-9, f"{a.final.length}")
    with h5py.File(path / "table.h5", "w") as f:
        f["stop_length"] = [2.0, 3.0]
        f["stop_length"].attrs["units"] = "cm"
    (path / "a.opts").write_text("-task critical\n-si_bending_stiffness 1e-6\n-si_friction_dry 1\n"
                                 "-output_interval 0.05\n-growth_initial_length 1.9\n")
    fresh()
    more = "-options_file a.opts -ts_max_time 1.5 -growth_initial_length 1.9"
    s, _ = sweep(Path("table.h5"), more)
    expect((s.status == 1).all(), f"status {s.status}, {s.line}")
    expect(np.abs(s.final.length - [2, 3]).max() < 1e-9, f"{s.final.length}")
    again, said = sweep("stop_length (cm)\n2\n3\n", more)  # it is the same sweep: nothing is left to be run
    expect(list(again.columns.stop_length) == ["2cm", "3cm"] and np.array_equal(again.seconds, s.seconds), f"{again.columns}, {said}")
    fresh()
    base = "-options_file a.opts -sweep_task critical"
    s, _ = sweep("growth_initial_length\n1.5\n", base=base)
    expect(s.status[0] == 1 and s.critical.length[0] > 1.9, f"{s.line}, {s.critical}")
    fresh()  # but a column that nothing reads is a mistake
    s, _ = sweep("growth_width\n1.5\n", base=base)
    expect(s.status[0] == 2 and "nothing in this run reads it" in s.line[0], f"{s.line}")


@check
def a_directory_has_each_run_as_a_single_run_writes_it():
    """-sweep_directory: each run's own file, as a single run writes it."""
    path = Path(scene.SCRATCH)
    table = "friction_mu,rod_model\n1,frame\n0.5,auto\n2,frame\n"
    s, _ = sweep(table, "-sweep_directory runs -output_interval 0.03", 2)
    expect(list(s.status) == [1, 1, 2], f"status {s.status}, {s.line}")
    names = [n.replace(" ", "=").replace("=-", "__")[1:] for n in rows(table)]
    for name, row in zip(names[:2], rows(table)):
        same(single(f"{row} -output_interval 0.03"), load(path / f"runs/{name}.h5"), name)
        expect((path / f"runs/{name}.xmf").exists(), f"{name}.xmf")
    got, _, lines = tendril(f"-restart runs/{names[0]}.h5 -ts_max_time 0.12 -output on.h5")
    expect(got == 0, f"-restart: {lines}")
    log = (path / f"runs/{names[2]}.log").read_text()
    expect(log == f"tendril: {s.line[2]}\n", f"{names[2]}.log: {log}")
    expect(len(list((path / "runs").iterdir())) == 6 and not list((path / "runs/running").iterdir()),
           f"{sorted((path / 'runs').rglob('*'))}")


@check
def a_full_disk_leaves_a_sweep_that_goes_on():
    """What was stored is whole, and the same command goes on when there is room."""
    table = "friction_mu\n" + "".join(f"{k / 60}\n" for k in range(60))
    (Path(scene.SCRATCH) / "table.csv").write_text(table)
    options = f"{SHORT} {ALL} -task sweep -sweep_file table.csv -output_interval 0.002"
    for ranks in (1, 2):
        with small_disk(1500) as disk:
            if not disk:
                return
            got, _, lines = tendril(f"{options} -output {disk}/a.h5", ranks)
            expect(got and len(lines) == 1 and "No space left on device; what was stored before is "
                   "whole" in lines[0], f"exit {got}, {lines}")
            s = load_sweep(disk / "a.h5")
            expect(set(s.status) <= {0, 1} and not s.finished, f"status {s.status}")
            subprocess.run(["mount", "-o", "remount,size=30000k", disk], check=True)
            got, _, lines = tendril(f"{options} -output {disk}/a.h5", ranks)
            expect(got == 0 and (load_sweep(disk / "a.h5").status == 1).all(), f"{lines}")


@check
def more_members_take_no_more_memory():
    """Many more members take no more of it, failing ones included, but for results that wait to be stored:
    of a fast machine those of all members do, half a kilobyte each; a member that left as little as two
    behind would show all the same."""
    code = ("import resource, subprocess, sys; "
            "subprocess.run(sys.argv[1:], check=True, stdout=subprocess.DEVNULL); "
            "print(resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss)")
    few, many, most = 200, 12000, []
    for n in (few, many):
        table = "friction_mu\n" + "".join(f"{k % 100 / 90}\n" for k in range(n))
        (Path(scene.SCRATCH) / "table.csv").write_text(table)
        options = shlex.split(f"{SHORT} -rod_cells 10 -ts_max_time 1e-4 -task sweep "
                              f"-sweep_file table.csv -output {n}.h5")
        done = subprocess.run([sys.executable, "-c", code, scene.TENDRIL, *options], check=True,
                              capture_output=True, text=True, cwd=scene.SCRATCH,
                              env=scene.ENVIRONMENT, timeout=HANG)
        most.append(int(done.stdout))
    each = (most[1] - most[0]) / (many - few)
    print(f"{most} kB, {each:.2f} kB a member")
    expect(each < 1.3, f"{most} kB, {each:.2f} kB a member")


def script(command, code=0, cwd=ROOT):
    """What a script prints."""
    environment = dict(scene.ENVIRONMENT, TENDRIL=scene.TENDRIL, MPIEXEC=scene.MPIEXEC,
                       PYTHON=sys.executable, PYTHONPATH=str(ROOT / "scripts"))
    done = subprocess.run(shlex.split(command), capture_output=True, text=True, env=environment,
                          cwd=cwd, timeout=HANG)
    expect(done.returncode == code, f"{command}: {done.returncode}, {done.stderr}")
    return done.stdout + done.stderr


@check
def sweep_sh_runs_in_one_job_and_a_process_a_point():
    """In one job and a process a point."""
    d = scene.SCRATCH
    command = f"scripts/sweep.sh {d}/a -j 2 {SHORT} -- friction_mu 0:1.5:4 friction_layers 0:1"
    said = script(command, 1)
    expect("sweep: 4 points, 4 to run here, 2 at a time" in said and "1 points failed" in said, said)
    expect("friction_mu=1.5__friction_layers=0:1: tendril: -friction_mu 1.5: too large" in said, said)
    same(single("-friction_mu 0.5 -friction_layers 0:1 -output_shapes 1"),  # as a member stores them
         load(Path(d) / "a/friction_mu=0.5__friction_layers=0:1.h5"), "sweep.sh")
    expect("sweep: 4 points, 1 to run here" in script(command, 1), command)
    for words, word in (("-j", "-j : give the number"), ("-j x -- friction_mu 0,1", "-j x: give"), ("-- '' 0,1", ": is no name of an option"),
                        ("-options_file none.opts -- friction_mu 0,1", "no options file none.opts"),
                        ("-- friction_mu 0:1:9999999999", "too many values")):
        said = script(f"scripts/sweep.sh {d}/e {words}", 2 if "none" not in words else 1)
        expect(word in said and said.count("\n") <= 1, said)
    said = script(f"scripts/sweep.sh {d}/c -friction_mew 1 -- friction_mu 0,1", 1)
    expect("did you mean -friction_mu?" in said, said)
    script(f"scripts/sweep.sh {d}/c {SHORT} -- friction_mu 0,1")  # nothing was stored: not another sweep's
    said = script(f"scripts/sweep.sh {d}/c {SHORT} -rod_order 2 -- friction_mu 0,1", 1)
    expect("holds a sweep with other options" in said, said)
    script(f"scripts/sweep.sh {d}/d -task stability -stability_points 3 -stability_vertices 20 -- "
           "friction_mu 0,1")
    expect(len(list(Path(f"{d}/d").glob("*.h5"))) == 2, "stability")


@check
def sweep_sh_counts_files_from_where_one_is():
    """Files count from where one is; one sweep at a time is at work in a directory."""
    d = Path(scene.SCRATCH)
    (d / "a.opts").write_text(SHORT.replace(" -", "\n-") + "\n")
    with small_disk(100) as disk:
        if disk:
            subprocess.run(["mount", "-o", "remount,ro", disk], check=True)
            said = script(f"{ROOT}/scripts/sweep.sh {disk}/a {SHORT} -- friction_mu 0,1", 1)
            expect(said == f"sweep: {disk}/a: nothing can be written there; give a directory of a disk and a place "
                   "where you may write\n", said)
    command = f"{ROOT}/scripts/sweep.sh here -j 1 -options_file a.opts -- friction_mu 0,1"
    script(command, cwd=d)
    expect(len(list((d / "here").glob("*.h5"))) == 2, f"{list(d.rglob('*.h5'))}")
    expect(not (ROOT / "here").exists(), "wrote into the project")
    with open(d / "here/running/lock.all", "a") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        said = script(command, 1, cwd=d)
        expect("another sweep is at work there" in said, said)
    script(command, cwd=d)
    said = script(f"{ROOT}/scripts/run.sh no-such-scene", 1, cwd=d)
    expect("no options file no-such-scene here" in said, said)


@check
def maps_and_ensembles_are_drawn_of_a_sweep():
    """Of the files of sweep.sh, and of a sweep's one."""
    d = scene.SCRATCH
    script(f"scripts/sweep.sh {d}/b -j 1 -options_file options/critical.opts -- friction_mu 0,1 "
           "growth_initial_length 0.3,0.5")
    script(f"scripts/map.sh {d}/b --axes friction_mu,growth_initial_length")
    sweep("friction_mu,shape_amplitude\n0,0.1\n1,0.1\n0,0.2\n1,0.2\n", ALL)
    script(f"scripts/map.sh {d}/out.h5 --axes friction_mu,shape_amplitude --quantity final/width")
    said = script(f"scripts/map.sh {d}/out.h5 --axes friction_mu,rod_cells", 1)
    expect("does not vary rod_cells" in said, said)
    said = script(f"{sys.executable} -m tendril ensemble {d}/out.h5 --output {d}/e")
    expect("ensemble: 4 members" in said, said)
    for name in ("b", "out", "e"):
        expect((Path(d) / f"{name}.png").stat().st_size > 3000, f"{name}.png")


if __name__ == "__main__":
    sys.exit(scene.main())

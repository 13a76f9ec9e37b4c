#!/usr/bin/env python3
"""What may happen to a run from outside: a full disk, a limit on file sizes, signals at any moment,
an error on one rank, a restart in place. Nothing is lost, nothing hangs, no file is wrong.

    faults.py build/tendril [--mpiexec mpiexec] CHECK...      (no CHECK: all of them)
    faults.py build/tendril --storm COUNT [SEED]    COUNT runs on 1 to 3 ranks killed (TERM, KILL) at
                                                    random steps; every third with a disk that fills
"""

import contextlib
import random
import re
import shlex
import signal
import subprocess
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "support"))
import scene  # takes .venv's python if this one lacks numpy and h5py
from held import PAGE, Held, ended, small_disk
from scene import DRY, Failure, check, distance, expect

import h5py
import numpy as np


def launch(ranks):
    return [scene.MPIEXEC, "-n", str(ranks), "--bind-to", "none"] if ranks > 1 else []


def command(options, ranks=1):
    return [*launch(ranks), scene.TENDRIL, *shlex.split(options)]


def run(options, ranks=1, before=""):
    """(exit code, tendril's lines on stderr, all of stderr); before: shell commands."""
    line = f"{before}exec {shlex.join(command(options, ranks))}"
    try:
        code, _, err = ended(["bash", "-c", line], env=scene.ENVIRONMENT)
    except subprocess.TimeoutExpired:
        raise Failure(f"{options}, {ranks} ranks: hangs") from None
    said = [s for s in err.splitlines() if s.startswith("tendril: ")]
    return code, said, err


def read(file):
    """A result, checked to be whole: all arrays as long as they should be, shapes that are rods."""
    with h5py.File(file) as f:
        t, shapes = f["series/t"][()], f["shapes/t"][()]
        for name, series in f["series"].items():
            expect(len(series) == len(t), f"{file}: series/{name} has {len(series)} of {len(t)}")
        for name, data in f["shapes"].items():
            expect(name == "s" or len(data) == len(shapes), f"{file}: shapes/{name} is short")
        expect((np.diff(t) > 0).all(), f"{file}: times do not increase")
        x = f["shapes/x"][()]
        length = np.hypot(*np.diff(x, axis=1).transpose(2, 0, 1)).sum(axis=1)
        expect(length.min() > 0.1, f"{file}: a shape is {length.min()} long")
        return {"finished": f.attrs["finished"], "t": t, "shapes": shapes, "x": x,
                "tip": x[-1, -1], "restart": "restart" in f}


FEED = f"-options_file {scene.ROOT}/options/feed.opts "


@check
def a_full_disk_leaves_what_was_stored_whole():
    """One line that names the file and the reason; what was stored is whole; a restart elsewhere goes
    on to the same end."""
    whole = f"{scene.SCRATCH}/whole.h5"
    expect(run(f"{FEED} -output {whole}")[0] == 0, "the run itself fails")
    for ranks in (1, 2):
        with small_disk(600) as disk:
            if not disk:
                print("no file system of its own can be mounted here: left out")
                return
            code, said, stderr = run(f"{FEED} -output {disk}/feed.h5", ranks)
            print(f"{ranks} ranks: exit {code}, {said}")
            expect(code != 0 and len(said) == 1, f"{ranks} ranks: exit {code}, {stderr}")
            expect("feed.h5" in said[0] and "No space left" in said[0], said[0])
            expect(not read(f"{disk}/feed.h5")["finished"], "says it is finished")
            expect(sorted(p.name for p in disk.iterdir() if p.suffix == ".part") == [], "leftovers")
            code, _, stderr = run(f"-restart {disk}/feed.h5 -output {scene.SCRATCH}/on.h5", ranks)
            expect(code == 0, f"restart: {stderr}")
            off = distance(read(f"{scene.SCRATCH}/on.h5")["tip"], read(whole)["tip"])
            expect(off < 1e-8, f"{ranks} ranks: the end differs by {off:.1e}")
    with small_disk(64) as disk:  # not even the first shape: refused before any work
        code, said, _ = run(f"{FEED} -output {disk}/feed.h5")
        expect(code != 0 and len(said) == 1 and "No space left" in said[0], said)
        expect(not list(disk.glob("*.h5")), "half a file is left")


@check
def a_limit_of_file_size_ends_a_run_in_one_line():
    code, said, stderr = run(f"{FEED} -output {scene.SCRATCH}/feed.h5", before="ulimit -f 600; ")
    print(f"exit {code}, {said}")
    expect(code > 0 and len(said) == 1 and "File too large" in said[0], f"exit {code}: {stderr}")
    read(f"{scene.SCRATCH}/feed.h5")


@check
def a_limit_of_file_size_ends_each_task_in_one_line():
    """What a task cannot write is seen, also what goes to the disk only when its file is closed."""
    file = Path(scene.SCRATCH) / "task.h5"
    for task in ("critical -rod_cells 60", "stability -stability_points 3 -stability_vertices 60"):
        options = f"-task {task} -output {file}"
        expect(run(options)[0] == 0, f"{task}: fails")
        for limit in (1, (file.stat().st_size - 1) // 1024):
            file.unlink(missing_ok=True)
            code, said, stderr = run(options, before=f"ulimit -f {limit}; ")
            print(f"{task}, {limit} kB: exit {code}, {said}")
            expect(code > 0 and len(said) == 1 and "File too large" in said[0],
                   f"{task}, {limit} kB: exit {code}, {stderr}")
            expect(not file.exists(), f"{task}, {limit} kB: half a file is left")


@check
def a_restart_in_place_goes_on_from_any_number_of_ranks_to_any():
    """On 1, 2 and 3 ranks, and from each number to each."""
    options = f"{DRY} -rod_cells 60 -output_interval 0.5 "
    whole = f"{scene.SCRATCH}/whole.h5"
    run(f"{options} -ts_max_time 5 -output {whole}")
    for first in (1, 2, 3):
        for then in (1, 2, 3):
            file = f"{scene.SCRATCH}/r{first}{then}.h5"
            code, _, err = run(f"{options} -ts_max_time 2.2 -output {file}", first)
            expect(code == 0, f"{first} ranks: {err}")
            code, _, err = run(f"-restart {file} -ts_max_time 5", then)
            expect(code == 0, f"{first}, then {then} ranks: {err}")
            a, b = read(file), read(whole)
            expect(np.allclose(a["shapes"], b["shapes"]), f"shapes at {a['shapes']}")
            off = distance(a["tip"], b["tip"])
            expect(off < 1e-5, f"{first}, then {then} ranks: tip off by {off:.1e}")
    with h5py.File(file) as f:
        earlier, now = f["earlier_options"][()].decode(), f.attrs["options"]
        expect("-ts_max_time 2.2" in str(earlier) and "-ts_max_time 5" in str(now), str(earlier))


@check
def a_table_that_dips_below_0_is_refused_before_any_work():
    """Below 0 between its entries: refused before any work, on any number of ranks."""
    file = f"{scene.SCRATCH}/table.h5"
    s, t = np.linspace(0, 1, 9), np.linspace(0, 2, 9)
    g = np.ones((9, 9))
    g[:, 4:6] = 1e-3
    with h5py.File(file, "w") as f:
        f["s"], f["t"], f["g"] = s, t, g
    for ranks in (1, 2, 3):
        code, said, _ = run(f"-growth_type table -growth_table {file} -ts_max_time 2", ranks)
        expect(code != 0 and len(said) == 1 and "-growth_table" in said[0], f"{ranks}: {said}")
    print(said[0])


@check
def a_second_writer_of_a_file_is_refused():
    """A second run, restart, task or sweep with the same file, or a sweep with the same directory, is
    refused; it names the process, and the first goes on as if nothing had been. One that was killed
    keeps nobody from it."""
    d = Path(scene.SCRATCH)
    options = f"{DRY} -rod_cells 60 -ts_max_time 1 -output_interval 0.1 "
    expect(run(f"{options} -output {d}/whole.h5")[0] == 0, "fails")
    others = (f"{options} -friction_mu 0.5 -output {d}/a.h5", f"-restart {d}/whole.h5 -ts_max_time 2 -output {d}/a.h5",
              f"-task critical -rod_cells 60 -output {d}/a.h5", f"-restart {d}/a.h5")
    for ranks in (1, 2):
        with Held(command(f"{options} -output {d}/a.h5"), env=scene.ENVIRONMENT) as first:
            first.let(5 * PAGE)
            for other in others[:4 if ranks == 1 else 1]:
                code, said, stderr = run(other, ranks)
                expect(code and len(said) == 1 and f"a.h5: is being written by process {first.process.pid} on "
                       in said[0], f"{other}, {ranks} ranks: exit {code}, {stderr}")
            expect(first.end() == (0, ""), "the first does not end well")
        a, whole = read(d / "a.h5"), read(d / "whole.h5")
        expect(a["finished"] and np.array_equal(a["t"], whole["t"]) and np.array_equal(a["x"], whole["x"]),
               "the first is not what it is alone")
        expect(not list(d.glob("*.lock")) and not list(d.glob("*.part")), f"left: {list(d.iterdir())}")
    (d / "table.csv").write_text("friction_mu\n1\n0.5\n0\n")
    sweep = f"{options} -task sweep -sweep_file {d}/table.csv -sweep_directory {d}/runs -output "
    with Held(command(f"{sweep} {d}/s.h5"), env=scene.ENVIRONMENT) as first:
        first.let(5 * PAGE)
        for file, word in (("s", "-output"), ("t", "-sweep_directory")):
            code, said, stderr = run(f"{sweep} {d}/{file}.h5 -snes_view")
            expect(code and len(said) == 1 and f"{word} " in said[0] and "is being written by" in said[0],
                   f"{file}: exit {code}, {stderr}")
        expect(first.end() == (0, ""), "the first sweep does not end well")
    expect(len(list((d / "runs").glob("*.h5"))) == 3, "members are missing")
    with Held(command(f"{options} -output {d}/b.h5"), env=scene.ENVIRONMENT) as first:
        first.let(5 * PAGE)
        first.send_signal(signal.SIGKILL)
        first.end()
    expect(run(f"{options} -output {d}/b.h5")[0] == 0, "what a killed one held stays held")


@check
def a_signal_to_mpiexec_ends_run_and_sweep_in_good_order():
    """SIGUSR1 to mpiexec itself, which hands it on and goes on: run and sweep end in good order, and say so
    in one line. (Of SIGTERM some make an end of their own, in which that line is lost.)"""
    d = Path(scene.SCRATCH)
    (d / "table.csv").write_text("friction_mu\n" + "".join(f"0.{k}\n" for k in range(10, 99)))
    endless = f"{DRY} -rod_cells 60 -ts_max_time 1e6 -ts_max_steps 100000000 -output {d}/a.h5"
    for options in (f"{endless} -output_interval 0.1", f"{endless} -task sweep -sweep_file {d}/table.csv"):
        with Held([scene.TENDRIL, *shlex.split(options)], launch(2), env=scene.ENVIRONMENT) as process:
            expect(process.let(5 * PAGE), "it has ended")
            process.process.send_signal(signal.SIGUSR1)
            code, said = process.end()
        lines = [line for line in said.splitlines() if line.startswith("tendril: ")]
        expect(code and len(lines) == 1 and "interrupted by signal 10" in lines[0], f"{options}: exit {code}, {said}")
        expect(sorted(p.suffix for p in d.glob("a.*")) in ([".h5"], [".h5", ".xmf"]), f"{list(d.iterdir())}")
        for file in d.glob("a.*"):
            file.unlink()


@check
def several_rods_that_are_stopped_or_have_no_room_lose_nothing():
    """A file that may not grow: one line, and what was stored is whole. A signal: the file says so, and is gone on with."""
    d = Path(scene.SCRATCH)
    (d / "two.opts").write_text("-growth_type feed\n-rod_cells 30\n[rod a]\n[rod b]\n-clamp_place 0,1,0\n")
    code, said, stderr = run(f"-options_file {d}/two.opts -ts_max_time 0.1 -output {d}/two.h5", before="ulimit -f 200; ")
    expect(code > 0 and len(said) == 1 and "two.h5: cannot be written" in said[0] and "File too large" in said[0] and
           "what was stored before is whole" in said[0], f"exit {code}: {stderr}")
    expect(not read(d / "two.h5")["finished"] and not list(d.glob("*.part")), "not what was stored before")
    endless = f"-options_file {d}/two.opts -ts_max_time 1e3 -output_interval 1 -output {d}/two.h5"
    with Held(command(endless), env=scene.ENVIRONMENT) as process:
        expect(process.let(4 * PAGE), "it has ended")
        process.process.send_signal(signal.SIGTERM)
        code, said = process.end()
    expect(code and said.count("tendril: ") == 1 and "interrupted by signal 15 at t" in said, f"exit {code}: {said}")
    stopped = read(d / "two.h5")
    expect(stopped["restart"] and len(stopped["t"]) > 5, "what was found is not there")
    code, _, stderr = run(f"-restart {d}/two.h5 -ts_max_time {1.01 * stopped['t'][-1]} -quiet")
    expect(code == 0 and read(d / "two.h5")["finished"], stderr)


@check
def a_run_of_one_process_starts_no_daemon():
    """A run of one process has no shared memory, of which Open MPI 5 would leave a
    segment behind each time; no daemon, without which it starts in half the time; and it asks no X server."""
    plain = {k: v for k, v in scene.ENVIRONMENT.items() if not k.startswith(("OMPI_MCA_", "HWLOC_"))}
    with Held(command(f"{DRY} -rod_cells 60 -ts_max_time 1"), env=plain) as first:
        first.let(5 * PAGE)
        place = Path(f"/proc/{first.process.pid}")
        maps, children = ((place / name).read_text() if (place / name).exists() else ""
                          for name in ("maps", f"task/{place.name}/children"))
        first.end()
    others = re.findall(r"/dev/shm/\S+|\S*(?:vader|sm)_segment\S*|\S*/hwloc_gl\S*", maps)
    expect(not others and not children, f"has {others}, processes {children}")


@check
def a_restart_with_other_scales_is_refused():
    """A restart with other scales would give the past another length."""
    tube = "-si_bending_stiffness 4.4907e-4 -si_friction_dry 20.03 "
    file = f"{scene.SCRATCH}/tube.h5"
    expect(run(f"{DRY} {tube} -ts_max_time 1 -output {file}")[0] == 0, "fails")
    code, said, _ = run(f"-restart {file} -ts_max_time 2 -si_friction_dry 10")
    expect(code != 0 and len(said) == 1 and "-si_" in said[0], said)
    expect(run(f"-restart {file} -ts_max_time 2 -si_friction_dry 20.03")[0] == 0, "the same ones")
    with h5py.File(file) as f:
        expect(f.attrs["parameters/friction_mu"] == 1 and f.attrs["parameters/rod_cells"] == 500
               and f.attrs["parameters/ts_type"] == b"vbdf", "parameters")
        for group in ("series", "shapes"):
            for name, data in f[group].items():
                expect(data.attrs["units"] and data.attrs["description"], f"{group}/{name}")
        expect(f["shapes/stretch"].shape == f["shapes/theta"].shape, "stretch")


STORM = f"{DRY} -rod_cells 1500 -output_interval 0.1 -ts_max_time 12 "


def held_pages(options, ranks):
    """How many pages a run prints while it is held."""
    pages = 0
    with Held([scene.TENDRIL, *shlex.split(options)], launch(ranks), env=scene.ENVIRONMENT) as process:
        while process.let():
            pages += 1
        code, said = process.end()
    expect(code == 0, f"the run fails: {said}")
    return pages


def killed(file, ranks, number, pages):
    """Starts the storm's run, lets it print so many pages and sends all ranks the signal; its stderr."""
    options = f"-restart {file}" if Path(file).exists() else f"{STORM} -output {file}"
    with Held([scene.TENDRIL, *shlex.split(options)], launch(ranks), env=scene.ENVIRONMENT) as process:
        if process.let(pages * PAGE + 1):
            process.send_signal(number)
        try:
            return process.end()[1]
        except subprocess.TimeoutExpired:
            raise Failure(f"{file}: does not end on signal {number}") from None


def survives(file, ranks, whole):
    """After a kill: the file is whole, and the run goes on to the same end, or says why not."""
    if not Path(file).exists():
        return "killed before its first store"
    read(file)
    if read(file)["finished"]:
        return "had finished"
    code, said, stderr = run(f"-restart {file}", ranks)
    expect(code == 0, f"{file}: does not go on: {stderr}")
    after = read(file)
    off = distance(after["tip"], whole["tip"])
    expect(after["finished"] and off < 1e-8, f"{file}, {ranks} ranks: ends {off:.1e} away")
    expect(np.allclose(after["shapes"], whole["shapes"]), f"{file}: shapes at other times")
    return f"goes on, tip to {off:.0e}"


def storm(count, seed):
    dice = random.Random(seed)
    wholes, pages, outcomes = {}, 0, {}
    for ranks in (1, 2, 3):  # one rank and two may differ by a decision that hung on round-off
        pages = held_pages(f"{STORM} -output {scene.SCRATCH}/whole.h5", ranks)
        wholes[ranks] = read(f"{scene.SCRATCH}/whole.h5")
    print("ranks differ by", *(f"{distance(w['tip'], wholes[1]['tip']):.1e}" for w in wholes.values()))
    for k in range(count):
        ranks, number = dice.choice((1, 2, 3)), dice.choice((signal.SIGTERM, signal.SIGKILL))
        whole = wholes[ranks]
        with small_disk(dice.randint(2000, 40000)) if k % 3 == 2 else \
                contextlib.nullcontext(Path(scene.SCRATCH)) as place:
            file = f"{place or scene.SCRATCH}/storm{k}.h5"
            for _ in range(dice.randint(1, 2)):
                err = killed(file, ranks, number, dice.randint(0, pages))
            full = "No space left" in err
            if full:
                elsewhere = f"{scene.SCRATCH}/elsewhere{k}.h5"
                if Path(file).exists():
                    read(file)
                    code, _, err = run(f"-restart {file} -output {elsewhere}", ranks)
                    expect(code == 0, f"{file}: {err}")
                    off = distance(read(elsewhere)["tip"], whole["tip"])
                    expect(off < 1e-8, f"{file}: ends {off:.1e} away")
                outcome = "disk full: goes on elsewhere"
            elif place and k % 3 == 2:
                with contextlib.suppress(Failure):
                    survives(file, ranks, whole)
                if Path(file).exists():
                    read(file)
                outcome = "on a small disk"
            else:
                outcome = survives(file, ranks, whole).split(",")[0]
            outcomes[outcome] = outcomes.get(outcome, 0) + 1
            for old in (file, file.replace(".h5", ".xmf")):
                Path(old).unlink(missing_ok=True)
        print(f"{k}: {ranks} ranks, {number.name}: {outcome}", flush=True)
    print(f"storm of {count}, seed {seed}:", ", ".join(f"{n} {o}" for o, n in outcomes.items()))


@check(ranks=2)
def runs_killed_at_random_moments_go_on():
    storm(6, 1)


if __name__ == "__main__":
    if "--storm" in sys.argv:
        at = sys.argv.index("--storm")
        numbers = [int(n) for n in sys.argv[at + 1:]]
        scene.CHECKS["storm"] = lambda: storm(numbers[0], numbers[1] if len(numbers) > 1 else 1)
        sys.argv[at:] = ["storm"]
    sys.exit(scene.main())

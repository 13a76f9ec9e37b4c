"""Many runs at once, over a grid of options or over any list of them: jobs of tendril's -task sweep."""

from __future__ import annotations

import csv
import itertools
import os
import tempfile
from concurrent.futures import ThreadPoolExecutor
from contextlib import nullcontext
from pathlib import Path
from typing import Mapping, Sequence

from .collection import Sweep, load_sweep
from .errors import RunError, TendrilError, arguments, positive
from .progress import bar
from .readers import heading, is_number
from .results import Results
from .runs import execute, launched, run, scene_words, task_of, text_of, texts_of, words_of
from .sweep_seen import SweepSeen

ALONE = {"task", "restart", "output", "quiet", "options_file"}  # a member with these runs by itself


def cores() -> int:
    return len(os.sched_getaffinity(0))


def write_table(path, members: Sequence[dict[str, str]]):
    """The table of a sweep, a member a line."""
    names = list(dict.fromkeys(name for member in members for name in member))
    with open(path, "w", newline="", encoding="utf-8") as file:
        table = csv.writer(file)
        table.writerow(names)
        table.writerows([member.get(name, "") for name in names] for member in members)


def stored(members: Sequence[dict], scene=None, jobs: int | None = None) -> list[Results | RunError]:
    """Short runs of a scene with each member's options, shared out over some processes of -task sweep,
    which start faster than one of several ranks. The results are series and shapes alone, without the
    attributes of a file."""
    jobs = min(jobs or cores(), len(members))
    found: list = [None] * len(members)

    def share(k):
        with tempfile.TemporaryDirectory(prefix="tendril-") as place:
            table, output = Path(place) / "table.csv", Path(place) / "runs.h5"
            texts = []
            for number, member in enumerate(members[k::jobs]):
                own = Path(place) / str(number)
                own.mkdir()
                texts.append(texts_of(member, own))
            write_table(table, texts)
            execute([*launched(1), *scene_words(scene, place), "-task", "sweep", "-sweep_file", str(table),
                     "-sweep_store", "series,shapes", "-output", str(output), "-quiet"])
            sweep = whole(load_sweep(output))
        found[k::jobs] = list(sweep.members.flat)

    with ThreadPoolExecutor(max(jobs, 1)) as pool:
        list(pool.map(share, range(jobs)))
    return found


def whole(sweep: Sweep) -> Sweep:
    """A sweep of which all is in memory: its file may go."""
    for table in (sweep.columns, sweep.final, sweep.critical, sweep.series, sweep.shapes):
        table.values()
    return sweep


def grid(over) -> dict[str, list]:
    """The axes of a grid, checked; a unit behind a name, "growth_width (mm)", stands behind its numbers."""
    if not isinstance(over, Mapping) or not over or not all(isinstance(name, str) for name in over):
        raise TendrilError('sweep: give what to vary, over={"friction_mu": [0, 0.5, 1]}')
    axes = {}
    for name, values in over.items():
        if isinstance(values, (str, bytes, dict)) or not hasattr(values, "__iter__") or hasattr(values, "ndim") and values.ndim != 1:
            raise TendrilError(f"sweep: over[{name!r}] is {values!r}: give a list of values")
        option, unit = heading(name.lstrip("-"))
        axes[option] = [f"{text_of(value)}{unit}" if unit and is_number(text_of(value)) else value for value in values]
        if not axes[option]:
            raise TendrilError(f"sweep: over[{name!r}] has no value: give some, or leave it out")
    return axes


def in_one_job(over, members, words, place, jobs, progress, seen=None) -> Sweep:
    """All members by one job, into one file of a directory; one that is there already is gone on with,
    if it is of the same table and options."""
    table, output = place / "sweep.csv", place / "sweep.h5"
    texts = [texts_of(member, place / "arrays") for member in members]
    write_table(table, texts)
    rest = [word for before, word in zip(["", *words], words) if "-task" not in (before, word)]
    store = [] if task_of(words) == "critical" else ["-sweep_store", "series,shapes"]
    try:
        with seen.following(output, over) if seen else nullcontext():
            execute([*launched(min(jobs, len(texts))), *rest, "-task", "sweep", "-sweep_task", task_of(words),
                     "-sweep_file", str(table), "-output", str(output), *store], progress=progress)
    except RunError as error:
        line = str(error).replace(f"output {output}: holds a sweep", f"directory {place}: holds a sweep")
        line = line.replace("name another file", "name another directory")
        raise RunError(line.removeprefix(f"sweep_file {table}: "), error.command) from None
    found = load_sweep(output, over)
    if seen:
        seen.look(found)
    return found


def one_by_one(members, scene, options, jobs, progress, seen=None):
    """A process a member: tasks that are none of a sweep."""
    def one(member):
        try:
            return run(scene, progress=False, **options | member)
        except RunError as error:
            return error

    with ThreadPoolExecutor(jobs) as pool, bar(progress, len(members)) as shown:
        found = []
        for k, r in enumerate(pool.map(one, members)):
            found.append(r)
            if seen:
                seen.member(k, r)
            shown.update()
    return found


@arguments(directory="file?", progress="flag?")
def sweep(scene=None, over: Mapping[str, Sequence] | None = None, *, directory=None,
          jobs: int | None = None, progress: bool | None = None, watch=None, **options) -> Sweep:
    """Runs every combination of the values of some options, in one job of tendril's -task sweep.

    over       {"friction_mu": [0, 0.5, 1], "growth_initial_length (mm)": [20, 30]}; the unit may stand behind each value
    directory  where sweep.h5 is kept, the file of all runs. If it is there, of the same sweep, only what
               is missing is run; of another one it is refused. None: nothing is kept
    jobs       runs at a time; None: as many as there are cores
    progress   a bar; None: in a terminal and in a notebook
    watch      a page of tendril.watch(), which shows members as they end
    options    those that all runs share, as for run; output_shapes or output_interval for more shapes
               of each than the first and last"""
    over = grid(over)
    jobs = cores() if jobs is None else positive(jobs, "jobs")
    if twice := [name for name in over if name in options]:
        raise TendrilError(f"sweep: {twice[0]} is varied, and given as {options[twice[0]]} for all; leave one of both out")
    members = [dict(zip(over, point)) for point in itertools.product(*over.values())]
    seen = SweepSeen(watch, scene, over) if watch else None
    with tempfile.TemporaryDirectory(prefix="tendril-") as temporary:
        place = Path(directory or temporary)
        (place / "arrays").mkdir(parents=True, exist_ok=True)
        words = [*scene_words(scene, place / "arrays"), *words_of(options, place / "arrays")]
        if task_of(words) in ("grow", "critical") and not ALONE & over.keys() and "restart" not in options:
            try:
                found = in_one_job(over, members, words, place, jobs, progress, seen)
                kept = found if directory else whole(found)
            except RunError as error:
                if directory or "has rods in space" not in str(error):
                    raise
                kept = Sweep(over, one_by_one(members, scene, options, jobs, progress, seen))  # of whose shapes one file is none
        else:
            kept = Sweep(over, one_by_one(members, scene, options, jobs, progress, seen))
        if not any((place / "arrays").iterdir()):
            (place / "arrays").rmdir()
    if seen:
        seen.ended()
    return kept

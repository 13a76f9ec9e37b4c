"""Many runs at once, over a grid of options or over any list of them: jobs of tendril's -task sweep."""

from __future__ import annotations

import csv
import itertools
import os
import shlex
import tempfile
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Mapping, Sequence

import numpy as np

from .collection import load_sweep
from .errors import RunError, TendrilError
from .results import Results, load
from .runs import execute, launched, run, scene_words, words_of

if TYPE_CHECKING:
    import xarray

LONGEST_NAME = 240  # of a result file, without its ending
ALONE = {"task", "restart", "output", "quiet", "options_file"}  # a member with these runs by itself


def cores() -> int:
    return len(os.sched_getaffinity(0))


def texts_of(options, directory) -> dict[str, str]:
    """{option: its value as tendril reads it}; arrays go into files in the directory."""
    words = words_of(options, directory)
    return dict(zip((word[1:] for word in words[::2]), words[1::2]))


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
            sweep = load_sweep(output)
        found[k::jobs] = [sweep.member(i) if sweep.status[i] == 1 else RunError(str(sweep.line[i]))
                          for i in range(len(sweep))]

    with ThreadPoolExecutor(max(jobs, 1)) as pool:
        list(pool.map(share, range(jobs)))
    return found


def task_of(words) -> str:
    """What a command line does."""
    task = "grow"
    for word, value in zip(words, words[1:]):
        if word == "-options_file":
            lines = [shlex.split(line, comments=True) for line in Path(value).read_text().splitlines()]
            task = next((line[1] for line in lines[::-1] if line[:1] == ["-task"]), task)
        elif word == "-task":
            task = value
    return task


def file_name(texts: Mapping[str, str]) -> str:
    """The name of a member's result file, without its ending, as -sweep_directory has it."""
    return "__".join(f"{name}={text}" for name, text in texts.items()).replace("/", "_")


def in_one_job(texts, words, task, directory, temporary, jobs, progress):
    """Runs all members by one job, which leaves their files in a directory. [RunError or None] of each."""
    table, output = Path(temporary) / "sweep.csv", Path(temporary) / "sweep.h5"
    write_table(table, texts)
    rest = [word for before, word in zip(["", *words], words) if "-task" not in (before, word)]
    execute([*launched(min(jobs, len(texts))), *rest, "-task", "sweep", "-sweep_task", task, "-sweep_file",
             str(table), "-sweep_directory", str(directory), "-output", str(output)], progress=progress)
    sweep = load_sweep(output)
    (Path(directory) / "running").rmdir()
    return [None if status == 1 else RunError(str(line)) for status, line in zip(sweep.status, sweep.line)]


def run_all(members: Sequence[dict], scene=None, options: Mapping | None = None, *, directory=None,
            jobs: int | None = None, progress: bool | None = None) -> list[Results | RunError]:
    """Runs the scene with each member's options, several at a time; in the place of a run that
    failed stands its error.

    options    those that all members share
    directory  where the result files are kept; None: they are not
    jobs       runs at a time; None: as many as there are cores"""
    jobs, options = jobs or cores(), dict(options or {})
    with tempfile.TemporaryDirectory(prefix="tendril-") as temporary:
        place = Path(directory or temporary)
        place.mkdir(parents=True, exist_ok=True)
        words = [*scene_words(scene, temporary), *words_of(options, temporary)]
        texts = []
        for number, member in enumerate(members):
            own = Path(temporary) / str(number)
            own.mkdir()
            texts.append(texts_of(member, own))
        files = [place / f"{file_name(t)}.h5" for t in texts]
        task = task_of(words)
        if task in ("grow", "critical") and not any(ALONE & t.keys() for t in texts) \
                and "restart" not in options and max(len(f.stem) for f in files) <= LONGEST_NAME:
            errors = in_one_job(texts, words, task, place, temporary, jobs, progress)
            return [error or load(file) for file, error in zip(files, errors)]
        return one_by_one(members, scene, options, files if directory else [None] * len(files), jobs,
                          progress)


def one_by_one(members, scene, options, outputs, jobs, progress):
    """A process a member: tasks that are none of a sweep."""
    from tqdm import tqdm

    def one(member, output):
        try:
            return run(scene, output=output, progress=False, **options | member)
        except RunError as error:
            return error

    with ThreadPoolExecutor(jobs) as pool:
        return list(tqdm(pool.map(one, members, outputs), total=len(members), desc="tendril", leave=False,
                         disable=None if progress is None else not progress))


def final_values(r: Results, si=False) -> dict:
    """{name: (value, unit)} of the last step, or of -task critical."""
    group = "series" if r.series else "critical"
    columns = {name: r.column(group, name, si) for name, values in getattr(r, group).items()
               if r.series or np.ndim(values) == 0}
    return {name: (float(np.ravel(values)[-1]), unit) for name, (values, unit) in columns.items()}


@dataclass
class Sweep:
    """The runs of a grid: sweep.members is an array of Results, of the shape of the grid, with a
    RunError in the place of one that failed."""

    over: dict  # option -> its values
    members: np.ndarray  # of objects, an axis an option

    def __iter__(self):
        """(options of the member, its Results or RunError), one after the other"""
        points = itertools.product(*self.over.values())
        return ((dict(zip(self.over, point)), r) for point, r in zip(points, self.members.flat))

    @property
    def failed(self) -> list[tuple[dict, RunError]]:
        return [(point, r) for point, r in self if isinstance(r, RunError)]

    def dataset(self, si=False) -> xarray.Dataset:
        """Where the runs ended: the last value of each series (of -task critical its numbers) over
        the options, as an xarray Dataset; NaN where a run failed."""
        import xarray

        last = [None if isinstance(r, RunError) else final_values(r, si) for r in self.members.flat]
        known = next((values for values in last if values), None)
        if known is None:
            raise TendrilError(f"no run of this sweep came to its end: {self.failed[0][1]}")
        data = {name: (tuple(self.over),
                       np.reshape([values[name][0] if values else np.nan for values in last],
                                  self.members.shape), {"units": unit})
                for name, (_, unit) in known.items()}
        return xarray.Dataset(data, {name: list(values) for name, values in self.over.items()})


def sweep(scene=None, over: Mapping[str, Sequence] | None = None, *, directory=None,
          jobs: int | None = None, progress: bool | None = None, **options) -> Sweep:
    """Runs every combination of the values of some options, in one job of tendril's -task sweep.

    over       {"friction_mu": [0, 0.5, 1], "growth_initial_length": [1, 2]}
    directory  where the result files are kept, NAME=VALUE__NAME=VALUE.h5; None: they are not
    jobs       runs at a time; None: as many as there are cores
    options    those that all runs share, as for run"""
    if not over:
        raise TendrilError('sweep: give what to vary, over={"friction_mu": [0, 0.5, 1]}')
    over = {name.lstrip("-"): list(values) for name, values in over.items()}
    members = [dict(zip(over, point)) for point in itertools.product(*over.values())]
    found = np.empty(len(members), object)
    found[:] = run_all(members, scene, options, directory=directory, jobs=jobs, progress=progress)
    return Sweep(over, found.reshape([len(values) for values in over.values()]))

"""Many runs at once, over a grid of options or over any list of them."""

from __future__ import annotations

import itertools
import os
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Mapping, Sequence

import numpy as np

from .errors import RunError, TendrilError
from .results import Results
from .runs import run, text_of

if TYPE_CHECKING:
    import xarray


def cores() -> int:
    return len(os.sched_getaffinity(0))


def run_all(members: Sequence[dict], scene=None, jobs: int | None = None,
            progress: bool | None = None) -> list[Results | RunError]:
    """Runs the scene with each member's options, several at a time; in the place of a run that
    failed stands its error.

    jobs  runs at a time; None: twice the cores, as short runs mostly wait for MPI to start and end"""
    from tqdm import tqdm

    def one(options):
        try:
            return run(scene, **{"progress": False} | options)
        except RunError as error:
            return error

    with ThreadPoolExecutor(jobs or 2 * cores()) as pool:
        return list(tqdm(pool.map(one, members), total=len(members), desc="tendril", leave=False,
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
    """Runs every combination of the values of some options.

    over       {"friction_mu": [0, 0.5, 1], "growth_initial_length": [1, 2]}
    directory  where the result files are kept, NAME=VALUE__NAME=VALUE.h5; None: they are not
    options    those that all runs share, as for run"""
    if not over:
        raise TendrilError('sweep: give what to vary, over={"friction_mu": [0, 0.5, 1]}')
    over = {name.lstrip("-"): list(values) for name, values in over.items()}
    members = []
    for point in itertools.product(*over.values()):
        member = dict(zip(over, point))
        if directory is not None:
            Path(directory).mkdir(parents=True, exist_ok=True)
            name = "__".join(f"{name}={text_of(value)}" for name, value in member.items())
            member["output"] = Path(directory) / f"{name}.h5"
        members.append(options | member)
    found = np.empty(len(members), object)
    found[:] = run_all(members, scene, jobs, progress)
    return Sweep(over, found.reshape([len(values) for values in over.values()]))

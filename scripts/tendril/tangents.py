"""Runs beside a run, by its derivatives: what it would be with numbers that differ a little."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from .results import Results, Table

STEP = 1e-4  # of differences along derivatives, in parts of a parameter's bounds
BEYOND = 0.5  # of the last interval between shapes: runs beside may be looked at a little after their end


def extended(t, values):
    """An array over t with one row more behind its end: the polynomial through the last four."""
    last = t[-4:]
    at = t[-1] + BEYOND * (t[-1] - t[-2])
    weights = [np.prod([(at - b) / (a - b) for b in last if b != a]) for a in last]
    return np.concatenate([values, [np.tensordot(weights, values[-4:], 1)]])


def beside(r: Results, changes, attributes) -> Results:
    """A run with -sensitivity, moved along its derivatives and made a little longer.

    changes     {option: by how much its number changes}
    attributes  of the run beside, which has other units if they depend on the numbers"""
    by = {name: r.sensitivity(name) for name in changes}

    def moved(group):
        table = getattr(r, group)
        new = Table({name: values + sum(change * getattr(by[option], group)[name] for option, change in changes.items()
                                        if name in getattr(by[option], group)) for name, values in table.items()})
        rows = {name for name, values in table.items() if np.shape(values)[:1] == table.t.shape and name != "s"}
        return Table({name: extended(table.t, values) if name in rows else values for name, values in new.items()})

    return replace(r, series=moved("series"), shapes=moved("shapes"), attributes=attributes)

"""How far something is, for all that takes a while: a bar in a terminal and in a notebook."""

from __future__ import annotations

import sys

SOON = 0.5  # seconds: what ends before needs no bar


def wanted(progress: bool | None) -> bool:
    """Whether there is a bar; None: where somebody looks on."""
    return bool(sys.stderr.isatty() or "ipykernel" in sys.modules) if progress is None else progress


def bar(progress: bool | None, total, form: str | None = None, what="tendril", unit="it"):
    """A bar of tqdm, where it is wanted."""
    from tqdm import tqdm

    return tqdm(total=total, desc=what, bar_format=form, unit=unit, leave=False, delay=SOON,
                disable=not wanted(progress))

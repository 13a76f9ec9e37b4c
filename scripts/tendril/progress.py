"""How far something is, for all that takes a while: a bar in a terminal and in a notebook."""

from __future__ import annotations

import sys


def bar(progress: bool | None, total, form: str | None = None, what="tendril"):
    """A bar of tqdm. progress: whether there is one; None: where somebody looks on."""
    from tqdm import tqdm

    seen = sys.stderr.isatty() or "ipykernel" in sys.modules
    return tqdm(total=total, desc=what, bar_format=form, leave=False,
                disable=not (seen if progress is None else progress))

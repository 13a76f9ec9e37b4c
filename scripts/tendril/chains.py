"""Lines from pieces that share end points, as ParaView, skeletons, networks and OBJ files have them."""

from __future__ import annotations

import numpy as np


def joined(x, cells):
    """Lines, each a list of indices of points, from pieces (lists of indices): two that share an end point where no third one
    ends are one. Where they branch the pieces between the forks are the lines. Pieces of more than two points are not cut, nor
    are two of them joined where the one goes back where the other came from, as VMTK's lines do at their common inlet. In the
    order of the first piece of each, and in the sense of most of them; of as many either way, from the first of the points.

    x  [n, 3], points; those at one place are one"""
    same = places(x)
    pieces, seen = [], set()
    for cell in cells:
        key = tuple(same[k] for k in cell)
        key = min(key, key[::-1])
        if len(cell) > 2 or (len(cell) == 2 and key[0] != key[1] and key not in seen):  # no piece of nothing, none twice
            pieces.append([int(k) for k in cell])
        seen.add(key)
    ends = {}
    for k, piece in enumerate(pieces):
        for end in (0, -1):
            ends.setdefault(same[piece[end]], []).append((k, end))
    used, lines = set(), []

    def grown(line, free):
        """The line with the pieces behind its last point, which is that end of a piece: (piece, 0 or -1)."""
        line = list(line)
        while len(here := ends[same[line[-1]]]) == 2:
            k, end = here[0] if here[1] == free else here[1]
            more = pieces[k] if end == 0 else pieces[k][::-1]
            if k in used or (min(len(more), len(pieces[free[0]])) > 2 and turns_back(x, line, more)):
                break
            used.add(k)
            line += more[1:]
            free = (k, -1 - end)
            senses.append(1 if end == 0 else -1)
        return line

    for k, piece in enumerate(pieces):
        if k not in used:
            used.add(k)
            senses = [1]
            line = grown(piece, (k, -1))
            ahead, senses = sum(senses), []
            line = grown(line[::-1], (k, 0))[::-1]
            sense = ahead - sum(senses)
            lines.append(line[::-1] if sense < 0 or (sense == 0 and line[-1] < line[0]) else line)
    return lines


def places(x):
    """For each point the first one at its place."""
    x = np.asarray(x, float)
    size = float(np.ptp(x, axis=0).max()) if len(x) else 0.0
    _, first, which = np.unique(np.round(x / (1e-7 * size)) if size > 0 else 0 * x, axis=0, return_index=True, return_inverse=True)
    return first[which.ravel()]


def turns_back(x, line, more):
    """Whether a piece goes back where the line came from."""
    return float((x[line[-1]] - x[line[-2]]) @ (x[more[1]] - x[more[0]])) < 0

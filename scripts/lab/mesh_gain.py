#!/usr/bin/env python3
"""Would a mesh that follows where the rod bends pay? The error of a cell of arc length h is about
h^5 |d^5 y|; cells that share it evenly are as many as the integral of |d^5 y|^(1/5), cells of one
length as many as its largest value times the length. Their ratio is the part of the cells that such
a mesh would need for the same error, if it could be changed at every step for nothing.

    mesh_gain.py RESULT.h5 ..."""

import sys

import numpy as np

import tendril


def density(s, y):
    """|d^5 y/ds^5|^(1/5) of a field over the arc, smoothed over ten cells; 0 where it is noise."""
    for _ in range(4):
        y = np.gradient(y, s)
    change = np.abs(np.gradient(y, s))
    kernel = np.hanning(11)
    return np.convolve(change, kernel / kernel.sum(), "same")[10:-10] ** 0.2


def needed(run, k):
    """The part of uniform cells, for the shape stored k-th."""
    x = np.asarray(run.shapes.x[k])
    s = np.concatenate([[0], np.cumsum(np.hypot(*np.diff(x, axis=0).T))])
    theta = np.unwrap(np.arctan2(np.gradient(x[:, 1], s), np.gradient(x[:, 0], s)))
    d = density(s, theta)
    return np.trapezoid(d, s[10:-10]) / (d.max() * (s[-11] - s[10]))


def main():
    print(f"{'scene':30} cells needed, of uniform ones, at times:")
    for name in sys.argv[1:]:
        run = tendril.load(name)
        t = np.asarray(run.shapes.t)
        if np.abs(np.asarray(run.shapes.x[-1])[:, 1]).max() < 1e-3:
            continue
        shown = [k for k in range(len(t)) if np.asarray(run.shapes.x[k])[:, 1].max() > 1e-3]
        shown = shown[:: max(1, len(shown) // 5)]
        print(f"{name:30}", "  ".join(f"{t[k]:g}: {needed(run, k):.2f}" for k in shown), flush=True)


if __name__ == "__main__":
    sys.exit(main())

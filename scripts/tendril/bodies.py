"""Bodies: the signed distance of a mesh on a grid, as fine as the rod's diameter asks, and how well it is met."""

from __future__ import annotations

from dataclasses import dataclass

import h5py
import numpy as np

from .errors import replacing
from .meshes import Distance, SurfaceError
from .progress import bar

MOST = 60_000_000  # values of a grid
COARSE = 4  # far from the surface the distance is taken at every fourth place only
SAMPLES = 1500
FINEST = 8  # spacings a diameter
DRAWN = 200_000  # triangles that are kept for pictures
STEEPER = 1.25  # slope of a distance at the surface, at most: the program refuses more


def axes_of(low, high, spacing):
    n = np.maximum(np.ceil((high - low) / spacing - 1e-9).astype(int) + 1, 4)
    return [low[d] + spacing * np.arange(n[d]) for d in range(3)]


def places_of(axes):
    return np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)


def on_grid(distance, axes, band, measure, count=lambda: None):
    """[n1, n2, n3] distances; within the band by `measure`, beyond it joined from every COARSE-th place. Calls `count`
    for each sheet."""
    from scipy.interpolate import RegularGridInterpolator

    spacing = axes[0][1] - axes[0][0]
    rough = rough_of(axes)
    values = np.empty([len(a) for a in rough])
    for k, x1 in enumerate(rough[0]):
        values[k] = distance.facets(places_of([[x1], *rough[1:]])).reshape(values.shape[1:])
        count()
    look = RegularGridInterpolator(rough, values)
    d = np.empty([len(a) for a in axes])
    reach = band + np.sqrt(3) * COARSE * spacing
    for k, x1 in enumerate(axes[0]):
        places = places_of([[x1], axes[1], axes[2]])
        sheet = look(places)
        near = np.abs(sheet) < reach
        if near.any():
            exact = distance.facets(places[near])
            close = np.abs(exact) < band
            if close.any() and measure is not distance.facets:
                exact[close] = measure(places[near][close])
            sheet[near] = exact
        d[k] = sheet.reshape(d.shape[1:])
        count()
    return d


def rough_of(axes):
    """Every COARSE-th place, to beyond the last."""
    spacing = axes[0][1] - axes[0][0]
    return [np.append(a[::COARSE], a[-1] + COARSE * spacing) for a in axes]


@dataclass
class Misfit:
    """Where the spline through a grid's values is farthest from the distance, at places near the surface."""

    error: float
    place: np.ndarray


def spline_error(axes, d, distance, measure, band, rng):
    """The largest error of the spline through the grid's values, at places near the surface."""
    from scipy.ndimage import map_coordinates, spline_filter

    corners = distance.mesh.corners[:distance.mesh.own]
    area = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
    which = rng.choice(len(area), SAMPLES, p=area / area.sum())
    share = rng.dirichlet([1, 1, 1], SAMPLES)
    x = np.einsum("ij,ijk->ik", share, corners[which])
    away = rng.normal(size=x.shape)
    x += away / np.linalg.norm(away, axis=1)[:, None] * rng.uniform(0, band, SAMPLES)[:, None]
    spacing = axes[0][1] - axes[0][0]
    low, high = (np.array([a[k] for a in axes]) for k in (0, -1))
    x = x[((x > low + 2 * spacing) & (x < high - 2 * spacing)).all(axis=1)]
    if not len(x):
        return Misfit(np.inf, low)
    at = ((x - low) / spacing).T
    c = spline_filter(d, order=3, mode="mirror")
    off = np.abs(map_coordinates(c, at, order=3, mode="mirror", prefilter=False) - measure(x))
    return Misfit(float(off.max()), x[np.argmax(off)])


def slope_of(d, spacing):
    """How much the grid's spline changes by length where the surface passes, on the average: 1 of a distance. The program
    asks the same (src/world/body.c)."""
    from scipy.ndimage import correlate1d, spline_filter

    changes = np.zeros(d.shape, bool)
    changes[:-1] |= d[:-1] * d[1:] <= 0
    changes[:, :-1] |= d[:, :-1] * d[:, 1:] <= 0
    c = spline_filter(d, order=3, mode="mirror")
    size2 = 0.0
    for axis in range(3):
        part = c
        for other in range(3):
            part = correlate1d(part, [-0.5, 0, 0.5] if other == axis else [1 / 6, 2 / 3, 1 / 6], axis=other, mode="mirror")
        size2 = size2 + part[changes] ** 2
    return float(np.sqrt(size2).mean() / spacing)


@dataclass
class Wish:
    """What a body is to be: of the options of surface()."""

    diameter: float | None
    spacing: float | None
    box: list | None
    facets: bool
    tolerance: float | None

    @property
    def width(self):
        """The rod's diameter, or what stands for it."""
        return self.diameter or 4 * self.spacing

    @property
    def finest(self):
        return self.spacing or self.width / FINEST

    def axes(self, mesh, h):
        edge = 3 * h + self.width
        low, high = mesh.points.min(axis=0) - edge, mesh.points.max(axis=0) + edge
        if self.box is not None:
            low, high = self.box
        count = np.prod(np.ceil((high - low) / h) + 1)
        if not count <= MOST:
            raise SurfaceError(f"a grid of spacing {h:.3g} has {count:.2g} values, {MOST:.0e} are the most: give a "
                               "larger spacing or tolerance, or a box about what the rod can reach")
        return axes_of(low, high, h)


def expected(mesh, axes, band):
    """How many distances a grid takes, about: the rough ones, and those near the surface."""
    h = axes[0][1] - axes[0][0]
    corners = mesh.corners
    area = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1).sum() / 2
    whole = float(np.prod([len(a) for a in axes]))
    return np.prod([len(a) for a in rough_of(axes)]) + min(whole, 2 * (band + np.sqrt(3) * COARSE * h) * area / h**3)


def size_told(mesh, axes, band, wish):
    """A grid's size, before the work begins."""
    shape = [len(a) for a in axes]
    h = axes[0][1] - axes[0][0]
    finest = "" if h <= 1.01 * wish.finest else f"; finer if need be, down to {wish.finest:.3g}"
    return (f"a grid of {' x '.join(map(str, shape))} = {np.prod(shape, dtype=float):.2g} values, {h:.3g} apart, "
            f"{megabytes(np.prod(shape, dtype=float))}, from about {expected(mesh, axes, band):.2g} distances to "
            f"{len(mesh.triangles)} triangles{finest}")


def megabytes(values):
    return f"{values * 8 / 1e6:.2g} MB" if values < 1.2e7 else f"{values * 8 / 1e6:.0f} MB"


@dataclass
class Grid:
    spacing: float
    axes: list
    values: np.ndarray  # [n1, n2, n3]
    misfit: Misfit
    distance: Distance
    rng: np.random.Generator


def grid_of(mesh, wish, tell, progress):
    """The grid of a mesh, as fine as is wanted."""
    rng = np.random.default_rng(0)
    goal = wish.tolerance or 0.002 * wish.width
    h, distance = wish.spacing or wish.width / 2, None
    while True:
        axes = wish.axes(mesh, h)
        band = 5 * h + wish.width / 2  # what is farther is felt through the spline by less than 2e-3 of its error
        tell(size_told(mesh, axes, band, wish))
        distance = distance or Distance(mesh)
        measure = distance.facets if wish.facets else distance.smooth
        with bar(progress, len(axes[0]) + len(rough_of(axes)[0]), what=f"surface, {h:.3g} apart", unit="sheet") as shown:
            d = on_grid(distance, axes, band, measure, shown.update)
        if not d.min() < 0 < d.max():
            raise SurfaceError("box: the mesh's surface is nowhere in it; give a box about what the rod can reach"
                               if wish.box is not None else "the mesh has no inside that a grid can see: give a smaller spacing")
        misfit = spline_error(axes, d, distance, measure, wish.width / 2, rng)
        if wish.spacing or misfit.error <= goal or h <= 1.01 * wish.width / FINEST:
            return Grid(h, axes, d, misfit, distance, rng)
        h = max(h * np.clip((goal / misfit.error) ** 0.25 * 0.9, 0.5, 0.84), wish.width / FINEST)


def met(mesh, wish, grid, back):
    """Refuses a grid that does not meet the surface, or that the program would refuse."""
    h, misfit = grid.spacing, grid.misfit
    slope = slope_of(grid.values, h)
    wrong = not 1 / STEEPER < slope < STEEPER
    if not wrong and (wish.spacing or not wish.width / 4 < misfit.error < np.inf):
        return
    place = "near (" + ", ".join(f"{v:.4g}" for v in back(misfit.place)) + ")"
    over = ", or its ends, led on, do" if mesh.own else ""
    if wrong:
        off = f", off by {misfit.error:.2g} {place}" if misfit.error < np.inf else ""
        raise SurfaceError(f"{mesh.name}: {h:.3g} apart the grid is no distance{off}: the mesh runs through itself{over}, or is "
                           "thinner than the grid is fine; mend it, or give a smaller spacing")
    raise SurfaceError(f"{mesh.name}: even {h:.3g} apart the distance is off by {misfit.error:.2g}, more than a quarter of the "
                       f"diameter, {place}: the mesh runs through itself{over}, or is thinner than the rod; mend it, or give "
                       "spacing to take it as it is")


def write_body(mesh, output, wish, unit, back, tell, progress):
    """Writes the file; returns the grid, and how far the triangles are from the smooth surface, None if that is not meant."""
    grid = grid_of(mesh, wish, tell, progress)
    met(mesh, wish, grid, back)
    flat = 0.0
    if not wish.facets:
        some = grid.rng.integers(mesh.own or len(mesh.triangles), size=SAMPLES)
        which, at = grid.distance.nearest(mesh.corners[some].mean(axis=1))
        flat = float(np.abs(grid.distance.bulge(which, at)[0]).max())
    with replacing(output) as part, h5py.File(part, "w") as f:
        f.create_dataset("distance", data=grid.values.transpose(2, 1, 0), chunks=True, compression="gzip", shuffle=True)
        f["origin"], f["spacing"] = [a[0] for a in grid.axes], [grid.spacing] * 3
        if unit:
            for name in ("distance", "origin", "spacing"):
                f[name].attrs["units"] = unit
        f.attrs.update(source=mesh.name, error=grid.misfit.error, facets=flat, diameter=wish.diameter or 0.0)
        if len(mesh.triangles) <= DRAWN:
            f.create_dataset("mesh/points", data=mesh.points, compression="gzip")
            f.create_dataset("mesh/triangles", data=mesh.triangles.astype(np.int32), compression="gzip")
    return grid, None if wish.facets else flat

"""What a fit has found: in words, as a table, as a picture, as an options file."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from scipy import stats

from .comparing import LINES
from .errors import RunError
from .found import Found
from .measured import Values
from .runs import lines_of, scene_words, text_of, write_arrays
from .style import BLUE, GREY, ORANGE, STYLE
from .units import DIMENSIONS, KINDS, PIXEL, briefly, suited_to

LOST = 0.5  # an interval that reaches this far, in parts of the bounds, tells nothing
CLOSE = 0.95  # a correlation from which on two parameters are hardly told apart


def unit_of(values: Values):
    """The name of a unit in which something was measured, in SI."""
    return {"": "", PIXEL: PIXEL, "rad": "rad"}.get(values.unit) or DIMENSIONS.get(values.unit, ("", ""))[1]


def shown(values: Values, most=None):
    """(what its numbers are multiplied by in words and pictures, the name of the unit they then have):
    centimetres for metres, where that suits, degrees for radians."""
    if values.unit == "rad":
        return np.degrees(1.0), "deg"
    if values.unit not in KINDS:
        return 1, unit_of(values)
    name, si = suited_to(KINDS[values.unit], np.nanmax(np.abs(values.numbers)) if most is None else most)
    return 1 / si, name


def labelled(text, unit):
    return f"{text} ({unit})" if unit else text


def share_of(fit: Found, k, part):
    """In words, how much a parameter changes over a part of its bounds."""
    p = fit.parameters[k]
    if p.logarithmic:
        return f"times {(p.high / p.low) ** part:.2g}"
    return f"{(p.high - p.low) * part:+.2g}{p.unit}"


def combination(fit: Found, axis, names):
    """What of two positive parameters is told, where only one number is: their ratio or the like."""
    a, b = names
    if not (fit.parameters[a].logarithmic and fit.parameters[b].logarithmic):
        return ""
    slope = [axis[k] * np.log(fit.parameters[k].high / fit.parameters[k].low) for k in names]
    power = -slope[0] / slope[1]
    name = [fit.parameters[k].name for k in names]
    if abs(power + 1) < 0.1:
        return f" Only {name[0]} / {name[1]} is told."
    if abs(power - 1) < 0.1:
        return f" Only {name[0]} x {name[1]} is told."
    return f" Only {name[0]} x {name[1]}^{power:.2g} is told."


def indistinct(fit: Found) -> list[str]:
    """What the data cannot tell, or hardly: directions in which the parameters may move over as much as
    their bounds and nothing is seen of it."""
    p = len(fit.parameters)
    variance, axes = np.linalg.eigh(fit.covariance[:p, :p])
    words, lost = [], set()
    reach = 1.96 * np.sqrt(np.maximum(variance, 0))
    for d, axis in zip(reach[::-1], axes.T[::-1]):
        if d < LOST:
            continue
        moved = [k for k in range(p) if abs(axis[k]) > 0.25 * np.abs(axis).max()]
        names = [fit.parameters[k].name for k in moved]
        lost.update(moved)
        if len(moved) == 1:
            words.append(f"{names[0]} cannot be told from these data: nothing of it is seen in the best scene.")
            continue
        part = 0.1 / np.abs(axis).max()
        together = ", ".join(f"{fit.parameters[k].name} {share_of(fit, k, part * axis[k])}" for k in moved)
        words.append(f"{' and '.join(names)} cannot be told apart by these data: {together}, and nothing "
                     f"is seen of it.{combination(fit, axis, moved) if len(moved) == 2 else ''}")
    correlations = fit.correlations
    for a in range(p):
        for b in range(a):
            if abs(correlations[a, b]) > CLOSE and not {a, b} <= lost:
                words.append(f"{fit.parameters[b].name} and {fit.parameters[a].name} are told apart only "
                             f"weakly: their estimates move together, correlation {correlations[a, b]:.3f}.")
    for q, x in zip(fit.parameters, fit.u):
        if min(x, 1 - x) < 1e-3:
            words.append(f"{q.name} is at its bound; the best value may lie beyond it.")
    return words


def parts_of(fit: Found, name, values):
    """In words, how errors are correlated, if they are."""
    g = fit.errors[name]
    factor, unit = shown(values, g.total)
    said = []
    if g.smooth > 0.1 * g.total:
        within = shown(values, g.reach) if name == LINES else (1, "")
        said.append(f"smooth {briefly(factor * g.smooth)} {unit}" + (
            f" over {briefly(within[0] * g.reach)} {within[1]}" if name == LINES else " over time"))
    if g.shift > 0.1 * g.total:
        said.append(f"of each photograph {briefly(factor * g.shift)} {unit}")
    return f" (of each point {briefly(factor * g.sigma)} {unit}, {', '.join(said)})" if said else ""


def describe(fit: Found) -> str:
    """The report: estimates, correlations, noise, what cannot be told."""
    width = max(len(p.name) for p in fit.parameters)
    lines = [f"{'':{width}}   estimate       95 % interval{'' if fit.trusted else ', NOT TO BE TRUSTED (see below)'}"]
    for p in fit.parameters:
        low, high = fit.intervals[p.name]
        lines.append(f"{p.name:{width}}   {fit.values[p.name]:<12.5g}   {low:.5g} to {high:.5g}"
                     f"{'  ' + p.unit if p.unit else ''}")
    if len(fit.parameters) > 1:
        lines.append("correlations")
        for k, p in enumerate(fit.parameters):
            lines.append(f"{p.name:{width}} " + " ".join(f"{c:7.3f}" for c in fit.correlations[k, :k + 1]))
    values = {c.name: c.values for c in fit.problem.measured.curves}
    values |= {LINES: p.points for p in fit.problem.measured.photographs}
    for name, noise in fit.noise.items():
        what = "centre lines" if name == LINES else name
        factor, unit = shown(values[name], noise)
        lines.append(f"noise of {what}: {factor * noise:.3g} {unit}".rstrip() + parts_of(fit, name, values[name]))
    lines.append(f"{fit.problem.measured.count()} points measured")
    lines += fit.problem.comparison.told(fit.run, fit.u[len(fit.parameters):])
    lines += [*fit.indistinct, *(f"! {words}" for words in fit.warnings)]
    lines += ["! interrupted: the best until then"] if fit.interrupted else []
    lines += [f"{fit.problem.count} runs, {fit.seconds:.0f} s"]
    return "\n".join(lines)


def table(fit: Found):
    """What was measured beside what was computed, a row a residual."""
    import pandas

    comparison, own = fit.problem.comparison, fit.u[len(fit.parameters):]
    view = fit.problem.view(fit.u)
    rows = []
    for p in fit.problem.measured.photographs:
        off, end, _, _ = comparison.of_photograph(fit.run, p, own, view)
        for value in (*off, *end):
            rows.append((LINES, p.source, p.abscissa, float(p.at.numbers), None, None, value,
                         unit_of(p.points)))
    for c in fit.problem.measured.curves:
        for at, measured, computed in zip(c.at.numbers, c.values.numbers, comparison.model(fit.run, c, view)):
            rows.append((c.name, c.source, c.abscissa, at, measured, computed, measured - computed,
                         unit_of(c.values)))
    return pandas.DataFrame(rows, columns=["group", "source", "over", "at", "measured", "computed",
                                           "residual", "unit"])


def normals(line):
    """[n, 2], to the left of a line of nodes."""
    along = np.gradient(line, axis=0)
    return np.column_stack([-along[:, 1], along[:, 0]]) / np.maximum(np.hypot(*along.T), 1e-300)[:, None]


def bands(fit: Found, photographs):
    """[(line [n, 2], how far the rod may lie to both sides of it [n])]: with x(s) its line at the estimate u, n its normal
    and C the covariance of all that was found, half of what holds 95 % is

        t sqrt(d C d),   d_k = n . dx/du_k,

    from runs that the end of the fit has made."""
    problem, p = fit.problem, len(fit.parameters)

    def lines(u, r):
        view = problem.view(u)
        return np.concatenate([problem.comparison.line(r, photo, u[p:], view).ravel() for photo in photographs])

    best = [problem.comparison.line(fit.run, photo, fit.u[p:], problem.view(fit.u)) for photo in photographs]
    slopes = problem.raw_jacobian(fit.u, central=True, of=lines).reshape(-1, 2, len(fit.u))
    across = np.einsum("ni,nik->nk", np.vstack([normals(line) for line in best]), slopes)
    half = np.median(fit.reach) * np.sqrt(np.maximum(np.einsum("na,ab,nb->n", across, fit.covariance, across), 0))
    return list(zip(best, np.split(half, np.cumsum([len(line) for line in best])[:-1])))


def draw_photograph(ax, fit: Found, p, line, half):
    factor, unit = shown(p.points)
    if half is not None:
        edges = [line + sign * half[:, None] * normals(line) for sign in (1, -1)]
        ax.fill(*(factor * np.vstack([edges[0], edges[1][::-1]]).T), color=BLUE, alpha=0.35, lw=0, label="95 % of shapes")
    ax.plot(*(factor * p.points.numbers.T), ".", ms=3, color=ORANGE, label="measured")
    ax.plot(*(factor * line.T), color=BLUE, lw=0.8, label="best scene")
    ax.set_aspect("equal", adjustable="datalim")
    if p.points.unit == PIXEL:
        ax.invert_yaxis()
    title = "no time"
    if p.abscissa:
        times, name = shown(p.at)
        title = f"${'t' if p.abscissa == 't' else 'L'}$ = {times * float(p.at.numbers):.4g} {name}".rstrip()
    ax.set_title(title, fontsize=8)
    ax.set_xlabel(labelled("$x_1$", unit))
    if ax.get_subplotspec().is_first_col():
        ax.set_ylabel(labelled("$x_2$", unit))


def draw_curve(ax, fit: Found, c):
    (along, at_unit), (factor, unit) = shown(c.at), shown(c.values)
    r = fit.run.column("series", c.abscissa, c.at.si)[0]  # from where the run begins
    all_of_it = replace(c, at=replace(c.at, numbers=np.linspace(r[0], c.at.numbers[-1], 400)))
    ax.plot(along * c.at.numbers, factor * c.values.numbers, ".", ms=4, color=ORANGE, label="measured")
    ax.plot(along * all_of_it.at.numbers, factor * fit.problem.comparison.model(fit.run, all_of_it, fit.problem.view(fit.u)),
            color=BLUE, label="best scene")
    ax.set_xlabel(labelled(c.abscissa, at_unit))
    ax.set_ylabel(labelled(c.name.replace("_", " "), unit))


def draw_residuals(ax, fit: Found):
    """How residuals, over their noise, are distributed, beside the normal distribution."""
    f = np.clip(fit.problem.residuals(fit.u)[fit.problem.errors.mine()], -5, 5)
    ax.hist(f, bins=int(np.clip(len(f) / 8, 11, 41)) // 2 * 2 + 1, range=(-5, 5), density=True, color=GREY)
    x = np.linspace(-5, 5, 201)
    ax.plot(x, stats.norm.pdf(x), color=BLUE, lw=0.8)
    ax.set_xlabel("residual over its error")
    ax.set_yticks([])
    evenly = any(block.evenly for block in fit.problem.errors.blocks)
    ax.set_title("residuals" if evenly else "residuals, correlation taken out", fontsize=8)


def draw(fit: Found, most=7):
    """What was measured beside the best scene; of many photographs some."""
    photographs = fit.problem.measured.photographs
    keep = np.unique(np.linspace(0, len(photographs) - 1, min(most, len(photographs))).astype(int))
    try:
        shapes = bands(fit, [photographs[k] for k in keep]) if len(keep) else []
    except RunError:  # beside the best scene none runs
        own, view = fit.u[len(fit.parameters):], fit.problem.view(fit.u)
        shapes = [(fit.problem.comparison.line(fit.run, photographs[k], own, view), None) for k in keep]
    panels = [(draw_photograph, photographs[k], *shape) for k, shape in zip(keep, shapes)]
    panels += [(draw_curve, c) for c in fit.problem.measured.curves]
    rows = -(-(len(panels) + 1) // 4)
    columns = -(-(len(panels) + 1) // rows)
    with plt.rc_context(STYLE):
        figure, axes = plt.subplots(rows, columns, figsize=(2.1 * columns, 1.9 * rows + 0.3),
                                    squeeze=False, layout="constrained")
        for ax, (panel, *what) in zip(axes.flat, panels):
            panel(ax, fit, *what)
        draw_residuals(axes.flat[len(panels)], fit)
        for ax in axes.flat[len(panels) + 1:]:
            ax.set_axis_off()
        figure.legend(*axes.flat[0].get_legend_handles_labels(), loc="outside upper left", ncol=3)
    plt.close(figure)
    return figure


def scene_lines(fit: Found):
    """Options of the scene that the fit began with, as they were written."""
    words = scene_words(fit.problem.scene, ".") if not isinstance(fit.problem.scene, dict) else []
    if isinstance(fit.problem.scene, dict):
        return [f"-{name} {text_of(value)}" for name, value in fit.problem.scene.items()]
    return lines_of(words[1]) if words else []


def scene_text(fit: Found, arrays=None) -> str:
    """The best scene: the lines of the one that the fit began with, those replaced that it changed.
    arrays: name -> file, of options whose value is a dict of arrays."""
    options = fit.problem.words(fit.u[:len(fit.parameters)])
    given = {name: (arrays or {}).get(name, f"{name}.h5") if isinstance(value, dict) else text_of(value)
             for name, value in options.items() if value is not None}
    kept = [line for line in scene_lines(fit) if not line.startswith("-")
            or line[1:].split()[0] not in given]
    found = [f"-{name} {value}" for name, value in given.items()]
    return "\n".join([*kept, f"# by tendril.fit{'' if fit.trusted else ', not to be trusted: see its report'}", *found]) + "\n"


def save(fit: Found, basename):
    """Writes BASENAME.opts, .txt, .csv, .json, .png, .pdf, and the files of arrays that the scene has."""
    arrays = {}
    for name, value in fit.problem.words(fit.u[:len(fit.parameters)]).items():
        if isinstance(value, dict):
            arrays[name] = write_arrays(f"{basename}-{name}.h5", value)
    Path(f"{basename}.opts").write_text(scene_text(fit, arrays))
    Path(f"{basename}.txt").write_text(describe(fit) + "\n")
    table(fit).to_csv(f"{basename}.csv", index=False)
    fit.to_json(f"{basename}.json")
    figure = draw(fit)
    with plt.rc_context(STYLE):
        for ending in ("png", "pdf"):
            figure.savefig(f"{basename}.{ending}")

"""The look of all pictures: colours that colour-blind readers can tell apart, the type of a journal."""

from __future__ import annotations

from pathlib import Path

from matplotlib import rc_context
from matplotlib.figure import Figure

from .errors import replacing

# Okabe and Ito's colours, told apart by colour-blind readers; times run along a sequential map.
BLUE, ORANGE, GREEN, RED, GREY = "#0072B2", "#E69F00", "#009E73", "#D55E00", "#777777"
COLOURS = (BLUE, RED, GREEN, ORANGE, "#CC79A7", "#56B4E9", "#000000")  # of runs drawn together
STYLE = {
    "font.size": 8, "font.family": ["STIXGeneral"], "font.serif": ["STIXGeneral"],
    "mathtext.fontset": "stix", "axes.linewidth": 0.6, "axes.labelsize": 9, "axes.titlesize": 9,
    "lines.linewidth": 1.1, "xtick.direction": "in", "ytick.direction": "in",
    "xtick.top": True, "ytick.right": True, "xtick.major.width": 0.6, "ytick.major.width": 0.6,
    "legend.frameon": False, "legend.fontsize": 8, "legend.handlelength": 1.6,
    "legend.columnspacing": 1.2, "legend.borderaxespad": 0.2, "legend.handletextpad": 0.5,
    "axes.formatter.offset_threshold": 7,  # 0.17404 is read more easily than 4 beside a 1e-5+1.74e-1
    "axes.unicode_minus": True, "savefig.dpi": 300, "figure.dpi": 150,
    "pdf.fonttype": 42, "ps.fonttype": 42,  # journals refuse Type 3
}
ENDINGS = (".png", ".pdf", ".svg", ".eps", ".jpg", ".tif", ".tiff")


class InStyle(Figure):
    """A figure that keeps the style whoever draws or saves it, a notebook or savefig("x.pdf")."""

    def draw(self, renderer):
        with rc_context(STYLE):
            super().draw(renderer)

    def savefig(self, *words, **more):
        with rc_context(STYLE):
            super().savefig(*words, **more)


def save(figure, output, usual):
    """Saves a figure as PNG and PDF under a name, or as the one thing that the name's ending says. output:
    None or empty: the usual name. Returns what was written, in words."""
    output = str(output or usual)
    endings = [""] if Path(output).suffix.lower() in ENDINGS else [".png", ".pdf"]
    for ending in endings:
        with replacing(output + ending) as part:
            figure.savefig(part)
    return output + " and ".join(endings)

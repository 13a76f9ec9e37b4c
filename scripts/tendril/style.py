"""The look of all pictures: colours that colour-blind readers can tell apart, the type of a journal."""

# Okabe and Ito's colours, told apart by colour-blind readers; times run along a sequential map.
BLUE, ORANGE, GREEN, RED, GREY = "#0072B2", "#E69F00", "#009E73", "#D55E00", "#777777"
COLOURS = (BLUE, RED, GREEN, ORANGE, "#CC79A7", "#56B4E9", "#000000")  # of runs drawn together
STYLE = {
    "font.size": 8, "font.family": "serif", "font.serif": ["STIXGeneral"],
    "mathtext.fontset": "stix", "axes.linewidth": 0.6, "axes.labelsize": 9, "axes.titlesize": 9,
    "lines.linewidth": 1.1, "xtick.direction": "in", "ytick.direction": "in",
    "xtick.top": True, "ytick.right": True, "xtick.major.width": 0.6, "ytick.major.width": 0.6,
    "legend.frameon": False, "legend.fontsize": 8, "legend.handlelength": 1.6,
    "legend.columnspacing": 1.2, "legend.borderaxespad": 0.2, "legend.handletextpad": 0.5,
    "savefig.dpi": 200, "pdf.fonttype": 42,
}

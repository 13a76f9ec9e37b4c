"""Finds options of a scene that give what was measured: friction, stiffness, natural curvature or any
other, with intervals, from photographs or series.

    scripts/fit.sh mytube.opts photographs.csv --parameter si_friction_dry=0.1N/m:2N/m \\
      --parameter rod_curvature=-10/m:10/m --output fit
    scripts/fit.sh root.opts 20s@a.csv 30s@b.csv --unit px --parameter hard=1:10 \\
      -- -friction_layers "0:1,3cm:{hard}"

SCENE is an options file. DATA are CSV files, a photograph without its own time as TIME@FILE (20s@a.csv,
12cm@b.csv). Leaves BASENAME.opts, the best scene, .txt, the report, .json, the same in numbers, .csv, the residuals, and the
picture of what was measured beside it, .png and .pdf. What data may look like, and what the numbers
mean: docs/fitting.md."""

import argparse
import sys
from pathlib import Path

import matplotlib

from .command import Parser, per_second
from .errors import TendrilError, complaint, writable
from .fitting import fit
from .measured import Measured, gather, named, read
from .watching import live_options, shown_live

LEFT = (".opts", ".txt", ".csv", ".json", ".png", ".pdf")


def measured(words, unit, fps=None):
    """All DATA as one; a word is FILE or TIME@FILE."""
    files = []
    for word in words:
        at, _, path = word.rpartition("@")
        files.append((path, read(path, unit, at, fps)))
    whole = Measured()
    for one in named(files, fps):
        whole.photographs += one.photographs
        whole.curves += one.curves
        whole.notes += one.notes
    return gather(whole)


def parameters(words):
    """{name: "LOW:HIGH:START"}"""
    found = {}
    for word in words:
        name, equals, bounds = word.partition("=")
        if not equals:
            raise TendrilError(f"--parameter {word}: give NAME=LOW:HIGH or NAME=LOW:HIGH:START")
        found[name.lstrip("-")] = bounds
    return found


def pairs(words, what, form):
    """{name: text} of words NAME=TEXT."""
    found = {}
    for word in words or ():
        name, equals, text = word.partition("=")
        if not equals:
            raise TendrilError(f"--{what} {word}: give {form}")
        found[name.lstrip("-")] = text
    return found


def options(words):
    """{name: value} of words behind --, as on tendril's command line."""
    found, name = {}, None
    for word in words:
        if word.startswith("-") and word[1:2].isalpha():
            name = word[1:]
            found[name] = True
        elif name is None or found[name] is not True:
            raise TendrilError(f"{word}: a word without an option")
        else:
            found[name] = word
    return found


def keep(basename, scene, data):
    """What is read must not be written over by what is left."""
    for path in (scene, *(word.rpartition("@")[2] for word in data)):
        for ending in LEFT:
            if Path(path).exists() and Path(path).resolve() == Path(f"{basename}{ending}").resolve():
                raise TendrilError(f"--output {basename}: would write over {path}; give another name")


def main(arguments=None):
    parser = Parser("scripts/fit.sh", __doc__)
    parser.add_argument("scene", metavar="SCENE")
    parser.add_argument("data", nargs="+", metavar="DATA")
    parser.add_argument("--parameter", "-p", action="append", default=[],
                        metavar="NAME=LOW:HIGH[:START]", help="what is looked for; give it once for each")
    parser.add_argument("--unit", default="", help="of coordinates that carry none: cm, px, ...")
    parser.add_argument("--fps", type=per_second, help="frames per second, of data that count frames; or 6/h, 1/10min")
    parser.add_argument("--y-down", action=argparse.BooleanOptionalAction,
                        help="x2 is counted downwards; default: of px it is, else it is not")
    parser.add_argument("--prior", action="append", metavar="NAME=MEAN:DEVIATION",
                        help="what is known of a parameter, 0.5N/m:0.1N/m")
    parser.add_argument("--tied", action="append", metavar="NAME=FORMULA",
                        help='an option that follows from parameters, "si_friction_viscous=2*si_friction_dry Ns/m^2"')
    parser.add_argument("--noise", action="append", metavar="GROUP=NOISE",
                        help="of lines or a series, where it is known and independent: lines=0.5mm")
    parser.add_argument("--output", metavar="BASENAME", default="fit", help="default %(default)s")
    parser.add_argument("--accuracy", type=float, default=3e-4, help="of the runs; default %(default)s")
    parser.add_argument("--starts", type=int, help="that fill the bounds; default 24 for one parameter, 12 "
                        "for two, else 8")
    live_options(parser)
    parser.add_argument("--seed", type=int, default=1, help="of the starts; default %(default)s")
    words = list(sys.argv[1:] if arguments is None else arguments)
    own, more = (words[:words.index("--")], words[words.index("--") + 1:]) if "--" in words else (words, [])
    lone = next((k for k, word in enumerate(own[:-2]) if word in ("-p", "--parameter") and "=" not in own[k + 1]), None)
    if lone is not None:
        print(f"fit: --parameter {own[lone + 1]} {own[lone + 2]}: give name and bounds in one, "
              f"{own[lone + 1]}=LOW:HIGH", file=sys.stderr)
        return 1
    choice = parser.parse_args(own)
    matplotlib.use("Agg")
    try:
        if not choice.parameter and not choice.prior:
            raise TendrilError("give what to look for, --parameter si_friction_dry=0.1N/m:2N/m")
        keep(choice.output, choice.scene, choice.data)
        writable(choice.output)
        data = measured(choice.data, choice.unit, choice.fps)
        for note in data.notes:
            print(f"fit: {note}")
        with shown_live(choice.live, choice.port, not choice.no_browser) as page:
            found = fit(choice.scene, data, parameters(choice.parameter), unit=choice.unit, y_down=choice.y_down,
                        priors=pairs(choice.prior, "prior", "NAME=MEAN:DEVIATION"),
                        tied=pairs(choice.tied, "tied", "NAME=FORMULA"),
                        noise=pairs(choice.noise, "noise", "lines=0.5mm or SERIES=NOISE"),
                        accuracy=choice.accuracy, starts=choice.starts, seed=choice.seed, progress=True, watch=page, **options(more))
            print(found.report())  # before it is kept: it is not lost, whatever befalls the files
            found.save(choice.output)
    except (TendrilError, OSError) as error:
        print(complaint(error, "fit"), file=sys.stderr)
        return 1
    except KeyboardInterrupt:
        print("fit: interrupted before anything was found", file=sys.stderr)
        return 130
    print(f"fit: {choice.output}.opts is the best scene; .txt, .csv, .png and .pdf beside it")
    return 0

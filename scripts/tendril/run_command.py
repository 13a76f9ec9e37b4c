"""The commands run, sweep and critical: as scripts/run.sh, for who has the package alone."""

from __future__ import annotations

import sys
from pathlib import Path

from .command import NEGATIVE, Parser
from .errors import TendrilError
from .runs import critical, run
from .watching import live_options, shown_live

RUN = """Runs a scene and draws it: an options file, or the name of one of the gallery. Options of tendril (docs/options.md)
follow, as -friction_mu 0.5; they win over the scene's.

    tendril-py run feed
    tendril-py run mine.opts -rod_cells 200 --output results/mine.h5"""
CRITICAL = """Tells at which length the straight rod of a scene gives way, and how. Options of tendril follow.

    tendril-py critical critical-feed
    tendril-py critical -growth_type uniform -tip_force 1"""
SWEEP = """Runs a scene with several values of options, each combination of them, on all cores; a map or curves are drawn of it.

    tendril-py sweep feed -friction_mu 0.2,0.5,0.8
    tendril-py sweep feed -friction_mu 0.2,0.5,0.8 --live
    tendril-py sweep feed -friction_mu 0.2,0.5,0.8 -rod_curvature 0,0.1 --output results/sweep.h5"""


def split(words):
    """(words with two dashes, or none, and scene; options of tendril by name)."""
    own, options, k = [], {}, 0
    while k < len(words):
        word = "--output" if words[k] == "-output" else words[k]
        if word.startswith("-") and not word.startswith("--") and len(word) > 2 and not NEGATIVE.match(word):
            flag = k + 1 == len(words) or words[k + 1].startswith("-") and not NEGATIVE.match(words[k + 1])
            options[word.lstrip("-")] = "true" if flag else words[k + 1]
            k += 1 if flag else 2
        else:
            own.append(word)
            k += 1
    return own, options


def parsed(name, text, arguments, output, quantity=False):
    own, options = split(sys.argv[1:] if arguments is None else arguments)
    parser = Parser(f"tendril-py {name}", text)
    parser.add_argument("scene", nargs="?", help="an options file, or the name of a scene")
    if output:
        parser.add_argument("--output", metavar="FILE.h5", help="the result; default: results/SCENE.h5")
        parser.add_argument("--no-picture", action="store_true", help="draws none")
    if quantity:
        live_options(parser)
        parser.add_argument("--quantity", default="width", help="what is drawn, the last value of a series; default: %(default)s")
    choice = parser.parse_args(own)
    if choice.scene is None and not options:
        raise TendrilError(f"{name}: give a scene, or options; -h tells how")
    return choice, options


def result_of(choice, kind=""):
    file = Path(choice.output or f"results/{Path(choice.scene).stem if choice.scene else 'run'}{kind}.h5")
    file.parent.mkdir(parents=True, exist_ok=True)
    return file


def run_main(arguments=None):
    choice, options = parsed("run", RUN, arguments, True)
    file = result_of(choice)
    r = run(choice.scene, output=file, **options)
    print(f"run: {file}, t = {r.series.t[-1]:g}, length {r.series.length[-1]:g}")
    if not choice.no_picture:
        from .pictures import plot

        plot(r).savefig(file.with_suffix(".png"), dpi=150)
        print(f"run: {file.with_suffix('.png')}")
    return 0


def critical_main(arguments=None):
    choice, options = parsed("critical", CRITICAL, arguments, False)
    found = critical(choice.scene, **options)
    print(f"critical: {found!r}; error below {found.error:.1e}")
    return 0


def values_of(text):
    """The values between commas, numbers as numbers."""
    found = []
    for word in text.split(","):
        try:
            found.append(float(word))
        except ValueError:
            found.append(word)
    return found


def sweep_main(arguments=None):
    from .sweeps import sweep

    choice, options = parsed("sweep", SWEEP, arguments, True, True)
    axes = {name: values_of(value) for name, value in options.items() if "," in value}
    if not axes:
        raise TendrilError("sweep: give an option several values, with commas between: -friction_mu 0.2,0.5,0.8")
    rest = {name: value for name, value in options.items() if name not in axes}
    place = result_of(choice, "-sweep").with_suffix("")
    with shown_live(choice.live, choice.port, not choice.no_browser) as page:
        found = sweep(choice.scene, axes, directory=place, watch=page, **rest)
        print(f"sweep: {place}/sweep.h5, {found!r}")
        if not choice.no_picture and len(axes) <= 2:
            from .maps import map

            quantity = choice.quantity
            map(found, list(axes), quantity).savefig(place.with_suffix(".png"), dpi=150)
            print(f"sweep: {place.with_suffix('.png')} has {quantity} over {' and '.join(axes)}")
    return 0

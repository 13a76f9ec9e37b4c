"""tendril in Python: run it, sweep it, fit it to an experiment, read, draw and play its results.

    import tendril
    r = tendril.run("options/feed.opts", friction_mu=0.5)
    tendril.plot(r).savefig("feed.png")

What is here is imported when it is first asked for: reading a file does not wait for matplotlib.
The logger "tendril" tells the command lines that are run (INFO) and what they print (DEBUG).
"""

from importlib import import_module
from typing import TYPE_CHECKING

__version__ = "0.2.0"  # that of CMakeLists.txt

if TYPE_CHECKING:
    from .barriers import circle, conduit, plane, polygon
    from .collection import Sweep
    from .ensembles import ensemble
    from .errors import ResultsError, RunError, TendrilError
    from .comparison import compare
    from .drawing import draw
    from .filming import Filmed, measure
    from .films import animate
    from .fitting import Fit, fit
    from .maps import map
    from .openings import End, ends
    from .page import view
    from .pictures import plot
    from .live_server import live
    from .live_widget import widget
    from .loading import load
    from .results import Results, Shape
    from .root_systems import laterals, rods
    from .samples import profile, sample
    from .runs import Critical, critical, run
    from .simulation import Simulation
    from .surfaces import Surface, surface
    from .sweeps import sweep
    from .watching import watch

_HOME = {"circle": "barriers", "conduit": "barriers", "plane": "barriers", "polygon": "barriers",
         "ResultsError": "errors", "RunError": "errors", "TendrilError": "errors",
         "animate": "films", "ensemble": "ensembles", "Fit": "fitting", "fit": "fitting", "map": "maps",
         "compare": "comparison", "draw": "drawing", "Filmed": "filming", "measure": "filming", "profile": "samples",
         "sample": "samples", "view": "page", "plot": "pictures", "live": "live_server", "watch": "watching", "widget": "live_widget", "Results": "results", "Shape": "results", "load": "loading",
         "Critical": "runs", "critical": "runs", "run": "runs", "laterals": "root_systems", "rods": "root_systems", "Simulation": "simulation", "Sweep": "collection", "sweep": "sweeps",
         "End": "openings", "ends": "openings", "Surface": "surfaces", "surface": "surfaces"}
__all__ = sorted(_HOME)


def __getattr__(name):
    if name not in _HOME:
        from .naming import unknown

        raise AttributeError(f"module tendril has no {name}{unknown(name, __all__, '; it has')}")
    return getattr(import_module(f".{_HOME[name]}", __name__), name)


def __dir__():
    return [*__all__, "__version__"]

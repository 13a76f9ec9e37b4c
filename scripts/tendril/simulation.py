"""A simulation in this very process, step by step: the library libtendril behind a class.

    sim = tendril.Simulation("feed", friction_mu=0.5)
    while sim.step():
        print(sim.t, sim.x[-1], sim.series["base_force_1"][-1])

    sim.advance(3)                # as far as t = 3; sim.x is the rod there
    sim.set("tip_force", 0.2)     # from here on
    sim.save("so-far.h5")         # for tendril.load(), -restart and Simulation.load()

Options are those of tendril.run(); laws may be functions:

    tendril.Simulation(friction=lambda v2: (1 / (1 + v2), -1 / (1 + v2) ** 2), ts_max_time=1)

Any number of simulations live side by side. tendril.run() and sweeps keep processes of their own: these
use all cores, and what one of them does cannot hurt the others.
"""

from __future__ import annotations

import ctypes
import os
import tempfile
import threading
import weakref
from collections.abc import Mapping
from ctypes import CFUNCTYPE, POINTER, byref, c_char_p, c_double, c_int, c_void_p
from ctypes.util import find_library
from functools import lru_cache
from pathlib import Path

import numpy as np

from .errors import RunError, TendrilError
from .naming import unknown
from .runs import CHECKOUT, executable, rod_words, text_of, words_of

OK, ENDED, WATCH, USER, RUN, LAW, PETSC = range(7)  # what calls return, as tendril.h has it
NODE = np.dtype([("s", float), ("stretch", float), ("theta", float), ("x", float, 3), ("v", float, 3),
                 ("d", float, (3, 3)), ("curvature", float, 3), ("moment", float, 3), ("force", float, 3),
                 ("contact", float, 3)])
BY_WORDS = ("wall_friction", "wall_to", "wall_at", "wall_turn_to", "curvature_to", "curvature_2_to", "twist_to", "tip_to", "tip_turn_to")
VALUES = {"friction": 2, "growth": 5, "curvature": 6}  # of a law
LOCK = threading.RLock()  # PETSc is in one call at a time


class Place(ctypes.Structure):
    """Where a law is asked for."""

    _fields_ = [("s", c_double), ("t", c_double), ("speed2", c_double)]


LAW_TYPE = CFUNCTYPE(c_int, c_void_p, POINTER(Place), POINTER(c_double))
WATCH_TYPE = CFUNCTYPE(c_int, c_void_p, c_void_p)
CALLS = {"TendrilCreateFortran": [c_int, POINTER(c_void_p)], "TendrilDestroy": [POINTER(c_void_p)],
         "TendrilSet": [c_void_p, c_char_p, c_char_p], "TendrilSetLaw": [c_void_p, c_char_p, LAW_TYPE, c_void_p],
         "TendrilSetWatch": [c_void_p, WATCH_TYPE, c_void_p], "TendrilSetUp": [c_void_p],
         "TendrilStep": [c_void_p, POINTER(c_double)], "TendrilAdvance": [c_void_p, c_double],
         "TendrilTime": [c_void_p, POINTER(c_double)],
         "TendrilNodes": [c_void_p, c_int, POINTER(c_int), POINTER(c_void_p)],
         "TendrilSeries": [c_void_p, c_char_p, POINTER(c_int), POINTER(c_void_p)],
         "TendrilRods": [c_void_p, POINTER(c_int)], "TendrilRodName": [c_void_p, c_int],
         "TendrilRodSeriesName": [c_void_p, c_int, c_int],
         "TendrilRodSeries": [c_void_p, c_int, c_char_p, POINTER(c_int), POINTER(c_void_p)],
         "TendrilSeriesName": [c_void_p, c_int], "TendrilSave": [c_void_p, c_char_p],
         "TendrilSaveAt": [c_void_p, c_double, c_char_p], "TendrilLoad": [c_void_p, c_char_p],
         "TendrilMessage": [c_void_p], "TendrilVersion": []}


def places():
    """Where the library may be, the likeliest first."""
    yield from sorted(Path(__file__).parent.glob("libtendril.so*"))
    yield CHECKOUT / "build/libtendril.so"
    try:
        program = Path(executable()).resolve()
        yield program.parent / "libtendril.so"
        for where in ("lib*", "lib/*"):  # Debian's are in a directory of the architecture
            yield from sorted(program.parents[1].glob(f"{where}/libtendril.so*"))
    except TendrilError:
        pass
    if name := find_library("tendril"):
        yield Path(name)


@lru_cache
def library():
    """libtendril: what the variable TENDRIL_LIBRARY names, else that of this package, of its checkout, of
    the program's place, of the system."""
    named = os.environ.get("TENDRIL_LIBRARY")
    found = named or next((p for p in places() if p.is_file() or p.name == str(p)), None)
    if not found:
        raise TendrilError("no libtendril.so: build it (scripts/run.sh does), or name it in the variable TENDRIL_LIBRARY")
    try:
        lib = ctypes.CDLL(str(found), os.RTLD_LAZY)  # what PETSc is linked with is bound as it is called
    except OSError as fault:
        raise TendrilError(f"{found}: cannot be loaded: {fault}") from None
    for name, arguments in CALLS.items():
        call = getattr(lib, name, None)
        if call is None:
            raise TendrilError(f"{found}: is of another version of tendril: it has no {name}")
        call.argtypes = arguments
        call.restype = {"TendrilMessage": c_char_p, "TendrilVersion": c_char_p, "TendrilSeriesName": c_char_p,
                        "TendrilRodName": c_char_p, "TendrilRodSeriesName": c_char_p, "TendrilDestroy": None}.get(name, c_int)
    return lib


def destroy(pointer):
    with LOCK:
        library().TendrilDestroy(byref(pointer))


class Handle:
    """The library's simulation. Arrays that look into its memory hold it, too; it goes with the last."""

    def __init__(self, comm):
        self.pointer = c_void_p()
        code = library().TendrilCreateFortran(comm, byref(self.pointer))
        self.end = weakref.finalize(self, destroy, self.pointer)
        if code:
            raise RunError(library().TendrilMessage(self.pointer).decode(errors="replace"))


class Series(Mapping):
    """The series of a simulation by their names: a value for each accepted step, and one for the present
    time if that is within a step. Read-only; where it is between steps they look into the library's memory,
    which later steps do not change."""

    def __init__(self, simulation, rod=None):
        self._of = weakref.ref(simulation)
        self._rod = rod  # of several; None: the only one, or all of them

    def _names(self):
        sim, names = self._of(), []
        call, of = ("TendrilSeriesName", ()) if self._rod is None else ("TendrilRodSeriesName", (self._rod,))
        while name := getattr(library(), call)(sim._pointer, *of, len(names)):
            names.append(name.decode())
        return names

    def __contains__(self, name):  # (Mapping would fetch all of it)
        return name in self._names()

    def __getitem__(self, name):
        sim, n, values = self._of(), c_int(), c_void_p()
        call = ("TendrilSeries",) if self._rod is None else ("TendrilRodSeries", self._rod)
        try:
            sim._call(*call, str(name).encode(), byref(n), byref(values))
        except RunError:
            if name in self._names():
                raise
            raise KeyError(f"{name}: no series of this simulation{unknown(name, self._names(), ', which has')}") from None
        if not n.value:
            return np.empty(0)
        block = (c_double * n.value).from_address(values.value)
        block.owner = sim._handle
        array = np.frombuffer(block)
        if sim._copies or sim._within:
            array = array.copy()
        array.flags.writeable = False
        return array

    def __iter__(self):
        return iter(self._names())

    def __len__(self):
        return len(self._names())

    def __repr__(self):
        return f"series of {', '.join(self._names())}"


class Rod:
    """What there is of a rod now; of one of several: sim["left"]."""

    def __init__(self, simulation, number, name):
        self._of, self._number, self.name = weakref.ref(simulation), number, name

    @property
    def _simulation(self):
        sim = self._of()
        if sim is None:
            raise TendrilError("the simulation is closed")
        return sim

    @property
    def nodes(self):
        """All that is known at the nodes, a record array (docs/library.md). It stays as it is when the
        simulation goes on. Of several ranks the first has it; elsewhere it is empty."""
        return self._simulation._nodes_of(self._number)

    @property
    def series(self) -> Series:
        """The series so far, by the names that the result file has for them."""
        return Series(self._simulation, self._number)

    def set(self, option, value):
        """Changes something of this rod from the present time on."""
        self._simulation.set(f"{self.name}_{str(option).lstrip('-')}", value)

    @property
    def space(self) -> bool:
        """Is the rod in space?"""
        return "tip_x3" in self.series

    def _vectors(self, name):
        return self.nodes[name] if self.space else self.nodes[name][:, :2]

    def _about(self, name):
        return self.nodes[name] if self.space else self.nodes[name][:, 2]

    s = property(lambda self: self.nodes["s"], doc="material labels of the nodes, 0 at the clamp, 1 at the tip")
    x = property(lambda self: self._vectors("x"), doc="positions of the nodes")
    v = property(lambda self: self._vectors("v"), doc="velocities of the material at the nodes")
    force = property(lambda self: self._vectors("force"), doc="internal force at the nodes")
    theta = property(lambda self: self.nodes["theta"], doc="angle of the tangent at the nodes")
    curvature = property(lambda self: self._about("curvature"), doc="curvature; in space twist and two bends")
    moment = property(lambda self: self._about("moment"), doc="internal moment at the nodes")

    def __repr__(self):
        return f"rod {self.name} of {self._simulation!r}"


class Simulation(Rod):
    """A run in this process.

    scene      an options file, the name of a scene, a dict of options, or nothing
    rods       of several, and pairs: as for tendril.run(); then sim["left"].x, sim.rods
    options    those of docs/options.md, as for tendril.run(); they win over the scene's
    friction   a law of one's own: of |v|^2, phi and its derivative; the force per length is -phi v
    growth     ... of s and t: g, dg/dt, dg/ds, p, dp/dt, p the integral of g
    curvature  ... of s and t: k0; or k0 and its rate for the material; or six values (tendril.h)
    comm       None: this process alone; a communicator of mpi4py, on all of its ranks: those share it
    load       a result file to go on from

    A wrong option raises RunError with one sentence, as does a run that gives up; what that has found can
    still be read and saved.
    """

    def __init__(self, scene=None, *, rods=None, pairs=None, friction=None, growth=None, curvature=None, comm=None, load=None,
                 **options):
        handle = -1 if comm is None else int(comm) if isinstance(comm, int) else comm.py2f()
        self._copies = comm is not None  # what is collective is not left to when arrays go
        self._handle = self._nodes = self._raised = None
        self._within = False
        with tempfile.TemporaryDirectory(prefix="tendril-") as directory:
            words = rod_words(scene, rods, pairs, directory) + words_of(options, directory)
            self._handle = Handle(handle)
            for name, value in zip(words[::2], words[1::2]):
                self._call("TendrilSet", name.encode(), value.encode())
            self._laws = {kind: self._law(kind, law) for kind, law in
                          {"friction": friction, "growth": growth, "curvature": curvature}.items() if law}
            self._watch = WATCH_TYPE(self._look)
            self._seen = None
            self._call("TendrilSetWatch", self._watch, None)
            self._call(*(("TendrilLoad", os.fsencode(load)) if load else ("TendrilSetUp",)))

    @classmethod
    def load(cls, file, **options):
        """Goes on from a result file, with its options but for those given."""
        return cls(load=file, **options)

    @property
    def _pointer(self):
        if self._handle is None:
            raise TendrilError("the simulation is closed")
        return self._handle.pointer

    def _call(self, name, *arguments):
        """Calls the library; what is wrong is raised. Returns the code of what is not: OK, ENDED or WATCH."""
        with LOCK:
            code = getattr(library(), name)(self._pointer, *arguments)
            good = code in (OK, ENDED, WATCH)
            message = "" if good else library().TendrilMessage(self._pointer).decode(errors="replace")
        raised, self._raised = self._raised, None
        if raised is not None and code in (WATCH, LAW):
            raise raised
        if not good:
            raise RunError(message)
        return code

    def _guarded(self, function, *arguments):
        """What a call from the library returns: an exception is kept for who called that."""
        try:
            return function(*arguments)
        except BaseException as fault:  # KeyboardInterrupt, too: no exception passes through the library
            self._raised = fault
            return 1

    def _law(self, kind, function):
        """A law of one's own, as the library calls it."""
        def fill(at, value):
            at = at.contents
            given = np.ravel(function(at.speed2) if kind == "friction" else function(at.s, at.t)).astype(float)
            if kind == "curvature" and len(given) < 3:
                given = np.array([given[0], 0, 0, given[1] if len(given) > 1 else 0, 0, 0])
            if len(given) != VALUES[kind]:
                raise TendrilError(f"{kind}: a law of one's own gives {VALUES[kind]} values, not {len(given)}")
            for k, one in enumerate(given):
                value[k] = one
            return 0
        law = LAW_TYPE(lambda ctx, at, value: self._guarded(fill, at, value))
        self._call("TendrilSetLaw", kind.encode(), law, None)
        return law

    def _look(self, ctx, pointer):
        """After each step of advance(): so Ctrl-C is heard there, too."""
        def watch():
            self._nodes = None
            return int(bool(self._seen and self._seen(self)))
        return self._guarded(watch)

    @property
    def t(self) -> float:
        """The time."""
        t = c_double()
        self._call("TendrilTime", byref(t))
        return t.value

    def step(self) -> bool:
        """Goes on to the end of the next accepted step; False: the run is at its end."""
        self._nodes, self._within = None, False
        return self._call("TendrilStep", None) == OK

    def advance(self, until=None, watch=None) -> bool:
        """Goes on to a time, or to the end; False: the run has ended before, or watch(sim), which is called
        after every step, has returned something true."""
        self._nodes, self._seen, self._within = None, watch, True  # series are then copied
        try:
            code = self._call("TendrilAdvance", float("inf") if until is None else float(until))
            return code == OK or (until is None and code == ENDED)
        finally:
            self._nodes = self._seen = None

    def set(self, option, value):
        """Changes something from the present time on; docs/library.md lists what. A value of several words is
        text, or a list: sim.set("wall_to", [1, sim.t + 0.5, 0, 0.6])."""
        self._nodes = None
        if str(option).lstrip("-") in BY_WORDS:
            words = value.split() if isinstance(value, str) else [text_of(one) for one in np.atleast_1d(value).tolist()]
            text = " ".join(words)
        else:
            text = text_of(value)
        self._call("TendrilSet", str(option).encode(), text.encode())

    def save(self, file, t=None):
        """Writes a result file: of the run so far, or up to an earlier time at which a shape was stored."""
        name = os.fsencode(file)
        self._call(*(("TendrilSave", name) if t is None else ("TendrilSaveAt", float(t), name)))

    def _nodes_of(self, rod):
        if self._nodes is None:
            self._nodes = {}
        if rod not in self._nodes:
            n, nodes = c_int(), c_void_p()
            self._call("TendrilNodes", rod, byref(n), byref(nodes))
            block = ctypes.string_at(nodes.value, n.value * NODE.itemsize) if n.value else b""
            self._nodes[rod] = np.frombuffer(block, NODE)
        return self._nodes[rod]

    @property
    def rods(self) -> dict[str, Rod]:
        """Those of a scene of several, by their names; of one rod: none."""
        n = c_int()
        self._call("TendrilRods", byref(n))
        names = [library().TendrilRodName(self._pointer, k).decode() for k in range(n.value)]
        return {name: Rod(self, k, name) for k, name in enumerate(names) if name}

    def __getitem__(self, name) -> Rod:
        rods = self.rods
        if name not in rods:
            raise KeyError(f"{name}: no rod of this simulation{unknown(name, rods, ', which has')}")
        return rods[name]

    @property
    def nodes(self):
        """As of a Rod: of the only one."""
        if rods := self.rods:
            raise TendrilError(f"the simulation holds {len(rods)} rods; take one, as sim[{next(iter(rods))!r}].x")
        return self._nodes_of(0)

    @property
    def series(self) -> Series:
        """As of a Rod; of several: sums, or the largest."""
        return Series(self)

    @property
    def _simulation(self):
        return self

    def close(self):
        """Ends it; its memory goes with the last array that looks into it. On several ranks: on all."""
        handle, self._handle = self._handle, None
        if handle and self._copies:
            handle.end()

    def __enter__(self):
        return self

    def __exit__(self, *fault):
        self.close()

    def __repr__(self):
        return "a simulation that is closed" if self._handle is None else f"a simulation at t = {self.t:.6g}"

#!/usr/bin/env python3
# test: the default is right where other methods fail
"""A fast part of the atlas of failure (scripts/lab/atlas.py): the default is right where other methods
fail, and each of these is shown to fail, so that the map stays true.

    atlas_cells.py build/tendril [CHECK...]      (no CHECK: all of them)"""

import sys
import tempfile
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "support"))
from interpreter import ROOT, from_venv

sys.path.insert(0, str(ROOT / "scripts/lab"))
try:
    import measure as m
except ImportError as error:
    from_venv(error)

DECAY8 = m.from_reference("decay", m.DECAY, "v_decay_mu1", (1.5, 8))
FOLD = m.from_reference("fold", m.DECAY, "v_decay_mu1", (15, 20))
SHORT = m.from_reference("short", m.THICK, "v_short")
NARROW = m.Scene("narrow", "-growth_type gaussian -growth_width 0.005 " + m.THICK, (5,),
                 finer="-rod_cells 1000 -ts_rtol 1e-7")
THIN = m.Scene("thin", m.DECAY + " -friction_beta 1e-12", (8, 14, 16),
               finer="-rod_cells 400 -ts_rtol 1e-7")

HAIRPIN = m.Scene("hairpin", "-growth_initial_length 2 -shape_amplitude 3.1", (2, 5),
                  finer="-rod_cells 400 -ts_rtol 1e-8")
STICK = m.Scene("stick", m.THICK + " -growth_type feed -friction_beta 0", (4, 6),
                finer="-rod_cells 400 -ts_rtol 1e-7")

CORNERS = m.Scene("corners", "-growth_type feed -growth_initial_length 0.5 -shape_type straight "
                  f"-rod_curvature 0.1 -wall_file {m.ROOT}/scripts/lab/walls/stone.txt "
                  "-contact_diameter 0.05 -contact_stiffness 3e5 -friction_beta 1e-10", (1.5, 2),
                  finer="-rod_cells 400 -ts_rtol 1e-7")

SPACE = m.Scene("in space", "-growth_initial_length 0.2 -tip_force 1000 -shape_amplitude 0.1 -shape_turn 0.5 -rod_bend_ratio 1.5 "
                "-rod_cells 40", (0.1,), finer="-rod_cells 80 -ts_rtol 1e-7", quantities=m.QUANTITIES + ("norm_x3",))
HELD = m.Scene("held", f"{m.THICK} -tip_type pinned -shape_turn 1 -rod_curvature_2 0.2 -rod_cells 30", (1,),
               finer="-rod_cells 60 -ts_rtol 1e-7", quantities=m.QUANTITIES + ("norm_x3",))
BALL = m.Scene("ball", "-growth_type feed -growth_initial_length 0.5 -shape_type straight -friction_beta 0 -rod_curvature 0.1 "
               "-rod_curvature_2 0.05 -contact_diameter 0.1 -contact_stiffness 1e5 -rod_cells 40 "
               f"-wall_file {m.ROOT}/scripts/lab/walls/ball.txt", (1.5,), finer="-rod_cells 80 -ts_rtol 1e-7",
               quantities=m.QUANTITIES + ("norm_x3",))

HANG = 900  # seconds that no run takes, however slow or busy the machine
# Where a method that makes no headway is stopped: the steps of the default's run, many times over. By the
# clock a slow machine would stop others, too.
STOP = " -ts_max_steps 20000"

CHECKS = {  # name: (scene, [(options, verdicts)]); the first is the default
    "decay": (DECAY8, [("", (m.RIGHT_,)),
                       ("-ts_type beuler -ts_theta_initial_guess_extrapolate -ts_dt 0.01",
                        (m.WRONG,)),
                       ("-rod_model linear", (m.WRONG,))]),
    "fold": (FOLD, [("", (m.RIGHT_,)), ("-rod_model auto", (m.RIGHT_,)),
                    ("-rod_model linear", (m.GAVE_UP,)), ("-rod_cells 20", (m.WRONG,))]),
    "short": (SHORT, [("", (m.RIGHT_,)), ("-rod_model mixed", (m.RIGHT_,)),
                      ("-ts_rtol 1e-2", (m.WRONG,))]),
    "narrow-zone": (NARROW, [("", (m.RIGHT_,)), ("-rod_grading uniform -rod_cells 50",
                                                 (m.WRONG, m.GAVE_UP))]),
    "thin-friction": (THIN, [("", (m.RIGHT_,)), ("-ts_max_reject 3", (m.RIGHT_,)),
                             ("-friction_newton primal -ts_max_reject 3", (m.GAVE_UP,))]),
    "snap": (HAIRPIN, [("", (m.RIGHT_,)), ("-rod_model auto", (m.RIGHT_,)),
                       ("-ts_type bdf -ts_bdf_order 5", (m.RIGHT_,)),
                       ("-friction_newton primal" + STOP, (m.RIGHT_,)),
                       ("-rod_model mixed", (m.RIGHT_,))]),
    "corners": (CORNERS, [("", (m.RIGHT_,)), ("-rod_model mixed", (m.REFUSED,)),
                          ("-friction_newton primal" + STOP, (m.RIGHT_,))]),
    "space": (SPACE, [("", (m.RIGHT_,)), ("-friction_newton primal", (m.RIGHT_,)), ("-ts_type beuler -ts_dt 0.01", (m.WRONG,)),
                      ("-ts_type bdf -ts_bdf_order 5 -ts_max_steps 600", (m.GAVE_UP,)), ("-rod_model mixed", (m.REFUSED,))]),
    "held": (HELD, [("", (m.RIGHT_,)), ("-friction_newton primal", (m.GAVE_UP,)),
                    ("-ts_type bdf -ts_bdf_order 5 -ts_max_steps 600", (m.GAVE_UP,))]),
    "ball": (BALL, [("", (m.RIGHT_,)), ("-rod_model mixed", (m.REFUSED,))]),
    "stick": (STICK, [("", (m.RIGHT_,))]),  # (primal crawls there with most tolerances)
}


def main():
    m.TENDRIL, names = sys.argv[1], sys.argv[2:] or list(CHECKS)
    failures = 0
    with tempfile.TemporaryDirectory() as scratch:
        store = m.Store(Path(scratch) / "store.jsonl")
        for name in names:
            if name not in CHECKS:
                sys.exit(f"atlas_cells: no check {name}; there are {', '.join(CHECKS)}")
            scene, runs = CHECKS[name]
            for options, verdicts in runs:
                run = store.get(m.Case("tendril", scene, options, limit=HANG))
                good = run["verdict"] in verdicts
                failures += not good
                print("ok  " if good else f"FAIL (should be {' or '.join(verdicts)})", m.short(run),
                      run["message"], flush=True)
    return failures > 0


if __name__ == "__main__":
    sys.exit(main())

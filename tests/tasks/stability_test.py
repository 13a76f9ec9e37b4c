#!/usr/bin/env python3
"""-task stability through the executable: its curves, verdicts and optimal shape against theorems.

    stability_test.py build/tendril [CHECK...]      (no CHECK: all of them)"""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "support"))
import scene  # takes .venv's python if this one lacks numpy and h5py
from scene import Run, check, expect

import h5py
import numpy as np

FEW = "-task stability -stability_points 7 -stability_vertices 150 "


def stability(options):
    """/stability by name; said: what was printed."""
    file = f"{scene.SCRATCH}/stability.h5"
    done = scene.subprocess.run([scene.TENDRIL, *options.split(), "-output", file], text=True,
                                capture_output=True, env=scene.ENVIRONMENT)
    expect(done.returncode == 0 and not done.stderr, f"{options}: {done.stderr}")
    with h5py.File(file) as f:
        r = {name: d[()] for name, d in f["stability"].items()}
        if "transient" in f:
            r["L2"] = f["transient/L2/amplification"][()]
    r["said"] = done.stdout
    return r


@check
def norms_shrink_up_to_where_is_known():
    """Up to where a norm shrinks, known in closed form; with viscous friction, uniform growth and
    feed have one norm under two names, so its curve is twice the rate."""
    for law, mu, t_cr, until in (("uniform", 0, 1.671770067494, 1.671770067494),
                                 ("feed", 0, 3.73772, 1.486352707430)):
        r = stability(f"{FEW} -growth_type {law} -friction_mu {mu} -stability_transient 0")
        twice = np.abs(r["lambda_max_A_plus_AT"] - 2 * r["rate_friction_norm"])
        off = (twice / np.maximum(1, np.abs(r["rate_friction_norm"]))).max()
        print(f"{law}: t_cr {r['t_cr']}, norms until {r['rate_friction_norm_until']:.10g} and "
              f"{r['lambda_max_A_plus_AT_until']:.10g}, curves differ by {off:.1e}")
        expect(abs(r["t_cr"] - t_cr) < 2e-5, f"{law}: t_cr {r['t_cr']}")
        for name in ("rate_friction_norm_until", "lambda_max_A_plus_AT_until"):
            expect(abs(r[name] - until) < 1e-6, f"{law}: {name} {r[name]}")
        expect(abs(r["lambda_max_A_until"] - r["t_cr"]) < 1e-6, f"{law}: {r['lambda_max_A_until']}")
        expect(off < 1e-7, f"{law}: A + A^T is not twice the rate, off by {off:.1e}")


@check
def the_optimal_shape_grows_as_the_propagator_says():
    """The optimal shape, stepped in time, grows as the propagator says."""
    for law, length, t2 in (("gaussian -growth_width 0.3", 1.5, 1.5), ("feed", 2, 3)):
        d, options = scene.SCRATCH, f"-growth_type {law} -growth_initial_length {length} "
        r = stability(f"{FEW} {options} -stability_end {t2} -stability_only_modes "
                      f"-shape_amplitude 1e-6 -stability_optimal_shape {d}/best.h5")
        run = Run(f"{options} -shape_type file -shape_file {d}/best.h5 -rod_model linear "
                  f"-ts_max_time {t2} -ts_rtol 1e-8")
        grown = run.norm_x2[-1] / run.norm_x2[0]
        print(f"{law}: grows by {grown:.8g}, the propagator says {r['L2']:.8g}")
        expect(abs(grown / r["L2"] - 1) < 1e-3, f"{law}: grows by {grown}, not {r['L2']}")


@check
def stability_up_to_critical_is_claimed_only_where_it_is_so():
    """That uniform growth is stable exactly up to t_cr is claimed where it is so, and only there."""
    layers = "-friction_layers 0:1,1:2"
    for options, holds in (("", True), ("-tip_force 0.5", True), ("-growth_type gaussian", False),
                           ("-growth_type feed", False), ("-friction_across 2", False),
                           (layers, False), ("-tip_force 0.5 -tip_law follower", False),
                           ("-tip_force 0.5 -tip_law resistance", False)):
        said = stability("-task stability -stability_points 3 -stability_vertices 60 "
                         f"-stability_transient 0 {options}")["said"]
        expect(("A is self-adjoint" in said) == holds, f"{options}: {said}")
        expect(("Best norm" in said) != holds, f"{options}: {said}")


if __name__ == "__main__":
    sys.exit(scene.main())

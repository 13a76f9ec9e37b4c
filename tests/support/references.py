"""The references of tests/reference, what they are runs of, and how near a run comes to them."""

import json

import numpy as np
from scene import DRY, ROOT, Run, distance, expect, file

SAG = "-shape_amplitude 0.1 -growth_initial_length "
SMOOTH = DRY + "-friction_beta 0.05 "                   # no thin friction layers
DECAY = "-growth_initial_length 0.5 -shape_amplitude 0.01 -ts_max_time 40 "
REFERENCES = {  # file: options, -output_interval (a divisor of all its times)
    "v_short": (DRY + "-ts_max_time 5", 1),
    "v_gauss": ("-growth_type gaussian -growth_initial_length 1 -shape_amplitude 0.1 "
                "-ts_max_time 10", 1),
    "v_feed": ("-growth_type feed " + DRY + "-ts_max_time 8", 1),
    "v_decay_mu1": (DECAY, 0.1),
    "v_decay_mu05": (DECAY + "-friction_mu 0.5", 0.1),
    "v_decay_mu0": (DECAY + "-friction_mu 0", 0.1),
}


def against_reference(name, more):
    """(the run, {quantity: its largest relative error up to t = 12, and after})"""
    options, interval = REFERENCES[name]
    r = Run(f"{options} {more} -output_interval {interval}")
    worst = {k: [0, 0] for k in ("norm_x2", "energy", "tip")}
    for line in (ROOT / "tests/reference" / f"{name}.json").read_text().splitlines():
        ref = json.loads(line)
        errors = {k: abs(r.at(k, ref["t"]) / ref[k] - 1) for k in ("norm_x2", "energy")}
        errors["tip"] = distance(r.tip_at(ref["t"])[:2], np.array(ref["tip"]))  # (space has a third)
        for k, e in errors.items():
            late = ref["t"] > 12
            worst[k][late] = max(worst[k][late], e)
    return r, worst


def expect_reference(name, more, defect):
    r, worst = against_reference(name, more)
    for k, (early, late) in worst.items():
        expect(early < 1e-3 and late < 1e-2, f"{name} {more}: {k} off by {early:.1e}, {late:.1e}")
    # the power at t = 0 is not known: the first step leaves a defect that later work outweighs
    late = r.energy_defect[r.t > 0.01].max()
    expect(late < defect and r.energy_defect.max() < 1e-3,
           f"{name} {more}: energy defect {late:.1e}, {r.energy_defect.max():.1e} at first")
    worst = {k: max(e) for k, e in worst.items()}
    largest = max(worst.values())
    # (it is of the whole run, the measured one of its second half and its end)
    expect(largest <= r.estimate <= 120 * largest,
           f"{name} {more}: estimated error {r.estimate:.1e}, measured {largest:.1e}")
    print(f"{name:13} {more:40} {r.steps:5} steps, {r.newton_iterations.sum():5.0f} Newton, largest "
          f"errors: |x2| {worst['norm_x2']:.1e}, energy {worst['energy']:.1e}, "
          f"tip {worst['tip']:.1e}; estimated {r.estimate:.1e}; defect {late:.1e}")


def field(factor, x1=(-3, 20), x2=(-8, 8), t=None, spacing=0.25):
    """The file of factor(x1, x2) or factor(x1, x2, t); t: the end of its times. Its interpolant is
    flat at the edges: a few entries further in, a cubic is exact."""
    x1, x2 = (np.arange(a, b + spacing / 2, spacing) for a, b in (x1, x2))
    if t is None:
        return file("field", x1=x1, x2=x2, factor=factor(x1, x2[:, None]))
    t = np.linspace(-1, t + 1, 9)
    return file("field", x1=x1, x2=x2, t=t,
                factor=factor(x1, x2[:, None], t[:, None, None]))


def bowl(x1, x2):
    return 1 + 0.3 * x1 + 0.2 * x2 ** 2


def stiffness(factor, name="stiffness"):
    d = np.linspace(0, 25, 1001)
    return "-rod_stiffness_file " + file(name, distance=d, factor=factor(d))


def references():
    """File: options, -output_interval (a divisor of all its times)."""
    in_bowl = f"-friction_field {field(bowl)} "
    REFERENCES.update({
        "w_across": (f"{SAG} 1 -friction_across 2 -ts_max_time 6", 2),
        "w_field": (f"-growth_type feed {SAG} 1.5 -friction_mu 0.7 {in_bowl} -ts_max_time 6", 2),
        "w_tip": (f"{SAG} 1 -friction_mu 0.5 -tip_law resistance -tip_force 0.5 -ts_max_time 4", 1),
        "w_apical": ("-growth_type apical -growth_zone 0.6 -growth_initial_length 1 "
                     "-shape_amplitude 0.2 -friction_mu 0.6 -tip_law resistance -tip_force 0.5 "
                     "-ts_max_time 5", 1),
        "w_stiff": ("-growth_type feed -growth_initial_length 2 -shape_amplitude 0.3 "
                    f"-friction_mu 0.8 {stiffness(lambda d: 1 + 3 * np.exp(-d), 'three')} "
                    "-ts_max_time 6", 2),
        "w_all": (f"-growth_type feed {SAG} 1.2 -friction_mu 0.7 -friction_across 2 {in_bowl} "
                  "-tip_law follower -tip_force 0.3 -rod_curvature 0.05 "
                  f"{stiffness(lambda d: 1 + 2 * np.exp(-d), 'two')} -ts_max_time 6", 2)})
    return [name for name in REFERENCES if name.startswith("w_")]


def expect_references(more, bound, defect, names=None):
    """Each reference is met to the bound, and in the frame model the estimate of the error holds."""
    known = references()
    for name in names or known:
        r, worst = against_reference(name, more)
        largest = max(max(e) for e in worst.values())
        late = r.energy_defect[r.t > 0.01].max()
        print(f"{name:9} {more}: {r.steps} steps, {r.newton_iterations.sum():.0f} Newton, "
              f"{', '.join(f'{k} {max(e):.1e}' for k, e in worst.items())}, "
              f"estimated {r.estimate:.1e}; defect {late:.1e}")
        expect(largest < bound, f"{name} {more}: off by {largest:.1e}")
        expect("mixed" in more or largest < r.estimate < 80 * largest,
               f"{name} {more}: estimated error {r.estimate:.1e}, measured {largest:.1e}")
        expect(late < defect, f"{name} {more}: energy defect {late:.1e}")

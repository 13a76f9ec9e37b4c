#!/usr/bin/env python3
"""A root that was turned by 90 degrees and bends back, in PyElastica: rest curvature that its growth changes, by a law that is written
here, for it has none. No friction holds it.

    results/peers/venv/bin/python scripts/lab/peers/pyelastica_root.py -tropism_gravity 2 -growth_initial_length 1 -ts_max_time 1 -elements 40

(scripts/lab/peers/setup.sh makes that venv.) It grows evenly, by 1 per unit of time, senses at its tip and straightens with G = 1:

    Dk/Dt = (f - u)/L,   f = b cos(theta of the tip)      (down is across the clamp)

each step by Euler's explicit method. Takes tendril's options for the scene, and, in units of the rod's last length, its stiffness and its mass,
  -elements N   of the rod              -dt DT       the step
  -slow S       how much longer than 1 the growth takes, so that the rod is near rest        -damping C   per time
  -radius R     of the section
Prints a JSON line with the tip's angle, and one of the cost (loop alone, without numba's compilation). Exit 1: it failed."""

import json
import sys
import time
from math import pi

import elastica as ea
import numpy as np


def arguments(words):
    options = {"elements": "40", "dt": "2e-4", "slow": "20", "damping": "0.5", "radius": "0.02", "tropism_gravity": "2",
               "growth_initial_length": "1", "ts_max_time": "1"}
    for name, value in zip(words[::2], words[1::2]):
        options[name.lstrip("-")] = value
    return {name: float(value) for name, value in options.items()}


SIDE = 1.0  # a positive curvature about the first director, x3, turns the tangent to x2


class Learn(ea.NoForces):
    """Edits rest lengths and rest curvatures at each step; lengths in units of the last one."""

    def __init__(self, o):
        super().__init__()
        self.o, self.now = o, 0.0
        self.last = o["growth_initial_length"] + o["ts_max_time"]

    def apply_forces(self, system, time=0.0):
        o, dt = self.o, time - self.now
        self.now = time
        grown = min(1.0, time / o["slow"]) * o["ts_max_time"]
        length, rate = (o["growth_initial_length"] + grown) / self.last, 0.0
        if time < o["slow"]:
            rate = o["ts_max_time"] / o["slow"] / self.last / length  # strain rate of growth
        along = system.director_collection[2]  # d3 is the tangent
        sensed = -o["tropism_gravity"] * self.last * along[0, -1]  # turns it to -x2
        system.rest_kappa[0] += dt * rate * (SIDE * sensed - system.kappa[0])
        system.rest_lengths[:] = length / len(system.rest_lengths)
        system.rest_voronoi_lengths[:] = length / len(system.rest_lengths)


class Simulation(ea.BaseSystemCollection, ea.Constraints, ea.Forcing, ea.Damping):
    pass


def build(o):
    n, radius = int(o["elements"]), o["radius"]
    start = o["growth_initial_length"] / (o["growth_initial_length"] + o["ts_max_time"])
    rod = ea.CosseratRod.straight_rod(n, np.zeros(3), np.array([1.0, 0, 0]), np.array([0, 0, 1.0]), start, radius, 1 / (pi * radius**2),
                                      youngs_modulus=4 / (pi * radius**4))
    simulation = Simulation()
    simulation.append(rod)
    simulation.constrain(rod).using(ea.OneEndFixedBC, constrained_position_idx=(0,), constrained_director_idx=(0,))
    simulation.add_forcing_to(rod).using(Learn, o)
    simulation.dampen(rod).using(ea.AnalyticalLinearDamper, damping_constant=o["damping"], time_step=o["dt"])
    simulation.finalize()
    return simulation, rod


def run(o, most_steps=None):
    simulation, rod = build(o)
    stepper, dt = ea.PositionVerlet(), o["dt"]
    steps = most_steps or int(np.ceil((o["slow"] + 4) / dt))  # and it comes to rest
    begin = time.perf_counter()
    for k in range(steps):
        stepper.step(simulation, np.float64(k * dt), np.float64(dt))
    along = rod.director_collection[2]
    angle = np.arctan2(along[1], along[0])
    tip = 1.5 * angle[-1] - 0.5 * angle[-2]  # of elements: that of the end
    return {"angle": float(tip)}, {"seconds": time.perf_counter() - begin, "steps": steps}


def main():
    o = arguments(sys.argv[1:])
    run(o, most_steps=3)  # numba compiles
    value, state = run(o)
    print(json.dumps(value))
    good = np.isfinite(value["angle"])
    if not good:
        state["failed"] = "not a number: the step is too long"
        print(f"pyelastica_root: {state['failed']}", file=sys.stderr)
    print(json.dumps(state))
    sys.exit(int(not good))


if __name__ == "__main__":
    np.seterr(all="ignore")
    main()

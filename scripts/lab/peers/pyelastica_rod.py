#!/usr/bin/env python3
"""The growing rod in PyElastica: a Cosserat rod with inertia, stepped explicitly, grown by editing
its rest lengths, held back by friction as an external force.

    results/peers/venv/bin/python scripts/lab/peers/pyelastica_rod.py -growth_initial_length 2 \
        -shape_amplitude 0.1 -ts_max_time 5 -times 1,5 -elements 40

(scripts/lab/peers/setup.sh makes that venv.) Takes tendril's options for the scene (uniform and
gaussian growth, sag, beta > 0) and
  -elements N   of the rod              -mass M    per length of the initial rod; its inertia is the
  -dt DT        the step                           model's error: friction is 1 per length
  -radius R     of the section: it stretches by force R^2 / 4, shears by about as much
Prints a JSON line per time, and one of the cost (loop alone, without numba's compilation).
Exit 3: the scene is not supported; 1: it failed."""

import json
import sys
import time
from math import erf, pi, sqrt

import elastica as ea
import numpy as np


def refuse(message):
    print(f"pyelastica_rod: {message}", file=sys.stderr)
    sys.exit(3)


def arguments(words):
    options = {"growth_type": "uniform", "growth_initial_length": "0.5", "growth_width": "0.5",
               "friction_mu": "1", "friction_beta": "1e-3", "shape_type": "sag",
               "shape_amplitude": "0.01", "ts_max_time": "40", "output_interval": "", "times": "",
               "elements": "40", "mass": "1e-3", "radius": "0.05", "dt": "1.5e-5"}
    for name, value in zip(words[::2], words[1::2]):
        name = name.lstrip("-")
        if name not in options:
            refuse(f"-{name}: not supported")
        options[name] = value
    return options


class Growth:
    """Lengths of the elements at time t: the arc length between labels, exact."""

    def __init__(self, options, elements):
        self.type, self.L0 = options["growth_type"], float(options["growth_initial_length"])
        self.width = float(options["growth_width"])
        self.labels = np.linspace(0, 1, elements + 1)
        zone = [erf(s / self.width) for s in self.labels]
        rates = self.labels if self.type == "uniform" else np.array(zone) / zone[-1]
        self.start, self.rate = self.L0 * np.diff(self.labels), np.diff(rates)

    def lengths(self, t):
        return self.start + self.rate * t


class GrowAndRub(ea.NoForces):
    """Edits the rest lengths and applies friction, phi(|v|) v per length, at each step."""

    def __init__(self, growth, mu, beta):
        super().__init__()
        self.growth, self.mu, self.beta = growth, mu, beta

    def apply_forces(self, system, time=0.0):
        lengths = self.growth.lengths(time)
        system.rest_lengths[:] = lengths
        system.rest_voronoi_lengths[:] = (lengths[1:] + lengths[:-1]) / 2
        share = np.zeros(len(lengths) + 1)
        share[1:] += lengths / 2
        share[:-1] += lengths / 2
        v = system.velocity_collection
        phi = (1 - self.mu) + self.mu / np.sqrt(v[0] ** 2 + v[1] ** 2 + self.beta)
        system.external_forces -= share * phi * v


class Simulation(ea.BaseSystemCollection, ea.Constraints, ea.Forcing):
    pass


def sag(growth, amplitude):
    """Angles of the elements (mean over each) and positions of the nodes."""
    s = growth.labels
    integral = amplitude * (s + (1 - s) ** 4 / 4)
    theta = np.diff(integral) / np.diff(s)
    x = np.zeros((3, len(s)))
    x[0, 1:] = np.cumsum(growth.start * np.cos(theta))
    x[1, 1:] = np.cumsum(growth.start * np.sin(theta))
    return theta, x


def build(options):
    if options["growth_type"] not in ("uniform", "gaussian") or options["shape_type"] != "sag":
        refuse("uniform or gaussian growth of a sag only")
    mu, beta = float(options["friction_mu"]), float(options["friction_beta"])
    if beta <= 0:
        refuse("-friction_beta: needs a value above 0")
    elements, radius = int(options["elements"]), float(options["radius"])
    growth = Growth(options, elements)
    # bending stiffness E pi r^4 / 4 = 1
    rod = ea.CosseratRod.straight_rod(
        elements, np.zeros(3), np.array([1.0, 0, 0]), np.array([0, 0, 1.0]), growth.L0, radius,
        float(options["mass"]) / (pi * radius ** 2), youngs_modulus=4 / (pi * radius ** 4))
    theta, x = sag(growth, float(options["shape_amplitude"]))
    rod.position_collection[:] = x
    rod.director_collection[0], rod.director_collection[1], rod.director_collection[2] = (
        np.array([0 * theta, 0 * theta, 1 + 0 * theta]),
        np.array([-np.sin(theta), np.cos(theta), 0 * theta]),
        np.array([np.cos(theta), np.sin(theta), 0 * theta]))
    simulation = Simulation()
    simulation.append(rod)
    simulation.constrain(rod).using(ea.OneEndFixedBC, constrained_position_idx=(0,),
                                    constrained_director_idx=(0,))
    simulation.add_forcing_to(rod).using(GrowAndRub, growth, mu, beta)
    simulation.finalize()
    return simulation, rod, growth


def observe(rod, growth, t):
    lengths = growth.lengths(t)
    x = rod.position_collection
    cells, y = np.diff(growth.labels), x[1]
    norm = sqrt(np.sum(cells * (y[1:] ** 2 + y[1:] * y[:-1] + y[:-1] ** 2) / 3))
    middle = (lengths[1:] + lengths[:-1]) / 2
    return {"t": t, "tip": [x[0, -1], x[1, -1]], "norm_x2": norm,
            "energy": float(np.sum(rod.kappa[0] ** 2 * middle) / 2)}


def run(options, most_steps=None):
    simulation, rod, growth = build(options)
    stepper = ea.PositionVerlet()
    times = [float(t) for t in options["times"].split(",") if t]
    begin, t, steps, values = time.perf_counter(), 0.0, 0, []
    for end in times:
        n = max(1, int(np.ceil((end - t) / float(options["dt"]))))
        dt, first = (end - t) / n, t
        for k in range(n):
            stepper.step(simulation, np.float64(first + k * dt), np.float64(dt))
            steps += 1
            if most_steps and steps >= most_steps:
                return None
            if k % 1000 == 0 and not np.isfinite(rod.position_collection[0, -1]):
                break
        t = end
        values.append(observe(rod, growth, t))
        print(json.dumps(values[-1]), flush=True)
    good = all(np.isfinite(v["energy"]) for v in values)
    state = {"seconds": time.perf_counter() - begin, "steps": steps,
             "work": steps * (int(options["elements"]) * 6 + 3)}
    return state if good else dict(state, failed="not a number: the step is too long")


def main():
    options = arguments(sys.argv[1:])
    run(options, most_steps=3)  # numba compiles
    state = run(options)
    print(json.dumps(state))
    if "failed" in state:
        print(f"pyelastica_rod: {state['failed']}", file=sys.stderr)
    sys.exit("failed" in state)


if __name__ == "__main__":
    np.seterr(all="ignore")
    main()

#!/usr/bin/env python3
"""A clamped rod that is pushed against a frictionless plane, in PyElastica: its contact of a rod with a
plane, a spring and a damper at the middles of the elements.

    results/peers/venv/bin/python scripts/lab/peers/pyelastica_contact.py -wall_file WALL.txt \\
        -growth_initial_length 0.0068 -ts_max_time 0.0032 -times 0.0032 -elements 40

(scripts/lab/peers/setup.sh makes that venv.) The wall file has one plane across x1. Where friction along
the rod is nothing, the answer depends on the length alone: so the rod grows evenly, in the first half
of the run, and rests in the second. Takes tendril's options for the scene, most of which it has no use
for, and, in units of the rod's last length L, its stiffness B and its mass per length m,
  -elements N   of the rod              -time T      of the whole run, in L^2 sqrt(m/B)
  -dt DT        the step                -damping C   per time
  -radius R     of the section: it stretches by force R^2 / 4
  -stiffness K  of the spring
Prints a JSON line with force and height, and one of the cost (loop alone, without numba's
compilation). Exit 3: the scene is not supported; 1: it failed."""

import json
import sys
import time
from math import pi

import elastica as ea
import numpy as np


def refuse(message):
    print(f"pyelastica_contact: {message}", file=sys.stderr)
    sys.exit(3)


def arguments(words):
    options = {"elements": "40", "time": "40", "dt": "1e-4", "damping": "8", "radius": "0.02",
               "stiffness": "1e4"}
    for name, value in zip(words[::2], words[1::2]):
        options[name.lstrip("-")] = value
    return options


def plane(file):
    """How far away the plane of a wall file is."""
    with open(file) as text:
        words = [word for line in text for word in line.split("#")[0].split()]
    if len(words) != 5 or words[0] != "plane" or float(words[3]) >= 0 or float(words[4]):
        refuse(f"{file}: one plane across x1 only")
    return float(words[1])


class Grow(ea.NoForces):
    """Edits the rest lengths at each step: from L0 to 1 in the first half of the run."""

    def __init__(self, start, end):
        super().__init__()
        self.start, self.end = start, end

    def apply_forces(self, system, time=0.0):
        length = self.start + (1 - self.start) * min(1, 2 * time / self.end)
        system.rest_lengths[:] = length / len(system.rest_lengths)
        system.rest_voronoi_lengths[:] = length / len(system.rest_lengths)


class Simulation(ea.BaseSystemCollection, ea.Constraints, ea.Forcing, ea.Damping, ea.Contact):
    pass


def build(o, scale):
    n, radius = int(o["elements"]), float(o["radius"])
    start = float(o["growth_initial_length"]) * scale
    tilt = 0.02 * np.linspace(0, 1, n + 1)  # so that it knows which way to go
    rod = ea.CosseratRod.straight_rod(
        n, np.zeros(3), np.array([1.0, 0, 0]), np.array([0, 0, 1.0]), start, radius,
        1 / (pi * radius ** 2), youngs_modulus=4 / (pi * radius ** 4))
    theta = (tilt[1:] + tilt[:-1]) / 2
    rod.position_collection[0, 1:] = np.cumsum(np.cos(theta)) * start / n
    rod.position_collection[1, 1:] = np.cumsum(np.sin(theta)) * start / n
    zero = 0 * theta
    rod.director_collection[0] = np.array([zero, zero, zero + 1])
    rod.director_collection[1] = np.array([-np.sin(theta), np.cos(theta), zero])
    rod.director_collection[2] = np.array([np.cos(theta), np.sin(theta), zero])
    # its surface touches the plane: so that the centre line touches where it should
    wall = ea.Plane(np.array([plane(o["wall_file"]) * scale + radius, 0, 0]),
                    np.array([-1.0, 0, 0]))
    simulation = Simulation()
    simulation.append(rod)
    simulation.append(wall)
    simulation.constrain(rod).using(ea.OneEndFixedBC, constrained_position_idx=(0,),
                                    constrained_director_idx=(0,))
    simulation.add_forcing_to(rod).using(Grow, start, float(o["time"]))
    simulation.detect_contact_between(rod, wall).using(ea.RodPlaneContact,
                                                       k=float(o["stiffness"]), nu=1.0)
    simulation.dampen(rod).using(ea.AnalyticalLinearDamper, damping_constant=float(o["damping"]),
                                 time_step=float(o["dt"]))
    simulation.finalize()
    return simulation, rod


def run(o, scale, most_steps=None):
    simulation, rod = build(o, scale)
    stepper, dt = ea.PositionVerlet(), float(o["dt"])
    steps = most_steps or int(np.ceil(float(o["time"]) / dt))
    begin, forces = time.perf_counter(), []
    for k in range(steps):
        stepper.step(simulation, np.float64(k * dt), np.float64(dt))
        if k > 0.9 * steps and k % 10 == 0 or k == steps - 1:  # contact chatters: a mean
            # at rest the force along x1 is the same all along
            forces.append(np.einsum("jk,jk->k", rod.director_collection[:, 0], rod.internal_stress))
    force = np.array(forces)
    value = {"t": float(o["ts_max_time"]), "tip": (rod.position_collection[:2, -1] / scale).tolist(),
             "base_force_1": -float(np.mean(force)) * scale ** 2,
             "tip_x2": abs(float(rod.position_collection[1, -1])) / scale}
    return value, {"seconds": time.perf_counter() - begin, "steps": steps,
                   "work": steps * (int(o["elements"]) * 6 + 3)}


def main():
    o = arguments(sys.argv[1:])
    scale = 1 / (float(o["growth_initial_length"]) + float(o["ts_max_time"]))
    run(o, scale, most_steps=3)  # numba compiles
    value, state = run(o, scale)
    print(json.dumps(value))
    good = np.isfinite(value["base_force_1"]) and np.isfinite(value["tip_x2"])
    if not good:
        state["failed"] = "not a number: the step is too long"
        print(f"pyelastica_contact: {state['failed']}", file=sys.stderr)
    print(json.dumps(state))
    sys.exit(int(not good))


if __name__ == "__main__":
    np.seterr(all="ignore")
    main()

#!/usr/bin/env python3
"""PyElastica on the scenes in space of scripts/lab/chart_space.py.

    results/peers/venv/bin/python scripts/lab/peers/pyelastica_space.py SCENE -elements 20 [-dt DT] [-time T] ...

(scripts/lab/peers/setup.sh makes that venv.) Scenes: bend (45 degrees, Bathe), twisted (27 turns), capstan, helix (the
same, askew), laid (a heavy rod on a plane). Units are those of the scene in tendril: stiffness B = 1, mass per length 1; the twisted rod has
those of PyElastica's own example. The scenes are at rest or slide evenly, so mass, damping and the section's
radius are chosen for PyElastica's sake: as slow as the step allows. Prints a JSON line of what was found, and one of
the cost: processor seconds of the loop alone, without numba's compilation. Exit 1: it failed."""

import time
from math import pi

import elastica as ea
import numpy as np

from scenes import run


class Simulation(ea.BaseSystemCollection, ea.Constraints, ea.Forcing, ea.Damping, ea.Contact):
    pass


class Led(ea.ConstraintBase):
    """The first node and element, led at a velocity."""

    def __init__(self, *fixed, velocity=(0.0, 0.0, 0.0), **more):
        super().__init__(**more)
        self.place, self.frame = np.array(fixed[0]), np.array(fixed[1])
        self.velocity = np.array(velocity)

    def constrain_values(self, system, time):
        system.position_collection[..., 0] = self.place + self.velocity * time
        system.director_collection[..., 0] = self.frame

    def constrain_rates(self, system, time):
        system.velocity_collection[..., 0] = self.velocity
        system.omega_collection[..., 0] = 0


def carried(tangents):
    """Normals that turn about no tangent: of a rod in a plane across x3, x3."""
    normal = np.zeros_like(tangents)
    last = np.array([0, 0, 1.0])
    for i, tangent in enumerate(tangents.T):
        last = last - tangent * (tangent @ last)
        last /= np.linalg.norm(last)
        normal[:, i] = last
    return normal


def rod(nodes, radius, shear, bend=(1, 1, 1), straight=True):
    """A rod of mass 1 per length through the nodes, of these stiffnesses; straight: without natural bends."""
    edges = np.diff(nodes)
    lengths = np.linalg.norm(edges, axis=0)
    tangents, n = edges / lengths, len(lengths)
    normal = carried(tangents)
    made = ea.CosseratRod.straight_rod(
        n, nodes[:, 0], tangents[:, 0], normal[:, 0], lengths.sum(), radius, 1 / (pi * radius**2),
        youngs_modulus=1.0, shear_modulus=1.0, position=nodes,
        directors=np.stack([normal, np.cross(tangents, normal, axis=0), tangents]))
    made.shear_matrix[:] = np.diag(shear)[:, :, None]
    made.bend_matrix[:] = np.diag(bend)[:, :, None]
    if straight:
        made.rest_kappa[:] = 0
    else:
        from elastica.rod.cosserat_rod import _compute_bending_twist_strains
        _compute_bending_twist_strains(made.director_collection, made.rest_voronoi_lengths, made.kappa)
        made.rest_kappa[:] = made.kappa
    return made


def go(simulation, o, watch=None):
    """Steps to the end; the first ones, in which numba compiles, are not counted. watch is called ever so often in the
    last quarter. Processor seconds, steps."""
    simulation.finalize()
    stepper, t, dt = ea.PositionVerlet(), np.float64(0), np.float64(o["dt"])
    for _ in range(5):
        t = stepper.step(simulation, t, dt)
    begin, steps = time.process_time(), int(o["time"] / dt)
    for i in range(5, steps):
        t = stepper.step(simulation, t, dt)
        if watch and i > 0.75 * steps and i % 20 == 0:
            watch()
    return {"seconds": time.process_time() - begin, "steps": steps}


def damped(simulation, system, o):
    simulation.dampen(system).using(ea.AnalyticalLinearDamper, damping_constant=o["damping"], time_step=o["dt"])


def bend(o):
    """An arc of 45 degrees and radius 1, pulled out of its plane by 7.2. It stretches and shears as Bathe's does:
    stiffnesses are 12e4 and 6e4 times that of bending."""
    n, angle = o["elements"], pi / 4
    s = np.linspace(0, angle, n + 1)
    system = rod(np.stack([np.sin(s), 1 - np.cos(s), 0 * s]), 0.1 / np.sqrt(pi), (6e4, 6e4, 12e4), straight=False)
    simulation = Simulation()
    simulation.append(system)
    simulation.constrain(system).using(ea.OneEndFixedBC, constrained_position_idx=(0,), constrained_director_idx=(0,))
    simulation.add_forcing_to(system).using(ea.EndpointForces, np.zeros(3), np.array([0, 0, 7.2]), ramp_up_time=1.0)
    damped(simulation, system, o)
    cost = go(simulation, o)
    return {"tip": system.position_collection[:, -1].tolist(),
            "speed": float(np.abs(system.velocity_collection).max())}, cost


def twisted(o):
    """PyElastica's own example, HelicalBucklingCase, with its numbers: -time 2100 is to rest."""
    n, length, radius = o["elements"], 100.0, 0.35
    area = pi * radius**2
    system = ea.CosseratRod.straight_rod(n, np.zeros(3), np.array([0, 0, 1.0]), np.array([0, 1.0, 0]), length, radius,
                                         1 / area, youngs_modulus=1e6, shear_modulus=1e5)
    system.shear_matrix[:] = (1e5 * np.identity(3))[:, :, None]
    system.bend_matrix[:] = np.diag([1.345, 1.345, 0.789])[:, :, None]
    simulation = Simulation()
    simulation.append(system)
    simulation.constrain(system).using(
        ea.HelicalBucklingBC, constrained_position_idx=(0, -1), constrained_director_idx=(0, -1), twisting_time=500,
        slack=3, number_of_rotations=27)
    damped(simulation, system, o)
    system.velocity_collection[1, n // 2] += 1e-6
    cost = go(simulation, o)
    edges = np.diff(system.position_collection)
    angle = np.degrees(np.arccos(edges[2] / np.linalg.norm(edges, axis=0)))
    return {"angle": float(angle.max()), "speed": float(np.abs(system.velocity_collection).max())}, cost


def round_a_pillar(n, lead, turns, rise=0.0):
    """Nodes along a line, round a pillar about x3, on which they wind at 1 from its axis and rise so much a radian, and
    off it; and the directions in which they come and leave."""
    along = np.hypot(1, rise)
    wound = 2 * pi * turns * along
    s = np.linspace(0, 2 * lead + wound, n + 1)
    phi = np.clip(s - lead, 0, wound) / along
    before, rest = np.minimum(s - lead, 0) / along, np.clip(s - lead - wound, 0, None) / along
    x = np.stack([before + np.sin(phi) + rest * np.cos(phi), 1 - np.cos(phi) + rest * np.sin(phi),
                  rise * (before + phi + rest)])
    end = 2 * pi * turns
    return x, np.array([1, 0, rise]) / along, np.array([np.cos(end), np.sin(end), rise]) / along


def slide_round(o, turns, rise=0.0, pull=60.0, stretch=1e4):
    """A rope, wound round a pillar, is pulled and let out at a speed: tensions over the angle."""
    n, lead, radius, speed = o["elements"], 2.0, 0.05, o["speed"]
    nodes, begins, ends = round_a_pillar(n, lead, turns, rise)
    system = rod(nodes, radius, (stretch,) * 3)
    high = 2 * pi * turns * rise
    pillar = ea.Cylinder(np.array([0, 1.0, -1.0 - lead * rise]), np.array([0, 0, 1.0]), np.array([1.0, 0, 0]),
                         2.0 + high + 2 * lead * rise, 1 - radius, 1.0)
    simulation = Simulation()
    simulation.append(system)
    simulation.append(pillar)
    simulation.constrain(pillar).using(ea.OneEndFixedBC, constrained_position_idx=(0,), constrained_director_idx=(0,))
    simulation.constrain(system).using(Led, constrained_position_idx=(0,), constrained_director_idx=(0,),
                                       velocity=speed * begins)
    simulation.add_forcing_to(system).using(ea.EndpointForces, np.zeros(3), pull * ends, ramp_up_time=0.01)
    simulation.detect_contact_between(system, pillar).using(
        ea.RodCylinderContact, k=o["stiffness"], nu=o["contact_damping"], velocity_damping_coefficient=o["viscous"],
        friction_coefficient=0.3)
    damped(simulation, system, o)
    seen = []

    def watch():  # contact chatters: tensions are means over time
        x = system.position_collection
        middle, edges = (x[:, 1:] + x[:, :-1]) / 2, np.diff(x)
        force = np.einsum("jik,jk->ik", system.director_collection, system.internal_stress)
        seen.append((np.unwrap(np.arctan2(middle[0], 1 - middle[1])),
                     np.einsum("ik,ik->k", force, edges) / np.linalg.norm(edges, axis=0)))

    cost = go(simulation, o, watch)
    phi, tension = np.mean(seen, axis=0)
    return {"phi": phi.tolist(), "tension": tension.tolist(), "drag": o["damping"] * speed,
            "speed": float(np.abs(system.velocity_collection).max())}, cost


def capstan(o):
    """A turn and a half, level."""
    return slide_round(o, 1.5)


def helix(o):
    """Two turns and some, at 60 degrees to the axis; a pull of 300 leaves 5 where it begins."""
    return slide_round(o, 2.5, 1 / np.sqrt(3), 300.0, 5e4)


def laid(o):
    """A heavy rod, clamped level 0.1 above a frictionless plane, lies down on it."""
    n, radius, weight, high = o["elements"], 0.1, 100.0, 0.1
    s = np.linspace(0, 1, n + 1)
    system = rod(np.stack([s, 0 * s, 0 * s]), radius, (3e4,) * 3)
    plane = ea.Plane(np.array([0, 0, -high - radius]), np.array([0, 0, 1.0]))
    simulation = Simulation()
    simulation.append(system)
    simulation.append(plane)
    simulation.constrain(system).using(ea.OneEndFixedBC, constrained_position_idx=(0,), constrained_director_idx=(0,))
    simulation.add_forcing_to(system).using(ea.GravityForces, acc_gravity=np.array([0, 0, -weight]))
    simulation.detect_contact_between(system, plane).using(ea.RodPlaneContact, k=o["stiffness"], nu=o["contact_damping"])
    damped(simulation, system, o)
    cost = go(simulation, o)
    return {"s": s.tolist(), "x": system.position_collection[[0, 2]].T.tolist(),
            "speed": float(np.abs(system.velocity_collection).max())}, cost


SCENES = {"bend": (bend, {"elements": 20, "time": 8, "damping": 3}),
          "twisted": (twisted, {"elements": 100, "time": 2100, "damping": 0.01}),
          "capstan": (capstan, {"elements": 100, "time": 8, "dt": 2e-4, "damping": 0.5, "speed": 0.1, "stiffness": 1e5,
                                "contact_damping": 100, "viscous": 1e4}),
          "helix": (helix, {"elements": 100, "time": 8, "dt": 2e-4, "damping": 0.5, "speed": 0.1, "stiffness": 1e5,
                            "contact_damping": 100, "viscous": 1e4}),
          "laid": (laid, {"elements": 40, "time": 2, "damping": 10, "stiffness": 1e5, "contact_damping": 10})}


def step(scene, o):
    """What is stable, by the scene's fastest wave."""
    return {"bend": 0.4 * pi / 4 / o["elements"] / np.sqrt(12e4), "twisted": 1e-3,
            "laid": min(1e-4, 4e-3 / o["elements"])}[scene]


if __name__ == "__main__":
    np.seterr(all="ignore")
    run(SCENES, step)

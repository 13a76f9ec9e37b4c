#!/usr/bin/env python3
"""MuJoCo's cable on the scenes in space of scripts/lab/chart_space.py.

    results/peers/venv/bin/python scripts/lab/peers/mujoco_space.py SCENE -elements 16 [-dt DT] [-time T] ...

(scripts/lab/peers/setup.sh makes that venv.) Scenes: bend (45 degrees, Bathe), laid (a heavy rod on a plane);
units are those of the scene in tendril, mass 1 per length. The cable is a chain of rigid capsules with ball
joints, clamped in the middle of its first, so that half of an element lies before the clamp. Prints a JSON line of what was
found, and one of the cost: processor seconds of the loop. Exit 1: it failed."""

import time
from math import pi

import mujoco
import numpy as np

from scenes import run


def numbers(values):
    return " ".join(f"{v:.12g}" for v in np.ravel(values))


def model(nodes, radius, o, world="", geom=""):
    """A cable along the nodes, bent so by nature, of stiffnesses 1."""
    second = pi * radius**4 / 4
    h = np.linalg.norm(nodes[1] - nodes[0])
    return mujoco.MjModel.from_xml_string(f"""<mujoco>
<extension><plugin plugin="mujoco.elasticity.cable"/></extension>
<option gravity="0 0 0" timestep="{o['dt']}" integrator="implicitfast" cone="elliptic" impratio="10"/>
<size memory="64M"/>
<worldbody>{world}<composite prefix="c" type="cable" initial="none" vertex="{numbers(nodes)}">
<plugin plugin="mujoco.elasticity.cable"><config key="twist" value="{1 / (2 * second)}"/>
<config key="bend" value="{1 / second}"/><config key="flat" value="false"/></plugin>
<joint kind="main" damping="{o['damping']}"/><geom type="capsule" size="{radius}" mass="{h}" {geom}/></composite>
</worldbody></mujoco>""")


def go(made, o, each=None):
    """Steps to the end, each(data) before a step."""
    data, steps = mujoco.MjData(made), int(o["time"] / o["dt"])
    mujoco.mj_forward(made, data)
    begin = time.process_time()
    for i in range(steps):
        if each:
            each(data)
        mujoco.mj_step(made, data)
        if data.warning[mujoco.mjtWarning.mjWARN_BADQACC].number:
            return data, {"seconds": time.process_time() - begin, "steps": i, "failed": "acceleration not a number"}
    return data, {"seconds": time.process_time() - begin, "steps": steps}


def end_of(made, data, h):
    body = made.nbody - 1
    return body, data.xpos[body] + data.xmat[body].reshape(3, 3) @ np.array([h, 0, 0])


def pull(made, data, h, force):
    """A dead force on the cable's end."""
    body, end = end_of(made, data, h)
    data.xfrc_applied[body, :3] = force
    data.xfrc_applied[body, 3:] = np.cross(end - data.xipos[body], force)


def bend(o):
    """An arc of 45 degrees and radius 1, pulled out of its plane by 7.2."""
    n = o["elements"]
    h = pi / 4 / (n - 0.5)
    angles = np.arange(n) * h
    nodes = np.vstack([[-h / 2, 0, 0],
                       [-h / 2, 0, 0] + np.cumsum(h * np.stack([np.cos(angles), np.sin(angles), 0 * angles], 1), axis=0)])
    made = model(nodes, 0.02, o)
    data, cost = go(made, o, lambda data: pull(made, data, h, np.array([0, 0, 7.2 * min(1, data.time / 2)])))
    return {"tip": end_of(made, data, h)[1].tolist(), "speed": float(np.abs(data.qvel).max())}, cost


def laid(o):
    """A heavy rod, clamped level 0.1 above a frictionless plane, lies down on it."""
    n, radius, high = o["elements"], 0.01, 0.1
    h = 1 / (n - 0.5)
    nodes = np.stack([-h / 2 + h * np.arange(n + 1), np.zeros(n + 1), np.zeros(n + 1)], 1)
    contact = f'friction="0 0 0" solref="{4 * o["dt"]} 1" solimp="0.99 0.999 0.0005"'
    made = model(nodes, radius, o, geom=f'contype="1" conaffinity="2" {contact}',
                 world=f'<geom type="plane" size="5 5 1" pos="0 0 {-high - radius}" contype="2" conaffinity="1" {contact}/>')
    made.opt.gravity[2] = -100
    data, cost = go(made, o)
    place = np.vstack([data.xpos[made.nbody - n:], end_of(made, data, h)[1]])
    return {"s": (-h / 2 + h * np.arange(n + 1)).tolist(), "x": place[:, [0, 2]].tolist(),
            "speed": float(np.abs(data.qvel).max())}, cost


SCENES = {"bend": (bend, {"elements": 16, "dt": 2e-3, "time": 8, "damping": 3.4}),
          "laid": (laid, {"elements": 16, "dt": 1e-3, "time": 3, "damping": 1.0})}


if __name__ == "__main__":
    run(SCENES)

"""Makes the data files of scenes, options/data/*.h5 and docs/ropes. They are kept with the scenes; this tells what
is in them, and makes them anew.

    PYTHONPATH=scripts .venv/bin/python -m tendril.scene_data"""

from pathlib import Path

import h5py
import numpy as np
from scipy.interpolate import CubicSpline


def write(path, **datasets):
    with h5py.File(path, "w") as f:
        for name, values in datasets.items():
            f[name] = np.asarray(values, float)


def rise(z):
    """From 0 at z = 0 to 1 at z = 1, with two derivatives."""
    z = np.clip(z, 0, 1)
    return z**3 * (10 - 15 * z + 6 * z * z)


def rope(data, turns=2.5, lead=1.5, rise_angle=0.15, radius=1, room=0.005, diameter=0.1, pull=200):
    """A rope laid round a pillar in a helix, and the pillar; returns what pulls it on."""
    along, up = np.cos(rise_angle), np.sin(rise_angle)
    length, arc = 2 * lead, 2 * np.pi * turns * radius / along
    length += arc
    s = np.linspace(0, 1, 1001)
    on = (np.tanh((s * length - lead) / 0.05) - np.tanh((s * length - lead - arc) / 0.05)) / 2
    bend, turned = on * along**2 / radius, up * along / radius * np.clip(s * length - lead, 0, arc)
    write(data / "capstan.h5", s=s, u2=-bend * np.sin(turned), u3=bend * np.cos(turned))
    axis, towards = np.array([up, 0, along]), np.array([1, 0, 0]) - up * np.array([up, 0, along])
    angle = 2 * np.pi * turns
    end = up * axis + np.cos(angle) * towards + np.sin(angle) * np.cross(axis, towards)
    pillar = [lead, radius, 0, *axis, radius - diameter / 2 - room]
    (data / "pillar.txt").write_text("# the pillar of capstan.opts\n"
                                     f"cylinder {' '.join(f'{v:.12g}' for v in pillar)} outside friction 0.3\n")
    return length, pull * end


def twisted_loop(data, length=4.5, torque=5.639, pull=49.68, slack=2.3, time=10):
    """A loop in a long rod under pull and torque (Coyne), and the way that its end is led: slack, while the clamp's
    turns wind it up."""
    part = np.sqrt(1 - torque**2 / (4 * pull))  # of the bend that there is without torque
    s = np.linspace(-length / 2, length / 2, 4001)
    cosine = 1 - 2 * part**2 / np.cosh(s * np.sqrt(pull) * part)**2
    rate = torque / (1 + cosine)
    turned = np.append(0, np.cumsum((rate[1:] + rate[:-1]) / 2 * np.diff(s)))
    turned -= turned[len(s) // 2]
    sine = np.sqrt(1 - cosine**2)
    q = np.stack([cosine, sine * np.cos(turned), sine * np.sin(turned)], axis=1)
    slope = np.gradient(q, s, axis=0, edge_order=2)
    d2, twist = carried(q), torque / 0.75
    bend = np.stack([(slope * d2).sum(1), (slope * np.cross(q, d2)).sum(1)])
    c, z = np.cos(twist * (s - s[0])), np.sin(twist * (s - s[0]))
    every = slice(None, None, 8)
    write(data / "plectoneme.h5", s=((s - s[0]) / length)[every], u1=np.full(len(s[every]), twist),
          u2=(bend[0] * z - bend[1] * c)[every], u3=(bend[0] * c + bend[1] * z)[every])
    x = ((q[1:, 0] + q[:-1, 0]) / 2 * np.diff(s)).sum()
    t = np.linspace(0, 1, 11)
    np.savetxt(data / "plectoneme.csv", np.c_[time * t, x - slack * t * t * (3 - 2 * t)], delimiter=",", fmt="%.8f",
               header="t,x1", comments="")


def meeting(x, radius, diameter, longer):
    """Of two strands that meet along x, a tail and the beginning of a loop: the first, which is the tail at x < 0.
    They wind round each other by three half turns. The other is its mirror image, x -> -x and x3 -> -x3."""
    along = longer * np.sqrt(2 * radius * diameter)
    circle = lambda x: radius - np.sqrt(radius**2 - np.clip(x, 0, radius)**2)
    up, other = circle(x), circle(-x)
    apart = np.hypot((up - other) / 2, 0.65 * diameter * np.clip(1 - (x / (1.5 * along))**2, 0, 1)**2)
    turned = np.pi + 3 * np.pi * rise((x / along + 1) / 2)
    return np.stack([x, (up + other) / 2 + apart * np.cos(turned), apart * np.sin(turned)], axis=-1)


def overhand(path, radius=0.5, diameter=0.02, tail=4, longer=2.2):
    """An overhand knot in a rod that is straight by nature, loose: two tails along x1, and between them a loop.
    Returns the rod's length, and how far its ends are apart."""
    edge = min(1.6 * longer * np.sqrt(2 * radius * diameter), 0.95 * radius)
    strand = meeting(np.linspace(-tail, edge, 2000), radius, diameter, longer)
    round_ = np.linspace(np.arcsin(edge / radius), 2 * np.pi - np.arcsin(edge / radius), 1000)[1:-1]
    loop = radius * np.stack([np.sin(round_), 1 - np.cos(round_), 0 * round_], axis=-1)
    line = np.concatenate([strand, loop, (strand * [-1, 1, -1])[::-1]])
    for _ in range(4):  # to points evenly spaced, between which it is smooth
        s = np.append(0, np.cumsum(np.linalg.norm(np.diff(line, axis=0), axis=1)))
        line = CubicSpline(s, line)(np.linspace(0, s[-1], 1200))
    s = np.append(0, np.cumsum(np.linalg.norm(np.diff(line, axis=0), axis=1)))
    curve, s = CubicSpline(s, line), np.linspace(0, s[-1], 2401)
    q = curve(s, 1) / np.linalg.norm(curve(s, 1), axis=1)[:, None]
    d2, slope = carried(q), np.gradient(q, s, axis=0, edge_order=2)
    u2, u3, every = -(slope * np.cross(q, d2)).sum(1), (slope * d2).sum(1), slice(None, None, 2)
    write(path, s=(s / s[-1])[every], u2=u2[every], u3=u3[every])
    return s[-1], 2 * tail


def carried(q):
    """A vector across, carried along tangents q without turning about them."""
    across = [np.array([0, 1, 0])]
    for tangent in q[1:]:
        d = across[-1] - (across[-1] @ tangent) * tangent
        across.append(d / np.linalg.norm(d))
    return np.array(across)


def main():
    data = Path("options/data")
    data.mkdir(parents=True, exist_ok=True)
    # A catheter: its tip has a tenth of the shaft's stiffness and a hook; both end at distance 3.
    d = np.linspace(0, 3, 25)
    write(data / "catheter.h5", distance=d, factor=0.1 + 0.9 * rise(d / 3),
          curvature=0.5 * (1 - rise(d / 1.5)))
    # The tip of a catheter that is bent, held and let go, and how it is fed meanwhile: in, out and in again.
    d = np.linspace(0, 2, 21)
    steer, held = [0, 2, 2, 3.5, 3.5, 10, 10, 11.5], [0, 0, 0, 1, 1, 1, 1, 0]
    write(data / "bent-tip.h5", t=steer, distance=d, curvature=1.3 * np.outer(held, 1 - rise(d / 2)))
    feed = [[0, 1], [2, 3.5], [3.5, 3.5], [7.5, 6.8], [8, 6.8], [11.5, 2.5], [12, 2.5], [16, 6.8]]
    np.savetxt(data / "in-and-out.csv", feed, delimiter=",", fmt="%g", header="t,length", comments="")
    # A vine robot whose growing end is steered to and fro.
    t, d = np.linspace(0, 16, 65), np.linspace(0, 1.5, 16)
    write(data / "slalom.h5", t=t, distance=d, curvature=np.outer(rise(t) * np.sin(2 * np.pi * t / 5), 1 - rise(d / 1.5)))
    ropes = Path("docs/ropes")
    length, force = rope(ropes)
    print(f"capstan.opts: -growth_initial_length {length:.12g}, -tip_force_vector",
          ",".join(f"{f:.9g}" for f in force))
    twisted_loop(ropes)
    length, apart = overhand(ropes / "knot.h5", tail=2.5)
    print("knot.opts: -growth_initial_length", length)
    np.savetxt(ropes / "knot.csv", [[0, apart], [0.1, apart], [2, apart + 2.15]], delimiter=",", fmt="%g",
               header="t,x1", comments="")
    # A vessel that narrows: friction along it rises from 0.2 to 1 between x1 = 2 and 10.
    x1 = np.linspace(0, 12, 25)
    write(data / "vessel.h5", x1=x1, x2=[0], factor=[0.2 + 0.8 * rise((x1 - 2) / 8)])


if __name__ == "__main__":
    main()

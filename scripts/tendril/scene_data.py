"""Makes the data files of scenes, options/data/*.h5 and docs/ropes. They are kept with the scenes; this tells what
is in them, and makes them anew.

    PYTHONPATH=scripts .venv/bin/python -m tendril.scene_data"""

from pathlib import Path

import h5py
import numpy as np


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
    d2 = [np.array([0, 1, 0])]
    for k in range(1, len(s)):  # carried along without turning about q
        d = d2[-1] - (d2[-1] @ q[k]) * q[k]
        d2.append(d / np.linalg.norm(d))
    d2, twist = np.array(d2), torque / 0.75
    bend = np.stack([(slope * d2).sum(1), (slope * np.cross(q, d2)).sum(1)])
    c, z = np.cos(twist * (s - s[0])), np.sin(twist * (s - s[0]))
    every = slice(None, None, 8)
    write(data / "plectoneme.h5", s=((s - s[0]) / length)[every], u1=np.full(len(s[every]), twist),
          u2=(bend[0] * z - bend[1] * c)[every], u3=(bend[0] * c + bend[1] * z)[every])
    x = ((q[1:, 0] + q[:-1, 0]) / 2 * np.diff(s)).sum()
    t = np.linspace(0, 1, 11)
    np.savetxt(data / "plectoneme.csv", np.c_[time * t, x - slack * t * t * (3 - 2 * t)], delimiter=",", fmt="%.8f",
               header="t,x1", comments="")


def main():
    data = Path("options/data")
    data.mkdir(parents=True, exist_ok=True)
    # A catheter: its tip has a tenth of the shaft's stiffness and a hook; both end at distance 3.
    d = np.linspace(0, 3, 25)
    write(data / "catheter.h5", distance=d, factor=0.1 + 0.9 * rise(d / 3),
          curvature=0.5 * (1 - rise(d / 1.5)))
    ropes = Path("docs/ropes")
    length, force = rope(ropes)
    print(f"capstan.opts: -growth_initial_length {length:.12g}, -tip_force_vector",
          ",".join(f"{f:.9g}" for f in force))
    twisted_loop(ropes)
    # A vessel that narrows: friction along it rises from 0.2 to 1 between x1 = 2 and 10.
    x1 = np.linspace(0, 12, 25)
    write(data / "vessel.h5", x1=x1, x2=[0], factor=[0.2 + 0.8 * rise((x1 - 2) / 8)])


if __name__ == "__main__":
    main()

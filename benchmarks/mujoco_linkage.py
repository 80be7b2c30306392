"""A linkage in MuJoCo: a tree in joint coordinates, its loops shut by `connect` constraints, soft spheres at corners.

Settings after MuJoCo's documentation: `implicitfast`, which it recommends, and `RK4`, which it names for motion whose
energy is to be kept; constraints as stiff as it allows (a time constant of two steps, impedance 0.9999), Newton's
solver, an elliptic cone. It has no coefficient of restitution: contacts are springs with dampers, whose damping ratio
is chosen here so that a single contact returns with the restitution asked for.
"""

import math
from collections.abc import Callable
from typing import Any

import numpy as np
from linkage import Linkage, Tree, arm_of, as_tree, turn
from workload import Array

RADIUS = 0.01
"""Of the spheres at corners (m); the floor lies as much lower."""
STIFF = "0.9999 0.9999 0.001 0.5 2"
"""Impedance of constraints: the largest that MuJoCo takes."""
CONTACT = 0.01
"""Seconds that a contact lasts where a step is one millisecond; it goes with the root of the step."""


def damping_ratio(restitution: float) -> float:
    """Damping ratio of a spring and damper that let go when they no longer push, for a restitution above 0.21.

    e = exp(-ζ φ / √(1 - ζ²)), tan φ = -2ζ √(1 - ζ²) / (1 - 2ζ²), φ in (π/2, π): at φ = ω t the force is over.
    """
    low, high = 0.0, math.sqrt(0.5)
    for _ in range(60):
        middle = (low + high) / 2.0
        low, high = (middle, high) if restitution_of(middle) > restitution else (low, middle)
    return low


def restitution_of(ratio: float) -> float:
    """Restitution of a spring and damper with this damping ratio, at most √½."""
    rest = math.sqrt(1.0 - ratio**2)
    over = math.pi - math.atan2(2.0 * ratio * rest, 1.0 - 2.0 * ratio**2)
    return math.exp(-ratio / rest * over)


def xml(tree: Tree, step: float, integrator: str) -> str:
    """The model; all its bodies are parallel to the world at the start, where every coordinate is zero."""
    linkage = tree.linkage
    start = linkage.start
    ratio = damping_ratio(linkage.restitution) if linkage.corners else 1.0
    lasting = CONTACT * math.sqrt(step / 1e-3)
    contact = lasting * math.sqrt(1.0 - ratio**2) / (math.pi * ratio)
    origins: dict[int, Array] = {}
    inside: dict[int, list[str]] = {bond.link: [] for bond in tree.bonds}
    lines: list[str] = []
    for bond in reversed(tree.bonds):  # tips first: a body holds all that hang on it
        k, pin = bond.link, bond.pin
        origins[k] = start[k, :2] + (turn(arm_of(pin, k), start[k, 2]) if pin else 0.0)
    for bond in reversed(tree.bonds):
        k, pin = bond.link, bond.pin
        place = origins[k] - origins.get(bond.parent, np.zeros(2))
        slides = "" if pin else "".join(f"<joint type='slide' axis='{axis}' name='{n}'/>" for n, axis in SLIDES)
        inertia = float(linkage.inertias[k])
        text = (
            f"<body name='b{k}' pos='{_pair(place)}'>"
            f"<inertial pos='{_pair(start[k, :2] - origins[k])}' mass='{float(linkage.masses[k])!r}' "
            f"diaginertia='{inertia!r} {inertia!r} {inertia!r}'/>{slides}<joint type='hinge' axis='0 0 1' name='t{k}'/>"
        )
        for corner in linkage.corners:
            if corner.link == k:
                at = start[k, :2] + turn(corner.arm, start[k, 2]) - origins[k]
                text += (
                    f"<geom type='sphere' size='{RADIUS}' pos='{_pair(at)}' contype='0' conaffinity='1' condim='1'/>"
                )
        text += "".join(inside[k]) + "</body>"
        inside.get(bond.parent, lines).append(text)
    floor = (
        f"<geom type='plane' size='50 50 1' pos='0 {-RADIUS} 0' zaxis='0 1 0' contype='1' conaffinity='0' condim='1' "
        f"priority='1' solref='{contact!r} {ratio!r}' solimp='{STIFF}'/>"
    )
    shut = ""
    for pin in tree.cuts:
        names = [f"b{k}" if k >= 0 else "world" for k in (pin.first, pin.second)]
        k = pin.first
        anchor = pin.first_arm if k < 0 else start[k, :2] + turn(pin.first_arm, start[k, 2]) - origins[k]
        shut += (
            f"<connect body1='{names[0]}' body2='{names[1]}' anchor='{_pair(anchor)}' solref='{2.0 * step!r} 1' "
            f"solimp='{STIFF}'/>"
        )
    return (
        f"<mujoco><compiler angle='radian' inertiafromgeom='false'/>"
        f"<option gravity='0 {-linkage.gravity!r} 0' timestep='{step!r}' integrator='{integrator}' cone='elliptic' "
        f"solver='Newton' tolerance='1e-14'/><worldbody>{floor if linkage.corners else ''}{''.join(lines)}</worldbody>"
        f"<equality>{shut}</equality></mujoco>"
    )


SLIDES = (("x", "1 0 0"), ("y", "0 1 0"))


def start(linkage: Linkage, step: float, integrator: str) -> Callable[[int, int], Array]:
    """The linkage at its start; call it with a number of steps and after how many of them states are wanted."""
    import mujoco

    tree = as_tree(linkage)
    model: Any = mujoco.MjModel.from_xml_string(xml(tree, step, integrator))
    data: Any = mujoco.MjData(model)
    names = [*(("x", "y") if tree.floats else ()), *(f"t{bond.link}" for bond in tree.bonds)]
    order = np.array([int(model.joint(name).qposadr[0]) for name in names])
    data.qvel[order] = tree.speeds()

    def run(steps: int, every: int) -> Array:
        q, v = np.empty((steps // every, len(order))), np.empty((steps // every, len(order)))
        for row in range(steps // every):
            mujoco.mj_step(model, data, nstep=every)
            q[row], v[row] = data.qpos[order], data.qvel[order]
        return tree.states(q, v)

    return run


def _pair(place: Array) -> str:
    return f"{float(place[0])!r} {float(place[1])!r} 0"

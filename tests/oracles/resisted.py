"""Mechanisms that friction resists, their equations written out, and runs of these by SciPy in short steps.

Each is a scene, the values that a random generator draws for it, and the rate of its state: coordinates, velocities,
and the work of all that resists.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.integrate import solve_ivp

from .maximal import Array

G = 9.81
Values = dict[str, float]

BEAM = """
name = "braked-beam"
[ground_link]
points = { O = [0, 0] }
[[link]]
name = "beam"
mass = 0.8
inertia = 0.05
com = [0.25, 0]
points = { A = [0, 0], B = [0.5, 0] }
[[joint]]
name = "hinge"
between = ["ground.O", "beam.A"]
[[brake]]
joint = "hinge"
torque = 0.5
[[joint_friction]]
joints = ["hinge"]
dry = 0.1
rate = 0.01
breakaway = 0.2
stribeck = 0.1
[[drag]]
point = "beam.B"
quadratic = 0.5
[gravity]
[start]
angles = { beam = 1.0 }
"""

ARM = """
name = "braked-arm"
[ground_link]
points = { O = [0, 0] }
[[link]]
name = "upper"
mass = 1.3
inertia = 0.04
com = [0.2, 0]
points = { A = [0, 0], B = [0.5, 0] }
[[link]]
name = "fore"
mass = 0.7
inertia = 0.02
com = [0.25, 0]
points = { B = [0, 0], C = [0.4, 0] }
[[joint]]
name = "shoulder"
between = ["ground.O", "upper.A"]
[[joint]]
name = "elbow"
between = ["upper.B", "fore.B"]
[[brake]]
joint = "shoulder"
torque = 0.5
[[joint_friction]]
joints = ["elbow"]
dry = 0.1
rate = 0.01
[[motor]]
joint = "shoulder"
angle = 0.5
stiffness = 20
damping = 0.5
limit = 2
[gravity]
[start]
angles = { upper = 1.0, fore = 0.5 }
"""

DISC = """
name = "laid-disc"
[[link]]
name = "disc"
mass = 2.0
inertia = 0.01
com = [0, 0]
points = { C = [0, 0] }
[[compliant_ground]]
name = "mat"
load = "100 N"
contacts = ["disc.C"]
radius = 0.1
normal = [-0.6, 0.8]
damping = 0.5
friction = 0.3
[gravity]
[start]
poses = { disc = [0.0, 1.0, 0.0] }
"""


def _power(rng: np.random.Generator, low: float, high: float) -> float:
    """10 to a random power between two."""
    return float(10.0 ** rng.uniform(low, high))


def draw_beam(rng: np.random.Generator) -> tuple[Values, Array]:
    """A brake, Stribeck's curve, quadratic drag, or all of them; and an angle."""
    kind = rng.integers(4)
    values = dict.fromkeys(
        ("brake_0.torque", "joint_friction_0.dry", "joint_friction_0.breakaway", "drag_0.quadratic"), 0.0
    )
    values |= {"brake_0.rate": 0.01, "joint_friction_0.rate": 0.01, "joint_friction_0.stribeck": 1.0}
    values |= {"drag_0.speed": 1e-3}
    if kind in (0, 3):
        values |= {"brake_0.torque": _power(rng, -3, 0.3), "brake_0.rate": _power(rng, -4, -1)}
    if kind in (1, 3):
        dry, rate = _power(rng, -3, 0), _power(rng, -4, -1)
        values |= {"joint_friction_0.dry": dry, "joint_friction_0.breakaway": dry * rng.uniform(1, 2)}
        values |= {"joint_friction_0.rate": rate, "joint_friction_0.stribeck": rate * _power(rng, 0.3, 2)}
    if kind in (2, 3):
        values |= {"drag_0.quadratic": _power(rng, -3, 1), "drag_0.speed": _power(rng, -4, -1)}
    return values, rng.uniform(-3.0, 3.0, 1)


def beam(values: Values) -> Callable[[float, Array], Array]:
    get = values.__getitem__

    def rate(_: float, y: Array) -> Array:
        angle, w = y[0], y[1]
        dry, extra = get("joint_friction_0.dry"), get("joint_friction_0.breakaway") - get("joint_friction_0.dry")
        moment = get("brake_0.torque") * np.tanh(w / get("brake_0.rate"))
        friction = dry + extra * np.exp(-((w / get("joint_friction_0.stribeck")) ** 2))
        moment = moment + friction * np.tanh(w / get("joint_friction_0.rate"))
        speed = 0.5 * w
        moment = moment + 0.5 * get("drag_0.quadratic") * np.sqrt(speed**2 + get("drag_0.speed") ** 2) * speed
        return np.array([w, -(0.8 * G * 0.25 * np.cos(angle) + moment) / (0.05 + 0.8 * 0.25**2), -moment * w])

    return rate


def draw_arm(rng: np.random.Generator) -> tuple[Values, Array]:
    """A brake in the shoulder, dry friction in the elbow, and a motor that is at its limit or not; and two angles."""
    values = {"brake_0.torque": _power(rng, -3, 0.5), "brake_0.rate": _power(rng, -4, -1)}
    values |= {"joint_friction_0.dry": _power(rng, -3, 0), "joint_friction_0.rate": _power(rng, -4, -1)}
    values |= {"motor_0.stiffness": _power(rng, 0, 2), "motor_0.limit": _power(rng, -1, 1), "motor_0.damping": 0.5}
    return values, rng.uniform(-3.0, 3.0, 2)


def arm(values: Values) -> Callable[[float, Array], Array]:
    get = values.__getitem__

    def rate(_: float, y: Array) -> Array:
        a, b, p, r = y[0], y[1], y[2], y[3]
        asked = get("motor_0.stiffness") * (0.5 - a) - get("motor_0.damping") * p
        limit = get("motor_0.limit")
        motor = asked if abs(asked.real) < limit else limit * np.sign(asked.real)
        shoulder = motor - get("brake_0.torque") * np.tanh(p / get("brake_0.rate"))
        elbow = -get("joint_friction_0.dry") * np.tanh((r - p) / get("joint_friction_0.rate"))
        m = 0.7 * 0.5 * 0.25
        m11, m12, m22 = 0.04 + 1.3 * 0.2**2 + 0.7 * 0.5**2, m * np.cos(a - b), 0.02 + 0.7 * 0.25**2
        at_a = shoulder - elbow - (1.3 * 0.2 + 0.7 * 0.5) * G * np.cos(a) - m * np.sin(a - b) * r**2
        at_b = elbow - 0.7 * 0.25 * G * np.cos(b) + m * np.sin(a - b) * p**2
        free = m11 * m22 - m12**2
        return np.array(
            [
                p,
                r,
                (m22 * at_a - m12 * at_b) / free,
                (m11 * at_b - m12 * at_a) / free,
                shoulder * p + elbow * (r - p),
            ]
        )

    return rate


def draw_disc(rng: np.random.Generator) -> tuple[Values, Array]:
    """On a slope that gives way, just touched."""
    values = {"mat.load": _power(rng, 1, 3), "mat.damping": _power(rng, -2, 0)}
    values |= {"mat.friction": rng.uniform(0.05, 1.0), "mat.slip_speed": _power(rng, -4, -1)}
    return values, np.array([-0.06, 0.08, rng.uniform(-3.0, 3.0)])


def disc(values: Values) -> Callable[[float, Array], Array]:
    get = values.__getitem__
    normal, along = np.array([-0.6, 0.8]), np.array([0.8, 0.6])

    def rate(_: float, y: Array) -> Array:
        depth, sinks = 0.1 - normal @ y[:2], -normal @ y[3:5]
        slip = along @ y[3:5] + 0.1 * y[5]
        force = get("mat.load") * (max(float(depth), 0.0) / 1e-3) ** 1.5 * (1.0 + get("mat.damping") * sinks)
        friction = -get("mat.friction") * force * np.tanh(slip / get("mat.slip_speed"))
        load = force * normal + friction * along
        return np.array(
            [y[3], y[4], y[5], load[0] / 2.0, load[1] / 2.0 - G, 0.1 * friction / 0.01, friction * slip - force * sinks]
        )

    return rate


@dataclass(frozen=True)
class Resisted:
    """A mechanism: its scene, what is drawn for it, and the rate of its state, whose first ``size`` are coordinates."""

    scene: str
    size: int
    draw: Callable[[np.random.Generator], tuple[Values, Array]]
    rate: Callable[[Values], Callable[[float, Array], Array]]

    def run(self, values: Values, q: Array, u: Array, until: float, rtol: float = 1e-13) -> Array:
        """The state at ``until`` (s), by steps of at most a fiftieth of that, the first of a millionth of a second."""
        start = np.concatenate([q, u, [0.0]])
        found = solve_ivp(
            self.rate(values),
            (0.0, until),
            start,
            method="DOP853",
            rtol=rtol,
            atol=1e-2 * rtol,
            first_step=1e-6,
            max_step=until / 50,
        )
        assert found.success
        return np.asarray(found.y[:, -1])


MECHANISMS = {
    "beam": Resisted(BEAM, 1, draw_beam, beam),
    "arm": Resisted(ARM, 2, draw_arm, arm),
    "disc": Resisted(DISC, 3, draw_disc, disc),
}

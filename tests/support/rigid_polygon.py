"""A regular polygon of rods, frozen stiff, that falls and bounces on y = 0: a motion in closed form between impacts.

It stands in for a compiled model wherever only the shape of a run matters.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from ccgen.runtime.model.disc import Disc
from ccgen.runtime.model.part import Part
from ccgen.runtime.model.rope import Rope
from ccgen.runtime.record.impact import Impact
from ccgen.runtime.record.phase import Phase
from ccgen.runtime.run import Run

Array = NDArray[np.float64]
G = 9.81


@dataclass(frozen=True)
class PolygonModel:
    """n unit rods of 1 kg; q = origin of link 0 and all link angles, as the generated models have it."""

    n: int = 6
    name: str = "stiff-hexagon"
    parameters: dict[str, float] = field(default_factory=lambda: {"gravity.g": G, "ground_0.restitution": 0.5})

    @property
    def links(self) -> tuple[str, ...]:
        return tuple(f"link_{k}" for k in range(self.n))

    @property
    def joints(self) -> tuple[str, ...]:
        return tuple(f"joint_{k}" for k in range(self.n))

    @property
    def q_of(self) -> tuple[str, ...]:
        return tuple(f"polygon.{name}" for name in self.q_names)

    @property
    def q_names(self) -> tuple[str, ...]:
        return ("x_0", "y_0", *(f"theta_{k}" for k in range(self.n)))

    @property
    def u_names(self) -> tuple[str, ...]:
        return ("vx_0", "vy_0", *(f"w_{k}" for k in range(self.n)))

    @property
    def contacts(self) -> tuple[tuple[str, str], ...]:
        return tuple((joint, "ground_0") for joint in self.joints)

    @property
    def stops(self) -> frozenset[str]:
        return frozenset()

    @property
    def off_contacts(self) -> tuple[tuple[str, str], ...]:
        return ()

    @property
    def slide_ends(self) -> frozenset[str]:
        return frozenset()

    def gaps(self, q: Array) -> Array:
        return self._corners(q)[..., : len(self.joints), 1]

    @property
    def outlines(self) -> tuple[Array, ...]:
        return tuple(np.array([[0.0, 0.0], [1.0, 0.0]]) for _ in self.links)

    @property
    def discs(self) -> tuple[Disc, ...]:
        return ()

    @property
    def ropes(self) -> tuple[Rope, ...]:
        return ()

    @property
    def parts(self) -> tuple[Part, ...]:
        return ()

    def slides(self, q: Array) -> dict[str, Array]:
        return {}

    @property
    def drawn_joints(self) -> tuple[str, ...]:
        return tuple(self.joints)

    @property
    def drawn_ground_points(self) -> Array:
        return np.zeros((0, 2))

    def ground_planes(self) -> dict[str, tuple[Array, Array]]:
        return {"ground_0": (np.zeros(2), np.array([0.0, 1.0]))}

    def _corners(self, q: Array) -> Array:
        """(..., n + 1, 2): joint 0 ... joint n, the last one coming back to the first."""
        sides = np.stack([np.cos(q[..., 2:]), np.sin(q[..., 2:])], axis=-1)
        first = q[..., None, :2]
        return np.concatenate([first, first + np.cumsum(sides, axis=-2)], axis=-2)

    def poses(self, q: Array) -> Array:
        return np.concatenate([self._corners(q)[..., :-1, :], q[..., 2:, None]], axis=-1)

    def point(self, name: str, q: Array) -> Array:
        return np.asarray(self._corners(q)[..., self.joints.index(name), :])

    def closure(self, q: Array) -> Array:
        corners = self._corners(q)
        return np.asarray(corners[..., -1, :] - corners[..., 0, :])

    def energy(self, q: Array, u: Array) -> tuple[Array, Array]:
        middle, speed, spin = self._body(q, u)
        kinetic = 0.5 * self.n * np.sum(speed**2, axis=-1) + 0.5 * self.inertia * spin**2
        return kinetic, self.n * G * middle[..., 1]

    @property
    def radius(self) -> float:
        return float(0.5 / np.sin(np.pi / self.n))

    @property
    def inertia(self) -> float:
        return self.n * (1 / 12 + self.radius**2 - 0.25)

    def _body(self, q: Array, u: Array) -> tuple[Array, Array, Array]:
        """Centre, its velocity and the spin."""
        middle = self._corners(q)[..., :-1, :].mean(axis=-2)
        arm, spin = middle - q[..., :2], u[..., 2]
        return middle, u[..., :2] + spin[..., None] * np.stack([-arm[..., 1], arm[..., 0]], axis=-1), spin

    def state(self, middle: Array, speed: Array, angle: float, spin: float) -> tuple[Array, Array]:
        """(q, u) of the polygon with joint 0 at `angle` from straight down."""
        arm = self.radius * np.array([np.sin(angle), -np.cos(angle)])
        turns = 2 * np.pi * (np.arange(self.n) + 0.5) / self.n + angle
        velocity = speed + spin * np.array([-arm[1], arm[0]])
        return np.concatenate([middle + arm, turns]), np.concatenate([velocity, np.full(self.n, spin)])

    def flight(self, t0: float, q0: Array, u0: Array, h: float) -> tuple[Array, Array]:
        """Where free flight leads in h seconds, exactly."""
        middle, speed, spin = self._body(q0, u0)
        angle = float(q0[2] - np.pi / self.n)
        fall = np.array([0.0, -G])
        later = middle + h * speed + 0.5 * h**2 * fall
        return self.state(later, speed + h * fall, angle + h * float(spin), float(spin))

    def between(self, t: float, times: Array, q: Array, u: Array) -> tuple[Array, Array]:
        """The state at t between two rows of a flight."""
        return self.flight(times[0], q[0], u[0], t - times[0])

    def height(self, q: Array) -> float:
        return float(self._corners(q)[..., 1].min())


def bouncing(
    until: float = 1.25, height: float = 1.0, tilt: float = 0.2, drift: float = 0.0, spin: float = 0.0, n: int = 6
) -> Run:
    """The polygon falling from `height`: rows every 0.05 s, impacts of its lowest corner with e = 0.5."""
    model = PolygonModel(n)
    start = np.array([0.0, height + model.radius * np.cos(tilt)])
    q, u = model.state(start, np.array([drift, 0.0]), tilt, spin)
    rows, impacts, phases = [(0.0, q, u)], [], []
    t, began = 0.0, 0.0
    while t < until:
        h = min(0.05, until - t)
        ahead = model.flight(t, q, u, h)
        if model.height(ahead[0]) > 0:
            t, (q, u) = t + h, ahead
            rows.append((t, q, u))
            continue
        h = _touch(model, q, u, h)
        t, (q, u) = t + h, model.flight(t, q, u, h)
        impact = _strike(model, t, q, u)
        rows += [(t, q, u), (t, q, impact.u_plus)]
        impacts.append(impact)
        phases += [Phase("flight", began, t), Phase("impact", t, t)]
        u, began = impact.u_plus, t
    phases.append(Phase("flight", began, t))
    ts, qs, us = (np.array(column) for column in zip(*rows, strict=True))
    return Run(model, ts, qs, us, tuple(impacts), tuple(phases), True, "", 12 * len(rows), 1e-15, 2e-13, model)


def _touch(model: PolygonModel, q: Array, u: Array, h: float) -> float:
    """The first instant within h at which the lowest corner is at the ground, from above."""
    low, high = 0.0, h
    for _ in range(60):
        middle = 0.5 * (low + high)
        above = model.height(model.flight(0.0, q, u, middle)[0]) > 0
        low, high = (middle, high) if above else (low, middle)
    return low


def _strike(model: PolygonModel, t: float, q: Array, u: Array) -> Impact:
    """The impact of the lowest corner of a rigid body without friction."""
    corners = model._corners(q)[:-1]
    corner = int(corners[:, 1].argmin())
    middle, speed, spin = model._body(q, u)
    arm = corners[corner] - middle
    approach = speed[1] + spin * arm[0]
    impulse = -1.5 * approach / (1 / model.n + arm[0] ** 2 / model.inertia)
    after = model.state(
        middle,
        speed + np.array([0.0, impulse / model.n]),
        float(q[2] - np.pi / model.n),
        float(spin + arm[0] * impulse / model.inertia),
    )[1]
    loss = float(model.energy(q, u)[0] - model.energy(q, after)[0])
    return Impact(t, ((f"joint_{corner}", "ground_0"),), u, after, np.array([impulse]), loss)

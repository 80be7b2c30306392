"""A four-bar in closed form, its crank turning evenly: ground pivots, a triangular coupler, no contacts."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from ccgen.runtime.model.disc import Disc
from ccgen.runtime.model.part import Part
from ccgen.runtime.model.rope import Rope
from ccgen.runtime.record.phase import Phase
from ccgen.runtime.run import Run

Array = NDArray[np.float64]
CRANK, COUPLER, ROCKER, SPAN = 0.3, 1.0, 0.8, 1.0


@dataclass(frozen=True)
class FourBar:
    """Massless links with 1 kg at the tip of the coupler; q = (crank, coupler, rocker) angles."""

    name: str = "four-bar </script>"
    links: tuple[str, ...] = ("crank", "coupler", "rocker")
    joints: tuple[str, ...] = ("joint_0", "joint_1", "joint_2", "joint_3")
    drawn_joints: tuple[str, ...] = joints
    q_names: tuple[str, ...] = ("theta_0", "theta_1", "theta_2")
    u_names: tuple[str, ...] = ("w_0", "w_1", "w_2")
    contacts: tuple[tuple[str, str], ...] = ()
    parameters: dict[str, float] = field(default_factory=dict)
    outlines: tuple[Array, ...] = (
        np.array([[0.0, 0.0], [CRANK, 0.0]]),
        np.array([[0.0, 0.0], [COUPLER, 0.0], [0.4, 0.5]]),
        np.array([[0.0, 0.0], [ROCKER, 0.0]]),
    )
    drawn_ground_points: Array = field(default_factory=lambda: np.array([[0.0, 0.0], [SPAN, 0.0]]))

    stops: frozenset[str] = frozenset()
    slide_ends: frozenset[str] = frozenset()
    off_contacts: tuple[tuple[str, str], ...] = ()
    discs: tuple[Disc, ...] = ()
    ropes: tuple[Rope, ...] = ()
    parts: tuple[Part, ...] = ()

    def slides(self, q: Array) -> dict[str, Array]:
        return {}

    def gaps(self, q: Array) -> Array:
        return np.zeros((*q.shape[:-1], 0))

    def ground_planes(self) -> dict[str, tuple[Array, Array]]:
        return {}

    def point(self, name: str, q: Array) -> Array:
        origin = np.zeros((*q.shape[:-1], 2))
        pin = origin + CRANK * np.stack([np.cos(q[..., 0]), np.sin(q[..., 0])], axis=-1)
        far = pin + COUPLER * np.stack([np.cos(q[..., 1]), np.sin(q[..., 1])], axis=-1)
        return (origin, pin, far, origin + np.array([SPAN, 0.0]))[self.joints.index(name)]

    def poses(self, q: Array) -> Array:
        origins = np.stack([self.point(name, q) for name in ("joint_0", "joint_1", "joint_3")], axis=-2)
        return np.concatenate([origins, q[..., None]], axis=-1)

    def closure(self, q: Array) -> Array:
        rocker = ROCKER * np.stack([np.cos(q[..., 2]), np.sin(q[..., 2])], axis=-1)
        return np.asarray(self.point("joint_2", q) - self.point("joint_3", q) - rocker)

    def energy(self, q: Array, u: Array) -> tuple[Array, Array]:
        x, y, angle = np.moveaxis(self.poses(q)[..., 1, :], -1, 0)
        return 0.5 * np.sum(u**2, axis=-1), 9.81 * (y + 0.4 * np.sin(angle) + 0.5 * np.cos(angle)) + 0 * x

    def turn(self, t0: float, q0: Array, u0: Array, h: float) -> tuple[Array, Array]:
        """The pose h seconds on, the crank turning at one turn a second."""
        crank = q0[0] + 2 * np.pi * h
        pin = CRANK * np.array([np.cos(crank), np.sin(crank)])
        reach = np.array([SPAN, 0.0]) - pin
        d = float(np.hypot(*reach))
        coupler = np.arctan2(reach[1], reach[0]) + np.arccos((COUPLER**2 + d**2 - ROCKER**2) / (2 * COUPLER * d))
        far = pin + COUPLER * np.array([np.cos(coupler), np.sin(coupler)]) - np.array([SPAN, 0.0])
        return np.array([crank, coupler, np.arctan2(far[1], far[0])]), u0

    def between(self, t: float, times: Array, q: Array, u: Array) -> tuple[Array, Array]:
        """The state at t between two rows."""
        return self.turn(times[0], q[0], u[0], t - times[0])


def turning(until: float = 1.0) -> Run:
    model = FourBar()
    start = model.turn(0.0, np.array([0.5, 0.0, 0.0]), np.zeros(3), 0.0)[0]
    ts = np.linspace(0.0, until, 21)
    qs = np.array([model.turn(0.0, start, np.zeros(3), t)[0] for t in ts])
    flight = (Phase("flight", 0.0, until),)
    return Run(model, ts, qs, np.ones_like(qs), (), flight, False, "made to stop", 1, 0.0, 0.0, model)

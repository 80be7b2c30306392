"""The energy balance of a run, from what it recorded.

Kinetic energy and that of weights are worked out of the poses and velocities of the links at the rows, with the masses
of the scene; the work of every other load, of springs too, of its force between the rows times the rate of the way on
which it acts; losses are those that impacts and stretches of time stepping say. Nothing is asked of the model's
energies, nor of the works that the core sums up.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ccgen.runtime.record.outputs import Sample, outputs_of

Array = NDArray[np.float64]

NODES, WEIGHTS = np.polynomial.legendre.leggauss(6)
"""In each of the parts of an interval between two rows."""
IDLE = {"Gravity", "Ground", "Touch", "OutlineTouch", "Stop", "Meshing", "Cam", "Journal", "Rope", "Input", "Law"}
"""Effects that have no power, as laws, by which others act, or whose power is that of their contacts or of weights."""


@dataclass(frozen=True)
class Body:
    """Mass (kg), inertia about the centre of mass (kg m²), and where that is in the link's frame (m)."""

    mass: float
    inertia: float
    centre: tuple[float, float]


def body(model: Any, link: str) -> Body:
    told = model.parameters
    centre = told.get(f"{link}.com.x", 0.0), told.get(f"{link}.com.y", 0.0)
    return Body(told.get(f"{link}.mass", 0.0), told.get(f"{link}.inertia", 0.0), centre)


def turned(angle: Array, arm: tuple[float, float]) -> Array:
    """A vector of a link's frame at angles (n,) of that: (n, 2)."""
    c, s = np.cos(angle), np.sin(angle)
    return np.stack([c * arm[0] - s * arm[1], s * arm[0] + c * arm[1]], axis=1)


def energy(model: Any, q: Array, u: Array) -> Array:
    """Of all links (n,), J: m v²/2 of each centre of mass, J ω²/2, and m g y."""
    poses, rates = model.poses(q), model.velocities(q, u)
    found, g = np.zeros(len(q)), model.parameters.get("gravity.g", 0.0)
    for number, link in enumerate(model.links):
        own, spin = body(model, link), rates[:, number, 2]
        arm = turned(poses[:, number, 2], own.centre)
        speed = rates[:, number, :2] + spin[:, None] * np.stack([-arm[:, 1], arm[:, 0]], axis=1)
        found += 0.5 * own.mass * np.sum(speed**2, axis=1) + 0.5 * own.inertia * spin**2
        found += own.mass * g * (poses[:, number, 1] + arm[:, 1])
    return found


def left(scene: Any, run: Any, nodes: int = 3000) -> Array:
    """What of the energy at every row (nt,), less that of the first, J, neither loads nor recorded losses account for.

    Powers are looked at at some ``nodes`` instants at least.
    """
    (model,) = run.in_force.models
    found = energy(model, run.q, run.u)
    found -= found[0]
    for impact in run.impacts:
        found[_row_after(run, impact) :] += impact.energy_loss
    for phase in run.phases:
        if phase.kind == "steps":
            found[np.searchsorted(run.t, phase.end) :] += phase.taken
    steps = np.diff(run.t)
    moving = steps > 0.0
    parts = int(np.ceil(nodes / (len(NODES) * np.count_nonzero(moving))))
    cuts = (np.arange(parts)[:, None] + 0.5 * (1.0 + NODES)).ravel() / parts
    times = run.t[:-1][moving, None] + steps[moving, None] * cuts
    power = sum((one.reshape(times.shape) for one in powers(scene, run, times.ravel())), np.zeros(times.shape))
    rises = np.zeros(len(steps))
    rises[moving] = power @ np.tile(0.5 * WEIGHTS, parts) / parts * steps[moving]
    return np.asarray(found - np.concatenate([[0.0], np.cumsum(rises)]))


def _row_after(run: Any, impact: Any) -> int:
    rows = np.flatnonzero(run.t == impact.t)
    after = [row for row in rows[1:] if np.array_equal(run.u[row], impact.u_plus)]
    return int(after[0] if after else rows[-1])


class Between:
    """A run at times between its rows: what loads exert, and the rates of what they act on."""

    def __init__(self, scene: Any, run: Any, t: Array) -> None:
        self.mechanism, self.run, self.t = scene.mechanism, run, t
        (self.model,) = run.in_force.models
        self.known = Sample(run, t)  # what Run.values looks names up in, once for all of them
        self.q, self.u = self.known.q, self.known.u
        self.poses, self.rates = self.model.poses(self.q), self.model.velocities(self.q, self.u)

    def told(self, name: str) -> Array:
        return np.asarray(outputs_of(self.run.model)[name].of(self.known))

    def _arm(self, reference: Any) -> tuple[float, float]:
        told = self.model.parameters
        owner = "ground" if reference.link < 0 else self.model.links[reference.link]
        if reference.point == "B" and f"{owner}.length" in told:
            return told[f"{owner}.length"], 0.0
        name = f"{owner}.points.{reference.point}"
        return told.get(f"{name}.x", 0.0), told.get(f"{name}.y", 0.0)

    def place(self, reference: Any) -> Array:
        """Where a named point of a link, or of the ground, is (n, 2)."""
        arm = self._arm(reference)
        if reference.link < 0:
            return np.tile(np.array(arm), (len(self.t), 1))
        pose = self.poses[:, reference.link]
        return np.asarray(pose[:, :2] + turned(pose[:, 2], arm))

    def velocity(self, reference: Any) -> Array:
        if reference.link < 0:
            return np.zeros((len(self.t), 2))
        arm = turned(self.poses[:, reference.link, 2], self._arm(reference))
        rate = self.rates[:, reference.link]
        return np.asarray(rate[:, :2] + rate[:, 2:] * np.stack([-arm[:, 1], arm[:, 0]], axis=1))

    def stretching(self, line: Any) -> Array:
        """The rate (n,) at which the two points of a line part."""
        first, second = line.points
        reach = self.place(second) - self.place(first)
        apart = self.velocity(second) - self.velocity(first)
        return np.asarray(np.sum(apart * reach, axis=1) / np.linalg.norm(reach, axis=1))

    def joint(self, number: int) -> tuple[str, Array]:
        """Its name, and the rate on which its effort works (n,)."""
        joint = self.mechanism.joints[number]
        asked = f"{joint.name}.{'slide_rate' if joint.slides else 'angular_velocity'}"
        return joint.name, self.told(asked if asked in self.run.outputs else f"joint {asked}")


def powers(scene: Any, run: Any, t: Array) -> Iterator[Array]:
    """Of every load but weights its power (n,), W, at times t (n,)."""
    at = Between(scene, run, t)
    for effect in scene.effects:
        kind = type(effect).__name__
        if kind in _POWERS:
            yield from _POWERS[kind](at, effect)
        elif kind not in IDLE:
            raise NotImplementedError(kind)
    if np.any(at.model.kernels.friction):
        yield from _rubbing(at)


def _along_line(at: Between, effect: Any) -> Iterator[Array]:
    yield -at.told(f"{effect.name}.force") * at.stretching(effect.line)


def _about_joint(at: Between, effect: Any) -> Iterator[Array]:
    slides = at.mechanism.joints[effect.joint].slides
    word = "moment" if type(effect).__name__ == "Torsion" else "force" if slides else "torque"
    yield at.told(f"{effect.name}.{word}") * at.joint(effect.joint)[1]


def _in_joints(at: Between, effect: Any) -> Iterator[Array]:
    for number in effect.joints:
        name, rate = at.joint(number)
        yield at.told(f"{effect.name}.{name}.{'force' if at.mechanism.joints[number].slides else 'moment'}") * rate


def _on_link(at: Between, effect: Any) -> Iterator[Array]:
    yield at.told(f"{effect.name}.torque") * at.rates[:, effect.link, 2]


def _at_point(at: Between, effect: Any) -> Iterator[Array]:
    v = at.velocity(effect.point)
    if type(effect).__name__ == "Drag":  # against the velocity
        yield -at.told(f"{effect.name}.force") * np.linalg.norm(v, axis=1)
        return
    yield at.told(f"{effect.name}.fx") * v[:, 0] + at.told(f"{effect.name}.fy") * v[:, 1]


def _of_drive(at: Between, effect: Any) -> Iterator[Array]:
    """By the reaction of the driven joint."""
    yield at.told(f"{at.mechanism.joints[effect.joint].name}.power")


_POWERS: dict[str, Callable[[Between, Any], Iterator[Array]]] = {
    "Spring": _along_line,
    "Damper": _along_line,
    "Torsion": _about_joint,
    "Motor": _about_joint,
    "Brake": _about_joint,
    "JointFriction": _in_joints,
    "Torque": _on_link,
    "Force": _at_point,
    "Drag": _at_point,
    "Drive": _of_drive,
}


def _rubbing(at: Between) -> Iterator[Array]:
    """Friction of points and discs on grounds: along the ground, times the velocity of what touches it there. In time
    stepping, where forces are no numbers, it is among what contacts take."""
    told = at.model.parameters
    force = np.nan_to_num(at.known.motion.pushes[..., 1])
    planes = at.model.ground_planes()
    for number, (point, ground) in enumerate(at.model.contacts):
        if not np.any(force[:, number]):
            continue
        if ground not in planes:
            raise NotImplementedError(f"friction of {point} on {ground}")
        normal = planes[ground][1]
        slip = at.model.point_velocity(point, at.q, at.u) @ np.array([normal[1], -normal[0]])
        if radius := told.get(f"{ground}.radius.{point}", told.get(f"{ground}.radius", 0.0)):
            slip = slip + radius * at.rates[:, at.model.links.index(point.partition(".")[0]), 2]
        yield force[:, number] * slip

"""What every picture of a run is made from: sampled frames of the motion."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..arrays import FloatArray
from ..record.drawable import Drawable
from ..record.event import Event
from ..record.impact import Impact
from ..record.outputs import Sample
from ..record.record import Record

MOST_IMPACTS = 1000  # more than that no picture shows apart
MOST_EVENTS = 200  # of one name


@dataclass(frozen=True)
class Frames:
    """The motion at n instants t: poses (n, drawn links, 3), joints (n, joints, 2), energies (n,).

    ``states`` has more of it, and the models that are in force.
    """

    t: FloatArray
    q: FloatArray
    u: FloatArray
    poses: FloatArray
    joints: FloatArray
    kinetic: FloatArray
    potential: FloatArray
    states: Sample

    def model(self, k: int) -> Drawable:
        """The model that is in force at instant k."""
        in_force, which = self.states.in_force
        return in_force.models[int(which[k])]

    def looks(self) -> list[tuple[Drawable, NDArray[np.bool_]]]:
        """The models that are in force at some of the instants, and at which (n,)."""
        in_force, which = self.states.in_force
        return [(in_force.models[number], which == number) for number in dict.fromkeys(which.tolist())]

    def joints_of(self, model: Drawable) -> FloatArray:
        """The joints (joints, 2) at the first instant at which a model is in force; at the first of all if none is."""
        return np.asarray(self.joints[next((int(np.argmax(rows)) for one, rows in self.looks() if one is model), 0)])


def shown_impacts(run: Record, most: int = MOST_IMPACTS) -> list[tuple[int, Impact]]:
    """Impacts worth a place in a picture, with their numbers from 1 on: all of them, or where there are more than
    ``most``, of each such part of the run the one that takes most energy."""
    numbered = list(enumerate(run.impacts, start=1))
    if len(numbered) <= most:
        return numbered
    part = max(float(run.t[-1] - run.t[0]) / most, np.finfo(float).tiny)
    largest: dict[int, tuple[int, Impact]] = {}
    for number, impact in numbered:
        place = int((float(impact.t) - float(run.t[0])) / part)
        if place not in largest or impact.energy_loss > largest[place][1].energy_loss:
            largest[place] = (number, impact)
    return sorted(largest.values(), key=lambda shown: shown[0])


def shown_events(run: Record, most: int = MOST_EVENTS) -> list[Event]:
    """Events worth a mark in a picture: all of them, or where there are more than ``most``, of each name the first in
    each such part of the run."""
    if len(run.events) <= most:
        return list(run.events)
    part = max(float(run.t[-1] - run.t[0]) / most, np.finfo(float).tiny)
    found: dict[tuple[str, int], Event] = {}
    for event in run.events:
        found.setdefault((event.name, int((float(event.t) - float(run.t[0])) / part)), event)
    return list(found.values())


def shown_changes(run: Record, most: int = MOST_IMPACTS) -> list[float]:
    """Times (s) at which events have set or switched something: all, or of more than ``most`` every second, third."""
    changes = run.in_force.changes
    every = -(-len(changes) // most) or 1
    return [float(t) for t in changes[::every]]


def frame_times(run: Record, rate: float, *, with_impacts: bool = True, most: int = MOST_IMPACTS) -> FloatArray:
    """Instants 1/rate apart from the start of the run, its end and, if asked, those of the impacts that are shown, and
    at which events have set something.

    A regular instant closer than a thousandth of a frame to an exact one gives way to it.
    """
    start, end = float(run.t[0]), float(run.t[-1])
    count = int(np.floor((end - start) * rate))
    regular = start + np.arange(count + 1) / rate
    beside = [*(impact.t for _, impact in shown_impacts(run, most)), *shown_changes(run, most)] if with_impacts else []
    exact = np.array([start, end, *beside])
    distance = np.min(np.abs(regular[:, None] - np.unique(exact)), axis=1)
    times: FloatArray = np.unique(np.concatenate([regular[distance > 1e-3 / rate], exact]))
    return times


def sample(run: Record, times: FloatArray) -> Frames:
    """The motion of a run at the given instants; at an impact its velocities are those after it."""
    model = run.model
    times = np.clip(times, run.t[0], run.t[-1])  # the end of a wide run, rounded to a double, may lie beyond it
    states = Sample(run, times)
    joints = np.zeros((len(times), len(model.drawn_joints), 2))
    for k, joint in enumerate(model.drawn_joints):
        joints[:, k] = states.place(joint)
    kinetic, potential = states.energies
    poses = states.poses[:, : len(model.outlines)]
    return Frames(times, states.q, states.u, poses, joints, kinetic, potential, states)


def pivots(model: Drawable, frames: Frames, size: float) -> FloatArray:
    """The points (k, 2) of the ground, in m, that hold something while a model is in force: a joint, or the end of what
    acts between points, also of what is off then and on in others of the ``frames``. ``size`` is the mechanism's (m).
    """
    fixed = np.asarray(model.drawn_ground_points, dtype=float).reshape(-1, 2)
    ends = [
        point
        for one, _ in frames.looks()
        for links, points in (
            *((part.links, part.points) for part in one.parts if part.kind in ("spring", "damper")),
            *((rope.links, rope.points) for rope in one.ropes),
        )
        for link, point in zip(links, points, strict=True)
        if link < 0
    ]
    held = np.concatenate([frames.joints_of(model), np.reshape(ends, (-1, 2))])
    distance = np.hypot(*np.moveaxis(fixed[:, None] - held, -1, 0))
    return np.asarray(fixed[np.any(distance <= 1e-6 * size, axis=1)])


def placed(outline: FloatArray, pose: FloatArray) -> FloatArray:
    """Points (m, 2) of a link's frame in the plane, for poses (..., 3): (..., m, 2)."""
    x, y, angle = (pose[..., i, None] for i in range(3))
    cos, sin = np.cos(angle), np.sin(angle)
    local_x, local_y = outline[:, 0], outline[:, 1]
    return np.stack([x + cos * local_x - sin * local_y, y + sin * local_x + cos * local_y], axis=-1)

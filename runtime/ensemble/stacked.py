"""Outputs by name at states of many runs at once."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import fields
from functools import cached_property
from typing import Any

import numpy as np

from ..arrays import FloatArray
from ..model.forces import Motion
from ..model.model import Model
from ..model.points import GROUND, link_of, turned
from ..record.in_force import APART
from ..record.outputs import Output, States

SAME = frozenset(
    (
        "data",
        "links",
        "joints",
        "contacts",
        "stops",
        "slide_ends",
        "q_names",
        "u_names",
        "told",
        "told_links",
        "core",
        "second_links",
        "rows",
        "points",
    )
)
"""What is the same of a model whatever its parameters are."""


class WantsRun(Exception):
    """An output that follows from a whole run, as impulses do, and not from states of it."""


class WantsParameters(Exception):
    """An output that follows from values of parameters beside the states."""


class Named:
    """A model whose parameters vary from state to state: what hangs on them is not to be asked."""

    def __init__(self, model: Model) -> None:
        self._model = model

    def __getattr__(self, name: str) -> Any:
        if name not in SAME:
            raise WantsParameters(name)
        return getattr(self._model, name)


class Stack(States):
    """States (n,) of runs of one model, with the accelerations and forces there where they are known."""

    def __init__(
        self, model: Any, t: FloatArray, q: FloatArray, u: FloatArray, forces: Mapping[str, FloatArray] | None
    ) -> None:
        super().__init__(model, t, q, u)
        self.forces = forces

    @cached_property
    def motion(self) -> Motion:
        assert self.forces is not None
        return motion_from(self.model, self.forces)

    @property
    def run(self) -> Any:
        raise WantsRun


class Apart(Stack):
    """States of runs with other parameters each: where links are and how they move has been worked out with them."""

    def __init__(
        self,
        model: Model,
        t: FloatArray,
        q: FloatArray,
        u: FloatArray,
        places: Mapping[str, FloatArray],
        forces: Mapping[str, FloatArray] | None,
    ) -> None:
        super().__init__(Named(model), t, q, u, forces)
        self.named, self.places = model, places

    @cached_property
    def poses(self) -> FloatArray:
        return self.places["pose"].reshape(len(self.t), len(self.named.links), 3)

    @cached_property
    def velocities(self) -> FloatArray:
        return self.places["velocity"].reshape(len(self.t), len(self.named.links), 3)

    @cached_property
    def energies(self) -> tuple[FloatArray, FloatArray]:
        return self.places["energy"][:, 0], self.places["energy"][:, 1]

    @cached_property
    def gaps(self) -> FloatArray:
        return np.where(self.places["gap"] == APART, np.nan, self.places["gap"])

    @cached_property
    def gap_rates(self) -> FloatArray:
        return np.where(self.places["gap"] == APART, np.nan, self.places["gap_rate"])

    def place(self, point: str) -> FloatArray:
        name = self.named.data["welded_points"].get(point, point)
        if name not in self.named.points:
            raise WantsParameters(point)
        number = self.named.points.index(name)
        return self.places["point"][:, 2 * number : 2 * number + 2]

    def velocity(self, point: str) -> FloatArray:
        link = link_of(self.named, point)
        place = self.place(point)
        if link == GROUND:
            return np.zeros_like(place)
        arms = place - self.poses[:, link, :2]
        return np.asarray(self.velocities[:, link, :2] + turned(arms) * self.velocities[:, link, 2:])

    def acceleration(self, point: str) -> FloatArray:
        raise WantsParameters(point)


def motion_from(model: Any, forces: Mapping[str, FloatArray]) -> Motion:
    """The motion of n states from what the core has written of each."""
    count = len(forces["u_dot"])
    return Motion(
        forces["u_dot"],
        forces["multipliers"][:, : len(model.rows)],
        forces["push"].reshape(count, 2, len(model.contacts)).transpose(0, 2, 1),
        forces["reaction"].reshape(count, len(model.joints), 3),
        forces["told"],
    )


def _no_motion(m: Any) -> Motion:
    """Of one state."""
    counts = ((len(m.u_names),), (len(m.rows),), (len(m.contacts), 2), (len(m.joints), 3), (len(m.told),))
    assert len(counts) == len(fields(Motion))
    return Motion(*(np.zeros((1, *shape)) for shape in counts))


class _Asking(Stack):
    """One state that notes whether forces are asked for."""

    asked = False

    @cached_property
    def motion(self) -> Motion:
        self.asked = True
        return _no_motion(self.model)


class _AskingApart(Apart):
    """One state of which no parameters are known."""

    @cached_property
    def motion(self) -> Motion:
        return _no_motion(self.named)


def wants_forces(model: Model, output: Output) -> bool:
    """Whether an output follows from accelerations or forces. Raises :class:`WantsRun`."""
    q, u = (np.array(part[None]) for part in model.start())
    asking = _Asking(model, np.zeros(1), q, u, None)
    output.of(asking)
    return asking.asked


def wants_parameters(model: Model, output: Output) -> bool:
    """Whether an output follows from values of parameters beside what is known of states apart."""
    q, u = (np.array(part[None]) for part in model.start())
    shapes = {"pose": 3 * len(model.links), "point": 2 * len(model.points), "gap": len(model.contacts), "energy": 2}
    shapes |= {"velocity": shapes["pose"], "gap_rate": shapes["gap"]}
    places = {key: np.zeros((1, count)) for key, count in shapes.items()}
    try:
        output.of(_AskingApart(model, np.zeros(1), q, u, places, None))
    except WantsParameters:
        return True
    return False

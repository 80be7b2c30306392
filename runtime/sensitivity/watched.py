"""What events of the scene and joints that let go or take hold watch, and by what the instants move at which they come
(docs/theory.md, eq. 11.12)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from ..arrays import FloatArray
from ..model.derivatives import under_inputs
from ..model.directions import directions_of
from ..model.forces import Held, motion_of
from ..model.model import Model
from ..model.thresholds import characteristic_time
from ..record.event import Event
from ..record.impact import Impact
from ..record.joint_change import JointChange
from .held import accelerations
from .local import Local, at_one
from .moving import Moving, whole_of
from .passing import MEET, RESTS, SLOW, Check
from .striking import UNDECIDED

ALL = ("q", "u", "k", "t")


class Cause(NamedTuple):
    """What brings an event, or the change of a joint, of this ``name``: an indicator of the model, by its ``number``;
    or the force in a ``joint``, by its number, -1: none, as it comes to its ``limit`` (N)."""

    name: str
    number: int
    joint: int = -1
    limit: float = 0.0


class Watched(NamedTuple):
    """What is watched at an instant: ``values`` (causes,), what these move by along all directions and the time, ``by``
    (causes, D + 1), and their ``rates`` (causes,) per second with what such rates are sums of, and what they are to be
    compared with, ``terms`` and ``sizes``."""

    values: FloatArray
    by: FloatArray
    rates: FloatArray
    terms: FloatArray
    sizes: FloatArray


def changes_of(model: Model) -> Sequence[Mapping[str, Any]]:
    """What a model's data say of its joints that let go and take hold."""
    said: Sequence[Mapping[str, Any]] = (model.data.get("switching") or {}).get("changes", ())
    return said


def events_of(model: Model) -> Sequence[Mapping[str, Any]]:
    """What a model's data say of its events."""
    said: Sequence[Mapping[str, Any]] = model.data.get("events", ())
    return said


def causes_of(
    model: Model, where: str, events: Sequence[Event], joints: Sequence[JointChange], impacts: Sequence[Impact]
) -> list[Cause]:
    """What has brought ``events`` and changes of ``joints`` at one instant, but impulses of the ``impacts`` there: what
    these break lets go whenever they come.

    Raises ``ValueError`` where an impulse is that of a limit, to rounding.
    """
    names = [one["name"] for one in events_of(model)]
    found = [Cause(event.name, names.index(event.name)) for event in events]
    for change in joints:
        said, joint = changes_of(model)[change.number], model.joints.index(change.joint)
        if said["impulse"] is not None:
            largest = max((float(np.hypot(*one.reactions[joint, :2])) for one in impacts), default=0.0)
            if abs(largest - said["impulse"]) <= UNDECIDED * said["impulse"]:
                raise ValueError(
                    f"{where}, where the impulse in {change.joint} is its limit to rounding: whether it lets go is "
                    "undecided; end the run before it"
                )
            if largest > said["impulse"]:
                continue
        by_force = said["force"] is not None
        limit = (joint, said["force"]) if by_force else (-1, 0.0)
        found.append(Cause(change.joint, len(names) + change.number, *limit))
    return found


def timed(model: Model, moving: Moving, t: float, q: FloatArray) -> Local:
    """A configuration whose directions have the time behind them."""
    directions = directions_of(model, ("q", "u", *moving.arguments, "t"))
    return at_one(model, replace(moving, directions=directions), t, q)


def watched(
    model: Model, moving: Moving, t: float, q: FloatArray, u: FloatArray, held: Held, causes: Sequence[Cause]
) -> Watched:
    """What has brought ``causes`` in a state, and its rates by the accelerations with what is ``held`` there."""
    n, per = len(q), characteristic_time(model)
    count = len(events_of(model)) + len(changes_of(model))
    every = timed(model, moving, t, q).tangent("indicators", count, u, ALL)
    by = np.array([_force_moves(model, moving, t, q, u, one) if one.limit else every[one.number] for one in causes])
    u_dot = accelerations(model, held, np.array([t]), q[None], np.ascontiguousarray(u[None]))[0][0]
    along, unit = np.concatenate([u, u_dot, [1.0]]), model.coordinate_units
    by_state = np.column_stack([by[:, : 2 * n], by[:, -1]])
    usual = np.concatenate([unit / per, unit / per**2, [1.0]])
    terms = np.abs(by_state) @ np.abs(along)
    return Watched(values(model, t, q, u, causes), by, by_state @ along, terms, np.abs(by_state) @ usual)


def values(model: Model, t: float, q: FloatArray, u: FloatArray, causes: Sequence[Cause]) -> FloatArray:
    """What has brought ``causes``, (causes,), in a state; forces are those in flight."""
    state = np.array([t]), q[None], np.ascontiguousarray(u[None])
    found, _, _ = model.kernels.indicators(*state)
    return np.array([_force(model, t, q, u, one) if one.limit else float(found[0, one.number]) for one in causes])


def _force(model: Model, t: float, q: FloatArray, u: FloatArray, cause: Cause) -> float:
    """By how much the force in a joint is above its limit (N)."""
    return float(np.hypot(*_reaction(model, t, q, u, cause.joint)) - cause.limit)


def _reaction(model: Model, t: float, q: FloatArray, u: FloatArray, joint: int) -> FloatArray:
    """The force in a joint, (2,)."""
    state = q[None], np.ascontiguousarray(u[None]), np.array([t])
    return np.asarray(motion_of(model, *state, (), reactions=True)[0].reactions[0, joint, :2])


def _force_moves(model: Model, moving: Moving, t: float, q: FloatArray, u: FloatArray, cause: Cause) -> FloatArray:
    """What the size of the force in a joint moves by along all directions and the time, (D + 1,)."""
    along = directions_of(model, ("q", "u", *moving.arguments, "t"))
    found = under_inputs(model, "reactions", q[None], np.ascontiguousarray(u[None]), np.array([t]), along)
    force = _reaction(model, t, q, u, cause.joint)
    size = float(np.hypot(*force)) or np.nan  # without a force its size has no derivative
    return np.asarray(force @ found[0, cause.joint, :2] / size)


def check_forces(where: str, held: Held, causes: Sequence[Cause]) -> None:
    """Raise ``ValueError`` where a force brings something while contacts are ``held``."""
    for cause in causes:
        if cause.limit and held:
            raise ValueError(
                f"{where}, where contacts are held, expected {cause.name} to let go in flight: forces have derivatives "
                "there alone; end the run before it"
            )


def no_instant(model: Model, seen: Watched) -> str:
    """Why the instant at which something comes has no derivative; empty where it has."""
    if not (np.isfinite(seen.by).all() and np.isfinite(seen.values).all()):
        return "where what it watches has no finite derivative, expected one; end the run before it"
    sizes = np.maximum(np.abs(seen.rates), seen.terms)
    per = characteristic_time(model)
    for value, rate, terms, usual, size in zip(seen.values, seen.rates, seen.terms, seen.sizes, sizes, strict=True):
        if abs(rate) <= max(RESTS * terms, SLOW * usual):
            return (
                f"where what it watches changes by {rate:.2g} per s, less than {SLOW:g} of what the mechanism's speeds "
                "make of it, expected a crossing: it grazes zero, and its instant has no derivative; end the run "
                "before it"
            )
        if abs(value) > MEET * per * max(size, usual):
            return (
                f"where what it watches is {value:.3g}, expected zero: it jumps over zero there, and its instant has "
                "no derivative; end the run before it"
            )
    return ""


def together(model: Model, moving: Moving, where: str, seen: Watched, trigger: int) -> Check:
    """All causes of the instant come together, whatever the column."""
    D = len(moving.directions.columns)
    dts = -seen.by[:, :D] / seen.rates[:, None]
    n = moving.states // 2
    whole_size = np.max([whole_of(model, moving, row) for row in dts[:, :n]], axis=0)

    def check(whole: FloatArray) -> None:
        apart = np.abs((dts - dts[trigger]) @ whole)
        terms = np.abs(dts) @ np.abs(whole)
        wrong = np.any(apart > MEET * (terms + MEET * whole_size), axis=0)
        if wrong.any():
            raise ValueError(
                f"{where}, which {moving.columns[int(np.argmax(wrong))]} parts: which of them comes first then depends "
                "on the sign of the change, and there is no one matrix of derivatives; leave out that column"
            )

    return check

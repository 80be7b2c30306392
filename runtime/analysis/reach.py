"""Inverse kinematics: the configuration in which points are at wanted places, and links and joints at wanted angles."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

import numpy as np
from numpy.typing import ArrayLike

from ..arrays import BoolArray, FloatArray
from ..model.assembly import nearest_closed
from ..model.model import Model, check_model
from ..precision import need_doubles
from .contacts import CLOSED
from .nearing import Nearing
from .wants import Wanted, Wants, read_wants

STARTS = 16
"""From as many configurations a reachable one is looked for, before wants are said to be out of reach."""
WITHIN = 1e-7
"""Wants that miss by less than this part of the mechanism's length, where they miss least, are met exactly."""
JUMP = 0.5
"""Joints that move farther than this (rad, lengths) are brought there in parts, so that they stay on their branch."""
SHORTEST = 1e-3
"""The least part; a way on which joints jump in less ends there."""
GOLDEN = (0.6180339887498949, 0.7548776662466927)
"""Steps of a sequence that fills all turns evenly."""


class OutOfReach(ValueError):
    """No configuration was found in which all wants are met. ``q`` is the one found in which they miss least (in the
    sense of least squares, angles over the mechanism's length); ``misses`` says by name how far each is off there, in m
    of points and lengths, in rad of angles.
    """

    def __init__(self, message: str, q: FloatArray, misses: Mapping[str, float]) -> None:
        super().__init__(message)
        self.q, self.misses = q, dict(misses)

    def __reduce__(self) -> tuple[type[OutOfReach], tuple[str, FloatArray, dict[str, float]]]:
        return OutOfReach, (str(self), self.q, self.misses)


def reach(
    model: Model,
    q: ArrayLike,
    points: Mapping[str, Sequence[float | None] | FloatArray] | None = None,
    angles: Mapping[str, float | str] | None = None,
    slides: Mapping[str, float] | None = None,
) -> FloatArray:
    """The configuration (nq,) with loops shut in which ``points`` are at places (x, y) in m, links and joints at
    ``angles`` (rad, or as "30 deg"), and sliding joints at lengths (m): the nearest to ``q`` (nq,) in joint
    displacements.

    Points are joints and named points, as ``model.point`` knows them; one of x and y may be None, which leaves it open.
    Of a link the angle is absolute, of a joint that of its second link against its first; full turns do not count.
    Where wants leave freedoms, all joints move as little as they can (least squares). Driven joints are as free as
    others. What ``q`` itself makes of the loops does not matter: they need not be shut there.

    No gap of a contact becomes negative: where a stop or a surface bars the nearest configuration, another one is
    given, near but not nearest. Newton's method with exact derivatives; where it does not get there from ``q``, from
    other configurations too. Raises ``OutOfReach``, a ``ValueError``, where wants are met in none that it finds: it
    says how far each is off where they miss least, and where that is. Raises ``ValueError`` for names that the model
    has not, and where loops cannot be closed.
    """
    check_model(model)
    need_doubles(model.precision, model.name, "inverse kinematics")
    state = configuration(model, q)
    return reached(model, state, read_wants(model, points, angles, slides))


def reached(model: Model, q: FloatArray, wants: Wants) -> FloatArray:
    """That of wants that have been read."""
    way = Nearing(model, wants)
    found = met(way, q)
    if found is not None:
        return found if way.farthest(q, found) <= JUMP else _nearer(way, q, found)
    closest = _closest(way, q)
    if way.miss(closest) <= WITHIN * model.length:
        found = met(way, q, closest)
        found = met(way, closest) if found is None else found
        if found is not None:
            return found
    raise _refusal(way, q, closest)


def _nearer(way: Nearing, q: FloatArray, found: FloatArray) -> FloatArray:
    """Of what was found at once and what is found by parts, the nearer to ``q``: Newton's steps may change branches."""
    try:
        led = by_parts(way.model, way.model.assemble(q), way.wants)
    except ValueError:  # loops cannot be closed from there
        return found
    other = None if led is None else met(way, q, led)
    if other is None or way.distance(q, found) <= way.distance(q, other):
        return found
    return other


def by_parts(model: Model, q: FloatArray, wants: Wants) -> FloatArray | None:
    """The configuration to which a closed ``q`` is led as its values go straight to those that are wanted, each step
    to the nearest and none farther than JUMP; ``None`` where it would have to jump."""
    way = -wants.differences(q)
    first, part, step = wants.values - way, 0.0, 1.0
    while part < 1.0:
        target = min(part + step, 1.0)
        nearing = Nearing(model, wants.at(first + target * way))
        found = met(nearing, q)
        if found is not None and nearing.farthest(q, found) <= JUMP:
            q, part, step = found, target, 2.0 * step
            continue
        step /= 2.0
        if step < SHORTEST:
            return None
    return q


def configuration(model: Model, q: ArrayLike) -> FloatArray:
    """One configuration (nq,). Raises ``ValueError`` for others."""
    states, single = model._batch(q, "q", len(model.q_names))
    if not single:
        raise ValueError(f"q: found shape {states.shape}, expected one configuration ({len(model.q_names)},)")
    return np.array(states[0])


def met(way: Nearing, q: FloatArray, begin: FloatArray | None = None) -> FloatArray | None:
    """The nearest configuration to ``q`` with loops shut and wants met, by the way from ``begin``; ``None`` where none
    is found, or a contact is behind its surface in it."""
    model, wants = way.model, way.wants

    def misses(x: FloatArray) -> FloatArray:
        return np.append(model.closure(x), wants.misses(x))

    def rows(x: FloatArray) -> FloatArray:
        return np.vstack([model.jacobian(x), wants.rows(x)])

    try:
        found = nearest_closed(misses, rows, way.metric, q, begin)
    except ValueError:
        return None
    found = _without_turns(model, found, q)
    return found if np.all(way.gaps(found) >= -CLOSED * model.length) else None


def _without_turns(model: Model, found: FloatArray, q: FloatArray) -> FloatArray:
    """The same configuration with angles within half a turn of those of ``q``."""
    turns = np.zeros(len(q))
    turns[list(model.angular)] = np.round((found - q)[list(model.angular)] / (2.0 * np.pi))
    return found - 2.0 * np.pi * turns if np.any(turns) else found


def _closest(way: Nearing, q: FloatArray) -> FloatArray:
    """Where wants miss least, of all that ways downhill from several starts lead to; the first that meets them."""
    best: FloatArray | None = None
    for start in _starts(way.model, q):
        found = way.least(start)
        if np.any(way.gaps(found) < -CLOSED * way.model.length):
            continue
        if best is None or way.miss(found) < way.miss(best) - 1e-12 * way.model.length:
            best = found
        if way.miss(best) <= WITHIN * way.model.length:
            break
    if best is None:
        raise ValueError(f"{way.model.name}: no configuration found from here that is outside all surfaces")
    return best


def _starts(model: Model, q: FloatArray) -> Iterator[FloatArray]:
    """``q``, then others whose angles are spread over the circle, and lengths around theirs, all closed; those from
    which loops cannot be closed are left out. Raises ``ValueError`` where that is all."""
    error: ValueError | None = None
    any_closed = False
    angular = np.isin(np.arange(len(q)), model.angular)
    base = np.arange(len(q)) < sum(kind in ("x", "y") for kind, _ in model.data["coordinates"])
    for number in range(STARTS):
        spread = np.modf((np.arange(len(q)) + 1.0) * GOLDEN[0] + number * GOLDEN[1])[0] - 0.5
        change = np.where(angular, 2.0 * np.pi * spread, 2.0 * model.length * spread)
        try:
            found = model.assemble(q + np.where(base, 0.0, change) * (number > 0))
        except ValueError as refusal:
            error = refusal
            continue
        any_closed = True
        yield found
    if not any_closed and error is not None:
        raise error


def _refusal(way: Nearing, q: FloatArray, closest: FloatArray) -> OutOfReach:
    """What misses where, as an error."""
    model, wants = way.model, way.wants
    parts = wants.parts()
    differences = wants.differences(closest)
    far = {one.name: float(np.linalg.norm(wants.misses(closest)[part])) for one, part in parts}
    least = min(WITHIN * model.length, 0.5 * max(far.values()))
    off = {one.name: float(np.linalg.norm(differences[part])) for one, part in parts}
    lines = [
        _sentence(one, wants.values[part], wants.open[part], _rounded(one.value(closest), model.length), off[one.name])
        for one, part in parts
        if far[one.name] > least
    ]
    gaps = zip(way.contacts.model.contacts, way.gaps(closest), strict=True)
    barred = [f"{point} on {ground}" for (point, ground), gap in gaps if gap <= CLOSED * model.length]
    tail = f"; {', '.join(barred)} is closed there" if barred else ""
    if len(parts) > 1:
        alone = [_alone(model, q, wants, number) for number in range(len(parts))]
        if all(alone):
            tail += "; each is within reach alone, not all together: want less, or other values"
    return OutOfReach(f"{model.name}: " + "\n".join(lines) + tail, closest, off)


def _alone(model: Model, q: FloatArray, wants: Wants, which: int) -> bool:
    way = Nearing(model, wants.alone(which))
    return way.miss(_closest(way, q)) <= WITHIN * model.length


def _rounded(values: FloatArray, length: float) -> FloatArray:
    """What is rounding beside the mechanism's ``length`` is 0."""
    return np.where(np.abs(values) <= 1e-12 * length, 0.0, values)


def _sentence(one: Wanted, values: FloatArray, left: BoolArray, nearest: FloatArray, off: float) -> str:
    wanted = ", ".join("any" if any_ else f"{x:.6g}" for x, any_ in zip(values, left, strict=True))
    found = ", ".join(f"{x:.6g}" for x in nearest)
    brackets = "({})" if len(nearest) > 1 else "{}"
    return (
        f"{one.kind}: {one.name}: found {brackets.format(wanted)} {one.unit}, expected what is within reach: the "
        f"nearest is {brackets.format(found)} {one.unit}, {off:.6g} {one.unit} away"
    )

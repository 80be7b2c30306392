"""What is wanted of a configuration: places of points, angles of links and joints, lengths of sliding joints."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..arrays import BoolArray, FloatArray
from ..faults import Faults
from ..model.joint_motion import turning
from ..model.model import Model
from ..model.numbers import read_numbers
from ..model.points import GROUND, bias, jacobian_at, link_of, turned

TEXT = re.compile(r"\s*([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)\s*(deg|rad)\s*")
"""An angle as a text, ``"30 deg"``."""


@dataclass(frozen=True)
class Place:
    """Where a point is. As all that can be wanted it has a value of so many numbers (``width``), their derivatives by u
    (``rows``), and their second derivatives in time at u̇ = 0 (``bias``), quadratic in rates u (b, nu)."""

    model: Model
    name: str
    kind: str = "points"
    unit: str = "m"

    @property
    def width(self) -> int:
        return 2

    def value(self, q: FloatArray) -> FloatArray:
        return self.model.point(self.name, q)

    def rows(self, q: FloatArray) -> FloatArray:
        return self.model.point_jacobian(self.name, q)

    def bias(self, q: FloatArray, u: FloatArray) -> FloatArray:
        return bias(self.model, np.broadcast_to(self.rows(q), (len(u), *self.rows(q).shape)), u)


@dataclass(frozen=True)
class Turn:
    """The angle of a link, or of a joint's second link against its first; linear in q."""

    model: Model
    name: str
    kind: str = "angles"
    unit: str = "rad"

    @property
    def width(self) -> int:
        return 1

    def value(self, q: FloatArray) -> FloatArray:
        if self.name in self.model.links:
            return self.model.poses(q)[self.model.links.index(self.name), 2:]
        return np.atleast_1d(self.model.joint_angles(q)[self.name])

    def rows(self, q: FloatArray) -> FloatArray:
        model, row = self.model, np.zeros((1, len(q)))
        sides = (GROUND, model.links.index(self.name)) if self.name in model.links else self._sides()
        for link, sign in zip(sides, (-1.0, 1.0), strict=True):
            row += sign * spin_row(model, link)
        return row

    def _sides(self) -> tuple[int, int]:
        first, second = self.model.data["between"][self.model.joints.index(self.name)]
        return first, second

    def bias(self, q: FloatArray, u: FloatArray) -> FloatArray:
        return np.zeros((len(u), 1))


@dataclass(frozen=True)
class Length:
    """How far a sliding joint is along its line: ``s = ŝ·d``, d going from the first link's point to the second's."""

    model: Model
    name: str
    kind: str = "slides"
    unit: str = "m"

    @property
    def width(self) -> int:
        return 1

    def value(self, q: FloatArray) -> FloatArray:
        return np.atleast_1d(self.model.slides(q)[self.name])

    def rows(self, q: FloatArray) -> FloatArray:
        along, way, spin, relative = self._line(q)
        return np.asarray(along @ relative + (turned(along) @ way) * spin)[None]

    def bias(self, q: FloatArray, u: FloatArray) -> FloatArray:
        """ŝ·d̈ + 2 ω ŝ^⊥·ḋ − ω² ŝ·d."""
        along, way, spin, relative = self._line(q)
        rates = u @ spin
        bent = bias(self.model, np.broadcast_to(relative, (len(u), *relative.shape)), u)
        return np.asarray(bent @ along + 2.0 * rates * (u @ relative.T @ turned(along)) - rates**2 * (along @ way))[
            :, None
        ]

    def _line(self, q: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
        """ŝ, d, the row of ω, and the derivatives (2, nu) of ḋ."""
        model, poses = self.model, self.model.poses(q)
        ends, links = model.lines.ends(self.name, poses), model.data["lines"][self.name]["links"]
        first, second = (jacobian_at(model, link, end[None], q[None])[0] for link, end in zip(links, ends, strict=True))
        return model.lines.direction(self.name, poses), ends[1] - ends[0], spin_row(model, links[0]), second - first


Wanted = Place | Turn | Length


def spin_row(model: Model, link: int) -> FloatArray:
    """Derivatives (nu,) of a link's angular velocity by u; zero of the ground."""
    row = np.zeros(len(model.u_names))
    if link != GROUND and (leader := model.data["leaders"][link]) != GROUND:
        row[[(kind, of) for kind, of in model.data["coordinates"]].index(("angle", leader))] = 1.0
    return row


class Wants:
    """Quantities with the values that they are to have, of numbers (k,) in all, misses of angles as lengths.

    ``open`` (k,) says which numbers are left as they come.
    """

    def __init__(self, model: Model, wanted: list[Wanted], values: FloatArray, left: BoolArray) -> None:
        self.model, self.wanted, self.values, self.open = model, wanted, values, left
        self.scale: FloatArray = np.concatenate(
            [np.full(one.width, model.length if one.unit == "rad" else 1.0) for one in wanted]
        )
        self.turns = np.concatenate([np.full(one.width, one.unit == "rad") for one in wanted])

    def at(self, values: FloatArray, left: BoolArray | None = None) -> Wants:
        """The same quantities with other values, and, where it is given, others ``left`` open."""
        return Wants(self.model, self.wanted, values, self.open if left is None else left)

    def alone(self, which: int) -> Wants:
        """One of them."""
        first = sum(one.width for one in self.wanted[:which])
        part = slice(first, first + self.wanted[which].width)
        return Wants(self.model, [self.wanted[which]], self.values[part], self.open[part])

    def differences(self, q: FloatArray) -> FloatArray:
        """What they are less what they are to be (k,), angles by the shorter way round."""
        found = np.concatenate([one.value(q) for one in self.wanted]) - self.values
        found = np.where(self.turns, np.remainder(found + np.pi, 2.0 * np.pi) - np.pi, found)
        return np.asarray(np.where(self.open, 0.0, found))

    def misses(self, q: FloatArray) -> FloatArray:
        """The same in m."""
        return self.differences(q) * self.scale

    def rows(self, q: FloatArray) -> FloatArray:
        """Derivatives of the misses by u, (k, nu), in m."""
        found = np.vstack([one.rows(q) for one in self.wanted]) * self.scale[:, None]
        return np.where(self.open[:, None], 0.0, found)

    def bias(self, q: FloatArray, u: FloatArray) -> FloatArray:
        """Second derivatives of the misses at u̇ = 0, (b, k), for rates u (b, nu)."""
        found = np.hstack([one.bias(q, u) for one in self.wanted]) * self.scale
        return np.where(self.open, 0.0, found)

    def parts(self) -> list[tuple[Wanted, slice]]:
        """Each with its numbers."""
        ends = np.cumsum([0, *(one.width for one in self.wanted)])
        return [(one, slice(int(a), int(b))) for one, a, b in zip(self.wanted, ends[:-1], ends[1:], strict=True)]


def read_wanted(
    model: Model,
    points: Mapping[str, Any] | None,
    angles: Mapping[str, Any] | None,
    slides: Mapping[str, Any] | None,
    faults: Faults,
) -> list[tuple[Wanted, Any]]:
    """The quantities that these arguments name, each with what was given for it; names that the model has not are
    noted among the ``faults``."""
    found: list[tuple[Wanted, Any]] = []
    lines = model.data["lines"]
    turns = [*model.links, *turning(model)]
    for what, given in (("points", points), ("angles", angles), ("slides", slides)):
        if given is not None and not isinstance(given, Mapping):
            faults.add(f"{what}: found {type(given).__name__}, expected a mapping by name")
    faults.stop_if_any()
    for name, value in (points or {}).items():
        with faults.collecting():
            found.append((_place(model, name), value))
    for name, value in (angles or {}).items():
        if name not in turns:
            faults.add(f"angles: found {name!r}, expected a link, or a joint that turns, of: {', '.join(turns)}")
        elif turns.count(name) > 1:
            faults.add(f"angles: found {name!r}, which is a link and a joint, expected a name of one; rename one")
        else:
            found.append((Turn(model, name), value))
    for name, value in (slides or {}).items():
        if name not in lines:
            faults.add(f"slides: found {name!r}, expected a sliding joint of: {', '.join(lines) or 'none'}")
        else:
            found.append((Length(model, name), value))
    if not found and not faults:
        faults.add("points, angles, slides: found nothing wanted, expected at least one; or use model.assemble(q)")
    return found


def _place(model: Model, name: str) -> Place:
    """The place of a point that moves. Raises ``TypeError`` and ``ValueError`` for what is none."""
    try:
        model.point(name, np.zeros(len(model.q_names)))
    except (TypeError, ValueError) as error:
        raise type(error)(f"points: {error}") from None
    if link_of(model, name) == GROUND:
        raise ValueError(f"points: found {name!r}, which is on the ground, expected a point that moves")
    return Place(model, name)


def read_wants(
    model: Model, points: Mapping[str, Any] | None, angles: Mapping[str, Any] | None, slides: Mapping[str, Any] | None
) -> Wants:
    """Wants of one configuration: a point's (x, y), where one of the two may be None; an angle or a length."""
    faults, values, left = Faults(), [], []
    named = read_wanted(model, points, angles, slides, faults)
    for one, given in named:
        with faults.collecting():
            number = _numbers(one, given)
            values.append(np.where(np.isnan(number), 0.0, number))
            left.append(np.isnan(number))
    faults.stop_if_any()
    return Wants(model, [one for one, _ in named], np.concatenate(values), np.concatenate(left))


def _numbers(one: Wanted, given: Any) -> FloatArray:
    """What is wanted of it as numbers (width,), of what is left open not a number."""
    what = f"{one.kind}: {one.name}"
    if one.width == 2:
        pair = list(given) if isinstance(given, list | tuple | np.ndarray) else [given]
        if len(pair) != 2 or all(x is None for x in pair):
            raise ValueError(f"{what}: found {given!r}, expected (x, y) in m, of which one may be None")
        return np.array([math.nan if x is None else _finite(x, what) for x in pair])
    if isinstance(given, str) and one.unit == "rad" and (match := TEXT.fullmatch(given)):
        number = float(match[1])
        return np.array([math.radians(number) if match[2] == "deg" else number])
    if isinstance(given, str):
        raise ValueError(
            f"{what}: found {given!r}, expected a number of {one.unit}" + ' or a text as "30 deg"' * (one.unit == "rad")
        )
    return np.array([_finite(given, what)])


def _finite(given: Any, what: str) -> float:
    found = read_numbers(given, what)
    if found.shape != () or not math.isfinite(found):
        raise ValueError(f"{what}: found {given!r}, expected a finite number")
    return float(found)

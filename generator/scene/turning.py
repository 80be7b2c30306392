"""What becomes of a part's numbers where it is mirrored, turned and moved: of link frames, joints, starts and effects.

A mirror exchanges left and right of the plane, and turns y round in the frame of every link of the part; links outside
of the part, to which it is joined, keep theirs. So an angle θ of a link becomes σθ + β, with σ = -1 and β = α + π in a
mirror and σ = 1 and β = α otherwise, where α is the angle of the place. A joint's angle φ, that of the second link
against the first, becomes σφ + β where the first is outside, σφ - β where the second is, and σφ where none is.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass
from functools import partial
from typing import Any

from ..effect_base.arithmetic import ExpressionError
from ..effect_base.effect import Turns
from ..effect_base.written_numbers import read_quantity

_SPOTS = {"rod": "between", "plate": "corners", "disc": "centre", "point_mass": "at"}
"""Keys of a link's bodies that say where they are."""


@dataclass(frozen=True)
class Sides:
    """Which sides of a joint belong to the part; whether it turns and does nothing else, so that what acts there is a
    moment; and whether it turns at all, so that what is given there is an angle."""

    first: bool
    second: bool
    turns: bool = True
    has_angle: bool = True


@dataclass(frozen=True)
class Turning:
    """How a part is put in its place: mirrored or not, turned by ``angle`` (rad), moved to ``at`` (m)."""

    mirror: bool
    angle: float
    at: tuple[float, float]

    @property
    def nothing(self) -> bool:
        """Whether angles and sides stay as they are."""
        return not self.mirror and not self.angle

    @property
    def sign(self) -> float:
        """σ."""
        return -1.0 if self.mirror else 1.0

    @property
    def shift(self) -> float:
        """β, rad."""
        return self.angle + (math.pi if self.mirror else 0.0)

    def link(self, table: Mapping[str, Any]) -> dict[str, Any]:
        """A ``[[link]]``: its points, its mass centre and its bodies, in its frame."""
        found = dict(table)
        if not self.mirror:
            return found
        if isinstance(points := table.get("points"), Mapping):
            found["points"] = {key: _mirrored(place) for key, place in points.items()}
        for key in ("com", "outline"):
            if key in table:
                found[key] = _mirrored(table[key]) if key == "com" else _each(table[key])
        if "around" in table:
            circles = table["around"]
            found["around"] = [_circle(one) for one in circles] if isinstance(circles, list) else _circle(circles)
        for kind, key in _SPOTS.items():
            if kind in table:
                bodies = table[kind]
                found[kind] = [_body(one, key) for one in bodies] if isinstance(bodies, list) else _body(bodies, key)
        return found

    def joint(self, table: Mapping[str, Any], sides: Sides) -> dict[str, Any]:
        """A ``[[joint]]``: the line in the first link's frame, and the second link's angle against the first."""
        found = dict(table)
        axis = table.get("axis")
        if isinstance(axis, list) and len(axis) == 2:
            found["axis"] = (_mirrored(axis) if self.mirror else axis) if sides.first else self._turned(axis)
        elif axis is not None:
            found["axis"] = times_plus(axis, self.sign, 0.0 if sides.first else self.shift)
        if table.get("type") in ("prismatic", "weld") and not (self.nothing or sides.first == sides.second):
            found.setdefault("angle", 0.0)
        if "angle" in found:
            found["angle"] = self._joint_angle(found["angle"], sides)
        return found

    def effect(
        self, table: Mapping[str, Any], turned: Mapping[str, Turns], sides: Sides | None, seen: Collection[str] = ()
    ) -> dict[str, Any]:
        """A table of an effect, by what its registration says of its keys; ``sides`` are those of its joint, if that
        is the part's, ``seen`` the keys of vectors of the state, which are seen from the part, as the state is."""
        found = dict(table)
        limits = {kind: key for key, kind in turned.items()}
        for key, kind in turned.items():
            if kind == "sense" and self.mirror and isinstance(table.get(key, False), bool):
                found[key] = not table.get(key, False)
            if key not in table or kind == "sense" or (kind != "vector" and "joint" in table and sides is None):
                continue
            value, turns = table[key], sides is None or sides.turns
            if kind == "vector":
                if table.get("frame") == "link":
                    found[key] = _mirrored(value) if self.mirror else value
                elif key in seen:
                    found[key] = self._turned(value)
            elif kind == "moment":
                found[key] = _in_rows(value, lambda one: times_plus(one, self.sign, 0.0)) if turns else value
            elif sides is not None and sides.has_angle:
                other = (
                    limits["highest angle" if kind == "lowest angle" else "lowest angle"] if kind != "angle" else key
                )
                if other != key and self.mirror and other not in table:
                    del found[key]
                found[other if self.mirror else key] = _in_rows(value, partial(self._joint_angle, sides=sides))
        return found

    def place(self, place: Any) -> Any:
        """A place [x, y] (m) in the plane, as of the ground's points and drawn joints."""
        if not isinstance(place, list) or len(place) != 2 or (self.nothing and self.at == (0.0, 0.0)):
            return place
        x, y = self._turned(place)
        return [times_plus(x, 1.0, self.at[0]), times_plus(y, 1.0, self.at[1])]

    def pose(self, pose: Any) -> Any:
        """A place and an angle of a link's frame, [x, y, θ]."""
        if not isinstance(pose, list) or len(pose) != 3:
            return pose
        return [*self.place(pose[:2]), self.link_angle(pose[2])]

    def link_angle(self, angle: Any) -> Any:
        """The angle of a link of the part in the plane."""
        return times_plus(angle, self.sign, self.shift)

    def rate(self, rate: Any) -> Any:
        """The angular velocity of a link of the part."""
        return times_plus(rate, self.sign, 0.0)

    def _joint_angle(self, angle: Any, sides: Sides) -> Any:
        if sides.first == sides.second:
            return times_plus(angle, self.sign if sides.first else 1.0, 0.0)
        return times_plus(angle, self.sign, -self.shift if sides.first else self.shift)

    def _turned(self, vector: list[Any]) -> list[Any]:
        """A vector in the plane; right angles leave it free of rounding."""
        x, y = times_plus(vector[0], self.sign, 0.0), vector[1]
        cos, sin = cos_sin(self.angle)
        return [_sum(x, cos, y, -sin), _sum(x, sin, y, cos)]


def cos_sin(angle: float) -> tuple[float, float]:
    """cos and sin (rad), exactly 0 or ±1 at the doubles nearest to multiples of a right angle."""
    quarters = angle / (math.pi / 2.0)
    if quarters.is_integer() and abs(quarters) < 2.0**20:
        return ((1.0, 0.0), (0.0, 1.0), (-1.0, 0.0), (0.0, -1.0))[int(quarters) % 4]
    return math.cos(angle), math.sin(angle)


def times_plus(value: Any, factor: float, more: float) -> Any:
    """``factor``·value + ``more`` of a number as scenes write it: a number, or a text with a unit or arithmetic."""
    if (factor == 1.0 and more == 0.0) or isinstance(value, bool) or not isinstance(value, str | int | float):
        return value
    number = _number(value)
    if number is not None:
        return factor * number + more
    text = f"({value})" if factor == 1.0 else f"-({value})" if factor == -1.0 else f"{factor!r}*({value})"
    return f"{text} + {more!r}" if more else text


def _number(value: str | int | float) -> float | None:
    """The number (SI) that stands there, ``None`` of arithmetic and of what is none."""
    if not isinstance(value, str):
        return value
    try:
        return read_quantity(value, None)
    except ExpressionError:
        return None


def _sum(x: Any, a: float, y: Any, b: float) -> Any:
    """ax + by of numbers as scenes write them."""
    parts = [times_plus(one, factor, 0.0) for one, factor in ((x, a), (y, b)) if factor and one not in (0, "0")]
    if len(parts) < 2:
        return parts[0] if parts else 0.0
    if all(isinstance(part, int | float) for part in parts):
        return parts[0] + parts[1]
    return " + ".join(f"({part})" if isinstance(part, str) else repr(part) for part in parts)


def _mirrored(place: Any) -> Any:
    """[x, y] of a link's frame; anything else, as a point's name, stays."""
    if isinstance(place, list) and len(place) == 2:
        return [place[0], times_plus(place[1], -1.0, 0.0)]
    return place


def _each(places: Any) -> Any:
    return [_mirrored(place) for place in places] if isinstance(places, list) else places


def _circle(table: Any) -> Any:
    """Points round a circle, [radius, angle], mirrored: so is the way round."""
    if not isinstance(table, Mapping):
        return table
    clockwise = table.get("clockwise", False)
    found = {**table, "clockwise": not clockwise} if isinstance(clockwise, bool) else {**table}
    if isinstance(points := table.get("points"), Mapping):
        found["points"] = {
            key: [place[0], times_plus(place[1], -1.0, 0.0)] if isinstance(place, list) and len(place) == 2 else place
            for key, place in points.items()
        }
    if "centre" in table:
        found["centre"] = _mirrored(table["centre"])
    return found


def _body(table: Any, key: str) -> Any:
    if not isinstance(table, Mapping) or key not in table:
        return table
    return {**table, key: _each(table[key]) if key in ("between", "corners") else _mirrored(table[key])}


def _in_rows(value: Any, turned: Callable[[Any], Any]) -> Any:
    """What is ``turned``: a value, or those in rows [t, value], or in a table that has ``rows``."""
    if isinstance(value, Mapping):
        return {**value, "rows": _in_rows(value["rows"], turned)} if "rows" in value else value
    if not isinstance(value, list):
        return turned(value)
    return [[row[0], turned(row[1])] if isinstance(row, list) and len(row) == 2 else row for row in value]

"""``continue_orbit(orbit, "ball.restitution", (0.3, 0.7))``: periodic motions along a parameter, through folds.

Pseudo-arclength continuation (H. B. Keller, in: Applications of Bifurcation Theory, 1977; R. Seydel, Practical
Bifurcation and Stability Analysis, 2010, chapter 4; docs/theory.md, section 12.2).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any, Literal, NamedTuple

import numpy as np

from ..arrays import FloatArray
from ..faults import Faults
from ..model.model import Model
from .approach import Grazing, approach
from .bifurcation import Bifurcation, passed
from .corrector import Corrector, Missed, Point
from .orbit import Orbit

FIRST, LARGEST, LEAST = 0.01, 0.04, 1e-7
"""Steps along a branch, in units of the mechanism and of the range of the parameter: the first one; the largest in the
parameter alone, unless another is asked for; and that at which a branch counts as ended."""

SLANTED = 5.0
"""Where states change much with the parameter a step may be so many times the largest."""

QUICK, GROWS = 3, 1.6
"""Where Newton's method takes no more than so many steps the next step is larger by this factor."""

BENDS = 0.98
"""Cosine of the angle by which a branch may turn in one step."""

BESIDE = 1e-2
"""An impact is at the instant of the section where it is within this part of the period."""

WAYS = ("both", "up", "down")


@dataclass(frozen=True, eq=False)
class Branch:
    """Periodic motions along a ``parameter``: a curve of ``orbits``, one for each of the ``values`` (points,) in the
    order of the curve, which may turn back. ``bifurcations`` are what lies on it, ``ends`` say why it ends on either
    side, in the order of the curve."""

    parameter: str
    values: FloatArray
    orbits: tuple[Orbit, ...] = field(repr=False)
    bifurcations: tuple[Bifurcation, ...]
    ends: tuple[str, str]

    @property
    def stable(self) -> FloatArray:
        """Whether each of them is stable, (points,)."""
        return np.array([orbit.stable for orbit in self.orbits])

    @property
    def runs(self) -> int:
        """How many runs were derived."""
        return max(orbit.return_map.count for orbit in self.orbits)


def continue_orbit(
    orbit: Orbit,
    parameter: str,
    between: Sequence[float],
    *,
    way: Literal["both", "up", "down"] = "both",
    step: float = LARGEST,
    most: int = 400,
) -> Branch:
    """Follow a periodic motion along a parameter of its model, by the path of it, to the ends of a range.

    ``between`` (low, high) is the range, in the parameter's own units, in which its value now lies. ``way`` says
    whether the parameter at first grows, falls, or both one after the other. ``step`` is the largest step, a part of
    the range; ``most`` is how many points there may be on either side. The motion may be stable or not; folds are
    passed. One that was found in ``segments`` is followed in as many, whose times follow its period. Folds, flips,
    Neimark-Sacker bifurcations and branch points are located by the zeros of their test functions, and grazing, which
    ends a branch, by extrapolation.

    Raises ``ValueError`` for arguments that are wrong, all at once, and for a motion that has neighbours of the same
    value of the parameter.
    """
    if not isinstance(orbit, Orbit):
        raise TypeError(f"orbit: found {type(orbit).__name__}, expected an Orbit; find one with find_orbit")
    low, high = check_arguments(orbit, parameter, between, way, step, most)
    value = orbit.return_map.model.parameters[parameter]
    corrector = Corrector(orbit.chain, orbit.period, parameter, high - low)
    first = corrector.begin(orbit.nodes, value)
    if corrector.among_others(first):
        raise ValueError(
            f"orbit: found one of a family of periodic motions at one value of {parameter}, among which no branch is "
            "told, as where energy is kept; expected one by itself: let something damp it, or drive it"
        )
    back, forth = (Side([first], [], f"not followed, as the way asked for was {way!r}") for _ in range(2))
    limits = Limits(low, high, step, most)
    if way in ("both", "up"):
        forth = _follow(corrector, first, limits)
    if forth.closed:
        back.end = forth.end
    elif way in ("both", "down"):
        back = _follow(corrector, first._replace(tangent=-first.tangent), limits)
    points = [*reversed(back.points[1:]), *forth.points]
    shift = len(back.points) - 1
    found = [_told(parameter, one, shift - one.place) for one in reversed(back.met)]
    found += [_told(parameter, one, shift + one.place) for one in forth.met]
    return Branch(
        parameter,
        np.array([point.value for point in points]),
        tuple(point.orbit for point in points),
        tuple(found),
        (back.end, forth.end),
    )


class Limits(NamedTuple):
    """How far a branch is followed."""

    low: float
    high: float
    step: float
    most: int


class Met(NamedTuple):
    """What was met, ``place`` points from the first one."""

    kind: Any
    point: Point
    place: float
    grazing: Grazing | None = None


@dataclass
class Side:
    """One way from the first point on."""

    points: list[Point]
    met: list[Met]
    end: str
    closed: bool = False


def check_arguments(
    orbit: Orbit, parameter: str, between: Sequence[float], way: str, step: float, most: int
) -> tuple[float, float]:
    """The range. Raises ``ValueError`` with all that is wrong."""
    faults, low, high = Faults(), 0.0, 1.0
    known = orbit.return_map.model.parameters
    if parameter not in known:
        faults.add(f"parameter: found {parameter!r}, expected one of {', '.join(known) or '(there are none)'}")
    try:
        low, high = (float(one) for one in between)
    except (TypeError, ValueError):
        faults.add(f"between: found {between!r}, expected two numbers, (low, high)")
    if not -np.inf < low < high < np.inf:
        faults.add(f"between: found {between!r}, expected two finite numbers, the lower one first")
    elif parameter in known and (wrong := _refused(orbit.return_map.model, parameter, (low, high))):
        faults.add(f"between: {wrong}")
    elif parameter in known and not low <= known[parameter] <= high:
        faults.add(
            f"between: found {low:g} to {high:g}, expected a range around {known[parameter]:g}, the value of "
            f"{parameter} at which the motion was found"
        )
    if way not in WAYS:
        faults.add(f"way: found {way!r}, expected one of {', '.join(WAYS)}")
    if isinstance(step, bool) or not isinstance(step, (int, float)) or not LEAST < step <= 1.0:
        faults.add(f"step: found {step!r}, expected a number above {LEAST:g}, at most 1")
    if isinstance(most, bool) or not isinstance(most, int) or most < 1:
        faults.add(f"most: found {most!r}, expected a number of points, at least 1")
    faults.stop_if_any()
    return low, high


def _refused(model: Model, parameter: str, ends: Sequence[float]) -> str:
    """What is wrong with values that the parameter cannot have, or nothing."""
    for end in ends:
        try:
            model.with_parameters({parameter: end})
        except ValueError as error:
            return str(error)
    return ""


def _told(parameter: str, met: Met, place: float) -> Bifurcation:
    if met.grazing is None:
        return Bifurcation(met.kind, parameter, met.point.value, met.point.orbit, place)
    grazing = met.grazing
    return Bifurcation("grazing", parameter, grazing.value, met.point.orbit, place, grazing.contact, grazing.error)


def _follow(corrector: Corrector, first: Point, limits: Limits) -> Side:
    """Step by step from the first point on along its tangent."""
    side, ds = Side([first], [], f"{limits.most} points, as many as were asked for"), min(FIRST, limits.step)
    while len(side.points) <= limits.most:
        last = side.points[-1]
        reached = _at_bound(corrector, last, ds, limits)
        try:
            point = _next(corrector, last, ds) if reached is None else _on_bound(corrector, last, reached)
            found = [Met(kind, at, len(side.points) - 1 + part) for kind, at, part in passed(corrector, last, point)]
        except Missed as missed:
            grazing = approach(corrector, side.points, ds)
            if grazing is not None:
                side.points += grazing.points[:1]
                side.met.append(Met("grazing", grazing.points[-1], len(side.points) - 1.0, grazing))
                side.end = "{} on {} grazes".format(*grazing.contact) + f" at {grazing.value:.9g}"
                return side
            ds /= 2.0
            if ds < LEAST:
                side.end = _why(last, missed)
                return side
            continue
        side.met += found
        side.points.append(corrector.spread(point))
        if reached is not None:
            side.end = f"{corrector.parameter} reached {reached:g}"
            return side
        if _comes_back(side.points, ds):
            side.end, side.closed = "the branch comes back to where it began", True
            return side
        if point.steps <= QUICK:
            ds = min(GROWS * ds, SLANTED * limits.step, limits.step / max(abs(float(point.tangent[-1])), 1e-3))
    return side


def _at_bound(corrector: Corrector, last: Point, ds: float, limits: Limits) -> float | None:
    """The end of the range that the next step would pass, if it does."""
    value = corrector.value_at(last.place + ds * last.tangent)
    return limits.high if value >= limits.high else limits.low if value <= limits.low else None


def _next(corrector: Corrector, last: Point, ds: float) -> Point:
    point = corrector.point(last.place + ds * last.tangent, last.tangent, last)
    _check_neighbours(last, point)
    return point


def _on_bound(corrector: Corrector, last: Point, value: float) -> Point:
    """The point at an end of the range."""
    point = corrector.point_at(value, last)
    _check_neighbours(last, point)
    return point


def _check_neighbours(last: Point, point: Point) -> None:
    """Raise :class:`Missed` where two points are not of one branch, or too far apart on it."""
    if point.pattern != last.pattern:
        raise Missed(f"the impacts are others there, {_named(point)} instead of {_named(last)}")
    if float(point.tangent @ last.tangent) < BENDS:
        raise Missed("the branch has a corner")


def _named(point: Point) -> str:
    return ", ".join(" and ".join("{} on {}".format(*one) for one in struck) for struck in point.pattern) or "none"


def _why(last: Point, missed: Missed) -> str:
    """Why there is no next point."""
    found = f"no periodic motion was found beyond {last.value:.9g}: {missed}"
    if isinstance(last.orbit.return_map.section, float) and any(
        min(one.t, abs(part.time - one.t)) <= BESIDE * part.time
        for part in last.crossed
        for one in part.runs[0].impacts
    ):
        return f"{found}; there an impact comes to the instant of the section: begin at another phase of what drives it"
    return found


def _comes_back(points: Sequence[Point], ds: float) -> bool:
    first, last = points[0], points[-1]
    apart = float(np.linalg.norm(last.begins(last.place) - first.begins(first.place)))
    ways = [one.begins(one.tangent) for one in (first, last)]
    turned = float(ways[0] @ ways[1]) / float(np.linalg.norm(ways[0]) * np.linalg.norm(ways[1]))
    return len(points) > 4 and apart < ds and turned > BENDS

"""Motions of four-bars and slider-cranks along one branch of their closure, by one equation of one coordinate.

Links are complex numbers, and their angles closed forms of the input's angle x, in 50 digits at Chebyshev points:
smooth through a place where two branches cross, as a sign changes there. What lies between Chebyshev series tell. Then

    T = M(x) v² / 2,    M dv/dt + M' v² / 2 + V' = Q,    v = dx/dt,

with SciPy's DOP853 from corner to corner of the loads, and from impact to impact: v behind is -e v before.
What else moves with x adds to M and V; what is dragged over a rough ground adds a second equation, for its force.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any

import mpmath
import numpy as np
from numpy.polynomial import chebyshev
from scipy.integrate import solve_ivp

G = 9.81
POINTS = 128
WIDTH = 0.72
"""How far on both sides of the place the branch is known, rad of the input."""
MOST = 5
"""Impacts that are followed: bounces that come to rest have no last one."""
Load = Callable[[float, float, float], float]
"""Q(t, x, v): the work of all loads per radian of the input (N m)."""
Part = Callable[[float, float], tuple[float, float, float]]
"""What else moves with the input: its M, M' and V' at t and x."""


@dataclass(frozen=True)
class Drag:
    """A uniform rod on the output's end, or on the slider, whose tip slides on a ground ``below`` the pivots; it points
    to the ``way`` (1 or -1) of x, and a constant ``torque`` between it and that link presses it down."""

    mass: float
    length: float
    below: float
    way: int
    torque: float
    friction: float


@dataclass
class OneBranch:
    """A branch of a four-bar with links ``a``, ``b``, ``c`` between pivots ``d`` apart, or, where ``d`` is zero, of a
    slider-crank whose crank and rod have the length ``a``. It passes a place at the input's angle ``place``, a multiple
    of pi / 2; ``side`` (1 or -1) says which of the branches. ``masses`` (kg) are uniform rods and a slider."""

    a: float
    b: float
    c: float
    d: float
    place: int
    side: int
    masses: Sequence[float]
    parts: list[Part] = field(default_factory=list)
    drag: Drag | None = None
    series: list[Any] = field(init=False)

    def __post_init__(self) -> None:
        self.series = self._series() if self.d else []

    @property
    def star(self) -> float:
        """The input's angle at the place (rad)."""
        return 0.5 * np.pi * self.place

    def _series(self) -> list[Any]:
        """Chebyshev coefficients of the angles of the coupler and the output."""
        k = np.arange(POINTS)
        with mpmath.workdps(50):
            at = [mpmath.cos(mpmath.pi * (2 * int(j) + 1) / (2 * POINTS)) for j in k]
            found = [self._closed(mpmath.pi * self.place / 2 + mpmath.mpf(WIDTH) * z) for z in at]
        values = np.unwrap(np.array(found, dtype=float), axis=0)
        cosines = np.cos(np.outer(k, np.pi * (2 * k + 1) / (2 * POINTS)))
        series = 2.0 / POINTS * cosines @ values
        series[0] /= 2.0
        assert np.max(np.abs(series[-8:])) < 1e-13, "the series do not end"
        return list(series.T)

    def _closed(self, x: Any) -> tuple[Any, Any]:
        """Angles of the coupler and the output: those of a triangle on the way from the output's pivot to the input's
        pin, whose angle there is zero, or pi, at the place, and changes its sign."""
        a, b, c, d = (mpmath.mpf(one) for one in (self.a, self.b, self.c, self.d))
        star = mpmath.pi * self.place / 2
        pin = a * mpmath.expj(x)
        way = abs(pin - d)
        angle = mpmath.acos((way**2 + c**2 - b**2) / (2 * way * c))
        sign = self.side * mpmath.sign(x - star)
        folded = abs(a * mpmath.expj(star) - d) ** 2 + c**2 < b**2
        angle = mpmath.pi - sign * (mpmath.pi - angle) if folded else sign * angle
        output = mpmath.arg(pin - d) + angle
        return mpmath.arg(d + c * mpmath.expj(output) - pin), output

    def angles(self, x: float, derivative: int = 0) -> list[float]:
        """Angles of the links (rad), or a derivative of them by x."""
        own = [x, 1.0, 0.0][derivative]
        if not self.d:
            return [own, -own]
        told = (chebyshev.chebder(one, derivative) if derivative else one for one in self.series)
        at = float(np.clip((x - self.star) / WIDTH, -1.0, 1.0))  # trials of a step may be far off
        return [own, *(float(chebyshev.chebval(at, one)) / WIDTH**derivative for one in told)]

    def point(self, link: int, along: float, aside: float, x: float) -> Any:
        """Where a point of a link's frame is, and its first and second derivatives by x, as complex numbers (m)."""
        angle, first, second = (self.angles(x, k) for k in (0, 1, 2))

        def arm(i: int, z: complex) -> Any:
            turned = z * np.exp(1j * angle[i])
            return np.array([turned, 1j * first[i] * turned, (1j * second[i] - first[i] ** 2) * turned])

        if link == 2 and not self.d:
            return np.array([2.0 * self.a * np.cos(x), -2.0 * self.a * np.sin(x), -2.0 * self.a * np.cos(x)], complex)
        begin = [np.zeros(3), arm(0, self.a), np.array([self.d, 0.0, 0.0])][link]
        return begin + arm(link, along + 1j * aside)

    def masses_and_weights(self, x: float) -> tuple[float, float, float]:
        """M and its derivative by x, and that of V."""
        inertia = change = weight = 0.0
        first, second = self.angles(x, 1), self.angles(x, 2)
        for link, (mass, length) in enumerate(zip(self.masses, (self.a, self.b, self.c), strict=True)):
            p = self.point(link, length / 2.0, 0.0, x)
            inertia += mass * abs(p[1]) ** 2
            change += 2.0 * mass * (np.conj(p[1]) * p[2]).real
            weight += mass * G * p[1].imag
            if link < len(first):
                inertia += mass * length**2 / 12.0 * first[link] ** 2
                change += mass * length**2 / 6.0 * first[link] * second[link]
        return inertia, change, weight

    def dragged(self, x: float) -> tuple[list[float], list[float]]:
        """The direction of what is dragged (rad) and its two derivatives by x; and the way of its tip along the ground
        with its first (m)."""
        assert self.drag
        length, way = self.drag.length, self.drag.way
        end = self.point(2, self.c, 0.0, x)
        sine = (-self.drag.below - end[0].imag) / length
        direction = float(np.arctan2(sine, way * np.sqrt(1.0 - sine**2)))
        across = length * np.cos(direction)
        first = -end[1].imag / across
        second = (length * np.sin(direction) * first**2 - end[2].imag) / across
        tip = end[0].real + across, end[1].real - length * np.sin(direction) * first
        return [direction, float(first), float(second)], [float(one) for one in tip]

    def slides(self, x: float, v: float) -> float:
        """How fast what is dragged slides (m/s)."""
        return self.dragged(x)[1][1] * v if self.drag else 0.0

    def equations(self, t: float, x: float, v: float, load: Load, side: float = 0.0) -> tuple[Any, Any]:
        """Of dv/dt and, where something is dragged, the ground's force on it: matrix and right side. Friction is
        against sliding to that ``side``, or as it slides."""
        inertia, change, weight = np.sum([self.masses_and_weights(x), *(part(t, x) for part in self.parts)], axis=0)
        right = load(t, x, v) - change * v * v / 2.0 - weight
        if not self.drag:
            return np.array([[inertia]]), np.array([right])
        mass, half, torque = self.drag.mass, self.drag.length / 2.0, -self.drag.way * self.drag.torque
        direction, first, second = self.dragged(x)[0]
        end, arm = self.point(2, self.c, 0.0, x), half * np.exp(1j * direction)
        turns = self.angles(x, 1)[2] if self.d else 0.0  # of the link that it is on
        by_rate = end[1] + 1j * arm * first  # its centre's acceleration is that times dv/dt, and
        by_motion = (end[2] + 1j * arm * second - arm * first**2) * v * v
        push = 1j - self.drag.friction * (side or np.sign(self.slides(x, v)))  # of the ground, by its normal force
        own = mass * (2.0 * half) ** 2 / 12.0
        matrix, sides = np.zeros((2, 2)), np.zeros(2)
        for row, (moves, centre, tip) in enumerate(
            [(0.0, end[1], end[1]), (1.0, 1j * arm, 2j * arm)]  # with the input, or turned about its pin
        ):
            matrix[row] = [mass * _dot(centre, by_rate) + moves * own * first, -_dot(tip, push)]
            sides[row] = -mass * _dot(centre, by_motion + 1j * G) + moves * (torque - own * second * v * v)
        matrix[0, 0] += inertia
        sides[0] += right - torque * turns
        return matrix, sides

    def acceleration(self, t: float, x: float, v: float, load: Load, side: float = 0.0) -> float:
        return float(np.linalg.solve(*self.equations(t, x, v, load, side))[0])

    def pressing(self, t: float, x: float, v: float, load: Load) -> float:
        """The ground's force on what is dragged (N)."""
        return float(np.linalg.solve(*self.equations(t, x, v, load))[1])

    def effort(self, t: float, x: float, v: float, load: Load) -> float:
        """The torque on the input that keeps v as it is (N m)."""
        matrix, sides = self.equations(t, x, v, load)
        return float(matrix[0, 1] * sides[1] / matrix[1, 1] - sides[0] if self.drag else -sides[0])

    def run(
        self,
        x: float,
        v: float,
        until: float,
        load: Load,
        corners: Sequence[float] = (),
        gap: Callable[[float], float] | None = None,
        restitution: float = 0.0,
    ) -> Motion:
        """From x and v at t = 0, as far as the branch is known; a contact with this ``gap`` (m) strikes, and holds what
        it has stopped if that presses. Followed to the fifth impact, and what drags as long as it slides one way."""
        found, t, state = Motion(), 0.0, [x, v]
        side = float(np.sign(self.slides(x, v)))
        for end in [*sorted(corner for corner in corners if 0.0 < corner < until), until]:
            before = float(np.nextafter(end, 0.0))
            while t < end:

                def leaves(_: float, y: Any) -> float:
                    return WIDTH - abs(y[0] - self.star)

                def strikes(_: float, y: Any) -> float:
                    return 1.0 if gap is None else gap(y[0])

                def goes_on(_: float, y: Any) -> float:
                    return side * self.slides(y[0], y[1]) if self.drag else 1.0

                for event in (leaves, strikes, goes_on):
                    event.terminal, event.direction = True, -1.0  # type: ignore[attr-defined]
                piece = solve_ivp(
                    lambda t, y, last=before: [y[1], self.acceleration(min(t, last), y[0], y[1], load, side)],
                    (t, end),
                    state,
                    method="DOP853",
                    rtol=2.3e-14,
                    atol=1e-15,
                    dense_output=True,
                    events=(leaves, strikes, goes_on),
                )
                assert piece.status >= 0, piece.message
                t = float(piece.t[-1])
                found.pieces.append((t, piece.sol))
                state = piece.y[:, -1].tolist()
                if len(piece.t_events[0]) or len(piece.t_events[2]):
                    return found
                if piece.status == 1:
                    assert gap is not None
                    t, at = float(piece.t_events[1][0]), piece.y_events[1][0]
                    found.strikes.append((t, float(at[1])))
                    if len(found.strikes) == MOST:
                        return found
                    state = [float(at[0]), -restitution * float(at[1])]
                    way = gap(state[0] + 1e-6) - gap(state[0] - 1e-6)
                    if restitution == 0.0 and way * self.acceleration(t, state[0], 0.0, load) < 0.0:
                        rest = np.array(state)
                        found.pieces.append((until, lambda _, rest=rest: rest))
                        return found
        return found


def _dot(one: complex, other: complex) -> float:
    return float((np.conj(one) * other).real)


@dataclass
class Motion:
    """``pieces`` of a motion by the times at which they end, each x and v as a function of time; ``strikes`` are the
    times of impacts and v before them."""

    pieces: list[tuple[float, Any]] = field(default_factory=list)
    strikes: list[tuple[float, float]] = field(default_factory=list)

    def at(self, t: float) -> tuple[float, float]:
        """x and v, those before an impact at its time."""
        last, at_last = self.pieces[-1]
        x, v = next((one for end, one in self.pieces if t <= end), at_last)(min(t, last))
        return float(x), float(v)

"""Motions of four-bars and slider-cranks along one branch of their closure, by one equation of one coordinate.

Links are complex numbers, and their angles closed forms of the input's angle x, in 50 digits at Chebyshev points:
smooth through a place where two branches cross, as a sign changes there. What lies between Chebyshev series tell. Then

    T = M(x) v² / 2,    M dv/dt + M' v² / 2 + V' = Q,    v = dx/dt,

with SciPy's DOP853 from corner to corner of the loads, and from impact to impact: v behind is -e v before.
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
Load = Callable[[float, float, float], float]
"""Q(t, x, v): the work of all loads per radian of the input (N m)."""


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

    def acceleration(self, t: float, x: float, v: float, load: Load) -> float:
        inertia, change, weight = self.masses_and_weights(x)
        return (load(t, x, v) - change * v * v / 2.0 - weight) / inertia

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
        it has stopped if that presses."""
        found, t, state = Motion(), 0.0, [x, v]
        for end in [*sorted(corner for corner in corners if 0.0 < corner < until), until]:
            while t < end:

                def leaves(_: float, y: Any) -> float:
                    return WIDTH - abs(y[0] - self.star)

                def strikes(_: float, y: Any) -> float:
                    return 1.0 if gap is None else gap(y[0])

                for event in (leaves, strikes):
                    event.terminal, event.direction = True, -1.0  # type: ignore[attr-defined]
                piece = solve_ivp(
                    lambda t, y: [y[1], self.acceleration(t, y[0], y[1], load)],
                    (t, end),
                    state,
                    method="DOP853",
                    rtol=2.3e-14,
                    atol=1e-15,
                    dense_output=True,
                    events=(leaves, strikes),
                )
                assert piece.status >= 0, piece.message
                t = float(piece.t[-1])
                found.pieces.append((t, piece.sol))
                state = piece.y[:, -1].tolist()
                if len(piece.t_events[0]):
                    return found
                if piece.status == 1:
                    assert gap is not None
                    t, at = float(piece.t_events[1][0]), piece.y_events[1][0]
                    found.strikes.append((t, float(at[1])))
                    state = [float(at[0]), -restitution * float(at[1])]
                    way = gap(state[0] + 1e-6) - gap(state[0] - 1e-6)
                    if restitution == 0.0 and way * self.acceleration(t, state[0], 0.0, load) < 0.0:
                        rest = np.array(state)
                        found.pieces.append((until, lambda _, rest=rest: rest))
                        return found
        return found


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

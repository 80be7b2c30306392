"""Bodies in a row that move along a line and strike each other: events in numbers of many digits.

Between impacts each moves as a parabola of its own, so every time of impact is a root of a polynomial of second
degree. What strikes at the same instant strikes by Newton's law, smooth, one impact for all closed contacts that do not
open: with impulses P along the normals, 0 <= P perpendicular to N u+ + E N u- >= 0, u+ = u- + M^-1 N^T P (C. Glocker,
F. Pfeiffer, "Multiple impacts with friction in rigid multibody systems", Nonlinear Dynamics 7, 1995), solved by trying
which of them push. Nothing is brought to rest but what is slower than two thirds of the digits tell.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import product
from typing import Any

import mpmath


@dataclass
class Row:
    """Bodies of ``masses`` (kg) at ``places`` (m) that grow, with ``speeds`` (m/s), of the same ``weight`` (m/s^2).

    ``reach`` has the distance at which neighbours touch, one less than bodies, and ``restitution`` theirs. A ``wall``
    left of the first, if it is not None, is its place, speed and restitution: it goes on whatever strikes it."""

    masses: Sequence[float]
    places: Sequence[float]
    speeds: Sequence[float]
    reach: Sequence[float]
    restitution: Sequence[float]
    wall: tuple[float, float, float] | None = None
    weight: float = 0.0
    digits: int = 40
    impacts: list[tuple[Any, tuple[int, ...]]] = field(default_factory=list)
    """of the motion: its time (s) and which pairs took part, 0 being the first body with the wall"""

    def move(self, until: float, most: int = 1_000_000) -> tuple[list[float], list[float]]:
        """Places (m) and speeds (m/s) at time ``until`` (s). ``RuntimeError`` after ``most`` impacts."""
        with mpmath.workdps(self.digits):
            return self._move(mpmath.mpf(until), most)

    def _move(self, until: Any, most: int) -> tuple[list[float], list[float]]:
        number = mpmath.mpf
        x, v = [number(p) for p in self.places], [number(s) for s in self.speeds]
        w = [number(0)] if self.wall is None else [number(self.wall[0])]
        t, self.impacts[:] = number(0), []
        while True:
            gaps, rates = self._gaps(x, v, w[0])
            ahead = [self._next(i, gaps[i], rates[i]) for i in range(len(gaps))]
            step = min((a for a in ahead if a is not None), default=None)
            if step is None or t + step > until:
                step = until - t
                x, v, w = self._fly(x, v, w, step)
                return [float(p) for p in x], [float(s) for s in v]
            x, v, w = self._fly(x, v, w, step)
            t += step
            struck = self._strike(x, v, w[0])
            if struck:
                self.impacts.append((t, struck))
            if len(self.impacts) > most:
                raise RuntimeError(f"most: found more than {most} impacts until {float(t)} s")

    def _fly(self, x: list[Any], v: list[Any], w: list[Any], h: Any) -> tuple[list[Any], list[Any], list[Any]]:
        a = mpmath.mpf(self.weight)
        wall = w[0] + h * (self.wall[1] if self.wall else 0)
        return [p + h * s + a * h * h / 2 for p, s in zip(x, v, strict=True)], [s + a * h for s in v], [wall]

    def _gaps(self, x: list[Any], v: list[Any], wall: Any) -> tuple[list[Any], list[Any]]:
        """Of the wall first, if there is one"""
        gaps = [x[i + 1] - x[i] - mpmath.mpf(r) for i, r in enumerate(self.reach)]
        rates = [v[i + 1] - v[i] for i in range(len(self.reach))]
        if self.wall is None:
            return gaps, rates
        return [x[0] - wall, *gaps], [v[0] - mpmath.mpf(self.wall[1]), *rates]

    def _falls(self, i: int) -> Any:
        """Acceleration of a gap: neighbours fall alike"""
        return mpmath.mpf(self.weight if self.wall is not None and i == 0 else 0)

    def _tiny(self) -> Any:
        return mpmath.mpf(10) ** (-self.digits * 2 // 3)

    def _next(self, i: int, gap: Any, rate: Any) -> Any:
        """When a gap is closed and falling next, or None"""
        a = self._falls(i)
        if abs(gap) <= self._tiny():
            if rate < -self._tiny():
                return mpmath.mpf(0)
            return -2 * rate / a if a < 0 and rate > 0 else None
        if a == 0:
            return -gap / rate if rate < 0 else None
        inside = rate * rate - 2 * a * gap
        if inside < 0:
            return None
        root = mpmath.sqrt(inside)
        return min((h for h in ((-rate - root) / a, (-rate + root) / a) if h > 0), default=None)

    def _strike(self, x: list[Any], v: list[Any], wall: Any) -> tuple[int, ...]:
        gaps, rates = self._gaps(x, v, wall)
        tiny = self._tiny()
        closed = [i for i in range(len(gaps)) if abs(gaps[i]) <= tiny and rates[i] <= tiny]
        if not any(rates[i] < -tiny for i in closed):
            return ()
        shift = 0 if self.wall is None else 1
        e = [mpmath.mpf(r) for r in ([self.wall[2]] if self.wall else []) + list(self.restitution)]
        rows = [{i - shift: mpmath.mpf(-1), i + 1 - shift: mpmath.mpf(1)} for i in range(len(gaps))]
        rows = [{k: s for k, s in row.items() if k >= 0} for row in rows]
        m = [mpmath.mpf(mass) for mass in self.masses]
        for pushing in product((True, False), repeat=len(closed)):
            push = [i for i, yes in zip(closed, pushing, strict=True) if yes]
            P = self._impulses(rows, m, push, [-(1 + e[i]) * rates[i] for i in push])
            if any(p < -tiny for p in P):
                continue
            after = list(v)
            for i, p in zip(push, P, strict=True):
                for k, s in rows[i].items():
                    after[k] += s * p / m[k]
            left = self._gaps(x, after, wall)[1]
            if all(left[i] + e[i] * rates[i] >= -tiny for i in closed):
                v[:] = after
                return tuple(closed)
        raise AssertionError("a complementarity problem with a positive definite matrix has a solution")

    @staticmethod
    def _impulses(rows: list[dict[int, Any]], m: list[Any], push: list[int], wanted: list[Any]) -> list[Any]:
        n = len(push)
        if not n:
            return []
        W = mpmath.matrix(n, n)
        for a in range(n):
            for b in range(n):
                W[a, b] = sum(s * rows[push[b]].get(k, 0) / m[k] for k, s in rows[push[a]].items())
        found = mpmath.lu_solve(W, mpmath.matrix(wanted)) if n > 1 else [wanted[0] / W[0, 0]]
        return [found[i] for i in range(n)]

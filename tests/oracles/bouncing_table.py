"""A ball on a table that goes up and down: its map from impact to impact, exact but for the root of one equation.

The table is at A sin(w t), the ball falls freely between impacts, which reverse the relative speed by the factor e
(Guckenheimer and Holmes 1983, section 2.4; Tufillaro, Abbott and Reilly 1992, chapter 1). Nothing is approximated, as
high bounces are there. Time is counted from a passage of the table upwards through its middle.

The gap g(t) between both is a parabola less a sine. Where its second derivative is zero is known, sin(w t) = g/(A w²);
between two such instants its rate is monotonic and has one zero at most, and between those the gap is monotonic itself:
no impact can be passed over.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

ROOT = 55
"""Halvings of an interval of at most a period: to the rounding of its ends."""
LOWEST = 30
"""Halvings for the instant of an extreme, at which the gap is flat: off by 1e-9 of a period it is right to 1e-18."""
LAST = 1e-6
"""Flights of less than so much of a period, while the ball presses, are the tail of infinitely many that end."""


@dataclass(frozen=True)
class BouncingTable:
    """``gravity`` (m/s²), ``amplitude`` A (m) and ``frequency`` w (rad/s) of the table, ``restitution`` e."""

    gravity: float
    amplitude: float
    frequency: float
    restitution: float

    @property
    def period(self) -> float:
        return 2.0 * math.pi / self.frequency

    @property
    def strength(self) -> float:
        """The table's largest acceleration by gravity, A w²/g."""
        return self.amplitude * self.frequency**2 / self.gravity

    @property
    def least_strength(self) -> float:
        """Least strength of an orbit with one impact a period: the table is never fast enough below it."""
        return math.pi * (1.0 - self.restitution) / (1.0 + self.restitution)

    @property
    def stable_until(self) -> float:
        """The strength from which that orbit is no longer stable; the multipliers there pass -1."""
        e = self.restitution
        return math.hypot(self.least_strength, 2.0 * (1.0 + e**2) / (1.0 + e) ** 2)

    @property
    def phase(self) -> float:
        """At which phase w t the stable orbit with one impact a period strikes.

        It comes back after a period T with the speed g T/2 that it left with, so that g T/2 = (1 + e) w + e g T/2,
        w being the table's speed A w cos(phase)."""
        return math.acos(self.least_strength / self.strength)

    @property
    def multipliers(self) -> Array:
        """Of that orbit, (2,): roots of z² - s z + e², s = 1 + e² - (1 + e)² A w² sin(phase)/g.

        The map's derivative by the time t and the ball's speed v behind an impact, rows first t: 1 and (1 + e)/g, then
        (1 + e) a and (1 + e)² a/g + e², a = -A w² sin(phase) being the table's acceleration."""
        e = self.restitution
        trace = 1.0 + e**2 - (1.0 + e) ** 2 * self.strength * math.sin(self.phase)
        return np.roots([1.0, -trace, e**2])

    def orbit_at_middle(self) -> tuple[float, float]:
        """Gap (m) and speed of the ball (m/s) on that orbit while the table goes up through its middle."""
        since = self.period - self.phase / self.frequency
        speed = self.gravity * self.period / 2.0
        height = self.amplitude * math.sin(self.phase) + speed * since - self.gravity * since**2 / 2.0
        return height, speed - self.gravity * since

    # -- the map ------------------------------------------------------------------------------------------------------

    def table(self, t: Array) -> Array:
        return self.amplitude * np.sin(self.frequency * t)

    def table_speed(self, t: Array) -> Array:
        return self.amplitude * self.frequency * np.cos(self.frequency * t)

    def next_impact(self, t: Array, height: Array, speed: Array) -> Array:
        """When balls (n,) that are at ``height`` at t, above the table or leaving it, strike it next.

        The gap is positive behind t, since they leave, however it is rounded at t itself."""

        def gap(x: Array) -> Array:
            return np.asarray(height + speed * (x - t) - self.gravity * (x - t) ** 2 / 2.0 - self.table(x))

        def rate(x: Array) -> Array:
            return np.asarray(speed - self.gravity * (x - t) - self.table_speed(x))

        found, low, first = np.full(t.shape, np.nan), t.copy(), np.ones(t.shape, dtype=bool)
        while np.isnan(found).any():
            high = self._next_inflection(low)
            turning = halved(rate, low, high, LOWEST)  # where the rate keeps its sign, one of the ends
            for a, b in ((low, turning), (turning, high)):
                strikes = np.isnan(found) & (first | (gap(a) > 0.0)) & (gap(b) <= 0.0) & (b > a)
                if strikes.any():
                    found = np.where(strikes, halved(gap, a, b, ROOT), found)
                first = first & (b <= a)
            low = high
        return found

    def _next_inflection(self, t: Array) -> Array:
        """The first instant after t at which the table's acceleration is that of gravity; else half a period later."""
        if self.strength <= 1.0:
            return t + self.period / 2.0
        own = math.asin(1.0 / self.strength)  # the acceleration -A w² sin is -g there
        later = [(phase - self.frequency * t) % (2.0 * math.pi) for phase in (own, math.pi - own)]
        later = [np.where(one <= 1e-12, 2.0 * math.pi, one) for one in later]
        return np.asarray(t + np.minimum(*later) / self.frequency)

    def impacts(self, height: Array, speed: Array, count: int) -> tuple[Array, Array]:
        """Times of the first ``count`` impacts, and whether they end in rest on the table before, (n, count) and (n,).

        Balls (n,) begin at t = 0. Not a number from where a ball rests on: infinitely many impacts have come before."""
        t, rests = np.zeros(height.shape), np.zeros(height.shape, dtype=bool)
        times = np.full((*height.shape, count), np.nan)
        for number in range(count):
            goes = ~rests
            if not goes.any():
                break
            before, start = t[goes], speed[goes]
            now = self.next_impact(before, height[goes], start)
            table, falling = self.table_speed(now), start - self.gravity * (now - before)
            leaving = table + self.restitution * (table - falling)
            t[goes], height[goes], speed[goes] = now, self.table(now), leaving
            times[goes, number] = now
            presses = self.gravity - self.amplitude * self.frequency**2 * np.sin(self.frequency * now)
            ends = (number > 0) & (presses > 0.0) & (now - before < LAST * self.period)
            rests[np.flatnonzero(goes)[ends]] = True
        return times, rests


def halved(of: Callable[[Array], Array], low: Array, high: Array, times: int) -> Array:
    """Where a function that falls from ``low`` to ``high`` comes to zero; an end where it keeps its sign."""
    down = of(high) <= of(low)
    for _ in range(times):
        middle = (low + high) / 2.0
        beyond = (of(middle) <= 0.0) == down
        low, high = np.where(beyond, low, middle), np.where(beyond, middle, high)
    return (low + high) / 2.0

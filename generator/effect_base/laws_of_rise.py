"""Laws of a rise from rest to rest, as designers of cams have them: of a lift over an angle, of a joint over time.

R. L. Norton, Cam Design and Manufacturing Handbook, 2nd edition, 2009, chapters 3 and 4.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

if TYPE_CHECKING:
    from sympy import Expr

TURN = 2.0 * math.pi

LawOfRise = Literal["cycloidal", "3-4-5", "4-5-6-7", "harmonic", "modified-trapezoidal"]


@dataclass(frozen=True)
class Part:
    """What a law is from the share ``start`` to ``end`` of the rise, by x from there on: powers of x with their
    factors, and a sine (amplitude, frequency, phase)."""

    powers: tuple[tuple[int, float], ...]
    wave: tuple[float, float, float] = (0.0, 0.0, 0.0)
    start: float = 0.0
    end: float = 1.0

    def at(self, x: float, order: int) -> float:
        """The derivative of this order."""
        terms = ((factor * math.perm(power, order), power - order) for power, factor in self.powers if power >= order)
        size, frequency, phase = self.wave
        wave = size * frequency**order * math.sin(frequency * x + phase + order * math.pi / 2.0)
        return math.fsum(factor * x**power for factor, power in terms) + wave

    def of(self, x: Expr) -> Expr:
        """The same as an expression."""
        import sympy as sp

        found = sp.Add(*(exact(factor) * x**power for power, factor in self.powers))
        size, frequency, phase = self.wave
        return found + sp.Float(size) * sp.sin(sp.Float(frequency) * x + exact(phase)) if size else found


def exact(value: float) -> Expr:
    import sympy as sp

    return sp.Integer(int(value)) if value.is_integer() else sp.Float(value)


def _modified_trapezoidal() -> tuple[Part, ...]:
    """Accelerations rise as a quarter of a sine over an eighth of the rise, stay, and turn round as half a sine: a
    trapezium without corners. All follows from the largest one, 8π/(2 + π) of the rise over the square of its time."""
    most = 8.0 * math.pi / (2.0 + math.pi)
    wave, frequency = most / (16.0 * math.pi**2), 4.0 * math.pi
    slope, fast = most / frequency, most / frequency + most / 4.0
    first = slope / 8.0 - wave
    second = first + slope / 4.0 + most / 32.0
    third = second + fast / 4.0 + 2.0 * wave
    fourth = third + fast / 4.0 - most / 32.0
    turned = 0.5 * math.pi  # minus the cosine is the sine less a quarter turn
    return (
        Part(((1, slope),), (-wave, frequency, 0.0), 0.0, 0.125),
        Part(((0, first), (1, slope), (2, most / 2.0)), start=0.125, end=0.375),
        Part(((0, second + wave), (1, fast)), (wave, frequency, -turned), 0.375, 0.625),
        Part(((0, third), (1, fast), (2, -most / 2.0)), start=0.625, end=0.875),
        Part(((0, fourth - wave), (1, slope)), (-wave, frequency, -turned), 0.875, 1.0),
    )


LAWS: Mapping[LawOfRise, tuple[Part, ...]] = {
    "cycloidal": (Part(((1, 1.0),), (-1.0 / TURN, TURN, 0.0)),),
    "3-4-5": (Part(((3, 10.0), (4, -15.0), (5, 6.0))),),
    "4-5-6-7": (Part(((4, 35.0), (5, -84.0), (6, 70.0), (7, -20.0))),),
    "harmonic": (Part(((0, 0.5),), (0.5, math.pi, -0.5 * math.pi)),),
    "modified-trapezoidal": _modified_trapezoidal(),
}
"""By name, in parts from 0 at x = 0 to 1 at x = 1. Accelerations jump at the ends of the harmonic one, and nowhere with
the others; the next derivative but of the 4-5-6-7 polynomial's does too, of the last also where its parts meet."""

"""How long a four-bar takes for a swing, by quadrature: it has one freedom, so its energy tells its speed."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import mpmath

G = mpmath.mpf("9.81")


@dataclass(frozen=True)
class FourBar:
    """Uniform rods (m, kg): an input from O = (0, 0), a coupler, an output from (span, 0), all in gravity along -y.

    ``side`` says on which side of the line from the coupler's pin on the input to the output's pivot the coupler meets
    the output: 1 where that is to the left.
    """

    input: Any
    coupler: Any
    output: Any
    span: Any
    masses: tuple[Any, Any, Any]
    side: int

    def mirrored(self) -> FourBar:
        """The same with the output as its input, seen from behind: x becomes span - x."""
        return FourBar(self.output, self.coupler, self.input, self.span, self.masses[::-1], self.side)

    def inertia_and_potential(self, angle: Any) -> tuple[Any, Any]:
        """Twice the kinetic energy at 1 rad/s of the input (kg m²), and the potential energy (J), at its angle."""
        pin = self.input * mpmath.expj(angle)
        way = self.span - pin
        distance = abs(way)
        along = (self.coupler**2 - self.output**2 + distance**2) / (2 * distance)
        aside = self.side * mpmath.sqrt(self.coupler**2 - along**2)
        joint = pin + way / distance * mpmath.mpc(along, aside)
        phi, psi = mpmath.arg(joint - pin), mpmath.arg(joint - self.span)
        of_coupler = -self.input * mpmath.sin(angle - psi) / (self.coupler * mpmath.sin(phi - psi))
        of_output = self.input * mpmath.sin(angle - phi) / (self.output * mpmath.sin(psi - phi))
        first, second, third = self.masses
        centre = self.input * mpmath.expj(angle) + of_coupler * self.coupler * mpmath.expj(phi) / 2
        inertia = (
            first * self.input**2 / 3
            + second * (abs(centre) ** 2 + (self.coupler * of_coupler) ** 2 / 12)
            + third * (self.output * of_output) ** 2 / 3
        )
        return inertia, G * (first * pin.imag + second * (pin.imag + joint.imag) + third * joint.imag) / 2

    def duration(self, begin: Any, end: Any, rate: Any, place: Any, width: Any) -> Any:
        """Seconds from the input's angle ``begin``, at which it turns at ``rate``, to ``end``; what happens within
        ``width`` of ``place`` is looked at by intervals that double from there."""
        inertia, potential = self.inertia_and_potential(begin)
        energy = inertia * rate**2 / 2 + potential
        low, high = min(begin, end), max(begin, end)
        points, step = {low, high, place}, mpmath.mpf(width)
        while step < high - low:
            points |= {point for point in (place - step, place + step) if low < point < high}
            step *= 4

        def pace(angle: Any) -> Any:
            inertia, potential = self.inertia_and_potential(angle)
            return mpmath.sqrt(inertia / (2 * (energy - potential)))

        return mpmath.quad(pace, sorted(points))

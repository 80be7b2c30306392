"""Play: a spring with a dead zone about its rest, as of teeth with backlash, which may be damped where engaged."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING

from ..mechanism.links import Parameter

if TYPE_CHECKING:
    from sympy import Expr

    from ..derive.motion import Motion


@dataclass(frozen=True)
class DeadZone:
    """Nothing acts while a way x from rest is within half of ``play`` (rad, m) on either side; beyond, ``stiffness``
    times what it is more, and ``damping`` times its rate, as long as both together draw it back.

    ``label`` tells its kinks and symbols from those of others.
    """

    label: str
    play: Parameter
    stiffness: Parameter
    damping: Parameter | None

    def sides(self) -> tuple[str, ...]:
        """Of each way, up and down: whether it is engaged, and with damping whether it draws back."""
        kinds = ("engaged", "loaded") if self.damping else ("engaged",)
        return tuple(f"{self.label}_{way}_{kind}" for way in ("up", "down") for kind in kinds)

    def switching(self, motion: Motion, x: Expr, rate: Expr) -> tuple[Expr, ...]:
        values: list[Expr] = []
        for sign, way in self._ways():
            values.append(self._beyond(motion, sign, x))
            if self.damping:
                values.append(self._drawing(motion, sign, way, x, rate))
        return tuple(values)

    def effort(self, motion: Motion, x: Expr, rate: Expr) -> Expr:
        """The moment (N m) or force (N) that draws x back."""
        total = motion.value(None)
        for sign, way in self._ways():
            total += sign * self._acting(motion, way) * self._drawing(motion, sign, way, x, rate)
        return motion.let(f"effort_{self.label}", total)

    def potential(self, motion: Motion, x: Expr) -> Expr:
        """½ k (|x| − play/2)² beyond the play (J)."""
        total = motion.value(None)
        for sign, _ in self._ways():
            beyond = self._beyond(motion, sign, x)
            total += motion.step(beyond) * motion.value(self.stiffness) * beyond**2 / 2
        return total

    def power(self, motion: Motion, x: Expr, rate: Expr) -> Expr:
        """What damping takes (W): the power of the effort, less that of its elastic part."""
        if self.damping is None:
            return motion.value(None)
        elastic = motion.value(None)
        for sign, way in self._ways():
            engaged = motion.side(f"{self.label}_{way}_engaged")
            elastic += sign * engaged * motion.value(self.stiffness) * self._beyond(motion, sign, x)
        return (elastic - self.effort(motion, x, rate)) * rate

    @staticmethod
    def _ways() -> Iterator[tuple[int, str]]:
        yield from ((1, "up"), (-1, "down"))

    def _acting(self, motion: Motion, way: str) -> Expr:
        engaged = motion.side(f"{self.label}_{way}_engaged")
        return engaged * motion.side(f"{self.label}_{way}_loaded") if self.damping else engaged

    def _beyond(self, motion: Motion, sign: int, x: Expr) -> Expr:
        return sign * x - motion.value(self.play) / 2

    def _drawing(self, motion: Motion, sign: int, way: str, x: Expr, rate: Expr) -> Expr:
        """k (σ x − play/2) + c σ dx/dt, whether it acts or not."""
        elastic = motion.value(self.stiffness) * self._beyond(motion, sign, x)
        return motion.let(f"strain_{self.label}_{way}", elastic + sign * motion.value(self.damping) * rate)

"""What the derivation asks of an effect."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Protocol

import sympy as sp

from ..mechanism.links import Parameter
from .gaps import Gap
from .motion import Couple, Force, Motion, Stands
from .vectors import Vector

Let = Callable[[str, sp.Expr], sp.Expr]
Told = tuple[str, str, sp.Expr] | tuple[str, str, sp.Expr, int]
"""What is asked of an effect, as ``torque``, or nothing where its name says it all, its unit, and the value; the number
of the link that a force acts on, where its name does not have it."""


class Terms(Protocol):
    """What the derivation asks of an effect. An effect that has nothing to say returns zero or nothing."""

    @property
    def title(self) -> str:
        """What the effect is called in a listing."""
        ...

    def parameters(self) -> tuple[Parameter, ...]: ...

    def field(self) -> Vector:
        """Uniform acceleration field (m/s²)."""
        ...

    def inputs(self) -> tuple[str, ...]:
        """Names of inputs that are given at run time."""
        ...

    def defines(self) -> Mapping[str, Stands]:
        """Names that expressions may have, each with what it stands for."""
        ...

    def sides(self) -> tuple[str, ...]:
        """Names of the kinks of its loads."""
        ...

    def switching(self, motion: Motion) -> Sequence[sp.Expr]:
        """Functions whose signs tell on which sides of them the loads are."""
        ...

    def latches(self) -> tuple[tuple[str, str], ...]:
        """Names of values that it holds, and of the kink that sets each."""
        ...

    def latching(self, motion: Motion) -> Sequence[sp.Expr]:
        """Those values where they are set."""
        ...

    def reaches(self, motion: Motion) -> Sequence[Vector]:
        """Vectors (m) that its loads have the direction of."""
        ...

    def loads(self, motion: Motion) -> Sequence[Force | Couple]:
        """Forces and moments on links; inputs and time are expressions of ``motion``."""
        ...

    def potential(self, motion: Motion) -> sp.Expr:
        """Potential energy (J) of those loads that have one; zero for the rest."""
        ...

    def drives(self, motion: Motion) -> Sequence[tuple[int, sp.Expr]]:
        """Joints whose motion is prescribed, each with its acceleration (rad/s², or m/s² along its line)."""
        ...

    def power(self, motion: Motion) -> sp.Expr:
        """Power (W) of those loads that have no potential."""
        ...

    def outputs(self, motion: Motion) -> Sequence[Told]:
        """Numbers that runs tell of it by name."""
        ...

    def gaps(self, let: Let) -> tuple[Gap, ...]:
        """What may touch what; ``let`` names what depends on parameters alone."""
        ...


def laws_of(effects: Sequence[Terms]) -> dict[str, Stands]:
    """The laws of effects by their names."""
    return {name: law for effect in effects for name, law in effect.defines().items()}

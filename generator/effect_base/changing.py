"""What a scene may give in place of a number: values that change as a run goes on."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import TYPE_CHECKING, ClassVar

if TYPE_CHECKING:
    from sympy import Expr

    from ..derive.motion import Motion


class Changing(ABC):
    """A value that changes in a run, with time alone, or ``of_state`` too. Its own numbers are not parameters."""

    of_state: ClassVar[bool] = False

    @property
    @abstractmethod
    def shown(self) -> str:
        """What it is, in words or as it is written."""

    @property
    def told(self) -> str:
        """The same behind the words that it is given over time."""
        return f"and by the state: {self.shown}" if self.of_state else self.shown

    @abstractmethod
    def realise(self, motion: Motion, name: str) -> Expr:
        """The value in the equations; its parts are named ``name_1``, ``name_2``, … there."""

    def kinks(self) -> tuple[tuple[float, float], ...]:
        """Times (s) at which steps end, so that they keep their order, each with the time after which it comes again, 0
        where it does not."""
        return ()

"""The order of elimination: for every link, what goes from its form, in order (theory, section 4.13)."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from ..equations.names import Variable

Pivot = tuple[Variable, ...]
"""Variables that go at once: one angular acceleration, the one or two multipliers of a cut joint, the acceleration
along a line, the acceleration of a segment's inboard point, or a dyad: the angular accelerations of two links and the
two multipliers of the pin between them."""


@dataclass(frozen=True)
class Plan:
    """``pivots[link]`` go from the form of ``link`` (of the ground, ``GROUND``) in this order, from the tips to the
    root.

    Angular accelerations are those of ``turn(k)``, at link k itself too. What is in no pivot of its own link stays
    open: it is handed on with the link's form until a link nearer to the root eliminates it. The acceleration of a
    floating root goes last, and is not listed. ``name`` says which of the portfolio's plans this is. ``otherwise`` is
    the plan to go to where a guard of this one fails; without one, the runtime solves such a state on its robust path.
    ``modules`` are sets of links whose equations run side by side as far as they are equal. ``severed`` links begin
    segments: the joint to their parent is cut open as well, so that their inboard points accelerate by themselves. What
    is left of a segment's form, over the multipliers at its ends (theory, eq. 4.18), goes to the root.
    """

    name: str
    pivots: Mapping[int, tuple[Pivot, ...]]
    otherwise: Plan | None = None
    modules: tuple[tuple[int, ...], ...] = ()
    severed: tuple[int, ...] = ()

    def at(self, link: int) -> tuple[Pivot, ...]:
        """What goes from the form of ``link``."""
        return self.pivots.get(link, ())


def is_dyad(pivot: Pivot) -> bool:
    """Whether a pivot closes a dyad: its rows alone give its angular accelerations."""
    return len(pivot) == 4


def is_closure(pivot: Pivot) -> bool:
    """Whether a pivot is multipliers alone."""
    return pivot[0].kind == "lambda"

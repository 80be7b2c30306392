"""Touch: a disc on one link that touches a disc, or an edge, of another: only pairs that a scene lists."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from pydantic import Field

from ..effect_base.contact import DEPTH, LAW_MEANS, Friction, Law, Restitution
from ..effect_base.effect import Complain, ContactPoint, Effect, Entry, Place, Rim, Surroundings
from ..effect_base.pair import Pair, PairTable, read_pair
from ..mechanism.links import FROM_0_TO_1, NOT_NEGATIVE, Parameter
from ..mechanism.mechanism import Mechanism

if TYPE_CHECKING:
    from ..derive.gaps import Gap
    from ..derive.terms_of_effects import Let


class TouchTable(PairTable):
    """One ``[[touch]]``."""

    restitution: Restitution = Field(description="the coefficient of restitution, a number from 0 to 1")
    friction: Friction | None = Field(default=None, description="Coulomb's coefficient of friction, a positive number")
    law: Law | None = Field(default=None, description=LAW_MEANS)


@dataclass(frozen=True)
class Touch(Effect):
    """Keeps the two of a ``pair`` out of each other, with ``restitution`` (0 to 1) and ``friction``."""

    index: int
    name: str
    pair: Pair
    restitution: Parameter
    friction: Parameter | None = None

    def parameters(self) -> tuple[Parameter, ...]:
        return (*self.pair.parameters(), self.restitution, *((self.friction,) if self.friction else ()))

    def describe(self, mechanism: Mechanism) -> str:
        return f"{self.pair.title}, {super().describe(mechanism)}"

    def gaps(self, let: Let) -> tuple[Gap, ...]:
        """One gap, called after the disc's centre and the touch."""
        from ..derive.vectors import symbol

        label = f"touch_{self.index}"
        return (self.pair.gap(let, self.name, label, symbol(self.restitution), symbol(self.friction)),)

    def rims(self) -> tuple[Rim, ...]:
        return self.pair.rims()

    def contact_points(self) -> tuple[ContactPoint, ...]:
        disc, other = self.pair.disc, self.pair.other
        discs = (disc, other) if other.end is None else (disc,)
        return tuple((body.title, self.name, body.start, body.radius) for body in discs)

    def check_start(self, place: Place) -> tuple[str, ...]:
        depth = self.pair.depth(place)
        if depth <= DEPTH:
            return ()
        return (
            f"the start has {self.pair.disc.title} inside {self.pair.other.title} by {depth:.6g} m, expected at or off "
            "its surface; change the start or the radii",
        )


def build(table: TouchTable, index: int, around: Surroundings, complain: Complain) -> Touch | None:
    """The record of a table, or ``None`` after having complained."""
    name = table.name or f"touch_{index}"
    pair = read_pair(table, name, f"rt_{index}", around.mechanism, complain)
    if pair is None:
        return None
    return Touch(
        index=index,
        name=name,
        pair=pair,
        restitution=Parameter(f"{name}.restitution", f"et_{index}", table.restitution, FROM_0_TO_1),
        friction=None
        if table.friction is None
        else Parameter(f"{name}.friction", f"ft_{index}", table.friction, NOT_NEGATIVE),
    )


ENTRY = Entry("touch", True, TouchTable, build)

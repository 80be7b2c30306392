"""Belt: two pulleys on one carrier that a belt joins, or two sprockets that a chain joins, without slip or slack."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from ..effect_base.effect import Complain, Entry, Surroundings
from ..effect_base.meshing import Meshing, term
from ..effect_base.table import JointName, LinkName, Name, Table
from ..mechanism.meshes import Mesh
from .gear import PitchRadius, title, wheels_of


class BeltTable(Table):
    """One ``[[belt]]``."""

    name: Name | None = Field(default=None, description="a name of letters, digits and _, beginning with a letter")
    joints: Annotated[list[JointName], Field(min_length=2, max_length=2)] = Field(
        description='the joints by which the two pulleys turn, such as ["motor", "spindle"]'
    )
    radii: Annotated[list[PitchRadius], Field(min_length=2, max_length=2)] = Field(
        description="the radii of the two pulleys, or of the sprockets' pitch circles, in m, positive numbers"
    )
    crossed: bool = Field(default=False, description="true where the belt crosses itself: pulleys turn opposite ways")
    carrier: LinkName | None = Field(
        default=None, description="the link on which both axes sit, where joints leave a choice; ground is one"
    )


def build(table: BeltTable, index: int, around: Surroundings, complain: Complain) -> Meshing | None:
    """The record of a table, or ``None`` after having complained."""
    mechanism = around.mechanism
    wheels = wheels_of(table.joints, table.carrier, mechanism, complain)
    if not wheels:
        return None
    name, signs = table.name or f"belt_{index}", (1, 1 if table.crossed else -1)
    terms = tuple(
        term(name, k + 1, signs[k], wheel, radius, f"belt_{index}")
        for k, (wheel, radius) in enumerate(zip(wheels, table.radii, strict=True))
    )
    rims = tuple((wheel.centre, None, one.radius) for wheel, one in zip(wheels, terms, strict=True))
    axes, sizes = tuple(wheel.axis for wheel in wheels), tuple(one.radius for one in terms)
    band = ("belt", name, axes, (*sizes, 1.0 if table.crossed else 0.0))
    row = Mesh(name, tuple(w.joint for w in wheels), terms)
    return Meshing(name, row, title(wheels, mechanism), rims, (band,))


ENTRY = Entry("belt", True, BeltTable, build, {})

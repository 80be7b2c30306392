"""Gear: two wheels on one carrier that mesh, outside each other or one inside the other."""

from __future__ import annotations

from typing import Annotated, ClassVar

from pydantic import Field

from ..effect_base.effect import Complain, Entry, Surroundings
from ..effect_base.meshing import Meshing, Wheel, distance, find_wheels, size, term
from ..effect_base.points import find_joint
from ..effect_base.table import JointName, LinkName, Name, Table
from ..effect_base.written_numbers import Measured, as_written
from ..mechanism.links import GROUND
from ..mechanism.mechanism import Mechanism
from ..mechanism.meshes import Mesh

FITS = 1e-6
"""Radii that miss the distance of the axes by more than this share of it do not fit."""

Teeth = Annotated[int, Field(gt=0), Measured("1")]
PitchRadius = Annotated[float, Field(gt=0.0), Measured("m")]


class GearTable(Table):
    """One ``[[gear]]``."""

    ONE_OF: ClassVar[tuple[str, ...]] = ("teeth", "ratio", "radii")

    name: Name | None = Field(default=None, description="a name of letters, digits and _, beginning with a letter")
    joints: Annotated[list[JointName], Field(min_length=2, max_length=2)] = Field(
        description='the joints by which the two wheels turn, such as ["sun", "planet"]'
    )
    teeth: Annotated[list[Teeth], Field(min_length=2, max_length=2)] | None = Field(
        default=None, description="the numbers of teeth of the two wheels, whole and positive"
    )
    ratio: Annotated[float, Field(gt=0.0), Measured("1")] | None = Field(
        default=None, description="how many times as fast as the second wheel the first one turns, a positive number"
    )
    radii: Annotated[list[PitchRadius], Field(min_length=2, max_length=2)] | None = Field(
        default=None, description="the radii of the two pitch circles in m, positive numbers"
    )
    internal: bool = Field(
        default=False, description="true where one wheel is a ring about the other: both turn the same way"
    )
    carrier: LinkName | None = Field(
        default=None, description="the link on which both axes sit, where joints leave a choice; ground is one"
    )


def build(table: GearTable, index: int, around: Surroundings, complain: Complain) -> Meshing | None:
    """The record of a table, or ``None`` after having complained."""
    mechanism = around.mechanism
    wheels = wheels_of(table.joints, table.carrier, mechanism, complain)
    given = [key for key in table.ONE_OF if getattr(table, key) is not None]
    if len(given) != 1:
        found = " beside ".join(given) or f"none of {', '.join(table.ONE_OF)}"
        complain((), f"found {found}, expected one of teeth, ratio and radii; give one")
        return None
    if not wheels:
        return None
    radii = _radii(table, given[0], wheels, mechanism, complain)
    if radii is None:
        return None
    name = table.name or f"gear_{index}"
    signs = (1, -1 if table.internal else 1)
    terms = [
        term(name, k + 1, signs[k], wheel, radius, f"gear_{index}")
        for k, (wheel, radius) in enumerate(zip(wheels, radii, strict=True))
    ]
    apart = distance(wheels[0].axis, wheels[1].axis, mechanism) > 0.0
    rims = [(w.centre, None, one.radius) for w, one in zip(wheels, terms, strict=True)] if apart else []
    centres, sizes = tuple(wheel.centre for wheel in wheels), tuple(one.radius for one in terms)
    teeth = (("gear", name, centres, sizes),) if apart else ()
    return Meshing(name, Mesh(name, _numbers(wheels), tuple(terms)), title(wheels, mechanism), tuple(rims), teeth)


def wheels_of(
    names: list[str], carrier: str | None, mechanism: Mechanism, complain: Complain
) -> tuple[Wheel, ...] | None:
    """The two wheels that turn by the joints of these names, or ``None`` after having complained."""
    joints: list[int] = []
    for at, name in enumerate(names):
        joint, wrong = find_joint(name, mechanism)
        if joint is not None and mechanism.joints[joint].slides:
            joint, wrong = None, "it slides along a line; a wheel turns by a revolute joint"
        if joint is None:
            complain(("joints", at), f'found "{name}", expected a joint; {wrong}')
        else:
            joints.append(joint)
    links = [link.name for link in mechanism.links]
    known = carrier is None or carrier == "ground" or carrier in links
    if not known:
        complain(("carrier",), f'found "{carrier}", expected a link; the links are {", ".join(links)}, and ground')
    if len(joints) != 2 or not known:
        return None
    if joints[0] == joints[1]:
        complain(("joints",), f'found "{names[0]}" twice, expected two joints; name another one')
        return None
    link = None if carrier is None else GROUND if carrier == "ground" else links.index(carrier)
    wheels, wrong = find_wheels(joints, mechanism, link)
    if not wheels:
        complain(("joints",), f"found no carrier, expected one link on which both axes sit; {wrong}")
    return wheels or None


def title(wheels: tuple[Wheel, ...], mechanism: Mechanism) -> str:
    """``sun - planet on arm``, by the names of joints and carrier."""
    names = " - ".join(mechanism.joints[wheel.joint].name for wheel in wheels)
    return f"{names} on {mechanism.link_name(wheels[0].carrier)}"


def _numbers(wheels: tuple[Wheel, ...]) -> tuple[int, ...]:
    return tuple(wheel.joint for wheel in wheels)


def _radii(
    table: GearTable, key: str, wheels: tuple[Wheel, ...], mechanism: Mechanism, complain: Complain
) -> tuple[float, float] | None:
    """The pitch radii (m): as given, or as the ratio divides the distance of the axes.

    Wheels on one axis, as those of a gearbox, have none: then the larger one gets the size of the mechanism.
    """
    apart = distance(wheels[0].axis, wheels[1].axis, mechanism)
    if key == "radii" and table.radii:
        first, second = table.radii
        wanted = abs(first - second) if table.internal else first + second
        if abs(wanted - apart) > FITS * max(first, second):
            complain(
                ("radii",),
                f"found radii of wheels whose axes are {as_written(wanted, 'm')} apart, expected "
                f"{as_written(apart, 'm')}, where their joints have them; change the radii or the points",
            )
            return None
        return first, second
    first, second = table.teeth or (1.0, float(table.ratio or 1.0))
    share = abs(first - second) if table.internal else first + second
    if apart == 0.0:
        apart, share = size(mechanism), max(first, second)
    if share == 0.0:
        complain(
            (key,),
            f"found wheels of one size, one inside the other, with axes {as_written(apart, 'm')} apart, expected a "
            "ring that is larger; change it, or leave out internal",
        )
        return None
    return apart * first / share, apart * second / share


ENTRY = Entry("gear", True, GearTable, build, {})

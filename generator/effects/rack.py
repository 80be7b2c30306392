"""Rack: a pinion that turns and a bar that slides, on one carrier; or a wheel that rolls along a line."""

from __future__ import annotations

from pydantic import Field

from ..effect_base.effect import Complain, Entry, Surroundings
from ..effect_base.meshing import Meshing, Wheel, find_wheels, term
from ..effect_base.points import find_joint
from ..effect_base.table import JointName, Name, Table
from ..mechanism.links import ANY, Parameter
from ..mechanism.mechanism import Mechanism
from ..mechanism.meshes import Mesh, MeshTerm
from .gear import PitchRadius


class RackTable(Table):
    """One ``[[rack]]``."""

    name: Name | None = Field(default=None, description="a name of letters, digits and _, beginning with a letter")
    pinion: JointName = Field(description="the joint by which the pinion turns")
    slide: JointName = Field(description="the prismatic joint by which the rack slides")
    radius: PitchRadius = Field(description="the radius of the pinion's pitch circle in m, a positive number")
    reverse: bool = Field(
        default=False, description="true where a pinion that turns counter-clockwise moves the rack against its line"
    )


def build(table: RackTable, index: int, around: Surroundings, complain: Complain) -> Meshing | None:
    """The record of a table, or ``None`` after having complained."""
    mechanism = around.mechanism
    pinion, wrong = find_joint(table.pinion, mechanism)
    if pinion is not None and mechanism.joints[pinion].slides:
        pinion, wrong = None, "it slides along a line; a pinion turns by a revolute joint"
    if pinion is None:
        complain(("pinion",), f'found "{table.pinion}", expected a joint; {wrong}')
    slide, wrong = find_joint(table.slide, mechanism)
    if slide is not None and mechanism.joints[slide].kind != "prismatic":
        slide, wrong = None, "its links turn against each other; a rack slides by a prismatic joint"
    if slide is None:
        complain(("slide",), f'found "{table.slide}", expected a joint; {wrong}')
    if pinion is None or slide is None:
        return None
    wheel = _wheel(pinion, slide, mechanism)
    if wheel is None:
        message = f"found {table.pinion} and {table.slide} without a link in common, expected one that carries both"
        complain((), f"{message}; name other joints")
        return None
    name = table.name or f"rack_{index}"
    outwards = 1 if mechanism.joints[slide].first.link == wheel.carrier else -1
    turned = term(name, 1, -1 if table.reverse else 1, wheel, table.radius, f"rack_{index}")
    start = Parameter(f"{name}.start_2", f"xp_rack_{index}_2", 0.0, ANY, "m")
    row = Mesh(name, (pinion, slide), (turned, MeshTerm(-outwards, None, start, slide=slide)))
    what = f"{table.pinion} - {table.slide} on {mechanism.link_name(wheel.carrier)}"
    line = mechanism.joints[slide]
    bar = line.second if outwards > 0 else line.first
    numbers = (turned.radius, line.axis, -1.0 if table.reverse else 1.0)
    teeth = ("rack", name, (wheel.centre, bar, line.first), numbers)
    return Meshing(name, row, what, ((wheel.centre, None, turned.radius),), (teeth,))


def _wheel(pinion: int, slide: int, mechanism: Mechanism) -> Wheel | None:
    """The pinion on a link of the sliding joint."""
    joint = mechanism.joints[slide]
    for carrier in (joint.first.link, joint.second.link):
        wheels, _ = find_wheels([pinion], mechanism, carrier)
        if wheels:
            return wheels[0]
    return None


ENTRY = Entry("rack", True, RackTable, build, {"reverse": "sense"})

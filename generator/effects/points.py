"""Points and joints as effects name them in their tables."""

from __future__ import annotations

from ..mechanism.joints import PointRef
from ..mechanism.links import GROUND
from ..mechanism.mechanism import Mechanism


def find_point(name: str, mechanism: Mechanism) -> tuple[PointRef | None, str]:
    """The point called ``name`` (``joint_3``, ``link_0.A``, ``ground.O``), or what is wrong with the name."""
    for joint in mechanism.joints:
        if joint.name == name:
            return (joint.second if joint.first.link == GROUND else joint.first), ""
    owner, dot, point = name.partition(".")
    links = [link.name for link in mechanism.links]
    if not dot:
        return None, f"the joints are {', '.join(j.name for j in mechanism.joints) or 'none'}"
    if owner != "ground" and owner not in links:
        return None, f"the links are {', '.join(links)}, and ground"
    points = mechanism.ground_points if owner == "ground" else mechanism.links[links.index(owner)].points
    if point not in points:
        return None, f"{owner} has the points {', '.join(points) or 'none'}"
    return PointRef(GROUND if owner == "ground" else links.index(owner), point), ""


def find_joint(name: str, mechanism: Mechanism) -> tuple[int | None, str]:
    """The index of the joint called ``name``, or what is wrong with the name."""
    names = [joint.name for joint in mechanism.joints]
    if name not in names:
        return None, f"the joints are {', '.join(names) or 'none'}"
    return names.index(name), ""

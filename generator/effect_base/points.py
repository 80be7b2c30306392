"""Points and joints as effects name them in their tables."""

from __future__ import annotations

from ..mechanism.joints import PointRef
from ..mechanism.links import GROUND
from ..mechanism.mechanism import Mechanism

NO_GROUND_POINTS = (
    "the ground has no points here: it has those of [ground_link], beside [[link]]; those of [pinned] and "
    "[four_bars]; and of [chain] with hinged = true; hinge the chain, or describe the mechanism by [[link]]"
)


def find_point(name: str, mechanism: Mechanism) -> tuple[PointRef | None, str]:
    """The point called ``name`` (``joint_3``, ``link_0.A``, ``ground.O``), or what is wrong with the name."""
    for joint in (*mechanism.joints, *mechanism.open):
        if joint.name == name and joint.slides:
            return joint.second, ""
        if joint.name == name:
            return (joint.second if joint.first.link == GROUND else joint.first), ""
    owner, dot, point = name.partition(".")
    links = [link.name for link in mechanism.links]
    if owner in mechanism.welded:
        owner, point = mechanism.link_name(mechanism.welded[owner]), f"{owner}_{point}"
    if name in mechanism.welds:
        return None, "it is a weld, which is no joint of the mechanism; name a point of one of its links"
    if not dot:
        return None, f"the joints are {', '.join(j.name for j in mechanism.joints) or 'none'}"
    if owner != "ground" and owner not in links:
        return None, f"the links are {', '.join(links)}, and ground"
    points = mechanism.ground_points if owner == "ground" else mechanism.links[links.index(owner)].points
    if not points and owner == "ground":
        return None, NO_GROUND_POINTS
    if point not in points:
        return None, f"{owner} has the points {', '.join(points)}"
    return PointRef(GROUND if owner == "ground" else links.index(owner), point), ""


def carriers(name: str, mechanism: Mechanism) -> tuple[str, ...]:
    """The points that a disc about the pin called ``name`` could be fixed to, as a scene writes them: those of both its
    links, if both move; none where there is no choice."""
    for joint in mechanism.joints:
        if joint.name == name and not joint.slides and not joint.on_ground:
            return written(joint.first, mechanism), written(joint.second, mechanism)
    return ()


def choose_carrier(name: str, mechanism: Mechanism) -> str:
    """What to say of a disc about the pin called ``name``: that its link is not known; nothing where it is."""
    found = carriers(name, mechanism)
    if not found:
        return ""
    one, other = (point.partition(".")[0] for point in found)
    return (
        f'found a disc about "{name}", a pin of {one} and {other}, expected the link that it turns with; '
        f'write "{found[0]}" or "{found[1]}"'
    )


def written(ref: PointRef, mechanism: Mechanism) -> str:
    """The point as a scene names it: of welded links under their own names."""
    own = (name for name, owner in mechanism.welded.items() if owner == ref.link and ref.point.startswith(f"{name}_"))
    if link := max(own, key=len, default=""):
        return f"{link}.{ref.point.removeprefix(f'{link}_')}"
    return f"{mechanism.link_name(ref.link)}.{ref.point}"


def find_joint(name: str, mechanism: Mechanism) -> tuple[int | None, str]:
    """The index of the joint called ``name``, or what is wrong with the name."""
    names = [joint.name for joint in mechanism.joints]
    if name not in names:
        weld = "it is a weld, whose links do not move against each other; " if name in mechanism.welds else ""
        return None, f"{weld}the joints are {', '.join(names) or 'none'}"
    return names.index(name), ""

"""Names of outputs that a scene has for certain or may have, before it is compiled."""

from __future__ import annotations

from collections.abc import Iterator

from ..mechanism.links import GROUND
from ..scene.scene import Scene

OF_MECHANISM = ("t", "kinetic_energy", "potential_energy", "energy")
OF_LINK = ("angle", "angular_velocity", "angular_acceleration")
OF_POINT = ("x", "y", "vx", "vy", "ax", "ay", "speed")
OF_JOINT = ("force", "fx", "fy", "moment", "power", "impulse")
OF_SLIDE = ("slide", "slide_rate")


def possible_outputs(scene: Scene) -> dict[str, None]:
    """Names of all outputs but those of effects other than laws, of contacts and of meshes, and some that a joint has
    only where it is driven or something strikes, in the order in which models have them."""
    return dict.fromkeys(_possible(scene))


def _possible(scene: Scene) -> Iterator[str]:
    mechanism = scene.mechanism
    joints = (*mechanism.joints, *mechanism.open)
    yield from OF_MECHANISM
    yield from (name for effect in scene.effects for name in effect.defines())
    for link in mechanism.links:
        yield from (f"{link.name}.{asked}" for asked in OF_LINK)
    for owner in (
        *(joint.name for joint in joints),
        *(f"{link.name}.{point}" for link in mechanism.links for point in link.points),
        *_welded_points(scene),
        *(f"{link.name}.com" for link in mechanism.links if not link.massless),
    ):
        yield from (f"{owner}.{asked}" for asked in OF_POINT)
    for joint in joints:
        asked = (*(OF_SLIDE if joint.slides else ()), *(OF_LINK if joint.turns else ()), *OF_JOINT)
        yield from (f"{joint.name}.{one}" for one in asked)


def _welded_points(scene: Scene) -> Iterator[str]:
    mechanism = scene.mechanism
    for name, owner in mechanism.welded.items():
        points = mechanism.ground_points if owner == GROUND else mechanism.links[owner].points
        yield from (f"{name}.{point.removeprefix(f'{name}_')}" for point in points if point.startswith(f"{name}_"))


def of_effects(scene: Scene, name: str) -> bool:
    """Whether this may be an output of an effect, of a contact or of a mesh, or says the kind of thing it is of."""
    owners = {
        *(str(getattr(effect, "name", "")) for effect in scene.effects),
        *(m.name for m in scene.mechanism.meshes),
    }
    return " " in name or any(name.startswith(f"{owner}.") for owner in owners - {""})

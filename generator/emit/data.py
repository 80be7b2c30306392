"""The data that a generated package carries beside its code: names, parameter values, start and run settings."""

from __future__ import annotations

from ..derive.equations import Equations
from ..effects.effect import Effect
from ..mechanism.links import Parameter, Point
from ..mechanism.mechanism import Mechanism
from ..mechanism.topology import Topology
from ..scene.scene import Scene

Json = dict[str, object]


def point_names(mechanism: Mechanism) -> list[str]:
    """Names of the positions that the kernel ``points`` gives, in its order: joints, then each link's named points."""
    names = [joint.name for joint in mechanism.joints]
    return names + [f"{link.name}.{name}" for link in mechanism.links for name in link.points]


def model_data(scene: Scene, topology: Topology, equations: Equations, hash_: str) -> Json:
    """Everything the runtime knows of the model besides the compiled kernels, ready for JSON."""
    mechanism = scene.mechanism
    return {
        "name": scene.name,
        "hash": hash_,
        "links": [link.name for link in mechanism.links],
        "joints": [joint.name for joint in mechanism.joints],
        "between": [[joint.first.link, joint.second.link] for joint in mechanism.joints],
        "outboard": _outboard(mechanism, topology),
        "cuts": [mechanism.joints[cut.joint].name for cut in topology.cuts],
        "root": mechanism.link_name(topology.root),
        "points": point_names(mechanism),
        "q_names": [s.name for s in equations.state.q],
        "u_names": [s.name for s in equations.state.u],
        "parameters": [[p.path, p.value] for p in equations.parameters],
        "inputs": [name for effect in scene.effects for name in effect.inputs()],
        "instants": [p.path for effect in scene.effects for p in effect.instants()],
        "contacts": [[contact.name, contact.ground] for contact in equations.contacts],
        "grounds": [plane for effect in scene.effects for plane in _planes(effect)],
        "outlines": [[_point(point) for point in link.points.values()] for link in mechanism.links],
        "ground_points": [_point(point) for point in mechanism.ground_points.values()],
        "start": {
            "poses": [list(pose) for pose in scene.start.poses],
            "velocities": [list(velocity) for velocity in scene.start.velocities],
        },
        "run": {"until": scene.run.until, "rtol": scene.run.rtol, "atol": scene.run.atol},
    }


def _outboard(mechanism: Mechanism, topology: Topology) -> list[str]:
    """The link on which each joint's reaction acts: the tree's outboard link, or a cut joint's second side."""
    found = {branch.joint: branch.link for branch in topology.branches}
    found |= {cut.joint: cut.second.link for cut in topology.cuts}
    return [mechanism.link_name(found[joint]) for joint in range(len(mechanism.joints))]


def _point(point: Point) -> list[str | float]:
    """Coordinates as parameter paths, or 0 where they are structurally zero."""
    return [_coordinate(point.x), _coordinate(point.y)]


def _coordinate(parameter: Parameter | None) -> str | float:
    return parameter.path if parameter else 0.0


def _planes(effect: Effect) -> list[Json]:
    return [{"name": name, "point": _point(point), "normal": _point(normal)} for name, point, normal in effect.planes()]

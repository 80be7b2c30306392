"""The data that a generated package carries beside its code: names, parameter values, start and run settings."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Sequence

import sympy as sp

from ..effect_base.effect import Effect, Rim
from ..equations.equations import ContactName, Equations
from ..equations.names import State, sliding_name
from ..mechanism.links import GROUND, Corner, Link, Parameter, Point
from ..mechanism.mechanism import Mechanism
from ..mechanism.topology import Topology
from ..scene.scene import HELD, ON, Scene
from .parameter_data import data_of_state, data_over_time, parameter_data, resting_data
from .schema import ModelData
from .start_data import coordinates, start_data

Json = dict[str, object]


def point_names(mechanism: Mechanism) -> list[str]:
    """Names of the positions that the kernel ``points`` gives, in its order: joints, then each link's named points."""
    names = [joint.name for joint in mechanism.joints]
    return names + [f"{link.name}.{name}" for link in mechanism.links for name in link.points]


def model_data(
    scene: Scene,
    topology: Topology,
    equations: Equations,
    hash_: str,
    contract: int,
    precision: str = "double",
    extra: Json | None = None,
) -> Json:
    """Everything the runtime knows of the model besides the compiled kernels, ready for JSON.

    ``schema.py`` says what each key means.
    """
    mechanism = scene.mechanism
    data: Json = {
        "contract": contract,
        "name": scene.name,
        "hash": hash_,
        "precision": precision,
        "links": [link.name for link in mechanism.links],
        "joints": [joint.name for joint in mechanism.joints],
        "between": [
            [joint.first.link, joint.second.link] for joint in map(mechanism.as_named, range(len(mechanism.joints)))
        ],
        "sides": list(topology.sides(len(mechanism.joints))),
        "cuts": [mechanism.joints[cut.joint].name for cut in topology.cuts],
        "rows": [*_rows(mechanism, topology), *(f"{row.mesh.name}.mesh" for row in topology.meshes)],
        "lines": _lines(mechanism),
        "coordinates": coordinates(mechanism, topology),
        "leaders": [topology.leader(k) for k in range(len(mechanism.links))],
        "root": mechanism.link_name(topology.root),
        "points": point_names(mechanism),
        "welded_points": _welded_points(mechanism),
        "q_names": [s.name for s in equations.state.q],
        "u_names": [s.name for s in equations.state.u],
        "parameters": parameter_data(equations.folded or equations.parameters),
        "folded": bool(equations.folded),
        "rests_on": resting_data(mechanism, topology.implied),
        "over_time": data_over_time(scene.effects),
        "of_state": data_of_state(scene.effects, [output.name for output in equations.outputs]),
        "drives": [_drive(mechanism, effect) for effect in scene.effects if effect.driven()],
        "accelerations": [p.path for effect in scene.effects for p in effect.accelerations()],
        "inputs": [name for effect in scene.effects for name in effect.inputs()],
        "instants": [p.path for effect in scene.effects for p in effect.instants()],
        "timed": any(sp.Symbol("t") in one.expression.free_symbols for one in equations.assignments()),
        "continuous": any(one.sides() for one in scene.effects) and not any(one.jumps() for one in scene.effects),
        "kinks": [list(kink) for effect in scene.effects for kink in effect.kinks()],
        "contacts": [[contact.point, contact.ground] for contact in equations.contacts],
        "stops": [contact.ground for contact in equations.contacts if contact.angular],
        "slide_ends": [contact.ground for contact in equations.contacts if contact.slides],
        "whiles": _whiles(equations.contacts),
        "gates": _gates(scene),
        "grounds": _planes(scene),
        "law": scene.run.law,
        "outlines": [[_point(point) for point in link.points.values()] for link in mechanism.links],
        "drawn": {
            link.name: _drawn(link, mechanism.outlines.get(link.name, ()))
            for link in mechanism.links
            if link.name in mechanism.outlines or _is_carriage(link)
        },
        "discs": _discs(scene),
        "ropes": _ropes(scene),
        "parts": _parts(scene),
        "outputs": [[output.name, output.unit] for output in equations.outputs],
        "output_links": {output.name: output.link for output in equations.outputs if output.link},
        "latches": [name for effect in scene.effects for name, _ in effect.latches()],
        "aids": list(mechanism.aids),
        "shafts": list(mechanism.shafts.values()),
        "integrators": [vars(one) for one in mechanism.integrators],
        "ground_names": list(mechanism.ground_points),
        "ground_points": [_point(point) for point in mechanism.ground_points.values()],
        "start": start_data(mechanism, topology, scene.start),
        "run": {"until": scene.run.until, "rtol": scene.run.rtol, "atol": scene.run.atol, "on_gain": scene.run.on_gain},
    }
    data |= extra or {}
    return ModelData.model_validate(data).model_dump(exclude_defaults=True)


def _rows(mechanism: Mechanism, topology: Topology) -> list[str]:
    return [f"{mechanism.joints[cut.joint].name}.{row}" for cut in topology.cuts for row in cut.rows]


def event_data(scene: Scene) -> Json:
    """The events of a scene; nothing where it has none."""
    if not scene.events:
        return {}
    lists = ("on", "off")
    data: Json = {
        "events": [
            vars(event) | {"set": dict(event.set)} | {key: [*getattr(event, key)] for key in lists}
            for event in scene.events
        ]
    }
    return data


def _gates(scene: Scene) -> list[Json]:
    """What each gate switches."""
    return [
        {
            "effect": gate.path.removesuffix(ON),
            "parameter": gate.path,
            "latches": [name for name, _ in effect.latches()],
        }
        for effect, gate in zip(scene.effects, scene.gates, strict=False)
        if gate
    ]


def _whiles(contacts: Sequence[ContactName]) -> list[Json]:
    """The contacts that are not always there."""
    every = [[dict(each) for each in contact.whiles] for contact in contacts]
    return [{"contact": number, "whiles": whiles} for number, whiles in enumerate(every) if {} not in whiles]


def _where_on(scene: Scene, effects: Iterable[int]) -> Json:
    """The gates one of which is 1 where something of these effects is there; nothing where it always is."""
    gates = [scene.gate(effect) or _gate_of_joint(scene, effect) for effect in effects]
    return {"on": [gate.path for gate in gates if gate]} if all(gates) else {}


def _gate_of_joint(scene: Scene, effect: int) -> Parameter | None:
    """The gate of the joint at which an effect is, if it is at one that lets go or takes hold."""
    joints = scene.effects[effect].at_joints()
    return scene.mechanism.gates_at.get(joints[0]) if len(joints) == 1 else None


def switching_data(scene: Scene) -> Json:
    """What changes in a scene; nothing where nothing does."""
    if not scene.changes:
        return {}
    mechanism = scene.mechanism
    data: Json = {
        "ends": {gate.path.removesuffix(HELD): _ends(scene, k) for k, gate in mechanism.gates.items()},
        "changes": [
            vars(change)
            | {"watch": None if change.watch is None else vars(change.watch) | {"names": [*change.watch.names]}}
            for change in scene.changes
        ],
    }
    return {"switching": data}


def _ends(scene: Scene, number: int) -> Json:
    """A joint that changes."""
    mechanism, gate = scene.mechanism, scene.mechanism.gates[number].path
    joint = mechanism.joints[number]
    ends = (joint.first, joint.second)
    gates = mechanism.gates_at
    at = [one for one in scene.effects if any(gates.get(joint) == gates[number] for joint in one.at_joints())]
    return {
        "gate": gate,
        "latches": [name for effect in at for name, _ in effect.latches()],
        "kind": joint.kind,
        "links": [end.link for end in ends],
        "points": [_point(mechanism.point(end)) for end in ends],
        "names": [f"{mechanism.link_name(end.link)}.{end.point}" for end in ends],
        "axis": joint.axis.value if joint.axis else 0.0,
        "angle": joint.angle.value if joint.angle else 0.0,
    }


def _discs(scene: Scene) -> list[Json]:
    """Each disc and each edge once, and closed curves."""
    found: dict[Rim, list[int]] = {}
    for index, effect in enumerate(scene.effects):
        for rim in effect.rims():
            found.setdefault(rim, []).append(index)
    point = scene.mechanism.point
    discs: list[Json] = [
        {
            "link": ref.link,
            "point": _point(point(ref)),
            "end": _point(point(end)) if end else None,
            "radius": [part.path for part in radius] if isinstance(radius, tuple) else _coordinate(radius),
            **_where_on(scene, effects),
        }
        for (ref, end, radius), effects in found.items()
    ]
    return discs + [
        {
            "link": ref.link,
            "point": _point(point(ref)),
            "end": None,
            "radius": 0.0,
            "around": [*map(list, around)],
            **_where_on(scene, [index]),
        }
        for index, effect in enumerate(scene.effects)
        for ref, around in effect.curves()
    ]


def _parts(scene: Scene) -> list[Json]:
    """What is drawn where effects act."""
    return [
        {
            "kind": kind,
            "name": name,
            "links": [ref.link for ref in refs],
            "points": [_point(scene.mechanism.point(ref)) for ref in refs],
            "numbers": [n if isinstance(n, float) else _coordinate(n) for n in numbers],
            **_where_on(scene, [index]),
        }
        for index, effect in enumerate(scene.effects)
        for kind, name, refs, numbers in effect.parts(scene.mechanism)
    ]


def _ropes(scene: Scene) -> list[Json]:
    """Each rope with its points."""
    return [
        {
            "name": name,
            "links": [ref.link for ref in refs],
            "points": [_point(scene.mechanism.point(ref)) for ref in refs],
            **_where_on(scene, [index]),
        }
        for index, effect in enumerate(scene.effects)
        for name, refs in effect.ropes()
    ]


def _welded_points(mechanism: Mechanism) -> dict[str, str]:
    """Points of welded links as a scene names them, and as points of the bodies that they have become."""
    return {
        f"{name}.{point.removeprefix(name + '_')}": f"{mechanism.link_name(owner)}.{point}"
        for name, owner in mechanism.welded.items()
        for point in (mechanism.ground_points if owner == GROUND else mechanism.links[owner].points)
        if point.startswith(f"{name}_")
    }


def driven_coordinates(state: State, topology: Topology, driven: Collection[int]) -> list[int]:
    """Per driven joint, in the order of the branches: its coordinate, and the one that it is measured from or −1."""
    found = []
    for branch in topology.branches:
        if branch.joint not in driven:
            continue
        if branch.slides:
            found += [state.u.index(sp.Symbol(sliding_name(branch.joint))), -1]
        else:
            below = state.rate(branch.parent)
            found += [state.u.index(state.rate(branch.link)), state.u.index(below) if below != 0 else -1]
    return found


def _drive(mechanism: Mechanism, effect: Effect) -> Json:
    """A driven joint, its position at t = 0 if that is given, and its speed, a parameter's path where it is one."""
    (joint,) = effect.driven()
    paths, (position, speed) = [p.path for p in effect.parameters()], effect.begins()
    return {
        "joint": mechanism.joints[joint].name,
        "position": position,
        "speed": paths[0] if paths else speed,
        "slides": mechanism.joints[joint].slides,
    }


def _lines(mechanism: Mechanism) -> dict[str, Json]:
    """Per sliding joint its two links and points, and its line's direction in the first link's frame."""
    return {
        joint.name: {
            "links": [joint.first.link, joint.second.link],
            "points": [_point(mechanism.point(joint.first)), _point(mechanism.point(joint.second))],
            "axis": _coordinate(joint.axis),
            "angle": None if joint.turns else _coordinate(joint.angle),
        }
        for joint in map(mechanism.as_named, range(len(mechanism.joints)))
        if joint.slides
    }


def _point(point: Point) -> list[str | float]:
    """Coordinates as parameter paths, or 0 where they are structurally zero."""
    return [_coordinate(point.x), _coordinate(point.y)]


def _is_carriage(link: Link) -> bool:
    """A link of one point without mass, as joints need that slide along two directions: there is nothing to see."""
    return link.massless and len(link.points) == 1


def _drawn(link: Link, corners: Sequence[Corner]) -> list[list[str | float]]:
    """What is drawn of a link, corner by corner."""
    return [_point(link.points[corner]) if isinstance(corner, str) else [*corner] for corner in corners]


def _coordinate(parameter: Parameter | None) -> str | float:
    return parameter.path if parameter else 0.0


def _planes(scene: Scene) -> list[Json]:
    return [
        {"name": name, "point": _point(point), "normal": _point(normal), **_where_on(scene, [index])}
        for index, effect in enumerate(scene.effects)
        for name, point, normal in effect.planes()
    ]

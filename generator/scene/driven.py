"""Joints whose motion effects prescribe: what that asks of the start, and drives that contradict each other."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace

import numpy as np

from ..effect_base.effect import Effect
from ..mechanism.assembled import Assembled
from ..mechanism.assembly import Speed
from ..mechanism.branch import Triple
from ..mechanism.layout import Held, Layout, Length
from ..mechanism.links import GROUND
from ..mechanism.mechanism import Mechanism
from .errors import Path, Report
from .scene import Moved, Sketch


def check_driven(mechanism: Mechanism, effects: Sequence[tuple[Path, Effect]], report: Report) -> bool:
    """No joint is driven twice, and no driven joint or rack lies in a ring of joints that hold or are given their
    motion."""
    found: dict[int, str] = {}
    fine = True
    for path, effect in effects:
        for joint in effect.driven():
            if joint in found:
                message = f"found {mechanism.joints[joint].name}, which {found[joint]} drives already, expected another"
                report.add((*path, "joint"), f"{message} joint; remove one of them")
                fine = False
            found.setdefault(joint, effect.title)
    if not found and not any(mesh.slides for mesh in mechanism.meshes):
        return fine
    from ..mechanism.topology import span  # only scenes with drives need the spanning tree here

    try:
        topology = span(mechanism, tuple(found))
    except ValueError:
        return fine  # links that nothing joins are reported elsewhere
    cut = {cut.joint for cut in topology.cuts} | {idle.joint for idle in topology.implied}
    for path, effect in effects:
        for joint in effect.driven():
            if joint in cut:
                message = (
                    f"found {mechanism.joints[joint].name}, whose motion other drives or sliding joints give already"
                )
                report.add((*path, "joint"), f"{message}, expected a joint that is free; remove a drive")
                fine = False
        for joint in mesh.slides if (mesh := effect.mesh()) else ():
            if joint in cut:
                message = f"found {mechanism.joints[joint].name}, which closes a ring of joints that slide"
                report.add((*path, "slide"), f"{message}, expected another one of its ring; name that")
                fine = False
    return fine


def mesh_speeds(layout: Layout, mechanism: Mechanism) -> tuple[Speed, ...]:
    """What meshes ask of the rates: each row, of entries up to 1, is to stay as it is."""
    numbers, speeds = {line.joint: len(layout.base) + k for k, line in enumerate(layout.lines)}, list[Speed]()
    for mesh in mechanism.meshes:
        row = np.zeros(len(layout.base) + len(layout.lines))
        for link, lever in mesh.levers().items():
            if link != GROUND:
                row[link] += lever
        for joint, sign in mesh.lengths().items():
            row[numbers[joint]] += sign * layout.unit
        speeds.append(Speed(mesh.joints[0], row / (np.abs(row).max() or 1.0), 0.0))
    return tuple(speeds)


def drive_layout(layout: Layout, mechanism: Mechanism, effects: Sequence[Effect]) -> tuple[Layout, tuple[Speed, ...]]:
    """The layout with the positions that drives ask for at t = 0, and the speeds that they ask for."""
    held, lengths, speeds = list(layout.held), list(layout.lengths), []
    numbers = {line.joint: len(layout.base) + k for k, line in enumerate(layout.lines)}
    for effect in effects:
        for index in effect.driven():
            joint, (position, speed) = mechanism.joints[index], effect.begins()
            row = np.zeros(len(layout.base) + len(layout.lines))
            if joint.slides:
                row[numbers[index]] = layout.unit
                lengths += [Length(index, numbers[index], position)] if position is not None else []
            else:
                for link, sign in ((joint.second.link, 1.0), (joint.first.link, -1.0)):
                    if link != GROUND:
                        row[link] += sign
                first, second = joint.first.link, joint.second.link
                held += [Held(index, first, second, position)] if position is not None else []
            speeds.append(Speed(index, row, speed))
    return replace(layout, held=tuple(held), lengths=tuple(lengths)), tuple(speeds)


def held_as_given(
    layout: Layout, mechanism: Mechanism, effects: Sequence[Effect], sketch: Sketch
) -> dict[int, Held | Length]:
    """What ``[start]`` gives driven joints, by the number of the drive, where the drive says how fast they move and not
    where they are: the angle of the second link against the first, where both are given, or a length."""
    found: dict[int, Held | Length] = {}
    numbers = {line.joint: len(layout.base) + k for k, line in enumerate(layout.lines)}
    told = [k for k, joint in enumerate(mechanism.joints) if joint.slides]
    driven = [(effect, joint) for effect in effects for joint in effect.driven()]
    for number, (effect, index) in enumerate(driven):
        joint, (position, _) = mechanism.joints[index], effect.begins()
        if position is not None:
            continue
        ends = joint.first.link, joint.second.link
        if joint.slides and told.index(index) in sketch.given.slides:
            length = sketch.slides[told.index(index)]
            assert length is not None
            found[number] = Length(index, numbers[index], length)
        elif not joint.slides and all(link == GROUND or link in sketch.given.angles for link in ends):
            one, other = (0.0 if link == GROUND else sketch.angles[link] for link in ends)
            found[number] = Held(index, *ends, other - one)
    return found


def with_given(layout: Layout, given: Iterable[Held | Length]) -> Layout:
    """The layout with driven joints as ``[start]`` gives them."""
    held = tuple(one for one in given if isinstance(one, Held))
    lengths = tuple(one for one in given if isinstance(one, Length))
    return replace(layout, held=layout.held + held, lengths=layout.lengths + lengths)


def moved_from_given(
    mechanism: Mechanism, effects: Sequence[Effect], sketch: Sketch, poses: Sequence[Triple], tolerance: float
) -> tuple[Moved, ...]:
    """Links of driven joints that turn otherwise than ``[start]`` gives, and driven joints that are elsewhere along
    their lines, by more than the ``tolerance``."""
    found, assembled = list[Moved](), Assembled(mechanism, poses)
    told = [k for k, joint in enumerate(mechanism.joints) if joint.slides]
    for effect in effects:
        placed = effect.begins()[0] is not None
        for index in effect.driven():
            joint = mechanism.joints[index]
            if joint.slides:
                length, got = sketch.slides[told.index(index)], assembled.length(index)
                if told.index(index) in sketch.given.slides and length is not None and abs(got - length) > tolerance:
                    found.append(Moved(joint.name, "slides", joint.name, length, got, placed))
                continue
            for link in (joint.first.link, joint.second.link):
                if link == GROUND or link not in sketch.given.angles:
                    continue
                off = poses[link][2] - sketch.angles[link]
                if abs(off - 2.0 * np.pi * round(off / (2.0 * np.pi))) > tolerance:
                    name = mechanism.link_name(link)
                    found.append(Moved(joint.name, "angles", name, sketch.angles[link], poses[link][2], placed))
    return tuple(found)

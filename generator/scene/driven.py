"""Joints whose motion effects prescribe: what that asks of the start, and drives that contradict each other."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ..effect_base.effect import Effect
from ..mechanism.assembly import Speed
from ..mechanism.layout import Held, Layout, Length
from ..mechanism.links import GROUND
from ..mechanism.mechanism import Mechanism
from .errors import Path, Report


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

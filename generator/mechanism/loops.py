"""The loops of a mechanism by name: which links and joints lie around each joint that closes one."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass

from .joints import Joint
from .mechanism import Mechanism


@dataclass(frozen=True)
class Loop:
    """Links and joints around a loop: ``joints[k]`` joins ``links[k - 1]`` and ``links[k]``; ``joints[0]`` closes."""

    links: tuple[int, ...]
    joints: tuple[int, ...]

    def text(self, mechanism: Mechanism) -> str:
        """``ground - crank - coupler - rocker (joints motor, knee, elbow, pivot)``."""
        links = " - ".join(mechanism.link_name(link) for link in self.links)
        return f"{links} (joints {', '.join(mechanism.joints[joint].name for joint in self.joints)})"


def loops(mechanism: Mechanism, closing: Collection[int], implied: Collection[int] = ()) -> tuple[Loop, ...]:
    """One loop for each joint in ``closing``: from its second side to its first through joints that are not in
    ``closing`` and that others do not imply.

    Those must connect the links as a tree.
    """
    roads: dict[int, list[tuple[int, int]]] = {}
    for index, joint in enumerate(mechanism.joints):
        if index not in closing and index not in implied:
            roads.setdefault(joint.first.link, []).append((joint.second.link, index))
            roads.setdefault(joint.second.link, []).append((joint.first.link, index))
    return tuple(_around(roads, mechanism.joints[index], index) for index in closing)


def _around(roads: Mapping[int, list[tuple[int, int]]], joint: Joint, index: int) -> Loop:
    """The way through the tree from the second side of a joint to its first."""
    start, end = joint.second.link, joint.first.link
    came: dict[int, tuple[int, int]] = {end: (end, -1)}
    waiting = [end]
    while start not in came:
        here = waiting.pop(0)
        for there, road in roads[here]:
            if there not in came:
                came[there] = (here, road)
                waiting.append(there)
    links, joints = [start], [index]
    while links[-1] != end:
        link, road = came[links[-1]]
        links.append(link)
        joints.append(road)
    return Loop(tuple(links), tuple(joints))

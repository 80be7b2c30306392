"""How many ways a mechanism can move, and which joints hold what others hold already.

Everything here is in maximal coordinates, x, y and angle of every link's frame, with the equations of every joint: no
joint is special because a spanning tree left it open. A vector s with Jᵀs = 0 is a state of self-stress: forces of the
joints that balance without any load. Joints that carry one are redundant, any of them; all others are needed.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from .branch import place
from .joints import Joint, PointRef
from .links import GROUND
from .mechanism import Mechanism
from .totals import total

Real = NDArray[np.float64]
Triple = tuple[float, float, float]

RANK = 1e-6
"""Singular values below this share of the largest count as zero: bars in line are so to the root of rounding only."""
_CARRIES = 1e-6
_TRIES, _STEPS, _FAR = 6, 60, 0.2


@dataclass(frozen=True)
class Group:
    """Joints that hold each other: they have ``surplus`` equations more than are independent.

    Numbers from that of the joints on are those of meshes.
    """

    joints: tuple[int, ...]
    surplus: int


@dataclass(frozen=True)
class Mobility:
    """``freedom``: ways to move by the rank of the joints' equations here; ``elsewhere``: at nearby configurations.

    ``groups`` are the redundant joints everywhere, ``here`` those that are redundant in this configuration only, as in
    a change point. ``stuck``: no configuration nearby was found, so the mechanism cannot move although ``freedom`` may
    say so.
    """

    freedom: int
    elsewhere: int
    groups: tuple[Group, ...]
    here: tuple[Group, ...]
    stuck: bool

    @property
    def structure(self) -> bool:
        """Nothing can move."""
        return self.freedom == 0 or self.stuck


def mobility(mechanism: Mechanism, poses: Sequence[Triple]) -> Mobility:
    """The mobility at assembled ``poses``, compared with that of random consistent configurations around them."""
    start = np.array(poses, dtype=float)
    joints = JointEquations(mechanism, start)
    here, freedom = joints.stresses(start)
    if not here.shape[1]:
        return Mobility(freedom, freedom, (), (), False)
    nearby = [found for found in joints.around(start) if np.abs(found - start).max() > 0.01 * _FAR]
    if not nearby:
        return Mobility(freedom, freedom, joints.groups(here), (), freedom > 0)
    stresses, elsewhere = min((joints.stresses(found) for found in nearby), key=lambda pair: pair[1])
    if elsewhere == freedom:
        return Mobility(freedom, elsewhere, joints.groups(here), (), False)
    always = joints.groups(stresses)
    return Mobility(freedom, elsewhere, always, joints.groups(here), False)


class JointEquations:
    """Equations of all joints; lengths in units of the mechanism's size, so that all entries are of order 1.

    ``poses`` (nl, 3) are x, y (m) and angle of every link's frame.
    """

    def __init__(self, mechanism: Mechanism, poses: Real) -> None:
        self.mechanism = mechanism
        arms = [abs(self.local(end)) for joint in mechanism.joints for end in (joint.first, joint.second)]
        self.size = max(arms, default=0.0) or 1.0
        self.count = poses.size
        counts = {"pin-in-slot": 1, "weld": 3}
        sizes = [
            counts.get(joint.kind, 2) * (k not in mechanism.open_gates) for k, joint in enumerate(mechanism.joints)
        ]
        sizes += [1] * len(mechanism.meshes)
        self.begun = poses.copy()
        ends = np.cumsum([0, *sizes])
        self.rows = [slice(int(a), int(b)) for a, b in pairwise(ends)]
        self.height = int(ends[-1])

    def local(self, ref: PointRef) -> complex:
        return complex(*self.mechanism.point(ref).values()) if ref.link != GROUND else 0j

    def residual(self, poses: Real) -> Real:
        """Second point less first point of every pin; across its line, and a held angle, where a joint slides."""
        rows, found = poses.tolist(), np.zeros(self.height)
        for at, joint in zip(self.rows, self.mechanism.joints, strict=False):
            if at.start == at.stop:
                continue
            gap = (place(self.mechanism, rows, joint.second) - place(self.mechanism, rows, joint.first)) / self.size
            if joint.slides:
                found[at.start] = (gap * (1j * self._along(joint, poses)).conjugate()).real
            else:
                found[at.start : at.start + 2] = gap.real, gap.imag
            if not joint.turns:
                angle = joint.angle.value if joint.angle else 0.0
                turned = self._angle(joint.second, poses) - self._angle(joint.first, poses) - angle
                found[at.stop - 1] = np.remainder(turned + np.pi, 2.0 * np.pi) - np.pi
        for at, mesh in zip(self.rows[len(self.mechanism.joints) :], self.mechanism.meshes, strict=True):
            passed = [lever * (poses - self.begun)[k, 2] for k, lever in mesh.levers().items() if k != GROUND]
            for index, sign in mesh.lengths().items():
                passed.append(sign * (self._length(index, poses) - self._length(index, self.begun)))
            found[at] = total(passed) / self.size
        return found

    def jacobian(self, poses: Real) -> Real:
        """Derivatives of the residual by x and y in units of the size and by the angles, shape (rows, 3 nl)."""
        found: Real = np.zeros((self.height, self.count))
        places = poses.tolist()
        for at, joint in zip(self.rows, self.mechanism.joints, strict=False):
            gap = place(self.mechanism, places, joint.second) - place(self.mechanism, places, joint.first)
            for ref, sign in ((joint.first, -1.0), (joint.second, 1.0)):
                if ref.link == GROUND or at.start == at.stop:
                    continue
                turned = 1j * self.local(ref) * np.exp(1j * poses[ref.link, 2]) / self.size
                if joint.slides and sign < 0.0:
                    turned += 1j * gap / self.size  # the line turns with the first link
                block = np.array([[1.0, 0.0, turned.real], [0.0, 1.0, turned.imag]])
                columns = slice(3 * ref.link, 3 * ref.link + 3)
                if joint.slides:
                    across = 1j * self._along(joint, poses)
                    found[at.start, columns] = sign * (np.array([across.real, across.imag]) @ block)
                else:
                    found[at.start : at.start + 2, columns] = sign * block
                if not joint.turns:
                    found[at.stop - 1, columns] = (0.0, 0.0, sign)
        for at, mesh in zip(self.rows[len(self.mechanism.joints) :], self.mechanism.meshes, strict=True):
            for link, lever in mesh.levers().items():
                if link != GROUND:
                    found[at.start, 3 * link + 2] += lever / self.size
            for index, sign in mesh.lengths().items():
                found[at.start] += sign * self._along_row(self.mechanism.joints[index], poses)
        return found

    def _length(self, index: int, poses: Real) -> float:
        """How far (m) a sliding joint is along its line."""
        joint, places = self.mechanism.joints[index], poses.tolist()
        gap = place(self.mechanism, places, joint.second) - place(self.mechanism, places, joint.first)
        return float((gap * self._along(joint, poses).conjugate()).real)

    def _along_row(self, joint: Joint, poses: Real) -> Real:
        """Derivatives of that in units of the size, shape (3 nl,)."""
        row, along, places = np.zeros(self.count), self._along(joint, poses), poses.tolist()
        gap = place(self.mechanism, places, joint.second) - place(self.mechanism, places, joint.first)
        for ref, sign in ((joint.first, -1.0), (joint.second, 1.0)):
            if ref.link != GROUND:
                turned = 1j * self.local(ref) * np.exp(1j * poses[ref.link, 2]) / self.size
                turned += 1j * gap / self.size if sign < 0.0 else 0.0
                block = [along.real, along.imag, (turned * along.conjugate()).real]
                row[3 * ref.link : 3 * ref.link + 3] += sign * np.array(block)
        return row

    def _angle(self, ref: PointRef, poses: Real) -> float:
        return 0.0 if ref.link == GROUND else float(poses[ref.link, 2])

    def _along(self, joint: Joint, poses: Real) -> complex:
        """Direction of a sliding joint's line."""
        angle = self._angle(joint.first, poses) + (joint.axis.value if joint.axis else 0.0)
        return complex(np.cos(angle), np.sin(angle))

    def stresses(self, poses: Real) -> tuple[Real, int]:
        """An orthonormal basis of the self-stresses, (rows, k), and the number of ways to move."""
        rows = self.jacobian(poses)
        values = np.linalg.svd(rows, compute_uv=False)
        rank = int(np.sum(values > RANK * values.max(initial=0.0)))
        none: Real = np.zeros((len(rows), 0))
        return np.linalg.svd(rows)[0][:, rank:] if rank < len(rows) else none, self.count - rank

    def groups(self, stresses: Real) -> tuple[Group, ...]:
        """Joints that a self-stress connects, each group with the number of its own stresses."""
        joints = len(self.rows)
        shares = stresses @ stresses.T
        linked = np.array([[np.abs(shares[a, b]).max(initial=0.0) > _CARRIES for b in self.rows] for a in self.rows])
        left = [joint for joint in range(joints) if linked[joint, joint]]
        found = []
        while left:
            group, waiting = set(), [left[0]]
            while waiting:
                joint = waiting.pop()
                if joint not in group:
                    group.add(joint)
                    waiting += [other for other in left if linked[joint, other]]
            left = [joint for joint in left if joint not in group]
            surplus = total(float(np.trace(shares[self.rows[joint], self.rows[joint]])) for joint in group)
            found.append(Group(tuple(sorted(group)), round(surplus)))
        return tuple(found)

    def around(self, poses: Real) -> list[Real]:
        """Consistent configurations near ``poses``: random steps along the free motions, then back onto the joints."""
        random = np.random.default_rng(0)
        scale = np.tile([self.size, self.size, 1.0], len(poses))
        _, values, right = np.linalg.svd(self.jacobian(poses))
        free = right[int(np.sum(values > RANK * values.max(initial=0.0))) :]
        found = []
        for _ in range(_TRIES if len(free) else 0):
            away = random.normal(size=len(free)) @ free
            here = poses + (scale * away * _FAR / np.abs(away).max()).reshape(poses.shape)
            for _ in range(_STEPS):
                gap = self.residual(here)
                if np.abs(gap).max() < 1e-12:
                    found.append(here)
                    break
                step = np.linalg.lstsq(self.jacobian(here), gap, rcond=1e-6)[0]
                here = here - (scale * step).reshape(poses.shape)
        return found

"""Which branch a mechanism is assembled in: the way that each of its loops bends.

The joints of a loop, in order, are the corners of a polygon. Going round it, the way turns left or right at each
corner. Configurations that differ in a turn lie on different branches, or on two sides of a change point, where the two
sides of that corner are in line. Neighbouring joints in one place, as a pin on a slider's guide, are one corner.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Sequence
from dataclasses import dataclass

from .joints import PointRef
from .links import GROUND
from .loops import Loop, loops
from .mechanism import Mechanism

Triple = tuple[float, float, float]

STRAIGHT = 1e-6
"""Turns (rad) nearer to 0 or to a half turn than this have no direction."""
TOGETHER = 1e-9
"""Joints nearer to each other than this part of the loop's size are in one place: a side so short is rounding."""


@dataclass(frozen=True)
class Branch:
    """How a loop bends at each of its joints: ``turns`` in rad, from -π to π, positive to the left.

    Of joints in one place the first pin has the turn, or the first of all if all slide; the others have ``None``.
    ``crossed``: two of its sides that are not neighbours cross each other.
    """

    loop: Loop
    turns: tuple[float | None, ...]
    crossed: bool

    @property
    def signs(self) -> tuple[int, ...]:
        """+1 left, -1 right, 0 straight on or straight back or no turn, for each joint of the loop."""
        return tuple(_sign(turn) if turn is not None else 0 for turn in self.turns)

    def text(self, mechanism: Mechanism) -> str:
        """``motor - knee - elbow - pivot: crossed; left at motor, knee; right at elbow, pivot``, and the flattest."""
        names = [mechanism.joints[joint].name for joint in self.loop.joints]
        own = [(name, turn) for name, turn in zip(names, self.turns, strict=True) if turn is not None]
        said = ["crossed" if self.crossed else "open"]
        for sign, word in ((1, "left at"), (-1, "right at"), (0, "in line at")):
            there = [name for name, turn in own if _sign(turn) == sign]
            said += [f"{word} {', '.join(there) if len(there) < len(names) else 'every joint'}"] if there else []
        flat = [abs(math.asin(max(-1.0, min(1.0, math.sin(turn))))) for _, turn in own]
        least = min(range(len(flat)), key=lambda corner: round(flat[corner], 6))
        if _sign(own[least][1]):
            said.append(f"nearest to a straight line: {own[least][0]}, by {math.degrees(flat[least]):.3g} deg")
        return f"{' - '.join(names)}: {'; '.join(said)}"


def _sign(turn: float) -> int:
    return 0 if abs(math.sin(turn)) < STRAIGHT else 1 if turn > 0.0 else -1


def branches(
    mechanism: Mechanism, poses: Sequence[Triple], closing: Collection[int], implied: Collection[int] = ()
) -> tuple[Branch, ...]:
    """The branch of each loop that the joints ``closing`` close, at ``poses`` (x, y, angle of each link's frame);
    ``implied`` joints close none."""
    return tuple(_branch(mechanism, loop, poses) for loop in loops(mechanism, closing, implied))


def place(mechanism: Mechanism, poses: Sequence[Triple], ref: PointRef) -> complex:
    """Where the point ``ref`` is (m)."""
    local = complex(*mechanism.point(ref).values())
    if ref.link == GROUND:
        return local
    x, y, angle = poses[ref.link]
    return complex(x, y) + local * complex(math.cos(angle), math.sin(angle))


def _branch(mechanism: Mechanism, loop: Loop, poses: Sequence[Triple]) -> Branch:
    places = [place(mechanism, poses, mechanism.joints[joint].second) for joint in loop.joints]
    groups = _together(places)
    corners = [places[group[0]] for group in groups]
    sides = [after - here for here, after in zip(corners, [*corners[1:], corners[0]], strict=True)]
    turns: list[float | None] = [None] * len(places)
    for group, before, after in zip(groups, [sides[-1], *sides[:-1]], sides, strict=True):
        turned = after * before.conjugate()
        pins = [at for at in group if not mechanism.joints[loop.joints[at]].slides]
        turns[min(pins or group)] = math.atan2(turned.imag, turned.real)
    return Branch(loop, tuple(turns), _crosses(corners))


def _together(places: Sequence[complex]) -> list[list[int]]:
    """The places in order, those of neighbours (the last and the first are, too) that coincide in one group."""
    size = max(abs(one - places[0]) for one in places)
    groups: list[list[int]] = []
    for at, one in enumerate(places):
        if groups and abs(one - places[groups[-1][0]]) <= TOGETHER * size:
            groups[-1].append(at)
        else:
            groups.append([at])
    if len(groups) > 1 and abs(places[groups[-1][0]] - places[0]) <= TOGETHER * size:
        groups[0] = groups.pop() + groups[0]
    return groups


def _crosses(corners: Sequence[complex]) -> bool:
    """Whether two sides of the polygon that share no corner cross."""
    count = len(corners)
    ends = [(corners[k], corners[(k + 1) % count]) for k in range(count)]
    apart = ((i, k) for i in range(count) for k in range(i + 2, count) if (i, k) != (0, count - 1))
    return any(_cross(*ends[i], *ends[k]) for i, k in apart)


def _cross(a: complex, b: complex, c: complex, d: complex) -> bool:
    def side(p: complex, q: complex, r: complex) -> float:
        return ((q - p).conjugate() * (r - p)).imag

    return side(a, b, c) * side(a, b, d) < 0.0 and side(c, d, a) * side(c, d, b) < 0.0

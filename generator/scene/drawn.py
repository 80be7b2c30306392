"""A start that is drawn: where joints and links roughly are. What that says about the links' angles and place.

A link of which two or more points are known, drawn or held by the ground, gets the angle that fits them best in the
sense of least squares, and keeps its lengths. Once a link's angle and one point are known, its joints are known for its
neighbours. Other links follow when the loops are closed, from where points that are drawn on them come to their places.
"""

from __future__ import annotations

import cmath
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ..mechanism.joints import Joint, PointRef
from ..mechanism.layout import Layout
from ..mechanism.links import GROUND
from ..mechanism.mechanism import Mechanism
from ..mechanism.totals import total
from .errors import Report
from .schema import StartTable

_ONE_PLACE = 1e-9
"""Points drawn nearer to each other than this share of their distance in the link give no direction."""


@dataclass(frozen=True)
class Anchor:
    """The point ``point`` of link ``link`` is drawn at (x, y), in m; no name stands for the origin of its frame."""

    link: int
    point: str
    x: float
    y: float

    def where(self, mechanism: Mechanism) -> tuple[complex, complex]:
        """The point in the link's frame, and where it is drawn."""
        local = complex(*mechanism.point(PointRef(self.link, self.point)).values()) if self.point else 0j
        return local, complex(self.x, self.y)


Ends = tuple[PointRef, PointRef]
"""A pin's side on a link, and its other side."""


def pins(mechanism: Mechanism) -> list[Joint]:
    """Joints whose two points are in one place."""
    return [joint for joint in mechanism.joints if not joint.slides]


def anchors(table: StartTable, mechanism: Mechanism, report: Report) -> tuple[Anchor, ...] | None:
    """What ``joints`` and ``poses`` draw; ``None`` after faults."""
    fine = _check_names("joints", table.joints, [joint.name for joint in mechanism.joints], report)
    fine = _check_names("poses", table.poses, [link.name for link in mechanism.links], report) and fine
    fine = _check_forms(table, mechanism, report) and fine
    if not fine:
        return None
    found = [_pose(mechanism, name, xya) for name, xya in (table.poses or {}).items()]
    for joint in mechanism.joints:
        if table.joints and joint.name in table.joints:
            x, y = table.joints[joint.name]
            ends = (joint.second,) if joint.slides else (joint.first, joint.second)
            found += [Anchor(end.link, end.point, x, y) for end in ends if end.link != GROUND]
    return tuple(found)


def carried(
    mechanism: Mechanism, angles: Sequence[float], drawn: Sequence[Anchor], slides: Sequence[float | None]
) -> list[float | None]:
    """The lengths of the sliding joints, with those of carriages by where the bodies that they carry are drawn, turned
    by ``angles``; what the scene says of them itself stays."""
    sliding = [joint for joint in mechanism.joints if joint.slides]
    found = list(slides)
    for across, up in zip(mechanism.aids[::2], mechanism.aids[1::2], strict=True):
        names = [joint.name for joint in sliding]
        body = sliding[names.index(up)].second
        for anchor in drawn:
            if anchor.link == body.link:
                local, there = anchor.where(mechanism)
                place = there + cmath.exp(1j * angles[body.link]) * (_local(mechanism, body) - local)
                for name, length in ((across, place.real), (up, place.imag)):
                    k = names.index(name)
                    found[k] = length if found[k] is None else found[k]
                break
    return found


def spread(mechanism: Mechanism, given: Sequence[float | None], drawn: Sequence[Anchor]) -> list[float | None]:
    """The angle of every link, ``None`` of those about which angles ``given`` and points ``drawn`` say nothing."""
    angles = list(given)
    known: list[dict[complex, complex]] = [{} for _ in angles]
    for anchor in drawn:
        local, there = anchor.where(mechanism)
        known[anchor.link][local] = there
    for joint in pins(mechanism):
        for end, other in ((joint.first, joint.second), (joint.second, joint.first)):
            if other.link == GROUND and end.link != GROUND:
                known[end.link].setdefault(_local(mechanism, end), _local(mechanism, other))
    placed: set[int] = set()
    meets = _pins_of_links(mechanism)
    while True:
        for link, points in enumerate(known):
            angles[link] = _fit(points) if angles[link] is None else angles[link]
        ready = [k for k, points in enumerate(known) if k not in placed and points and angles[k] is not None]
        if not ready:
            return angles
        for link in ready:
            placed.add(link)
            turn = np.exp(1j * float(angles[link] or 0.0))
            origin = total(there - local * turn for local, there in known[link].items()) / len(known[link])
            _pass_on(mechanism, meets[link], origin, turn, known)


def drawn_lengths(
    mechanism: Mechanism, angles: Sequence[float], drawn: Sequence[Anchor], given: Sequence[float | None]
) -> list[float | None]:
    """Lengths along the lines of sliding joints whose two links are drawn (or the ground), those ``given`` first."""
    origins: dict[int, complex] = {GROUND: 0j}
    for anchor in drawn:
        local, there = anchor.where(mechanism)
        origins.setdefault(anchor.link, there - local * np.exp(1j * angles[anchor.link]))
    turns = {GROUND: 0.0} | dict(enumerate(angles))
    found: list[float | None] = []
    for joint, length in zip((joint for joint in mechanism.joints if joint.slides), given, strict=True):
        first, second = joint.first.link, joint.second.link
        if length is not None or first not in origins or second not in origins:
            found.append(length)
            continue
        ends = [
            origins[e.link] + _local(mechanism, e) * np.exp(1j * turns[e.link]) for e in (joint.first, joint.second)
        ]
        along = np.exp(1j * (turns[first] + (joint.axis.value if joint.axis else 0.0)))
        found.append(float(((ends[1] - ends[0]) * along.conjugate()).real))
    return found


def pinned_as_drawn(layout: Layout, mechanism: Mechanism, drawn: Sequence[Anchor], loose: Collection[int]) -> Layout:
    """The layout with the points ``drawn`` on links ``loose``, whose angles nothing says, pinned to where they are
    drawn; of what floats to where they are beside the first point that is drawn at all."""
    told = [anchor for anchor in drawn if anchor.link in loose]
    rows, bases, ends = [], [], []
    for anchor in (*drawn[:1], *told):
        local, there = anchor.where(mechanism)
        row = layout.arms[anchor.link].copy()
        row[anchor.link] += local
        rows.append(row)
        bases.append(layout.base[anchor.link] - there)
        ends.append(abs(local))
    away = (rows[0], bases[0]) if told and layout.floating else (0.0, 0.0)
    return replace(
        layout,
        gaps=(*layout.gaps, *(-1 for _ in told)),
        gap_base=np.append(layout.gap_base, np.array([base - away[1] for base in bases[1:]], dtype=complex)),
        gap_arms=np.vstack([layout.gap_arms, *(row - away[0] for row in rows[1:])]),
        ends=(*layout.ends, *ends[1:]),
    )


def offset(mechanism: Mechanism, poses: Sequence[Sequence[float]], drawn: Sequence[Anchor]) -> complex:
    """The translation of ``poses`` that brings the drawn points nearest to their places (m)."""
    moves = []
    for anchor in drawn:
        local, there = anchor.where(mechanism)
        x, y, angle = poses[anchor.link]
        moves.append(there - (complex(x, y) + local * np.exp(1j * angle)))
    return complex(np.mean(moves))


def _pass_on(
    mechanism: Mechanism, ends: Sequence[Ends], origin: complex, turn: complex, known: list[dict[complex, complex]]
) -> None:
    """Tell a placed link's neighbours where their common joints are, unless they are drawn."""
    for end, other in ends:
        if other.link != GROUND:
            there = origin + _local(mechanism, end) * turn
            known[other.link].setdefault(_local(mechanism, other), there)


def _pins_of_links(mechanism: Mechanism) -> list[list[Ends]]:
    """Per link its pins in scene order: its own side and the other one."""
    found: list[list[Ends]] = [[] for _ in mechanism.links]
    for joint in pins(mechanism):
        for end, other in ((joint.first, joint.second), (joint.second, joint.first)):
            if end.link != GROUND:
                found[end.link].append((end, other))
    return found


def _fit(points: Mapping[complex, complex]) -> float | None:
    """The rotation that fits points of a link to their places best (Procrustes); ``None`` where they do not say one."""
    local, there = np.array(list(points)), np.array(list(points.values()))
    if len(local) < 2:
        return None
    arms, drawn = local - local.mean(), there - there.mean()
    turn = np.vdot(arms, drawn)
    return float(np.angle(turn)) if abs(turn) > _ONE_PLACE * np.vdot(arms, arms).real else None


def _local(mechanism: Mechanism, ref: PointRef) -> complex:
    return complex(*mechanism.point(ref).values())


def _pose(mechanism: Mechanism, name: str, xya: Sequence[float]) -> Anchor:
    return Anchor([link.name for link in mechanism.links].index(name), "", xya[0], xya[1])


def _check_names(key: str, given: Mapping[str, object] | None, names: Sequence[str], report: Report) -> bool:
    """Every name in ``joints`` and ``poses`` is one of the mechanism's."""
    unknown = [name for name in given or () if name not in names]
    kind = "joint" if key == "joints" else "link"
    for name in unknown:
        expected = f"one of {', '.join(names)}" if names else f"none, because there is no {kind}"
        report.add(("start", key, name), f"found an unknown {kind}, expected {expected}; correct the name")
    return not unknown


def _check_forms(table: StartTable, mechanism: Mechanism, report: Report) -> bool:
    """Nothing is said twice: no angle beside a pose, neither beside two drawn joints, no place beside a drawing."""
    names = [link.name for link in mechanism.links]
    angles, poses, joints = table.angles, table.poses or {}, table.joints or {}
    angled = set(angles) if isinstance(angles, Mapping) else set(names if angles is not None else ())
    wrong: list[tuple[str, str, str]] = []
    jointed = _jointed(mechanism)
    for link, name in enumerate(names):
        said = [f"{word} of {name}" for word, there in (("an angle", angled), ("a pose", poses)) if name in there]
        drawn = [joint for joint in jointed[link] if joint in joints]
        if len(said) > 1:
            wrong.append(("poses", name, f"{' beside '.join(said)}, expected one of them"))
        elif said and len(drawn) > 1:
            wrong.append(("joints", drawn[0], f"{' and '.join(drawn)} beside {said[0]}, expected one of these"))
    for key, name, found in wrong:
        report.add(("start", key, name), f"found {found}, because each gives the link's angle; remove one")
    placed = [key for key in ("position", "tilt") if (joints or poses) and getattr(table, key)]
    for key in placed:
        report.add(
            ("start", key), f"found a {key} beside drawn joints or poses, expected none; remove it or the drawing"
        )
    return not wrong and not placed


def _jointed(mechanism: Mechanism) -> dict[int, list[str]]:
    """Per link one joint for each point that pins join to it."""
    ends: dict[int, dict[str, str]] = {link: {} for link in range(GROUND, len(mechanism.links))}
    for joint in pins(mechanism):
        for end in (joint.first, joint.second):
            ends[end.link][end.point] = joint.name
    return {link: list(names.values()) for link, names in ends.items()}

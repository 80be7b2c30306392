"""What is told of a start that cannot be: loops that do not close, drives, meshes and speeds that contradict them."""

from __future__ import annotations

from collections.abc import Collection, Sequence

import numpy as np

from ..effect_base.effect import Effect
from ..mechanism.assembly import CannotClose, Contradiction, Speed, alone, nearest
from ..mechanism.carriages import loose_parts
from ..mechanism.layout import Layout, Real
from ..mechanism.loops import loops
from ..mechanism.mechanism import Mechanism
from .bodies import Bodies
from .errors import Path, Report

RANK = 1e-9
"""Singular values of the closure's Jacobian (m) below this count as zero."""
_OPEN = 1e-6
"""Loops that are open by this share of the worst one take part in a contradiction."""


def closes(layout: Layout, wanted: Real) -> bool:
    """Whether the joints alone can be closed from the sketch."""
    try:
        nearest(layout, wanted)
    except CannotClose:
        return False
    return True


def report_drives(drives: Sequence[tuple[Path, Effect]], what: str, report: Report) -> None:
    """Drives that ask for what the mechanism cannot do."""
    names = ", ".join(effect.title for _, effect in drives)
    expected = "expected what the mechanism can do; change one of them or remove it"
    report.add(drives[-1][0], f"{what} (the drives are {names}), {expected}")


def report_stuck(
    layout: Layout,
    x: Real,
    prescribed: Sequence[Speed],
    drives: Sequence[tuple[Path, Effect]],
    mechanism: Mechanism,
    report: Report,
) -> bool:
    """Whether drives ask for more motions than the joints leave; then that is told, and how much they leave."""
    _, values, motions = np.linalg.svd(layout.jacobian(x))
    left = motions[int(np.sum(values > RANK)) :]
    if not prescribed or int(np.linalg.matrix_rank(moved := np.array([one.row for one in prescribed]) @ left.T)) == len(
        prescribed
    ):
        return False
    free = len(left) + 2 * layout.floating
    still = [mechanism.joints[one.joint].name for one, row in zip(prescribed, moved, strict=True) if _still(row)]
    found = f"found {', '.join(still)} driven, which the other joints hold still, expected a joint that can move"
    if not still:
        found = f"found {len(prescribed)} driven joints, expected no more than can be moved apart from each other"
    message = f"{found}; without drives the mechanism has {free} degree{'s' * (free != 1)} of freedom here"
    slots = [joint.name for joint in mechanism.joints if joint.kind == "pin-in-slot"]
    if slots:
        message += f"; the first point of {', '.join(slots)} has the slot: exchange points if it is in the other link"
    report.add(drives[-1][0], message)
    return True


def check_meshed(
    layout: Layout,
    x: Real,
    prescribed: Sequence[Speed],
    meshes: Sequence[Speed],
    mechanism: Mechanism,
    effects: Sequence[tuple[Path, Effect]],
    report: Report,
) -> bool:
    """Whether meshes let drives move their joints as they will: no mesh joins what two drives give."""
    rows = np.vstack([layout.jacobian(x), *(one.row for one in meshes)])
    _, values, motions = np.linalg.svd(rows)
    left = motions[int(np.sum(values > RANK)) :]
    moved = np.array([one.row for one in prescribed]).reshape(len(prescribed), len(x)) @ left.T
    if int(np.linalg.matrix_rank(moved, tol=RANK)) == len(prescribed):
        return True
    driven = ", ".join(mechanism.joints[one.joint].name for one in prescribed)
    path, effect = next((path, effect) for path, effect in effects if effect.mesh())
    free = len(left) + 2 * layout.floating
    report.add(
        path,
        f"found {driven} driven, whose motions {effect.title} joins, expected drives of joints that move apart from "
        f"each other; with what meshes the mechanism has {free} degree{'s' * (free != 1)} of freedom here; "
        "remove a drive",
    )
    return False


def _still(rates: Real) -> bool:
    return float(np.abs(rates).max(initial=0.0)) <= RANK


def report_rates(
    error: Contradiction,
    drives: Sequence[tuple[Path, Effect]],
    layout: Layout,
    mechanism: Mechanism,
    holds: Collection[str],
    report: Report,
) -> None:
    """Velocities that open a joint, or that miss a drive."""
    name, turning = mechanism.joints[error.joint].name, len(mechanism.links)
    if not error.links and drives:
        report_drives(drives, f"found speeds that open {name} at {error.speed:.3g} m/s or rad/s together", report)
        return
    names = ", ".join(_mover(mechanism, layout, index) for index in error.links)
    angular = all(index < turning for index in error.links)
    key, what = ("angular_velocities", "angular velocities") if angular else ("sliding_velocities", "velocities")
    opens = f"that open {name} at {error.speed:.3g} m/s, expected loops to stay closed"
    if any(error.joint in effect.driven() for _, effect in drives):
        opens = f"that miss the drive of {name} by {error.speed:.3g} rad/s or m/s, expected those it prescribes"
    advice = f"correct one of them or give fewer{_may_be_open(name, holds)}"
    report.add(("start", key), f"found {what} of {names} {opens}; {advice}")


def _may_be_open(joint: str, holds: Collection[str]) -> str:
    """How to begin without a joint that takes hold only later, where it is one."""
    return f'; write open = ["{joint}"] in [start] where {joint} is not to hold yet' if joint in holds else ""


def _mover(mechanism: Mechanism, layout: Layout, index: int) -> str:
    """The link, or the sliding joint, whose displacement has the number ``index``."""
    count = len(mechanism.links)
    if index < count:
        return mechanism.links[index].name
    return mechanism.joints[layout.lines[index - count].joint].name


def report_open(layout: Layout, error: CannotClose, wanted: Real, bodies: Bodies, driven: int, report: Report) -> None:
    """Name the loop that does not close; where each closes alone, all joints that contradict each other."""
    mechanism = bodies.mechanism
    rings = loops(mechanism, layout.gaps)
    misses = [alone(layout, wanted, gap) for gap in range(len(rings))]
    worst = int(np.argmax(misses)) if rings else 0
    if rings and misses[worst]:
        joint, miss, unit = layout.gaps[worst], misses[worst], "m"
        found = f"no way to close the loop {rings[worst].text(mechanism)}: the nearest configuration misses by"
    else:
        joint, miss, unit = error.joint, error.miss, error.unit
        gaps = layout.closure(error.best)[: 2 * len(rings)]
        open_ones = np.flatnonzero(np.hypot(gaps[0::2], gaps[1::2]) > _OPEN * miss)
        around = sorted({joint, *(k for ring in open_ones for k in rings[ring].joints)})
        names = ", ".join(mechanism.joints[joint].name for joint in around)
        found = f"joints that do not close together from this start ({names}): each loop closes alone, but together "
        found += "they miss by"
    report.add(
        bodies.at_joint(joint),
        f"found {found} {miss:.3g} {unit} at {mechanism.joints[joint].name}, expected 0; change lengths or points, or "
        f"give a [start] nearer to a closed configuration{_too_many(mechanism, driven)}",
    )


def _too_many(mechanism: Mechanism, driven: int) -> str:
    """That there are more joints than the links have freedoms, where that is so."""
    count = mechanism.freedoms(driven)
    if count >= 0:
        return ""
    return (
        f"; by Grübler's count the mechanism has {count} degrees of freedom: it has joints or drives that no lengths "
        "but special ones allow; remove one"
    )


def report_apart(layout: Layout, bodies: Bodies, report: Report) -> None:
    """Links that no chain of joints connects with the others, and how they may be."""
    links = bodies.mechanism.links
    missing = [min(group) for group in loose_parts(bodies.mechanism) if not group & bodies.free]
    if bodies.free and missing:
        for index in missing:
            message = (
                f"found no joints that hold {links[index].name}, and no free = true, which others have, expected one "
            )
            report.add(
                bodies.at_link(index), message + f"of these; add a [[joint]], or free = true to {links[index].name}"
            )
        return
    base = links[0].name if layout.floating else "the ground"
    for index in layout.apart:
        message = f"found no joints that connect {links[index].name} with {base}, expected one piece; add a [[joint]], "
        report.add(bodies.at_link(index), message + "or free = true to a [[link]] that moves freely beside the others")

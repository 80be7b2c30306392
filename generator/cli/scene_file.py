"""The scene file that a command is given."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import typer

from ..scene import Scene, SceneError
from ..scene.load import load_with_settings
from .detail import Detail
from .refusal import fail

if TYPE_CHECKING:
    from ..scene.scene import Moved

SEEN = 1e-9
"""Changes (rad, m) and drawn points farther off (m) than this are spoken of."""
LAST_DIGIT = 1e-3
"""Changes are written with three digits; one below the last of them of the largest is nothing beside that."""
CHANGES = 3
"""Changed angles, and changed lengths, that are named unless all are asked for: the largest."""
REMARKS = 8
"""Remarks on values that are told unless all are asked for."""


def read(path: Path, settings: Mapping[str, float] | None = None) -> Scene:
    """The scene in ``path``, names of its ``[let]`` having the values that ``settings`` give them; or all its faults on
    standard error and exit code 2."""
    try:
        return load_with_settings(path, settings or {})
    except SceneError as error:
        fail(str(error))


def tell_assembly(scene: Scene, detail: Detail = Detail.USUAL) -> None:
    """Say on standard error, in one line, how the start was assembled, if its loops had to be closed or a drawing was
    not exact; in full detail which branch each loop is on too. Remarks on values come first."""
    _tell_remarks(scene, detail)
    tell_closing(scene, detail)


def tell_closing(scene: Scene, detail: Detail, when: str = "") -> None:
    """The same without remarks on values; ``when`` says with which values."""
    start, everything = scene.start, detail is Detail.ALL
    changed = _noticeable(start.turned), _noticeable(start.slid)
    named = None if everything else CHANGES
    changes = [
        _changes_text(what, found, unit, named)
        for what, found, unit in zip(("angles", "lengths"), changed, ("rad", "m"), strict=True)
    ]
    missed = f"drawn points lie up to {start.missed_by:.3g} m off" if start.missed_by > SEEN else ""
    if detail is Detail.NOTHING or not (any(changes) or missed or everything):
        return
    from ..documents.assembled import branch_lines
    from ..mechanism.topology import span
    from ..stages import plan_scene

    lines = branch_lines(scene, plan_scene(scene)[0] if everything else span(scene.mechanism, scene.driven))
    closed = f"{len(lines)} loop{'s' * (len(lines) != 1)} closed" if lines else "joints fitted"
    told = ", ".join(filter(None, [closed if any(changes) else "", *changes, missed]))
    more = ["the others"] if any(len(found) > CHANGES for found in changed) else []
    more += ["its branch" if len(lines) == 1 else "their branches"] if lines else []
    if told:
        tell(scene, when + told + (f"; -v for {' and '.join(more)}" if more and not everything else ""))
    for one in start.moved:
        tell(scene, _moved_text(one))
    for line in lines if everything else ():
        tell(scene, f"branch {line}")


def _noticeable(changes: Sequence[tuple[str, float]]) -> list[tuple[str, float]]:
    """Those that are seen, and are not nothing beside the largest."""
    return [one for one in changes if one[1] > max(SEEN, LAST_DIGIT * changes[0][1])]


def _changes_text(what: str, changes: Sequence[tuple[str, float]], unit: str, named: int | None) -> str:
    """``angles changed by 0.219 rad (coupler), 0.0741 (rocker)``, the ``named`` first ones; empty where there is
    none."""
    if not changes:
        return ""
    (name, change), *others = changes[:named]
    told = [f"{what} changed by {change:.3g} {unit} ({name})", *(f"{by:.3g} ({of})" for of, by in others)]
    left = len(changes) - len(told)
    return ", ".join(told) + (f" and {left} more" if left else "")


def _moved_text(moved: Moved) -> str:
    """What a driven joint was given at the start, what it got, and why."""
    angle = moved.key == "angles"
    given, got = (math.degrees(x) if angle else x for x in (moved.given, moved.got))
    why = f"where its drive has {moved.joint} at t = 0" if moved.placed else "the nearest at which its loops close"
    unit = "deg" if angle else "m"
    return f"{moved.of} starts at {got:.6g} {unit}, {why}; [start] {moved.key} gives {given:.6g} {unit}"


def _tell_remarks(scene: Scene, detail: Detail) -> None:
    """Say how values are understood that may be meant otherwise; of many some, unless in full detail. They are
    warnings, which --quiet leaves: who meant degrees has other results than asked for.
    """
    shown = scene.remarks if detail is Detail.ALL else scene.remarks[:REMARKS]
    for remark in shown:
        typer.echo(remark, err=True)
    if len(shown) < len(scene.remarks):
        tell(scene, f"and {len(scene.remarks) - len(shown)} more values like these; -v for all")


def tell_mobility(scene: Scene, detail: Detail = Detail.USUAL) -> bool:
    """Say on standard error which joints are redundant, all of many in full detail only, and whether anything can
    move; whether any are redundant, which is not looked for where nothing is to be said."""
    if detail is Detail.NOTHING:
        return False
    from ..documents.assembled import implied_lines, mobility_of, redundancy_lines

    found = mobility_of(scene)
    for line in redundancy_lines(scene, found, every=detail is Detail.ALL):
        tell(scene, line)
    return bool((found and found.groups) or implied_lines(scene))


def tell(scene: Scene, line: str) -> None:
    """A remark on the scene, on standard error."""
    typer.echo(f"{scene.name}: {line}", err=True)

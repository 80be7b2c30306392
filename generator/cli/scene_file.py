"""The scene file that a command is given."""

from __future__ import annotations

from pathlib import Path

import typer

from ..scene import Scene, SceneError, load_scene
from .refusal import fail

SEEN = 1e-9
"""Changes (rad, m) and drawn points farther off (m) than this are spoken of."""
SHOWN = 8
"""Loops whose branch is told; `ccgen show` has all."""


def read(path: Path) -> Scene:
    """The scene in ``path``, or all its faults on standard error and exit code 2."""
    try:
        return load_scene(path)
    except SceneError as error:
        fail(str(error))


def tell_assembly(scene: Scene) -> None:
    """Say on standard error how the start was assembled, if its loops had to be closed or a drawing was not exact."""
    start = scene.start
    loops = len(scene.mechanism.joints) > len(scene.mechanism.links) - all(
        not j.on_ground for j in scene.mechanism.joints
    )
    what = "loops closed" if loops else "joints fitted"
    told = [
        f"angles changed by up to {start.assembled_by:.3g} rad ({start.most})" if start.assembled_by > SEEN else "",
        f"lengths changed by up to {start.slid_by:.3g} m ({start.farthest})" if start.slid_by > SEEN else "",
    ]
    told = [what, *filter(None, told)] if any(told) else []
    told += [f"drawn points lie up to {start.missed_by:.3g} m off"] if start.missed_by > SEEN else []
    if not told:
        return
    from ..emit.assembled import branch_lines

    typer.echo(f"{scene.name}: {', '.join(told)}", err=True)
    lines = branch_lines(scene)
    for line in lines[:SHOWN]:
        typer.echo(f"{scene.name}: branch {line}", err=True)
    if len(lines) > SHOWN:
        typer.echo(f"{scene.name}: and {len(lines) - SHOWN} more; ccgen show has all", err=True)


def tell_mobility(scene: Scene) -> None:
    """Say on standard error which joints are redundant, and whether anything can move."""
    from ..emit.assembled import mobility_of, redundancy_lines

    for line in redundancy_lines(scene, mobility_of(scene)):
        typer.echo(f"{scene.name}: {line}", err=True)

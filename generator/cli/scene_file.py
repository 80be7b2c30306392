"""The scene file that a command is given."""

from __future__ import annotations

from pathlib import Path

import typer

from ..scene import Scene, SceneError, load_scene
from .refusal import fail

SEEN = 1e-9
"""Drawn points that lie farther off (m) are spoken of."""
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
    turned = f"{what}, angles changed by up to {start.assembled_by:.3g} rad ({start.most})" if start.most else ""
    drawn = f"drawn points lie up to {start.missed_by:.3g} m off" if start.missed_by > SEEN else ""
    if not turned and not drawn:
        return
    from ..emit.assembled import branch_lines

    typer.echo(f"{scene.name}: {', '.join(part for part in (turned, drawn) if part)}", err=True)
    for line in branch_lines(scene)[:SHOWN]:
        typer.echo(f"{scene.name}: branch {line}", err=True)


def tell_mobility(scene: Scene) -> None:
    """Say on standard error which joints are redundant, and whether anything can move."""
    from ..emit.assembled import mobility_of, redundancy_lines

    for line in redundancy_lines(scene, mobility_of(scene)):
        typer.echo(f"{scene.name}: {line}", err=True)

"""The scene file that a command is given."""

from __future__ import annotations

from pathlib import Path

import typer

from ..scene import Scene, SceneError, load_scene
from .refusal import fail


def read(path: Path) -> Scene:
    """The scene in ``path``, or all its faults on standard error and exit code 2."""
    try:
        return load_scene(path)
    except SceneError as error:
        fail(str(error))


def tell_assembly(scene: Scene) -> None:
    """Say on standard error when the start's loops had to be closed."""
    if scene.start.assembled_by:
        typer.echo(f"{scene.name}: loops closed, angles changed by up to {scene.start.assembled_by:.3g} rad", err=True)

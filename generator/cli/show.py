"""``ccgen show SCENE``: the equations for a person to read."""

from __future__ import annotations

from pathlib import Path

import typer

from .progress import progress
from .refusal import refusing
from .scene_file import read, tell_assembly


def show(scene_file: Path, latex: bool, expand: bool) -> None:
    """Print the equations of the scene, as text or LaTeX, as derived or expanded."""
    scene = read(scene_file)
    tell_assembly(scene)
    from ..emit.show import show_text

    with refusing(ValueError), progress() as tell:  # too many links to expand
        tell.stage("derive")
        text = show_text(scene, latex, expand)
    typer.echo(text)

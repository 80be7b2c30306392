"""``ccgen show SCENE``: the equations for a person to read."""

from __future__ import annotations

from pathlib import Path

import typer

from .progress import progress
from .refusal import refusing
from .scene_file import read, tell_assembly


def show(scene_file: Path, latex: bool, expand: bool, fold: bool) -> None:
    """Print the equations of the scene, as text or LaTeX, as derived, expanded or folded."""
    scene = read(scene_file)
    tell_assembly(scene)
    from ..emit.show import show_text

    with refusing(ValueError), progress() as tell:  # too many links to expand, values that fold to no finite number
        tell.stage("derive")
        text = show_text(scene, latex, expand, fold)
    typer.echo(text)

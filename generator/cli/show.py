"""``ccgen show SCENE``: the equations for a person to read."""

from __future__ import annotations

from pathlib import Path

import typer

from .common import progress, read, tell_assembly, trouble


def show(scene_file: Path, latex: bool, expand: bool) -> None:
    """Print the equations of the scene, as text or LaTeX, as derived or expanded."""
    scene = read(scene_file)
    tell_assembly(scene)
    from ..emit.show import show_text

    with trouble(), progress() as say:
        say("derive")
        text = show_text(scene, latex, expand)
    typer.echo(text)

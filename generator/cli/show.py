"""``ccgen show SCENE``: what a scene is, and its equations for a person to read."""

from __future__ import annotations

from pathlib import Path

import typer

from .detail import Detail
from .progress import progress
from .refusal import fail, refusing
from .scene_file import read, tell_assembly


def show(
    scene_file: Path,
    equations: bool,
    latex: bool,
    expand: bool,
    fold: bool,
    plan: str | None = None,
    detail: Detail = Detail.USUAL,
    tolerances: bool = False,
) -> None:
    """Print the scene's summary, and its equations if asked for: as text or LaTeX, as derived, expanded or folded.

    Or instead the thresholds of a run, which need the compiled model.
    """
    scene = read(scene_file)
    if tolerances:
        from ccgen.runtime.model.thresholds import thresholds_text

        from .compiled import compiled

        if equations or latex or expand or fold or plan:
            fail("--tolerances: found beside an option for equations, expected it alone; leave out the other")
        typer.echo(thresholds_text(compiled(scene, detail)))
        return
    tell_assembly(scene, detail)
    from ..documents.show import show_text

    with (
        refusing(ValueError),
        progress(detail) as tell,
    ):  # too many links to expand, values that fold to no finite number, no such plan
        tell.stage("derive")
        text = show_text(scene, latex, expand, fold, equations=equations, plan=plan)
    typer.echo(text)

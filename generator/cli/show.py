"""``ccgen show SCENE``: what a scene is, and its equations for a person to read."""

from __future__ import annotations

from pathlib import Path

import typer

from ..scene import Scene
from .detail import Detail
from .folders import MODELS, check_folder
from .progress import progress
from .refusal import Faults, refusing, refusing_options
from .scene_file import read, tell_assembly


def show(
    scene_file: Path,
    equations: bool,
    latex: bool,
    expand: bool,
    fold: bool,
    plan: str | None,
    detail: Detail,
    tolerances: bool,
    faults: Faults,
) -> None:
    """Print the scene's summary, and its equations if asked for: as text or LaTeX, as derived, expanded or folded.

    Or instead the thresholds of a run, which need the compiled model.
    """
    given = {"--equations": equations, "--latex": latex, "--expand": expand, "--fold": fold, "--plan": plan is not None}
    for option in given if tolerances else ():
        if given[option]:
            faults.add(f"{option}: found beside --tolerances, which needs none, expected one of them; leave one out")
    faults.of(_check_plan, plan)
    scene = faults.of(read, scene_file)
    if scene and plan and not tolerances:
        faults.of(_check_plan, plan, scene, fold)
    if tolerances:
        faults.of(check_folder, MODELS, "folder of models")
    faults.stop_if_any()
    assert scene
    if tolerances:
        from ccgen.runtime.model.thresholds import thresholds_text

        from .compiled import compiled

        typer.echo(thresholds_text(compiled(scene, detail)))
        return
    tell_assembly(scene, detail)
    from ..documents.show import show_text

    with (
        refusing(ValueError),
        progress(detail) as tell,
    ):  # too many links to expand, values that fold to no finite number
        tell.stage("derive")
        text = show_text(scene, latex, expand, fold, equations=equations, plan=plan)
    typer.echo(text)


def _check_plan(plan: str | None, scene: Scene | None = None, fold: bool = False) -> None:
    """Stop with exit code 2 unless there is such a plan, and the ``scene``, where it is known, has one of its kind."""
    from ..stages import check_plan, plan_scene

    with refusing_options():
        check_plan(plan)
        if scene:
            plan_scene(scene, plan, fold=fold)

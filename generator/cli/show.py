"""``ccgen show SCENE``: what a scene is, and its equations for a person to read."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

import typer

from ..scene import Scene
from .compiled import compiled
from .detail import Detail
from .folders import MODELS, check_folder
from .progress import progress
from .refusal import Faults, refusing, refusing_options
from .scene_file import tell_assembly
from .settings import read_set, scene_with, with_settings


def show(
    scene_file: Path,
    equations: bool,
    latex: bool,
    expand: bool,
    fold: bool,
    plan: str | None,
    detail: Detail,
    instead: Sequence[str],
    settings: Mapping[str, float],
    faults: Faults,
) -> None:
    """Print the scene's summary, and its equations if asked for: as text or LaTeX, as derived, expanded or folded.

    Or ``instead`` the thresholds of a run, or names of outputs, which need the compiled model. With ``settings`` the
    summary and the thresholds are those for other values of parameters; equations have symbols for them.
    """
    given = {"--equations": equations, "--latex": latex, "--expand": expand, "--fold": fold, "--plan": plan is not None}
    beside = [*(option for option in given if given[option]), *instead[1:]] if instead else []
    for option in beside:
        faults.add(f"{option}: found beside {instead[0]}, which needs none, expected one of them; leave one out")
    for option in (option for option in given if settings and given[option] and option != "--plan"):
        faults.add(f"--set: found beside {option}, expected without: equations have symbols for values; leave one out")
    faults.of(_check_plan, plan)
    scene = read_set(scene_file, settings, faults)
    if scene and plan and not instead:
        faults.of(_check_plan, plan, scene, fold)
    if instead or settings:
        faults.of(check_folder, MODELS, "folder of models")
    faults.stop_if_any()
    assert scene
    if instead:
        from ccgen.runtime.model.thresholds import thresholds_text
        from ccgen.runtime.record.outputs import outputs_text

        told = {"--tolerances": thresholds_text, "--outputs": outputs_text}[instead[0]]
        typer.echo(told(with_settings(compiled(scene, detail), settings, scene, detail)))
        return
    changed = _with_values(scene, settings, detail) if settings else None
    if changed is None:
        tell_assembly(scene, detail)
    from ..documents.show import show_text

    with (
        refusing(ValueError),
        progress(detail) as tell,
    ):  # too many links to expand, values that fold to no finite number
        tell.stage("derive")
        text = show_text(scene, latex, expand, fold, equations=equations, plan=plan, changed=changed)
    typer.echo(text)


def _with_values(scene: Scene, settings: Mapping[str, float], detail: Detail) -> Scene:
    """The scene with other values, its start assembled anew with them."""
    with_settings(compiled(scene, detail), settings, scene, detail)
    return scene_with(settings, scene)


def _check_plan(plan: str | None, scene: Scene | None = None, fold: bool = False) -> None:
    """Stop with exit code 2 unless there is such a plan, and the ``scene``, where it is known, has one of its kind."""
    from ..stages import check_plan, plan_scene

    with refusing_options():
        check_plan(plan)
        if scene:
            plan_scene(scene, plan, fold=fold)

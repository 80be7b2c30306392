"""What the commands share: refusing with a sentence, folders, progress."""

from __future__ import annotations

import os
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import NoReturn

import typer

from ..emit.cache import OutputError
from ..emit.compiler import CompileError
from ..scene import Scene, SceneError, load_scene

STAGES = {
    "derive": "deriving the equations",
    "write": "writing the sources",
    "compile": "compiling",
    "simulate": "simulating",
    "compare": "comparing",
    "draw": "drawing",
}


def fail(message: str, code: int = 2) -> NoReturn:
    """Say ``message`` on standard error and stop with ``code``."""
    typer.echo(message, err=True)
    raise typer.Exit(code)


def read(path: Path) -> Scene:
    """The scene in ``path``, or all its faults on standard error and exit code 2."""
    try:
        return load_scene(path)
    except SceneError as error:
        fail(str(error))


@contextmanager
def trouble() -> Iterator[None]:
    """What cannot be done is said in a sentence, with exit code 2: no compiler, a folder that vanished, bad numbers."""
    try:
        yield
    except (SceneError, CompileError, OutputError, OSError, ValueError) as error:
        fail(f"ccgen: {error}")


def check_folder(folder: Path, option: str) -> None:
    """Stop with exit code 2 unless ``folder`` exists or can be made, and can be written to."""
    nearest = folder.absolute()
    while not os.path.lexists(nearest):
        nearest = nearest.parent
    if not nearest.is_dir():
        fail(f"{option} {folder}: found a file {nearest}, expected a folder; name another")
    if not os.access(nearest, os.W_OK | os.X_OK):
        fail(
            f"{option} {folder}: found no permission to write in {nearest}, expected a folder to write in; name another"
        )


def tell_assembly(scene: Scene) -> None:
    """Say on standard error when the start's loops had to be closed."""
    if scene.start.assembled_by:
        typer.echo(f"{scene.name}: loops closed, angles changed by up to {scene.start.assembled_by:.3g} rad", err=True)


@contextmanager
def progress() -> Iterator[Callable[[str], None]]:
    """A function to call with the name of each stage; it shows something on a terminal and nothing in a pipe."""
    if not sys.stderr.isatty():
        yield lambda stage: None
        return
    from rich.console import Console

    with Console(stderr=True).status("") as status:
        yield lambda stage: status.update(STAGES.get(stage, stage))

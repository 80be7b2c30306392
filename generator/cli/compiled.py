"""The compiled model of a command's scene."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ..compile.compiler import CompileError
from ..package.replace import OutputError
from ..pipeline import generate
from ..scene import Scene
from .detail import Detail
from .folders import DERIVED, MODELS
from .progress import progress
from .refusal import refusing
from .scene_file import tell_assembly

if TYPE_CHECKING:
    from ccgen.runtime import Model


def compiled(scene: Scene, detail: Detail, *, derivatives: bool = False) -> Model:
    """The compiled model of a scene, in the folder of models, which the caller has looked at, with its derivatives
    where asked; exit code 2 and a sentence where there is none."""
    tell_assembly(scene, detail)
    from ccgen.runtime import load_model

    with progress(detail) as tell, refusing(CompileError, OutputError):
        folder = DERIVED if derivatives else MODELS
        return load_model(generate(scene, folder, tell.stage, derivatives=derivatives))

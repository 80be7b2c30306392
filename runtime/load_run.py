"""Runs from the files that ``Run.save`` and ``ccgen run`` write."""

from __future__ import annotations

import io
import os
import re
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from .files import read_path
from .loading.load import reopen
from .model.model import Model
from .record.event import Event
from .record.hybrid_state import UNREADABLE, ZIPPED, HybridState
from .record.impact import Impact
from .record.joint_change import JointChange
from .record.phase import Phase
from .record.plain import TEXT, VERSION, VERSION_KEY, Reader, kind_of
from .run import Run
from .simulation import forces_along, pieces, stretches
from .simulation.advance import Advance, Latched
from .simulation.arguments import Settings

NAME = re.compile(r"\w+")
"""Names of packages."""

KINDS: Mapping[str, type] = {
    kind_of(kind): kind
    for kind in (
        Run,
        Event,
        HybridState,
        Impact,
        JointChange,
        Phase,
        Advance,
        Latched,
        Settings,
        forces_along.Along,
        pieces.Piece,
        stretches.Along,
        stretches.Between,
        stretches.StretchedRun,
    )
}
"""All kinds of records that a run is made of."""


def load_run(path: str | os.PathLike[str], model: Model) -> Run:
    """The run in an .npz file that :meth:`Run.save` or ``ccgen run`` wrote, with the ``model`` that it is of.

    It answers as before, ``at``, ``values``, ``reactions`` and ``state`` included, by the same bits where its inputs
    were no function: states and forces between the rows are lost with that. Values of parameters are the file's.

    Raises ``FileNotFoundError`` where there is no such file, ``ValueError`` for one that holds no run, one of another
    model, or one that another version of ccgen wrote otherwise, and ``ImportError`` where the model has become another
    since.
    """
    if not isinstance(model, Model):
        raise TypeError(f"model: found {type(model).__name__}, expected a Model; load one with load_model(folder)")
    arrays = _arrays_in(path)
    if (name := str(arrays["model"])) != model.name:
        raise ValueError(f"{path}: found a run of {name}, expected one of {model.name}; load the model of that name")
    find = _finder(model)
    try:
        run = Reader(find, KINDS, arrays).record()
    except ImportError:
        raise
    except UNREADABLE as error:
        raise ValueError(_none(path)) from error
    if not isinstance(run, Run):
        raise ValueError(_none(path))
    return run


def package_of(path: str | os.PathLike[str]) -> str:
    """The name of the generated package of the model that the run in a file is of. Raises as :func:`load_run`."""
    return str(_arrays_in(path)["package"])


def _none(path: object) -> str:
    return f"path: {path}: found no run, expected a file as ccgen run (result.npz) and Run.save write it"


def _arrays_in(path: str | os.PathLike[str]) -> dict[str, Any]:
    """All arrays of the file of a run."""
    source = read_path(path, "an .npz file")
    if not source.is_file():
        found = "a folder" if source.is_dir() else "no such file"
        raise FileNotFoundError(f"{path}: found {found}, expected the .npz file of a run; correct the path")
    content = source.read_bytes()
    try:
        if not content.startswith(ZIPPED):  # NumPy would take it for a pickle, and advise to load that
            raise ValueError(_none(path))
        with np.load(io.BytesIO(content), allow_pickle=False) as file:
            arrays = {name: file[name] for name in file.files}
        if str(arrays["format"]) != "ccgen run" or "model" not in arrays:
            raise ValueError(_none(path))
    except UNREADABLE as error:
        raise ValueError(_none(path)) from error
    if not {TEXT, "package"} <= arrays.keys():
        raise ValueError(f"{path}: found the rows of a run alone, expected all of it; simulate it again")
    if (version := str(arrays.get(VERSION_KEY, 1))) != str(VERSION):
        raise ValueError(
            f"{path}: found a run as another ccgen records it, {VERSION_KEY} {version}, expected {VERSION}; simulate "
            "it again. Its rows can be read with numpy.load"
        )
    return arrays


def _finder(model: Model) -> Callable[[Any], Any]:
    """Finds models in the package of one.

    Raises ``ValueError`` for a model that is in no package.
    """
    folder = model.folder
    if folder is None:
        raise ValueError(f"{model.name}: found a model without a package, expected one; load it from a folder")

    def find(said: Any) -> Any:
        if not NAME.fullmatch(said["package"]):  # compiled code is loaded from there: from nowhere else than beside
            raise ValueError(f"{said['package']!r} is no name of a package")
        own = folder if said["name"] == model.name else folder.parent / said["package"]
        return reopen(own, said["name"], said["hash"], said["values"], said.get("begin"))

    return find

"""Models from generated packages."""

from __future__ import annotations

import copyreg
import time
from collections.abc import Mapping
from importlib.machinery import ExtensionFileLoader
from importlib.util import module_from_spec, spec_from_file_location
from os import PathLike
from pathlib import Path
from typing import Any

from ..files import read_path
from ..model.model import Model
from ..model.start import Begin
from .package import read_package

PATIENCE = 10.0
"""Seconds for which a package that others replace meanwhile is read anew; a replacement takes milliseconds, others may
follow."""

_loaded: dict[tuple[Path, str], tuple[object, Mapping[str, Any]]] = {}
"""Descriptor and data of every package that this process has loaded, by folder and seal."""


def load_model(path: str | PathLike[str]) -> Model:
    """The model in the generated package at ``path``, as :func:`ccgen.generator.generate` returns it.

    Raises ``FileNotFoundError`` when there is no generated package, and ``ImportError`` when it is damaged or does not
    fit this Python, this runtime or this processor; nothing of it is loaded then.
    """
    folder = read_path(path, "the folder of a generated package").resolve()
    patience = time.monotonic() + PATIENCE
    while True:
        found = _version(folder)
        try:
            return _load(folder)
        except (FileNotFoundError, ImportError):
            replaced = _version(folder) != found or (found is None and any(folder.parent.glob(".ccgen-*")))
            if not replaced or time.monotonic() > patience:
                raise


def reopen(folder: Path, name: str, hash_: str, values: Mapping[str, float], begin: Begin | None = None) -> Model:
    """The model ``name`` with parameter ``values`` from the package in ``folder``, as a copy of it was taken, with a
    start of its own where it had one.

    Raises ``FileNotFoundError`` when the package is gone, and ``ImportError`` when another is there now.
    """
    try:
        model = load_model(folder)
    except FileNotFoundError:
        raise FileNotFoundError(f"{folder}: found no model, expected {name}; generate it there again") from None
    if model.data["hash"] != hash_:
        other = "of the same name, made of another scene or after a change," if model.name == name else f"{model.name},"
        raise ImportError(
            f"{folder}: found another model, {other} expected {name} as it was; generate that one there again, or into "
            "a folder of its own and load it from there"
        )
    if begin is not None:
        poses, velocities, *own = begin
        known = dict(zip(model.parameters, own[0], strict=True)) if own else dict(values)
        model = _with(model, known).with_start(poses, velocities)
    return _with(model, values)


def _with(model: Model, values: Mapping[str, float]) -> Model:
    """The model with those of the values that are no numbers in its code."""
    return model.with_parameters({path: value for path, value in values.items() if path in model.settable})


def _address(model: Model) -> tuple[Any, ...]:
    """What a pickle holds of a model: the folder of its package, its parameters, and a start that is not the scene's;
    who reads it loads the model there.

    Raises ``TypeError`` for a model that is in no package.
    """
    if model.folder is None:
        raise TypeError(f"{model.name}: found a model without a package, which cannot be pickled; load it from one")
    return reopen, (model.folder, model.name, model.data["hash"], dict(model.parameters), model._begin)


copyreg.pickle(Model, _address)


def _load(folder: Path) -> Model:
    package = read_package(folder)
    key = folder, package.seal
    if key not in _loaded:
        name = f"_ccgen_models.{package.extension.name.partition('.')[0]}"
        loader = ExtensionFileLoader(name, str(package.extension))
        spec = spec_from_file_location(name, package.extension, loader=loader)
        assert spec
        module = module_from_spec(spec)
        loader.exec_module(module)
        _loaded[key] = module.descriptor, package.data
    return Model(*_loaded[key], folder=folder)


def _version(folder: Path) -> tuple[int, int] | None:
    """What tells a folder from those that were in its place before."""
    try:
        found = folder.stat()
    except OSError:
        return None
    return found.st_ino, found.st_ctime_ns

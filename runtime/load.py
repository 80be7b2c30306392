"""Models from generated packages."""

from __future__ import annotations

import importlib.util
import json
import sys
from os import PathLike
from pathlib import Path

from .model import Model


def load_model(path: str | PathLike[str]) -> Model:
    """The model in the generated package at ``path``, as :func:`ccgen.generator.generate` returns it.

    Raises ``FileNotFoundError`` when there is no generated package, and ``ImportError`` when it does not fit this
    runtime.
    """
    folder = Path(path).resolve()
    init = folder / "__init__.py"
    if not init.is_file() or not (folder / "model.json").is_file():
        raise FileNotFoundError(f"{folder} is not a generated model; make one with: ccgen --scene FILE")
    name = f"_ccgen_models.{folder.name}_{abs(hash((str(folder), init.stat().st_mtime_ns))):x}"
    if name not in sys.modules:
        spec = importlib.util.spec_from_file_location(name, init, submodule_search_locations=[str(folder)])
        assert spec and spec.loader
        module = importlib.util.module_from_spec(spec)
        sys.modules[name] = module
        try:
            spec.loader.exec_module(module)
        except BaseException:
            del sys.modules[name]
            raise
    module = sys.modules[name]
    return Model(module.descriptor, module.model.data)


def open_model(descriptor: object, folder: Path) -> Model:
    """The model of a generated package, from its descriptor capsule and its data."""
    return Model(descriptor, json.loads((folder / "model.json").read_text()))
